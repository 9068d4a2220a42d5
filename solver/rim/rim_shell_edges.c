/* SPDX-License-Identifier: MIT */
/* The edges of a shell: those of its faces that are not joined, and both sides of the slit. */
#include "rim_builder.h"

#include <math.h>
#include <string.h>

/* The free edges as chains: first both sides of the slit, piece by piece, number 2 k and 2 k + 1.
 */
struct free_edges {
    struct shell_edge *edges;
    struct vec3 (*ends)[2];
    bool *used;
    size_t count, of_slit;
};

static struct vec3 rim_point_on_face(struct rim_builder *b, int32_t face, const double uv[2]) {
    struct surface_jet jet;
    surface_jet_at(rim_edges_surface(b->march, face), &b->march->cursor, uv[0], uv[1], &jet);
    return jet.r;
}

static void set_edge_ends(struct rim_builder *b, struct free_edges *found, size_t k) {
    const struct shell_edge *edge = &found->edges[k];
    for (int end = 0; end < 2; end++)
        found->ends[k][end] = rim_point_on_face(b, edge->face, edge->uv[end ? edge->count - 1 : 0]);
}

/* Divides the free edge on which the slit ends at `uv` of a face, which becomes a place of it. At
 * its end there is nothing to divide. */
static void divide_edge(struct rim_builder *b, struct free_edges *found, int32_t face,
                        double uv[2]) {
    const struct surface *surface = rim_edges_surface(b->march, face);
    double least = HUGE_VAL, at[2] = {0, 0}, share;
    size_t best = 0, piece = 0;
    /* the nearest place of the face's edges */
    for (size_t k = found->of_slit; k < found->count; k++)
        for (size_t n = 0; found->edges[k].face == face && n + 1 < found->edges[k].count; n++) {
            const double *from = found->edges[k].uv[n], *to = found->edges[k].uv[n + 1];
            double own = rim_builder_deviation(b, surface, from, to, uv, &share);
            if (!(own < least))
                continue;
            least = own;
            best = k;
            piece = n;
            for (int m = 0; m < 2; m++)
                at[m] = from[m] + share * (to[m] - from[m]);
        }
    struct shell_edge *edge = &found->edges[best], *rest = &found->edges[found->count];
    if (least < HUGE_VAL) {
        /* A ring ends where it begins: which of the two is meant the piece tells. */
        struct vec3 r = rim_point_on_face(b, face, at);
        const struct vec3 *end = found->ends[best];
        if ((piece == 0 && vec3_distance(r, end[0]) <= b->tolerance) ||
            (piece + 2 == edge->count && vec3_distance(r, end[1]) <= b->tolerance)) {
            memcpy(uv, at, sizeof at);
            return;
        }
    }
    double(*first)[2] = arena_alloc(b->march->arena, piece + 2, sizeof *first);
    b->failed = b->failed || !first;
    if (b->failed || !(least < HUGE_VAL))
        return;
    memcpy(first, edge->uv, (piece + 1) * sizeof *first);
    memcpy(first[piece + 1], at, sizeof at);
    memcpy(uv, at, sizeof at);
    *rest = (struct shell_edge){face, edge->uv + piece, edge->count - piece};
    memcpy(rest->uv[0], at, sizeof at);
    *edge = (struct shell_edge){face, first, piece + 2};
    set_edge_ends(b, found, best);
    set_edge_ends(b, found, found->count++);
}

/* Finds the free edges of the faces, and adds the sides of the slit, whose ends at the boundary
 * divide the edges there. */
static bool find_free_edges(struct rim_builder *b, struct free_edges *found) {
    struct march *march = b->march;
    const struct shell *shell = march->surface->shell;
    int32_t component = shell_component(shell, march->surface->face);
    size_t pieces = 0, count = shell_edge_count(shell);
    const struct shell_slit_piece *piece =
        march->cut.slit[0] ? shell_slit_pieces(march->cut.slit[0], &pieces) : NULL;
    size_t room = count + 4 * pieces;
    found->edges = arena_alloc(march->arena, room, sizeof *found->edges);
    found->ends = arena_alloc(march->arena, room, sizeof *found->ends);
    found->used = arena_alloc(march->arena, room, sizeof *found->used);
    if (!found->edges || !found->ends || !found->used)
        return false;
    found->count = found->of_slit = 2 * pieces;
    for (size_t k = 0; k < count; k++) {
        struct shell_edge *edge = &found->edges[found->count];
        if (shell_edge(shell, k, component, march->arena, edge) != STATUS_OK)
            return false;
        if (edge->count > 0)
            set_edge_ends(b, found, found->count++);
    }
    for (size_t n = 0; n < pieces; n++, piece++) {
        double(*uv)[2] = arena_alloc(march->arena, 2 * piece->count, sizeof *uv);
        if (!uv)
            return false;
        memcpy(uv, piece->uv, piece->count * sizeof *uv);
        if (piece->begins)
            divide_edge(b, found, piece->face, uv[0]);
        if (piece->ends)
            divide_edge(b, found, piece->face, uv[piece->count - 1]);
        for (size_t k = 0; k < piece->count; k++)
            memcpy(uv[2 * piece->count - 1 - k], uv[k], sizeof *uv);
        for (size_t side = 0; side < 2; side++) {
            found->edges[2 * n + side] =
                (struct shell_edge){piece->face, uv + side * piece->count, piece->count};
            set_edge_ends(b, found, 2 * n + side);
        }
    }
    return !b->failed;
}

/* Whether two edges are the sides of the same piece of the slit. */
static bool turns_back(const struct free_edges *found, size_t edge, size_t other) {
    return edge < found->of_slit && (edge ^ other) == 1;
}

/* Edge after edge, each that whose beginning is nearest to the end of the last, until it is the
 * loop's own. */
void rim_builder_add_shell(struct rim_builder *b) {
    struct free_edges found = {.count = 0};
    b->failed = !find_free_edges(b, &found);
    for (size_t first = 0; first < found.count && !b->failed; first++) {
        size_t at = first;
        if (found.used[first])
            continue;
        while (!found.used[at] && !b->failed) {
            /* its vertices, of which a polyline within the tolerance needs no more */
            const struct shell_edge *edge = &found.edges[at];
            const double(*uv)[2] = (const double(*)[2])edge->uv;
            const uint8_t *kept = rim_builder_keep_points(
                b, rim_edges_surface(b->march, edge->face), uv, edge->count);
            for (size_t k = 0; kept && k < edge->count && !b->failed; k++)
                if (kept[k])
                    rim_builder_add_vertex(
                        b, &(struct rim_vertex){.face = edge->face,
                                                .uv = {uv[k][0], uv[k][1]},
                                                .r = rim_point_on_face(b, edge->face, uv[k]),
                                                .leaps = k + 1 == edge->count});
            size_t next = first;
            double best = turns_back(&found, at, first)
                              ? HUGE_VAL
                              : vec3_distance(found.ends[at][1], found.ends[first][0]);
            found.used[at] = true;
            for (size_t k = 0; k < found.count; k++) {
                double gap = vec3_distance(found.ends[at][1], found.ends[k][0]);
                if (found.used[k] || turns_back(&found, at, k) || gap >= best)
                    continue;
                next = k;
                best = gap;
            }
            at = next;
        }
        rim_builder_end_loop(b, false);
    }
}
