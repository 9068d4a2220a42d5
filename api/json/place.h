/* SPDX-License-Identifier: MIT */
/*
 * A parsed JSON document, read by people who want to know where they are. A `tree_place` is a value
 * together with the way that leads to it, so that whatever is wrong with it can be reported under
 * its JSON pointer (RFC 6901); it lives on the stack of the function that looks at it, and points
 * to its parent's. A place may be missing: then reading it reports that it is required.
 *
 * Every read function checks type and range, reports what is wrong to the document's problem and
 * returns false; so a decoder goes on after an error and finds the independent ones too.
 * `place.c` and `parse.c` are the only files that include jansson.h.
 */
#ifndef API_JSON_PLACE_H
#define API_JSON_PLACE_H

#include "api/limits.h"
#include "api/problem.h"
#include "numbers.h"
#include "solver/arena.h"
#include "solver/status.h"
#include <stdbool.h>
#include <stddef.h>

struct json_t;

/* One document and where its errors and arrays go. */
struct tree {
    struct json_t *root;
    struct numbers numbers; /* the arrays that are not in the tree of the parser */
    struct api_problem *problem;
    struct arena *arena;
};

/* An array of `rows` numbers (`width` 0) or of `rows` arrays of `width` numbers, or with no rows
 * one number; without values none of these. */
struct tree_packed {
    const double *values;
    size_t rows, width;
};

struct tree_place {
    const struct tree *tree;
    const struct tree_place *parent; /* NULL at the root */
    const char *key;                 /* of an object's member; NULL: element `index` */
    size_t index;
    const struct json_t *value; /* NULL: missing, unless it is packed */
    struct tree_packed packed;
};

enum tree_type {
    TREE_MISSING,
    TREE_OBJECT,
    TREE_ARRAY,
    TREE_STRING,
    TREE_NUMBER,
    TREE_BOOLEAN,
    TREE_NULL
};

/* The numbers that are allowed: low..high, or with `open` those strictly between. */
struct tree_range {
    double low, high;
    bool open;
};

/* Sets up the parser for this process; see `api_prepare`. */
bool tree_prepare(void) STATUS_MUST_USE;

/* For tests: the n-th allocation of the parser in this thread from now on (1 is the next) and all
 * after it fail; 0 never. */
void tree_fail_at(size_t n);

/* Parses `bytes` within the limits. On API_OK the caller frees the tree with `tree_free`; else
 * `problem` is API_TOO_LARGE, API_MALFORMED_JSON (with line and column), API_INVALID_REQUEST (a
 * number beyond the doubles, with its pointer) or API_OUT_OF_MEMORY. */
enum api_problem_id tree_parse(struct tree *tree, const char *bytes, size_t length,
                               const struct api_limits *limits, struct arena *arena,
                               struct api_problem *problem) STATUS_MUST_USE;
void tree_free(struct tree *tree);

struct tree_place tree_root(const struct tree *tree);

/* A member of an object, or an element of an array; missing when there is none, also when `parent`
 * is of another type. */
struct tree_place tree_member(const struct tree_place *parent, const char *key);
struct tree_place tree_element(const struct tree_place *parent, size_t index);

enum tree_type tree_type(const struct tree_place *place);
static inline bool tree_given(const struct tree_place *place) {
    return place->value || place->packed.values;
}

/* Elements of an array or members of an object; else 0. */
size_t tree_length(const struct tree_place *place);

/* Reports that something is wrong at `place`. */
void tree_fault(const struct tree_place *place, const char *detail, ...)
    __attribute__((format(printf, 2, 3)));

/* The place is an object; each member whose key is not in the NULL-terminated `keys` is reported,
 * and does not make the answer false. */
bool tree_object(const struct tree_place *place, const char *const keys[]);

/* The place is an array of `least` elements or more. */
bool tree_array(const struct tree_place *place, size_t least);

/* The value of a string, in the tree. */
bool tree_string(const struct tree_place *place, const char **value);

/* The index in `names` (`count` of them) of the string there. */
bool tree_choice(const struct tree_place *place, const char *const names[], size_t count,
                 int *value);

bool tree_number(const struct tree_place *place, struct tree_range range, double *value);
bool tree_integer(const struct tree_place *place, int low, int high, int *value);

/* true and false, or 1 and 0 as geomdl writes them. */
bool tree_boolean(const struct tree_place *place, bool *value);

/* Exactly `count` numbers, in an array. */
bool tree_vector(const struct tree_place *place, struct tree_range range, size_t count,
                 double *values);

/* An array of at least `least` numbers, copied into the arena. Only the first bad one is
 * reported. */
bool tree_numbers(const struct tree_place *place, struct tree_range range, size_t least,
                  const double **values, size_t *count);

/* An array of at least `least` arrays of `width` numbers each, copied into the arena row by row.
 * Only the first bad row is reported. */
bool tree_rows(const struct tree_place *place, struct tree_range range, size_t width, size_t least,
               double **values, size_t *count);

/* `count` elements in the arena; NULL with the problem set to API_OUT_OF_MEMORY. */
void *tree_alloc(const struct tree *tree, size_t count, size_t size);

#endif
