/* SPDX-License-Identifier: MIT */
/*
 * Cuts that a net itself asks for. Where cloth shears by more than it may, the nodes beyond the
 * limit lie in regions: ridges of shear that mostly run from an edge of the part, where the shear
 * is greatest, to a place inside from which it grows. A cut along the ridge, its mouth at the edge
 * and its tip where the shear is within the limit, takes the region away. Where the ridge ends
 * before the edge, the mouth is at the nearest one, or where the ridge would meet it: in the corner
 * of a flange, say.
 */
#ifndef API_STUDY_PROPOSAL_H
#define API_STUDY_PROPOSAL_H

#include "part.h"

/* A cut as a search knows it: it goes along the part from its mouth, at an edge, straight to its
 * tip. */
struct study_cut {
    struct vec3 mouth, tip;
};

/* The edge of the part in space: pieces from `from[k]` to `to[k]`. */
struct proposal_edge {
    size_t count;
    struct vec3 *from, *to;
};

/* The edge as the rim of a drape has it, without the lips of cuts, in `arena`. Errors:
 * STATUS_OUT_OF_MEMORY. */
enum status proposal_edge_make(const struct drape_rim *rim, struct arena *arena,
                               struct proposal_edge *edge) STATUS_MUST_USE;

/* The place of the edge nearest to a point; the point itself where there is no edge. */
struct vec3 proposal_edge_nearest(const struct proposal_edge *edge, struct vec3 point);

/* A ridge of shear, from its end next to an edge to that inside. */
struct study_ridge {
    struct vec3 outer, inner;
};

/* Where the mouth of a cut along a ridge is. */
enum proposal_mouth { MOUTH_NEAREST, MOUTH_AHEAD, MOUTHS };

/* The cut along a ridge, its tip at the inner end. */
struct study_cut proposal_cut(const struct study_part *part, const struct proposal_edge *edge,
                              double spacing, const struct study_ridge *ridge,
                              enum proposal_mouth mouth);

/* What cuts are proposed for. */
struct proposal_case {
    const struct study_part *part;
    const struct proposal_edge *edge;
    const struct drape_result *result;
    double limit_deg; /* of the absolute shear */
    bool bare;        /* the cloth ends within the part, .. */
    struct vec3 at;   /* .. here */
    double spacing;   /* the greater one */
};

/* Up to `most` ridges, the region with the greatest shear first; returns how many. Scratch comes
 * from `arena` and is given back. Errors: STATUS_OUT_OF_MEMORY. */
enum status proposal_find(const struct proposal_case *c, struct study_ridge *ridges, size_t most,
                          struct arena *arena, size_t *count) STATUS_MUST_USE;

/* The place of a cut at a share of its way from mouth to tip; beyond 1 behind its tip. */
struct vec3 proposal_place(const struct study_part *part, const struct study_cut *cut,
                           double share);

/* The cut as a drape has it, in `arena`: the places of its chord that are nearest on the part, as
 * few as stay within a hundredth of `spacing` of it. Errors: STATUS_OUT_OF_MEMORY. */
enum status proposal_line(const struct study_part *part, const struct study_cut *cut,
                          double spacing, struct arena *arena,
                          struct drape_cut_line *line) STATUS_MUST_USE;

#endif
