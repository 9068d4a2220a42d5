/* SPDX-License-Identifier: MIT */
/*
 * A part of a CAD file as the importer knows it: its trimmed faces, each an exact NURBS surface
 * with trim curves in the parameters, in the file's own unit. `cad.h` reads the file, `face.h`
 * makes one face, `document.h` writes what the service takes.
 */
#ifndef CLI_IMPORT_PART_H
#define CLI_IMPORT_PART_H

#include <array>
#include <stdexcept>
#include <string>
#include <vector>

namespace drape {

/* Why a file cannot be imported, as a sentence for its owner. */
struct unreadable : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/* What is wrong with a face. */
struct fault {
    std::string what; /* a sentence without the face */
    double by = 0;    /* its size, 0 where it has none */
    bool gap = false; /* a distance, nothing where the part's tolerance calls it one place */
};

/* A curve in (u, v). Polynomial where `weights` is empty. */
struct trim_curve {
    int degree = 1;
    std::vector<double> knots;
    std::vector<std::array<double, 2>> points; /* not multiplied by the weights */
    std::vector<double> weights;
};

/* Curves end to end. */
struct trim_loop {
    bool outer; /* what lies inside is kept, not cut away */
    std::vector<trim_curve> curves;
};

/* A face whose r_u x r_v is the file's outward normal. */
struct face {
    int degree[2], size[2];
    std::vector<double> knots[2];
    std::vector<std::array<double, 3>> points; /* v runs fastest, not multiplied by the weights */
    std::vector<double> weights;               /* empty: all 1 */
    std::vector<trim_loop> loops;              /* none: the whole domain */
    std::string name, colour, kind;            /* "" without; colour as #rrggbb */
    /* By Open CASCADE's own integration, of its faces; where they are asked for. */
    double area, centre[3], normal[3];
    std::array<double, 3> box[2]; /* its lowest and highest corner */
};

/* What the file says of the edges of the faces. */
struct edge_counts {
    int shared = 0, free = 0, faulty = 0;
    double largest_gap = 0;
};

struct part {
    std::string unit; /* of the lengths: m, mm, cm, um, in, ft */
    std::vector<face> faces;
    std::vector<int> numbers; /* of the faces in the file */
    edge_counts edges;
    double tolerance = 0;           /* that joins what the file joins */
    std::vector<std::string> notes; /* what was healed or left out, a sentence each */
};

} // namespace drape

#endif
