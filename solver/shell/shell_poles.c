/* SPDX-License-Identifier: MIT */
/* Which faces of a shell meet at the poles of others: those that have an edge with an end there. */
#include "faces.h"

struct pole_search {
    struct shell *shell;
    struct arena *arena;
    int32_t face; /* the one with the pole */
    struct vec3 at;
    struct shell_corner *corners;
    size_t count, room;
    bool failed;
};

/* Takes the face of an edge that has its end 0 or 1 there, number / 2 and number % 2, once. */
static bool take_corner(void *context, int32_t number) {
    struct pole_search *search = context;
    const struct shell *shell = search->shell;
    const struct face_edge *edge = &shell->edges[number / 2];
    int32_t face = edge_face(shell, (size_t)number / 2);
    bool known = face == search->face || edge->bare || shell->faces[face].duplicate ||
                 vec3_distance(edge->end[number % 2], search->at) > 2 * shell->tolerance;
    for (size_t k = 0; k < search->count && !known; k++)
        known = search->corners[k].face == face;
    if (known)
        return true;
    if (search->count == search->room)
        search->corners = arena_enlarge(search->arena, search->corners, search->count,
                                        sizeof *search->corners, &search->room);
    search->failed = !search->corners;
    if (search->failed)
        return false;
    struct curve_place place;
    edge_at_share(shell, edge, number % 2, &place);
    search->corners[search->count++] = (struct shell_corner){face, {place.uv[0], place.uv[1]}};
    return true;
}

enum status faces_round_poles(struct shell *shell, struct arena *arena) {
    struct boxes *ends = NULL;
    for (size_t k = 0; k < shell->face_count; k++) {
        struct face *face = &shell->faces[k];
        for (int end = 0; face->surface.has_poles && end < 4; end++) {
            const struct surface_axis *axis = &face->surface.axis[end / 2];
            if (!axis->pole[end % 2])
                continue;
            if (!ends) { /* the first pole: most shells have none */
                struct box *boxes = arena_take(arena, 2 * shell->edge_count, sizeof *boxes);
                for (size_t e = 0; boxes && e < 2 * shell->edge_count; e++) {
                    struct vec3 r = shell->edges[e / 2].end[e % 2];
                    boxes[e] = box_round(r, r, 2 * shell->tolerance);
                }
                if (!boxes || boxes_make(boxes, 2 * shell->edge_count, arena, &ends) != STATUS_OK)
                    return STATUS_OUT_OF_MEMORY;
            }
            struct pole_search search = {.shell = shell,
                                         .arena = arena,
                                         .face = (int32_t)k,
                                         .at = axis->pole_point[end % 2]};
            struct box box = box_round(search.at, search.at, 0);
            boxes_visit(ends, &box, take_corner, &search);
            if (search.failed)
                return STATUS_OUT_OF_MEMORY;
            face->round_pole[end] = search.corners;
            face->round_pole_count[end] = search.count;
        }
    }
    return STATUS_OK;
}

size_t shell_round_pole(const struct surface *surface, int end,
                        const struct shell_corner **corners) {
    const struct face *face = face_of_surface(surface);
    *corners = face->round_pole[end];
    return face->round_pole_count[end];
}
