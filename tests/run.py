#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Runs the tests, several at a time, and counts: checks of the source, cmocka programs, fuzz
inputs, Python and bats files as built for use and, where that tells more, with sanitizers; once the
page in Chromium, what is in deploy/ and six hosts. Everything a test starts has ports and folders
of its own.

Says what has ended and how far the run is; what failed is printed at once and again at the end. A
test that was skipped is counted as skipped, and fewer tests than a plan announced are failures. The
last line is "N passed, N failed" (and ", N skipped" if any were); the exit status says the same.
A job that runs daemons and fails beside others has one more try with the machine to itself: what
passes then needed time that others had. Both tries are shown, and such jobs are named at the end.
Usage: tests/run.py check|all BUILD [SANITIZED [PATTERN]]
DRAPED_TEST_TIMES names a file to which seconds and seconds of processors of every job are added.
PATTERN, a regular expression, limits the run to the jobs in whose name it is found."""
import glob
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field

LONGEST = 900  # seconds one job may take
STILL = 30  # seconds without news until it is said what runs
SIZE_SHORT = "0.1"  # of the exact tests every day, and where sanitizers make each step slow
CORES = os.cpu_count() or 1

# Those that take longest begin first.
FIRST = ["browser/page", "faults/test_slow", "test_store_faults", "http/jobs", "deploy/package",
         "browser/trouble", "sanitized tests/exact/test_exact_shell", "exact/test_exact_random.c",
         "faults/test_disk", "faults/test_kills", "http/studies", "http/map", "http/roles",
         "hosts/hosts.sh", "http/", "faults/", "deploy/", "browser/", "store/", "server/", "sanitized"]
# What runs daemons, whose answers take longer on a busy machine.
DAEMONS = ("http/", "faults/", "import/", "store/", "server/", "deploy/", "browser/", "clients/", "hosts/")
# What mostly waits leaves the processors to others: as long as they idle another job begins beside.
MOST = 3 * CORES  # jobs at a time
LOOK = 1.0  # seconds over which idling is measured
IDLE = 0.15  # of a processor, in which a further job finds room

# What runs once, because the other build would find nothing more. What a daemon says to a request is
# decided alike in both: with sanitizers; so is what a store answers. As it is used: what above all
# waits, kills, or has programs of others read what was written, searches of many nets, and the import
# of many files, whose time is Open CASCADE's. That code is run with sanitizers by http/, server/ and unit/.
SANITIZED_ALONE = ("faults/test_disk", "faults/test_hostile", "http/drapes", "http/errors",
                   "http/framing", "http/import", "http/jobs", "http/laminates", "http/limits",
                   "http/map", "http/origin", "http/owners", "http/roles", "http/service",
                   "http/studies", "http/surfaces", "http/tokens", "store/test_store")
# What waits for children and for time: not every day.
WAITING = ("server/test_document_pool", "server/test_dispatcher", "server/test_sandbox")
PLAIN_ALONE = ("http/docs", "http/proposals", "http/readers", "faults/test_kills", "faults/test_slow",
               "import/test_import", "import/test_splits", "store/test_store_durability")


@dataclass
class Job:
    """A program that speaks TAP and what became of it."""

    name: str
    command: list
    env: dict = field(default_factory=dict)
    one_test: bool = False  # its exit status is the whole of what it says
    needs: str = ""  # the job that builds its program
    passed: int = 0
    failed: int = 0
    skipped: int = 0
    seconds: float = 0
    cpu: float = 0
    text: str = ""
    tries: int = 1

    def again(self):
        """The same job, not yet run."""
        return Job(self.name, self.command, self.env, self.one_test, self.needs, tries=self.tries + 1)

    def rank(self):
        """Its place in the order of starts."""
        return next((k for k, part in enumerate(FIRST) if part in self.name), len(FIRST))

    def count(self, status):
        """Counts the lines of TAP; `status` is None when the time was up."""
        if self.one_test:
            self.passed, self.failed = int(status == 0), int(status != 0)
            return
        lines = re.findall(r"^(ok|not ok) ?(.*)", self.text, re.MULTILINE)
        self.skipped = sum("# skip" in what.lower() for _, what in lines)
        self.passed = sum(word == "ok" and "# skip" not in what.lower() for word, what in lines)
        self.failed = len(lines) - self.passed - self.skipped
        planned = sum(map(int, re.findall(r"^1\.\.(\d+)\s*(?:#.*)?$", self.text, re.MULTILINE)))
        if planned != len(lines) or planned == 0:
            self.text += f"# {len(lines)} results, {planned} planned\n"
            self.failed += max(1, planned - len(lines))
        elif status != 0 and self.failed == 0:
            self.failed = 1
        if status is None:
            self.text += f"# stopped after {LONGEST} s\n"
        elif status != 0:
            self.text += f"# exit status {status}\n"


def checks(build):
    return [Job(script, [script, build], one_test=True)
            for script in sorted(glob.glob("tests/checks/*.sh"))]


def programs(build, size, kinds=("exact", "unit", "store", "server")):
    """The cmocka programs; the exact ones at that share of their size."""
    return [Job(f"{build} {source}", [f"{build}/{source[:-2]}"],
                {"CMOCKA_MESSAGE_OUTPUT": "TAP", "DRAPED_TEST_SIZE": size})
            for kind in kinds for source in sorted(glob.glob(f"tests/{kind}/test_*.c"))]


def replays(build):
    """The inputs of the fuzzers, once each."""
    jobs = []
    for source in sorted(glob.glob("tests/fuzz/fuzz_*.c")):
        name = os.path.basename(source)[len("fuzz_"):-2]
        command = [f"{build}/{source[:-2]}", f"tests/fuzz/corpus/{name}"]
        jobs.append(Job(f"{build} {source}", command))
    return jobs


def bats(build, pattern):
    return [Job(f"{build} {file}", ["bats", "--tap", file], {"BUILD": build})
            for file in sorted(glob.glob(pattern))]


def faults(build):
    return [Job(f"{build} {file}", ["python3", file], {"BUILD": build})
            for file in sorted(glob.glob("tests/faults/test_*.py"))]


def imports(build):
    """With Debian's own Python, which has the modules of its packages."""
    return [Job(f"{build} {file}", ["/usr/bin/python3", file], {"BUILD": build})
            for file in sorted(glob.glob("tests/import/test_*.py"))]


def benchmark(build):
    return [Job("tests/benchmark/test_score.py", ["python3", "tests/benchmark/test_score.py", build])]


def pages(build):
    return [Job(file, ["node", "--test-reporter=tap", file], {"BUILD": build})
            for file in sorted(glob.glob("tests/browser/*.test.mjs") + glob.glob("tests/clients/*.test.mjs"))]


def every_day(build):
    """What `make check` runs."""
    short = [job for job in programs(build, SIZE_SHORT, ("exact", "unit", "server"))
             if not is_one_of(job, build, WAITING)]
    return checks(build) + short + replays(build) + bats(build, "tests/http/drapes.bats")


def is_one_of(job, build, files):
    return any(job.name.startswith(f"{build} tests/{file}") for file in files)


def everything(build, sanitized):
    """What `make test` runs. The page runs in the browser, not in the daemon, and deploy/ is about
    the daemon as users install it: once is enough. The second build is made beside the first tests."""
    jobs = checks(build)
    for each, size in ((build, "1"), (sanitized, SIZE_SHORT)):
        once = programs(each, size) + replays(each) + faults(each) + imports(each)
        once += bats(each, "tests/http/*.bats")
        alone, other = PLAIN_ALONE, SANITIZED_ALONE
        if each == sanitized:
            alone, other = other, alone
            for job in once:
                job.needs = sanitized
        jobs += [job for job in once
                 if is_one_of(job, each, alone) or not is_one_of(job, each, other)]
    jobs += benchmark(build) + pages(build) + bats(build, "tests/deploy/*.bats")
    return jobs + [Job("tests/hosts/hosts.sh", ["tests/hosts/hosts.sh", build, "200"])]


def build_for(jobs, build):
    """What builds the programs that these jobs need beyond `build`, as a job that comes first."""
    command = ["nice", "make", "--no-print-directory", "-s", f"-j{CORES}", f"B={build}", ".sanitized"]
    return [Job(name, command, {"MAKEFLAGS": ""}, one_test=True)
            for name in sorted({job.needs for job in jobs if job.needs})] + jobs


def idle_seconds():
    """Of all processors since the machine started, waiting for disks included."""
    with open("/proc/stat") as stat:
        idle, disks = stat.readline().split()[4:6]
    return (int(idle) + int(disks)) / os.sysconf("SC_CLK_TCK")


class Run:
    """The jobs that wait, run and have ended."""

    def __init__(self, jobs, folder):
        self.waiting = sorted(jobs, key=lambda job: (job.name not in {j.needs for j in jobs}, job.rank()))
        self.total = len(jobs)
        self.running = {}  # by process id: job, file of output, start
        self.ended = []
        self.folder = folder
        self.begun = self.news = self.looked = time.monotonic()
        self.idled = self.idle_before = idle_seconds()

    def start(self, job):
        output = tempfile.TemporaryFile(dir=self.folder)
        process = subprocess.Popen(job.command, stdin=subprocess.DEVNULL, stdout=output,
                                   stderr=subprocess.STDOUT, env={**os.environ, **job.env},
                                   start_new_session=True)
        self.running[process.pid] = (job, output, time.monotonic(), process)

    def has_room(self):
        """Whether the processors idled since the last look, by the work of all that runs."""
        now, idled = time.monotonic(), idle_seconds()
        if now - self.looked < LOOK:
            return False
        idle = (idled - self.idled) / (now - self.looked)
        self.looked, self.idled = now, idled
        return idle > IDLE

    def next_job(self):
        """Takes the first job whose program is built; None while there is none."""
        built = {job.name for job in self.ended if not job.failed} | {""}
        ready = [job for job in self.waiting if job.needs in built]
        if not ready:
            return None
        self.waiting.remove(ready[0])
        return ready[0]

    def start_what_fits(self):
        """One job a processor, and another one whenever there is room."""
        while self.waiting and (len(self.running) < CORES
                                or len(self.running) < MOST and self.has_room()):
            job = self.next_job()
            if not job:
                return
            self.start(job)

    def drop_unbuilt(self):
        """What cannot be built cannot pass."""
        broken = {job.name for job in self.ended if job.failed}
        for job in [job for job in self.waiting if job.needs in broken]:
            self.waiting.remove(job)
            job.failed, job.text = 1, f"# {job.needs} could not be built\n"
            self.ended.append(job)

    def end(self, pid, status, usage):
        job, output, begun, process = self.running.pop(pid)
        process.returncode = 0  # it has been waited for
        output.seek(0)
        job.text += output.read().decode(errors="replace")
        output.close()
        job.seconds = time.monotonic() - begun
        job.cpu = usage.ru_utime + usage.ru_stime
        job.count(None if job.seconds > LONGEST else os.waitstatus_to_exitcode(status))
        self.ended.append(job)
        self.tell(job)

    def tell(self, job):
        self.news = time.monotonic()
        counts = f"{job.passed:4d} passed {job.failed:3d} failed"
        counts += f" {job.skipped:3d} skipped" if job.skipped else ""
        print(f"[{len(self.ended):3d}/{self.total}] {job.name:50s} {counts}"
              f" {job.seconds:6.1f} s", flush=True)
        if job.failed:
            print(job.text, flush=True)

    def tell_what_runs(self):
        now = time.monotonic()
        if now - self.news < STILL:
            return
        self.news = now
        names = [f"{job.name} ({now - begun:.0f} s)" for job, _, begun, _ in self.running.values()]
        print(f"[{len(self.ended):3d}/{self.total}] runs: {', '.join(names)}", flush=True)

    def stop_late(self):
        """Ends what has used its time: first asked, then killed."""
        for pid, (_, _, begun, _) in self.running.items():
            late = time.monotonic() - begun - LONGEST
            if late > 0:
                os.killpg(pid, signal.SIGTERM if late < 10 else signal.SIGKILL)

    def all(self):
        while self.waiting or self.running:
            self.start_what_fits()
            self.drop_unbuilt()
            pid, status, usage = os.wait4(-1, os.WNOHANG)
            if pid in self.running:
                self.end(pid, status, usage)
            elif pid == 0:
                self.stop_late()
                self.tell_what_runs()
                time.sleep(0.02)

    def try_alone(self):
        """What failed and runs daemons, once more, one after the other."""
        for job in [job for job in self.ended
                    if job.failed and any(part in job.name for part in DAEMONS)]:
            self.ended.remove(job)
            self.waiting = [job.again()]
            self.all()

    def stop(self):
        for pid in self.running:
            os.killpg(pid, signal.SIGKILL)

    def summary(self):
        """Prints what failed again, what took longest, and the sums."""
        for job in self.ended:
            if job.failed:
                print(f"---- {job.name}\n{job.text}")
        alone = [job.name for job in self.ended if job.tries > 1 and not job.failed]
        if alone:
            print("failed beside others, passed alone:", ", ".join(alone))
        print("the twenty that took longest, and what they took of a processor:")
        for job in sorted(self.ended, key=lambda job: -job.seconds)[:20]:
            print(f"{job.seconds:6.1f} s {job.cpu:6.1f} s  {job.name}")
        seconds, idle = time.monotonic() - self.begun, idle_seconds() - self.idle_before
        print(f"{seconds:.0f} s, of the processors {sum(job.cpu for job in self.ended):.0f} s; "
              f"they idled {100 * idle / (CORES * seconds):.0f} %")
        passed, failed, skipped = (sum(getattr(job, what) for job in self.ended)
                                   for what in ("passed", "failed", "skipped"))
        print(f"{passed} passed, {failed} failed" + (f", {skipped} skipped" if skipped else ""))
        return 1 if failed or not passed else 0


def main(kind, build, sanitized="", pattern=""):
    os.chdir(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
    jobs = every_day(build) if kind == "check" else everything(build, sanitized)
    jobs = build_for([job for job in jobs if re.search(pattern, job.name)], build)
    with tempfile.TemporaryDirectory() as folder:
        run = Run(jobs, folder)
        try:
            run.all()
            run.try_alone()
        finally:
            run.stop()
    if os.environ.get("DRAPED_TEST_TIMES"):
        with open(os.environ["DRAPED_TEST_TIMES"], "a") as file:
            for job in run.ended:
                print(f"{job.seconds:.1f}\t{job.cpu:.1f}\t{job.name}", file=file)
    return run.summary()


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
