# SPDX-License-Identifier: MIT
"""Opens COUNT event streams of a drape that waits, and prints what one costs the daemon in memory.

Usage: streams.py PORT DRAPE DAEMON_PID COUNT. Prints "streams N bytes B": those whose first event
came, and by how many bytes a stream the daemon's resident set grew.
"""
import socket
import sys


def resident(pid):
    with open(f"/proc/{pid}/status") as status:
        line = next(line for line in status if line.startswith("VmRSS:"))
    return int(line.split()[1]) * 1024


def first_event(stream):
    text = b""
    while b"\n\n" not in text.partition(b"\r\n\r\n")[2]:
        piece = stream.recv(65536)
        if not piece:
            return False
        text += piece
    return b" 200 " in text.partition(b"\r\n")[0]


port, drape, pid, count = int(sys.argv[1]), sys.argv[2], int(sys.argv[3]), int(sys.argv[4])
call = f"GET /v1/drapes/{drape}/events HTTP/1.1\r\nHost: localhost\r\n\r\n".encode()
before = resident(pid)
streams = []
for _ in range(count):
    stream = socket.create_connection(("127.0.0.1", port), timeout=20)
    stream.sendall(call)
    streams.append(stream)
open_streams = sum(first_event(stream) for stream in streams)
print(f"streams {open_streams} bytes {(resident(pid) - before) // count}")
