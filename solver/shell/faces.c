/* SPDX-License-Identifier: MIT */
#include "faces.h"

enum { NEWTON_MAX = 40, HALVINGS_MAX = 20, RUN_MAX = 8, POINT_SAMPLES = 4 };

/* A place this close outside the domain, as a share of it, is on its border. */
static const double border = 1e-9;

/* Loops that run along the seam of a closed direction may be off by this share of the domain. */
static const double seam = 2e-6;

/* Its inner parameters and their derivative. */
static void curve_parameters(const struct shell *shell, const struct face_curve *curve, double from,
                             double t, struct curve_place *place) {
    const struct surface *surface = &shell->faces[curve->face].surface;
    double outer[2];
    place->t = t;
    if (curve->trim) {
        trim_curve_beyond(curve->trim, from, t, outer, place->rate);
        surface_inner(surface, outer, place->uv);
        for (int k = 0; k < 2; k++)
            place->rate[k] *= surface_axis_rate(&surface->axis[k], place->uv[k], NULL);
    } else {
        for (int k = 0; k < 2; k++) {
            const double *line[2] = {curve->line[0], curve->line[1]};
            place->rate[k] = line[1][k] - line[0][k];
            place->uv[k] = t == 1 ? line[1][k] : line[0][k] + t * place->rate[k];
        }
    }
}

void curve_beyond(const struct shell *shell, const struct face_curve *curve, double from, double t,
                  struct curve_place *place) {
    struct surface_cursor cursor = {0, 0};
    curve_parameters(shell, curve, from, t, place);
    surface_jet_at(&shell->faces[curve->face].surface, &cursor, place->uv[0], place->uv[1],
                   &place->jet);
    place->r = place->jet.r;
    place->tangent =
        vec3_axpy(place->rate[1], place->jet.v, vec3_scale(place->rate[0], place->jet.u));
}

void curve_at(const struct shell *shell, const struct face_curve *curve, double t,
              struct curve_place *place) {
    double within = fmin(fmax(t, curve->range[0]), curve->range[1]);
    curve_beyond(shell, curve, within, within, place);
}

/* How the parameters bend is taken over this share of the range. */
static const double bend_step = 1e-4;

struct vec3 curve_second(const struct shell *shell, const struct face_curve *curve,
                         const struct curve_place *place) {
    const double *range = curve->range, step = bend_step * (range[1] - range[0]);
    const double *rate = place->rate, to = place->t + (place->t > range[1] - step ? -step : step);
    const struct surface_jet *jet = &place->jet;
    struct curve_place beside;
    curve_parameters(shell, curve, to, to, &beside);
    double by = 1 / (to - place->t);
    struct vec3 second = vec3_scale(rate[0] * rate[0], jet->uu);
    second = vec3_axpy(2 * rate[0] * rate[1], jet->uv, second);
    second = vec3_axpy(rate[1] * rate[1], jet->vv, second);
    second = vec3_axpy(by * (beside.rate[0] - rate[0]), jet->u, second);
    return vec3_axpy(by * (beside.rate[1] - rate[1]), jet->v, second);
}

/* Steps shorter than this share of the range do not bring the place nearer. */
static const double arrived = 1e-14;

/* How the curve bends towards the point is left out of the first step, and of the next while it
 * changes them by less than this share. */
static const double bent = 0.1;

/* Newton's method for g(t) = (q - r) . r' / |r'|^2 = 0: where r is near to q or straight, g' = -1;
 * where that does not hold, it is taken from the last two places. */
double curve_nearest(const struct shell *shell, const struct face_curve *curve, struct vec3 point,
                     double from, const double range[2], struct curve_place *place) {
    double t = fmin(fmax(from, range[0]), range[1]), distance, before[2] = {NAN, NAN}; /* t, g */
    curve_at(shell, curve, t, place);
    distance = vec3_distance(place->r, point);
    for (int round = 0; round < NEWTON_MAX; round++) {
        struct curve_place next;
        double speed2 = vec3_norm2(place->tangent), closer = distance, last = t;
        double step = vec3_dot(vec3_sub(point, place->r), place->tangent) / speed2;
        if (fabs(step) <= arrived * (range[1] - range[0]))
            break;
        double slope = (step - before[1]) / (t - before[0]);
        before[0] = t;
        before[1] = step;
        if (slope < 0 && fabs(slope + 1) > bent)
            step /= -slope;
        for (int h = 0; h < HALVINGS_MAX && isfinite(step) && !(closer < distance); h++) {
            double to = fmin(fmax(last + step, range[0]), range[1]);
            if (to == last)
                break;
            curve_at(shell, curve, to, &next);
            closer = vec3_distance(next.r, point);
            step /= 2;
        }
        if (!(closer < distance))
            break;
        *place = next;
        t = next.t;
        distance = closer;
    }
    return distance;
}

bool edge_is_point(const struct shell *shell, const struct face_edge *edge, double reach) {
    for (int k = 1; k < POINT_SAMPLES; k++) {
        struct curve_place place;
        curve_at(shell, &shell->curves[edge->curve],
                 edge->t[0] + k * (edge->t[1] - edge->t[0]) / POINT_SAMPLES, &place);
        if (vec3_distance(place.r, edge->end[0]) > reach)
            return false;
    }
    return vec3_distance(edge->end[0], edge->end[1]) <= reach;
}

/* Makes the run of some segments, and of their halves, from number `at` on, if there is room; the
 * number after them. */
static uint32_t add_face_run(struct face *face, uint32_t at, uint32_t first, uint32_t count) {
    struct face_run run = {.first = first, .count = count, .edge = face->segments[first].edge};
    double low[2] = {HUGE_VAL, HUGE_VAL}, high[2] = {-HUGE_VAL, -HUGE_VAL};
    run.next = at + 1;
    if (count > RUN_MAX) {
        run.next = add_face_run(face, run.next, first, count / 2);
        run.next = add_face_run(face, run.next, first + count / 2, count - count / 2);
    }
    if (!face->runs)
        return run.next;
    for (uint32_t s = first; s < first + count; s++)
        for (int k = 0; k < 2; k++) {
            const struct face_segment *segment = &face->segments[s];
            low[k] = fmin(low[k], fmin(segment->a[k], segment->b[k]));
            high[k] = fmax(high[k], fmax(segment->a[k], segment->b[k]));
        }
    for (int k = 0; k < 2; k++) {
        run.centre[k] = (low[k] + high[k]) / 2;
        run.half[k] = (high[k] - low[k]) / 2;
    }
    face->runs[at] = run;
    return run.next;
}

enum status face_make_runs(struct face *face, struct arena *arena) {
    for (int pass = 0; pass < 2; pass++) {
        uint32_t count = 0;
        for (uint32_t s = 0, end; s < face->segment_count; s = end) {
            for (end = s;
                 end < face->segment_count && face->segments[end].edge == face->segments[s].edge;)
                end++;
            count = add_face_run(face, count, s, end - s);
        }
        face->run_count = count;
        if (pass == 0)
            face->runs = arena_alloc(arena, count, sizeof *face->runs);
        if (!face->runs)
            return STATUS_OUT_OF_MEMORY;
    }
    return STATUS_OK;
}

/* The column or row of the grid that x lies in, one of direction k. */
static int grid_index(const struct face *face, int k, double x) {
    const struct surface_axis *axis = &face->surface.axis[k];
    double low = surface_axis_lower(axis), high = surface_axis_upper(axis);
    double at = (x - low) / (high - low) * FACE_GRID;
    return at > 0 ? (int)fmin(at, FACE_GRID - 1) : 0;
}

enum status face_make_grid(struct face *face, struct arena *arena) {
    uint8_t *marks = arena_alloc(arena, FACE_GRID * FACE_GRID, 1);
    if (!marks)
        return STATUS_OUT_OF_MEMORY;
    /* Marks the cells within a hundredth of one round a segment, by steps of half a cell. */
    for (uint32_t s = 0; s < face->segment_count; s++) {
        const struct face_segment *segment = &face->segments[s];
        double size[2], steps = 1;
        for (int k = 0; k < 2; k++) {
            size[k] = surface_axis_length(&face->surface.axis[k]) / FACE_GRID;
            steps = fmax(steps, ceil(2 * fabs(segment->b[k] - segment->a[k]) / size[k]));
        }
        for (int n = 0; n < (int)steps; n++) {
            int first[2], last[2];
            for (int k = 0; k < 2; k++) {
                double way = (segment->b[k] - segment->a[k]) / steps, a = segment->a[k] + n * way;
                double slack = 0.01 * size[k];
                first[k] = grid_index(face, k, fmin(a, a + way) - slack);
                last[k] = grid_index(face, k, fmax(a, a + way) + slack);
            }
            for (int i = first[0]; i <= last[0]; i++)
                for (int j = first[1]; j <= last[1]; j++)
                    marks[i * FACE_GRID + j] = 1;
        }
    }
    for (int n = 0; n < FACE_GRID * FACE_GRID; n++) {
        const int at[2] = {n / FACE_GRID, n % FACE_GRID};
        double uv[2];
        for (int k = 0; k < 2; k++) {
            const struct surface_axis *axis = &face->surface.axis[k];
            double low = surface_axis_lower(axis), high = surface_axis_upper(axis);
            uv[k] = low + (high - low) * (at[k] + 0.5) / FACE_GRID;
        }
        marks[n] = marks[n]                  ? FACE_CELL_MIXED
                   : face_contains(face, uv) ? FACE_CELL_INSIDE
                                             : FACE_CELL_OUTSIDE;
    }
    face->cells = marks;
    return STATUS_OK;
}

bool face_holds_way(const struct face *face, const double from[2], const double to[2]) {
    int first[2], last[2];
    for (int k = 0; k < 2; k++) {
        const struct surface_axis *axis = &face->surface.axis[k];
        double low = fmin(from[k], to[k]), high = fmax(from[k], to[k]);
        if (!(low > surface_axis_lower(axis) && high < surface_axis_upper(axis)))
            return false;
        first[k] = grid_index(face, k, low);
        last[k] = grid_index(face, k, high);
    }
    if ((last[0] - first[0] + 1) * (last[1] - first[1] + 1) > FACE_GRID)
        return false;
    for (int i = first[0]; i <= last[0]; i++)
        for (int j = first[1]; j <= last[1]; j++)
            if (face->cells[i * FACE_GRID + j] != FACE_CELL_INSIDE)
                return false;
    return true;
}

bool face_contains(const struct face *face, const double uv[2]) {
    double at[2], outer[2];
    for (int k = 0; k < 2; k++) {
        const struct surface_axis *axis = &face->surface.axis[k];
        double low = surface_axis_lower(axis), high = surface_axis_upper(axis);
        double slack = border * (high - low);
        at[k] = surface_axis_wrap(axis, uv[k]);
        if (!(at[k] >= low - slack && at[k] <= high + slack))
            return false;
        if (axis->closed && face->trim)
            at[k] = fmin(fmax(at[k], low + seam * (high - low)), high - seam * (high - low));
    }
    if (!face->trim)
        return true;
    int cell =
        face->cells
            ? face->cells[grid_index(face, 0, at[0]) * FACE_GRID + grid_index(face, 1, at[1])]
            : FACE_CELL_MIXED;
    if (cell != FACE_CELL_MIXED)
        return cell == FACE_CELL_INSIDE;
    surface_outer(&face->surface, at, outer);
    return trim_contains(face->trim, outer);
}
