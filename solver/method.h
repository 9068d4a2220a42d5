/* SPDX-License-Identifier: MIT */
/* The ways of laying a net that the solver knows, and what each needs and does. */
#ifndef SOLVER_METHOD_H
#define SOLVER_METHOD_H

#include <stdbool.h>

/* The fishnet algorithms of the paper's comparison, and the fourth-order one. */
enum drape_method { DRAPE_BASIC, DRAPE_GEODESIC, DRAPE_MOSAIC, DRAPE_GIB, DRAPE_GIB4 };
enum { DRAPE_METHOD_COUNT = DRAPE_GIB4 + 1 };

/* What the yarn between two nodes is taken for. */
enum drape_yarn {
    DRAPE_YARN_CHORD,    /* a straight chord of the spacing's length */
    DRAPE_YARN_GEODESIC, /* a geodesic of the spacing's length */
    DRAPE_YARN_ARC       /* an arc of the surface's normal curvature (paper, section 4.1) */
};

/* How gib obtains the yarn tangents at A. */
enum drape_yarn_path {
    DRAPE_PATH_CHORD,     /* the chord projected on the tangent plane: closed form */
    DRAPE_PATH_RELAXATION /* the boundary-value problem of the paper's section 4.3 */
};

struct drape_method_traits {
    enum drape_yarn yarn;
    bool flat;      /* drapes flat triangles: those of a mesh, or made of the surface */
    bool corrected; /* a second net corrects the first, and tells the error of each node */
    bool on_meshes; /* can drape a mesh */
    double cost;    /* of a node of a surface against gib's, about, measured on free-form parts */
};

extern const struct drape_method_traits drape_method_traits[DRAPE_METHOD_COUNT];

/* As in the contract. */
extern const char *const drape_method_names[DRAPE_METHOD_COUNT];

#endif
