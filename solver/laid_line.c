/* SPDX-License-Identifier: MIT */
#include "laid_line.h"

#include <math.h>

/* A piece is looked at in its middle and in those of its halves. It is near enough within this
 * share of the reach, for it may be further between. */
static const double looked_at[] = {0.5, 0.25, 0.75}, near_share = 0.9;

/* A middle is moved to where the part rises above its chord: along the normal within 60 degrees,
 * and by at most this share of half the chord. Beyond a hole or an edge the nearest place is aside.
 */
static const double normal_share = 0.5, rise_share = 0.75;

enum { DEEPEST = 10 }; /* halves of halves: 1,024 pieces of one */

struct laying {
    const struct laid_line_part *part;
    struct arena *arena;
    double reach;
    struct vec3 *points;
    size_t count, room;
};

static bool add_point(struct laying *l, struct vec3 r) {
    if (l->count == l->room)
        l->points = arena_enlarge(l->arena, l->points, l->count, sizeof *l->points, &l->room);
    if (l->points)
        l->points[l->count++] = r;
    return l->points;
}

/* Where the middle of a piece is to be moved to; false if it is to stay. */
static bool find_foot(const struct laying *l, struct vec3 from, struct vec3 way,
                      struct vec3 *foot) {
    struct vec3 normal;
    bool far = false;
    for (int k = 2; k >= 0; k--) { /* the middle last */
        struct vec3 r = vec3_axpy(looked_at[k], way, from);
        if (!l->part->nearest(l->part->context, r, foot, &normal))
            return false;
        far |= vec3_distance(r, *foot) > near_share * l->reach;
    }
    struct vec3 rise = vec3_sub(*foot, vec3_axpy(looked_at[0], way, from));
    double height = vec3_norm(rise);
    return far && height <= rise_share * vec3_norm(way) / 2 &&
           fabs(vec3_dot(rise, normal)) >= normal_share * height;
}

/* Adds the piece from a point to another, without the first of them. */
static bool add_piece(struct laying *l, struct vec3 from, struct vec3 to, int depth) {
    struct vec3 foot;
    if (depth == DEEPEST || !find_foot(l, from, vec3_sub(to, from), &foot))
        return add_point(l, to);
    return add_piece(l, from, foot, depth + 1) && add_piece(l, foot, to, depth + 1);
}

enum status laid_line_make(const struct laid_line_part *part, const struct drape_cut_line *asked,
                           double reach, struct arena *arena, struct drape_cut_line *line) {
    struct laying l = {.part = part, .arena = arena, .reach = reach};
    bool all = add_point(&l, asked->path[0]);
    for (size_t k = 1; k < asked->count && all; k++)
        all = add_piece(&l, asked->path[k - 1], asked->path[k], 0);
    *line = (struct drape_cut_line){l.points, l.count};
    return all ? STATUS_OK : STATUS_OUT_OF_MEMORY;
}
