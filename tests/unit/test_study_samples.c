/* SPDX-License-Identifier: MIT */
#include "studied.h"

#include "api/map/map.h"
#include "tests/check.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

#define TOLERANCES                                                                                 \
    "\"vary\":{\"start\":{\"radius\":0.2},\"angle_deg\":{\"normal\":3}},\"sample\":%d,\"seed\":%d"

static struct studied draw_samples(const char *drape, int count, int seed) {
    char rest[200];
    snprintf(rest, sizeof rest, TOLERANCES, count, seed);
    return studied_make(drape, rest);
}

static double band_at(struct studied *f, const char *name, size_t row) {
    struct api_reader reader = reader_over(&f->container);
    const struct api_column *column = api_columns_find(&f->columns, API_TABLE_BANDS, name);
    double value;
    if (!column)
        fail_msg("no column %s", name);
    assert_true(api_columns_read(&reader, column, row, 1, &value));
    return value;
}

static const char plate[] =
    "{\"surface\":{\"degree_u\":1,\"degree_v\":1,\"knotvector_u\":[0,0,1,1],"
    "\"knotvector_v\":[0,0,1,1],\"size_u\":2,\"size_v\":2,"
    "\"control_points\":[[-1,-1,0],[-1,1,0],[1,-1,0],[1,1,0]]},\"fabric\":{\"spacing\":0.5},"
    "\"direction\":{\"angle_deg\":40}}";

/* Starts within the radius, evenly: half of them within r / sqrt 2; angles normal, 68.3 % of them
 * within one deviation. */
static void test_samples_are_drawn_as_asked(void **state) {
    enum { COUNT = 800 };
    struct studied f = draw_samples(plate, COUNT, 5);
    int near = 0, within = 0, right = 0;
    double sum = 0;
    (void)state;
    assert_int_equal(f.rows, COUNT);
    for (size_t k = 0; k < f.rows; k++) {
        double x = studied_value(&f, "x", k), y = studied_value(&f, "y", k);
        double turn = studied_value(&f, "angle_deg", k) - 40;
        check_at_most(hypot(x, y), 0.2 + 1e-12);
        near += hypot(x, y) < 0.2 / sqrt(2);
        right += x > 0;
        within += fabs(turn) < 3;
        sum += turn;
    }
    check_at_most(fabs(near / (double)COUNT - 0.5), 0.06);
    check_at_most(fabs(right / (double)COUNT - 0.5), 0.06);
    check_at_most(fabs(within / (double)COUNT - 0.683), 0.06);
    check_at_most(fabs(sum / COUNT), 3 * 3 / sqrt(COUNT));
    for (size_t cell = 0; cell < api_columns_rows(&f.columns, API_TABLE_BANDS); cell++) {
        check_at_most(fabs(band_at(&f, "shear_deg_p95", cell)), 1e-9);
        check_at_most(band_at(&f, "warp_x_p05", cell), band_at(&f, "warp_x_mean", cell));
        check_at_most(fabs(band_at(&f, "warp_x_mean", cell) - cos(40 * acos(-1) / 180)), 0.01);
    }
    studied_free(&f);
}

/* Of a disc that reaches beyond the part all starts lie on it, and a warning tells. */
static void test_a_disc_larger_than_the_part_is_told(void **state) {
    static const char *const studies[] = {
        "\"vary\":{\"start\":{\"radius\":1.1}},\"sample\":20",
        "\"vary\":{\"start\":{\"radius\":1.2}},\"sample\":20",
    };
    (void)state;
    for (int c = 0; c < 2; c++) {
        struct studied f = studied_make(plate, studies[c]);
        const struct api_warnings *warnings = &f.columns.study.warnings;
        bool told = false;
        for (size_t k = 0; k < (size_t)warnings->count; k++)
            told = told || strcmp(warnings->list[k].code, "disc") == 0;
        assert_int_equal(told, c == 1);
        for (size_t k = 0; k < f.rows; k++)
            check_at_most(fmax(fabs(studied_value(&f, "x", k)), fabs(studied_value(&f, "y", k))),
                          1);
        studied_free(&f);
    }
}

/* Of a plate the turn of the warp is that of its sample, a normal deviate of 3 degrees: what share
 * of its distribution lies within the band of some samples is exact. */
static double share_within(int count, int seed) {
    struct studied f = draw_samples(plate, count, seed);
    double share = 0;
    for (int side = 0; side < 2; side++) {
        double sine = band_at(&f, side ? "warp_y_p95" : "warp_y_p05", 0);
        double turn = asin(sine) * 180 / acos(-1) - 40;
        share += (side ? 0.5 : -0.5) * erf(turn / (3 * sqrt(2)));
    }
    studied_free(&f);
    return share;
}

/* Number k of n in rising order has a share below it that is of the beta distribution B(k, n + 1 -
 * k), whatever the field's own. So where 0.05 (n + 1) is whole the share within is of B(0.9 (n +
 * 1), 0.1 (n + 1)): nine tenths on the mean, and sqrt(0.9 0.1 / (n + 2)) about it. */
static void test_bands_hold_nine_tenths_and_scatter_as_order_statistics(void **state) {
    static const int counts[] = {39, 239};
    const int seeds = check_sized(80, 50);
    (void)state;
    for (int c = 0; c < 2; c++) {
        double sum = 0, squares = 0, scatter = sqrt(0.09 / (counts[c] + 2));
        for (int seed = 1; seed <= seeds; seed++) {
            double off = share_within(counts[c], seed) - 0.9;
            sum += off;
            squares += off * off;
        }
        printf("  of %d samples: %.4f, scatter %.4f of %.4f\n", counts[c], 0.9 + sum / seeds,
               sqrt(squares / seeds), scatter);
        check_at_most(fabs(sum / seeds), 3 * scatter / sqrt(seeds));
        check_at_most(fabs(sqrt(squares / seeds) / scatter - 1), 0.3);
    }
}

/* Bands of some samples hold nine in ten of others, over all cells. */
static void test_bands_hold_nine_tenths_of_fresh_samples(void **state) {
    enum { COUNT = 250 };
    const int others = check_sized(100, 40);
    struct bytes part = studied_saddle();
    struct studied bands = draw_samples(part.data, COUNT, 1);
    struct studied fresh = draw_samples(part.data, others, 2);
    size_t cells = api_columns_rows(&bands.columns, API_TABLE_BANDS), inside = 0, all = 0;
    (void)state;
    check_above(cells, 100);
    for (size_t k = 0; k < (size_t)others; k++) {
        struct bytes request = studied_request(&fresh, k), container = {0};
        struct api_problem problem = {0};
        struct arena *arena = arena_new((size_t)1 << 30);
        struct vec3 *points = arena_alloc(arena, cells, sizeof *points);
        struct api_map *map = arena_alloc(arena, 1, sizeof *map);
        for (size_t c = 0; c < cells; c++)
            points[c] = vec3_make(band_at(&bands, "x", c), band_at(&bands, "y", c),
                                  band_at(&bands, "z", c));
        const struct map_target target = {
            .vertices = points, .vertex_count = cells, .element_count = cells};
        assert_int_equal(run_text(request.data, &container, &problem), API_OK);
        struct api_reader reader = reader_over(&container);
        assert_int_equal(api_map_make(&reader, &target, NULL, arena, map, &problem), API_OK);
        for (size_t m = 0; m < map->fields.column_count; m++) {
            double value;
            if (strcmp(map->columns[m].name, "shear_deg") != 0)
                continue;
            for (size_t c = 0; c < cells; c++, all++) {
                map->columns[m].fill(map->columns[m].context, c, 1, &value);
                inside += value >= band_at(&bands, "shear_deg_p05", c) &&
                          value <= band_at(&bands, "shear_deg_p95", c);
            }
        }
        bytes_free(&request);
        bytes_free(&container);
        arena_free(arena);
    }
    printf("  bands hold %.2f %% of fresh samples\n", 100 * (double)inside / (double)all);
    check_at_most(fabs((double)inside / (double)all - 0.9), 0.02);
    studied_free(&bands);
    studied_free(&fresh);
    bytes_free(&part);
}

/* Of two samples the bands end at the one and the other. In a rigid cavity each has the fibre
 * fraction of its own shear, Vf = Vf0 t / (h cos gamma), here 0.5 0.01 / 0.012, not a mean of the
 * cells about: as a map of its drape has. */
static void test_bands_follow_the_shear_of_each_sample(void **state) {
    struct bytes part = studied_saddle();
    struct studied f = draw_samples(part.data, 2, 5);
    const double radian = acos(-1) / 180, fraction = 0.5 * 0.01 / 0.012;
    (void)state;
    size_t cells = api_columns_rows(&f.columns, API_TABLE_BANDS);
    check_at_least((double)cells, 100);
    for (size_t c = 0; c < cells; c++) {
        double low = cos(band_at(&f, "shear_deg_p05", c) * radian);
        double high = cos(band_at(&f, "shear_deg_p95", c) * radian);
        double least = fraction / fmax(low, high);
        double most = fraction / fmin(low, high);
        check_at_most(fabs(band_at(&f, "fiber_volume_fraction_p05", c) - least), 1e-14);
        check_at_most(fabs(band_at(&f, "fiber_volume_fraction_p95", c) - most), 1e-14);
    }
    studied_free(&f);
    bytes_free(&part);
}

static void test_samples_have_the_same_bits_from_any_tasks(void **state) {
    struct bytes part = studied_saddle();
    char rest[200];
    (void)state;
    snprintf(rest, sizeof rest, TOLERANCES, 40, 3);
    studied_check_threads(part.data, rest);
    bytes_free(&part);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_samples_are_drawn_as_asked),
        cmocka_unit_test(test_a_disc_larger_than_the_part_is_told),
        cmocka_unit_test(test_bands_hold_nine_tenths_and_scatter_as_order_statistics),
        cmocka_unit_test(test_bands_hold_nine_tenths_of_fresh_samples),
        cmocka_unit_test(test_bands_follow_the_shear_of_each_sample),
        cmocka_unit_test(test_samples_have_the_same_bits_from_any_tasks),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
