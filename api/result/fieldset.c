/* SPDX-License-Identifier: MIT */
#include "fieldset.h"

#include "solver/vec.h"
#include <string.h>

struct fieldset_field fieldset_first(const struct api_column_source *columns, size_t count) {
    const struct column_spec *spec = column_spec_find(columns->table, columns->name);
    bool whole = spec && (size_t)spec->parts <= count;
    for (int k = 0; whole && k < spec->parts; k++)
        whole = columns[k].table == spec->table && strcmp(columns[k].name, spec->part[k]) == 0;
    return whole ? (struct fieldset_field){spec->name, spec->parts}
                 : (struct fieldset_field){columns->name, 1};
}

void fieldset_tensor_names(const char *names[FIELDSET_TENSOR_COLUMNS]) {
    static const enum column_id ids[] = {COLUMN_CELLS_k1,   COLUMN_CELLS_k2,
                                         COLUMN_CELLS_k3,   COLUMN_CELLS_k1_direction,
                                         COLUMN_CELLS_warp, COLUMN_CELLS_weft};
    column_part_names(ids, sizeof ids / sizeof *ids, names);
}

static void add_dyad(double tensor[6], double factor, struct vec3 a) {
    const double dyad[6] = {a.x * a.x, a.y * a.y, a.z * a.z, a.x * a.y, a.y * a.z, a.x * a.z};
    for (int k = 0; k < 6; k++)
        tensor[k] += factor * dyad[k];
}

void fieldset_tensor(const double v[FIELDSET_TENSOR_COLUMNS], double tensor[6]) {
    struct vec3 first = vec3_make(v[3], v[4], v[5]);
    struct vec3 warp = vec3_make(v[6], v[7], v[8]), weft = vec3_make(v[9], v[10], v[11]);
    struct vec3 normal = vec3_unit(vec3_cross(warp, weft));
    memset(tensor, 0, 6 * sizeof *tensor);
    add_dyad(tensor, v[0], first);
    add_dyad(tensor, v[1], vec3_cross(normal, first));
    add_dyad(tensor, v[2], normal);
}
