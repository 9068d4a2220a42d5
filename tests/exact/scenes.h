/* SPDX-License-Identifier: MIT */
/*
 * Surfaces with a start, a direction, quadrant sides and the exact net: what the accuracy tests are
 * rows over. A scene is draped with N cells along warp: spacing[0] = side / N, spacing[1] = aspect
 * times that, |i|, |j| <= N.
 */
#ifndef DRAPE_TESTS_SCENES_H
#define DRAPE_TESTS_SCENES_H

#include "measure.h"

#define SCENE_LIST(X)                                                                              \
    X(SPHERE, "sphere R=50")                   /* stereographic, L = 30 */                         \
    X(SPHERE_PATCH, "sphere lat/long patch")   /* moved, oblique */                                \
    X(SPHERE_FULL, "sphere of revolution")     /* closed in u, poles; across the seam */           \
    X(SPHERE_UNEQUAL, "sphere, weft 0.6 warp") /* unequal spacing */                               \
    X(SPHERE_EDGE, "sphere, start on edge")    /* both generators point inwards; by point */       \
    X(SPHERE_SHEARED, "sphere, pre-shear 20")                                                      \
    X(SADDLE, "saddle")                         /* L = 1.2 */                                      \
    X(SADDLE_SPLIT, "saddle, split, x10")       /* uneven knots, moved, ten times as large */      \
    X(SADDLE_CORNER, "saddle, start in corner") /* generators along both edges */                  \
    X(SADDLE_UNEQUAL, "saddle, weft 1.5 warp")                                                     \
    X(PARABOLOID, "paraboloid")                                                                    \
    X(PARABOLOID_SMALL, "paraboloid x1e-3") /* mirrored */                                         \
    X(PLANE, "plane")                       /* oblique */                                          \
    X(CYLINDER, "cylinder patch")           /* oblique */                                          \
    X(CYLINDER_FULL, "cylinder, closed")    /* oblique, across the seam */                         \
    X(CONE, "cone patch")                   /* oblique */                                          \
    X(CONE_FULL, "cone frustum, closed")                                                           \
    X(TORUS, "torus, quarter")                                                                     \
    X(TORUS_FULL, "torus, closed") /* across both seams */                                         \
    X(ELLIPSOID, "ellipsoid patch")                                                                \
    X(SADDLE_OBLIQUE, "saddle, oblique")                                                           \
    X(BEZIER, "rational bicubic")                                                                  \
    X(FREEFORM, "free-form bicubic, C2")

enum scene_id {
#define X(id, name) SCENE_##id,
    SCENE_LIST(X)
#undef X
        SCENE_COUNT
};

struct scene {
    const char *name;
    struct shape shape;
    struct shape smooth;  /* the same surface about the start in an analytic chart */
    struct motion motion; /* of the shapes from their own axes */
    double start_uv[2];
    double smooth_uv[2]; /* the start there */
    double angle_deg, pre_shear_deg;
    bool by_point, by_vector; /* how the solver is told */
    bool one_quadrant;        /* the others leave the surface at once */
    double side, aspect;
    double length[2]; /* side, aspect * side */
    struct frame start;
    enum scene_id id;
    struct reference *reference; /* see scene_reference */
};

void scene_make(struct scene *scene, enum scene_id id);
/* The exact net, made when first asked for; the scene owns it. */
const struct reference *scene_reference(struct scene *scene);
void scene_free(struct scene *scene);

/* The solver's settings for N cells a side. */
struct drape_settings scene_settings(const struct scene *scene, enum drape_method method, int n);

#endif
