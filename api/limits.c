/* SPDX-License-Identifier: MIT */
#include "limits.h"

const struct api_limits api_limits_default = {
    .max_nodes = 4000000,
    .max_memory = (size_t)4 << 30,
    .max_elements = 4000000,
    .max_control_points = (size_t)512 * 512,
    .max_depth = 32,
    .threads = 1,
    .max_variants = 1000000,
};
