/* SPDX-License-Identifier: MIT */
/*
 * Writes the moulds that searches are measured on: make_moulds FOLDER. They are solids whose tool
 * side is all that joins the highest face smoothly; every fillet is smaller than a cell of the net
 * that a search would explore on. Lengths are in millimetres.
 */
#include <BRepAlgoAPI_Cut.hxx>
#include <BRepAlgoAPI_Fuse.hxx>
#include <BRepBuilderAPI_MakePolygon.hxx>
#include <BRepFilletAPI_MakeFillet.hxx>
#include <BRepOffsetAPI_ThruSections.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakeCone.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <BRep_Tool.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <STEPControl_Writer.hxx>
#include <TopExp.hxx>
#include <TopTools_IndexedDataMapOfShapeListOfShape.hxx>
#include <TopTools_ListOfShape.hxx>
#include <TopoDS.hxx>
#include <cmath>
#include <cstdio>
#include <string>

/* Rounds the edges that lie above z = 0: those that go up by `upright`, the others by `level`. */
static TopoDS_Shape round_edges(const TopoDS_Shape &solid, double upright, double level) {
    BRepFilletAPI_MakeFillet fillet(solid);
    TopTools_IndexedDataMapOfShapeListOfShape edges; /* and the faces at each */
    TopExp::MapShapesAndUniqueAncestors(solid, TopAbs_EDGE, TopAbs_FACE, edges);
    for (int i = 1; i <= edges.Extent(); i++) {
        TopoDS_Edge edge = TopoDS::Edge(edges.FindKey(i));
        bool seam = edges(i).Extent() < 2;
        double from = BRep_Tool::Pnt(TopExp::FirstVertex(edge)).Z();
        double to = BRep_Tool::Pnt(TopExp::LastVertex(edge)).Z();
        if (std::fmax(from, to) > 0.1 && !seam)
            fillet.Add(std::fabs(from - to) > 1 ? upright : level, edge);
    }
    return fillet.Shape();
}

/* A block from a rectangle at `low` to one at `high`, each x0, y0, x1, y1. */
static TopoDS_Shape block(double low, const double (&a)[4], double high, const double (&b)[4]) {
    BRepOffsetAPI_ThruSections sections(true, true);
    for (int k = 0; k < 2; k++) {
        const double *r = k ? b : a, z = k ? high : low;
        BRepBuilderAPI_MakePolygon polygon(gp_Pnt(r[0], r[1], z), gp_Pnt(r[2], r[1], z),
                                           gp_Pnt(r[2], r[3], z), gp_Pnt(r[0], r[3], z), true);
        sections.AddWire(polygon.Wire());
    }
    return sections.Shape();
}

static TopoDS_Shape box(double x0, double y0, double x1, double y1, double z) {
    return BRepPrimAPI_MakeBox(gp_Pnt(x0, y0, 0), gp_Pnt(x1, y1, z)).Shape();
}

static TopoDS_Shape cylinder(double x, double y, double radius, double z) {
    return BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(x, y, 0), gp_Dir(0, 0, 1)), radius, z).Shape();
}

static TopoDS_Shape fuse(const TopoDS_Shape &a, const TopoDS_Shape &b) {
    return BRepAlgoAPI_Fuse(a, b).Shape();
}

static void write(const std::string &path, const TopoDS_Shape &shape) {
    STEPControl_Writer writer;
    writer.Transfer(shape, STEPControl_AsIs);
    writer.Write(path.c_str());
}

int main(int argc, char **argv) {
    if (argc != 2)
        return 2;
    for (const Handle(Message_Printer) & printer : Message::DefaultMessenger()->Printers())
        printer->SetTraceLevel(Message_Fail);
    const TopoDS_Shape cone =
        BRepPrimAPI_MakeCone(gp_Ax2(gp_Pnt(75, 50, 0), gp_Dir(0, 0, 1)), 40, 25, 30).Shape();
    const TopoDS_Shape step =
        BRepPrimAPI_MakeBox(gp_Pnt(120, -1, 15), gp_Pnt(201, 121, 31)).Shape();
    const struct {
        const char *name;
        TopoDS_Shape solid;
        double upright, level;
    } moulds[] = {
        {"tray", box(0, 0, 200, 140, 20), 25, 6},
        {"draft", block(0, {0, 0, 200, 150}, 30, {15, 12, 180, 140}), 12, 6},
        {"lean", block(0, {0, 0, 180, 120}, 40, {40, 25, 150, 100}), 15, 8},
        {"corner", fuse(box(0, 0, 180, 70, 15), box(0, 0, 70, 160, 15)), 12, 5},
        {"stairs", BRepAlgoAPI_Cut(box(0, 0, 200, 120, 30), step).Shape(), 12, 6},
        {"boss", fuse(box(0, 0, 180, 140, 10), cylinder(70, 65, 35, 25)), 15, 5},
        {"cup", fuse(box(0, 0, 150, 100, 8), cone), 12, 6},
        {"lid", fuse(cylinder(0, 0, 80, 15), box(-45, -20, 40, 30, 30)), 10, 5},
        {"hat", fuse(box(0, 0, 220, 110, 8), block(8, {50, 25, 180, 85}, 35, {65, 35, 160, 75})),
         12, 6},
    };
    for (const auto &mould : moulds) {
        try {
            write(std::string(argv[1]) + "/" + mould.name + ".step",
                  round_edges(mould.solid, mould.upright, mould.level));
        } catch (const Standard_Failure &failure) {
            std::fprintf(stderr, "%s: %s\n", mould.name, failure.GetMessageString());
        }
    }
    return 0;
}
