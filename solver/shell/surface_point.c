/* SPDX-License-Identifier: MIT */
#include "surface_point.h"

#include "crossing.h"
#include "shell.h"

/* The continuation is trusted while its normal and its parameter lines have turned by less than 60
 * degrees from the boundary; a line from a pole points somewhere when it does so by less. */
static const double turned_cosine = 0.5;

/* It is trusted as far as this share of the way to where the lines at right angles to the boundary
 * meet. */
static const double before_focus = 0.75;

/* How closely the nearest place of a border is found, as a share of the domain. */
static const double border_accuracy = 1e-4;

/* A step longer than this share of the distance to a pole is taken through the pole's chart. */
static const double pole_share = 0.3;

/* A point this near to a pole is the pole: as a share of the surface's size, and of the magnitude
 * of coordinates, by which they are rounded. */
static const double at_pole = 1e-13, at_pole_rounding = 4e-15;

enum { POLE_SAMPLES = 64, POLE_REFINEMENTS = 40, POLE_TURNS = 8, BORDER_ROUNDS = 8 };

/* The line from a pole that is looked for is known when it points aside by less than this, as a
 * sine, before the last step of Newton's method: that leaves the square. */
static const double pole_sine = 1e-6;

/* Which tangent has vanished: 0 r_u, 1 r_v, -1 neither, 2 both. */
static int vanished_tangent(const struct surface *surface, const struct surface_point *point) {
    bool u = !(point->first[0] > surface->least_tangent2[0]);
    bool v = !(point->first[2] > surface->least_tangent2[1]);
    return u && v ? 2 : u ? 0 : v ? 1 : -1;
}

/* The limit of r_u x r_v / |..| at a place where one tangent vanishes: with r_u = 0 at an end of
 * v, r_u = r_uv dv a little inside, so the normal is that of (r_uv dv) x r_v; alike for u. Zero
 * where there is no limit: both vanish, or they are parallel. */
static struct vec3 limit_normal(const struct surface *surface, const struct surface_point *point) {
    const struct surface_jet *jet = &point->jet;
    int vanished = vanished_tangent(surface, point);
    if (vanished != 0 && vanished != 1)
        return vec3_make(0, 0, 0);
    const struct surface_axis *axis = &surface->axis[1 - vanished];
    double middle = (surface_axis_lower(axis) + surface_axis_upper(axis)) / 2;
    double inward = point->uv[1 - vanished] < middle ? 1 : -1;
    struct vec3 normal = vanished == 0 ? vec3_cross(jet->uv, jet->v) : vec3_cross(jet->u, jet->uv);
    double scale = vec3_norm(jet->uv) * vec3_norm(vanished == 0 ? jet->v : jet->u);
    if (!(vec3_norm(normal) > SURFACE_POINT_PARALLEL * scale))
        return vec3_make(0, 0, 0);
    return vec3_scale(surface->side * inward, vec3_unit(normal));
}

bool surface_point_complete(const struct surface *surface, struct surface_point *point) {
    point->surface = surface;
    if (!surface_point_first_form(surface, &point->jet, point->first, &point->normal))
        point->normal = limit_normal(surface, point);
    surface_point_second_form(&point->jet, point->normal, point->second);
    return vec3_norm2(point->normal) > 0;
}

bool surface_point_at_pole(const struct surface *surface, const struct surface_point *point) {
    return vanished_tangent(surface, point) >= 0;
}

bool surface_point_at(const struct surface *surface, struct surface_cursor *cursor,
                      const double uv[2], struct surface_point *point) {
    point->uv[0] = uv[0];
    point->uv[1] = uv[1];
    surface_jet_at(surface, cursor, uv[0], uv[1], &point->jet);
    return surface_point_complete(surface, point);
}

bool surface_point_nearest(const struct surface *surface, struct surface_cursor *cursor,
                           struct vec3 r, struct surface_point *point, double *distance) {
    struct shell_point nearest;
    double uv[2];
    if (!surface->shell) {
        surface_nearest_at(surface, r, uv, distance);
        return surface_point_at(surface, cursor, uv, point);
    }
    shell_nearest(surface->shell, r, shell_component(surface->shell, surface->face), &nearest,
                  distance);
    return surface_point_at(shell_surface(surface->shell, nearest.face), cursor, nearest.inner,
                            point);
}

bool surface_point_nearest_from(struct surface_cursor *cursor, const struct surface_point *near,
                                struct vec3 r, struct surface_point *point, double *distance) {
    const struct surface *surface = near->surface;
    double uv[2] = {near->uv[0], near->uv[1]};
    if (surface->shell) {
        struct shell_point place = {.face = surface->face, .inner = {uv[0], uv[1]}};
        shell_nearest_from(surface->shell, r, &place, distance);
        return surface_point_at(shell_surface(surface->shell, place.face), cursor, place.inner,
                                point);
    }
    if (surface->has_folds)
        surface_nearest_at(surface, r, uv, distance);
    else
        *distance = surface_nearest_from(surface, r, uv);
    return surface_point_at(surface, cursor, uv, point);
}

/* Two sides of a fold have less than this cosine between their normals. */
static const double over_fold = 0.9999;

bool surface_point_in_frame(struct surface_cursor *cursor, const struct surface_point *point,
                            struct surface_point *own) {
    return point->surface->has_folds && surface_point_at(point->surface, cursor, point->uv, own) &&
           vec3_dot(own->normal, point->normal) < over_fold;
}

/* A pole: the end of an axis where the domain's edge is one point. */
struct pole {
    int axis, end;
    double x; /* the parameter of `axis` there */
    struct vec3 point;
};

/* The pole nearest to `point`; false when the surface has none. */
static bool nearest_pole(const struct surface *surface, struct vec3 point, struct pole *pole) {
    double least = HUGE_VAL;
    if (!surface->has_poles)
        return false;
    for (int k = 0; k < 4; k++) {
        const struct surface_axis *axis = &surface->axis[k / 2];
        int end = k % 2;
        double distance = axis->pole[end] ? vec3_distance(point, axis->pole_point[end]) : HUGE_VAL;
        if (distance < least) {
            least = distance;
            *pole =
                (struct pole){k / 2, end, end ? surface_axis_upper(axis) : surface_axis_lower(axis),
                              axis->pole_point[end]};
        }
    }
    return least < HUGE_VAL;
}

double surface_point_pole_distance(const struct surface *surface, struct vec3 point,
                                   struct vec3 *pole) {
    struct pole nearest;
    if (!nearest_pole(surface, point, &nearest))
        return HUGE_VAL;
    *pole = nearest.point;
    return vec3_distance(point, nearest.point);
}

/* The tangent of the surface's line that leaves the pole at parameter w, and its derivative by w.
 */
static struct vec3 line_from_pole(const struct surface *surface, struct surface_cursor *cursor,
                                  const struct pole *pole, double w, struct vec3 *turning) {
    double uv[2], inward = pole->end ? -1 : 1;
    struct surface_jet jet;
    uv[pole->axis] = pole->x;
    uv[1 - pole->axis] = w;
    surface_jet_at(surface, cursor, uv[0], uv[1], &jet);
    *turning = vec3_scale(inward, jet.uv);
    return vec3_scale(inward, pole->axis == 0 ? jet.u : jet.v);
}

/* How well that line points along `direction` (unit): the cosine of the angle between them, and
 * the speed of the line. */
static double pole_alignment(const struct surface *surface, struct surface_cursor *cursor,
                             const struct pole *pole, double w, struct vec3 direction,
                             double *speed) {
    struct vec3 turning, line = line_from_pole(surface, cursor, pole, w, &turning);
    *speed = vec3_norm(line);
    return vec3_dot(vec3_unit(line), direction);
}

/* Newton's method for the line along `direction` from that at *w: the line l turns by
 * |l x l'| / |l|^2 for each of w. One that lies beyond the domain by more than half its length is
 * taken to be next to its border, as among samples. False when it does not lead to a line that
 * points there. */
static bool turn_to(const struct surface *surface, struct surface_cursor *cursor,
                    const struct pole *pole, struct vec3 direction, double *w, double *speed) {
    const struct surface_axis *around = &surface->axis[1 - pole->axis];
    double low = surface_axis_lower(around), width = surface_axis_length(around),
           high = low + width;
    for (int k = 0; k < POLE_TURNS; k++) {
        struct vec3 turning, line = line_from_pole(surface, cursor, pole, *w, &turning);
        struct vec3 normal = vec3_cross(line, turning), aside = vec3_cross(line, direction);
        double square = vec3_norm2(line), area = vec3_norm(normal);
        *speed = sqrt(square);
        double sine = vec3_dot(aside, normal) / (area * *speed);
        if (!(vec3_dot(line, direction) > turned_cosine * *speed) || !(fabs(sine) <= 1))
            return false;
        *w += sine * square / area;
        if (fabs(sine) < pole_sine)
            return true;
        if (around->closed || (*w > low - width / 2 && *w < high + width / 2))
            continue;
        *w = *w < low ? low - width / POLE_SAMPLES : high + width / POLE_SAMPLES;
        return pole_alignment(surface, cursor, pole, *w, direction, speed) > turned_cosine;
    }
    return false;
}

/* The line along `direction` among samples around the pole, refined by golden sections; false when
 * none points there. */
static bool search_line(const struct surface *surface, struct surface_cursor *cursor,
                        const struct pole *pole, struct vec3 direction, double *w, double *speed) {
    const struct surface_axis *around = &surface->axis[1 - pole->axis];
    double low = surface_axis_lower(around), width = surface_axis_length(around) / POLE_SAMPLES;
    double best = -2, at = low;
    for (int k = 0; k <= POLE_SAMPLES; k++) {
        double cosine = pole_alignment(surface, cursor, pole, low + k * width, direction, speed);
        if (cosine > best) {
            best = cosine;
            at = low + k * width;
        }
    }
    if (!(best > 0))
        return false;
    const double golden = 0.61803398874989485;
    double a = at - width, b = at + width, x = b - golden * (b - a), y = a + golden * (b - a);
    double fx = pole_alignment(surface, cursor, pole, x, direction, speed);
    double fy = pole_alignment(surface, cursor, pole, y, direction, speed);
    for (int k = 0; k < POLE_REFINEMENTS; k++) {
        if (fx > fy) {
            b = y;
            y = x;
            fy = fx;
            x = b - golden * (b - a);
            fx = pole_alignment(surface, cursor, pole, x, direction, speed);
        } else {
            a = x;
            x = y;
            fx = fy;
            y = a + golden * (b - a);
            fy = pole_alignment(surface, cursor, pole, y, direction, speed);
        }
    }
    *w = (a + b) / 2;
    best = pole_alignment(surface, cursor, pole, *w, direction, speed);
    return best > turned_cosine && *speed > 0;
}

/* The pole's own chart: direction and distance from it. The line that points at `target` is found
 * from that at uv or, where it does not lead there, among samples around the pole; false when none
 * points there. At the pole itself the other parameter means nothing and stays. */
static bool pull_through_pole(const struct surface *surface, struct surface_cursor *cursor,
                              const struct pole *pole, struct vec3 target, double uv[2]) {
    struct vec3 offset = vec3_sub(target, pole->point), direction = vec3_unit(offset);
    if (vec3_norm(offset) <= at_pole * surface->size + at_pole_rounding * surface->magnitude) {
        uv[pole->axis] = pole->x;
        return true;
    }
    double at = uv[1 - pole->axis], speed;
    if (!turn_to(surface, cursor, pole, direction, &at, &speed) &&
        !search_line(surface, cursor, pole, direction, &at, &speed))
        return false;
    uv[1 - pole->axis] = at;
    uv[pole->axis] = pole->x + (pole->end ? -1 : 1) * vec3_norm(offset) / speed;
    return true;
}

/* The parameters next to a point, by the tangent plane and how the surface bends. */
static bool pull_by_bend(const struct surface_point *from, struct vec3 step, double uv[2]) {
    double ab[2];
    if (!surface_point_components(from, step, ab))
        return false;
    struct vec3 bend = jet_bend(&from->jet, ab);
    if (!surface_point_components(from, vec3_axpy(-0.5, bend, step), ab))
        return false;
    uv[0] = from->uv[0] + ab[0];
    uv[1] = from->uv[1] + ab[1];
    return true;
}

/* The place of `target` on that face round a pole whose region holds it: by its own chart where the
 * face has the pole, else from its corner. False where none does. */
static bool pull_to_next_wedge(const struct surface *surface, struct surface_cursor *cursor,
                               const struct pole *pole, struct vec3 target,
                               struct surface_place *place) {
    const struct shell_corner *corners;
    size_t count = shell_round_pole(surface, 2 * pole->axis + pole->end, &corners);
    for (size_t k = 0; k < count; k++) {
        const struct surface *face = shell_surface(surface->shell, corners[k].face);
        struct surface_place there = {face, {corners[k].uv[0], corners[k].uv[1]}};
        struct surface_point corner;
        struct pole own;
        bool found;
        if (nearest_pole(face, pole->point, &own) &&
            vec3_distance(own.point, pole->point) <= 2 * shell_tolerance(surface->shell))
            found = pull_through_pole(face, cursor, &own, target, there.uv);
        else
            found = surface_point_at(face, cursor, there.uv, &corner) &&
                    pull_by_bend(&corner, vec3_sub(target, corner.jet.r), there.uv);
        if (found && crossing_within(face, there.uv)) {
            *place = there;
            return true;
        }
    }
    return false;
}

/* The pole near which parameters are not those by which a point moves so far; false where they are.
 */
static bool pole_beside(const struct surface_point *from, struct vec3 step, struct pole *pole) {
    return nearest_pole(from->surface, from->jet.r, pole) &&
           pole_share * vec3_distance(from->jet.r, pole->point) < vec3_norm(step);
}

bool surface_point_pull_on_face(struct surface_cursor *cursor, const struct surface_point *from,
                                struct vec3 step, double uv[2]) {
    struct pole pole;
    uv[0] = from->uv[0];
    uv[1] = from->uv[1];
    return pole_beside(from, step, &pole)
               ? pull_through_pole(from->surface, cursor, &pole, vec3_add(from->jet.r, step), uv)
               : pull_by_bend(from, step, uv);
}

bool surface_point_pull(struct surface_cursor *cursor, const struct surface_point *from,
                        struct vec3 step, struct surface_place *place) {
    struct pole pole;
    const struct surface *surface = from->surface;
    place->surface = surface;
    bool found = surface_point_pull_on_face(cursor, from, step, place->uv);
    if (surface->shell && pole_beside(from, step, &pole) &&
        !(found && crossing_within(surface, place->uv))) {
        struct vec3 target = vec3_add(from->jet.r, step);
        found = pull_to_next_wedge(surface, cursor, &pole, target, place) || found;
    }
    return found;
}

bool surface_point_move(struct surface_cursor *cursor, const struct surface_point *from,
                        struct vec3 step, struct surface_point *to) {
    struct surface_place place;
    return surface_point_pull(cursor, from, step, &place) &&
           surface_point_at(place.surface, cursor, place.uv, to);
}

/* Curvatures by parameters are wrong by rounding over the square of the distance to a pole, as a
 * share of the surface's size: at this share by 1e-6 of themselves. */
static const double beside_pole = 1e-5;

double surface_point_curvature(struct surface_cursor *cursor, const struct surface_point *point,
                               struct vec3 direction) {
    const struct surface *surface = point->surface;
    struct surface_point on;
    struct vec3 pole;
    if (!surface || !surface->has_poles ||
        surface_point_pole_distance(surface, point->jet.r, &pole) > beside_pole * surface->size)
        return surface_point_normal_curvature(point, direction);
    struct vec3 way = surface_point_tangent(point, direction);
    bool moved =
        surface_point_move(cursor, point, vec3_scale(2 * beside_pole * surface->size, way), &on);
    return surface_point_normal_curvature(moved ? &on : point, direction);
}

bool surface_point_principal(const struct surface_point *point, struct vec3 direction[2]) {
    struct vec3 a = vec3_unit(point->jet.u), b = vec3_cross(point->normal, a);
    double along = surface_point_normal_curvature(point, a);
    double across = surface_point_normal_curvature(point, b);
    double twist = surface_point_normal_curvature(point, vec3_add(a, b)) - (along + across) / 2;
    double half = (along - across) / 2, spread = sqrt(half * half + twist * twist);
    /* (cosine, sine) is the eigenvector of the larger one, the larger of the two by a root */
    double larger = sqrt((1 + fabs(half) / spread) / 2), smaller = twist / (2 * spread * larger);
    double cosine = half < 0 ? smaller : larger, sine = half < 0 ? larger : smaller;
    direction[0] = vec3_axpy(cosine, a, vec3_scale(sine, b));
    direction[1] = vec3_axpy(cosine, b, vec3_scale(-sine, a));
    return spread > 0;
}

/* A place of a part's boundary: the point, and the curvature of the boundary there, as a vector. */
struct border {
    struct surface_point point;
    struct vec3 bend;
};

/* With r' and r'' the derivatives of the boundary by its parameter. */
static struct vec3 curve_bend(struct vec3 first, struct vec3 second) {
    double along = vec3_dot(first, second) / vec3_norm2(first);
    return vec3_scale(1 / vec3_norm2(first), vec3_axpy(-along, first, second));
}

/* The place of the domain's border next to uv that is nearest to `r` in space: of the side that uv
 * lies beyond, or of two at a corner the nearer, by Newton's method for the least distance along
 * it. False where there is no tangent plane. */
static bool nearest_border(const struct surface *surface, struct surface_cursor *cursor,
                           struct vec3 r, const double uv[2], struct border *border) {
    double low[2], high[2], least = HUGE_VAL;
    for (int k = 0; k < 2; k++) {
        const struct surface_axis *axis = &surface->axis[k];
        low[k] = axis->closed ? -HUGE_VAL : surface_axis_lower(axis);
        high[k] = axis->closed ? HUGE_VAL : surface_axis_upper(axis);
    }
    for (int k = 0; k < 2; k++) {
        double at[2] = {fmin(fmax(uv[0], low[0]), high[0]), fmin(fmax(uv[1], low[1]), high[1])};
        double step = HUGE_VAL, *along = &at[1 - k];
        double arrived = border_accuracy * surface_axis_length(&surface->axis[1 - k]);
        struct surface_point place;
        if (at[k] == uv[k])
            continue;
        for (int round = 0; round < BORDER_ROUNDS && fabs(step) > arrived; round++) {
            place.uv[0] = at[0];
            place.uv[1] = at[1];
            surface_jet_at(surface, cursor, at[0], at[1], &place.jet);
            struct vec3 first = k ? place.jet.u : place.jet.v;
            struct vec3 second = k ? place.jet.uu : place.jet.vv, to = vec3_sub(r, place.jet.r);
            double rate = vec3_norm2(first) - vec3_dot(to, second), from = *along;
            step = vec3_dot(to, first) / fmax(rate, vec3_norm2(first) / 4);
            *along = fmin(fmax(from + step, low[1 - k]), high[1 - k]);
            step = *along - from;
        }
        double distance = vec3_distance(place.jet.r, r);
        if (!(distance < least) || !surface_point_complete(surface, &place))
            continue;
        least = distance;
        border->point = place;
        border->bend =
            k ? curve_bend(place.jet.u, place.jet.uu) : curve_bend(place.jet.v, place.jet.vv);
    }
    return least < HUGE_VAL;
}

/* Whether the parameter lines that lead from the boundary to a point have turned by less than 60
 * degrees on the way: where they turn back, or come round from infinite parameters, the polynomials
 * say nothing of the part. They are the same lines whatever the parametrisation, and wherever faces
 * are cut. */
static bool lines_lead_on(const struct surface_point *point, struct surface_cursor *cursor) {
    for (int k = 0; k < 2; k++) {
        const struct surface_axis *axis = &point->surface->axis[k];
        double low = surface_axis_lower(axis), high = surface_axis_upper(axis);
        double uv[2] = {point->uv[0], point->uv[1]};
        struct surface_jet border;
        uv[k] = axis->closed ? uv[k] : fmin(fmax(uv[k], low), high);
        if (uv[k] == point->uv[k])
            continue;
        surface_jet_at(point->surface, cursor, uv[0], uv[1], &border);
        struct vec3 before = k ? border.v : border.u, here = k ? point->jet.v : point->jet.u;
        if (!(vec3_dot(before, here) > turned_cosine * vec3_norm(before) * vec3_norm(here)))
            return false;
    }
    return true;
}

/* Whether the continuation is to be trusted at a point, by the boundary where that is nearest: not
 * far from it, turned by less than 60 degrees, not near where the lines at right angles to the
 * boundary meet, and where parameters still lead somewhere. */
static bool is_trusted(const struct surface_point *point, const struct border *border,
                       double reach) {
    struct vec3 offset = vec3_sub(point->jet.r, border->point.jet.r);
    struct surface_cursor cursor = {0, 0};
    return vec3_norm(offset) < reach &&
           vec3_dot(point->normal, border->point.normal) > turned_cosine &&
           vec3_dot(offset, border->bend) < before_focus && lines_lead_on(point, &cursor);
}

double surface_point_cut_turn(const struct surface *surface, int k) {
    const struct surface_axis *axis = &surface->axis[k], *other = &surface->axis[1 - k];
    bool cut = axis->closed && !other->pole[0] && !other->pole[1];
    return cut ? surface_axis_length(axis) / 2 : HUGE_VAL;
}

/* Beyond the cut its ghosts end a full turn from there. */
static enum surface_point_zone zone_round(const struct surface *surface, int k, double from,
                                          double to) {
    if (!surface->axis[k].closed)
        return SURFACE_POINT_INSIDE;
    double turns = fabs(to - from) / surface_point_cut_turn(surface, k);
    return turns <= 1 + SURFACE_POINT_BOUNDARY_WIDTH ? SURFACE_POINT_INSIDE
           : turns <= 3                              ? SURFACE_POINT_GHOST
                                                     : SURFACE_POINT_BEYOND;
}

bool surface_point_is_beyond(const struct surface_point *point, double slack) {
    const struct surface *surface = point->surface;
    bool beyond = false;
    for (int k = 0; k < 2; k++) {
        const struct surface_axis *axis = &surface->axis[k];
        double x = point->uv[k], low = surface_axis_lower(axis), high = surface_axis_upper(axis);
        if (axis->closed || (x >= low && x <= high))
            continue;
        double by = x < low ? low - x : x - high, speed2 = point->first[2 * k];
        beyond = beyond || by > slack * (high - low) ||
                 by * by * speed2 > slack * slack * surface->size * surface->size;
    }
    return beyond;
}

enum surface_point_zone surface_point_zone_on_face(const struct surface_point *point,
                                                   const struct crossing *crossing, double reach) {
    struct border border;
    struct vec3 tangent[2];
    if (crossing->kind == CROSSING_NONE ||
        crossing->distance <= shell_joint_width(point->surface->shell))
        return SURFACE_POINT_INSIDE;
    if (!surface_point_is_beyond(point, 0))
        return SURFACE_POINT_GHOST;
    if (!crossing_border(point, crossing, &border.point, tangent))
        return SURFACE_POINT_BEYOND;
    border.bend = curve_bend(tangent[0], tangent[1]);
    return is_trusted(point, &border, reach) ? SURFACE_POINT_GHOST : SURFACE_POINT_BEYOND;
}

bool surface_point_is_trusted(const struct surface_point *point, struct surface_cursor *cursor,
                              double reach) {
    struct border border;
    struct crossing crossing;
    if (!point->surface->shell)
        return nearest_border(point->surface, cursor, point->jet.r, point->uv, &border) &&
               is_trusted(point, &border, reach);
    crossing_find(point, NULL, &crossing);
    return surface_point_zone_on_face(point, &crossing, reach) != SURFACE_POINT_BEYOND;
}

enum surface_point_zone surface_point_zone(const struct surface *surface,
                                           struct surface_cursor *cursor, const double centre[2],
                                           const struct surface_point *point, double reach,
                                           enum drape_reason *reason) {
    struct border border;
    *reason = DRAPE_REASON_BOUNDARY;
    if (surface_point_is_beyond(point, SURFACE_POINT_BOUNDARY_WIDTH))
        return nearest_border(surface, cursor, point->jet.r, point->uv, &border) &&
                       is_trusted(point, &border, reach)
                   ? SURFACE_POINT_GHOST
                   : SURFACE_POINT_BEYOND;
    enum surface_point_zone zone_u = zone_round(surface, 0, centre[0], point->uv[0]);
    enum surface_point_zone zone_v = zone_round(surface, 1, centre[1], point->uv[1]);
    *reason = DRAPE_REASON_FOLD;
    return zone_u > zone_v ? zone_u : zone_v;
}
