/* SPDX-License-Identifier: MIT */
/* One cell of the march from three places of the net. */
#include "march.h"

#include "solver/fishnet/correction.h"
#include "solver/fishnet/fishnet_collocation.h"
#include "solver/fishnet/fishnet_geodesic.h"
#include "solver/fishnet/fishnet_length.h"
#include "solver/fishnet/logarithm.h"
#include "solver/fishnet/rough.h"
#include "solver/fishnet/slide_formulas.h"
#include "solver/fishnet/yarn.h"
#include "solver/shell/crossing.h"
#include <stdlib.h>
#include <string.h>

bool march_point_at(struct march *march, const struct net_node *node, struct surface_point *point) {
    if (!march->mesh)
        return surface_point_at(march_surface(march, node), &march->cursor, node->uv, point);
    struct mesh_point place = {.triangle = (int32_t)node->uv[0], .r = node->r};
    *point = march_mesh_point(march, &place);
    return true;
}

bool march_point(struct march *march, int32_t i, int32_t j, struct surface_point *point) {
    const struct net_node *node = net_place(march->net, i, j);
    return node && march_point_at(march, node, point);
}

bool march_guess_from_before(const struct march *march, const struct march_cell *at, double uv[2]) {
    const struct net_view *before = &march->before;
    const struct net_node *a = net_view_place(before, at->i - at->si, at->j - at->sj);
    const struct net_node *b = net_view_place(before, at->i - at->si, at->j);
    const struct net_node *c = net_view_place(before, at->i, at->j - at->sj);
    const struct net_node *d = net_view_place(before, at->i, at->j);
    if (a && b && c && d && march->surface->shell &&
        !(d->face == a->face && d->face == b->face && d->face == c->face &&
          d->face == march_face(march, at->a) && d->face == march_face(march, at->b) &&
          d->face == march_face(march, at->c)))
        return false;
    for (int k = 0; a && b && c && d && k < 2; k++)
        uv[k] = d->uv[k] + (at->b->uv[k] - b->uv[k]) + (at->c->uv[k] - c->uv[k]) -
                (at->a->uv[k] - a->uv[k]);
    return a && b && c && d;
}

void march_find_corrections(const struct march *march, const struct march_cell *at,
                            struct march_corrections *c) {
    const struct net_view *before = &march->before;
    const double *d = march->settings->spacing;
    int32_t i = at->i, j = at->j;
    c->excess = at->excess;
    c->has[0] = correction_find(before, i - at->si, j, at->si, 0, d[0], &c->of[0]);
    c->has[1] = march->settings->slide == 0 &&
                correction_find(before, i, j - at->sj, 0, at->sj, d[1], &c->of[1]);
}

double march_corrected_chord(struct march_corrections *c, int k, const struct surface_point *from,
                             double curvature, double arc_chord) {
    double chord;
    struct correction *of = &c->of[k];
    if (!c->has[k])
        return k ? arc_chord + c->excess : arc_chord;
    of->whole = of->whole && correction_agrees(of, 0, from, curvature);
    if (!of->whole)
        return correction_sideways(of, from, from, arc_chord);
    return correction_chord(of, &chord) ? chord : arc_chord;
}

/* Gives up corrections that do not agree with the surface at D. Whether there was one. */
static bool drop_corrections(const struct fishnet_cell *cell, const struct surface_point *d,
                             struct march_corrections *c) {
    bool dropped = false;
    for (int k = 0; k < 2; k++) {
        struct vec3 chord = vec3_sub(d->jet.r, (k ? cell->c : cell->b)->jet.r);
        struct correction *of = &c->of[k];
        bool drop = c->has[k] && of->whole &&
                    !correction_agrees(of, 1, d, surface_point_normal_curvature(d, chord));
        of->whole = of->whole && !drop;
        dropped = dropped || drop;
    }
    return dropped;
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

/* Whether the place expected of D lies beyond the boundary by its parameters, and by what of the
 * surface is nearest to it. Beyond a corner at which r_u and r_v are parallel no parameters lead.
 */
static bool pulled_outside(struct march *march, const struct fishnet_cell *cell) {
    struct surface_place there;
    struct vec3 step = vec3_sub(cell->guess, cell->c->jet.r);
    return surface_point_pull(&march->cursor, cell->c, step, &there) &&
           is_outside(march->surface, there.uv);
}

static bool nearest_outside(const struct march *march, const struct fishnet_cell *cell) {
    double uv[2] = {cell->c->uv[0], cell->c->uv[1]};
    (void)surface_nearest_from(march->surface, cell->guess, uv);
    return is_outside(march->surface, uv);
}

/* Whether either says so; on a shell, whether the place expected lies beyond a free edge. */
static bool expected_outside(struct march *march, const struct fishnet_cell *cell) {
    const struct surface_point *c = cell->c;
    struct vec3 step = vec3_sub(cell->guess, c->jet.r);
    struct surface_point there;
    struct crossing crossing;
    if (!march->surface->shell)
        return pulled_outside(march, cell) || nearest_outside(march, cell);
    if (!surface_point_move(&march->cursor, c, step, &there) ||
        !crossing_settle(&march->cursor, &there))
        return false;
    crossing_find(&there, NULL, &crossing);
    return crossing.kind == CROSSING_FREE;
}

const struct net_node *march_node_at(const struct march *march, int32_t i, int32_t j) {
    if (march->arm[0] && j == 0)
        return &march->arm[0][abs(i)];
    if (march->arm[1] && i == 0)
        return &march->arm[1][abs(j)];
    return net_place(march->net, i, j);
}

bool march_yarn(struct march *march, int32_t i, int32_t j, int di, int dj,
                const struct surface_point *point, struct vec3 *direction) {
    struct yarn_place here = {i, j, march_node_at(march, i, j)};
    struct yarn_place there = {i + di, j + dj, march_node_at(march, i + di, j + dj)};
    if (!here.node || !there.node ||
        net_is_parted_to(here.node, there.node, di ? 0 : 1, di + dj > 0))
        return false;
    struct yarn_net yarns = {march->net, march_whole(march), &march->cursor};
    *direction = yarn_leave(&yarns, &here, &there, di ? 0 : 1, di + dj > 0, point);
    return true;
}

bool march_turn_as_at_a(struct march *march, const struct march_cell *at, struct vec3 back[2],
                        struct vec3 start[2]) {
    int32_t i = at->i, j = at->j;
    int si = at->si, sj = at->sj;
    struct vec3 ab, ac;
    if (!march_yarn(march, i - si, j - sj, 0, sj, at->a, &ab) ||
        !march_yarn(march, i - si, j - sj, si, 0, at->a, &ac) ||
        !march_yarn(march, i - si, j, 0, -sj, at->b, &back[0]) ||
        !march_yarn(march, i, j - sj, -si, 0, at->c, &back[1]))
        return false;
    double cosine = vec3_dot(ab, ac), sine = vec3_dot(vec3_cross(ab, ac), at->a->normal);
    for (int k = 0; k < 2; k++) {
        struct vec3 left = vec3_cross((k ? at->c : at->b)->normal, back[k]);
        start[k] = vec3_axpy(k ? sine : -sine, left, vec3_scale(-cosine, back[k]));
    }
    return true;
}

void march_note_edge(struct march *march, int family, int sign, struct vec3 start,
                     struct vec3 end) {
    struct vec3 from = vec3_scale(sign, start), to = vec3_scale(sign, end);
    march->edges.rough |= NET_EDGE_BIT(family, sign < 0);
    march->edges.yarns.edge[family] =
        sign < 0 ? (struct net_edge){to, from} : (struct net_edge){from, to};
}

void march_note_edges(struct march *march, const struct march_cell *at, const struct vec3 start[2],
                      const struct vec3 end[2]) {
    march_note_edge(march, 0, at->si, start[0], end[0]);
    march_note_edge(march, 1, at->sj, start[1], end[1]);
}

/* How far the ends of a rough cell's yarns may be apart, by their length, and for geodesics that
 * are shot how accurate their steps are; of those that only lead to where lengths are measured. */
static const double length_accuracy = 3e-8;
static const double geodesic_accuracy[] = {1e-11, 1e-12}, rough_accuracy[] = {9e-10, 2e-9};
static const double about_accuracy[] = {2e-2, 1e-3};

/* How far from its face a yarn may lie that stays on its continuation, by its length: the way that
 * keeps to the joint between is longer by 8/3 of this squared. */
static const double grazing = 3e-3;

/* Whether a yarn all but keeps to the face on which its ends are, along a joint that bends away
 * from it: geodesics over the joint do not come back. Beyond a free edge it is on the continuation
 * of its face anyway. */
static bool grazes_joint(struct march *march, const struct surface_point *from, struct vec3 start,
                         const struct surface_point *to, double d) {
    struct surface_point middle;
    struct crossing joint;
    if (from->surface != to->surface ||
        !surface_point_move(&march->cursor, from, vec3_scale(d / 2, start), &middle))
        return false;
    crossing_find(&middle, NULL, &joint);
    return joint.kind != CROSSING_JOINT || joint.distance <= grazing * d;
}

/* The geodesics from B and C that meet. One whose chord is longer than it is, but for what two
 * faces leave between them, was led round a corner to another place of its joint, and has been
 * torn. */
static enum fishnet_end meet_as_geodesics(struct march *march, const struct fishnet_cell *cell,
                                          const double accuracy[2], struct fishnet_yarns *yarns,
                                          struct fishnet_node *node) {
    const double *d = march->length;
    const struct shell *shell = march->surface->shell;
    double gap = shell ? 2 * shell_edges(shell).largest_gap : 0;
    enum fishnet_end end = fishnet_geodesic_meet(march->surface, &march->cursor, cell, d[0], d[1],
                                                 accuracy, yarns, node);
    for (int k = 0; k < 2 && end == FISHNET_FOUND; k++)
        if (vec3_distance(node->point.jet.r, (k ? cell->c : cell->b)->jet.r) >
            (1 + MARCH_STRETCH + accuracy[0]) * d[k] + gap)
            end = FISHNET_NO_CONVERGENCE;
    return end;
}

/* Whether a point on the continuation of a face of a shell lies past a joint, on another face. */
static bool lies_over_joint(struct march *march, const struct surface_point *point) {
    const struct shell *shell = point->surface->shell;
    const struct crossing *joint = shell ? march_look_over(march, point) : NULL;
    return joint && joint->kind == CROSSING_JOINT && joint->distance > shell_joint_width(shell);
}

/* Moves a D that is nearly there to where both yarns have their length. Beside a joint it may have
 * moved past that, and lengths were those of the face's continuation. */
static bool measure_yarns(struct march *march, const struct fishnet_cell *cell, double accuracy,
                          struct fishnet_yarns *yarns, struct fishnet_node *node) {
    const double *d = march->length;
    return fishnet_length_meet(&march->cursor, cell, d[0], d[1], accuracy, yarns, node) &&
           !lies_over_joint(march, &node->point);
}

/* The same from D as chords have it and, where that is on a joint along which a yarn comes, so that
 * neither face has all of it, from beside it: from this share of the way to A. */
static bool measure_from_chords(struct march *march, const struct fishnet_cell *cell,
                                struct fishnet_yarns *yarns, struct fishnet_node *node) {
    const double beside = 0.02;
    const struct fishnet_node chords = *node;
    struct surface_point *d = &node->point;
    if (measure_yarns(march, cell, length_accuracy, yarns, node))
        return true;
    *node = chords;
    if (!d->surface->shell)
        return false;
    struct vec3 to_a = vec3_sub(cell->a->jet.r, d->jet.r);
    return surface_point_move(&march->cursor, d, vec3_scale(beside, to_a), d) &&
           crossing_settle(&march->cursor, d) &&
           measure_yarns(march, cell, length_accuracy, yarns, node);
}

/* Geodesics that are shot to about D and measured there, which costs less than a round of accurate
 * ones; or where they cannot be, shot all the way. */
static enum fishnet_end shoot_and_measure(struct march *march, const struct fishnet_cell *cell,
                                          struct fishnet_yarns *yarns, struct fishnet_node *node) {
    enum fishnet_end end = meet_as_geodesics(march, cell, about_accuracy, yarns, node);
    if (end != FISHNET_FOUND)
        return end;
    const struct fishnet_yarns about = *yarns;
    const struct fishnet_node there = *node;
    if (measure_yarns(march, cell, length_accuracy, yarns, node))
        return FISHNET_FOUND;
    *yarns = about;
    *node = there;
    return meet_as_geodesics(march, cell, rough_accuracy, yarns, node);
}

/* A cell with a rough edge: both yarns to D are geodesics of the spacing's length. Where chords led
 * to a D, `found`, it may be enough to measure them. */
static enum fishnet_end solve_rough(struct march *march, const struct march_cell *at,
                                    const struct fishnet_cell *cell, bool found,
                                    struct fishnet_node *node) {
    const double *d = march->length;
    struct fishnet_yarns yarns = {.reach = march_reach(march)};
    struct vec3 back[2];
    bool geodesic = march->method->yarn == DRAPE_YARN_GEODESIC;
    const struct fishnet_collocation wanted = {
        {d[0], d[1]}, geodesic_accuracy[0], march->settings->lanes};
    const struct fishnet_node chords = *node;
    bool measured = false;
    if (found && geodesic) { /* and the yarns cross at D as they do at A */
        measured = fishnet_collocation_solve(&march->cursor, cell, &wanted, &yarns, node) &&
                   cell->orientation *
                           vec3_dot(vec3_cross(yarns.end[0], yarns.end[1]), node->point.normal) >
                       0 &&
                   !lies_over_joint(march, &node->point);
    } else if (found) {
        measured = measure_from_chords(march, cell, &yarns, node);
    }
    if (measured) {
        march_note_edges(march, at, yarns.start, yarns.end);
        return FISHNET_FOUND;
    }
    *node = chords;
    if (!march_turn_as_at_a(march, at, back, yarns.start))
        return FISHNET_NO_CONVERGENCE;
    node->tried = 0;
    const struct fishnet_yarns begun = yarns;
    const double *accuracy = geodesic ? geodesic_accuracy : rough_accuracy;
    enum fishnet_end end = geodesic ? meet_as_geodesics(march, cell, accuracy, &yarns, node)
                                    : shoot_and_measure(march, cell, &yarns, node);
    /* Over a joint that is curved, for one; not where the first rays could not be followed. */
    if (end == FISHNET_NO_CONVERGENCE && geodesic && node->iterations > 0) {
        memcpy(yarns.start, begun.start, sizeof yarns.start);
        end = meet_as_geodesics(march, cell, rough_accuracy, &yarns, node);
    }
    /* One that met a joint stays on the face on which it begins. One that met none would be the
     * same, but for being lost where the continuation is not trusted. */
    const bool tried[2] = {geodesic || yarns.met[0], geodesic || yarns.met[1]};
    for (int k = 0; k < 2 && end == FISHNET_NO_CONVERGENCE && march->surface->shell; k++) {
        if (!tried[k])
            continue;
        yarns = begun;
        yarns.stays[k] = true;
        end = meet_as_geodesics(march, cell, accuracy, &yarns, node);
        if (end == FISHNET_FOUND &&
            !grazes_joint(march, k ? cell->c : cell->b, yarns.start[k], &node->point, d[k]))
            end = FISHNET_NO_CONVERGENCE;
    }
    /* Where the cell shears much, steps from the yarns at A may lead astray. */
    if (end == FISHNET_NO_CONVERGENCE && geodesic && found) {
        *node = chords;
        if (measure_yarns(march, cell, rough_accuracy[0], &yarns, node))
            end = FISHNET_FOUND;
    }
    if (end == FISHNET_FOUND)
        march_note_edges(march, at, yarns.start, yarns.end);
    return end;
}

/* An arc of the curvature at one end that turns by more than this is no yarn's. */
static const double bent_most = 0.5;

/* Whether a cell that found no D by chords may do so by geodesics: one that hangs on a rough edge,
 * whose A, B and C do not lie on one side of a crease, or with B or C on a small radius. Not one
 * that surely leads out of a surface without creases: its continuation is wild there. */
static bool hangs_on_rough(struct march *march, const struct fishnet_cell *cell,
                           enum fishnet_end end) {
    const double *d = march->length;
    const struct surface_point *a = cell->a, *b = cell->b, *c = cell->c;
    if (vec3_dot(a->normal, b->normal) < ROUGH_FOLD_COSINE ||
        vec3_dot(a->normal, c->normal) < ROUGH_FOLD_COSINE)
        return true;
    if (end == FISHNET_NO_CONVERGENCE)
        return true;
    if (fabs(cell->curvature[0]) * d[0] > bent_most || fabs(cell->curvature[1]) * d[1] > bent_most)
        return true;
    return rough_is_rough(a, b, d[1]) || rough_is_rough(a, c, d[0]);
}

enum rough_kind march_edge_chord(const struct march *march, const struct march_corrections *c,
                                 int k, const struct surface_point *from,
                                 const struct surface_point *to, double curvature, double *chord) {
    double d = march->length[k], right = fishnet_arc_chord(d, curvature);
    enum rough_kind kind = rough_edge(from, to, curvature, d, &right);
    if (kind == ROUGH_EDGE || fabs(right - *chord) > ROUGH_FAR_OFF * d)
        return ROUGH_EDGE;
    if (kind == ROUGH_BENT && march->settings->yarn_path == DRAPE_PATH_RELAXATION)
        return ROUGH_NOT; /* arcs along relaxed tangents are what was asked for */
    if (!c->has[k])
        *chord = k ? right + c->excess : right;
    else if (!c->of[k].whole)
        *chord = correction_sideways(&c->of[k], from, to, right);
    return kind;
}

/* Two sides of a joint with this cosine between their normals, or less, are over a crease. */
static const double over_crease = 0.9999;

/* Carries a D that was found on the continuation of a face to where it lies, over a crease of the
 * shell: chords lead back and forth over it just beyond. Whether its edges have to be laid anew. */
static bool lies_over_crease(struct march *march, struct surface_point *d) {
    if (!lies_over_joint(march, d))
        return false;
    struct surface_point beyond = *d;
    if (!crossing_settle(&march->cursor, &beyond) || beyond.surface == d->surface ||
        vec3_dot(beyond.normal, d->normal) > over_crease)
        return false;
    *d = beyond;
    return true;
}

/* For the method basic: straight chords, but over a fold, where no chord as long as the
 * spacing is a yarn's and nets of them end. */
static enum fishnet_end solve_folded(struct march *march, const struct march_cell *at,
                                     const struct fishnet_cell *cell, enum fishnet_end end,
                                     struct fishnet_node *node) {
    const double *d = march->length;
    bool found = end == FISHNET_FOUND;
    bool folded = found ? lies_over_crease(march, &node->point) ||
                              rough_is_fold(cell->b, &node->point, d[0]) ||
                              rough_is_fold(cell->c, &node->point, d[1])
                        : hangs_on_rough(march, cell, end);
    return folded ? solve_rough(march, at, cell, found, node) : end;
}

/* Which edges of a cell are not arcs: all of it `laid` as geodesics, where one is rough; or edges
 * whose directions their chords do not tell. */
struct uneven {
    bool laid, edge[2];
};

/* D by the chords at hand; where weft slides by that which follows from D, and with it its length.
 */
static enum fishnet_end solve_chords(struct march *march, const struct march_cell *at,
                                     struct fishnet_cell *cell, struct fishnet_node *node) {
    cell->slide = at->slide;
    enum fishnet_end end = fishnet_solve(march->surface, &march->cursor, cell, node);
    if (at->slide && end == FISHNET_FOUND) {
        march->length[1] = at->slide->length;
        cell->cd = at->slide->chord;
    }
    cell->slide = NULL; /* CD then has the length that was found */
    return end;
}

/* Lays the edges of a cell that are not smooth, D being where chords of smooth ones meet. Those
 * that are bent get their chords, weft that slides what these are longer than arcs'. */
static enum fishnet_end solve_uneven(struct march *march, const struct march_cell *at,
                                     struct fishnet_cell *cell, const struct march_corrections *c,
                                     enum fishnet_end end, struct fishnet_node *node,
                                     struct uneven *uneven) {
    bool bent = false;
    bool rough = march_is_at_point(march, cell->a->jet.r) ||
                 (end == FISHNET_FOUND ? lies_over_crease(march, &node->point)
                                       : hangs_on_rough(march, cell, end));
    const struct surface_point *d = &node->point;
    const double *spacing = march->length;
    bool look = end == FISHNET_FOUND && !rough &&
                !(rough_is_arc(cell->b, d, cell->curvature[0], spacing[0]) &&
                  rough_is_arc(cell->c, d, cell->curvature[1], spacing[1]));
    for (int k = 0; k < 2 && look && !rough; k++) {
        double *chord = k ? &cell->cd : &cell->bd, before = *chord;
        enum rough_kind kind =
            march_edge_chord(march, c, k, k ? cell->c : cell->b, d, cell->curvature[k], chord);
        rough = kind == ROUGH_EDGE;
        uneven->edge[k] = kind == ROUGH_UNEVEN;
        bent = bent || *chord != before;
        if (k && at->slide)
            at->slide->excess += *chord - before;
    }
    uneven->laid = rough;
    if (rough)
        return solve_rough(march, at, cell, end == FISHNET_FOUND, node);
    double uv[2] = {node->point.uv[0], node->point.uv[1]};
    cell->guess = node->point.jet.r;
    cell->guess_uv = d->surface == cell->c->surface ? uv : NULL;
    if (bent)
        end = solve_chords(march, at, cell, node);
    cell->guess_uv = NULL;
    return end;
}

/* Notes the directions of an uneven edge between D, which is found, and B (k = 0) or C. */
static void note_uneven(struct march *march, const struct march_cell *at, int k,
                        const struct surface_point *d) {
    const struct surface_point *from = k ? at->c : at->b, *end[2] = {from, d};
    struct vec3 leave[2];
    for (int n = 0; n < 2; n++) {
        const struct surface_point *to = end[1 - n];
        const struct rough_end there = {to->surface, to->uv, to->jet.r, NULL};
        leave[n] = march_is_beside_cut(march, d->jet.r)
                       ? yarn_leave_well(march->surface, &march->cursor, end[n], &there)
                       : logarithm_leave(&march->cursor, end[n], &there);
    }
    march_note_edge(march, k, k ? at->sj : at->si, leave[0], vec3_scale(-1, leave[1]));
}

/* By chords first, corrected by the edges BD and CD in the net before where they can be had; then
 * the edges that are not smooth are laid anew, and geodesics in place of arcs where they are asked
 * for. A D that is expected beyond the boundary, and not to be found on the continuation, is a
 * matter of the boundary. */
bool march_solve_lengths(struct march *march, const struct march_cell *from,
                         struct fishnet_node *node, enum drape_reason *reason) {
    const struct drape_settings *s = march->settings;
    struct surface_point corner[3];
    struct march_cell own = *from, *at = &own;
    const struct surface_point **point[3] = {&own.a, &own.b, &own.c};
    for (int k = 0; k < 3 && !march->mesh; k++)
        if (surface_point_in_frame(&march->cursor, *point[k], &corner[k]))
            *point[k] = &corner[k];
    const bool corrects = march->before.net;
    struct vec3 edge = vec3_sub(at->b->jet.r, at->a->jet.r);
    struct fishnet_cell cell = {.a = at->a,
                                .b = at->b,
                                .c = at->c,
                                .guess = vec3_add(at->c->jet.r, vec3_add(edge, at->trend)),
                                .guess_uv = at->guess_uv,
                                .corrects = corrects,
                                .orientation = at->si * at->sj};
    struct march_corrections corrections = {.has = {false, false}};
    enum fishnet_end end = FISHNET_FOUND;
    struct uneven uneven = {.laid = false};
    double uv[2];
    march->edges.rough = 0;
    if (march->mesh)
        return march_mesh_corner(march, at, cell.guess, node, reason);
    if (corrects) {
        net_view_move(&march->before, at->i, at->j);
        if (march_guess_from_before(march, at, uv))
            cell.guess_uv = uv;
        march_find_corrections(march, at, &corrections);
    }
    /* Corrections that do not agree with the surface at D are given up, once. */
    for (int pass = 0; pass < 2; pass++) {
        if (pass > 0 && !(corrects && end == FISHNET_FOUND &&
                          drop_corrections(&cell, &node->point, &corrections)))
            break;
        fishnet_chords(&march->cursor, march->method->yarn, s->yarn_path, march->length, &cell);
        cell.bd = march_corrected_chord(&corrections, 0, cell.b, cell.curvature[0], cell.bd);
        cell.cd = march_corrected_chord(&corrections, 1, cell.c, cell.curvature[1], cell.cd);
        if (at->slide)
            at->slide->curvature = cell.curvature[1];
        end = solve_chords(march, at, &cell, node);
    }
    if (end == FISHNET_FOUND && node->looked)
        march->look = (struct march_look){
            node->point.surface, {node->point.uv[0], node->point.uv[1]}, node->crossing};
    end = march->method->yarn == DRAPE_YARN_CHORD
              ? solve_folded(march, at, &cell, end, node)
              : solve_uneven(march, at, &cell, &corrections, end, node, &uneven);
    if (end == FISHNET_FOUND && march->method->yarn == DRAPE_YARN_GEODESIC && !uneven.laid) {
        const struct fishnet_node chords = *node;
        end = fishnet_geodesic_solve(march->surface, &march->cursor, &cell, march->length, s->lanes,
                                     node);
        /* Over a joint of which chords did not know what does not converge by them may do so from
         * face to face. */
        uneven.laid = end == FISHNET_NO_CONVERGENCE && march->surface->shell;
        if (uneven.laid) {
            *node = chords;
            end = solve_rough(march, at, &cell, true, node);
        }
    }
    for (int k = 0; k < 2 && end == FISHNET_FOUND && !uneven.laid; k++)
        if (uneven.edge[k])
            note_uneven(march, at, k, &node->point);
    if (end == FISHNET_FOUND)
        return true;
    if (end != FISHNET_COLLAPSED && expected_outside(march, &cell))
        *reason = DRAPE_REASON_BOUNDARY;
    else
        *reason = end == FISHNET_COLLAPSED    ? DRAPE_REASON_COLLAPSED
                  : end == FISHNET_DEGENERATE ? DRAPE_REASON_DEGENERATE
                                              : DRAPE_REASON_NO_CONVERGENCE;
    return false;
}

bool march_solve_corner(struct march *march, const struct march_cell *at, struct fishnet_node *node,
                        enum drape_reason *reason) {
    bool found = march->settings->slide > 0 ? march_slide_corner(march, at, node, reason)
                                            : march_solve_lengths(march, at, node, reason);
    if (found)
        march_count_solved(march, (size_t)node->iterations, node->residual);
    return found;
}
