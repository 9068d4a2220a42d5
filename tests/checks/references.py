# SPDX-License-Identifier: MIT
"""What Markdown files refer to: prints each link, heading, path or test that is not there.

A block behind the line <!-- figures of FILE --> repeats figures of that file: each of its numbers has
to stand there too.

Paths and tests are recognised in `code`: a path by the folder at the top of the tree that it starts
with, where * and {a,b} stand for several, or by the ending of a source file; a test by its name, test_MODULE_BEHAVIOUR. Names with such
words in capitals are to be filled in, and are skipped.
"""

import glob
import os
import re
import subprocess
import sys

TOP = ("api/", "benchmark/", "cli/", "deploy/", "docs/", "import/", "server/", "solver/", "tests/")
LINK = re.compile(r"\]\(([^)\s]+)\)")
CODE = re.compile(r"`([^`\s]+)`")
SOURCE = re.compile(r"[\w./-]+/[\w.-]+\.(?:c|cc|h|py|sh|bats|mjs)")
TEST = re.compile(r"test_\w+_\w+")
TWICE = re.compile(r"^<!-- figures of (\S+) -->\n+((?:.+\n)+)", re.M)
NUMBER = re.compile(r"\d[\d.,]*(?:e-?\d+)?\d|\d")
BLANK = re.compile(r"(?<![A-Z])(NAME|MODULE|BEHAVIOUR)(?![A-Z])")


def without_blocks(text):
    return re.sub(r"^```.*?^```", "", text, flags=re.M | re.S)


def headings(path):
    """The anchors of a file's headings, as GitHub makes them."""
    with open(path, encoding="utf-8") as file:
        lines = re.findall(r"^#+ (.*)$", without_blocks(file.read()), flags=re.M)
    return {re.sub(r"[^\w\- ]", "", line.lower()).replace(" ", "-") for line in lines}


def alternatives(pattern):
    found = re.search(r"\{([^{}]*)\}", pattern)
    if not found:
        return [pattern]
    return [
        one
        for part in found[1].split(",")
        for one in alternatives(pattern[: found.start()] + part + pattern[found.end() :])
    ]


def missing_links(path, text):
    for target in LINK.findall(text):
        if re.match(r"[a-z]+:", target):
            continue
        file, _, anchor = target.partition("#")
        where = os.path.normpath(os.path.join(os.path.dirname(path), file)) if file else path
        if not os.path.exists(where):
            yield target
        elif anchor and anchor not in headings(where):
            yield target


def missing_names(text, tests):
    for name in CODE.findall(text):
        if BLANK.search(name):
            continue
        if (name.startswith(TOP) or SOURCE.fullmatch(name)) and not all(glob.glob(one) for one in alternatives(name)):
            yield name
        elif TEST.fullmatch(name) and not re.search(rf"\b{name}\b", tests):
            yield name


def other_figures(path, text):
    """The numbers of marked blocks that the file which they are taken from does not have."""
    for file, block in TWICE.findall(text):
        with open(os.path.join(os.path.dirname(path), file), encoding="utf-8") as source:
            known = set(NUMBER.findall(source.read()))
        for number in NUMBER.findall(re.sub(r"\]\([^)]*\)|`[^`]*`", "", block)):
            if number not in known:
                yield f"the figure {number}, said to be of {file},"


def main():
    listed = subprocess.run(
        ["grep", "-rhoE", "--include=*.[ch]", r"\btest_\w+", "tests"], stdout=subprocess.PIPE, check=True
    )
    tests = listed.stdout.decode()
    bad = 0
    for path in sys.argv[1:]:
        with open(path, encoding="utf-8") as file:
            text = without_blocks(file.read())
        for name in [*missing_links(path, text), *missing_names(text, tests), *other_figures(path, text)]:
            print(f"{path}: {name} is not there")
            bad = 1
    return bad


sys.exit(main())
