/* SPDX-License-Identifier: MIT */
/* One cell of the march from three places of the net. */
#include "march.h"

bool march_station(struct march *march, int32_t i, int32_t j, struct station *station) {
    const struct net_node *node = net_place(&march->net, i, j);
    return node && station_at(march->surface, &march->cursor, node->uv, station);
}

static struct vec3 guess(const struct station *a, const struct station *b, const struct station *c,
                         const struct vec3 *last_edge) {
    struct vec3 edge = vec3_sub(b->jet.r, a->jet.r);
    struct vec3 trend = last_edge ? vec3_sub(edge, *last_edge) : vec3_make(0, 0, 0);
    return vec3_add(c->jet.r, vec3_add(edge, trend));
}

bool march_solve_corner(struct march *march, int si, int sj, const struct station *a,
                        const struct station *b, const struct station *c,
                        const struct vec3 *last_edge, struct fishnet_node *node,
                        enum drape_reason *reason) {
    const struct drape_settings *s = march->settings;
    struct fishnet_cell cell = {.a = a, .b = b, .c = c, .orientation = si * sj};
    cell.guess = guess(a, b, c, last_edge);
    fishnet_chords(s->method, s->spacing[0], s->spacing[1], &cell);
    enum fishnet_end end = fishnet_solve(march->surface, &march->cursor, &cell, node);
    if (end == FISHNET_FOUND) {
        march->solved++;
        march->iterations += (size_t)node->iterations;
        march->residual_max = fmax(march->residual_max, node->residual);
        return true;
    }
    *reason = end == FISHNET_COLLAPSED    ? DRAPE_REASON_COLLAPSED
              : end == FISHNET_DEGENERATE ? DRAPE_REASON_DEGENERATE
                                          : DRAPE_REASON_NO_CONVERGENCE;
    return false;
}

enum status march_corner(struct march *march, int32_t i, int32_t j, int si, int sj, bool *placed,
                         enum drape_reason *reason) {
    struct station a, b, c;
    struct fishnet_node node;
    enum station_zone zone;
    *placed = false;
    if (!march_station(march, i - si, j - sj, &a) || !march_station(march, i - si, j, &b) ||
        !march_station(march, i, j - sj, &c)) {
        *reason = DRAPE_REASON_DEGENERATE;
        return STATUS_OK;
    }
    const struct net_node *a2 = net_place(&march->net, i - 2 * si, j - sj);
    const struct net_node *b2 = net_place(&march->net, i - 2 * si, j);
    struct vec3 last = a2 && b2 ? vec3_sub(b2->r, a2->r) : vec3_make(0, 0, 0);
    if (!march_solve_corner(march, si, sj, &a, &b, &c, a2 && b2 ? &last : NULL, &node, reason))
        return STATUS_OK;
    enum status status = march_place(march, i, j, &node.station, &zone);
    *placed = zone != STATION_BEYOND;
    *reason = DRAPE_REASON_BOUNDARY;
    return status;
}
