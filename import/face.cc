/* SPDX-License-Identifier: MIT */
#include "face.h"

#include "degree.h"
#include "import.h"
#include <BRepBuilderAPI_NurbsConvert.hxx>
#include <BRepTools.hxx>
#include <BRep_Tool.hxx>
#include <Geom2dAdaptor_Curve.hxx>
#include <Geom2dConvert.hxx>
#include <Geom2d_BSplineCurve.hxx>
#include <Geom2d_TrimmedCurve.hxx>
#include <GeomAdaptor_Surface.hxx>
#include <GeomConvert.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Geom_RectangularTrimmedSurface.hxx>
#include <ShapeExtend_WireData.hxx>
#include <Standard_Failure.hxx>
#include <TopExp.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Iterator.hxx>
#include <TopoDS_Vertex.hxx>
#include <TopoDS_Wire.hxx>
#include <algorithm>
#include <cmath>
#include <limits>

namespace drape {
namespace {

using uv = std::array<double, 2>; /* a point in parameters */

enum { FIT_DEGREE = 5, HALVINGS = 12, SAMPLES = 32 };
constexpr double FIT = 1e-9;     /* deviation of a carried trim curve, as a share of the domain */
constexpr double ON_EDGE = 1e-9; /* how near to the domain's border a curve lies on it, likewise */
constexpr double CLOSE = 1e-5;   /* how near curves that follow each other meet, likewise */
constexpr double NEAR = 0.01;    /* how near they are if a seam is not between them, likewise */
constexpr double EXACT = 1e-9; /* deviation of a surface from the file's, as a share of its size */

/* ---- parameters of a surface and of its NURBS ---- */

/* A parameter of the file's surface as one of its NURBS: the same, or where the file's is an angle
 * and the NURBS is made of rational arcs of half angle a,
 *     (2 t - 1) tan(a / 2) = tan(phi / 2),
 * with t in 0..1 along the arc and phi the angle from its middle. */
class direction {
  public:
    bool angular = false;
    double shift = 0;           /* added to the file's parameter first */
    std::vector<double> breaks; /* distinct knots, rising */

    double span() const { return breaks.back() - breaks.front(); }

    /* Takes the knots. A whole turn that begins within an arc cuts the first and the last of them
     * short: their other ends are a whole arc away. */
    void set_breaks(const std::vector<double> &knots) {
        size_t last = knots.size() - 1;
        breaks = ends = knots;
        if (last < 3)
            return;
        ends[0] = knots[1] - (knots[2] - knots[1]);
        ends[last] = knots[last - 1] + (knots[last - 1] - knots[last - 2]);
    }

    /* Value and two derivatives at x, which lies in the arc of `inside`. */
    void map(double x, double inside, double out[3]) const {
        x += shift;
        out[0] = x;
        out[1] = 1;
        out[2] = 0;
        if (!angular)
            return;
        size_t k = arc(inside + shift);
        double half = (ends[k + 1] - ends[k]) / 2, middle = ends[k] + half;
        double scale = half / std::tan(half / 2), tangent = std::tan((x - middle) / 2);
        out[0] = middle + scale * tangent;
        out[1] = scale * (1 + tangent * tangent) / 2;
        out[2] = out[1] * tangent;
    }
    double at(double x) const {
        double out[3];
        map(x, x, out);
        return out[0];
    }

  private:
    std::vector<double> ends; /* of the arcs */

    size_t arc(double x) const {
        size_t k = 0;
        while (k + 2 < breaks.size() && x >= breaks[k + 1])
            k++;
        return k;
    }
};

/* The NURBS of a face, and the way from the file's parameters to its own. */
struct conversion {
    Handle(Geom_Surface) original;
    Handle(Geom_BSplineSurface) nurbs;
    direction way[2];
    double low[2], high[2]; /* the box of the face in the file's parameters */
    bool plain() const { return !way[0].angular && !way[1].angular; }
};

/* Kinds of surfaces, and which of their parameters are angles, of u and v: all, or where the curve
 * that they are made from is a circle or an ellipse. */
struct surface_kind {
    GeomAbs_SurfaceType type;
    const char *name;
    enum { NO, YES, BY_BASIS } angular[2];
};
const surface_kind &find_kind(GeomAbs_SurfaceType type) {
    using k = surface_kind;
    static const surface_kind kinds[] = {
        {GeomAbs_Plane, "plane", {k::NO, k::NO}},
        {GeomAbs_Cylinder, "cylinder", {k::YES, k::NO}},
        {GeomAbs_Cone, "cone", {k::YES, k::NO}},
        {GeomAbs_Sphere, "sphere", {k::YES, k::YES}},
        {GeomAbs_Torus, "torus", {k::YES, k::YES}},
        {GeomAbs_SurfaceOfRevolution, "revolution", {k::YES, k::BY_BASIS}},
        {GeomAbs_SurfaceOfExtrusion, "extrusion", {k::BY_BASIS, k::NO}},
        {GeomAbs_OffsetSurface, "offset", {k::NO, k::NO}},
        {GeomAbs_OtherSurface, "nurbs", {k::NO, k::NO}}};
    const surface_kind *kind = kinds;
    while (kind->type != type && kind->type != GeomAbs_OtherSurface)
        kind++;
    return *kind;
}

bool is_angle(const GeomAdaptor_Surface &surface, int k) {
    auto angular = find_kind(surface.GetType()).angular[k];
    if (angular != surface_kind::BY_BASIS)
        return angular == surface_kind::YES;
    GeomAbs_CurveType basis = surface.BasisCurve()->GetType();
    return basis == GeomAbs_Circle || basis == GeomAbs_Ellipse;
}

std::vector<double> distinct_knots(const Handle(Geom_BSplineSurface) & nurbs, int k) {
    std::vector<double> breaks;
    int first = k == 0 ? nurbs->FirstUKnotIndex() : nurbs->FirstVKnotIndex();
    int last = k == 0 ? nurbs->LastUKnotIndex() : nurbs->LastVKnotIndex();
    for (int i = first; i <= last; i++)
        breaks.push_back(k == 0 ? nurbs->UKnot(i) : nurbs->VKnot(i));
    return breaks;
}

/* The largest distance of the NURBS from the file's surface, over a grid, in shares of the size. */
double surface_deviation(const conversion &c) {
    double worst = 0, size = 0;
    gp_Pnt first = c.nurbs->Value(c.way[0].at(c.low[0]), c.way[1].at(c.low[1]));
    for (int i = 0; i <= 12; i++)
        for (int j = 0; j <= 12; j++) {
            double u = c.low[0] + (c.high[0] - c.low[0]) * i / 12;
            double v = c.low[1] + (c.high[1] - c.low[1]) * j / 12;
            gp_Pnt at = c.original->Value(u, v);
            gp_Pnt made = c.nurbs->Value(c.way[0].at(u), c.way[1].at(v));
            worst = std::max(worst, at.Distance(made));
            size = std::max(size, at.Distance(first));
        }
    return size > 0 ? worst / size : 1;
}

/* A spline surface cut down to the box, where that is smaller. */
Handle(Geom_BSplineSurface)
    cut_spline(const Handle(Geom_BSplineSurface) & whole, double low[2], double high[2]) {
    Handle(Geom_BSplineSurface) cut = Handle(Geom_BSplineSurface)::DownCast(whole->Copy());
    double bound[4], share[2];
    bool smaller = false;
    cut->Bounds(bound[0], bound[1], bound[2], bound[3]);
    for (int k = 0; k < 2; k++) {
        bool periodic = k == 0 ? cut->IsUPeriodic() : cut->IsVPeriodic();
        share[k] = ON_EDGE * (bound[2 * k + 1] - bound[2 * k]);
        if (std::fabs(low[k] - bound[2 * k]) < share[k])
            low[k] = bound[2 * k];
        if (std::fabs(high[k] - bound[2 * k + 1]) < share[k])
            high[k] = bound[2 * k + 1];
        bool inside = low[k] >= bound[2 * k] && high[k] <= bound[2 * k + 1];
        smaller = smaller || low[k] != bound[2 * k] || high[k] != bound[2 * k + 1];
        if (periodic && inside)
            k == 0 ? cut->SetUNotPeriodic() : cut->SetVNotPeriodic();
    }
    if (smaller)
        cut->Segment(low[0], high[0], low[1], high[1], share[0], share[1]);
    return cut;
}

/* The surface of a face and the box of its trims in the parameters, within the surface's own. */
void find_parameter_box(const TopoDS_Face &shape, conversion &c) {
    double bound[4];
    c.original = BRep_Tool::Surface(shape);
    if (c.original.IsNull())
        throw unreadable("has no surface");
    Handle(Geom_RectangularTrimmedSurface) trimmed =
        Handle(Geom_RectangularTrimmedSurface)::DownCast(c.original);
    if (!trimmed.IsNull())
        c.original = trimmed->BasisSurface();
    BRepTools::UVBounds(shape, c.low[0], c.high[0], c.low[1], c.high[1]);
    c.original->Bounds(bound[0], bound[1], bound[2], bound[3]);
    for (int k = 0; k < 2; k++) {
        bool periodic = k == 0 ? c.original->IsUPeriodic() : c.original->IsVPeriodic();
        /* A turn that begins next to nothing beside the seam is that from the seam on. */
        double share = ON_EDGE * (bound[2 * k + 1] - bound[2 * k]);
        if (periodic && std::fabs(c.low[k] - bound[2 * k]) < share)
            c.low[k] = bound[2 * k];
        if (periodic && std::fabs(c.high[k] - bound[2 * k + 1]) < share)
            c.high[k] = bound[2 * k + 1];
        if (!periodic) {
            c.low[k] = std::max(c.low[k], bound[2 * k]);
            c.high[k] = std::min(c.high[k], bound[2 * k + 1]);
        } else if (c.high[k] - c.low[k] > bound[2 * k + 1] - bound[2 * k]) {
            c.high[k] = c.low[k] + (bound[2 * k + 1] - bound[2 * k]);
        }
        if (!(c.high[k] - c.low[k] > 1e-12 * (1 + std::fabs(c.low[k]))) ||
            !(std::fabs(c.low[k]) < 1e12 && std::fabs(c.high[k]) < 1e12))
            throw unreadable("has no extent in its parameters");
    }
}

/* Whether the face is a whole turn of an angle that begins beside the surface's seam, at `from`. */
bool begins_elsewhere(const conversion &c, int k, double &from) {
    double bound[4];
    c.original->Bounds(bound[0], bound[1], bound[2], bound[3]);
    double turn = bound[2 * k + 1] - bound[2 * k];
    from = bound[2 * k];
    return c.way[k].angular && c.high[k] - c.low[k] > (1 - ON_EDGE) * turn && c.low[k] != from;
}

/* Moves the seam of a whole turn to where the face begins. */
void move_seam(conversion &c, int k) {
    direction &way = c.way[k];
    double low[2], high[2], turn = way.span();
    c.nurbs->Bounds(low[0], high[0], low[1], high[1]);
    way.shift = -turn * std::floor((c.low[k] - low[k]) / turn);
    low[k] = way.at(c.low[k]);
    high[k] = low[k] + turn;
    k == 0 ? c.nurbs->SetUPeriodic() : c.nurbs->SetVPeriodic();
    c.nurbs->Segment(low[0], high[0], low[1], high[1]);
    way.set_breaks(distinct_knots(c.nurbs, k));
}

/* The domain is the box of the face; a surface of more than IMPORT_DEGREE_MAX is approximated.
 * Whole turns are converted from the surface's seam on: Open CASCADE cuts their NURBS at the value
 * of the angle, which is another parameter. */
conversion convert(const TopoDS_Face &shape, std::vector<fault> &faults) {
    conversion c;
    find_parameter_box(shape, c);
    GeomAdaptor_Surface adaptor(c.original);
    double low[2], high[2];
    bool elsewhere[2];
    for (int k = 0; k < 2; k++) {
        c.way[k].angular = is_angle(adaptor, k);
        elsewhere[k] = begins_elsewhere(c, k, low[k]);
        low[k] = elsewhere[k] ? low[k] : c.low[k];
        high[k] = low[k] + (c.high[k] - c.low[k]);
    }
    Handle(Geom_BSplineSurface) spline = Handle(Geom_BSplineSurface)::DownCast(c.original);
    c.nurbs = !spline.IsNull()
                  ? cut_spline(spline, c.low, c.high)
                  : GeomConvert::SurfaceToBSplineSurface(new Geom_RectangularTrimmedSurface(
                        c.original, low[0], high[0], low[1], high[1]));
    double by;
    c.nurbs = limit_degree(c.nurbs, IMPORT_DEGREE_MAX, by);
    if (c.nurbs.IsNull())
        throw unreadable("has a degree above 9, and no approximation was found");
    if (by > 0)
        faults.push_back({"a degree above 9 was approximated", by});
    if (c.nurbs->IsUPeriodic())
        c.nurbs->SetUNotPeriodic();
    if (c.nurbs->IsVPeriodic())
        c.nurbs->SetVNotPeriodic();
    for (int k = 0; k < 2; k++) {
        c.way[k].set_breaks(distinct_knots(c.nurbs, k));
        c.way[k].shift = c.way[k].breaks.front() - c.low[k];
        if (std::fabs(c.way[k].shift) < 1e-9 * (c.high[k] - c.low[k]))
            c.way[k].shift = 0;
        if (elsewhere[k])
            move_seam(c, k);
    }
    return c;
}

/* ---- curves ---- */

/* A pcurve in the NURBS's parameters, from the beginning of its oriented edge to the end. */
struct carried {
    const conversion *parameters;
    Handle(Geom2d_Curve) curve;
    double first, last; /* of the curve's parameter, in the order of the edge */

    /* Place and two derivatives by t in 0..1, one-sided towards `inside`. */
    void at(double t, double inside, double out[2][3]) const {
        gp_Pnt2d p, q;
        gp_Vec2d d, dd;
        double scale = last - first, nudge = t + 1e-10 * (inside - t);
        curve->D2(first + nudge * scale, p, d, dd);
        curve->D0(first + t * scale, p);
        curve->D0(first + inside * scale, q);
        for (int k = 0; k < 2; k++) {
            double m[3], x1 = d.Coord(k + 1) * scale, x2 = dd.Coord(k + 1) * scale * scale;
            parameters->way[k].map(p.Coord(k + 1), q.Coord(k + 1), m);
            out[k][0] = m[0];
            out[k][1] = m[1] * x1;
            out[k][2] = m[2] * x1 * x1 + m[1] * x2;
        }
    }
    uv place(double t) const {
        gp_Pnt2d p = curve->Value(first + t * (last - first));
        return {parameters->way[0].at(p.X()), parameters->way[1].at(p.Y())};
    }
};

/* The quintic Bezier piece that has the curve's derivatives at both ends. */
void hermite(const carried &curve, double a, double b, uv out[6]) {
    double from[2][3], to[2][3], h = b - a, middle = (a + b) / 2;
    curve.at(a, middle, from);
    curve.at(b, middle, to);
    for (size_t k = 0; k < 2; k++) {
        out[0][k] = from[k][0];
        out[1][k] = from[k][0] + h / 5 * from[k][1];
        out[2][k] = from[k][0] + 2 * h / 5 * from[k][1] + h * h / 20 * from[k][2];
        out[3][k] = to[k][0] - 2 * h / 5 * to[k][1] + h * h / 20 * to[k][2];
        out[4][k] = to[k][0] - h / 5 * to[k][1];
        out[5][k] = to[k][0];
    }
}

bool is_fit(const carried &curve, double a, double b, const uv piece[6]) {
    for (double share : {0.25, 0.5, 0.75}) {
        uv d[6], at = curve.place(a + share * (b - a));
        std::copy(piece, piece + 6, d);
        for (int r = 1; r < 6; r++)
            for (int k = 0; k < 6 - r; k++)
                for (size_t x = 0; x < 2; x++)
                    d[k][x] += share * (d[k + 1][x] - d[k][x]);
        for (size_t x = 0; x < 2; x++)
            if (std::fabs(d[0][x] - at[x]) > FIT * curve.parameters->way[x].span())
                return false;
    }
    return true;
}

void fit_pieces(const carried &curve, double a, double b, int depth, trim_curve &out) {
    uv piece[FIT_DEGREE + 1];
    hermite(curve, a, b, piece);
    if (depth < HALVINGS && !is_fit(curve, a, b, piece)) {
        fit_pieces(curve, a, (a + b) / 2, depth + 1, out);
        fit_pieces(curve, (a + b) / 2, b, depth + 1, out);
        return;
    }
    if (out.points.empty()) {
        out.knots.assign(FIT_DEGREE + 1, a);
        out.points.push_back(piece[0]);
    }
    out.points.insert(out.points.end(), piece + 1, piece + FIT_DEGREE + 1);
    out.knots.insert(out.knots.end(), FIT_DEGREE, b);
}

/* Where the carried curve may have a corner in a derivative: its own knots, and the knots of
 * angular directions that it crosses. */
std::vector<double> find_breaks(const carried &curve) {
    std::vector<double> breaks = {0, 1};
    Geom2dAdaptor_Curve adaptor(curve.curve);
    double low = std::min(curve.first, curve.last), high = std::max(curve.first, curve.last);
    int intervals = adaptor.NbIntervals(GeomAbs_C2);
    TColStd_Array1OfReal own(1, intervals + 1);
    adaptor.Intervals(own, GeomAbs_C2);
    for (int k = 2; k <= intervals; k++)
        if (own(k) > low && own(k) < high)
            breaks.push_back((own(k) - curve.first) / (curve.last - curve.first));
    for (int k = 0; k < 2; k++) {
        const direction &way = curve.parameters->way[k];
        auto height = [&](double t, double knot) {
            return curve.curve->Value(curve.first + t * (curve.last - curve.first)).Coord(k + 1) +
                   way.shift - knot;
        };
        for (size_t i = 1; way.angular && i + 1 < way.breaks.size(); i++)
            for (int s = 0; s < SAMPLES; s++) {
                double a = double(s) / SAMPLES, b = double(s + 1) / SAMPLES;
                double knot = way.breaks[i], left = height(a, knot);
                if ((left > 0) == (height(b, knot) > 0))
                    continue;
                for (int step = 0; step < 50; step++) {
                    double middle = (a + b) / 2;
                    ((height(middle, knot) > 0) == (left > 0) ? a : b) = middle;
                }
                breaks.push_back((a + b) / 2);
            }
    }
    std::sort(breaks.begin(), breaks.end());
    std::vector<double> apart = {0};
    for (double t : breaks)
        if (t > apart.back() + 1e-9 && t < 1 - 1e-9)
            apart.push_back(t);
    apart.push_back(1);
    return apart;
}

bool is_level(const carried &curve, int k) {
    double from = curve.place(0)[size_t(k)];
    for (int s = 1; s <= SAMPLES; s++)
        if (std::fabs(curve.place(double(s) / SAMPLES)[size_t(k)] - from) >
            ON_EDGE * curve.parameters->way[k].span())
            return false;
    return true;
}

trim_curve straight(const uv &from, const uv &to) {
    return {1, {0, 0, 1, 1}, {from, to}, {}};
}

/* The NURBS form of the file's curve, moved by the directions' shifts. */
trim_curve exact_curve(const carried &curve, const Handle(Geom2d_BSplineCurve) & spline) {
    trim_curve out;
    out.degree = spline->Degree();
    for (int i = 1; i <= spline->NbKnots(); i++)
        out.knots.insert(out.knots.end(), size_t(spline->Multiplicity(i)), spline->Knot(i));
    for (int i = 1; i <= spline->NbPoles(); i++) {
        out.points.push_back({spline->Pole(i).X() + curve.parameters->way[0].shift,
                              spline->Pole(i).Y() + curve.parameters->way[1].shift});
        if (spline->IsRational())
            out.weights.push_back(spline->Weight(i));
    }
    return out;
}

trim_curve make_curve(const carried &curve) {
    if (is_level(curve, 0) || is_level(curve, 1))
        return straight(curve.place(0), curve.place(1));
    if (curve.parameters->plain()) {
        double low = std::min(curve.first, curve.last), high = std::max(curve.first, curve.last);
        Handle(Geom2d_Curve) piece = new Geom2d_TrimmedCurve(curve.curve, low, high);
        if (curve.last < curve.first)
            piece->Reverse();
        Handle(Geom2d_BSplineCurve) spline = Geom2dConvert::CurveToBSplineCurve(piece);
        if (!spline.IsNull() && spline->IsPeriodic())
            spline->SetNotPeriodic();
        if (!spline.IsNull() && spline->Degree() <= IMPORT_DEGREE_MAX)
            return exact_curve(curve, spline);
    }
    trim_curve out;
    out.degree = FIT_DEGREE;
    std::vector<double> breaks = find_breaks(curve);
    for (size_t k = 0; k + 1 < breaks.size(); k++)
        fit_pieces(curve, breaks[k], breaks[k + 1], 0, out);
    out.knots.push_back(breaks.back());
    return out;
}

/* ---- loops ---- */

double parameter_distance(const conversion &c, const uv &a, const uv &b) {
    double sum = 0;
    for (size_t k = 0; k < 2; k++) {
        double x = (a[k] - b[k]) / c.way[k].span();
        sum += x * x;
    }
    return std::sqrt(sum);
}

/* An edge of a wire, and the file's vertices at its ends. */
struct wire_edge {
    carried curve;
    TopoDS_Vertex first, last;
};

/* Whether an edge begins at the vertex where the one before it ends, and not beyond a seam. Where a
 * wire touches itself, the nearest edge may be another one than that which follows. */
bool follows_on(const conversion &c, const carried &before, const TopoDS_Vertex &vertex,
                const wire_edge &edge) {
    return !vertex.IsNull() && !edge.first.IsNull() && vertex.IsSame(edge.first) &&
           parameter_distance(c, before.place(1), edge.curve.place(0)) < NEAR;
}

/* The edges of a wire in the NURBS's parameters, in the order in which they follow each other. */
std::vector<carried> order_wire(const conversion &c, const TopoDS_Face &shape,
                                const TopoDS_Wire &wire) {
    std::vector<wire_edge> found;
    std::vector<carried> chain;
    TopoDS_Vertex last_vertex;
    Handle(ShapeExtend_WireData) data =
        new ShapeExtend_WireData(wire, Standard_True, Standard_False);
    for (int i = 1; i <= data->NbEdges(); i++) {
        TopoDS_Edge edge = data->Edge(i);
        double first = 0, last = 0;
        Handle(Geom2d_Curve) curve = BRep_Tool::CurveOnSurface(edge, shape, first, last);
        if (curve.IsNull())
            throw unreadable("has an edge without a curve in its parameters");
        if (!(last > first))
            continue;
        bool reversed = edge.Orientation() == TopAbs_REVERSED;
        found.push_back({{&c, curve, reversed ? last : first, reversed ? first : last},
                         TopExp::FirstVertex(edge, Standard_True),
                         TopExp::LastVertex(edge, Standard_True)});
    }
    while (!found.empty()) {
        size_t next = 0;
        if (!chain.empty() && !follows_on(c, chain.back(), last_vertex, found[0])) {
            double nearest = std::numeric_limits<double>::infinity();
            for (size_t k = 0; k < found.size() && nearest > 1e-6; k++) {
                double distance =
                    parameter_distance(c, found[k].curve.place(0), chain.back().place(1));
                if (distance < nearest) {
                    nearest = distance;
                    next = k;
                }
            }
        }
        chain.push_back(found[next].curve);
        last_vertex = found[next].last;
        found.erase(found.begin() + std::ptrdiff_t(next));
    }
    return chain;
}

/* Whether the curve runs along the border of the domain. */
bool is_on_border(const carried &curve) {
    for (int k = 0; k < 2; k++) {
        const direction &way = curve.parameters->way[k];
        double from = curve.place(0)[size_t(k)], share = ON_EDGE * way.span();
        if (is_level(curve, k) && (std::fabs(from - way.breaks.front()) < share ||
                                   std::fabs(from - way.breaks.back()) < share))
            return true;
    }
    return false;
}

bool lines_cross(const uv &a, const uv &b, const uv &c, const uv &d) {
    auto side = [](const uv &p, const uv &q, const uv &r) {
        return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
    };
    return side(a, b, c) * side(a, b, d) < 0 && side(c, d, a) * side(c, d, b) < 0;
}

/* Whether a loop crosses itself, by its curves at 1 / 16 each; of loops of many curves, by fewer.
 */
bool crosses_itself(const std::vector<carried> &chain) {
    size_t steps = chain.size() < 64 ? 16 : chain.size() < 512 ? 2 : 1;
    std::vector<uv> line;
    for (const carried &curve : chain)
        for (size_t s = 0; s < steps; s++)
            line.push_back(curve.place(double(s) / double(steps)));
    size_t n = line.size();
    if (n > 4096)
        return false;
    for (size_t i = 0; i < n; i++)
        for (size_t j = i + 2; j < n; j++)
            if ((j + 1) % n != i && lines_cross(line[i], line[i + 1], line[j], line[(j + 1) % n]))
                return true;
    return false;
}

void make_loops(const conversion &c, const TopoDS_Face &shape, double tolerance, face &out,
                std::vector<fault> &faults) {
    TopoDS_Face forward = TopoDS::Face(shape.Oriented(TopAbs_FORWARD));
    TopoDS_Wire outer = BRepTools::OuterWire(forward);
    bool bordered = true;
    int wires = 0;
    for (TopoDS_Iterator at(forward); at.More(); at.Next()) {
        if (at.Value().ShapeType() != TopAbs_WIRE)
            continue;
        wires++;
        TopoDS_Wire wire = TopoDS::Wire(at.Value());
        std::vector<carried> chain = order_wire(c, forward, wire);
        if (chain.empty())
            continue;
        trim_loop loop = {bool(wire.IsSame(outer)), {}};
        double gap = 0; /* in space, between the end of a curve and the beginning of the next */
        for (size_t k = 0; k < chain.size(); k++) {
            uv end = chain[k].place(1);
            uv next = chain[(k + 1) % chain.size()].place(0);
            bordered = bordered && is_on_border(chain[k]);
            loop.curves.push_back(make_curve(chain[k]));
            double apart = parameter_distance(c, end, next);
            if (apart > CLOSE)
                loop.curves.push_back(straight(end, next));
            if (apart > 1e-9)
                gap = std::max(
                    gap, c.nurbs->Value(end[0], end[1]).Distance(c.nurbs->Value(next[0], next[1])));
        }
        if (gap > tolerance)
            faults.push_back({"a trim is open and was closed by a straight line", gap, true});
        if (crosses_itself(chain))
            faults.push_back({"a trim crosses itself"});
        out.loops.push_back(loop);
    }
    if (wires == 0 || (wires == 1 && bordered))
        out.loops.clear();
}

/* ---- the face ---- */

void copy_surface(const Handle(Geom_BSplineSurface) & nurbs, face &out) {
    out.degree[0] = nurbs->UDegree();
    out.degree[1] = nurbs->VDegree();
    out.size[0] = nurbs->NbUPoles();
    out.size[1] = nurbs->NbVPoles();
    for (int i = 1; i <= nurbs->NbUKnots(); i++)
        out.knots[0].insert(out.knots[0].end(), size_t(nurbs->UMultiplicity(i)), nurbs->UKnot(i));
    for (int i = 1; i <= nurbs->NbVKnots(); i++)
        out.knots[1].insert(out.knots[1].end(), size_t(nurbs->VMultiplicity(i)), nurbs->VKnot(i));
    bool rational = nurbs->IsURational() || nurbs->IsVRational();
    for (int i = 1; i <= out.size[0]; i++)
        for (int j = 1; j <= out.size[1]; j++) {
            gp_Pnt p = nurbs->Pole(i, j);
            out.points.push_back({p.X(), p.Y(), p.Z()});
            if (rational)
                out.weights.push_back(nurbs->Weight(i, j));
        }
}

/* Exchanges u and v, which turns r_u x r_v round. */
void exchange_parameters(face &f) {
    face old = f;
    for (int k = 0; k < 2; k++) {
        f.degree[k] = old.degree[1 - k];
        f.size[k] = old.size[1 - k];
        f.knots[k] = old.knots[1 - k];
    }
    for (int i = 0; i < old.size[0]; i++)
        for (int j = 0; j < old.size[1]; j++) {
            size_t from = size_t(i * old.size[1] + j), to = size_t(j * old.size[0] + i);
            f.points[to] = old.points[from];
            if (!old.weights.empty())
                f.weights[to] = old.weights[from];
        }
    for (trim_loop &loop : f.loops)
        for (trim_curve &curve : loop.curves)
            for (uv &p : curve.points)
                std::swap(p[0], p[1]);
}

/* Where no closed form carries the parameters over, Open CASCADE's own conversion of the whole
 * face, whose trim curves are fitted to the face's tolerance. */
conversion convert_whole(const TopoDS_Face &shape, TopoDS_Face &made, std::vector<fault> &faults) {
    BRepBuilderAPI_NurbsConvert convert_nurbs(shape, Standard_True);
    made = TopoDS::Face(convert_nurbs.Shape());
    std::vector<fault> none;
    conversion c = convert(made, none);
    if (surface_deviation(c) > 1e-5)
        throw unreadable("has a surface without a NURBS form");
    faults.push_back({"the trims were fitted to the face's tolerance"});
    return c;
}

} // namespace

face face_make(const TopoDS_Face &shape, std::vector<fault> &faults) {
    face out = {};
    TopoDS_Face used = shape;
    conversion c = convert(shape, faults);
    GeomAbs_SurfaceType type = GeomAdaptor_Surface(c.original).GetType();
    out.kind = find_kind(type).name;
    double away = surface_deviation(c);
    if (away > EXACT && type == GeomAbs_OffsetSurface)
        faults.push_back({"an offset surface was approximated"});
    else if (away > EXACT && faults.empty())
        c = convert_whole(shape, used, faults);
    if (c.nurbs->NbUPoles() > IMPORT_SIZE_MAX || c.nurbs->NbVPoles() > IMPORT_SIZE_MAX)
        throw unreadable("has more than 512 control points in one direction");
    copy_surface(c.nurbs, out);
    make_loops(c, used, std::max(1e-6, 2 * BRep_Tool::Tolerance(shape)), out, faults);
    if (shape.Orientation() == TopAbs_REVERSED)
        exchange_parameters(out);
    return out;
}

} // namespace drape
