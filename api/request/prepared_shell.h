/* SPDX-License-Identifier: MIT */
/* The faces of a request as one surface for the solver. */
#ifndef API_REQUEST_PREPARED_SHELL_H
#define API_REQUEST_PREPARED_SHELL_H

#include "api/json/text.h"
#include "api/limits.h"
#include "api/problem.h"
#include "request.h"
#include "solver/shell/shell.h"

struct prepared_shell {
    const struct shell *shell;
    size_t count;
    const int32_t *numbers;  /* of its faces among those of the surface, rising */
    int32_t start_face;      /* the start's face by its place in the shell, of a start in u and v */
    const struct shell *all; /* all faces, where they have been needed: joined where they can be */
    bool sound;              /* as one surface */
};

/* `7 ("name")`: how a face is named to its owner. */
enum { API_FACE_TITLE_SIZE = 64 };
void prepared_shell_face_title(const struct api_surface *surface, int32_t number,
                               char title[API_FACE_TITLE_SIZE]);

/* Bytes of the spans of all faces, see PREPARED_SPANS_MAX. */
size_t prepared_shell_bytes(const struct api_surface *surface);

/*
 * Makes the shell of a decoded request whose surface is one, of the faces that it selects, in
 * `arena`, and refuses a spacing so small that covering its largest component would take more than
 * `limits->max_nodes`. Problems name faces by number and name: API_INVALID_REQUEST (faces that
 * cannot be one surface, the tolerance, the selection, a start on a face that is not selected, the
 * spacing), API_DEGENERATE_SURFACE (a face without area), API_OUT_OF_MEMORY.
 */
enum api_problem_id prepared_shell_make(const struct api_request *request,
                                        const struct api_limits *limits, struct arena *arena,
                                        struct prepared_shell *shell,
                                        struct api_problem *problem) STATUS_MUST_USE;

/* Where a drape found its start on no face of `chosen`: API_START_OFF_SURFACE for a point that lies
 * on a face which the request leaves out, and names that. Otherwise, and without memory, it leaves
 * `problem` as it is. */
void prepared_shell_name_left_out(const struct api_request *request,
                                  const struct prepared_shell *chosen, struct arena *arena,
                                  struct api_problem *problem);

/* What follows from all faces of a surface, without any request: `all`, and where that is sound the
 * shell of them. Why it is not, or why there is none, is left in `fault`, whose pointers begin at
 * the surface. Returns API_OK or API_OUT_OF_MEMORY, likewise in `fault`. */
enum api_problem_id prepared_shell_make_whole(const struct api_surface *surface,
                                              struct arena *arena, struct prepared_shell *shell,
                                              struct api_problem *fault) STATUS_MUST_USE;

/* The members of a description that a shell or a mesh has: `faces`, `edges`, `bounding_box`,
 * `area`, `notes`, ... See `prepared_part_describe`. What is wrong with the faces of an imported
 * file, `fault`, is one more of its `notes`. */
enum api_problem_id prepared_shell_describe(const struct api_surface *surface,
                                            const struct prepared_shell *whole,
                                            const struct api_problem *fault, struct api_text *text,
                                            struct arena *arena,
                                            struct api_problem *problem) STATUS_MUST_USE;

#endif
