/* SPDX-License-Identifier: MIT */
/* Lines along parts whose nearest places are known in closed form. */
#include "solver/laid_line.h"

#include "tests/check.h"
#include <math.h>

static const double reach = 0.05;

static enum status lay(bool (*nearest)(const void *, struct vec3, struct vec3 *, struct vec3 *),
                       struct vec3 from, struct vec3 to, struct arena *arena,
                       struct drape_cut_line *line) {
    const struct laid_line_part part = {nearest, NULL};
    const struct vec3 ends[2] = {from, to};
    const struct drape_cut_line asked = {ends, 2};
    return laid_line_make(&part, &asked, reach, arena, line);
}

/* How far the middles of a line's pieces are from the part, at the most. */
static double greatest_rise(bool (*nearest)(const void *, struct vec3, struct vec3 *,
                                            struct vec3 *),
                            const struct drape_cut_line *line) {
    double most = 0;
    struct vec3 place, normal;
    for (size_t k = 1; k < line->count; k++) {
        struct vec3 middle = vec3_scale(0.5, vec3_add(line->path[k - 1], line->path[k]));
        assert_true(nearest(NULL, middle, &place, &normal));
        most = fmax(most, vec3_distance(middle, place));
    }
    return most;
}

static bool nearest_on_sphere(const void *context, struct vec3 r, struct vec3 *place,
                              struct vec3 *normal) {
    (void)context;
    *place = *normal = vec3_unit(r);
    return vec3_norm2(r) > 0;
}

static void test_laid_line_is_the_great_circle(void **state) {
    (void)state;
    struct arena *arena = arena_new(1 << 20);
    struct drape_cut_line line;
    struct vec3 from = {1, 0, 0}, to = vec3_unit(vec3_make(-0.5, 1, 0.3));
    struct vec3 across = vec3_unit(vec3_cross(from, to));
    assert_int_equal(lay(nearest_on_sphere, from, to, arena, &line), STATUS_OK);
    check_at_most(greatest_rise(nearest_on_sphere, &line), reach);
    assert_int_equal(line.count, 5);
    for (size_t k = 0; k < line.count; k++) {
        check_at_most(fabs(vec3_dot(line.path[k], across)), 1e-15);
        check_at_most(fabs(vec3_norm(line.path[k]) - 1), 1e-15);
    }
    arena_free(arena);
}

/* Two sides of a box: x <= 0 of the plane z = 0, and z <= 0 of the plane x = 0. */
static bool nearest_on_box(const void *context, struct vec3 r, struct vec3 *place,
                           struct vec3 *normal) {
    (void)context;
    struct vec3 top = {fmin(r.x, 0), r.y, 0}, side = {0, r.y, fmin(r.z, 0)};
    bool above = vec3_distance(top, r) <= vec3_distance(side, r);
    *place = above ? top : side;
    *normal = above ? vec3_make(0, 0, 1) : vec3_make(1, 0, 0);
    return true;
}

static void test_laid_line_goes_over_an_edge(void **state) {
    (void)state;
    struct arena *arena = arena_new(1 << 20);
    struct drape_cut_line line;
    assert_int_equal(lay(nearest_on_box, vec3_make(-2, 0, 0), vec3_make(0, 1, -3), arena, &line),
                     STATUS_OK);
    check_at_most(greatest_rise(nearest_on_box, &line), reach);
    for (size_t k = 0; k < line.count; k++)
        check_at_most(fmin(fabs(line.path[k].x), fabs(line.path[k].z)), 1e-15);
    arena_free(arena);
}

/* A plane with a round hole of radius 1. */
static bool nearest_beside_hole(const void *context, struct vec3 r, struct vec3 *place,
                                struct vec3 *normal) {
    (void)context;
    double radius = hypot(r.x, r.y), grown = radius < 1 ? 1 / radius : 1;
    *place = vec3_make(grown * r.x, grown * r.y, 0);
    *normal = vec3_make(0, 0, 1);
    return radius > 0;
}

static void test_laid_line_goes_round_no_hole(void **state) {
    (void)state;
    struct arena *arena = arena_new(1 << 20);
    struct drape_cut_line line;
    assert_int_equal(
        lay(nearest_beside_hole, vec3_make(-3, 0.5, 0), vec3_make(4, 0.4, 0), arena, &line),
        STATUS_OK);
    assert_int_equal(line.count, 2);
    arena_free(arena);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_laid_line_is_the_great_circle),
        cmocka_unit_test(test_laid_line_goes_over_an_edge),
        cmocka_unit_test(test_laid_line_goes_round_no_hole),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
