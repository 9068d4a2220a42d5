/* SPDX-License-Identifier: MIT */
#include "whole.h"

#include "tests/check.h"
#include <stdio.h>
#include <stdlib.h>

enum { CELLS = 16, CELLS_OF_MOSAIC = 8 };
static const double SAME_SHEAR_DEG = 1e-6;

/* Twice the gap, and as much again for what a yarn adds up that crosses several: each takes what a
 * sliver is wide that is left out there. */
static const double GAPS = 4;

/* A node on the border may be beyond it by a gap: of the domain. */
static const double ON_BORDER = 1e-5;

/* By which the mosaic of a shell is off the whole's net of chords: of a spacing, and degrees. */
static const double SAME_MOSAIC = 0.02, SAME_MOSAIC_SHEAR_DEG = 3;

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

bool whole_is_turned(const struct drape_run *whole, const struct drape_result *other) {
    struct vec3 normal = vec3_cross(whole->result.start_warp, whole->result.start_weft);
    return vec3_dot(normal, vec3_cross(other->start_warp, other->start_weft)) < 0;
}

static bool is_on_border(const struct shape *shape, const double at[2]) {
    double lower[2], upper[2];
    shape_domain(shape, lower, upper);
    for (int a = 0; a < 2; a++) {
        double width = upper[a] - lower[a];
        if (fmin(at[a] - lower[a], upper[a] - at[a]) < ON_BORDER * width)
            return true;
    }
    return false;
}

/* Node for node; (i, j) is (i, -j) where the start's face is turned round. */
static struct difference compare(const struct shape *shape, const struct drape_run *whole,
                                 const struct drape_result *other, double off, bool gaps) {
    struct grid grid;
    struct difference most = {.bad = {1000, 1000}};
    const struct drape_nodes *nodes = &whole->result.nodes, *its = &other->nodes;
    bool turned = whole_is_turned(whole, other);
    int both = 0;
    grid_make(&grid, its);
    for (size_t k = 0; k < nodes->count; k++) {
        int at = grid_find(&grid, nodes->i[k], turned ? -nodes->j[k] : nodes->j[k]);
        const double uv[2] = {nodes->u[k], nodes->v[k]};
        if (at < 0 && gaps && is_on_border(shape, uv))
            continue;
        if (at < 0) {
            most.missing++;
            note(&most, nodes->i[k], nodes->j[k]);
            continue;
        }
        both++;
        double shear = turned ? -its->shear_deg[at] : its->shear_deg[at];
        double away = vec3_distance(node_point(nodes, (int)k), node_point(its, at));
        if (away > off)
            note(&most, nodes->i[k], nodes->j[k]);
        most.position = fmax(most.position, away);
        most.shear_deg = fmax(most.shear_deg, fabs(shear - nodes->shear_deg[k]));
    }
    most.extra = (int)its->count - both;
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

bool whole_is_same(struct scene *scene, const struct whole_case *c) {
    static struct pieces pieces;
    enum drape_method method = c->method;
    bool mosaic = method == DRAPE_MOSAIC;
    struct drape_settings settings =
        scene_settings(scene, method, mosaic ? CELLS_OF_MOSAIC : CELLS);
    struct drape_run whole;
    struct drape_result result = {0};
    struct vec3 low, high;
    struct surface_jet jet;
    uint64_t random = c->seed;
    shape_evaluate(&scene->shape, scene->start_uv[0], scene->start_uv[1], &jet);
    settings.start_kind = DRAPE_START_POINT;
    settings.start_point = jet.r;
    settings.slide = c->slide;
    settings.method = mosaic ? DRAPE_BASIC : method; /* what it tends to */
    drape_begin(&whole, &scene->shape, &settings);
    settings.method = method;
    settings.direction_kind = DRAPE_DIRECTION_VECTOR;
    settings.direction_vector = whole.result.start_warp;
    pieces_cut(&pieces, c->cutting, &scene->shape, &random);
    surface_bounds(whole.surface, &low, &high);
    double size = vec3_distance(low, high);
    if (c->gap > 0)
        pieces_disturb(&pieces, c->gap * size, &random);
    struct arena *arena = arena_new((size_t)1 << 30);
    struct shell *shell = pieces_shell(&pieces, arena);
    enum status status =
        drape_solve(&(struct drape_part){.shell = shell}, &settings, NULL, arena, &result);
    if (status == STATUS_OK && whole_is_turned(&whole, &result)) {
        settings.pre_shear_deg = -settings.pre_shear_deg;
        int low_j = settings.extent[1][0];
        settings.extent[1][0] = -settings.extent[1][1];
        settings.extent[1][1] = -low_j;
        status = drape_solve(&(struct drape_part){.shell = shell}, &settings, NULL, arena, &result);
    }
    assert_int_equal(status, STATUS_OK);
    struct shell_edges edges = shell_edges(shell);
    /* Faces moved along their joints are further apart than the gap tells. */
    double gap = fmax(2 * sqrt(3) * c->gap * size, edges.largest_gap);
    double allowed = WHOLE_SAME * size + GAPS * gap, allowed_deg = SAME_SHEAR_DEG;
    if (gap > 0)
        allowed_deg += GAPS * gap / fmin(settings.spacing[0], settings.spacing[1]) * 180 / M_PI;
    if (mosaic) {
        allowed += SAME_MOSAIC * fmin(settings.spacing[0], settings.spacing[1]);
        allowed_deg = SAME_MOSAIC_SHEAR_DEG;
    }
    struct difference most =
        compare(&scene->shape, &whole, &result, allowed, gap > WHOLE_SAME * size);
    bool same = most.missing == 0 && most.extra == 0 && most.position <= allowed &&
                most.shear_deg <= allowed_deg && same_rim(&whole.result, &result);
    if (!same || getenv("DRAPED_VERBOSE"))
        printf("  %s, method %d, %s, %d faces, seed %llu: %zu nodes, %d missing, %d extra, %.1e of "
               "the size, %.1e deg, first (%d, %d); %zu joined, %zu free, gap %.1e\n",
               scene->name, method, cutting_name(c->cutting), pieces.count,
               (unsigned long long)c->seed, whole.result.nodes.count, most.missing, most.extra,
               most.position / size, most.shear_deg, most.bad[0], most.bad[1], edges.joined,
               edges.free, edges.largest_gap);
    arena_free(arena);
    drape_end(&whole);
    return same;
}

bool whole_scene_is_same(enum scene_id id, enum cutting cutting, double gap, uint64_t seed) {
    static const enum drape_method every[] = {DRAPE_GIB, DRAPE_GIB4, DRAPE_BASIC, DRAPE_GEODESIC};
    const struct whole_case c = {cutting, every[seed % 4], gap, seed, 0};
    struct scene scene;
    scene_make(&scene, id);
    bool same = whole_is_same(&scene, &c);
    scene_free(&scene);
    return same;
}
