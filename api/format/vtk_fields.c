/* SPDX-License-Identifier: MIT */
#include "vtk_fields.h"

#include "encoder.h"
#include <string.h>

static bool add(struct vtk_fields *fields, struct vtk_file *file, const struct vtk_array *array,
                const struct api_column_source *const *columns, size_t count) {
    if (fields->count == VTK_ARRAYS_MAX)
        return false;
    struct vtk_array own = *array;
    own.rows = columns[0]->rows;
    own.source = (int)fields->count;
    memcpy(fields->field[fields->count++].column, columns, count * sizeof *columns);
    return vtk_add(file, &own);
}

bool vtk_fields_add(struct vtk_fields *fields, struct vtk_file *file, enum vtk_section section,
                    const char *name, int components,
                    const struct api_column_source *const *columns) {
    bool integer = columns[0]->integer && components == 1;
    struct vtk_array array = {.section = section,
                              .type = integer ? VTK_INT64 : VTK_FLOAT64,
                              .components = components,
                              .kind = VTK_FIELDS_DATA};
    strncpy(array.name, name, VTK_NAME_SIZE - 1);
    return add(fields, file, &array, columns, (size_t)components);
}

bool vtk_fields_add_all(struct vtk_fields *fields, struct vtk_file *file, enum vtk_section section,
                        const struct api_column_source *columns, size_t count) {
    struct fieldset_field field;
    for (size_t k = 0; k < count; k += (size_t)field.components) {
        const struct api_column_source *parts[COLUMN_PARTS_MAX];
        field = fieldset_first(columns + k, count - k);
        if (columns[k].table == API_TABLE_PLIES)
            continue;
        for (int c = 0; c < field.components; c++)
            parts[c] = &columns[k + (size_t)c];
        if (!vtk_fields_add(fields, file, section, field.name, field.components, parts))
            return false;
    }
    return true;
}

bool vtk_fields_add_tensor(struct vtk_fields *fields, struct vtk_file *file,
                           const struct api_column_source *columns, size_t count) {
    const struct api_column_source *column[FIELDSET_TENSOR_COLUMNS];
    const struct column_spec *tensor = &column_specs[COLUMN_CELLS_permeability];
    const char *names[FIELDSET_TENSOR_COLUMNS];
    if (encoder_find(columns, count, tensor->table, tensor->part[0]))
        return true;
    fieldset_tensor_names(names);
    for (int k = 0; k < FIELDSET_TENSOR_COLUMNS; k++) {
        column[k] = encoder_find(columns, count, API_TABLE_CELLS, names[k]);
        if (!column[k])
            return true;
    }
    struct vtk_array array = {.section = VTK_CELL_DATA,
                              .type = VTK_FLOAT64,
                              .components = tensor->parts,
                              .kind = VTK_FIELDS_TENSOR};
    strncpy(array.name, tensor->name, VTK_NAME_SIZE - 1);
    return add(fields, file, &array, column, FIELDSET_TENSOR_COLUMNS);
}

/* ---- values ---- */

/* The columns of a field side by side. */
static bool fill_rows(struct vtk_fields *fields, const struct api_column_source *const *column,
                      size_t components, uint64_t first, size_t count, double *rows) {
    for (size_t k = 0; k < components; k++) {
        if (!column[k]->fill(column[k]->context, (size_t)first, count, fields->values))
            return false;
        for (size_t row = 0; row < count; row++)
            rows[row * components + k] = fields->values[row];
    }
    return true;
}

static bool fill_integers(struct vtk_fields *fields, const struct api_column_source *column,
                          uint64_t first, size_t count, int64_t *integers) {
    if (!column->fill(column->context, (size_t)first, count, fields->values))
        return false;
    for (size_t row = 0; row < count; row++)
        integers[row] = (int64_t)fields->values[row];
    return true;
}

static bool fill_tensors(struct vtk_fields *fields, const struct api_column_source *const *column,
                         uint64_t first, size_t count, double *tensors) {
    if (!fill_rows(fields, column, FIELDSET_TENSOR_COLUMNS, first, count, fields->rows))
        return false;
    for (size_t row = 0; row < count; row++)
        fieldset_tensor(fields->rows + row * FIELDSET_TENSOR_COLUMNS, tensors + 6 * row);
    return true;
}

bool vtk_fields_fill(struct vtk_fields *fields, const struct vtk_array *array, uint64_t first,
                     size_t count, void *bytes) {
    const struct api_column_source *const *column = fields->field[array->source].column;
    if (array->kind == VTK_FIELDS_TENSOR)
        return fill_tensors(fields, column, first, count, bytes);
    if (array->type == VTK_INT64)
        return fill_integers(fields, column[0], first, count, bytes);
    return fill_rows(fields, column, (size_t)array->components, first, count, bytes);
}
