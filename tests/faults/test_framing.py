# SPDX-License-Identifier: MIT
"""Sends the raw requests of framing.cases and looks at every byte that comes back: how many
answers, which, and whether the connection was closed."""
import json
import os
import re
import socket
import sys
import time

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from daemon import Daemon, Tap, expect, expect_problem, expect_sound_log, saddle  # noqa: E402

CASES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "framing.cases")
PREFIXES = {
    "@GET ": b"GET /version HTTP/1.1\r\nHost: localhost\r\n",
    "@POST ": b"POST /v1/drapes HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n",
}
GOOD = b"GET /version HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n"
SECONDS = 20  # an answer, on a busy machine


def unescape(text):
    """Python's escapes, and {TEXT*N} for repetition."""
    def repeat(match):
        return match.group(1) * int(match.group(2))
    return re.sub(r"\{([^{}]*)\*(\d+)\}", repeat, text).encode().decode("unicode_escape").encode(
        "latin-1")


def read_cases():
    with open(CASES) as file:
        for line in file:
            line = line.rstrip("\n")
            if not line or line.startswith("#"):
                continue
            name, wanted, raw = (part.strip() for part in line.split(" | ", 2))
            head = b""
            for mark, prefix in PREFIXES.items():
                if raw.startswith(mark):
                    head, raw = prefix, raw[len(mark):]
            yield name, wanted.split(), [head + unescape(part) if k == 0 else unescape(part)
                                         for k, part in enumerate(raw.split("<pause>"))]


def receive_all(connection):
    """What comes until the other side closes; whether it did within the time."""
    data = b""
    connection.settimeout(SECONDS)
    try:
        while piece := connection.recv(65536):
            data += piece
        return data, True
    except TimeoutError:
        return data, False
    except ConnectionResetError:
        return data, True


def dechunk(data):
    body = b""
    while True:
        size, _, data = data.partition(b"\r\n")
        length = int(size, 16)
        if length == 0:
            return body, data.partition(b"\r\n")[2]
        body, data = body + data[:length], data[length + 2:]


def split_answers(data, methods):
    """A list of (status, headers, body); whatever is no answer fails."""
    answers = []
    while data:
        head, mark, rest = data.partition(b"\r\n\r\n")
        expect(mark and head.startswith(b"HTTP/1."), f"no answer: {data[:100]!r}")
        lines = head.decode("latin-1").split("\r\n")
        status = int(lines[0].split()[1])
        headers = {n.lower(): v.strip() for n, v in (line.split(":", 1) for line in lines[1:])}
        if status == 100 or (methods and methods[min(len(answers), len(methods) - 1)] == b"HEAD"):
            body, data = b"", rest
        elif headers.get("transfer-encoding") == "chunked":
            body, data = dechunk(rest)
        else:
            length = int(headers.get("content-length", 0))
            body, data = rest[:length], rest[length:]
        if status != 100:
            answers.append((status, headers, body))
    return answers


def send(connection, pieces):
    try:
        for k, piece in enumerate(pieces):
            if k:
                time.sleep(0.05)  # so that it arrives in a packet of its own
            connection.sendall(piece)
    except (BrokenPipeError, ConnectionResetError):
        pass  # refused before it was all sent


def exchange(port, pieces, methods):
    with socket.create_connection(("127.0.0.1", port), SECONDS) as connection:
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        send(connection, pieces)
        data, closed = receive_all(connection)
    return split_answers(data, methods), closed


def check(daemon, wanted, pieces):
    """`wanted`: the statuses in order; a slug behind the last one; `keep`: a good request may
    follow on the same connection, and is answered; otherwise the connection is closed."""
    statuses = [int(word) for word in wanted if word.isdigit()]
    slugs = [word for word in wanted if not word.isdigit() and word not in ("keep", "none")]
    if "keep" in wanted:
        pieces, statuses = pieces + [GOOD], statuses + [200]
    methods = [b"HEAD", b"GET"] if pieces[0].startswith(b"HEAD ") else []
    answers, closed = exchange(daemon.port, pieces, methods)
    got = [answer[0] for answer in answers]
    expect(got == statuses, f"answers {got}, not {statuses}; {answers[-1:]}")
    expect(closed, "the connection stays open")
    for status, headers, body in answers:
        if status >= 400 and body:
            expect_problem(status, headers, body)
    if "keep" in wanted:
        answers.pop()
    if slugs:
        expect_problem(*answers[-1], slug=slugs[0])
    if slugs and "keep" not in wanted:
        expect(answers[-1][1].get("connection", "").lower() == "close", "it does not say close")


def waiting_call(factor):
    """A call that is suspended until its drape ends."""
    body = json.dumps(saddle(factor)).encode()
    return (b"POST /v1/drapes?fields=nodes.i HTTP/1.1\r\nHost: localhost\r\nPrefer: wait=20\r\n"
            b"Content-Type: application/json\r\nContent-Length: %d\r\n\r\n" % len(body)) + body


def test_malformed_behind_a_waiting_call(daemon, apart):
    """The answer that is waited for comes first, then one 400, then the end."""
    bad = b"GET /version HTTP/1.1\nHost: localhost\n\n"
    call = waiting_call(0.3 + 0.01 * apart)
    answers, closed = exchange(daemon.port, [call, bad] if apart else [call + bad], [])
    expect([answer[0] for answer in answers] == [200, 400], [answer[:2] for answer in answers])
    expect(closed, "the connection stays open")
    expect_problem(*answers[1], slug="bad-request")


def test_waiting_calls_in_a_row(daemon):
    """Pipelined, each is answered in its turn."""
    calls = b"".join(waiting_call(0.4 + 0.01 * k) for k in range(3)) + GOOD
    answers, closed = exchange(daemon.port, [calls], [])
    expect([answer[0] for answer in answers] == [200] * 4, [answer[:2] for answer in answers])
    expect(closed, "the connection stays open")


def main():
    tap = Tap()
    daemon = Daemon("--max-body", "1M").start()
    try:
        for name, wanted, pieces in read_cases():
            tap.run(f"framing: {name}", check, daemon, wanted, pieces)
        for apart in (False, True):
            tap.run(f"framing: malformed behind a waiting call, {'later' if apart else 'at once'}",
                    test_malformed_behind_a_waiting_call, daemon, apart)
        tap.run("framing: waiting calls in a row", test_waiting_calls_in_a_row, daemon)
        tap.run("framing: the daemon answers as before", daemon.get_json, "/version")
        tap.run("framing: the log is JSON, line by line", expect_sound_log, daemon)
        tap.run("framing: the daemon ends well", daemon.end_well)
    finally:
        daemon.remove()
    tap.finish()


if __name__ == "__main__":
    main()
