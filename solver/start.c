/* SPDX-License-Identifier: MIT */
#include "start.h"

#include "angle.h"

/* A direction whose projection is shorter than this share of it lies along the normal. */
static const double along_normal = 1e-9;

static enum status find_uv(const struct surface *surface, const struct drape_settings *settings,
                           double uv[2]) {
    double lower[2], upper[2], distance;
    struct vec3 target = settings->start_point;
    if (settings->start_kind == DRAPE_START_UV) {
        surface_domain(surface, lower, upper);
        for (int k = 0; k < 2; k++) {
            uv[k] = settings->start_uv[k];
            if (!(uv[k] >= lower[k] && uv[k] <= upper[k]))
                return STATUS_START_OFF_SURFACE;
        }
        return STATUS_OK;
    }
    if (settings->start_kind == DRAPE_START_CENTROID)
        surface_area(surface, &target);
    surface_nearest(surface, target, uv, &distance);
    bool far = distance > fmax(settings->spacing[0], settings->spacing[1]);
    return settings->start_kind == DRAPE_START_POINT && far ? STATUS_START_OFF_SURFACE : STATUS_OK;
}

/* Turned about the unit normal, to which `direction` is at right angles. */
static struct vec3 turned(struct vec3 direction, struct vec3 normal, double degrees) {
    double sine, cosine;
    angle_sincos_deg(degrees, &sine, &cosine);
    struct vec3 across = vec3_cross(normal, direction);
    return vec3_axpy(sine, across, vec3_scale(cosine, direction));
}

enum status start_find(const struct surface *surface, const struct drape_settings *settings,
                       struct march_start *start) {
    struct surface_cursor cursor = {0};
    struct station *station = &start->station;
    double uv[2], ab[2];
    enum status status = find_uv(surface, settings, uv);
    if (status != STATUS_OK)
        return status;
    if (!station_at(surface, &cursor, uv, station))
        return STATUS_DEGENERATE_SURFACE;
    if (settings->direction_kind == DRAPE_DIRECTION_VECTOR) {
        struct vec3 wanted = vec3_unit(settings->direction_vector);
        struct vec3 across = vec3_cross(station->normal, wanted);
        if (!(vec3_norm(across) > along_normal))
            return STATUS_INVALID;
        start->warp = station_tangent(station, wanted);
    } else {
        bool regular = station_components(station, station->normal, ab);
        bool pole = !regular && vec3_norm2(station->jet.u) < vec3_norm2(station->jet.v);
        struct vec3 from = station_tangent(station, pole ? station->jet.v : station->jet.u);
        start->warp = turned(from, station->normal, settings->direction_deg);
    }
    start->weft = turned(start->warp, station->normal, 90 - settings->pre_shear_deg);
    return STATUS_OK;
}
