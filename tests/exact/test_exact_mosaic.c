/* SPDX-License-Identifier: MIT */
/*
 * The method mosaic on flat and folded sheets, whose nets are squares; and its steps, in a march of
 * a few lines: on a plane they are exact, on curved surfaces their net tends to that of basic as
 * the square of the triangles' size.
 *
 * That takes generators which follow those of the surface. Straight paths on the mesh turn wherever
 * they pass its vertices, where all its curvature is, on one side or the other; along a row of
 * vertices always on the same. They tend to geodesics, but more slowly.
 */
#include "march.h"
#include "measure.h"
#include "profile.h"
#include "scenes.h"
#include "solver/mesh/corner.h"
#include "solver/mesh/path.h"
#include "solver/mesh/tessellation.h"
#include "tests/check.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { CELLS = 10, SIDE = 2 * CELLS + 1 };

static const size_t plenty = 4000000;

/* Nodes (i, j), -CELLS..CELLS. */
struct net {
    struct mesh_point node[SIDE][SIDE];
    double residual;
};

static struct mesh_point *node_at(struct net *net, int i, int j) {
    return &net->node[j + CELLS][i + CELLS];
}

static struct mesh *tessellate(struct shape *shape, double size, struct arena *arena) {
    struct nurbs nurbs = shape_nurbs(shape);
    struct surface *surface;
    struct mesh *mesh;
    assert_int_equal(surface_make(&nurbs, arena, &surface), STATUS_OK);
    assert_int_equal(mesh_from_surface(surface, size, plenty, arena, &mesh), STATUS_OK);
    return mesh;
}

/* Straight on along `direction`, or with the nodes of a net on the surface from one to the next. */
static void march_arm(const struct mesh *mesh, struct net *net, int di, int dj,
                      struct vec3 direction, double d, const struct drape_nodes *along) {
    struct mesh_path path;
    assert_true(mesh_path_straight(&path, mesh, node_at(net, 0, 0), direction));
    for (int k = 1; k <= CELLS; k++) {
        int at = (k * dj + CELLS) * SIDE + k * di + CELLS;
        if (along)
            assert_true(mesh_path_towards(&path, mesh, node_at(net, (k - 1) * di, (k - 1) * dj),
                                          node_point(along, at)));
        assert_int_equal(mesh_path_chord(&path, d), MESH_PATH_DONE);
        *node_at(net, k * di, k * dj) = path.at;
    }
}

static void march_cell(const struct mesh *mesh, struct net *net, int i, int j, const double d[2]) {
    int si = i > 0 ? 1 : -1, sj = j > 0 ? 1 : -1;
    struct mesh_cell cell = {.a = *node_at(net, i - si, j - sj),
                             .b = *node_at(net, i - si, j),
                             .c = *node_at(net, i, j - sj),
                             .bd = d[0],
                             .cd = d[1],
                             .orientation = si * sj};
    struct mesh_corner corner;
    cell.guess = vec3_sub(vec3_add(cell.b.r, cell.c.r), cell.a.r);
    assert_int_equal(mesh_corner_solve(mesh, &cell, &corner), MESH_CORNER_FOUND);
    *node_at(net, i, j) = corner.at;
    net->residual = fmax(net->residual, corner.residual);
}

static void march_all(const struct mesh *mesh, struct net *net, const struct plain_setup *setup,
                      const struct drape_nodes *along) {
    const double *d = setup->spacing;
    struct vec3 start = shape_point(setup->shape, setup->uv);
    net->residual = 0;
    assert_true(mesh_nearest(mesh, start, MESH_ANY, node_at(net, 0, 0), NULL));
    for (int sign = -1; sign <= 1; sign += 2) {
        march_arm(mesh, net, sign, 0, vec3_scale(sign, setup->warp), d[0], along);
        march_arm(mesh, net, 0, sign, vec3_scale(sign, setup->weft), d[1], along);
    }
    for (int j = 1; j <= CELLS; j++)
        for (int i = 1; i <= CELLS; i++)
            for (int k = 0; k < 4; k++)
                march_cell(mesh, net, k & 1 ? -i : i, k & 2 ? -j : j, d);
}

/* The largest distance between two nets' nodes. */
static double net_gap(struct net *net, const struct drape_nodes *nodes) {
    double worst = 0;
    for (size_t at = 0; at < nodes->count; at++) {
        struct vec3 r = node_at(net, nodes->i[at], nodes->j[at])->r;
        worst = fmax(worst, vec3_distance(r, node_point(nodes, (int)at)));
    }
    return worst;
}

static struct plain_setup make_setup(const struct shape *shape, const double uv[2],
                                     double angle_deg, double d) {
    struct plain_setup setup = {.shape = shape,
                                .uv = {uv[0], uv[1]},
                                .method = DRAPE_BASIC,
                                .spacing = {d, 0.8 * d},
                                .n = {CELLS, CELLS}};
    shape_frame(shape, uv, angle_deg, 0, &setup.warp, &setup.weft);
    return setup;
}

enum { ANGLES = 12, SIZES = 4 };

/* The mosaic nets of all directions on triangles of one size, along the nets' own generators or
 * straight on: the root mean square of their errors. */
static double mean_error(const struct mesh *mesh, const struct plain_setup *setups,
                         struct drape_nodes *const *nodes, bool along) {
    static struct net net;
    double sum = 0;
    for (int k = 0; k < ANGLES; k++) {
        march_all(mesh, &net, &setups[k], along ? nodes[k] : NULL);
        check_at_most(net.residual, 1e-12);
        double error = net_gap(&net, nodes[k]) / (CELLS * setups[k].spacing[0]);
        sum += error * error;
    }
    return sqrt(sum / ANGLES);
}

static double print_order(const double error[SIZES]) {
    double order = order_of(error[0], error[SIZES - 1]) / (SIZES - 1);
    for (int k = 0; k < SIZES; k++)
        printf(" %.1e", error[k]);
    printf(" (%.2f)", order);
    return order;
}

/* Against the basic nets for triangles of d / 2, d / 4, d / 8, d / 16. */
static void check_order(const char *name, struct shape *shape, const double uv[2], double d) {
    struct plain_setup setups[ANGLES];
    struct drape_nodes *nodes[ANGLES];
    double along[SIZES], straight[SIZES];
    for (int k = 0; k < ANGLES; k++) {
        setups[k] = make_setup(shape, uv, 3 + 360.0 * k / ANGLES, d);
        nodes[k] = plain_make(&setups[k]);
    }
    for (int k = 0; k < SIZES; k++) {
        struct arena *arena = arena_new((size_t)1 << 32);
        const struct mesh *mesh = tessellate(shape, ldexp(d, -k - 1), arena);
        along[k] = mean_error(mesh, setups, nodes, true);
        straight[k] = mean_error(mesh, setups, nodes, false);
        arena_free(arena);
    }
    printf("  %-11s", name);
    double order = print_order(along);
    printf("  straight:");
    double straight_order = print_order(straight);
    printf("\n");
    check_above(order, 1.9);
    check_below(along[1], 2e-4);
    check_above(straight_order, 1.3);
    check_below(straight[1], 1e-3);
    for (int k = 0; k < ANGLES; k++)
        plain_free(nodes[k]);
}

static void test_exact_mosaic_converges_to_basic(void **state) {
    static struct shape shape;
    (void)state;
    const double patch[2] = {-0.6, 0.6}, middle[2] = {0.03, -0.02};
    shape_stereographic(&shape, 50, patch, patch);
    check_order("sphere", &shape, middle, 2.5);
    const double turn[2] = {0, 3}, lower[2] = {1, -1.5}, upper[2] = {1, 1.5}, on[2] = {0.48, 0.53};
    shape_frustum(&shape, turn, lower, upper, 1);
    check_order("cylinder", &shape, on, 0.08);
    const double rim[2] = {2, 1};
    shape_frustum(&shape, turn, lower, rim, 1);
    check_order("cone", &shape, on, 0.08);
    const double square[2] = {-1.4, 1.4}, near[2] = {0.1, 0.07};
    shape_quadric(&shape, 1, -1, square, square);
    check_order("saddle", &shape, near, 0.08);
    shape_quadric(&shape, 0.6, 1, square, square);
    check_order("paraboloid", &shape, near, 0.08);
}

/* Whatever the triangles: here they come from uneven rows. */
static void test_exact_mosaic_is_exact_on_a_plane(void **state) {
    static struct shape shape;
    static struct net net;
    const double x[2] = {-2, 3}, y[2] = {-2, 2}, uv[2] = {0.2, 0.1};
    const struct motion motion = motion_similar(3, vec3_make(1, 2, -1), 1.1, vec3_make(10, -20, 5));
    (void)state;
    for (int k = 0; k < 24; k++) {
        struct arena *arena = arena_new((size_t)1 << 30);
        shape_plane(&shape, x, y);
        shape_insert_knot(&shape, 0, 0.37);
        shape_move(&shape, &motion);
        struct plain_setup setup = make_setup(&shape, uv, 15.0 * k, 0.3);
        march_all(tessellate(&shape, k % 2 ? 0.17 : 0.9, arena), &net, &setup, NULL);
        struct vec3 start = node_at(&net, 0, 0)->r;
        double worst = 0;
        for (int j = -CELLS; j <= CELLS; j++)
            for (int i = -CELLS; i <= CELLS; i++) {
                struct vec3 r = vec3_axpy(i * setup.spacing[0], setup.warp, start);
                r = vec3_axpy(j * setup.spacing[1], setup.weft, r);
                worst = fmax(worst, vec3_distance(r, node_at(&net, i, j)->r));
            }
        check_below(worst, 1e-12);
        arena_free(arena);
    }
}

/* Over a crease the net stays square: unrolled, it is that of the plane. */
static void test_exact_mosaic_is_exact_over_a_crease(void **state) {
    static struct shape shape;
    static struct net net;
    const double uv[2] = {0.43, 0.5}, rise = 0.6;
    (void)state;
    for (int k = 0; k < 12; k++) {
        struct arena *arena = arena_new((size_t)1 << 30);
        shape_crease(&shape, 1, rise);
        struct plain_setup setup = make_setup(&shape, uv, 90.0 * k, 0.05);
        march_all(tessellate(&shape, 0.01 * (k + 1), arena), &net, &setup, NULL);
        struct vec3 start = node_at(&net, 0, 0)->r;
        double worst = 0;
        for (int j = -CELLS; j <= CELLS; j++)
            for (int i = -CELLS; i <= CELLS; i++) {
                struct vec3 r = node_at(&net, i, j)->r;
                struct vec3 side = k % 2 ? setup.warp : setup.weft;
                int across = k % 2 ? i : j;
                double d = setup.spacing[k % 2 ? 0 : 1];
                worst = fmax(worst, fabs(vec3_dot(vec3_sub(r, start), side) - across * d));
            }
        check_below(worst, 1e-12);
        arena_free(arena);
    }
}

/* ---- whole drapes ---- */

/* A flat sheet of one of four shapes: a quadrilateral, one with a corner drawn into a pole, a disk
 * with four singular corners, a net of control points moved within the plane. */
static void make_flat(struct shape *shape, int kind, uint64_t *seed) {
    const double x[2] = {0, random_between(seed, 50, 130)},
                 y[2] = {0, random_between(seed, 40, 99)};
    if (kind == 2) {
        shape_disk(shape, y[1] / 2);
        return;
    }
    shape_plane(shape, x, y);
    if (kind == 1) /* h[0] and h[1] are the ends of the edge u = 0 */
        memcpy(shape->h[1], shape->h[0], sizeof shape->h[0]);
    for (int k = 0; k < 4 && kind != 1; k++)
        for (int n = 0; n < 2; n++)
            shape->h[k][n] += random_between(seed, -12, 12);
    if (kind == 3)
        for (int k = 0; k < 3; k++)
            shape_insert_knot(shape, k % 2, random_between(seed, 0.2, 0.8) * (k % 2 ? y[1] : x[1]));
}

/* However a flat sheet is shaped and turned, wherever the net starts and in whatever direction: it
 * is covered by square cells. */
static int wrong_flat_sheet(uint64_t name) {
    static struct shape shape;
    uint64_t seed = name;
    struct drape_run run;
    double d = random_between(&seed, 2, 7);
    struct drape_settings settings = {.method = DRAPE_MOSAIC,
                                      .spacing = {d, d},
                                      .direction_deg = random_between(&seed, 0, 360),
                                      .start_kind = DRAPE_START_UV,
                                      .max_nodes = 100000};
    make_flat(&shape, (int)(name % 4), &seed);
    for (int k = 0; k < 2; k++) {
        const double *knots = shape.knots[k];
        settings.start_uv[k] = knots[0] + random_between(&seed, 0.1, 0.9) *
                                              (knots[shape.size[k] + shape.degree[k]] - knots[0]);
    }
    struct vec3 axis = {random_unit(&seed) - 0.5, random_unit(&seed) - 0.5, random_unit(&seed)};
    const struct motion motion =
        motion_similar(1, axis, random_between(&seed, 0, 6), vec3_make(10, -70, 30));
    shape_move(&shape, &motion);
    assert_int_equal(drape_try(&run, &shape, &settings), STATUS_OK);
    const struct drape_summary *s = &run.result.summary;
    bool wrong = !(s->cloth_coverage > 0.99) || !(s->max_shear_deg < 1e-6) ||
                 s->front_reasons[DRAPE_REASON_BOUNDARY] != run.result.front.count;
    if (wrong)
        printf("  sheet %llu: %.4f covered, %.3f degrees\n", (unsigned long long)name,
               s->cloth_coverage, s->max_shear_deg);
    drape_end(&run);
    return wrong;
}

static void test_exact_mosaic_covers_flat_sheets(void **state) {
    (void)state;
    assert_int_equal(check_rounds(1, 400, 40, wrong_flat_sheet), 0);
}

/* Up to three folds of 20 to 140 degrees, one way and the other, with a start anywhere, on a fold
 * too: the net is the square grid on the unrolled sheet. At its edge cloth is cut cell by cell, and
 * mosaic knows none beyond: there it may miss a part of those that lie across a fold. */
static int wrong_folded_sheet(uint64_t name) {
    static struct profile_sheet sheet;
    struct profile_part parts[4] = {{0, 0, 20}};
    uint64_t seed = name;
    int count = 2 + (int)(name % 3);
    for (int k = 0; k < count; k++)
        parts[k] = (struct profile_part){.turn_deg = k == 0 ? 0 : random_between(&seed, 20, 140),
                                         .length = random_between(&seed, 12, 30)};
    if (count > 2)
        parts[2].turn_deg *= -1;
    profile_make(&sheet, parts, count, random_between(&seed, 25, 60));
    const double start[2] = {name % 5 ? random_between(&seed, 0.1, 0.9) * sheet.total
                                      : parts[0].length,
                             random_between(&seed, 0.1, 0.9) * sheet.width};
    double d = random_between(&seed, 1, 3), angle = name % 4 ? random_between(&seed, 0, 360) : 90;
    struct drape_run run;
    profile_drape(&sheet, DRAPE_MOSAIC, d, start, angle, &run);
    struct profile_error error = profile_measure(&sheet, d, start, angle, &run);
    bool wrong = error.missing > 0 || !(error.position < 1e-8) || !(error.most_shear_deg < 1e-4) ||
                 !(run.result.summary.cloth_coverage > 0.95);
    if (wrong)
        printf("  sheet %llu, %d folds, d %.3g at %.0f degrees: %.1e d, %.4f degrees, %d missing, "
               "%.4f covered\n",
               (unsigned long long)name, count - 1, d, angle, error.position, error.most_shear_deg,
               error.missing, run.result.summary.cloth_coverage);
    drape_end(&run);
    return wrong;
}

static void test_exact_mosaic_goes_on_over_folds(void **state) {
    (void)state;
    assert_int_equal(check_rounds(1, 200, 20, wrong_folded_sheet), 0);
}

/* Vertices - edges + triangles, those in the same place once: 2 for a sphere, 0 for a torus. */
static int compare_points(const void *a, const void *b) {
    const struct vec3 *p = a, *q = b;
    if (p->x != q->x)
        return p->x < q->x ? -1 : 1;
    if (p->y != q->y)
        return p->y < q->y ? -1 : 1;
    return (p->z > q->z) - (p->z < q->z);
}

static long euler_number(const struct mesh *mesh, size_t *rim) {
    size_t n = mesh->vertex_count, places = 0;
    struct vec3 *points = malloc(n * sizeof *points);
    memcpy(points, mesh->vertices, n * sizeof *points);
    qsort(points, n, sizeof *points, compare_points);
    for (size_t k = 0; k < n; k++)
        places += k == 0 || compare_points(&points[k - 1], &points[k]) != 0;
    free(points);
    *rim = 0;
    for (size_t e = 0; e < 3 * mesh->triangle_count; e++)
        *rim += mesh->twins[e] == MESH_NONE;
    size_t edges = (3 * mesh->triangle_count + *rim) / 2;
    return (long)places - (long)edges + (long)mesh->triangle_count;
}

/* The smallest height over the longest side among all triangles. */
static double worst_shape(const struct mesh *mesh) {
    double worst = 1;
    for (int32_t t = 0; t < (int32_t)mesh->triangle_count; t++) {
        struct vec3 p[3];
        double longest2 = 0;
        mesh_corner_points(mesh, t, p);
        for (int k = 0; k < 3; k++)
            longest2 = fmax(longest2, vec3_norm2(vec3_sub(p[(k + 1) % 3], p[k])));
        struct vec3 cross = vec3_cross(vec3_sub(p[1], p[0]), vec3_sub(p[2], p[0]));
        worst = fmin(worst, vec3_norm(cross) / longest2);
    }
    return worst;
}

static void check_closed(const char *name, struct shape *shape, double size, long euler, bool rim,
                         double area) {
    for (int transposed = 0; transposed < 2; transposed++) {
        struct arena *arena = arena_new((size_t)1 << 32);
        const struct mesh *mesh = tessellate(shape, size, arena);
        size_t edges;
        printf("  %-12s %6zu triangles, area %.4f of the true one, shapes %.2f\n", name,
               mesh->triangle_count, mesh->area / area, worst_shape(mesh));
        assert_int_equal(mesh->component_count, 1);
        assert_int_equal(euler_number(mesh, &edges), euler);
        assert_int_equal(edges > 0, rim);
        assert_int_equal(mesh->components[0].rim_count, edges);
        check_below(fabs(mesh->area / area - 1), 3e-3);
        check_above(worst_shape(mesh), 0.1);
        shape_transpose(shape);
        arena_free(arena);
    }
}

static void test_exact_mosaic_closes_seams_and_poles(void **state) {
    static struct shape shape;
    (void)state;
    const double round[2] = {0, 2 * M_PI}, half[2] = {0, M_PI / 2}, all[2] = {-M_PI / 2, M_PI / 2};
    shape_sphere(&shape, 1, round, all, M_PI / 2);
    check_closed("sphere", &shape, 0.05, 2, false, 4 * M_PI);
    check_closed("sphere", &shape, 0.013, 2, false, 4 * M_PI);
    shape_sphere(&shape, 1, round, half, M_PI / 2);
    check_closed("hemisphere", &shape, 0.05, 1, true, 2 * M_PI);
    shape_sphere(&shape, 1, half, half, M_PI / 2);
    check_closed("octant", &shape, 0.05, 1, true, M_PI / 2);
    shape_torus(&shape, 2, 0.7, round, round, M_PI / 2);
    check_closed("torus", &shape, 0.05, 0, false, 4 * M_PI * M_PI * 1.4);
    const double low[2] = {1, 0}, high[2] = {1, 3}, tip[2] = {0, 3};
    shape_frustum(&shape, round, low, high, M_PI / 2);
    check_closed("cylinder", &shape, 0.05, 0, true, 6 * M_PI);
    shape_frustum(&shape, round, low, tip, M_PI / 2);
    check_closed("cone", &shape, 0.05, 1, true, M_PI * sqrt(10));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_exact_mosaic_converges_to_basic),
        cmocka_unit_test(test_exact_mosaic_is_exact_on_a_plane),
        cmocka_unit_test(test_exact_mosaic_is_exact_over_a_crease),
        cmocka_unit_test(test_exact_mosaic_covers_flat_sheets),
        cmocka_unit_test(test_exact_mosaic_goes_on_over_folds),
        cmocka_unit_test(test_exact_mosaic_closes_seams_and_poles),
    };
    return cmocka_run_group_tests_name("exact_mosaic", tests, NULL, NULL);
}
