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

/* How far the end of a yarn that goes straight on is known, as a share of the spacing. */
static const double geodesic_accuracy = 1e-11, arc_accuracy = 1e-7;

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

/* Twice the room of an array that is full; the old one stays in the arena. */
static void *grown(struct arena *arena, const void *from, size_t length, size_t room, size_t size) {
    char *to = arena_take(arena, room, size);
    if (to && length)
        memcpy(to, from, length * size);
    return to;
}

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

/* Distance of the free yarn from its generator first, then of its end from the start. A yarn begins
 * only where no other can go on. */
static int64_t rank_of(const struct free_end *e) {
    int64_t i = labs(e->i), j = labs(e->j), yarn = e->dj ? i : j;
    return e->begins * ((int64_t)1 << 62) + yarn * ((int64_t)1 << 32) + i + j;
}

static bool before(const struct free_end *a, const struct free_end *b) {
    if (a->rank != b->rank)
        return a->rank < b->rank;
    if (a->i != b->i)
        return a->i < b->i;
    if (a->j != b->j)
        return a->j < b->j;
    return a->di != b->di ? a->di < b->di : a->dj < b->dj;
}

static enum status push_end(struct growth *g, struct free_end end) {
    if (g->heap_length == g->heap_room) {
        g->heap_room = g->heap_room ? 2 * g->heap_room : 1024;
        g->heap = grown(g->march->arena, g->heap, g->heap_length, g->heap_room, sizeof *g->heap);
        if (!g->heap)
            return STATUS_OUT_OF_MEMORY;
    }
    end.rank = rank_of(&end);
    size_t at = g->heap_length++;
    for (; at > 0 && before(&end, &g->heap[(at - 1) / 2]); at = (at - 1) / 2)
        g->heap[at] = g->heap[(at - 1) / 2];
    g->heap[at] = end;
    return STATUS_OK;
}

static struct free_end pop_end(struct growth *g) {
    struct free_end least = g->heap[0], last = g->heap[--g->heap_length];
    size_t at = 0;
    for (size_t child; (child = 2 * at + 1) < g->heap_length; at = child) {
        child += child + 1 < g->heap_length && before(&g->heap[child + 1], &g->heap[child]);
        if (!before(&g->heap[child], &last))
            break;
        g->heap[at] = g->heap[child];
    }
    g->heap[at] = last;
    return least;
}

/* Queues the unknown places round (i, j), diagonally too: there the cell may now have three. */
static enum status push_around(struct growth *g, int32_t i, int32_t j) {
    enum status status = STATUS_OK;
    for (int dj = -1; dj <= 1; dj++)
        for (int di = -1; di <= 1 && status == STATUS_OK; di++)
            if (net_state_at(g->march->net, i + di, j + dj) == NET_UNKNOWN)
                status = push_place(g, i + di, j + dj);
    return status;
}

/* Whether (i, j) is the fourth corner of a cell whose others are there, one of them inside next to
 * it, seen from A = (i - si, j - sj). */
static bool has_corners(struct march *march, int32_t i, int32_t j, int si, int sj) {
    struct net *net = march->net;
    const struct net_node *b = net_place(net, i - si, j), *c = net_place(net, i, j - sj);
    return b && c && (b->state == NET_INSIDE || c->state == NET_INSIDE) &&
           net_place(net, i - si, j - sj);
}

/* Whether the cell of which (i, j) is the fourth corner rests on a grown node. */
static bool is_on_grown(struct net *net, int32_t i, int32_t j, int si, int sj) {
    const struct net_node *a = net_place(net, i - si, j - sj);
    const struct net_node *b = net_place(net, i - si, j), *c = net_place(net, i, j - sj);
    return (a && a->grown) || (b && b->grown) || (c && c->grown);
}

/* Notes how a node came about, for the estimate of its error. */
static enum status note_step(struct march *march, int32_t i, int32_t j, int di, int dj,
                             enum march_way way) {
    struct march_steps *steps = &march->grown;
    if (!march->first)
        return STATUS_OK;
    if (steps->count == steps->room) {
        steps->room = steps->room ? 2 * steps->room : 1024;
        steps->step =
            grown(march->arena, steps->step, steps->count, steps->room, sizeof *steps->step);
        if (!steps->step)
            return STATUS_OUT_OF_MEMORY;
    }
    steps->step[steps->count++] = (struct march_step){i, j, (int8_t)di, (int8_t)dj, (uint8_t)way};
    return STATUS_OK;
}

/* Puts a yarn's next node, one spacing from the end. */
static enum status place_end(struct growth *g, const struct free_end *e,
                             const struct surface_point *to) {
    struct march *march = g->march;
    enum surface_point_zone zone;
    int32_t i = e->i + e->di, j = e->j + e->dj;
    enum status status = march_place(march, i, j, to, &zone);
    if (status != STATUS_OK || zone == SURFACE_POINT_BEYOND)
        return status;
    net_mark_grown(march->net, i, j);
    status = note_step(march, i, j, e->di, e->dj, e->begins ? MARCH_ACROSS : MARCH_STRAIGHT);
    return status == STATUS_OK ? push_around(g, i, j) : status;
}

/* Tries the cells round an unknown place; `tried`: there was one with three corners. */
static enum status solve_place(struct growth *g, int32_t i, int32_t j, bool *tried) {
    struct march *march = g->march;
    int si = i < 0 ? -1 : 1, sj = j < 0 ? -1 : 1;
    enum drape_reason reason = DRAPE_REASON_BOUNDARY, first = reason;
    *tried = false;
    for (int k = 0; k < 4; k++) {
        int ki = k & 1 ? -si : si, kj = k & 2 ? -sj : sj;
        bool placed;
        if (!has_corners(march, i, j, ki, kj))
            continue;
        enum status status = march_corner(march, i, j, ki, kj, &placed, &reason);
        first = *tried ? first : reason;
        *tried = true;
        if (status != STATUS_OK || net_state_at(march->net, i, j) == NET_FAILED)
            return status;
        if (!placed)
            continue;
        if (is_on_grown(march->net, i, j, ki, kj))
            net_mark_grown(march->net, i, j);
        status = note_step(march, i, j, ki, kj, MARCH_CELL);
        return status == STATUS_OK ? push_around(g, i, j) : status;
    }
    return *tried ? march_fail(march, i, j, first) : STATUS_OK;
}

static enum status push_waiting(struct growth *g, struct free_end end) {
    if (g->waiting_length == g->waiting_room) {
        g->waiting = arena_enlarge(g->march->arena, g->waiting, g->waiting_length,
                                   sizeof *g->waiting, &g->waiting_room);
        if (!g->waiting)
            return STATUS_OUT_OF_MEMORY;
    }
    g->waiting[g->waiting_length++] = end;
    return STATUS_OK;
}

/* Puts the yarns that wait into the heap. Most have been overtaken by cells. */
static enum status push_yarns(struct growth *g) {
    enum status status = STATUS_OK;
    for (size_t k = 0; k < g->waiting_length && status == STATUS_OK; k++) {
        const struct free_end *e = &g->waiting[k];
        if (net_state_at(g->march->net, e->i + e->di, e->j + e->dj) == NET_UNKNOWN)
            status = push_end(g, *e);
    }
    g->waiting_length = 0;
    return status;
}

/* Lets the yarns that could reach (i, j) straight on wait; one that would begin there
 * needs a yarn to cross. */
static enum status wait_for_yarns(struct growth *g, int32_t i, int32_t j) {
    struct net *net = g->march->net;
    enum status status = STATUS_OK;
    for (int k = 0; k < 4 && status == STATUS_OK; k++) {
        int8_t di = sides[k][0], dj = sides[k][1];
        int32_t fi = i - di, fj = j - dj;
        bool goes_on = net_place(net, fi - di, fj - dj);
        bool crosses = net_place(net, fi - dj, fj - di) || net_place(net, fi + dj, fj + di);
        if (net_state_at(net, fi, fj) == NET_INSIDE && (goes_on || crosses))
            status = push_waiting(g, (struct free_end){fi, fj, di, dj, !goes_on, 0});
    }
    return status;
}

static enum status empty_queue(struct growth *g) {
    while (g->length) {
        struct place p = g->queue[g->head];
        bool tried;
        g->head = (g->head + 1) % g->room;
        g->length--;
        if (net_state_at(g->march->net, p.i, p.j) != NET_UNKNOWN)
            continue;
        enum status status = solve_place(g, p.i, p.j, &tried);
        if (status == STATUS_OK && !tried)
            status = wait_for_yarns(g, p.i, p.j);
        if (status != STATUS_OK)
            return status;
        if (!march_progress(g->march))
            return STATUS_CANCELLED;
    }
    return STATUS_OK;
}

static bool is_broken(const struct net_node *node) {
    return node && node->state == NET_FAILED &&
           (node->reason == DRAPE_REASON_COLLAPSED || node->reason == DRAPE_REASON_NO_CONVERGENCE ||
            node->reason == DRAPE_REASON_DEGENERATE);
}

/* Whether the net is broken beside the yarn's next step: `reason` says how. A yarn does not go
 * round a place where its neighbours came together. */
static bool broken_beside(struct march *march, const struct free_end *e,
                          enum drape_reason *reason) {
    for (int k = 0; k < 4; k++) {
        int side = k & 1 ? -1 : 1, step = k / 2;
        const struct net_node *node = net_find(march->net, e->i + step * e->di + side * e->dj,
                                               e->j + step * e->dj + side * e->di);
        if (is_broken(node)) {
            *reason = (enum drape_reason)node->reason;
            return true;
        }
    }
    return false;
}

static bool is_flat(struct vec3 across, struct vec3 along) {
    double sine2 = vec3_norm2(vec3_cross(across, along));
    return sine2 < flat_sine * flat_sine * vec3_norm2(across) * vec3_norm2(along);
}

/* Whether the yarn crosses another at its end under an angle at which cells have all but collapsed:
 * it would only wind on beside it. Over a fold chords say little: there it is asked how the other
 * yarn leaves. */
static bool crosses_flat(struct march *march, const struct free_end *e,
                         const struct surface_point *from, struct vec3 along) {
    for (int side = -1; side <= 1; side += 2) {
        int di = side * e->dj, dj = side * e->di;
        const struct net_node *node = net_place(march->net, e->i + di, e->j + dj);
        struct vec3 across;
        if (!node || !is_flat(vec3_sub(node->r, from->jet.r), along))
            continue;
        if (march->mesh || !march_yarn(march, e->i, e->j, di, dj, from, &across) ||
            is_flat(across, along))
            return true;
    }
    return false;
}

/* The same on a mesh: by the one-sided difference of second order where there are three nodes. */
static struct vec3 yarn_end_on_mesh(struct march *march, const struct free_end *e, struct vec3 r,
                                    struct vec3 last) {
    struct vec3 chord = vec3_sub(r, last);
    const struct net_node *first = net_place(march->net, e->i - 2 * e->di, e->j - 2 * e->dj);
    if (!first)
        return chord;
    return vec3_axpy(0.5, vec3_sub(chord, vec3_sub(last, first->r)), chord);
}

/* The unit tangents of the yarn at (i, j), which is at `from`, towards its neighbour at (i + di, j
 * + dj), which is at `to`, and at that on from there: by its logarithm where it can be had. */
static bool yarn_between(struct march *march, int32_t i, int32_t j, int di, int dj,
                         const struct surface_point *from, const struct surface_point *to,
                         struct vec3 *leave, struct vec3 *arrive) {
    double length = march->settings->spacing[dj != 0];
    struct vec3 back;
    if (!march_yarn(march, i, j, di, dj, from, leave) ||
        !march_yarn(march, i + di, j + dj, -di, -dj, to, &back))
        return false;
    *arrive = vec3_scale(-1, back);
    struct logarithm l;
    if (march->method->yarn == DRAPE_YARN_ARC &&
        logarithm_find(&march->cursor, from, to, arc_accuracy, &l)) {
        *leave = l.leave;
        *arrive = l.arrive;
    } else if (march->method->yarn != DRAPE_YARN_CHORD)
        (void)fishnet_geodesic_between(
            march->surface, &march->cursor, from, to,
            march->method->yarn == DRAPE_YARN_GEODESIC ? geodesic_accuracy : arc_accuracy, &length,
            leave, arrive);
    return true;
}

/* The yarn's direction at its end, which is at `from`: in the surface, that of its last edge,
 * turned by half the angle by which it turns sideways at the node before. Zero when it is not
 * known. */
static struct vec3 yarn_end(struct march *march, const struct free_end *e,
                            const struct surface_point *from) {
    int di = e->di, dj = e->dj;
    int32_t i = e->i - di, j = e->j - dj;
    struct surface_point last, first;
    struct vec3 before, onward, end, arrive;
    const struct net_node *node = net_place(march->net, i, j);
    if (!node)
        return vec3_make(0, 0, 0);
    if (march->mesh)
        return yarn_end_on_mesh(march, e, from->jet.r, node->r);
    if (!march_point(march, i, j, &last) ||
        !yarn_between(march, i, j, di, dj, &last, from, &onward, &end))
        return vec3_make(0, 0, 0);
    if (!march_point(march, i - di, j - dj, &first) ||
        !yarn_between(march, i, j, -di, -dj, &last, &first, &before, &arrive))
        return end;
    double turn = -vec3_dot(vec3_cross(before, onward), last.normal) / 2;
    return vec3_axpy(turn, vec3_cross(from->normal, end), end);
}

/* The direction of the yarn at (i, j) of which (i + di, j + dj) is the next place: of both chords
 * where there are two; zero where there is no neighbour. */
static struct vec3 yarn_tangent(struct march *march, int32_t i, int32_t j, int di, int dj,
                                const struct surface_point *from) {
    const struct net_node *ahead = net_place(march->net, i + di, j + dj);
    const struct net_node *behind = net_place(march->net, i - di, j - dj);
    struct free_end forward = {i, j, (int8_t)-di, (int8_t)-dj, false, 0};
    struct free_end backward = {i, j, (int8_t)di, (int8_t)dj, false, 0};
    if (ahead && behind)
        return vec3_sub(ahead->r, behind->r);
    return ahead    ? vec3_scale(-1, yarn_end(march, &forward, from))
           : behind ? yarn_end(march, &backward, from)
                    : vec3_make(0, 0, 0);
}

/* The direction of a yarn that begins at `from`: weft is as much to the left of warp as it is at
 * the start. */
static struct vec3 direction_across(struct march *march, const struct free_end *e,
                                    const struct surface_point *from) {
    double sine, cosine, sign = e->di + e->dj;
    struct vec3 along = yarn_tangent(march, e->i, e->j, e->dj != 0, e->di != 0, from);
    struct vec3 normal = from->normal;
    along = vec3_unit(vec3_axpy(-vec3_dot(along, normal), normal, along));
    angle_sincos_deg(90 - march->settings->pre_shear_deg, &sine, &cosine);
    struct vec3 left = vec3_scale(e->dj ? sine : -sine, vec3_cross(normal, along));
    return vec3_scale(sign, vec3_axpy(cosine, along, left));
}

/* The first spacing of a yarn across another. One that would leave the part at once is no yarn: the
 * place may still be reached otherwise. */
static enum status begin_yarn(struct growth *g, const struct free_end *e) {
    struct march *march = g->march;
    struct surface_point from, to;
    if (!march_point(march, e->i, e->j, &from) ||
        !march_straight_on(march, &from, direction_across(march, e, &from), e->di, e->dj, &to))
        return STATUS_OK;
    return place_end(g, e, &to);
}

/* One spacing straight on. */
static enum status go_straight(struct growth *g, const struct free_end *e) {
    struct march *march = g->march;
    struct surface_point from, to;
    int32_t i = e->i + e->di, j = e->j + e->dj;
    if (!march_point(march, e->i, e->j, &from))
        return march_fail(march, i, j, DRAPE_REASON_DEGENERATE);
    struct vec3 direction = yarn_end(march, e, &from);
    if (crosses_flat(march, e, &from, direction))
        return march_fail(march, i, j, DRAPE_REASON_COLLAPSED);
    if (!march_straight_on(march, &from, direction, e->di, e->dj, &to))
        return march_fail(march, i, j, march->astray);
    return place_end(g, e, &to);
}

/* A yarn's next node, unless it would lie beyond the extent or beside a place where the net broke.
 */
static enum status reach_end(struct growth *g, const struct free_end *e) {
    struct march *march = g->march;
    enum drape_reason reason;
    int32_t i = e->i + e->di, j = e->j + e->dj;
    if (!march_in_extent(march, i, j))
        return march_fail(march, i, j, DRAPE_REASON_EXTENT);
    if (broken_beside(march, e, &reason))
        return march_fail(march, i, j, reason);
    return e->begins ? begin_yarn(g, e) : go_straight(g, e);
}

/* Queues the unknown places next to a tile's nodes inside. */
static enum status push_tile(struct growth *g, const struct net_tile *tile) {
    struct net_window window = net_window(g->march->net, tile->ti, tile->tj);
    enum status status = STATUS_OK;
    for (int y = 0; y < NET_TILE; y++) {
        uint32_t row = net_window_bits(&window, NET_BIT_KNOWN, y);
        uint32_t up = net_window_bits(&window, NET_BIT_KNOWN, y + 1);
        uint32_t down = net_window_bits(&window, NET_BIT_KNOWN, y - 1);
        uint32_t rim =
            (uint32_t)tile->bits[NET_BIT_INSIDE][y] << 1 & ~(up & down & row << 1 & row >> 1);
        for (; rim; rim &= rim - 1) {
            int bit = __builtin_ctz(rim);
            for (int k = 0; k < 4 && status == STATUS_OK; k++) {
                int nx = bit - 1 + sides[k][0], ny = y + sides[k][1];
                uint32_t beside = ny < y ? down : ny > y ? up : row;
                if (!(beside >> (nx + 1) & 1))
                    status = push_place(g, tile->ti * NET_TILE + nx, tile->tj * NET_TILE + ny);
            }
        }
    }
    return status;
}

static enum status push_rim(struct growth *g) {
    struct net_tile **tiles = net_sorted_tiles(g->march->net);
    if (!tiles)
        return STATUS_OUT_OF_MEMORY;
    enum status status = STATUS_OK;
    for (size_t t = 0, count = net_tile_count(g->march->net); t < count && status == STATUS_OK; t++)
        status = push_tile(g, tiles[t]);
    return status;
}

static bool is_edgeless(const struct march *march) {
    if (!march->mesh && march->surface->shell)
        return shell_is_closed(march->surface->shell, march->surface->face);
    if (!march->mesh)
        return march->surface->axis[0].closed && march->surface->axis[1].closed;
    int32_t start = march_mesh_point_of(&march->start.point).triangle;
    return march->mesh->components[march->mesh->component[start]].rim_count == 0;
}

/* On a surface without an edge nothing ends at a boundary: what could not be reached lies against
 * the net itself. */
static enum status settle_edgeless(struct growth *g) {
    struct march *march = g->march;
    if (!is_edgeless(march))
        return STATUS_OK;
    enum status status = push_rim(g);
    for (; status == STATUS_OK && g->length; g->length--, g->head = (g->head + 1) % g->room) {
        struct place p = g->queue[g->head];
        if (net_state_at(march->net, p.i, p.j) == NET_UNKNOWN)
            status = march_fail(march, p.i, p.j, DRAPE_REASON_FOLD);
    }
    return status;
}

static enum status put_aside(struct growth *g, int32_t i, int32_t j, const struct net_node *node) {
    if (g->aside_length == g->aside_room) {
        g->aside_room = g->aside_room ? 2 * g->aside_room : 1024;
        g->aside =
            grown(g->march->arena, g->aside, g->aside_length, g->aside_room, sizeof *g->aside);
        if (!g->aside)
            return STATUS_OUT_OF_MEMORY;
    }
    g->aside[g->aside_length++] = (struct aside){i, j, *node};
    return STATUS_OK;
}

/* A surface that closes both ways was cut open opposite the start, so that the quadrants share it
 * evenly. From now on the net goes on over the cuts until it meets itself: what lay beyond them is
 * put aside. */
static enum status pass_cuts(struct growth *g) {
    struct march *march = g->march;
    const struct surface *surface = march->surface;
    if (march->mesh || surface->shell || !surface->axis[0].closed || !surface->axis[1].closed)
        return STATUS_OK;
    struct net_tile **tiles = net_sorted_tiles(march->net);
    enum status status = tiles ? STATUS_OK : STATUS_OUT_OF_MEMORY;
    march->past_cut = true;
    overlap_pass_slit(march->overlap);
    for (size_t t = 0; tiles && t < net_tile_count(march->net); t++)
        for (int at = 0; at < NET_TILE * NET_TILE && status == STATUS_OK; at++) {
            int x = at % NET_TILE, y = at / NET_TILE;
            struct net_node node = tiles[t]->node[y][x], none = {.state = NET_UNKNOWN};
            int32_t i = tiles[t]->ti * NET_TILE + x, j = tiles[t]->tj * NET_TILE + y;
            if (node.reason != DRAPE_REASON_FOLD ||
                (node.state != NET_GHOST && node.state != NET_FAILED))
                continue;
            if (node.state == NET_GHOST) {
                march->ghosts--;
                status = put_aside(g, i, j, &node);
            }
            if (status == STATUS_OK)
                status = net_put(march->net, i, j, &none);
        }
    return status;
}

/* Ghosts beyond the cuts that no node has replaced carry the net's differences on. */
static enum status put_back(struct growth *g) {
    struct march *march = g->march;
    enum status status = STATUS_OK;
    for (size_t k = 0; k < g->aside_length && status == STATUS_OK; k++) {
        const struct aside *a = &g->aside[k];
        const struct net_node *now = net_find(march->net, a->i, a->j);
        if (now->state != NET_UNKNOWN &&
            !(now->state == NET_FAILED && now->reason == DRAPE_REASON_FOLD))
            continue;
        march->ghosts++;
        status = net_put(march->net, a->i, a->j, &a->node);
    }
    return status;
}

enum status march_growth(struct march *march) {
    struct growth g = {.march = march};
    march->growing = true;
    enum status status = pass_cuts(&g);
    if (status == STATUS_OK)
        status = push_rim(&g);
    while (status == STATUS_OK) {
        status = empty_queue(&g);
        if (status == STATUS_OK)
            status = push_yarns(&g);
        if (status != STATUS_OK || !g.heap_length)
            break;
        struct free_end end = pop_end(&g);
        if (net_state_at(march->net, end.i + end.di, end.j + end.dj) == NET_UNKNOWN)
            status = march_watch_folds(march);
        if (status == STATUS_OK &&
            net_state_at(march->net, end.i + end.di, end.j + end.dj) == NET_UNKNOWN)
            status = reach_end(&g, &end);
    }
    if (status == STATUS_OK)
        status = settle_edgeless(&g);
    return status == STATUS_OK ? put_back(&g) : status;
}
