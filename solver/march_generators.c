/* SPDX-License-Identifier: MIT */
/* The four arms of the two generator yarns, as geodesics from the start. */
#include "march.h"

#include "correction.h"
#include "geodesic.h"

enum { CHORD_ROUNDS = 30 };

/* Relative accuracy of a chord along a generator. */
static const double chord_tolerance = 1e-13;

/* Moves the geodesic on until it is the chord d away from where it was: Newton on the length, for
 * which the chord grows at the cosine between chord and tangent. */
static bool advance_chord(struct geodesic *geodesic, struct surface_cursor *cursor, double d) {
    struct station from, to;
    struct vec3 tangent;
    if (!geodesic_station(geodesic, cursor, &from, NULL))
        return false;
    double length = d;
    for (int round = 0; round < CHORD_ROUNDS; round++) {
        struct geodesic ahead = *geodesic;
        if (!geodesic_advance(&ahead, length) || !geodesic_station(&ahead, cursor, &to, &tangent))
            return false;
        struct vec3 chord = vec3_sub(to.jet.r, from.jet.r);
        double size = vec3_norm(chord), rate = vec3_dot(chord, tangent) / size;
        if (fabs(size - d) <= chord_tolerance * d || round == CHORD_ROUNDS - 1) {
            *geodesic = ahead;
            return fabs(size - d) <= 1e3 * chord_tolerance * d;
        }
        if (!(rate > 0.1))
            return false;
        length += (d - size) / rate;
    }
    return false;
}

static bool advance(const struct march *march, struct geodesic *geodesic,
                    struct surface_cursor *cursor, double d) {
    return march->settings->method == DRAPE_BASIC ? advance_chord(geodesic, cursor, d)
                                                  : geodesic_advance(geodesic, d);
}

bool march_straight_on(struct march *march, const struct station *from, struct vec3 direction,
                       double d, struct station *station) {
    struct geodesic geodesic;
    return geodesic_start(&geodesic, march->surface, from, direction) &&
           advance(march, &geodesic, &march->cursor, d) &&
           geodesic_station(&geodesic, &march->cursor, station, NULL);
}

/* A generator on one side of the start, nodes k (di, dj), k = 1, 2, .. */
struct arm {
    struct geodesic geodesic;
    int di, dj;
    bool started, ended;
};

static struct arm make_arm(const struct march *march, int k) {
    int sign = k % 2 ? -1 : 1;
    bool warp = k < 2;
    struct vec3 direction = warp ? march->start.warp : march->start.weft;
    struct arm arm = {.di = warp ? sign : 0, .dj = warp ? 0 : sign};
    arm.started = geodesic_start(&arm.geodesic, march->surface, &march->start.station,
                                 vec3_scale(sign, direction));
    return arm;
}

/* To node k. In a second march the edge's chord is the corrected one, like those of the yarns
 * beside it, so that they fit to the last order. */
static bool advance_arm(struct march *march, struct arm *arm, int32_t k, double d) {
    double chord;
    if (march->before && correction_chord(march->before, (k - 1) * arm->di, (k - 1) * arm->dj,
                                          arm->di, arm->dj, d, &chord))
        return advance_chord(&arm->geodesic, &march->cursor, chord);
    return advance(march, &arm->geodesic, &march->cursor, d);
}

static enum status grow_arm(struct march *march, struct arm *arm, int32_t k) {
    struct station station;
    enum station_zone zone;
    int32_t i = k * arm->di, j = k * arm->dj;
    double d = march->settings->spacing[arm->dj != 0];
    arm->ended = true;
    if (!march_in_extent(march, i, j))
        return march_fail(march, i, j, DRAPE_REASON_EXTENT);
    if (!arm->started || !advance_arm(march, arm, k, d) ||
        !geodesic_station(&arm->geodesic, &march->cursor, &station, NULL))
        return march_fail(march, i, j, DRAPE_REASON_BOUNDARY);
    enum status status = march_place(march, i, j, &station, &zone);
    arm->ended = zone == STATION_BEYOND;
    return status;
}

/* All four side by side, so that on a closed surface they meet half way. */
enum status march_generators(struct march *march) {
    struct arm arms[4];
    enum station_zone zone;
    enum status status = march_place(march, 0, 0, &march->start.station, &zone);
    for (int a = 0; a < 4; a++)
        arms[a] = make_arm(march, a);
    bool going = true;
    for (int32_t k = 1; going && status == STATUS_OK; k++) {
        going = false;
        for (int a = 0; a < 4 && status == STATUS_OK; a++) {
            if (!arms[a].ended)
                status = grow_arm(march, &arms[a], k);
            going = going || !arms[a].ended;
        }
    }
    return status;
}
