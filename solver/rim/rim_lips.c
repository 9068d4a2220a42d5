/* SPDX-License-Identifier: MIT */
#include "rim_lips.h"

#include "solver/angle.h"
#include "solver/march/cuts.h"
#include <stdlib.h>
#include <string.h>

/* The points of a lip, from one end to the other, both included: the left one from the mouth to the
 * tip, the right one back. Points of cuts that begin on it are left out, the flat line goes
 * straight over their mouths. */
struct lip {
    const struct rim_point **points;
    size_t count;
};

static const struct rim_point *tip_of(const struct lip lip[2]) {
    return lip[1].points[0];
}

static void flat_place(const struct march *march, const struct rim_point *point, double xy[2]) {
    xy[0] = point->p * march->settings->spacing[0];
    xy[1] = point->q * march->settings->spacing[1];
}

static int32_t rim_lip_of(const struct rim *rim, size_t k) {
    return rim->lip_of[rim->points[k].sight];
}

/* The lip that begins at point `first` of the loop from `begin` to before `end`. */
static struct lip take_lip(const struct rim *rim, size_t begin, size_t end, size_t first,
                           const struct rim_point **points) {
    struct lip lip = {.points = points};
    int32_t number = rim_lip_of(rim, first);
    bool on = true; /* the last point was one of the lip */
    for (size_t n = 0, k = first; n < end - begin; n++, k = k + 1 < end ? k + 1 : begin) {
        int32_t own = rim_lip_of(rim, k);
        if (on || own == number)
            lip.points[lip.count++] = &rim->points[k];
        on = own == number;
        if (!on && abs(own) <= abs(number))
            break;
    }
    return lip;
}

/* Finds lip number `number`, as `drape_rim.cut` counts them: the rim leaves it on its way for the
 * lips of later cuts, which have greater numbers, and at its end for another line. `points` has
 * room for all of the rim. A lip without points if the rim has none of it. */
static struct lip find_rim_lip(const struct rim *rim, int32_t number,
                               const struct rim_point **points) {
    for (size_t begin = 0, end; begin < rim->count; begin = end) {
        for (end = begin; end < rim->count && rim->points[end].loop == rim->points[begin].loop;)
            end++;
        for (size_t k = begin, last = end - 1; k < end; last = k++)
            if (rim_lip_of(rim, k) == number && rim_lip_of(rim, last) != number &&
                abs(rim_lip_of(rim, last)) <= abs(number))
                return take_lip(rim, begin, end, k, points);
    }
    return (struct lip){.points = points};
}

/* An angle in degrees less whole turns, -180..180. */
static double within_turn(double degrees) {
    return degrees - 360 * floor((degrees + 180) / 360);
}

/* A place of a lip at a distance from its tip, in the flat cloth: between two of its points by
 * halving their parameters, and seen as well as can be. Point number k counts from the tip. */
static void place_from_tip(struct march *march, struct rim *rim, const struct lip *lip, bool right,
                           double far, double xy[2]) {
    enum { HALVINGS = 40 };
    const struct rim_point *near = NULL, *point = NULL;
    struct vec3 tip = lip->points[right ? 0 : lip->count - 1]->r;
    for (size_t k = 0; k < lip->count && !(point && vec3_distance(point->r, tip) >= far); k++) {
        near = point;
        point = lip->points[right ? k : lip->count - 1 - k];
    }
    const struct surface *surface = rim_edges_surface(march, point->face);
    struct surface_point at;
    double low = 0, high = 1, uv[2] = {point->uv[0], point->uv[1]};
    struct rim_cloth_point seen = {.p = point->p, .q = point->q};
    bool between = surface && near && near->face == point->face;
    for (int n = 0; n < HALVINGS && between; n++) {
        double share = (low + high) / 2;
        for (int k = 0; k < 2; k++)
            uv[k] = near->uv[k] + share * (point->uv[k] - near->uv[k]);
        if (!surface_point_at(surface, &march->cursor, uv, &at))
            break;
        *(vec3_distance(at.jet.r, tip) < far ? &low : &high) = share;
        seen.p = near->p + share * (point->p - near->p);
        seen.q = near->q + share * (point->q - near->q);
    }
    rim_cloth_look(&rim->cloth, point->sight, point->beside);
    if (surface && surface_point_at(surface, &march->cursor, uv, &at))
        (void)rim_cloth_see_well(&rim->cloth, &at, &seen);
    xy[0] = seen.p * march->settings->spacing[0];
    xy[1] = seen.q * march->settings->spacing[1];
}

/* The direction of a lip at its tip, in degrees: that of the chords between its places one, two and
 * three spacings away, of a short one thirds of it, half way between which they are one and a half
 * and two and a half, carried on to the tip. */
static double tip_direction(struct march *march, struct rim *rim, const struct lip *lip, bool right,
                            double length) {
    const double *d = march->settings->spacing;
    double step = fmin(fmin(d[0], d[1]), length / 3), xy[3][2], direction[2];
    for (int n = 0; n < 3; n++)
        place_from_tip(march, rim, lip, right, (n + 1) * step, xy[n]);
    for (int n = 0; n < 2; n++)
        direction[n] = angle_atan2_deg(xy[n + 1][1] - xy[n][1], xy[n + 1][0] - xy[n][0]);
    return direction[0] - 1.5 * within_turn(direction[1] - direction[0]);
}

/* The angle from the left lip to the right one at the tip. Of two that differ by a whole turn it is
 * the one below 0 if there is cloth on the far side of the tip, too, or if it is all but 0. */
static const double slit_angle = 0.5;

static double tip_angle(struct march *march, struct rim *rim, const struct lip lip[2],
                        double length) {
    double left = tip_direction(march, rim, &lip[0], false, length);
    double right = tip_direction(march, rim, &lip[1], true, length);
    double angle = within_turn(right - left), sine, cosine;
    angle_sincos_deg(left + angle / 2, &sine, &cosine);
    int32_t i = (int32_t)lround(tip_of(lip)->p - 2 * cosine);
    int32_t j = (int32_t)lround(tip_of(lip)->q - 2 * sine);
    return angle < -slit_angle && net_state_at(march->net, i, j) != NET_INSIDE ? angle + 360
                                                                               : angle;
}

/* A wedge of more than half a turn is closed by the arc about the tip, not by the chord from mouth
 * to mouth, which runs over cloth: the area between the two, the mouths, at (x, y) from the tip, at
 * their mean distance. */
static double beyond_chord(const double x[2], const double y[2], double angle_deg) {
    double radius2 = sqrt((x[0] * x[0] + y[0] * y[0]) * (x[1] * x[1] + y[1] * y[1])), sine, cosine;
    angle_sincos_deg(angle_deg, &sine, &cosine);
    return angle_deg > 180 ? radius2 * (angle_deg * M_PI / 180 - sine) / 2 : 0;
}

/* The area on the right of a lip's flat line, seen from where it begins, and its length on the
 * part.
 */
static double lip_area(const struct march *march, const struct lip *lip, double *length) {
    double origin[2], last[2] = {0, 0}, at[2], area = 0;
    flat_place(march, lip->points[0], origin);
    *length = 0;
    for (size_t k = 1; k < lip->count; k++) {
        flat_place(march, lip->points[k], at);
        at[0] -= origin[0];
        at[1] -= origin[1];
        area += (at[0] * last[1] - last[0] * at[1]) / 2;
        memcpy(last, at, sizeof last);
        *length += vec3_distance(lip->points[k]->r, lip->points[k - 1]->r);
    }
    return area;
}

/* Measures cut number `number`. The wedge lies between the left lip, the right one back, and the
 * chord from mouth to mouth. */
static void measure_cut(struct march *march, struct rim *rim, size_t number,
                        const struct rim_point **points, struct drape_cuts *cuts) {
    int32_t own = (int32_t)number + 1;
    struct lip lip[2] = {find_rim_lip(rim, own, points)};
    lip[1] = find_rim_lip(rim, -own, points + lip[0].count);
    cuts->length[number] = march->cuts->cut[number].length;
    cuts->mouth[number] = march->cuts->cut[number].lip[0][0].r;
    if (lip[0].count < 2 || lip[1].count < 2)
        return;
    const struct rim_point *tip = tip_of(lip), *left = lip[0].points[0],
                           *right = lip[1].points[lip[1].count - 1];
    double at[2], x[2], y[2], length[2], area = 0;
    for (int side = 0; side < 2; side++)
        area += lip_area(march, &lip[side], &length[side]);
    cuts->length[number] = length[0];
    cuts->mouth[number] = left->r;
    cuts->covered[number] = left->covered && tip->covered && right->covered;
    if (!cuts->covered[number])
        return;
    for (int side = 0; side < 2; side++) {
        double from[2];
        flat_place(march, tip, from);
        flat_place(march, side ? right : left, at);
        x[side] = at[0] - from[0];
        y[side] = at[1] - from[1];
    }
    double angle = tip_angle(march, rim, lip, length[0]);
    double width = sqrt((x[1] - x[0]) * (x[1] - x[0]) + (y[1] - y[0]) * (y[1] - y[0]));
    area += (x[0] * y[1] - x[1] * y[0]) / 2 + beyond_chord(x, y, angle);
    cuts->tip_angle_deg[number] = angle;
    cuts->area[number] = area;
    cuts->mouth_width[number] = area < 0 ? -width : width;
}

enum status rim_lips_measure(struct march *march, struct rim *rim, struct drape_cuts *cuts) {
    size_t count = march->settings->cut_count; /* without those to apexes, which come after */
    *cuts = (struct drape_cuts){.count = count};
    if (count == 0)
        return STATUS_OK;
    double **columns[] = {&cuts->length, &cuts->tip_angle_deg, &cuts->mouth_width, &cuts->area};
    for (int k = 0; k < 4; k++)
        if (!(*columns[k] = arena_alloc(march->arena, count, sizeof(double))))
            return STATUS_OUT_OF_MEMORY;
    const struct rim_point **points = arena_take(march->arena, 2 * rim->count, sizeof *points);
    cuts->mouth = arena_alloc(march->arena, count, sizeof *cuts->mouth);
    cuts->covered = arena_alloc(march->arena, count, sizeof *cuts->covered);
    if (!cuts->mouth || !cuts->covered || !points)
        return STATUS_OUT_OF_MEMORY;
    for (size_t k = 0; k < count; k++)
        measure_cut(march, rim, k, points, cuts);
    return STATUS_OK;
}
