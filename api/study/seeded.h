/* SPDX-License-Identifier: MIT */
/* Random numbers that follow from a seed and their purpose alone. */
#ifndef API_STUDY_SEEDED_H
#define API_STUDY_SEEDED_H

#include <stddef.h>
#include <stdint.h>

/* Number `dimension` (below 64) of draw `k`, evenly from 0 to 1: Steele, Lea and Flood's mixing of
 * a counter. */
static inline double seeded_uniform(uint32_t seed, size_t k, unsigned dimension) {
    uint64_t z = ((uint64_t)seed << 32) + (uint64_t)k * 64 + dimension;
    z = (z + 0x9E3779B97F4A7C15u) * 0x9E3779B97F4A7C15u;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return (double)((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

/* About normal, with mean 0 and deviation 1; takes three numbers, from `first` on. */
static inline double seeded_bell(uint32_t seed, size_t k, unsigned first) {
    return 2 * (seeded_uniform(seed, k, first) + seeded_uniform(seed, k, first + 1) +
                seeded_uniform(seed, k, first + 2) - 1.5);
}

#endif
