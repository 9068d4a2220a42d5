#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The kinematic draping algorithm of KinDrape on moulds that are heights z = F(x, y), written anew from
its description: C. Krogh, B. L. V. Bak, E. Lindgaard et al., A simple MATLAB draping code for
fiber-reinforced composites, Struct Multidisc Optim 64, 457-471 (2021), with the two spheres and the
search for one angle of its efficient version (github.com/chrkrogh/KinDrape).

    kinematic.py CASE >NET.csv

A cell has the vertices 1 (i, j), 2 (i, j+1), 3 and 4, all edges chords of length d. Vertex 3 lies on the
circle in which the spheres about 2 and 4 meet, where that pierces the mould. Two strips of cells cross at
the start: in each of their cells edge 1-4 turns until the mean shear of its corners is that of the cloth
before. So it is strips of cells that run straight, not the yarns through the start: a net of another
definition than the task's, from which it is away by about half a spacing's turn."""
import json
import math
import pathlib
import struct
import sys
import time

# Turns of the circle to either side of the place opposite vertex 1 between which the mould is looked
# for, the widest first: narrower ones where the mould is steep, or ends.
SEARCH = [math.radians(turn) for turn in (120, 100, 80, 60, 40, 20)]
EXACT = 1e-12  # of heights, relative to the spacing, and of angles in radians
ARMS = [((1, 0), (0, 1), (0, 0)), ((0, 1), (-1, 0), (1, 1)), ((-1, 0), (0, -1), (0, 1)), ((0, -1), (1, 0), (0, 0))]


def add(a, b, k=1.0):
    return tuple(p + k * q for p, q in zip(a, b))


def unit(a):
    size = math.hypot(*a)
    return tuple(p / size for p in a)


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def dot(a, b):
    return sum(p * q for p, q in zip(a, b))


class Spline:
    """The height of a NURBS surface: Newton's method for the parameters of a place (x, y)."""

    def __init__(self, surface):
        self.knots = [surface["knotvector_u"], surface["knotvector_v"]]
        self.degree = [surface["degree_u"], surface["degree_v"]]
        self.rows = surface["size_v"]
        net = surface["control_points"]
        weights = net.get("weights") or [1.0] * len(net["points"])
        self.points = [(w * x, w * y, w * z, w) for (x, y, z), w in zip(net["points"], weights)]
        self.domain = [((k[d] + k[-d - 1]) / 2, k[-d - 1] - k[d]) for k, d in zip(self.knots, self.degree)]
        self.at = [middle for middle, _ in self.domain]

    def basis(self, way, t):
        """The first control point that counts, the B-splines at t and their derivatives (Cox, de Boor)."""
        knots, degree = self.knots[way], self.degree[way]
        low, high = degree, len(knots) - degree - 2
        while low < high:
            middle = (low + high + 1) // 2
            low, high = (middle, high) if knots[middle] <= t else (low, middle - 1)
        values, before = [1.0], [1.0]
        for d in range(1, degree + 1):
            before, raised = values, [0.0] * (d + 1)
            for r, value in enumerate(values):
                left, right = knots[low + 1 + r - d], knots[low + 1 + r]
                raised[r] += value * (right - t) / (right - left)
                raised[r + 1] += value * (t - left) / (right - left)
            values = raised
        slopes = [0.0] * (degree + 1)
        for r, value in enumerate(before):
            rate = degree * value / (knots[low + 1 + r] - knots[low + 1 + r - degree])
            slopes[r] -= rate
            slopes[r + 1] += rate
        return low - degree, values, slopes

    def jet(self, u, v):
        """The point and its two derivatives."""
        (a, bu, du), (b, bv, dv) = self.basis(0, u), self.basis(1, v)
        sums = [[0.0] * 4 for _ in range(3)]
        for r in range(len(bu)):
            for c in range(len(bv)):
                point = self.points[(a + r) * self.rows + b + c]
                for total, weight in zip(sums, (bu[r] * bv[c], du[r] * bv[c], bu[r] * dv[c])):
                    for k in range(4):
                        total[k] += weight * point[k]
        w = sums[0][3]
        place = [s / w for s in sums[0][:3]]
        return place, *([(s[k] - s[3] * place[k]) / w for k in range(3)] for s in sums[1:])

    def height(self, x, y):
        """z at (x, y), by the polynomials of the end spans a little beyond the edge; None far from it."""
        for _ in range(30):
            place, su, sv = self.jet(*self.at)
            dx, dy, area = x - place[0], y - place[1], su[0] * sv[1] - su[1] * sv[0]
            if area == 0:
                break
            du, dv = (dx * sv[1] - dy * sv[0]) / area, (dy * su[0] - dx * su[1]) / area
            self.at = [self.at[0] + du, self.at[1] + dv]
            if abs(du) + abs(dv) < 1e-9:  # the step squares what is left
                return place[2] + du * su[2] + dv * sv[2]
            if any(abs(t - m) > 0.75 * w for t, (m, w) in zip(self.at, self.domain)):
                break
        self.at = [middle for middle, _ in self.domain]
        return None

    def has(self, x, y):
        return self.height(x, y) is not None and all(
            abs(t - middle) <= (0.5 + 1e-9) * width for t, (middle, width) in zip(self.at, self.domain))


class Facets:
    """The height of triangles of a binary STL file, which are found by squares of the plane (x, y)."""

    def __init__(self, path):
        data = path.read_bytes()
        count, = struct.unpack_from("<I", data, 80)
        rows = [struct.unpack_from("<12f", data, 84 + 50 * k)[3:] for k in range(count)]
        self.triangles = [(r[0:3], r[3:6], r[6:9]) for r in rows]
        wide = max(max(abs(c) for p in t for c in p[:2]) for t in self.triangles)
        self.size = 2 * wide / max(4, math.isqrt(count) // 2)
        self.squares = {}
        for triangle in self.triangles:
            low, high = ([int(f(p[k] for p in triangle) // self.size) for k in (0, 1)] for f in (min, max))
            for a in range(low[0], high[0] + 1):
                for b in range(low[1], high[1] + 1):
                    self.squares.setdefault((a, b), []).append(triangle)

    def height(self, x, y):
        for p, q, r in self.squares.get((int(x // self.size), int(y // self.size)), ()):
            area = (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
            if area == 0:
                continue
            b = ((x - p[0]) * (r[1] - p[1]) - (y - p[1]) * (r[0] - p[0])) / area
            c = ((q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0])) / area
            if min(b, c, 1 - b - c) >= -1e-7:
                return p[2] + b * (q[2] - p[2]) + c * (r[2] - p[2])
        return None

    def has(self, x, y):
        return self.height(x, y) is not None


def pierce(mould, centre, towards, aside, d):
    """The place where the circle centre + cos t towards + sin t aside pierces the mould: regula falsi
    with halved ends (Illinois). None where there is none."""
    def place(t):
        return add(add(centre, towards, math.cos(t)), aside, math.sin(t))

    def above(t):
        p = place(t)
        height = mould.height(p[0], p[1])
        return None if height is None else p[2] - height
    looked = []
    for turn in (math.pi + side * turn for turn in SEARCH for side in (-1, 1)):
        g = above(turn)
        ends = [(t, f) for t, f in looked if f * g <= 0] if g is not None else []
        if ends:
            # The places at vertex 1 are others: the bracket across the far side is wanted.
            (low, f), high = max(ends, key=lambda end: abs(end[0] - turn)), turn
            break
        if g is not None:
            looked.append((turn, g))
    else:
        return None
    for _ in range(100):
        t = high - g * (high - low) / (g - f) if g != f else (low + high) / 2
        h = above(t)
        if h is None:
            return None
        if abs(h) < EXACT * d or abs(t - high) < EXACT:
            return place(t)
        if h * g < 0:
            low, f = high, g
        else:
            f /= 2
        high, g = t, h
    return None


def fourth(mould, one, two, four, d):
    """Vertex 3 of a cell: the spheres about 2 and 4 meet in a circle, vertex 1 on its near side."""
    if None in (one, two, four):
        return None
    centre = tuple((p + q) / 2 for p, q in zip(two, four))
    half = add(two, centre, -1)
    rest = d * d - dot(half, half)
    back = add(one, centre, -1)
    axis = unit(half)
    back = add(back, axis, -dot(back, axis))
    if rest <= 0 or dot(back, back) == 0:
        return None
    towards = tuple(math.sqrt(rest) * p for p in unit(back))
    return pierce(mould, centre, towards, cross(axis, towards), d)


def ahead(mould, one, angle, d):
    """The place at the distance d from vertex 1 whose direction in the plane (x, y) has that angle."""
    towards = (-d * math.cos(angle), -d * math.sin(angle), 0)
    return pierce(mould, one, towards, (0, 0, d), d)


def mean_shear(cell):
    """The mean of the corners' shear, positive where corner 1 is acute: opening corners count negative."""
    total = 0.0
    for k in range(4):
        a, b = (add(cell[(k + s) % 4], cell[k], -1) for s in (1, 3))
        total += (math.pi / 2 - math.atan2(math.hypot(*cross(a, b)), dot(a, b))) * (1 if k % 2 == 0 else -1)
    return total / 4


def strip_cell(mould, one, two, angle, shear, d):
    """Vertices 3 and 4 and the angle of edge 1-4 at which the mean shear is as wanted: secants."""
    tried = []
    for angle in (angle, angle + 1e-3):
        four = ahead(mould, one, angle, d)
        three = fourth(mould, one, two, four, d)
        if three is None:
            return None, None, angle
        tried.append((angle, mean_shear((one, two, three, four)) - shear))
    for _ in range(30):
        (a, f), (b, g) = tried[-2:]
        if abs(g) < EXACT or f == g:
            return three, four, b
        angle = b - g * (b - a) / (g - f)
        four = ahead(mould, one, angle, d)
        three = fourth(mould, one, two, four, d)
        if three is None:
            break
        tried.append((angle, mean_shear((one, two, three, four)) - shear))
    return None, None, angle


def lay(mould, start, weft_angle, shear, d, extent):
    """The net {(i, j): place} from the start, whose first edge along weft has that angle in plan."""
    nodes = {(0, 0): start, (0, 1): ahead(mould, start, weft_angle, d)}

    def inside(i, j):
        return extent[0][0] <= i <= extent[0][1] and extent[1][0] <= j <= extent[1][1]
    for arm, (along, across, first) in enumerate(ARMS):
        wanted = shear * (1 if arm % 2 == 0 else -1)
        angle = weft_angle - math.pi / 2 + arm * math.pi / 2 + (shear if arm % 2 == 0 else 0)
        at = first
        while inside(*add(at, along)) and nodes.get(at) and nodes.get(add(at, across)):
            keys = at, add(at, across), add(add(at, across), along), add(at, along)
            three, four, angle = strip_cell(mould, nodes[keys[0]], nodes[keys[1]], angle, wanted, d)
            if three is None:
                break
            nodes.setdefault(keys[2], three)
            nodes.setdefault(keys[3], four)
            at = keys[3]
    for arm, (along, across, _) in enumerate(ARMS):
        corner = ((1, 1), (0, 1), (0, 0), (1, 0))[arm]
        reach = max(map(abs, (*extent[0], *extent[1]))) + 1
        for a in range(reach):
            for b in range(reach):
                one = add(add(corner, along, a), across, b)
                two, four = add(one, across), add(one, along)
                three = add(two, along)
                if inside(*three) and three not in nodes:
                    found = fourth(mould, *(nodes.get(tuple(map(int, k))) for k in (one, two, four)), d)
                    if found:
                        nodes[tuple(map(int, three))] = found
    return {tuple(map(int, k)): p for k, p in nodes.items() if p}


def drape(case):
    """The net of a case as CSV, and the seconds it took; None for a case that gives a CAD file."""
    folder = pathlib.Path(case)
    task = json.loads((folder / "task.json").read_text())
    path = folder / task["geometry"]
    if path.suffix == ".step":
        return None
    mould = Facets(path) if path.suffix == ".stl" else Spline(json.loads(path.read_text()))
    weft, extent = task["weft"], (task["extent"]["warp"], task["extent"]["weft"])
    # Angles are counted from warp to weft: where that is the other way round, the families are swapped.
    swapped = task["warp"][0] * weft[1] - task["warp"][1] * weft[0] < 0
    if swapped:
        weft, extent = task["warp"], extent[::-1]
    begun = time.perf_counter()
    nodes = lay(mould, tuple(task["start"]), math.atan2(weft[1], weft[0]),
                math.radians(task["pre_shear_deg"]), task["spacing"], extent)
    seconds = time.perf_counter() - begun
    nodes = {(k[::-1] if swapped else k): p for k, p in nodes.items() if mould.has(p[0], p[1])}
    lines = ["i,j,x,y,z", *(f"{i},{j},{x:.12g},{y:.12g},{z:.12g}" for (i, j), (x, y, z) in sorted(nodes.items()))]
    return "\n".join(lines) + "\n", seconds


if __name__ == "__main__":
    made = drape(sys.argv[1]) if len(sys.argv) == 2 else sys.exit(__doc__)
    sys.exit("a CAD file: not for this algorithm") if made is None else print(made[0], end="")
