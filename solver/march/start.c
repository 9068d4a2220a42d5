/* SPDX-License-Identifier: MIT */
#include "start.h"

#include "solver/angle.h"
#include <string.h>

/* A start this near to the trimmed region, as a share of the domain, lies on its edge: flattening
 * moves edges by a quarter of that. */
static const double on_trim = 4e-6;

/* A polyline passes the start when it is this near, as a share of the spacing. */
static const double passing = 1e-3;

/* Generators that meet at an angle with a smaller sine make no net: 1 degree. */
static const double nearly_parallel = 0.0175;

double start_inside(const struct surface *surface, const struct trim *trim, struct vec3 target,
                    double inner[2]) {
    enum { STEPS = 16 };
    struct surface_cursor cursor = {0};
    double low[2], high[2], least = HUGE_VAL;
    surface_domain(surface, low, high);
    for (int margin = STEPS / 4; margin >= 0 && least == HUGE_VAL; margin -= STEPS / 4)
        for (int k = 0; k < STEPS * STEPS; k++) {
            int at[2] = {k / STEPS, k % STEPS};
            double outer[2];
            struct surface_jet jet;
            bool inside = true;
            for (int x = 0; x < 2; x++) {
                inside = inside && at[x] >= margin && at[x] < STEPS - margin;
                outer[x] = low[x] + (at[x] + 0.5) / STEPS * (high[x] - low[x]);
            }
            if (!inside || (trim && !trim_contains(trim, outer)))
                continue;
            surface_evaluate(surface, &cursor, outer[0], outer[1], &jet);
            double distance = vec3_distance(jet.r, target);
            if (!(distance < least))
                continue;
            least = distance;
            surface_inner(surface, outer, inner);
        }
    return least;
}

/* The inner parameters of the start: by default of the surface point nearest to the centroid or,
 * where that is trimmed away, of a place well inside the trimmed region. */
static enum status find_uv(const struct surface *surface, const struct trim *trim,
                           const struct drape_settings *settings, double uv[2]) {
    enum { SIDES = 64 };
    double lower[2], upper[2], outer[2], distance;
    surface_domain(surface, lower, upper);
    if (settings->start_kind == DRAPE_START_CENTROID) {
        struct vec3 centroid;
        if (trim)
            trim_area(trim, &centroid);
        else
            surface_area(surface, &centroid);
        surface_nearest_at(surface, centroid, uv, &distance);
        surface_outer(surface, uv, outer);
        if (trim && !trim_contains(trim, outer)) {
            trim_middle(trim, outer);
            surface_inner(surface, outer, uv);
        }
    } else if (settings->start_kind == DRAPE_START_POINT) {
        double reach = fmax(settings->spacing[0], settings->spacing[1]);
        reach += fabs(surface->height); /* the point may lie on the surface before it is moved */
        surface_nearest_at(surface, settings->start_point, uv, &distance);
        if (!(distance <= reach))
            return STATUS_START_OFF_SURFACE;
    } else {
        surface_inner(surface, settings->start_uv, uv);
    }
    surface_outer(surface, uv, outer);
    if (settings->start_kind == DRAPE_START_UV)
        memcpy(outer, settings->start_uv, sizeof outer);
    for (int k = 0; k < 2; k++)
        if (!(outer[k] >= lower[k] && outer[k] <= upper[k]))
            return STATUS_START_OFF_SURFACE;
    /* With a place beside it in the trimmed region it lies on an edge, or at a corner of at least
     * six degrees. */
    bool inside = !trim || trim_contains(trim, outer);
    for (int k = 0; k < SIDES && !inside; k++) {
        double way[2], beside[2];
        angle_sincos_deg(360.0 * k / SIDES, &way[1], &way[0]);
        for (int x = 0; x < 2; x++) {
            double at = outer[x] + on_trim * (upper[x] - lower[x]) * way[x];
            beside[x] = fmin(fmax(at, lower[x]), upper[x]);
        }
        inside = trim_contains(trim, beside);
    }
    return inside ? STATUS_OK : STATUS_START_OFF_SURFACE;
}

/* Turned about the unit normal, to which `direction` is at right angles. */
static struct vec3 turned(struct vec3 direction, struct vec3 normal, double degrees) {
    double sine, cosine;
    angle_sincos_deg(degrees, &sine, &cosine);
    struct vec3 across = vec3_cross(normal, direction);
    return vec3_axpy(sine, across, vec3_scale(cosine, direction));
}

/* The warp of the settings, without regard to generators. */
static enum status find_warp(const struct drape_settings *settings, struct vec3 tangent,
                             struct march_start *start) {
    const struct surface *surface = start->point.surface;
    struct vec3 normal = start->point.normal;
    bool by_first = surface && surface->shell && settings->zero.kind != DRAPE_ZERO_TANGENT;
    int side = by_first ? shell_side(surface->shell, surface->face) : 1;
    int sense = side * drape_zero_direction(&settings->zero, vec3_scale(side, normal), tangent,
                                            &start->zero);
    start->side = vec3_scale(side, normal);
    bool by_vector = settings->direction_kind == DRAPE_DIRECTION_VECTOR;
    start->warp = by_vector ? zero_across(vec3_unit(settings->direction_vector), normal)
                            : turned(start->zero, normal, sense * settings->direction_deg);
    return vec3_norm2(start->warp) > 0 ? STATUS_OK : STATUS_INVALID;
}

/* The point with the caller's parameters and the derivatives by them. */
static struct surface_point in_outer_parameters(const struct surface *surface,
                                                const struct surface_point *point) {
    struct surface_point outer = *point;
    struct surface_cursor cursor = {0};
    surface_outer(surface, point->uv, outer.uv);
    surface_evaluate(surface, &cursor, outer.uv[0], outer.uv[1], &outer.jet);
    return outer;
}

/* From one place to another in parameters, in space to first order. */
static struct vec3 way_between(const struct surface_jet *jet, const double from[2],
                               const double to[2]) {
    return vec3_axpy(to[1] - from[1], jet->v, vec3_scale(to[0] - from[0], jet->u));
}

/* Where the polyline passes the start, and its direction there. */
static enum status find_on_curve(const struct surface *surface,
                                 const struct drape_generator *generator, double spacing,
                                 const struct surface_point *start, struct march_curve *curve,
                                 struct vec3 *direction) {
    struct surface_point outer = in_outer_parameters(surface, start);
    double least = HUGE_VAL, share = 0;
    size_t before = 0;
    for (size_t k = 0; k + 1 < generator->curve_count; k++) {
        /* The place of the segment p q that is nearest to the start, by the metric there. */
        const double *p = generator->curve[k], *q = generator->curve[k + 1];
        struct vec3 along = way_between(&outer.jet, p, q),
                    to = way_between(&outer.jet, p, outer.uv);
        double length2 = vec3_norm2(along);
        double at = length2 > 0 ? fmin(fmax(vec3_dot(to, along) / length2, 0), 1) : 0;
        double distance = vec3_norm(vec3_axpy(-at, along, to));
        if (distance < least) {
            least = distance;
            share = at;
            before = k;
        }
    }
    if (!(least <= passing * spacing))
        return STATUS_GENERATOR_OFF_START;
    /* At a pole all its parameters are one place, but the surface's lines leave it in different
     * directions: the start is as the segment sees it. */
    const double *p = generator->curve[before], *q = generator->curve[before + 1];
    double uv[2] = {p[0] + share * (q[0] - p[0]), p[1] + share * (q[1] - p[1])};
    struct surface_cursor cursor = {0};
    surface_inner(surface, uv, uv);
    curve->from = *start;
    if (surface_point_at_pole(surface, start) &&
        !surface_point_at(surface, &cursor, uv, &curve->from))
        return STATUS_GENERATOR_OFF_START;
    curve->sense = 1;
    outer = in_outer_parameters(surface, &curve->from);
    /* The first points on both sides of the segment that are further than that from the start. */
    double reach = passing * spacing;
    size_t ahead = before + 1, behind = before + 1; /* behind: one more than the index */
    while (ahead < generator->curve_count &&
           !(vec3_norm(way_between(&outer.jet, outer.uv, generator->curve[ahead])) > reach))
        ahead++;
    while (behind > 0 &&
           !(vec3_norm(way_between(&outer.jet, outer.uv, generator->curve[behind - 1])) > reach))
        behind--;
    curve->ends[0] = ahead == generator->curve_count;
    curve->ends[1] = behind == 0;
    curve->next[0] = ahead;
    curve->next[1] = behind - 1;
    size_t to = curve->ends[0] ? curve->next[1] : curve->next[0];
    if (curve->ends[0] && curve->ends[1])
        return STATUS_GENERATOR_OFF_START;
    struct vec3 offset = way_between(&outer.jet, outer.uv, generator->curve[to]);
    *direction = surface_point_tangent(start, curve->ends[0] ? vec3_scale(-1, offset) : offset);
    return vec3_norm2(*direction) > 0 ? STATUS_OK : STATUS_GENERATOR_OFF_START;
}

/* Turns `direction`, warp or weft as the settings alone have it, into that of the generator. */
static enum status find_generator(const struct surface *surface,
                                  const struct drape_settings *settings, int k,
                                  struct march_start *start, struct vec3 *direction) {
    const struct drape_generator *generator = &settings->generator[k];
    const struct surface_point *point = &start->point;
    if (generator->kind == DRAPE_GENERATOR_GEODESIC || generator->kind == DRAPE_GENERATOR_STEERED)
        return STATUS_OK;
    if (generator->kind == DRAPE_GENERATOR_PLACES) {
        *direction = surface_point_tangent(point, generator->places[generator->place_start].along);
        return vec3_norm2(*direction) > 0 ? STATUS_OK : STATUS_GENERATOR_OFF_START;
    }
    if (generator->kind == DRAPE_GENERATOR_CURVE)
        return find_on_curve(surface, generator, settings->spacing[k], point, &start->curve[k],
                             direction);
    struct vec3 along = vec3_cross(vec3_unit(generator->plane_normal), point->normal);
    if (!(vec3_norm(along) > nearly_parallel))
        return STATUS_GENERATOR_PARALLEL;
    *direction = vec3_unit(vec3_dot(along, *direction) < 0 ? vec3_scale(-1, along) : along);
    return STATUS_OK;
}

/* Weft to the left of warp. */
static enum status find_generators(const struct surface *surface,
                                   const struct drape_settings *settings, struct march_start *start,
                                   int *faulty) {
    *faulty = 0;
    enum status status = find_generator(surface, settings, 0, start, &start->warp);
    if (status != STATUS_OK)
        return status;
    *faulty = 1;
    start->weft = turned(start->warp, start->point.normal, 90 - settings->pre_shear_deg);
    status = find_generator(surface, settings, 1, start, &start->weft);
    double left = vec3_dot(vec3_cross(start->warp, start->weft), start->point.normal);
    if (left < 0) {
        start->weft = vec3_scale(-1, start->weft);
        start->curve[1].sense = -1;
    }
    if (status == STATUS_OK && !(fabs(left) > nearly_parallel))
        return STATUS_GENERATOR_PARALLEL;
    return status;
}

/* At a corner where r_u and r_v, both inwards, point opposite ways no direction has parameters, as
 * on a disk in one patch. A start this near to one is put a small share of the domain inside, along
 * parameters for which r_u and r_v cancel: it moves by the square of that share, which geodesics of
 * all methods get away from in a bounded number of steps. */
static const double singular_sine = 3e-3, singular_inside = 3e-3;

static void leave_singular_corner(const struct surface *surface, struct surface_cursor *cursor,
                                  double uv[2]) {
    struct surface_jet jet;
    struct vec3 inward[2];
    double sign[2], least = HUGE_VAL;
    surface_jet_at(surface, cursor, uv[0], uv[1], &jet);
    for (int k = 0; k < 2; k++) {
        const struct surface_axis *axis = &surface->axis[k];
        double lower = surface_axis_lower(axis), upper = surface_axis_upper(axis);
        sign[k] = uv[k] < (lower + upper) / 2 ? 1 : -1;
        inward[k] = vec3_scale(sign[k], k ? jet.v : jet.u);
        least = fmin(least, (upper - lower) * vec3_norm(inward[k]));
    }
    double size = vec3_norm(inward[0]) * vec3_norm(inward[1]);
    double sine = vec3_norm(vec3_cross(inward[0], inward[1]));
    if (!(least > 0) || !(sine < singular_sine * size) || vec3_dot(inward[0], inward[1]) > 0)
        return;
    for (int k = 0; k < 2; k++)
        uv[k] += sign[k] * singular_inside * least / vec3_norm(inward[k]);
}

enum status start_find(const struct surface *surface, const struct trim *trim,
                       const struct drape_settings *settings, const double inner[2],
                       struct march_start *start, int *faulty) {
    struct surface_cursor cursor = {0};
    double uv[2];
    enum status status = inner ? STATUS_OK : find_uv(surface, trim, settings, uv);
    if (status != STATUS_OK)
        return status;
    if (inner)
        memcpy(uv, inner, sizeof uv);
    leave_singular_corner(surface, &cursor, uv);
    if (!surface_point_at(surface, &cursor, uv, &start->point))
        return STATUS_DEGENERATE_SURFACE;
    const struct surface_point *point = &start->point;
    bool along_v = surface_point_at_pole(surface, point) && point->first[0] < point->first[2];
    status = find_warp(settings, along_v ? point->jet.v : point->jet.u, start);
    return status == STATUS_OK ? find_generators(surface, settings, start, faulty) : status;
}

enum status start_move_to_mesh(struct march *march) {
    const struct mesh *mesh = march->mesh;
    struct march_start *start = &march->start;
    struct mesh_point place;
    if (!mesh_nearest(mesh, start->point.jet.r, MESH_ANY, &place, NULL))
        return STATUS_START_OFF_SURFACE;
    start->smooth = start->point;
    start->smooth_direction[0] = start->warp;
    start->smooth_direction[1] = start->weft;
    start->point = march_mesh_point(march, &place);
    start->warp = march_mesh_unfolded(march, &start->point, start->warp);
    start->weft = march_mesh_unfolded(march, &start->point, start->weft);
    return STATUS_OK;
}

static bool needs_surface(const struct drape_generator *generator) {
    return generator->kind == DRAPE_GENERATOR_CURVE || generator->kind == DRAPE_GENERATOR_PLACES ||
           generator->kind == DRAPE_GENERATOR_STEERED;
}

enum status start_find_on_mesh(struct march *march, int *faulty) {
    const struct drape_settings *settings = march->settings;
    const struct mesh *mesh = march->mesh;
    struct march_start *start = &march->start;
    struct mesh_point place;
    double distance, reach = fmax(settings->spacing[0], settings->spacing[1]);
    if (settings->start_kind == DRAPE_START_UV || needs_surface(&settings->generator[0]) ||
        needs_surface(&settings->generator[1]))
        return STATUS_INVALID;
    bool by_point = settings->start_kind == DRAPE_START_POINT;
    int32_t component = by_point ? MESH_ANY : mesh_largest_component(mesh);
    struct vec3 target = by_point ? settings->start_point : mesh->components[component].centroid;
    if (!mesh_nearest(mesh, target, component, &place, &distance) ||
        (by_point && !(distance <= reach)))
        return STATUS_START_OFF_SURFACE;
    /* Onto the smooth surface: from the point asked for, so that it stays if it lies there; else,
     * or where that is beyond the rim, from the place on the triangles. */
    if (march->smooth) {
        struct mesh_point nearest = {place.triangle, settings->start_point};
        mesh_smooth_project(march->smooth, &nearest);
        if (by_point && mesh_smooth_follow(march->smooth, &nearest, true, 0) == MESH_NONE)
            place = nearest;
        mesh_smooth_project(march->smooth, &place);
    }
    start->point = march_mesh_point(march, &place);
    enum status status = find_warp(settings, vec3_make(0, 0, 0), start);
    return status == STATUS_OK ? find_generators(NULL, settings, start, faulty) : status;
}
