/* SPDX-License-Identifier: MIT */
/* VTK XML UnstructuredGrid: the caller's mesh with all columns as cell data. */
#include "encoder.h"
#include "vtk_fields.h"
#include <string.h>

_Static_assert((int)ENCODER_PIECE >= (int)VTK_PIECE, "a piece has room for one of the file's");

enum kind { POINTS = VTK_FIELDS_KINDS, CONNECTIVITY, OFFSETS, TYPES };

/* VTK's numbers for shapes. */
enum { SHAPE_TRIANGLE = 5, SHAPE_QUAD = 9 };

struct state {
    struct vtk_file file;
    struct vtk_fields fields;
    size_t element; /* the next of the list that is being written */
    int corner;
    int32_t offset; /* behind it */
};

static int corners(const int32_t element[4]) {
    return element[3] < 0 ? 3 : 4;
}

/* ---- values ---- */

static void fill_points(const struct map_fields *fields, uint64_t first, size_t count,
                        double *values) {
    for (size_t k = 0; k < count; k++) {
        struct vec3 vertex = fields->vertices[first + k];
        memcpy(values + 3 * k, (const double[]){vertex.x, vertex.y, vertex.z}, 3 * sizeof(double));
    }
}

static void fill_connectivity(const struct map_fields *fields, struct state *state, size_t count,
                              int32_t *values) {
    for (size_t k = 0; k < count; k++) {
        const int32_t *element = fields->elements[state->element];
        values[k] = element[state->corner++];
        if (state->corner == corners(element)) {
            state->corner = 0;
            state->element++;
        }
    }
}

static void fill_offsets(const struct map_fields *fields, struct state *state, uint64_t first,
                         size_t count, int32_t *values) {
    for (size_t k = 0; k < count; k++)
        values[k] = state->offset += corners(fields->elements[first + k]);
}

static bool fill(void *context, const struct vtk_array *array, uint64_t first, size_t count,
                 void *bytes) {
    struct encoder *encoder = context;
    struct state *state = encoder->state;
    const struct map_fields *fields = &encoder->fields;
    uint8_t *shapes = bytes;
    if (array->kind < VTK_FIELDS_KINDS)
        return vtk_fields_fill(&state->fields, array, first, count, bytes);
    switch ((enum kind)array->kind) {
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

static bool add_mesh(const struct map_fields *fields, struct vtk_file *file) {
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

static bool begin(struct encoder *encoder, struct api_problem *problem) {
    struct state *state = encoder->state;
    const struct map_fields *fields = &encoder->fields;
    state->file = (struct vtk_file){.points = fields->vertex_count,
                                    .cells = fields->element_count,
                                    .fill = fill,
                                    .context = encoder};
    if (!vtk_fields_add_all(&state->fields, &state->file, VTK_CELL_DATA, fields->columns,
                            fields->column_count) ||
        !vtk_fields_add_tensor(&state->fields, &state->file, fields->columns,
                               fields->column_count) ||
        !add_mesh(fields, &state->file)) {
        api_problem_set(problem, API_TOO_LARGE, "the mesh is too large for this format");
        return false;
    }
    encoder->length = vtk_length(&state->file);
    return true;
}

static void next(struct encoder *encoder) {
    struct state *state = encoder->state;
    if (!vtk_next(&state->file, &encoder->piece, &encoder->ended))
        encoder->failed = true;
}

const struct format format_vtu = {
    .name = "vtu",
    .media_type = "application/vnd.vtk",
    .about = "VTK UnstructuredGrid: the caller's mesh with the fields of its elements",
    .exact = "every bit",
    .uses = FORMAT_MAP,
    .elements = true,
    .state_size = sizeof(struct state),
    .begin = begin,
    .next = next};
