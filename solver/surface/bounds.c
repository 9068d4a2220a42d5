/* SPDX-License-Identifier: MIT */
#include "bounds.h"

#include "spans.h"
#include <float.h>

/* ---- cells ---- */

double bounds_least(const struct bounds_cell *cell) {
    int size = (cell->degree[0] + 1) * (cell->degree[1] + 1);
    double least = DBL_MAX;
    for (int i = 0; i < size; i++) {
        double ratio = cell->pairs[i][0] / cell->pairs[i][1];
        least = ratio < least ? ratio : least;
    }
    return least;
}

double bounds_least_corner(const struct bounds_cell *cell, int *corner) {
    int n = cell->degree[0], m = cell->degree[1];
    double least = DBL_MAX;
    for (int k = 0; k < 4; k++) {
        bounds_pair pair = cell->pairs[(k & 1 ? n * (m + 1) : 0) + (k & 2 ? m : 0)];
        double value = pair[0] / pair[1];
        if (!(value < least))
            continue;
        least = value;
        if (corner)
            *corner = k;
    }
    return least;
}

/* The least (sign 1) or the greatest (sign -1, and negative) second derivative of N - level W in
 * `direction` over [0, 1]: n (n - 1) times a second difference. */
static double extreme_second(const struct bounds_cell *cell, double level, int direction,
                             double sign) {
    int n = cell->degree[0], m = cell->degree[1], along = cell->degree[direction];
    int step = direction == 0 ? m + 1 : 1;
    double least = DBL_MAX;
    if (along < 2)
        return 0;
    for (int k = 0; k <= (direction == 0 ? n - 2 : n); k++)
        for (int l = 0; l <= (direction == 1 ? m - 2 : m); l++) {
            const bounds_pair *at = cell->pairs + k * (m + 1) + l;
            bounds_pair difference = at[0] - 2 * at[step] + at[2 * step];
            double value = sign * (difference[0] - level * difference[1]);
            least = value < least ? value : least;
        }
    return along * (along - 1) * least;
}

int bounds_bend(const struct bounds_cell *cell, double level) {
    double bend[2];
    for (int k = 0; k < 2; k++)
        bend[k] = fmax(-extreme_second(cell, level, k, 1), -extreme_second(cell, level, k, -1));
    if (bend[0] > bend[1] || bend[1] > bend[0])
        return bend[1] > bend[0];
    return cell->upper[1] - cell->lower[1] > cell->upper[0] - cell->lower[0];
}

/* The Hessian (a b; b c) is nowhere negative when min a >= 0, min c >= 0 and
 * (min a) (min c) >= (max |b|)^2; b is n m times a difference across. */
bool bounds_convex(const struct bounds_cell *cell, double level) {
    double a = extreme_second(cell, level, 0, 1);
    if (!(a >= 0))
        return false;
    double c = extreme_second(cell, level, 1, 1);
    if (!(c >= 0))
        return false;
    int n = cell->degree[0], m = cell->degree[1];
    double twist = 0;
    for (int k = 0; k < n; k++)
        for (int l = 0; l < m; l++) {
            const bounds_pair *at = cell->pairs + k * (m + 1) + l;
            bounds_pair difference = at[m + 2] - at[m + 1] - at[1] + at[0];
            twist = fmax(twist, fabs(difference[0] - level * difference[1]));
        }
    double b = n * m * twist;
    return a * c >= b * b;
}

/* ---- the search ---- */

/* Depth first, so that the stack is as deep as a cell is halved, and no deeper. */
void bounds_run(struct bounds_search *search) {
    struct bounds_cell stack[BOUNDS_DEPTH_MAX + 1];
    const size_t size = (size_t)((search->degree[0] + 1) * (search->degree[1] + 1));
    int depth[BOUNDS_DEPTH_MAX + 1] = {0}, count = 1;
    stack[0] = (struct bounds_cell){search->degree, {0, 0}, {1, 1}, search->store};
    while (count > 0) {
        int top = count - 1;
        int direction = search->judge(search->context, &stack[top]);
        if (direction == BOUNDS_SETTLED || depth[top] == BOUNDS_DEPTH_MAX) {
            count--;
            continue;
        }
        /* the cell becomes its upper half, the next one its lower: each row of coefficients along
         * the direction is halved at its middle */
        struct bounds_cell *cell = &stack[top], *low = &stack[count];
        bounds_pair *from = search->store + (size_t)top * size;
        bounds_pair *to = search->store + (size_t)count * size;
        int n = cell->degree[direction], width = cell->degree[1] + 1;
        int rows = direction == 0 ? width : cell->degree[0] + 1, step = direction == 0 ? width : 1;
        for (int k = 0; k < rows; k++) {
            bounds_pair *row = from + (direction == 0 ? k : k * width);
            bounds_pair *lower = to + (direction == 0 ? k : k * width);
            lower[0] = row[0];
            for (int r = 1; r <= n; r++) {
                for (int i = 0; i <= n - r; i++)
                    row[i * step] = 0.5 * (row[i * step] + row[(i + 1) * step]);
                lower[r * step] = row[0];
            }
        }
        *low = *cell;
        low->pairs = to;
        low->upper[direction] = cell->lower[direction] =
            (cell->lower[direction] + cell->upper[direction]) / 2;
        depth[count++] = ++depth[top];
    }
}

/* ---- the tight box ---- */

/* What a coordinate may be short of its extreme, as a share of the surface's size; ten times less
 * than anyone is promised. */
static const double box_tolerance = 1e-10;

/* The extreme of one coordinate: the least of sign * r_lane. */
struct extreme {
    double best, tolerance;
};

static int judge_extreme(void *context, const struct bounds_cell *cell) {
    struct extreme *extreme = context;
    extreme->best = fmin(extreme->best, bounds_least_corner(cell, NULL));
    if (!(bounds_least(cell) < extreme->best - extreme->tolerance))
        return BOUNDS_SETTLED;
    return bounds_bend(cell, extreme->best);
}

/* Corners of all spans first: what they attain rules out most spans at a glance. */
static void find_extreme(const struct surface *surface, int lane, double sign,
                         struct extreme *extreme, struct bounds_search *search) {
    size_t spans = (size_t)surface->axis[0].span_count * (size_t)surface->axis[1].span_count;
    size_t size = surface->points_per_span;
    extreme->best = DBL_MAX;
    for (size_t i = 0; i < spans; i++) {
        const vec4 *points = surface->points + i * size;
        extreme->best = fmin(extreme->best, sign * points[0][lane] / points[0][3]);
        extreme->best = fmin(extreme->best, sign * points[size - 1][lane] / points[size - 1][3]);
    }
    for (size_t i = 0; i < spans; i++) {
        const vec4 *points = surface->points + i * size;
        bool room = false; /* for less than the best yet */
        for (size_t k = 0; k < size; k++) {
            double value = sign * points[k][lane];
            search->store[k] = (bounds_pair){value, points[k][3]};
            room = room || value < (extreme->best - extreme->tolerance) * points[k][3];
        }
        if (room)
            bounds_run(search);
    }
}

void bounds_tight(const struct surface *surface, struct vec3 *lower, struct vec3 *upper) {
    struct bounds_search search;
    struct extreme extreme = {.tolerance = box_tolerance * surface->size};
    double low[3], high[3];
    search.degree[0] = surface->axis[0].degree;
    search.degree[1] = surface->axis[1].degree;
    search.judge = judge_extreme;
    search.context = &extreme;
    for (int lane = 0; lane < 3; lane++) {
        find_extreme(surface, lane, 1, &extreme, &search);
        low[lane] = extreme.best;
        find_extreme(surface, lane, -1, &extreme, &search);
        high[lane] = -extreme.best;
    }
    double away = fabs(surface->height);
    *lower = vec3_make(low[0] - away, low[1] - away, low[2] - away);
    *upper = vec3_make(high[0] + away, high[1] + away, high[2] + away);
}
