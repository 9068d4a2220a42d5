/* SPDX-License-Identifier: MIT */
#include "log.h"
#include <math.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

enum {
    LINE_MAX_BYTES = 4096, /* what one write to a pipe passes on undivided */
    TEXT_MAX_BYTES = 512,  /* of a value, before escaping */
    TAIL_BYTES = 8         /* always left for closing the object */
};

static enum log_level lowest = LOG_LEVEL_INFO;
/* stderr may be a file, where two writes could overlap. */
static pthread_mutex_t line_lock = PTHREAD_MUTEX_INITIALIZER;

struct line {
    char text[LINE_MAX_BYTES];
    size_t length;
};

/* Appends all of `text` or nothing. */
static bool put(struct line *line, const char *text, size_t length) {
    if (line->length + length + TAIL_BYTES > sizeof line->text)
        return false;
    memcpy(line->text + line->length, text, length);
    line->length += length;
    return true;
}

/* Bytes of the well-formed UTF-8 character at `s`; 0 when there is none. */
static size_t utf8_length(const unsigned char *s, size_t left) {
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

/* Appends the character at `s` escaped; returns the bytes it took of `s`, 0 without room. */
static size_t put_character(struct line *line, const unsigned char *s, size_t left) {
    char escaped[8];
    size_t length = utf8_length(s, left);
    if (length == 0)
        return put(line, "\\ufffd", 6) ? 1 : 0;
    if (s[0] < 0x20 || s[0] == 0x7f) {
        int n = snprintf(escaped, sizeof escaped, "\\u%04x", s[0]);
        return put(line, escaped, (size_t)n) ? 1 : 0;
    }
    if (s[0] == '"' || s[0] == '\\') {
        escaped[0] = '\\';
        escaped[1] = (char)s[0];
        return put(line, escaped, 2) ? 1 : 0;
    }
    return put(line, (const char *)s, length) ? length : 0;
}

static void put_text(struct line *line, const char *text) {
    if (!text) {
        put(line, "null", 4);
        return;
    }
    if (!put(line, "\"", 1))
        return;
    size_t left = strnlen(text, TEXT_MAX_BYTES);
    const unsigned char *s = (const unsigned char *)text;
    while (left > 0) {
        size_t taken = put_character(line, s, left);
        if (taken == 0)
            break;
        s += taken;
        left -= taken;
    }
    line->text[line->length++] = '"'; /* one of TAIL_BYTES */
}

static void put_field(struct line *line, const struct log_field *field) {
    char number[40];
    size_t before = line->length;
    int n = snprintf(number, sizeof number, ",\"%.32s\":", field->name);
    if (!put(line, number, (size_t)n))
        return;
    if (line->length + 16 + TAIL_BYTES > sizeof line->text) { /* no room for a useful value */
        line->length = before;
        return;
    }
    if (field->kind == LOG_KIND_TEXT) {
        put_text(line, field->text);
        return;
    }
    if (field->kind == LOG_KIND_INT)
        n = snprintf(number, sizeof number, "%lld", (long long)field->integer);
    else if (isfinite(field->real))
        n = snprintf(number, sizeof number, "%.6g", field->real);
    else
        n = snprintf(number, sizeof number, "null");
    if (!put(line, number, (size_t)n))
        line->length = before;
}

static void put_head(struct line *line, enum log_level level) {
    static const char *const names[] = {"debug", "info", "warning", "error"};
    struct timespec now;
    struct tm utc;
    clock_gettime(CLOCK_REALTIME, &now);
    gmtime_r(&now.tv_sec, &utc);
    char head[96];
    size_t n = strftime(head, sizeof head, "{\"time\":\"%Y-%m-%dT%H:%M:%S", &utc);
    put(line, head, n);
    int m =
        snprintf(head, sizeof head, ".%06ldZ\",\"level\":\"%s\"", now.tv_nsec / 1000, names[level]);
    put(line, head, (size_t)m);
}

void log_init(enum log_level level) {
    lowest = level;
}

void log_write(enum log_level level, const struct log_field *fields) {
    if (level < lowest)
        return;
    struct line line = {.length = 0};
    put_head(&line, level);
    for (; fields->kind != LOG_KIND_NONE; fields++)
        put_field(&line, fields);
    memcpy(line.text + line.length, "}\n", 2);
    line.length += 2;
    pthread_mutex_lock(&line_lock);
    ssize_t written = write(STDERR_FILENO, line.text, line.length);
    (void)written; /* there is no other place to report it */
    pthread_mutex_unlock(&line_lock);
}

struct log_field log_text(const char *name, const char *value) {
    return (struct log_field){.name = name, .kind = LOG_KIND_TEXT, .text = value};
}

struct log_field log_int(const char *name, int64_t value) {
    return (struct log_field){.name = name, .kind = LOG_KIND_INT, .integer = value};
}

struct log_field log_real(const char *name, double value) {
    return (struct log_field){.name = name, .kind = LOG_KIND_REAL, .real = value};
}

struct log_field log_event(const char *event) {
    return log_text("event", event);
}
