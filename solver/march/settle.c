/* SPDX-License-Identifier: MIT */
/*
 * Where a quadrant would lie on itself or on another part of the net. Its rows are marched a few at
 * a time without asking, side by side or not, and then looked at in their order, so that what stays
 * does not depend on how they were marched.
 */
#include "quadrant.h"

#include <stdlib.h>

enum status quadrant_note_climbed(struct quadrant *q, int32_t i, int32_t j) {
    struct arena *arena = q->march->arena;
    if (q->climbed_count == q->climbed_room) {
        q->climbed = arena_enlarge(arena, q->climbed, q->climbed_count, sizeof *q->climbed,
                                   &q->climbed_room);
        if (!q->climbed)
            return STATUS_OUT_OF_MEMORY;
    }
    q->climbed[q->climbed_count++] = (struct quadrant_place){i, j};
    return STATUS_OK;
}

static int compare_places(const void *a, const void *b) {
    const struct quadrant_place *p = a, *q = b;
    return p->j != q->j ? (p->j > q->j) - (p->j < q->j) : (p->i > q->i) - (p->i < q->i);
}

/* Whether the node at (i, j) lies on what comes before it. */
static bool lies_on_net(struct quadrant *q, int32_t i, int32_t j) {
    struct march *march = q->march;
    struct surface_point point;
    const struct net_node *node = net_find(march->net, i * q->si, j * q->sj);
    return node && node->state == NET_INSIDE &&
           overlap_is_near(march->overlap, i * q->si, j * q->sj, node->r) &&
           march_point_at(march, node, &point) &&
           overlap_meets_before(march->overlap, i * q->si, j * q->sj, &point);
}

/* Takes out (i, j) and what lies beyond its column in its row and those above, up to the one before
 * `end`: the place above it still has its cell. */
static enum status cut(struct quadrant *q, int32_t i, int32_t j, int32_t end) {
    static const struct net_node none = {.state = NET_UNKNOWN};
    struct march *march = q->march;
    enum status status = STATUS_OK;
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

/* Looks at a place, and cuts the net there if it has to be. */
static enum status settle_place(struct quadrant *q, int32_t i, int32_t j, int32_t end) {
    return lies_on_net(q, i, j) ? cut(q, i, j, end) : STATUS_OK;
}

static enum status settle_climbed(struct quadrant *q, int32_t end) {
    enum status status = STATUS_OK;
    if (q->climbed_count)
        qsort(q->climbed, q->climbed_count, sizeof *q->climbed, compare_places);
    for (size_t k = 0; k < q->climbed_count && status == STATUS_OK; k++) {
        struct quadrant_place p = q->climbed[k];
        const struct net_node *node = net_find(q->march->net, p.i * q->si, p.j * q->sj);
        status = overlap_add(q->march->overlap, p.i * q->si, p.j * q->sj, node->r);
    }
    for (size_t k = 0; k < q->climbed_count && status == STATUS_OK; k++)
        status = settle_place(q, q->climbed[k].i, q->climbed[k].j, end);
    q->climbed_count = 0;
    return status;
}

/* The k-th tile of the block from the weft arm on; NULL beyond the last one. */
static struct net_tile *tile_at(struct quadrant *q, int32_t k) {
    int32_t ti = q->si > 0 ? k : -1 - k, tj = q->settled * q->sj >> NET_TILE_BITS;
    return net_find_tile(&q->march->net->table[net_table_of(ti, tj)], ti, tj);
}

/* Of those of row j of the block that are suspected. */
static enum status settle_row(struct quadrant *q, const unsigned *suspects, int32_t count,
                              int32_t j, int32_t end) {
    enum status status = STATUS_OK;
    int y = j * q->sj & (NET_TILE - 1);
    for (int32_t i = 1; i < count * NET_TILE && i < q->length && status == STATUS_OK; i++) {
        int32_t k = q->si > 0 ? i / NET_TILE : (i - 1) / NET_TILE;
        int x = i * q->si & (NET_TILE - 1);
        if (suspects[k] >> overlap_patch_of(x, y) & 1)
            status = settle_place(q, i, j, end);
    }
    return status;
}

static enum status settle_rows(struct quadrant *q, int32_t end, struct arena *arena) {
    struct overlap *overlap = q->march->overlap;
    enum status status = STATUS_OK;
    struct net_tile *tile;
    int32_t count = 0;
    bool any = false;
    for (; status == STATUS_OK && (tile = tile_at(q, count)); count++)
        status = overlap_add_tile(overlap, tile, true);
    unsigned *suspects = arena_take(arena, (size_t)count, sizeof *suspects);
    if (!suspects || status != STATUS_OK)
        return STATUS_OUT_OF_MEMORY;
    for (int32_t k = 0; k < count; k++) {
        suspects[k] = overlap_suspects(overlap, tile_at(q, k));
        any = any || suspects[k];
    }
    for (int32_t j = q->settled; any && j < end && status == STATUS_OK; j++)
        status = settle_row(q, suspects, count, j, end);
    return status;
}

enum status quadrant_settle(struct quadrant *q, int32_t end) {
    struct quadrant_row *row = &q->row[0];
    enum status status = settle_climbed(q, end);
    if (status == STATUS_OK)
        status = settle_rows(q, end, q->march->arena);
    row->count = row->count < q->length ? row->count : q->length;
    row->last = row->last < q->length ? row->last : q->length - 1;
    for (int k = 0; k < 2; k++)
        q->reach[k] = q->reach[k] < q->length ? q->reach[k] : q->length - 1;
    q->settled = end;
    return status;
}
