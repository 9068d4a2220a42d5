/* SPDX-License-Identifier: MIT */
/*
 * Degree reduction, span by span and direction by direction. In homogeneous coordinates a row of
 * control points is a curve of Bezier pieces p(t) of degree m. On each piece, or on halves of it, q
 * of degree n < m has value, first and second derivative of p at both ends, so that neighbours join
 * as smoothly as before up to curvature, and p's values at n - 5 places between. The coefficients
 * of p - q, in Bernstein polynomials of degree m, bound how far they are apart.
 */
#include "degree.h"

#include <TColStd_Array1OfInteger.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TColStd_Array2OfReal.hxx>
#include <TColgp_Array2OfPnt.hxx>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace drape {
namespace {

enum { ENDS = 3, HALVINGS = 6 };
constexpr double APART = 1e-9; /* of the surface's size */
constexpr double FAR_APART = 1e-6;
constexpr double SMOOTH = 1e-9; /* likewise: by which taking out a knot may move the surface */

using point = std::array<double, 4>; /* w x, w y, w z, w */
using row = std::vector<point>;

point blend(double s, const point &a, double t, const point &b) {
    return {s * a[0] + t * b[0], s * a[1] + t * b[1], s * a[2] + t * b[2], s * a[3] + t * b[3]};
}

/* Bernstein's polynomial number k of degree n. */
double bernstein_polynomial(size_t n, size_t k, double t) {
    double value = 1;
    for (size_t i = 0; i < k; i++)
        value *= t * double(n - i) / double(i + 1);
    return value * std::pow(1 - t, double(n - k));
}

point value(const row &p, double t) {
    point sum{};
    for (size_t k = 0; k < p.size(); k++)
        sum = blend(1, sum, bernstein_polynomial(p.size() - 1, k, t), p[k]);
    return sum;
}

/* The control points of [from, to] of a piece. */
row piece_between(const row &p, double from, double to) {
    size_t m = p.size() - 1;
    row out(m + 1);
    for (size_t k = 0; k <= m; k++) { /* the blossom at `to` k times and at `from` m - k times */
        row level = p;
        for (size_t round = 0; round < m; round++) {
            double t = round < k ? to : from;
            for (size_t i = 0; i < m - round; i++)
                level[i] = blend(1 - t, level[i], t, level[i + 1]);
        }
        out[k] = level[0];
    }
    return out;
}

/* The three control points of q at an end, from those of p there. */
void meet_end(const row &p, bool last, double m, double n, row &q) {
    auto from = [&](size_t k) { return last ? p[p.size() - 1 - k] : p[k]; };
    auto to = [&](size_t k) -> point & { return last ? q[q.size() - 1 - k] : q[k]; };
    double first = m / n, second = m * (m - 1) / (n * (n - 1));
    to(0) = from(0);
    to(1) = blend(1 - first, from(0), first, from(1));
    point bend = blend(1, blend(1, from(2), -2, from(1)), 1, from(0));
    to(2) = blend(1, blend(2, to(1), -1, to(0)), second, bend);
}

/* Solves a x = b, both given up, by Gauss' method with pivots. */
row solve_linear(std::vector<std::vector<double>> a, row b) {
    size_t n = b.size();
    for (size_t k = 0; k < n; k++) {
        size_t pivot = k;
        for (size_t i = k + 1; i < n; i++)
            if (std::fabs(a[i][k]) > std::fabs(a[pivot][k]))
                pivot = i;
        std::swap(a[k], a[pivot]);
        std::swap(b[k], b[pivot]);
        for (size_t i = 0; i < n; i++) {
            double factor = i == k ? 0 : a[i][k] / a[k][k];
            for (size_t j = k; j < n && i != k; j++)
                a[i][j] -= factor * a[k][j];
            b[i] = blend(1, b[i], -factor, b[k]);
        }
    }
    for (size_t k = 0; k < n; k++)
        b[k] = blend(1 / a[k][k], b[k], 0, b[k]);
    return b;
}

row reduce_piece(const row &p, size_t n) {
    size_t free = n + 1 - 2 * ENDS;
    row q(n + 1), right;
    meet_end(p, false, double(p.size() - 1), double(n), q);
    meet_end(p, true, double(p.size() - 1), double(n), q);
    std::vector<std::vector<double>> matrix;
    for (size_t i = 0; i < free; i++) {
        double t = (1 - std::cos(M_PI * (double(i) + 0.5) / double(free))) / 2;
        matrix.emplace_back();
        for (size_t k = ENDS; k < n + 1 - ENDS; k++)
            matrix.back().push_back(bernstein_polynomial(n, k, t));
        right.push_back(blend(1, value(p, t), -1, value(q, t)));
    }
    row middle = solve_linear(matrix, right);
    std::copy(middle.begin(), middle.end(), q.begin() + ENDS);
    return q;
}

/* How far two pieces are apart at most: q with the degree of p raised step by step. */
double pieces_apart(const row &p, row q) {
    double worst = 0;
    while (q.size() < p.size()) {
        double n = double(q.size());
        row up{q.front()};
        for (size_t k = 1; k < q.size(); k++)
            up.push_back(blend(double(k) / n, q[k - 1], 1 - double(k) / n, q[k]));
        up.push_back(q.back());
        q = up;
    }
    for (size_t k = 0; k < p.size(); k++) {
        double by = 0;
        for (size_t i = 0; i < 3; i++) /* as places, with those of p */
            by = std::hypot(by, q[k][i] - p[k][i] / p[k][3] * q[k][3]);
        worst = std::max(worst, by / std::min(q[k][3], p[k][3]));
    }
    return worst;
}

/* A surface as rows of Bezier pieces along u. */
struct rows {
    std::vector<row> of; /* one for each control point along v */
    std::vector<double> knots;
    size_t degree;
};

rows split_rows(const Handle(Geom_BSplineSurface) & surface) {
    rows out;
    int knots = surface->NbUKnots();
    if (knots > 2)
        surface->IncreaseUMultiplicity(2, knots - 1, surface->UDegree());
    out.degree = size_t(surface->UDegree());
    for (int k = 1; k <= knots; k++)
        out.knots.push_back(surface->UKnot(k));
    for (int i = 1; i <= surface->NbVPoles(); i++) {
        out.of.emplace_back();
        for (int j = 1; j <= surface->NbUPoles(); j++) {
            gp_Pnt p = surface->Pole(j, i);
            double w = surface->Weight(j, i);
            out.of.back().push_back({w * p.X(), w * p.Y(), w * p.Z(), w});
        }
    }
    return out;
}

double rows_size(const rows &surface) {
    double low[3], high[3], sum = 0;
    for (size_t k = 0; k < 3; k++) {
        low[k] = HUGE_VAL;
        high[k] = -HUGE_VAL;
        for (const row &r : surface.of)
            for (const point &p : r) {
                low[k] = std::min(low[k], p[k] / p[3]);
                high[k] = std::max(high[k], p[k] / p[3]);
            }
        sum = std::hypot(sum, high[k] - low[k]);
    }
    return sum;
}

/* All rows of span number `span` in `pieces` equal pieces of degree n, after what is there. */
double reduce_span(const rows &from, size_t span, size_t n, size_t pieces, rows &to) {
    double worst = 0;
    for (size_t i = 0; i < from.of.size(); i++) {
        auto begin = from.of[i].begin() + long(span * from.degree);
        row whole(begin, begin + long(from.degree + 1));
        for (size_t k = 0; k < pieces; k++) {
            row p =
                piece_between(whole, double(k) / double(pieces), double(k + 1) / double(pieces));
            row q = reduce_piece(p, n);
            worst = std::max(worst, pieces_apart(p, q));
            to.of[i].insert(to.of[i].end(), q.begin() + !to.of[i].empty(), q.end());
        }
    }
    for (size_t k = 1; k <= pieces; k++) {
        double share = double(k) / double(pieces);
        to.knots.push_back((1 - share) * from.knots[span] + share * from.knots[span + 1]);
    }
    return worst;
}

rows reduce_rows(const rows &from, size_t n, double allowed, double &by) {
    rows to{std::vector<row>(from.of.size()), {from.knots[0]}, n};
    for (size_t span = 0; span + 1 < from.knots.size(); span++) {
        const rows before = to;
        double worst = HUGE_VAL;
        for (int halving = 0; halving <= HALVINGS && !(worst <= allowed); halving++) {
            to = before;
            worst = reduce_span(from, span, n, size_t(1) << halving, to);
        }
        by = std::max(by, worst);
    }
    return to;
}

/* The surface of the rows, its other direction being that of `like`. */
Handle(Geom_BSplineSurface) join(const rows &r, const Handle(Geom_BSplineSurface) & like) {
    int along = int(r.of[0].size()), across = int(r.of.size()), degree = int(r.degree);
    TColgp_Array2OfPnt poles(1, along, 1, across);
    TColStd_Array2OfReal weights(1, along, 1, across);
    for (int i = 1; i <= across; i++)
        for (int j = 1; j <= along; j++) {
            const point &p = r.of[size_t(i - 1)][size_t(j - 1)];
            poles.SetValue(j, i, gp_Pnt(p[0] / p[3], p[1] / p[3], p[2] / p[3]));
            weights.SetValue(j, i, p[3]);
        }
    TColStd_Array1OfReal knots(1, int(r.knots.size()));
    TColStd_Array1OfInteger counts(1, int(r.knots.size()));
    for (int k = 1; k <= knots.Length(); k++) {
        knots.SetValue(k, r.knots[size_t(k - 1)]);
        counts.SetValue(k, k == 1 || k == knots.Length() ? degree + 1 : degree);
    }
    return new Geom_BSplineSurface(poles, weights, knots, like->VKnots(), counts,
                                   like->VMultiplicities(), degree, like->VDegree());
}

/* Takes out of the knots of u those within what the surface is smooth over. */
void take_out_knots(const Handle(Geom_BSplineSurface) & surface, double allowed) {
    int degree = surface->UDegree();
    for (int k = surface->NbUKnots() - 1; k > 1; k--)
        for (int count = degree - 1; count > degree - ENDS; count--)
            if (!surface->RemoveUKnot(k, count, allowed))
                break;
}

/* A copy without periods, whose knots begin and end with the domain. */
Handle(Geom_BSplineSurface) cut_open(const Handle(Geom_BSplineSurface) & surface) {
    Handle(Geom_BSplineSurface) copy = Handle(Geom_BSplineSurface)::DownCast(surface->Copy());
    double low[2], high[2];
    copy->Bounds(low[0], high[0], low[1], high[1]);
    if (copy->IsUPeriodic())
        copy->SetUNotPeriodic();
    if (copy->IsVPeriodic())
        copy->SetVNotPeriodic();
    if (copy->FirstUKnotIndex() > 1 || copy->FirstVKnotIndex() > 1)
        copy->Segment(low[0], high[0], low[1], high[1]);
    return copy;
}

} // namespace

Handle(Geom_BSplineSurface)
    limit_degree(const Handle(Geom_BSplineSurface) & surface, int most, double &by) {
    Handle(Geom_BSplineSurface) made = surface;
    by = 0;
    for (int v = 0; v < 2; v++) {
        if ((v ? made->VDegree() : made->UDegree()) <= most)
            continue;
        made = cut_open(made);
        if (v)
            made->ExchangeUV();
        rows whole = split_rows(made);
        double size = rows_size(whole);
        rows reduced = reduce_rows(whole, size_t(most), APART * size, by);
        if (!(by <= FAR_APART * size))
            return nullptr;
        made = join(reduced, made);
        take_out_knots(made, SMOOTH * size);
        if (v)
            made->ExchangeUV();
    }
    return made;
}

} // namespace drape
