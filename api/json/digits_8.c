/* SPDX-License-Identifier: MIT */
/* The kernel of digits for the registers of AVX-512. */
#include "digits.h"

#include "solver/wide.h"
#if WIDE_FILES
#include <immintrin.h>
#include <string.h>
#define LANES 8
#define DIGITS_KERNEL digits_kernel_8
#pragma GCC target("avx512f,avx512dq,avx512vl,avx2,fma")
#include "digits_lanes.h"
#endif
