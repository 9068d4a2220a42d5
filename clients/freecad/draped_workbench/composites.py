# SPDX-License-Identifier: MIT
"""A draper for the Composites workbench (github.com/jwharington/FreeCAD-CompositesWB) in the place of its own: the same
constructor, calls and meanings, the net by draped. `use_in_composites()` puts it there.

Fabric coordinates are millimetres in the flat cloth from the coordinate system's origin, x along the warp, which begins
along the system's x; z is up. A local coordinate system is the rotation from global axes into those of the cloth at a
point: x is the warp, z the normal."""
from __future__ import annotations

import importlib
import math
from typing import Any, Optional, Sequence

import numpy as np
import Part
from FreeCAD import Rotation, Vector

from . import feature
from .net import Net
from .service import Failure, Service

CELLS = 60  # along a square part
TURNED = 0.01  # share of the cloth on the other side than the rest, from which on it is folded
BEYOND = 1.5  # cells: a point of the mesh that is farther outside the net has no cloth


class Draper:
    """The drape of a shape from a coordinate system, at the points of its mesh. What did not succeed has
    `isValid()` false, and `reason` (a word), `detail` (a sentence) and `diagnostics` say why; its calls raise
    ValueError. Nothing else stands in for a drape that failed."""

    def __init__(self, mesh: Any, lcs: Any, shape: Any, service: Optional[Service] = None,
                 spacing: float = 0) -> None:
        self.mesh, self.shape = mesh, shape
        self.reason = self.detail = ""
        self.diagnostics: dict[str, Any] = {}
        self.strains: Optional[np.ndarray] = None  # facets x (XX, YY, XY)
        try:
            self._drape(lcs, service or feature.service_of("", 60), spacing)
        except Failure as failure:
            self.reason, self.detail = failure.reason, str(failure)
        self.diagnostics.update(valid=self.isValid(), reason=self.reason, detail=self.detail)

    def _drape(self, lcs: Any, service: Service, spacing: float) -> None:
        if not self.mesh.Points:
            raise Failure("no-mesh", "The mesh has no points: choose a smaller MaxLength.")
        request = feature.rosette_of(lcs)
        base = Vector(*request["start"]["point"])
        on = self.shape.distToShape(Part.Vertex(base))[1][0][0]
        request["start"]["point"] = list(on)
        request["fabric"] = {"spacing": spacing or math.sqrt(self.shape.Area) / CELLS}
        faces = {"faces": list(range(len(self.shape.Faces)))}
        net = feature.drape_shape(self.shape, faces, {"length_unit": "mm", "direction": {"angle_deg": 0}, **request},
                                  service)
        points = net.locate([list(point.Vector) for point in self.mesh.Points])
        bare = int((points.beyond > BEYOND).sum())
        self.diagnostics = {**net.summary, "points": len(points.flat), "bare_points": bare}
        if bare or net.summary["outcome"] != "complete":
            raise Failure("bare", f"The cloth does not cover the shape, and {bare} of {len(points.flat)} points of its "
                          f"mesh are bare: {net.summary['verdict']['detail']}.")
        self.net: Net = net
        self.facets = np.array(self.mesh.Topology[1])
        areas = np.linalg.det(_edges(points.flat[self.facets])) / 2
        self.side = np.array([1.0, math.copysign(1, areas.sum())])  # of the fabric's axes: seen as the mesh is wound
        turned = np.abs(areas[areas * self.side[1] <= 0]).sum() / np.abs(areas).sum()
        if turned > TURNED:
            raise Failure("folded", f"{100 * turned:.1f} % of the cloth lie on other cloth: drape less of the part.")
        self.fabric_points = points.flat * self.side
        self.strains = self._strains()

    def isValid(self) -> bool:
        return self.strains is not None

    def _check(self) -> None:
        if not self.isValid():
            raise ValueError(self.detail)

    def _lcs(self, point: Sequence[float], normal: Any) -> Any:
        self._check()
        place = self.net.locate([list(point)])
        warp, weft = place.warp[0] * self.side[0], place.weft[0] * self.side[1]
        return Rotation(Vector(*warp), Vector(*weft), normal, "ZXY").inverted()

    def get_lcs(self, tri: Sequence[Any]) -> Any:
        """In the middle of a triangle, whose own normal is z."""
        normal = (tri[1] - tri[0]).cross(tri[2] - tri[1]).normalize()
        return self._lcs((tri[0] + tri[1] + tri[2]) / 3, normal)

    def get_lcs_at_point(self, center: Any) -> Any:
        """At the point of the shape that is nearest to this one, with its face's normal."""
        vertex = Part.Vertex(center)
        found = [(*face.distToShape(vertex), face) for face in self.shape.Faces]
        _, pairs, _, face = min(found, key=lambda each: each[0])
        return self._lcs(pairs[0][0], face.normalAt(*face.Surface.parameter(pairs[0][0])))

    def get_tex_coord_at_point(self, point: Any, offset_angle_deg: float = 0) -> Any:
        self._check()
        return _turned(self.net.locate([list(point)]).flat * self.side, offset_angle_deg)[0]

    def get_tex_coords(self, offset_angle_deg: float = 0) -> list[Any]:
        """Of the mesh's points."""
        self._check()
        return _turned(self.fabric_points, offset_angle_deg)

    def get_boundaries(self, offset_angle_deg: float = 0) -> list[list[Any]]:
        """What is cut: closed lines in the fabric, the last point of each the first."""
        self._check()
        return [_turned(np.vstack([points, points[:1]]) * self.side, offset_angle_deg)
                for points, _ in self.net.pattern("cut")]

    def calc_strain(self, facet: int) -> np.ndarray:
        self._check()
        return self.strains[facet]  # type: ignore[index]

    def _strains(self) -> np.ndarray:
        """Of the triangles: J = d(part)/d(fabric) in axes with x along the warp; XX = Jxx - 1, YY = Jyy - 1,
        XY = Jxy + Jyx. Of cloth that shears by gamma these are 0, cos(gamma) - 1, sin(gamma)."""
        corners = np.array([list(point) for point in self.mesh.Topology[0]])[self.facets]
        edges, flat = _edges(corners), _edges(self.fabric_points[self.facets])
        normal = np.cross(edges[:, :, 0], edges[:, :, 1])
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        warp = self.net.locate(corners.mean(axis=1)).warp * self.side[0]
        x = warp - (warp * normal).sum(axis=1, keepdims=True) * normal
        x /= np.linalg.norm(x, axis=1, keepdims=True)
        axes = np.stack([x, np.cross(normal, x)], axis=1)
        adjugate = np.stack([flat[:, ::-1, 1] * [1, -1], flat[:, ::-1, 0] * [-1, 1]], axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):  # nan in a triangle without area
            inverse = adjugate / np.linalg.det(flat)[:, None, None]
        jacobian = axes @ edges @ inverse
        return np.column_stack([jacobian[:, 0, 0] - 1, jacobian[:, 1, 1] - 1, jacobian[:, 0, 1] + jacobian[:, 1, 0]])


def _edges(corners: np.ndarray) -> np.ndarray:
    """Of triangles the edges from their first corner, as columns."""
    return np.stack([corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]], axis=2)


def _turned(flat: np.ndarray, angle_deg: float) -> list[Any]:
    turn = Rotation(Vector(0, 0, 1), angle_deg)
    return [turn.multVec(Vector(x, y, 0)) for x, y in flat.tolist()]


def use_in_composites() -> None:
    """From now on shells of the Composites workbench are draped by draped."""
    importlib.import_module("freecad.Composites.features.CompositeShell").Draper = Draper
