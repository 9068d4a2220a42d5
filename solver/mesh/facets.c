/* SPDX-License-Identifier: MIT */
#include "facets.h"

#include "facets_cell.h"
#include "solver/wide.h"
#include <math.h>

enum { STACK = FACETS_LEVELS * FACETS_CHILDREN, JUMPS = 8, HOPS = 64 /* of a jump */ };
enum { DIGIT_BITS = 11, DIGITS = 1 << DIGIT_BITS };

/* How far beyond the rim is outside, as a share of the edge there: more than rounding. */
static const double beyond = 1e-6;

/* Of distances and radii. */
static const double rounding = 1e-12;

/* In sizes of cells: steps from point to point that more like them are expected after, and how far
 * these may lead before what is near is looked up again. */
static const double small_steps = 4, lasting_steps = 7;

/* ---- making ---- */

struct key {
    uint64_t morton;
    int32_t cell;
};

/* The bits of x, each followed by a zero. */
static uint64_t interleave(uint32_t x) {
    uint64_t b = x;
    b = (b | b << 16) & 0x0000ffff0000ffffU;
    b = (b | b << 8) & 0x00ff00ff00ff00ffU;
    b = (b | b << 4) & 0x0f0f0f0f0f0f0f0fU;
    b = (b | b << 2) & 0x3333333333333333U;
    return (b | b << 1) & 0x5555555555555555U;
}

/* The place of a cell on Morton's curve through all places from the least i and j on. */
static uint64_t morton_of(const struct facets *facets, size_t cell) {
    const int32_t *place = facets->source.places[cell];
    return interleave((uint32_t)place[0] - (uint32_t)facets->low[0]) |
           interleave((uint32_t)place[1] - (uint32_t)facets->low[1]) << 1;
}

/* Orders the cells by their keys, digit by digit from the lowest. */
static enum status sort_cells(struct facets *facets, struct arena *arena) {
    struct arena_mark mark = arena_mark(arena);
    size_t count = facets->source.cell_count;
    struct key *from = arena_take(arena, count, sizeof *from);
    struct key *to = arena_take(arena, count, sizeof *to);
    uint64_t most = 0;
    if (!from || !to)
        return STATUS_OUT_OF_MEMORY;
    for (size_t k = 0; k < count; k++) {
        from[k] = (struct key){morton_of(facets, k), (int32_t)k};
        most |= from[k].morton;
    }
    for (int shift = 0; shift < 64 && most >> shift; shift += DIGIT_BITS) {
        size_t begin[DIGITS + 1] = {0};
        for (size_t k = 0; k < count; k++)
            begin[(from[k].morton >> shift) % DIGITS + 1]++;
        for (int digit = 0; digit < DIGITS; digit++)
            begin[digit + 1] += begin[digit];
        for (size_t k = 0; k < count; k++)
            to[begin[(from[k].morton >> shift) % DIGITS]++] = from[k];
        struct key *last = from;
        from = to;
        to = last;
    }
    for (size_t k = 0; k < count; k++)
        facets->order[k] = from[k].cell;
    arena_rewind(arena, mark);
    return STATUS_OK;
}

static struct vec3 corner_point(const struct facets_source *source, int32_t cell, int corner) {
    return source->nodes[source->corners[cell][corner & 3]];
}

static struct vec3 middle_of(const struct facets_source *source, int32_t cell) {
    struct vec3 middle = {0, 0, 0};
    for (int k = 0; k < 4; k++)
        middle = vec3_axpy(0.25, corner_point(source, cell, k), middle);
    return middle;
}

static struct vec3 ball_middle(const struct facets_node *node, int c) {
    return vec3_make(node->middle[0][c], node->middle[1][c], node->middle[2][c]);
}

/* The ball about the middle of the box of the middles below, round all balls there. */
static struct vec3 ball_round(const struct facets_node *below, double *radius) {
    double at[3];
    for (int k = 0; k < 3; k++) {
        double lower = below->middle[k][0], upper = lower;
        for (int n = 1; n < below->count; n++) {
            lower = below->middle[k][n] < lower ? below->middle[k][n] : lower;
            upper = below->middle[k][n] > upper ? below->middle[k][n] : upper;
        }
        at[k] = lower + (upper - lower) / 2;
    }
    struct vec3 middle = vec3_make(at[0], at[1], at[2]);
    for (int n = 0; n < below->count; n++) {
        double reach = vec3_distance(middle, ball_middle(below, n)) + below->radius[n];
        *radius = reach > *radius ? reach : *radius;
    }
    return middle;
}

/* The key of the node of this level that the k-th of those below belongs to. */
static uint64_t parent_of(const struct facets *facets, int level, size_t k) {
    uint64_t own =
        level == 0 ? morton_of(facets, (size_t)facets->order[k]) : facets->level[level - 1][k].key;
    return own >> 3; /* FACETS_CHILDREN */
}

/* The nodes over `below` of the level below, or cells; how many there are. */
static enum status add_level(struct facets *facets, size_t below, struct arena *arena,
                             size_t *count) {
    int level = facets->levels++;
    uint64_t last = 0;
    *count = 0;
    for (size_t k = 0; k < below; k++) {
        uint64_t key = parent_of(facets, level, k);
        *count += k == 0 || key != last;
        last = key;
    }
    struct facets_node *node = arena_alloc(arena, *count, sizeof *node);
    if (!node)
        return STATUS_OUT_OF_MEMORY;
    facets->level[level] = node;
    for (size_t k = 0; k < below; k++) {
        uint64_t key = parent_of(facets, level, k);
        if (node->count > 0 && node->key != key)
            node++;
        if (node->count == 0) {
            node->key = key;
            node->first = k;
        }
        struct vec3 middle;
        double radius = 0;
        if (level > 0) {
            middle = ball_round(&facets->level[level - 1][k], &radius);
        } else {
            /* the ball about the middle of a cell, through its farthest corner */
            const struct facets_source *source = &facets->source;
            middle = middle_of(source, facets->order[k]);
            for (int c = 0; c < 4; c++) {
                struct vec3 corner = corner_point(source, facets->order[k], c);
                double own2 = vec3_norm2(vec3_sub(corner, middle));
                radius = own2 > radius ? own2 : radius;
            }
            radius = sqrt(radius);
            facets->size += radius / (double)source->cell_count;
        }
        size_t c = (size_t)node->count++;
        vec3_to_columns(middle, node->middle[0], node->middle[1], node->middle[2], c);
        node->radius[c] = radius * (1 + rounding); /* in its favour */
    }
    return STATUS_OK;
}

enum status facets_make(const struct facets_source *source, struct arena *arena,
                        struct facets **result) {
    if (source->cell_count == 0)
        return STATUS_INVALID;
    struct facets *facets = arena_alloc(arena, 1, sizeof *facets);
    if (!facets)
        return STATUS_OUT_OF_MEMORY;
    facets->source = *source;
    facets->around = arena_take(arena, source->node_count, sizeof *facets->around);
    facets->order = arena_take(arena, source->cell_count, sizeof *facets->order);
    if (!facets->around || !facets->order)
        return STATUS_OUT_OF_MEMORY;
    facets->low[0] = facets->low[1] = INT32_MAX;
    for (size_t k = 0; k < source->cell_count; k++)
        for (int side = 0; side < 2; side++) {
            int32_t own = source->places[k][side];
            facets->low[side] = own < facets->low[side] ? own : facets->low[side];
        }
    enum status status = sort_cells(facets, arena);
    for (size_t count = source->cell_count; status == STATUS_OK;) {
        status = add_level(facets, count, arena, &count);
        if (count <= 1)
            break;
    }
    for (size_t node = 0; node < source->node_count; node++)
        for (int k = 0; k < 4; k++)
            facets->around[node][k] = FACETS_NONE;
    /* A cell has its own place at each corner, since it lies on another side of each. */
    for (size_t cell = 0; cell < source->cell_count; cell++)
        for (int k = 0; k < 4; k++)
            facets->around[source->corners[cell][k]][k] = (int32_t)cell;
    *result = facets;
    return status;
}

/* ---- the query ---- */

struct query {
    const struct facets *facets;
    struct vec3 point;
    struct facets_point *best;
    double distance, distance2; /* of the best */
};

static void try_cell(struct query *query, int32_t cell) {
    struct facets_cell own;
    struct facets_cell_point place;
    if (cell == query->best->cell)
        return;
    for (int k = 0; k < FACETS_SIDES; k++)
        own.corner[k] = corner_point(&query->facets->source, cell, k);
    own.middle = middle_of(&query->facets->source, cell);
    facets_cell_nearest(&own, query->point, &place);
    bool nearer = place.distance2 < query->distance2 ||
                  (place.distance2 == query->distance2 && cell < query->best->cell);
    if (!nearer)
        return;
    query->distance2 = place.distance2;
    query->distance = sqrt(place.distance2);
    *query->best =
        (struct facets_point){.cell = cell,
                              .side = place.side,
                              .weight = {place.weight[0], place.weight[1], place.weight[2]},
                              .r = place.r};
}

/* So many cells on from a cell along the warp (axis 0) or the weft, as far as there are some. */
static int32_t hop(const struct facets *facets, int32_t cell, int axis, double steps) {
    static const int8_t corner[2][2] = {{0, 0}, {1, 3}};
    static const int8_t own[2][2] = {{1, 3}, {0, 0}}; /* the neighbour's corner at that one */
    bool on = steps > 0;
    for (int k = 0; k < HOPS && k + 0.5 < fabs(steps); k++) {
        int32_t node = facets->source.corners[cell][corner[on][axis]];
        int32_t next = facets->around[node][own[on][axis]];
        if (next == FACETS_NONE)
            break;
        cell = next;
    }
    return cell;
}

/* The cell under the point if the net went on as it does at this one: the point less the cell's
 * middle is x a + y b with its mean warp a and weft b, and something across them. */
static int32_t jump(const struct facets *facets, struct vec3 point, int32_t cell) {
    const struct facets_source *source = &facets->source;
    struct vec3 d1 = vec3_sub(corner_point(source, cell, 2), corner_point(source, cell, 0));
    struct vec3 d2 = vec3_sub(corner_point(source, cell, 1), corner_point(source, cell, 3));
    struct vec3 a = vec3_scale(0.5, vec3_sub(d1, vec3_scale(-1, d2)));
    struct vec3 b = vec3_scale(0.5, vec3_sub(d1, d2)),
                gap = vec3_sub(point, middle_of(source, cell));
    double aa = vec3_norm2(a), ab = vec3_dot(a, b), bb = vec3_norm2(b);
    double ga = vec3_dot(gap, a), gb = vec3_dot(gap, b), area2 = aa * bb - ab * ab;
    if (!(area2 > 0))
        return cell;
    cell = hop(facets, cell, 0, (ga * bb - gb * ab) / area2);
    return hop(facets, cell, 1, (gb * aa - ga * ab) / area2);
}

/* A child in the tree: a node of this level, or with the level -1 the cell order[index]. */
struct visit {
    double least; /* its distance, or less */
    size_t index;
    int level;
};

/* By how much the squared distance from each child's middle is more than it may be: the ball of
 * radius R about m comes as near as d when |p - m| <= R + d. */
WIDE_CLONES
static void measure_balls(const struct facets_node *node, struct vec3 p, double distance,
                          double excess[FACETS_CHILDREN]) {
    const double *x = node->middle[0], *y = node->middle[1], *z = node->middle[2];
    for (int c = 0; c < FACETS_CHILDREN; c++) {
        double dx = p.x - x[c], dy = p.y - y[c], dz = p.z - z[c];
        double reach = node->radius[c] + distance;
        excess[c] = dx * dx + dy * dy + dz * dz - reach * reach;
    }
}

/* Tries all cells under a node that may be nearer than the best so far. */
static void descend_from(struct query *query, struct visit root) {
    struct visit stack[STACK];
    size_t height = 0;
    stack[height++] = root;
    while (height > 0) {
        struct visit at = stack[--height];
        if (at.least > query->distance * (1 + rounding))
            continue;
        if (at.level < 0) {
            try_cell(query, query->facets->order[at.index]);
            continue;
        }
        /* the children that are near enough, the nearest on top */
        const struct facets_node *node = &query->facets->level[at.level][at.index];
        double excess[FACETS_CHILDREN];
        size_t bottom = height;
        measure_balls(node, query->point, query->distance * (1 + rounding), excess);
        for (int c = 0; c < node->count; c++) {
            if (excess[c] > 0)
                continue;
            double least = vec3_distance(query->point, ball_middle(node, c)) - node->radius[c];
            size_t k = height++;
            for (; k > bottom && stack[k - 1].least < least; k--)
                stack[k] = stack[k - 1];
            stack[k] = (struct visit){least, node->first + (size_t)c, at.level - 1};
        }
    }
}

/* ---- one after the other ---- */

/* Notes the nodes over cells that come within `reach` of the point; none if these are many. */
static void gather_near(struct facets_search *search, struct vec3 point, double reach) {
    const struct facets *facets = search->facets;
    struct visit stack[STACK];
    size_t height = 0;
    search->middle = point;
    search->reach = -1;
    search->count = 0;
    stack[height++] = (struct visit){.level = facets->levels - 1};
    while (height > 0 && facets->levels > 1) {
        struct visit at = stack[--height];
        const struct facets_node *node = &facets->level[at.level][at.index];
        double excess[FACETS_CHILDREN];
        measure_balls(node, point, reach * (1 + rounding), excess);
        for (int c = 0; c < node->count; c++) {
            size_t child = node->first + (size_t)c;
            if (excess[c] > 0)
                continue;
            if (at.level > 1) {
                stack[height++] = (struct visit){.index = child, .level = at.level - 1};
                continue;
            }
            if (search->count == FACETS_NEAR)
                return;
            struct facets_node *group = &search->near[search->count / FACETS_CHILDREN];
            int own = search->count % FACETS_CHILDREN;
            for (int k = 0; k < 3; k++)
                group->middle[k][own] = node->middle[k][c];
            group->radius[own] = node->radius[c];
            group->count = own + 1;
            search->node[search->count++] = child;
        }
        search->reach = height > 0 ? -1 : reach;
    }
}

static bool has_near(const struct facets_search *search, const struct query *query) {
    return vec3_distance(query->point, search->middle) + query->distance <=
           search->reach * (1 - rounding);
}

/* ---- the rim ---- */

/* Whether `at`, the nearest to a point, lies on the rim, on an edge of one cell or at a corner that
 * is not in the middle of four, and the point beyond it, as seen along the plane of its triangle.
 */
static bool lies_beyond_rim(const struct facets *facets, const struct facets_point *at,
                            struct vec3 point) {
    const struct facets_source *source = &facets->source;
    const int32_t *corners = source->corners[at->cell];
    if (at->weight[0] > 0)
        return false;
    if (at->weight[1] > 0 && at->weight[2] > 0) {
        /* on an edge: whether another cell has both of its ends */
        const int32_t *a = facets->around[corners[at->side & 3]];
        const int32_t *b = facets->around[corners[(at->side + 1) & 3]];
        for (int k = 0; k < 4; k++)
            for (int m = 0; m < 4; m++)
                if (a[k] != FACETS_NONE && a[k] != at->cell && a[k] == b[m])
                    return false;
    } else {
        const int32_t *around = facets->around[corners[(at->side + (at->weight[2] > 0)) & 3]];
        if (around[0] != FACETS_NONE && around[1] != FACETS_NONE && around[2] != FACETS_NONE &&
            around[3] != FACETS_NONE)
            return false;
    }
    struct vec3 a = corner_point(source, at->cell, at->side);
    struct vec3 b = corner_point(source, at->cell, at->side + 1);
    struct vec3 c = corner_point(source, at->cell, at->side + 2);
    struct vec3 ab = vec3_sub(b, a), gap = vec3_sub(point, at->r);
    struct vec3 normal = vec3_unit(vec3_cross(ab, vec3_sub(c, b)));
    double by = vec3_norm(vec3_axpy(-vec3_dot(gap, normal), normal, gap));
    return by > beyond * vec3_norm(ab);
}

struct facets_search facets_search_begin(const struct facets *facets) {
    return (struct facets_search){.facets = facets, .reach = -1};
}

void facets_nearest(struct facets_search *search, struct vec3 point, struct facets_point *at) {
    const struct facets *facets = search->facets;
    int32_t cell = search->cell, last = FACETS_NONE;
    *at = (struct facets_point){.cell = INT32_MAX};
    struct query query = {facets, point, at, HUGE_VAL, HUGE_VAL};
    /* Jumps to where the net has the point, or close to it; the tree finds the rest. */
    for (int k = 0; k < JUMPS && cell != last; k++) {
        last = cell;
        cell = jump(facets, point, cell);
    }
    try_cell(&query, cell);
    /* The cells that may be nearer lie under the nodes near the middle, if the point is so near to
     * that. A point that is not, but a small step from the last one, is made the middle, because
     * more of such steps are likely. */
    double step = vec3_distance(point, search->point);
    if (!has_near(search, &query) && fmax(step, query.distance) < small_steps * facets->size)
        gather_near(search, point, query.distance + lasting_steps * facets->size);
    if (has_near(search, &query)) {
        for (int n = 0; n < search->count; n += FACETS_CHILDREN) {
            const struct facets_node *group = &search->near[n / FACETS_CHILDREN];
            double excess[FACETS_CHILDREN];
            measure_balls(group, point, query.distance * (1 + rounding), excess);
            for (int c = 0; c < group->count; c++)
                if (excess[c] <= 0)
                    descend_from(&query, (struct visit){.index = search->node[n + c], .level = 0});
        }
    } else {
        descend_from(&query, (struct visit){.level = facets->levels - 1});
    }
    at->distance = query.distance;
    at->outside = lies_beyond_rim(facets, at, point);
    search->cell = at->cell;
    search->point = point;
}
