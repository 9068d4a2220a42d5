/* SPDX-License-Identifier: MIT */
/* Collocation for registers of two numbers, which every processor has. */
#define LANES 2
#define COLLOCATION_KERNEL collocation_kernel_2
#include "collocation_points.h"
