/* SPDX-License-Identifier: MIT */
/*
 * The quadrants, row by row away from the warp generator. A row goes on until it has left the
 * surface for good, as far as it can tell; when a higher row reaches further out, the rows below it
 * are extended on demand, so that exactly those ghosts are computed that some node rests on.
 *
 * A quadrant needs nothing of the others but the two arms beside it, and its nodes lie in tiles of
 * its own: with a team the four are marched at the same time.
 */
#include "quadrant.h"

#include <stdlib.h>
#include <string.h>

/* Shorter rows are as fast one by one; and those that are not settled in blocks in waves of few
 * rows, which wait for each other less. */
static const int32_t worth_a_wave = 32, worth_few = 12;
enum { FEW = 4 };

/* On the arms it is read from the quadrant's copy: those tiles belong to others. */
const struct net_node *quadrant_node(struct quadrant *q, int32_t i, int32_t j) {
    if (i > 0 && j > 0)
        return net_find(q->march->net, i * q->si, j * q->sj);
    return j == 0 ? &q->arm[0][i] : &q->arm[1][j];
}

static bool quadrant_point(struct quadrant *q, int32_t i, int32_t j, struct surface_point *point) {
    const struct net_node *node = quadrant_node(q, i, j);
    return node && (node->state == NET_INSIDE || node->state == NET_GHOST) &&
           march_point_at(q->march, node, point);
}

/* Whether a cut parts a point at (i, j) from the places that it rests on. */
static bool quadrant_is_parted(struct quadrant *q, int32_t i, int32_t j,
                               const struct surface_point *point) {
    int32_t at = i * q->si, row = j * q->sj;
    return q->march->cuts && (march_is_parted(q->march, at, row, -q->si, 0, point) ||
                              march_is_parted(q->march, at, row, 0, -q->sj, point));
}

/* Whether a cut parts two places next to each other along a family of yarns, the one nearer to the
 * start first. */
static bool parts_nodes(struct quadrant *q, const struct net_node *a, const struct net_node *b,
                        int family) {
    return q->march->cuts && net_is_parted_to(a, b, family, (family ? q->sj : q->si) > 0);
}

/* Where the row below ended before place i, that is brought into being with the places under it, on
 * the highest one of its column that is there. */
enum status quadrant_reach_below(struct quadrant *q, struct quadrant_row *below, int32_t i,
                                 int32_t j, bool *found) {
    struct march *march = q->march;
    struct surface_point a, b, *point = &below->at[i];
    int32_t r = j - 1;
    *found = i < below->count;
    if (*found)
        return STATUS_OK;
    while (r > 0) {
        const struct net_node *node = quadrant_node(q, i, r);
        if (node && node->state != NET_UNKNOWN)
            break;
        r--;
    }
    *found = quadrant_point(q, i, r, point);
    *found = *found && (r == j - 1 || quadrant_point(q, i - 1, r, &a));
    for (r++; *found && r < j; r++) {
        struct fishnet_node node;
        enum drape_reason reason;
        enum surface_point_zone zone;
        const struct net_node *at_a = quadrant_node(q, i - 1, r - 1);
        const struct net_node *at_b = quadrant_node(q, i - 1, r),
                              *at_c = quadrant_node(q, i, r - 1);
        *found = quadrant_point(q, i - 1, r, &b) && !parts_nodes(q, at_a, at_b, 1) &&
                 !parts_nodes(q, at_a, at_c, 0);
        if (!*found)
            return STATUS_OK;
        struct march_cell cell = {
            .i = i * q->si, .j = r * q->sj, .si = q->si, .sj = q->sj, .a = &a, .b = &b, .c = point};
        const struct march_counts counts = march->counts;
        *found = march_solve_corner(march, &cell, &node, &reason);
        if (!*found)
            return march_fail_cell(march, cell.i, cell.j, reason, cell.b);
        *found = !quadrant_is_parted(q, i, r, &node.point);
        if (!*found) { /* how often that is asked depends on the wave */
            march->counts = counts;
            return STATUS_OK;
        }
        bool grown = at_a->grown || at_b->grown || at_c->grown;
        enum status status = march_place(march, cell.i, cell.j, &node.point, &zone);
        if (status == STATUS_OK && grown && zone != SURFACE_POINT_BEYOND)
            status = march_note_step(march, cell.i, cell.j, q->si, q->sj, MARCH_CELL, true);
        if (status != STATUS_OK)
            return status;
        if (march->overlap)
            overlap_forget(march->overlap, cell.i, cell.j);
        if (zone == SURFACE_POINT_INSIDE && march->by_rows && r < q->checked)
            status = quadrant_note_late(q, i, r);
        *found = zone != SURFACE_POINT_BEYOND;
        if (status != STATUS_OK || !*found)
            return status;
        *point = node.point;
        a = b;
    }
    below->count += *found;
    return STATUS_OK;
}

static bool has_left(struct quadrant *q, int32_t i, int32_t j, const struct surface_point *point) {
    const struct net_node *node = quadrant_node(q, i, j);
    return !(node && node->state == NET_INSIDE) &&
           ((node && (node->turn != 0 || node->across != 0)) || march_has_left(q->march, point));
}

void quadrant_take_edge(struct differences *edge, const struct surface_point *below,
                        const struct surface_point *at, const struct surface_point *last) {
    if (at->surface != below->surface || (last && at->surface != last->surface))
        edge->count = 0;
    if (at->surface != below->surface)
        return;
    edge->count += edge->count < WAVE_ORDERS;
    for (int k = 0; k < 2; k++) {
        double now = at->uv[k] - below->uv[k];
        for (int order = 0; order < edge->count; order++) {
            double before = edge->of[order][k];
            edge->of[order][k] = now;
            now -= before;
        }
    }
}

void quadrant_stop_row(struct quadrant *q, struct quadrant_row *row, struct vec3 at) {
    row->parted = row->lacks && !(row->lacks[row->count - 1] & LACKS_ALL) &&
                  march_is_beside_cut(q->march, at);
    row->ended = !row->parted;
}

enum status quadrant_put(struct quadrant *q, struct quadrant_row *row, int32_t j,
                         const struct surface_point *point) {
    enum surface_point_zone zone;
    int32_t i = row->count;
    enum status status = march_place(q->march, i * q->si, j * q->sj, point, &zone);
    row->ended = zone == SURFACE_POINT_BEYOND;
    /* nothing rests on what lies too far beyond the part, where parameters say nothing */
    bool lost = status == STATUS_OK && row->ended &&
                net_find(q->march->net, i * q->si, j * q->sj)->reason == DRAPE_REASON_BOUNDARY;
    row->count += !lost;
    if (zone == SURFACE_POINT_INSIDE || (zone == SURFACE_POINT_GHOST && !has_left(q, i, j, point)))
        row->last = i;
    return status;
}

enum status quadrant_place(struct quadrant *q, struct quadrant_row *row, int32_t j,
                           const struct surface_point *point) {
    int32_t i = row->count;
    if (quadrant_is_parted(q, i, j, point)) {
        quadrant_stop_row(q, row, point->jet.r);
        return STATUS_OK;
    }
    enum status status = quadrant_put(q, row, j, point);
    if (status == STATUS_OK && i >= row->grown && !row->ended)
        status = march_note_step(q->march, i * q->si, j * q->sj, q->si, q->sj, MARCH_CELL, true);
    return status;
}

/* The cell of the next place of a row. */
static struct march_cell next_cell(const struct quadrant *q, const struct quadrant_row *below,
                                   const struct quadrant_row *row, int32_t j) {
    int32_t i = row->count;
    struct march_cell cell = {.i = i * q->si, .j = j * q->sj, .si = q->si, .sj = q->sj};
    cell.a = &below->at[i - 1];
    cell.b = &row->at[i - 1];
    cell.c = &below->at[i];
    bool alone = row->lacks && ((row->lacks[i - 1] | below->lacks[i - 1]) & LACKS_BEFORE ||
                                (i >= 2 && (row->lacks[i - 2] | below->lacks[i - 2]) & LACKS_ALL));
    if (i >= 2 && !alone)
        cell.trend = vec3_sub(vec3_sub(cell.b->jet.r, cell.a->jet.r),
                              vec3_sub(row->at[i - 2].jet.r, below->at[i - 2].jet.r));
    return cell;
}

bool quadrant_rests_far(struct quadrant *q, const struct quadrant_row *below,
                        const struct quadrant_row *row, int32_t j) {
    const struct march_cell cell = next_cell(q, below, row, j);
    return march_slide_rests_far(q->march, &cell);
}

enum status quadrant_grow_node(struct quadrant *q, struct quadrant_row *below,
                               struct quadrant_row *row, int32_t j) {
    struct march *march = q->march;
    struct fishnet_node node;
    enum drape_reason reason;
    int32_t i = row->count;
    struct march_cell cell = next_cell(q, below, row, j);
    double uv[2];
    quadrant_take_growth(below, row);
    if (i >= 2 && !march->mesh && row->edge.count > 0 && cell.c->surface == cell.b->surface &&
        !surface_point_near_pole(cell.c->surface, cell.c->jet.r, march_pole_reach2(march))) {
        /* The parameters below it, and the edge between the rows extrapolated by its differences,
         * as long as their sizes on the surface, but for the angle between its parameter lines,
         * become smaller with their order. */
        double last = HUGE_VAL;
        uv[0] = cell.c->uv[0];
        uv[1] = cell.c->uv[1];
        for (int order = 0; order < row->edge.count; order++) {
            const double *of = row->edge.of[order], *first = cell.c->first;
            double size2 = of[0] * of[0] * first[0] + of[1] * of[1] * first[2];
            if (!(size2 < last))
                break;
            last = size2;
            uv[0] += of[0];
            uv[1] += of[1];
        }
        cell.guess_uv = uv;
    }
    if (!march_solve_corner(march, &cell, &node, &reason)) {
        quadrant_stop_row(q, row, cell.b->jet.r);
        return march_fail_cell(march, cell.i, cell.j, reason, cell.b);
    }
    row->at[i] = node.point;
    quadrant_take_edge(&row->edge, &below->at[i], &row->at[i], &row->at[i - 1]);
    return quadrant_place(q, row, j, &node.point);
}

/* As if no cut were near. */
static void forget_growth(const struct quadrant *q, struct quadrant_row *row) {
    row->parted = row->waits = false;
    row->grown = INT32_MAX;
    if (row->lacks)
        memset(row->lacks, 0, (size_t)q->length + 1);
}

void quadrant_begin_row(struct quadrant *q, const struct quadrant_row *below,
                        struct quadrant_row *row, int32_t j) {
    row->planted = quadrant_point(q, 0, j, &row->at[0]);
    row->ended = !row->planted;
    forget_growth(q, row);
    row->last = row->planted && !has_left(q, 0, j, &row->at[0]) ? 0 : -1;
    row->count = row->planted;
    row->edge.count = 0;
    if (row->planted)
        quadrant_take_edge(&row->edge, &below->at[0], &row->at[0], NULL);
}

/* A row ends `fringe` places after it has left the surface, but not before it is as far beyond the
 * ends of the two rows below: the boundary may run inwards first, and stencils at their nodes reach
 * two places to all sides. */
static enum status grow_row(struct quadrant *q, struct quadrant_row *below,
                            struct quadrant_row *row, int32_t j) {
    int32_t farthest = q->reach[0] > q->reach[1] ? q->reach[0] : q->reach[1];
    int32_t fringe = q->march->fringe, limit = farthest + fringe;
    if (!row->begun)
        quadrant_begin_row(q, below, row, j);
    row->begun = row->waits = false;
    while (!row->ended && row->count < q->length &&
           (row->count <= limit || row->count <= row->last + fringe)) {
        bool found = false;
        enum status status = STATUS_OK;
        if (!row->parted)
            status = quadrant_reach_below(q, below, row->count, j, &found);
        if (status == STATUS_OK && !row->parted && !(found && quadrant_has_cell(below, row)))
            quadrant_stop_row(q, row, row->at[row->count - 1].jet.r);
        if (status == STATUS_OK && row->parted) {
            status = quadrant_go_behind(q, below, row, j);
            found = false;
        }
        bool ahead = q->march->settings->slide > 0 && row->count + 1 < q->length;
        if (status == STATUS_OK && found && ahead) /* weft that slides rests on a place more */
            status = quadrant_reach_below(q, below, row->count + 1, j, &ahead);
        if (status == STATUS_OK && found && !row->ended)
            status = quadrant_grow_node(q, below, row, j);
        if (status != STATUS_OK)
            return status;
    }
    if (row->planted)
        q->reach[1] = q->reach[0];
    q->reach[0] = row->last >= 0 ? row->last : q->reach[0];
    return STATUS_OK;
}

/* Copies an arm up to and with the first place that is no node; `length` gets the number of nodes.
 */
static struct net_node *copy_arm(struct march *march, struct arena *arena, int di, int dj,
                                 int32_t *length) {
    for (*length = 0; net_place(march->net, *length * di, *length * dj);)
        ++*length;
    struct net_node *arm = arena_alloc(arena, (size_t)*length + 1, sizeof *arm);
    for (int32_t k = 0; arm && k < *length; k++)
        arm[k] = *net_place(march->net, k * di, k * dj);
    return arm;
}

/* The larger first, so that threads that share them end at about the same time. */
static int compare_sizes(const void *a, const void *b) {
    size_t p = ((const struct quadrant *)a)->size, q = ((const struct quadrant *)b)->size;
    return (p < q) - (p > q);
}

/* Rows for each quadrant, or the same for all that are marched one after the other. */
static enum status make_quadrant_rows(struct march *march, struct arena *arena,
                                      struct quadrant *quadrants, bool together) {
    int32_t longest = 0;
    for (int k = 0; k < NET_TABLES; k++)
        longest = quadrants[k].length > longest ? quadrants[k].length : longest;
    for (int k = 0; k < NET_TABLES; k++) {
        struct quadrant *q = &quadrants[k];
        q->in_blocks = longest >= worth_a_wave;
        bool in_few = !q->in_blocks && !march->overlap && longest >= worth_few;
        if (k > 0 && !together) {
            memcpy(q->row, quadrants[0].row, sizeof q->row);
            q->wave = quadrants[0].wave;
            q->kernel = quadrants[0].kernel;
            memcpy(q->before, quadrants[0].before, sizeof q->before);
            continue;
        }
        enum status status = STATUS_OK;
        if (q->in_blocks || in_few)
            status = wave_make(march, arena, in_few ? FEW : WAVE_LANES, q);
        int rows = 1 + (q->wave ? q->kernel->lanes : 1);
        for (int r = 0; r < rows && status == STATUS_OK; r++) {
            struct quadrant_row *row = &q->row[r];
            row->at = arena_take(arena, (size_t)longest, sizeof *row->at);
            row->lacks = march->cuts ? arena_alloc(arena, (size_t)longest + 1, 1) : NULL;
            status = row->at && (row->lacks || !march->cuts) ? STATUS_OK : STATUS_OUT_OF_MEMORY;
        }
        if (status != STATUS_OK)
            return status;
    }
    return STATUS_OK;
}

/* The rows of a quadrant until the weft generator ends, or the net has left the surface for good.
 */
static void grow_quadrant(void *data, int number) {
    struct quadrant *q = &((struct quadrant *)data)[number];
    struct quadrant_row *arm = &q->row[0];
    enum status status = STATUS_OK;
    bool planted = true;
    arm->count = 0;
    forget_growth(q, arm);
    while (arm->count < q->length && quadrant_point(q, arm->count, 0, &arm->at[arm->count]))
        arm->count++;
    for (int32_t i = 0; i < arm->count; i++)
        q->reach[0] = has_left(q, i, 0, &arm->at[i]) ? q->reach[0] : i;
    bool been_near = q->reach[0] > 0; /* the generator is a row, too */
    q->checked = 1;
    q->march->by_rows = q->march->overlap && q->in_blocks;
    for (int32_t j = 1, empty = 0; empty < q->march->fringe;) {
        int count = 1;
        if (q->wave)
            status = wave_run(q, j, &count);
        for (int k = 1; k <= count && planted && status == STATUS_OK; k++, j++) {
            struct quadrant_row *row = &q->row[k];
            status = grow_row(q, &q->row[k - 1], row, j);
            planted = row->planted;
            been_near = been_near || row->last >= 0;
            empty = been_near && row->last < 0 ? empty + 1 : 0;
        }
        if (status == STATUS_OK && planted && !march_progress(q->march))
            status = STATUS_CANCELLED;
        if (status != STATUS_OK || !planted)
            break;
        const struct quadrant_row top = q->row[count];
        q->row[count] = q->row[0];
        q->row[0] = top;
        if (q->march->by_rows && j == quadrant_block_end(q, q->checked))
            status = quadrant_check_overlaps(q, j);
        if (status != STATUS_OK)
            break;
    }
    if (q->march->by_rows && status == STATUS_OK)
        status = quadrant_check_overlaps(q, quadrant_block_end(q, q->checked));
    q->march->by_rows = false;
    q->status = status;
}

/* Adds what a quadrant has noted of the places that have grown in it. */
static enum status take_grown(struct march *march, const struct march_steps *own) {
    struct march_steps *all = &march->grown;
    if (own->count == 0)
        return STATUS_OK;
    all->room = all->count + own->count;
    all->step = arena_copy(march->arena, all->step, all->count, all->room, sizeof *all->step);
    if (!all->step)
        return STATUS_OUT_OF_MEMORY;
    memcpy(all->step + all->count, own->step, own->count * sizeof *own->step);
    all->count += own->count;
    return STATUS_OK;
}

/* Where the net may meet itself one quadrant has to know of the others: then one after the other.
 * Their own memory is needed no longer than this. */
enum status march_quadrants(struct march *march) {
    const struct drape_team *team = march->settings->team;
    struct march_counts *all = &march->counts;
    bool together = team && !march->overlap;
    struct arena *arena = arena_child(march->arena);
    if (!arena)
        return STATUS_OUT_OF_MEMORY;
    struct arena_mark mark = arena_mark(arena);
    struct quadrant *quadrants = arena_alloc(arena, NET_TABLES, sizeof *quadrants);
    enum status status = quadrants ? STATUS_OK : STATUS_OUT_OF_MEMORY;
    for (int k = 0; k < NET_TABLES && status == STATUS_OK; k++) {
        struct quadrant *q = &quadrants[k];
        int32_t height;
        *q = (struct quadrant){
            .local = *march, .si = k % 2 ? -1 : 1, .sj = (k / 2 != march->cut.inward) ? -1 : 1};
        q->march = &q->local;
        q->local.counts = (struct march_counts){0};
        q->local.grown = (struct march_steps){0};
        if (together && march->cuts && !(q->local.arena = arena_child(march->arena)))
            status = STATUS_OUT_OF_MEMORY;
        q->local.arm[0] = q->arm[0] = copy_arm(march, arena, q->si, 0, &q->length);
        q->local.arm[1] = q->arm[1] = copy_arm(march, arena, 0, q->sj, &height);
        q->size = (size_t)q->length * (size_t)height;
        if (!q->arm[0] || !q->arm[1])
            status = STATUS_OUT_OF_MEMORY;
    }
    if (status == STATUS_OK && together) {
        qsort(quadrants, NET_TABLES, sizeof *quadrants, compare_sizes);
        for (int k = 0; k < NET_TABLES; k++)
            quadrants[k].march = &quadrants[k].local;
    }
    if (status == STATUS_OK)
        status = make_quadrant_rows(march, arena, quadrants, together);
    if (status == STATUS_OK && together)
        team->run(team->context, NET_TABLES, grow_quadrant, quadrants);
    for (int k = 0; k < NET_TABLES && status == STATUS_OK; k++) {
        if (!together)
            grow_quadrant(quadrants, k);
        const struct march_counts *own = &quadrants[k].local.counts;
        all->inside += own->inside;
        all->reported += own->reported;
        all->ghosts += own->ghosts;
        all->broken = all->broken || own->broken;
        all->solved += own->solved;
        all->iterations += own->iterations;
        all->residual_max = fmax(all->residual_max, own->residual_max);
        status = quadrants[k].status;
        if (status == STATUS_OK && all->inside > march->max_nodes)
            status = STATUS_TOO_MANY_NODES;
        if (status == STATUS_OK)
            status = take_grown(march, &quadrants[k].local.grown);
    }
    arena_rewind(arena, mark);
    return status;
}
