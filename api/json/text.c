/* SPDX-License-Identifier: MIT */
#include "text.h"

#include "number.h"
#include <math.h>
#include <string.h>

enum { FIRST_CAPACITY = 1024 };

/* Makes room for `length` more bytes, doubling; the old block stays in the arena until that is
 * rewound, so a text costs at most twice its final size. */
static bool reserve(struct api_text *text, size_t length) {
    if (text->failed)
        return false;
    if (length <= text->capacity - text->length)
        return true;
    size_t capacity = text->capacity ? text->capacity : FIRST_CAPACITY;
    while (capacity - text->length < length && capacity <= SIZE_MAX / 2)
        capacity *= 2;
    char *bytes = text->arena ? arena_alloc(text->arena, capacity, 1) : NULL;
    if (!bytes) {
        text->failed = true;
        return false;
    }
    if (text->length)
        memcpy(bytes, text->bytes, text->length);
    text->bytes = bytes;
    text->capacity = capacity;
    return true;
}

void api_text_bytes(struct api_text *text, const void *bytes, size_t length) {
    if (!reserve(text, length))
        return;
    memcpy(text->bytes + text->length, bytes, length);
    text->length += length;
}

void api_text_raw(struct api_text *text, const char *string) {
    api_text_bytes(text, string, strlen(string));
}

static void escape(struct api_text *text, char c) {
    static const char hex[] = "0123456789abcdef";
    unsigned code = (unsigned char)c;
    if (c == '"' || c == '\\') {
        api_text_bytes(text, (const char[]){'\\', c}, 2);
    } else if (code < 0x20) {
        api_text_raw(text, "\\u00");
        api_text_bytes(text, (const char[]){hex[code >> 4], hex[code & 15]}, 2);
    } else {
        api_text_bytes(text, &c, 1);
    }
}

void api_text_string(struct api_text *text, const char *string) {
    api_text_raw(text, "\"");
    for (; *string; string++)
        escape(text, *string);
    api_text_raw(text, "\"");
}

void api_text_number(struct api_text *text, double value) {
    if (!isfinite(value)) {
        api_text_raw(text, "null");
    } else if (reserve(text, API_NUMBER_SIZE)) {
        text->length += api_number_shortest(text->bytes + text->length, value);
    }
}

void api_text_integer(struct api_text *text, int64_t value) {
    if (reserve(text, API_NUMBER_SIZE))
        text->length += api_number_integer(text->bytes + text->length, value);
}

void api_text_key(struct api_text *text, const char *key) {
    char last = text->length ? text->bytes[text->length - 1] : '{';
    if (last != '{' && last != '[')
        api_text_raw(text, ",");
    api_text_string(text, key);
    api_text_raw(text, ":");
}

void api_text_key_string(struct api_text *text, const char *key, const char *value) {
    api_text_key(text, key);
    api_text_string(text, value);
}

void api_text_key_number(struct api_text *text, const char *key, double value) {
    api_text_key(text, key);
    api_text_number(text, value);
}

void api_text_key_integer(struct api_text *text, const char *key, int64_t value) {
    api_text_key(text, key);
    api_text_integer(text, value);
}

void api_text_numbers(struct api_text *text, const double *values, size_t count) {
    api_text_raw(text, "[");
    for (size_t i = 0; i < count; i++) {
        if (i)
            api_text_raw(text, ",");
        api_text_number(text, values[i]);
    }
    api_text_raw(text, "]");
}

void api_text_integers(struct api_text *text, const int *values, size_t count) {
    api_text_raw(text, "[");
    for (size_t i = 0; i < count; i++) {
        if (i)
            api_text_raw(text, ",");
        api_text_integer(text, values[i]);
    }
    api_text_raw(text, "]");
}

const char *api_text_finish(struct api_text *text) {
    api_text_bytes(text, "", 1);
    return text->failed ? NULL : text->bytes;
}
