/* SPDX-License-Identifier: MIT */
/* Fillets no larger than a spacing and sharp folds: on a developable part the net is the flat
 * square grid whatever the spacing, and has no shear. */
#include "awkward.h"
#include "profile.h"
#include "tests/check.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void check_sheet(struct profile_sheet *sheet, const struct profile_method *method, double d,
                        const double start[2], double angle_deg) {
    struct drape_run run;
    profile_drape(sheet, method->id, d, start, angle_deg, &run);
    struct profile_error error = profile_measure(sheet, d, start, angle_deg, &run);
    printf("    %-8s d %-5g at %3g deg: %6zu nodes, %.1e d, shear %.4f, of cells %.4f deg\n",
           method->name, d, angle_deg, run.result.nodes.count, error.position, error.node_shear_deg,
           error.cell_shear_deg);
    assert_int_equal(error.missing, 0);
    assert_int_equal(run.result.summary.outcome, DRAPE_COMPLETE);
    check_below(error.position, method->position);
    check_below(error.node_shear_deg, PROFILE_SHEAR_DEG);
    check_below(error.cell_shear_deg, PROFILE_SHEAR_DEG);
    check_below(error.most_shear_deg, PROFILE_SHEAR_DEG);
    drape_end(&run);
}

/* A hat, as of a B-pillar: fillets of radius 3 between flanges, walls at 80 degrees and a top. */
static void test_exact_folds_hat(void **state) {
    static const struct profile_part hat[] = {
        {0, 0, 20}, {3, 80, 25}, {3, -80, 40}, {3, -80, 25}, {3, 80, 20}};
    static const double spacings[] = {0.25, 1, 2, 5, 10}, angles[] = {0, 20, 45, 70};
    static struct profile_sheet sheet;
    (void)state;
    for (size_t k = 0; k < sizeof spacings / sizeof *spacings; k++) {
        double d = spacings[k];
        profile_make(&sheet, hat, 5, d < 1 ? 20 : 60);
        double start[2] = {sheet.total / 2, sheet.width / 2};
        for (int m = 0; m < PROFILE_METHODS; m++) {
            for (size_t a = 0; a < sizeof angles / sizeof *angles; a++) {
                check_sheet(&sheet, &profile_methods[m], d, start, angles[a]);
            }
        }
    }
}

/* A crease of 30 to 150 degrees, up or down, with the start and so nodes on it, or beside it. */
static void test_exact_folds_crease(void **state) {
    static const double angles[] = {0, 20, 45, 70, 90};
    static struct profile_sheet sheet;
    (void)state;
    for (int fold = -150; fold <= 150; fold += 60) {
        struct profile_part roof[] = {{0, 0, 12}, {0, fold, 12}};
        printf("  fold of %d degrees\n", fold);
        profile_make(&sheet, roof, 2, 20);
        for (int m = 0; m <= PROFILE_METHODS; m++) {
            const struct profile_method *method =
                m < PROFILE_METHODS ? &profile_methods[m] : &profile_basic;
            for (size_t a = 0; a < sizeof angles / sizeof *angles; a++) {
                for (int beside = 0; beside < 3; beside++) {
                    double start[2] = {12 - 0.37 * beside, 10};
                    if (beside == 2) /* and the generator's sixth node on the crease */
                        start[0] = 12 - 6 * cos(angles[a] * M_PI / 180);
                    check_sheet(&sheet, method, 1, start, angles[a]);
                }
            }
        }
    }
}

/* A fillet whose radius is rounding is a fold. */
static void test_exact_folds_radius_below_rounding(void **state) {
    static const double radii[] = {1e-13, 1e-12, 3e-12}, turns[] = {-150, 80, 130};
    static struct profile_sheet sheet;
    (void)state;
    for (int k = 0; k < 9; k++) {
        struct profile_part roof[] = {{0, 0, 12}, {radii[k % 3], turns[k / 3], 12}};
        const double start[2] = {11.3, 10};
        profile_make(&sheet, roof, 2, 20);
        for (int m = 0; m < PROFILE_METHODS; m++)
            check_sheet(&sheet, &profile_methods[m], 1, start, 20);
    }
}

/* Where a sheet lies back on itself cloth ends: no node beyond, and none that is wrong before. */
static void test_exact_folds_back_on_itself(void **state) {
    static const double folds[] = {-179.9, -179, 179, 179.9, 180}, angles[] = {0, 20, 45, 70};
    static struct profile_sheet sheet;
    (void)state;
    for (size_t f = 0; f < sizeof folds / sizeof *folds; f++) {
        struct profile_part roof[] = {{0, 0, 12}, {0, folds[f], 12}};
        profile_make(&sheet, roof, 2, 20);
        for (int m = 0; m < PROFILE_METHODS; m++)
            for (size_t a = 0; a < sizeof angles / sizeof *angles; a++) {
                const double start[2] = {6.3, 10};
                struct drape_run run;
                profile_drape(&sheet, profile_methods[m].id, 1, start, angles[a], &run);
                struct profile_error error = profile_measure(&sheet, 1, start, angles[a], &run);
                assert_int_equal(run.result.summary.outcome, DRAPE_PARTIAL);
                check_above(run.result.nodes.count, 180);
                for (size_t k = 0; k < run.result.nodes.count; k++)
                    check_at_most(run.result.nodes.u[k], 12 + 1e-6);
                check_below(error.position, profile_methods[m].position);
                check_below(error.node_shear_deg, PROFILE_SHEAR_DEG);
                check_below(error.cell_shear_deg, PROFILE_SHEAR_DEG);
                check_below(error.most_shear_deg, PROFILE_SHEAR_DEG);
                drape_end(&run);
            }
    }
}

/* Several folds under one edge: a joggle lower than a spacing. */
static void test_exact_folds_joggle(void **state) {
    static const struct profile_part joggle[] = {{0, 0, 15}, {0.5, 60, 0.4}, {0.5, -60, 15}};
    static const double angles[] = {0, 20, 45, 70};
    static struct profile_sheet sheet;
    (void)state;
    profile_make(&sheet, joggle, 3, 20);
    for (int m = 0; m < PROFILE_METHODS; m++) {
        for (size_t a = 0; a < sizeof angles / sizeof *angles; a++) {
            double start[2] = {7.3, 10};
            check_sheet(&sheet, &profile_methods[m], 2.5, start, angles[a]);
        }
    }
}

/* Once round a square tube, with folds and with fillets: the net ends where it would meet itself.
 */
static void test_exact_folds_square_tube(void **state) {
    static const struct profile_part sharp[] = {
        {0, 0, 10}, {0, 90, 20}, {0, 90, 20}, {0, 90, 20}, {0, 90, 10}};
    static const struct profile_part filleted[] = {
        {0, 0, 7}, {3, 90, 14}, {3, 90, 14}, {3, 90, 14}, {3, 90, 7}};
    static const double angles[] = {0, 30, 45};
    static struct profile_sheet sheet;
    (void)state;
    for (int k = 0; k < 2; k++) {
        profile_make(&sheet, k ? filleted : sharp, 5, 40);
        for (int m = 0; m < PROFILE_METHODS; m++) {
            for (size_t a = 0; a < sizeof angles / sizeof *angles; a++) {
                double start[2] = {sheet.total / 2, 20};
                check_sheet(&sheet, &profile_methods[m], k ? 3.7 : 1, start, angles[a]);
            }
        }
    }
}

/* --- a box whose edges and corners are rounded --- */

enum { BOX_LEVELS = 3 };
static const double BOX_SPACING = 0.2; /* halved from level to level */

static void drape_box(struct shape *shape, enum drape_method method, double d,
                      struct drape_run *run) {
    struct drape_settings settings = {.method = method,
                                      .spacing = {d, d},
                                      .start_kind = DRAPE_START_UV,
                                      .direction_deg = awkward[0].angle_deg,
                                      .max_nodes = 1000000};
    awkward_start(&awkward[0], shape, settings.start_uv);
    drape_begin(run, shape, &settings);
    assert_int_equal(run->result.summary.outcome, DRAPE_COMPLETE);
}

/* The largest distance of nodes from those of a net that is `times` as fine; but for those that
 * rest on free edges, which are a choice at any spacing. */
static double gap_to(const struct drape_run *fine, int times, const struct drape_run *run,
                     double d) {
    const struct drape_nodes *nodes = &run->result.nodes;
    double gap = 0;
    for (size_t k = 0; k < nodes->count; k++) {
        int at = grid_find(&fine->grid, nodes->i[k] * times, nodes->j[k] * times);
        if (abs(nodes->i[k]) * d > 1.2 + 1e-9 || abs(nodes->j[k]) * d > 1.2 + 1e-9)
            continue;
        assert_true(at >= 0);
        gap = fmax(gap,
                   vec3_distance(node_point(nodes, (int)k), node_point(&fine->result.nodes, at)));
    }
    return gap;
}

/* Doubly curved, with spacings from more than the radii of its corners on: all methods tend to the
 * finest net of geodesics with their order. */
static void test_exact_folds_rounded_box(void **state) {
    static struct shape shape;
    struct drape_run finest;
    int times = check_sized(4, 2);
    (void)state;
    awkward[0].make(&shape);
    drape_box(&shape, DRAPE_GEODESIC, BOX_SPACING / (1 << (BOX_LEVELS - 1)) / times, &finest);
    for (int m = 0; m < PROFILE_METHODS; m++) {
        double gap[BOX_LEVELS];
        printf("  %-8s", profile_methods[m].name);
        for (int level = 0; level < BOX_LEVELS; level++) {
            struct drape_run run;
            double d = BOX_SPACING / (1 << level);
            drape_box(&shape, profile_methods[m].id, d, &run);
            gap[level] = gap_to(&finest, times << (BOX_LEVELS - 1 - level), &run, d);
            printf(" %.1e", gap[level]);
            drape_end(&run);
        }
        double order = order_of(gap[0], gap[BOX_LEVELS - 1]) / (BOX_LEVELS - 1);
        printf(" (%.2f)\n", order);
        check_above(order, profile_methods[m].id == DRAPE_GIB4 ? 2.4 : 1.9);
        check_below(gap[0], 0.02 * BOX_SPACING);
    }
    drape_end(&finest);
}

/* --- a profile turned about an axis --- */

/* By 3 radians about z, its beginning at the radius `off`, in so many rational arcs: between these
 * the surface goes on smoothly, but not its second derivatives. */
static void turn_profile(const struct profile_sheet *sheet, double off, int spans,
                         struct shape *shape) {
    double half = 1.5 / spans;
    *shape = sheet->shape;
    shape->degree[1] = 2;
    shape->size[1] = 2 * spans + 1;
    for (int k = 0; k < shape->size[1] + 3; k++)
        shape->knots[1][k] = fmin(fmax((k - 1) / 2, 0), spans);
    for (int i = 0; i < shape->size[0]; i++)
        for (int j = 0; j < shape->size[1]; j++) {
            const double *of = sheet->shape.h[2 * i];
            double w = j % 2 ? cos(half) : 1, angle = half * j - 1.5;
            double rho = (of[0] + off * of[3]) * (j % 2 ? 1 : w);
            double h[4] = {rho * cos(angle), rho * sin(angle), of[2] * w, of[3] * w};
            memcpy(shape->h[i * shape->size[1] + j], h, sizeof h);
        }
}

/* Edges that cross the beginning of a fillet and a line between two arcs: however many arcs there
 * are, the net is the same. */
static void test_exact_folds_over_knot_lines_without_a_joint(void **state) {
    static const struct profile_part rings[] = {{0, 0, 20}, {3, 80, 12}, {2, -60, 15}};
    static struct profile_sheet sheet;
    static struct shape shape[2];
    (void)state;
    profile_make(&sheet, rings, 3, 1);
    for (int k = 0; k < 2; k++)
        turn_profile(&sheet, 20, 2 + k, &shape[k]);
    for (int m = 0; m < PROFILE_METHODS; m++) {
        struct drape_run run[2];
        double gap = 0;
        struct drape_settings settings = {.method = profile_methods[m].id,
                                          .spacing = {8, 8},
                                          .start_kind = DRAPE_START_POINT,
                                          .start_point = {33.3 * cos(0.03), 33.3 * sin(0.03), 0},
                                          .direction_kind = DRAPE_DIRECTION_VECTOR,
                                          .direction_vector = {1, 0.4, 0},
                                          .max_nodes = 10000};
        for (int k = 0; k < 2; k++)
            drape_begin(&run[k], &shape[k], &settings);
        const struct drape_nodes *nodes = &run[0].result.nodes;
        for (size_t n = 0; n < nodes->count; n++) {
            int at = grid_find(&run[1].grid, nodes->i[n], nodes->j[n]);
            assert_true(at >= 0);
            gap = fmax(gap, vec3_distance(node_point(nodes, (int)n),
                                          node_point(&run[1].result.nodes, at)));
        }
        printf("  %-8s %zu nodes, %.1e d\n", profile_methods[m].name, nodes->count, gap / 8);
        check_below(gap / 8, 2e-6);
        for (int k = 0; k < 2; k++)
            drape_end(&run[k]);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_exact_folds_hat),
        cmocka_unit_test(test_exact_folds_crease),
        cmocka_unit_test(test_exact_folds_radius_below_rounding),
        cmocka_unit_test(test_exact_folds_back_on_itself),
        cmocka_unit_test(test_exact_folds_joggle),
        cmocka_unit_test(test_exact_folds_square_tube),
        cmocka_unit_test(test_exact_folds_rounded_box),
        cmocka_unit_test(test_exact_folds_over_knot_lines_without_a_joint),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
