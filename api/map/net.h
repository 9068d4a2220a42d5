/* SPDX-License-Identifier: MIT */
/*
 * The net of a stored result as it is mapped from: its cloth, and what is known in its cells. The
 * values of a cell stand in one row, because a point needs those of up to six cells at once.
 */
#ifndef API_MAP_NET_H
#define API_MAP_NET_H

#include "api/result/columns.h"
#include "api/result/stored_rim.h"
#include "solver/mesh/facets.h"

/* How a column of the cells is mapped. */
enum map_kind {
    MAP_SMOOTH, /* interpolated */
    MAP_VECTOR, /* the first of three that are a yarn's: interpolated, then made unit again */
    MAP_TENSOR, /* the first of k1, k2, k3, k1_x, k1_y, k1_z */
    MAP_CELL    /* that of the cell */
};

/* What a row holds of a permeability: its components in the frame of the warp (`permeability.h`),
 * k_ww, k_wa, k_aa of the tangent plane, then k3. They turn with the cloth; and a mean of positive
 * tensors in that frame is positive. */
enum { MAP_TENSOR_COLUMNS = 6, MAP_TENSOR_VALUES = 4 };

/* k1 d d^T + k2 (n x d)(n x d)^T with d = a warp + b e2, and k3, in that frame. */
static inline void map_tensor_values(double k1, double k2, double k3, double a, double b,
                                     double values[MAP_TENSOR_VALUES]) {
    values[0] = k1 * a * a + k2 * b * b;
    values[1] = (k1 - k2) * a * b;
    values[2] = k1 * b * b + k2 * a * a;
    values[3] = k3;
}

struct map_group {
    const struct api_column *column; /* the first; the others follow it */
    const struct column_spec *spec;  /* of it; NULL for an unknown one */
    enum map_kind kind;
    size_t columns; /* of the result */
    size_t offset;  /* of its first value in a row */
};

struct map_net {
    struct api_columns columns; /* of the result; `group` points into it: not to be moved */
    struct map_group group[API_COLUMNS_MAX];
    size_t group_count;
    size_t column_count; /* of all groups */
    size_t width;        /* of a row */
    size_t warp, weft;   /* their offsets in a row */
    double spacing;      /* the larger one */
    struct facets *facets;
    size_t whole, cut; /* cells: whole ones, then those that the rim cuts */
    double *rows;      /* one a cell */
    struct stored_rim *edge;
    bool *clear; /* of each whole cell: no rim comes near it */
};

/* Reads the header and lists the groups, in the order of their columns. API_INVALID_REQUEST when
 * the net has no cells, API_INTERNAL for a container that is damaged or has no yarn directions. */
enum api_problem_id map_net_open(const struct api_reader *reader, struct map_net *net,
                                 struct api_problem *problem) STATUS_MUST_USE;

/* API_INTERNAL, that the result cannot be read; API_OUT_OF_MEMORY. */
enum api_problem_id map_net_damaged(struct api_problem *problem);
enum api_problem_id map_net_no_memory(struct api_problem *problem);

/* Before it is loaded: leaves out all groups but these, which have to have warp and weft. */
void map_net_keep(struct map_net *net, const enum column_id *ids, size_t count);

/* Then reads the net into `arena`. `monitor` (may be NULL) is asked whether to go on. API_INTERNAL,
 * API_CANCELLED, API_OUT_OF_MEMORY. */
enum api_problem_id map_net_load(const struct api_reader *reader,
                                 const struct drape_monitor *monitor, struct arena *arena,
                                 struct map_net *net, struct api_problem *problem) STATUS_MUST_USE;

/* (p, q) of a point of the cloth. */
void map_net_coordinates(const struct facets *facets, const struct facets_point *point,
                         double pq[2]);

/* Whether a point lies beyond the cloth: off the cells, or beyond the rim in one that it cuts. */
bool map_net_is_beyond(const struct map_net *net, const struct facets_point *point);

/* The row at a point of the cloth, `width` values: linear on each facet between the cell's own at
 * its middle and the mean of the cells around it at a corner; those of MAP_CELL are the cell's. */
void map_net_interpolate(const struct map_net *net, const struct facets_point *point, double *row);

/* The warp and weft of a row, unit vectors; where a mean vanishes, those of the cell. */
void map_net_yarns(const struct map_net *net, const struct facets_point *point, const double *row,
                   struct vec3 *warp, struct vec3 *weft);

#endif
