/* SPDX-License-Identifier: MIT */
/*
 * Parts of flat faces that unfold once they are cut: pyramids, ends of prisms. Their nets are
 * known: square in the unfolded plane, whatever edges the yarns cross.
 */
#ifndef DRAPE_TESTS_POLYHEDRON_H
#define DRAPE_TESTS_POLYHEDRON_H

#include "shapes.h"
#include "solver/drape.h"
#include "solver/shell/shell.h"

enum { POLYHEDRON_FACES = 10, POLYHEDRON_CORNERS = 10 };

/* A face: its corners in order, anticlockwise seen from outside, its frame, and its place in the
 * plane: the corner 0 is at `at`, the first axis turned by (c, s). */
struct polyhedron_face {
    int count;
    struct vec3 corner[POLYHEDRON_CORNERS], axis[2];
    double at[2], c, s;
    bool unfolded;
    /* as the solver has it: */
    struct shape shape;
    double outline[POLYHEDRON_CORNERS + 1][2];
    struct trim_curve curve;
    struct trim_loop loop;
};

/* And its cuts, each along one edge of two faces, from the mouth to the tip; large: to be static.
 */
struct polyhedron {
    int count, cut_count;
    struct polyhedron_face face[POLYHEDRON_FACES];
    struct vec3 path[POLYHEDRON_FACES][2];
    struct drape_cut_line cuts[POLYHEDRON_FACES];
    double tip_deg[POLYHEDRON_FACES]; /* by which angle each dart is to open */
};

/* n triangles that rise from a rim near the circle of radius 80 to an apex at that height, cut
 * along one edge; and the lid of n corners, with n walls that go down by a height, cut along all of
 * their edges. Both are turned and shifted at random. */
void polyhedron_pyramid(struct polyhedron *p, int n, double height, uint64_t *seed);
void polyhedron_prism(struct polyhedron *p, int n, double height, uint64_t *seed);

/* The same part, mirrored at the plane x = 0, and scaled. */
void polyhedron_change(struct polyhedron *p, double scale, bool mirror);

struct shell *polyhedron_shell(struct polyhedron *p, struct arena *arena);

/* A point well inside a face. */
struct vec3 polyhedron_inside(const struct polyhedron *p, int face, uint64_t *seed);

/* Where in the plane a point of a face lies, and a direction on it. */
void polyhedron_unfold(const struct polyhedron *p, int face, struct vec3 r, double at[2]);
void polyhedron_unfold_direction(const struct polyhedron *p, int face, struct vec3 a, double to[2]);

#endif
