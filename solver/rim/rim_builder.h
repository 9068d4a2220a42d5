/* SPDX-License-Identifier: MIT */
/*
 * What the edges of a part are gathered with, whatever they come from: vertices in their order,
 * which loops end, and the few points of a curve that a polyline within a tolerance needs.
 */
#ifndef SOLVER_RIM_RIM_BUILDER_H
#define SOLVER_RIM_RIM_BUILDER_H

#include "rim_edges.h"

struct rim_builder {
    struct march *march;
    struct rim_edges *edges;
    double tolerance; /* in space */
    bool failed;      /* no memory: what is added from then on is ignored */
};

/* The domain as the net sees it: closed directions cut open, or without an end. */
struct rim_window {
    double low[2], high[2], length[2];
    bool endless[2];
};

/* Adds a vertex to the loop that is being made; the second that of a surface of one face at inner
 * parameters. */
void rim_builder_add_vertex(struct rim_builder *b, const struct rim_vertex *vertex);
void rim_builder_add_point(struct rim_builder *b, double u, double v);

/* Ends the loop of the vertices added since the last one: where it began, by a vertex for that
 * unless `closed`. */
void rim_builder_end_loop(struct rim_builder *b, bool closed);

/* How far the place m is from the line a c, in space, and at which share of that it is nearest: r_u
 * and r_v at m measure it. */
double rim_builder_deviation(const struct rim_builder *b, const struct surface *surface,
                             const double a[2], const double c[2], const double m[2],
                             double *share);

/* Which of its points a polyline needs to stay within the tolerance; NULL without memory, then or
 * before. */
uint8_t *rim_builder_keep_points(struct rim_builder *b, const struct surface *surface,
                                 const double (*uv)[2], size_t count);

/* Whether all of a side of the domain is one point. */
static inline bool rim_builder_is_pole(const struct rim_builder *b, int k, int end) {
    const struct surface_axis *axis = &b->march->surface->axis[k];
    return !axis->closed && axis->pole[end];
}

/* Add the edges of a shell's component with the start; and those of a surface of one face with
 * trims, in a window. */
void rim_builder_add_shell(struct rim_builder *b);
void rim_builder_add_trims(struct rim_builder *b, const struct rim_window *window);

/* Makes the lips of the march's cuts part of the loops. Errors: as `rim_edges_make`. */
enum status rim_builder_add_cuts(struct rim_builder *b, struct cut_fault *fault) STATUS_MUST_USE;

#endif
