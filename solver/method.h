/* SPDX-License-Identifier: MIT */
/* The ways of laying a net that the solver knows. */
#ifndef SOLVER_METHOD_H
#define SOLVER_METHOD_H

/* The fishnet algorithms of the paper's comparison, and the fourth-order one. */
enum drape_method {
    DRAPE_BASIC,    /* yarns between nodes are straight chords of the spacing's length */
    DRAPE_GEODESIC, /* geodesics of the spacing's length */
    DRAPE_MOSAIC,   /* basic on flat triangles: of a tessellation 0.25 spacings fine, or a mesh */
    DRAPE_GIB,      /* arcs of the surface's normal curvature (paper, section 4.1) */
    DRAPE_GIB4      /* gib with deferred correction: fourth order, with an error estimate */
};

/* How gib obtains the yarn tangents at A. */
enum drape_yarn_path {
    DRAPE_PATH_CHORD,     /* the chord projected on the tangent plane: closed form */
    DRAPE_PATH_RELAXATION /* the boundary-value problem of the paper's section 4.3 */
};

#endif
