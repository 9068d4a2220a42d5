#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Runs a CalculiX deck on a mesh that is not plane, moved at its nodes by a smooth field, and asks at every
point of every layer whether the stresses printed follow from the strains printed: sigma = C(angle)
epsilon, with the layer's directions laid on its element by the angle in the map. What is left is measured
in degrees, too, by what a turn of the layer would change. CalculiX counts points from an element's bottom:
those of a layer have to lie about its middle.

usage: curved.py MESH.json MAP.json DECK FOLDER [SIDE], the side that the plies lie on, 1 or -1"""

import json
import math
import os
import subprocess
import sys

import numpy as np

E1, E2, E3, NU12, NU13, NU23, G12, G13, G23 = 100e9, 8e9, 5e9, 0.3, 0.25, 0.4, 4e9, 3e9, 2e9
PAIRS = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)]  # as they are printed


def tensors(rows):
    """Symmetric matrices from the six components of each row."""
    whole = np.zeros((len(rows), 3, 3))
    for k, (i, j) in enumerate(PAIRS):
        whole[:, i, j] = whole[:, j, i] = rows[:, k]
    return whole


def stress_of(strain, axes):
    """Of a layer with these axes, as rows: by the nine constants, in its own directions and back."""
    normal = np.linalg.inv([[1 / E1, -NU12 / E1, -NU13 / E1], [-NU12 / E1, 1 / E2, -NU23 / E2],
                            [-NU13 / E1, -NU23 / E2, 1 / E3]])
    own = axes @ strain @ np.swapaxes(axes, 1, 2)
    stress = 2 * np.array([[0, G12, G13], [G12, 0, G23], [G13, G23, 0]]) * own
    for k in range(3):
        stress[:, k, k] = np.einsum("j,njj->n", normal[k], own)
    return np.swapaxes(axes, 1, 2) @ stress @ axes


def frame(corners):
    """First edge, across and normal of an element, as rows."""
    p = np.array(corners)
    n = np.cross(p[2] - p[0], p[3] - p[1]) if len(p) == 4 else np.cross(p[1] - p[0], p[2] - p[0])
    n /= np.linalg.norm(n)
    x = p[1] - p[0] - (p[1] - p[0]) @ n * n
    x /= np.linalg.norm(x)
    return np.array([x, np.cross(n, x), n])


def axes_of(rows, angles):
    """Of layers at these angles in degrees, in these frames."""
    c, s = np.cos(np.radians(angles))[:, None], np.sin(np.radians(angles))[:, None]
    x, y, n = rows[:, 0], rows[:, 1], rows[:, 2]
    return np.stack([c * x + s * y, c * y - s * x, n], 1)


def write(text, folder, nodes, elements, materials):
    size = max(np.abs(v).max() for v in nodes.values())
    with open(os.path.join(folder, "curved.inp"), "w") as f:
        f.write(text + "*ELSET, ELSET=ALL\n" + "".join(f"{e},\n" for e in elements))
        for k in range(materials):
            f.write(f"*MATERIAL, NAME=MATERIAL_{k + 1}\n*ELASTIC, TYPE=ENGINEERING CONSTANTS\n"
                    f"{E1},{E2},{E3},{NU12},{NU13},{NU23},{G12},{G13}\n{G23}\n")
        f.write("*STEP\n*STATIC\n*BOUNDARY\n")
        for n, place in nodes.items():
            x, y, z = place / size
            moved = size * 1e-4 * np.array([x + 0.4 * y * y, 0.7 * x - 0.3 * y, 0.5 * x * y - 0.2 * z])
            f.writelines(f"{n},{k + 1},{k + 1},{moved[k]:.12g}\n" for k in range(3))
        f.write("*EL PRINT, ELSET=ALL, GLOBAL=YES\nS,E\n*EL PRINT, ELSET=ALL\nCOORD\n*END STEP\n")


def printed(path):
    """Of each kind of output the rows: element, point, values."""
    tables, rows = {}, None
    for line in open(path):
        if "(" in line:
            rows = tables.setdefault(line.split()[0], [])
        elif line.strip():
            rows.append([float(v) for v in line.split()[:8]])
    return {kind: np.array(rows) for kind, rows in tables.items()}


def main():
    mesh, mapped, folder = json.load(open(sys.argv[1]))["mesh"], json.load(open(sys.argv[2])), sys.argv[4]
    text, plies, side = open(sys.argv[3]).read(), mapped["plies"], int((sys.argv + ["1"])[5])
    shapes = dict(zip(mesh["ids"], mesh["triangles"] + mesh["quads"]))
    places = np.array(mesh["vertices"])
    layers = {}  # of each element, away from the tool: angle and thickness
    for e, angle, own in zip(plies["element"], plies["angle_deg"], plies["thickness"]):
        layers.setdefault(e, []).append((angle, own))
    frames = {e: frame(places[shapes[e]]) for e in layers}
    assert len({v[2, 2] > 0 for v in frames.values()}) == len({len(shapes[e]) for e in layers}) == 2
    write(text, folder, {mesh["vertex_ids"][c]: places[c] for e in layers for c in shapes[e]}, layers,
          max(plies["ply"]))
    run = subprocess.run(["ccx", "curved"], cwd=folder, capture_output=True, text=True, timeout=60)
    assert "Job finished" in run.stdout, run.stdout[-2000:]
    tables = printed(os.path.join(folder, "curved.dat"))
    stress, strain, point = (tables[kind] for kind in ("stresses", "strains", "global"))
    assert (stress[:, :2] == strain[:, :2]).all() and (stress[:, :2] == point[:, :2]).all()
    angles, rows, off = np.full(len(stress), np.nan), np.zeros((len(stress), 3, 3)), 0
    for e, own in layers.items():
        at, low = np.flatnonzero(stress[:, 0] == e), -sum(t for _, t in own) / 2
        heights = (point[at, 2:] - places[shapes[e]].mean(0)) @ frames[e][2]
        upward = own if side * frames[e][2, 2] > 0 else own[::-1]
        for k, (angle, t) in enumerate(upward):
            mine = slice(k * len(at) // len(own), (k + 1) * len(at) // len(own))
            angles[at[mine]], rows[at[mine]] = angle, frames[e]
            off = max(off, abs(heights[mine].mean() - low - t / 2) / t)
            low += t
    whole = tensors(strain[:, 2:])

    def expected(turn):
        return stress_of(whole, axes_of(rows, angles + turn)).reshape(len(stress), -1)

    right, slope = expected(0), (expected(0.01) - expected(-0.01)) / 0.02
    left = tensors(stress[:, 2:]).reshape(len(stress), -1) - right
    error = (np.abs(left).max(1) / np.abs(right).max(1)).max()
    turned = np.abs((left * slope).sum(1) / (slope * slope).sum(1)).max()
    print(f"{len(layers)} elements, {len(stress)} points: stresses within {error:.1e}, angles within "
          f"{turned:.1e} degrees, layers within {off:.1e} of their thickness")
    assert 0 < error < 1e-4 and 0 < turned < 1e-3 and off < 0.01


main()
