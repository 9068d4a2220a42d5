/* SPDX-License-Identifier: MIT */
/*
 * The body of a wave's kernel, for files that say LANES and the kernel's name WAVE_KERNEL: chords,
 * Newton's method and its checks, as fishnet.c and surface_point.h have them, for as many cells as
 * there are lanes. Cells that need more than that (a step shortened or halved, another root, no
 * tangent plane) are left to the scalar code.
 */
#ifndef SOLVER_MARCH_WAVE_CELLS_H
#define SOLVER_MARCH_WAVE_CELLS_H

#include "solver/fishnet/correction.h"
#include "solver/fishnet/fishnet.h"
#include "solver/fishnet/fishnet_limits.h"
#include "solver/fishnet/rough_lanes.h"
#include "solver/surface/evaluate_lanes.h"
#include "wave.h"

/* Where the numbers of a point begin. */
#define MEMBER(member) (offsetof(struct wave_point, member) / sizeof(double))
enum {
    AT_U = MEMBER(uv),
    AT_R = MEMBER(jet.r),
    AT_NORMAL = MEMBER(normal),
    AT_FIRST = MEMBER(first),
    AT_SECOND = MEMBER(second)
};
/* Two are usual; cells that need more than these are left alone. */
enum { WAVE_ROUNDS = 6 };

INLINE lanes number(const struct wave_places *places, int slot, int n) {
    return lanes_load(&places->of[n][slot]);
}

INLINE struct lanes3 vector(const struct wave_places *places, int slot, int n) {
    return (struct lanes3){number(places, slot, n), number(places, slot, n + 1),
                           number(places, slot, n + 2)};
}

INLINE struct lanes_point point_at(const struct wave_places *at, int slot) {
    return (struct lanes_point){
        .jet = {vector(at, slot, AT_R), vector(at, slot, AT_R + 3), vector(at, slot, AT_R + 6)},
        .normal = vector(at, slot, AT_NORMAL),
        .first = {number(at, slot, AT_FIRST), number(at, slot, AT_FIRST + 1),
                  number(at, slot, AT_FIRST + 2)},
        .second = {number(at, slot, AT_SECOND), number(at, slot, AT_SECOND + 1),
                   number(at, slot, AT_SECOND + 2)}};
}

/* ---- what is expected of D ---- */

/* Takes in the edge from the row below at the last place. */
INLINE void add_edges(struct wave *wave, const struct wave_places *a, const struct wave_places *b) {
    for (int k = 0; k < 2; k++) {
        lanes now = number(b, 1, AT_U + k) - number(a, 0, AT_U + k);
        for (int order = 0; order < WAVE_ORDERS; order++) {
            lanes before = lanes_load(wave->difference[order][k]);
            lanes_store(now, wave->difference[order][k]);
            now -= before;
        }
    }
}

INLINE void expect(struct wave *wave, const struct wave_places *c) {
    lanes e = number(c, 0, AT_FIRST), g = number(c, 0, AT_FIRST + 2);
    lanes u = number(c, 0, AT_U), v = number(c, 0, AT_U + 1), last = lanes_of(HUGE_VAL);
    lanes_mask going = last == last;
    for (int order = 0; order < WAVE_ORDERS; order++) {
        lanes du = lanes_load(wave->difference[order][0]);
        lanes dv = lanes_load(wave->difference[order][1]);
        lanes size = du * du * e + dv * dv * g;
        going &= size < last;
        last = size;
        u = lanes_select(going, u + du, u);
        v = lanes_select(going, v + dv, v);
    }
    lanes_store(u, wave->expected[0]);
    lanes_store(v, wave->expected[1]);
}

/* ---- chords ---- */

INLINE void arc_chords(struct wave *wave, int k, lanes curvature) {
    lanes_store(curvature, wave->curvature[k]);
    lanes_store(fishnet_arc_chord_lanes(wave->length[k], curvature), wave->chord[k]);
}

INLINE void find_chords(struct wave *wave, const struct wave_places *a, const struct wave_places *b,
                        const struct wave_places *c) {
    if (!wave->arcs) {
        for (int k = 0; k < 2; k++) {
            lanes_store(lanes_of(wave->length[k]), wave->chord[k]);
            lanes_store(lanes_of(0), wave->curvature[k]);
        }
        return;
    }
    const struct lanes_point at = point_at(a, 0), at_b = point_at(b, 1), at_c = point_at(c, 0);
    struct lanes3 ab =
        surface_point_projection_lanes(&at, lanes3_sub(vector(b, 1, AT_R), at.jet.r));
    struct lanes3 ac =
        surface_point_projection_lanes(&at, lanes3_sub(vector(c, 0, AT_R), at.jet.r));
    arc_chords(wave, 1, surface_point_normal_curvature_lanes(&at_c, ab));
    arc_chords(wave, 0, surface_point_normal_curvature_lanes(&at_b, ac));
}

/* ---- corrections ---- */

INLINE lanes_mask even(const struct wave_before *at, int slot) {
    lanes_mask mask;
    memcpy(&mask, &at->even[slot], sizeof mask);
    return mask;
}

INLINE struct lanes3 bend(const struct wave_before *at, int slot, int k) {
    return (struct lanes3){lanes_load(&at->bend[k][0][slot]), lanes_load(&at->bend[k][1][slot]),
                           lanes_load(&at->bend[k][2][slot])};
}

/* As correction_agrees. */
INLINE lanes_mask agrees(double d, struct lanes3 bend, const struct wave_places *at, int slot,
                         lanes curvature) {
    const struct lanes_point point = point_at(at, slot);
    lanes expected = lanes_abs(curvature) * d * d,
          net = lanes_abs(surface_point_gauss_curvature_lanes(&point)) * d * d;
    lanes miss = lanes_abs(lanes3_dot(bend, vector(at, slot, AT_NORMAL)) - curvature * d * d);
    return (miss <= CORRECTION_SHARE * expected + CORRECTION_LEAST * d) &
           (miss * expected <= CORRECTION_PRODUCT * correction_apart(net) * d * d);
}

/* As correction_chord, of the edge k from the places `from`; the lanes whose correction holds. */
INLINE lanes_mask correct_chord(struct wave *wave, int k, const struct wave_places *from,
                                lanes *chord) {
    int slot = k ? 0 : 1;
    double d = wave->length[k];
    struct lanes3 near = bend(wave_before_at(wave, 1), slot, k);
    struct lanes3 far = bend(wave_before_at(wave, 0), 1, k), change = lanes3_sub(far, near);
    struct lanes3 mean = lanes3_scale(lanes_of(0.5), lanes3_add(near, far));
    lanes m2 = lanes3_norm2(mean);
    lanes across = correction_across(m2, lanes3_dot(mean, change), lanes3_norm2(change));
    lanes share = correction_share(m2 / (d * d), across / (d * d));
    lanes_store(far.x, wave->bend[k][0]);
    lanes_store(far.y, wave->bend[k][1]);
    lanes_store(far.z, wave->bend[k][2]);
    *chord = d * lanes_sqrt(share);
    return (share > CORRECTION_SHORTEST) &
           agrees(d, near, from, slot, lanes_load(wave->curvature[k]));
}

/* As march_guess_from_before and march_corrected_chord. */
INLINE void correct(struct wave *wave, const struct wave_places *a, const struct wave_places *b) {
    const struct wave_before *a0 = wave_before_at(wave, 2), *b0 = wave_before_at(wave, 1);
    const struct wave_before *d0 = wave_before_at(wave, 0);
    lanes chord[2];
    lanes_mask settled = even(d0, 1) & even(b0, 1) & even(b0, 0) & even(a0, 0);
    settled &= correct_chord(wave, 0, b, &chord[0]) & correct_chord(wave, 1, b, &chord[1]);
    for (int k = 0; k < 2; k++) {
        lanes uv = lanes_load(&d0->uv[k][1]) +
                   (number(b, 1, AT_U + k) - lanes_load(&b0->uv[k][1])) +
                   (number(b, 0, AT_U + k) - lanes_load(&b0->uv[k][0])) -
                   (number(a, 0, AT_U + k) - lanes_load(&a0->uv[k][0]));
        lanes_store(lanes_select(settled, uv, lanes_load(wave->expected[k])), wave->expected[k]);
        lanes_store(lanes_select(settled, chord[k], lanes_load(wave->chord[k])), wave->chord[k]);
        memcpy(wave->whole[k], &settled, sizeof settled);
    }
    wave->settled = lanes_bits(settled);
}

static void prepare(struct wave *wave) {
    const struct wave_places *a = wave_at(wave, 2), *b = wave_at(wave, 1);
    add_edges(wave, a, b);
    expect(wave, b);
    find_chords(wave, a, b, b);
    if (wave->corrected)
        correct(wave, a, b);
}

/* ---- Newton's method ---- */

/* As surface_point_near_pole; of surfaces that have poles. */
static __attribute__((noinline)) lanes_mask
near_pole(const struct surface *surface, const struct lanes3 *point, const lanes *distance2) {
    lanes_mask near = lanes_of(0) > lanes_of(0);
    for (int k = 0; k < 4; k++) {
        const struct surface_axis *axis = &surface->axis[k / 2];
        const struct vec3 *at = &axis->pole_point[k % 2];
        struct lanes3 pole = {lanes_of(at->x), lanes_of(at->y), lanes_of(at->z)};
        if (axis->pole[k % 2])
            near |= lanes3_norm2(lanes3_sub(*point, pole)) < *distance2;
    }
    return near;
}

struct lanes_linear {
    lanes a, b, c, d, inverse;
};

INLINE struct lanes_linear linear_make(struct lanes3 u, struct lanes3 v, struct lanes3 wb,
                                       struct lanes3 wc) {
    struct lanes_linear m = {
        lanes3_dot(wb, u), lanes3_dot(wb, v), lanes3_dot(wc, u), lanes3_dot(wc, v), {0}};
    m.inverse = 1 / (m.a * m.d - m.b * m.c);
    return m;
}

struct lanes_step {
    lanes u, v;
};

INLINE struct lanes_step linear_solve(const struct lanes_linear *m, lanes f1, lanes f2) {
    return (struct lanes_step){(m->d * f1 - m->b * f2) * m->inverse,
                               (m->a * f2 - m->c * f1) * m->inverse};
}

/* e by a step on the paraboloid; r_u and r_v there. */
INLINE struct lanes3 model_step(const struct lanes_jet *jet, struct lanes_step s,
                                struct lanes3 *there_u, struct lanes3 *there_v) {
    struct lanes3 u = lanes3_axpy(s.v, jet->uv, lanes3_scale(s.u, jet->uu));
    struct lanes3 v = lanes3_axpy(s.v, jet->vv, lanes3_scale(s.u, jet->uv));
    lanes half = lanes_of(0.5);
    *there_u = lanes3_add(jet->u, u);
    *there_v = lanes3_add(jet->v, v);
    u = lanes3_axpy(half, u, jet->u);
    v = lanes3_axpy(half, v, jet->v);
    return lanes3_axpy(s.v, v, lanes3_scale(s.u, u));
}

/* A cell, and D on the way to it. */
struct lanes_cell {
    struct lanes3 a, b, c;
    lanes bd, cd, bd2, cd2, inverse[2]; /* squares, and one by them */
    lanes u, v;
    struct lanes_jet jet;
    struct lanes3 wb, wc; /* D - B, D - C */
    lanes f[2], error;    /* as newton_step's; the larger relative length error */
    lanes iterations;
};

INLINE void find_error(struct lanes_cell *cell) {
    cell->f[0] = (lanes3_norm2(cell->wb) - cell->bd2) / 2;
    cell->f[1] = (lanes3_norm2(cell->wc) - cell->cd2) / 2;
    lanes b = lanes_abs(cell->f[0]) * cell->inverse[0];
    lanes c = lanes_abs(cell->f[1]) * cell->inverse[1];
    cell->error = lanes_select(b > c, b, c);
}

/* As newton_step, for the lanes in `wanted`, of which those that have no step are taken out. */
INLINE struct lanes_step find_step(const struct lanes_cell *cell, lanes_mask *wanted) {
    const struct lanes_jet *jet = &cell->jet;
    struct lanes_linear linear = linear_make(jet->u, jet->v, cell->wb, cell->wc);
    struct lanes_step step = linear_solve(&linear, -cell->f[0], -cell->f[1]);
    lanes whole = lanes_abs(step.u) + lanes_abs(step.v);
    lanes_mask going = (cell->error > FISHNET_MODEL_LEAST) & *wanted;
    *wanted &= lanes_finite(linear.inverse);
    for (int round = 0; round < FISHNET_MODEL_ROUNDS && lanes_bits(going); round++) {
        struct lanes3 u, v, e = model_step(jet, step, &u, &v);
        lanes half = lanes3_norm2(e) / 2;
        linear = linear_make(u, v, lanes3_add(cell->wb, e), lanes3_add(cell->wc, e));
        struct lanes_step more =
            linear_solve(&linear, -(cell->f[0] + lanes3_dot(cell->wb, e) + half),
                         -(cell->f[1] + lanes3_dot(cell->wc, e) + half));
        lanes size = lanes_abs(more.u) + lanes_abs(more.v);
        going &= lanes_finite(linear.inverse) & (size < 0.5 * whole);
        step.u = lanes_select(going, step.u + more.u, step.u);
        step.v = lanes_select(going, step.v + more.v, step.v);
        going &= size > FISHNET_MODEL_ENOUGH * whole;
    }
    *wanted &= lanes_finite(step.u) & lanes_finite(step.v);
    return step;
}

/* Those of the lanes `going` that settle; D is then where their last evaluation was. */
INLINE lanes_mask newton(struct wave *wave, lanes_mask going, struct lanes_cell *cell) {
    lanes_mask ordered = cell->bd < cell->cd;
    lanes least = lanes_select(ordered, cell->bd, cell->cd);
    lanes longest = 2 * lanes_select(ordered, cell->cd, cell->bd), least2 = least * least;
    lanes enough = FISHNET_TOLERANCE + FISHNET_ROUNDING * wave->surface->magnitude / least;
    lanes previous = lanes_of(HUGE_VAL), none = {0}, share2 = none;
    lanes limit =
        wave->corrected ? lanes_of(FISHNET_CORRECTED_GUESS) : FISHNET_GUESS_SHARE * enough;
    lanes_mask done = none != none;
    cell->iterations = none;
    for (int round = 0; round < WAVE_ROUNDS; round++) {
        lanes_jet_at(wave->surface, wave->cursor, cell->u, cell->v, &cell->jet);
        cell->wb = lanes3_sub(cell->jet.r, cell->b);
        cell->wc = lanes3_sub(cell->jet.r, cell->c);
        find_error(cell);
        lanes error = cell->error, wrong = 6 * error * error;
        cell->iterations += lanes_select(going, lanes_of(1), none);
        lanes_mask end =
            (error <= limit) |
            (wrong * wrong < FISHNET_NEGLIGIBLE * FISHNET_NEGLIGIBLE * share2 * share2 * share2) |
            ((error >= previous) & (error <= FISHNET_STAGNATION));
        done |= going & end;
        going &= ~end & (error < previous);
        if (!lanes_bits(going))
            break;
        struct lanes_step step = find_step(cell, &going);
        lanes size2 =
            lanes3_norm2(lanes3_axpy(step.v, cell->jet.v, lanes3_scale(step.u, cell->jet.u)));
        going &= size2 <= longest * longest;
        if (wave->surface->has_poles) {
            lanes reach = FISHNET_POLE_STEPS * longest, reach2 = reach * reach;
            going &= ~near_pole(wave->surface, &cell->jet.r, &reach2);
        }
        share2 = size2 / least2;
        previous = error;
        limit = enough;
        cell->u = lanes_select(going, cell->u + step.u, cell->u);
        cell->v = lanes_select(going, cell->v + step.v, cell->v);
    }
    return done;
}

/* As fishnet.c's: the last step, on the paraboloid. */
INLINE void settle(struct lanes_cell *cell) {
    struct lanes_jet *jet = &cell->jet;
    struct lanes_linear linear = linear_make(jet->u, jet->v, cell->wb, cell->wc);
    struct lanes_step step = linear_solve(&linear, -cell->f[0], -cell->f[1]);
    lanes_mask moves = (cell->error > FISHNET_SETTLED) & lanes_finite(linear.inverse);
    struct lanes3 u, v, e = model_step(jet, step, &u, &v);
    lanes error = cell->error;
    cell->u = lanes_select(moves, cell->u + step.u, cell->u);
    cell->v = lanes_select(moves, cell->v + step.v, cell->v);
    jet->r = lanes3_select(moves, lanes3_add(jet->r, e), jet->r);
    jet->u = lanes3_select(moves, u, jet->u);
    jet->v = lanes3_select(moves, v, jet->v);
    cell->wb = lanes3_add(cell->wb, e);
    cell->wc = lanes3_add(cell->wc, e);
    find_error(cell);
    cell->error = lanes_select(moves, cell->error, error);
}

/* ---- D ---- */

struct lanes_forms {
    struct lanes3 normal;
    lanes first[3], second[3];
};

/* As surface_point_complete; which lanes have a regular tangent plane. */
INLINE lanes_mask complete(const struct surface *surface, const struct lanes_jet *jet,
                           struct lanes_forms *forms) {
    struct lanes3 cross = lanes3_cross(jet->u, jet->v);
    lanes nu = lanes3_norm2(jet->u), nv = lanes3_norm2(jet->v), area = lanes3_norm2(cross);
    const double *least = surface->least_tangent2;
    forms->first[0] = nu;
    forms->first[1] = lanes3_dot(jet->u, jet->v);
    forms->first[2] = nv;
    forms->normal = lanes3_scale(surface->side / lanes_sqrt(area), cross);
    forms->second[0] = lanes3_dot(jet->uu, forms->normal);
    forms->second[1] = lanes3_dot(jet->uv, forms->normal);
    forms->second[2] = lanes3_dot(jet->vv, forms->normal);
    return (nu > least[0]) & (nv > least[1]) &
           (area > SURFACE_POINT_PARALLEL * SURFACE_POINT_PARALLEL * nu * nv) &
           (lanes3_norm2(forms->normal) > 0);
}

INLINE lanes turn(struct lanes3 p, struct lanes3 q, struct lanes3 r, struct lanes3 normal) {
    return lanes3_dot(lanes3_cross(lanes3_sub(q, p), lanes3_sub(r, p)), normal);
}

INLINE lanes_mask is_convex(struct lanes3 a, struct lanes3 b, struct lanes3 c, struct lanes3 d) {
    struct lanes3 normal = lanes3_cross(lanes3_sub(d, a), lanes3_sub(b, c));
    return (turn(a, c, d, normal) > 0) & (turn(d, b, a, normal) > 0) & (turn(c, d, b, normal) > 0) &
           (turn(b, a, c, normal) > 0);
}

/* As fishnet_right_root. */
INLINE lanes_mask right_root(const struct wave *wave, const struct lanes_cell *cell,
                             struct lanes3 normal_b, struct lanes3 normal_d) {
    struct lanes3 d = cell->jet.r;
    double sign = wave->orientation;
    lanes at_d = sign * turn(cell->c, d, cell->b, normal_d);
    lanes_mask away = (at_d > 0) & (sign * turn(cell->c, d, cell->b, normal_b) > 0);
    lanes_mask open = at_d > FISHNET_OPEN_SINE * cell->bd * cell->cd;
    if (lanes_bits(open) != LANES_ALL)
        open |= (sign * turn(cell->a, cell->c, d, normal_d) > 0) &
                (sign * turn(d, cell->b, cell->a, normal_d) > 0) &
                is_convex(cell->a, cell->b, cell->c, d);
    return away & open;
}

INLINE void put_vector(struct wave_places *places, size_t n, struct lanes3 a) {
    lanes_store(a.x, &places->of[n][1]);
    lanes_store(a.y, &places->of[n + 1][1]);
    lanes_store(a.z, &places->of[n + 2][1]);
}

INLINE void put_point(struct wave_places *places, const struct lanes_cell *cell,
                      const struct lanes_forms *forms) {
    lanes_store(cell->u, &places->of[AT_U][1]);
    lanes_store(cell->v, &places->of[AT_U + 1][1]);
    put_vector(places, MEMBER(jet.r), cell->jet.r);
    put_vector(places, MEMBER(jet.u), cell->jet.u);
    put_vector(places, MEMBER(jet.v), cell->jet.v);
    put_vector(places, MEMBER(jet.uu), cell->jet.uu);
    put_vector(places, MEMBER(jet.uv), cell->jet.uv);
    put_vector(places, MEMBER(jet.vv), cell->jet.vv);
    put_vector(places, AT_NORMAL, forms->normal);
    for (int n = 0; n < 3; n++) {
        lanes_store(forms->first[n], &places->of[AT_FIRST + n][1]);
        lanes_store(forms->second[n], &places->of[AT_SECOND + n][1]);
    }
}

INLINE void square_chords(struct lanes_cell *cell) {
    cell->bd2 = cell->bd * cell->bd;
    cell->cd2 = cell->cd * cell->cd;
    cell->inverse[0] = 1 / cell->bd2;
    cell->inverse[1] = 1 / cell->cd2;
}

/* Member by member: copies of the whole take as long as a step of Newton's. */
INLINE void take_cell(struct wave *wave, struct lanes_cell *cell) {
    const struct wave_places *a = wave_at(wave, 2), *b = wave_at(wave, 1);
    cell->a = vector(a, 0, AT_R);
    cell->b = vector(b, 1, AT_R);
    cell->c = vector(b, 0, AT_R);
    cell->bd = lanes_load(wave->chord[0]);
    cell->cd = lanes_load(wave->chord[1]);
    cell->u = lanes_load(wave->expected[0]);
    cell->v = lanes_load(wave->expected[1]);
    square_chords(cell);
}

/* Whether D2 at D agrees with it; all where edge k is not corrected as a whole. */
INLINE lanes_mask agrees_at_end(const struct wave *wave, int k, const struct wave_places *d,
                                struct lanes3 chord) {
    lanes_mask whole;
    memcpy(&whole, wave->whole[k], sizeof whole);
    struct lanes3 far = {lanes_load(wave->bend[k][0]), lanes_load(wave->bend[k][1]),
                         lanes_load(wave->bend[k][2])};
    const struct lanes_point at_d = point_at(d, 1);
    return agrees(wave->length[k], far, d, 1, surface_point_normal_curvature_lanes(&at_d, chord)) |
           ~whole;
}

INLINE struct lanes_point point_of(const struct lanes_cell *cell, const struct lanes_forms *forms) {
    return (struct lanes_point){.jet = {cell->jet.r, cell->jet.u, cell->jet.v},
                                .normal = forms->normal,
                                .first = {forms->first[0], forms->first[1], forms->first[2]},
                                .second = {forms->second[0], forms->second[1], forms->second[2]}};
}

/* D of those of the lanes `wanted` that find one from where the cell begins. */
INLINE lanes_mask find_corner(struct wave *wave, lanes_mask wanted, struct lanes3 normal_b,
                              struct lanes_cell *cell, struct lanes_forms *forms) {
    double sign = wave->orientation;
    lanes_mask found = wanted & (cell->bd > 0) & (cell->cd > 0) &
                       (sign * turn(cell->a, cell->c, cell->b, normal_b) > 0);
    found &= newton(wave, wanted, cell);
    settle(cell);
    found &= complete(wave->surface, &cell->jet, forms);
    return found & right_root(wave, cell, normal_b, forms->normal);
}

/* Takes over D of the lanes `choose` from another solution of the cell. */
INLINE void choose_corner(lanes_mask choose, const struct lanes_cell *from,
                          const struct lanes_forms *from_forms, struct lanes_cell *cell,
                          struct lanes_forms *forms) {
    struct lanes_jet *to = &cell->jet;
    const struct lanes_jet *jet = &from->jet;
    cell->u = lanes_select(choose, from->u, cell->u);
    cell->v = lanes_select(choose, from->v, cell->v);
    cell->error = lanes_select(choose, from->error, cell->error);
    cell->iterations = lanes_select(choose, from->iterations, cell->iterations);
    to->r = lanes3_select(choose, jet->r, to->r);
    to->u = lanes3_select(choose, jet->u, to->u);
    to->v = lanes3_select(choose, jet->v, to->v);
    to->uu = lanes3_select(choose, jet->uu, to->uu);
    to->uv = lanes3_select(choose, jet->uv, to->uv);
    to->vv = lanes3_select(choose, jet->vv, to->vv);
    forms->normal = lanes3_select(choose, from_forms->normal, forms->normal);
    for (int n = 0; n < 3; n++) {
        forms->first[n] = lanes_select(choose, from_forms->first[n], forms->first[n]);
        forms->second[n] = lanes_select(choose, from_forms->second[n], forms->second[n]);
    }
}

/* As solve_uneven where nothing is rough: looks at the edges to D, of which `ends` are the
 * beginnings, of the lanes `uneven`; where one is bent D moves to the end of its chord. Those whose
 * edges are laid thereby. */
INLINE lanes_mask lay_bent(struct wave *wave, lanes_mask uneven, const struct lanes_point ends[2],
                           struct lanes_cell *cell, struct lanes_forms *forms) {
    struct lanes_cell again = *cell;
    struct lanes_forms new_forms;
    const struct lanes_point d = point_of(cell, forms);
    const lanes side[2] = {lanes_of(wave->surface->side), lanes_of(wave->surface->side)};
    lanes_mask laid = uneven, moved = uneven ^ uneven;
    for (int k = 0; k < 2; k++) {
        lanes *chord = k ? &again.cd : &again.bd, before = *chord;
        double length = wave->length[k];
        struct edge_kind_lanes kind = find_edge_kind_lanes(
            &ends[k], &d, lanes_load(wave->curvature[k]), length, before, side);
        lanes_mask bent = kind.known & kind.even & ~kind.arc;
        *chord = lanes_select(bent, kind.chord, before);
        laid &= (kind.arc | bent) & (lanes_abs(*chord - before) <= ROUGH_FAR_OFF * length);
        moved |= *chord != before;
    }
    moved &= laid;
    if (!lanes_bits(moved))
        return laid;
    square_chords(&again);
    lanes_mask found = find_corner(wave, moved, ends[0].normal, &again, &new_forms);
    choose_corner(found, &again, &new_forms, cell, forms);
    return laid & (found | ~moved);
}

INLINE lanes_mask within(const struct wave *wave, lanes u, lanes v) {
    return (u >= wave->lower[0]) & (u <= wave->upper[0]) & (v >= wave->lower[1]) &
           (v <= wave->upper[1]);
}

static void solve(struct wave *wave) {
    struct lanes_cell cell;
    struct lanes_forms forms;
    lanes_mask active;
    take_cell(wave, &cell);
    memcpy(&active, wave->active, sizeof active);
    /* Lanes without a cell stay where another is: all in one span, if they can be. */
    cell.u = lanes_select(active, cell.u, lanes_of(wave->expected[0][wave->lane]));
    cell.v = lanes_select(active, cell.v, lanes_of(wave->expected[1][wave->lane]));
    if (wave->surface->has_poles) {
        lanes reach2 = lanes_of(wave->pole_reach2);
        active &= ~near_pole(wave->surface, &cell.c, &reach2);
    }
    const struct wave_places *b = wave_at(wave, 1);
    const struct lanes_point ends[2] = {point_at(b, 1), point_at(b, 0)};
    lanes_mask found = find_corner(wave, active, ends[0].normal, &cell, &forms);
    const struct lanes_point d = point_of(&cell, &forms);
    lanes_mask smooth =
        rough_is_arc_lanes(&ends[0], &d, lanes_load(wave->curvature[0]), wave->length[0]) &
        rough_is_arc_lanes(&ends[1], &d, lanes_load(wave->curvature[1]), wave->length[1]);
    lanes_mask uneven = found & ~smooth;
    lanes_mask inside = within(wave, cell.u, cell.v) &
                        within(wave, lanes_load(wave->expected[0]), lanes_load(wave->expected[1]));
    lanes_store(cell.u, wave->tried[0]);
    lanes_store(cell.v, wave->tried[1]);
    if (wave->arcs && !wave->corrected && lanes_bits(uneven)) {
        smooth |= lay_bent(wave, uneven, ends, &cell, &forms);
        inside &= within(wave, cell.u, cell.v);
    }
    lanes_store(cell.iterations, wave->iterations);
    lanes_store(cell.error, wave->residual);
    put_point(wave->into, &cell, &forms);
    if (wave->corrected) {
        struct lanes3 bd = lanes3_sub(cell.jet.r, cell.b), cd = lanes3_sub(cell.jet.r, cell.c);
        found &= agrees_at_end(wave, 0, wave->into, bd) & agrees_at_end(wave, 1, wave->into, cd);
    }
    wave->found = lanes_bits(found);
    wave->smooth = lanes_bits(smooth);
    wave->inside = lanes_bits(inside);
}

const struct wave_kernel WAVE_KERNEL = {LANES, prepare, solve};

#endif
