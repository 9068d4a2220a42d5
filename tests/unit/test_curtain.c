/* SPDX-License-Identifier: MIT */
/* Curtains: which straight ways pierce them, beside posts and ends as well. */
#include "solver/net/curtain.h"

#include "support.h"
#include "tests/check.h"

#include <math.h>

/* A curtain of height 2 in the plane z = 0 along a line of 5 posts, some of them turns. */
static struct curtain *zigzag(struct arena *arena) {
    static const struct curtain_post posts[5] = {{{0, 0, 0}, {0, 0, 1}, 2},
                                                 {{10, 0, 0}, {0, 0, 1}, 2},
                                                 {{20, 6, 0}, {0, 0, 1}, 2},
                                                 {{24, 6, 0}, {0, 0, 1}, 2},
                                                 {{30, -3, 0}, {0, 0, 1}, 2}};
    const struct curtain_line line = {posts, 5};
    struct curtain *curtain;
    assert_int_equal(curtain_make(&line, 1, arena, &curtain), STATUS_OK);
    return curtain;
}

static void test_curtain_parts_its_sides(void **state) {
    struct arena *arena = arena_new((size_t)1 << 20);
    const struct curtain *curtain = zigzag(arena);
    struct vec3 normal;
    (void)state;
    assert_true(curtain_parts(curtain, vec3_make(5, -1, 0), vec3_make(5, 1, 0), &normal));
    assert_true(normal.z == 1);
    assert_true(curtain_parts(curtain, vec3_make(5, -1, 1.9), vec3_make(5, 1, 1.9), NULL));
    assert_false(curtain_parts(curtain, vec3_make(5, -1, 2.1), vec3_make(5, 1, 2.1), NULL));
    assert_false(curtain_parts(curtain, vec3_make(5, -1, 0), vec3_make(6, -1, 0), NULL));
    assert_false(curtain_parts(curtain, vec3_make(5, -1, 0), vec3_make(5, -0.1, 0), NULL));
    /* before its beginning and behind its end */
    assert_false(curtain_parts(curtain, vec3_make(-0.1, -1, 0), vec3_make(-0.1, 1, 0), NULL));
    assert_true(curtain_parts(curtain, vec3_make(29.9, -6, 0), vec3_make(29.9, 1, 0), NULL));
    assert_false(curtain_parts(curtain, vec3_make(30.1, -6, 0), vec3_make(30.1, 1, 0), NULL));
    assert_true(curtain_end_distance(curtain, vec3_make(30, 0, 4)) == 5);
    arena_free(arena);
}

/* A way that begins on the curtain is on its left: it passes to the right, and not to the left. */
static void test_curtain_is_on_its_left(void **state) {
    struct arena *arena = arena_new((size_t)1 << 20);
    const struct curtain *curtain = zigzag(arena);
    (void)state;
    bool left = curtain_parts(curtain, vec3_make(5, 0, 0), vec3_make(5, 1, 0), NULL);
    bool right = curtain_parts(curtain, vec3_make(5, 0, 0), vec3_make(5, -1, 0), NULL);
    assert_true(left != right);
    assert_true(left == curtain_parts(curtain, vec3_make(7, 1, 0), vec3_make(7, 0, 0), NULL));
    arena_free(arena);
}

/* Whether the place in z = 0 is on the left of the curtain, which has one y at each x. */
static bool is_left(struct vec3 r) {
    double y = r.x < 10 ? 0 : r.x < 20 ? 0.6 * (r.x - 10) : r.x < 24 ? 6 : 6 - 1.5 * (r.x - 24);
    return r.y > y;
}

/* However a way goes from one side to the other, through posts too, the piece whose ends are on two
 * sides is parted; one whose ends are on one side only where it cuts off the corner at a post. */
static void test_curtain_lets_no_way_slip_through(void **state) {
    static const double turns[3] = {10, 20, 24};
    struct arena *arena = arena_new((size_t)1 << 20);
    const struct curtain *curtain = zigzag(arena);
    struct random random = random_begin("curtain");
    (void)state;
    for (int k = 0; k < 20000; k++) {
        struct vec3 from = {random_between(&random, 1, 29), -5, 0};
        struct vec3 to = {random_between(&random, 1, 29), 9, 0};
        if (k % 2) { /* straight through a post */
            struct vec3 post = k % 4 == 1 ? vec3_make(10, 0, 0) : vec3_make(20, 6, 0);
            from = vec3_make(post.x, -5, 0);
            to = vec3_make(post.x, 9, 0);
        }
        for (int n = 0; n < 64; n++) {
            struct vec3 a = vec3_axpy(n / 64.0, vec3_sub(to, from), from);
            struct vec3 b = vec3_axpy((n + 1) / 64.0, vec3_sub(to, from), from);
            bool corner = false;
            for (int post = 0; post < 3; post++)
                corner = corner || (a.x < turns[post]) != (b.x < turns[post]);
            if (is_left(a) != is_left(b) || !corner)
                assert_int_equal(curtain_parts(curtain, a, b, NULL), is_left(a) != is_left(b));
        }
    }
    arena_free(arena);
}

static void test_curtain_is_near_where_it_is(void **state) {
    struct arena *arena = arena_new((size_t)1 << 20);
    const struct curtain *curtain = zigzag(arena);
    (void)state;
    assert_true(curtain_is_near(curtain, vec3_make(5, 1, 0), 1.1));
    assert_false(curtain_is_near(curtain, vec3_make(5, 9, 0), 2));
    assert_false(curtain_is_near(curtain, vec3_make(-9, 0, 0), 2));
    /* by distance, whichever way it is turned: beyond its beginning, above it, beside a slant */
    assert_true(curtain_is_near(curtain, vec3_make(-3, 4, 0), 5.001));
    assert_false(curtain_is_near(curtain, vec3_make(-3, 4, 0), 4.999));
    assert_true(curtain_is_near(curtain, vec3_make(5, 3, 6), 5.001));
    assert_false(curtain_is_near(curtain, vec3_make(5, 3, 6), 4.999));
    double slant = hypot(10, 6);
    struct vec3 beside = {15 + 3 * 6 / slant, 3 - 3 * 10 / slant, 0};
    assert_true(curtain_is_near(curtain, beside, 3.001));
    assert_false(curtain_is_near(curtain, beside, 2.999));
    arena_free(arena);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_curtain_parts_its_sides),
        cmocka_unit_test(test_curtain_is_on_its_left),
        cmocka_unit_test(test_curtain_lets_no_way_slip_through),
        cmocka_unit_test(test_curtain_is_near_where_it_is),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
