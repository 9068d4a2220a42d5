#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Compares results byte by byte, by their digests, with those in tests/results/digests: the examples
and the requests of the tests, in all methods and formats, with patterns and maps, laminates
(laminates.json, each on the surface of another request) and studies (studies.json). The time that
solving took is made 0. Of a request that is refused what is said against it is compared: those of
tests/unit/bad_requests, and of refusals.json, which change another. A change that is meant is
written down with `make golden`.
Usage: compare.py BUILD [--write | REQUEST]: of that request alone, or of those "refused"; compare.py: which there are"""
import glob
import hashlib
import json
import os
import re
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

HERE = Path(__file__).parent
DIGESTS = HERE / "digests"
LONGEST = 60  # seconds of a drape

FORMATS = ["json", "csv", "csv --table cells", "vtp", "glb", "npz", "svg", "dxf --partial"]
MAP = " --map api/examples/mould.bdf"
MAPS = [f + MAP for f in ["json", "csv", "vtu", "lcmsim", "lcmsim --inlet 17,18", "csv --fields k1"]] + [
    "lcmsim --map tests/fuzz/corpus/map_json/mesh.json",
    "json --map tests/fuzz/corpus/map_json/points.json"]
WAYS = [{"method": m} for m in ["basic", "geodesic", "mosaic", "gib", "gib4"]] + [
    {"method": "gib", "yarn_path": "relaxation"}]
PERMEABLE = {"permeability": {"model": "gebart", "fiber_radius": 1e-5, "packing": "hexagonal"},
             "fabric": {"thickness": 0.01, "fiber_volume_fraction": 0.5}}
EXAMPLES = sorted(glob.glob("api/examples/*.json"))
REQUESTS = sorted(glob.glob("tests/requests/*.json"))
BAD_REQUESTS = sorted(glob.glob("tests/unit/bad_requests/*.json"))
SEEDS = sorted(glob.glob("tests/fuzz/corpus/run/*.json"))
OPTIONS = [f"json --precision {p}" for p in (1, 6, 17)] + [
    f"{f} --fields nodes.x,cells.shear_deg" for f in FORMATS[:6]]

ON_ROLLS = [f"{f} --partial" for f in ("dxf", "astm", "svg", "svg --width 9 --turn 0 --gap 0.01",
                                       "hpgl --roll 1", "laser", "laser-csv", "virtek")]
STACKS = [f + MAP for f in ("csv", "csv --table plies", "json", "lcmsim", "nastran", "abaqus", "compost", "acp", "gmsh", "unv",
                            "csv --reference 1,2,0 --cavity-height pid:1:0.004")]
SOLVERS = [f + MAP for f in ("abd", "calculix", "lsdyna", "optistruct", "radioss --reference 1,2,0",
                             "nastran --plies-as yarns", "nastran --plies-as bisector", "lims", "vtu", "lcmsim-h5")]
ELASTIC = {"plies": {"0": {"fabric": {"lamina": {"e1": 1.1e11, "e2": 6e9, "nu12": 0.3, "g12": 2e9}}}}}
BUNDLED = ("stack under pressure", "millimetres", "triangles")  # of a patch, of faces, of triangles
LAMINATES, STUDIES = ({each["name"]: each for each in json.loads((HERE / file).read_text())}
                      for file in ("laminates.json", "studies.json"))


def cases():
    """Every (request file, changes, output): changes as a merge patch, output as arguments."""
    for file in EXAMPLES + SEEDS:
        yield from ((file, {}, output) for output in FORMATS + ["html"])
        yield from ((file, PERMEABLE, output) for output in MAPS)
    for file in REQUESTS:
        yield from ((file, {}, output) for output in FORMATS[:4])
    for file in EXAMPLES + REQUESTS:
        if "triangles" not in json.loads(Path(file).read_text())["surface"]:
            yield from ((file, way, "json") for way in WAYS)
    for changes in json.loads((HERE / "changes.json").read_text()):
        outputs = FORMATS + MAPS if "permeability" in changes else FORMATS + MAPS[:3]
        yield from (("api/examples/saddle.json", changes, output) for output in outputs)
    yield from (("api/examples/freeform.json", {}, output) for output in OPTIONS)
    for threads in (1, 2, 5):
        yield "api/examples/sphere.json", {"fabric": {"spacing": 0.25}}, f"json --threads {threads}"
    for name in LAMINATES:
        yield from ((f"laminate: {name}", {}, output) for output in ["json", "html"] + ON_ROLLS + STACKS)
    yield from (("laminate: named pieces", ELASTIC, output) for output in SOLVERS)
    yield from ((f"laminate: {name}", {}, "bundle --partial") for name in BUNDLED)
    for name in STUDIES:
        yield from ((f"study: {name}", {}, output) for output in ["json", "csv", "json --variant 3"])
    yield from ((file, {}, "json") for file in BAD_REQUESTS)
    yield from ((f"refused {case['of']}", case["changes"], case["output"])
                for case in json.loads((HERE / "refusals.json").read_text()))


def request_of(file):
    """The bytes of a request, or of a laminate or a study by its name."""
    file = file.removeprefix("refused ")
    kind, _, name = file.partition(": ")
    if kind == "laminate":
        on = json.loads(Path(LAMINATES[name]["surface_of"]).read_text())
        own = {key: value for key, value in LAMINATES[name].items() if key not in ("name", "surface_of")}
        return json.dumps({"surface": on["surface"], "length_unit": on.get("length_unit", "m"), **own}).encode()
    if kind == "study":
        own = {key: value for key, value in STUDIES[name].items() if key not in ("name", "drape_of")}
        drape = json.loads(Path(STUDIES[name]["drape_of"]).read_text())
        return json.dumps({**own, "drape": patched(drape, own.get("drape", {}))}).encode()
    return Path(file).read_bytes()


def patched(value, patch):
    """RFC 7386: members of `patch` replace those of `value`, null removes them; numbers are places of a list."""
    if not isinstance(patch, dict):
        return patch
    if isinstance(value, list) and patch and all(key.isdigit() for key in patch):
        return [patched(each, patch[str(k)]) if str(k) in patch else each for k, each in enumerate(value)]
    merged = dict(value) if isinstance(value, dict) else {}
    for key, change in patch.items():
        if change is None:
            merged.pop(key, None)
        else:
            merged[key] = patched(merged.get(key), change)
    return merged


def group_of(case):
    """What the results of a case are compared with alone: those of its request, its maps, its bundle, or
    others that are refused."""
    file, _, output = case
    if file.startswith(("refused laminate", "refused study")):
        return file.partition(":")[0]
    if file.startswith("refused ") or file in BAD_REQUESTS:
        return "refused"
    return f"{file}, bundle" if output.startswith("bundle") else f"{file}, maps" if " --map " in output else file


def name_of(case):
    file, changes, output = case
    changed = " " + json.dumps(changes, separators=(",", ":")) if changes else ""
    return f"{file}{changed} {output}"


def digest_line(build, clock, case):
    """What tests/results/digests says of a case: digest or exit status, and the case."""
    file, changes, output = case
    request = request_of(file)
    if changes:
        request = json.dumps(patched(json.loads(request), changes)).encode()
    done = subprocess.run([f"{build}/drape", "--format", *output.split()], input=request,
                          capture_output=True, timeout=LONGEST,
                          env={**os.environ, "LD_PRELOAD": clock})
    said = hashlib.sha256(done.stdout).hexdigest()[:32] if done.returncode == 0 else \
        f"exit status {done.returncode} {hashlib.sha256(done.stderr).hexdigest()[:32]}"
    return f"{said} {name_of(case)}"


def compare(build, group):
    """The lines of all cases, or of those of a group up to the first that is another, and the same as they
    were."""
    chosen = [case for case in cases() if group in (None, group_of(case))]
    expected, names = DIGESTS.read_text().splitlines(), set(map(name_of, chosen))
    if group:
        expected = [line for line in expected if re.sub(r"^(exit status \d+ )?\w{32} ", "", line) in names]
    lines, known = [], set(expected)
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(os.cpu_count()) as pool:
        clock = os.path.join(folder, "stopped_clock.so")
        subprocess.run(["gcc", "-shared", "-fPIC", "-Wall", "-Werror", "-o", clock,
                        HERE / "stopped_clock.c"], check=True)
        for line in pool.map(lambda case: digest_line(build, clock, case), chosen):
            lines.append(line)
            if group and line not in known:
                pool.shutdown(cancel_futures=True)
                break
    return lines, expected


def main(build, write, group):
    lines, expected = compare(build, group)
    if write:
        DIGESTS.write_text("\n".join(lines) + "\n")
        return 0
    other = [line for line in lines if line not in set(expected)]
    missing = len(expected) - (len(lines) - len(other))
    print(f"{len(lines)} results: {len(other)} new or changed, {missing} expected ones missing",
          *other, sep="\n")
    return int(lines != expected)


if __name__ == "__main__":
    if len(sys.argv) == 1:
        print(*dict.fromkeys(map(group_of, cases())), sep="\n")
        sys.exit()
    asked = (sys.argv[2:] or [None])[0]
    sys.exit(main(sys.argv[1], asked == "--write", None if asked == "--write" else asked))
