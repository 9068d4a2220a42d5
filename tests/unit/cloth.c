/* SPDX-License-Identifier: MIT */
#include "cloth.h"

#include "tests/check.h"
#include <stdlib.h>
#include <string.h>

/* ---- nets ---- */

static bool kept(bool (*keep)(int, int), int n, int m, int i, int j) {
    return i >= 0 && j >= 0 && i < n && j < m && (!keep || keep(i, j));
}

static void add_yarns(struct cloth *cloth, size_t cell) {
    const int32_t *c = cloth->corners[cell];
    const struct vec3 *r = cloth->nodes;
    double *fields = cloth->fields[cell];
    struct vec3 warp = vec3_unit(vec3_sub(vec3_add(r[c[1]], r[c[2]]), vec3_add(r[c[0]], r[c[3]])));
    struct vec3 weft = vec3_unit(vec3_sub(vec3_add(r[c[2]], r[c[3]]), vec3_add(r[c[0]], r[c[1]])));
    memcpy(fields + CLOTH_WARP, &warp, sizeof warp);
    memcpy(fields + CLOTH_WEFT, &weft, sizeof weft);
    fields[CLOTH_I] = cloth->places[cell][0];
    fields[CLOTH_J] = cloth->places[cell][1];
}

struct cloth cloth_make(int n, int m, struct vec3 (*at)(double i, double j),
                        bool (*keep)(int i, int j)) {
    size_t most = (size_t)(n + 1) * (size_t)(m + 1);
    struct cloth cloth = {.nodes = calloc(most, sizeof *cloth.nodes),
                          .node_places = calloc(most, sizeof *cloth.node_places),
                          .corners = calloc(most, sizeof *cloth.corners),
                          .places = calloc(most, sizeof *cloth.places),
                          .fields = calloc(most, sizeof *cloth.fields)};
    int32_t *number = calloc(most, sizeof *number);
    for (int j = 0; j <= m; j++) {
        for (int i = 0; i <= n; i++) {
            if (!kept(keep, n, m, i, j) && !kept(keep, n, m, i - 1, j) &&
                !kept(keep, n, m, i, j - 1) && !kept(keep, n, m, i - 1, j - 1))
                continue;
            size_t node = cloth.node_count++;
            number[i + (n + 1) * j] = (int32_t)node;
            cloth.nodes[node] = at(i, j);
            cloth.node_places[node][0] = i;
            cloth.node_places[node][1] = j;
        }
    }
    for (int j = 0; j < m; j++) {
        for (int i = 0; i < n; i++) {
            if (!kept(keep, n, m, i, j))
                continue;
            size_t cell = cloth.cell_count++;
            const int32_t *corner = number + i + (n + 1) * j;
            memcpy(cloth.corners[cell],
                   (int32_t[]){corner[0], corner[1], corner[n + 2], corner[n + 1]},
                   sizeof *cloth.corners);
            cloth.places[cell][0] = i;
            cloth.places[cell][1] = j;
            add_yarns(&cloth, cell);
        }
    }
    free(number);
    return cloth;
}

void cloth_free(struct cloth *cloth) {
    free(cloth->nodes);
    free(cloth->node_places);
    free(cloth->corners);
    free(cloth->places);
    free(cloth->fields);
}

struct facets_source cloth_source(const struct cloth *cloth) {
    return (struct facets_source){.nodes = cloth->nodes,
                                  .node_count = cloth->node_count,
                                  .corners = (const int32_t(*)[4])cloth->corners,
                                  .places = (const int32_t(*)[2])cloth->places,
                                  .cell_count = cloth->cell_count};
}

struct vec3 cloth_middle(const struct cloth *cloth, size_t cell) {
    struct vec3 sum = {0, 0, 0};
    for (int k = 0; k < 4; k++)
        sum = vec3_add(sum, cloth->nodes[cloth->corners[cell][k]]);
    return vec3_scale(0.25, sum);
}

/* ---- containers ---- */

struct rule {
    const struct cloth *cloth;
    int column;
};

static bool fill_node(const void *context, size_t first, size_t count, double *values) {
    const struct rule *rule = context;
    const struct cloth *cloth = rule->cloth;
    for (size_t k = 0; k < count; k++) {
        const struct vec3 r = cloth->nodes[first + k];
        const double row[] = {cloth->node_places[first + k][0], cloth->node_places[first + k][1],
                              r.x, r.y, r.z};
        values[k] = row[rule->column];
    }
    return true;
}

static bool fill_cell(const void *context, size_t first, size_t count, double *values) {
    const struct rule *rule = context;
    for (size_t k = 0; k < count; k++)
        values[k] = rule->cloth->fields[first + k][rule->column];
    return true;
}

struct bytes cloth_result(const struct cloth *cloth) {
    static const char *const node_names[] = {"i", "j", "x", "y", "z"};
    static const char *const cell_names[CLOTH_FIELDS] = {
        "i",      "j",  "shear_deg", "thickness", "warp_x", "warp_y", "warp_z", "weft_x", "weft_y",
        "weft_z", "k1", "k2",        "k3",        "k1_x",   "k1_y",   "k1_z",   "locked"};
    enum { NODE_NAMES = sizeof node_names / sizeof *node_names };
    struct rule rules[NODE_NAMES + CLOTH_FIELDS];
    struct api_column_source sources[NODE_NAMES + CLOTH_FIELDS];
    for (int k = 0; k < NODE_NAMES + CLOTH_FIELDS; k++) {
        bool node = k < NODE_NAMES;
        int column = node ? k : k - NODE_NAMES;
        rules[k] = (struct rule){cloth, column};
        sources[k] =
            (struct api_column_source){.table = node ? API_TABLE_NODES : API_TABLE_CELLS,
                                       .name = node ? node_names[column] : cell_names[column],
                                       .integer = column < 2 || (!node && column == CLOTH_LOCKED),
                                       .rows = node ? cloth->node_count : cloth->cell_count,
                                       .fill = node ? fill_node : fill_cell,
                                       .context = &rules[k]};
    }
    struct api_columns header = {.summary = {.nodes = cloth->node_count,
                                             .cells = cloth->cell_count,
                                             .error_estimate_max = -1,
                                             .max_shear_error_deg = -1,
                                             .thickness_error_max = -1,
                                             .solver_version = "0"},
                                 .grid = {.spacing = {1, 1}}};
    struct bytes bytes = {0};
    struct api_problem problem = {0};
    struct api_sink sink = sink_into(&bytes);
    struct arena *arena = arena_new((size_t)1 << 24);
    assert_int_equal(
        api_columns_write(&header, sources, NODE_NAMES + CLOTH_FIELDS, &sink, arena, &problem),
        API_OK);
    arena_free(arena);
    return bytes;
}
