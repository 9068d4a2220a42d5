/* SPDX-License-Identifier: MIT */
/*
 * CalculiX: the mesh as quadratic shells, S6 and S8R, which alone take composite sections there,
 * with nodes in the middles of edges; for each element an *ORIENTATION of every layer and a
 * composite *SHELL SECTION. (Orientations by *DISTRIBUTION are accepted in composite sections by
 * CalculiX 2.20, and ignored.)
 * Sources: CalculiX CrunchiX User's Manual, *ORIENTATION (ccx.openaircraft.com/ccx-doc), six- and
 * eight-node shell elements (www.openaircraft.com/ccx-doc/ccx/node40.html, node41.html); *SHELL
 * SECTION as ccx 2.20 reads it, which a test runs.
 */
#include "deck.h"
#include <stdlib.h>

enum { DIGITS = 20, EDGES = 4 };

static const char mark[] = "**";

struct edge {
    int32_t a, b;            /* vertices, a < b */
    int32_t element, number; /* whose edge it is */
};

struct state {
    int32_t (*middle)[EDGES]; /* of each element's edges, from 0 */
    struct edge *edge;        /* one of each middle, in their order */
    size_t middles;
    int32_t first; /* the number of middle 0 */
};

/* ---- middles ---- */

static int compare(const void *x, const void *y) {
    const struct edge *p = x, *q = y;
    return p->a != q->a ? (p->a > q->a) - (p->a < q->a) : (p->b > q->b) - (p->b < q->b);
}

static size_t list_edges(const struct map_fields *fields, struct edge *edges) {
    size_t count = 0;
    for (size_t e = 0; e < fields->element_count; e++) {
        const int32_t *corners = fields->elements[e];
        int sides = corners[3] < 0 ? 3 : 4;
        for (int k = 0; k < sides && !deck_is_bare(fields, e); k++) {
            int32_t p = corners[k], q = corners[(k + 1) % sides];
            edges[count++] = (struct edge){p < q ? p : q, p < q ? q : p, (int32_t)e, k};
        }
    }
    return count;
}

/* Edges between the same vertices share their middle. */
static void number_middles(struct state *state, size_t count) {
    qsort(state->edge, count, sizeof *state->edge, compare);
    for (size_t k = 0; k < count; k++) {
        struct edge edge = state->edge[k];
        bool same = state->middles > 0 && compare(&edge, &state->edge[state->middles - 1]) == 0;
        if (!same)
            state->edge[state->middles++] = edge;
        state->middle[edge.element][edge.number] = (int32_t)state->middles - 1;
    }
}

static bool make_middles(struct state *state, const struct map_fields *fields) {
    size_t elements = fields->element_count;
    state->middle = malloc(elements * sizeof *state->middle);
    state->edge = malloc(elements * EDGES * sizeof *state->edge);
    if (!state->middle || !state->edge)
        return false;
    number_middles(state, list_edges(fields, state->edge));
    for (size_t k = 0; k < fields->vertex_count; k++)
        if (deck_vertex_id(fields, k) >= state->first)
            state->first = deck_vertex_id(fields, k) + 1;
    return true;
}

static bool begin(struct encoder *encoder, struct api_problem *problem) {
    struct state *state = encoder->state;
    if (!deck_check(encoder, INT32_MAX / 2, problem))
        return false;
    if (!make_middles(state, &encoder->fields))
        api_problem_set(problem, API_OUT_OF_MEMORY, "no memory for the middles of edges");
    return problem->id == API_OK;
}

static void end(struct encoder *encoder) {
    struct state *state = encoder->state;
    free(state->middle);
    free(state->edge);
}

static size_t middles(const struct encoder *encoder) {
    return ((const struct state *)encoder->state)->middles;
}

/* ---- the deck ---- */

static void write_head(struct encoder *encoder, size_t item) {
    static const char *const about[] = {
        "The mesh with nodes in the middles of edges, numbered behind its own, and a composite "
        "*SHELL SECTION for each element: thickness, MATERIAL_k, the direction of the warp of ply "
        "k. "
        "For *INCLUDE. The shear between warp and weft is not here.",
        NULL};
    (void)item;
    deck_head(encoder, mark, about);
    deck_line(encoder, "*NODE, NSET=DRAPED\n");
}

static void write_point(struct encoder *encoder, const char *before, struct vec3 v) {
    deck_line(encoder, "%s", before);
    deck_real(encoder, v.x, DIGITS);
    deck_line(encoder, ",");
    deck_real(encoder, v.y, DIGITS);
    deck_line(encoder, ",");
    deck_real(encoder, v.z, DIGITS);
}

static void write_node(struct encoder *encoder, int32_t id, struct vec3 v) {
    deck_line(encoder, "%d", id);
    write_point(encoder, ",", v);
    deck_line(encoder, "\n");
}

static void write_vertex(struct encoder *encoder, size_t item) {
    write_node(encoder, deck_vertex_id(&encoder->fields, item), encoder->fields.vertices[item]);
}

static void write_middle(struct encoder *encoder, size_t item) {
    const struct state *state = encoder->state;
    const struct vec3 *v = encoder->fields.vertices;
    const struct edge *edge = &state->edge[item];
    write_node(encoder, state->first + (int32_t)item,
               vec3_scale(0.5, vec3_add(v[edge->a], v[edge->b])));
}

static void write_element(struct encoder *encoder, size_t item) {
    const struct map_fields *fields = &encoder->fields;
    const struct state *state = encoder->state;
    const int32_t *corners = fields->elements[item];
    int sides = corners[3] < 0 ? 3 : 4;
    int32_t id = deck_element_id(fields, item);
    if (deck_is_bare(fields, item))
        return;
    deck_line(encoder, "*ELEMENT, TYPE=%s, ELSET=E%d\n%d", sides == 3 ? "S6" : "S8R", id, id);
    for (int k = 0; k < sides; k++)
        deck_line(encoder, ",%d", deck_vertex_id(fields, (size_t)corners[k]));
    for (int k = 0; k < sides; k++)
        deck_line(encoder, ",%d", state->first + state->middle[item][k]);
    deck_line(encoder, "\n");
}

static void write_section(struct encoder *encoder, size_t item) {
    const struct map_fields *fields = &encoder->fields;
    int32_t id = deck_element_id(fields, item);
    size_t layers = deck_layers(fields, item);
    if (layers == 0)
        return;
    struct element_frame frame = deck_frame(fields, item);
    for (size_t k = 0; k < layers; k++) {
        const struct map_ply_row *row = deck_layer(fields, item, k);
        struct vec3 a = element_direction(&frame, row->angle_deg);
        deck_line(encoder, "*ORIENTATION, NAME=E%d_%d\n", id, row->ply + 1);
        write_point(encoder, "", a);
        write_point(encoder, ",", vec3_cross(frame.normal, a));
        deck_line(encoder, "\n");
    }
    deck_line(encoder, "*SHELL SECTION, COMPOSITE, ELSET=E%d\n", id);
    for (size_t k = 0; k < layers; k++) {
        const struct map_ply_row *row = deck_layer(fields, item, k);
        deck_real(encoder, row->thickness, DIGITS);
        deck_line(encoder, ",,MATERIAL_%d,E%d_%d\n", row->ply + 1, id, row->ply + 1);
    }
}

static const struct deck_section sections[] = {{NULL, write_head},
                                               {deck_vertices, write_vertex},
                                               {middles, write_middle},
                                               {deck_elements, write_element},
                                               {deck_elements, write_section},
                                               {0}};

const struct format format_calculix = {
    .name = "calculix",
    .media_type = "text/x-calculix",
    .about = "CalculiX: the mesh as S6 and S8R, a composite *SHELL SECTION for each element",
    .exact = "15 digits",
    .uses = FORMAT_MAP,
    .elements = true,
    .own = sections,
    .state_size = sizeof(struct state),
    .begin = begin,
    .next = deck_next,
    .end = end};
