/* SPDX-License-Identifier: MIT */
/*
 * What the quadrants could not reach. A queue holds unknown places next to the net. A place with
 * three corners of a cell is solved, from the side of the start if it can be; one without waits in
 * a heap. When the queue is empty, the waiting place nearest to its generator is reached by its
 * yarn going straight on for one spacing, a free edge, and the queue fills again. Where there is no
 * such yarn either, as when a generator leaves the part at once, a yarn sets off across the one
 * that is there, at the angle that the generators have at the start.
 */
#include "march.h"

#include "solver/angle.h"
#include "solver/fishnet/fishnet_geodesic.h"
#include "solver/fishnet/logarithm.h"
#include <stdlib.h>
#include <string.h>

/* The sine of 10 degrees: beyond 80 degrees of shear. */
static const double flat_sine = 0.17365;

/* How far the end of a yarn that goes straight on is known, as a share of the spacing; and a
 * logarithm, whose directions are right to the square root of that. */
static const double geodesic_accuracy = 1e-11, arc_accuracy = 1e-7, logarithm_accuracy = 1e-12;

struct place {
    int32_t i, j;
};

/* A yarn that may go straight on from (i, j) to (i + di, j + dj), or begin there. */
struct free_end {
    int32_t i, j;
    int8_t di, dj;
    bool begins;
    int64_t rank; /* among those that wait */
};

/* A ghost beyond a cut. */
struct aside {
    int32_t i, j;
    struct net_node node;
};

struct growth {
    struct march *march;
    int hand; /* -1: it grows in the order of the net's mirror image, j for -j (`march_cut`); else 1
               */
    struct aside *aside;
    size_t aside_length, aside_room;
    struct place *queue; /* a ring */
    size_t head, length, room;
    struct free_end *waiting; /* that go into the heap when the queue is empty */
    size_t waiting_length, waiting_room;
    struct free_end *heap; /* least first */
    size_t heap_length, heap_room;
};

static const int8_t sides[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};

static enum status push_place(struct growth *g, int32_t i, int32_t j) {
    if (g->length == g->room) {
        size_t room = g->room ? 2 * g->room : 1024;
        struct place *to = arena_take(g->march->arena, room, sizeof *to);
        if (!to)
            return STATUS_OUT_OF_MEMORY;
        for (size_t k = 0; k < g->length; k++)
            to[k] = g->queue[(g->head + k) % g->room];
        g->queue = to;
        g->room = room;
        g->head = 0;
    }
    g->queue[(g->head + g->length++) % g->room] = (struct place){i, j};
    return STATUS_OK;
}

static bool comes_before(const struct growth *g, const struct free_end *a,
                         const struct free_end *b) {
    if (a->rank != b->rank)
        return a->rank < b->rank;
    if (a->i != b->i)
        return a->i < b->i;
    if (a->j != b->j)
        return g->hand * a->j < g->hand * b->j;
    return a->di != b->di ? a->di < b->di : g->hand * a->dj < g->hand * b->dj;
}

static struct free_end pop_end(struct growth *g) {
    struct free_end least = g->heap[0], last = g->heap[--g->heap_length];
    size_t at = 0;
    for (size_t child; (child = 2 * at + 1) < g->heap_length; at = child) {
        child +=
            child + 1 < g->heap_length && comes_before(g, &g->heap[child + 1], &g->heap[child]);
        if (!comes_before(g, &g->heap[child], &last))
            break;
        g->heap[at] = g->heap[child];
    }
    g->heap[at] = last;
    return least;
}

/* Queues the unknown places round (i, j), diagonally too: there the cell may now have three. */
static enum status push_around(struct growth *g, int32_t i, int32_t j) {
    enum status status = STATUS_OK;
    for (int dj = -g->hand; abs(dj) <= 1; dj += g->hand)
        for (int di = -1; di <= 1 && status == STATUS_OK; di++)
            if (net_state_at(g->march->net, i + di, j + dj) == NET_UNKNOWN)
                status = push_place(g, i + di, j + dj);
    return status;
}

enum status march_note_step(struct march *march, int32_t i, int32_t j, int di, int dj,
                            enum march_way way, bool grown) {
    struct march_steps *steps = &march->grown;
    if (grown)
        net_mark_grown(march->net, i, j);
    if (!march->first)
        return STATUS_OK;
    if (steps->count == steps->room &&
        !(steps->step = arena_enlarge(march->arena, steps->step, steps->count, sizeof *steps->step,
                                      &steps->room)))
        return STATUS_OUT_OF_MEMORY;
    steps->step[steps->count++] = (struct march_step){i, j, (int8_t)di, (int8_t)dj, (uint8_t)way};
    return STATUS_OK;
}

/* Puts the yarns that wait into the heap, by the distance of the free yarn from its generator
 * first, then of its end from the start. A yarn begins only where no other can go on. Most have
 * been overtaken by cells. */
static enum status push_waiting(struct growth *g) {
    for (size_t k = 0; k < g->waiting_length; k++) {
        struct free_end end = g->waiting[k];
        if (net_state_at(g->march->net, end.i + end.di, end.j + end.dj) != NET_UNKNOWN)
            continue;
        if (g->heap_length == g->heap_room &&
            !(g->heap = arena_enlarge(g->march->arena, g->heap, g->heap_length, sizeof *g->heap,
                                      &g->heap_room)))
            return STATUS_OUT_OF_MEMORY;
        int64_t i = labs(end.i), j = labs(end.j), yarn = end.dj ? i : j;
        end.rank = end.begins * ((int64_t)1 << 62) + yarn * ((int64_t)1 << 32) + i + j;
        size_t at = g->heap_length++;
        for (; at > 0 && comes_before(g, &end, &g->heap[(at - 1) / 2]); at = (at - 1) / 2)
            g->heap[at] = g->heap[(at - 1) / 2];
        g->heap[at] = end;
    }
    g->waiting_length = 0;
    return STATUS_OK;
}

/* The neighbour on the side (di, dj) from which a yarn comes to the node at (i, j); NULL where
 * there is none, or a cut between. */
static const struct net_node *yarn_from(const struct march *march, int32_t i, int32_t j, int di,
                                        int dj) {
    const struct net_node *node = march_node_at(march, i, j);
    const struct net_node *next = march_node_at(march, i + di, j + dj);
    bool comes = node && next && !net_is_parted_to(node, next, di ? 0 : 1, di + dj > 0);
    return comes ? next : NULL;
}

/* Tries the cells of which an unknown place is the fourth corner: one with the three others, of
 * which one next to it is inside, from the side of the start if it can be. Where there is no such
 * cell, the yarns that could reach it straight on wait; one that would begin there needs a yarn to
 * cross. */
static enum status solve_place(struct growth *g, int32_t i, int32_t j) {
    struct march *march = g->march;
    struct net *net = march->net;
    enum drape_reason reason = DRAPE_REASON_BOUNDARY, first = reason;
    const struct net_node *round[3][3]; /* [row][column] */
    bool tried = false;
    for (int k = 0; k < 9; k++)
        round[k / 3][k % 3] = net_place(net, i + k % 3 - 1, j + k / 3 - 1);
    for (int k = 0; k < 4; k++) {
        int si = (i < 0 ? -1 : 1) * (k & 1 ? -1 : 1),
            sj = g->hand * (g->hand * j < 0 ? -1 : 1) * (k & 2 ? -1 : 1);
        const struct net_node *a = round[1 - sj][1 - si];
        const struct net_node *b = round[1][1 - si], *c = round[1 - sj][1];
        if (!a || !b || !c || (b->state != NET_INSIDE && c->state != NET_INSIDE) ||
            net_is_parted_to(a, b, 1, sj > 0) || net_is_parted_to(a, c, 0, si > 0))
            continue;
        enum surface_point_zone zone = SURFACE_POINT_BEYOND;
        struct surface_point at_a, at_b, at_c;
        struct march_cell cell = {i, j, si, sj, &at_a, &at_b, &at_c, {0, 0, 0}, NULL, NULL, 0};
        struct fishnet_node node;
        bool regular = march_point_at(march, a, &at_a) && march_point_at(march, b, &at_b) &&
                       march_point_at(march, c, &at_c);
        reason = DRAPE_REASON_DEGENERATE;
        const struct net_node *a2 = net_place(net, i - 2 * si, j - sj);
        const struct net_node *b2 = net_place(net, i - 2 * si, j);
        if (regular && a2 && b2)
            cell.trend = vec3_sub(vec3_sub(at_b.jet.r, at_a.jet.r), vec3_sub(b2->r, a2->r));
        if (regular && march_solve_corner(march, &cell, &node, &reason)) {
            if (march_is_parted(march, i, j, -si, 0, &node.point) ||
                march_is_parted(march, i, j, 0, -sj, &node.point))
                continue;
            enum status status = march_place(march, i, j, &node.point, &zone);
            if (status != STATUS_OK || net_state_at(net, i, j) == NET_FAILED)
                return status;
            reason = DRAPE_REASON_BOUNDARY;
        } else if (regular && march_is_beside_cut(march, at_b.jet.r)) {
            continue;
        }
        first = tried ? first : reason;
        tried = true;
        if (zone == SURFACE_POINT_BEYOND)
            continue;
        bool grown = a->grown || b->grown || c->grown;
        enum status status = march_note_step(march, i, j, si, sj, MARCH_CELL, grown);
        return status == STATUS_OK ? push_around(g, i, j) : status;
    }
    if (tried)
        return march_fail(march, i, j, first);
    for (int k = 0; k < 4; k++) {
        int8_t di = sides[k][0], dj = (int8_t)(g->hand * sides[k][1]);
        int32_t fi = i - di, fj = j - dj;
        const struct net_node *from = round[1 - dj][1 - di];
        if (!from || from->state != NET_INSIDE)
            continue;
        bool goes_on = yarn_from(march, fi, fj, -di, -dj);
        bool crosses = yarn_from(march, fi, fj, -dj, -di) || yarn_from(march, fi, fj, dj, di);
        if (!goes_on && !crosses)
            continue;
        if (g->waiting_length == g->waiting_room &&
            !(g->waiting = arena_enlarge(march->arena, g->waiting, g->waiting_length,
                                         sizeof *g->waiting, &g->waiting_room)))
            return STATUS_OUT_OF_MEMORY;
        g->waiting[g->waiting_length++] = (struct free_end){fi, fj, di, dj, !goes_on, 0};
    }
    return STATUS_OK;
}

static bool is_flat(struct vec3 across, struct vec3 along) {
    double sine2 = vec3_norm2(vec3_cross(across, along));
    return sine2 < flat_sine * flat_sine * vec3_norm2(across) * vec3_norm2(along);
}

/* The unit tangents of the yarn at (i, j), which is at `from`, towards its neighbour at (i + di, j
 * + dj), which is at `to`, and at that on from there: by its logarithm where it can be had, but not
 * beside a tip, where that may be of the way on its other side. */
static bool yarn_between(struct march *march, int32_t i, int32_t j, int di, int dj,
                         const struct surface_point *from, const struct surface_point *to,
                         struct vec3 *leave, struct vec3 *arrive) {
    double length = march->settings->spacing[dj != 0];
    struct vec3 back;
    if (!march_yarn(march, i, j, di, dj, from, leave) ||
        !march_yarn(march, i + di, j + dj, -di, -dj, to, &back))
        return false;
    *arrive = vec3_scale(-1, back);
    enum drape_yarn yarn = march->method->yarn;
    bool exact = yarn == DRAPE_YARN_GEODESIC || march_is_beside_tip(march, from->jet.r);
    struct logarithm l;
    if (!exact && yarn == DRAPE_YARN_ARC &&
        logarithm_find(&march->cursor, from, to, logarithm_accuracy, &l)) {
        *leave = l.leave;
        *arrive = l.arrive;
    } else if (yarn != DRAPE_YARN_CHORD)
        (void)fishnet_geodesic_between(march->surface, &march->cursor, from, to,
                                       exact ? geodesic_accuracy : arc_accuracy, &length, leave,
                                       arrive);
    return true;
}

/* The yarn's direction at its end, which is at `from`: in the surface, that of its last edge,
 * turned by half the angle by which it turns sideways at the node before; on a mesh the one-sided
 * difference of second order where there are three nodes, but over folds of flat triangles. Zero
 * when it is not known. */
static struct vec3 yarn_end(struct march *march, int32_t i_end, int32_t j_end, int di, int dj,
                            const struct surface_point *from) {
    int32_t i = i_end - di, j = j_end - dj;
    struct surface_point last, first;
    struct vec3 before, onward, end, arrive;
    const struct net_node *node = yarn_from(march, i_end, j_end, -di, -dj);
    const struct net_node *third = node ? yarn_from(march, i, j, -di, -dj) : NULL;
    if (!node)
        return vec3_make(0, 0, 0);
    if (march->mesh && (march->smooth || !march_mesh_folds(march))) {
        struct vec3 chord = vec3_sub(from->jet.r, node->r);
        return third ? vec3_axpy(0.5, vec3_sub(chord, vec3_sub(node->r, third->r)), chord) : chord;
    }
    if (!march_point(march, i, j, &last) ||
        !yarn_between(march, i, j, di, dj, &last, from, &onward, &end))
        return vec3_make(0, 0, 0);
    if (!march_point(march, i - di, j - dj, &first) ||
        !yarn_between(march, i, j, -di, -dj, &last, &first, &before, &arrive))
        return end;
    double turn = -vec3_dot(vec3_cross(before, onward), last.normal) / 2;
    return vec3_axpy(turn, vec3_cross(from->normal, end), end);
}

/* The direction of a yarn that begins at `from`: weft is as much to the left of warp as it is at
 * the start. The yarn that it crosses is known by both directions in which that leaves where there
 * are two, and on a mesh by both chords: over a fold they would cut the corner. */
static struct vec3 direction_across(struct march *march, const struct free_end *e,
                                    const struct surface_point *from) {
    int8_t di = e->dj != 0, dj = e->di != 0;
    const struct net_node *ahead = yarn_from(march, e->i, e->j, di, dj);
    const struct net_node *behind = yarn_from(march, e->i, e->j, -di, -dj);
    struct vec3 along = {0, 0, 0}, normal = from->normal, to[2];
    double sine, cosine, sign = e->di + e->dj;
    if (ahead && behind && !march->mesh && march_yarn(march, e->i, e->j, di, dj, from, &to[0]) &&
        march_yarn(march, e->i, e->j, -di, -dj, from, &to[1]))
        along = vec3_sub(to[0], to[1]);
    else if (ahead && behind)
        along = vec3_sub(ahead->r, behind->r);
    else if (ahead)
        along = vec3_scale(-1, yarn_end(march, e->i, e->j, -di, -dj, from));
    else if (behind)
        along = yarn_end(march, e->i, e->j, di, dj, from);
    along = vec3_unit(vec3_axpy(-vec3_dot(along, normal), normal, along));
    angle_sincos_deg(90 - march->settings->pre_shear_deg, &sine, &cosine);
    struct vec3 left = vec3_scale(e->dj ? sine : -sine, vec3_cross(normal, along));
    return vec3_scale(sign, vec3_axpy(cosine, along, left));
}

/* The place one spacing on along a direction. */
static bool go_a_spacing(struct march *march, int32_t i, int32_t j, int di, int dj,
                         const struct surface_point *from, struct vec3 direction,
                         struct surface_point *to, enum drape_reason *reason) {
    if (dj)
        march->length[1] = march_slide_length(march, i, j, from, direction);
    bool gone = march_straight_on(march, from, direction, di, dj, to, reason);
    march->length[1] = march->settings->spacing[1];
    return gone;
}

/* Over a fold chords say little: there it is asked how the other yarn leaves. */
bool march_goes_on(struct march *march, int32_t i, int32_t j, int di, int dj,
                   const struct surface_point *from, struct surface_point *to,
                   enum drape_reason *reason) {
    struct vec3 direction = yarn_end(march, i, j, di, dj, from), across;
    *reason = DRAPE_REASON_COLLAPSED;
    for (int side = -1; side <= 1; side += 2) {
        const struct net_node *node = yarn_from(march, i, j, side * dj, side * di);
        if (node && is_flat(vec3_sub(node->r, from->jet.r), direction) &&
            (march->mesh || !march_yarn(march, i, j, side * dj, side * di, from, &across) ||
             is_flat(across, direction)))
            return false;
    }
    return go_a_spacing(march, i, j, di, dj, from, direction, to, reason);
}

/* A yarn's next node, one spacing straight on, unless it would lie beyond the extent or beside a
 * place where the net broke. A yarn that begins, but would leave the part at once, is none: the
 * place may still be reached otherwise. */
static enum status reach_end(struct growth *g, const struct free_end *e) {
    struct march *march = g->march;
    int32_t i = e->i + e->di, j = e->j + e->dj;
    enum drape_reason reason;
    enum surface_point_zone zone;
    struct surface_point from, to;
    if (!march_in_extent(march, i, j))
        return march_fail(march, i, j, DRAPE_REASON_EXTENT);
    /* A yarn does not go round a place where its neighbours came together. */
    for (int k = 0; k < 4; k++) {
        int side = k & 1 ? -1 : 1, step = k / 2;
        const struct net_node *node = net_find(march->net, e->i + step * e->di + side * e->dj,
                                               e->j + step * e->dj + side * e->di);
        if (node && node->state == NET_FAILED && march_breaks_net((enum drape_reason)node->reason))
            return march_fail(march, i, j, (enum drape_reason)node->reason);
    }
    if (!march_point(march, e->i, e->j, &from))
        return e->begins ? STATUS_OK : march_fail(march, i, j, DRAPE_REASON_DEGENERATE);
    bool gone = e->begins ? go_a_spacing(march, e->i, e->j, e->di, e->dj, &from,
                                         direction_across(march, e, &from), &to, &reason)
                          : march_goes_on(march, e->i, e->j, e->di, e->dj, &from, &to, &reason);
    if (!gone)
        return e->begins ? STATUS_OK : march_fail(march, i, j, reason);
    if (march_is_parted(march, i, j, -e->di, -e->dj, &to))
        return STATUS_OK;
    enum status status = march_watch_overlaps(march);
    if (status == STATUS_OK)
        status = march_place(march, i, j, &to, &zone);
    if (status != STATUS_OK || zone == SURFACE_POINT_BEYOND)
        return status;
    status =
        march_note_step(march, i, j, e->di, e->dj, e->begins ? MARCH_ACROSS : MARCH_STRAIGHT, true);
    return status == STATUS_OK ? push_around(g, i, j) : status;
}

/* The order of nodes tile by tile, of the net's mirror image. */
static int compare_mirrored(const void *a, const void *b) {
    const struct place *p = a, *q = b;
    int32_t key[2][4];
    for (int k = 0; k < 2; k++) {
        int32_t i = (k ? q : p)->i, j = -(k ? q : p)->j;
        key[k][0] = j >> NET_TILE_BITS;
        key[k][1] = i >> NET_TILE_BITS;
        key[k][2] = j;
        key[k][3] = i;
    }
    for (int n = 0; n < 4; n++)
        if (key[0][n] != key[1][n])
            return key[0][n] < key[1][n] ? -1 : 1;
    return 0;
}

/* The nodes inside next to which places are unknown, tile by tile. */
static enum status find_rim(const struct growth *g, struct place **rim, size_t *count) {
    struct net *net = g->march->net;
    struct net_tile **tiles = net_sorted_tiles(net);
    size_t room = 0;
    *rim = NULL;
    *count = 0;
    if (!tiles)
        return STATUS_OUT_OF_MEMORY;
    for (size_t t = 0; t < net_tile_count(net); t++) {
        const struct net_tile *tile = tiles[t];
        struct net_window window = net_window(net, tile->ti, tile->tj);
        for (int y = 0; y < NET_TILE; y++) {
            uint32_t row = net_window_bits(&window, NET_BIT_KNOWN, y);
            uint32_t up = net_window_bits(&window, NET_BIT_KNOWN, y + 1);
            uint32_t down = net_window_bits(&window, NET_BIT_KNOWN, y - 1);
            uint32_t inside = (uint32_t)tile->bits[NET_BIT_INSIDE][y] << 1;
            for (uint32_t bits = inside & ~(up & down & row << 1 & row >> 1); bits;
                 bits &= bits - 1) {
                if (*count == room &&
                    !(*rim = arena_enlarge(g->march->arena, *rim, *count, sizeof **rim, &room)))
                    return STATUS_OUT_OF_MEMORY;
                (*rim)[(*count)++] = (struct place){tile->ti * NET_TILE + __builtin_ctz(bits) - 1,
                                                    tile->tj * NET_TILE + y};
            }
        }
    }
    return STATUS_OK;
}

/* Queues the unknown places next to nodes inside. */
static enum status push_rim(struct growth *g) {
    struct place *rim;
    size_t count;
    enum status status = find_rim(g, &rim, &count);
    if (status == STATUS_OK && count > 0 && g->hand < 0)
        qsort(rim, count, sizeof *rim, compare_mirrored);
    for (size_t k = 0; k < 4 * count && status == STATUS_OK; k++) {
        int32_t i = rim[k / 4].i + sides[k % 4][0], j = rim[k / 4].j + g->hand * sides[k % 4][1];
        if (net_state_at(g->march->net, i, j) == NET_UNKNOWN)
            status = push_place(g, i, j);
    }
    return status;
}

/* Takes an unknown place out of the queue; false when there is none. */
static bool next_place(struct growth *g, struct place *place) {
    while (g->length) {
        *place = g->queue[g->head];
        g->head = (g->head + 1) % g->room;
        g->length--;
        if (net_state_at(g->march->net, place->i, place->j) == NET_UNKNOWN)
            return true;
    }
    return false;
}

/* A part that closes both ways was cut open opposite the start, so that the quadrants share it
 * evenly. From now on the net goes on over the cuts until it meets itself: what lay beyond them is
 * put aside. */
static enum status pass_cuts(struct growth *g) {
    struct march *march = g->march;
    const struct surface *surface = march->surface;
    if (march->mesh || (surface->shell ? !march->cut.slit[1]
                                       : !surface->axis[0].closed || !surface->axis[1].closed))
        return STATUS_OK;
    struct net_tile **tiles = net_sorted_tiles(march->net);
    enum status status = tiles ? STATUS_OK : STATUS_OUT_OF_MEMORY;
    march->cut.passed = true;
    march->cut.slit[0] = march->cut.slit[1] = NULL;
    overlap_pass_slits(march->overlap);
    for (size_t t = 0; tiles && t < net_tile_count(march->net); t++)
        for (int at = 0; at < NET_TILE * NET_TILE && status == STATUS_OK; at++) {
            int x = at % NET_TILE, y = at / NET_TILE;
            struct net_node node = tiles[t]->node[y][x], none = {.state = NET_UNKNOWN};
            int32_t i = tiles[t]->ti * NET_TILE + x, j = tiles[t]->tj * NET_TILE + y;
            if (node.reason != DRAPE_REASON_FOLD ||
                (node.state != NET_GHOST && node.state != NET_FAILED))
                continue;
            if (node.state == NET_GHOST) {
                if (g->aside_length == g->aside_room &&
                    !(g->aside = arena_enlarge(march->arena, g->aside, g->aside_length,
                                               sizeof *g->aside, &g->aside_room)))
                    return STATUS_OUT_OF_MEMORY;
                g->aside[g->aside_length++] = (struct aside){i, j, node};
                march->counts.ghosts--;
            }
            status = net_put(march->net, i, j, &none);
        }
    return status;
}

enum status march_growth(struct march *march) {
    struct growth g = {.march = march, .hand = march->cut.inward ? -1 : 1};
    struct place place;
    march->growing = true;
    enum status status = pass_cuts(&g);
    if (status == STATUS_OK)
        status = push_rim(&g);
    while (status == STATUS_OK) {
        while (status == STATUS_OK && next_place(&g, &place)) {
            status = solve_place(&g, place.i, place.j);
            if (status == STATUS_OK && !march_progress(march))
                status = STATUS_CANCELLED;
        }
        if (status == STATUS_OK)
            status = push_waiting(&g);
        if (status != STATUS_OK || !g.heap_length)
            break;
        struct free_end end = pop_end(&g);
        end.begins = end.begins && !yarn_from(march, end.i, end.j, -end.di, -end.dj);
        if (net_state_at(march->net, end.i + end.di, end.j + end.dj) != NET_UNKNOWN)
            continue;
        status = reach_end(&g, &end);
    }
    /* On a surface without an edge nothing ends at a boundary: what could not be reached lies
     * against the net itself. */
    const struct surface *surface = march->surface;
    bool edgeless = status == STATUS_OK;
    if (edgeless && march->mesh) {
        int32_t start = march_mesh_point_of(&march->start.point).triangle;
        edgeless = march->mesh->components[march->mesh->component[start]].rim_count == 0;
    } else if (edgeless) {
        edgeless = surface->shell ? shell_is_closed(surface->shell, surface->face)
                                  : surface->axis[0].closed && surface->axis[1].closed;
    }
    if (edgeless)
        status = push_rim(&g);
    while (edgeless && status == STATUS_OK && next_place(&g, &place))
        status = march_fail(march, place.i, place.j, DRAPE_REASON_FOLD);
    /* Ghosts beyond the cuts that no node has replaced carry the net's differences on. */
    for (size_t k = 0; k < g.aside_length && status == STATUS_OK; k++) {
        const struct aside *a = &g.aside[k];
        const struct net_node *now = net_find(march->net, a->i, a->j);
        if (now->state != NET_UNKNOWN &&
            !(now->state == NET_FAILED && now->reason == DRAPE_REASON_FOLD))
            continue;
        march->counts.ghosts++;
        status = net_put(march->net, a->i, a->j, &a->node);
    }
    return status;
}
