/* SPDX-License-Identifier: MIT */
/*
 * The same arithmetic on LANES numbers at once, one lane of a vector each. Every operation is that
 * of scalars, without contraction: a lane has the bits that a scalar would have, at any width.
 *
 * A file that includes this says LANES (2, 4 or 8) and, before anything that is compiled for wider
 * registers than every processor has, the target.
 */
#ifndef SOLVER_LANES_H
#define SOLVER_LANES_H

#include "vec.h"
#include "wide.h"
#include <stdbool.h>
#include <stdint.h>
#include <string.h>
#if defined(__x86_64__)
#include <immintrin.h>
#endif

/* Unlike vec3, nothing of these is used outside the functions that are compiled for the target. */
typedef double lanes __attribute__((vector_size(8 * LANES)));
typedef int64_t lanes_mask __attribute__((vector_size(8 * LANES))); /* -1 where true, else 0 */

struct lanes3 {
    lanes x, y, z;
};

/* struct surface_jet of several points. */
struct lanes_jet {
    struct lanes3 r, u, v, uu, uv, vv;
};

INLINE lanes lanes_load(const double *from) {
    lanes a;
    memcpy(&a, from, sizeof a);
    return a;
}

INLINE void lanes_store(lanes a, double *to) {
    memcpy(to, &a, sizeof a);
}

INLINE lanes lanes_of(double a) {
    return a - (lanes){0};
}

INLINE lanes lanes_select(lanes_mask choose, lanes a, lanes b) {
    return (lanes)(((lanes_mask)a & choose) | ((lanes_mask)b & ~choose));
}

INLINE lanes lanes_abs(lanes a) {
    return (lanes)((lanes_mask)a & INT64_MAX);
}

/* Neither infinite nor NaN. */
INLINE lanes_mask lanes_finite(lanes a) {
    return lanes_abs(a) < HUGE_VAL;
}

INLINE lanes lanes_sqrt(lanes a) {
#if defined(__x86_64__) && LANES == 8
    return (lanes)_mm512_sqrt_pd((__m512d)a);
#elif defined(__x86_64__) && LANES == 4
    return (lanes)_mm256_sqrt_pd((__m256d)a);
#elif defined(__x86_64__) && LANES == 2
    return (lanes)_mm_sqrt_pd((__m128d)a);
#else
    for (int k = 0; k < LANES; k++)
        a[k] = sqrt(a[k]);
    return a;
#endif
}

/* Of normal numbers: m, 1/2 <= m < 1, with x = m 2^e for x > 0; and x 2^k for a whole number k. */
INLINE lanes lanes_split(lanes x, lanes *e) {
    lanes_mask bits = (lanes_mask)x;
    *e = __builtin_convertvector((bits >> 52) - 1022, lanes);
    return (lanes)((bits & 0x000fffffffffffff) | 0x3fe0000000000000);
}

INLINE lanes lanes_scale2(lanes x, lanes k) {
    return (lanes)((lanes_mask)x + (__builtin_convertvector(k, lanes_mask) << 52));
}

/* Bit k is lane k. */
INLINE unsigned lanes_bits(lanes_mask mask) {
#if defined(__x86_64__) && LANES == 8
    return _mm512_movepi64_mask((__m512i)mask);
#elif defined(__x86_64__) && LANES == 4
    return (unsigned)_mm256_movemask_pd((__m256d)mask);
#elif defined(__x86_64__) && LANES == 2
    return (unsigned)_mm_movemask_pd((__m128d)mask);
#else
    unsigned bits = 0;
    for (int k = 0; k < LANES; k++)
        bits |= (unsigned)(mask[k] & 1) << k;
    return bits;
#endif
}

enum { LANES_ALL = (1 << LANES) - 1 };

INLINE bool lanes_any(lanes_mask mask) {
    return lanes_bits(mask) != 0;
}

INLINE bool lanes_all(lanes_mask mask) {
    return lanes_bits(mask) == LANES_ALL;
}

INLINE lanes_mask lanes_not(lanes_mask mask) {
    return ~mask;
}

/* ---- vectors of space, as in vec.h ---- */

INLINE struct lanes3 lanes3_of(struct vec3 a) {
    return (struct lanes3){lanes_of(a.x), lanes_of(a.y), lanes_of(a.z)};
}

INLINE struct lanes3 lanes3_add(struct lanes3 a, struct lanes3 b) {
    return (struct lanes3){a.x + b.x, a.y + b.y, a.z + b.z};
}

INLINE struct lanes3 lanes3_sub(struct lanes3 a, struct lanes3 b) {
    return (struct lanes3){a.x - b.x, a.y - b.y, a.z - b.z};
}

INLINE struct lanes3 lanes3_scale(lanes s, struct lanes3 a) {
    return (struct lanes3){s * a.x, s * a.y, s * a.z};
}

INLINE struct lanes3 lanes3_axpy(lanes s, struct lanes3 b, struct lanes3 a) {
    return (struct lanes3){a.x + s * b.x, a.y + s * b.y, a.z + s * b.z};
}

INLINE lanes lanes3_dot(struct lanes3 a, struct lanes3 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

INLINE struct lanes3 lanes3_cross(struct lanes3 a, struct lanes3 b) {
    return (struct lanes3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

INLINE lanes lanes3_norm2(struct lanes3 a) {
    return lanes3_dot(a, a);
}

INLINE struct lanes3 lanes3_select(lanes_mask choose, struct lanes3 a, struct lanes3 b) {
    return (struct lanes3){lanes_select(choose, a.x, b.x), lanes_select(choose, a.y, b.y),
                           lanes_select(choose, a.z, b.z)};
}

/* a / |a|; the zero vector stays zero. */
INLINE struct lanes3 lanes3_unit(struct lanes3 a) {
    lanes n = lanes_sqrt(lanes3_norm2(a));
    return lanes3_select(n > 0, lanes3_scale(1 / n, a), a);
}

#endif
