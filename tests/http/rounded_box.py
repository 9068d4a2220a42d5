# SPDX-License-Identifier: MIT
"""A box without its bottom, its edges rounded: python3 rounded_box.py LENGTH WIDTH HEIGHT RADIUS
prints the request of a drape on its 17 faces: the top, and on every side of it a wall, a rounded
edge, a rounded upright edge and an eighth of a sphere. The origin is in the middle of its foot."""
import json
import sys
from math import sqrt


def patch(rows, weights=None):
    """A NURBS patch of a row of control points for every u, of degree 1 or 2 without inner knots."""
    size_u, size_v = len(rows), len(rows[0])
    face = {"degree_u": size_u - 1, "degree_v": size_v - 1,
            "knotvector_u": [0] * size_u + [1] * size_u, "knotvector_v": [0] * size_v + [1] * size_v,
            "size_u": size_u, "size_v": size_v,
            "control_points": {"points": [list(p) for row in rows for p in row]}}
    if weights:
        face["control_points"]["weights"] = [w for row in weights for w in row]
    return face


def rounded_box(length, width, height, radius):
    x, y, z, w = length / 2, width / 2, height, 1 / sqrt(2)
    a, b, c = x - radius, y - radius, z - radius
    faces = [patch([[(-a, -b, z), (-a, b, z)], [(a, -b, z), (a, b, z)]])]
    for sx in (1, -1):
        arc = lambda s, t: [(s * a, t, z), (s * x, t, z), (s * x, t, c)]
        faces.append(patch([arc(sx, -b), arc(sx, b)], [[1, w, 1]] * 2))
        faces.append(patch([[(sx * x, -b, c), (sx * x, -b, 0)], [(sx * x, b, c), (sx * x, b, 0)]]))
    for sy in (1, -1):
        arc = lambda t, s: [(t, s * b, z), (t, s * y, z), (t, s * y, c)]
        faces.append(patch([arc(-a, sy), arc(a, sy)], [[1, w, 1]] * 2))
        faces.append(patch([[(-a, sy * y, c), (-a, sy * y, 0)], [(a, sy * y, c), (a, sy * y, 0)]]))
    for sx in (1, -1):
        for sy in (1, -1):
            turn = [(sx * x, sy * b), (sx * x, sy * y), (sx * a, sy * y)]
            faces.append(patch([[(*p, c) for p in turn], [(*p, 0) for p in turn]], [[1, w, 1]] * 2))
            pole = [(sx * a, sy * b, z)] * 3
            faces.append(patch([pole, [(*p, z) for p in turn], [(*p, c) for p in turn]],
                               [[1, w, 1], [w, w * w, w], [1, w, 1]]))
    return faces


if __name__ == "__main__":
    print(json.dumps({"surface": {"faces": rounded_box(*map(float, sys.argv[1:5]))}, "length_unit": "mm",
                      "fabric": {"spacing": 4, "locking_angle_deg": 50},
                      "start": {"point": [0, 0, float(sys.argv[3])]}, "direction": {"vector": [1, 0, 0]}}))
