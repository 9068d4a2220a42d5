/* SPDX-License-Identifier: MIT */
#include "vtk.h"

#include <endian.h>
#include <string.h>

static const struct {
    const char *name;
    size_t size;
} types[] = {[VTK_FLOAT64] = {"Float64", 8},
             [VTK_INT64] = {"Int64", 8},
             [VTK_INT32] = {"Int32", 4},
             [VTK_UINT8] = {"UInt8", 1}};

static const char tail[] = "\n  </AppendedData>\n</VTKFile>\n";

enum { LENGTH = 8 }; /* bytes before the values of each array */

bool vtk_add(struct vtk_file *file, const struct vtk_array *array) {
    if (file->count == VTK_ARRAYS_MAX)
        return false;
    file->array[file->count++] = *array;
    return true;
}

static size_t row_size(const struct vtk_array *array) {
    return types[array->type].size * (size_t)array->components;
}

static uint64_t array_size(const struct vtk_array *array) {
    return array->rows * row_size(array);
}

/* ---- the description ---- */

static void attribute(struct api_text *text, const char *name, uint64_t value) {
    api_text_raw(text, " ");
    api_text_raw(text, name);
    api_text_raw(text, "=\"");
    api_text_integer(text, (int64_t)value);
    api_text_raw(text, "\"");
}

static void describe_array(struct api_text *text, const struct vtk_array *array, uint64_t offset) {
    api_text_raw(text, "        <DataArray type=\"");
    api_text_raw(text, types[array->type].name);
    api_text_raw(text, "\" Name=\"");
    api_text_raw(text, array->name);
    api_text_raw(text, "\"");
    attribute(text, "NumberOfComponents", array->flat ? 1 : (uint64_t)array->components);
    api_text_raw(text, " format=\"appended\"");
    attribute(text, "offset", offset);
    api_text_raw(text, "/>\n");
}

static void describe_section(struct api_text *text, const struct vtk_file *file,
                             enum vtk_section section) {
    const char *const names[VTK_SECTIONS] = {"PointData", "CellData", "Points",
                                             file->polydata ? "Polys" : "Cells"};
    uint64_t offset = 0;
    api_text_raw(text, "      <");
    api_text_raw(text, names[section]);
    api_text_raw(text, ">\n");
    for (size_t k = 0; k < file->count; k++) {
        if (file->array[k].section == section)
            describe_array(text, &file->array[k], offset);
        offset += LENGTH + array_size(&file->array[k]);
    }
    api_text_raw(text, "      </");
    api_text_raw(text, names[section]);
    api_text_raw(text, ">\n");
}

static void describe(struct api_text *text, const struct vtk_file *file) {
    const char *dataset = file->polydata ? "PolyData" : "UnstructuredGrid";
    api_text_raw(text, "<?xml version=\"1.0\"?>\n<VTKFile type=\"");
    api_text_raw(text, dataset);
    api_text_raw(text,
                 "\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n  <");
    api_text_raw(text, dataset);
    api_text_raw(text, ">\n    <Piece");
    attribute(text, "NumberOfPoints", file->points);
    if (file->polydata)
        api_text_raw(text, " NumberOfVerts=\"0\" NumberOfLines=\"0\" NumberOfStrips=\"0\"");
    attribute(text, file->polydata ? "NumberOfPolys" : "NumberOfCells", file->cells);
    api_text_raw(text, ">\n");
    for (int section = 0; section < VTK_SECTIONS; section++)
        describe_section(text, file, (enum vtk_section)section);
    api_text_raw(text, "    </Piece>\n  </");
    api_text_raw(text, dataset);
    api_text_raw(text, ">\n  <AppendedData encoding=\"raw\">\n_");
}

uint64_t vtk_length(const struct vtk_file *file) {
    char buffer[VTK_PIECE];
    struct api_text text = api_text_over(buffer, sizeof buffer);
    describe(&text, file);
    uint64_t length = text.length + strlen(tail);
    for (size_t k = 0; k < file->count; k++)
        length += LENGTH + array_size(&file->array[k]);
    return length;
}

/* ---- the values ---- */

/* From this machine's order of bytes to little-endian. */
static void order_bytes(unsigned char *bytes, size_t size, size_t count) {
    if (__BYTE_ORDER == __LITTLE_ENDIAN)
        return;
    for (unsigned char *value = bytes; value < bytes + size * count; value += size)
        for (size_t k = 0; k < size / 2; k++) {
            unsigned char byte = value[k];
            value[k] = value[size - 1 - k];
            value[size - 1 - k] = byte;
        }
}

static bool next_values(struct vtk_file *file, struct api_text *piece) {
    _Alignas(8) unsigned char block[VTK_BLOCK];
    const struct vtk_array *array = &file->array[file->at];
    uint64_t size = htole64(array_size(array)), left = array->rows - file->row;
    size_t most = VTK_BLOCK / row_size(array), count = left < most ? (size_t)left : most;
    if (file->row == 0)
        api_text_bytes(piece, &size, sizeof size);
    if (count > 0) {
        if (!file->fill(file->context, array, file->row, count, block))
            return false;
        order_bytes(block, types[array->type].size, count * (size_t)array->components);
        api_text_bytes(piece, block, count * row_size(array));
    }
    file->row += count;
    if (file->row == array->rows) {
        file->row = 0;
        file->at++;
    }
    return true;
}

bool vtk_next(struct vtk_file *file, struct api_text *piece, bool *ended) {
    bool good = true;
    if (!file->described) {
        describe(piece, file);
        file->described = true;
    } else if (file->at < file->count) {
        good = next_values(file, piece);
    } else {
        api_text_raw(piece, tail);
        *ended = true;
    }
    return good && !piece->failed;
}
