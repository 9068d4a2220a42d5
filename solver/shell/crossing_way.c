/* SPDX-License-Identifier: MIT */
/* Straight ways over a face of a shell, and the joints that they leave it through. */
#include "crossing.h"

#include "faces.h"

/* Joints that a way meets within this share of it are met at one place. */
static const double as_near = 1e-9;

/* A joint goes on beyond an open end for so many lengths of the domain: further than any path. */
static const double open_reach = 2;

/* A way that misses the end of a segment by this share of the domain goes through it. */
static const double touch = 1e-9;

static const struct face *face_of(const struct surface *surface) {
    return &surface->shell->faces[surface->face];
}

/* What takes a place into the domain of closed directions. */
static void turn_of(const struct surface *surface, const double uv[2], double turn[2]) {
    for (int k = 0; k < 2; k++)
        turn[k] = uv[k] - surface_axis_wrap(&surface->axis[k], uv[k]);
}

bool crossing_none_within(const struct surface *surface, const double low[2],
                          const double high[2]) {
    return face_holds_way(face_of(surface), low, high);
}

/* A straight way over a face, from p by e, and the joint that it leaves the region through first.
 */
struct leaving {
    const struct surface *surface;
    double p[2], e[2], by[2]; /* `by` is one by the domain's lengths */
    double least, place;      /* shares of the way and of the segment */
    bool beyond_end;          /* the place is not on the segment, but beyond an open end */
    const struct face_segment *segment;
};

/* The share of the way at which it leaves the region through a segment from a to b, whose inside
 * lies as the edge says; HUGE_VAL where it does not. `at` gets the share of the segment. */
static double leaves_through(const struct leaving *way, const double a[2], const double b[2],
                             int inside, const bool open[2], double *at) {
    const double *p = way->p, *e = way->e, *by = way->by;
    double sx = b[0] - a[0], sy = b[1] - a[1];
    double out = (e[0] * sy - e[1] * sx) * inside; /* > 0: from left to right of the segment */
    if (!(out > 0))
        return HUGE_VAL;
    double cross = e[0] * sy - e[1] * sx;
    double ax = a[0] - p[0], ay = a[1] - p[1];
    double share = (ax * sy - ay * sx) / cross;
    *at = (ax * e[1] - ay * e[0]) / cross;
    double whole = 1 / (fabs(sx) * by[0] + fabs(sy) * by[1]);
    bool hits = share >= -as_near && share <= 1 && *at >= -(open[0] ? open_reach : touch) * whole &&
                *at <= 1 + (open[1] ? open_reach : touch) * whole;
    return hits ? fmax(share, 0) : HUGE_VAL;
}

static void leave_through(struct leaving *leaving, const struct face_segment *segment) {
    const struct surface *surface = leaving->surface;
    const struct face_edge *edge = &surface->shell->edges[segment->edge];
    const bool open[2] = {edge->open[0] && segment->t[0] == edge->t[0],
                          edge->open[1] && segment->t[1] == edge->t[1]};
    double a[2], b[2], at;
    for (int k = 0; k < 2; k++) {
        a[k] = leaving->p[k] + face_way(&surface->axis[k], leaving->p[k], segment->a[k]);
        b[k] = a[k] + segment->b[k] - segment->a[k];
    }
    double met = leaves_through(leaving, a, b, edge->inside, open, &at);
    if (met == HUGE_VAL)
        return;
    const double there[2] = {leaving->p[0] + met * leaving->e[0],
                             leaving->p[1] + met * leaving->e[1]};
    bool beyond_end = fmax(-at, at - 1) > touch;
    /* Joints of one line meet the way at one place: the one that is there goes first. */
    double ahead = leaving->beyond_end == beyond_end ? 0 : beyond_end ? -as_near : as_near;
    if (met < leaving->least + ahead && (!beyond_end || !face_contains(face_of(surface), there))) {
        leaving->least = met;
        leaving->segment = segment;
        leaving->place = at;
        leaving->beyond_end = beyond_end;
    }
}

/* Whether a way has to be held against the segments of a run: they belong to a joint, and lie near
 * it or at an open end, beyond which the joint goes on. */
static bool may_leave_through(const struct leaving *leaving, const struct face_run *run) {
    const struct surface *surface = leaving->surface;
    const struct face_edge *edge = &surface->shell->edges[run->edge];
    bool near = true;
    for (int k = 0; k < 2; k++) {
        double off =
            fabs(face_way(&surface->axis[k], leaving->p[k], run->centre[k])) - run->half[k];
        double reach = fabs(leaving->e[k]);
        near = near && !(off > reach + 2 * touch * (reach + 1 / leaving->by[k]));
    }
    return edge->mate != EDGE_FREE && (near || edge->open[0] || edge->open[1]);
}

bool crossing_on_way(const struct surface *surface, const double from[2], const double to[2],
                     double *share, struct crossing *crossing) {
    const struct face *face = face_of(surface);
    struct leaving leaving = {.surface = surface, .least = HUGE_VAL};
    double turn[2], end[2];
    turn_of(surface, from, turn);
    for (int k = 0; k < 2; k++) {
        const struct surface_axis *axis = &surface->axis[k];
        leaving.p[k] = from[k] - turn[k];
        leaving.e[k] = to[k] - from[k];
        leaving.by[k] = 1 / (surface_axis_upper(axis) - surface_axis_lower(axis));
        end[k] = leaving.p[k] + leaving.e[k];
    }
    if (face_holds_way(face, leaving.p, end))
        return false;
    for (uint32_t r = 0; r < face->run_count; r++) {
        const struct face_run *run = &face->runs[r];
        bool may = may_leave_through(&leaving, run);
        for (uint32_t s = 0; s < run->count && may; s++)
            leave_through(&leaving, &face->segments[run->first + s]);
    }
    const struct face_segment *first = leaving.segment;
    if (!first)
        return false;
    double place = leaving.place;
    *share = leaving.least;
    const bool *open = surface->shell->edges[first->edge].open;
    place = open[0] ? place : fmax(place, 0);
    place = open[1] ? place : fmin(place, 1);
    crossing->number = first->edge;
    crossing->distance = 0;
    for (int k = 0; k < 2; k++)
        crossing->edge[k] = from[k] + *share * leaving.e[k];
    return crossing_move(surface, first->t[0] + place * (first->t[1] - first->t[0]), crossing);
}
