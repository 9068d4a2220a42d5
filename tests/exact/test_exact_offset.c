/* SPDX-License-Identifier: MIT */
/*
 * Surfaces moved along their normal (solver/shell/offset.h): on planes, cylinders, cones, spheres
 * and tori the moved surface is one of the kind with the same parameters, so its net is known; on
 * others its derivatives are differences of its points.
 */
#include "measure.h"
#include "solver/shell/offset.h"
#include "solver/shell/shell.h"
#include "solver/surface/trim.h"
#include "tests/check.h"
#include <stdio.h>
#include <string.h>

static const double WHOLE[2] = {0, 2 * M_PI};

/* ---- surfaces that are moved into others of their kind ---- */

static void make_plane(struct shape *shape, double h) {
    struct motion up = motion_identity();
    up.shift.z = h;
    shape_plane(shape, (double[2]){0, 2}, (double[2]){0, 1.5});
    shape_move(shape, &up);
}

static void make_cylinder(struct shape *shape, double h) {
    shape_frustum(shape, WHOLE, (double[2]){1 + h, 0}, (double[2]){1 + h, 2}, M_PI / 2);
}

/* The profile falls by 1 over 1.5: its normal is (1.5, 0.5) / sqrt(2.5). */
static void make_cone(struct shape *shape, double h) {
    double out = h * 1.5 / sqrt(2.5), up = h * 0.5 / sqrt(2.5);
    shape_frustum(shape, (double[2]){0, M_PI / 2}, (double[2]){1 + out, up},
                  (double[2]){0.5 + out, 1.5 + up}, M_PI / 2);
}

static void make_sphere(struct shape *shape, double h) {
    shape_sphere(shape, 1 + h, WHOLE, (double[2]){-M_PI / 2, M_PI / 2}, M_PI / 2);
}

static void make_octant(struct shape *shape, double h) {
    shape_sphere(shape, 1 + h, (double[2]){0, M_PI / 2}, (double[2]){0, M_PI / 2}, M_PI / 2);
}

static void make_patch(struct shape *shape, double h) {
    shape_stereographic(shape, 1 + h, (double[2]){-0.1, 0.5}, (double[2]){-0.45, 0.05});
}

static void make_torus(struct shape *shape, double h) {
    shape_torus(shape, 2, 0.7 + h, (double[2]){0, M_PI / 2}, (double[2]){-M_PI / 2, M_PI / 2},
                M_PI / 2);
}

static void make_whole_torus(struct shape *shape, double h) {
    shape_torus(shape, 2, 0.7 + h, WHOLE, WHOLE, M_PI / 2);
}

struct kind {
    const char *name;
    void (*make)(struct shape *shape, double h);
    double start[2], spacing, angle_deg;
};

static const struct kind kinds[] = {
    {"plane", make_plane, {0.9, 0.6}, 0.06, 20},
    {"cylinder", make_cylinder, {0.3, 0.45}, 0.1, 20},
    {"cone", make_cone, {0.4, 0.5}, 0.06, 20},
    {"sphere", make_sphere, {0.2, 0.55}, 0.1, 20},
    {"octant from the pole", make_octant, {0, 1}, 0.05, 0},
    {"sphere patch", make_patch, {0.1, -0.1}, 0.03, 20},
    {"quarter torus", make_torus, {0.4, 0.5}, 0.08, 20},
    {"torus", make_whole_torus, {0.1, 0.2}, 0.12, 20},
};
enum { KINDS = sizeof kinds / sizeof *kinds };

/* Which way r_u x r_v looks: outwards is 1. */
static double outward(const struct kind *kind) {
    struct shape shape, wider;
    kind->make(&shape, 0);
    kind->make(&wider, 1e-3);
    struct surface_jet jet;
    double at[2] = {kind->start[0], kind->start[1] - (kind->start[1] == 1 ? 0.3 : 0)};
    shape_evaluate(&shape, at[0], at[1], &jet);
    struct vec3 way = vec3_sub(shape_point(&wider, at), jet.r);
    return vec3_dot(way, jet_normal(&jet)) > 0 ? 1 : -1;
}

/* The surface with h = 0 moved by h. */
static struct surface *moved(const struct kind *kind, double h, struct arena *arena) {
    struct shape shape;
    struct surface *base, *result;
    kind->make(&shape, 0);
    struct nurbs nurbs = shape_nurbs(&shape);
    assert_int_equal(surface_make(&nurbs, arena, &base), STATUS_OK);
    assert_int_equal(surface_offset(base, outward(kind) * h, arena, &result), STATUS_OK);
    return result;
}

static double jet_gap(const struct surface_jet *a, const struct surface_jet *b, double unit) {
    double gap = vec3_distance(a->r, b->r);
    gap = fmax(gap, unit * fmax(vec3_distance(a->u, b->u), vec3_distance(a->v, b->v)));
    gap = fmax(gap, unit * unit * vec3_distance(a->uu, b->uu));
    gap = fmax(gap, unit * unit * vec3_distance(a->uv, b->uv));
    return fmax(gap, unit * unit * vec3_distance(a->vv, b->vv));
}

static void test_offset_has_the_jets_of_its_kind(void **state) {
    (void)state;
    for (int k = 0; k < KINDS; k++) {
        for (int side = -1; side <= 1; side += 2) {
            struct arena *arena = arena_new((size_t)1 << 26);
            double h = 0.13 * side, lower[2], upper[2], worst = 0;
            struct surface_cursor cursor = {0}, other = {0};
            struct shape shape;
            struct surface *own = moved(&kinds[k], h, arena), *wanted;
            kinds[k].make(&shape, h);
            struct nurbs nurbs = shape_nurbs(&shape);
            assert_int_equal(surface_make(&nurbs, arena, &wanted), STATUS_OK);
            surface_domain(own, lower, upper);
            for (int n = 0; n < 21 * 21; n++) {
                struct surface_jet a, b;
                double u = lower[0] + (upper[0] - lower[0]) * (n / 21) / 20.0;
                double v = lower[1] + (upper[1] - lower[1]) * (n % 21) / 20.0;
                surface_evaluate(own, &cursor, u, v, &a);
                surface_evaluate(wanted, &other, u, v, &b);
                worst = fmax(worst, jet_gap(&a, &b, 0.1));
            }
            struct vec3 centroid[2];
            double area[2] = {surface_area(own, &centroid[0]), surface_area(wanted, &centroid[1])};
            printf("%-22s h %+.2f: jets within %.2g\n", kinds[k].name, h, worst);
            check_below(worst, 1e-12);
            check_below(fabs(area[0] / area[1] - 1), 1e-12);
            check_below(vec3_distance(centroid[0], centroid[1]), 1e-12);
            for (int d = 0; d < 2; d++)
                assert_int_equal(surface_closed(own, d), surface_closed(wanted, d));
            arena_free(arena);
        }
    }
}

static const enum drape_method methods[] = {DRAPE_GIB,      DRAPE_GIB4,   DRAPE_BASIC,
                                            DRAPE_GEODESIC, DRAPE_MOSAIC, DRAPE_GIB};
enum { METHODS = sizeof methods / sizeof *methods };

/* The largest distance between nodes of the same indices. */
static double net_gap(const struct drape_nodes *a, const struct drape_nodes *b) {
    double gap = a->count == b->count ? 0 : HUGE_VAL;
    for (size_t k = 0; gap < HUGE_VAL && k < a->count; k++) {
        if (a->i[k] != b->i[k] || a->j[k] != b->j[k])
            return HUGE_VAL;
        gap = fmax(gap, vec3_distance(node_point(a, (int)k), node_point(b, (int)k)));
    }
    return gap;
}

/* Ply k of a sphere of radius R is the net of R + h; and so on. */
static void test_offset_nets_are_those_of_the_moved_surface(void **state) {
    (void)state;
    for (int k = 0; k < KINDS; k++) {
        for (int m = 0; m < METHODS; m++) {
            struct shape shape;
            struct drape_run wanted;
            struct drape_result result = {0};
            const struct kind *kind = &kinds[k];
            double h = m % 2 ? 0.11 : -0.08;
            struct drape_settings settings = {.method = methods[m],
                                              .yarn_path = m == METHODS - 1 ? DRAPE_PATH_RELAXATION
                                                                            : DRAPE_PATH_CHORD,
                                              .spacing = {kind->spacing, kind->spacing},
                                              .start_kind = DRAPE_START_UV,
                                              .start_uv = {kind->start[0], kind->start[1]},
                                              .direction_deg = kind->angle_deg,
                                              .max_nodes = 100000};
            kind->make(&shape, h);
            assert_int_equal(drape_try(&wanted, &shape, &settings), STATUS_OK);
            struct surface *own = moved(kind, h, wanted.arena);
            assert_int_equal(drape_solve(&(struct drape_part){.surface = own}, &settings, NULL,
                                         wanted.arena, &result),
                             STATUS_OK);
            double gap = net_gap(&result.nodes, &wanted.result.nodes);
            printf("%-22s h %+.2f method %d: %zu nodes within %.2g\n", kind->name, h,
                   (int)methods[m], result.nodes.count, gap);
            check_below(gap, 1e-8);
            check_below(fabs(result.summary.cloth_coverage - wanted.result.summary.cloth_coverage),
                        1e-6);
            drape_end(&wanted);
        }
    }
}

/* Nodes found side by side have the bits of those found one after the other. */
static void test_offset_has_the_same_bits_with_any_lanes(void **state) {
    (void)state;
    for (int k = 0; k < KINDS; k++) {
        struct arena *arena = arena_new((size_t)1 << 28);
        struct drape_result result[4] = {{.start_face = 0}};
        struct surface *own = moved(&kinds[k], 0.07, arena);
        for (int n = 0; n < 4; n++) {
            const struct drape_settings settings = {
                .method = DRAPE_GIB,
                .spacing = {kinds[k].spacing, kinds[k].spacing},
                .start_kind = DRAPE_START_UV,
                .start_uv = {kinds[k].start[0], kinds[k].start[1]},
                .direction_deg = kinds[k].angle_deg,
                .max_nodes = 100000,
                .lanes = 1 << n};
            assert_int_equal(drape_solve(&(struct drape_part){.surface = own}, &settings, NULL,
                                         arena, &result[n]),
                             STATUS_OK);
            const struct drape_nodes *a = &result[0].nodes, *b = &result[n].nodes;
            assert_int_equal(a->count, b->count);
            assert_memory_equal(a->x, b->x, a->count * sizeof *a->x);
            assert_memory_equal(a->shear_deg, b->shear_deg, a->count * sizeof *a->shear_deg);
        }
        arena_free(arena);
    }
}

/* ---- shells ---- */

enum { PIECES = 4 };

/* A shape cut into four faces, every second one with its normal the other way. */
static void cut_faces(const struct shape *whole, struct arena *arena, struct shell_patch *parts) {
    double lower[2], upper[2];
    shape_domain(whole, lower, upper);
    for (int n = 0; n < PIECES; n++) {
        struct shape piece = *whole;
        double range[2][2];
        for (int k = 0; k < 2; k++) {
            double middle = lower[k] + 0.45 * (upper[k] - lower[k]);
            bool second = k ? n % 2 : n / 2;
            range[k][0] = second ? middle : lower[k];
            range[k][1] = second ? upper[k] : middle;
        }
        struct surface *surface;
        shape_cut(&piece, range[0], range[1]);
        if (n % 2)
            shape_transpose(&piece);
        struct nurbs nurbs = shape_nurbs(&piece);
        assert_int_equal(surface_make(&nurbs, arena, &surface), STATUS_OK);
        parts[n] = (struct shell_patch){.surface = surface};
    }
}

static void test_offset_moves_shells_to_one_side(void **state) {
    (void)state;
    for (int side = -1; side <= 1; side += 2) {
        const struct kind *kind = &kinds[KINDS - 2]; /* the quarter torus */
        struct shape base, other;
        struct drape_run wanted;
        struct drape_result result = {0};
        struct shell_patch parts[PIECES];
        struct shell_fault fault;
        struct shell *shell;
        double h = 0.1 * side;
        kind->make(&base, 0);
        kind->make(&other, h);
        struct drape_settings settings = {.spacing = {0.08, 0.08},
                                          .method = DRAPE_GIB,
                                          .start_kind = DRAPE_START_POINT,
                                          .start_point = shape_point(&base, kind->start),
                                          .direction_kind = DRAPE_DIRECTION_VECTOR,
                                          .direction_vector = {0.3, -0.2, 1},
                                          .max_nodes = 100000};
        /* The start is given on the surface before it is moved, further from it than the spacing.
         */
        struct drape_settings there = settings;
        there.start_point = shape_point(&other, kind->start);
        assert_int_equal(drape_try(&wanted, &other, &there), STATUS_OK);
        cut_faces(&base, wanted.arena, parts);
        assert_int_equal(shell_make(parts, PIECES, 0, wanted.arena, &shell, &fault), STATUS_OK);
        assert_int_equal(
            shell_offset(shell, parts, outward(kind) * h, wanted.arena, &shell, &fault), STATUS_OK);
        assert_int_equal(drape_solve(&(struct drape_part){.shell = shell}, &settings, NULL,
                                     wanted.arena, &result),
                         STATUS_OK);
        struct grid grid;
        double gap = 0;
        int missing = 0; /* on the rim, to rounding */
        grid_make(&grid, &result.nodes);
        /* The side of a shell's start may turn the weft round. */
        double turned = vec3_dot(result.start_weft, wanted.result.start_weft) < 0 ? -1 : 1;
        for (size_t k = 0; k < wanted.result.nodes.count; k++) {
            int i = wanted.result.nodes.i[k], j = (int)turned * wanted.result.nodes.j[k];
            int at = grid_find(&grid, i, j);
            missing += at < 0;
            if (at < 0 || result.nodes.grown[at] || wanted.result.nodes.grown[k])
                continue;
            gap = fmax(gap, vec3_distance(node_point(&result.nodes, at),
                                          node_point(&wanted.result.nodes, (int)k)));
        }
        printf("shell moved by %+.1f: %zu nodes within %.2g\n", h, result.nodes.count, gap);
        check_below(gap, 1e-8);
        check_at_most(missing, 2);
        check_at_most(fabs((double)result.nodes.count - (double)wanted.result.nodes.count), 2);
        grid_free(&grid);
        drape_end(&wanted);
    }
}

/* Two planes that meet at 10 degrees; and the tube of a torus from its inside. */
static void test_offset_names_what_a_shell_cannot_do(void **state) {
    struct arena *arena = arena_new((size_t)1 << 26);
    struct shell_patch parts[PIECES] = {{0}};
    struct shell_fault fault = {0};
    struct shell *shell, *moved;
    struct shape shape;
    (void)state;
    shape_crease(&shape, 1, M_PI / 18);
    const double v[2] = {0, 1}, u[2][2] = {{0, 0.5}, {0.5, 1}};
    for (int k = 0; k < 2; k++) {
        struct shape half = shape;
        struct surface *surface;
        shape_cut(&half, u[k], v);
        struct nurbs nurbs = shape_nurbs(&half);
        assert_int_equal(surface_make(&nurbs, arena, &surface), STATUS_OK);
        parts[k].surface = surface;
    }
    assert_int_equal(shell_make(parts, 2, 0, arena, &shell, &fault), STATUS_OK);
    assert_int_equal(shell_offset(shell, parts, 0.01, arena, &moved, &fault), STATUS_INVALID);
    assert_int_equal(fault.kind, SHELL_FOLDS);
    assert_int_equal(fault.face_count, 2);
    check_below(fabs(fault.fold_deg - 10), 1e-9);
    kinds[KINDS - 2].make(&shape, 0);
    cut_faces(&shape, arena, parts);
    assert_int_equal(shell_make(parts, PIECES, 0, arena, &shell, &fault), STATUS_OK);
    double inward = -outward(&kinds[KINDS - 2]);
    assert_int_equal(shell_offset(shell, parts, 0.71 * inward, arena, &moved, &fault),
                     STATUS_INVALID);
    assert_int_equal(fault.kind, SHELL_TOO_CURVED);
    check_below(fabs(fault.radius - 0.7), 1e-9);
    arena_free(arena);
}

/* ---- other surfaces ---- */

/* r + h n by the tests' own evaluator. */
static struct vec3 lifted(const struct shape *shape, double u, double v, double h) {
    struct surface_jet jet;
    shape_evaluate(shape, u, v, &jet);
    return vec3_axpy(h, jet_normal(&jet), jet.r);
}

/* Sixth-order central differences. */
static struct vec3 difference(const struct vec3 p[7], double step, bool second) {
    static const double first[7] = {-1.0 / 60, 9.0 / 60,  -45.0 / 60, 0,
                                    45.0 / 60, -9.0 / 60, 1.0 / 60};
    static const double twice[7] = {2.0 / 180,   -27.0 / 180, 270.0 / 180, -490.0 / 180,
                                    270.0 / 180, -27.0 / 180, 2.0 / 180};
    struct vec3 sum = {0, 0, 0};
    for (int k = 0; k < 7; k++)
        sum = vec3_axpy(second ? twice[k] : first[k], p[k], sum);
    return vec3_scale(1 / (second ? step * step : step), sum);
}

static void test_offset_derivatives_are_those_of_its_points(void **state) {
    uint64_t seed = 20261122;
    (void)state;
    for (int round = 0; round < check_sized(60, 10); round++) {
        struct arena *arena = arena_new((size_t)1 << 26);
        struct shape shape;
        struct surface *base, *own;
        struct surface_cursor cursor = {0};
        double h = random_between(&seed, -0.2, 0.2), lower[2], upper[2];
        if (round == 0)
            shape_freeform(&shape);
        else
            shape_random(&shape, &seed);
        struct nurbs nurbs = shape_nurbs(&shape);
        assert_int_equal(surface_make(&nurbs, arena, &base), STATUS_OK);
        assert_int_equal(surface_offset(base, h, arena, &own), STATUS_OK);
        surface_domain(own, lower, upper);
        for (int n = 0; n < 20; n++) {
            double at[2], step = 1e-3;
            struct surface_jet jet;
            for (int k = 0; k < 2; k++) {
                at[k] = random_between(&seed, lower[k] + 0.01, upper[k] - 0.01);
                int span = shape_span(&shape, k, at[k]);
                double low = shape.knots[k][span], high = shape.knots[k][span + 1];
                at[k] = low + (high - low) * random_between(&seed, 0.3, 0.7);
                step = fmin(step, (high - low) / 20);
            }
            struct vec3 along[2][7];
            for (int k = -3; k <= 3; k++) {
                along[0][k + 3] = lifted(&shape, at[0] + k * step, at[1], h);
                along[1][k + 3] = lifted(&shape, at[0], at[1] + k * step, h);
            }
            surface_evaluate(own, &cursor, at[0], at[1], &jet);
            double scale = fmax(1, fmax(vec3_norm(jet.uu), vec3_norm(jet.vv)));
            check_below(vec3_distance(jet.r, along[0][3]), 1e-12);
            check_below(vec3_distance(jet.u, difference(along[0], step, false)), 1e-7 * scale);
            check_below(vec3_distance(jet.v, difference(along[1], step, false)), 1e-7 * scale);
            check_below(vec3_distance(jet.uu, difference(along[0], step, true)), 1e-5 * scale);
            check_below(vec3_distance(jet.vv, difference(along[1], step, true)), 1e-5 * scale);
            struct vec3 across[7];
            for (int k = -3; k <= 3; k++) {
                struct surface_jet there;
                surface_evaluate(own, &cursor, at[0], at[1] + k * step, &there);
                across[k + 3] = there.u;
            }
            check_below(vec3_distance(jet.uv, difference(across, step, false)), 1e-6 * scale);
        }
        arena_free(arena);
    }
}

/* ---- how far ---- */

static bool holds(struct shape *shape, double h, struct surface_offset_fault *fault) {
    struct arena *arena = arena_new((size_t)1 << 26);
    struct surface *base, *own;
    struct nurbs nurbs = shape_nurbs(shape);
    assert_int_equal(surface_make(&nurbs, arena, &base), STATUS_OK);
    assert_int_equal(surface_offset(base, h, arena, &own), STATUS_OK);
    bool good = surface_offset_holds(own, NULL, 1e-6, fault);
    arena_free(arena);
    return good;
}

static void test_offset_holds_up_to_the_radius_of_curvature(void **state) {
    struct surface_offset_fault fault;
    struct shape shape;
    (void)state;
    /* z = (4 x^2 - 2 y^2) / 2: radii of curvature 1/4 up and 1/2 down, both at its middle. */
    shape_quadric(&shape, 4, -2, (double[2]){-0.93, 1}, (double[2]){-1, 0.87});
    assert_true(holds(&shape, 0.249, &fault));
    assert_false(holds(&shape, 0.251, &fault));
    check_below(fabs(fault.radius - 0.25), 1e-9);
    check_below(vec3_norm(fault.at), 1e-4);
    assert_true(holds(&shape, -0.499, &fault));
    assert_false(holds(&shape, -0.501, &fault));
    check_below(fabs(fault.radius - 0.5), 1e-9);
    /* A torus from its inside: the tube's own radius. */
    shape_torus(&shape, 2, 0.7, WHOLE, WHOLE, M_PI / 2);
    double inward = -outward(&kinds[KINDS - 1]);
    assert_true(holds(&shape, 0.699 * inward, &fault));
    assert_false(holds(&shape, 0.701 * inward, &fault));
    check_below(fabs(fault.radius - 0.7), 1e-9);
    assert_true(holds(&shape, -1.29 * inward, &fault));
    /* A sphere with its poles, where the parameters' forms mean nothing. */
    shape_sphere(&shape, 1, WHOLE, (double[2]){-M_PI / 2, M_PI / 2}, M_PI / 2);
    inward = -outward(&kinds[3]);
    assert_true(holds(&shape, 0.999 * inward, &fault));
    assert_true(holds(&shape, -2 * inward, &fault));
    assert_false(holds(&shape, 1.001 * inward, &fault));
    check_below(fabs(fault.radius - 1), 1e-6); /* the root of a difference of rounding */
}

static void test_offset_finds_creases(void **state) {
    struct surface_offset_fault fault;
    struct shape shape;
    (void)state;
    shape_crease(&shape, 1, M_PI / 6);
    assert_false(holds(&shape, 0.01, &fault));
    check_below(fabs(fault.fold_deg - 30), 1e-9);
    check_below(fabs(fault.at.x), 1e-12);
    shape_crease(&shape, 1, 1e-5);
    assert_true(holds(&shape, 0.01, &fault));
}

/* A cone's apex opens into a circle. */
static void test_offset_opens_an_apex(void **state) {
    struct arena *arena = arena_new((size_t)1 << 26);
    struct surface *base, *own;
    struct surface_cursor cursor = {0};
    struct surface_jet a, b;
    struct shape shape;
    (void)state;
    shape_frustum(&shape, WHOLE, (double[2]){1, 0}, (double[2]){0, 1}, M_PI / 2);
    struct nurbs nurbs = shape_nurbs(&shape);
    assert_int_equal(surface_make(&nurbs, arena, &base), STATUS_OK);
    assert_int_equal(surface_offset(base, 0.1, arena, &own), STATUS_OK);
    surface_evaluate(own, &cursor, 0, 1, &a);
    surface_evaluate(own, &cursor, 0.5, 1, &b);
    check_below(fabs(vec3_distance(a.r, b.r) - 0.2 / sqrt(2)), 1e-12);
    check_above(vec3_norm(a.u), 0.1);
    arena_free(arena);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_offset_has_the_jets_of_its_kind),
        cmocka_unit_test(test_offset_nets_are_those_of_the_moved_surface),
        cmocka_unit_test(test_offset_has_the_same_bits_with_any_lanes),
        cmocka_unit_test(test_offset_moves_shells_to_one_side),
        cmocka_unit_test(test_offset_names_what_a_shell_cannot_do),
        cmocka_unit_test(test_offset_derivatives_are_those_of_its_points),
        cmocka_unit_test(test_offset_holds_up_to_the_radius_of_curvature),
        cmocka_unit_test(test_offset_finds_creases),
        cmocka_unit_test(test_offset_opens_an_apex),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
