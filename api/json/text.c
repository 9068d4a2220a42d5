/* SPDX-License-Identifier: MIT */
#include "text.h"

#include "number.h"
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

enum { FIRST_CAPACITY = 1024, LINE_SIZE = 1024 };

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
    if (length == 0 || !reserve(text, length)) /* without bytes there may be no text to add to */
        return;
    memcpy(text->bytes + text->length, bytes, length);
    text->length += length;
}

void api_text_raw(struct api_text *text, const char *string) {
    api_text_bytes(text, string, strlen(string));
}

void api_text_format(struct api_text *text, const char *format, ...) {
    char line[LINE_SIZE];
    va_list values;
    va_start(values, format);
    vsnprintf(line, sizeof line, format, values);
    va_end(values);
    api_text_raw(text, line);
}

size_t api_text_character(const char *string, size_t left) {
    const unsigned char *s = (const unsigned char *)string;
    size_t length = s[0] < 0x80 ? 1 : s[0] < 0xc2 ? 0 : s[0] < 0xe0 ? 2 : s[0] < 0xf0 ? 3 : 4;
    if (s[0] > 0xf4 || length > left)
        return 0;
    for (size_t k = 1; k < length; k++)
        if ((s[k] & 0xc0) != 0x80)
            return 0;
    bool overlong = (s[0] == 0xe0 && s[1] < 0xa0) || (s[0] == 0xf0 && s[1] < 0x90);
    bool surrogate = s[0] == 0xed && s[1] > 0x9f;
    bool beyond = s[0] == 0xf4 && s[1] > 0x8f;
    return overlong || surrogate || beyond ? 0 : length;
}

size_t api_text_escape(const char *s, size_t left, char escaped[API_ESCAPED_SIZE], size_t *length) {
    static const char hex[] = "0123456789abcdef";
    unsigned char c = (unsigned char)*s;
    size_t taken = api_text_character(s, left);
    if (taken == 0 || c < 0x20 || c == 0x7f) {
        memcpy(escaped, taken ? "\\u0000" : "\\ufffd", 6);
        if (taken) {
            escaped[4] = hex[c >> 4];
            escaped[5] = hex[c & 15];
        }
        *length = 6;
        return 1;
    }
    size_t slash = c == '"' || c == '\\';
    escaped[0] = '\\';
    memcpy(escaped + slash, s, taken);
    *length = slash + taken;
    return taken;
}

void api_text_string(struct api_text *text, const char *string) {
    char escaped[API_ESCAPED_SIZE];
    size_t length, taken;
    api_text_raw(text, "\"");
    for (size_t left = strlen(string); left > 0; left -= taken, string += taken) {
        /* The next bytes that stand for themselves: all of nearly every string. */
        for (taken = 0; taken < left && string[taken] >= ' ' && string[taken] < 0x7f &&
                        string[taken] != '"' && string[taken] != '\\';)
            taken++;
        if (taken) {
            api_text_bytes(text, string, taken);
        } else {
            taken = api_text_escape(string, left, escaped, &length);
            api_text_bytes(text, escaped, length);
        }
    }
    api_text_raw(text, "\"");
}

void api_text_number(struct api_text *text, double value) {
    if (!isfinite(value))
        api_text_raw(text, "null");
    else if (reserve(text, API_NUMBER_SIZE))
        text->length += api_number_shortest(text->bytes + text->length, value);
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

void api_text_key_object(struct api_text *text, const char *key) {
    api_text_key(text, key);
    api_text_raw(text, "{");
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

void api_text_key_boolean(struct api_text *text, const char *key, bool value) {
    api_text_key(text, key);
    api_text_raw(text, value ? "true" : "false");
}

void api_text_numbers(struct api_text *text, const double *values, size_t count) {
    for (size_t i = 0; i < count; i++) {
        api_text_raw(text, i ? "," : "[");
        api_text_number(text, values[i]);
    }
    api_text_raw(text, count ? "]" : "[]");
}

void api_text_integers(struct api_text *text, const int *values, size_t count) {
    for (size_t i = 0; i < count; i++) {
        api_text_raw(text, i ? "," : "[");
        api_text_integer(text, values[i]);
    }
    api_text_raw(text, count ? "]" : "[]");
}

void api_text_key_numbers(struct api_text *text, const char *key, const double *values,
                          size_t count) {
    api_text_key(text, key);
    api_text_numbers(text, values, count);
}

void api_text_key_integers(struct api_text *text, const char *key, const int *values,
                           size_t count) {
    api_text_key(text, key);
    api_text_integers(text, values, count);
}

void api_text_key_rows(struct api_text *text, const char *key, const double *values, size_t width,
                       size_t count) {
    api_text_key(text, key);
    for (size_t i = 0; i < count; i++) {
        api_text_raw(text, i ? "," : "[");
        api_text_numbers(text, values + i * width, width);
    }
    api_text_raw(text, count ? "]" : "[]");
}

void api_text_box(struct api_text *text, const double *lower, const double *upper) {
    api_text_key(text, "bounding_box");
    api_text_raw(text, "[");
    api_text_numbers(text, lower, 3);
    api_text_raw(text, ",");
    api_text_numbers(text, upper, 3);
    api_text_raw(text, "]");
}

const char *api_text_finish(struct api_text *text) {
    api_text_bytes(text, "", 1);
    return text->failed ? NULL : text->bytes;
}
