/* SPDX-License-Identifier: MIT */
#include "faces.h"

#include "bounds.h"
#include <string.h>

static enum status fail(struct shell_fault *fault, enum shell_fault_kind kind, int32_t face) {
    if (fault)
        *fault = (struct shell_fault){.kind = kind, .face_count = face >= 0, .face = {face}};
    return kind == SHELL_NOTHING_LEFT ? STATUS_DEGENERATE_SURFACE : STATUS_INVALID;
}

static enum status make_face(const struct shell_part *part, struct arena *arena,
                             struct face *face) {
    face->surface = *part->surface;
    face->side = 1;
    if (part->loop_count == 0) {
        face->area = surface_area(part->surface, &face->centroid);
        return STATUS_OK;
    }
    enum status status =
        trim_make(part->surface, part->loops, part->loop_count, arena, &face->trim);
    if (status == STATUS_OK)
        face->area = trim_area(face->trim, &face->centroid);
    return status;
}

static void find_bounds(struct shell *shell) {
    for (size_t k = 0; k < shell->face_count; k++) {
        struct vec3 low, high;
        bounds_tight(&shell->faces[k].surface, &low, &high);
        if (k == 0) {
            shell->lower = low;
            shell->upper = high;
        }
        struct vec3 *a = &shell->lower, *b = &shell->upper;
        *a = vec3_make(fmin(a->x, low.x), fmin(a->y, low.y), fmin(a->z, low.z));
        *b = vec3_make(fmax(b->x, high.x), fmax(b->y, high.y), fmax(b->z, high.z));
    }
    shell->size = vec3_distance(shell->lower, shell->upper);
}

enum status shell_make(const struct shell_part *parts, size_t count, double tolerance,
                       struct arena *arena, struct shell **shell, struct shell_fault *fault) {
    struct shell *made = arena_alloc(arena, 1, sizeof *made);
    if (fault)
        *fault = (struct shell_fault){.kind = SHELL_FAULTLESS};
    if (count == 0 || count > SHELL_FACES_MAX)
        return fail(fault, SHELL_TOO_MANY, -1);
    if (!made || !(made->faces = arena_alloc(arena, count, sizeof *made->faces)))
        return STATUS_OUT_OF_MEMORY;
    made->face_count = count;
    for (size_t k = 0; k < count; k++) {
        enum status status = make_face(&parts[k], arena, &made->faces[k]);
        if (status == STATUS_DEGENERATE_SURFACE)
            return fail(fault, SHELL_NOTHING_LEFT, (int32_t)k);
        if (status != STATUS_OK)
            return status;
        made->faces[k].component = (int32_t)k;
    }
    made->component_count = count;
    find_bounds(made);
    made->tolerance = tolerance == 0 ? SHELL_TOLERANCE * made->size : tolerance;
    if (!(made->tolerance > 0 && made->tolerance < made->size))
        return fail(fault, SHELL_TOLERANCE_BAD, -1);
    *shell = made;
    return STATUS_OK;
}

size_t shell_face_count(const struct shell *shell) {
    return shell->face_count;
}

const struct surface *shell_surface(const struct shell *shell, int32_t face) {
    return &shell->faces[face].surface;
}

const struct trim *shell_trim(const struct shell *shell, int32_t face) {
    return shell->faces[face].trim;
}

int32_t shell_component(const struct shell *shell, int32_t face) {
    return shell->faces[face].component;
}

size_t shell_component_count(const struct shell *shell) {
    return shell->component_count;
}

struct shell_edges shell_edges(const struct shell *shell) {
    return shell->edges;
}

double shell_tolerance(const struct shell *shell) {
    return shell->tolerance;
}

void shell_bounds(const struct shell *shell, struct vec3 *lower, struct vec3 *upper) {
    *lower = shell->lower;
    *upper = shell->upper;
}

double shell_size(const struct shell *shell) {
    return shell->size;
}

double shell_area(const struct shell *shell, int32_t component, struct vec3 *centroid) {
    double area = 0;
    struct vec3 moment = {0, 0, 0};
    for (size_t k = 0; k < shell->face_count; k++) {
        const struct face *face = &shell->faces[k];
        if (face->component != component)
            continue;
        area += face->area;
        moment = vec3_axpy(face->area, face->centroid, moment);
    }
    if (centroid)
        *centroid = vec3_scale(1 / area, moment);
    return area;
}
