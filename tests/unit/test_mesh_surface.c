/* SPDX-License-Identifier: MIT */
#include "solver/mesh/tessellation.h"

#include "patch.h"
#include "sample.h"
#include "tests/check.h"
#include <math.h>
#include <stdio.h>
#include <time.h>

static const size_t plenty = 4000000;

static struct arena *new_arena(void) {
    return arena_new((size_t)1 << 32);
}

static struct surface *make_surface(const struct nurbs *nurbs, struct arena *arena) {
    struct surface *surface;
    assert_int_equal(nurbs_validate(nurbs, NULL), STATUS_OK);
    assert_int_equal(surface_make(nurbs, arena, &surface), STATUS_OK);
    return surface;
}

/* Every vertex is r(u, v), every normal along r_u x r_v; the longest side. */
static double check_on_surface(const struct surface *surface, const struct mesh *mesh) {
    struct surface_cursor cursor = {0};
    struct surface_jet jet;
    double longest = 0;
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        surface_evaluate(surface, &cursor, mesh->parameters[v][0], mesh->parameters[v][1], &jet);
        check_at_most(vec3_distance(jet.r, mesh->vertices[v]), 1e-9 * mesh->size);
    }
    for (int32_t t = 0; t < (int32_t)mesh->triangle_count; t++) {
        struct vec3 p[3];
        double uv[2];
        mesh_corner_points(mesh, t, p);
        struct vec3 sum = vec3_add(p[0], vec3_add(p[1], p[2]));
        struct mesh_point middle = {t, vec3_scale(1.0 / 3, sum)};
        mesh_parameters(mesh, &middle, uv);
        surface_evaluate(surface, &cursor, uv[0], uv[1], &jet);
        check_above(vec3_dot(mesh->normals[t], vec3_cross(jet.u, jet.v)), 0);
        for (int k = 0; k < 3; k++)
            longest = fmax(longest, vec3_distance(p[k], p[(k + 1) % 3]));
    }
    return longest;
}

static size_t boundary_edges(const struct mesh *mesh) {
    size_t count = 0;
    for (size_t e = 0; e < 3 * mesh->triangle_count; e++)
        count += mesh->twins[e] == MESH_NONE;
    return count;
}

static void test_mesh_surface_of_random_patches(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    for (int round = 0; round < 60; round++) {
        struct patch_kind kind = {1 + random_index(&random, 5), 1 + random_index(&random, 5),
                                  random_index(&random, 2), random_index(&random, 2)};
        struct arena *arena = new_arena();
        static struct patch patch;
        struct mesh *mesh;
        patch_make(&patch, &kind, &random);
        const struct surface *surface = make_surface(&patch.nurbs, arena);
        double area = surface_area(surface, NULL), size = sqrt(area / 3000);
        assert_int_equal(mesh_from_surface(surface, size, plenty, arena, &mesh), STATUS_OK);
        assert_int_equal(mesh->component_count, 1);
        assert_in_range(mesh->triangle_count, 3000, 60000);
        check_below(check_on_surface(surface, mesh), 4 * size);
        check_below(fabs(mesh->area / area - 1), 0.02);
        arena_free(arena);
    }
}

/* A flat patch with knots at thirds, wider at one end: no triangle crosses a knot line, the number
 * of points in a row follows its length, and the mesh is the plane. */
static void test_mesh_surface_keeps_to_knot_lines(void **state) {
    (void)state;
    static const double ku[] = {0, 0, 0.3, 0.4, 1, 1}, kv[] = {0, 0, 0.5, 1, 1};
    struct arena *arena = new_arena();
    struct vec3 points[12];
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 3; j++)
            points[3 * i + j] = vec3_make(ku[i + 1] * (0.1 + kv[j + 1]), 2 * kv[j + 1], 0);
    const struct nurbs nurbs = {
        .u = {1, 4, ku, 6}, .v = {1, 3, kv, 5}, .points = points, .point_count = 12};
    const struct surface *surface = make_surface(&nurbs, arena);
    struct mesh *mesh;
    assert_int_equal(mesh_from_surface(surface, 0.05, plenty, arena, &mesh), STATUS_OK);
    check_below(fabs(mesh->area - surface_area(surface, NULL)), 1e-12);
    assert_in_range(mesh->triangle_count, 1000, 2000);
    static const double *const knots[2] = {ku, kv};
    for (size_t t = 0; t < mesh->triangle_count; t++)
        for (int direction = 0; direction < 2; direction++)
            for (int k = 1; k < (direction ? 4 : 5); k++) {
                bool below = false, above = false;
                for (int corner = 0; corner < 3; corner++) {
                    double x = mesh->parameters[mesh->corners[t][corner]][direction];
                    below = below || x < knots[direction][k];
                    above = above || x > knots[direction][k];
                }
                assert_false(below && above);
            }
    check_below(check_on_surface(surface, mesh), 0.1);
    arena_free(arena);
}

/* A triangle as a patch: its edge u = 0 is one point. The rows run along v then. */
static void test_mesh_surface_with_a_pole(void **state) {
    (void)state;
    static const double knots[] = {0, 0, 1, 1};
    const struct vec3 points[] = {{0, 0, 0}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    for (int transposed = 0; transposed < 2; transposed++) {
        const struct vec3 turned[] = {points[0], points[3], points[1], points[2]};
        const struct nurbs nurbs = {.u = {1, 2, knots, 4},
                                    .v = {1, 2, knots, 4},
                                    .points = transposed ? turned : points,
                                    .point_count = 4};
        struct arena *arena = new_arena();
        const struct surface *surface = make_surface(&nurbs, arena);
        struct mesh *mesh;
        assert_int_equal(mesh_from_surface(surface, 0.02, plenty, arena, &mesh), STATUS_OK);
        assert_int_equal(mesh->component_count, 1);
        check_below(fabs(mesh->area - 0.5), 1e-13);
        check_below(mesh->triangle_count, 5000);
        check_below(check_on_surface(surface, mesh), 0.05);
        struct mesh_point place;
        double uv[2];
        assert_true(mesh_nearest(mesh, vec3_make(0, 0, 0), MESH_ANY, &place, NULL));
        mesh_parameters(mesh, &place, uv);
        check_below(fabs(uv[transposed]), 1e-12);
        arena_free(arena);
    }
}

static void test_mesh_surface_with_too_many_triangles(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    struct patch_kind kind = {3, 3, true, false};
    struct arena *arena = new_arena();
    static struct patch patch;
    struct mesh *mesh;
    patch_make(&patch, &kind, &random);
    const struct surface *surface = make_surface(&patch.nurbs, arena);
    double size = sqrt(surface_area(surface, NULL) / 1000);
    assert_int_equal(mesh_from_surface(surface, size, plenty, arena, &mesh), STATUS_OK);
    size_t count = mesh->triangle_count;
    assert_int_equal(mesh_from_surface(surface, size, count, arena, &mesh), STATUS_OK);
    for (size_t most = count - 1; most > 0; most /= 2)
        assert_int_equal(mesh_from_surface(surface, size, most, arena, &mesh),
                         STATUS_TOO_MANY_NODES);
    for (double tiny = 1e-5; tiny > 1e-300; tiny *= 1e-20)
        assert_int_equal(mesh_from_surface(surface, tiny, plenty, arena, &mesh),
                         STATUS_TOO_MANY_NODES);
    arena_free(arena);
}

static void test_mesh_surface_coarser_than_the_surface(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    struct patch_kind kind = {2, 2, true, false};
    struct arena *arena = new_arena();
    static struct patch patch;
    struct mesh *mesh;
    patch_make(&patch, &kind, &random);
    const struct surface *surface = make_surface(&patch.nurbs, arena);
    assert_int_equal(mesh_from_surface(surface, 1e9, plenty, arena, &mesh), STATUS_OK);
    check_at_least(boundary_edges(mesh), 4);
    check_at_least(mesh->triangle_count, 2);
    arena_free(arena);
}

static void test_mesh_surface_allocation_failures(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    struct patch_kind kind = {3, 2, true, true};
    static struct patch patch;
    patch_make(&patch, &kind, &random);
    size_t n = 1;
    for (enum status status = STATUS_OUT_OF_MEMORY; status != STATUS_OK; n++) {
        struct arena *arena = new_arena();
        const struct surface *surface = make_surface(&patch.nurbs, arena);
        struct mesh *mesh;
        arena_fail_at(arena, n);
        status = mesh_from_surface(surface, 0.2, plenty, arena, &mesh);
        assert_true(status == STATUS_OK || status == STATUS_OUT_OF_MEMORY);
        arena_free(arena);
    }
    check_above(n, 15);
    printf("%zu allocations of a tessellation\n", n - 2);
}

static double seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void test_mesh_surface_of_a_million_triangles(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    struct patch_kind kind = {3, 3, true, true};
    struct arena *arena = new_arena();
    static struct patch patch;
    struct mesh *mesh;
    patch_make(&patch, &kind, &random);
    const struct surface *surface = make_surface(&patch.nurbs, arena);
    double size = sqrt(surface_area(surface, NULL) / 400000), begin = seconds();
    assert_int_equal(mesh_from_surface(surface, size, plenty, arena, &mesh), STATUS_OK);
    printf("%zu triangles in %.2f s\n", mesh->triangle_count, seconds() - begin);
    assert_int_equal(mesh->component_count, 1);
    arena_free(arena);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_mesh_surface_of_random_patches),
        cmocka_unit_test(test_mesh_surface_keeps_to_knot_lines),
        cmocka_unit_test(test_mesh_surface_with_a_pole),
        cmocka_unit_test(test_mesh_surface_with_too_many_triangles),
        cmocka_unit_test(test_mesh_surface_coarser_than_the_surface),
        cmocka_unit_test(test_mesh_surface_allocation_failures),
        cmocka_unit_test(test_mesh_surface_of_a_million_triangles),
    };
    return cmocka_run_group_tests_name("mesh_surface", tests, NULL, NULL);
}
