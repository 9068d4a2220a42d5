/* SPDX-License-Identifier: MIT */
/* VTK XML UnstructuredGrid: the caller's mesh with all columns as cell data, those of the plies by
 * ply: angle_1, shear_1, thickness_1, ..., not a number where the ply is not. */
#include "encoder.h"
#include "stack.h"
#include "vtk_fields.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

_Static_assert((int)ENCODER_PIECE >= (int)VTK_PIECE, "a piece has room for one of the file's");

enum kind { POINTS = VTK_FIELDS_KINDS, CONNECTIVITY, OFFSETS, TYPES, PLY };

/* Of a ply, by column; `PLY` arrays have ply * PLY_FIELDS + field for their source. */
static const struct {
    enum column_id column;
    const char *name;
} ply_fields[] = {{COLUMN_PLIES_angle_deg, "angle"},
                  {COLUMN_PLIES_shear_deg, "shear"},
                  {COLUMN_PLIES_thickness, "thickness"},
                  {COLUMN_PLIES_fiber_volume_fraction, "fiber_volume_fraction"}};
enum { PLY_FIELDS = sizeof ply_fields / sizeof *ply_fields };

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

static double ply_value(const struct map_ply_row *row, enum column_id column) {
    if (!row)
        return (double)NAN;
    if (column == COLUMN_PLIES_angle_deg)
        return row->angle_deg;
    if (column == COLUMN_PLIES_shear_deg)
        return row->shear_deg;
    return column == COLUMN_PLIES_thickness ? row->thickness : row->fiber_volume_fraction;
}

static void fill_ply(const struct map_fields *fields, int source, uint64_t first, size_t count,
                     double *values) {
    for (size_t k = 0; k < count; k++)
        values[k] = ply_value(stack_row(fields, first + k, source / PLY_FIELDS),
                              ply_fields[source % PLY_FIELDS].column);
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
    case PLY:
        fill_ply(fields, array->source, first, count, bytes);
        break;
    }
    return true;
}

/* ---- the list of arrays ---- */

/* Of the plies what is selected of their columns. */
static bool add_plies(const struct map_fields *fields, struct vtk_file *file) {
    for (int f = 0; fields->plies && f < PLY_FIELDS; f++) {
        const struct column_spec *spec = &column_specs[ply_fields[f].column];
        if (!encoder_find(fields->columns, fields->column_count, spec->table, spec->name))
            continue;
        for (size_t ply = 0; ply < fields->plies->ply_count; ply++) {
            struct vtk_array array = {.section = VTK_CELL_DATA,
                                      .type = VTK_FLOAT64,
                                      .components = 1,
                                      .rows = fields->element_count,
                                      .kind = PLY,
                                      .source = (int)ply * PLY_FIELDS + f};
            snprintf(array.name, sizeof array.name, "%s_%zu", ply_fields[f].name, ply + 1);
            if (!vtk_add(file, &array))
                return false;
        }
    }
    return true;
}

static bool add_mesh(const struct map_fields *fields, struct vtk_file *file) {
    uint64_t total = 0;
    for (size_t k = 0; k < fields->element_count; k++)
        total += (uint64_t)corners(fields->elements[k]);
    const struct vtk_array arrays[] = {
        {.section = VTK_POINTS,
         .type = VTK_FLOAT64,
         .components = 3,
         .rows = fields->vertex_count,
         .name = "Points",
         .kind = POINTS},
        {.section = VTK_TOPOLOGY,
         .type = VTK_INT32,
         .components = 1,
         .rows = total,
         .name = "connectivity",
         .kind = CONNECTIVITY},
        {.section = VTK_TOPOLOGY,
         .type = VTK_INT32,
         .components = 1,
         .rows = fields->element_count,
         .name = "offsets",
         .kind = OFFSETS},
        {.section = VTK_TOPOLOGY,
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
        !add_plies(fields, &state->file) || !add_mesh(fields, &state->file)) {
        api_problem_set(problem, API_TOO_LARGE,
                        "the mesh is too large for this format, or has too many plies: `fields` "
                        "without plies.* leaves these out");
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
    .about = "VTK UnstructuredGrid: the caller's mesh with the fields of its elements and plies",
    .exact = "every bit",
    .uses = FORMAT_MAP,
    .elements = true,
    .state_size = sizeof(struct state),
    .begin = begin,
    .next = next};
