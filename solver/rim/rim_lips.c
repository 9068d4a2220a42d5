/* SPDX-License-Identifier: MIT */
#include "rim_lips.h"

#include "solver/angle.h"
#include "solver/march/cuts.h"

/* The points of a lip, in the flat cloth and on the part. The rim has its ends once: the tip with
 * the right lip, that at the edge with the left one. */
struct lip {
    size_t first, count;
    bool backwards; /* the rim runs from the tip */
};

/* Its point number k, counted towards the tip. */
static const struct rim_point *lip_point(const struct rim *rim, const struct lip *lip, size_t k) {
    return &rim->points[lip->first + (lip->backwards ? lip->count - 1 - k : k)];
}

static void flat_place(const struct march *march, const struct rim_point *point, double xy[2]) {
    xy[0] = point->p * march->settings->spacing[0];
    xy[1] = point->q * march->settings->spacing[1];
}

/* The points of a lip; the right one ends where the rim goes on along the edge. */
static struct lip find_lip(const struct rim *rim, int32_t sight, bool right) {
    struct lip lip = {.backwards = right};
    while (lip.first < rim->count && rim->points[lip.first].sight != sight)
        lip.first++;
    while (lip.first + lip.count < rim->count && rim->points[lip.first + lip.count].sight == sight)
        lip.count++;
    return lip;
}

/* An angle in degrees less whole turns, -180..180. */
static double within_turn(double degrees) {
    return degrees - 360 * floor((degrees + 180) / 360);
}

/* The direction of a lip at its tip, in degrees: that of the chords between its places one, two and
 * three spacings away, half way between which they are one and a half and two and a half, carried
 * on to the tip. */
static double tip_direction(struct march *march, struct rim *rim, const struct lip *lip) {
    const double *d = march->settings->spacing;
    double xy[3][2] = {{0, 0}}, direction[2];
    size_t k = lip->count - 1;
    struct vec3 tip = lip_point(rim, lip, k)->r;
    for (int n = 0; n < 3; n++) {
        double far = (n + 1) * fmin(d[0], d[1]);
        while (k > 0 && vec3_distance(lip_point(rim, lip, k)->r, tip) < far)
            k--;
        const struct rim_point *point = lip_point(rim, lip, k);
        const struct surface *surface = rim_edges_surface(march, point->face);
        struct surface_point at;
        struct rim_cloth_point seen = {.p = point->p, .q = point->q};
        rim_cloth_look(&rim->cloth, point->sight, point->beside);
        if (surface && surface_point_at(surface, &march->cursor, point->uv, &at))
            (void)rim_cloth_see_well(&rim->cloth, &at, &seen);
        xy[n][0] = seen.p * d[0];
        xy[n][1] = seen.q * d[1];
    }
    for (int n = 0; n < 2; n++)
        direction[n] = angle_atan2_deg(xy[n + 1][1] - xy[n][1], xy[n + 1][0] - xy[n][0]);
    return direction[0] - 1.5 * within_turn(direction[1] - direction[0]);
}

/* The angle from the left lip to the right one at the tip. Of two that differ by a whole turn it is
 * the one below 0 if there is cloth on the far side of the tip, too. */
static double tip_angle(struct march *march, struct rim *rim, const struct lip lip[2]) {
    const struct rim_point *point = lip_point(rim, &lip[1], lip[1].count - 1);
    double left = tip_direction(march, rim, &lip[0]);
    double right = tip_direction(march, rim, &lip[1]);
    double angle = within_turn(right - left), sine, cosine;
    angle_sincos_deg(left + angle / 2, &sine, &cosine);
    int32_t i = (int32_t)lround(point->p - 2 * cosine);
    int32_t j = (int32_t)lround(point->q - 2 * sine);
    return angle < 0 && net_state_at(march->net, i, j) != NET_INSIDE ? angle + 360 : angle;
}

/* A wedge of more than half a turn is closed by the arc about the tip, not by the chord from mouth
 * to mouth, which runs over cloth: the area between the two, the mouths at their mean distance. */
static double beyond_chord(const double tip[2], const double left[2], const double right[2],
                           double angle_deg) {
    double x[2] = {left[0] - tip[0], right[0] - tip[0]}, sine, cosine;
    double y[2] = {left[1] - tip[1], right[1] - tip[1]};
    double radius2 = sqrt((x[0] * x[0] + y[0] * y[0]) * (x[1] * x[1] + y[1] * y[1]));
    angle_sincos_deg(angle_deg, &sine, &cosine);
    return angle_deg > 180 ? radius2 * (angle_deg * M_PI / 180 - sine) / 2 : 0;
}

static void measure_cut(struct march *march, struct rim *rim, size_t number,
                        struct drape_cuts *cuts) {
    const struct rim_lips *lips = &rim->lips[number];
    struct lip lip[2] = {find_lip(rim, lips->left, false), find_lip(rim, lips->right, true)};
    double last[2], first[2], at[2], area = 0;
    cuts->length[number] = march->cuts->cut[number].length;
    if (lip[0].count < 3 || lip[1].count < 3)
        return;
    /* the wedge: along the left lip, back along the right one, and from mouth to mouth */
    struct vec3 place = rim->points[lip[0].first].r;
    flat_place(march, &rim->points[lip[0].first], first);
    last[0] = first[0];
    last[1] = first[1];
    cuts->mouth[number] = place;
    cuts->length[number] = 0;
    for (size_t side = 0; side < 2; side++)
        for (size_t k = 0; k < lip[side].count; k++) {
            const struct rim_point *point = &rim->points[lip[side].first + k];
            flat_place(march, point, at);
            area += (at[0] * last[1] - last[0] * at[1]) / 2;
            last[0] = at[0];
            last[1] = at[1];
            cuts->length[number] += side == 0 || k == 0 ? vec3_distance(point->r, place) : 0;
            place = point->r;
        }
    /* the place behind the last one of the right lip is its end at the edge */
    size_t behind = lip[1].first + lip[1].count;
    if (behind == rim->count || rim->points[behind].loop != rim->points[behind - 1].loop)
        for (behind = lip[1].first;
             behind > 0 && rim->points[behind - 1].loop == rim->points[behind].loop;)
            behind--;
    flat_place(march, &rim->points[behind], at);
    area += (at[0] * last[1] - last[0] * at[1] + first[0] * at[1] - at[0] * first[1]) / 2;
    double width =
        sqrt((at[0] - first[0]) * (at[0] - first[0]) + (at[1] - first[1]) * (at[1] - first[1]));
    double angle = tip_angle(march, rim, lip), tip[2];
    flat_place(march, lip_point(rim, &lip[1], lip[1].count - 1), tip);
    cuts->tip_angle_deg[number] = angle;
    cuts->area[number] = area + beyond_chord(tip, first, at, angle);
    cuts->mouth_width[number] = cuts->area[number] < 0 ? -width : width;
}

enum status rim_lips_measure(struct march *march, struct rim *rim, struct drape_cuts *cuts) {
    size_t count = march->cuts ? march->cuts->count : 0;
    *cuts = (struct drape_cuts){.count = count};
    double **columns[] = {&cuts->length, &cuts->tip_angle_deg, &cuts->mouth_width, &cuts->area};
    for (int k = 0; k < 4 && count; k++)
        if (!(*columns[k] = arena_alloc(march->arena, count, sizeof(double))))
            return STATUS_OUT_OF_MEMORY;
    cuts->mouth = arena_alloc(march->arena, count, sizeof *cuts->mouth);
    if (!cuts->mouth)
        return STATUS_OUT_OF_MEMORY;
    for (size_t k = 0; k < count; k++)
        measure_cut(march, rim, k, cuts);
    return STATUS_OK;
}
