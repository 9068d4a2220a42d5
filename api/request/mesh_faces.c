/* SPDX-License-Identifier: MIT */
#include "mesh_faces.h"

#include "solver/mesh/grow.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* How far a point that selects may be from the mesh, of its size. */
static const double near_share = 0.01;

const int32_t *mesh_face_numbers(const struct mesh *mesh, struct arena *arena, size_t *count) {
    int32_t *face = arena_alloc(arena, mesh->triangle_count, sizeof *face);
    *count = face ? mesh_faces(mesh, arena, face) : 0;
    if (*count > MESH_FACES_MAX) {
        memset(face, 0, mesh->triangle_count * sizeof *face);
        *count = 1;
    }
    return *count > 0 ? face : NULL;
}

/* ---- selecting ---- */

static enum api_problem_id refuse_count(const char *pointer, const char *what, size_t count,
                                        struct api_problem *problem) {
    return api_problem_add(problem, pointer, "must be less than %zu, the number of %s of the mesh",
                           count, what);
}

/* Marks the triangles of the faces that are listed, or that the selection grows from. */
static enum api_problem_id mark_faces(const struct api_selection *selection,
                                      const struct mesh *mesh, struct arena *arena, int32_t *marked,
                                      struct api_problem *problem) {
    bool listed = selection->kind == API_SELECT_LIST;
    size_t count, chosen = listed ? selection->count : 1;
    const int32_t *face = mesh_face_numbers(mesh, arena, &count);
    uint8_t *wanted = face ? arena_alloc(arena, count, 1) : NULL;
    char pointer[API_POINTER_MAX] = "/surface/grow_from";
    if (!wanted)
        return api_problem_no_memory(problem, "the faces");
    for (size_t k = 0; k < chosen; k++) {
        int number = listed ? selection->faces[k] : selection->grow_from;
        if (listed)
            (void)snprintf(pointer, sizeof pointer, "/surface/faces/%zu", k);
        if ((size_t)number >= count)
            return refuse_count(pointer, "faces", count, problem);
        wanted[number] = 1;
    }
    for (size_t t = 0; t < mesh->triangle_count; t++)
        marked[t] = wanted[face[t]];
    return API_OK;
}

/* Marks the triangle that the selection names. */
static enum api_problem_id mark_triangle(const struct api_selection *selection,
                                         const struct mesh *mesh, int32_t *marked,
                                         struct api_problem *problem) {
    struct mesh_point nearest = {.triangle = selection->grow_from};
    double distance = 0;
    if (selection->seed == API_SEED_POINT)
        (void)mesh_nearest(mesh, selection->point, MESH_ANY, &nearest, &distance);
    else if ((size_t)selection->grow_from >= mesh->triangle_count)
        return refuse_count("/surface/grow_from/element", "triangles", mesh->triangle_count,
                            problem);
    if (distance > near_share * mesh->size)
        return api_problem_add(problem, "/surface/grow_from/point",
                               "is %.4g away from the mesh, whose nearest point is (%.6g, %.6g, "
                               "%.6g)",
                               distance, nearest.r.x, nearest.r.y, nearest.r.z);
    marked[nearest.triangle] = 1;
    return API_OK;
}

enum api_problem_id mesh_faces_choose(const struct api_selection *selection, struct arena *arena,
                                      struct mesh **mesh, struct api_problem *problem) {
    bool grown = selection->kind == API_SELECT_GROWN;
    struct mesh *part;
    if (selection->kind == API_SELECT_ALL)
        return API_OK;
    int32_t *marked = arena_alloc(arena, (*mesh)->triangle_count, sizeof *marked);
    if (!marked)
        return api_problem_no_memory(problem, "the faces");
    if ((grown && selection->seed != API_SEED_FACE
             ? mark_triangle(selection, *mesh, marked, problem)
             : mark_faces(selection, *mesh, arena, marked, problem)) != API_OK)
        return problem->id;
    if ((grown && mesh_grow(*mesh, selection->up_to_deg, arena, marked) != STATUS_OK) ||
        mesh_part(*mesh, marked, arena, &part) != STATUS_OK)
        return api_problem_no_memory(problem, "the faces");
    *mesh = part;
    return API_OK;
}

/* ---- describing ---- */

struct measured_face {
    double area;                /* twice */
    struct vec3 centre, normal; /* times that */
    struct vec3 lower, upper;
};

static void measure_faces(const struct mesh *mesh, const int32_t *face,
                          struct measured_face *measured) {
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        struct measured_face *one = &measured[face[t]];
        struct vec3 p[3];
        mesh_corner_points(mesh, (int32_t)t, p);
        struct vec3 normal = vec3_cross(vec3_sub(p[1], p[0]), vec3_sub(p[2], p[0]));
        double area = vec3_norm(normal);
        for (int k = 0; k < 3; k++) {
            one->lower = one->area > 0 || k ? vec3_min(one->lower, p[k]) : p[k];
            one->upper = one->area > 0 || k ? vec3_max(one->upper, p[k]) : p[k];
            one->centre = vec3_axpy(area / 3, p[k], one->centre);
        }
        one->area += area;
        one->normal = vec3_add(one->normal, normal);
    }
}

static void write_measured_face(struct api_text *text, size_t index,
                                const struct measured_face *face) {
    struct vec3 centre = vec3_scale(1 / face->area, face->centre);
    double length = vec3_norm(face->normal);
    struct vec3 normal = vec3_scale(length > 1e-9 * face->area ? 1 / length : 0, face->normal);
    api_text_raw(text, index ? ",{" : "{");
    api_text_key_integer(text, "index", (int64_t)index);
    api_text_key_number(text, "area", face->area / 2);
    api_text_box(text, &face->lower.x, &face->upper.x);
    api_text_key_numbers(text, "centre", &centre.x, 3);
    api_text_key_numbers(text, "normal", &normal.x, 3);
    api_text_key_string(text, "kind", "mesh");
    api_text_raw(text, "}");
}

struct mesh_joint {
    int32_t face[2];
    double fold_deg;
};

static int compare_joints(const void *x, const void *y) {
    const struct mesh_joint *a = x, *b = y;
    for (int k = 0; k < 2; k++)
        if (a->face[k] != b->face[k])
            return a->face[k] < b->face[k] ? -1 : 1;
    return (a->fold_deg > b->fold_deg) - (a->fold_deg < b->fold_deg);
}

/* Of every two faces that meet, once, with the least fold between them. */
static bool write_joints(const struct mesh *mesh, const int32_t *face, struct arena *arena,
                         struct api_text *text) {
    size_t count = 0;
    const char *before = "[";
    struct mesh_joint *joints =
        arena_alloc(arena, 3 * mesh->triangle_count / 2 + 1, sizeof *joints);
    if (!joints)
        return false;
    for (int32_t half = 0; (size_t)half < 3 * mesh->triangle_count; half++) {
        int32_t twin = mesh->twins[half];
        if (twin == MESH_NONE || face[half / 3] >= face[twin / 3])
            continue;
        joints[count++] =
            (struct mesh_joint){{face[half / 3], face[twin / 3]}, mesh_edge_fold_deg(mesh, half)};
    }
    qsort(joints, count, sizeof *joints, compare_joints);
    api_text_key(text, "joints");
    for (size_t k = 0; k < count; k++) {
        const struct mesh_joint *one = &joints[k];
        if (k > 0 && one[-1].face[0] == one->face[0] && one[-1].face[1] == one->face[1])
            continue;
        api_text_raw(text, before);
        api_text_numbers(text, (const double[]){one->face[0], one->face[1], one->fold_deg}, 3);
        before = ",";
    }
    api_text_raw(text, *before == '[' ? "[]" : "]");
    return true;
}

static bool write_openings(const struct mesh *mesh, struct arena *arena, struct api_text *text) {
    struct mesh_opening *openings;
    size_t count;
    if (mesh_openings(mesh, arena, &openings, &count) != STATUS_OK)
        return false;
    api_text_key(text, "openings");
    api_text_raw(text, "[");
    for (size_t k = 0; k < count && k < MESH_OPENINGS_SHOWN; k++) {
        api_text_raw(text, k ? ",{" : "{");
        api_text_key_integer(text, "edges", (int64_t)openings[k].edges);
        api_text_key_number(text, "length", openings[k].length);
        api_text_key_numbers(text, "centre", &openings[k].centre.x, 3);
        api_text_raw(text, "}");
    }
    api_text_raw(text, "]");
    api_text_key_integer(text, "opening_count", (int64_t)count);
    return true;
}

bool mesh_faces_describe(const struct mesh *mesh, struct arena *arena, struct api_text *text) {
    size_t count;
    const int32_t *face = mesh_face_numbers(mesh, arena, &count);
    struct measured_face *measured = face ? arena_alloc(arena, count, sizeof *measured) : NULL;
    if (!measured)
        return false;
    measure_faces(mesh, face, measured);
    api_text_key(text, "faces");
    api_text_raw(text, "[");
    for (size_t k = 0; k < count; k++)
        write_measured_face(text, k, &measured[k]);
    api_text_raw(text, "]");
    return write_joints(mesh, face, arena, text) && write_openings(mesh, arena, text);
}
