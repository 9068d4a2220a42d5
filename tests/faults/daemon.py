# SPDX-License-Identifier: MIT
"""A daemon of its own for a test: started on a free port with a new data folder, stopped by its
process id, and whatever of it is left is removed. Tests say what they found in TAP."""
import http.client
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time

BUILD = os.environ.get("BUILD", "build")
LONG = os.environ.get("LONG") == "1"  # make soak
START_SECONDS = 60  # sanitizers and a busy machine included
STOP_SECONDS = 30  # what the contract allows after SIGTERM


class Failure(Exception):
    pass


def expect(good, text):
    if not good:
        raise Failure(text)


def seed():
    """Of a random test, printed: DRAPED_SEED, else, so that a run says of a tree what the one before
    said, the same every time; in `make soak` a new one."""
    usual = random.SystemRandom().getrandbits(32) if LONG else 1
    chosen = int(os.environ.get("DRAPED_SEED", usual))
    print(f"# DRAPED_SEED={chosen}", flush=True)
    return random.Random(chosen)


def argument_of(pid):
    """What a child of the daemon is, by its command line; "" when it has ended."""
    try:
        with open(f"/proc/{pid}/cmdline", "rb") as line:
            return line.read().split(b"\0")[1].decode()
    except (OSError, IndexError):
        return ""


class Daemon:
    def __init__(self, *flags, files=None):
        self.flags = flags
        self.home = tempfile.mkdtemp(prefix="draped-test-")
        self.log_path = os.path.join(self.home, "log")
        self.process = None
        self.port = 0
        self.files = files  # descriptors it may open

    def start(self, *more, port=0):
        import resource

        def limit():
            if self.files:
                resource.setrlimit(resource.RLIMIT_NOFILE, (self.files, self.files))

        with open(self.log_path, "ab") as log:
            self.process = subprocess.Popen(
                [f"{BUILD}/draped", "--listen", f"127.0.0.1:{port}",
                 "--data", os.path.join(self.home, "data"), *self.flags, *more],
                stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=log, preexec_fn=limit)
        line = self.process.stdout.readline().decode()
        expect(line.startswith("draped listening on http://"),
               f"it does not start: {line!r} {self.log_tail()}")
        self.port = int(line.rsplit(":", 1)[1])
        return self

    def kill(self):
        self.process.kill()
        self.process.wait()
        self.process.stdout.close()
        self.process = None

    def stop(self):
        """SIGTERM; the exit status and the seconds it took."""
        begun = time.monotonic()
        self.process.send_signal(signal.SIGTERM)
        try:
            status = self.process.wait(STOP_SECONDS)
        except subprocess.TimeoutExpired:
            self.kill()
            raise Failure(f"it did not end within {STOP_SECONDS} s") from None
        self.process.stdout.close()
        self.process = None
        return status, time.monotonic() - begun

    def children(self):
        """Process ids of its workers and checkers."""
        found = []
        base = f"/proc/{self.process.pid}/task"
        for task in os.listdir(base):
            try:
                with open(f"{base}/{task}/children") as children:
                    found += [int(pid) for pid in children.read().split()]
            except OSError:
                continue  # the thread has ended
        return found

    def workers(self):
        """Process ids of its workers."""
        return [pid for pid in self.children() if argument_of(pid) == "worker"]

    def end_well(self):
        """Stops it by SIGTERM; it must exit with status 0."""
        status = self.stop()[0]
        expect(status == 0, f"exit status {status}; its log ends:\n{self.log_tail(60)}")

    def log_tail(self, lines=5):
        with open(self.log_path, errors="replace") as log:
            return "\n".join(log.read().splitlines()[-lines:])

    def call(self, method, path, body=None, headers=None, timeout=30):
        """Status, headers in small letters, body. Raises OSError when nobody answers."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=timeout)
        try:
            connection.request(method, path, body, headers or {})
            answer = connection.getresponse()
            return (answer.status, {k.lower(): v for k, v in answer.getheaders()}, answer.read())
        except http.client.HTTPException as error:
            raise OSError(f"{type(error).__name__}: {error}") from error
        finally:
            connection.close()

    def submit(self, request, **headers):
        fields = {"Content-Type": "application/json"}
        fields.update({name.replace("_", "-"): value for name, value in headers.items()})
        return self.call("POST", "/v1/drapes", json.dumps(request), fields)

    def get_json(self, path):
        status, _, body = self.call("GET", path)
        expect(status == 200, f"GET {path} is {status}: {body[:300]}")
        return json.loads(body)

    def remove(self):
        if self.process:
            self.kill()
        shutil.rmtree(self.home, ignore_errors=True)


def expect_sound_log(daemon):
    """Every line is JSON: nothing that was sent got in unescaped."""
    with open(daemon.log_path, "rb") as log:
        for line in log:
            try:
                json.loads(line)
            except ValueError:
                raise Failure(f"no JSON in the log: {line[:200]!r}") from None


def expect_problem(status, headers, body, slug=None):
    """The whole of what a problem has to be."""
    expect(headers.get("content-type") == "application/problem+json",
           f"{status} is {headers.get('content-type')}: {body[:200]}")
    problem = json.loads(body)
    expect(problem["status"] == status and problem["title"] and problem["detail"], problem)
    expect(problem["request_id"] == headers.get("x-request-id"), "the request id is another")
    if slug:
        expect(problem["type"] == f"/problems/{slug}", problem)


def saddle(spacing):
    """The example request with that spacing: 0.2 takes milliseconds, 0.004 seconds."""
    with open("api/examples/saddle.json") as file:
        request = json.load(file)
    request["fabric"]["spacing"] = spacing
    return request


class Tap:
    """Runs functions as tests; `finish` ends the program."""

    def __init__(self):
        self.count = self.failed = 0

    def run(self, name, function, *arguments):
        self.count += 1
        try:
            function(*arguments)
            print(f"ok {self.count} - {name}", flush=True)
        except Exception as error:  # whatever it is, the test has failed and the next one goes on
            self.failed += 1
            print(f"not ok {self.count} - {name}\n#   {type(error).__name__}: {error}", flush=True)

    def finish(self):
        print(f"1..{self.count}")
        sys.exit(1 if self.failed else 0)
