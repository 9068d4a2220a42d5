# SPDX-License-Identifier: MIT
"""Compares how server/http/wire.h, llhttp and h11 read random connections: where each message ends,
and whether it is well-formed. Where two accept the same beginning the ends must be the same. Where
one refuses what another accepts, the reason must be argued in disagreements.txt; a new one fails.
Inputs are the cases of tests/faults/framing.cases, changed at random.
Usage: parsers.py WIRE SECONDS   (DRAPED_SEED of the environment: to run again)"""
import os
import random
import subprocess
import sys
import time

import h11

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "../../faults"))
from test_framing import read_cases  # noqa: E402

BATCH = 4000
LONGEST = 4000  # bytes of a case that is changed; longer ones test limits, which parsers do not share
PIECES = [b"\r\n", b"\n", b"\r", b" ", b"\t", b"\0", b":", b";", b"=", b'"', b"\\", b",", b"0", b"1", b"a",
          b"/", b"?", b"#", b"%", b"@", b"[", b"]", b"\x7f", b"\x80", b"\xff", b"\x0b", b"\x0c", b"-", b"+", b"_",
          b"\r\n\r\n", b"0\r\n\r\n", b"2\r\n{}\r\n", b";a=b", b";a", b"HTTP/1.1", b"HTTP/1.0", b"GET ", b"* ",
          b"Content-Length: 2\r\n", b"Transfer-Encoding: chunked\r\n", b"Host: localhost\r\n", b"X: y\r\n",
          b" z\r\n", b"Connection: close\r\n", b"http://localhost", b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n"]


def mutate(chance, cases):
    """A case with one to four changes: a piece put in, over or out, two cases in a row."""
    data = chance.choice(cases)
    for _ in range(chance.randint(1, 4)):
        at = chance.randint(0, len(data))
        kind = chance.random()
        if kind < 0.4:
            data = data[:at] + chance.choice(PIECES) + data[at:]
        elif kind < 0.6:
            data = data[:at] + chance.choice(PIECES) + data[at + chance.randint(1, 4):]
        elif kind < 0.75:
            data = data[:at] + data[at + chance.randint(1, 4):]
        elif kind < 0.85:
            data = data[:at] + bytes([chance.randrange(256)]) + data[at + 1:]
        elif kind < 0.95:
            other = chance.choice(cases)
            data = data[:at] + other[chance.randint(0, len(other)):]
        else:
            data = data + chance.choice(cases)
    return data


def frames(inputs):
    return b"".join(len(data).to_bytes(4, "big") + data for data in inputs)


def run(command, inputs):
    """The verdicts of a program: (ends, state) for each input."""
    lines = subprocess.run(command, input=frames(inputs), stdout=subprocess.PIPE, check=True,
                           timeout=300).stdout.decode("latin-1").splitlines()
    assert len(lines) == len(inputs), f"{command[0]}: {len(lines)} verdicts for {len(inputs)} inputs"
    verdicts = []
    for line in lines:
        words = line.split(" ")
        count = next(k for k, word in enumerate(words) if not word.isdigit())
        verdicts.append(([int(word) for word in words[:count]], " ".join(words[count:])))
    return verdicts


def read_h11(data):
    """The same by h11; a connection of its own for each message."""
    ends = []
    rest = data
    while rest:
        connection = h11.Connection(h11.SERVER, max_incomplete_event_size=65536)
        connection.receive_data(rest)
        begun = False
        try:
            while True:
                event = connection.next_event()
                if event is h11.NEED_DATA:
                    return ends, "more"
                if isinstance(event, h11.EndOfMessage):
                    break
                begun = True
        except h11.RemoteProtocolError as error:
            return ends, str(error).split(":")[0].split(" b'")[0].split(" (")[0]
        assert begun
        rest = connection.trailing_data[0]
        ends.append(len(data) - len(rest))
    return ends, "ok"


def good(state):
    return state in ("ok", "more")


def compare(ours, theirs):
    """None when they agree, or one has not decided yet; else what disagreements.txt calls it."""
    (our_ends, our_state), (their_ends, their_state) = ours, theirs
    common = min(len(our_ends), len(their_ends))
    if our_ends[:common] != their_ends[:common]:
        return "a message ends elsewhere"
    if len(their_ends) > len(our_ends):
        return f"accepts: {our_state}"
    if len(our_ends) > len(their_ends):
        return f"refuses: {their_state}" if not good(their_state) else f"waits: {our_state}"
    if our_state == "ok" and not good(their_state):
        return f"refuses: {their_state}"
    return None


def read_argued():
    """The disagreements that are argued: "PARSER disagreement", where PARSER may be `both`."""
    argued = set()
    with open(os.path.join(HERE, "disagreements.txt")) as file:
        for line in file:
            words = line.strip().split(" ", 1)
            if words[0] in ("llhttp", "h11", "both"):
                argued.update((parser, words[1]) for parser in ("llhttp", "h11")
                              if words[0] in (parser, "both"))
    return argued


def main():
    wire, seconds = sys.argv[1], float(sys.argv[2])
    seed = int(os.environ.get("DRAPED_SEED") or random.SystemRandom().getrandbits(32))
    print(f"DRAPED_SEED={seed}", flush=True)
    chance = random.Random(seed)
    cases = [b"".join(pieces) for _, _, pieces in read_cases()]
    inputs = cases
    cases = [case for case in cases if len(case) <= LONGEST]
    argued, seen, new = read_argued(), {}, {}
    count, end = 0, time.monotonic() + seconds
    while True:
        ours = run([wire], inputs)
        others = {"llhttp": run(["node", os.path.join(HERE, "llhttp.mjs")], inputs),
                  "h11": [read_h11(data) for data in inputs]}
        for parser, theirs in others.items():
            for data, our, their in zip(inputs, ours, theirs):
                found = compare(our, their)
                if not found:
                    continue
                seen[parser, found] = seen.get((parser, found), 0) + 1
                if (parser, found) not in argued:
                    kept = new.setdefault((parser, found), (data, our, their))
                    if len(data) < len(kept[0]):
                        new[parser, found] = (data, our, their)
        count += len(inputs)
        if time.monotonic() >= end:
            break
        inputs = [mutate(chance, cases) for _ in range(BATCH)]
    for (parser, found), times in sorted(seen.items()):
        print(f"{times:8} {parser} {found}")
    for (parser, found), (data, our, their) in sorted(new.items()):
        print(f"NOT ARGUED: {parser} | {found}\n    {data[-400:]!r}\n    ours {our}, theirs {their}")
    print(f"parsers: {count} inputs, {len(seen)} kinds of disagreement, {len(new)} not argued")
    sys.exit(1 if new else 0)


if __name__ == "__main__":
    main()
