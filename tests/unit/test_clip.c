/* SPDX-License-Identifier: MIT */
#include "api/laminate/clip.h"

#include "support.h"
#include "tests/check.h"
#include <math.h>

static void add_box(struct polygons *polygons, double x0, double y0, double x1, double y1,
                    bool hole) {
    const double x[4] = {x0, x1, x1, x0}, y[4] = {y0, y0, y1, y1};
    for (int k = 0; k < 4; k++)
        assert_true(polygons_add(polygons, x[hole ? 3 - k : k], y[hole ? 3 - k : k]));
    polygons_close(polygons);
}

static double area_of(const struct polygons *polygons) {
    double sum = 0;
    size_t first = 0;
    for (size_t k = 0; k < polygons->count; k++) {
        const struct polygons_point *a = &polygons->points[k];
        const struct polygons_point *b = &polygons->points[a->last ? first : k + 1];
        sum += (a->x * b->y - b->x * a->y) / 2;
        first = a->last ? k + 1 : first;
    }
    return sum;
}

static void check_area(struct polygons *a, struct polygons *b, double wanted) {
    struct polygons both = {0};
    assert_true(clip_make(a, b, &both));
    check_at_most(fabs(area_of(&both) - wanted), 1e-9);
    polygons_free(&both);
}

/* Boxes that overlap, touch, share edges, contain each other or are apart; and a hole. */
static void test_clip_of_boxes_has_their_common_area(void **state) {
    static const double boxes[][4] = {
        {1, 1, 3, 3},     {-1, -1, 1, 1}, {0, 0, 2, 2}, {0, 0, 2, 1}, {0, 0.5, 2, 1},
        {0.5, 0.5, 1, 1}, {-1, -1, 5, 5}, {2, 0, 3, 2}, {5, 5, 6, 6}, {0.5, -1, 1.5, 3}};
    (void)state;
    for (size_t k = 0; k < sizeof boxes / sizeof *boxes; k++) {
        const double *box = boxes[k];
        struct polygons a = {0}, b = {0};
        add_box(&a, 0, 0, 2, 2, false);
        add_box(&b, box[0], box[1], box[2], box[3], false);
        double wide = fmax(fmin(2, box[2]) - fmax(0, box[0]), 0);
        double high = fmax(fmin(2, box[3]) - fmax(0, box[1]), 0);
        check_area(&a, &b, wide * high);
        check_area(&b, &a, wide * high);
        polygons_free(&a);
        polygons_free(&b);
    }
    struct polygons ring = {0}, box = {0};
    add_box(&ring, 0, 0, 4, 4, false);
    add_box(&ring, 1, 1, 3, 3, true);
    add_box(&box, 2, -1, 5, 2, false);
    check_area(&ring, &box, 2 * 2 - 1);
    check_area(&box, &ring, 2 * 2 - 1);
    polygons_free(&ring);
    polygons_free(&box);
}

/* Inside both is inside the clip. */
static void test_clip_holds_what_is_in_both(void **state) {
    struct random random = random_begin("clip");
    (void)state;
    for (int round = 0; round < 200; round++) {
        struct polygons of[2] = {{0}, {0}}, both = {0};
        for (int n = 0; n < 2; n++) {
            int corners = 3 + random_index(&random, 12);
            double x = random_between(&random, -0.5, 0.5), y = random_between(&random, -0.5, 0.5);
            for (int k = 0; k < corners; k++) {
                double angle = 2 * M_PI * k / corners, r = random_between(&random, 0.3, 1);
                assert_true(polygons_add(&of[n], x + r * cos(angle), y + r * sin(angle)));
            }
            polygons_close(&of[n]);
        }
        assert_true(clip_make(&of[0], &of[1], &both));
        for (int k = 0; k < 200; k++) {
            double x = random_between(&random, -1.5, 1.5), y = random_between(&random, -1.5, 1.5);
            bool wanted = polygons_contain(&of[0], x, y) && polygons_contain(&of[1], x, y);
            assert_int_equal(polygons_contain(&both, x, y), wanted);
        }
        polygons_free(&of[0]);
        polygons_free(&of[1]);
        polygons_free(&both);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_clip_of_boxes_has_their_common_area),
        cmocka_unit_test(test_clip_holds_what_is_in_both),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
