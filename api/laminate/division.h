/* SPDX-License-Identifier: MIT */
/*
 * The regions into which splits divide a part. The part is looked at through small triangles: two
 * that share an edge are in one region unless the way between their middles pierces the curtain
 * along a split (`solver/net/curtain.h`). What a place belongs to is then found from a triangle
 * beside it, on the same side of all curtains.
 */
#ifndef API_LAMINATE_DIVISION_H
#define API_LAMINATE_DIVISION_H

#include "laminate.h"
#include "solver/mesh/mesh.h"
#include "solver/part.h"

enum { DIVISION_NONE = -1 };

struct division_region {
    double area;
    struct vec3 middle; /* a place of the region, next to the mean of its area */
    double depth;       /* how far its triangles' middles are from the splits, at the most */
};

struct division {
    const struct mesh *mesh;
    struct curtain *curtain;
    int32_t *region; /* of each triangle; DIVISION_NONE: cut away, or a sliver */
    struct division_region *regions;
    size_t count;
    size_t fault; /* the split that is wrong */
    struct vec3 at;
};

/* The triangles through which a part is looked at, of one made in `arena`. Problems: as the
 * tessellation has. `size` gets how long their edges are. */
enum api_problem_id division_mesh(const struct drape_part *part, int32_t face, struct arena *arena,
                                  const struct mesh **mesh, double *size,
                                  struct api_problem *problem) STATUS_MUST_USE;

enum division_fault {
    DIVISION_SOUND,
    DIVISION_OFF_PART,
    DIVISION_DIVIDES_NOTHING,
    DIVISION_REPEATED /* it lies on splits before it */
};

/* Divides the part along splits, whose points are at most `reach` off it. False without memory;
 * `fault` says what is wrong with the split division->fault, if anything is, and where. */
bool division_make(const struct drape_part *part, const struct mesh *mesh, double size,
                   double reach, const struct laminate_pieces *pieces, struct arena *arena,
                   struct division *division, enum division_fault *fault);

/* The region of a place on or near the part. */
int32_t division_region_at(const struct division *division, struct vec3 r);

#endif
