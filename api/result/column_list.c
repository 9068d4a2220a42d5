/* SPDX-License-Identifier: MIT */
#include "column_list.h"

#include <string.h>

const char *const column_tables[API_TABLE_COUNT] = {"nodes", "cells",    "front",  "rim",
                                                    "cuts",  "cut",      "plies",  "variants",
                                                    "bands", "proposed", "courses"};

const char *const column_kind_names[COLUMN_KINDS] = {"scalar",  "vector", "tensor", "integer",
                                                     "flag",    "truth",  "reason", "positive",
                                                     "failure", "name"};

const char *const column_need_names[COLUMN_NEEDS] = {
    [COLUMN_ALWAYS] = "",
    [COLUMN_ESTIMATE] = "method `gib4`",
    [COLUMN_FACES] = "several faces",
    [COLUMN_THICKNESS] = "`fabric.thickness` t₀, `plies` n; or `cavity.height`",
    [COLUMN_FRACTION] = "`fabric.fiber_volume_fraction` Vf₀; rigid: `fabric.thickness` too",
    [COLUMN_LOCKING] = "`fabric.locking_angle_deg`",
    [COLUMN_LIMIT] = "`fabric.limit_curve`",
    [COLUMN_PERMEABILITY] = "`permeability`",
    [COLUMN_TABLE] = "`permeability` by `table`",
    [COLUMN_CUTS] = "`cuts`",
    [COLUMN_JUDGED] = "an objective or a limit",
    [COLUMN_MAP] = "a map",
    [COLUMN_MAP_PERMEABILITY] = "a map, `permeability`",
    [COLUMN_MAP_PROPERTY] = "a map, Nastran",
    [COLUMN_MAP_ROLE] = "a map, `inlet`, `outlet` or `edge_channel`",
    [COLUMN_LAMINATE] = "a map of a laminate",
    [COLUMN_COMPACTION] = "a map of a laminate, `compaction`, `cavity`",
};

#define PARTS_SCALAR(stem) .parts = 1, .part = {stem}
#define PARTS_VECTOR(stem) .parts = 3, .part = {stem "_x", stem "_y", stem "_z"}
#define PARTS_TENSOR(stem)                                                                         \
    .parts = 6, .part = {stem "xx", stem "yy", stem "zz", stem "xy", stem "yz", stem "xz"}
#define PARTS_INTEGER PARTS_SCALAR
#define PARTS_FLAG PARTS_SCALAR
#define PARTS_TRUTH PARTS_SCALAR
#define PARTS_REASON PARTS_SCALAR
#define PARTS_POSITIVE PARTS_SCALAR
#define PARTS_FAILURE PARTS_SCALAR
#define PARTS_NAME PARTS_SCALAR

#define SPEC(TABLE, field, stem, KIND, units, NEED, text)                                          \
    {.table = API_TABLE_##TABLE,                                                                   \
     .kind = COLUMN_##KIND,                                                                        \
     .need = COLUMN_##NEED,                                                                        \
     .name = #field,                                                                               \
     .unit = units,                                                                                \
     .meaning = text,                                                                              \
     PARTS_##KIND(#stem)},

const struct column_spec column_specs[COLUMN_COUNT] = {COLUMN_LIST(SPEC)};

const struct column_spec *column_spec_find(enum api_table table, const char *name) {
    for (int id = 0; id < COLUMN_COUNT; id++) {
        const struct column_spec *spec = &column_specs[id];
        for (int k = 0; spec->table == table && k < spec->parts; k++)
            if (strcmp(spec->part[k], name) == 0)
                return spec;
    }
    return NULL;
}

size_t column_part_names(const enum column_id *ids, size_t count, const char **names) {
    size_t total = 0;
    for (size_t k = 0; k < count; k++)
        for (int part = 0; part < column_specs[ids[k]].parts; part++)
            names[total++] = column_specs[ids[k]].part[part];
    return total;
}

bool column_kind_is_integer(enum column_kind kind) {
    return kind == COLUMN_INTEGER || kind == COLUMN_FLAG || kind == COLUMN_TRUTH ||
           kind == COLUMN_REASON || kind == COLUMN_FAILURE || kind == COLUMN_NAME;
}
