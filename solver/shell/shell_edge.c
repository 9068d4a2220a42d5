/* SPDX-License-Identifier: MIT */
#include "faces.h"

#include <string.h>

size_t shell_edge_count(const struct shell *shell) {
    return shell->edge_count;
}

/* The segments of an edge, which follow each other in its face. */
static const struct face_segment *segments_of(const struct face *face, int32_t edge,
                                              size_t *count) {
    uint32_t first = 0;
    while (first < face->segment_count && face->segments[first].edge != edge)
        first++;
    for (*count = 0;
         first + *count < face->segment_count && face->segments[first + *count].edge == edge;)
        ++*count;
    return face->segments + first;
}

enum status shell_edge(const struct shell *shell, size_t number, int32_t component,
                       struct arena *arena, struct shell_edge *edge) {
    const struct face_edge *own = &shell->edges[number];
    int32_t number_of_face = edge_face(shell, number);
    const struct face *face = &shell->faces[number_of_face];
    size_t count;
    *edge = (struct shell_edge){.face = number_of_face};
    if (own->mate != EDGE_FREE || own->bare || face->component != component)
        return STATUS_OK;
    const struct face_segment *segments = segments_of(face, (int32_t)number, &count);
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
