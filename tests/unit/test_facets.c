/* SPDX-License-Identifier: MIT */
#include "solver/mesh/facets.h"

#include "cloth.h"
#include "own_arena.h"
#include "tests/check.h"
#include <math.h>

/* ---- nets ---- */

static struct vec3 flat(double i, double j) {
    return vec3_make(i, j, 0);
}

static struct vec3 bent(double i, double j) {
    return vec3_make(i + 0.3 * sin(j), 0.9 * j + 0.2 * cos(2 * i), 2 * sin(0.4 * i) * cos(0.3 * j));
}

/* A tube that comes back nearly to where it began. */
static struct vec3 rolled(double i, double j) {
    return vec3_make(3 * cos(0.4 * i), 3 * sin(0.4 * i), j);
}

/* Cells whose corners are all in one place. */
static struct vec3 collapsed(double i, double j) {
    return vec3_make(i < 3 ? i : 3, j < 2 ? j : 2, 0);
}

static bool with_hole(int i, int j) {
    return !(i >= 4 && i < 7 && j >= 3 && j < 6) && !(i > 9 && j > 8);
}

static bool in_rows(int i, int j) {
    return j % 2 == 0 || i == 3;
}

static struct facets *facets_of(const struct cloth *cloth) {
    const struct facets_source source = cloth_source(cloth);
    struct facets *facets = NULL;
    assert_int_equal(facets_make(&source, arena, &facets), STATUS_OK);
    return facets;
}

/* ---- another way to the nearest place ---- */

static double to_edge(struct vec3 p, struct vec3 a, struct vec3 b) {
    struct vec3 ab = vec3_sub(b, a);
    double length = vec3_norm2(ab), t = length > 0 ? vec3_dot(vec3_sub(p, a), ab) / length : 0;
    return vec3_distance(p, vec3_axpy(fmin(fmax(t, 0), 1), ab, a));
}

/* The foot on the plane when it is on the inner side of all edges, else the nearest edge. */
static double to_triangle(struct vec3 p, struct vec3 a, struct vec3 b, struct vec3 c) {
    struct vec3 n = vec3_cross(vec3_sub(b, a), vec3_sub(c, a)), r[4] = {a, b, c, a};
    bool inside = vec3_norm2(n) > 0;
    for (int k = 0; k < 3; k++)
        inside =
            inside && vec3_dot(vec3_cross(vec3_sub(r[k + 1], r[k]), vec3_sub(p, r[k])), n) >= 0;
    if (inside)
        return fabs(vec3_dot(vec3_sub(p, a), n)) / vec3_norm(n);
    return fmin(to_edge(p, a, b), fmin(to_edge(p, b, c), to_edge(p, c, a)));
}

static double by_looking_at_all(const struct cloth *cloth, struct vec3 p) {
    double best = HUGE_VAL;
    for (size_t cell = 0; cell < cloth->cell_count; cell++) {
        struct vec3 middle = cloth_middle(cloth, cell);
        for (int side = 0; side < 4; side++) {
            const int32_t *c = cloth->corners[cell];
            best = fmin(best, to_triangle(p, middle, cloth->nodes[c[side]],
                                          cloth->nodes[c[(side + 1) % 4]]));
        }
    }
    return best;
}

static void assert_place(const struct cloth *cloth, const struct facets_point *place,
                         struct vec3 p) {
    const int32_t *c = cloth->corners[place->cell];
    struct vec3 r = vec3_scale(place->weight[0], cloth_middle(cloth, (size_t)place->cell));
    double sum = 0;
    for (int k = 0; k < 3; k++) {
        check_at_least(place->weight[k], 0);
        sum += place->weight[k];
    }
    for (int k = 0; k < 2; k++)
        r = vec3_axpy(place->weight[1 + k], cloth->nodes[c[(place->side + k) % 4]], r);
    check_below(fabs(sum - 1), 1e-14);
    check_below(vec3_distance(r, place->r), 1e-12);
    check_below(fabs(vec3_distance(p, place->r) - place->distance), 1e-12);
}

static void find_nearest(const struct facets *facets, struct vec3 point,
                         struct facets_point *place) {
    struct facets_search walk = facets_search_begin(facets);
    facets_nearest(&walk, point, place);
}

static struct vec3 random_point(struct random *random, double reach) {
    double x = random_between(random, -2 * reach, 14 * reach);
    double y = random_between(random, -2 * reach, 12 * reach);
    return vec3_make(x, y, random_between(random, -2 * reach, 2 * reach));
}

/* ---- tests ---- */

static void test_facets_nearest_is_that_of_looking_at_all(void **state) {
    (void)state;
    struct vec3 (*const shapes[])(double, double) = {flat, bent, rolled, collapsed};
    bool (*const parts[])(int, int) = {NULL, with_hole, in_rows};
    struct random random = random_begin("nearest");
    for (int which = 0; which < 12; which++) {
        struct cloth cloth = cloth_make(13, 11, shapes[which % 4], parts[which / 4]);
        struct facets *facets = facets_of(&cloth);
        for (int trial = 0; trial < 400; trial++) {
            double reach = trial % 4 ? 1 : 30;
            struct vec3 p = random_point(&random, reach);
            struct facets_point place;
            find_nearest(facets, p, &place);
            assert_place(&cloth, &place, p);
            check_below(fabs(place.distance - by_looking_at_all(&cloth, p)), 1e-11 * reach);
        }
        cloth_free(&cloth);
    }
}

/* Small steps near the cloth, and jumps. Rolled and flat nets have places as near as another. */
static void test_facets_nearest_does_not_depend_on_what_was_searched_before(void **state) {
    (void)state;
    struct vec3 (*const shapes[])(double, double) = {flat, bent, rolled, collapsed};
    struct random random = random_begin("walk");
    for (int which = 0; which < 4; which++) {
        struct cloth cloth = cloth_make(40, 33, shapes[which], which == 1 ? with_hole : NULL);
        struct facets *facets = facets_of(&cloth);
        struct facets_search walk = facets_search_begin(facets);
        struct vec3 p = random_point(&random, 1);
        for (int trial = 0; trial < 3000; trial++) {
            double step = 0.5 * random_index(&random, 5);
            struct vec3 by = {random_index(&random, 3) - 1, random_index(&random, 3) - 1,
                              random_index(&random, 3) - 1};
            p = trial % 50 ? vec3_axpy(step, by, p) : random_point(&random, 1 + trial % 4);
            struct facets_point place, alone;
            facets_nearest(&walk, p, &place);
            find_nearest(facets, p, &alone);
            assert_true(place.cell == alone.cell && place.side == alone.side);
            assert_true(place.distance == alone.distance && place.outside == alone.outside);
            assert_memory_equal(place.weight, alone.weight, sizeof place.weight);
        }
        cloth_free(&cloth);
    }
}

static bool is_outside(const struct facets *facets, double x, double y, double z) {
    struct facets_point place;
    find_nearest(facets, vec3_make(x, y, z), &place);
    return place.outside;
}

static void test_facets_outside_is_beyond_the_rim(void **state) {
    (void)state;
    struct cloth cloth = cloth_make(12, 10, flat, with_hole);
    struct facets *facets = facets_of(&cloth);
    assert_false(is_outside(facets, 0.5, 0.5, 0));
    assert_false(is_outside(facets, 0.5, 0.5, 7)); /* far above is not beyond */
    assert_false(is_outside(facets, 0, 3.3, 0));   /* on the rim, on a corner of it, and above */
    assert_false(is_outside(facets, 0, 0, 0));
    assert_false(is_outside(facets, 4, 3, 2));
    assert_false(is_outside(facets, 2, 2, 0)); /* a corner inside, an edge inside */
    assert_false(is_outside(facets, 2, 2.5, 1));
    assert_true(is_outside(facets, -0.01, 3.3, 0));
    assert_true(is_outside(facets, -0.01, -0.01, 0));
    assert_true(is_outside(facets, 12.2, 1, 5));
    assert_true(is_outside(facets, 5.5, 4.5, 0)); /* the hole */
    assert_true(is_outside(facets, 11, 9.5, 0));  /* the missing corner */
    cloth_free(&cloth);
}

/* Above a roof's ridge, and in its valley, the nearest place is on an inner edge. */
static struct vec3 roof(double i, double j) {
    return vec3_make(i, j, -fabs(i - 3));
}

static void test_facets_above_a_ridge_is_not_outside(void **state) {
    (void)state;
    struct cloth cloth = cloth_make(6, 4, roof, NULL);
    struct facets *facets = facets_of(&cloth);
    for (double y = 0.5; y < 4; y += 0.25)
        assert_false(is_outside(facets, 3.1, y, 2));
    cloth_free(&cloth);
}

static void test_facets_of_one_cell_and_of_none(void **state) {
    (void)state;
    struct cloth cloth = cloth_make(1, 1, flat, NULL);
    struct facets *facets = facets_of(&cloth);
    struct facets_point place;
    find_nearest(facets, vec3_make(0.5, 0.5, -3), &place);
    assert_true(place.cell == 0 && place.distance == 3 && !place.outside);
    assert_true(place.weight[0] == 1);
    struct facets_source source = cloth_source(&cloth);
    source.cell_count = 0;
    assert_int_equal(facets_make(&source, arena, &facets), STATUS_INVALID);
    cloth_free(&cloth);
}

static void test_facets_without_memory_is_a_status(void **state) {
    (void)state;
    struct cloth cloth = cloth_make(9, 9, bent, NULL);
    const struct facets_source source = cloth_source(&cloth);
    struct facets *facets;
    for (size_t n = 1; n <= 5; n++) {
        arena_fail_at(arena, n);
        assert_int_equal(facets_make(&source, arena, &facets), STATUS_OUT_OF_MEMORY);
    }
    arena_fail_at(arena, 0);
    cloth_free(&cloth);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_facets_nearest_is_that_of_looking_at_all),
        cmocka_unit_test(test_facets_nearest_does_not_depend_on_what_was_searched_before),
        cmocka_unit_test(test_facets_outside_is_beyond_the_rim),
        cmocka_unit_test(test_facets_above_a_ridge_is_not_outside),
        cmocka_unit_test(test_facets_of_one_cell_and_of_none),
        cmocka_unit_test(test_facets_without_memory_is_a_status),
    };
    return cmocka_run_group_tests_name("facets", tests, set_up, tear_down);
}
