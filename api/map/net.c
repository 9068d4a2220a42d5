/* SPDX-License-Identifier: MIT */
#include "net.h"

#include "api/result/quads.h"
#include "solver/permeability.h"
#include <string.h>

enum { BLOCK = 2048 }; /* rows that are read at a time */

static enum api_problem_id damaged(struct api_problem *problem) {
    api_problem_set(problem, API_INTERNAL, "the stored result is damaged or cannot be read");
    return problem->id;
}

static enum api_problem_id no_memory(struct api_problem *problem) {
    api_problem_set(problem, API_OUT_OF_MEMORY, "the map needs more memory than allowed");
    return problem->id;
}

/* ---- groups ---- */

/* Whether the columns from this one on are these. */
static bool begins(const struct api_column *column, size_t left, const char *const *names,
                   size_t count) {
    for (size_t k = 0; k < count; k++)
        if (k >= left || strcmp(column[k].name, names[k]) != 0)
            return false;
    return true;
}

static bool is_tensor(const struct api_column *column, size_t left) {
    static const enum column_id ids[] = {COLUMN_CELLS_k1, COLUMN_CELLS_k2, COLUMN_CELLS_k3,
                                         COLUMN_CELLS_k1_direction};
    const char *names[MAP_TENSOR_COLUMNS];
    return begins(column, left, names, column_part_names(ids, sizeof ids / sizeof *ids, names));
}

static size_t add_group(struct map_net *net, const struct api_column *column, size_t left) {
    const struct column_spec *spec = column_spec_find(column->table, column->name);
    struct map_group group = {column, spec, MAP_SMOOTH, 1, net->width};
    size_t values = 1;
    if (column->integer) {
        group.kind = MAP_CELL;
    } else if (is_tensor(column, left)) {
        group.kind = MAP_TENSOR;
        group.columns = MAP_TENSOR_COLUMNS;
        values = MAP_TENSOR_VALUES;
    } else if (spec && spec->kind == COLUMN_VECTOR &&
               begins(column, left, spec->part, (size_t)spec->parts)) {
        group.kind = MAP_VECTOR;
        group.columns = values = 3;
    }
    net->group[net->group_count++] = group;
    net->column_count += group.columns;
    net->width += values;
    return group.columns;
}

static bool find_vector(const struct map_net *net, enum column_id id, size_t *place) {
    for (size_t k = 0; k < net->group_count; k++) {
        *place = net->group[k].place;
        if (net->group[k].kind == MAP_VECTOR && net->group[k].spec == &column_specs[id])
            return true;
    }
    return false;
}

enum api_problem_id map_net_open(const struct api_reader *reader, struct map_net *net,
                                 struct api_problem *problem) {
    struct api_columns *columns = &net->columns;
    size_t end = 0;
    memset(net, 0, sizeof *net);
    if (api_columns_open(reader, columns, problem) != API_OK)
        return problem->id;
    while (end < columns->count && columns->column[end].table != API_TABLE_FRONT)
        end++;
    for (size_t k = 0; k < end;)
        k += columns->column[k].table == API_TABLE_CELLS
                 ? add_group(net, &columns->column[k], end - k)
                 : 1;
    const double *spacing = columns->grid.spacing;
    net->spacing = spacing[0] > spacing[1] ? spacing[0] : spacing[1];
    if (!find_vector(net, COLUMN_CELLS_warp, &net->warp) ||
        !find_vector(net, COLUMN_CELLS_weft, &net->weft))
        return damaged(problem);
    if (api_columns_rows(columns, API_TABLE_CELLS) == 0)
        api_problem_set(problem, API_INVALID_REQUEST,
                        "the net has no cells, so there is nothing to map");
    return problem->id;
}

/* ---- the cloth ---- */

/* One coordinate of all nodes, into every third double from `out` on. */
static bool read_coordinate(const struct api_reader *reader, const struct api_columns *columns,
                            const char *name, double *out) {
    const struct api_column *column = api_columns_find(columns, API_TABLE_NODES, name);
    double block[BLOCK];
    for (size_t first = 0; column && first < column->rows; first += BLOCK) {
        size_t left = column->rows - first, count = left < BLOCK ? left : BLOCK;
        if (!api_columns_read(reader, column, first, count, block))
            return false;
        for (size_t k = 0; k < count; k++)
            out[3 * (first + k)] = block[k];
    }
    return column != NULL;
}

static enum api_problem_id load_cloth(const struct api_reader *reader, struct arena *arena,
                                      struct map_net *net, struct api_problem *problem) {
    const struct api_columns *columns = &net->columns;
    size_t nodes = api_columns_rows(columns, API_TABLE_NODES);
    size_t cells = api_columns_rows(columns, API_TABLE_CELLS);
    double(*points)[3] = arena_take(arena, nodes, sizeof *points);
    int32_t(*corners)[4] = arena_take(arena, cells, sizeof *corners);
    int32_t(*places)[2] = arena_take(arena, cells, sizeof *places);
    struct quads *quads = arena_take(arena, 1, sizeof *quads);
    if (!points || !corners || !places || !quads)
        return no_memory(problem);
    if (!read_coordinate(reader, columns, "x", &points[0][0]) ||
        !read_coordinate(reader, columns, "y", &points[0][1]) ||
        !read_coordinate(reader, columns, "z", &points[0][2]) ||
        !quads_begin(quads, reader, columns) || !quads_next(quads, cells, corners, places))
        return damaged(problem);
    _Static_assert(sizeof(struct vec3) == 3 * sizeof(double), "a point is its coordinates");
    const struct facets_source source = {.nodes = (const struct vec3 *)(const void *)points,
                                         .node_count = nodes,
                                         .corners = (const int32_t(*)[4])corners,
                                         .places = (const int32_t(*)[2])places,
                                         .cell_count = cells};
    return facets_make(&source, arena, &net->facets) == STATUS_OK ? API_OK : no_memory(problem);
}

/* ---- the rows ---- */

struct block {
    size_t first, count;
    double values[MAP_TENSOR_COLUMNS][BLOCK];
};

static struct vec3 vector_at(const double *values) {
    return vec3_make(values[0], values[1], values[2]);
}

/* k1 d d^T + k2 (n x d)(n x d)^T with d = a warp + b e2, the permeability's frame. */
static void put_tensors(const struct map_net *net, size_t place, const struct block *block) {
    const double(*v)[BLOCK] = block->values;
    for (size_t k = 0; k < block->count; k++) {
        double *row = net->rows + (block->first + k) * net->width;
        struct vec3 warp = vector_at(row + net->warp), weft = vector_at(row + net->weft);
        struct vec3 d = vec3_make(v[3][k], v[4][k], v[5][k]);
        double a = vec3_dot(d, warp), b = vec3_dot(d, permeability_across(warp, weft));
        row[place] = v[0][k] * a * a + v[1][k] * b * b;
        row[place + 1] = (v[0][k] - v[1][k]) * a * b;
        row[place + 2] = v[0][k] * b * b + v[1][k] * a * a;
        row[place + 3] = v[2][k];
    }
}

/* The groups of one kind or of all others: a tensor takes the yarns of its row. */
static bool fill_rows(const struct api_reader *reader, const struct map_net *net, bool tensors,
                      struct block *block) {
    for (size_t k = 0; k < net->group_count; k++) {
        const struct map_group *group = &net->group[k];
        if ((group->kind == MAP_TENSOR) != tensors)
            continue;
        for (size_t column = 0; column < group->columns; column++)
            if (!api_columns_read(reader, &group->column[column], block->first, block->count,
                                  block->values[column]))
                return false;
        if (tensors)
            put_tensors(net, group->place, block);
        for (size_t row = 0; row < block->count && !tensors; row++)
            for (size_t column = 0; column < group->columns; column++)
                net->rows[(block->first + row) * net->width + group->place + column] =
                    block->values[column][row];
    }
    return true;
}

static enum api_problem_id load_rows(const struct api_reader *reader,
                                     const struct drape_monitor *monitor, struct arena *arena,
                                     struct map_net *net, struct api_problem *problem) {
    size_t cells = api_columns_rows(&net->columns, API_TABLE_CELLS);
    struct block *block = arena_take(arena, 1, sizeof *block);
    net->rows = arena_take(arena, cells, net->width * sizeof *net->rows);
    if (!block || !net->rows)
        return no_memory(problem);
    for (block->first = 0; block->first < cells; block->first += BLOCK) {
        size_t left = cells - block->first;
        block->count = left < BLOCK ? left : BLOCK;
        if (!fill_rows(reader, net, false, block) || !fill_rows(reader, net, true, block))
            return damaged(problem);
        if (monitor && !monitor->progress(monitor->context, 0)) {
            api_problem_set(problem, API_CANCELLED, "the map was cancelled");
            return problem->id;
        }
    }
    return API_OK;
}

enum api_problem_id map_net_load(const struct api_reader *reader,
                                 const struct drape_monitor *monitor, struct arena *arena,
                                 struct map_net *net, struct api_problem *problem) {
    enum api_problem_id result = load_rows(reader, monitor, arena, net, problem);
    return result == API_OK ? load_cloth(reader, arena, net, problem) : result;
}

/* ---- places ---- */

/* Adds the mean of the cells around a corner, `weight` times. */
static void add_corner(const struct map_net *net, const int32_t around[4], double weight,
                       double *row) {
    int count = 0;
    for (int k = 0; k < 4; k++)
        count += around[k] != FACETS_NONE;
    for (int k = 0; k < 4; k++) {
        if (around[k] == FACETS_NONE)
            continue;
        const double *own = net->rows + (size_t)around[k] * net->width;
        for (size_t v = 0; v < net->width; v++)
            row[v] += weight / count * own[v];
    }
}

void map_net_interpolate(const struct map_net *net, const struct facets_place *place, double *row) {
    const struct facets *facets = net->facets;
    const int32_t *corners = facets->source.corners[place->cell];
    const double *cell = net->rows + (size_t)place->cell * net->width;
    for (size_t v = 0; v < net->width; v++)
        row[v] = place->weight[0] * cell[v];
    for (int k = 0; k < 2; k++)
        if (place->weight[1 + k] > 0)
            add_corner(net, facets->around[corners[(place->side + k) & 3]], place->weight[1 + k],
                       row);
    for (size_t k = 0; k < net->group_count; k++)
        if (net->group[k].kind == MAP_CELL)
            row[net->group[k].place] = cell[net->group[k].place];
}

void map_net_yarns(const struct map_net *net, const struct facets_place *place, const double *row,
                   struct vec3 *warp, struct vec3 *weft) {
    const double *cell = net->rows + (size_t)place->cell * net->width;
    *warp = vec3_unit(vector_at(row + net->warp));
    *weft = vec3_unit(vector_at(row + net->weft));
    if (vec3_norm2(*warp) == 0)
        *warp = vector_at(cell + net->warp);
    if (vec3_norm2(*weft) == 0)
        *weft = vector_at(cell + net->weft);
}
