/* SPDX-License-Identifier: MIT */
/* The regions into which splits divide a square of side 1: their areas, where they are, and what is
 * wrong with a split. */
#include "api/laminate/division.h"
#include "sample.h"
#include "support.h"
#include "tests/check.h"
#include <math.h>

enum { POINTS = 5, SPLITS = 3 };

/* A line of up to POINTS places of the square, which ends before the first with x < -8. */
struct line {
    double at[POINTS][2];
};

#define END                                                                                        \
    { -9, 0 }

static struct arena *arena;
static struct drape_part part;
static const struct mesh *mesh;
static double size;

static int make_square(void **state) {
    struct sample sample = sample_grid(1, 1, NULL);
    struct api_problem problem = {.id = API_OK};
    (void)state;
    arena = arena_new((size_t)1 << 30);
    part = (struct drape_part){.mesh = sample_mesh(&sample, arena)};
    sample_free(&sample);
    assert_int_equal(division_mesh(&part, 0, arena, &mesh, &size, &problem), API_OK);
    return 0;
}

static int free_square(void **state) {
    (void)state;
    arena_free(arena);
    return 0;
}

/* Divides it along lines, of which those without a point are none. */
static enum division_fault divide(const struct line lines[SPLITS], struct division *division) {
    struct vec3 path[SPLITS][POINTS];
    struct drape_cut_line splits[SPLITS];
    struct laminate_pieces pieces = {.splits = splits};
    enum division_fault fault;
    for (int k = 0; k < SPLITS && lines[k].at[0][0] > -8; k++) {
        struct drape_cut_line *own = &splits[pieces.split_count++];
        *own = (struct drape_cut_line){path[k], 0};
        for (int n = 0; n < POINTS && lines[k].at[n][0] > -8; n++)
            path[k][own->count++] = vec3_make(lines[k].at[n][0], lines[k].at[n][1], 0);
    }
    assert_true(division_make(&part, mesh, size, 0.1, &pieces, arena, division, &fault));
    return fault;
}

/* Two triangles are cut into four until no edge is longer than twice those of 20,000 of equal
 * sides. */
static void test_division_looks_through_small_triangles(void **state) {
    const double of_equal_sides = sqrt(1 / (20000 * sqrt(3) / 4));
    double longest = 0, area = 0;
    (void)state;
    for (size_t h = 0; h < 3 * mesh->triangle_count; h++)
        longest = fmax(longest, vec3_norm(mesh_edge_vector(mesh, (int32_t)h)));
    for (size_t t = 0; t < mesh->triangle_count; t++)
        area += mesh_twice_area(mesh, (int32_t)t) / 2;
    check_at_most(longest, 2 * of_equal_sides);
    check_above(longest, of_equal_sides);
    check_at_most(fabs(longest - sqrt(2) / 128), 1e-12);
    check_at_most(fabs(size - longest), 1e-12);
    assert_int_equal(mesh->triangle_count, 2 << 14);
    check_at_most(fabs(area - 1), 1e-12);
}

/* Lines from edge to edge, one that ends a triangle short of both, one that bends, two that cross,
 * one that ends at another, and a loop. */
static void test_division_has_the_areas_of_its_regions(void **state) {
    static const struct {
        struct line lines[SPLITS];
        size_t count;
        struct {
            double at[2], area, middle[2], depth;
        } regions[4];
    } rows[] = {
        {{{{{0.3, 0}, {0.3, 1}, END}}, {{END}}},
         2,
         {{{0.1, 0.5}, 0.3, {0.15, 0.5}, 0.3}, {{0.31, 0.9}, 0.7, {0.65, 0.5}, 0.7}}},
        {{{{{0.01, 0.25}, {0.99, 0.25}, END}}, {{END}}},
         2,
         {{{0.1, 0.2}, 0.25, {0.5, 0.125}, 0.25}, {{0.5, 0.26}, 0.75, {0.5, 0.625}, 0.75}}},
        {{{{{0, 0.5}, {0.5, 0.5}, {0.5, 0}, END}}, {{END}}},
         2,
         {{{0.2, 0.2}, 0.25, {0.25, 0.25}, 0.5}, {{0.6, 0.4}, 0.75, {7 / 12.0, 7 / 12.0}, 0.7071}}},
        {{{{{0.5, 0}, {0.5, 1}, END}}, {{{0, 0.5}, {1, 0.5}, END}}, {{END}}},
         4,
         {{{0.2, 0.2}, 0.25, {0.25, 0.25}, 0.5},
          {{0.8, 0.2}, 0.25, {0.75, 0.25}, 0.5},
          {{0.8, 0.8}, 0.25, {0.75, 0.75}, 0.5},
          {{0.2, 0.8}, 0.25, {0.25, 0.75}, 0.5}}},
        {{{{{0.5, 0}, {0.5, 1}, END}}, {{{0, 0.5}, {0.5, 0.5}, END}}, {{END}}},
         3,
         {{{0.2, 0.2}, 0.25, {0.25, 0.25}, 0.5},
          {{0.2, 0.8}, 0.25, {0.25, 0.75}, 0.5},
          {{0.8, 0.8}, 0.5, {0.75, 0.5}, 0.5}}},
        {{{{{0.25, 0.25}, {0.75, 0.25}, {0.75, 0.75}, {0.25, 0.75}, {0.25, 0.25}}}, {{END}}},
         2,
         {{{0.5, 0.5}, 0.25, {0.5, 0.5}, 0.25}, {{0.1, 0.1}, 0.75, {NAN, NAN}, 0.3536}}},
    };
    (void)state;
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        struct division division;
        assert_int_equal(divide(rows[k].lines, &division), DIVISION_SOUND);
        assert_int_equal(division.count, rows[k].count);
        for (size_t n = 0; n < rows[k].count; n++) {
            const double *at = rows[k].regions[n].at, *middle = rows[k].regions[n].middle;
            int32_t number = division_region_at(&division, vec3_make(at[0], at[1], 0));
            assert_in_range(number, 0, rows[k].count - 1);
            const struct division_region *own = &division.regions[number];
            /* a triangle is on the side where its middle is */
            check_at_most(fabs(own->area - rows[k].regions[n].area), 1.5 * size);
            check_at_most(fabs(own->depth - rows[k].regions[n].depth), size);
            if (isnan(middle[0]))
                continue;
            check_at_most(fabs(own->middle.x - middle[0]), size);
            check_at_most(fabs(own->middle.y - middle[1]), size);
        }
    }
}

/* The first split that is wrong, and where. */
static void test_division_says_which_split_is_wrong(void **state) {
    static const struct {
        struct line lines[SPLITS];
        enum division_fault fault;
        size_t split;
    } rows[] = {
        {{{{{0.3, -0.2}, {0.3, 1}, END}}, {{END}}}, DIVISION_OFF_PART, 0},
        {{{{{0.3, 0}, {0.3, 1}, END}}, {{{0.6, 0}, {1.6, 0}, END}}, {{END}}}, DIVISION_OFF_PART, 1},
        {{{{{0.3, 0}, {0.3, 0.5}, END}}, {{END}}}, DIVISION_DIVIDES_NOTHING, 0},
        {{{{{0.3, 0}, {0.3, 1}, END}}, {{{0.6, 0.2}, {0.6, 0.8}, END}}, {{END}}},
         DIVISION_DIVIDES_NOTHING,
         1},
        {{{{{0.3, 0}, {0.3, 1}, END}}, {{{0.301, 0}, {0.301, 1}, END}}, {{END}}},
         DIVISION_REPEATED,
         1},
        {{{{{0.3, 0}, {0.3, 1}, END}}, {{{0.5, 0}, {0.5, 1}, END}}, {{{0.3, 0}, {0.3, 1}, END}}},
         DIVISION_REPEATED,
         2},
    };
    (void)state;
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        struct division division;
        assert_int_equal(divide(rows[k].lines, &division), rows[k].fault);
        assert_int_equal(division.fault, rows[k].split);
        if (rows[k].fault == DIVISION_OFF_PART)
            assert_true(division.at.x > 1.1 || division.at.y < -0.1);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_division_looks_through_small_triangles),
        cmocka_unit_test(test_division_has_the_areas_of_its_regions),
        cmocka_unit_test(test_division_says_which_split_is_wrong),
    };
    return cmocka_run_group_tests(tests, make_square, free_square);
}
