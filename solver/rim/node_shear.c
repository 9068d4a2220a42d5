/* SPDX-License-Identifier: MIT */
#include "node_shear.h"

#include "solver/fishnet/yarn.h"

/* So many places across are kept at the most: those along the rim of a net of a thousand nodes. */
enum { LEAST_ACROSS = 8, MOST_ACROSS = 32 };

/* The first of the places `low` to the one before `high` of an increasing column whose value is not
 * less; `high` where there is none. */
static size_t first_not_less(const int32_t *column, size_t low, size_t high, int32_t value) {
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        bool less = column[middle] < value;
        low = less ? middle + 1 : low;
        high = less ? high : middle;
    }
    return low;
}

/* Where each row of nodes begins, and the last one ends; NULL without memory. */
static size_t *list_rows(struct arena *arena, const struct drape_nodes *n) {
    int32_t count = n->count ? n->j[n->count - 1] - n->j[0] + 1 : 0;
    size_t *rows = arena_take(arena, (size_t)count + 1, sizeof *rows);
    for (int32_t row = 0; rows && row < count; row++)
        rows[row] = first_not_less(n->j, row ? rows[row - 1] : 0, n->count, n->j[0] + row);
    if (rows)
        rows[count] = n->count;
    return rows;
}

/* Which node (i, j) is, at once where its row has no gap before it; the number of nodes where it is
 * none. */
static size_t node_number(const struct node_shear *shear, int32_t i, int32_t j) {
    const struct drape_nodes *n = shear->nodes;
    if (n->count == 0 || j < n->j[0] || j > n->j[n->count - 1])
        return n->count;
    const size_t *row = &shear->rows[j - n->j[0]];
    if (row[0] == row[1] || i < n->i[row[0]])
        return n->count;
    size_t at = row[0] + (size_t)(i - n->i[row[0]]);
    if (at >= row[1] || n->i[at] != i)
        at = first_not_less(n->i, row[0], at < row[1] ? at : row[1], i);
    return at < row[1] && n->i[at] == i ? at : n->count;
}

enum status node_shear_make(struct march *march, const struct drape_nodes *nodes,
                            struct node_shear *shear) {
    int32_t across = LEAST_ACROSS;
    while (across < MOST_ACROSS && (size_t)(across * across) < 2 * nodes->count)
        across *= 2;
    *shear = (struct node_shear){
        .march = march,
        .nodes = nodes,
        .view = net_view(march->net),
        .places = arena_alloc(march->arena, (size_t)(across * across), sizeof *shear->places),
        .across = across,
        .rows = list_rows(march->arena, nodes),
        .rough = net_has_rough(march->net),
        .order = march->method->yarn == DRAPE_YARN_CHORD ? SHEAR_SECOND : SHEAR_FOURTH};
    return shear->places && shear->rows ? STATUS_OK : STATUS_OUT_OF_MEMORY;
}

/* The angle between the yarns of a ghost in the surface. On a shell its neighbours, as far as it
 * has them, have to lie on its own face: what goes on beyond the end of a joint is on neither of
 * two faces. */
static bool measure_yarns(struct node_shear *shear, struct node_shear_place *ghost, int x, int y) {
    static const int8_t sides[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
    struct march *march = shear->march;
    const struct net_window *window = &shear->view.window;
    struct yarn_spot spot = {.filled = true};
    struct yarn_net net = {march->net, march->surface, &march->cursor};
    if (march->mesh || !march_point(march, ghost->i, ghost->j, &spot.point))
        return false;
    for (int k = 0; k < 4 && march->surface->shell; k++) {
        const struct net_node *node = net_window_place(window, x + sides[k][0], y + sides[k][1]);
        if (node && node->face != spot.point.surface->face)
            return false;
    }
    ghost->shear_deg = shear_rounded(90 - yarn_node_angle(&net, window, x, y, &spot));
    for (int k = 0; k < 2; k++)
        if (!(vec3_norm2(vec3_add(spot.onward[k][0], spot.onward[k][1])) > 0))
            return false;
    return true;
}

/* Whether a ghost is measured between its yarns, as nodes are: near rough edges and, where the
 * surface is developable, where stencils at the ends of yarns would reach them. */
static bool is_by_yarns(struct node_shear *shear, const struct node_shear_place *ghost, int x,
                        int y) {
    struct march *march = shear->march;
    struct surface_point point;
    if (ghost->rough || !shear->rough || march->mesh)
        return ghost->rough;
    return net_window_near_rough(&shear->view.window, y, SHEAR_REACH_AT_END) >> x & 1 &&
           march_point(march, ghost->i, ghost->j, &point) &&
           yarn_is_developable(&point, march->settings->spacing);
}

static bool measure_ghost(struct node_shear *shear, struct node_shear_place *ghost, int x, int y) {
    const struct net_window *window = &shear->view.window;
    const struct net_node *node = net_window_place(window, x, y);
    struct shear_row row;
    struct vec3 along[2];
    if (!node)
        return false;
    ghost->grown = node->grown;
    if (is_by_yarns(shear, ghost, x, y))
        return measure_yarns(shear, ghost, x, y);
    shear_node(&row, window, x, y, shear->order);
    along[0] = vec3_make(row.warp[0][x], row.warp[1][x], row.warp[2][x]);
    along[1] = vec3_make(row.weft[0][x], row.weft[1][x], row.weft[2][x]);
    ghost->shear_deg = shear_between_deg(along);
    return vec3_norm2(along[0]) > 0 && vec3_norm2(along[1]) > 0;
}

/* Node or ghost (i, j). */
static const struct node_shear_place *find_place(struct node_shear *shear, int32_t i, int32_t j) {
    const struct drape_nodes *n = shear->nodes;
    int32_t wrap = shear->across - 1;
    struct node_shear_place *place = &shear->places[(j & wrap) * shear->across + (i & wrap)];
    if (place->searched && place->i == i && place->j == j)
        return place;
    *place = (struct node_shear_place){.i = i, .j = j, .searched = true, .error_deg = -1};
    net_view_move(&shear->view, i, j);
    int x = i - shear->view.ti * NET_TILE, y = j - shear->view.tj * NET_TILE;
    place->rough =
        shear->rough && net_window_near_rough(&shear->view.window, y, SHEAR_REACH) >> x & 1;
    size_t number = node_number(shear, i, j);
    place->known = number < n->count;
    if (place->known) {
        place->shear_deg = n->shear_deg[number];
        place->error_deg = n->shear_error_deg ? n->shear_error_deg[number] : -1;
        place->grown = n->grown[number];
    } else {
        place->known = measure_ghost(shear, place, x, y);
    }
    return place;
}

/* The places that shear is found between in the cell (i, j). Along the rim cells are looked at
 * again and again in turn with those beside them. */
static const struct node_shear_cell *load_cell(struct node_shear *shear, int32_t i, int32_t j) {
    struct node_shear_cell *cell = &shear->cell[(i & 1) + 2 * (j & 1)];
    if (cell->loaded && cell->i == i && cell->j == j)
        return cell;
    *cell = (struct node_shear_cell){.i = i, .j = j, .loaded = true, .cubic = true};
    for (int b = 0; b < 4 && cell->cubic; b++)
        for (int a = 0; a < 4 && cell->cubic; a++) {
            const struct node_shear_place *place = find_place(shear, i + a - 1, j + b - 1);
            cell->cubic = place->known && !place->rough;
            cell->shear_deg[b][a] = place->shear_deg;
        }
    for (int k = 0; k < 4; k++) {
        int a = 1 + (k & 1), b = 1 + k / 2;
        const struct node_shear_place *place = find_place(shear, i + a - 1, j + b - 1);
        cell->shear_deg[b][a] = place->shear_deg;
        cell->known[k] = place->known;
        cell->grown = cell->grown || place->grown;
    }
    return cell;
}

/* By all of the four by four nodes and ghosts around. */
static double cubic_between(const struct node_shear_cell *cell, double x, double y) {
    double fp[4], fq[4], unused[4], sum = 0;
    rim_cloth_cubics(x, fp, unused);
    rim_cloth_cubics(y, fq, unused);
    for (int b = 0; b < 4; b++)
        for (int a = 0; a < 4; a++)
            sum += fp[a] * fq[b] * cell->shear_deg[b][a];
    return sum;
}

bool node_shear_between(struct node_shear *shear, double p, double q, double *shear_deg,
                        bool *grown) {
    double x = p - floor(p), y = q - floor(q), weights = 0, sum = 0;
    const struct node_shear_cell *cell = load_cell(shear, (int32_t)floor(p), (int32_t)floor(q));
    if (grown)
        *grown = cell->grown;
    for (int k = 0; k < 4; k++) {
        double weight = (k & 1 ? x : 1 - x) * (k / 2 ? y : 1 - y);
        if (!cell->known[k])
            continue;
        sum += weight * cell->shear_deg[1 + k / 2][1 + (k & 1)];
        weights += weight;
    }
    *shear_deg = cell->cubic ? cubic_between(cell, x, y) : weights > 0 ? sum / weights : 0;
    return weights > 0;
}

/* Beyond the nodes differences reach to one side alone; what cubics may miss of the bend of the
 * shear over a cell, and of its step over one where there are none; and how far lines along the rim
 * may lie beside it, in spacings (`drape_rim`). */
static const double beyond_share = 3, bend_share = 0.05, corner_share = 0.1, rim_share = 1e-3;

/* By how much the parabola through three values passes the middle one, if that is the greatest. */
static double parabola_top(double before, double middle, double after) {
    double bend = 2 * middle - before - after, step = after - before;
    return before <= middle && after <= middle && bend > 0 ? step * step / (8 * bend) : 0;
}

static double shear_size_at(struct node_shear *shear, int32_t i, int32_t j, double none) {
    const struct node_shear_place *place = find_place(shear, i, j);
    return place->known ? fabs(place->shear_deg) : none;
}

/* What the shear between the nodes of a cell is wrong by, other than by their own errors. */
static double between_error(const struct node_shear_cell *cell) {
    double bend = 0, low = HUGE_VAL, high = -HUGE_VAL;
    for (int k = 0; k < 4; k++) {
        const double *row = cell->shear_deg[k];
        if (cell->cubic)
            bend = fmax(bend, fmax(fabs(row[0] - row[1] - row[2] + row[3]),
                                   fabs(cell->shear_deg[0][k] - cell->shear_deg[1][k] -
                                        cell->shear_deg[2][k] + cell->shear_deg[3][k])));
        double corner = cell->shear_deg[1 + k / 2][1 + (k & 1)];
        low = cell->known[k] ? fmin(low, corner) : low;
        high = cell->known[k] ? fmax(high, corner) : high;
    }
    double step = fmax(high - low, 0);
    return cell->cubic ? bend_share * bend + rim_share * step : corner_share * step;
}

double node_shear_error(struct node_shear *shear, double p, double q) {
    int32_t i = (int32_t)floor(p), j = (int32_t)floor(q);
    const struct node_shear_place *node = find_place(shear, i, j);
    double error = node->error_deg, own = fabs(node->shear_deg), most = 0;
    if (p == i && q == j && error >= 0) {
        for (int k = 0; k < 2; k++)
            error += parabola_top(shear_size_at(shear, i - (k == 0), j - (k == 1), own), own,
                                  shear_size_at(shear, i + (k == 0), j + (k == 1), own));
        return error;
    }
    for (int k = 0; k < 16; k++)
        most = fmax(most, find_place(shear, i + k % 4 - 1, j + k / 4 - 1)->error_deg);
    return beyond_share * most + between_error(load_cell(shear, i, j));
}
