/* SPDX-License-Identifier: MIT */
/*
 * libdrape: drapes woven fabric on curved surfaces, within a program.
 *
 * What goes in and comes out are the documents of the service (api/openapi.yaml): a drape request
 * as JSON, a result as columns of float64 or as a document in any format of docs/formats.md,
 * problems as RFC 9457 has them. The same request has the same bits here, from the command `drape`
 * and from the daemon; only the times in a summary differ.
 *
 * The interface keeps: what stands here keeps its meaning as long as the library's name ends in
 * .so.1. Functions are added under new symbol versions, members of documents as the service adds
 * them. No structure is seen from outside, so that none can grow.
 *
 * The library reads no files, opens no connections, prints nothing, never exits. Functions may be
 * called from any thread, those of one drape from one at a time. A text that they take ends with 0.
 * Lengths are in the request's own unit, angles in degrees, permeability in m^2.
 *
 *     struct drape *drape = drape_run(request, strlen(request), NULL, NULL, NULL);
 *     size_t count;
 *     const double *shear = drape_column(drape, "nodes.shear_deg", &count);
 *     if (!shear)
 *         fprintf(stderr, "%s\n", drape_problem(drape));
 *     drape_free(drape);
 */
#ifndef LIBDRAPE_H
#define LIBDRAPE_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/* A drape that has been run, and what the last call on it had to say. */
struct drape;

/* Called now and then while a drape is solved with its share that is done, 0..1; any other answer
 * than 0 stops it: the problem is then `cancelled`. This is how a program limits its time. */
typedef int drape_progress(void *context, double fraction);

/* The version of the solver, as in `summary.solver_version`: what the bits of results depend on. */
const char *drape_version(void);

/*
 * Runs a drape request of `length` bytes. `options` are those of the call alone, NAME=VALUE with
 * `&` between them: `max_nodes` (default 4000000), `max_memory` in bytes (4294967296), `threads`
 * (1); NULL for none. `progress` may be NULL. A surface has to be in the request: none is stored.
 * The caller frees the drape; NULL only when there is no memory even for the problem.
 */
struct drape *drape_run(const char *request, size_t length, const char *options,
                        drape_progress *progress, void *context);

/* NULL is allowed. */
void drape_free(struct drape *drape);

/*
 * What is wrong, as application/problem+json: `type` ends in the slug to tell problems apart by,
 * `errors` have the JSON pointer of each place and what would be right. Of the last call on the
 * drape that failed; NULL when the last one did not. A drape whose run failed answers every call
 * with the run's problem. Lives until the next call on the drape.
 */
const char *drape_problem(const struct drape *drape);

/* The `summary` of the result document, as JSON. Lives as long as the drape; NULL: see the problem.
 */
const char *drape_summary(struct drape *drape);

/* A column of the result, "nodes.x", "cells.shear_deg", "rim.p", ... (docs/fields.md), one value a
 * row, words as the numbers that docs/fields.md has for them; `count` may be NULL. Lives as long as
 * the drape; NULL: see the problem, which names the columns when there is none of that name. */
const double *drape_column(struct drape *drape, const char *name, size_t *count);

/*
 * The result as a document: `format` is json, csv, vtp, glb or npz, or of the flat cut pattern svg
 * or dxf; `options` as the service has them in a query, not escaped ("precision=6&table=cells",
 * "allowance=0.01"); NULL for none. Sets `*length`, which may be NULL; a 0 follows the last byte.
 * The caller gives the document back with `drape_free_document`. NULL: see the problem.
 */
char *drape_document(struct drape *drape, const char *format, const char *options, size_t *length);

/*
 * The result's fields on a mesh or at points of the caller's: `mesh` of `mesh_length` bytes in
 * `mesh_format`, json (`points` or `mesh`), nastran, abaqus, lsdyna, gmsh, unv, stl or obj.
 * `format` is json, csv, vtu, lcmsim or a solver's deck; `options` are also those of the mesh
 * (inlet, outlet, reference, edge_channel, cavity_height). The document as of `drape_document`.
 */
char *drape_map(struct drape *drape, const char *mesh, size_t mesh_length, const char *mesh_format,
                const char *format, const char *options, size_t *length);

/* NULL is allowed. */
void drape_free_document(char *document);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
