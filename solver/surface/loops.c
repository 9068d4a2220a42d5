/* SPDX-License-Identifier: MIT */
#include "loops.h"

#include <stdlib.h>

/* How far apart ends of curves are no longer one, as a share of the domain; how narrow what
 * is gone round wrongly may be, as a share of the loop's extent. */
static const double meeting = 1e-4, narrow = 1e-3;

/* Lines that a loop is looked at along, fewer for loops of very many edges. */
enum { LINES_MOST = 256, LINES_LEAST = 16, CROSSINGS_MOST = 1 << 20 };

/* ---- ends ---- */

/* Whether the ends of curves that follow each other are one point: in the domain, or in space. */
static bool is_closed_loop(const struct trim_loop *loop, const struct surface *surface,
                           double tolerance, struct loop_fault *fault) {
    if (loop->count == 1 && !loop->curves[0].knots)
        return true;
    struct surface_cursor cursor = {0};
    double low[2], high[2], at[2][2];
    surface_domain(surface, low, high);
    for (size_t k = 0; k < loop->count; k++) {
        double next[2];
        bool near = true;
        struct surface_jet jet[2];
        trim_curve_end(&loop->curves[k], 1, fault->uv);
        trim_curve_end(&loop->curves[(k + 1) % loop->count], 0, next);
        for (int x = 0; x < 2; x++) {
            fault->gap[x] = next[x] - fault->uv[x];
            near = near && fabs(fault->gap[x]) <= meeting * (high[x] - low[x]);
            at[0][x] = fmin(fmax(fault->uv[x], low[x]), high[x]);
            at[1][x] = fmin(fmax(next[x], low[x]), high[x]);
        }
        for (int n = 0; n < 2 && !near; n++)
            surface_evaluate(surface, &cursor, at[n][0], at[n][1], &jet[n]);
        if (!near && !(vec3_distance(jet[0].r, jet[1].r) <= tolerance))
            return false;
    }
    return true;
}

/* ---- winding ---- */

/* Where a line of constant y meets the loop; `turn` is 1 where that goes towards larger y, -1 where
 * down. */
struct crossing {
    size_t line;
    double x;
    int turn;
};

static int compare_loop_crossings(const void *a, const void *b) {
    const struct crossing *p = a, *q = b;
    if (p->line != q->line)
        return p->line < q->line ? -1 : 1;
    return (p->x > q->x) - (p->x < q->x);
}

/* A closed polyline, seen along direction `along`: x is the coordinate along, y across. */
struct view {
    const double (*points)[2];
    size_t count;
    int along;
    double low[2], high[2]; /* x, y */
    size_t lines;
};

static double coordinate(const struct view *view, size_t k, int axis) {
    return view->points[k % view->count][axis == 0 ? view->along : 1 - view->along];
}

static double height(const struct view *view, size_t line) {
    return view->low[1] +
           ((double)line + 0.5) / (double)view->lines * (view->high[1] - view->low[1]);
}

/* The first line at y or above. */
static size_t line_from(const struct view *view, double y) {
    double share = (y - view->low[1]) / (view->high[1] - view->low[1]) * (double)view->lines - 0.5;
    size_t line = share > 0 ? (size_t)ceil(share) : 0;
    line = line < view->lines ? line : view->lines;
    while (line > 0 && height(view, line - 1) >= y)
        line--;
    while (line < view->lines && height(view, line) < y)
        line++;
    return line;
}

/* Where the lines meet the loop, into `to` (NULL: counted alone). */
static size_t cross_loop(const struct view *view, struct crossing *to) {
    size_t count = 0;
    for (size_t k = 0; k < view->count; k++) {
        double a[2], b[2];
        for (int axis = 0; axis < 2; axis++) {
            a[axis] = coordinate(view, k, axis);
            b[axis] = coordinate(view, k + 1, axis);
        }
        size_t from = line_from(view, fmin(a[1], b[1])), end = line_from(view, fmax(a[1], b[1]));
        for (size_t line = from; to && line < end; line++) {
            double share = (height(view, line) - a[1]) / (b[1] - a[1]);
            to[count + line - from] = (struct crossing){
                .line = line, .x = a[0] + share * (b[0] - a[0]), .turn = b[1] > a[1] ? 1 : -1};
        }
        count += end - from;
    }
    return count;
}

/* Whether the loop goes round every point of the lines once in one sense, or not at all. */
static enum status is_simple(const struct trim *trim, size_t loop, struct arena *arena,
                             struct loop_fault *fault, bool *simple) {
    struct view view;
    *simple = true;
    view.count = trim_loop_points(trim, loop, &view.points);
    size_t lines = view.count > 0 ? CROSSINGS_MOST / view.count : 0;
    view.lines = lines < LINES_LEAST ? LINES_LEAST : lines > LINES_MOST ? LINES_MOST : lines;
    for (int along = 0; along < 2 && *simple && view.count > 2; along++) {
        struct arena_mark mark = arena_mark(arena);
        view.along = along;
        for (int axis = 0; axis < 2; axis++) {
            view.low[axis] = view.high[axis] = coordinate(&view, 0, axis);
            for (size_t k = 1; k < view.count; k++) {
                view.low[axis] = fmin(view.low[axis], coordinate(&view, k, axis));
                view.high[axis] = fmax(view.high[axis], coordinate(&view, k, axis));
            }
        }
        if (!(view.high[1] > view.low[1]))
            return STATUS_OK;
        size_t count = cross_loop(&view, NULL);
        struct crossing *crossings = arena_take(arena, count + 1, sizeof *crossings);
        if (!crossings)
            return STATUS_OUT_OF_MEMORY;
        cross_loop(&view, crossings);
        qsort(crossings, count, sizeof *crossings, compare_loop_crossings);
        double area = 0;
        for (size_t k = 0; k < view.count; k++)
            area += (coordinate(&view, k, 0) - view.low[0]) * coordinate(&view, k + 1, 1) -
                    (coordinate(&view, k + 1, 0) - view.low[0]) * coordinate(&view, k, 1);
        /* With its inside on the left it goes down first. */
        int winding = 0, sign = area > 0 ? -1 : 1;
        double least = narrow * (view.high[0] - view.low[0]);
        for (size_t k = 0; k + 1 < count && *simple; k++) {
            const struct crossing *at = &crossings[k], *next = at + 1;
            winding = k > 0 && at->line != at[-1].line ? at->turn : winding + at->turn;
            *simple = at->line != next->line || !(next->x - at->x > least) || winding == 0 ||
                      winding == sign;
            if (!*simple) {
                fault->uv[along] = (at->x + next->x) / 2;
                fault->uv[1 - along] = height(&view, at->line);
            }
        }
        arena_rewind(arena, mark);
    }
    return STATUS_OK;
}

enum status loops_check(const struct trim_loop *loops, const struct trim *trim,
                        const struct surface *surface, double tolerance, struct arena *arena,
                        struct loop_fault *fault) {
    *fault = (struct loop_fault){.kind = LOOP_SOUND};
    for (size_t k = 0; k < trim_loop_count(trim); k++) {
        bool simple;
        fault->loop = k;
        if (!is_closed_loop(&loops[k], surface, tolerance, fault)) {
            fault->kind = LOOP_OPEN;
            return STATUS_OK;
        }
        enum status status = is_simple(trim, k, arena, fault, &simple);
        if (status != STATUS_OK)
            return status;
        if (!simple) {
            fault->kind = LOOP_CROSSES;
            return STATUS_OK;
        }
    }
    return STATUS_OK;
}
