/* SPDX-License-Identifier: MIT */
/*
 * From face to face of a shell. A place is found on a face's natural continuation first; one that
 * lies outside the face's region is carried over the edge nearest to it: what leads from the edge
 * to it keeps its component along the edge, and the others are turned from the one tangent plane
 * into the other, as if both were unfolded. Several faces may lie between. Beyond a free edge the
 * continuation holds, as it does beyond the border of a surface of its own.
 */
#ifndef SOLVER_SHELL_CROSSING_H
#define SOLVER_SHELL_CROSSING_H

#include "surface_point.h"

/* What a place outside a face's region has between itself and the face. */
enum crossing_kind {
    CROSSING_NONE, /* nothing: it is in the region */
    CROSSING_JOINT,
    CROSSING_FREE
};

/* Orthonormal frame at a place of an edge: along it, across it out of the face that is left or into
 * the one that is entered, and the normal. */
struct crossing_frame {
    struct vec3 at, along, across, normal;
};

struct crossing {
    enum crossing_kind kind;
    bool at_corner;  /* CROSSING_JOINT: the place lies beyond its end on the shell's boundary, or a
                        free edge is as near */
    bool continued;  /* CROSSING_JOINT: beyond an end, where the curves of both faces go on alike */
    double distance; /* of the place from the edge, to first order */
    double edge[2];  /* where on the face that is left: inner parameters, in the place's turn */
    const struct surface *beyond; /* CROSSING_JOINT: the next face, and where on it */
    double entry[2];
    struct crossing_frame from, to;
    int32_t number;    /* of the edge, and its parameter there */
    double t, rate[2]; /* and the derivative of the edge's inner parameters by it */
    int32_t nearest;   /* the edge that is nearest to the place, -1: none, and where on it */
    double nearest_t;
};

/* Looks from a point of a shell's face over the edge that is nearest to it, or over the line in
 * which a joint goes on beyond its end, where the point lies past that. At a vertex that is
 * not the joint to the face `before`, which it was carried from; NULL: it was not. */
void crossing_find(const struct surface_point *point, const struct surface *before,
                   struct crossing *crossing);

/* The place of the shell's boundary that is nearest in space to a point beyond it, which the
 * crossing was found for: on the nearest edge, or on those that follow it without a crease.
 * `border` gets the place, and `derivative` the first and second derivative of the edge. False
 * where there is none. */
bool crossing_border(const struct surface_point *point, const struct crossing *crossing,
                     struct surface_point *border, struct vec3 derivative[2]);

/* The joint to the face `beyond` that is nearest to a point, on either side of it. False where
 * the point's face has none. */
bool crossing_between(const struct surface_point *point, const struct surface *beyond,
                      struct crossing *crossing);

/* A vector at the place as it is beyond the edge. */
struct vec3 crossing_turn(const struct crossing *crossing, struct vec3 v);

/* The place beyond a joint that the point is carried to: to second order in its distance, and after
 * some rounds exactly what is nearest to it. False where there is none. */
bool crossing_carry(const struct crossing *crossing, struct surface_cursor *cursor,
                    const struct surface_point *point, int rounds, struct surface_place *place);

/* Carries a point over joints until it lies in its face's region or beyond a free edge; a few
 * at the most. False when it got lost. */
bool crossing_settle(struct surface_cursor *cursor, struct surface_point *point);

/* Whether a place is in the region of its face of a shell. */
bool crossing_within(const struct surface *surface, const double uv[2]);

/* Whether a rectangle of parameters lies well inside the face's region, as far as its grid tells.
 */
bool crossing_all_within(const struct surface *surface, const double low[2], const double high[2]);

/* Where a way leaves the region of a face. */
struct crossing_exit {
    double share; /* of the way, 0..1, that lies before it */
    double t;     /* the place of the joint */
    int32_t edge; /* its number */
};

/* Where the way from one place of a face to another first leaves its region over a joint. False
 * when it meets none from inside. */
bool crossing_leaves(const struct surface *surface, const double from[2], const double to[2],
                     struct crossing_exit *exit);

/* That joint, too, and the share of the way that lies before it. */
bool crossing_on_way(const struct surface *surface, const double from[2], const double to[2],
                     double *share, struct crossing *crossing);

/* Moves a crossing along its edge to `t`, kept within it. False where it has no frame. */
bool crossing_move(const struct surface *surface, double t, struct crossing *crossing);

#endif
