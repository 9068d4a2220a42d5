/* SPDX-License-Identifier: MIT */
/*
 * The cloth as a map from the net's coordinates (p, q), i and j as real numbers, to space: in each
 * cell the tensor product of the cubics through four nodes along each yarn, those of the cell and
 * its neighbours, ghosts among them. Two cells agree on the edge between them. Near rough edges,
 * where differences in space say little, a place is found by its geodesics from the cell's nodes:
 * their directions and lengths between the yarns there, each with the weight that the node has in
 * bilinear interpolation. On developable surfaces that is exact, whatever they fold. On others
 * yarns are no geodesics, but arcs from node to node, by the angle between the edges that meet at a
 * node.
 *
 * Where the surface has no healthy continuation, and on meshes, the net ends up to a spacing short
 * of the edge. There corners that are missing are extrapolated along the yarns, by parabolas
 * through three nodes, or straight on from two; not where the net ended for another reason than
 * the boundary. Where the surface bends away from such a cell, its places are seen from the corners
 * that the net has.
 */
#ifndef SOLVER_RIM_RIM_CLOTH_H
#define SOLVER_RIM_RIM_CLOTH_H

#include "rim_edges.h"

/* A node that places near rough edges are seen from. */
struct rim_node {
    int32_t i, j;
    bool searched, found;
    struct surface_point point;
    bool has_yarn[2][2];    /* by family, to its neighbours of lower and higher index: .. */
    struct vec3 yarn[2][2]; /* .. its yarns there, towards the higher index */
};

/* A corner of a cell that places near rough edges are seen from. */
struct rim_corner {
    int32_t i, j;
    bool searched, found;
    bool blind; /* a search for a geodesic from it failed: they cost as much as twenty logarithms */
    struct surface_point point;
    struct vec3 yarn[2]; /* towards the higher index */
    double turn[2];      /* by how much they turn to the left there, as sines */
};

/* The cell (i, j) and its neighbours, as far as they are on one side of all cuts. */
struct rim_patch {
    int32_t i, j, sight;
    bool made;
    bool known;                  /* it has all four corners, */
    bool extended;               /* not all of them from the net */
    bool rough;                  /* a rough edge is near, or, but on a mesh, it is extended:
                                    differences do not tell its shear, */
    bool smooth;                 /* nor, by rough edges unless the nodes turn evenly, its places */
    struct vec3 r[4][4];         /* [b][a]: node (i + a - 1, j + b - 1); bilinear unless smooth */
    struct rim_corner corner[4]; /* (i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1) as they are asked
                                    for */
};

/* A node beside the tip of a cut, and its yarns towards the higher index. */
struct rim_seer {
    int32_t i, j;
    bool searched, found;
    struct surface_point point;
    struct vec3 yarn[2];
};

enum { RIM_SEERS = 8 }; /* so many across are kept */

struct rim_cloth {
    struct march *march;
    struct net_view view;      /* of the march's net */
    struct net **beyond;       /* by sight: corners that were extrapolated, as ghosts */
    int32_t sight;             /* what is looked at: places on one side of all cuts, .. */
    struct surface_point eye;  /* .. that of this one, if .. */
    bool guarded;              /* .. a cut is near, so that nodes may be beyond it */
    struct rim_patch *patches; /* those looked at last, that of a cell at a place of its own */
    struct rim_patch *patch;   /* the last of all */
    struct rim_node *nodes;    /* corners of patches, as patches are kept */
    bool at_tip;               /* the tip of a cut is near: */
    struct rim_seer seers[RIM_SEERS * RIM_SEERS]; /* nodes there, as they are asked for */
    bool failed;                                  /* no memory */
};

/* A point of the cloth. */
struct rim_cloth_point {
    double p, q;
    struct vec3 r;
    struct vec3 along[2]; /* its derivatives by p and q */
    bool smooth, rough;   /* as of its patch */
    bool seen;            /* found along the surface from the cell's nodes, not in space alone */
};

/* Of a rim with so many sights (`rim_edges.h`). Errors: STATUS_OUT_OF_MEMORY. */
enum status rim_cloth_make(struct march *march, int32_t sights,
                           struct rim_cloth *cloth) STATUS_MUST_USE;

/* From now on the cloth is looked at from a place beside the rim, one of this sight: what lies
 * beyond a cut is not seen. */
void rim_cloth_look(struct rim_cloth *cloth, int32_t sight, struct vec3 eye);

/* Whether a node of the net is seen. */
bool rim_cloth_sees(const struct rim_cloth *cloth, const struct net_node *node);

/* The patch at the cell (i, j), which is there until another one is asked for. */
const struct rim_patch *rim_cloth_patch(struct rim_cloth *cloth, int32_t i, int32_t j);

/* Lagrange's cubics on -1, 0, 1, 2 at t, and their derivatives. */
void rim_cloth_cubics(double t, double of[4], double by[4]);

/* The point at (p, q), which may lie a little outside the patch. */
void rim_patch_point(const struct rim_patch *patch, double p, double q,
                     struct rim_cloth_point *place);

/* The point of the cloth nearest to a point of an edge, from `place->p` and `q`, near which it is:
 * it minimises |X(p, q) - r| by Gauss and Newton. False when there is no cloth. */
bool rim_cloth_find(struct rim_cloth *cloth, const struct rim_edge_point *spot,
                    struct rim_cloth_point *place);

/* The place of the cloth that is the place `to` of the part, from about where it is, to rounding
 * where the cloth is flat and its edges are geodesics: by the geodesic from the nearest node that
 * is seen, between that one's yarns (rim_seers.c). False, with `place` as it was, where there is
 * none, and on meshes. */
bool rim_cloth_see_well(struct rim_cloth *cloth, const struct surface_point *to,
                        struct rim_cloth_point *place);

/* The components (a, b) for which a along[0] + b along[1] is nearest to `step`; false where the two
 * are nearly parallel. */
bool rim_cloth_components(const struct vec3 along[2], struct vec3 step, double ab[2]);

#endif
