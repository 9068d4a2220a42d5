/* SPDX-License-Identifier: MIT */
#include "solver/surface/spans.h"

#include "patch.h"
#include "support.h"
#include "tests/check.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* A random surface of one kind, made. */
struct subject {
    struct patch patch;
    struct arena *arena;
    struct surface *surface;
    struct surface_cursor cursor;
};

static void subject_make(struct subject *s, const struct patch_kind *kind, struct random *random) {
    struct nurbs_fault fault;
    patch_make(&s->patch, kind, random);
    if (nurbs_validate(&s->patch.nurbs, &fault) != STATUS_OK)
        fail_msg("degrees %d %d: %s", kind->p, kind->q, fault.reason);
    s->arena = arena_new((size_t)1 << 26);
    s->cursor = (struct surface_cursor){0};
    assert_int_equal(surface_make(&s->patch.nurbs, s->arena, &s->surface), STATUS_OK);
}

static void for_every_kind(void (*check)(struct subject *s, struct random *random),
                           const char *name) {
    struct random random = random_begin(name);
    for (int k = 0; k < 4 * NURBS_DEGREE_MAX * NURBS_DEGREE_MAX; k++) {
        struct patch_kind kind = {1 + k / 4 % NURBS_DEGREE_MAX, 1 + k / 4 / NURBS_DEGREE_MAX,
                                  k % 2 == 0, k % 4 < 2};
        struct subject subject;
        subject_make(&subject, &kind, &random);
        check(&subject, &random);
        arena_free(subject.arena);
    }
}

static struct vec3 rounded(struct patch_point p) {
    return vec3_make((double)p.x, (double)p.y, (double)p.z);
}

/* ---- values ---- */

static void check_values(struct subject *s, struct random *random) {
    const struct nurbs *nurbs = &s->patch.nurbs;
    for (int k = 0; k < 40; k++) {
        int lu, lv;
        struct surface_jet jet;
        double u = patch_parameter(&nurbs->u, random, &lu);
        double v = patch_parameter(&nurbs->v, random, &lv);
        surface_evaluate(s->surface, &s->cursor, u, v, &jet);
        double error = vec3_distance(jet.r, rounded(patch_evaluate(nurbs, lu, lv, u, v)));
        if (!(error < 2e-13 * PATCH_SIZE_MAX))
            fail_msg("degrees %d %d: off by %g", nurbs->u.degree, nurbs->v.degree, error);
    }
}

static void test_surface_values_are_those_of_de_boor(void **state) {
    (void)state;
    for_every_kind(check_values, __func__);
}

/* ---- derivatives ---- */

enum { R_U, R_V, R_UU, R_UV, R_VV, DERIVATIVES };

struct place {
    const struct nurbs *nurbs;
    int lu, lv;
    long double u, v, hu, hv; /* h: the steps in u and v */
};

static struct patch_point at(const struct place *p, int i, int j, long double share) {
    return patch_evaluate(p->nurbs, p->lu, p->lv, p->u + i * share * p->hu,
                          p->v + j * share * p->hv);
}

/* sum of c[k] r(u + i[k] h, v + j[k] h), divided by `scale`. */
static struct vec3 combine(const struct place *p, long double share, const int terms[][3],
                           size_t count, long double scale) {
    long double x = 0, y = 0, z = 0;
    for (size_t k = 0; k < count; k++) {
        struct patch_point r = at(p, terms[k][0], terms[k][1], share);
        x += terms[k][2] * r.x;
        y += terms[k][2] * r.y;
        z += terms[k][2] * r.z;
    }
    return vec3_make((double)(x / scale), (double)(y / scale), (double)(z / scale));
}

/* Centred differences of second order in the step. */
static struct vec3 difference(const struct place *p, int derivative, long double share) {
    static const int u1[][3] = {{1, 0, 1}, {-1, 0, -1}}, v1[][3] = {{0, 1, 1}, {0, -1, -1}};
    static const int u2[][3] = {{1, 0, 1}, {0, 0, -2}, {-1, 0, 1}};
    static const int v2[][3] = {{0, 1, 1}, {0, 0, -2}, {0, -1, 1}};
    static const int uv[][3] = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
    long double hu = share * p->hu, hv = share * p->hv;
    switch (derivative) {
    case R_U:
        return combine(p, share, u1, 2, 2 * hu);
    case R_V:
        return combine(p, share, v1, 2, 2 * hv);
    case R_UU:
        return combine(p, share, u2, 3, hu * hu);
    case R_VV:
        return combine(p, share, v2, 3, hv * hv);
    default:
        return combine(p, share, uv, 4, 4 * hu * hv);
    }
}

/* The differences' errors for a step and for its half, summed over places: they must go down with
 * the square of the step, and Richardson's extrapolation of the two must be closer still. */
struct errors {
    double whole, half, extrapolated, size;
};

static void add_errors(struct errors *errors, const struct place *place, int derivative,
                       struct vec3 value) {
    struct vec3 whole = difference(place, derivative, 1), half = difference(place, derivative, 0.5);
    struct vec3 better = vec3_scale(1.0 / 3, vec3_sub(vec3_scale(4, half), whole));
    errors->whole += vec3_distance(whole, value);
    errors->half += vec3_distance(half, value);
    errors->extrapolated += vec3_distance(better, value);
    errors->size += vec3_norm(value);
}

static void assert_second_order(const struct errors *e, const struct nurbs *nurbs, int derivative) {
    bool exact = e->whole <= 1e-9 * e->size + 1e-9;
    double order = log2(e->whole / e->half);
    bool ok = exact || (fabs(order - 2) < 0.1 && e->extrapolated < 0.02 * e->whole);
    if (!ok)
        fail_msg("degrees %d %d, derivative %d: errors %g, %g, %g of %g, order %g", nurbs->u.degree,
                 nurbs->v.degree, derivative, e->whole, e->half, e->extrapolated, e->size, order);
}

static void check_derivatives(struct subject *s, struct random *random) {
    const struct nurbs *nurbs = &s->patch.nurbs;
    struct errors errors[DERIVATIVES] = {{0}};
    for (int k = 0; k < 20; k++) {
        struct place p = {.nurbs = nurbs};
        struct surface_jet jet;
        double u = patch_parameter(&nurbs->u, random, &p.lu);
        double v = patch_parameter(&nurbs->v, random, &p.lv);
        p.u = u;
        p.v = v;
        p.hu = 0.01L * (nurbs->u.knots[p.lu + 1] - nurbs->u.knots[p.lu]);
        p.hv = 0.01L * (nurbs->v.knots[p.lv + 1] - nurbs->v.knots[p.lv]);
        surface_evaluate(s->surface, &s->cursor, u, v, &jet);
        const struct vec3 values[DERIVATIVES] = {jet.u, jet.v, jet.uu, jet.uv, jet.vv};
        for (int d = 0; d < DERIVATIVES; d++)
            add_errors(&errors[d], &p, d, values[d]);
    }
    for (int d = 0; d < DERIVATIVES; d++)
        assert_second_order(&errors[d], nurbs, d);
}

static void test_surface_derivatives_are_the_limits_of_differences(void **state) {
    (void)state;
    for_every_kind(check_derivatives, __func__);
}

/* ---- the rest ---- */

/* Whatever span was visited before. */
static void check_cursor(struct subject *s, struct random *random) {
    const struct nurbs *nurbs = &s->patch.nurbs;
    for (int k = 0; k < 20; k++) {
        int lu, lv;
        struct surface_jet one, other;
        struct surface_cursor fresh = {0};
        double u = patch_parameter(&nurbs->u, random, &lu);
        double v = patch_parameter(&nurbs->v, random, &lv);
        surface_evaluate(s->surface, &s->cursor, u, v, &one);
        surface_evaluate(s->surface, &fresh, u, v, &other);
        assert_memory_equal(&one, &other, sizeof one);
    }
}

static void test_surface_evaluation_does_not_depend_on_the_cursor(void **state) {
    (void)state;
    for_every_kind(check_cursor, __func__);
}

static void check_continuation(struct subject *s, struct random *random) {
    const struct nurbs *nurbs = &s->patch.nurbs;
    int lu = nurbs->u.size - 1, lv = nurbs->v.degree;
    struct surface_jet jet;
    double lower[2], upper[2];
    surface_domain(s->surface, lower, upper);
    assert_true(lower[0] == nurbs->u.knots[nurbs->u.degree]);
    assert_true(upper[1] == nurbs->v.knots[nurbs->v.size]);
    if (nurbs->u.knots[lu + 1] == nurbs->u.knots[lu] || surface_closed(s->surface, 0) ||
        surface_closed(s->surface, 1))
        return;
    double u = upper[0] + random_between(random, 0, 0.1), v = lower[1];
    surface_evaluate(s->surface, &s->cursor, u, v, &jet);
    struct vec3 expected = rounded(patch_evaluate(nurbs, lu, lv, u, v));
    check_below(vec3_distance(jet.r, expected), 1e-11 * (PATCH_SIZE_MAX + vec3_norm(expected)));
}

static void test_surface_goes_on_beyond_its_edge_by_its_own_polynomials(void **state) {
    (void)state;
    for_every_kind(check_continuation, __func__);
}

static void check_bounds(struct subject *s, struct random *random) {
    const struct nurbs *nurbs = &s->patch.nurbs;
    struct vec3 low, high;
    surface_bounds(s->surface, &low, &high);
    for (int k = 0; k < 20; k++) {
        int span;
        struct surface_jet jet;
        double u = patch_parameter(&nurbs->u, random, &span);
        double v = patch_parameter(&nurbs->v, random, &span);
        surface_evaluate(s->surface, &s->cursor, u, v, &jet);
        check_above(jet.r.x, low.x - 1e-12);
        check_above(jet.r.y, low.y - 1e-12);
        check_above(jet.r.z, low.z - 1e-12);
        check_below(jet.r.x, high.x + 1e-12);
        check_below(jet.r.y, high.y + 1e-12);
        check_below(jet.r.z, high.z + 1e-12);
    }
}

static void test_surface_lies_in_its_bounds(void **state) {
    (void)state;
    for_every_kind(check_bounds, __func__);
}

/* A grid of places of a span is evaluated line by line, to the same bits. */
static void check_grid(struct subject *s, struct random *random) {
    enum { COUNT = 5, LINES = 2 };
    const struct surface_axis *axis = s->surface->axis;
    struct surface_element elements[COUNT * LINES];
    double at[2][COUNT];
    struct surface_grid grid = {.count = {COUNT, LINES}, .at = {at[0], at[1]}};
    int *span = grid.span;
    for (int n = 0; n < 2; n++) {
        span[n] = (int)random_between(random, 0, axis[n].span_count - 1e-9);
        for (int k = 0; k < COUNT; k++)
            at[n][k] = random_between(random, axis[n].breaks[span[n]], axis[n].breaks[span[n] + 1]);
    }
    surface_evaluate_grid(s->surface, &grid, elements);
    for (int k = 0; k < COUNT * LINES; k++) {
        struct surface_jet jet;
        surface_evaluate_span(s->surface, span[0], span[1], at[0][k / LINES], at[1][k % LINES],
                              &jet);
        assert_memory_equal(&elements[k].r, &jet.r, sizeof jet.r);
        assert_memory_equal(&elements[k].u, &jet.u, sizeof jet.u);
        assert_memory_equal(&elements[k].v, &jet.v, sizeof jet.v);
    }
}

static void test_surface_grid_has_the_bits_of_places(void **state) {
    (void)state;
    for_every_kind(check_grid, __func__);
}

/* A bilinear patch that is a parallelogram: everything is known. */
static void test_surface_area_and_centroid_of_a_parallelogram(void **state) {
    (void)state;
    static const double knots[] = {0, 0, 3, 3};
    static const struct vec3 points[] = {{0, 0, 0}, {1, 2, 0}, {4, 0, 1}, {5, 2, 1}};
    const struct nurbs_axis axis = {1, 2, knots, 4};
    const struct nurbs nurbs = {.u = axis, .v = axis, .points = points, .point_count = 4};
    struct arena *arena = arena_new(1 << 20);
    struct surface *surface;
    struct vec3 centroid;
    assert_int_equal(surface_make(&nurbs, arena, &surface), STATUS_OK);
    double area = vec3_norm(vec3_cross(points[1], points[2]));
    check_below(fabs(surface_area(surface, &centroid) - area), 1e-14 * area);
    check_below(vec3_distance(centroid, vec3_scale(0.5, points[3])), 1e-14);
    check_above(surface_area(surface, NULL), 0);
    assert_false(surface_closed(surface, 0) || surface_closed(surface, 1));
    arena_free(arena);
}

/* The parabola z = x^2 along y, whose vertex no sample meets, and the half of it beside that. */
static void test_surface_bends_by_the_least_radius_that_it_has(void **state) {
    (void)state;
    static const double knots[] = {0, 0, 0, 1, 1, 1}, knots_v[] = {0, 0, 1, 1};
    static const double ends[][2] = {{-0.3, 0.7}, {0.25, 0.5}};
    for (int k = 0; k < 2; k++) {
        double a = ends[k][0], b = ends[k][1], x[] = {a, (a + b) / 2, b},
               z[] = {a * a, a * b, b * b};
        struct vec3 points[6];
        for (int n = 0; n < 6; n++)
            points[n] = vec3_make(x[n / 2], n % 2, z[n / 2]);
        const struct nurbs nurbs = {
            .u = {2, 3, knots, 6}, .v = {1, 2, knots_v, 4}, .points = points, .point_count = 6};
        struct arena *arena = arena_new(1 << 20);
        struct surface *surface;
        struct surface_bends bends;
        assert_int_equal(surface_make(&nurbs, arena, &surface), STATUS_OK);
        surface_bends_find(surface, NULL, &bends);
        double least = k == 0 ? 0.5 : pow(1 + 4 * a * a, 1.5) / 2;
        check_below(fabs(bends.least_radius - least), 1e-9);
        assert_false(bends.turns_back);
        arena_free(arena);
    }
}

/* The unit square with weights a_i b_j, so that x is a function of u alone and y of v: most of it
 * lies within 1e-5 of a corner of the parameters. */
static void test_surface_area_under_uneven_weights(void **state) {
    (void)state;
    static const double knots[] = {0, 0, 0, 1, 1, 1}, a[] = {1, 1e5, 3}, b[] = {1e5, 1, 1e-5};
    struct vec3 points[9], centroid;
    double weights[9];
    for (int k = 0; k < 9; k++) {
        points[k] = vec3_make(k / 3 / 2.0, k % 3 / 2.0, 0);
        weights[k] = a[k / 3] * b[k % 3];
    }
    const struct nurbs_axis axis = {2, 3, knots, 6};
    const struct nurbs nurbs = {axis, axis, points, 9, weights, 9};
    struct arena *arena = arena_new(1 << 20);
    struct surface *surface;
    assert_int_equal(surface_make(&nurbs, arena, &surface), STATUS_OK);
    check_below(fabs(surface_area(surface, &centroid) - 1), 1e-5);
    check_below(vec3_distance(centroid, vec3_make(0.5, 0.5, 0)), 1e-5);
    arena_free(arena);
}

/* The unit square with weights r^i along u, which a projective change of parameter takes away: in
 * inner parameters a place moves evenly, of whatever degree, and however far the weights spread. */
static void test_surface_inner_parameters_are_even_under_projective_weights(void **state) {
    (void)state;
    enum { ENDS = 2 * (NURBS_DEGREE_MAX + 1) };
    static const double ratio[] = {1e-7, 1.4e-4, 0.3, 7, 1e4, 1e7}, knots_v[] = {0, 0, 1, 1};
    for (int p = 1; p <= NURBS_DEGREE_MAX; p++)
        for (size_t k = 0; k < sizeof ratio / sizeof *ratio; k++) {
            double knots[ENDS] = {0}, weights[ENDS], low[2] = {0, 0.5}, high[2];
            struct vec3 points[ENDS];
            for (int i = 0; i <= p; i++)
                for (int j = 0; j < 2; j++) {
                    knots[p + 1 + i] = 1;
                    points[2 * i + j] = vec3_make((double)i / p, j, 0);
                    weights[2 * i + j] = pow(ratio[k], i);
                }
            size_t count = 2 * (size_t)(p + 1);
            const struct nurbs nurbs = {
                {p, p + 1, knots, count}, {1, 2, knots_v, 4}, points, count, weights, count};
            struct arena *arena = arena_new(1 << 20);
            struct surface *surface;
            struct surface_cursor cursor = {0};
            struct surface_jet first, last;
            assert_int_equal(surface_make(&nurbs, arena, &surface), STATUS_OK);
            high[0] = surface_axis_upper(&surface->axis[0]);
            high[1] = 0.5;
            surface_jet_at(surface, &cursor, low[0], low[1], &first);
            surface_jet_at(surface, &cursor, high[0], high[1], &last);
            check_below(vec3_distance(first.u, last.u), 1e-8 * vec3_norm(first.u));
            arena_free(arena);
        }
}

static void test_surface_without_area_is_degenerate(void **state) {
    (void)state;
    static const double knots[] = {0, 0, 1, 1};
    static const struct vec3 shapes[][4] = {{{1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}},
                                            {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {3, 3, 3}},
                                            {{0, 0, 0}, {0, 0, 0}, {1, 0, 0}, {1, 0, 0}}};
    const struct nurbs_axis axis = {1, 2, knots, 4};
    for (size_t k = 0; k < 3; k++) {
        const struct nurbs nurbs = {.u = axis, .v = axis, .points = shapes[k], .point_count = 4};
        struct arena *arena = arena_new(1 << 20);
        struct surface *surface;
        assert_int_equal(surface_make(&nurbs, arena, &surface), STATUS_DEGENERATE_SURFACE);
        arena_free(arena);
    }
}

/* A quarter-circle cylinder in four spans: the whole turn, closed in u. */
static void test_surface_closed_direction_wraps(void **state) {
    (void)state;
    static const double knots_u[] = {0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4}, knots_v[] = {0, 0, 1, 1};
    static const double corner[9][2] = {{1, 0},   {1, 1},  {0, 1},  {-1, 1}, {-1, 0},
                                        {-1, -1}, {0, -1}, {1, -1}, {1, 0}};
    struct vec3 points[18];
    double weights[18];
    for (int i = 0; i < 18; i++) {
        points[i] = vec3_make(corner[i / 2][0], corner[i / 2][1], i % 2);
        weights[i] = i / 2 % 2 ? sqrt(0.5) : 1;
    }
    const struct nurbs nurbs = {{2, 9, knots_u, 12}, {1, 2, knots_v, 4}, points, 18, weights, 18};
    struct arena *arena = arena_new(1 << 20);
    struct surface *surface;
    struct surface_cursor cursor = {0};
    assert_int_equal(nurbs_validate(&nurbs, NULL), STATUS_OK);
    assert_int_equal(surface_make(&nurbs, arena, &surface), STATUS_OK);
    assert_true(surface_closed(surface, 0));
    assert_false(surface_closed(surface, 1));
    check_below(fabs(surface_area(surface, NULL) - 2 * acos(-1)), 1e-12);
    for (int turns = -3; turns <= 3; turns++) {
        struct surface_jet jet;
        surface_evaluate(surface, &cursor, 0.5 + 4 * turns, 0.25, &jet);
        check_below(vec3_distance(jet.r, vec3_make(sqrt(0.5), sqrt(0.5), 0.25)), 1e-14);
    }
    arena_free(arena);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_surface_values_are_those_of_de_boor),
        cmocka_unit_test(test_surface_derivatives_are_the_limits_of_differences),
        cmocka_unit_test(test_surface_evaluation_does_not_depend_on_the_cursor),
        cmocka_unit_test(test_surface_goes_on_beyond_its_edge_by_its_own_polynomials),
        cmocka_unit_test(test_surface_lies_in_its_bounds),
        cmocka_unit_test(test_surface_grid_has_the_bits_of_places),
        cmocka_unit_test(test_surface_area_and_centroid_of_a_parallelogram),
        cmocka_unit_test(test_surface_bends_by_the_least_radius_that_it_has),
        cmocka_unit_test(test_surface_area_under_uneven_weights),
        cmocka_unit_test(test_surface_inner_parameters_are_even_under_projective_weights),
        cmocka_unit_test(test_surface_without_area_is_degenerate),
        cmocka_unit_test(test_surface_closed_direction_wraps),
    };
    return cmocka_run_group_tests_name("surface", tests, NULL, NULL);
}
