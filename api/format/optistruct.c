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

static const char mark[] = "$";

struct state {
    bool upward;
    size_t field;     /* on the line of a list that is being written */
    double thickness; /* of the ply that is being written */
};

static bool begin(struct encoder *encoder, struct api_problem *problem) {
    struct state *state = encoder->state;
    return deck_check(encoder, INT32_MAX, problem) &&
           deck_check_sides(encoder, &state->upward, problem);
}

static void write_head(struct encoder *encoder, size_t item) {
    static const char *const about[] = {
        "Plies for elements whose property is a PCOMPP and whose material x-axis is side 1-2, as "
        "it "
        "is without THETA or MCID; with a direction of the caller's, the system with that x-axis. "
        "DRAPE k, SET k and PLY k are of ply k; its T is the least on the mesh, times the thinning "
        "factor of DRAPE that of the element.",
        "The shear between warp and weft is not here.", NULL};
    (void)item;
    deck_head(encoder, mark, about);
}

/* The next field of a list, four to a line behind the first. */
static void list(struct encoder *encoder, int64_t id) {
    struct state *state = encoder->state;
    deck_line(encoder, "%s%16lld", state->field++ % ROW ? "" : "\n*       ", (long long)id);
}

static void write_drape(struct encoder *encoder, size_t item) {
    const struct map_fields *fields = &encoder->fields;
    struct state *state = encoder->state;
    size_t element = item % fields->element_count;
    int ply = (int)(item / fields->element_count);
    const struct map_ply_row *row = deck_row(fields, element, ply);
    if (element == 0) {
        state->thickness = deck_thickness(fields, ply);
        deck_line(encoder, "DRAPE*  %16d\n*\n", ply + 1);
    }
    if (!row)
        return;
    deck_line(encoder, "*       %-16s%16d", "ELEM", deck_element_id(fields, element));
    deck_real(encoder, row->thickness / state->thickness, WIDTH);
    deck_real(encoder, deck_fold_deg(row->angle_deg), WIDTH);
    deck_line(encoder, "\n*\n");
}

static void write_set(struct encoder *encoder, size_t item) {
    const struct map_fields *fields = &encoder->fields;
    struct state *state = encoder->state;
    size_t element = item % fields->element_count;
    int ply = (int)(item / fields->element_count);
    if (element == 0) {
        deck_line(encoder, "SET*    %16d%-16s%-16s\n*", ply + 1, "ELEM", "LIST");
        state->field = 0;
    }
    if (deck_row(fields, element, ply))
        list(encoder, deck_element_id(fields, element));
    if (element + 1 == fields->element_count)
        deck_line(encoder, "\n");
}

/* ID MID T THETA, SOUT TMANUF DID; ESID1. */
static void write_ply(struct encoder *encoder, size_t item) {
    int ply = (int)item;
    double thickness = deck_thickness(&encoder->fields, ply);
    if (thickness == 0)
        return;
    deck_line(encoder, "PLY*    %16d%16d", ply + 1, ply + 1);
    deck_real(encoder, thickness, WIDTH);
    deck_line(encoder, "%16s\n*       %-16s%16s%16d\n*       %16d\n*\n", "0.", "YES", "", ply + 1,
              ply + 1);
}

/* ID LAM PLYID1 ..: from the bottom, along the elements' normals. */
static void write_stack(struct encoder *encoder, size_t item) {
    struct state *state = encoder->state;
    int count = (int)deck_plies(encoder);
    (void)item;
    deck_line(encoder, "STACK*  %16d%16s", 1, "");
    state->field = 2;
    for (int k = 0; k < count; k++) {
        int ply = state->upward ? k : count - 1 - k;
        if (deck_thickness(&encoder->fields, ply) > 0)
            list(encoder, ply + 1);
    }
    deck_line(encoder, "\n");
}

static const struct deck_section sections[] = {{NULL, write_head},
                                               {deck_ply_elements, write_drape},
                                               {deck_ply_elements, write_set},
                                               {deck_plies, write_ply},
                                               {NULL, write_stack},
                                               {0}};

const struct format format_optistruct = {
    .name = "optistruct",
    .media_type = "text/x-optistruct",
    .about = "OptiStruct: DRAPE, SET and PLY of each ply, and their STACK",
    .exact = "12 digits",
    .uses = FORMAT_MAP,
    .elements = true,
    .own = sections,
    .state_size = sizeof(struct state),
    .begin = begin,
    .next = deck_next};
