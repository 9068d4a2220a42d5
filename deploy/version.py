#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The version: one number for daemon, commands, solver, client and packages. solver/version.h has it, the
files of FOLLOWERS repeat it, and CHANGELOG.md has an entry for it, dated once it is released.

usage: version.py            prints it
       version.py --check    exits 1 when a file has another one, or the changelog no entry
       version.py NEW        raises it everywhere, and begins its entry; one that is not released gets the new number
       version.py --release  dates its entry today
       version.py --debian   prints the changelog as Debian's packages have it
"""

import datetime
import os
import re
import sys
import textwrap
import time

SOURCE = ("solver/version.h", r'#define DRAPE_VERSION "(.*)"')
FOLLOWERS = (("api/openapi.yaml", r"\n  version: (\S+)\n"),
             ("clients/python/draped.py", r'__version__ = "(.*)"'),
             ("clients/typescript/package.json", r'\n  "version": "(.*)"'),
             ("clients/mcp/package.json", r'\n  "version": "(.*)"'),
             ("clients/freecad/package.xml", r"<version>(.*)</version>"),
             ("deploy/kubernetes/kustomization.yaml", r"newTag: (\S+)"))
CHANGELOG = "CHANGELOG.md"
NUMBER = r"\d+\.\d+\.\d+(?:-rc\d+)?"
ENTRY = rf"^## ({NUMBER}) \((unreleased|\d{4}-\d\d-\d\d)\)\n(.*?)(?=^## |\Z)"
MAINTAINER = "The draped authors <maintainers@draped.invalid>"


def read(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


def write(path, text):
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)


def version_in(path, pattern):
    return re.search(pattern, read(path))[1]


def entries():
    """Of the changelog, the newest first: version, date, what changed as lines of a list."""
    found = re.findall(ENTRY, read(CHANGELOG), re.MULTILINE | re.DOTALL)
    return [(number, date, re.findall(r"^- (.*(?:\n  .*)*)", text, re.MULTILINE))
            for number, date, text in found]


def check(version):
    faults = [f"{path} has version {version_in(path, pattern)}, {SOURCE[0]} {version}"
              for path, pattern in FOLLOWERS if version_in(path, pattern) != version]
    newest = entries()[0]
    if newest[0] != version or not newest[2]:
        faults.append(f"{CHANGELOG} begins with {newest[0]}, {len(newest[2])} changes; the version is {version}")
    print(*faults, sep="\n", end="\n" if faults else "")
    return 1 if faults else 0


def raise_to(version):
    for path, pattern in (SOURCE, *FOLLOWERS):
        text = read(path)
        at = re.search(pattern, text)
        write(path, text[:at.start(1)] + version + text[at.end(1):])
    text = read(CHANGELOG)
    at = text.index("\n## ") + 1
    heading, rest = text[at:].split("\n", 1)
    if not heading.endswith(" (unreleased)"):
        rest = f"\n{heading}\n{rest}"
    write(CHANGELOG, f"{text[:at]}## {version} (unreleased)\n{rest}")
    return 0


def release(version):
    if check(version) != 0:
        return 1
    write(CHANGELOG, read(CHANGELOG).replace(f"## {version} (unreleased)",
                                             f"## {version} ({datetime.date.today()})", 1))
    return 0


def print_debian():
    for number, date, changes in entries():
        today = date == "unreleased"
        day = (time.gmtime(int(os.environ.get("SOURCE_DATE_EPOCH", time.time()))) if today
               else time.strptime(date, "%Y-%m-%d"))
        print(f"draped ({number.replace('-', '~')}) {'UNRELEASED' if today else 'unstable'}; urgency=medium\n")
        for change in changes:
            print(textwrap.fill(" ".join(change.split()), 78, initial_indent="  * ",
                                subsequent_indent="    ", break_on_hyphens=False))
        print(f"\n -- {MAINTAINER}  {time.strftime('%a, %d %b %Y %H:%M:%S +0000', day)}\n")
    return 0


def main():
    os.chdir(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
    version, wanted = version_in(*SOURCE), sys.argv[1] if len(sys.argv) > 1 else ""
    if wanted == "":
        return print(version)
    if wanted == "--debian":
        return print_debian()
    if re.fullmatch(NUMBER, wanted):
        return raise_to(wanted)
    if wanted in ("--check", "--release"):
        return (check if wanted == "--check" else release)(version)
    print(__doc__, file=sys.stderr)
    return 2


if __name__ == "__main__":
    sys.exit(main())
