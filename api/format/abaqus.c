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
#include "stack_groups.h"

enum { DIGITS = 20, SET_ROW = 12 };

static const char mark[] = "**";

static bool begin(struct encoder *encoder, struct api_problem *problem) {
    return stack_groups_begin(encoder, false, problem);
}

static size_t members(const struct encoder *encoder) {
    const struct stack_groups *groups = encoder->state;
    return groups->start[groups->count];
}

static void write_head(struct encoder *encoder, size_t item) {
    static const char *const about[] = {
        "The mesh with a composite *SHELL SECTION for each group of like thicknesses. Layers from "
        "the bottom: thickness, 3 points, MATERIAL_k, the orientation PLY_k, whose 1-direction is "
        "the warp of ply k on each element. The shear between warp and weft is not here.",
        NULL};
    (void)item;
    deck_head(encoder, mark, about);
    deck_line(encoder, "%s %zu groups; of one, thicknesses differ by at most %g %%\n*NODE\n", mark,
              stack_groups_count(encoder), encoder->options.within);
}

static void write_numbers(struct encoder *encoder, int32_t id, const double *values, size_t count) {
    deck_line(encoder, "%d", id);
    for (size_t k = 0; k < count; k++) {
        deck_line(encoder, ", ");
        deck_real(encoder, values[k], DIGITS);
    }
    deck_line(encoder, "\n");
}

static void write_vertex(struct encoder *encoder, size_t item) {
    struct vec3 v = encoder->fields.vertices[item];
    write_numbers(encoder, deck_vertex_id(&encoder->fields, item), (const double[]){v.x, v.y, v.z},
                  3);
}

/* The keyword where the kind of elements changes from one to the next. */
static void write_element(struct encoder *encoder, size_t item) {
    const struct map_fields *fields = &encoder->fields;
    const int32_t *corners = fields->elements[item];
    bool triangle = corners[3] < 0;
    if (item == 0 || triangle != (fields->elements[item - 1][3] < 0))
        deck_line(encoder, "*ELEMENT, TYPE=%s\n", triangle ? "S3" : "S4");
    deck_line(encoder, "%d", deck_element_id(fields, item));
    for (int k = 0; k < 4 && corners[k] >= 0; k++)
        deck_line(encoder, ", %d", deck_vertex_id(fields, (size_t)corners[k]));
    deck_line(encoder, "\n");
}

static void write_table(struct encoder *encoder, size_t item) {
    (void)item;
    deck_line(encoder, "*DISTRIBUTION TABLE, NAME=DIRECTIONS\nCOORD3D, COORD3D\n");
}

/* The first line is what elements have that are not listed. */
static void write_direction(struct encoder *encoder, size_t item) {
    const struct map_fields *fields = &encoder->fields;
    size_t element = item % fields->element_count;
    int ply = (int)(item / fields->element_count);
    const struct map_ply_row *row = deck_row(fields, element, ply);
    if (element == 0)
        deck_line(encoder,
                  "*DISTRIBUTION, NAME=PLY_%d_DIRECTIONS, LOCATION=ELEMENT, TABLE=DIRECTIONS\n"
                  ", 1., 0., 0., 0., 1., 0.\n",
                  ply + 1);
    if (row) {
        struct element_frame frame = deck_frame(fields, element);
        struct vec3 a = element_direction(&frame, row->angle_deg);
        struct vec3 b = vec3_cross(frame.normal, a);
        write_numbers(encoder, deck_element_id(fields, element),
                      (const double[]){a.x, a.y, a.z, b.x, b.y, b.z}, 6);
    }
    if (element + 1 == fields->element_count)
        deck_line(encoder,
                  "*ORIENTATION, NAME=PLY_%d, SYSTEM=RECTANGULAR\nPLY_%d_DIRECTIONS\n3, 0.\n",
                  ply + 1, ply + 1);
}

/* Members in lines of at most SET_ROW numbers. */
static void write_member(struct encoder *encoder, size_t item) {
    const struct stack_groups *groups = encoder->state;
    int32_t element = groups->member[item], group = groups->group[element];
    size_t place = item - groups->start[group];
    if (place == 0)
        deck_line(encoder, "*ELSET, ELSET=STACK_%d\n", group + 1);
    bool last = item + 1 == groups->start[group + 1] || place % SET_ROW == SET_ROW - 1;
    deck_line(encoder, "%d%s", deck_element_id(&encoder->fields, (size_t)element),
              last ? "\n" : ", ");
}

static void write_section(struct encoder *encoder, size_t item) {
    const struct map_fields *fields = &encoder->fields;
    const struct stack_groups *groups = encoder->state;
    size_t element = (size_t)groups->member[groups->start[item]];
    deck_line(encoder, "*SHELL SECTION, COMPOSITE, ELSET=STACK_%zu\n", item + 1);
    for (size_t k = 0; k < deck_layers(fields, element); k++) {
        const struct map_ply_row *row = deck_layer(fields, element, k);
        deck_real(encoder, row->thickness, DIGITS);
        deck_line(encoder, ", 3, MATERIAL_%d, PLY_%d\n", row->ply + 1, row->ply + 1);
    }
}

static const struct deck_section sections[] = {{NULL, write_head},
                                               {deck_vertices, write_vertex},
                                               {deck_elements, write_element},
                                               {NULL, write_table},
                                               {deck_ply_elements, write_direction},
                                               {members, write_member},
                                               {stack_groups_count, write_section},
                                               {0}};

const struct format format_abaqus = {
    .name = "abaqus",
    .media_type = "text/x-abaqus",
    .about = "Abaqus: the mesh, *DISTRIBUTION of each ply's directions, composite *SHELL SECTION",
    .exact = "15 digits; `within` groups thicknesses coarser",
    .uses = FORMAT_MAP,
    .elements = true,
    .own = sections,
    .state_size = sizeof(struct stack_groups),
    .begin = begin,
    .next = deck_next,
    .end = stack_groups_end};
