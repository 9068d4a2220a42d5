/* SPDX-License-Identifier: MIT */
/* The wave's kernel for the registers of AVX-512. */
#include "wave.h"

#include "solver/wide.h"
#if WIDE_FILES
#include "solver/fishnet/rough.h"
#include <immintrin.h>
#include <string.h>
#define LANES 8
#define WAVE_KERNEL wave_kernel_8
#pragma GCC target("avx512f,avx512dq,avx512vl,avx2")
#include "wave_cells.h"
#endif
