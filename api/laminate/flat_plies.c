/* SPDX-License-Identifier: MIT */
#include "flat_plies.h"

#include "api/map/net.h"
#include "api/result/flat_pattern.h"
#include "clip.h"
#include "region.h"
#include <math.h>

/* As of the pattern of a drape: what points of the rim are left out for, in spacings. */
static const double tolerance = 5e-4;

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
static enum api_problem_id clip_to_boundary(const struct laminate *laminate, size_t k,
                                            const struct api_reader *reader, struct map_net *cloth,
                                            struct arena *arena, struct polygons *cut,
                                            struct api_problem *problem) {
    static const enum column_id kept[] = {COLUMN_CELLS_warp, COLUMN_CELLS_weft};
    struct polygons loops = {0}, both = {0};
    struct region region;
    map_net_keep(cloth, kept, sizeof kept / sizeof *kept);
    if (map_net_load(reader, NULL, arena, cloth, problem) != API_OK ||
        region_make(laminate, k, cloth->facets, cloth->columns.grid.spacing, arena, &region,
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

enum api_problem_id flat_plies_make(const struct laminate *laminate,
                                    const struct api_reader *const *nets, int ply,
                                    struct arena *arena, struct flat_plies *shapes,
                                    struct api_problem *problem) {
    struct map_net *cloth = arena_alloc(arena, 1, sizeof *cloth);
    *shapes =
        (struct flat_plies){.shapes = arena_alloc(arena, laminate->count, sizeof *shapes->shapes)};
    if (!shapes->shapes || !cloth)
        return api_problem_no_memory(problem, "the patterns");
    for (size_t k = 0; k < laminate->count && problem->id == API_OK; k++) {
        const struct api_reader *reader = nets[laminate->plies[k].net];
        struct arena_mark mark = arena_mark(arena);
        struct outline outline = {0};
        struct flat_pattern flat = {0};
        if (!reader || (ply != LAMINATE_ALL && k != (size_t)ply))
            continue;
        struct flat_ply *shape = &shapes->shapes[shapes->count++];
        bool good = map_net_open(reader, cloth, problem) == API_OK &&
                    outline_make(&outline, reader, &cloth->columns, problem) == API_OK &&
                    flat_pattern_make(&flat, reader, &cloth->columns, &outline, tolerance,
                                      problem) == API_OK;
        *shape = (struct flat_ply){.cut = flat.polygons, .ply = k};
        flat.polygons = (struct polygons){0};
        struct polygons *cut = &shape->cut;
        if (good && laminate->plies[k].boundary.count)
            good = clip_to_boundary(laminate, k, reader, cloth, arena, cut, problem) == API_OK;
        double sum = 0;
        for (size_t n = 0; good && n < cut->count; n++) {
            cut->points[n].x *= cloth->columns.grid.spacing[0];
            cut->points[n].y *= cloth->columns.grid.spacing[1];
        }
        polygons_bounds(cut, shape->low, shape->high);
        for (size_t n = 0, first = 0; n < cut->count; n++) {
            const struct polygons_point *a = &cut->points[n];
            const struct polygons_point *b = &cut->points[a->last ? first : n + 1];
            sum += (a->x * b->y - b->x * a->y) / 2;
            first = a->last ? n + 1 : first;
        }
        shape->area = fabs(sum);
        flat_pattern_free(&flat);
        outline_free(&outline);
        arena_rewind(arena, mark);
    }
    return problem->id;
}

void flat_plies_free(struct flat_plies *shapes) {
    for (size_t k = 0; k < shapes->count; k++)
        polygons_free(&shapes->shapes[k].cut);
    shapes->count = 0;
}
