/* SPDX-License-Identifier: MIT */
/*
 * Nastran bulk data: the mesh with the angle of each element's bottom ply as THETA, and a PCOMPG
 * for each group of like stacks, whose angles run from that ply. So the angles of a single ply are
 * its own on every element.
 *
 * Large fields, of 16 characters: a real number has 12 digits at least. THETA is a real number
 * with a point, from side G1-G2; an integer there would be a coordinate system.
 * Source: MSC Nastran Quick Reference Guide (2022.4), entries CORD2R, CQUAD4, CTRIA3, GRID,
 * PCOMPG.
 */
#include "deck.h"

enum { WIDTH = 16 };

/* THETA is the warp of the bottom ply from the first edge, whatever the angles run from. */
static void write_theta_shell(struct encoder *encoder, const struct deck_item *item) {
    const struct map_fields *fields = &encoder->fields;
    const struct deck_state *state = encoder->state;
    struct element_frame frame = stack_frame(fields, item->element);
    double bottom = stack_layer(fields, item->element, 0)->angle_deg;
    api_text_format(&encoder->piece, "%s%16d%16d", item->corners[3] < 0 ? "CTRIA3* " : "CQUAD4* ",
                    item->id, state->groups.group[item->element] + 1);
    for (int k = 0; k < 4 && item->corners[k] >= 0; k++)
        api_text_format(&encoder->piece, "%s%16d", k == 2 ? "\n*       " : "",
                        deck_vertex_id(fields, (size_t)item->corners[k]));
    deck_real(encoder, element_fold_deg(frame.edge_deg + bottom), WIDTH);
    api_text_raw(&encoder->piece, "\n");
}

/* GPLYID, MID, T, THETA on one line of large fields, SOUT on the next. */
static void write_pcompg(struct encoder *encoder, const struct deck_item *item) {
    const struct stack_groups *groups = &((struct deck_state *)encoder->state)->groups;
    api_text_format(&encoder->piece, "PCOMPG* %16zu\n*\n", item->number + 1);
    for (size_t k = groups->first[item->number]; k < groups->first[item->number + 1]; k++) {
        const struct stack_layer *layer = &groups->layer[k];
        api_text_format(&encoder->piece, "*       %16d%16d", layer->ply + 1, layer->ply + 1);
        deck_real(encoder, layer->thickness, WIDTH);
        deck_real(encoder, layer->angle_deg, WIDTH);
        api_text_format(&encoder->piece, "\n*       %-16s\n", "YES");
    }
}

static const struct deck deck = {
    .mark = "$",
    .about =
        "The mesh with THETA of the bottom ply, from side G1-G2, and a PCOMPG for each group of "
        "like stacks, in place of the mesh's own GRID and shell elements.",
    .id_max = INT32_MAX,
    .rosette = deck_write_cord2r,
    .grouping = DECK_BY_STACK,
    .point = {"GRID*   ", WIDTH, {"                ", "", "\n*       "}, WIDTH},
    .sections = {{DECK_VERTICES, deck_write_vertex, NULL},
                 {DECK_STACKS, write_theta_shell, NULL},
                 {DECK_GROUPS, write_pcompg, NULL},
                 {DECK_PLIES, deck_write_mat8, NULL}}};

const struct format format_nastran = {
    .name = "nastran",
    .media_type = "text/x-nastran",
    .about = "Nastran bulk data: the mesh with THETA, and PCOMPG by groups of like stacks",
    .exact = "12 digits; stacks are rounded within `within` (2: degrees, percent)",
    DECK_FORMAT(deck)};
