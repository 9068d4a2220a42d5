/* SPDX-License-Identifier: MIT */
/*
 * JSON text being written: bytes that grow in an arena, or fill a buffer of the caller's. Running
 * out of room sets `failed`, after which nothing is added; so a document is written straight
 * through and asked once, at its end, whether it is whole.
 */
#ifndef API_JSON_TEXT_H
#define API_JSON_TEXT_H

#include "solver/arena.h"
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct api_text {
    char *bytes;
    size_t length, capacity;
    struct arena *arena; /* where it grows; NULL: `bytes` is the caller's and does not grow */
    bool failed;
};

static inline struct api_text api_text_growing(struct arena *memory) {
    return (struct api_text){.arena = memory};
}

static inline struct api_text api_text_over(char *buffer, size_t capacity) {
    return (struct api_text){.bytes = buffer, .capacity = capacity};
}

/* `length` bytes as they are. */
void api_text_bytes(struct api_text *text, const void *bytes, size_t length);

/* A zero-terminated string as it is: punctuation, literals and `"key":`. */
void api_text_raw(struct api_text *text, const char *string);

/* As printf: a line of at most 1,023 bytes; what is longer is cut there. */
void api_text_format(struct api_text *text, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* Bytes of the well-formed UTF-8 character at `string`, of which `left` (1 or more) bytes follow; 0
 * when there is none. */
size_t api_text_character(const char *string, size_t left);

/* The character at `s`, of which `left` (1 or more) bytes follow, as JSON has it within quotes:
 * `*length` bytes in `escaped`. Returns how many bytes it takes; one that is not UTF-8 becomes
 * U+FFFD. */
enum { API_ESCAPED_SIZE = 8 };
size_t api_text_escape(const char *s, size_t left, char escaped[API_ESCAPED_SIZE], size_t *length);

/* A zero-terminated string in quotes, escaped. */
void api_text_string(struct api_text *text, const char *string);

/* The shortest decimal of a finite number; `null` for one that is not. */
void api_text_number(struct api_text *text, double value);
void api_text_integer(struct api_text *text, int64_t value);

/* `,"key":value`, the comma left out right after an opening bracket. */
void api_text_key(struct api_text *text, const char *key);
void api_text_key_object(struct api_text *text, const char *key); /* and its opening brace */
void api_text_key_string(struct api_text *text, const char *key, const char *value);
void api_text_key_number(struct api_text *text, const char *key, double value);
void api_text_key_integer(struct api_text *text, const char *key, int64_t value);
void api_text_key_boolean(struct api_text *text, const char *key, bool value);
void api_text_key_numbers(struct api_text *text, const char *key, const double *values,
                          size_t count);
void api_text_key_integers(struct api_text *text, const char *key, const int *values, size_t count);

/* `,"key":[[a,b,c],...]`: `count` rows of `width` numbers. */
void api_text_key_rows(struct api_text *text, const char *key, const double *values, size_t width,
                       size_t count);

/* The contract's `bounding_box`, of two corners of three coordinates. */
void api_text_box(struct api_text *text, const double *lower, const double *upper);

/* `[a,b,...]`. */
void api_text_numbers(struct api_text *text, const double *values, size_t count);
void api_text_integers(struct api_text *text, const int *values, size_t count);

/* Zero-terminates; the string, or NULL when it failed. */
const char *api_text_finish(struct api_text *text);

#endif
