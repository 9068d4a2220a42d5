/* SPDX-License-Identifier: MIT */
#include "rough.h"

#define LANES 2 /* the two ends of an edge */
#include "solver/angle.h"
#include "solver/lanes.h"
#include "solver/surface/spans.h"

/* At a pole, where there is no curvature, arcs rise alike at both ends, but for this. */
static const double pole_misfit = 2.5e-2;

/* There is a crease between ends where the surface turns by more than this angle and twice what it
 * bends. */
static const double least_fold = 1e-3;

/* An edge that rises by so much else than the curvature at its end says, as a share of that or of
 * the edge, lies on the other side of a joint there. */
static const double other_side = 0.2;
static const double least_rise = 5e-4;

/* How the surface bends along a direction t and across it: II(t, t), II(t, n x t) and II(n x t, n x
 * t), the normal curvatures and the geodesic torsion. */
struct bend {
    double curvature, torsion, across;
};

/* Along the unit tangent t. With t = a r_u + b r_v and D = sqrt(E G - F^2), n x t has the
 * components
 * -(a F + b G) / D and (a E + b F) / D, where n is along r_u x r_v. */
static struct bend bend_along(const struct surface_point *p, struct vec3 t) {
    double ab[2];
    const double *i = p->first, *ii = p->second;
    if (!surface_point_components(p, t, ab))
        return (struct bend){0, 0, 0};
    double side = p->surface ? p->surface->side : 1;
    double scale = side / sqrt(surface_point_determinant(p));
    const double n[2] = {-(ab[0] * i[1] + ab[1] * i[2]) * scale,
                         (ab[0] * i[0] + ab[1] * i[1]) * scale};
    return (struct bend){surface_point_form(ii, ab),
                         ab[0] * n[0] * ii[0] + (ab[0] * n[1] + ab[1] * n[0]) * ii[1] +
                             ab[1] * n[1] * ii[2],
                         surface_point_form(ii, n)};
}

/* A direction in the tangent plane at `from` in that at `to`, unfolded about the line in which they
 * meet: turned as the one normal into the other. */
static struct vec3 unfolded(struct vec3 direction, struct vec3 from, struct vec3 to) {
    struct vec3 axis = vec3_cross(from, to);
    double cosine = vec3_dot(from, to), along = vec3_dot(axis, direction) / (1 + cosine);
    struct vec3 turned = vec3_add(vec3_scale(cosine, direction), vec3_cross(axis, direction));
    return cosine > -0.9 ? vec3_axpy(along, axis, turned) : direction;
}

/* The angle between the projected chord of a geodesic, c long, and the geodesic itself, taken as a
 * helix, to fourth order; `bend` is that along the chord, from which that along the helix differs
 * by that angle. */
static double helix_angle(const struct bend *bend, double c2) {
    double curvature = bend->curvature, torsion = bend->torsion,
           angle = curvature * torsion * c2 / 6;
    double k2 = curvature * curvature, t2 = torsion * torsion;
    double k = curvature + 2 * torsion * angle, t = torsion + (bend->across - curvature) * angle;
    double d2 = c2 * (1 + k2 * c2 / 12);
    return k * t * d2 / 6 * (1 + d2 * (k2 / 6 - (k2 + t2) / 20));
}

/* The same over a joint between p and q, both bends constant: where the edge rises by a share of
 * what it does with the far one more than with the near one, sqrt(share) of it lies beyond the
 * joint. */
static double joint_angle(const struct bend *near, const struct bend *far, double c2, double rise) {
    double arc = near->curvature * c2 / 2;
    double share = (rise - arc) / ((far->curvature - near->curvature) * c2 / 2);
    double beyond = share > 0 ? sqrt(fmin(share, 1)) : 0, s = 1 - beyond;
    return c2 *
           (near->curvature * near->torsion * s * s * (0.5 - s / 3) +
            far->curvature * beyond * beyond * (near->torsion * s / 2 + far->torsion * beyond / 6));
}

/* An edge as it sets off from p: its chord, that in the tangent plane, how the surface bends there,
 * and whether its rise tells of a joint on the way. */
struct departure {
    struct vec3 chord, along;
    double c2, rise;
    struct bend near;
    bool over_joint;
};

static struct departure departure(const struct surface_point *p, struct vec3 to) {
    struct departure d = {.chord = vec3_sub(to, p->jet.r)};
    d.along = surface_point_tangent(p, d.chord);
    d.c2 = vec3_norm2(d.chord);
    d.rise = vec3_dot(d.chord, p->normal);
    d.near = bend_along(p, d.along);
    double arc = d.near.curvature * d.c2 / 2;
    d.over_joint = fabs(d.rise - arc) > other_side * fabs(arc) + least_rise * sqrt(d.c2);
    return d;
}

static struct vec3 leave_as_helix(const struct surface_point *p, const struct departure *d) {
    struct vec3 beside = vec3_cross(p->normal, d->along);
    return vec3_unit(vec3_axpy(helix_angle(&d->near, d->c2), beside, d->along));
}

/* The square of the angle by which the normal turns for each length along a direction. */
static double normal_turn2(const struct bend *bend) {
    return bend->curvature * bend->curvature + bend->torsion * bend->torsion;
}

static struct vec3 leave_over_joint(const struct surface_point *p, const struct departure *d,
                                    const struct surface_point *q) {
    struct vec3 t = d->along, along = surface_point_tangent(q, d->chord);
    struct bend far = bend_along(q, along);
    double angle = joint_angle(&d->near, &far, d->c2, d->rise);
    double turn2 = fmax(normal_turn2(&d->near), normal_turn2(&far)) * d->c2;
    if (vec3_norm(vec3_sub(q->normal, p->normal)) > 2 * sqrt(turn2) + least_fold) {
        t = surface_point_tangent(p, unfolded(along, q->normal, p->normal));
        angle = far.curvature * far.torsion * d->c2 / 6;
    }
    return vec3_unit(vec3_axpy(angle, vec3_cross(p->normal, t), t));
}

const struct surface_point *rough_end_point(struct surface_cursor *cursor,
                                            const struct rough_end *end,
                                            struct surface_point *made) {
    if (!end->surface)
        return NULL;
    if (end->point)
        return end->point;
    return surface_point_at(end->surface, cursor, end->uv, made) ? made : NULL;
}

/* A rise e beyond the arc's leads aside by at most e times the angle by which the normal turns to
 * the side: that at hand, and what there may be of it further on. With more curvature of its own
 * than |K| d^2 the surface itself makes nets wrong by more. */
static const double sure_aside = 1e-4, turn_aside = 0.3, own_curvature = 1e-4;

static bool is_sure(const struct departure *d) {
    double length = sqrt(d->c2), excess = fabs(d->rise - d->near.curvature * d->c2 / 2) / length;
    double gauss = d->near.curvature * d->near.across - d->near.torsion * d->near.torsion;
    return excess * (fabs(d->near.torsion) * length + turn_aside) < sure_aside ||
           fabs(gauss) * d->c2 > own_curvature;
}

bool rough_leaves_surely(const struct surface_point *p, struct vec3 to) {
    struct departure d = departure(p, to);
    return is_sure(&d);
}

struct vec3 rough_leave(struct surface_cursor *cursor, const struct surface_point *p,
                        const struct rough_end *end, bool *sure) {
    struct surface_point made;
    struct departure d = departure(p, end->r);
    if (sure)
        *sure = is_sure(&d);
    const struct surface_point *q = d.over_joint ? rough_end_point(cursor, end, &made) : NULL;
    return q ? leave_over_joint(p, &d, q) : leave_as_helix(p, &d);
}

/* The turn of an edge in its normal plane, as it goes from one end to the other, in Legendre's
 * polynomials; the largest of the first order is half an arc's turn. */
struct turn {
    double of[4];    /* of order 1 to 4 */
    double sideways; /* by torsion: of order 2, to the side */
    double wound;    /* what torsion may leave wrong of the length, as a share of it */
    double unsure;   /* and of the angle at which it leaves */
};

double rough_arcsine(double x) {
    double x2 = x * x;
    if (x2 < 0.01)
        return x * (1 + x2 * (1.0 / 6 + x2 * (3.0 / 40 + x2 * (5.0 / 112))));
    return angle_atan2_deg(x, sqrt(fmax(1 - x2, 0))) * (ANGLE_PI / 180);
}

/* What is left out of a helix, from curvatures and torsions times the length: of the length, and of
 * its angle where they change, and where there is much of them. */
static void find_unsure(double k0, double k1, double t0, double t1, struct turn *turn) {
    double bend = (k0 * k0 + k1 * k1 + t0 * t0 + t1 * t1) / 2;
    turn->wound = turn->sideways * turn->sideways * bend / 4;
    turn->unsure = fabs(k1 * t1 - k0 * t0) / 12 + fabs(k1 * t1 + k0 * t0) * bend * bend / 64;
}

/* The turn that has the curvatures at both ends, the angle between the normals there and, as its
 * mean, the direction of the chord: what the curvatures of p and q say of the edge between them,
 * which sets off from them like this, d long, or as an arc would be where d is 0, to fourth order.
 */
static struct turn turn_between(const struct departure *p, const struct departure *q, double d) {
    double c2 = p->c2, chord = sqrt(c2);
    const double torsion[2] = {p->near.torsion, q->near.torsion};
    double mean = rough_arcsine(p->rise / chord),
           half = (mean + rough_arcsine(q->rise / chord)) / 2;
    if (!(d > 0))
        d = chord / angle_sinc(half);
    /* the geodesic leaves beside the chord, by rough_leave's angle */
    double a = p->near.curvature * (1 + torsion[0] * torsion[0] * c2 / 3) * d;
    double b = q->near.curvature * (1 + torsion[1] * torsion[1] * c2 / 3) * d;
    double third = ((a + b) / 4 - half) / 5;
    double fourth = ((b - a) / 4 - 3 * (half - mean)) / 7;
    struct turn turn = {.of = {half - third, half - mean - fourth, third, fourth},
                        .sideways = fabs((a + b) * (torsion[0] + torsion[1])) * d / 48};
    find_unsure(a, b, torsion[0] * d, torsion[1] * d, &turn);
    return turn;
}

/* The chord by its length: the mean cosine of the turn. */
static double chord_share(const struct turn *turn) {
    const double *c = turn->of;
    return angle_sinc(c[0]) - (c[1] * c[1] / 5 + c[2] * c[2] / 7 + c[3] * c[3] / 9) / 2 -
           turn->sideways * turn->sideways;
}

/* What the chord may be wrong by, by its length. */
static double error_of(const struct turn *turn) {
    return ROUGH_MISSED * (turn->of[2] * turn->of[2] + turn->of[3] * turn->of[3]);
}

/* ---- both ends of an edge at once: the same sums, in the lanes of vectors ---- */

INLINE lanes both(double p, double q) {
    return (lanes){p, q};
}

INLINE struct lanes3 both_vectors(struct vec3 p, struct vec3 q) {
    return (struct lanes3){both(p.x, q.x), both(p.y, q.y), both(p.z, q.z)};
}

INLINE struct lanes3 unit_vectors(struct lanes3 a) {
    lanes n = lanes_sqrt(lanes3_norm2(a));
    return lanes3_select(n > 0, lanes3_scale(1 / n, a), a);
}

INLINE lanes form_of(const lanes coefficients[3], const lanes ab[2]) {
    return ab[0] * ab[0] * coefficients[0] + 2 * ab[0] * ab[1] * coefficients[1] +
           ab[1] * ab[1] * coefficients[2];
}

/* An edge as it sets off from either end, as in `departure`. */
struct departures {
    struct lanes3 normal, along;
    lanes c2, rise, curvature, torsion, across;
};

/* As in `bend_along`. */
INLINE void bend_both(const struct surface_point *p, const struct surface_point *q,
                      struct departures *d) {
    lanes i[3], ii[3];
    for (int k = 0; k < 3; k++) {
        i[k] = both(p->first[k], q->first[k]);
        ii[k] = both(p->second[k], q->second[k]);
    }
    lanes determinant = i[0] * i[2] - i[1] * i[1];
    lanes_mask regular =
        determinant > SURFACE_POINT_PARALLEL * SURFACE_POINT_PARALLEL * i[0] * i[2];
    lanes side = both(p->surface ? p->surface->side : 1, q->surface ? q->surface->side : 1);
    lanes inverse = 1 / determinant, scale = side / lanes_sqrt(determinant);
    lanes by_u = lanes3_dot(d->along, both_vectors(p->jet.u, q->jet.u));
    lanes by_v = lanes3_dot(d->along, both_vectors(p->jet.v, q->jet.v));
    const lanes ab[2] = {(i[2] * by_u - i[1] * by_v) * inverse,
                         (i[0] * by_v - i[1] * by_u) * inverse};
    const lanes n[2] = {-(ab[0] * i[1] + ab[1] * i[2]) * scale,
                        (ab[0] * i[0] + ab[1] * i[1]) * scale};
    const lanes zero = {0};
    d->curvature = lanes_select(regular, form_of(ii, ab), zero);
    d->torsion = lanes_select(
        regular,
        ab[0] * n[0] * ii[0] + (ab[0] * n[1] + ab[1] * n[0]) * ii[1] + ab[1] * n[1] * ii[2], zero);
    d->across = lanes_select(regular, form_of(ii, n), zero);
}

INLINE struct departures depart(const struct surface_point *p, const struct surface_point *q) {
    struct lanes3 from = both_vectors(p->jet.r, q->jet.r), to = both_vectors(q->jet.r, p->jet.r);
    struct lanes3 chord = lanes3_sub(to, from);
    struct departures d = {.normal = both_vectors(p->normal, q->normal), .c2 = lanes3_norm2(chord)};
    d.rise = lanes3_dot(chord, d.normal);
    d.along = unit_vectors(lanes3_axpy(-d.rise, d.normal, chord));
    bend_both(p, q, &d);
    return d;
}

/* As `helix_angle`. */
INLINE lanes helix_angles(const struct departures *d) {
    lanes curvature = d->curvature, torsion = d->torsion, c2 = d->c2;
    lanes angle = curvature * torsion * c2 / 6;
    lanes k2 = curvature * curvature, t2 = torsion * torsion;
    lanes k = curvature + 2 * torsion * angle, t = torsion + (d->across - curvature) * angle;
    lanes d2 = c2 * (1 + k2 * c2 / 12);
    return k * t * d2 / 6 * (1 + d2 * (k2 / 6 - (k2 + t2) / 20));
}

/* The directions in which a geodesic leaves its ends where curvature k and torsion t change evenly
 * from one to the other: with c^2 times the integral of (1 - x) k(x) times that of t, from 0 to x,
 * of which a helix has k t / 6. */
INLINE struct lanes3 leave_evenly(const struct departures *d) {
    lanes k = d->curvature, t = d->torsion;
    lanes dk = both(k[1], k[0]) - k, dt = both(t[1], t[0]) - t;
    lanes angle = helix_angles(d) + d->c2 * (k * dt / 24 + dk * t / 12 + dk * dt / 40);
    return unit_vectors(lanes3_axpy(angle, lanes3_cross(d->normal, d->along), d->along));
}

INLINE struct departure departure_of(const struct departures *d, int end) {
    return (struct departure){.c2 = d->c2[end],
                              .rise = d->rise[end],
                              .near = {d->curvature[end], d->torsion[end], d->across[end]}};
}

bool rough_estimate(const struct surface_point *p, const struct surface_point *q,
                    struct rough_geodesic *geodesic) {
    struct departures d = depart(p, q);
    const struct departure from_p = departure_of(&d, 0), from_q = departure_of(&d, 1);
    struct turn turn = turn_between(&from_p, &from_q, 0);
    struct lanes3 leave = leave_evenly(&d);
    double share = chord_share(&turn);
    *geodesic = (struct rough_geodesic){
        .length = sqrt(from_p.c2) / share,
        .error = error_of(&turn) + turn.wound,
        .angle = turn.unsure,
        .leave = {leave.x[0], leave.y[0], leave.z[0]},
        .arrive = vec3_scale(-1, vec3_make(leave.x[1], leave.y[1], leave.z[1]))};
    return fabs(turn.of[0]) < ROUGH_TURN_MOST && share > 0.5 && isfinite(geodesic->error);
}

/* |K| d^2, the larger of both ends. */
static double turn_of_net(const struct surface_point *p, const struct surface_point *q, double d) {
    const struct surface_point *end[2] = {p, q};
    double most = 0;
    for (int k = 0; k < 2; k++)
        most = fmax(most, fabs(surface_point_gauss_curvature(end[k])) * d * d);
    return most;
}

/* Whether an edge is an arc beyond doubt, without a look at how the surface bends at its far end.
 * Curvature that changes evenly, by c / d over the edge, has it rise by c d / 6 more than an arc at
 * p and by twice that at q, and its chord is wrong by c (k + c / 4) / 24; what else q rises by is
 * five times the third term of the turn. */
static bool rises_as_arc(const struct surface_point *p, const struct surface_point *q,
                         double curvature, double d, double net) {
    struct vec3 along = vec3_sub(q->jet.r, p->jet.r);
    double rise = curvature * vec3_norm2(along) / 2, k = fabs(curvature) * d;
    double at_p = (vec3_dot(along, p->normal) - rise) / d;
    double at_q = (-vec3_dot(along, q->normal) - rise) / d;
    double change = 2 * (fabs(at_p) + fabs(at_q)), uneven = at_q - 2 * at_p;
    return 2 * (k + change) < ROUGH_ARC_TURN &&
           uneven * uneven < ROUGH_EVEN + ROUGH_OWN_SHARE * net &&
           change * (k + change / 4) < 12 * (ROUGH_ARC_ERROR + ROUGH_ARC_SHARE * net);
}

enum rough_kind rough_edge(const struct surface_point *p, const struct surface_point *q,
                           double curvature, double d, double *chord) {
    double misfit = rough_misfit(p, q, curvature, d);
    if (surface_point_at_pole(p->surface, p) || surface_point_at_pole(q->surface, q)) {
        struct vec3 along = vec3_sub(q->jet.r, p->jet.r);
        bool alike = fabs(vec3_dot(along, vec3_add(p->normal, q->normal))) < pole_misfit * d;
        return alike ? ROUGH_NOT : ROUGH_EDGE;
    }
    if (rough_is_folded_back(p, q))
        return ROUGH_EDGE;
    double net = turn_of_net(p, q, d);
    if (rises_as_arc(p, q, curvature, d, net))
        return ROUGH_NOT;
    struct departure from_p = departure(p, q->jet.r), from_q = departure(q, p->jet.r);
    struct turn turn = turn_between(&from_p, &from_q, d);
    const double *c = turn.of;
    double error = error_of(&turn);
    double own = ROUGH_OWN_SHARE * net, most = ROUGH_ARC_ERROR + own;
    double right = d * chord_share(&turn);
    bool gentle = 2 * fabs(c[0]) < ROUGH_ARC_TURN;
    if (misfit < ROUGH_ARC_MISFIT && gentle && error < ROUGH_EVEN + own &&
        fabs(right - *chord) < (ROUGH_ARC_ERROR + ROUGH_ARC_SHARE * net) * d)
        return ROUGH_NOT;
    bool winds = turn.sideways > ROUGH_WINDING + net ||
                 (!gentle && turn.sideways * turn.sideways + c[1] * c[1] > most);
    if (!(error < ROUGH_BENT_ERROR + own) || !(fabs(c[0]) < ROUGH_TURN_MOST) || winds)
        return ROUGH_EDGE;
    *chord = right;
    bool by_places =
        misfit * misfit < ROUGH_ARC_MISFIT * ROUGH_ARC_MISFIT + ROUGH_SHEAR_SHARE * net;
    return gentle && by_places ? ROUGH_BENT : ROUGH_UNEVEN;
}
