/* SPDX-License-Identifier: MIT */
#include "solver/mesh/mesh.h"

#include "sample.h"
#include "tests/check.h"
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

static struct arena *new_arena(void) {
    return arena_new((size_t)1 << 32);
}

static struct vec3 waves(struct vec3 p) {
    return vec3_make(p.x, p.y, 0.1 * sin(7 * p.x) * cos(5 * p.y));
}

static struct vec3 lifted(struct vec3 p) {
    return vec3_make(p.x, p.y, p.z + 1);
}

static struct vec3 upright(struct vec3 p) {
    return vec3_make(p.x, 0, p.y);
}

static struct vec3 hanging(struct vec3 p) {
    return vec3_make(p.x, 0, -p.y);
}

static struct vec3 shifted(struct vec3 p) {
    return vec3_make(p.x, p.y - 1, p.z);
}

/* Twins are each other's, run the other way, and belong to one component. */
static void check_topology(const struct mesh *mesh) {
    for (int32_t e = 0; e < (int32_t)(3 * mesh->triangle_count); e++) {
        int32_t twin = mesh->twins[e];
        if (twin == MESH_NONE)
            continue;
        assert_in_range(twin, 0, 3 * mesh->triangle_count - 1);
        assert_int_equal(mesh->twins[twin], e);
        assert_int_equal(mesh->component[e / 3], mesh->component[twin / 3]);
        struct vec3 from = mesh_corner_point(mesh, e / 3, e % 3);
        struct vec3 to = mesh_corner_point(mesh, twin / 3, (twin + 1) % 3);
        assert_true(vec3_distance(from, to) == 0);
    }
    for (int32_t t = 0; t < (int32_t)mesh->triangle_count; t++) {
        struct vec3 p[3];
        mesh_corner_points(mesh, t, p);
        struct vec3 cross = vec3_cross(vec3_sub(p[1], p[0]), vec3_sub(p[2], p[0]));
        check_below(vec3_distance(vec3_unit(cross), mesh->normals[t]), 1e-12);
    }
}

static size_t boundary_edges(const struct mesh *mesh) {
    size_t count = 0;
    for (size_t e = 0; e < 3 * mesh->triangle_count; e++)
        count += mesh->twins[e] == MESH_NONE;
    return count;
}

static void test_mesh_of_a_square(void **state) {
    (void)state;
    struct arena *arena = new_arena();
    struct sample s = sample_grid(1, 1, NULL);
    const struct mesh *mesh = sample_mesh(&s, arena);
    check_topology(mesh);
    assert_int_equal(mesh->triangle_count, 2);
    assert_int_equal(boundary_edges(mesh), 4);
    assert_int_equal(mesh->component_count, 1);
    check_below(fabs(mesh->area - 1), 1e-15);
    check_below(vec3_distance(mesh->centroid, vec3_make(0.5, 0.5, 0)), 1e-15);
    assert_true(vec3_distance(mesh->upper, vec3_make(1, 1, 0)) == 0);
    assert_true(fabs(mesh->size - sqrt(2)) < 1e-15 && mesh->magnitude == mesh->size);
    assert_true(mesh->normals[0].z == 1 && mesh->normals[1].z == 1);
    sample_free(&s);
    arena_free(arena);
}

static void test_mesh_winds_random_triangles_one_way(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    for (int round = 0; round < 40; round++) {
        struct arena *arena = new_arena();
        int n = 1 + random_index(&random, 30), m = 1 + random_index(&random, 30);
        struct sample s = sample_grid(n, m, &random);
        sample_map(&s, waves);
        sample_shuffle(&s, &random);
        if (round % 2)
            sample_scatter(&s);
        const struct mesh *mesh = sample_mesh(&s, arena);
        check_topology(mesh);
        assert_int_equal(mesh->component_count, 1);
        assert_int_equal(boundary_edges(mesh), 2 * (n + m));
        for (size_t t = 0; t < mesh->triangle_count; t++)
            check_above(mesh->normals[t].z * mesh->normals[0].z, 0);
        sample_free(&s);
        arena_free(arena);
    }
}

static void test_mesh_keeps_the_winding_of_most_of_the_area(void **state) {
    (void)state;
    struct arena *arena = new_arena();
    struct sample s = sample_grid(4, 4, NULL);
    for (int up = 0; up < 2; up++) {
        for (size_t t = 0; t < 10; t++) {
            int32_t second = s.triangles[t][1];
            s.triangles[t][1] = s.triangles[t][2];
            s.triangles[t][2] = second;
        }
        const struct mesh *mesh = sample_mesh(&s, arena);
        for (size_t t = 0; t < mesh->triangle_count; t++)
            assert_true(mesh->normals[t].z == 1);
    }
    sample_free(&s);
    arena_free(arena);
}

static void test_mesh_joins_vertices_in_the_same_place(void **state) {
    (void)state;
    struct arena *arena = new_arena();
    struct sample s = sample_grid(6, 5, NULL);
    sample_scatter(&s);
    for (size_t v = 0; v < s.vertex_count; v += 2)
        if (s.vertices[v].z == 0)
            s.vertices[v].z = -0.0;
    const struct mesh *mesh = sample_mesh(&s, arena);
    check_topology(mesh);
    assert_int_equal(mesh->component_count, 1);
    assert_int_equal(boundary_edges(mesh), 22);
    sample_free(&s);
    arena_free(arena);
}

/* Two surfaces, each with vertices of its own, that touch along a line inside both. */
static void test_mesh_leaves_surfaces_that_touch_apart(void **state) {
    (void)state;
    struct arena *arena = new_arena();
    struct sample flat = sample_grid(4, 4, NULL), below = sample_grid(4, 4, NULL);
    struct sample up = sample_grid(4, 4, NULL), down = sample_grid(4, 4, NULL);
    sample_map(&below, shifted);
    sample_map(&up, upright);
    sample_map(&down, hanging);
    sample_add(&flat, &below); /* joined along y = 0 by its places */
    const struct mesh *one = sample_mesh(&flat, arena);
    assert_int_equal(one->component_count, 1);
    struct mesh_fault fault;
    struct mesh *mesh;
    sample_add(&flat, &up); /* now three single edges lie there */
    struct mesh_source source = sample_source(&flat);
    assert_int_equal(mesh_make(&source, arena, &mesh, &fault), STATUS_INVALID);
    assert_int_equal(fault.kind, MESH_FAULT_NON_MANIFOLD);
    struct sample cross = sample_grid(4, 8, NULL), other = sample_grid(4, 8, NULL);
    sample_map(&other, upright); /* edge of the one against the inside of the other */
    for (size_t v = 0; v < cross.vertex_count; v++)
        cross.vertices[v].y -= 0.5;
    sample_add(&cross, &other);
    const struct mesh *two = sample_mesh(&cross, arena);
    check_topology(two);
    assert_int_equal(two->component_count, 2);
    sample_free(&flat);
    sample_free(&below);
    sample_free(&up);
    sample_free(&down);
    sample_free(&cross);
    sample_free(&other);
    arena_free(arena);
}

static void test_mesh_of_several_components(void **state) {
    (void)state;
    struct arena *arena = new_arena();
    struct sample s = sample_grid(3, 3, NULL), other = sample_grid(5, 2, NULL);
    sample_map(&other, lifted);
    sample_add(&s, &other);
    const struct mesh *mesh = sample_mesh(&s, arena);
    struct mesh_point place;
    double distance;
    assert_int_equal(mesh->component_count, 2);
    for (int k = 0; k < 2; k++) {
        const struct mesh_component *component = &mesh->components[k];
        check_below(fabs(component->area - 1), 1e-14);
        check_below(vec3_distance(component->centroid, vec3_make(0.5, 0.5, k)), 1e-14);
        assert_int_equal(component->triangle_count, k == 0 ? 18 : 20);
        assert_int_equal(component->rim_count, k == 0 ? 12 : 14);
        assert_true(mesh_nearest(mesh, vec3_make(0.3, 0.4, 0.2), k, &place, &distance));
        check_below(fabs(distance - (k == 0 ? 0.2 : 0.8)), 1e-15);
        assert_int_equal(mesh->component[place.triangle], k);
    }
    assert_false(mesh_nearest(mesh, vec3_make(0, 0, 0), 2, &place, NULL));
    check_below(vec3_distance(mesh->centroid, vec3_make(0.5, 0.5, 0.5)), 1e-14);
    sample_free(&s);
    sample_free(&other);
    arena_free(arena);
}

/* ---- faults ---- */

struct faulty {
    struct vec3 vertices[6];
    int32_t triangles[4][3];
    size_t vertex_count, triangle_count;
    enum mesh_fault_kind kind;
    size_t index;
};

static const struct faulty faulty[] = {
    {{{0, 0, 0}}, {{0, 0, 0}}, 1, 0, MESH_FAULT_EMPTY, 0},
    {{{0, 0, 0}, {1, 0, 0}, {0, NAN, 0}}, {{0, 1, 2}}, 3, 1, MESH_FAULT_VERTEX, 2},
    {{{0, 0, 0}, {1, INFINITY, 0}, {0, 1, 0}}, {{0, 1, 2}}, 3, 1, MESH_FAULT_VERTEX, 1},
    {{{0, 0, 2e60}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}, 3, 1, MESH_FAULT_VERTEX, 0},
    {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}}, 3, 2, MESH_FAULT_INDEX, 1},
    {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, -1}}, 3, 1, MESH_FAULT_INDEX, 0},
    {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {1, 1, 2}}, 3, 2, MESH_FAULT_NO_AREA, 1},
    {{{0, 0, 0}, {1, 1, 1}, {3, 3, 3}}, {{0, 1, 2}}, 3, 1, MESH_FAULT_NO_AREA, 0},
    {{{0, 0, 0}, {0, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}, 3, 1, MESH_FAULT_NO_AREA, 0},
    {{{1e9, 0, 0}, {1e9 + 1, 0, 0}, {1e9, 1e-5, 0}}, {{0, 1, 2}}, 3, 1, MESH_FAULT_NO_AREA, 0},
    {{{0, 0, 0}, {1, 0, 0}, {0.5, 9e-7, 0}}, {{0, 1, 2}}, 3, 1, MESH_FAULT_SLIVER, 0},
    {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {2, 1, 0}}, 3, 2, MESH_FAULT_DUPLICATE, 1},
    {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
     {{0, 1, 2}, {3, 4, 5}},
     6,
     2,
     MESH_FAULT_DUPLICATE,
     1},
    {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}},
     {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}},
     5,
     3,
     MESH_FAULT_NON_MANIFOLD,
     2},
    {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0, 0, 1}},
     {{0, 1, 2}, {2, 1, 3}, {1, 2, 0}},
     5,
     3,
     MESH_FAULT_DUPLICATE,
     2},
};

static void test_mesh_faults(void **state) {
    (void)state;
    for (size_t k = 0; k < sizeof faulty / sizeof *faulty; k++) {
        struct arena *arena = new_arena();
        const struct faulty *f = &faulty[k];
        struct sample s = sample_of(f->vertices, f->vertex_count, f->triangles, f->triangle_count);
        struct mesh_source source = sample_source(&s);
        struct mesh_fault fault = {0};
        struct mesh *mesh;
        assert_int_equal(mesh_make(&source, arena, &mesh, NULL), STATUS_INVALID);
        assert_int_equal(mesh_make(&source, arena, &mesh, &fault), STATUS_INVALID);
        if (fault.kind != f->kind || fault.index != f->index)
            fail_msg("mesh %zu: triangle %zu: %s", k, fault.index, fault.reason);
        check_above(strlen(fault.reason), 10);
        assert_true(f->kind != MESH_FAULT_INDEX || fault.corner == 2);
        sample_free(&s);
        arena_free(arena);
    }
}

static void test_mesh_refuses_more_than_can_be_numbered(void **state) {
    (void)state;
    struct arena *arena = new_arena();
    struct mesh_source source = {.triangle_count = (size_t)INT32_MAX};
    struct mesh_fault fault;
    struct mesh *mesh;
    assert_int_equal(mesh_make(&source, arena, &mesh, &fault), STATUS_INVALID);
    assert_int_equal(fault.kind, MESH_FAULT_TOO_LARGE);
    arena_free(arena);
}

/* A strip of 2 n triangles round a ring, its end joined to its beginning turned over or not. */
static struct sample ring(int n, bool turned) {
    struct sample s = sample_of(NULL, (size_t)(2 * n), NULL, (size_t)(2 * n));
    for (int k = 0; k < n; k++) {
        double a = 2 * M_PI * k / n, b = turned ? a / 2 : 0.3;
        for (int side = 0; side < 2; side++) {
            double out = 1 + (side ? 0.3 : -0.3) * cos(b);
            s.vertices[2 * k + side] =
                vec3_make(out * cos(a), out * sin(a), (side ? 0.3 : -0.3) * sin(b));
        }
        bool swapped = turned && k + 1 == n;
        int next = 2 * ((k + 1) % n), low = next + swapped, high = next + 1 - swapped;
        const int32_t corners[2][3] = {{2 * k, low, 2 * k + 1}, {low, high, 2 * k + 1}};
        memcpy(s.triangles[2 * k], corners, sizeof corners);
    }
    return s;
}

static void test_mesh_refuses_a_moebius_strip(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    struct arena *arena = new_arena();
    for (int round = 0; round < 20; round++) {
        struct sample plain = ring(12, false), turned = ring(12, true);
        sample_shuffle(&plain, &random);
        sample_shuffle(&turned, &random);
        check_topology(sample_mesh(&plain, arena));
        struct mesh_source source = sample_source(&turned);
        struct mesh_fault fault;
        struct mesh *mesh;
        assert_int_equal(mesh_make(&source, arena, &mesh, &fault), STATUS_INVALID);
        assert_int_equal(fault.kind, MESH_FAULT_ONE_SIDED);
        assert_in_range(fault.index, 0, 23);
        sample_free(&plain);
        sample_free(&turned);
    }
    arena_free(arena);
}

static void test_mesh_accepts_thin_triangles_and_unused_vertices(void **state) {
    (void)state;
    struct arena *arena = new_arena();
    const struct vec3 vertices[] = {{0, 0, 0}, {1, 0, 0}, {0.5, 1.1e-6, 0}, {50, 50, 50}};
    const int32_t triangles[][3] = {{0, 1, 2}};
    struct sample s = sample_of(vertices, 4, triangles, 1);
    const struct mesh *mesh = sample_mesh(&s, arena);
    assert_true(mesh->upper.z == 0);
    for (double scale = 1e-50; scale < 1e60; scale *= 1e10) {
        struct sample scaled = sample_grid(2, 2, NULL);
        for (size_t v = 0; v < scaled.vertex_count; v++)
            scaled.vertices[v] = vec3_scale(scale, scaled.vertices[v]);
        mesh = sample_mesh(&scaled, arena);
        check_below(fabs(mesh->area / (scale * scale) - 1), 1e-12);
        sample_free(&scaled);
    }
    sample_free(&s);
    arena_free(arena);
}

/* ---- the nearest place ---- */

static double scan_nearest(const struct mesh *mesh, struct vec3 at, int32_t component) {
    double least = HUGE_VAL;
    for (int32_t t = 0; t < (int32_t)mesh->triangle_count; t++) {
        struct vec3 p[3], n = mesh->normals[t];
        mesh_corner_points(mesh, t, p);
        struct mesh_point foot = {t, vec3_axpy(-vec3_dot(vec3_sub(at, p[0]), n), n, at)};
        double weight[3];
        if (component != MESH_ANY && mesh->component[t] != component)
            continue;
        mesh_weights(mesh, &foot, weight);
        if (weight[0] >= 0 && weight[1] >= 0 && weight[2] >= 0)
            least = fmin(least, vec3_distance(foot.r, at));
        for (int k = 0; k < 3; k++) {
            struct vec3 edge = vec3_sub(p[(k + 1) % 3], p[k]);
            double share = vec3_dot(vec3_sub(at, p[k]), edge) / vec3_norm2(edge);
            share = fmin(fmax(share, 0), 1);
            least = fmin(least, vec3_distance(vec3_axpy(share, edge, p[k]), at));
        }
    }
    return least;
}

static void check_nearest(const struct mesh *mesh, struct vec3 at, int32_t component) {
    struct mesh_point place;
    double distance, scanned = scan_nearest(mesh, at, component);
    assert_true(mesh_nearest(mesh, at, component, &place, &distance));
    check_at_most(fabs(distance - scanned), 1e-13 * (1 + scanned));
    check_at_most(fabs(vec3_distance(place.r, at) - distance), 1e-14 * (1 + scanned));
    check_below(sample_gap(mesh, &place), 1e-12);
}

static void test_mesh_nearest_as_by_a_scan(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    for (int round = 0; round < 60; round++) {
        struct arena *arena = new_arena();
        struct sample s =
            sample_grid(1 + random_index(&random, 12), 1 + random_index(&random, 12), &random);
        struct sample other = sample_grid(3, 4, &random);
        sample_map(&s, waves);
        sample_map(&other, lifted);
        sample_add(&s, &other);
        sample_shuffle(&s, &random);
        const struct mesh *mesh = sample_mesh(&s, arena);
        for (int k = 0; k < 50; k++) {
            double reach = k % 5 ? 1.5 : 50;
            struct vec3 at = vec3_scale(reach, random_direction(&random));
            check_nearest(mesh, at, k % 3 - 1);
        }
        sample_free(&s);
        sample_free(&other);
        arena_free(arena);
    }
}

static void test_mesh_nearest_takes_the_first_of_equal_triangles(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    struct arena *arena = new_arena();
    struct sample s = sample_grid(8, 8, NULL);
    sample_shuffle(&s, &random);
    const struct mesh *mesh = sample_mesh(&s, arena);
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        struct mesh_point place;
        int32_t first = 0;
        while (mesh->corners[first][0] != (int32_t)v && mesh->corners[first][1] != (int32_t)v &&
               mesh->corners[first][2] != (int32_t)v)
            first++;
        assert_true(mesh_nearest(mesh, mesh->vertices[v], MESH_ANY, &place, NULL));
        assert_int_equal(place.triangle, first);
    }
    struct mesh_point place;
    assert_false(mesh_nearest(mesh, vec3_make(NAN, 0, 0), MESH_ANY, &place, NULL));
    sample_free(&s);
    arena_free(arena);
}

static void test_mesh_parameters_are_interpolated(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    struct arena *arena = new_arena();
    struct sample s = sample_grid(7, 9, &random);
    double uv[2], (*parameters)[2] = arena_alloc(arena, s.vertex_count, sizeof *parameters);
    for (size_t v = 0; v < s.vertex_count; v++) {
        parameters[v][0] = 3 * s.vertices[v].x - s.vertices[v].y;
        parameters[v][1] = 5 - 2 * s.vertices[v].y;
    }
    sample_shuffle(&s, &random);
    struct mesh_source source = sample_source(&s);
    const struct mesh *plain = sample_mesh(&s, arena);
    struct mesh *mesh;
    source.parameters = (const double(*)[2])parameters;
    assert_int_equal(mesh_make(&source, arena, &mesh, NULL), STATUS_OK);
    for (int k = 0; k < 100; k++) {
        double x = random_between(&random, 0, 1), y = random_between(&random, 0, 1);
        struct mesh_point place = sample_place(mesh, x, y);
        mesh_parameters(mesh, &place, uv);
        check_below(fabs(uv[0] - 3 * x + y), 1e-13);
        check_below(fabs(uv[1] - 5 + 2 * y), 1e-13);
        mesh_parameters(plain, &place, uv);
        assert_true(uv[0] == place.triangle && uv[1] == 0);
    }
    sample_free(&s);
    arena_free(arena);
}

static double seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void time_nearest(const struct mesh *mesh, double height, struct random *random) {
    enum { QUERIES = 3000 };
    struct mesh_point place;
    double begin = seconds(), sum = 0, distance;
    for (int k = 0; k < QUERIES; k++) {
        struct vec3 at = {random_between(random, 0, 1), random_between(random, 0, 1), 0};
        at.z = waves(at).z + height;
        assert_true(mesh_nearest(mesh, at, MESH_ANY, &place, &distance));
        sum += distance;
    }
    printf("nearest at height %g: %.0f a second (mean distance %g)\n", height,
           QUERIES / (seconds() - begin), sum / QUERIES);
}

static void test_mesh_of_a_million_triangles(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    int n = check_sized(1000, 200);
    for (int soup = 0; soup < 2; soup++) {
        struct arena *arena = new_arena();
        struct sample s = sample_grid(n, n / 2, &random);
        sample_map(&s, waves);
        sample_shuffle(&s, &random);
        if (soup)
            sample_scatter(&s);
        double begin = seconds();
        const struct mesh *mesh = sample_mesh(&s, arena);
        printf("%zu triangles, %s: %.2f s, %.0f bytes each, %.0f at the peak\n",
               mesh->triangle_count, soup ? "a soup" : "shared vertices", seconds() - begin,
               (double)arena_held(arena) / 1e6, (double)arena_peak(arena) / 1e6);
        assert_int_equal(mesh->component_count, 1);
        assert_int_equal(boundary_edges(mesh), 3 * n);
        time_nearest(mesh, 0, &random);
        time_nearest(mesh, 0.1, &random);
        sample_free(&s);
        arena_free(arena);
    }
}

/* One far triangle must not make all others one leaf's worth. */
static void test_mesh_with_a_triangle_far_away(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    struct arena *arena = new_arena();
    struct sample s = sample_grid(200, 200, &random), far = sample_grid(1, 1, NULL);
    for (size_t v = 0; v < far.vertex_count; v++)
        far.vertices[v].x += 1e7;
    sample_add(&s, &far);
    const struct mesh *mesh = sample_mesh(&s, arena);
    time_nearest(mesh, 0, &random);
    for (int k = 0; k < 20; k++)
        check_nearest(mesh, random_direction(&random), MESH_ANY);
    sample_free(&s);
    sample_free(&far);
    arena_free(arena);
}

static void test_mesh_allocation_failures(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    struct sample s = sample_grid(9, 9, &random);
    sample_shuffle(&s, &random);
    struct mesh_source source = sample_source(&s);
    struct mesh *mesh;
    size_t n = 1;
    for (enum status status = STATUS_OUT_OF_MEMORY; status != STATUS_OK; n++) {
        struct arena *arena = new_arena();
        arena_fail_at(arena, n);
        status = mesh_make(&source, arena, &mesh, NULL);
        assert_true(status == STATUS_OK || status == STATUS_OUT_OF_MEMORY);
        arena_free(arena);
    }
    check_above(n, 12);
    printf("%zu allocations of a mesh\n", n - 2);
    sample_free(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_mesh_of_a_square),
        cmocka_unit_test(test_mesh_winds_random_triangles_one_way),
        cmocka_unit_test(test_mesh_keeps_the_winding_of_most_of_the_area),
        cmocka_unit_test(test_mesh_joins_vertices_in_the_same_place),
        cmocka_unit_test(test_mesh_leaves_surfaces_that_touch_apart),
        cmocka_unit_test(test_mesh_of_several_components),
        cmocka_unit_test(test_mesh_faults),
        cmocka_unit_test(test_mesh_refuses_more_than_can_be_numbered),
        cmocka_unit_test(test_mesh_refuses_a_moebius_strip),
        cmocka_unit_test(test_mesh_accepts_thin_triangles_and_unused_vertices),
        cmocka_unit_test(test_mesh_nearest_as_by_a_scan),
        cmocka_unit_test(test_mesh_nearest_takes_the_first_of_equal_triangles),
        cmocka_unit_test(test_mesh_parameters_are_interpolated),
        cmocka_unit_test(test_mesh_of_a_million_triangles),
        cmocka_unit_test(test_mesh_with_a_triangle_far_away),
        cmocka_unit_test(test_mesh_allocation_failures),
    };
    return cmocka_run_group_tests_name("mesh", tests, NULL, NULL);
}
