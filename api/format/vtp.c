/* SPDX-License-Identifier: MIT */
/* VTK XML PolyData: the nodes as points, the cells as quadrilaterals, every other column as data of
 * one or the other. */
#include "api/result/fieldset.h"
#include "api/result/quads.h"
#include "format.h"
#include "vtk.h"
#include <string.h>

_Static_assert((int)ENCODE_PIECE >= (int)VTK_PIECE, "a piece has room for one of the file's");

enum kind { DATA, TENSOR, CONNECTIVITY, OFFSETS };

enum { FIELDS_MAX = API_COLUMNS_MAX + 1, TENSOR_ROWS = 256 };

struct state {
    struct vtk_file file;
    struct quads quads;
    size_t count;
    struct {
        const struct api_column *column[FIELDSET_TENSOR_COLUMNS];
    } field[FIELDS_MAX];
};

/* ---- values ---- */

/* The columns of a field side by side. */
static bool fill_data(struct api_encoder *encoder, const struct api_column *const *column,
                      int components, uint64_t first, size_t count, void *bytes) {
    double *values = bytes;
    for (int k = 0; k < components; k++) {
        if (!api_columns_read(encoder->reader, column[k], (size_t)first, count, encoder->values))
            return false;
        for (size_t row = 0; row < count; row++)
            values[row * (size_t)components + (size_t)k] = encoder->values[row];
    }
    return true;
}

static bool fill_integers(struct api_encoder *encoder, const struct api_column *column,
                          uint64_t first, size_t count, void *bytes) {
    int64_t *values = bytes;
    if (!api_columns_read(encoder->reader, column, (size_t)first, count, encoder->values))
        return false;
    for (size_t row = 0; row < count; row++)
        values[row] = (int64_t)encoder->values[row];
    return true;
}

static bool fill_tensors(struct api_encoder *encoder, const struct api_column *const *column,
                         uint64_t first, size_t count, double *tensors) {
    double rows[TENSOR_ROWS * FIELDSET_TENSOR_COLUMNS];
    while (count > 0) {
        size_t part = count < TENSOR_ROWS ? count : TENSOR_ROWS;
        if (!fill_data(encoder, column, FIELDSET_TENSOR_COLUMNS, first, part, rows))
            return false;
        for (size_t row = 0; row < part; row++, tensors += 6)
            fieldset_tensor(rows + row * FIELDSET_TENSOR_COLUMNS, tensors);
        first += part;
        count -= part;
    }
    return true;
}

static bool fill(void *context, const struct vtk_array *array, uint64_t first, size_t count,
                 void *bytes) {
    struct api_encoder *encoder = context;
    struct state *state = encoder->state;
    const struct api_column *const *column = state->field[array->source].column;
    int32_t *offsets = bytes;
    switch ((enum kind)array->kind) {
    case DATA:
        return array->type == VTK_INT64
                   ? fill_integers(encoder, column[0], first, count, bytes)
                   : fill_data(encoder, column, array->components, first, count, bytes);
    case TENSOR:
        return fill_tensors(encoder, column, first, count, bytes);
    case CONNECTIVITY:
        return quads_next(&state->quads, count, bytes, NULL);
    case OFFSETS:
        for (size_t k = 0; k < count; k++)
            offsets[k] = (int32_t)(4 * (first + k + 1));
        break;
    }
    return true;
}

/* ---- the list of arrays ---- */

static bool add_field(struct state *state, enum vtk_part part, const char *name, int components,
                      const struct api_column *const *column, enum kind kind) {
    struct vtk_array array = {.part = part,
                              .type =
                                  column[0]->integer && components == 1 ? VTK_INT64 : VTK_FLOAT64,
                              .components = components,
                              .rows = column[0]->rows,
                              .kind = kind,
                              .source = (int)state->count};
    size_t columns = kind == TENSOR ? FIELDSET_TENSOR_COLUMNS : (size_t)components;
    if (state->count == FIELDS_MAX)
        return false;
    strncpy(array.name, name, VTK_NAME_SIZE - 1);
    memcpy(state->field[state->count++].column, column, columns * sizeof *column);
    return vtk_add(&state->file, &array);
}

static bool is_coordinate(const struct api_column *column) {
    return column->table == API_TABLE_NODES && strlen(column->name) == 1 &&
           strchr("xyz", column->name[0]);
}

static bool add_table(const struct api_encoder *encoder, enum api_table table) {
    enum vtk_part part = table == API_TABLE_NODES ? VTK_POINT_DATA : VTK_CELL_DATA;
    const char *names[API_COLUMNS_MAX];
    const struct api_column *columns[API_COLUMNS_MAX];
    struct fieldset_field field;
    size_t count = 0;
    for (size_t i = 0; i < encoder->count; i++) {
        const struct api_column *column = encoder->selected[i];
        if (column->table != table || is_coordinate(column))
            continue;
        names[count] = column->name;
        columns[count++] = column;
    }
    for (size_t i = 0; i < count; i += (size_t)field.components) {
        fieldset_make(names, count, i, &field);
        if (!add_field(encoder->state, part, field.name, field.components, &columns[i], DATA))
            return false;
    }
    return true;
}

/* The permeability of the cells, when all that it follows from is there. */
static bool add_tensor(const struct api_encoder *encoder) {
    const struct api_column *column[FIELDSET_TENSOR_COLUMNS];
    for (int k = 0; k < FIELDSET_TENSOR_COLUMNS; k++) {
        column[k] = encode_selected(encoder, API_TABLE_CELLS, fieldset_tensor_columns[k]);
        if (!column[k])
            return true;
    }
    return add_field(encoder->state, VTK_CELL_DATA, "permeability", 6, column, TENSOR);
}

static bool add_points(const struct api_encoder *encoder) {
    static const char *const names[] = {"x", "y", "z"};
    const struct api_column *column[3];
    for (int k = 0; k < 3; k++) {
        column[k] = api_columns_find(&encoder->columns, API_TABLE_NODES, names[k]);
        if (!column[k])
            return false;
    }
    return add_field(encoder->state, VTK_POINTS, "Points", 3, column, DATA);
}

static bool add_topology(struct vtk_file *file) {
    return vtk_add(file, &(struct vtk_array){.part = VTK_TOPOLOGY,
                                             .type = VTK_INT32,
                                             .components = 4,
                                             .flat = true,
                                             .rows = file->cells,
                                             .name = "connectivity",
                                             .kind = CONNECTIVITY}) &&
           vtk_add(file, &(struct vtk_array){.part = VTK_TOPOLOGY,
                                             .type = VTK_INT32,
                                             .components = 1,
                                             .rows = file->cells,
                                             .name = "offsets",
                                             .kind = OFFSETS});
}

static bool begin(struct api_encoder *encoder, struct api_problem *problem) {
    struct state *state = encoder->state;
    struct vtk_file *file = &state->file;
    *file = (struct vtk_file){.polydata = true,
                              .points = api_columns_rows(&encoder->columns, API_TABLE_NODES),
                              .cells = api_columns_rows(&encoder->columns, API_TABLE_CELLS),
                              .fill = fill,
                              .context = encoder};
    if (!quads_begin(&state->quads, encoder->reader, &encoder->columns) ||
        file->cells > INT32_MAX / 4 || !add_table(encoder, API_TABLE_NODES) ||
        !add_table(encoder, API_TABLE_CELLS) || !add_tensor(encoder) || !add_points(encoder) ||
        !add_topology(file))
        return encode_damaged(problem);
    encoder->length = vtk_length(file);
    return true;
}

static void next(struct api_encoder *encoder) {
    struct state *state = encoder->state;
    if (!vtk_next(&state->file, &encoder->piece, &encoder->ended))
        encoder->failed = true;
}

const struct api_format encode_vtp = {.name = "vtp",
                                      .media_type = "application/vnd.vtk",
                                      .state_size = sizeof(struct state),
                                      .begin = begin,
                                      .next = next};
