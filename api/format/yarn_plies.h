/* SPDX-License-Identifier: MIT */
/*
 * A map's plies as layers that solvers of structures know: each with one orthotropic frame, though
 * the yarns of a sheared weave are not square.
 *
 * With the share a of warp, the shear g and the thickness t of a ply at an element:
 * - warp: one layer along the warp, as if weft were at right angles to it.
 * - yarns: two unidirectional layers, along warp of a t and above it, on the side on which plies
 *   follow, along weft of (1 - a) t.
 * - bisector: one layer of t along the bisector of the acute angle of warp and weft, where half as
 *   much of either makes it orthotropic: Q = (Q1(b) + Q1(-b)) / 2 with b = (90 - |g|) / 2 degrees.
 * Its constants follow |g|, and are a material's; so a ply is several, one for each class of |g|
 * that occurs.
 *
 * Unidirectional plies stay as they are. Each layer has a number and a material of its own. Without
 * shear all three have the same A and D (`solver/lamina.h`); yarns have the B of two layers above
 * each other, where the ply itself has none.
 */
#ifndef API_FORMAT_YARN_PLIES_H
#define API_FORMAT_YARN_PLIES_H

#include "stack.h"

/* All arrays are of malloc. */
struct yarn_plies {
    struct map_plies plies; /* what to show in place of the map's */
    struct lamina *lamina;  /* of each of them, Pa; e1 is 0: not known. NULL: of none */
    /* for its own functions */
    struct map_ply_row *rows;
    size_t *first;
    char **names;
    int32_t *number; /* of a ply's layers and classes, in the order of plies */
};

/* Classes of shear are as wide as half of `within` degrees, at least YARN_PLIES_FINEST: moduli
 * change by up to 2 % with a degree. The plies of `fields` know their thickness. False with the
 * problem set: API_INVALID_REQUEST (the bisector of a ply whose lamina is not known, or that has
 * more of one yarn), API_TOO_LARGE or API_OUT_OF_MEMORY; yarn_plies_free in any case. `format` is
 * the name in texts. */
bool yarn_plies_make(struct yarn_plies *layers, const struct map_fields *fields,
                     enum format_plies_as as, double within, const char *format,
                     struct api_problem *problem);
void yarn_plies_free(struct yarn_plies *layers);

/* What a map knows of a ply; half warp and half weft, and no lamina, where it knows nothing. */
struct map_ply_kind yarn_plies_kind(const struct map_plies *plies, int ply);

static const double YARN_PLIES_FINEST = 0.02; /* degrees */

#endif
