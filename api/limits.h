/* SPDX-License-Identifier: MIT */
/* What one job may cost. */
#ifndef API_LIMITS_H
#define API_LIMITS_H

#include <stddef.h>

/* Zero-initialised fields are not allowed: see `api_limits_default`. */
struct api_limits {
    size_t max_nodes;          /* nodes in one net */
    size_t max_memory;         /* bytes the job's arena may hold */
    size_t max_elements;       /* JSON values in the body, counted before parsing: `prescan.h` */
    size_t max_control_points; /* of one surface */
    int max_depth;             /* JSON nesting */
    int threads;               /* threads on one drape */
    size_t max_variants;       /* of one study */
};

/* 4e6 nodes, 4 GiB, 4e6 elements, 512 x 512 control points, depth 32, one thread, 1e6
 * variants. */
extern const struct api_limits api_limits_default;

#endif
