/* SPDX-License-Identifier: MIT */
/* Cuts that a net asks for, on a square of side 1: its edge, ridges of shear, where the mouths of
 * cuts along them are, and the lines of cuts on the part. */
#include "api/study/proposal.h"
#include "sample.h"
#include "support.h"
#include "tests/check.h"
#include <math.h>

enum { SIDE = 21 }; /* nodes a side of the net */

static struct arena *arena;
static struct study_part part; /* the square, plane */
static struct vec3 corners[4] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
static struct vec3 ends[4] = {{1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 0}};
static const struct proposal_edge edge = {4, corners, ends};

static int make_part(void **state) {
    struct sample sample = sample_grid(8, 8, NULL);
    (void)state;
    arena = arena_new((size_t)1 << 28);
    part.geometry.mesh = sample_mesh(&sample, arena);
    part.area = 1;
    sample_free(&sample);
    return 0;
}

static int free_part(void **state) {
    (void)state;
    arena_free(arena);
    return 0;
}

static void check_place(struct vec3 found, double x, double y, double slack) {
    check_at_most(fabs(found.x - x), slack);
    check_at_most(fabs(found.y - y), slack);
}

/* ---- the edge ---- */

/* Loops are closed, and the lips of cuts are left out. */
static void test_edge_is_the_rim_without_lips(void **state) {
    static int32_t loop[] = {0, 0, 0, 0, 1, 1, 1}, cut[] = {0, 1, -1, 0, 0, 0, 0};
    static double x[] = {0, 1, 2, 3, 10, 11, 12}, y[] = {0, 0, 1, 1, 5, 5, 6}, z[7];
    static const int pieces[][2] = {{0, 1}, {3, 0}, {4, 5}, {5, 6}, {6, 4}};
    struct drape_rim rim = {.count = 7, .loop = loop, .x = x, .y = y, .z = z, .cut = cut};
    struct proposal_edge found;
    (void)state;
    assert_int_equal(proposal_edge_make(&rim, arena, &found), STATUS_OK);
    assert_int_equal(found.count, 5);
    for (size_t k = 0; k < 5; k++) {
        check_place(found.from[k], x[pieces[k][0]], y[pieces[k][0]], 0);
        check_place(found.to[k], x[pieces[k][1]], y[pieces[k][1]], 0);
    }
    rim.cut = NULL;
    assert_int_equal(proposal_edge_make(&rim, arena, &found), STATUS_OK);
    assert_int_equal(found.count, 7);
}

static void test_edge_has_its_nearest_place(void **state) {
    static const double places[][4] = {{0.4, 0.1, 0.4, 0},  {0.9, 0.4, 1, 0.4}, {0.3, 0.95, 0.3, 1},
                                       {0.1, 0.6, 0, 0.6},  {-1, -2, 0, 0},     {1.5, 2, 1, 1},
                                       {0.5, -0.5, 0.5, 0}, {1, 0, 1, 0}};
    const struct proposal_edge none = {0, NULL, NULL};
    (void)state;
    for (size_t k = 0; k < sizeof places / sizeof *places; k++) {
        const struct vec3 at = vec3_make(places[k][0], places[k][1], 0);
        check_place(proposal_edge_nearest(&edge, at), places[k][2], places[k][3], 1e-15);
        check_place(proposal_edge_nearest(&none, at), at.x, at.y, 0);
    }
}

/* The nearest place of the edge, or that which the ridge meets when it goes straight on. */
static void test_cuts_begin_at_the_edge(void **state) {
    const struct study_ridge ridges[] = {{{0.4, 0.3, 0}, {0.2, 0.3, 0}},
                                         {{0.3, 0.4, 0}, {0.6, 0.5, 0}},
                                         {{0.5, 0.2, 0}, {0.5, 0.2, 0}}};
    static const double nearest[][2] = {{0.4, 0}, {0, 0.4}, {0.5, 0}};
    static const double ahead[][2] = {{1, 0.3}, {0, 0.3}, {0.5, 0}};
    (void)state;
    for (size_t k = 0; k < 3; k++) {
        const struct study_cut near = proposal_cut(&part, &edge, 0.02, &ridges[k], MOUTH_NEAREST);
        const struct study_cut on = proposal_cut(&part, &edge, 0.02, &ridges[k], MOUTH_AHEAD);
        check_place(near.mouth, nearest[k][0], nearest[k][1], 1e-12);
        check_place(near.tip, ridges[k].inner.x, ridges[k].inner.y, 0);
        check_place(on.mouth, ahead[k][0], ahead[k][1], 0.01);
        check_place(on.tip, ridges[k].inner.x, ridges[k].inner.y, 0);
    }
}

static struct vec3 rolled(struct vec3 p) {
    const double turn = 2 * acos(-1) * p.x;
    return vec3_make(cos(turn), sin(turn), p.y);
}

/* Round a tube there is no edge ahead: the mouth is at the edge next to where the walk is given up.
 */
static void test_walk_round_a_tube_ends(void **state) {
    static struct vec3 low[] = {{1, 0, 0}, {-1, 0, 0}}, across[] = {{-1, 0, 0}, {1, 0, 0}};
    static const struct proposal_edge ends_of_tube = {2, low, across};
    const struct study_ridge ridge = {{1, 0, 0.5}, {cos(0.2), -sin(0.2), 0.5}};
    struct sample sample = sample_grid(24, 1, NULL);
    struct study_part tube = {.area = 2 * acos(-1)};
    (void)state;
    sample_map(&sample, rolled);
    tube.geometry.mesh = sample_mesh(&sample, arena);
    sample_free(&sample);
    const struct study_cut cut = proposal_cut(&tube, &ends_of_tube, 0.1, &ridge, MOUTH_AHEAD);
    check_place(cut.tip, cos(0.2), -sin(0.2), 0);
    check_at_most(fabs(cut.mouth.x), 1);
    check_at_most(fabs(cut.mouth.y) + fabs(cut.mouth.z), 1e-12);
}

/* ---- ridges ---- */

static int32_t node_i[SIDE * SIDE], node_j[SIDE * SIDE];
static double node_x[SIDE * SIDE], node_y[SIDE * SIDE], node_z[SIDE * SIDE], shear[SIDE * SIDE];

/* Nodes 0.05 apart, sheared by 50 degrees at x = 0.2 below y = 0.42, and by -60 at y = 0.8 beyond
 * x = 0.58, of which one is missing. */
static struct drape_result sheared_net(void) {
    struct drape_result result = {.nodes = {.count = 0,
                                            .i = node_i,
                                            .j = node_j,
                                            .x = node_x,
                                            .y = node_y,
                                            .z = node_z,
                                            .shear_deg = shear}};
    for (int j = 0; j < SIDE; j++)
        for (int i = 0; i < SIDE; i++) {
            size_t k = result.nodes.count++;
            node_i[k] = i;
            node_j[k] = j;
            node_x[k] = 0.05 * i;
            node_y[k] = 0.05 * j;
            shear[k] = i == 4 && j <= 8 ? 50 : j == 16 && i >= 12 && i != 15 ? -60 : 10;
        }
    return result;
}

/* The greatest shear first; each from its end next to the edge to the other one. */
static void test_ridges_run_from_the_edge_inwards(void **state) {
    const struct drape_result result = sheared_net();
    struct proposal_case c = {
        .part = &part, .edge = &edge, .result = &result, .limit_deg = 40, .spacing = 0.05};
    struct study_ridge ridges[3];
    size_t count;
    (void)state;
    assert_int_equal(proposal_find(&c, ridges, 3, arena, &count), STATUS_OK);
    assert_int_equal(count, 2);
    check_place(ridges[0].outer, 0.975, 0.8, 1e-9); /* the mean of its first two nodes */
    check_place(ridges[0].inner, 0.6, 0.8, 0.0251);
    check_place(ridges[1].outer, 0.2, 0.025, 1e-9);
    check_place(ridges[1].inner, 0.2, 0.4, 0.0251);
    assert_int_equal(proposal_find(&c, ridges, 1, arena, &count), STATUS_OK);
    assert_int_equal(count, 1);
    check_place(ridges[0].outer, 0.975, 0.8, 1e-9);
    c.limit_deg = 55;
    assert_int_equal(proposal_find(&c, ridges, 3, arena, &count), STATUS_OK);
    assert_int_equal(count, 1);
    c.limit_deg = 60;
    assert_int_equal(proposal_find(&c, ridges, 3, arena, &count), STATUS_OK);
    assert_int_equal(count, 0);
}

/* Where cloth ends without much shear a cut goes there, two spacings long at least; but not where a
 * ridge is. */
static void test_ridge_of_cloth_that_ends(void **state) {
    const struct drape_result result = sheared_net();
    struct proposal_case c = {.part = &part,
                              .edge = &edge,
                              .result = &result,
                              .limit_deg = 70,
                              .bare = true,
                              .at = {0.5, 0.3, 0},
                              .spacing = 0.05};
    struct study_ridge ridges[3];
    size_t count;
    (void)state;
    assert_int_equal(proposal_find(&c, ridges, 3, arena, &count), STATUS_OK);
    assert_int_equal(count, 1);
    check_place(ridges[0].inner, 0.5, 0.3, 1e-12);
    c.at = vec3_make(0.5, 0.03, 0);
    assert_int_equal(proposal_find(&c, ridges, 3, arena, &count), STATUS_OK);
    assert_int_equal(count, 1);
    check_place(ridges[0].inner, 0.5, 0.1, 1e-12);
    assert_int_equal(proposal_find(&c, ridges, 0, arena, &count), STATUS_OK);
    assert_int_equal(count, 0);
    c.at = vec3_make(0.5, 0, 0);
    assert_int_equal(proposal_find(&c, ridges, 3, arena, &count), STATUS_OK);
    assert_int_equal(count, 0);
    c.limit_deg = 40;
    c.at = vec3_make(0.5, 0.3, 0);
    assert_int_equal(proposal_find(&c, ridges, 3, arena, &count), STATUS_OK);
    assert_int_equal(count, 2);
}

/* ---- lines ---- */

static struct vec3 folded(struct vec3 p) {
    return vec3_make(p.x, p.y, fabs(p.x - 0.5));
}

/* On a plane the two ends; over a fold its place between them, within a step. */
static void test_lines_have_the_places_they_need(void **state) {
    const struct study_cut cut = {{0, 0.5, 0}, {0.8, 0.5, 0}};
    struct study_cut over = {{0, 0.5, 0.5}, {1, 0.5, 0.5}};
    struct sample sample = sample_grid(8, 8, NULL);
    struct study_part roof = {.area = 1};
    struct drape_cut_line line;
    (void)state;
    assert_int_equal(proposal_line(&part, &cut, 0.05, arena, &line), STATUS_OK);
    assert_int_equal(line.count, 2);
    check_place(line.path[0], 0, 0.5, 0);
    check_place(line.path[1], 0.8, 0.5, 0);
    check_place(proposal_place(&part, &cut, 0.25), 0.2, 0.5, 1e-12);
    check_place(proposal_place(&part, &cut, 1.125), 0.9, 0.5, 1e-12);
    sample_map(&sample, folded);
    roof.geometry.mesh = sample_mesh(&sample, arena);
    sample_free(&sample);
    assert_int_equal(proposal_line(&roof, &over, 0.05, arena, &line), STATUS_OK);
    check_at_least(line.count, 3);
    check_at_most(line.count, 5);
    for (size_t k = 0; k < line.count; k++)
        check_at_most(fabs(line.path[k].z - fabs(line.path[k].x - 0.5)), 1e-9);
    check_place(line.path[line.count - 1], 1, 0.5, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_edge_is_the_rim_without_lips),
        cmocka_unit_test(test_edge_has_its_nearest_place),
        cmocka_unit_test(test_cuts_begin_at_the_edge),
        cmocka_unit_test(test_walk_round_a_tube_ends),
        cmocka_unit_test(test_ridges_run_from_the_edge_inwards),
        cmocka_unit_test(test_ridge_of_cloth_that_ends),
        cmocka_unit_test(test_lines_have_the_places_they_need),
    };
    return cmocka_run_group_tests(tests, make_part, free_part);
}
