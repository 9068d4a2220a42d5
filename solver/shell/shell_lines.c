/* SPDX-License-Identifier: MIT */
#include "faces.h"

#include <string.h>

/* Lines turn by no more than about this from piece to piece, in radians. */
static const double turn_most = 0.4;

/* Pieces of an edge that is one point in space, but not in the parameters: a pole. */
enum { PIECES_OF_POLE = 8 };

/* Ends of edges this near to each other, in tolerances, are one. */
static const double same_end = 3;

/* The arc length of an edge at its segments' ends, and how much it turns. */
struct ruler {
    const struct face_segment *segments;
    size_t count;
    double *at; /* count + 1 */
    double turn;
};

static enum status measure_ruler(const struct shell *shell, struct arena *arena,
                                 struct ruler *ruler) {
    const struct face_edge *edge = &shell->edges[ruler->segments[0].edge];
    const struct face_curve *curve = &shell->curves[edge->curve];
    struct curve_place place;
    struct vec3 before = {0, 0, 0}, last;
    ruler->at = arena_alloc(arena, ruler->count + 1, sizeof *ruler->at);
    if (!ruler->at)
        return STATUS_OUT_OF_MEMORY;
    curve_at(shell, curve, ruler->segments[0].t[0], &place);
    last = place.r;
    for (size_t k = 0; k < ruler->count; k++) {
        curve_at(shell, curve, ruler->segments[k].t[1], &place);
        struct vec3 way = vec3_sub(place.r, last);
        ruler->at[k + 1] = ruler->at[k] + vec3_norm(way);
        ruler->turn += k > 0 ? vec3_norm(vec3_sub(vec3_unit(before), vec3_unit(way))) : 0;
        before = way;
        last = place.r;
    }
    return STATUS_OK;
}

/* The curve's parameter at a share of the length. */
static double ruler_parameter(const struct ruler *ruler, double share) {
    double length = share * ruler->at[ruler->count];
    size_t k = 0;
    while (k + 1 < ruler->count && ruler->at[k + 1] < length)
        k++;
    double step = ruler->at[k + 1] - ruler->at[k];
    double part = step > 0 ? fmin(fmax((length - ruler->at[k]) / step, 0), 1) : 0;
    const double *t = ruler->segments[k].t;
    return t[0] + part * (t[1] - t[0]);
}

/* ---- ends ---- */

struct ends {
    const struct shell *shell;
    struct vec3 *at; /* of edge e: 2 e and 2 e + 1 */
    struct vec3 r;
    size_t number, found;
};

static bool find_first(void *context, int32_t number) {
    struct ends *ends = context;
    if ((size_t)number < ends->found &&
        vec3_distance(ends->shell->edges[number / 2].end[number % 2], ends->r) <=
            same_end * ends->shell->tolerance)
        ends->found = (size_t)number;
    return true;
}

/* Where the ends of all edges are: those that are one have the place of the first of them. */
static enum status gather_ends(const struct shell *shell, struct arena *arena, struct ends *ends) {
    size_t count = 2 * shell->edge_count;
    struct boxes *boxes;
    struct box *box = arena_take(arena, count, sizeof *box);
    *ends = (struct ends){.shell = shell, .at = arena_take(arena, count, sizeof *ends->at)};
    if (!box || !ends->at)
        return STATUS_OUT_OF_MEMORY;
    for (size_t k = 0; k < count; k++) {
        struct vec3 r = shell->edges[k / 2].end[k % 2];
        box[k] = box_round(r, r, same_end * shell->tolerance);
    }
    enum status status = boxes_make(box, count, arena, &boxes);
    for (size_t k = 0; k < count && status == STATUS_OK; k++) {
        ends->r = shell->edges[k / 2].end[k % 2];
        ends->found = k;
        boxes_visit(boxes, &box[k], find_first, ends);
        ends->at[k] = ends->found == k ? ends->r : ends->at[ends->found];
    }
    return status;
}

/* ---- lines ---- */

static enum status alloc_line(struct shell_line *line, size_t pieces, struct arena *arena) {
    line->count = pieces + 1;
    line->uv = arena_alloc(arena, line->count, sizeof *line->uv);
    line->r = arena_alloc(arena, line->count, sizeof *line->r);
    return line->uv && line->r ? STATUS_OK : STATUS_OUT_OF_MEMORY;
}

/* The line of an edge; on the other side of a joint, that of whose first is `first`, else NULL, it
 * has the points of that, with parameters of its own. */
static enum status make_line(const struct ends *ends, const struct ruler *ruler, double size,
                             const struct shell_line *first, struct arena *arena,
                             struct shell_line *line) {
    const struct shell *shell = ends->shell;
    size_t number = (size_t)ruler->segments[0].edge;
    const struct face_edge *edge = &shell->edges[number];
    const struct face_curve *curve = &shell->curves[edge->curve];
    double pieces = fmax(ruler->at[ruler->count] / size * (1 - 1e-9), ruler->turn / turn_most);
    size_t last = first ? first->count - 1 : (size_t)fmax(ceil(pieces), 1);
    enum status status = alloc_line(line, last, arena);
    for (size_t k = 0; status == STATUS_OK && k <= last; k++) {
        struct curve_place place;
        double from = ruler_parameter(ruler, (double)k / (double)last);
        if (first)
            line->r[k] = first->r[edge->reversed ? last - k : k];
        if (first && k > 0 && k < last)
            (void)curve_nearest(shell, curve, line->r[k], from, edge->t, &place);
        else
            curve_at(shell, curve, from, &place);
        memcpy(line->uv[k], place.uv, sizeof *line->uv);
        if (!first)
            line->r[k] = k == 0      ? ends->at[2 * number]
                         : k == last ? ends->at[2 * number + 1]
                                     : place.r;
    }
    return status;
}

enum status shell_lines(const struct shell *shell, int32_t component, double size,
                        struct arena *arena, struct shell_line **lines) {
    struct ends ends;
    struct shell_line *made = arena_alloc(arena, shell->edge_count, sizeof *made);
    enum status status = made ? gather_ends(shell, arena, &ends) : STATUS_OUT_OF_MEMORY;
    for (size_t k = 0; k < shell->face_count && status == STATUS_OK; k++) {
        const struct face *face = &shell->faces[k];
        if (face->component != component || face->duplicate)
            continue;
        /* in the order of the face's segments */
        for (uint32_t s = 0; s < face->segment_count && status == STATUS_OK;) {
            struct ruler ruler = {.segments = face->segments + s};
            int32_t number = face->segments[s].edge, mate = shell->edges[number].mate;
            for (; s < face->segment_count && face->segments[s].edge == number; s++)
                ruler.count++;
            const struct shell_line *first =
                mate != EDGE_FREE && made[mate].count > 0 ? &made[mate] : NULL;
            status = measure_ruler(shell, arena, &ruler);
            if (status == STATUS_OK)
                status = make_line(&ends, &ruler, size, first, arena, &made[number]);
        }
    }
    for (size_t e = 0; e < shell->edge_count && status == STATUS_OK; e++) {
        const struct face_edge *edge = &shell->edges[e];
        const struct face *face = &shell->faces[edge_face(shell, e)];
        made[e].face = face->surface.face;
        if (!edge->bare || face->component != component || face->duplicate ||
            !edge_is_point(shell, edge, same_end * shell->tolerance))
            continue;
        status = alloc_line(&made[e], PIECES_OF_POLE, arena);
        for (size_t k = 0; status == STATUS_OK && k <= PIECES_OF_POLE; k++) {
            struct curve_place place;
            edge_at_share(shell, edge, (double)k / PIECES_OF_POLE, &place);
            memcpy(made[e].uv[k], place.uv, sizeof *made[e].uv);
            made[e].r[k] = ends.at[2 * e + (k == PIECES_OF_POLE)];
        }
    }
    *lines = made;
    return status;
}
