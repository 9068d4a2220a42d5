/* SPDX-License-Identifier: MIT */
#include "faces.h"

#include <string.h>

size_t shell_edge_count(const struct shell *shell) {
    return shell->edge_count;
}

enum status shell_edge(const struct shell *shell, size_t number, int32_t component,
                       struct arena *arena, struct shell_edge *edge) {
    const struct face_edge *own = &shell->edges[number];
    int32_t number_of_face = edge_face(shell, number);
    const struct face *face = &shell->faces[number_of_face];
    *edge = (struct shell_edge){.face = number_of_face};
    if (own->mate != EDGE_FREE || own->bare || face->component != component)
        return STATUS_OK;
    /* its segments, which follow each other in its face */
    const struct face_segment *segments = face->segments;
    const struct face_segment *end = segments + face->segment_count;
    size_t count = 0;
    while (segments < end && segments->edge != (int32_t)number)
        segments++;
    while (segments + count < end && segments[count].edge == (int32_t)number)
        count++;
    if (count == 0)
        return STATUS_OK;
    edge->uv = arena_alloc(arena, count + 1, sizeof *edge->uv);
    if (!edge->uv)
        return STATUS_OUT_OF_MEMORY;
    bool forward = own->inside * face->surface.side > 0;
    for (size_t k = 0; k <= count; k++) {
        size_t at = forward ? k : count - k;
        memcpy(edge->uv[k], at < count ? segments[at].a : segments[count - 1].b, sizeof *edge->uv);
    }
    edge->count = count + 1;
    return STATUS_OK;
}
