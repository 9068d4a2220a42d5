/* SPDX-License-Identifier: MIT */
/*
 * A surface cut into faces gives the net of the whole: every scene, cut by lines u = const and
 * v = const, each piece parametrised anew at random, turned round and in any order. DRAPED_SEED
 * sets the seed and DRAPED_ROUNDS how often all are cut; what fails says its seed.
 */
#include "disguise.h"
#include "measure.h"
#include "scenes.h"
#include "tests/check.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { ROUNDS = 1, PIECES_MAX = 64, CELLS = 16 };
static const uint64_t SEED = 20261122;
static const double SAME = 1e-9; /* of the surface's size */
static const double SAME_SHEAR_DEG = 1e-6;

static struct shape pieces[PIECES_MAX];

static struct shell *make_shell(int count, struct arena *arena) {
    struct shell_part *parts = arena_alloc(arena, (size_t)count, sizeof *parts);
    struct shell *shell = NULL;
    struct shell_fault fault;
    for (int k = 0; k < count; k++) {
        struct nurbs nurbs = shape_nurbs(&pieces[k]);
        struct surface *surface;
        assert_int_equal(surface_make(&nurbs, arena, &surface), STATUS_OK);
        parts[k].surface = surface;
    }
    enum status status = shell_make(parts, (size_t)count, 0, arena, &shell, &fault);
    if (status != STATUS_OK)
        print_error("status %d: fault %d of face %d\n", status, fault.kind, fault.face[0]);
    assert_int_equal(status, STATUS_OK);
    return shell;
}

static void cut_lines(double low, double high, int count, uint64_t *seed, double *lines) {
    for (int k = 0; k <= count; k++)
        lines[k] = low + (high - low) * k / count;
    for (int k = 1; k < count; k++)
        lines[k] += random_between(seed, -0.3, 0.3) * (high - low) / count;
}

/* Into count[0] by count[1] pieces, shuffled. */
static void cut(const struct shape *whole, const int count[2], uint64_t *seed) {
    double lower[2], upper[2], lines[2][PIECES_MAX + 1];
    int total = count[0] * count[1];
    shape_domain(whole, lower, upper);
    for (int k = 0; k < 2; k++)
        cut_lines(lower[k], upper[k], count[k], seed, lines[k]);
    for (int n = 0; n < total; n++) {
        int a = n / count[1], b = n % count[1];
        struct shape *piece = &pieces[n];
        *piece = *whole;
        shape_cut(piece, &lines[0][a], &lines[1][b]);
        for (int k = 0; k < 2; k++)
            (void)disguise_direction(piece, k, seed);
        if (random_unit(seed) < 0.5)
            shape_transpose(piece);
    }
    for (int n = total - 1; n > 0; n--) {
        int other = (int)(random_unit(seed) * (n + 1));
        struct shape swap = pieces[n];
        pieces[n] = pieces[other];
        pieces[other] = swap;
    }
}

struct difference {
    double position, shear_deg;
    int missing, extra;
    int bad[2]; /* the first node that is off, counted from the start */
};

static void note(struct difference *most, int i, int j) {
    if (abs(i) + abs(j) >= abs(most->bad[0]) + abs(most->bad[1]))
        return;
    most->bad[0] = i;
    most->bad[1] = j;
}

static bool is_turned(const struct drape_run *whole, const struct drape_result *other) {
    struct vec3 normal = vec3_cross(whole->result.start_warp, whole->result.start_weft);
    return vec3_dot(normal, vec3_cross(other->start_warp, other->start_weft)) < 0;
}

/* Node for node; (i, j) is (i, -j) where the start's face is turned round. */
static struct difference compare(const struct drape_run *whole, const struct drape_result *other,
                                 double off) {
    struct grid grid;
    struct difference most = {.bad = {1000, 1000}};
    const struct drape_nodes *nodes = &whole->result.nodes, *its = &other->nodes;
    bool turned = is_turned(whole, other);
    grid_make(&grid, its);
    for (size_t k = 0; k < nodes->count; k++) {
        int at = grid_find(&grid, nodes->i[k], turned ? -nodes->j[k] : nodes->j[k]);
        if (at < 0) {
            most.missing++;
            note(&most, nodes->i[k], nodes->j[k]);
            continue;
        }
        double shear = turned ? -its->shear_deg[at] : its->shear_deg[at];
        double away = vec3_distance(node_point(nodes, (int)k), node_point(its, at));
        if (away > off)
            note(&most, nodes->i[k], nodes->j[k]);
        most.position = fmax(most.position, away);
        most.shear_deg = fmax(most.shear_deg, fabs(shear - nodes->shear_deg[k]));
    }
    most.extra = (int)its->count - (int)nodes->count + most.missing;
    grid_free(&grid);
    return most;
}

static bool same_as_whole(struct scene *scene, enum drape_method method, uint64_t seed) {
    struct drape_settings settings = scene_settings(scene, method, CELLS);
    struct drape_run whole;
    struct drape_result result = {0};
    struct vec3 low, high;
    struct surface_jet jet;
    uint64_t random = seed;
    shape_evaluate(&scene->shape, scene->start_uv[0], scene->start_uv[1], &jet);
    settings.start_kind = DRAPE_START_POINT;
    settings.start_point = jet.r;
    drape_begin(&whole, &scene->shape, &settings);
    settings.direction_kind = DRAPE_DIRECTION_VECTOR;
    settings.direction_vector = whole.result.start_warp;
    const int count[2] = {1 + (int)(random_unit(&random) * 6), 2 + (int)(random_unit(&random) * 6)};
    cut(&scene->shape, count, &random);
    struct arena *arena = arena_new((size_t)1 << 30);
    struct shell *shell = make_shell(count[0] * count[1], arena);
    enum status status = drape_solve_shell(shell, &settings, NULL, arena, &result);
    if (status == STATUS_OK && is_turned(&whole, &result)) {
        settings.pre_shear_deg = -settings.pre_shear_deg;
        int low_j = settings.extent[1][0];
        settings.extent[1][0] = -settings.extent[1][1];
        settings.extent[1][1] = -low_j;
        status = drape_solve_shell(shell, &settings, NULL, arena, &result);
    }
    assert_int_equal(status, STATUS_OK);
    surface_bounds(whole.surface, &low, &high);
    double size = vec3_distance(low, high);
    struct difference most = compare(&whole, &result, SAME * size);
    bool same = most.missing == 0 && most.extra == 0 && most.position <= SAME * size &&
                most.shear_deg <= SAME_SHEAR_DEG;
    struct shell_edges edges = shell_edges(shell);
    if (!same || getenv("DRAPED_VERBOSE"))
        printf(
            "  %s, method %d, %d x %d faces, seed %llu: %zu nodes, %d missing, %d extra, %.1e of "
            "the size, %.1e deg; %zu joined, %zu free, gap %.1e\n",
            scene->name, method, count[0], count[1], (unsigned long long)seed,
            whole.result.nodes.count, most.missing, most.extra, most.position / size,
            most.shear_deg, edges.joined, edges.free, edges.largest_gap);
    arena_free(arena);
    drape_end(&whole);
    return same;
}

static void test_exact_shell_of_pieces_is_the_whole(void **state) {
    const char *seed_text = getenv("DRAPED_SEED"), *rounds_text = getenv("DRAPED_ROUNDS");
    static const enum drape_method every[] = {DRAPE_GIB, DRAPE_GIB4, DRAPE_BASIC, DRAPE_GEODESIC};
    uint64_t first = seed_text ? strtoull(seed_text, NULL, 10) : SEED;
    int rounds = rounds_text ? atoi(rounds_text) : ROUNDS, bad = 0;
    (void)state;
    printf("  seed %llu\n", (unsigned long long)first);
    for (int round = 0; round < rounds; round++)
        for (int id = 0; id < SCENE_COUNT; id++) {
            struct scene scene;
            uint64_t seed = first + (uint64_t)(round * SCENE_COUNT + id);
            scene_make(&scene, (enum scene_id)id);
            bad += !same_as_whole(&scene, every[seed % 4], seed);
            scene_free(&scene);
        }
    assert_int_equal(bad, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_exact_shell_of_pieces_is_the_whole),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
