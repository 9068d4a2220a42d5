# SPDX-License-Identifier: MIT
"""The FreeCAD workbench without a display, run by `freecadcmd` (tests/clients/freecad.py): drapes of a tray with
fillets and of a dome, by the command DRAPE and a daemon at URL. What it finds goes to the file TAP."""
import math
import os
import sys
import types

sys.path[:0] = ["clients/freecad", "tests/clients", "tests/faults"]
import FreeCAD
import Mesh
import numpy as np
import Part
from daemon import Tap, expect
from draped_workbench import composites, feature
from workbench_parts import dome

URL = os.environ["URL"]
V = FreeCAD.Vector


def body(document, shape, name="Body"):
    made = document.addObject("Part::Feature", name)
    made.Shape = shape
    return made


def tray():
    """A block with rounded corners and upper edges: its top and what is smooth from there."""
    block = Part.makeBox(120, 80, 12)
    block = block.makeFillet(25, [edge for edge in block.Edges if edge.BoundBox.ZLength > 11])
    return block.makeFillet(6, [edge for edge in block.Edges if edge.BoundBox.ZMin > 11])


def skin(shape):
    """The upper faces of the dome."""
    return [f"Face{k + 1}" for k, face in enumerate(shape.Faces)
            if not isinstance(face.Surface, Part.Plane) or abs(face.CenterOfMass.z) < 1e-6]


def top(shape):
    return f"Face{1 + max(range(len(shape.Faces)), key=lambda k: shape.Faces[k].CenterOfMass.z)}"


def draped(shape, faces, **settings):
    """A document with a drape of faces; the drape, its cloth and its pattern."""
    document = FreeCAD.newDocument()
    drape = feature.make_drape((body(document, shape), faces))
    for name, value in settings.items():
        setattr(drape, name, value)
    document.recompute()
    return drape, document.DrapeCloth, document.DrapePattern


def test_tray():
    drape, cloth, pattern = draped(tray(), [top(tray())], UpTo=20, Spacing=3, Locking=40)
    expect(drape.Outcome.startswith("complete: ") and drape.Coverage > 0.999, drape.Outcome)
    expect(cloth.Mesh.CountFacets == 2 * len(drape.Proxy.net.shear) == len(cloth.FaceColors), cloth.Mesh)
    part = drape.Faces[0].Shape
    worst = max(part.distToShape(Part.Vertex(point.Vector))[0] for point in cloth.Mesh.Points[::50])
    expect(worst < 2e-5, f"the cloth is {worst} mm off the part")
    lengths = [edge.Length for edge in drape.Shape.Edges]
    expect(2.7 < min(lengths) and max(lengths) < 3 + 1e-9, f"yarns' steps {min(lengths)} to {max(lengths)}")
    expect(all(wire.isClosed() for wire in pattern.Shape.Wires), "the pattern is open")
    area = Part.Face(pattern.Shape.Wires).Area
    expect(abs(area / drape.FlatArea.getValueAs("mm^2").Value - 1) < 1e-4, f"{area}, not {drape.FlatArea}")
    expect(any(pattern.getConstruction(k) for k in range(len(pattern.Geometry))), "no notches")


def test_again():
    drape, cloth, pattern = draped(dome(), skin(dome()), Spacing=6)
    facets, lines, yarns = cloth.Mesh.CountFacets, len(pattern.Geometry), len(drape.Shape.Wires)
    drape.Spacing = 4
    drape.Document.recompute()
    expect(cloth.Mesh.CountFacets > 2 * facets and len(pattern.Geometry) > lines, "cloth or pattern stay as they were")
    drape.Angle = 45
    drape.YarnStep = 4
    drape.Document.recompute()
    net = drape.Proxy.net
    warp = net.points[(net.index == [1, 0]).all(axis=1)][0]
    expect(abs(warp[0] - warp[1]) < 1e-5 < warp[0], f"{warp} {drape.Outcome}")
    expect(len(drape.Shape.Wires) < yarns, f"{len(drape.Shape.Wires)} yarns of {yarns}")


def test_daemon():
    one = draped(dome(), skin(dome()), Spacing=6)
    other = draped(dome(), skin(dome()), Spacing=6, Service=URL)
    expect(one[0].Outcome == other[0].Outcome, other[0].Outcome)
    expect([p.Vector for p in one[1].Mesh.Points] == [p.Vector for p in other[1].Mesh.Points], "another net")


def test_places():
    """In a part that is moved and turned the cloth is where the part is."""
    document = FreeCAD.newDocument()
    group = document.addObject("App::Part", "Group")
    group.Placement = FreeCAD.Placement(V(500, 0, 0), FreeCAD.Rotation(V(0, 1, 0), 90))
    made = body(document, tray())
    made.Placement = FreeCAD.Placement(V(0, 0, 300), FreeCAD.Rotation())
    group.addObject(made)
    drape = feature.make_drape((made, [top(tray())]))
    document.recompute()
    box = document.DrapeCloth.Mesh.BoundBox
    expect(abs(box.XMax - 812) < 1e-6 and abs(box.XMin - 812) < 1e-6 and box.ZMin < -100, f"{drape.Outcome} {box}")


def test_rosette():
    """The warp begins at the origin along x, turned by the angle."""
    document = FreeCAD.newDocument()
    lcs = document.addObject("App::Placement", "System")
    lcs.Placement = FreeCAD.Placement(V(60, 40, 12), FreeCAD.Rotation(V(0, 0, 1), 30))
    drape = feature.make_drape((body(document, tray()), [top(tray())]))
    drape.Rosette, drape.Angle, drape.Spacing = lcs, 15, 3
    document.recompute()
    net = drape.Proxy.net
    ends = [net.points[np.flatnonzero((net.index == place).all(axis=1))[0]] for place in ([0, 0], [4, 0])]
    turn = math.degrees(math.atan2(*(ends[1] - ends[0])[[1, 0]]))
    expect(np.abs(ends[0] - [60, 40, 12]).max() < 1e-9 and abs(turn - 45) < 1e-9, f"{ends} {turn}")


def test_failures():
    """Nothing that is out of date stays, and the next drape is right again."""
    drape, cloth, pattern = draped(dome(), skin(dome()), Spacing=6)
    right = drape.Outcome
    for name, wrong, word in (("Spacing", 1e4, "/fabric/spacing"), ("Service", "http://127.0.0.1:1", "Check the address"),
                              ("UpTo", 20, "one face"), ("Faces", (drape.Faces[0], ["Edge1"]), "choose faces")):
        kept = getattr(drape, name)
        setattr(drape, name, wrong)
        drape.Document.recompute()
        expect("Invalid" in drape.State and word in drape.Outcome, f"{name}: {drape.State} {drape.Outcome}")
        expect(cloth.Mesh.CountFacets == 0 and not pattern.Geometry and drape.Shape.isNull(), f"{name}: old cloth")
        setattr(drape, name, kept)
        drape.Document.recompute()
        expect(drape.Outcome == right and cloth.Mesh.CountFacets > 0 and pattern.Geometry, f"{name}: {drape.Outcome}")


def test_document():
    """Saved and opened it shows what it showed, and is draped again when it has to be."""
    drape, cloth, _ = draped(dome(), skin(dome()), Spacing=6)
    facets, outcome, document = cloth.Mesh.CountFacets, drape.Outcome, drape.Document
    path = os.path.join(os.environ["FOLDER"], "dome.FCStd")
    document.saveAs(path)
    FreeCAD.closeDocument(document.Name)
    opened = FreeCAD.openDocument(path)
    expect(opened.DrapeCloth.Mesh.CountFacets == facets and opened.Drape.Outcome == outcome, opened.Drape.Outcome)
    opened.DrapeCloth.FullColour = 30
    opened.recompute()
    expect(opened.DrapeCloth.State == ["Up-to-date"] and opened.DrapeCloth.Mesh.CountFacets == facets, "cloth")
    opened.Drape.Spacing = 4
    opened.recompute()
    expect(opened.DrapeCloth.Mesh.CountFacets > facets, opened.Drape.Outcome)


def placed(base, x, z):
    lcs = FreeCAD.ActiveDocument.addObject("App::Placement", "System")
    lcs.Placement = FreeCAD.Placement(base, FreeCAD.Rotation(x, V(), z, "ZXY"))
    return lcs


def cylinder(side=1):
    """A third of a cylinder of radius 60, its mesh, a system on it whose x is at 0.4 to its axis."""
    FreeCAD.newDocument()
    face = next(face for face in Part.makeCylinder(60, 100, V(), V(0, 0, 1), 120).Faces
                if isinstance(face.Surface, Part.Cylinder)).copy()
    out, axis = V(math.cos(1), math.sin(1), 0), V(0, 0, 1)
    x = axis * math.cos(0.4) + out.cross(axis) * math.sin(0.4)
    return face, Mesh.Mesh(face.tessellate(0.02)), placed(out * 60 + axis * 50, x, out * side)


def developed(point):
    """The place of a point of the cylinder in the cloth, exactly: it is rolled out and turned."""
    across, along = 60 * (1 - math.atan2(point.y, point.x)), point.z - 50  # towards out x axis, and the axis
    c, s = math.cos(0.4), math.sin(0.4)
    return V(along * c + across * s, across * c - along * s, 0)


def test_draper_exact():
    for side in (1, -1):
        face, mesh, lcs = cylinder(side)
        draper = composites.Draper(mesh, lcs, face)
        expect(draper.isValid() and draper.reason == "", draper.detail)
        worst = max((place - developed(point.Vector)).Length
                    for place, point in zip(draper.get_tex_coords(), mesh.Points))
        expect(worst < 0.02, f"texture coordinates are {worst} mm off")
        expect(np.abs(draper.strains).max() < 1e-3, f"strains {np.abs(draper.strains).max(axis=0)}")
        (loop,) = draper.get_boundaries(25)
        area = sum(a.x * b.y - a.y * b.x for a, b in zip(loop, loop[1:])) / 2
        expect(loop[0] == loop[-1] and abs(abs(area) - 100 * 60 * math.radians(120)) < 1e-3, f"area {area}")
        for t in (0.3, 1.5):
            point, out, axis = V(60 * math.cos(t), 60 * math.sin(t), 20), V(math.cos(t), math.sin(t), 0), V(0, 0, 1)
            warp = axis * math.cos(0.4) + out.cross(axis) * math.sin(0.4)
            turn = draper.get_lcs_at_point(point)
            expect((turn.multVec(warp) - V(1, 0, 0)).Length < 1e-4 and (turn.multVec(out) - V(0, 0, 1)).Length < 1e-9,
                   f"{turn.multVec(warp)}, {turn.multVec(out)}")
            tri = [point, point + axis * 0.01, point + axis.cross(out) * -0.01]
            expect(draper.get_lcs(tri).multVec(warp).x > 0.9999, "lcs of a triangle")
        turned = draper.get_tex_coord_at_point(V(60 * math.cos(0.5), 60 * math.sin(0.5), 10), 90)
        exact = developed(V(60 * math.cos(0.5), 60 * math.sin(0.5), 10))
        expect((turned - V(-exact.y, exact.x, 0)).Length < 0.02, f"{turned} of {exact}")


def test_draper_shear():
    """On a dome no yarn is stretched, and what the shear is the strains say."""
    FreeCAD.newDocument()
    shape = Part.makeSphere(60, V(), V(0, 0, 1), 30, 90).Faces[0]
    mesh = Mesh.Mesh(shape.tessellate(0.1))
    draper = composites.Draper(mesh, placed(V(0, 0, 60), V(1, 0, 0), V(0, 0, 1)), shape)
    expect(draper.isValid(), draper.detail)
    middles = np.array([list(point) for point in mesh.Topology[0]])[np.array(mesh.Topology[1])].mean(axis=1)
    near = [int(((draper.net.middles - middle) ** 2).sum(axis=1).argmin()) for middle in middles]
    gamma = np.radians(draper.net.shear[near])
    exact = np.column_stack([0 * gamma, np.cos(gamma) - 1, np.sin(gamma)])
    off = np.median(np.abs(draper.strains - exact), axis=0)
    expect(off.max() < 0.01 and np.abs(exact[:, 2]).max() > 0.35, f"{off}, shear up to {np.abs(exact[:, 2]).max()}")


def test_draper_fails():
    face, mesh, lcs = cylinder()
    kept, os.environ["DRAPE"] = os.environ["DRAPE"], "/no/such"
    draper = composites.Draper(mesh, lcs, face)
    os.environ["DRAPE"] = kept
    expect(not draper.isValid() and draper.reason == "no-program" and "/no/such" in draper.detail, draper.detail)
    expect(draper.diagnostics["valid"] is False and draper.diagnostics["reason"] == "no-program", draper.diagnostics)
    for call in (draper.get_tex_coords, draper.get_boundaries, lambda: draper.get_lcs_at_point(V())):
        try:
            call()
        except ValueError as error:
            expect("/no/such" in str(error), str(error))
        else:
            expect(False, "an answer without a drape")
    block = Part.makeBox(60, 60, 60)
    block = block.makeFillet(3, block.Edges)
    lcs = placed(V(30, 30, 60), V(1, 0, 0), V(0, 0, 1))
    bare = composites.Draper(Mesh.Mesh(block.tessellate(0.5)), lcs, block)
    expect(bare.reason == "bare" and bare.diagnostics["outcome"] == "partial" and "not in one piece" in bare.detail,
           f"{bare.reason} {bare.detail}")


def test_draper_in_composites():
    """The workbench itself needs a FreeCAD of its own: here a module in its place."""
    for name in ("freecad", "freecad.Composites", "freecad.Composites.features",
                 "freecad.Composites.features.CompositeShell"):
        sys.modules.setdefault(name, types.ModuleType(name))
    composites.use_in_composites()
    expect(sys.modules["freecad.Composites.features.CompositeShell"].Draper is composites.Draper, "another draper")


def main():
    tap = Tap()
    for name, test in (("a tray with fillets: yarns, cloth and pattern", test_tray),
                       ("a changed parameter drapes again", test_again), ("a daemon drapes alike", test_daemon),
                       ("a part that is moved", test_places), ("laying by a coordinate system", test_rosette),
                       ("failures withdraw what was there", test_failures), ("a document is opened again", test_document),
                       ("Composites: a cylinder, exactly", test_draper_exact),
                       ("Composites: strains of sheared cloth", test_draper_shear),
                       ("Composites: reasons for failure", test_draper_fails),
                       ("Composites: in the place of its draper", test_draper_in_composites)):
        tap.run(f"freecad: {name}", test)
    tap.finish()


with open(os.environ["TAP"], "w", buffering=1) as sys.stdout:
    try:
        main()
    except SystemExit:
        pass
os._exit(0)
