/* SPDX-License-Identifier: MIT */
/* The requests of api/examples/: that they are what their README says. */
#include "support.h"
#include "tests/check.h"

#include "api/request/prepared_part.h"
#include "solver/surface/bounds.h"
#include "solver/surface/measure.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const names[] = {"saddle", "sphere", "freeform"};

struct example {
    struct arena *arena;
    struct bytes text, container;
    struct api_request request;
    const struct surface *surface;
};

static void example_open(struct example *example, const char *name) {
    char path[64];
    struct api_problem problem;
    struct prepared_part shape;
    snprintf(path, sizeof path, "api/examples/%s.json", name);
    *example = (struct example){.arena = arena_new((size_t)1 << 26), .text = file_read(path)};
    if (decode_text(example->text.data, example->arena, &example->request, &problem) != API_OK ||
        prepared_part_make(&example->request, &api_limits_default, example->arena, &shape,
                           &problem) != API_OK)
        fail_msg("%s: %s: %s", name, problem.error[0].pointer, problem.error[0].detail);
    example->surface = shape.part.surface;
}

static void example_close(struct example *example) {
    arena_free(example->arena);
    bytes_free(&example->text);
    bytes_free(&example->container);
}

/* The values of a column of the nodes; the caller frees them. */
static double *node_column(struct example *example, const char *name, size_t *rows) {
    struct api_problem problem = {0};
    struct api_columns columns;
    struct api_reader reader = reader_over(&example->container);
    if (!example->container.data)
        assert_int_equal(run_text(example->text.data, &example->container, &problem), API_OK);
    assert_int_equal(api_columns_open(&reader, &columns, &problem), API_OK);
    const struct api_column *column = api_columns_find(&columns, API_TABLE_NODES, name);
    *rows = column->rows;
    double *values = calloc(*rows, sizeof *values);
    assert_true(api_columns_read(&reader, column, 0, *rows, values));
    return values;
}

static void test_examples_run(void **state) {
    (void)state;
    for (size_t k = 0; k < sizeof names / sizeof *names; k++) {
        struct example example;
        size_t rows;
        example_open(&example, names[k]);
        free(node_column(&example, "x", &rows));
        assert_in_range(rows, 1000, 20000);
        example_close(&example);
    }
}

/* A random point of the surface. */
static struct vec3 random_point(struct random *random, const struct surface *surface) {
    struct surface_cursor cursor = {0};
    struct surface_jet jet;
    double lower[2], upper[2];
    surface_domain(surface, lower, upper);
    double u = random_between(random, lower[0], upper[0]);
    double v = random_between(random, lower[1], upper[1]);
    surface_evaluate(surface, &cursor, u, v, &jet);
    return jet.r;
}

static void test_examples_saddle_is_the_saddle(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    struct example example;
    example_open(&example, "saddle");
    for (int i = 0; i < 10000; i++) {
        struct vec3 p = random_point(&random, example.surface);
        check_below(fabs(p.z - (p.x * p.x - p.y * p.y) / 2), 1e-14);
        check_at_most(fabs(p.x), 2);
        check_at_most(fabs(p.y), 2);
    }
    example_close(&example);
}

static void test_examples_sphere_is_a_sphere(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    struct example example;
    struct vec3 low = {0, 0, 100};
    example_open(&example, "sphere");
    for (int i = 0; i < 10000; i++) {
        struct vec3 p = random_point(&random, example.surface);
        check_below(fabs(vec3_norm(p) - 48), 1e-13 * 48);
        low.z = fmin(low.z, p.z);
    }
    check_above(low.z, 16);
    check_below(low.z, 17); /* the corners are at 16 */
    example_close(&example);
}

static void test_examples_freeform_is_bicubic_rational_and_uneven(void **state) {
    (void)state;
    struct example example;
    example_open(&example, "freeform");
    const struct nurbs *nurbs = &example.request.surface.nurbs;
    assert_int_equal(nurbs->u.degree, 3);
    assert_int_equal(nurbs->v.degree, 3);
    assert_non_null(nurbs->weights);
    assert_true(nurbs->u.knots[5] - nurbs->u.knots[4] != nurbs->u.knots[4] - nurbs->u.knots[3]);
    example_close(&example);
}

/* sin gamma = -x y / sqrt((1 + x^2)(1 + y^2)), to the accuracy of this spacing. */
static void test_examples_saddle_has_the_shear_of_its_readme(void **state) {
    (void)state;
    struct example example;
    size_t rows;
    example_open(&example, "saddle");
    double *x = node_column(&example, "x", &rows), *y = node_column(&example, "y", &rows);
    double *shear = node_column(&example, "shear_deg", &rows);
    for (size_t k = 0; k < rows; k++) {
        double sine = -x[k] * y[k] / sqrt((1 + x[k] * x[k]) * (1 + y[k] * y[k]));
        check_below(fabs(shear[k] - asin(sine) * 180 / acos(-1)), 0.15);
    }
    free(x);
    free(y);
    free(shear);
    example_close(&example);
}

static void assert_node(struct example *example, int i, int j, const double expected[4],
                        double tolerance) {
    static const char *const keys[] = {"x", "y", "z", "shear_deg"};
    size_t rows, at = 0;
    double *is = node_column(example, "i", &rows), *js = node_column(example, "j", &rows);
    while (at < rows && !((int)is[at] == i && (int)js[at] == j))
        at++;
    check_below(at, rows);
    for (size_t k = 0; k < 4; k++) {
        double *values = node_column(example, keys[k], &rows);
        if (!(fabs(values[at] - expected[k]) < tolerance * (k == 3 ? 10 : 1)))
            fail_msg("node %d %d: %s is %.9g, not %.9g", i, j, keys[k], values[at], expected[k]);
        free(values);
    }
    free(is);
    free(js);
}

/* The limits of the README are further from the net of this spacing than the last digit, but not
 * by more than its second order allows. */
static void test_examples_freeform_is_near_the_limits_of_its_readme(void **state) {
    (void)state;
    struct example example;
    example_open(&example, "freeform");
    assert_node(&example, 20, 20, (const double[]){281.66438, 247.22063, 98.31998, -19.9897}, 0.01);
    assert_node(&example, -20, -20, (const double[]){76.79671, 70.54999, 83.61291, 36.9431}, 0.01);
    assert_node(&example, -20, 20, (const double[]){85.85201, 240.30880, 74.58798, -24.9742}, 0.01);
    assert_node(&example, 20, -20, (const double[]){260.28468, 54.83116, 53.75146, -0.8182}, 0.01);
    example_close(&example);
}

/* Strip by strip as all at once: area, box, and which directions are closed. */
static void test_examples_are_measured_in_strips(void **state) {
    (void)state;
    static const char *const all[] = {"saddle",     "sphere", "freeform",
                                      "hemisphere", "octant", "torus"};
    for (size_t k = 0; k < sizeof all / sizeof *all; k++) {
        struct example example;
        struct surface_measure measure;
        struct vec3 lower, upper;
        example_open(&example, all[k]);
        assert_int_equal(surface_measure(&example.request.surface.nurbs, example.arena, &measure),
                         STATUS_OK);
        bounds_tight(example.surface, &lower, &upper);
        double size = vec3_distance(lower, upper), area = surface_area(example.surface, NULL);
        check_below(fabs(measure.area - area), 1e-9 * area);
        check_below(vec3_distance(measure.lower, lower), 1e-9 * size);
        check_below(vec3_distance(measure.upper, upper), 1e-9 * size);
        for (int direction = 0; direction < 2; direction++)
            assert_int_equal(measure.closed[direction], surface_closed(example.surface, direction));
        example_close(&example);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_examples_run),
        cmocka_unit_test(test_examples_are_measured_in_strips),
        cmocka_unit_test(test_examples_saddle_is_the_saddle),
        cmocka_unit_test(test_examples_sphere_is_a_sphere),
        cmocka_unit_test(test_examples_freeform_is_bicubic_rational_and_uneven),
        cmocka_unit_test(test_examples_saddle_has_the_shear_of_its_readme),
        cmocka_unit_test(test_examples_freeform_is_near_the_limits_of_its_readme),
    };
    prepare();
    return cmocka_run_group_tests_name("examples", tests, NULL, NULL);
}
