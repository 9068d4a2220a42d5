/* SPDX-License-Identifier: MIT */
#include "awkward.h"

/* A spline of `spans` even spans over [0, 1]^2 with control points point(u, v, p). */
static void sample(struct shape *shape, const int degree[2], const int spans[2],
                   struct vec3 (*point)(double u, double v, const double p[]), const double p[]) {
    for (int k = 0; k < 2; k++) {
        int n = degree[k], count = 0;
        for (int i = -n; i <= spans[k] + n; i++)
            shape->knots[k][count++] = fmin(fmax((double)i / spans[k], 0), 1);
        shape->degree[k] = n;
        shape->size[k] = count - n - 1;
    }
    for (int i = 0; i < shape->size[0] * shape->size[1]; i++) {
        int at[2] = {i / shape->size[1], i % shape->size[1]};
        double uv[2];
        for (int k = 0; k < 2; k++) {
            double sum = 0;
            for (int m = 1; m <= degree[k]; m++)
                sum += shape->knots[k][at[k] + m];
            uv[k] = sum / degree[k];
        }
        struct vec3 r = point(uv[0], uv[1], p);
        double *h = shape->h[i];
        h[0] = r.x;
        h[1] = r.y;
        h[2] = r.z;
        h[3] = 1;
    }
}

/* Width, height, and how sharply the edges along and across are bent. */
static struct vec3 box(double u, double v, const double p[]) {
    double x = 2 * u - 1, y = 2 * v - 1;
    return vec3_make(x, p[0] * y, p[1] * (1 - pow(fabs(x), p[2])) * (1 - pow(fabs(y), p[3])));
}

static void make_box(struct shape *shape) {
    sample(shape, (int[2]){3, 3}, (int[2]){20, 20}, box, (double[4]){1, 0.8, 8, 8});
}

/* A dome that runs out into a flat flange: height, radius squared, steepness, shape. */
static struct vec3 flange(double u, double v, const double p[]) {
    double x = 2.4 * u - 1.2, y = 2.4 * v - 1.2, s = (x * x + p[3] * y * y) / p[1];
    return vec3_make(x, y, p[0] / (1 + pow(s, p[2])));
}

static void make_flange(struct shape *shape) {
    sample(shape, (int[2]){3, 3}, (int[2]){24, 24}, flange, (double[4]){0.7, 0.6, 3, 1});
}

/* Turn, pitch, and the radii between which it lies. */
static struct vec3 helicoid(double u, double v, const double p[]) {
    double angle = p[0] * u, r = p[2] + v * (p[3] - p[2]);
    return vec3_make(r * cos(angle), r * sin(angle), p[1] * angle);
}

static void make_helicoid(struct shape *shape) {
    sample(shape, (int[2]){5, 5}, (int[2]){24, 4}, helicoid, (double[4]){2 * M_PI, 0.25, -1, 1});
}

/* A spiral ramp: generators leave it soon, and the net goes round by yarns along its edge. */
static void make_ramp(struct shape *shape) {
    sample(shape, (int[2]){5, 5}, (int[2]){32, 4}, helicoid, (double[4]){3 * M_PI, 0.25, 0.4, 1.4});
}

/* Turn and half its width. */
static struct vec3 moebius(double u, double v, const double p[]) {
    double angle = p[0] * u, half = angle / 2, w = p[1] * (2 * v - 1);
    double r = 1 + w * cos(half);
    return vec3_make(r * cos(angle), r * sin(angle), w * sin(half));
}

static void make_moebius(struct shape *shape) {
    sample(shape, (int[2]){4, 3}, (int[2]){28, 4}, moebius, (double[2]){2 * M_PI, 0.6});
}

/* Height, and how many along u and v. */
static struct vec3 waves(double u, double v, const double p[]) {
    return vec3_make(2 * u, 2 * v, p[0] * sin(p[1] * u) * cos(p[2] * v));
}

/* Degree 2: the curvature jumps at every knot. */
static void make_joints(struct shape *shape) {
    sample(shape, (int[2]){2, 2}, (int[2]){5, 5}, waves, (double[3]){0.3, 5, 4});
}

static void make_roof(struct shape *shape) {
    shape_crease(shape, 1, M_PI / 3);
}

static void make_whole_torus(struct shape *shape) {
    shape_torus(shape, 2, 0.7, (double[2]){0, 2 * M_PI}, (double[2]){0, 2 * M_PI}, M_PI / 2);
}

static void make_inner_torus(struct shape *shape) {
    shape_torus(shape, 2, 1.2, (double[2]){0, 2}, (double[2]){2, 4.2}, M_PI / 2);
}

static void make_octant(struct shape *shape) {
    shape_sphere(shape, 1, (double[2]){0, M_PI / 2}, (double[2]){0, M_PI / 2}, M_PI / 2);
}

static void make_annulus(struct shape *shape) {
    shape_frustum(shape, (double[2]){0, 5}, (double[2]){1.5, 0}, (double[2]){2.5, 0.3}, M_PI / 2);
}

static void make_cone(struct shape *shape) {
    shape_frustum(shape, (double[2]){0, 3}, (double[2]){1, 0}, (double[2]){2, 1.5}, M_PI / 2);
}

static void make_saddle(struct shape *shape) {
    shape_quadric(shape, 1.5, -1, (double[2]){-1, 1}, (double[2]){-1, 1});
}

const struct awkward awkward[AWKWARD] = {
    {"box", make_box, {0.5, 0.5}, 30, 0.1, 12},
    {"flange", make_flange, {0.5, 0.5}, 0, 0.1, 14},
    {"flange, start outside", make_flange, {0.15, 0.2}, 20, 0.1, 30},
    {"helicoid", make_helicoid, {0.5, 0.5}, 0, 0.1, 20},
    {"helicoid, from its edge", make_helicoid, {0.5, 0.85}, 60, 0.1, 30},
    {"ramp", make_ramp, {0.5, 0.7}, 20, 0.1, 60},
    {"annulus, from its edge", make_annulus, {0.5, 0}, 25, 0.1, 80},
    {"torus, outside", make_whole_torus, {0, 0}, 80, 0.12, 30},
    {"torus, inside", make_inner_torus, {0.5, 0.5}, 10, 0.08, 10},
    {"Moebius band", make_moebius, {0.5, 0.5}, 10, 0.08, 24},
    {"C1 joints", make_joints, {0.45, 0.5}, 25, 0.12, 14},
    {"roof", make_roof, {0.4, 0.45}, 25, 0.1, 12},
    {"octant near its pole", make_octant, {0.4, 0.6}, 30, 0.05, 14},
    {"cone, from a corner", make_cone, {0, 0}, 33, 0.1, 40},
    {"saddle, coarse", make_saddle, {0.55, 0.6}, 15, 0.12, 10},
    {"rational bicubic", shape_bezier, {0.5, 0.5}, 70, 0.06, 12},
};

/* ---- families ---- */

static void random_box(struct shape *shape, uint64_t *seed) {
    const double p[] = {random_between(seed, 0.6, 1.5), random_between(seed, 0.3, 1),
                        random_between(seed, 4, 10), random_between(seed, 4, 10)};
    sample(shape, (int[2]){3, 3}, (int[2]){20, 20}, box, p);
}

static void random_flange(struct shape *shape, uint64_t *seed) {
    const double p[] = {random_between(seed, 0.3, 0.9), random_between(seed, 0.4, 0.8),
                        random_between(seed, 2, 4), random_between(seed, 0.6, 1.5)};
    sample(shape, (int[2]){3, 3}, (int[2]){24, 24}, flange, p);
}

static void random_helicoid(struct shape *shape, uint64_t *seed) {
    double inner = random_between(seed, -0.5, 0.5);
    const double p[] = {random_between(seed, 2, 7), random_between(seed, 0.15, 0.6), inner,
                        inner + random_between(seed, 0.7, 1.5)};
    sample(shape, (int[2]){5, 5}, (int[2]){24, 4}, helicoid, p);
}

static void random_moebius(struct shape *shape, uint64_t *seed) {
    const double p[] = {random_between(seed, 3, 6), random_between(seed, 0.3, 0.7)};
    sample(shape, (int[2]){4, 3}, (int[2]){28, 4}, moebius, p);
}

static void random_joints(struct shape *shape, uint64_t *seed) {
    const double p[] = {random_between(seed, 0.1, 0.4), random_between(seed, 2, 6),
                        random_between(seed, 2, 6)};
    int spans = (int)random_between(seed, 3, 8);
    sample(shape, (int[2]){2, 2}, (int[2]){spans, spans}, waves, p);
}

static void random_torus(struct shape *shape, uint64_t *seed) {
    double u = random_between(seed, 0, 6), v = random_between(seed, 0, 6);
    const double turn[] = {u, u + random_between(seed, 1.5, 4)};
    const double tube[] = {v, v + random_between(seed, 2, 4)};
    shape_torus(shape, 1, random_between(seed, 0.3, 0.7), turn, tube, M_PI / 2);
}

static void random_weights(struct shape *shape, uint64_t *seed) {
    shape_random(shape, seed);
    for (int k = 0; k < shape->size[0] * shape->size[1]; k++) {
        double scale = exp(random_between(seed, -2.3, 2.3)) / shape->h[k][3];
        for (int n = 0; n < 4; n++)
            shape->h[k][n] *= scale;
    }
}

const struct awkward_family awkward_families[AWKWARD_FAMILIES] = {
    {"boxes", random_box},
    {"flanges", random_flange},
    {"helicoids", random_helicoid},
    {"Moebius bands", random_moebius},
    {"C1 joints", random_joints},
    {"tori", random_torus},
    {"weights of 0.1 to 10", random_weights},
};

void awkward_start(const struct awkward *which, const struct shape *shape, double uv[2]) {
    double lower[2], upper[2];
    shape_domain(shape, lower, upper);
    for (int k = 0; k < 2; k++)
        uv[k] = lower[k] + which->start[k] * (upper[k] - lower[k]);
}
