/* SPDX-License-Identifier: MIT */
#include "solver/mesh/corner.h"

#include "sample.h"
#include "solver/mesh/path.h"
#include "tests/check.h"
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

static struct arena *new_arena(void) {
    return arena_new((size_t)1 << 32);
}

static struct vec3 hilly(struct vec3 p) {
    return vec3_make(p.x, p.y, 0.1 * sin(6 * p.x) * cos(5 * p.y));
}

static struct vec3 turn_about_z(struct vec3 a, double angle) {
    double c = cos(angle), s = sin(angle);
    return vec3_make(c * a.x - s * a.y, s * a.x + c * a.y, a.z);
}

/* A cell at A with yarns along two directions, chords bd and cd; false when a yarn leaves the
 * mesh. */
static bool make_cell(const struct mesh *mesh, const struct mesh_point *a, struct vec3 warp,
                      struct vec3 weft, const double chord[2], struct mesh_cell *cell) {
    struct mesh_path b, c;
    *cell = (struct mesh_cell){.a = *a, .bd = chord[0], .cd = chord[1]};
    if (!mesh_path_straight(&c, mesh, a, warp) || !mesh_path_straight(&b, mesh, a, weft) ||
        mesh_path_chord(&c, chord[0]) != MESH_PATH_DONE ||
        mesh_path_chord(&b, chord[1]) != MESH_PATH_DONE)
        return false;
    cell->b = b.at;
    cell->c = c.at;
    cell->guess = vec3_sub(vec3_add(b.at.r, c.at.r), a->r);
    double turn = vec3_dot(vec3_cross(warp, weft), mesh->normals[a->triangle]);
    cell->orientation = turn > 0 ? 1 : -1;
    return true;
}

static void check_found(const struct mesh *mesh, const struct mesh_cell *cell,
                        const struct mesh_corner *d, double magnitude) {
    double slack = 1e-12 + 1e-15 * magnitude / fmin(cell->bd, cell->cd);
    check_at_most(d->residual, slack);
    check_at_most(fabs(vec3_distance(d->at.r, cell->b.r) / cell->bd - 1), slack);
    check_at_most(fabs(vec3_distance(d->at.r, cell->c.r) / cell->cd - 1), slack);
    check_below(sample_gap(mesh, &d->at), 1e-12 * magnitude + 2e-9 * cell->bd);
    struct vec3 base = vec3_sub(cell->b.r, cell->c.r), n = mesh->normals[d->at.triangle];
    struct vec3 across = vec3_cross(vec3_sub(d->at.r, cell->c.r), base);
    check_above(cell->orientation * vec3_dot(across, n), 0);
}

static void test_mesh_corner_is_exact_on_a_plane(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    struct arena *arena = new_arena();
    struct sample s = sample_grid(25, 20, &random);
    sample_shuffle(&s, &random);
    const struct mesh *mesh = sample_mesh(&s, arena);
    int found = 0;
    for (int k = 0; k < 3000; k++) {
        struct mesh_point a =
            sample_place(mesh, random_between(&random, 0, 1), random_between(&random, 0, 1));
        double angle = random_between(&random, 0.2, 2.9) * (k % 2 ? 1 : -1);
        double chord[2] = {random_between(&random, 0.001, 0.3), 0};
        chord[1] = k % 3 ? chord[0] : random_between(&random, 0.001, 0.3);
        struct vec3 warp = turn_about_z(vec3_make(1, 0, 0), random_between(&random, 0, 7));
        struct mesh_cell cell;
        struct mesh_corner d;
        if (!make_cell(mesh, &a, warp, turn_about_z(warp, angle), chord, &cell))
            continue;
        struct vec3 g = cell.guess; /* a parallelogram */
        bool inside = g.x >= 0 && g.x <= 1 && g.y >= 0 && g.y <= 1;
        enum mesh_corner_end end = mesh_corner_solve(mesh, &cell, &d);
        if (end != (inside ? MESH_CORNER_FOUND : MESH_CORNER_BOUNDARY))
            fail_msg("cell %d: %d (%s)", k, end, inside ? "inside" : "outside");
        if (!inside)
            continue;
        check_below(vec3_distance(d.at.r, g), 1e-11);
        check_found(mesh, &cell, &d, 1);
        found++;
    }
    check_above(found, 1000);
    sample_free(&s);
    arena_free(arena);
}

/* Along the edges of the mesh and from vertex to vertex of a regular grid. */
static void test_mesh_corner_on_vertices_and_edges(void **state) {
    (void)state;
    enum { N = 12 };
    struct random random = random_begin(__func__);
    struct arena *arena = new_arena();
    struct sample s = sample_grid(N, N, NULL);
    sample_shuffle(&s, &random);
    const struct mesh *mesh = sample_mesh(&s, arena);
    for (int step = 1; step < 4; step++)
        for (int i = 0; i + step <= N; i++)
            for (int j = 0; j + step <= N; j++) {
                double chord = (double)step / N;
                struct mesh_cell cell = {.bd = chord, .cd = chord, .orientation = 1};
                struct mesh_corner d;
                double x = (double)i / N, y = (double)j / N;
                cell.a = sample_place(mesh, x, y);
                cell.c = sample_place(mesh, (double)(i + step) / N, y);
                cell.b = sample_place(mesh, x, (double)(j + step) / N);
                cell.guess = vec3_make(x + chord, y + chord, 0);
                assert_int_equal(mesh_corner_solve(mesh, &cell, &d), MESH_CORNER_FOUND);
                check_below(vec3_distance(d.at.r, cell.guess), 1e-13);
                assert_in_range(d.steps, 1, 40);
            }
    sample_free(&s);
    arena_free(arena);
}

/* All right roots of a cell, by sampling its circle densely: the heights over the mesh z = z(x, y)
 * change their sign there. */
static int scan_roots(const struct mesh *mesh, const struct mesh_cell *cell, struct vec3 nearest_to,
                      double *nearest) {
    enum { STEPS = 4000 };
    struct vec3 base = vec3_sub(cell->c.r, cell->b.r), axis = vec3_unit(base);
    double length = vec3_norm(base);
    double x = (length * length + cell->bd * cell->bd - cell->cd * cell->cd) / (2 * length);
    double radius = sqrt(cell->bd * cell->bd - x * x), before = 0;
    struct vec3 middle = vec3_axpy(x, axis, cell->b.r);
    struct vec3 p = vec3_unit(vec3_cross(axis, vec3_make(0.2, 0.3, 0.9))), q = vec3_cross(axis, p);
    int roots = 0;
    *nearest = HUGE_VAL;
    for (int k = 0; k <= STEPS; k++) {
        double angle = 2 * M_PI * k / STEPS;
        struct vec3 r = vec3_axpy(radius * cos(angle), p, middle);
        struct mesh_point place;
        r = vec3_axpy(radius * sin(angle), q, r);
        mesh_nearest(mesh, r, MESH_ANY, &place, NULL);
        struct vec3 n = mesh->normals[place.triangle];
        double height = vec3_dot(vec3_sub(r, place.r), n);
        struct vec3 across = vec3_cross(vec3_sub(r, cell->c.r), vec3_scale(-1, base));
        bool right = cell->orientation * vec3_dot(across, n) > 0;
        if (k > 0 && height * before < 0 && right) {
            roots++;
            *nearest = fmin(*nearest, vec3_distance(r, nearest_to));
        }
        before = height;
    }
    return roots;
}

static void test_mesh_corner_finds_the_root_of_a_scan(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    struct arena *arena = new_arena();
    struct sample s = sample_grid(14, 14, &random);
    sample_map(&s, hilly);
    sample_shuffle(&s, &random);
    const struct mesh *mesh = sample_mesh(&s, arena);
    int ends[4] = {0};
    for (int k = 0; k < 60; k++) {
        struct mesh_point a = sample_place(mesh, random_between(&random, 0.35, 0.65),
                                           random_between(&random, 0.35, 0.65));
        double chord = random_between(&random, 0.05, 0.3), chords[2] = {chord, chord}, nearest;
        double angle = random_between(&random, 0.3, 2.8) * (k % 2 ? 1 : -1);
        struct vec3 n = mesh->normals[a.triangle];
        struct vec3 warp = mesh_tangent(mesh, a.triangle, random_direction(&random));
        struct vec3 weft = vec3_axpy(sin(angle), vec3_cross(n, warp), vec3_scale(cos(angle), warp));
        struct mesh_cell cell;
        struct mesh_corner d;
        if (!make_cell(mesh, &a, warp, weft, chords, &cell))
            continue;
        enum mesh_corner_end end = mesh_corner_solve(mesh, &cell, &d);
        ends[end]++;
        assert_int_not_equal(end, MESH_CORNER_NO_CONVERGENCE);
        if (end == MESH_CORNER_FOUND) {
            check_found(mesh, &cell, &d, 1);
            check_above(scan_roots(mesh, &cell, d.at.r, &nearest), 0);
            check_below(nearest, 3e-3 * chord);
        } else if (end == MESH_CORNER_COLLAPSED) {
            assert_int_equal(scan_roots(mesh, &cell, cell.guess, &nearest), 0);
        }
    }
    printf("%d found, %d collapsed, %d past the boundary\n", ends[0], ends[1], ends[2]);
    check_above(ends[0], 30);
    sample_free(&s);
    arena_free(arena);
}

/* z = 0 for x <= 0.5, from there on down. */
static struct vec3 over_edge(struct vec3 p) {
    return p.x <= 0.5 ? p : vec3_make(0.5, p.y, 0.5 - p.x);
}

static void test_mesh_corner_over_a_square_edge(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    struct arena *arena = new_arena();
    struct sample s = sample_grid(20, 20, NULL);
    sample_map(&s, over_edge);
    sample_shuffle(&s, &random);
    const struct mesh *mesh = sample_mesh(&s, arena);
    for (int k = 0; k < 200; k++) {
        double chord = random_between(&random, 0.02, 0.12), y = random_between(&random, 0.2, 0.6);
        double before = random_between(&random, 0, chord), chords[2] = {chord, chord};
        struct mesh_point a = sample_place(mesh, 0.5 - before, y);
        struct mesh_cell cell;
        struct mesh_corner d;
        struct vec3 warp = {1, 0, 0}, weft = {0, k % 2 ? 1 : -1, 0};
        assert_true(make_cell(mesh, &a, warp, weft, chords, &cell));
        assert_int_equal(mesh_corner_solve(mesh, &cell, &d), MESH_CORNER_FOUND);
        struct vec3 wanted = vec3_axpy(chord, weft, cell.c.r); /* the net stays square */
        check_below(vec3_distance(d.at.r, wanted), 1e-12);
    }
    sample_free(&s);
    arena_free(arena);
}

static bool not_left_rim(struct vec3 middle) {
    return middle.x > 0.05;
}

static struct vec3 lowered(struct vec3 p) {
    return vec3_make(p.x, p.y, p.z - 0.02);
}

static struct vec3 bent_up(struct vec3 p) {
    return vec3_make(p.x, p.y, 4 * (p.x - 0.5) * (p.x - 0.5));
}

static struct vec3 bent_up_lowered(struct vec3 p) {
    return lowered(bent_up(p));
}

/* Another sheet closely below: D is on that of B and C, or nowhere. */
static void test_mesh_corner_stays_on_its_sheet(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    struct arena *arena = new_arena();
    struct sample s = sample_grid(20, 20, &random), below = sample_grid(20, 20, &random);
    struct vec3 (*const maps[2])(struct vec3) = {bent_up, bent_up_lowered};
    sample_map(&s, maps[0]);
    sample_map(&below, maps[1]);
    for (size_t t = 0; t < below.triangle_count / 2; t++) {
        int32_t second = below.triangles[t][1]; /* mostly its normals are up as well, */
        below.triangles[t][1] = below.triangles[t][2];
        below.triangles[t][2] = second;
    }
    sample_keep(&s, not_left_rim);
    sample_add(&s, &below);
    const struct mesh *mesh = sample_mesh(&s, arena);
    assert_int_equal(mesh->component_count, 2);
    int past = 0;
    for (int k = 0; k < 3000; k++) {
        double x = random_between(&random, 0.06, 0.14), y = random_between(&random, 0.3, 0.7);
        struct mesh_point a;
        struct mesh_cell cell;
        struct mesh_corner d;
        double chords[2] = {0.11, 0.11}, angle = random_between(&random, 0.5, 1.07);
        mesh_nearest(mesh, bent_up(vec3_make(x, y, 0)), 0, &a, NULL);
        struct vec3 warp = mesh_tangent(mesh, a.triangle, vec3_make(-cos(angle), sin(angle), 0));
        struct vec3 weft = mesh_tangent(mesh, a.triangle, vec3_make(-sin(angle), -cos(angle), 0));
        if (!make_cell(mesh, &a, warp, weft, chords, &cell))
            continue;
        enum mesh_corner_end end = mesh_corner_solve(mesh, &cell, &d);
        if (end == MESH_CORNER_FOUND)
            assert_int_equal(mesh->component[d.at.triangle], 0);
        else
            assert_int_equal(end, MESH_CORNER_BOUNDARY);
        past += end != MESH_CORNER_FOUND;
    }
    check_above(past, 20);
    sample_free(&s);
    sample_free(&below);
    arena_free(arena);
}

/* A thin plate, closed round its rim: D never comes to lie on its back. */
static struct vec3 back(struct vec3 p) {
    return vec3_make(p.x, p.y, -0.01);
}

/* Joins the edges of two grids of n x n squares, the first and second half of the vertices. */
static void add_rim(struct sample *plate, int n) {
    size_t sides = 8 * (size_t)n, t = plate->triangle_count;
    struct sample closed =
        sample_of(plate->vertices, plate->vertex_count, NULL, plate->triangle_count + sides);
    int32_t back_side = (n + 1) * (n + 1);
    memcpy(closed.triangles, plate->triangles, t * sizeof *closed.triangles);
    for (int edge = 0; edge < 4; edge++)
        for (int k = 0; k < n; k++, t += 2) {
            int step = edge < 2 ? 1 : n + 1, from = edge % 2 ? (edge < 2 ? n * (n + 1) : n) : 0;
            int32_t a = from + k * step, b = a + step;
            const int32_t corners[2][3] = {{a, b, b + back_side},
                                           {a, b + back_side, a + back_side}};
            memcpy(closed.triangles[t], corners, sizeof corners);
        }
    sample_free(plate);
    *plate = closed;
}

static void test_mesh_corner_never_on_the_back(void **state) {
    (void)state;
    enum { N = 16 };
    struct random random = random_begin(__func__);
    struct arena *arena = new_arena();
    struct sample s = sample_grid(N, N, NULL), under = sample_grid(N, N, NULL);
    sample_map(&under, back);
    sample_add(&s, &under);
    add_rim(&s, N);
    sample_shuffle(&s, &random);
    const struct mesh *mesh = sample_mesh(&s, arena);
    assert_int_equal(mesh->component_count, 1);
    int ends[4] = {0};
    for (int k = 0; k < 2000; k++) {
        struct mesh_point a;
        struct mesh_cell cell;
        struct mesh_corner d;
        double chords[2] = {0.1, 0.1};
        struct vec3 at = {random_between(&random, 0, 1), random_between(&random, 0, 1), 0};
        mesh_nearest(mesh, at, MESH_ANY, &a, NULL);
        struct vec3 warp = turn_about_z(vec3_make(1, 0, 0), random_between(&random, 0, 7));
        if (!make_cell(mesh, &a, warp, turn_about_z(warp, 1.5), chords, &cell) || cell.b.r.z < 0 ||
            cell.c.r.z < 0)
            continue;
        enum mesh_corner_end end = mesh_corner_solve(mesh, &cell, &d);
        ends[end]++;
        if (end == MESH_CORNER_FOUND) {
            check_found(mesh, &cell, &d, 1);
            check_above(d.at.r.z, -0.01 + 1e-12);
        }
    }
    printf("%d found, %d collapsed, %d no convergence\n", ends[0], ends[1], ends[3]);
    assert_true(ends[0] > 1000 && ends[3] == 0 && ends[2] == 0);
    sample_free(&s);
    sample_free(&under);
    arena_free(arena);
}

static bool not_slot(struct vec3 middle) {
    return !(fabs(middle.x - 0.525) < 0.025 && middle.y < 0.4);
}

/* A slot between C and D, none between B and D. */
static void test_mesh_corner_beyond_a_slot(void **state) {
    (void)state;
    struct arena *arena = new_arena();
    struct sample s = sample_grid(20, 20, NULL);
    sample_keep(&s, not_slot);
    const struct mesh *mesh = sample_mesh(&s, arena);
    struct mesh_cell cell = {.bd = 0.2, .cd = 0.2, .orientation = -1};
    struct mesh_corner d;
    cell.a = sample_place(mesh, 0.43, 0.51);
    cell.c = sample_place(mesh, 0.43, 0.31);
    cell.b = sample_place(mesh, 0.63, 0.51);
    cell.guess = vec3_make(0.63, 0.31, 0);
    cell.orientation = 1;
    assert_int_equal(mesh_corner_solve(mesh, &cell, &d), MESH_CORNER_FOUND);
    check_below(vec3_distance(d.at.r, cell.guess), 1e-13);
    cell.a = sample_place(mesh, 0.43, 0.21); /* both beyond */
    cell.c = sample_place(mesh, 0.43, 0.01);
    cell.b = sample_place(mesh, 0.63, 0.21);
    cell.guess = vec3_make(0.63, 0.01, 0);
    assert_int_equal(mesh_corner_solve(mesh, &cell, &d), MESH_CORNER_FOUND);
    cell.b = sample_place(mesh, 0.499, 0.21);
    assert_int_equal(mesh_corner_solve(mesh, &cell, &d), MESH_CORNER_BOUNDARY);
    sample_free(&s);
    arena_free(arena);
}

static void test_mesh_corner_that_has_collapsed(void **state) {
    (void)state;
    struct arena *arena = new_arena();
    struct sample s = sample_grid(10, 10, NULL);
    const struct mesh *mesh = sample_mesh(&s, arena);
    struct mesh_cell cell = {.bd = 0.1, .cd = 0.1, .orientation = 1};
    struct mesh_corner d;
    cell.a = sample_place(mesh, 0.5, 0.5);
    cell.c = sample_place(mesh, 0.61, 0.5);
    cell.b = sample_place(mesh, 0.39, 0.51); /* further apart than the chords reach */
    assert_int_equal(mesh_corner_solve(mesh, &cell, &d), MESH_CORNER_COLLAPSED);
    cell.b = cell.c;
    assert_int_equal(mesh_corner_solve(mesh, &cell, &d), MESH_CORNER_COLLAPSED);
    cell.c = sample_place(mesh, 0.6, 0.5);
    cell.b = sample_place(mesh, 0.5, 0.4); /* the wrong way round */
    assert_int_equal(mesh_corner_solve(mesh, &cell, &d), MESH_CORNER_COLLAPSED);
    cell.orientation = -1;
    assert_int_equal(mesh_corner_solve(mesh, &cell, &d), MESH_CORNER_FOUND);
    cell.bd = NAN;
    assert_int_equal(mesh_corner_solve(mesh, &cell, &d), MESH_CORNER_COLLAPSED);
    sample_free(&s);
    arena_free(arena);
}

static struct vec3 far_off(struct vec3 p) {
    return vec3_axpy(1e-3, hilly(p), vec3_make(500, -300, 200));
}

static void test_mesh_corner_far_from_the_origin(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    struct arena *arena = new_arena();
    struct sample s = sample_grid(20, 20, &random);
    sample_map(&s, far_off);
    const struct mesh *mesh = sample_mesh(&s, arena);
    for (int k = 0; k < 300; k++) {
        struct mesh_point a;
        struct mesh_cell cell;
        struct mesh_corner d;
        double chords[2] = {1e-4, 0.7e-4};
        struct vec3 p = {random_between(&random, 0.3, 0.7), random_between(&random, 0.3, 0.7), 0};
        mesh_nearest(mesh, far_off(p), MESH_ANY, &a, NULL);
        struct vec3 warp = turn_about_z(vec3_make(1, 0, 0), random_between(&random, 0, 7));
        assert_true(make_cell(mesh, &a, warp, turn_about_z(warp, 1.4), chords, &cell));
        assert_int_equal(mesh_corner_solve(mesh, &cell, &d), MESH_CORNER_FOUND);
        check_found(mesh, &cell, &d, 500);
    }
    sample_free(&s);
    arena_free(arena);
}

static double seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Meshes coarser and much finer than the net; prints what a step costs. */
static void test_mesh_corner_on_meshes_of_every_size(void **state) {
    (void)state;
    enum { CELLS = 2000 };
    struct random random = random_begin(__func__);
    for (int n = 10; n <= 700; n *= 4) {
        struct arena *arena = new_arena();
        struct sample s = sample_grid(n, n, &random);
        sample_map(&s, hilly);
        const struct mesh *mesh = sample_mesh(&s, arena);
        int found = 0, steps = 0;
        double spent = 0, chords[2] = {0.025, 0.025};
        for (int k = 0; k < CELLS; k++) {
            struct vec3 p = {random_between(&random, 0, 1), random_between(&random, 0, 1), 0};
            struct vec3 warp = turn_about_z(vec3_make(1, 0, 0), random_between(&random, 0, 7));
            struct mesh_point a;
            struct mesh_cell cell;
            struct mesh_corner d;
            mesh_nearest(mesh, hilly(p), MESH_ANY, &a, NULL);
            if (!make_cell(mesh, &a, warp, turn_about_z(warp, 1.6), chords, &cell))
                continue;
            double begin = seconds();
            enum mesh_corner_end end = mesh_corner_solve(mesh, &cell, &d);
            spent += end == MESH_CORNER_FOUND ? seconds() - begin : 0;
            assert_true(end == MESH_CORNER_FOUND || end == MESH_CORNER_BOUNDARY);
            if (end == MESH_CORNER_FOUND)
                check_found(mesh, &cell, &d, 1);
            found += end == MESH_CORNER_FOUND;
            steps += end == MESH_CORNER_FOUND ? d.steps : 0;
        }
        check_above(found, CELLS * 9 / 10);
        printf("chord %.2f triangles: %.1f triangles, %.0f ns a step\n", 0.025 * n,
               (double)steps / found, 1e9 * spent / found);
        sample_free(&s);
        arena_free(arena);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_mesh_corner_is_exact_on_a_plane),
        cmocka_unit_test(test_mesh_corner_on_vertices_and_edges),
        cmocka_unit_test(test_mesh_corner_finds_the_root_of_a_scan),
        cmocka_unit_test(test_mesh_corner_over_a_square_edge),
        cmocka_unit_test(test_mesh_corner_stays_on_its_sheet),
        cmocka_unit_test(test_mesh_corner_never_on_the_back),
        cmocka_unit_test(test_mesh_corner_beyond_a_slot),
        cmocka_unit_test(test_mesh_corner_that_has_collapsed),
        cmocka_unit_test(test_mesh_corner_far_from_the_origin),
        cmocka_unit_test(test_mesh_corner_on_meshes_of_every_size),
    };
    return cmocka_run_group_tests_name("mesh_corner", tests, NULL, NULL);
}
