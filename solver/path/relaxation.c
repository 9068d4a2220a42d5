/* SPDX-License-Identifier: MIT */
#include "relaxation.h"

#include <string.h>

enum { STATE = 4, ROUNDS_MAX = 40, HALVINGS_MAX = 12, COARSE = 5, FINE = 9 };

/* Knots met on the way that the mesh is fitted to, as many as the coarsest can take; and how often
 * it is fitted anew, each time with the square of the miss before. */
enum { MEETINGS_MAX = 3, FITTINGS_MAX = 6 };

/* Newton ends with a correction whose norm per point is less; what it leaves is smaller by the
 * factor of `difference` and more. */
static const double tolerance = 1e-10;

/* A knot is met at a point of the mesh when the path is there so near, as a share of it. */
static const double meeting_tolerance = 1e-8;

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

/* Where the path meets a knot. */
struct meeting {
    int direction, point; /* of the mesh */
    double at;            /* the knot, as a distance in u or v from A */
    double s;
};

/* A step of the mesh lies in one span, and takes the polynomials of that span at both its ends. */
struct step {
    int span[2];
    double turn[2]; /* what to take off (u, v) to be in the domain of the span */
};

/* What does not change while Newton runs, but for y. */
struct problem {
    const struct surface *surface;
    const double *from; /* (u, v) of A */
    double to[2];       /* (u, v) of B, less those of A */
    double scale[2];    /* |r_u|, |r_v| at A over the chord: one unit of the norm is one chord */
    double s[RELAXATION_POINTS_MAX];
    struct step step[RELAXATION_POINTS_MAX]; /* k: from point k - 1 to k */
    struct meeting meeting[MEETINGS_MAX];    /* by s */
    int meetings;
    double y[RELAXATION_POINTS_MAX][STATE]; /* where the corrections are computed next */
};

/* g = (p, q, w) at a point of the mesh, and the lower half of its Jacobian; the upper is (0, 1). */
struct slope {
    double w[2];
    double by_uv[2][2], by_pq[2][2]; /* [row][column] */
};

/* -I^-1 (x, y), as column `c` of `out`. */
static void solve_column(const struct tangent_basis *basis, double x, double y, int c,
                         double out[2][2]) {
    double ab[2];
    tangent_solve(basis, x, y, ab);
    out[0][c] = -ab[0];
    out[1][c] = -ab[1];
}

/* w and its derivatives. That c = a + r_u w1 + r_v w2 is normal to the surface, c . r_u = 0 and
 * c . r_v = 0, defines w; differentiated by u, with i = I (w_u) for the unknown,
 *
 *     i_1 = -(a_u + r_uu w1 + r_uv w2) . r_u - c . r_uu,
 *     i_2 = -(a_u + r_uu w1 + r_uv w2) . r_v - c . r_uv,
 *
 * and alike by v. All of it is in the second-order jet but a_u and a_v, the third derivatives,
 * which are differences of a, by the polynomials of the one span: across a knot a difference would
 * be that of the jump, not a derivative. By p, it is I (w_p) = -a_p with a_p = 2 (p r_uu + q r_uv).
 */
static void find_slope(const struct problem *problem, int k, const struct step *step,
                       struct slope *slope) {
    double x[2], width[2], w[2][2];
    const double *pq = &problem->y[k][2];
    struct surface_jet jet[3];
    const struct surface_jet *at = &jet[0];
    for (int n = 0; n < 2; n++) {
        x[n] = problem->from[n] + problem->y[k][n] - step->turn[n];
        width[n] = difference / problem->surface->axis[n].rates[step->span[n]];
    }
    for (int n = 0; n < 3; n++)
        surface_evaluate_span(problem->surface, step->span[0], step->span[1],
                              x[0] + (n == 1 ? width[0] : 0), x[1] + (n == 2 ? width[1] : 0),
                              &jet[n]);
    struct tangent_basis basis = tangent_basis_of(at->u, at->v);
    struct vec3 a = jet_bend(at, pq);
    solve_column(&basis, vec3_dot(a, at->u), vec3_dot(a, at->v), 0, w);
    slope->w[0] = w[0][0];
    slope->w[1] = w[1][0];
    struct vec3 c = vec3_axpy(slope->w[1], at->v, vec3_axpy(slope->w[0], at->u, a));
    for (int n = 0; n < 2; n++) {
        struct vec3 to_u = n ? at->uv : at->uu, to_v = n ? at->vv : at->uv;
        struct vec3 change = vec3_scale(1 / width[n], vec3_sub(jet_bend(&jet[1 + n], pq), a));
        change = vec3_axpy(slope->w[1], to_v, vec3_axpy(slope->w[0], to_u, change));
        solve_column(&basis, vec3_dot(change, at->u) + vec3_dot(c, to_u),
                     vec3_dot(change, at->v) + vec3_dot(c, to_v), n, slope->by_uv);
        struct vec3 by = vec3_scale(2, vec3_axpy(pq[1], to_v, vec3_scale(pq[0], to_u)));
        solve_column(&basis, vec3_dot(by, at->u), vec3_dot(by, at->v), n, slope->by_pq);
    }
}

/* A correction of one point as a function of what is not known at A: of (dp, dq) there. Column 0 is
 * the constant part, 1 and 2 are the factors of dp and of dq. x is the part of (u, v), v that of
 * (p, q). */
struct affine {
    double x[3][2], v[3][2];
};

/* The system from A to B, which carries errors on by no more than geodesics part from each other on
 * the way: little over one spacing. Row k of it is A_k dY_(k-1) + B_k dY_k = -F_k with
 * A_k = -(1 + h/2 J_(k-1)), B_k = 1 - h/2 J_k and the -F_k of equation 42 with its signs put right,
 * solved for dY_k. As the upper half of J is (0, 1), the 4 x 4 block B_k comes down to the 2 x 2
 * matrix S = 1 - h/2 J_pq - h^2/4 J_uv. */
static void eliminate_all(const struct problem *problem, int points, struct affine *affine) {
    struct slope before, at;
    affine[0] = (struct affine){.v = {{0, 0}, {1, 0}, {0, 1}}};
    for (int k = 1; k < points; k++) {
        const struct step *step = &problem->step[k];
        const double *last = problem->y[k - 1], *y = problem->y[k];
        double half = (problem->s[k] - problem->s[k - 1]) / 2, minus_f[STATE], s[2][2];
        if (k == 1 || memcmp(step, step - 1, sizeof *step) != 0)
            find_slope(problem, k - 1, step, &before);
        else
            before = at;
        find_slope(problem, k, step, &at);
        for (int n = 0; n < 2; n++) {
            minus_f[n] = last[n] - y[n] + half * (last[2 + n] + y[2 + n]);
            minus_f[2 + n] = last[2 + n] - y[2 + n] + half * (before.w[n] + at.w[n]);
            for (int c = 0; c < 2; c++)
                s[n][c] = (n == c) - half * (at.by_pq[n][c] + half * at.by_uv[n][c]);
        }
        double inverse = 1 / (s[0][0] * s[1][1] - s[0][1] * s[1][0]);
        for (int c = 0; c < 3; c++) {
            const double *x = affine[k - 1].x[c], *v = affine[k - 1].v[c];
            double rx[2], rv[2], *to = affine[k].v[c];
            for (int n = 0; n < 2; n++) {
                rx[n] = x[n] + half * v[n] + (c == 0 ? minus_f[n] : 0);
                rv[n] = v[n] + (c == 0 ? minus_f[2 + n] : 0) +
                        half * (before.by_uv[n][0] * x[0] + before.by_uv[n][1] * x[1] +
                                before.by_pq[n][0] * v[0] + before.by_pq[n][1] * v[1]);
            }
            for (int n = 0; n < 2; n++)
                rv[n] += half * (at.by_uv[n][0] * rx[0] + at.by_uv[n][1] * rx[1]);
            to[0] = (s[1][1] * rv[0] - s[0][1] * rv[1]) * inverse;
            to[1] = (s[0][0] * rv[1] - s[1][0] * rv[0]) * inverse;
            for (int n = 0; n < 2; n++)
                affine[k].x[c][n] = rx[n] + half * to[n];
        }
    }
}

/* Newton's correction dY at problem->y (equations 47 to 51) and its norm (54), per point: the two
 * equations at B give what was not known at A. The norm is not a number when the surface is
 * singular on the way. */
static double find_correction(const struct problem *problem, int points, double dy[][STATE]) {
    struct affine affine[RELAXATION_POINTS_MAX];
    double known[3] = {1, 0, 0}, sum = 0;
    eliminate_all(problem, points, affine);
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

/* Newton from path->y. A step is halved until the correction that would follow it is the smaller
 * (equations 52 and 53); that correction is the next one, so an undamped step costs nothing more.
 */
static bool relax_on_mesh(struct problem *problem, struct relaxation *path) {
    double dy[RELAXATION_POINTS_MAX][STATE], next[RELAXATION_POINTS_MAX][STATE];
    size_t size = (size_t)path->points * sizeof dy[0];
    memcpy(problem->y, path->y, size);
    double norm = find_correction(problem, path->points, dy);
    path->iterations++;
    for (int round = 0; round < ROUNDS_MAX && isfinite(norm); round++) {
        double mu = 1, after = HUGE_VAL;
        for (int halving = 0; halving <= HALVINGS_MAX; halving++, mu /= 2) {
            for (int k = 0; k < path->points; k++)
                for (int n = 0; n < STATE; n++)
                    problem->y[k][n] = path->y[k][n] + mu * dy[k][n];
            if (norm <= tolerance)
                break;
            after = find_correction(problem, path->points, next);
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

/* Sorts in the knots of direction n between A and B, where the straight line meets them; more than
 * fit are counted alone. */
static void find_knots(struct problem *problem, int n) {
    double from = problem->from[n];
    struct surface_walk walk =
        surface_walk_begin(&problem->surface->axis[n], from, from + problem->to[n]);
    walk.way = problem->to[n];
    while (surface_walk_next(&walk) && walk.share < 1 - meeting_tolerance) {
        if (!(walk.share > meeting_tolerance))
            continue;
        int k = problem->meetings++;
        if (k >= MEETINGS_MAX)
            return;
        for (; k > 0 && problem->meeting[k - 1].s > walk.share; k--)
            problem->meeting[k] = problem->meeting[k - 1];
        problem->meeting[k] = (struct meeting){n, 0, walk.at - from, walk.share};
    }
}

/* A mesh with a point at each meeting, and the others even between them. */
static void place_points(struct problem *problem, int points) {
    double end[MEETINGS_MAX + 2] = {0};
    int steps[MEETINGS_MAX + 1], pieces = problem->meetings + 1, at = 0;
    for (int k = 0; k < pieces; k++) {
        end[k + 1] = k < problem->meetings ? problem->meeting[k].s : 1;
        steps[k] = 1;
    }
    for (int left = points - 1 - pieces; left > 0; left--) {
        int widest = 0;
        for (int k = 1; k < pieces; k++)
            if ((end[k + 1] - end[k]) * steps[widest] > (end[widest + 1] - end[widest]) * steps[k])
                widest = k;
        steps[widest]++;
    }
    for (int k = 0; k < pieces; k++) {
        for (int step = 0; step < steps[k]; step++)
            problem->s[at + step] = end[k] + (end[k + 1] - end[k]) * step / steps[k];
        at += steps[k];
        if (k < problem->meetings)
            problem->meeting[k].point = at;
    }
    problem->s[at] = 1;
}

/* The problem on a mesh for the straight line in (u, v), and that line. False when the two points
 * have no chord to scale by. */
static bool start_straight(const struct surface *surface, const struct surface_point *a,
                           const struct surface_point *b, int points, struct problem *problem,
                           struct relaxation *path) {
    double chord = vec3_distance(a->jet.r, b->jet.r);
    problem->surface = surface;
    problem->from = a->uv;
    problem->meetings = 0;
    for (int n = 0; n < 2; n++) {
        problem->to[n] = b->uv[n] - a->uv[n];
        problem->scale[n] = sqrt(a->first[2 * n]) / chord;
        find_knots(problem, n);
    }
    if (problem->meetings > MEETINGS_MAX || problem->meetings > points - 2)
        problem->meetings = 0;
    place_points(problem, points);
    *path = (struct relaxation){.points = points};
    for (int k = 0; k < points; k++)
        for (int n = 0; n < 2; n++) {
            path->y[k][n] = problem->to[n] * problem->s[k];
            path->y[k][2 + n] = problem->to[n];
        }
    return isfinite(problem->scale[0] + problem->scale[1]);
}

/* Halves every step: between two points the cubic through their values and derivatives. */
static void start_refined(struct problem *problem, const struct relaxation *coarse,
                          struct relaxation *path) {
    *path = (struct relaxation){.points = 2 * coarse->points - 1};
    for (int k = coarse->points - 1; k >= 0; k--) {
        problem->s[2 * k] = problem->s[k];
        memcpy(path->y[2 * k], coarse->y[k], sizeof path->y[0]);
    }
    for (int k = 0; k < problem->meetings; k++)
        problem->meeting[k].point *= 2;
    for (int k = 1; k < path->points; k += 2) {
        const double *l = path->y[k - 1], *r = path->y[k + 1];
        double h = problem->s[k + 1] - problem->s[k - 1];
        problem->s[k] = problem->s[k - 1] + h / 2;
        for (int n = 0; n < 2; n++) {
            path->y[k][n] = (l[n] + r[n]) / 2 + h / 8 * (l[2 + n] - r[2 + n]);
            path->y[k][2 + n] = 1.5 / h * (r[n] - l[n]) - (l[2 + n] + r[2 + n]) / 4;
        }
    }
}

/* Moves the points that stand for knots to where the path meets them, and those between along.
 * False when they would pass each other; `moved` is the farthest. */
static bool fit_mesh(struct problem *problem, const struct relaxation *path, double *moved) {
    double before = 0, after = 0;
    int first = 0;
    *moved = 0;
    for (int m = 0; m <= problem->meetings; m++) {
        struct meeting *meeting = &problem->meeting[m];
        int last = m < problem->meetings ? meeting->point : path->points - 1;
        double end = problem->s[last], to = 1;
        if (m < problem->meetings) {
            const double *y = path->y[last];
            to = end + (meeting->at - y[meeting->direction]) / y[2 + meeting->direction];
            *moved = fmax(*moved, fabs(to - end));
        }
        if (!(to > after))
            return false;
        for (int k = first + 1; k <= last; k++)
            problem->s[k] = after + (to - after) * ((problem->s[k] - before) / (end - before));
        before = end;
        after = to;
        first = last;
    }
    return after == 1;
}

/* Newton on a mesh that is fitted to the knots as the path comes to be known; each step lies in the
 * span of its middle. */
static bool relax(struct problem *problem, struct relaxation *path) {
    for (int round = 0; round < FITTINGS_MAX; round++) {
        double moved;
        for (int k = 1; k < path->points; k++) {
            struct step *step = &problem->step[k];
            *step = k > 1 ? step[-1] : (struct step){0};
            for (int n = 0; n < 2; n++) {
                const struct surface_axis *axis = &problem->surface->axis[n];
                double x = problem->from[n] + (path->y[k - 1][n] + path->y[k][n]) / 2;
                double wrapped = surface_axis_wrap(axis, x);
                step->turn[n] = x - wrapped;
                step->span[n] = surface_axis_span(axis, step->span[n], wrapped);
            }
        }
        if (!relax_on_mesh(problem, path))
            return false;
        if (problem->meetings == 0)
            return true;
        if (!fit_mesh(problem, path, &moved))
            return false;
        if (moved < meeting_tolerance)
            return true;
    }
    return false;
}

bool relaxation_solve(const struct surface *surface, const struct surface_point *a,
                      const struct surface_point *b, int points, struct relaxation *path) {
    struct problem problem;
    return start_straight(surface, a, b, points, &problem, path) && relax(&problem, path);
}

bool relaxation_tangents(const struct surface *surface, struct surface_cursor *cursor,
                         const struct surface_point *a, const struct surface_point *b,
                         struct vec3 *tangent_at_a, double *length, int *iterations) {
    struct problem problem;
    struct relaxation coarse, fine;
    struct vec3 pole;
    double chord = vec3_distance(a->jet.r, b->jet.r), velocity[2];
    if (surface_point_pole_distance(surface, a->jet.r, &pole) < pole_distance * chord ||
        !start_straight(surface, a, b, COARSE, &problem, &coarse) || !relax(&problem, &coarse))
        return false;
    start_refined(&problem, &coarse, &fine);
    if (!relax(&problem, &fine))
        return false;
    /* The speed is the same all along. */
    double least = HUGE_VAL, most = 0;
    for (int k = 0; k < fine.points; k++) {
        const double *y = fine.y[k];
        struct surface_jet jet;
        surface_jet_at(surface, cursor, problem.from[0] + y[0], problem.from[1] + y[1], &jet);
        double speed = vec3_norm(vec3_axpy(y[3], jet.v, vec3_scale(y[2], jet.u)));
        least = fmin(least, speed);
        most = fmax(most, speed);
    }
    if (!(most <= (1 + uneven_speed) * least))
        return false;
    for (int n = 0; n < 2; n++)
        velocity[n] = (4 * fine.y[0][2 + n] - coarse.y[0][2 + n]) / 3;
    struct vec3 along = vec3_axpy(velocity[1], a->jet.v, vec3_scale(velocity[0], a->jet.u));
    if (!(vec3_norm(along) <= detour * chord))
        return false;
    *length = vec3_norm(along);
    *tangent_at_a = vec3_unit(along);
    if (iterations)
        *iterations = coarse.iterations + fine.iterations;
    return true;
}
