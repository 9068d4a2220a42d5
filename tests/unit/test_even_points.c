/* SPDX-License-Identifier: MIT */
/* Points spread evenly over the area of a part. */
#include "solver/mesh/even_points.h"

#include "sample.h"
#include "support.h"
#include "tests/check.h"
#include <math.h>

/* The plane [0, 1]^2, which its parameters run over unevenly: x = u^3, y = v. */
static struct surface *uneven_plane(struct arena *arena) {
    static const double knots_u[] = {0, 0, 0, 0, 1, 1, 1, 1}, knots_v[] = {0, 0, 1, 1};
    static struct vec3 points[8];
    struct surface *surface;
    for (int k = 0; k < 8; k++)
        points[k] = vec3_make(k / 2 == 3, k % 2, 0);
    const struct nurbs nurbs = {.u = {.degree = 3, .size = 4, .knots = knots_u, .knot_count = 8},
                                .v = {.degree = 1, .size = 2, .knots = knots_v, .knot_count = 4},
                                .points = points,
                                .point_count = 8};
    assert_int_equal(surface_make(&nurbs, arena, &surface), STATUS_OK);
    return surface;
}

/* Every place has a share of the area near the mean, counted by a fine grid of those points of
 * [0, 1]^2 that are `inside`, and its nearest neighbour about a spacing away. */
static void check_even(const struct part_point *places, size_t count,
                       bool (*inside)(double x, double y)) {
    enum { N = 200 };
    size_t *own = calloc(count, sizeof *own), all = 0;
    for (int k = 0; k < N * N; k++) {
        struct vec3 r = vec3_make((k % N + 0.5) / N, (k / N + 0.5) / N, 0);
        size_t nearest = 0;
        if (inside && !inside(r.x, r.y))
            continue;
        for (size_t s = 1; s < count; s++)
            if (vec3_distance(places[s].r, r) < vec3_distance(places[nearest].r, r))
                nearest = s;
        own[nearest]++;
        all++;
    }
    double mean = (double)all / (double)count, spacing = sqrt(mean) / N;
    for (size_t s = 0; s < count; s++) {
        double least = HUGE_VAL;
        for (size_t t = 0; t < count; t++)
            least = t == s ? least : fmin(least, vec3_distance(places[s].r, places[t].r));
        check_at_least((double)own[s], 0.5 * mean);
        check_at_most((double)own[s], 1.5 * mean);
        check_at_least(least, 0.5 * spacing);
        check_at_most(least, 1.5 * spacing);
        assert_true(!inside || inside(places[s].r.x, places[s].r.y));
    }
    free(own);
}

static void test_even_points_are_even_in_space_and_not_in_parameters(void **state) {
    struct arena *arena = arena_new((size_t)1 << 30);
    const struct drape_part part = {.surface = uneven_plane(arena)};
    struct part_point *places;
    size_t found;
    (void)state;
    static const size_t counts[] = {9, 50, 333};
    for (size_t k = 0; k < sizeof counts / sizeof *counts; k++) {
        assert_int_equal(even_points(&part, 0, counts[k], arena, &places, &found), STATUS_OK);
        assert_int_equal(found, counts[k]);
        check_even(places, found, NULL);
        for (size_t s = 0; s < found; s++)
            check_at_most(fabs(pow(places[s].uv[0], 3) - places[s].r.x), 1e-12);
    }
    arena_free(arena);
}

/* The square less a disc of radius 0.3 in its middle. */
static bool beside_the_disc(double x, double y) {
    return hypot(x - 0.5, y - 0.5) > 0.2999;
}

static void test_even_points_stay_within_trims(void **state) {
    enum { SIDES = 360 };
    struct arena *arena = arena_new((size_t)1 << 30);
    struct surface *surface = uneven_plane(arena);
    double circle[SIDES][2];
    const double(*points)[2] = (const double(*)[2])circle;
    for (int k = 0; k < SIDES; k++) {
        double t = 2 * acos(-1) * k / SIDES;
        circle[k][0] = cbrt(0.5 + 0.3 * cos(t));
        circle[k][1] = 0.5 + 0.3 * sin(t);
    }
    const struct trim_curve curve = {.degree = 1, .points = points, .count = SIDES};
    const struct trim_loop loop = {.curves = &curve, .count = 1};
    struct trim *trim;
    struct part_point *places;
    size_t found;
    (void)state;
    assert_int_equal(trim_make(surface, &loop, 1, arena, &trim), STATUS_OK);
    const struct drape_part part = {.surface = surface, .trim = trim};
    assert_int_equal(even_points(&part, 0, 60, arena, &places, &found), STATUS_OK);
    assert_int_equal(found, 60);
    check_even(places, found, beside_the_disc);
    arena_free(arena);
}

static struct vec3 cubed(struct vec3 p) {
    return vec3_make(p.x * p.x * p.x, p.y, p.z);
}

/* Triangles of very different sizes; a second component gets none. */
static void test_even_points_on_meshes_go_by_area(void **state) {
    struct arena *arena = arena_new((size_t)1 << 30);
    struct sample sample = sample_grid(15, 9, NULL), other = sample_grid(3, 3, NULL);
    struct part_point *places;
    size_t found;
    (void)state;
    sample_map(&sample, cubed);
    for (size_t k = 0; k < other.vertex_count; k++)
        other.vertices[k].z += 5;
    sample_add(&sample, &other);
    struct mesh *mesh = sample_mesh(&sample, arena);
    for (int32_t component = 0; component < 2; component++) {
        const struct drape_part part = {.mesh = mesh};
        assert_int_equal(even_points(&part, component, 40, arena, &places, &found), STATUS_OK);
        assert_int_equal(found, 40);
        double height = places[0].r.z;
        for (size_t s = 0; s < found; s++) {
            assert_true(places[s].r.z == height);
            assert_int_equal(mesh->component[places[s].face], component);
            places[s].r.z = 0;
        }
        check_even(places, found, NULL);
    }
    sample_free(&sample);
    sample_free(&other);
    arena_free(arena);
}

/* The memory that ran out is told. */
static void test_even_points_without_memory(void **state) {
    enum { MOST = 40 };
    (void)state;
    for (size_t n = 1; n < MOST; n++) {
        struct arena *arena = arena_new((size_t)1 << 30);
        const struct drape_part part = {.surface = uneven_plane(arena)};
        struct part_point *places;
        size_t found;
        arena_fail_at(arena, n);
        enum status status = even_points(&part, 0, 20, arena, &places, &found);
        arena_free(arena);
        if (status == STATUS_OK)
            return;
        assert_int_equal(status, STATUS_OUT_OF_MEMORY);
    }
    fail_msg("it takes more than %d allocations", MOST);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_even_points_are_even_in_space_and_not_in_parameters),
        cmocka_unit_test(test_even_points_stay_within_trims),
        cmocka_unit_test(test_even_points_on_meshes_go_by_area),
        cmocka_unit_test(test_even_points_without_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
