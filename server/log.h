/* SPDX-License-Identifier: MIT */
/*
 * The log: one JSON object a line on stderr, one line an event, written with one system call. Every
 * value is escaped, whatever bytes it holds; long texts are cut. Never log a body, a token or a
 * database password.
 *
 *     log_info(log_event("job_failed"), log_text("job", id), log_int("attempts", 3));
 *
 * gives {"time":"2025-01-02T03:04:05.678901Z","level":"info","event":"job_failed","job":...}.
 * Any thread; it cannot fail, a line that cannot be written is lost.
 */
#ifndef SERVER_LOG_H
#define SERVER_LOG_H

#include <stdint.h>

enum log_level { LOG_LEVEL_DEBUG, LOG_LEVEL_INFO, LOG_LEVEL_WARNING, LOG_LEVEL_ERROR };

enum log_kind { LOG_KIND_NONE, LOG_KIND_TEXT, LOG_KIND_INT, LOG_KIND_REAL, LOG_KIND_NOTHING };

/* One member of the line; made by the functions below, read at once. */
struct log_field {
    const char *name; /* a literal: it is not escaped */
    enum log_kind kind;
    const char *text; /* LOG_KIND_TEXT; NULL is written as null */
    int64_t integer;
    double real;
};

struct log_field log_text(const char *name, const char *value);
/* The same, but left out of the line when it is empty. */
struct log_field log_word(const char *name, const char *value);
struct log_field log_int(const char *name, int64_t value);
struct log_field log_real(const char *name, double value); /* null when not finite */
/* The first field of every line: what happened, in snake_case. */
struct log_field log_event(const char *event);

#define LOG_FIELDS(...) ((const struct log_field[]){__VA_ARGS__, {0}})
#define log_debug(...) log_write(LOG_LEVEL_DEBUG, LOG_FIELDS(__VA_ARGS__))
#define log_info(...) log_write(LOG_LEVEL_INFO, LOG_FIELDS(__VA_ARGS__))
#define log_warning(...) log_write(LOG_LEVEL_WARNING, LOG_FIELDS(__VA_ARGS__))
#define log_error(...) log_write(LOG_LEVEL_ERROR, LOG_FIELDS(__VA_ARGS__))

/* Events below `level` are not written; LOG_LEVEL_INFO at the start. Before other threads run. */
void log_init(enum log_level level);

/* Writes the fields up to the one of LOG_KIND_NONE. Call it by the macros. */
void log_write(enum log_level level, const struct log_field *fields);

#endif
