/* SPDX-License-Identifier: MIT */
#include "measure.h"
#include "bounds.h"
#include "surface.h"

/* Points of 32 bytes, and as much again in powers where the degrees are low. */
enum { SPAN_POINT_BYTES = 64 };

int64_t surface_span_bytes(const struct nurbs *nurbs) {
    int64_t spans = (int64_t)(nurbs->u.size - nurbs->u.degree) * (nurbs->v.size - nurbs->v.degree);
    return spans * (nurbs->u.degree + 1) * (nurbs->v.degree + 1) * SPAN_POINT_BYTES;
}

/* The strip at span [t_l, t_(l+1)] of `direction`: degree + 1 control points, gathered in the
 * arena, between the 2 degree + 2 knots around the span, unclamped. */
static enum status gather_strip(const struct nurbs *nurbs, int direction, int l,
                                struct arena *arena, struct nurbs *strip) {
    int first[2] = {0, 0};
    *strip = *nurbs;
    struct nurbs_axis *axis = direction == 0 ? &strip->u : &strip->v;
    int p = axis->degree;
    first[direction] = l - p;
    *axis = (struct nurbs_axis){p, p + 1, axis->knots + l - p, (size_t)(2 * p + 2)};
    size_t width = (size_t)strip->v.size, count = (size_t)strip->u.size * width;
    struct vec3 *points = arena_take(arena, count, sizeof *points);
    double *weights = arena_take(arena, count, sizeof *weights);
    if (!points || !weights)
        return STATUS_OUT_OF_MEMORY;
    for (size_t k = 0; k < count; k++) {
        size_t i = (size_t)first[0] + k / width, j = (size_t)first[1] + k % width;
        points[k] = nurbs->points[i * (size_t)nurbs->v.size + j];
        weights[k] = nurbs->weights ? nurbs->weights[i * (size_t)nurbs->v.size + j] : 1;
    }
    strip->points = points;
    strip->point_count = count;
    strip->weights = nurbs->weights ? weights : NULL;
    strip->weight_count = nurbs->weights ? count : 0;
    return STATUS_OK;
}

/* A strip without area is part of many a good surface. */
static enum status measure_strip(const struct nurbs *strip, int direction, bool first,
                                 struct arena *arena, struct surface_measure *measure) {
    struct surface *surface;
    struct vec3 lower, upper;
    enum status status = surface_make(strip, arena, &surface);
    if (status != STATUS_OK && status != STATUS_DEGENERATE_SURFACE)
        return status;
    measure->closed[1 - direction] =
        measure->closed[1 - direction] && surface_closed(surface, 1 - direction);
    if (direction == 1)
        return STATUS_OK;
    if (status == STATUS_OK)
        measure->area += surface_area(surface, NULL);
    surface_bounds(surface, &lower, &upper);
    const struct vec3 *low = &measure->lower, *high = &measure->upper;
    if (!first && low->x <= lower.x && low->y <= lower.y && low->z <= lower.z &&
        upper.x <= high->x && upper.y <= high->y && upper.z <= high->z)
        return STATUS_OK;
    bounds_tight(surface, &lower, &upper);
    if (first) {
        measure->lower = lower;
        measure->upper = upper;
    }
    measure->lower = vec3_min(measure->lower, lower);
    measure->upper = vec3_max(measure->upper, upper);
    return STATUS_OK;
}

/* All strips of a direction: those of u give area and box, and whether v is closed; those of v
 * whether u is, until one of them is not. */
static enum status add_strips(const struct nurbs *nurbs, int direction, struct arena *arena,
                              struct surface_measure *measure) {
    const struct nurbs_axis *axis = direction == 0 ? &nurbs->u : &nurbs->v;
    bool first = true;
    for (int l = axis->degree; l < axis->size; l++) {
        struct arena_mark mark = arena_mark(arena);
        struct nurbs strip;
        if (!(axis->knots[l + 1] > axis->knots[l]))
            continue;
        if (direction == 1 && !measure->closed[0])
            break;
        enum status status = gather_strip(nurbs, direction, l, arena, &strip);
        if (status == STATUS_OK)
            status = measure_strip(&strip, direction, first, arena, measure);
        arena_rewind(arena, mark);
        if (status != STATUS_OK)
            return status;
        first = false;
    }
    return STATUS_OK;
}

enum status surface_measure(const struct nurbs *nurbs, struct arena *arena,
                            struct surface_measure *measure) {
    *measure = (struct surface_measure){.closed = {true, true}};
    enum status status = add_strips(nurbs, 0, arena, measure);
    if (status == STATUS_OK)
        status = add_strips(nurbs, 1, arena, measure);
    if (status == STATUS_OK && !(measure->area > 0))
        status = STATUS_DEGENERATE_SURFACE;
    return status;
}
