/* SPDX-License-Identifier: MIT */
/*
 * A table for a three-dimensional look-up table of ACP: at the middle of each element its place,
 * and of each ply the directions of warp and weft, projected on the element, and the thickness.
 * Directions are vectors of space, so that nothing depends on how angles are counted. Where a ply
 * is not there its fields are empty, which numpy reads as NaN.
 *
 * The file is comma-separated values for a script: the columns of a LookUpTable3D, `Location` and
 * columns of directions (N x 3) and of scalars (N), are set from arrays (github.com/ansys/pyacp,
 * src/ansys/acp/core/_tree_objects/lookup_table_3d.py and its tests).
 */
#include "encoder.h"
#include "stack.h"

enum { ACP_PLIES_MAX = 200, ROOM = (7 * ACP_PLIES_MAX + 4) * ENCODER_VALUE_ROOM };

static bool begin_acp(struct encoder *encoder, struct api_problem *problem) {
    const struct map_plies *plies = encoder->fields.plies;
    if (plies->row_count == 0)
        return !api_problem_set(problem, API_INVALID_REQUEST,
                                "acp describes plies, but none of the %zu elements lies on the "
                                "cloth: check the length unit and the position of the mesh",
                                encoder->fields.element_count);
    if (plies->ply_count > ACP_PLIES_MAX)
        return !api_problem_set(problem, API_TOO_LARGE,
                                "acp can hold at most %d plies; csv has a row for each",
                                ACP_PLIES_MAX);
    return true;
}

static void write_names(struct encoder *encoder) {
    const struct map_plies *plies = encoder->fields.plies;
    api_text_raw(&encoder->piece, "x,y,z");
    for (size_t k = 1; k <= plies->ply_count; k++) {
        for (int weft = 0; weft < 2; weft++)
            for (const char *axis = "xyz"; *axis; axis++)
                api_text_format(&encoder->piece, ",%s_%zu_%c", weft ? "weft" : "warp", k, *axis);
        if (plies->thickness)
            api_text_format(&encoder->piece, ",thickness_%zu", k);
    }
    api_text_raw(&encoder->piece, "\n");
}

static void write_components(struct encoder *encoder, struct vec3 v) {
    const double values[] = {v.x, v.y, v.z};
    for (int k = 0; k < 3; k++) {
        api_text_raw(&encoder->piece, k ? "," : "");
        api_text_number(&encoder->piece, values[k]);
    }
}

static void next_acp(struct encoder *encoder) {
    const struct map_fields *fields = &encoder->fields;
    const struct map_plies *plies = fields->plies;
    struct api_text *text = &encoder->piece;
    if (!encoder->begun)
        write_names(encoder);
    encoder->begun = true;
    for (; encoder->row < fields->element_count && text->capacity - text->length > ROOM;
         encoder->row++) {
        size_t e = encoder->row;
        if (stack_layers(fields, e) == 0)
            continue;
        struct element_frame frame = stack_frame(fields, e);
        write_components(encoder, element_middle(fields->vertices, fields->elements[e]));
        for (int k = 0; k < (int)plies->ply_count; k++) {
            const struct map_ply_row *row = stack_row(fields, e, k);
            api_text_raw(text, row ? "," : ",,,,,,");
            if (row) {
                write_components(encoder, element_direction(&frame, row->angle_deg));
                api_text_raw(text, ",");
                write_components(encoder, element_direction(&frame, element_weft_deg(row)));
            }
            api_text_raw(text, plies->thickness ? "," : "");
            if (row && plies->thickness)
                api_text_number(text, row->thickness);
        }
        api_text_raw(text, "\n");
    }
    encoder->ended = encoder->row == fields->element_count;
}

const struct format format_acp = {
    .name = "acp",
    .media_type = "text/x-acp",
    .about = "a look-up table for ACP: places, directions of warp and weft, thickness of each ply",
    .exact = "every bit",
    .uses = FORMAT_MAP,
    .elements = true,
    .begin = begin_acp,
    .next = next_acp};
