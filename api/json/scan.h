/* SPDX-License-Identifier: MIT */
/*
 * JSON read as it comes, for large arrays of numbers: no tree is made of them. The reader of a
 * mesh (`api/map/json.c`) reads a whole document so, that of arrays in other documents
 * (`numbers.h`) no more than these. Only the first error is reported; every function that returns
 * bool then returns false, with the problem set.
 */
#ifndef API_JSON_SCAN_H
#define API_JSON_SCAN_H

#include "api/problem.h"
#include "solver/arena.h"
#include "solver/status.h"
#include <stdbool.h>

enum { SCAN_KEY_SIZE = 32 };

struct scan {
    const char *begin, *at, *end; /* the text, and what comes next */
    struct arena *arena;          /* of the reader's arrays */
    struct api_problem *problem;
};

/* What is wrong; all return false. API_MALFORMED_JSON with line and column of what comes next. */
bool scan_malformed(struct scan *scan, const char *what);
/* API_INVALID_REQUEST at an element of a row of the array `path`, or at the row, or at the array:
 * -1 for what is not meant. */
bool scan_invalid(struct scan *scan, const char *path, long row, int element, const char *what, ...)
    __attribute__((format(printf, 5, 6)));
/* API_OUT_OF_MEMORY. */
bool scan_no_memory(struct scan *scan);

/* The next character that is no space; 0 at the end. */
char scan_peek(struct scan *scan);

/* Whether that is the wanted one, which is then behind. No problem is set. */
bool scan_take(struct scan *scan, char wanted) STATUS_MUST_USE;

/* The bracket that opens the value at `path` (and `row`); `what` it must be, when another value is
 * there. */
bool scan_open(struct scan *scan, char bracket, const char *path, long row,
               const char *what) STATUS_MUST_USE;

/* After an element of an array or object: whether there is another one, or it was closed. */
bool scan_next(struct scan *scan, char closing, bool *more) STATUS_MUST_USE;

/* A key and its colon. One with escapes is refused; one longer than any that is known is cut, and
 * so unknown. */
bool scan_key(struct scan *scan, char key[SCAN_KEY_SIZE]) STATUS_MUST_USE;

/* A number of JSON that is right here, read into `value` unless that is NULL. No problem is set.
 * One beyond the doubles is passed and false; else `at` stays where there is none. */
bool scan_take_number(struct scan *scan, double *value) STATUS_MUST_USE;

/* A number, as JSON writes it. */
bool scan_number(struct scan *scan, const char *path, long row, int element,
                 double *value) STATUS_MUST_USE;

#endif
