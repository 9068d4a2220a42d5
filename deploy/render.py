#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes the files of deploy/ in which settings and routes of the daemon occur: caps on bodies, memory
of pods, time-outs, paths. Each is its template in deploy/templates, where {{name}} stands for a value
(`values`), {{name:m}} for one in MiB. Settings are what the daemon prints, routes what api/openapi.yaml
says of them. With --check nothing is written: exits 1 when a file is not what it would be.
Usage: render.py DRAPED [--check]
"""
import difflib
import glob
import os
import re
import subprocess
import sys

import yaml

TEMPLATES = "deploy/templates"
INSIDE = ("/healthz", "/readyz", "/metrics")  # not for callers from elsewhere
MARGIN_SECONDS = 30  # of a proxy over the longest that an answer is held
BESIDE_BYTES = 256 << 20  # what the daemon takes beside bodies, checks and jobs
GIB = 1 << 30

def settings(draped, variables):
    """What the daemon makes of these variables; numbers as integers."""
    text = subprocess.run([draped, "--check-config"], capture_output=True, text=True, check=True,
                          env={"DRAPED_ALLOW_ANONYMOUS": "1", **variables}).stdout
    pairs = (line.split(" = ", 1) for line in text.splitlines())
    return {name: int(value) if value.isdigit() else value for name, value in pairs}


def operations(description):
    for path, item in description["paths"].items():
        for method, operation in item.items():
            if method in ("get", "post", "put", "delete"):
                yield path, operation


def pattern(path):
    return "^" + re.sub(r"\{[^}]*\}", "[^/]+", path) + "$"


def locations(template, given):
    """nginx's locations beside `/`: its directives and some of their own, for bodies of meshes and for
    event streams."""
    common = re.search(r"    location / \{\n(.*?)\n    \}\n", template, re.DOTALL)[1]
    common = "\n".join(line for line in common.splitlines() if line and "#" not in line)
    blocks = []
    for note, paths, own in (
            ("A mesh to map onto may be larger: --max-mesh.", given["large"],
             "client_max_body_size {{max_mesh:m}}m;"),
            ("Server-sent events arrive when they are sent.", given["streams"],
             "proxy_buffering off;\n        gzip off;")):
        blocks += [f"    # {note}\n    location ~ {pattern(path)} {{\n{common}\n        {own}\n    }}"
                   for path in paths]
    return "\n\n".join(blocks)


def ingress_paths(paths):
    """The fewest rules that let these paths through: by their first segment."""
    rules = []
    for path in paths:
        first, more = re.match(r"(/[^/]*)(/?)", path).groups()
        rule = (first + "/", "Prefix") if more else (first, "Exact")
        if rule not in rules:
            rules.append(rule)
    return "\n".join(f"          - path: {path}\n            pathType: {kind}\n"
                     "            backend: {service: {name: draped-api, port: {name: http}}}"
                     for path, kind in sorted(rules, key=lambda rule: -len(rule[0].rstrip("/"))))


def values(draped):
    with open("api/openapi.yaml", encoding="utf-8") as file:
        description = yaml.safe_load(file)
    every = list(operations(description))
    known = settings(draped, {})
    large = sorted({path for path, each in every if each.get("x-body-limit") == "max_mesh"})
    streams = sorted({path for path, each in every
                      if "text/event-stream" in each["responses"].get("200", {}).get("content", {})})
    wait = max(parameter["schema"]["maximum"] for _, each in every
               for parameter in each.get("parameters", []) if parameter.get("name") == "wait")
    return {"max_body": known["max-body"], "max_mesh": known["max-mesh"],
            "wait": wait, "patience": wait + MARGIN_SECONDS, "large": large, "streams": streams,
            "large_pattern": "|".join(pattern(path) for path in large),
            "paths": ingress_paths(path for path in description["paths"] if path not in INSIDE)}


def memory(draped, template):
    """The limit of the pod, by what its settings let it hold; in whole GiB."""
    pod = next(yaml.safe_load_all(re.sub(r"\{\{\w+\}\}", "", template)))["spec"]["template"]["spec"]
    known = settings(draped, {each["name"]: each["value"] for each in pod["containers"][0]["env"]
                              if "value" in each and each["name"] != "DRAPED_TOKENS"})
    most = ((known["workers"] + 1) * known["job-memory"] if known["role"] == "worker"
            else known["max-bodies"] + known["check-memory"])
    return f"{-(-(most + BESIDE_BYTES) // GIB)}Gi"


def render(draped, template, given):
    def value(match):
        name, unit = match.groups()
        found = memory(draped, template) if name == "memory" else given[name]
        return str(found >> 20 if unit else found)
    if "{{locations}}" in template:
        template = template.replace("{{locations}}", locations(template, given))
    return re.sub(r"\{\{(\w+)(:m)?\}\}", value, template)


def rendered(draped):
    """The files and what they are to hold."""
    given = values(draped)
    for path in sorted(glob.glob(f"{TEMPLATES}/**", recursive=True)):
        if os.path.isfile(path):
            with open(path, encoding="utf-8") as file:
                yield os.path.join("deploy", os.path.relpath(path, TEMPLATES)), render(draped, file.read(), given)


def main():
    draped, check, same = os.path.abspath(sys.argv[1]), "--check" in sys.argv, True
    os.chdir(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
    for path, wanted in rendered(draped):
        with open(path, "r" if check else "w", encoding="utf-8") as file:
            if check:
                found = file.read()
                same &= found == wanted
                sys.stdout.writelines(difflib.unified_diff(found.splitlines(True), wanted.splitlines(True),
                                                           path, "by its template"))
            else:
                file.write(wanted)
    return 0 if same else 1


if __name__ == "__main__":
    sys.exit(main())
