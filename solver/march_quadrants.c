/* SPDX-License-Identifier: MIT */
/*
 * The quadrants, row by row away from the warp generator. A row goes on until it has left the
 * surface for good, as far as it can tell; when a higher row reaches further out, the rows below it
 * are extended on demand, so that exactly those ghosts are computed that some node rests on.
 */
#include "march.h"

struct quadrant {
    struct march *march;
    int si, sj;
    int32_t length;        /* places on the warp arm */
    int32_t reach;         /* the last place of the row below that has not left the surface */
    struct station *below; /* row j - 1 at i = 0 .. below_count - 1, counted from the generator */
    struct station *row;   /* row j alike */
    int32_t below_count, row_count;
};

/* How a row went. */
struct row_end {
    bool planted; /* it has a first node, on the weft generator */
    bool near;    /* some place of it has not left the surface */
};

/* Brings (i, j) and the places below it into being, the row having ended before: `found` says
 * whether, `station` is then there. */
static enum status climb_column(struct quadrant *q, int32_t i, int32_t j, struct station *station,
                                bool *found) {
    struct march *march = q->march;
    struct station a, b;
    int32_t r = j;
    while (r > 0 && net_state_at(&march->net, i * q->si, r * q->sj) == NET_UNKNOWN)
        r--;
    *found = march_station(march, i * q->si, r * q->sj, station);
    if (!*found || r == j || !march_station(march, (i - 1) * q->si, r * q->sj, &a))
        return STATUS_OK;
    for (r++; *found && r <= j; r++) {
        struct fishnet_node node;
        enum drape_reason reason;
        enum station_zone zone;
        *found = march_station(march, (i - 1) * q->si, r * q->sj, &b);
        if (!*found)
            return STATUS_OK;
        struct march_cell cell = {i * q->si, r * q->sj, q->si,     q->sj, &a,
                                  &b,        station,   {0, 0, 0}, NULL};
        *found = march_solve_corner(march, &cell, &node, &reason);
        if (!*found)
            return march_fail(march, i * q->si, r * q->sj, reason);
        enum status status = march_place(march, i * q->si, r * q->sj, &node.station, &zone);
        if (status != STATUS_OK)
            return status;
        *found = zone != STATION_BEYOND;
        *station = node.station;
        a = b;
    }
    return STATUS_OK;
}

/* Makes sure that below[i] is there; `found` is false when the net has no such place. */
static enum status reach_below(struct quadrant *q, int32_t i, int32_t j, bool *found) {
    *found = i < q->below_count;
    if (*found)
        return STATUS_OK;
    enum status status = climb_column(q, i, j - 1, &q->below[i], found);
    q->below_count += *found;
    return status;
}

static bool has_left(const struct quadrant *q, int32_t i, int32_t j,
                     const struct station *station) {
    return net_state_at(&q->march->net, i * q->si, j * q->sj) != NET_INSIDE &&
           march_has_left(q->march, station);
}

/* By how much the edge from the row below to this one at i differs from that at i - 1. */
static struct vec3 edge_trend(const struct quadrant *q, int32_t i) {
    if (i < 2)
        return vec3_make(0, 0, 0);
    struct vec3 last = vec3_sub(q->row[i - 1].jet.r, q->below[i - 1].jet.r);
    return vec3_sub(last, vec3_sub(q->row[i - 2].jet.r, q->below[i - 2].jet.r));
}

/* The parameters of (i, j): those below it, and the edge between the rows extrapolated from the
 * three before, quadratically. */
static void extrapolate(const struct quadrant *q, int32_t i, double uv[2]) {
    const struct station *row = &q->row[i], *below = &q->below[i];
    for (int k = 0; k < 2; k++)
        uv[k] = below[0].uv[k] + 3 * (row[-1].uv[k] - below[-1].uv[k]) -
                3 * (row[-2].uv[k] - below[-2].uv[k]) + (row[-3].uv[k] - below[-3].uv[k]);
}

/* Node (i, j) of the row; `zone` says where it went, STATION_BEYOND when the row ends. */
static enum status grow_node(struct quadrant *q, int32_t i, int32_t j, enum station_zone *zone) {
    struct march *march = q->march;
    struct fishnet_node node;
    enum drape_reason reason;
    struct march_cell cell = {.i = i * q->si, .j = j * q->sj, .si = q->si, .sj = q->sj};
    cell.a = &q->below[i - 1];
    cell.b = &q->row[i - 1];
    cell.c = &q->below[i];
    cell.trend = edge_trend(q, i);
    double uv[2];
    if (i >= 3 && !march->surface->has_poles) {
        extrapolate(q, i, uv);
        cell.guess_uv = uv;
    }
    *zone = STATION_BEYOND;
    if (!march_solve_corner(march, &cell, &node, &reason))
        return march_fail(march, i * q->si, j * q->sj, reason);
    q->row[i] = node.station;
    q->row_count = i + 1;
    return march_place(march, i * q->si, j * q->sj, &node.station, zone);
}

/* A row ends `fringe` places after it has left the surface, but not before it is as far beyond the
 * end of the row below: the boundary may run inwards first. */
static enum status grow_row(struct quadrant *q, int32_t j, struct row_end *end) {
    struct march *march = q->march;
    *end = (struct row_end){.planted = march_station(march, 0, j * q->sj, &q->row[0])};
    if (!end->planted)
        return STATUS_OK;
    int32_t last = has_left(q, 0, j, &q->row[0]) ? -1 : 0, limit = q->reach + march->fringe;
    q->row_count = 1;
    for (int32_t i = 1; i < q->length && (i <= limit || i <= last + march->fringe); i++) {
        bool found;
        enum station_zone zone;
        enum status status = reach_below(q, i, j, &found);
        if (status == STATUS_OK && found)
            status = grow_node(q, i, j, &zone);
        if (status != STATUS_OK)
            return status;
        if (!found || zone == STATION_BEYOND)
            break;
        if (!has_left(q, i, j, &q->row[i]))
            last = i;
    }
    end->near = last >= 0;
    q->reach = end->near ? last : q->reach;
    return STATUS_OK;
}

static int32_t arm_length(struct march *march, int si) {
    int32_t length = 0;
    while (net_place(&march->net, length * si, 0))
        length++;
    return length;
}

/* Rows until the weft generator ends, or the net has left the surface for good. */
static enum status grow_rows(struct quadrant *q) {
    bool been_near = false;
    for (int32_t j = 1, empty = 0; empty < q->march->fringe; j++) {
        struct row_end end;
        enum status status = grow_row(q, j, &end);
        if (status != STATUS_OK || !end.planted)
            return status;
        if (!march_progress(q->march))
            return STATUS_CANCELLED;
        been_near = been_near || end.near;
        empty = been_near && !end.near ? empty + 1 : 0;
        struct station *free_row = q->below;
        q->below = q->row;
        q->below_count = q->row_count;
        q->row = free_row;
    }
    return STATUS_OK;
}

static enum status grow_quadrant(struct march *march, int si, int sj) {
    struct quadrant q = {.march = march, .si = si, .sj = sj, .length = arm_length(march, si)};
    q.below = arena_alloc(march->arena, (size_t)q.length, sizeof *q.below);
    q.row = arena_alloc(march->arena, (size_t)q.length, sizeof *q.row);
    if (!q.below || !q.row)
        return STATUS_OUT_OF_MEMORY;
    while (q.below_count < q.length &&
           march_station(march, q.below_count * si, 0, &q.below[q.below_count]))
        q.below_count++;
    for (int32_t i = 0; i < q.below_count; i++)
        q.reach = has_left(&q, i, 0, &q.below[i]) ? q.reach : i;
    return grow_rows(&q);
}

enum status march_quadrants(struct march *march) {
    enum status status = STATUS_OK;
    for (int k = 0; k < 4 && status == STATUS_OK; k++)
        status = grow_quadrant(march, k % 2 ? -1 : 1, k / 2 ? -1 : 1);
    return status;
}
