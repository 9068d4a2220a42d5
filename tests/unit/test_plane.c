/* SPDX-License-Identifier: MIT */
#include "api/laminate/plane.h"

#include "support.h"
#include "tests/check.h"
#include <math.h>
#include <string.h>

static struct api_problem problem;

static void add_box(struct polygons *polygons, double x0, double y0, double x1, double y1,
                    bool hole) {
    const double x[4] = {x0, x1, x1, x0}, y[4] = {y0, y0, y1, y1};
    for (int k = 0; k < 4; k++)
        assert_true(polygons_add(polygons, x[hole ? 3 - k : k], y[hole ? 3 - k : k]));
    polygons_close(polygons);
}

/* What is on the left, below 0 for holes. */
static double signed_area(const struct polygons *polygons) {
    double sum = 0;
    for (size_t first = 0; first < polygons->count;)
        sum += polygons_loop_area(polygons, first, &first);
    return sum;
}

static void check_area(const struct polygons *a, enum plane_operation operation,
                       const struct polygons *b, double wanted, double tolerance) {
    struct polygons result = {0};
    problem = (struct api_problem){0};
    assert_int_equal(plane_combine(a, operation, b, &result, &problem), API_OK);
    check_at_most(fabs(signed_area(&result) - wanted), tolerance);
    polygons_free(&result);
}

static void check_areas(const struct polygons *a, const struct polygons *b, double both) {
    double of_a = signed_area(a), of_b = signed_area(b);
    check_area(a, PLANE_BOTH, b, both, 1e-9);
    check_area(b, PLANE_BOTH, a, both, 1e-9);
    check_area(a, PLANE_EITHER, b, of_a + of_b - both, 1e-9);
    check_area(a, PLANE_FIRST_ALONE, b, of_a - both, 1e-9);
    check_area(b, PLANE_FIRST_ALONE, a, of_b - both, 1e-9);
}

/* Boxes that overlap, touch, share edges, contain each other or are apart; and a hole. */
static void test_plane_combines_boxes_to_their_areas(void **state) {
    static const double boxes[][4] = {
        {1, 1, 3, 3},     {-1, -1, 1, 1}, {0, 0, 2, 2}, {0, 0, 2, 1}, {0, 0.5, 2, 1},
        {0.5, 0.5, 1, 1}, {-1, -1, 5, 5}, {2, 0, 3, 2}, {5, 5, 6, 6}, {0.5, -1, 1.5, 3}};
    struct polygons ring = {0}, box = {0};
    (void)state;
    for (size_t k = 0; k < sizeof boxes / sizeof *boxes; k++) {
        const double *at = boxes[k];
        struct polygons a = {0}, b = {0};
        add_box(&a, 0, 0, 2, 2, false);
        add_box(&b, at[0], at[1], at[2], at[3], false);
        double wide = fmax(fmin(2, at[2]) - fmax(0, at[0]), 0);
        double high = fmax(fmin(2, at[3]) - fmax(0, at[1]), 0);
        check_areas(&a, &b, wide * high);
        polygons_free(&a);
        polygons_free(&b);
    }
    add_box(&ring, 0, 0, 4, 4, false);
    add_box(&ring, 1, 1, 3, 3, true);
    add_box(&box, 2, -1, 5, 2, false);
    check_areas(&ring, &box, 2 * 2 - 1);
    polygons_free(&ring);
    polygons_free(&box);
}

/* Shapes that overlap each other count once, and so does what a polygon has that crosses itself. */
static void test_plane_counts_what_is_enclosed_twice_once(void **state) {
    struct polygons shapes = {0}, none = {0}, bow = {0};
    static const double x[] = {0, 2, 2, 0}, y[] = {0, 2, 0, 1};
    (void)state;
    for (int k = 0; k < 20; k++)
        add_box(&shapes, 0.25 * k, 0, 0.25 * k + 1, 1, false);
    check_area(&shapes, PLANE_EITHER, &none, 5.75, 1e-9);
    check_area(&none, PLANE_BOTH, &shapes, 0, 0);
    for (int k = 3; k >= 0; k--) /* crosses itself at x = 2 / 3 */
        assert_true(polygons_add(&bow, x[k], y[k]));
    polygons_close(&bow);
    check_area(&bow, PLANE_EITHER, &none, 1.0 / 3 + 4.0 / 3, 1e-9);
    polygons_free(&shapes);
    polygons_free(&bow);
}

static void add_star(struct random *random, struct polygons *polygons) {
    int corners = 3 + random_index(random, 12);
    double x = random_between(random, -0.5, 0.5), y = random_between(random, -0.5, 0.5);
    for (int k = 0; k < corners; k++) {
        double angle = 2 * M_PI * k / corners, r = random_between(random, 0.3, 1);
        assert_true(polygons_add(polygons, x + r * cos(angle), y + r * sin(angle)));
    }
    polygons_close(polygons);
}

/* A place is inside the result where it should be. */
static void test_plane_holds_what_it_should(void **state) {
    struct random random = random_begin("plane");
    (void)state;
    for (int round = 0; round < 300; round++) {
        enum plane_operation operation = round % 3;
        struct polygons a = {0}, b = {0}, result = {0};
        add_star(&random, &a);
        add_star(&random, &b);
        assert_int_equal(plane_combine(&a, operation, &b, &result, &problem), API_OK);
        for (int k = 0; k < 200; k++) {
            double x = random_between(&random, -1.5, 1.5), y = random_between(&random, -1.5, 1.5);
            bool in_a = polygons_contain(&a, x, y), in_b = polygons_contain(&b, x, y);
            bool wanted = operation == PLANE_EITHER ? in_a || in_b
                          : operation == PLANE_BOTH ? in_a && in_b
                                                    : in_a && !in_b;
            assert_int_equal(polygons_contain(&result, x, y), wanted);
        }
        polygons_free(&a);
        polygons_free(&b);
        polygons_free(&result);
    }
}

/* A polygon and the same with every point moved by a little: from what makes no difference to what
 * makes one, no area is lost. */
static void test_plane_loses_nothing_where_edges_nearly_coincide(void **state) {
    struct random random = random_begin("nearly");
    (void)state;
    for (int round = 0; round < check_sized(600, 60); round++) {
        double off = pow(10, random_between(&random, -16, -5));
        struct polygons a = {0}, b = {0};
        for (int k = 0; k < 100; k++) {
            double angle = 2 * M_PI * k / 100, r = 1 + 0.3 * sin(3 * angle);
            double x = r * cos(angle), y = r * sin(angle);
            assert_true(polygons_add(&a, x, y));
            assert_true(polygons_add(&b, x + off * random_between(&random, -1, 1),
                                     y + off * random_between(&random, -1, 1)));
        }
        polygons_close(&a);
        polygons_close(&b);
        double area = signed_area(&a), slack = 20 * off + 1e-9;
        check_area(&a, PLANE_EITHER, &b, area, slack);
        check_area(&a, PLANE_BOTH, &b, area, slack);
        check_area(&a, PLANE_FIRST_ALONE, &b, 0, slack);
        polygons_free(&a);
        polygons_free(&b);
    }
}

static void test_plane_says_what_geos_does_not_take(void **state) {
    struct polygons a = {0}, b = {0}, result = {0};
    (void)state;
    problem = (struct api_problem){0};
    add_box(&a, 0, 0, 1, 1, false);
    add_box(&b, 0, 0, NAN, 1, false);
    assert_int_equal(plane_combine(&a, PLANE_BOTH, &b, &result, &problem), API_INTERNAL);
    assert_non_null(strstr(problem.error[0].detail, "polygons of the plane: "));
    polygons_free(&a);
    polygons_free(&b);
    polygons_free(&result);
}

/* ---- faces ---- */

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
    const struct segment **along;
    double sum = 0;
    assert_int_equal(plane_face(segments, at, &face, &along, &problem), API_OK);
    for (size_t k = 0, first = 0; k < face.count; k++) {
        const struct polygons_point *a = &face.points[k];
        const struct polygons_point *b = &face.points[a->last ? first : k + 1];
        sum += along[k]->number == number ? hypot(b->x - a->x, b->y - a->y) : 0;
        first = a->last ? k + 1 : first;
    }
    check_at_most(fabs(signed_area(&face) - area), 1e-9);
    check_at_most(fabs(sum - length), 1e-9);
    polygons_free(&face);
}

/* A square of side 4 that a line halves, with a hole and a line in the hole's middle that ends
 * inside; and what lies outside has no face. */
static void test_plane_finds_the_face_of_a_place(void **state) {
    struct arena *arena = arena_new((size_t)1 << 24);
    struct segments segments = {.arena = arena};
    (void)state;
    problem = (struct api_problem){0};
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
    add_line(&segments, 2, 1.5, 3, 1.5, 5); /* on it and on to the line: a bridge neither */
    check_face(&segments, 0.5, 0.5, 11, 5, 0);
    add_line(&segments, 0, 1.5, 1, 1.5, 6);
    check_face(&segments, 0.5, 0.5, 3 * 1.5 - 0.5, 6, 1);
    check_face(&segments, 0.5, 0.5, 3 * 1.5 - 0.5, 4, 0.5); /* of two the first */
    arena_free(arena);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_plane_combines_boxes_to_their_areas),
        cmocka_unit_test(test_plane_counts_what_is_enclosed_twice_once),
        cmocka_unit_test(test_plane_holds_what_it_should),
        cmocka_unit_test(test_plane_loses_nothing_where_edges_nearly_coincide),
        cmocka_unit_test(test_plane_says_what_geos_does_not_take),
        cmocka_unit_test(test_plane_finds_the_face_of_a_place),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
