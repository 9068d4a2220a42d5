/* SPDX-License-Identifier: MIT */
#include "arrangement.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Ends this near, as a share of all, are one; beside a segment is so many times further. */
static const double same = 1e-9, beside = 4;

/* A place that a segment passes: one of its ends, or where another meets it. */
struct pass {
    size_t segment, node;
    double share, at[2];
};

/* Half-edges 2 e and 2 e + 1 run along edge e, there and back. */
struct half {
    size_t from;
    double angle;
    int32_t number;
};

struct arrangement {
    struct arena *arena;
    double reach;
    double (*nodes)[2];
    size_t node_count;
    struct half *halves;
    size_t half_count;
    size_t *first, *outgoing; /* of each node its half-edges, counter-clockwise */
    size_t *place;            /* of each half-edge in `outgoing` */
};

bool segments_add(struct segments *s, const double from[2], const double to[2], int32_t number) {
    if (s->count == s->room) {
        void *larger = arena_enlarge(s->arena, s->list, s->count, sizeof *s->list, &s->room);
        if (!larger)
            return false;
        s->list = larger;
    }
    s->list[s->count++] = (struct segment){{from[0], from[1]}, {to[0], to[1]}, number};
    return true;
}

bool segments_add_polygons(struct segments *s, const struct polygons *polygons, int32_t number) {
    const struct polygons_point *p = polygons->points;
    bool good = true;
    for (size_t k = 0, first = 0; k < polygons->count && good; k++) {
        const struct polygons_point *next = &p[p[k].last ? first : k + 1];
        const double from[2] = {p[k].x, p[k].y}, to[2] = {next->x, next->y};
        good = segments_add(s, from, to, number);
        first = p[k].last ? k + 1 : first;
    }
    return good;
}

/* ---- where segments meet ---- */

struct meeting {
    const struct segment *list;
    struct pass *passes;
    size_t count, room;
    double reach;
    struct arena *arena;
};

static bool add_pass(struct meeting *m, size_t segment, double share) {
    const struct segment *s = &m->list[segment];
    if (m->count == m->room) {
        void *larger = arena_enlarge(m->arena, m->passes, m->count, sizeof *m->passes, &m->room);
        if (!larger)
            return false;
        m->passes = larger;
    }
    share = share < 0 ? 0 : fmin(share, 1);
    struct pass *pass = &m->passes[m->count++];
    *pass = (struct pass){.segment = segment, .share = share};
    for (int k = 0; k < 2; k++)
        pass->at[k] = share < 1 ? s->from[k] + share * (s->to[k] - s->from[k]) : s->to[k];
    return true;
}

/* Where a and b cross, or an end of one is on the other: both pass the place there. With the
 * directions d and e, from_a + t d = from_b + s e. */
static bool meet(struct meeting *m, size_t a, size_t b) {
    const struct segment *x = &m->list[a], *y = &m->list[b];
    double d[2] = {x->to[0] - x->from[0], x->to[1] - x->from[1]};
    double e[2] = {y->to[0] - y->from[0], y->to[1] - y->from[1]};
    double w[2] = {y->from[0] - x->from[0], y->from[1] - x->from[1]};
    double d2 = d[0] * d[0] + d[1] * d[1], e2 = e[0] * e[0] + e[1] * e[1];
    double determinant = d[0] * e[1] - d[1] * e[0];
    double slack_d = m->reach / sqrt(d2), slack_e = m->reach / sqrt(e2);
    if (fabs(determinant) > same * sqrt(d2 * e2)) {
        double t = (w[0] * e[1] - w[1] * e[0]) / determinant;
        double s = (w[0] * d[1] - w[1] * d[0]) / determinant;
        bool both = t >= -slack_d && t <= 1 + slack_d && s >= -slack_e && s <= 1 + slack_e;
        return !both || (add_pass(m, a, t) && add_pass(m, b, s));
    }
    for (int k = 0; k < 4; k++) { /* along each other: at the ends of one that lie on the other */
        const double *end = k == 0 ? y->from : k == 1 ? y->to : k == 2 ? x->from : x->to;
        const double *from = k < 2 ? x->from : y->from, *along = k < 2 ? d : e;
        double v[2] = {end[0] - from[0], end[1] - from[1]}, l2 = k < 2 ? d2 : e2;
        double t = (v[0] * along[0] + v[1] * along[1]) / l2;
        double off = fabs(v[0] * along[1] - v[1] * along[0]) / sqrt(l2);
        if (off <= m->reach && t > 0 && t < 1 && !add_pass(m, k < 2 ? a : b, t))
            return false;
    }
    return true;
}

struct span {
    double low[2], high[2];
    size_t segment;
};

static int compare_spans(const void *a, const void *b) {
    const struct span *x = a, *y = b;
    return (x->low[0] > y->low[0]) - (x->low[0] < y->low[0]);
}

/* All places that segments pass, by a sweep over their boxes. */
static bool find_meetings(struct meeting *m, size_t count) {
    struct span *spans = arena_take(m->arena, count, sizeof *spans);
    for (size_t k = 0; spans && k < count; k++) {
        const struct segment *s = &m->list[k];
        for (int x = 0; x < 2; x++) {
            spans[k].low[x] = fmin(s->from[x], s->to[x]) - m->reach;
            spans[k].high[x] = fmax(s->from[x], s->to[x]) + m->reach;
        }
        spans[k].segment = k;
        if (!add_pass(m, k, 0) || !add_pass(m, k, 1))
            return false;
    }
    if (!spans)
        return false;
    qsort(spans, count, sizeof *spans, compare_spans);
    for (size_t k = 0; k < count; k++)
        for (size_t n = k + 1; n < count && spans[n].low[0] <= spans[k].high[0]; n++)
            if (spans[n].low[1] <= spans[k].high[1] && spans[k].low[1] <= spans[n].high[1] &&
                !meet(m, spans[k].segment, spans[n].segment))
                return false;
    return true;
}

/* ---- nodes and edges ---- */

static int compare_pass_places(const void *a, const void *b) {
    const struct pass *x = a, *y = b;
    return (x->at[0] > y->at[0]) - (x->at[0] < y->at[0]);
}

static int compare_passes(const void *a, const void *b) {
    const struct pass *x = a, *y = b;
    if (x->segment != y->segment)
        return x->segment < y->segment ? -1 : 1;
    return (x->share > y->share) - (x->share < y->share);
}

/* Makes one node of the passes that are within reach of each other. */
static bool name_nodes(struct arrangement *a, struct meeting *m) {
    a->nodes = arena_take(a->arena, m->count, sizeof *a->nodes);
    size_t begin = 0; /* nodes before it are too far to the left */
    qsort(m->passes, m->count, sizeof *m->passes, compare_pass_places);
    for (size_t k = 0; a->nodes && k < m->count; k++) {
        struct pass *pass = &m->passes[k];
        while (begin < a->node_count && a->nodes[begin][0] < pass->at[0] - m->reach)
            begin++;
        for (pass->node = begin; pass->node < a->node_count; pass->node++)
            if (fabs(a->nodes[pass->node][0] - pass->at[0]) <= m->reach &&
                fabs(a->nodes[pass->node][1] - pass->at[1]) <= m->reach)
                break;
        if (pass->node == a->node_count)
            memcpy(a->nodes[a->node_count++], pass->at, sizeof pass->at);
    }
    return a->nodes;
}

struct edge {
    size_t low, high, order;
    int32_t number;
};

static int compare_edges(const void *a, const void *b) {
    const struct edge *x = a, *y = b;
    if (x->low != y->low)
        return x->low < y->low ? -1 : 1;
    if (x->high != y->high)
        return x->high < y->high ? -1 : 1;
    return (x->order > y->order) - (x->order < y->order);
}

/* Drops edges with an end that nothing else comes to, until there is none. */
static size_t prune(struct edge *edges, size_t count, size_t *degree) {
    for (size_t before = count + 1; count < before;) {
        size_t kept = 0;
        before = count;
        for (size_t k = 0; k < count; k++) {
            if (degree[edges[k].low] > 1 && degree[edges[k].high] > 1) {
                edges[kept++] = edges[k];
                continue;
            }
            degree[edges[k].low]--;
            degree[edges[k].high]--;
        }
        count = kept;
    }
    return count;
}

static struct edge *find_split_edges(const struct arrangement *a, struct meeting *m,
                                     size_t *count) {
    struct edge *edges = arena_take(a->arena, m->count, sizeof *edges);
    size_t *degree = arena_alloc(a->arena, a->node_count, sizeof *degree), kept = 0;
    *count = 0;
    if (!edges || !degree)
        return NULL;
    qsort(m->passes, m->count, sizeof *m->passes, compare_passes);
    for (size_t k = 1; k < m->count; k++) {
        const struct pass *from = &m->passes[k - 1], *to = &m->passes[k];
        if (from->segment == to->segment && from->node != to->node)
            edges[(*count)++] = (struct edge){.low = from->node < to->node ? from->node : to->node,
                                              .high = from->node < to->node ? to->node : from->node,
                                              .order = from->segment,
                                              .number = m->list[from->segment].number};
    }
    qsort(edges, *count, sizeof *edges, compare_edges);
    for (size_t k = 0; k < *count; k++)
        if (kept == 0 || edges[kept - 1].low != edges[k].low ||
            edges[kept - 1].high != edges[k].high)
            edges[kept++] = edges[k];
    for (size_t k = 0; k < kept; k++) {
        degree[edges[k].low]++;
        degree[edges[k].high]++;
    }
    *count = prune(edges, kept, degree);
    return edges;
}

/* ---- half-edges ---- */

struct direction {
    double angle;
    size_t half;
};

static int compare_directions(const void *a, const void *b) {
    const struct direction *x = a, *y = b;
    return (x->angle > y->angle) - (x->angle < y->angle);
}

static bool sort_halves(struct arrangement *a, const struct edge *edges, size_t count) {
    a->half_count = 2 * count;
    a->halves = arena_take(a->arena, a->half_count, sizeof *a->halves);
    a->first = arena_alloc(a->arena, a->node_count + 2, sizeof *a->first);
    a->outgoing = arena_take(a->arena, a->half_count, sizeof *a->outgoing);
    a->place = arena_take(a->arena, a->half_count, sizeof *a->place);
    struct direction *directions = arena_take(a->arena, a->half_count, sizeof *directions);
    if (!a->halves || !a->first || !a->outgoing || !a->place || !directions)
        return false;
    for (size_t h = 0; h < a->half_count; h++) {
        const struct edge *edge = &edges[h / 2];
        size_t from = h % 2 ? edge->high : edge->low, to = h % 2 ? edge->low : edge->high;
        const double *p = a->nodes[from], *q = a->nodes[to];
        a->halves[h] = (struct half){from, atan2(q[1] - p[1], q[0] - p[0]), edge->number};
        a->first[from + 2]++;
    }
    for (size_t n = 0; n < a->node_count; n++)
        a->first[n + 2] += a->first[n + 1];
    for (size_t h = 0; h < a->half_count; h++)
        directions[a->first[a->halves[h].from + 1]++] = (struct direction){a->halves[h].angle, h};
    for (size_t n = 0; n < a->node_count; n++)
        qsort(directions + a->first[n], a->first[n + 1] - a->first[n], sizeof *directions,
              compare_directions);
    for (size_t k = 0; k < a->half_count; k++) {
        a->outgoing[k] = directions[k].half;
        a->place[directions[k].half] = k;
    }
    return true;
}

struct arrangement *arrangement_make(const struct segments *segments, struct arena *arena) {
    struct arrangement *a = arena_alloc(arena, 1, sizeof *a);
    double low[2] = {HUGE_VAL, HUGE_VAL}, high[2] = {-HUGE_VAL, -HUGE_VAL};
    struct meeting m = {.list = segments->list, .arena = arena};
    size_t count = 0;
    for (size_t k = 0; k < segments->count; k++)
        for (int x = 0; x < 2; x++) {
            const struct segment *s = &segments->list[k];
            low[x] = fmin(low[x], fmin(s->from[x], s->to[x]));
            high[x] = fmax(high[x], fmax(s->from[x], s->to[x]));
        }
    if (!a)
        return NULL;
    a->arena = arena;
    if (segments->count)
        a->reach = m.reach = same * hypot(high[0] - low[0], high[1] - low[1]);
    if (!find_meetings(&m, segments->count) || !name_nodes(a, &m))
        return NULL;
    struct edge *edges = find_split_edges(a, &m, &count);
    return edges && sort_halves(a, edges, count) ? a : NULL;
}

/* ---- faces ---- */

/* The half-edge that follows one round the face on its left, of those that are `kept` (NULL: all):
 * the first clockwise from the way back. */
static size_t next_half(const struct arrangement *a, size_t half, const bool *kept) {
    size_t back = half ^ 1, node = a->halves[back].from, at = a->place[back];
    do
        at = (at == a->first[node] ? a->first[node + 1] : at) - 1;
    while (kept && !kept[a->outgoing[at]] && a->outgoing[at] != back);
    return a->outgoing[at];
}

/* A loop of half-edges: what it encloses on its left, below 0 round the outside of what hangs
 * together. */
struct ring {
    size_t begin;
    double area;
};

/* Whether an odd number of the loop's edges is to the left of a place. */
static bool ring_contains(const struct arrangement *a, const struct ring *ring,
                          const double at[2]) {
    bool inside = false;
    size_t h = ring->begin;
    do {
        const double *p = a->nodes[a->halves[h].from], *q = a->nodes[a->halves[h ^ 1].from];
        if ((p[1] <= at[1]) != (q[1] <= at[1]) &&
            p[0] + (at[1] - p[1]) / (q[1] - p[1]) * (q[0] - p[0]) <= at[0])
            inside = !inside;
        h = next_half(a, h, NULL);
    } while (h != ring->begin);
    return inside;
}

/* The loops of all faces, and of each half-edge the number of its own. */
static struct ring *find_rings(const struct arrangement *a, size_t *count, size_t **ring_of) {
    struct ring *rings = arena_take(a->arena, a->half_count, sizeof *rings);
    bool *seen = arena_alloc(a->arena, a->half_count, sizeof *seen);
    *ring_of = arena_take(a->arena, a->half_count, sizeof **ring_of);
    *count = 0;
    for (size_t k = 0; rings && seen && *ring_of && k < a->half_count; k++) {
        double area = 0;
        for (size_t h = k; !seen[h]; h = next_half(a, h, NULL)) {
            const double *p = a->nodes[a->halves[h].from], *q = a->nodes[a->halves[h ^ 1].from];
            const double *o = a->nodes[a->halves[k].from];
            area += ((p[0] - o[0]) * (q[1] - o[1]) - (q[0] - o[0]) * (p[1] - o[1])) / 2;
            seen[h] = true;
            (*ring_of)[h] = *count;
            if (next_half(a, h, NULL) == k)
                rings[(*count)++] = (struct ring){k, area};
        }
    }
    return seen && *ring_of ? rings : NULL;
}

/* The smallest loop round a place that encloses something, but those of `without`, by their
 * hanging together; `count` where there is none. */
static size_t ring_round(const struct arrangement *a, const struct ring *rings, size_t count,
                         const double at[2], const size_t *part, size_t without) {
    size_t found = count;
    for (size_t k = 0; k < count; k++)
        if (rings[k].area > 0 && part[a->halves[rings[k].begin].from] != without &&
            (found == count || rings[k].area < rings[found].area) &&
            ring_contains(a, &rings[k], at))
            found = k;
    return found;
}

/* Of each node the least one that it hangs together with. */
static size_t *find_parts(const struct arrangement *a) {
    size_t *part = arena_take(a->arena, a->node_count, sizeof *part);
    for (size_t n = 0; part && n < a->node_count; n++)
        part[n] = n;
    for (bool changed = part != NULL; changed;) {
        changed = false;
        for (size_t h = 0; h < a->half_count; h++) {
            size_t *from = &part[a->halves[h].from], *to = &part[a->halves[h ^ 1].from];
            changed = changed || *from != *to;
            *from = *to = *from < *to ? *from : *to;
        }
    }
    return part;
}

/* Adds the loop of a half-edge, and notes its half-edges as used (may be NULL). */
static bool add_ring(const struct arrangement *a, size_t begin, const bool *kept, bool *used,
                     struct polygons *polygons, int32_t *numbers) {
    size_t h = begin;
    bool good = true;
    do {
        const double *at = a->nodes[a->halves[h].from];
        if (numbers)
            numbers[polygons->count] = a->halves[h].number;
        if (used)
            used[h] = true;
        good = polygons_add(polygons, at[0], at[1]);
        h = next_half(a, h, kept);
    } while (good && h != begin && !(used && (used[h] || !kept[h])));
    polygons_close(polygons);
    return good;
}

bool arrangement_face(const struct arrangement *a, const double at[2], struct polygons *face,
                      int32_t **numbers) {
    size_t count, *ring_of, *part = find_parts(a), none = a->node_count;
    struct ring *rings = find_rings(a, &count, &ring_of);
    *numbers = arena_take(a->arena, a->half_count + 1, sizeof **numbers);
    if (!part || !rings || !*numbers)
        return false;
    size_t outer = ring_round(a, rings, count, at, part, none);
    if (outer == count)
        return true;
    bool good = add_ring(a, rings[outer].begin, NULL, NULL, face, *numbers);
    for (size_t k = 0; k < count && good; k++) {
        size_t node = a->halves[rings[k].begin].from;
        if (rings[k].area < 0 &&
            ring_round(a, rings, count, a->nodes[node], part, part[node]) == outer)
            good = add_ring(a, rings[k].begin, NULL, NULL, face, *numbers);
    }
    return good;
}

bool arrangement_select(const struct arrangement *a,
                        bool (*holds)(const void *context, const double at[2]), const void *context,
                        struct polygons *selected) {
    bool *kept = arena_alloc(a->arena, a->half_count, sizeof *kept);
    bool *used = arena_alloc(a->arena, a->half_count, sizeof *used), good = kept && used;
    for (size_t h = 0; h < a->half_count && good; h++) {
        const double *p = a->nodes[a->halves[h].from], *q = a->nodes[a->halves[h ^ 1].from];
        double nudge = beside * a->reach, c = cos(a->halves[h].angle), s = sin(a->halves[h].angle);
        double x = (p[0] + q[0]) / 2, y = (p[1] + q[1]) / 2;
        const double left[2] = {x - nudge * s, y + nudge * c};
        const double right[2] = {x + nudge * s, y - nudge * c};
        kept[h] = holds(context, left) && !holds(context, right);
    }
    for (size_t h = 0; h < a->half_count && good; h++)
        good = !kept[h] || used[h] || add_ring(a, h, kept, used, selected, NULL);
    return good;
}
