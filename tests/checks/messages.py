#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""All messages of draped in one list, to be read in one go: the sentences among the strings of the
programs and of the page, by file. Compares them with tests/checks/messages.txt, or writes that file
(--write), and prints the messages that use a private word of this code.

A sentence is a string of two words or more that is not SQL, markup or a line of a deck. %s and its
like stand for inserted values. Usage: tests/checks/messages.py [--write]"""

import difflib
import pathlib
import re
import subprocess
import sys

LIST = pathlib.Path("tests/checks/messages.txt")
TOKEN = re.compile(r'/\*.*?\*/|//[^\n]*|\'(?:\\.|[^\'\\])\'|^[ \t]*#[ \t]*include[^\n]*|"(?:\\.|[^"\\\n])*"', re.S | re.M)
SCRIPT = re.compile(r"/\*.*?\*/|(?<![:\w])//[^\n]*|\"(?:\\.|[^\"\\\n])*\"|'(?:\\.|[^'\\\n])*'|`(?:\\.|[^`\\])*`", re.S)
TEXT = re.compile(r"(?<=>)[^<>]+(?=<)|(?<=\s)(?:title|placeholder|aria-label|alt|data-help)=\"([^\"]*)\"")
BETWEEN = re.compile(r"\s*(?:PRI\w+\s*)?")  # of the pieces of one string
# SQL, markup, styles, shaders, lines of decks, headers of HTTP and of systemd.
NO_SENTENCE = re.compile(r"^\s*(SELECT|INSERT|UPDATE|DELETE|CREATE|DROP|WITH|PRAGMA|BEGIN|COMMIT|VALUES|AND|OR"
                         r"|WHERE|FROM|SET|ORDER|UNION|ON|RETURNING|LISTEN|NOTIFY|COPY|JOIN|LEFT|EXISTS|CASE)\b"
                         r"|\b(NOT NULL|THEN|ELSE|END AS|MATERIALIZED|RETURNING|INSERT INTO|IF NOT EXISTS|WHERE|DECLARE|UNIQUE|AS now)\b"
                         r"|\b(?:void|vec[234]|discard)\b|\{[a-z-]+:|\\n\d+\\n|max-age|no-cache|^(?:axis|curve|dot) [a-z ]+$|^Bearer |^STOPPING|^RELOADING"
                         r"|^\s*[<{$*#/.,;:&|=\[(\\]")
ASSERTION = re.compile(r"_Static_assert\(.*?\);", re.S)  # read by who compiles
MARK = re.compile(r"(?:\b(?:class|className|classes)\b[^;\"'`]{0,40})$")  # of an element of the page: its classes
WORDS = re.compile(r"[A-Za-z][a-z]+,? [a-z]{2,}|[A-Za-z] [a-z]{3,} [a-z]{2,}")
# Words of this code, or of nobody.
PRIVATE = re.compile(r"\b(sign of life|(?<!there )is no(?! longer)|which no cloth|out of step|bears?|astray|told|sought|hub|nursery|desk|shelf|shelves"
                     r"|station|lane|so many|so long|not ours|parted by|alike|gives? way"
                     r"|goes? with|leaves? nothing|is there twice|(?:shows?|showed|shown) life|on the way"
                     r"|hangs? on|passed over|of which nothing|nor has|as are left|for everybody else)\b")


def strings(text):
    """The strings of a C source, pieces joined."""
    text, found, end = ASSERTION.sub("", text), None, 0
    for match in TOKEN.finditer(text):
        if not match[0].startswith('"'):
            continue
        if found is not None and BETWEEN.fullmatch(text, end, match.start()):
            found += ("%s" if "PRI" in text[end:match.start()] else "") + match[0][1:-1]
        else:
            if found is not None:
                yield found
            found = match[0][1:-1]
        end = match.end()
    if found is not None:
        yield found


def of_page(path, text):
    """The strings of a script or the texts of a page; values that are put in as %s."""
    for match in (TEXT if path.endswith(".html") else SCRIPT).finditer(text):
        if path.endswith(".html"):
            yield re.sub(r"\s+", " ", match[1] or match[0]).strip()
        elif not match[0].startswith("/") and not MARK.search(text, max(0, match.start() - 60), match.start()):
            yield re.sub(r"\$\{[^}]*\}", "%s", re.sub(r"\s+", " ", match[0][1:-1]))


def sentences(path):
    text = pathlib.Path(path).read_text(encoding="utf-8")
    for string in of_page(path, text) if path.endswith((".js", ".html")) else strings(text):
        if WORDS.search(string) and not NO_SENTENCE.search(string):
            yield string.strip().removesuffix("\\n")


def main(write):
    files = subprocess.run(["git", "ls-files", "--", *(f"{top}/*.{end}" for top in ("solver", "api", "cli", "import", "server")
                                                      for end in ("c", "h", "cc", "js", "html"))],
                           stdout=subprocess.PIPE, check=True).stdout.decode().split()
    lines, bad = [], 0
    for path in files:
        said = list(dict.fromkeys(sentences(path)))
        lines += [path, *(f"    {one}" for one in said), ""] if said else []
        for one in said:
            if found := PRIVATE.search(one):
                print(f"{path}: \"{one}\" says \"{found[0]}\"")
                bad = 1
    if write:
        LIST.write_text("\n".join(lines), encoding="utf-8")
        return bad
    before = LIST.read_text(encoding="utf-8").split("\n")
    for line in difflib.unified_diff(before, lines, str(LIST), "the programs", n=0, lineterm=""):
        print(line)
        bad = 1
    if bad:
        print("read what has changed as a stranger would; `make golden` writes the list anew")
    return bad


sys.exit(main("--write" in sys.argv[1:]))
