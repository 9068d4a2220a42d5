#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Turns api/materials/*.json into a C header: embed_materials.py OUT.h FILE..."""

import json
import os
import sys

KEYS = {"name", "about", "source", "example", "areal_weight", "fabric", "permeability", "compaction",
        "price"}
SHOWN = ("name", "about", "source", "example")


def read(path):
    with open(path, encoding="utf-8") as file:
        material = json.load(file)
    name = os.path.basename(path).removesuffix(".json")
    if material["name"] != name or set(material) - KEYS or not all(k in material for k in SHOWN):
        sys.exit(f"{path}: a material has its file's name, about, source and example, and of the rest "
                 f"only {sorted(KEYS)}")
    return material


def dump(value):
    """JSON in ASCII."""
    return json.dumps(value, separators=(",", ":"))


def literal(text):
    """ASCII as a C string."""
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def main(target, paths):
    materials = [read(path) for path in sorted(paths)]
    heads = ",".join(dump({key: m[key] for key in SHOWN} | {"own": False}) for m in materials)
    with open(target, "w", encoding="ascii") as file:
        file.write("/* Made by api/embed_materials.py from api/materials. */\n")
        file.write(f"static const char materials_heads[] = {literal(heads)};\n")
        file.write("static const struct api_material materials[] = {\n")
        for m in materials:
            text = literal(dump(m))
            file.write(f'    {{"{m["name"]}", "{m["about"]}",\n     {text},\n     sizeof {text} - 1}},\n')
        file.write("};\n")


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:])
