/* SPDX-License-Identifier: MIT */
/* The constructions of `shapes.h`. */
#include "shapes.h"
#include <assert.h>
#include <string.h>

/* A rational curve of the half plane (rho, z), homogeneous (w rho, w z, w). */
struct profile {
    int degree, size;
    double knots[SHAPE_KNOTS_MAX];
    double h[SHAPE_SIZE_MAX][3];
};

static void clamp_knots(double *knots, int degree, const double range[2]) {
    for (int i = 0; i <= degree; i++) {
        knots[i] = range[0];
        knots[degree + 1 + i] = range[1];
    }
}

static void one_span(struct shape *shape, int degree, const double u[2], const double v[2]) {
    for (int k = 0; k < 2; k++) {
        shape->degree[k] = degree;
        shape->size[k] = degree + 1;
        clamp_knots(shape->knots[k], degree, k == 0 ? u : v);
    }
}

void shape_plane(struct shape *shape, const double x[2], const double y[2]) {
    one_span(shape, 1, x, y);
    for (int i = 0; i < 4; i++) {
        double h[4] = {x[i / 2], y[i % 2], 0, 1};
        memcpy(shape->h[i], h, sizeof h);
    }
}

/* Control values over [a, b] of x (`power` 1) and x^2 (2) at degree 2: their blossoms. */
static double blossom(const double range[2], int i, int power) {
    double a = range[i == 2], b = range[i != 0];
    return power == 1 ? (a + b) / 2 : a * b;
}

void shape_quadric(struct shape *shape, double a, double b, const double x[2], const double y[2]) {
    one_span(shape, 2, x, y);
    for (int i = 0; i < 9; i++) {
        double xx = blossom(x, i / 3, 2), yy = blossom(y, i % 3, 2);
        double h[4] = {blossom(x, i / 3, 1), blossom(y, i % 3, 1), (a * xx + b * yy) / 2, 1};
        memcpy(shape->h[i], h, sizeof h);
    }
}

void shape_stereographic(struct shape *shape, double radius, const double u[2], const double v[2]) {
    one_span(shape, 2, u, v);
    for (int i = 0; i < 9; i++) {
        double square = blossom(u, i / 3, 2) + blossom(v, i % 3, 2);
        double h[4] = {2 * radius * blossom(u, i / 3, 1), 2 * radius * blossom(v, i % 3, 1),
                       radius * (1 - square), 1 + square};
        assert(h[3] > 0);
        memcpy(shape->h[i], h, sizeof h);
    }
}

/* An arc about (centre, 0) in quadratic spans of equal angle, at most `widest`: the middle
 * point of a span of angle 2 g lies where the end tangents meet and has weight cos g. */
static void arc(struct profile *curve, double centre, double radius, const double angle[2],
                double widest) {
    int spans = (int)ceil(fabs(angle[1] - angle[0]) / widest - 1e-9);
    double half = (angle[1] - angle[0]) / (2 * spans);
    curve->degree = 2;
    curve->size = 2 * spans + 1;
    for (int i = 0; i < curve->size; i++) {
        double a = angle[0] + half * i, w = i % 2 ? cos(half) : 1;
        double reach = i % 2 ? radius : radius * w; /* radius / cos(half), times the weight */
        curve->h[i][0] = centre * w + reach * cos(a);
        curve->h[i][1] = reach * sin(a);
        curve->h[i][2] = w;
    }
    for (int i = 0; i < curve->size + 3; i++) {
        int knot = i < 1 ? 0 : (i - 1) / 2;
        curve->knots[i] = (double)(knot > spans ? spans : knot) / spans;
    }
}

static void revolve(struct shape *shape, const struct profile *profile, const double turn[2],
                    double widest) {
    struct profile circle;
    arc(&circle, 0, 1, turn, widest);
    shape->degree[0] = circle.degree;
    shape->degree[1] = profile->degree;
    shape->size[0] = circle.size;
    shape->size[1] = profile->size;
    memcpy(shape->knots[0], circle.knots, sizeof circle.knots);
    memcpy(shape->knots[1], profile->knots, sizeof profile->knots);
    for (int i = 0; i < circle.size; i++) {
        for (int j = 0; j < profile->size; j++) {
            double *h = shape->h[i * profile->size + j];
            h[0] = circle.h[i][0] * profile->h[j][0];
            h[1] = circle.h[i][1] * profile->h[j][0];
            h[2] = circle.h[i][2] * profile->h[j][1];
            h[3] = circle.h[i][2] * profile->h[j][2];
        }
    }
}

/* cos(90 deg) is 6e-17: a pole of the sphere and the seam of a full turn are made exact. */
static void snap(struct profile *profile) {
    for (int i = 0; i < profile->size; i++) {
        for (int c = 0; c < 2; c++) {
            if (fabs(profile->h[i][c]) < 1e-14 * profile->h[0][2] * 1e3) {
                profile->h[i][c] = 0;
            }
        }
    }
}

void shape_sphere(struct shape *shape, double radius, const double turn[2],
                  const double latitude[2], double widest) {
    struct profile profile;
    arc(&profile, 0, 1, latitude, widest);
    snap(&profile);
    revolve(shape, &profile, turn, widest);
    struct motion scale = motion_stretch(radius, radius, radius);
    shape_move(shape, &scale);
}

void shape_torus(struct shape *shape, double major, double minor, const double turn[2],
                 const double tube[2], double widest) {
    struct profile profile;
    arc(&profile, major, minor, tube, widest);
    revolve(shape, &profile, turn, widest);
}

void shape_frustum(struct shape *shape, const double turn[2], const double a[2], const double b[2],
                   double widest) {
    struct profile profile = {
        .degree = 1, .size = 2, .knots = {0, 0, 1, 1}, .h = {{a[0], a[1], 1}, {b[0], b[1], 1}}};
    revolve(shape, &profile, turn, widest);
}

void shape_crease(struct shape *shape, double half, double rise) {
    static const double ku[] = {0, 0, 0, 0.5, 0.5, 1, 1, 1}, kv[] = {0, 0, 1, 1};
    shape->degree[0] = 2;
    shape->degree[1] = 1;
    shape->size[0] = 5;
    shape->size[1] = 2;
    memcpy(shape->knots[0], ku, sizeof ku);
    memcpy(shape->knots[1], kv, sizeof kv);
    for (int i = 0; i < 10; i++) {
        double x = half * (i / 2 - 2) / 2.0;
        double up = x > 0 ? x * sin(rise) : 0, along = x > 0 ? x * cos(rise) : x;
        double h[4] = {along, half * (i % 2 ? 1 : -1), up, 1};
        memcpy(shape->h[i], h, sizeof h);
    }
}

static void put(struct shape *shape, int i, int j, struct vec3 r, double weight) {
    double h[4] = {weight * r.x, weight * r.y, weight * r.z, weight};
    memcpy(shape->h[i * shape->size[1] + j], h, sizeof h);
}

void shape_disk(struct shape *shape, double radius) {
    static const double range[2] = {0, 1};
    one_span(shape, 2, range, range);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            bool edge = (i == 1) != (j == 1);
            double reach = radius * (edge ? sqrt(2) : sqrt(0.5));
            struct vec3 point = {reach * (i - 1), reach * (j - 1), 0};
            put(shape, i, j, point, edge ? sqrt(0.5) : 1);
        }
    }
}

void shape_freeform(struct shape *shape) {
    static const double knots[2][11] = {{0, 0, 0, 0, 0.22, 0.47, 0.81, 1, 1, 1, 1},
                                        {0, 0, 0, 0, 0.35, 0.55, 0.7, 1, 1, 1, 1}};
    for (int k = 0; k < 2; k++) {
        shape->degree[k] = 3;
        shape->size[k] = 7;
        memcpy(shape->knots[k], knots[k], sizeof knots[k]);
    }
    for (int i = 0; i < 7; i++) {
        for (int j = 0; j < 7; j++) {
            double x = (i - 3) / 3.0, y = (j - 3) / 3.0;
            double z = 0.3 * cos(2.1 * x) * cos(1.7 * y + 0.4) + 0.1 * x * y;
            double weight = 1 + 0.5 * sin(0.9 * i + 1.3 * j);
            put(shape, i, j, vec3_make(x + 0.03 * sin(3 * y), y - 0.02 * x, z), weight);
        }
    }
}

void shape_bezier(struct shape *shape) {
    static const double z[4][4] = {
        {0.1, 0.4, 0.3, -0.2}, {0.3, 0.7, 0.2, 0.1}, {-0.1, 0.5, 0.6, 0.2}, {0.0, -0.3, 0.3, 0.4}};
    static const double range[2] = {0, 1}, knots[2][3] = {{0.13, 0.5, 0.77}, {0.31, 0.42, 0.9}};
    one_span(shape, 3, range, range);
    for (int i = 0; i < 4; i++) {
        for (int j = 0; j < 4; j++) {
            double x = (2 * i - 3) / 3.0, y = (2 * j - 3) / 3.0;
            put(shape, i, j, vec3_make(x, y + 0.1 * x * x, z[i][j]), 1 + 0.25 * ((i + 2 * j) % 3));
        }
    }
    for (int i = 0; i < 3; i++) {
        shape_insert_knot(shape, 0, knots[0][i]);
        shape_insert_knot(shape, 1, knots[1][i]);
    }
}

double random_unit(uint64_t *seed) {
    uint64_t z = (*seed += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    z ^= z >> 31;
    return (double)(z >> 11) * 0x1p-53;
}

double random_between(uint64_t *seed, double low, double high) {
    return low + (high - low) * random_unit(seed);
}

/* Up to six spans with a width ratio of at most 4. */
static void random_axis(struct shape *shape, int k, uint64_t *seed) {
    int degree = 2 + (int)(8 * random_unit(seed)), spans = 1 + (int)(6 * random_unit(seed));
    double x = 0;
    shape->degree[k] = degree;
    shape->size[k] = degree + spans;
    for (int i = 0; i < spans + 2 * degree + 1; i++) {
        shape->knots[k][i] = x;
        if (i >= degree && i < degree + spans) {
            x += random_between(seed, 0.25, 1);
        }
    }
    for (int i = 0; i < spans + 2 * degree + 1; i++) {
        shape->knots[k][i] /= x;
    }
}

/* The Greville abscissa of control point i, mapped to [-1, 1]: with it as the coordinate and equal
 * weights, the parametrisation is the identity. */
static double greville(const struct shape *shape, int k, int i) {
    double sum = 0;
    for (int l = 1; l <= shape->degree[k]; l++) {
        sum += shape->knots[k][i + l];
    }
    return 2 * sum / shape->degree[k] - 1;
}

/* Heights are a sum of three waves, so that the surface is smooth on the scale of its size however
 * fine its knots are; weights vary by up to 5 either way, smoothly for the same reason. */
void shape_random(struct shape *shape, uint64_t *seed) {
    double wave[4][4];
    random_axis(shape, 0, seed);
    random_axis(shape, 1, seed);
    for (int l = 0; l < 4; l++) {
        wave[l][0] = random_between(seed, -2.5, 2.5);
        wave[l][1] = random_between(seed, -2.5, 2.5);
        wave[l][2] = random_between(seed, 0, 2 * M_PI);
        wave[l][3] = random_between(seed, -0.15, 0.15);
    }
    double spread = random_unit(seed) * log(5);
    for (int i = 0; i < shape->size[0]; i++) {
        for (int j = 0; j < shape->size[1]; j++) {
            double x = greville(shape, 0, i), y = greville(shape, 1, j), z = 0;
            for (int l = 0; l < 3; l++) {
                z += wave[l][3] * sin(wave[l][0] * x + wave[l][1] * y + wave[l][2]);
            }
            double weight = exp(spread * sin(wave[3][0] * x + wave[3][1] * y + wave[3][2]));
            put(shape, i, j, vec3_make(x, y, z), weight);
        }
    }
}
