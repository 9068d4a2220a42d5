/* SPDX-License-Identifier: MIT */
/*
 * Decks of solvers, text in cards: what their writers share. A format of this kind is a list of
 * parts (`format->own`), each so many items, which are written one after the other.
 *
 * Numbers of elements and vertices are the caller's. Plies are numbered from 1, and ply k is of
 * material k, which is the caller's to define. A bare element is left out, and said.
 */
#ifndef API_FORMAT_CARDS_H
#define API_FORMAT_CARDS_H

#include "element.h"
#include "encoder.h"

enum {
    CARDS_PLIES_MAX = 200,  /* of one element: an item holds its stack */
    CARDS_ITEM = 48 * 1024, /* bytes of an item at most */
};

/* Its items are 0 .. count - 1; each writes at most CARDS_ITEM bytes to `encoder->piece`. */
struct cards_part {
    size_t (*count)(const struct encoder *encoder); /* NULL: 1 */
    void (*write)(struct encoder *encoder, size_t item);
};

/* `next` of a format whose `own` is an array of parts, ended by one without `write`. */
void cards_next(struct encoder *encoder);

/* The usual counts. */
size_t cards_vertices(const struct encoder *encoder);
size_t cards_elements(const struct encoder *encoder);
size_t cards_plies(const struct encoder *encoder);
/* Every element for every ply: item = ply * elements + element. */
size_t cards_places(const struct encoder *encoder);

/* Whether the stack can be written at all; else the problem is set: no element has a ply, a
 * thickness is not known, there are too many plies, or an id is larger than `id_max`. */
bool cards_check(const struct encoder *encoder, int32_t id_max, struct api_problem *problem);

/* The same for formats that have one sequence of plies for all elements: refused are stacks of
 * several plies on elements of which some look to one side and some to the other. `*upward`: the
 * plies follow each other along the elements' normals. */
bool cards_check_sides(const struct encoder *encoder, bool *upward, struct api_problem *problem);

/* ---- the stack ---- */

int32_t cards_element_id(const struct map_fields *fields, size_t element);
int32_t cards_vertex_id(const struct map_fields *fields, size_t vertex);
bool cards_is_bare(const struct map_fields *fields, size_t element);

/* How many plies an element has, and the k-th from its bottom, along its own normal. */
size_t cards_layers(const struct map_fields *fields, size_t element);
const struct map_ply_row *cards_layer(const struct map_fields *fields, size_t element, size_t k);

/* The row of a ply at an element, NULL when it is not there. */
const struct map_ply_row *cards_row(const struct map_fields *fields, size_t element, int ply);

/* The frame of an element that has plies. */
struct element_frame cards_frame(const struct map_fields *fields, size_t element);

/* The least thickness that a ply has: what thinning factors refer to. */
double cards_thickness(const struct map_fields *fields, int ply);

/* A fibre's angle between -90 (excluded) and 90: where it points to and from is the same. */
double cards_fold_deg(double angle_deg);

/* ---- text ---- */

/* The head of a deck as comments: the drape, the unit, what `about` says line by line, ended by a
 * NULL, bare elements and warnings; each line behind `mark`. */
void cards_head(struct encoder *encoder, const char *mark, const char *const *about);

/* `printf` to the piece; a line at most. */
void cards_line(struct encoder *encoder, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* Right-aligned in a field: a whole number, nothing, a word, or a real number with a point and as
 * many digits as the field has room for. */
void cards_integer(struct encoder *encoder, int64_t value, int width);
void cards_blank(struct encoder *encoder, int width);
void cards_word(struct encoder *encoder, const char *word, int width);
void cards_real(struct encoder *encoder, double value, int width);

#endif
