/* SPDX-License-Identifier: MIT */
/* Maps up to the rim of the cloth: elements in the cells that it cuts have fields of second order,
 * and what lies beyond it is told. */
#include "api/map/map.h"

#include "support.h"
#include "tests/check.h"
#include <math.h>
#include <string.h>

enum { POINTS = 400 };

static const double pi = 3.14159265358979323846;

/* A result mapped onto points near the rim. */
struct mapped {
    struct bytes container;
    struct arena *arena;
    struct api_map map;
    struct vec3 points[POINTS];
};

static void map_points(const char *request, struct mapped *mapped) {
    struct api_problem problem = {0};
    prepare();
    if (run_text(request, &mapped->container, &problem) != API_OK)
        fail_msg("%s", problem.error[0].detail);
    const struct api_reader reader = reader_over(&mapped->container);
    const struct map_target target = {
        .vertices = mapped->points, .vertex_count = POINTS, .element_count = POINTS};
    mapped->arena = arena_new((size_t)1 << 28);
    if (api_map_make(&reader, &target, NULL, mapped->arena, &mapped->map, &problem) != API_OK)
        fail_msg("%s", problem.error[0].detail);
}

static void forget(struct mapped *mapped) {
    bytes_free(&mapped->container);
    arena_free(mapped->arena);
}

static double value_at(const struct mapped *mapped, const char *name, size_t row) {
    const struct map_fields *fields = &mapped->map.fields;
    double value = 0;
    for (size_t k = 0; k < fields->column_count; k++)
        if (strcmp(fields->columns[k].name, name) == 0)
            fields->columns[k].fill(fields->columns[k].context, row, 1, &value);
    return value;
}

static int count_extrapolated(const struct mapped *mapped) {
    int count = 0;
    for (size_t k = 0; k < POINTS; k++)
        count += value_at(mapped, "extrapolated", k) != 0;
    return count;
}

/* A place of [-2, 2]^2, from `near` to `far` inside of its border. */
static void beside_border(struct random *random, double near, double far, double at[2]) {
    int k = random_index(random, 2);
    at[k] = random_between(random, -2, 2);
    at[1 - k] = (random_index(random, 2) ? 1 : -1) * (2 - random_between(random, near, far));
}

/* The largest error of the shear on the saddle, of which sin gamma is known; none is extrapolated.
 */
static double saddle_error(double spacing, struct random *random) {
    static struct mapped mapped;
    struct bytes request = {0};
    double worst = 0;
    for (size_t k = 0; k < POINTS; k++) {
        double at[2];
        beside_border(random, 0, 0.1, at);
        mapped.points[k] = vec3_make(at[0], at[1], (at[0] * at[0] - at[1] * at[1]) / 2);
    }
    bytes_format(&request,
                 "{\"surface\":%s,\"fabric\":{\"spacing\":%g},\"start\":{\"uv\":[0.5,0.5]}}",
                 request_text("saddle_surface"), spacing);
    mapped.container = (struct bytes){0};
    map_points(request.data, &mapped);
    for (size_t k = 0; k < POINTS; k++) {
        double x = mapped.points[k].x, y = mapped.points[k].y;
        double exact = -asin(x * y / sqrt((1 + x * x) * (1 + y * y))) * 180 / pi;
        worst = fmax(worst, fabs(value_at(&mapped, "shear_deg", k) - exact));
        check_at_most(value_at(&mapped, "distance", k), spacing * spacing / 8);
    }
    assert_int_equal(count_extrapolated(&mapped), 0);
    forget(&mapped);
    bytes_free(&request);
    return worst;
}

static void test_map_rim_has_fields_of_second_order(void **state) {
    (void)state;
    struct random random = random_begin("saddle");
    double coarse = saddle_error(0.2, &random), fine = saddle_error(0.05, &random);
    check_at_most(coarse, 0.7);
    check_at_most(fine, coarse / 9);
}

/* Flat cloth, obliquely cut: no shear, and what lies beyond the border is told. */
static void test_map_rim_tells_what_lies_beyond(void **state) {
    static struct mapped mapped;
    (void)state;
    struct random random = random_begin("plane");
    for (size_t k = 0; k < POINTS; k++) {
        double at[2];
        beside_border(&random, k % 2 ? 0 : -0.3, k % 2 ? 0.1 : -0.01, at);
        mapped.points[k] = vec3_make(at[0], at[1], 0);
    }
    mapped.container = (struct bytes){0};
    map_points("{\"surface\":{\"degree_u\":1,\"degree_v\":1,\"size_u\":2,\"size_v\":2,"
               "\"knotvector_u\":[0,0,1,1],\"knotvector_v\":[0,0,1,1],\"control_points\":"
               "[[-2,-2,0],[-2,2,0],[2,-2,0],[2,2,0]]},\"fabric\":{\"spacing\":0.2},"
               "\"direction\":{\"angle_deg\":31}}",
               &mapped);
    for (size_t k = 0; k < POINTS; k++) {
        assert_true((value_at(&mapped, "extrapolated", k) != 0) == (k % 2 == 0));
        check_at_most(fabs(value_at(&mapped, "shear_deg", k)), 1e-9);
    }
    forget(&mapped);
}

/* The border of a hemisphere, and shear there by symmetry: (x, y) and (y, x) have the same. */
static void test_map_rim_of_a_hemisphere(void **state) {
    static struct mapped mapped;
    (void)state;
    struct random random = random_begin("hemisphere");
    struct bytes request = file_read("api/examples/hemisphere.json");
    for (size_t k = 0; k < POINTS; k += 2) {
        double z = random_between(&random, 0, 4), turn = random_between(&random, 0, 2 * pi);
        double r = sqrt(1e4 - z * z);
        mapped.points[k] = vec3_make(r * cos(turn), r * sin(turn), z);
        mapped.points[k + 1] = vec3_make(r * sin(turn), r * cos(turn), z);
    }
    mapped.container = (struct bytes){0};
    bytes_add(&request, "", 1);
    map_points(request.data, &mapped);
    assert_int_equal(count_extrapolated(&mapped), 0);
    for (size_t k = 0; k < POINTS; k += 2)
        check_at_most(fabs(fabs(value_at(&mapped, "shear_deg", k)) -
                           fabs(value_at(&mapped, "shear_deg", k + 1))),
                      0.05);
    forget(&mapped);
    bytes_free(&request);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_map_rim_has_fields_of_second_order),
        cmocka_unit_test(test_map_rim_tells_what_lies_beyond),
        cmocka_unit_test(test_map_rim_of_a_hemisphere),
    };
    return cmocka_run_group_tests_name("map_rim", tests, NULL, NULL);
}
