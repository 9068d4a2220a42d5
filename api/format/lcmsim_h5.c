/* SPDX-License-Identifier: MIT */
/*
 * LCMsim's own HDF5 mesh, with the inputs of every cell: exact, where a case (`lcmsim.c`) has
 * parts. Names, types and shapes are those that create_LcmMesh of LCMsim v2 reads and
 * save_plottable_mesh writes (github.com/LCMsim/LCMsim_v2.jl at ccfe9b6,
 * src/preparation/meshUtils.jl, src/ioUtils.jl). Julia has the first index run fastest: what it
 * sees as N x 3 is 3 x N here. SI units.
 *
 * - Quadrilaterals are split along the first diagonal. Corners are sorted by number, as LCMsim's
 *   readers of meshes leave them. Cells with an edge that no other cell shares are walls.
 * - ap is the porosity and cp 0: it does not follow the pressure.
 */
#include "element_frame.h"
#include "encoder.h"
#include "hdf5.h"
#include "lcmsim.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Numbers of LCMsim: of CELLTYPE, and of parts, which have names. */
enum { TYPE_INNER = 1, TYPE_INLET = -1, TYPE_OUTLET = -2, TYPE_WALL = -3 };
static const struct {
    int part, type;
    const char *id, *name;
} roles[MAP_ROLES] = {[MAP_FABRIC] = {1, TYPE_INNER, "1", "base"},
                      [MAP_INLET] = {2, TYPE_INLET, "2", "inlet"},
                      [MAP_OUTLET] = {3, TYPE_OUTLET, "3", "outlet"},
                      [MAP_CHANNEL] = {4, TYPE_INNER, "4", "channel"}};

struct cell {
    int32_t corner[3]; /* sorted */
    int32_t element;
    bool wall;
};

struct state {
    struct lcmsim_source source;
    struct cell *cell;
    size_t cells, sent;
    struct hdf5_file *file;
    const char *image;
    size_t length;
};

/* ---- cells ---- */

/* What cannot be filled is not there: a wall to the flow. So is a side that no other cell has. */
static bool list_cells(struct state *state, const struct map_fields *fields) {
    struct lcmsim_inputs in;
    state->cell = malloc(2 * fields->element_count * sizeof *state->cell);
    if (!state->cell)
        return false;
    for (size_t e = 0; e < fields->element_count; e++) {
        const int32_t *corner = fields->elements[e];
        bool out = lcmsim_read(&state->source, e, &in) == LCMSIM_LEFT_OUT;
        for (int half = 0; !out && half < (corner[3] < 0 ? 1 : 2); half++) {
            int32_t a = corner[0], b = corner[half + 1], c = corner[half + 2];
            int32_t low = a < b ? a : b, high = a < b ? b : a;
            int32_t first = low < c ? low : c, last = high > c ? high : c;
            state->cell[state->cells++] =
                (struct cell){{first, a + b + c - first - last, last}, (int32_t)e, false};
        }
    }
    size_t count = 3 * state->cells;
    struct element_edge *sides = malloc(count * sizeof *sides);
    if (!sides)
        return false;
    for (size_t c = 0; c < state->cells; c++) {
        const int32_t *v = state->cell[c].corner;
        for (size_t k = 0; k < 3; k++)
            sides[3 * c + k] =
                (struct element_edge){v[k == 2], v[k == 0 ? 1 : 2], (int32_t)c, (int32_t)k};
    }
    qsort(sides, count, sizeof *sides, element_edge_compare);
    for (size_t k = 0; k < count; k++)
        if ((k == 0 || element_edge_compare(&sides[k - 1], &sides[k]) != 0) &&
            (k + 1 == count || element_edge_compare(&sides[k], &sides[k + 1]) != 0))
            state->cell[sides[k].element].wall = true;
    free(sides);
    return true;
}

static enum map_role cell_role(const struct map_fields *fields, const struct cell *cell) {
    return fields->roles ? (enum map_role)fields->roles[cell->element] : MAP_FABRIC;
}

/* ---- inputs ---- */

static struct lcmsim_inputs cell_inputs(const struct encoder *encoder, const struct cell *cell) {
    const struct state *state = encoder->state;
    struct lcmsim_inputs in;
    (void)lcmsim_read(&state->source, (size_t)cell->element, &in);
    in.porosity = fmin(in.porosity, LCMSIM_POROSITY_MAX);
    return in;
}

static const char *const real_names[] = {"/properties/volume",       "/properties/area",
                                         "/properties/permeability", "/properties/porosity",
                                         "/properties/thickness",    "/properties/alpha",
                                         "/properties/ap",           "/properties/cp"};
enum { REALS = sizeof real_names / sizeof *real_names };

/* The property of that number. */
static double cell_real(const struct encoder *encoder, const struct cell *cell, int real) {
    struct lcmsim_inputs in = cell_inputs(encoder, cell);
    const struct vec3 *v = encoder->fields.vertices;
    struct vec3 p = v[cell->corner[0]];
    double metres = encoder->fields.unit->metres;
    double area =
        0.5 * metres * metres *
        vec3_norm(vec3_cross(vec3_sub(v[cell->corner[1]], p), vec3_sub(v[cell->corner[2]], p)));
    const double reals[REALS] = {area * in.thickness, area,          in.k1,       in.porosity,
                                 in.thickness,        in.k2 / in.k1, in.porosity, 0};
    return reals[real];
}

/* ---- the file ---- */

/* Room for the largest dataset, used for each in turn. */
union values {
    double *real;
    int64_t *integer;
    void *room;
};

static void write_groups(const struct encoder *encoder, union values values) {
    const struct state *state = encoder->state;
    const struct map_fields *fields = &encoder->fields;
    size_t points = fields->vertex_count, cells = state->cells;
    bool there[MAP_ROLES] = {false};
    hdf5_group(state->file, "/mesh");
    for (size_t k = 0; k < points; k++) {
        struct vec3 v = vec3_scale(fields->unit->metres, fields->vertices[k]);
        values.real[k] = v.x;
        values.real[points + k] = v.y;
        values.real[2 * points + k] = v.z;
    }
    hdf5_reals(state->file, "/mesh/vertices", 3, points, values.real);
    for (size_t c = 0; c < cells; c++)
        for (size_t k = 0; k < 3; k++)
            values.integer[k * cells + c] = state->cell[c].corner[k] + 1;
    hdf5_integers(state->file, "/mesh/cells", 3, cells, values.integer);
    hdf5_group(state->file, "/properties");
    for (int real = 0; real < REALS; real++) {
        for (size_t c = 0; c < cells; c++)
            values.real[c] = cell_real(encoder, &state->cell[c], real);
        hdf5_reals(state->file, real_names[real], cells, 0, values.real);
    }
    for (size_t c = 0; c < cells; c++) {
        struct vec3 d = cell_inputs(encoder, &state->cell[c]).direction;
        values.real[c] = d.x;
        values.real[cells + c] = d.y;
        values.real[2 * cells + c] = d.z;
    }
    hdf5_reals(state->file, "/properties/reference_direction", 3, cells, values.real);
    for (size_t c = 0; c < cells; c++) {
        enum map_role role = cell_role(fields, &state->cell[c]);
        values.integer[c] = roles[role].part;
        there[role] = true;
    }
    hdf5_integers(state->file, "/properties/part_id", cells, 0, values.integer);
    for (size_t c = 0; c < cells; c++) {
        int type = roles[cell_role(fields, &state->cell[c])].type;
        values.integer[c] = type == TYPE_INNER && state->cell[c].wall ? TYPE_WALL : type;
    }
    hdf5_integers(state->file, "/properties/type", cells, 0, values.integer);
    if (fields->revision)
        hdf5_string(state->file, "/mesh", "revision", fields->revision);
    for (int role = 0; role < MAP_ROLES; role++)
        if (there[role])
            hdf5_string(state->file, "/properties", roles[role].id, roles[role].name);
}

/* ---- the format ---- */

static bool begin_lcmsim_h5(struct encoder *encoder, struct api_problem *problem) {
    struct state *state = encoder->state;
    if (!lcmsim_open(&state->source, &encoder->fields, encoder->options.fiber_volume_fraction,
                     problem))
        return false;
    if (list_cells(state, &encoder->fields)) {
        size_t points = encoder->fields.vertex_count;
        size_t rows = state->cells > points ? state->cells : points;
        union values values = {.room = malloc(3 * rows * sizeof(double))};
        state->file = values.room ? hdf5_new() : NULL;
        if (state->file) {
            write_groups(encoder, values);
            state->image = hdf5_image(state->file, &state->length);
        }
        free(values.room);
    }
    if (!state->image)
        api_problem_set(problem, API_OUT_OF_MEMORY, "no memory to make the HDF5 file");
    encoder->length = state->length;
    return problem->id == API_OK;
}

static void next_lcmsim_h5(struct encoder *encoder) {
    struct state *state = encoder->state;
    size_t left = state->length - state->sent;
    size_t part = left < encoder->piece.capacity ? left : encoder->piece.capacity;
    api_text_bytes(&encoder->piece, state->image + state->sent, part);
    state->sent += part;
    encoder->ended = state->sent == state->length;
}

static void end_lcmsim_h5(struct encoder *encoder) {
    struct state *state = encoder->state;
    hdf5_free(state->file);
    free(state->cell);
}

const struct format format_lcmsim_h5 = {.name = "lcmsim-h5",
                                        .media_type = "application/x-lcmsim",
                                        .about = "LCMsim's HDF5 mesh with the inputs of every cell",
                                        .exact = "every bit",
                                        .uses = FORMAT_MAP,
                                        .flow = true,
                                        .elements = true,
                                        .state_size = sizeof(struct state),
                                        .begin = begin_lcmsim_h5,
                                        .next = next_lcmsim_h5,
                                        .end = end_lcmsim_h5};
