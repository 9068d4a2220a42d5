/* SPDX-License-Identifier: MIT */
#include "solver/permeability.h"

#include "support.h"
#include "tests/check.h"
#include <math.h>

static const double pi = 3.14159265358979323846;

static void assert_near(double value, double expected, double tolerance) {
    if (!(fabs(value - expected) <= tolerance * fabs(expected)))
        fail_msg("%.17g is not %.17g", value, expected);
}

/* Symmetric tensors of space: xx, yy, zz, xy, yz, xz. */
struct tensor {
    double m[3][3];
};

static void add_dyad(struct tensor *k, double factor, struct vec3 a) {
    const double v[3] = {a.x, a.y, a.z};
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            k->m[i][j] += factor * v[i] * v[j];
}

static struct tensor in_space(const struct permeability *k, struct vec3 warp, struct vec3 weft) {
    struct tensor tensor = {0};
    struct vec3 first = permeability_direction(k, warp, weft);
    struct vec3 normal = vec3_unit(vec3_cross(warp, weft));
    add_dyad(&tensor, k->k1, first);
    add_dyad(&tensor, k->k2, vec3_cross(normal, first));
    add_dyad(&tensor, k->k3, normal);
    return tensor;
}

static void assert_tensors_near(const struct tensor *a, const struct tensor *b, double tolerance) {
    double size = 0;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            size = fmax(size, fabs(b->m[i][j]));
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            check_at_most(fabs(a->m[i][j] - b->m[i][j]), tolerance * size);
}

/* Unit yarns with that shear in a plane turned at random. */
static void make_yarns(struct random *random, double shear_deg, struct vec3 *warp,
                       struct vec3 *weft) {
    struct vec3 a, b;
    do {
        a = vec3_make(random_between(random, -1, 1), random_between(random, -1, 1),
                      random_between(random, -1, 1));
        b = vec3_make(random_between(random, -1, 1), random_between(random, -1, 1),
                      random_between(random, -1, 1));
    } while (vec3_norm(vec3_cross(a, b)) < 0.1);
    *warp = vec3_unit(a);
    double shear = shear_deg * pi / 180;
    struct vec3 across = vec3_unit(vec3_axpy(-vec3_dot(b, *warp), *warp, b));
    *weft = vec3_axpy(sin(shear), *warp, vec3_scale(cos(shear), across));
}

static const double table_shear[] = {0, 20, 40}, table_k1[] = {3e-10, 2e-10, 2e-10};
static const double table_k2[] = {1e-10, 0.9e-10, 0.2e-10}, table_k3[] = {3e-12, 2e-12, 1e-12};
static const double table_angle[] = {-30, -10, 5};
static const struct permeability_table table = {3,        table_shear, table_k1,
                                                table_k2, table_k3,    table_angle};

/* Every model with something of everything. */
enum { MODELS = 4 };
static struct permeability model(int which, double vf, double shear_deg) {
    static const double k[3] = {2e-10, 0.5e-10, 1e-12};
    switch (which) {
    case 0:
        return permeability_kozeny_carman(k, 0.5, vf, shear_deg, 0);
    case 1:
        return permeability_gebart(17e-6, PERMEABILITY_QUADRATIC, vf, shear_deg, 0);
    case 2:
        return permeability_gebart(5e-6, PERMEABILITY_HEXAGONAL, vf, shear_deg, 0);
    default:
        return permeability_of_table(&table, shear_deg, NULL);
    }
}

/* ---- numbers worked by hand ---- */

static void test_permeability_gebart_gives_the_hand_worked_numbers(void **state) {
    (void)state;
    const double r = 17e-6, vf = 0.5;
    assert_near(permeability_gebart_along(r, PERMEABILITY_QUADRATIC, vf), 2.02807018e-11, 1e-8);
    assert_near(permeability_gebart_across(r, PERMEABILITY_QUADRATIC, vf), 3.73472833e-12, 1e-8);
    assert_near(permeability_gebart_along(r, PERMEABILITY_HEXAGONAL, vf), 2.18113208e-11, 1e-8);
    assert_near(permeability_gebart_across(r, PERMEABILITY_HEXAGONAL, vf), 4.72786599e-12, 1e-8);
}

static void test_permeability_packing_limits_are_those_of_touching_circles(void **state) {
    (void)state;
    assert_near(permeability_packing_limit(PERMEABILITY_QUADRATIC), 0.78539816339744831, 1e-15);
    assert_near(permeability_packing_limit(PERMEABILITY_HEXAGONAL), 0.90689968211710893, 1e-15);
}

static void test_permeability_kozeny_carman_factor_by_hand(void **state) {
    (void)state;
    assert_near(permeability_kozeny_carman_factor(0.5, 0.5), 1, 1e-15);
    /* (0.4^3 / 0.36) / (0.5^3 / 0.25) = 0.17777.. / 0.5 */
    assert_near(permeability_kozeny_carman_factor(0.6, 0.5), 0.064 / 0.36 / 0.5, 1e-14);
    assert_true(permeability_kozeny_carman_factor(1, 0.5) == 0);
    assert_true(permeability_kozeny_carman_factor(7, 0.5) == 0);
}

/* Parallel fibres that have slid are what they were, and k1 is along them; a weave is a slide of 0,
 * to which what slides a little comes near. */
static void test_permeability_of_parallel_fibers_stays(void **state) {
    (void)state;
    static const double k0[3] = {4e-10, 1e-10, 1e-11};
    for (double shear = -80; shear <= 80; shear += 20) {
        struct permeability k = permeability_kozeny_carman(k0, 0.5, 0.5, shear, 1);
        assert_near(k.k1, k0[0], 1e-14);
        assert_near(k.k2, k0[1], 1e-14);
        assert_near(k.along, 1, 1e-14);
        k = permeability_gebart(17e-6, PERMEABILITY_QUADRATIC, 0.5, shear, 1);
        assert_near(k.k1, permeability_gebart_along(17e-6, PERMEABILITY_QUADRATIC, 0.5), 1e-14);
        assert_near(k.k2, permeability_gebart_across(17e-6, PERMEABILITY_QUADRATIC, 0.5), 1e-14);
        assert_near(k.along, 1, 1e-14);
        assert_near(permeability_areal_ratio(shear, 1), 1, 1e-15);
        assert_near(permeability_unslid_deg(shear, 0.5), atan(tan(shear * pi / 180) / 2) * 180 / pi,
                    1e-13);
        double cosine = cos(shear * pi / 180);
        assert_near(permeability_areal_ratio(shear, 0.25), pow(cosine, -0.75), 1e-14);
        /* half way: F = [1 x; 0 y], det K = k1 k2 */
        k = permeability_kozeny_carman(k0, 0.5, 0.5, shear, 0.5);
        assert_near(k.k1 * k.k2, k0[0] * k0[1], 1e-13);
        struct permeability weave = permeability_kozeny_carman(k0, 0.5, 0.5, shear, 0);
        k = permeability_kozeny_carman(k0, 0.5, 0.5, shear, 1e-9);
        assert_near(k.k1, weave.k1, 1e-7);
        weave = permeability_gebart(17e-6, PERMEABILITY_QUADRATIC, 0.5, shear, 0);
        k = permeability_gebart(17e-6, PERMEABILITY_QUADRATIC, 0.5, shear, 1e-9);
        assert_near(k.k1, weave.k1, 1e-7);
        assert_near(k.k2, weave.k2, 1e-7);
    }
}

/* k1 = k2 at 30 degrees: axes on the bisectors, the ratio 3, the product g^2 K0^2. */
static void test_permeability_balanced_fabric_has_its_axes_on_the_bisectors(void **state) {
    (void)state;
    static const double k0[3] = {3e-10, 3e-10, 1e-11};
    double g = 0.064 / 0.36 / 0.5;
    struct permeability k = permeability_kozeny_carman(k0, 0.5, 0.6, 30, 0);
    assert_near(k.k1 / k.k2, 3, 1e-14);
    assert_near(k.k1 * k.k2, g * g * 9e-20, 1e-13);
    assert_near(k.k3, g * 1e-11, 1e-14);
    assert_near(k.along, cos(30 * pi / 180), 1e-14); /* yarns at 0 and 60 degrees */
    assert_near(k.across, sin(30 * pi / 180), 1e-14);
    for (double shear = -85; shear <= 85; shear += 5) {
        double s = sin(fabs(shear) * pi / 180);
        k = permeability_kozeny_carman(k0, 0.5, 0.5, shear, 0);
        assert_near(k.k1 / k.k2, (1 + s) / (1 - s), 1e-10);
        assert_near(k.k1 * k.k2, 9e-20, 1e-13);
    }
}

/* k1 = 4, k2 = 1 at 30 degrees: K = [4.25 0.433; 0.433 0.75] / 0.866. */
static void test_permeability_push_forward_by_hand(void **state) {
    (void)state;
    static const double k0[3] = {4, 1, 0.1};
    struct permeability k = permeability_kozeny_carman(k0, 0.5, 0.5, 30, 0);
    double c = sqrt(0.75), xx = 4.25 / c, xy = 0.5, yy = c;
    struct tensor expected = {{{xx, xy, 0}, {xy, yy, 0}, {0, 0, 0.1}}};
    struct tensor found = in_space(&k, vec3_make(1, 0, 0), vec3_make(0.5, c, 0));
    assert_tensors_near(&found, &expected, 1e-14);
    assert_near(k.k1 * k.k2, 4, 1e-14);
}

static void test_permeability_gebart_superposes_two_yarns(void **state) {
    (void)state;
    const double shear = 25, s = sin(shear * pi / 180), c = cos(shear * pi / 180);
    const struct vec3 warp = {1, 0, 0}, weft = {s, c, 0};
    double along = permeability_gebart_along(17e-6, PERMEABILITY_QUADRATIC, 0.5);
    double across = permeability_gebart_across(17e-6, PERMEABILITY_QUADRATIC, 0.5);
    struct permeability k = permeability_gebart(17e-6, PERMEABILITY_QUADRATIC, 0.5, shear, 0);
    struct tensor expected = {{{across, 0, 0}, {0, across, 0}, {0, 0, across}}};
    add_dyad(&expected, (along - across) / 2, warp);
    add_dyad(&expected, (along - across) / 2, weft);
    struct tensor found = in_space(&k, warp, weft);
    assert_tensors_near(&found, &expected, 1e-14);
    assert_true(k.k3 == across);
}

/* ---- the table ---- */

static void test_permeability_table_goes_through_its_rows(void **state) {
    (void)state;
    for (int row = 0; row < 3; row++) {
        bool outside = true;
        struct permeability k = permeability_of_table(&table, -table_shear[row], &outside);
        assert_false(outside);
        assert_near(k.k1, table_k1[row], 1e-15);
        assert_near(k.k2, table_k2[row], 1e-15);
        assert_near(k.k3, table_k3[row], 1e-15);
    }
}

static void test_permeability_table_ends_are_kept_and_flagged(void **state) {
    (void)state;
    static const double shear[] = {5, 30}, k1[] = {2, 1}, k2[] = {1, 0.5}, k3[] = {0.1, 0.2};
    const struct permeability_table part = {2, shear, k1, k2, k3, NULL};
    bool outside = false;
    struct permeability k = permeability_of_table(&part, -4.9, &outside);
    assert_true(outside && k.k1 == 2 && k.k2 == 1 && k.k3 == 0.1);
    k = permeability_of_table(&part, 88, &outside);
    assert_true(outside && k.k1 == 1 && k.k2 == 0.5 && k.k3 == 0.2);
    k = permeability_of_table(&part, 17.5, &outside);
    assert_false(outside);
    assert_near(k.k1, 1.5, 1e-15); /* two rows: a straight line */
}

static void test_permeability_interpolation_keeps_monotony(void **state) {
    (void)state;
    struct random random = random_begin("monotony");
    for (int trial = 0; trial < 300; trial++) {
        enum { MOST = 9 };
        double x[MOST], y[MOST];
        size_t count = 1 + (size_t)random_index(&random, MOST);
        for (size_t k = 0; k < count; k++) {
            x[k] = (k ? x[k - 1] : 0) + random_between(&random, 0.01, 10);
            y[k] = random_index(&random, 4) && k ? random_between(&random, 1, 3) : 2;
        }
        for (size_t k = 0; k + 1 < count; k++) {
            double low = fmin(y[k], y[k + 1]), high = fmax(y[k], y[k + 1]), last = y[k];
            for (int step = 0; step <= 64; step++) {
                double at = x[k] + (x[k + 1] - x[k]) * step / 64;
                double value = permeability_interpolate(x, y, count, at);
                check_at_least(value, low - 1e-14);
                check_at_most(value, high + 1e-14);
                check_at_least((value - last) * (y[k + 1] - y[k]), -1e-14);
                last = value;
            }
            assert_near(permeability_interpolate(x, y, count, x[k]), y[k], 1e-15);
        }
    }
}

/* Intervals of 1 and 2 with slopes 1 and 1/2: at the ends the parabola's slopes 7/6 and 1/6, in the
 * middle the harmonic mean 9/13; half way in an interval of h the mean of its ends and h / 8 times
 * by how much the slope falls. */
static void test_permeability_interpolation_by_hand(void **state) {
    static const double x[] = {0, 1, 3}, y[] = {0, 1, 2};
    const double first = 7.0 / 6, middle = 9.0 / 13, last = 1.0 / 6;
    (void)state;
    assert_near(permeability_interpolate(x, y, 3, 0.5), 0.5 + (first - middle) / 8, 1e-15);
    assert_near(permeability_interpolate(x, y, 3, 2), 1.5 + (middle - last) / 4, 1e-15);
}

/* k1 along warp without shear, where the bisector lies at 45 degrees; and k2 the larger one. */
static void test_permeability_table_angle_is_from_the_bisector(void **state) {
    (void)state;
    static const double shear[] = {0, 40}, one[] = {1, 1}, two[] = {2, 2}, angle[] = {-45, -15};
    const struct permeability_table turned = {2, shear, two, one, one, angle};
    const struct permeability_table swapped = {2, shear, one, two, one, angle};
    struct permeability k = permeability_of_table(&turned, 0, NULL);
    assert_near(k.along, 1, 1e-15);
    check_below(fabs(k.across), 1e-15);
    k = permeability_of_table(&turned, 40, NULL); /* 25 - 15 degrees from warp */
    assert_near(k.along, cos(10 * pi / 180), 1e-14);
    assert_near(k.across, sin(10 * pi / 180), 1e-14);
    k = permeability_of_table(&turned, -40, NULL);
    assert_near(k.across, -sin(10 * pi / 180), 1e-14);
    k = permeability_of_table(&swapped, 40, NULL); /* at right angles to that */
    assert_true(k.k1 == 2 && k.k2 == 1);
    assert_near(k.along, sin(10 * pi / 180), 1e-14);
    assert_near(k.across, -cos(10 * pi / 180), 1e-14);
}

/* ---- the table over shear and fraction ---- */

static const double grid_shear[] = {0, 20, 45}, grid_vf[] = {0.4, 0.5, 0.62};
static const double grid_k1[] = {4e-10,   2e-10, 0.6e-10, 3e-10, 1.4e-10,
                                 0.5e-10, 1e-10, 0.5e-10, 2e-11};
static const double grid_k2[] = {3e-10, 1e-10, 0.3e-10, 1e-10, 0.4e-10, 1e-11, 2e-11, 1e-11, 4e-12};
static const double grid_k3[] = {3e-12, 1e-12, 0.3e-12, 3e-12, 1e-12, 0.3e-12, 3e-12, 1e-12, 3e-13};
static const double grid_angle[] = {0, 10, 20, 10, 20, 30, 0, 0, 0};
static const struct permeability_grid grid = {3,       3,       grid_shear, grid_vf,
                                              grid_k1, grid_k2, grid_k3,    grid_angle};

static void test_permeability_grid_goes_through_its_values(void **state) {
    (void)state;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            bool outside = true;
            struct permeability k =
                permeability_of_grid(&grid, grid_vf[j], -grid_shear[i], &outside);
            double degrees = (90 - grid_shear[i]) / 2 + grid_angle[3 * i + j];
            assert_false(outside);
            assert_near(k.k1, grid_k1[3 * i + j], 1e-14);
            assert_near(k.k2, grid_k2[3 * i + j], 1e-14);
            assert_near(k.k3, grid_k3[3 * i + j], 1e-14);
            assert_near(k.along, cos(degrees * pi / 180), 1e-13);
        }
}

/* Half-way the geometric mean, in either direction; angles in the middle. */
static void test_permeability_grid_is_log_linear_between(void **state) {
    (void)state;
    struct permeability k = permeability_of_grid(&grid, 0.45, 0, NULL);
    assert_near(k.k1, sqrt(grid_k1[0] * grid_k1[1]), 1e-13);
    assert_near(k.along, cos(50 * pi / 180), 1e-13);
    k = permeability_of_grid(&grid, 0.5, 10, NULL);
    assert_near(k.k2, sqrt(grid_k2[1] * grid_k2[4]), 1e-13);
    k = permeability_of_grid(&grid, 0.56, 32.5, NULL);
    assert_near(k.k1, pow(grid_k1[4] * grid_k1[5] * grid_k1[7] * grid_k1[8], 0.25), 1e-13);
}

static void test_permeability_grid_beyond_its_fractions_is_scaled_and_flagged(void **state) {
    (void)state;
    bool outside = false;
    struct permeability k = permeability_of_grid(&grid, 0.7, 20, &outside);
    assert_true(outside);
    assert_near(k.k1, grid_k1[5] * pow(0.3 / 0.38, 3) * pow(0.62 / 0.7, 2), 1e-13);
    outside = false;
    k = permeability_of_grid(&grid, 0.3, 20, &outside);
    assert_true(outside);
    assert_near(k.k3, grid_k3[3] * pow(0.7 / 0.6, 3) * pow(0.4 / 0.3, 2), 1e-13);
    outside = false;
    k = permeability_of_grid(&grid, 0.5, 60, &outside);
    assert_true(outside);
    assert_near(k.k1, grid_k1[7], 1e-14);
    assert_true(permeability_of_grid(&grid, 1.1, 20, NULL).k1 == 0);
}

/* Of random tables that pass, k / (1 - Vf), by which a mould fills, falls everywhere. */
static void test_permeability_grid_of_denser_cloth_always_fills_slower(void **state) {
    (void)state;
    struct random random = random_begin("denser");
    enum { ROWS = 4, COLUMNS = 4 };
    for (int trial = 0; trial < 60; trial++) {
        double shear[ROWS], vf[COLUMNS], k[3][ROWS * COLUMNS];
        for (int i = 0; i < ROWS; i++)
            shear[i] = (i ? shear[i - 1] : 0) + random_between(&random, 1, 20);
        for (int j = 0; j < COLUMNS; j++)
            vf[j] = (j ? vf[j - 1] : 0.2) + random_between(&random, 0.02, 0.15);
        for (int n = 0; n < 3 * ROWS * COLUMNS; n++) {
            int j = n % COLUMNS;
            double *value = &k[n / (ROWS * COLUMNS)][n % (ROWS * COLUMNS)];
            double fall = j ? exp(-(vf[j] - vf[j - 1]) / (1 - vf[j])) : 1;
            *value = j ? value[-1] * fall *
                             (random_index(&random, 3) ? random_between(&random, 0.1, 1) : 1 - 1e-9)
                       : random_between(&random, 1e-12, 1e-9);
            assert_true(!j || permeability_falls(value[-1], vf[j - 1], *value, vf[j]));
        }
        const struct permeability_grid any = {ROWS, COLUMNS, shear, vf, k[0], k[1], k[2], NULL};
        for (int place = 0; place < 5; place++) {
            double gamma = random_between(&random, 0, 80), last[3] = {INFINITY, INFINITY, INFINITY};
            for (double f = 0.1; f < 0.95; f += 0.01) {
                struct permeability at = permeability_of_grid(&any, f, gamma, NULL);
                const double own[3] = {at.k1 / (1 - f), at.k2 / (1 - f), at.k3 / (1 - f)};
                for (int n = 0; n < 3; n++) {
                    check_at_most(own[n] / last[n], 1);
                    last[n] = own[n];
                }
            }
        }
    }
}

/* ---- invariants ---- */

static void test_permeability_unsheared_gives_the_input_back(void **state) {
    (void)state;
    static const double warpwise[3] = {2e-10, 0.5e-10, 1e-12}, weftwise[3] = {1e-10, 3e-10, 1e-12};
    struct permeability k = permeability_kozeny_carman(warpwise, 0.5, 0.5, 0, 0);
    assert_near(k.k1, 2e-10, 1e-15);
    assert_near(k.k2, 0.5e-10, 1e-15);
    assert_near(k.k3, 1e-12, 1e-15);
    assert_true(k.along == 1 && k.across == 0);
    k = permeability_kozeny_carman(weftwise, 0.5, 0.5, 0, 0);
    assert_near(k.k1, 3e-10, 1e-15);
    assert_near(k.k2, 1e-10, 1e-15);
    assert_true(k.along == 0 && k.across == 1);
}

static void test_permeability_is_positive_and_ordered(void **state) {
    (void)state;
    struct random random = random_begin("positive");
    for (int trial = 0; trial < 4000; trial++) {
        double shear = random_between(&random, -89.9, 89.9),
               vf = random_between(&random, 0.05, 1.5);
        struct permeability k = model(trial % MODELS, vf, shear);
        check_at_least(k.k1, k.k2);
        check_at_least(k.k2, 0);
        check_at_least(k.k3, 0);
        check_at_least(k.along, 0);
        assert_true(vf > 0.78 || (k.k2 > 0 && k.k3 > 0));
        assert_near(k.along * k.along + k.across * k.across, 1, 1e-14);
    }
}

static void test_permeability_is_finite_at_ninety_degrees(void **state) {
    (void)state;
    for (int which = 0; which < MODELS; which++) {
        for (int sign = -1; sign <= 1; sign += 2) {
            struct vec3 warp = {0, 0, 1}, weft = {0, 0, sign};
            struct permeability k = model(which, 0.5, 90 * sign);
            struct vec3 direction = permeability_direction(&k, warp, weft);
            assert_true(isfinite(k.k1) && isfinite(k.k2) && isfinite(k.k3));
            assert_near(vec3_norm(direction), 1, 1e-14);
        }
    }
    assert_true(isfinite(permeability_areal_ratio(90, 0)));
}

static void test_permeability_sign_of_shear_mirrors_the_tensor(void **state) {
    (void)state;
    struct random random = random_begin("mirror");
    for (int trial = 0; trial < 400; trial++) {
        double shear = random_between(&random, 0.1, 89), vf = random_between(&random, 0.3, 0.7);
        struct permeability a = model(trial % MODELS, vf, shear);
        struct permeability b = model(trial % MODELS, vf, -shear);
        assert_true(a.k1 == b.k1 && a.k2 == b.k2 && a.k3 == b.k3);
        assert_true(a.along == b.along && a.across == -b.across);
    }
}

/* Yarns turned in space: the tensor by its frame is that turned with them. Exchanging warp and weft
 * of a fabric that is alike in both changes nothing. */
static void test_permeability_turns_with_the_yarns(void **state) {
    (void)state;
    struct random random = random_begin("rotation");
    for (int trial = 0; trial < 400; trial++) {
        double shear = random_between(&random, -80, 80);
        struct vec3 warp, weft;
        make_yarns(&random, shear, &warp, &weft);
        struct vec3 normal = vec3_unit(vec3_cross(warp, weft)), e2 = vec3_cross(normal, warp);
        struct permeability k = model(trial % MODELS, 0.55, shear);
        struct tensor flat = in_space(&k, vec3_make(1, 0, 0),
                                      vec3_make(vec3_dot(weft, warp), vec3_dot(weft, e2), 0));
        const double rotation[3][3] = {
            {warp.x, e2.x, normal.x}, {warp.y, e2.y, normal.y}, {warp.z, e2.z, normal.z}};
        struct tensor turned = {0}, found = in_space(&k, warp, weft);
        for (int i = 0; i < 9; i++)
            for (int j = 0; j < 9; j++)
                turned.m[i / 3][i % 3] +=
                    rotation[i / 3][j / 3] * flat.m[j / 3][j % 3] * rotation[i % 3][j % 3];
        assert_tensors_near(&found, &turned, 1e-13);
    }
}

static void test_permeability_of_a_balanced_fabric_knows_no_first_yarn(void **state) {
    (void)state;
    struct random random = random_begin("exchange");
    static const double k0[3] = {3e-10, 3e-10, 1e-11};
    for (int trial = 0; trial < 200; trial++) {
        double shear = random_between(&random, -80, 80);
        struct vec3 warp, weft;
        make_yarns(&random, shear, &warp, &weft);
        struct permeability k =
            trial % 2 ? permeability_kozeny_carman(k0, 0.5, 0.6, shear, 0) : model(1, 0.5, shear);
        /* The weft as first yarn, the other way round, so that the normal stays. */
        struct tensor a = in_space(&k, warp, weft);
        struct tensor b = in_space(&k, weft, vec3_scale(-1, warp));
        k = trial % 2 ? permeability_kozeny_carman(k0, 0.5, 0.6, -shear, 0) : model(1, 0.5, -shear);
        b = in_space(&k, weft, vec3_scale(-1, warp));
        assert_tensors_near(&a, &b, 1e-12);
    }
}

static void test_permeability_principal_undoes_a_rotation(void **state) {
    (void)state;
    struct random random = random_begin("principal");
    for (int trial = 0; trial < 1000; trial++) {
        double angle = random_between(&random, -pi / 2, pi / 2), c = cos(angle), s = sin(angle);
        double k1 = random_between(&random, 1, 2), k2 = random_between(&random, 0.01, 0.99);
        struct permeability k = permeability_principal(k1 * c * c + k2 * s * s, (k1 - k2) * c * s,
                                                       k1 * s * s + k2 * c * c, 0.5);
        assert_near(k.k1, k1, 1e-13);
        assert_near(k.k2, k2, 1e-11);
        assert_near(k.along * c + k.across * s, 1, 1e-12);
        assert_true(k.k3 == 0.5);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_permeability_gebart_gives_the_hand_worked_numbers),
        cmocka_unit_test(test_permeability_packing_limits_are_those_of_touching_circles),
        cmocka_unit_test(test_permeability_kozeny_carman_factor_by_hand),
        cmocka_unit_test(test_permeability_balanced_fabric_has_its_axes_on_the_bisectors),
        cmocka_unit_test(test_permeability_push_forward_by_hand),
        cmocka_unit_test(test_permeability_gebart_superposes_two_yarns),
        cmocka_unit_test(test_permeability_table_goes_through_its_rows),
        cmocka_unit_test(test_permeability_table_ends_are_kept_and_flagged),
        cmocka_unit_test(test_permeability_interpolation_keeps_monotony),
        cmocka_unit_test(test_permeability_interpolation_by_hand),
        cmocka_unit_test(test_permeability_table_angle_is_from_the_bisector),
        cmocka_unit_test(test_permeability_grid_goes_through_its_values),
        cmocka_unit_test(test_permeability_grid_is_log_linear_between),
        cmocka_unit_test(test_permeability_grid_beyond_its_fractions_is_scaled_and_flagged),
        cmocka_unit_test(test_permeability_grid_of_denser_cloth_always_fills_slower),
        cmocka_unit_test(test_permeability_unsheared_gives_the_input_back),
        cmocka_unit_test(test_permeability_of_parallel_fibers_stays),
        cmocka_unit_test(test_permeability_is_positive_and_ordered),
        cmocka_unit_test(test_permeability_is_finite_at_ninety_degrees),
        cmocka_unit_test(test_permeability_sign_of_shear_mirrors_the_tensor),
        cmocka_unit_test(test_permeability_turns_with_the_yarns),
        cmocka_unit_test(test_permeability_of_a_balanced_fabric_knows_no_first_yarn),
        cmocka_unit_test(test_permeability_principal_undoes_a_rotation),
    };
    return cmocka_run_group_tests_name("permeability", tests, NULL, NULL);
}
