/* SPDX-License-Identifier: MIT */
#include "variation.h"

#include <string.h>

/* From stop to stop of an arm. */
enum { SHIFT_STEPS = 2 };

/* Steps of differences, by the spacing. */
static const double place_step = 1e-5;

/* The box round all places, and the places in it. */
static enum status find_places(struct march *march, struct steer_variation *v) {
    size_t tiles = net_tile_count(march->net);
    struct net_tile **tile = net_sorted_tiles(march->net);
    int32_t high[2] = {INT32_MIN, INT32_MIN};
    v->low[0] = v->low[1] = INT32_MAX;
    if (!tile)
        return STATUS_OUT_OF_MEMORY;
    for (size_t t = 0; t < tiles; t++) {
        const int32_t at[2] = {tile[t]->ti * NET_TILE, tile[t]->tj * NET_TILE};
        for (int k = 0; k < 2; k++) {
            v->low[k] = at[k] < v->low[k] ? at[k] : v->low[k];
            high[k] = at[k] > high[k] ? at[k] : high[k];
        }
    }
    v->size[0] = high[0] - v->low[0] + NET_TILE;
    v->size[1] = high[1] - v->low[1] + NET_TILE;
    size_t box = (size_t)v->size[0] * (size_t)v->size[1], places = 0;
    v->node = arena_alloc(march->arena, box, sizeof *v->node);
    v->slot = arena_take(march->arena, box, sizeof *v->slot);
    if (!v->node || !v->slot)
        return STATUS_OUT_OF_MEMORY;
    for (size_t n = 0; n < box; n++) {
        v->slot[n] = -1;
        v->node[n] = net_place(march->net, v->low[0] + (int32_t)n % v->size[0],
                               v->low[1] + (int32_t)n / v->size[0]);
        places += v->node[n] != NULL;
    }
    v->point = arena_take(march->arena, box, sizeof *v->point);
    v->derivative = arena_take(march->arena, places * 3 * (size_t)v->row, sizeof *v->derivative);
    return v->point && v->derivative ? STATUS_OK : STATUS_OUT_OF_MEMORY;
}

/* Evaluates the surface at all places; where it has no tangent plane there is no place. */
static void find_points(struct march *march, struct steer_variation *v) {
    for (int32_t n = 0; n < v->size[0] * v->size[1]; n++)
        if (v->node[n] && !surface_point_at(march_surface(march, v->node[n]), &march->cursor,
                                            v->node[n]->uv, &v->point[n]))
            v->node[n] = NULL;
}

static double *add_derivative(struct steer_variation *v, int32_t index) {
    v->slot[index] = v->known++;
    return v->derivative + (size_t)v->slot[index] * 3 * (size_t)v->row;
}

/* ---- generators ---- */

/* The number of places of an arm beyond the start. */
static int32_t arm_length(const struct steer_variation *v, int di, int dj) {
    int32_t k = 1;
    for (;; k++) {
        int32_t index = steer_index(v, k * di, k * dj);
        if (index < 0 || !v->node[index])
            return k - 1;
    }
}

/* The Gaussian curvature at a share of the way between two stops, by the parabola through three. */
static double gauss_between(const struct march_stop *stop, double share) {
    double low = stop[0].gauss, middle = stop[1].gauss_before, high = stop[1].gauss;
    return low + share * (4 * middle - 3 * low - high + 2 * share * (low + high - 2 * middle));
}

/* The curvature at a place of an arm, and by how much it rises with each value. */
struct bend {
    double curvature, gauss, rise[DRAPE_CURVATURE_VALUES];
};

static struct bend bend_at(const struct drape_curvature *curvature, int sign,
                           const struct march_stop *stop, double share) {
    double s = sign * (stop[0].gone + share * (stop[1].gone - stop[0].gone));
    struct bend bend = {.curvature = sign * curvature_at(curvature, s),
                        .gauss = gauss_between(stop, share)};
    curvature_weights(curvature, s, bend.rise);
    for (int n = 0; n < 2 * curvature->points; n++)
        bend.rise[n] *= sign;
    return bend;
}

/* What a path has moved by with each value: along itself, to its left, and its tangent's turn. */
struct shift {
    double along[DRAPE_CURVATURE_VALUES], left[DRAPE_CURVATURE_VALUES],
        turn[DRAPE_CURVATURE_VALUES];
};

/* The derivatives of a shift that goes on by h times another. Arc length is kept; the tangent turns
 * by what the curvature changes and, as neighbouring geodesics do, by the Gaussian curvature. */
static void shift_rate(const struct bend *bend, const struct shift *from, double h,
                       const struct shift *on, int count, struct shift *rate) {
    for (int n = 0; n < count; n++) {
        double along = from->along[n] + h * on->along[n], left = from->left[n] + h * on->left[n];
        double turn = from->turn[n] + h * on->turn[n];
        rate->along[n] = bend->curvature * left;
        rate->left[n] = turn - bend->curvature * along;
        rate->turn[n] = bend->rise[n] - bend->gauss * left;
    }
}

/* On to the next stop, by steps of the classical Runge-Kutta rule. */
static void shift_on(const struct drape_curvature *curvature, int sign,
                     const struct march_stop *stop, struct shift *a) {
    double h = (stop[1].gone - stop[0].gone) / SHIFT_STEPS, by = 1.0 / SHIFT_STEPS;
    int count = 2 * curvature->points;
    for (int m = 0; m < SHIFT_STEPS; m++) {
        struct bend low = bend_at(curvature, sign, stop, m * by);
        struct bend middle = bend_at(curvature, sign, stop, (m + 0.5) * by);
        struct bend high = bend_at(curvature, sign, stop, (m + 1) * by);
        struct shift rate[4];
        shift_rate(&low, a, 0, a, count, &rate[0]);
        shift_rate(&middle, a, h / 2, &rate[0], count, &rate[1]);
        shift_rate(&middle, a, h / 2, &rate[1], count, &rate[2]);
        shift_rate(&high, a, h, &rate[2], count, &rate[3]);
        for (int k = 0; k < 4; k++) {
            double share = (k == 1 || k == 2 ? 2 : 1) * h / 6;
            for (int n = 0; n < count; n++) {
                a->along[n] += share * rate[k].along[n];
                a->left[n] += share * rate[k].left[n];
                a->turn[n] += share * rate[k].turn[n];
            }
        }
    }
}

/* One arm with `count` stops by the values of its generator, whose derivatives begin with `column`.
 * Where stops are equal chords apart, each also moves along the path, so that they stay it. */
static void vary_arm(const struct march *march, struct steer_variation *v, int number, int column,
                     int32_t count, const struct march_stop *stop) {
    int g = number / 2, sign = number % 2 ? -1 : 1;
    const struct drape_curvature *curvature = &march->settings->generator[g].curvature;
    struct shift shift = {{0}, {0}, {0}};
    struct vec3 before[DRAPE_CURVATURE_VALUES] = {{0, 0, 0}};
    for (int32_t m = 1; m < count; m++) {
        int32_t index = steer_index(v, g ? 0 : sign * m, g ? sign * m : 0);
        double *d = v->derivative + (size_t)v->slot[index] * 3 * (size_t)v->row;
        struct vec3 chord = vec3_sub(stop[m].r, stop[m - 1].r);
        double slant = vec3_dot(chord, stop[m].tangent);
        shift_on(curvature, sign, &stop[m - 1], &shift);
        for (int n = 0; n < 2 * curvature->points; n++) {
            struct vec3 by =
                vec3_axpy(shift.left[n], stop[m].left, vec3_scale(shift.along[n], stop[m].tangent));
            if (march->method->yarn == DRAPE_YARN_CHORD) {
                double on = vec3_dot(chord, vec3_sub(before[n], by)) / slant;
                by = vec3_axpy(on, stop[m].tangent, by);
            }
            before[n] = by;
            vec3_to_columns(by, d, d + v->row, d + 2 * v->row, (size_t)(column + n));
        }
    }
}

/* The places of an arm, which do not move but for the values of its own generator. */
static enum status vary_places(struct march *march, bool varied, struct steer_variation *v,
                               int number, int column) {
    int k = number / 2, sign = number % 2 ? -1 : 1;
    int32_t count = arm_length(v, k ? 0 : sign, k ? sign : 0) + 1;
    for (int32_t m = 1; m < count; m++) {
        double *d = add_derivative(v, steer_index(v, k ? 0 : sign * m, k ? sign * m : 0));
        memset(d, 0, 3 * (size_t)v->row * sizeof *d);
    }
    if (!varied)
        return STATUS_OK;
    struct arena_mark mark = arena_mark(march->arena);
    struct march_stop *stop = arena_take(march->arena, (size_t)count, sizeof *stop);
    if (!stop)
        return STATUS_OUT_OF_MEMORY;
    count = march_arm_stops(march, number, count, stop);
    vary_arm(march, v, number, column, count, stop);
    arena_rewind(march->arena, mark);
    return STATUS_OK;
}

/* The four arms, and the start, which stays. */
static enum status vary_arms(struct march *march, const bool varied[2], struct steer_variation *v) {
    int32_t start = steer_index(v, 0, 0);
    int first = varied[0] ? 2 * march->settings->generator[0].curvature.points : 0;
    enum status status = STATUS_OK;
    memset(add_derivative(v, start), 0, 3 * (size_t)v->row * sizeof *v->derivative);
    for (int number = 0; number < 4 && status == STATUS_OK; number++)
        status = vary_places(march, varied[number / 2], v, number, number < 2 ? 0 : first);
    return status;
}

/* ---- cells ---- */

/* dD = sum_r column[r] (sum_X row[r][X] . dX), X = A, B, C. */
struct law {
    struct vec3 column[2], row[2][3];
};

/* The gradients of the chords BD and CD by A, B and C, times the chords, where they change with the
 * surface: differences along two tangents of each. */
static void add_chords(struct march *march, const struct fishnet_cell *cell, struct law *law) {
    const struct surface_point *corner[3] = {cell->a, cell->b, cell->c};
    const double *length = march->settings->spacing;
    double step = place_step * fmin(length[0], length[1]);
    for (int x = 0; x < 3; x++) {
        struct vec3 first = vec3_unit(corner[x]->jet.u);
        struct vec3 tangent[2] = {first, vec3_cross(corner[x]->normal, first)};
        for (int k = 0; k < 2; k++) {
            struct fishnet_cell moved = *cell;
            struct surface_point to;
            if (!surface_point_move(&march->cursor, corner[x], vec3_scale(step, tangent[k]), &to))
                continue;
            *(x == 0 ? &moved.a : x == 1 ? &moved.b : &moved.c) = &to;
            fishnet_chords(&march->cursor, march->method->yarn, DRAPE_PATH_CHORD, length, &moved);
            double bd = (moved.bd - cell->bd) / step, cd = (moved.cd - cell->cd) / step;
            law->row[0][x] = vec3_axpy(cell->bd * bd, tangent[k], law->row[0][x]);
            law->row[1][x] = vec3_axpy(cell->cd * cd, tangent[k], law->row[1][x]);
        }
    }
}

/* The law of the corner D; false where its yarns are parallel. Chords over folds stay what they
 * are.
 */
static bool find_law(struct march *march, const struct surface_point *const corner[3],
                     const struct surface_point *d, bool rough, struct law *law) {
    struct fishnet_cell cell = {.a = corner[0], .b = corner[1], .c = corner[2]};
    struct vec3 wb = vec3_sub(d->jet.r, cell.b->jet.r), wc = vec3_sub(d->jet.r, cell.c->jet.r);
    struct vec3 e = vec3_unit(surface_point_projection(d, wb)), f = vec3_cross(d->normal, e);
    double m[4] = {vec3_dot(wb, e), vec3_dot(wb, f), vec3_dot(wc, e), vec3_dot(wc, f)};
    double determinant = m[0] * m[3] - m[1] * m[2];
    if (!(fabs(determinant) > 1e-6 * vec3_norm(wb) * vec3_norm(wc)))
        return false;
    double by = 1 / determinant;
    *law = (struct law){
        .column = {vec3_axpy(-m[2] * by, f, vec3_scale(m[3] * by, e)),
                   vec3_axpy(m[0] * by, f, vec3_scale(-m[1] * by, e))},
        .row = {{{0, 0, 0}, wb, {0, 0, 0}}, {{0, 0, 0}, {0, 0, 0}, wc}},
    };
    if (march->method->yarn != DRAPE_YARN_CHORD && !rough) {
        fishnet_chords(&march->cursor, march->method->yarn, DRAPE_PATH_CHORD,
                       march->settings->spacing, &cell);
        add_chords(march, &cell, law);
    }
    return true;
}

/* Applies a law to all parameters. */
WIDE_CLONES
static void apply_law(const struct law *law, const double *const from[3], int row, double *to) {
    for (int n = 0; n < row; n += STEER_LANES) {
        steer_lanes sum[2], d[3];
        for (int r = 0; r < 2; r++) {
            sum[r] = steer_dot(law->row[r][0], from[0] + n, row);
            sum[r] += steer_dot(law->row[r][1], from[1] + n, row);
            sum[r] += steer_dot(law->row[r][2], from[2] + n, row);
        }
        d[0] = law->column[0].x * sum[0] + law->column[1].x * sum[1];
        d[1] = law->column[0].y * sum[0] + law->column[1].y * sum[1];
        d[2] = law->column[0].z * sum[0] + law->column[1].z * sum[1];
        for (int k = 0; k < 3; k++)
            memcpy(to + k * row + n, &d[k], sizeof d[k]);
    }
}

/* Derives node (i, j) as the corner D of the cell whose A lies against (di, dj). False where it is
 * known, or one of the others is not. */
static bool vary_corner(struct march *march, struct steer_variation *v, int32_t i, int32_t j,
                        int di, int dj) {
    int32_t index = steer_index(v, i, j),
            of[3] = {steer_index(v, i - di, j - dj), steer_index(v, i - di, j),
                     steer_index(v, i, j - dj)};
    const double *from[3];
    const struct surface_point *corner[3];
    struct law law;
    if (index < 0 || !v->node[index] || v->slot[index] >= 0)
        return false;
    for (int x = 0; x < 3; x++) {
        if (of[x] < 0 || v->slot[of[x]] < 0)
            return false;
        from[x] = v->derivative + (size_t)v->slot[of[x]] * 3 * (size_t)v->row;
        corner[x] = &v->point[of[x]];
    }
    if (!find_law(march, corner, &v->point[index], v->node[index]->rough != 0, &law))
        return false;
    apply_law(&law, from, v->row, add_derivative(v, index));
    return true;
}

/* The four quadrants, away from the generators. */
static void vary_quadrants(struct march *march, struct steer_variation *v) {
    for (int q = 0; q < 4; q++) {
        int di = q & 1 ? -1 : 1, dj = q & 2 ? -1 : 1;
        for (int32_t j = dj; steer_index(v, v->low[0], j) >= 0; j += dj)
            for (int32_t i = di; steer_index(v, i, j) >= 0; i += di)
                (void)vary_corner(march, v, i, j, di, dj);
    }
}

/* Where they have not reached: from whichever side three corners are known, as the net grew. */
static void vary_rest(struct march *march, struct steer_variation *v) {
    for (int32_t before = -1; v->known > before;) {
        before = v->known;
        for (int q = 0; q < 4; q++)
            for (int32_t n = 0; n < v->size[0] * v->size[1]; n++)
                if (v->node[n] && v->slot[n] < 0)
                    (void)vary_corner(march, v, v->low[0] + n % v->size[0],
                                      v->low[1] + n / v->size[0], q & 1 ? -1 : 1, q & 2 ? -1 : 1);
    }
}

enum status steer_variation_make(struct march *march, const bool varied[2],
                                 struct steer_variation *v) {
    *v = (struct steer_variation){0};
    for (int k = 0; k < 2; k++)
        v->parameters += varied[k] ? 2 * march->settings->generator[k].curvature.points : 0;
    v->row = (v->parameters + STEER_LANES - 1) / STEER_LANES * STEER_LANES;
    enum status status = find_places(march, v);
    if (status != STATUS_OK)
        return status;
    find_points(march, v);
    status = vary_arms(march, varied, v);
    if (status != STATUS_OK)
        return status;
    vary_quadrants(march, v);
    vary_rest(march, v);
    return STATUS_OK;
}
