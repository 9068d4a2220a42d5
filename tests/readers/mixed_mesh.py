#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Writes a mesh of the saddle z = (x^2 - y^2) / 2 for a map, of triangles and quadrilaterals, warped,
of both windings, each beginning at any of its corners, with numbers that begin anywhere; one element
lies beyond the cloth. usage: mixed_mesh.py LENGTH SIZE [HEIGHT]: lengths times LENGTH, SIZE x SIZE places, heights times
HEIGHT; with 0 in a plane, its rim straight."""

import json
import random
import sys

length, size = float(sys.argv[1]), int(sys.argv[2])
height = float(sys.argv[3]) if len(sys.argv) > 3 else 1
choose = random.Random(7)
vertices, triangles, quads = [], [], []
for j in range(size + 1):
    for i in range(size + 1):
        inside = height != 0 or (0 < i < size and 0 < j < size)
        x, y = (1.2 * (2 * k / size - 1) + inside * choose.uniform(-0.1, 0.1) / size for k in (i, j))
        vertices.append([length * x, length * y, height * length * (x * x - y * y) / 2])


def turned(corners):
    start = choose.randrange(len(corners))
    corners = corners[start:] + corners[:start]
    return corners[::-1] if choose.random() < 0.5 else corners


for j in range(size):
    for i in range(size):
        a = j * (size + 1) + i
        b, c, d = a + 1, a + size + 2, a + size + 1
        if choose.random() < 0.5:
            quads.append(turned([a, b, c, d]))
        else:
            triangles += [turned([a, b, c]), turned([a, c, d])]
vertices += [[length * 40, 0, 0], [length * 41, 0, 0], [length * 40, length, 0]]
triangles.append([len(vertices) - 3, len(vertices) - 2, len(vertices) - 1])
count = len(triangles) + len(quads)
json.dump({"mesh": {"vertices": vertices, "triangles": triangles, "quads": quads,
                    "ids": choose.sample(range(1, 10 * count), count),
                    "vertex_ids": choose.sample(range(1, 10 * len(vertices)), len(vertices))}},
          sys.stdout)
