# SPDX-License-Identifier: MIT
"""Parts as engineers make them in FreeCAD: filleted, shelled, united, cut, lofted, swept. Run by
`freecadcmd`; writes each as STEP and IGES into the folder PARTS, and parts.json: of each its faces'
areas in their order, square millimetres."""
import json
import math
import os

import FreeCAD
import Part

V = FreeCAD.Vector
FOLDER = os.environ["PARTS"]


def filleted_box():
    box = Part.makeBox(120, 80, 30)
    return box.makeFillet(6, box.Edges)


def shelled_tray():
    tray = Part.makeBox(150, 90, 25)
    upright = [edge for edge in tray.Edges if abs(edge.Vertexes[0].Z - edge.Vertexes[1].Z) > 1]
    tray = tray.makeFillet(12, upright)
    top = max(tray.Faces, key=lambda face: face.CenterOfMass.z)
    return tray.makeThickness([top], 2.5, 1e-3)


def united_dome():
    """A hemisphere on a flange, with a fillet between them and a boss on top."""
    flange = Part.makeCylinder(80, 8)
    dome = Part.makeSphere(50, V(0, 0, 8), V(0, 0, 1), 0, 90)
    part = flange.fuse(dome).removeSplitter()
    foot = [edge for edge in part.Edges
            if abs(edge.BoundBox.ZMin - 8) < 1e-6 and edge.BoundBox.ZLength < 1e-6
            and abs(edge.BoundBox.XLength - 100) < 1]
    part = part.makeFillet(10, foot)
    return part.fuse(Part.makeCylinder(12, 30, V(0, 0, 45))).removeSplitter()


def cut_bracket():
    web = Part.makeBox(100, 60, 6).fuse(Part.makeBox(6, 60, 70)).removeSplitter()
    inner = [edge for edge in web.Edges
             if all(abs(v.X - 6) < 1e-6 and abs(v.Z - 6) < 1e-6 for v in edge.Vertexes)]
    web = web.makeFillet(8, inner)
    for y in (15, 45):
        web = web.cut(Part.makeCylinder(6, 20, V(75, y, -5)))
    return web.cut(Part.makeCylinder(9, 20, V(-5, 30, 45), V(1, 0, 0)))


def lofted_duct():
    def section(z, a, b, turn):
        points = [V(a * math.cos(t + turn) + z / 4, b * math.sin(t + turn), z)
                  for t in (math.tau * k / 12 for k in range(12))]
        curve = Part.BSplineCurve()
        curve.interpolate(Points=points, PeriodicFlag=True)
        return Part.Wire(curve.toShape())
    return Part.makeLoft([section(0, 40, 40, 0), section(60, 50, 30, 0), section(140, 30, 22, 0)],
                         False)


def swept_rail():
    path = Part.Wire([Part.makeLine(V(0, 0, 0), V(0, 0, 60)),
                      Part.Arc(V(0, 0, 60), V(20 * (1 - math.sqrt(0.5)), 0, 60 + 20 * math.sqrt(0.5)),
                               V(20, 0, 80)).toShape(),
                      Part.makeLine(V(20, 0, 80), V(90, 0, 80))])
    profile = Part.makePolygon([V(-15, -15, 0), V(-15, 0, 0), V(15, 0, 0), V(15, -15, 0)])
    return path.makePipeShell([profile], False, False, 2)


def area(face):
    """What FreeCAD says, which of a free-form surface is off by 2e-5: of a whole patch the integral of
    |S_u x S_v| by Gauss's rule on 256 x 64 cells."""
    surface, (u0, u1, v0, v1) = face.Surface, face.ParameterRange
    if not isinstance(surface, Part.BSplineSurface) or len(face.Wires) > 1:
        return face.Area
    half = math.sqrt(0.6)
    rule = [((1 - half) / 2, 5 / 18), (0.5, 4 / 9), ((1 + half) / 2, 5 / 18)]
    du, dv, whole = (u1 - u0) / 256, (v1 - v0) / 64, 0
    for i in range(256):
        for j in range(64):
            for s, weight in rule:
                for t, other in rule:
                    u, v = u0 + du * (i + s), v0 + dv * (j + t)
                    normal = surface.getDN(u, v, 1, 0).cross(surface.getDN(u, v, 0, 1))
                    whole += weight * other * normal.Length
    return whole * du * dv


parts = {}
for make in (filleted_box, shelled_tray, united_dome, cut_bracket, lofted_duct, swept_rail):
    shape = make()
    name = make.__name__
    shape.exportStep(os.path.join(FOLDER, name + ".step"))
    shape.exportIges(os.path.join(FOLDER, name + ".igs"))
    parts[name] = [area(face) for face in shape.Faces]
with open(os.path.join(FOLDER, "parts.json"), "w") as file:
    json.dump(parts, file)
