/* SPDX-License-Identifier: MIT */
/*
 * What lies behind a cut, row by row. A row that meets a lip goes on behind it from the row below:
 * at the first place to which weft goes straight on there. Where the row below ends at a lip that
 * leans away it goes straight on itself, up to that lip. So all else is cells again, in the rows of
 * the quadrant. What is reached otherwise, or where branches of the net may come together, is left
 * to the growth.
 */
#include "quadrant.h"

/* A yarn goes straight on by the three places before, which must not be another quadrant's. */
enum { PLACES_BEFORE = 3 };

/* The next place of a row by a yarn that goes straight on from the one before it (family 0), or
 * below it: whether there is one, and no cut on the way. */
static bool goes_straight(struct quadrant *q, const struct quadrant_row *row, int32_t j, int family,
                          const struct surface_point *from, struct surface_point *to) {
    struct march *march = q->march;
    int di = family ? 0 : q->si, dj = family ? q->sj : 0;
    int32_t i = row->count * q->si - di, at = j * q->sj - dj;
    enum drape_reason reason;
    const struct net_node *node =
        quadrant_node(q, row->count - (family ? 0 : 1), j - (family ? 1 : 0));
    return (family ? j : row->count) >= PLACES_BEFORE && node->state == NET_INSIDE &&
           march_in_extent(march, i + di, at + dj) &&
           march_goes_on(march, i, at, di, dj, from, to, &reason) &&
           !march_is_parted(march, i + di, at + dj, -di, -dj, to);
}

/* Puts it; `lacks` says what it is short of. */
static enum status put_straight(struct quadrant *q, const struct quadrant_row *below,
                                struct quadrant_row *row, int32_t j, int family, uint8_t lacks,
                                const struct surface_point *point) {
    int32_t i = row->count;
    enum status status = quadrant_put(q, row, j, point);
    if (status != STATUS_OK || row->count == i)
        return status;
    row->lacks[i] = lacks;
    row->at[i] = *point;
    row->grown = i < row->grown ? i : row->grown;
    row->edge.count = 0;
    if (family)
        quadrant_take_edge(&row->edge, &below->at[i], &row->at[i], NULL);
    return row->ended ? STATUS_OK
                      : march_note_step(q->march, i * q->si, j * q->sj, family ? 0 : q->si,
                                        family ? q->sj : 0, MARCH_STRAIGHT, true);
}

/* Whether the row below has the place i. */
static bool has_below(const struct quadrant_row *below, int32_t i) {
    return i < below->count && !(below->lacks[i] & LACKS_ALL);
}

/* Where along its row weft goes straight on from the row below: the lip in between has been passed.
 * Where nothing parts that place from the row's last one branches of the net come together. */
static enum status go_round(struct quadrant *q, const struct quadrant_row *below,
                            struct quadrant_row *row, int32_t j) {
    struct surface_point to;
    int32_t begin = row->count;
    for (; row->count < below->count && row->count < q->length; row->count++) {
        int32_t i = row->count;
        if (has_below(below, i) && goes_straight(q, row, j, 1, &below->at[i], &to)) {
            row->ended =
                i == begin && !march_is_parted(q->march, i * q->si, j * q->sj, -q->si, 0, &to);
            return row->ended ? STATUS_OK : put_straight(q, below, row, j, 1, LACKS_BEFORE, &to);
        }
        row->lacks[i] = LACKS_ALL;
    }
    for (int32_t i = begin; i < row->count; i++)
        row->lacks[i] = 0;
    row->count = begin;
    row->ended = true;
    return STATUS_OK;
}

enum status quadrant_go_behind(struct quadrant *q, const struct quadrant_row *below,
                               struct quadrant_row *row, int32_t j) {
    struct surface_point to;
    int32_t i = row->count;
    row->parted = false;
    if (!goes_straight(q, row, j, 0, &row->at[i - 1], &to))
        return go_round(q, below, row, j);
    row->ended =
        has_below(below, i) && !march_is_parted(q->march, i * q->si, j * q->sj, 0, -q->sj, &to);
    return row->ended ? STATUS_OK : put_straight(q, below, row, j, 0, LACKS_BELOW, &to);
}
