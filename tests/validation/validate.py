#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Drapes what others have draped and prints both results side by side: the figures of
docs/validation.md. Usage: validate.py DRAPE DATA, DATA a folder for the curves of the picture."""
import csv
import gzip
import json
import math
import pathlib
import subprocess
import sys
import time

sys.path.append(str(pathlib.Path(__file__).resolve().parents[2] / "benchmark"))
import kinematic  # noqa: E402

DRAPE, DATA = sys.argv[1], pathlib.Path(sys.argv[2])
HERE = pathlib.Path(__file__).parent
STEP, FACET = 0.0125, 0.04  # of the course and of the mould's mesh, in metres


def drape(document, *options):
    done = subprocess.run([DRAPE, "-", *options], input=json.dumps(document), capture_output=True,
                          text=True)
    if done.returncode:
        sys.exit(f"{DRAPE}: {done.stderr}{done.stdout}")
    return json.loads(done.stdout)


def net(result):
    """The net's nodes {(i, j): (x, y, z)} and shear {(i, j): degrees}, j and shear with other signs: the
    course has its weft on the other side of warp."""
    nodes = result["nodes"]
    keys = [(i, -j) for i, j in zip(nodes["i"], nodes["j"])]
    return (dict(zip(keys, zip(nodes["x"], nodes["y"], nodes["z"]))),
            dict(zip(keys, (-s for s in nodes["shear_deg"]))))


def span(knots, degree, t):
    """The index k of the span knots[k] <= t < knots[k + 1], the last one for the end of the domain."""
    last = len(knots) - degree - 2
    return max(k for k in range(degree, last + 1) if knots[k] <= t or k == degree)


def basis(knots, degree, t):
    """The span's index and its degree + 1 B-splines at t (Cox and de Boor)."""
    k, values = span(knots, degree, t), [1.0]
    for d in range(1, degree + 1):
        raised = [0.0] * (d + 1)
        for r, value in enumerate(values):
            low, high = knots[k + 1 + r - d], knots[k + 1 + r]
            raised[r] += value * (high - t) / (high - low)
            raised[r + 1] += value * (t - low) / (high - low)
        values = raised
    return k, values


def point(surface, u, v):
    """S(u, v) of a surface without weights."""
    (ku, nu), (kv, nv) = (basis(surface[f"knotvector_{c}"], surface[f"degree_{c}"], t)
                          for c, t in (("u", u), ("v", v)))
    points, n = surface["control_points"]["points"], surface["size_v"]
    rows = [(a, b, points[(ku - surface["degree_u"] + r) * n + kv - surface["degree_v"] + c])
            for r, a in enumerate(nu) for c, b in enumerate(nv)]
    return [sum(a * b * p[axis] for a, b, p in rows) for axis in range(3)]


def mesh(surface, size):
    """Triangles on the surface, equal steps of u and of v, the longest edges along both about `size`."""
    def steps(along):
        lines = [[point(surface, *(along(t / 60, s))) for t in range(61)] for s in (0, 0.5, 1)]
        return math.ceil(max(sum(map(math.dist, line, line[1:])) for line in lines) / size)
    m, n = steps(lambda t, s: (t, s)), steps(lambda t, s: (s, t))
    vertices = [point(surface, a / m, b / n) for a in range(m + 1) for b in range(n + 1)]
    triangles = []
    for a in range(m):
        for b in range(n):
            p = a * (n + 1) + b
            triangles += [[p, p + n + 1, p + n + 2], [p, p + n + 2, p + 1]]
    return {"vertices": vertices, "triangles": triangles}


def distances(ours, theirs):
    return sorted(math.dist(ours[k], theirs[k]) for k in theirs if k in ours)


def edge_errors(nodes):
    """The distances of neighbouring nodes along both yarns over the step, less 1, in percent."""
    return [100 * (math.dist(p, nodes[k]) / STEP - 1) for (i, j), p in nodes.items()
            for k in ((i + 1, j), (i, j + 1)) if k in nodes]


def row(name, nodes, shear, reference):
    edges, apart = edge_errors(nodes), distances(reference, nodes)
    print(f"{name:22s}{len(nodes):8d}{1e3 * apart[len(apart) // 2]:9.3f}"
          f"{1e3 * apart[int(0.95 * len(apart))]:9.3f}{1e3 * apart[-1]:9.3f}"
          f"{min(edges):9.3f}{max(edges):8.3f}{min(shear):9.3f}{max(shear):8.3f}")


def course():
    """The geodesic course of Abaqus Composites Modeler, draped from its corner along its first edge."""
    with gzip.open(HERE / "geodesic_course.csv.gz", "rt") as file:
        rows = [{c: float(x) for c, x in r.items()} for r in csv.DictReader(file)]
    theirs = {(int(r["i"]), int(r["j"])): (r["x"], r["y"], r["z"]) for r in rows}
    their_shear = {(int(r["i"]), int(r["j"])): math.degrees(r["shear_rad"]) for r in rows}
    surface = json.load(open(HERE / "blade.json"))["surface"]
    request = {"surface": surface, "length_unit": "m", "fabric": {"spacing": STEP},
               "start": {"point": theirs[0, 0]}, "direction": {"vector": [b - a for a, b in zip(theirs[0, 0], theirs[1, 0])]},
               "method": "gib4"}
    nets = {"gib4, exact face": net(drape(request))}
    reference = nets["gib4, exact face"][0]
    for method in "gib", "geodesic", "basic":
        nets[f"{method}, exact face"] = net(drape({**request, "method": method}))
    for size in FACET, FACET / 2, FACET / 4:
        nets[f"mosaic, {1e3 * size:.0f} mm facets"] = net(
            drape({**request, "surface": mesh(surface, size), "method": "mosaic"}))
    print("net                      nodes   median     95 %   largest, mm  edges, %     shear, degrees")
    row("Abaqus, 40 mm facets", theirs, their_shear.values(), reference)
    for name, (nodes, shear) in nets.items():
        common = {k: p for k, p in nodes.items() if k in theirs}
        row(name, common, [shear[k] for k in common], reference)
    with open(DATA / "course.dat", "w") as file:
        for i in sorted(i for i, j in theirs if j == 40):
            rows = theirs, *(nets[f"mosaic, {size} mm facets"][0] for size in (40, 20, 10))
            print(i * STEP, *(1e3 * math.dist(r[i, 40], reference[i, 40]) for r in rows), file=file)


def steered_course():
    """The same course with generators of least energy, with k values along each: it begins at its corner,
    so that those of one side have an effect."""
    with gzip.open(HERE / "geodesic_course.csv.gz", "rt") as file:
        rows = [[float(r[c]) for c in "ijxyz"] for r in csv.DictReader(file)]
    at = {(i, j): place for i, j, *place in rows}
    print("\ngenerators            shear, degrees: greatest    95 %    mean     energy, m^2")
    for values in 0, 4, 8, 16:
        kind = {"steered": {"points": values}} if values else "geodesic"
        summary = drape({"surface": json.load(open(HERE / "blade.json"))["surface"], "length_unit": "m",
                         "fabric": {"spacing": STEP}, "start": {"point": at[0, 0]},
                         "direction": {"vector": [b - a for a, b in zip(at[0, 0], at[1, 0])]},
                         "extent": {"warp": [0, 320], "weft": [-40, 0]},
                         "generators": {"warp": kind, "weft": kind}})["summary"]
        energy = f"{summary['steering']['energy_after']:16.6f}" if values else ""
        print(f"{f'steered, {values} values' if values else 'geodesics':22s}{summary['max_shear_deg']:24.3f}"
              f"{summary['p95_shear_deg']:8.3f}{summary['mean_shear_deg']:8.3f}{energy}")


def sheared_plane(name, stretch):
    """Cloth whose diagonal is `stretch` times its length before: a rhombus with the shear
    90 - 2 acos(stretch / sqrt 2) degrees and the thickness 1 / cos(shear) of flat cloth."""
    shear = 90 - 2 * math.degrees(math.acos(stretch / math.sqrt(2)))
    plane = {"degree_u": 1, "degree_v": 1, "size_u": 2, "size_v": 2, "knotvector_u": [0, 0, 1, 1],
             "knotvector_v": [0, 0, 1, 1],
             "control_points": [[x, y, 0] for x in (-100, 100) for y in (-100, 100)]}
    result = drape({"surface": plane, "length_unit": "mm", "start": {"uv": [0.5, 0.5]},
                    "fabric": {"spacing": 5, "thickness": 1, "pre_shear_deg": shear}})
    nodes, cells = net(result)[0], result["cells"]
    diagonal = math.dist(nodes[-5, 5], nodes[5, -5]) / (10 * 5 * math.sqrt(2))
    print(f"{name:16s}{shear:12.6f}{min(cells['shear_deg']):12.6f}{max(cells['shear_deg']):12.6f}"
          f"{stretch:12.6f}{diagonal:12.6f}{1 / math.cos(math.radians(shear)):12.6f}"
          f"{max(cells['thickness']):12.6f}")


def closed_forms():
    print("\n                 exact shear       least     largest       exact    diagonal       exact   thickness")
    sheared_plane("bias extension", (210 - 70 + 50) / (210 - 70))
    sheared_plane("picture frame", (200 * math.sqrt(2) + 60) / (200 * math.sqrt(2)))


def along_parabola(length):
    """x at an arc length of z = x^2 / 100 from its apex, by Newton's method."""
    x = length
    for _ in range(20):
        q = x / 50
        x -= (x / 2 * math.hypot(1, q) + 25 * math.asinh(q) - length) / math.hypot(1, q)
    return x


def saddle_point(s, t):
    """The exact net of z = (x^2 - y^2) / 100 from its middle: a sum of two curves."""
    x, y = along_parabola(s), along_parabola(t)
    return x, y, (x * x - y * y) / 100


def strips():
    """KinDrape's algorithm with the middle of its first cell in the middle of the saddle, where its straight
    strips are about the yarns that the exact net has as geodesics; beside it `basic`, from the same middle."""
    folder = pathlib.Path(__file__).resolve().parents[2] / "benchmark" / "cases" / "saddle"
    surface, task = (json.loads((folder / name).read_text()) for name in ("surface.json", "task.json"))
    print("\nspacing, mm  cells   KinDrape   seconds      basic   seconds")
    for cells in 10, 20, 40:
        d = 60 / cells
        begun = time.perf_counter()
        nodes = kinematic.lay(kinematic.Spline(surface), saddle_point(-d / 2, -d / 2), math.pi / 2, 0, d,
                              ((1 - cells, cells), (1 - cells, cells)))
        seconds = time.perf_counter() - begun
        apart = max(math.dist(p, saddle_point((i - 0.5) * d, (j - 0.5) * d)) for (i, j), p in nodes.items())
        result = drape({"surface": surface, "length_unit": "mm", "fabric": {"spacing": d}, "method": "basic",
                        "start": {"uv": task["start_uv"]}, "direction": {"vector": task["warp"]},
                        "extent": {"warp": [-cells, cells], "weft": [-cells, cells]}})
        ours = zip(*(result["nodes"][c] for c in "ijxyz"))
        other = max(math.dist(p, saddle_point(i * d, j * d)) for i, j, *p in ours)
        print(f"{d:11.1f}{2 * cells:7d}{apart:11.2e}{seconds:10.3f}{other:11.2e}"
              f"{result['summary']['timing_ms']['solve'] / 1e3:10.4f}")


if __name__ == "__main__":
    course()
    steered_course()
    strips()
    closed_forms()
