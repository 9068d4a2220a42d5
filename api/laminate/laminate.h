/* SPDX-License-Identifier: MIT */
/*
 * A laminate as it was understood: a stack of plies on one surface, the first on the tool, each of
 * them a drape of its own. Everything lies in the arena it was decoded with.
 *
 * With `offset` nominal ply k is draped on the surface moved by what lies below it and half of
 * itself, h_k = side (sum_(i<k) n_i t_i + n_k t_k / 2) for plies of n layers of the thickness t.
 * Plies whose drapes are the same in every respect share one.
 */
#ifndef API_LAMINATE_LAMINATE_H
#define API_LAMINATE_LAMINATE_H

#include "api/input.h"
#include "api/limits.h"
#include "api/problem.h"
#include "api/request/request.h"
#include "solver/arena.h"
#include "solver/stack.h"

enum { LAMINATE_PLIES_MAX = 1000, LAMINATE_NAME_MAX = 64, LAMINATE_REPEAT_MAX = 10000 };

/* A closed line of points in space. */
struct laminate_loop {
    const struct vec3 *points;
    size_t count;
};

/* Where a ply is: the places of its cloth inside an odd number of the loops, projected on it. As
 * long as it is given by loops in the surface's parameters it has `trims`. */
struct laminate_boundary {
    const struct laminate_loop *loops;
    size_t count; /* 0: everywhere */
    const struct trim_loop *trims;
    size_t trim_count;
};

struct laminate_ply {
    const char *name;         /* not empty, unique */
    struct api_request drape; /* its fabric, start, ...; cavity flexible */
    int repeat;               /* layers, beside drape.fabric.plies */
    double areal_weight;      /* of one layer before shear, kg/m^2; 0: not known */
    struct api_compaction law;
    struct laminate_boundary boundary;
    size_t net; /* which of the laminate's drapes is its own, from 0 in the order of first use */
};

struct laminate {
    struct api_surface surface;
    const struct api_unit *length_unit;
    bool unit_of_surface; /* as in `api_request` */
    struct laminate_ply *plies;
    size_t count;
    struct stack_cavity cavity;
    bool nominal; /* plies lie on each other; else all on the surface */
    int side;     /* 1 or -1 */
    size_t net_count;
    const size_t *net_ply;           /* the first ply of each net */
    char (*net_digest)[API_ID_SIZE]; /* of each net: `api_digest_request` */
};

/* Layers of a ply. */
int laminate_layers(const struct laminate_ply *ply);

/* The drape of ply k (from 0) as a request by itself, whose angle turns about Su x Sv. That of a
 * ply under a rosette without z turns about the normal on the side that the plies lie on. */
struct api_request laminate_drape(const struct laminate *laminate, size_t k);

/*
 * Decodes `input->request`; a surface given by id as `api_decode` does. Returns API_OK,
 * API_MALFORMED_JSON, API_TOO_LARGE, API_INVALID_REQUEST (pointers such as /plies/2/fabric) or
 * API_OUT_OF_MEMORY.
 */
enum api_problem_id laminate_decode(const struct api_input *input, const struct api_limits *limits,
                                    struct arena *arena, struct laminate *laminate,
                                    struct api_problem *problem) STATUS_MUST_USE;

/*
 * Then, with the surface at hand: makes of boundaries in the surface's parameters such in space;
 * lets a ply with a boundary and no start of its own start in the middle of that; and finds out
 * which plies share a drape. API_OK, API_DEGENERATE_SURFACE, API_INVALID_REQUEST or
 * API_OUT_OF_MEMORY.
 */
enum api_problem_id laminate_resolve(struct laminate *laminate, const struct api_limits *limits,
                                     struct arena *arena,
                                     struct api_problem *problem) STATUS_MUST_USE;

/* Copies what is wrong with the drape of ply k (from 0) as what is wrong with the laminate. */
void laminate_fault_of_ply(const struct laminate *laminate, size_t k, const struct api_problem *own,
                           struct api_problem *problem);

/* The laminate as it was understood, in the form that is decoded; NULL without memory. */
const char *laminate_normalise(const struct laminate *laminate, struct arena *arena);

#endif
