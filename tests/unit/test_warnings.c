/* SPDX-License-Identifier: MIT */
/* The warnings of a summary: each comes when it should, and does not when it need not. */
#include "support.h"
#include "tests/check.h"
#include <stdio.h>
#include <string.h>

/* A plane of 1 by 1. */
#define PLANE                                                                                      \
    "{\"degree_u\":1,\"degree_v\":1,\"size_u\":2,\"size_v\":2,\"knotvector_u\":[0,0,1,1],"         \
    "\"knotvector_v\":[0,0,1,1],\"control_points\":[[0,0,0],[0,1,0],[1,0,0],[1,1,0]]}"

/* z = a (x^2 - y^2) over [-1, 1]^2: for 2 a = 1 with 30 degrees of shear at its corners, for
 * 2 a = 2 with 53. */
#define SADDLE(a)                                                                                  \
    "{\"degree_u\":2,\"degree_v\":2,\"size_u\":3,\"size_v\":3,\"knotvector_u\":[0,0,0,1,1,1],"     \
    "\"knotvector_v\":[0,0,0,1,1,1],\"control_points\":[[-1,-1,0],[-1,0," a "],[-1,1,0],"          \
    "[0,-1,-" a "],[0,0,0],[0,1,-" a "],[1,-1,0],[1,0," a "],[1,1,0]]}"

/* A hill on a square of 2 by 2, z = h (1 - x^2) (1 - y^2) / 4. */
#define HILL(h)                                                                                    \
    "{\"degree_u\":2,\"degree_v\":2,\"size_u\":3,\"size_v\":3,\"knotvector_u\":[0,0,0,1,1,1],"     \
    "\"knotvector_v\":[0,0,0,1,1,1],\"control_points\":[[-1,-1,0],[-1,0,0],[-1,1,0],"              \
    "[0,-1,0],[0,0," h "],[0,1,0],[1,-1,0],[1,0,0],[1,1,0]]}"

/* A trough of 2 by 1 with the radius of curvature 1 / k at its bottom, z = k x^2 / 2. */
#define TROUGH(high, low)                                                                          \
    "{\"degree_u\":2,\"degree_v\":1,\"size_u\":3,\"size_v\":2,\"knotvector_u\":[0,0,0,1,1,1],"     \
    "\"knotvector_v\":[0,0,1,1],\"control_points\":[[-1,0," high "],[-1,1," high "],[0,0," low     \
    "],[0,1," low "],[1,0," high "],[1,1," high "]]}"

/* A cubic profile whose middle points are at x = a and b: with 1 and 0 it has a cusp, with 0.9 and
 * 0.1 it goes round a bend that turns by a right angle and more. */
#define HOOK(a, b)                                                                                 \
    "{\"degree_u\":3,\"degree_v\":1,\"size_u\":4,\"size_v\":2,\"knotvector_u\":"                   \
    "[0,0,0,0,1,1,1,1],\"knotvector_v\":[0,0,1,1],\"control_points\":[[0,0,0],[0,1,0],[" a         \
    ",0,1],[" a ",1,1],[" b ",0,1],[" b ",1,1],[1,0,0],[1,1,0]]}"

/* Two planes of 1 by 1 that meet at x = 1, the second of which ends at x and z. */
#define FOLD(x, z)                                                                                 \
    "{\"degree_u\":1,\"degree_v\":1,\"size_u\":3,\"size_v\":2,\"knotvector_u\":[0,0,1,2,2],"       \
    "\"knotvector_v\":[0,0,1,1],\"control_points\":[[0,0,0],[0,1,0],[1,0,0],[1,1,0],[" x ",0," z   \
    "],[" x ",1," z "]]}"

/* Two by four points on a plane of 1 by 3, with v running fastest, and with u. */
#define ROWS(points)                                                                               \
    "{\"degree_u\":1,\"degree_v\":1,\"size_u\":2,\"size_v\":4,\"knotvector_u\":[0,0,1,1],"         \
    "\"knotvector_v\":[0,0,1,2,3,3],\"control_points\":[" points "]}"

#define SQUARES(gap)                                                                               \
    "{\"vertices\":[[0,0,0],[1,0,0],[1,1,0],[0,1,0],[" gap ",0,0],[2,0,0],[2,1,0],[" gap ",1,0]]," \
    "\"triangles\":[[0,1,2],[0,2,3],[4,5,6],[4,6,7],[1,4,7],[1,7,2]]}"
#define APART                                                                                      \
    "{\"vertices\":[[0,0,0],[1,0,0],[1,1,0],[0,1,0],[1.2,0,0],[2,0,0],[2,1,0],[1.2,1,0]],"         \
    "\"triangles\":[[0,1,2],[0,2,3],[4,5,6],[4,6,7]]}"

struct expectation {
    const char *code, *with, *without; /* requests */
};

static const struct expectation expectations[] = {
    {"coarse", "{\"surface\":" PLANE ",\"fabric\":{\"spacing\":0.3}}",
     "{\"surface\":" PLANE ",\"fabric\":{\"spacing\":0.1}}"},
    {"thickness", "{\"surface\":" PLANE ",\"fabric\":{\"spacing\":0.1,\"thickness\":0.5}}",
     "{\"surface\":" PLANE ",\"fabric\":{\"spacing\":0.1,\"thickness\":0.0005}}"},
    {"thickness",
     "{\"surface\":" PLANE ",\"length_unit\":\"mm\",\"fabric\":{\"spacing\":0.1,\"thickness\":0.5,"
     "\"plies\":4}}",
     "{\"surface\":" PLANE
     ",\"length_unit\":\"mm\",\"fabric\":{\"spacing\":0.1,\"thickness\":0.05}}"},
    {"thickness", "{\"surface\":" PLANE ",\"fabric\":{\"spacing\":0.1,\"thickness\":5e-7}}",
     "{\"surface\":" PLANE ",\"fabric\":{\"spacing\":0.1,\"thickness\":5e-5}}"},
    {"thickness",
     "{\"surface\":" TROUGH("4", "-4") ",\"fabric\":{\"spacing\":0.05,\"thickness\":0.015,"
                                       "\"plies\":10}}",
     "{\"surface\":" TROUGH("1", "-1") ",\"fabric\":{\"spacing\":0.05,\"thickness\":0.015,"
                                       "\"plies\":10}}"},
    {"locked",
     "{\"surface\":" SADDLE("1") ",\"fabric\":{\"spacing\":0.05,\"locking_angle_deg\":25}}",
     "{\"surface\":" SADDLE("1") ",\"fabric\":{\"spacing\":0.05,\"locking_angle_deg\":31}}"},
    {"locked",
     "{\"surface\":" SADDLE("1") ",\"fabric\":{\"spacing\":0.05,\"locking_angle_deg\":29.8}}",
     "{\"surface\":" SADDLE("1") ",\"fabric\":{\"spacing\":0.05}}"},
    {"locked", "{\"surface\":" SADDLE("4") ",\"fabric\":{\"spacing\":0.05}}",
     "{\"surface\":" SADDLE("2") ",\"fabric\":{\"spacing\":0.05}}"},
    {"packing_exceeded",
     "{\"surface\":" PLANE ",\"fabric\":{\"spacing\":0.1,\"thickness\":0.01,"
     "\"fiber_volume_fraction\":0.5},\"cavity\":{\"height\":0.005}}",
     "{\"surface\":" PLANE ",\"fabric\":{\"spacing\":0.1,\"thickness\":0.01,"
     "\"fiber_volume_fraction\":0.5},\"cavity\":{\"height\":0.008}}"},
    {"fillet", "{\"surface\":" TROUGH("4", "-4") ",\"fabric\":{\"spacing\":0.15}}",
     "{\"surface\":" TROUGH("1", "-1") ",\"fabric\":{\"spacing\":0.15}}"},
    {"cusp",
     "{\"surface\":" HOOK("1", "0") ",\"start\":{\"uv\":[0.2,0.5]},\"fabric\":{\"spacing\":0.1}}",
     "{\"surface\":" HOOK("0.9", "0.1") ",\"start\":{\"uv\":[0.2,0.5]},"
                                        "\"fabric\":{\"spacing\":0.1}}"},
    {"cusp",
     "{\"surface\":" FOLD("0.01",
                          "1e-3") ",\"start\":{\"uv\":[0.5,0.5]},\"fabric\":{\"spacing\":0.1}}",
     "{\"surface\":" FOLD("0.1",
                          "0.1") ",\"start\":{\"uv\":[0.5,0.5]},\"fabric\":{\"spacing\":0.1}}"},
    {"steers_nothing",
     "{\"surface\":" PLANE ",\"start\":{\"uv\":[0,0]},\"direction\":{\"vector\":[-1,1,0]},"
     "\"generators\":{\"warp\":{\"steered\":[0.1,0.2]}},\"fabric\":{\"spacing\":0.1}}",
     "{\"surface\":" PLANE ",\"start\":{\"uv\":[0.5,0.5]},\"direction\":{\"vector\":[-1,1,0]},"
     "\"generators\":{\"warp\":{\"steered\":[0.1,0.2]}},\"fabric\":{\"spacing\":0.1}}"},
    {"not_steered",
     "{\"surface\":" PLANE
     ",\"generators\":{\"warp\":\"least_energy\"},\"fabric\":{\"spacing\":0.1}}",
     "{\"surface\":" HILL(
         "3") ",\"generators\":{\"warp\":\"least_energy\"},\"fabric\":{\"spacing\":0.1}}"},
    {"uncovered", "{\"surface\":" HILL("10") ",\"fabric\":{\"spacing\":0.1}}",
     "{\"surface\":" HILL("3") ",\"fabric\":{\"spacing\":0.1}}"},
    {"collapsed", "{\"surface\":" HILL("10") ",\"fabric\":{\"spacing\":0.1}}",
     "{\"surface\":" HILL("3") ",\"fabric\":{\"spacing\":0.1}}"},
    {"size", "{\"surface\":" PLANE ",\"length_unit\":\"mm\",\"fabric\":{\"spacing\":0.1}}",
     "{\"surface\":" PLANE ",\"length_unit\":\"ft\",\"fabric\":{\"spacing\":0.1}}"},
    {"points_order",
     "{\"surface\":" ROWS(
         "[0,0,0],[1,0,0],[0,1,0],[1,1,0],[0,2,0],[1,2,0],[0,3,0],[1,3,0]") ","
                                                                            "\"start\":{\"uv\":[0."
                                                                            "3,0.3]},\"fabric\":{"
                                                                            "\"spacing\":0.1}}",
     "{\"surface\":" ROWS(
         "[0,0,0],[0,1,0],[0,2,0],[0,3,0],[1,0,0],[1,1,0],[1,2,0],[1,3,0]") ","
                                                                            "\"fabric\":{"
                                                                            "\"spacing\":0.1}}"},
    {"components",
     "{\"surface\":" APART ",\"start\":{\"point\":[0.5,0.5,0]},\"method\":\"mosaic\","
     "\"fabric\":{\"spacing\":0.1}}",
     "{\"surface\":" SQUARES("1.2") ",\"start\":{\"point\":[0.5,0.5,0]},\"method\":\"mosaic\","
                                    "\"fabric\":{\"spacing\":0.1}}"},
};
enum { EXPECTATIONS = sizeof expectations / sizeof *expectations };

/* The warning with the code; NULL when there is none. */
static const struct api_warning *warning_of(const char *request, const char *code,
                                            struct api_columns *columns) {
    struct bytes container = {0};
    struct api_problem problem;
    if (run_text(request, &container, &problem) != API_OK)
        fail_msg("%s: %s", request, problem.error[0].detail);
    struct api_reader reader = reader_over(&container);
    assert_int_equal(api_columns_open(&reader, columns, &problem), API_OK);
    bytes_free(&container);
    for (size_t k = 0; k < columns->summary.warnings.count; k++)
        if (strcmp(columns->summary.warnings.list[k].code, code) == 0)
            return &columns->summary.warnings.list[k];
    return NULL;
}

static void test_warnings_come_when_they_should(void **state) {
    static struct api_columns columns;
    (void)state;
    for (int k = 0; k < EXPECTATIONS; k++) {
        const struct api_warning *warning =
            warning_of(expectations[k].with, expectations[k].code, &columns);
        if (!warning)
            fail_msg("no warning %s for %s", expectations[k].code, expectations[k].with);
        printf("  %s: %s (%s)\n", warning->code, warning->detail, warning->pointer);
        assert_true(warning->detail[0] && warning->pointer[0] == '/');
        check_below(strlen(warning->detail), sizeof warning->detail - 1);
    }
}

static void test_warnings_do_not_come_needlessly(void **state) {
    static struct api_columns columns;
    (void)state;
    for (int k = 0; k < EXPECTATIONS; k++) {
        const struct api_warning *warning =
            warning_of(expectations[k].without, expectations[k].code, &columns);
        if (warning)
            fail_msg("%s: %s", expectations[k].without, warning->detail);
    }
}

/* Squares by their side. Of units in which the diagonal is from 50 mm to 10 m: mm, or the first. */
static void test_warnings_of_size_name_the_unit_that_is_likely(void **state) {
    static struct api_columns columns;
    static const struct {
        double side;
        const char *unit, *says;
    } cases[] = {
        {1, "mm", "did you mean m?"},    {3000, "m", "did you mean mm?"},
        {100, "um", "did you mean mm?"}, {20, "um", "did you mean cm?"},
        {1e6, "m", "did you mean um?"},  {1e8, "m", "is that its unit?"},
    };
    (void)state;
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        struct bytes request = {0};
        double a = cases[k].side;
        bytes_format(&request,
                     "{\"surface\":{\"degree_u\":1,\"degree_v\":1,\"size_u\":2,\"size_v\":2,"
                     "\"knotvector_u\":[0,0,1,1],\"knotvector_v\":[0,0,1,1],\"control_points\":"
                     "[[0,0,0],[0,%g,0],[%g,0,0],[%g,%g,0]]},\"length_unit\":\"%s\","
                     "\"fabric\":{\"spacing\":%g}}",
                     a, a, a, a, cases[k].unit, a / 10);
        const struct api_warning *warning = warning_of(request.data, "size", &columns);
        assert_non_null(warning);
        if (!strstr(warning->detail, cases[k].says))
            fail_msg("%g %s: %s", a, cases[k].unit, warning->detail);
        bytes_free(&request);
    }
}

/* A spacing larger than the part is refused, and the one proposed makes cells: of a plane, of a
 * strip that is narrower than what its area would have, of triangles. */
static void test_run_proposes_a_spacing_that_makes_cells(void **state) {
    static const char *const parts[] = {
        PLANE,
        "{\"degree_u\":1,\"degree_v\":1,\"size_u\":2,\"size_v\":2,\"knotvector_u\":[0,0,1,1],"
        "\"knotvector_v\":[0,0,1,1],\"control_points\":[[0,0,0],[0,0.1,0],[90,0,0],[90,0.1,0]]}",
        "{\"vertices\":[[0,0,0],[1,0,0],[1,1,0.2],[0,1,0]],\"triangles\":[[0,1,2],[0,2,3]]}"};
    (void)state;
    for (size_t k = 0; k < sizeof parts / sizeof *parts; k++) {
        struct bytes request = {0}, container = {0};
        struct api_problem problem;
        static struct api_columns columns;
        double spacing;
        bytes_format(&request, "{\"surface\":%s,\"fabric\":{\"spacing\":5000}}", parts[k]);
        assert_int_equal(run_text(request.data, &container, &problem), API_INVALID_REQUEST);
        assert_string_equal(problem.error[0].pointer, "/fabric/spacing");
        const char *told = strstr(problem.error[0].detail, "a spacing of ");
        assert_non_null(told);
        assert_int_equal(sscanf(told, "a spacing of %lf", &spacing), 1);
        bytes_free(&request);
        bytes_free(&container);
        request = (struct bytes){0};
        bytes_format(&request, "{\"surface\":%s,\"fabric\":{\"spacing\":%g}}", parts[k], spacing);
        assert_null(warning_of(request.data, "coarse", &columns));
        check_at_least(columns.summary.cells, 81);
        bytes_free(&request);
    }
}

/* Round a flat ring by more than a turn some of the cloth would be needed twice. */
static void test_warnings_tell_of_cloth_that_overlaps(void **state) {
    static struct api_columns columns;
    static const double cosines[] = {1, 0, -1, 0}, sines[] = {0, 1, 0, -1};
    (void)state;
    for (int quarters = 3; quarters <= 5; quarters += 2) {
        struct bytes request = {0};
        bytes_format(&request,
                     "{\"surface\":{\"degree_u\":2,\"degree_v\":1,\"size_u\":%d,\"size_v\":2,"
                     "\"knotvector_v\":[0,0,1,1],\"knotvector_u\":[0,0,0",
                     2 * quarters + 1);
        for (int k = 1; k < quarters; k++)
            bytes_format(&request, ",%d,%d", k, k);
        bytes_format(&request, ",%d,%d,%d],\"control_points\":{\"points\":[", quarters, quarters,
                     quarters);
        for (int k = 0; k <= 2 * quarters; k++)
            for (int side = 1; side <= 2; side++) {
                double x = cosines[k / 2 % 4], y = sines[k / 2 % 4];
                if (k % 2) {
                    x += cosines[(k / 2 + 1) % 4];
                    y += sines[(k / 2 + 1) % 4];
                }
                bytes_format(&request, "%s[%g,%g,0]", 2 * k + side > 1 ? "," : "", side * x,
                             side * y);
            }
        bytes_format(&request, "],\"weights\":[");
        for (int k = 0; k <= 2 * quarters; k++)
            for (int side = 1; side <= 2; side++)
                bytes_format(&request, "%s%.17g", 2 * k + side > 1 ? "," : "",
                             k % 2 ? 0.70710678118654752 : 1.0);
        bytes_format(&request, "]}},\"fabric\":{\"spacing\":0.1}}");
        const struct api_warning *warning = warning_of(request.data, "overlap", &columns);
        if (warning)
            printf("  %s\n", warning->detail);
        assert_int_equal(warning != NULL, quarters > 4);
        bytes_free(&request);
    }
}

static int prepare_once(void **state) {
    (void)state;
    prepare();
    return 0;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_warnings_come_when_they_should),
        cmocka_unit_test(test_warnings_do_not_come_needlessly),
        cmocka_unit_test(test_warnings_of_size_name_the_unit_that_is_likely),
        cmocka_unit_test(test_run_proposes_a_spacing_that_makes_cells),
        cmocka_unit_test(test_warnings_tell_of_cloth_that_overlaps),
    };
    return cmocka_run_group_tests(tests, prepare_once, NULL);
}
