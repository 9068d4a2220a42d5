/* SPDX-License-Identifier: MIT */
/* The wave's kernel for the registers of AVX2. */
#include "wave.h"

#include "solver/wide.h"
#if WIDE_FILES
#include "solver/fishnet/rough.h"
#include <immintrin.h>
#include <string.h>
#define LANES 4
#define WAVE_KERNEL wave_kernel_4
#pragma GCC target("avx2")
#include "wave_cells.h"
#endif
