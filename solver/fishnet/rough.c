/* SPDX-License-Identifier: MIT */
#include "rough.h"

#include "rough_formulas.h"
#define LANES 2 /* the two ends of an edge */
#include "rough_lanes.h"
#include "unfolding.h"

/* At a pole, where there is no curvature, arcs rise alike at both ends, but for this. */
static const double pole_misfit = 2.5e-2;

/* The side of a point's surface; 1 on a mesh. */
static double normal_side(const struct surface_point *p) {
    return p->surface ? p->surface->side : 1;
}

static struct departure depart_for(const struct surface_point *p, struct vec3 to) {
    return depart(p, vec3_sub(to, p->jet.r), normal_side(p));
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
    double length = sqrt(d->c2), excess = fabs(d->rise - d->curvature * d->c2 / 2) / length;
    double gauss = d->curvature * d->across - d->torsion * d->torsion;
    return excess * (fabs(d->torsion) * length + turn_aside) < sure_aside ||
           fabs(gauss) * d->c2 > own_curvature;
}

double rough_aside(const struct surface_point *p, struct vec3 chord) {
    struct departure d = depart(p, chord, normal_side(p));
    return helix_angle(&d);
}

bool rough_leaves_surely(const struct surface_point *p, struct vec3 to) {
    struct departure d = depart_for(p, to);
    return is_sure(&d);
}

struct vec3 rough_leave(struct surface_cursor *cursor, const struct surface_point *p,
                        const struct rough_end *end, bool *sure) {
    struct surface_point made;
    struct departure d = depart_for(p, end->r);
    if (sure)
        *sure = is_sure(&d);
    const struct surface_point *q = is_over_joint(&d) ? rough_end_point(cursor, end, &made) : NULL;
    double angle = q ? 0 : helix_angle(&d);
    struct vec3 t = d.along;
    if (q) {
        struct departure far = depart(q, vec3_sub(end->r, p->jet.r), normal_side(q));
        angle = joint_angle(&d, &far);
        if (is_creased(&d, &far, vec3_sub(q->normal, p->normal))) {
            t = surface_point_tangent(p, unfolding_turned(far.along, q->normal, p->normal));
            angle = far.curvature * far.torsion * d.c2 / 6;
        }
    }
    return lead_aside(t, angle, p->normal);
}

double rough_steep_arcsine(double x) {
    return angle_atan2_deg(x, sqrt(fmax(1 - x * x, 0))) * (ANGLE_PI / 180);
}

/* ---- both ends of an edge at once, in the lanes of vectors ---- */

INLINE lanes both(double p, double q) {
    return (lanes){p, q};
}

INLINE struct lanes3 both_vectors(struct vec3 p, struct vec3 q) {
    return (struct lanes3){both(p.x, q.x), both(p.y, q.y), both(p.z, q.z)};
}

INLINE struct departure departure_of(const struct departure_lanes *d, int end) {
    return (struct departure){.c2 = d->c2[end],
                              .rise = d->rise[end],
                              .curvature = d->curvature[end],
                              .torsion = d->torsion[end]};
}

/* A geodesic leaves its ends beside the chord, where curvature k and torsion t change evenly from
 * one to the other, by c^2 times the integral of (1 - x) k(x) times that of t, from 0 to x, of
 * which a helix has k t / 6. */
WIDE_CLONES
bool rough_estimate(const struct surface_point *p, const struct surface_point *q,
                    struct rough_geodesic *geodesic) {
    struct lanes_point ends = {.jet = {both_vectors(p->jet.r, q->jet.r),
                                       both_vectors(p->jet.u, q->jet.u),
                                       both_vectors(p->jet.v, q->jet.v)},
                               .normal = both_vectors(p->normal, q->normal)};
    for (int k = 0; k < 3; k++) {
        ends.first[k] = both(p->first[k], q->first[k]);
        ends.second[k] = both(p->second[k], q->second[k]);
    }
    struct lanes3 chord = lanes3_sub(both_vectors(q->jet.r, p->jet.r), ends.jet.r);
    struct departure_lanes d = depart_lanes(&ends, chord, both(normal_side(p), normal_side(q)));
    lanes k = d.curvature, t = d.torsion, dk = both(k[1], k[0]) - k, dt = both(t[1], t[0]) - t;
    lanes angle = helix_angle_lanes(&d) + d.c2 * (k * dt / 24 + dk * t / 12 + dk * dt / 40);
    struct lanes3 leave =
        lanes3_unit(lanes3_axpy(angle, lanes3_cross(ends.normal, d.along), d.along));
    const struct departure from_p = departure_of(&d, 0), from_q = departure_of(&d, 1);
    double at_p, mean;
    chord_angles(&from_p, &from_q, &at_p, &mean);
    double size = sqrt(from_p.c2), arc = size / angle_sinc(mean);
    struct turn turn = turn_between(&from_p, &from_q, at_p, mean, arc);
    double share = chord_share(&turn);
    *geodesic = (struct rough_geodesic){
        .length = size / share,
        .error = chord_error(&turn) + turn.wound,
        .angle = turn.unsure,
        .leave = {leave.x[0], leave.y[0], leave.z[0]},
        .arrive = vec3_scale(-1, vec3_make(leave.x[1], leave.y[1], leave.z[1]))};
    return fabs(turn.of[0]) < ROUGH_TURN_MOST && share > 0.5 && isfinite(geodesic->error);
}

enum rough_kind rough_edge(const struct surface_point *p, const struct surface_point *q,
                           double curvature, double d, double *chord) {
    if (surface_point_at_pole(p->surface, p) || surface_point_at_pole(q->surface, q)) {
        struct vec3 along = vec3_sub(q->jet.r, p->jet.r);
        bool alike = fabs(vec3_dot(along, vec3_add(p->normal, q->normal))) < pole_misfit * d;
        return alike ? ROUGH_NOT : ROUGH_EDGE;
    }
    const double side[2] = {normal_side(p), normal_side(q)};
    struct edge_kind kind = find_edge_kind(p, q, curvature, d, *chord, side);
    if (kind.arc)
        return ROUGH_NOT;
    if (!kind.known)
        return ROUGH_EDGE;
    *chord = kind.chord;
    return kind.even ? ROUGH_BENT : ROUGH_UNEVEN;
}

bool rough_is_rough(const struct surface_point *p, const struct surface_point *q, double d) {
    double chord = d, curvature = surface_point_normal_curvature(p, vec3_sub(q->jet.r, p->jet.r));
    return !rough_is_arc(p, q, curvature, d) &&
           rough_edge(p, q, curvature, d, &chord) == ROUGH_EDGE;
}

bool rough_is_fold(const struct surface_point *p, const struct surface_point *q, double d) {
    return vec3_dot(p->normal, q->normal) < ROUGH_FOLD_COSINE && rough_is_rough(p, q, d);
}
