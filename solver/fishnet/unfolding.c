/* SPDX-License-Identifier: MIT */
#include "unfolding.h"

#include "solver/shell/crossing.h"

static void knot_frame(const struct surface *surface, const struct unfolding_side *side, int k,
                       const double uv[2], struct vec3 frame[3], struct vec3 *at) {
    struct surface_jet jet;
    surface_evaluate_span(surface, side->span[0], side->span[1], uv[0] - side->turn[0],
                          uv[1] - side->turn[1], &jet);
    frame[0] = vec3_unit(k == 0 ? jet.v : jet.u);
    frame[2] = vec3_unit(vec3_cross(jet.u, jet.v));
    frame[1] = vec3_cross(frame[2], frame[0]);
    *at = jet.r;
}

struct unfolding unfolding_between(const struct unfolding_side *from,
                                   const struct unfolding_side *to) {
    struct unfolding unfolding = {.flat = true};
    const struct surface *surface = from->surface;
    int across = -1, differ = 0;
    if (to->surface != surface) { /* on both sides of a joint of a shell */
        struct crossing c;
        if (!from->point || !to->point || !crossing_between(from->point, to->surface, &c))
            return unfolding;
        return (struct unfolding){.at = c.from.at,
                                  .from = {c.from.along, c.from.across, c.from.normal},
                                  .to = {c.to.along, c.to.across, c.to.normal}};
    }
    for (int k = 0; k < 2; k++)
        if (from->span[k] != to->span[k]) {
            across = k;
            differ++;
        }
    if (differ != 1)
        return unfolding;
    const struct surface_axis *axis = &surface->axis[across];
    int a = from->span[across], b = to->span[across], last = axis->span_count - 1;
    bool up = b == a + 1 || (axis->closed && a == last && b == 0 && last > 1);
    bool down = b == a - 1 || (axis->closed && a == 0 && b == last && last > 1);
    if (!up && !down)
        return unfolding;
    double knot = axis->breaks[a + up] + from->turn[across], uv[2];
    double share = (knot - from->uv[across]) / (to->uv[across] - from->uv[across]);
    share = share >= 0 && share <= 1 ? share : 0.5;
    uv[across] = knot;
    uv[1 - across] = from->uv[1 - across] + share * (to->uv[1 - across] - from->uv[1 - across]);
    struct vec3 other;
    knot_frame(surface, from, across, uv, unfolding.from, &unfolding.at);
    knot_frame(surface, to, across, uv, unfolding.to, &other);
    unfolding.flat = false;
    return unfolding;
}

struct vec3 unfolding_back(const struct unfolding *unfolding, struct vec3 v) {
    struct vec3 sum = vec3_make(0, 0, 0);
    if (unfolding->flat)
        return v;
    for (int k = 0; k < 3; k++)
        sum = vec3_axpy(vec3_dot(v, unfolding->to[k]), unfolding->from[k], sum);
    return sum;
}

/* Planes that meet at more than 179 degrees, or not at all, as a cosine and the square of a sine.
 */
static const double folded_back = -0.9998, no_fold2 = 1e-12;

/* Rodrigues' formula, with the axis from x to = sin a. */
struct vec3 unfolding_turned(struct vec3 direction, struct vec3 from, struct vec3 to) {
    struct vec3 axis = vec3_cross(from, to);
    double cosine = vec3_dot(from, to);
    if (!(cosine > folded_back) || (cosine > 0 && vec3_norm2(axis) < no_fold2))
        return direction;
    struct vec3 turned = vec3_add(vec3_scale(cosine, direction), vec3_cross(axis, direction));
    return vec3_axpy(vec3_dot(axis, direction) / (1 + cosine), axis, turned);
}

struct unfolding_side unfolding_path(const struct path *path, struct vec3 r) {
    return (struct unfolding_side){.surface = path->surface,
                                   .span = {path->span[0], path->span[1]},
                                   .turn = {path->turn[0], path->turn[1]},
                                   .uv = {path->uv[0], path->uv[1]},
                                   .r = r};
}

struct unfolding_side unfolding_point(const struct surface_point *point) {
    const struct surface *surface = point->surface;
    struct unfolding_side side = {
        .surface = surface, .uv = {point->uv[0], point->uv[1]}, .r = point->jet.r, .point = point};
    for (int k = 0; k < 2; k++) {
        double wrapped = surface_axis_wrap(&surface->axis[k], point->uv[k]);
        side.turn[k] = point->uv[k] - wrapped;
        side.span[k] = surface_axis_span(&surface->axis[k], 0, wrapped);
    }
    return side;
}

struct vec3 unfolding_gap(const struct unfolding_side *from, const struct unfolding_side *to,
                          const struct unfolding *unfolding) {
    if (unfolding->flat)
        return vec3_sub(to->r, from->r);
    struct vec3 beyond = unfolding_back(unfolding, vec3_sub(to->r, unfolding->at));
    return vec3_add(vec3_sub(unfolding->at, from->r), beyond);
}
