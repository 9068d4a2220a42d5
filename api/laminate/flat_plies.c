/* SPDX-License-Identifier: MIT */
#include "flat_plies.h"

#include "api/map/net.h"
#include "api/result/flat_pattern.h"
#include "clip.h"
#include "region.h"
#include <math.h>

/* As of the pattern of a drape: what points of the rim are left out for, in spacings. */
static const double tolerance = 5e-4;

struct flattening {
    const struct laminate *laminate;
    struct arena *arena;
    struct flat_plies *shapes;
};

/* The loops of a boundary turned so that they enclose what is on their left, holes the other way
 * round, in (p, q). */
static bool oriented_loops(const struct region *region, struct polygons *loops) {
    for (size_t n = 0; n < region->loop_count; n++) {
        size_t low = region->first[n], count = region->first[n + 1] - low;
        double sum = 0;
        for (size_t k = 0; k < count; k++) {
            const double *a = region->points[low + k], *b = region->points[low + (k + 1) % count];
            sum += a[0] * b[1] - b[0] * a[1];
        }
        int depth = 0; /* of this loop within the others */
        for (size_t m = 0; m < region->loop_count; m++) {
            struct polygons one = {0};
            bool good = true;
            for (size_t k = region->first[m]; good && m != n && k < region->first[m + 1]; k++)
                good = polygons_add(&one, region->points[k][0], region->points[k][1]);
            polygons_close(&one);
            depth += good && m != n &&
                     clip_contains(&one, region->points[low][0], region->points[low][1]);
            polygons_free(&one);
            if (!good)
                return false;
        }
        bool back = (sum > 0) == (depth % 2 == 1);
        for (size_t k = 0; k < count; k++) {
            const double *at = region->points[low + (back ? count - 1 - k : k)];
            if (!polygons_add(loops, at[0], at[1]))
                return false;
        }
        polygons_close(loops);
    }
    return true;
}

/* What of the cut lies within the ply's boundary. */
static enum api_problem_id clip_to_boundary(struct flattening *p, size_t k,
                                            const struct api_reader *reader, struct map_net *cloth,
                                            struct polygons *cut, struct api_problem *problem) {
    static const enum column_id kept[] = {COLUMN_CELLS_warp, COLUMN_CELLS_weft};
    struct polygons loops = {0}, both = {0};
    struct region region;
    map_net_keep(cloth, kept, sizeof kept / sizeof *kept);
    if (map_net_load(reader, NULL, p->arena, cloth, problem) != API_OK ||
        region_make(p->laminate, k, cloth->facets, cloth->columns.grid.spacing, p->arena, &region,
                    problem) != API_OK)
        return problem->id;
    bool good = oriented_loops(&region, &loops) && clip_make(&loops, cut, &both);
    if (good) {
        polygons_free(cut);
        *cut = both;
    } else {
        polygons_free(&both);
        api_problem_no_memory(problem, "the patterns");
    }
    polygons_free(&loops);
    return problem->id;
}

static enum api_problem_id make_flat_ply(struct flattening *p, size_t k,
                                         const struct api_reader *reader,
                                         struct api_problem *problem) {
    struct arena_mark mark = arena_mark(p->arena);
    struct map_net *cloth = arena_alloc(p->arena, 1, sizeof *cloth);
    struct flat_ply *shape = &p->shapes->shapes[p->shapes->count++];
    struct outline outline = {0};
    struct flat_pattern cut = {0};
    *shape = (struct flat_ply){.ply = k};
    if (!cloth)
        return api_problem_no_memory(problem, "the patterns");
    bool good =
        map_net_open(reader, cloth, problem) == API_OK &&
        outline_make(&outline, reader, &cloth->columns, problem) == API_OK &&
        flat_pattern_make(&cut, reader, &cloth->columns, &outline, tolerance, problem) == API_OK;
    if (good && p->laminate->plies[k].boundary.count)
        good = clip_to_boundary(p, k, reader, cloth, &cut.polygons, problem) == API_OK;
    const double *spacing = cloth->columns.grid.spacing;
    for (size_t n = 0; good && n < cut.polygons.count; n++) {
        cut.polygons.points[n].x *= spacing[0];
        cut.polygons.points[n].y *= spacing[1];
    }
    shape->cut = cut.polygons;
    cut.polygons = (struct polygons){0};
    polygons_bounds(&shape->cut, shape->low, shape->high);
    double sum = 0;
    for (size_t n = 0, first = 0; n < shape->cut.count; n++) {
        const struct polygons_point *a = &shape->cut.points[n];
        const struct polygons_point *b = &shape->cut.points[a->last ? first : n + 1];
        sum += (a->x * b->y - b->x * a->y) / 2;
        first = a->last ? n + 1 : first;
    }
    shape->area = fabs(sum);
    flat_pattern_free(&cut);
    outline_free(&outline);
    arena_rewind(p->arena, mark);
    return problem->id;
}

enum api_problem_id flat_plies_make(const struct laminate *laminate,
                                    const struct api_reader *const *nets, int ply,
                                    struct arena *arena, struct flat_plies *shapes,
                                    struct api_problem *problem) {
    struct flattening p = {laminate, arena, shapes};
    *shapes =
        (struct flat_plies){.shapes = arena_alloc(arena, laminate->count, sizeof *shapes->shapes)};
    if (!shapes->shapes)
        return api_problem_no_memory(problem, "the patterns");
    for (size_t k = 0; k < laminate->count; k++) {
        const struct api_reader *net = nets[laminate->plies[k].net];
        if (net && (ply == LAMINATE_ALL || k == (size_t)ply) &&
            make_flat_ply(&p, k, net, problem) != API_OK)
            return problem->id;
    }
    return API_OK;
}

void flat_plies_free(struct flat_plies *shapes) {
    for (size_t k = 0; k < shapes->count; k++)
        polygons_free(&shapes->shapes[k].cut);
    shapes->count = 0;
}
