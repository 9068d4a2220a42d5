#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""How good the search `optimise` is: on random free-form surfaces and the examples, its best largest
shear with 500 variants against that of a grid of starts and angles with many more.

Usage: study_quality.py BUILD [SURFACES [VARIANTS [NODES [FIRST]]]]; 20 surfaces from number FIRST (0)
on, grids of 4000 variants, nets of 400 nodes if not given. A line for each part, then in how many the
search was within 0.1 degrees of the grid, or better, and by how much on the mean."""
import json
import random
import subprocess
import sys

EXAMPLES = ["freeform", "octant", "saddle", "torus", "hemisphere", "tray"]
BUDGET = 500


def run(build, drape, search, starts, angles):
    study = {"drape": drape, "objectives": ["max_shear_deg"], "search": search, "budget": BUDGET,
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
    surfaces, variants, nodes, first = (list(map(int, sys.argv[2:])) + [20, 4000, 400, 0][len(sys.argv) - 2:])[:4]
    parts = [(f"random {k}", {"surface": random_surface(k), "fabric": {"spacing": 0.05}})
             for k in range(first, first + surfaces)]
    parts += [(name, json.load(open(f"api/examples/{name}.json"))) for name in EXAMPLES]
    near, gain, angles = 0, 0, round(variants ** (1 / 3))
    for name, drape in parts:
        drape = coarsened(build, drape, nodes)
        found, mine = run(build, drape, "optimise", 1, angles)
        grid, _ = run(build, drape, "grid", variants // angles, angles)
        near += found - grid <= 0.1
        gain += (grid - found) / len(parts)
        print(f"{name:12} optimise {found:8.4f} deg of {mine['variants']}; grid of {variants} "
              f"{grid:8.4f}", flush=True)
    print(f"within 0.1 degrees of the grid, or better: {near} of {len(parts)}; "
          f"lower by {gain:.2f} degrees on the mean")


main()
