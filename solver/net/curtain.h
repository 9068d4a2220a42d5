/* SPDX-License-Identifier: MIT */
/*
 * A curtain: a line on a part, along its normals above and below it, which ways over the part
 * between places near each other may pass. It is what keeps the cloth on either side of a cut
 * apart. Whether a way pierces it is decided edge by edge with the same signs for all that meet
 * there, so that no way slips through where two straight pieces join, and none is stopped beyond
 * its end.
 */
#ifndef SOLVER_NET_CURTAIN_H
#define SOLVER_NET_CURTAIN_H

#include "solver/arena.h"
#include "solver/status.h"
#include "solver/surface/boxes.h"
#include "solver/vec.h"
#include <stdbool.h>
#include <stddef.h>

/* A place of a line, the unit normal of the part there, and how far the curtain reaches along that
 * to both sides. */
struct curtain_post {
    struct vec3 r, normal;
    double height;
};

/* Posts in order, at least 2, straight between them. */
struct curtain_line {
    const struct curtain_post *posts;
    size_t count;
};

struct curtain;

/* A curtain along `count` lines; the posts are copied. Errors: STATUS_OUT_OF_MEMORY. */
enum status curtain_make(const struct curtain_line *lines, size_t count, struct arena *arena,
                         struct curtain **curtain) STATUS_MUST_USE;

/* The box round all that is within `reach` of the curtain. */
struct box curtain_box(const struct curtain *curtain, double reach);

/* Whether a place is within `reach` of the curtain, to what its strips bend. */
bool curtain_is_near(const struct curtain *curtain, struct vec3 r, double reach);

/* The end of a line, its last post, that is nearest to a place; there is one. */
const struct curtain_post *curtain_end(const struct curtain *curtain, struct vec3 r);

/* How far that is. */
double curtain_end_distance(const struct curtain *curtain, struct vec3 r);

/* Whether the straight way between two places pierces the curtain, and the part's normal there (may
 * be NULL). A place on a line is to the left of it. */
bool curtain_parts(const struct curtain *curtain, struct vec3 from, struct vec3 to,
                   struct vec3 *normal);

#endif
