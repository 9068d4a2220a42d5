/* SPDX-License-Identifier: MIT */
/*
 * Decks of solvers: text in lines of fixed or free fields. A deck is data, `struct deck`: what must
 * hold for it, what its head says, and sections that are written one after the other, each item by
 * item.
 *
 * Numbers of elements and vertices are the caller's. Plies, or what `plies_as` makes of them, are
 * numbered from 1, and ply k is of material k. Its constants are here where the request has them
 * (`fabric.lamina`); else it is the caller's to define. An element without plies is bare: it is
 * left out, and the head says how many are.
 */
#ifndef API_FORMAT_DECK_H
#define API_FORMAT_DECK_H

#include "encoder.h"
#include "stack.h"
#include "yarn_plies.h"

enum {
    DECK_PLIES_MAX = 200,    /* of one element: an item holds its stack */
    DECK_NUMBERS_MAX = 1000, /* of all: the head lists them */
    DECK_ITEM = 48 * 1024,   /* bytes of an item at most */
    DECK_SECTIONS_MAX = 8
};

/* What the items of a section are. */
enum deck_items {
    DECK_END,          /* there is no such section, and none after it */
    DECK_ONCE,         /* one item */
    DECK_VERTICES,     /* of the mesh */
    DECK_ELEMENTS,     /* of the mesh, bare ones too */
    DECK_STACKS,       /* elements that have plies */
    DECK_PLIES,        /* of the laminate */
    DECK_PLY_ELEMENTS, /* every element for every ply */
    DECK_GROUPS,       /* of like stacks; the element is the first of the group */
    DECK_MEMBERS,      /* elements by group */
    DECK_MIDDLES       /* of edges, of a deck that has them (`deck_state.middles`) */
};

/* A rosette as a coordinate system: its x as it is given, z at right angles to that. */
struct deck_axes {
    int32_t id;                  /* beyond those of elements and vertices */
    struct vec3 origin, x, y, z; /* the directions are unit vectors */
};

struct deck_item {
    size_t number;  /* from 0, in its section */
    size_t element; /* of all that have one, */
    int32_t id;     /* and its id */
    const int32_t *corners;
    size_t layers;    /* how many plies it has */
    int ply;          /* of DECK_PLIES and DECK_PLY_ELEMENTS, from 0 */
    bool first, last; /* of the ply's elements, or of the group's members */
};

/* Each item writes at most DECK_ITEM bytes. */
struct deck_section {
    enum deck_items items;
    void (*write)(struct encoder *encoder, const struct deck_item *item); /* NULL: `text` */
    const char *text;
};

/* How a vertex is written: the name, the number in a field, and x, y, z in fields of `width`, each
 * behind a text. */
struct deck_point {
    const char *name;
    int number_width;
    const char *before[3];
    int width;
};

struct deck {
    const char *mark;  /* before a comment */
    const char *about; /* in the head: what the reader has to know, in paragraphs */
    const char *text;  /* the first line behind the head; NULL: none */
    int32_t id_max;
    enum { DECK_UNGROUPED, DECK_BY_THICKNESS, DECK_BY_STACK } grouping;
    bool one_sequence; /* of plies, for all elements: of several plies none may look to another
                          side than the rest */
    bool reference;    /* needs the caller's direction */
    bool (*begin)(struct encoder *encoder, struct api_problem *problem);    /* NULL: nothing more */
    void (*rosette)(struct encoder *encoder, const struct deck_axes *axes); /* before `text` */
    struct deck_point point;
    struct deck_section sections[DECK_SECTIONS_MAX];
};

/* The state of a format whose `own` is a deck. */
struct deck_state {
    struct yarn_plies layers; /* where they are not the plies of the map */
    struct stack_groups groups;
    bool upward;      /* the plies follow each other along the elements' normals */
    size_t field;     /* on the line of a list that is being written */
    double thickness; /* the least that the ply has that is being written; 0: it is nowhere */
    /* Of a deck with nodes in the middles of edges; all by malloc. */
    int32_t (*middle)[4];      /* of each element's edges, from 0 */
    struct element_edge *edge; /* one of each middle, in their order */
    size_t middles;
    int32_t first_middle; /* the number of middle 0 */
};

/* What a format is beside its name, media type and texts; `deck` is a struct deck. */
#define DECK_FORMAT(deck)                                                                          \
    .uses = FORMAT_MAP, .elements = true, .yarns = true, .own = &(deck),                           \
    .state_size = sizeof(struct deck_state), .begin = deck_begin, .next = deck_next,               \
    .end = deck_end

/* Refused are maps without a ply on an element, without thicknesses, with too many plies, with an
 * id that is too large, and what the deck says. */
bool deck_begin(struct encoder *encoder, struct api_problem *problem);
void deck_next(struct encoder *encoder);
void deck_end(struct encoder *encoder);

/* The constants of a ply's material, from 0, in newtons per square of the mesh's unit; false where
 * they are not known. MAT8 in large fields, of Nastran's kind, writes them, if they are. */
bool deck_lamina(const struct encoder *encoder, int ply, struct lamina *lamina);
void deck_write_mat8(struct encoder *encoder, const struct deck_item *item);

/* A vector of real numbers behind each other, in fields of `width` with `between` before all but
 * the first. */
void deck_write_vector(struct encoder *encoder, struct vec3 vector, const char *between, int width);

/* A rosette as CORD2R in large fields, of Nastran's kind: origin, a point on z, one in the xz
 * plane. */
void deck_write_cord2r(struct encoder *encoder, const struct deck_axes *axes);

/* The numbers that elements and vertices have in the deck. */
int32_t deck_element_id(const struct map_fields *fields, size_t element);
int32_t deck_vertex_id(const struct map_fields *fields, size_t vertex);

/* A vertex, or a point of the deck's own, as `deck.point` says. */
void deck_write_point(struct encoder *encoder, int32_t id, struct vec3 point);
void deck_write_vertex(struct encoder *encoder, const struct deck_item *item);

/* The warp of a ply on an element, and the direction across it: six real numbers, and the end of
 * the line. */
void deck_write_axes(struct encoder *encoder, size_t element, double angle_deg, const char *between,
                     int width);

/* A real number, right-aligned, with a point and as many digits as the field has room for. */
void deck_real(struct encoder *encoder, double value, int width);

#endif
