/* SPDX-License-Identifier: MIT */
/*
 * A laminate as it was understood: a stack of plies on one surface, the first on the tool, each of
 * them a drape of its own. Everything lies in the arena it was decoded with.
 *
 * With `offset` nominal ply k is draped on the surface moved by what lies below it and half of
 * itself, h_k = side (sum_(i<k) n_i t_i + n_k t_k / 2) for plies of n layers of the thickness t.
 * Plies whose drapes are the same in every respect share one.
 *
 * A ply may be divided along splits into pieces, each a drape of the whole part, of which the cloth
 * in its region is kept; or be laid in courses, each a drape as wide as its roll. Once a laminate
 * is resolved, every piece has an entry of its own among `plies`; those of one ply follow each
 * other.
 */
#ifndef API_LAMINATE_LAMINATE_H
#define API_LAMINATE_LAMINATE_H

#include "api/input.h"
#include "api/limits.h"
#include "api/problem.h"
#include "api/request/request.h"
#include "solver/arena.h"
#include "solver/courses.h"
#include "solver/stack.h"

enum { LAMINATE_PLIES_MAX = 1000, LAMINATE_NAME_MAX = 64, LAMINATE_REPEAT_MAX = 10000 };

/* Splits of a ply, pieces between them, and its courses, at the most. */
enum {
    LAMINATE_SPLITS_MAX = 64,
    LAMINATE_PIECES_MAX = 64,
    LAMINATE_COURSES_MAX = COURSES_MAX - 1,
    LAMINATE_SIBLINGS_MAX = COURSES_MAX
};

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

/* At a seam the cloth of both sides goes half the overlap beyond the split; with `over` that of the
 * first, or the last, of the two pieces ends there and lies on the other, which goes the whole of
 * it under that. Or it ends half the gap before the split. */
enum laminate_over { LAMINATE_OVER_NONE, LAMINATE_OVER_FIRST, LAMINATE_OVER_LAST };
struct laminate_seam {
    double overlap, gap; /* 0: none */
    enum laminate_over over;
};

/* The figures of a course, as of `struct course`; names are in `course_figure_names`. */
enum course_figure {
    COURSE_WIDTH,
    COURSE_CUT_LENGTH,
    COURSE_AREA,
    COURSE_NET_AREA,
    COURSE_TRIM_AREA,
    COURSE_COVERAGE, /* share of the part under it, but not under the one beside it */
    COURSE_MEAN_SHEAR,
    COURSE_MAX_SHEAR,
    COURSE_WANTED,
    COURSE_WANTED_MOST,
    COURSE_GAP_LEAST,
    COURSE_GAP_MOST,
    COURSE_GAP_AREA,
    COURSE_OVERLAP_AREA,
    COURSE_STAGGER, /* least distance of its near edge, in space, from such of the nearest ply below
                       that has courses; -1: there is none */
    COURSE_FIGURES
};
extern const char *const course_figure_names[COURSE_FIGURES + 1]; /* then NULL */

/* What is asked for: all of `lay` but its drape. */
struct laminate_courses {
    struct courses_settings lay;
    double stagger; /* each ply with courses but the first is laid back by so much more */
};

struct laminate_piece {
    const char *name;
    struct vec3 at; /* a place in its region; not of a course */
    double figures[COURSE_FIGURES];
    struct api_request drape;
};

/* How a ply is divided: along splits, or into courses, whose drapes are their pieces. Pieces are
 * those of the request, once resolved those of all regions, or all courses. */
struct laminate_pieces {
    const struct laminate_courses *courses; /* NULL: along splits */
    const struct drape_cut_line *splits;    /* lines on the part from edge to edge, or closed */
    size_t split_count;
    struct laminate_seam seam;
    const struct laminate_piece *pieces;
    size_t count;
    struct api_request ply; /* what holds of pieces that do not say it */
};

struct laminate_ply {
    size_t number;                        /* of the ply in the request, from 0 */
    size_t piece;                         /* of the ply, from 0 */
    const struct laminate_pieces *pieces; /* NULL: the ply is of one */
    const char *name;                     /* not empty, unique */
    struct api_request drape;             /* its fabric, start, ...; cavity flexible */
    int repeat;                           /* layers, beside drape.fabric.plies */
    double areal_weight;                  /* of one layer before shear, kg/m^2; 0: not known */
    double price;                         /* of a m^2 of its cloth, in any currency; 0: not known */
    struct api_compaction law;
    struct laminate_boundary boundary;
    size_t net; /* which of the laminate's drapes is its own, from 0 in the order of first use */
};

struct laminate {
    struct api_surface surface;
    const struct api_unit *length_unit;
    struct laminate_ply *plies;
    size_t count;
    size_t ply_count; /* of the request: `count` less the further pieces */
    struct stack_cavity cavity;
    bool nominal; /* plies lie on each other; else all on the surface */
    int side;     /* 1 or -1 */
    size_t net_count;
    const size_t *net_ply;           /* the first ply of each net */
    char (*net_digest)[API_ID_SIZE]; /* of each net: `api_digest_request` */
    char revision[API_ID_SIZE]; /* the digest of all of it, its surface and the solver's version:
                                   what is made of it bears this */
};

/* Layers of a ply. */
int laminate_layers(const struct laminate_ply *ply);

/* Whether the ply is of several pieces between splits. */
bool laminate_is_split(const struct laminate_ply *ply);

/* What to call a ply, or a piece of one: "skin", "skin, left". */
enum { LAMINATE_TITLE_SIZE = 2 * LAMINATE_NAME_MAX + 3 };
void laminate_title(const struct laminate_ply *ply, char title[LAMINATE_TITLE_SIZE]);

/* Whether a split ends where it begins. */
bool laminate_split_closed(const struct drape_cut_line *split);

/* Into how many steps of at most `step` a length is divided, 1 to 1e5. */
size_t laminate_steps(double length, double step);

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
 * Then, with the surface at hand: divides plies into their pieces, each of which starts in the
 * middle of its region unless it says where; lays courses; makes of boundaries in the surface's
 * parameters such in space; lets a ply with a boundary and no start of its own start in the middle
 * of that; and finds out which plies share a drape. API_OK, API_DEGENERATE_SURFACE,
 * API_INVALID_REQUEST or API_OUT_OF_MEMORY.
 */
enum api_problem_id laminate_resolve(struct laminate *laminate, const struct api_limits *limits,
                                     struct arena *arena,
                                     struct api_problem *problem) STATUS_MUST_USE;

/* The part that the laminate is laid on, without any offset. Problems: as `prepared_part_make`. */
struct prepared_part;
enum api_problem_id laminate_part(const struct laminate *laminate, const struct api_limits *limits,
                                  struct arena *arena, struct prepared_part *shape,
                                  struct api_problem *problem) STATUS_MUST_USE;

/* Copies what is wrong with the drape of ply k (from 0) as what is wrong with the laminate. */
void laminate_fault_of_ply(const struct laminate *laminate, size_t k, const struct api_problem *own,
                           struct api_problem *problem);

/* The laminate as it was understood, in the form that is decoded; NULL without memory. */
const char *laminate_normalise(const struct laminate *laminate, struct arena *arena);

#endif
