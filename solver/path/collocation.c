/* SPDX-License-Identifier: MIT */
#include "collocation.h"

#include "solver/shell/crossing.h"
#include "solver/wide.h"
#include <string.h>

enum { ROOT_ROUNDS = 6 };

/* A place may lie beyond its span by this share of that. */
static const double slack = 1e-9;

/* Nearer to a pole than this many lengths parameters turn too fast. */
static const double pole_distance = 1.5;

/* The sine of the angle by which a surface turns at a fold. */
static const double least_fold = 1e-11;

/* A piece may become as short as this, by the path's length. */
static const double shortest = 1e-7;

/* Gauss's places. */
static const double place_of[COLLOCATION_PLACES] = {
    0.019855071751231884, 0.10166676129318664, 0.2372337950418355, 0.4082826787521751,
    0.591717321247825,    0.7627662049581645,  0.8983332387068134, 0.9801449282487681};

static const struct collocation_kernel *kernel_for(int lanes) {
    int most = lanes ? lanes : COLLOCATION_PLACES;
#if WIDE_FILES
    if (most >= 8 && wide_has(8))
        return &collocation_kernel_8;
    if (most >= 4 && wide_has(4))
        return &collocation_kernel_4;
#endif
    (void)most;
    return &collocation_kernel_2;
}

/* ---- the first path ---- */

/* The cubic from one (u, v) to another with these velocities there. */
struct cubic {
    double from[2], to[2], leave[2], arrive[2];
};

static double cubic_at(const struct cubic *c, int k, double t, double *rate) {
    double way = c->to[k] - c->from[k];
    double c2 = 3 * way - 2 * c->leave[k] - c->arrive[k], c3 = c->leave[k] + c->arrive[k] - 2 * way;
    *rate = c->leave[k] + t * (2 * c2 + 3 * t * c3);
    return c->from[k] + t * (c->leave[k] + t * (c2 + t * c3));
}

static bool make_cubic(const struct station *from, const struct station *to,
                       const struct vec3 tangent[2], double length, struct cubic *c) {
    memcpy(c->from, from->uv, sizeof c->from);
    memcpy(c->to, to->uv, sizeof c->to);
    return station_components(from, vec3_scale(length, tangent[0]), c->leave) &&
           station_components(to, vec3_scale(length, tangent[1]), c->arrive);
}

/* The share of the way at which the cubic meets the parameter `at`, which lies between its ends. */
static double cubic_meets(const struct cubic *c, int k, double at) {
    double low = 0, high = 1, t = (at - c->from[k]) / (c->to[k] - c->from[k]), rate;
    for (int round = 0; round < ROOT_ROUNDS; round++) {
        double miss = at - cubic_at(c, k, t, &rate);
        *((miss > 0) == (c->to[k] > c->from[k]) ? &low : &high) = t;
        t += miss / rate;
        if (!(t > low && t < high))
            t = (low + high) / 2;
    }
    return t;
}

/* A knot line of one direction, and where on the way it is met. */
struct meeting {
    int axis;
    double knot, t;
};

/* The knot lines of direction k between the ends, sorted in; false when there are too many. */
static bool find_meetings(const struct surface_axis *axis, const struct cubic *c, int k,
                          struct meeting *meeting, int *count) {
    struct surface_walk walk = surface_walk_begin(axis, c->from[k], c->to[k]);
    while (surface_walk_next(&walk)) {
        if (*count == COLLOCATION_PIECES - 1)
            return false;
        double t = cubic_meets(c, k, walk.at);
        int n = (*count)++;
        for (; n > 0 && meeting[n - 1].t > t; n--)
            meeting[n] = meeting[n - 1];
        meeting[n] = (struct meeting){k, walk.at, t};
    }
    return true;
}

/* The cubic in space with these ends and the unit tangents there, as its tangent at a share of the
 * way: on arcs right to fourth order in their turn. */
struct arc {
    struct vec3 mean, leave, arrive; /* the chord by the length of the way, and the tangents */
};

static struct vec3 arc_tangent(const struct arc *arc, double t) {
    struct vec3 ends =
        vec3_axpy(t * (3 * t - 2), arc->arrive, vec3_scale((1 - t) * (1 - 3 * t), arc->leave));
    return vec3_axpy(6 * t * (1 - t), arc->mean, ends);
}

/* The piece from one share of the way to another, in the span where its middle is. */
static void place_piece(const struct surface *surface, const struct cubic *c, const struct arc *arc,
                        double length, const double t[2], struct collocation_piece *piece) {
    double rate;
    for (int n = 0; n < 2; n++) {
        const struct surface_axis *axis = &surface->axis[n];
        double middle = cubic_at(c, n, (t[0] + t[1]) / 2, &rate);
        double wrapped = surface_axis_wrap(axis, middle);
        piece->span[n] = surface_axis_span(axis, 0, wrapped);
        piece->turn[n] = middle - wrapped;
    }
    piece->begin = t[0] * length;
    piece->length = (t[1] - t[0]) * length;
    for (int k = 0; k < COLLOCATION_PLACES; k++) {
        double at = t[0] + (t[1] - t[0]) * place_of[k];
        struct vec3 tangent = arc_tangent(arc, at);
        const double of[3] = {tangent.x, tangent.y, tangent.z};
        for (int x = 0; x < 3; x++)
            piece->tangent[x][k] = of[x];
        for (int n = 0; n < 2; n++)
            piece->uv[n][k] = cubic_at(c, n, at, &rate);
    }
}

/* Whether nothing but knot lines can lie between the ends. */
static bool is_free(const struct station *from, const struct station *to, double length) {
    const struct surface *surface = from->surface;
    struct vec3 pole;
    if (to->surface != surface ||
        !(station_pole_distance(surface, from->jet.r, &pole) > pole_distance * length))
        return false;
    if (!surface->shell)
        return true;
    double low[2], high[2];
    for (int k = 0; k < 2; k++) {
        double margin = fabs(to->uv[k] - from->uv[k]) / 8;
        low[k] = fmin(from->uv[k], to->uv[k]) - margin;
        high[k] = fmax(from->uv[k], to->uv[k]) + margin;
    }
    return crossing_none_within(surface, low, high);
}

/* The normal at uv as the piece's span has it. */
static struct vec3 normal_of(const struct surface *surface, const struct collocation_piece *piece,
                             const double uv[2]) {
    struct surface_jet jet;
    surface_evaluate_span(surface, piece->span[0], piece->span[1], uv[0] - piece->turn[0],
                          uv[1] - piece->turn[1], &jet);
    return vec3_scale(surface->side, vec3_unit(vec3_cross(jet.u, jet.v)));
}

static bool is_fold(struct vec3 normal, struct vec3 other) {
    return !(vec3_norm2(vec3_cross(normal, other)) < least_fold * least_fold);
}

/* Whether the surface turns at a knot line on the way. */
static bool crosses_fold(const struct collocation *path) {
    const struct surface *surface = path->from->surface;
    for (int k = 0; k < path->pieces; k++)
        if (path->axis[k] != COLLOCATION_ALONG &&
            is_fold(normal_of(surface, &path->piece[k], path->uv[k]),
                    normal_of(surface, &path->piece[k + 1], path->uv[k])))
            return true;
    return false;
}

bool collocation_begin(struct collocation *path, const struct station *from,
                       const struct station *to, const struct vec3 tangent[2], double length,
                       int parts, int lanes) {
    const struct surface *surface = from->surface;
    struct meeting meeting[COLLOCATION_PIECES];
    struct cubic c;
    int count = 0;
    if (!is_free(from, to, length) || !make_cubic(from, to, tangent, length, &c) ||
        !find_meetings(&surface->axis[0], &c, 0, meeting, &count) ||
        !find_meetings(&surface->axis[1], &c, 1, meeting, &count) ||
        (count + 1) * parts > COLLOCATION_PIECES)
        return false;
    path->kernel = kernel_for(lanes);
    path->from = from;
    path->leave = tangent[0];
    path->length = length;
    path->pieces = (count + 1) * parts;
    const struct arc arc = {vec3_scale(1 / length, vec3_sub(to->jet.r, from->jet.r)), tangent[0],
                            tangent[1]};
    meeting[count] = (struct meeting){.axis = COLLOCATION_ALONG, .t = 1};
    for (int k = 0; k < path->pieces; k++) {
        const struct meeting *next = &meeting[k / parts];
        double begin = k < parts ? 0 : next[-1].t, way = next->t - begin, rate;
        const double t[2] = {begin + way * (k % parts) / parts,
                             begin + way * (k % parts + 1) / parts};
        place_piece(surface, &c, &arc, length, t, &path->piece[k]);
        int axis = path->axis[k] = (k + 1) % parts ? COLLOCATION_ALONG : next->axis;
        if (axis == COLLOCATION_ALONG)
            continue;
        path->knot[k] = path->uv[k][axis] = next->knot;
        path->uv[k][1 - axis] = cubic_at(&c, 1 - axis, next->t, &rate);
    }
    return !surface->has_folds || !crosses_fold(path);
}

/* ---- from turn to turn ---- */

bool collocation_lay(struct collocation *path) {
    path->to = path->from->jet.r;
    path->arrive = path->leave;
    for (int k = 0; k < path->pieces; k++) {
        struct collocation_piece *piece = &path->piece[k];
        piece->from = path->to;
        piece->leave = path->arrive;
        path->kernel->lay(path->from->surface, piece);
        path->to = piece->to;
        path->arrive = piece->arrive;
    }
    return isfinite(path->to.x + path->to.y + path->to.z);
}

/* Moves uv, where the path meets a knot line at the end of piece k, and says by how much further
 * along the path that is. */
static bool move_meeting(struct collocation *path, int k, struct vec3 turn, double *shift) {
    const struct surface *surface = path->from->surface;
    const struct collocation_piece *piece = &path->piece[k];
    struct station at;
    double *uv = path->uv[k], ab[2], rate[2], end = piece->begin + piece->length;
    surface_evaluate_span(surface, piece->span[0], piece->span[1], uv[0] - piece->turn[0],
                          uv[1] - piece->turn[1], &at.jet);
    struct vec3 step = vec3_sub(vec3_axpy(end, turn, piece->to), at.jet.r);
    at.first[0] = vec3_norm2(at.jet.u);
    at.first[1] = vec3_dot(at.jet.u, at.jet.v);
    at.first[2] = vec3_norm2(at.jet.v);
    if (!station_components(&at, step, ab) ||
        !station_components(&at, vec3_add(piece->arrive, turn), rate))
        return false;
    int axis = path->axis[k];
    for (int n = 0; n < 2; n++)
        uv[n] += ab[n];
    *shift = (path->knot[k] - uv[axis]) / rate[axis];
    uv[1 - axis] += *shift * rate[1 - axis];
    uv[axis] = path->knot[k];
    return isfinite(*shift);
}

double collocation_move(struct collocation *path, double angle) {
    struct vec3 before = path->leave, left = vec3_cross(path->from->normal, before);
    double shift[COLLOCATION_PIECES + 1] = {0}, most2 = 0;
    path->leave = vec3_unit(vec3_axpy(angle, left, before));
    struct vec3 turn = vec3_sub(path->leave, before);
    for (int k = 0; k + 1 < path->pieces; k++) {
        if (path->axis[k] != COLLOCATION_ALONG && !move_meeting(path, k, turn, &shift[k + 1]))
            return HUGE_VAL;
        most2 = fmax(most2, shift[k + 1] * shift[k + 1]);
    }
    for (int k = 0; k < path->pieces; k++) {
        struct collocation_piece *piece = &path->piece[k];
        path->kernel->move(piece, turn, &shift[k]);
        piece->begin += shift[k];
        piece->length += shift[k + 1] - shift[k];
        if (!(piece->length > shortest * path->length))
            return HUGE_VAL;
        for (int n = 0; n < COLLOCATION_PLACES; n++)
            most2 = piece->moved2[n] <= most2 ? most2 : piece->moved2[n];
    }
    return sqrt(most2);
}

/* ---- what has become of it ---- */

double collocation_change(const struct collocation *path) {
    double first[3], most2 = 0;
    for (int x = 0; x < 3; x++)
        first[x] = path->piece[0].bend[x][0];
    for (int k = 0; k < path->pieces; k++)
        for (int n = 0; n < COLLOCATION_PLACES; n++) {
            double size2 = 0;
            for (int x = 0; x < 3; x++) {
                double by = path->piece[k].bend[x][n] - first[x];
                size2 += by * by;
            }
            most2 = size2 > most2 ? size2 : most2;
        }
    return sqrt(most2) * path->length;
}

static bool in_spans(const struct collocation *path) {
    bool within = true;
    for (int k = 0; k < path->pieces; k++)
        for (int n = 0; n < 2; n++) {
            const struct collocation_piece *piece = &path->piece[k];
            const struct surface_axis *axis = &path->from->surface->axis[n];
            int span = piece->span[n];
            double low = axis->breaks[span], high = axis->breaks[span + 1];
            double beyond = slack * (high - low);
            low = span == 0 && !axis->closed ? -HUGE_VAL : low - beyond + piece->turn[n];
            high = span == axis->span_count - 1 && !axis->closed ? HUGE_VAL
                                                                 : high + beyond + piece->turn[n];
            for (int p = 0; p < COLLOCATION_PLACES; p++)
                within = within && piece->uv[n][p] >= low && piece->uv[n][p] <= high;
        }
    return within;
}

bool collocation_is_whole(const struct collocation *path, const struct station *end) {
    const struct surface *surface = path->from->surface;
    const struct collocation_piece *last = &path->piece[path->pieces - 1];
    if (!in_spans(path))
        return false;
    return !surface->has_folds ||
           (!is_fold(normal_of(surface, path->piece, path->from->uv), path->from->normal) &&
            !is_fold(normal_of(surface, last, end->uv), end->normal));
}
