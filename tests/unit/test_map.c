/* SPDX-License-Identifier: MIT */
#include "api/map/map.h"
#include "api/map/map_columns.h"

#include "cloth.h"
#include "own_arena.h"
#include "solver/permeability.h"
#include "tests/check.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

/* ---- cloth ---- */

static struct vec3 flat(double i, double j) {
    return vec3_make(i, j, 0);
}

/* A trellis sheared by 30 degrees. */
static struct vec3 sheared(double i, double j) {
    return vec3_make(i + 0.5 * j, sqrt(0.75) * j, 0);
}

static struct vec3 bent(double i, double j) {
    return vec3_make(i + 0.1 * sin(j), 0.9 * j + 0.1 * cos(2 * i), sin(0.4 * i) * cos(0.3 * j));
}

static struct vec3 rolled(double i, double j) {
    return vec3_make(4 * cos(0.2 * i), 4 * sin(0.2 * i), j);
}

static bool with_hole(int i, int j) {
    return i != 4 || j < 3 || j > 5;
}

/* The permeability of a cell: k1 at `degrees` from warp, away from it towards weft. */
static void set_permeability(double *fields, double k1, double k2, double k3, double degrees) {
    struct vec3 warp =
        vec3_make(fields[CLOTH_WARP], fields[CLOTH_WARP + 1], fields[CLOTH_WARP + 2]);
    struct vec3 weft =
        vec3_make(fields[CLOTH_WEFT], fields[CLOTH_WEFT + 1], fields[CLOTH_WEFT + 2]);
    const struct permeability k = {.along = cos(degrees * pi / 180),
                                   .across = sin(degrees * pi / 180)};
    struct vec3 direction = permeability_direction(&k, warp, weft);
    const double values[] = {k1, k2, k3, direction.x, direction.y, direction.z};
    memcpy(fields + CLOTH_K1, values, sizeof values);
}

/* Fields that differ from cell to cell, all within a ratio of three. */
static void set_random_fields(struct cloth *cloth, struct random *random) {
    for (size_t cell = 0; cell < cloth->cell_count; cell++) {
        double *fields = cloth->fields[cell];
        fields[CLOTH_SHEAR] = random_between(random, -30, 30);
        fields[CLOTH_THICKNESS] = random_between(random, 0.001, 0.002);
        fields[CLOTH_LOCKED] = random_index(random, 2);
        set_permeability(fields, random_between(random, 2e-10, 3e-10),
                         random_between(random, 1e-10, 2e-10), random_between(random, 1e-12, 2e-12),
                         random_between(random, -80, 80));
    }
}

/* ---- maps ---- */

struct mapped {
    struct bytes container;
    struct api_reader reader;
    struct map_target mesh;
    struct api_map map;
    struct api_problem problem;
    enum api_problem_id result;
};

static struct mapped *map_mesh_onto(const struct cloth *cloth, struct map_target mesh) {
    struct mapped *mapped = calloc(1, sizeof *mapped);
    assert_non_null(mapped);
    mapped->container = cloth_result(cloth);
    mapped->reader = reader_over(&mapped->container);
    mapped->mesh = mesh;
    mapped->result =
        api_map_make(&mapped->reader, &mapped->mesh, NULL, arena, &mapped->map, &mapped->problem);
    assert_int_equal(mapped->result, API_OK);
    return mapped;
}

static struct mapped *map_points(const struct cloth *cloth, const struct vec3 *points,
                                 size_t count) {
    return map_mesh_onto(
        cloth,
        (struct map_target){.vertices = points, .vertex_count = count, .element_count = count});
}

static void mapped_free(struct mapped *mapped) {
    bytes_free(&mapped->container);
    free(mapped);
}

static double value_at(const struct mapped *mapped, const char *name, size_t row) {
    const struct map_fields *fields = &mapped->map.fields;
    for (size_t k = 0; k < fields->column_count; k++) {
        double value;
        if (strcmp(fields->columns[k].name, name) != 0)
            continue;
        assert_int_equal(fields->columns[k].rows, fields->element_count);
        fields->columns[k].fill(fields->columns[k].context, row, 1, &value);
        return value;
    }
    fail_msg("there is no column %s", name);
    return 0;
}

static void assert_near(double value, double expected, double tolerance) {
    if (!(fabs(value - expected) <= tolerance))
        fail_msg("%.17g is not %.17g", value, expected);
}

static struct vec3 vector_at(const struct mapped *mapped, const char *base, size_t row) {
    char name[3][16];
    for (int k = 0; k < 3; k++)
        snprintf(name[k], sizeof name[k], "%s_%c", base, "xyz"[k]);
    return vec3_make(value_at(mapped, name[0], row), value_at(mapped, name[1], row),
                     value_at(mapped, name[2], row));
}

struct tensor {
    double m[3][3];
};

static struct tensor tensor_at(const struct mapped *mapped, size_t row) {
    static const char *const names[3][3] = {
        {"kxx", "kxy", "kxz"}, {"kxy", "kyy", "kyz"}, {"kxz", "kyz", "kzz"}};
    struct tensor tensor;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            tensor.m[i][j] = value_at(mapped, names[i][j], row);
    return tensor;
}

static double quadratic(const struct tensor *k, struct vec3 a, struct vec3 b) {
    const double u[3] = {a.x, a.y, a.z}, v[3] = {b.x, b.y, b.z};
    double sum = 0;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            sum += u[i] * k->m[i][j] * v[j];
    return sum;
}

/* ---- fields ---- */

static void test_map_gives_a_cell_back_at_its_middle(void **state) {
    (void)state;
    struct random random = random_begin("middle");
    struct cloth cloth = cloth_make(9, 8, bent, with_hole);
    set_random_fields(&cloth, &random);
    struct vec3 *points = calloc(cloth.cell_count, sizeof *points);
    for (size_t k = 0; k < cloth.cell_count; k++)
        points[k] = cloth_middle(&cloth, k);
    struct mapped *mapped = map_points(&cloth, points, cloth.cell_count);
    static const char *const names[CLOTH_FIELDS] = {
        "i",      "j",  "shear_deg", "thickness", "warp_x", "warp_y", "warp_z", "weft_x", "weft_y",
        "weft_z", "k1", "k2",        "k3",        "k1_x",   "k1_y",   "k1_z",   "locked"};
    for (size_t row = 0; row < cloth.cell_count; row++) {
        for (int k = 0; k < CLOTH_FIELDS; k++) {
            double expected = cloth.fields[row][k];
            /* A direction is worth the difference of the permeabilities that it parts. */
            double tolerance = k >= CLOTH_K1_DIRECTION && k < CLOTH_LOCKED ? 1e-8 : 1e-12;
            assert_near(value_at(mapped, names[k], row), expected,
                        tolerance * fmax(k == CLOTH_SHEAR ? 30 : 1e-3, fabs(expected)));
        }
        assert_near(value_at(mapped, "distance", row), 0, 1e-14);
        assert_true(value_at(mapped, "extrapolated", row) == 0);
        assert_true(value_at(mapped, "id", row) == (double)row);
    }
    assert_int_equal(mapped->map.fields.warning_count, 0);
    mapped_free(mapped);
    free(points);
    cloth_free(&cloth);
}

static void test_map_keeps_what_is_the_same_everywhere(void **state) {
    (void)state;
    struct random random = random_begin("same");
    struct cloth cloth = cloth_make(9, 8, sheared, with_hole);
    for (size_t k = 0; k < cloth.cell_count; k++) {
        cloth.fields[k][CLOTH_SHEAR] = 30;
        cloth.fields[k][CLOTH_THICKNESS] = 0.25;
        set_permeability(cloth.fields[k], 3e-10, 1e-10, 1e-12, 30);
    }
    struct vec3 points[200];
    for (size_t k = 0; k < 200; k++)
        points[k] =
            vec3_make(random_between(&random, -3, 15), random_between(&random, -3, 10), 0.01);
    struct mapped *mapped = map_points(&cloth, points, 200);
    for (size_t row = 0; row < 200; row++) {
        struct vec3 direction = vector_at(mapped, "k1", row);
        assert_near(value_at(mapped, "shear_deg", row), 30, 1e-13);
        assert_near(value_at(mapped, "thickness", row), 0.25, 1e-15);
        assert_near(value_at(mapped, "k1", row), 3e-10, 1e-24);
        assert_near(value_at(mapped, "k2", row), 1e-10, 1e-24);
        assert_near(value_at(mapped, "k3", row), 1e-12, 1e-26);
        assert_near(vec3_distance(direction, vec3_make(sqrt(0.75), 0.5, 0)), 0, 1e-13);
        assert_near(vec3_distance(vector_at(mapped, "weft", row), vec3_make(0.5, sqrt(0.75), 0)), 0,
                    1e-14);
        assert_near(value_at(mapped, "kxx", row), 2.5e-10, 1e-23); /* 3 cos^2 30 + sin^2 30 */
        assert_near(value_at(mapped, "kyy", row), 1.5e-10, 1e-23);
        assert_near(value_at(mapped, "kxy", row), sqrt(0.75) * 1e-10, 1e-23);
        assert_near(value_at(mapped, "kzz", row), 1e-12, 1e-25);
        assert_near(value_at(mapped, "kyz", row), 0, 1e-25);
    }
    mapped_free(mapped);
    cloth_free(&cloth);
}

static void test_map_is_exact_for_what_is_linear_within_the_net(void **state) {
    (void)state;
    struct random random = random_begin("linear");
    struct cloth cloth = cloth_make(9, 8, sheared, NULL);
    for (size_t k = 0; k < cloth.cell_count; k++) {
        struct vec3 r = cloth_middle(&cloth, k);
        cloth.fields[k][CLOTH_SHEAR] = 3 * r.x - 2 * r.y + 1;
        cloth.fields[k][CLOTH_THICKNESS] = 0.1 + 0.01 * r.x;
    }
    struct vec3 points[200];
    for (size_t k = 0; k < 200; k++) {
        points[k] = sheared(random_between(&random, 1, 8), random_between(&random, 1, 7));
        points[k].z = random_between(&random, -0.2, 0.2);
    }
    struct mapped *mapped = map_points(&cloth, points, 200);
    for (size_t row = 0; row < 200; row++) {
        assert_near(value_at(mapped, "shear_deg", row), 3 * points[row].x - 2 * points[row].y + 1,
                    1e-12);
        assert_near(value_at(mapped, "thickness", row), 0.1 + 0.01 * points[row].x, 1e-14);
        assert_near(value_at(mapped, "distance", row), fabs(points[row].z), 1e-14);
    }
    mapped_free(mapped);
    cloth_free(&cloth);
}

/* Places of the cloth a hair to both sides of a corner, an edge or a facet's edge. */
static void test_map_is_continuous_over_the_net(void **state) {
    (void)state;
    struct random random = random_begin("continuous");
    struct cloth cloth = cloth_make(9, 8, bent, with_hole);
    set_random_fields(&cloth, &random);
    enum { PAIRS = 300 };
    static struct vec3 points[2 * PAIRS];
    for (size_t k = 0; k < PAIRS; k++) {
        size_t cell = (size_t)random_index(&random, (int)cloth.cell_count);
        const int32_t *corner = cloth.corners[cell];
        struct vec3 a = cloth.nodes[corner[random_index(&random, 4)]], b = a;
        if (k % 3)
            b = k % 3 == 1 ? cloth.nodes[corner[random_index(&random, 4)]]
                           : cloth_middle(&cloth, cell);
        double t = random_between(&random, 0, 1);
        struct vec3 p = vec3_axpy(t, vec3_sub(b, a), a);
        struct vec3 step = vec3_make(random_between(&random, -1e-8, 1e-8),
                                     random_between(&random, -1e-8, 1e-8), 0);
        points[2 * k] = vec3_add(p, step);
        points[2 * k + 1] = vec3_sub(p, step);
    }
    struct mapped *mapped = map_points(&cloth, points, sizeof points / sizeof *points);
    for (size_t k = 0; k < PAIRS; k++) {
        struct tensor a = tensor_at(mapped, 2 * k), b = tensor_at(mapped, 2 * k + 1);
        assert_near(value_at(mapped, "shear_deg", 2 * k), value_at(mapped, "shear_deg", 2 * k + 1),
                    1e-5);
        assert_near(
            vec3_distance(vector_at(mapped, "warp", 2 * k), vector_at(mapped, "warp", 2 * k + 1)),
            0, 1e-6);
        for (int i = 0; i < 9; i++)
            assert_near(a.m[i / 3][i % 3], b.m[i / 3][i % 3], 1e-16);
    }
    mapped_free(mapped);
    cloth_free(&cloth);
}

/* ---- the tensor ---- */

static void test_map_tensor_is_positive_and_that_of_its_columns(void **state) {
    (void)state;
    struct random random = random_begin("positive");
    struct cloth cloth = cloth_make(9, 8, bent, with_hole);
    set_random_fields(&cloth, &random);
    for (size_t k = 0; k < cloth.cell_count; k++) /* some nearly singular ones */
        if (k % 3 == 0)
            set_permeability(cloth.fields[k], 3e-10, 1e-17, 1e-18,
                             random_between(&random, -90, 90));
    struct vec3 points[300];
    for (size_t k = 0; k < 300; k++)
        points[k] = vec3_make(random_between(&random, -1, 10), random_between(&random, -1, 8),
                              random_between(&random, -1, 1));
    struct mapped *mapped = map_points(&cloth, points, 300);
    for (size_t row = 0; row < 300; row++) {
        struct tensor k = tensor_at(mapped, row);
        struct vec3 warp = vector_at(mapped, "warp", row), weft = vector_at(mapped, "weft", row);
        struct vec3 first = vector_at(mapped, "k1", row),
                    normal = vec3_unit(vec3_cross(warp, weft));
        double k1 = value_at(mapped, "k1", row), k2 = value_at(mapped, "k2", row);
        double k3 = value_at(mapped, "k3", row);
        check_at_least(k1, k2);
        check_above(k2, 0);
        check_above(k3, 0);
        assert_near(vec3_norm(first), 1, 1e-14);
        assert_near(vec3_dot(first, normal), 0, 1e-14);
        assert_near(quadratic(&k, first, first), k1, 1e-14 * k1);
        assert_near(quadratic(&k, normal, normal), k3, 1e-14 * k1);
        assert_near(k.m[0][0] + k.m[1][1] + k.m[2][2], k1 + k2 + k3, 1e-14 * k1);
        for (int trial = 0; trial < 10; trial++) {
            struct vec3 v =
                vec3_make(random_between(&random, -1, 1), random_between(&random, -1, 1),
                          random_between(&random, -1, 1));
            check_above(quadratic(&k, v, v), -1e-15 * k1);
        }
    }
    mapped_free(mapped);
    cloth_free(&cloth);
}

/* On a roll whose cells are all alike, the map is too, whichever way it faces. */
static void test_map_tensor_turns_with_the_cloth(void **state) {
    (void)state;
    struct random random = random_begin("turns");
    struct cloth cloth = cloth_make(20, 8, rolled, NULL);
    for (size_t k = 0; k < cloth.cell_count; k++)
        set_permeability(cloth.fields[k], 3e-10, 1e-10, 1e-12, 25);
    struct vec3 points[200];
    for (size_t k = 0; k < 200; k++)
        points[k] = rolled(random_between(&random, 0, 20), random_between(&random, 0, 8));
    struct mapped *mapped = map_points(&cloth, points, 200);
    for (size_t row = 0; row < 200; row++) {
        struct vec3 warp = vector_at(mapped, "warp", row), weft = vector_at(mapped, "weft", row);
        struct vec3 first = vector_at(mapped, "k1", row);
        assert_near(value_at(mapped, "k1", row), 3e-10, 1e-23);
        assert_near(value_at(mapped, "k2", row), 1e-10, 1e-23);
        assert_near(vec3_dot(first, warp), cos(25 * pi / 180), 1e-12);
        assert_near(vec3_dot(first, weft), sin(25 * pi / 180), 1e-12);
        assert_near(warp.z, 0, 1e-14);
    }
    mapped_free(mapped);
    cloth_free(&cloth);
}

static struct vec3 turn(double r[3][3], struct vec3 v) {
    return vec3_make(r[0][0] * v.x + r[0][1] * v.y + r[0][2] * v.z,
                     r[1][0] * v.x + r[1][1] * v.y + r[1][2] * v.z,
                     r[2][0] * v.x + r[2][1] * v.y + r[2][2] * v.z);
}

static void make_rotation(struct random *random, double r[3][3]) {
    struct vec3 a =
        vec3_unit(vec3_make(random_between(random, -1, 1), random_between(random, -1, 1),
                            random_between(random, 0.1, 1)));
    struct vec3 b = vec3_unit(vec3_cross(a, vec3_make(1, random_between(random, -1, 1), 0)));
    struct vec3 c = vec3_cross(a, b);
    const double rows[3][3] = {{a.x, a.y, a.z}, {b.x, b.y, b.z}, {c.x, c.y, c.z}};
    memcpy(r, rows, sizeof rows);
}

static void turn_cloth(struct cloth *cloth, double r[3][3]) {
    static const int vectors[] = {CLOTH_WARP, CLOTH_WEFT, CLOTH_K1_DIRECTION};
    for (size_t k = 0; k < cloth->node_count; k++)
        cloth->nodes[k] = turn(r, cloth->nodes[k]);
    for (size_t k = 0; k < cloth->cell_count; k++) {
        for (int v = 0; v < 3; v++) {
            double *own = cloth->fields[k] + vectors[v];
            struct vec3 turned = turn(r, vec3_make(own[0], own[1], own[2]));
            memcpy(own, &turned, sizeof turned);
        }
    }
}

static void test_map_of_all_turned_is_the_map_turned(void **state) {
    (void)state;
    struct random random = random_begin("rotation");
    struct cloth cloth = cloth_make(9, 8, bent, with_hole);
    set_random_fields(&cloth, &random);
    struct vec3 points[100], turned[100];
    double r[3][3];
    make_rotation(&random, r);
    for (size_t k = 0; k < 100; k++) {
        points[k] = vec3_make(random_between(&random, -1, 10), random_between(&random, -1, 8),
                              random_between(&random, -1, 1));
        turned[k] = turn(r, points[k]);
    }
    struct mapped *before = map_points(&cloth, points, 100);
    turn_cloth(&cloth, r);
    struct mapped *after = map_points(&cloth, turned, 100);
    for (size_t row = 0; row < 100; row++) {
        static const char *const scalars[] = {"shear_deg", "distance", "extrapolated"};
        for (size_t k = 0; k < sizeof scalars / sizeof *scalars; k++)
            assert_near(value_at(after, scalars[k], row), value_at(before, scalars[k], row), 1e-11);
        /* At an edge that two cells share both are as near, and rounding chooses. */
        assert_near(value_at(after, "i", row), value_at(before, "i", row), 1);
        assert_near(value_at(after, "j", row), value_at(before, "j", row), 1);
        assert_near(value_at(after, "k1", row), value_at(before, "k1", row), 1e-21);
        assert_near(value_at(after, "k2", row), value_at(before, "k2", row), 1e-21);
        assert_near(
            vec3_distance(vector_at(after, "warp", row), turn(r, vector_at(before, "warp", row))),
            0, 1e-11);
        struct tensor a = tensor_at(after, row), b = tensor_at(before, row);
        for (int k = 0; k < 3; k++) {
            const struct vec3 axis[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
            assert_near(quadratic(&a, turn(r, axis[k]), turn(r, axis[(k + 1) % 3])),
                        quadratic(&b, axis[k], axis[(k + 1) % 3]), 1e-21);
        }
    }
    mapped_free(before);
    mapped_free(after);
    cloth_free(&cloth);
}

/* ---- plies ---- */

/* Two elements on a cloth sheared by 30 degrees, the second flipped, and one beyond it. */
static void test_map_lays_the_drape_as_one_ply(void **state) {
    (void)state;
    struct cloth cloth = cloth_make(4, 4, sheared, NULL);
    for (size_t k = 0; k < cloth.cell_count; k++) {
        cloth.fields[k][CLOTH_SHEAR] = 30;
        cloth.fields[k][CLOTH_THICKNESS] = 0.002;
    }
    static const struct vec3 vertices[] = {{2, 1, 0}, {2, 2, 0}, {3, 1, 0}, {12, 1, 0}};
    static const int32_t elements[][4] = {{2, 3, 1, -1}, {0, 2, 1, -1}, {0, 1, 2, -1}};
    static const int32_t ids[] = {9, 17, 4};
    struct mapped *mapped = map_mesh_onto(&cloth, (struct map_target){.vertices = vertices,
                                                                      .vertex_count = 4,
                                                                      .elements = elements,
                                                                      .element_count = 3,
                                                                      .ids = ids});
    const struct map_plies *plies = mapped->map.fields.plies;
    static const double angle[] = {0, 90}, weft[] = {60, 30};
    assert_int_equal(plies->row_count, 2);
    assert_true(plies->first[1] == 0 && plies->first[2] == 1 && plies->first[3] == 2);
    for (size_t k = 0; k < 2; k++) {
        const struct map_ply_row *row = &plies->rows[k];
        assert_int_equal(row->element, k + 1);
        assert_int_equal(row->mirrored, k == 1);
        assert_near(row->angle_deg, angle[k], 1e-12);
        assert_near(element_weft_deg(row), weft[k], 1e-12);
        assert_near(row->thickness, 0.002, 1e-15);
    }
    assert_non_null(strstr(mapped->map.fields.warnings[0], "1 of 3 elements have no ply"));
    static const char *const names[] = {"element", "ply", "angle_deg", "shear_deg", "thickness"};
    static const double values[][2] = {{17, 4}, {1, 1}, {0, 90}, {30, 30}, {0.002, 0.002}};
    const struct api_column_source *own = &mapped->map.fields.columns[0];
    while (own->table != API_TABLE_PLIES)
        own++;
    assert_ptr_equal(own + 5, &mapped->map.fields.columns[mapped->map.fields.column_count]);
    for (int k = 0; k < 5; k++, own++) {
        double both[2];
        assert_string_equal(own->name, names[k]);
        assert_true(own->fill(own->context, 0, 2, both));
        assert_near(both[0], values[k][0], 1e-12);
        assert_near(both[1], values[k][1], 1e-12);
    }
    mapped_free(mapped);
    cloth_free(&cloth);
}

/* ---- cavities ---- */

/* Cloth of 2 mm, half of it fibres, that lies flat and says that it is 2.1 mm thick. */
static struct cloth make_lying(struct api_request *request) {
    struct cloth cloth = cloth_make(4, 4, flat, NULL);
    for (size_t k = 0; k < cloth.cell_count; k++)
        cloth.fields[k][CLOTH_THICKNESS] = 0.0021;
    *request = (struct api_request){
        .fabric = {.thickness = 0.002, .plies = 1, .fiber_volume_fraction = 0.5},
        .permeability = {.model = API_PERMEABILITY_NONE},
    };
    return cloth;
}

/* Where a height is given cloth has it, elsewhere its own, or that of a drape between rigid faces;
 * plies that are thinner are counted. */
static void test_map_presses_cloth_to_heights(void **state) {
    (void)state;
    static const struct vec3 points[] = {{1, 1, 0}, {2, 1, 0}, {3, 1, 0}, {9, 1, 0}};
    static const double heights[] = {0, 0.0015, 0.004, 0.004};
    for (int rigid = 0; rigid < 2; rigid++) {
        struct api_request request;
        struct cloth cloth = make_lying(&request);
        request.cavity.rigid = rigid;
        request.cavity.height = 0.001;
        struct mapped *mapped = map_mesh_onto(&cloth, (struct map_target){.vertices = points,
                                                                          .vertex_count = 4,
                                                                          .element_count = 4,
                                                                          .heights = heights,
                                                                          .cloth = &request});
        assert_near(value_at(mapped, "thickness", 0), rigid ? 0.001 : 0.0021, 1e-15);
        assert_near(value_at(mapped, "thickness", 1), 0.0015, 1e-15);
        assert_near(value_at(mapped, "thickness", 2), 0.004, 1e-15);
        assert_int_equal(mapped->map.fields.warning_count, 1);
        assert_non_null(strstr(mapped->map.fields.warnings[0],
                               "at 1 of 4 points the plies are thinner than the cavity"));
        mapped_free(mapped);
        cloth_free(&cloth);
    }
}

/* A punch over a half of the cloth: its height there, the cloth's own beside it, at every point. */
static void test_map_presses_cloth_under_a_punch(void **state) {
    (void)state;
    static const struct vec3 points[] = {{1, 1, 0}, {1, 3, 0}, {3, 1, 0}, {3, 3, 0}, {9, 1, 0}};
    static const struct vec3 corners[] = {
        {-1, -1, 0.0015}, {2, -1, 0.0015}, {2, 2, 0.0015}, {-1, 2, 0.0015}, {0.5, 5, 0.0015}};
    static const int32_t punch[][4] = {{0, 1, 2, 3}, {3, 2, 4, -1}};
    struct api_request request;
    struct cloth cloth = make_lying(&request);
    struct mapped *mapped = map_mesh_onto(&cloth, (struct map_target){.vertices = points,
                                                                      .vertex_count = 5,
                                                                      .element_count = 5,
                                                                      .punch_vertices = corners,
                                                                      .punch = punch,
                                                                      .punch_count = 2,
                                                                      .cloth = &request});
    assert_near(value_at(mapped, "thickness", 0), 0.0015, 1e-12);
    assert_near(value_at(mapped, "thickness", 1), 0.0015, 1e-12);
    assert_near(value_at(mapped, "thickness", 2), 0.0021, 1e-15);
    assert_int_equal(mapped->map.fields.warning_count, 1);
    assert_non_null(strstr(mapped->map.fields.warnings[0], "the punch is not above 2 of 5 points"));
    mapped_free(mapped);
    cloth_free(&cloth);
}

/* No more than there is room for; those that came first. */
static void test_map_keeps_its_first_warnings(void **state) {
    (void)state;
    static struct api_map map;
    for (int k = 0; k < MAP_WARNINGS_MAX + 2; k++) {
        map_warn_text(&map, k < MAP_WARNINGS_MAX ? "kept" : "too late");
        map_warn(&map, "number %d", k);
    }
    assert_int_equal(map.fields.warning_count, MAP_WARNINGS_MAX);
    for (int k = 0; k < MAP_WARNINGS_MAX; k += 2)
        assert_string_equal(map.fields.warnings[k], "kept");
    assert_string_equal(map.fields.warnings[MAP_WARNINGS_MAX - 1], "number 3");
    map_warn_text(&map, "too late");
    assert_int_equal(map.fields.warning_count, MAP_WARNINGS_MAX);
}

/* ---- places ---- */

static void test_map_tells_distance_and_what_is_extrapolated(void **state) {
    (void)state;
    struct cloth cloth = cloth_make(4, 4, flat, NULL);
    static const struct vec3 points[] = {{1.5, 1.5, 0}, {1.5, 1.5, 3}, {4, 2, 0},
                                         {4.5, 2, 0},   {-3, -4, 0},   {7, 2, 4}};
    static const double distance[] = {0, 3, 0, 0.5, 5, 5}, extrapolated[] = {0, 0, 0, 1, 1, 1};
    struct mapped *mapped = map_points(&cloth, points, 6);
    for (size_t row = 0; row < 6; row++) {
        assert_near(value_at(mapped, "distance", row), distance[row], 1e-14);
        assert_true(value_at(mapped, "extrapolated", row) == extrapolated[row]);
    }
    assert_int_equal(mapped->map.fields.warning_count, 0); /* half of them is not more than half */
    mapped_free(mapped);
    cloth_free(&cloth);
}

static void test_map_warns_when_more_than_half_is_far(void **state) {
    (void)state;
    struct cloth cloth = cloth_make(4, 4, flat, NULL);
    static const struct vec3 points[] = {{1.5, 1.5, 0}, {1.5, 1.5, 1.2}, {2, 2, 30}};
    struct mapped *mapped = map_points(&cloth, points, 3);
    assert_int_equal(mapped->map.fields.warning_count, 1);
    assert_non_null(strstr(mapped->map.fields.warnings[0], "2 of 3 points"));
    assert_non_null(strstr(mapped->map.fields.warnings[0], "30 m"));
    mapped_free(mapped);
    for (size_t k = 0; k < cloth.cell_count; k++)
        cloth.fields[k][CLOTH_THICKNESS] = 1.3; /* within the cloth */
    mapped = map_points(&cloth, points, 3);
    assert_int_equal(mapped->map.fields.warning_count, 0);
    mapped_free(mapped);
    cloth_free(&cloth);
}

static void test_map_takes_the_middles_of_elements_and_their_ids(void **state) {
    (void)state;
    struct cloth cloth = cloth_make(4, 4, flat, NULL);
    for (size_t k = 0; k < cloth.cell_count; k++)
        cloth.fields[k][CLOTH_SHEAR] = cloth_middle(&cloth, k).x;
    static const struct vec3 vertices[] = {{1, 1, 0}, {2, 1, 0}, {2, 2, 0}, {1, 2, 0}, {3, 1.5, 0}};
    static const int32_t elements[][4] = {{0, 1, 2, 3}, {1, 4, 2, -1}};
    static const int32_t ids[] = {501, 7};
    static uint8_t roles[] = {0, 1};
    struct mapped *mapped = map_mesh_onto(&cloth, (struct map_target){.vertices = vertices,
                                                                      .vertex_count = 5,
                                                                      .elements = elements,
                                                                      .element_count = 2,
                                                                      .ids = ids,
                                                                      .roles = roles});
    assert_true(value_at(mapped, "id", 0) == 501 && value_at(mapped, "id", 1) == 7);
    assert_near(value_at(mapped, "shear_deg", 0), 1.5, 1e-14);
    assert_near(value_at(mapped, "shear_deg", 1), 7 / 3.0, 1e-14);
    assert_ptr_equal(mapped->map.fields.roles, roles);
    mapped_free(mapped);
    cloth_free(&cloth);
}

/* The line of names of the map as CSV, "" when the fields are refused. */
static void selected_names(const struct mapped *mapped, const char *list, char names[512]) {
    struct api_problem problem = {0};
    const struct format_source source = {.fields = &mapped->map.fields};
    const struct format_options options = {.fields = list};
    struct encoder *encoder =
        encoder_new(format_named(FORMAT_MAP, "csv"), &source, &options, &problem);
    ssize_t length = encoder ? encoder_read(encoder, names, 511) : 0;
    check_at_least(length, 0);
    names[length] = '\0';
    names[strcspn(names, "\n")] = '\0';
    assert_int_equal(problem.id, encoder ? API_OK : API_INVALID_REQUEST);
    encoder_free(encoder);
}

static void test_map_selects_columns_in_their_own_order(void **state) {
    (void)state;
    struct cloth cloth = cloth_make(4, 4, flat, NULL);
    static const struct vec3 point = {1, 1, 0};
    struct mapped *mapped = map_points(&cloth, &point, 1);
    char all[512], names[512];
    size_t commas = 0;
    assert_int_equal(mapped->map.fields.column_count, CLOTH_FIELDS + 9);
    selected_names(mapped, NULL, all);
    for (const char *at = all; *at; at++)
        commas += *at == ',';
    assert_int_equal(commas, CLOTH_FIELDS + 8);
    selected_names(mapped, "", names);
    assert_string_equal(names, all);
    selected_names(mapped, "cells.k1,distance,id,k1", names);
    assert_string_equal(names, "id,k1,distance");
    static const char *const wrong[] = {"k4", "id,", ",id", "nodes.x", "cells.", "k"};
    for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++) {
        selected_names(mapped, wrong[k], names);
        assert_string_equal(names, "");
    }
    mapped_free(mapped);
    cloth_free(&cloth);
}

/* ---- what goes wrong ---- */

struct patience {
    int questions;
};

static bool ask(void *context, double fraction) {
    struct patience *patience = context;
    check_at_least(fraction, 0);
    check_at_most(fraction, 1);
    return patience->questions-- > 0;
}

static void test_map_stops_when_told_to(void **state) {
    (void)state;
    struct cloth cloth = cloth_make(4, 4, flat, NULL);
    struct bytes container = cloth_result(&cloth);
    struct api_reader reader = reader_over(&container);
    static struct vec3 points[3000];
    const struct map_target mesh = {
        .vertices = points, .vertex_count = 3000, .element_count = 3000};
    static struct api_map map;
    for (int questions = 0; questions < 4; questions++) {
        struct patience patience = {questions};
        const struct drape_monitor monitor = {ask, &patience};
        struct api_problem problem = {0};
        assert_int_equal(api_map_make(&reader, &mesh, &monitor, arena, &map, &problem),
                         API_CANCELLED);
        assert_int_equal(patience.questions, -1);
    }
    struct patience patience = {4};
    const struct drape_monitor monitor = {ask, &patience};
    struct api_problem problem = {0};
    assert_int_equal(api_map_make(&reader, &mesh, &monitor, arena, &map, &problem), API_OK);
    bytes_free(&container);
    cloth_free(&cloth);
}

static void test_map_without_memory_is_a_problem(void **state) {
    (void)state;
    struct cloth cloth = cloth_make(4, 4, flat, NULL);
    struct bytes container = cloth_result(&cloth);
    struct api_reader reader = reader_over(&container);
    static const struct vec3 point = {1, 1, 0};
    const struct map_target mesh = {.vertices = &point, .vertex_count = 1, .element_count = 1};
    static struct api_map map;
    size_t n = 0;
    enum api_problem_id result;
    do {
        struct api_problem problem = {0};
        struct arena_mark mark = arena_mark(arena);
        arena_fail_at(arena, ++n);
        result = api_map_make(&reader, &mesh, NULL, arena, &map, &problem);
        assert_true(result == API_OK || result == API_OUT_OF_MEMORY);
        arena_rewind(arena, mark);
    } while (result != API_OK);
    arena_fail_at(arena, 0);
    check_above(n, 30);
    bytes_free(&container);
    cloth_free(&cloth);
}

/* The columns stay, the net does not. */
static void test_map_gives_back_what_it_needs_no_more(void **state) {
    (void)state;
    struct cloth cloth = cloth_make(60, 60, flat, NULL);
    static const struct vec3 point = {1, 1, 0};
    struct arena *own = arena_new((size_t)1 << 26);
    struct bytes container = cloth_result(&cloth);
    struct api_reader reader = reader_over(&container);
    const struct map_target mesh = {.vertices = &point, .vertex_count = 1, .element_count = 1};
    static struct api_map map;
    struct api_problem problem = {0};
    assert_int_equal(api_map_make(&reader, &mesh, NULL, own, &map, &problem), API_OK);
    check_above(arena_peak(own), 3600 * sizeof(double) * CLOTH_FIELDS);
    assert_true(arena_held(own) < (size_t)1 << 18);
    arena_free(own);
    bytes_free(&container);
    cloth_free(&cloth);
}

static void test_map_refuses_a_net_without_cells_and_a_damaged_one(void **state) {
    (void)state;
    struct cloth cloth = cloth_make(4, 4, flat, NULL);
    static const struct vec3 point = {1, 1, 0};
    const struct map_target mesh = {.vertices = &point, .vertex_count = 1, .element_count = 1};
    static struct api_map map;
    for (int damage = 0; damage < 3; damage++) {
        struct api_problem problem = {0};
        size_t cells = cloth.cell_count;
        cloth.cell_count = damage == 0 ? 0 : cells;
        struct bytes container = cloth_result(&cloth);
        cloth.cell_count = cells;
        struct api_reader reader = reader_over(&container);
        container.length -= damage == 1 ? 8 : 0;
        container.length = damage == 2 ? 20 : container.length;
        assert_int_equal(api_map_make(&reader, &mesh, NULL, arena, &map, &problem),
                         damage == 0 ? API_INVALID_REQUEST : API_INTERNAL);
        bytes_free(&container);
    }
    cloth_free(&cloth);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_map_gives_a_cell_back_at_its_middle),
        cmocka_unit_test(test_map_keeps_what_is_the_same_everywhere),
        cmocka_unit_test(test_map_is_exact_for_what_is_linear_within_the_net),
        cmocka_unit_test(test_map_is_continuous_over_the_net),
        cmocka_unit_test(test_map_tensor_is_positive_and_that_of_its_columns),
        cmocka_unit_test(test_map_tensor_turns_with_the_cloth),
        cmocka_unit_test(test_map_of_all_turned_is_the_map_turned),
        cmocka_unit_test(test_map_lays_the_drape_as_one_ply),
        cmocka_unit_test(test_map_presses_cloth_to_heights),
        cmocka_unit_test(test_map_presses_cloth_under_a_punch),
        cmocka_unit_test(test_map_keeps_its_first_warnings),
        cmocka_unit_test(test_map_tells_distance_and_what_is_extrapolated),
        cmocka_unit_test(test_map_warns_when_more_than_half_is_far),
        cmocka_unit_test(test_map_takes_the_middles_of_elements_and_their_ids),
        cmocka_unit_test(test_map_selects_columns_in_their_own_order),
        cmocka_unit_test(test_map_stops_when_told_to),
        cmocka_unit_test(test_map_without_memory_is_a_problem),
        cmocka_unit_test(test_map_gives_back_what_it_needs_no_more),
        cmocka_unit_test(test_map_refuses_a_net_without_cells_and_a_damaged_one),
    };
    return cmocka_run_group_tests_name("map", tests, set_up, tear_down);
}
