#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Opens a result with a reader that others wrote, and compares what that finds with the result as
JSON. Usage: read.py KIND FILE [RESULT.json]. Exit status 1 and a traceback when something differs."""

import csv
import json
import os
import sys
import xml.etree.ElementTree


def load(path):
    with open(path, encoding="utf-8") as file:
        return json.load(file)


def same(found, expected, what):
    assert len(found) == len(expected), f"{what}: {len(found)} values, not {len(expected)}"
    assert all(a == b for a, b in zip(found, expected)), f"{what} differs"


def vtk_arrays(data):
    from vtk.util.numpy_support import vtk_to_numpy

    arrays = {data.GetArrayName(k): vtk_to_numpy(data.GetArray(k))
              for k in range(data.GetNumberOfArrays())}
    assert None not in arrays, "an array without a name"
    return arrays


def compare_arrays(arrays, columns, skipped=()):
    """Every column is there: as an array of its name, or as a component of a vector."""
    for name, values in columns.items():
        if name in skipped:
            continue
        base, axis = name[:-2], "xyz".find(name[-1])
        if len(name) > 2 and name[-2] == "_" and axis >= 0 and name not in arrays:
            base = base if arrays.get(base) is not None and arrays[base].ndim == 2 \
                else base + "_direction"
            same(arrays[base][:, axis], values, name)
        else:
            same(arrays[name], values, name)


def check_tensor(arrays):
    import numpy

    k = arrays["permeability"]
    full = k[:, [0, 3, 5, 3, 1, 4, 5, 4, 2]].reshape(-1, 3, 3)
    found = numpy.sort(numpy.linalg.eigvalsh(full), axis=1)
    names = ("k1", "k2", "k3")
    expected = numpy.sort(numpy.column_stack([arrays[n] for n in names]), axis=1)
    assert numpy.allclose(found, expected, rtol=1e-9, atol=0), "principal permeabilities"


def read_vtp(path, result):
    import vtk
    from vtk.util.numpy_support import vtk_to_numpy

    reader = vtk.vtkXMLPolyDataReader()
    reader.SetFileName(path)
    reader.Update()
    data = reader.GetOutput()
    assert reader.GetErrorCode() == 0
    nodes, cells = result["nodes"], result["cells"]
    points = vtk_to_numpy(data.GetPoints().GetData())
    for axis, name in enumerate("xyz"):
        same(points[:, axis], nodes[name], name)
    compare_arrays(vtk_arrays(data.GetPointData()), nodes, "xyz")
    arrays = vtk_arrays(data.GetCellData())
    compare_arrays(arrays, cells)
    if "k1" in cells:
        check_tensor(arrays)
    place = {(i, j): k for k, (i, j) in enumerate(zip(nodes["i"], nodes["j"]))}
    corners = vtk_to_numpy(data.GetPolys().GetConnectivityArray()).reshape(-1, 4)
    assert len(corners) == len(cells["i"])
    for (i, j), own in zip(zip(cells["i"], cells["j"]), corners):
        expected = [place[i, j], place[i + 1, j], place[i + 1, j + 1], place[i, j + 1]]
        assert list(own) == expected, f"corners of cell {i}, {j}"


def read_vtu(path, columns=None):
    import vtk

    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(path)
    reader.Update()
    data = reader.GetOutput()
    assert reader.GetErrorCode() == 0 and data.GetNumberOfCells() > 0
    assert all(data.GetCellType(k) in (5, 9) for k in range(data.GetNumberOfCells()))
    arrays = vtk_arrays(data.GetCellData())
    assert all(len(values) == data.GetNumberOfCells() for values in arrays.values())
    if columns:
        tensor = {"kxx": 0, "kyy": 1, "kzz": 2, "kxy": 3, "kyz": 4, "kxz": 5}
        compare_arrays(arrays, columns, tensor)
        for name, component in tensor.items():
            same(arrays["permeability"][:, component], columns[name], name)
    if "permeability" in arrays:
        check_tensor(arrays)


def read_npz(path, result):
    import numpy

    reasons = ["boundary", "collapsed", "no_convergence", "degenerate", "extent", "fold"]
    with numpy.load(path) as arrays:
        for table in ("nodes", "cells", "front"):
            for name, values in result[table].items():
                array = arrays[f"{table}.{name}"]
                assert array.dtype == numpy.float64 and array.ndim == 1
                found = [reasons[int(k)] for k in array] if name == "reason" else array
                same(found, values, f"{table}.{name}")
        assert len(arrays.files) == sum(len(result[t]) for t in ("nodes", "cells", "front", "rim"))


def read_csv(path, result):
    with open(path, newline="", encoding="utf-8") as file:
        rows = list(csv.reader(file))
    for table in ("nodes", "cells"):
        if rows[0] == list(result[table]):
            for k, name in enumerate(rows[0]):
                same([float(row[k]) for row in rows[1:]], result[table][name], name)
            return
    raise AssertionError(f"no table has the columns {rows[0]}")


def read_glb(path, result):
    """What the validator does not say: that the numbers are those of the net."""
    import struct

    import numpy

    with open(path, "rb") as file:
        data = file.read()
    magic, version, length, size, kind = struct.unpack("<4sII I4s", data[:20])
    assert (magic, version, length, kind) == (b"glTF", 2, len(data), b"JSON")
    gltf, start = json.loads(data[20:20 + size]), 20 + size + 8
    nodes = len(result["nodes"]["x"])
    positions = numpy.frombuffer(data, "<f4", 3 * nodes, start).reshape(-1, 3)
    for axis, name in enumerate("xyz"):
        same(positions[:, axis], numpy.float32(result["nodes"][name]), name)
    view = gltf["bufferViews"][gltf["accessors"][2]["bufferView"]]
    indices = numpy.frombuffer(data, "<u4", view["byteLength"] // 4, start + view["byteOffset"])
    assert len(indices) == 6 * len(result["cells"]["i"]) and indices.max() < nodes
    view = gltf["bufferViews"][gltf["accessors"][1]["bufferView"]]
    colours = numpy.frombuffer(data, "<u2", 4 * nodes, start + view["byteOffset"]).reshape(-1, 4)
    light = colours[:, :3] @ (0.2126, 0.7152, 0.0722)
    shear = numpy.abs(result["nodes"]["shear_deg"])
    order = numpy.argsort(shear, kind="stable")
    assert (numpy.diff(light[order]) >= -1e-9).all(), "more shear is not lighter"


def pattern_area(result):
    return result["summary"]["flat_area"]


def shoelace(points):
    return sum(x * v - u * y for (x, y), (u, v) in zip(points, points[1:] + points[:1])) / 2


def read_dxf(path, result):
    import ezdxf

    document = ezdxf.readfile(path)
    assert not document.audit().errors
    assert document.dxfversion == "AC1009"
    model = document.modelspace()
    cut = model.query("POLYLINE[layer=='CUT']")
    assert cut and all(line.is_closed for line in cut)
    area = sum(shoelace([tuple(v.dxf.location)[:2] for v in line.vertices]) for line in cut)
    expected = pattern_area(result)
    assert abs(area - expected) < 1e-3 * expected, f"area {area}, not {expected}"
    locked = sum(result["cells"].get("locked", []))
    assert len(model.query("LINE[layer=='LOCKED']")) == locked
    assert len(model.query("CIRCLE[layer=='START']")) == 1


def read_svg(path, result, metres):
    """`metres`: of the drape's unit."""
    root = xml.etree.ElementTree.parse(path).getroot()
    space = {"s": "http://www.w3.org/2000/svg"}
    assert root.attrib["width"].endswith("mm")
    box = [float(n) for n in root.attrib["viewBox"].split()]
    assert box[2] == float(root.attrib["width"][:-2]), "not at true scale"
    cut = root.find(".//s:path[@id='cut']", space).attrib["d"]
    area = 0.0
    for polygon in cut.split("Z"):
        numbers = [float(n) for n in polygon.replace("M", " ").split()]
        area += shoelace(list(zip(numbers[::2], numbers[1::2])))
    expected = pattern_area(result) * (metres * 1e3) ** 2
    assert abs(area - expected) < 1e-3 * expected, f"area {area}, not {expected}"
    cells = root.findall(".//s:g[@id='locked']/s:rect", space)
    locked = sum(float(c.attrib["width"]) for c in cells) / (
        result["grid"]["spacing"][0] * metres * 1e3)
    assert abs(locked - sum(result["cells"].get("locked", []))) < 1e-6
    assert root.find("s:title", space).text


def lcmsim_number(field):
    """As LCMsim reads it: no letter E, and a sign within the number begins its exponent."""
    text = field.strip().replace("E", "").replace("e", "")
    for k in range(1, len(text)):
        if text[k] in "+-":
            return float(text[:k] + "e" + text[k:])
    return float(text)


PART_COLUMNS = (
    "name,type,part_id,thickness,porosity,porosity_noise,permeability,permeability_noise,alpha,"
    "refdir1,refdir2,refdir3,porosity_1,p_1,porosity_2,p_2,n_CK,permeability_Z,thickness_DM,"
    "porosity_DM,permeability_DM,permeability_DM_Z").split(",")


def read_bulk(path):
    """mesh.bdf by LCMsim's rules: fields of eight characters."""
    nodes, parts = {}, {}
    with open(path, encoding="ascii") as file:
        for line in file:
            fields = [line[k:k + 8].strip() for k in range(8, 64, 8)]
            if line.startswith("GRID    "):
                assert fields[1] == ""
                nodes[int(fields[0])] = [lcmsim_number(f) for f in fields[2:5]]
            elif line.startswith("CTRIA3  "):
                corners = [int(f) for f in fields[2:5]]
                assert len(set(corners)) == 3 and all(c in nodes for c in corners)
                parts[int(fields[0])] = int(fields[1])
    return nodes, parts


def read_lcmsim(folder, _=None):
    import meshio

    mesh = os.path.join(folder, "mesh.bdf")
    nodes, parts = read_bulk(mesh)
    assert nodes and parts
    with open(os.path.join(folder, "part_description.csv"), newline="", encoding="ascii") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == PART_COLUMNS
    assert {int(row["part_id"]) for row in rows} == set(parts.values())
    assert len(rows) <= 127 and all(1 <= int(row["part_id"]) <= 127 for row in rows)
    for row in rows:
        assert row["type"] == {"1": "inlet", "127": "outlet"}.get(row["part_id"], "base")
        assert 0 < float(row["porosity"]) <= 0.99 and float(row["thickness"]) > 0
        assert row["porosity"] == row["porosity_1"] == row["porosity_2"]
        assert float(row["permeability"]) > 0 and 0 < float(row["alpha"]) <= 1
        assert any(c in row["porosity"] for c in ".e") and any(c in row["permeability"] for c in ".e")
        direction = [float(row[f"refdir{k}"]) for k in (1, 2, 3)]
        assert abs(sum(d * d for d in direction) - 1) < 1e-6
    with open(os.path.join(folder, "simulation_params.csv"), newline="", encoding="ascii") as file:
        (row,) = csv.DictReader(file)
    assert float(row["p_ref"]) == 101325 and float(row["mu_resin"]) > 0
    found = meshio.read(mesh, file_format="nastran")
    assert len(found.points) == len(nodes)
    assert sum(len(block.data) for block in found.cells) == len(parts)
    for point, expected in zip(found.points, nodes.values()):
        assert max(abs(a - b) for a, b in zip(point, expected)) == 0


def read_lcmsim_h5(path, result, mesh, metres="1"):
    """What create_LcmMesh of LCMsim v2 takes, by name, type and shape as Julia has stored it; the
    values of each cell are its element's own, lengths in m, of which the mesh's unit has so many."""
    import collections

    import h5py
    import numpy

    unit = float(metres)
    shapes = mesh["mesh"].get("triangles", []) + mesh["mesh"].get("quads", [])
    with h5py.File(path) as file:
        cells, points = file["mesh/cells"], file["mesh/vertices"]
        count = cells.shape[1]
        assert cells.dtype == "<i8" and cells.shape == (3, count)
        assert points.dtype == "<f8" and points.shape == (3, len(mesh["mesh"]["vertices"]))
        p = {name: file["properties"][name][...] for name in file["properties"]}
        names = dict(file["properties"].attrs)
        cells, points = cells[...].T - 1, points[...].T
    for name in ("part_id", "type"):
        assert p[name].dtype == "<i8" and p[name].shape == (count,)
    for name in ("thickness", "porosity", "permeability", "alpha", "volume", "area", "ap", "cp"):
        assert p[name].dtype == "<f8" and p[name].shape == (count,)
    assert p["reference_direction"].shape == (3, count)
    parts = (b"base", b"inlet", b"outlet", b"channel")
    assert names == {str(k + 1): parts[k] for k in set(result["cells"]["role"])}
    of = {tuple(sorted(c)): e for e, s in enumerate(shapes) for c in ([s[0:3]] if len(s) == 3 else
          [s[0:3], [s[0], s[2], s[3]]])}
    edges = collections.Counter(tuple(e) for c in cells for e in ((c[0], c[1]), (c[1], c[2]),
                                                                  (c[0], c[2])))
    columns = result["cells"]
    assert len(of) == count
    assert numpy.array_equal(points, unit * numpy.array(mesh["mesh"]["vertices"], dtype=float))
    for k, cell in enumerate(cells):
        e = of[tuple(cell)]
        a, b, c = points[cell]
        area = numpy.linalg.norm(numpy.cross(b - a, c - a)) / 2
        assert p["permeability"][k] == columns["k1"][e]
        assert p["thickness"][k] == unit * columns["thickness"][e]
        assert p["alpha"][k] == columns["k2"][e] / columns["k1"][e]
        assert p["porosity"][k] == p["ap"][k] == columns["porosity"][e] and p["cp"][k] == 0
        assert all(p["reference_direction"][i, k] == columns["k1_" + x][e] for i, x in enumerate("xyz"))
        assert abs(p["area"][k] / area - 1) < 1e-12
        assert abs(p["volume"][k] / area / p["thickness"][k] - 1) < 1e-12
        wall = 1 in (edges[cell[0], cell[1]], edges[cell[1], cell[2]], edges[cell[0], cell[2]])
        assert p["type"][k] == {1: -3 if wall else 1, 2: -1, 3: -2, 4: -3 if wall else 1}[p["part_id"][k]]
        assert p["part_id"][k] == 1 + columns["role"][e]


def read_lims(path, result, mesh, metres="1", reference=None):
    """A DMP file as its page says: lines in free format, without those that begin with #; headings
    by what they count. The tensor of each element, from its first side or a direction, has k1 and k2
    of the map, along the map's direction in space, projected."""
    import cards
    import numpy

    unit = float(metres)
    with open(path, encoding="ascii") as file:
        lines = file.read().splitlines()
    notes = [line.split() for line in lines if line.startswith("#")]
    lines = [line.split() for line in lines if line and not line.startswith("#")]
    assert lines[0][:4] == ["Number", "of", "nodes", ":"]
    count = int(lines[0][4])
    nodes = numpy.array(lines[3:3 + count], dtype=float)
    assert numpy.array_equal(nodes[:, 0], numpy.arange(1, count + 1))
    head = lines[3 + count]
    assert head[:4] == ["Number", "of", "elements", ":"]
    rows = lines[6 + count:6 + count + int(head[4])]
    assert [row[0] for row in rows] == [str(k + 1) for k in range(len(rows))]
    assert lines[6 + count + len(rows)] == ["Resin", "Viscosity", "model", "NEWTON"]
    assert len(lines) == 8 + count + len(rows) and float(lines[-1][2]) > 0
    columns, shapes = result["cells"], mesh["mesh"].get("triangles", []) + mesh["mesh"].get("quads", [])
    out = {int(n[4].strip(",")) for n in notes if n[1:3] == ["left", "out:"]}
    kept = [e for e in range(len(shapes)) if columns["id"][e] not in out]
    assert len(rows) == len(kept)
    worst, gates = 0, {"gate": set(), "vent": set()}
    for row, e in zip(rows, kept):
        n = int(row[1])
        assert n == len(shapes[e]) and len(row) == 2 + n + 5
        place = nodes[[int(k) - 1 for k in row[2:2 + n]], 1:]
        assert numpy.array_equal(place, unit * numpy.array([mesh["mesh"]["vertices"][k] for k in shapes[e]]))
        h, vf, xx, xy, yy = map(float, row[2 + n:])
        assert h == unit * columns["thickness"][e]
        assert abs(vf - columns["fiber_volume_fraction"][e]) < 1e-15
        x, y, normal = cards.frame(place, [float(v) for v in reference.split(",")] if reference else None)
        (k2, k1), axes = numpy.linalg.eigh([[xx, xy], [xy, yy]])
        assert abs(k1 / columns["k1"][e] - 1) < 1e-12 and abs(k2 / columns["k2"][e] - 1) < 1e-12
        role = columns["role"][e] if "role" in columns else 0
        if k2 < 0.9 * k1:
            d = numpy.array([columns["k1_" + a][e] for a in "xyz"])
            d = cards.unit(d - normal * (d @ normal))
            mine = axes[0, 1] * x + axes[1, 1] * y
            worst = max(worst, numpy.degrees(numpy.arcsin(numpy.linalg.norm(numpy.cross(d, mine)))))
        for name, number in (("gate", 1), ("vent", 2)):
            if role == number:
                gates[name] |= set(row[2:2 + n])
    assert worst < 1e-6
    for name, own in gates.items():
        assert own - gates["gate"] <= {n[3] for n in notes if n[1:3] == [name + ":", "node"]} <= own
    print(f"# {len(rows)} elements, directions within {worst:.1e} degrees")


def read_compost(path, result, mesh):
    """CompoST: every object has fields of its class alone, by CompositeStandard.py 0.9.5, ids are
    there once, and each ply's mesh and lists are the rows of the map."""
    item = {"memberName", "additionalParameters", "ID"}
    element = item | {"subComponents"}
    known = {
        "CompositeDB": {"name", "allMaterials", "allComposite", "allGeometry", "allSimulations", "fileMetadata"},
        "Spline": item | {"points", "breaks"},
        "FileMetadata": {"version", "maxID"}, "GenericMaterial": item, "Sequence": element,
        "Ply": element | {"material", "splineRelimitationRef"}, "Piece": element | {"material", "splineRelimitationRef"},
        "DrapingSimulation": item | {"plyID", "maxShearAngle", "drapedMesh", "mappedShearAngles"},
        "AreaMesh": item | {"meshElements"}, "MeshElement": item | {"nodes"}, "Point": item | {"x", "y", "z"}}
    document, ids = load(path), {}

    def visit(value):
        if isinstance(value, list):
            for one in value:
                visit(one)
        elif isinstance(value, dict) and "_serialized_type" in value:
            module, _, name = value["_serialized_type"].rpartition(".")
            assert module == "CompoST.CompositeStandard" and set(value) - {"_serialized_type"} <= known[name]
            if "ID" in value:  # the same object again has the same content
                assert ids.setdefault(value["ID"], value) == value
            for key, one in value.items():
                if key != "additionalParameters":
                    visit(one)

    visit(document)
    assert max(ids) <= document["fileMetadata"]["maxID"]
    (sequence,) = document["allComposite"]
    leaves = [piece for ply in sequence["subComponents"] for piece in ply.get("subComponents", [ply])]
    assert [leaf["material"] for leaf in leaves] == document["allMaterials"]
    # Every spline is the edge of one ply or piece, closed, and broken at corners alone.
    splines = {one["ID"]: one for one in document.get("allGeometry", [])}
    assert sorted(splines) == sorted(leaf["splineRelimitationRef"] for leaf in leaves if "splineRelimitationRef" in leaf)
    assert "allGeometry" not in document or len(splines) == len(leaves)
    for one in splines.values():
        assert one["points"][0] == one["points"][-1] and all(k + 1 < len(one["points"]) for k in one["breaks"])
    cells, plies = result["cells"], result["plies"]
    place = {e: k for k, e in enumerate(cells["id"])}
    shapes, points = mesh["mesh"].get("triangles", []) + mesh["mesh"].get("quads", []), mesh["mesh"]["vertices"]
    whole = [(p, s) for p, s in dict.fromkeys(zip(plies["ply"], plies.get("piece", [0] * len(plies["ply"]))))]
    whole.sort()
    assert len(document["allSimulations"]) == len(leaves) == len(whole)
    assert [len(ply.get("subComponents", [])) for ply in sequence["subComponents"]] == [
        sum(p == n and s > 0 for p, s in whole) for n in dict.fromkeys(p for p, s in whole)]
    for leaf, run, (p, s) in zip(leaves, document["allSimulations"], whole):
        assert run["plyID"] == leaf["ID"]
        rows = [k for k, n in enumerate(plies["ply"]) if n == p and plies.get("piece", [0] * (k + 1))[k] == s]
        more = run["additionalParameters"]
        assert run["mappedShearAngles"] == [plies["shear_deg"][k] for k in rows]
        assert run["maxShearAngle"] == max(abs(g) for g in run["mappedShearAngles"])
        for name in ("element", "angle_deg", "thickness", "fiber_volume_fraction"):
            assert more[name] == [plies[name][k] for k in rows], name
        assert more["k1"] == [cells["k1"][place[e]] for e in more["element"]]
        found = [[[n["x"], n["y"], n["z"]] for n in one["nodes"]] for one in run["drapedMesh"]["meshElements"]]
        assert found == [[points[v] for v in shapes[place[e]]] for e in more["element"]]
    print(f"# {len(leaves)} plies or pieces, {len(plies['ply'])} elements")


def read_vtu_plies(path, result):
    """Arrays by ply: the rows of the table, and not a number where there is none."""
    import numpy
    import vtk

    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(path)
    reader.Update()
    arrays = vtk_arrays(reader.GetOutput().GetCellData())
    plies, place = result["plies"], {e: k for k, e in enumerate(result["cells"]["id"])}
    names = {"angle_deg": "angle", "shear_deg": "shear", "thickness": "thickness",
             "fiber_volume_fraction": "fiber_volume_fraction"}
    for ply in range(1, max(plies["ply"]) + 1):
        rows = [k for k, p in enumerate(plies["ply"]) if p == ply]
        for column, name in names.items():
            array = arrays[f"{name}_{ply}"].copy()
            at = [place[plies["element"][k]] for k in rows]
            assert all(array[at] == numpy.array(plies[column])[rows])
            array[at] = 0
            assert numpy.isnan(array).sum() == len(array) - len(rows)


def main():
    kind, path, *rest = sys.argv[1:]
    if kind == "svg":
        read_svg(path, load(rest[0]), float(rest[1]))
        return
    readers = {"vtp": read_vtp, "vtu": read_vtu, "npz": read_npz, "csv": read_csv, "glb": read_glb,
               "dxf": read_dxf, "lcmsim": read_lcmsim, "lcmsim-h5": read_lcmsim_h5, "lims": read_lims, "compost": read_compost,
               "vtu-plies": read_vtu_plies}
    readers[kind](path, *[load(name) if name.endswith(".json") else name for name in rest])


if __name__ == "__main__":
    main()
