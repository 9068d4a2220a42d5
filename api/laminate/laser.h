/* SPDX-License-Identifier: MIT */
/*
 * The lines that show where every layer of a laminate is laid: the edges of its pattern and a line
 * along its warp, on the tool raised by what lies below,
 *
 *     r = foot + h n,    h = sum over the plies below that lie there of n t / cos(shear),
 *
 * each as thick as it is by itself, n its layers. Of a sheared or slid fabric 1 / cos(shear) is
 * `permeability_areal_ratio`. A place of the cloth is bilinear in its cell, which leaves it off the
 * tool; its foot is the nearest place of the part, exactly on it. What lies below an edge is looked
 * at a little inside it, because plies of one shape end at one line.
 */
#ifndef API_LAMINATE_LASER_H
#define API_LAMINATE_LASER_H

#include "api/format/laser_sheet.h"
#include "api/result/columns.h"
#include "flat_plies.h"

/* By default lines are within so many metres of curves. */
#define LASER_TOLERANCE 1e-4

/*
 * Of a laminate that is resolved and the shapes of all its plies; `tolerance` is in its unit.
 * Plies that have no net do not count: those above lie lower. The sheet lies in the arena. API_OK,
 * API_INVALID_REQUEST (a thickness is not known), API_INTERNAL, API_OUT_OF_MEMORY.
 */
enum api_problem_id laser_make(const struct laminate *laminate,
                               const struct api_reader *const *nets,
                               const struct flat_plies *shapes, double tolerance,
                               struct arena *arena, struct laser_sheet *sheet,
                               struct api_problem *problem) STATUS_MUST_USE;

/* Of every ply, or piece, of a laminate its edge on the part itself, at the default tolerance; in
 * the arena. Errors as above. */
struct map_outline;
enum api_problem_id laser_outlines(const struct laminate *laminate,
                                   const struct api_reader *const *nets, struct arena *arena,
                                   const struct map_outline **outlines,
                                   struct api_problem *problem) STATUS_MUST_USE;

#endif
