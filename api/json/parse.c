/* SPDX-License-Identifier: MIT */
/* From bytes to a tree: limits, the parser and what it may complain about. */
#include "value.h"

#include "locate.h"
#include "prescan.h"
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* jansson reports some failed allocations as errors of syntax, others not at all: so they are
 * noted here, by thread. */
static _Thread_local bool allocation_failed;
static _Thread_local size_t fail_in; /* allocations until the first failing one; 0: none fails */

static void *allocate_noted(size_t size) {
    bool refuse = fail_in == 1;
    fail_in -= fail_in > 1;
    void *memory = refuse ? NULL : malloc(size);
    allocation_failed = allocation_failed || !memory;
    return memory;
}

bool json_tree_prepare(void) {
    json_set_alloc_funcs(allocate_noted, free);
    json_object_seed(0);
    return numbers_prepare();
}

void json_tree_fail_at(size_t n) {
    fail_in = n;
}

/* Parses the text that is left without its arrays of numbers; errors are those of the caller's. */
static json_t *parse_left(const struct numbers *numbers, const char *bytes, size_t length,
                          json_error_t *error) {
    const size_t flags = JSON_REJECT_DUPLICATES | JSON_DECODE_INT_AS_REAL | JSON_DECODE_ANY;
    allocation_failed = false;
    json_t *root = json_loadb(numbers->text, numbers->length, flags, error);
    if (root || !numbers->count || allocation_failed)
        return root;
    const struct numbers_array *mark;
    size_t left = error->position > 0 ? (size_t)error->position : 0;
    size_t position = numbers_origin(numbers, left, &mark);
    if (mark && json_error_code(error) != json_error_premature_end_of_input) {
        /* It stumbled over the array itself: of that it would have read no more than the bracket.
         */
        position = mark->from + 1;
        size_t used = strlen(error->text);
        snprintf(error->text + used, JSON_ERROR_TEXT_LENGTH - 1 - used, " near '['");
    }
    /* Line and column of it, as jansson counts: characters, not bytes, read of the line. */
    error->line = 1;
    error->column = 0;
    for (size_t k = 0; k < position && k < length; k++) {
        bool newline = bytes[k] == '\n';
        error->line += newline;
        error->column = newline ? 0 : error->column + ((bytes[k] & 0xC0) != 0x80);
    }
    error->position = (int)position;
    return NULL;
}

enum api_problem_id json_tree_parse(struct json_tree *tree, const char *bytes, size_t length,
                                    const struct api_limits *limits, struct arena *arena,
                                    struct api_problem *problem) {
    *tree = (struct json_tree){.problem = problem, .arena = arena};
    if (length == 0)
        return api_problem_set(problem, API_MALFORMED_JSON,
                               "line 1, column 1: the document is empty");
    if (api_prescan(bytes, length, limits, problem) != API_OK)
        return problem->id;
    if (!numbers_take_out(bytes, length, arena, &tree->numbers))
        return api_problem_no_memory(problem, "the document");
    json_error_t error;
    tree->root = parse_left(&tree->numbers, bytes, length, &error);
    if (tree->root)
        return API_OK;
    if (allocation_failed)
        return api_problem_no_memory(problem, "the document");
    if (json_error_code(&error) == json_error_numeric_overflow) {
        /* A number like 1e999 is JSON, but not a double: out of every range. */
        char pointer[API_POINTER_MAX];
        size_t position = error.position > 0 ? (size_t)error.position : 0;
        api_locate(bytes, position < length ? position : length, pointer);
        return api_problem_add(problem, pointer, "is too large for a double-precision number");
    }
    /* jansson quotes the text it stumbled over, which may be any bytes. */
    for (char *text = error.text; *text; text++)
        if (*text < ' ' || *text > '~')
            *text = '?';
    return api_problem_set(problem, API_MALFORMED_JSON, "line %d, column %d: %s", error.line,
                           error.column, error.text);
}

void json_tree_free(struct json_tree *tree) {
    json_decref(tree->root);
    tree->root = NULL;
}

bool json_document_has(const char *bytes, size_t length, const struct api_limits *limits,
                       const char *key) {
    struct api_problem problem = {.id = API_OK};
    struct json_tree tree;
    struct arena *arena = arena_new(limits->max_memory);
    bool found = false;
    if (arena && json_tree_parse(&tree, bytes, length, limits, arena, &problem) == API_OK) {
        struct json_value root = value_root(&tree), member = value_member(&root, key);
        found = value_given(&member);
        json_tree_free(&tree);
    }
    arena_free(arena);
    return found;
}
