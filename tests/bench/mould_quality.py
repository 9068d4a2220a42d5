#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""How good the search `optimise` is on CAD parts with fillets, nets of 2,800 nodes: the best largest shear
of 500 variants, against that of a grid of about so many, at the request's own spacing.

mould_quality.py BUILD VARIANTS [PART.step:FACE ...]: the moulds of make_moulds, and other parts by a face
of their tool side."""
import json
import math
import os
import subprocess
import sys
import tempfile

NODES, ANGLES, NEAR = 2800, 18, 0.5


def run(build, document, fields):
    done = subprocess.run([f"{build}/drape", "-", "--fields", fields], input=json.dumps(document),
                          capture_output=True, text=True)
    if done.returncode:
        sys.exit(done.stderr)
    return json.loads(done.stdout)


def top_of(build, path):
    """The highest plane face of a mould; all that joins it smoothly is the tool side."""
    done = subprocess.run([f"{build}/drape-import", "--list", path], capture_output=True, text=True)
    planes = [face for face in json.loads(done.stdout)["faces"] if face["kind"] == "plane"]
    return max(planes, key=lambda face: (round(face["bounding_box"][0][2], 3), face["area"]))["index"]


def best(build, drape, search, grid):
    result = run(build, {
        "drape": drape, "objectives": ["max_shear_deg"], "search": search,
        "limits": {"cloth_coverage": {"min": 0.99}},
        "vary": {"start": {"grid": grid}, "angle_deg": {"from": 0, "to": 85, "step": 5}}},
        "variants.max_shear_deg,variants.feasible")
    row = result["best"]["max_shear_deg"]
    return result["variants"]["max_shear_deg"][row]


def main():
    build, variants, given = sys.argv[1], int(sys.argv[2]), sys.argv[3:]
    within = []
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([f"{build}/tests/bench/make_moulds", folder], check=True)
        parts = [(path, top_of(build, path)) for path in
                 (os.path.join(folder, name) for name in sorted(os.listdir(folder)))]
        parts += [(path, int(face)) for path, face in (one.rsplit(":", 1) for one in given)]
        for path, face in parts:
            drape = {"surface": {"file": os.path.abspath(path), "grow_from": face}, "fabric": {"spacing": 8}}
            area = run(build, drape, "nodes.i")["summary"]["part_area"]
            drape["fabric"]["spacing"] = float(f"{math.sqrt(area / NODES):.2g}")
            found, grid = best(build, drape, "optimise", 1), best(build, drape, "grid", variants // ANGLES)
            within.append(found <= grid + NEAR)
            print(f"{os.path.basename(path):16} optimise {found:8.3f}  grid {grid:8.3f}", flush=True)
    print(f"within {NEAR} degrees of the grid, or below: {sum(within)} of {len(within)}")


main()
