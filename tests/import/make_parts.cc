/* SPDX-License-Identifier: MIT */
/*
 * Writes the CAD files that the importer is tested with: make_parts FOLDER. Each is made by Open
 * CASCADE itself, so that the area of each face is known by another way; that of the whole is
 * printed, a line each: NAME FACES AREA, in the file's unit.
 */
#include <BRepAdaptor_Curve.hxx>
#include <BRepAlgoAPI_Common.hxx>
#include <BRepAlgoAPI_Cut.hxx>
#include <BRepAlgoAPI_Fuse.hxx>
#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakePolygon.hxx>
#include <BRepBuilderAPI_MakeWire.hxx>
#include <BRepBuilderAPI_Transform.hxx>
#include <BRepFilletAPI_MakeFillet.hxx>
#include <BRepGProp.hxx>
#include <BRepOffsetAPI_ThruSections.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakeCone.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <BRepPrimAPI_MakePrism.hxx>
#include <BRepPrimAPI_MakeRevol.hxx>
#include <BRepPrimAPI_MakeSphere.hxx>
#include <BRepPrimAPI_MakeTorus.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <Bnd_Box.hxx>
#include <GC_MakeArcOfCircle.hxx>
#include <GProp_GProps.hxx>
#include <GeomAPI_PointsToBSpline.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Geom_ConicalSurface.hxx>
#include <Geom_CylindricalSurface.hxx>
#include <Geom_Line.hxx>
#include <Geom_SphericalSurface.hxx>
#include <Geom_ToroidalSurface.hxx>
#include <IGESControl_Writer.hxx>
#include <Interface_Static.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Quantity_Color.hxx>
#include <STEPCAFControl_Writer.hxx>
#include <STEPControl_Writer.hxx>
#include <ShapeUpgrade_UnifySameDomain.hxx>
#include <TColStd_Array1OfInteger.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TColStd_Array2OfReal.hxx>
#include <TColgp_Array1OfPnt.hxx>
#include <TColgp_Array2OfPnt.hxx>
#include <TDataStd_Name.hxx>
#include <TDocStd_Document.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Face.hxx>
#include <XCAFDoc_ColorTool.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

static std::string folder;

static void print_size(const std::string &name, const TopoDS_Shape &shape) {
    GProp_GProps properties;
    BRepGProp::SurfaceProperties(shape, properties, 1e-9);
    int faces = 0;
    for (TopExp_Explorer at(shape, TopAbs_FACE); at.More(); at.Next())
        faces++;
    std::printf("%s %d %.17g\n", name.c_str(), faces, properties.Mass());
}

static void write_step(const std::string &name, const TopoDS_Shape &shape, const char *unit = "MM",
                       const char *schema = "AP214IS") {
    Interface_Static::SetCVal("write.step.schema", schema);
    Interface_Static::SetCVal("write.step.unit", unit);
    STEPControl_Writer writer;
    writer.Transfer(shape, STEPControl_AsIs);
    writer.Write((folder + "/" + name + ".step").c_str());
    print_size(name, shape);
}

static void write_iges(const std::string &name, const TopoDS_Shape &shape, const char *unit) {
    IGESControl_Writer writer(unit, 1);
    writer.AddShape(shape);
    writer.ComputeModel();
    writer.Write((folder + "/" + name + ".igs").c_str());
    print_size(name, shape);
}

static TopoDS_Shape round_edges(const TopoDS_Shape &shape, double radius) {
    BRepFilletAPI_MakeFillet fillet(shape);
    TopTools_IndexedMapOfShape edges;
    TopExp::MapShapes(shape, TopAbs_EDGE, edges);
    for (int i = 1; i <= edges.Extent(); i++)
        fillet.Add(radius, TopoDS::Edge(edges(i)));
    return fillet.Shape();
}

static TopoDS_Shape moved(const TopoDS_Shape &shape, double x, double y, double z, double turn) {
    gp_Trsf shift, rotation;
    shift.SetTranslation(gp_Vec(x, y, z));
    rotation.SetRotation(gp_Ax1(gp_Pnt(0, 0, 0), gp_Dir(1, 2, 3)), turn);
    return BRepBuilderAPI_Transform(shape, shift * rotation, true).Shape();
}

/* A hemisphere on a flange, with a fillet where they meet. */
static TopoDS_Shape make_dome() {
    TopoDS_Shape flange = BRepPrimAPI_MakeBox(gp_Pnt(-100, -100, -20), gp_Pnt(100, 100, 0)).Shape();
    TopoDS_Shape dome = BRepAlgoAPI_Fuse(flange, BRepPrimAPI_MakeSphere(60).Shape()).Shape();
    BRepFilletAPI_MakeFillet fillet(dome);
    TopTools_IndexedMapOfShape edges;
    TopExp::MapShapes(dome, TopAbs_EDGE, edges);
    for (int i = 1; i <= edges.Extent(); i++) {
        TopoDS_Edge edge = TopoDS::Edge(edges(i));
        if (BRep_Tool::Degenerated(edge))
            continue;
        gp_Pnt from = BRep_Tool::Pnt(TopExp::FirstVertex(edge));
        gp_Pnt to = BRep_Tool::Pnt(TopExp::LastVertex(edge));
        if (std::fabs(from.Z()) < 1e-6 && std::fabs(to.Z()) < 1e-6 &&
            std::hypot(from.X(), from.Y()) < 61 && std::hypot(to.X(), to.Y()) < 61)
            fillet.Add(10, edge);
    }
    return fillet.Shape();
}

/* The upper half of a sphere that runs into a tube: booleans leave the turn of both faces a
 * rounding beside the seam. */
static TopoDS_Shape make_neck() {
    TopoDS_Shape whole = BRepAlgoAPI_Fuse(BRepPrimAPI_MakeSphere(40).Shape(),
                                          BRepPrimAPI_MakeCylinder(20, 80).Shape())
                             .Shape();
    TopoDS_Shape below = BRepPrimAPI_MakeBox(gp_Pnt(-100, -100, -100), gp_Pnt(100, 100, 0)).Shape();
    return BRepAlgoAPI_Cut(whole, below).Shape();
}

/* A cone whose top is rounded: cloth that goes down on both sides of it meets behind. */
static TopoDS_Shape make_cup() {
    BRepPrimAPI_MakeCone cone(40, 15, 60);
    BRepFilletAPI_MakeFillet fillet(cone.Shape());
    TopTools_IndexedMapOfShape edges;
    TopExp::MapShapes(cone.Shape(), TopAbs_EDGE, edges);
    for (int i = 1; i <= edges.Extent(); i++) {
        TopoDS_Edge edge = TopoDS::Edge(edges(i));
        if (BRep_Tool::Pnt(TopExp::FirstVertex(edge)).Z() > 59 &&
            BRep_Tool::Pnt(TopExp::LastVertex(edge)).Z() > 59)
            fillet.Add(5, edge);
    }
    return fillet.Shape();
}

/* A surface of degree 2 by 14 in spans of very uneven length with a kink between the last two, as
 * fillets of three edges are filled with, rational, and a strip along its border u = 1. */
static TopoDS_Shape make_high() {
    enum { DEGREE = 14, SPANS = 4, POLES = SPANS * DEGREE + 1 };
    const double knots[SPANS + 1] = {500.414, 500.7, 506.2, 511.715, 512};
    TopoDS_Compound all;
    BRep_Builder builder;
    TColgp_Array2OfPnt poles(1, 3, 1, POLES), strip(1, 2, 1, POLES);
    TColStd_Array2OfReal weights(1, 3, 1, POLES), same(1, 2, 1, POLES);
    TColStd_Array1OfReal u(1, 2), v(1, SPANS + 1);
    TColStd_Array1OfInteger often(1, 2), twice(1, 2), interior(1, SPANS + 1);
    for (int j = 1; j <= POLES; j++) {
        int span = std::min((j - 1) / DEGREE, SPANS - 1);
        double along = (j - 1 - span * DEGREE) / double(DEGREE);
        double t = knots[span] + along * (knots[span + 1] - knots[span]);
        double kink = std::max(t - knots[SPANS - 1], 0.0);
        for (int i = 1; i <= 3; i++) {
            double wave =
                span < SPANS - 1 ? std::sin(3 * (t - knots[SPANS - 1]) / (1 + 0.1 * i)) : 0;
            poles(i, j) = gp_Pnt(4 * i, t - 500, 0.5 * wave + 2 * kink + 0.3 * i * i);
            weights(i, j) = i == 2 ? 0.75 + 0.1 * std::cos(t) : 1;
        }
        for (int i = 1; i <= 2; i++) {
            strip(i, j) = poles(3, j).Translated(gp_Vec(5 * (i - 1), 0, 2 * (i - 1)));
            same(i, j) = weights(3, j);
        }
    }
    for (int k = 0; k <= SPANS; k++) {
        v(k + 1) = knots[k];
        interior(k + 1) = k == 0 || k == SPANS ? DEGREE + 1 : DEGREE;
    }
    for (int k = 1; k <= 2; k++) {
        u(k) = 11.6 * (k - 1);
        often(k) = 3;
        twice(k) = 2;
    }
    auto add = [&](const Handle(Geom_Surface) & surface) {
        builder.Add(all, BRepBuilderAPI_MakeFace(surface, 1e-7).Face());
    };
    builder.MakeCompound(all);
    add(new Geom_BSplineSurface(poles, weights, u, v, often, interior, 2, DEGREE));
    add(new Geom_BSplineSurface(strip, same, u, v, twice, interior, 1, DEGREE));
    return all;
}

/* Full turns that begin anywhere but on the seam of their surface, as other systems write them. */
static TopoDS_Shape make_turned() {
    TopoDS_Compound all;
    BRep_Builder builder;
    builder.MakeCompound(all);
    gp_Ax3 at(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1));
    auto add = [&](const gp_Vec &away, const Handle(Geom_Surface) & surface, double u, double to_u,
                   double v, double to_v) {
        surface->Translate(away);
        builder.Add(all, BRepBuilderAPI_MakeFace(surface, u, to_u, v, to_v, 1e-7).Face());
    };
    add(gp_Vec(0, 0, 0), new Geom_CylindricalSurface(at, 10), M_PI, 3 * M_PI, -5, 12);
    add(gp_Vec(50, 0, 0), new Geom_ConicalSurface(at, 0.3, 10), 1, 1 + 2 * M_PI, -5, 12);
    add(gp_Vec(0, 50, 0), new Geom_SphericalSurface(at, 10), 2.5, 2.5 + 2 * M_PI, -1, 0.7);
    add(gp_Vec(50, 50, 0), new Geom_ToroidalSurface(at, 15, 4), 0.1, 0.1 + 2 * M_PI, 3.2, 4.7);
    add(gp_Vec(100, 50, 0), new Geom_ToroidalSurface(at, 15, 4), 0.1, 2, 3.2, 3.2 + 2 * M_PI);
    return all;
}

/* A hat of changing height and width along a bent pillar, all edges along it rounded. */
static TopoDS_Shape make_pillar() {
    BRepOffsetAPI_ThruSections loft(true, false, 1e-6);
    const double widths[] = {90, 60, 55, 75}, heights[] = {60, 45, 40, 50};
    for (int s = 0; s < 4; s++) {
        double half = widths[s] / 2, flange = half + 45, slope = 10;
        const double profile[8][2] = {{-flange, 0},
                                      {-half, 0},
                                      {-half + slope, heights[s]},
                                      {half - slope, heights[s]},
                                      {half, 0},
                                      {flange, 0},
                                      {flange, -15},
                                      {-flange, -15}};
        BRepBuilderAPI_MakePolygon section;
        for (const double(&p)[2] : profile)
            section.Add(gp_Pnt(250 * s, p[0], p[1] + 8 * s * s));
        section.Close();
        loft.AddWire(section.Wire());
    }
    BRepFilletAPI_MakeFillet fillet(loft.Shape());
    TopTools_IndexedMapOfShape edges;
    TopExp::MapShapes(loft.Shape(), TopAbs_EDGE, edges);
    for (int i = 1; i <= edges.Extent(); i++) {
        gp_Pnt from = BRep_Tool::Pnt(TopExp::FirstVertex(TopoDS::Edge(edges(i))));
        gp_Pnt to = BRep_Tool::Pnt(TopExp::LastVertex(TopoDS::Edge(edges(i))));
        if (std::fabs(from.X() - to.X()) > 700 && std::fabs(from.Y()) < 60)
            fillet.Add(6, TopoDS::Edge(edges(i)));
    }
    return fillet.Shape();
}

/* A rectangle with round corners, from its middle. */
static TopoDS_Wire round_rectangle(double length, double width, double radius, double z) {
    BRepBuilderAPI_MakeWire wire;
    gp_Pnt first, last;
    for (int k = 0; k <= 4; k++) {
        double turn = k * M_PI / 2, x = length / 2 - radius, y = width / 2 - radius;
        gp_Pnt middle(k % 4 == 1 || k % 4 == 2 ? -x : x, k % 4 >= 2 ? -y : y, z);
        gp_Pnt from = middle.Translated(gp_Vec(std::cos(turn), std::sin(turn), 0) * radius);
        if (k > 0)
            wire.Add(BRepBuilderAPI_MakeEdge(last, k == 4 ? first : from));
        if (k == 4)
            break;
        BRepBuilderAPI_MakeEdge corner(gp_Circ(gp_Ax2(middle, gp::DZ(), gp::DX()), radius), turn,
                                       turn + M_PI / 2);
        first = k == 0 ? from : first;
        last = middle.Translated(gp_Vec(-std::sin(turn), std::cos(turn), 0) * radius);
        wire.Add(corner);
    }
    return wire;
}

/* Rounds the edges that lie within a box. */
static TopoDS_Shape round_within(const Bnd_Box &box, const TopoDS_Shape &shape, double radius) {
    BRepFilletAPI_MakeFillet fillet(shape);
    TopTools_IndexedMapOfShape edges;
    TopExp::MapShapes(shape, TopAbs_EDGE, edges);
    for (int i = 1; i <= edges.Extent(); i++) {
        bool inside = true;
        BRepAdaptor_Curve curve(TopoDS::Edge(edges(i)));
        for (int s = 0; s <= 8; s++) {
            gp_Pnt at = curve.Value(curve.FirstParameter() +
                                    (curve.LastParameter() - curve.FirstParameter()) * s / 8);
            inside = inside && !box.IsOut(at);
        }
        if (inside)
            fillet.Add(radius, TopoDS::Edge(edges(i)));
    }
    return fillet.Shape();
}

/* A crowned cover with sloping walls on a flange, its shoulder and its foot rounded. */
static TopoDS_Shape make_cover() {
    BRepOffsetAPI_ThruSections walls(true, true, 1e-6);
    walls.AddWire(round_rectangle(300, 200, 70, 0));
    walls.AddWire(round_rectangle(230, 130, 49, 45));
    gp_Ax2 round_y(gp_Pnt(0, 0, -607), gp::DY(), -gp::DZ());
    TopoDS_Shape crown = BRepPrimAPI_MakeSphere(round_y, 650).Shape();
    TopoDS_Shape body = BRepAlgoAPI_Common(walls.Shape(), crown).Shape();
    TopoDS_Face flange = BRepBuilderAPI_MakeFace(round_rectangle(380, 280, 50, 0));
    TopoDS_Shape plate = BRepPrimAPI_MakePrism(flange, gp_Vec(0, 0, -4)).Shape();
    ShapeUpgrade_UnifySameDomain whole(BRepAlgoAPI_Fuse(plate, body).Shape());
    whole.Build();
    const Bnd_Box shoulder(gp_Pnt(-190, -140, 18), gp_Pnt(190, 140, 50));
    const Bnd_Box foot(gp_Pnt(-151, -101, -1), gp_Pnt(151, 101, 1));
    return round_within(foot, round_within(shoulder, whole.Shape(), 12), 8);
}

/* A line through points of the xz-plane, its corners rounded by `radius`. */
static TopoDS_Wire rounded_line(const std::vector<gp_Pnt> &points, double radius) {
    BRepBuilderAPI_MakeWire wire;
    gp_Pnt from = points.front();
    for (size_t k = 1; k + 1 < points.size(); k++) {
        gp_Dir in(gp_Vec(points[k - 1], points[k])), out(gp_Vec(points[k], points[k + 1]));
        double cut = radius * std::tan(in.Angle(out) / 2);
        gp_Pnt begin = points[k].Translated(gp_Vec(in) * -cut);
        gp_Pnt end = points[k].Translated(gp_Vec(out) * cut);
        wire.Add(BRepBuilderAPI_MakeEdge(from, begin));
        wire.Add(BRepBuilderAPI_MakeEdge(GC_MakeArcOfCircle(begin, gp_Vec(in), end).Value()));
        from = end;
    }
    wire.Add(BRepBuilderAPI_MakeEdge(from, points.back()));
    return wire;
}

/* The profile of a hat, pulled along: planes and fillets in turn. */
static TopoDS_Shape make_hat() {
    const std::vector<gp_Pnt> profile = {gp_Pnt(-80, 0, 0), gp_Pnt(-45, 0, 0), gp_Pnt(-30, 0, 40),
                                         gp_Pnt(30, 0, 40), gp_Pnt(45, 0, 0),  gp_Pnt(80, 0, 0)};
    return BRepPrimAPI_MakePrism(rounded_line(profile, 6), gp_Vec(0, 250, 0)).Shape();
}

/* A hemisphere, its flange and the fillet between them. */
static TopoDS_Shape make_bowl() {
    constexpr double RADIUS = 50, FILLET = 10, REACH = 90;
    double turn = std::asin(FILLET / (RADIUS + FILLET)); /* of where the fillet begins */
    double foot = (RADIUS + FILLET) * std::cos(turn);    /* where it ends */
    gp_Pnt side(RADIUS * std::cos(turn), 0, RADIUS * std::sin(turn)), end(foot, 0, 0);
    gp_Vec down(std::sin(turn), 0, -std::cos(turn));
    BRepBuilderAPI_MakeWire wire(
        BRepBuilderAPI_MakeEdge(GC_MakeArcOfCircle(gp_Pnt(0, 0, RADIUS), gp::DX(), side).Value()));
    wire.Add(BRepBuilderAPI_MakeEdge(GC_MakeArcOfCircle(side, down, end).Value()));
    wire.Add(BRepBuilderAPI_MakeEdge(end, gp_Pnt(REACH, 0, 0)));
    return BRepPrimAPI_MakeRevol(wire.Wire(), gp::OZ()).Shape();
}

/* Sections of a wing as one smooth curve each; the loft is cut along the span and the nose. */
static TopoDS_Shape make_wing() {
    BRepOffsetAPI_ThruSections loft(false, false, 1e-6);
    for (int s = 0; s < 4; s++) {
        double chord = 300 - 40 * s, sweep = 30 * s * s;
        TColgp_Array1OfPnt points(1, 21);
        for (int i = 0; i <= 20; i++) {
            double x = i / 20.0, bow = 0.3 * x * (1 - x) * (1.5 - x);
            points(i + 1) = gp_Pnt(sweep + chord * x, 400 * s, chord * bow + 5 * s * s);
        }
        Handle(Geom_BSplineCurve) curve = GeomAPI_PointsToBSpline(points, 3, 8, GeomAbs_C2, 1e-4);
        loft.AddWire(BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(curve)));
    }
    loft.Build();
    TopoDS_Compound patches;
    BRep_Builder builder;
    builder.MakeCompound(patches);
    for (int i = 0; i < 3; i++)
        builder.Add(patches, BRepAlgoAPI_Common(loft.Shape(),
                                                moved(BRepPrimAPI_MakeBox(3000, 400, 900).Shape(),
                                                      -900, 400 * i, -450, 0.02))
                                 .Shape());
    return patches;
}

/* Cut by slanted planes and cylinders: trims that are no lines in the parameters of any surface. */
static TopoDS_Shape make_cuts() {
    TopoDS_Shape all = BRepPrimAPI_MakeCylinder(30, 120).Shape();
    all = BRepAlgoAPI_Fuse(
              all,
              BRepPrimAPI_MakeCone(gp_Ax2(gp_Pnt(100, 0, 0), gp_Dir(0, 0, 1)), 40, 10, 90).Shape())
              .Shape();
    all = BRepAlgoAPI_Fuse(all, moved(BRepPrimAPI_MakeTorus(40, 12).Shape(), 50, 60, 40, 0.3))
              .Shape();
    TopoDS_Shape cut = moved(BRepPrimAPI_MakeBox(400, 400, 100).Shape(), -150, -150, 85, 0.25);
    all = BRepAlgoAPI_Cut(all, cut).Shape();
    return BRepAlgoAPI_Cut(all, BRepPrimAPI_MakeCylinder(
                                    gp_Ax2(gp_Pnt(-50, 5, 50), gp_Dir(1, 0.1, 0.2)), 8, 250)
                                    .Shape())
        .Shape();
}

/* A hat with corrugations, `count` blocks with rounded edges on a plate: many faces. */
static TopoDS_Shape make_many(int count) {
    TopoDS_Shape all =
        BRepPrimAPI_MakeBox(gp_Pnt(-5, -5, -3), gp_Pnt(10.0 * count + 5, 25, 0)).Shape();
    TopoDS_Compound blocks;
    BRep_Builder builder;
    builder.MakeCompound(blocks);
    builder.Add(blocks, all);
    TopoDS_Shape block = round_edges(BRepPrimAPI_MakeBox(8, 20, 6).Shape(), 1.5);
    for (int i = 0; i < count; i++)
        builder.Add(blocks, moved(block, 10.0 * i, 0, 0, 0.1));
    return blocks;
}

static TopoDS_Face square(const gp_Pnt &a, const gp_Pnt &b, const gp_Pnt &c, const gp_Pnt &d) {
    return BRepBuilderAPI_MakeFace(BRepBuilderAPI_MakePolygon(a, b, c, d, true).Wire());
}

/* Faces that share no edge. */
static TopoDS_Shape make_loose(bool fin) {
    TopoDS_Compound all;
    BRep_Builder builder;
    builder.MakeCompound(all);
    for (int i = 0; i < 3; i++) {
        double x = 10.0 * i, z = i == 1 ? 0 : 1;
        builder.Add(all, square(gp_Pnt(x, 0, i == 2 ? 0 : z), gp_Pnt(x + 10, 0, i == 2 ? z : 0),
                                gp_Pnt(x + 10, 10, i == 2 ? z : 0), gp_Pnt(x, 10, i == 2 ? 0 : z)));
    }
    if (fin) /* a third face at an edge */
        builder.Add(
            all, square(gp_Pnt(10, 0, 0), gp_Pnt(10, 10, 0), gp_Pnt(10, 10, 8), gp_Pnt(10, 0, 8)));
    return all;
}

/* A long face beside three short ones, which share no edge in the file: one edge lies along three.
 */
static TopoDS_Shape make_row() {
    TopoDS_Compound all;
    BRep_Builder builder;
    builder.MakeCompound(all);
    builder.Add(all, square(gp_Pnt(0, 0, 0), gp_Pnt(30, 0, 0), gp_Pnt(30, 5, 0), gp_Pnt(0, 5, 0)));
    for (int i = 0; i < 3; i++) {
        double x = 10.0 * i;
        builder.Add(all, square(gp_Pnt(x, 5, 0), gp_Pnt(x + 10, 5, 0), gp_Pnt(x + 10, 9, 3),
                                gp_Pnt(x, 9, 3)));
    }
    return all;
}

/* Two triangles joined by next to nothing. At the narrow place the edges end off their vertices,
 * and the first comes nearer to an edge of its own triangle than to the one that follows. */
static TopoDS_Shape make_pinched() {
    constexpr double HALF = 2e-4; /* of the narrow place */
    BRep_Builder builder;
    TopoDS_Vertex corners[6];
    TopoDS_Wire wire;
    const gp_Pnt vertices[6] = {gp_Pnt(-20, 10, 0), gp_Pnt(0, HALF, 0),  gp_Pnt(20, 10, 0),
                                gp_Pnt(20, -10, 0), gp_Pnt(0, -HALF, 0), gp_Pnt(-20, -10, 0)};
    builder.MakeWire(wire);
    for (int k = 0; k < 6; k++)
        builder.MakeVertex(corners[k], vertices[k], 10 * HALF);
    for (int k = 0; k < 6; k++) {
        gp_Pnt from = vertices[k], to = k == 0 ? vertices[4] : vertices[(k + 1) % 6];
        TopoDS_Edge edge;
        builder.MakeEdge(edge, new Geom_Line(from, gp_Dir(gp_Vec(from, to))), 1e-7);
        builder.Range(edge, 0, from.Distance(to));
        builder.Add(edge, corners[k].Oriented(TopAbs_FORWARD));
        builder.Add(edge, corners[(k + 1) % 6].Oriented(TopAbs_REVERSED));
        builder.Add(wire, edge);
    }
    return BRepBuilderAPI_MakeFace(gp_Pln(gp_Pnt(0, 0, 0), gp_Dir(0, 0, -1)), wire, true);
}

/* A face whose bound lacks its last side, or has two that cross. */
static TopoDS_Shape make_faulty(bool crosses) {
    gp_Pnt third(10, 10, 0), fourth(0, 10, 0);
    if (crosses)
        std::swap(third, fourth);
    BRepBuilderAPI_MakePolygon bound(gp_Pnt(0, 0, 0), gp_Pnt(10, 0, 0), third, fourth, crosses);
    return BRepBuilderAPI_MakeFace(gp_Pln(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1)), bound.Wire(), true);
}

/* A face and a line that bounds nothing. */
static TopoDS_Shape make_mixed() {
    TopoDS_Compound all;
    BRep_Builder builder;
    builder.MakeCompound(all);
    builder.Add(all, square(gp_Pnt(0, 0, 0), gp_Pnt(9, 0, 0), gp_Pnt(9, 9, 0), gp_Pnt(0, 9, 0)));
    builder.Add(all, BRepBuilderAPI_MakeEdge(gp_Pnt(0, 0, 0), gp_Pnt(0, 0, 5)));
    return all;
}

static TopoDS_Shape make_wires() {
    return BRepBuilderAPI_MakePolygon(gp_Pnt(0, 0, 0), gp_Pnt(10, 0, 0), gp_Pnt(10, 10, 0), true)
        .Wire();
}

/* Two instances of a named, coloured part, the second one turned. */
static void write_assembly() {
    Handle(TDocStd_Document) document = new TDocStd_Document("BinXCAF");
    Handle(XCAFDoc_ShapeTool) shapes = XCAFDoc_DocumentTool::ShapeTool(document->Main());
    Handle(XCAFDoc_ColorTool) colours = XCAFDoc_DocumentTool::ColorTool(document->Main());
    TopoDS_Shape box = BRepPrimAPI_MakeBox(10, 20, 30).Shape();
    TDF_Label part = shapes->AddShape(box, false);
    TDataStd_Name::Set(part, "bracket");
    colours->SetColor(part, Quantity_Color(1, 0, 0, Quantity_TOC_sRGB), XCAFDoc_ColorSurf);
    TDF_Label whole = shapes->NewShape();
    TDataStd_Name::Set(whole, "frame");
    gp_Trsf away;
    away.SetTranslation(gp_Vec(100, 0, 0));
    shapes->AddComponent(whole, part, TopLoc_Location());
    shapes->AddComponent(whole, part, TopLoc_Location(away));
    shapes->UpdateAssemblies();
    Interface_Static::SetCVal("write.step.unit", "MM");
    STEPCAFControl_Writer writer;
    writer.Transfer(document);
    writer.Write((folder + "/assembly.step").c_str());
    print_size("assembly", shapes->GetShape(whole));
    STEPCAFControl_Writer apart; /* the same with each part in a file of its own */
    apart.Transfer(document, STEPControl_AsIs, "apart_");
    apart.Write((folder + "/apart.step").c_str());
}

int main(int argc, char **argv) {
    if (argc != 2)
        return 2;
    folder = argv[1];
    for (const Handle(Message_Printer) & printer : Message::DefaultMessenger()->Printers())
        printer->SetTraceLevel(Message_Fail);
    TopoDS_Shape box = BRepPrimAPI_MakeBox(60, 40, 30).Shape();
    TopoDS_Shape rounded = round_edges(box, 6);
    write_step("box", box, "MM", "AP203");
    write_step("rounded", rounded);
    write_step("rounded_inch", rounded, "INCH", "AP242DIS");
    write_iges("rounded_iges", rounded, "IN");
    write_step("sphere", BRepPrimAPI_MakeSphere(25).Shape(), "M");
    write_step("torus", moved(BRepPrimAPI_MakeTorus(40, 15).Shape(), 1, 2, 3, 1));
    write_step("dome", make_dome());
    write_step("cup", make_cup());
    write_step("neck", make_neck());
    write_step("turned", make_turned());
    write_step("high", make_high());
    write_step("pillar", make_pillar());
    write_step("wing", make_wing());
    write_step("hat", make_hat());
    write_step("bowl", make_bowl());
    write_step("cover", make_cover());
    write_step("cuts", make_cuts());
    write_iges("cuts_iges", make_cuts(), "MM");
    write_step("many", make_many(12));
    write_step("loose", make_loose(false));
    write_step("fin", make_loose(true));
    write_iges("row_iges", make_row(), "MM");
    write_step("pinched", make_pinched());
    write_step("open", make_faulty(false));
    write_step("crossed", make_faulty(true));
    write_step("mixed", make_mixed());
    write_step("wires", make_wires());
    write_assembly();
    return 0;
}
