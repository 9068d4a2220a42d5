#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Reads a mesh of Gmsh (MSH 2.2) or a universal file by the pages of these formats, without the program's own code,
and compares nodes, elements and every field with the JSON document of the same map.
usage: field_mesh.py gmsh|unv FILE MESH.json MAP.json"""

import json
import math
import sys

VECTORS = ("warp", "weft", "k1_direction")
OWN = ("id", "pid")  # of the mesh itself
PLIES = {"angle": "angle_deg", "shear": "shear_deg", "thickness": "thickness",
         "fiber_volume_fraction": "fiber_volume_fraction"}


def read_gmsh(lines):
    """Nodes and elements by id, fields by name and element, names of properties."""
    nodes, elements, fields, names = {}, {}, {}, {}
    at = 0
    while at < len(lines):
        section = lines[at]
        end = lines.index(section.replace("$", "$End"), at)
        body = lines[at + 1:end]
        if section == "$MeshFormat":
            assert body == ["2.2 0 8"], body
        elif section == "$PhysicalNames":
            assert int(body[0]) == len(body) - 1
            for line in body[1:]:
                dimension, tag, name = line.split(maxsplit=2)
                assert dimension == "2"
                names[int(tag)] = name.strip('"')
        elif section == "$Nodes":
            assert int(body[0]) == len(body) - 1
            nodes = {int(w[0]): [float(x) for x in w[1:]] for w in map(str.split, body[1:])}
        elif section == "$Elements":
            assert int(body[0]) == len(body) - 1
            for kind, tags, *rest in (map(int, line.split()[1:]) for line in body[1:]):
                assert tags == 2 and len(rest[tags:]) == {2: 3, 3: 4}[kind]
            elements = {int(w[0]): ([int(n) for n in w[5:]], int(w[3])) for w in map(str.split, body[1:])}
        elif section == "$ElementData":
            assert body[0] == "1" and body[2:6] == ["1", "0", "3", "0"], body[:6]
            width, count = int(body[6]), int(body[7])
            rows = [line.split() for line in body[8:]]
            assert len(rows) == count == len(elements) and all(len(row) == width + 1 for row in rows)
            values = {int(row[0]): [float(x) for x in row[1:]] for row in rows}
            if width == 9:  # a symmetric tensor: XX XY XZ YX YY YZ ZX ZY ZZ
                assert all(v[1] == v[3] and v[2] == v[6] and v[5] == v[7] for v in values.values())
                values = {e: [v[0], v[4], v[8], v[1], v[5], v[2]] for e, v in values.items()}
            fields[body[1].strip('"')] = {e: v for e, v in values.items() if not math.isnan(sum(v))}
        at = end + 1
    return nodes, elements, fields, names


def read_unv(lines):
    """Likewise; of elements without a value a dataset says nothing."""
    nodes, elements, fields, names = {}, {}, {}, {}
    at = 0
    while at < len(lines):
        assert lines[at] == "    -1", lines[at]
        kind, end = int(lines[at + 1]), lines.index("    -1", at + 1)
        body = lines[at + 2:end]
        if kind == 164:
            assert body[0][:10] == "         1"
        elif kind == 2411:
            for k in range(0, len(body), 2):
                nodes[int(body[k][:10])] = [float(body[k + 1][25 * c:25 * c + 25]) for c in range(3)]
        elif kind == 2412:
            for k in range(0, len(body), 2):
                label, shape, prop, _, _, count = (int(body[k][10 * c:10 * c + 10]) for c in range(6))
                corners = [int(body[k + 1][10 * c:10 * c + 10]) for c in range(count)]
                assert count == {91: 3, 94: 4}[shape]
                elements[label] = (corners, prop)
        elif kind == 2467:
            k = 0
            while k < len(body):
                count, name = int(body[k].split()[7]), body[k + 1]
                rows = body[k + 2:k + 2 + (count + 1) // 2]
                members = [int(w) for row in rows for w in row.split()]
                assert members[::4] == [8] * count
                k += 2 + len(rows)
                for element in members[1::4]:
                    names[elements[element][1]] = name
        elif kind == 2414:
            assert body[2].strip() == "2"  # on elements
            _, _, characteristic, _, data, width = map(int, body[8].split())
            assert data == 2 and characteristic == {1: 1, 3: 2}[width]
            field = fields.setdefault(body[1].strip(), {})
            for k in range(13, len(body), 2):
                element, count = map(int, body[k].split())
                assert count == width
                field[element] = [float(body[k + 1][13 * c:13 * c + 13]) for c in range(width)]
        else:
            raise AssertionError(kind)
        at = end + 1
    return nodes, elements, fields, names


def wanted_fields(result, tensors):
    """Of the JSON document: by name, element and component."""
    cells = result["cells"]
    ids, wanted = cells["id"], {}
    tensor = ["k" + c for c in ("xx", "yy", "zz", "xy", "yz", "xz")]
    groups = {name: [f"{name}_{c}" for c in "xyz"] for name in ("warp", "weft", "k1")}
    grouped = {c: name for name, columns in groups.items() for c in columns}
    for column, values in cells.items():
        if column in OWN:
            continue
        if column in grouped:
            name = grouped[column]
            wanted["k1_direction" if name == "k1" else name] = {
                e: list(v) for e, *v in zip(ids, *(cells[c] for c in groups[name]))}
        elif column in tensor and tensors:
            wanted["permeability"] = {e: list(v) for e, *v in zip(ids, *(cells[c] for c in tensor))}
        else:
            wanted[column] = {e: [float(v)] for e, v in zip(ids, values) if v is not None}
    plies = result["plies"]
    for name, column in PLIES.items():
        for element, ply, value in zip(plies["element"], plies["ply"], plies.get(column, [])):
            wanted.setdefault(f"{name}_{ply}", {})[element] = [value]
    return wanted


def main():
    kind, path, mesh, result = sys.argv[1:]
    with open(path, encoding="ascii") as file:
        lines = file.read().split("\n")
    assert lines.pop() == ""
    nodes, elements, fields, _ = {"gmsh": read_gmsh, "unv": read_unv}[kind](lines)
    with open(mesh, encoding="ascii") as file:
        mesh = json.load(file)["mesh"]
    assert nodes == dict(zip(mesh["vertex_ids"], mesh["vertices"]))
    corners = [[mesh["vertex_ids"][c] for c in element] for element in mesh["triangles"] + mesh["quads"]]
    assert {e: c for e, (c, _) in elements.items()} == dict(zip(mesh["ids"], corners))
    with open(result, encoding="utf-8") as file:
        wanted = wanted_fields(json.load(file), kind == "gmsh")
    assert fields.keys() == wanted.keys(), (sorted(fields), sorted(wanted))
    for name, values in wanted.items():
        assert fields[name].keys() == values.keys(), name
        for element, row in values.items():
            near = 0 if kind == "gmsh" else 6e-6
            assert all(abs(a - b) <= near * abs(b) for a, b in zip(fields[name][element], row)), (name, element)
    print(f"# {kind}: {len(nodes)} nodes, {len(elements)} elements, {len(fields)} fields")


if __name__ == "__main__":
    main()
