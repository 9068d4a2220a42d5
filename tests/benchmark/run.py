#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Drapes every case of the open benchmark by every method, scores the nets, writes the scores to
benchmark/results.csv and prints the tables of benchmark/README.md.

Usage: run.py DRAPE FOLDER [TOOL...]    FOLDER is for the nets; with tools, those alone: of the others, and of FreeCAD
where it is not installed, scores stay as they are"""
import csv
import gzip
import io
import json
import os
import pathlib
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
CASES = ROOT / "benchmark" / "cases"
NAMES = ["cylinder", "cone", "hat", "torus", "folds", "dome", "sphere", "saddle", "mould", "rational",
         "freeform", "blade"]
METHODS = ["gib", "gib4", "geodesic", "basic", "mosaic"]
KINDRAPE, ABAQUS, FREECAD = "KinDrape", "Abaqus", "FreeCAD"
TOOLS = [*METHODS, KINDRAPE, ABAQUS, FREECAD]
COLUMNS = ["nodes", "missing", "coverage", "distance_median", "distance_p95", "distance_max", "distance_max_spacings",
           "shear_error_median_deg", "shear_error_max_deg", "edge_min_percent", "edge_max_percent", "seconds"]
sys.path.append(str(ROOT / "benchmark"))
import kinematic  # noqa: E402
import score  # noqa: E402


def request(folder, task, method):
    """The drape request of a case; the extent on both sides of the start, for faces may be turned over."""
    path = folder / task["geometry"]
    reach = {c: max(map(abs, task["extent"][c])) for c in ("warp", "weft")}
    start = {"uv": task["start_uv"]} if "start_uv" in task else {"point": task["start"]}
    surface = json.loads(path.read_text()) if path.suffix == ".json" else {
        "file": str(path), **({"unit": task["length_unit"]} if path.suffix == ".stl" else {})}
    fabric = {"spacing": task["spacing"]}
    if task["pre_shear_deg"]:
        fabric["pre_shear_deg"] = task["pre_shear_deg"]
    return {"surface": surface, "length_unit": task["length_unit"], "fabric": fabric, "start": start,
            "direction": {"vector": task["warp"]}, "method": method,
            "extent": {c: [-n, n] for c, n in reach.items()}}


def drape(program, document):
    """The nodes as CSV and the seconds of the solver."""
    done = subprocess.run([program, "-"], input=json.dumps(document), capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{program}: {done.stderr}{done.stdout}")
    result = json.loads(done.stdout)
    nodes, text = result["nodes"], io.StringIO()
    columns = ["i", "j", "x", "y", "z", "shear_deg"]
    csv.writer(text).writerows([columns, *zip(*(nodes[c] for c in columns))])
    return text.getvalue(), result["summary"]["timing_ms"]["solve"] / 1e3


def tools(program, folder, task):
    """What drapes a case: {name: function that gives a net and its seconds, or None}."""
    found = {method: (lambda method=method: drape(program, request(folder, task, method)))
             for method in METHODS if not (task["geometry"].endswith(".stl") and method == "gib4")}
    found[KINDRAPE] = lambda: kinematic.drape(folder)
    if folder.name == "blade":
        course = ROOT / "tests" / "validation" / "geodesic_course.csv.gz"
        found[ABAQUS] = lambda: (gzip.open(course, "rt").read(), None)
    return found


def flatten(nets):
    """FreeCAD's nets of all cases, in one run, for FreeCAD takes seconds to start."""
    script = ROOT / "benchmark" / "flatten.py"
    subprocess.run(["freecadcmd", str(script)], env={**os.environ, "CASES": str(CASES), "NETS": str(nets)},
                   stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, check=True)
    return json.loads((nets / "seconds.json").read_text())


def kept():
    """The scores of results.csv."""
    with open(ROOT / "benchmark" / "results.csv", newline="") as file:
        return {(row["case"], row["tool"]): {c: float(row[c]) if "." in row[c] or "e" in row[c] else
                                             int(row[c]) if row[c] else None for c in COLUMNS}
                for row in csv.DictReader(file)}


def scores(program, nets, chosen):
    """{(case, tool): scores}"""
    found = {key: value for key, value in kept().items() if key[1] not in chosen}
    seconds = flatten(nets) if FREECAD in chosen else {}
    for name in NAMES:
        folder = CASES / name
        task = json.loads((folder / "task.json").read_text())
        if FREECAD in chosen and name in seconds:
            found[name, FREECAD] = score.score(folder, nets / f"{name}-FreeCAD.csv", seconds[name])
        for tool, make in tools(program, folder, task).items():
            made = make() if tool in chosen else None
            if made:
                path = nets / f"{name}-{tool}.csv"
                path.write_text(made[0])
                found[name, tool] = score.score(folder, path, made[1])
    return found


def write(found, path):
    with open(path, "w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["case", "tool", *COLUMNS])
        for name, tool in sorted(found, key=lambda key: (NAMES.index(key[0]), TOOLS.index(key[1]))):
            values = [found[name, tool][c] for c in COLUMNS]
            table.writerow([name, tool, *(f"{v:.3g}" if isinstance(v, float) else v for v in values)])


TABLES = [("largest distance from the exact net, in spacings", "distance_max_spacings", ".1e"),
          ("largest error of the shear angle, in degrees", "shear_error_max_deg", ".1e"),
          ("seconds", "seconds", ".2g")]


def tables(found):
    """Those of benchmark/README.md."""
    lines = []
    for title, column, form in TABLES:
        lines += ["", title, f"{'':10s}" + "".join(f"{tool:>11s}" for tool in TOOLS)]
        for name in NAMES:
            values = (found.get((name, tool), {}).get(column) for tool in TOOLS)
            lines.append(f"{name:10s}" + "".join(f"{'-' if v is None else format(v, form):>11s}" for v in values))
    return "\n".join(lines[1:]) + "\n"


def main():
    program, nets = sys.argv[1], pathlib.Path(sys.argv[2])
    nets.mkdir(parents=True, exist_ok=True)
    chosen = sys.argv[3:] or [tool for tool in TOOLS if tool != FREECAD or shutil.which("freecadcmd")]
    write(scores(program, nets, chosen), ROOT / "benchmark" / "results.csv")
    print(tables(kept()), end="")


if __name__ == "__main__":
    main()
