/* SPDX-License-Identifier: MIT */
/*
 * CalculiX: the mesh as quadratic shells, S6 and S8R, which alone take composite sections there,
 * with nodes in the middles of edges; for each element an *ORIENTATION of every layer and a
 * composite *SHELL SECTION. (Orientations by *DISTRIBUTION are accepted in composite sections by
 * CalculiX 2.20, and ignored.)
 * Sources: CalculiX CrunchiX User's Manual, *ORIENTATION (ccx.openaircraft.com/ccx-doc), six- and
 * eight-node shell elements (www.openaircraft.com/ccx-doc/ccx/node40.html, node41.html); *SHELL
 * SECTION as ccx 2.20 reads it, which a test runs.
 */
#include "deck.h"
#include <stdlib.h>

enum { WIDTH = 20, EDGES = 4 };

/* Edges between the same vertices share their middle. The numbers of middles follow those of all
 * vertices. */
static bool make_middles(struct encoder *encoder, struct api_problem *problem) {
    struct deck_state *state = encoder->state;
    const struct map_fields *fields = &encoder->fields;
    size_t elements = fields->element_count, count = 0;
    state->middle = malloc(elements * sizeof *state->middle);
    state->edge = malloc(elements * EDGES * sizeof *state->edge);
    if (!state->middle || !state->edge)
        return !api_problem_set(problem, API_OUT_OF_MEMORY, "no memory for the mid-edge nodes");
    for (size_t e = 0; e < elements; e++) {
        const int32_t *corners = fields->elements[e];
        int sides = element_corner_count(corners);
        for (int k = 0; k < sides && stack_layers(fields, e) > 0; k++) {
            int32_t p = corners[k], q = corners[(k + 1) % sides];
            state->edge[count++] =
                (struct element_edge){p < q ? p : q, p < q ? q : p, (int32_t)e, k};
        }
    }
    qsort(state->edge, count, sizeof *state->edge, element_edge_compare);
    for (size_t k = 0; k < count; k++) {
        struct element_edge edge = state->edge[k];
        if (state->middles == 0 ||
            element_edge_compare(&edge, &state->edge[state->middles - 1]) != 0)
            state->edge[state->middles++] = edge;
        state->middle[edge.element][edge.number] = (int32_t)state->middles - 1;
    }
    for (size_t k = 0; k < fields->vertex_count; k++)
        if (deck_vertex_id(fields, k) >= state->first_middle)
            state->first_middle = deck_vertex_id(fields, k) + 1;
    return true;
}

static void write_middle(struct encoder *encoder, const struct deck_item *item) {
    const struct deck_state *state = encoder->state;
    const struct vec3 *v = encoder->fields.vertices;
    const struct element_edge *edge = &state->edge[item->number];
    deck_write_point(encoder, state->first_middle + (int32_t)item->number,
                     vec3_scale(0.5, vec3_add(v[edge->a], v[edge->b])));
}

static void write_s6_or_s8r(struct encoder *encoder, const struct deck_item *item) {
    const struct deck_state *state = encoder->state;
    int sides = element_corner_count(item->corners);
    api_text_format(&encoder->piece, "*ELEMENT, TYPE=%s, ELSET=E%d\n%d", sides == 3 ? "S6" : "S8R",
                    item->id, item->id);
    for (int k = 0; k < sides; k++)
        api_text_format(&encoder->piece, ",%d",
                        deck_vertex_id(&encoder->fields, (size_t)item->corners[k]));
    for (int k = 0; k < sides; k++)
        api_text_format(&encoder->piece, ",%d",
                        state->first_middle + state->middle[item->element][k]);
    api_text_raw(&encoder->piece, "\n");
}

static void write_shell_section(struct encoder *encoder, const struct deck_item *item) {
    const struct map_fields *fields = &encoder->fields;
    struct api_text *text = &encoder->piece;
    for (size_t k = 0; k < item->layers; k++) {
        const struct map_ply_row *row = stack_layer(fields, item->element, k);
        api_text_format(text, "*ORIENTATION, NAME=E%d_%d\n", item->id, row->ply + 1);
        deck_write_axes(encoder, item->element, row->angle_deg, ",", WIDTH);
    }
    api_text_format(text, "*SHELL SECTION, COMPOSITE, ELSET=E%d\n", item->id);
    for (size_t k = 0; k < item->layers; k++) {
        const struct map_ply_row *row = stack_layer(fields, item->element, k);
        deck_real(encoder, row->thickness, WIDTH);
        api_text_format(text, ",,MATERIAL_%d,E%d_%d\n", row->ply + 1, item->id, row->ply + 1);
    }
}

/* E1 E2 E3 nu12 nu13 nu23 G12 G13, G23: through the layer as across its fibres, but with nu13 and
 * nu23 of 0, as the layers of an element change their thickness together. */
static void write_engineering_constants(struct encoder *encoder, const struct deck_item *item) {
    struct lamina own;
    if (!deck_lamina(encoder, item->ply, &own))
        return;
    const double values[] = {own.e1, own.e2, own.e2, own.nu12, 0, 0, own.g12, own.g12, own.g12};
    enum { ROW = 8 };
    api_text_format(&encoder->piece,
                    "*MATERIAL, NAME=MATERIAL_%d\n*ELASTIC, TYPE=ENGINEERING CONSTANTS",
                    item->ply + 1);
    for (size_t k = 0; k < sizeof values / sizeof *values; k++) {
        api_text_raw(&encoder->piece, k % ROW ? "," : "\n");
        deck_real(encoder, values[k], WIDTH);
    }
    api_text_raw(&encoder->piece, "\n");
}

/* Directions of x and y: systems have no origin there. */
static void write_calculix_system(struct encoder *encoder, const struct deck_axes *axes) {
    api_text_raw(&encoder->piece, "*ORIENTATION, NAME=ROSETTE\n");
    deck_write_vector(encoder, axes->x, ",", WIDTH);
    api_text_raw(&encoder->piece, ",");
    deck_write_vector(encoder, axes->y, ",", WIDTH);
    api_text_raw(&encoder->piece, "\n");
}

static const struct deck deck = {
    .mark = "**",
    .about = "The mesh with mid-edge nodes, numbered after its own nodes, and a "
             "composite *SHELL SECTION for each element: thickness, MATERIAL_k, the direction of "
             "the fibre of ply k, of a woven ply the warp. For *INCLUDE.",
    .text = "*NODE, NSET=DRAPED\n",
    .id_max = INT32_MAX / 2,
    .rosette = write_calculix_system,
    .begin = make_middles,
    .point = {"", 0, {",", ",", ","}, WIDTH},
    .sections = {{DECK_VERTICES, deck_write_vertex, NULL},
                 {DECK_MIDDLES, write_middle, NULL},
                 {DECK_STACKS, write_s6_or_s8r, NULL},
                 {DECK_STACKS, write_shell_section, NULL},
                 {DECK_PLIES, write_engineering_constants, NULL}}};

const struct format format_calculix = {
    .name = "calculix",
    .media_type = "text/x-calculix",
    .about = "CalculiX: the mesh as S6 and S8R, a composite *SHELL SECTION for each element",
    .exact = "15 digits",
    DECK_FORMAT(deck)};
