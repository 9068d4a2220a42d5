/* SPDX-License-Identifier: MIT */
/* The wave's kernel for registers of two numbers, which every processor has. */
#define LANES 2
#define WAVE_KERNEL wave_kernel_2
#include "wave_cells.h"
