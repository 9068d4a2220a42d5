/* SPDX-License-Identifier: MIT */
/*
 * What joining the faces of a shell gathers, for joints.c and the two files that work for it: the
 * curves that bound the faces, as points (joints_curves.c), and the edges that these are cut into
 * (joints_edges.c).
 */
#ifndef SOLVER_SHELL_JOINTS_H
#define SOLVER_SHELL_JOINTS_H

#include "faces.h"

enum { JOIN_SAMPLES = 3 }; /* places along an edge at which it is judged */

/* Steps between points leave their curve by less than this share of their own length. */
static const double join_sagitta = 0.02;

struct join_point {
    double t, uv[2];
    struct vec3 r;
};

/* Everything while it is gathered. */
struct join {
    struct shell *shell;
    struct arena *arena, *scratch; /* scratch: what only the joining needs, more than what stays */
    struct arena *pool[2]; /* of the points, and of those they are copied to when they grow */
    struct join_point *points;
    size_t point_count, point_room;
    size_t curve_room;
    struct join_cut *cuts;                    /* of curves, in no order until they are sorted */
    size_t cut_count, cut_room, corner_count; /* the first are at corners of their own curves */
    int32_t *last_cut;                        /* of each curve, or -1 */
    struct boxes *boxes;                      /* round the steps from point to point */
    int32_t *curve_of, *edge_of;              /* of points; of the steps that follow them */
    bool failed;                              /* no memory */
};

struct join_cut {
    int32_t curve;
    double t;
    struct vec3 r;
    int32_t
        before; /* the cut of the same curve that was added before, or -1; until they are sorted */
};

/* The curves of all faces: their trims, or their domains' sides. */
void join_gather_curves(struct join *join, const struct shell_patch *patches);

/* The place at t of a curve. */
struct join_point join_sample(const struct shell *shell, const struct face_curve *curve, double t);

/* Adds the points of a curve, close enough for the steps between them to be straight. */
void join_sample_curve(struct join *join, int32_t number);

/* Boxes round the steps between points, within which the curve lies, and `margin` more. */
enum status join_make_boxes(struct join *join, double margin);

/* The point of a curve nearest to `point`, looked for from the step at `at`. */
double join_nearest(const struct join *join, uint32_t at, struct vec3 point, const double range[2],
                    struct curve_place *place);

/* Cuts the curves at the ends of all that pass, and at their own corners. */
void join_cut_curves(struct join *join);

/* The edges of all curves, between cuts further apart than the tolerance. */
enum status join_make_edges(struct join *join);

/* Whether a face is no wider than `width` beside an edge, at a share of it. Slivers of half the
 * tolerance have no boundary: their neighbours meet as over a gap. */
bool join_is_sliver(const struct shell *shell, const struct face_edge *edge, double share,
                    double width);

#endif
