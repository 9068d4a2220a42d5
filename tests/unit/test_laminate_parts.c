/* SPDX-License-Identifier: MIT */
/* What laminates are made of that needs no drape: the options of rolls, cloths and layers, figures
 * of courses, regions of the plane and the bands of seams. */
#include "api/laminate/band.h"
#include "api/laminate/courses.h"
#include "api/laminate/flat_piece.h"
#include "api/laminate/patterns.h"
#include "api/laminate/plane.h"
#include "api/laminate/region.h"
#include "cloth.h"
#include "support.h"
#include "tests/check.h"
#include <math.h>
#include <string.h>

#define COUNT(table) (sizeof(table) / sizeof *(table))

/* ---- rolls ---- */

/* Both sides of every limit. */
static void test_roll_options_are_what_they_say(void **state) {
    static const struct {
        const char *name, *value;
        bool good;
        struct laminate_roll roll;
    } rows[] = {
        {"width", "1.5", true, {.width = 1.5}},
        {"width", "1e12", true, {.width = 1e12}},
        {"width", "1.0000001e12", false, {.width = 0}},
        {"width", "0", false, {.width = 0}},
        {"width", "-1", false, {.width = 0}},
        {"width", "", false, {.width = 0}},
        {"width", "1m", false, {.width = 0}},
        {"gap", "1e-9", true, {.gap = 1e-9}},
        {"gap", "nan", false, {.width = 0}},
        {"tolerance", "0.01", true, {.tolerance = 0.01}},
        {"tolerance", "0", false, {.width = 0}},
        {"roll", "1", true, {.number = 1}},
        {"roll", "1000", true, {.number = 1000}},
        {"roll", "1001", false, {.width = 0}},
        {"roll", "0", false, {.width = 0}},
        {"roll", "1.5", false, {.width = 0}},
        {"roll", "x", false, {.width = 0}},
        {"turn", "0", true, {.straight = true}},
        {"turn", "180", true, {.straight = false}},
        {"turn", "90", false, {.width = 0}},
        {"partial", "1", true, {.partial = true}},
        {"partial", "0", true, {.partial = false}},
        {"partial", "2", false, {.width = 0}},
    };
    (void)state;
    for (size_t k = 0; k < COUNT(rows); k++) {
        struct laminate_roll roll = {.width = 0};
        const struct laminate_roll *wanted = &rows[k].roll;
        struct api_problem problem = {.id = API_OK};
        bool good = laminate_roll_option(&roll, rows[k].name, rows[k].value, &problem);
        if (good != rows[k].good || (problem.id == API_OK) != good || roll.width != wanted->width ||
            roll.gap != wanted->gap || roll.tolerance != wanted->tolerance ||
            roll.number != wanted->number || roll.straight != wanted->straight ||
            roll.partial != wanted->partial)
            fail_msg("%s=%s", rows[k].name, rows[k].value);
        if (!good)
            assert_non_null(strstr(problem.error[0].detail, rows[k].name));
    }
    struct laminate_roll roll = {.straight = true, .partial = true};
    struct api_problem problem = {.id = API_OK};
    assert_true(laminate_roll_option(&roll, "turn", "180", &problem) && !roll.straight);
    assert_true(laminate_roll_option(&roll, "partial", "0", &problem) && !roll.partial);
    assert_false(laminate_roll_option(&roll, "colour", "1", &problem));
    assert_int_equal(problem.id, API_OK);
}

/* Plies that differ in one thing are of different cloths; in their spacings, of the same. */
static void test_cloths_differ_in_what_is_bought(void **state) {
    struct laminate_ply plies[8];
    const struct laminate laminate = {.plies = plies, .count = COUNT(plies)};
    (void)state;
    for (size_t k = 0; k < COUNT(plies); k++)
        plies[k] = (struct laminate_ply){.areal_weight = 0.3,
                                         .price = 20,
                                         .drape.fabric = {.thickness = 1,
                                                          .fiber_volume_fraction = 0.5,
                                                          .material = "\"twill\""}};
    plies[1].drape.settings.spacing[0] = 7;
    assert_int_equal(laminate_cloths(&laminate), 1);
    plies[2].drape.fabric.thickness = 2;
    assert_int_equal(laminate_cloths(&laminate), 2);
    plies[3].drape.fabric.fiber_volume_fraction = 0.6;
    plies[4].areal_weight = 0.4;
    plies[5].price = 21;
    plies[6].drape.fabric.material = "\"satin\"";
    plies[7].drape.fabric.material = NULL;
    assert_int_equal(laminate_cloths(&laminate), 7);
    for (size_t k = 2; k < COUNT(plies); k++)
        plies[k] = plies[2];
    assert_int_equal(laminate_cloths(&laminate), 2);
}

/* ---- plies ---- */

static void test_plies_have_layers_titles_and_steps(void **state) {
    static const struct {
        double length, step;
        size_t steps;
    } rows[] = {{0, 1, 1},     {1, 1, 1},           {1.001, 1, 2},       {5, 0.5, 10},
                {1e5, 1, 1e5}, {1e5 - 0.5, 1, 1e5}, {1e5 - 1, 1, 99999}, {1e300, 1, 1e5}};
    static const struct vec3 path[] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 0, 0}, {2, 0, 0}};
    const struct laminate_piece own[] = {{.name = "left"}, {.name = "right"}};
    const struct laminate_pieces pieces = {.pieces = own, .count = 2};
    struct laminate_ply ply = {.name = "skin", .repeat = 3, .drape.fabric.plies = 4};
    char title[LAMINATE_TITLE_SIZE];
    (void)state;
    for (size_t k = 0; k < COUNT(rows); k++)
        assert_int_equal(laminate_steps(rows[k].length, rows[k].step), rows[k].steps);
    for (size_t count = 2; count <= COUNT(path); count++)
        assert_int_equal(laminate_split_closed(&(struct drape_cut_line){path, count}), count == 4);
    const struct vec3 there_and_back[] = {path[0], path[1], path[0]};
    assert_false(laminate_split_closed(&(struct drape_cut_line){there_and_back, 3}));
    assert_int_equal(laminate_layers(&ply), 12);
    laminate_title(&ply, title);
    assert_string_equal(title, "skin");
    ply.pieces = &pieces;
    ply.piece = 1;
    laminate_title(&ply, title);
    assert_string_equal(title, "skin, right");
    assert_true(laminate_is_split(&ply));
}

/* Under a rosette without z the angle of plies on the lower side turns the other way. */
static void test_plies_turn_about_their_own_side(void **state) {
    (void)state;
    for (int k = 0; k < 8; k++) {
        const bool rosette = k & 1, upright = k & 2, below = k & 4;
        struct laminate_ply ply = {.drape.settings = {.direction_deg = 30}};
        const struct laminate laminate = {.plies = &ply, .count = 1, .side = below ? -1 : 1};
        ply.drape.settings.zero.kind = rosette ? DRAPE_ZERO_ROSETTE : ply.drape.settings.zero.kind;
        ply.drape.settings.zero.z = vec3_make(0, 0, upright ? 1 : 0);
        double angle = laminate_drape(&laminate, 0).settings.direction_deg;
        assert_true(angle == (rosette && !upright && below ? -30 : 30));
    }
}

/* ---- courses ---- */

/* Areas are summed and shares at most 1, shears and deviations the greatest, the stagger the least;
 * what a course does not have counts for nothing. */
static void test_courses_sum_up(void **state) {
    struct laminate_piece own[3] = {{.name = "a"}, {.name = "b"}, {.name = "c"}};
    const struct laminate_pieces pieces = {.pieces = own, .count = COUNT(own)};
    double sums[COURSE_FIGURES];
    (void)state;
    for (int n = 0; n < 3; n++)
        for (int k = 0; k < COURSE_FIGURES; k++)
            own[n].figures[k] = 1 + k + (n == 1 ? 0.5 : 0.25 * n);
    for (int n = 0; n < 3; n++)
        own[n].figures[COURSE_COVERAGE] = 0.25;
    own[0].figures[COURSE_STAGGER] = own[0].figures[COURSE_WANTED_MOST] = NAN;
    courses_sum_up(&pieces, sums);
    for (int k = 0; k < COURSE_FIGURES; k++) {
        bool summed = k == COURSE_AREA || k == COURSE_NET_AREA || k == COURSE_TRIM_AREA ||
                      k == COURSE_GAP_AREA || k == COURSE_OVERLAP_AREA;
        bool greatest = k == COURSE_MAX_SHEAR || k == COURSE_WANTED_MOST;
        if (summed)
            assert_true(sums[k] == 3 * (1 + k) + 1);
        else if (greatest || k == COURSE_STAGGER)
            assert_true(sums[k] == 1 + k + 0.5);
        else if (k == COURSE_COVERAGE)
            assert_true(sums[k] == 0.75);
        else
            assert_true(isnan(sums[k]));
    }
    own[2].figures[COURSE_STAGGER] = -1;
    own[1].figures[COURSE_COVERAGE] = 0.75;
    courses_sum_up(&pieces, sums);
    assert_true(sums[COURSE_STAGGER] == -1 && sums[COURSE_COVERAGE] == 1);
}

/* ---- regions ---- */

static void add_corners(struct polygons *polygons, const double (*corners)[2], size_t count) {
    for (size_t k = 0; k < count; k++)
        assert_true(polygons_add(polygons, corners[k][0], corners[k][1]));
    polygons_close(polygons);
}

/* A star with a hole, in spacings that differ, agrees with its polygons wherever one looks; and the
 * box with its rim is as half-open boxes are. */
static void test_region_contains_what_its_polygons_enclose(void **state) {
    static const double spacing[2] = {0.5, 0.25}, box[4][2] = {{0, 0}, {2, 0}, {2, 1}, {0, 1}};
    static const struct {
        double pq[2];
        bool inside;
    } places[] = {{{0, 0}, true},  {{-1e-9, 0}, false}, {{4, 0}, false},   {{3.999, 0}, true},
                  {{0, 4}, false}, {{0, 3.999}, true},  {{2, 2}, true},    {{2, -1e-9}, false},
                  {{5, 2}, false}, {{-1, 2}, false},    {{2, 4.5}, false}, {{NAN, 2}, false}};
    struct random random = random_begin("region");
    struct arena *arena = arena_new((size_t)1 << 24);
    struct polygons star = {0}, square = {0}, line = {0};
    struct region region;
    (void)state;
    for (int loop = 0; loop < 2; loop++) {
        for (int k = 0; k < 400; k++) {
            double angle = 2 * M_PI * k / 400, r = (loop ? 0.3 : 1) + 0.2 * (k % 2);
            assert_true(polygons_add(&star, r * cos(angle), (loop ? -r : r) * sin(angle)));
        }
        polygons_close(&star);
    }
    assert_true(region_of_polygons(&star, spacing, arena, &region));
    assert_int_equal(region.loop_count, 2);
    assert_int_equal(region.first[1], 400);
    for (int k = 0; k < 20000; k++) {
        double x = random_between(&random, -1.3, 1.3), y = random_between(&random, -1.3, 1.3);
        const double pq[2] = {x / spacing[0], y / spacing[1]};
        assert_int_equal(region_contains(&region, pq), polygons_contain(&star, x, y));
    }
    add_corners(&square, box, 4);
    assert_true(region_of_polygons(&square, spacing, arena, &region));
    for (size_t k = 0; k < COUNT(places); k++)
        if (region_contains(&region, places[k].pq) != places[k].inside)
            fail_msg("(%g, %g)", places[k].pq[0], places[k].pq[1]);
    add_corners(&line, (const double[3][2]){{0, 1}, {2, 1}, {1, 1}}, 3); /* it encloses nothing */
    assert_true(region_of_polygons(&line, spacing, arena, &region));
    assert_false(region_contains(&region, (const double[2]){2, 4}));
    polygons_free(&star);
    polygons_free(&square);
    polygons_free(&line);
    arena_free(arena);
}

/* ---- bands ---- */

/* The area of all that shapes cover, each place once. */
static double covered_area(const struct polygons *shapes) {
    struct api_problem problem = {.id = API_OK};
    struct polygons none = {0}, all = {0};
    assert_int_equal(plane_combine(shapes, PLANE_EITHER, &none, &all, &problem), API_OK);
    double area = polygons_area(&all);
    polygons_free(&all);
    return area;
}

enum { SIDES = 4 };

/* The area, on the part, of the bands of a rhombus of cloth with these reaches. */
static double band_area(const double reach[SIDES], double sine, bool hole) {
    static const double corners[SIDES][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    struct polygons square = {0}, shapes = {0};
    struct band_edge edges[SIDES];
    double s = isnan(sine) ? 0 : fmax(fmin(sine, 0.97), -0.97);
    for (int k = 0; k < SIDES; k++) {
        const double *at = corners[hole ? SIDES - 1 - k : k];
        assert_true(polygons_add(&square, at[0], at[1]));
        edges[k] = (struct band_edge){reach[k], sine};
    }
    polygons_close(&square);
    assert_true(band_make(&square, edges, &shapes));
    double area = covered_area(&shapes) * sqrt(1 - s * s);
    polygons_free(&square);
    polygons_free(&shapes);
    return area;
}

/*
 * About a rhombus of side 1 with the angle t, the warp and weft of cloth whose shear has the sine
 * cos t: outside a band of the reach r has 4 r and the disc, inside 4 r - r^2 sum cot(t_i / 2). Of
 * one edge alone it is a stadium, of two opposite ones two. Discs are polygons whose chords take
 * off less than 7e-4.
 */
static void test_bands_have_their_area_on_the_part(void **state) {
    static const double sines[] = {0, 0.5, -0.5, 0.9, -0.97};
    const double r = 0.05, disc = M_PI * r * r, slack = 7e-4 * disc;
    const double all[] = {r, r, r, r}, one[] = {0, r, 0, 0}, last[] = {0, 0, 0, r};
    const double two[] = {r, 0, r, 0}, none[] = {0, 0, 0, 0}, bend[] = {0, r, r, 0};
    (void)state;
    for (size_t k = 0; k < COUNT(sines); k++)
        for (int hole = 0; hole < 2; hole++) {
            double s = sines[k], t = acos(s);
            double within = r * r * 2 * (1 / tan(t / 2) + tan(t / 2));
            /* of two edges that meet at a corner the bands overlap within it */
            double corner = hole ? M_PI - t : t;
            check_at_most(fabs(band_area(all, s, hole) - (8 * r + disc - within)), slack);
            check_at_most(fabs(band_area(one, s, hole) - (2 * r + disc)), slack);
            check_at_most(fabs(band_area(last, s, hole) - (2 * r + disc)), slack);
            check_at_most(fabs(band_area(two, s, hole) - 2 * (2 * r + disc)), 2 * slack);
            double half = (M_PI - corner) / 2; /* of what opens beyond the corner */
            check_at_most(
                fabs(band_area(bend, s, hole) - (4 * r + disc + half * r * r - r * r * tan(half))),
                2 * slack);
            assert_true(band_area(none, s, hole) == 0);
        }
    assert_true(band_area(all, NAN, false) == band_area(all, 0, false));
    assert_true(band_area(all, 0.99, false) == band_area(all, 0.97, false));
    assert_true(band_area(all, -0.99, false) == band_area(all, -0.97, false));
}

/* ---- pieces ---- */

static struct vec3 in_plane(double i, double j) {
    return vec3_make(i, j, 0);
}

/* A split at y = 2 over cloth of which it leaves one post and finds it again at the next: behind
 * the first one, before which it goes on to the rim, the piece lies on the same side as behind the
 * others, and has the lengths between them. */
static void test_piece_follows_its_split_from_rim_to_rim(void **state) {
    static const enum column_id kept[] = {COLUMN_CELLS_warp, COLUMN_CELLS_weft};
    static const double length[2][4] = {{1.8, 1.7, 1, 0}, {1, 0, 3.5, 0}};
    struct cloth cloth = cloth_make(4, 4, in_plane, NULL);
    struct bytes container = cloth_result(&cloth);
    struct api_reader reader = reader_over(&container);
    struct api_problem problem = {0};
    struct polygons rim = {0};
    static const double corners[4][2] = {{-0.5, -0.5}, {4, -0.5}, {4, 4}, {-0.5, 4}};
    (void)state;
    prepare();
    for (int k = 0; k < 4; k++)
        assert_true(polygons_add(&rim, corners[k][0], corners[k][1]));
    polygons_close(&rim);
    for (int back = 0; back < 2; back++) {
        struct split_post list[] = {
            {{1.3, 2, 0}, 8}, {{2, 9, 0}, 8}, {{3, 2, 0}, 0.5}, {{3.5, 2, 0}, 0}};
        struct split_post turned[] = {
            {{3.5, 2, 0}, 0.5}, {{3, 2, 0}, 8}, {{2, 9, 0}, 8}, {{1.3, 2, 0}, 0}};
        const struct split_posts posts = {back ? turned : list, 4};
        struct arena *arena = arena_new((size_t)1 << 24);
        struct map_net *net = arena_alloc(arena, 1, sizeof *net);
        struct flat_piece piece = {0};
        assert_int_equal(map_net_open(&reader, net, &problem), API_OK);
        map_net_keep(net, kept, COUNT(kept));
        assert_int_equal(map_net_load(&reader, NULL, arena, net, &problem), API_OK);
        if (flat_piece_make(net, &rim, &posts, arena, &piece, &problem) != API_OK)
            fail_msg("%s", problem.error[0].detail);
        for (int k = 0; k < 4; k++) {
            const struct split_side *side = &piece.sides[k];
            assert_int_equal(side->there, length[back][k] > 0);
            check_at_most(fabs(side->length - length[back][k]), 1e-9);
            if (!side->there)
                continue;
            assert_int_equal(side->forward, back);
            check_at_most(fabs(fabs(side->warp_deg) - 180), 1e-9);
        }
        flat_piece_free(&piece);
        arena_free(arena);
    }
    polygons_free(&rim);
    bytes_free(&container);
    cloth_free(&cloth);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_roll_options_are_what_they_say),
        cmocka_unit_test(test_cloths_differ_in_what_is_bought),
        cmocka_unit_test(test_plies_have_layers_titles_and_steps),
        cmocka_unit_test(test_plies_turn_about_their_own_side),
        cmocka_unit_test(test_courses_sum_up),
        cmocka_unit_test(test_region_contains_what_its_polygons_enclose),
        cmocka_unit_test(test_bands_have_their_area_on_the_part),
        cmocka_unit_test(test_piece_follows_its_split_from_rim_to_rim),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
