/* SPDX-License-Identifier: MIT */
#include "api/map/channel.h"

#include "api/map/map.h"
#include "own_arena.h"
#include "support.h"
#include "tests/check.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* A sheet of 10 by 10 with a square hole of 4 by 4 in its middle. */
enum { SIDE = 40, COUNT = SIDE * SIDE };

static struct vec3 points[(SIDE + 1) * (SIDE + 1)];
static int32_t quads[COUNT][4];

static struct map_target make_mesh(void) {
    for (int j = 0; j <= SIDE; j++)
        for (int i = 0; i <= SIDE; i++)
            points[j * (SIDE + 1) + i] = vec3_make(10.0 * i / SIDE, 10.0 * j / SIDE, 0);
    for (int32_t k = 0; k < COUNT; k++) {
        int32_t first = k / SIDE * (SIDE + 1) + k % SIDE;
        const int32_t corners[4] = {first, first + 1, first + SIDE + 2, first + SIDE + 1};
        memcpy(quads[k], corners, sizeof corners);
    }
    return (struct map_target){.vertices = points,
                               .vertex_count = sizeof points / sizeof *points,
                               .elements = (const int32_t(*)[4])quads,
                               .element_count = COUNT};
}

/* The distance of a place in the sheet from its outer edge or that of its hole. */
static double distance_from_edge(double x, double y) {
    double outer = 5 - fmax(fabs(x - 5), fabs(y - 5));
    double dx = fmax(fabs(x - 5) - 2, 0), dy = fmax(fabs(y - 5) - 2, 0);
    double within = 2 - fmax(fabs(x - 5), fabs(y - 5));
    return fmin(outer, within > 0 ? within : hypot(dx, dy));
}

static enum api_problem_id map(struct map_target *mesh, struct bytes *container,
                               struct api_map *map) {
    struct api_reader reader = reader_over(container);
    struct api_problem problem = {0};
    return api_map_make(&reader, mesh, NULL, arena, map, &problem);
}

static bool option(struct map_target *mesh, const char *name, const char *value) {
    struct api_problem problem = {0};
    return map_target_option(mesh, name, value, arena, &problem);
}

static bool warned(const struct api_map *map, const char *text) {
    bool found = false;
    for (size_t k = 0; k < map->fields.warning_count; k++)
        found = found || strstr(map->fields.warnings[k], text);
    return found;
}

/* All elements whose middle is near to an edge, of the hole as well, but for the inlet. */
static void test_channel_follows_every_rim(void **state) {
    (void)state;
    static struct api_map mapped;
    static const double widths[] = {0.3, 0.7, 1.1, 20};
    struct bytes container = {0};
    struct api_problem problem = {0};
    assert_int_equal(run_text(request_text("sheet_with_hole"), &container, &problem), API_OK);
    for (size_t w = 0; w < sizeof widths / sizeof *widths; w++) {
        struct map_target mesh = make_mesh();
        char text[32];
        size_t wrong = 0;
        snprintf(text, sizeof text, "%g,2e-8", widths[w]);
        assert_true(option(&mesh, "edge_channel", text));
        assert_true(option(&mesh, "inlet", "0"));
        assert_int_equal(map(&mesh, &container, &mapped), API_OK);
        assert_true(mapped.fields.channel_permeability == 2e-8);
        assert_int_equal(mapped.fields.roles[0], MAP_INLET);
        for (size_t k = 1; k < COUNT; k++) {
            struct vec3 at = map_target_point(&mesh, k);
            bool near = distance_from_edge(at.x, at.y) <= widths[w];
            wrong += mapped.fields.roles[k] != (near ? MAP_CHANNEL : MAP_FABRIC);
        }
        check_at_most((double)wrong, 0);
        assert_false(warned(&mapped, "no element"));
        assert_true(warned(&mapped, "the request has no permeability"));
    }
    bytes_free(&container);
}

static double value_at(const struct api_map *map, const char *name, size_t row) {
    const struct map_fields *fields = &map->fields;
    double value = NAN;
    for (size_t k = 0; k < fields->column_count; k++)
        if (strcmp(fields->columns[k].name, name) == 0)
            fields->columns[k].fill(fields->columns[k].context, row, 1, &value);
    return value;
}

/* Every format has the columns: the channel's permeability is there, and elsewhere the cloth's. */
static void test_channel_is_in_the_columns(void **state) {
    (void)state;
    static struct api_map mapped;
    static const char *const names[] = {"k1", "k2", "k3", "kxx", "kyy", "kzz", "kxy", "kyz", "kxz"};
    struct bytes container = {0};
    char text[2048];
    struct map_target mesh = make_mesh();
    const char *request = request_text("sheet_with_hole");
    snprintf(text, sizeof text, "%.*s,%s}", (int)strlen(request) - 1, request,
             "\"permeability\":{\"model\":\"table\",\"shear_deg\":[0,50],\"k1\":[3e-10,3e-10],"
             "\"k2\":[2e-10,2e-10],\"k3\":[1e-11,1e-11]}");
    assert_int_equal(run_text(text, &container, &(struct api_problem){0}), API_OK);
    assert_true(option(&mesh, "edge_channel", "0.7,2e-8"));
    assert_true(option(&mesh, "outlet", "sphere:5:0.1:0:0.3"));
    assert_int_equal(map(&mesh, &container, &mapped), API_OK);
    assert_false(warned(&mapped, "edge_channel"));
    size_t roles[MAP_ROLES] = {0}, wrong = 0;
    for (size_t e = 0; e < COUNT; e++) {
        bool channel = mesh.roles[e] == MAP_CHANNEL;
        roles[mesh.roles[e]]++;
        wrong += value_at(&mapped, "role", e) != mesh.roles[e];
        for (size_t n = 0; n < sizeof names / sizeof *names; n++) {
            static const double cloth[] = {3e-10, 2e-10, 1e-11}, own[] = {2e-8, 2e-8, 2e-8};
            double value = value_at(&mapped, names[n], e);
            if (n < 3)
                wrong += fabs(value / (channel ? own : cloth)[n] - 1) > 1e-9;
            else if (channel)
                wrong += value != (n < 6 ? 2e-8 : 0);
        }
    }
    check_at_most((double)wrong, 0);
    assert_true(roles[MAP_CHANNEL] > 100 && roles[MAP_OUTLET] > 1 && roles[MAP_FABRIC] > 100);
    bytes_free(&container);
}

static void test_channel_nowhere_is_said(void **state) {
    (void)state;
    static struct api_map mapped;
    struct bytes container = {0};
    struct api_problem problem = {0};
    assert_int_equal(run_text(request_text("sheet_with_hole"), &container, &problem), API_OK);
    struct map_target mesh = make_mesh();
    assert_true(option(&mesh, "edge_channel", "0.001,1e-8"));
    assert_int_equal(map(&mesh, &container, &mapped), API_OK);
    assert_true(warned(&mapped, "no element"));
    bytes_free(&container);
}

static void test_channel_of_bad_numbers_is_a_problem(void **state) {
    (void)state;
    static const char *const texts[] = {"",    "1",     "1,",       "1,0",   "0,1e-8", "-1,1e-8",
                                        "1;2", "1,2,3", "nan,1e-8", "1,inf", "1e-8",   "a,b"};
    for (size_t k = 0; k < sizeof texts / sizeof *texts; k++) {
        struct map_target mesh = make_mesh();
        assert_false(option(&mesh, "edge_channel", texts[k]));
    }
    struct map_target mesh = make_mesh();
    mesh.elements = NULL;
    assert_false(option(&mesh, "edge_channel", "1,1e-8"));
    mesh = make_mesh();
    assert_true(option(&mesh, "edge_channel", "1,1e-8"));
    assert_false(option(&mesh, "edge_channel", "1,1e-8"));
}

/* The middles of elements are at odd multiples of 0.125. */
static void test_gates_by_place(void **state) {
    (void)state;
    static const struct {
        const char *list;
        size_t count;
    } cases[] = {{"sphere:0.125:0.125:0:0.1", 1},
                 {"sphere:0.125:0.125:0:0.25", 3},
                 {"line:0:0.125:0:10:0.125:0:0.01", SIDE},
                 {"line:0:0.125:0:1:0.125:0:0.2", 5},
                 {"7,sphere:9.875:9.875:1:1,line:5:0:0:5:10:0:0.13", 2 + 2 * SIDE}};
    static const char *const bad[] = {"sphere:1:2:3",     "sphere:1:2:3:0",   "sphere:50:50:0:1",
                                      "sphere:1:2:3:4:5", "line:1:2:3:4:5:6", "line:1:2:3:4:5:6:-1",
                                      "sphere:a:b:c:d",   "ball:1:2:3:4",     "sphere:1:2:3:1,"};
    for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
        struct map_target mesh = make_mesh();
        size_t count = 0;
        assert_true(option(&mesh, "outlet", cases[c].list));
        for (size_t k = 0; k < COUNT; k++)
            count += mesh.roles[k] == MAP_OUTLET;
        assert_int_equal(count, cases[c].count);
    }
    for (size_t c = 0; c < sizeof bad / sizeof *bad; c++) {
        struct map_target mesh = make_mesh();
        assert_false(option(&mesh, "inlet", bad[c]));
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_channel_follows_every_rim),
        cmocka_unit_test(test_channel_is_in_the_columns),
        cmocka_unit_test(test_channel_nowhere_is_said),
        cmocka_unit_test(test_channel_of_bad_numbers_is_a_problem),
        cmocka_unit_test(test_gates_by_place),
    };
    return cmocka_run_group_tests_name("map_channel", tests, set_up, tear_down);
}
