/* SPDX-License-Identifier: MIT */
/* Layers of sheared weaves, and lamination theory. */
#include "api/format/yarn_plies.h"

#include "small.h"
#include "solver/angle.h"
#include "support.h"
#include "tests/check.h"
#include <math.h>
#include <string.h>

static const struct lamina carbon = {110e9, 6e9, 0.3, 2e9};

/* The strain that a unidirectional layer has under a unit stress along its fibre, from its
 * compliance: e_xx = c^4 / e1 + (1 / g12 - 2 nu12 / e1) s^2 c^2 + s^4 / e2. */
static void test_lamina_has_the_modulus_of_its_compliance(void **state) {
    (void)state;
    for (double angle = -90; angle <= 90; angle += 7.5) {
        double q[LAMINA_ENTRIES] = {0}, s, c;
        angle_sincos_deg(angle, &s, &c);
        lamina_add(&carbon, angle, 1, q);
        double det = q[0] * (q[3] * q[5] - q[4] * q[4]) - q[1] * (q[1] * q[5] - q[4] * q[2]) +
                     q[2] * (q[1] * q[4] - q[3] * q[2]);
        double found = (q[3] * q[5] - q[4] * q[4]) / det;
        double wanted = pow(c, 4) / carbon.e1 + pow(s, 4) / carbon.e2 +
                        (1 / carbon.g12 - 2 * carbon.nu12 / carbon.e1) * s * s * c * c;
        check_at_most(fabs(found / wanted - 1), 1e-12);
    }
}

/* Of one element: its layers as `as`, and their A and D in the element's frame. */
static struct lamina_abd abd_as(double shear_deg, double angle_deg, enum format_plies_as as,
                                double share, bool mirrored) {
    struct map_fields fields = small_stack();
    struct map_plies plies = *fields.plies;
    const struct map_ply_row row = {0, 0, mirrored, angle_deg, shear_deg, 0.4, 0.5};
    const struct map_ply_kind kind = {share, carbon};
    static const size_t first[] = {0, 1, 1};
    struct api_problem problem = {0};
    struct yarn_plies layers;
    struct lamina_abd abd = {0};
    plies.rows = &row;
    plies.row_count = plies.ply_count = 1;
    plies.first = first;
    plies.kinds = &kind;
    fields.plies = &plies;
    assert_true(yarn_plies_make(&layers, &fields, as, 0, "test", &problem));
    double z = -row.thickness / 2;
    for (size_t k = 0; k < layers.plies.row_count; k++) {
        const struct map_ply_row *own = &layers.plies.rows[k];
        double q[LAMINA_ENTRIES] = {0};
        lamina_add(&layers.lamina[own->ply], own->angle_deg, 1, q);
        lamina_stack(&abd, q, z, z + own->thickness);
        z += own->thickness;
    }
    check_at_most(fabs(z - row.thickness / 2), 1e-15);
    yarn_plies_free(&layers);
    return abd;
}

static double difference(const double a[LAMINA_ENTRIES], const double b[LAMINA_ENTRIES]) {
    double most = 0;
    for (int k = 0; k < LAMINA_ENTRIES; k++)
        most = fmax(most, fabs(a[k] - b[k]) / (fabs(a[0]) + fabs(a[3])));
    return most;
}

static void test_yarn_plies_without_shear_are_the_ordinary_ply(void **state) {
    (void)state;
    for (double angle = -80; angle <= 90; angle += 10)
        for (int mirrored = 0; mirrored < 2; mirrored++) {
            struct lamina_abd warp = abd_as(0, angle, PLIES_AS_WARP, 0.5, mirrored);
            struct lamina_abd yarns = abd_as(0, angle, PLIES_AS_YARNS, 0.5, mirrored);
            struct lamina_abd bisector = abd_as(0, angle, PLIES_AS_BISECTOR, 0.5, mirrored);
            check_at_most(difference(warp.a, yarns.a), 1e-14);
            check_at_most(difference(warp.d, yarns.d), 1e-14);
            check_at_most(difference(warp.a, bisector.a), 1e-14);
            check_at_most(difference(warp.d, bisector.d), 1e-14);
            check_at_most(difference(warp.b, bisector.b), 1e-14);
            check_above(difference(yarns.b, warp.b), 0.1);
        }
}

/* Both have the same membrane and bending stiffness at any shear, either way, on either side. The
 * classes of shear are of 0.02 degrees here. */
static void test_yarn_plies_on_the_bisector_have_the_stiffness_of_yarns(void **state) {
    (void)state;
    for (double shear = -60; shear <= 60; shear += 7.37)
        for (int mirrored = 0; mirrored < 2; mirrored++) {
            struct lamina_abd yarns = abd_as(shear, 25, PLIES_AS_YARNS, 0.5, mirrored);
            struct lamina_abd bisector = abd_as(shear, 25, PLIES_AS_BISECTOR, 0.5, mirrored);
            struct lamina_abd warp = abd_as(shear, 25, PLIES_AS_WARP, 0.5, mirrored);
            check_at_most(difference(yarns.a, bisector.a), 3e-4);
            check_at_most(difference(yarns.d, bisector.d), 3e-4);
            if (fabs(shear) > 5)
                check_above(difference(yarns.a, warp.a), 0.01);
        }
}

/* Turned by any angle the stiffness is the same in a frame that turns with it: its invariants
 * A11 + A22 + 2 A12 and A66 - A12 are. */
static void test_yarn_plies_do_not_depend_on_the_frame(void **state) {
    (void)state;
    for (int as = PLIES_AS_WARP; as <= PLIES_AS_BISECTOR; as++) {
        struct lamina_abd first = abd_as(33, 0, (enum format_plies_as)as, 0.5, false);
        for (double angle = 3; angle < 180; angle += 13) {
            struct lamina_abd turned = abd_as(33, angle, (enum format_plies_as)as, 0.5, false);
            double sum = first.a[0] + first.a[3] + 2 * first.a[1];
            check_at_most(fabs((turned.a[0] + turned.a[3] + 2 * turned.a[1]) / sum - 1), 1e-13);
            check_at_most(fabs(turned.a[5] - turned.a[1] - first.a[5] + first.a[1]) / sum, 1e-13);
        }
    }
}

static void test_yarn_plies_share_their_thickness_by_the_balance(void **state) {
    (void)state;
    double q[LAMINA_ENTRIES] = {0};
    struct lamina_abd abd = abd_as(20, 0, PLIES_AS_YARNS, 0.7, false);
    lamina_add(&carbon, 0, 0.7 * 0.4, q);
    lamina_add(&carbon, 70, 0.3 * 0.4, q);
    check_at_most(difference(abd.a, q), 1e-14);
    struct lamina_abd uni = abd_as(20, 0, PLIES_AS_YARNS, 1, false);
    memset(q, 0, sizeof q);
    lamina_add(&carbon, 0, 0.4, q);
    check_at_most(difference(uni.a, q), 1e-14);
}

static void check_bisector_refused(const struct map_ply_kind *kind, const char *detail) {
    struct map_fields fields = small_stack();
    struct map_plies plies = *fields.plies;
    const struct map_ply_kind kinds[] = {*kind, *kind};
    struct api_problem problem = {0};
    struct yarn_plies layers;
    plies.kinds = kinds;
    fields.plies = &plies;
    assert_false(yarn_plies_make(&layers, &fields, PLIES_AS_BISECTOR, 2, "nastran", &problem));
    yarn_plies_free(&layers);
    assert_int_equal(problem.id, API_INVALID_REQUEST);
    if (!strstr(problem.error[0].detail, detail))
        fail_msg("%s", problem.error[0].detail);
}

static void test_yarn_plies_on_the_bisector_need_constants_and_balance(void **state) {
    (void)state;
    check_bisector_refused(&(struct map_ply_kind){0.5, {0, 0, 0, 0}}, "fabric.lamina");
    check_bisector_refused(&(struct map_ply_kind){0.6, carbon}, "plies_as=yarns");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_lamina_has_the_modulus_of_its_compliance),
        cmocka_unit_test(test_yarn_plies_without_shear_are_the_ordinary_ply),
        cmocka_unit_test(test_yarn_plies_on_the_bisector_have_the_stiffness_of_yarns),
        cmocka_unit_test(test_yarn_plies_do_not_depend_on_the_frame),
        cmocka_unit_test(test_yarn_plies_share_their_thickness_by_the_balance),
        cmocka_unit_test(test_yarn_plies_on_the_bisector_need_constants_and_balance),
    };
    return cmocka_run_group_tests_name("yarn_plies", tests, NULL, NULL);
}
