/* SPDX-License-Identifier: MIT */
#include "report.h"

#include "report_strip.h"
#include "solver/rim/rim_report.h"
#include "solver/team.h"

static enum status alloc_columns(struct arena *arena, bool faces, struct drape_result *result) {
    struct drape_nodes *n = &result->nodes;
    struct drape_cells *c = &result->cells;
    struct drape_front *f = &result->front;
    double **columns[] = {&n->u,         &n->v,      &n->x,        &n->y,      &n->z,
                          &n->shear_deg, &c->warp_x, &c->warp_y,   &c->warp_z, &c->weft_x,
                          &c->weft_y,    &c->weft_z, &c->shear_deg};
    int32_t **indices[] = {&n->i, &n->j, &c->i, &c->j, &f->i, &f->j};
    size_t counts[] = {n->count, c->count, f->count};
    bool all = !faces || (n->face = arena_take(arena, n->count, sizeof *n->face));
    for (size_t k = 0; k < sizeof columns / sizeof *columns; k++)
        all = all && (*columns[k] = arena_take(arena, k < 6 ? n->count : c->count, sizeof(double)));
    for (size_t k = 0; k < sizeof indices / sizeof *indices; k++)
        all = all && (*indices[k] = arena_take(arena, counts[k / 2], sizeof(int32_t)));
    all = all && (n->grown = arena_take(arena, n->count, sizeof *n->grown)) &&
          (f->reason = arena_take(arena, f->count, sizeof *f->reason));
    return all ? STATUS_OK : STATUS_OUT_OF_MEMORY;
}

static void summarise_net(const struct march *march, struct drape_result *result) {
    struct drape_summary *s = &result->summary;
    struct drape_nodes *nodes = &result->nodes;
    size_t count = nodes->count;
    int32_t least = count ? nodes->i[0] : 0, most = least;
    for (size_t k = 0; k < count; k++) {
        least = nodes->i[k] < least ? nodes->i[k] : least;
        most = nodes->i[k] > most ? nodes->i[k] : most;
    }
    result->warp_range[0] = least;
    result->warp_range[1] = most;
    result->weft_range[0] = count ? nodes->j[0] : 0; /* they are sorted by j */
    result->weft_range[1] = count ? nodes->j[count - 1] : 0;
    s->coverage = fmin(s->coverage / march_area(march), 1);
    s->residual_max = march->counts.residual_max;
    s->newton_iterations_mean =
        march->counts.solved ? (double)march->counts.iterations / (double)march->counts.solved : 0;
    /* where the first march had no node, the largest elsewhere stands for it */
    for (size_t k = 0; nodes->error_estimate && k < count; k++)
        if (nodes->error_estimate[k] < 0)
            nodes->error_estimate[k] = s->error_estimate_max;
    if (s->shear_error_max < 0) /* no yarn has enough nodes to tell it */
        nodes->shear_error_deg = NULL;
    for (size_t k = 0; nodes->shear_error_deg && k < count; k++)
        if (nodes->shear_error_deg[k] < 0)
            nodes->shear_error_deg[k] = s->shear_error_max;
}

static bool begins_row(const struct net_window *windows, size_t t) {
    return t == 0 || windows[t].tile[1][1]->tj != windows[t - 1].tile[1][1]->tj;
}

/* One strip for each row of tiles; NULL without memory. */
static struct report_strip *make_strips(struct march *march, struct drape_result *result,
                                        int *count) {
    size_t count_of_tiles = net_tile_count(march->net), rows = 0;
    struct net_tile **tiles = net_sorted_tiles(march->net);
    struct net_window *windows = arena_take(march->arena, count_of_tiles, sizeof *windows);
    if (!tiles || !windows)
        return NULL;
    for (size_t t = 0; t < count_of_tiles; t++) {
        windows[t] = net_window(march->net, tiles[t]->ti, tiles[t]->tj);
        rows += begins_row(windows, t);
    }
    struct report_strip *strips = arena_alloc(march->arena, rows, sizeof *strips);
    if (!strips)
        return NULL;
    *count = 0;
    for (size_t t = 0; t < count_of_tiles; t++) {
        if (begins_row(windows, t)) {
            struct report_strip *strip = &strips[(*count)++];
            *strip = (struct report_strip){.march = march,
                                           .result = result,
                                           .windows = &windows[t],
                                           .before = march->before,
                                           .estimate_max = -1,
                                           .shear_error_max = -1};
        }
        strips[*count - 1].count++;
    }
    /* Strips that are made one after the other share them. */
    size_t kept = net_has_rough(march->net) ? 2 * REPORT_SPOTS : 0;
    size_t sharing = march->settings->team ? 1 : (size_t)*count;
    struct yarn_spot *spots =
        arena_alloc(march->arena, kept * (size_t)*count / sharing, sizeof *spots);
    for (int k = 0; spots && k < *count; k++)
        strips[k].spots = spots + kept * ((size_t)k / sharing);
    return spots ? strips : NULL;
}

/* All that is made at the same time once the places in the columns are known. */
struct tasks {
    struct rim_found *rim;
    struct report_strip *strips;
};

/* The rim, which takes longest, first. */
static void add_strip(void *data, int k) {
    const struct tasks *tasks = data;
    if (k == 0)
        rim_report_find(tasks->rim);
    else
        report_strip_add(&tasks->strips[k - 1]);
}

enum status report_make(struct march *march, struct drape_result *result) {
    const struct drape_team *team = march->settings->team;
    struct drape_nodes *nodes = &result->nodes;
    int count;
    *result = (struct drape_result){
        .start_point = march->start.point.jet.r,
        .start_warp = march->start.warp,
        .start_weft = march->start.weft,
        .start_zero = march->start.zero,
        .start_side = march->start.side,
        .summary = {.error_estimate_max = -1, .shear_error_max = -1, .max_shear_error_deg = -1}};
    (void)march_parameters(march, &march->start.point, result->start_uv);
    result->start_face = march_face(march, &march->start.point);
    struct report_strip *strips = make_strips(march, result, &count);
    struct tasks tasks = {rim_report_begin(march), strips};
    if (!strips || !tasks.rim)
        return STATUS_OUT_OF_MEMORY;
    team_run(team, count, report_strip_count, strips);
    struct report_tally sum = {0}; /* gives each strip its places in the columns */
    for (int k = 0; k < count; k++) {
        strips[k].next = sum;
        sum.nodes += strips[k].holds.nodes;
        sum.cells += strips[k].holds.cells;
        sum.front += strips[k].holds.front;
    }
    nodes->count = sum.nodes;
    result->cells.count = sum.cells;
    result->front.count = sum.front;
    /* Takes the estimates from the net that was corrected, and gives its memory back. */
    if (march->first) {
        nodes->error_estimate =
            arena_take(march->arena, nodes->count, sizeof *nodes->error_estimate);
        nodes->shear_error_deg =
            arena_take(march->arena, nodes->count, sizeof *nodes->shear_error_deg);
        if (!nodes->error_estimate || !nodes->shear_error_deg)
            return STATUS_OUT_OF_MEMORY;
        team_run(team, count, report_strip_add_estimates, strips);
        net_free(march->first);
        march->first = NULL;
        march->before = (struct net_view){.net = NULL};
    }
    if (alloc_columns(march->arena, march->surface && march->surface->shell, result) != STATUS_OK)
        return STATUS_OUT_OF_MEMORY;
    team_run(team, count + 1, add_strip, &tasks);
    /* In the order of the strips: the same sums, to the last bit, on any threads. */
    struct drape_summary *summary = &result->summary;
    for (int k = 0; k < count; k++) {
        summary->coverage += strips[k].covered;
        summary->error_estimate_max = fmax(summary->error_estimate_max, strips[k].estimate_max);
        summary->shear_error_max = fmax(summary->shear_error_max, strips[k].shear_error_max);
        for (int reason = 0; reason < DRAPE_REASON_COUNT; reason++)
            summary->front_reasons[reason] += strips[k].reasons[reason];
    }
    summarise_net(march, result);
    return rim_report(march, tasks.rim, result);
}
