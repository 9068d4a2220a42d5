/* SPDX-License-Identifier: MIT */
#include "vtk.h"

#include "stack.h"
#include <endian.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

_Static_assert((int)ENCODER_PIECE >= (int)VTK_PIECE, "a piece has room for one of the file's");

static const struct {
    const char *name;
    size_t size;
} types[] = {[VTK_FLOAT64] = {"Float64", 8},
             [VTK_INT64] = {"Int64", 8},
             [VTK_INT32] = {"Int32", 4},
             [VTK_UINT8] = {"UInt8", 1}};

static const char tail[] = "\n  </AppendedData>\n</VTKFile>\n";

enum { LENGTH = 8 }; /* bytes before the values of each array */

/* Of a ply, by column; its arrays have ply * PLY_FIELDS + field for their source. */
static const struct {
    enum column_id column;
    const char *name;
} ply_fields[] = {{COLUMN_PLIES_angle_deg, "angle"},
                  {COLUMN_PLIES_shear_deg, "shear"},
                  {COLUMN_PLIES_thickness, "thickness"},
                  {COLUMN_PLIES_fiber_volume_fraction, "fiber_volume_fraction"}};
enum { PLY_FIELDS = sizeof ply_fields / sizeof *ply_fields };

/* ---- the list of arrays ---- */

bool vtk_add(struct vtk_file *file, const struct vtk_array *array) {
    if (file->count == VTK_ARRAYS_MAX)
        return false;
    file->array[file->count++] = *array;
    return true;
}

bool vtk_add_columns(struct vtk_file *file, enum vtk_section section, const char *name,
                     int components, const struct api_column_source *const *columns) {
    bool integer = columns[0]->integer && components == 1;
    struct vtk_array array = {.section = section,
                              .type = integer ? VTK_INT64 : VTK_FLOAT64,
                              .components = components,
                              .rows = columns[0]->rows,
                              .kind = VTK_COLUMNS};
    strncpy(array.name, name, VTK_NAME_SIZE - 1);
    memcpy(array.column, columns, (size_t)components * sizeof *columns);
    return vtk_add(file, &array);
}

bool vtk_add_fields(struct vtk_file *file, enum vtk_section section,
                    const struct api_column_source *columns, size_t count) {
    struct fieldset_field field;
    for (size_t k = 0; k < count; k += (size_t)field.components) {
        const struct api_column_source *column[COLUMN_PARTS_MAX];
        field = fieldset_first(columns + k, count - k);
        for (int c = 0; c < field.components; c++)
            column[c] = &columns[k + (size_t)c];
        if (columns[k].table != API_TABLE_PLIES &&
            !vtk_add_columns(file, section, field.name, field.components, column))
            return false;
    }
    return true;
}

bool vtk_add_tensor(struct vtk_file *file, const struct api_column_source *columns, size_t count) {
    const struct column_spec *tensor = &column_specs[COLUMN_CELLS_permeability];
    const char *names[FIELDSET_TENSOR_COLUMNS];
    struct vtk_array array = {.section = VTK_CELL_DATA,
                              .type = VTK_FLOAT64,
                              .components = tensor->parts,
                              .kind = VTK_TENSOR};
    if (encoder_find(columns, count, tensor->table, tensor->part[0]))
        return true;
    fieldset_tensor_names(names);
    for (int k = 0; k < FIELDSET_TENSOR_COLUMNS; k++) {
        array.column[k] = encoder_find(columns, count, API_TABLE_CELLS, names[k]);
        if (!array.column[k])
            return true;
    }
    array.rows = array.column[0]->rows;
    strncpy(array.name, tensor->name, VTK_NAME_SIZE - 1);
    return vtk_add(file, &array);
}

bool vtk_add_elements(struct vtk_file *file, const struct map_fields *fields) {
    bool room = vtk_add_fields(file, VTK_CELL_DATA, fields->columns, fields->column_count) &&
                vtk_add_tensor(file, fields->columns, fields->column_count);
    for (int f = 0; fields->plies && f < PLY_FIELDS; f++) {
        const struct column_spec *spec = &column_specs[ply_fields[f].column];
        if (!encoder_find(fields->columns, fields->column_count, spec->table, spec->name))
            continue;
        for (size_t ply = 0; ply < fields->plies->ply_count && room; ply++) {
            struct vtk_array array = {.section = VTK_CELL_DATA,
                                      .type = VTK_FLOAT64,
                                      .components = 1,
                                      .rows = fields->element_count,
                                      .kind = VTK_PLY,
                                      .source = (int)ply * PLY_FIELDS + f};
            snprintf(array.name, sizeof array.name, "%s_%zu", ply_fields[f].name, ply + 1);
            room = vtk_add(file, &array);
        }
    }
    return room;
}

/* ---- the description ---- */

static size_t row_size(const struct vtk_array *array) {
    return types[array->type].size * (size_t)array->components;
}

static uint64_t array_size(const struct vtk_array *array) {
    return array->rows * row_size(array);
}

static void describe_file(struct api_text *text, const struct vtk_file *file) {
    const char *dataset = file->polydata ? "PolyData" : "UnstructuredGrid";
    const char *const names[VTK_SECTIONS] = {"PointData", "CellData", "Points",
                                             file->polydata ? "Polys" : "Cells"};
    api_text_format(
        text,
        "<?xml version=\"1.0\"?>\n%s%s%s<VTKFile type=\"%s\" version=\"1.0\" "
        "byte_order=\"LittleEndian\" header_type=\"UInt64\">\n  <%s>\n    <Piece "
        "NumberOfPoints=\"%llu\"%s NumberOf%s=\"%llu\">\n",
        file->revision ? "<!-- revision " : "", file->revision ? file->revision : "",
        file->revision ? " -->\n" : "", dataset, dataset, (unsigned long long)file->points,
        file->polydata ? " NumberOfVerts=\"0\" NumberOfLines=\"0\" NumberOfStrips=\"0\"" : "",
        file->polydata ? "Polys" : "Cells", (unsigned long long)file->cells);
    for (int section = 0; section < VTK_SECTIONS; section++) {
        uint64_t offset = 0;
        api_text_format(text, "      <%s>\n", names[section]);
        for (size_t k = 0; k < file->count; k++) {
            const struct vtk_array *array = &file->array[k];
            if ((int)array->section == section)
                api_text_format(text,
                                "        <DataArray type=\"%s\" Name=\"%s\" "
                                "NumberOfComponents=\"%d\" format=\"appended\" "
                                "offset=\"%llu\"/>\n",
                                types[array->type].name, array->name,
                                array->flat ? 1 : array->components, (unsigned long long)offset);
            offset += LENGTH + array_size(array);
        }
        api_text_format(text, "      </%s>\n", names[section]);
    }
    api_text_format(text, "    </Piece>\n  </%s>\n  <AppendedData encoding=\"raw\">\n_", dataset);
}

void vtk_begin(struct encoder *encoder) {
    const struct vtk_file *file = encoder->state;
    struct api_text text = api_text_over(encoder->buffer, sizeof encoder->buffer);
    describe_file(&text, file);
    encoder->length = text.length + strlen(tail);
    for (size_t k = 0; k < file->count; k++)
        encoder->length += LENGTH + array_size(&file->array[k]);
}

/* ---- the values ---- */

/* The values of columns, side by side; the encoder's `values` hold one of them at a time. */
static bool fill_columns(struct encoder *encoder, const struct vtk_array *array, size_t first,
                         size_t count, void *bytes) {
    struct vtk_file *file = encoder->state;
    int64_t *integers = bytes;
    double *rows = array->kind == VTK_TENSOR ? file->rows : bytes;
    size_t width = array->kind == VTK_TENSOR ? FIELDSET_TENSOR_COLUMNS : (size_t)array->components;
    for (size_t k = 0; k < width; k++) {
        const struct api_column_source *column = array->column[k];
        if (!column->fill(column->context, first, count, encoder->values))
            return false;
        for (size_t row = 0; row < count && array->type == VTK_INT64; row++)
            integers[row] = (int64_t)encoder->values[row];
        for (size_t row = 0; row < count && array->type != VTK_INT64; row++)
            rows[row * width + k] = encoder->values[row];
    }
    for (size_t row = 0; row < count && array->kind == VTK_TENSOR; row++)
        fieldset_tensor(rows + row * width, (double *)bytes + 6 * row);
    return true;
}

static void fill_ply(const struct encoder *encoder, const struct vtk_array *array, size_t first,
                     size_t count, double *values) {
    int ply = array->source / PLY_FIELDS;
    enum column_id column = ply_fields[array->source % PLY_FIELDS].column;
    for (size_t k = 0; k < count; k++) {
        const struct map_ply_row *row = stack_row(&encoder->fields, first + k, ply);
        values[k] = !row                               ? (double)NAN
                    : column == COLUMN_PLIES_angle_deg ? row->angle_deg
                    : column == COLUMN_PLIES_shear_deg ? row->shear_deg
                    : column == COLUMN_PLIES_thickness ? row->thickness
                                                       : row->fiber_volume_fraction;
    }
}

bool vtk_fill(struct encoder *encoder, const struct vtk_array *array, uint64_t first, size_t count,
              void *bytes) {
    struct vtk_file *file = encoder->state;
    if (array->kind == VTK_PLY) {
        fill_ply(encoder, array, (size_t)first, count, bytes);
        return true;
    }
    return array->kind < VTK_OWN_KINDS ? fill_columns(encoder, array, (size_t)first, count, bytes)
                                       : file->fill(encoder, array, first, count, bytes);
}

/* The description, then a block of an array at a time, then the tail. */
void vtk_next(struct encoder *encoder) {
    _Alignas(8) unsigned char block[VTK_BLOCK];
    struct vtk_file *file = encoder->state;
    if (!encoder->begun) {
        describe_file(&encoder->piece, file);
        encoder->begun = true;
        return;
    }
    if (file->at == file->count) {
        api_text_raw(&encoder->piece, tail);
        encoder->ended = true;
        return;
    }
    const struct vtk_array *array = &file->array[file->at];
    uint64_t size = htole64(array_size(array)), left = array->rows - file->row;
    size_t most = VTK_BLOCK / row_size(array), count = left < most ? (size_t)left : most;
    if (file->row == 0)
        api_text_bytes(&encoder->piece, &size, sizeof size);
    if (count > 0) {
        encoder->failed = !vtk_fill(encoder, array, file->row, count, block);
        if (encoder->failed)
            return;
        size_t length = count * row_size(array), width = types[array->type].size;
        for (unsigned char *value = block;
             __BYTE_ORDER != __LITTLE_ENDIAN && value < block + length; value += width)
            for (size_t k = 0; k < width / 2; k++) {
                unsigned char byte = value[k];
                value[k] = value[width - 1 - k];
                value[width - 1 - k] = byte;
            }
        api_text_bytes(&encoder->piece, block, length);
    }
    file->row += count;
    if (file->row == array->rows) {
        file->row = 0;
        file->at++;
    }
}
