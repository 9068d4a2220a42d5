/* SPDX-License-Identifier: MIT */
/*
 * Decks of solvers, text in cards: what their writers share. A format of this kind is a list of
 * sections (`format->own`), each so many items, which are written one after the other.
 *
 * Numbers of elements and vertices are the caller's. Plies are numbered from 1, and ply k is of
 * material k, which is the caller's to define. A bare element is left out, and said.
 */
#ifndef API_FORMAT_DECK_H
#define API_FORMAT_DECK_H

#include "element_frame.h"
#include "encoder.h"

enum {
    CARDS_PLIES_MAX = 200,  /* of one element: an item holds its stack */
    CARDS_ITEM = 48 * 1024, /* bytes of an item at most */
};

/* Its items are 0 .. count - 1; each writes at most CARDS_ITEM bytes to `encoder->piece`. */
struct deck_section {
    size_t (*count)(const struct encoder *encoder); /* NULL: 1 */
    void (*write)(struct encoder *encoder, size_t item);
};

/* `next` of a format whose `own` is an array of sections, ended by one without `write`. */
void deck_next(struct encoder *encoder);

/* The usual counts. */
size_t deck_vertices(const struct encoder *encoder);
size_t deck_elements(const struct encoder *encoder);
size_t deck_plies(const struct encoder *encoder);
/* Every element for every ply: item = ply * elements + element. */
size_t deck_ply_elements(const struct encoder *encoder);

/* Whether the stack can be written at all; else the problem is set: no element has a ply, a
 * thickness is not known, there are too many plies, or an id is larger than `id_max`. */
bool deck_check(const struct encoder *encoder, int32_t id_max, struct api_problem *problem);

/* The same for formats that have one sequence of plies for all elements: refused are stacks of
 * several plies on elements of which some look to one side and some to the other. `*upward`: the
 * plies follow each other along the elements' normals. */
bool deck_check_sides(const struct encoder *encoder, bool *upward, struct api_problem *problem);

/* ---- the stack ---- */

int32_t deck_element_id(const struct map_fields *fields, size_t element);
int32_t deck_vertex_id(const struct map_fields *fields, size_t vertex);
bool deck_is_bare(const struct map_fields *fields, size_t element);

/* How many plies an element has, and the k-th from its bottom, along its own normal. */
size_t deck_layers(const struct map_fields *fields, size_t element);
const struct map_ply_row *deck_layer(const struct map_fields *fields, size_t element, size_t k);

/* The row of a ply at an element, NULL when it is not there. */
const struct map_ply_row *deck_row(const struct map_fields *fields, size_t element, int ply);

/* The frame of an element that has plies. */
struct element_frame deck_frame(const struct map_fields *fields, size_t element);

/* The least thickness that a ply has: what thinning factors refer to. */
double deck_thickness(const struct map_fields *fields, int ply);

/* A fibre's angle between -90 (excluded) and 90: where it points to and from is the same. */
double deck_fold_deg(double angle_deg);

/* ---- text ---- */

/* The head of a deck as comments: the drape, the unit, what `about` says line by line, ended by a
 * NULL, bare elements and warnings; each line behind `mark`. */
void deck_head(struct encoder *encoder, const char *mark, const char *const *about);

/* `printf` to the piece; a line at most. */
void deck_line(struct encoder *encoder, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* Right-aligned in a field: a whole number, nothing, a word, or a real number with a point and as
 * many digits as the field has room for. */
void deck_integer(struct encoder *encoder, int64_t value, int width);
void deck_blank(struct encoder *encoder, int width);
void deck_word(struct encoder *encoder, const char *word, int width);
void deck_real(struct encoder *encoder, double value, int width);

#endif
