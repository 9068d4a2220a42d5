/* SPDX-License-Identifier: MIT */
/*
 * The nearest point of a surface, by branch and bound (`bounds.h`) on the square of the distance,
 *
 *   f(u, v) = |r(u, v) - q|^2 = N / W,  N = |sum_k B_k (P_k - q w_k)|^2,  W = (sum_k B_k w_k)^2,
 *
 * a rational Bezier function of twice the degree on every span. Newton's method on the span that
 * is nearest at a glance gives a first distance D. A span is then left out when a plane at D from
 * q has all its control points beyond it, which holds for nearly all; of the others, so are the
 * cells whose coefficients N_k / W_k are all at least D^2, and those where N - D^2 W is convex and
 * Newton's method inside the cell leads to nothing nearer. So neither creases between spans nor
 * other local minima can hide the nearest point, and a sphere seen from its centre, where
 * N = D^2 W exactly, is settled at once.
 *
 * Measured on surfaces of 8 x 8 and of 100 x 100 spans alike, on average: none to four spans looked
 * into, up to 27 cells, and one to five runs of Newton's method of about four steps.
 */
#include "bounds.h"
#include "spans.h"

#include <float.h>

enum {
    SAMPLES = 4, /* of the first span, in each direction */
    NEWTON_MAX = 60,
    HALVINGS_MAX = 40,
    CROSSINGS_MAX = 1000 /* of span borders; each brings the point nearer */
};

/* What the distance may exceed the least one by, as a share of the surface's size. */
static const double tolerance = 1e-10;

/* A slope of the distance, along the surface, that counts as zero for what Newton's method found:
 * as a share of size and distance. It mostly ends at 1e-15. */
static const double level_slope = 1e-10;

/* Eigenvalues of the scaled Hessian less than this share of the greater one are taken for it. */
static const double least_curvature = 1e-6;

/* Beside a pole a tangent counts, down to a thousandth of what has vanished elsewhere: points a
 * billionth of the size away are distinguished. */
static const double pole_share2 = 1e-6;

/* So close to a pole, as a share of the span, a descent may have been held up by it; it is left
 * when that gains so much, as a share of the surface's size, that it is not rounding. */
static const double pole_vicinity = 1e-6, pole_gain = 1e-12;

/* A point that may be the nearest. */
struct candidate {
    int span[2];
    double uv[2], distance;
};

/* A rectangle within a span. */
struct box {
    int span[2];
    double lower[2], upper[2];
};

struct search {
    const struct surface *surface;
    struct vec3 target;
    struct candidate best;
    int span[2]; /* being searched */
    struct bounds_search *bounds;
};

static const vec4 *span_points(const struct surface *surface, int su, int sv) {
    size_t span = (size_t)su * (size_t)surface->axis[1].span_count + (size_t)sv;
    return surface->points + span * surface->points_per_span;
}

/* ---- Newton's method within a box ---- */

static double distance_at(const struct search *search, const struct box *box, const double uv[2],
                          struct surface_jet *jet) {
    surface_evaluate_span(search->surface, box->span[0], box->span[1], uv[0], uv[1], jet);
    return vec3_distance(jet->r, search->target);
}

/* What Newton's method needs of f / 2 in lengths along the surface: with t_k = r_k / |r_k|, the
 * gradient g_k = o . t_k for the offset o = r - q, and the Hessian
 * h_kl = (r_k . r_l + o . r_kl) / (|r_k| |r_l|). */
struct slope {
    double length[2]; /* |r_u|, |r_v| */
    double gradient[2];
    double uu, uv, vv; /* the Hessian */
    bool held[2];      /* descent leads out of the box, or the tangent has vanished */
    double norm;       /* of what is not held */
};

static struct slope distance_slope(const struct search *search, const struct box *box,
                                   const double at[2], const struct surface_jet *jet) {
    struct vec3 offset = vec3_sub(jet->r, search->target), tangent[2] = {jet->u, jet->v};
    struct slope s = {.norm = 0};
    for (int k = 0; k < 2; k++) {
        double length2 = vec3_norm2(tangent[k]);
        s.held[k] = !(length2 > pole_share2 * search->surface->least_tangent2[k]);
        s.length[k] = s.held[k] ? 1 : sqrt(length2);
        s.gradient[k] = vec3_dot(offset, tangent[k]) / s.length[k];
        s.held[k] = s.held[k] || (at[k] <= box->lower[k] && s.gradient[k] >= 0) ||
                    (at[k] >= box->upper[k] && s.gradient[k] <= 0);
        if (!s.held[k])
            s.norm = fmax(s.norm, fabs(s.gradient[k]));
    }
    double a = s.length[0], b = s.length[1];
    s.uu = (vec3_norm2(jet->u) + vec3_dot(offset, jet->uu)) / (a * a);
    s.uv = (vec3_dot(jet->u, jet->v) + vec3_dot(offset, jet->uv)) / (a * b);
    s.vv = (vec3_norm2(jet->v) + vec3_dot(offset, jet->vv)) / (b * b);
    return s;
}

/* |H|^-1 g: Newton's step where H is positive definite, and downhill also where it is not. The
 * projection on the first eigenvector is (H - l2) / (l1 - l2). */
static void solve_hessian(const struct slope *s, double x[2]) {
    double middle = (s->uu + s->vv) / 2, half = (s->uu - s->vv) / 2;
    double radius = sqrt(half * half + s->uv * s->uv);
    double l1 = middle + radius, l2 = middle - radius, gu = s->gradient[0], gv = s->gradient[1];
    double floor_value = fmax(least_curvature * fmax(fabs(l1), fabs(l2)), DBL_MIN);
    if (l2 > floor_value) {
        double determinant = s->uu * s->vv - s->uv * s->uv;
        x[0] = (s->vv * gu - s->uv * gv) / determinant;
        x[1] = (s->uu * gv - s->uv * gu) / determinant;
        return;
    }
    double inverse1 = 1 / fmax(fabs(l1), floor_value), inverse2 = 1 / fmax(fabs(l2), floor_value);
    double first[2] = {gu, gv};
    if (radius > 0) {
        first[0] = (s->uu * gu + s->uv * gv - l2 * gu) / (2 * radius);
        first[1] = (s->uv * gu + s->vv * gv - l2 * gv) / (2 * radius);
    }
    x[0] = inverse1 * first[0] + inverse2 * (gu - first[0]);
    x[1] = inverse1 * first[1] + inverse2 * (gv - first[1]);
}

/* Moves `candidate` to a minimum of the distance within the box that holds it; whether the slope
 * vanishes there. Distances are flat at a minimum, so close to it, where they differ by rounding,
 * the slope has to decrease instead. */
static bool descend_in_box(const struct search *search, const struct box *box,
                           struct candidate *candidate) {
    const struct surface *surface = search->surface;
    struct surface_jet jet;
    candidate->distance = distance_at(search, box, candidate->uv, &jet);
    struct slope slope = distance_slope(search, box, candidate->uv, &jet);
    for (int round = 0; round < NEWTON_MAX && slope.norm > 0; round++) {
        double step[2], x[2], noise = 8 * DBL_EPSILON * (candidate->distance + surface->magnitude);
        bool moved = false;
        /* Where a bound holds one parameter, or the joint step would push against it, each goes its
         * own way. */
        solve_hessian(&slope, x);
        bool alone = slope.held[0] || slope.held[1];
        for (int k = 0; k < 2; k++)
            alone = alone || (candidate->uv[k] <= box->lower[k] && x[k] > 0) ||
                    (candidate->uv[k] >= box->upper[k] && x[k] < 0);
        for (int k = 0; k < 2; k++) {
            double h = fabs(k == 0 ? slope.uu : slope.vv);
            if (alone)
                x[k] = slope.held[k] ? 0 : slope.gradient[k] / (h > least_curvature ? h : 1);
            step[k] = -x[k] / slope.length[k];
        }
        for (int h = 0; h < HALVINGS_MAX && !moved; h++) {
            double uv[2];
            for (int k = 0; k < 2; k++) {
                uv[k] = fmin(fmax(candidate->uv[k] + step[k], box->lower[k]), box->upper[k]);
                step[k] /= 2;
            }
            double distance = distance_at(search, box, uv, &jet);
            bool even = fabs(distance - candidate->distance) <= noise;
            if (!even && !(distance < candidate->distance))
                continue;
            struct slope next = distance_slope(search, box, uv, &jet);
            if (even && !(next.norm < slope.norm / 2))
                break;
            *candidate = (struct candidate){{box->span[0], box->span[1]}, {uv[0], uv[1]}, distance};
            slope = next;
            moved = true;
        }
        if (!moved)
            break;
    }
    return slope.norm <= level_slope * (surface->size + candidate->distance);
}

/* ---- spans and their neighbours ---- */

/* The parameter of a share of a span; its ends are the knots themselves. */
static double parameter(const struct surface_axis *axis, int span, double share) {
    const double *b = &axis->breaks[span];
    return share >= 1 ? b[1] : fmin(b[0] + share * (b[1] - b[0]), b[1]);
}

static struct box span_box(const struct surface *surface, int su, int sv) {
    const double *bu = &surface->axis[0].breaks[su], *bv = &surface->axis[1].breaks[sv];
    return (struct box){{su, sv}, {bu[0], bv[0]}, {bu[1], bv[1]}};
}

/* The span beyond the border of `candidate` that it lies on, and its parameter there. */
static bool neighbour_span(const struct surface_axis *axis, int *span, double *x) {
    int last = axis->span_count - 1, at = *span;
    if (*x <= axis->breaks[at] && (at > 0 || axis->closed)) {
        *span = at > 0 ? at - 1 : last;
        *x = axis->breaks[*span + 1];
        return true;
    }
    if (*x >= axis->breaks[at + 1] && (at < last || axis->closed)) {
        *span = at < last ? at + 1 : 0;
        *x = axis->breaks[*span];
        return true;
    }
    return false;
}

/* Goes on from a candidate on the border of its span into the up to three spans that share it. */
static bool cross_border(const struct search *search, struct candidate *candidate) {
    const struct surface *surface = search->surface;
    for (int which = 1; which <= 3; which++) {
        struct candidate next = *candidate;
        bool shared = true;
        for (int k = 0; k < 2; k++)
            if (which & (1 << k))
                shared = shared && neighbour_span(&surface->axis[k], &next.span[k], &next.uv[k]);
        if (!shared)
            continue;
        struct box box = span_box(surface, next.span[0], next.span[1]);
        descend_in_box(search, &box, &next);
        if (next.distance < candidate->distance) {
            *candidate = next;
            return true;
        }
    }
    return false;
}

/* The point on the edge of a pole that looks at the target: of samples all along it, the one with
 * the steepest way down, -o . t with the unit tangent t into the surface, and one step down. */
static bool best_way_out(const struct search *search, int k, int end, struct candidate *candidate) {
    const struct surface_axis *axis = &search->surface->axis[k];
    const struct surface_axis *edge = &search->surface->axis[1 - k];
    double inward = end ? -1 : 1, steepest = 0;
    struct candidate next = *candidate;
    for (int i = 0; i < SAMPLES * edge->span_count; i++) {
        struct surface_jet jet;
        next.span[1 - k] = i / SAMPLES;
        next.uv[1 - k] = parameter(edge, i / SAMPLES, (0.5 + i % SAMPLES) / SAMPLES);
        next.uv[k] = axis->breaks[end ? axis->span_count : 0];
        struct box box = span_box(search->surface, next.span[0], next.span[1]);
        distance_at(search, &box, next.uv, &jet);
        struct vec3 tangent = vec3_scale(inward, k == 0 ? jet.u : jet.v);
        double length = vec3_norm(tangent);
        double down = -vec3_dot(vec3_sub(jet.r, search->target), tangent) / length;
        if (!(down > steepest))
            continue;
        steepest = down;
        next.uv[k] += inward * down / length;
        next.uv[k] = fmin(fmax(next.uv[k], box.lower[k]), box.upper[k]);
        *candidate = next;
    }
    return steepest > 0;
}

/* All along the edge of a pole is one point, from which a descent may lead elsewhere than to where
 * it was reached. */
static bool leave_pole(const struct search *search, struct candidate *candidate) {
    const struct surface *surface = search->surface;
    for (int k = 0; k < 2; k++) {
        const struct surface_axis *axis = &surface->axis[k];
        double near = pole_vicinity / axis->rates[candidate->span[k]];
        bool low = axis->pole[0] && candidate->uv[k] <= surface_axis_lower(axis) + near;
        bool high = axis->pole[1] && candidate->uv[k] >= surface_axis_upper(axis) - near;
        struct candidate next = *candidate;
        if ((!low && !high) || !best_way_out(search, k, high, &next))
            continue;
        struct box box = span_box(surface, next.span[0], next.span[1]);
        descend_in_box(search, &box, &next);
        if (next.distance < candidate->distance - pole_gain * surface->size) {
            *candidate = next;
            return true;
        }
    }
    return false;
}

/* The local minimum that `candidate` leads to, across spans; kept when it is the best. */
static void improve_best(struct search *search, struct candidate candidate) {
    struct box box = span_box(search->surface, candidate.span[0], candidate.span[1]);
    int crossings = 0;
    descend_in_box(search, &box, &candidate);
    while (crossings < CROSSINGS_MAX &&
           (cross_border(search, &candidate) || leave_pole(search, &candidate)))
        crossings++;
    if (candidate.distance < search->best.distance)
        search->best = candidate;
}

/* ---- branch and bound ---- */

/* Points where f is less than this are nearer than the best, by more than tolerance and rounding:
 * N comes from differences P - q w, each right to rounding of the coordinates. */
static double threshold(const struct search *search) {
    const struct surface *surface = search->surface;
    double d = search->best.distance, reach = d + surface->size;
    return d * d - tolerance * surface->size * d -
           16 * DBL_EPSILON * reach * (reach + surface->magnitude);
}

static int judge_distance(void *context, const struct bounds_cell *cell) {
    struct search *search = context;
    int corner;
    if (bounds_least_corner(cell, &corner) < threshold(search)) {
        struct candidate candidate = {.span = {search->span[0], search->span[1]}};
        for (int k = 0; k < 2; k++)
            candidate.uv[k] = parameter(&search->surface->axis[k], search->span[k],
                                        corner & (1 << k) ? cell->upper[k] : cell->lower[k]);
        improve_best(search, candidate);
    }
    if (!(bounds_least(cell) < threshold(search)))
        return BOUNDS_SETTLED;
    double level = search->best.distance * search->best.distance;
    if (!bounds_convex(cell, level))
        return bounds_bend(cell, level);
    /* the minimum of the cell can be had by Newton's method, and then may be no longer of interest
     */
    struct candidate candidate = {.span = {search->span[0], search->span[1]}};
    struct box box = {.span = {search->span[0], search->span[1]}};
    for (int k = 0; k < 2; k++) {
        const struct surface_axis *axis = &search->surface->axis[k];
        box.lower[k] = parameter(axis, search->span[k], cell->lower[k]);
        box.upper[k] = parameter(axis, search->span[k], cell->upper[k]);
        candidate.uv[k] = parameter(axis, search->span[k], (cell->lower[k] + cell->upper[k]) / 2);
    }
    bool found = descend_in_box(search, &box, &candidate);
    if (candidate.distance < search->best.distance)
        improve_best(search, candidate);
    bool settled = found && bounds_convex(cell, candidate.distance * candidate.distance);
    return settled ? BOUNDS_SETTLED : bounds_bend(cell, level);
}

/* Whether the plane across the way from q to the middle of the span, at the best distance, has
 * all its control points P / w beyond it: n . (P - q w) >= D w. */
static bool beyond_plane(const struct search *search, const vec4 *points) {
    size_t size = search->surface->points_per_span;
    vec4 middle = points[size / 2];
    struct vec3 q = search->target;
    struct vec3 n = vec3_unit(
        vec3_sub(vec3_scale(1 / middle[3], vec3_make(middle[0], middle[1], middle[2])), q));
    double level = vec3_dot(n, q) + search->best.distance - tolerance * search->surface->size;
    for (size_t i = 0; i < size; i++) {
        vec4 p = points[i];
        if (!(n.x * p[0] + n.y * p[1] + n.z * p[2] >= level * p[3]))
            return false;
    }
    return true;
}

/* ratio[i][j] = C(p, i) C(p, j) / C(2 p, i + j): what B_i^p B_j^p is of B_(i+j)^2p. */
static void product_ratios(int p, double ratio[NURBS_DEGREE_MAX + 1][NURBS_DEGREE_MAX + 1]) {
    double binomial[NURBS_DEGREE_MAX + 1] = {1}, twice[BOUNDS_ORDER_MAX] = {1};
    for (int k = 0; k < p; k++)
        binomial[k + 1] = binomial[k] * (p - k) / (k + 1);
    for (int k = 0; k < 2 * p; k++)
        twice[k + 1] = twice[k] * (2 * p - k) / (k + 1);
    for (int i = 0; i <= p; i++)
        for (int j = 0; j <= p; j++)
            ratio[i][j] = binomial[i] * binomial[j] / twice[i + j];
}

/* The coefficients of N and W: those of the span with itself, each pair of rows once. */
static void load_square(struct search *search, const vec4 *points) {
    int p = search->surface->axis[0].degree, q = search->surface->axis[1].degree;
    double ru[NURBS_DEGREE_MAX + 1][NURBS_DEGREE_MAX + 1];
    double rv[NURBS_DEGREE_MAX + 1][NURBS_DEGREE_MAX + 1];
    vec4 moved[(NURBS_DEGREE_MAX + 1) * (NURBS_DEGREE_MAX + 1)];
    bounds_pair *pairs = search->bounds->store;
    product_ratios(p, ru);
    product_ratios(q, rv);
    for (int i = 0; i < (p + 1) * (q + 1); i++) {
        vec4 target = {search->target.x, search->target.y, search->target.z, 0};
        moved[i] = points[i] - points[i][3] * target;
    }
    for (int i = 0; i < (2 * p + 1) * (2 * q + 1); i++)
        pairs[i] = (bounds_pair){0, 0};
    for (int i = 0; i <= p; i++)
        for (int j = i; j <= p; j++)
            for (int k = 0; k <= q; k++)
                for (int l = 0; l <= q; l++) {
                    vec4 x = moved[i * (q + 1) + k] * moved[j * (q + 1) + l];
                    double share = (j > i ? 2 : 1) * ru[i][j] * rv[k][l];
                    pairs[(i + j) * (2 * q + 1) + k + l] +=
                        share * (bounds_pair){x[0] + x[1] + x[2], x[3]};
                }
}

/* ---- the search ---- */

/* A first candidate: on the span with the nearest corner, the nearest of some samples inside, away
 * from poles, where directions are lost. */
static struct candidate first_candidate(const struct search *search) {
    const struct surface *surface = search->surface;
    struct candidate nearest = {.distance = DBL_MAX}, best = nearest;
    size_t last = surface->points_per_span - 1;
    for (int su = 0; su < surface->axis[0].span_count; su++)
        for (int sv = 0; sv < surface->axis[1].span_count; sv++)
            for (size_t end = 0; end < 2; end++) {
                vec4 p = span_points(surface, su, sv)[end * last];
                struct vec3 r = vec3_scale(1 / p[3], vec3_make(p[0], p[1], p[2]));
                double distance2 = vec3_norm2(vec3_sub(r, search->target));
                if (distance2 < nearest.distance)
                    nearest = (struct candidate){.span = {su, sv}, .distance = distance2};
            }
    struct box box = span_box(surface, nearest.span[0], nearest.span[1]);
    for (int i = 0; i < SAMPLES * SAMPLES; i++) {
        struct surface_jet jet;
        struct candidate candidate = nearest;
        candidate.uv[0] =
            parameter(&surface->axis[0], candidate.span[0], (0.5 + i / SAMPLES) / SAMPLES);
        candidate.uv[1] =
            parameter(&surface->axis[1], candidate.span[1], (0.5 + i % SAMPLES) / SAMPLES);
        candidate.distance = distance_at(search, &box, candidate.uv, &jet);
        if (i == 0 || candidate.distance < best.distance)
            best = candidate;
    }
    return best;
}

void surface_nearest(const struct surface *surface, struct vec3 point, double uv[2],
                     double *distance) {
    surface_nearest_at(surface, point, uv, distance);
    surface_outer(surface, uv, uv);
}

double surface_nearest_from(const struct surface *surface, struct vec3 point, double uv[2]) {
    struct search search = {.surface = surface, .target = point};
    struct candidate from;
    for (int k = 0; k < 2; k++) {
        const struct surface_axis *axis = &surface->axis[k];
        double at = surface_axis_wrap(axis, uv[k]);
        from.uv[k] = fmin(fmax(at, surface_axis_lower(axis)), surface_axis_upper(axis));
        from.span[k] = surface_axis_span(axis, 0, from.uv[k]);
    }
    search.best = from;
    search.best.distance = DBL_MAX;
    improve_best(&search, from);
    uv[0] = search.best.uv[0];
    uv[1] = search.best.uv[1];
    return search.best.distance;
}

/* The distance to a moved surface is least where that to the surface itself is, or on an edge: the
 * foot of the normal through the point is the same. */
void surface_nearest_at(const struct surface *surface, struct vec3 point, double uv[2],
                        double *distance) {
    if (surface->height != 0) {
        struct surface base = *surface;
        base.height = 0;
        surface_nearest_at(&base, point, uv, distance);
        *distance = surface_nearest_from(surface, point, uv);
        return;
    }
    struct bounds_search bounds;
    struct search search = {.surface = surface, .target = point, .bounds = &bounds};
    bounds.degree[0] = 2 * surface->axis[0].degree;
    bounds.degree[1] = 2 * surface->axis[1].degree;
    bounds.judge = judge_distance;
    bounds.context = &search;
    search.best = first_candidate(&search);
    improve_best(&search, search.best);
    for (int su = 0; su < surface->axis[0].span_count; su++)
        for (int sv = 0; sv < surface->axis[1].span_count; sv++) {
            const vec4 *points = span_points(surface, su, sv);
            if (search.best.distance <= tolerance * surface->size || beyond_plane(&search, points))
                continue;
            search.span[0] = su;
            search.span[1] = sv;
            load_square(&search, points);
            bounds_run(&bounds);
        }
    uv[0] = search.best.uv[0];
    uv[1] = search.best.uv[1];
    *distance = search.best.distance;
}
