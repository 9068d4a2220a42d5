/* SPDX-License-Identifier: MIT */
#include "scan.h"

#include "number.h"
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

/* ---- what is wrong ---- */

bool scan_malformed(struct scan *scan, const char *what) {
    size_t line = 1, column = 1;
    for (const char *c = scan->begin; c < scan->at; c++) {
        column = *c == '\n' ? 1 : column + 1;
        line += *c == '\n';
    }
    return !api_problem_set(scan->problem, API_MALFORMED_JSON, "line %zu, column %zu: %s", line,
                            column, what);
}

bool scan_invalid(struct scan *scan, const char *path, long row, int element, const char *what,
                  ...) {
    char pointer[API_POINTER_MAX], detail[API_DETAIL_MAX];
    int used = snprintf(pointer, sizeof pointer, "%s", path);
    if (row >= 0)
        used += snprintf(pointer + used, sizeof pointer - (size_t)used, "/%ld", row);
    if (element >= 0)
        snprintf(pointer + used, sizeof pointer - (size_t)used, "/%d", element);
    va_list arguments;
    va_start(arguments, what);
    vsnprintf(detail, sizeof detail, what, arguments);
    va_end(arguments);
    return !api_problem_set_at(scan->problem, API_INVALID_REQUEST, pointer, "%s", detail);
}

bool scan_no_memory(struct scan *scan) {
    return !api_problem_no_memory(scan->problem, "the mesh");
}

/* ---- characters ---- */

char scan_peek(struct scan *scan) {
    while (scan->at < scan->end &&
           (*scan->at == ' ' || *scan->at == '\n' || *scan->at == '\r' || *scan->at == '\t'))
        scan->at++;
    return scan->at < scan->end ? *scan->at : '\0';
}

bool scan_take(struct scan *scan, char wanted) {
    if (scan_peek(scan) != wanted || scan->at == scan->end)
        return false;
    scan->at++;
    return true;
}

/* What is here is not the value that has to be here: another one is invalid, anything else is no
 * JSON. */
static bool scan_refuse(struct scan *scan, const char *path, long row, int element,
                        const char *what) {
    static const char *const words[] = {"true", "false", "null"};
    char c = scan_peek(scan);
    bool value = c && strchr("{[\"-0123456789", c);
    for (size_t k = 0; k < sizeof words / sizeof *words; k++) {
        size_t length = strlen(words[k]);
        value = value || ((size_t)(scan->end - scan->at) >= length &&
                          memcmp(scan->at, words[k], length) == 0);
    }
    if (value)
        return scan_invalid(scan, path, row, element, "%s", what);
    return scan_malformed(scan,
                          scan->at == scan->end ? "the document ends early" : "a value is missing");
}

bool scan_open(struct scan *scan, char bracket, const char *path, long row, const char *what) {
    return scan_take(scan, bracket) || scan_refuse(scan, path, row, -1, what);
}

bool scan_next(struct scan *scan, char closing, bool *more) {
    *more = scan_take(scan, ',');
    if (*more || scan_take(scan, closing))
        return true;
    return scan_malformed(scan, scan->at == scan->end ? "the document ends early"
                                                      : "a comma or a closing bracket is missing");
}

bool scan_key(struct scan *scan, char key[SCAN_KEY_SIZE]) {
    if (!scan_take(scan, '"'))
        return scan_malformed(scan, "a key in quotes is missing");
    size_t length = 0;
    for (; scan->at < scan->end && *scan->at != '"'; scan->at++) {
        if (*scan->at == '\\' || (unsigned char)*scan->at < ' ')
            return scan_malformed(
                scan, "a key has a backslash or a control character, which no known key has");
        if (length < SCAN_KEY_SIZE - 1)
            key[length++] = *scan->at;
    }
    key[length] = '\0';
    if (scan->at == scan->end)
        return scan_malformed(scan, "the document ends early");
    scan->at++;
    return scan_take(scan, ':') || scan_malformed(scan, "a colon is missing");
}

bool scan_take_number(struct scan *scan, double *value) {
    const char *begin = scan->at, *end = api_number_end(begin, scan->end);
    size_t length = end ? (size_t)(end - begin) : 0;
    scan->at += length;
    return end && (!value || api_number_read(begin, length, value) == length);
}

bool scan_number(struct scan *scan, const char *path, long row, int element, double *value) {
    char c = scan_peek(scan);
    const char *begin = scan->at;
    if (c != '-' && (c < '0' || c > '9'))
        return scan_refuse(scan, path, row, element, "must be a number");
    if (scan_take_number(scan, value))
        return true;
    return scan->at == begin ? scan_malformed(scan, "this is not a JSON number")
                             : scan_invalid(scan, path, row, element,
                                            "is too large for a double-precision number");
}
