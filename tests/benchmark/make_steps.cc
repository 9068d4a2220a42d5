/* SPDX-License-Identifier: MIT */
/*
 * Writes the CAD files of the open benchmark's cases: make_steps FOLDER. They are surfaces of
 * elementary faces, as a CAD program writes them; make_cases has the same as splines, and the nets.
 */
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_Sewing.hxx>
#include <Geom_ConicalSurface.hxx>
#include <Geom_CylindricalSurface.hxx>
#include <Geom_Plane.hxx>
#include <Geom_ToroidalSurface.hxx>
#include <Interface_Static.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <STEPControl_Writer.hxx>
#include <TopoDS_Face.hxx>
#include <cmath>
#include <cstdio>
#include <string>

static const double degree = M_PI / 180, tolerance = 1e-7;

static bool write(const std::string &folder, const char *name, const TopoDS_Shape &shape) {
    Interface_Static::SetCVal("write.step.unit", "MM");
    STEPControl_Writer writer;
    writer.Transfer(shape, STEPControl_AsIs);
    return writer.Write((folder + "/" + name + "/surface.step").c_str()) == IFSelect_RetDone;
}

static TopoDS_Face face(const Handle(Geom_Surface) & surface, double u0, double u1, double v0,
                        double v1) {
    return BRepBuilderAPI_MakeFace(surface, u0, u1, v0, v1, tolerance).Face();
}

static TopoDS_Shape make_cylinder() {
    return face(new Geom_CylindricalSurface(gp_Ax3(), 60), -100 * degree, 100 * degree, -120, 120);
}

/* rho = 0.6 z for z from 60 to 210; the second parameter is the slant from the apex. */
static TopoDS_Shape make_cone() {
    double half = std::atan(0.6), apex = std::cos(half);
    Handle(Geom_Surface) cone = new Geom_ConicalSurface(gp_Ax3(), half, 0);
    return face(cone, -100 * degree, 100 * degree, 60 / apex, 210 / apex);
}

static TopoDS_Shape make_torus() {
    return face(new Geom_ToroidalSurface(gp_Ax3(), 90, 30), 0, 90 * degree, 0, 360 * degree);
}

/* Straight pieces and fillets along the profile in the plane (x, z), 240 mm wide along y. */
static TopoDS_Shape make_hat() {
    static const double straight[5] = {60, 40, 80, 40, 60}, turns[5] = {0, 70, -70, -70, 70};
    const double radius = 12, width = 240;
    double x = 0, z = 0, angle = 0;
    BRepBuilderAPI_Sewing sewing(1e-6);
    for (int k = 0; k < 5; k++) {
        double turn = turns[k] * degree, side = turn > 0 ? 1 : -1;
        gp_Dir across(0, 1, 0);
        if (turn != 0) {
            /* The axis lies to the left of the profile where it turns left. Angles are counted
             * about y from the way back to the fillet's beginning. */
            gp_Pnt axis(x - side * radius * std::sin(angle), 0,
                        z + side * radius * std::cos(angle));
            gp_Dir back(side * std::sin(angle), 0, -side * std::cos(angle));
            gp_Ax3 frame(axis, gp_Dir(0, -side, 0), back);
            double low = side > 0 ? -width : 0;
            sewing.Add(face(new Geom_CylindricalSurface(frame, radius), 0, std::fabs(turn), low,
                            low + width));
            double chord = 2 * radius * std::sin(std::fabs(turn) / 2);
            x += chord * std::cos(angle + turn / 2);
            z += chord * std::sin(angle + turn / 2);
            angle += turn;
        }
        gp_Dir along(std::cos(angle), 0, std::sin(angle));
        gp_Ax3 frame(gp_Pnt(x, 0, z), along.Crossed(across), along);
        sewing.Add(face(new Geom_Plane(frame), 0, straight[k], 0, width));
        x += straight[k] * std::cos(angle);
        z += straight[k] * std::sin(angle);
    }
    sewing.Perform();
    return sewing.SewedShape();
}

int main(int argc, char **argv) {
    if (argc != 2)
        return 2;
    for (const auto &printer : Message::DefaultMessenger()->Printers())
        printer->SetTraceLevel(Message_Fail);
    std::string folder = argv[1];
    bool written = write(folder, "cylinder", make_cylinder()) &&
                   write(folder, "cone", make_cone()) && write(folder, "torus", make_torus()) &&
                   write(folder, "hat", make_hat());
    if (!written)
        std::fprintf(stderr, "make_steps: a file cannot be written below %s\n", argv[1]);
    return written ? 0 : 1;
}
