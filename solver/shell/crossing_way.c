/* SPDX-License-Identifier: MIT */
/* Straight ways over a face of a shell, and the joints that they leave it through. */
#include "crossing.h"

#include "faces.h"

/* Joints that a way meets within this share of it are met at one place. */
static const double as_near = 1e-9;

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
    double least, t;          /* the share of the way, and the place of the edge */
    double off;               /* how far that is beyond an open end, in domains; 0: on the edge */
    int32_t edge;             /* -1: none */
};

/* A line from a by s in which an edge runs, or goes on beyond an open end; t there. */
struct line {
    double a[2], s[2], t[2];
    double low, high; /* shares of s that count */
    bool beyond_end;
};

/* Takes a line where the way leaves the region through it: from its left to its right if the face
 * lies to the left of it. */
static void leave_through(struct leaving *leaving, int32_t number, const struct line *line) {
    const struct surface *surface = leaving->surface;
    const double *p = leaving->p, *e = leaving->e, *s = line->s;
    double ax = face_way(&surface->axis[0], p[0], line->a[0]);
    double ay = face_way(&surface->axis[1], p[1], line->a[1]);
    double cross = e[0] * s[1] - e[1] * s[0];
    if (!(cross * surface->shell->edges[number].inside > 0))
        return;
    double share = (ax * s[1] - ay * s[0]) / cross, at = (ax * e[1] - ay * e[0]) / cross;
    if (!(share >= -as_near && share <= 1 && at >= line->low && at <= line->high))
        return;
    double met = fmax(share, 0);
    /* just past the line: that may lie on the boundary itself */
    double past = met + touch / (fabs(e[0]) * leaving->by[0] + fabs(e[1]) * leaving->by[1]);
    const double there[2] = {p[0] + past * e[0], p[1] + past * e[1]};
    /* Joints of one line meet the way at one place: the one whose end is nearer goes first. */
    const double *by = leaving->by;
    double off = line->beyond_end ? fabs(at) * (fabs(s[0]) * by[0] + fabs(s[1]) * by[1]) : 0;
    bool first = fabs(met - leaving->least) <= as_near ? off < leaving->off : met < leaving->least;
    if (first && (!line->beyond_end || !face_contains(face_of_surface(surface), there))) {
        leaving->least = met;
        leaving->edge = number;
        leaving->t = line->t[0] + at * (line->t[1] - line->t[0]);
        leaving->off = off;
    }
}

/* The same of a segment, and of what goes on beyond the open ends of its edge that it ends at. */
static void leave_segment(struct leaving *leaving, const struct face_segment *segment, bool near) {
    const struct face_edge *edge = &leaving->surface->shell->edges[segment->edge];
    const double *a = segment->a, *b = segment->b, *by = leaving->by, *t = segment->t;
    double sx = b[0] - a[0], sy = b[1] - a[1],
           slack = touch / (fabs(sx) * by[0] + fabs(sy) * by[1]);
    struct line line = {{a[0], a[1]}, {sx, sy}, {t[0], t[1]}, -slack, 1 + slack, false};
    if (near)
        leave_through(leaving, segment->edge, &line);
    for (int k = 0; k < 2; k++) {
        const double *end = k ? b : a, *rate = edge->beyond[k];
        if (!edge->open[k] || t[k] != edge->t[k])
            continue;
        double next = touch / (fabs(rate[0]) * by[0] + fabs(rate[1]) * by[1]);
        line = (struct line){{end[0], end[1]},     {rate[0], rate[1]},   {t[k], t[k] + 1},
                             k ? next : -HUGE_VAL, k ? HUGE_VAL : -next, true};
        leave_through(leaving, segment->edge, &line);
    }
}

/* Whether a run has the segment at an open end of its edge. */
static bool ends_open(const struct face *face, const struct face_run *run,
                      const struct face_edge *edge) {
    const struct face_segment *first = &face->segments[run->first], *last = first + run->count - 1;
    return (edge->open[0] && first->t[0] == edge->t[0]) ||
           (edge->open[1] && last->t[1] == edge->t[1]);
}

bool crossing_leaves(const struct surface *surface, const double from[2], const double to[2],
                     struct crossing_exit *exit) {
    const struct face *face = face_of_surface(surface);
    struct leaving leaving = {.surface = surface, .least = HUGE_VAL, .edge = -1};
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
            leave_segment(&leaving, &face->segments[run->first + s], near);
        r = may ? r + 1 : run->next;
    }
    *exit = (struct crossing_exit){leaving.least, leaving.t, leaving.edge};
    return leaving.edge >= 0;
}

bool crossing_on_way(const struct surface *surface, const double from[2], const double to[2],
                     double *share, struct crossing *crossing) {
    struct crossing_exit exit;
    if (!crossing_leaves(surface, from, to, &exit))
        return false;
    *share = exit.share;
    crossing->number = exit.edge;
    crossing->distance = 0;
    for (int k = 0; k < 2; k++)
        crossing->edge[k] = from[k] + exit.share * (to[k] - from[k]);
    return crossing_move(surface, exit.t, crossing);
}
