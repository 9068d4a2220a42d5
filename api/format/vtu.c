/* SPDX-License-Identifier: MIT */
/* VTK XML UnstructuredGrid: the caller's mesh with all columns as cell data. */
#include "element_frame.h"
#include "vtk.h"
#include <string.h>

enum kind { POINTS = VTK_OWN_KINDS, CONNECTIVITY, OFFSETS, TYPES };

/* VTK's numbers for shapes. */
enum { SHAPE_TRIANGLE = 5, SHAPE_QUAD = 9 };

struct state {
    struct vtk_file file;
    size_t element; /* the next of the list that is being written */
    int corner;
    int32_t offset; /* behind it */
};

/* ---- values ---- */

static bool fill_mesh(struct encoder *encoder, const struct vtk_array *array, uint64_t first,
                      size_t count, void *bytes) {
    struct state *state = encoder->state;
    const struct map_fields *fields = &encoder->fields;
    const int32_t(*elements)[4] = fields->elements;
    double *reals = bytes;
    int32_t *integers = bytes;
    uint8_t *shapes = bytes;
    for (size_t k = 0; k < count; k++)
        switch ((enum kind)array->kind) {
        case POINTS:
            memcpy(reals + 3 * k, &fields->vertices[first + k], 3 * sizeof *reals);
            break;
        case CONNECTIVITY:
            integers[k] = elements[state->element][state->corner++];
            if (state->corner == element_corner_count(elements[state->element])) {
                state->corner = 0;
                state->element++;
            }
            break;
        case OFFSETS:
            integers[k] = state->offset += element_corner_count(elements[first + k]);
            break;
        case TYPES:
            shapes[k] = elements[first + k][3] < 0 ? SHAPE_TRIANGLE : SHAPE_QUAD;
            break;
        }
    return true;
}

/* The columns of the elements, of the plies what is selected of theirs, and the mesh. */
static bool begin_vtu(struct encoder *encoder, struct api_problem *problem) {
    static const struct vtk_array arrays[] = {
        {VTK_POINTS, VTK_FLOAT64, 3, .name = "Points", .kind = POINTS},
        {VTK_TOPOLOGY, VTK_INT32, 1, .name = "connectivity", .kind = CONNECTIVITY},
        {VTK_TOPOLOGY, VTK_INT32, 1, .name = "offsets", .kind = OFFSETS},
        {VTK_TOPOLOGY, VTK_UINT8, 1, .name = "types", .kind = TYPES},
    };
    const struct map_fields *fields = &encoder->fields;
    struct vtk_file *file = encoder->state;
    uint64_t corners = 0;
    file->points = fields->vertex_count;
    file->cells = fields->element_count;
    file->fill = fill_mesh;
    bool room = vtk_add_elements(file, fields);
    for (size_t k = 0; k < fields->element_count; k++)
        corners += (uint64_t)element_corner_count(fields->elements[k]);
    room = room && corners <= INT32_MAX;
    for (size_t k = 0; k < sizeof arrays / sizeof *arrays && room; k++) {
        struct vtk_array array = arrays[k];
        array.rows = array.kind == POINTS         ? fields->vertex_count
                     : array.kind == CONNECTIVITY ? corners
                                                  : fields->element_count;
        room = vtk_add(file, &array);
    }
    if (!room)
        return !api_problem_set(
            problem, API_TOO_LARGE,
            "the mesh is too large for vtu, or has too many plies; to leave the plies "
            "out, give `fields` without plies.*, or choose csv");
    file->revision = encoder->fields.revision;
    vtk_begin(encoder);
    return true;
}

const struct format format_vtu = {
    .name = "vtu",
    .media_type = "application/vnd.vtk",
    .about = "VTK UnstructuredGrid: the caller's mesh with the fields of its elements and plies",
    .exact = "every bit",
    .uses = FORMAT_MAP,
    .flow = true,
    .elements = true,
    .state_size = sizeof(struct state),
    .begin = begin_vtu,
    .next = vtk_next};
