/* SPDX-License-Identifier: MIT */
/* Inside of a shell: its faces. Only the files of solver/surface include it. */
#ifndef SOLVER_SURFACE_FACES_H
#define SOLVER_SURFACE_FACES_H

#include "shell.h"
#include "spans.h"

struct face {
    struct surface surface; /* the caller's, as a face of this shell */
    struct trim *trim;      /* NULL: all of the domain */
    double area;
    struct vec3 centroid;
    int32_t component;
    int8_t side; /* by which it has to be turned to face like the first of its component: 1 or -1 */
};

struct shell {
    struct face *faces;
    size_t face_count, component_count;
    double tolerance, size;
    struct vec3 lower, upper;
    struct shell_edges edges;
};

#endif
