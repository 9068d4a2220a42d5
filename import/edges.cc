/* SPDX-License-Identifier: MIT */
#include "edges.h"

#include <BRep_Tool.hxx>
#include <Bnd_Box.hxx>
#include <Geom2d_Curve.hxx>
#include <Geom_Surface.hxx>
#include <NCollection_UBTreeFiller.hxx>
#include <TopExp.hxx>
#include <TopTools_IndexedDataMapOfShapeListOfShape.hxx>
#include <TopTools_ListOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace drape {
namespace {

enum { GAP_SAMPLES = 9, STEPS = 16, TOLD = 10 };
constexpr double WIDE = 10; /* tolerances, of files whose faces are not within one */
constexpr double LONGER =
    1e-3; /* by which edges joined so have to be, as a share of the diagonal */
/* Where a loose edge is judged: at no round share of it, where others may end. */
constexpr double judged[] = {0.0773, 0.2909, 0.4873, 0.7127, 0.9211};
constexpr size_t JUDGED = std::size(judged);

/* A curve on a surface, as a curve in space by t in 0..1. */
struct seam {
    Handle(Geom2d_Curve) curve;
    Handle(Geom_Surface) surface;
    double first = 0, last = 0;

    seam(const TopoDS_Edge &edge, const TopoDS_Face &face) {
        curve = BRep_Tool::CurveOnSurface(edge, face, first, last);
        surface = BRep_Tool::Surface(face);
    }
    bool missing() const { return curve.IsNull() || surface.IsNull(); }
    gp_Pnt at(double t, gp_Vec *tangent = nullptr) const {
        gp_Pnt2d uv;
        gp_Vec2d rate;
        gp_Pnt p;
        gp_Vec u, v;
        curve->D1(first + (last - first) * t, uv, rate);
        if (!tangent)
            return surface->Value(uv.X(), uv.Y());
        surface->D1(uv.X(), uv.Y(), p, u, v);
        *tangent = (u * rate.X() + v * rate.Y()) * (last - first);
        return p;
    }
    /* The distance to a place, wherever near `t` it is smallest: Newton's method without the
     * curvature, which tells nothing over distances as short as those sought. */
    double distance(const gp_Pnt &point, double t) const {
        double least = HUGE_VAL;
        for (int step = 0; step < 20; step++) {
            gp_Vec tangent;
            gp_Vec to(at(t, &tangent), point);
            double square = tangent.SquareMagnitude(), away = to.Magnitude();
            if (!(away < least) || !(square > 0))
                break;
            least = away;
            t = std::clamp(t + to.Dot(tangent) / square, 0.0, 1.0);
        }
        return least;
    }
};

/* The largest distance between the surfaces along an edge that two faces share, or `gap` if that is
 * larger. */
double widen_gap(double gap, const TopoDS_Edge &edge, const TopTools_ListOfShape &faces) {
    const seam sides[2] = {{edge, TopoDS::Face(faces.First())}, {edge, TopoDS::Face(faces.Last())}};
    if (sides[0].missing() || sides[1].missing())
        return gap;
    for (int s = 0; s <= GAP_SAMPLES; s++) {
        double t = double(s) / GAP_SAMPLES;
        gp_Pnt point = sides[0].at(t);
        if (point.Distance(sides[1].at(t)) > gap)
            gap = std::max(gap, sides[1].distance(point, t));
    }
    return gap;
}

/* ---- faces that the file leaves apart ---- */

/* An edge of one face. */
struct loose_edge {
    int number; /* the face's */
    seam line;
    gp_Pnt points[STEPS + 1];
    double length = 0, bend = 0; /* how far it may leave the chords between its points */
    Bnd_Box box;
    std::map<size_t, double> near[JUDGED]; /* other edges and how far they are, at `judged` */

    loose_edge(int face, const seam &curve) : number(face), line(curve) {
        for (int k = 0; k <= STEPS; k++) {
            points[k] = line.at(double(k) / STEPS);
            box.Add(points[k]);
            length += k ? points[k].Distance(points[k - 1]) : 0;
        }
        for (int k = 1; k < STEPS; k++) {
            gp_XYZ middle = (points[k - 1].XYZ() + points[k + 1].XYZ()) / 2;
            bend = std::max(bend, points[k].Distance(gp_Pnt(middle)));
        }
    }
    double distance(const gp_Pnt &point) const {
        int nearest = 0;
        for (int k = 1; k <= STEPS; k++)
            if (point.SquareDistance(points[k]) < point.SquareDistance(points[nearest]))
                nearest = k;
        return line.distance(point, double(nearest) / STEPS);
    }
    /* The nearest at a place within the tolerance, HUGE_VAL without. */
    double nearest(size_t place, double tolerance) const {
        double least = HUGE_VAL;
        for (const auto &[edge, away] : near[place])
            least = std::min(least, away <= tolerance ? away : HUGE_VAL);
        return least;
    }
};

typedef NCollection_UBTree<size_t, Bnd_Box> box_tree;

/* The edges whose boxes hold a place. */
struct holders : box_tree::Selector {
    Bnd_Box place;
    std::vector<size_t> edges;

    Standard_Boolean Reject(const Bnd_Box &box) const override { return box.IsOut(place); }
    Standard_Boolean Accept(const size_t &edge) override {
        edges.push_back(edge);
        return true;
    }
};

/* Finds what lies within `reach` of each edge. Edges as short as that join nothing. */
void find_near(std::vector<loose_edge> &edges, double reach) {
    box_tree tree;
    NCollection_UBTreeFiller<size_t, Bnd_Box> filler(tree);
    for (size_t k = 0; k < edges.size(); k++) {
        Bnd_Box box = edges[k].box;
        box.Enlarge(reach + edges[k].bend);
        if (edges[k].length > reach)
            filler.Add(k, box);
    }
    filler.Fill();
    for (size_t k = 0; k < edges.size(); k++)
        for (size_t s = 0; s < JUDGED && edges[k].length > reach; s++) {
            gp_Pnt point = edges[k].line.at(judged[s]);
            holders found;
            found.place.Add(point);
            tree.Select(found);
            for (size_t other : found.edges) {
                double away = other == k ? HUGE_VAL : edges[other].distance(point);
                if (away <= reach)
                    edges[k].near[s][other] = away;
            }
        }
}

/* The length of the edges, on both sides, that others lie beside within the tolerance. */
double joined_length(const std::vector<loose_edge> &edges, double tolerance) {
    double length = 0;
    for (const loose_edge &edge : edges)
        for (size_t s = 0; s < JUDGED; s++)
            length += edge.nearest(s, tolerance) < HUGE_VAL ? edge.length / JUDGED : 0;
    return length;
}

/* The faces that meet at an edge where more than two do: at two places of it, for at one of them
 * another edge may end. Empty elsewhere; `first` gets the first of their edges. */
std::set<int> crowd(const std::vector<loose_edge> &edges, size_t number, double tolerance,
                    size_t &first) {
    std::set<int> faces;
    int places = 0;
    first = number;
    for (size_t s = 0; s < JUDGED; s++) {
        std::set<int> here = {edges[number].number};
        size_t lowest = number;
        for (const auto &[other, away] : edges[number].near[s])
            if (away <= tolerance) {
                here.insert(edges[other].number);
                lowest = std::min(lowest, other);
            }
        if (here.size() < 3)
            continue;
        places++;
        faces.insert(here.begin(), here.end());
        first = std::min(first, lowest);
    }
    return places > 1 ? faces : std::set<int>();
}

/* ---- counting ---- */

class counting {
  public:
    edge_counts counts;

    counting(const std::vector<found_face> &all, std::vector<std::string> &told)
        : faces(all), notes(told) {}
    void count_shared(const std::vector<int> &numbers);
    void count_loose(double diagonal);

  private:
    const std::vector<found_face> &faces;
    std::vector<std::string> &notes;
    std::vector<loose_edge> loose;

    void blame(const std::vector<int> &crowded) {
        std::string list;
        for (int number : crowded)
            list += (list.empty() ? "" : ", ") + face_title(number, faces[size_t(number)].name);
        if (++counts.faulty <= TOLD)
            notes.push_back(count_text(crowded.size(), "face") + " meet at one edge: " + list);
    }
};

/* What the file says; the edges of one face are left for `count_loose`. */
void counting::count_shared(const std::vector<int> &numbers) {
    TopTools_IndexedDataMapOfShapeListOfShape by_edge;
    std::map<const TopoDS_TShape *, int> number_of;
    for (int number : numbers) {
        TopExp::MapShapesAndAncestors(faces[size_t(number)].shape, TopAbs_EDGE, TopAbs_FACE,
                                      by_edge);
        number_of[faces[size_t(number)].shape.TShape().get()] = number;
    }
    for (int i = 1; i <= by_edge.Extent(); i++) {
        const TopoDS_Edge &edge = TopoDS::Edge(by_edge.FindKey(i));
        const TopTools_ListOfShape &of = by_edge(i);
        if (BRep_Tool::Degenerated(edge))
            continue;
        if (of.Extent() == 2)
            counts.largest_gap = widen_gap(counts.largest_gap, edge, of);
        if (of.Extent() == 1 && !BRep_Tool::IsClosed(edge, TopoDS::Face(of.First()))) {
            int number = number_of[of.First().TShape().get()];
            seam line(edge, TopoDS::Face(of.First()));
            if (faces[size_t(number)].solid || line.missing())
                counts.free++;
            else
                loose.push_back({number, line});
        } else if (of.Extent() <= 2) {
            counts.shared++;
        } else {
            std::vector<int> crowded;
            for (const TopoDS_Shape &face : of)
                crowded.push_back(number_of[face.TShape().get()]);
            blame(crowded);
        }
    }
}

/* Files of some systems leave gaps or overlaps wider than what is one place elsewhere: edges are
 * joined over these when that joins longer ones. */
void counting::count_loose(double diagonal) {
    double close = std::max(1e-7, EDGES_TOLERANCE * diagonal), wide = WIDE * close;
    find_near(loose, wide);
    bool gaps = joined_length(loose, wide) > joined_length(loose, close) + 2 * LONGER * diagonal;
    double tolerance = gaps ? wide : close, gap = 0;
    std::set<std::pair<size_t, size_t>> pairs;
    for (size_t k = 0; k < loose.size(); k++) {
        size_t first, joined = 0;
        std::set<int> crowded = crowd(loose, k, close, first);
        if (!crowded.empty() && first == k)
            blame({crowded.begin(), crowded.end()});
        for (size_t s = 0; s < JUDGED && crowded.empty(); s++)
            for (const auto &[other, away] : loose[k].near[s])
                if (away == loose[k].nearest(s, tolerance)) {
                    pairs.insert({std::min(k, other), std::max(k, other)});
                    gap = std::max(gap, away);
                    joined++;
                    break;
                }
        counts.free += crowded.empty() && joined < JUDGED;
    }
    counts.shared += int(pairs.size());
    counts.largest_gap = std::max(counts.largest_gap, gap);
    if (!pairs.empty())
        notes.push_back("joined: " + count_text(pairs.size(), "edge") +
                        " of faces that the file does not join" +
                        (gaps ? ", over gaps or overlaps of more than the usual tolerance" : ""));
}

} // namespace

std::string face_title(int number, const std::string &name) {
    return "face " + std::to_string(number) + (name.empty() ? "" : " (\"" + name + "\")");
}

std::string count_text(size_t count, const char *noun) {
    return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

edge_counts edges_count(const std::vector<found_face> &faces, const std::vector<int> &numbers,
                        double diagonal, std::vector<std::string> &notes) {
    counting all(faces, notes);
    all.count_shared(numbers);
    all.count_loose(diagonal);
    return all.counts;
}

} // namespace drape
