/* SPDX-License-Identifier: MIT */
#include "rough.h"

#include "solver/surface/crossing.h"

enum { HOPS_MAX = 16 };

/* Along a helix of curvature k and torsion t an arc of the curvature in the chord's direction is
 * wrong by (k d)^2 (t d)^2 / 72 of its length. */
static const double helix_share = 72;
static const double length_share = 5e-7;

/* A knot line is a joint when the angle by which the surface turns on it, or the change of the turn
 * of an edge, is more than this. */
static const double joint_angle = 1e-3;
static const double joint_turn = 4e-3;

/* An edge that rises by so much else than the curvature at its end says, as a share of that or of
 * the edge, lies on the other side of a joint there. */
static const double other_side = 0.2;
static const double least_rise = 5e-4;

/* II(t, t) and II(t, n x t) of the unit tangent t: normal curvature and geodesic torsion. */
static void bend_along(const struct station *p, struct vec3 t, double *curvature, double *torsion) {
    double along[2], across[2];
    const double *ii = p->second;
    *curvature = *torsion = 0;
    if (!station_components(p, t, along) ||
        !station_components(p, vec3_cross(p->normal, t), across))
        return;
    *curvature = station_form(ii, along);
    *torsion = along[0] * across[0] * ii[0] +
               (along[0] * across[1] + along[1] * across[0]) * ii[1] + along[1] * across[1] * ii[2];
}

/* A direction in the tangent plane at `from` in that at `to`, unfolded about the line in which they
 * meet: turned as the one normal into the other. */
static struct vec3 unfolded(struct vec3 direction, struct vec3 from, struct vec3 to) {
    struct vec3 axis = vec3_cross(from, to);
    double cosine = vec3_dot(from, to), along = vec3_dot(axis, direction) / (1 + cosine);
    struct vec3 turned = vec3_add(vec3_scale(cosine, direction), vec3_cross(axis, direction));
    return cosine > -0.9 ? vec3_axpy(along, axis, turned) : direction;
}

struct vec3 rough_leave(const struct surface *surface, struct surface_cursor *cursor,
                        const struct station *p, const double to_uv[2], struct vec3 to) {
    double curvature, torsion;
    struct station q;
    struct vec3 chord = vec3_sub(to, p->jet.r), t = station_tangent(p, chord);
    bend_along(p, t, &curvature, &torsion);
    double c2 = vec3_norm2(chord), rise = curvature * c2 / 2;
    if (surface &&
        fabs(vec3_dot(chord, p->normal) - rise) > other_side * fabs(rise) + least_rise * sqrt(c2) &&
        station_at(surface, cursor, to_uv, &q)) {
        struct vec3 along = station_tangent(&q, chord);
        bend_along(&q, along, &curvature, &torsion);
        if (vec3_norm(vec3_sub(q.normal, p->normal)) > joint_angle)
            t = station_tangent(p, unfolded(along, q.normal, p->normal));
    }
    return vec3_unit(vec3_axpy(curvature * torsion * c2 / 6, vec3_cross(p->normal, t), t));
}

/* Whether the surface turns, or bends differently, on either side of (u, v) on a knot of direction
 * k between `span` and the next. */
static bool is_joint(const struct surface *surface, int k, const int span[2], const double uv[2],
                     struct vec3 chord, double d) {
    struct station side[2];
    double curvature[2];
    for (int n = 0; n < 2; n++) {
        int at[2] = {span[0], span[1]};
        at[k] += n;
        surface_evaluate_span(surface, at[0], at[1], uv[0], uv[1], &side[n].jet);
        side[n].uv[0] = uv[0];
        side[n].uv[1] = uv[1];
        if (!station_complete(surface, &side[n]))
            return true;
        curvature[n] = station_normal_curvature(&side[n], chord);
    }
    return fabs(curvature[1] - curvature[0]) * d > joint_turn ||
           vec3_norm(vec3_sub(side[1].normal, side[0].normal)) > joint_angle;
}

/* Whether the surface turns, or bends differently, beyond a joint of faces; `to` gets the station
 * there. */
static bool is_joint_of_faces(const struct surface *from, const struct crossing *crossing,
                              struct vec3 chord, double d, struct station *to) {
    struct surface_cursor cursor = {0, 0};
    struct station side;
    if (!station_at(from, &cursor, crossing->edge, &side) ||
        !station_at(crossing->beyond, &cursor, crossing->entry, to))
        return true;
    double change = station_normal_curvature(to, crossing_turn(crossing, chord)) -
                    station_normal_curvature(&side, chord);
    return fabs(change) * d > joint_turn ||
           vec3_norm(vec3_sub(to->normal, side.normal)) > joint_angle;
}

static bool crosses_knot(const struct station *p, const struct station *q, double d);

/* Whether there is a joint on the way to another face of a shell, through those between. */
static bool crosses_faces(const struct station *p, const struct station *q, double d) {
    struct surface_cursor cursor = {0, 0};
    struct station at = *p;
    for (int hop = 0; hop < HOPS_MAX && at.surface != q->surface; hop++) {
        struct crossing crossing;
        struct station edge, beyond;
        double uv[2], share;
        struct vec3 chord = vec3_sub(q->jet.r, at.jet.r);
        bool met = station_pull(at.surface, &cursor, &at, chord, uv) &&
                   crossing_on_way(at.surface, at.uv, uv, &share, &crossing);
        if (!met && !crossing_between(&at, q->surface, &crossing))
            return true;
        if (is_joint_of_faces(at.surface, &crossing, chord, d, &beyond) ||
            !station_at(at.surface, &cursor, crossing.edge, &edge) || crosses_knot(&at, &edge, d))
            return true;
        at = beyond;
    }
    return at.surface != q->surface || crosses_knot(&at, q, d);
}

/* Whether there is a joint between two places of a surface, as the straight line between their
 * parameters crosses it. Round a closed direction the seam counts as one. */
static bool crosses_knot(const struct station *p, const struct station *q, double d) {
    const struct surface *surface = p->surface;
    struct vec3 chord = vec3_sub(q->jet.r, p->jet.r);
    for (int k = 0; k < 2; k++) {
        const struct surface_axis *axis = &surface->axis[k];
        double from = surface_axis_wrap(axis, p->uv[k]), to = surface_axis_wrap(axis, q->uv[k]);
        double shift = from - p->uv[k];
        if (fabs(to - shift - q->uv[k]) > 0.5 * fabs(surface_axis_upper(axis) - axis->breaks[0]))
            return true;
        int a = surface_axis_span(axis, 0, from), b = surface_axis_span(axis, a, to);
        for (int s = a < b ? a : b; s < (a < b ? b : a); s++) {
            const struct surface_axis *other = &surface->axis[1 - k];
            double uv[2], share = (axis->breaks[s + 1] - from) / (to - from);
            int span[2];
            uv[k] = axis->breaks[s + 1];
            uv[1 - k] =
                surface_axis_wrap(other, p->uv[1 - k] + share * (q->uv[1 - k] - p->uv[1 - k]));
            span[k] = s;
            span[1 - k] = surface_axis_span(other, 0, uv[1 - k]);
            if (is_joint(surface, k, span, uv, chord, d))
                return true;
        }
    }
    return false;
}

bool rough_edge_closely(const struct station *p, const struct station *q, double curvature,
                        double misfit, double d) {
    double turn = fabs(curvature) * d;
    if (station_at_pole(p->surface,
                        p)) { /* a pole: no curvature there, but arcs rise alike at both ends */
        struct vec3 chord = vec3_sub(q->jet.r, p->jet.r);
        return !(fabs(vec3_dot(chord, vec3_add(p->normal, q->normal))) < ROUGH_MISFIT_ROUGH * d);
    }
    if (!(misfit < ROUGH_MISFIT_ROUGH && turn < ROUGH_TURN_ROUGH))
        return true;
    if (turn >= ROUGH_TURN_SMOOTH) {
        double bend, torsion;
        bend_along(p, station_tangent(p, vec3_sub(q->jet.r, p->jet.r)), &bend, &torsion);
        if (bend * bend * torsion * torsion * d * d * d * d > helix_share * length_share)
            return true;
    }
    return misfit >= ROUGH_MISFIT_SMOOTH &&
           (p->surface == q->surface ? crosses_knot(p, q, d) : crosses_faces(p, q, d));
}
