/* SPDX-License-Identifier: MIT */
#include "numbers.h"
#include "number.h"
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>

enum { SECRET_LENGTH = 16, MARK_ROOM = 64 };

/* A mark is the string U+0001, these digits, a colon and the array's number. */
static char secret[SECRET_LENGTH + 1];

bool numbers_prepare(void) {
    uint64_t random;
    if (getrandom(&random, sizeof random, 0) != (ssize_t)sizeof random)
        return false;
    snprintf(secret, sizeof secret, "%016llx", (unsigned long long)random);
    return true;
}

/* ------------------------------------------------------------------ reading */

struct reader {
    const char *at, *end;
};

static void skip_blanks(struct reader *reader) {
    while (reader->at < reader->end && *reader->at && strchr(" \t\r\n", *reader->at))
        reader->at++;
}

static bool take(struct reader *reader, char wanted) {
    skip_blanks(reader);
    bool there = reader->at < reader->end && *reader->at == wanted;
    reader->at += there;
    return there;
}

static size_t digits(struct reader *reader) {
    const char *begin = reader->at;
    while (reader->at < reader->end && *reader->at >= '0' && *reader->at <= '9')
        reader->at++;
    return (size_t)(reader->at - begin);
}

static bool skip(struct reader *reader, const char *any) {
    bool there = reader->at < reader->end && *reader->at && strchr(any, *reader->at);
    reader->at += there;
    return there;
}

/* -? (0 | [1-9][0-9]*) (. [0-9]+)? ([eE] [+-]? [0-9]+)? */
static bool take_number(struct reader *reader, double *value) {
    const char *begin = reader->at;
    skip(reader, "-");
    const char *whole = reader->at;
    size_t count = digits(reader);
    if (count == 0 || (count > 1 && *whole == '0') || (skip(reader, ".") && !digits(reader)))
        return false;
    if (skip(reader, "eE")) {
        skip(reader, "+-");
        if (!digits(reader))
            return false;
    }
    size_t length = (size_t)(reader->at - begin);
    return !value || api_number_read(begin, length, value) == length;
}

/* A flat array: how many numbers; 0 when it is none. `values` may be NULL: they are counted. */
static size_t take_flat(struct reader *reader, double *values) {
    size_t count = 0;
    if (!take(reader, '['))
        return 0;
    do {
        skip_blanks(reader);
        if (!take_number(reader, values ? values + count : NULL))
            return 0;
        count++;
    } while (take(reader, ','));
    return take(reader, ']') ? count : 0;
}

/* An array of flat arrays of the same length. */
static size_t take_rows(struct reader *reader, size_t *width, double *values) {
    size_t rows = 0;
    if (!take(reader, '['))
        return 0;
    do {
        size_t count = take_flat(reader, values ? values + rows * *width : NULL);
        if (!count || (rows > 0 && count != *width))
            return 0;
        *width = count;
        rows++;
    } while (take(reader, ','));
    return take(reader, ']') ? rows : 0;
}

/* The array at `begin`, in its shape, its values not yet read. False when it is none of numbers, or
 * too short. */
static bool measure(const char *begin, const char *end, struct numbers_array *array,
                    const char **behind) {
    struct reader reader = {begin, end};
    array->width = 0;
    array->rows = take_flat(&reader, NULL);
    if (!array->rows) {
        reader.at = begin;
        array->rows = take_rows(&reader, &array->width, NULL);
    }
    *behind = reader.at;
    return array->rows * (array->width ? array->width : 1) >= NUMBERS_LEAST;
}

/* ------------------------------------------------------------------ taking out */

/* What is written, and the arrays found; both grow in the arena. */
struct writer {
    struct arena *arena;
    char *text;
    size_t length, capacity;
    struct numbers_array *array;
    size_t count, room;
};

static void *grow(struct arena *arena, const void *old, size_t used, size_t *capacity, size_t least,
                  size_t size) {
    size_t wanted = *capacity * 2 > least ? *capacity * 2 : least;
    void *memory = arena_take(arena, wanted, size);
    if (memory && used)
        memcpy(memory, old, used * size);
    if (memory)
        *capacity = wanted;
    return memory;
}

static bool put(struct writer *writer, const char *bytes, size_t length) {
    if (!length)
        return true;
    if (writer->length + length > writer->capacity) {
        writer->text = grow(writer->arena, writer->text, writer->length, &writer->capacity,
                            writer->length + length + 4096, 1);
        if (!writer->text)
            return false;
    }
    memcpy(writer->text + writer->length, bytes, length);
    writer->length += length;
    return true;
}

/* As it is written in JSON; returns its length. */
static int make_mark(char mark[MARK_ROOM], size_t index) {
    return snprintf(mark, MARK_ROOM, "\"\\u0001%s:%zu\"", secret, index);
}

static bool put_mark(struct writer *writer, struct numbers_array *array) {
    char mark[MARK_ROOM];
    int length = make_mark(mark, writer->count);
    array->at = writer->length;
    if (writer->count == writer->room) {
        writer->array = grow(writer->arena, writer->array, writer->count, &writer->room, 16,
                             sizeof *writer->array);
        if (!writer->array)
            return false;
    }
    writer->array[writer->count++] = *array;
    return put(writer, mark, (size_t)length);
}

/* Reads the values of a measured array. False without memory; `*in_range` says whether all are
 * doubles. */
static bool read_values(struct arena *arena, const char *begin, const char *end,
                        struct numbers_array *array, bool *in_range) {
    struct arena_mark mark = arena_mark(arena);
    struct reader reader = {begin, end};
    size_t width = array->width;
    double *values = arena_take(arena, array->rows * (width ? width : 1), sizeof *values);
    if (!values)
        return false;
    array->values = values;
    size_t rows = width ? take_rows(&reader, &width, values) : take_flat(&reader, values);
    *in_range = rows == array->rows;
    if (!*in_range)
        arena_rewind(arena, mark);
    return true;
}

static const char *string_end(const char *at, const char *end) {
    for (at++; at < end && *at != '"'; at++)
        at += *at == '\\' && at + 1 < end;
    return at < end ? at + 1 : end;
}

bool numbers_take_out(const char *bytes, size_t length, struct arena *arena,
                      struct numbers *numbers) {
    struct writer writer = {.arena = arena};
    const char *const end = bytes + length, *kept = bytes; /* up to there all is written */
    const char *tried = bytes; /* up to there no array of numbers begins */
    for (const char *at = bytes; at < end; at++) {
        struct numbers_array array;
        const char *behind;
        bool in_range;
        if (*at == '"')
            at = string_end(at, end) - 1;
        if (*at != '[' || at < tried)
            continue;
        if (!measure(at, end, &array, &behind))
            continue;
        if (!read_values(arena, at, end, &array, &in_range))
            return false;
        if (!in_range) {
            tried = behind;
            continue;
        }
        array.from = (size_t)(at - bytes);
        array.to = (size_t)(behind - bytes);
        if (!put(&writer, kept, (size_t)(at - kept)) || !put_mark(&writer, &array))
            return false;
        kept = behind;
        at = behind - 1;
    }
    bool any = writer.count > 0;
    if (any && !put(&writer, kept, (size_t)(end - kept)))
        return false;
    *numbers = (struct numbers){any ? writer.text : bytes, any ? writer.length : length,
                                writer.array, writer.count};
    return true;
}

/* ------------------------------------------------------------------ afterwards */

static bool is_mark(const char *text) {
    return text[0] == '\1' && !strncmp(text + 1, secret, SECRET_LENGTH) &&
           text[1 + SECRET_LENGTH] == ':';
}

const struct numbers_array *numbers_find(const struct numbers *numbers, const char *string) {
    if (!is_mark(string))
        return NULL;
    size_t index = strtoul(string + SECRET_LENGTH + 2, NULL, 10);
    return index < numbers->count ? &numbers->array[index] : NULL;
}

size_t numbers_origin(const struct numbers *numbers, size_t position,
                      const struct numbers_array **ended) {
    size_t before = 0;
    while (before < numbers->count && numbers->array[before].at < position)
        before++;
    *ended = NULL;
    if (before == 0)
        return position;
    const struct numbers_array *array = &numbers->array[before - 1];
    char mark[MARK_ROOM];
    size_t end = array->at + (size_t)make_mark(mark, before - 1);
    *ended = position == end ? array : NULL;
    return array->to + (position > end ? position - end : 0);
}
