/* SPDX-License-Identifier: MIT */
/*
 * Functions marked WIDE_CLONES are compiled for AVX as well, where four doubles are one register;
 * the processor's own is chosen when the program is loaded. Without contraction both versions give
 * the same bits. What they call must be INLINE to be wide, too.
 */
#ifndef SOLVER_WIDE_H
#define SOLVER_WIDE_H

#if defined(__x86_64__) && defined(__gnu_linux__) && !defined(__clang__) &&                        \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) && !defined(__SSP_ALL__)
#define WIDE_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define WIDE_CLONES
#endif

/* Whether a file may be compiled for registers wider than every processor's, by a pragma. */
#if defined(__x86_64__) && defined(__gnu_linux__) && !defined(__clang__)
#define WIDE_FILES 1
#else
#define WIDE_FILES 0
#endif

#if WIDE_FILES
#include <stdbool.h>

/* Whether the processor has registers of 4 or 8 doubles, as files compiled for them take. */
static inline bool wide_has(int doubles) {
    return doubles == 8 ? __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq")
                        : __builtin_cpu_supports("avx2");
}
#endif

#define INLINE static inline __attribute__((always_inline))

#endif
