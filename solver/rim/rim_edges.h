/* SPDX-License-Identifier: MIT */
/*
 * The edges of what is to be covered, as closed chains of vertices: the border of the domain and
 * the trims, of a shell the edges of its faces that are not joined, of a mesh the border of the
 * component with the start. What is to be covered lies on
 * the left of a chain, seen against the surface's normal.
 *
 * Between two vertices a chain follows the straight line in the parameters, on a mesh in space.
 * A closed direction that no pole closes is cut open where the net is: both sides of the cut are
 * edges.
 */
#ifndef SOLVER_RIM_RIM_EDGES_H
#define SOLVER_RIM_RIM_EDGES_H

#include "solver/march/march.h"

struct rim_vertex {
    int32_t face; /* on a mesh the triangle, on a shell the face, else 0 */
    double uv[2]; /* the surface's inner parameters, not wrapped round closed directions */
    struct vec3 r;
    bool leaps;    /* the next vertex is the same place by other parameters: nothing lies between */
    int32_t sight; /* of the piece from here: pieces with one number see the cloth from one side of
                      all cuts */
};

/* The pieces between the vertices first .. first + count; the last vertex is the same place as the
 * first. */
struct rim_loop {
    size_t first, count;
};

struct rim_edges {
    struct rim_vertex *vertices;
    struct rim_loop *loops;
    size_t vertex_count, vertex_room, loop_count, loop_room;
    int32_t sights;  /* numbers of sights: 1 without cuts */
    int32_t *lip_of; /* for each sight the lip of its pieces, as `drape_rim.cut` numbers them;
                        NULL without cuts */
};

/* Finds the edges, in the march's arena; trims with as few vertices as keep them within
 * `tolerance` in space. The lips of cuts become part of the chains that they begin on. Errors:
 * STATUS_OUT_OF_MEMORY; STATUS_CUT of a cut that does not begin at an edge, or that ends at one,
 * with the fault. */
struct cut_fault;
enum status rim_edges_make(struct march *march, double tolerance, struct rim_edges *edges,
                           struct cut_fault *fault) STATUS_MUST_USE;

/* A point on a chain. */
struct rim_edge_point {
    int32_t face;
    double t;     /* 0..1 between its vertices */
    double uv[2]; /* as of a vertex */
    struct vec3 r;
    struct surface_jet jet; /* that of its surface there; of a mesh unset */
    struct vec3 dr;         /* its derivative by t */
    struct vec3 normal;     /* on the start's side, of any length; zero where there is none */
};

/* The surface that parameters on a face belong to; NULL on a mesh. */
static inline const struct surface *rim_edges_surface(const struct march *march, int32_t face) {
    const struct surface *surface = march->surface;
    return surface && surface->shell ? shell_surface(surface->shell, face) : surface;
}

/* The point at t, 0 to 1, between two vertices that follow each other. */
void rim_edges_point(struct march *march, const struct rim_vertex *from,
                     const struct rim_vertex *to, double t, struct rim_edge_point *spot);

#endif
