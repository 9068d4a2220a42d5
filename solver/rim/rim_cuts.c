/* SPDX-License-Identifier: MIT */
/*
 * Cuts as edges. A loop comes to the place where a cut begins, goes along its left lip to the tip,
 * back along the right one, and on: so what is to be covered stays on its left.
 */
#include "rim_builder.h"

#include "solver/march/cuts.h"
#include "solver/surface/boxes.h"
#include <math.h>
#include <string.h>

/* A cut meets an edge where it comes this near to it, in spacings; one that begins further inside
 * is led to the edge if it is not further away than `snap`. */
static const double contact = 2e-3, snap = 0.5;

/* A cut begins at a vertex that is this near, in spacings. */
static const double at_vertex = 1e-5;

/* Sights of a cut: of its lips, and of the edges behind its mouth and its far end. */
enum { SIGHTS = 4 };

/* Where a lip meets the edges. */
struct meeting {
    size_t loop, piece; /* of the loop's pieces */
    double share;       /* of the way along it */
    size_t vertex;      /* the first of the lip's vertices behind it */
    double distance;
};

/* The shares of two straight pieces at which they are nearest, each within its ends. */
static double nearest_shares(struct vec3 a, struct vec3 b, struct vec3 c, struct vec3 d,
                             double share[2]) {
    struct vec3 u = vec3_sub(b, a), v = vec3_sub(d, c), w = vec3_sub(a, c);
    double uu = vec3_norm2(u), uv = vec3_dot(u, v), vv = vec3_norm2(v);
    double uw = vec3_dot(u, w), vw = vec3_dot(v, w), whole = uu * vv - uv * uv;
    double s = whole > 1e-12 * uu * vv ? (uv * vw - vv * uw) / whole : 0;
    s = fmin(fmax(s, 0), 1);
    double t = vv > 0 ? fmin(fmax((s * uv + vw) / vv, 0), 1) : 0;
    s = uu > 0 ? fmin(fmax((t * uv - uw) / uu, 0), 1) : 0;
    share[0] = s;
    share[1] = t;
    return vec3_distance(vec3_axpy(s, u, a), vec3_axpy(t, v, c));
}

/* Whether what lies left of an edge at a share of it is where a line goes from there. */
static bool leads_inside(struct rim_builder *b, const struct rim_vertex *edge, double share,
                         struct vec3 to) {
    struct rim_edge_point spot;
    rim_edges_point(b->march, &edge[0], &edge[1], fmin(fmax(share, 1e-3), 1 - 1e-3), &spot);
    struct vec3 left = vec3_cross(spot.normal, spot.dr);
    return vec3_dot(left, vec3_sub(to, spot.r)) >= 0;
}

/* What is looked for along the edges for one lip of a cut. */
struct lip_search {
    struct rim_builder *b;
    const struct cut_vertex *lip;
    size_t count;
    double spacing;
    struct box box; /* round the lip and what it may be led to */
    struct meeting mouth, tip;
};

/* Takes a straight piece of an edge, from a to c, as the place where a step of the lip meets it, if
 * that is a better one: the last one that meets at all or, as long as none does, the nearest to the
 * first step. And as that where the tip lies, if it is the nearest. */
static void try_meeting(struct lip_search *s, const struct rim_vertex *edge, struct meeting own,
                        const double t[2], struct vec3 a, struct vec3 c) {
    const struct cut_vertex *lip = s->lip;
    double near = contact * s->spacing, share[2];
    for (size_t k = 0; k + 1 < s->count; k++) {
        size_t ahead = k + 2 < s->count ? k + 2 : s->count - 1;
        own.distance = nearest_shares(a, c, lip[k].r, lip[k + 1].r, share);
        own.share = t[0] + share[0] * (t[1] - t[0]);
        own.vertex = k + 1;
        bool meets = own.distance < near, met = s->mouth.distance < near;
        bool better = meets && met
                          ? own.vertex > s->mouth.vertex ||
                                (own.vertex == s->mouth.vertex && own.distance < s->mouth.distance)
                          : own.distance < s->mouth.distance && (meets || k == 0);
        bool at_tip = k + 2 == s->count && share[1] > 0.5;
        if (better && !at_tip && leads_inside(s->b, edge, own.share, lip[ahead].r))
            s->mouth = own;
    }
    struct vec3 end = lip[s->count - 1].r;
    own.distance = nearest_shares(a, c, end, end, share);
    own.share = t[0] + share[0] * (t[1] - t[0]);
    if (own.distance < s->tip.distance)
        s->tip = own;
}

/* The same of a piece from t[0] to t[1] that may bend: in halves, until they are straight. */
static void try_bent(struct lip_search *s, const struct rim_vertex *edge, struct meeting own,
                     const double t[2], struct vec3 a, struct vec3 c, int halvings) {
    struct rim_edge_point spot;
    double middle = (t[0] + t[1]) / 2, length = vec3_distance(a, c);
    rim_edges_point(s->b->march, &edge[0], &edge[1], middle, &spot);
    double bent = vec3_distance(spot.r, vec3_scale(0.5, vec3_add(a, c)));
    struct vec3 between = vec3_scale(0.5, vec3_add(a, c));
    double reach = length / 2 + 2 * bent;
    if (box_distance2(&s->box, between) > reach * reach)
        return;
    if (bent < contact / 4 * s->spacing || halvings == 0) {
        try_meeting(s, edge, own, t, a, c);
        return;
    }
    const double first[2] = {t[0], middle}, second[2] = {middle, t[1]};
    try_bent(s, edge, own, first, a, spot.r, halvings - 1);
    try_bent(s, edge, own, second, spot.r, c, halvings - 1);
}

/* Where a lip comes from the edges, and where on them its tip is nearest. */
static void find_lip_meetings(struct rim_builder *b, const struct cut *cut, int side,
                              double spacing, struct meeting *mouth, struct meeting *tip) {
    enum { HALVINGS = 16 };
    static const double whole[2] = {0, 1};
    const struct rim_edges *e = b->edges;
    struct lip_search s = {.b = b,
                           .lip = cut->lip[side],
                           .count = cut->count[side],
                           .spacing = spacing,
                           .mouth = {.distance = HUGE_VAL},
                           .tip = {.distance = HUGE_VAL}};
    s.box = box_round(s.lip[0].r, s.lip[0].r, snap * spacing);
    for (size_t k = 1; k < s.count; k++) {
        struct box own = box_round(s.lip[k].r, s.lip[k].r, snap * spacing);
        s.box = box_join(&s.box, &own);
    }
    for (size_t n = 0; n < e->loop_count; n++)
        for (size_t p = 0; p < e->loops[n].count; p++) {
            const struct rim_vertex *edge = &e->vertices[e->loops[n].first + p];
            struct meeting own = {.loop = n, .piece = p};
            if (!edge->leaps)
                try_bent(&s, edge, own, whole, edge[0].r, edge[1].r, HALVINGS);
        }
    *mouth = s.mouth;
    *tip = s.tip;
}

/* Adds a vertex behind others: it is another place than the last one, or the same on another face.
 */
static void push(struct rim_vertex *to, size_t *count, const struct rim_vertex *vertex) {
    if (*count > 0)
        to[*count - 1].leaps = to[*count - 1].face != vertex->face;
    to[(*count)++] = *vertex;
}

/* Adds the vertices of a loop from a place of it round to the same. Where two vertices are that
 * place, on two faces, it is between them. `sight` is that of its first pieces, up to the next cut.
 */
static void push_round(struct rim_builder *b, const struct meeting *at, double spacing,
                       int32_t sight, struct rim_vertex *to, size_t *count) {
    const struct rim_loop *loop = &b->edges->loops[at->loop];
    const struct rim_vertex *v = &b->edges->vertices[loop->first];
    size_t n = loop->count, piece = at->piece, last = (piece + n - 1) % n, begin = *count;
    int32_t old = v[piece].sight;
    struct rim_edge_point spot;
    rim_edges_point(b->march, &v[piece], &v[piece + 1], at->share, &spot);
    struct rim_vertex place = {
        .face = v[piece].face, .uv = {spot.uv[0], spot.uv[1]}, .r = spot.r, .sight = old};
    size_t first = n;
    if (vec3_distance(spot.r, v[piece + 1].r) < at_vertex * spacing)
        first = (piece + 1) % n;
    else if (vec3_distance(spot.r, v[piece].r) < at_vertex * spacing)
        first = v[last].leaps ? last : piece;
    bool between = first == n;
    if (between)
        push(to, count, &place);
    first = between ? piece : first;
    for (size_t k = between || v[first].leaps ? 1 : 0; k <= n; k++) {
        size_t number = first + k;
        /* the loop's last vertex is its first one, by other parameters round a closed direction */
        bool seam = number == n && (v[n].uv[0] != v[0].uv[0] || v[n].uv[1] != v[0].uv[1]);
        if (number < n || seam)
            to[(*count)++] = v[number];
        if (seam)
            to[*count - 1].leaps = true;
        if (number >= n)
            to[(*count)++] = v[number - n];
    }
    if (between)
        push(to, count, &place);
    for (size_t k = begin; k < *count && to[k].sight == old; k++)
        to[k].sight = sight;
    b->edges->lip_of[sight] = b->edges->lip_of[old];
}

/* The parameters of a place of a lip by those of the vertex before it: round closed directions
 * without a jump, as the net is cut open. */
static void go_on_round(const struct rim_builder *b, const struct rim_vertex *before,
                        struct rim_vertex *vertex) {
    const struct surface *surface = rim_edges_surface(b->march, vertex->face);
    for (int k = 0; k < 2 && surface && before->face == vertex->face; k++) {
        const struct surface_axis *axis = &surface->axis[k];
        double turn = surface_axis_length(axis);
        if (axis->closed)
            vertex->uv[k] += turn * round((before->uv[k] - vertex->uv[k]) / turn);
    }
}

/* Adds a lip from vertex number `from` to the one before `end`, or back from there to `from`. */
static void push_lip(const struct rim_builder *b, const struct cut *cut, int side, size_t from,
                     int32_t sight, struct rim_vertex *to, size_t *count) {
    size_t end = cut->count[side];
    to[*count - 1].sight = sight;
    for (size_t k = from; k < end; k++) {
        const struct cut_vertex *own = &cut->lip[side][side ? end - 1 - (k - from) : k];
        struct rim_vertex vertex = {
            .face = own->face, .uv = {own->uv[0], own->uv[1]}, .r = own->r, .sight = sight};
        go_on_round(b, &to[*count - 1], &vertex);
        push(to, count, &vertex);
    }
}

static enum status add_cut(struct rim_builder *b, const struct cut *cut, size_t number,
                           struct cut_fault *fault) {
    struct rim_edges *e = b->edges;
    const double *d = b->march->settings->spacing;
    double spacing = fmin(d[0], d[1]);
    struct meeting mouth[2], tip;
    for (int side = 0; side < 2; side++)
        find_lip_meetings(b, cut, side, spacing, &mouth[side], &tip);
    *fault = (struct cut_fault){.cut = number, .kind = CUT_BEGINS_INSIDE, .at = cut->lip[0][0].r};
    if (!(mouth[0].distance <= snap * spacing && mouth[1].distance <= snap * spacing))
        return STATUS_CUT;
    bool through = tip.distance < contact * spacing;
    *fault = (struct cut_fault){
        .cut = number, .kind = CUT_SPLITS, .at = cut->lip[0][cut->count[0] - 1].r};
    if (through && tip.loop == mouth[0].loop)
        return STATUS_CUT;
    size_t room = 2 * e->vertex_count + cut->count[0] + cut->count[1] + 16, count = 0, kept = 0;
    struct rim_vertex *to = arena_alloc(b->march->arena, room, sizeof *to);
    if (!to)
        return STATUS_OUT_OF_MEMORY;
    int32_t sight = e->sights;
    e->sights += SIGHTS;
    e->lip_of[sight] = (int32_t)number + 1;
    e->lip_of[sight + 1] = -(int32_t)number - 1;
    push_round(b, &mouth[0], spacing, sight + 2, to, &count);
    push_lip(b, cut, 0, mouth[0].vertex, sight, to, &count);
    size_t end = count - 1;
    if (through)
        push_round(b, &tip, spacing, sight + 3, to, &count);
    push_lip(b, cut, 1, mouth[1].vertex, sight + 1, to, &count);
    to[end].leaps = true; /* beside the tip, or onto the other edge */
    to[count - cut->count[1] + mouth[1].vertex - 1].leaps = true;
    push(to, &count, &to[0]);
    to[count - 1].leaps = false;
    struct rim_loop own = {0, count - 1};
    for (size_t n = 0; n < e->loop_count; n++) { /* the other loops as they are */
        struct rim_loop other = e->loops[n];
        if (n == mouth[0].loop || (through && n == tip.loop))
            continue;
        memcpy(to + count, e->vertices + other.first, (other.count + 1) * sizeof *to);
        e->loops[kept++] = (struct rim_loop){count, other.count};
        count += other.count + 1;
    }
    e->loops[kept++] = own;
    e->loop_count = kept;
    e->vertices = to;
    e->vertex_count = count;
    e->vertex_room = room;
    return STATUS_OK;
}

enum status rim_builder_add_cuts(struct rim_builder *b, struct cut_fault *fault) {
    const struct cuts *cuts = b->march->cuts;
    enum status status = STATUS_OK;
    struct rim_edges *e = b->edges;
    size_t sights = (size_t)e->sights + SIGHTS * cuts->count;
    e->lip_of = arena_alloc(b->march->arena, sights, sizeof *e->lip_of);
    if (!e->lip_of)
        return STATUS_OUT_OF_MEMORY;
    for (size_t k = 0; k < cuts->count && status == STATUS_OK; k++)
        status = add_cut(b, &cuts->cut[k], k, fault);
    return status;
}
