/* SPDX-License-Identifier: MIT */
#include "rim.h"

#include "rim_front.h"
#include "solver/march/cuts.h"
#include "solver/shell/crossing.h"
#include "solver/surface/boxes.h"
#include <string.h>

/* Steps along an edge, in spacings: of first places; below which two smooth places need none in
 * the middle; and below which a place where something ends is not looked for more closely. */
static const double first_step = 2, short_step = 0.3, least_step = 1.0 / 64;

/* By how much the cubic over two steps may miss the place in the middle: over one step it is off by
 * a sixteenth of that. */
static const double cubic_miss = 4 * RIM_TOLERANCE;

/* And by how much it may leave its direction there, over the step: another corner of a cell tells
 * that a little otherwise. */
static const double turn_miss = 0.06;

/* By how much the straight line may miss it near rough edges, where a parabola through all three
 * takes its place. */
static const double parabola_miss = 20 * RIM_TOLERANCE;

/* Or by how much the parabola through the places round it may, which over one step is off by an
 * eighth of that; it has points enough for a step as bent as this. */
static const double guess_miss = 3 * RIM_TOLERANCE, most_bent = 40 * RIM_TOLERANCE;

/* Points that a step is divided into, at the most. */
enum { DIVISIONS = 64 };

/* Over a step too short to be halved coordinates that differ by more than this, and this times the
 * way, are of places that do not hang together: a wild end of the net. */
static const double jump = 0.15, jump_steepness = 15;

/* A point of the cloth this near to the one looked for, in spacings, is the right one. */
static const double beyond_doubt = 0.15;

/* How far beside a cut, in spacings, it is looked for what lies on one side of it. */
static const double beside = 0.01;

/* A node may be this far from the place that it is to lead to, in spacings. */
static const double seed_reach = 2;

/* A corner of the rim turns by so much. */
static const double turned_cosine = 0.9;

/* A place on an edge, found on the cloth. */
struct stop {
    double t;
    struct rim_edge_point spot;
    double pq[2], by_t[2]; /* the net's coordinates and their derivatives */
    struct vec3 along[2];  /* what they follow from, as of a place of the cloth */
    bool covered, smooth;
    bool sloped; /* the derivatives are those of the cloth there: smooth, or seen */
};

struct tracer {
    struct march *march;
    struct rim *rim;
    struct rim_edges edges;
    int32_t loop;
    const struct rim_vertex *from, *to; /* the piece that is followed */
    double spacing;                     /* the smaller one */
    double half_turn[2];                /* see surface_point_cut_turn */
    struct net_tile **tiles;            /* that have nodes inside, */
    struct box *box;                    /* the box round those of each, */
    size_t tile_count;
    struct boxes *boxes; /* and all of them */
    bool failed;         /* no memory */
};

/* ---- a place to begin at ---- */

/* A place beside the spot, moved to the part where that ends before it. */
static struct vec3 on_part(const struct tracer *t, const struct rim_edge_point *spot,
                           struct vec3 r) {
    const struct surface *surface = rim_edges_surface(t->march, spot->face);
    const struct vec3 along[2] = {spot->jet.u, spot->jet.v};
    struct surface_point place;
    double ab[2];
    bool inside = surface && rim_cloth_components(along, vec3_sub(r, spot->r), ab);
    for (int k = 0; k < 2 && inside; k++) {
        const struct surface_axis *axis = &surface->axis[k];
        ab[k] += spot->uv[k];
        inside = axis->closed ||
                 (ab[k] >= surface_axis_lower(axis) && ab[k] <= surface_axis_upper(axis));
    }
    inside = inside && (!surface->shell || crossing_within(surface, ab));
    return !inside && cuts_nearest(t->march, r, &place) ? place.jet.r : r;
}

/* A place beside the spot that is to be covered: towards the middle of its piece, whose ends may
 * lie on a cut. */
static struct vec3 covered_beside(const struct tracer *t, const struct rim_edge_point *spot) {
    struct vec3 left = vec3_unit(vec3_cross(spot->normal, spot->dr));
    struct vec3 inward = vec3_axpy(1 - 2 * spot->t, vec3_unit(spot->dr), left);
    struct vec3 r = vec3_axpy(beside * t->spacing, inward, spot->r);
    return t->march->cuts ? on_part(t, spot, r) : r;
}

/* Whether a node is on the same side of the cuts as what is to be covered beside the place. */
static bool same_turn(const struct tracer *t, const struct net_node *node,
                      const struct rim_edge_point *spot) {
    if (!rim_cloth_sees(&t->rim->cloth, node))
        return false;
    if (t->march->cut.slit[0]) {
        struct vec3 covered = covered_beside(t, spot);
        const struct shell_slit_point from = {node->r, march_normal_at(t->march, node)};
        const struct shell_slit_point to = {covered, spot->normal};
        return !shell_slits_part(t->march->cut.slit, &from, &to);
    }
    bool apart = t->march->mesh || t->march->surface->shell;
    return apart || (fabs(node->uv[0] - spot->uv[0]) <= t->half_turn[0] &&
                     fabs(node->uv[1] - spot->uv[1]) <= t->half_turn[1]);
}

/* About where r is on the net, from the node nearest to it: by the differences of nodes there, at
 * most half a cell away, so that the cell on that side of the node is looked at. */
static void place_beside_node(const struct tracer *t, struct vec3 r, double pq[2]) {
    struct net *net = t->march->net;
    int32_t i = (int32_t)pq[0], j = (int32_t)pq[1];
    struct vec3 node = net_place(net, i, j)->r, along[2];
    double ab[2];
    for (int k = 0; k < 2; k++) {
        const struct net_node *next = net_place(net, i + (k == 0), j + (k == 1));
        const struct net_node *last = net_place(net, i - (k == 0), j - (k == 1));
        along[k] = vec3_scale(next && last ? 0.5 : 1,
                              vec3_sub(next ? next->r : node, last ? last->r : node));
    }
    for (int k = 0; k < 2 && rim_cloth_components(along, vec3_sub(r, node), ab); k++)
        pq[k] += fmin(fmax(ab[k], -0.5), 0.5);
}

/* A node that is looked for: the nearest to a spot so far, of those as near the first. */
struct seed {
    const struct tracer *t;
    const struct rim_edge_point *spot;
    bool alike;     /* it has to face as the spot does */
    double least;   /* square of its distance, or of the reach, */
    int32_t number; /* of its tile; -1: there is none yet, */
    int32_t i, j;   /* and where it is in the net */
};

static bool look_in_tile(void *context, int32_t number) {
    struct seed *seed = context;
    const struct tracer *t = seed->t;
    const struct rim_edge_point *spot = seed->spot;
    const struct net_tile *tile = t->tiles[number];
    double nearest = box_distance2(&t->box[number], spot->r);
    if (nearest > seed->least || (nearest == seed->least && number > seed->number))
        return true;
    for (int y = 0; y < NET_TILE; y++)
        for (uint32_t row = tile->bits[NET_BIT_INSIDE][y]; row; row &= row - 1) {
            int x = __builtin_ctz(row);
            const struct net_node *node = &tile->node[y][x];
            double own = vec3_norm2(vec3_sub(node->r, spot->r));
            bool nearer = own < seed->least || (own == seed->least && number < seed->number);
            struct surface_point point;
            if (!nearer || !same_turn(t, node, spot) ||
                (seed->alike && !(march_point_at(t->march, node, &point) &&
                                  vec3_dot(point.normal, spot->normal) >= 0)))
                continue;
            seed->least = own;
            seed->number = number;
            seed->i = tile->ti * NET_TILE + x;
            seed->j = tile->tj * NET_TILE + y;
        }
    return true;
}

/* The node inside that is nearest to the spot as a place of the net, or, where that ends at the
 * node, one beside it; false when none is near. Of those that face `alike`, or of all: the two
 * sides of a thin part, of a blade at its trailing edge, are near each other in space alone. */
static bool find_seed(const struct tracer *t, const struct rim_edge_point *spot, bool alike,
                      double pq[2]) {
    const double *d = t->march->settings->spacing;
    double reach = seed_reach * fmax(d[0], d[1]);
    struct seed seed = {t, spot, alike, reach * reach, -1, 0, 0};
    const struct box near = box_round(spot->r, spot->r, reach);
    boxes_visit(t->boxes, &near, look_in_tile, &seed);
    if (seed.number < 0)
        return false;
    pq[0] = seed.i;
    pq[1] = seed.j;
    if (!rim_cloth_patch(&t->rim->cloth, seed.i, seed.j)->known)
        place_beside_node(t, spot->r, pq);
    return true;
}

/* ---- places on an edge ---- */

/* Takes in a point of the cloth. Its derivatives by t follow from along[0] p' + along[1] q' = r',
 * in the mean of squares. */
static void take_cloth_point(const struct rim_cloth_point *place, struct stop *stop) {
    memcpy(stop->along, place->along, sizeof stop->along);
    (void)rim_cloth_components(stop->along, stop->spot.dr, stop->by_t);
    stop->pq[0] = place->p;
    stop->pq[1] = place->q;
    stop->smooth = place->smooth;
    stop->sloped = place->smooth || place->seen;
    stop->covered = true;
}

/* Looks for the spot on the cloth near the coordinates of `place`. Where it is looked for in
 * space alone, cloth that faces the other way is not the spot's. */
static bool find_on_cloth(struct tracer *t, const struct rim_edge_point *spot,
                          struct rim_cloth_point *place) {
    const struct march_start *start = &t->march->start;
    if (!rim_cloth_find(&t->rim->cloth, spot, place))
        return false;
    double hand = vec3_dot(vec3_cross(start->warp, start->weft), start->point.normal);
    struct vec3 up = vec3_cross(place->along[0], place->along[1]);
    return place->seen || hand * vec3_dot(up, spot->normal) >= 0;
}

/* Finds the spot of `stop` on the cloth, from the coordinates expected or, where these do not
 * lead there, from the nearest node. */
static void find_stop(struct tracer *t, const double expected[2], bool known, struct stop *stop) {
    struct rim_cloth_point place = {.p = expected[0], .q = expected[1]};
    double seed[2];
    stop->covered = stop->smooth = stop->sloped = false;
    stop->pq[0] = expected[0];
    stop->pq[1] = expected[1];
    stop->by_t[0] = stop->by_t[1] = 0;
    rim_cloth_look(&t->rim->cloth, t->from->sight, covered_beside(t, &stop->spot));
    bool found = known && find_on_cloth(t, &stop->spot, &place);
    double miss = found ? vec3_distance(place.r, stop->spot.r) : HUGE_VAL;
    if (miss > beyond_doubt * t->spacing &&
        (find_seed(t, &stop->spot, true, seed) || find_seed(t, &stop->spot, false, seed))) {
        struct rim_cloth_point other = {.p = seed[0], .q = seed[1]};
        if (find_on_cloth(t, &stop->spot, &other) && vec3_distance(other.r, stop->spot.r) < miss) {
            place = other;
            found = true;
        }
    }
    if (found)
        take_cloth_point(&place, stop);
}

static void edge_point_at(struct tracer *t, double at, struct rim_edge_point *spot) {
    rim_edges_point(t->march, t->from, t->to, at, spot);
}

/* p and q on the cubic between two places, at a share of the way; where a derivative is not known,
 * on the straight line. */
static void cubic(const struct stop *a, const struct stop *b, double share, double pq[2]) {
    double width = b->t - a->t, s = share, r = 1 - share;
    for (int k = 0; k < 2; k++) {
        if (!a->sloped || !b->sloped) {
            pq[k] = r * a->pq[k] + s * b->pq[k];
            continue;
        }
        pq[k] = r * r * (1 + 2 * s) * a->pq[k] + s * s * (1 + 2 * r) * b->pq[k] +
                width * s * r * (r * a->by_t[k] - s * b->by_t[k]);
    }
}

/* ---- points ---- */

static void add_rim_point(struct tracer *t, const struct rim_edge_point *spot, const double pq[2],
                          bool covered) {
    struct rim *rim = t->rim;
    if (rim->count == rim->room)
        rim->points = arena_enlarge(t->march->arena, rim->points, rim->count, sizeof *rim->points,
                                    &rim->room);
    t->failed = t->failed || !rim->points;
    if (t->failed)
        return;
    rim->points[rim->count++] = (struct rim_point){.loop = t->loop,
                                                   .face = spot->face,
                                                   .covered = covered,
                                                   .uv = {spot->uv[0], spot->uv[1]},
                                                   .r = spot->r,
                                                   .beside = covered_beside(t, spot),
                                                   .sight = t->from->sight,
                                                   .p = pq[0],
                                                   .q = pq[1]};
}

/* The points of a step but its last: on the parabola through the place `b` in its middle or, when
 * that is NULL, on the cubic, by as many straight lines as it needs: one of second derivative c
 * deviates from its chord by c / 8 of the square of its length. */
static void emit(struct tracer *t, const struct stop *a, const struct stop *b,
                 const struct stop *c) {
    double width = c->t - a->t, most = 0, bend = 0;
    for (int k = 0; k < 2 && !b && a->sloped && c->sloped; k++) {
        double rise = c->pq[k] - a->pq[k], from = width * a->by_t[k], to = width * c->by_t[k];
        most = fmax(most,
                    fmax(fabs(6 * rise - 4 * from - 2 * to), fabs(-6 * rise + 2 * from + 4 * to)));
    }
    double lines = ceil(sqrt(most / (8 * 0.7 * RIM_TOLERANCE)));
    int count = lines < 1 ? 1 : lines > DIVISIONS ? DIVISIONS : (int)lines;
    for (int k = 0; k < 2 && b; k++)
        bend = fmax(bend, fabs(a->pq[k] - 2 * b->pq[k] + c->pq[k]) / 2);
    if (b)
        count = bend < RIM_TOLERANCE / 2 ? 2 : bend < 8 * RIM_TOLERANCE ? 4 : 8;
    add_rim_point(t, &a->spot, a->pq, a->covered);
    for (int n = 1; n < count; n++) {
        struct rim_edge_point spot;
        double share = (double)n / count, pq[2];
        edge_point_at(t, a->t + share * width, &spot);
        cubic(a, c, share, pq);
        for (int k = 0; k < 2 && b; k++)
            pq[k] = a->pq[k] + share * (c->pq[k] - a->pq[k]) +
                    4 * share * (1 - share) * (b->pq[k] - (a->pq[k] + c->pq[k]) / 2);
        add_rim_point(t, &spot, pq, true);
    }
}

static bool are_near(const double p[2], const double q[2], double miss) {
    return fabs(p[0] - q[0]) < miss && fabs(p[1] - q[1]) < miss;
}

/* Whether the cubic from a to c passes the place in the middle, near rough edges in its direction:
 * where the flat edge has a corner a quarter of the way along, it may pass by chance. */
static bool is_cubic(const struct stop *a, const struct stop *b, const struct stop *c) {
    double pq[2], width = c->t - a->t;
    if (!a->sloped || !b->sloped || !c->sloped)
        return false;
    cubic(a, c, 0.5, pq);
    bool straight = true;
    for (int k = 0; k < 2 && !(a->smooth && b->smooth && c->smooth); k++) {
        double slope = 1.5 * (c->pq[k] - a->pq[k]) - width * (a->by_t[k] + c->by_t[k]) / 4;
        straight = straight && fabs(slope - width * b->by_t[k]) < turn_miss;
    }
    return straight && are_near(pq, b->pq, cubic_miss);
}

/* The place a quarter of the way from a to c on the parabola through these and b in their middle.
 */
static void quarter(const struct stop *a, const struct stop *b, const struct stop *c,
                    double pq[2]) {
    for (int k = 0; k < 2; k++)
        pq[k] = (3 * a->pq[k] + 6 * b->pq[k] - c->pq[k]) / 8;
}

/* Whether the net's coordinates jump from a to b: the cloth is not known between them. */
static bool jumps(const struct tracer *t, const struct stop *a, const struct stop *b) {
    double way = vec3_distance(a->spot.r, b->spot.r) / t->spacing;
    double p = b->pq[0] - a->pq[0], q = b->pq[1] - a->pq[1];
    return sqrt(p * p + q * q) > jump + jump_steepness * way;
}

/* The points of a step but its last, halved until its cubics hold; `guess`: the place in its middle
 * on the parabola through its ends and another place, or NULL. */
static void refine_step(struct tracer *t, const struct stop *a, const struct stop *c,
                        const double *guess) {
    struct stop middle = {.t = (a->t + c->t) / 2};
    double length = vec3_distance(a->spot.r, c->spot.r) / t->spacing;
    double straight[2], expected[2], near_a[2], near_c[2];
    bool both = a->covered && c->covered, none = !a->covered && !c->covered;
    if (both && a->smooth && c->smooth && length < short_step && !jumps(t, a, c)) {
        emit(t, a, NULL, c);
        return;
    }
    cubic(a, c, 0.5, expected);
    if (guess && !(a->smooth && c->smooth))
        memcpy(expected, guess, sizeof expected);
    edge_point_at(t, middle.t, &middle.spot);
    find_stop(t, both ? expected : a->covered ? a->pq : c->pq, a->covered || c->covered, &middle);
    double halves = vec3_distance(a->spot.r, middle.spot.r) / t->spacing;
    bool found = both && middle.covered, cubics = found && is_cubic(a, &middle, c);
    bool settled = cubics || (none && !middle.covered);
    for (int k = 0; k < 2; k++)
        straight[k] = (a->pq[k] + c->pq[k]) / 2;
    /* Near rough edges the place is near the straight line, or where a parabola has it. */
    if (found && !cubics && !(a->smooth && middle.smooth && c->smooth) &&
        (are_near(straight, middle.pq, parabola_miss) ||
         (guess && are_near(guess, middle.pq, guess_miss) &&
          are_near(straight, middle.pq, most_bent)))) {
        emit(t, a, &middle, c);
        return;
    }
    if (settled || fmax(length, halves) < least_step || c->t - a->t < 1e-9) {
        if (!settled &&
            ((a->covered && jumps(t, a, &middle)) || (c->covered && jumps(t, &middle, c))))
            middle.covered = false;
        emit(t, a, NULL, &middle);
        emit(t, &middle, NULL, c);
        return;
    }
    quarter(a, &middle, c, near_a);
    quarter(c, &middle, a, near_c);
    refine_step(t, a, &middle, found ? near_a : NULL);
    refine_step(t, &middle, c, found ? near_c : NULL);
}

/* ---- pieces and loops ---- */

/* A piece from a place that is known; `last` becomes that at its end. At a corner the cloth may end
 * on the yarn that this piece runs along, which the one before it only met. */
static void follow_edge_piece(struct tracer *t, struct stop *last) {
    struct vec3 before = vec3_unit(last->spot.dr);
    struct stop next;
    last->t = 0;
    edge_point_at(t, 0, &last->spot);
    if (!last->covered && vec3_dot(before, vec3_unit(last->spot.dr)) < turned_cosine)
        find_stop(t, last->pq, false, last);
    struct rim_cloth_point place = {.p = last->pq[0], .q = last->pq[1]};
    if (last->covered && last->smooth) {
        const struct rim_patch *patch = t->rim->cloth.patch;
        if (!patch->known || fabs(place.p - patch->i - 0.5) > 0.6 ||
            fabs(place.q - patch->j - 0.5) > 0.6)
            patch =
                rim_cloth_patch(&t->rim->cloth, (int32_t)floor(place.p), (int32_t)floor(place.q));
        if (patch->smooth) {
            rim_patch_point(patch, place.p, place.q, &place);
            take_cloth_point(&place, last);
        }
    } else if (last->covered) {
        (void)rim_cloth_components(last->along, last->spot.dr, last->by_t);
    }
    while (last->t < 1) { /* a step from the last place */
        double step = first_step * t->spacing, speed = vec3_norm(last->spot.dr), left = 1 - last->t;
        double dt = speed * left > step ? step / speed : left, expected[2];
        for (;; dt /= 2) {
            next.t = dt >= left ? 1 : last->t + dt;
            edge_point_at(t, next.t, &next.spot);
            if (vec3_distance(next.spot.r, last->spot.r) < 1.5 * step || dt < 1e-9)
                break;
        }
        for (int k = 0; k < 2; k++)
            expected[k] = last->pq[k] + last->by_t[k] * (next.t - last->t);
        find_stop(t, expected, last->covered, &next);
        refine_step(t, last, &next, NULL);
        *last = next;
    }
}

static void follow_edge_loop(struct tracer *t, const struct rim_loop *loop) {
    const struct rim_vertex *vertices = t->edges.vertices + loop->first;
    struct stop stop = {.covered = false};
    int32_t sight = -1;
    size_t begin = t->rim->count, first = 0;
    for (size_t k = 0; k < loop->count && !t->failed; k++) {
        t->from = &vertices[k];
        t->to = &vertices[k + 1];
        if (t->from->leaps)
            continue;
        if (t->from->sight != sight) {
            edge_point_at(t, 0, &stop.spot);
            find_stop(t, stop.pq, stop.covered, &stop);
        }
        sight = t->from->sight;
        follow_edge_piece(t, &stop);
    }
    /* Nothing leads to where the loop begins but its end, if that is there. */
    struct rim_point *start = t->rim->points + begin;
    if (!t->failed && t->rim->count > begin && !start->covered && stop.covered &&
        sight == start->sight &&
        vec3_distance(stop.spot.r, start->r) < RIM_TOLERANCE * t->spacing) {
        start->covered = true;
        start->p = stop.pq[0];
        start->q = stop.pq[1];
    }
    /* Points that no cloth reaches take the coordinates of the last one before that it does. */
    struct rim_point *points = t->rim->points;
    size_t count = t->failed ? 0 : t->rim->count - begin;
    while (first < count && !points[begin + first].covered)
        first++;
    for (size_t k = 0; first < count && k < count; k++) {
        struct rim_point *own = &points[begin + (first + k) % count];
        const struct rim_point *last = &points[begin + (first + k + count - 1) % count];
        if (!own->covered) {
            own->p = last->p;
            own->q = last->q;
        }
    }
}

/* The tiles that have nodes inside, and the boxes round these. */
static enum status take_tiles(struct tracer *t) {
    struct arena *arena = t->march->arena;
    size_t count = net_tile_count(t->march->net);
    t->tiles = net_sorted_tiles(t->march->net);
    t->box = arena_take(arena, count, sizeof *t->box);
    if (!t->tiles || !t->box)
        return STATUS_OUT_OF_MEMORY;
    for (size_t k = 0; k < count; k++) {
        struct net_tile *tile = t->tiles[k];
        struct box box = {{HUGE_VAL, HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}};
        for (int y = 0; y < NET_TILE; y++)
            for (uint32_t row = tile->bits[NET_BIT_INSIDE][y]; row; row &= row - 1) {
                struct vec3 r = tile->node[y][__builtin_ctz(row)].r;
                box.lower = vec3_min(box.lower, r);
                box.upper = vec3_max(box.upper, r);
            }
        t->tiles[t->tile_count] = tile;
        t->box[t->tile_count] = box;
        t->tile_count += box.lower.x <= box.upper.x;
    }
    return boxes_make(t->box, t->tile_count, arena, &t->boxes);
}

enum status rim_make(struct march *march, struct rim *rim) {
    const double *d = march->settings->spacing;
    struct tracer t = {.march = march, .rim = rim, .spacing = fmin(d[0], d[1])};
    *rim = (struct rim){.count = 0};
    for (int k = 0; k < 2; k++)
        t.half_turn[k] = march->surface ? surface_point_cut_turn(march->surface, k) : HUGE_VAL;
    struct cut_fault fault;
    enum status status = rim_edges_make(march, RIM_TOLERANCE / 3 * t.spacing, &t.edges, &fault);
    if (status == STATUS_OK)
        status = rim_cloth_make(march, t.edges.sights, &rim->cloth);
    if (status != STATUS_OK)
        return STATUS_OUT_OF_MEMORY;
    if (take_tiles(&t) != STATUS_OK)
        return STATUS_OUT_OF_MEMORY;
    for (size_t k = 0; k < t.edges.loop_count && !t.failed; k++) {
        t.loop = (int32_t)k;
        follow_edge_loop(&t, &t.edges.loops[k]);
    }
    rim->covered = !t.failed && rim->count > 0;
    for (size_t k = 0; k < rim->count && rim->covered; k++)
        rim->covered = rim->points[k].covered;
    if (!t.failed)
        rim_reach_front(rim);
    rim->loop_count = t.edges.loop_count;
    rim->lip_of = t.edges.lip_of;
    return t.failed || rim->cloth.failed ? STATUS_OUT_OF_MEMORY : STATUS_OK;
}

/* ---- the way round ---- */

/* The share of the way from `x` to `to`, starting at share `at`, at which the next whole number is
 * passed; 1 if none is. */
static double next_cell_side(double from, double to, double at) {
    double x = from + at * (to - from), step = to - from;
    if (step == 0)
        return 1;
    double line = step > 0 ? floor(x) + 1 : ceil(x) - 1, next = (line - from) / step;
    if (next <= at)
        next = (line + (step > 0 ? 1 : -1) - from) / step;
    return next < 1 ? next : 1;
}

/* The rim that runs along the sides of cells, as far as rounding goes, is that of the cells that it
 * has on its left: they may have nodes beyond it, and then are no whole cells. */
static const double beside_side = 1e-9;

/* Whether the line between two points runs along an end of the net that its extent sets. */
static bool runs_along_extent(const struct rim *rim, const double from[2], const double to[2]) {
    const struct drape_settings *s = rim->cloth.march->settings;
    bool along = false;
    for (int k = 0; k < 2; k++)
        for (int end = 0; end < 2 && s->has_extent[k]; end++)
            along = along || (fabs(from[k] - s->extent[k][end]) < RIM_TOLERANCE &&
                              fabs(to[k] - s->extent[k][end]) < RIM_TOLERANCE);
    return along;
}

bool rim_walk_next(struct rim_walk *walk, struct rim_piece *piece) {
    const struct rim *rim = walk->rim;
    size_t k = walk->point;
    if (k == rim->count)
        return false;
    bool last = k + 1 == rim->count || rim->points[k + 1].loop != rim->points[k].loop;
    const struct rim_point *a = &rim->points[k], *b = &rim->points[last ? walk->first : k + 1];
    const double from[2] = {a->p, a->q}, to[2] = {b->p, b->q};
    bool one_cell = floor(from[0]) == floor(to[0]) && floor(from[1]) == floor(to[1]);
    double begin = walk->at, end = 1;
    if (!one_cell)
        end = fmin(next_cell_side(from[0], to[0], begin), next_cell_side(from[1], to[1], begin));
    for (int n = 0; n < 2; n++) {
        piece->from[n] = begin == 0 ? from[n] : from[n] + begin * (to[n] - from[n]);
        piece->to[n] = end == 1 ? to[n] : from[n] + end * (to[n] - from[n]);
        piece->r[n] = vec3_axpy(n ? end : begin, vec3_sub(b->r, a->r), a->r);
    }
    double dp = piece->to[0] - piece->from[0], dq = piece->to[1] - piece->from[1];
    double length = sqrt(dp * dp + dq * dq) + 1e-12;
    piece->i = (int32_t)floor((piece->from[0] + piece->to[0]) / 2 - beside_side * dq / length);
    piece->j = (int32_t)floor((piece->from[1] + piece->to[1]) / 2 + beside_side * dp / length);
    piece->point = k;
    piece->loose = !a->covered || !b->covered;
    piece->at_extent = piece->loose && runs_along_extent(rim, from, to);
    walk->at = end < 1 ? end : 0;
    walk->point = end < 1 ? k : k + 1;
    walk->first = end == 1 && last ? k + 1 : walk->first;
    return true;
}
