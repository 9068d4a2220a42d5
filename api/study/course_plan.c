/* SPDX-License-Identifier: MIT */
#include "course_plan.h"

#include <math.h>
#include <string.h>

/* How many values each kind of unknown has, in their order. */
enum plan_kind { PLAN_FIRST, PLAN_GAP, PLAN_ORIGIN, PLAN_WIDTH, PLAN_KINDS };

static const struct study_span *span_of(const struct study_courses *c, enum plan_kind kind) {
    const struct study_span *spans[] = {&c->first, &c->gap, &c->origin, &c->width};
    return spans[kind];
}

/* Neighbours with distances of their own. */
static size_t gap_count(const struct study_courses *c) {
    return c->count > 1 ? c->count - 1 : 1;
}

static size_t values_of(const struct study_courses *c, enum plan_kind kind) {
    size_t each = kind == PLAN_FIRST ? 1 : kind == PLAN_GAP ? gap_count(c) : c->count;
    return each * span_of(c, kind)->points;
}

size_t course_plan_unknowns(const struct study_courses *courses) {
    size_t count = 0;
    for (int kind = 0; kind < PLAN_KINDS; kind++)
        count += values_of(courses, (enum plan_kind)kind);
    return count;
}

struct study_span course_plan_span(const struct study_courses *courses, size_t k) {
    enum plan_kind kind = PLAN_FIRST;
    for (; kind < PLAN_WIDTH && k >= values_of(courses, kind); kind++)
        k -= values_of(courses, kind);
    if (kind == PLAN_WIDTH && courses->widths)
        return (struct study_span){1, 0, (double)courses->width_count};
    return *span_of(courses, kind);
}

static size_t least_size(size_t a, size_t b) {
    return a < b ? a : b;
}

/* Value n of `wanted`, of a list that may have fewer or more; 0 of none. */
static double spread_value(const double *values, size_t count, size_t n, size_t wanted) {
    double at = wanted > 1 ? (double)(n * (count - 1)) / (double)(wanted - 1) : 0;
    return count ? values[(size_t)(at + 0.5)] : 0;
}

static const struct courses_offset *gap_at(const struct courses_settings *lay, size_t n) {
    return &lay->gaps[least_size(n, lay->gap_count - 1)];
}

/* Which of the widths there are is the nearest. */
static double nearest_width(const struct study_courses *c, double width) {
    size_t best = 0;
    for (size_t k = 1; k < c->width_count; k++)
        if (fabs(c->widths[k] - width) < fabs(c->widths[best] - width))
            best = k;
    return (double)best + 0.5;
}

void course_plan_begin(const struct study_courses *c, double *unknowns) {
    const struct courses_settings *lay = &c->base->lay;
    size_t k = 0, points = c->gap.points;
    for (size_t n = 0; n < c->first.points; n++)
        unknowns[k++] = spread_value(lay->first.values, lay->first.count, n, c->first.points);
    for (size_t n = 0; points && n < gap_count(c); n++)
        for (size_t p = 0; p < points; p++)
            unknowns[k++] = spread_value(gap_at(lay, n)->values, gap_at(lay, n)->count, p, points);
    for (size_t n = 0; c->origin.points && n < c->count; n++)
        unknowns[k++] = courses_value(lay->origins, lay->origin_count, n, 0.5);
    for (size_t n = 0; c->width.points && n < c->count; n++) {
        double width = courses_value(lay->widths, lay->width_count, n, 0);
        unknowns[k++] = c->widths ? nearest_width(c, width) : width;
    }
    for (size_t n = 0; n < k; n++) {
        struct study_span span = course_plan_span(c, n);
        unknowns[n] = fmin(fmax(unknowns[n], span.from), span.to);
    }
}

void course_plan_make(const struct study_courses *c, const double *unknowns,
                      struct course_plan *plan) {
    const struct courses_settings *lay = &c->base->lay;
    const double *gaps = unknowns + values_of(c, PLAN_FIRST);
    const double *origins = gaps + values_of(c, PLAN_GAP);
    const double *widths = origins + values_of(c, PLAN_ORIGIN);
    size_t all = c->count, points = c->gap.points;
    all = lay->width_count > all ? lay->width_count : all;
    all = lay->origin_count > all ? lay->origin_count : all;
    all = lay->gap_count + 1 > all && lay->gap_count > 1 ? lay->gap_count + 1 : all;
    all = least_size(all, STUDY_COURSES_MAX);
    *plan = (struct course_plan){.count = all, .lay = *lay};
    plan->lay.wanted = c->wanted;
    plan->lay.first = (struct courses_offset){plan->first, 1};
    if (c->first.points)
        plan->lay.first.count = c->first.points;
    else if (lay->first.count)
        plan->lay.first.count = lay->first.count;
    const double *first = c->first.points ? unknowns : lay->first.values;
    if (first)
        memcpy(plan->first, first, plan->lay.first.count * sizeof *first);
    for (size_t n = 0; n < all; n++) {
        size_t own = least_size(n, c->count - 1), gap = least_size(n, gap_count(c) - 1);
        const struct courses_offset *kept = gap_at(lay, n);
        const double *from = points ? gaps + gap * points : kept->values;
        plan->gaps[n] = (struct courses_offset){plan->gap[n], points ? points : kept->count};
        memcpy(plan->gap[n], from, plan->gaps[n].count * sizeof *from);
        plan->origin[n] = c->origin.points ? origins[own]
                                           : courses_value(lay->origins, lay->origin_count, n, 0.5);
        plan->width[n] = courses_value(lay->widths, lay->width_count, n, 0);
        if (c->width.points)
            plan->width[n] = widths[own];
        if (c->width.points && c->widths)
            plan->width[n] = c->widths[least_size((size_t)widths[own], c->width_count - 1)];
    }
    plan->lay.gaps = plan->gaps;
    plan->lay.gap_count = all > 1 ? all - 1 : 1;
    plan->lay.origins = plan->origin;
    plan->lay.origin_count = plan->lay.width_count = all;
    plan->lay.widths = plan->width;
}
