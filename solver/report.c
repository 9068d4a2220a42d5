/* SPDX-License-Identifier: MIT */
#include "report.h"

#include "shear.h"

/* Uncovered area that one node of the boundary can stand for, in cells: the strip beyond it, and
 * where the boundary runs obliquely the corner between two of them. */
static const double strip_cells = 2;

/* A known place of the net: (i, j), which is (x, y) of the window. */
struct spot {
    int32_t i, j;
    const struct net_window *window;
    int x, y;
    const struct net_node *node;
};

/* Called for each known place in the order of the result. */
typedef void visitor(struct march *march, struct drape_result *result, const struct spot *spot);

/* Visits one row of tiles that lie at the same height, which `windows` show. */
static void visit_row(struct march *march, struct drape_result *result,
                      const struct net_window *windows, size_t count, int y, visitor *visit) {
    for (size_t t = 0; t < count; t++) {
        const struct net_tile *tile = windows[t].tile[1][1];
        struct spot spot = {.window = &windows[t], .j = tile->tj * NET_TILE + y, .y = y};
        for (int x = 0; x < NET_TILE; x++) {
            spot.i = tile->ti * NET_TILE + x;
            spot.x = x;
            spot.node = &tile->node[y][x];
            if (spot.node->state != NET_UNKNOWN)
                visit(march, result, &spot);
        }
    }
}

/* Visits all known places sorted by j, then i. */
static void visit_net(struct march *march, struct drape_result *result,
                      const struct net_window *windows, visitor *visit) {
    size_t count = net_tile_count(march->net);
    for (size_t first = 0, last; first < count; first = last) {
        int32_t tj = windows[first].tile[1][1]->tj;
        for (last = first; last < count && windows[last].tile[1][1]->tj == tj;)
            last++;
        for (int y = 0; y < NET_TILE; y++)
            visit_row(march, result, &windows[first], last - first, y, visit);
    }
}

/* The four nodes of the cell from the spot on, if all are inside. */
static bool cell_corners(const struct spot *spot, struct vec3 corner[4]) {
    static const int8_t at[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    for (int k = 0; k < 4; k++) {
        const struct net_node *node =
            net_window_find(spot->window, spot->x + at[k][0], spot->y + at[k][1]);
        if (!node || node->state != NET_INSIDE)
            return false;
        corner[k] = node->r;
    }
    return true;
}

/* Whether the net ends at the spot, and why: for the boundary the last node inside stands for it,
 * for all else the place that has no node. */
static bool ends_at(const struct spot *spot, enum drape_reason *reason) {
    static const int8_t side[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
    bool own = spot->node->state != NET_INSIDE;
    *reason = own ? (enum drape_reason)spot->node->reason : DRAPE_REASON_BOUNDARY;
    if (own && *reason == DRAPE_REASON_BOUNDARY)
        return false;
    for (int k = 0; k < 4; k++) {
        const struct net_node *next =
            net_window_find(spot->window, spot->x + side[k][0], spot->y + side[k][1]);
        bool inside = next && next->state == NET_INSIDE;
        if (own ? inside
                : !inside && (!next || next->state == NET_UNKNOWN ||
                              next->reason == DRAPE_REASON_BOUNDARY))
            return true;
    }
    return false;
}

static void count_place(struct march *march, struct drape_result *result, const struct spot *spot) {
    struct vec3 corner[4];
    enum drape_reason reason;
    (void)march;
    result->nodes.count += spot->node->state == NET_INSIDE;
    result->cells.count += spot->node->state == NET_INSIDE && cell_corners(spot, corner);
    result->front.count += ends_at(spot, &reason);
}

static enum status alloc_columns(struct arena *arena, bool estimated, struct drape_result *result) {
    struct drape_nodes *n = &result->nodes;
    struct drape_cells *c = &result->cells;
    struct drape_front *f = &result->front;
    double **columns[] = {&n->u,         &n->v,      &n->x,        &n->y,      &n->z,
                          &n->shear_deg, &c->warp_x, &c->warp_y,   &c->warp_z, &c->weft_x,
                          &c->weft_y,    &c->weft_z, &c->shear_deg};
    int32_t **indices[] = {&n->i, &n->j, &c->i, &c->j, &f->i, &f->j};
    size_t counts[] = {n->count, c->count, f->count};
    bool all = true;
    for (size_t k = 0; k < sizeof columns / sizeof *columns; k++) {
        *columns[k] = arena_alloc(arena, k < 6 ? n->count : c->count, sizeof(double));
        all = all && *columns[k];
    }
    for (size_t k = 0; k < sizeof indices / sizeof *indices; k++) {
        *indices[k] = arena_alloc(arena, counts[k / 2], sizeof(int32_t));
        all = all && *indices[k];
    }
    if (estimated) {
        n->error_estimate = arena_alloc(arena, n->count, sizeof *n->error_estimate);
        all = all && n->error_estimate;
    }
    f->reason = arena_alloc(arena, f->count, sizeof *f->reason);
    n->count = c->count = f->count = 0;
    return all && f->reason ? STATUS_OK : STATUS_OUT_OF_MEMORY;
}

/* The parameters within the domain, and the point there: a node that lies outside by rounding, or
 * on a later turn round a closed direction, is brought back. */
static struct vec3 bring_inside(struct march *march, const struct net_node *node, double uv[2]) {
    struct surface_jet jet;
    bool moved = false;
    for (int k = 0; k < 2; k++) {
        const struct surface_axis *axis = &march->surface->axis[k];
        double wrapped = surface_axis_wrap(axis, node->uv[k]);
        uv[k] = fmin(fmax(wrapped, surface_axis_lower(axis)), surface_axis_upper(axis));
        moved = moved || uv[k] != wrapped;
    }
    if (!moved)
        return node->r;
    surface_evaluate(march->surface, &march->cursor, uv[0], uv[1], &jet);
    return jet.r;
}

/* The distance to the first march's node, of which it is the error to leading order. Where that had
 * none, the largest elsewhere stands for it (`summarise`). */
static void add_estimate(struct march *march, struct drape_result *result, size_t at,
                         const struct spot *spot) {
    const struct net_node *before = net_place(march->before, spot->i, spot->j);
    double estimate = before ? vec3_distance(before->r, spot->node->r) : -1;
    result->nodes.error_estimate[at] = estimate;
    result->summary.error_estimate_max = fmax(result->summary.error_estimate_max, estimate);
}

static void add_node(struct march *march, struct drape_result *result, const struct spot *spot) {
    struct drape_nodes *nodes = &result->nodes;
    size_t at = nodes->count++;
    double uv[2], shear = shear_at_node(spot->window, spot->x, spot->y,
                                        march->before ? SHEAR_FOURTH : SHEAR_SECOND);
    struct vec3 r = bring_inside(march, spot->node, uv);
    nodes->i[at] = spot->i;
    nodes->j[at] = spot->j;
    nodes->u[at] = uv[0];
    nodes->v[at] = uv[1];
    nodes->x[at] = r.x;
    nodes->y[at] = r.y;
    nodes->z[at] = r.z;
    nodes->shear_deg[at] = shear;
    if (march->before)
        add_estimate(march, result, at, spot);
}

/* Half the cross product of the diagonals: the area of a flat quadrilateral, to second order that
 * of a curved one. */
static double cell_area(const struct vec3 corner[4]) {
    return vec3_norm(vec3_cross(vec3_sub(corner[2], corner[0]), vec3_sub(corner[3], corner[1]))) /
           2;
}

static void add_cell(struct drape_result *result, int32_t i, int32_t j,
                     const struct vec3 corner[4]) {
    struct drape_cells *cells = &result->cells;
    struct shear_cell cell = shear_of_cell(corner[0], corner[1], corner[2], corner[3]);
    size_t at = cells->count++;
    cells->i[at] = i;
    cells->j[at] = j;
    cells->shear_deg[at] = cell.shear_deg;
    cells->warp_x[at] = cell.warp.x;
    cells->warp_y[at] = cell.warp.y;
    cells->warp_z[at] = cell.warp.z;
    cells->weft_x[at] = cell.weft.x;
    cells->weft_y[at] = cell.weft.y;
    cells->weft_z[at] = cell.weft.z;
    result->summary.coverage += cell_area(corner);
}

static void add_place(struct march *march, struct drape_result *result, const struct spot *spot) {
    struct vec3 corner[4];
    enum drape_reason reason;
    if (spot->node->state == NET_INSIDE)
        add_node(march, result, spot);
    if (spot->node->state == NET_INSIDE && cell_corners(spot, corner))
        add_cell(result, spot->i, spot->j, corner);
    if (ends_at(spot, &reason)) {
        struct drape_front *front = &result->front;
        front->i[front->count] = spot->i;
        front->j[front->count] = spot->j;
        front->reason[front->count++] = (uint8_t)reason;
        result->summary.front_reasons[reason]++;
    }
}

/* Complete when nothing but boundary and, round a closed surface, the net itself stopped it, and
 * what lies uncovered along them is no more than a strip. */
static enum drape_outcome outcome_of(const struct march *march, const struct drape_summary *s,
                                     double uncovered) {
    const double *d = march->settings->spacing;
    size_t ends = s->front_reasons[DRAPE_REASON_BOUNDARY] + s->front_reasons[DRAPE_REASON_FOLD],
           all = 0;
    for (int k = 0; k < DRAPE_REASON_COUNT; k++)
        all += s->front_reasons[k];
    double strip = strip_cells * (double)ends * d[0] * d[1];
    return ends == all && uncovered <= strip ? DRAPE_COMPLETE : DRAPE_PARTIAL;
}

static void summarise(const struct march *march, struct drape_result *result) {
    struct drape_summary *s = &result->summary;
    const struct drape_nodes *nodes = &result->nodes;
    double sum = 0, area = march_area(march), covered = s->coverage;
    for (size_t k = 0; k < nodes->count; k++) {
        double shear = fabs(nodes->shear_deg[k]);
        s->max_shear_deg = fmax(s->max_shear_deg, shear);
        sum += shear;
        bool first = k == 0;
        int32_t *wi = result->warp_range, *wj = result->weft_range;
        wi[0] = first || nodes->i[k] < wi[0] ? nodes->i[k] : wi[0];
        wi[1] = first || nodes->i[k] > wi[1] ? nodes->i[k] : wi[1];
        wj[0] = first || nodes->j[k] < wj[0] ? nodes->j[k] : wj[0];
        wj[1] = first || nodes->j[k] > wj[1] ? nodes->j[k] : wj[1];
    }
    s->mean_shear_deg = nodes->count ? sum / (double)nodes->count : 0;
    s->coverage = fmin(covered / area, 1);
    s->outcome = outcome_of(march, s, area - covered);
    s->residual_max = march->residual_max;
    s->newton_iterations_mean =
        march->solved ? (double)march->iterations / (double)march->solved : 0;
    for (size_t k = 0; nodes->error_estimate && k < nodes->count; k++)
        if (nodes->error_estimate[k] < 0)
            nodes->error_estimate[k] = s->error_estimate_max;
}

/* Windows on all tiles, sorted by row, then column; NULL without memory. */
static struct net_window *make_windows(struct net *net) {
    struct net_tile **tiles = net_sorted_tiles(net);
    struct net_window *windows = arena_alloc(net->arena, net_tile_count(net), sizeof *windows);
    for (size_t t = 0; tiles && windows && t < net_tile_count(net); t++)
        windows[t] = net_window(net, tiles[t]->ti, tiles[t]->tj);
    return tiles ? windows : NULL;
}

enum status report_make(struct march *march, struct drape_result *result) {
    *result = (struct drape_result){.start_point = march->start.station.jet.r,
                                    .start_warp = march->start.warp,
                                    .start_weft = march->start.weft,
                                    .summary.error_estimate_max = -1};
    result->start_uv[0] = march->start.station.uv[0];
    result->start_uv[1] = march->start.station.uv[1];
    struct net_window *windows = make_windows(march->net);
    if (!windows)
        return STATUS_OUT_OF_MEMORY;
    visit_net(march, result, windows, count_place);
    enum status status = alloc_columns(march->arena, march->before, result);
    if (status != STATUS_OK)
        return status;
    visit_net(march, result, windows, add_place);
    summarise(march, result);
    return STATUS_OK;
}
