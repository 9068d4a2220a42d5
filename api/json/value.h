/* SPDX-License-Identifier: MIT */
/*
 * A parsed JSON document whose values know where they are. A `json_value` is a value
 * together with the way that leads to it, so that whatever is wrong with it can be reported under
 * its JSON pointer (RFC 6901); it lives on the stack of the function that looks at it, and points
 * to its parent's. A value may be missing: then reading it reports that it is required.
 *
 * Every read function checks type and range, reports what is wrong to the document's problem and
 * returns false; so a decoder goes on after an error and finds the independent ones too.
 * `value.c` and `parse.c` are the only files that include jansson.h.
 */
#ifndef API_JSON_VALUE_H
#define API_JSON_VALUE_H

#include "api/limits.h"
#include "api/problem.h"
#include "numbers.h"
#include "solver/arena.h"
#include "solver/status.h"
#include <stdbool.h>
#include <stddef.h>

struct json_t;

/* One document and where its errors and arrays go. */
struct json_tree {
    struct json_t *root;
    struct numbers numbers; /* the arrays that are not in the tree of the parser */
    struct api_problem *problem;
    struct arena *arena;
};

/* An array of `rows` numbers (`width` 0) or of `rows` arrays of `width` numbers, or with no rows
 * one number; without values none of these. */
struct value_packed {
    const double *values;
    size_t rows, width;
};

struct json_value {
    const struct json_tree *tree;
    const struct json_value *parent; /* NULL at the root */
    const char *key;                 /* of an object's member; NULL: element `index` */
    size_t index;
    const struct json_t *value; /* NULL: missing, unless it is packed */
    struct value_packed packed;
};

enum value_type {
    VALUE_MISSING,
    VALUE_OBJECT,
    VALUE_ARRAY,
    VALUE_STRING,
    VALUE_NUMBER,
    VALUE_BOOLEAN,
    VALUE_NULL
};

/* The numbers that are allowed: low..high, or with `open` those strictly between. */
struct value_range {
    double low, high;
    bool open;
};

/* Sets up the parser for this process; see `api_prepare`. */
bool json_tree_prepare(void) STATUS_MUST_USE;

/* For tests: the n-th allocation of the parser in this thread from now on (1 is the next) and all
 * after it fail; 0 never. */
void json_tree_fail_at(size_t n);

/* Parses `bytes` within the limits. On API_OK the caller frees the tree with `json_tree_free`; else
 * `problem` is API_TOO_LARGE, API_MALFORMED_JSON (with line and column), API_INVALID_REQUEST (a
 * number beyond the doubles, with its pointer) or API_OUT_OF_MEMORY. */
enum api_problem_id json_tree_parse(struct json_tree *tree, const char *bytes, size_t length,
                                    const struct api_limits *limits, struct arena *arena,
                                    struct api_problem *problem) STATUS_MUST_USE;
void json_tree_free(struct json_tree *tree);

/* Whether a document is a JSON object within the limits that has a member `key`: a study has
 * "drape", a laminate "plies". */
bool json_document_has(const char *bytes, size_t length, const struct api_limits *limits,
                       const char *key);

struct json_value value_root(const struct json_tree *tree);

/* A member of an object, or an element of an array; missing when there is none, also when `parent`
 * is of another type. */
struct json_value value_member(const struct json_value *parent, const char *key);
struct json_value value_element(const struct json_value *parent, size_t index);

enum value_type value_type(const struct json_value *json);
static inline bool value_given(const struct json_value *json) {
    return json->value || json->packed.values;
}

/* Elements of an array or members of an object; else 0. */
size_t value_length(const struct json_value *json);

/* Reports that something is wrong at `json`; false, for functions that answer so. */
bool value_fault(const struct json_value *json, const char *detail, ...)
    __attribute__((format(printf, 2, 3)));

/* The value is an object; each member whose key is not in the NULL-terminated `keys` is reported,
 * and does not make the answer false. */
bool value_object(const struct json_value *json, const char *const keys[]);

/* The value is an array of `least` elements or more. */
bool value_array(const struct json_value *json, size_t least);

/* The value of a string, in the tree. */
bool value_string(const struct json_value *json, const char **value);

/* The index in `names` (`count` of them) of the string there. */
bool value_choice(const struct json_value *json, const char *const names[], size_t count,
                  int *value);

bool value_number(const struct json_value *json, struct value_range range, double *value);
bool value_integer(const struct json_value *json, int low, int high, int *value);

/* true and false, or 1 and 0 as geomdl writes them. */
bool value_boolean(const struct json_value *json, bool *value);

/* Exactly `count` numbers, in an array. */
bool value_vector(const struct json_value *json, struct value_range range, size_t count,
                  double *values);

/* An array of at least `least` numbers, copied into the arena. Only the first bad one is
 * reported. */
bool value_numbers(const struct json_value *json, struct value_range range, size_t least,
                   const double **values, size_t *count);

/* An array of at least `least` arrays of `width` numbers each, copied into the arena row by row.
 * Only the first bad row is reported. */
bool value_rows(const struct json_value *json, struct value_range range, size_t width, size_t least,
                double **values, size_t *count);

/* `count` elements in the arena; NULL with the problem set to API_OUT_OF_MEMORY. */
void *json_tree_alloc(const struct json_tree *tree, size_t count, size_t size);

#endif
