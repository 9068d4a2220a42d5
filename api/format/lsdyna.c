/* SPDX-License-Identifier: MIT */
/*
 * LS-DYNA: the mesh, its shells as *ELEMENT_SHELL_COMPOSITE with material, thickness and angle of
 * each layer, from the bottom. Angles run from the element's x-axis, N1-N2.
 * Sources: LS-DYNA Keyword User's Manual, *ELEMENT_SHELL; its fields as PyDyna has them
 * (ansys/pydyna, element_shell_composite.py): ids of 8 characters; MID, THICK, B and a blank of 10
 * each, two layers a line. *DEFINE_COORDINATE_SYSTEM as Altair Radioss reads it
 * (2021.help.altair.com). lsdyna.ansys.com/orthotropic-materials: the default x-axis is the 1-2
 * edge.
 */
#include "deck.h"

enum { ID_WIDTH = 8, WIDTH = 10, COORDINATE = 16, SHELL_PART = 1 };

/* A triangle has its third corner twice. */
static void write_composite_shell(struct encoder *encoder, const struct deck_item *item) {
    const struct map_fields *fields = &encoder->fields;
    double edge = stack_frame(fields, item->element).edge_deg;
    api_text_format(&encoder->piece, "%8d%8d", item->id, SHELL_PART);
    for (int k = 0; k < 4; k++) {
        int32_t corner = item->corners[item->corners[k] < 0 ? 2 : k];
        api_text_format(&encoder->piece, "%8d", deck_vertex_id(fields, (size_t)corner));
    }
    for (size_t k = 0; k < item->layers; k++) {
        const struct map_ply_row *row = stack_layer(fields, item->element, k);
        api_text_format(&encoder->piece, "%s%10d", k % 2 ? "          " : "\n", row->ply + 1);
        deck_real(encoder, row->thickness, WIDTH);
        deck_real(encoder, element_fold_deg(edge + row->angle_deg), WIDTH);
    }
    api_text_raw(&encoder->piece, "\n");
}

/* The origin, a point on x, one in the xy plane. */
static void write_lsdyna_system(struct encoder *encoder, const struct deck_axes *axes) {
    api_text_format(&encoder->piece, "*DEFINE_COORDINATE_SYSTEM\n%10d", axes->id);
    deck_write_vector(encoder, axes->origin, "", WIDTH);
    deck_write_vector(encoder, vec3_add(axes->origin, axes->x), "", WIDTH);
    api_text_raw(&encoder->piece, "\n");
    deck_write_vector(encoder, vec3_add(axes->origin, axes->y), "", WIDTH);
    api_text_raw(&encoder->piece, "\n");
}

static const struct deck deck = {
    .mark = "$",
    .about = "The mesh as part 1, in place of its own *NODE and *ELEMENT_SHELL; for *INCLUDE. "
             "Layers from the bottom: material, thickness, angle of the fibre, of a woven ply's "
             "warp, from side N1-N2 (AOPT 0, and no invariant node numbering).",
    .text = "*NODE\n",
    .id_max = 99999999,
    .rosette = write_lsdyna_system,
    .point = {"", ID_WIDTH, {"", "", ""}, COORDINATE},
    .sections = {{DECK_VERTICES, deck_write_vertex, NULL},
                 {DECK_ONCE, NULL, "*ELEMENT_SHELL_COMPOSITE\n"},
                 {DECK_STACKS, write_composite_shell, NULL}}};

const struct format format_lsdyna = {
    .name = "lsdyna",
    .media_type = "text/x-lsdyna",
    .about = "LS-DYNA: the mesh as *ELEMENT_SHELL_COMPOSITE, thickness and angle of each layer",
    .exact = "angles to 5e-7 degrees, thicknesses to 6 digits",
    DECK_FORMAT(deck)};
