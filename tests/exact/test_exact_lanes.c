/* SPDX-License-Identifier: MIT */
/* Nodes found side by side (solver/march/wave.h) and by several threads have the bits of those
 * found one after the other, at any width that this processor has. DRAPED_SEED sets the seed. */
#include "api/threads.h"
#include "disguise.h"
#include "measure.h"
#include "solver/surface/trim.h"
#include "tests/check.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { ROUNDS = 60, WIDTHS = 3, CORNERS = 5 };
static const uint64_t SEED = 20251121;
static const double WHOLE[2] = {0, 2 * M_PI};

static void make_cylinder(struct shape *shape) {
    shape_frustum(shape, WHOLE, (double[2]){1, 0}, (double[2]){1, 2}, M_PI / 2);
}

static void make_frustum(struct shape *shape) {
    shape_frustum(shape, WHOLE, (double[2]){1, 0}, (double[2]){0.5, 1.5}, M_PI / 2);
}

static void make_sphere(struct shape *shape) {
    shape_sphere(shape, 1, WHOLE, (double[2]){-M_PI / 2, M_PI / 2}, M_PI / 2);
}

static void make_hemisphere(struct shape *shape) {
    shape_sphere(shape, 1, WHOLE, (double[2]){0, M_PI / 2}, M_PI / 2);
}

static void make_octant(struct shape *shape) {
    shape_sphere(shape, 1, (double[2]){0, M_PI / 2}, (double[2]){0, M_PI / 2}, M_PI / 2);
}

static void make_thin_torus(struct shape *shape) {
    shape_torus(shape, 2, 0.15, WHOLE, WHOLE, M_PI / 2);
}

static void make_band(struct shape *shape) {
    shape_sphere(shape, 1, WHOLE, (double[2]){-1.2, 1.2}, M_PI / 2);
}

static void make_torus(struct shape *shape) {
    shape_torus(shape, 2, 0.7, WHOLE, WHOLE, M_PI / 2);
}

static void make_quarter_torus(struct shape *shape) {
    shape_torus(shape, 2, 0.7, (double[2]){0, M_PI / 2}, (double[2]){-M_PI / 2, M_PI / 2},
                M_PI / 2);
}

static void make_disk(struct shape *shape) {
    shape_disk(shape, 1);
}

static void make_roof(struct shape *shape) {
    shape_crease(shape, 1, M_PI / 6);
}

static void make_plane(struct shape *shape) {
    shape_plane(shape, (double[2]){0, 2}, (double[2]){0, 1.5});
}

static void (*const shapes[])(struct shape *shape) = {
    make_cylinder, make_frustum, make_sphere,     make_hemisphere,    make_octant,
    make_band,     make_torus,   make_thin_torus, make_quarter_torus, shape_freeform,
    shape_bezier,  make_disk,    make_roof,       make_plane};
enum { SHAPES = sizeof shapes / sizeof *shapes };
static const enum drape_method methods[] = {DRAPE_GIB, DRAPE_BASIC, DRAPE_GIB4, DRAPE_GIB,
                                            DRAPE_GEODESIC};
enum { METHODS = sizeof methods / sizeof *methods };

/* A border with corners on which the domain's middle lies inside, and a hole. */
static struct trim *trim_of(struct shape *shape, struct arena *arena) {
    double corners[2][CORNERS][2], lower[2], upper[2];
    struct trim_curve curve[2];
    struct trim_loop loops[2];
    struct trim *trim;
    struct surface *surface;
    struct nurbs nurbs = shape_nurbs(shape);
    shape_domain(shape, lower, upper);
    for (int k = 0; k < 2; k++) {
        for (int c = 0; c < CORNERS; c++) {
            for (int n = 0; n < 2; n++) {
                double angle = 2 * M_PI * (c + 0.3) / CORNERS;
                double at = (k ? 0.7 : 0.5) + (k ? 0.1 : 0.45) * (n ? sin(angle) : cos(angle));
                corners[k][c][n] = lower[n] + at * (upper[n] - lower[n]);
            }
        }
        curve[k] = (struct trim_curve){
            .degree = 1, .points = (const double(*)[2])corners[k], .count = CORNERS};
        loops[k] = (struct trim_loop){.reversed = k == 0, .curves = &curve[k], .count = 1};
    }
    assert_int_equal(surface_make(&nurbs, arena, &surface), STATUS_OK);
    assert_int_equal(trim_make(surface, loops, 2, arena, &trim), STATUS_OK);
    return trim;
}

static bool same(size_t count, const void *a, const void *b, size_t size) {
    return (!a && !b) || memcmp(a, b, count * size) == 0;
}

static bool same_result(const struct drape_result *a, const struct drape_result *b) {
    const struct drape_nodes *p = &a->nodes, *q = &b->nodes;
    const struct drape_cells *c = &a->cells, *d = &b->cells;
    const struct drape_front *f = &a->front, *g = &b->front;
    const double *nodes[][2] = {{p->u, q->u},
                                {p->v, q->v},
                                {p->x, q->x},
                                {p->y, q->y},
                                {p->z, q->z},
                                {p->shear_deg, q->shear_deg},
                                {p->error_estimate, q->error_estimate}};
    const double *cells[][2] = {{c->warp_x, d->warp_x},      {c->warp_y, d->warp_y},
                                {c->warp_z, d->warp_z},      {c->weft_x, d->weft_x},
                                {c->weft_y, d->weft_y},      {c->weft_z, d->weft_z},
                                {c->shear_deg, d->shear_deg}};
    bool all = p->count == q->count && c->count == d->count && f->count == g->count &&
               memcmp(&a->summary, &b->summary, sizeof a->summary) == 0;
    for (int k = 0; all && k < 7; k++) {
        all = same(p->count, nodes[k][0], nodes[k][1], sizeof(double)) &&
              same(c->count, cells[k][0], cells[k][1], sizeof(double));
    }
    return all && same(p->count, p->i, q->i, sizeof *p->i) &&
           same(p->count, p->j, q->j, sizeof *p->j) && same(p->count, p->grown, q->grown, 1) &&
           same(c->count, c->i, d->i, sizeof *c->i) && same(c->count, c->j, d->j, sizeof *c->j) &&
           same(f->count, f->i, g->i, sizeof *f->i) && same(f->count, f->j, g->j, sizeof *f->j) &&
           same(f->count, f->reason, g->reason, 1);
}

/* One after the other, then at each width, the widest with a team. */
static void check_widths(struct shape *shape, const struct trim *trim,
                         struct drape_settings settings, uint64_t seed) {
    static const int lanes[WIDTHS] = {2, 4, 8}, threads[WIDTHS] = {1, 2, 4};
    struct drape_run alone, wide;
    struct api_threads team;
    settings.lanes = 1;
    settings.team = NULL;
    enum status status = drape_try_trimmed(&alone, shape, trim, &settings);
    for (int k = 0; k < WIDTHS; k++) {
        settings.lanes = lanes[k];
        settings.team = api_threads_make(&team, threads[k]);
        assert_int_equal(drape_try_trimmed(&wide, shape, trim, &settings), status);
        if (status == STATUS_OK && !same_result(&alone.result, &wide.result)) {
            fail_msg("seed %llu: other bits with %d lanes", (unsigned long long)seed, lanes[k]);
        }
        drape_end(&wide);
    }
    drape_end(&alone);
}

/* Parallel fibres, or any slide. */
static double random_slide(uint64_t *seed) {
    return random_unit(seed) < 0.5 ? 1 : random_between(seed, 0.05, 0.95);
}

/* A start, direction, spacing, extent and trim at random, of so many nodes across; some by another
 * method. First as a weave, then as a fabric that slides. */
static void check_drape(struct shape *shape, double least, double most, uint64_t seed) {
    uint64_t more = seed * 31 + 7;
    struct arena *arena = arena_new((size_t)64 << 20);
    const struct trim *trim = NULL;
    double lower[2], upper[2], d = sqrt(shape_area(shape)) / random_between(&more, least, most);
    shape_domain(shape, lower, upper);
    struct drape_settings settings = {
        .method = methods[(int)(random_unit(&more) * METHODS)],
        .spacing = {d, d * random_between(&more, 0.7, 1.4)},
        .start_kind = DRAPE_START_UV,
        .direction_deg = random_between(&more, -180, 180),
        .pre_shear_deg = random_between(&more, -20, 20),
        .has_extent = {random_unit(&more) < 0.3, random_unit(&more) < 0.3},
        .extent = {{-40, 35}, {-29, 38}},
        .max_nodes = 40000,
    };
    for (int k = 0; k < 2; k++) {
        double at = random_between(&more, 0.4, 0.6);
        settings.start_uv[k] = lower[k] + at * (upper[k] - lower[k]);
    }
    if (random_unit(&more) < 0.3) {
        trim = trim_of(shape, arena);
    }
    check_widths(shape, trim, settings, seed);
    settings.pre_shear_deg = 0;
    settings.slide = random_slide(&more);
    check_widths(shape, trim, settings, seed);
    arena_free(arena);
}

static uint64_t first_seed(void) {
    const char *text = getenv("DRAPED_SEED");
    return text ? strtoull(text, NULL, 10) : SEED;
}

static void test_exact_lanes_of_known_shapes_have_same_bits(void **state) {
    static struct shape shape;
    (void)state;
    for (int k = 0; k < SHAPES * check_sized(3, 1); k++) {
        memset(&shape, 0, sizeof shape);
        shapes[k % SHAPES](&shape);
        check_drape(&shape, 12, 110, first_seed() + (uint64_t)k);
    }
}

static void check_random_shapes(int rounds, double least, double most) {
    static struct shape shape;
    printf("  seed %llu\n", (unsigned long long)first_seed());
    for (int k = 0; k < rounds; k++) {
        uint64_t seed = first_seed() + (uint64_t)k, more = seed;
        memset(&shape, 0, sizeof shape);
        shape_random(&shape, &more);
        struct motion steep = motion_stretch(1, 1, random_between(&more, 0.5, 4));
        shape_move(&shape, &steep);
        check_drape(&shape, least, most, seed);
    }
}

static void test_exact_lanes_of_random_shapes_have_same_bits(void **state) {
    (void)state;
    check_random_shapes(check_sized(ROUNDS, 8), 12, 110);
}

/* Where steps of Newton's rule are too long, and single cells are given up or take more rounds. */
static void test_exact_lanes_of_coarse_nets_have_same_bits(void **state) {
    (void)state;
    check_random_shapes(check_sized(600, 120), 4, 14);
}

/* ---- cuts ---- */

enum { ROUNDS_OF_CUTS = 40, CUTS = 2, PATH = 9 };

/* Rows end at a lip and go on behind it: a dome or a saddle with one or two cuts at random. */
static void test_exact_lanes_behind_cuts_have_same_bits(void **state) {
    static struct shape shape;
    (void)state;
    for (int round = 0; round < check_sized(ROUNDS_OF_CUTS, 6); round++) {
        uint64_t seed = first_seed() + (uint64_t)round, more = seed * 31 + 7;
        const double side[2] = {-1, 1};
        double a = random_between(&more, -0.6, 0.6), b = random_between(&more, -0.6, 0.6);
        double d = 2 / random_between(&more, 30, 110);
        struct vec3 path[CUTS][PATH];
        struct drape_cut_line cuts[CUTS];
        shape_quadric(&shape, a, b, side, side);
        for (int n = 0; n < CUTS; n++) { /* one from the edge y = 1, the other from x = -1 */
            double from = random_between(&more, -0.7, 0.7), tip = random_between(&more, -0.6, 0.6);
            double depth = random_between(&more, 0.35, 0.75);
            for (int k = 0; k < PATH; k++) {
                double along = 1 - (1 - depth) * k / (PATH - 1);
                double across = from + (tip - from) * k / (PATH - 1);
                double x = n ? -along : fmax(across, 0.1 - depth), y = n ? across - 0.3 : along;
                path[n][k] = vec3_make(x, y, (a * x * x + b * y * y) / 2);
            }
            cuts[n] = (struct drape_cut_line){path[n], PATH};
        }
        struct drape_settings settings = {.method = methods[(int)(random_unit(&more) * METHODS)],
                                          .spacing = {d, d * random_between(&more, 0.7, 1.4)},
                                          .direction_deg = random_between(&more, -180, 180),
                                          .start_kind = DRAPE_START_POINT,
                                          .cuts = cuts,
                                          .cut_count = 1,
                                          .max_nodes = 40000};
        check_widths(&shape, NULL, settings, seed);
        settings.cut_count = CUTS;
        check_widths(&shape, NULL, settings, seed);
        settings.slide = random_slide(&more);
        check_widths(&shape, NULL, settings, seed);
    }
}

/* ---- shells ---- */

enum { FACES_A_SIDE = 4, FACES = FACES_A_SIDE * FACES_A_SIDE, ROUNDS_OF_SHELLS = 24 };

/* Faces of a surface, each as a shape with a loop round it or without. */
struct faces {
    struct shape shape[FACES];
    double corners[FACES][4][2];
    struct trim_curve curve[FACES];
    struct trim_loop loop[FACES];
    bool trimmed;
    int count;
};

/* Into side x side pieces of the whole by isolines, each with parameters of its own; or quads of
 * the whole, whose inner corners are moved. */
static void cut_faces(const struct shape *whole, int side, uint64_t *seed, struct faces *faces) {
    double lower[2], upper[2], corner[FACES_A_SIDE + 1][FACES_A_SIDE + 1][2];
    static const int8_t round_it[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    *faces = (struct faces){.count = side * side, .trimmed = random_unit(seed) < 0.5};
    shape_domain(whole, lower, upper);
    for (int a = 0; a <= side; a++)
        for (int b = 0; b <= side; b++)
            for (int k = 0; k < 2; k++) {
                int at = k ? b : a;
                bool inner = faces->trimmed && a > 0 && b > 0 && a < side && b < side;
                double moved = inner ? random_between(seed, -0.25, 0.25) : 0;
                double x = lower[k] + (upper[k] - lower[k]) * (at + moved) / side;
                corner[a][b][k] = at == side ? upper[k] : x;
            }
    for (int n = 0; n < faces->count; n++) {
        int a = n / side, b = n % side;
        struct shape *face = &faces->shape[n];
        *face = *whole;
        for (int c = 0; c < 4; c++)
            memcpy(faces->corners[n][c], corner[a + round_it[c][0]][b + round_it[c][1]],
                   sizeof faces->corners[n][c]);
        faces->curve[n] = (struct trim_curve){
            .degree = 1, .points = (const double(*)[2])faces->corners[n], .count = 4};
        faces->loop[n] = (struct trim_loop){true, &faces->curve[n], 1};
        if (faces->trimmed)
            continue;
        shape_cut(face, (double[2]){corner[a][b][0], corner[a + 1][b][0]},
                  (double[2]){corner[a][b][1], corner[a][b + 1][1]});
        for (int k = 0; k < 2; k++)
            (void)disguise_direction(face, k, seed);
        if (random_unit(seed) < 0.5)
            shape_transpose(face);
    }
}

static struct shell *make_shell(struct faces *faces, struct arena *arena) {
    struct shell_patch parts[FACES] = {{0}};
    struct shell *shell;
    for (int k = 0; k < faces->count; k++) {
        struct nurbs nurbs = shape_nurbs(&faces->shape[k]);
        struct surface *surface;
        assert_int_equal(surface_make(&nurbs, arena, &surface), STATUS_OK);
        parts[k] = (struct shell_patch){
            .surface = surface, .loops = &faces->loop[k], .loop_count = faces->trimmed ? 1 : 0};
    }
    assert_int_equal(shell_make(parts, (size_t)faces->count, 0, arena, &shell, NULL), STATUS_OK);
    return shell;
}

/* One after the other, then at each width, the widest with a team; as a weave or sliding. */
static void check_shell(const struct shape *whole, bool slides, uint64_t seed) {
    static const int lanes[] = {1, 2, 4, 8}, threads[] = {1, 1, 2, 4};
    static const enum drape_method by[] = {DRAPE_GIB, DRAPE_GIB4, DRAPE_BASIC};
    static struct faces faces;
    struct arena *arena = arena_new((size_t)1 << 30);
    uint64_t more = seed * 31 + 7;
    cut_faces(whole, 2 + (int)(random_unit(&more) * (FACES_A_SIDE - 1)), &more, &faces);
    struct shell *shell = make_shell(&faces, arena);
    double d = sqrt(shell_area(shell, 0, NULL)) / random_between(&more, 40, 110);
    struct drape_settings settings = {.method = by[seed % 3],
                                      .spacing = {d, d * random_between(&more, 0.7, 1.4)},
                                      .direction_deg = random_between(&more, -180, 180),
                                      .slide = slides ? random_slide(&more) : 0,
                                      .max_nodes = 40000};
    struct drape_result result[4];
    for (int k = 0; k < 4; k++) {
        struct api_threads team;
        settings.lanes = lanes[k];
        settings.team = api_threads_make(&team, threads[k]);
        assert_int_equal(
            drape_solve(&(struct drape_part){.shell = shell}, &settings, NULL, arena, &result[k]),
            STATUS_OK);
        size_t count = result[0].nodes.count;
        if (!same_result(&result[0], &result[k]) ||
            !same(count, result[0].nodes.face, result[k].nodes.face, sizeof(int32_t)))
            fail_msg("seed %llu: other bits with %d lanes", (unsigned long long)seed, lanes[k]);
    }
    arena_free(arena);
}

static void test_exact_lanes_over_the_faces_of_shells_have_same_bits(void **state) {
    static void (*const wholes[])(struct shape *) = {
        shape_bezier, make_quarter_torus, make_octant, make_roof, make_cylinder, shape_freeform};
    static struct shape shape;
    (void)state;
    for (int k = 0; k < check_sized(ROUNDS_OF_SHELLS, 4); k++) {
        uint64_t seed = first_seed() + (uint64_t)k;
        memset(&shape, 0, sizeof shape);
        wholes[seed / 3 % (sizeof wholes / sizeof *wholes)](&shape);
        check_shell(&shape, false, seed);
        check_shell(&shape, true, seed);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_exact_lanes_of_known_shapes_have_same_bits),
        cmocka_unit_test(test_exact_lanes_of_random_shapes_have_same_bits),
        cmocka_unit_test(test_exact_lanes_of_coarse_nets_have_same_bits),
        cmocka_unit_test(test_exact_lanes_behind_cuts_have_same_bits),
        cmocka_unit_test(test_exact_lanes_over_the_faces_of_shells_have_same_bits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
