/* SPDX-License-Identifier: MIT */
#include "rim_cloth.h"

#include "solver/fishnet/fishnet_geodesic.h"
#include "solver/fishnet/logarithm.h"
#include "solver/march/cuts.h"
#include "solver/net/curtain.h"
#include "solver/surface/spans.h"
#include "solver/wide.h"

/* Patches that are kept, of cells next to each other: a step along the rim is halved again and
 * again. */
enum { PATCHES_ACROSS = 4, PATCHES = PATCHES_ACROSS * PATCHES_ACROSS };

/* And their corners. */
enum { NODES_ACROSS = 4 };

/* How far beyond the net, in spacings, corners are extrapolated at the most: cloth that was not
 * laid past a neck covers nothing behind it. */
enum { LAYERS = 6 };

/* Steps of Newton's method in one patch, and changes from patch to patch. */
enum { STEPS = 12, HOPS = 24, STRICT_HOPS = 6 };

/* A step this small, in spacings, is the last: the next would be its square. */
static const double last_step = 1e-6;

/* By how much a place may lie outside its patch: hardly; where no cell follows, by rounding; where
 * two cells send it to each other, so little that they agree there; and where an extent ends the
 * cloth, by as much as cubics between nodes are beside the yarn: of an edge along it, and of
 * others, which end there or leave the cloth. */
static const double strict = 1e-9, at_end = 1e-6, lax = 2e-2, at_extent = 1e-3, past_extent = 1e-4;

/* How far in spacings a place of the cloth may be from the surface point that it is to be: the
 * height of an arc of a radian over its chord, and a right-angled fold over the middle of a cell.
 */
static const double near_smooth = 0.15, near_rough = 0.6;

/* And where corners of the cell were extrapolated, so that the surface may bend away from it. */
static const double near_extended = 2e-3;

/* An extrapolated edge may differ that much from the spacing. */
static const double longest_edge = 1.6, shortest_edge = 0.4;

/* So near to the tip of a cut, in spacings, cells and their neighbours may reach round it. */
static const double tip_reach = 4;

/* Nodes this far from the place looked at, in spacings, may be asked for. */
static const double sight_reach = 8;

enum status rim_cloth_make(struct march *march, int32_t sights, struct rim_cloth *cloth) {
    *cloth = (struct rim_cloth){.march = march, .view = net_view(march->net)};
    cloth->beyond = arena_alloc(march->arena, (size_t)sights, sizeof *cloth->beyond);
    cloth->patch = cloth->patches = arena_take(march->arena, PATCHES, sizeof *cloth->patches);
    cloth->nodes =
        arena_take(march->arena, (size_t)NODES_ACROSS * NODES_ACROSS, sizeof *cloth->nodes);
    for (int k = 0; cloth->patches && k < PATCHES; k++)
        cloth->patches[k].made = cloth->patches[k].known = false;
    for (int k = 0; k < RIM_SEERS * RIM_SEERS; k++)
        cloth->seers[k].searched = false;
    for (int k = 0; cloth->nodes && k < NODES_ACROSS * NODES_ACROSS; k++)
        cloth->nodes[k].searched = false;
    enum status status =
        cloth->beyond && cloth->patches && cloth->nodes ? STATUS_OK : STATUS_OUT_OF_MEMORY;
    for (int32_t k = 0; k < sights && status == STATUS_OK; k++) {
        cloth->beyond[k] = arena_alloc(march->arena, 1, sizeof *cloth->beyond[k]);
        status = cloth->beyond[k] ? net_make(cloth->beyond[k], march->arena, false)
                                  : STATUS_OUT_OF_MEMORY;
    }
    return status;
}

void rim_cloth_look(struct rim_cloth *cloth, int32_t sight, struct vec3 eye) {
    struct march *march = cloth->march;
    const double *d = march->settings->spacing;
    cloth->sight = sight;
    cloth->eye.jet.r = eye;
    cloth->guarded =
        march->cuts && curtain_is_near(march->cuts->curtain, eye, sight_reach * fmax(d[0], d[1]));
    cloth->at_tip = cloth->guarded && !march->mesh && march_is_near_tip(march, eye, tip_reach);
    if (cloth->at_tip && march_is_beside_tip(march, eye))
        cloth->guarded = cloth->at_tip = cuts_nearest(march, eye, &cloth->eye);
}

bool rim_cloth_sees(const struct rim_cloth *cloth, const struct net_node *node) {
    return !cloth->guarded || !march_is_hidden(cloth->march, node, &cloth->eye);
}

/* The node of the net at (i, j) if it has a place and is seen; else NULL. */
static const struct net_node *seen_node(struct rim_cloth *cloth, int32_t i, int32_t j) {
    const struct net_node *node = net_place(cloth->march->net, i, j);
    return node && rim_cloth_sees(cloth, node) ? node : NULL;
}

/* The same in the view, which is near. */
static const struct net_node *viewed_node(const struct rim_cloth *cloth, int32_t i, int32_t j) {
    const struct net_node *node = net_view_place(&cloth->view, i, j);
    return node && rim_cloth_sees(cloth, node) ? node : NULL;
}

/* ---- corners beyond the net ---- */

/* Whether cloth may go on to (i, j): the net did not end there for another reason than the
 * boundary. */
static bool may_reach(struct rim_cloth *cloth, int32_t i, int32_t j) {
    const struct net_node *node = net_find(cloth->march->net, i, j);
    bool ended = node && node->state == NET_FAILED && node->reason != DRAPE_REASON_BOUNDARY;
    return !ended && march_in_extent(cloth->march, i, j);
}

/* Keeps the corner at (i, j) as one of that layer, or of which so many layers were tried. */
static void keep_corner(struct rim_cloth *cloth, int32_t i, int32_t j, struct net_node corner,
                        int layers) {
    corner.yarns = (uint32_t)layers & NET_YARNS_MOST;
    enum status status = net_put(cloth->beyond[cloth->sight], i, j, &corner);
    cloth->failed = cloth->failed || status != STATUS_OK;
}

/* The corner at (i, j): of the net, or else extrapolated along the yarns from the nodes on each
 * side, as the mean of what those of the highest order say, and at most `layers` beyond it; NULL
 * when it cannot be had. What was tried is kept before the next layer is, as the places beside it
 * ask for each other. */
static const struct net_node *cloth_corner(struct rim_cloth *cloth, int32_t i, int32_t j,
                                           int layers) {
    static const int8_t sides[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
    const struct net_node *node = seen_node(cloth, i, j);
    if (node || layers == 0 || cloth->failed)
        return node;
    node = net_find(cloth->beyond[cloth->sight], i, j);
    int tried = node && node->state == NET_FAILED ? (int)node->yarns : 0;
    if (node && node->state == NET_GHOST)
        return node->yarns <= (uint32_t)layers ? node : NULL;
    if (tried >= layers || !may_reach(cloth, i, j))
        return NULL;
    int count[3] = {0, 0, 0}, best = 0; /* by the order; and that which is taken */
    struct vec3 sum[3] = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
    for (; tried < layers && best == 0; tried++) {
        keep_corner(cloth, i, j, (struct net_node){.state = NET_FAILED}, tried);
        for (int k = 0; k < 4; k++) {
            int di = sides[k][0], dj = sides[k][1];
            const struct net_node *a = cloth_corner(cloth, i - di, j - dj, tried), *b, *c;
            b = a ? cloth_corner(cloth, i - 2 * di, j - 2 * dj, tried) : NULL;
            c = b ? cloth_corner(cloth, i - 3 * di, j - 3 * dj, tried) : NULL;
            double d = cloth->march->settings->spacing[dj != 0];
            if (!b)
                continue;
            int order = a->rough || b->rough || !c || c->rough ? 1 : 2;
            struct vec3 step = vec3_sub(a->r, b->r);
            if (order == 2)
                step = vec3_add(step, vec3_sub(step, vec3_sub(b->r, c->r)));
            double length = vec3_norm(step);
            if (!(length > shortest_edge * d && length < longest_edge * d))
                continue;
            sum[order] = vec3_add(sum[order], vec3_axpy(d / length, step, a->r));
            count[order]++;
        }
        best = count[2] ? 2 : count[1] ? 1 : 0;
    }
    struct net_node made = {.state = best ? NET_GHOST : NET_FAILED};
    if (best)
        made.r = vec3_scale(1.0 / count[best], sum[best]);
    keep_corner(cloth, i, j, made, tried);
    return best ? net_place(cloth->beyond[cloth->sight], i, j) : NULL;
}

/* ---- patches ---- */

/* Four places in a line of a patch, the first of which is the node (i, j): where they stand, how
 * far apart, and which way they go in the net. */
struct line {
    struct vec3 *r;
    ptrdiff_t far;
    int32_t i, j;
    int di, dj;
};

/* Third differences of nodes by which a cubic may still be told from the surface, in spacings: an
 * arc that turns by a fifth of a radian from node to node has 0.04, and the cubic is off by 2e-4.
 */
static const double bent = 0.04;

static struct line line_of(struct rim_patch *patch, bool row, int n) {
    return row ? (struct line){patch->r[n], 1, patch->i - 1, patch->j + n - 1, 1, 0}
               : (struct line){&patch->r[0][n], 4, patch->i + n - 1, patch->j - 1, 0, 1};
}

/* Whether the nodes turn evenly, though edges among them are called rough: along each line, and on
 * to the node before it or after it, since a crease half way between its inner two is not seen in
 * the four alone. */
static bool turns_evenly(const struct rim_cloth *cloth, struct rim_patch *patch) {
    const double *d = cloth->march->settings->spacing;
    double most = bent * fmin(d[0], d[1]);
    for (int n = 0; n < 8; n++) {
        const struct line line = line_of(patch, n % 2, n / 2);
        const struct vec3 *r = line.r;
        struct vec3 third =
            vec3_axpy(3, vec3_sub(r[line.far], r[2 * line.far]), vec3_sub(r[3 * line.far], r[0]));
        const struct net_node *beyond = NULL;
        for (int k = 0; k < 2 && !beyond; k++) {
            ptrdiff_t end = k ? 3 : 0, step = k ? -1 : 1;
            int32_t behind = k ? 4 : -1;
            const struct vec3 *a = &r[end * line.far], *b = a + step * line.far;
            const struct vec3 *c = b + step * line.far;
            beyond = viewed_node(cloth, line.i + behind * line.di, line.j + behind * line.dj);
            if (beyond &&
                !(vec3_norm(vec3_axpy(3, vec3_sub(*a, *b), vec3_sub(*c, beyond->r))) < most))
                return false;
        }
        if (!(vec3_norm(third) < most && beyond))
            return false;
    }
    return true;
}

/* The neighbours of the cell's corners. Where the net has none, the cubic through the other three
 * places of a line and the node behind them goes on to it; of a lower degree where there are fewer.
 */
static void load_neighbours(struct rim_cloth *cloth, struct rim_patch *patch, bool *rough) {
    bool known[4][4], all = true;
    for (int b = 0; b < 4; b++)
        for (int a = 0; a < 4; a++) {
            bool inner = (a == 1 || a == 2) && (b == 1 || b == 2);
            const struct net_node *node =
                inner ? NULL : viewed_node(cloth, patch->i + a - 1, patch->j + b - 1);
            known[b][a] = inner || node;
            all = all && known[b][a];
            if (node) {
                patch->r[b][a] = node->r;
                *rough = *rough || node->rough;
            }
        }
    patch->rough = *rough || (patch->extended && !cloth->march->mesh);
    *rough = *rough && !(all && turns_evenly(cloth, patch));
    for (int k = 0; k < 6; k++) { /* those through the cell first */
        static const int8_t number[6] = {1, 1, 2, 2, 0, 3};
        int n = number[k];
        bool row = k % 2 == 0 || k == 5;
        const struct line line = line_of(patch, row, n);
        const bool has[2] = {known[row ? n : 0][row ? 0 : n] && !*rough,
                             known[row ? n : 3][row ? 3 : n] && !*rough};
        for (int end = 0; end < 2; end++) {
            ptrdiff_t step = end ? -line.far : line.far;
            struct vec3 *r = &line.r[end ? 3 * line.far : 0], a = r[step], b = r[2 * step];
            int32_t behind = end ? -1 : 4;
            if (has[end])
                continue;
            struct vec3 extended = vec3_axpy(2, a, vec3_scale(-1, b)), c = r[3 * step];
            if (has[1 - end]) {
                const struct net_node *d =
                    viewed_node(cloth, line.i + behind * line.di, line.j + behind * line.dj);
                extended = vec3_add(vec3_scale(3, vec3_sub(a, b)), c);
                if (d && !d->rough)
                    extended = vec3_add(extended, vec3_sub(vec3_axpy(3, vec3_sub(c, b), a), d->r));
            }
            *r = extended;
        }
    }
}

const struct rim_patch *rim_cloth_patch(struct rim_cloth *cloth, int32_t i, int32_t j) {
    int at = (j & (PATCHES_ACROSS - 1)) * PATCHES_ACROSS + (i & (PATCHES_ACROSS - 1));
    struct rim_patch *patch = cloth->patch = &cloth->patches[at];
    if (patch->made && patch->i == i && patch->j == j && patch->sight == cloth->sight)
        return patch;
    patch->made = true;
    patch->sight = cloth->sight;
    patch->i = i;
    patch->j = j;
    for (int k = 0; k < 4; k++)
        patch->corner[k].searched = false;
    patch->extended = false;
    patch->known = patch->rough = true;
    net_view_move(&cloth->view, i, j);
    bool rough = false; /* whether one of the cell's corners has rough edges */
    for (int k = 0; k < 4 && patch->known; k++) {
        int a = k & 1, b = k / 2;
        const struct net_node *node = viewed_node(cloth, i + a, j + b);
        patch->extended = patch->extended || !node;
        node = node ? node : cloth_corner(cloth, i + a, j + b, LAYERS);
        patch->known = node;
        if (node)
            patch->r[b + 1][a + 1] = node->r;
        rough = rough || (node && node->rough);
    }
    if (patch->known)
        load_neighbours(cloth, patch, &rough);
    patch->smooth = patch->known && !rough;
    return patch;
}

void rim_cloth_cubics(double t, double of[4], double by[4]) {
    double a = t + 1, b = t - 1, c = t - 2;
    of[0] = -t * b * c / 6;
    of[1] = a * b * c / 2;
    of[2] = -a * t * c / 2;
    of[3] = a * t * b / 6;
    by[0] = -(b * c + t * (b + c)) / 6;
    by[1] = (b * c + a * (b + c)) / 2;
    by[2] = -(t * c + a * (t + c)) / 2;
    by[3] = (t * b + a * (t + b)) / 6;
}

INLINE struct vec3 vec3_of_lanes(vec4 a) {
    return vec3_make(a[0], a[1], a[2]);
}

WIDE_CLONES
void rim_patch_point(const struct rim_patch *patch, double p, double q,
                     struct rim_cloth_point *place) {
    double fp[4], dp[4], fq[4], dq[4];
    rim_cloth_cubics(p - patch->i, fp, dp);
    rim_cloth_cubics(q - patch->j, fq, dq);
    vec4 sum = {0}, by_p = {0}, by_q = {0};
    for (int b = 0; b < 4; b++) {
        vec4 r = {0}, along = {0};
        for (int a = 0; a < 4; a++) {
            const struct vec3 *node = &patch->r[b][a];
            const vec4 at = {node->x, node->y, node->z, 0};
            r = fp[a] * at + r;
            along = dp[a] * at + along;
        }
        sum = fq[b] * r + sum;
        by_p = fq[b] * along + by_p;
        by_q = dq[b] * r + by_q;
    }
    *place = (struct rim_cloth_point){.p = p,
                                      .q = q,
                                      .r = vec3_of_lanes(sum),
                                      .along = {vec3_of_lanes(by_p), vec3_of_lanes(by_q)},
                                      .smooth = patch->smooth,
                                      .rough = patch->rough};
}

/* ---- places ---- */

bool rim_cloth_components(const struct vec3 along[2], struct vec3 step, double ab[2]) {
    const struct vec3 *x = along;
    double e = vec3_norm2(x[0]), f = vec3_dot(x[0], x[1]), g = vec3_norm2(x[1]);
    double s = vec3_dot(step, x[0]), t = vec3_dot(step, x[1]), determinant = e * g - f * f;
    ab[0] = (g * s - f * t) / determinant;
    ab[1] = (e * t - f * s) / determinant;
    return determinant > 1e-4 * e * g;
}

/* Newton's method in one patch; false when it fails, or leaves the patch by far. */
static bool newton_in_patch(const struct rim_patch *patch, struct vec3 r,
                            struct rim_cloth_point *place) {
    double p = place->p, q = place->q, ab[2];
    for (int k = 0; k < STEPS; k++) {
        rim_patch_point(patch, p, q, place);
        if (!rim_cloth_components(place->along, vec3_sub(r, place->r), ab))
            return false;
        p += fmin(fmax(ab[0], -1), 1);
        q += fmin(fmax(ab[1], -1), 1);
        if (fabs(ab[0]) < last_step && fabs(ab[1]) < last_step)
            break;
        if (p < patch->i - 1 || p > patch->i + 2 || q < patch->j - 1 || q > patch->j + 2)
            break;
    }
    place->p = p;
    place->q = q;
    return true;
}

static bool is_within(const struct rim_patch *patch, const struct rim_cloth_point *place,
                      double slack) {
    double x = place->p - patch->i, y = place->q - patch->j;
    return x >= -slack && x <= 1 + slack && y >= -slack && y <= 1 + slack;
}

/* ---- places near rough edges ---- */

/* A yarn that turns by more than this at a node, as a sine, is no arc. */
static const double most_turned = 0.3;

/* How well a place is known from a corner that is far, by the length between them: next to nothing
 * and, where the surface has curvature K of its own, as a share of |K| d^2, by which yarns are
 * other than the arcs that they are taken for. */
static const double seen_accuracy = 1e-4, seen_share = 0.03, seen_most = 1e-2;

/* Finds corner number n of a patch, its yarns by their edges of the cell or, where these are
 * missing, straight through from the other side; false when the net has none. */
static bool find_patch_corner(struct rim_cloth *cloth, struct rim_patch *patch, int n) {
    struct rim_corner *corner = &patch->corner[n];
    if (corner->searched)
        return corner->found;
    *corner = (struct rim_corner){
        .i = patch->i + (n & 1), .j = patch->j + n / 2, .searched = true, .blind = false};
    int at = (corner->j & (NODES_ACROSS - 1)) * NODES_ACROSS + (corner->i & (NODES_ACROSS - 1));
    struct rim_node *node = &cloth->nodes[at];
    if (!node->searched || node->i != corner->i || node->j != corner->j) {
        node->searched = true;
        node->i = corner->i;
        node->j = corner->j;
        node->found = march_point(cloth->march, node->i, node->j, &node->point);
        for (int k = 0; k < 4 && node->found; k++) {
            int family = k / 2, side = k % 2 ? 1 : -1;
            struct vec3 *yarn = &node->yarn[family][k % 2];
            node->has_yarn[family][k % 2] =
                march_yarn(cloth->march, node->i, node->j, family ? 0 : side, family ? side : 0,
                           &node->point, yarn);
            *yarn = vec3_scale(side, *yarn);
        }
    }
    corner->point = node->point;
    corner->found = node->found && seen_node(cloth, node->i, node->j);
    for (int k = 0; k < 2 && node->found; k++) {
        int own = k ? 1 - n / 2 : 1 - (n & 1);
        const struct vec3 *yarn = node->yarn[k];
        const bool *has = node->has_yarn[k];
        double turn = vec3_dot(vec3_cross(yarn[0], yarn[1]), node->point.normal);
        corner->turn[k] = has[0] && has[1] && fabs(turn) < most_turned ? turn : 0;
        corner->yarn[k] = yarn[has[own] ? own : 1 - own];
        corner->found = corner->found && (has[0] || has[1]);
    }
    return corner->found;
}

/* Edges are geodesics, but the yarn that turns by an angle a at a node is an arc, which bulges by
 * a x (1 - x) / 2 between it and the next one. Adds that to p and q, with x and y from the corner,
 * and turns the frame at the corner to how the yarns go there. */
static void bend_yarns(const struct rim_corner *corner, double pq[2],
                       struct rim_cloth_point *frame) {
    double x[2] = {pq[0] - corner->i, pq[1] - corner->j}, ab[2];
    struct vec3 off = {0, 0, 0}, left[2];
    for (int k = 0; k < 2; k++) {
        double far = fmin(fabs(x[k]), 1);
        left[k] =
            vec3_scale(corner->turn[k] / 2, vec3_cross(corner->point.normal, frame->along[k]));
        off = vec3_axpy(far * (1 - far), left[k], off);
    }
    if (!rim_cloth_components(frame->along, off, ab))
        return;
    for (int k = 0; k < 2; k++) {
        double far = fmin(fabs(x[k]), 1);
        pq[k] += ab[k];
        frame->along[k] = vec3_axpy((x[k] < 0 ? 1 : -1) * (1 - 2 * far), left[k], frame->along[k]);
    }
}

/* What a corner says of a place: p and q, and how they change there. */
struct view {
    double pq[2];
    struct vec3 along[2];
};

/* The place `to` by its geodesic from the corner: its logarithm or, with `search`, where that is
 * not to be had, what a search finds. */
static bool see_from(struct rim_cloth *cloth, struct rim_corner *corner,
                     const struct surface_point *to, bool search, struct view *view) {
    const double *d = cloth->march->settings->spacing;
    const struct vec3 *yarn = corner->yarn;
    double *pq = view->pq;
    struct vec3 guess = vec3_axpy((pq[1] - corner->j) * d[1], yarn[1],
                                  vec3_scale((pq[0] - corner->i) * d[0], yarn[0]));
    struct vec3 start = surface_point_tangent(&corner->point, guess), end;
    double length = vec3_norm(guess), ab[2];
    struct rim_cloth_point frame = {
        .along = {vec3_scale(d[0], yarn[0]), vec3_scale(d[1], yarn[1])}};
    pq[0] = corner->i;
    pq[1] = corner->j;
    view->along[0] = frame.along[0];
    view->along[1] = frame.along[1];
    if (vec3_distance(to->jet.r, corner->point.jet.r) < last_step * fmin(d[0], d[1]))
        return true;
    struct logarithm l;
    double gauss = fmax(fabs(surface_point_gauss_curvature(&corner->point)),
                        fabs(surface_point_gauss_curvature(to)));
    double accuracy = fmin(seen_accuracy + seen_share * gauss * (d[0] * d[1]), seen_most);
    if (logarithm_find(&cloth->march->cursor, &corner->point, to, accuracy, &l)) {
        length = l.length;
        start = l.leave;
        end = l.arrive;
    } else if (!search) {
        return false;
    } else {
        corner->blind = corner->blind || !fishnet_geodesic_between(
                                             cloth->march->surface, &cloth->march->cursor,
                                             &corner->point, to, accuracy, &length, &start, &end);
        if (corner->blind)
            return false;
    }
    if (!rim_cloth_components(frame.along, vec3_scale(length, start), ab))
        return false;
    pq[0] += ab[0];
    pq[1] += ab[1];
    bend_yarns(corner, pq, &frame);
    /* carries the yarns of the corner along the geodesic */
    struct vec3 side = vec3_cross(corner->point.normal, start);
    struct vec3 there = vec3_cross(to->normal, end);
    for (int k = 0; k < 2; k++)
        view->along[k] = vec3_axpy(vec3_dot(frame.along[k], start), end,
                                   vec3_scale(vec3_dot(frame.along[k], side), there));
    return true;
}

/* A place so little off what was expected, in spacings, has the weights that it was found by. */
static const double weight_change = 0.05;

/* What the corners of a patch say of a place, as they are asked: without or with a search. */
struct sight {
    bool asked[4][2], seen[4];
    struct view view[4];
};

/* Finds p and q of a place in the patch from those of its corners whose bilinear weight is more
 * than `least_weight`, by which it is the less. Geodesics cost: mostly one is enough, from the
 * nearest corner; from the others where that cannot be had. Searches, which cost as much as fifty
 * logarithms, come last; but on a shell, where the nearest corner may lie on another face, and a
 * further one on this one beyond a notch. */
static bool see(struct rim_cloth *cloth, struct rim_patch *patch, const struct surface_point *to,
                struct sight *sight, struct rim_cloth_point *place) {
    static const double near = 0.24, any = 1e-3;
    double x = fmin(fmax(place->p - patch->i, 0), 1), y = fmin(fmax(place->q - patch->j, 0), 1);
    struct view sum = {.pq = {0, 0}, .along = {{0, 0, 0}, {0, 0, 0}}};
    double weights = 0;
    for (int pass = to->surface->shell ? 2 : 0; pass < 4 && !(weights > 0); pass++) {
        int search = pass / 2;
        double least_weight = pass % 2 ? any : near;
        for (int k = 0; k < 4; k++) {
            struct view *view = &sight->view[k];
            double weight = (k & 1 ? x : 1 - x) * (k / 2 ? y : 1 - y) - least_weight;
            if (weight <= 0)
                continue;
            if (!sight->seen[k] && !sight->asked[k][search]) {
                sight->asked[k][search] = true;
                view->pq[0] = place->p;
                view->pq[1] = place->q;
                sight->seen[k] = find_patch_corner(cloth, patch, k) &&
                                 see_from(cloth, &patch->corner[k], to, search, view);
            }
            if (!sight->seen[k])
                continue;
            weights += weight;
            for (int m = 0; m < 2; m++) {
                sum.pq[m] += weight * view->pq[m];
                sum.along[m] = vec3_axpy(weight, view->along[m], sum.along[m]);
            }
        }
    }
    if (!(weights > 0))
        return false;
    place->p = sum.pq[0] / weights;
    place->q = sum.pq[1] / weights;
    for (int m = 0; m < 2; m++)
        place->along[m] = vec3_scale(1 / weights, sum.along[m]);
    place->r = to->jet.r;
    place->smooth = false;
    place->rough = true;
    place->seen = true;
    return true;
}

/* Beside the tip of a cut, where cells reach over it or have corners behind it: from the nearest
 * node. Not where the net has broken. */
static bool find_at_tip(struct rim_cloth *cloth, const struct rim_edge_point *spot,
                        struct rim_cloth_point *place) {
    struct surface_point to = {.uv = {spot->uv[0], spot->uv[1]}, .jet = spot->jet};
    if (!surface_point_complete(rim_edges_surface(cloth->march, spot->face), &to) ||
        !rim_cloth_see_well(cloth, &to, place))
        return false;
    for (int k = 0; k < 4; k++) {
        int32_t i = (int32_t)floor(place->p) + (k & 1), j = (int32_t)floor(place->q) + k / 2;
        const struct net_node *node = net_find(cloth->march->net, i, j);
        bool failed = node && node->state == NET_FAILED;
        if ((failed && march_breaks_net((enum drape_reason)node->reason)) ||
            !march_in_extent(cloth->march, i, j))
            return false;
    }
    return true;
}

/* The cell of a place that is guessed, in direction k: what is hardly beyond the extent may be in
 * the last one. */
static int32_t cell_along(const struct drape_settings *settings, int k, double x) {
    double low = settings->extent[k][0], high = settings->extent[k][1];
    if (settings->has_extent[k] && low < high && x > low - at_extent && x < high + at_extent)
        x = fmin(fmax(x, low), high - 0.5);
    return (int32_t)floor(x);
}

/* The yarn that ends the cloth in direction k, of index `end`. */
struct last_yarn {
    int k;
    int32_t end;
};

/* The size, across the yarn at a place of it and in spacings, of the difference of its nodes from
 * `from` on with these weights; -1 where the net has not all of them. */
static double difference_across(struct rim_cloth *cloth, const struct last_yarn *yarn, int32_t from,
                                const double *weights, int count,
                                const struct rim_cloth_point *place) {
    struct vec3 sum = {0, 0, 0};
    double ab[2];
    for (int n = 0; n < count; n++) {
        const struct net_node *node =
            seen_node(cloth, yarn->k ? from + n : yarn->end, yarn->k ? yarn->end : from + n);
        if (!node)
            return -1;
        sum = vec3_axpy(weights[n], node->r, sum);
    }
    return rim_cloth_components(place->along, sum, ab) ? fabs(ab[yarn->k]) : -1;
}

/* By how much the last yarn may be beside its arc or cubic in the cell of a place, in spacings
 * across: half the greatest fourth difference of nodes among which are the cell's. At a corner of
 * the angle a half way between two nodes that is a / 4, and the yarn 3 a / 16 beside. Where the net
 * ends there and it goes straight on, by as much as it turns. */
static double doubt_between(struct rim_cloth *cloth, const struct last_yarn *yarn,
                            const struct rim_cloth_point *place) {
    static const double fourth[5] = {1, -4, 6, -4, 1}, second[3] = {1, -2, 1};
    int32_t at = (int32_t)floor(yarn->k ? place->p : place->q);
    double most = -1;
    for (int32_t from = at - 3; from <= at; from++)
        most = fmax(most, difference_across(cloth, yarn, from, fourth, 5, place) / 2);
    for (int side = 0; side < 2 && most < 0; side++)
        most = difference_across(cloth, yarn, side ? at + 1 : at - 2, second, 3, place);
    return fmax(most, 0);
}

/* What is hardly beyond the extent is on the yarn that ends it. */
static void keep_on_last_yarn(struct rim_cloth *cloth, struct vec3 edge,
                              struct rim_cloth_point *place) {
    static const double across = 0.05; /* of an edge along a yarn, as a slope */
    const struct drape_settings *settings = cloth->march->settings;
    double *pq[2] = {&place->p, &place->q}, ab[2];
    if ((!settings->has_extent[0] && !settings->has_extent[1]) ||
        !rim_cloth_components(place->along, edge, ab))
        return;
    for (int k = 0; k < 2; k++)
        for (int side = 0; side < 2 && settings->has_extent[k]; side++) {
            const struct last_yarn yarn = {k, settings->extent[k][side]};
            int32_t end = yarn.end;
            double beyond = (*pq[k] - end) * (side ? 1 : -1);
            bool along = fabs(ab[k]) < across * fabs(ab[1 - k]);
            double most = along ? at_extent : past_extent;
            if (along && beyond >= most && beyond < lax)
                most += doubt_between(cloth, &yarn, place);
            if (beyond < most)
                *pq[k] = side ? fmin(*pq[k], end) : fmax(*pq[k], end);
        }
}

bool rim_cloth_find(struct rim_cloth *cloth, const struct rim_edge_point *spot,
                    struct rim_cloth_point *place) {
    const struct drape_settings *settings = cloth->march->settings;
    const double *d = settings->spacing;
    struct rim_cloth_point last = *place;
    bool found = false; /* a place a little outside a patch that was */
    for (int hop = 0; hop < HOPS; hop++) {
        if (!(fabs(place->p) < 1e9 && fabs(place->q) < 1e9))
            return false;
        if (cloth->at_tip)
            return find_at_tip(cloth, spot, place);
        int32_t i = hop ? (int32_t)floor(place->p) : cell_along(settings, 0, place->p);
        int32_t j = hop ? (int32_t)floor(place->q) : cell_along(settings, 1, place->q);
        (void)rim_cloth_patch(cloth, i, j);
        /* in the patch, or where it leads out of it: in space where that tells it, else along the
         * surface from corners that the net has */
        struct rim_patch *patch = cloth->patch;
        struct rim_cloth_point own = *place;
        struct surface_point to = {.uv = {spot->uv[0], spot->uv[1]}, .jet = spot->jet};
        bool spatial = patch->known && patch->smooth && newton_in_patch(patch, spot->r, &own);
        bool enough = spatial && (!patch->extended ||
                                  vec3_distance(own.r, spot->r) < near_extended * fmin(d[0], d[1]));
        bool seen = !enough && (!patch->smooth || patch->extended);
        for (int k = 0; k < 4 && seen; k++)
            seen = may_reach(cloth, patch->i + (k & 1), patch->j + k / 2);
        seen = seen && !cloth->march->mesh &&
               surface_point_complete(rim_edges_surface(cloth->march, spot->face), &to);
        if (seen) {
            struct sight sight = {.seen = {false}};
            double p = place->p, q = place->q;
            seen = see(cloth, patch, &to, &sight, place);
            /* once more where the place was not the one expected: the weights follow from it */
            if (seen && !(fabs(place->p - p) < weight_change && fabs(place->q - q) < weight_change))
                seen = see(cloth, patch, &to, &sight, place);
        }
        spatial = spatial || (!seen && patch->known && !patch->smooth &&
                              newton_in_patch(patch, spot->r, &own));
        if (!seen && !spatial)
            break;
        if (!seen)
            *place = own;
        keep_on_last_yarn(cloth, spot->dr, place);
        bool within = is_within(patch, place, hop < STRICT_HOPS ? strict : lax);
        if (within || is_within(patch, place, at_end)) {
            last = *place;
            found = true;
        }
        if (within)
            break;
    }
    *place = last;
    return found && vec3_distance(place->r, spot->r) <
                        (place->smooth ? near_smooth : near_rough) * fmax(d[0], d[1]);
}
