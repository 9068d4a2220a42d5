/* SPDX-License-Identifier: MIT */
#include "studied.h"

#include "tests/check.h"
#include <math.h>
#include <stdio.h>

/* With a part of the drapes it finds what a grid finds, or better, and keeps its budget. */
static void test_optimise_beats_a_grid(void **state) {
    static const char vary[] = "\"vary\":{\"start\":{\"grid\":60},\"angle_deg\":{\"from\":0,"
                               "\"to\":75,\"step\":15}},\"objectives\":[\"max_shear_deg\"]";
    char rest[300];
    struct bytes parts[] = {text_replace(studied_bowl, "0.1", "0.08"), studied_mesh()};
    (void)state;
    for (int k = 0; k < 2; k += check_stride(2)) {
        struct studied grid = studied_make(parts[k].data, vary);
        snprintf(rest, sizeof rest, "%s,\"search\":\"optimise\",\"budget\":180", vary);
        struct studied best = studied_make(parts[k].data, rest);
        check_at_most(best.rows, 180);
        check_at_most(studied_best(&best, QUANTITY_MAX_SHEAR),
                      studied_best(&grid, QUANTITY_MAX_SHEAR) + 1e-9);
        studied_check_bits(&best, (size_t)best.columns.study.best[QUANTITY_MAX_SHEAR]);
        studied_free(&grid);
        studied_free(&best);
    }
    bytes_free(&parts[0]);
    bytes_free(&parts[1]);
}

/* On z = (x^2 + y^2) / 2 over a square it finds its apex, from where the net is that of a
 * translation surface: sin gamma = x y / sqrt((1 + x^2)(1 + y^2)), 30 degrees in the corners (1,
 * 1). */
static void test_optimise_finds_the_apex_of_a_bowl(void **state) {
    struct studied f =
        studied_make(studied_bowl, "\"vary\":{\"start\":{\"grid\":9}},\"search\":\"optimise\","
                                   "\"budget\":150,\"objectives\":[\"max_shear_deg\"]");
    (void)state;
    size_t best = (size_t)f.columns.study.best[QUANTITY_MAX_SHEAR];
    check_at_most(fabs(studied_value(&f, "x", best)), 0.01);
    check_at_most(fabs(studied_value(&f, "y", best)), 0.01);
    check_at_most(fabs(studied_value(&f, "max_shear_deg", best) - 30), 0.3);
    studied_free(&f);
}

/* On a studied_roof, whose faces have their normals to different sides, the net is that of a plane:
 * the cut is a rectangle, without waste, where the yarns run along the edges, wherever it starts.
 */
static void test_optimise_goes_over_the_faces_of_a_shell(void **state) {
    struct studied f = studied_make(
        studied_roof,
        "\"vary\":{\"start\":{\"grid\":9},\"angle_deg\":{\"from\":0,\"to\":80,\"step\":10}},"
        "\"search\":\"optimise\",\"budget\":120,\"objectives\":[\"waste_area\"]");
    (void)state;
    check_at_most(studied_best(&f, QUANTITY_WASTE_AREA), 0.005);
    studied_free(&f);
}

/* On a roof of two planes no yarn is sheared, wherever it starts: the search ends when it has
 * looked everywhere. With something to find, here less waste, as an objective or a limit that none
 * keeps or that some miss by little, it has all of its budget. */
static void test_optimise_ends_where_all_are_as_good(void **state) {
    static const char *const more[] = {"]", ",\"waste_area\"]",
                                       "],\"limits\":{\"waste_area\":{\"max\":1e-9}}",
                                       "],\"limits\":{\"waste_area\":{\"max\":0.5}}"};
    char rest[300];
    (void)state;
    for (int k = 0; k < 4; k++) {
        snprintf(
            rest, sizeof rest,
            "\"vary\":{\"start\":{\"grid\":9},\"angle_deg\":{\"from\":0,\"to\":80,\"step\":10}},"
            "\"search\":\"optimise\",\"budget\":120,\"objectives\":[\"max_shear_deg\"%s",
            more[k]);
        struct studied f = studied_make(studied_roof, rest);
        check_at_least(f.rows, k ? 120 : 45);
        check_at_most(f.rows, k ? 120 : 50);
        check_at_most(studied_best(&f, QUANTITY_MAX_SHEAR), 1e-9);
        studied_free(&f);
    }
}

/* A bowl, as a face of a shell, without its middle, the square of 0.2 about the apex: no place that
 * is looked at lies in the hole, and the search ends at its edge, the nearest to the apex there is.
 */
static void test_optimise_keeps_to_what_is_left_of_a_face(void **state) {
    struct bytes shell = text_replace(
        studied_bowl, "\"surface\":{",
        "\"surface\":{\"faces\":[{\"trims\":[{\"degree\":1,\"knotvector\":[0,0,1,2,3,4,4],"
        "\"control_points\":[[0.4,0.4],[0.6,0.4],[0.6,0.6],[0.4,0.6],[0.4,0.4]]}],");
    struct bytes part = text_replace(shell.data, "},\"fabric\"", "}]},\"fabric\"");
    struct studied f =
        studied_make(part.data, "\"vary\":{\"start\":{\"grid\":9}},\"search\":\"optimise\","
                                "\"budget\":60,\"objectives\":[\"max_shear_deg\"]");
    size_t best = (size_t)f.columns.study.best[QUANTITY_MAX_SHEAR];
    double x = fabs(studied_value(&f, "x", best)), y = fabs(studied_value(&f, "y", best));
    (void)state;
    for (size_t row = 0; row < f.rows; row++)
        assert_true(studied_value(&f, "failure", row) == 0);
    check_at_most(fabs(fmax(x, y) - 0.2), 1e-9);
    check_at_most(fmin(x, y), 0.02);
    studied_free(&f);
    bytes_free(&part);
    bytes_free(&shell);
}

/* Half a sphere whose parameters end in its pole, from where the net is the most even: the search
 * ends there, and goes on where there is no tangent plane to look about in. */
#define W "0.70710678118654752"
static void test_optimise_ends_in_a_pole(void **state) {
    static const char half[] =
        "{\"surface\":{\"degree_u\":2,\"degree_v\":2,\"size_u\":9,\"size_v\":3,"
        "\"knotvector_u\":[0,0,0,1,1,2,2,3,3,4,4,4],\"knotvector_v\":[0,0,0,1,1,1],"
        "\"control_points\":{\"points\":[[1,0,0],[1,0,1],[0,0,1],[1,1,0],[1,1,1],[0,0,1],[0,1,0],"
        "[0,1,1],[0,0,1],[-1,1,0],[-1,1,1],[0,0,1],[-1,0,0],[-1,0,1],[0,0,1],[-1,-1,0],[-1,-1,1],"
        "[0,0,1],[0,-1,0],[0,-1,1],[0,0,1],[1,-1,0],[1,-1,1],[0,0,1],[1,0,0],[1,0,1],[0,0,1]],"
        "\"weights\":[1," W ",1," W ",0.5," W ",1," W ",1," W ",0.5," W ",1," W ",1," W ",0.5," W
        ",1," W ",1," W ",0.5," W ",1," W ",1]}},"
        "\"fabric\":{\"spacing\":0.12}}";
    struct studied f = studied_make(
        half, "\"vary\":{\"start\":{\"grid\":9},\"angle_deg\":{\"from\":0,\"to\":80,\"step\":10}},"
              "\"search\":\"optimise\",\"budget\":120,\"objectives\":[\"max_shear_deg\"]");
    size_t best = (size_t)f.columns.study.best[QUANTITY_MAX_SHEAR];
    (void)state;
    check_at_least(f.rows, 110);
    check_at_least(studied_value(&f, "z", best), 0.99);
    studied_free(&f);
}

/* Where the greatest shear of the free-form part is moves from one of its divisions to another as
 * the start does: 1,500 variants find 18.7 degrees. */
static void test_optimise_follows_the_greatest_shear_over_the_part(void **state) {
    struct bytes text = file_read("api/examples/freeform.json");
    struct bytes part = text_replace(text.data, "\"spacing\": 5", "\"spacing\": 10");
    struct studied f = studied_make(
        part.data,
        "\"vary\":{\"start\":{\"grid\":9},\"angle_deg\":{\"from\":0,\"to\":85,\"step\":5}},"
        "\"search\":\"optimise\",\"budget\":100,\"objectives\":[\"max_shear_deg\"]");
    (void)state;
    check_below(studied_best(&f, QUANTITY_MAX_SHEAR), 20);
    studied_free(&f);
    bytes_free(&part);
    bytes_free(&text);
}

/* z = x y over [0, 1]^2 is its own mirror image in x = y, a plane across a principal axis: the
 * search begins with the drape's own start and with the place of that plane next to it, along the
 * plane and at 45 degrees to it, and with the drape's own direction. */
static void test_optimise_begins_with_what_is_obvious(void **state) {
    struct bytes mesh = studied_mesh();
    struct bytes part = text_replace(
        mesh.data, "\"fabric\"",
        "\"start\":{\"point\":[0.3,0.2,0.06]},\"direction\":{\"angle_deg\":12},\"fabric\"");
    struct studied f = studied_make(
        part.data, "\"vary\":{\"start\":{\"grid\":9},\"angle_deg\":{\"from\":0,\"to\":85,"
                   "\"step\":5}},\"search\":\"optimise\",\"budget\":20,"
                   "\"objectives\":[\"max_shear_deg\"]");
    size_t own = 0, plane = 0;
    (void)state;
    for (size_t k = 0; k < f.rows; k++) {
        double x = studied_value(&f, "x", k), y = studied_value(&f, "y", k);
        double angle = studied_value(&f, "angle_deg", k);
        bool at = hypot(x - 0.3, y - 0.2) < 0.01;
        own += at && fabs(angle - 12) < 1e-9;
        /* the axis x is horizontal, the surface is not */
        plane += fabs(x - y) < 0.02 && fabs(x + y - 0.5) < 0.05 &&
                 (fabs(angle - 45) < 4 || fabs(angle) < 4 || fabs(angle - 90) < 4);
    }
    assert_int_equal(own, 1);
    assert_int_equal(plane, 2);
    studied_free(&f);
    bytes_free(&part);
    bytes_free(&mesh);
}

/* A bowl over a square has the same moments in all directions of its plane, so that its principal
 * axes tell nothing of its planes of symmetry, which are those of its coordinates: the search
 * begins next to the own start on either, along it and at 45 degrees. */
static void test_optimise_begins_on_planes_of_coordinates(void **state) {
    static const double starts[][2] = {{0, 0.2}, {0.3, 0}};
    struct bytes part = text_replace(studied_bowl, "\"fabric\"",
                                     "\"start\":{\"point\":[0.3,0.2,0.065]},\"fabric\"");
    struct studied f = studied_make(
        part.data, "\"vary\":{\"start\":{\"grid\":9},\"angle_deg\":{\"from\":0,\"to\":85,"
                   "\"step\":5}},\"search\":\"optimise\",\"budget\":20,"
                   "\"objectives\":[\"max_shear_deg\"]");
    (void)state;
    for (int p = 0; p < 2; p++) {
        size_t found = 0;
        for (size_t k = 0; k < f.rows; k++)
            found += hypot(studied_value(&f, "x", k) - starts[p][0],
                           studied_value(&f, "y", k) - starts[p][1]) < 0.01;
        assert_int_equal(found, 2);
    }
    studied_free(&f);
    bytes_free(&part);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_optimise_beats_a_grid),
        cmocka_unit_test(test_optimise_finds_the_apex_of_a_bowl),
        cmocka_unit_test(test_optimise_goes_over_the_faces_of_a_shell),
        cmocka_unit_test(test_optimise_ends_where_all_are_as_good),
        cmocka_unit_test(test_optimise_keeps_to_what_is_left_of_a_face),
        cmocka_unit_test(test_optimise_ends_in_a_pole),
        cmocka_unit_test(test_optimise_follows_the_greatest_shear_over_the_part),
        cmocka_unit_test(test_optimise_begins_with_what_is_obvious),
        cmocka_unit_test(test_optimise_begins_on_planes_of_coordinates),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
