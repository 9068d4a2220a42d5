/* SPDX-License-Identifier: MIT */
/* Paths past the corners of spans: on a sphere, split as one likes, geodesics are great circles.
 * And geodesics that are measured instead: on a sphere and, as helices, on a cylinder; and those
 * that are found by collocation, beside the integrated ones; and Jacobi fields. DRAPED_SEED sets
 * the seed. */
#include "pieces.h"
#include "shapes.h"
#include "solver/fishnet/logarithm.h"
#include "solver/path/collocation.h"
#include "solver/path/dormand.h"
#include "solver/path/path.h"
#include "tests/check.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { DIRECTIONS = 24 };
static const double split[2] = {0.1, -0.13}; /* the knots inserted in u and v */
static const double half = 0.4;              /* length before and after the corner, radius 1 */

static void chart(struct vec3 r, double uv[2]) {
    uv[0] = r.x / (1 + r.z);
    uv[1] = r.y / (1 + r.z);
}

/* The great circle from the unit vector r along the unit tangent t. */
static struct vec3 circle(struct vec3 r, struct vec3 t, double length) {
    return vec3_axpy(sin(length), t, vec3_scale(cos(length), r));
}

static struct surface *split_sphere(struct shape *shape, struct arena *arena) {
    const double range[2] = {-0.5, 0.5};
    struct surface *surface;
    shape_stereographic(shape, 1, range, range);
    for (int k = 0; k < 2; k++)
        shape_insert_knot(shape, k, split[k]);
    struct nurbs nurbs = shape_nurbs(shape);
    assert_int_equal(surface_make(&nurbs, arena, &surface), STATUS_OK);
    return surface;
}

/* How far a geodesic ends from the great circle that passes the corner by about `miss`, under the
 * given angle. */
static double error_past_corner(const struct surface *surface, struct vec3 corner, double angle,
                                double miss) {
    struct vec3 east = vec3_unit(vec3_cross((struct vec3){0, 1, 0}, corner));
    struct vec3 t = vec3_axpy(sin(angle), vec3_cross(corner, east), vec3_scale(cos(angle), east));
    struct vec3 r = circle(corner, t, -half), end;
    struct vec3 ahead = vec3_axpy(sin(half), corner, vec3_scale(cos(half), t));
    struct vec3 turned = circle(ahead, vec3_cross(r, ahead), miss / sin(half));
    struct surface_cursor cursor = {0, 0};
    struct surface_point from, to;
    struct path path;
    double uv[2];
    chart(r, uv);
    assert_true(surface_point_at(surface, &cursor, uv, &from));
    assert_true(path_geodesic(&path, surface, &from, turned));
    assert_true(path_advance(&path, 2 * half));
    assert_true(path_surface_point(&path, &cursor, &to, NULL));
    end = circle(r, turned, 2 * half);
    return vec3_distance(end, to.jet.r);
}

/* A path that meets one edge within a hair's breadth of another must not take them in the wrong
 * order: it would go on from beyond the edge it missed, and never meet it. */
static void test_exact_path_passes_corners_of_spans(void **state) {
    static const double misses[] = {0, 1e-3, 1e-5, 1e-7, 1e-8, 1e-9, 1e-11, 1e-13};
    static struct shape shape;
    struct arena *arena = arena_new((size_t)1 << 24);
    struct surface *surface = split_sphere(&shape, arena);
    struct vec3 corner = shape_point(&shape, split);
    double worst = 0;
    (void)state;
    for (int k = 0; k < DIRECTIONS; k++)
        for (size_t m = 0; m < sizeof misses / sizeof *misses; m++)
            for (int side = -1; side <= 1; side += 2)
                worst =
                    fmax(worst, error_past_corner(surface, corner, 0.1 + 2 * M_PI * k / DIRECTIONS,
                                                  side * misses[m]));
    printf("  largest error %.1e\n", worst);
    check_below(worst, 1e-12);
    arena_free(arena);
}

enum { PAIRS = 2000, ACCURACIES = 3 };
static const double accuracies[ACCURACIES] = {1e-4, 1e-6, 1e-8};

/* The exact logarithm of q at p: its length and unit tangent. */
typedef void exact_logarithm(struct vec3 p, struct vec3 q, double *length, struct vec3 *leave);

static void on_sphere(struct vec3 p, struct vec3 q, double *length, struct vec3 *leave) {
    *length = vec3_angle(p, q);
    *leave = vec3_unit(vec3_axpy(-vec3_dot(p, q), p, q));
}

static void on_cylinder(struct vec3 p, struct vec3 q, double *length, struct vec3 *leave) {
    double turn = atan2(p.x * q.y - p.y * q.x, p.x * q.x + p.y * q.y), rise = q.z - p.z;
    *length = sqrt(turn * turn + rise * rise);
    *leave = vec3_scale(1 / *length, (struct vec3){-p.y * turn, p.x * turn, rise});
}

/* The logarithm of q as it follows from the chain to a place beside, known roughly. */
static bool go_on_to(struct surface_cursor *cursor, const struct surface_point *p,
                     const struct surface_point *q, double accuracy, struct logarithm *logarithm) {
    struct logarithm_chain chain;
    struct surface_point beside;
    struct vec3 way = vec3_sub(p->jet.r, q->jet.r);
    struct vec3 step = vec3_scale(0.02, vec3_add(way, vec3_cross(q->normal, way)));
    chain.way.pieces = 0;
    return surface_point_move(cursor, q, step, &beside) && beside.surface == q->surface &&
           logarithm_go_on(cursor, &chain, p, &beside, accuracies[0], logarithm) &&
           logarithm_go_on(cursor, &chain, p, q, accuracy, logarithm) && way_holds(&chain.way);
}

/* The largest errors of lengths, by themselves, and of directions, over pairs of places less than a
 * radius apart; from the second on how many of them were found. */
static size_t largest_errors(const struct surface *surface, exact_logarithm *exact, double accuracy,
                             double errors[2]) {
    struct surface_cursor cursor = {0, 0};
    size_t found = 0;
    double lower[2], upper[2];
    surface_domain(surface, lower, upper);
    errors[0] = errors[1] = 0;
    for (int k = 0; k < PAIRS; k++) {
        struct surface_point from, to;
        struct logarithm l, gone_on;
        struct vec3 leave;
        double uv[2][2], length;
        for (int n = 0; n < 2; n++) {
            double x = fmod(0.05 + 0.6180339887 * (k + 1) * (n + 1), 1);
            uv[0][n] = lower[n] + x * (upper[n] - lower[n]);
            x += 0.3 * fmod(0.7548776662 * (k + 1) * (2 * n + 1), 1) - 0.15;
            uv[1][n] = lower[n] + fmin(fmax(x, 0), 1) * (upper[n] - lower[n]);
        }
        assert_true(surface_point_at(surface, &cursor, uv[0], &from));
        assert_true(surface_point_at(surface, &cursor, uv[1], &to));
        exact(from.jet.r, to.jet.r, &length, &leave);
        if (length > 1 || !logarithm_find(&cursor, &from, &to, accuracy, &l))
            continue;
        found++;
        assert_true(go_on_to(&cursor, &from, &to, accuracy, &gone_on));
        errors[0] = fmax(errors[0], fabs(l.length / length - 1));
        errors[0] = fmax(errors[0], fabs(gone_on.length / length - 1));
        errors[1] = fmax(errors[1], vec3_distance(l.leave, leave));
        errors[1] = fmax(errors[1], vec3_distance(gone_on.leave, leave));
    }
    return found;
}

static void check_logarithms(const char *name, const struct surface *surface,
                             exact_logarithm *exact) {
    for (int k = 0; k < ACCURACIES; k++) {
        double errors[2];
        size_t found = largest_errors(surface, exact, accuracies[k], errors);
        printf("  %s, to %.0e: %zu found, lengths %.1e, directions %.1e\n", name, accuracies[k],
               found, errors[0], errors[1]);
        check_at_least(found, PAIRS * 9 / 10);
        check_below(errors[0], 10 * accuracies[k]);
        check_below(errors[1], 3 * sqrt(accuracies[k]));
    }
}

/* Both as accurate as asked for, laid anew and from a place beside, and over the knot lines of a
 * cylinder of quarters. */
static void test_exact_path_logarithms(void **state) {
    static const double whole[2] = {0, 2 * M_PI}, foot[2] = {1, 0}, top[2] = {1, 2};
    static struct shape shape;
    struct arena *arena = arena_new((size_t)1 << 24);
    struct surface *surface;
    (void)state;
    check_logarithms("sphere", split_sphere(&shape, arena), on_sphere);
    shape_frustum(&shape, whole, foot, top, M_PI / 2);
    struct nurbs nurbs = shape_nurbs(&shape);
    assert_int_equal(surface_make(&nurbs, arena, &surface), STATUS_OK);
    check_logarithms("cylinder", surface, on_cylinder);
    arena_free(arena);
}

/* Over joints beside the pole in which they end, where straight lines of parameters lead round: a
 * cap of the sphere as quarters, between places on different ones. */
static void test_exact_path_logarithms_over_joints_at_a_pole(void **state) {
    static const double cap[2] = {M_PI / 2 - 1, M_PI / 2};
    static struct pieces pieces;
    struct arena *arena = arena_new((size_t)1 << 26);
    struct surface_cursor cursor = {0, 0};
    uint64_t seed = 31;
    size_t found = 0, gone_on = 0;
    double worst = 0;
    (void)state;
    pieces = (struct pieces){.count = 4};
    for (int k = 0; k < 4; k++) {
        const double quarter[2] = {k * M_PI / 2, (k + 1) * M_PI / 2};
        shape_sphere(&pieces.shape[k], 1, quarter, cap, 1.6);
    }
    const struct shell *shell = pieces_shell(&pieces, arena);
    for (int k = 0; k < PAIRS; k++) {
        struct surface_point end[2];
        struct logarithm l;
        double length;
        struct vec3 leave;
        for (int n = 0; n < 2; n++) {
            const struct surface *surface = shell_surface(shell, (k + n) % 4);
            double lower[2], upper[2], uv[2];
            surface_domain(surface, lower, upper);
            for (int x = 0; x < 2; x++)
                uv[x] = lower[x] + random_between(&seed, 0.1, 0.9) * (upper[x] - lower[x]);
            assert_true(surface_point_at(surface, &cursor, uv, &end[n]));
        }
        if (!logarithm_find(&cursor, &end[0], &end[1], accuracies[2], &l))
            continue;
        on_sphere(end[0].jet.r, end[1].jet.r, &length, &leave);
        worst = fmax(worst, fabs(l.length / length - 1));
        found++;
        if (go_on_to(&cursor, &end[0], &end[1], accuracies[2], &l)) {
            worst = fmax(worst, fabs(l.length / length - 1));
            gone_on++;
        }
    }
    printf("  %zu of %d found, %zu from beside, lengths %.1e\n", found, PAIRS, gone_on, worst);
    check_at_least(found, PAIRS * 9 / 10);
    check_at_least(gone_on, found * 9 / 10);
    check_below(worst, 10 * accuracies[2]);
    arena_free(arena);
}

/* A geodesic of a random surface, by integration. */
struct integrated {
    struct surface_point from, to;
    struct vec3 tangent[2];
    double length;
};

static bool integrate(const struct surface *surface, uint64_t *seed, struct integrated *g) {
    struct surface_cursor cursor = {0, 0};
    struct path path;
    double lower[2], upper[2], uv[2], angle = random_between(seed, -M_PI, M_PI);
    surface_domain(surface, lower, upper);
    for (int k = 0; k < 2; k++)
        uv[k] = lower[k] + random_between(seed, 0.2, 0.8) * (upper[k] - lower[k]);
    if (!surface_point_at(surface, &cursor, uv, &g->from))
        return false;
    struct vec3 u = vec3_unit(g->from.jet.u), across = vec3_cross(g->from.normal, u);
    g->tangent[0] = vec3_axpy(sin(angle), across, vec3_scale(cos(angle), u));
    g->length = random_between(seed, 0.02, 0.8);
    return path_geodesic(&path, surface, &g->from, g->tangent[0]) &&
           path_advance(&path, g->length) &&
           path_surface_point(&path, &cursor, &g->to, &g->tangent[1]);
}

/* The same by collocation, from a place beside its end; how far that is from it, as a share of the
 * length. Negative where it is not to be had. */
static double collocate(const struct integrated *g, int parts, int lanes,
                        struct collocation *path) {
    struct surface_cursor cursor = {0, 0};
    struct surface_point beside;
    const double uv[2] = {g->to.uv[0] + 0.01 * (g->to.uv[0] - g->from.uv[0]),
                          g->to.uv[1] - 0.01 * (g->to.uv[1] - g->from.uv[1])};
    double moved = g->length / 2;
    assert_true(surface_point_at(g->from.surface, &cursor, uv, &beside));
    if (!collocation_begin(path, &g->from, &beside, g->tangent, g->length, parts, lanes))
        return -1;
    for (int turn = 0; turn < 20 && moved > 1e-14 && moved < g->length; turn++) {
        if (!collocation_evaluate(path))
            return -1;
        moved = collocation_move(path, 0);
    }
    if (!(moved < 1e-12 * g->length) || !collocation_is_whole(path, &g->to))
        return -1;
    return vec3_distance(path->to, g->to.jet.r) / g->length;
}

/* To the accuracy of integration; where a piece is too long for that, quarters of it are better by
 * as much as an order of 16 makes them. With the same bits at any width. */
static void test_exact_path_collocation_follows_geodesics(void **state) {
    static struct shape shape;
    static struct collocation path, other;
    uint64_t seed = check_seed(20261122);
    int tried = 0, found = 0, coarse = 0, steep = 0;
    (void)state;
    for (int round = 0; round < 400; round++) {
        struct arena *arena = arena_new((size_t)1 << 24);
        struct surface *surface;
        struct integrated g;
        struct motion taller = motion_stretch(1, 1, random_between(&seed, 1, 5));
        shape_random(&shape, &seed);
        shape_move(&shape, &taller);
        struct nurbs nurbs = shape_nurbs(&shape);
        assert_int_equal(surface_make(&nurbs, arena, &surface), STATUS_OK);
        if (integrate(surface, &seed, &g)) {
            double error = collocate(&g, 1, 2, &path), finer = collocate(&g, 4, 2, &other);
            tried++;
            found += finer >= 0 && finer < 1e-10;
            coarse += error > 1e-10 && finer >= 0;
            steep += error > 1e-10 && finer >= 0 && finer < 1e-4 * error + 1e-11;
            assert_true(collocate(&g, 1, 8, &other) == error);
            assert_true(error < 0 || memcmp(&path.to, &other.to, sizeof path.to) == 0);
            assert_true(collocate(&g, 1, 4, &other) == error);
        }
        arena_free(arena);
    }
    printf("  %d of %d to 1e-10, %d of %d far better in quarters\n", found, tried, steep, coarse);
    check_at_least(found, tried * 9 / 10);
    check_at_least(coarse, 3);
    check_at_least(steep, coarse * 8 / 10);
}

/* Over corners of spans too, it ends where the great circle does. */
static void test_exact_path_collocation_on_sphere(void **state) {
    static struct shape shape;
    static struct collocation path;
    struct arena *arena = arena_new((size_t)1 << 24);
    struct surface *surface = split_sphere(&shape, arena);
    double worst = 0;
    uint64_t seed = 7;
    int found = 0;
    (void)state;
    for (int round = 0; round < 200; round++) {
        struct integrated g;
        assert_true(integrate(surface, &seed, &g));
        found += collocate(&g, 1, 0, &path) >= 0;
        if (path.pieces > 0)
            worst =
                fmax(worst, vec3_distance(path.to, circle(g.from.jet.r, g.tangent[0], g.length)));
    }
    printf("  %d of 200, to %.1e\n", found, worst);
    check_at_least(found, 190);
    check_below(worst, 1e-13);
    arena_free(arena);
}

/* Of a surface whose polynomials go on wildly: a geodesic that leaves it, anywhere and where the
 * continuation is trusted. */
static bool leave_wildly(uint64_t *seed, struct path *anywhere, struct path *trusted) {
    static struct shape shape;
    struct arena *arena = arena_new((size_t)1 << 24);
    struct surface *surface;
    struct surface_cursor cursor = {0, 0};
    struct surface_point from;
    shape_random(&shape, seed);
    struct nurbs nurbs = shape_nurbs(&shape);
    assert_int_equal(surface_make(&nurbs, arena, &surface), STATUS_OK);
    const double uv[2] = {surface_axis_upper(&surface->axis[0]),
                          surface_axis_lower(&surface->axis[1])};
    assert_true(surface_point_at(surface, &cursor, uv, &from));
    struct vec3 out = vec3_axpy(random_between(seed, -1, 1), from.jet.v, from.jet.u);
    assert_true(path_geodesic(anywhere, surface, &from, out));
    anywhere->accuracy = 1e-9;
    *trusted = *anywhere;
    trusted->reach = surface->size / 3;
    (void)path_advance(anywhere, surface->size / 4);
    bool gone = path_advance(trusted, surface->size / 4);
    arena_free(arena);
    return gone;
}

/* One that goes wild is given up after a few steps, others are followed as anywhere: also those of
 * a step or two where the continuation is not trusted, as over a ridge. */
static void test_exact_path_is_lost_where_nothing_is_trusted(void **state) {
    uint64_t seed = check_seed(5);
    int lost = 0, astray = 0, rounds = check_sized(1600, 400);
    double anywhere_steps = 0, steps = 0;
    (void)state;
    for (int round = 0; round < rounds; round++) {
        struct path anywhere, trusted;
        bool gone = leave_wildly(&seed, &anywhere, &trusted);
        lost += !gone;
        astray += gone && trusted.astray > 0;
        anywhere_steps += gone ? 0 : anywhere.tried;
        steps += gone ? 0 : trusted.tried;
        if (gone)
            assert_memory_equal(anywhere.uv, trusted.uv, sizeof anywhere.uv);
    }
    printf("  %d of %d lost, in %.0f%% of the steps; %d went astray and on\n", lost, rounds,
           100 * steps / anywhere_steps, astray);
    check_at_least(lost, rounds / 20);
    check_at_most(lost, rounds / 2);
    check_at_least(astray, rounds / 400);
    check_below(steps, 0.8 * anywhere_steps);
}

/* How much a Jacobi field of a geodesic is off from that between it and two turned by a hair. */
static double field_error(const struct surface *surface, const struct surface_point *from,
                          struct vec3 direction, double length) {
    static const double hair = 1e-4;
    struct surface_cursor cursor = {0, 0};
    struct surface_point end[3];
    struct path path;
    struct vec3 left = vec3_cross(from->normal, direction), tangent;
    double field = 0;
    for (int k = -1; k <= 1; k++) {
        assert_true(path_geodesic(&path, surface, from, vec3_axpy(k * hair, left, direction)));
        path.carries = true;
        path.field[1] = 1;
        path.accuracy = k ? 1e-12 : 1e-9;
        assert_true(path_advance(&path, length));
        assert_true(path_surface_point(&path, &cursor, &end[k + 1], k ? NULL : &tangent));
        field = k ? field : path.field[0];
    }
    struct vec3 moved = vec3_sub(end[2].jet.r, end[0].jet.r);
    double exact = vec3_dot(moved, vec3_cross(end[1].normal, tangent)) / (2 * atan(hair));
    return fabs(field - exact) / length;
}

/* On a sphere the sine of the length, on any other surface what its neighbours say. */
static void test_exact_path_carries_its_jacobi_field(void **state) {
    static struct shape shapes[2];
    const double range[2] = {-0.5, 0.5};
    double worst[2] = {0, 0};
    (void)state;
    shape_stereographic(&shapes[0], 1, range, range);
    shape_freeform(&shapes[1]);
    for (int n = 0; n < 2; n++) {
        struct arena *arena = arena_new((size_t)1 << 26);
        struct surface *surface;
        struct nurbs nurbs = shape_nurbs(&shapes[n]);
        assert_int_equal(surface_make(&nurbs, arena, &surface), STATUS_OK);
        for (int k = 0; k < DIRECTIONS; k++) {
            struct surface_cursor cursor = {0, 0};
            struct surface_point from;
            double uv[2], angle = 2 * M_PI * k / DIRECTIONS;
            for (int a = 0; a < 2; a++)
                uv[a] = (surface_axis_lower(&surface->axis[a]) +
                         surface_axis_upper(&surface->axis[a])) /
                        2;
            assert_true(surface_point_at(surface, &cursor, uv, &from));
            struct vec3 u = vec3_unit(from.jet.u), v = vec3_cross(from.normal, u);
            struct vec3 t = vec3_axpy(sin(angle), v, vec3_scale(cos(angle), u));
            worst[n] = fmax(worst[n], field_error(surface, &from, t, surface->size / 4));
        }
        arena_free(arena);
    }
    printf("  off by %.1e on a sphere, %.1e on a free form\n", worst[0], worst[1]);
    check_below(worst[0], 1e-7);
    check_below(worst[1], 1e-3);
}

/* y' = (cos s) y: y = exp(sin s), of which four times as much. */
static void grow_and_shrink(const void *context, double s, const vec4 *y, vec4 *slope) {
    *slope = cos(s + *(const double *)context) * *y;
}

/* What one step of h is wrong by, and what the rough one's error estimate is. */
static void step_errors(double h, double error[3]) {
    const double at = 0.3;
    const vec4 y = {1, 2, -1, -2}, from[2] = {y, cos(at) * y};
    struct dormand_error estimate;
    double exact = exp(sin(at + h) - sin(at));
    vec4 to;
    dormand_step(grow_and_shrink, &at, h, from, &to, &estimate);
    error[0] = fabs(to[0] - exact);
    dormand_rough_step(grow_and_shrink, &at, h, from, &to, &estimate);
    error[1] = fabs(to[0] - exact);
    error[2] = fabs(estimate.fifth[0]);
    check_below(fabs(to[3] + 2 * to[0]), 1e-15);
}

/* Of order 8 and 5, by a step half as long; the estimate of the latter, of order 4, is no less. */
static void test_exact_path_steps_have_their_orders(void **state) {
    double whole[3], half_step[3], order[3];
    (void)state;
    step_errors(0.3, whole);
    step_errors(0.15, half_step);
    for (int k = 0; k < 3; k++)
        order[k] = log2(whole[k] / half_step[k]) - 1;
    printf("  orders %.2f and %.2f, of the estimate %.2f\n", order[0], order[1], order[2]);
    check_below(fabs(order[0] - 8), 0.5);
    check_below(fabs(order[1] - 5), 0.5);
    check_below(fabs(order[2] - 4), 0.5);
    check_at_most(whole[1], whole[2]);
}

/* A rough path is as near to a great circle as it was told to be. */
static void test_exact_path_is_followed_roughly(void **state) {
    static struct shape shape;
    struct arena *arena = arena_new((size_t)1 << 26);
    struct surface *surface = split_sphere(&shape, arena);
    const struct vec3 r = {-0.3, 0.1, sqrt(0.9)};
    double worst = 0;
    (void)state;
    for (int k = 0; k < DIRECTIONS; k++) {
        struct surface_cursor cursor = {0, 0};
        struct surface_point from, to;
        struct path path;
        double uv[2], angle = 2 * M_PI * k / DIRECTIONS;
        chart(r, uv);
        assert_true(surface_point_at(surface, &cursor, uv, &from));
        struct vec3 u = vec3_unit(from.jet.u), v = vec3_cross(from.normal, u);
        struct vec3 t = vec3_axpy(sin(angle), v, vec3_scale(cos(angle), u));
        assert_true(path_geodesic(&path, surface, &from, t));
        path.accuracy = 1e-3;
        assert_true(path_advance(&path, half));
        assert_true(path_surface_point(&path, &cursor, &to, NULL));
        worst = fmax(worst, vec3_distance(circle(r, t, half), to.jet.r) / half);
    }
    printf("  off by %.1e of the length\n", worst);
    check_below(worst, 1e-3);
    check_above(worst, 1e-9); /* steps of order 8 would be off by 1e-10 */
    arena_free(arena);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_exact_path_steps_have_their_orders),
        cmocka_unit_test(test_exact_path_is_followed_roughly),
        cmocka_unit_test(test_exact_path_passes_corners_of_spans),
        cmocka_unit_test(test_exact_path_logarithms),
        cmocka_unit_test(test_exact_path_logarithms_over_joints_at_a_pole),
        cmocka_unit_test(test_exact_path_collocation_follows_geodesics),
        cmocka_unit_test(test_exact_path_collocation_on_sphere),
        cmocka_unit_test(test_exact_path_carries_its_jacobi_field),
        cmocka_unit_test(test_exact_path_is_lost_where_nothing_is_trusted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
