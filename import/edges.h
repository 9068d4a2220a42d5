/* SPDX-License-Identifier: MIT */
/*
 * Where the edges of a part lie together: those that two faces share in the file, and those of
 * faces that the file leaves apart, as IGES does with all. Nothing is moved or cut: the solver
 * joins the faces as they are, within a tolerance that this finds.
 */
#ifndef CLI_IMPORT_EDGES_H
#define CLI_IMPORT_EDGES_H

#include "part.h"
#include <TopoDS_Face.hxx>

namespace drape {

/* A face of the file in its place, before it is converted. */
struct found_face {
    TopoDS_Face shape;
    std::string name, colour;
    bool solid;                /* of a closed body */
    std::vector<fault> faults; /* known of it as it was read */
};

/* "face 3", with its name where it has one. */
std::string face_title(int number, const std::string &name);

/* "1 edge", "2 edges". */
std::string count_text(size_t count, const char *noun);

/* What two surfaces may be apart at a joint, as a share of the part's diagonal. */
constexpr double EDGES_TOLERANCE = 1e-5; /* the service's default */

/* Counts the edges of the faces with these numbers. Edges of faces in no solid that lie within
 * EDGES_TOLERANCE of the diagonal of each other are shared; within ten times that if longer edges
 * are shared so. `notes` gets what is worth saying. */
edge_counts edges_count(const std::vector<found_face> &faces, const std::vector<int> &numbers,
                        double diagonal, std::vector<std::string> &notes);

} // namespace drape

#endif
