/* SPDX-License-Identifier: MIT */
/* The rim along rows of the net, against a diamond with a hole in a plane, and its picture. */
#include "api/format/part_picture.h"
#include "api/result/stored_rim.h"

#include "support.h"
#include "tests/check.h"
#include <math.h>
#include <stdlib.h>

/* |x| + |y| <= 0.9 of the plane [-1, 1]^2 less |x - 0.3| + |y| < 0.2, from the middle. */
static const char diamond[] =
    "{\"surface\":{\"degree_u\":1,\"degree_v\":1,\"size_u\":2,\"size_v\":2,"
    "\"knotvector_u\":[0,0,1,1],\"knotvector_v\":[0,0,1,1],"
    "\"control_points\":[[-1,-1,0],[-1,1,0],[1,-1,0],[1,1,0]],\"trims\":["
    "{\"points\":[[0.95,0.5],[0.5,0.95],[0.05,0.5],[0.5,0.05],[0.95,0.5]],\"reversed\":true},"
    "{\"points\":[[0.75,0.5],[0.65,0.6],[0.55,0.5],[0.65,0.4],[0.75,0.5]],\"reversed\":false}]},"
    "\"start\":{\"uv\":[0.5,0.5]},\"fabric\":{\"spacing\":%g}}";

static const double outer = 0.9, hole = 0.2, hole_at = 0.3;

static void drape_diamond(double spacing, struct bytes *container, struct api_columns *columns) {
    struct api_problem problem = {0};
    struct bytes request = {0};
    bytes_format(&request, diamond, spacing);
    if (run_text(request.data, container, &problem) != API_OK)
        fail_msg("%s", problem.error[0].detail);
    bytes_free(&request);
    const struct api_reader reader = reader_over(container);
    assert_int_equal(api_columns_open(&reader, columns, &problem), API_OK);
}

/* The ends of what is left of the line y, ascending, 0 or 2 or 4. */
static size_t exact_ends(double y, double ends[4]) {
    double half = outer - fabs(y), gap = hole - fabs(y);
    size_t count = 0;
    if (half <= 0)
        return 0;
    ends[count++] = -half;
    if (gap > 0) {
        ends[count++] = hole_at - gap;
        ends[count++] = hole_at + gap;
    }
    ends[count++] = half;
    return count;
}

static void check_row(const struct stored_rim *edge, double spacing, double y) {
    struct stretch_end stretches[STORED_RIM_STRETCHES][2];
    double exact[4];
    size_t expected = exact_ends(y, exact), found = 0;
    for (int i = -8; i < 8; i++) { /* cell by cell */
        size_t count = stored_rim_stretches(edge, y / spacing, i, i + 1, stretches);
        for (size_t k = 0; k < 2 * count; k++) {
            const struct stretch_end *end = &stretches[k / 2][k % 2];
            if (!end->known) {
                assert_true(end->p == i + (int)(k % 2));
                continue;
            }
            assert_true(found < expected);
            check_below(fabs(end->p * spacing - exact[found]), 1e-3 * spacing);
            check_below(fabs(end->point.x - exact[found++]), 1e-3 * spacing);
            check_below(fabs(end->point.y - y), 1e-3 * spacing);
        }
    }
    assert_int_equal(found, expected);
    size_t whole = stored_rim_stretches(edge, y / spacing, -8, 8, stretches);
    assert_int_equal(whole, expected / 2);
}

/* The diamond's edge, draped with a spacing. */
struct draped {
    struct bytes container;
    struct api_columns columns;
    struct arena *arena;
    struct stored_rim *edge;
};

static struct draped *drape_edge(double spacing) {
    struct draped *draped = calloc(1, sizeof *draped);
    struct api_problem problem = {0};
    drape_diamond(spacing, &draped->container, &draped->columns);
    const struct api_reader reader = reader_over(&draped->container);
    draped->arena = arena_new((size_t)1 << 24);
    assert_int_equal(
        stored_rim_make(&reader, &draped->columns, draped->arena, &draped->edge, &problem), API_OK);
    return draped;
}

static void draped_free(struct draped *draped) {
    arena_free(draped->arena);
    bytes_free(&draped->container);
    free(draped);
}

static void test_stored_rim_stretches_of_a_diamond_with_a_hole(void **state) {
    static const double spacing = 0.25;
    struct draped *draped = drape_edge(spacing);
    (void)state;
    for (double y = -0.993; y < 1; y += 0.0137)
        check_row(draped->edge, spacing, y);
    draped_free(draped);
}

static bool is_within(double x, double y) {
    return fabs(x) + fabs(y) < outer && fabs(x - hole_at) + fabs(y) > hole;
}

/* Cells all of whose corners are within: one that is clear has the rim nowhere near it, one that is
 * not has it in it or close by. */
static void test_stored_rim_find_clear_leaves_the_cells_at_the_rim(void **state) {
    static const double spacing = 0.03;
    struct draped *draped = drape_edge(spacing);
    int32_t cells[5000][2];
    bool clear[5000];
    size_t count = 0, clear_count = 0;
    (void)state;
    for (int j = -32; j < 32; j++)
        for (int i = -32; i < 32; i++) {
            int inner = 0;
            for (int k = 0; k < 4; k++)
                inner += is_within((i + k % 2) * spacing, (j + k / 2) * spacing);
            cells[count][0] = i;
            cells[count][1] = j;
            count += inner == 4;
        }
    stored_rim_find_clear(draped->edge, (const int32_t(*)[2])cells, count, clear);
    for (size_t k = 0; k < count; k++) {
        double middle[2] = {cells[k][0] + 0.5, cells[k][1] + 0.5};
        clear_count += clear[k];
        for (int at = 0; at < 25 && clear[k]; at++) {
            double p = cells[k][0] + at % 5 / 4.0, q = cells[k][1] + at / 5 / 4.0;
            assert_false(stored_rim_is_beyond(draped->edge, p, q, 0));
        }
        double to_outer = outer / spacing - fabs(middle[0]) - fabs(middle[1]);
        double to_hole = fabs(middle[0] - hole_at / spacing) + fabs(middle[1]) - hole / spacing;
        if (clear[k])
            check_at_least(fmin(to_outer, to_hole), 1.05); /* the cell has 1, the slack 0.06 */
        else
            check_below(fmin(to_outer, to_hole), 4);
    }
    check_at_least((double)clear_count, 0.7 * (double)count);
    draped_free(draped);
}

/* A picture has the diamond's area to the width of its lines, though whole cells have little of it;
 * no pixel further out than a line is wide. */
static void test_portrait_shows_the_cloth_up_to_the_rim(void **state) {
    struct bytes container = {0};
    struct api_columns *columns = malloc(sizeof *columns);
    struct api_problem problem = {0};
    struct part_picture picture = {0};
    size_t drawn = 0;
    (void)state;
    drape_diamond(0.29, &container, columns);
    const struct api_reader reader = reader_over(&container);
    assert_int_equal(part_picture_draw(&picture, &reader, columns, &problem), API_OK);
    const struct raster *raster = &picture.raster;
    for (size_t k = 0; k < (size_t)raster->width * (size_t)raster->height; k++)
        drawn += raster->pixels[k] != 0;
    double area = 2 * (outer * outer - hole * hole);
    double pixels = area * picture.scale * picture.scale / sqrt(1 + 0.35 * 0.35 + 0.7 * 0.7);
    check_below(columns->summary.coverage, 0.6);
    check_below(fabs((double)drawn / pixels - 1), 0.01);
    raster_free(&picture.raster);
    free(columns);
    bytes_free(&container);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_stored_rim_stretches_of_a_diamond_with_a_hole),
        cmocka_unit_test(test_stored_rim_find_clear_leaves_the_cells_at_the_rim),
        cmocka_unit_test(test_portrait_shows_the_cloth_up_to_the_rim),
    };
    prepare();
    return cmocka_run_group_tests_name("stored_rim", tests, NULL, NULL);
}
