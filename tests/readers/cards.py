#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Reads decks of solvers by the rules of their manuals, without the program's own code, and
compares the fibre of every ply on every element, as a direction in space, and its thickness with
the JSON document of the same map.

usage: cards.py FORMAT MESH.json MAP.json DECK [REFERENCE|- [SIDE [WITHIN [yarns]]]]

REFERENCE is x,y,z. With SIDE, 1 or -1, plies follow each other along that side of z, on elements that
are nowhere upright: their layers from the bottom are compared; 0: they are not. WITHIN: degrees and percent by
which the deck is rounded. With yarns plies 2 k - 1 and 2 k are warp and weft of ply k, half of it each.
"""

import collections
import json
import math
import re
import sys

import numpy as np

ANGLE, LENGTH = 1e-6, 1e-12


def unit(v):
    return v / np.linalg.norm(v)


def frame(points, reference=None):
    """x, y, normal of an element: side 1-2 or the reference projected; the normal by its corners."""
    p = [np.array(q, float) for q in points]
    normal = np.cross(p[2] - p[0], p[3] - p[1]) if len(p) == 4 else np.cross(p[1] - p[0], p[2] - p[0])
    normal = unit(normal)
    x = (p[1] - p[0]) if reference is None else np.array(reference, float)
    x = unit(x - normal * (x @ normal))
    return x, np.cross(normal, x), normal


def at(points, degrees, reference=None):
    x, y, _ = frame(points, reference)
    return math.cos(math.radians(degrees)) * x + math.sin(math.radians(degrees)) * y


# Every reader returns {(element, ply): (direction, thickness)}, and layers by element from its
# bottom where the deck has them. `corners` is what the caller's mesh has for an element.


def bulk(path):
    """Entries of large fields: name and fields, blank ones "". A line has four."""
    entry = None
    for line in open(path):
        if line.startswith("$"):
            continue
        name, fields = line[:8].strip(), [line[k : k + 16].strip() for k in (8, 24, 40, 56)]
        assert len(line.rstrip("\n")) <= 72, line
        if name != "*":
            if entry:
                yield entry
            assert name.endswith("*"), line
            entry = (name[:-1], [])
        entry[1].extend(fields)
    yield entry


def real(field):
    assert "." in field, field
    return float(field)


def read_nastran(path, corners, reference):
    points, elements, stacks, rows, layers = {}, {}, {}, {}, {}
    for name, f in bulk(path):
        if name == "GRID":
            points[int(f[0])] = [real(f[2]), real(f[3]), real(f[4])]
        elif name in ("CQUAD4", "CTRIA3"):
            n = 4 if name == "CQUAD4" else 3
            elements[int(f[0])] = int(f[1]), [int(g) for g in f[2 : 2 + n]], real(f[2 + n])
        else:
            assert name == "PCOMPG"
            stacks[int(f[0])] = [(int(p[0]), int(p[1]), real(p[2]), real(p[3]))
                                 for p in (f[k : k + 8] for k in range(8, len(f), 8))]
    for element, (stack, nodes, theta) in elements.items():
        place = [points[g] for g in nodes]
        assert np.allclose(place, corners[element], rtol=1e-11, atol=1e-11)
        layers[element] = [ply for ply, *_ in stacks[stack]]
        for ply, material, thickness, angle in stacks[stack]:
            assert ply == material
            rows[element, ply] = at(place, theta + angle), thickness
    return rows, layers


def read_optistruct(path, corners, reference):
    drapes, plies, sets, stack = {}, {}, {}, []
    for name, f in bulk(path):
        if name == "DRAPE":
            lines = [f[k : k + 8] for k in range(8, len(f), 8)]
            assert all(line[0] == "ELEM" for line in lines)
            drapes[int(f[0])] = {int(l[1]): (real(l[2]), real(l[3])) for l in lines}
        elif name == "SET":
            assert f[1:3] == ["ELEM", "LIST"]
            sets[int(f[0])] = {int(g) for g in f[4:] if g}
        elif name == "PLY":
            assert f[6] == f[0] and f[8] == f[0]
            plies[int(f[0])] = real(f[2]), real(f[3])
        else:
            assert name == "STACK"
            stack = [int(g) for g in f[2:] if g]
    rows, layers = {}, {}
    for ply in stack:
        thickness, angle = plies[ply]
        assert sets[ply] == set(drapes[ply])
        for element, (thinning, turn) in drapes[ply].items():
            rows[element, ply] = at(corners[element], angle + turn, reference), thinning * thickness
            layers.setdefault(element, []).append(ply)
    return rows, layers


def read_radioss(path, corners, reference):
    rows, ply, thickness = {}, None, None
    lines = [line.rstrip("\n") for line in open(path) if not line.startswith("#")]
    for k, line in enumerate(lines):
        if line.startswith("/DRAPE/"):
            ply, thickness = int(line[7:]), float(lines[k + 1].rsplit(" ", 1)[1])
        elif line[:10].strip() in ("SHELL", "SH3N"):
            element = int(line[10:20])
            assert (line[:10].strip() == "SHELL") == (len(corners[element]) == 4)
            rows[element, ply] = (at(corners[element], float(line[40:60]), reference),
                                  float(line[20:40]) * thickness)
    return rows, {}


def read_lsdyna(path, corners, reference):
    points, rows, layers, keyword, element = {}, {}, {}, None, None
    for line in open(path):
        line = line.rstrip("\n")
        if line.startswith("$"):
            continue
        if line.startswith("*"):
            keyword = line
        elif keyword == "*NODE":
            points[int(line[:8])] = [float(line[8 + 16 * k : 24 + 16 * k]) for k in range(3)]
        elif len(line) == 48 and "." not in line:
            element, part, *nodes = [int(line[8 * k : 8 * k + 8]) for k in range(6)]
            nodes = nodes[:3] if nodes[3] == nodes[2] else nodes
            place = [points[n] for n in nodes]
            assert np.allclose(place, corners[element], rtol=1e-9, atol=1e-9)
        else:
            for k in range(0, len(line), 40):
                ply, thickness, angle = (line[k + 10 * j : k + 10 * j + 10] for j in range(3))
                layers.setdefault(element, []).append(int(ply))
                rows[element, int(ply)] = at(place, real(angle)), real(thickness)
    return rows, layers


def keywords(path):
    """Abaqus and CalculiX: (keyword, parameters, lines of values)."""
    entry = None
    for line in open(path):
        line = line.strip()
        if line.startswith("**"):
            continue
        if line.startswith("*"):
            if entry:
                yield entry
            head, *parameters = [part.strip() for part in line.split(",")]
            entry = head, dict((p.split("=") + [""])[:2] for p in parameters), []
        else:
            entry[2].append([value.strip() for value in line.split(",")])
    yield entry


def direction(values):
    return np.array([float(v) for v in values[:3]])


def read_abaqus(path, corners, reference):
    points, elements, fields, orientation, sets, rows, layers = {}, {}, {}, {}, {}, {}, {}
    for head, parameters, lines in keywords(path):
        if head == "*NODE":
            points = {int(l[0]): [float(v) for v in l[1:4]] for l in lines}
        elif head == "*ELEMENT":
            n = {"S3": 3, "S4": 4}[parameters["TYPE"]]
            elements.update({int(l[0]): [int(v) for v in l[1 : n + 1]] for l in lines})
        elif head == "*DISTRIBUTION TABLE":
            assert lines == [["COORD3D", "COORD3D"]]
        elif head == "*DISTRIBUTION":
            assert parameters["LOCATION"] == "ELEMENT" and lines[0][0] == ""
            fields[parameters["NAME"]] = {int(l[0]): direction(l[1:]) for l in lines[1:]}
        elif head == "*ORIENTATION":
            orientation[parameters["NAME"]] = fields[lines[0][0]]
        elif head == "*ELSET":
            sets[parameters["ELSET"]] = [int(v) for l in lines for v in l]
        else:
            assert head == "*SHELL SECTION" and "COMPOSITE" in parameters
            for element in sets[parameters["ELSET"]]:
                assert np.allclose([points[n] for n in elements[element]], corners[element])
                for thickness, _, material, name in lines:
                    ply = int(name[4:])
                    assert material == f"MATERIAL_{ply}"
                    rows[element, ply] = orientation[name][element], float(thickness)
                    layers.setdefault(element, []).append(ply)
    return rows, layers


def read_calculix(path, corners, reference):
    points, elements, orientation, rows, layers = {}, {}, {}, {}, {}
    for head, parameters, lines in keywords(path):
        if head == "*NODE":
            points = {int(l[0]): np.array([float(v) for v in l[1:4]]) for l in lines}
        elif head == "*ELEMENT":
            ((element, *nodes),) = [[int(v) for v in l] for l in lines]
            n = {"S6": 3, "S8R": 4}[parameters["TYPE"]]
            assert len(nodes) == 2 * n and parameters["ELSET"] == f"E{element}"
            assert np.allclose([points[k] for k in nodes[:n]], corners[element])
            for k in range(n):
                middle = (points[nodes[k]] + points[nodes[(k + 1) % n]]) / 2
                assert np.allclose(points[nodes[n + k]], middle)
            elements[parameters["ELSET"]] = element
        elif head == "*ORIENTATION":
            orientation[parameters["NAME"]] = direction(lines[0])
        else:
            assert head == "*SHELL SECTION" and "COMPOSITE" in parameters
            element = elements[parameters["ELSET"]]
            for thickness, _, material, name in lines:
                ply = int(name.split("_")[1])
                assert material == f"MATERIAL_{ply}"
                rows[element, ply] = orientation[name], float(thickness)
                layers.setdefault(element, []).append(ply)
    return rows, layers


def split(plies, cells, corners):
    """Rows of warp and weft in place of those of plies; a weft is 90 degrees less the shear from the
    warp, to the side that warp x weft has of the element."""
    split = {"element": [], "ply": [], "angle_deg": [], "thickness": []}
    yarns = {e: [np.array(v) for v in w] for e, *w in zip(
        cells["id"], zip(*(cells[f"warp_{x}"] for x in "xyz")), zip(*(cells[f"weft_{x}"] for x in "xyz")))}
    for e, ply, angle, shear, t in zip(*(plies[k] for k in ("element", "ply", "angle_deg", "shear_deg",
                                                           "thickness"))):
        normal = frame(corners[e])[2]
        turn = (90 - shear) * np.sign(normal @ np.cross(*yarns[e]))
        for weft in (0, 1):
            for key, value in (("element", e), ("ply", 2 * ply - 1 + weft),
                               ("angle_deg", angle + weft * turn), ("thickness", t / 2)):
                split[key].append(value)
    return split


def read_acp(path, corners, reference):
    """Warp and weft as halves of a ply; elements by their middles."""
    table = np.genfromtxt(path, delimiter=",", names=True)
    middles = {e: np.mean(places, 0) for e, places in corners.items()}
    rows = {}
    for row in table:
        place = np.array([row[x] for x in "xyz"])
        element = min(middles, key=lambda e: np.linalg.norm(middles[e] - place))
        assert np.allclose(middles[element], place, rtol=1e-14, atol=1e-14)
        for k in range(1, sum(name.startswith("thickness") for name in table.dtype.names) + 1):
            for weft, yarn in enumerate(("warp", "weft")):
                way = np.array([row[f"{yarn}_{k}_{x}"] for x in "xyz"])
                if not np.isnan(way[0]):
                    rows[element, 2 * k - 1 + weft] = way, row[f"thickness_{k}"] / 2
    return rows, {}


def check_order(layers, corners, side):
    """Along the element's normal: with the plies where it looks to their side, else against them."""
    for element, found in layers.items():
        along = (frame(corners[element])[2][2] > 0) == (side > 0)
        assert found == sorted(found, reverse=not along), (element, found)
    assert any(len(found) > 1 for found in layers.values())


def compare(name, mesh, expected, rows, layers, reference, side, within, yarns=False):
    mesh = mesh["mesh"]
    shapes = mesh.get("triangles", []) + mesh.get("quads", [])
    ids = mesh.get("ids") or range(1, len(shapes) + 1)
    shown = expected["cells"]["id"]  # from 0 where the mesh has no numbers
    number = dict(zip(shown, ids))
    corners = {i: [mesh["vertices"][v] for v in s] for i, s in zip(ids, shapes)}
    cells, plies = expected["cells"], expected["plies"]
    warp = {}
    if "warp_x" in cells:  # of a drape; a stack has many
        warp = dict(zip(ids, map(np.array, zip(cells["warp_x"], cells["warp_y"], cells["warp_z"]))))
    if yarns:
        plies, warp = split(plies, cells, {s: corners[number[s]] for s in number}), {}
    keys = [(number[e], p) for e, p in zip(plies["element"], plies["ply"])]
    assert set(rows) == set(keys), set(rows) ^ set(keys)
    if side:
        check_order(layers, corners, side)
    worst = collections.Counter()
    for key, angle, thickness in zip(keys, plies["angle_deg"], plies["thickness"]):
        is_direction, is_thickness = rows[key]
        _, _, normal = frame(corners[key[0]])
        both = [at(corners[key[0]], angle, reference)]
        if warp:
            both.append(unit(warp[key[0]] - normal * (warp[key[0]] @ normal)))
        for fibre in both:
            turn = math.degrees(math.atan2(np.linalg.norm(np.cross(fibre, is_direction)),
                                           abs(fibre @ is_direction)))
            worst["angle"] = max(worst["angle"], turn)
        worst["thickness"] = max(worst["thickness"], abs(is_thickness / thickness - 1))
    print(f"{name}: {len(rows)} rows, angles within {worst['angle']:.1e} degrees, "
          f"thicknesses within {worst['thickness']:.1e}")
    assert worst["angle"] <= ANGLE + 1.1 * within
    assert worst["thickness"] <= (1e-5 if name == "lsdyna" else 1e-7) + 1.1 * within / 100
    assert not within or worst["thickness"] > 1e-3  # else nothing was rounded


if __name__ == "__main__":
    name, mesh_file, map_file, deck = sys.argv[1:5]
    own = None
    if len(sys.argv) > 5 and sys.argv[5] != "-":
        own = [float(v) for v in sys.argv[5].split(",")]
    towards = int(sys.argv[6]) if len(sys.argv) > 6 else 0
    mesh_text, map_text = json.load(open(mesh_file)), json.load(open(map_file))
    shapes = mesh_text["mesh"].get("triangles", []) + mesh_text["mesh"].get("quads", [])
    numbers = mesh_text["mesh"].get("ids") or range(1, len(shapes) + 1)
    places = {i: [mesh_text["mesh"]["vertices"][v] for v in s] for i, s in zip(numbers, shapes)}
    found, order = globals()["read_" + name](deck, places, own)
    compare(name, mesh_text, map_text, found, order, own, towards,
            float(sys.argv[7]) if len(sys.argv) > 7 else 0, len(sys.argv) > 8)
