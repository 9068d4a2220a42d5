/* SPDX-License-Identifier: MIT */
/*
 * What is wrong with a caller's document, and what it is: all that can be known before anything is
 * solved. Functions from bytes to bytes, as `run.h`, for the same reason: the daemon calls them in
 * a process of its own, tests and fuzzers directly.
 */
#ifndef API_CHECK_H
#define API_CHECK_H

#include "api/request/material.h"
#include "api/request/normalise.h"
#include "api/request/prepared_part.h"
#include "input.h"
#include "limits.h"
#include "problem.h"
#include "sink.h"
#include "solver/status.h"

/* What a document turned out to be. */
struct api_check {
    char digest[API_ID_SIZE];  /* of a drape request: `api_digest_request` */
    char surface[API_ID_SIZE]; /* the stored surface that a request names, or the posted one's id;
                                  "": the request has its own */
    bool needs_surface;        /* the request names one, and it was not among the input */
    char text[API_ID_SIZE];    /* of a request: `api_digest_bytes` of its text */
    char ground[API_ID_SIZE];  /* of a request that names a stored surface: `api_digest_ground` */
    size_t form_length;        /* bytes of the prepared form that were written; 0: there is none */
    bool form_renewed;         /* which is of a stored surface, and that had no sound one */
    bool needs_materials;      /* the names of some were written, a line each: they come first */
    size_t filled_length;      /* the first bytes written are the request with its materials in
                                  it; 0: it is as it came */
    size_t definition_length;  /* of a surface or material: the first bytes written are its
                                  definition */
    size_t variants;           /* of a study: how many it looks at, at the most */
    char material[API_MATERIAL_NAME_SIZE]; /* the name of a posted one */
};

/* A drape request, with the stored surface that it names once that is known, by its definition or
 * its prepared form: without it `needs_surface` is set and no more is checked. Whether a surface of
 * very many spans has an area, and whether the spacing is too small for it, is found by the solver
 * alone. To `forms`, unless it is NULL, a prepared form is written of what was made here and may be
 * needed again: of the stored surface, or of the request. Returns API_OK or the id set in
 * `problem`. */
enum api_problem_id api_check_drape(const struct api_input *input, const struct api_limits *limits,
                                    const struct api_sink *forms, struct api_check *check,
                                    struct api_problem *problem) STATUS_MUST_USE;

/* Whether the solver could take the surface and the spacing of a decoded request. Of a surface with
 * very many spans that is left for the solver to say. */
enum api_problem_id api_check_decoded(struct api_request *request, const struct api_limits *limits,
                                      struct arena *arena,
                                      struct api_problem *problem) STATUS_MUST_USE;

/* Steps of it, for documents that have a drape in them. Sets what `check` says of the text and of
 * the surface that is named. */
enum api_problem_id api_check_names(const struct api_input *input,
                                    const struct api_request *request, struct arena *arena,
                                    struct api_check *check,
                                    struct api_problem *problem) STATUS_MUST_USE;

/* Before the part is made: makes the form of a stored surface that came without a sound one, and
 * says whether a form is to be written then. */
bool api_check_expects_form(struct api_request *request, struct arena *arena);

/* Writes it. */
void api_check_write_form(const struct api_request *request, const struct prepared_part *part,
                          struct arena *arena, const struct api_sink *forms,
                          struct api_check *check);

/* A surface to be stored, as `input->request`. Writes its normalised definition and then its
 * description (a JSON object each, not terminated); to `forms`, unless it is NULL, its prepared
 * form. */
enum api_problem_id api_check_surface(const struct api_input *input,
                                      const struct api_limits *limits, const struct api_sink *sink,
                                      const struct api_sink *forms, struct api_check *check,
                                      struct api_problem *problem) STATUS_MUST_USE;

/* A material to be kept, likewise: its document and what lists show of it. */
enum api_problem_id api_check_material(const struct api_input *input,
                                       const struct api_limits *limits, const struct api_sink *sink,
                                       struct api_check *check,
                                       struct api_problem *problem) STATUS_MUST_USE;

/* Puts the materials into the request that it names (`request/material.h`); the new text lies in
 * the arena. `own` has the caller's that were asked for; NULL: none were yet, and when some are
 * needed their names are written instead. API_OK or API_OUT_OF_MEMORY; `check` is to be cleared. */
enum api_problem_id api_check_mentions(struct api_input *input, const char *own, size_t own_length,
                                       const struct api_sink *sink, struct arena *arena,
                                       struct api_check *check,
                                       struct api_problem *problem) STATUS_MUST_USE;

/* Writes a stored surface, `input->request`, as binary glTF: `request/preview.h`. */
enum api_problem_id api_check_preview(const struct api_input *input,
                                      const struct api_limits *limits, const struct api_sink *sink,
                                      struct api_problem *problem) STATUS_MUST_USE;

/* Writes the request as it was understood, with what the solve chose for a start when `start` is
 * not NULL. */
enum api_problem_id api_check_normalise(const struct api_input *input,
                                        const struct api_limits *limits,
                                        const struct api_start *start, const struct api_sink *sink,
                                        struct api_problem *problem) STATUS_MUST_USE;

#endif
