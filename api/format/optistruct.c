/* SPDX-License-Identifier: MIT */
/*
 * OptiStruct: for each ply a DRAPE, a SET of its elements and a PLY, and one STACK. The ply's own
 * angle is 0, its own thickness the least that it has; DRAPE gives each element's thinning factor
 * and angle from there. Large fields, of 16 characters.
 * Source: Altair OptiStruct 2021 Reference Guide, Bulk Data Entries DRAPE, PLY, SET, STACK
 * (2021.help.altair.com/2021/hwsolvers/os/topics/solvers/os).
 */
#include "deck.h"

enum { WIDTH = 16, ROW = 4 };

static void write_drape_entry(struct encoder *encoder, const struct deck_item *item) {
    struct deck_state *state = encoder->state;
    const struct map_ply_row *row = stack_row(&encoder->fields, item->element, item->ply);
    if (item->first) {
        state->thickness = stack_least_thickness(&encoder->fields, item->ply);
        api_text_format(&encoder->piece, "DRAPE*  %16d\n*\n", item->ply + 1);
    }
    if (!row)
        return;
    api_text_format(&encoder->piece, "*       %-16s%16d", "ELEM", item->id);
    deck_real(encoder, row->thickness / state->thickness, WIDTH);
    deck_real(encoder, element_fold_deg(row->angle_deg), WIDTH);
    api_text_raw(&encoder->piece, "\n*\n");
}

/* The next number of a list, four to a line behind the first. */
static void list_id(struct encoder *encoder, int32_t id) {
    struct deck_state *state = encoder->state;
    api_text_format(&encoder->piece, "%s%16d", state->field++ % ROW ? "" : "\n*       ", id);
}

static void write_set(struct encoder *encoder, const struct deck_item *item) {
    struct deck_state *state = encoder->state;
    if (item->first) {
        api_text_format(&encoder->piece, "SET*    %16d%-16s%-16s\n*", item->ply + 1, "ELEM",
                        "LIST");
        state->field = 0;
    }
    if (stack_row(&encoder->fields, item->element, item->ply))
        list_id(encoder, item->id);
    if (item->last)
        api_text_raw(&encoder->piece, "\n");
}

/* ID MID T THETA, SOUT TMANUF DID; ESID1. */
static void write_ply_entry(struct encoder *encoder, const struct deck_item *item) {
    int number = item->ply + 1;
    double thickness = stack_least_thickness(&encoder->fields, item->ply);
    if (thickness == 0)
        return;
    api_text_format(&encoder->piece, "PLY*    %16d%16d", number, number);
    deck_real(encoder, thickness, WIDTH);
    api_text_format(&encoder->piece, "%16s\n*       %-16s%16s%16d\n*       %16d\n*\n", "0.", "YES",
                    "", number, number);
}

/* ID LAM PLYID1 ..: from the bottom, along the elements' normals. */
static void write_stack_entry(struct encoder *encoder, const struct deck_item *item) {
    struct deck_state *state = encoder->state;
    int count = (int)encoder->fields.plies->ply_count;
    (void)item;
    api_text_format(&encoder->piece, "STACK*  %16d%16s", 1, "");
    state->field = 2;
    for (int k = 0; k < count; k++) {
        int ply = state->upward ? k : count - 1 - k;
        if (stack_least_thickness(&encoder->fields, ply) > 0)
            list_id(encoder, ply + 1);
    }
    api_text_raw(&encoder->piece, "\n");
}

static const struct deck deck = {
    .mark = "$",
    .about = "Plies for elements whose property is a PCOMPP and whose material x-axis is side 1-2, "
             "as it is without THETA or MCID; with a direction of the caller's, the system with "
             "that x-axis. DRAPE k, SET k and PLY k are of ply k; its T is the least on the mesh, "
             "times the thinning factor of DRAPE that of the element.",
    .id_max = INT32_MAX,
    .rosette = deck_write_cord2r,
    .one_sequence = true,
    .sections = {{DECK_PLY_ELEMENTS, write_drape_entry, NULL},
                 {DECK_PLY_ELEMENTS, write_set, NULL},
                 {DECK_PLIES, write_ply_entry, NULL},
                 {DECK_ONCE, write_stack_entry, NULL},
                 {DECK_PLIES, deck_write_mat8, NULL}}};

const struct format format_optistruct = {
    .name = "optistruct",
    .media_type = "text/x-optistruct",
    .about = "OptiStruct: DRAPE, SET and PLY of each ply, and their STACK",
    .exact = "12 digits",
    DECK_FORMAT(deck)};
