/* SPDX-License-Identifier: MIT */
/*
 * The stiffness of the stack on every element by classical lamination theory (`solver/lamina.h`):
 * A, B and D in the element's frame, whose x is the direction that angles run from and whose z is
 * its own normal, about the middle of the stack. One line of comma-separated values an element.
 *
 * By default the two yarns of a woven ply share its whole thickness, as they are, sheared. With
 * `plies_as` layers are those of a deck: yarns one above the other, or one along the warp, as if it
 * were square.
 */
#include "stack.h"
#include "yarn_plies.h"

#include "encoder.h"

static const char *const parts = "abd", *const entries[LAMINA_ENTRIES] = {"11", "12", "16",
                                                                          "22", "26", "66"};

static bool begin_abd(struct encoder *encoder, struct api_problem *problem) {
    const struct map_plies *plies = encoder->fields.plies;
    if (plies->row_count == 0)
        return !api_problem_set(problem, API_INVALID_REQUEST,
                                "abd describes plies, but none of the %zu elements lies on the "
                                "cloth: check the length unit and the position of the mesh",
                                encoder->fields.element_count);
    if (!plies->thickness)
        return !api_problem_set(
            problem, API_INVALID_REQUEST,
            "abd needs a thickness: give fabric.thickness in the request, or choose csv");
    for (size_t k = 0; k < plies->ply_count; k++)
        if (yarn_plies_kind(plies, (int)k).lamina.e1 == 0)
            return !api_problem_set(problem, API_INVALID_REQUEST,
                                    "abd needs the elastic constants of every ply: give "
                                    "fabric.lamina of %.60s",
                                    plies->names[k]);
    enum format_plies_as as = encoder->options.plies_as;
    if (as != PLIES_AS_YARNS && as != PLIES_AS_WARP)
        return true;
    struct yarn_plies *layers = encoder->state;
    if (!yarn_plies_make(layers, &encoder->fields, as, 0, "abd", problem))
        return false;
    encoder->fields.plies = &layers->plies;
    return true;
}

/* Q of a layer, or of a ply whose yarns share it. */
static void stiffness_of(const struct encoder *encoder, const struct map_ply_row *row,
                         double q[LAMINA_ENTRIES]) {
    const struct yarn_plies *layers = encoder->state;
    if (layers->lamina) {
        lamina_add(&layers->lamina[row->ply], row->angle_deg, 1, q);
        return;
    }
    struct map_ply_kind kind = yarn_plies_kind(encoder->fields.plies, row->ply);
    lamina_add(&kind.lamina, row->angle_deg, kind.warp_share, q);
    if (kind.warp_share < 1)
        lamina_add(&kind.lamina, element_weft_deg(row), 1 - kind.warp_share, q);
}

static struct lamina_abd abd_of(const struct encoder *encoder, size_t element) {
    const struct map_fields *fields = &encoder->fields;
    struct lamina_abd abd = {0};
    double z = 0;
    for (size_t k = 0; k < stack_layers(fields, element); k++)
        z -= stack_layer(fields, element, k)->thickness / 2;
    for (size_t k = 0; k < stack_layers(fields, element); k++) {
        const struct map_ply_row *row = stack_layer(fields, element, k);
        double q[LAMINA_ENTRIES] = {0};
        stiffness_of(encoder, row, q);
        lamina_stack(&abd, q, z, z + row->thickness);
        z += row->thickness;
    }
    return abd;
}

/* N/m, N and N m: thicknesses are in the mesh's unit, moduli in Pa. */
static void next_abd(struct encoder *encoder) {
    enum { ROOM = 20 * ENCODER_VALUE_ROOM, VALUES = 3 * LAMINA_ENTRIES };
    const struct map_fields *fields = &encoder->fields;
    struct api_text *text = &encoder->piece;
    if (!encoder->begun) {
        api_text_raw(text, "id");
        for (int k = 0; k < VALUES; k++)
            api_text_format(text, ",%c%s", parts[k / LAMINA_ENTRIES], entries[k % LAMINA_ENTRIES]);
        api_text_raw(text, "\n");
    }
    encoder->begun = true;
    double metres = fields->unit->metres;
    for (; encoder->row < fields->element_count && text->capacity - text->length > ROOM;
         encoder->row++) {
        struct lamina_abd abd = abd_of(encoder, encoder->row);
        const double *values[] = {abd.a, abd.b, abd.d};
        if (stack_layers(fields, encoder->row) == 0)
            continue;
        api_text_integer(text, fields->ids ? fields->ids[encoder->row] : (int64_t)encoder->row);
        double unit = metres;
        for (int part = 0; part < 3; part++, unit *= metres)
            for (int k = 0; k < LAMINA_ENTRIES; k++) {
                api_text_raw(text, ",");
                api_text_number(text, values[part][k] * unit);
            }
        api_text_raw(text, "\n");
    }
    encoder->ended = encoder->row == fields->element_count;
}

static void end_abd(struct encoder *encoder) {
    yarn_plies_free(encoder->state);
}

const struct format format_abd = {
    .name = "abd",
    .media_type = "text/x-abd",
    .about = "the matrices A, B and D of the stack on each element, by lamination theory",
    .exact = "every bit",
    .uses = FORMAT_MAP,
    .elements = true,
    .yarns = true,
    .state_size = sizeof(struct yarn_plies),
    .begin = begin_abd,
    .next = next_abd,
    .end = end_abd};
