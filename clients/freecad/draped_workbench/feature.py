# SPDX-License-Identifier: MIT
"""What a drape is in a document: `Drape`, whose shape is the yarns, with the cloth as a mesh and the flat pattern as a
sketch that follow it. None of it needs a display."""
from __future__ import annotations

import math
import os
import re
import tempfile
from typing import Any, Optional

import FreeCAD
import Mesh
import Part

from . import net as nets
from . import service as services

METHODS = ["gib", "gib4", "basic", "geodesic", "mosaic"]
CELLS = 40  # along a square part, unless a spacing is given
AREA_TOLERANCE = 1e-3  # between FreeCAD's area of the chosen faces and that of the faces that were draped
POINT = 1e-6  # mm: a shorter line is none
V = FreeCAD.Vector


def preferences() -> Any:
    """`Program`, `Address` and `Token`: a token is not for documents, which are passed on."""
    return FreeCAD.ParamGet("User parameter:BaseApp/Preferences/Mod/Draped")


def service_of(address: str, limit: float) -> services.Service:
    kept = preferences()
    return services.service(address or kept.GetString("Address", os.environ.get("DRAPED_URL", "")),
                            kept.GetString("Program", os.environ.get("DRAPE", "drape")),
                            kept.GetString("Token", os.environ.get("DRAPED_TOKEN", "")), limit)


def drape_shape(shape: Any, chosen: dict[str, Any], request: dict[str, Any], service: services.Service) -> nets.Net:
    """The net on faces of a shape. They go as STEP, whose faces keep FreeCAD's order; that they are the chosen ones is
    seen from their area."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "part.step")
        shape.exportStep(path)
        with open(path, encoding="latin-1", newline="") as file:
            text = file.read()
        with open(path, "w", encoding="latin-1", newline="") as file:  # the same part, the same file: no time of day
            file.write(re.sub(r"(FILE_NAME\('[^']*',)'[^']*'", r"\1'1970-01-01T00:00:00'", text, count=1))
        net = nets.Net(*service.drape(request, path, chosen))
    if "faces" in chosen:
        area = sum(shape.Faces[k].Area for k in chosen["faces"])
        if abs(net.summary["part_area"] - area) > AREA_TOLERANCE * area:
            raise services.Failure("other-faces", f"The faces that were draped have {net.summary['part_area']:g} mm2, "
                                   f"those that were chosen {area:g}: drape the shape after Part > Refine shape.")
    return net


class DrapeProxy:
    """Of the object `Drape`, a Part::FeaturePython."""

    Type = "Draped::Drape"
    net: Optional[nets.Net] = None

    def __init__(self, obj: Any) -> None:
        obj.Proxy = self
        for kind, name, group, text in (
                ("LinkSubGlobal", "Faces", "Part", "Faces of one body, on the tool side"),
                ("Angle", "UpTo", "Part", "Also faces that join the first across folds of at most so much; 0: none"),
                ("LinkGlobal", "Rosette", "Laying", "A coordinate system: laying begins at its origin, with the warp "
                 "along its x"),
                ("Bool", "OwnStart", "Laying", "Whether laying begins at Start, else at the rosette or in the middle"),
                ("Vector", "Start", "Laying", "A point of the faces"),
                ("Angle", "Angle", "Laying", "Of the warp, from the rosette's x, or the x axis"),
                ("Length", "Spacing", "Laying", "Of yarns in the net; 0: by the size of the part"),
                ("Enumeration", "Method", "Laying", "How the net is marched"),
                ("Angle", "Locking", "Cloth", "Shear that the fabric takes; 0: not known"),
                ("String", "Material", "Cloth", "Of the library, `drape --materials`; empty: none"),
                ("IntegerConstraint", "YarnStep", "Cloth", "Every so many yarns are drawn"),
                ("String", "Service", "Service", "Address of a daemon; empty: by the preferences"),
                ("FloatConstraint", "Limit", "Service", "Seconds that a drape may take"),
                ("String", "Outcome", "Result", "What became of it"),
                ("Integer", "Nodes", "Result", "Of the net"),
                ("Angle", "MaxShear", "Result", "Largest shear"),
                ("Float", "Coverage", "Result", "Share of the faces that the cloth covers"),
                ("Area", "FlatArea", "Result", "Of the flat cloth")):
            obj.addProperty(f"App::Property{kind}", name, group, text)
        obj.Method, obj.UpTo = METHODS, 0
        obj.YarnStep, obj.Limit = (1, 1, 1000, 1), (60, 1, 3600, 1)
        for name in ("Outcome", "Nodes", "MaxShear", "Coverage", "FlatArea"):
            obj.setEditorMode(name, 1)

    def execute(self, obj: Any) -> None:
        self.net = None
        try:
            self.net = drape_shape(*self._faces(obj), self._request(obj), service_of(obj.Service, obj.Limit))
        except services.Failure as failure:
            self._withdraw(obj, failure)
            raise
        summary = self.net.summary
        obj.Shape = Part.makeCompound([Part.makePolygon([V(*point) for point in yarn])
                                       for _, yarn in self.net.yarns(obj.YarnStep)])
        obj.Nodes, obj.MaxShear = summary["nodes"], summary["max_shear_deg"]
        obj.Coverage, obj.FlatArea = summary["cloth_coverage"], summary["flat_area"]
        obj.Outcome = f"{summary['outcome']}: {summary['nodes']} nodes, shear up to {summary['max_shear_deg']:.1f} " \
                      f"deg, {100 * summary['cloth_coverage']:.1f} % covered"

    def net_of(self, obj: Any) -> nets.Net:
        """The net of what the object is now; after a document was opened it is draped again."""
        if self.net is None:
            self.execute(obj)
        return self.net  # type: ignore[return-value]

    @staticmethod
    def _faces(obj: Any) -> tuple[Any, dict[str, Any]]:
        if not obj.Faces or not obj.Faces[1]:
            raise services.Failure("no-faces", "No faces are chosen: set Faces, or select faces of a body and drape.")
        body, names = obj.Faces
        if not all(re.fullmatch(r"Face\d+", name.rpartition(".")[2]) for name in names):
            raise services.Failure("no-faces", f"{', '.join(names)}: choose faces.")
        shape = body.Shape.copy()
        if hasattr(body, "getGlobalPlacement"):
            shape.Placement = body.getGlobalPlacement()
        faces = sorted({int(name.rpartition("Face")[2]) - 1 for name in names})
        if obj.UpTo > 0:
            if len(faces) > 1:
                raise services.Failure("no-faces", "With UpTo one face is chosen, from which the others are reached.")
            return shape, {"grow_from": faces[0], "up_to_deg": float(obj.UpTo)}
        return shape, {"faces": faces}

    @staticmethod
    def _request(obj: Any) -> dict[str, Any]:
        spacing = float(obj.Spacing) or usual_spacing(obj)
        fabric: dict[str, Any] = {"spacing": spacing}
        if obj.Locking > 0:
            fabric["locking_angle_deg"] = float(obj.Locking)
        if obj.Material:
            fabric["material"] = obj.Material
        request: dict[str, Any] = {"length_unit": "mm", "fabric": fabric, "method": obj.Method,
                                   "direction": {"angle_deg": float(obj.Angle)}}
        if obj.Rosette:
            request.update(rosette_of(obj.Rosette))
        if obj.OwnStart:
            request["start"] = {"point": list(obj.Start)}
        return request

    def _withdraw(self, obj: Any, failure: Exception) -> None:
        """Nothing that is out of date stays in the document."""
        obj.Shape, obj.Outcome = Part.Shape(), str(failure)
        obj.Nodes = obj.MaxShear = obj.Coverage = obj.FlatArea = 0
        for other in obj.InList:
            if getattr(getattr(other, "Proxy", None), "Type", "") in ("Draped::Cloth", "Draped::Pattern"):
                other.Proxy.clear(other)

    def __getstate__(self) -> None:  # the net is not kept with the document
        return None

    def __setstate__(self, state: Any) -> None:
        return None

    dumps, loads = __getstate__, __setstate__  # what FreeCAD 1.0 calls them


def usual_spacing(obj: Any) -> float:
    """Two digits of what gives CELLS along a square of the faces' area."""
    body, names = obj.Faces
    faces = body.Shape.Faces
    area = sum(faces[int(name.rpartition("Face")[2]) - 1].Area for name in names)
    side = math.sqrt(area) / CELLS
    digit = 10 ** math.floor(math.log10(side) - 1)
    return max(round(side / digit), 1) * digit


def rosette_of(lcs: Any) -> dict[str, Any]:
    """The keys `rosette` and `start` of a request, by an object with a placement."""
    place = lcs.getGlobalPlacement() if hasattr(lcs, "getGlobalPlacement") else lcs.Placement
    x, z = (list(place.Rotation.multVec(axis)) for axis in (V(1, 0, 0), V(0, 0, 1)))
    return {"rosette": {"origin": list(place.Base), "x": x, "z": z}, "start": {"point": list(place.Base)}}


class Follower:
    """An object that shows the net of the Drape that it links to."""

    Type = ""

    def __init__(self, obj: Any, drape: Any) -> None:
        obj.addProperty("App::PropertyLink", "Drape", "Cloth", "What it shows")
        obj.Proxy, obj.Drape = self, drape

    def __getstate__(self) -> None:
        return None

    def __setstate__(self, state: Any) -> None:
        return None

    dumps, loads = __getstate__, __setstate__


class ClothProxy(Follower):
    """Of the object `Cloth`, a Mesh::FeaturePython: two triangles a cell, in the colour of its shear."""

    Type = "Draped::Cloth"

    def __init__(self, obj: Any, drape: Any) -> None:
        super().__init__(obj, drape)
        obj.addProperty("App::PropertyAngle", "FullColour", "Cloth", "Shear from which on the colour is full; 0: the "
                        "locking angle, else the largest")
        obj.addProperty("App::PropertyColorList", "FaceColors", "Cloth", "Of the triangles")
        obj.addProperty("App::PropertyFloatList", "Shear", "Cloth", "Of the triangles, in degrees")
        for name in ("FaceColors", "Shear"):
            obj.setEditorMode(name, 2)

    def execute(self, obj: Any) -> None:
        drape = obj.Drape
        net = drape.Proxy.net_of(drape)
        limit = float(obj.FullColour) or float(drape.Locking) or abs(net.shear).max()
        points, triangles = net.points.tolist(), map(tuple, net.triangles().tolist())
        obj.Mesh = Mesh.Mesh(([V(*point) for point in points], list(triangles)))
        obj.FaceColors = [tuple(colour) for colour in net.colours(limit).repeat(2, axis=0).tolist()]
        obj.Shear = net.shear.repeat(2).tolist()

    @staticmethod
    def clear(obj: Any) -> None:
        obj.Mesh, obj.FaceColors, obj.Shear = Mesh.Mesh(), [], []


class PatternProxy(Follower):
    """Of the object `Pattern`, a Sketcher::SketchObjectPython: the edge of the flat cloth, the warp along x, the start
    at the sketch's origin; notches and the grain are construction lines."""

    Type = "Draped::Pattern"

    def execute(self, obj: Any) -> bool:
        net = obj.Drape.Proxy.net_of(obj.Drape)
        self.clear(obj)
        for name, drawn in (("cut", False), ("notches", True), ("grain", True)):
            lines = []
            for points, closed in net.pattern(name):
                corners = [V(x, y, 0) for x, y in points.tolist()]
                lines += [Part.LineSegment(a, b) for a, b in zip(corners, corners[1:] + corners[:closed])
                          if a.distanceToPoint(b) > POINT]
            obj.addGeometry(lines, drawn)
        return False  # and what a sketch does itself: its shape by its lines

    @staticmethod
    def clear(obj: Any) -> None:
        obj.deleteAllGeometry()
        obj.Shape = Part.Shape()


def make_drape(faces: tuple[Any, list[str]], name: str = "Drape") -> Any:
    """A drape of faces, (body, ["Face1", ...]), with its cloth and pattern, in the body's document; not yet
    computed. The pattern lies beside the part."""
    document = faces[0].Document
    drape = document.addObject("Part::FeaturePython", name)
    DrapeProxy(drape)
    drape.Faces = faces
    cloth = document.addObject("Mesh::FeaturePython", f"{name}Cloth")
    ClothProxy(cloth, drape)
    pattern = document.addObject("Sketcher::SketchObjectPython", f"{name}Pattern")
    PatternProxy(pattern, drape)
    box = faces[0].Shape.BoundBox
    pattern.Placement.Base = V(box.XMax + box.DiagonalLength, 0, box.ZMin)
    return drape
