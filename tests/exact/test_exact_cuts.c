/* SPDX-License-Identifier: MIT */
/* Cuts with exact answers: a cone to its apex, the corner of a box, a slit in a plane. */
#include "measure.h"
#include "pieces.h"
#include "shapes.h"
#include "solver/drape.h"
#include "solver/shell/shell.h"
#include "solver/surface/trim.h"
#include "tests/check.h"
#include "whole.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

static const uint64_t SEED = 20261124;

/* Nodes, in spacings; the angle at the tip, in degrees; and shear. */
struct bounds {
    enum drape_method method;
    double node, tip_deg, shear_deg;
};

static struct surface *surface_of(struct shape *shape, struct arena *arena) {
    struct nurbs nurbs = shape_nurbs(shape);
    struct surface *surface;
    assert_int_equal(surface_make(&nurbs, arena, &surface), STATUS_OK);
    return surface;
}

/* What all cuts of a developable part leave: everything covered, no shear, and the area. */
static void check_cloth(const struct drape_result *result, double tip_deg,
                        const struct bounds *bounds) {
    assert_int_equal(result->cuts.count, 1);
    printf("    %-8s %5zu nodes, covers %.6f, area off by %.1e, tip %.9f deg, shear %.1e deg\n",
           drape_method_names[bounds->method], result->nodes.count, result->summary.cloth_coverage,
           result->summary.cloth_area / result->summary.part_area - 1,
           result->cuts.tip_angle_deg[0], result->summary.max_shear_deg);
    check_below(1 - result->summary.cloth_coverage, 1e-12);
    check_below(fabs(result->summary.cloth_area / result->summary.part_area - 1), 1e-4);
    check_below(fabs(result->cuts.tip_angle_deg[0] - tip_deg), bounds->tip_deg);
    for (size_t k = 0; k < result->nodes.count; k++)
        check_below(fabs(result->nodes.shear_deg[k]), bounds->shear_deg);
    for (size_t k = 0; k < result->cells.count; k++)
        check_below(fabs(result->cells.shear_deg[k]), bounds->shear_deg);
}

/* A whole cone about the z axis, a start on it, and two directions there. */
struct cone {
    struct shape shape;
    double base, height, slant;
    double longitude, far; /* of the start: far is its share of the slant from the apex */
    struct vec3 start, down, side;
};

static void make_cone(struct cone *cone, double base, double height, double longitude, double far) {
    const double turn[2] = {0, 2 * M_PI}, apex[2] = {0, height}, rim[2] = {base, 0};
    double x = cos(longitude), y = sin(longitude), slant = hypot(base, height);
    *cone = (struct cone){.base = base,
                          .height = height,
                          .slant = slant,
                          .longitude = longitude,
                          .far = far,
                          .start = {far * base * x, far * base * y, (1 - far) * height},
                          .down = {base * x / slant, base * y / slant, -height / slant},
                          .side = {-y, x, 0}};
    shape_frustum(&cone->shape, turn, apex, rim, M_PI / 2);
}

/* A net at `angle` degrees to the side. */
static struct drape_settings settings_on(const struct cone *cone, enum drape_method method,
                                         double d, double angle) {
    double turn = angle * M_PI / 180;
    return (struct drape_settings){
        .method = method,
        .spacing = {d, d},
        .start_kind = DRAPE_START_POINT,
        .start_point = cone->start,
        .direction_kind = DRAPE_DIRECTION_VECTOR,
        .direction_vector = vec3_axpy(sin(turn), cone->down, vec3_scale(cos(turn), cone->side)),
        .max_nodes = 100000};
}

/* How far nodes are from where they are on the cone unrolled about its apex, cut along the
 * generator at the longitude `cut`: (i, j) is at i e + j f, with e and f the directions of the
 * yarns at the start. In spacings; of nodes on the cut the nearer of two places. */
static double off_unrolled(const struct cone *cone, const struct drape_result *result, double cut,
                           double d) {
    static const double on_cut = 1e-3;
    double worst = 0, share = cone->base / cone->slant, round = 2 * M_PI;
    for (size_t k = 0; k < result->nodes.count; k++) {
        double x = result->nodes.x[k], y = result->nodes.y[k], z = result->nodes.z[k], off[2];
        double s = sqrt(x * x + y * y + (cone->height - z) * (cone->height - z));
        double behind = atan2(y, x) - cut;
        behind -= round * floor(behind / round);
        bool near = fmin(behind, round - behind) * share * s < on_cut * d;
        for (int way = 0; way < 2; way++) {
            double round_it = behind + (way ? behind < M_PI ? round : -round : 0);
            double start = cone->longitude - cut;
            start -= round * floor(start / round);
            double flat = (round_it - start) * share;
            struct vec3 to = vec3_axpy(s * cos(flat) - cone->far * cone->slant, cone->down,
                                       vec3_scale(s * sin(flat), cone->side));
            off[way] = hypot(vec3_dot(to, result->start_warp) / d - result->nodes.i[k],
                             vec3_dot(to, result->start_weft) / d - result->nodes.j[k]);
        }
        worst = fmax(worst, near ? fmin(off[0], off[1]) : off[0]);
    }
    return worst;
}

/* Cut along a generator to the apex. */
static void check_cone(double base, double height, const struct bounds *bounds, uint64_t *seed) {
    static struct cone cone;
    struct arena *arena = arena_new((size_t)1 << 30);
    struct drape_result result = {0};
    double cut = random_between(seed, 0, 2 * M_PI), start = cut + random_between(seed, 1.5, 4.5);
    make_cone(&cone, base, height, start, random_between(seed, 0.5, 0.7));
    double d = cone.slant / 30;
    const struct vec3 path[2] = {{base * cos(cut), base * sin(cut), 0}, {0, 0, height}};
    const struct drape_cut_line line = {path, 2};
    struct drape_settings settings =
        settings_on(&cone, bounds->method, d, random_between(seed, 0, 90));
    settings.cuts = &line;
    settings.cut_count = 1;
    assert_int_equal(drape_solve(&(struct drape_part){.surface = surface_of(&cone.shape, arena)},
                                 &settings, NULL, arena, &result),
                     STATUS_OK);
    check_cloth(&result, 360 * (1 - base / cone.slant), bounds);
    double worst = off_unrolled(&cone, &result, cut, d);
    printf("             nodes within %.1e spacings\n", worst);
    check_below(worst, bounds->node);
    arena_free(arena);
}

static void test_cone_cut_to_its_apex_is_flat(void **state) {
    static const struct bounds all[] = {{DRAPE_GIB, 5e-4, 0.05, 0.01},
                                        {DRAPE_GEODESIC, 1e-8, 5e-6, 0.01}};
    uint64_t seed = SEED;
    (void)state;
    for (size_t m = 0; m < sizeof all / sizeof *all; m++)
        for (int k = 0; k < 6; k++)
            check_cone(100, random_between(&seed, 40, 200), &all[m], &seed);
}

/* A cone that nobody cuts: cloth that passes its apex on both sides meets on the generator opposite
 * the start, up to which all of it is the square grid, however the cone is cut into faces. Nodes
 * are those of the whole: what the generators fix to 1e-6 spacings, and to 1e-5 where these begin
 * within a spacing of the apex, grown ones to 1e-4. */
static void check_uncut_cone(uint64_t *seed, const struct bounds *bounds) {
    static struct cone cone;
    static struct pieces pieces;
    double height = random_between(seed, 55, 200), longitude = random_between(seed, 0, 2 * M_PI);
    double far = random_unit(seed) < 0.5 ? random_between(seed, 0.05, 0.95)
                                         : pow(10, random_between(seed, -3, -0.7));
    int faces = 1 + (int)(random_unit(seed) * 7);
    make_cone(&cone, 100, height, longitude, far);
    double d = 8, opposite = longitude + M_PI;
    struct drape_settings settings =
        settings_on(&cone, bounds->method, d, random_between(seed, 0, 90));
    struct drape_run whole, cut = {.arena = arena_new((size_t)1 << 30)};
    assert_int_equal(drape_try(&whole, &cone.shape, &settings), STATUS_OK);
    pieces_cut_grid(&pieces, &cone.shape, faces, 1, seed);
    const struct drape_part part = {.shell = pieces_shell(&pieces, cut.arena)};
    assert_int_equal(drape_solve(&part, &settings, NULL, cut.arena, &cut.result), STATUS_OK);
    grid_make(&cut.grid, &cut.result.nodes);
    double worst[2] = {off_unrolled(&cone, &whole.result, opposite, d),
                       off_unrolled(&cone, &cut.result, opposite, d)};
    printf("    %-8s height %3.0f, start at %6.2f spacings, %d faces: covers %.6f and %.6f, nodes "
           "within %.1e and %.1e\n",
           drape_method_names[bounds->method], height, far * cone.slant / d, faces,
           whole.result.summary.cloth_coverage, cut.result.summary.cloth_coverage, worst[0],
           worst[1]);
    check_below(fmax(worst[0], worst[1]), bounds->node);
    check_above(whole.result.summary.cloth_coverage, 0.999);
    check_above(cut.result.summary.cloth_coverage, 0.999);
    const struct drape_nodes *nodes = &whole.result.nodes;
    int turn = whole_is_turned(&whole, &cut.result) ? -1 : 1;
    double fixed = far * cone.slant > d ? 1e-6 : 1e-5;
    assert_int_equal(nodes->count, cut.result.nodes.count);
    assert_int_equal(whole.result.cuts.count, 0);
    assert_null(whole.result.rim.cut);
    for (size_t k = 0; k < nodes->count; k++) {
        check_below(fabs(nodes->shear_deg[k]), bounds->shear_deg);
        int at = grid_find(&cut.grid, nodes->i[k], turn * nodes->j[k]);
        assert_true(at >= 0);
        check_below(vec3_distance(node_point(nodes, (int)k), node_point(&cut.result.nodes, at)),
                    (nodes->grown && nodes->grown[k] ? 1e-4 : fixed) * d);
    }
    drape_end(&whole);
    grid_free(&cut.grid);
    arena_free(cut.arena);
}

static void test_cone_is_cut_to_its_apex_opposite_the_start(void **state) {
    static const struct bounds all[] = {
        {DRAPE_GIB, 1e-3, 0, 0.05}, {DRAPE_GIB4, 1e-3, 0, 0.05}, {DRAPE_GEODESIC, 1e-8, 0, 0.05}};
    uint64_t seed = SEED;
    (void)state;
    for (int round = 0; round < 8; round++)
        for (size_t m = 0; m < sizeof all / sizeof *all; m++)
            check_uncut_cone(&seed, &all[m]);
}

/* Cloth passes what is pointed by little, as cones 5.7 and 24 degrees from flat, the latter of
 * which lacks 31, and what has a brim that gives back what is missing: a hat of 30 degrees. Nothing
 * is cut: all of the rim is the part's. */
static void test_blunt_cone_and_hat_are_not_cut(void **state) {
    static struct cone cone;
    static struct pieces hat;
    (void)state;
    for (int k = 0; k < 3; k++) {
        static const double height[] = {10, 45, 57.7};
        struct arena *arena = arena_new((size_t)1 << 30);
        struct drape_result result = {0};
        bool brim = k == 2;
        double edge = brim ? 200 : 100;
        make_cone(&cone, 100, height[k], 1, 0.4);
        struct drape_settings settings = settings_on(&cone, DRAPE_GIB, 8, 20);
        memset(&hat, 0, sizeof hat);
        hat.count = 1 + brim;
        hat.shape[0] = cone.shape;
        shape_frustum(&hat.shape[1], (double[2]){0, 2 * M_PI}, (double[2]){100, 0},
                      (double[2]){edge, 0}, M_PI / 2);
        const struct drape_part part = {.shell = pieces_shell(&hat, arena)};
        assert_int_equal(drape_solve(&part, &settings, NULL, arena, &result), STATUS_OK);
        printf("    %s covers %.6f, shear %.2f deg\n", brim ? "hat" : "blunt cone",
               result.summary.cloth_coverage, result.summary.max_shear_deg);
        assert_true(result.rim.count > 0);
        for (size_t n = 0; n < result.rim.count; n++)
            check_below(fabs(hypot(result.rim.x[n], result.rim.y[n]) - edge), 0.1);
        if (!brim)
            check_above(result.summary.cloth_coverage, 0.999);
        arena_free(arena);
    }
}

/* Three planes that meet in a corner, cut along one of their edges. */
static void test_box_corner_is_flat(void **state) {
    static const struct bounds all[] = {{DRAPE_GIB, 1e-8, 1e-6, 1e-4},
                                        {DRAPE_GIB4, 1e-8, 1e-6, 1e-4},
                                        {DRAPE_GEODESIC, 1e-8, 1e-6, 1e-4}};
    uint64_t seed = SEED;
    (void)state;
    for (int k = 0; k < 12; k++) {
        static struct shape shape[3];
        const struct bounds *bounds = &all[k % 3];
        struct arena *arena = arena_new((size_t)1 << 30);
        struct drape_result result = {0};
        struct shell_patch patches[3] = {{0}};
        struct shell_fault fault;
        struct shell *shell;
        double a = random_between(&seed, 60, 100), b = random_between(&seed, 60, 100);
        double c = random_between(&seed, 40, 80), d = 4;
        const double size[3][2] = {{a, b}, {b, c}, {c, a}};
        /* the planes z = 0, x = 0, y = 0, by cyclic changes of axes */
        for (int n = 0; n < 3; n++) {
            const double x[2] = {n == 2 ? -size[n][0] : 0, n == 2 ? 0 : size[n][0]};
            const double y[2] = {n == 1 ? -size[n][1] : 0, n == 1 ? 0 : size[n][1]};
            struct motion motion = {.m = {{0}}};
            shape_plane(&shape[n], x, y);
            for (int row = 0; row < 3; row++)
                motion.m[(row + n) % 3][row] = 1;
            shape_move(&shape[n], &motion);
            patches[n].surface = surface_of(&shape[n], arena);
        }
        assert_int_equal(shell_make(patches, 3, 0, arena, &shell, &fault), STATUS_OK);
        double angle = random_between(&seed, 0, M_PI / 2);
        const struct vec3 path[2] = {{0, 0, -c}, {0, 0, 0}};
        const struct drape_cut_line line = {path, 2};
        struct drape_settings settings = {
            .method = bounds->method,
            .spacing = {d, d},
            .start_kind = DRAPE_START_POINT,
            .start_point = {random_between(&seed, 20, 50), random_between(&seed, 20, 50), 0},
            .direction_kind = DRAPE_DIRECTION_VECTOR,
            .direction_vector = {cos(angle), sin(angle), 0},
            .cuts = &line,
            .cut_count = 1,
            .max_nodes = 100000};
        assert_int_equal(
            drape_solve(&(struct drape_part){.shell = shell}, &settings, NULL, arena, &result),
            STATUS_OK);
        check_cloth(&result, 90, bounds);
        check_below(fabs(result.cuts.area[0] - c * c / 2), 1e-3 * c * c);
        check_below(fabs(result.cuts.mouth_width[0] - c * sqrt(2)), 1e-3 * c);
        double worst = 0; /* of nodes: the planes unfolded into z = 0 about x = 0 and y = 0 */
        for (size_t n = 0; n < result.nodes.count; n++) {
            struct vec3 flat = {result.nodes.x[n], result.nodes.y[n], 0};
            bool on_x = fabs(result.nodes.x[n]) < 1e-9 && result.nodes.z[n] < 0;
            flat.x += on_x ? result.nodes.z[n] : 0;
            flat.y += !on_x && result.nodes.z[n] < 0 ? result.nodes.z[n] : 0;
            struct vec3 to = vec3_sub(flat, settings.start_point);
            double i = vec3_dot(to, result.start_warp) / d, j = vec3_dot(to, result.start_weft) / d;
            worst = fmax(worst, hypot(i - result.nodes.i[n], j - result.nodes.j[n]));
        }
        printf("             nodes within %.1e spacings\n", worst);
        check_below(worst, bounds->node);
        arena_free(arena);
    }
}

/* A slit opens nothing: all nodes are those of the sheet without it, but for a few that the cut
 * leaves without a yarn between it and an edge, and its lips lie on each other. Every third has
 * another that begins on it, on the left or on the right. */
static void test_slit_in_a_plane_changes_nothing(void **state) {
    uint64_t seed = SEED;
    (void)state;
    for (int k = 0; k < 24; k++) {
        static struct shape shape;
        struct arena *arena = arena_new((size_t)1 << 30);
        struct drape_result whole = {0}, slit = {0};
        const double x[2] = {0, 100}, y[2] = {0, 80};
        double angle = random_between(&seed, 0, M_PI);
        shape_plane(&shape, x, y);
        struct vec3 path[3] = {{random_between(&seed, 20, 80), 80, 0},
                               {random_between(&seed, 20, 80), 60, 0},
                               {random_between(&seed, 20, 80), random_between(&seed, 40, 50), 0}};
        struct vec3 along = vec3_unit(vec3_sub(path[2], path[1]));
        double turn = vec3_cross(along, vec3_sub(path[0], path[1])).z;
        double side = turn > 0 ? -8 : 8; /* away from where the cut comes from */
        const struct vec3 middle = vec3_scale(0.5, vec3_add(path[1], path[2]));
        const struct vec3 branch[2] = {middle,
                                       vec3_axpy(side, vec3_make(-along.y, along.x, 0), middle)};
        const struct drape_cut_line lines[2] = {{path, 3}, {branch, 2}};
        size_t count = k % 3 ? 1 : 2;
        struct drape_settings settings = {
            .method = k % 2 ? DRAPE_GEODESIC : DRAPE_GIB,
            .spacing = {4, 4},
            .start_kind = DRAPE_START_POINT,
            .start_point = {random_between(&seed, 10, 90), random_between(&seed, 5, 30), 0},
            .direction_kind = DRAPE_DIRECTION_VECTOR,
            .direction_vector = {cos(angle), sin(angle), 0},
            .max_nodes = 100000};
        const struct drape_part part = {.surface = surface_of(&shape, arena)};
        assert_int_equal(drape_solve(&part, &settings, NULL, arena, &whole), STATUS_OK);
        settings.cuts = lines;
        settings.cut_count = count;
        assert_int_equal(drape_solve(&part, &settings, NULL, arena, &slit), STATUS_OK);
        size_t at = 0;
        for (size_t n = 0; n < slit.nodes.count; n++, at++) {
            while (at < whole.nodes.count &&
                   (whole.nodes.i[at] != slit.nodes.i[n] || whole.nodes.j[at] != slit.nodes.j[n]))
                at++;
            assert_true(at < whole.nodes.count);
            check_below(
                hypot(slit.nodes.x[n] - whole.nodes.x[at], slit.nodes.y[n] - whole.nodes.y[at]),
                4e-9);
        }
        assert_true(slit.nodes.count + 3 * count >= whole.nodes.count);
        check_below(1 - slit.summary.cloth_coverage, 1e-12);
        check_below(fabs(slit.summary.cloth_area - 8000), 0.02);
        for (size_t n = 0; n < count; n++) {
            assert_true(slit.cuts.covered[n]);
            check_below(fabs(slit.cuts.tip_angle_deg[n]), n ? 1e-3 : 1e-4);
            check_below(fabs(slit.cuts.area[n]), 0.02);
        }
        check_below(fabs(slit.cuts.length[0] - vec3_distance(path[0], path[1]) -
                         vec3_distance(path[1], path[2])),
                    0.01);
        assert_true(slit.cells.count < whole.cells.count);
        arena_free(arena);
    }
}

/* A frustum that closes is cut open opposite the start; a cut on either side of that, from below or
 * from above, changes nothing. By all methods. */
static void test_slit_in_a_frustum_changes_nothing(void **state) {
    const double round = 2 * M_PI, turn[2] = {0, round}, low[2] = {100, 0}, high[2] = {50, 80};
    uint64_t seed = SEED;
    (void)state;
    for (int k = 0; k < 20; k++) {
        static struct shape shape;
        struct arena *arena = arena_new((size_t)1 << 30);
        struct drape_result whole = {0}, slit = {0};
        double start = random_between(&seed, 0, round), cut = start + random_between(&seed, 0.3, 6);
        double tip = random_between(&seed, 0.3, 0.7), from = k % 2 ? 1 : 0;
        double angle = random_between(&seed, 0, M_PI);
        bool opposite = fabs(cut - start - M_PI) < 0.2;
        if (opposite)
            cut += 0.5;
        shape_frustum(&shape, turn, low, high, M_PI / 2);
        const struct vec3 path[2] = {
            {(100 - 50 * from) * cos(cut), (100 - 50 * from) * sin(cut), 80 * from},
            {(100 - 50 * tip) * cos(cut), (100 - 50 * tip) * sin(cut), 80 * tip}};
        const struct drape_cut_line line = {path, 2};
        struct drape_settings settings = {
            .method = (enum drape_method)(k % DRAPE_METHOD_COUNT),
            .spacing = {4, 4},
            .start_kind = DRAPE_START_POINT,
            .start_point = {75 * cos(start), 75 * sin(start), 40},
            .direction_kind = DRAPE_DIRECTION_VECTOR,
            .direction_vector = {-sin(start) * cos(angle), cos(start) * cos(angle), sin(angle)},
            .max_nodes = 100000};
        const struct drape_part part = {.surface = surface_of(&shape, arena)};
        assert_int_equal(drape_solve(&part, &settings, NULL, arena, &whole), STATUS_OK);
        settings.cuts = &line;
        settings.cut_count = 1;
        assert_int_equal(drape_solve(&part, &settings, NULL, arena, &slit), STATUS_OK);
        printf("    %-8s covers %.6f, whole %.6f; tip %.4f deg, shear %.4f, whole %.4f deg\n",
               drape_method_names[settings.method], slit.summary.cloth_coverage,
               whole.summary.cloth_coverage, slit.cuts.tip_angle_deg[0], slit.summary.max_shear_deg,
               whole.summary.max_shear_deg);
        bool flat = settings.method == DRAPE_MOSAIC;
        assert_true(flat || slit.cuts.covered[0]);
        check_below(whole.summary.cloth_coverage - slit.summary.cloth_coverage, 1e-3);
        check_below(slit.summary.mean_shear_deg - whole.summary.mean_shear_deg, 0.1);
        check_below(flat ? 0 : slit.summary.max_shear_deg - whole.summary.max_shear_deg, 0.1);
        check_below(fabs(slit.cuts.length[0] - fabs(tip - from) * hypot(50, 80)), 0.01);
        check_below(flat ? 0 : fabs(slit.cuts.tip_angle_deg[0]), 0.05);
        arena_free(arena);
    }
}

/* A dome with a dart, by method, moved by shares of its spacing. */
static void drape_dome(enum drape_method method, double scale, double mirror, double aside,
                       struct arena *arena, struct drape_result *result) {
    enum { POINTS = 13 };
    static struct shape shape;
    const double side[2] = {-100, 100}, d = 5 * scale;
    struct vec3 path[POINTS];
    shape_quadric(&shape, -1.0 / 120, -1.0 / 120, side, side);
    struct motion motion = motion_stretch(scale, scale, scale);
    shape_move(&shape, &motion);
    for (int k = 0; k < POINTS; k++) {
        double share = k / (POINTS - 1.0);
        double x = mirror * (70 + 5 * aside - 25 * share), y = 100 - 60 * share;
        path[k] = vec3_scale(scale, vec3_make(x, y, -(x * x + y * y) / 240));
    }
    const struct drape_cut_line line = {path, POINTS};
    struct drape_settings settings = {
        .method = method,
        .spacing = {d, d},
        .start_kind = DRAPE_START_POINT,
        .start_point = {mirror * 3 * scale, 4 * scale, -25 * scale / 240},
        .direction_kind = DRAPE_DIRECTION_VECTOR,
        .direction_vector = {mirror, 0.3, 0},
        .cuts = &line,
        .cut_count = 1,
        .max_nodes = 100000};
    assert_int_equal(drape_solve(&(struct drape_part){.surface = surface_of(&shape, arena)},
                                 &settings, NULL, arena, result),
                     STATUS_OK);
    check_above(result->summary.cloth_coverage, method == DRAPE_MOSAIC ? 0.999 : 1 - 1e-6);
    assert_true(result->cuts.covered[0]);
}

/* Where nodes differ, in spacings; those of a mirrored net are looked for as (i, -j). */
static double dome_gap(const struct drape_result *a, const struct drape_result *b, double scale,
                       double mirror) {
    double worst = 0;
    assert_int_equal(a->nodes.count, b->nodes.count);
    for (size_t k = 0; k < a->nodes.count; k++) {
        size_t n = 0;
        while (n < b->nodes.count &&
               (b->nodes.i[n] != a->nodes.i[k] || mirror * b->nodes.j[n] != a->nodes.j[k]))
            n++;
        assert_true(n < b->nodes.count);
        struct vec3 other = {mirror * b->nodes.x[n], b->nodes.y[n], b->nodes.z[n]};
        struct vec3 own = {a->nodes.x[k], a->nodes.y[k], a->nodes.z[k]};
        worst = fmax(worst, vec3_distance(own, vec3_scale(1 / scale, other)) / 5);
    }
    return worst;
}

static void test_dart_in_a_dome_moves_as_its_part_does(void **state) {
    (void)state;
    for (int m = 0; m < DRAPE_METHOD_COUNT; m++) {
        struct arena *arena = arena_new((size_t)1 << 30);
        struct drape_result own = {0}, moved = {0}, large = {0}, mirrored = {0};
        bool flat = m == DRAPE_MOSAIC; /* its triangles are not those of the mirrored part */
        drape_dome((enum drape_method)m, 1, 1, 0, arena, &own);
        drape_dome((enum drape_method)m, 1, 1, 1e-6, arena, &moved);
        drape_dome((enum drape_method)m, 1024, 1, 0, arena, &large);
        drape_dome((enum drape_method)m, 1, -1, 0, arena, &mirrored);
        check_below(dome_gap(&own, &moved, 1, 1), 1e-5);
        check_below(dome_gap(&own, &large, 1024, 1), 1e-9);
        check_below(flat ? 0 : dome_gap(&own, &mirrored, 1, -1), 1e-9);
        check_below(fabs(moved.cuts.tip_angle_deg[0] - own.cuts.tip_angle_deg[0]), 1e-3);
        check_below(fabs(large.cuts.tip_angle_deg[0] - own.cuts.tip_angle_deg[0]), 1e-6);
        check_below(flat ? 0 : fabs(mirrored.cuts.tip_angle_deg[0] - own.cuts.tip_angle_deg[0]),
                    1e-6);
        arena_free(arena);
    }
}

/* What cannot be a cut is told with its number. */
static void test_what_is_no_cut_is_told(void **state) {
    static struct shape shape;
    const double x[2] = {0, 100}, y[2] = {0, 80};
    static const struct {
        struct vec3 path[2];
        enum cut_fault_kind kind;
    } cases[] = {{{{50, 60, 0}, {50, 30, 0}}, CUT_BEGINS_INSIDE},
                 {{{50, 80, 0}, {50, 0, 0}}, CUT_SPLITS},
                 {{{50, 80, 0}, {50, 78, 0}}, CUT_SHORT},
                 {{{20, 80, 0}, {20, 10, 0}}, CUT_AT_START},
                 {{{50, 80, 9}, {50, 30, 9}}, CUT_OFF_PART},
                 {{{100, 60, 0}, {60, 60, 0}}, CUT_CROSSES}};
    (void)state;
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        struct arena *arena = arena_new((size_t)1 << 30);
        struct drape_result result = {0};
        const struct vec3 first[2] = {{70, 80, 0}, {70, 30, 0}};
        const struct drape_cut_line lines[2] = {{first, 2}, {cases[k].path, 2}};
        shape_plane(&shape, x, y);
        struct drape_settings settings = {.spacing = {4, 4},
                                          .start_kind = DRAPE_START_POINT,
                                          .start_point = {20, 20, 0},
                                          .cuts = lines,
                                          .cut_count = 2,
                                          .max_nodes = 100000};
        assert_int_equal(drape_solve(&(struct drape_part){.surface = surface_of(&shape, arena)},
                                     &settings, NULL, arena, &result),
                         STATUS_CUT);
        assert_int_equal(result.faulty_cut.kind, cases[k].kind);
        assert_int_equal(result.faulty_cut.cut, 1);
        arena_free(arena);
    }
}

/* A cut that crosses itself, turns back on itself or ends beside itself is told; one that winds, or
 * has a corner of 10 degrees, is none of them. */
static void test_a_cut_that_crosses_itself_is_told(void **state) {
    static struct shape shape;
    const double x[2] = {0, 100}, y[2] = {0, 80};
    static const struct {
        struct vec3 path[6];
        size_t count;
        enum status status;
        struct vec3 at; /* within half a spacing */
    } cases[] = {{{{50, 80, 0}, {50, 40, 0}, {70, 40, 0}, {70, 60, 0}, {40, 60, 0}},
                  5,
                  STATUS_CUT,
                  {50, 60, 0}},
                 {{{50, 80, 0}, {50, 40, 0}, {50, 60, 0}}, 3, STATUS_CUT, {50, 60, 0}},
                 {{{50, 80, 0}, {50, 40, 0}, {70, 40, 0}, {70, 60, 0}, {50.01, 60, 0}},
                  5,
                  STATUS_CUT,
                  {50, 60, 0}},
                 {{{50, 80, 0}, {50, 40, 0}, {70, 40, 0}, {70, 60, 0}, {60, 60, 0}, {60, 50, 0}},
                  6,
                  STATUS_OK,
                  {0, 0, 0}},
                 {{{50, 80, 0}, {50, 40, 0}, {53, 57, 0}}, 3, STATUS_OK, {0, 0, 0}}};
    (void)state;
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        struct arena *arena = arena_new((size_t)1 << 30);
        struct drape_result result = {0};
        const struct drape_cut_line line = {cases[k].path, cases[k].count};
        shape_plane(&shape, x, y);
        struct drape_settings settings = {.spacing = {4, 4},
                                          .start_kind = DRAPE_START_POINT,
                                          .start_point = {20, 20, 0},
                                          .cuts = &line,
                                          .cut_count = 1,
                                          .max_nodes = 100000};
        const struct drape_part part = {.surface = surface_of(&shape, arena)};
        assert_int_equal(drape_check_cuts(&part, &settings, arena, &result), cases[k].status);
        assert_int_equal(drape_solve(&part, &settings, NULL, arena, &result), cases[k].status);
        if (cases[k].status == STATUS_CUT) {
            assert_int_equal(result.faulty_cut.kind, CUT_CROSSES_SELF);
            check_below(vec3_distance(result.faulty_cut.at, cases[k].at), 2);
        }
        arena_free(arena);
    }
}

/* The left lip of a cut that is given by its two ends, far from each other, as a line in space. */
static size_t lay_far_cut(double spacing, struct arena *arena, struct vec3 **lip) {
    static struct shape shape;
    const double side[2] = {-100, 100}, a = -1.0 / 60, b = -1.0 / 300;
    const struct vec3 path[2] = {{20, 100, (400 * a + 10000 * b) / 2}, {-60, 0, 1800 * a}};
    const struct drape_cut_line line = {path, 2};
    struct drape_result result = {0};
    shape_quadric(&shape, a, b, side, side);
    struct drape_settings settings = {.method = DRAPE_GIB,
                                      .spacing = {spacing, spacing},
                                      .start_kind = DRAPE_START_POINT,
                                      .start_point = {40, -40, 800 * (a + b)},
                                      .cuts = &line,
                                      .cut_count = 1,
                                      .max_nodes = 100000};
    assert_int_equal(drape_solve(&(struct drape_part){.surface = surface_of(&shape, arena)},
                                 &settings, NULL, arena, &result),
                     STATUS_OK);
    *lip = arena_alloc(arena, result.rim.count, sizeof **lip);
    size_t count = 0;
    for (size_t k = 0; k < result.rim.count; k++)
        if (result.rim.cut[k] == 1)
            (*lip)[count++] = vec3_make(result.rim.x[k], result.rim.y[k], result.rim.z[k]);
    return count;
}

/* Its points between the ends are moved to the part along its normals where it rises from the line
 * by a share of that, whatever the spacing: lips differ by the steps in which they are followed. */
static void test_cut_between_far_points_hardly_moves_with_the_spacing(void **state) {
    (void)state;
    struct arena *arena = arena_new((size_t)1 << 30);
    struct vec3 *fine, *lip;
    size_t fine_count = lay_far_cut(1, arena, &fine);
    for (double d = 2; d <= 8; d *= 2) {
        size_t count = lay_far_cut(d, arena, &lip);
        double worst = 0;
        for (size_t k = 0; k < count; k++) {
            double least = HUGE_VAL;
            for (size_t n = 0; n + 1 < fine_count; n++) {
                struct vec3 way = vec3_sub(fine[n + 1], fine[n]), to = vec3_sub(lip[k], fine[n]);
                double length2 = fmax(vec3_norm2(way), 1e-30);
                double share = fmin(fmax(vec3_dot(to, way) / length2, 0), 1);
                least = fmin(least, vec3_norm(vec3_axpy(-share, way, to)));
            }
            worst = fmax(worst, least);
        }
        printf("    spacing %g: %zu points, within %.1e spacings of those by 1\n", d, count,
               worst / d);
        check_above((double)count, 10);
        check_below(worst, 1e-3 * d);
    }
    arena_free(arena);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_cone_cut_to_its_apex_is_flat),
        cmocka_unit_test(test_cone_is_cut_to_its_apex_opposite_the_start),
        cmocka_unit_test(test_blunt_cone_and_hat_are_not_cut),
        cmocka_unit_test(test_box_corner_is_flat),
        cmocka_unit_test(test_slit_in_a_plane_changes_nothing),
        cmocka_unit_test(test_slit_in_a_frustum_changes_nothing),
        cmocka_unit_test(test_dart_in_a_dome_moves_as_its_part_does),
        cmocka_unit_test(test_what_is_no_cut_is_told),
        cmocka_unit_test(test_a_cut_that_crosses_itself_is_told),
        cmocka_unit_test(test_cut_between_far_points_hardly_moves_with_the_spacing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
