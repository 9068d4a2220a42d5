/* SPDX-License-Identifier: MIT */
#include "method.h"

const struct drape_method_traits drape_method_traits[DRAPE_METHOD_COUNT] = {
    [DRAPE_BASIC] = {DRAPE_YARN_CHORD, .on_meshes = true, .cost = 1},
    [DRAPE_GEODESIC] = {DRAPE_YARN_GEODESIC, .on_meshes = true, .cost = 6},
    [DRAPE_MOSAIC] = {DRAPE_YARN_CHORD, .flat = true, .on_meshes = true, .cost = 5},
    [DRAPE_GIB] = {DRAPE_YARN_ARC, .on_meshes = true, .cost = 1},
    [DRAPE_GIB4] = {DRAPE_YARN_ARC, .corrected = true, .cost = 2.5},
};

const char *const drape_method_names[DRAPE_METHOD_COUNT] = {
    [DRAPE_BASIC] = "basic", [DRAPE_GEODESIC] = "geodesic", [DRAPE_MOSAIC] = "mosaic",
    [DRAPE_GIB] = "gib",     [DRAPE_GIB4] = "gib4",
};
