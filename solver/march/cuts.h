/* SPDX-License-Identifier: MIT */
/*
 * Cuts: lines on the part over which the cloth does not go, each from an edge to its tip. A cut has
 * two lips, lines of cloth over one line of the part. The march lays no yarn across; what lies
 * behind a lip is reached round the tip, straight on along the yarns that pass it.
 */
#ifndef SOLVER_MARCH_CUTS_H
#define SOLVER_MARCH_CUTS_H

#include "march.h"
#include "solver/result.h"
#include "solver/surface/boxes.h"

/* A place of a lip: as a vertex of an edge (`rim_edges.h`). */
struct cut_vertex {
    int32_t face; /* on a mesh the triangle, on a shell the face, else 0 */
    double uv[2]; /* the surface's inner parameters; on a mesh those of the triangle */
    struct vec3 r;
    bool leaps; /* the next one is the same place on another face */
};

struct cut {
    struct cut_vertex *lip[2]; /* from the edge to the tip: the left one and the right one, seen
                                  that way against the normals */
    size_t count[2];
    double length;
};

struct cuts {
    struct cut *cut;
    size_t count;
    struct curtain *curtain;
    struct box near; /* round all that is within both of the following of it */
};

struct cuts_to_apexes {
    struct drape_cut_line *line; /* from the edge to the apex */
    size_t count;
};

/* In spacings: corners of a cell are less than this apart; and so near to the tip of a cut it tells
 * how yarns go. */
#define CUTS_CELL_REACH 2.0
#define CUTS_POINT_REACH 7.5

/* Whether a place may be a corner of a cell with one that is so near to a cut: most are not. */
static inline bool cuts_may_be_near(const struct cuts *cuts, struct vec3 at) {
    const struct box *box = &cuts->near;
    return at.x >= box->lower.x && at.x <= box->upper.x && at.y >= box->lower.y &&
           at.y <= box->upper.y && at.z >= box->lower.z && at.z <= box->upper.z;
}

/* The place of the part nearest to a point; false where it has no tangent plane. */
bool cuts_nearest(struct march *march, struct vec3 r, struct surface_point *place);

/* Lays the cuts of the settings on the part of a march that has its start, and after them those
 * among these to apexes of the part that can be laid: `march->cuts`, NULL when there are none.
 * Errors: STATUS_OUT_OF_MEMORY; STATUS_CUT, with the fault of a cut of the settings. */
enum status cuts_make(struct march *march, const struct cuts_to_apexes *apexes,
                      struct cut_fault *fault) STATUS_MUST_USE;

/* The lines opposite the start, each from an edge to an apex of the part that the cloth cannot
 * pass. Not on a mesh of the caller's. Errors: STATUS_OUT_OF_MEMORY. */
enum status cuts_to_apexes(struct march *march, struct cuts_to_apexes *apexes) STATUS_MUST_USE;

#endif
