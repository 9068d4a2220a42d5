/* SPDX-License-Identifier: MIT */
#include "solver/mesh/path.h"

#include "sample.h"
#include "tests/check.h"
#include <math.h>
#include <stdio.h>

static struct arena *new_arena(void) {
    return arena_new((size_t)1 << 30);
}

/* The unit square in a plane of space: p = (x, y, 0) to its place there. */
static struct vec3 tilted(struct vec3 p) {
    const struct vec3 a = {0.6, 0.48, 0.64}, b = {-0.8, 0.36, 0.48};
    return vec3_add(vec3_make(3, -2, 1), vec3_axpy(p.x, a, vec3_scale(p.y, b)));
}

/* Folds the plane along the lines x = 1/8, 2/8, ..: lengths in it stay as they are. */
static struct vec3 folded(struct vec3 p) {
    static const double slope[8] = {0, 0.9, 0.3, -1.2, -1.5, 0.2, 1.4, 1.1};
    double x = 0, z = 0;
    for (int k = 0; k < 8 && p.x > k / 8.0; k++) {
        double part = fmin(p.x - k / 8.0, 1 / 8.0);
        x += part * cos(slope[k]);
        z += part * sin(slope[k]);
    }
    return vec3_make(x, p.y, z);
}

/* A grid whose vertices are moved along y only, so that x = k / 8 stay lines of it. */
static struct sample fold_grid(struct random *random) {
    enum { N = 8 };
    struct sample s = sample_grid(N, N, NULL);
    for (int j = 1; j < N; j++)
        for (int i = 0; i <= N; i++)
            s.vertices[j * (N + 1) + i].y += random_between(random, -0.3, 0.3) / N;
    return s;
}

static struct vec3 straight_on(struct vec3 from, double angle, double length) {
    return vec3_axpy(length, vec3_make(cos(angle), sin(angle), 0), from);
}

/* The place of the mesh at (x, y) of the plane before `map`, and a direction there. */
static struct mesh_point mapped_place(const struct mesh *flat, const struct mesh *mesh, double x,
                                      double y) {
    struct mesh_point place = sample_place(flat, x, y);
    double weight[3];
    mesh_weights(flat, &place, weight);
    place.r = vec3_make(0, 0, 0);
    for (int k = 0; k < 3; k++)
        place.r = vec3_axpy(weight[k], mesh_corner_point(mesh, place.triangle, k), place.r);
    return place;
}

/* A direction of the flat mesh in the same triangle of the other one, which has its shape. */
static struct vec3 mapped_direction(const struct mesh *flat, const struct mesh *mesh, int32_t t,
                                    struct vec3 direction) {
    struct vec3 p[3], q[3];
    mesh_corner_points(flat, t, p);
    mesh_corner_points(mesh, t, q);
    struct vec3 a = vec3_sub(p[1], p[0]), b = vec3_sub(p[2], p[0]);
    double whole = a.x * b.y - a.y * b.x;
    double s = (direction.x * b.y - direction.y * b.x) / whole;
    double r = (a.x * direction.y - a.y * direction.x) / whole;
    return vec3_axpy(s, vec3_sub(q[1], q[0]), vec3_scale(r, vec3_sub(q[2], q[0])));
}

/* Paths on a mesh that is the flat one folded: as straight as there. */
static void check_unfolding(struct sample *flat_sample, struct vec3 (*map)(struct vec3),
                            struct random *random) {
    struct arena *arena = new_arena();
    const struct mesh *flat = sample_mesh(flat_sample, arena);
    sample_map(flat_sample, map);
    const struct mesh *mesh = sample_mesh(flat_sample, arena);
    for (int k = 0; k < 200; k++) {
        struct vec3 from = {random_between(random, 0, 1), random_between(random, 0, 1), 0};
        if (k % 4 == 0) /* from grid lines and points, along them */
            from = vec3_make(floor(8 * from.x) / 8, k % 8 ? from.y : floor(8 * from.y) / 8, 0);
        double angle = k % 4 ? random_between(random, -4, 4) : M_PI / 2 * random_index(random, 4);
        double length = random_between(random, 0, 0.8);
        struct vec3 to = straight_on(from, angle, length);
        if (to.x < 0 || to.x > 1 || to.y < 0 || to.y > 1)
            continue;
        struct mesh_point place = mapped_place(flat, mesh, from.x, from.y);
        struct vec3 direction =
            mapped_direction(flat, mesh, place.triangle, straight_on(vec3_make(0, 0, 0), angle, 1));
        struct mesh_path path;
        assert_true(mesh_path_straight(&path, mesh, &place, direction));
        assert_int_equal(mesh_path_length(&path, length), MESH_PATH_DONE);
        struct mesh_point end = mapped_place(flat, mesh, to.x, to.y);
        check_below(vec3_distance(path.at.r, end.r), 1e-12);
        check_below(sample_gap(mesh, &path.at), 1e-12);
        check_below(fabs(vec3_dot(path.direction, mesh->normals[path.at.triangle])), 1e-14);
        check_below(fabs(vec3_norm(path.direction) - 1), 1e-14);
    }
    arena_free(arena);
}

static void test_mesh_path_is_straight_on_a_plane(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    for (int round = 0; round < 20; round++) {
        struct sample s = sample_grid(8, 8, round % 2 ? &random : NULL);
        sample_shuffle(&s, &random);
        check_unfolding(&s, tilted, &random);
        sample_free(&s);
    }
}

static void test_mesh_path_unfolds(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    for (int round = 0; round < 20; round++) {
        struct sample s = fold_grid(&random);
        sample_shuffle(&s, &random);
        check_unfolding(&s, folded, &random);
        sample_free(&s);
    }
}

static void test_mesh_path_ends_at_the_boundary(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    struct arena *arena = new_arena();
    struct sample s = sample_grid(7, 6, &random);
    const struct mesh *mesh = sample_mesh(&s, arena);
    for (int k = 0; k < 300; k++) {
        double x = random_between(&random, 0, 1), y = random_between(&random, 0, 1);
        struct mesh_point from = sample_place(mesh, x, y);
        struct vec3 e = straight_on(vec3_make(0, 0, 0), random_between(&random, -4, 4), 1);
        double to_x = (e.x > 0 ? 1 - x : -x) / e.x, to_y = (e.y > 0 ? 1 - y : -y) / e.y;
        struct mesh_path path;
        assert_true(mesh_path_straight(&path, mesh, &from, e));
        assert_int_equal(mesh_path_length(&path, 2), MESH_PATH_BOUNDARY);
        struct vec3 end = vec3_axpy(fmin(to_x, to_y), e, from.r);
        check_below(vec3_distance(path.at.r, end), 1e-12);
    }
    sample_free(&s);
    arena_free(arena);
}

/* A yarn along the edge of a part: rounding must not lead it off. */
static void test_mesh_path_runs_along_the_boundary(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    struct arena *arena = new_arena();
    struct sample s = sample_grid(9, 9, &random);
    sample_map(&s, tilted);
    sample_shuffle(&s, &random);
    const struct mesh *mesh = sample_mesh(&s, arena);
    for (int k = 0; k < 20; k++) {
        struct mesh_point from;
        struct mesh_path path;
        double begin = k % 2 ? 0 : 0.013;
        struct vec3 a = tilted(vec3_make(begin, k & 4 ? 0 : 1, 0));
        struct vec3 b = tilted(vec3_make(1, k & 4 ? 0 : 1, 0));
        assert_true(mesh_nearest(mesh, a, MESH_ANY, &from, NULL));
        assert_true(mesh_path_straight(&path, mesh, &from, vec3_sub(b, a)));
        for (int step = 1; step <= 30; step++) {
            assert_int_equal(mesh_path_chord(&path, (1 - begin) / 32), MESH_PATH_DONE);
            struct vec3 r = vec3_axpy(step / 32.0, vec3_sub(b, a), a);
            check_below(vec3_distance(path.at.r, r), 1e-12);
        }
    }
    sample_free(&s);
    arena_free(arena);
}

static struct vec3 hilly(struct vec3 p) {
    return vec3_make(p.x, p.y, 0.15 * sin(6 * p.x) * cos(5 * p.y));
}

static void test_mesh_path_chords_are_as_long_as_asked(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    struct arena *arena = new_arena();
    struct sample s = sample_grid(30, 30, &random);
    sample_map(&s, hilly);
    const struct mesh *mesh = sample_mesh(&s, arena);
    int steps = 0;
    for (int k = 0; k < 200; k++) {
        struct mesh_point from = sample_place(mesh, random_between(&random, 0.3, 0.7),
                                              random_between(&random, 0.3, 0.7));
        struct mesh_path path;
        double chord = random_between(&random, 0.001, 0.1);
        assert_true(mesh_path_straight(&path, mesh, &from, random_direction(&random)));
        for (;;) {
            struct vec3 before = path.at.r;
            if (mesh_path_chord(&path, chord) != MESH_PATH_DONE)
                break;
            check_below(fabs(vec3_distance(before, path.at.r) / chord - 1), 1e-13);
            check_below(sample_gap(mesh, &path.at), 1e-13);
            steps++;
        }
    }
    check_above(steps, 1000);
    sample_free(&s);
    arena_free(arena);
}

/* The surface of a cube of side 2 about 0, each face two triangles. */
static struct sample cube(void) {
    static const struct vec3 p[8] = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1},
                                     {-1, -1, 1},  {1, -1, 1},  {1, 1, 1},  {-1, 1, 1}};
    static const int32_t t[12][3] = {{4, 5, 6}, {4, 6, 7}, {0, 2, 1}, {0, 3, 2},
                                     {0, 1, 5}, {0, 5, 4}, {1, 2, 6}, {1, 6, 5},
                                     {2, 3, 7}, {2, 7, 6}, {3, 0, 4}, {3, 4, 7}};
    return sample_of(p, 8, t, 12);
}

/* At a corner of a cube, 270 degrees in all, it has 135 on either side: from the diagonal of one
 * face on along the edge between the two others. */
static void test_mesh_path_halves_the_angle_at_a_vertex(void **state) {
    (void)state;
    struct arena *arena = new_arena();
    struct sample s = cube();
    const struct mesh *mesh = sample_mesh(&s, arena);
    struct mesh_point from;
    struct mesh_path path;
    assert_true(mesh_nearest(mesh, vec3_make(0.5, 0.5, 1.01), MESH_ANY, &from, NULL));
    assert_true(mesh_path_straight(&path, mesh, &from, vec3_make(1, 1, 0)));
    assert_int_equal(mesh_path_length(&path, sqrt(0.5) + 1), MESH_PATH_DONE);
    check_below(vec3_distance(path.at.r, vec3_make(1, 1, 0)), 1e-13);
    sample_free(&s);
    arena_free(arena);
}

/* From the tip of a pyramid with four sides, four ways at right angles take a quarter each. */
static void test_mesh_path_shares_the_angle_out_at_its_start(void **state) {
    (void)state;
    const struct vec3 p[5] = {{0, 0, 2}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}};
    const int32_t t[4][3] = {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 1}};
    struct arena *arena = new_arena();
    struct sample s = sample_of(p, 5, t, 4);
    const struct mesh *mesh = sample_mesh(&s, arena);
    for (int32_t first = 0; first < 4; first++) {
        struct mesh_point tip = {first, p[0]};
        struct vec3 n = mesh->normals[first];
        struct vec3 along = mesh_tangent(mesh, first, vec3_make(0.3, 0.8, -1)), end[4];
        for (int k = 0; k < 4; k++) {
            struct mesh_path path;
            assert_true(mesh_path_straight(&path, mesh, &tip, along));
            assert_int_equal(mesh_path_length(&path, 0.5), MESH_PATH_DONE);
            end[k] = path.at.r;
            along = vec3_cross(n, along);
        }
        for (int k = 0; k < 4; k++)
            check_below(vec3_distance(end[(k + 1) % 4], vec3_make(-end[k].y, end[k].x, end[k].z)),
                        1e-13);
    }
    sample_free(&s);
    arena_free(arena);
}

/* A ring of triangles round (0, 0, 0) with its rim on the unit circle, from angle 0 on. */
static struct sample ring(int n, double step) {
    struct sample s = sample_of(NULL, (size_t)n + 2, NULL, (size_t)n);
    for (int k = 0; k <= n; k++)
        s.vertices[k + 1] = vec3_make(cos(k * step), sin(k * step), 0);
    for (int k = 0; k < n; k++) {
        s.triangles[k][0] = 0;
        s.triangles[k][1] = k + 1;
        s.triangles[k][2] = k + 2;
    }
    return s;
}

/* Along a rim that bends a little it goes on for as long as the whole bend is small. */
static void test_mesh_path_follows_a_rim_that_hardly_bends(void **state) {
    (void)state;
    static const struct {
        double step_deg, length;
        enum mesh_path_end end;
    } rims[] = {{0.5, 2.5, MESH_PATH_DONE},
                {0.5, 4.5, MESH_PATH_BOUNDARY},
                {0.1, 10, MESH_PATH_DONE},
                {1, 1.5, MESH_PATH_BOUNDARY},
                {1, 0.9, MESH_PATH_DONE}};
    for (size_t k = 0; k < sizeof rims / sizeof *rims; k++) {
        struct arena *arena = new_arena();
        double step = rims[k].step_deg * M_PI / 180;
        struct sample s = ring(40, step);
        const struct mesh *mesh = sample_mesh(&s, arena);
        struct mesh_point from = {0, mesh->vertices[1]};
        struct mesh_path path;
        assert_true(mesh_path_straight(&path, mesh, &from, vec3_make(0, 1, 0)));
        assert_int_equal(mesh_path_length(&path, rims[k].length * 2 * sin(step / 2)), rims[k].end);
        check_above(vec3_norm(path.at.r), 0.999);
        assert_false(mesh_path_straight(&path, mesh, &from, vec3_make(0.1, 1, 0)));
        assert_false(mesh_path_straight(&path, mesh, &from, vec3_make(0, -1, 0)));
        sample_free(&s);
        arena_free(arena);
    }
}

static void test_mesh_path_stays_in_the_plane_of_a_section(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    struct arena *arena = new_arena();
    struct sample s = sample_grid(16, 16, NULL);
    sample_map(&s, hilly);
    sample_shuffle(&s, &random);
    const struct mesh *mesh = sample_mesh(&s, arena);
    for (int k = 0; k < 300; k++) {
        bool grid = k % 2; /* along grid lines, through vertices */
        double x = grid ? random_index(&random, 17) / 16.0 : random_between(&random, 0, 1);
        double y = grid ? random_index(&random, 17) / 16.0 : random_between(&random, 0, 1);
        struct vec3 plane = grid ? vec3_make(k % 4 == 1, k % 4 == 3, 0) : random_direction(&random);
        struct mesh_point from = sample_place(mesh, x, y);
        struct mesh_path path;
        if (vec3_norm(vec3_cross(plane, mesh->normals[from.triangle])) < 0.1)
            continue;
        struct vec3 towards = vec3_cross(plane, vec3_make(0, 0, 1));
        if (!mesh_path_section(&path, mesh, &from, plane, towards))
            continue;
        check_above(vec3_dot(path.direction, towards), 0);
        int steps = 0; /* it may go round a hill */
        for (struct vec3 before = from.r;
             steps++ < 200 && mesh_path_chord(&path, 0.02) == MESH_PATH_DONE; before = path.at.r) {
            check_below(fabs(vec3_dot(vec3_sub(path.at.r, from.r), plane)), 1e-12);
            check_below(fabs(vec3_distance(before, path.at.r) - 0.02), 1e-13);
        }
    }
    sample_free(&s);
    arena_free(arena);
}

static void test_mesh_path_without_a_way(void **state) {
    (void)state;
    struct arena *arena = new_arena();
    struct sample s = cube();
    const struct mesh *mesh = sample_mesh(&s, arena);
    struct mesh_point from = {0, {0, 0, 1}};
    struct mesh_path path;
    assert_false(mesh_path_straight(&path, mesh, &from, vec3_make(0, 0, 1)));
    assert_false(mesh_path_section(&path, mesh, &from, vec3_make(0, 0, 1), vec3_make(1, 0, 0)));
    assert_true(mesh_path_straight(&path, mesh, &from, vec3_make(1, 0.1, 0)));
    assert_int_equal(mesh_path_chord(&path, 4), MESH_PATH_LOST);
    assert_true(mesh_path_straight(&path, mesh, &from, vec3_make(1, 0, 0)));
    assert_int_equal(mesh_path_length(&path, 8), MESH_PATH_DONE);
    check_below(vec3_distance(path.at.r, from.r), 1e-13);
    assert_int_equal(mesh_path_length(&path, 0), MESH_PATH_DONE);
    check_below(vec3_distance(path.at.r, from.r), 1e-13);
    sample_free(&s);
    arena_free(arena);
}

static bool beside_slot(struct vec3 middle) {
    return !(fabs(middle.x - 0.5) < 0.1 && middle.y > 0.2);
}

static struct vec3 lifted(struct vec3 p) {
    return vec3_make(p.x, p.y, p.z + 0.05);
}

static void test_mesh_path_connects_only_without_a_gap(void **state) {
    (void)state;
    struct arena *arena = new_arena();
    struct sample s = sample_grid(20, 20, NULL), above = sample_grid(20, 20, NULL);
    sample_keep(&s, beside_slot);
    sample_map(&above, lifted);
    sample_add(&s, &above);
    const struct mesh *mesh = sample_mesh(&s, arena);
    struct mesh_point left, right, low, over;
    mesh_nearest(mesh, vec3_make(0.33, 0.52, 0), 0, &left, NULL);
    mesh_nearest(mesh, vec3_make(0.71, 0.57, 0), 0, &right, NULL);
    mesh_nearest(mesh, vec3_make(0.31, 0.1, 0), 0, &low, NULL);
    mesh_nearest(mesh, vec3_make(0.33, 0.5, 0.05), 1, &over, NULL);
    assert_true(mesh_path_connects(mesh, &left, &left, 1));
    assert_true(mesh_path_connects(mesh, &left, &low, 1));
    assert_true(mesh_path_connects(mesh, &low, &left, 1));
    assert_false(mesh_path_connects(mesh, &left, &low, 0.3));
    assert_false(mesh_path_connects(mesh, &left, &right, 1));
    assert_false(mesh_path_connects(mesh, &left, &over, 1));
    assert_false(mesh_path_connects(mesh, &over, &left, 1));
    sample_free(&s);
    sample_free(&above);
    arena_free(arena);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_mesh_path_is_straight_on_a_plane),
        cmocka_unit_test(test_mesh_path_unfolds),
        cmocka_unit_test(test_mesh_path_ends_at_the_boundary),
        cmocka_unit_test(test_mesh_path_runs_along_the_boundary),
        cmocka_unit_test(test_mesh_path_chords_are_as_long_as_asked),
        cmocka_unit_test(test_mesh_path_halves_the_angle_at_a_vertex),
        cmocka_unit_test(test_mesh_path_shares_the_angle_out_at_its_start),
        cmocka_unit_test(test_mesh_path_follows_a_rim_that_hardly_bends),
        cmocka_unit_test(test_mesh_path_stays_in_the_plane_of_a_section),
        cmocka_unit_test(test_mesh_path_without_a_way),
        cmocka_unit_test(test_mesh_path_connects_only_without_a_gap),
    };
    return cmocka_run_group_tests_name("mesh_path", tests, NULL, NULL);
}
