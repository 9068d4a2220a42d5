/* SPDX-License-Identifier: MIT */
#include "solver/drape.h"
#include "solver/mesh/smooth_corner.h"
#include "solver/mesh/smooth_path.h"

#include "own_arena.h"
#include "sample.h"
#include "tests/check.h"
#include <math.h>
#include <stdio.h>

static struct vec3 centred(struct vec3 p) {
    return vec3_make(2 * p.x - 1, 2 * p.y - 1, 0);
}

/* The sphere of radius 2 about (0, 0, -2), from above. */
static struct vec3 cap(struct vec3 p) {
    struct vec3 q = centred(p);
    return vec3_make(q.x, q.y, sqrt(4 - q.x * q.x - q.y * q.y) - 2);
}

static struct vec3 wavy(struct vec3 p) {
    struct vec3 q = centred(p);
    return vec3_make(q.x, q.y, 0.1 * sin(4 * q.x) * cos(3 * q.y));
}

static struct mesh_smooth *smooth_of(struct sample *sample, const struct mesh **mesh) {
    struct mesh_smooth *smooth;
    *mesh = sample_mesh(sample, arena);
    assert_int_equal(mesh_smooth_make(*mesh, arena, &smooth), STATUS_OK);
    return smooth;
}

static double largest(double a, double b) {
    return isfinite(b) ? fmax(a, b) : HUGE_VAL;
}

/* Errors of places, normals and curvatures on a sphere. */
static void cap_errors(int n, struct random *random, double error[3]) {
    struct sample sample = sample_grid(n, n, random);
    const struct mesh *mesh;
    sample_map(&sample, cap);
    struct mesh_smooth *smooth = smooth_of(&sample, &mesh);
    error[0] = error[1] = error[2] = 0;
    for (int32_t t = 0; t < (int32_t)mesh->triangle_count; t++) {
        struct vec3 p[3], centre = {0, 0, -2};
        struct mesh_jet jet;
        mesh_corner_points(mesh, t, p);
        struct mesh_point place = {t, vec3_scale(1 / 3.0, vec3_add(p[0], vec3_add(p[1], p[2])))};
        mesh_smooth_project(smooth, &place);
        mesh_smooth_jet(smooth, &place, &jet);
        struct vec3 out = vec3_sub(place.r, centre), normal = vec3_unit(jet.gradient);
        struct vec3 tangent = vec3_unit(vec3_cross(normal, random_direction(random)));
        error[0] = largest(error[0], fabs(vec3_norm(out) - 2));
        error[1] = largest(error[1], vec3_norm(vec3_cross(vec3_unit(out), normal)));
        error[2] = largest(error[2], fabs(mesh_jet_form(&jet, tangent, tangent) + 0.5));
    }
    sample_free(&sample);
}

static void test_mesh_smooth_has_the_curvature_of_a_sphere(void **state) {
    (void)state;
    static const double least_order[3] = {3, 2.2, 1.2};
    static const char *const names[3] = {"place", "normal", "curvature"};
    struct random random = random_begin("sphere");
    double coarse[3], fine[3];
    cap_errors(12, &random, coarse);
    cap_errors(48, &random, fine);
    for (int k = 0; k < 3; k++) {
        double order = log2(coarse[k] / fine[k]) / 2;
        printf("  %-9s %.1e %.1e (%.2f)\n", names[k], coarse[k], fine[k], order);
        assert_true(order > least_order[k]);
    }
}

static void test_mesh_smooth_follows_to_the_nearest_triangle(void **state) {
    (void)state;
    struct random random = random_begin("follow");
    struct sample sample = sample_grid(20, 20, &random);
    const struct mesh *mesh;
    sample_map(&sample, wavy);
    sample_shuffle(&sample, &random);
    struct mesh_smooth *smooth = smooth_of(&sample, &mesh);
    for (int k = 0; k < 1000; k++) {
        double x = random_between(&random, -0.99, 0.99), y = random_between(&random, -0.99, 0.99);
        struct mesh_point aim = sample_place(mesh, x, y);
        struct mesh_point place = {random_index(&random, (int)mesh->triangle_count), aim.r};
        assert_int_equal(mesh_smooth_follow(smooth, &place, true, 0), MESH_NONE);
        assert_true(sample_gap(mesh, &place) < 1e-9);
    }
    sample_free(&sample);
}

static void test_mesh_smooth_geodesics_of_a_sphere_are_great_circles(void **state) {
    (void)state;
    struct random random = random_begin("great circles");
    struct sample sample = sample_grid(40, 40, &random);
    const struct mesh *mesh;
    sample_map(&sample, cap);
    struct mesh_smooth *smooth = smooth_of(&sample, &mesh);
    for (int k = 0; k < 50; k++) {
        struct mesh_point from = sample_place(mesh, 0, 0);
        struct mesh_smooth_path path;
        double angle = random_between(&random, 0, 2 * M_PI), length = 0.8;
        struct vec3 direction = {cos(angle), sin(angle), 0}, none = {0, 0, 0};
        mesh_smooth_project(smooth, &from);
        assert_true(mesh_smooth_path(&path, smooth, &from, direction, none));
        assert_int_equal(mesh_smooth_length(&path, length), MESH_PATH_DONE);
        struct vec3 end = vec3_scale(2 * sin(length / 2), direction);
        end.z = 2 * cos(length / 2) - 2;
        assert_true(vec3_distance(path.at.r, end) < 1e-5);
        assert_true(mesh_smooth_path(&path, smooth, &from, direction, none));
        assert_int_equal(mesh_smooth_chord(&path, 0.5), MESH_PATH_DONE);
        assert_true(fabs(vec3_distance(path.at.r, from.r) - 0.5) < 1e-8);
    }
    sample_free(&sample);
}

/* Vertices off by a share of the triangles' size, slivers, soups, a single triangle: the net may be
 * poor, but its places lie near the mesh, its edges have their lengths, and it ends. */
static void drape_rough(struct sample *sample, enum drape_method method) {
    struct drape_settings settings = {
        .method = method, .spacing = {0.07, 0.05}, .direction_deg = 20, .max_nodes = 100000};
    struct drape_result result;
    const struct mesh *mesh = sample_mesh(sample, arena);
    assert_int_equal(
        drape_solve(&(struct drape_part){.mesh = mesh}, &settings, NULL, arena, &result),
        STATUS_OK);
    assert_true(result.nodes.count >= 1 && result.summary.residual_max < 1e-4);
    for (size_t k = 0; k < result.nodes.count; k++) {
        struct vec3 r = {result.nodes.x[k], result.nodes.y[k], result.nodes.z[k]};
        struct mesh_point place;
        double distance;
        assert_true(mesh_nearest(mesh, r, MESH_ANY, &place, &distance));
        assert_true(distance < 0.2);
    }
}

static double noise;
static struct random *source;

static struct vec3 shaken(struct vec3 p) {
    struct vec3 q = wavy(p);
    q.z += random_between(source, -noise, noise);
    return q;
}

static struct vec3 squeezed(struct vec3 p) {
    return wavy(vec3_make(p.x, 0.5 + (p.y - 0.5) * 0.9, 0));
}

static void test_mesh_smooth_survives_bad_meshes(void **state) {
    (void)state;
    struct random random = random_begin("bad meshes");
    source = &random;
    for (int k = 0; k < 12; k++) {
        struct arena_mark mark = arena_mark(arena);
        bool thin = k % 3 == 2;
        struct sample sample = sample_grid(thin ? 60 : 15, thin ? 2 : 15, &random);
        noise = 0.1 * (k / 3) / 15;
        sample_map(&sample, k % 3 ? squeezed : shaken);
        sample_shuffle(&sample, &random);
        if (k % 2)
            sample_scatter(&sample);
        drape_rough(&sample, k % 4 < 2 ? DRAPE_GIB : DRAPE_BASIC);
        sample_free(&sample);
        arena_rewind(arena, mark);
    }
    static const struct vec3 corners[] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    static const int32_t one[1][3] = {{0, 1, 2}};
    struct sample single = sample_of(corners, 3, one, 1);
    drape_rough(&single, DRAPE_GIB);
    sample_free(&single);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_mesh_smooth_has_the_curvature_of_a_sphere, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(test_mesh_smooth_follows_to_the_nearest_triangle, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(test_mesh_smooth_geodesics_of_a_sphere_are_great_circles,
                                        set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_mesh_smooth_survives_bad_meshes, set_up, tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
