/* SPDX-License-Identifier: MIT */
/*
 * Faces as real files have them give the net of the one surface that they are of: slivers, also
 * narrower than the tolerance, sides next to no length or of none, corners that all but meet, long
 * sides against several short ones, faces a little off their place, twice, turned round.
 * DRAPED_SEED sets the seed and DRAPED_ROUNDS how often all scenes are cut; what fails says its
 * seed.
 */
#include "tests/check.h"
#include "whole.h"
#include <stdio.h>
#include <stdlib.h>

static const uint64_t SEED = 20261123;

/* Some of the faces are in place, others off by up to this share of the size. */
static const double GAP = 1e-6;

static void test_exact_shell_files_are_the_whole(void **state) {
    const char *seed_text = getenv("DRAPED_SEED"), *rounds_text = getenv("DRAPED_ROUNDS");
    uint64_t seed = seed_text ? strtoull(seed_text, NULL, 10) : SEED;
    int rounds = rounds_text ? atoi(rounds_text) : 1, bad = 0;
    (void)state;
    printf("  seed %llu\n", (unsigned long long)seed);
    for (int round = 0; round < rounds; round++)
        for (int id = 0; id < SCENE_COUNT; id += check_stride(2), seed++)
            bad += !whole_scene_is_same((enum scene_id)id, CUT_BRICKS, seed % 2 ? GAP : 0, seed);
    assert_int_equal(bad, 0);
}

/* A face that is as good as none beside the edges of two others, one of them bare for being too
 * thin to have sides; and one that is thin at one end alone, between faces that are out of place.
 */
static void test_exact_shell_files_with_slivers(void **state) {
    (void)state;
    assert_true(whole_scene_is_same(SCENE_SPHERE_FULL, CUT_BRICKS, GAP, 20261125));
    assert_true(whole_scene_is_same(SCENE_SADDLE, CUT_BRICKS, GAP, 2259));
}

/* Faces that are hardly wider than the tolerance at one end alone, and neighbours that meet over
 * two slivers side by side. */
static void test_exact_shell_files_with_wedges(void **state) {
    (void)state;
    assert_true(whole_scene_is_same(SCENE_SPHERE, CUT_BRICKS, GAP, 42391));
    assert_true(whole_scene_is_same(SCENE_SPHERE, CUT_BRICKS, GAP, 20143));
    assert_true(whole_scene_is_same(SCENE_BEZIER, CUT_BRICKS, GAP, 42021));
}

/* In a corner of one face, trimmed along its own sides, where nodes lie on the edge. */
static void test_exact_shell_files_with_nodes_on_a_trim(void **state) {
    (void)state;
    assert_true(whole_scene_is_same(SCENE_SADDLE_CORNER, CUT_BRICKS, 0, 1008));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_exact_shell_files_are_the_whole),
        cmocka_unit_test(test_exact_shell_files_with_slivers),
        cmocka_unit_test(test_exact_shell_files_with_wedges),
        cmocka_unit_test(test_exact_shell_files_with_nodes_on_a_trim),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
