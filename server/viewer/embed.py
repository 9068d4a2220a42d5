#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Collects the files of the page for the binary: embed.py OUT_DIR FILE...

Writes OUT_DIR/viewer.bin, all files one after the other, each as it is and packed with gzip, and
OUT_DIR/viewer_files.h, the table of what lies where. The page's own address has a digest of all
files in it, so that browsers may keep them for good.
"""

import gzip
import hashlib
import os
import sys

TYPES = {
    ".html": "text/html; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".json": "application/json",
    ".svg": "image/svg+xml",
}


def read(path):
    """The file's bytes. Modules of three.js name the library as bundlers do; browsers need its
    address."""
    with open(path, "rb") as file:
        content = file.read()
    if "node_modules" in path:
        content = content.replace(b"from 'three';", b"from './three.module.min.js';")
    return content


def main(target, paths):
    files = {os.path.basename(path): read(path) for path in sorted(paths)}
    if len(files) != len(paths):
        sys.exit("two files of the page have one name")
    digest = hashlib.sha256()
    for name, content in files.items():
        digest.update(b"%s %d\n%s" % (name.encode(), len(content), content))
    digest = digest.hexdigest()[:16]
    page = files["index.html"].replace(b"@FILES@", b"viewer/" + digest.encode())
    files["index.html"] = page

    store, rows = b"", []
    for name, content in files.items():
        packed = gzip.compress(content, 9, mtime=0)
        kind = TYPES[os.path.splitext(name)[1]]
        rows.append(
            '    {"%s", "%s", %d, %d, %d, %d},'
            % (name, kind, len(store), len(content), len(store) + len(content), len(packed))
        )
        store += content + packed
    binary = os.path.join(target, "viewer.bin")
    with open(binary, "wb") as file:
        file.write(store)
    with open(os.path.join(target, "viewer_files.h"), "w", encoding="ascii") as file:
        file.write("/* Made by server/viewer/embed.py. */\n")
        file.write('#define VIEWER_DIGEST "%s"\n#define VIEWER_BINARY "%s"\n' % (digest, binary))
        file.write("static const struct viewer_file viewer_files[] = {\n")
        file.write("\n".join(rows) + "\n};\n")


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:])
