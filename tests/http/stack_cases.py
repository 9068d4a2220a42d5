#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""
Eleven laminates on a plane, where a drape is known: every ply has its pre-shear everywhere and its
warp in its direction. All that `drape --map` says of the stack is worked out here again, from the
formulas of docs/laminates.md alone, and compared.

    stack_cases.py build/drape
"""

import json
import math
import subprocess
import sys

SIDE, CELLS = 1.0, 8
QUADRATIC, HEXAGONAL = math.pi / 4, math.pi / (2 * math.sqrt(3))
PLANE = {
    "degree_u": 1, "degree_v": 1, "size_u": 2, "size_v": 2,
    "knotvector_u": [0, 0, 1, 1], "knotvector_v": [0, 0, 1, 1],
    "control_points": [[0, 0, 0], [0, SIDE, 0], [SIDE, 0, 0], [SIDE, SIDE, 0]],
}


def ply(angle, shear=0.0, thickness=5e-4, fraction=0.5, spacing=0.05, **more):
    fabric = {"spacing": spacing, "thickness": thickness, "fiber_volume_fraction": fraction,
              "pre_shear_deg": shear, "locking_angle_deg": 35}
    return {"fabric": fabric, "direction": {"angle_deg": angle}, "start": {"uv": [0.5, 0.5]}, **more}


KOZENY = {"model": "kozeny_carman", "k1": 3e-10, "k2": 1e-10, "k3": 2e-11,
          "at_fiber_volume_fraction": 0.5}
GEBART = {"model": "gebart", "fiber_radius": 8e-6, "packing": "hexagonal"}
TABLE = {"model": "table", "shear_deg": [0, 30], "k1": [2e-10, 2e-10], "k2": [1e-10, 1e-10],
         "k3": [1e-11, 1e-11], "angle_deg": [10, 10]}
LAW, STIFF = {"a": 0.2, "b": 0.08}, {"a": 0.15, "b": 0.1}
TRIANGLE = [[0.07, 0.06, 0.3], [0.93, 0.11, -0.2], [0.35, 0.94, 0.1]]
HALF = [[-0.5, 0, 0], [0.51, 0, 0], [0.51, 1.0, 0], [-0.5, 1.0, 0]]
BEYOND = [[-0.01, -0.01, 0], [1.01, -0.01, 0], [1.01, 1.01, 0], [-0.01, 1.01, 0]]

CASES = {
    "one ply": dict(plies=[ply(20, permeability=KOZENY)]),
    "three equal plies": dict(plies=[ply(20, 15, permeability=KOZENY)] * 3),
    "0/90 is isotropic": dict(plies=[ply(0, permeability=KOZENY), ply(90, permeability=KOZENY)]),
    "sheared both ways": dict(plies=[ply(10, 25, permeability=KOZENY),
                                     ply(-35, -20, thickness=3e-4, permeability=GEBART)]),
    "a table": dict(plies=[ply(5, 12, permeability=TABLE), ply(50, -20, permeability=TABLE)]),
    "under a pressure": dict(
        cavity={"pressure": 1e5},
        plies=[ply(0, 10, compaction=LAW, permeability=KOZENY),
               ply(45, compaction=STIFF, permeability=GEBART),
               ply(90, permeability=KOZENY)]),
    "a height without laws": dict(
        cavity={"height": 1.2e-3},
        plies=[ply(0, 20, permeability=KOZENY), ply(45, thickness=8e-4, permeability=KOZENY)]),
    "a height with two laws": dict(
        cavity={"height": 1.1e-3},
        plies=[ply(0, 10, compaction=LAW, permeability=KOZENY, repeat=2),
               ply(45, -12, compaction=STIFF, permeability=GEBART),
               ply(80, permeability=KOZENY)]),
    "a patch in between": dict(
        offset="nominal", side=-1, cavity={"height": 1.3e-3},
        plies=[ply(0, compaction=LAW, permeability=KOZENY),
               ply(30, 8, permeability=KOZENY, repeat=3, boundary={"polygon": TRIANGLE}),
               ply(90, compaction=LAW, permeability=KOZENY)]),
    "patches along the edge": dict(
        plies=[ply(25, permeability=KOZENY, boundary={"polygon": BEYOND}),
               ply(0, permeability=KOZENY, boundary={"polygon": HALF}),
               ply(60, permeability=KOZENY)]),
    "too thin a cavity": dict(
        cavity={"height": 3e-4},
        plies=[ply(0, 40, permeability=KOZENY), ply(45, permeability=KOZENY)]),
}


# ---------------------------------------------------------------- the mesh

def mesh():
    step = SIDE / CELLS
    vertices = [[a * step, b * step, 0] for a in range(CELLS + 1) for b in range(CELLS + 1)]
    triangles = []
    for a in range(CELLS):
        for b in range(CELLS):
            i = a * (CELLS + 1) + b
            corners = [i, i + CELLS + 1, i + CELLS + 2, i + 1]
            if (a + b) % 3 == 0:  # looks to the other side
                corners = [corners[1], corners[0], corners[3], corners[2]]
            triangles.append(corners[:3])
            triangles.append([corners[0], corners[2], corners[3]])
    return vertices, triangles


# ---------------------------------------------------------------- one ply

def kozeny(vf):
    return (1 - vf) ** 3 / vf ** 2


def tensor(model, vf, shear):
    """K in the frame of the warp (2 x 2) and through it."""
    g = math.radians(shear)
    s, c = math.sin(g), math.cos(g)
    if model["model"] == "kozeny_carman":
        f = kozeny(vf) / kozeny(model["at_fiber_volume_fraction"]) if vf < 1 else 0
        k1, k2 = f * model["k1"], f * model["k2"]
        return [[(k1 + k2 * s * s) / c, k2 * s], [k2 * s, k2 * c]], f * model["k3"]
    if model["model"] == "gebart":
        r = model["fiber_radius"]
        hexagonal = model["packing"] == "hexagonal"
        top, cc, root = (HEXAGONAL, 53, math.sqrt(6)) if hexagonal else (QUADRATIC, 57, math.sqrt(2))
        along = 8 * r * r / cc * kozeny(vf)
        across = 16 / (9 * math.pi * root) * r * r * max(math.sqrt(top / vf) - 1, 0) ** 2.5
        k = [[across, 0], [0, across]]
        for x, y in ((1, 0), (s, c)):
            for i, a in enumerate((x, y)):
                for j, b in enumerate((x, y)):
                    k[i][j] += (along - across) / 2 * a * b
        return k, across
    # The table of these cases is constant: k1 at angle_deg from the acute bisector.
    acute = (90 - abs(shear)) / 2 + model["angle_deg"][0]
    t = math.radians(acute if shear >= 0 else -acute)
    x, y = math.cos(t), math.sin(t)
    k1, k2 = model["k1"][0], model["k2"][0]
    return [[k1 * x * x + k2 * y * y, (k1 - k2) * x * y],
            [(k1 - k2) * x * y, k1 * y * y + k2 * x * x]], model["k3"][0]


def inside(polygon, x, y):
    odd = False
    for (ax, ay, _), (bx, by, _) in zip(polygon, polygon[1:] + polygon[:1]):
        if (ay <= y) != (by <= y) and ax + (y - ay) / (by - ay) * (bx - ax) <= x:
            odd = not odd
    return odd


# ---------------------------------------------------------------- the stack

def press(cavity, plies):
    """Thickness and fibre fraction of each ply, and the pressure of those with a law."""
    own = [p.get("repeat", 1) * p["fabric"]["thickness"] /
           math.cos(math.radians(p["fabric"]["pre_shear_deg"])) for p in plies]
    vf = [p["fabric"]["fiber_volume_fraction"] for p in plies]
    laws = [p.get("compaction") for p in plies]
    if cavity == "flexible":
        return own, vf, 0

    def under(p, k):
        return own[k] * vf[k] / (laws[k]["a"] * p ** laws[k]["b"])

    which = [k for k, law in enumerate(laws) if law]
    share = cavity["height"] / sum(own) if "height" in cavity else 1
    pressure = cavity.get("pressure", 0) if which else 0
    if "height" in cavity and which:
        wanted = share * sum(own[k] for k in which)
        low, high = 1e-30, 1e30
        for _ in range(300):
            pressure = math.sqrt(low * high)
            if sum(under(pressure, k) for k in which) > wanted:
                low = pressure
            else:
                high = pressure
    thick = [under(pressure, k) if laws[k] else own[k] * share for k in range(len(plies))]
    return thick, [own[k] * vf[k] / thick[k] for k in range(len(plies))], pressure


def stack(case, plies):
    thick, vf, pressure = press(case.get("cavity", "flexible"), plies)
    total, resistance = sum(thick), 0
    k = [[0, 0], [0, 0]]
    for p, t, f in zip(plies, thick, vf):
        own, through = tensor(p["permeability"], f, p["fabric"]["pre_shear_deg"])
        a = math.radians(p["direction"]["angle_deg"])
        turn = [[math.cos(a), -math.sin(a)], [math.sin(a), math.cos(a)]]
        for i in range(2):
            for j in range(2):
                k[i][j] += t / total * sum(turn[i][m] * own[m][n] * turn[j][n]
                                           for m in range(2) for n in range(2))
        resistance += t / through if through > 0 else math.inf
    mean, half = (k[0][0] + k[1][1]) / 2, (k[0][0] - k[1][1]) / 2
    radius = math.hypot(half, k[0][1])
    limits = [HEXAGONAL if p["permeability"]["model"] == "gebart" else 0.9 for p in plies]
    return {
        "ply_count": len(plies), "thickness": total,
        "fiber_volume_fraction": sum(t * f for t, f in zip(thick, vf)) / total,
        "porosity": 1 - sum(t * f for t, f in zip(thick, vf)) / total,
        "pressure": pressure, "k1": mean + radius, "k2": mean - radius, "k3": total / resistance,
        "kxx": k[0][0], "kyy": k[1][1], "kxy": k[0][1], "kzz": total / resistance,
        "packing_exceeded": int(any(f > limit for f, limit in zip(vf, limits))),
        "locked": int(any(abs(p["fabric"]["pre_shear_deg"]) > 35 for p in plies)),
    }, list(zip(thick, vf))


def close(a, b, scale, what):
    if not abs(a - b) <= 1e-9 * scale:
        raise SystemExit(f"{what}: {a!r}, not {b!r}")


def check(drape, name, case):
    vertices, triangles = mesh()
    files = {"l": {"surface": PLANE, **case}, "m": {"mesh": {"vertices": vertices,
                                                              "triangles": triangles}}}
    for key, document in files.items():
        with open(f"{key}.json", "w", encoding="ascii") as file:
            json.dump(document, file)
    run = subprocess.run([drape, "l.json", "--map", "m.json"], capture_output=True, check=True)
    result = json.loads(run.stdout)
    cells, rows, at, worst = result["cells"], result["plies"], 0, 0.0
    for e, corners in enumerate(triangles):
        points = [vertices[c] for c in corners]
        x, y = (sum(p[k] for p in points) / 3 for k in (0, 1))
        there = [p for p in case["plies"] if "boundary" not in p or
                 inside(p["boundary"]["polygon"], x, y)]
        wanted, pressed = stack(case, there)
        for key, value in wanted.items():
            if key == "pressure" and key not in cells:
                continue
            scale = max(abs(wanted["k1"]), 1e-30) if key[0] == "k" else max(abs(value), 1e-3)
            close(cells[key][e], value, scale, f"{name}, element {e}, {key}")
        edge = [points[1][k] - points[0][k] for k in (0, 1)]
        first, last = ([points[n][k] - points[0][k] for k in (0, 1)] for n in (1, 2))
        side = 1 if first[0] * last[1] - first[1] * last[0] > 0 else -1
        for p, (thickness, vf) in zip(there, pressed):
            number = next(k for k, q in enumerate(case["plies"]) if q is p) + 1
            angle = side * (p["direction"]["angle_deg"] -
                            math.degrees(math.atan2(edge[1], edge[0])))
            off = (rows["angle_deg"][at] - angle + 180) % 360 - 180
            close(off, 0, 1e3, f"{name}, element {e}, angle of ply {number}")
            close(rows["element"][at], e, 1, f"{name}, element")
            if not case["plies"].count(p) > 1:
                close(rows["ply"][at], number, 1, f"{name}, ply")
            close(rows["shear_deg"][at], p["fabric"]["pre_shear_deg"], 1e2, f"{name}, shear")
            close(rows["thickness"][at], thickness, thickness, f"{name}, thickness")
            close(rows["fiber_volume_fraction"][at], vf, 1, f"{name}, fibre fraction")
            at += 1
    close(at, len(rows["ply"]), 1, f"{name}, rows")
    print(f"{name}: {len(triangles)} elements, {at} plies on them")


if __name__ == "__main__":
    for title, laminate in CASES.items():
        check(sys.argv[1], title, laminate)
