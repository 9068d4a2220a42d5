/* SPDX-License-Identifier: MIT */
/* Meshes for the tests: grids of triangles that can be bent, shuffled, joined and taken apart. */
#ifndef UNIT_SAMPLE_H
#define UNIT_SAMPLE_H

#include "solver/mesh/mesh.h"
#include "support.h"

/* On the heap; `sample_free` gives it back. */
struct sample {
    struct vec3 *vertices;
    int32_t (*triangles)[3];
    size_t vertex_count, triangle_count;
};

/* n x m squares over [0, 1]^2 of the plane z = 0, each two triangles with normals up. With `random`
 * (may be NULL) inner vertices are moved by up to 0.2 squares and diagonals run either way. */
struct sample sample_grid(int n, int m, struct random *random);

/* The vertices and triangles given; of two samples; of the triangles for which `keep` is true. */
struct sample sample_of(const struct vec3 *vertices, size_t vertex_count,
                        const int32_t (*triangles)[3], size_t triangle_count);
void sample_add(struct sample *sample, const struct sample *other);
void sample_keep(struct sample *sample, bool (*keep)(struct vec3 middle));

void sample_map(struct sample *sample, struct vec3 (*map)(struct vec3 p));
/* Triangles in random order, wound and begun at random. */
void sample_shuffle(struct sample *sample, struct random *random);
/* Every triangle gets vertices of its own. */
void sample_scatter(struct sample *sample);
void sample_free(struct sample *sample);

struct mesh_source sample_source(const struct sample *sample);
/* Its mesh; the test fails when there is a fault. */
struct mesh *sample_mesh(const struct sample *sample, struct arena *arena);

/* The first place of a mesh under or over (x, y), by looking at all triangles; the test fails when
 * there is none. */
struct mesh_point sample_place(const struct mesh *mesh, double x, double y);

/* How far a place is from its own triangle. */
double sample_gap(const struct mesh *mesh, const struct mesh_point *place);

struct vec3 random_direction(struct random *random);

#endif
