/* SPDX-License-Identifier: MIT */
/* From bytes to a tree: limits, the parser and what it may complain about. */
#include "place.h"

#include "locate.h"
#include "prescan.h"
#include <jansson.h>
#include <stdlib.h>

/* jansson reports some failed allocations as errors of syntax, others not at all: so they are
 * noted here, by thread. */
static _Thread_local bool allocation_failed;
static _Thread_local size_t fail_in; /* allocations until the first failing one; 0: none fails */

static void *allocate(size_t size) {
    bool refuse = fail_in == 1;
    fail_in -= fail_in > 1;
    void *memory = refuse ? NULL : malloc(size);
    allocation_failed = allocation_failed || !memory;
    return memory;
}

void tree_prepare(void) {
    json_set_alloc_funcs(allocate, free);
    json_object_seed(0);
}

void tree_fail_at(size_t n) {
    fail_in = n;
}

/* jansson quotes the text it stumbled over, which may be any bytes. */
static void make_printable(char *text) {
    for (; *text; text++)
        if (*text < ' ' || *text > '~')
            *text = '?';
}

static void set_parse_problem(struct api_problem *problem, const char *bytes, size_t length,
                              json_error_t *error) {
    if (allocation_failed) {
        api_problem_set(problem, API_OUT_OF_MEMORY, "no memory to parse the document");
    } else if (json_error_code(error) == json_error_numeric_overflow) {
        /* A number like 1e999 is JSON, but not a double: out of every range. */
        char pointer[API_POINTER_MAX];
        size_t position = error->position > 0 ? (size_t)error->position : 0;
        api_locate(bytes, position < length ? position : length, pointer);
        api_problem_add(problem, pointer, "is too large for a double-precision number");
    } else {
        make_printable(error->text);
        api_problem_set(problem, API_MALFORMED_JSON, "line %d, column %d: %s", error->line,
                        error->column, error->text);
    }
}

enum api_problem_id tree_parse(struct tree *tree, const char *bytes, size_t length,
                               const struct api_limits *limits, struct arena *arena,
                               struct api_problem *problem) {
    const size_t flags = JSON_REJECT_DUPLICATES | JSON_DECODE_INT_AS_REAL | JSON_DECODE_ANY;
    *tree = (struct tree){.problem = problem, .arena = arena};
    if (length == 0) {
        api_problem_set(problem, API_MALFORMED_JSON, "line 1, column 1: the document is empty");
        return problem->id;
    }
    if (api_prescan(bytes, length, limits, problem) != API_OK)
        return problem->id;
    json_error_t error;
    allocation_failed = false;
    tree->root = json_loadb(bytes, length, flags, &error);
    if (tree->root)
        return API_OK;
    set_parse_problem(problem, bytes, length, &error);
    return problem->id;
}

void tree_free(struct tree *tree) {
    json_decref(tree->root);
    tree->root = NULL;
}
