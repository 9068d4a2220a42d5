/* SPDX-License-Identifier: MIT */
/* Straight ways over a face of a shell, and the joints that they leave it through. */
#include "crossing.h"

#include "faces.h"

/* Joints that a way meets within this share of it are met at one place. */
static const double as_near = 1e-9;

/* A joint goes on beyond an open end for so many lengths of the domain: as far as any path. */
static const double open_reach = HUGE_VAL;

/* A way that misses the end of a segment by this share of the domain goes through it. */
static const double touch = 1e-9;

bool crossing_all_within(const struct surface *surface, const double low[2], const double high[2]) {
    return face_holds_way(face_of_surface(surface), low, high);
}

/* A straight way over a face, from p by e, and the joint that it leaves the region through first.
 */
struct leaving {
    const struct surface *surface;
    double p[2], e[2], by[2]; /* `by` is one by the domain's lengths */
    double least, place;      /* shares of the way and of the segment */
    double past; /* how far beyond an open end the place is, by the domain; 0: on the segment */
    const struct face_segment *segment;
};

/* Takes the segment s, from a on, where the way leaves the region through it, or beyond an open end
 * of its edge: from its left to its right if the face lies to the left of it. */
static void leave_through(struct leaving *leaving, const struct face_segment *segment) {
    const struct surface *surface = leaving->surface;
    const struct face_edge *edge = &surface->shell->edges[segment->edge];
    const double *p = leaving->p, *e = leaving->e, *by = leaving->by;
    double from[2], to[2], reach[2];
    for (int k = 0; k < 2; k++) {
        bool open = edge->open[k] && segment->t[k] == edge->t[k];
        from[k] = p[k] + face_way(&surface->axis[k], p[k], segment->a[k]);
        to[k] = from[k] + segment->b[k] - segment->a[k];
        reach[k] = open ? open_reach : touch;
    }
    double sx = to[0] - from[0], sy = to[1] - from[1], ax = from[0] - p[0], ay = from[1] - p[1];
    double cross = e[0] * sy - e[1] * sx;
    if (!(cross * edge->inside > 0))
        return;
    double share = (ax * sy - ay * sx) / cross, at = (ax * e[1] - ay * e[0]) / cross;
    double whole = 1 / (fabs(sx) * by[0] + fabs(sy) * by[1]);
    if (!(share >= -as_near && share <= 1 && at >= -reach[0] * whole && at <= 1 + reach[1] * whole))
        return;
    double met = fmax(share, 0);
    const double there[2] = {p[0] + met * e[0], p[1] + met * e[1]};
    double off = fmax(-at, at - 1), past = off > touch ? off / whole : 0;
    /* Joints of one line meet the way at one place: the one whose end is nearest goes first. */
    double ahead = leaving->past == past ? 0 : past > leaving->past ? -as_near : as_near;
    if (met < leaving->least + ahead &&
        (past == 0 || !face_contains(face_of_surface(surface), there))) {
        leaving->least = met;
        leaving->segment = segment;
        leaving->place = at;
        leaving->past = past;
    }
}

/* Whether a run has the segment at an open end of its edge. */
static bool ends_open(const struct face *face, const struct face_run *run,
                      const struct face_edge *edge) {
    const struct face_segment *first = &face->segments[run->first], *last = first + run->count - 1;
    return (edge->open[0] && first->t[0] == edge->t[0]) ||
           (edge->open[1] && last->t[1] == edge->t[1]);
}

bool crossing_on_way(const struct surface *surface, const double from[2], const double to[2],
                     double *share, struct crossing *crossing) {
    const struct face *face = face_of_surface(surface);
    struct leaving leaving = {.surface = surface, .least = HUGE_VAL};
    double end[2];
    for (int k = 0; k < 2; k++) {
        const struct surface_axis *axis = &surface->axis[k];
        /* in the turn of closed directions that is the domain */
        leaving.p[k] = from[k] - (from[k] - surface_axis_wrap(axis, from[k]));
        leaving.e[k] = to[k] - from[k];
        leaving.by[k] = 1 / surface_axis_length(axis);
        end[k] = leaving.p[k] + leaving.e[k];
    }
    if (face_holds_way(face, leaving.p, end))
        return false;
    for (uint32_t r = 0; r < face->run_count;) {
        /* those of joints that lie near, or at an open end, beyond which they go on */
        const struct face_run *run = &face->runs[r];
        const struct face_edge *edge = &surface->shell->edges[run->edge];
        bool near = true;
        for (int k = 0; k < 2; k++) {
            double off = fabs(face_way(&surface->axis[k], leaving.p[k], run->centre[k]));
            double reach = fabs(leaving.e[k]);
            near = near && !(off - run->half[k] > reach + 2 * touch * (reach + 1 / leaving.by[k]));
        }
        bool may = edge->mate != EDGE_FREE && (near || ends_open(face, run, edge));
        bool leaf = run->next == r + 1;
        for (uint32_t s = 0; s < run->count && may && leaf; s++)
            leave_through(&leaving, &face->segments[run->first + s]);
        r = may ? r + 1 : run->next;
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
