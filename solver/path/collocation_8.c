/* SPDX-License-Identifier: MIT */
/* Collocation for the registers of AVX-512. */
#include "solver/wide.h"
#if WIDE_FILES
#include "collocation.h"
#include <immintrin.h>
#include <string.h>
#define LANES 8
#define COLLOCATION_KERNEL collocation_kernel_8
#pragma GCC target("avx512f,avx512dq,avx512vl,avx2")
#include "collocation_points.h"
#endif
