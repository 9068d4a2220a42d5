# SPDX-License-Identifier: MIT
"""Splits at random on a cylinder and a saddle: split_cases.py DRAPE ROUNDS SEED.

Unrolled, a quarter of a cylinder is a rectangle. A split that is a
straight line of it, half of an overlap h beyond it on each side, has closed forms: cloth is not
sheared, areas are those of polygons, and beyond a split of length L, which meets the edges under the
angles a and pi - a, there is L h - h^2 / 2 (cot a - (pi / 2 - a)) of cloth. On a saddle, where cloth is
sheared, areas are those of no closed form, but what is left of both pieces without their overlap is
what butt pieces have, and the overlap is as wide as asked for."""
import json
import random
import subprocess
import sys
from math import atan2, cos, hypot, pi, sin, sqrt, tan

DRAPE, ROUNDS, SEED = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
RADIUS, HEIGHT = 60, 80


def patch(rows, weights=None):
    """A NURBS patch without inner knots of rows of control points."""
    size_u, size_v = len(rows), len(rows[0])
    points = {"points": [p for row in rows for p in row]}
    if weights:
        points["weights"] = [w for row in weights for w in row]
    return {"degree_u": size_u - 1, "degree_v": size_v - 1, "size_u": size_u, "size_v": size_v,
            "knotvector_u": [0] * size_u + [1] * size_u, "knotvector_v": [0] * size_v + [1] * size_v,
            "control_points": points}


def pieces(surface, path, spacing, seam, direction=0):
    ply = {"fabric": {"spacing": spacing}, "direction": {"angle_deg": direction}, "method": "gib",
           "splits": [{"path": path}], **({"seam": seam} if seam else {})}
    asked = json.dumps({"surface": surface, "plies": [ply]})
    answer = subprocess.run([DRAPE, "-"], input=asked, capture_output=True, text=True)
    said = json.loads(answer.stdout)["plies"][0] if answer.returncode == 0 else {}
    if len(said.get("seams", [])) != 1:
        sys.exit(f"no seam: {answer.stderr}{json.dumps(said)} of {asked}")
    return said["cloth_coverage"], sorted(p["area"] for p in said["pieces"]), said["seams"][0]


def near(what, value, wanted, tolerance, case):
    if not abs(value - wanted) <= tolerance:
        sys.exit(f"{what} is {value}, not {wanted} within {tolerance}: {case}")


def between(a, b, count=60):
    return [[a[0] + (b[0] - a[0]) * k / count, a[1] + (b[1] - a[1]) * k / count]
            for k in range(count + 1)]


def cylinder(rng):
    """A quarter; unrolled RADIUS pi / 2 by HEIGHT, split from side to side."""
    w, width = sqrt(0.5), RADIUS * pi / 2
    arc = [[RADIUS, 0], [RADIUS, RADIUS], [0, RADIUS]]
    surface = patch([[[*p, 0], [*p, HEIGHT]] for p in arc], [[1, 1], [w, w], [1, 1]])
    low, high = (rng.uniform(0.25, 0.75) * HEIGHT for _ in range(2))
    path = [[RADIUS * cos(s / RADIUS), RADIUS * sin(s / RADIUS), z]
            for s, z in between([0, low], [width, high])]
    area = width * (low + high) / 2
    return surface, path, area, width * HEIGHT - area, hypot(width, high - low), \
        pi / 2 - abs(atan2(high - low, width))


def saddle(rng):
    """z = x y / 100 on a square, split from side to side by a plane."""
    surface = patch([[[x, y, x * y / 100] for y in (-40, 40)] for x in (-40, 40)])
    low, high = (rng.uniform(-15, 15) for _ in range(2))
    return surface, [[x, y, x * y / 100] for x, y in between([-40, low], [40, high])]


rng = random.Random(SEED)
for round in range(ROUNDS):
    spacing, overlap, gap = rng.uniform(1.5, 5), rng.uniform(1, 8), rng.uniform(0.5, 3)
    turn = rng.choice([0, 90, rng.uniform(0, 90)])
    case = f"seed {SEED}, round {round}, spacing {spacing}, overlap {overlap}, gap {gap}, turn {turn}"
    surface, path, one, other, length, angle = cylinder(rng)
    whole = one + other
    coverage, areas, seam = pieces(surface, path, spacing, None, turn)
    near("coverage", coverage, 1, 0, case)
    near("an area of the cylinder", areas[0], min(one, other), 2e-4 * whole, case)
    near("an area of the cylinder", areas[1], max(one, other), 2e-4 * whole, case)
    near("the length", seam["length"], length, 2e-3 * length, case)
    h = overlap / 2
    more = length * h - h * h / 2 * (1 / tan(angle) - (pi / 2 - angle))
    coverage, wider, seam = pieces(surface, path, spacing, {"overlap": overlap}, turn)
    near("what overlaps", seam["overlap_area"], 2 * more, 4e-3 * length, case)
    near("what is added", sum(wider) - sum(areas), 2 * more, 4e-3 * length, case)
    near("a gap beside an overlap", seam["gap_area"], 0, 0, case)
    coverage, fewer, seam = pieces(surface, path, spacing, {"gap": gap}, turn)
    near("the gap's width", seam["gap_width"], gap, 2e-3 * gap + 0.4 * gap**2 / length, case)
    near("coverage beside a gap", coverage, 1 - length * gap / whole, 2e-3, case)

    surface, path = saddle(rng)
    coverage, areas, seam = pieces(surface, path, spacing, None, turn)
    near("coverage of the saddle", coverage, 1, 0, case)
    coverage, wider, seam = pieces(surface, path, spacing, {"overlap": overlap}, turn)
    near("an overlap of the saddle", sum(wider) - sum(areas), seam["overlap_area"], 1e-6, case)
    near("its width", seam["overlap_width"], overlap, 0.03 * overlap + overlap**2 / 80, case)
    near("its gap", seam["gap_area"], 0, 0, case)
print(f"{ROUNDS} rounds")
