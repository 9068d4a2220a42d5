/* SPDX-License-Identifier: MIT */
#include "prescan.h"

#include "walk.h"

/* What a member of an object counts, in values: a key and its place in a hash table take that much
 * more memory and time than an element of an array, and no honest document has many. */
enum { MEMBER_COST = 8 };

/* Every value but the first comes right after a comma or an opening bracket, so counting those
 * never counts too few. */
enum api_problem_id api_prescan(const char *bytes, size_t length, const struct api_limits *limits,
                                struct api_problem *problem) {
    size_t elements = 1;
    int depth = 0;
    for (size_t i = 0; i < length; i++) {
        switch (bytes[i]) {
        case '"':
            i = (size_t)(walk_string_end(bytes + i + 1, bytes + length) - bytes);
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
        if (depth > limits->max_depth)
            return api_problem_set(problem, API_TOO_LARGE,
                                   "the document nests deeper than the limit of %d levels",
                                   limits->max_depth);
        if (elements > limits->max_elements)
            return api_problem_set(problem, API_TOO_LARGE,
                                   "the document has more values than the limit of %zu, a member "
                                   "of an object counting as %d",
                                   limits->max_elements, MEMBER_COST);
    }
    return API_OK;
}
