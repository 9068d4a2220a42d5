/* SPDX-License-Identifier: MIT */
#include "report.h"

#include "estimate.h"
#include "solver/angle.h"
#include "solver/fishnet/yarn.h"
#include "solver/net/shear.h"
#include "solver/rim/rim_report.h"
#include <string.h>

/* The bits of a row of a window that are the tile's own. */
static const uint32_t own_bits = ((1u << NET_TILE) - 1) << 1;

/* Where the normals at a cell's corners differ by more than this, the surface is folded there. */
static const double folded_cosine = 0.5;

/* Nodes that are kept of each of two rows. */
enum { SPOTS = 64 };

/* The surface is developable, for all that matters, where |K| d^2 is less. */
static const double developable = 1e-4;

/* A known place of the net: (i, j), which is (x, y) of the window. */
struct spot {
    int32_t i, j;
    const struct net_window *window;
    int x, y;
    const struct net_node *node;
};

struct tally {
    size_t nodes, cells, front;
};

/* A row of tiles at the same height: a part of the result that is made by itself, after all have
 * been counted, so that the parts can be made at the same time. */
struct part {
    const struct march *march;
    struct drape_result *result;
    const struct net_window *windows; /* on its tiles, in order */
    size_t count;
    struct tally holds; /* how much it has for the columns */
    struct tally next;  /* where in them its next one goes */
    double covered;     /* area of its cells */
    double estimate_max;
    bool plain; /* the caller's parameters are the surface's own, within these */
    double lower[2], upper[2];
    size_t reasons[DRAPE_REASON_COUNT];
    struct surface_cursor cursor;
    struct net_view before;
    struct yarn_spot *spots; /* of a net with rough edges: the nodes of two rows that have been
                                measured last, that of (i, j) at i % SPOTS of row j % 2 */
};

/* Own places of row y that are inside, those from which a cell goes on, and those at which the net
 * may end: inside with a neighbour that is not, or the other way round. */
struct row_bits {
    uint32_t inside, cells, rim;
};

/* Whether the four corners of a cell that is not folded turn one way. */
static bool is_convex(const struct net_window *window, int x, int y) {
    const struct net_node *node[4] = {
        net_window_find(window, x, y), net_window_find(window, x + 1, y),
        net_window_find(window, x + 1, y + 1), net_window_find(window, x, y + 1)};
    struct vec3 edge[4], normal = vec3_make(0, 0, 0);
    for (int k = 0; k < 4; k++)
        edge[k] = vec3_sub(node[(k + 1) & 3]->r, node[k]->r);
    for (int k = 0; k < 4; k++)
        normal = vec3_add(normal, vec3_cross(edge[k], edge[(k + 1) & 3]));
    for (int k = 0; k < 4; k++)
        if (!(vec3_dot(vec3_cross(edge[k], edge[(k + 1) & 3]), normal) > 0))
            return false;
    return true;
}

static bool station_of(struct part *part, const struct net_node *node, struct station *station) {
    if (node && part->march->mesh) {
        struct mesh_place place = {.triangle = (int32_t)node->uv[0], .r = node->r};
        *station = march_mesh_station(part->march, &place);
        return true;
    }
    return node && station_at(march_surface(part->march, node), &part->cursor, node->uv, station);
}

static struct yarn_net yarn_net(struct part *part) {
    return (struct yarn_net){part->march->net, part->march->surface, &part->cursor};
}

/* The node at (x, y) of a window, which is kept for the cells and nodes next to it; NULL where
 * there is no tangent plane. */
static struct yarn_spot *spot_of(struct part *part, const struct net_window *window, int x, int y) {
    int32_t i = window->tile[1][1]->ti * NET_TILE + x, j = window->tile[1][1]->tj * NET_TILE + y;
    struct yarn_spot *spot = &part->spots[(j & 1) * SPOTS + (i & (SPOTS - 1))];
    if (spot->filled && spot->i == i && spot->j == j)
        return spot;
    spot->filled = station_of(part, net_window_find(window, x, y), &spot->station);
    spot->i = i;
    spot->j = j;
    spot->known = 0;
    return spot->filled ? spot : NULL;
}

/* The corners of the cell from (x, y) on. */
static bool find_corners(struct part *part, const struct net_window *window, int x, int y,
                         struct yarn_spot *corner[4]) {
    static const int8_t at[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    for (int k = 0; k < 4; k++)
        if (!(corner[k] = spot_of(part, window, x + at[k][0], y + at[k][1])))
            return false;
    return true;
}

/* Whether a cell whose corners do not turn one way in space is cloth all the same: one that is bent
 * over a fold, and open in the surface. */
static bool is_bent(struct part *part, const struct net_window *window, int x, int y) {
    struct yarn_spot *corner[4];
    double least = 1;
    if (!yarn_cell_is_rough(window, x, y) || !find_corners(part, window, x, y, corner))
        return false;
    for (int k = 1; k < 4; k++)
        least = fmin(least, vec3_dot(corner[0]->station.normal, corner[k]->station.normal));
    struct yarn_net net = yarn_net(part);
    return least < folded_cosine && yarn_cell_is_open(&net, window, x, y, corner);
}

/* Those of the cells that are no cloth: yarns along free edges may close cells that are not convex,
 * and so may rough ones where the net all but collapses. The march never makes others. */
static uint32_t no_cells(struct part *part, const struct net_window *window, int y,
                         uint32_t cells) {
    uint32_t row = net_window_bits(window, NET_BIT_GROWN, y), none = 0;
    uint32_t up = net_window_bits(window, NET_BIT_GROWN, y + 1);
    row |= net_window_bits(window, NET_BIT_ROUGH, y);
    up |= net_window_bits(window, NET_BIT_ROUGH, y + 1);
    for (uint32_t left = cells & (row | row >> 1 | up | up >> 1); left; left &= left - 1) {
        int bit = __builtin_ctz(left);
        if (!is_convex(window, bit - 1, y) && !is_bent(part, window, bit - 1, y))
            none |= 1u << bit;
    }
    return none;
}

static struct row_bits row_bits(struct part *part, const struct net_window *window, int y) {
    uint32_t row = net_window_bits(window, NET_BIT_INSIDE, y);
    uint32_t up = net_window_bits(window, NET_BIT_INSIDE, y + 1), both = row & up;
    uint32_t down = net_window_bits(window, NET_BIT_INSIDE, y - 1);
    uint32_t all = up & down & row << 1 & row >> 1, any = up | down | row << 1 | row >> 1;
    uint32_t cells = both & both >> 1 & own_bits;
    return (struct row_bits){.inside = row & own_bits,
                             .cells = cells & ~no_cells(part, window, y, cells),
                             .rim = ((row & ~all) | (~row & any)) & own_bits};
}

static struct spot spot_at(const struct net_window *window, int x, int y) {
    const struct net_tile *tile = window->tile[1][1];
    return (struct spot){.i = tile->ti * NET_TILE + x,
                         .j = tile->tj * NET_TILE + y,
                         .window = window,
                         .x = x,
                         .y = y,
                         .node = &tile->node[y][x]};
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

static void count_tile(struct part *part, size_t t) {
    for (int y = 0; y < NET_TILE; y++) {
        struct row_bits bits = row_bits(part, &part->windows[t], y);
        part->holds.nodes += (size_t)__builtin_popcount(bits.inside);
        part->holds.cells += (size_t)__builtin_popcount(bits.cells);
        for (uint32_t rim = bits.rim; rim; rim &= rim - 1) {
            enum drape_reason reason;
            struct spot spot = spot_at(&part->windows[t], __builtin_ctz(rim) - 1, y);
            part->holds.front += ends_at(&spot, &reason);
        }
    }
}

static void count_part(void *data, int k) {
    struct part *part = &((struct part *)data)[k];
    for (size_t t = 0; t < part->count; t++)
        count_tile(part, t);
}

static enum status alloc_columns(struct arena *arena, bool faces, struct drape_result *result) {
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
        *columns[k] = arena_take(arena, k < 6 ? n->count : c->count, sizeof(double));
        all = all && *columns[k];
    }
    for (size_t k = 0; k < sizeof indices / sizeof *indices; k++) {
        *indices[k] = arena_take(arena, counts[k / 2], sizeof(int32_t));
        all = all && *indices[k];
    }
    if (faces) {
        n->face = arena_take(arena, n->count, sizeof *n->face);
        all = all && n->face;
    }
    n->grown = arena_take(arena, n->count, sizeof *n->grown);
    f->reason = arena_take(arena, f->count, sizeof *f->reason);
    return all && n->grown && f->reason ? STATUS_OK : STATUS_OUT_OF_MEMORY;
}

/* The parameters within the domain, and the point there: a node that lies outside by rounding, or
 * on a later turn round a closed direction, is brought back. */
static struct vec3 bring_inside(struct part *part, const struct net_node *node, double uv[2]) {
    const struct surface *surface = march_surface(part->march, node);
    struct surface_jet jet;
    bool moved = false;
    if (part->march->mesh) {
        struct mesh_place place = {.triangle = (int32_t)node->uv[0], .r = node->r};
        mesh_parameters(part->march->mesh, &place, uv);
        return node->r;
    }
    for (int k = 0; k < 2; k++) {
        const struct surface_axis *axis = &surface->axis[k];
        double wrapped = surface_axis_wrap(axis, node->uv[k]);
        double low = surface_axis_lower(axis), high = surface_axis_upper(axis);
        uv[k] = wrapped < low ? low : wrapped > high ? high : wrapped;
        moved = moved || uv[k] != wrapped;
    }
    if (moved)
        surface_jet_at(surface, &part->cursor, uv[0], uv[1], &jet);
    surface_outer(surface, uv, uv);
    return moved ? jet.r : node->r;
}

static void add_node(struct part *part, const struct spot *spot, double shear_deg) {
    struct drape_nodes *nodes = &part->result->nodes;
    const struct net_node *node = spot->node;
    size_t at = part->next.nodes++;
    double uv[2] = {node->uv[0], node->uv[1]};
    bool plain = part->plain && uv[0] >= part->lower[0] && uv[0] <= part->upper[0] &&
                 uv[1] >= part->lower[1] && uv[1] <= part->upper[1];
    struct vec3 r = plain ? node->r : bring_inside(part, node, uv);
    nodes->i[at] = spot->i;
    nodes->j[at] = spot->j;
    nodes->u[at] = uv[0];
    nodes->v[at] = uv[1];
    if (nodes->face)
        nodes->face[at] = node->face;
    nodes->x[at] = r.x;
    nodes->y[at] = r.y;
    nodes->z[at] = r.z;
    nodes->shear_deg[at] = shear_deg;
    nodes->grown[at] = node->grown;
}

/* The nodes of row y of a tile, those that are `inside`. Returns the places, as bits, whose shear
 * is by the stencil that most have. */
static uint32_t add_nodes(struct part *part, const struct net_window *window, int y,
                          const struct shear_block *block, uint32_t inside) {
    enum drape_method method = part->march->settings->method;
    bool chords = method == DRAPE_BASIC || method == DRAPE_MOSAIC;
    enum shear_order order = chords ? SHEAR_SECOND : SHEAR_FOURTH;
    struct shear_row yarns;
    double shear_deg[SHEAR_PLACES];
    uint32_t usual = shear_nodes(block, order, &yarns);
    for (uint32_t left = inside >> 1 & ~usual; left; left &= left - 1)
        shear_node(&yarns, window, __builtin_ctz(left), y, order);
    shear_angles(&yarns, shear_deg);
    for (uint32_t left = inside >> 1; left; left &= left - 1) {
        struct spot spot = spot_at(window, __builtin_ctz(left), y);
        add_node(part, &spot, shear_deg[spot.x]);
    }
    return usual;
}

/* The cells from row y of a tile, of which some are rough. */
static void add_cells(struct part *part, const struct net_window *window, int y,
                      const struct shear_block *block, uint32_t cells, uint32_t rough) {
    struct drape_cells *to = &part->result->cells;
    double *warp[] = {to->warp_x, to->warp_y, to->warp_z};
    double *weft[] = {to->weft_x, to->weft_y, to->weft_z};
    struct shear_row yarns;
    double shear_deg[SHEAR_PLACES], area[SHEAR_PLACES];
    uint32_t usual = shear_cells(block, &yarns, area) & ~(rough >> 1);
    for (uint32_t left = cells >> 1 & ~usual; left; left &= left - 1) {
        int x = __builtin_ctz(left);
        shear_cell(&yarns, window, x, y, rough >> (x + 1) & 1);
    }
    shear_normalise(&yarns);
    shear_angles(&yarns, shear_deg);
    for (uint32_t left = cells >> 1; left; left &= left - 1) {
        int x = __builtin_ctz(left);
        size_t at = part->next.cells++;
        to->i[at] = window->tile[1][1]->ti * NET_TILE + x;
        to->j[at] = window->tile[1][1]->tj * NET_TILE + y;
        to->shear_deg[at] = shear_deg[x];
        for (int k = 0; k < 3; k++) {
            warp[k][at] = yarns.warp[k][x];
            weft[k][at] = yarns.weft[k][x];
        }
        if (!(rough >> (x + 1) & 1))
            part->covered += area[x];
    }
}

/* The shear angle at a node near rough edges, number `at`, between the directions of its yarns. */
static void measure_node(struct part *part, const struct spot *spot, size_t at) {
    struct yarn_spot *own = spot_of(part, spot->window, spot->x, spot->y);
    struct yarn_net net = yarn_net(part);
    if (own)
        part->result->nodes.shear_deg[at] =
            90 - yarn_node_angle(&net, spot->window, spot->x, spot->y, own);
}

/* Whether the surface has hardly any curvature of its own at a node, so that yarns do not turn
 * sideways and the one direction in which one ends is its own. */
static bool is_developable(struct part *part, const struct spot *spot) {
    struct yarn_spot *own = spot_of(part, spot->window, spot->x, spot->y);
    const double *d = part->march->settings->spacing;
    return own && fabs(station_gauss_curvature(&own->station)) * d[0] * d[1] < developable;
}

/* The same of a cell, and its area, that of the fabric. */
static void measure_cell(struct part *part, const struct spot *spot, size_t at) {
    struct drape_cells *cells = &part->result->cells;
    struct yarn_spot *corner[4];
    const double *d = part->march->settings->spacing;
    double sine, cosine;
    bool regular = find_corners(part, spot->window, spot->x, spot->y, corner);
    struct yarn_net net = yarn_net(part);
    double w = regular ? yarn_cell_angle(&net, spot->window, spot->x, spot->y, corner)
                       : 90 - cells->shear_deg[at];
    struct vec3 warp = {cells->warp_x[at], cells->warp_y[at], cells->warp_z[at]};
    struct vec3 weft = {cells->weft_x[at], cells->weft_y[at], cells->weft_z[at]};
    shear_set_angle(&warp, &weft, w);
    cells->warp_x[at] = warp.x;
    cells->warp_y[at] = warp.y;
    cells->warp_z[at] = warp.z;
    cells->weft_x[at] = weft.x;
    cells->weft_y[at] = weft.y;
    cells->weft_z[at] = weft.z;
    cells->shear_deg[at] = 90 - w;
    angle_sincos_deg(w, &sine, &cosine);
    part->covered += d[0] * d[1] * fabs(sine);
}

static void add_end(struct part *part, const struct spot *spot) {
    struct drape_front *front = &part->result->front;
    enum drape_reason reason;
    if (!ends_at(spot, &reason))
        return;
    size_t at = part->next.front++;
    front->i[at] = spot->i;
    front->j[at] = spot->j;
    front->reason[at] = (uint8_t)reason;
    part->reasons[reason]++;
}

/* The nodes and cells of a row that rough edges are near, one after the other; the first of the row
 * are at `first`. Stencils at the `ends` of yarns reach further. */
static void measure_rough(struct part *part, size_t t, int y, const struct row_bits *bits,
                          uint32_t ends, uint32_t cells, struct tally first) {
    uint32_t near = net_window_near_rough(&part->windows[t], y, SHEAR_REACH) << 1;
    uint32_t far = net_window_near_rough(&part->windows[t], y, SHEAR_REACH_AT_END) << 1;
    for (uint32_t left = bits->inside | bits->cells; left; left &= left - 1) {
        int bit = __builtin_ctz(left);
        struct spot spot = spot_at(&part->windows[t], bit - 1, y);
        uint32_t here = bits->inside & 1u << bit;
        if (here & near || (here & far & ends && is_developable(part, &spot)))
            measure_node(part, &spot, first.nodes);
        if (bits->cells & cells & 1u << bit)
            measure_cell(part, &spot, first.cells);
        first.nodes += bits->inside >> bit & 1;
        first.cells += bits->cells >> bit & 1;
    }
}

/* The cells of row y that have a node with a rough edge next to them, as bits like those of nodes.
 */
static uint32_t rough_cells(const struct net_window *window, int y) {
    uint32_t low = net_window_near_rough(window, y, 1);
    uint32_t high = net_window_near_rough(window, y + 1, 1);
    return (low | low >> 1 | high | high >> 1) << 1;
}

static void add_row(struct part *part, size_t t, int y) {
    struct row_bits bits = row_bits(part, &part->windows[t], y);
    bool measured = net_has_rough(part->march->net);
    uint32_t rough = measured ? rough_cells(&part->windows[t], y) : 0, usual = 0;
    struct tally first = part->next;
    struct shear_block block;
    if (!(bits.inside | bits.rim))
        return;
    shear_load(&block, &part->windows[t], y);
    if (bits.inside)
        usual = add_nodes(part, &part->windows[t], y, &block, bits.inside);
    if (bits.cells)
        add_cells(part, &part->windows[t], y, &block, bits.cells, rough);
    for (uint32_t left = bits.rim; left; left &= left - 1) {
        struct spot spot = spot_at(&part->windows[t], __builtin_ctz(left) - 1, y);
        add_end(part, &spot);
    }
    if (measured)
        measure_rough(part, t, y, &bits, ~usual << 1, rough, first);
}

/* All that is made at the same time once the places in the columns are known. */
struct tasks {
    struct rim_found *rim;
    struct part *parts;
};

/* Sorted by j, then i; the rim, which takes longest, first. */
static void add_part(void *data, int k) {
    const struct tasks *tasks = data;
    if (k == 0) {
        rim_report_find(tasks->rim);
        return;
    }
    struct part *part = &tasks->parts[k - 1];
    for (int y = 0; y < NET_TILE; y++)
        for (size_t t = 0; t < part->count; t++)
            add_row(part, t, y);
}

static void summarise(const struct march *march, struct drape_result *result) {
    struct drape_summary *s = &result->summary;
    const struct drape_nodes *nodes = &result->nodes;
    for (size_t k = 0; k < nodes->count; k++) {
        bool first = k == 0;
        int32_t *wi = result->warp_range, *wj = result->weft_range;
        wi[0] = first || nodes->i[k] < wi[0] ? nodes->i[k] : wi[0];
        wi[1] = first || nodes->i[k] > wi[1] ? nodes->i[k] : wi[1];
        wj[0] = first || nodes->j[k] < wj[0] ? nodes->j[k] : wj[0];
        wj[1] = first || nodes->j[k] > wj[1] ? nodes->j[k] : wj[1];
    }
    s->coverage = fmin(s->coverage / march_area(march), 1);
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
    struct net_window *windows = arena_take(net->arena, net_tile_count(net), sizeof *windows);
    for (size_t t = 0; tiles && windows && t < net_tile_count(net); t++)
        windows[t] = net_window(net, tiles[t]->ti, tiles[t]->tj);
    return tiles ? windows : NULL;
}

static bool begins_row(const struct net_window *windows, size_t t) {
    return t == 0 || windows[t].tile[1][1]->tj != windows[t - 1].tile[1][1]->tj;
}

static size_t tile_rows(const struct net_window *windows, size_t tiles) {
    size_t rows = 0;
    for (size_t t = 0; windows && t < tiles; t++)
        rows += begins_row(windows, t);
    return rows;
}

static void find_plain(const struct march *march, struct part *part) {
    part->plain = !march->mesh && !march->surface->shell;
    for (int k = 0; part->plain && k < 2; k++) {
        const struct surface_axis *axis = &march->surface->axis[k];
        part->lower[k] = surface_axis_lower(axis);
        part->upper[k] = surface_axis_upper(axis);
        part->plain = axis->factor == 1 && axis->origin == 0;
    }
}

/* One part for each row of tiles; NULL without memory. */
static struct part *make_parts(struct march *march, struct drape_result *result, int *count) {
    size_t tiles = net_tile_count(march->net);
    const struct net_window *windows = make_windows(march->net);
    struct part *parts = arena_alloc(march->arena, tile_rows(windows, tiles), sizeof *parts);
    if (!windows || !parts)
        return NULL;
    *count = 0;
    for (size_t t = 0; t < tiles; t++) {
        if (begins_row(windows, t)) {
            struct part *part = &parts[(*count)++];
            *part = (struct part){.march = march,
                                  .result = result,
                                  .windows = &windows[t],
                                  .before = march->before,
                                  .estimate_max = -1};
        }
        parts[*count - 1].count++;
    }
    size_t kept = net_has_rough(march->net) ? 2 * SPOTS : 0;
    struct yarn_spot *spots = arena_alloc(march->arena, kept * (size_t)*count, sizeof *spots);
    for (int k = 0; spots && k < *count; k++) {
        parts[k].spots = spots + kept * (size_t)k;
        find_plain(march, &parts[k]);
    }
    return spots ? parts : NULL;
}

/* Gives each part its places in the columns. */
static void place_parts(struct part *parts, int count, struct drape_result *result) {
    struct tally sum = {0};
    for (int k = 0; k < count; k++) {
        parts[k].next = sum;
        sum.nodes += parts[k].holds.nodes;
        sum.cells += parts[k].holds.cells;
        sum.front += parts[k].holds.front;
    }
    result->nodes.count = sum.nodes;
    result->cells.count = sum.cells;
    result->front.count = sum.front;
}

/* In the order of the parts: the same sums, to the last bit, on any threads. */
static void gather_parts(const struct part *parts, int count, struct drape_summary *summary) {
    for (int k = 0; k < count; k++) {
        summary->coverage += parts[k].covered;
        summary->error_estimate_max = fmax(summary->error_estimate_max, parts[k].estimate_max);
        for (int reason = 0; reason < DRAPE_REASON_COUNT; reason++)
            summary->front_reasons[reason] += parts[k].reasons[reason];
    }
}

static void run(const struct march *march, int count, void (*task)(void *data, int k), void *data) {
    const struct drape_team *team = march->settings->team;
    if (team)
        team->run(team->context, count, task, data);
    for (int k = 0; !team && k < count; k++)
        task(data, k);
}

/* Where the first march had no node, the largest elsewhere stands for it (`summarise`). */
static void add_estimates(void *data, int k) {
    struct part *part = &((struct part *)data)[k];
    double *to = part->result->nodes.error_estimate + part->next.nodes;
    for (int y = 0; y < NET_TILE; y++)
        for (size_t t = 0; t < part->count; t++) {
            const struct net_tile *tile = part->windows[t].tile[1][1];
            net_view_move(&part->before, tile->ti * NET_TILE, tile->tj * NET_TILE);
            for (uint32_t left = tile->bits[NET_BIT_INSIDE][y]; left; left &= left - 1) {
                const struct net_node *before =
                    net_window_place(&part->before.window, __builtin_ctz(left), y);
                *to = before ? estimate_of(before) : -1;
                part->estimate_max = fmax(part->estimate_max, *to++);
            }
        }
}

/* Takes the estimates from the net that was corrected, and gives its memory back. */
static enum status take_estimates(struct march *march, struct part *parts, int count,
                                  struct drape_nodes *nodes) {
    nodes->error_estimate = arena_take(march->arena, nodes->count, sizeof *nodes->error_estimate);
    if (!nodes->error_estimate)
        return STATUS_OUT_OF_MEMORY;
    run(march, count, add_estimates, parts);
    net_free(march->first);
    march->first = NULL;
    march->before = (struct net_view){.net = NULL};
    return STATUS_OK;
}

enum status report_make(struct march *march, struct drape_result *result) {
    int count;
    *result = (struct drape_result){.start_point = march->start.station.jet.r,
                                    .start_warp = march->start.warp,
                                    .start_weft = march->start.weft,
                                    .summary.error_estimate_max = -1};
    (void)march_parameters(march, &march->start.station, result->start_uv);
    result->start_face = march_face(march, &march->start.station);
    struct part *parts = make_parts(march, result, &count);
    struct tasks tasks = {rim_report_begin(march), parts};
    if (!parts || !tasks.rim)
        return STATUS_OUT_OF_MEMORY;
    run(march, count, count_part, parts);
    place_parts(parts, count, result);
    enum status status =
        march->first ? take_estimates(march, parts, count, &result->nodes) : STATUS_OK;
    if (status == STATUS_OK)
        status = alloc_columns(march->arena, march->surface && march->surface->shell, result);
    if (status != STATUS_OK)
        return status;
    run(march, count + 1, add_part, &tasks);
    gather_parts(parts, count, &result->summary);
    summarise(march, result);
    return rim_report(march, tasks.rim, result);
}
