/* SPDX-License-Identifier: MIT */
/*
 * Radioss: a /DRAPE for each ply, with each element's thinning factor and its angle from the
 * reference direction, which the caller gives and the stack has as VX, VY, VZ (def_orth = 2). The
 * factor is of the least thickness that the ply has, which is to be its /PLY's.
 * Sources: Altair Radioss 2021 Reference Guide, /DRAPE, /PLY and /STACK
 * (2021.help.altair.com/2021/hwsolvers/rad/topics/solvers/rad); fields as OpenRadioss reads them
 * (hm_cfg_files/config/CFG/radioss2022/TABLE/drape_ply_slice.cfg): 10, 10, 20, 20 characters.
 */
#include "deck.h"

enum { WIDTH = 20 };

static void write_reference(struct encoder *encoder, const struct deck_item *item) {
    const struct vec3 *v = encoder->fields.plies->reference;
    (void)item;
    api_text_format(&encoder->piece, "# %.15g %.15g %.15g\n", v->x, v->y, v->z);
}

static void write_drape_line(struct encoder *encoder, const struct deck_item *item) {
    struct deck_state *state = encoder->state;
    const struct map_ply_row *row = stack_row(&encoder->fields, item->element, item->ply);
    if (item->first) {
        state->thickness = stack_least_thickness(&encoder->fields, item->ply);
        api_text_format(&encoder->piece,
                        "/DRAPE/%d\n%.63s, thickness %.15g\n"
                        "#   Entity Entity_ID            Thinning          thetaDrape\n",
                        item->ply + 1, encoder->fields.plies->names[item->ply], state->thickness);
    }
    if (!row)
        return;
    api_text_format(&encoder->piece, "%-10s%10d", item->corners[3] < 0 ? "SH3N" : "SHELL",
                    item->id);
    deck_real(encoder, row->thickness / state->thickness, WIDTH);
    deck_real(encoder, element_fold_deg(row->angle_deg), WIDTH);
    api_text_raw(&encoder->piece, "\n");
}

/* The origin and the directions of y and z. */
static void write_skew(struct encoder *encoder, const struct deck_axes *axes) {
    const struct vec3 lines[3] = {axes->origin, axes->y, axes->z};
    api_text_format(&encoder->piece, "/SKEW/FIX/%d\nrosette\n", axes->id);
    for (int k = 0; k < 3; k++) {
        deck_write_vector(encoder, lines[k], "", WIDTH);
        api_text_raw(&encoder->piece, "\n");
    }
}

static const struct deck deck = {
    .mark = "#",
    .about = "/DRAPE k is of /PLY k, which has the thickness that stands in its title, the angle 0 "
             "and def_orth 2. Angles run from the VX, VY, VZ of the stack:",
    .id_max = INT32_MAX,
    .rosette = write_skew,
    .one_sequence = true,
    .reference = true,
    .sections = {{DECK_ONCE, write_reference, NULL}, {DECK_PLY_ELEMENTS, write_drape_line, NULL}}};

const struct format format_radioss = {.name = "radioss",
                                      .media_type = "text/x-radioss",
                                      .about = "Radioss: a /DRAPE for each ply; needs `reference`",
                                      .exact = "15 digits",
                                      DECK_FORMAT(deck)};
