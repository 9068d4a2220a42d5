/* SPDX-License-Identifier: MIT */
/*
 * Fabrics with their figures: a JSON document each, with lengths in m, `areal_weight` in kg/m^2,
 * `fabric`, `permeability` and `compaction` as in a request. Those of the library, api/materials,
 * are in the program, each with where its figures come from; others are a caller's own. A request
 * has one as `fabric.material`, by name or whole; what it says beside that wins.
 */
#ifndef API_REQUEST_MATERIAL_H
#define API_REQUEST_MATERIAL_H

#include "api/limits.h"
#include "api/problem.h"
#include "solver/arena.h"
#include "solver/status.h"
#include <stdbool.h>
#include <stddef.h>

enum { API_MATERIAL_NAME_SIZE = 65 };

struct api_material {
    const char *name, *about; /* NULL: none */
    const char *json;         /* in one line; of one with a name that comes first */
    size_t length;
};

/* The library, by name; NULL after the last. */
const struct api_material *api_material_at(size_t index);

/* NULL when the library has none. */
const struct api_material *api_material_named(const char *name);

/* All of the library without their figures, each in an array's element:
 * {"name", "about", "source", "example", "own"}. No brackets are about them. */
const char *api_materials_heads(void);

/*
 * Decodes a document to be kept: it has a name, which is none of the library's, and figures that go
 * together. `*head` is what a list shows of it. All lies in the arena. API_OK, API_MALFORMED_JSON,
 * API_TOO_LARGE, API_INVALID_REQUEST or API_OUT_OF_MEMORY.
 */
enum api_problem_id api_material_decode(const char *bytes, size_t length,
                                        const struct api_limits *limits, struct arena *arena,
                                        struct api_material *material, const char **head,
                                        struct api_problem *problem) STATUS_MUST_USE;

/*
 * Names in the text of a request, of a study or of a laminate. They are put there as what they
 * stand for when a request is accepted, so that nothing that becomes of a material later changes a
 * result.
 */

/* Whether there may be any: without reading the text. */
bool api_material_mentioned(const char *request, size_t length);

/* The names that the library does not have, each once and in a line of its own; "" when there are
 * none, NULL without memory. Of text that is no JSON any. */
const char *api_material_wanted(const char *request, size_t length, struct arena *arena);

/* The request with the document of each material in the place of its name. `own` has those that are
 * not of the library, as written by `api_material_decode`, a line each. A name that neither has
 * stays. NULL without memory. */
const char *api_material_fill(const char *request, size_t length, const char *own,
                              size_t own_length, struct arena *arena, size_t *filled);

#endif
