/* SPDX-License-Identifier: MIT */
#include "api/laminate/arrangement.h"

#include "support.h"
#include "tests/check.h"
#include <math.h>

static void add_line(struct segments *segments, double x0, double y0, double x1, double y1,
                     int32_t number) {
    const double from[2] = {x0, y0}, to[2] = {x1, y1};
    assert_true(segments_add(segments, from, to, number));
}

static void add_square(struct segments *segments, double low, double high, int32_t number) {
    add_line(segments, low, low, high, low, number);
    add_line(segments, high, low, high, high, number);
    add_line(segments, high, high, low, high, number);
    add_line(segments, low, high, low, low, number);
}

/* The area of the face at (x, y), and how long its edges of a number are. */
static void check_face(const struct segments *segments, double x, double y, double area,
                       int32_t number, double length) {
    struct polygons face = {0};
    const double at[2] = {x, y};
    int32_t *numbers;
    struct arrangement *all = arrangement_make(segments, segments->arena);
    assert_non_null(all);
    assert_true(arrangement_face(all, at, &face, &numbers));
    double sum = 0;
    for (size_t k = 0, first = 0; k < face.count; k++) {
        const struct polygons_point *a = &face.points[k];
        const struct polygons_point *b = &face.points[a->last ? first : k + 1];
        sum += numbers[k] == number ? hypot(b->x - a->x, b->y - a->y) : 0;
        first = a->last ? k + 1 : first;
    }
    check_at_most(fabs(polygons_area(&face) - area), 1e-12);
    check_at_most(fabs(sum - length), 1e-12);
    polygons_free(&face);
}

/* A square of side 4 that a line halves, with a hole and a line in the hole's middle that ends
 * inside; and what lies outside has no face. */
static void test_arrangement_finds_the_face_of_a_place(void **state) {
    struct arena *arena = arena_new((size_t)1 << 24);
    struct segments segments = {.arena = arena};
    (void)state;
    add_square(&segments, 0, 4, 1);
    check_face(&segments, 1, 1, 16, 1, 16);
    check_face(&segments, 5, 1, 0, 1, 0);
    add_line(&segments, 3, -1, 3, 5, 2);
    check_face(&segments, 1, 1, 12, 2, 4);
    check_face(&segments, 3.5, 1, 4, 2, 4);
    add_square(&segments, 1, 2, 3);
    check_face(&segments, 0.5, 0.5, 11, 3, 4);
    check_face(&segments, 1.5, 1.5, 1, 3, 4);
    add_line(&segments, 2, 1.5, 2.5, 1.5, 4); /* ends inside: divides nothing */
    check_face(&segments, 0.5, 0.5, 11, 4, 0);
    add_line(&segments, 2, 1.5, 3, 1.5,
             5); /* on it, and on to the line: a bridge, from both sides */
    check_face(&segments, 0.5, 0.5, 11, 5, 1);
    add_line(&segments, 0, 1.5, 1, 1.5, 6);
    check_face(&segments, 0.5, 0.5, 3 * 1.5 - 0.5, 6, 1);
    arena_free(arena);
}

static bool in_either_box(const void *context, const double at[2]) {
    (void)context;
    return (fabs(at[0]) < 1 && fabs(at[1]) < 1) || (fabs(at[0] - 1) < 1 && fabs(at[1]) < 0.5);
}

/* What is in one of two boxes, whose outlines cross. */
static void test_arrangement_selects_what_holds(void **state) {
    struct arena *arena = arena_new((size_t)1 << 24);
    struct segments segments = {.arena = arena};
    struct polygons selected = {0};
    (void)state;
    add_square(&segments, -1, 1, 0);
    add_line(&segments, 0, -0.5, 2, -0.5, 0);
    add_line(&segments, 2, -0.5, 2, 0.5, 0);
    add_line(&segments, 2, 0.5, 0, 0.5, 0);
    add_line(&segments, 0, 0.5, 0, -0.5, 0);
    struct arrangement *all = arrangement_make(&segments, arena);
    assert_non_null(all);
    assert_true(arrangement_select(all, in_either_box, NULL, &selected));
    assert_int_equal(selected.count, 8);
    check_at_most(fabs(polygons_area(&selected) - 5), 1e-12);
    polygons_free(&selected);
    arena_free(arena);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_arrangement_finds_the_face_of_a_place),
        cmocka_unit_test(test_arrangement_selects_what_holds),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
