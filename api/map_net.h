/* SPDX-License-Identifier: MIT */
/* The net of a stored result as it is mapped from: its cloth, and what is known in its cells. */
#ifndef API_MAP_NET_H
#define API_MAP_NET_H

#include "../solver/facets.h"
#include "columns.h"

/* How a column of the cells is mapped. */
enum map_kind {
    MAP_SMOOTH, /* interpolated */
    MAP_VECTOR, /* the first of three that are a direction */
    MAP_TENSOR, /* the first of k1, k2, k3, k1_x, k1_y, k1_z: kept in the frame of the warp */
    MAP_CELL    /* that of the cell */
};

struct map_group {
    const struct api_column *column; /* the first; the others follow it */
    enum map_kind kind;
    size_t columns; /* of the result */
    size_t place;   /* of its first value in a row, which holds up to `columns` values */
};

enum { MAP_GROUPS_MAX = API_COLUMNS_MAX };

struct map_net {
    struct api_columns columns; /* of the result; `group` points into it */
    struct facets *facets;
    struct map_group group[MAP_GROUPS_MAX];
    size_t group_count;
    size_t width; /* of a row */
    size_t warp, weft; /* places in the row */
    double *rows; /* one a cell */
    double reach; /* the larger spacing */
};

/* Reads the net into `arena`. Problems as in `api_map_make`. */
enum api_problem_id map_net_load(const struct api_reader *reader, struct arena *arena,
                                 struct map_net *net, struct api_problem *problem) STATUS_MUST_USE;

/* One row of values at a place of the cloth: smooth ones interpolated, those of MAP_CELL of the
 * cell. */
void map_net_interpolate(const struct map_net *net, const struct facets_place *place, double *row);

#endif
