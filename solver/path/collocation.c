/* SPDX-License-Identifier: MIT */
#include "collocation.h"

#include "solver/shell/crossing.h"
#include "solver/wide.h"
#include <string.h>

enum { ROOT_ROUNDS = 6 };

/* A point may lie beyond its span by this share of that. */
static const double slack = 1e-9;

/* Nearer to a pole than this many lengths parameters turn too fast. */
static const double pole_distance = 1.5;

/* The sine of the angle by which a surface turns at a fold. */
static const double least_fold = 1e-11;

/* A piece may become as short as this, by the path's length. */
static const double shortest = 1e-7;

const double collocation_point[COLLOCATION_POINTS] = {
    0.019855071751231884, 0.10166676129318664, 0.2372337950418355, 0.4082826787521751,
    0.591717321247825,    0.7627662049581645,  0.8983332387068134, 0.9801449282487681};

/* What each point counts in the terms of degree 6 and 7 in Legendre's polynomials of what is known
 * there. */
static const double last_terms[2][COLLOCATION_POINTS] = {
    {0.2098921910670315, -0.5591073831433645, 0.6166048635025358, -0.2673896714262035,
     -0.2673896714262035, 0.6166048635025358, -0.5591073831433645, 0.2098921910670315},
    {-0.11769245644771255, 0.37789693708459177, -0.6317745531190049, 0.7849065579218132,
     -0.7849065579218132, 0.6317745531190049, -0.37789693708459177, 0.11769245644771255}};

/* Terms fall by about this factor where eight points show a bend. */
static const double last_share = 0.3;

/* Half a piece has this share of the last terms; no piece is split into more than so many at once.
 */
static const double half_rest = 1.0 / 64;
enum { SPLITS_MOST = 8 };

static const struct collocation_kernel *kernel_for(int lanes) {
    int most = lanes ? lanes : COLLOCATION_POINTS;
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

static double guess_at(const struct collocation_guess *g, int k, double t, double *rate) {
    double way = g->to[k] - g->from[k];
    double c2 = 3 * way - 2 * g->leave[k] - g->arrive[k], c3 = g->leave[k] + g->arrive[k] - 2 * way;
    *rate = g->leave[k] + t * (2 * c2 + 3 * t * c3);
    return g->from[k] + t * (g->leave[k] + t * (c2 + t * c3));
}

/* A knot line of one direction, and where on the way it is met. */
struct meeting {
    int axis;
    double knot, t;
};

/* The knot lines of direction k between the ends, sorted in by the share of the way at which the
 * guess meets them; false when there are too many. */
static bool find_knot_lines(const struct surface_axis *axis, const struct collocation_guess *c,
                            int k, struct meeting *meeting, int *count) {
    struct surface_walk walk = surface_walk_begin(axis, c->from[k], c->to[k]);
    while (surface_walk_next(&walk)) {
        if (*count == COLLOCATION_PIECES - 1)
            return false;
        double low = 0, high = 1, t = (walk.at - c->from[k]) / (c->to[k] - c->from[k]), rate;
        for (int round = 0; round < ROOT_ROUNDS; round++) {
            double miss = walk.at - guess_at(c, k, t, &rate);
            *((miss > 0) == (c->to[k] > c->from[k]) ? &low : &high) = t;
            t += miss / rate;
            if (!(t > low && t < high))
                t = (low + high) / 2;
        }
        int n = (*count)++;
        for (; n > 0 && meeting[n - 1].t > t; n--)
            meeting[n] = meeting[n - 1];
        meeting[n] = (struct meeting){k, walk.at, t};
    }
    return true;
}

/* The piece k, in the span where its middle is, and where it ends. */
static void start_piece(struct collocation *path, int k) {
    const struct collocation_guess *guess = &path->guess;
    const struct surface *surface = path->from->surface;
    struct collocation_piece *piece = &path->piece[k];
    double begin = k ? path->share[k - 1] : 0, way = path->share[k] - begin, rate;
    for (int n = 0; n < 2; n++) {
        const struct surface_axis *axis = &surface->axis[n];
        double middle = guess_at(guess, n, begin + way / 2, &rate);
        double wrapped = surface_axis_wrap(axis, middle);
        piece->span[n] = surface_axis_span(axis, 0, wrapped);
        piece->turn[n] = middle - wrapped;
    }
    piece->begin = begin * path->length;
    piece->length = way * path->length;
    for (int p = 0; p < COLLOCATION_POINTS; p++) {
        double at = begin + way * collocation_point[p];
        struct vec3 ends = vec3_axpy(at * (3 * at - 2), guess->tangent[1],
                                     vec3_scale((1 - at) * (1 - 3 * at), guess->tangent[0]));
        struct vec3 tangent = vec3_axpy(6 * at * (1 - at), guess->mean, ends);
        const double of[3] = {tangent.x, tangent.y, tangent.z};
        for (int x = 0; x < 3; x++)
            piece->tangent[x][p] = of[x];
        for (int n = 0; n < 2; n++)
            piece->uv[n][p] = guess_at(guess, n, at, &rate);
    }
    int axis = path->axis[k];
    if (axis == COLLOCATION_ALONG)
        return;
    path->uv[k][axis] = path->knot[k];
    path->uv[k][1 - axis] = guess_at(guess, 1 - axis, path->share[k], &rate);
}

/* Splits piece k into into[k] pieces. False when there are too many. */
static bool split_pieces(struct collocation *path, const int *into) {
    int most = 0;
    for (int k = 0; k < path->pieces; k++)
        most += into[k];
    if (most > COLLOCATION_PIECES)
        return false;
    int at = most;
    for (int k = path->pieces - 1; k >= 0; k--) {
        double end = path->share[k], begin = k ? path->share[k - 1] : 0;
        for (int n = into[k]; n > 0; n--) {
            path->share[--at] = begin + (end - begin) * n / into[k];
            path->axis[at] = n < into[k] ? COLLOCATION_ALONG : path->axis[k];
            path->knot[at] = path->knot[k];
        }
    }
    path->pieces = most;
    for (int k = 0; k < most; k++)
        start_piece(path, k);
    return true;
}

/* Whether nothing but knot lines can lie between the ends. */
static bool is_free(const struct surface_point *from, const struct surface_point *to,
                    double length) {
    const struct surface *surface = from->surface;
    struct vec3 pole;
    if (to->surface != surface ||
        !(surface_point_pole_distance(surface, from->jet.r, &pole) > pole_distance * length))
        return false;
    if (!surface->shell)
        return true;
    double low[2], high[2];
    for (int k = 0; k < 2; k++) {
        double margin = fabs(to->uv[k] - from->uv[k]) / 8;
        low[k] = fmin(from->uv[k], to->uv[k]) - margin;
        high[k] = fmax(from->uv[k], to->uv[k]) + margin;
    }
    return crossing_all_within(surface, low, high);
}

/* The normal at uv as the piece's span has it. */
static struct vec3 span_normal(const struct surface *surface, const struct collocation_piece *piece,
                               const double uv[2]) {
    struct surface_jet jet;
    surface_evaluate_span(surface, piece->span[0], piece->span[1], uv[0] - piece->turn[0],
                          uv[1] - piece->turn[1], &jet);
    return vec3_scale(surface->side, vec3_unit(vec3_cross(jet.u, jet.v)));
}

static bool is_fold(struct vec3 normal, struct vec3 other) {
    return !(vec3_norm2(vec3_cross(normal, other)) < least_fold * least_fold);
}

/* False where the surface turns at a knot line on the way. */
bool collocation_begin(struct collocation *path, const struct surface_point *from,
                       const struct surface_point *to, const struct vec3 tangent[2], double length,
                       int each, int lanes) {
    const struct surface *surface = from->surface;
    struct collocation_guess *guess = &path->guess;
    struct meeting meeting[COLLOCATION_PIECES];
    int count = 0, into[COLLOCATION_PIECES];
    for (int k = 0; k < 2; k++) {
        guess->from[k] = from->uv[k];
        guess->to[k] = to->uv[k];
        guess->tangent[k] = tangent[k];
    }
    guess->mean = vec3_scale(1 / length, vec3_sub(to->jet.r, from->jet.r));
    if (!is_free(from, to, length) ||
        !surface_point_components(from, vec3_scale(length, tangent[0]), guess->leave) ||
        !surface_point_components(to, vec3_scale(length, tangent[1]), guess->arrive) ||
        !find_knot_lines(&surface->axis[0], guess, 0, meeting, &count) ||
        !find_knot_lines(&surface->axis[1], guess, 1, meeting, &count))
        return false;
    path->kernel = kernel_for(lanes);
    path->from = from;
    path->leave = tangent[0];
    path->length = length;
    path->pieces = count + 1;
    meeting[count] = (struct meeting){.axis = COLLOCATION_ALONG, .t = 1};
    for (int k = 0; k <= count; k++) {
        path->share[k] = meeting[k].t;
        path->axis[k] = meeting[k].axis;
        path->knot[k] = meeting[k].knot;
        into[k] = each;
    }
    if (!split_pieces(path, into))
        return false;
    for (int k = 0; surface->has_folds && k < path->pieces; k++)
        if (path->axis[k] != COLLOCATION_ALONG &&
            is_fold(span_normal(surface, &path->piece[k], path->uv[k]),
                    span_normal(surface, &path->piece[k + 1], path->uv[k])))
            return false;
    return true;
}

/* ---- from round to round ---- */

bool collocation_evaluate(struct collocation *path) {
    path->to = path->from->jet.r;
    path->arrive = path->leave;
    for (int k = 0; k < path->pieces; k++) {
        struct collocation_piece *piece = &path->piece[k];
        piece->from = path->to;
        piece->leave = path->arrive;
        path->kernel->evaluate(path->from->surface, piece);
        path->to = piece->to;
        path->arrive = piece->arrive;
    }
    return isfinite(path->to.x + path->to.y + path->to.z);
}

/* By the size of the last two terms of a piece's bend in Legendre's polynomials, times its length:
 * the last term's, or about that where it happens to vanish. */
bool collocation_refine(struct collocation *path, double most, bool *split) {
    int into[COLLOCATION_PIECES];
    *split = false;
    for (int k = 0; k < path->pieces; k++) {
        const struct collocation_piece *piece = &path->piece[k];
        double size2[2] = {0, 0};
        for (int x = 0; x < 3; x++)
            for (int n = 0; n < 2; n++) {
                double sum = 0;
                for (int p = 0; p < COLLOCATION_POINTS; p++)
                    sum += last_terms[n][p] * piece->bend[x][p];
                size2[n] += sum * sum;
            }
        double rest = piece->length * sqrt(fmax(last_share * last_share * size2[0], size2[1]));
        for (into[k] = 1; into[k] < SPLITS_MOST && rest > most; into[k] *= 2)
            rest *= half_rest;
        *split = *split || into[k] > 1;
    }
    return !*split || split_pieces(path, into);
}

/* Moves uv, where the path meets a knot line at the end of piece k, and says by how much further
 * along the path that is. */
static bool move_meeting(struct collocation *path, int k, struct vec3 turn, double *shift) {
    const struct surface *surface = path->from->surface;
    const struct collocation_piece *piece = &path->piece[k];
    struct surface_point at;
    double *uv = path->uv[k], ab[2], rate[2], end = piece->begin + piece->length;
    surface_evaluate_span(surface, piece->span[0], piece->span[1], uv[0] - piece->turn[0],
                          uv[1] - piece->turn[1], &at.jet);
    struct vec3 step = vec3_sub(vec3_axpy(end, turn, piece->to), at.jet.r);
    at.first[0] = vec3_norm2(at.jet.u);
    at.first[1] = vec3_dot(at.jet.u, at.jet.v);
    at.first[2] = vec3_norm2(at.jet.v);
    if (!surface_point_components(&at, step, ab) ||
        !surface_point_components(&at, vec3_add(piece->arrive, turn), rate))
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
    /* The ends of pieces between two knot lines, or between one and an end of the path, move as
     * those do: each by its share of the way. */
    for (int k = 0, first = 0; k < path->pieces; k++) {
        const struct collocation_piece *piece = path->piece;
        if (k + 1 < path->pieces && path->axis[k] == COLLOCATION_ALONG)
            continue;
        double begin = piece[first].begin, way = piece[k].begin + piece[k].length - begin;
        for (int n = first; n < k; n++)
            shift[n + 1] =
                shift[first] + (shift[k + 1] - shift[first]) * (piece[n + 1].begin - begin) / way;
        first = k + 1;
    }
    for (int k = 0; k < path->pieces; k++) {
        struct collocation_piece *piece = &path->piece[k];
        path->kernel->move(piece, turn, &shift[k]);
        piece->begin += shift[k];
        piece->length += shift[k + 1] - shift[k];
        if (!(piece->length > shortest * path->length))
            return HUGE_VAL;
        for (int n = 0; n < COLLOCATION_POINTS; n++)
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
        for (int n = 0; n < COLLOCATION_POINTS; n++) {
            double size2 = 0;
            for (int x = 0; x < 3; x++) {
                double by = path->piece[k].bend[x][n] - first[x];
                size2 += by * by;
            }
            most2 = size2 > most2 ? size2 : most2;
        }
    return sqrt(most2) * path->length;
}

bool collocation_is_whole(const struct collocation *path, const struct surface_point *end) {
    const struct surface *surface = path->from->surface;
    const struct collocation_piece *last = &path->piece[path->pieces - 1];
    bool within = true;
    for (int k = 0; k < path->pieces; k++)
        for (int n = 0; n < 2; n++) {
            const struct collocation_piece *piece = &path->piece[k];
            const struct surface_axis *axis = &surface->axis[n];
            int span = piece->span[n];
            double low = axis->breaks[span], high = axis->breaks[span + 1];
            double beyond = slack * (high - low), turn = piece->turn[n];
            low = span == 0 && !axis->closed ? -HUGE_VAL : low - beyond + turn;
            high = span == axis->span_count - 1 && !axis->closed ? HUGE_VAL : high + beyond + turn;
            for (int p = 0; p < COLLOCATION_POINTS; p++)
                within = within && piece->uv[n][p] >= low && piece->uv[n][p] <= high;
        }
    if (!within)
        return false;
    return !surface->has_folds ||
           (!is_fold(span_normal(surface, path->piece, path->from->uv), path->from->normal) &&
            !is_fold(span_normal(surface, last, end->uv), end->normal));
}
