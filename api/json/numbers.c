/* SPDX-License-Identifier: MIT */
#include "numbers.h"
#include "scan.h"
#include "text.h"
#include "walk.h"
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

/* A flat array: how many numbers; 0 when it is none. `values` may be NULL: they are counted. */
static size_t take_flat(struct scan *scan, double *values) {
    size_t count = 0;
    if (!scan_take(scan, '['))
        return 0;
    do {
        scan_peek(scan);
        if (!scan_take_number(scan, values ? values + count : NULL))
            return 0;
        count++;
    } while (scan_take(scan, ','));
    return scan_take(scan, ']') ? count : 0;
}

/* An array of flat arrays of the same length. */
static size_t take_rows(struct scan *scan, size_t *width, double *values) {
    size_t rows = 0;
    if (!scan_take(scan, '['))
        return 0;
    do {
        size_t count = take_flat(scan, values ? values + rows * *width : NULL);
        if (!count || (rows > 0 && count != *width))
            return 0;
        *width = count;
        rows++;
    } while (scan_take(scan, ','));
    return scan_take(scan, ']') ? rows : 0;
}

/* ------------------------------------------------------------------ taking out */

/* As it is written in JSON; returns its length. */
static int make_mark(char mark[MARK_ROOM], size_t index) {
    return snprintf(mark, MARK_ROOM, "\"\\u0001%s:%zu\"", secret, index);
}

bool numbers_take_out(const char *bytes, size_t length, struct arena *arena,
                      struct numbers *numbers) {
    struct api_text text = api_text_growing(arena);
    struct numbers_array array, *arrays = NULL;
    size_t count = 0, room = 0;
    const char *const end = bytes + length, *kept = bytes; /* up to there all is written */
    const char *tried = bytes; /* up to there no array of numbers begins */
    for (const char *at = arena ? bytes : end; at < end; at++) {
        char mark[MARK_ROOM];
        if (*at == '"' && (at = walk_string_end(at + 1, end)) == end)
            break;
        if (*at != '[' || at < tried)
            continue;
        /* The shape of the array, if it is one of numbers and not too short; then its values. */
        struct scan scan = {.at = at, .end = end};
        array = (struct numbers_array){.rows = take_flat(&scan, NULL)};
        if (!array.rows) {
            scan.at = at;
            array.rows = take_rows(&scan, &array.width, NULL);
        }
        const char *behind = scan.at;
        size_t width = array.width, wanted = array.rows * (width ? width : 1);
        if (wanted < NUMBERS_LEAST)
            continue;
        struct arena_mark before = arena_mark(arena);
        double *values = arena_take(arena, wanted, sizeof *values);
        if (!values)
            return false;
        array.values = values;
        scan.at = at;
        size_t rows = width ? take_rows(&scan, &width, values) : take_flat(&scan, values);
        if (rows != array.rows) { /* not all are doubles */
            arena_rewind(arena, before);
            tried = behind;
            continue;
        }
        api_text_bytes(&text, kept, (size_t)(at - kept));
        array.from = (size_t)(at - bytes);
        array.to = (size_t)(behind - bytes);
        array.at = text.length;
        if (count == room)
            arrays = arena_enlarge(arena, arrays, count, sizeof *arrays, &room);
        if (!arrays)
            return false;
        arrays[count] = array;
        api_text_bytes(&text, mark, (size_t)make_mark(mark, count++));
        kept = behind;
        at = behind - 1;
    }
    if (count > 0)
        api_text_bytes(&text, kept, (size_t)(end - kept));
    *numbers =
        (struct numbers){count ? text.bytes : bytes, count ? text.length : length, arrays, count};
    return !text.failed;
}

/* ------------------------------------------------------------------ afterwards */

const struct numbers_array *numbers_find(const struct numbers *numbers, const char *string) {
    if (string[0] != '\1' || strncmp(string + 1, secret, SECRET_LENGTH) != 0 ||
        string[1 + SECRET_LENGTH] != ':')
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
