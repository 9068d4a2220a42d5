/* SPDX-License-Identifier: MIT */
/*
 * Where a quadrant would lie on itself or on another part of the net. Its rows are marched a few at
 * a time without asking, side by side or not, and then looked at in their order, so that what stays
 * does not depend on how they were marched.
 */
#include "quadrant.h"

#include <stdlib.h>

enum status quadrant_note_late(struct quadrant *q, int32_t i, int32_t j) {
    struct arena *arena = q->march->arena;
    if (q->late_count == q->late_room) {
        q->late = arena_enlarge(arena, q->late, q->late_count, sizeof *q->late, &q->late_room);
        if (!q->late)
            return STATUS_OUT_OF_MEMORY;
    }
    q->late[q->late_count++] = (struct quadrant_place){i, j};
    return STATUS_OK;
}

static int compare_places(const void *a, const void *b) {
    const struct quadrant_place *p = a, *q = b;
    return p->j != q->j ? (p->j > q->j) - (p->j < q->j) : (p->i > q->i) - (p->i < q->i);
}

/* Looks at the node (i, j). Where it lies on what comes before it, it is taken out with what lies
 * beyond its column in its row and those above, up to the one before `end`: the place above it
 * still has its cell. */
static enum status check_node(struct quadrant *q, int32_t i, int32_t j, int32_t end) {
    static const struct net_node none = {.state = NET_UNKNOWN};
    struct march *march = q->march;
    struct surface_point point;
    enum status status = STATUS_OK;
    const struct net_node *node = net_find(march->net, i * q->si, j * q->sj);
    if (!node || node->state != NET_INSIDE ||
        !overlap_is_near(march->overlap, i * q->si, j * q->sj, node->r) ||
        !march_point_at(march, node, &point) ||
        !overlap_meets_before(march->overlap, i * q->si, j * q->sj, &point))
        return STATUS_OK;
    for (int32_t row = j; row < end; row++)
        for (int32_t at = row == j ? i : i + 1; status == STATUS_OK; at++) {
            enum net_state state = net_state_at(march->net, at * q->si, row * q->sj);
            if (state == NET_UNKNOWN)
                break;
            march->counts.inside -= state == NET_INSIDE;
            march->counts.ghosts -= state == NET_GHOST;
            status = net_put(march->net, at * q->si, row * q->sj, &none);
            overlap_forget(march->overlap, at * q->si, row * q->sj);
        }
    q->length = i + 1 < q->length ? i + 1 : q->length;
    return status == STATUS_OK ? march_fail(march, i * q->si, j * q->sj, DRAPE_REASON_FOLD)
                               : status;
}

/* The k-th tile of the block from the weft arm on; NULL beyond the last one. */
static struct net_tile *tile_at(struct quadrant *q, int32_t k) {
    int32_t ti = q->si > 0 ? k : -1 - k, tj = q->checked * q->sj >> NET_TILE_BITS;
    return net_find_tile(&q->march->net->table[net_table_of(ti, tj)], ti, tj);
}

enum status quadrant_check_overlaps(struct quadrant *q, int32_t end) {
    struct quadrant_row *row = &q->row[0];
    enum status status = STATUS_OK;
    /* First the nodes that were put into rows which had been looked at. */
    if (q->late_count)
        qsort(q->late, q->late_count, sizeof *q->late, compare_places);
    for (size_t k = 0; k < q->late_count && status == STATUS_OK; k++) {
        struct quadrant_place p = q->late[k];
        const struct net_node *node = net_find(q->march->net, p.i * q->si, p.j * q->sj);
        status = overlap_add(q->march->overlap, p.i * q->si, p.j * q->sj, node->r);
    }
    for (size_t k = 0; k < q->late_count && status == STATUS_OK; k++)
        status = check_node(q, q->late[k].i, q->late[k].j, end);
    q->late_count = 0;
    /* Then those of the block whose patches lie near others. */
    struct overlap *overlap = q->march->overlap;
    struct net_tile *tile;
    int32_t count = 0;
    for (; status == STATUS_OK && (tile = tile_at(q, count)); count++)
        status = overlap_add_tile(overlap, tile, true);
    unsigned *suspects = NULL, any = 0;
    if (status == STATUS_OK &&
        !(suspects = arena_take(q->march->arena, (size_t)count, sizeof *suspects)))
        status = STATUS_OUT_OF_MEMORY;
    for (int32_t k = 0; k < count && status == STATUS_OK; k++)
        any |= suspects[k] = overlap_suspects(overlap, tile_at(q, k));
    for (int32_t j = q->checked; any && j < end; j++) {
        int y = j * q->sj & (NET_TILE - 1);
        for (int32_t i = 1; i < count * NET_TILE && i < q->length && status == STATUS_OK; i++) {
            int32_t k = q->si > 0 ? i / NET_TILE : (i - 1) / NET_TILE;
            int x = i * q->si & (NET_TILE - 1);
            if (suspects[k] >> overlap_patch_of(x, y) & 1)
                status = check_node(q, i, j, end);
        }
    }
    row->count = row->count < q->length ? row->count : q->length;
    row->last = row->last < q->length ? row->last : q->length - 1;
    for (int k = 0; k < 2; k++)
        q->reach[k] = q->reach[k] < q->length ? q->reach[k] : q->length - 1;
    q->checked = end;
    return status;
}
