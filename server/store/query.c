/* SPDX-License-Identifier: MIT */
#include "query.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ------------------------------------------------------------------ parameters */

struct query_value of_int(int64_t value) {
    return (struct query_value){.kind = QUERY_INT, .integer = value};
}

struct query_value of_no_int(void) {
    return (struct query_value){.kind = QUERY_INT, .null = true};
}

struct query_value of_real(double value) {
    return (struct query_value){.kind = QUERY_REAL, .real = value};
}

struct query_value of_text(const char *text) {
    return (struct query_value){QUERY_TEXT, !text, .bytes = text,
                                .length = text ? strlen(text) : 0};
}

struct query_value of_bytes(const void *bytes, size_t length) {
    return (struct query_value){.kind = QUERY_BYTES, .bytes = bytes ? bytes : "", .length = length};
}

void query_bind_values(struct query *query, const struct query_value *values, size_t count) {
    memcpy(query->values + query->bound, values, count * sizeof *values);
    query->bound += (int)count;
}

/* ------------------------------------------------------------------ rows */

bool query_row(struct query *query) {
    return !query->no_memory && query->driver->row(query);
}

bool query_is_null(const struct query *query, int column) {
    return query->driver->column(query, column).null;
}

int64_t query_int(const struct query *query, int column) {
    return query->driver->column(query, column).integer;
}

double query_real(const struct query *query, int column) {
    return query->driver->column(query, column).real;
}

const char *query_text(const struct query *query, int column) {
    return query->driver->column(query, column).bytes;
}

const void *query_bytes(const struct query *query, int column, size_t *length) {
    struct query_value value = query->driver->column(query, column);
    *length = value.length;
    return value.bytes;
}

void query_copy(const struct query *query, int column, char *to, size_t size) {
    const char *text = query_text(query, column);
    snprintf(to, size, "%s", text ? text : "");
}

void query_duplicate(struct query *query, int column, char **to, size_t *length) {
    struct query_value value = query->driver->column(query, column);
    *to = value.null ? NULL : malloc(value.length + 1);
    query->no_memory = query->no_memory || (!value.null && !*to);
    if (!*to)
        return;
    if (value.length > 0)
        memcpy(*to, value.bytes, value.length);
    (*to)[value.length] = '\0';
    if (length)
        *length = value.length;
}

/* ------------------------------------------------------------------ ends */

enum store_answer query_end(struct query *query) {
    enum store_answer answer = query->driver->end(query);
    if (query->give_back)
        query->give_back(query);
    return answer == STORE_OK && query->no_memory ? STORE_DOWN : answer;
}

enum store_answer query_end_found(struct query *query, bool found, enum store_answer none) {
    enum store_answer answer = query_end(query);
    return answer == STORE_OK && !found ? none : answer;
}

enum store_answer query_number(struct query *query, enum store_answer none, int64_t *number) {
    bool found = query_row(query);
    *number = found ? query_int(query, 0) : 0;
    return query_end_found(query, found, none);
}

enum store_answer query_run(struct query *query) {
    query_row(query);
    return query_end(query);
}

enum store_answer query_find(struct query *query, enum store_answer none) {
    return query_end_found(query, query_row(query), none);
}
