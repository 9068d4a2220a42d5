/* SPDX-License-Identifier: MIT */
/* The plies of a stack as they lie flat: each up to the rim of its cloth and within its boundary,
 * the warp along x and the weft along y, from the start of its drape. */
#ifndef API_LAMINATE_FLAT_PLIES_H
#define API_LAMINATE_FLAT_PLIES_H

#include "api/result/columns.h"
#include "api/result/flat_pattern.h"
#include "flat_piece.h"
#include "laminate.h"

enum { LAMINATE_ALL = -1 };

/* One ply's, whose layers are alike, in the laminate's unit, and what lies in it: of a ply with a
 * boundary of its own nothing that its drape has beyond that. */
struct flat_ply {
    struct polygons cut;
    double low[2], high[2];
    struct pattern_notch *notches; /* on the edge of `cut`, places in lengths; malloc'ed */
    size_t notch_count;
    size_t lip_notches; /* the first of them, which are of lips of cuts */
    double area;        /* of one layer, flat; without a boundary the `flat_area` of its drape */
    double covered;     /* share of what it is to cover that has cloth */
    double
        max_shear_deg; /* of the cloth, within a boundary of the cells that are in it or pass it */
    double locked_cells; /* those of them beyond the locking angle; -1: there is none */
    bool partial;        /* less is covered than of a complete drape */
    size_t ply;
    /* Of a piece of a ply: `covered` is of its ply, all pieces together. */
    struct flat_piece *piece; /* NULL: the ply is of one */
    struct polygons cloth;    /* all of its cloth, with what is cut off */
    double region_area;       /* of the cloth in its region, flat */
    double surface;           /* of `cut`, on the part, .. */
    double region_surface;    /* .. and of what of it lies in its region */
    double part_area;         /* of the part */
};

struct flat_plies {
    struct flat_ply *shapes;
    size_t count;
};

/* The shapes of the pieces of the ply that shape `first` is a piece of: as many as the ply has from
 * there on, NULL where one has no net. False where the ply is of one. */
bool flat_plies_siblings(const struct flat_plies *shapes, const struct laminate *laminate,
                         size_t first, const struct flat_ply *siblings[LAMINATE_SIBLINGS_MAX]);

/* Of one ply (from 0) with all its pieces, or of all; plies whose net is NULL have none.
 * API_INVALID_REQUEST (a boundary that cannot be followed), API_INTERNAL, API_OUT_OF_MEMORY. To be
 * freed in any case. */
enum api_problem_id flat_plies_make(const struct laminate *laminate,
                                    const struct api_reader *const *nets, int ply,
                                    struct arena *arena, struct flat_plies *shapes,
                                    struct api_problem *problem) STATUS_MUST_USE;
/* Whether a warning of ply k's drape is one of the ply: not what its drape has beyond the boundary.
 */
bool flat_plies_concerns(const struct laminate *laminate, size_t k,
                         const struct api_warning *warning);

void flat_plies_free(struct flat_plies *shapes);

#endif
