/* SPDX-License-Identifier: MIT */
/* The kernel of digits for the registers of AVX2. */
#include "digits.h"

#include "solver/wide.h"
#if WIDE_FILES
#include <immintrin.h>
#include <string.h>
#define LANES 4
#define DIGITS_KERNEL digits_kernel_4
#pragma GCC target("avx2,fma")
#include "digits_lanes.h"
#endif
