/* SPDX-License-Identifier: MIT */
/* Collocation for the registers of AVX2. */
#include "solver/wide.h"
#if WIDE_FILES
#include "collocation.h"
#include <immintrin.h>
#include <string.h>
#define LANES 4
#define COLLOCATION_KERNEL collocation_kernel_4
#pragma GCC target("avx2")
#include "collocation_points.h"
#endif
