/* SPDX-License-Identifier: MIT */
/*
 * Abaqus: the mesh, for each ply the directions of its warp on every element as a *DISTRIBUTION
 * that an *ORIENTATION takes, and a composite *SHELL SECTION for each group of like thicknesses,
 * whose layers name these orientations. Directions are vectors of space, so nothing depends on how
 * the solver numbers sides.
 * Sources: Abaqus Keywords Guide, *DISTRIBUTION, *DISTRIBUTION TABLE (docs.software.vt.edu/
 * abaqusv2024/English/SIMACAEKEYRefMap), *ORIENTATION and *SHELL SECTION; Abaqus Analysis Guide,
 * Orientations (abaqus-docs.mit.edu/2017/English/SIMACAEMODRefMap).
 */
#include "deck.h"

enum { WIDTH = 20, SET_ROW = 12 };

/* The keyword where the kind of elements changes from one to the next. */
static void write_s3_or_s4(struct encoder *encoder, const struct deck_item *item) {
    const struct map_fields *fields = &encoder->fields;
    bool triangle = item->corners[3] < 0;
    if (item->element == 0 || triangle != (fields->elements[item->element - 1][3] < 0))
        api_text_format(&encoder->piece, "*ELEMENT, TYPE=%s\n", triangle ? "S3" : "S4");
    api_text_format(&encoder->piece, "%d", item->id);
    for (int k = 0; k < 4 && item->corners[k] >= 0; k++)
        api_text_format(&encoder->piece, ", %d", deck_vertex_id(fields, (size_t)item->corners[k]));
    api_text_raw(&encoder->piece, "\n");
}

/* The first line is what elements have that are not listed. */
static void write_ply_directions(struct encoder *encoder, const struct deck_item *item) {
    struct api_text *text = &encoder->piece;
    const struct map_ply_row *row = stack_row(&encoder->fields, item->element, item->ply);
    if (item->first)
        api_text_format(
            text,
            "*DISTRIBUTION, NAME=PLY_%d_DIRECTIONS, LOCATION=ELEMENT, TABLE=DIRECTIONS\n"
            ", 1., 0., 0., 0., 1., 0.\n",
            item->ply + 1);
    if (row) {
        api_text_format(text, "%d, ", item->id);
        deck_write_axes(encoder, item->element, row->angle_deg, ", ", WIDTH);
    }
    if (item->last)
        api_text_format(text,
                        "*ORIENTATION, NAME=PLY_%d, SYSTEM=RECTANGULAR\nPLY_%d_DIRECTIONS\n3, 0.\n",
                        item->ply + 1, item->ply + 1);
}

/* Members in lines of at most SET_ROW numbers. */
static void write_set_member(struct encoder *encoder, const struct deck_item *item) {
    const struct stack_groups *groups = &((struct deck_state *)encoder->state)->groups;
    int32_t group = groups->group[item->element];
    size_t place = item->number - groups->start[group];
    if (item->first)
        api_text_format(&encoder->piece, "*ELSET, ELSET=STACK_%d\n", group + 1);
    api_text_format(&encoder->piece, "%d%s", item->id,
                    item->last || place % SET_ROW == SET_ROW - 1 ? "\n" : ", ");
}

static void write_group_section(struct encoder *encoder, const struct deck_item *item) {
    const struct stack_groups *groups = &((struct deck_state *)encoder->state)->groups;
    api_text_format(&encoder->piece, "*SHELL SECTION, COMPOSITE, ELSET=STACK_%zu\n",
                    item->number + 1);
    for (size_t k = groups->first[item->number]; k < groups->first[item->number + 1]; k++) {
        int ply = groups->layer[k].ply + 1;
        deck_real(encoder, groups->layer[k].thickness, WIDTH);
        api_text_format(&encoder->piece, ", 3, MATERIAL_%d, PLY_%d\n", ply, ply);
    }
}

/* E1, E2, nu12, G12, G13, G23: across the layer as in it. */
static void write_lamina(struct encoder *encoder, const struct deck_item *item) {
    struct lamina own;
    if (!deck_lamina(encoder, item->ply, &own))
        return;
    const double values[] = {own.e1, own.e2, own.nu12, own.g12, own.g12, own.g12};
    api_text_format(&encoder->piece, "*MATERIAL, NAME=MATERIAL_%d\n*ELASTIC, TYPE=LAMINA\n",
                    item->ply + 1);
    for (size_t k = 0; k < sizeof values / sizeof *values; k++) {
        api_text_raw(&encoder->piece, k ? ", " : "");
        deck_real(encoder, values[k], WIDTH);
    }
    api_text_raw(&encoder->piece, "\n");
}

/* A point on x, one in the xy plane, the origin. */
static void write_abaqus_system(struct encoder *encoder, const struct deck_axes *axes) {
    const struct vec3 points[3] = {vec3_add(axes->origin, axes->x), vec3_add(axes->origin, axes->y),
                                   axes->origin};
    api_text_raw(&encoder->piece, "*ORIENTATION, NAME=ROSETTE, SYSTEM=RECTANGULAR\n");
    for (int k = 0; k < 3; k++) {
        deck_write_vector(encoder, points[k], ", ", WIDTH);
        api_text_raw(&encoder->piece, k < 2 ? ", " : "\n3, 0.\n");
    }
}

static const struct deck deck = {
    .mark = "**",
    .about = "The mesh with a composite *SHELL SECTION for each group of like thicknesses. Layers "
             "from the bottom: thickness, 3 points, MATERIAL_k, the orientation PLY_k, whose "
             "1-direction is the fibre of ply k on each element, of a woven ply the warp.",
    .text = "*NODE\n",
    .id_max = INT32_MAX,
    .rosette = write_abaqus_system,
    .grouping = DECK_BY_THICKNESS,
    .point = {"", 0, {", ", ", ", ", "}, WIDTH},
    .sections = {{DECK_VERTICES, deck_write_vertex, NULL},
                 {DECK_ELEMENTS, write_s3_or_s4, NULL},
                 {DECK_ONCE, NULL, "*DISTRIBUTION TABLE, NAME=DIRECTIONS\nCOORD3D, COORD3D\n"},
                 {DECK_PLY_ELEMENTS, write_ply_directions, NULL},
                 {DECK_MEMBERS, write_set_member, NULL},
                 {DECK_GROUPS, write_group_section, NULL},
                 {DECK_PLIES, write_lamina, NULL}}};

const struct format format_abaqus = {
    .name = "abaqus",
    .media_type = "text/x-abaqus",
    .about = "Abaqus: the mesh, *DISTRIBUTION of each ply's directions, composite *SHELL SECTION",
    .exact = "15 digits; thicknesses are rounded within `within` percent (2)",
    DECK_FORMAT(deck)};
