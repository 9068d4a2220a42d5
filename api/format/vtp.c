/* SPDX-License-Identifier: MIT */
/* VTK XML PolyData: the nodes as points, the cells as quadrilaterals, every other column as data of
 * one or the other. */
#include "api/result/quads.h"
#include "encoder.h"
#include "vtk_fields.h"
#include <string.h>

_Static_assert((int)ENCODER_PIECE >= (int)VTK_PIECE, "a piece has room for one of the file's");

enum kind { CONNECTIVITY = VTK_FIELDS_KINDS, OFFSETS };

struct state {
    struct vtk_file file;
    struct vtk_fields fields;
    struct api_column_source data[API_COLUMNS_MAX]; /* the columns but the coordinates */
    struct api_column_source point[3];
    struct quads quads;
};

static bool fill(void *context, const struct vtk_array *array, uint64_t first, size_t count,
                 void *bytes) {
    struct encoder *encoder = context;
    struct state *state = encoder->state;
    int32_t *offsets = bytes;
    if (array->kind < VTK_FIELDS_KINDS)
        return vtk_fields_fill(&state->fields, array, first, count, bytes);
    if (array->kind == CONNECTIVITY)
        return quads_next(&state->quads, count, bytes, NULL);
    for (size_t k = 0; k < count; k++)
        offsets[k] = (int32_t)(4 * (first + k + 1));
    return true;
}

/* ---- the list of arrays ---- */

static bool is_coordinate(const struct api_column_source *column) {
    return column->table == API_TABLE_NODES && strlen(column->name) == 1 &&
           strchr("xyz", column->name[0]);
}

/* The selected columns, which are sorted by table. */
static bool add_data(const struct encoder *encoder, struct state *state) {
    size_t end[2] = {0}, count = 0;
    for (size_t i = 0; i < encoder->count; i++) {
        const struct api_column_source *column = &encoder->selected[i];
        if (column->table == API_TABLE_FRONT || column->table == API_TABLE_RIM ||
            is_coordinate(column))
            continue;
        state->data[count++] = *column;
        end[column->table] = count;
    }
    const struct api_column_source *cells = state->data + end[0];
    size_t cell_count = count - end[0];
    return vtk_fields_add_all(&state->fields, &state->file, VTK_POINT_DATA, state->data, end[0]) &&
           vtk_fields_add_all(&state->fields, &state->file, VTK_CELL_DATA, cells, cell_count) &&
           vtk_fields_add_tensor(&state->fields, &state->file, cells, cell_count);
}

static bool add_points(struct encoder *encoder, struct state *state) {
    static const char *const names[] = {"x", "y", "z"};
    const struct api_column_source *point[3];
    for (int k = 0; k < 3; k++) {
        const struct api_column *column =
            api_columns_find(&encoder->columns, API_TABLE_NODES, names[k]);
        if (!column)
            return false;
        state->point[k] = encoder_source(encoder, column);
        point[k] = &state->point[k];
    }
    return vtk_fields_add(&state->fields, &state->file, VTK_POINTS, "Points", 3, point);
}

static bool add_topology(struct vtk_file *file) {
    return vtk_add(file, &(struct vtk_array){.section = VTK_TOPOLOGY,
                                             .type = VTK_INT32,
                                             .components = 4,
                                             .flat = true,
                                             .rows = file->cells,
                                             .name = "connectivity",
                                             .kind = CONNECTIVITY}) &&
           vtk_add(file, &(struct vtk_array){.section = VTK_TOPOLOGY,
                                             .type = VTK_INT32,
                                             .components = 1,
                                             .rows = file->cells,
                                             .name = "offsets",
                                             .kind = OFFSETS});
}

static bool begin(struct encoder *encoder, struct api_problem *problem) {
    struct state *state = encoder->state;
    struct vtk_file *file = &state->file;
    *file = (struct vtk_file){.polydata = true,
                              .points = api_columns_rows(&encoder->columns, API_TABLE_NODES),
                              .cells = api_columns_rows(&encoder->columns, API_TABLE_CELLS),
                              .fill = fill,
                              .context = encoder};
    if (!quads_begin(&state->quads, encoder->reader, &encoder->columns) ||
        file->cells > INT32_MAX / 4 || !add_data(encoder, state) || !add_points(encoder, state) ||
        !add_topology(file))
        return encoder_damaged(problem);
    encoder->length = vtk_length(file);
    return true;
}

static void next(struct encoder *encoder) {
    struct state *state = encoder->state;
    if (!vtk_next(&state->file, &encoder->piece, &encoder->ended))
        encoder->failed = true;
}

const struct format format_vtp = {.name = "vtp",
                                  .media_type = "application/vnd.vtk",
                                  .about = "VTK PolyData: the net with its fields, for ParaView",
                                  .exact = "every bit",
                                  .uses = FORMAT_RESULT,
                                  .state_size = sizeof(struct state),
                                  .begin = begin,
                                  .next = next};
