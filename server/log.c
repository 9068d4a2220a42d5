/* SPDX-License-Identifier: MIT */
#include "log.h"

#include "api/json/text.h"
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
static bool put_bytes(struct line *line, const char *text, size_t length) {
    if (line->length + length + TAIL_BYTES > sizeof line->text)
        return false;
    memcpy(line->text + line->length, text, length);
    line->length += length;
    return true;
}

static void put_field(struct line *line, const struct log_field *field) {
    char number[40];
    size_t before = line->length;
    int n = snprintf(number, sizeof number, ",\"%.32s\":", field->name);
    if (!put_bytes(line, number, (size_t)n))
        return;
    if (line->length + 16 + TAIL_BYTES > sizeof line->text) { /* no room for a useful value */
        line->length = before;
        return;
    }
    const char *text = field->text;
    if (field->kind == LOG_KIND_TEXT && text) {
        if (!put_bytes(line, "\"", 1))
            return;
        char escaped[API_ESCAPED_SIZE];
        size_t length, taken;
        for (size_t left = strnlen(text, TEXT_MAX_BYTES); left > 0; left -= taken, text += taken) {
            taken = api_text_escape(text, left, escaped, &length);
            if (!put_bytes(line, escaped, length))
                break;
        }
        line->text[line->length++] = '"'; /* one of TAIL_BYTES */
        return;
    }
    if (field->kind == LOG_KIND_INT)
        n = snprintf(number, sizeof number, "%lld", (long long)field->integer);
    else if (field->kind != LOG_KIND_TEXT && isfinite(field->real))
        n = snprintf(number, sizeof number, "%.6g", field->real);
    else
        n = snprintf(number, sizeof number, "null");
    if (!put_bytes(line, number, (size_t)n))
        line->length = before;
}

void log_init(enum log_level level) {
    lowest = level;
}

void log_write(enum log_level level, const struct log_field *fields) {
    static const char *const names[] = {"debug", "info", "warning", "error"};
    struct timespec now;
    struct tm utc;
    if (level < lowest)
        return;
    clock_gettime(CLOCK_REALTIME, &now);
    gmtime_r(&now.tv_sec, &utc);
    struct line line = {.length = 0};
    line.length = strftime(line.text, 64, "{\"time\":\"%Y-%m-%dT%H:%M:%S", &utc);
    line.length += (size_t)snprintf(line.text + line.length, 64, ".%06ldZ\",\"level\":\"%s\"",
                                    now.tv_nsec / 1000, names[level]);
    for (; fields->kind != LOG_KIND_NONE; fields++)
        if (fields->kind != LOG_KIND_NOTHING)
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

struct log_field log_word(const char *name, const char *value) {
    struct log_field field = log_text(name, value);
    if (!value || !value[0])
        field.kind = LOG_KIND_NOTHING;
    return field;
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
