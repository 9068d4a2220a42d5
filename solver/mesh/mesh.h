/* SPDX-License-Identifier: MIT */
/*
 * A triangle mesh ready to be draped: checked, connected across its edges, wound one way, and with
 * a tree of boxes over its triangles. The mosaic method lays its net on one, its caller's own or
 * the tessellation of a surface (`tessellation.h`).
 *
 * Edge k of a triangle runs from its corner k to corner k + 1 (mod 3), counter-clockwise about its
 * normal; as a half-edge it is number 3 t + k. The normal of a point is that of its triangle.
 *
 * A mesh is immutable once made and may be read by many threads at once.
 */
#ifndef SOLVER_MESH_MESH_H
#define SOLVER_MESH_MESH_H

#include "solver/arena.h"
#include "solver/relocation.h"
#include "solver/status.h"
#include "solver/vec.h"
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    MESH_NONE = -1, /* no half-edge, no triangle */
    MESH_ANY = -1   /* any component */
};

/* A triangle whose smallest height is less than this share of its longest edge is a sliver. Its
 * normal, off by rounding's share of that height, would still be good to 1e-10, but no mesher means
 * to make one. */
#define MESH_SLIVER 1e-6

/* A mesh as its owner wrote it down: a view of the caller's arrays. */
struct mesh_source {
    const struct vec3 *vertices; /* finite, absolute coordinates at most 1e60 */
    size_t vertex_count;
    const int32_t (*triangles)[3]; /* indices of vertices, wound either way */
    size_t triangle_count;         /* 1 .. INT32_MAX / 3 */
    double least_height; /* of a triangle, as a share of its longest edge; 0: MESH_SLIVER */
    const double (*parameters)[2]; /* (u, v) of each vertex on the surface it came from, or NULL */
    const int32_t *faces;          /* of each triangle: the face it came from; or NULL */
};

/* What can be wrong with a mesh, in the order of the checks. X(id, reason) */
#define MESH_FAULT_LIST(X)                                                                         \
    X(EMPTY, "a mesh needs at least one triangle")                                                 \
    X(TOO_LARGE, "the mesh has too many vertices or triangles")                                    \
    X(VERTEX, "a vertex must have finite coordinates of at most 1e60")                             \
    X(INDEX, "a triangle refers to a vertex that is not there")                                    \
    X(NO_AREA, "the triangle has no area")                                                         \
    X(SLIVER, "the triangle's height is less than 1e-6 of its longest edge")                       \
    X(DUPLICATE, "the triangle has the same corners as another one")                               \
    X(NON_MANIFOLD, "the triangle shares an edge with more than one other")                        \
    X(ONE_SIDED, "the triangles round here cannot be wound consistently: the mesh is one-sided")

enum mesh_fault_kind {
#define X(id, reason) MESH_FAULT_##id,
    MESH_FAULT_LIST(X)
#undef X
};

struct mesh_fault {
    enum mesh_fault_kind kind;
    size_t index; /* of the vertex for MESH_FAULT_VERTEX, of the triangle for the later ones, 0 for
                     the two before: the first at fault, where several are */
    int corner;   /* of the triangle, for MESH_FAULT_INDEX */
    const char *reason; /* a sentence in static storage */
};

/* Triangles that hang together by edges. */
struct mesh_component {
    double area;
    struct vec3 centroid; /* of that area */
    size_t triangle_count;
    size_t rim_count; /* of edges with one triangle only; 0: the component is closed */
};

struct mesh_box {
    double lower[3], upper[3];
};

struct mesh {
    size_t vertex_count, triangle_count;
    struct vec3 *vertices;
    double (*parameters)[2]; /* of each vertex; NULL: none were given */
    int32_t *faces;          /* of each triangle; NULL: none were given */
    int32_t (*corners)[3];   /* counter-clockwise about the normal */
    int32_t *twins;          /* of half-edge 3 t + k: that of the triangle beyond, or MESH_NONE */
    struct vec3 *normals;    /* unit */
    int32_t *component;      /* of each triangle; numbered by their first triangles */
    struct mesh_component *components;
    size_t component_count;
    struct vec3 lower, upper; /* the box around the triangles */
    double size;              /* its diagonal */
    double magnitude;         /* its largest absolute coordinate: what rounding scales with */
    double area;
    struct vec3 centroid;
    double sharpest; /* the least cosine between the normals of two triangles at an edge */
    /* The tree (`tree.h`): leaf l has the triangles order[4 l ..]. */
    struct mesh_box *boxes;
    int32_t *order;
    size_t leaf_count;
};

/* A point on a mesh. */
struct mesh_point {
    int32_t triangle;
    struct vec3 r; /* in the triangle, to rounding */
};

/*
 * Makes a mesh of `source`, whose arrays are not needed afterwards, in `arena`; O(n log n).
 *
 * Triangles are neighbours when they share an edge by the indices of its ends; edges left over are
 * joined when their ends lie in exactly the same points, so that a soup of triangles, each with
 * vertices of its own, becomes a surface. Windings are made consistent within each component, the
 * way that most of its area has it already. Components may be many.
 *
 * Errors: STATUS_OUT_OF_MEMORY; STATUS_INVALID, for which `fault` (may be NULL) says why.
 */
enum status mesh_make(const struct mesh_source *source, struct arena *arena, struct mesh **mesh,
                      struct mesh_fault *fault) STATUS_MUST_USE;

/* A walk of `solver/relocation.h` from the pointer to a mesh on. */
void mesh_relocate(struct relocation *relocation, void *field);

/* The component of the largest area, of equal ones the first. */
int32_t mesh_largest_component(const struct mesh *mesh);

/* The nearest point of a component, or with MESH_ANY of the whole mesh, and its distance (may be
 * NULL); of points equally near, that in the first triangle. False when there is no such component
 * or `point` is not finite. */
bool mesh_nearest(const struct mesh *mesh, struct vec3 point, int32_t component,
                  struct mesh_point *nearest, double *distance);

/* Barycentric coordinates of a point in its triangle: r = sum of weight[k] times corner k; they add
 * up to 1 and are negative only by rounding. */
void mesh_weights(const struct mesh *mesh, const struct mesh_point *at, double weight[3]);

/* The vertices' parameters, interpolated at a point; (triangle, 0) for a mesh without. */
void mesh_parameters(const struct mesh *mesh, const struct mesh_point *at, double uv[2]);

static inline struct vec3 mesh_corner_point(const struct mesh *mesh, int32_t triangle, int corner) {
    return mesh->vertices[mesh->corners[triangle][corner]];
}

/* The half-edges of the same triangle after and before one. */
static inline int32_t mesh_next_half(int32_t half) {
    return half % 3 == 2 ? half - 2 : half + 1;
}

static inline int32_t mesh_previous_half(int32_t half) {
    return half % 3 == 0 ? half + 2 : half - 1;
}

/* The half-edge of the border that follows one of it, round the triangles at its end. */
static inline int32_t mesh_next_on_border(const struct mesh *mesh, int32_t half) {
    int32_t next = mesh_next_half(half);
    while (mesh->twins[next] != MESH_NONE)
        next = mesh_next_half(mesh->twins[next]);
    return next;
}

/* The corners of a triangle in order. */
static inline void mesh_corner_points(const struct mesh *mesh, int32_t triangle,
                                      struct vec3 point[3]) {
    for (int k = 0; k < 3; k++)
        point[k] = mesh_corner_point(mesh, triangle, k);
}

/* Twice the area of a triangle. */
static inline double mesh_twice_area(const struct mesh *mesh, int32_t triangle) {
    struct vec3 p[3];
    mesh_corner_points(mesh, triangle, p);
    return vec3_norm(vec3_cross(vec3_sub(p[1], p[0]), vec3_sub(p[2], p[0])));
}

/* From the start of a half-edge to its end. */
static inline struct vec3 mesh_edge_vector(const struct mesh *mesh, int32_t half) {
    return vec3_sub(mesh_corner_point(mesh, half / 3, mesh_next_half(half) % 3),
                    mesh_corner_point(mesh, half / 3, half % 3));
}

/* `direction` projected on the plane of the triangle, unit; zero when it is normal to it. */
static inline struct vec3 mesh_tangent(const struct mesh *mesh, int32_t triangle,
                                       struct vec3 direction) {
    struct vec3 normal = mesh->normals[triangle];
    return vec3_unit(vec3_axpy(-vec3_dot(direction, normal), normal, direction));
}

#endif
