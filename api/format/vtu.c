/* SPDX-License-Identifier: MIT */
/* VTK XML UnstructuredGrid: the caller's mesh with all columns as cell data. */
#include "api/result/fieldset.h"
#include "mesh_format.h"
#include "vtk.h"
#include <stdio.h>
#include <string.h>

_Static_assert((int)MESH_PIECE >= (int)VTK_PIECE, "a piece has room for one of the file's");

enum kind { DATA, TENSOR, POINTS, CONNECTIVITY, OFFSETS, TYPES };

/* VTK's numbers for shapes. */
enum { SHAPE_TRIANGLE = 5, SHAPE_QUAD = 9 };

enum { ROWS = VTK_BLOCK / 8 };

struct state {
    struct vtk_file file;
    size_t element; /* the next of the list that is being written */
    int corner;
    int32_t offset; /* behind it */
    double values[ROWS];
};

static int corners(const int32_t element[4]) {
    return element[3] < 0 ? 3 : 4;
}

/* ---- values ---- */

/* One component of rows that have `stride`. */
static void fill_component(struct state *state, const struct api_column_source *column,
                           uint64_t first, size_t count, double *values, size_t stride) {
    column->fill(column->context, (size_t)first, count, state->values);
    for (size_t row = 0; row < count; row++)
        values[row * stride] = state->values[row];
}

static void fill_integers(struct state *state, const struct api_column_source *column,
                          uint64_t first, size_t count, int64_t *values) {
    column->fill(column->context, (size_t)first, count, state->values);
    for (size_t row = 0; row < count; row++)
        values[row] = (int64_t)state->values[row];
}

static void fill_tensors(const struct api_mesh_fields *fields, uint64_t first, size_t count,
                         double *tensors) {
    const struct api_column_source *column[FIELDSET_TENSOR_COLUMNS];
    for (int k = 0; k < FIELDSET_TENSOR_COLUMNS; k++)
        column[k] = mesh_column(fields, fieldset_tensor_columns[k]);
    for (size_t row = 0; row < count; row++) {
        double values[FIELDSET_TENSOR_COLUMNS];
        for (int k = 0; k < FIELDSET_TENSOR_COLUMNS; k++)
            column[k]->fill(column[k]->context, (size_t)first + row, 1, &values[k]);
        fieldset_tensor(values, tensors + 6 * row);
    }
}

static void fill_points(const struct api_mesh_fields *fields, uint64_t first, size_t count,
                        double *values) {
    for (size_t k = 0; k < count; k++) {
        struct vec3 vertex = fields->vertices[first + k];
        memcpy(values + 3 * k, (const double[]){vertex.x, vertex.y, vertex.z}, 3 * sizeof(double));
    }
}

static void fill_connectivity(const struct api_mesh_fields *fields, struct state *state,
                              size_t count, int32_t *values) {
    for (size_t k = 0; k < count; k++) {
        const int32_t *element = fields->elements[state->element];
        values[k] = element[state->corner++];
        if (state->corner == corners(element)) {
            state->corner = 0;
            state->element++;
        }
    }
}

static void fill_offsets(const struct api_mesh_fields *fields, struct state *state, uint64_t first,
                         size_t count, int32_t *values) {
    for (size_t k = 0; k < count; k++)
        values[k] = state->offset += corners(fields->elements[first + k]);
}

static bool fill(void *context, const struct vtk_array *array, uint64_t first, size_t count,
                 void *bytes) {
    struct api_mesh_encoder *encoder = context;
    struct state *state = encoder->state;
    const struct api_mesh_fields *fields = &encoder->fields;
    const struct api_column_source *column = fields->columns + array->source;
    size_t components = (size_t)array->components;
    uint8_t *shapes = bytes;
    switch ((enum kind)array->kind) {
    case DATA:
        if (array->type == VTK_INT64)
            fill_integers(state, column, first, count, bytes);
        else
            for (size_t k = 0; k < components; k++)
                fill_component(state, column + k, first, count, (double *)bytes + k, components);
        break;
    case TENSOR:
        fill_tensors(fields, first, count, bytes);
        break;
    case POINTS:
        fill_points(fields, first, count, bytes);
        break;
    case CONNECTIVITY:
        fill_connectivity(fields, state, count, bytes);
        break;
    case OFFSETS:
        fill_offsets(fields, state, first, count, bytes);
        break;
    case TYPES:
        for (size_t k = 0; k < count; k++)
            shapes[k] = corners(fields->elements[first + k]) == 3 ? SHAPE_TRIANGLE : SHAPE_QUAD;
        break;
    }
    return true;
}

/* ---- the list of arrays ---- */

static bool add_columns(const struct api_mesh_fields *fields, struct vtk_file *file) {
    const char *names[VTK_ARRAYS_MAX];
    struct fieldset_field field;
    bool good = fields->column_count <= VTK_ARRAYS_MAX, derived = !mesh_column(fields, "kxx");
    for (size_t k = 0; good && k < fields->column_count; k++)
        names[k] = fields->columns[k].name;
    for (size_t k = 0; good && k < fields->column_count; k += (size_t)field.components) {
        fieldset_make(names, fields->column_count, k, &field);
        bool integer = field.components == 1 && fields->columns[k].integer;
        struct vtk_array array = {.part = VTK_CELL_DATA,
                                  .type = integer ? VTK_INT64 : VTK_FLOAT64,
                                  .components = field.components,
                                  .rows = fields->element_count,
                                  .kind = DATA,
                                  .source = (int)k};
        snprintf(array.name, sizeof array.name, "%s", field.name);
        good = vtk_add(file, &array);
    }
    for (int k = 0; k < FIELDSET_TENSOR_COLUMNS; k++)
        derived = derived && mesh_column(fields, fieldset_tensor_columns[k]);
    return good && (!derived || vtk_add(file, &(struct vtk_array){.part = VTK_CELL_DATA,
                                                                  .type = VTK_FLOAT64,
                                                                  .components = 6,
                                                                  .rows = fields->element_count,
                                                                  .name = "permeability",
                                                                  .kind = TENSOR}));
}

static bool add_mesh(const struct api_mesh_fields *fields, struct vtk_file *file) {
    uint64_t total = 0;
    for (size_t k = 0; k < fields->element_count; k++)
        total += (uint64_t)corners(fields->elements[k]);
    const struct vtk_array arrays[] = {
        {.part = VTK_POINTS,
         .type = VTK_FLOAT64,
         .components = 3,
         .rows = fields->vertex_count,
         .name = "Points",
         .kind = POINTS},
        {.part = VTK_TOPOLOGY,
         .type = VTK_INT32,
         .components = 1,
         .rows = total,
         .name = "connectivity",
         .kind = CONNECTIVITY},
        {.part = VTK_TOPOLOGY,
         .type = VTK_INT32,
         .components = 1,
         .rows = fields->element_count,
         .name = "offsets",
         .kind = OFFSETS},
        {.part = VTK_TOPOLOGY,
         .type = VTK_UINT8,
         .components = 1,
         .rows = fields->element_count,
         .name = "types",
         .kind = TYPES},
    };
    for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++)
        if (total > INT32_MAX || !vtk_add(file, &arrays[k]))
            return false;
    return true;
}

static bool begin(struct api_mesh_encoder *encoder, struct api_problem *problem) {
    struct state *state = encoder->state;
    const struct api_mesh_fields *fields = &encoder->fields;
    state->file = (struct vtk_file){.points = fields->vertex_count,
                                    .cells = fields->element_count,
                                    .fill = fill,
                                    .context = encoder};
    if (!add_columns(fields, &state->file) || !add_mesh(fields, &state->file)) {
        api_problem_set(problem, API_TOO_LARGE, "the mesh is too large for this format");
        return false;
    }
    encoder->length = vtk_length(&state->file);
    return true;
}

static void next(struct api_mesh_encoder *encoder) {
    struct state *state = encoder->state;
    if (!vtk_next(&state->file, &encoder->piece, &encoder->ended))
        encoder->failed = true;
}

const struct api_mesh_format mesh_format_vtu = {.name = "vtu",
                                                .media_type = "application/vnd.vtk",
                                                .state_size = sizeof(struct state),
                                                .begin = begin,
                                                .next = next};
