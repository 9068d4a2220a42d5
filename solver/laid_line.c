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

/* ---- whether it meets itself ---- */

/* Of two pieces of a line that are no further apart than this share of the way between them along
 * it one has come back to the other. */
static const double back_share = 0.1;

static double clamp_share(double share) {
    return fmin(fmax(share, 0), 1);
}

/* The least distance of the pieces a + s u and b + t v, 0 <= s, t <= 1: the least of the quadratic
 * form in s, then in turn in t and s (Ericson, Real-Time Collision Detection, 5.1.9). */
static double segments_apart(const struct vec3 a[2], const struct vec3 b[2]) {
    struct vec3 u = vec3_sub(a[1], a[0]), v = vec3_sub(b[1], b[0]), w = vec3_sub(a[0], b[0]);
    double uu = vec3_norm2(u), uv = vec3_dot(u, v), vv = vec3_norm2(v), vw = vec3_dot(v, w);
    double sine2 = uu * vv - uv * uv;
    double s = sine2 > 0 ? clamp_share((uv * vw - vv * vec3_dot(u, w)) / sine2) : 0;
    double t = clamp_share((uv * s + vw) / vv);
    s = clamp_share((uv * t - vec3_dot(u, w)) / uu);
    return vec3_norm(vec3_axpy(-t, v, vec3_axpy(s, u, w)));
}

bool laid_line_meets_itself(const struct drape_cut_line *line, double within, struct vec3 *at) {
    const struct vec3 *p = line->path;
    size_t pieces = line->count - 1;
    bool ring = !(vec3_distance(p[0], p[pieces]) > 0);
    double total = 0;
    for (size_t k = 0; k < pieces; k++)
        total += vec3_distance(p[k], p[k + 1]);
    for (size_t j = 0; j < pieces; j++) {
        double own = vec3_distance(p[j], p[j + 1]), way = 0; /* between both along the line */
        for (size_t k = j + 1; k < pieces;) {
            double step = vec3_distance(p[k], p[k + 1]), apart = segments_apart(p + j, p + k);
            double between = ring ? fmin(way, total - own - way - step) : way;
            struct vec3 back = vec3_sub(p[j], p[k]), on = vec3_sub(p[k + 1], p[k]);
            bool turns = k == j + 1 && vec3_dot(back, on) > 0 &&
                         vec3_norm(vec3_cross(back, on)) < back_share * vec3_dot(back, on);
            *at = p[k];
            if (turns || (apart < within && apart < back_share * between))
                return true;
            /* Before the line has gone on for so long no piece of it is nearer than `within`. */
            double passed = step;
            do {
                way += step;
                step = ++k < pieces ? vec3_distance(p[k], p[k + 1]) : 0;
                passed += step;
            } while (k < pieces && passed <= apart - within);
        }
    }
    return false;
}
