/* SPDX-License-Identifier: MIT */
#include "report_strip.h"

#include "estimate.h"
#include "shear_error.h"
#include "solver/angle.h"
#include "solver/fishnet/slide_formulas.h"
#include "solver/net/shear.h"
#include "solver/wide.h"

/* The bits of a row of a window that are the tile's own. */
static const uint32_t own_bits = ((1u << NET_TILE) - 1) << 1;

/* Where the normals at a cell's corners differ by more than this, the surface is folded there. */
static const double folded_cosine = 0.5;

/* Own places of row y that are inside, those from which a cell goes on, and those at which the net
 * may end: inside with a neighbour that is not, or the other way round. */
struct row_bits {
    uint32_t inside, cells, rim;
};

static struct yarn_net yarn_net(struct report_strip *strip) {
    return (struct yarn_net){strip->march->net, march_whole(strip->march), &strip->cursor};
}

/* The node at (x, y) of a window, which is kept for the cells and nodes next to it; NULL where
 * there is no tangent plane. */
static struct yarn_spot *yarn_spot_at(struct report_strip *strip, const struct net_window *window,
                                      int x, int y) {
    const struct march *march = strip->march;
    int32_t i = window->tile[1][1]->ti * NET_TILE + x, j = window->tile[1][1]->tj * NET_TILE + y;
    const struct net_node *node = net_window_find(window, x, y);
    struct yarn_spot *spot = &strip->spots[(j & 1) * REPORT_SPOTS + (i & (REPORT_SPOTS - 1))];
    if (spot->filled && spot->i == i && spot->j == j)
        return spot;
    spot->filled = node;
    spot->i = i;
    spot->j = j;
    spot->known = 0;
    if (node && march->mesh) {
        struct mesh_point point = {.triangle = (int32_t)node->uv[0], .r = node->r};
        spot->point = march_mesh_point(march, &point);
    } else if (node) {
        spot->filled =
            surface_point_at(march_surface(march, node), &strip->cursor, node->uv, &spot->point);
    }
    return spot->filled ? spot : NULL;
}

/* The corners of the cell from (x, y) on. */
static bool find_cell_spots(struct report_strip *strip, const struct net_window *window, int x,
                            int y, struct yarn_spot *corner[4]) {
    static const int8_t at[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    for (int k = 0; k < 4; k++)
        if (!(corner[k] = yarn_spot_at(strip, window, x + at[k][0], y + at[k][1])))
            return false;
    return true;
}

/* Whether a cell is cloth: no cut parts its corners, and they turn one way in space, or it is bent
 * over a fold, and open in the surface. */
static bool cell_is_cloth(struct report_strip *strip, const struct net_window *window, int x,
                          int y) {
    const struct net_node *node[4] = {
        net_window_find(window, x, y), net_window_find(window, x + 1, y),
        net_window_find(window, x + 1, y + 1), net_window_find(window, x, y + 1)};
    struct vec3 edge[4], normal = vec3_make(0, 0, 0);
    struct yarn_spot *corner[4];
    bool convex = !net_is_parted(node[0], node[1], 0) && !net_is_parted(node[3], node[2], 0) &&
                  !net_is_parted(node[0], node[3], 1) && !net_is_parted(node[1], node[2], 1);
    bool odd = false;
    for (int k = 0; k < 4; k++)
        odd = odd || node[k]->grown || node[k]->rough;
    if (!convex || !odd)
        return convex;
    double least = 1;
    for (int k = 0; k < 4; k++)
        edge[k] = vec3_sub(node[(k + 1) & 3]->r, node[k]->r);
    for (int k = 0; k < 4; k++)
        normal = vec3_add(normal, vec3_cross(edge[k], edge[(k + 1) & 3]));
    for (int k = 0; k < 4 && convex; k++)
        convex = vec3_dot(vec3_cross(edge[k], edge[(k + 1) & 3]), normal) > 0;
    if (convex || !yarn_cell_is_rough(window, x, y) ||
        !find_cell_spots(strip, window, x, y, corner))
        return convex;
    for (int k = 1; k < 4; k++)
        least = fmin(least, vec3_dot(corner[0]->point.normal, corner[k]->point.normal));
    struct yarn_net net = yarn_net(strip);
    return least < folded_cosine && yarn_cell_is_open(&net, window, x, y, corner);
}

static struct row_bits row_bits(struct report_strip *strip, const struct net_window *window,
                                int y) {
    uint32_t row = net_window_bits(window, NET_BIT_INSIDE, y);
    uint32_t up = net_window_bits(window, NET_BIT_INSIDE, y + 1), both = row & up;
    uint32_t down = net_window_bits(window, NET_BIT_INSIDE, y - 1);
    uint32_t all = up & down & row << 1 & row >> 1, any = up | down | row << 1 | row >> 1;
    struct row_bits bits = {.inside = row & own_bits,
                            .cells = both & both >> 1 & own_bits,
                            .rim = ((row & ~all) | (~row & any)) & own_bits};
    /* Some are no cloth: yarns along free edges may close cells that are not convex, and so may
     * rough ones where the net all but collapses. The march never makes others. */
    uint32_t odd = 0;
    for (int k = y; k <= y + 1; k++)
        odd |=
            net_window_bits(window, NET_BIT_GROWN, k) | net_window_bits(window, NET_BIT_ROUGH, k);
    for (uint32_t left = bits.cells & (odd | odd >> 1); left; left &= left - 1) {
        int bit = __builtin_ctz(left);
        if (!cell_is_cloth(strip, window, bit - 1, y))
            bits.cells &= ~(1u << bit);
    }
    return bits;
}

/* Whether the net ends at the place (x, y) of a window's own tile, and why: for the boundary the
 * last node inside stands for it, for all else the place that has no node. */
static bool ends_at(const struct net_window *window, int x, int y, enum drape_reason *reason) {
    static const int8_t side[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
    const struct net_node *node = &window->tile[1][1]->node[y][x];
    bool own = node->state != NET_INSIDE;
    *reason = own ? (enum drape_reason)node->reason : DRAPE_REASON_BOUNDARY;
    if (own && *reason == DRAPE_REASON_BOUNDARY)
        return false;
    for (int k = 0; k < 4; k++) {
        const struct net_node *next = net_window_find(window, x + side[k][0], y + side[k][1]);
        bool inside = next && next->state == NET_INSIDE;
        if (own ? inside
                : !inside && (!next || next->state == NET_UNKNOWN ||
                              next->reason == DRAPE_REASON_BOUNDARY))
            return true;
    }
    return false;
}

void report_strip_count(void *strips, int number) {
    struct report_strip *strip = &((struct report_strip *)strips)[number];
    for (size_t t = 0; t < strip->count; t++)
        for (int y = 0; y < NET_TILE; y++) {
            struct row_bits bits = row_bits(strip, &strip->windows[t], y);
            strip->holds.nodes += (size_t)__builtin_popcount(bits.inside);
            strip->holds.cells += (size_t)__builtin_popcount(bits.cells);
            for (uint32_t rim = bits.rim; rim; rim &= rim - 1) {
                enum drape_reason reason;
                strip->holds.front +=
                    ends_at(&strip->windows[t], __builtin_ctz(rim) - 1, y, &reason);
            }
        }
}

/* The next of the places `left` and those that follow it without a gap: the first, and how many.
 */
static int next_run(uint32_t *left, int *first) {
    *first = __builtin_ctz(*left);
    int count = __builtin_ctz(~(*left >> *first));
    *left &= ~(((1u << count) - 1) << *first);
    return count;
}

/* What follows is compiled once more for runs of a tile's whole row, which most are. */

INLINE void copy_run(const double *from, int count, double *to) {
    for (int n = 0; n < count; n++)
        to[n] = from[n];
}

INLINE void index_run(int32_t i, int32_t j, int count, int32_t *to_i, int32_t *to_j) {
    for (int n = 0; n < count; n++) {
        to_i[n] = i + n;
        to_j[n] = j;
    }
}

/* Parameters k of nodes of one face as the caller's; false where one of them is not between the
 * ends of an open axis. */
INLINE bool outer_run(const struct surface_axis *axis, int k, const struct net_node *nodes,
                      int count, double *to) {
    double low = surface_axis_lower(axis), high = surface_axis_upper(axis);
    int between = !axis->closed;
    for (int n = 0; n < count; n++)
        between &= (nodes[n].uv[k] > low) & (nodes[n].uv[k] < high);
    if (!between)
        return false;
    for (int n = 0; n < count; n++)
        to[n] = surface_axis_outer_between(axis, nodes[n].uv[k]);
    return true;
}

/* The parameters of nodes from number `at` on, within the domain, and their places: a node that
 * lies outside by rounding, or on a later turn round a closed direction, is brought back. */
static void bring_run_inside(struct report_strip *strip, const struct net_node *nodes, int count,
                             size_t at) {
    struct drape_nodes *to = &strip->result->nodes;
    for (const struct net_node *node = nodes; node < nodes + count; node++, at++) {
        const struct surface *surface = march_surface(strip->march, node);
        struct surface_jet jet = {.r = node->r};
        double uv[2];
        bool moved = false;
        if (strip->march->mesh) {
            struct mesh_point place = {.triangle = (int32_t)node->uv[0], .r = node->r};
            mesh_parameters(strip->march->mesh, &place, uv);
        }
        for (int k = 0; k < 2 && !strip->march->mesh; k++) {
            const struct surface_axis *axis = &surface->axis[k];
            double wrapped = surface_axis_wrap(axis, node->uv[k]);
            double low = surface_axis_lower(axis), high = surface_axis_upper(axis);
            uv[k] = wrapped < low ? low : wrapped > high ? high : wrapped;
            moved = moved || uv[k] != wrapped;
        }
        if (moved)
            surface_jet_at(surface, &strip->cursor, uv[0], uv[1], &jet);
        if (!strip->march->mesh)
            surface_outer(surface, uv, uv);
        to->u[at] = uv[0];
        to->v[at] = uv[1];
        vec3_to_columns(jet.r, to->x, to->y, to->z, at);
    }
}

/* The parameters of nodes of one face, or none, from number `at` on. */
INLINE void add_parameters(struct report_strip *strip, const struct net_node *nodes, int count,
                           size_t at) {
    const struct drape_nodes *to = &strip->result->nodes;
    const struct surface *surface = march_surface(strip->march, nodes);
    if (!surface || !outer_run(&surface->axis[0], 0, nodes, count, to->u + at) ||
        !outer_run(&surface->axis[1], 1, nodes, count, to->v + at))
        bring_run_inside(strip, nodes, count, at);
}

/* `count` nodes of row y of a tile from x on, which are inside. */
INLINE void add_run(struct report_strip *strip, const struct net_tile *tile, int x, int y,
                    int count, const struct shear_block *block, const double *shear_deg) {
    const struct drape_nodes *to = &strip->result->nodes;
    const struct net_node *nodes = &tile->node[y][x];
    const size_t at = strip->next.nodes;
    const unsigned grown = tile->bits[NET_BIT_GROWN][y] >> x;
    uint8_t *to_grown = to->grown + at;
    int32_t *face = to->face ? to->face + at : NULL;
    strip->next.nodes += (size_t)count;
    index_run(tile->ti * NET_TILE + x, tile->tj * NET_TILE + y, count, to->i + at, to->j + at);
    copy_run(shear_places(block, 0, x), count, to->x + at);
    copy_run(shear_places(block, 1, x), count, to->y + at);
    copy_run(shear_places(block, 2, x), count, to->z + at);
    copy_run(shear_deg + x, count, to->shear_deg + at);
    for (int n = 0; n < count; n++)
        to_grown[n] = grown >> n & 1;
    if (!face)
        add_parameters(strip, nodes, count, at);
    for (int n = 0, end; n < count && face; n = end) { /* of one face after the other */
        for (end = n; end < count && nodes[end].face == nodes[n].face; end++)
            face[end] = nodes[end].face;
        add_parameters(strip, nodes + n, end - n, at + (size_t)n);
    }
}

/* The nodes of row y of a tile, those that are `inside`. Returns the places, as bits, whose shear
 * is by the stencil that most have. */
static uint32_t add_nodes(struct report_strip *strip, const struct net_window *window, int y,
                          const struct shear_block *block, uint32_t inside) {
    bool chords = strip->march->method->yarn == DRAPE_YARN_CHORD;
    enum shear_order order = chords ? SHEAR_SECOND : SHEAR_FOURTH;
    struct shear_row yarns;
    double shear_deg[SHEAR_PLACES];
    uint32_t usual = shear_nodes(block, order, &yarns);
    for (uint32_t left = inside >> 1 & ~usual; left; left &= left - 1)
        shear_node(&yarns, window, __builtin_ctz(left), y, order);
    shear_angles(&yarns, shear_deg);
    for (uint32_t left = inside >> 1; left;) {
        int x, count = next_run(&left, &x);
        if (count == NET_TILE)
            add_run(strip, window->tile[1][1], 0, y, NET_TILE, block, shear_deg);
        else
            add_run(strip, window->tile[1][1], x, y, count, block, shear_deg);
    }
    return usual;
}

/* `count` cells from row y of a tile from x on. */
INLINE void add_cell_run(struct report_strip *strip, const struct net_tile *tile, int x, int y,
                         int count, const struct shear_row *yarns, const double *shear_deg) {
    const struct drape_cells *to = &strip->result->cells;
    double *warp[] = {to->warp_x, to->warp_y, to->warp_z};
    double *weft[] = {to->weft_x, to->weft_y, to->weft_z};
    const size_t at = strip->next.cells;
    strip->next.cells += (size_t)count;
    index_run(tile->ti * NET_TILE + x, tile->tj * NET_TILE + y, count, to->i + at, to->j + at);
    copy_run(shear_deg + x, count, to->shear_deg + at);
    for (int k = 0; k < 3; k++) {
        copy_run(yarns->warp[k] + x, count, warp[k] + at);
        copy_run(yarns->weft[k] + x, count, weft[k] + at);
    }
}

/* The cells from row y of a tile, of which some are rough. */
static void add_cells(struct report_strip *strip, const struct net_window *window, int y,
                      const struct shear_block *block, uint32_t cells, uint32_t rough) {
    struct shear_row yarns;
    double shear_deg[SHEAR_PLACES], area[SHEAR_PLACES];
    uint32_t usual = shear_cells(block, &yarns, area) & ~(rough >> 1);
    for (uint32_t left = cells >> 1 & ~usual; left; left &= left - 1) {
        int x = __builtin_ctz(left);
        shear_cell(&yarns, window, x, y, rough >> (x + 1) & 1);
    }
    shear_normalise(&yarns);
    shear_angles(&yarns, shear_deg);
    for (uint32_t left = cells >> 1 & ~(rough >> 1); left; left &= left - 1)
        strip->covered += area[__builtin_ctz(left)];
    for (uint32_t left = cells >> 1; left;) {
        int x, count = next_run(&left, &x);
        if (count == NET_TILE)
            add_cell_run(strip, window->tile[1][1], 0, y, NET_TILE, &yarns, shear_deg);
        else
            add_cell_run(strip, window->tile[1][1], x, y, count, &yarns, shear_deg);
    }
}

/* The nodes and cells of a row that rough edges are near, one after the other, by the angles
 * between their yarns; the first of the row are at `first`. Stencils at the `ends` of yarns reach
 * further: there, as at the lips of cuts, the one direction in which a yarn ends is its own only
 * where yarns do not turn sideways, because the surface has hardly any curvature. */
static void measure_rough(struct report_strip *strip, const struct net_window *window, int y,
                          const struct row_bits *bits, uint32_t ends, uint32_t cells,
                          struct report_tally first) {
    uint32_t near = net_window_near_rough(window, y, SHEAR_REACH) << 1;
    uint32_t far = net_window_near_rough(window, y, SHEAR_REACH_AT_END) << 1;
    const double *d = strip->march->settings->spacing;
    struct drape_cells *c = &strip->result->cells;
    struct yarn_net net = yarn_net(strip);
    for (uint32_t left = bits->inside | bits->cells; left; left &= left - 1) {
        int bit = __builtin_ctz(left), x = bit - 1;
        uint32_t here = bits->inside & 1u << bit & (near | (far & ends));
        struct yarn_spot *own = here ? yarn_spot_at(strip, window, x, y) : NULL;
        bool at_lip = ends >> bit & 1 && net_window_find(window, x, y)->beside;
        if (own && ((here & near && !at_lip) || yarn_is_developable(&own->point, d))) {
            strip->result->nodes.shear_deg[first.nodes] =
                shear_rounded(90 - yarn_node_angle(&net, window, x, y, own));
        }
        if (bits->cells & cells & 1u << bit) {
            /* the directions of a cell by the yarns at its corners, and the area of its fabric */
            size_t at = first.cells;
            struct yarn_spot *corner[4];
            double w = find_cell_spots(strip, window, x, y, corner)
                           ? yarn_cell_angle(&net, window, x, y, corner)
                           : 90 - c->shear_deg[at];
            double sine, cosine;
            struct vec3 warp = {c->warp_x[at], c->warp_y[at], c->warp_z[at]};
            struct vec3 weft = {c->weft_x[at], c->weft_y[at], c->weft_z[at]};
            shear_set_angle(&warp, &weft, w);
            vec3_to_columns(warp, c->warp_x, c->warp_y, c->warp_z, at);
            vec3_to_columns(weft, c->weft_x, c->weft_y, c->weft_z, at);
            c->shear_deg[at] = shear_rounded(90 - w);
            angle_sincos_deg(w, &sine, &cosine);
            double c_slide = strip->march->settings->slide;
            double stretch = c_slide > 0 ? slide_stretch(c_slide, cosine) : 1;
            strip->covered += d[0] * d[1] * fabs(sine) * stretch;
        }
        first.nodes += bits->inside >> bit & 1;
        first.cells += bits->cells >> bit & 1;
    }
}

void report_strip_add(struct report_strip *strip) {
    struct drape_front *front = &strip->result->front;
    bool measured = net_has_rough(strip->march->net);
    for (int y = 0; y < NET_TILE; y++)
        for (size_t t = 0; t < strip->count; t++) {
            const struct net_window *window = &strip->windows[t];
            struct row_bits bits = row_bits(strip, window, y);
            uint32_t rough = 0,
                     usual = 0; /* cells that have a node with a rough edge next to them */
            struct report_tally first = strip->next;
            struct shear_block block;
            if (!(bits.inside | bits.rim))
                continue;
            bool near = measured && net_window_has_rough(window, y, SHEAR_REACH_AT_END);
            if (near) {
                uint32_t low = net_window_near_rough(window, y, 1);
                uint32_t high = net_window_near_rough(window, y + 1, 1);
                rough = (low | low >> 1 | high | high >> 1) << 1;
            }
            shear_load(&block, window, y);
            if (bits.inside)
                usual = add_nodes(strip, window, y, &block, bits.inside);
            if (bits.cells)
                add_cells(strip, window, y, &block, bits.cells, rough);
            for (uint32_t left = bits.rim; left; left &= left - 1) {
                int x = __builtin_ctz(left) - 1;
                enum drape_reason reason;
                if (!ends_at(window, x, y, &reason))
                    continue;
                size_t at = strip->next.front++;
                front->i[at] = window->tile[1][1]->ti * NET_TILE + x;
                front->j[at] = window->tile[1][1]->tj * NET_TILE + y;
                front->reason[at] = (uint8_t)reason;
                strip->reasons[reason]++;
            }
            if (near)
                measure_rough(strip, window, y, &bits, ~usual << 1, rough, first);
        }
}

void report_strip_add_estimates(void *strips, int number) {
    struct report_strip *strip = &((struct report_strip *)strips)[number];
    const struct drape_nodes *nodes = &strip->result->nodes;
    struct defect_net net = {.march = strip->march,
                             .net = net_view(strip->march->net),
                             .spacing = strip->march->settings->spacing};
    size_t row[NET_TILE + 1] = {strip->next.nodes}; /* where each row of the strip begins */
    for (int y = 0; y < NET_TILE; y++) {
        row[y + 1] = row[y];
        for (size_t t = 0; t < strip->count; t++)
            row[y + 1] +=
                (size_t)__builtin_popcount(strip->windows[t].tile[1][1]->bits[NET_BIT_INSIDE][y]);
    }
    for (size_t t = 0; t < strip->count; t++) {
        const struct net_tile *tile = strip->windows[t].tile[1][1];
        double shear_error_deg[NET_TILE][NET_TILE];
        net_view_move(&strip->before, tile->ti * NET_TILE, tile->tj * NET_TILE);
        net_view_move(&net.net, tile->ti * NET_TILE, tile->tj * NET_TILE);
        shear_error_of_tile(&net, &strip->before, shear_error_deg);
        for (int y = 0; y < NET_TILE; y++)
            for (uint32_t left = tile->bits[NET_BIT_INSIDE][y]; left; left &= left - 1) {
                int x = __builtin_ctz(left);
                const struct net_node *before = net_window_place(&strip->before.window, x, y);
                size_t at = row[y]++;
                nodes->error_estimate[at] = before ? estimate_of(before) : -1;
                nodes->shear_error_deg[at] = shear_error_deg[y][x];
                strip->estimate_max = fmax(strip->estimate_max, nodes->error_estimate[at]);
                strip->shear_error_max = fmax(strip->shear_error_max, nodes->shear_error_deg[at]);
            }
    }
}
