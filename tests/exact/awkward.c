/* SPDX-License-Identifier: MIT */
#include "awkward.h"

/* A spline of `spans` even spans over [0, 1]^2 with control points point(u, v). */
static void sample(struct shape *shape, const int degree[2], const int spans[2],
                   struct vec3 (*point)(double u, double v)) {
    for (int k = 0; k < 2; k++) {
        int p = degree[k], count = 0;
        for (int i = -p; i <= spans[k] + p; i++)
            shape->knots[k][count++] = fmin(fmax((double)i / spans[k], 0), 1);
        shape->degree[k] = p;
        shape->size[k] = count - p - 1;
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
        struct vec3 r = point(uv[0], uv[1]);
        double *h = shape->h[i];
        h[0] = r.x;
        h[1] = r.y;
        h[2] = r.z;
        h[3] = 1;
    }
}

static struct vec3 box(double u, double v) {
    double x = 2 * u - 1, y = 2 * v - 1;
    return vec3_make(x, y, 0.8 * (1 - pow(x, 8)) * (1 - pow(y, 8)));
}

static void make_box(struct shape *shape) {
    sample(shape, (int[2]){3, 3}, (int[2]){20, 20}, box);
}

/* A dome that runs out into a flat flange. */
static struct vec3 flange(double u, double v) {
    double x = 2.4 * u - 1.2, y = 2.4 * v - 1.2, s = (x * x + y * y) / 0.6;
    return vec3_make(x, y, 0.7 / (1 + s * s * s));
}

static void make_flange(struct shape *shape) {
    sample(shape, (int[2]){3, 3}, (int[2]){24, 24}, flange);
}

static struct vec3 helicoid(double u, double v) {
    double angle = 2 * M_PI * u, r = 2 * v - 1;
    return vec3_make(r * cos(angle), r * sin(angle), 0.25 * angle);
}

static void make_helicoid(struct shape *shape) {
    sample(shape, (int[2]){5, 5}, (int[2]){24, 4}, helicoid);
}

/* A spiral ramp: generators leave it soon, and the net goes round by yarns along its edge. */
static struct vec3 ramp(double u, double v) {
    double angle = 3 * M_PI * u, r = 0.4 + v;
    return vec3_make(r * cos(angle), r * sin(angle), 0.25 * angle);
}

static void make_ramp(struct shape *shape) {
    sample(shape, (int[2]){5, 5}, (int[2]){32, 4}, ramp);
}

static struct vec3 band(double u, double v) {
    double angle = 1.5 * M_PI * u, half = angle / 2, w = 0.6 * (2 * v - 1);
    double r = 1 + w * cos(half);
    return vec3_make(r * cos(angle), r * sin(angle), w * sin(half));
}

static struct vec3 moebius(double u, double v) {
    return band(4 * u / 3, v);
}

static void make_moebius(struct shape *shape) {
    sample(shape, (int[2]){4, 3}, (int[2]){28, 4}, moebius);
}

/* Degree 2: the curvature jumps at every knot. */
static struct vec3 waves(double u, double v) {
    return vec3_make(2 * u, 2 * v, 0.3 * sin(5 * u) * cos(4 * v));
}

static void make_joints(struct shape *shape) {
    sample(shape, (int[2]){2, 2}, (int[2]){5, 5}, waves);
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

void awkward_start(const struct awkward *which, const struct shape *shape, double uv[2]) {
    double lower[2], upper[2];
    shape_domain(shape, lower, upper);
    for (int k = 0; k < 2; k++)
        uv[k] = lower[k] + which->start[k] * (upper[k] - lower[k]);
}
