# SPDX-License-Identifier: MIT
"""A thousand clients that are slow in every way, for half a minute (LONG=1) or some seconds, while
normal calls go on."""
import os
import random
import resource
import selectors
import signal
import socket
import sys
import threading
import time

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from daemon import LONG, Daemon, Tap, expect, expect_sound_log, saddle  # noqa: E402

CLIENTS = 1000
SECONDS = 30 if LONG else 12  # more than the 10 s that a head may take
HEAD = b"GET /version HTTP/1.1\r\nHost: localhost\r\nX: "
BODY = (b"POST /v1/drapes HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
        b"Content-Length: 100000\r\n\r\n")
CHUNKED = (b"POST /v1/drapes HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
           b"Transfer-Encoding: chunked\r\n\r\n")
# What a client says first, and then about once a second.
KINDS = {"head": (HEAD, b"a"), "body": (BODY, b" "), "chunks": (CHUNKED, b"1\r\n \r\n"),
         "silent": (b"", b""), "newlines": (b"", b"\r\n")}


class SlowClient:
    def __init__(self, port, kind):
        self.kind = kind
        self.answer = b""
        self.first, self.drip = KINDS[kind]
        self.socket = socket.socket()
        self.socket.setblocking(False)
        self.socket.connect_ex(("127.0.0.1", port))
        self.due = time.monotonic() + random.random()
        self.open = True

    def send(self, now):
        data, self.first = self.first or self.drip, b""
        self.due = now + 1.0
        try:
            if data:
                self.socket.send(data)
        except BlockingIOError:
            pass
        except OSError:
            self.open = False

    def receive(self):
        try:
            piece = self.socket.recv(4096)
            self.answer += piece
            self.open = self.open and bool(piece)
        except BlockingIOError:
            pass
        except OSError:
            self.open = False


class Crowd(threading.Thread):
    """CLIENTS at a time; who is thrown out is followed by another one."""

    def __init__(self, port):
        super().__init__()
        self.port = port
        self.refused = dict.fromkeys(KINDS, 0)
        self.wrong = []
        self.begun = 0

    def add(self, selector):
        client = SlowClient(self.port, list(KINDS)[self.begun % len(KINDS)])
        self.begun += 1
        selector.register(client.socket, selectors.EVENT_READ, client)
        return client

    def leave(self, selector, client):
        selector.unregister(client.socket)
        client.socket.close()
        if client.answer.startswith(b"HTTP/1.1 408 "):
            self.refused[client.kind] += 1
        elif client.answer:
            self.wrong.append(client.answer[:200])

    def run(self):
        end = time.monotonic() + SECONDS
        with selectors.DefaultSelector() as selector:
            clients = [self.add(selector) for _ in range(CLIENTS)]
            while (now := time.monotonic()) < end:
                for key, _ in selector.select(0.1):
                    key.data.receive()
                for k, client in enumerate(clients):
                    if client.open and client.due <= now:
                        client.send(now)
                    if not client.open:
                        self.leave(selector, client)
                        clients[k] = self.add(selector)
            for client in clients:
                self.leave(selector, client)


def normal_call(daemon, number):
    if number % 3 == 0:
        answer = daemon.submit(saddle(0.3 + 0.001 * (number % 10)), Prefer="wait=25")
    else:
        answer = daemon.call("GET", "/v1/drapes" if number % 3 == 1 else "/version")
    expect(answer[0] == 200, f"call {number} is {answer[0]}: {answer[2][:300]}")


def descriptors(daemon):
    return len(os.listdir(f"/proc/{daemon.process.pid}/fd"))


def connections(daemon):
    """Those that are open on both sides."""
    with open("/proc/net/tcp") as table:
        fields = [line.split() for line in list(table)[1:]]
    return sum(local.endswith(f":{daemon.port:04X}") and state == "01"
               for _, local, _, state, *_ in fields)


def wait_for_descriptors(daemon, most):
    end = time.monotonic() + 30
    while (count := descriptors(daemon)) > most:
        expect(time.monotonic() < end, f"{count} descriptors are open, {most} before")
        time.sleep(0.2)


def test_slow_clients():
    _, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(hard, 4096), hard))
    daemon = Daemon("--workers", "1").start()
    try:
        for number in range(30):
            normal_call(daemon, number)
        before = descriptors(daemon)
        crowd = Crowd(daemon.port)
        crowd.start()
        calls, slowest = 0, 0.0
        try:
            while crowd.is_alive():
                begun = time.monotonic()
                normal_call(daemon, calls)
                slowest = max(slowest, time.monotonic() - begun)
                calls += 1
                time.sleep(0.01)
        finally:
            crowd.join()
        print(f"# {calls} calls beside {CLIENTS} slow clients, the slowest {slowest * 1e3:.0f} ms; "
              f"408 for {crowd.refused} of {crowd.begun}")
        expect(not crowd.wrong, crowd.wrong[:2])
        for kind in ("head", "body", "chunks", "silent", "newlines"):
            expect(crowd.refused[kind] > 0, f"no slow client of kind {kind} was refused")
        wait_for_descriptors(daemon, before + 8)
        daemon.end_well()
        expect_sound_log(daemon)
    finally:
        daemon.remove()


def raw(daemon, path, buffer=None):
    """A connection on which the path was asked for."""
    client = socket.socket()
    if buffer:
        client.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, buffer)
    client.connect(("127.0.0.1", daemon.port))
    client.sendall(f"GET {path} HTTP/1.1\r\nHost: localhost\r\n\r\n".encode())
    return client


def hold_worker(daemon):
    """A drape that runs until its worker is let go on; its path."""
    for worker in daemon.workers():
        os.kill(worker, signal.SIGSTOP)
    return daemon.submit(saddle(0.31))[1]["location"]


def test_slow_readers():
    """A reply that its client does not read is cut, within 60 s and what its length is worth; an
    event stream on which nothing happens says so before proxies give it up."""
    daemon = Daemon("--workers", "1").start()
    try:
        _, headers, _ = daemon.submit(saddle(0.01), Prefer="wait=50")
        path = headers["location"] + "/result?format=json"
        _, headers, body = daemon.call("GET", path)
        # Of unknown length, it is made and counted in small pieces, and long for any socket.
        expect("content-length" not in headers and len(body) > 2e7, len(body))
        size = len(body)
        before = connections(daemon)
        unread = raw(daemon, path, 4096)
        events = raw(daemon, hold_worker(daemon) + "/events")
        events.settimeout(40)
        seen, end = b"", time.monotonic() + 60
        while b"\n: " not in seen:
            expect(time.monotonic() < end, f"no comment: {seen!r}")
            piece = events.recv(65536)
            expect(piece, f"the stream ends: {seen!r}")
            seen += piece
        events.close()
        expect(connections(daemon) > before, f"{size} bytes fit into the socket: nothing is tested")
        end = time.monotonic() + 150
        while connections(daemon) > before:
            expect(time.monotonic() < end, "a reply that nobody reads is never cut")
            time.sleep(0.5)
        got = 0
        try:
            while piece := unread.recv(1 << 20):
                got += len(piece)
        except ConnectionError:
            pass
        expect(got < size, "it was all there")
        for worker in daemon.workers():
            os.kill(worker, signal.SIGCONT)
        daemon.end_well()
    finally:
        daemon.remove()


def main():
    tap = Tap()
    tap.run("slow: replies that are not read are cut, and silent streams speak", test_slow_readers)
    tap.run(f"slow: normal calls succeed beside {CLIENTS} slow clients", test_slow_clients)
    tap.finish()


if __name__ == "__main__":
    main()
