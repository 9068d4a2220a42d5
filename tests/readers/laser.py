# SPDX-License-Identifier: MIT
"""What a projector draws, read by the formats' own rules and compared with exact answers.

laser.py read FILE             any of the three formats as JSON: revision, layers with their lines
laser.py plane|cylinder|sphere|fibres DRAPE
                               drapes a laminate on it with that command, and prints as JSON how far
                               points are from the part at the height that the stack has there"""
import csv
import json
import math
import subprocess
import sys
import tempfile

import numpy


def read_virtek(text):
    assert text.endswith("EOD\r\n") and text.count("\n") == text.count("\r\n")
    lines, layers, revisions = iter(text.split("\r\n")), [], set()
    for line in lines:
        if line == "EOD":
            break
        assert line.startswith("LAYER START ")
        title = line[12:]
        revisions.add(title.rsplit(" revision ", 1)[1])
        layers.append({"title": title.rsplit(" revision ", 1)[0], "lines": []})
        for line in lines:
            if line.startswith("LAYER END "):
                assert line[10:] == title
                break
            name = line.removeprefix("START ")
            count = int(next(lines).removeprefix("P "))
            points = [[float(v) for v in next(lines).split()] for _ in range(count)]
            assert next(lines) == "END " + name and all(len(p) == 6 for p in points)
            layers[-1]["lines"].append({"kind": name.split()[0], "points": points})
    revision, = revisions
    return {"revision": revision, "layers": layers}


def read_csv(text):
    layers, revisions = {}, set()
    for row in csv.DictReader(text.splitlines()):
        key = tuple(int(row[k]) for k in ("ply", "piece", "layer"))
        lines = layers.setdefault(key, [])
        if len(lines) < int(row["line"]):
            lines.append({"kind": row["kind"], "points": []})
        lines[-1]["points"].append(
            [float(row[k]) for k in ("x", "y", "z", "nx", "ny", "nz", "height")])
        revisions.add(row["revision"])
    revision, = revisions
    return {"revision": revision,
            "layers": [{"ply": k[0], "layer": k[2], "lines": v} for k, v in layers.items()]}


def read(path):
    with open(path, encoding="ascii", newline="") as file:
        text = file.read()
    if text.startswith("{"):
        return json.loads(text)
    return read_virtek(text) if text.startswith("LAYER") else read_csv(text)


def draw(drape, request, *arguments):
    with tempfile.NamedTemporaryFile("w", suffix=".json") as file:
        json.dump(request, file)
        file.flush()
        return json.loads(subprocess.run([drape, file.name, "--format", "laser", *arguments],
                                         check=True, capture_output=True).stdout)


def points_of(layer, kinds=("edge", "hole", "warp")):
    return numpy.array([p for line in layer["lines"] if line["kind"] in kinds
                        for p in line["points"]])


def sagitta(layer, surface):
    """How far the middles of chords are from the surface, of chords at one height."""
    return max((abs(surface((numpy.array(p[:3]) + q[:3]) / 2) - p[6])
                for line in layer["lines"] for p, q in zip(line["points"], line["points"][1:])
                if abs(p[6] - q[6]) < 1e-12), default=0)


def rectangle(x0, y0, x1, y1, place):
    corners = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]
    return [[place(x + (u - x) * k / 40, y + (v - y) * k / 40) for k in range(40)]
            for (x, y), (u, v) in zip(corners, corners[1:] + corners[:1])]


def in_rectangle(at, x0, y0, x1, y1):
    return (at[:, 0] > x0) & (at[:, 0] < x1) & (at[:, 1] > y0) & (at[:, 1] < y1)


def fabric(spacing, thickness, **other):
    return {"spacing": spacing, "thickness": thickness, "fiber_volume_fraction": 0.5, **other}


def plane(drape):
    """Three layers that are sheared by 25 degrees, a patch, and a ply over all; seen from below."""
    box = (0.53, 0.91, 2.47, 3.03)
    patch = [p for side in rectangle(*box, lambda x, y: [x, y, 0]) for p in side]
    surface = {"degree_u": 1, "degree_v": 1, "size_u": 2, "size_v": 2,
               "knotvector_u": [0, 0, 1, 1], "knotvector_v": [0, 0, 1, 1],
               "control_points": [[0, 0, 0], [0, 4, 0], [4, 0, 0], [4, 4, 0]]}
    sheared = {"name": "sheared", "repeat": 3, "fabric": fabric(0.1, 0.002, pre_shear_deg=25)}
    laminate = {"surface": surface, "side": -1, "plies": [
        sheared, {"name": "patch", "fabric": fabric(0.1, 0.003), "boundary": {"polygon": patch}},
        {"name": "over", "fabric": fabric(0.1, 0.001)}]}
    layers = draw(drape, laminate)["layers"]
    own = 0.002 / math.cos(math.radians(25))
    wrong = 0
    for layer in layers:
        at = points_of(layer)
        inside = in_rectangle(at, *box)
        height = {1: (layer["layer"] - 1) * own, 2: 3 * own}.get(layer["ply"], 3 * own)
        height = height + (layer["ply"] == 3) * 0.003 * inside
        known = numpy.ones(len(at), bool)
        if layer["ply"] == 3:  # not where the step is
            known = inside == in_rectangle(at, box[0] - .1, box[1] - .1, box[2] + .1, box[3] + .1)
        foot = at[:, :3] - at[:, 6:] * at[:, 3:6]
        wrong = max(wrong, numpy.abs(at[:, 6] - height)[known].max(), numpy.abs(foot[:, 2]).max(),
                    numpy.abs(at[:, 3:6] - [0, 0, -1]).max())
    edge = points_of(layers[3], ("edge",))
    off = numpy.abs(edge[:, None, :2] - numpy.array(patch)[None, :, :2]).sum(2).min(1).max()
    return {"layers": len(layers), "wrong": wrong, "edge": off}


def cylinder(drape):
    """A quarter of a cylinder about z, four layers; its points and chords."""
    radius, tall, half = 2, 3, math.sqrt(0.5)
    surface = {"degree_u": 2, "degree_v": 1, "size_u": 3, "size_v": 2,
               "knotvector_u": [0, 0, 0, 1, 1, 1], "knotvector_v": [0, 0, 1, 1],
               "control_points": {
                   "points": [[2, 0, 0], [2, 0, 3], [2, 2, 0], [2, 2, 3], [0, 2, 0], [0, 2, 3]],
                   "weights": [1, 1, half, half, 1, 1]}}
    answer = {"wrong": 0, "edge": 0, "chord": 0, "points": 0}
    for side in (1, -1):
        laminate = {"surface": surface, "side": side, "offset": "nominal", "plies": [
            {"name": "a", "repeat": 2, "fabric": fabric(0.05, 0.003), "direction": {"angle_deg": 33}},
            {"name": "b", "fabric": fabric(0.07, 0.002), "direction": {"angle_deg": 0}},
            {"name": "c", "fabric": fabric(0.05, 0.001), "direction": {"angle_deg": 90}}]}
        layers = draw(drape, laminate, "--tolerance", "0.0002")["layers"]
        for layer, height in zip(layers, (0, 0.003, 0.006, 0.008), strict=True):
            at = points_of(layer)
            out = numpy.hypot(at[:, 0], at[:, 1])
            sign = numpy.sign((at[:, :2] * at[:, 3:5]).sum(1))
            assert abs(sign.sum()) == len(at) and (sign[0] == answer.setdefault(str(side), sign[0]))
            answer["wrong"] = max(answer["wrong"], numpy.abs(at[:, 6] - height).max(),
                                  numpy.abs(out - radius - sign * height).max(),
                                  numpy.abs(at[:, :2] / out[:, None] - sign[:, None] * at[:, 3:5]).max())
            edge = points_of(layer, ("edge",))
            turn = numpy.arctan2(edge[:, 1], edge[:, 0])
            rim = numpy.abs([edge[:, 2], edge[:, 2] - tall, radius * turn,
                             radius * (turn - math.pi / 2)]).min(0)
            answer["edge"] = max(answer["edge"], rim.max())
            answer["chord"] = max(answer["chord"], sagitta(
                layer, lambda r: sign[0] * (math.hypot(r[0], r[1]) - radius)))
            answer["points"] = max(answer["points"], len(edge))
    return answer


class Net:
    """The net of a pin-jointed fabric on a sphere, marched by meeting circles; then its shear."""

    def __init__(self, start, along, spacing, count):
        a, middle, rows = spacing, count, 2 * count + 1
        normal = start / numpy.linalg.norm(start)
        across = numpy.cross(normal, along)
        node = numpy.full((rows, rows, 3), numpy.nan)
        for k in range(-count, count + 1):
            node[middle + k, middle] = math.cos(k * a) * normal + math.sin(k * a) * along
            node[middle, middle + k] = math.cos(k * a) * normal + math.sin(k * a) * across
        for x in (1, -1):
            for y in (1, -1):
                for i in range(middle, middle + x * count, x):
                    for j in range(middle, middle + y * count, y):
                        b, c = node[i + x, j], node[i, j + y]
                        node[i + x, j + y] = self.meet(node[i, j], b, c, math.cos(a))
        warp = node[1:, :-1] + node[1:, 1:] - node[:-1, :-1] - node[:-1, 1:]
        weft = node[:-1, 1:] + node[1:, 1:] - node[:-1, :-1] - node[1:, :-1]
        cosine = (warp * weft).sum(2) / numpy.linalg.norm(warp, axis=2) / numpy.linalg.norm(weft, axis=2)
        centre = node[:-1, :-1] + node[1:, 1:] + node[1:, :-1] + node[:-1, 1:]
        good = numpy.isfinite(cosine).ravel()
        self.shear = numpy.arcsin(cosine.ravel()[good])
        self.centre = centre.reshape(-1, 3)[good]
        self.centre /= numpy.linalg.norm(self.centre, axis=1)[:, None]

    @staticmethod
    def meet(old, b, c, cosine):
        share = cosine / (1 + b @ c)
        rest = 1 - share * share * (2 + 2 * (b @ c))
        if not rest > 0:
            return numpy.full(3, numpy.nan)
        off = numpy.cross(b, c)
        off *= math.sqrt(rest) / numpy.linalg.norm(off)
        return max(share * (b + c) + off, share * (b + c) - off,
                   key=lambda d: numpy.linalg.norm(d - old))

    def shear_at(self, at):
        """By a plane through the shears of the twelve nearest cells."""
        near = numpy.argsort(((self.centre - at) ** 2).sum(1))[:12]
        away = self.centre[near] - at
        frame = numpy.linalg.svd(at[None, :])[2][1:]
        rows = numpy.column_stack([numpy.ones(12), away @ frame.T])
        return numpy.linalg.lstsq(rows, self.shear[near], rcond=None)[0][0]


def octant(below, spacing):
    radius, half = 100, math.sqrt(0.5)
    surface = {"degree_u": 2, "degree_v": 2, "size_u": 3, "size_v": 3,
               "knotvector_u": [0, 0, 0, 1, 1, 1], "knotvector_v": [0, 0, 0, 1, 1, 1],
               "control_points": {
                   "points": [[100, 0, 0], [100, 0, 100], [0, 0, 100], [100, 100, 0],
                              [100, 100, 100], [0, 0, 100], [0, 100, 0], [0, 100, 100], [0, 0, 100]],
                   "weights": [1, half, 1, half, 0.5, half, 1, half, 1]}}
    start = numpy.ones(3) * radius / math.sqrt(3)
    along = numpy.array([-1, 1, 0]) * half

    def place(x, y):
        r = start + x * along + y * numpy.cross(start / radius, along)
        return list(r * radius / numpy.linalg.norm(r))

    patch = [p for line in rectangle(-48, -25, 48, 40, place) for p in line]
    common = {"start": {"point": list(start)}, "direction": {"vector": list(along)}}
    return start, along, {"surface": surface, "length_unit": "mm", "plies": [
        {"name": "below", "repeat": 2, "fabric": fabric(spacing, 0.5, **below), **common},
        {"name": "whole", "fabric": fabric(spacing, 0.25), **common},
        {"name": "patch", "fabric": fabric(spacing, 0.3), "boundary": {"polygon": patch}, **common}]}


def sphere(drape, below=None, spacing=2):
    """Two pin-jointed layers and one over them; the height of a patch above all three."""
    start, along, laminate = octant(below or {}, spacing)
    layers = draw(drape, laminate)["layers"]
    net = Net(start, along, spacing / 100, int(70 / spacing))
    answer = {"height": 0, "shear": 0, "wrong": 0, "chord": 0}
    for layer in layers:
        at = points_of(layer)
        size = numpy.linalg.norm(at[:, :3], axis=1)
        sign = numpy.sign((at[:, :3] * at[:, 3:6]).sum(1))
        answer["wrong"] = max(answer["wrong"], numpy.abs(size - 100 - sign * at[:, 6]).max(),
                              numpy.abs(at[:, :3] / size[:, None] - sign[:, None] * at[:, 3:6]).max())
        answer["chord"] = max(answer["chord"], sagitta(
            layer, lambda r: sign[0] * (numpy.linalg.norm(r) - 100)))
        if layer["name"] != "patch":
            continue
        for p in at:
            shear = net.shear_at(p[:3] / numpy.linalg.norm(p[:3]))
            answer["shear"] = max(answer["shear"], abs(math.degrees(shear)))
            height = 0.25 / math.cos(shear) + (1 if below else 1 / math.cos(shear))
            answer["height"] = max(answer["height"], abs(p[6] - height))
    return answer


def fibres(drape):
    """The layers below unidirectional: the cloth keeps its area there, and its thickness."""
    return sphere(drape, {"kinematics": "parallel_fibers"})


if __name__ == "__main__":
    what, given = sys.argv[1:]
    cases = {"read": read, "plane": plane, "cylinder": cylinder, "sphere": sphere, "fibres": fibres}
    print(json.dumps(cases[what](given)))
