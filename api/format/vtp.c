/* SPDX-License-Identifier: MIT */
/* VTK XML PolyData: the nodes as points, the cells as quadrilaterals, every other column as data of
 * one or the other. */
#include "api/result/cell_corners.h"
#include "vtk.h"
#include <string.h>

enum kind { CONNECTIVITY = VTK_OWN_KINDS, OFFSETS };

struct state {
    struct vtk_file file;
    struct api_column_source data[API_COLUMNS_MAX]; /* the columns but the coordinates */
    struct api_column_source point[3];
    struct cell_corners quads;
};

static bool fill_topology(struct encoder *encoder, const struct vtk_array *array, uint64_t first,
                          size_t count, void *bytes) {
    struct state *state = encoder->state;
    int32_t *offsets = bytes;
    if (array->kind == CONNECTIVITY)
        return cell_corners_next(&state->quads, count, bytes, NULL);
    for (size_t k = 0; k < count; k++)
        offsets[k] = (int32_t)(4 * (first + k + 1));
    return true;
}

/* The selected columns, which are sorted by table, without coordinates; and the net. */
static bool begin_vtp(struct encoder *encoder, struct api_problem *problem) {
    static const char *const names[] = {"x", "y", "z"};
    struct state *state = encoder->state;
    struct vtk_file *file = &state->file;
    file->polydata = true;
    file->points = api_columns_rows(&encoder->columns, API_TABLE_NODES);
    file->cells = api_columns_rows(&encoder->columns, API_TABLE_CELLS);
    file->fill = fill_topology;
    if (!cell_corners_begin(&state->quads, encoder->reader, &encoder->columns) ||
        file->cells > INT32_MAX / 4)
        return encoder_damaged(problem);
    const struct api_column_source *point[3];
    struct vtk_array topology = {.section = VTK_TOPOLOGY,
                                 .type = VTK_INT32,
                                 .components = 4,
                                 .flat = true,
                                 .rows = file->cells,
                                 .name = "connectivity",
                                 .kind = CONNECTIVITY};
    size_t end[2] = {0}, count = 0;
    for (size_t i = 0; i < encoder->count; i++) {
        const struct api_column_source *column = &encoder->selected[i];
        bool coordinate = column->table == API_TABLE_NODES && strlen(column->name) == 1 &&
                          strchr("xyz", column->name[0]);
        if ((column->table != API_TABLE_NODES && column->table != API_TABLE_CELLS) || coordinate)
            continue;
        state->data[count++] = *column;
        end[column->table] = count;
    }
    for (int k = 0; k < 3; k++) {
        const struct api_column *column =
            api_columns_find(&encoder->columns, API_TABLE_NODES, names[k]);
        if (!column)
            return encoder_damaged(problem);
        state->point[k] = encoder_source(encoder, column);
        point[k] = &state->point[k];
    }
    const struct api_column_source *cells = state->data + end[0];
    if (!vtk_add_fields(file, VTK_POINT_DATA, state->data, end[0]) ||
        !vtk_add_fields(file, VTK_CELL_DATA, cells, count - end[0]) ||
        !vtk_add_tensor(file, cells, count - end[0]) ||
        !vtk_add_columns(file, VTK_POINTS, "Points", 3, point) || !vtk_add(file, &topology))
        return encoder_damaged(problem);
    topology.components = 1;
    topology.flat = false;
    topology.kind = OFFSETS;
    strcpy(topology.name, "offsets");
    if (!vtk_add(file, &topology))
        return encoder_damaged(problem);
    vtk_begin(encoder);
    return true;
}

const struct format format_vtp = {.name = "vtp",
                                  .media_type = "application/vnd.vtk",
                                  .about = "VTK PolyData: the net with its fields, for ParaView",
                                  .exact = "every bit",
                                  .uses = FORMAT_RESULT,
                                  .state_size = sizeof(struct state),
                                  .begin = begin_vtp,
                                  .next = vtk_next};
