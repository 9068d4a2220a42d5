#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Makes small mistakes at random, one at a time, and runs the tests that run the line where each is,
those first that take least time, until one notices. A mistake is a point of points.py; the tests of a
line are known from one run of all of them that counts lines. One object is compiled for a mistake, and
one library linked, which all programs load; no file of the tree is changed. Only tests that run what
has changed are counted again.

A mistake that no test notices within --seconds of tests survives. Those that nothing can notice are in
equivalents.toml with the reason; they are listed as such, and count neither way, as do those that do
not compile. The exit status is 0 when at least 85 % of what is left were noticed."""
import argparse
import array
import collections
import glob
import json
import os
import random
import re
import resource
import shlex
import shutil
import signal
import subprocess
import sys
import time
import tomllib

import points

HERE = os.path.dirname(os.path.abspath(__file__))
TOP = os.path.normpath(os.path.join(HERE, "..", ".."))
FOLDERS = ("api", "server", "solver")
SHARE = 0.85  # of mistakes that have to be noticed
LONGEST = 300  # seconds of processor time of a test
SLOWER = 6  # times what it took by the clock a test may take, and half a minute
CAUGHT, SURVIVED, EQUIVALENT, BROKEN = "caught", "SURVIVED", "equivalent", "did not build"


class Library:
    """What the programs of the tests load, in which one file at a time is changed."""

    def __init__(self, build):
        self.build = build
        self.original = os.path.join(build, "libmutable.so")
        self.loaded = os.path.join(build, "loaded", "libmutable.so")
        os.makedirs(os.path.dirname(self.loaded), exist_ok=True)
        self.make("mutable")
        self.remove()  # else there is nothing to do
        self.compile, self.link = map(shlex.split, self.make("-n", "mutant", "FILE=FOLDER/NAME.c").splitlines()[-2:])
        self.restore()

    def make(self, *goals):
        """What it prints."""
        done = subprocess.run(["make", "--no-print-directory", "-s", f"B={self.build}", *goals],
                              stdin=subprocess.DEVNULL, capture_output=True, text=True)
        if done.returncode:
            sys.exit(done.stdout + done.stderr)
        return done.stdout

    def remove(self):
        if os.path.lexists(self.loaded):
            os.remove(self.loaded)

    def restore(self):
        self.remove()
        os.symlink(os.path.abspath(self.original), self.loaded)

    def mutate(self, file, text):
        """What the compiler says against it, or None."""
        with open(os.path.join(self.build, "mutant.c"), "w") as out:
            out.write(f'#line 1 "{file}"\n{text}')
        self.remove()
        own = os.path.join(self.build, file[:-2] + ".o")
        for command in ([word.replace("FOLDER", os.path.dirname(file)) for word in self.compile],
                        [word for word in self.link if word != own]):
            done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True,
                                  env={**os.environ, "CCACHE_DISABLE": "1"})  # it has mixed mistakes up
            if done.returncode:
                return done.stderr
        return None


class Test:
    """A program, a file of bats or the results of a request: its name, how it is run, what it took and ran."""

    def __init__(self, name, command, made_of, build):
        self.name, self.command, self.made_of, self.build = name, command, made_of, build
        self.folder = os.path.join(build, "lines", name)
        self.seconds, self.elapsed, self.passed = 0.0, LONGEST, False

    def run(self, counts, longest):
        """Whether it passes, each process within the time; it is stopped at the first failure. Lines
        are counted below `counts`."""
        environment = {**os.environ, "BUILD": self.build, "DRAPED_TEST_SIZE": "0.1",
                       "CMOCKA_MESSAGE_OUTPUT": "TAP", "GCOV_PREFIX": os.path.abspath(counts),
                       "GCOV_PREFIX_STRIP": str(os.path.abspath(self.build).count("/"))}
        if self.command[0] == "bats":
            environment["LD_PRELOAD"] = os.path.abspath(f"{self.build}/watched.so")
        limit = resource.RLIMIT_CPU, (int(longest), int(longest) + 5)
        process = subprocess.Popen(["timeout", "-k", "5", str(30 + SLOWER * int(self.elapsed)), *self.command],
                                   stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True,
                                   stderr=subprocess.DEVNULL, env=environment, errors="replace",
                                   start_new_session=True, preexec_fn=lambda: resource.setrlimit(*limit))
        failed = any(line.startswith("not ok") for line in process.stdout)
        if failed:
            end_session(process.pid)
        return process.wait() == 0 and not failed

    def is_counted(self):
        """Whether it passed when it was counted, and neither it nor what it runs has changed since."""
        note = os.path.join(self.folder, "note.json")
        ran = glob.glob(f"{self.folder}/**/*.gcda", recursive=True)
        objects = (f"{self.build}/{os.path.relpath(path, self.folder)[:-5]}.o" for path in ran)
        return os.path.isfile(note) and json.load(open(note))["passed"] and all(
            os.path.isfile(path) and os.path.getmtime(path) < os.path.getmtime(note)
            for path in (*self.made_of, *objects))

    def count(self):
        """Runs it as it is, unless that is known."""
        note = os.path.join(self.folder, "note.json")
        if not self.is_counted():
            shutil.rmtree(self.folder, ignore_errors=True)
            os.makedirs(self.folder)
            begun, clock = time_of_children(), time.monotonic()
            passed = self.run(self.folder, LONGEST)
            spent = time_of_children() - begun
            for path in glob.glob(f"{self.folder}/**/*.gcda", recursive=True):
                if not has_counts(path):
                    os.remove(path)  # else a change of any object would have all tests counted again
            with open(note, "w") as file:
                json.dump({"seconds": spent, "elapsed": time.monotonic() - clock, "passed": passed}, file)
            print(f"{spent:6.1f} s {self.name}", flush=True)
        self.__dict__.update(json.load(open(note)))

    def lines(self, files):
        """Of the files those lines that it ran, and those that have code."""
        counted = []
        for file in files:
            stem = os.path.join(self.folder, file[:-2])
            if os.path.isfile(f"{stem}.gcda"):
                if not os.path.lexists(f"{stem}.gcno"):
                    os.symlink(os.path.abspath(f"{self.build}/{file[:-2]}.gcno"), f"{stem}.gcno")
                counted.append(f"{stem}.gcda")
        done = subprocess.run(["gcov", "--json-format", "--stdout", *counted], capture_output=True,
                              text=True) if counted else None
        for text in done.stdout.splitlines() if done else ():
            for file in json.loads(text)["files"]:
                if file["file"] in files:
                    counts = collections.Counter()  # of all clones of a function
                    for line in file["lines"]:
                        counts[line["line_number"]] += line["count"]
                    yield file["file"], counts


def has_counts(path):
    """Whether a .gcda says that anything ran: the length of counters that are all zero is negative."""
    counters, words, at = 0x01a10000, array.array("i"), 4
    with open(path, "rb") as file:
        words.frombytes(file.read())
    while at + 1 < len(words) and not (words[at] == counters and words[at + 1] > 0):
        at += 2 + max(words[at + 1], 0) // 4
    return at + 1 < len(words)


def time_of_children():
    """Seconds of processor time that tests have taken, those of them that have ended."""
    times = os.times()
    return times.children_user + times.children_system


def end_session(leader):
    """All that a test has started: daemons outlive the shell that began them."""
    for path in glob.glob("/proc/[0-9]*/stat"):
        try:
            fields = open(path).read().rpartition(")")[2].split()
            if int(fields[3]) == leader:
                os.kill(int(path.split("/")[2]), signal.SIGKILL)
        except (OSError, IndexError):
            continue


class Lines:
    """Which tests run a line, and how often which noticed a mistake of a file."""

    def __init__(self, tests, files):
        self.of = collections.defaultdict(lambda: collections.defaultdict(list))
        self.code = collections.defaultdict(set)
        self.noticed = collections.Counter()
        for test in tests:
            for file, counts in test.lines(set(files)):
                self.code[file].update(counts)
                for line in (line for line, count in counts.items() if count):
                    self.of[file][line].append(test)

    def tests(self, file, point):
        """Those that are quick or have noticed others first. Code of several lines counts for its
        first; data, for the file."""
        if point.body:
            line = max((line for line in self.code[file] if line <= point.line), default=0)
            tests = self.of[file][line]
        else:
            tests = {id(test): test for tests in self.of[file].values() for test in tests}.values()
        return sorted(tests, key=lambda test: test.seconds / (1 + self.noticed[file, test.name]))


def shown(source, at, end, text):
    """The lines around a point, with that text in its place, in one line."""
    begin, stop = source.rfind("\n", 0, at) + 1, source.find("\n", end)
    return " ".join((source[begin:at] + text + source[end:stop]).split())


def equivalents():
    with open(os.path.join(HERE, "equivalents.toml"), "rb") as file:
        return {(each["file"], each["line"], each["becomes"]): each["why"]
                for each in tomllib.load(file).get("equivalent", [])}


def faults_of_equivalents():
    """Those whose line is gone."""
    return [f"equivalents.toml: {file} has no line '{line}'" for file, line, _ in equivalents()
            if not os.path.isfile(file) or line not in " ".join(open(file).read().split())]


def choose(files, count, each, seed):
    """So many mistakes in all, or of each file, or all those of a line FILE:LINE: file, its text, a
    point and what stands there instead."""
    choice = random.Random(seed)
    every = [[(file, source, point) for point in points.points_of(source) if line in ("", str(point.line))]
             for file, _, line in (asked.partition(":") for asked in files) for source in [open(file).read()]]
    if all(":" in file for file in files):
        return [(*mistake, other) for mistake in sum(every, []) for other in mistake[2].others]
    if not each:
        every = [sum(every, [])]
    chosen = [mistake for of in every for mistake in choice.sample(of, min(each or count, len(of)))]
    return [(*each, choice.choice(each[2].others)) for each in sorted(chosen, key=lambda e: (e[0], e[2].at))]


def notice(mistake, library, tests, seconds):
    """What became of a mistake, and who noticed."""
    file, source, point, other = mistake
    said = library.mutate(file, source[:point.at] + other + source[point.end:])
    if said is not None:
        return BROKEN, next((line for line in said.splitlines() if "error:" in line), said[:200])
    spent, counts = 0.0, os.path.join(library.build, "unread")
    for number, test in enumerate(tests):
        spent += test.seconds
        if spent > max(seconds, test.seconds):
            return SURVIVED, f"{number} of the {len(tests)} tests that run it"
        if not test.run(counts, 5 + 4 * test.seconds):
            return CAUGHT, test.name
    return SURVIVED, f"all {len(tests)} tests that run it" if tests else "no test runs it"


def try_all(chosen, library, lines, seconds):
    """Of each file how many came to which end."""
    known, count = equivalents(), collections.defaultdict(collections.Counter)
    for number, mistake in enumerate(chosen, 1):
        file, source, point, other = mistake
        line, becomes = (shown(source, point.at, point.end, text)
                         for text in (source[point.at:point.end], other))
        why = known.get((file, line, becomes))
        outcome, detail = (EQUIVALENT, why) if why else notice(
            mistake, library, lines.tests(file, point), seconds)
        count[file][outcome] += 1
        lines.noticed[file, detail] += outcome == CAUGHT
        print(f"[{number}/{len(chosen)}] {outcome} {file}:{point.line} {point.kind}: {detail}")
        if outcome == SURVIVED:
            print(f"    line = '{line}'\n    becomes = '{becomes}'")
        sys.stdout.flush()
    return count


def report(count):
    """The shares by file and in all; the exit status."""
    total = collections.Counter()
    for file, each in sorted(count.items()):
        total += each
        print(f"{share(each)}  {file}")
    print(f"{share(total)}  all; {total[EQUIVALENT]} equivalent, {total[BROKEN]} did not build")
    return 0 if total[CAUGHT] >= SHARE * (total[CAUGHT] + total[SURVIVED]) else 1


def share(each):
    tried = each[CAUGHT] + each[SURVIVED]
    return f"{each[CAUGHT]:4d} of {tried:4d} noticed, {100 * each[CAUGHT] / max(tried, 1):3.0f} %"


def every_test(build):
    """What notices mistakes: programs, files of bats, and requests whose results are known."""
    for kind in ("unit", "server", "store", "exact"):
        for source in sorted(glob.glob(f"tests/{kind}/test_*.c")):
            program = f"{build}/{source[:-2]}"
            yield Test(f"{kind}/{os.path.basename(source)}", [program], [f"{program}.o"], build)
    for source in sorted(glob.glob("tests/http/*.bats")):
        yield Test(f"http/{os.path.basename(source)}", ["bats", "--tap", source], [source], build)
    compare = "tests/results/compare.py"
    for request in subprocess.run(["python3", compare], capture_output=True, text=True, check=True).stdout.splitlines():
        yield Test(f"results/{request}", ["python3", compare, build, request], [compare], build)


def tests_named(pattern, build):
    """Those in whose name the pattern is found, run as they are where that was not done."""
    tests = [test for test in every_test(build) if re.search(pattern, test.name)]
    for test in tests:
        test.count()
        if not test.passed:
            print(f"fails without a mistake: {test.name}", flush=True)
    return [test for test in tests if test.passed]


def sources():
    """Of all of api, server and solver what the library has."""
    return sorted(file for folder in FOLDERS for file in glob.glob(f"{folder}/**/*.c", recursive=True)
                  if not re.match("api/clients|server/(main.c|viewer)", file))


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--build", default="build/mutable", help="folder of the build (build/mutable)")
    parser.add_argument("--count", type=int, default=100, help="how many mistakes in all (100)")
    parser.add_argument("--each", type=int, help="how many of each file instead")
    parser.add_argument("--seed", type=int, default=int(time.time()) % 100000, help="of the choice (the time)")
    parser.add_argument("--seconds", type=float, default=200,
                        help="of processor time of tests for one mistake (200)")
    parser.add_argument("--tests", default="", help="a regular expression: only tests in whose name it is found")
    parser.add_argument("--check", action="store_true", help="only whether equivalents.toml still fits")
    parser.add_argument("files", nargs="*", help="C files, or lines of them FILE:LINE (all of api, server and solver)")
    return parser.parse_args()


def main():
    asked = arguments()
    os.chdir(TOP)
    if asked.check:
        faults = faults_of_equivalents()
        print(*faults, sep="\n", end="\n" if faults else "")
        return 1 if faults else 0
    library = Library(asked.build)
    tests = tests_named(asked.tests, asked.build)
    chosen = choose(asked.files or sources(), asked.count, asked.each, asked.seed)
    print(f"seed {asked.seed}: {len(chosen)} mistakes in {len({each[0] for each in chosen})} files", flush=True)
    lines = Lines(tests, {each[0] for each in chosen})
    try:
        return report(try_all(chosen, library, lines, asked.seconds))
    finally:
        library.restore()


if __name__ == "__main__":
    sys.exit(main())
