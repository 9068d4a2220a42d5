/* SPDX-License-Identifier: MIT */
#include "reference.h"
#include "chebyshev.h"
#include <assert.h>
#include <stdlib.h>

enum { TAYLOR_ORDER = 24, SPHERE_ORDER = 30 };
/* Step of the Taylor expansions in z: small beside the distance to the complex singularities. */
static const double TAYLOR_STEP = 0.125;

typedef void reference_function(const struct reference *self, double s, double t,
                                struct exact_net_point *point);

/* A quadrant of the net on the unit sphere, r[0], with its derivatives r[1] = r_s and r[2] = r_t,
 * in axes where the start is x, warp y, and weft lies in the plane of y and z. */
struct sphere_quadrant {
    double length[2];
    struct vec3 r[3][SPHERE_ORDER][SPHERE_ORDER];
};

struct reference {
    reference_function *at;
    struct motion motion;
    double scale;          /* of the motion */
    struct frame start;    /* in the axes of the motion, except for the sphere */
    double a, b;           /* translation: coefficients; cylinder: radius; cone: half angle */
    struct chebyshev rule; /* sphere */
    struct vec3 centre;    /* sphere */
    double w0;             /* sphere: yarn angle at the start */
    struct sphere_quadrant *sphere[2]; /* s t > 0 and s t < 0 */
    struct exact_net *net;
};

/* Taylor coefficients of w about z0 from its first two, with S = sin w and C = cos w:
 * n S_n = sum k a_k C_(n-k), n C_n = -sum k a_k S_(n-k), and from z w'' + w' = -sin w
 * z0 (n+1)(n+2) a_(n+2) = -S_n - (n+1)^2 a_(n+1). At z0 = 0 the latter gives a_(n+1) itself. */
static void angle_series(double z0, double a[TAYLOR_ORDER]) {
    double sine[TAYLOR_ORDER] = {sin(a[0])}, cosine[TAYLOR_ORDER] = {cos(a[0])};
    for (int n = 0; n + 1 < TAYLOR_ORDER; n++) {
        for (int k = 1; k <= n; k++) {
            sine[n] += k * a[k] * cosine[n - k] / n;
            cosine[n] -= k * a[k] * sine[n - k] / n;
        }
        int m = (n + 1) * (n + 1);
        if (z0 == 0) {
            a[n + 1] = -sine[n] / m;
        } else if (n + 2 < TAYLOR_ORDER) {
            a[n + 2] = -(sine[n] + m * a[n + 1]) / (z0 * (n + 1) * (n + 2));
        }
    }
}

static void series_at(const double a[TAYLOR_ORDER], double h, double *w, double *dw) {
    *w = 0;
    *dw = 0;
    for (int n = TAYLOR_ORDER - 1; n >= 0; n--) {
        *dw = *dw * h + *w;
        *w = *w * h + a[n];
    }
}

void sphere_angle(double w0, double z, double *w, double *dw) {
    double a[TAYLOR_ORDER] = {w0}, at = 0;
    double sign = z < 0 ? -1 : 1;
    do {
        double next = fabs(z) - fabs(at) > TAYLOR_STEP ? at + sign * TAYLOR_STEP : z;
        angle_series(at, a);
        series_at(a, next - at, w, dw);
        a[0] = *w;
        a[1] = *dw;
        at = next;
    } while (at != z);
}

double sphere_collapse(double w0) {
    double z = 1, w, dw;
    for (int i = 0; i < 50; i++) {
        sphere_angle(w0, z, &w, &dw);
        z -= w / dw;
    }
    return z;
}

/* The sum of a row (or column, by `stride`) of values with one row of integration weights. */
static struct vec3 integral(const struct chebyshev *rule, int i, double length,
                            const struct vec3 *f, int stride) {
    struct vec3 sum = {0, 0, 0};
    for (int k = 0; k < rule->n; k++) {
        sum = vec3_axpy(length * rule->integral[i][k], f[k * stride], sum);
    }
    return sum;
}

/* One sweep of r_s = r_s(s, 0) - integral of cos w r dt, r_t likewise, r = r(0, t) + integral of
 * r_s. */
static void sphere_sweep(const struct chebyshev *rule, double w0,
                         double cosine[SPHERE_ORDER][SPHERE_ORDER], struct sphere_quadrant *q) {
    static struct vec3 f[SPHERE_ORDER][SPHERE_ORDER];
    for (int i = 0; i < SPHERE_ORDER; i++) {
        for (int j = 0; j < SPHERE_ORDER; j++) {
            f[i][j] = vec3_scale(-cosine[i][j], q->r[0][i][j]);
        }
    }
    for (int i = 0; i < SPHERE_ORDER; i++) {
        for (int j = 0; j < SPHERE_ORDER; j++) {
            double s = q->length[0] * rule->x[i], t = q->length[1] * rule->x[j];
            struct vec3 warp = {-sin(s), cos(s), 0};
            struct vec3 weft = {-sin(t), cos(t) * cos(w0), cos(t) * sin(w0)};
            q->r[1][i][j] = vec3_add(warp, integral(rule, j, q->length[1], f[i], 1));
            q->r[2][i][j] = vec3_add(weft, integral(rule, i, q->length[0], &f[0][j], SPHERE_ORDER));
        }
    }
    for (int i = 0; i < SPHERE_ORDER; i++) {
        for (int j = 0; j < SPHERE_ORDER; j++) {
            double t = q->length[1] * rule->x[j];
            struct vec3 edge = {cos(t), sin(t) * cos(w0), sin(t) * sin(w0)};
            struct vec3 along = integral(rule, i, q->length[0], &q->r[1][0][j], SPHERE_ORDER);
            q->r[0][i][j] = vec3_add(edge, along);
        }
    }
}

static struct sphere_quadrant *sphere_quadrant_make(const struct chebyshev *rule, double w0,
                                                    double sign, const double length[2]) {
    static double cosine[SPHERE_ORDER][SPHERE_ORDER];
    struct sphere_quadrant *q = calloc(1, sizeof *q);
    assert(q);
    q->length[0] = length[0];
    q->length[1] = length[1];
    for (int i = 0; i < SPHERE_ORDER; i++) {
        for (int j = 0; j < SPHERE_ORDER; j++) {
            double w, dw;
            sphere_angle(w0, sign * length[0] * rule->x[i] * length[1] * rule->x[j], &w, &dw);
            cosine[i][j] = sign * cos(w);
        }
    }
    for (int sweep = 0; sweep < 40; sweep++) {
        sphere_sweep(rule, sign > 0 ? w0 : M_PI - w0, cosine, q);
    }
    return q;
}

/* In quadrants of s t < 0 the net is that of the turned yarn with start angle 180 deg - w0. */
static void at_sphere(const struct reference *self, double s, double t,
                      struct exact_net_point *point) {
    double sign[2] = {s < 0 ? -1 : 1, t < 0 ? -1 : 1}, radius = self->a, dw, w;
    const struct sphere_quadrant *q = self->sphere[sign[0] != sign[1]];
    double angle = sign[0] != sign[1] ? M_PI - self->w0 : self->w0;
    double wx[CHEBYSHEV_MAX], wy[CHEBYSHEV_MAX];
    chebyshev_weights(&self->rule, fabs(s) / radius / q->length[0], wx);
    chebyshev_weights(&self->rule, fabs(t) / radius / q->length[1], wy);
    struct vec3 sum[3] = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}, axis[3];
    axis[0] = vec3_unit(vec3_sub(self->start.r, self->centre));
    axis[1] = vec3_scale(sign[0], self->start.warp);
    axis[2] = vec3_scale(sign[1], self->start.weft);
    axis[2] = vec3_scale(1 / sin(angle), vec3_axpy(-cos(angle), axis[1], axis[2]));
    for (int i = 0; i < SPHERE_ORDER * SPHERE_ORDER; i++) {
        int a = i / SPHERE_ORDER, b = i % SPHERE_ORDER;
        for (int k = 0; k < 3; k++) {
            sum[k] = vec3_axpy(wx[a] * wy[b], q->r[k][a][b], sum[k]);
        }
    }
    for (int k = 0; k < 3; k++) {
        struct vec3 turned = vec3_scale(sum[k].x, axis[0]);
        turned = vec3_axpy(sum[k].y, axis[1], turned);
        sum[k] = vec3_axpy(sum[k].z, axis[2], turned);
    }
    sphere_angle(self->w0, s * t / (radius * radius), &w, &dw);
    point->r = vec3_axpy(radius, sum[0], self->centre);
    point->warp = vec3_scale(sign[0], sum[1]);
    point->weft = vec3_scale(sign[1], sum[2]);
    point->shear_deg = 90 - w * 180 / M_PI;
}

static struct reference *reference_new(reference_function *at, const struct motion *motion) {
    struct reference *self = calloc(1, sizeof *self);
    assert(self);
    self->at = at;
    self->motion = *motion;
    self->scale = vec3_norm(motion_vector(motion, vec3_make(1, 0, 0)));
    return self;
}

struct reference *reference_sphere(struct vec3 centre, double radius, const struct frame *start,
                                   const double length[2]) {
    struct motion none = motion_identity();
    struct reference *self = reference_new(at_sphere, &none);
    double unit[2] = {length[0] / radius, length[1] / radius};
    self->centre = centre;
    self->a = radius;
    self->start = *start;
    self->w0 = vec3_angle(start->warp, start->weft);
    chebyshev_make(&self->rule, SPHERE_ORDER);
    self->sphere[0] = sphere_quadrant_make(&self->rule, self->w0, 1, unit);
    self->sphere[1] = sphere_quadrant_make(&self->rule, self->w0, -1, unit);
    return self;
}

/* The arc length of z = a x^2 / 2 is (X sqrt(1 + X^2) + asinh X) / (2 a), X = a x; Newton. */
static double parabola_x(double a, double s) {
    double x = s;
    for (int i = 0; i < 60; i++) {
        double slope = a * x;
        double length = (slope * sqrt(1 + slope * slope) + asinh(slope)) / (2 * a);
        x -= (length - s) / sqrt(1 + slope * slope);
    }
    return x;
}

/* Into space, and the shear from the tangents. */
static void finish(const struct reference *self, struct exact_net_point *point) {
    point->r = motion_point(&self->motion, point->r);
    point->warp = vec3_unit(motion_vector(&self->motion, point->warp));
    point->weft = vec3_unit(motion_vector(&self->motion, point->weft));
    point->shear_deg = 90 - vec3_angle(point->warp, point->weft) * 180 / M_PI;
}

static void at_translation(const struct reference *self, double s, double t,
                           struct exact_net_point *point) {
    double x = parabola_x(self->a, s / self->scale), y = parabola_x(self->b, t / self->scale);
    point->r = vec3_make(x, y, (self->a * x * x + self->b * y * y) / 2);
    point->warp = vec3_make(1, 0, self->a * x);
    point->weft = vec3_make(0, 1, self->b * y);
    finish(self, point);
}

struct reference *reference_translation(const struct motion *motion, double a, double b) {
    struct reference *self = reference_new(at_translation, motion);
    self->a = a;
    self->b = b;
    return self;
}

/* Back through a similarity: M^T / scale^2. */
static struct vec3 back(const struct reference *self, struct vec3 a) {
    struct motion inverse = motion_identity();
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            inverse.m[i][j] = self->motion.m[j][i] / (self->scale * self->scale);
        }
    }
    return motion_vector(&inverse, a);
}

static void set_start(struct reference *self, const struct frame *start) {
    self->start.r = back(self, vec3_sub(start->r, self->motion.shift));
    self->start.warp = vec3_unit(back(self, start->warp));
    self->start.weft = vec3_unit(back(self, start->weft));
}

static void at_plane(const struct reference *self, double s, double t,
                     struct exact_net_point *point) {
    const struct frame *start = &self->start;
    point->r = vec3_axpy(s, start->warp, vec3_axpy(t, start->weft, start->r));
    point->warp = start->warp;
    point->weft = start->weft;
    finish(self, point);
}

struct reference *reference_plane(const struct frame *start) {
    struct motion none = motion_identity();
    struct reference *self = reference_new(at_plane, &none);
    self->start = *start;
    return self;
}

/* (e_rho, e_phi) at longitude phi. */
static void polar(double phi, struct vec3 *out, struct vec3 *round) {
    *out = vec3_make(cos(phi), sin(phi), 0);
    *round = vec3_make(-sin(phi), cos(phi), 0);
}

static void at_cylinder(const struct reference *self, double s, double t,
                        struct exact_net_point *point) {
    const struct frame *start = &self->start;
    struct vec3 out, round;
    double phi = atan2(start->r.y, start->r.x), z = start->r.z;
    polar(phi, &out, &round);
    double warp = vec3_dot(start->warp, round), weft = vec3_dot(start->weft, round);
    s /= self->scale;
    t /= self->scale;
    phi += (s * warp + t * weft) / self->a;
    z += s * start->warp.z + t * start->weft.z;
    polar(phi, &out, &round);
    point->r = vec3_add(vec3_scale(self->a, out), vec3_make(0, 0, z));
    point->warp = vec3_axpy(warp, round, vec3_make(0, 0, start->warp.z));
    point->weft = vec3_axpy(weft, round, vec3_make(0, 0, start->weft.z));
    finish(self, point);
}

struct reference *reference_cylinder(const struct motion *motion, double radius,
                                     const struct frame *start) {
    struct reference *self = reference_new(at_cylinder, motion);
    self->a = radius;
    set_start(self, start);
    return self;
}

/* Unrolled about its apex, the cone is a sector: slant l is the radius, phi sin(half angle) the
 * angle. `flat` is a direction there, along and across the ray of the start. */
static struct vec3 unrolled(double beta, const double flat[2], double angle, double phi) {
    struct vec3 out, round;
    polar(phi, &out, &round);
    struct vec3 ray = vec3_add(vec3_scale(sin(beta), out), vec3_make(0, 0, cos(beta)));
    double along = flat[0] * cos(angle) + flat[1] * sin(angle);
    double across = flat[1] * cos(angle) - flat[0] * sin(angle);
    return vec3_add(vec3_scale(along, ray), vec3_scale(across, round));
}

static void at_cone(const struct reference *self, double s, double t,
                    struct exact_net_point *point) {
    const struct frame *start = &self->start;
    struct vec3 out, round;
    double phi = atan2(start->r.y, start->r.x), beta = self->a;
    polar(phi, &out, &round);
    struct vec3 ray = vec3_add(vec3_scale(sin(beta), out), vec3_make(0, 0, cos(beta)));
    double warp[2] = {vec3_dot(start->warp, ray), vec3_dot(start->warp, round)};
    double weft[2] = {vec3_dot(start->weft, ray), vec3_dot(start->weft, round)};
    s /= self->scale;
    t /= self->scale;
    double flat[2] = {vec3_norm(start->r) + s * warp[0] + t * weft[0], s * warp[1] + t * weft[1]};
    double angle = atan2(flat[1], flat[0]);
    phi += angle / sin(beta);
    point->r = unrolled(beta, flat, angle, phi);
    point->warp = unrolled(beta, warp, angle, phi);
    point->weft = unrolled(beta, weft, angle, phi);
    finish(self, point);
}

struct reference *reference_cone(const struct motion *motion, double half_angle,
                                 const struct frame *start) {
    struct reference *self = reference_new(at_cone, motion);
    self->a = half_angle;
    set_start(self, start);
    return self;
}

static void at_net(const struct reference *self, double s, double t,
                   struct exact_net_point *point) {
    exact_net_at(self->net, s, t, point);
}

struct reference *reference_net(const struct exact_net_setup *setup) {
    struct motion none = motion_identity();
    struct reference *self = reference_new(at_net, &none);
    self->net = exact_net_make(setup);
    return self;
}

const struct exact_net *reference_get_net(const struct reference *reference) {
    return reference->net;
}

void reference_free(struct reference *reference) {
    if (reference) {
        exact_net_free(reference->net);
        free(reference->sphere[0]);
        free(reference->sphere[1]);
        free(reference);
    }
}

void reference_at(const struct reference *reference, double s, double t,
                  struct exact_net_point *point) {
    reference->at(reference, s, t, point);
}

static struct vec3 great_circle(double radius, struct vec3 r, struct vec3 along, double length) {
    double a = length / radius;
    return vec3_axpy(radius * sin(a), along, vec3_scale(cos(a), r));
}

void sphere_recursion(double radius, const struct frame *start, const double arc[2], const int n[2],
                      struct vec3 *out) {
    int row = n[0] + 1;
    for (int i = 0; i <= n[0]; i++) {
        out[i] = great_circle(radius, start->r, start->warp, i * arc[0]);
    }
    for (int j = 1; j <= n[1]; j++) {
        out[j * row] = great_circle(radius, start->r, start->weft, j * arc[1]);
        for (int i = 1; i <= n[0]; i++) {
            struct vec3 a = out[(j - 1) * row + i - 1];
            struct vec3 m = vec3_unit(vec3_add(out[(j - 1) * row + i], out[j * row + i - 1]));
            out[j * row + i] = vec3_axpy(2 * vec3_dot(a, m), m, vec3_scale(-1, a));
        }
    }
}
