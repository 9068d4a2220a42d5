/* SPDX-License-Identifier: MIT */
#include "flat_plies.h"

#include "api/map/net.h"
#include "api/result/flat_pattern.h"
#include "clip.h"
#include "region.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

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

/* ---- the cells of a ply with a boundary ---- */

struct cell {
    int32_t i, j;
};

static int compare_ply_cells(const void *a, const void *b) {
    const struct cell *x = a, *y = b;
    return x->j != y->j ? (x->j > y->j) - (x->j < y->j) : (x->i > y->i) - (x->i < y->i);
}

/* The cells that a boundary passes, sorted; it is known by points half a spacing apart. */
static struct cell *cells_passed(const struct region *region, size_t *count, struct arena *arena) {
    *count = region->first[region->loop_count];
    struct cell *cells = arena_alloc(arena, *count, sizeof *cells);
    for (size_t k = 0; cells && k < *count; k++)
        cells[k] = (struct cell){(int32_t)floor(region->points[k][0]),
                                 (int32_t)floor(region->points[k][1])};
    if (cells)
        qsort(cells, *count, sizeof *cells, compare_ply_cells);
    return cells;
}

/* Takes the cells of a table, whole ones or those that the rim cuts, into the ply's numbers: those
 * whose middle lies within the boundary, or that it passes. False when they cannot be read. */
static bool add_cells_inside(const struct api_reader *reader, const struct api_columns *columns,
                             enum api_table table, const struct region *region,
                             const struct cell *passed, size_t passed_count, double locking_deg,
                             struct flat_ply *shape) {
    enum { BLOCK = 512, COLUMNS = 3 };
    static const char *const names[COLUMNS] = {"i", "j", "shear_deg"};
    double block[COLUMNS][BLOCK];
    size_t rows = api_columns_rows(columns, table);
    for (size_t first = 0, held; first < rows; first += held) {
        held = rows - first < BLOCK ? rows - first : BLOCK;
        for (int c = 0; c < COLUMNS; c++) {
            const struct api_column *column = api_columns_find(columns, table, names[c]);
            if (!column || !api_columns_read(reader, column, first, held, block[c]))
                return false;
        }
        for (size_t k = 0; k < held; k++) {
            const double middle[2] = {block[0][k] + 0.5, block[1][k] + 0.5};
            const struct cell key = {(int32_t)block[0][k], (int32_t)block[1][k]};
            double shear_deg = fabs(block[2][k]);
            if (!region_contains(region, middle) &&
                !bsearch(&key, passed, passed_count, sizeof *passed, compare_ply_cells))
                continue;
            shape->max_shear_deg = fmax(shape->max_shear_deg, shear_deg);
            shape->locked_cells +=
                table == API_TABLE_CELLS && locking_deg >= 0 && shear_deg > locking_deg;
        }
    }
    return true;
}

/* What of the cut lies within the ply's boundary, and what the cells there say. */
static enum api_problem_id clip_to_boundary(const struct laminate *laminate,
                                            const struct api_reader *reader, struct map_net *cloth,
                                            struct arena *arena, struct flat_ply *shape,
                                            struct api_problem *problem) {
    static const enum column_id kept[] = {COLUMN_CELLS_warp, COLUMN_CELLS_weft};
    const struct laminate_ply *ply = &laminate->plies[shape->ply];
    const double *d = cloth->columns.grid.spacing;
    struct polygons loops = {0}, both = {0};
    struct region region;
    size_t count;
    map_net_keep(cloth, kept, sizeof kept / sizeof *kept);
    if (map_net_load(reader, NULL, arena, cloth, problem) != API_OK ||
        region_make(laminate, shape->ply, cloth->facets, d, arena, &region, problem) != API_OK)
        return problem->id;
    struct cell *passed = cells_passed(&region, &count, arena);
    bool good = passed && oriented_loops(&region, &loops) && clip_make(&loops, &shape->cut, &both);
    double locking_deg = ply->drape.fabric.locking_angle_deg;
    shape->max_shear_deg = 0;
    shape->locked_cells = locking_deg >= 0 ? 0 : -1;
    if (good) {
        polygons_free(&shape->cut);
        shape->cut = both;
        double whole = polygons_area(&loops), area = polygons_area(&both);
        shape->area = area * d[0] * d[1];
        shape->covered = whole > 0 ? fmin(area / whole, 1) : 0;
    } else {
        polygons_free(&both);
        api_problem_no_memory(problem, "the patterns");
    }
    polygons_free(&loops);
    for (int k = 0; good && k < 2; k++)
        if (!add_cells_inside(reader, &cloth->columns, k ? API_TABLE_CUT : API_TABLE_CELLS, &region,
                              passed, count, locking_deg, shape))
            return map_net_damaged(problem);
    return problem->id;
}

/* The pattern and the numbers of a ply. */
static enum api_problem_id make_flat_ply(const struct laminate *laminate,
                                         const struct api_reader *reader, struct map_net *cloth,
                                         struct arena *arena, struct flat_ply *shape,
                                         struct api_problem *problem) {
    struct flat_pattern flat = {0};
    if (map_net_open(reader, cloth, problem) != API_OK)
        return problem->id;
    const struct api_summary *summary = &cloth->columns.summary;
    const double *d = cloth->columns.grid.spacing;
    (void)!flat_pattern_make(&flat, reader, &cloth->columns, tolerance, problem);
    shape->cut = flat.polygons;
    flat.polygons = (struct polygons){0};
    flat_pattern_free(&flat);
    shape->area = summary->flat_area;
    shape->covered = summary->cloth_coverage;
    shape->max_shear_deg = summary->max_shear_deg;
    shape->locked_cells = summary->locked_cells;
    if (problem->id == API_OK && laminate->plies[shape->ply].boundary.count)
        (void)!clip_to_boundary(laminate, reader, cloth, arena, shape, problem);
    shape->partial = shape->covered < DRAPE_COMPLETE_COVERAGE;
    for (size_t n = 0; problem->id == API_OK && n < shape->cut.count; n++) {
        shape->cut.points[n].x *= d[0];
        shape->cut.points[n].y *= d[1];
    }
    polygons_bounds(&shape->cut, shape->low, shape->high);
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
        if (!reader || (ply != LAMINATE_ALL && k != (size_t)ply))
            continue;
        struct flat_ply *shape = &shapes->shapes[shapes->count++];
        *shape = (struct flat_ply){.ply = k};
        (void)!make_flat_ply(laminate, reader, cloth, arena, shape, problem);
        arena_rewind(arena, mark);
    }
    return problem->id;
}

bool flat_plies_concerns(const struct laminate *laminate, size_t k,
                         const struct api_warning *warning) {
    static const char *const whole[] = {"uncovered", "locked", "packing_exceeded", "components"};
    bool of_whole = false;
    for (size_t n = 0; n < sizeof whole / sizeof *whole; n++)
        of_whole = of_whole || strcmp(warning->code, whole[n]) == 0;
    return laminate->plies[k].boundary.count == 0 || !of_whole;
}

void flat_plies_free(struct flat_plies *shapes) {
    for (size_t k = 0; k < shapes->count; k++)
        polygons_free(&shapes->shapes[k].cut);
    shapes->count = 0;
}
