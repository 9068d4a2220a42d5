/* SPDX-License-Identifier: MIT */
#include "relaxation.h"

#include <string.h>

enum { STATE = 4, ROUNDS_MAX = 40, HALVINGS_MAX = 12, COARSE = 5, FINE = 9 };

/* Newton ends with a correction whose norm per point is less; what it leaves is smaller by the
 * factor of `difference` and more. */
static const double tolerance = 1e-10;

/* The weight of p and q against u and v in the norm (54): the paper's 1 / 10. */
static const double velocity_weight = 0.1;

/* The step of the differences, as a share of the span: the square root of the rounding, for it is
 * a first derivative of second derivatives that are polynomials over the span. */
static const double difference = 1e-7;

/* With a pole nearer than this many distances, the line is too crooked in (u, v) for nine points.
 */
static const double pole_distance = 4;

/* The speed along a geodesic is constant. A mesh on which it is not, to this share, does not
 * resolve the path, or the path runs over a crease where p and q ought to jump. */
static const double uneven_speed = 0.02;

/* Longer than this many chords, it is not the shortest line between neighbours on a net (that of
 * half a turn of a circle is pi / 2). */
static const double detour = 2;

/* What does not change while Newton runs. */
struct problem {
    const struct surface *surface;
    struct surface_cursor *cursor;
    const double *from; /* (u, v) of A */
    double to[2];       /* (u, v) of B, less those of A */
    double scale[2];    /* |r_u|, |r_v| at A over the chord: one unit of the norm
                           is one chord in space */
    double y[RELAXATION_POINTS_MAX][STATE]; /* where the corrections are computed next */
};

/* g = (p, q, w) at a point of the mesh, and the lower half of its Jacobian; the upper is (0, 1). */
struct slope {
    double w[2];
    double by_uv[2][2], by_pq[2][2]; /* [row][column] */
};

/* p^2 r_uu + 2 p q r_uv + q^2 r_vv: the acceleration if p and q were constant. */
static struct vec3 acceleration(const struct surface_jet *jet, double p, double q) {
    struct vec3 a = vec3_scale(p * p, jet->uu);
    a = vec3_axpy(2 * p * q, jet->uv, a);
    return vec3_axpy(q * q, jet->vv, a);
}

/* The inverse of the first fundamental form. */
struct form {
    double e, f, g, inverse;
};

static struct form form_make(const struct surface_jet *jet) {
    struct form form = {vec3_norm2(jet->u), vec3_dot(jet->u, jet->v), vec3_norm2(jet->v), 0};
    form.inverse = 1 / (form.e * form.g - form.f * form.f);
    return form;
}

/* -I^-1 (x, y), as column `c` of `out`. */
static void form_solve(const struct form *form, double x, double y, int c, double out[2][2]) {
    out[0][c] = -(form->g * x - form->f * y) * form->inverse;
    out[1][c] = -(form->e * y - form->f * x) * form->inverse;
}

/* The jet at the k-th point, and those a little further in u and in v, all by the polynomials of
 * the one span: across a knot a difference would be that of the jump, not a derivative. */
static void jets_at(const struct problem *problem, int k, struct surface_jet jet[3],
                    double step[2]) {
    const struct surface *surface = problem->surface;
    int *span[2] = {&problem->cursor->span_u, &problem->cursor->span_v};
    double x[2];
    for (int n = 0; n < 2; n++) {
        const struct surface_axis *axis = &surface->axis[n];
        x[n] = surface_axis_wrap(axis, problem->from[n] + problem->y[k][n]);
        *span[n] = surface_axis_span(axis, *span[n], x[n]);
        step[n] = difference / axis->rates[*span[n]];
    }
    for (int n = 0; n < 3; n++)
        surface_evaluate_span(surface, *span[0], *span[1], x[0] + (n == 1 ? step[0] : 0),
                              x[1] + (n == 2 ? step[1] : 0), &jet[n]);
}

/* w and its derivatives. That c = a + r_u w1 + r_v w2 is normal to the surface, c . r_u = 0 and
 * c . r_v = 0, defines w; differentiated by u, with i = I (w_u) for the unknown,
 *
 *     i_1 = -(a_u + r_uu w1 + r_uv w2) . r_u - c . r_uu,
 *     i_2 = -(a_u + r_uu w1 + r_uv w2) . r_v - c . r_uv,
 *
 * and alike by v. All of it is in the second-order jet but a_u and a_v, the third derivatives,
 * which are differences of a. By p, it is I (w_p) = -a_p with a_p = 2 (p r_uu + q r_uv). */
static void slope_at(const struct problem *problem, int k, struct slope *slope) {
    double p = problem->y[k][2], q = problem->y[k][3], step[2], w[2][2];
    struct surface_jet jet[3];
    jets_at(problem, k, jet, step);
    const struct surface_jet *at = &jet[0];
    struct form form = form_make(at);
    struct vec3 a = acceleration(at, p, q);
    form_solve(&form, vec3_dot(a, at->u), vec3_dot(a, at->v), 0, w);
    slope->w[0] = w[0][0];
    slope->w[1] = w[1][0];
    struct vec3 c = vec3_axpy(slope->w[1], at->v, vec3_axpy(slope->w[0], at->u, a));
    for (int n = 0; n < 2; n++) {
        struct vec3 to_u = n ? at->uv : at->uu, to_v = n ? at->vv : at->uv;
        struct vec3 ahead = acceleration(&jet[1 + n], p, q);
        struct vec3 change = vec3_scale(1 / step[n], vec3_sub(ahead, a));
        change = vec3_axpy(slope->w[1], to_v, vec3_axpy(slope->w[0], to_u, change));
        form_solve(&form, vec3_dot(change, at->u) + vec3_dot(c, to_u),
                   vec3_dot(change, at->v) + vec3_dot(c, to_v), n, slope->by_uv);
        struct vec3 by = vec3_scale(2, vec3_axpy(q, to_v, vec3_scale(p, to_u)));
        form_solve(&form, vec3_dot(by, at->u), vec3_dot(by, at->v), n, slope->by_pq);
    }
}

/* A correction of one point as a function of what is not known at A: of (dp, dq) there. Column 0 is
 * the constant part, 1 and 2 are the factors of dp and of dq. x is the part of (u, v), v that of
 * (p, q). */
struct affine {
    double x[3][2], v[3][2];
};

/* y_k = y_(k-1) + h/2 (..) is short of by this: -F_k, equation 42 with its signs put right. */
static void defect(const struct problem *problem, int k, double half, const struct slope *slope,
                   double minus_f[STATE]) {
    const double *y = problem->y[k], *before = problem->y[k - 1];
    for (int n = 0; n < 2; n++) {
        minus_f[n] = before[n] - y[n] + half * (before[2 + n] + y[2 + n]);
        minus_f[2 + n] = before[2 + n] - y[2 + n] + half * (slope[k - 1].w[n] + slope[k].w[n]);
    }
}

/* Row k of the system, A_k dY_(k-1) + B_k dY_k = -F_k with A_k = -(1 + h/2 J_(k-1)) and
 * B_k = 1 - h/2 J_k, solved for dY_k. As the upper half of J is (0, 1), the 4 x 4 block B_k comes
 * down to the 2 x 2 matrix S = 1 - h/2 J_pq - h^2/4 J_uv. */
static void eliminate(const struct slope *before, const struct slope *at, double half,
                      const double minus_f[STATE], const struct affine *from, struct affine *to) {
    double s[2][2];
    for (int r = 0; r < 2; r++)
        for (int c = 0; c < 2; c++)
            s[r][c] = (r == c) - half * (at->by_pq[r][c] + half * at->by_uv[r][c]);
    double inverse = 1 / (s[0][0] * s[1][1] - s[0][1] * s[1][0]);
    for (int c = 0; c < 3; c++) {
        const double *x = from->x[c], *v = from->v[c];
        double rx[2], rv[2];
        for (int n = 0; n < 2; n++) {
            rx[n] = x[n] + half * v[n] + (c == 0 ? minus_f[n] : 0);
            rv[n] = v[n] + (c == 0 ? minus_f[2 + n] : 0) +
                    half * (before->by_uv[n][0] * x[0] + before->by_uv[n][1] * x[1] +
                            before->by_pq[n][0] * v[0] + before->by_pq[n][1] * v[1]);
        }
        for (int n = 0; n < 2; n++)
            rv[n] += half * (at->by_uv[n][0] * rx[0] + at->by_uv[n][1] * rx[1]);
        to->v[c][0] = (s[1][1] * rv[0] - s[0][1] * rv[1]) * inverse;
        to->v[c][1] = (s[0][0] * rv[1] - s[1][0] * rv[0]) * inverse;
        for (int n = 0; n < 2; n++)
            to->x[c][n] = rx[n] + half * to->v[c][n];
    }
}

/* Newton's correction dY at problem->y (equations 47 to 51) and its norm (54), per point. The block
 * system is eliminated from A to B, which carries errors on by no more than geodesics part from
 * each other on the way, little over one spacing; then the two equations at B give what was not
 * known at A. The norm is not a number when the surface is singular on the way. */
static double correction(const struct problem *problem, int points, double dy[][STATE]) {
    struct slope slope[RELAXATION_POINTS_MAX];
    struct affine affine[RELAXATION_POINTS_MAX];
    double half = 0.5 / (points - 1), minus_f[STATE], known[3] = {1, 0, 0}, sum = 0;
    affine[0] = (struct affine){.v = {{0, 0}, {1, 0}, {0, 1}}};
    slope_at(problem, 0, &slope[0]);
    for (int k = 1; k < points; k++) {
        slope_at(problem, k, &slope[k]);
        defect(problem, k, half, slope, minus_f);
        eliminate(&slope[k - 1], &slope[k], half, minus_f, &affine[k - 1], &affine[k]);
    }
    const struct affine *last = &affine[points - 1];
    const double *p = last->x[1], *q = last->x[2];
    double inverse = 1 / (p[0] * q[1] - p[1] * q[0]);
    double x = problem->to[0] - problem->y[points - 1][0] - last->x[0][0];
    double y = problem->to[1] - problem->y[points - 1][1] - last->x[0][1];
    known[1] = (q[1] * x - q[0] * y) * inverse;
    known[2] = (p[0] * y - p[1] * x) * inverse;
    for (int k = 0; k < points; k++)
        for (int n = 0; n < 2; n++) {
            dy[k][n] = dy[k][2 + n] = 0;
            for (int c = 0; c < 3; c++) {
                dy[k][n] += known[c] * affine[k].x[c][n];
                dy[k][2 + n] += known[c] * affine[k].v[c][n];
            }
            sum += problem->scale[n] * (fabs(dy[k][n]) + velocity_weight * fabs(dy[k][2 + n]));
        }
    return sum / points;
}

/* problem->y = path->y + mu dy */
static void shift(struct problem *problem, const struct relaxation *path, double mu,
                  double dy[][STATE]) {
    for (int k = 0; k < path->points; k++)
        for (int n = 0; n < STATE; n++)
            problem->y[k][n] = path->y[k][n] + mu * dy[k][n];
}

/* Newton from path->y. A step is halved until the correction that would follow it is the smaller
 * (equations 52 and 53); that correction is the next one, so an undamped step costs nothing more.
 */
static bool newton(struct problem *problem, struct relaxation *path) {
    double dy[RELAXATION_POINTS_MAX][STATE], next[RELAXATION_POINTS_MAX][STATE];
    size_t size = (size_t)path->points * sizeof dy[0];
    memcpy(problem->y, path->y, size);
    double norm = correction(problem, path->points, dy);
    path->iterations++;
    for (int round = 0; round < ROUNDS_MAX && isfinite(norm); round++) {
        double mu = 1, after = HUGE_VAL;
        for (int halving = 0; halving <= HALVINGS_MAX; halving++, mu /= 2) {
            shift(problem, path, mu, dy);
            if (norm <= tolerance)
                break;
            after = correction(problem, path->points, next);
            path->iterations++;
            if (after < norm)
                break;
            path->halvings++;
        }
        if (norm > tolerance && !(after < norm))
            return false;
        memcpy(path->y, problem->y, size);
        if (norm <= tolerance)
            return true;
        memcpy(dy, next, size);
        norm = after;
    }
    return false;
}

/* False when the two stations have no chord to scale by. */
static bool problem_make(const struct surface *surface, struct surface_cursor *cursor,
                         const struct station *a, const struct station *b,
                         struct problem *problem) {
    double chord = vec3_distance(a->jet.r, b->jet.r);
    problem->surface = surface;
    problem->cursor = cursor;
    problem->from = a->uv;
    for (int n = 0; n < 2; n++) {
        problem->to[n] = b->uv[n] - a->uv[n];
        problem->scale[n] = sqrt(a->first[2 * n]) / chord;
    }
    return isfinite(problem->scale[0] + problem->scale[1]);
}

/* The straight line in (u, v). */
static void start_straight(const struct problem *problem, int points, struct relaxation *path) {
    *path = (struct relaxation){.points = points};
    for (int k = 0; k < points; k++)
        for (int n = 0; n < 2; n++) {
            path->y[k][n] = problem->to[n] * k / (points - 1);
            path->y[k][2 + n] = problem->to[n];
        }
}

/* Twice as fine a mesh: between two points the cubic through their values and derivatives. */
static void start_refined(const struct relaxation *coarse, struct relaxation *path) {
    double h = 1.0 / (coarse->points - 1);
    *path = (struct relaxation){.points = 2 * coarse->points - 1};
    for (int k = 0; k < coarse->points; k++)
        memcpy(path->y[2 * k], coarse->y[k], sizeof path->y[0]);
    for (int k = 1; k < coarse->points; k++)
        for (int n = 0; n < 2; n++) {
            const double *l = coarse->y[k - 1], *r = coarse->y[k];
            path->y[2 * k - 1][n] = (l[n] + r[n]) / 2 + h / 8 * (l[2 + n] - r[2 + n]);
            path->y[2 * k - 1][2 + n] = 1.5 / h * (r[n] - l[n]) - (l[2 + n] + r[2 + n]) / 4;
        }
}

bool relaxation_solve(const struct surface *surface, struct surface_cursor *cursor,
                      const struct station *a, const struct station *b, int points,
                      struct relaxation *path) {
    struct problem problem;
    if (!problem_make(surface, cursor, a, b, &problem))
        return false;
    start_straight(&problem, points, path);
    return newton(&problem, path);
}

/* The velocity in space at a point of the path. */
static struct vec3 velocity(const struct surface_jet *jet, double p, double q) {
    return vec3_axpy(q, jet->v, vec3_scale(p, jet->u));
}

/* Whether the speed is the same all along. */
static bool resolved(const struct problem *problem, const struct relaxation *path) {
    double least = HUGE_VAL, most = 0;
    for (int k = 0; k < path->points; k++) {
        const double *y = path->y[k];
        struct surface_jet jet;
        surface_evaluate(problem->surface, problem->cursor, problem->from[0] + y[0],
                         problem->from[1] + y[1], &jet);
        double speed = vec3_norm(velocity(&jet, y[2], y[3]));
        least = fmin(least, speed);
        most = fmax(most, speed);
    }
    return most <= (1 + uneven_speed) * least;
}

bool relaxation_tangents(const struct surface *surface, struct surface_cursor *cursor,
                         const struct station *a, const struct station *b,
                         struct vec3 *tangent_at_a, double *length, int *iterations) {
    struct problem problem;
    struct relaxation coarse, fine;
    struct vec3 pole;
    double chord = vec3_distance(a->jet.r, b->jet.r);
    if (station_pole_distance(surface, a->jet.r, &pole) < pole_distance * chord ||
        !problem_make(surface, cursor, a, b, &problem))
        return false;
    start_straight(&problem, COARSE, &coarse);
    if (!newton(&problem, &coarse))
        return false;
    start_refined(&coarse, &fine);
    if (!newton(&problem, &fine) || !resolved(&problem, &fine))
        return false;
    double p = (4 * fine.y[0][2] - coarse.y[0][2]) / 3, q = (4 * fine.y[0][3] - coarse.y[0][3]) / 3;
    struct vec3 along = velocity(&a->jet, p, q);
    if (!(vec3_norm(along) <= detour * chord))
        return false;
    *length = vec3_norm(along);
    *tangent_at_a = vec3_unit(along);
    if (iterations)
        *iterations = coarse.iterations + fine.iterations;
    return true;
}
