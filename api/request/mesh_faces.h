/* SPDX-License-Identifier: MIT */
/* A stored mesh as a part with faces: those that hang together over edges that fold by less than
 * MESH_FOLD_DEG, as the drape of a mesh has its folds. */
#ifndef API_REQUEST_MESH_FACES_H
#define API_REQUEST_MESH_FACES_H

#include "api/json/text.h"
#include "api/problem.h"
#include "request.h"
#include "solver/mesh/mesh.h"

enum {
    MESH_FACES_MAX = 2000,   /* a mesh of more is rough all over: it is one face */
    MESH_OPENINGS_SHOWN = 20 /* in a description */
};

/* The face of each triangle, in `arena`; NULL without memory. */
const int32_t *mesh_face_numbers(const struct mesh *mesh, struct arena *arena, size_t *count);

/* Replaces `mesh` by the part of it that is selected, in `arena`. Problems: API_INVALID_REQUEST at
 * a face or an element that is not there, or a point far from the mesh; API_OUT_OF_MEMORY. */
enum api_problem_id mesh_faces_choose(const struct api_selection *selection, struct arena *arena,
                                      struct mesh **mesh,
                                      struct api_problem *problem) STATUS_MUST_USE;

/* Members of a description: `faces`, `joints` ([face, face, the least fold between them]) and
 * `openings` ([{"edges", "length", "centre"}], the longest first, MESH_OPENINGS_SHOWN at most),
 * `opening_count`. False without memory. */
bool mesh_faces_describe(const struct mesh *mesh, struct arena *arena, struct api_text *text);

#endif
