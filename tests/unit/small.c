/* SPDX-License-Identifier: MIT */
#include "small.h"

#include "tests/check.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double DEG = 3.14159265358979323846 / 180;

/* ---- a result ---- */

struct place {
    int i, j;
};

static int compare_places(const void *a, const void *b) {
    const struct place *p = a, *q = b;
    return p->j != q->j ? p->j - q->j : p->i - q->i;
}

/* Values follow from the place and the number of the column: nothing special, all different. */
struct rule {
    const struct place *places;
    int kind; /* 0: i, 1: j, 2: flag, else a number of its own */
};

static bool fill(const void *context, size_t first, size_t count, double *values) {
    const struct rule *rule = context;
    for (size_t k = 0; k < count; k++) {
        const struct place *p = &rule->places[first + k];
        switch (rule->kind) {
        case 0:
            values[k] = p->i;
            break;
        case 1:
            values[k] = p->j;
            break;
        case 2:
            values[k] = (p->i + p->j) % 2 != 0;
            break;
        default:
            values[k] = 0.125 * rule->kind + 0.5 * p->i - 0.25 * p->j;
        }
    }
    return true;
}

static const char *const node_names[] = {"i", "j", "u", "v", "x", "y", "z", "shear_deg"};
static const char *const cell_names[] = {
    "i",        "j",      "shear_deg", "thickness", "fiber_volume_fraction",
    "porosity", "warp_x", "warp_y",    "warp_z",    "weft_x",
    "weft_y",   "weft_z", "k1",        "k2",        "k3",
    "k1_x",     "k1_y",   "k1_z",      "locked"};

enum {
    NODE_NAMES = sizeof node_names / sizeof *node_names,
    CELL_NAMES = sizeof cell_names / sizeof *cell_names
};

static void add(struct api_column_source *source, struct rule *rule, enum api_table table,
                const char *name, int number, const struct place *places, size_t rows) {
    bool flag = strcmp(name, "locked") == 0;
    *rule = (struct rule){places, number < 2 ? number : flag ? 2 : number + 1};
    *source = (struct api_column_source){.table = table,
                                         .name = name,
                                         .integer = number < 2 || flag,
                                         .rows = rows,
                                         .fill = fill,
                                         .context = rule};
}

static size_t corners_of(const int (*cells)[2], size_t count, struct place *nodes) {
    size_t total = 0, kept = 0;
    for (size_t k = 0; k < count; k++)
        for (int c = 0; c < 4; c++)
            nodes[total++] = (struct place){cells[k][0] + c % 2, cells[k][1] + c / 2};
    qsort(nodes, total, sizeof *nodes, compare_places);
    for (size_t k = 0; k < total; k++)
        if (k == 0 || compare_places(&nodes[k], &nodes[kept - 1]) != 0)
            nodes[kept++] = nodes[k];
    return kept;
}

struct bytes small_result_of(const int (*cells)[2], size_t count, const char *unit) {
    struct place *nodes = calloc(4 * count + 1, sizeof *nodes);
    struct place *places = calloc(count + 1, sizeof *places);
    struct rule rules[NODE_NAMES + CELL_NAMES];
    struct api_column_source sources[NODE_NAMES + CELL_NAMES];
    struct bytes bytes = {0};
    struct api_problem problem = {0};
    size_t node_count = corners_of(cells, count, nodes), n = 0;
    for (size_t k = 0; k < count; k++)
        places[k] = (struct place){cells[k][0], cells[k][1]};
    for (int k = 0; k < NODE_NAMES; k++, n++)
        add(&sources[n], &rules[n], API_TABLE_NODES, node_names[k], k, nodes, node_count);
    for (int k = 0; k < CELL_NAMES; k++, n++)
        add(&sources[n], &rules[n], API_TABLE_CELLS, cell_names[k], k, places, count);
    struct api_columns header = {
        .summary = {.nodes = node_count,
                    .cells = count,
                    .coverage = 0.75,
                    .max_shear_deg = 2,
                    .max_shear_pinned_deg = 2,
                    .max_shear_grown_deg = -1,
                    .locked_cells = 1,
                    .error_estimate_max = -1,
                    .max_shear_error_deg = -1,
                    .thickness_error_max = -1,
                    .solver_version = "0"},
        .grid = {.warp = {0, 2}, .weft = {0, 2}, .spacing = {0.01, 0.02}},
    };
    for (int k = 0; k < API_UNIT_COUNT; k++)
        if (strcmp(api_units[k].name, unit) == 0)
            header.unit = &api_units[k];
    struct api_sink sink = sink_into(&bytes);
    struct arena *arena = arena_new(1 << 20);
    assert_int_equal(api_columns_write(&header, sources, n, &sink, arena, &problem), API_OK);
    arena_free(arena);
    free(nodes);
    free(places);
    return bytes;
}

struct bytes small_result(void) {
    static const int cells[][2] = {{0, 0}, {1, 0}, {0, 1}};
    return small_result_of(cells, 3, "m");
}

/* ---- meshes ---- */

static const char *const mesh_names[] = {"id",     "thickness", "porosity", "k1",     "k2",
                                         "k3",     "k1_x",      "k1_y",     "k1_z",   "warp_x",
                                         "warp_y", "warp_z",    "weft_x",   "weft_y", "weft_z"};
enum { MESH_NAMES = sizeof mesh_names / sizeof *mesh_names };

/* By rows: a fabric of 3 mm in a plane, its k1 along (cos a, sin a). */
static void mesh_row(double values[MESH_NAMES], double id, double degrees) {
    const double row[MESH_NAMES] = {id,
                                    3 + 0.001 * fmod(degrees, 180),
                                    0.604,
                                    1.63e-10,
                                    0.31 * 1.63e-10,
                                    1e-12,
                                    cos(degrees * DEG),
                                    sin(degrees * DEG),
                                    0,
                                    1,
                                    0,
                                    0,
                                    0,
                                    1,
                                    0};
    memcpy(values, row, sizeof row);
}

struct mesh_rule {
    const double (*rows)[MESH_NAMES];
    int column;
};

static bool fill_mesh(const void *context, size_t first, size_t count, double *values) {
    const struct mesh_rule *rule = context;
    for (size_t k = 0; k < count; k++)
        values[k] = rule->rows[first + k][rule->column];
    return true;
}

static struct map_fields mesh_of(const double (*rows)[MESH_NAMES], size_t count,
                                 struct mesh_rule *rules, struct api_column_source *sources) {
    for (int k = 0; k < MESH_NAMES; k++) {
        rules[k] = (struct mesh_rule){rows, k};
        sources[k] = (struct api_column_source){.table = API_TABLE_CELLS,
                                                .name = mesh_names[k],
                                                .integer = k == 0,
                                                .rows = count,
                                                .fill = fill_mesh,
                                                .context = &rules[k]};
    }
    return (struct map_fields){.unit = &api_units[2],
                               .element_count = count,
                               .columns = sources,
                               .column_count = MESH_NAMES};
}

static double mesh_rows[2][MESH_NAMES];

void small_mesh_set(const char *column, size_t element, double value) {
    for (int k = 0; k < MESH_NAMES; k++)
        if (strcmp(column, mesh_names[k]) == 0)
            mesh_rows[element][k] = value;
}

struct map_fields small_mesh(void) {
    static const struct vec3 vertices[] = {
        {0, 0, 0}, {100, 0, 0}, {100, 50.5, 0}, {0, 50, -0.0123456}, {150, 25, 1e-4}};
    static const int32_t elements[][4] = {{0, 1, 2, 3}, {1, 4, 2, -1}};
    static struct mesh_rule rules[MESH_NAMES];
    static struct api_column_source sources[MESH_NAMES];
    mesh_row(mesh_rows[0], 17, 0);
    mesh_row(mesh_rows[1], 4, 30);
    struct map_fields fields = mesh_of((const double(*)[MESH_NAMES])mesh_rows, 2, rules, sources);
    fields.vertices = vertices;
    fields.vertex_count = sizeof vertices / sizeof *vertices;
    fields.elements = elements;
    return fields;
}

struct map_fields small_stack(void) {
    static const char *const names[] = {"outer", "inner"};
    static const struct map_ply_row rows[] = {{0, 0, false, 30.25, 12.5, 0.5, 0.4},
                                              {0, 1, false, -59.75, -3, 0.25, 0.45},
                                              {1, 1, true, 170.125, 0, 0.75, 0.45}};
    static const size_t first[] = {0, 2, 3};
    static const int32_t ids[] = {17, 4}, vertex_ids[] = {11, 12, 13, 14, 1000000};
    static const struct vec3 reference = {1, 0.5, 0};
    static const struct map_plies plies = {.ply_count = 2,
                                           .side = -1,
                                           .names = names,
                                           .rows = rows,
                                           .row_count = 3,
                                           .first = first,
                                           .thickness = true,
                                           .fraction = true,
                                           .reference = &reference};
    struct map_fields fields = small_mesh();
    fields.plies = &plies;
    fields.ids = ids;
    fields.vertex_ids = vertex_ids;
    return fields;
}

/* All that a strip needs, in one block. */
struct strip {
    struct mesh_rule rules[MESH_NAMES];
    struct api_column_source sources[MESH_NAMES];
    double (*rows)[MESH_NAMES];
    struct vec3 *vertices;
    int32_t (*elements)[4];
};

static struct strip strip;

struct map_fields small_strip(size_t count, double turn_deg) {
    strip.rows = calloc(count, sizeof *strip.rows);
    strip.vertices = calloc(2 * count + 2, sizeof *strip.vertices);
    strip.elements = calloc(count, sizeof *strip.elements);
    for (size_t k = 0; k <= count; k++) {
        strip.vertices[2 * k] = vec3_make((double)k, 0, 0);
        strip.vertices[2 * k + 1] = vec3_make((double)k, 1, 0);
    }
    for (size_t k = 0; k < count; k++) {
        int32_t n = (int32_t)(2 * k);
        mesh_row(strip.rows[k], (double)k + 1, turn_deg * (double)k);
        memcpy(strip.elements[k], (const int32_t[]){n, n + 2, n + 3, n + 1}, 4 * sizeof n);
    }
    struct map_fields fields =
        mesh_of((const double(*)[MESH_NAMES])strip.rows, count, strip.rules, strip.sources);
    fields.vertices = strip.vertices;
    fields.vertex_count = 2 * count + 2;
    fields.elements = (const int32_t(*)[4])strip.elements;
    return fields;
}

void small_strip_free(struct map_fields *fields) {
    (void)fields;
    free(strip.rows);
    free(strip.vertices);
    free(strip.elements);
}
