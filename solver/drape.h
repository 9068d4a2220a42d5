/* SPDX-License-Identifier: MIT */
/*
 * libdrape: lays a woven fabric of inextensible yarns, pinned at their crossings, on a part.
 *
 * Node (i, j) of the net lies i spacings along warp and j spacings along weft from the start (0,0).
 * Two generator yarns through the start fix the whole net; every other node D follows from three
 * neighbours A, B, C by the step of `fishnet.h`. With s along warp and t along weft the exact net
 * is a Chebyshev net: |r_s| = |r_t| = 1, r_s . r_t = cos w, and the shear angle is 90 deg - w.
 * docs/mathematics.md has the model, the methods and the sources; `the paper` is its first one.
 *
 * The library does no input or output, reads no clock, keeps no state between calls, never prints,
 * never exits.
 */
#ifndef SOLVER_DRAPE_H
#define SOLVER_DRAPE_H

#include "arena.h"
#include "part.h"
#include "result.h"
#include "settings.h"
#include "status.h"
#include "version.h"

/*
 * Drapes a part. `monitor` may be NULL; scratch and result come from `arena`.
 *
 * Of a shell the component of its faces that the start lies on is draped, which is that of the
 * largest area where nothing else is asked for. The face of the start gives the side of all.
 * Generators that are curves are in the parameters of that face, and geodesics beyond it.
 *
 * Of a mesh, too, the component with the start is draped: for the method mosaic its flat triangles,
 * for gib (with yarn_path chord), basic and geodesic the smooth surface that they stand for
 * (`mesh/smooth.h`). u and v of the nodes are then (triangle, 0).
 *
 * Errors: STATUS_INVALID (a setting out of its range; on a mesh also gib4, a start by parameters
 * and generators that are curves), STATUS_START_OFF_SURFACE, STATUS_START_STUCK,
 * STATUS_DEGENERATE_SURFACE (no tangent plane at the start), STATUS_GENERATOR_OFF_START,
 * STATUS_GENERATOR_PARALLEL, STATUS_TOO_MANY_NODES, STATUS_OUT_OF_MEMORY, STATUS_CANCELLED. A drape
 * that cannot cover everything is a success whose outcome is partial.
 */
enum status drape_solve(const struct drape_part *part, const struct drape_settings *settings,
                        const struct drape_monitor *monitor, struct arena *arena,
                        struct drape_result *result) STATUS_MUST_USE;

/*
 * Whether the cuts of a drape can be laid, at a hundredth of its cost: STATUS_OK, STATUS_CUT with
 * `result->faulty_cut`, or STATUS_OUT_OF_MEMORY. What else is wrong with the settings is not told.
 */
enum status drape_check_cuts(const struct drape_part *part, const struct drape_settings *settings,
                             struct arena *arena, struct drape_result *result) STATUS_MUST_USE;

/*
 * What many drapes of a part by one method share, in `arena`, for `settings->prepared`: the smooth
 * surface of a mesh; of the component of a shell the coarse mesh by which a tube is cut open; for
 * the method mosaic the triangles of a surface, or of that component. It may be used by many
 * threads at once. Drapes of another spacing or component make their own triangles. Errors:
 * STATUS_OUT_OF_MEMORY, and as the drapes would have STATUS_TOO_MANY_NODES and
 * STATUS_DEGENERATE_SURFACE.
 */
enum status drape_prepare(const struct drape_part *part, int32_t component,
                          const struct drape_settings *settings, struct arena *arena,
                          const struct drape_prepared **prepared) STATUS_MUST_USE;

/* A walk of `relocation.h` from the pointer to that on, for a method other than mosaic and no mesh.
 */
struct relocation;
void drape_prepared_relocate(struct relocation *relocation, void *field);

/* How the part bends: a surface as `surface_bends_find` has it, of a shell the least radius of its
 * faces alone; of a mesh, which has none, the radius is infinite. */
struct surface_bends;
void drape_find_bends(const struct drape_part *part, struct surface_bends *bends);

/* The first face whose border should be a pole, but is a hole less than `least` wide
 * (`surface_has_spread_pole`), else one at the shortest piece of a shell's boundary, if that is a
 * hole as narrow; -1 when there is none. `at` gets where and `spread` how wide it is. */
int32_t drape_find_hole(const struct drape_part *part, double least, struct vec3 *at,
                        double *spread);

#endif
