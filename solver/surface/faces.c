/* SPDX-License-Identifier: MIT */
#include "faces.h"

enum { NEWTON_MAX = 40, HALVINGS_MAX = 20 };

/* A place this close outside the domain, as a share of it, is on its border. */
static const double border = 1e-9;

/* Loops that run along the seam of a closed direction may be off by this share of the domain. */
static const double seam = 2e-6;

static void line_at(const struct face_curve *curve, double t, double uv[2], double rate[2]) {
    for (int k = 0; k < 2; k++) {
        rate[k] = curve->line[1][k] - curve->line[0][k];
        uv[k] = t == 1 ? curve->line[1][k] : curve->line[0][k] + t * rate[k];
    }
}

void curve_at(const struct shell *shell, const struct face_curve *curve, double t,
              struct curve_place *place) {
    const struct surface *surface = &shell->faces[curve->face].surface;
    struct surface_cursor cursor = {0, 0};
    double outer[2];
    place->t = t;
    if (curve->trim) {
        trim_curve_at(curve->trim, t, outer, place->rate);
        surface_inner(surface, outer, place->uv);
        for (int k = 0; k < 2; k++)
            place->rate[k] *= surface_axis_rate(&surface->axis[k], place->uv[k], NULL);
    } else {
        line_at(curve, t, place->uv, place->rate);
    }
    surface_jet_at(surface, &cursor, place->uv[0], place->uv[1], &place->jet);
    place->r = place->jet.r;
    place->tangent =
        vec3_axpy(place->rate[1], place->jet.v, vec3_scale(place->rate[0], place->jet.u));
}

double curve_nearest(const struct shell *shell, const struct face_curve *curve, struct vec3 point,
                     double from, const double range[2], struct curve_place *place) {
    double t = fmin(fmax(from, range[0]), range[1]), distance;
    curve_at(shell, curve, t, place);
    distance = vec3_distance(place->r, point);
    for (int round = 0; round < NEWTON_MAX; round++) {
        struct curve_place next;
        double speed2 = vec3_norm2(place->tangent), closer = distance, last = t;
        double step = vec3_dot(vec3_sub(point, place->r), place->tangent) / speed2;
        for (int h = 0; h < HALVINGS_MAX && isfinite(step) && !(closer < distance); h++) {
            double to = fmin(fmax(last + step, range[0]), range[1]);
            if (to == last)
                break;
            curve_at(shell, curve, to, &next);
            closer = vec3_distance(next.r, point);
            step /= 2;
        }
        if (!(closer < distance))
            break;
        *place = next;
        t = next.t;
        distance = closer;
    }
    return distance;
}

bool face_contains(const struct face *face, const double uv[2]) {
    double at[2], outer[2];
    for (int k = 0; k < 2; k++) {
        const struct surface_axis *axis = &face->surface.axis[k];
        double low = surface_axis_lower(axis), high = surface_axis_upper(axis);
        double slack = border * (high - low);
        at[k] = surface_axis_wrap(axis, uv[k]);
        if (!(at[k] >= low - slack && at[k] <= high + slack))
            return false;
        if (axis->closed && face->trim)
            at[k] = fmin(fmax(at[k], low + seam * (high - low)), high - seam * (high - low));
    }
    if (!face->trim)
        return true;
    surface_outer(&face->surface, at, outer);
    return trim_contains(face->trim, outer);
}
