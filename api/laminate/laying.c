/* SPDX-License-Identifier: MIT */
#include "laying.h"

#include "api/format/cut_sheet.h"
#include "api/result/shear_limit.h"
#include <math.h>
#include <stdlib.h>

enum { LAYING_BLOCK = 512, PLACES = LAYING_SECTORS + 1 };

/* Rows of three columns of a table, at most LAYING_BLOCK of them; false when they cannot be read.
 */
static bool read_laying_rows(const struct api_reader *net, const struct api_columns *columns,
                             enum api_table table, const char *const *names, int count,
                             size_t first, size_t rows, double block[][LAYING_BLOCK]) {
    for (int c = 0; c < count; c++) {
        const struct api_column *column = api_columns_find(columns, table, names[c]);
        if (!column || !api_columns_read(net, column, first, rows, block[c]))
            return false;
    }
    return true;
}

/* Takes the cells of a table whose middles lie in the shape into their sectors. */
static bool sort_into_sectors(const struct api_reader *net, const struct api_columns *columns,
                              enum api_table table, const struct api_fabric *fabric,
                              const struct flat_ply *shape, struct laying *laying) {
    static const char *const names[] = {"i", "j", "shear_deg"};
    const double *d = columns->grid.spacing;
    double block[3][LAYING_BLOCK];
    size_t rows = api_columns_rows(columns, table);
    for (size_t first = 0, held; first < rows; first += held) {
        held = rows - first < LAYING_BLOCK ? rows - first : LAYING_BLOCK;
        if (!read_laying_rows(net, columns, table, names, 3, first, held, block))
            return false;
        for (size_t k = 0; k < held; k++) {
            double x = (block[0][k] + 0.5) * d[0], y = (block[1][k] + 0.5) * d[1];
            double shear = block[2][k];
            if (!polygons_contain(&shape->cut, x, y))
                continue;
            struct laying_sector *sector =
                &laying->sectors[(x < laying->begin[0]) + 2 * (y < laying->begin[1])];
            sector->cells++;
            sector->mean_deg += fabs(shear);
            sector->locked += table == API_TABLE_CELLS && shear_limit_locks(fabric, shear);
            if (sector->cells == 1 || fabs(shear) > fabs(sector->greatest_deg)) {
                sector->greatest_deg = shear;
                sector->flat[0] = x;
                sector->flat[1] = y;
            }
        }
    }
    return true;
}

/* The nodes that are nearest, in the net, to flat places. */
static bool find_sector_places(const struct api_reader *net, const struct api_columns *columns,
                               const double (*flat)[2], struct vec3 places[PLACES]) {
    static const char *const names[] = {"i", "j", "x", "y", "z"};
    const double *d = columns->grid.spacing;
    double block[5][LAYING_BLOCK], nearest[PLACES];
    size_t rows = api_columns_rows(columns, API_TABLE_NODES);
    for (int n = 0; n < PLACES; n++)
        nearest[n] = HUGE_VAL;
    for (size_t first = 0, held; first < rows; first += held) {
        held = rows - first < LAYING_BLOCK ? rows - first : LAYING_BLOCK;
        if (!read_laying_rows(net, columns, API_TABLE_NODES, names, 5, first, held, block))
            return false;
        for (size_t k = 0; k < held; k++)
            for (int n = 0; n < PLACES; n++) {
                double away =
                    hypot(block[0][k] * d[0] - flat[n][0], block[1][k] * d[1] - flat[n][1]);
                if (away < nearest[n]) {
                    nearest[n] = away;
                    places[n] = vec3_make(block[2][k], block[3][k], block[4][k]);
                }
            }
    }
    return true;
}

/* How far the shape goes from where it is begun, along one of the yarns there. */
static void find_reach(const struct polygons *cut, const double begin[2], int yarn,
                       double reach[2]) {
    reach[0] = reach[1] = HUGE_VAL;
    for (size_t k = 0, first = 0; k < cut->count; k++) {
        const struct polygons_point *a = &cut->points[k];
        const struct polygons_point *b = &cut->points[a->last ? first : k + 1];
        double across[2] = {(yarn ? a->x : a->y) - begin[!yarn],
                            (yarn ? b->x : b->y) - begin[!yarn]};
        double along[2] = {(yarn ? a->y : a->x) - begin[yarn], (yarn ? b->y : b->x) - begin[yarn]};
        first = a->last ? k + 1 : first;
        if ((across[0] <= 0) == (across[1] <= 0))
            continue;
        double at = along[0] - across[0] / (across[1] - across[0]) * (along[1] - along[0]);
        reach[at > 0] = fmin(reach[at > 0], fabs(at));
    }
    for (int k = 0; k < 2; k++)
        reach[k] = isfinite(reach[k]) ? reach[k] : 0;
}

static int compare_sectors(const void *a, const void *b) {
    const struct laying_sector *x = a, *y = b;
    double first = fabs(x->greatest_deg), second = fabs(y->greatest_deg);
    if ((x->cells == 0) != (y->cells == 0))
        return x->cells == 0 ? 1 : -1;
    if (first < second || first > second)
        return first > second ? 1 : -1;
    return x->warp != y->warp ? y->warp - x->warp : y->weft - x->weft;
}

bool laying_find(const struct api_reader *net, const struct api_columns *columns,
                 const struct api_fabric *fabric, const struct flat_ply *shape,
                 struct laying *laying) {
    const struct nesting_shape outline = {.cut = &shape->cut,
                                          .low = {shape->low[0], shape->low[1]},
                                          .high = {shape->high[0], shape->high[1]}};
    const struct cut_chord chord = cut_chord_of(&outline);
    double flat[PLACES][2];
    struct vec3 places[PLACES] = {{0, 0, 0}};
    *laying = (struct laying){.at_start = polygons_contain(&shape->cut, 0, 0)};
    laying->begin[0] = laying->at_start ? 0 : (chord.x[0] + chord.x[1]) / 2;
    laying->begin[1] = laying->at_start ? 0 : chord.y;
    for (int k = 0; k < LAYING_SECTORS; k++) {
        laying->sectors[k].warp = k % 2 ? -1 : 1;
        laying->sectors[k].weft = k / 2 ? -1 : 1;
    }
    for (int yarn = 0; yarn < 2; yarn++)
        find_reach(&shape->cut, laying->begin, yarn, laying->reach[yarn]);
    if (!sort_into_sectors(net, columns, API_TABLE_CELLS, fabric, shape, laying) ||
        !sort_into_sectors(net, columns, API_TABLE_CUT, fabric, shape, laying))
        return false;
    qsort(laying->sectors, LAYING_SECTORS, sizeof *laying->sectors, compare_sectors);
    for (int k = 0; k < PLACES; k++)
        for (int n = 0; n < 2; n++)
            flat[k][n] = k < LAYING_SECTORS ? laying->sectors[k].flat[n] : laying->begin[n];
    if (!find_sector_places(net, columns, (const double(*)[2])flat, places))
        return false;
    laying->place = places[LAYING_SECTORS];
    for (int k = 0; k < LAYING_SECTORS; k++) {
        laying->sectors[k].place = places[k];
        laying->sectors[k].mean_deg /= fmax((double)laying->sectors[k].cells, 1);
    }
    return true;
}
