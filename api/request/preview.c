/* SPDX-License-Identifier: MIT */
#include "preview.h"

#include "api/json/text.h"
#include "mesh_faces.h"
#include "solver/surface/surface.h"
#include "solver/surface/trim.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

enum {
    STEPS_LEAST = 8,    /* of the grid, in a direction that may bend */
    STEPS_TRIMMED = 24, /* in one that is cut by trims */
    STEPS_MOST = 48,    /* of a face */
    HALVINGS = 16       /* towards a trim */
};

/* One face's triangles, as glTF has them. */
struct primitive {
    float (*positions)[3], (*normals)[3];
    uint32_t *indices, vertex_count, index_count, vertex_room, index_room;
    const struct api_surface *face; /* NULL: a mesh */
    size_t number;
};

struct vertex {
    double uv[2];
    uint32_t index;
    bool inside;
};

struct maker {
    const struct surface *surface;
    const struct trim *trim;
    struct surface_cursor cursor;
    struct primitive *out;
};

/* ---- one face ---- */

static void add_vertex(struct maker *m, struct vertex *vertex) {
    struct primitive *p = m->out;
    struct surface_jet jet;
    surface_evaluate(m->surface, &m->cursor, vertex->uv[0], vertex->uv[1], &jet);
    struct vec3 normal = vec3_cross(jet.u, jet.v);
    double length = vec3_norm(normal);
    normal = length > 0 ? vec3_scale(1 / length, normal) : vec3_make(0, 0, 1);
    const double r[3] = {jet.r.x, jet.r.y, jet.r.z}, n[3] = {normal.x, normal.y, normal.z};
    vertex->index = p->vertex_count++;
    for (int k = 0; k < 3; k++) {
        p->positions[vertex->index][k] = (float)r[k];
        p->normals[vertex->index][k] = (float)n[k];
    }
}

static void add_face_triangle(struct primitive *p, uint32_t a, uint32_t b, uint32_t c) {
    if (p->index_count + 3 > p->index_room || a == b || b == c || c == a)
        return;
    p->indices[p->index_count++] = a;
    p->indices[p->index_count++] = b;
    p->indices[p->index_count++] = c;
}

/* Where the trim crosses the line from a vertex inside to one outside. */
static struct vertex cross_trim(struct maker *m, const struct vertex *in,
                                const struct vertex *out) {
    double low[2] = {in->uv[0], in->uv[1]}, high[2] = {out->uv[0], out->uv[1]};
    for (int step = 0; step < HALVINGS; step++) {
        const double middle[2] = {(low[0] + high[0]) / 2, (low[1] + high[1]) / 2};
        memcpy(trim_contains(m->trim, middle) ? low : high, middle, sizeof middle);
    }
    struct vertex vertex = {.uv = {low[0], low[1]}, .inside = true};
    add_vertex(m, &vertex);
    return vertex;
}

/* The part of a triangle of the grid that is inside: none, a triangle or a quadrilateral. */
static void add_clipped(struct maker *m, const struct vertex *const corner[3]) {
    struct vertex kept[4];
    int count = 0;
    if (m->out->vertex_count + 2 > m->out->vertex_room)
        return;
    for (int k = 0; k < 3; k++) {
        const struct vertex *a = corner[k], *b = corner[(k + 1) % 3];
        if (a->inside)
            kept[count++] = *a;
        if (a->inside != b->inside)
            kept[count++] = a->inside ? cross_trim(m, a, b) : cross_trim(m, b, a);
    }
    for (int k = 2; k < count; k++)
        add_face_triangle(m->out, kept[0].index, kept[k - 1].index, kept[k].index);
}

static int grid_steps(const struct nurbs_axis *axis, bool trimmed, size_t faces) {
    int steps = axis->degree == 1 && axis->size == 2 ? 1 : STEPS_LEAST + 2 * axis->size;
    int least = trimmed ? STEPS_TRIMMED : 1;
    steps = steps < least ? least : steps;
    int most = faces > 2000 ? STEPS_LEAST : STEPS_MOST;
    return steps < most ? steps : most;
}

static bool take_primitive_room(struct primitive *p, size_t vertices, size_t triangles,
                                struct arena *arena) {
    p->positions = arena_alloc(arena, vertices, sizeof *p->positions);
    p->normals = arena_alloc(arena, vertices, sizeof *p->normals);
    p->indices = arena_alloc(arena, 3 * triangles, sizeof *p->indices);
    p->vertex_room = (uint32_t)vertices;
    p->index_room = (uint32_t)(3 * triangles);
    return p->positions && p->normals && p->indices;
}

/* By a grid of (nu + 1) (nv + 1) vertices, then those on trims. A face without an area has no
 * triangles. */
static bool tessellate_face(struct primitive *p, const struct api_surface *face, size_t faces,
                            struct arena *arena) {
    struct surface *surface;
    struct trim *trim = NULL;
    int nu = grid_steps(&face->nurbs.u, face->trim_count > 0, faces);
    int nv = grid_steps(&face->nurbs.v, face->trim_count > 0, faces);
    size_t cells = (size_t)nu * (size_t)nv, wide = (size_t)nv + 1, count = (size_t)(nu + 1) * wide;
    double low[2], high[2];
    enum status status = surface_make(&face->nurbs, arena, &surface);
    if (status == STATUS_OK && face->trim_count)
        status = trim_make(surface, face->trims, face->trim_count, arena, &trim);
    if (status != STATUS_OK)
        return status != STATUS_OUT_OF_MEMORY;
    if (!take_primitive_room(p, count + (trim ? 4 * cells : 0) + 2, 4 * cells, arena))
        return false;
    struct maker maker = {.surface = surface, .trim = trim, .out = p};
    struct vertex *grid = arena_alloc(arena, count, sizeof *grid);
    if (!grid)
        return false;
    surface_domain(surface, low, high);
    for (int i = 0; i <= nu; i++)
        for (int j = 0; j <= nv; j++) {
            struct vertex *vertex = &grid[(size_t)i * wide + (size_t)j];
            vertex->uv[0] = low[0] + (high[0] - low[0]) * i / nu;
            vertex->uv[1] = low[1] + (high[1] - low[1]) * j / nv;
            vertex->inside = !trim || trim_contains(trim, vertex->uv);
            add_vertex(&maker, vertex);
        }
    for (int i = 0; i < nu; i++)
        for (int j = 0; j < nv; j++) {
            const struct vertex *a = &grid[(size_t)i * wide + (size_t)j], *b = a + wide;
            add_clipped(&maker, (const struct vertex *const[]){a, b, b + 1});
            add_clipped(&maker, (const struct vertex *const[]){a, b + 1, a + 1});
        }
    return true;
}

/* ---- a mesh ---- */

/* The faces of a mesh, flat, each with vertices of its own. `kept` counts them; NULL without
 * memory. */
static struct primitive *mesh_primitives(const struct api_mesh *from, struct arena *arena,
                                         size_t *kept) {
    const struct mesh_source source = {.vertices = from->vertices,
                                       .vertex_count = from->vertex_count,
                                       .triangles = from->triangles,
                                       .triangle_count = from->triangle_count};
    size_t count = 0;
    struct mesh *mesh;
    if (mesh_make(&source, arena, &mesh, NULL) != STATUS_OK)
        return NULL;
    const int32_t *face = mesh_face_numbers(mesh, arena, &count);
    struct primitive *all = face ? arena_alloc(arena, count, sizeof *all) : NULL;
    size_t *triangles = face ? arena_alloc(arena, count, sizeof *triangles) : NULL;
    /* Of each vertex of the mesh the face that has it last, and its number there. */
    struct {
        int32_t face;
        uint32_t index;
    } *last = face ? arena_alloc(arena, mesh->vertex_count, sizeof *last) : NULL;
    bool good = all && triangles && last;
    for (size_t t = 0; good && t < mesh->triangle_count; t++)
        triangles[face[t]]++;
    for (size_t k = 0; good && k < count; k++) {
        good = take_primitive_room(&all[k], 3 * triangles[k], triangles[k], arena);
        all[k].number = k;
        all[k].normals = NULL;
    }
    for (size_t t = 0; good && t < mesh->triangle_count; t++) {
        struct primitive *p = &all[face[t]];
        uint32_t corner[3];
        for (int k = 0; k < 3; k++) {
            int32_t v = mesh->corners[t][k];
            if (last[v].face != face[t] + 1) {
                const double r[3] = {mesh->vertices[v].x, mesh->vertices[v].y, mesh->vertices[v].z};
                for (int c = 0; c < 3; c++)
                    p->positions[p->vertex_count][c] = (float)r[c];
                last[v].face = face[t] + 1;
                last[v].index = p->vertex_count++;
            }
            corner[k] = last[v].index;
        }
        add_face_triangle(p, corner[0], corner[1], corner[2]);
    }
    *kept = count;
    return good ? all : NULL;
}

/* ---- glTF ---- */

enum { GLTF_FLOAT = 5126, GLTF_UINT = 5125, GLTF_ARRAY = 34962, GLTF_ELEMENTS = 34963 };

/* The bytes of a primitive: positions, normals, indices. */
static size_t parts_of(const struct primitive *p, const void *part[3], size_t length[3]) {
    size_t count = 0;
    part[count] = p->positions;
    length[count++] = p->vertex_count * sizeof *p->positions;
    if (p->normals) {
        part[count] = p->normals;
        length[count++] = p->vertex_count * sizeof *p->normals;
    }
    part[count] = p->indices;
    length[count++] = p->index_count * sizeof *p->indices;
    return count;
}

static void write_extreme(struct api_text *text, const struct primitive *p, const char *key,
                          double sign) {
    double extreme[3];
    for (int k = 0; k < 3; k++) {
        extreme[k] = (double)p->positions[0][k];
        for (uint32_t i = 1; i < p->vertex_count; i++)
            if (sign * (double)p->positions[i][k] > sign * extreme[k])
                extreme[k] = (double)p->positions[i][k];
    }
    api_text_key_numbers(text, key, extreme, 3);
}

static void write_primitive(struct api_text *text, const struct primitive *p, size_t accessor,
                            size_t material) {
    api_text_raw(text, "{");
    api_text_key_object(text, "attributes");
    api_text_key_integer(text, "POSITION", (int64_t)accessor);
    if (p->normals)
        api_text_key_integer(text, "NORMAL", (int64_t)accessor + 1);
    api_text_raw(text, "}");
    api_text_key_integer(text, "indices", (int64_t)accessor + (p->normals ? 2 : 1));
    api_text_key_integer(text, "material", (int64_t)material);
    api_text_key_object(text, "extras");
    api_text_key_integer(text, "face", (int64_t)p->number);
    if (p->face && p->face->face_name)
        api_text_key_string(text, "name", p->face->face_name);
    api_text_key_string(text, "kind",
                        !p->face             ? "mesh"
                        : p->face->face_kind ? p->face->face_kind
                                             : "nurbs");
    api_text_raw(text, "}}");
}

/* #rrggbb in linear light, as glTF wants it; a light grey where none is given. */
static void write_gltf_material(struct api_text *text, const struct primitive *p) {
    const char *colour = p->face ? p->face->face_colour : NULL;
    unsigned rgb[3] = {0xc8, 0xcc, 0xd0};
    double linear[4] = {0, 0, 0, 1};
    if (colour &&
        (strlen(colour) != 7 || sscanf(colour, "#%2x%2x%2x", &rgb[0], &rgb[1], &rgb[2]) != 3))
        rgb[0] = rgb[1] = rgb[2] = 0xcc;
    for (int k = 0; k < 3; k++) {
        double value = rgb[k] / 255.0;
        linear[k] = value * value * (0.3 + 0.7 * value); /* within 1 % of the sRGB curve */
    }
    api_text_raw(text, "{\"doubleSided\":true");
    api_text_key(text, "pbrMetallicRoughness");
    api_text_raw(text, "{\"metallicFactor\":0,\"roughnessFactor\":0.8");
    api_text_key_numbers(text, "baseColorFactor", linear, 4);
    api_text_raw(text, "}}");
}

static const char *write_gltf(const struct primitive *all, size_t count, struct arena *arena,
                              size_t *bytes) {
    struct api_text text = api_text_growing(arena);
    const void *part[3];
    size_t view = 0, accessor = 0, length[3], parts;
    api_text_raw(&text, "{\"asset\":{\"version\":\"2.0\",\"generator\":\"draped\"},\"scene\":0,"
                        "\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],"
                        "\"meshes\":[{\"primitives\":[");
    for (size_t k = 0; k < count; k++) {
        api_text_raw(&text, k ? "," : "");
        write_primitive(&text, &all[k], accessor, k);
        accessor += all[k].normals ? 3 : 2;
    }
    api_text_raw(&text, "]}],\"materials\":[");
    for (size_t k = 0; k < count; k++) {
        api_text_raw(&text, k ? "," : "");
        write_gltf_material(&text, &all[k]);
    }
    api_text_raw(&text, "],\"accessors\":[");
    for (size_t k = 0; k < count; k++) {
        parts = parts_of(&all[k], part, length);
        for (size_t i = 0; i < parts; i++) {
            bool last = i + 1 == parts;
            api_text_raw(&text, view ? ",{" : "{");
            api_text_key_integer(&text, "bufferView", (int64_t)view++);
            api_text_key_integer(&text, "componentType", last ? GLTF_UINT : GLTF_FLOAT);
            api_text_key_integer(&text, "count", last ? all[k].index_count : all[k].vertex_count);
            api_text_key_string(&text, "type", last ? "SCALAR" : "VEC3");
            if (i == 0) {
                write_extreme(&text, &all[k], "min", -1);
                write_extreme(&text, &all[k], "max", 1);
            }
            api_text_raw(&text, "}");
        }
    }
    api_text_raw(&text, "],\"bufferViews\":[");
    *bytes = view = 0;
    for (size_t k = 0; k < count; k++) {
        parts = parts_of(&all[k], part, length);
        for (size_t i = 0; i < parts; i++) {
            api_text_raw(&text, view++ ? ",{\"buffer\":0" : "{\"buffer\":0");
            api_text_key_integer(&text, "byteOffset", (int64_t)*bytes);
            api_text_key_integer(&text, "byteLength", (int64_t)length[i]);
            api_text_key_integer(&text, "target", i + 1 == parts ? GLTF_ELEMENTS : GLTF_ARRAY);
            api_text_raw(&text, "}");
            *bytes += length[i];
        }
    }
    api_text_raw(&text, "],\"buffers\":[{");
    api_text_key_integer(&text, "byteLength", (int64_t)*bytes);
    api_text_raw(&text, "}]}");
    return api_text_finish(&text);
}

static bool send_bytes(const struct api_sink *sink, const void *bytes, size_t length) {
    return length == 0 || sink->write(sink->context, bytes, length);
}

enum api_problem_id api_preview(const struct api_surface *surface, const struct api_sink *sink,
                                struct arena *arena, struct api_problem *problem) {
    size_t count = surface->kind == API_SURFACE_SHELL ? surface->face_count : 1;
    size_t kept = 0, bytes = 0;
    bool on_mesh = surface->kind == API_SURFACE_MESH;
    struct primitive *all = on_mesh ? mesh_primitives(&surface->mesh, arena, &kept)
                                    : arena_alloc(arena, count, sizeof *all);
    bool good = all != NULL;
    /* The primitives that have triangles. */
    for (size_t k = 0; good && !on_mesh && k < count; k++) {
        struct primitive *one = &all[kept];
        *one = (struct primitive){.number = k};
        one->face = surface->kind == API_SURFACE_SHELL ? &surface->faces[k] : surface;
        good = tessellate_face(one, one->face, count, arena);
        kept += one->index_count > 0;
    }
    const char *gltf = good && kept > 0 ? write_gltf(all, kept, arena, &bytes) : NULL;
    if (good && kept == 0)
        return api_problem_set(problem, API_DEGENERATE_SURFACE, "no face has an area");
    if (!gltf)
        return api_problem_no_memory(problem, "the preview");
    /* The header, the chunk of JSON, padded with spaces, and that of the buffer. */
    size_t length = strlen(gltf), padding = (4 - length % 4) % 4;
    const uint32_t head[5] = {0x46546c67, 2, (uint32_t)(28 + length + padding + bytes),
                              (uint32_t)(length + padding), 0x4e4f534a};
    const uint32_t chunk[2] = {(uint32_t)bytes, 0x004e4942};
    good = send_bytes(sink, head, sizeof head) && send_bytes(sink, gltf, length) &&
           send_bytes(sink, "   ", padding) && send_bytes(sink, chunk, sizeof chunk);
    for (size_t k = 0; good && k < kept; k++) {
        const void *part[3];
        size_t lengths[3], parts = parts_of(&all[k], part, lengths);
        for (size_t i = 0; good && i < parts; i++)
            good = send_bytes(sink, part[i], lengths[i]);
    }
    if (!good)
        api_problem_set(problem, API_UNAVAILABLE, "there is no disk space for the preview now");
    return problem->id;
}
