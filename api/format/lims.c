/* SPDX-License-Identifier: MIT */
/*
 * A mesh for LIMS (University of Delaware), as a DMP file: nodes, then shell elements with
 * thickness h, fibre volume fraction Vf and the permeability in the element's own axes,
 *
 *   Kxx = k1 cos^2 a + k2 sin^2 a,  Kxy = (k1 - k2) cos a sin a,  Kyy = k1 sin^2 a + k2 cos^2 a,
 *
 * a the angle of k1 from x about the normal. x is the first edge N1-N2, or the caller's direction
 * projected on the element (`element_frame.h`); the head of the file says which. SI units.
 *
 * The order of the sections and fields is that of sites.udel.edu/lims/lims-file-formats, by which a
 * reader takes lines in free format, passes over lines that begin with # and ignores the text of
 * headings. Nodes and elements are numbered from 1 without gaps; nodes of no element are left out.
 * Gates and vents are set by node, in LIMS's script: the head lists the nodes of inlet and outlet.
 */
#include "deck.h"
#include "lcmsim.h"
#include "solver/angle.h"
#include <stdlib.h>

enum { LINE = 512 }; /* bytes of a row with its heading at most */

/* The parts of the file, with a row for each element or vertex that is of them. */
enum section { HEAD, DENSE, GATES, VENTS, NODES, ELEMENTS, RESIN, SECTIONS };

struct node {
    int32_t number; /* 0: no element has it */
    uint8_t role;   /* enum map_role: of an element that it is a corner of */
};

struct state {
    struct lcmsim_source source;
    struct node *node; /* of each vertex */
    size_t nodes, elements, left_out;
    enum section section;
    int32_t element; /* the number of the last one */
};

/* ---- what there is ---- */

static bool begin_lims(struct encoder *encoder, struct api_problem *problem) {
    struct state *state = encoder->state;
    const struct map_fields *fields = &encoder->fields;
    struct lcmsim_inputs in;
    if (!lcmsim_open(&state->source, fields, encoder->options.fiber_volume_fraction, problem))
        return false;
    state->node = calloc(fields->vertex_count, sizeof *state->node);
    if (!state->node)
        return !api_problem_set(problem, API_OUT_OF_MEMORY, "no memory for the nodes of the mesh");
    for (size_t e = 0; e < fields->element_count; e++) {
        const int32_t *corners = fields->elements[e];
        if (lcmsim_read(&state->source, e, &in) == LCMSIM_LEFT_OUT) {
            state->left_out++;
            continue;
        }
        state->elements++;
        for (int k = 0; k < element_corner_count(corners); k++) {
            struct node *node = &state->node[corners[k]];
            node->number = 1;
            if (fields->roles && fields->roles[e] != MAP_FABRIC && node->role != MAP_INLET)
                node->role = fields->roles[e];
        }
    }
    for (size_t v = 0; v < fields->vertex_count; v++)
        if (state->node[v].number)
            state->node[v].number = (int32_t)++state->nodes;
    return true;
}

static void end_lims(struct encoder *encoder) {
    struct state *state = encoder->state;
    free(state->node);
}

/* ---- rows ---- */

static void write_lims_head(struct encoder *encoder) {
    const struct state *state = encoder->state;
    char origin[ENCODER_NOTE_SIZE];
    encoder_origin(encoder, origin);
    api_text_format(
        &encoder->piece,
        "# LIMS mesh of %s: m, m^2\n"
        "# Kxx, Kxy, Kyy: x is %s, y is 90 degrees about the\n"
        "# element's normal. Another axis: the option reference.\n"
        "# The viscosity at the end of the file is an example: set that of your resin.\n",
        origin,
        encoder->fields.plies->reference ? "the direction of the option reference"
                                         : "the edge N1-N2");
    if (state->left_out)
        api_text_format(
            &encoder->piece,
            "# %zu elements are left out, walls to the flow: they are packed too densely "
            "to be filled.\n",
            state->left_out);
}

static void write_numbers(struct api_text *text, const double *values, int count) {
    for (int k = 0; k < count; k++) {
        api_text_raw(text, " ");
        api_text_number(text, values[k]);
    }
    api_text_raw(text, "\n");
}

/* Index NNOD N1 N2 N3 (N4) h Vf Kxx Kxy Kyy; or that it is left out. */
static void write_lims_element(struct encoder *encoder, size_t e) {
    struct state *state = encoder->state;
    const struct map_fields *fields = &encoder->fields;
    const int32_t *corners = fields->elements[e];
    struct lcmsim_inputs in;
    struct element_frame frame;
    bool dense = lcmsim_read(&state->source, e, &in) == LCMSIM_LEFT_OUT;
    if (dense != (state->section == DENSE))
        return;
    if (dense) {
        api_text_format(&encoder->piece, "# left out: element %d, fibre volume fraction %.6g\n",
                        deck_element_id(fields, e), lcmsim_fraction(&state->source, e));
        return;
    }
    api_text_format(&encoder->piece, "%d %d", ++state->element, element_corner_count(corners));
    for (int k = 0; k < element_corner_count(corners); k++)
        api_text_format(&encoder->piece, " %d", state->node[corners[k]].number);
    double a = 0; /* a flat element has no axes, and no flow */
    if (element_frame_make(fields->vertices, corners, fields->plies->reference, &frame) ==
        ELEMENT_SOUND)
        a = element_angle_deg(&frame, in.direction);
    double c, s;
    angle_sincos_deg(a, &s, &c);
    const double values[] = {in.thickness, 1 - in.porosity, in.k1 * c * c + in.k2 * s * s,
                             (in.k1 - in.k2) * c * s, in.k1 * s * s + in.k2 * c * c};
    write_numbers(&encoder->piece, values, sizeof values / sizeof *values);
}

static void write_lims_node(struct encoder *encoder, size_t v) {
    const struct state *state = encoder->state;
    const struct node *node = &state->node[v];
    uint8_t role = state->section == GATES ? MAP_INLET : MAP_OUTLET;
    if (node->number == 0 || (state->section != NODES && node->role != role))
        return;
    if (state->section != NODES) {
        api_text_format(&encoder->piece, "# %s: node %d\n", role == MAP_INLET ? "gate" : "vent",
                        node->number);
        return;
    }
    struct vec3 p = vec3_scale(encoder->fields.unit->metres, encoder->fields.vertices[v]);
    api_text_format(&encoder->piece, "%d", node->number);
    write_numbers(&encoder->piece, (const double[]){p.x, p.y, p.z}, 3);
}

/* ---- the file ---- */

static const char rule[] = "===================================================\n";

static void write_row(struct encoder *encoder, size_t row) {
    const struct state *state = encoder->state;
    struct api_text *text = &encoder->piece;
    if (row == 0 && state->section == NODES)
        api_text_format(text, "Number of nodes : %zu\nIndex x y z\n%s", state->nodes, rule);
    if (row == 0 && state->section == ELEMENTS)
        api_text_format(text,
                        "Number of elements : %zu\nIndex NNOD N1 N2 N3 (N4) (N5) (N6) (N7) (N8) "
                        "h Vf Kxx Kxy Kyy Kzz Kzx Kyz\n%s",
                        state->elements, rule);
    switch (state->section) {
    case HEAD:
        write_lims_head(encoder);
        break;
    case DENSE:
    case ELEMENTS:
        write_lims_element(encoder, row);
        break;
    case GATES:
    case VENTS:
    case NODES:
        write_lims_node(encoder, row);
        break;
    case RESIN:
        api_text_raw(text, "Resin Viscosity model NEWTON\nViscosity : 0.06\n");
        break;
    case SECTIONS:
        break;
    }
}

static void next_lims(struct encoder *encoder) {
    struct state *state = encoder->state;
    const struct map_fields *fields = &encoder->fields;
    const size_t rows[SECTIONS] = {[HEAD] = 1,
                                   [DENSE] = fields->element_count,
                                   [GATES] = fields->vertex_count,
                                   [VENTS] = fields->vertex_count,
                                   [NODES] = fields->vertex_count,
                                   [ELEMENTS] = fields->element_count,
                                   [RESIN] = 1};
    while (state->section < SECTIONS && encoder->piece.capacity - encoder->piece.length > LINE) {
        write_row(encoder, encoder->row++);
        if (encoder->row == rows[state->section]) {
            encoder->row = 0;
            state->section++;
        }
    }
    encoder->ended = state->section == SECTIONS;
}

const struct format format_lims = {
    .name = "lims",
    .media_type = "text/x-lims",
    .about = "a DMP mesh for LIMS, with the permeability of each element in its own axes",
    .exact = "15 digits",
    .uses = FORMAT_MAP,
    .elements = true,
    .flow = true,
    .state_size = sizeof(struct state),
    .begin = begin_lims,
    .next = next_lims,
    .end = end_lims};
