/* SPDX-License-Identifier: MIT */
#include "reads.h"
#include "backend.h"
#include "seal.h"
#include "server/clock.h"
#include "server/log.h"
#include "server/metrics.h"
#include "sql.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static struct query begin_read(const struct store *store, const char *sql) {
    return store->reader.query(store->reader.of, sql);
}

/* ------------------------------------------------------------------ seals */

/* Says so once for each look at a thing that is not what was written. STORE_ALTERED. */
static enum store_answer say_altered(const char *what, const char *id) {
    metrics_store_altered();
    log_error(log_event("store_altered"), log_text("what", what), log_text("id", id));
    return STORE_ALTERED;
}

/* Whether the text in a column is that which the next column is the seal of. */
static bool text_is_sealed(const struct query *query, int column) {
    const char *text = query_text(query, column);
    return query_is_null(query, column + 1) ? !text
                                            : query_int(query, column + 1) == seal_of_text(text);
}

/* ------------------------------------------------------------------ jobs */

/* A result has the digest and the owner of its job. */
#define JOB_COLUMNS                                                                                \
    "j.sequence, j.id, j.status, j.progress, j.created, j.started, j.finished, j.attempts,"        \
    " j.priority, j.expired, j.owner, j.surface, j.digest, j.kind, j.done, j.total, j.position,"   \
    " j.round, j.error, j.error_seal, coalesce(r.summary, j.summary),"                             \
    " coalesce(r.summary_seal, j.summary_seal)"                                                    \
    " FROM draped.jobs j LEFT JOIN draped.results r ON r.number = j.result"

/* Between two steps a study has no attempt, though it is at its first; what has begun a round is
 * running until it ends, and is as far as its parts. */
static void read_job(struct query *query, struct store_job *job) {
    enum { ROUND = 17, ERROR, SUMMARY = ERROR + 2 };
    int64_t status = query_int(query, 2), round = query_int(query, ROUND);
    bool begun = round > 0 && status < STORE_SUCCEEDED;
    job->sequence = query_int(query, 0);
    query_copy(query, 1, job->id, sizeof job->id);
    job->status = begun ? STORE_RUNNING : (enum store_status)status;
    job->progress = query_real(query, 3);
    job->created = query_int(query, 4);
    job->started = query_int(query, 5);
    job->finished = query_int(query, 6);
    job->attempts = (int)query_int(query, 7);
    job->priority = (int)query_int(query, 8);
    job->expired = query_int(query, 9) != 0;
    query_copy(query, 10, job->owner, sizeof job->owner);
    query_copy(query, 11, job->surface, sizeof job->surface);
    query_copy(query, 12, job->digest, sizeof job->digest);
    job->kind = (enum store_kind)query_int(query, 13);
    job->done = query_int(query, 14);
    job->total = query_int(query, 15);
    job->position = query_int(query, 16);
    job->altered = !text_is_sealed(query, ERROR) || !text_is_sealed(query, SUMMARY);
    if (job->altered)
        (void)say_altered(store_kind_name(job->kind), job->id);
    if (!job->altered) {
        query_duplicate(query, ERROR, &job->error, NULL);
        query_duplicate(query, SUMMARY, &job->summary, NULL);
    }
    if (round > 0 && job->attempts == 0)
        job->attempts = 1;
    if (begun)
        job->progress = job->total > job->done ? (double)job->done / (double)job->total : 1;
}

enum store_answer store_get(struct store *store, const char *id, struct store_job *job) {
    memset(job, 0, sizeof *job);
    struct query query = begin_read(store, "SELECT " JOB_COLUMNS " WHERE j.id = $1");
    query_bind(&query, of_text(id));
    bool found = query_row(&query);
    if (found)
        read_job(&query, job);
    return query_end_found(&query, found, STORE_EMPTY);
}

enum store_answer store_request(struct store *store, const char *id, char **bytes, size_t *length) {
    *bytes = NULL;
    *length = 0;
    struct query query = begin_read(store, "SELECT q.bytes, q.seal FROM draped.jobs j"
                                           " JOIN draped.requests q ON q.job = j.sequence"
                                           " WHERE j.id = $1");
    query_bind(&query, of_text(id));
    bool found = query_row(&query), sound = true;
    if (found) {
        const void *stored = query_bytes(&query, 0, length);
        sound = query_int(&query, 1) == seal_of_request(id, stored, *length);
    }
    if (found && sound)
        query_duplicate(&query, 0, bytes, length);
    enum store_answer answer = query_end_found(&query, found, STORE_EMPTY);
    return answer == STORE_OK && !sound ? say_altered("request", id) : answer;
}

/* The jobs of a statement, up to `limit`, into the page; one more tells that there is a next page.
 */
static enum store_answer read_page(struct query *query, size_t limit, struct store_page *page) {
    bool memory = true;
    while (query_row(query)) {
        if (page->count == limit) {
            page->next = page->jobs[limit - 1].sequence;
            break;
        }
        if ((page->count & (page->count - 1)) == 0) { /* there is room up to a power of two */
            void *more =
                realloc(page->jobs, (page->count ? 2 * page->count : 1) * sizeof *page->jobs);
            memory = more != NULL;
            if (!memory)
                break;
            page->jobs = more;
        }
        memset(&page->jobs[page->count], 0, sizeof *page->jobs);
        read_job(query, &page->jobs[page->count++]);
    }
    enum store_answer answer = query_end(query);
    return memory ? answer : STORE_DOWN;
}

enum store_answer store_members(struct store *store, const char *id, struct store_page *page) {
    memset(page, 0, sizeof *page);
    struct query query = begin_read(
        store, "SELECT " JOB_COLUMNS " WHERE j.parent = (SELECT sequence FROM draped.jobs"
               " WHERE id = $1 AND kind = " SQL_LAMINATE ") ORDER BY j.position");
    query_bind(&query, of_text(id));
    return read_page(&query, SIZE_MAX, page);
}

#define LIST_OF(which, limit)                                                                      \
    "SELECT " JOB_COLUMNS " WHERE j.sequence < $1 AND " which                                      \
    " ORDER BY j.sequence DESC LIMIT " limit

enum store_answer store_list(struct store *store, const struct store_filter *filter,
                             struct store_page *page) {
    int64_t cursor = cursor_open(store->secret, filter->owner, filter->cursor);
    const bool some = filter->has_status;
    memset(page, 0, sizeof *page);
    /* A statement each, so that it has the index it needs: the + keeps one of all drapes out. */
    const char *sql =
        some ? LIST_OF("j.kind = $2 AND j.status = $3", "$4") : LIST_OF("+j.kind = $2", "$3");
    if (filter->owner)
        sql = some ? LIST_OF("j.kind = $2 AND j.owner = $3 AND $4 = " SQL_SHOWN, "$5")
                   : LIST_OF("j.kind = $2 AND j.owner = $3", "$4");
    else if (filter->kind != STORE_DRAPE)
        sql = some ? LIST_OF("j.kind > 0 AND j.kind = $2 AND $3 = " SQL_SHOWN, "$4")
                   : LIST_OF("j.kind > 0 AND j.kind = $2", "$3");
    struct query query = begin_read(store, sql);
    query_bind(&query, of_int(cursor > 0 ? cursor : INT64_MAX), of_int(filter->kind));
    if (filter->owner)
        query_bind(&query, of_text(filter->owner));
    if (filter->has_status)
        query_bind(&query, of_int(filter->status));
    query_bind(&query, of_int(filter->limit + 1));
    enum store_answer answer = read_page(&query, (size_t)filter->limit, page);
    page->next = cursor_seal(store->secret, filter->owner, page->next);
    return answer;
}

/* ------------------------------------------------------------------ numbers */

enum store_answer reads_counts(const struct reader *reader, int64_t now,
                               struct store_counts *counts) {
    memset(counts, 0, sizeof *counts);
    struct query query = reader->query(reader->of, reader->dialect->counts);
    while (query_row(&query)) {
        int64_t number = query_int(&query, 0), n = query_int(&query, 1);
        if (number >= 0 && number < STORE_STATUS_COUNT)
            counts->jobs[number] = n;
        else if (number == 8 || number == 9)
            counts->tasks[number - 8] = n;
        else if (number >= 10 && number < 10 + STORE_STATUS_COUNT)
            counts->ended[number - 10] = n;
        else if (number == 15)
            counts->crashed = n;
    }
    enum store_answer answer = query_end(&query);
    if (answer != STORE_OK)
        return answer;
    query = reader->query(reader->of, reader->dialect->hosts);
    query_bind(&query, now ? of_int(now) : of_no_int(), of_int(STORE_SEEN_US));
    if (query_row(&query)) {
        counts->hosts = query_int(&query, 0);
        counts->workers = query_int(&query, 1);
        counts->busy = query_int(&query, 2);
    }
    answer = query_end(&query);
    if (answer != STORE_OK)
        return answer;
    query = reader->query(
        reader->of,
        "SELECT min(created) FROM (SELECT * FROM (SELECT created FROM draped.jobs"
        " WHERE kind = " SQL_DRAPE " AND status = " SQL_QUEUED " ORDER BY sequence LIMIT 1) drapes"
        " UNION ALL SELECT * FROM (SELECT created FROM draped.jobs WHERE kind = " SQL_STUDY
        " AND status = " SQL_QUEUED " AND round = 0 ORDER BY sequence LIMIT 1) studies) oldest");
    return query_number(&query, STORE_OK, &counts->oldest_queued);
}

enum store_answer store_counts(struct store *store, struct store_counts *counts) {
    int64_t now = store->options.clock ? store->options.clock() : 0;
    return reads_counts(&store->reader, now || store->ops->wall_leases ? now : clock_utc_us(),
                        counts);
}

enum store_answer store_usage(struct store *store, const char *owner, struct store_usage *usage) {
    memset(usage, 0, sizeof *usage);
    struct query query =
        begin_read(store, "SELECT CAST(coalesce(sum(queued - tasks), 0) AS bigint),"
                          " CAST(coalesce(sum(running), 0) AS bigint),"
                          " CAST(coalesce(sum(results + others), 0) AS bigint)"
                          " FROM draped.owners WHERE owner = $1");
    query_bind(&query, of_text(owner));
    if (query_row(&query)) {
        usage->queued = query_int(&query, 0);
        usage->running = query_int(&query, 1);
        usage->bytes = query_int(&query, 2);
    }
    return query_end(&query);
}

/* ------------------------------------------------------------------ claims */

void reads_claim(const struct query *query, struct store_claim *claim, int64_t *result) {
    claim->sequence = query_int(query, 0);
    query_copy(query, 1, claim->id, sizeof claim->id);
    query_copy(query, 2, claim->surface, sizeof claim->surface);
    claim->token = query_int(query, 3);
    claim->attempts = (int)query_int(query, 4);
    *result = query_int(query, 5);
    query_copy(query, 6, claim->owner, sizeof claim->owner);
    query_copy(query, 7, claim->origin, sizeof claim->origin);
    claim->kind = (enum store_kind)query_int(query, 8);
    claim->spent = query_int(query, 9);
    const void *task = query_bytes(query, 10, &claim->task_length);
    if (task && claim->task_length <= sizeof claim->task)
        memcpy(claim->task, task, claim->task_length);
    query_copy(query, 11, claim->parent, sizeof claim->parent);
    claim->waited_us = query_int(query, 12);
}

enum store_answer reads_attempts(struct store *store, const struct store_claim *claim,
                                 int64_t *attempts, int64_t *excused) {
    struct query query =
        begin_read(store, "SELECT attempts, excused FROM draped.jobs"
                          " WHERE sequence = $1 AND token = $2 AND status = " SQL_RUNNING);
    query_bind(&query, of_int(claim->sequence), of_int(claim->token));
    bool holds = query_row(&query);
    *attempts = holds ? query_int(&query, 0) : 0;
    *excused = holds ? query_int(&query, 1) : 0;
    return query_end_found(&query, holds, STORE_CONFLICT);
}

enum store_answer store_check(struct store *store, const struct store_claim *claim) {
    int64_t attempts, excused;
    return reads_attempts(store, claim, &attempts, &excused);
}

enum store_answer store_numbers(struct store *store, const struct store_claim *claim, void **bytes,
                                size_t *length) {
    char *all = malloc(1);
    size_t room = 1;
    bool sound = true;
    *length = 0;
    struct query query =
        begin_read(store, "SELECT bytes, seal FROM draped.task_numbers WHERE parent = $1"
                          " ORDER BY round, position");
    query_bind(&query, of_int(claim->sequence));
    while (all && query_row(&query)) {
        size_t count = 0;
        const void *more = query_bytes(&query, 0, &count);
        sound = sound && query_int(&query, 1) == seal_of_numbers(claim->id, more, count);
        if (*length + count > room) {
            room = 2 * (*length + count);
            char *grown = realloc(all, room);
            if (!grown)
                free(all);
            all = grown;
        }
        if (all && count > 0)
            memcpy(all + *length, more, count);
        *length += count;
    }
    *bytes = all;
    enum store_answer answer = query_end(&query);
    if (answer == STORE_OK && !sound)
        return say_altered("numbers", claim->id);
    return all ? answer : STORE_DOWN;
}

/* ------------------------------------------------------------------ results */

/* Results that were found altered, so that a caller learns of it before the first byte. */
static void altered_note(struct store *store, int64_t number) {
    struct store_altered *altered = &store->altered;
    atomic_store(&altered->results[atomic_fetch_add(&altered->next, 1) % STORE_ALTERED_KEPT],
                 number);
}

static bool altered_known(struct store *store, int64_t number) {
    bool known = false;
    for (int k = 0; k < STORE_ALTERED_KEPT; k++)
        known = known || atomic_load(&store->altered.results[k]) == number;
    return known;
}

enum store_answer store_result_find(struct store *store, const char *id,
                                    struct store_result *result) {
    struct query query =
        begin_read(store, "SELECT r.number, r.length, r.job, r.token,"
                          " r.owner = j.owner AND r.digest = j.digest"
                          " FROM draped.jobs j JOIN draped.results r ON r.number = j.result"
                          " WHERE j.id = $1 AND r.state = " SQL_COMPLETE);
    query_bind(&query, of_text(id));
    bool found = query_row(&query), sound = true;
    if (found) {
        snprintf(result->id, sizeof result->id, "%s", id);
        result->number = query_int(&query, 0);
        result->length = query_int(&query, 1);
        result->job = query_int(&query, 2);
        result->token = query_int(&query, 3);
        sound = query_int(&query, 4) != 0 && result->length > 0 &&
                !altered_known(store, result->number);
    }
    enum store_answer answer = query_end_found(&query, found, STORE_EMPTY);
    return answer == STORE_OK && !sound ? say_altered("result", id) : answer;
}

/* A chunk that is not there belongs to a result that has been removed, or it is lost. */
enum store_answer reads_chunk(struct store *store, const struct store_result *result, int64_t index,
                              void *bytes, size_t length) {
    const struct seal_chunk chunk = {
        .job = result->job,
        .token = result->token,
        .index = index,
        .last = (index + 1) * STORE_CHUNK_BYTES >= result->length,
    };
    size_t stored = 0;
    struct query query = begin_read(store, store->reader.dialect->chunk);
    query_bind(&query, of_int(result->number), of_int(index));
    bool found = query_row(&query);
    const void *from = found ? query_bytes(&query, 0, &stored) : NULL;
    bool sound =
        from && stored == length && query_int(&query, 1) == seal_of_chunk(&chunk, from, length);
    if (sound)
        memcpy(bytes, from, length);
    enum store_answer answer = query_end(&query);
    if (answer != STORE_OK || sound)
        return answer;
    query = begin_read(store, "SELECT 1 FROM draped.results WHERE number = $1"
                              " AND state = " SQL_COMPLETE);
    query_bind(&query, of_int(result->number));
    answer = query_find(&query, STORE_EMPTY);
    if (answer != STORE_OK)
        return answer;
    altered_note(store, result->number);
    return say_altered("result", result->id);
}

/* ------------------------------------------------------------------ surfaces, materials, links */

#define ITEM_COLUMNS "SELECT sequence, id, owner, created, description"

/* A statement for each kind of item, whose tables have the same columns. */
#define OF_KIND(columns, which)                                                                    \
    (const char *const[]){columns " FROM draped.surfaces WHERE " which,                            \
                          columns " FROM draped.materials WHERE " which,                           \
                          columns " FROM draped.links WHERE " which}[kind]

static void read_item(struct query *query, struct store_item *item) {
    item->sequence = query_int(query, 0);
    query_copy(query, 1, item->id, sizeof item->id);
    query_copy(query, 2, item->owner, sizeof item->owner);
    item->created = query_int(query, 3);
    query_duplicate(query, 4, &item->description, NULL);
}

enum store_answer store_item_get(struct store *store, enum store_item_kind kind, const char *owner,
                                 const char *id, struct store_item *item) {
    memset(item, 0, sizeof *item);
    struct query query =
        begin_read(store, OF_KIND(ITEM_COLUMNS ", definition, seal",
                                  "id = $1 AND ($2 IS NULL OR owner = $2) LIMIT 1"));
    query_bind(&query, of_text(id), of_text(owner));
    bool found = query_row(&query), sound = true;
    if (found) {
        read_item(&query, item);
        query_duplicate(&query, 5, &item->definition, &item->definition_length);
        sound = query_int(&query, 6) == seal_of_item(item);
    }
    enum store_answer answer = query_end_found(&query, found, STORE_EMPTY);
    if (answer != STORE_OK || sound)
        return answer;
    store_item_clear(item);
    return say_altered(store_item_kind_name(kind), id);
}

enum store_answer store_form_get(struct store *store, const char *owner, const char *id,
                                 char **form, size_t *length) {
    struct query query = begin_read(
        store, form
                   ? "SELECT form FROM draped.surfaces WHERE id = $1 AND ($2 IS NULL OR owner = $2)"
                     " ORDER BY coalesce(length(form), 0) DESC LIMIT 1"
                   : "SELECT 1 FROM draped.surfaces WHERE id = $1 AND ($2 IS NULL OR owner = $2)"
                     " LIMIT 1");
    query_bind(&query, of_text(id), of_text(owner));
    bool found = query_row(&query);
    if (found && form)
        query_duplicate(&query, 0, form, length);
    return query_end_found(&query, found, STORE_EMPTY);
}

enum store_answer store_item_list(struct store *store, enum store_item_kind kind, const char *owner,
                                  int64_t cursor, int limit, struct store_items *page) {
    memset(page, 0, sizeof *page);
    cursor = cursor_open(store->secret, owner, cursor);
    page->items = calloc((size_t)limit, sizeof *page->items);
    if (!page->items)
        return STORE_DOWN;
    struct query query = begin_read(
        store, owner ? OF_KIND(ITEM_COLUMNS,
                               "owner = $1 AND sequence < $2 ORDER BY sequence DESC LIMIT $3")
                     : OF_KIND(ITEM_COLUMNS,
                               "$1 IS NULL AND sequence < $2 ORDER BY sequence DESC LIMIT $3"));
    query_bind(&query, of_text(owner), of_int(cursor > 0 ? cursor : INT64_MAX),
               of_int((int64_t)limit + 1));
    while (query_row(&query)) {
        if (page->count == (size_t)limit) {
            page->next = cursor_seal(store->secret, owner, page->items[limit - 1].sequence);
            break;
        }
        read_item(&query, &page->items[page->count++]);
    }
    return query_end(&query);
}

/* ------------------------------------------------------------------ the key of cursors */

enum store_answer reads_secret(struct store *store, unsigned char secret[CURSOR_SECRET_BYTES]) {
    size_t length = 0;
    struct query query = begin_read(store, "SELECT bytes FROM draped.secret");
    const void *bytes = query_row(&query) ? query_bytes(&query, 0, &length) : NULL;
    bool good = bytes && length == CURSOR_SECRET_BYTES;
    if (good)
        memcpy(secret, bytes, length);
    return query_end_found(&query, good, STORE_DAMAGED);
}
