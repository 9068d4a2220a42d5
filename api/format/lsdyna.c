/* SPDX-License-Identifier: MIT */
/*
 * LS-DYNA: the mesh, its shells as *ELEMENT_SHELL_COMPOSITE with material, thickness and angle of
 * each layer, from the bottom. Angles run from the element's x-axis, N1-N2.
 * Sources: LS-DYNA Keyword User's Manual, *ELEMENT_SHELL; its fields as PyDyna has them
 * (ansys/pydyna, element_shell_composite.py): ids of 8 characters; MID, THICK, B and a blank of 10
 * each, two layers a line. lsdyna.ansys.com/orthotropic-materials: the default x-axis is the 1-2
 * edge.
 */
#include "cards.h"

enum { WIDTH = 10, COORDINATE = 16, ID_MAX = 99999999, PART = 1 };

static const char mark[] = "$";

static bool begin(struct encoder *encoder, struct api_problem *problem) {
    return cards_check(encoder, ID_MAX, problem);
}

static void write_head(struct encoder *encoder, size_t item) {
    static const char *const about[] = {
        "The mesh as part 1, in place of its own *NODE and *ELEMENT_SHELL; for *INCLUDE. Layers "
        "from "
        "the bottom: material, thickness, angle of the warp from side N1-N2 (AOPT 0, and no "
        "invariant node numbering). The shear between warp and weft is not here.",
        NULL};
    (void)item;
    cards_head(encoder, mark, about);
    cards_line(encoder, "*NODE\n");
}

static void write_vertex(struct encoder *encoder, size_t item) {
    struct vec3 v = encoder->fields.vertices[item];
    cards_line(encoder, "%8d", cards_vertex_id(&encoder->fields, item));
    cards_real(encoder, v.x, COORDINATE);
    cards_real(encoder, v.y, COORDINATE);
    cards_real(encoder, v.z, COORDINATE);
    cards_line(encoder, "\n");
}

static void write_keyword(struct encoder *encoder, size_t item) {
    (void)item;
    cards_line(encoder, "*ELEMENT_SHELL_COMPOSITE\n");
}

/* A triangle has its third corner twice. */
static void write_element(struct encoder *encoder, size_t item) {
    const struct map_fields *fields = &encoder->fields;
    const int32_t *corners = fields->elements[item];
    size_t layers = cards_layers(fields, item);
    if (layers == 0)
        return;
    double edge = cards_frame(fields, item).edge_deg;
    cards_line(encoder, "%8d%8d", cards_element_id(fields, item), PART);
    for (int k = 0; k < 4; k++)
        cards_line(encoder, "%8d",
                   cards_vertex_id(fields, (size_t)corners[corners[k] < 0 ? 2 : k]));
    for (size_t k = 0; k < layers; k++) {
        const struct map_ply_row *row = cards_layer(fields, item, k);
        cards_line(encoder, "%s%10d", k % 2 ? "          " : "\n", row->ply + 1);
        cards_real(encoder, row->thickness, WIDTH);
        cards_real(encoder, cards_fold_deg(edge + row->angle_deg), WIDTH);
    }
    cards_line(encoder, "\n");
}

static const struct cards_part parts[] = {{NULL, write_head},
                                          {cards_vertices, write_vertex},
                                          {NULL, write_keyword},
                                          {cards_elements, write_element},
                                          {0}};

const struct format format_lsdyna = {
    .name = "lsdyna",
    .media_type = "text/x-lsdyna",
    .about = "LS-DYNA: the mesh as *ELEMENT_SHELL_COMPOSITE, thickness and angle of each layer",
    .exact = "angles to 5e-7 degrees, thicknesses to 6 digits",
    .uses = FORMAT_MAP,
    .elements = true,
    .own = parts,
    .begin = begin,
    .next = cards_next};
