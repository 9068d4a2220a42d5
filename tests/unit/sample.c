/* SPDX-License-Identifier: MIT */
#include "sample.h"

#include "tests/check.h"
#include <stdlib.h>
#include <string.h>

struct sample sample_of(const struct vec3 *vertices, size_t vertex_count,
                        const int32_t (*triangles)[3], size_t triangle_count) {
    struct sample s = {.vertex_count = vertex_count, .triangle_count = triangle_count};
    s.vertices = calloc(vertex_count + 1, sizeof *s.vertices);
    s.triangles = calloc(triangle_count + 1, sizeof *s.triangles);
    assert_true(s.vertices && s.triangles);
    if (vertices)
        memcpy(s.vertices, vertices, vertex_count * sizeof *s.vertices);
    if (triangles)
        memcpy(s.triangles, triangles, triangle_count * sizeof *s.triangles);
    return s;
}

static void set_triangle(struct sample *s, size_t t, int a, int b, int c) {
    s->triangles[t][0] = a;
    s->triangles[t][1] = b;
    s->triangles[t][2] = c;
}

struct sample sample_grid(int n, int m, struct random *random) {
    struct sample s = sample_of(NULL, (size_t)((n + 1) * (m + 1)), NULL, (size_t)(2 * n * m));
    for (int j = 0; j <= m; j++)
        for (int i = 0; i <= n; i++) {
            bool inner = random && i > 0 && i < n && j > 0 && j < m;
            double x = inner ? random_between(random, -0.2, 0.2) : 0;
            double y = inner ? random_between(random, -0.2, 0.2) : 0;
            s.vertices[j * (n + 1) + i] = vec3_make((i + x) / n, (j + y) / m, 0);
        }
    for (int j = 0; j < m; j++)
        for (int i = 0; i < n; i++) {
            size_t t = 2 * (size_t)(j * n + i);
            int a = j * (n + 1) + i, b = a + 1, c = b + n + 1, d = a + n + 1;
            bool other = random && random_index(random, 2);
            set_triangle(&s, t, a, b, other ? d : c);
            set_triangle(&s, t + 1, other ? b : a, c, d);
        }
    return s;
}

void sample_add(struct sample *sample, const struct sample *other) {
    size_t m = sample->vertex_count, n = sample->triangle_count;
    struct sample sum = sample_of(NULL, m + other->vertex_count, NULL, n + other->triangle_count);
    memcpy(sum.vertices, sample->vertices, m * sizeof *sum.vertices);
    memcpy(sum.vertices + m, other->vertices, other->vertex_count * sizeof *sum.vertices);
    memcpy(sum.triangles, sample->triangles, n * sizeof *sum.triangles);
    for (size_t t = 0; t < other->triangle_count; t++)
        for (int k = 0; k < 3; k++)
            sum.triangles[n + t][k] = other->triangles[t][k] + (int32_t)m;
    sample_free(sample);
    *sample = sum;
}

void sample_keep(struct sample *sample, bool (*keep)(struct vec3 middle)) {
    size_t kept = 0;
    for (size_t t = 0; t < sample->triangle_count; t++) {
        int32_t *k = sample->triangles[t];
        struct vec3 sum = vec3_add(sample->vertices[k[0]],
                                   vec3_add(sample->vertices[k[1]], sample->vertices[k[2]]));
        if (keep(vec3_scale(1.0 / 3, sum)))
            memmove(sample->triangles[kept++], k, sizeof *sample->triangles);
    }
    sample->triangle_count = kept;
}

void sample_map(struct sample *sample, struct vec3 (*map)(struct vec3 p)) {
    for (size_t v = 0; v < sample->vertex_count; v++)
        sample->vertices[v] = map(sample->vertices[v]);
}

void sample_shuffle(struct sample *sample, struct random *random) {
    for (size_t t = sample->triangle_count; t-- > 0;) {
        int32_t *a = sample->triangles[t], c[3];
        int32_t *b = sample->triangles[random_index(random, (int)t + 1)];
        memcpy(c, a, sizeof c);
        memmove(a, b, sizeof c);
        int first = random_index(random, 3), step = 1 + random_index(random, 2);
        for (int k = 0; k < 3; k++)
            b[k] = c[(first + k * step) % 3];
    }
}

void sample_scatter(struct sample *sample) {
    struct sample soup = sample_of(NULL, 3 * sample->triangle_count, NULL, sample->triangle_count);
    for (size_t t = 0; t < sample->triangle_count; t++)
        for (size_t k = 0; k < 3; k++) {
            soup.vertices[3 * t + k] = sample->vertices[sample->triangles[t][k]];
            soup.triangles[t][k] = (int32_t)(3 * t + k);
        }
    sample_free(sample);
    *sample = soup;
}

void sample_free(struct sample *sample) {
    free(sample->vertices);
    free(sample->triangles);
}

struct mesh_source sample_source(const struct sample *sample) {
    return (struct mesh_source){.vertices = sample->vertices,
                                .vertex_count = sample->vertex_count,
                                .triangles = (const int32_t(*)[3])sample->triangles,
                                .triangle_count = sample->triangle_count};
}

struct mesh *sample_mesh(const struct sample *sample, struct arena *arena) {
    struct mesh_source source = sample_source(sample);
    struct mesh_fault fault = {.reason = "no memory"};
    struct mesh *mesh;
    if (mesh_make(&source, arena, &mesh, &fault) != STATUS_OK)
        fail_msg("triangle %zu: %s", fault.index, fault.reason);
    return mesh;
}

struct mesh_point sample_place(const struct mesh *mesh, double x, double y) {
    for (int32_t t = 0; t < (int32_t)mesh->triangle_count; t++) {
        struct vec3 n = mesh->normals[t], p = mesh_corner_point(mesh, t, 0);
        double z = p.z - (n.x * (x - p.x) + n.y * (y - p.y)) / n.z, weight[3];
        struct mesh_point place = {t, {x, y, z}};
        if (!isfinite(z))
            continue;
        mesh_weights(mesh, &place, weight);
        if (weight[0] > -1e-14 && weight[1] > -1e-14 && weight[2] > -1e-14)
            return place;
    }
    fail_msg("no place at %g %g", x, y);
    return (struct mesh_point){0};
}

double sample_gap(const struct mesh *mesh, const struct mesh_point *place) {
    double weight[3], outside = 0;
    struct vec3 offset = vec3_sub(place->r, mesh_corner_point(mesh, place->triangle, 0));
    mesh_weights(mesh, place, weight);
    for (int k = 0; k < 3; k++)
        outside = fmax(outside, -weight[k] * mesh->size);
    return fmax(outside, fabs(vec3_dot(offset, mesh->normals[place->triangle])));
}

struct vec3 random_direction(struct random *random) {
    for (;;) {
        struct vec3 a = {random_between(random, -1, 1), random_between(random, -1, 1),
                         random_between(random, -1, 1)};
        if (vec3_norm(a) > 0.1 && vec3_norm(a) < 1)
            return vec3_unit(a);
    }
}
