/* SPDX-License-Identifier: MIT */
#include "net.h"

#include "api/result/cell_corners.h"
#include "api/result/fields.h"
#include "solver/permeability.h"
#include <stdlib.h>
#include <string.h>

enum { BLOCK = 2048 }; /* rows that are read at a time */

enum api_problem_id map_net_damaged(struct api_problem *problem) {
    return api_problem_set(problem, API_INTERNAL, "the stored result is damaged or cannot be read");
}

enum api_problem_id map_net_no_memory(struct api_problem *problem) {
    return api_problem_set(problem, API_OUT_OF_MEMORY, "the map needs more memory than allowed");
}

/* ---- groups ---- */

/* Whether the columns from this one on are these. */
static bool are_columns(const struct api_column *column, size_t left, const char *const *names,
                        size_t count) {
    for (size_t k = 0; k < count; k++)
        if (k >= left || strcmp(column[k].name, names[k]) != 0)
            return false;
    return true;
}

/* Behind those that are there. */
static void add_group(struct map_net *net, struct map_group *group) {
    group->offset = net->width;
    net->width += group->kind == MAP_TENSOR ? MAP_TENSOR_VALUES : group->columns;
    net->column_count += group->columns;
    net->group[net->group_count++] = *group;
}

static bool find_vector(const struct map_net *net, enum column_id id, size_t *offset) {
    for (size_t k = 0; k < net->group_count; k++) {
        *offset = net->group[k].offset;
        if (net->group[k].kind == MAP_VECTOR && net->group[k].spec == &column_specs[id])
            return true;
    }
    return false;
}

enum api_problem_id map_net_open(const struct api_reader *reader, struct map_net *net,
                                 struct api_problem *problem) {
    static const enum column_id ids[] = {COLUMN_CELLS_k1, COLUMN_CELLS_k2, COLUMN_CELLS_k3,
                                         COLUMN_CELLS_k1_direction};
    const char *tensor[MAP_TENSOR_COLUMNS];
    size_t parts = column_part_names(ids, sizeof ids / sizeof *ids, tensor), end = 0;
    struct api_columns *columns = &net->columns;
    memset(net, 0, sizeof *net);
    if (api_columns_open(reader, columns, problem) != API_OK)
        return problem->id;
    while (end < columns->count && columns->column[end].table != API_TABLE_FRONT)
        end++;
    for (size_t k = 0, taken; k < end; k += taken) {
        const struct api_column *column = &columns->column[k];
        const struct column_spec *spec = column_spec_find(column->table, column->name);
        struct map_group group = {column, spec, MAP_SMOOTH, 1, 0};
        bool yarn =
            spec == &column_specs[COLUMN_CELLS_warp] || spec == &column_specs[COLUMN_CELLS_weft];
        taken = 1;
        if (column->table != API_TABLE_CELLS)
            continue;
        if (column->integer) {
            group.kind = MAP_CELL;
        } else if (are_columns(column, end - k, tensor, parts)) {
            group.kind = MAP_TENSOR;
            group.columns = MAP_TENSOR_COLUMNS;
        } else if (yarn && are_columns(column, end - k, spec->part, (size_t)spec->parts)) {
            group.kind = MAP_VECTOR;
            group.columns = 3;
        }
        taken = group.columns;
        add_group(net, &group);
    }
    const double *spacing = columns->grid.spacing;
    net->spacing = spacing[0] > spacing[1] ? spacing[0] : spacing[1];
    if (!find_vector(net, COLUMN_CELLS_warp, &net->warp) ||
        !find_vector(net, COLUMN_CELLS_weft, &net->weft))
        return map_net_damaged(problem);
    net->whole = api_columns_rows(columns, API_TABLE_CELLS);
    net->cut = api_columns_rows(columns, API_TABLE_CUT);
    if (net->whole + net->cut == 0)
        return api_problem_set(problem, API_INVALID_REQUEST,
                               "the net has no cells, so there is nothing to map");
    return API_OK;
}

void map_net_keep(struct map_net *net, const enum column_id *ids, size_t count) {
    size_t all = net->group_count;
    net->group_count = net->column_count = net->width = 0;
    for (size_t k = 0; k < all; k++) {
        struct map_group group = net->group[k];
        bool wanted = false;
        for (size_t n = 0; n < count; n++)
            wanted = wanted || group.spec == &column_specs[ids[n]];
        if (wanted)
            add_group(net, &group);
    }
    (void)find_vector(net, COLUMN_CELLS_warp, &net->warp);
    (void)find_vector(net, COLUMN_CELLS_weft, &net->weft);
}

/* ---- the cloth ---- */

/* A column of all rows, into every `stride`-th double from `out` on. */
static bool read_whole_column(const struct api_reader *reader, const struct api_columns *columns,
                              enum api_table table, const char *name, size_t stride, double *out) {
    const struct api_column *column = api_columns_find(columns, table, name);
    double block[BLOCK];
    for (size_t first = 0; column && first < column->rows; first += BLOCK) {
        size_t left = column->rows - first, count = left < BLOCK ? left : BLOCK;
        if (!api_columns_read(reader, column, first, count, block))
            return false;
        for (size_t k = 0; k < count; k++)
            out[stride * (first + k)] = block[k];
    }
    return column != NULL;
}

/* The cloth while it is gathered. */
struct gathering {
    double (*points)[3]; /* the nodes, then corners beyond them of cells that are cut */
    int32_t (*corners)[4];
    int32_t (*places)[2];
    double (*node)[2]; /* i and j of the nodes */
    double (*cut)[14]; /* i, j and the corners of the cells that are cut */
    struct corner {
        int32_t i, j;
        int32_t *index; /* where its number is wanted */
        const double *r;
    } * beyond;
    size_t nodes, count;
};

static int compare_corners(const void *a, const void *b) {
    const struct corner *p = a, *q = b;
    return p->j != q->j ? (p->j > q->j) - (p->j < q->j) : (p->i > q->i) - (p->i < q->i);
}

/* The number of the node (i, j), or FACETS_NONE. */
static int32_t node_at(const struct gathering *g, int32_t i, int32_t j) {
    size_t low = 0, high = g->nodes;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        const double *at = g->node[middle];
        bool before = at[1] < j || (at[1] == j && at[0] < i);
        low = before ? middle + 1 : low;
        high = before ? high : middle;
    }
    return low < g->nodes && g->node[low][0] == i && g->node[low][1] == j ? (int32_t)low
                                                                          : FACETS_NONE;
}

static bool read_cloth(const struct api_reader *reader, const struct map_net *net,
                       struct gathering *g) {
    static const char *const places[] = {"i", "j"}, *const points[] = {"x", "y", "z"};
    const struct api_columns *columns = &net->columns;
    bool good = true;
    for (int k = 0; k < 3; k++)
        good = good &&
               read_whole_column(reader, columns, API_TABLE_NODES, points[k], 3, &g->points[0][k]);
    for (int k = 0; net->cut && k < 2; k++)
        good = good &&
               read_whole_column(reader, columns, API_TABLE_NODES, places[k], 2, &g->node[0][k]) &&
               read_whole_column(reader, columns, API_TABLE_CUT, places[k], 14, &g->cut[0][k]);
    for (int k = 0; net->cut && k < 12; k++)
        good = good && read_whole_column(reader, columns, API_TABLE_CUT, api_fields_corners[k], 14,
                                         &g->cut[0][2 + k]);
    return good;
}

static enum api_problem_id load_cloth(const struct api_reader *reader, struct arena *arena,
                                      struct map_net *net, struct api_problem *problem) {
    const struct api_columns *columns = &net->columns;
    size_t nodes = api_columns_rows(columns, API_TABLE_NODES), cells = net->whole + net->cut;
    struct gathering g = {.nodes = nodes};
    struct cell_corners *quads = arena_take(arena, 1, sizeof *quads);
    g.points = arena_take(arena, nodes + 4 * net->cut, sizeof *g.points);
    g.corners = arena_take(arena, cells, sizeof *g.corners);
    g.places = arena_take(arena, cells, sizeof *g.places);
    g.node = arena_take(arena, net->cut ? nodes : 0, sizeof *g.node);
    g.cut = arena_take(arena, net->cut, sizeof *g.cut);
    g.beyond = arena_take(arena, 4 * net->cut, sizeof *g.beyond);
    if (!g.points || !g.corners || !g.places || !g.node || !g.cut || !g.beyond || !quads)
        return map_net_no_memory(problem);
    if (nodes + 4 * net->cut > INT32_MAX || !read_cloth(reader, net, &g) ||
        !cell_corners_begin(quads, reader, columns) ||
        !cell_corners_next(quads, net->whole, g.corners, g.places))
        return map_net_damaged(problem);
    for (size_t k = 0; k < net->cut; k++) {
        size_t cell = net->whole + k;
        for (int side = 0; side < 2; side++)
            g.places[cell][side] = (int32_t)g.cut[k][side];
        for (int c = 0; c < 4; c++) { /* a corner gets its number, or is noted */
            int32_t i = g.places[cell][0] + (c == 1 || c == 2), j = g.places[cell][1] + c / 2;
            int32_t *corner = &g.corners[cell][c];
            *corner = node_at(&g, i, j);
            if (*corner == FACETS_NONE)
                g.beyond[g.count++] = (struct corner){i, j, corner, g.cut[k] + 2 + 3 * c};
        }
    }
    /* The corners that are no nodes are numbered after these, each once. */
    size_t points = nodes;
    if (g.count)
        qsort(g.beyond, g.count, sizeof *g.beyond, compare_corners);
    for (size_t k = 0; k < g.count; k++) {
        if (k == 0 || compare_corners(&g.beyond[k - 1], &g.beyond[k]) != 0)
            memcpy(g.points[points++], g.beyond[k].r, sizeof *g.points);
        *g.beyond[k].index = (int32_t)(points - 1);
    }
    _Static_assert(sizeof(struct vec3) == 3 * sizeof(double), "a point is its coordinates");
    const struct facets_source source = {.node_count = points,
                                         .nodes = (const struct vec3 *)(const void *)g.points,
                                         .corners = (const int32_t(*)[4])g.corners,
                                         .places = (const int32_t(*)[2])g.places,
                                         .cell_count = cells};
    return facets_make(&source, arena, &net->facets) == STATUS_OK ? API_OK
                                                                  : map_net_no_memory(problem);
}

/* ---- the rows ---- */

struct block {
    enum api_table table;
    size_t first, count;
    size_t row; /* of the first */
    double values[MAP_TENSOR_COLUMNS][BLOCK];
};

static struct vec3 vector_of(const double *values) {
    return vec3_make(values[0], values[1], values[2]);
}

/* The groups of one kind or of all others: a tensor takes the yarns of its row. */
static bool fill_block(const struct api_reader *reader, const struct map_net *net, bool tensors,
                       struct block *block) {
    for (size_t g = 0; g < net->group_count; g++) {
        const struct map_group *group = &net->group[g];
        if ((group->kind == MAP_TENSOR) != tensors)
            continue;
        for (size_t c = 0; c < group->columns; c++) {
            const struct api_column *column =
                api_columns_find(&net->columns, block->table, group->column[c].name);
            if (!column ||
                !api_columns_read(reader, column, block->first, block->count, block->values[c]))
                return false;
        }
        for (size_t k = 0; k < block->count && tensors; k++) {
            double(*v)[BLOCK] = block->values;
            double *row = net->rows + (block->row + k) * net->width;
            struct vec3 warp = vector_of(row + net->warp), weft = vector_of(row + net->weft);
            struct vec3 d = vec3_make(v[3][k], v[4][k], v[5][k]);
            double a = vec3_dot(d, warp), b = vec3_dot(d, permeability_across(warp, weft));
            map_tensor_values(v[0][k], v[1][k], v[2][k], a, b, row + group->offset);
        }
        for (size_t row = 0; row < block->count && !tensors; row++)
            for (size_t column = 0; column < group->columns; column++)
                net->rows[(block->row + row) * net->width + group->offset + column] =
                    block->values[column][row];
    }
    return true;
}

enum api_problem_id map_net_load(const struct api_reader *reader,
                                 const struct drape_monitor *monitor, struct arena *arena,
                                 struct map_net *net, struct api_problem *problem) {
    struct block *block = arena_take(arena, 1, sizeof *block);
    net->rows = arena_take(arena, net->whole + net->cut, net->width * sizeof *net->rows);
    if (!block || !net->rows)
        return map_net_no_memory(problem);
    for (int cut = 0; cut < 2; cut++) { /* rows of the whole cells, then of those that are cut */
        size_t cells = cut ? net->cut : net->whole;
        block->table = cut ? API_TABLE_CUT : API_TABLE_CELLS;
        for (block->first = 0; block->first < cells; block->first += BLOCK) {
            size_t left = cells - block->first;
            block->count = left < BLOCK ? left : BLOCK;
            block->row = block->first + (cut ? net->whole : 0);
            if (!fill_block(reader, net, false, block) || !fill_block(reader, net, true, block))
                return map_net_damaged(problem);
            if (monitor && !monitor->progress(monitor->context, 0))
                return api_problem_set(problem, API_CANCELLED, "the map was cancelled");
        }
    }
    if (load_cloth(reader, arena, net, problem) != API_OK ||
        stored_rim_make(reader, &net->columns, arena, &net->edge, problem) != API_OK)
        return problem->id;
    net->clear = arena_take(arena, net->whole, sizeof *net->clear);
    if (!net->clear)
        return map_net_no_memory(problem);
    stored_rim_find_clear(net->edge, net->facets->source.places, net->whole, net->clear);
    return API_OK;
}

/* ---- points ---- */

void map_net_coordinates(const struct facets *facets, const struct facets_point *point,
                         double pq[2]) {
    static const int8_t corner[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    const int32_t *at = facets->source.places[point->cell];
    const int8_t *a = corner[point->side & 3], *b = corner[(point->side + 1) & 3];
    for (int k = 0; k < 2; k++)
        pq[k] = at[k] + point->weight[0] / 2 + point->weight[1] * a[k] + point->weight[2] * b[k];
}

bool map_net_is_beyond(const struct map_net *net, const struct facets_point *point) {
    double pq[2];
    if (!point->outside && (size_t)point->cell < net->whole && net->clear[point->cell])
        return false;
    map_net_coordinates(net->facets, point, pq);
    /* On facets, which lie off the surface, a point is right to about their distance. */
    return point->outside ||
           stored_rim_is_beyond(net->edge, pq[0], pq[1], 2 * point->distance / net->spacing);
}

void map_net_interpolate(const struct map_net *net, const struct facets_point *point, double *row) {
    const struct facets *facets = net->facets;
    const int32_t *corners = facets->source.corners[point->cell];
    const double *cell = net->rows + (size_t)point->cell * net->width;
    for (size_t v = 0; v < net->width; v++)
        row[v] = point->weight[0] * cell[v];
    for (int k = 0; k < 2; k++) { /* of a corner the mean of the cells around it */
        const int32_t *around = facets->around[corners[(point->side + k) & 3]];
        double weight = point->weight[1 + k];
        int count = 0;
        for (int c = 0; c < 4; c++)
            count += around[c] != FACETS_NONE;
        for (int c = 0; c < 4 && weight > 0; c++) {
            const double *own = net->rows + (size_t)around[c] * net->width;
            for (size_t v = 0; v < net->width && around[c] != FACETS_NONE; v++)
                row[v] += weight / count * own[v];
        }
    }
    for (size_t k = 0; k < net->group_count; k++)
        if (net->group[k].kind == MAP_CELL)
            row[net->group[k].offset] = cell[net->group[k].offset];
}

void map_net_yarns(const struct map_net *net, const struct facets_point *point, const double *row,
                   struct vec3 *warp, struct vec3 *weft) {
    const double *cell = net->rows + (size_t)point->cell * net->width;
    *warp = vec3_unit(vector_of(row + net->warp));
    *weft = vec3_unit(vector_of(row + net->weft));
    if (vec3_norm2(*warp) == 0)
        *warp = vector_of(cell + net->warp);
    if (vec3_norm2(*weft) == 0)
        *weft = vector_of(cell + net->weft);
}
