/* SPDX-License-Identifier: MIT */
#include "prescan.h"

/* What a member of an object counts, in values: a key and its place in a hash table take that much
 * more memory and time than an element of an array, and no honest document has many. */
enum { MEMBER_COST = 8 };

/* The index of the quote that ends the string opened at `start`, or `length`. */
static size_t string_end(const char *bytes, size_t start, size_t length) {
    size_t i = start + 1;
    while (i < length && bytes[i] != '"')
        i += bytes[i] == '\\' ? 2 : 1;
    return i;
}

/* Every value but the first comes right after a comma or an opening bracket, so counting those
 * never counts too few. */
enum api_problem_id api_prescan(const char *bytes, size_t length, const struct api_limits *limits,
                                struct api_problem *problem) {
    size_t elements = 1;
    int depth = 0;
    for (size_t i = 0; i < length; i++) {
        switch (bytes[i]) {
        case '"':
            i = string_end(bytes, i, length);
            break;
        case '[':
        case '{':
            elements++;
            depth++;
            break;
        case ']':
        case '}':
            depth -= depth > 0;
            break;
        case ',':
            elements++;
            break;
        case ':':
            elements += MEMBER_COST - 1;
            break;
        }
        if (depth > limits->max_depth) {
            api_problem_set(problem, API_TOO_LARGE,
                            "the document nests deeper than the limit of %d levels",
                            limits->max_depth);
            return problem->id;
        }
        if (elements > limits->max_elements) {
            api_problem_set(problem, API_TOO_LARGE,
                            "the document has more values than the limit of %zu, a member of an "
                            "object counting as %d",
                            limits->max_elements, MEMBER_COST);
            return problem->id;
        }
    }
    return API_OK;
}
