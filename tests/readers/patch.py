#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Runs a CalculiX deck of plies in a plane, the same ones from below as from above so that it stays
flat, under a uniform strain at its rim, and compares the stress in every layer and the volume of every
element with what the angles and thicknesses in the map say: sigma = Q(angle) epsilon, and area times
thickness. A layer is known by how high its points lie.

usage: patch.py MAP.json DECK FOLDER"""

import json
import math
import os
import subprocess
import sys

import numpy as np

# Layers are in one element and become thinner together: with nu13 = nu23 = 0 that costs nothing.
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


def direction(corners, angle):
    """Of a warp so far from an element's first edge about its own normal, as an angle from x."""
    x, y = np.array(corners).T
    side = 1 if x @ np.roll(y, -1) - y @ np.roll(x, -1) > 0 else -1
    return math.atan2(y[1] - y[0], x[1] - x[0]) + side * math.radians(angle)


def write(deck, folder, rim, nodes, materials):
    gradient = np.array([[STRAIN[0], STRAIN[2] / 2], [STRAIN[2] / 2, STRAIN[1]]])
    with open(os.path.join(folder, "patch.inp"), "w") as f:
        f.write(f"*INCLUDE, INPUT={os.path.abspath(deck)}\n")
        for k in range(materials):
            f.write(f"*MATERIAL, NAME=MATERIAL_{k + 1}\n*ELASTIC, TYPE=ENGINEERING CONSTANTS\n"
                    f"{E1},{E2},{E2},{NU12},0,0,{G12},{G12}\n{G12}\n")
        f.write("*STEP\n*STATIC\n*BOUNDARY\nDRAPED,3,3\n")
        for n in rim:
            u = gradient @ nodes[n][:2]
            f.write(f"{n},1,1,{u[0]:.12g}\n{n},2,2,{u[1]:.12g}\n")
        f.write("*EL PRINT, ELSET=ALL, GLOBAL=YES\nS\n*EL PRINT, ELSET=ALL\nCOORD\nEVOL\n*END STEP\n")


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
    plies = expected["plies"]
    write(own, folder, rim, nodes, max(plies["ply"]))
    run = subprocess.run(["ccx", "patch"], cwd=folder, capture_output=True, text=True, timeout=60)
    assert "Job finished" in run.stdout, run.stdout[-2000:]
    layers = {}  # of each element, upwards: angle and thickness
    for e, angle, own in zip(plies["element"], plies["angle_deg"], plies["thickness"]):
        flat = [nodes[n][:2] for n in shape[e][: len(shape[e]) // 2]] if e in shape else None
        if flat:
            layers.setdefault(e, []).append((direction(flat, angle), own))
    stress, volume, kind, found = 0, 0, None, {}
    for line in open(os.path.join(folder, "patch.dat")):
        words = line.split()
        if "(" in line:
            kind = words[0]
        elif kind == "stresses" and len(words) >= 8:
            found[words[0], words[1]] = np.array([float(words[2]), float(words[3]), float(words[5])])
        elif kind in ("global", "coordinates") and len(words) == 5:
            e, height, low = int(words[0]), float(words[4]), -sum(t for _, t in layers[int(words[0])]) / 2
            for angle, own in layers[e]:
                if low < height < low + own:
                    right = stiffness(angle) @ STRAIN
                    stress = max(stress, np.abs(found.pop((words[0], words[1])) - right).max()
                                 / np.abs(right).max())
                low += own
        elif kind == "volume" and len(words) == 2:
            corners = shape[int(words[0])]
            x, y = np.array([nodes[n][:2] for n in corners[: len(corners) // 2]]).T
            area = abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2
            right = area * sum(t for _, t in layers[int(words[0])])
            volume = max(volume, abs(float(words[1]) / right - 1))
    print(f"{len(elements)} elements: stresses within {stress:.1e}, volumes within {volume:.1e}")
    assert not found  # every point lies in a layer
    assert 0 < stress < 1e-3 and 0 < volume < 1e-5


main()
