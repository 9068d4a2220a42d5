/* SPDX-License-Identifier: MIT */
/*
 * A surface cut into faces gives the net of the whole: every scene, cut by lines u = const and
 * v = const, each piece parametrised anew at random, turned round and in any order. DRAPED_SEED
 * sets the seed and DRAPED_ROUNDS how often all are cut; what fails says its seed.
 */
#include "api/threads.h"
#include "measure.h"
#include "solver/shell/shell_slit.h"
#include "tests/check.h"
#include "whole.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { ROUNDS = 1, CELLS = 16 };
static const uint64_t SEED = 20261122;
static const double GAP = 1e-6; /* by which faces are off their place, of the size */

static const enum drape_method methods[] = {DRAPE_GIB, DRAPE_GEODESIC, DRAPE_GIB4, DRAPE_BASIC};

static struct pieces pieces;

/* All scenes, cut one way. */
static void check_cutting(enum cutting cutting, double gap) {
    const char *seed_text = getenv("DRAPED_SEED"), *rounds_text = getenv("DRAPED_ROUNDS");
    uint64_t first = seed_text ? strtoull(seed_text, NULL, 10) : SEED;
    int rounds = rounds_text ? atoi(rounds_text) : ROUNDS, bad = 0;
    printf("  seed %llu\n", (unsigned long long)first);
    for (int round = 0; round < rounds; round++)
        for (int id = 0; id < SCENE_COUNT; id++)
            bad += !whole_scene_is_same((enum scene_id)id, cutting, gap,
                                        first + (uint64_t)(round * SCENE_COUNT + id));
    assert_int_equal(bad, 0);
}

/* The faces as triangles; cut in one way after the other. */
static void test_exact_shell_mosaic_is_nearly_the_whole(void **state) {
    (void)state;
    const char *seed_text = getenv("DRAPED_SEED");
    uint64_t seed = seed_text ? strtoull(seed_text, NULL, 10) : SEED;
    int bad = 0;
    for (int id = 0; id < SCENE_COUNT; id += check_stride(3)) {
        struct scene scene;
        scene_make(&scene, (enum scene_id)id);
        uint64_t own = seed + (uint64_t)id;
        const struct whole_case c = {(enum cutting)(own % CUTTINGS), DRAPE_MOSAIC, 0, own, 0};
        bad += !whole_is_same(&scene, &c);
        scene_free(&scene);
    }
    assert_int_equal(bad, 0);
}

static void test_exact_shell_cut_by_isolines_is_the_whole(void **state) {
    (void)state;
    check_cutting(CUT_ISOLINES, 0);
}

static void test_exact_shell_cut_into_strips_is_the_whole(void **state) {
    (void)state;
    check_cutting(CUT_STRIPS, 0);
}

static void test_exact_shell_cut_into_quads_is_the_whole(void **state) {
    (void)state;
    check_cutting(CUT_QUADS, 0);
}

static void test_exact_shell_with_an_island_is_the_whole(void **state) {
    (void)state;
    check_cutting(CUT_ISLAND, 0);
}

/* Places next to a vertex of four faces, which any two of them took for the other's; a yarn over
 * the seam of a face and then over its joint. */
static void test_exact_shell_at_vertices_and_seams(void **state) {
    (void)state;
    assert_true(whole_scene_is_same(SCENE_SPHERE, CUT_QUADS, 0, 1570958));
    assert_true(whole_scene_is_same(SCENE_SPHERE_EDGE, CUT_QUADS, 0, 1675668));
    assert_true(whole_scene_is_same(SCENE_SPHERE_FULL, CUT_ISOLINES, 0, 1466231));
}

/* Whether (u, v) lies in the quadrilateral of an outline; all of its corners turn one way. */
static bool in_quad(const double corner[4][2], const double uv[2]) {
    int left = 0;
    for (int k = 0; k < 4; k++) {
        const double *a = corner[k], *b = corner[(k + 1) % 4];
        left += (b[0] - a[0]) * (uv[1] - a[1]) > (b[1] - a[1]) * (uv[0] - a[0]);
    }
    return left == 0 || left == 4;
}

/* Without one of the faces the net runs over the hole: nothing else of it is missing. */
static void check_hole(enum scene_id id, uint64_t seed) {
    static struct scene scene;
    struct drape_run whole;
    struct drape_result result;
    struct grid grid;
    double hole[4][2], lower[2], upper[2];
    int lost = 0, off = 0, in_hole = 0;
    uint64_t random = seed;
    scene_make(&scene, id);
    struct drape_settings settings = scene_settings(&scene, DRAPE_GIB, CELLS);
    settings.start_kind = DRAPE_START_POINT;
    settings.start_point = shape_point(&scene.shape, scene.start_uv);
    drape_begin(&whole, &scene.shape, &settings);
    settings.direction_kind = DRAPE_DIRECTION_VECTOR;
    settings.direction_vector = whole.result.start_warp;
    shape_domain(&scene.shape, lower, upper);
    pieces_cut_grid(&pieces, &scene.shape, 5, 5, &random);
    int last = --pieces.count, out = 6 + (int)(random_unit(&random) * 3);
    for (int c = 0; c < 4; c++)
        for (int k = 0; k < 2; k++)
            hole[c][k] = lower[k] + (upper[k] - lower[k]) * pieces.corners[out][c][k];
    pieces.shape[out] = pieces.shape[last];
    memcpy(pieces.outline[out], pieces.outline[last], sizeof pieces.outline[out]);
    struct arena *arena = arena_new((size_t)1 << 30);
    struct shell *shell = pieces_shell(&pieces, arena);
    assert_int_equal(
        drape_solve(&(struct drape_part){.shell = shell}, &settings, NULL, arena, &result),
        STATUS_OK);
    bool turned = whole_is_turned(&whole, &result);
    grid_make(&grid, &result.nodes);
    const struct drape_nodes *nodes = &whole.result.nodes;
    for (size_t k = 0; k < nodes->count; k++) {
        const double uv[2] = {nodes->u[k], nodes->v[k]};
        int at = grid_find(&grid, nodes->i[k], turned ? -nodes->j[k] : nodes->j[k]);
        bool inside = in_quad((const double(*)[2])hole, uv);
        in_hole += inside;
        lost += at < 0 && !inside;
        off += at >= 0 && vec3_distance(node_point(nodes, (int)k), node_point(&result.nodes, at)) >
                              WHOLE_SAME * shell_size(shell);
    }
    printf("  %s: %zu nodes, %d in the hole, %d lost, %d off\n", scene.name, nodes->count, in_hole,
           lost, off);
    assert_int_equal(lost, 0);
    assert_int_equal(off, 0);
    grid_free(&grid);
    arena_free(arena);
    drape_end(&whole);
    scene_free(&scene);
}

static void test_exact_shell_runs_over_a_hole(void **state) {
    (void)state;
    check_hole(SCENE_SPHERE, SEED);
    check_hole(SCENE_SADDLE, SEED + 1);
    check_hole(SCENE_PLANE, SEED + 2);
    check_hole(SCENE_CYLINDER, SEED + 3);
}

/* A strap that runs out into a wider plate, both flat: their joint goes on beyond the strap along
 * the plate's own border, and yarns that have left the strap at its side enter the plate there.
 * Turned at random, so that nothing is told by rounding. */
static void test_exact_shell_strap_runs_out_into_a_plate(void **state) {
    static const double side[2][2][2] = {{{-0.5, 0.5}, {0, 2}}, {{-1.5, 1.5}, {2, 3.5}}};
    static const struct vec3 start = {0, 0.3, 0}, ahead = {0.17, 0.98, 0};
    uint64_t seed = SEED;
    double worst = 0;
    (void)state;
    for (int round = 0; round < 16; round++) {
        struct drape_result result;
        struct vec3 axis = {random_unit(&seed), random_unit(&seed), random_unit(&seed)};
        struct motion move = motion_similar(1, vec3_unit(axis), random_between(&seed, 1, 3),
                                            vec3_make(0, 0, random_between(&seed, 0, 3)));
        pieces = (struct pieces){.count = 2};
        for (int k = 0; k < 2; k++) {
            shape_plane(&pieces.shape[k], side[k][0], side[k][1]);
            shape_move(&pieces.shape[k], &move);
            if (round >> k & 1)
                shape_transpose(&pieces.shape[k]);
        }
        struct drape_settings settings = {.method = methods[round / 4],
                                          .spacing = {0.05, 0.05},
                                          .start_kind = DRAPE_START_POINT,
                                          .start_point = motion_point(&move, start),
                                          .direction_kind = DRAPE_DIRECTION_VECTOR,
                                          .direction_vector = motion_vector(&move, ahead),
                                          .max_nodes = 20000};
        struct arena *arena = arena_new((size_t)1 << 28);
        struct shell *shell = pieces_shell(&pieces, arena);
        assert_int_equal(
            drape_solve(&(struct drape_part){.shell = shell}, &settings, NULL, arena, &result),
            STATUS_OK);
        struct vec3 origin = settings.start_point;
        for (size_t n = 0; n < result.nodes.count; n++) {
            struct vec3 flat = vec3_axpy(0.05 * result.nodes.i[n], result.start_warp, origin);
            flat = vec3_axpy(0.05 * result.nodes.j[n], result.start_weft, flat);
            worst = fmax(worst, vec3_distance(flat, node_point(&result.nodes, (int)n)) / 0.05);
        }
        assert_int_equal(result.summary.outcome, DRAPE_COMPLETE);
        check_below(1 - result.summary.cloth_coverage, 1e-9);
        check_below(result.summary.max_shear_deg, 1e-6);
        arena_free(arena);
    }
    printf("  nodes off by %.1e spacings\n", worst);
    check_below(worst, 1e-9);
}

/* ---- tubes: cut open opposite the start ---- */

/* By which the opening of a shell may be off the line opposite the start, in spacings. */
static const double OFF_OPPOSITE = 1;

/* By which the nodes of a shell may be off those of the whole, in spacings: gib4 corrects next to
 * the opening by what lies beyond it, and chords of a mosaic go a long way here. */
static const double SAME_ROUND = 1e-4, SAME_ROUND_MOSAIC = 0.3;

/* By how much a place of the whole is beside the line opposite the start: 1 is half a turn. */
static struct vec3 shell_centre(const struct shell *shell) {
    struct vec3 low, high;
    shell_bounds(shell, &low, &high);
    return vec3_scale(0.5, vec3_add(low, high));
}

static double beside_opposite(const struct scene *scene, double u) {
    double lower[2], upper[2];
    shape_domain(&scene->shape, lower, upper);
    double turns = fabs(u - scene->start_uv[0]) / (upper[0] - lower[0]);
    return 1 - 2 * fmin(turns, 1 - turns);
}

/* Without extents: the same nodes, but for some next to the line opposite the start, and cloth all
 * round. */
static bool tube_is_same(enum scene_id id, enum cutting cutting, enum drape_method method,
                         uint64_t seed) {
    static struct scene scene;
    struct drape_run whole;
    struct drape_result result;
    struct grid grid;
    uint64_t random = seed;
    scene_make(&scene, id);
    bool mosaic = method == DRAPE_MOSAIC;
    struct drape_settings settings = scene_settings(&scene, mosaic ? DRAPE_BASIC : method, CELLS);
    settings.has_extent[0] = settings.has_extent[1] = false;
    settings.start_kind = DRAPE_START_POINT;
    settings.start_point = shape_point(&scene.shape, scene.start_uv);
    drape_begin(&whole, &scene.shape, &settings);
    settings.method = method;
    settings.direction_kind = DRAPE_DIRECTION_VECTOR;
    settings.direction_vector = whole.result.start_warp;
    pieces_cut(&pieces, cutting, &scene.shape, &random);
    struct arena *arena = arena_new((size_t)1 << 30);
    struct shell *shell = pieces_shell(&pieces, arena);
    assert_int_equal(
        drape_solve(&(struct drape_part){.shell = shell}, &settings, NULL, arena, &result),
        STATUS_OK);
    bool turned = whole_is_turned(&whole, &result);
    double d = fmin(settings.spacing[0], settings.spacing[1]), off = 0, furthest = 0;
    double round = 2 * vec3_distance(settings.start_point, shell_centre(shell));
    const struct drape_nodes *nodes = &whole.result.nodes;
    int missing = 0;
    grid_make(&grid, &result.nodes);
    for (size_t k = 0; k < nodes->count; k++) {
        int at = grid_find(&grid, nodes->i[k], turned ? -nodes->j[k] : nodes->j[k]);
        missing += at < 0;
        if (at < 0)
            furthest = fmax(furthest, beside_opposite(&scene, nodes->u[k]) * round);
        else
            off =
                fmax(off, vec3_distance(node_point(nodes, (int)k), node_point(&result.nodes, at)));
    }
    int extra = (int)result.nodes.count - (int)nodes->count + missing;
    const struct drape_summary *a = &whole.result.summary, *b = &result.summary;
    double allowed = WHOLE_SAME * shell_size(shell) + (mosaic ? SAME_ROUND_MOSAIC : SAME_ROUND) * d;
    bool same = off <= allowed && (mosaic || furthest <= OFF_OPPOSITE * d) &&
                b->cloth_coverage > 0.999 && b->coverage <= b->cloth_coverage &&
                fabs(b->flat_area / a->flat_area - 1) < 1e-3;
    if (!same || getenv("DRAPED_VERBOSE"))
        printf("  %s, method %d, %s, %d faces, seed %llu: %zu nodes, %d missing, %d extra, %.1e d "
               "off, "
               "missing up to %.2g d beside; cover %.6f %.6f, flat area %.2e\n",
               scene.name, method, cutting_name(cutting), pieces.count, (unsigned long long)seed,
               nodes->count, missing, extra, off / d, furthest / d, b->coverage, b->cloth_coverage,
               b->flat_area / a->flat_area - 1);
    grid_free(&grid);
    arena_free(arena);
    drape_end(&whole);
    scene_free(&scene);
    return same;
}

static void test_exact_shell_of_a_tube_is_cut_open_opposite_the_start(void **state) {
    static const enum drape_method every[] = {DRAPE_GIB, DRAPE_GIB4, DRAPE_BASIC, DRAPE_GEODESIC,
                                              DRAPE_MOSAIC};
    const char *seed_text = getenv("DRAPED_SEED"), *rounds_text = getenv("DRAPED_ROUNDS");
    uint64_t seed = seed_text ? strtoull(seed_text, NULL, 10) : SEED;
    int rounds = rounds_text ? atoi(rounds_text) : ROUNDS, step = check_stride(2), bad = 0;
    (void)state;
    for (int round = 0; round < rounds; round++)
        for (int m = 0; m < 5; m += step, seed += (uint64_t)step) {
            enum cutting cutting = (enum cutting)(seed % CUTTINGS);
            bad += !tube_is_same(SCENE_CYLINDER_FULL, cutting, every[m], seed);
            bad += !tube_is_same(SCENE_CONE_FULL, cutting, every[m], seed);
        }
    assert_int_equal(bad, 0);
}

/* The cut passes a joint where rounding leaves a piece of it that has no direction, and a yarn
 * passes the cut there. */
static void test_exact_shell_of_a_tube_is_cut_open_over_joints(void **state) {
    (void)state;
    assert_true(tube_is_same(SCENE_CYLINDER_FULL, CUT_ISOLINES, DRAPE_GIB, 36));
}

/* Ways over a slit of two pieces, whose ends lie back over each other by what faces are off their
 * joint, pass it once wherever they meet it. */
static void test_exact_shell_slit_is_passed_next_to_a_joint(void **state) {
    static const double x[2] = {-1, 1}, y[2][2] = {{-1, 0}, {0, 1}}, back = 2e-6;
    static const struct vec3 normal = {0, 0, 1};
    (void)state;
    pieces = (struct pieces){.count = 2};
    for (int k = 0; k < 2; k++)
        shape_plane(&pieces.shape[k], x, y[k]);
    struct arena *arena = arena_new((size_t)1 << 26);
    struct shell *shell = pieces_shell(&pieces, arena);
    double uv[2][2][2] = {{{0, -1}, {0, back}}, {{0, 0}, {0, 1}}};
    struct vec3 r[2][2] = {{{0, -1, 0}, {0, back, 0}}, {{0, 0, 0}, {0, 1, 0}}};
    const struct shell_slit_piece piece[2] = {
        {.face = 0, .begins = true, .count = 2, .uv = uv[0], .r = r[0]},
        {.face = 1, .ends = true, .count = 2, .uv = uv[1], .r = r[1]}};
    const struct shell_slit_lines lines = {.pieces = piece, .count = 2, .reach = 0.2, .beyond = 1};
    struct shell_slit *slit;
    assert_int_equal(shell_slit_make(shell, &lines, arena, &slit), STATUS_OK);
    for (int k = 0; k < 1000; k++) {
        double at = 0.1 * (k - 499.5) / 500, slope = 0.02 * (k % 5 - 2);
        const struct shell_slit_point left = {{-0.03, at - slope, 0}, normal},
                                      right = {{0.05, at + slope, 0}, normal};
        assert_int_equal(shell_slit_passes(slit, &right, &left), 1);
        assert_int_equal(shell_slit_passes(slit, &left, &right), -1);
    }
    arena_free(arena);
}

static void check_bits(const struct drape_nodes *a, const struct drape_nodes *b) {
    const double *columns[][2] = {{a->u, b->u}, {a->v, b->v}, {a->x, b->x},
                                  {a->y, b->y}, {a->z, b->z}, {a->shear_deg, b->shear_deg}};
    assert_int_equal(a->count, b->count);
    for (size_t k = 0; k < sizeof columns / sizeof *columns; k++)
        assert_memory_equal(columns[k][0], columns[k][1], a->count * sizeof(double));
    assert_memory_equal(a->face, b->face, a->count * sizeof *a->face);
}

/* The same bits with several threads. */
static void test_exact_shell_has_same_bits_with_threads(void **state) {
    static const enum drape_method every[] = {DRAPE_GIB, DRAPE_GIB4, DRAPE_GEODESIC};
    (void)state;
    for (int m = 0; m < 3; m++) {
        struct arena *arena = arena_new((size_t)1 << 30);
        static struct shape whole;
        struct drape_result one, four;
        struct api_threads team;
        uint64_t seed = SEED + (uint64_t)m;
        shape_freeform(&whole);
        pieces_cut(&pieces, m == 0 ? CUT_QUADS : CUT_STRIPS, &whole, &seed);
        struct shell *shell = pieces_shell(&pieces, arena);
        double d = shell_size(shell) / 60;
        struct drape_settings settings = {
            .method = every[m], .spacing = {d, d}, .direction_deg = 17, .max_nodes = 100000};
        assert_int_equal(
            drape_solve(&(struct drape_part){.shell = shell}, &settings, NULL, arena, &one),
            STATUS_OK);
        settings.team = api_threads_make(&team, 4);
        assert_int_equal(
            drape_solve(&(struct drape_part){.shell = shell}, &settings, NULL, arena, &four),
            STATUS_OK);
        check_bits(&one.nodes, &four.nodes);
        arena_free(arena);
    }
}

static void survive_failing_allocations(enum drape_method method, double d) {
    enum status status = STATUS_OUT_OF_MEMORY;
    size_t n = 1;
    for (; status != STATUS_OK; n += (size_t)check_stride(3)) {
        struct arena *arena = arena_new((size_t)1 << 28);
        struct shell_patch *parts = pieces_parts(&pieces, arena);
        struct shell *shell;
        struct drape_result result;
        arena_fail_at(arena, n);
        status = shell_make(parts, (size_t)pieces.count, 0, arena, &shell, NULL);
        struct drape_settings settings = {.method = method, .spacing = {d, d}, .max_nodes = 10000};
        if (status == STATUS_OK)
            status =
                drape_solve(&(struct drape_part){.shell = shell}, &settings, NULL, arena, &result);
        if (status != STATUS_OK)
            assert_int_equal(status, STATUS_OUT_OF_MEMORY);
        arena_free(arena);
    }
    check_above(n, 20);
}

/* Whichever allocation fails, making and draping a shell end as out of memory. */
static void test_exact_shell_survives_failing_allocations(void **state) {
    static struct shape whole;
    static struct scene tube;
    uint64_t seed = SEED;
    (void)state;
    shape_freeform(&whole);
    pieces_cut_grid(&pieces, &whole, 2, 2, &seed);
    survive_failing_allocations(DRAPE_GIB, 0.3);
    survive_failing_allocations(DRAPE_MOSAIC, 0.3);
    scene_make(&tube, SCENE_CYLINDER_FULL);
    pieces_cut_grid(&pieces, &tube.shape, 2, 2, &seed);
    survive_failing_allocations(DRAPE_GIB, 2);
    scene_free(&tube);
}

static void test_exact_shell_with_gaps_is_nearly_the_whole(void **state) {
    (void)state;
    check_cutting(CUT_ISOLINES, GAP);
    check_cutting(CUT_QUADS, GAP);
}

/* Of a sphere between two latitudes the mean normal is as long as the mean of their sines; rims are
 * measured as 16 chords of each edge. */
static void test_exact_shell_flatness_is_the_mean_normal(void **state) {
    static const double turn[2] = {0, 2 * M_PI}, lower[] = {-M_PI / 2, -0.9},
                        upper[] = {-0.5, 0, 0.6, M_PI / 2};
    static struct shape whole;
    uint64_t seed = SEED;
    (void)state;
    for (int k = 0; k < 8; k++) {
        const double latitude[2] = {lower[k / 4], upper[k % 4]};
        double exact = fabs(sin(latitude[0]) + sin(latitude[1])) / 2;
        struct arena *arena = arena_new((size_t)1 << 28);
        assert_non_null(arena);
        shape_sphere(&whole, 1, turn, latitude, M_PI / 2);
        pieces_cut_grid(&pieces, &whole, 3, 2, &seed);
        assert_true(fabs(shell_flatness(pieces_shell(&pieces, arena), 0) - exact) < 4e-3);
        arena_free(arena);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_exact_shell_mosaic_is_nearly_the_whole),
        cmocka_unit_test(test_exact_shell_cut_by_isolines_is_the_whole),
        cmocka_unit_test(test_exact_shell_cut_into_strips_is_the_whole),
        cmocka_unit_test(test_exact_shell_cut_into_quads_is_the_whole),
        cmocka_unit_test(test_exact_shell_with_an_island_is_the_whole),
        cmocka_unit_test(test_exact_shell_at_vertices_and_seams),
        cmocka_unit_test(test_exact_shell_runs_over_a_hole),
        cmocka_unit_test(test_exact_shell_strap_runs_out_into_a_plate),
        cmocka_unit_test(test_exact_shell_of_a_tube_is_cut_open_opposite_the_start),
        cmocka_unit_test(test_exact_shell_of_a_tube_is_cut_open_over_joints),
        cmocka_unit_test(test_exact_shell_slit_is_passed_next_to_a_joint),
        cmocka_unit_test(test_exact_shell_has_same_bits_with_threads),
        cmocka_unit_test(test_exact_shell_survives_failing_allocations),
        cmocka_unit_test(test_exact_shell_with_gaps_is_nearly_the_whole),
        cmocka_unit_test(test_exact_shell_flatness_is_the_mean_normal),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
