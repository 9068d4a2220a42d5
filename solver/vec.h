/* SPDX-License-Identifier: MIT */
/* Vectors of space, passed and returned by value. */
#ifndef SOLVER_VEC_H
#define SOLVER_VEC_H

#include <math.h>
#include <stddef.h>

struct vec3 {
    double x, y, z;
};

static inline struct vec3 vec3_make(double x, double y, double z) {
    return (struct vec3){x, y, z};
}

static inline struct vec3 vec3_add(struct vec3 a, struct vec3 b) {
    return (struct vec3){a.x + b.x, a.y + b.y, a.z + b.z};
}

static inline struct vec3 vec3_sub(struct vec3 a, struct vec3 b) {
    return (struct vec3){a.x - b.x, a.y - b.y, a.z - b.z};
}

static inline struct vec3 vec3_scale(double s, struct vec3 a) {
    return (struct vec3){s * a.x, s * a.y, s * a.z};
}

/* To row k of three columns. */
static inline void vec3_to_columns(struct vec3 a, double *x, double *y, double *z, size_t k) {
    x[k] = a.x;
    y[k] = a.y;
    z[k] = a.z;
}

/* a + s b */
static inline struct vec3 vec3_axpy(double s, struct vec3 b, struct vec3 a) {
    return (struct vec3){a.x + s * b.x, a.y + s * b.y, a.z + s * b.z};
}

/* The corners of the box round a and b; a number of b that is NaN is left out. */
static inline struct vec3 vec3_min(struct vec3 a, struct vec3 b) {
    return (struct vec3){b.x < a.x ? b.x : a.x, b.y < a.y ? b.y : a.y, b.z < a.z ? b.z : a.z};
}

static inline struct vec3 vec3_max(struct vec3 a, struct vec3 b) {
    return (struct vec3){b.x > a.x ? b.x : a.x, b.y > a.y ? b.y : a.y, b.z > a.z ? b.z : a.z};
}

static inline double vec3_dot(struct vec3 a, struct vec3 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline struct vec3 vec3_cross(struct vec3 a, struct vec3 b) {
    return (struct vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static inline double vec3_norm2(struct vec3 a) {
    return vec3_dot(a, a);
}

static inline double vec3_norm(struct vec3 a) {
    return sqrt(vec3_dot(a, a));
}

static inline double vec3_distance(struct vec3 a, struct vec3 b) {
    return vec3_norm(vec3_sub(a, b));
}

/* a / |a|; the zero vector stays zero, so that no NaN arises here. */
static inline struct vec3 vec3_unit(struct vec3 a) {
    double n = vec3_norm(a);
    return n > 0 ? vec3_scale(1 / n, a) : a;
}

/* The angle between a and b in radians, 0..pi, accurate also near both ends. */
static inline double vec3_angle(struct vec3 a, struct vec3 b) {
    return atan2(vec3_norm(vec3_cross(a, b)), vec3_dot(a, b));
}

#endif
