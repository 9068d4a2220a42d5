# SPDX-License-Identifier: MIT
"""What clients/python/draped.py raises when the service (the first argument, with --max-body 64K) refuses, and when
what is at the address is another program: silent, one that breaks off, of another version. Files: the second."""
import contextlib
import json
import os
import socket
import sys
import threading
import time

sys.path.insert(0, "clients/python")
import draped  # noqa: E402

URL, FOLDER = sys.argv[1:]


@contextlib.contextmanager
def server(answer):
    """The address of one that says `answer`, bytes, to everything (None: nothing, ever), and its calls."""
    listener = socket.create_server(("127.0.0.1", 0))
    held = []

    def serve():
        with contextlib.suppress(OSError):
            while True:
                call = listener.accept()[0]
                held.append(call)
                if answer is not None:
                    call.recv(1 << 16)
                    call.sendall(answer)
                    call.close()

    threading.Thread(target=serve, daemon=True).start()
    try:
        yield f"http://127.0.0.1:{listener.getsockname()[1]}", held
    finally:
        listener.close()
        for call in held:
            call.close()


def said(body, length=None, status="200 OK"):
    return f"HTTP/1.1 {status}\r\nContent-Length: {length or len(body)}\r\n\r\n{body}".encode()


def check(kind, also, words, call, *arguments, **options):
    """The call raises exactly this type, with these words, soon."""
    begun = time.monotonic()
    try:
        call(*arguments, **options)
        sys.exit(f"nothing was wrong with {call}")
    except draped.DrapedError as error:
        assert type(error) is kind and isinstance(error, also), repr(error)
        assert all(word in str(error) for word in words), str(error)
    assert time.monotonic() - begun < 30


client = draped.Client(URL)
assert client.version() == draped.__version__

# What the daemon refuses: too large a part is told at once, though all of it is sent.
large = os.path.join(FOLDER, "large.stl")
with open(large, "wb") as file:
    file.write(bytes(50 << 20))
check(draped.TooLarge, Exception, ["over the limit of 65536 bytes", URL, "Send less"], client.upload, large)
with open("api/examples/saddle.json", encoding="utf-8") as file:
    drape = client.submit(json.load(file))
client.wait(drape)
bare = os.path.join(FOLDER, "nodes.inp")
with open(bare, "w", encoding="ascii") as file:
    file.write("*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 0., 1., 0.\n")
kept = os.path.join(FOLDER, "kept.vtu")
with open(kept, "w", encoding="ascii") as file:
    file.write("as it was")
check(draped.DrapedError, Exception, ["invalid-request", "no shell elements"], client.save_map, drape, bare, kept)
check(draped.DrapedError, Exception, ["not-found"], client.wait, 32 * "0")

# What is too slow: the job goes on, the silent server is left alone.
slow = {"surface": json.load(open("api/examples/freeform.json"))["surface"], "fabric": {"spacing": 0.3}}
job = client.submit(slow)
check(draped.WaitTimeout, TimeoutError, [f"drapes/{job}", "it goes on"], client.wait, job, timeout=0)
client.cancel(job)
with server(None) as (url, calls):
    check(draped.Unreachable, ConnectionError, ["no answer within 0.5 s", url], draped.Client(url, timeout=0.5).version)
    assert len(calls) == 1

# What is no draped, or another one.
with server(said('{"name": "draped", "version": "99.1.0"}')) as (url, calls):
    check(draped.OtherVersion, Exception, ["draped 99.1.0", draped.__version__, url, "Use the draped.py of draped 99.1.0"],
          draped.Client(url).version)
for answer in (said("<html>"), said("[]"), said("gone", status="404 Not Found")):
    with server(answer) as (url, calls):
        check(draped.OtherVersion, Exception, ["no draped", url, "Check the address"], draped.Client(url).version)
with server(b"SSH-2.0-OpenSSH\r\n") as (url, calls):
    check(draped.Unreachable, ConnectionError, [url], draped.Client(url).version)

# What breaks off leaves the file as it was, and nothing beside it.
for answer in (said("x" * 100, 1000), b"HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n64\r\nxxx"):
    with server(answer) as (url, calls):
        check(draped.Unreachable, ConnectionError, [url], draped.Client(url).save, drape, kept, format="csv")
        check(draped.Unreachable, ConnectionError, [url], draped.Client(url).result, drape)
with open(kept, encoding="ascii") as file:
    assert file.read() == "as it was"
assert sorted(os.listdir(FOLDER)) == ["kept.vtu", "large.stl", "nodes.inp"], os.listdir(FOLDER)
