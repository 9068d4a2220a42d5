/* SPDX-License-Identifier: MIT */
#include "proposal.h"

#include <math.h>
#include <stdlib.h>

/* ---- the edge of the part ---- */

enum status proposal_edge_make(const struct drape_rim *rim, struct arena *arena,
                               struct proposal_edge *edge) {
    *edge = (struct proposal_edge){.from = arena_alloc(arena, rim->count + 1, sizeof *edge->from),
                                   .to = arena_alloc(arena, rim->count + 1, sizeof *edge->to)};
    if (!edge->from || !edge->to)
        return STATUS_OUT_OF_MEMORY;
    for (size_t k = 0, first = 0; k < rim->count; k++) {
        first = k > 0 && rim->loop[k] == rim->loop[k - 1] ? first : k;
        bool last = k + 1 == rim->count || rim->loop[k + 1] != rim->loop[k];
        size_t next = last ? first : k + 1;
        if (rim->cut && rim->cut[k] != 0)
            continue;
        edge->from[edge->count] = vec3_make(rim->x[k], rim->y[k], rim->z[k]);
        edge->to[edge->count++] = vec3_make(rim->x[next], rim->y[next], rim->z[next]);
    }
    return STATUS_OK;
}

struct vec3 proposal_edge_nearest(const struct proposal_edge *edge, struct vec3 point) {
    struct vec3 nearest = point;
    double least = HUGE_VAL;
    for (size_t k = 0; k < edge->count; k++) {
        struct vec3 along = vec3_sub(edge->to[k], edge->from[k]);
        double share = vec3_dot(vec3_sub(point, edge->from[k]), along) / vec3_norm2(along);
        struct vec3 at = vec3_axpy(share > 0 ? fmin(share, 1) : 0, along, edge->from[k]);
        double distance = vec3_distance(at, point);
        if (!(distance < least))
            continue;
        least = distance;
        nearest = at;
    }
    return nearest;
}

/* Where a walk along the part from the outer end of a ridge, straight on, meets the edge. */
static struct vec3 edge_ahead(const struct study_part *part, const struct proposal_edge *edge,
                              double spacing, const struct study_ridge *ridge) {
    enum { STEPS_MOST = 10000 };
    static const double least = 0.5; /* of a step: less far it comes only beyond the edge */
    struct vec3 way = vec3_sub(ridge->outer, ridge->inner), at = ridge->outer;
    bool on = vec3_norm2(way) > 0;
    for (int k = 0; on && k < STEPS_MOST; k++) {
        struct part_point next;
        double off;
        way = vec3_unit(way);
        study_part_nearest(part, vec3_axpy(spacing, way, at), &next, &off);
        on = vec3_dot(vec3_sub(next.r, at), way) > least * spacing;
        way = on ? vec3_sub(next.r, at) : way;
        at = next.r;
    }
    return proposal_edge_nearest(edge, at);
}

struct study_cut proposal_cut(const struct study_part *part, const struct proposal_edge *edge,
                              double spacing, const struct study_ridge *ridge,
                              enum proposal_mouth mouth) {
    return (struct study_cut){mouth == MOUTH_AHEAD ? edge_ahead(part, edge, spacing, ridge)
                                                   : proposal_edge_nearest(edge, ridge->outer),
                              ridge->inner};
}

/* ---- regions of the net ---- */

/* Nodes no further apart than this, in steps along warp and weft, belong to one region: it goes on
 * over a fold, at which a row or two of nodes may be missing. */
enum { REACH = 2 };

/* The ends of a ridge are the middles of the region's first and last spacing, seen from the edge;
 * and no proposed cut is shorter than so many spacings. */
static const double end_width = 1, shortest = 2;

struct region {
    const struct proposal_case *c;
    uint8_t *beyond; /* of each node: its shear is beyond the limit, and it is in no region yet */
    size_t *node;    /* of the region */
    size_t count;
};

static struct vec3 region_node(const struct region *region, size_t k) {
    const struct drape_nodes *nodes = &region->c->result->nodes;
    return vec3_make(nodes->x[k], nodes->y[k], nodes->z[k]);
}

/* The first node that is not before (i, j): nodes are sorted by j, then i. */
static size_t find_node(const struct drape_nodes *nodes, int32_t i, int32_t j) {
    size_t low = 0, high = nodes->count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        bool before = nodes->j[middle] < j || (nodes->j[middle] == j && nodes->i[middle] < i);
        low = before ? middle + 1 : low;
        high = before ? high : middle;
    }
    return low;
}

/* The nodes beyond the limit that hang together with a first one. */
static void fill_region(struct region *region, size_t first) {
    const struct drape_nodes *nodes = &region->c->result->nodes;
    region->node[0] = first;
    region->count = 1;
    region->beyond[first] = 0;
    for (size_t k = 0; k < region->count; k++) {
        int32_t i = nodes->i[region->node[k]], j = nodes->j[region->node[k]];
        for (int32_t row = j - REACH; row <= j + REACH; row++)
            for (size_t n = find_node(nodes, i - REACH, row);
                 n < nodes->count && nodes->j[n] == row && nodes->i[n] <= i + REACH; n++)
                if (region->beyond[n]) {
                    region->beyond[n] = 0;
                    region->node[region->count++] = n;
                }
    }
}

/* The mean place, by shear, of the region's nodes whose `distance` is within a spacing of `end`. */
static struct vec3 mean_place(const struct region *region, const double *distance, double end) {
    struct vec3 sum = {0, 0, 0};
    double weight = 0;
    for (size_t k = 0; k < region->count; k++) {
        double shear = fabs(region->c->result->nodes.shear_deg[region->node[k]]);
        if (fabs(distance[k] - end) > end_width * region->c->spacing)
            continue;
        sum = vec3_axpy(shear, region_node(region, region->node[k]), sum);
        weight += shear;
    }
    return vec3_scale(1 / weight, sum);
}

/* The ridge of a region: from its end next to an edge to its place that is furthest from there. */
static struct study_ridge find_ridge(const struct region *region, double *distance) {
    const struct proposal_case *c = region->c;
    double least = HUGE_VAL, most = 0;
    for (size_t k = 0; k < region->count; k++) {
        struct vec3 r = region_node(region, region->node[k]);
        distance[k] = vec3_distance(r, proposal_edge_nearest(c->edge, r));
        least = fmin(least, distance[k]);
    }
    struct study_ridge ridge = {.outer = mean_place(region, distance, least)};
    for (size_t k = 0; k < region->count; k++) {
        distance[k] = vec3_distance(region_node(region, region->node[k]), ridge.outer);
        most = fmax(most, distance[k]);
    }
    ridge.inner = mean_place(region, distance, most);
    return ridge;
}

/* Moves the inner end onto the part, and away from the edge if a cut from there is too short. */
static bool settle_ridge(const struct proposal_case *c, struct study_ridge *ridge) {
    struct part_point nearest;
    double off, least = shortest * c->spacing;
    struct vec3 mouth = proposal_edge_nearest(c->edge, ridge->outer);
    struct vec3 way = vec3_sub(ridge->inner, mouth);
    double length = vec3_norm(way);
    if (!(length > 0))
        return false;
    struct vec3 tip = length < least ? vec3_axpy(least / length, way, mouth) : ridge->inner;
    study_part_nearest(c->part, tip, &nearest, &off);
    ridge->inner = nearest.r;
    return vec3_distance(ridge->inner, mouth) >= 0.5 * least;
}

enum status proposal_find(const struct proposal_case *c, struct study_ridge *ridges, size_t most,
                          struct arena *arena, size_t *count) {
    const struct drape_nodes *nodes = &c->result->nodes;
    struct arena_mark mark = arena_mark(arena);
    struct region region = {.c = c,
                            .beyond = arena_alloc(arena, nodes->count + 1, 1),
                            .node = arena_take(arena, nodes->count, sizeof *region.node)};
    double *distance = arena_take(arena, nodes->count, sizeof *distance);
    *count = 0;
    if (!region.beyond || !region.node || !distance)
        return STATUS_OUT_OF_MEMORY;
    for (size_t k = 0; k < nodes->count; k++)
        region.beyond[k] = fabs(nodes->shear_deg[k]) > c->limit_deg;
    while (*count < most) {
        size_t worst = nodes->count;
        for (size_t k = 0; k < nodes->count; k++)
            if (region.beyond[k] && (worst == nodes->count ||
                                     fabs(nodes->shear_deg[k]) > fabs(nodes->shear_deg[worst])))
                worst = k;
        if (worst == nodes->count)
            break;
        fill_region(&region, worst);
        ridges[*count] = find_ridge(&region, distance);
        *count += settle_ridge(c, &ridges[*count]);
    }
    if (*count == 0 && most > 0 && c->bare) { /* it ends without much shear: at a fold, say */
        ridges[0] = (struct study_ridge){c->at, c->at};
        *count += settle_ridge(c, &ridges[0]);
    }
    arena_rewind(arena, mark);
    return STATUS_OK;
}

/* ---- a cut on the part ---- */

struct vec3 proposal_place(const struct study_part *part, const struct study_cut *cut,
                           double share) {
    struct part_point nearest;
    double distance;
    study_part_nearest(part, vec3_axpy(share, vec3_sub(cut->tip, cut->mouth), cut->mouth), &nearest,
                       &distance);
    return nearest.r;
}

/* How far a point lies from the line through two others. */
static double distance_from_chord(struct vec3 point, struct vec3 from, struct vec3 to) {
    struct vec3 way = vec3_unit(vec3_sub(to, from)), off = vec3_sub(point, from);
    return vec3_norm(vec3_axpy(-vec3_dot(off, way), way, off));
}

enum status proposal_line(const struct study_part *part, const struct study_cut *cut,
                          double spacing, struct arena *arena, struct drape_cut_line *line) {
    enum { STEPS_MOST = 400 };
    static const double step = 0.25, straight = 0.01;
    double length = vec3_distance(cut->mouth, cut->tip);
    size_t steps = 1 + (size_t)fmin(length / (step * spacing), STEPS_MOST - 1), kept = 1;
    struct vec3 *path = arena_alloc(arena, steps + 1, sizeof *path);
    if (!path)
        return STATUS_OUT_OF_MEMORY;
    for (size_t k = 0; k <= steps; k++)
        path[k] = k == 0       ? cut->mouth
                  : k == steps ? cut->tip
                               : proposal_place(part, cut, (double)k / (double)steps);
    for (size_t last = 0; last < steps;) { /* as far as all points between lie on the chord */
        size_t next = last + 1;
        for (bool good = true; good && next < steps; next += good)
            for (size_t k = last + 1; k <= next && good; k++)
                good =
                    distance_from_chord(path[k], path[last], path[next + 1]) < straight * spacing;
        last = next;
        path[kept++] = path[last];
    }
    *line = (struct drape_cut_line){path, kept};
    return STATUS_OK;
}
