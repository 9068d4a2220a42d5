/* SPDX-License-Identifier: MIT */
/*
 * Cells of a fabric whose weft slides along its warp (`solver/fishnet/slide.h`). The length of CD
 * follows from the shear there, which D decides: it is found by secants.
 *
 * The shear is measured in the triangle C P D: P is the foot of D's characteristic on the fibre
 * below, l b ahead of C, and T the direction of CP. The fibre's direction comes from P to D, so
 * that the angle between CD and T is that between weft and fibre in the middle of the edge, to
 * second order. What D rests on lies about P, on whichever side of C that is: a march that asked
 * the fibre of D itself for its direction would amplify what short waves there are in it from cell
 * to cell. For the bends of the fibre this is the scheme of Lax and Wendroff.
 */
#include "march.h"

#include "solver/fishnet/slide_formulas.h"
#include <stdlib.h>

enum { ROUNDS = 12, FOOT_MOST = 16 };

/* Where the law is kept no better than this, by the edge, it is not. */
static const double taken = 1e-9;

/* Where a fibre's radius is less than two spacings of weft, or it is sheared by more than 60
 * degrees, its parallels meet: a cell that cannot be solved there has collapsed. */
static const double meets_within = 0.5, meets_beyond = 1.732;

/* The fibre below a cell, as a parabola over its tangent at C: it is `aside` (to the left) at the
 * place `step` from C, counted in spacings away from A, where it has the slope and turns so much a
 * spacing. */
struct fibre {
    struct vec3 tangent, left; /* at C, unit */
    double aside, slope, turn;
    int step;
};

/* The unit tangent at (i, j) of the yarn towards (i + di, j + dj). */
static bool leave_node(struct march *march, int32_t i, int32_t j, int di, int dj,
                       const struct surface_point *point, struct vec3 *leave) {
    const struct net_node *there = march_node_at(march, i + di, j + dj);
    if (!there || (there->state != NET_INSIDE && there->state != NET_GHOST))
        return false;
    if (!march->mesh || march->smooth)
        return march_yarn(march, i, j, di, dj, point, leave);
    *leave = surface_point_tangent(point, vec3_sub(there->r, point->jet.r));
    return vec3_norm2(*leave) > 0;
}

/* The unit tangent of the fibre through (i, j), which is at `point`, going along (di, 0), and the
 * angle by which it turns to the left there; false where one of its neighbours is missing. */
static bool turn_fibre(struct march *march, int32_t i, int32_t j, int di,
                       const struct surface_point *point, struct vec3 *tangent, double *turn) {
    struct vec3 back, ahead;
    if (!leave_node(march, i, j, -di, 0, point, &back) ||
        !leave_node(march, i, j, di, 0, point, &ahead))
        return false;
    *turn = slide_turn(back, ahead, point->normal);
    *tangent = vec3_unit(vec3_sub(ahead, back));
    return true;
}

/* The same at the end of a fibre, too, where it turns as two places before let expect, or one. */
static bool turn_fibre_on(struct march *march, int32_t i, int32_t j, int di,
                          const struct surface_point *point, struct vec3 *tangent, double *turn) {
    struct surface_point before;
    struct vec3 back, other;
    double last[2] = {0, 0};
    int known = 0;
    if (turn_fibre(march, i, j, di, point, tangent, turn))
        return true;
    if (!leave_node(march, i, j, -di, 0, point, &back))
        return false;
    while (known < 1 && di * i - known > 1 &&
           march_point(march, i - (known + 1) * di, j, &before) &&
           turn_fibre(march, i - (known + 1) * di, j, di, &before, &other, &last[known]))
        known++;
    *turn = known == 2 ? 2 * last[0] - last[1] : last[0];
    *tangent =
        vec3_unit(vec3_axpy(*turn / 2, vec3_cross(back, point->normal), vec3_scale(-1, back)));
    return true;
}

/* Lays the parabola about the place nearest to the foot, which is about `foot` spacings from C, or
 * as near to it as the net goes. Feet next to C are near enough to it. */
static bool lay_fibre(struct march *march, const struct march_cell *at, double foot,
                      struct fibre *f) {
    int32_t j = at->j - at->sj;
    int side = foot < 0 ? -1 : 1,
        steps = fabs(foot) > 1 ? (int)fmin(fabs(foot) + 0.5, FOOT_MOST) : 0;
    *f = (struct fibre){.step = 0};
    if (!turn_fibre_on(march, at->i, j, at->si, at->c, &f->tangent, &f->turn))
        return false;
    f->left = vec3_cross(at->c->normal, f->tangent);
    for (int step = side; abs(step) <= steps; step += side) {
        int32_t i = at->i + step * at->si;
        struct surface_point point;
        struct vec3 tangent;
        double edge = f->slope + side * f->turn / 2, turn;
        const struct net_node *node = i * at->si > 0 ? march_node_at(march, i, j) : NULL;
        if (!node || (node->state != NET_INSIDE && node->state != NET_GHOST) ||
            !march_point_at(march, node, &point) ||
            !turn_fibre_on(march, i, j, at->si, &point, &tangent, &turn))
            break;
        *f = (struct fibre){f->tangent, f->left, f->aside + side * edge, edge + side * turn / 2,
                            turn,       step};
    }
    return true;
}

/* What a cell's fibre has to do with its weft: the slope of the line from C to the foot, which is
 * about `foot` spacings ahead, and the components of chords like AB's. */
static struct slide make_slide(const struct march *march, const struct march_cell *at,
                               const struct fibre *f, double foot) {
    const struct drape_settings *s = march->settings;
    struct vec3 ab = vec3_sub(at->b->jet.r, at->a->jet.r);
    double aside = march->mesh && !march->smooth ? 0 : rough_aside(at->c, ab);
    double side = at->si * at->sj; /* 1: weft is to the left of the fibre */
    struct slide slide = {.c = s->slide,
                          .spacing = {s->spacing[0], s->spacing[1]},
                          .along = vec3_axpy(-aside, f->left, f->tangent),
                          .across = vec3_scale(side, vec3_axpy(aside, f->tangent, f->left)),
                          .rate = side * (f->turn / 2),
                          .excess = at->excess};
    if (f->step != 0) {
        double from = foot - f->step;
        double mean = (f->aside + from * (f->slope + from * f->turn / 2)) / foot;
        slide.mean = side * mean;
        slide.rate = side * (f->slope + from * f->turn - mean) / foot;
        slide.foot = foot;
    }
    return slide;
}

/* CD as D is expected, by the trend. */
static struct vec3 expected_edge(const struct march_cell *at) {
    return vec3_add(vec3_sub(at->b->jet.r, at->a->jet.r), at->trend);
}

/* How that lies to the fibre below it, taken by its turn at C. */
static bool lean_slide(struct march *march, const struct march_cell *at, struct slide *slide,
                       struct fibre *fibre) {
    if (!lay_fibre(march, at, 0, fibre))
        return false;
    *slide = make_slide(march, at, fibre, 0);
    slide_expect(slide, expected_edge(at));
    return true;
}

/* Where the foot is about, in spacings of warp ahead of C. */
static double foot_of(const struct slide *slide) {
    double rate;
    return slide_foot(slide, &rate);
}

/* The same, the fibre being followed as far as to the foot. */
static bool expect_slide(struct march *march, const struct march_cell *at, struct slide *slide,
                         struct fibre *fibre) {
    if (!lean_slide(march, at, slide, fibre))
        return false;
    double tangent = slide->tangent, foot = foot_of(slide);
    if (fabs(foot) > 1) {
        if (!lay_fibre(march, at, foot, fibre))
            return false;
        *slide = make_slide(march, at, fibre, foot);
        slide_set(slide, tangent);
        slide_settle(slide, expected_edge(at));
    }
    return true;
}

bool march_slide_rests_far(struct march *march, const struct march_cell *at) {
    struct slide slide;
    struct fibre fibre;
    return lean_slide(march, at, &slide, &fibre) && foot_of(&slide) > 1;
}

/* Of CD as it was laid: by its chord, a rough or uneven one by how it leaves C. */
static void measure_slide(struct march *march, const struct march_cell *at,
                          const struct surface_point *d, struct slide *slide) {
    const struct net_edge *edge = &march->edges.yarns.edge[1];
    if (!(march->edges.rough & NET_EDGE_BIT(1, at->sj < 0))) {
        slide_settle(slide, vec3_sub(d->jet.r, at->c->jet.r));
        return;
    }
    struct vec3 leave = at->sj < 0 ? vec3_scale(-1, edge->higher) : edge->lower;
    double aside = rough_aside(at->c, vec3_sub(at->b->jet.r, at->a->jet.r));
    slide_settle(slide, vec3_axpy(-aside, vec3_cross(at->c->normal, leave), leave));
}

/* Whether parallels meet about a cell whose fibre and weft were expected like this. */
static bool parallels_meet(const struct march *march, const struct march_cell *at,
                           const struct fibre *fibre, struct slide slide) {
    const double *d = march->settings->spacing;
    slide_settle(&slide, expected_edge(at));
    return fabs(fibre->turn) * d[1] > meets_within * d[0] || fabs(slide.tangent) > meets_beyond;
}

bool march_slide_corner(struct march *march, const struct march_cell *from,
                        struct fishnet_node *node, enum drape_reason *reason) {
    const double *d = march->settings->spacing;
    struct march_cell at = *from;
    struct slide slide;
    struct fibre fibre;
    double last_length = 0, last_miss = 0, miss = HUGE_VAL, uv[2];
    int iterations = 0;
    *reason = DRAPE_REASON_DEGENERATE;
    at.excess = march->before.net ? march_slide_excess(march, &at) : 0;
    if (!expect_slide(march, &at, &slide, &fibre))
        return false;
    /* Newton's method finds the length of smooth edges with D; secants that of others. */
    at.slide = march->mesh ? NULL : &slide;
    double length = slide.length;
    const struct slide expected = slide;
    for (int round = 0; round < ROUNDS && !(fabs(miss) <= SLIDE_KEPT * length); round++) {
        march->length[1] = length;
        bool found = march_solve_lengths(march, &at, node, reason);
        length = march->length[1];
        march->length[1] = d[1];
        if (!found) {
            if (*reason == DRAPE_REASON_NO_CONVERGENCE &&
                parallels_meet(march, from, &fibre, expected))
                *reason = DRAPE_REASON_COLLAPSED;
            return false;
        }
        at.slide = NULL;
        iterations += node->iterations;
        measure_slide(march, &at, &node->point, &slide);
        *reason = DRAPE_REASON_COLLAPSED;
        if (!(fabs(slide.tangent) < SLIDE_STEEPEST_TANGENT))
            return false;
        miss = slide.length - length;
        double rate = 1 + slide.c * slide.tangent * slide.tangent;
        double secant = (last_miss - miss) / (length - last_length);
        if (round > 0 && secant > rate / 4 && secant < 4 * rate)
            rate = secant;
        last_length = length;
        last_miss = miss;
        if (fabs(miss) <= SLIDE_KEPT * length)
            break;
        length += miss / rate;
        at.trend =
            vec3_sub(vec3_sub(node->point.jet.r, at.c->jet.r), vec3_sub(at.b->jet.r, at.a->jet.r));
        uv[0] = node->point.uv[0];
        uv[1] = node->point.uv[1];
        at.guess_uv = !march->mesh && node->point.surface == at.c->surface ? uv : NULL;
    }
    node->iterations = iterations;
    if (fabs(miss) <= taken * length)
        return true;
    if (!parallels_meet(march, from, &fibre, expected))
        *reason = DRAPE_REASON_NO_CONVERGENCE;
    return false;
}

double march_slide_length(struct march *march, int32_t i, int32_t j,
                          const struct surface_point *point, struct vec3 weft) {
    double c = march->settings->slide, b = march->settings->spacing[1], turn;
    struct vec3 tangent;
    int di = leave_node(march, i, j, -1, 0, point, &tangent) ? 1 : -1;
    if (!(c > 0) || !turn_fibre_on(march, i, j, di, point, &tangent, &turn))
        return b;
    double sine = vec3_dot(vec3_unit(surface_point_projection(point, weft)), tangent);
    return b * slide_stretch(c, fmax(fmin(sine, SLIDE_STEEPEST), -SLIDE_STEEPEST));
}

/* ---- the correction of a net before ---- */

enum { STENCIL = 5, LINE = 4 };

/* Its node at (i, j) in the quadrant of a cell, by numbers counted away from the start; NULL where
 * it has none, or none that differences hold at. */
static const struct net_node *smooth_node(const struct march *march, const struct march_cell *at,
                                          int32_t i, int32_t j) {
    const struct net_node *node =
        i >= 0 && j >= 0 ? net_view_place(&march->before, i * at->si, j * at->sj) : NULL;
    return node && !node->rough && !node->grown && !node->beside ? node : NULL;
}

/* The derivative along warp (family 0) or weft at (i, j), of fourth order: centred, or as far to
 * one side as the quadrant asks, beyond which the net's error has a kink. */
static bool smooth_derivative(const struct march *march, const struct march_cell *at, int32_t i,
                              int32_t j, int family, struct vec3 *derivative) {
    static const double weights[STENCIL][STENCIL] = {{-25, 48, -36, 16, -3},
                                                     {-3, -10, 18, -6, 1},
                                                     {1, -8, 0, 8, -1},
                                                     {-1, 6, -18, 10, 3},
                                                     {3, -16, 36, -48, 25}};
    static const int8_t order[STENCIL] = {2, 1, 3, 0, 4};
    for (int n = 0; n < STENCIL; n++) {
        int own = order[n], k = 0;
        struct vec3 sum = {0, 0, 0};
        for (; k < STENCIL; k++) {
            const struct net_node *node =
                smooth_node(march, at, family ? i : i + k - own, family ? j + k - own : j);
            if (!node)
                break;
            sum = vec3_axpy(weights[own][k] / 12, node->r, sum);
        }
        *derivative = sum;
        if (k == STENCIL)
            return true;
    }
    return false;
}

/* |r_t|^2 at (i, j) by the law. */
static bool lawful_square(const struct march *march, const struct march_cell *at, int32_t i,
                          int32_t j, double *square) {
    struct vec3 s, t;
    if (!smooth_derivative(march, at, i, j, 0, &s) || !smooth_derivative(march, at, i, j, 1, &t))
        return false;
    double dot = vec3_dot(s, t), sine2 = dot * dot / (vec3_norm2(s) * vec3_norm2(t));
    double length =
        march->settings->spacing[1] *
        slide_stretch(march->settings->slide, sqrt(fmin(sine2, SLIDE_STEEPEST * SLIDE_STEEPEST)));
    *square = length * length;
    return true;
}

/* With r_t in the middle of the edge and D3 the third difference about it, |chord|^2 = |r_t|^2 +
 * chord . D3 / 12 - |D3|^2 / 90: to order b^6, and on circles and helices to order b^8. */
double march_slide_excess(struct march *march, const struct march_cell *at) {
    static const double middle[LINE - 1][LINE] = {{5, 15, -5, 1}, {-1, 9, 9, -1}, {1, -5, 15, 5}};
    static const int8_t order[LINE - 1] = {1, 0, 2}, third[LINE] = {-1, 3, -3, 1};
    int32_t i = at->i * at->si, j = at->j * at->sj - 1;
    net_view_move(&march->before, at->i, at->j);
    for (int n = 0; n < LINE - 1; n++) {
        int own = order[n], k = 0;
        const struct net_node *node[LINE];
        struct vec3 bend = {0, 0, 0};
        double square = 0;
        for (; k < LINE; k++) {
            double lawful;
            node[k] = smooth_node(march, at, i, j + k - own);
            if (!node[k] || !lawful_square(march, at, i, j + k - own, &lawful))
                break;
            square += middle[own][k] / 16 * lawful;
            bend = vec3_axpy(third[k], node[k]->r, bend);
        }
        if (k < LINE)
            continue;
        struct vec3 chord = vec3_sub(node[own + 1]->r, node[own]->r);
        square += vec3_dot(chord, bend) / 12 - vec3_norm2(bend) / 90;
        return square > 0 ? sqrt(square) - vec3_norm(chord) : 0;
    }
    return 0;
}
