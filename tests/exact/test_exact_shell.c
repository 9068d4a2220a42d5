/* SPDX-License-Identifier: MIT */
/*
 * A surface cut into faces gives the net of the whole: every scene, cut by lines u = const and
 * v = const, each piece parametrised anew at random, turned round and in any order. DRAPED_SEED
 * sets the seed and DRAPED_ROUNDS how often all are cut; what fails says its seed.
 */
#include "api/threads.h"
#include "disguise.h"
#include "measure.h"
#include "scenes.h"
#include "tests/check.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { ROUNDS = 1, PIECES_MAX = 64, CELLS = 16, CELLS_OF_MOSAIC = 8 };
static const uint64_t SEED = 20261122;
static const double SAME = 1e-9; /* of the surface's size */
static const double GAP = 1e-6;  /* by which faces are off their place, of the size */
static const double SAME_SHEAR_DEG = 1e-6;

/* By which the mosaic of a shell is off the whole's net of chords: of a spacing, and degrees. */
static const double SAME_MOSAIC = 0.02, SAME_MOSAIC_SHEAR_DEG = 3;

/* A loop of lines and cubics in shares of the whole's domain; later in those of the piece. */
enum { CURVES_MAX = 12 };
struct outline {
    int count;
    struct trim_curve curve[CURVES_MAX];
    double point[CURVES_MAX][4][2];
    bool hole;
};

static struct shape pieces[PIECES_MAX];
static struct outline outlines[PIECES_MAX][2]; /* without curves: none */

static double quad_corners[PIECES_MAX][4][2]; /* of pieces by cut_grid, in shares of the domain */

static const double cubic_knots[] = {0, 0, 0, 0, 1, 1, 1, 1};

/* The loops of a piece in its shell's arena. */
static void trim_piece(int k, struct shell_part *part, struct arena *arena) {
    struct trim_loop *loops = arena_alloc(arena, 2, sizeof *loops);
    for (int n = 0; n < 2; n++) {
        struct outline *outline = &outlines[k][n];
        for (int c = 0; c < outline->count; c++)
            outline->curve[c].points = (const double(*)[2])outline->point[c];
        if (outline->count)
            loops[part->loop_count++] = (struct trim_loop){.reversed = !outline->hole,
                                                           .curves = outline->curve,
                                                           .count = (size_t)outline->count};
    }
    part->loops = loops;
}

static struct shell *make_shell(int count, struct arena *arena) {
    struct shell_part *parts = arena_alloc(arena, (size_t)count, sizeof *parts);
    struct shell *shell = NULL;
    struct shell_fault fault;
    for (int k = 0; k < count; k++) {
        struct nurbs nurbs = shape_nurbs(&pieces[k]);
        struct surface *surface;
        assert_int_equal(surface_make(&nurbs, arena, &surface), STATUS_OK);
        parts[k].surface = surface;
        trim_piece(k, &parts[k], arena);
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
    memset(outlines, 0, sizeof outlines);
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

/* ---- joints at a slant, and islands ---- */

static void add_curve(struct outline *outline, const double from[2], const double to[2],
                      const double (*between)[2]) {
    double(*p)[2] = outline->point[outline->count];
    bool line = between == NULL;
    memcpy(p[0], from, sizeof p[0]);
    memcpy(p[line ? 1 : 3], to, sizeof p[0]);
    for (int k = 0; k < 2 && !line; k++)
        memcpy(p[1 + k], between[k], sizeof p[0]);
    outline->curve[outline->count++] = (struct trim_curve){
        .degree = line ? 1 : 3, .count = line ? 2 : 4, .knots = line ? NULL : cubic_knots};
}

static void put_back(double p[2], const double low[2], const double length[2],
                     const double map[2][2], bool swap) {
    for (int k = 0; k < 2; k++)
        p[k] = map[k][0] + map[k][1] * (low[k] + p[k] * length[k]);
    if (swap) {
        double x = p[0];
        p[0] = p[1];
        p[1] = x;
    }
}

/* The piece within its outlines, of a surface that goes on a little beyond them. */
static void make_piece(const struct shape *whole, int n, uint64_t *seed) {
    struct shape *piece = &pieces[n];
    double lower[2], upper[2], length[2], box[2][2], map[2][2];
    shape_domain(whole, lower, upper);
    *piece = *whole;
    for (int k = 0; k < 2; k++) {
        double least = 1, most = 0, margin = random_between(seed, 0, 0.2);
        length[k] = upper[k] - lower[k];
        for (int c = 0; c < outlines[n][0].count && !outlines[n][0].hole; c++)
            for (size_t i = 0; i < outlines[n][0].curve[c].count; i++) {
                least = fmin(least, outlines[n][0].point[c][i][k]);
                most = fmax(most, outlines[n][0].point[c][i][k]);
            }
        if (outlines[n][0].hole) {
            least = 0;
            most = 1;
        }
        box[k][0] = fmax(least - margin, 0);
        box[k][1] = fmin(most + margin, 1);
        for (int e = 0; e < 2; e++)
            box[k][e] = box[k][e] == 1 ? upper[k] : lower[k] + box[k][e] * length[k];
    }
    shape_cut(piece, box[0], box[1]);
    for (int k = 0; k < 2; k++)
        disguise_affine(piece, k, seed, map[k]);
    bool swap = random_unit(seed) < 0.5;
    if (swap)
        shape_transpose(piece);
    for (int loop = 0; loop < 2; loop++)
        for (int c = 0; c < outlines[n][loop].count; c++)
            for (size_t i = 0; i < outlines[n][loop].curve[c].count; i++)
                put_back(outlines[n][loop].point[c][i], lower, length, (const double(*)[2])map,
                         swap);
}

/* Cubics from v = 0 to v = 1 that do not meet, and the strips between them. */
static int cut_strips(const struct shape *whole, uint64_t *seed) {
    double line[PIECES_MAX + 1][4][2];
    int count = 2 + (int)(random_unit(seed) * 6);
    memset(outlines, 0, sizeof outlines);
    for (int k = 0; k <= count; k++)
        for (int i = 0; i < 4; i++) {
            bool end = k == 0 || k == count;
            line[k][i][0] = (double)k / count + (end ? 0 : random_between(seed, -0.4, 0.4) / count);
            line[k][i][1] = i / 3.0;
        }
    for (int k = 0; k < count; k++) {
        struct outline *o = &outlines[k][0];
        double(*a)[2] = line[k], (*b)[2] = line[k + 1];
        const double back[2][2] = {{a[2][0], a[2][1]}, {a[1][0], a[1][1]}};
        add_curve(o, a[0], b[0], NULL);
        add_curve(o, b[0], b[3], (const double(*)[2])(b + 1));
        add_curve(o, b[3], a[3], NULL);
        add_curve(o, a[3], a[0], back);
        make_piece(whole, k, seed);
    }
    return count;
}

/* Quadrilaterals with straight sides round moved points of a grid. */
static int cut_grid(const struct shape *whole, int nu, int nv, uint64_t *seed) {
    static double point[10][10][2];
    int n = 0;
    memset(outlines, 0, sizeof outlines);
    for (int i = 0; i <= nu; i++)
        for (int j = 0; j <= nv; j++) {
            bool in_u = i > 0 && i<nu, in_v = j> 0 && j < nv;
            point[i][j][0] = (i + (in_u ? random_between(seed, -0.3, 0.3) : 0)) / nu;
            point[i][j][1] = (j + (in_v ? random_between(seed, -0.3, 0.3) : 0)) / nv;
        }
    for (int i = 0; i < nu; i++)
        for (int j = 0; j < nv; j++, n++) {
            struct outline *o = &outlines[n][0];
            add_curve(o, point[i][j], point[i + 1][j], NULL);
            add_curve(o, point[i + 1][j], point[i + 1][j + 1], NULL);
            add_curve(o, point[i + 1][j + 1], point[i][j + 1], NULL);
            add_curve(o, point[i][j + 1], point[i][j], NULL);
            for (int c = 0; c < 4; c++)
                memcpy(quad_corners[n][c], o->point[c][0], sizeof quad_corners[n][c]);
            make_piece(whole, n, seed);
        }
    return nu * nv;
}

static int cut_quads(const struct shape *whole, uint64_t *seed) {
    int nu = 1 + (int)(random_unit(seed) * 6), nv = 2 + (int)(random_unit(seed) * 5);
    return cut_grid(whole, nu, nv, seed);
}

/* A rounded island in the whole, begun at different places by the two. */
static int cut_island(const struct shape *whole, uint64_t *seed) {
    double at[2], r = random_between(seed, 0.05, 0.25);
    memset(outlines, 0, sizeof outlines);
    for (int k = 0; k < 2; k++)
        at[k] = random_between(seed, 0.3, 0.7);
    for (int n = 0; n < 2; n++) {
        int first = (int)(random_unit(seed) * 4);
        outlines[n][0].hole = n == 0;
        for (int q = first; q < first + 4; q++) {
            static const int8_t corner[5][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}, {1, 0}};
            double p[4][2];
            for (int k = 0; k < 2; k++) {
                double a = corner[q % 4][k], b = corner[q % 4 + 1][k];
                p[0][k] = at[k] + r * a;
                p[3][k] = at[k] + r * b;
                p[1][k] = at[k] + r * (a + 0.55 * b);
                p[2][k] = at[k] + r * (b + 0.55 * a);
            }
            add_curve(&outlines[n][0], p[0], p[3], (const double(*)[2])(p + 1));
        }
        make_piece(whole, n, seed);
    }
    return 2;
}

/* What real files have: each face a little off its place, and some twice. */
static int disturb(int count, double gap, uint64_t *seed) {
    for (int n = 0; n < count; n++) {
        struct motion motion = motion_identity();
        motion.shift = vec3_make(random_between(seed, -gap, gap), random_between(seed, -gap, gap),
                                 random_between(seed, -gap, gap));
        shape_move(&pieces[n], &motion);
    }
    if (count < PIECES_MAX && random_unit(seed) < 0.5) {
        int twin = (int)(random_unit(seed) * count);
        pieces[count] = pieces[twin];
        memcpy(outlines[count], outlines[twin], sizeof outlines[twin]);
        shape_transpose(&pieces[count]);
        for (int loop = 0; loop < 2; loop++)
            for (int c = 0; c < outlines[count][loop].count; c++)
                for (size_t i = 0; i < outlines[count][loop].curve[c].count; i++) {
                    double *p = outlines[count][loop].point[c][i], x = p[0];
                    p[0] = p[1];
                    p[1] = x;
                }
        count++;
    }
    return count;
}

enum cutting { CUT_ISOLINES, CUT_STRIPS, CUT_QUADS, CUT_ISLAND, CUTTINGS };
static const char *const cutting_names[] = {"isolines", "strips", "quads", "island"};

static int cut_by(enum cutting cutting, const struct shape *whole, uint64_t *seed) {
    if (cutting == CUT_ISOLINES) {
        const int count[2] = {1 + (int)(random_unit(seed) * 6), 2 + (int)(random_unit(seed) * 6)};
        cut(whole, count, seed);
        return count[0] * count[1];
    }
    return cutting == CUT_STRIPS  ? cut_strips(whole, seed)
           : cutting == CUT_QUADS ? cut_quads(whole, seed)
                                  : cut_island(whole, seed);
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

/* Up to its rim the cloth of one is that of the other, where it reaches all of it. */
static bool same_rim(const struct drape_result *whole, const struct drape_result *other) {
    const struct drape_summary *a = &whole->summary, *b = &other->summary;
    if (a->outcome != DRAPE_COMPLETE || whole->rim.count == 0)
        return true;
    return b->outcome == DRAPE_COMPLETE && fabs(b->flat_area / a->flat_area - 1) < 1e-3 &&
           fabs(b->max_shear_deg - a->max_shear_deg) < 0.1;
}

static bool same_as_whole(struct scene *scene, enum cutting cutting, enum drape_method method,
                          bool disturbed, uint64_t seed) {
    bool mosaic = method == DRAPE_MOSAIC;
    struct drape_settings settings =
        scene_settings(scene, method, mosaic ? CELLS_OF_MOSAIC : CELLS);
    struct drape_run whole;
    struct drape_result result = {0};
    struct vec3 low, high;
    struct surface_jet jet;
    uint64_t random = seed;
    shape_evaluate(&scene->shape, scene->start_uv[0], scene->start_uv[1], &jet);
    settings.start_kind = DRAPE_START_POINT;
    settings.start_point = jet.r;
    settings.method = mosaic ? DRAPE_BASIC : method; /* what it tends to */
    drape_begin(&whole, &scene->shape, &settings);
    settings.method = method;
    settings.direction_kind = DRAPE_DIRECTION_VECTOR;
    settings.direction_vector = whole.result.start_warp;
    int count = cut_by(cutting, &scene->shape, &random);
    surface_bounds(whole.surface, &low, &high);
    double size = vec3_distance(low, high);
    if (disturbed)
        count = disturb(count, GAP * size, &random);
    struct arena *arena = arena_new((size_t)1 << 30);
    struct shell *shell = make_shell(count, arena);
    enum status status = drape_solve_shell(shell, &settings, NULL, arena, &result);
    if (status == STATUS_OK && is_turned(&whole, &result)) {
        settings.pre_shear_deg = -settings.pre_shear_deg;
        int low_j = settings.extent[1][0];
        settings.extent[1][0] = -settings.extent[1][1];
        settings.extent[1][1] = -low_j;
        status = drape_solve_shell(shell, &settings, NULL, arena, &result);
    }
    assert_int_equal(status, STATUS_OK);
    struct shell_edges edges = shell_edges(shell);
    /* Twice the gap; faces moved along their joints are further apart than the gap tells. */
    double gap = disturbed ? 2 * sqrt(3) * GAP * size : edges.largest_gap;
    double allowed = SAME * size + 2 * gap, allowed_deg = SAME_SHEAR_DEG;
    if (mosaic) {
        allowed += SAME_MOSAIC * fmin(settings.spacing[0], settings.spacing[1]);
        allowed_deg = SAME_MOSAIC_SHEAR_DEG;
    }
    struct difference most = compare(&whole, &result, allowed);
    bool same = most.missing == 0 && most.extra == 0 && most.position <= allowed &&
                (disturbed || most.shear_deg <= allowed_deg) && same_rim(&whole.result, &result);
    if (!same || getenv("DRAPED_VERBOSE"))
        printf("  %s, method %d, %s, %d faces, seed %llu: %zu nodes, %d missing, %d extra, %.1e of "
               "the size, %.1e deg, first (%d, %d); %zu joined, %zu free, gap %.1e\n",
               scene->name, method, cutting_names[cutting], count, (unsigned long long)seed,
               whole.result.nodes.count, most.missing, most.extra, most.position / size,
               most.shear_deg, most.bad[0], most.bad[1], edges.joined, edges.free,
               edges.largest_gap);
    arena_free(arena);
    drape_end(&whole);
    return same;
}

static bool scene_is_same(int id, enum cutting cutting, bool disturbed, uint64_t seed) {
    static const enum drape_method every[] = {DRAPE_GIB, DRAPE_GIB4, DRAPE_BASIC, DRAPE_GEODESIC};
    struct scene scene;
    scene_make(&scene, (enum scene_id)id);
    bool same = same_as_whole(&scene, cutting, every[seed % 4], disturbed, seed);
    scene_free(&scene);
    return same;
}

/* All scenes, cut one way. */
static void check_cutting(enum cutting cutting, bool disturbed) {
    const char *seed_text = getenv("DRAPED_SEED"), *rounds_text = getenv("DRAPED_ROUNDS");
    uint64_t first = seed_text ? strtoull(seed_text, NULL, 10) : SEED;
    int rounds = rounds_text ? atoi(rounds_text) : ROUNDS, bad = 0;
    printf("  seed %llu\n", (unsigned long long)first);
    for (int round = 0; round < rounds; round++)
        for (int id = 0; id < SCENE_COUNT; id++)
            bad += !scene_is_same(id, cutting, disturbed,
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
        bad += !same_as_whole(&scene, (enum cutting)(own % CUTTINGS), DRAPE_MOSAIC, false, own);
        scene_free(&scene);
    }
    assert_int_equal(bad, 0);
}

static void test_exact_shell_cut_by_isolines_is_the_whole(void **state) {
    (void)state;
    check_cutting(CUT_ISOLINES, false);
}

static void test_exact_shell_cut_into_strips_is_the_whole(void **state) {
    (void)state;
    check_cutting(CUT_STRIPS, false);
}

static void test_exact_shell_cut_into_quads_is_the_whole(void **state) {
    (void)state;
    check_cutting(CUT_QUADS, false);
}

static void test_exact_shell_with_an_island_is_the_whole(void **state) {
    (void)state;
    check_cutting(CUT_ISLAND, false);
}

/* Places next to a vertex of four faces, which any two of them took for the other's; a yarn over
 * the seam of a face and then over its joint. */
static void test_exact_shell_at_vertices_and_seams(void **state) {
    (void)state;
    assert_true(scene_is_same(SCENE_SPHERE, CUT_QUADS, false, 1570958));
    assert_true(scene_is_same(SCENE_SPHERE_EDGE, CUT_QUADS, false, 1675668));
    assert_true(scene_is_same(SCENE_SPHERE_FULL, CUT_ISOLINES, false, 1466231));
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
    int count = cut_grid(&scene.shape, 5, 5, &random), out = 6 + (int)(random_unit(&random) * 3);
    for (int c = 0; c < 4; c++)
        for (int k = 0; k < 2; k++)
            hole[c][k] = lower[k] + (upper[k] - lower[k]) * quad_corners[out][c][k];
    pieces[out] = pieces[count - 1];
    memcpy(outlines[out], outlines[count - 1], sizeof outlines[out]);
    struct arena *arena = arena_new((size_t)1 << 30);
    struct shell *shell = make_shell(count - 1, arena);
    assert_int_equal(drape_solve_shell(shell, &settings, NULL, arena, &result), STATUS_OK);
    bool turned = is_turned(&whole, &result);
    grid_make(&grid, &result.nodes);
    const struct drape_nodes *nodes = &whole.result.nodes;
    for (size_t k = 0; k < nodes->count; k++) {
        const double uv[2] = {nodes->u[k], nodes->v[k]};
        int at = grid_find(&grid, nodes->i[k], turned ? -nodes->j[k] : nodes->j[k]);
        bool inside = in_quad((const double(*)[2])hole, uv);
        in_hole += inside;
        lost += at < 0 && !inside;
        off += at >= 0 && vec3_distance(node_point(nodes, (int)k), node_point(&result.nodes, at)) >
                              SAME * shell_size(shell);
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
    int count = cut_by(cutting, &scene.shape, &random);
    struct arena *arena = arena_new((size_t)1 << 30);
    struct shell *shell = make_shell(count, arena);
    assert_int_equal(drape_solve_shell(shell, &settings, NULL, arena, &result), STATUS_OK);
    bool turned = is_turned(&whole, &result);
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
    double allowed = SAME * shell_size(shell) + (mosaic ? SAME_ROUND_MOSAIC : SAME_ROUND) * d;
    bool same = off <= allowed && (mosaic || furthest <= OFF_OPPOSITE * d) &&
                b->cloth_coverage > 0.999 && b->coverage <= b->cloth_coverage &&
                fabs(b->flat_area / a->flat_area - 1) < 1e-3;
    if (!same || getenv("DRAPED_VERBOSE"))
        printf("  %s, method %d, %s, %d faces, seed %llu: %zu nodes, %d missing, %d extra, %.1e d "
               "off, "
               "missing up to %.2g d beside; cover %.6f %.6f, flat area %.2e\n",
               scene.name, method, cutting_names[cutting], count, (unsigned long long)seed,
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
        int count = cut_by(m == 0 ? CUT_QUADS : CUT_STRIPS, &whole, &seed);
        struct shell *shell = make_shell(count, arena);
        double d = shell_size(shell) / 60;
        struct drape_settings settings = {
            .method = every[m], .spacing = {d, d}, .direction_deg = 17, .max_nodes = 100000};
        assert_int_equal(drape_solve_shell(shell, &settings, NULL, arena, &one), STATUS_OK);
        settings.team = api_threads_make(&team, 4);
        assert_int_equal(drape_solve_shell(shell, &settings, NULL, arena, &four), STATUS_OK);
        check_bits(&one.nodes, &four.nodes);
        arena_free(arena);
    }
}

static void survive_failing_allocations(int count, enum drape_method method, double d) {
    enum status status = STATUS_OUT_OF_MEMORY;
    size_t n = 1;
    for (; status != STATUS_OK; n += (size_t)check_stride(3)) {
        struct arena *arena = arena_new((size_t)1 << 28);
        struct shell_part parts[4] = {{0}};
        struct shell *shell;
        struct drape_result result;
        for (int k = 0; k < count; k++) {
            struct nurbs nurbs = shape_nurbs(&pieces[k]);
            struct surface *surface;
            assert_int_equal(surface_make(&nurbs, arena, &surface), STATUS_OK);
            parts[k].surface = surface;
            trim_piece(k, &parts[k], arena);
        }
        arena_fail_at(arena, n);
        status = shell_make(parts, (size_t)count, 0, arena, &shell, NULL);
        struct drape_settings settings = {.method = method, .spacing = {d, d}, .max_nodes = 10000};
        if (status == STATUS_OK)
            status = drape_solve_shell(shell, &settings, NULL, arena, &result);
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
    int count = cut_grid(&whole, 2, 2, &seed);
    survive_failing_allocations(count, DRAPE_GIB, 0.3);
    survive_failing_allocations(count, DRAPE_MOSAIC, 0.3);
    scene_make(&tube, SCENE_CYLINDER_FULL);
    count = cut_grid(&tube.shape, 2, 2, &seed);
    survive_failing_allocations(count, DRAPE_GIB, 2);
    scene_free(&tube);
}

static void test_exact_shell_with_gaps_is_nearly_the_whole(void **state) {
    (void)state;
    check_cutting(CUT_ISOLINES, true);
    check_cutting(CUT_QUADS, true);
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
        cmocka_unit_test(test_exact_shell_of_a_tube_is_cut_open_opposite_the_start),
        cmocka_unit_test(test_exact_shell_has_same_bits_with_threads),
        cmocka_unit_test(test_exact_shell_survives_failing_allocations),
        cmocka_unit_test(test_exact_shell_with_gaps_is_nearly_the_whole),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
