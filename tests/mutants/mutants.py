#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Makes the mistakes of mutants.toml one at a time in a copy of the tree, builds it, and runs the
tests that ought to notice. A mutant is caught when a test fails or does not end in time; it survives
when all pass. One that does not build shows nothing, nor does a test that fails without any: the
tests are run so first. The exit status is 0 when all is well and every mutant was caught."""
import argparse
import glob
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib

HERE = os.path.dirname(os.path.abspath(__file__))
LONGEST = 300  # seconds of one test
PARTS = [f"build/tests/import/{maker}" for maker in ("make_parts", "make_splits")] # of tests of import
KEYS = {"file", "why", "from", "to", "tests"}
CAUGHT, SURVIVED, BROKEN, OPEN = "caught", "SURVIVED", "did not build", "not tried"


def split(test):
    """The source of a test, and what it is limited to: a part of names, or a request of known results."""
    name, _, part = test.partition(": ")
    path = f"tests/{name}"
    for source in (f"{path}.c", f"{path}.py", path):
        if os.path.isfile(source):
            return source, part
    return None, part


def test_faults(test):
    source, part = split(test)
    if source is None:
        return [f"the test {test} is not there"]
    if source.endswith(".bats") and not any(
            part in line for line in open(source) if line.startswith("@test")):
        return [f"no test of {source} has '{part}' in its name"]
    return []


def mutant_faults(mutant):
    if set(mutant) != KEYS or not mutant["tests"]:
        return [f"it must have {', '.join(sorted(KEYS))}"]
    if not os.path.isfile(mutant["file"]):
        return ["the file is not there"]
    count = open(mutant["file"]).read().count(mutant["from"])
    faults = [f"its text is there {count} times, not once"] if count != 1 else []
    if mutant["from"] == mutant["to"]:
        faults.append("it changes nothing")
    return faults + [fault for test in mutant["tests"] for fault in test_faults(test)]


def check(mutants):
    bad = 0
    for mutant in mutants:
        for fault in mutant_faults(mutant):
            print(f"mutant of {mutant.get('file')} ({mutant.get('why')}): {fault}")
            bad = 1
    return bad


def copy_tree(folder):
    """What git knows, as it is now, and the modules that npm fetched, which git does not know."""
    names = subprocess.run(["git", "ls-files", "-z", "-co", "--exclude-standard"], check=True,
                           capture_output=True, text=True).stdout.split("\0")
    for name in filter(os.path.isfile, names):
        to = os.path.join(folder, name)
        os.makedirs(os.path.dirname(to), exist_ok=True)
        shutil.copy2(name, to)
    for modules in glob.glob("**/node_modules", recursive=True):
        to = os.path.join(folder, modules)
        if os.path.isdir(os.path.dirname(to)) and "node_modules" not in os.path.dirname(modules):
            os.symlink(os.path.abspath(modules), to)


def build(targets):
    """The output of a build that failed, or None."""
    done = subprocess.run(["make", "-s", f"-j{os.cpu_count()}", "B=build", "WARN=-w", *targets],
                          stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True)
    return done.stdout if done.returncode else None


def targets_of(tests):
    sources = [split(test)[0] for test in tests]
    programs = [f"build/{source[:-2]}" for source in sources if source.endswith(".c")]
    return sorted(set(["all"] + programs + PARTS * any("import" in source for source in sources)))


def command_of(test):
    source, part = split(test)
    if source.endswith(".c"):
        return [f"build/{source[:-2]}"]
    if source.endswith(".py"):
        return ["/usr/bin/python3", source, *(["build", part] if part else [])]
    return ["bats", "--tap", *(["-f", part] if part else []), source]


def run_test(test, output):
    """Whether it passed; a test that does not end in time has failed."""
    environment = {**os.environ, "BUILD": "build", "DRAPED_TEST_SIZE": "0.1",
                   "CMOCKA_MESSAGE_OUTPUT": "TAP"}
    command = ["timeout", "-k", "10", str(LONGEST), *command_of(test)]
    with open(output, "w") as file:
        status = subprocess.run(command, stdin=subprocess.DEVNULL, stdout=file,
                                stderr=subprocess.STDOUT, env=environment).returncode
    return status == 0


def first_failure(output):
    lines = open(output, errors="replace").read().splitlines()
    return next((line for line in lines if line.startswith("not ok")), "ended early")


def try_mutant(mutant, original, output):
    """What became of it, and which test saw it."""
    with open(mutant["file"], "w") as file:
        file.write(original.replace(mutant["from"], mutant["to"]))
    try:
        log = build(targets_of(mutant["tests"]))
        if log is not None:
            return BROKEN, log.strip().splitlines()[0] if log.strip() else ""
        for test in mutant["tests"]:
            if not run_test(test, output):
                return CAUGHT, f"{test}: {first_failure(output)}"
        return SURVIVED, ", ".join(mutant["tests"])
    finally:
        with open(mutant["file"], "w") as file:
            file.write(original)


def run_without(mutants, output):
    """The tests that pass as long as nothing is changed; None when that does not build."""
    tests = sorted({test for mutant in mutants for test in mutant["tests"]})
    log = build(targets_of(tests))
    if log is not None:
        print(log)
        return None
    good = set()
    for test in tests:
        if run_test(test, output):
            good.add(test)
        else:
            print(f"fails without a mutant: {test}: {first_failure(output)}", flush=True)
    print(f"{len(good)} of {len(tests)} tests pass without a mutant", flush=True)
    return good


def run(mutants, folder):
    os.environ["PATH"] = "/usr/lib/ccache:" + os.environ["PATH"]
    os.environ["CCACHE_NOHASHDIR"] = "1"
    tree, output = os.path.join(folder, "tree"), os.path.join(folder, "output")
    copy_tree(tree)
    os.chdir(tree)
    good = run_without(mutants, output)
    if good is None:
        return 1
    count = dict.fromkeys((CAUGHT, SURVIVED, BROKEN, OPEN), 0)
    for number, mutant in enumerate(mutants, 1):
        begun = time.monotonic()
        mutant["tests"] = [test for test in mutant["tests"] if test in good]
        outcome, detail = OPEN, "its tests fail anyway"
        if mutant["tests"]:
            outcome, detail = try_mutant(mutant, open(mutant["file"]).read(), output)
        count[outcome] += 1
        print(f"[{number:3d}/{len(mutants)}] {outcome:13s} {mutant['file']}: {mutant['why']}\n"
              f"          {time.monotonic() - begun:.0f} s, {detail}", flush=True)
    print(", ".join(f"{many} {outcome.lower()}" for outcome, many in count.items()))
    return 0 if count[CAUGHT] == len(mutants) else 1


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("what", choices=("check", "run"), help="check: every text is in its file exactly once, "
                        "every test is there; run: make them")
    parser.add_argument("pattern", nargs="?", default="", help="a regular expression: those whose file or why has it")
    asked = parser.parse_args()
    os.chdir(os.path.join(HERE, "..", ".."))
    with open(os.path.join(HERE, "mutants.toml"), "rb") as file:
        mutants = tomllib.load(file)["mutant"]
    if check(mutants):
        return 1
    if asked.what == "check":
        return 0
    mutants = [mutant for mutant in mutants
               if re.search(asked.pattern, f"{mutant['file']}: {mutant['why']}")]
    with tempfile.TemporaryDirectory(prefix="draped-mutants-") as folder:
        return run(mutants, folder)


if __name__ == "__main__":
    sys.exit(main())
