/* SPDX-License-Identifier: MIT */
/*
 * Parts as they come to be draped, by every method: the net goes to the rim everywhere, and a
 * copy ten times as large, or a thousandth, drapes the same.
 */
#include "measure.h"
#include "shapes.h"
#include "tests/check.h"
#include <stdio.h>

static const double QUARTER = M_PI / 2;

/* --- the parts --- */

static void make_rectangle(struct shape *shape) {
    shape_plane(shape, (double[2]){0, 3}, (double[2]){0, 2});
}

static void make_strip(struct shape *shape) {
    shape_plane(shape, (double[2]){0, 5}, (double[2]){0, 0.3});
}

static void make_saddle(struct shape *shape) {
    shape_quadric(shape, 1, -1, (double[2]){-1, 1}, (double[2]){-1, 1});
}

/* The start, (0, 0), is far from its middle. */
static void make_sphere_patch(struct shape *shape) {
    shape_stereographic(shape, 2, (double[2]){-0.1, 0.5}, (double[2]){-0.45, 0.05});
}

static void make_quarter_torus(struct shape *shape) {
    shape_torus(shape, 2, 0.7, (double[2]){0, QUARTER}, (double[2]){-QUARTER, QUARTER}, QUARTER);
}

/* The paper's figure 7: one octant, generators along the two boundary meridians. v = 1 is the
 * pole. */
static void make_octant(struct shape *shape) {
    shape_sphere(shape, 1, (double[2]){0, QUARTER}, (double[2]){0, QUARTER}, QUARTER);
}

static void make_hemisphere(struct shape *shape) {
    shape_sphere(shape, 1, (double[2]){0, 4 * QUARTER}, (double[2]){0, QUARTER}, QUARTER);
}

/* A helmet: geodesics that leave it come round below the rim. */
static void make_half_ellipsoid(struct shape *shape) {
    struct motion stretch = motion_stretch(1.3, 1, 0.9);
    make_hemisphere(shape);
    shape_move(shape, &stretch);
}

static void make_roof(struct shape *shape) {
    shape_crease(shape, 1, M_PI / 6);
}

struct part {
    const char *name;
    void (*make)(struct shape *shape);
    double start[2], angle_deg, spacing;
};

static const struct part parts[] = {
    {"rectangle, 0 deg", make_rectangle, {1.4, 0.9}, 0, 0.07},
    {"rectangle, 17 deg", make_rectangle, {1.4, 0.9}, 17, 0.07},
    {"rectangle, 30 deg", make_rectangle, {1.4, 0.9}, 30, 0.07},
    {"rectangle, 45 deg", make_rectangle, {1.4, 0.9}, 45, 0.07},
    {"rectangle, 60 deg", make_rectangle, {1.4, 0.9}, 60, 0.07},
    {"start near a corner", make_rectangle, {0.05, 0.04}, 30, 0.07},
    {"strip, 40 deg", make_strip, {0.3, 0.1}, 40, 0.03},
    {"saddle, 20 deg", make_saddle, {-0.2, 0.3}, 20, 0.05},
    {"sphere patch", make_sphere_patch, {0, 0}, 25, 0.05},
    {"quarter torus", make_quarter_torus, {0.4, 0.5}, 0, 0.08},
    {"roof, 30 deg crease", make_roof, {0.3, 0.45}, 35, 0.05},
    {"octant from the pole", make_octant, {0, 1}, 0, 0.05},
    {"hemisphere from the pole", make_hemisphere, {0, 1}, 0, 0.05},
    {"half ellipsoid", make_half_ellipsoid, {0.05, 0.5}, 40, 0.06},
};
enum { PARTS = sizeof parts / sizeof *parts };

static const enum drape_method methods[] = {DRAPE_GIB, DRAPE_BASIC, DRAPE_GIB4, DRAPE_GEODESIC,
                                            DRAPE_MOSAIC};
enum { METHODS = sizeof methods / sizeof *methods };

static void drape_part(const struct part *part, enum drape_method method, double scale,
                       struct shape *shape, struct drape_run *run) {
    struct motion larger = motion_stretch(scale, scale, scale);
    double d = part->spacing * scale;
    struct drape_settings settings = {.method = method,
                                      .spacing = {d, d},
                                      .start_kind = DRAPE_START_UV,
                                      .start_uv = {part->start[0], part->start[1]},
                                      .direction_deg = part->angle_deg,
                                      .max_nodes = 50000};
    part->make(shape);
    shape_move(shape, &larger);
    assert_int_equal(drape_try(run, shape, &settings), STATUS_OK);
    if (method != DRAPE_MOSAIC) /* whose nodes lie on its triangles */
        check_result(shape, &settings, run);
}

/* --- coverage --- */

/* What is left is a strip at the rim narrower than the diagonal of a cell. */
static void check_coverage(const struct part *part, const struct shape *shape,
                           const struct drape_run *run) {
    const struct drape_summary *summary = &run->result.summary;
    double strip = sqrt(2) * part->spacing * shape_perimeter(shape) / shape_area(shape);
    assert_int_equal(summary->outcome, DRAPE_COMPLETE);
    assert_int_equal(summary->front_reasons[DRAPE_REASON_BOUNDARY], run->result.front.count);
    check_below(1 - summary->coverage, strip);
}

static void test_exact_parts_are_covered(void **state) {
    static struct shape shape;
    (void)state;
    for (int k = 0; k < PARTS; k++) {
        printf("  %-26s", parts[k].name);
        for (int m = 0; m < METHODS; m++) {
            struct drape_run run;
            drape_part(&parts[k], methods[m], 1, &shape, &run);
            printf(" %.3f", run.result.summary.coverage);
            check_coverage(&parts[k], &shape, &run);
            drape_end(&run);
        }
        printf("\n");
    }
}

/* --- scale --- */

/* The largest distance between the nodes of a net and of its enlarged copy, in spacings. */
static double scale_gap(const struct drape_run *run, const struct drape_run *copy, double scale,
                        double spacing) {
    const struct drape_nodes *nodes = &run->result.nodes, *others = &copy->result.nodes;
    double gap = 0;
    assert_int_equal(nodes->count, others->count);
    for (size_t k = 0; k < nodes->count; k++) {
        assert_int_equal(nodes->i[k], others->i[k]);
        assert_int_equal(nodes->j[k], others->j[k]);
        struct vec3 r = vec3_scale(scale, node_point(nodes, (int)k));
        gap = fmax(gap, vec3_distance(r, node_point(others, (int)k)));
    }
    return gap / (spacing * scale);
}

static void test_exact_parts_scale(void **state) {
    static const double scales[] = {10, 1e-3};
    static struct shape shape, larger;
    double worst = 0;
    (void)state;
    for (int k = 0; k < PARTS * 2 * METHODS; k++) {
        const struct part *part = &parts[k / (2 * METHODS)];
        enum drape_method method = methods[k % METHODS];
        double scale = scales[k / METHODS % 2];
        struct drape_run run, copy;
        drape_part(part, method, 1, &shape, &run);
        drape_part(part, method, scale, &larger, &copy);
        double gap = scale_gap(&run, &copy, scale, part->spacing);
        if (!(gap < 1e-8))
            fail_msg("%s, method %d, x %g: %.1e spacings", part->name, (int)method, scale, gap);
        worst = fmax(worst, gap);
        drape_end(&run);
        drape_end(&copy);
    }
    printf("  largest difference %.1e spacings\n", worst);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_exact_parts_are_covered),
        cmocka_unit_test(test_exact_parts_scale),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
