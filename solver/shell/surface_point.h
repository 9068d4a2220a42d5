/* SPDX-License-Identifier: MIT */
/*
 * A point: a place on the surface with all the march needs to know there, and the ways to get
 * from one to another. Everything that is special about a place (the seam of a closed direction, a
 * pole, the continuation beyond the boundary) is settled here, so that the march can think in
 * space.
 */
#ifndef SOLVER_SHELL_SURFACE_POINT_H
#define SOLVER_SHELL_SURFACE_POINT_H

#include "solver/reason.h"
#include "solver/surface/spans.h"

struct surface_point {
    const struct surface *surface; /* that uv are parameters of; NULL on a mesh */
    double uv[2];                  /* continuous along the net: a closed direction is not wrapped */
    struct surface_jet jet;
    struct vec3 normal; /* unit, along r_u x r_v or, on faces of a shell that are turned round,
                           against it; its limit at a pole; zero where there is none */
    double first[3];    /* E, F, G: r_u.r_u, r_u.r_v, r_v.r_v */
    double second[3];   /* L, M, N: r_uu, r_uv, r_vv times the normal */
};

/* Where (u, v) lies, from the net's point of view the better first. */
enum surface_point_zone {
    SURFACE_POINT_INSIDE,
    SURFACE_POINT_GHOST, /* on the continuation, while that is healthy */
    SURFACE_POINT_BEYOND
};

/* Where on which surface: a face, if it is one of a shell. */
struct surface_place {
    const struct surface *surface;
    double uv[2];
};

/* Evaluates at uv. False when the surface has no tangent plane there. */
bool surface_point_at(const struct surface *surface, struct surface_cursor *cursor,
                      const double uv[2], struct surface_point *point);

/* The place of the surface, or of its component of the shell, that is nearest to r, and its
 * distance from that. False as above. */
bool surface_point_nearest(const struct surface *surface, struct surface_cursor *cursor,
                           struct vec3 r, struct surface_point *point, double *distance);

/* The same, from a place near it. */
bool surface_point_nearest_from(struct surface_cursor *cursor, const struct surface_point *near,
                                struct vec3 r, struct surface_point *point, double *distance);

/* A point on a fold has two frames, and Newton's last step, of rounding, may carry it over with
 * that of the side it comes from. Whether it is so, and `own` then the point with the frame of the
 * span in which its parameters lie, as `surface_point_at` has it. */
bool surface_point_in_frame(struct surface_cursor *cursor, const struct surface_point *point,
                            struct surface_point *own);

/* Completes a point whose uv and jet are set. False as above. */
bool surface_point_complete(const struct surface *surface, struct surface_point *point);

/* Whether r_u or r_v vanishes at a point that is complete. */
bool surface_point_at_pole(const struct surface *surface, const struct surface_point *point);

/* The place next to `from` displaced by `step` in space, |step| small against the radii of
 * curvature: to second order in |step| away from poles, to first order near one, where it goes
 * through the pole. It is on the surface of `from`, or its continuation; at a pole at which faces
 * of a shell meet, on the face in whose region it lies. False when there is none (across a pole's
 * open side); it is then that of `from`. */
bool surface_point_pull(struct surface_cursor *cursor, const struct surface_point *from,
                        struct vec3 step, struct surface_place *place);

/* The same on the surface of `from` alone, with its continuation: parameters. */
bool surface_point_pull_on_face(struct surface_cursor *cursor, const struct surface_point *from,
                                struct vec3 step, double uv[2]);

/* The same, evaluated; `to` may be `from`. False also where the surface has no tangent plane there.
 */
bool surface_point_move(struct surface_cursor *cursor, const struct surface_point *from,
                        struct vec3 step, struct surface_point *to);

/* The normal curvature at a point along `direction`, which is not zero, as
 * `surface_point_normal_curvature`: next to a pole, where rounding hides how parameter lines bend
 * round it, that a little further on that way. */
double surface_point_curvature(struct surface_cursor *cursor, const struct surface_point *point,
                               struct vec3 direction);

/* The unit directions of principal curvature at a point: that of the larger one first. False where
 * all normal curvatures are equal. */
bool surface_point_principal(const struct surface_point *point, struct vec3 direction[2]);

/* The distance from `point` to the nearest pole, and that pole; infinite when there is none. */
double surface_point_pole_distance(const struct surface *surface, struct vec3 point,
                                   struct vec3 *pole);

/* Round a closed direction k that no pole closes, the net is cut open half a turn from its centre:
 * that much in its parameter; HUGE_VAL for other directions. */
double surface_point_cut_turn(const struct surface *surface, int k);

/* A node this close outside the domain, as a share of the domain and of the surface's size, is on
 * its boundary. */
#define SURFACE_POINT_BOUNDARY_WIDTH 1e-9

/* Whether a point lies beyond the domain of its surface by more than `slack`, as a share of the
 * domain and of the surface's size. */
bool surface_point_is_beyond(const struct surface_point *point, double slack);

/* The zone of a point of a surface alone and, unless it is inside, why the net ends there. The
 * continuation is trusted up to `reach` from the boundary. Round a closed direction that no pole
 * closes, the net ends half a period from `centre` on either side, where it would meet itself. */
enum surface_point_zone surface_point_zone(const struct surface *surface,
                                           struct surface_cursor *cursor, const double centre[2],
                                           const struct surface_point *point, double reach,
                                           enum drape_reason *reason);

/* The same on a face of a shell: inside as far as the face or a joint of it reaches, by what was
 * found between the point and its face (`crossing.h`). */
struct crossing;
enum surface_point_zone surface_point_zone_on_face(const struct surface_point *point,
                                                   const struct crossing *crossing, double reach);

/* Whether the continuation is trusted at a point beyond the domain, as either zone asks. */
bool surface_point_is_trusted(const struct surface_point *point, struct surface_cursor *cursor,
                              double reach);

/* Tangents this nearly parallel (sine of their angle) span no tangent plane. */
#define SURFACE_POINT_PARALLEL 1e-9

#include "tangent_plane.h"

/* The principal curvatures k1 and k2 are m + r and m - r: the roots of k^2 - 2 m k + K = 0 with the
 * mean curvature m and the Gaussian curvature K. */
static inline void surface_point_principal_curvatures(const struct surface_point *point, double *m,
                                                      double *r) {
    const double *a = point->first, *b = point->second;
    double determinant = surface_point_determinant(point);
    double gauss = surface_point_gauss_curvature(point);
    *m = (a[0] * b[2] - 2 * a[1] * b[1] + a[2] * b[0]) / (2 * determinant);
    *r = sqrt(fmax(*m * *m - gauss, 0));
}

#endif
