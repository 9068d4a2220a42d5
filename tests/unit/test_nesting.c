/* SPDX-License-Identifier: MIT */
#include "api/result/nesting.h"

#include "support.h"
#include "tests/check.h"
#include <math.h>

enum { SHAPES = 6 };

static void finish_shape(struct nesting_shape *shape, struct polygons *cut, int layers) {
    polygons_close(cut);
    *shape = (struct nesting_shape){.cut = cut, .area = polygons_area(cut), .layers = layers};
    polygons_bounds(cut, shape->low, shape->high);
}

static void add_point(struct polygons *cut, double x, double y) {
    assert_true(polygons_add(cut, x, y));
}

/* The distance of (x, y) from the segment a b. */
static double segment_distance(const double a[2], const double b[2], const double at[2]) {
    double way[2] = {b[0] - a[0], b[1] - a[1]}, from[2] = {at[0] - a[0], at[1] - a[1]};
    double share = (way[0] * from[0] + way[1] * from[1]) / (way[0] * way[0] + way[1] * way[1]);
    share = fmin(fmax(share, 0), 1);
    return hypot(from[0] - share * way[0], from[1] - share * way[1]);
}

/* The least distance of corners of one shape on the roll from edges of the other, below 0 where one
 * lies inside the other. */
static double clearance(const struct nesting_shape *shapes, const struct nesting_place *p,
                        const struct nesting_place *q) {
    const struct polygons *a = shapes[p->shape].cut, *b = shapes[q->shape].cut;
    struct polygons placed = {0};
    double least = HUGE_VAL;
    for (size_t m = 0; m < b->count; m++) {
        double at[2];
        nesting_point(&shapes[q->shape], q, b->points[m].x, b->points[m].y, at);
        add_point(&placed, at[0], at[1]);
    }
    polygons_close(&placed);
    for (size_t n = 0; n < a->count; n++) {
        double at[2];
        nesting_point(&shapes[p->shape], p, a->points[n].x, a->points[n].y, at);
        double near = HUGE_VAL;
        for (size_t m = 0; m < placed.count; m++) {
            const struct polygons_point *from = &placed.points[m];
            const struct polygons_point *to = &placed.points[(m + 1) % placed.count];
            const double ends[2][2] = {{from->x, from->y}, {to->x, to->y}};
            near = fmin(near, segment_distance(ends[0], ends[1], at));
        }
        least = fmin(least, polygons_contain(&placed, at[0], at[1]) ? -near : near);
    }
    polygons_free(&placed);
    return least;
}

/* Random stars, some of them with several layers, on rolls with and without a gap. */
static void test_nesting_keeps_shapes_on_the_roll_and_apart(void **state) {
    struct random random = random_begin("nesting");
    (void)state;
    for (int round = 0; round < 12; round++) {
        struct polygons cuts[SHAPES] = {{0}};
        struct nesting_shape shapes[SHAPES];
        size_t count = 0;
        for (int k = 0; k < SHAPES; k++) {
            int corners = 3 + random_index(&random, 9);
            for (int n = 0; n < corners; n++) {
                double angle = 2 * M_PI * n / corners, r = random_between(&random, 0.2, 1);
                add_point(&cuts[k], 7 + r * cos(angle), r * sin(angle));
            }
            finish_shape(&shapes[k], &cuts[k], 1 + random_index(&random, 3));
            count += (size_t)shapes[k].layers;
        }
        struct nesting_roll roll = {random_between(&random, 2.1, 4), round % 2 * 0.05,
                                    round % 3 > 0};
        struct arena *arena = arena_new(1 << 24);
        struct nesting_place *places;
        double length;
        assert_true(nesting_make(shapes, SHAPES, &roll, arena, &places, &length));
        for (size_t n = 0; n < count; n++) {
            const struct nesting_shape *own = &shapes[places[n].shape];
            assert_true(roll.turn || !places[n].turned);
            if (n > 0) /* in the order in which they are cut: along the roll, then across it */
                assert_true(places[n - 1].x < places[n].x ||
                            (places[n - 1].x == places[n].x && places[n - 1].y <= places[n].y));
            check_at_most(-places[n].x, 0);
            check_at_most(-places[n].y, 0);
            check_at_most(places[n].x + own->high[0] - own->low[0] - length, 1e-12);
            check_at_most(places[n].y + own->high[1] - own->low[1] - roll.width, 1e-12);
            for (size_t m = 0; m < count; m++)
                if (m != n)
                    check_at_most(roll.gap - clearance(shapes, &places[n], &places[m]), 1e-9);
        }
        arena_free(arena);
        for (int k = 0; k < SHAPES; k++)
            polygons_free(&cuts[k]);
    }
}

/* Right-angled triangles of which two make a square fill the roll if they may be turned, up to the
 * bands, and half of it if not: the hypotenuse rises along the roll. */
static void test_nesting_turns_triangles_into_squares(void **state) {
    (void)state;
    for (int turn = 0; turn < 2; turn++) {
        struct polygons cut = {0};
        struct nesting_shape shape;
        struct arena *arena = arena_new(1 << 24);
        struct nesting_place *places;
        double length;
        add_point(&cut, 0, 0);
        add_point(&cut, 1, 0);
        add_point(&cut, 0, 1);
        finish_shape(&shape, &cut, 8);
        const struct nesting_roll roll = {1, 0, turn};
        assert_true(nesting_make(&shape, 1, &roll, arena, &places, &length));
        if (turn)
            check_at_most(fabs(length - 4), 8.0 / 240);
        else
            check_at_most(fabs(length - 8), 1e-12);
        arena_free(arena);
        polygons_free(&cut);
    }
}

/* Boxes of 3, 2 and 1 by 1 on a roll of 2: the last fits behind the second. */
static void test_nesting_is_shorter_than_shelves(void **state) {
    static const double sides[][2] = {{3, 1}, {2, 1}, {1, 1}};
    struct polygons cuts[3] = {{0}};
    struct nesting_shape shapes[3];
    struct arena *arena = arena_new(1 << 24);
    struct nesting_place *places;
    double length;
    (void)state;
    for (int k = 0; k < 3; k++) {
        add_point(&cuts[k], 0, 0);
        add_point(&cuts[k], sides[k][0], 0);
        add_point(&cuts[k], sides[k][0], sides[k][1]);
        add_point(&cuts[k], 0, sides[k][1]);
        finish_shape(&shapes[k], &cuts[k], 1);
    }
    const struct nesting_roll roll = {2, 0, true};
    assert_true(nesting_make(shapes, 3, &roll, arena, &places, &length));
    check_at_most(fabs(length - 3), 1e-12); /* on shelves 4 */
    arena_free(arena);
    for (int k = 0; k < 3; k++)
        polygons_free(&cuts[k]);
}

/* A million layers take a moment: four fit across the roll, with a gap three. */
static void test_nesting_of_very_many_layers_is_shelves(void **state) {
    struct polygons cut = {0};
    struct nesting_shape shape;
    (void)state;
    add_point(&cut, 0, 0);
    add_point(&cut, 1, 0);
    add_point(&cut, 1, 1);
    add_point(&cut, 0, 1);
    finish_shape(&shape, &cut, 1000000);
    for (int gaps = 0; gaps < 2; gaps++) {
        const struct nesting_roll roll = {4, gaps * 0.25, true};
        struct arena *arena = arena_new(1 << 28);
        struct nesting_place *places;
        double length;
        assert_true(nesting_make(&shape, 1, &roll, arena, &places, &length));
        check_at_most(fabs(length - (gaps ? 333334 * 1.25 - 0.25 : 250000)), 1e-6);
        check_at_most(fabs(places[1].y - 1 - roll.gap), 1e-12);
        arena_free(arena);
    }
    polygons_free(&cut);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_nesting_keeps_shapes_on_the_roll_and_apart),
        cmocka_unit_test(test_nesting_turns_triangles_into_squares),
        cmocka_unit_test(test_nesting_is_shorter_than_shelves),
        cmocka_unit_test(test_nesting_of_very_many_layers_is_shelves),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
