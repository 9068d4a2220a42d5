/* SPDX-License-Identifier: MIT */
/*
 * Behind a hole of a mesh the net comes together from both sides. In a plane that fits. With
 * curvature in the hole it is out of step, by several spacings on the saddle below: there the net
 * ends, and no yarn is longer or shorter than its spacing.
 */
#include "measure.h"
#include "solver/mesh/mesh.h"
#include "tests/check.h"
#include <stdio.h>

enum { CELLS = 80 };

static const double spacing = 0.03;

/* A square with a round hole, or one with a bar in it. */
static bool in_disc(double x, double y) {
    return hypot(x - 0.55, y - 0.55) < 0.3;
}

static bool in_bar(double x, double y) {
    return fabs(x - 0.5) < 0.04 && fabs(y - 0.5) < 0.4;
}

static struct vec3 place(double x, double y, double bend) {
    return vec3_make(x, y, bend * (x - 0.5) * (y - 0.5));
}

/* The sheet z = bend (x - 1/2) (y - 1/2) over the unit square, but for the hole. */
static struct mesh *make_sheet(double bend, bool (*hole)(double, double), struct arena *arena) {
    static struct vec3 vertices[CELLS * CELLS * 4];
    static int32_t triangles[CELLS * CELLS * 2][3];
    size_t vertex = 0, triangle = 0;
    for (int k = 0; k < CELLS * CELLS; k++) {
        int i = k / CELLS, j = k % CELLS, first = (int)vertex;
        if (hole((i + 0.5) / CELLS, (j + 0.5) / CELLS))
            continue;
        for (int corner = 0; corner < 4; corner++)
            vertices[vertex++] =
                place((double)(i + corner / 2) / CELLS, (double)(j + corner % 2) / CELLS, bend);
        const int32_t two[2][3] = {{first, first + 2, first + 3}, {first, first + 3, first + 1}};
        for (int at = 0; at < 6; at++)
            triangles[triangle + (size_t)at / 3][at % 3] = two[at / 3][at % 3];
        triangle += 2;
    }
    struct mesh_source source = {.vertices = vertices,
                                 .vertex_count = vertex,
                                 .triangles = (const int32_t(*)[3])triangles,
                                 .triangle_count = triangle};
    struct mesh *mesh;
    struct mesh_fault fault;
    assert_int_equal(mesh_make(&source, arena, &mesh, &fault), STATUS_OK);
    return mesh;
}

/* The largest shares of its spacing by which the chord of a yarn in a cell is shorter and longer.
 */
struct misfit {
    double shorter, longer;
};

static struct misfit worst_edges(const struct drape_result *result) {
    const struct drape_nodes *n = &result->nodes;
    const struct drape_cells *c = &result->cells;
    struct grid grid;
    struct misfit worst = {0, 0};
    grid_make(&grid, n);
    for (size_t k = 0; k < c->count; k++) {
        static const int corner[5][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}};
        for (int edge = 0; edge < 4; edge++) {
            int from = grid_find(&grid, c->i[k] + corner[edge][0], c->j[k] + corner[edge][1]);
            int to = grid_find(&grid, c->i[k] + corner[edge + 1][0], c->j[k] + corner[edge + 1][1]);
            double chord = vec3_distance(node_point(n, from), node_point(n, to));
            worst.shorter = fmax(worst.shorter, 1 - chord / spacing);
            worst.longer = fmax(worst.longer, chord / spacing - 1);
        }
    }
    grid_free(&grid);
    return worst;
}

struct sheet {
    double bend, angle_deg;
    bool (*hole)(double, double);
    enum drape_method method;
    enum { FITS, TEARS, EITHER } end;
};

/* What the net says of its end is checked. */
static struct misfit drape_sheet(const struct sheet *s) {
    struct arena *arena = arena_new((size_t)1 << 28);
    double angle = M_PI / 180 * s->angle_deg;
    struct drape_settings settings = {.method = s->method,
                                      .spacing = {spacing, spacing},
                                      .start_kind = DRAPE_START_POINT,
                                      .start_point = place(0.1, 0.2, s->bend),
                                      .direction_kind = DRAPE_DIRECTION_VECTOR,
                                      .direction_vector = {cos(angle), sin(angle), 0},
                                      .max_nodes = 100000};
    struct mesh *mesh = make_sheet(s->bend, s->hole, arena);
    struct drape_result result;
    assert_int_equal(
        drape_solve(&(struct drape_part){.mesh = mesh}, &settings, NULL, arena, &result),
        STATUS_OK);
    const struct drape_summary *summary = &result.summary;
    struct misfit worst = worst_edges(&result);
    printf(
        "  bend %.2f  %2.0f deg  method %d: %zu cells, edges -%.1e +%.1e, %zu places out of step, "
        "cloth %.4f\n",
        s->bend, s->angle_deg, (int)s->method, result.cells.count, worst.shorter, worst.longer,
        summary->front_reasons[DRAPE_REASON_FOLD], summary->cloth_coverage);
    if (s->end != EITHER) {
        assert_int_equal(summary->front_reasons[DRAPE_REASON_FOLD] == 0, s->end == FITS);
        assert_int_equal(summary->outcome == DRAPE_COMPLETE, s->end == FITS);
    }
    check_at_most(summary->coverage, summary->cloth_coverage);
    arena_free(arena);
    return worst;
}

static void test_exact_join_in_step(void **state) {
    (void)state;
    const struct sheet flat[] = {{0, 20, in_disc, DRAPE_MOSAIC, FITS},
                                 {0, 45, in_bar, DRAPE_GIB, FITS},
                                 {0, 0, in_bar, DRAPE_MOSAIC, FITS}};
    for (size_t k = 0; k < sizeof flat / sizeof *flat; k++) {
        struct misfit worst = drape_sheet(&flat[k]);
        check_below(fmax(worst.shorter, worst.longer), 1e-9);
    }
}

static void test_exact_join_out_of_step(void **state) {
    (void)state;
    const struct sheet bent[] = {{0.8, 0, in_disc, DRAPE_MOSAIC, TEARS},
                                 {0.8, 20, in_disc, DRAPE_GIB, TEARS},
                                 {0.8, 20, in_bar, DRAPE_BASIC, TEARS},
                                 {0.8, 45, in_bar, DRAPE_MOSAIC, TEARS},
                                 {-0.8, 30, in_bar, DRAPE_GIB, TEARS}};
    for (size_t k = 0; k < sizeof bent / sizeof *bent; k++) {
        struct misfit worst = drape_sheet(&bent[k]);
        check_below(fmax(worst.shorter, worst.longer), 1e-3);
    }
}

/* Cloth gives way to a hundredth of a spacing, but hardly stretches. */
static void test_exact_join_by_less_than_a_hundredth(void **state) {
    (void)state;
    for (int k = 1; k <= 10; k++) {
        const struct sheet sheet = {0.01 * k, 9 * k, k % 2 ? in_disc : in_bar,
                                    k % 3 ? DRAPE_GIB : DRAPE_MOSAIC, EITHER};
        struct misfit worst = drape_sheet(&sheet);
        check_below(worst.shorter, 1e-2);
        check_below(worst.longer, 1e-3);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_exact_join_in_step),
                                       cmocka_unit_test(test_exact_join_out_of_step),
                                       cmocka_unit_test(test_exact_join_by_less_than_a_hundredth)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
