# SPDX-License-Identifier: MIT
"""The cloth as FreeCAD flattens a mesh (its module flatmesh: least squares conformal, then relaxed as a membrane), with
the settings that the draper of its Composites workbench has: a square grid of the flat cloth, put back on the
triangles. Run by freecadcmd; CASES and NETS are folders, with seconds of a processor in NETS/seconds.json."""
import json
import os
import pathlib
import time

import flatmesh
import Mesh
import numpy as np
import Part
from FreeCAD import Vector

STEPS, WEIGHT = 5, 0.95  # of the relaxation, as freecad/Composites/tools/draper.py has them
CELLS = 80  # of the mesh, along u and along v of a face


def spline(document):
    """A surface as geomdl writes it."""
    surface, net = Part.BSplineSurface(), document["control_points"]
    rows = np.array(net["points"]).reshape(document["size_u"], document["size_v"], 3)
    weights = np.array(net.get("weights") or np.ones(rows.shape[:2])).reshape(rows.shape[:2])
    knots = [np.unique(document[f"knotvector_{way}"], return_counts=True) for way in "uv"]
    surface.buildFromPolesMultsKnots([[Vector(*point) for point in row] for row in rows.tolist()],
                                     *(counts.tolist() for _, counts in knots), *(at.tolist() for at, _ in knots),
                                     False, False, document["degree_u"], document["degree_v"], weights.tolist())
    return surface.toShape()


def mesh_of(path):
    """Points and triangles: of one face a grid of its parameters, of several faces what FreeCAD makes of them."""
    if path.suffix == ".stl":
        points, triangles = Mesh.Mesh(str(path)).Topology
        return np.array([list(point) for point in points]), np.array(triangles)
    shape = Part.read(str(path)) if path.suffix == ".step" else spline(json.loads(path.read_text()))
    if len(shape.Faces) > 1:
        points, triangles = Mesh.Mesh(shape.tessellate(0.01)).Topology
        return np.array([list(point) for point in points]), np.array(triangles)
    surface, (u0, u1, v0, v1) = shape.Faces[0].Surface, shape.Faces[0].ParameterRange
    points = np.array([list(surface.value(u, v)) for u in np.linspace(u0, u1, CELLS + 1)
                       for v in np.linspace(v0, v1, CELLS + 1)])
    first = (np.arange(CELLS)[:, None] * (CELLS + 1) + np.arange(CELLS)).ravel()
    corners = np.stack([first, first + CELLS + 1, first + CELLS + 2, first + 1], axis=1)
    return points, corners[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)


def barycentric(triangles, at):
    """Of points (n x d) in triangles (m x 3 x d): n x m x 3, by least squares where d is 3."""
    a, b = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    off = at[:, None] - triangles[None, :, 0]
    aa, ab, bb = (a * a).sum(-1), (a * b).sum(-1), (b * b).sum(-1)
    u, v = (off * a).sum(-1), (off * b).sum(-1)
    det = aa * bb - ab**2
    s, t = (bb * u - ab * v) / det, (aa * v - ab * u) / det
    return np.stack([1 - s - t, s, t], axis=-1)


def net_of(task, points, triangles):
    """The nodes (i, j, x, y, z) that lie on the mesh."""
    unwrapper = flatmesh.FaceUnwrapper(points, triangles)
    unwrapper.findFlatNodes(STEPS, WEIGHT)
    flat = np.array(unwrapper.ze_nodes)[:, :2]
    corners, cloth = points[triangles], flat[triangles]
    start = np.array(task["start"])
    shares = barycentric(corners, start[None])[0]
    off = np.linalg.norm((shares[:, :, None] * corners).sum(axis=1) - start, axis=1)
    inside = np.where(shares.min(axis=1) > -1e-6, off, np.inf)
    here = int(np.argmin(inside))
    origin = (shares[here][:, None] * cloth[here]).sum(axis=0)
    ahead = barycentric(corners[here][None], (start + 1e-3 * task["spacing"] * np.array(task["warp"]))[None])[0, 0]
    x = (ahead[:, None] * cloth[here]).sum(axis=0) - origin
    x /= np.linalg.norm(x)
    side = np.sign(np.linalg.det(cloth[:, 1:] - cloth[:, :1]).sum())
    y = side * np.array([-x[1], x[0]])
    extent, rows = task["extent"], []
    for i in range(extent["warp"][0], extent["warp"][1] + 1):
        js = np.arange(extent["weft"][0], extent["weft"][1] + 1)
        at = origin + task["spacing"] * (i * x + js[:, None] * y)
        shares = barycentric(cloth, at)
        best = shares.min(axis=2).argmax(axis=1)
        for j, k, share in zip(js.tolist(), best, shares[np.arange(len(js)), best]):
            if share.min() > -1e-9:
                rows.append((i, j, *(share[:, None] * corners[k]).sum(axis=0).tolist()))
    return rows


def main():
    cases, nets, seconds = pathlib.Path(os.environ["CASES"]), pathlib.Path(os.environ["NETS"]), {}
    for folder in sorted(cases.iterdir()):
        task = json.loads((folder / "task.json").read_text())
        if task["pre_shear_deg"]:
            continue  # a flattening knows no cloth that was sheared before
        points, triangles = mesh_of(folder / task["geometry"])
        begun = time.process_time()
        rows = net_of(task, points, triangles)
        seconds[folder.name] = time.process_time() - begun
        lines = ["i,j,x,y,z", *(",".join(map(repr, row)) for row in rows)]
        (nets / f"{folder.name}-FreeCAD.csv").write_text("\n".join(lines) + "\n")
    (nets / "seconds.json").write_text(json.dumps(seconds))


main()
