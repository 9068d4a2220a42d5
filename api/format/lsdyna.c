/* SPDX-License-Identifier: MIT */
/*
 * LS-DYNA: the mesh, its shells as *ELEMENT_SHELL_COMPOSITE with material, thickness and angle of
 * each layer, from the bottom. Angles run from the element's x-axis, N1-N2.
 * Sources: LS-DYNA Keyword User's Manual, *ELEMENT_SHELL; its fields as PyDyna has them
 * (ansys/pydyna, element_shell_composite.py): ids of 8 characters; MID, THICK, B and a blank of 10
 * each, two layers a line. lsdyna.ansys.com/orthotropic-materials: the default x-axis is the 1-2
 * edge.
 */
#include "deck.h"

enum { WIDTH = 10, COORDINATE = 16, ID_MAX = 99999999, PART = 1 };

static const char mark[] = "$";

static bool begin(struct encoder *encoder, struct api_problem *problem) {
    return deck_check(encoder, ID_MAX, problem);
}

static void write_head(struct encoder *encoder, size_t item) {
    static const char *const about[] = {
        "The mesh as part 1, in place of its own *NODE and *ELEMENT_SHELL; for *INCLUDE. Layers "
        "from "
        "the bottom: material, thickness, angle of the warp from side N1-N2 (AOPT 0, and no "
        "invariant node numbering). The shear between warp and weft is not here.",
        NULL};
    (void)item;
    deck_head(encoder, mark, about);
    deck_line(encoder, "*NODE\n");
}

static void write_vertex(struct encoder *encoder, size_t item) {
    struct vec3 v = encoder->fields.vertices[item];
    deck_line(encoder, "%8d", deck_vertex_id(&encoder->fields, item));
    deck_real(encoder, v.x, COORDINATE);
    deck_real(encoder, v.y, COORDINATE);
    deck_real(encoder, v.z, COORDINATE);
    deck_line(encoder, "\n");
}

static void write_keyword(struct encoder *encoder, size_t item) {
    (void)item;
    deck_line(encoder, "*ELEMENT_SHELL_COMPOSITE\n");
}

/* A triangle has its third corner twice. */
static void write_element(struct encoder *encoder, size_t item) {
    const struct map_fields *fields = &encoder->fields;
    const int32_t *corners = fields->elements[item];
    size_t layers = deck_layers(fields, item);
    if (layers == 0)
        return;
    double edge = deck_frame(fields, item).edge_deg;
    deck_line(encoder, "%8d%8d", deck_element_id(fields, item), PART);
    for (int k = 0; k < 4; k++)
        deck_line(encoder, "%8d", deck_vertex_id(fields, (size_t)corners[corners[k] < 0 ? 2 : k]));
    for (size_t k = 0; k < layers; k++) {
        const struct map_ply_row *row = deck_layer(fields, item, k);
        deck_line(encoder, "%s%10d", k % 2 ? "          " : "\n", row->ply + 1);
        deck_real(encoder, row->thickness, WIDTH);
        deck_real(encoder, deck_fold_deg(edge + row->angle_deg), WIDTH);
    }
    deck_line(encoder, "\n");
}

static const struct deck_section sections[] = {{NULL, write_head},
                                               {deck_vertices, write_vertex},
                                               {NULL, write_keyword},
                                               {deck_elements, write_element},
                                               {0}};

const struct format format_lsdyna = {
    .name = "lsdyna",
    .media_type = "text/x-lsdyna",
    .about = "LS-DYNA: the mesh as *ELEMENT_SHELL_COMPOSITE, thickness and angle of each layer",
    .exact = "angles to 5e-7 degrees, thicknesses to 6 digits",
    .uses = FORMAT_MAP,
    .elements = true,
    .own = sections,
    .begin = begin,
    .next = deck_next};
