/* SPDX-License-Identifier: MIT */
#include "documents.h"
#include "api/json/text.h"
#include "api/result/summary.h"
#include <jansson.h>
#include <stdio.h>
#include <string.h>

/* The longest list: 1000 jobs, each with a problem of 16 errors at the worst. */
enum { DOCUMENT_BYTES_MAX = 64 << 20 };

struct document {
    struct arena *arena;
    struct api_text text;
};

static struct document document_new(void) {
    struct document document = {.arena = arena_new(DOCUMENT_BYTES_MAX)};
    document.text = api_text_growing(document.arena);
    document.text.failed = !document.arena;
    return document;
}

/* The text in memory of its own; frees the rest. */
static char *document_finish(struct document *document) {
    const char *text = document->text.failed ? NULL : api_text_finish(&document->text);
    char *copy = text ? strdup(text) : NULL;
    arena_free(document->arena);
    return copy;
}

/* `count` decimal digits of a number, the last at `end - 1`. */
static void put_digits(char *end, int count, int64_t number) {
    for (; count > 0; count--, number /= 10)
        *--end = (char)('0' + number % 10);
}

/* The date follows from the days since 0000-03-01, in which leap days come last (H. Hinnant,
 * chrono-compatible low-level date algorithms). */
void documents_time(char date[DOCUMENTS_TIME_SIZE], int64_t us) {
    const int64_t seconds = us / 1000000, day = seconds / 86400 + 719468;
    const int64_t era = day / 146097, of_era = day % 146097;
    const int64_t year = (of_era - of_era / 1460 + of_era / 36524 - of_era / 146096) / 365;
    const int64_t of_year = of_era - (365 * year + year / 4 - year / 100);
    const int64_t month = (5 * of_year + 2) / 153; /* 0 is March */
    memcpy(date, "0000-00-00T00:00:00.000000Z", DOCUMENTS_TIME_SIZE);
    put_digits(date + 4, 4, year + 400 * era + (month > 9));
    put_digits(date + 7, 2, month < 10 ? month + 3 : month - 9);
    put_digits(date + 10, 2, of_year - (153 * month + 2) / 5 + 1);
    put_digits(date + 13, 2, seconds / 3600 % 24);
    put_digits(date + 16, 2, seconds / 60 % 60);
    put_digits(date + 19, 2, seconds % 60);
    put_digits(date + 26, 6, us % 1000000);
}

static void write_member(struct api_text *text, const char *key, const char *json) {
    api_text_key(text, key);
    api_text_raw(text, json);
}

/* "key": the time, or null for 0. */
static void write_time(struct api_text *text, const char *key, int64_t us) {
    char date[DOCUMENTS_TIME_SIZE];
    documents_time(date, us);
    write_member(text, key, us ? "\"" : "null");
    if (us)
        api_text_bytes(text, date, sizeof date - 1);
    api_text_raw(text, us ? "\"" : "");
}

const char *documents_collection(enum store_kind kind) {
    static const char *const names[STORE_KIND_COUNT] = {"drapes", "studies", "tasks", "laminates"};
    return names[kind];
}

/* Nothing of it needs escaping. */
static void write_link(struct api_text *text, const char *key, const struct store_job *job,
                       const char *tail) {
    write_member(text, key, "\"/v1/");
    api_text_raw(text, documents_collection(job->kind));
    api_text_raw(text, "/");
    api_text_raw(text, job->id);
    api_text_raw(text, tail);
    api_text_raw(text, "\"");
}

/* `plies` may be NULL. The stored summary belongs to the result, which other jobs may share; the
 * time in the queue is this job's. */
static void write_status(struct api_text *text, const struct store_job *job, const char *plies) {
    bool shares = job->kind == STORE_LAMINATE && job->total > 0; /* of its drapes have ended */
    double progress = !shares                          ? job->progress
                      : job->status == STORE_SUCCEEDED ? 1
                                                       : (double)job->done / (double)job->total;
    api_text_raw(text, "{");
    api_text_key_string(text, "id", job->id);
    if (job->owner[0] && job->owner[0] != '@') /* an address is nobody else's business */
        api_text_key_string(text, "owner", job->owner);
    api_text_key_string(text, "status", store_status_name(job->status));
    api_text_key_number(text, "progress", progress);
    if (job->kind == STORE_STUDY) {
        /* How many have been looked at. A search may end before its budget: then the summary has
         * their number. */
        json_t *summary = json_loads(job->summary ? job->summary : "{}", 0, NULL);
        int64_t all = json_integer_value(json_object_get(summary, "variants"));
        json_decref(summary);
        api_text_key_object(text, "variants");
        api_text_key_integer(text, "done", all ? all : job->done);
        api_text_key_integer(text, "total", all ? all : job->total);
        api_text_raw(text, "}");
    }
    write_time(text, "created", job->created);
    write_time(text, "started", job->started);
    write_time(text, "finished", job->finished);
    api_text_key_integer(text, "attempts", job->attempts);
    if (job->summary && (job->kind != STORE_STUDY || job->status == STORE_SUCCEEDED)) {
        api_text_key(text, "summary");
        api_summary_write_stored(text, job->summary, documents_queue_ms(job));
    } else if (job->summary) {
        write_member(text, "best_so_far", job->summary);
    }
    if (plies)
        write_member(text, "plies", plies);
    if (job->error)
        write_member(text, "error", job->error);
    if (job->altered)
        write_member(text, "damaged", "true");
    api_text_key_object(text, "links");
    write_link(text, "self", job, "");
    if (job->kind != STORE_LAMINATE)
        write_link(text, "result", job, "/result");
    write_link(text, "request", job, "/request");
    write_link(text, "events", job, "/events");
    api_text_raw(text, "}}");
}

char *documents_status(const struct store_job *job, const char *plies) {
    struct document document = document_new();
    write_status(&document.text, job, plies);
    return document_finish(&document);
}

/* A page of a list begins and ends. The cursor is a string: what it means is the store's business.
 */
static struct document begin_page(const char *collection) {
    struct document document = document_new();
    api_text_raw(&document.text, "{");
    write_member(&document.text, collection, "[");
    return document;
}

static char *end_page(struct document *document, int64_t next) {
    char cursor[24];
    snprintf(cursor, sizeof cursor, "\"%lld\"", (long long)next);
    api_text_raw(&document->text, "]");
    write_member(&document->text, "next", next ? cursor : "null");
    api_text_raw(&document->text, "}");
    return document_finish(document);
}

char *documents_list(enum store_kind kind, const struct store_page *page) {
    struct document document = begin_page(documents_collection(kind));
    for (size_t k = 0; k < page->count; k++) {
        api_text_raw(&document.text, k ? "," : "");
        write_status(&document.text, &page->jobs[k], NULL);
    }
    return end_page(&document, page->next);
}

char *documents_items(const char *collection, const char *first, const struct store_items *page) {
    struct document document = begin_page(collection);
    api_text_raw(&document.text, first);
    for (size_t k = 0; k < page->count; k++) {
        const char *description = page->items[k].description;
        api_text_raw(&document.text, k || *first ? "," : "");
        api_text_raw(&document.text, description ? description : "null");
    }
    return end_page(&document, page->next);
}

char *documents_job_problem(const struct store_job *job, const char *request_id, int *status) {
    json_t *problem = json_loads(job->error ? job->error : "{}", 0, NULL);
    json_int_t own = json_integer_value(json_object_get(problem, "status"));
    *status = own >= 400 && own <= 599 ? (int)own : 500;
    json_object_set_new(problem, "request_id", json_string(request_id));
    char *text = json_dumps(problem, JSON_COMPACT);
    json_decref(problem);
    return text;
}

double documents_queue_ms(const struct store_job *job) {
    int64_t us = job->started > job->created ? job->started - job->created : 0;
    return (double)us / 1000;
}
