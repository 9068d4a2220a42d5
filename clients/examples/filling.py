#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""From a drape request to a filled mould: drapes the fabric, maps its fields on a mesh and computes
how resin fills the mould by Darcy's law, once with the draped fields and once with those of the flat
fabric. Needs DOLFINx and Matplotlib (Debian: python3-dolfinx-real, python3-matplotlib).

    python3 filling.py request.json [-o fronts.png] [--drape build/drape] [--cells 40]
    python3 filling.py --check        the flow against exact solutions

The request has one untrimmed NURBS surface, a thickness, a fibre volume fraction and a permeability.

The flow: q = -(K / mu) grad p in the tangent plane, div(h q) = 0 where there is resin, p = p_inlet at
the inlet and 0 at the front. Pressures are linear on the triangles. Each node owns the pore volume
V_i = int phi h N_i; what the assembled equation says flows to a node, Q_i = -sum_j A_ij p_j, fills it.
A step lasts until the next node is full (the FE/CV method of mould filling: Bruschke and Advani,
Polymer Composites 11, 1990).
"""

import argparse
import json
import logging
import os
import subprocess
import sys
import tempfile

import numpy
import scipy.sparse
import scipy.sparse.linalg
import ufl
from dolfinx import fem, mesh as meshes
from mpi4py import MPI

logging.disable(logging.INFO)  # of the form compiler

VISCOSITY = 0.1  # Pa s
PRESSURE = 1e5  # Pa at the inlet, over that in the cavity
METRES = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "um": 1e-6, "in": 0.0254, "ft": 0.3048}


# ---- the mesh ----

def basis(degree, knots, x):
    """The values of all B-splines of a degree at x (Cox and de Boor)."""
    knots = numpy.asarray(knots, float)
    span = min(max(numpy.searchsorted(knots, x, "right") - 1, degree), len(knots) - degree - 2)
    values = numpy.zeros(len(knots) - 1)
    values[span] = 1
    for k in range(1, degree + 1):
        for i in range(len(knots) - 1 - k):
            left, right = knots[i + k] - knots[i], knots[i + k + 1] - knots[i + 1]
            values[i] = ((x - knots[i]) / left * values[i] if left else 0) + (
                (knots[i + k + 1] - x) / right * values[i + 1] if right else 0)
    return values[:len(knots) - degree - 1]


def surface_points(surface, us, vs):
    control = surface["control_points"]
    weights = None
    if isinstance(control, dict):
        control, weights = control["points"], control.get("weights")
    net = numpy.array(control).reshape(surface["size_u"], surface["size_v"], 3)
    weights = numpy.array(weights if weights is not None else numpy.ones(net.shape[:2]))
    weights = weights.reshape(net.shape[:2])
    bu = [basis(surface["degree_u"], surface["knotvector_u"], u) for u in us]
    bv = [basis(surface["degree_v"], surface["knotvector_v"], v) for v in vs]
    above = numpy.einsum("ai,bj,ij,ijk->abk", bu, bv, weights, net)
    return above / numpy.einsum("ai,bj,ij->ab", bu, bv, weights)[..., None]


def grid_triangles(rows, columns):
    """Triangles over a grid of rows x columns points, the diagonals turned about every other cell."""
    triangles = []
    for i in range(rows - 1):
        for j in range(columns - 1):
            a, b, c, d = (i * columns + j, (i + 1) * columns + j, (i + 1) * columns + j + 1,
                          i * columns + j + 1)
            triangles += [[a, b, c], [a, c, d]] if (i + j) % 2 else [[a, b, d], [b, c, d]]
    return numpy.array(triangles)


def mesh_of(request, cells):
    surface = request["surface"]
    us = numpy.linspace(surface["knotvector_u"][surface["degree_u"]],
                        surface["knotvector_u"][-surface["degree_u"] - 1], cells + 1)
    vs = numpy.linspace(surface["knotvector_v"][surface["degree_v"]],
                        surface["knotvector_v"][-surface["degree_v"] - 1], cells + 1)
    return surface_points(surface, us, vs).reshape(-1, 3), grid_triangles(cells + 1, cells + 1)


# ---- the fields ----

def map_fields(drape, request, points, triangles):
    """Thickness in the request's unit, porosity, permeability tensor in m^2 of each triangle."""
    with tempfile.TemporaryDirectory() as folder:
        mesh = os.path.join(folder, "mesh.json")
        with open(mesh, "w", encoding="utf-8") as file:
            json.dump({"mesh": {"vertices": points.tolist(), "triangles": triangles.tolist()}}, file)
        text = subprocess.run([drape, "--map", mesh, request], check=True,
                              stdout=subprocess.PIPE).stdout
    cells = {name: numpy.array(values) for name, values in json.loads(text)["cells"].items()}
    if "kxx" not in cells or "porosity" not in cells:
        sys.exit("filling: the request needs a thickness, a fibre volume fraction and a permeability")
    if cells["porosity"].min() <= 0:
        sys.exit("filling: the cavity is too thin for the sheared fabric; nothing is left for resin")
    k = [[cells[name] for name in row] for row in
         (("kxx", "kxy", "kxz"), ("kxy", "kyy", "kyz"), ("kxz", "kyz", "kzz"))]
    return cells, cells["thickness"], cells["porosity"], numpy.transpose(k, (2, 0, 1))


def flat_fields(cells, points, triangles):
    """What a simulation without a drape takes: thickness, porosity, k1 and k2 of the cloth where it is
    sheared least, along one direction, that of the warp there, everywhere."""
    best = int(numpy.argmin(numpy.abs(cells["shear_deg"])))
    warp = numpy.array([cells["warp_" + axis][best] for axis in "xyz"])
    edges = points[triangles]
    normals = numpy.cross(edges[:, 1] - edges[:, 0], edges[:, 2] - edges[:, 0])
    normals /= numpy.linalg.norm(normals, axis=1)[:, None]
    first = warp - (normals @ warp)[:, None] * normals
    first /= numpy.linalg.norm(first, axis=1)[:, None]
    second = numpy.cross(normals, first)
    along = numpy.array([cells["k1_" + axis][best] for axis in "xyz"]) @ warp
    k1, k2 = cells["k1"][best], cells["k2"][best]
    if abs(along) < 0.5 ** 0.5:
        k1, k2 = k2, k1
    tensor = (k1 * first[:, :, None] * first[:, None, :]
              + k2 * second[:, :, None] * second[:, None, :])
    ones = numpy.ones(len(triangles))
    return cells["thickness"][best] * ones, cells["porosity"][best] * ones, tensor


# ---- the flow ----

class Mould:
    """The assembled equation: A_ij = int (h / mu) grad N_i . K grad N_j, V_i = int phi h N_i."""

    def __init__(self, points, triangles, thickness, porosity, tensor):
        domain = ufl.Mesh(ufl.VectorElement("Lagrange", ufl.Cell("triangle", geometric_dimension=3), 1))
        mesh = meshes.create_mesh(MPI.COMM_WORLD, triangles, points, domain)
        cells = numpy.array(mesh.topology.original_cell_index)
        scalars = fem.FunctionSpace(mesh, ("DG", 0))
        tensors = fem.TensorFunctionSpace(mesh, ("DG", 0), (3, 3))
        h, pores, k = fem.Function(scalars), fem.Function(scalars), fem.Function(tensors)
        h.x.array[:] = thickness[cells]
        pores.x.array[:] = (thickness * porosity)[cells]
        k.x.array[:] = tensor[cells].reshape(-1)
        linear = fem.FunctionSpace(mesh, ("Lagrange", 1))
        u, v = ufl.TrialFunction(linear), ufl.TestFunction(linear)
        flow = fem.form(h / VISCOSITY * ufl.inner(k * ufl.grad(u), ufl.grad(v)) * ufl.dx)
        matrix = fem.petsc.assemble_matrix(flow)
        matrix.assemble()
        rows, columns, values = matrix.getValuesCSR()
        self.matrix = scipy.sparse.csr_matrix((values, columns, rows))
        self.volume = fem.petsc.assemble_vector(fem.form(pores * v * ufl.dx)).array.copy()
        # Of each vertex of the caller's the unknown.
        self.unknown = numpy.empty(len(points), int)
        nodes = mesh.geometry.input_global_indices
        for cell in range(len(triangles)):
            for node, dof in zip(mesh.geometry.dofmap.links(cell), linear.dofmap.cell_dofs(cell)):
                self.unknown[nodes[node]] = dof

    def fill(self, inlet):
        """When each vertex is full, in seconds; the vertices of `inlet` are from the beginning."""
        a, count = self.matrix, len(self.volume)
        pressure, share, when = numpy.zeros(count), numpy.zeros(count), numpy.full(count, numpy.nan)
        given = numpy.zeros(count, bool)
        given[self.unknown[inlet]] = True
        pressure[given] = PRESSURE
        share[given] = 1
        when[given] = 0
        time = 0.0
        while (share < 1).any():
            free = numpy.flatnonzero((share >= 1) & ~given)
            pressure[share < 1] = 0
            if len(free):
                right = -a[free][:, given] @ pressure[given]
                pressure[free] = scipy.sparse.linalg.spsolve(a[free][:, free].tocsc(), right)
            rate = numpy.where(share < 1, -(a @ pressure), 0) / self.volume
            growing = rate > 0
            if not growing.any():
                sys.exit("filling: no way for the resin to what is still empty")
            step = ((1 - share[growing]) / rate[growing]).min()
            time += step
            share[growing] += rate[growing] * step
            full = growing & (share >= 1 - 1e-9)
            share[full] = 1
            when[full] = time
        return when[self.unknown]


# ---- the picture ----

def draw(path, points, triangles, cases):
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot
    latest = max(times.max() for _, times in cases)
    levels = numpy.linspace(0, latest, 13)
    figure, axes = pyplot.subplots(1, len(cases), figsize=(5 * len(cases), 4.4), sharey=True,
                                   constrained_layout=True)
    for axis, (title, times) in zip(axes, cases):
        filled = axis.tricontourf(points[:, 0], points[:, 1], triangles, times, levels, cmap="viridis")
        axis.tricontour(points[:, 0], points[:, 1], triangles, times, levels, colors="white",
                        linewidths=0.7)
        axis.set_aspect("equal")
        axis.set_title(f"{title}: full after {times.max():.0f} s")
        axis.set_xlabel("x")
    axes[0].set_ylabel("y")
    figure.colorbar(filled, ax=axes, label="time of the front, s")
    figure.savefig(path, dpi=100)


# ---- checks ----

def check():
    """A strip filled from its end: t = phi mu x^2 / (2 k p). A disk from a hole of radius a:
    t = phi mu / (2 k p) (r^2 ln(r / a) - (r^2 - a^2) / 2). Errors at 20, 40, 80 triangles a side."""
    k, porosity, height = 1e-10, 0.5, 3e-3
    last = []
    for name in ("strip", "disk"):
        for cells in (20, 40, 80):
            x, y = numpy.meshgrid(numpy.linspace(0, 1, cells + 1), numpy.linspace(0, 1, cells + 1),
                                  indexing="ij")
            if name == "strip":
                points = numpy.stack([x, y * 4 / cells, 0 * x], -1).reshape(-1, 3)
            else:
                radius, angle = 0.2 + 0.8 * x, numpy.pi / 2 * y
                points = numpy.stack([radius * numpy.cos(angle), radius * numpy.sin(angle), 0 * x],
                                     -1).reshape(-1, 3)
            triangles = grid_triangles(cells + 1, cells + 1)
            ones = numpy.ones(len(triangles))
            times = Mould(points, triangles, height * ones, porosity * ones,
                          k * ones[:, None, None] * numpy.eye(3)).fill(numpy.arange(cells + 1))
            factor = porosity * VISCOSITY / (2 * k * PRESSURE)
            r = points[:, 0] if name == "strip" else numpy.hypot(points[:, 0], points[:, 1])
            exact = factor * (r ** 2 if name == "strip" else
                              r ** 2 * numpy.log(r / 0.2) - (r ** 2 - 0.04) / 2)
            error = abs(times.max() / exact.max() - 1)
            print(f"{name} {cells}: filled after {times.max():.1f} s, exact {exact.max():.1f} s, "
                  f"error {100 * error:.2f} %")
        last.append(error)
    return 0 if max(last) < 0.001 else 1


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("request", nargs="?")
    parser.add_argument("-o", "--output", help="picture of both flow fronts, png or svg")
    parser.add_argument("--drape", default="build/drape", help="the program; default: build/drape")
    parser.add_argument("--cells", type=int, default=40, help="of the mesh along a side; default: 40")
    parser.add_argument("--check", action="store_true", help="the flow against exact solutions")
    arguments = parser.parse_args()
    if arguments.check:
        return check()
    if not arguments.request:
        parser.error("a request is needed")
    with open(arguments.request, encoding="utf-8") as file:
        request = json.load(file)
    points, triangles = mesh_of(request, arguments.cells)
    cells, *draped = map_fields(arguments.drape, arguments.request, points, triangles)
    metres = METRES[request.get("length_unit", "m")]
    start = points[numpy.abs(points - points.mean(axis=0)).sum(axis=1).argmin()]
    radius = 0.08 * numpy.linalg.norm(points.max(axis=0) - points.min(axis=0))
    inlet = numpy.flatnonzero(numpy.linalg.norm(points - start, axis=1) <= radius)
    cases = []
    for title, fields in (("draped fields", draped),
                          ("flat fabric", flat_fields(cells, points, triangles))):
        thickness, porosity, tensor = fields
        mould = Mould(points * metres, triangles, thickness * metres, porosity, tensor)
        cases.append((title, mould.fill(inlet)))
        print(f"{title}: fibre fraction {1 - porosity.max():.3f} to {1 - porosity.min():.3f}, "
              f"half full after {numpy.median(cases[-1][1]):.1f} s, full after "
              f"{cases[-1][1].max():.1f} s")
    if arguments.output:
        draw(arguments.output, points, triangles, cases)
    return 0


if __name__ == "__main__":
    sys.exit(main())
