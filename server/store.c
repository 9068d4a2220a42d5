/* SPDX-License-Identifier: MIT */
#include "store_backend.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const struct store_options store_options_default = {
    .queue_limit = 10000,
    .lease_us = INT64_C(60) * 1000000,
    .max_attempts = 3,
    .busy_ms = 5000,
    .retention_us = INT64_C(168) * 3600 * 1000000,
};

/* ------------------------------------------------------------------ names */

const char *store_answer_name(enum store_answer answer) {
    static const char *const names[] = {"ok", "empty", "conflict", "full", "busy", "down"};
    return names[answer];
}

static const char *const status_names[] = {
#define X(id, name) name,
    STORE_STATUS_LIST(X)
#undef X
};

const char *store_status_name(enum store_status status) {
    return status_names[status];
}

bool store_status_from_name(const char *name, enum store_status *status) {
    for (int k = 0; k < STORE_STATUS_COUNT; k++) {
        if (!strcmp(name, status_names[k])) {
            *status = (enum store_status)k;
            return true;
        }
    }
    return false;
}

bool store_status_ended(enum store_status status) {
    return status != STORE_QUEUED && status != STORE_RUNNING;
}

/* ------------------------------------------------------------------ open and close */

struct store *store_open(const char *url, const struct store_options *options, struct hub *hub,
                         char why[STORE_WHY_SIZE]) {
    if (strstr(url, "://")) {
        snprintf(why, STORE_WHY_SIZE,
                 "only SQLite (sqlite:PATH) is available as a store in this version");
        return NULL;
    }
    const char *path = strncmp(url, "sqlite:", 7) ? url : url + 7;
    return store_sqlite_open(path, options, hub, why);
}

void store_close(struct store *store) {
    if (store)
        store->ops->close(store);
}

enum store_answer store_ping(struct store *store) {
    return store->ops->ping(store);
}

/* ------------------------------------------------------------------ jobs */

/* Tells the waiters of a job, and the dispatchers when it may be claimed. */
static void tell(struct store *store, const char *id, bool claimable) {
    hub_notify(store->hub, id);
    if (claimable)
        hub_notify(store->hub, hub_queue);
}

enum store_answer store_submit(struct store *store, const struct store_submission *submission,
                               struct store_receipt *receipt) {
    enum store_answer answer = store->ops->submit(store, submission, receipt);
    if (answer == STORE_OK && !receipt->existing)
        tell(store, receipt->id, receipt->status == STORE_QUEUED);
    return answer;
}

enum store_answer store_get(struct store *store, const char *id, struct store_job *job) {
    memset(job, 0, sizeof *job);
    return store->ops->get(store, id, job);
}

void store_job_clear(struct store_job *job) {
    free(job->error);
    free(job->summary);
    job->error = NULL;
    job->summary = NULL;
}

enum store_answer store_request(struct store *store, const char *id, char **bytes, size_t *length) {
    *bytes = NULL;
    *length = 0;
    return store->ops->request(store, id, bytes, length);
}

enum store_answer store_list(struct store *store, const struct store_filter *filter,
                             struct store_page *page) {
    memset(page, 0, sizeof *page);
    return store->ops->list(store, filter, page);
}

void store_page_clear(struct store_page *page) {
    for (size_t k = 0; k < page->count; k++)
        store_job_clear(&page->jobs[k]);
    free(page->jobs);
    memset(page, 0, sizeof *page);
}

enum store_answer store_cancel(struct store *store, const char *id) {
    enum store_answer answer = store->ops->cancel(store, id);
    if (answer == STORE_OK)
        tell(store, id, false);
    return answer;
}

enum store_answer store_delete(struct store *store, const char *id) {
    enum store_answer answer = store->ops->remove(store, id);
    if (answer == STORE_OK)
        tell(store, id, false);
    return answer;
}

enum store_answer store_counts(struct store *store, struct store_counts *counts) {
    memset(counts, 0, sizeof *counts);
    return store->ops->counts(store, counts);
}

/* ------------------------------------------------------------------ dispatchers */

enum store_answer store_claim(struct store *store, struct store_claim *claim) {
    memset(claim, 0, sizeof *claim);
    enum store_answer answer = store->ops->claim(store, claim);
    if (answer == STORE_OK)
        tell(store, claim->id, false);
    return answer;
}

enum store_answer store_renew(struct store *store, const struct store_claim *claim,
                              double progress) {
    enum store_answer answer = store->ops->renew(store, claim, progress);
    if (answer == STORE_OK)
        tell(store, claim->id, false);
    return answer;
}

enum store_answer store_check(struct store *store, const struct store_claim *claim) {
    return store->ops->check(store, claim);
}

enum store_answer store_fail(struct store *store, const struct store_claim *claim,
                             const char *error) {
    enum store_answer answer = store->ops->fail(store, claim, error);
    if (answer == STORE_OK)
        tell(store, claim->id, false);
    return answer;
}

enum store_answer store_crashed(struct store *store, const struct store_claim *claim,
                                const char *detail) {
    enum store_answer answer = store->ops->crashed(store, claim, detail);
    if (answer == STORE_OK)
        tell(store, claim->id, true);
    return answer;
}

enum store_answer store_release(struct store *store, const struct store_claim *claim) {
    enum store_answer answer = store->ops->release(store, claim);
    if (answer == STORE_OK)
        tell(store, claim->id, true);
    return answer;
}

enum store_answer store_sweep(struct store *store, struct store_sweep *sweep) {
    memset(sweep, 0, sizeof *sweep);
    return store->ops->sweep(store, sweep);
}

/* ------------------------------------------------------------------ results */

struct store_writer {
    struct store *store;
    struct store_claim claim;
    int64_t number; /* of the stored part; 0 while all is in `buffer` */
    int64_t index;  /* chunks stored */
    bool committed;
    size_t used;
    unsigned char buffer[STORE_CHUNK_BYTES];
};

struct store_writer *store_writer_new(struct store *store, const struct store_claim *claim) {
    struct store_writer *writer = malloc(sizeof *writer);
    if (!writer)
        return NULL;
    writer->store = store;
    writer->claim = *claim;
    writer->number = 0;
    writer->index = 0;
    writer->committed = false;
    writer->used = 0;
    return writer;
}

static struct store_chunk chunk_of(const struct store_writer *writer) {
    return (struct store_chunk){
        .claim = &writer->claim,
        .number = writer->number,
        .index = writer->index,
        .bytes = writer->buffer,
        .length = writer->used,
        .total = writer->index * STORE_CHUNK_BYTES + (int64_t)writer->used,
    };
}

static enum store_answer flush(struct store_writer *writer) {
    if (writer->index + 1 >= STORE_CHUNKS_MAX)
        return STORE_DOWN;
    struct store_chunk chunk = chunk_of(writer);
    enum store_answer answer = writer->store->ops->result_append(writer->store, &chunk);
    if (answer == STORE_OK) {
        writer->number = chunk.number;
        writer->index++;
        writer->used = 0;
    }
    return answer;
}

enum store_answer store_writer_append(struct store_writer *writer, const void *bytes,
                                      size_t length) {
    const unsigned char *from = bytes;
    while (length > 0) {
        if (writer->used == STORE_CHUNK_BYTES) {
            enum store_answer answer = flush(writer);
            if (answer != STORE_OK)
                return answer;
        }
        size_t room = STORE_CHUNK_BYTES - writer->used;
        size_t part = length < room ? length : room;
        memcpy(writer->buffer + writer->used, from, part);
        writer->used += part;
        from += part;
        length -= part;
    }
    return STORE_OK;
}

enum store_answer store_writer_commit(struct store_writer *writer, const char *summary) {
    struct store_chunk chunk = chunk_of(writer);
    chunk.summary = summary;
    enum store_answer answer = writer->store->ops->result_commit(writer->store, &chunk);
    if (answer == STORE_OK) {
        writer->committed = true;
        tell(writer->store, writer->claim.id, false);
    }
    return answer;
}

void store_writer_free(struct store_writer *writer) {
    if (!writer)
        return;
    if (writer->number != 0 && !writer->committed) {
        enum store_answer dropped = writer->store->ops->result_drop(writer->store, writer->number);
        (void)dropped; /* else the sweep finds it */
    }
    free(writer);
}

enum store_answer store_result_find(struct store *store, const char *id,
                                    struct store_result *result) {
    memset(result, 0, sizeof *result);
    return store->ops->result_find(store, id, result);
}

enum store_answer store_result_read(struct store *store, const struct store_result *result,
                                    int64_t offset, void *bytes, size_t length) {
    unsigned char *to = bytes;
    while (length > 0) {
        size_t within = (size_t)(offset % STORE_CHUNK_BYTES);
        size_t room = STORE_CHUNK_BYTES - within;
        size_t part = length < room ? length : room;
        enum store_answer answer = store->ops->result_read(
            store, result->number, offset / STORE_CHUNK_BYTES, within, to, part);
        if (answer != STORE_OK)
            return answer;
        to += part;
        offset += (int64_t)part;
        length -= part;
    }
    return STORE_OK;
}

/* ------------------------------------------------------------------ surfaces */

void store_surface_clear(struct store_surface *surface) {
    free(surface->definition);
    free(surface->description);
    surface->definition = NULL;
    surface->description = NULL;
}

enum store_answer store_surface_put(struct store *store, const struct store_surface *surface,
                                    bool *created) {
    return store->ops->surface_put(store, surface, created);
}

enum store_answer store_surface_get(struct store *store, const char *id,
                                    struct store_surface *surface) {
    memset(surface, 0, sizeof *surface);
    return store->ops->surface_get(store, id, surface);
}

enum store_answer store_surface_list(struct store *store, const char *owner, int64_t cursor,
                                     int limit, struct store_surfaces *page) {
    memset(page, 0, sizeof *page);
    return store->ops->surface_list(store, owner, cursor, limit, page);
}

void store_surfaces_clear(struct store_surfaces *page) {
    for (size_t k = 0; k < page->count; k++)
        store_surface_clear(&page->surfaces[k]);
    free(page->surfaces);
    memset(page, 0, sizeof *page);
}

enum store_answer store_surface_delete(struct store *store, const char *id) {
    return store->ops->surface_delete(store, id);
}
