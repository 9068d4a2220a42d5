/* SPDX-License-Identifier: MIT */
/*
 * The quadrants, row by row away from the warp generator. A row goes on until it has left the
 * surface for good, as far as it can tell; when a higher row reaches further out, the rows below it
 * are extended on demand, so that exactly those ghosts are computed that some node rests on.
 *
 * A quadrant needs nothing of the others but the two arms beside it, and its nodes lie in tiles of
 * its own: with a team the four are marched at the same time.
 */
#include "march.h"

/* The differences of a row's sequence at its last place: of order 0, 1, .. in u and v. */
enum { ORDERS = 6 };
struct differences {
    int count; /* of those known */
    double of[ORDERS][2];
};

struct quadrant {
    struct march local; /* the march as this quadrant sees it: counts, cursor and view of its own */
    struct march *march; /* = &local */
    enum status status;  /* how it ended */
    int si, sj;
    struct net_node *arm[2]; /* the places on the warp and weft arm, to the first that is none */
    int32_t length;          /* places on the warp arm */
    int32_t reach[2]; /* of the row below and the one below it: the last place that has not left
                         the surface */
    struct station *below; /* row j - 1 at i = 0 .. below_count - 1, counted from the generator */
    struct station *row;   /* row j alike */
    int32_t below_count, row_count;
    struct differences edge; /* of the edge from the row below to this one, in parameters */
};

/* How a row went. */
struct row_end {
    bool planted; /* it has a first node, on the weft generator */
    bool near;    /* some place of it has not left the surface */
};

/* The place (i, j), counted from the start away along the arms; NULL where nothing was put. On the
 * arms it is read from the quadrant's copy: those tiles belong to others. */
static const struct net_node *find_place(struct quadrant *q, int32_t i, int32_t j) {
    if (i > 0 && j > 0)
        return net_find(q->march->net, i * q->si, j * q->sj);
    return j == 0 ? &q->arm[0][i] : &q->arm[1][j];
}

static enum net_state state_at(struct quadrant *q, int32_t i, int32_t j) {
    const struct net_node *node = find_place(q, i, j);
    return node ? (enum net_state)node->state : NET_UNKNOWN;
}

static bool station_of(struct quadrant *q, int32_t i, int32_t j, struct station *station) {
    const struct net_node *node = find_place(q, i, j);
    return node && (node->state == NET_INSIDE || node->state == NET_GHOST) &&
           march_station_at(q->march, node, station);
}

/* Brings (i, j) and the places below it into being, the row having ended before: `found` says
 * whether, `station` is then there. */
static enum status climb_column(struct quadrant *q, int32_t i, int32_t j, struct station *station,
                                bool *found) {
    struct march *march = q->march;
    struct station a, b;
    int32_t r = j;
    while (r > 0 && state_at(q, i, r) == NET_UNKNOWN)
        r--;
    *found = station_of(q, i, r, station);
    if (!*found || r == j || !station_of(q, i - 1, r, &a))
        return STATUS_OK;
    for (r++; *found && r <= j; r++) {
        struct fishnet_node node;
        enum drape_reason reason;
        enum station_zone zone;
        *found = station_of(q, i - 1, r, &b);
        if (!*found)
            return STATUS_OK;
        struct march_cell cell = {i * q->si, r * q->sj, q->si,     q->sj, &a,
                                  &b,        station,   {0, 0, 0}, NULL};
        *found = march_solve_corner(march, &cell, &node, &reason);
        if (!*found)
            return march_fail(march, i * q->si, r * q->sj, reason);
        enum status status = march_place(march, i * q->si, r * q->sj, &node.station, &zone);
        if (status != STATUS_OK)
            return status;
        *found = zone != STATION_BEYOND;
        *station = node.station;
        a = b;
    }
    return STATUS_OK;
}

/* Makes sure that below[i] is there; `found` is false when the net has no such place. */
static enum status reach_below(struct quadrant *q, int32_t i, int32_t j, bool *found) {
    *found = i < q->below_count;
    if (*found)
        return STATUS_OK;
    enum status status = climb_column(q, i, j - 1, &q->below[i], found);
    q->below_count += *found;
    return status;
}

static bool has_left(struct quadrant *q, int32_t i, int32_t j, const struct station *station) {
    return state_at(q, i, j) != NET_INSIDE && march_has_left(q->march, station);
}

/* By how much the edge from the row below to this one at i differs from that at i - 1. */
static struct vec3 edge_trend(const struct quadrant *q, int32_t i) {
    if (i < 2)
        return vec3_make(0, 0, 0);
    struct vec3 last = vec3_sub(q->row[i - 1].jet.r, q->below[i - 1].jet.r);
    return vec3_sub(last, vec3_sub(q->row[i - 2].jet.r, q->below[i - 2].jet.r));
}

/* Takes in the edge at i. */
static void add_edge(struct quadrant *q, int32_t i) {
    struct differences *edge = &q->edge;
    edge->count += edge->count < ORDERS;
    for (int k = 0; k < 2; k++) {
        double now = q->row[i].uv[k] - q->below[i].uv[k];
        for (int order = 0; order < edge->count; order++) {
            double before = edge->of[order][k];
            edge->of[order][k] = now;
            now -= before;
        }
    }
}

/* The size of a difference on the surface, squared, but for the angle between its parameter lines.
 */
static double size2(const struct station *station, const double of[2]) {
    return of[0] * of[0] * station->first[0] + of[1] * of[1] * station->first[2];
}

/* The parameters of (i, j): those below it, and the edge between the rows extrapolated by its
 * differences, as long as they become smaller with their order. */
static void extrapolate(const struct quadrant *q, int32_t i, double uv[2]) {
    const struct differences *edge = &q->edge;
    const struct station *below = &q->below[i];
    double last = HUGE_VAL;
    uv[0] = below->uv[0];
    uv[1] = below->uv[1];
    for (int order = 0; order < edge->count; order++) {
        double size = size2(below, edge->of[order]);
        if (!(size < last))
            break;
        last = size;
        uv[0] += edge->of[order][0];
        uv[1] += edge->of[order][1];
    }
}

/* Node (i, j) of the row; `zone` says where it went, STATION_BEYOND when the row ends. */
static enum status grow_node(struct quadrant *q, int32_t i, int32_t j, enum station_zone *zone) {
    struct march *march = q->march;
    struct fishnet_node node;
    enum drape_reason reason;
    struct march_cell cell = {.i = i * q->si, .j = j * q->sj, .si = q->si, .sj = q->sj};
    cell.a = &q->below[i - 1];
    cell.b = &q->row[i - 1];
    cell.c = &q->below[i];
    cell.trend = edge_trend(q, i);
    double uv[2];
    if (i >= 2 && !march->mesh && !march->surface->has_poles) {
        extrapolate(q, i, uv);
        cell.guess_uv = uv;
    }
    *zone = STATION_BEYOND;
    if (!march_solve_corner(march, &cell, &node, &reason))
        return march_fail(march, i * q->si, j * q->sj, reason);
    q->row[i] = node.station;
    q->row_count = i + 1;
    add_edge(q, i);
    return march_place(march, i * q->si, j * q->sj, &node.station, zone);
}

/* A row ends `fringe` places after it has left the surface, but not before it is as far beyond the
 * ends of the two rows below: the boundary may run inwards first, and stencils at their nodes reach
 * two places to all sides. */
static enum status grow_row(struct quadrant *q, int32_t j, struct row_end *end) {
    struct march *march = q->march;
    *end = (struct row_end){.planted = station_of(q, 0, j, &q->row[0])};
    if (!end->planted)
        return STATUS_OK;
    int32_t farthest = q->reach[0] > q->reach[1] ? q->reach[0] : q->reach[1];
    int32_t last = has_left(q, 0, j, &q->row[0]) ? -1 : 0, limit = farthest + march->fringe;
    q->row_count = 1;
    q->edge.count = 0;
    add_edge(q, 0);
    for (int32_t i = 1; i < q->length && (i <= limit || i <= last + march->fringe); i++) {
        bool found;
        enum station_zone zone;
        enum status status = reach_below(q, i, j, &found);
        if (status == STATUS_OK && found)
            status = grow_node(q, i, j, &zone);
        if (status != STATUS_OK)
            return status;
        if (!found || zone == STATION_BEYOND)
            break;
        if (!has_left(q, i, j, &q->row[i]))
            last = i;
    }
    end->near = last >= 0;
    q->reach[1] = q->reach[0];
    q->reach[0] = end->near ? last : q->reach[0];
    return STATUS_OK;
}

/* Rows until the weft generator ends, or the net has left the surface for good. */
static enum status grow_rows(struct quadrant *q) {
    bool been_near = false;
    for (int32_t j = 1, empty = 0; empty < q->march->fringe; j++) {
        struct row_end end;
        enum status status = grow_row(q, j, &end);
        if (status != STATUS_OK || !end.planted)
            return status;
        if (!march_progress(q->march))
            return STATUS_CANCELLED;
        been_near = been_near || end.near;
        empty = been_near && !end.near ? empty + 1 : 0;
        struct station *free_row = q->below;
        q->below = q->row;
        q->below_count = q->row_count;
        q->row = free_row;
    }
    return STATUS_OK;
}

/* Copies an arm up to and with the first place that is no node; `length` gets the number of nodes.
 */
static struct net_node *copy_arm(struct march *march, int di, int dj, int32_t *length) {
    for (*length = 0; net_place(march->net, *length * di, *length * dj);)
        ++*length;
    struct net_node *arm = arena_alloc(march->arena, (size_t)*length + 1, sizeof *arm);
    for (int32_t k = 0; arm && k < *length; k++)
        arm[k] = *net_place(march->net, k * di, k * dj);
    return arm;
}

/* What a quadrant needs but its rows, before any of them is marched. */
static enum status prepare(struct march *march, int number, struct quadrant *q) {
    int32_t height;
    *q = (struct quadrant){.local = *march, .si = number % 2 ? -1 : 1, .sj = number / 2 ? -1 : 1};
    q->march = &q->local;
    q->local.inside = q->local.ghosts = q->local.solved = q->local.iterations = 0;
    q->arm[0] = copy_arm(march, q->si, 0, &q->length);
    q->arm[1] = copy_arm(march, 0, q->sj, &height);
    q->local.arm[0] = q->arm[0];
    q->local.arm[1] = q->arm[1];
    return q->arm[0] && q->arm[1] ? STATUS_OK : STATUS_OUT_OF_MEMORY;
}

/* Two rows for each quadrant, or the same two for all that are marched one after the other. */
static enum status make_rows(struct march *march, struct quadrant *quadrants, bool together) {
    int32_t longest = 0;
    for (int k = 0; k < NET_TABLES; k++)
        longest = quadrants[k].length > longest ? quadrants[k].length : longest;
    for (int k = 0; k < NET_TABLES; k++) {
        struct quadrant *q = &quadrants[k];
        bool own = k == 0 || together;
        size_t room = (size_t)longest;
        q->below = own ? arena_alloc(march->arena, room, sizeof *q->below) : quadrants[0].below;
        q->row = own ? arena_alloc(march->arena, room, sizeof *q->row) : quadrants[0].row;
        if (!q->below || !q->row)
            return STATUS_OUT_OF_MEMORY;
    }
    return STATUS_OK;
}

static void grow_quadrant(void *data, int number) {
    struct quadrant *q = &((struct quadrant *)data)[number];
    while (q->below_count < q->length &&
           station_of(q, q->below_count, 0, &q->below[q->below_count]))
        q->below_count++;
    for (int32_t i = 0; i < q->below_count; i++)
        q->reach[0] = has_left(q, i, 0, &q->below[i]) ? q->reach[0] : i;
    q->status = grow_rows(q);
}

static enum status gather(struct march *march, const struct quadrant *q) {
    march->inside += q->local.inside;
    march->ghosts += q->local.ghosts;
    march->solved += q->local.solved;
    march->iterations += q->local.iterations;
    march->residual_max = fmax(march->residual_max, q->local.residual_max);
    bool too_many = march->inside > march->settings->max_nodes;
    return q->status == STATUS_OK && too_many ? STATUS_TOO_MANY_NODES : q->status;
}

/* Where the net may meet itself one quadrant has to know of the others: then one after the other.
 */
enum status march_quadrants(struct march *march) {
    const struct drape_team *team = march->settings->team;
    bool together = team && !march->fold;
    struct quadrant *quadrants = arena_alloc(march->arena, NET_TABLES, sizeof *quadrants);
    enum status status = quadrants ? STATUS_OK : STATUS_OUT_OF_MEMORY;
    for (int k = 0; k < NET_TABLES && status == STATUS_OK; k++)
        status = prepare(march, k, &quadrants[k]);
    if (status == STATUS_OK)
        status = make_rows(march, quadrants, together);
    if (status != STATUS_OK)
        return status;
    if (together)
        team->run(team->context, NET_TABLES, grow_quadrant, quadrants);
    for (int k = 0; k < NET_TABLES && status == STATUS_OK; k++) {
        if (!together)
            grow_quadrant(quadrants, k);
        status = gather(march, &quadrants[k]);
    }
    return status;
}
