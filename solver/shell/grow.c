/* SPDX-License-Identifier: MIT */
#include "faces.h"
#include "solver/angle.h"

enum { LOOKS = 5 }; /* places of an edge at which its fold is looked at */

/* Of faces that are meant to be smooth or flat. */
static const double ROUNDING_DEG = 1e-6;

/* The normal of the face on its shell's side. */
static struct vec3 face_normal_at(const struct shell *shell, const struct face_curve *curve,
                                  const struct curve_place *place) {
    const struct face *face = &shell->faces[curve->face];
    return vec3_scale(face->side, vec3_unit(vec3_cross(place->jet.u, place->jet.v)));
}

void edge_normals(const struct shell *shell, const struct face_edge *edge, double share,
                  struct vec3 normal[2], struct vec3 *at) {
    const struct face_edge *mate = &shell->edges[edge->mate];
    const struct face_curve *other = &shell->curves[mate->curve];
    struct curve_place here, there;
    double across = edge->reversed ? 1 - share : share;
    edge_at_share(shell, edge, share, &here);
    curve_nearest(shell, other, here.r, mate->t[0] + across * (mate->t[1] - mate->t[0]), mate->t,
                  &there);
    normal[0] = face_normal_at(shell, &shell->curves[edge->curve], &here);
    normal[1] = face_normal_at(shell, other, &there);
    *at = here.r;
}

/* The largest angle by which the faces fold along an edge and its mate. */
static double fold_deg(const struct shell *shell, const struct face_edge *edge) {
    double largest = 0;
    for (int k = 0; k < LOOKS; k++) {
        struct vec3 n[2], at;
        edge_normals(shell, edge, (k + 0.5) / LOOKS, n, &at);
        double fold = angle_atan2_deg(vec3_norm(vec3_cross(n[0], n[1])), vec3_dot(n[0], n[1]));
        largest = fmax(largest, fold);
    }
    return largest;
}

bool shell_joint(const struct shell *shell, size_t number, int32_t face[2], double *fold) {
    const struct face_edge *edge = &shell->edges[number];
    if (edge->mate < (int64_t)number) /* free, or the second side */
        return false;
    face[0] = edge_face(shell, number);
    face[1] = edge_face(shell, (size_t)edge->mate);
    *fold = fold_deg(shell, edge);
    return true;
}

enum status shell_grow(const struct shell *shell, int32_t face, double up_to_deg,
                       struct arena *arena, uint8_t *reached) {
    struct arena_mark mark = arena_mark(arena);
    bool *smooth = arena_alloc(arena, shell->edge_count, sizeof *smooth);
    if (!smooth)
        return STATUS_OUT_OF_MEMORY;
    for (size_t k = 0; k < shell->edge_count; k++)
        smooth[k] = shell->edges[k].mate >= 0 &&
                    fold_deg(shell, &shell->edges[k]) <= up_to_deg + ROUNDING_DEG;
    for (size_t k = 0; k < shell->face_count; k++)
        reached[k] = k == (size_t)face;
    for (bool grew = true; grew;) {
        grew = false;
        for (size_t k = 0; k < shell->edge_count; k++) {
            const struct face_edge *edge = &shell->edges[k];
            if (!smooth[k] || !reached[edge_face(shell, k)])
                continue;
            uint8_t *next = &reached[edge_face(shell, (size_t)edge->mate)];
            grew = grew || !*next;
            *next = 1;
        }
    }
    arena_rewind(arena, mark);
    return STATUS_OK;
}
