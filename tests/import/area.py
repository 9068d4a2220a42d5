# SPDX-License-Identifier: MIT
"""Areas of the faces of a surface document, by Green's theorem: for G with dG/du = |r_u x r_v| the
area inside a loop is the integral of G dv along it. Gauss's rule on every knot span of the trim
curves and of the surface; an independent reader of what the importer writes."""

import numpy

NODES, WEIGHTS = numpy.polynomial.legendre.leggauss(12)
HALVINGS = 12  # of a span of a trim curve, towards where it crosses a knot of its surface


def basis(knots, degree, span, t):
    """The degree + 1 B-splines that are not 0 on a span, at the places t; Cox and de Boor."""
    left = [None] + [t - knots[span + 1 - j] for j in range(1, degree + 1)]
    right = [None] + [knots[span + j] - t for j in range(1, degree + 1)]
    values = [numpy.ones_like(t)]
    for j in range(1, degree + 1):
        saved, row = numpy.zeros_like(t), []
        for r in range(j):
            share = values[r] / (right[r + 1] + left[j - r])
            row.append(saved + right[r + 1] * share)
            saved = left[j - r] * share
        values = row + [saved]
    return numpy.array(values)


def derivatives(knots, degree, span, t):
    """The same B-splines and their derivatives."""
    lower = basis(knots, degree - 1, span, t)
    slope = numpy.zeros((degree + 1,) + t.shape)
    for k in range(degree):
        low = span - degree + 1 + k
        share = degree * lower[k] / (knots[low + degree] - knots[low])
        slope[k] -= share
        slope[k + 1] += share
    return basis(knots, degree, span, t), slope


def spans(knots, degree, count):
    return [k for k in range(degree, count) if knots[k + 1] > knots[k]]


class Surface:
    def __init__(self, face):
        self.degree = face["degree_u"], face["degree_v"]
        self.size = face["size_u"], face["size_v"]
        self.knots = numpy.array(face["knotvector_u"]), numpy.array(face["knotvector_v"])
        points = numpy.array(face["control_points"]["points"]).reshape(self.size + (3,))
        weights = face["control_points"].get("weights")
        weights = numpy.array(weights).reshape(self.size) if weights else numpy.ones(self.size)
        self.net = numpy.concatenate([points * weights[..., None], weights[..., None]], axis=2)
        self.domain = [(self.knots[k][self.degree[k]], self.knots[k][self.size[k]]) for k in (0, 1)]

    def element(self, span, u, v):
        """|r_u x r_v| at places of one span each way."""
        p, q = self.degree
        bu, du = derivatives(self.knots[0], p, span[0], u)
        bv, dv = derivatives(self.knots[1], q, span[1], v)
        net = self.net[span[0] - p : span[0] + 1, span[1] - q : span[1] + 1]
        sums = [numpy.einsum("in,jn,ijx->nx", a, b, net) for a, b in ((bu, bv), (du, bv), (bu, dv))]
        r, w = sums[0][:, :3] / sums[0][:, 3:], sums[0][:, 3:]
        ru = (sums[1][:, :3] - sums[1][:, 3:] * r) / w
        rv = (sums[2][:, :3] - sums[2][:, 3:] * r) / w
        return numpy.linalg.norm(numpy.cross(ru, rv), axis=1)

    def antiderivative(self, u, v):
        """The integral of |r_u x r_v| from the domain's lower border to u, at places (u, v)."""
        total = numpy.zeros_like(u)
        knots, p, q = self.knots, self.degree[0], self.degree[1]
        inner = numpy.clip(v, *self.domain[1])
        for row in spans(knots[1], q, self.size[1]):
            last = row == spans(knots[1], q, self.size[1])[-1]
            here = (inner >= knots[1][row]) & ((inner < knots[1][row + 1]) | last)
            for span in spans(knots[0], p, self.size[0]):
                low, high = knots[0][span], knots[0][span + 1]
                end = numpy.clip(u[here], low, high)
                for node, weight in zip(NODES, WEIGHTS):
                    at = low + (end - low) * (1 + node) / 2
                    total[here] += weight * (end - low) / 2 * self.element((span, row), at, inner[here])
        return total


def curve_pieces(curve, surface):
    """The trim curve at Gauss's nodes, in pieces within a span of its surface: u, v, dv weighted."""
    degree = curve["degree"]
    knots = numpy.array(curve["knotvector"])
    points = numpy.array(curve["control_points"]["points"])
    weights = curve["control_points"].get("weights")
    weights = numpy.array(weights) if weights else numpy.ones(len(points))
    net = numpy.concatenate([points * weights[:, None], weights[:, None]], axis=1)
    assert len(knots) == len(points) + degree + 1

    def places(span, low, high):
        t = numpy.concatenate([[low], low + (high - low) * (1 + NODES) / 2, [high]])
        b, d = derivatives(knots, degree, span, t)
        x, dx = (numpy.einsum("in,ix->nx", s, net[span - degree : span + 1]) for s in (b, d))
        uv = x[:, :2] / x[:, 2:]
        return uv, (dx[:, 1] - dx[:, 2] * uv[:, 1]) / x[:, 2]

    for span in spans(knots, degree, len(points)):
        stack = [(knots[span], knots[span + 1], 0)]
        while stack:
            low, high, depth = stack.pop()
            uv, dv = places(span, low, high)
            crossed = any(
                ((k > uv[:, x].min() + 1e-9) & (k < uv[:, x].max() - 1e-9)).any()
                for x, k in enumerate(surface.knots)
            )
            if depth < (HALVINGS if crossed else 1):
                middle = (low + high) / 2
                stack += [(low, middle, depth + 1), (middle, high, depth + 1)]
            else:
                yield uv[1:-1, 0], uv[1:-1, 1], dv[1:-1] * WEIGHTS * (high - low) / 2


def whole(surface):
    total = 0
    for row in spans(surface.knots[1], surface.degree[1], surface.size[1]):
        low, high = surface.knots[1][row], surface.knots[1][row + 1]
        v = low + (high - low) * (1 + NODES) / 2
        u = numpy.full_like(v, surface.domain[0][1])
        total += (surface.antiderivative(u, v) * WEIGHTS * (high - low) / 2).sum()
    return total


def area(face):
    surface = Surface(face)
    if not face.get("trims"):
        return whole(surface)
    total = 0
    for loop in face["trims"]:
        pieces = [piece for curve in loop["data"] for piece in curve_pieces(curve, surface)]
        u, v, dv = (numpy.concatenate([piece[k] for piece in pieces]) for k in range(3))
        inside = abs((surface.antiderivative(u, v) * dv).sum())
        total += inside if loop["reversed"] else -inside
    return total
