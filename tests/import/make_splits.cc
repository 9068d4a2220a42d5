/* SPDX-License-Identifier: MIT */
/*
 * Writes parts whole and as Open CASCADE splits them: make_splits FOLDER FIRST COUNT. Of each seed
 * from FIRST on a part is drawn, and up to four tools that go through it: planes, cylinders,
 * spheres and wavy sheets. FOLDER has whole_SEED.step and split_SEED.step, whose faces share edges,
 * are turned round at random, or stand alone with edges of their own, which only meet by the
 * system's tolerance. A line is printed for each: SEED KIND FACES AREA, a point of the part and a
 * direction along it.
 */
#include <BRepAdaptor_Surface.hxx>
#include <BRepAlgoAPI_Splitter.hxx>
#include <BRepBuilderAPI_Copy.hxx>
#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakeWire.hxx>
#include <BRepGProp.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <BRepPrimAPI_MakePrism.hxx>
#include <BRepPrimAPI_MakeRevol.hxx>
#include <BRepPrimAPI_MakeSphere.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <GC_MakeArcOfCircle.hxx>
#include <GProp_GProps.hxx>
#include <GeomAPI_PointsToBSplineSurface.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Geom_SphericalSurface.hxx>
#include <Geom_ToroidalSurface.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <STEPControl_Writer.hxx>
#include <Standard_Failure.hxx>
#include <TColgp_Array2OfPnt.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_ListOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Face.hxx>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

/* All parts are about this long, in millimetres. What splits with edges that are off by more than a
 * millionth of it is left out: of sections that all but touch Open CASCADE finds no better ones. */
static constexpr double SIZE = 100, OFF = 1e-6 * SIZE, DEGREE = M_PI / 180;

/* The same numbers with every library: a distribution of the library may differ. */
struct Chance {
    std::mt19937_64 engine;
    double unit() { return double(engine() >> 11) * 0x1p-53; }
    double between(double low, double high) { return low + unit() * (high - low); }
    int below(int count) { return int(unit() * count); }
    gp_Dir direction() {
        double z = between(-1, 1), turn = between(0, 2 * M_PI), r = std::sqrt(1 - z * z);
        return gp_Dir(r * std::cos(turn), r * std::sin(turn), z);
    }
};

/* ---- wholes ---- */

/* A sheet through n by n points of random heights. */
static Handle(Geom_BSplineSurface) make_sheet(Chance &chance, int n, double height) {
    TColgp_Array2OfPnt points(1, n, 1, n);
    double width = SIZE * chance.between(0.6, 1);
    for (int i = 1; i <= n; i++)
        for (int j = 1; j <= n; j++)
            points(i, j) = gp_Pnt(SIZE * ((i - 1.0) / (n - 1) - 0.5),
                                  width * ((j - 1.0) / (n - 1) - 0.5), height * chance.unit());
    return GeomAPI_PointsToBSplineSurface(points, 3, 3, GeomAbs_C2, 1e-3).Surface();
}

/* A hemisphere, its flange and the fillet between them, of one turn. */
static TopoDS_Shape make_bowl(Chance &chance) {
    double radius = SIZE * 0.4, fillet = SIZE * chance.between(0.05, 0.15);
    double turn = std::asin(fillet / (radius + fillet)), foot = (radius + fillet) * std::cos(turn);
    gp_Pnt side(radius * std::cos(turn), 0, radius * std::sin(turn)), end(foot, 0, 0);
    gp_Vec down(std::sin(turn), 0, -std::cos(turn));
    BRepBuilderAPI_MakeWire wire(
        BRepBuilderAPI_MakeEdge(GC_MakeArcOfCircle(gp_Pnt(0, 0, radius), gp::DX(), side).Value()));
    wire.Add(BRepBuilderAPI_MakeEdge(GC_MakeArcOfCircle(side, down, end).Value()));
    wire.Add(BRepBuilderAPI_MakeEdge(end, gp_Pnt(foot + SIZE * 0.2, 0, 0)));
    return BRepPrimAPI_MakeRevol(wire.Wire(), gp::OZ()).Shape();
}

static const char *const kinds[] = {"sheet", "wavy sheet", "dome", "sphere", "torus patch", "bowl"};
enum { KINDS = sizeof kinds / sizeof *kinds };

static TopoDS_Shape make_whole(Chance &chance, int kind) {
    gp_Ax3 axes(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1));
    Handle(Geom_Surface) surface;
    double u = 2 * M_PI, low = -M_PI / 2, high = M_PI / 2;
    if (kind == 5)
        return make_bowl(chance);
    if (kind < 2) {
        surface = make_sheet(chance, kind ? 8 : 5, SIZE * (kind ? 0.05 : 0.2));
        return BRepBuilderAPI_MakeFace(surface, 1e-7).Face();
    }
    if (kind == 4) {
        surface = new Geom_ToroidalSurface(axes, SIZE * 0.5, SIZE * chance.between(0.1, 0.3));
        u = chance.between(60, 200) * DEGREE;
        low = chance.between(-180, 180) * DEGREE;
        high = low + chance.between(60, 200) * DEGREE;
    } else {
        surface = new Geom_SphericalSurface(axes, SIZE * 0.5);
        low = kind == 2 ? chance.between(-60, 50) * DEGREE : low;
    }
    return BRepBuilderAPI_MakeFace(surface, 0, u, low, high, 1e-7).Face();
}

/* ---- tools ---- */

/* Through a point, wherever it lies. */
static TopoDS_Shape make_tool(Chance &chance, const gp_Pnt &through) {
    gp_Dir way = chance.direction();
    gp_Ax2 axes(through, way);
    double reach = 4 * SIZE, radius = SIZE * chance.between(0.15, 0.8);
    gp_Pnt beside = through.Translated(gp_Vec(axes.XDirection()) * radius);
    switch (chance.below(4)) {
    case 0:
        return BRepBuilderAPI_MakeFace(gp_Pln(through, way), -reach, reach, -reach, reach).Face();
    case 1: /* the wall alone */
        axes.SetLocation(beside.Translated(gp_Vec(way) * -reach));
        return BRepPrimAPI_MakeCylinder(axes, radius, 2 * reach).Face();
    case 2:
        return BRepPrimAPI_MakeSphere(gp_Ax2(beside, way), radius).Face();
    default:
        enum { POINTS = 6 };
        TColgp_Array2OfPnt points(1, POINTS, 1, POINTS);
        for (int i = 1; i <= POINTS; i++)
            for (int j = 1; j <= POINTS; j++)
                points(i, j) = through.Translated(gp_Vec(axes.XDirection()) * SIZE * (i - 3.5) +
                                                  gp_Vec(axes.YDirection()) * SIZE * (j - 3.5) +
                                                  gp_Vec(way) * SIZE * chance.between(-0.15, 0.15));
        GeomAPI_PointsToBSplineSurface sheet(points, 3, 3, GeomAbs_C2, 1e-3);
        return BRepBuilderAPI_MakeFace(sheet.Surface(), 1e-7).Face();
    }
}

/* ---- points of a part ---- */

static std::vector<TopoDS_Face> faces_of(const TopoDS_Shape &shape) {
    std::vector<TopoDS_Face> faces;
    for (TopExp_Explorer at(shape, TopAbs_FACE); at.More(); at.Next())
        faces.push_back(TopoDS::Face(at.Current()));
    return faces;
}

static gp_Pnt random_point(Chance &chance, const TopoDS_Shape &shape, gp_Vec &along) {
    std::vector<TopoDS_Face> faces = faces_of(shape);
    BRepAdaptor_Surface surface(faces[chance.below(int(faces.size()))]);
    double u0 = surface.FirstUParameter(), u1 = surface.LastUParameter();
    double v0 = surface.FirstVParameter(), v1 = surface.LastVParameter();
    gp_Pnt at;
    gp_Vec by_u, by_v;
    double u = u0 + chance.between(0.05, 0.95) * (u1 - u0);
    double v = v0 + chance.between(0.05, 0.95) * (v1 - v0);
    surface.D1(u, v, at, by_u, by_v);
    double turn = chance.between(0, 2 * M_PI);
    along = by_u.Normalized() * std::cos(turn) + by_v.Normalized() * std::sin(turn);
    return at;
}

/* ---- files ---- */

/* By how much an edge of the split part may be off the faces that it is of. */
static double tolerance_of(const TopoDS_Shape &shape) {
    double most = 0;
    for (TopExp_Explorer at(shape, TopAbs_EDGE); at.More(); at.Next())
        most = std::fmax(most, BRep_Tool::Tolerance(TopoDS::Edge(at.Current())));
    return most;
}

static double area_of(const TopoDS_Shape &shape) {
    GProp_GProps properties;
    BRepGProp::SurfaceProperties(shape, properties);
    return properties.Mass();
}

static void write(const std::string &path, const TopoDS_Shape &shape) {
    STEPControl_Writer writer;
    writer.Transfer(shape, STEPControl_AsIs);
    writer.Write(path.c_str());
}

/* The faces in any order; of some parts each with edges of its own. */
static TopoDS_Shape shuffled(Chance &chance, const TopoDS_Shape &split) {
    std::vector<TopoDS_Face> faces = faces_of(split);
    TopoDS_Compound all;
    BRep_Builder builder;
    bool apart = chance.unit() < 0.5;
    builder.MakeCompound(all);
    for (size_t left = faces.size(); left > 0; left--) {
        size_t pick = size_t(chance.below(int(left)));
        TopoDS_Shape face = apart ? BRepBuilderAPI_Copy(faces[pick]).Shape() : faces[pick];
        builder.Add(all, apart && chance.unit() < 0.5 ? face.Reversed() : face);
        faces[pick] = faces[left - 1];
    }
    return all;
}

static void make_part(const std::string &folder, unsigned long seed) {
    Chance chance{std::mt19937_64(seed)};
    int kind = chance.below(KINDS), count = 1 + chance.below(4);
    gp_Vec along;
    TopoDS_Shape whole = make_whole(chance, kind);
    TopTools_ListOfShape parts, tools;
    parts.Append(whole);
    for (int k = 0; k < count; k++)
        tools.Append(make_tool(chance, random_point(chance, whole, along)));
    BRepAlgoAPI_Splitter splitter;
    splitter.SetArguments(parts);
    splitter.SetTools(tools);
    splitter.Build();
    TopoDS_Shape split = shuffled(chance, splitter.Shape());
    gp_Pnt start = random_point(chance, whole, along);
    double area = area_of(whole), off = tolerance_of(split);
    if (splitter.HasErrors() || std::fabs(area_of(split) / area - 1) > 1e-4 || off > OFF)
        return; /* not what was asked for */
    std::string number = std::to_string(seed);
    write(folder + "/whole_" + number + ".step", whole);
    write(folder + "/split_" + number + ".step", split);
    std::printf("%lu\t%s\t%zu\t%.17g\t%.17g\t%.17g %.17g %.17g\t%.17g %.17g %.17g\n", seed,
                kinds[kind], faces_of(split).size(), area, off, start.X(), start.Y(), start.Z(),
                along.X(), along.Y(), along.Z());
}

int main(int argc, char **argv) {
    if (argc != 4)
        return 2;
    for (const Handle(Message_Printer) & printer : Message::DefaultMessenger()->Printers())
        printer->SetTraceLevel(Message_Fail);
    unsigned long first = std::strtoul(argv[2], nullptr, 10), count = std::atoi(argv[3]);
    for (unsigned long seed = first; seed < first + count; seed++) {
        try {
            make_part(argv[1], seed);
        } catch (const Standard_Failure &failure) {
            std::fprintf(stderr, "%lu: %s\n", seed, failure.GetMessageString());
        }
    }
    return 0;
}
