/* SPDX-License-Identifier: MIT */
#include "api/result/fields.h"

#include "support.h"
#include "tests/check.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static double shears[] = {0, 30, -60, 20, -20, 20.000001, 89.9};
enum { CELLS = sizeof shears / sizeof *shears };

static struct api_request plain_request(void) {
    return (struct api_request){.fabric = {.locking_angle_deg = {-1, -1}, .plies = 1},
                                .permeability = {.model = API_PERMEABILITY_NONE}};
}

/* Yarns in the plane z = 1, filled in by `set_up`. */
static double warp[3][CELLS], weft[3][CELLS];

static const struct drape_result result = {.cells = {.count = CELLS,
                                                     .shear_deg = shears,
                                                     .warp_x = warp[0],
                                                     .warp_y = warp[1],
                                                     .warp_z = warp[2],
                                                     .weft_x = weft[0],
                                                     .weft_y = weft[1],
                                                     .weft_z = weft[2]}};
static struct arena *arena;

static int set_up(void **state) {
    (void)state;
    for (size_t k = 0; k < CELLS; k++) {
        warp[0][k] = 1;
        weft[0][k] = sin(shears[k] * acos(-1) / 180);
        weft[1][k] = cos(shears[k] * acos(-1) / 180);
    }
    arena = arena_new((size_t)1 << 22);
    return arena ? 0 : -1;
}

static int tear_down(void **state) {
    (void)state;
    arena_free(arena);
    return 0;
}

/* The values of a derived column of the cells; NULL when it is not there. The caller frees. */
static double *derive(const struct api_request *request, const char *name) {
    struct api_fields *fields = malloc(sizeof *fields);
    double *values = NULL;
    assert_non_null(fields);
    assert_int_equal(api_fields_list(fields, request, &result, arena), STATUS_OK);
    for (size_t i = 0; i < fields->count; i++) {
        const struct api_column_source *source = &fields->source[i];
        if (source->table != API_TABLE_CELLS || strcmp(source->name, name) != 0)
            continue;
        values = calloc(CELLS, sizeof *values);
        source->fill(source->context, 0, 3, values);
        source->fill(source->context, 3, CELLS - 3, values + 3);
    }
    free(fields);
    return values;
}

static void assert_column(const struct api_request *request, const char *name,
                          double (*expected)(double shear_rad)) {
    double *values = derive(request, name);
    assert_non_null(values);
    for (size_t k = 0; k < CELLS; k++) {
        double wanted = expected(shears[k] * acos(-1) / 180);
        /* At 89.9 degrees the rounding of radians leaves the expected cosine so good. */
        check_at_most(fabs(values[k] - wanted), 1e-12 * fabs(wanted));
    }
    free(values);
}

static void assert_absent(const struct api_request *request, const char *name) {
    assert_null(derive(request, name));
}

static double flexible_thickness(double shear) {
    return 3 * 0.25 / cos(shear);
}
static double half(double shear) {
    (void)shear;
    return 0.5;
}
static double rigid_height(double shear) {
    (void)shear;
    return 0.8;
}
static double rigid_fraction(double shear) {
    return 0.5 * (3 * 0.25 / 0.8) / cos(shear);
}
static double rigid_porosity(double shear) {
    return 1 - rigid_fraction(shear);
}

static void test_fields_flexible_cavity_follows_mass_conservation(void **state) {
    (void)state;
    struct api_request request = plain_request();
    request.fabric.thickness = 0.25;
    request.fabric.fiber_volume_fraction = 0.5;
    request.fabric.plies = 3;
    assert_column(&request, "thickness", flexible_thickness);
    assert_column(&request, "fiber_volume_fraction", half);
    assert_column(&request, "porosity", half);
    assert_int_equal(api_fields_count(COLUMN_CELLS_packing_exceeded, &request, &result.cells), 0);
}

static void test_fields_rigid_cavity_follows_mass_conservation(void **state) {
    (void)state;
    struct api_request request = plain_request();
    request.fabric.thickness = 0.25;
    request.fabric.fiber_volume_fraction = 0.5;
    request.fabric.plies = 3;
    request.cavity.rigid = true;
    request.cavity.height = 0.8;
    assert_column(&request, "thickness", rigid_height);
    assert_column(&request, "fiber_volume_fraction", rigid_fraction);
    assert_column(&request, "porosity", rigid_porosity);
    /* 0.46875 / cos 60 = 0.9375 and that at 89.9 degrees, against 0.9 */
    assert_int_equal(api_fields_count(COLUMN_CELLS_packing_exceeded, &request, &result.cells), 2);
}

static void test_fields_without_their_inputs_are_left_out(void **state) {
    (void)state;
    struct api_request request = plain_request();
    assert_absent(&request, "thickness");
    assert_absent(&request, "fiber_volume_fraction");
    assert_absent(&request, "porosity");
    assert_absent(&request, "locked");
    assert_absent(&request, "packing_exceeded");
    request.cavity.rigid = true;
    request.cavity.height = 0.8;
    request.fabric.fiber_volume_fraction = 0.5;
    assert_column(&request, "thickness", rigid_height);
    assert_absent(&request, "porosity"); /* takes the ply's thickness */
}

static void test_fields_locked_is_beyond_the_locking_angle(void **state) {
    (void)state;
    struct api_request request = plain_request();
    static const struct {
        double angle_deg[2], expected[CELLS];
    } rows[] = {{{20, 20}, {0, 1, 1, 0, 0, 1, 1}},
                {{60, 19}, {0, 0, 1, 0, 1, 0, 1}},
                {{19, 60}, {0, 1, 0, 1, 0, 1, 1}}};
    for (size_t row = 0; row < sizeof rows / sizeof *rows; row++) {
        double sum = 0;
        memcpy(request.fabric.locking_angle_deg, rows[row].angle_deg, sizeof rows[row].angle_deg);
        double *locked = derive(&request, "locked");
        assert_memory_equal(locked, rows[row].expected, sizeof rows[row].expected);
        for (int k = 0; k < CELLS; k++)
            sum += locked[k];
        assert_true(api_fields_count(COLUMN_CELLS_locked, &request, &result.cells) == sum);
        free(locked);
    }
    request = plain_request();
    assert_true(api_fields_count(COLUMN_CELLS_locked, &request, &result.cells) == -1);
}

/* Straight between the rows, constant beyond; of both signs alike without negative angles. */
static void test_fields_severity_is_read_off_the_curve(void **state) {
    (void)state;
    static const double even_deg[] = {10, 20, 60}, even[] = {0.1, 0.25, 0.75};
    static const double uneven_deg[] = {-40, 0, 20, 60}, uneven[] = {1, 0, 0.5, 0.75};
    const struct {
        struct api_limit_curve curve;
        double expected[CELLS], most;
    } rows[] = {{{3, even_deg, even}, {0.1, 0.375, 0.75, 0.25, 0.25, 0.2500000125, 0.75}, 0.75},
                {{4, uneven_deg, uneven}, {0, 0.5625, 1, 0.5, 0.5, 0.50000000625, 0.75}, 1}};
    struct api_request request = plain_request();
    assert_absent(&request, "severity");
    assert_true(api_fields_most(COLUMN_CELLS_severity, &request, &result.cells) == -1);
    for (size_t row = 0; row < sizeof rows / sizeof *rows; row++) {
        request.fabric.limit = rows[row].curve;
        double *severity = derive(&request, "severity");
        for (int k = 0; k < CELLS; k++)
            check_at_most(fabs(severity[k] - rows[row].expected[k]), 1e-12);
        assert_true(api_fields_most(COLUMN_CELLS_severity, &request, &result.cells) ==
                    rows[row].most);
        free(severity);
    }
}

static void test_fields_packing_limit_is_that_of_the_model(void **state) {
    (void)state;
    struct api_request request = plain_request();
    request.fabric.thickness = 1;
    request.cavity.rigid = true;
    request.cavity.height = 1;
    request.permeability.model = API_PERMEABILITY_GEBART;
    request.fabric.fiber_volume_fraction = 0.8;
    request.permeability.packing = API_PACKING_QUADRATIC; /* 0.785 */
    assert_int_equal(api_fields_count(COLUMN_CELLS_packing_exceeded, &request, &result.cells),
                     CELLS);
    request.permeability.packing = API_PACKING_HEXAGONAL; /* 0.907; 0.8 / cos 30 = 0.924 */
    assert_int_equal(api_fields_count(COLUMN_CELLS_packing_exceeded, &request, &result.cells), 3);
}

static void test_fields_are_finite_at_ninety_degrees(void **state) {
    (void)state;
    struct api_request request = plain_request();
    request.fabric.thickness = 1;
    double kept = shears[1];
    shears[1] = 90;
    double *values = derive(&request, "thickness");
    assert_true(isfinite(values[1]));
    shears[1] = kept;
    free(values);
}

/* ---- permeability ---- */

static const double table_shear[] = {0, 30}, table_k1[] = {4e-10, 3e-10};
static const double table_k2[] = {2e-10, 1e-10}, table_k3[] = {1e-11, 2e-11};

static struct api_request table_request(void) {
    struct api_request request = plain_request();
    request.permeability = (struct api_permeability){.model = API_PERMEABILITY_TABLE,
                                                     .rows = 2,
                                                     .shear_deg = table_shear,
                                                     .table_k1 = table_k1,
                                                     .table_k2 = table_k2,
                                                     .table_k3 = table_k3};
    return request;
}

static double columns_at(const struct api_request *request, const char *name, size_t cell) {
    double *values = derive(request, name), value;
    assert_non_null(values);
    value = values[cell];
    free(values);
    return value;
}

static void test_fields_permeability_of_a_table_needs_nothing_else(void **state) {
    (void)state;
    struct api_request request = table_request();
    static const double outside[CELLS] = {0, 0, 1, 0, 0, 0, 1};
    double *flags = derive(&request, "out_of_table");
    assert_memory_equal(flags, outside, sizeof outside);
    free(flags);
    assert_true(columns_at(&request, "k1", 0) == 4e-10);
    assert_true(columns_at(&request, "k2", 1) == 1e-10);
    assert_true(columns_at(&request, "k3", 2) == 2e-11);
    /* The bisector at 30 degrees of shear is 30 degrees from warp. */
    check_below(fabs(columns_at(&request, "k1_x", 1) - sqrt(0.75)), 1e-15);
    check_below(fabs(columns_at(&request, "k1_y", 1) - 0.5), 1e-15);
    assert_true(columns_at(&request, "k1_z", 1) == 0);
    assert_absent(&request, "porosity");
}

static void test_fields_permeability_follows_the_fibre_volume_fraction(void **state) {
    (void)state;
    struct api_request request = plain_request();
    request.fabric.thickness = 1;
    request.fabric.fiber_volume_fraction = 0.5;
    request.cavity.rigid = true;
    request.cavity.height = 1;
    request.permeability = (struct api_permeability){.model = API_PERMEABILITY_KOZENY_CARMAN,
                                                     .k1 = 1e-10,
                                                     .k2 = 1e-10,
                                                     .k3 = 1e-11,
                                                     .at_fiber_volume_fraction = 0.5};
    double vf = 0.5 / sqrt(0.75), g = pow(1 - vf, 3) / (vf * vf) / 0.5;
    check_below(fabs(columns_at(&request, "k3", 0) - 1e-11), 1e-25);
    check_below(fabs(columns_at(&request, "k3", 1) - g * 1e-11), 1e-24);
    check_below(fabs(columns_at(&request, "k1", 1) - g * sqrt(3) * 1e-10), 1e-23);
    /* At 60 degrees the cavity is full of fibres: no flow, and a flag. */
    assert_true(columns_at(&request, "k1", 2) == 0);
    assert_true(columns_at(&request, "packing_exceeded", 2) == 1);
    assert_absent(&request, "out_of_table");
}

static void test_fields_permeability_is_left_out_without_a_model(void **state) {
    (void)state;
    struct api_request request = plain_request();
    assert_absent(&request, "k1");
    assert_absent(&request, "k1_x");
    assert_absent(&request, "out_of_table");
}

static void test_fields_permeability_without_memory_is_a_status(void **state) {
    (void)state;
    struct api_request request = table_request();
    struct api_fields fields;
    for (size_t n = 1; n <= 7; n++) {
        arena_fail_at(arena, n);
        assert_int_equal(api_fields_list(&fields, &request, &result, arena), STATUS_OUT_OF_MEMORY);
    }
    arena_fail_at(arena, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_fields_flexible_cavity_follows_mass_conservation),
        cmocka_unit_test(test_fields_rigid_cavity_follows_mass_conservation),
        cmocka_unit_test(test_fields_without_their_inputs_are_left_out),
        cmocka_unit_test(test_fields_locked_is_beyond_the_locking_angle),
        cmocka_unit_test(test_fields_severity_is_read_off_the_curve),
        cmocka_unit_test(test_fields_packing_limit_is_that_of_the_model),
        cmocka_unit_test(test_fields_are_finite_at_ninety_degrees),
        cmocka_unit_test(test_fields_permeability_of_a_table_needs_nothing_else),
        cmocka_unit_test(test_fields_permeability_follows_the_fibre_volume_fraction),
        cmocka_unit_test(test_fields_permeability_is_left_out_without_a_model),
        cmocka_unit_test(test_fields_permeability_without_memory_is_a_status),
    };
    return cmocka_run_group_tests_name("fields", tests, set_up, tear_down);
}
