/* SPDX-License-Identifier: MIT */
/*
 * Nastran bulk data: the mesh with the angle of each element's bottom ply as THETA, and a PCOMPG
 * for each group of like stacks, whose angles run from that ply. So the angles of a single ply are
 * its own on every element.
 *
 * Large fields, of 16 characters: a real number has 12 digits at least. THETA is a real number
 * with a point, from side G1-G2; an integer there would be a coordinate system.
 * Source: MSC Nastran Quick Reference Guide (2022.4), entries CQUAD4, CTRIA3, GRID, PCOMPG.
 */
#include "deck.h"
#include "stack_groups.h"

enum { WIDTH = 16 };

static const char mark[] = "$";

static bool begin(struct encoder *encoder, struct api_problem *problem) {
    return stack_groups_begin(encoder, true, problem);
}

static void write_head(struct encoder *encoder, size_t item) {
    static const char *const about[] = {
        "The mesh with THETA of the bottom ply, from side G1-G2, and a PCOMPG for each group of "
        "like "
        "stacks, in place of the mesh's own GRID and shell elements. Plies are of the warp; the "
        "shear between warp and weft is not here.",
        NULL};
    (void)item;
    deck_head(encoder, mark, about);
    deck_line(encoder,
              "%s %zu groups; of one, angles differ by at most %g degrees and thicknesses "
              "by %g %%\n",
              mark, stack_groups_count(encoder), encoder->options.within, encoder->options.within);
}

static void write_vertex(struct encoder *encoder, size_t item) {
    struct vec3 v = encoder->fields.vertices[item];
    deck_line(encoder, "GRID*   %16d%16s", deck_vertex_id(&encoder->fields, item), "");
    deck_real(encoder, v.x, WIDTH);
    deck_real(encoder, v.y, WIDTH);
    deck_line(encoder, "\n*       ");
    deck_real(encoder, v.z, WIDTH);
    deck_line(encoder, "\n");
}

/* The warp of the bottom ply from the first edge, whatever the angles run from. */
static double theta(const struct map_fields *fields, size_t element) {
    struct element_frame frame = deck_frame(fields, element);
    return deck_fold_deg(frame.edge_deg + deck_layer(fields, element, 0)->angle_deg);
}

static void write_element(struct encoder *encoder, size_t item) {
    const struct map_fields *fields = &encoder->fields;
    const struct stack_groups *groups = encoder->state;
    const int32_t *corners = fields->elements[item];
    if (groups->group[item] < 0)
        return;
    deck_line(encoder, "%s%16d%16d", corners[3] < 0 ? "CTRIA3* " : "CQUAD4* ",
              deck_element_id(fields, item), groups->group[item] + 1);
    for (int k = 0; k < 4 && corners[k] >= 0; k++)
        deck_line(encoder, "%s%16d", k == 2 ? "\n*       " : "",
                  deck_vertex_id(fields, (size_t)corners[k]));
    deck_real(encoder, theta(fields, item), WIDTH);
    deck_line(encoder, "\n");
}

/* GPLYID, MID, T, THETA on one line of large fields, SOUT on the next. */
static void write_group(struct encoder *encoder, size_t item) {
    const struct map_fields *fields = &encoder->fields;
    const struct stack_groups *groups = encoder->state;
    size_t element = (size_t)groups->member[groups->start[item]];
    double bottom = deck_layer(fields, element, 0)->angle_deg;
    deck_line(encoder, "PCOMPG* %16zu\n*\n", item + 1);
    for (size_t k = 0; k < deck_layers(fields, element); k++) {
        const struct map_ply_row *row = deck_layer(fields, element, k);
        deck_line(encoder, "*       %16d%16d", row->ply + 1, row->ply + 1);
        deck_real(encoder, row->thickness, WIDTH);
        deck_real(encoder, deck_fold_deg(row->angle_deg - bottom), WIDTH);
        deck_line(encoder, "\n*       %-16s\n", "YES");
    }
}

static const struct deck_section sections[] = {{NULL, write_head},
                                               {deck_vertices, write_vertex},
                                               {deck_elements, write_element},
                                               {stack_groups_count, write_group},
                                               {0}};

const struct format format_nastran = {
    .name = "nastran",
    .media_type = "text/x-nastran",
    .about = "Nastran bulk data: the mesh with THETA, and PCOMPG by groups of like stacks",
    .exact = "12 digits; `within` groups coarser",
    .uses = FORMAT_MAP,
    .elements = true,
    .own = sections,
    .state_size = sizeof(struct stack_groups),
    .begin = begin,
    .next = deck_next,
    .end = stack_groups_end};
