/* SPDX-License-Identifier: MIT */
/*
 * The way of a logarithm: the pieces between two points, which end on the knot lines and on the
 * joints of faces that they cross. Over a joint it goes on as it does over a knot line: what it
 * has along the joint stays, so that it is straight when both sides are unfolded.
 */
#ifndef SOLVER_FISHNET_WAY_H
#define SOLVER_FISHNET_WAY_H

#include "rough.h"
#include "solver/shell/crossing.h"

enum { WAY_PIECES = 48, WAY_LINES = 8, WAY_JOINTS = 4 };

/* What the point at the beginning of a piece lies on: a knot line of direction 0 or 1, or neither a
 * line nor a joint, or a joint, whose number is added to that. */
enum { WAY_ALONG = -1, WAY_JOINT = 2 };

/* The points from p to q and the pieces between them; on a line or a joint one for either side. */
struct way {
    int pieces, used, joints;
    struct surface_point *from[WAY_PIECES], *to[WAY_PIECES];
    int on[WAY_PIECES + 1]; /* of the point at the beginning of each piece */
    struct crossing joint[WAY_JOINTS];
    struct surface_point points[2 * (WAY_PIECES + WAY_LINES + WAY_JOINTS)];
};

/* Lays the way straight in parameters, from face to face by where q is seen. False when there are
 * too many lines or joints, more than once round a closed direction, or where it is lost. */
bool way_lay(struct surface_cursor *cursor, const struct surface_point *p,
             const struct surface_point *q, struct way *way);

/* Moves the end of a way to a q near it. False, when the way is to be laid anew, where that is not
 * on the last piece's face or beyond a knot line, or far for that piece. */
bool way_move_end(struct way *way, const struct surface_point *q);

/* The unit tangents of the line or joint at the beginning of piece k, before it and after. */
void way_tangents(const struct way *way, int k, struct vec3 tangent[2]);

/* The most by which normals on both sides of a joint differ. */
double way_crease(const struct way *way);

/* Moves the point at the beginning of piece k along its line or joint, so far to the left of the
 * way. False where that runs along it, or past the end of the joint. */
bool way_slide(struct way *way, int k, double left);

/* Evaluates both ends of piece k in the span that it runs through. */
bool way_place_ends(struct way *way, int k);

/* The point at uv as the span has it in which the way to `towards` begins. A span further on,
 * over a knot line on which parameters alone change, has another point at uv. */
bool way_point_beside(const struct surface *surface, const double uv[2], const double towards[2],
                      struct surface_point *point);

/* Whether the pieces leave no face and cross no crease but where they end. */
bool way_holds(const struct way *way);

#endif
