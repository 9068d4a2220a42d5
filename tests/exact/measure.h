/* SPDX-License-Identifier: MIT */
/*
 * Measuring a net: running the solver on a shape, finding nodes by their indices, errors against an
 * exact net, edge lengths against what a method promises.
 */
#ifndef DRAPE_TESTS_MEASURE_H
#define DRAPE_TESTS_MEASURE_H

#include "reference.h"
#include "solver/drape.h"
#include "solver/mesh/mesh.h"
#include "solver/shell/shell.h"
#include "solver/surface/surface.h"
#include "solver/surface/trim.h"

/* Nodes by (i, j). */
struct grid {
    int low[2], size[2];
    int *index;
};

void grid_make(struct grid *grid, const struct drape_nodes *nodes);
void grid_free(struct grid *grid);
/* The node's place in the columns, or -1. */
int grid_find(const struct grid *grid, int i, int j);
struct vec3 node_point(const struct drape_nodes *nodes, int at);

/* A drape of a shape. */
struct drape_run {
    struct arena *arena;
    struct surface *surface;
    struct drape_result result;
    struct grid grid;
};

/* Drapes a shape, of which `trim` is usable (NULL: all). Fails the test unless the shape is valid.
 * Returns what drape_solve says; when that is not STATUS_OK there is no grid. `drape_end` in any
 * case. */
enum status drape_try_trimmed(struct drape_run *run, struct shape *shape, const struct trim *trim,
                              const struct drape_settings *settings);
/* The same, and fails the test unless it worked and the result holds together (`check_result`). */
void drape_begin_trimmed(struct drape_run *run, struct shape *shape, const struct trim *trim,
                         const struct drape_settings *settings);
/* Both with the whole shape. */
enum status drape_try(struct drape_run *run, struct shape *shape,
                      const struct drape_settings *settings);
void drape_begin(struct drape_run *run, struct shape *shape, const struct drape_settings *settings);
void drape_end(struct drape_run *run);

/* What must hold for every result: sorted unique nodes, all numbers finite, node (0,0) there, uv in
 * the domain and r(u, v) = (x, y, z), cells with four nodes each and all such cells, unit
 * directions, ranges and summary that follow from the columns. */
void check_result(const struct shape *shape, const struct drape_settings *settings,
                  const struct drape_run *run);

/* Largest errors over the nodes of a net with |i| <= n[0], |j| <= n[1]; NaN counts as infinite. */
struct net_error {
    double position, shear_deg;
    int count, worst[2]; /* nodes compared; (i, j) of the largest position error */
};
struct net_error measure_error(const struct drape_nodes *nodes, const struct reference *reference,
                               const double spacing[2], const int n[2]);

/* The chord 2 sin(d k / 2) / k of an arc of length d and curvature k. */
double arc_chord(double d, double k);

/* Chord lengths |CD| and |BD| promised to node D = (i, j), i j != 0, by gib with closed-form
 * tangents (docs/mathematics.md), from the positions of its three neighbours on the side of the
 * start. */
void gib_chords(const struct shape *shape, const struct drape_nodes *nodes, const struct grid *grid,
                int i, int j, const double spacing[2], double chord[2]);

/* Largest |edge / promised - 1| over edges that end in a node with i j != 0 (towards the start),
 * for basic or gib. */
double measure_edges(const struct shape *shape, const struct drape_nodes *nodes,
                     const struct grid *grid, enum drape_method method, const double spacing[2]);

/* The largest distance of the nodes of a developable surface from the square grid, in spacings,
 * where it is unrolled: `unroll` says where in the plane (u, v) lies. The grid has its origin at
 * node (0, 0), and is turned, and looked at from that side, as they lie in the mean. */
double square_gap(const struct drape_nodes *nodes, double d,
                  void (*unroll)(const void *surface, double u, double v, double at[2]),
                  const void *surface);

/* The sum of the areas of all cells, each the mean of its two triangulations. */
double cells_area(const struct drape_run *run);

/* The area within all loops of the rim in the flat. */
double rim_flat_area(const struct drape_rim *rim, const double spacing[2]);

/* Largest distance of the nodes with |i|, |j| <= n from the net of great-circle edges on a sphere
 * (`sphere_recursion` in all quadrants). */
double sphere_gap(const struct drape_run *run, struct vec3 centre, const struct frame *start,
                  const double arc[2], int n);

/* Observed order between two errors at d and d / 2. */
double order_of(double coarse, double fine);

#endif
