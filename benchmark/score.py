#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Scores the net of any draping tool against the exact net of a case. Nothing but Python is needed.

    score.py CASE NET.csv [--seconds S] [--json]

CASE is a folder of cases/. NET.csv has one row a node: i and j, counted from the start along warp and
weft, x, y and z, and the shear angle if there is one (shear_deg or shear_rad). Tools number nodes as they
like, so signs of i, j and shear, which family is called warp, where counting begins and the unit of
length are found from the net itself; what had to be assumed is said. A net that is none of the case's,
whichever way it is read, is refused with the reason.

Exit status: 0 scored, 1 the net cannot be scored, 2 wrong arguments."""
import argparse
import csv
import json
import math
import pathlib
import statistics
import sys

UNITS = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "in": 0.0254, "ft": 0.3048, "um": 1e-6}
STRETCH = 0.12  # by which the median edge may miss the spacing before that is taken for another unit
SMALL_SHEAR_DEG = 0.5  # cloth sheared by less tells neither sign nor unit
# The same net with its families renamed: new (i, j) from (i, j), whether that turns the sign of shear,
# and how it is said. The first is preferred to all others that fit as well.
READINGS = [(1, 1, False), (-1, 1, False), (1, -1, False), (-1, -1, False),
            (1, 1, True), (-1, 1, True), (1, -1, True), (-1, -1, True)]


class Refused(Exception):
    """The net cannot be scored; the message says why and what to do."""


def number(text, line, column):
    try:
        return float(text)
    except ValueError:
        raise Refused(f"line {line}: {column} is {text!r}, not a number") from None


def index(text, line, column):
    value = number(text, line, column)
    if value != round(value) if math.isfinite(value) else True:
        raise Refused(f"line {line}: {column} is {text!r}, not a whole number of cells")
    return int(value)


def read_table(path):
    """The columns by name and the rows as (line, cells) of a CSV file; `,`, `;`, tabs and blanks separate."""
    try:
        text = pathlib.Path(path).read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise Refused(f"{path} cannot be read: {error}") from None
    lines = [(k, line) for k, line in enumerate(text.splitlines(), 1)
             if line.strip() and not line.lstrip().startswith("#")]
    if not lines:
        raise Refused(f"{path} is empty")
    head = lines[0][1]
    mark = next((m for m in ",;\t" if m in head), None)
    split = (lambda line: next(csv.reader([line], delimiter=mark))) if mark else str.split
    names = [name.strip().lower() for name in split(head)]
    rows = [(k, [cell.strip() for cell in split(line)]) for k, line in lines[1:]]
    missing = [name for name in "ijxyz" if name not in names]
    if missing:
        raise Refused(f"no column {', '.join(missing)}: the first line has to name the columns i, j, x, y, z "
                      f"and, if there is one, shear_deg or shear_rad; it is {head.strip()!r}")
    return {name: at for at, name in enumerate(names)}, rows


def read_net(path):
    """{(i, j): (x, y, z)}, {(i, j): shear} in degrees or None, and what was left out."""
    column, rows = read_table(path)
    shear_name = next((name for name in ("shear_deg", "shear_rad", "shear") if name in column), None)
    nodes, shear, said, blank = {}, {}, [], 0
    for line, cells in rows:
        if len(cells) < len(column):
            raise Refused(f"line {line}: {len(cells)} values for {len(column)} columns")
        key = tuple(index(cells[column[c]], line, c) for c in "ij")
        if any(cells[column[c]] == "" for c in "xyz"):
            place = (math.nan,)
        else:
            place = tuple(number(cells[column[c]], line, c) for c in "xyz")
        if not all(map(math.isfinite, place)):
            blank += 1
            continue
        if key in nodes:
            raise Refused(f"line {line}: node {key} is there twice")
        nodes[key] = place
        if shear_name and cells[column[shear_name]] != "":
            value = number(cells[column[shear_name]], line, shear_name)
            if math.isfinite(value):
                shear[key] = math.degrees(value) if shear_name == "shear_rad" else value
    if blank:
        said.append(f"{blank} nodes without a place are taken as missing")
    if not nodes:
        raise Refused("the net has no node")
    return nodes, shear, said


def edges(nodes):
    """The lengths between neighbours along both families."""
    return [math.dist(p, nodes[k]) for (i, j), p in nodes.items()
            for k in ((i + 1, j), (i, j + 1)) if k in nodes]


def scale_of(nodes, task, said):
    """The factor from the net's unit to the task's, by the lengths of edges."""
    lengths = edges(nodes)
    if not lengths:
        raise Refused("no two nodes are neighbours: i and j count cells, and each step is 1")
    ratio = statistics.median(lengths) / task["spacing"]
    own = UNITS[task["length_unit"]]
    for name, unit in sorted(UNITS.items(), key=lambda entry: entry[1] != own):
        if abs(ratio * unit / own - 1) < STRETCH:
            if unit != own:
                said.append(f"lengths are in {name}, the task's in {task['length_unit']}")
            return unit / own
    raise Refused(f"edges are {ratio:.3g} times the spacing of {task['spacing']:g} {task['length_unit']}, "
                  "which is no unit's factor: drape with the task's spacing")


def readings(nodes, task, exact):
    """Each way to read i and j as (median distance, order, map of the net's keys to the exact ones, the
    node at the start), but those with less than half of the nodes in common that another has."""
    start = task["start"]
    zero = min(nodes, key=lambda key: math.dist(nodes[key], start))
    gap = math.dist(nodes[zero], start)
    if gap > 0.5 * task["spacing"]:
        raise Refused(f"no node lies at the start {tuple(start)}: the nearest, {zero}, is "
                      f"{gap / task['spacing']:.3g} spacings away. Check frame and unit, and start there")
    ways = []
    for si, sj, swapped in READINGS:
        steps = {(i, j): (si * (i - zero[0]), sj * (j - zero[1])) for i, j in nodes}
        keys = {k: (b, a) if swapped else (a, b) for k, (a, b) in steps.items()}
        ways.append((keys, [math.dist(nodes[k], exact[e]) for k, e in keys.items() if e in exact]))
    most = max(len(apart) for _, apart in ways)
    return [(statistics.median(apart), order, keys, zero) for order, (keys, apart) in enumerate(ways)
            if 2 * len(apart) >= most]


def match(nodes, task, exact, said):
    """The net by the exact net's keys, by the way to read it that is nearest, and whether that turns the
    sign of shear."""
    found = sorted(readings(nodes, task, exact), key=lambda reading: reading[:2])
    least = found[0][0]
    # Symmetric nets fit in more than one way: of those the first in order.
    close = [r for r in found if r[0] <= 1.001 * least + 1e-9 * task["spacing"]]
    apart, order, keys, zero = min(close, key=lambda reading: reading[1])
    si, sj, swapped = READINGS[order]
    if zero != (0, 0):
        said.append(f"node {zero} is the start, (0, 0) of the task")
    if swapped:
        said.append("what the net calls i counts along weft, j along warp")
    for sign, name in ((si, "i"), (sj, "j")):
        if sign < 0:
            said.append(f"{name} counts the other way")
    if apart > task["spacing"]:
        said.append(f"WARNING: half of the nodes are more than {apart / task['spacing']:.2g} spacings away "
                    "in the best reading: is it this task's start, direction and frame?")
    return keys, si * sj < 0


def net_shear(nodes, key):
    """The shear at a node by central differences along both yarns, in degrees; None at the net's edge."""
    i, j = key
    around = [nodes.get(k) for k in ((i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1))]
    if None in around:
        return None
    a, b = ([p - q for p, q in zip(around[k], around[k + 1])] for k in (0, 2))
    cosine = sum(p * q for p, q in zip(a, b)) / (math.hypot(*a) * math.hypot(*b) or math.inf)
    return 90 - math.degrees(math.acos(max(-1, min(1, cosine))))


def shear_errors(nodes, shear, exact, exact_shear, turned, said):
    """Absolute differences of shear angles at common nodes, in degrees."""
    if not shear:
        said.append("the net has no shear: it is taken from the nodes, by central differences")
        own = {key: net_shear(nodes, key) for key in nodes}
        return [abs(s - exact_shear[k]) for k, s in own.items() if s is not None and k in exact_shear]
    common = [k for k in shear if k in exact_shear]
    if not common:
        return []
    ways = {"": lambda s: -s if turned else s, "shear has the other sign": lambda s: s if turned else -s,
            "shear is in radians": lambda s: math.degrees(-s if turned else s),
            "shear is in radians, with the other sign": lambda s: math.degrees(s if turned else -s)}
    wanted = {w: exact_shear for w in ways}
    if min(shear[k] for k in common) >= 0:
        for name, way in (("shear has no sign", abs), ("shear has no sign and is in radians",
                                                       lambda s: math.degrees(abs(s)))):
            ways[name] = way
            wanted[name] = {k: abs(s) for k, s in exact_shear.items()}
    errors = {w: sorted(abs(way(shear[k]) - wanted[w][k]) for k in common) for w, way in ways.items()}
    best = min(errors, key=lambda w: statistics.fmean(errors[w]))
    most = max(abs(exact_shear[k]) for k in common)
    if most < SMALL_SHEAR_DEG or statistics.fmean(errors[""]) <= 1.001 * statistics.fmean(errors[best]):
        best = ""
    if best:
        said.append(best)
    return errors[best]


def cells(nodes):
    return {(i, j) for i, j in nodes if {(i + 1, j), (i, j + 1), (i + 1, j + 1)} <= nodes.keys()}


def share(values, part):
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(part * len(ordered)))]


def score(case, path, seconds=None):
    """The scores of a net as a dictionary; `assumed` lists what was assumed to read it."""
    folder = pathlib.Path(case)
    task = json.loads((folder / "task.json").read_text())
    exact, exact_shear, _ = read_net(folder / task["net"]["file"])
    given, given_shear, said = read_net(path)
    factor = scale_of(given, task, said)
    given = {k: tuple(factor * c for c in p) for k, p in given.items()}
    keys, turned = match(given, task, exact, said)
    nodes = {keys[k]: p for k, p in given.items()}
    shear = {keys[k]: s for k, s in given_shear.items()}
    common = [k for k in nodes if k in exact]
    apart = [math.dist(nodes[k], exact[k]) for k in common]
    lengths = [100 * (length / task["spacing"] - 1) for length in edges(nodes)]
    sheared = shear_errors(nodes, shear, exact, exact_shear, turned, said)
    wanted = cells(exact)
    return {
        "case": folder.resolve().name, "unit": task["length_unit"],
        "nodes": len(nodes), "missing": len(exact) - len(common), "beyond": len(nodes) - len(common),
        "coverage": len(cells(nodes) & wanted) / len(wanted),
        "distance_median": statistics.median(apart), "distance_p95": share(apart, 0.95),
        "distance_max": max(apart), "distance_max_spacings": max(apart) / task["spacing"],
        "shear_error_median_deg": statistics.median(sheared) if sheared else None,
        "shear_error_max_deg": max(sheared) if sheared else None,
        "edge_min_percent": min(lengths), "edge_max_percent": max(lengths),
        "exact_error": task["net"]["error"], "geometry_error": task["net"].get("geometry_error", 0.0),
        "seconds": seconds, "assumed": said}


def text(result):
    unit = result["unit"]

    def angle(value):
        return "unknown" if value is None else f"{value:.3g}"
    lines = [
        f"nodes      {result['nodes']}, of the exact net {result['missing']} missing, {result['beyond']} beyond it",
        f"coverage   {100 * result['coverage']:.2f} % of its cells",
        f"distance   median {result['distance_median']:.3g}, 95 % {result['distance_p95']:.3g}, largest "
        f"{result['distance_max']:.3g} {unit}, which is {result['distance_max_spacings']:.2g} spacings",
        f"shear      median error {angle(result['shear_error_median_deg'])}, largest "
        f"{angle(result['shear_error_max_deg'])} degrees",
        f"edges      {result['edge_min_percent']:+.3f} to {result['edge_max_percent']:+.3f} % of the spacing",
        f"exact net  known to {result['exact_error']:.1e} {unit}" + (
            f"; the geometry is within {result['geometry_error']:.1e} {unit} of its surface"
            if result["geometry_error"] else "")]
    if result["seconds"] is not None:
        lines.append(f"time       {result['seconds']:.4g} s, as given")
    return "\n".join(lines + [f"assumed    {said}" for said in result["assumed"]])


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("case", help="a folder of cases/")
    parser.add_argument("net", help="the net to score, CSV")
    parser.add_argument("--seconds", type=float, help="the time that the tool took, to be kept with the scores")
    parser.add_argument("--json", action="store_true", help="the scores as JSON")
    options = parser.parse_args(arguments)
    if not (pathlib.Path(options.case) / "task.json").is_file():
        parser.error(f"{options.case} is no case: it has no task.json")
    try:
        result = score(options.case, options.net, options.seconds)
    except Refused as reason:
        print(f"score.py: {options.net}: {reason}", file=sys.stderr)
        return 1
    print(json.dumps(result, indent=1) if options.json else text(result))
    return 0


if __name__ == "__main__":
    sys.exit(main())
