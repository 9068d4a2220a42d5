/* SPDX-License-Identifier: MIT */
/*
 * The body of a wave's kernel, for files that say LANES and the kernel's name WAVE_KERNEL: chords,
 * Newton's method and its checks, as fishnet.c and surface_point.h have them, for as many cells as
 * there are lanes. Cells that need more than that (a step shortened or halved, another root, no
 * tangent plane) are left to the scalar code.
 */
#ifndef SOLVER_MARCH_WAVE_CELLS_H
#define SOLVER_MARCH_WAVE_CELLS_H

#include "solver/fishnet/cell_lanes.h"
#include "solver/fishnet/fishnet.h"
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

/* D: where it is, and the surface there; its numbers as those of a point of the wave. */
struct lanes_corner {
    lanes uv[2];
    struct lanes_jet jet;
    struct lanes3 normal;
    lanes first[3], second[3];
};
_Static_assert(sizeof(struct lanes_corner) == WAVE_NUMBERS * sizeof(lanes), "all of its numbers");

INLINE struct lanes_point point_of(const struct lanes_corner *d) {
    return (struct lanes_point){.jet = {d->jet.r, d->jet.u, d->jet.v},
                                .normal = d->normal,
                                .first = {d->first[0], d->first[1], d->first[2]},
                                .second = {d->second[0], d->second[1], d->second[2]}};
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

/* How long edge k is taken to be. */
INLINE lanes length_of(const struct wave *wave, int k) {
    return k && wave->slide > 0 ? lanes_load(wave->weft) : lanes_of(wave->length[k]);
}

INLINE void arc_chords(struct wave *wave, int k, lanes curvature) {
    lanes_store(curvature, wave->curvature[k]);
    lanes_store(fishnet_arc_chord_lanes(length_of(wave, k), curvature), wave->chord[k]);
}

INLINE void find_chords(struct wave *wave, const struct wave_places *a, const struct wave_places *b,
                        const struct wave_places *c) {
    if (!wave->arcs) {
        for (int k = 0; k < 2; k++) {
            lanes_store(length_of(wave, k), wave->chord[k]);
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

/* As correction_chord, of the edge k from the places `from`; the lanes whose correction holds. */
INLINE lanes_mask correct_chord(struct wave *wave, int k, const struct wave_places *from,
                                lanes *chord) {
    int slot = k ? 0 : 1;
    double d = wave->length[k];
    struct lanes3 near = bend(wave_before_at(wave, k ? wave->lag : 1), slot, k);
    struct lanes3 far = bend(wave_before_at(wave, 0), 1, k);
    const struct lanes_point begin = point_at(from, slot);
    lanes_mask holds;
    lanes_store(far.x, wave->bend[k][0]);
    lanes_store(far.y, wave->bend[k][1]);
    lanes_store(far.z, wave->bend[k][2]);
    *chord = correction_chord_of_lanes(near, far, d, &holds);
    return holds & correction_bend_agrees_lanes(near, d, &begin, lanes_load(wave->curvature[k]));
}

/* As march_guess_from_before and march_corrected_chord. */
INLINE void correct(struct wave *wave, const struct wave_places *a, const struct wave_places *b,
                    const struct wave_places *c) {
    const struct wave_before *a0 = wave_before_at(wave, wave->lag + 1);
    const struct wave_before *b0 = wave_before_at(wave, 1), *d0 = wave_before_at(wave, 0);
    const struct wave_before *c0 = wave_before_at(wave, wave->lag);
    lanes chord[2];
    lanes_mask whole[2], settled = even(d0, 1) & even(b0, 1) & even(c0, 0) & even(a0, 0);
    settled &= correct_chord(wave, 0, b, &chord[0]);
    whole[0] = whole[1] = settled;
    if (wave->slide > 0) {
        whole[1] ^= settled;
        chord[1] = lanes_load(wave->chord[1]) + lanes_load(wave->excess);
    } else {
        settled &= correct_chord(wave, 1, c, &chord[1]);
        whole[0] = whole[1] = settled;
    }
    for (int k = 0; k < 2; k++) {
        lanes uv = lanes_load(&d0->uv[k][1]) +
                   (number(b, 1, AT_U + k) - lanes_load(&b0->uv[k][1])) +
                   (number(c, 0, AT_U + k) - lanes_load(&c0->uv[k][0])) -
                   (number(a, 0, AT_U + k) - lanes_load(&a0->uv[k][0]));
        lanes_store(lanes_select(settled, uv, lanes_load(wave->expected[k])), wave->expected[k]);
        lanes_store(lanes_select(settled, chord[k], lanes_load(wave->chord[k])), wave->chord[k]);
        memcpy(wave->whole[k], &whole[k], sizeof whole[k]);
    }
    wave->settled = lanes_bits(settled);
}

static void prepare(struct wave *wave) {
    const struct wave_places *a = wave_a(wave), *b = wave_b(wave), *c = wave_c(wave);
    add_edges(wave, a, b);
    expect(wave, c);
    find_chords(wave, a, b, c);
    if (wave->corrected)
        correct(wave, a, b, c);
}

/* ---- weft that slides ---- */

/* `joint_angle` of the lanes `over`, which leave C over a joint towards `there`, without a crease.
 */
static __attribute__((noinline)) lanes angle_over_joint(struct wave *wave,
                                                        const struct wave_places *there,
                                                        const struct departure_lanes *near,
                                                        const struct lanes_point *c,
                                                        lanes_mask over, lanes_mask *holds) {
    struct lanes_corner q;
    int first = __builtin_ctz(lanes_bits(over));
    for (int k = 0; k < 2; k++) {
        lanes at = number(there, 0, AT_U + k);
        q.uv[k] = lanes_select(over, at, lanes_of(at[first])); /* all in one span, if they can be */
    }
    lanes_jet_at(wave->surface, wave->cursor, q.uv[0], q.uv[1], &q.jet);
    lanes_mask regular = surface_point_first_form_lanes(wave->surface, &q.jet, q.first, &q.normal);
    surface_point_second_form_lanes(&q.jet, q.normal, q.second);
    const struct lanes_point end = point_of(&q);
    struct departure_lanes far = depart_lanes(&end, lanes3_sub(vector(there, 0, AT_R), c->jet.r),
                                              lanes_of(wave->surface->side));
    *holds &= ~over | (regular & ~is_creased_lanes(near, &far, lanes3_sub(q.normal, c->normal)));
    return joint_angle_lanes(near, &far);
}

/* The unit tangent at C of the fibre towards `there`, as rough_leave; of those where it `holds`. */
INLINE struct lanes3 leave(struct wave *wave, const struct wave_places *there,
                           const struct lanes_point *c, lanes side, lanes_mask *holds) {
    struct departure_lanes d = depart_lanes(c, lanes3_sub(vector(there, 0, AT_R), c->jet.r), side);
    lanes angle = helix_angle_lanes(&d);
    lanes_mask one, over = *holds & is_over_joint_lanes(&d);
    memcpy(&one, wave->one, sizeof one);
    *holds &= (d.c2 > 0) & (~over | one);
    over &= one;
    if (lanes_bits(over))
        angle = lanes_select(over, angle_over_joint(wave, there, &d, c, over, holds), angle);
    return lead_aside_lanes(d.along, angle, c->normal);
}

INLINE void store3(struct lanes3 a, double to[3][WAVE_LANES]) {
    lanes_store(a.x, to[0]);
    lanes_store(a.y, to[1]);
    lanes_store(a.z, to[2]);
}

INLINE struct lanes3 load3(const double from[3][WAVE_LANES]) {
    return (struct lanes3){lanes_load(from[0]), lanes_load(from[1]), lanes_load(from[2])};
}

INLINE lanes_mask even_place(const struct wave_places *at) {
    lanes_mask mask;
    memcpy(&mask, &at->even[0], sizeof mask);
    return mask;
}

/* CD as `lean` has found it. */
INLINE struct slide_lanes slide_of(const struct wave *wave) {
    const lanes none = {0};
    return (struct slide_lanes){.c = wave->slide,
                                .spacing = {wave->length[0], wave->length[1]},
                                .along = load3(wave->along),
                                .across = load3(wave->across),
                                .mean = none,
                                .rate = lanes_load(wave->rate),
                                .foot = none,
                                .curvature = lanes_load(wave->curvature[1]),
                                .excess = lanes_load(wave->excess),
                                .tangent = lanes_load(wave->tangent),
                                .stretch = lanes_load(wave->stretch),
                                .length = lanes_load(wave->weft)};
}

/* As expect_slide of march_slide.c, where the fibre below goes on smoothly to both sides of C and
 * the foot lies beside it. */
static void lean(struct wave *wave) {
    const struct wave_places *a = wave_a(wave), *b = wave_b(wave), *at_c = wave_c(wave);
    const struct wave_places *ahead = wave_at(wave, wave->lag - 1);
    const struct lanes_point c = point_at(at_c, 0);
    const lanes side = lanes_load(wave->side), weft_side = lanes_of(wave->orientation);
    lanes_mask holds = even_place(a) & even_place(at_c) & even_place(ahead);
    struct lanes3 ab = lanes3_sub(vector(b, 1, AT_R), vector(a, 0, AT_R));
    struct lanes3 last = lanes3_sub(vector(wave_at(wave, 2), 1, AT_R),
                                    vector(wave_at(wave, wave->lag + 2), 0, AT_R));
    struct lanes3 back = leave(wave, a, &c, side, &holds);
    struct lanes3 on = leave(wave, ahead, &c, side, &holds);
    struct lanes3 tangent = lanes3_unit(lanes3_sub(on, back));
    struct lanes3 left = lanes3_cross(c.normal, tangent);
    struct departure_lanes weft = depart_lanes(&c, ab, side);
    lanes aside = helix_angle_lanes(&weft);
    store3(lanes3_axpy(-aside, left, tangent), wave->along);
    store3(lanes3_scale(weft_side, lanes3_axpy(aside, tangent, left)), wave->across);
    lanes_store(weft_side * (slide_turn_lanes(back, on, c.normal) / 2), wave->rate);
    struct slide_lanes slide = slide_of(wave);
    slide_expect_lanes(&slide, lanes3_add(ab, lanes3_sub(ab, last)));
    lanes foot_rate, foot = slide_foot_lanes(&slide, &foot_rate);
    lanes_store(slide.tangent, wave->tangent);
    lanes_store(slide.stretch, wave->stretch);
    lanes_store(slide.length, wave->weft);
    wave->plain = lanes_bits(holds & (lanes_abs(foot) <= 1));
}

/* As measure_slide: of D on an arc, whether CD is as long as the law has it. */
INLINE lanes_mask keeps_law(struct slide_lanes *slide, struct lanes3 chord) {
    const lanes length = slide->length;
    slide_settle_lanes(slide, chord);
    return (lanes_abs(slide->tangent) < SLIDE_STEEPEST_TANGENT) &
           (lanes_abs(slide->length - length) <= SLIDE_KEPT * length);
}

/* ---- Newton's method ---- */

/* surface_point_near_pole of surfaces that have poles, out of the way of the others. */
static __attribute__((noinline)) lanes_mask
near_pole(const struct surface *surface, const struct lanes3 *point, const lanes *distance2) {
    return surface_point_near_pole_lanes(surface, *point, *distance2);
}

/* Those of the lanes `going` that settle; D is then where their last evaluation was. */
INLINE lanes_mask newton(struct wave *wave, lanes_mask going, struct corner_lanes *cell,
                         struct slide_lanes *slide, struct lanes_corner *d) {
    lanes_mask ordered = cell->bd < cell->cd;
    lanes least = lanes_select(ordered, cell->bd, cell->cd);
    lanes longest = 2 * lanes_select(ordered, cell->cd, cell->bd), least2 = least * least;
    lanes enough = enough_error_lanes(wave->surface, least);
    lanes previous = lanes_of(HUGE_VAL), none = {0}, share2 = none;
    lanes limit =
        wave->corrected ? lanes_of(FISHNET_CORRECTED_GUESS) : FISHNET_GUESS_SHARE * enough;
    lanes_mask done = none != none;
    cell->iterations = none;
    for (int round = 0; round < WAVE_ROUNDS; round++) {
        lanes_jet_at(wave->surface, wave->cursor, d->uv[0], d->uv[1], &d->jet);
        cell->wb = lanes3_sub(d->jet.r, cell->b);
        cell->wc = lanes3_sub(d->jet.r, cell->c);
        if (slide)
            slide_chord_lanes(cell, slide, going);
        else
            cell->gradient = cell->wc;
        find_error_lanes(cell);
        lanes error = cell->error, step[2];
        cell->iterations += lanes_select(going, lanes_of(1), none);
        lanes_mask end = has_converged_lanes(error, limit, share2, previous);
        done |= going & end;
        going &= ~end & (error < previous);
        if (!lanes_bits(going))
            break;
        going = newton_step_lanes(cell, &d->jet, slide, going, step);
        lanes size2 = spatial_size2_lanes(&d->jet, step);
        going &= size2 <= longest * longest;
        if (wave->surface->has_poles) {
            lanes reach = FISHNET_POLE_STEPS * longest, reach2 = reach * reach;
            going &= ~near_pole(wave->surface, &d->jet.r, &reach2);
        }
        share2 = size2 / least2;
        previous = error;
        limit = enough;
        for (int k = 0; k < 2; k++)
            d->uv[k] = lanes_select(going, d->uv[k] + step[k], d->uv[k]);
    }
    return done;
}

/* ---- D ---- */

INLINE void put_point(struct wave_places *places, const struct lanes_corner *d) {
    const lanes *from = (const lanes *)d;
    _Pragma("GCC unroll 29") for (int n = 0; n < WAVE_NUMBERS; n++)
        lanes_store(from[n], &places->of[n][1]);
}

/* Member by member: copies of the whole take as long as a step of Newton's. */
INLINE void take_cell(struct wave *wave, struct corner_lanes *cell, struct lanes_corner *d) {
    const struct wave_places *a = wave_a(wave), *b = wave_b(wave), *c = wave_c(wave);
    cell->a = vector(a, 0, AT_R);
    cell->b = vector(b, 1, AT_R);
    cell->c = vector(c, 0, AT_R);
    cell->bd = lanes_load(wave->chord[0]);
    cell->cd = lanes_load(wave->chord[1]);
    d->uv[0] = lanes_load(wave->expected[0]);
    d->uv[1] = lanes_load(wave->expected[1]);
    square_chords_lanes(cell);
}

/* Whether D2 at D agrees with it; all where edge k is not corrected as a whole. */
INLINE lanes_mask agrees_at_end(const struct wave *wave, int k, const struct wave_places *d,
                                struct lanes3 chord) {
    lanes_mask whole;
    memcpy(&whole, wave->whole[k], sizeof whole);
    struct lanes3 far = {lanes_load(wave->bend[k][0]), lanes_load(wave->bend[k][1]),
                         lanes_load(wave->bend[k][2])};
    const struct lanes_point at_d = point_at(d, 1);
    return correction_bend_agrees_lanes(far, wave->length[k], &at_d,
                                        surface_point_normal_curvature_lanes(&at_d, chord)) |
           ~whole;
}

/* D of those of the lanes `wanted` that find one from where the cell begins; `slide` as for
 * newton_step. */
INLINE lanes_mask find_corner(struct wave *wave, lanes_mask wanted, struct lanes3 normal_b,
                              struct corner_lanes *cell, struct slide_lanes *slide,
                              struct lanes_corner *d) {
    double sign = wave->orientation;
    lanes_mask found = wanted & (cell->bd > 0) & (cell->cd > 0) &
                       (sign * triangle_turn_lanes(cell->a, cell->c, cell->b, normal_b) > 0);
    const lanes cd = cell->cd;
    found &= newton(wave, wanted, cell, slide, d);
    settle_lanes(cell, slide, d->uv, &d->jet);
    cell->cd = cd; /* by which it was expected */
    found &= surface_point_first_form_lanes(wave->surface, &d->jet, d->first, &d->normal);
    surface_point_second_form_lanes(&d->jet, d->normal, d->second);
    return found & (lanes3_norm2(d->normal) > 0) &
           is_right_root_lanes(cell, d->jet.r, sign, normal_b, d->normal);
}

/* Takes over D of the lanes `choose` from another solution of the cell. */
INLINE void choose_corner(lanes_mask choose, const struct corner_lanes *from,
                          const struct lanes_corner *from_d, struct corner_lanes *cell,
                          struct lanes_corner *d) {
    const lanes *chosen = (const lanes *)from_d;
    lanes *to = (lanes *)d;
    cell->error = lanes_select(choose, from->error, cell->error);
    cell->iterations = lanes_select(choose, from->iterations, cell->iterations);
    for (int n = 0; n < WAVE_NUMBERS; n++)
        to[n] = lanes_select(choose, chosen[n], to[n]);
}

INLINE void choose_slide(lanes_mask choose, const struct slide_lanes *from,
                         struct slide_lanes *to) {
    to->tangent = lanes_select(choose, from->tangent, to->tangent);
    to->stretch = lanes_select(choose, from->stretch, to->stretch);
    to->length = lanes_select(choose, from->length, to->length);
}

/* As solve_uneven where nothing is rough: looks at the edges to D, of which `ends` are the
 * beginnings, of the lanes `uneven`; where one is bent D moves to the end of its chord, weft that
 * slides by what that is longer than an arc's. Those whose edges are laid thereby. */
INLINE lanes_mask lay_bent(struct wave *wave, lanes_mask uneven, const struct lanes_point ends[2],
                           struct slide_lanes *slide, struct corner_lanes *cell,
                           struct lanes_corner *corner) {
    struct corner_lanes again = *cell;
    struct slide_lanes bent_slide;
    struct lanes_corner new_corner = {.uv = {corner->uv[0], corner->uv[1]}};
    const struct lanes_point d = point_of(corner);
    const lanes side[2] = {lanes_of(wave->surface->side), lanes_of(wave->surface->side)};
    lanes_mask laid = uneven, moved = uneven ^ uneven;
    if (slide) {
        bent_slide = *slide;
        again.cd = slide->chord;
    }
    for (int k = 0; k < 2; k++) {
        lanes *chord = k ? &again.cd : &again.bd, before = *chord;
        lanes length = k && slide ? slide->length : lanes_of(wave->length[k]);
        struct edge_kind_lanes kind = find_edge_kind_lanes(
            &ends[k], &d, lanes_load(wave->curvature[k]), length, before, side);
        lanes_mask bent = kind.known & kind.even & ~kind.arc;
        *chord = lanes_select(bent, kind.chord, before);
        laid &= (kind.arc | bent) & (lanes_abs(*chord - before) <= ROUGH_FAR_OFF * length);
        moved |= *chord != before;
        if (k && slide)
            bent_slide.excess += *chord - before;
    }
    moved &= laid;
    if (!lanes_bits(moved))
        return laid;
    square_chords_lanes(&again);
    lanes_mask found =
        find_corner(wave, moved, ends[0].normal, &again, slide ? &bent_slide : NULL, &new_corner);
    choose_corner(found, &again, &new_corner, cell, corner);
    if (slide)
        choose_slide(found, &bent_slide, slide);
    return laid & (found | ~moved);
}

INLINE lanes_mask within(const struct wave *wave, lanes u, lanes v) {
    return (u >= wave->lower[0]) & (u <= wave->upper[0]) & (v >= wave->lower[1]) &
           (v <= wave->upper[1]);
}

/* The lanes whose edges to D, CD of the length `weft`, are arcs; where they are straight chords,
 * not over a fold. */
INLINE lanes_mask are_smooth(const struct wave *wave, const struct lanes_point ends[2],
                             const struct lanes_point *d, lanes weft) {
    if (wave->arcs)
        return rough_is_arc_lanes(&ends[0], d, lanes_load(wave->curvature[0]),
                                  lanes_of(wave->length[0])) &
               rough_is_arc_lanes(&ends[1], d, lanes_load(wave->curvature[1]), weft);
    return (lanes3_dot(ends[0].normal, d->normal) > ROUGH_FOLD_COSINE) &
           (lanes3_dot(ends[1].normal, d->normal) > ROUGH_FOLD_COSINE);
}

static void solve(struct wave *wave) {
    struct corner_lanes cell;
    struct lanes_corner corner;
    lanes_mask active;
    take_cell(wave, &cell, &corner);
    memcpy(&active, wave->active, sizeof active);
    /* Lanes without a cell stay where another is: all in one span, if they can be. */
    corner.uv[0] = lanes_select(active, corner.uv[0], lanes_of(wave->expected[0][wave->lane]));
    corner.uv[1] = lanes_select(active, corner.uv[1], lanes_of(wave->expected[1][wave->lane]));
    if (wave->surface->has_poles) {
        lanes reach2 = lanes_of(wave->pole_reach2);
        active &= ~near_pole(wave->surface, &cell.c, &reach2);
    }
    const bool slides = wave->slide > 0;
    struct slide_lanes slide;
    if (slides)
        slide = slide_of(wave);
    const struct lanes_point ends[2] = {point_at(wave_b(wave), 1), point_at(wave_c(wave), 0)};
    lanes_mask found =
        find_corner(wave, active, ends[0].normal, &cell, slides ? &slide : NULL, &corner);
    const struct lanes_point d = point_of(&corner);
    lanes_mask smooth =
        are_smooth(wave, ends, &d, slides ? slide.length : lanes_of(wave->length[1]));
    lanes_mask uneven = found & ~smooth;
    lanes_mask inside = within(wave, corner.uv[0], corner.uv[1]) &
                        within(wave, lanes_load(wave->expected[0]), lanes_load(wave->expected[1]));
    lanes_store(corner.uv[0], wave->tried[0]);
    lanes_store(corner.uv[1], wave->tried[1]);
    if (wave->arcs && !wave->corrected && lanes_bits(uneven)) {
        smooth |= lay_bent(wave, uneven, ends, slides ? &slide : NULL, &cell, &corner);
        inside &= within(wave, corner.uv[0], corner.uv[1]);
    }
    if (slides)
        smooth &= keeps_law(&slide, lanes3_sub(corner.jet.r, cell.c));
    lanes_store(cell.iterations, wave->iterations);
    lanes_store(cell.error, wave->residual);
    put_point(wave->into, &corner);
    if (wave->corrected) {
        struct lanes3 bd = lanes3_sub(corner.jet.r, cell.b), cd = lanes3_sub(corner.jet.r, cell.c);
        found &= agrees_at_end(wave, 0, wave->into, bd) & agrees_at_end(wave, 1, wave->into, cd);
    }
    wave->found = lanes_bits(found);
    wave->smooth = lanes_bits(smooth);
    wave->inside = lanes_bits(inside);
}

const struct wave_kernel WAVE_KERNEL = {LANES, lean, prepare, solve};

#endif
