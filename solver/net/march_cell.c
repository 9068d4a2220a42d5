/* SPDX-License-Identifier: MIT */
/* One cell of the march from three places of the net. */
#include "march.h"

#include "correction.h"
#include "fishnet_geodesic.h"
#include <string.h>

bool march_station_at(struct march *march, const struct net_node *node, struct station *station) {
    if (!march->mesh)
        return station_at(march->surface, &march->cursor, node->uv, station);
    struct mesh_place place = {.triangle = (int32_t)node->uv[0], .r = node->r};
    *station = march_mesh_station(march->mesh, &place);
    return true;
}

bool march_station(struct march *march, int32_t i, int32_t j, struct station *station) {
    const struct net_node *node = net_place(march->net, i, j);
    return node && march_station_at(march, node, station);
}

/* C + AB, and the change from AB to CD. */
static struct vec3 guess(const struct march_cell *at) {
    struct vec3 edge = vec3_sub(at->b->jet.r, at->a->jet.r);
    return vec3_add(at->c->jet.r, vec3_add(edge, at->trend));
}

/* D of the net before, moved as the other corners have moved since. */
static bool guess_from_before(const struct march *march, const struct march_cell *at,
                              double uv[2]) {
    const struct net_view *before = &march->before;
    const struct net_node *a = net_view_place(before, at->i - at->si, at->j - at->sj);
    const struct net_node *b = net_view_place(before, at->i - at->si, at->j);
    const struct net_node *c = net_view_place(before, at->i, at->j - at->sj);
    const struct net_node *d = net_view_place(before, at->i, at->j);
    for (int k = 0; a && b && c && d && k < 2; k++)
        uv[k] = d->uv[k] + (at->b->uv[k] - b->uv[k]) + (at->c->uv[k] - c->uv[k]) -
                (at->a->uv[k] - a->uv[k]);
    return a && b && c && d;
}

/* The chords of a cell: by its edges BD and CD in the net before, where they can be had. */
static void find_chords(struct march *march, const struct march_cell *at,
                        struct fishnet_cell *cell) {
    const struct drape_settings *s = march->settings;
    const double *d = s->spacing;
    double bd, cd;
    bool by_bd = march->before.net &&
                 correction_chord(&march->before, at->i - at->si, at->j, at->si, 0, d[0], &bd);
    bool by_cd = march->before.net &&
                 correction_chord(&march->before, at->i, at->j - at->sj, 0, at->sj, d[1], &cd);
    if (!by_bd || !by_cd)
        fishnet_chords(march->surface, &march->cursor, s->method, s->yarn_path, d, cell);
    cell->bd = by_bd ? bd : cell->bd;
    cell->cd = by_cd ? cd : cell->cd;
}

/* Whether (u, v) is not inside the open boundaries; on them neither. */
static bool is_outside(const struct surface *surface, const double uv[2]) {
    for (int k = 0; k < 2; k++) {
        const struct surface_axis *axis = &surface->axis[k];
        if (!axis->closed &&
            !(uv[k] > surface_axis_lower(axis) && uv[k] < surface_axis_upper(axis)))
            return true;
    }
    return false;
}

/* Whether the place expected of D lies beyond the boundary: so its parameters, or what of the
 * surface is nearest to it. Beyond a corner at which r_u and r_v are parallel no parameters lead.
 */
static bool expected_outside(struct march *march, const struct fishnet_cell *cell) {
    double uv[2];
    struct vec3 step = vec3_sub(cell->guess, cell->c->jet.r);
    if (station_pull(march->surface, &march->cursor, cell->c, step, uv) &&
        is_outside(march->surface, uv))
        return true;
    memcpy(uv, cell->c->uv, sizeof uv);
    (void)surface_nearest_from(march->surface, cell->guess, uv);
    return is_outside(march->surface, uv);
}

/* Why a cell has no fourth corner. One that is expected beyond the boundary, and not to be found on
 * the continuation, is a matter of the boundary. */
static enum drape_reason reason_of(struct march *march, const struct fishnet_cell *cell,
                                   enum fishnet_end end) {
    if (end == FISHNET_COLLAPSED)
        return DRAPE_REASON_COLLAPSED;
    if (expected_outside(march, cell))
        return DRAPE_REASON_BOUNDARY;
    return end == FISHNET_DEGENERATE ? DRAPE_REASON_DEGENERATE : DRAPE_REASON_NO_CONVERGENCE;
}

static bool solve_on_surface(struct march *march, const struct march_cell *at,
                             struct fishnet_node *node, enum drape_reason *reason) {
    const struct drape_settings *s = march->settings;
    struct fishnet_cell cell = {.a = at->a, .b = at->b, .c = at->c, .orientation = at->si * at->sj};
    double uv[2];
    cell.guess = guess(at);
    cell.guess_uv = at->guess_uv;
    if (march->before.net) {
        net_view_move(&march->before, at->i, at->j);
        if (guess_from_before(march, at, uv))
            cell.guess_uv = uv;
    }
    find_chords(march, at, &cell);
    enum fishnet_end end = fishnet_solve(march->surface, &march->cursor, &cell, node);
    if (end == FISHNET_FOUND && s->method == DRAPE_GEODESIC)
        end = fishnet_geodesic_solve(march->surface, &march->cursor, &cell, s->spacing[0],
                                     s->spacing[1], node);
    if (end != FISHNET_FOUND)
        *reason = reason_of(march, &cell, end);
    return end == FISHNET_FOUND;
}

bool march_solve_corner(struct march *march, const struct march_cell *at, struct fishnet_node *node,
                        enum drape_reason *reason) {
    bool found = march->mesh ? march_mesh_corner(march, at, guess(at), node, reason)
                             : solve_on_surface(march, at, node, reason);
    if (found) {
        march->solved++;
        march->iterations += (size_t)node->iterations;
        march->residual_max =
            node->residual > march->residual_max ? node->residual : march->residual_max;
    }
    return found;
}

enum status march_corner(struct march *march, int32_t i, int32_t j, int si, int sj, bool *placed,
                         enum drape_reason *reason) {
    struct station a, b, c;
    struct march_cell cell = {i, j, si, sj, &a, &b, &c, {0, 0, 0}, NULL};
    struct fishnet_node node;
    enum station_zone zone;
    *placed = false;
    if (!march_station(march, i - si, j - sj, &a) || !march_station(march, i - si, j, &b) ||
        !march_station(march, i, j - sj, &c)) {
        *reason = DRAPE_REASON_DEGENERATE;
        return STATUS_OK;
    }
    const struct net_node *a2 = net_place(march->net, i - 2 * si, j - sj);
    const struct net_node *b2 = net_place(march->net, i - 2 * si, j);
    if (a2 && b2)
        cell.trend = vec3_sub(vec3_sub(b.jet.r, a.jet.r), vec3_sub(b2->r, a2->r));
    if (!march_solve_corner(march, &cell, &node, reason))
        return STATUS_OK;
    enum status status = march_place(march, i, j, &node.station, &zone);
    *placed = zone != STATION_BEYOND;
    *reason = DRAPE_REASON_BOUNDARY;
    return status;
}
