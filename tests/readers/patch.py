#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Runs a CalculiX deck of one ply in a plane under a uniform strain at its rim, and compares the
stress and the volume of every element with what the ply's angle and thickness in the map say:
sigma = Q(angle) epsilon, and area times thickness.

usage: patch.py MAP.json DECK FOLDER"""

import json
import math
import os
import subprocess
import sys

import numpy as np

E1, E2, NU12, G12 = 100e9, 8e9, 0.3, 4e9
STRAIN = np.array([1e-3, -4e-4, 6e-4])  # xx, yy, 2 xy


def stiffness(angle):
    """Of a plane orthotropic layer whose 1-direction is `angle` from x, for (xx, yy, 2 xy)."""
    nu21 = NU12 * E2 / E1
    q = np.array([[E1, NU12 * E2, 0], [NU12 * E2, E2, 0], [0, 0, G12 * (1 - NU12 * nu21)]])
    q /= 1 - NU12 * nu21
    c, s = math.cos(angle), math.sin(angle)
    t = np.array([[c * c, s * s, 2 * c * s], [s * s, c * c, -2 * c * s],
                  [-c * s, c * s, c * c - s * s]])
    inverse = np.linalg.inv(t)
    return inverse @ q @ inverse.T


def nodes_of(deck):
    nodes, reading = {}, False
    for line in open(deck):
        if line.startswith("*"):
            reading = reading and line.startswith("**") or line.startswith("*NODE")
        elif reading:
            number, *place = line.split(",")
            nodes[int(number)] = np.array([float(v) for v in place])
    return nodes


def write(deck, folder, rim, nodes):
    gradient = np.array([[STRAIN[0], STRAIN[2] / 2], [STRAIN[2] / 2, STRAIN[1]]])
    with open(os.path.join(folder, "patch.inp"), "w") as f:
        f.write(f"*INCLUDE, INPUT={os.path.abspath(deck)}\n*MATERIAL, NAME=MATERIAL_1\n"
                f"*ELASTIC, TYPE=ENGINEERING CONSTANTS\n{E1},{E2},{E2},{NU12},{NU12},0.3,{G12},{G12}\n"
                f"{G12}\n*STEP\n*STATIC\n*BOUNDARY\nDRAPED,3,3\n")
        for n in rim:
            u = gradient @ nodes[n][:2]
            f.write(f"{n},1,1,{u[0]:.12g}\n{n},2,2,{u[1]:.12g}\n")
        f.write("*EL PRINT, ELSET=ALL, GLOBAL=YES\nS\n*EL PRINT, ELSET=ALL\nEVOL\n*END STEP\n")


def main():
    expected, deck, folder = json.load(open(sys.argv[1])), sys.argv[2], sys.argv[3]
    text = open(deck).read()
    elements = [int(l.split("ELSET=E")[1]) for l in text.splitlines() if l.startswith("*ELEMENT")]
    nodes, lines = nodes_of(deck), text.splitlines()
    shape = {int(v[0]): [int(c) for c in v[1:]] for k, l in zip(lines, lines[1:])
             if k.startswith("*ELEMENT") for v in [l.split(",")]}
    nodes = {n: nodes[n] for corners in shape.values() for n in corners}
    low, high = np.min(list(nodes.values()), 0), np.max(list(nodes.values()), 0)
    rim = [n for n, v in nodes.items() if min(*(v[:2] - low[:2]), *(high[:2] - v[:2])) < 1e-9]
    own = os.path.join(folder, "deck.inp")
    with open(own, "w") as f:
        f.write(text + "*ELSET, ELSET=ALL\n" + "".join(f"{e},\n" for e in elements))
    write(own, folder, rim, nodes)
    run = subprocess.run(["ccx", "patch"], cwd=folder, capture_output=True, text=True, timeout=60)
    assert "Job finished" in run.stdout, run.stdout[-2000:]
    cells = expected["cells"]
    thickness = dict(zip(expected["plies"]["element"], expected["plies"]["thickness"]))
    angle = {e: math.atan2(y, x) for e, x, y in zip(cells["id"], cells["warp_x"], cells["warp_y"])}
    stress, volume, kind = 0, 0, None
    for line in open(os.path.join(folder, "patch.dat")):
        words = line.split()
        if "(" in line:
            kind = words[0]
        elif kind == "stresses" and len(words) >= 8:
            found = np.array([float(words[2]), float(words[3]), float(words[5])])
            right = stiffness(angle[int(words[0])]) @ STRAIN
            stress = max(stress, np.abs(found - right).max() / np.abs(right).max())
        elif kind == "volume" and len(words) == 2:
            corners = shape[int(words[0])]
            x, y = np.array([nodes[n][:2] for n in corners[: len(corners) // 2]]).T
            area = abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2
            right = area * thickness[int(words[0])]
            volume = max(volume, abs(float(words[1]) / right - 1))
    print(f"{len(elements)} elements: stresses within {stress:.1e}, volumes within {volume:.1e}")
    assert 0 < stress < 1e-3 and 0 < volume < 1e-5


main()
