#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Runs CalculiX decks of a flat sheet with materials of their own.

lamination.py mesh LENGTH WIDTH SIZE [turned]: writes a mesh of a sheet from the origin along x, of
    quadrilaterals of that size; turned: each begins at any corner, and half of them look down.
lamination.py abd DECK ABD.csv FOLDER: the matrices A, B and D of the deck as CalculiX has them, from its
    energy under each pair of uniform strains and curvatures, against those in ABD.csv, in the frame whose
    x is the global one.
lamination.py stretch DECK FOLDER: prints the force by elongation, N/mm, of a sheet held at both ends.
"""

import csv
import itertools
import json
import os
import random
import subprocess
import sys

import numpy as np

ENTRIES = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)]


def mesh(length, width, size, turned):
    choose = random.Random(3)
    nx, ny = round(length / size), round(width / size)
    vertices = [[length * i / nx, width * j / ny, 0] for j in range(ny + 1) for i in range(nx + 1)]
    quads = []
    for j, i in itertools.product(range(ny), range(nx)):
        a = j * (nx + 1) + i
        corners = [a, a + 1, a + nx + 2, a + nx + 1]
        if turned:
            start = choose.randrange(4)
            corners = (corners[start:] + corners[:start])[:: choose.choice((1, -1))]
        quads.append(corners)
    json.dump({"mesh": {"vertices": vertices, "quads": quads, "ids": list(range(1, len(quads) + 1)),
                        "vertex_ids": list(range(1, len(vertices) + 1))}}, sys.stdout)


def read(deck):
    """Nodes, and the corners and middles of elements."""
    nodes, shape, kind = {}, {}, None
    for line in open(deck):
        if line.startswith("**"):
            continue
        if line.startswith("*"):
            kind = line.split(",")[0].strip()
        elif kind == "*NODE":
            number, *place = line.split(",")
            nodes[int(number)] = np.array([float(v) for v in place])
        elif kind == "*ELEMENT":
            number, *own = [int(v) for v in line.split(",")]
            shape[number] = own
    return nodes, shape


def run(deck, folder, conditions, wanted):
    nodes, shape = read(deck)
    with open(os.path.join(folder, "case.inp"), "w") as f:
        f.write(f"*INCLUDE, INPUT={os.path.abspath(deck)}\n")
        f.write("*ELSET, ELSET=ALL\n" + "".join(f"{e},\n" for e in shape))
        f.write("*NSET, NSET=HELD\n" + "".join(f"{n},\n" for n in nodes if nodes[n][0] < 1e-9))
        f.write("*STEP\n*STATIC\n*BOUNDARY\n" + conditions(nodes) + wanted + "*END STEP\n")
    done = subprocess.run(["ccx", "case"], cwd=folder, capture_output=True, text=True, timeout=120)
    assert "Job finished" in done.stdout, done.stdout[-2000:]
    return [line.split() for line in open(os.path.join(folder, "case.dat"))]


def energy(deck, folder, load):
    """Under strains xx, yy, 2xy and curvatures of all nodes."""
    def conditions(nodes):
        lines = []
        for n, (x, y, _) in nodes.items():
            w = -(load[3] * x * x + load[4] * y * y + load[5] * x * y) / 2
            u = (load[0] * x + load[2] * y / 2, load[1] * y + load[2] * x / 2, w)
            lines += [f"{n},{k + 1},{k + 1},{u[k]:.15g}\n" for k in range(3)]
        return "".join(lines)
    found = run(deck, folder, conditions, "*EL PRINT, ELSET=ALL, TOTALS=ONLY\nELSE\n")
    return float(found[-1][-1])


def area(points):
    x, y = np.array(points)[:, 0], np.array(points)[:, 1]
    return (x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2


def expected(path, nodes, shape):
    """Integrated over the sheet, about the global z."""
    whole = np.zeros((6, 6))
    for row in csv.DictReader(open(path)):
        own = area([nodes[n] for n in shape[int(row["id"])][:4]])
        matrix, turn = np.zeros((6, 6)), np.diag([1, 1, np.sign(own)])
        for name, (r, c), sign in (("a", (0, 0), 1), ("b", (0, 3), np.sign(own)), ("d", (3, 3), 1)):
            part = np.zeros((3, 3))
            for i, j in ENTRIES:
                part[i, j] = part[j, i] = float(row[name + "126"[i] + "126"[j]])
            matrix[r : r + 3, c : c + 3] = sign * turn @ part @ turn
        matrix[3:, :3] = matrix[:3, 3:].T
        whole += abs(own) * matrix
    # N/m, N and N m to N and mm
    scale = np.diag([1, 1, 1, 1e3, 1e3, 1e3])
    return scale @ whole @ scale / 1e3


def check_abd(deck, path, folder):
    nodes, shape = read(deck)
    right = expected(path, nodes, shape)
    unit = np.diag([1e-3] * 3 + [1e-4] * 3)  # small; linear anyway
    alone = [energy(deck, folder, unit[k]) for k in range(6)]
    found = np.diag([2 * alone[k] / unit[k, k] ** 2 for k in range(6)])
    for i, j in itertools.combinations(range(6), 2):
        both = energy(deck, folder, unit[i] + unit[j])
        found[i, j] = found[j, i] = (both - alone[i] - alone[j]) / (unit[i, i] * unit[j, j])
    size = np.sqrt(np.outer(np.diag(right), np.diag(right)))
    off = [np.abs((found - right) / size)[r].max() for r in
           ((slice(0, 3), slice(0, 3)), (slice(0, 3), slice(3, 6)), (slice(3, 6), slice(3, 6)))]
    coupling = np.abs((right / size)[:3, 3:]).max()
    print("of CalculiX: A within %.1e, B within %.1e, D within %.1e; coupling %.2g" % (*off, coupling))
    assert all(0 < v < 1e-3 for v in off) and coupling > 0.1


def stretch(deck, folder):
    def conditions(nodes):
        far = max(v[0] for v in nodes.values())
        ends = [(n, v[0] > 1) for n, v in nodes.items() if v[0] < 1e-9 or v[0] > far - 1e-9]
        return "DRAPED,3,3\n" + "".join(f"{n},1,1,{float(end)}\n{n},2,2\n" for n, end in ends)
    found = run(deck, folder, conditions, "*NODE PRINT, NSET=HELD, TOTALS=ONLY\nRF\n")
    print("%.6g" % -float(found[-1][0]))


if __name__ == "__main__":
    if sys.argv[1] == "mesh":
        mesh(*map(float, sys.argv[2:5]), len(sys.argv) > 5)
    elif sys.argv[1] == "abd":
        check_abd(*sys.argv[2:5])
    else:
        stretch(*sys.argv[2:4])
