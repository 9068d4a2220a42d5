# SPDX-License-Identifier: MIT
"""Callers that take what they can get: each is a process of its own, at an address of its own of
loopback, and so an owner of its own. `CORPUS` names what they do; `start` runs some of them at once
and collects the statuses that they were answered with."""
import http.client
import json
import multiprocessing
import os
import socket
import threading
import time

JSON = {"Content-Type": "application/json"}


def saddle(spacing):
    with open("api/examples/saddle.json") as file:
        request = json.load(file)
    request["fabric"]["spacing"] = spacing
    return request


class Caller:
    """What one hostile process knows: where to call, from where, until when."""

    def __init__(self, port, address, until, scale, drape):
        self.port, self.address, self.until, self.scale = port, address, until, scale
        self.drape = drape  # one that has succeeded
        self.statuses = {}
        self.lock = threading.Lock()

    def on(self):
        return time.monotonic() < self.until

    def count(self, status):
        with self.lock:
            self.statuses[status] = self.statuses.get(status, 0) + 1

    def connect(self):
        return socket.create_connection(("127.0.0.1", self.port), 10, (self.address, 0))

    def post(self, path, body, headers=JSON):
        """Notes the status; the document that was answered, {} for none."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=60,
                                                source_address=(self.address, 0))
        try:
            connection.request("POST", path, body, headers)
            answer = connection.getresponse()
            document = json.loads(answer.read())
            why = f" {document['detail']}" if answer.status == 503 else ""
            self.count(f"{answer.status}{why}")
            if answer.status in (429, 503):
                time.sleep(0.2)
            return document
        except (OSError, http.client.HTTPException):
            self.count("none")
            time.sleep(0.05)
            return {}
        finally:
            connection.close()

    def posts(self, path, bodies, at_once):
        """Posts the bodies again and again, some at a time."""
        def go(k):
            while self.on():
                self.post(path, bodies[k % len(bodies)]())
                k += at_once
        threads = [threading.Thread(target=go, args=(k,)) for k in range(at_once)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()

    def hold(self, count, first, drip, pause):
        """Keeps so many connections, on each `first` and then a drip every `pause` seconds; what
        is answered is not read. Those that are closed are replaced."""
        held = []
        while self.on():
            while len(held) < count and self.on():
                try:
                    connection = self.connect()
                    connection.sendall(first)
                    connection.setblocking(False)
                    held.append(connection)
                except OSError:
                    self.count("none")
                    break
            for connection in list(held):
                try:
                    if drip:
                        connection.send(drip)
                    elif connection.recv(1, socket.MSG_PEEK) == b"":
                        raise OSError
                except BlockingIOError:
                    pass
                except OSError:
                    self.count("closed")
                    connection.close()
                    held.remove(connection)
            time.sleep(pause)
        for connection in held:
            connection.close()


def zigzag(points):
    """A saddle with a trim that crosses itself all the way."""
    request = saddle(0.1)
    corners = [[0.1 + 0.8 * (k * 0.6180339887 % 1), 0.1 + 0.8 * (k * 0.7548776662 % 1)]
               for k in range(points)]
    corners.append(corners[0])
    count = len(corners)
    knots = [0.0] + [k / (count - 1) for k in range(count)] + [1.0]
    request["surface"]["trims"] = [{"degree": 1, "knotvector": knots,
                                    "control_points": {"points": corners}}]
    return json.dumps(request)


def lattice(size, degree):
    """A surface of size x size control points."""
    knots = [0] * degree + [k / (size - degree) for k in range(size - degree + 1)] + [1] * degree
    points = [[i, j, (i * j % 7) / 7] for i in range(size) for j in range(size)]
    return json.dumps({"degree_u": degree, "degree_v": degree, "knotvector_u": knots,
                       "knotvector_v": knots, "size_u": size, "size_v": size,
                       "control_points": {"points": points}})


def crossing_trims(caller):
    body = zigzag(int(2980 * caller.scale))
    caller.posts("/v1/drapes", [lambda: body], 6)


def large_trims(caller):
    body = zigzag(int(7270 * caller.scale))
    caller.posts("/v1/drapes", [lambda: body], 12)


def large_surfaces(caller):
    body = lattice(max(12, int(512 * caller.scale)), 9)
    caller.posts("/v1/surfaces", [lambda: body], 6)


def large_bodies(caller):
    points = "[1.25,2.5,3.75]," * int(3750000 * caller.scale)
    body = '{"control_points":{"points":[' + points + "[0,0,0]]}}"
    caller.posts("/v1/surfaces", [lambda: body], 8)


def endless_drapes(caller):
    """Drapes of many seconds each, each another one."""
    number = iter(range(1, 1000000))
    caller.posts("/v1/drapes", [lambda: json.dumps(
        saddle(0.003 + 1e-8 * (next(number) + os.getpid() % 1000)))], 6)


def event_streams(caller):
    """Of a drape that waits behind others of its owner."""
    for k in range(20):
        waiting = caller.post("/v1/drapes", json.dumps(saddle(0.0031 + 1e-8 * k)))
    caller.hold(int(1500 * caller.scale), b"GET /v1/drapes/%s/events HTTP/1.1\r\nHost: localhost"
                b"\r\n\r\n" % waiting.get("id", caller.drape).encode(), None, 0.5)


def study_streams(caller):
    """Of a study that gets on all the time, more than one owner may have."""
    study = {"drape": saddle(0.1), "objectives": ["max_shear_deg"],
             "vary": {"start": {"grid": 300}, "angle_deg": {"from": 0, "to": 90, "step": 1}}}
    running = caller.post("/v1/studies", json.dumps(study))
    caller.hold(int(2500 * caller.scale), b"GET /v1/studies/%s/events HTTP/1.1\r\nHost: localhost"
                b"\r\n\r\n" % running["id"].encode(), None, 0.1)


def idle_connections(caller):
    caller.hold(int(2500 * caller.scale), b"GET /version HTTP/1.1\r\nHost: localhost\r\n\r\n", None,
                1)


def slow_uploads(caller):
    caller.hold(int(400 * caller.scale), b"POST /v1/drapes HTTP/1.1\r\nHost: localhost\r\n"
                b"Content-Type: application/json\r\nContent-Length: 2000000\r\n\r\n",
                b" " * 600, 0.5)


def unread_maps(caller):
    count = int(20000 * caller.scale)
    body = json.dumps({"points": [[-1.5 + 3 * k / count, 0.3, 0.1] for k in range(count)]})
    head = ("POST /v1/drapes/%s/map HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json"
            "\r\nContent-Length: %d\r\n\r\n" % (caller.drape, len(body)))
    caller.hold(16, (head + body).encode(), None, 0.5)


CORPUS = [crossing_trims, large_trims, large_surfaces, large_bodies, endless_drapes, endless_drapes,
          event_streams, study_streams, idle_connections, slow_uploads, unread_maps]


def run(attack, arguments, answers):
    os.nice(19)  # it stands for another machine, and must not take the time of the daemon's
    caller = Caller(*arguments)
    attack(caller)
    answers.put((attack.__name__, caller.statuses))


class Hostile:
    """All of the corpus against the daemon for so many seconds; `scale` 1 is full size."""

    def __init__(self, port, seconds, scale, drape):
        until = time.monotonic() + seconds
        self.answers = multiprocessing.Queue()
        self.processes = [
            multiprocessing.Process(target=run, daemon=True, args=(
                attack, (port, f"127.0.0.{2 + k}", until, scale, drape), self.answers))
            for k, attack in enumerate(CORPUS)]
        for process in self.processes:
            process.start()

    def collect(self):
        """By attack, how often each status was answered."""
        found = {}
        for process in self.processes:
            process.join(60)
            if process.is_alive():
                process.kill()
        while not self.answers.empty():
            name, statuses = self.answers.get()
            into = found.setdefault(name, {})
            for status, count in statuses.items():
                into[status] = into.get(status, 0) + count
        return found
