#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Turns api/openapi.yaml into a C header with its JSON text: embed_openapi.py IN.yaml OUT.h"""

import json
import sys

import yaml


def main(source, target):
    with open(source, encoding="utf-8") as file:
        document = yaml.safe_load(file)
    text = json.dumps(document, separators=(",", ":")).encode("ascii") + b"\0"
    rows = (text[k : k + 20] for k in range(0, len(text), 20))
    lines = ["    " + ", ".join(str(byte) for byte in row) + "," for row in rows]
    with open(target, "w", encoding="ascii") as file:
        file.write("/* Made by api/embed_openapi.py from api/openapi.yaml. */\n")
        file.write("static const char openapi_json[] = {\n" + "\n".join(lines) + "\n};\n")


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2])
