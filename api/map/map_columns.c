/* SPDX-License-Identifier: MIT */
#include "map_columns.h"

#include "api/result/fields.h"
#include <stdarg.h>
#include <stdio.h>

/* Numbers of elements as a file has them; without one from 0. */
static bool fill_ids(const void *context, size_t first, size_t count, double *values) {
    const int32_t *ids = context;
    for (size_t k = 0; k < count; k++)
        values[k] = ids ? ids[first + k] : (double)(first + k);
    return true;
}

static void add_column(struct api_map *map, const char *name, bool integer,
                       bool (*fill)(const void *, size_t, size_t, double *), const void *context) {
    map->columns[map->fields.column_count++] =
        (struct api_column_source){.table = API_TABLE_CELLS,
                                   .name = name,
                                   .integer = integer,
                                   .rows = map->fields.element_count,
                                   .fill = fill,
                                   .context = context};
}

double *map_columns_add(struct api_map *map, const char *name, bool integer, double *values) {
    add_column(map, name, integer, api_fields_copy, values);
    return values;
}

double *map_columns_new(struct api_map *map, enum column_id id, int part, struct arena *arena) {
    const struct column_spec *spec = &column_specs[id];
    return map_columns_add(map, spec->part[part], column_kind_is_integer(spec->kind),
                           arena_alloc(arena, map->fields.element_count, sizeof(double)));
}

/* What each element is to the flow, enum map_role. */
static bool fill_roles(const void *context, size_t first, size_t count, double *values) {
    const uint8_t *roles = context;
    for (size_t k = 0; k < count; k++)
        values[k] = roles[first + k];
    return true;
}

void map_columns_ids(struct api_map *map, const struct map_target *target) {
    add_column(map, column_specs[COLUMN_CELLS_id].name, true, fill_ids, target->ids);
    if (target->pids)
        add_column(map, column_specs[COLUMN_CELLS_pid].name, true, fill_ids, target->pids);
    if (target->roles)
        add_column(map, column_specs[COLUMN_CELLS_role].name, true, fill_roles, target->roles);
}

void map_warn_text(struct api_map *map, const char *text) {
    if (map->fields.warning_count < MAP_WARNINGS_MAX)
        map->fields.warnings[map->fields.warning_count++] = text;
}

void map_warn(struct api_map *map, const char *format, ...) {
    if (map->fields.warning_count == MAP_WARNINGS_MAX)
        return;
    char *text = map->warning[map->fields.warning_count];
    va_list values;
    va_start(values, format);
    (void)vsnprintf(text, API_MAP_WARNING_SIZE, format, values);
    va_end(values);
    map_warn_text(map, text);
}
