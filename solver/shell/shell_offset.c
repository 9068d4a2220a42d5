/* SPDX-License-Identifier: MIT */
#include "faces.h"
#include "offset.h"
#include "solver/angle.h"

enum { LOOKS = 5 }; /* places of an edge at which its fold is looked at */

/* What faces that are meant to be smooth may fold by, in radians: moved edges gape by so much times
 * the height, and are joined over it. */
static const double smooth_fold = 0.02;

/* Finds the first joint that folds by more. */
static bool find_fold(const struct shell *shell, double height, struct shell_fault *fault) {
    for (size_t e = 0; e < shell->edge_count; e++) {
        const struct face_edge *edge = &shell->edges[e];
        if (edge->mate <= (int32_t)e)
            continue;
        for (int k = 0; k < LOOKS; k++) {
            struct vec3 normal[2], at;
            edge_normals(shell, edge, (k + 0.5) / LOOKS, normal, &at);
            double apart = vec3_distance(normal[0], normal[1]);
            if (!(fabs(height) * apart > smooth_fold * fabs(height) + shell->tolerance))
                continue;
            int32_t a = edge_face(shell, e);
            int32_t b = edge_face(shell, (size_t)edge->mate);
            double sine = vec3_norm(vec3_cross(normal[0], normal[1]));
            *fault = (struct shell_fault){
                .kind = SHELL_FOLDS,
                .face_count = 2,
                .face = {a < b ? a : b, a < b ? b : a},
                .at = at,
                .fold_deg = angle_atan2_deg(sine, vec3_dot(normal[0], normal[1]))};
            return true;
        }
    }
    return false;
}

enum status shell_offset(const struct shell *shell, const struct shell_patch *patches,
                         double height, struct arena *arena, struct shell **moved,
                         struct shell_fault *fault) {
    double tolerance = shell->tolerance + smooth_fold * fabs(height);
    struct shell_patch *own = arena_alloc(arena, shell->face_count, sizeof *own);
    if (!own)
        return STATUS_OUT_OF_MEMORY;
    if (find_fold(shell, height, fault))
        return STATUS_INVALID;
    for (size_t k = 0; k < shell->face_count; k++) {
        const struct face *face = &shell->faces[k];
        struct surface *surface;
        enum status status =
            surface_offset(patches[k].surface, face->side * height, arena, &surface);
        if (status == STATUS_OUT_OF_MEMORY)
            return status;
        if (status != STATUS_OK)
            return STATUS_INVALID;
        struct surface_offset_fault offset;
        if (!surface_offset_holds(surface, face->trim, tolerance, &offset)) {
            *fault =
                (struct shell_fault){.kind = offset.radius > 0 ? SHELL_TOO_CURVED : SHELL_FOLDS,
                                     .face_count = 1,
                                     .face = {(int32_t)k},
                                     .at = offset.at,
                                     .radius = offset.radius,
                                     .fold_deg = offset.fold_deg};
            return STATUS_INVALID;
        }
        own[k] = patches[k];
        own[k].surface = surface;
        own[k].trim = NULL;
    }
    return shell_make(own, shell->face_count, tolerance, arena, moved, fault);
}
