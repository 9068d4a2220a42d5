# SPDX-License-Identifier: MIT
"""A draped net as what FreeCAD shows and asks: quadrilaterals, yarns, the flat cloth, and the place in the
cloth of a point on the part. Lengths are in the net's own unit, millimetres here."""
from __future__ import annotations

from typing import Any, Iterator, Mapping, NamedTuple
from xml.etree import ElementTree

import numpy as np

NEAREST = 9  # cells that are looked at for a point: those whose middles are nearest to it
STEPS = 6  # of Newton's method within a cell
SLACK = 1e-9  # of a cell


class Places(NamedTuple):
    """Of n points: where in the flat cloth they are, how the cloth lies there, how far away it is."""

    flat: np.ndarray  # n x 2, along warp and weft from the start
    warp: np.ndarray  # n x 3, d(point)/d(flat) along the warp
    weft: np.ndarray  # n x 3
    distance: np.ndarray  # n
    beyond: np.ndarray  # n, in cells: how far outside the nearest cell, 0 within it


class Net:
    """Of the JSON of a result, and its flat pattern as SVG."""

    def __init__(self, result: Mapping[str, Any], pattern: str) -> None:
        nodes, cells = result["nodes"], result["cells"]
        self.summary: dict[str, Any] = result["summary"]
        self.spacing = np.array(result["grid"]["spacing"], dtype=float)
        self.index = np.column_stack([nodes["i"], nodes["j"]]).astype(int)
        self.points = np.column_stack([nodes[axis] for axis in "xyz"]).astype(float)
        at = {(i, j): k for k, (i, j) in enumerate(self.index.tolist())}
        self.corners = np.array([[at[i, j], at[i + 1, j], at[i + 1, j + 1], at[i, j + 1]]
                                 for i, j in zip(map(int, cells["i"]), map(int, cells["j"]))], dtype=int).reshape(-1, 4)
        self.shear = np.array(cells["shear_deg"], dtype=float)
        self._pattern = ElementTree.fromstring(pattern.encode())
        places = self.index[self.corners[:, 0]].tolist()
        taken = {(i, j) for i, j in places}
        # Of each cell, warp and weft: whether there is another before and behind it.
        self.goes_on = np.array([[[(i - di, j - dj) in taken, (i + di, j + dj) in taken] for di, dj in ((1, 0), (0, 1))]
                                 for i, j in places], dtype=bool).reshape(-1, 2, 2)
        self.middles = self.points[self.corners].mean(axis=1)

    @property
    def flat(self) -> np.ndarray:
        """The nodes in the flat cloth."""
        return self.index * self.spacing

    def triangles(self) -> np.ndarray:
        """Two for each cell, its own behind each other."""
        return self.corners[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)

    def yarns(self, step: int = 1) -> Iterator[tuple[str, np.ndarray]]:
        """Every `step`-th warp and weft yarn from the start, as ("warp" or "weft", points); a yarn that a
        hole divides comes in parts."""
        for name, along in (("warp", 0), ("weft", 1)):
            across = 1 - along
            order = np.lexsort((self.index[:, along], self.index[:, across]))
            order = order[self.index[order, across] % step == 0]
            places = self.index[order]
            follows = (np.diff(places[:, across]) == 0) & (np.diff(places[:, along]) == 1)
            for part in np.split(order, np.flatnonzero(~follows) + 1):
                if len(part) > 1:
                    yield name, self.points[part]

    def pattern(self, name: str) -> Iterator[tuple[np.ndarray, bool]]:
        """Lines of the flat pattern by what they are, `cut` (the edge, holes as well), `notches` or `grain`: the points
        of each in the flat cloth, and whether it is closed."""
        for path in self._pattern.iter("{http://www.w3.org/2000/svg}path"):
            if path.get("id") != name:
                continue
            for part in path.get("d", "").split("M")[1:]:
                words = part.replace("L", " ").replace("Z", " ").split()
                yield np.array(words, dtype=float).reshape(-1, 2), "Z" in part

    def colours(self, limit: float) -> np.ndarray:
        """Of each cell red, green, blue, 0 to 1: white without shear, red from `limit` degrees on to one side, blue
        to the other."""
        share = np.clip(self.shear / max(limit, SLACK), -1, 1)
        pale = 1 - np.abs(share)
        return np.column_stack([np.where(share > 0, 1, pale), pale, np.where(share < 0, 1, pale)])

    def locate(self, points: Any) -> Places:
        """Where points on the part are in the cloth. A cell is x(a, b) = sum of its corners by a and b bilinearly;
        the nearest x to a point has (x - point) . x_a = (x - point) . x_b = 0, by Newton's method without the
        second derivatives, from the middle. A cell goes on over its edge where no other is: there are the places of
        points beside the net."""
        points = np.asarray(points, dtype=float).reshape(-1, 3)
        near = self._nearest(points)
        cell = self.points[self.corners[near]]  # n x NEAREST x 4 x 3
        ab = np.full(near.shape + (2,), 0.5)
        for _ in range(STEPS):
            at, along, across = _bilinear(cell, ab)
            ab += _least_squares(along, across, points[:, None] - at)
        off = np.linalg.norm(points[:, None] - _bilinear(cell, np.clip(ab, 0, 1))[0], axis=2)
        outside = np.abs(ab - 0.5).max(axis=2)
        rows = np.arange(len(points))
        best = np.argmin(off + SLACK * outside, axis=1)
        cell, ab, chosen = cell[rows, best], ab[rows, best], near[rows, best]
        goes_on = self.goes_on[chosen]
        ab = np.clip(ab, np.where(goes_on[:, :, 0], 0, -np.inf), np.where(goes_on[:, :, 1], 1, np.inf))
        beyond = np.maximum(np.abs(ab - 0.5) - 0.5, 0).max(axis=1)
        at, along, across = _bilinear(cell, ab)
        first = self.index[self.corners[chosen, 0]]
        return Places((first + ab) * self.spacing, along / self.spacing[0], across / self.spacing[1], off[rows, best],
                      beyond)

    def _nearest(self, points: np.ndarray) -> np.ndarray:
        count = min(NEAREST, len(self.middles))
        found = np.empty((len(points), count), dtype=int)
        for some in np.array_split(np.arange(len(points)), len(points) * len(self.middles) // 4_000_000 + 1):
            squares = ((points[some, None] - self.middles) ** 2).sum(axis=2)
            found[some] = np.argpartition(squares, count - 1, axis=1)[:, :count]
        return found


def _bilinear(cell: np.ndarray, ab: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """x(a, b) of cells, and its derivatives."""
    a, b = ab[..., :1], ab[..., 1:]
    p, q, r, s = (cell[..., k, :] for k in range(4))
    return ((1 - a) * (1 - b) * p + a * (1 - b) * q + a * b * r + (1 - a) * b * s,
            (1 - b) * (q - p) + b * (r - s), (1 - a) * (s - p) + a * (r - q))


def _least_squares(along: np.ndarray, across: np.ndarray, off: np.ndarray) -> np.ndarray:
    """(da, db) with which along da + across db is nearest to off."""
    aa, ab, bb = ((x * y).sum(axis=-1) for x, y in ((along, along), (along, across), (across, across)))
    u, v = (along * off).sum(axis=-1), (across * off).sum(axis=-1)
    det = aa * bb - ab**2
    return np.stack([bb * u - ab * v, aa * v - ab * u], axis=-1) / np.where(det > 0, det, np.inf)[..., None]
