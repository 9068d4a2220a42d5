#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""How good the search `optimise` is: on random free-form surfaces and the examples, its best largest
shear with 500 variants against that of a grid of starts and angles with many more, and of a search with
three times the budget.

Usage: study_quality.py BUILD [SURFACES [VARIANTS [NODES [FIRST]]]]; 20 surfaces from number FIRST (0)
on, grids of 4000 variants (0: none), nets of 900 nodes if not given. A line for each part, then in how
many the search was within 0.1 degrees of the least of all, or of the grid, and by how much above."""
import json
import random
import subprocess
import sys

EXAMPLES = ["freeform", "octant", "saddle", "torus", "hemisphere", "tray"]
BUDGET = 500
LONGER = 3


def run(build, drape, search, starts, angles, budget=BUDGET):
    study = {"drape": drape, "objectives": ["max_shear_deg"], "search": search, "budget": budget,
             "limits": {"cloth_coverage": {"min": 0.99}},
             "vary": {"start": {"grid": starts},
                      "angle_deg": {"from": 0, "to": 90 - 90 / angles, "step": 90 / angles}}}
    done = subprocess.run([f"{build}/drape", "-", "--fields",
                           "variants.max_shear_deg,variants.feasible"],
                          input=json.dumps(study), capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(done.stderr)
    result = json.loads(done.stdout)
    best = result["best"]["max_shear_deg"]
    return result["variants"]["max_shear_deg"][best], result["summary"]


def random_surface(number):
    """A bicubic over [0, 1] x [0, 0.5..1] whose control points are up to 0.05 to 0.2 high."""
    rng, n = random.Random(number), 6
    width, height = rng.uniform(0.5, 1), rng.uniform(0.05, 0.2)
    points = [[i / (n - 1), width * j / (n - 1), height * rng.random()]
              for i in range(n) for j in range(n)]
    return {"degree_u": 3, "degree_v": 3, "size_u": n, "size_v": n,
            "knotvector_u": [0, 0, 0, 0, 0.3, 0.6, 1, 1, 1, 1],
            "knotvector_v": [0, 0, 0, 0, 0.4, 0.7, 1, 1, 1, 1], "control_points": points}


def coarsened(build, drape, nodes):
    """The request with the spacing that gives about as many nodes, whatever it had."""
    drape["fabric"] = {"spacing": drape["fabric"]["spacing"]}
    drape.pop("permeability", None)
    drape.pop("extent", None)
    done = subprocess.run([f"{build}/drape", "-", "--fields", "nodes.i"], input=json.dumps(drape),
                          capture_output=True, text=True, check=True)
    area = json.loads(done.stdout)["summary"]["part_area"]
    drape["fabric"]["spacing"] = (area / nodes) ** 0.5
    return drape


def main():
    build = sys.argv[1]
    surfaces, variants, nodes, first = (list(map(int, sys.argv[2:])) + [20, 4000, 900, 0][len(sys.argv) - 2:])[:4]
    parts = [(f"random {k}", {"surface": random_surface(k), "fabric": {"spacing": 0.05}})
             for k in range(first, first + surfaces)]
    parts += [(name, json.load(open(f"api/examples/{name}.json"))) for name in EXAMPLES]
    angles = max(round(variants ** (1 / 3)), 17)
    above = {"grid": [], "least": []}
    for name, drape in parts:
        drape = coarsened(build, drape, nodes)
        found, mine = run(build, drape, "optimise", 1, angles)
        longer, _ = run(build, drape, "optimise", 1, angles, LONGER * BUDGET)
        grid = run(build, drape, "grid", variants // angles, angles)[0] if variants else float("nan")
        if variants:
            above["grid"].append(found - grid)
        above["least"].append(found - min(found, longer, *([grid] if variants else [])))
        print(f"{name:12} optimise {found:8.4f} deg of {mine['variants']}, {longer:8.4f} of "
              f"{LONGER * BUDGET}; grid of {variants} {grid:8.4f}", flush=True)
    for than, by in [(than, by) for than, by in above.items() if by]:
        print(f"within 0.1 degrees of the {than}, or below: {sum(x <= 0.1 for x in by)} of {len(by)}; "
              f"above by {sum(by) / len(by):.4f} degrees on the mean, {max(by):.4f} at the most")


main()
