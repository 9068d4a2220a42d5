/* SPDX-License-Identifier: MIT */
#include "measure.h"
#include "tests/check.h"
#include <stdlib.h>
#include <string.h>

/* Enough for the largest net here; a solver that wants more has a leak. */
static const size_t ARENA_BUDGET = (size_t)512 << 20;
/* r(u, v) against x, y, z, relative to the size of the surface. */
static const double EVALUATION_TOLERANCE = 1e-12;
/* Of a length between two points, relative to their coordinates. */
static const double ROUNDING = 1e-14;
/* The mean of two edges, by their vectors or their directions: chords differ by little. */
static const double MEAN_COSINE = 1 - 1e-6;

void grid_make(struct grid *grid, const struct drape_nodes *nodes) {
    int low[2] = {0, 0}, high[2] = {0, 0};
    for (size_t k = 0; k < nodes->count; k++) {
        int at[2] = {nodes->i[k], nodes->j[k]};
        for (int c = 0; c < 2; c++) {
            low[c] = at[c] < low[c] ? at[c] : low[c];
            high[c] = at[c] > high[c] ? at[c] : high[c];
        }
    }
    for (int c = 0; c < 2; c++) {
        grid->low[c] = low[c];
        grid->size[c] = high[c] - low[c] + 1;
    }
    size_t cells = (size_t)grid->size[0] * (size_t)grid->size[1];
    grid->index = malloc(cells * sizeof *grid->index);
    assert_non_null(grid->index);
    for (size_t k = 0; k < cells; k++) {
        grid->index[k] = -1;
    }
    for (size_t k = 0; k < nodes->count; k++) {
        int at = (nodes->j[k] - low[1]) * grid->size[0] + nodes->i[k] - low[0];
        assert_int_equal(grid->index[at], -1);
        grid->index[at] = (int)k;
    }
}

void grid_free(struct grid *grid) {
    free(grid->index);
    grid->index = NULL;
}

int grid_find(const struct grid *grid, int i, int j) {
    i -= grid->low[0];
    j -= grid->low[1];
    bool inside = i >= 0 && j >= 0 && i < grid->size[0] && j < grid->size[1];
    return inside ? grid->index[j * grid->size[0] + i] : -1;
}

struct vec3 node_point(const struct drape_nodes *nodes, int at) {
    return vec3_make(nodes->x[at], nodes->y[at], nodes->z[at]);
}

enum status drape_try_trimmed(struct drape_run *run, struct shape *shape, const struct trim *trim,
                              const struct drape_settings *settings) {
    struct nurbs_fault fault = {.reason = ""};
    struct nurbs nurbs = shape_nurbs(shape);
    memset(run, 0, sizeof *run);
    run->arena = arena_new(ARENA_BUDGET);
    assert_non_null(run->arena);
    if (nurbs_validate(&nurbs, &fault) != STATUS_OK) {
        fail_msg("nurbs_validate: member %d, %s", (int)fault.member, fault.reason);
    }
    assert_int_equal(surface_make(&nurbs, run->arena, &run->surface), STATUS_OK);
    enum status status = drape_solve(&(struct drape_part){.surface = run->surface, .trim = trim},
                                     settings, NULL, run->arena, &run->result);
    if (status == STATUS_OK) {
        grid_make(&run->grid, &run->result.nodes);
    }
    return status;
}

void drape_begin_trimmed(struct drape_run *run, struct shape *shape, const struct trim *trim,
                         const struct drape_settings *settings) {
    assert_int_equal(drape_try_trimmed(run, shape, trim, settings), STATUS_OK);
    check_result(shape, settings, run);
}

enum status drape_try(struct drape_run *run, struct shape *shape,
                      const struct drape_settings *settings) {
    return drape_try_trimmed(run, shape, NULL, settings);
}

void drape_begin(struct drape_run *run, struct shape *shape,
                 const struct drape_settings *settings) {
    drape_begin_trimmed(run, shape, NULL, settings);
}

void drape_end(struct drape_run *run) {
    grid_free(&run->grid);
    arena_free(run->arena);
    run->arena = NULL;
}

struct net_error measure_error(const struct drape_nodes *nodes, const struct reference *reference,
                               const double spacing[2], const int n[2]) {
    struct net_error error = {0, 0, 0, {0, 0}};
    for (size_t k = 0; k < nodes->count; k++) {
        int i = nodes->i[k], j = nodes->j[k];
        if (abs(i) > n[0] || abs(j) > n[1]) {
            continue;
        }
        struct exact_net_point exact;
        reference_at(reference, i * spacing[0], j * spacing[1], &exact);
        double position = vec3_distance(node_point(nodes, (int)k), exact.r);
        double shear = fabs(nodes->shear_deg[k] - exact.shear_deg);
        if (!(position <= error.position)) {
            error.position = isnan(position) ? HUGE_VAL : position;
            error.worst[0] = i;
            error.worst[1] = j;
        }
        if (!(shear <= error.shear_deg)) {
            error.shear_deg = isnan(shear) ? HUGE_VAL : shear;
        }
        error.count++;
    }
    return error;
}

double order_of(double coarse, double fine) {
    return log2(coarse / fine);
}

double arc_chord(double d, double k) {
    double half = d * k / 2;
    if (fabs(half) < 1e-4) { /* sin x / x to its fourth power: 1e-19 */
        return d * (1 - half * half / 6 + half * half * half * half / 120);
    }
    return 2 * sin(half) / k;
}

static struct vec3 in_tangent_plane(const struct surface_jet *jet, struct vec3 a) {
    struct vec3 n = jet_normal(jet);
    return vec3_unit(vec3_axpy(-vec3_dot(a, n), n, a));
}

/* The curvature at node `at` along `direction`, projected on the tangent plane there. */
static double node_curvature(const struct shape *shape, const struct drape_nodes *nodes, int at,
                             struct vec3 direction) {
    struct surface_jet jet;
    shape_evaluate(shape, nodes->u[at], nodes->v[at], &jet);
    struct vec3 a = in_tangent_plane(&jet, direction);
    return jet_second_form(&jet, a, a);
}

void gib_chords(const struct shape *shape, const struct drape_nodes *nodes, const struct grid *grid,
                int i, int j, const double spacing[2], double chord[2]) {
    int si = i < 0 ? -1 : 1, sj = j < 0 ? -1 : 1;
    int a = grid_find(grid, i - si, j - sj), b = grid_find(grid, i - si, j);
    int c = grid_find(grid, i, j - sj);
    struct surface_jet jet;
    struct vec3 ra = node_point(nodes, a);
    shape_evaluate(shape, nodes->u[a], nodes->v[a], &jet);
    struct vec3 r1 = in_tangent_plane(&jet, vec3_sub(node_point(nodes, b), ra));
    struct vec3 r2 = in_tangent_plane(&jet, vec3_sub(node_point(nodes, c), ra));
    chord[0] = arc_chord(spacing[1], node_curvature(shape, nodes, c, r1));
    chord[1] = arc_chord(spacing[0], node_curvature(shape, nodes, b, r2));
}

double measure_edges(const struct shape *shape, const struct drape_nodes *nodes,
                     const struct grid *grid, enum drape_method method, const double spacing[2]) {
    double worst = 0;
    for (size_t k = 0; k < nodes->count; k++) {
        int i = nodes->i[k], j = nodes->j[k];
        int si = i < 0 ? -1 : 1, sj = j < 0 ? -1 : 1;
        int b = grid_find(grid, i - si, j), c = grid_find(grid, i, j - sj);
        if (i == 0 || j == 0 || b < 0 || c < 0 || grid_find(grid, i - si, j - sj) < 0) {
            continue;
        }
        struct vec3 d = node_point(nodes, (int)k);
        double chord[2] = {spacing[1], spacing[0]};
        if (method != DRAPE_BASIC) {
            gib_chords(shape, nodes, grid, i, j, spacing, chord);
        }
        double cd = fabs(vec3_distance(node_point(nodes, c), d) / chord[0] - 1);
        double bd = fabs(vec3_distance(node_point(nodes, b), d) / chord[1] - 1);
        worst = fmax(worst, isnan(cd + bd) ? HUGE_VAL : fmax(cd, bd));
    }
    return worst;
}

double square_gap(const struct drape_nodes *nodes, double d,
                  void (*unroll)(const void *surface, double u, double v, double at[2]),
                  const void *surface) {
    double(*at)[2] = malloc(nodes->count * sizeof *at), from[2] = {0, 0}, gap[2] = {0, 0};
    assert_non_null(at);
    for (size_t k = 0; k < nodes->count; k++) {
        unroll(surface, nodes->u[k], nodes->v[k], at[k]);
        if (nodes->i[k] == 0 && nodes->j[k] == 0)
            memcpy(from, at[k], sizeof from);
    }
    for (int side = 0; side < 2; side++) {
        double cosine = 0, sine = 0;
        for (int pass = 0; pass < 2; pass++)
            for (size_t k = 0; k < nodes->count; k++) {
                double x = (at[k][0] - from[0]) / d, y = (at[k][1] - from[1]) / d;
                double i = nodes->i[k], j = side ? -nodes->j[k] : nodes->j[k];
                double size = hypot(cosine, sine);
                if (pass == 0) {
                    cosine += x * i + y * j;
                    sine += y * i - x * j;
                } else {
                    gap[side] = fmax(gap[side], hypot(x - (cosine * i - sine * j) / size,
                                                      y - (sine * i + cosine * j) / size));
                }
            }
    }
    free(at);
    return fmin(gap[0], gap[1]);
}

double cells_area(const struct drape_run *run) {
    static const int corner[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    const struct drape_cells *cells = &run->result.cells;
    double sum = 0;
    for (size_t k = 0; k < cells->count; k++) {
        struct vec3 r[4];
        for (int c = 0; c < 4; c++) {
            int at = grid_find(&run->grid, cells->i[k] + corner[c][0], cells->j[k] + corner[c][1]);
            r[c] = node_point(&run->result.nodes, at);
        }
        for (int c = 0; c < 4; c++) { /* the triangle at each corner, twice half the cell */
            struct vec3 a = vec3_sub(r[(c + 1) % 4], r[c]), b = vec3_sub(r[(c + 3) % 4], r[c]);
            sum += vec3_norm(vec3_cross(a, b)) / 4;
        }
    }
    return sum;
}

double rim_flat_area(const struct drape_rim *rim, const double spacing[2]) {
    double area = 0;
    for (size_t first = 0, k = 0; k < rim->count; k++) {
        bool last = k + 1 == rim->count || rim->loop[k + 1] != rim->loop[k];
        size_t next = last ? first : k + 1;
        area += (rim->p[k] * rim->q[next] - rim->p[next] * rim->q[k]) / 2;
        first = last ? k + 1 : first;
    }
    return area * spacing[0] * spacing[1];
}

double sphere_gap(const struct drape_run *run, struct vec3 centre, const struct frame *start,
                  const double arc[2], int n) {
    struct vec3 *exact = malloc(sizeof *exact * (size_t)((n + 1) * (n + 1)));
    double worst = 0;
    assert_non_null(exact);
    for (int q = 0; q < 4; q++) {
        int a = q % 2 ? -1 : 1, b = q / 2 ? -1 : 1;
        struct frame frame = {vec3_sub(start->r, centre), vec3_scale(a, start->warp),
                              vec3_scale(b, start->weft)};
        sphere_recursion(vec3_norm(frame.r), &frame, arc, (int[2]){n, n}, exact);
        for (int k = 0; k < (n + 1) * (n + 1); k++) {
            int at = grid_find(&run->grid, a * (k % (n + 1)), b * (k / (n + 1)));
            if (at >= 0) {
                struct vec3 r = vec3_sub(node_point(&run->result.nodes, at), centre);
                worst = fmax(worst, vec3_distance(r, exact[k]));
            }
        }
    }
    free(exact);
    return worst;
}

/* Sorted by j, then i, without repetition. */
static bool in_order(int i0, int j0, int i1, int j1) {
    return j1 > j0 || (j1 == j0 && i1 > i0);
}

/* The largest coordinate of a control point: how far rounding reaches. */
static double size_of(const struct shape *shape) {
    double size = 0;
    for (int k = 0; k < shape->size[0] * shape->size[1]; k++) {
        size = fmax(size, vec3_norm(shape->points[k]));
    }
    return size;
}

static void check_nodes(const struct shape *shape, const struct drape_run *run) {
    const struct drape_nodes *nodes = &run->result.nodes;
    double lower[2], upper[2], size = size_of(shape);
    shape_domain(shape, lower, upper);
    for (size_t k = 0; k < nodes->count; k++) {
        double uv[2] = {nodes->u[k], nodes->v[k]};
        if (k > 0) {
            assert_true(in_order(nodes->i[k - 1], nodes->j[k - 1], nodes->i[k], nodes->j[k]));
        }
        check_at_least(uv[0], lower[0]);
        check_at_most(uv[0], upper[0]);
        check_at_least(uv[1], lower[1]);
        check_at_most(uv[1], upper[1]);
        assert_true(isfinite(nodes->shear_deg[k]));
        double off = vec3_distance(shape_point(shape, uv), node_point(nodes, (int)k));
        check_at_most(off, EVALUATION_TOLERANCE * size);
        assert_true(!nodes->error_estimate || isfinite(nodes->error_estimate[k]));
    }
    check_at_least(grid_find(&run->grid, 0, 0), 0);
}

/* The direction of the sum of the two edges of cell (i, j) along (di, dj). */
static struct vec3 mean_edge(const struct drape_run *run, int i, int j, int di, int dj) {
    struct vec3 sum = {0, 0, 0};
    for (int side = 0; side < 2; side++) {
        int p = i + side * dj, q = j + side * di;
        int from = grid_find(&run->grid, p, q), to = grid_find(&run->grid, p + di, q + dj);
        sum = vec3_add(sum, vec3_sub(node_point(&run->result.nodes, to),
                                     node_point(&run->result.nodes, from)));
    }
    return vec3_unit(sum);
}

static double cosine(struct vec3 a, struct vec3 b) {
    return vec3_dot(vec3_unit(a), vec3_unit(b));
}

/* The directions of a cell have the bisectors of its mean edges; the angle between them is that in
 * the surface, which differs where the cell lies across a fold. */
static void check_cells(const struct drape_run *run) {
    const struct drape_cells *cells = &run->result.cells;
    const struct drape_nodes *nodes = &run->result.nodes;
    const struct grid *grid = &run->grid;
    size_t full = 0;
    for (size_t k = 0; k < nodes->count; k++) {
        int i = nodes->i[k], j = nodes->j[k];
        full += grid_find(grid, i + 1, j) >= 0 && grid_find(grid, i, j + 1) >= 0 &&
                grid_find(grid, i + 1, j + 1) >= 0;
    }
    assert_int_equal(cells->count, full);
    for (size_t k = 0; k < cells->count; k++) {
        int i = cells->i[k], j = cells->j[k];
        assert_true(k == 0 || in_order(cells->i[k - 1], cells->j[k - 1], i, j));
        check_at_least(grid_find(grid, i, j), 0);
        check_at_least(grid_find(grid, i + 1, j), 0);
        check_at_least(grid_find(grid, i, j + 1), 0);
        check_at_least(grid_find(grid, i + 1, j + 1), 0);
        struct vec3 warp = {cells->warp_x[k], cells->warp_y[k], cells->warp_z[k]};
        struct vec3 weft = {cells->weft_x[k], cells->weft_y[k], cells->weft_z[k]};
        check_below(fabs(vec3_norm(warp) - 1), 1e-12);
        check_below(fabs(vec3_norm(weft) - 1), 1e-12);
        double shear = 90 - vec3_angle(warp, weft) * 180 / M_PI;
        check_below(fabs(shear - cells->shear_deg[k]), 1e-8);
        struct vec3 a = mean_edge(run, i, j, 1, 0), b = mean_edge(run, i, j, 0, 1);
        check_above(cosine(vec3_add(warp, weft), vec3_add(a, b)), MEAN_COSINE);
        check_above(cosine(vec3_sub(weft, warp), vec3_sub(b, a)), MEAN_COSINE);
    }
}

/* Each place once; `boundary` at the last node inside, anything else beside the net. */
static void check_front(const struct drape_run *run) {
    const struct drape_front *front = &run->result.front;
    size_t counts[DRAPE_REASON_COUNT] = {0};
    for (size_t k = 0; k < front->count; k++) {
        int i = front->i[k], j = front->j[k];
        bool beside = false, there = grid_find(&run->grid, i, j) >= 0;
        for (int l = 0; l < 9; l++) {
            beside = beside || grid_find(&run->grid, i + l % 3 - 1, j + l / 3 - 1) >= 0;
        }
        assert_true(k == 0 || in_order(front->i[k - 1], front->j[k - 1], i, j));
        check_below(front->reason[k], DRAPE_REASON_COUNT);
        counts[front->reason[k]]++;
        assert_true(there == (front->reason[k] == DRAPE_REASON_BOUNDARY) && beside);
    }
    for (int k = 0; k < DRAPE_REASON_COUNT; k++) {
        assert_int_equal(counts[k], run->result.summary.front_reasons[k]);
    }
}

/* Points of the rim lie on the surface, and nowhere further apart on the cloth than yarns of a
 * third of a spacing let them; together they go round what the summary says. */
static void check_rim(const struct shape *shape, const struct drape_settings *settings,
                      const struct drape_run *run) {
    const struct drape_rim *rim = &run->result.rim;
    const struct drape_summary *summary = &run->result.summary;
    double size = size_of(shape), least = fmin(settings->spacing[0], settings->spacing[1]);
    bool covered = rim->count > 0;
    for (size_t first = 0, k = 0; k < rim->count; k++) {
        bool last = k + 1 == rim->count || rim->loop[k + 1] != rim->loop[k];
        size_t next = last ? first : k + 1;
        struct vec3 r = {rim->x[k], rim->y[k], rim->z[k]};
        struct vec3 to = {rim->x[next], rim->y[next], rim->z[next]};
        double dp = rim->p[next] - rim->p[k], dq = rim->q[next] - rim->q[k];
        assert_true(isfinite(rim->p[k]) && isfinite(rim->q[k]));
        check_below(vec3_distance(shape_point(shape, (double[2]){rim->u[k], rim->v[k]}), r),
                    1e-9 * size);
        if (rim->covered[k] && rim->covered[next] && !summary->front_reasons[DRAPE_REASON_FOLD])
            check_at_most(hypot(dp, dq), 0.2 + 20 * vec3_distance(r, to) / least);
        covered = covered && rim->covered[k];
        first = last ? k + 1 : first;
    }
    double flat = rim_flat_area(rim, settings->spacing);
    check_at_least(summary->cloth_coverage, 0);
    check_at_most(summary->cloth_coverage, 1);
    assert_true(
        (summary->outcome == DRAPE_COMPLETE) ==
        (summary->cloth_coverage >= DRAPE_COMPLETE_COVERAGE && run->result.cells.count > 0));
    /* where the cloth meets itself some lies between the two, and the sum is as exact as a cell */
    bool apart = summary->front_reasons[DRAPE_REASON_FOLD] == 0;
    if (covered && summary->outcome == DRAPE_COMPLETE)
        check_below(fabs(flat - summary->flat_area), (apart ? 1e-6 : 5e-3) * flat);
}

void check_result(const struct shape *shape, const struct drape_settings *settings,
                  const struct drape_run *run) {
    const struct drape_result *result = &run->result;
    const struct drape_summary *summary = &result->summary;
    double worst = 0, spacing = fmin(settings->spacing[0], settings->spacing[1]);
    check_nodes(shape, run);
    check_cells(run);
    check_front(run);
    check_rim(shape, settings, run);
    for (size_t k = 0; k < result->nodes.count; k++)
        worst = fmax(worst, fabs(result->nodes.shear_deg[k]));
    for (size_t k = 0; k < result->cells.count; k++)
        worst = fmax(worst, fabs(result->cells.shear_deg[k]));
    check_at_least(summary->max_shear_deg, worst);
    check_at_most(summary->max_shear_deg, 90);
    check_at_most(summary->p95_shear_deg, summary->max_shear_deg);
    check_at_most(summary->mean_shear_deg, summary->max_shear_deg);
    check_at_least(summary->coverage, 0);
    check_at_most(summary->coverage, 1 + 1e-9);
    check_at_least(summary->residual_max, 0);
    /* Of nodes far beyond the boundary, where polynomials cancel, more than 1e-9 may be left. */
    check_below(summary->residual_max, 2e-9 + ROUNDING * size_of(shape) / spacing);
    assert_true(isfinite(summary->newton_iterations_mean));
    for (int k = 0; k < 2; k++) {
        const int32_t *range = k ? result->weft_range : result->warp_range;
        assert_int_equal(range[0], run->grid.low[k]);
        assert_int_equal(range[1], run->grid.low[k] + run->grid.size[k] - 1);
        assert_true(!settings->has_extent[k] ||
                    (range[0] >= settings->extent[k][0] && range[1] <= settings->extent[k][1]));
    }
}
