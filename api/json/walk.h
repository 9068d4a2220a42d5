/* SPDX-License-Identifier: MIT */
/*
 * A walk through the text of a JSON document from string to string, which knows the arrays and
 * objects that it is in. No tree is made and nothing is checked: of text that is no JSON the walk
 * ends at its end all the same.
 */
#ifndef API_JSON_WALK_H
#define API_JSON_WALK_H

#include <stdbool.h>
#include <stddef.h>

/* Bytes of the text. */
struct walk_span {
    const char *from, *to;
};

/* An open array or object, and the member of it that was reached. */
struct walk_level {
    bool object, in_value; /* of an object: behind the colon */
    size_t index;          /* of an array */
    struct walk_span key;  /* of an object, as spelled, without its quotes; NULL: none yet */
};

enum { WALK_LEVELS_MAX = 64 };

struct walk {
    const char *at, *end; /* of the text */
    size_t depth;         /* may exceed WALK_LEVELS_MAX: of levels beyond nothing is known */
    struct walk_level level[WALK_LEVELS_MAX];
};

/* Goes behind the next string, a key or a value; one that is not closed goes to the end. False, and
 * at the end of the text, when there is none. */
bool walk_next_string(struct walk *walk, struct walk_span *string);

/* The level that is `up` levels out of the innermost (0); NULL when there is none or it is not
 * known. */
const struct walk_level *walk_level(const struct walk *walk, size_t up);

bool walk_span_is(struct walk_span span, const char *text);

/* The quote that ends the string whose first byte is at `at`, or `end`. */
const char *walk_string_end(const char *at, const char *end);

#endif
