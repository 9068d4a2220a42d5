# SPDX-License-Identifier: MIT
"""Connections that one owner takes, and what is left for others: an idle one makes room, probes are
answered when all are taken."""
import os
import select
import socket
import sys
import time

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from daemon import Daemon, Failure, Tap, expect, saddle  # noqa: E402

HEALTH = b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n"
VERSION = b"GET /version HTTP/1.1\r\nHost: localhost\r\n\r\n"
# Its head is complete, its body is not: the connection is not idle.
UPLOAD = (b"POST /v1/drapes HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
          b"Content-Length: 5000\r\n\r\n" + b" " * 1000)


def connect(daemon, address):
    return socket.create_connection(("127.0.0.1", daemon.port), 10, (address, 0))


def ask(connection, request):
    """The status of its answer; None when the connection was closed instead."""
    try:
        connection.sendall(request)
        answer = connection.recv(65536)
    except ConnectionError:
        return None
    return int(answer.split(b" ", 2)[1]) if answer else None


def asked(daemon, address, request):
    with connect(daemon, address) as connection:
        return ask(connection, request)


def fill(daemon, address, share, upload=UPLOAD, beyond=VERSION, seconds=40):
    """Uploads of the address, as many as its share, so that it gets no more: what is beyond is
    refused. One that comes before the daemon has noticed that another connection was closed is
    refused; one that was not sent for a moment after it was connected, on a busy machine, is an idle
    one."""
    busy = []
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if len(busy) < share:
            busy.append(connect(daemon, address))
            busy[-1].sendall(upload)
            time.sleep(0.02)
        elif asked(daemon, address, beyond) == 429:
            return busy
        ended = select.select(busy, [], [], 0)[0]
        busy = [connection for connection in busy if connection not in ended]
    raise Failure(f"{address} gets {len(busy)} connections, its share is {share}")


def upload(daemon, address, seconds=40):
    """One that is taken; another is tried when it is refused."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        connection = connect(daemon, address)
        connection.sendall(UPLOAD)
        if not select.select([connection], [], [], 0.1)[0]:
            return connection
        connection.close()
    raise Failure(f"{address} finds no place")


def settled(daemon, address, request, status, seconds=40):
    """Whether that becomes the answer."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if asked(daemon, address, request) == status:
            return True
        time.sleep(0.1)
    return False


def with_daemon(function, *flags):
    daemon = Daemon("--workers", "1", *flags)
    try:
        daemon.start()
        function(daemon)
        daemon.end_well()
    finally:
        daemon.remove()


def test_owners_idle_connections_make_room(daemon):
    """One address takes all it can get and says nothing more: others connect all the same."""
    idle = [connect(daemon, "127.0.0.2") for _ in range(200)]
    idle += [connect(daemon, "127.0.0.3") for _ in range(200)]
    for k in range(20):  # what has only just come does not count as idle
        expect(settled(daemon, "127.0.0.4", VERSION, 200), f"another caller was refused ({k})")
    expect(settled(daemon, "127.0.0.2", VERSION, 200), "its own newest connection was refused")
    for connection in idle:
        connection.close()


def test_owners_busy_connections_leave_the_reserve(daemon):
    """Connections that are all in use: an owner alone gets half of them and then 429; when every
    place is taken whoever comes gets one of who has most, and 503 only when nobody has more than
    one; probes 200 throughout."""
    busy = fill(daemon, "127.0.0.2", 16)
    expect(asked(daemon, "127.0.0.2", HEALTH) == 200, "a probe was refused")
    for k in range(1, 32):  # with one of the owner above there are 32
        busy.append(upload(daemon, f"127.0.1.{k}"))
    expect(settled(daemon, "127.0.0.4", VERSION, 503), "there are more than --max-connections")
    silent = [connect(daemon, "127.0.0.2") for _ in range(100)]
    for path in (b"/healthz", b"/readyz", b"/metrics"):
        expect(asked(daemon, "127.0.0.4", HEALTH.replace(b"/healthz", path)) == 200,
               f"{path} was refused")
    for connection in busy + silent:
        connection.close()
    expect(settled(daemon, "127.0.0.4", VERSION, 200), "places are not given back")


def test_owners_bodies_have_a_share(daemon):
    """Half of what bodies may hold is the most for one owner's, but for a single one."""
    # Three fit. A fourth would be refused when they have arrived, or together with another of them.
    upload = UPLOAD.replace(b"5000", b"300000") + b" " * 199000
    over = b"POST /v1/drapes HTTP/1.1\r\nHost: localhost\r\nContent-Length: 200000\r\n\r\n"
    held = fill(daemon, "127.0.0.2", 3, upload, over + b" " * 200000)
    status, _, _ = daemon.submit(saddle(0.2))
    expect(status == 202, f"another owner's body is {status}")
    expect(asked(daemon, "127.0.0.3", over + b" " * 200000) == 400, "another's large one is refused")
    for connection in held:
        connection.close()


tap = Tap()
tap.run("test_owners_idle_connections_make_room", with_daemon,
        test_owners_idle_connections_make_room, "--max-connections", "64")
tap.run("test_owners_busy_connections_leave_the_reserve", with_daemon,
        test_owners_busy_connections_leave_the_reserve, "--max-connections", "32")
tap.run("test_owners_bodies_have_a_share", with_daemon, test_owners_bodies_have_a_share,
        "--max-bodies", "1200K", "--max-body", "1M", "--max-mesh", "1M")
tap.finish()
