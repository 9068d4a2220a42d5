/* SPDX-License-Identifier: MIT */
#include "seal.h"
#include "server/clock.h"
#include "uncommitted_result.h"
#include <stdlib.h>
#include <string.h>

/* ------------------------------------------------------------------ names */

static const char *const status_names[] = {
#define X(id, name) name,
    STORE_STATUS_LIST(X)
#undef X
};

static const char *const kind_names[] = {
#define X(id, name) name,
    STORE_KIND_LIST(X)
#undef X
};

const char *store_kind_name(enum store_kind kind) {
    return kind_names[kind];
}

const char *store_item_kind_name(enum store_item_kind kind) {
    static const char *const names[STORE_ITEM_KINDS] = {"surface", "material", "link"};
    return names[kind];
}

const char *store_status_name(enum store_status status) {
    return status_names[status];
}

bool store_status_from_name(const char *name, enum store_status *status) {
    int k = 0;
    while (k < STORE_STATUS_COUNT && strcmp(name, status_names[k]) != 0)
        k++;
    if (k < STORE_STATUS_COUNT)
        *status = (enum store_status)k;
    return k < STORE_STATUS_COUNT;
}

bool store_status_ended(enum store_status status) {
    return status != STORE_QUEUED && status != STORE_RUNNING;
}

/* ------------------------------------------------------------------ the store itself */

void store_close(struct store *store) {
    if (!store)
        return;
    store_cache_free(store->cache);
    if (store->health.at_ms && !store_failed(store->health.answer))
        store->ops->leave(store, store->health.host.name);
    pthread_mutex_destroy(&store->health.lock);
    pthread_mutex_destroy(&store->uncommitted.lock);
    store->ops->close(store);
}

int64_t store_monotonic_us(const struct store *store) {
    return store->options.monotonic_clock ? store->options.monotonic_clock() : clock_us();
}

/* ------------------------------------------------------------------ jobs */

void store_tell(struct store *store, const char *subject) {
    job_events_notify(store->events, subject, JOB_CHANGED);
    if (store->ops->announce)
        store->ops->announce(store, subject);
}

/* What changes often, and ends nothing, is told in this process alone; others look now and then. */
static void tell_progress_here(struct store *store, const char *id) {
    job_events_notify(store->events, id, JOB_PROGRESSED);
}

int64_t store_rank(const struct store_submission *submission, int64_t now) {
    return now - submission->priority * STORE_PRIORITY_US +
           (submission->kind == STORE_STUDY ? STORE_BACKGROUND : 0);
}

/* Whether something may be submitted: what a key repeats needs no room. */
static enum store_answer ready_for(struct store *store, const struct store_submission *submission) {
    enum store_answer health = store_health(store);
    return store_failed(health) && !(health == STORE_NO_SPACE && submission->key) ? health
                                                                                  : STORE_OK;
}

enum store_answer store_submit(struct store *store, const struct store_submission *submission,
                               struct store_receipt *receipt) {
    memset(receipt, 0, sizeof *receipt);
    enum store_answer answer = ready_for(store, submission);
    if (answer == STORE_OK)
        answer = store_note(store, store->ops->submit(store, submission, receipt));
    if (answer == STORE_OK && !receipt->existing && receipt->status == STORE_QUEUED)
        store_tell(store, job_events_queue);
    return answer;
}

enum store_answer store_flush(struct store *store) {
    return store->ops->flush ? store->ops->flush(store) : STORE_OK;
}

enum store_answer store_submit_family(struct store *store, const struct store_family *family,
                                      struct store_receipt *receipt) {
    memset(receipt, 0, sizeof *receipt);
    enum store_answer answer = ready_for(store, &family->parent);
    if (answer == STORE_OK)
        answer = store_note(store, store->ops->submit_family(store, family, receipt));
    if (answer == STORE_OK && !receipt->existing)
        store_tell(store, job_events_queue);
    return answer;
}

void store_job_clear(struct store_job *job) {
    free(job->error);
    free(job->summary);
    job->error = NULL;
    job->summary = NULL;
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
        store_tell(store, id);
    return answer;
}

enum store_answer store_delete(struct store *store, const char *id) {
    enum store_answer answer = store->ops->remove(store, id);
    if (answer == STORE_OK)
        store_tell(store, id);
    return answer;
}

/* ------------------------------------------------------------------ dispatchers */

/* The job has ended, and with it perhaps the one it belongs to. */
static void tell_end(struct store *store, const struct store_claim *claim) {
    store_tell(store, claim->id);
    if (claim->parent[0])
        store_tell(store, claim->parent);
}

static void tell_claim(struct store *store, const struct store_claim *claim) {
    if (claim->reused)
        tell_end(store, claim);
    else
        tell_progress_here(store, claim->id);
}

static enum store_answer claim_some(struct store *store, bool fresh, struct store_claim *claim) {
    memset(claim, 0, sizeof *claim);
    enum store_answer answer = store->ops->claim(store, fresh, claim);
    if (answer == STORE_OK)
        tell_claim(store, claim);
    return answer;
}

enum store_answer store_claim(struct store *store, struct store_claim *claim) {
    return claim_some(store, false, claim);
}

enum store_answer store_claim_fresh(struct store *store, struct store_claim *claim) {
    return claim_some(store, true, claim);
}

enum store_answer store_starving(struct store *store, bool fresh) {
    return store->ops->starving(store, fresh);
}

enum store_answer store_renew(struct store *store, const struct store_claim *claim,
                              double progress) {
    enum store_answer answer = store->ops->renew(store, claim, progress);
    if (answer == STORE_OK)
        tell_progress_here(store, claim->id);
    return answer;
}

enum store_answer store_fail(struct store *store, const struct store_claim *claim,
                             const char *error) {
    enum store_answer answer = store->ops->fail(store, claim, error);
    if (answer == STORE_OK)
        tell_end(store, claim);
    return answer;
}

/* The others that are idle are told by those who claim (`dispatcher.c`). */
enum store_answer store_begin_round(struct store *store, const struct store_claim *claim,
                                    const struct store_round *round) {
    enum store_answer answer = store->ops->begin_round(store, claim, round);
    if (answer == STORE_OK) {
        tell_progress_here(store, claim->id);
        store_tell(store, job_events_queue);
    }
    return answer;
}

/* The study may be in the queue again: who ends a task claims next. */
enum store_answer store_end_task(struct store *store, const struct store_claim *claim,
                                 const void *numbers, size_t length, int64_t spent) {
    enum store_answer answer = store->ops->end_task(store, claim, numbers, length, spent);
    if (answer == STORE_OK)
        tell_progress_here(store, claim->parent);
    return answer;
}

enum store_answer store_change_task(struct store *store, const struct store_claim *claim,
                                    const void *task) {
    enum store_answer answer = store->ops->change_task(store, claim, task);
    if (answer == STORE_OK)
        store_tell(store, job_events_queue);
    return answer;
}

/* ------------------------------------------------------------------ results */

struct store_writer {
    struct store *store;
    struct store_claim claim;
    int64_t number; /* of the stored segments; 0 while all is in memory */
    bool committed;
    struct store_uncommitted *uncommitted; /* what is not stored yet; NULL after the commit */
};

struct store_writer *store_writer_new(struct store *store, const struct store_claim *claim) {
    struct store_writer *writer = calloc(1, sizeof *writer);
    struct store_uncommitted *uncommitted = uncommitted_new(store, claim->id);
    if (!writer || !uncommitted) {
        free(writer);
        uncommitted_close(uncommitted, 0);
        return NULL;
    }
    writer->store = store;
    writer->claim = *claim;
    writer->uncommitted = uncommitted;
    return writer;
}

static struct store_segment segment_of(const struct store_writer *writer) {
    const struct store_uncommitted *uncommitted = writer->uncommitted;
    return (struct store_segment){
        .claim = &writer->claim,
        .number = writer->number,
        .index = uncommitted->index,
        .chunks = uncommitted->chunks,
        .length = uncommitted->length,
        .total = uncommitted->index * STORE_CHUNK_BYTES + (int64_t)uncommitted->length,
    };
}

size_t segment_chunk_length(const struct store_segment *segment, size_t k) {
    size_t at = k * STORE_CHUNK_BYTES;
    size_t left = at < segment->length ? segment->length - at : 0;
    return left < STORE_CHUNK_BYTES ? left : STORE_CHUNK_BYTES;
}

int64_t segment_seal(const struct store_segment *segment, size_t k) {
    const struct seal_chunk chunk = {
        .job = segment->claim->sequence,
        .token = segment->claim->token,
        .index = segment->index + (int64_t)k,
        .last = segment->last && (k + 1) * STORE_CHUNK_BYTES >= segment->length,
    };
    return seal_of_chunk(&chunk, segment->chunks[k], segment_chunk_length(segment, k));
}

enum store_answer store_writer_append(struct store_writer *writer, const void *bytes,
                                      size_t length) {
    struct store_uncommitted *uncommitted = writer->uncommitted;
    struct store *store = writer->store;
    const unsigned char *from = bytes;
    while (length > 0) {
        if (uncommitted->length == STORE_SEGMENT_BYTES) {
            if (uncommitted->index + STORE_SEGMENT_CHUNKS >= STORE_CHUNKS_MAX)
                return STORE_DOWN;
            struct store_segment segment = segment_of(writer);
            enum store_answer answer =
                store_note(store, store->ops->result_append(store, &segment));
            if (answer != STORE_OK)
                return answer;
            writer->number = segment.number;
            uncommitted->index += STORE_SEGMENT_CHUNKS;
            uncommitted->length = 0;
        }
        unsigned char **chunk = &uncommitted->chunks[uncommitted->length / STORE_CHUNK_BYTES];
        if (!*chunk && !(*chunk = malloc(STORE_CHUNK_BYTES)))
            return STORE_DOWN;
        size_t within = uncommitted->length % STORE_CHUNK_BYTES;
        size_t room = STORE_CHUNK_BYTES - within;
        size_t taken = length < room ? length : room;
        memcpy(*chunk + within, from, taken);
        uncommitted->length += taken;
        from += taken;
        length -= taken;
    }
    return STORE_OK;
}

enum store_answer store_writer_commit_and_claim(struct store_writer *writer, const char *summary,
                                                struct store_claim *next) {
    struct store_segment segment = segment_of(writer);
    segment.summary = summary;
    segment.last = true;
    segment.next = next;
    struct store *store = writer->store;
    if (next)
        memset(next, 0, sizeof *next);
    if (segment.index == 0 && !writer->uncommitted->listed) {
        uncommitted_list(writer->uncommitted);
        job_events_notify(store->events, writer->claim.id, JOB_RESULT_READABLE);
    }
    enum store_answer answer = store_note(store, store->ops->result_commit(store, &segment));
    if (answer == STORE_OK) {
        writer->committed = true;
        uncommitted_close(writer->uncommitted, segment.number);
        writer->uncommitted = NULL;
        tell_end(writer->store, &writer->claim);
    }
    if (answer == STORE_OK && next && next->sequence)
        tell_claim(store, next);
    else if (next) /* what was undone is no claim */
        next->sequence = 0;
    return answer;
}

enum store_answer store_writer_commit(struct store_writer *writer, const char *summary) {
    return store_writer_commit_and_claim(writer, summary, NULL);
}

void store_writer_free(struct store_writer *writer) {
    if (!writer)
        return;
    if (writer->number != 0 && !writer->committed)
        /* else the sweep finds it */
        (void)!writer->store->ops->result_drop(writer->store, writer->number);
    uncommitted_close(writer->uncommitted, 0);
    free(writer);
}

/* A chunk is loaded whole: the next call is going to ask for what follows. */
enum store_answer store_result_read(struct store *store, const struct store_result *result,
                                    int64_t offset, void *bytes, size_t length) {
    for (unsigned char *to = bytes; length > 0;) {
        int64_t index = offset / STORE_CHUNK_BYTES;
        size_t within = (size_t)(offset % STORE_CHUNK_BYTES);
        size_t room = STORE_CHUNK_BYTES - within;
        size_t taken = length < room ? length : room;
        if (!store_cache_read(store->cache, result->number, index, within, to, taken)) {
            int64_t left = result->length - index * STORE_CHUNK_BYTES;
            size_t size = left < STORE_CHUNK_BYTES ? (size_t)left : STORE_CHUNK_BYTES;
            unsigned char *chunk = malloc(size);
            enum store_answer answer =
                chunk ? reads_chunk(store, result, index, chunk, size) : STORE_DOWN;
            if (answer != STORE_OK) {
                free(chunk);
                return answer;
            }
            memcpy(to, chunk + within, taken);
            store_cache_put(store->cache, result->number, index, chunk, size);
        }
        to += taken;
        offset += (int64_t)taken;
        length -= taken;
    }
    return STORE_OK;
}

/* ------------------------------------------------------------------ surfaces, materials, links */

void store_item_clear(struct store_item *item) {
    free(item->definition);
    free(item->description);
    free(item->form);
    item->form = NULL;
    item->definition = NULL;
    item->description = NULL;
}

enum store_answer store_item_put(struct store *store, enum store_item_kind kind,
                                 const struct store_item *item, bool *created) {
    return store_note(store, store->ops->item_put(store, kind, item, created));
}

enum store_answer store_form_put(struct store *store, const char *owner, const char *id,
                                 const void *form, size_t length) {
    return store_note(store, store->ops->form_put(store, owner, id, form, length));
}

void store_items_clear(struct store_items *page) {
    for (size_t k = 0; k < page->count; k++)
        store_item_clear(&page->items[k]);
    free(page->items);
    memset(page, 0, sizeof *page);
}

enum store_answer store_item_delete(struct store *store, enum store_item_kind kind,
                                    const char *owner, const char *id) {
    return store->ops->item_delete(store, kind, owner, id);
}
