/* SPDX-License-Identifier: MIT */
#include "line.h"

#include "solver/path/path.h"
#include "solver/shell/crossing.h"
#include "solver/shell/shell.h"

#include <string.h>

/* The continuation beyond the part is followed so far, as a share of its size. */
static const double reach = 0.3;

/* ---- points to a line ---- */

enum { STENCIL = 7 };

/* The derivative at node k of the polynomial through `count` points, by Lagrange's weights: with
 * l_m the basis polynomials, l_m'(s_k) = prod_(n != m, k) (s_k - s_n) / prod_(n != m) (s_m - s_n),
 * and l_k' less the sum of all others. */
static struct vec3 derivative_at(const struct course_line *line, size_t first, size_t count,
                                 size_t k) {
    const double *s = line->s;
    struct vec3 sum = {0, 0, 0};
    for (size_t m = first; m < first + count; m++) {
        double weight = 1;
        if (m == k)
            continue;
        for (size_t n = first; n < first + count; n++) {
            weight *= n != m && n != k ? s[k] - s[n] : 1;
            weight /= n != m ? s[m] - s[n] : 1;
        }
        sum = vec3_axpy(weight, vec3_sub(line->at[m].jet.r, line->at[k].jet.r), sum);
    }
    return sum;
}

/* Arcs by their chords and the turn w of the tangent between the ends, exact on circles: with
 * x = sin(w / 2), half the tangents' difference, arc / chord = (w / 2) / x, the series of asin x /
 * x.
 */
static void measure_arcs(struct course_line *line, bool by_turn) {
    line->s[0] = 0;
    for (size_t k = 1; k < line->count; k++) {
        double chord = vec3_distance(line->at[k - 1].jet.r, line->at[k].jet.r);
        double x2 = by_turn ? vec3_norm2(vec3_sub(line->tangent[k], line->tangent[k - 1])) / 4 : 0;
        double longer = 1 + x2 * (1.0 / 6 + x2 * (3.0 / 40 + x2 * (5.0 / 112)));
        line->s[k] = line->s[k - 1] + chord * longer;
    }
}

static void find_tangents(struct course_line *line) {
    size_t count = line->count < STENCIL ? line->count : STENCIL;
    for (size_t k = 0; k < line->count; k++) {
        size_t first = k < count / 2 ? 0 : k - count / 2;
        first = first + count > line->count ? line->count - count : first;
        struct vec3 t = derivative_at(line, first, count, k);
        line->tangent[k] = surface_point_tangent(&line->at[k], t);
    }
}

void line_complete(struct course_line *line) {
    measure_arcs(line, false);
    find_tangents(line);
    measure_arcs(line, true);
    find_tangents(line);
    measure_arcs(line, true);
}

bool line_alloc(struct course_line *line, size_t count, struct arena *arena) {
    *line = (struct course_line){.at = arena_alloc(arena, count, sizeof *line->at),
                                 .tangent = arena_alloc(arena, count, sizeof *line->tangent),
                                 .s = arena_alloc(arena, count, sizeof *line->s)};
    return line->at && line->tangent && line->s;
}

/* ---- geodesics ---- */

/* Whether a line has gone too far beyond the part, or round a closed direction further than a net
 * goes from `start`. */
static bool is_beyond(const struct surface_point *point, const struct surface_point *start) {
    struct surface_cursor cursor = {0};
    enum drape_reason reason;
    const struct surface *surface = point->surface;
    if (!surface->shell)
        return surface_point_zone(surface, &cursor, start->uv, point, reach * surface->size,
                                  &reason) == SURFACE_POINT_BEYOND;
    struct crossing crossing;
    crossing_find(point, NULL, &crossing);
    return surface_point_zone_on_face(point, &crossing, reach * shell_size(surface->shell)) ==
           SURFACE_POINT_BEYOND;
}

/* Goes on from an end to the side `side`, 0 before the first point: up to `most` points, the next
 * one at `points` and then away from it by `sign`; how many there are. */
static size_t continue_line(const struct surface_point *from, struct vec3 tangent, int side,
                            double step, size_t most, struct surface_point *points,
                            struct vec3 *tangents) {
    struct surface_cursor cursor = {0};
    struct path path;
    int sign = side ? 1 : -1;
    size_t count = 0;
    bool going = path_geodesic(&path, from->surface, from, vec3_scale(sign, tangent));
    for (; going && count < most; count += going) {
        struct surface_point *at = side ? points + count : points - count;
        struct vec3 t;
        going = path_advance(&path, step) && path_surface_point(&path, &cursor, at, &t) &&
                !is_beyond(at, from);
        if (going)
            *(side ? tangents + count : tangents - count) = vec3_scale(sign, t);
    }
    return count;
}

enum status line_extend(struct course_line *line, double step, double most, struct arena *arena,
                        size_t *before) {
    struct course_line own = *line;
    size_t side = (size_t)fmin(most / step, 1e6) + 1;
    if (!line_alloc(line, own.count + 2 * side, arena))
        return STATUS_OUT_OF_MEMORY;
    memcpy(line->at + side, own.at, own.count * sizeof *own.at);
    memcpy(line->tangent + side, own.tangent, own.count * sizeof *own.tangent);
    size_t end = side + own.count;
    size_t low = continue_line(&own.at[0], own.tangent[0], 0, step, side, line->at + side - 1,
                               line->tangent + side - 1);
    size_t high = continue_line(&own.at[own.count - 1], own.tangent[own.count - 1], 1, step, side,
                                line->at + end, line->tangent + end);
    line->at += side - low;
    line->tangent += side - low;
    line->count = low + own.count + high;
    for (size_t k = 0; k < line->count; k++) {
        double at = k < low ? 0
                    : k < low + own.count
                        ? own.s[k - low]
                        : own.s[own.count - 1] + (double)(k - low - own.count + 1) * step;
        line->s[k] = k < low ? (double)k * step : (double)low * step + at;
    }
    *before = low;
    return line->count >= 2 ? STATUS_OK : STATUS_NO_CONVERGENCE;
}

/* ---- a place of the line ---- */

/* The interval k .. k + 1 in which s lies, an end's own beyond it. */
static size_t interval_of(const struct course_line *line, double s) {
    size_t low = 0, high = line->count - 1;
    while (high - low > 1) {
        size_t half = (low + high) / 2;
        if (line->s[half] <= s)
            low = half;
        else
            high = half;
    }
    return low;
}

/* The surface's place next to a target near it: by steps from the nearer end. */
static bool bring_down(struct surface_cursor *cursor, const struct surface_point *from,
                       struct vec3 target, struct surface_point *point) {
    enum { ROUNDS = 4 };
    *point = *from;
    for (int round = 0; round < ROUNDS; round++) {
        struct vec3 step = vec3_sub(target, point->jet.r);
        step = vec3_axpy(-vec3_dot(step, point->normal), point->normal, step);
        if (!surface_point_move(cursor, point, step, point))
            return false;
    }
    return !point->surface->shell || crossing_settle(cursor, point);
}

bool line_point(const struct course_line *line, double s, struct surface_cursor *cursor,
                struct surface_point *point, struct vec3 *tangent) {
    size_t k = interval_of(line, s), last = line->count - 1;
    if (s < 0 || s > line->s[last]) {
        struct path path;
        size_t end = s < 0 ? 0 : last;
        int sign = s < 0 ? -1 : 1;
        bool gone = path_geodesic(&path, line->at[end].surface, &line->at[end],
                                  vec3_scale(sign, line->tangent[end])) &&
                    path_advance(&path, s < 0 ? -s : s - line->s[last]) &&
                    path_surface_point(&path, cursor, point, tangent);
        *tangent = vec3_scale(sign, *tangent);
        return gone;
    }
    if (s == line->s[k] || s == line->s[k + 1]) {
        k += s == line->s[k + 1];
        *point = line->at[k];
        *tangent = line->tangent[k];
        return true;
    }
    double h = line->s[k + 1] - line->s[k], x = (s - line->s[k]) / h, y = 1 - x;
    struct vec3 a = line->at[k].jet.r, chord = vec3_sub(line->at[k + 1].jet.r, a);
    struct vec3 *t = &line->tangent[k];
    struct vec3 r = vec3_axpy(x * x * (1 + 2 * y), chord, a), slope;
    r = vec3_axpy(h * x * y * y, t[0], vec3_axpy(-h * x * x * y, t[1], r));
    slope = vec3_axpy(y * (y - 2 * x), t[0], vec3_scale(6 * x * y / h, chord));
    slope = vec3_axpy(x * (x - 2 * y), t[1], slope);
    if (!bring_down(cursor, &line->at[k + (x > 0.5)], r, point))
        return false;
    *tangent = surface_point_tangent(point, slope);
    return vec3_norm2(*tangent) > 0;
}

/* ---- parallels ---- */

/* De Casteljau's rule; beyond the ends the tangent there. */
double line_distance_at(const struct line_distance *distance, double s) {
    double b[LINE_VALUES_MAX], x = (s - distance->from) / (distance->to - distance->from);
    size_t n = distance->count < LINE_VALUES_MAX ? distance->count : LINE_VALUES_MAX;
    const double *v = distance->values;
    if (n == 1 || !(distance->to > distance->from))
        return v[0];
    if (x <= 0)
        return v[0] + x * (double)(n - 1) * (v[1] - v[0]);
    if (x >= 1)
        return v[n - 1] + (x - 1) * (double)(n - 1) * (v[n - 1] - v[n - 2]);
    for (size_t k = 0; k < n; k++)
        b[k] = v[k];
    for (size_t left = n - 1; left > 0; left--)
        for (size_t k = 0; k < left; k++)
            b[k] += x * (b[k + 1] - b[k]);
    return b[0];
}

/* The end of the geodesic that leaves the line at s, to `slack`, a length. */
static bool shoot(const struct course_line *line, const struct line_distance *distance, double s,
                  double slack, struct surface_cursor *cursor, struct surface_point *end) {
    struct surface_point from;
    struct vec3 t;
    struct path path;
    double h = line_distance_at(distance, s);
    if (!line_point(line, s, cursor, &from, &t))
        return false;
    *end = from;
    struct vec3 across = vec3_scale(h < 0 ? -1 : 1, vec3_cross(from.normal, t));
    if (h == 0)
        return true;
    bool gone = path_geodesic(&path, from.surface, &from, across);
    path.accuracy = slack / fabs(h);
    return gone && path_advance(&path, fabs(h)) && path_surface_point(&path, cursor, end, NULL);
}

/* The line's arc length below a length of the parallel: the polynomial through six points about it,
 * s[k] of the line at the parallel's x[k]. */
static double foot_below(const struct course_line *parallel, const double *s, double x) {
    enum { POINTS = 6 };
    size_t count = parallel->count < POINTS ? parallel->count : POINTS;
    size_t first = interval_of(parallel, x);
    first = first > POINTS / 2 - 1 ? first - (POINTS / 2 - 1) : 0;
    first = first + count > parallel->count ? parallel->count - count : first;
    double sum = 0;
    for (size_t m = first; m < first + count; m++) {
        double weight = 1;
        for (size_t n = first; n < first + count; n++)
            weight *= n != m ? (x - parallel->s[n]) / (parallel->s[m] - parallel->s[n]) : 1;
        sum += weight * s[m];
    }
    return sum;
}

/* The parallel's points below every `stride`-th of the line, from that next to `foot` to both sides
 * as long as they go on in the line's sense; s gets the line's arc lengths. */
static enum status find_feet(const struct course_line *line, const struct line_distance *distance,
                             double foot, double slack, size_t stride, struct arena *arena,
                             struct course_line *feet, double **s) {
    struct surface_cursor cursor = {0};
    size_t begin = interval_of(line, foot), before = begin / stride, low = before, high = before;
    size_t first = begin % stride, room = (line->count - 1 - first) / stride + 1;
    *s = arena_alloc(arena, room, sizeof **s);
    if (!*s || !line_alloc(feet, room, arena))
        return STATUS_OUT_OF_MEMORY;
    bool found = shoot(line, distance, line->s[begin], slack, &cursor, &feet->at[before]);
    for (int side = 0; side < 2 && found; side++)
        for (size_t k = before; side ? k + 1 < room : k > 0;) {
            size_t next = side ? k + 1 : k - 1, from = first + k * stride,
                   to = first + next * stride;
            if (!shoot(line, distance, line->s[to], slack, &cursor, &feet->at[next]))
                break;
            struct vec3 step = vec3_sub(feet->at[next].jet.r, feet->at[k].jet.r);
            struct vec3 own = vec3_sub(line->at[to].jet.r, line->at[from].jet.r);
            if (!(vec3_dot(step, own) > 0))
                break;
            k = next;
            *(side ? &high : &low) = k;
        }
    feet->at += low;
    feet->tangent += low;
    feet->s += low;
    feet->count = found ? high - low + 1 : 0;
    if (feet->count < 2)
        return STATUS_NO_CONVERGENCE;
    for (size_t k = 0; k < feet->count; k++)
        (*s)[k] = line->s[first + (low + k) * stride];
    line_complete(feet);
    return STATUS_OK;
}

/* Parallels that need not be more accurate, in shares of a step, have feet below every so many
 * points of the line: these tell no more than where along it geodesics are to leave. */
static const double wide_accuracy = 1e-6;
enum { WIDE_STRIDE = 2 };

enum status line_parallel(const struct course_line *line, const struct line_distance *distance,
                          double foot, double step, double accuracy, struct arena *arena,
                          struct course_line *parallel, size_t *middle) {
    struct surface_cursor cursor = {0};
    struct course_line feet;
    double *s, slack = accuracy * step;
    size_t stride = accuracy > wide_accuracy ? WIDE_STRIDE : 1;
    enum status status = find_feet(line, distance, foot, slack, stride, arena, &feet, &s);
    if (status != STATUS_OK)
        return status;
    /* Where the foot is along the parallel, by the points on both sides of it. */
    size_t k = 0;
    while (k + 2 < feet.count && s[k + 1] <= foot)
        k++;
    double x = feet.s[k] + (feet.s[k + 1] - feet.s[k]) * (foot - s[k]) / (s[k + 1] - s[k]);
    double length = feet.s[feet.count - 1];
    x = fmin(fmax(x, 0), length);
    size_t before = (size_t)(x / step), count = before + (size_t)((length - x) / step) + 1;
    if (!line_alloc(parallel, count, arena))
        return STATUS_OUT_OF_MEMORY;
    size_t low = 0;
    parallel->count = 0;
    for (k = 0; k < count; k++) {
        double at = x + ((double)k - (double)before) * step;
        double from = foot_below(&feet, s, at);
        if (shoot(line, distance, from, slack, &cursor, &parallel->at[k])) {
            parallel->count++;
            continue;
        }
        if (k > before)
            break;
        low = k + 1;
        parallel->count = 0;
    }
    if (parallel->count < 2 || low > before)
        return STATUS_NO_CONVERGENCE;
    parallel->at += low;
    parallel->tangent += low;
    parallel->s += low;
    *middle = before - low;
    line_complete(parallel);
    return STATUS_OK;
}
