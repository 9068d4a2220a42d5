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

static const char mark[] = "#";

struct state {
    double thickness; /* of the ply that is being written */
};

static bool begin(struct encoder *encoder, struct api_problem *problem) {
    bool upward;
    if (!deck_check(encoder, INT32_MAX, problem) || !deck_check_sides(encoder, &upward, problem))
        return false;
    if (!encoder->fields.plies->reference)
        api_problem_set(
            problem, API_INVALID_REQUEST,
            "radioss needs reference=x,y,z: the direction that the stack has as VX, VY, "
            "VZ, from which its angles run");
    return problem->id == API_OK;
}

static void write_head(struct encoder *encoder, size_t item) {
    static const char *const about[] = {
        "/DRAPE k is of /PLY k, which has the thickness that stands in its title, the angle 0 and "
        "def_orth 2. Angles run from the VX, VY, VZ of the stack:",
        NULL};
    const struct vec3 *v = encoder->fields.plies->reference;
    (void)item;
    deck_head(encoder, mark, about);
    deck_line(encoder, "%s %.15g %.15g %.15g\n", mark, v->x, v->y, v->z);
}

static void write_drape(struct encoder *encoder, size_t item) {
    const struct map_fields *fields = &encoder->fields;
    struct state *state = encoder->state;
    size_t element = item % fields->element_count;
    int ply = (int)(item / fields->element_count);
    const struct map_ply_row *row = deck_row(fields, element, ply);
    if (element == 0) {
        state->thickness = deck_thickness(fields, ply);
        deck_line(encoder, "/DRAPE/%d\n%.63s, thickness %.15g\n", ply + 1,
                  fields->plies->names[ply], state->thickness);
        deck_line(encoder, "#   Entity Entity_ID            Thinning          thetaDrape\n");
    }
    if (!row)
        return;
    deck_line(encoder, "%-10s%10d", fields->elements[element][3] < 0 ? "SH3N" : "SHELL",
              deck_element_id(fields, element));
    deck_real(encoder, row->thickness / state->thickness, WIDTH);
    deck_real(encoder, deck_fold_deg(row->angle_deg), WIDTH);
    deck_line(encoder, "\n");
}

static const struct deck_section sections[] = {
    {NULL, write_head}, {deck_ply_elements, write_drape}, {0}};

const struct format format_radioss = {.name = "radioss",
                                      .media_type = "text/x-radioss",
                                      .about = "Radioss: a /DRAPE for each ply; needs `reference`",
                                      .exact = "15 digits",
                                      .uses = FORMAT_MAP,
                                      .elements = true,
                                      .own = sections,
                                      .state_size = sizeof(struct state),
                                      .begin = begin,
                                      .next = deck_next};
