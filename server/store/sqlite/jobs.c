/* SPDX-License-Identifier: MIT */
#include "server/share.h"
#include "server/store/seal.h"
#include "server/store/sql.h"
#include "sqlite.h"
#include <sodium.h>
#include <string.h>

enum { KEY_DIGEST_BYTES = 32 };

/* ------------------------------------------------------------------ submit */

struct submit {
    const struct store_submission *submission;
    const struct store_family *family; /* NULL: a job without jobs of its own */
    struct store_receipt *receipt;
    const char *owner;
    const char *surface; /* NULL without */
    int64_t now;
    unsigned char key_digest[KEY_DIGEST_BYTES];
};

/* STORE_EMPTY when the key is new. */
static enum store_answer find_key(struct db *db, struct submit *submit) {
    struct store_receipt *receipt = submit->receipt;
    struct query query =
        db_query(db, "SELECT id, status, key_digest, kind FROM jobs WHERE owner = ? AND key = ?");
    query_bind(&query, of_text(submit->owner), of_text(submit->submission->key));
    enum store_answer found = STORE_EMPTY;
    if (query_row(&query)) {
        size_t length = 0;
        const void *digest = query_bytes(&query, 2, &length);
        bool same = length == KEY_DIGEST_BYTES &&
                    !memcmp(digest, submit->key_digest, KEY_DIGEST_BYTES) &&
                    query_int(&query, 3) == (int64_t)submit->submission->kind;
        found = same ? STORE_OK : STORE_CONFLICT;
        query_copy(&query, 0, receipt->id, sizeof receipt->id);
        receipt->status = (enum store_status)query_int(&query, 1);
        receipt->existing = true;
    }
    enum store_answer answer = query_end(&query);
    return answer == STORE_OK ? found : answer;
}

static int64_t bytes_of(const struct submit *submit) {
    int64_t length = (int64_t)submit->submission->request_length;
    for (size_t k = 0; submit->family && k < submit->family->count; k++)
        length += (int64_t)submit->family->members[k].request_length;
    return length;
}

/* Whether there is room for it, among all and for its owner; `queues` jobs of it wait in the queue:
 * none when it has its result already. */
static enum store_answer find_room(struct sqlite_store *store, struct db *db, struct submit *submit,
                                   int64_t queues) {
    const struct store_quota *quota = &submit->submission->quota;
    const int64_t limit = sqlite_options(store)->queue_limit;
    int64_t waiting = 0;
    struct store_usage usage = {0};
    struct query query = db_query(db, "SELECT n, queued - tasks, results + others FROM counts"
                                      " LEFT JOIN owners ON owner = ? WHERE status = " SQL_QUEUED);
    query_bind(&query, of_text(submit->owner));
    if (query_row(&query)) {
        waiting = query_int(&query, 0);
        usage.queued = query_int(&query, 1);
        usage.bytes = query_int(&query, 2);
    }
    enum store_answer answer = query_end(&query);
    if (answer != STORE_OK)
        return answer;
    if (queues && quota->queued > 0 && usage.queued + queues > quota->queued)
        submit->receipt->full = STORE_BOUND_OWNER_QUEUED;
    else if (quota->bytes > 0 && usage.bytes + bytes_of(submit) > quota->bytes)
        submit->receipt->full = STORE_BOUND_OWNER_BYTES;
    else if (queues && waiting + queues > limit)
        submit->receipt->full = STORE_BOUND_QUEUE;
    else if (queues && !share_fits(usage.queued, waiting, limit, queues))
        submit->receipt->full = STORE_BOUND_SHARE;
    else
        return STORE_OK;
    return STORE_FULL;
}

/* With its request. `result` 0: it is to be queued; else it has succeeded. */
static enum store_answer insert_job(struct db *db, const struct submit *submit, int64_t result) {
    const struct store_submission *submission = submit->submission;
    struct query query = db_query(
        db, "INSERT INTO jobs (id, status, rank, priority, owner, digest, surface, key, key_digest,"
            " created, started, finished, progress, result, request_bytes, origin, kind, total)"
            " VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, nullif(?, 0), ?, ?, ?, ?)");
    int64_t ended = result ? submit->now : 0;
    query_bind(&query, of_text(submit->receipt->id),
               of_int(result ? STORE_SUCCEEDED : STORE_QUEUED),
               of_int(store_rank(submission, submit->now)), of_int(submission->priority),
               of_text(submit->owner), of_text(submission->digest), of_text(submit->surface),
               of_text(submission->key),
               of_bytes(submit->key_digest, submission->key ? KEY_DIGEST_BYTES : 0),
               of_int(submit->now), of_int(ended), of_int(ended), of_real(result ? 1.0 : 0.0),
               of_int(result), of_int((int64_t)submission->request_length),
               of_text(submission->origin), of_int(submission->kind), of_int(submission->total));
    enum store_answer answer = query_run(&query);
    if (answer != STORE_OK)
        return answer;
    query = db_query(db, "INSERT INTO requests (job, seal, bytes) VALUES (?, ?, ?)");
    query_bind(&query, of_int(db_last_row(db)),
               of_int(seal_of_request(submit->receipt->id, submission->request,
                                      submission->request_length)),
               of_bytes(submission->request, submission->request_length));
    return query_run(&query);
}

/* ------------------------------------------------------------------ a laminate with its drapes */

/* Its drapes are put into the queue as its own submission would be. */
static enum store_answer submit_family(struct sqlite_store *store, struct db *db,
                                       struct submit *submit) {
    enum store_answer answer = find_room(store, db, submit, (int64_t)submit->family->count);
    if (answer == STORE_OK)
        answer = insert_job(db, submit, 0);
    if (answer != STORE_OK)
        return answer;
    int64_t parent = db_last_row(db);
    struct query query = db_query(db, "UPDATE jobs SET status = " SQL_WAITING
                                      ", round = 1, started = created, open = ?, total = ?"
                                      " WHERE sequence = ?");
    query_bind(&query, of_int((int64_t)submit->family->count),
               of_int((int64_t)submit->family->count), of_int(parent));
    answer = query_run(&query);
    for (size_t k = 0; k < submit->family->count && answer == STORE_OK; k++) {
        const struct store_member *member = &submit->family->members[k];
        struct store_submission own = *submit->submission;
        struct store_receipt receipt;
        struct submit drape = *submit;
        own.kind = STORE_DRAPE;
        own.request = member->request;
        own.request_length = member->request_length;
        own.digest = member->digest;
        own.key = NULL;
        own.total = 1;
        drape.submission = &own;
        drape.receipt = &receipt;
        id_make(receipt.id);
        answer = insert_job(db, &drape, 0);
        if (answer != STORE_OK)
            break;
        query = db_query(db, "UPDATE jobs SET parent = ?, position = ? WHERE id = ?");
        query_bind(&query, of_int(parent), of_int((int64_t)k), of_text(receipt.id));
        answer = query_run(&query);
    }
    submit->receipt->status = STORE_RUNNING;
    return answer;
}

/* ------------------------------------------------------------------ either */

/* Where its owner has the complete result of its digest, it takes that: then it has succeeded. */
static enum store_answer submit_operation(struct sqlite_store *store, struct db *db,
                                          void *context) {
    struct submit *submit = context;
    const struct store_submission *submission = submit->submission;
    submit->now = sqlite_now(store);
    enum store_answer answer = submission->key ? find_key(db, submit) : STORE_EMPTY;
    if (answer != STORE_EMPTY)
        return answer;
    struct query query;
    if (submit->surface) {
        query = db_query(db, "SELECT 1 FROM surfaces WHERE id = ?");
        query_bind(&query, of_text(submit->surface));
        answer = query_find(&query, STORE_EMPTY);
        if (answer != STORE_OK)
            return answer;
    }
    if (submit->family)
        return submit_family(store, db, submit);
    query = db_query(db, "SELECT number FROM results WHERE owner = ? AND digest = ?"
                         " AND state = " SQL_COMPLETE);
    query_bind(&query, of_text(submit->owner), of_text(submission->digest));
    int64_t result = 0;
    answer = query_number(&query, STORE_OK, &result);
    if (answer == STORE_OK)
        answer = find_room(store, db, submit, result ? 0 : 1);
    if (answer == STORE_OK)
        answer = insert_job(db, submit, result);
    submit->receipt->status = result ? STORE_SUCCEEDED : STORE_QUEUED;
    return answer;
}

static enum store_answer run_submit(struct store *store, const struct store_submission *submission,
                                    const struct store_family *family,
                                    struct store_receipt *receipt) {
    const char *surface = submission->surface;
    struct submit submit = {
        .submission = submission,
        .family = family,
        .receipt = receipt,
        .owner = submission->owner ? submission->owner : "",
        .surface = surface && surface[0] ? surface : NULL,
    };
    id_make(receipt->id);
    if (submission->key)
        crypto_generichash(submit.key_digest, sizeof submit.key_digest, submission->request,
                           submission->request_length, NULL, 0);
    enum store_answer room = sqlite_room_for(store, (size_t)bytes_of(&submit));
    if (room != STORE_OK && submission->key) { /* what is there already needs no room */
        struct db *db = sqlite_take_reader(store);
        enum store_answer known = sqlite_give_reader(store, db, find_key(db, &submit));
        return known == STORE_EMPTY ? room : known;
    }
    if (room != STORE_OK)
        return room;
    return sqlite_write(store, submission->unpromised ? DB_LAZY : DB_DURABLE, submit_operation,
                        &submit);
}

enum store_answer sqlite_submit(struct store *store, const struct store_submission *submission,
                                struct store_receipt *receipt) {
    return run_submit(store, submission, NULL, receipt);
}

enum store_answer sqlite_submit_family(struct store *store, const struct store_family *family,
                                       struct store_receipt *receipt) {
    return run_submit(store, &family->parent, family, receipt);
}

/* ------------------------------------------------------------------ ending by the caller */

static enum store_answer cancel_operation(struct sqlite_store *store, struct db *db,
                                          void *context) {
    const char *id = context;
    struct query query = db_query(db, "UPDATE jobs SET status = " SQL_CANCELLED
                                      ", finished = ?, lease = NULL, holder = NULL"
                                      " WHERE id = ? AND status < " SQL_FIRST_ENDED);
    query_bind(&query, of_int(sqlite_now(store)), of_text(id));
    enum store_answer answer = db_change(&query, STORE_EMPTY);
    if (answer != STORE_EMPTY)
        return answer;
    query = db_query(db, "SELECT 1 FROM jobs WHERE id = ?");
    query_bind(&query, of_text(id));
    answer = query_find(&query, STORE_EMPTY);
    return answer == STORE_OK ? STORE_CONFLICT : answer;
}

enum store_answer sqlite_cancel(struct store *store, const char *id) {
    return sqlite_write(store, DB_DURABLE, cancel_operation, (void *)(uintptr_t)id);
}

static enum store_answer remove_operation(struct sqlite_store *store, struct db *db,
                                          void *context) {
    (void)store;
    struct query query = db_query(db, "SELECT sequence, result FROM jobs WHERE id = ?");
    query_bind(&query, of_text(context));
    bool known = query_row(&query);
    int64_t sequence = known ? query_int(&query, 0) : 0;
    int64_t result = known ? query_int(&query, 1) : 0;
    enum store_answer answer = query_end_found(&query, known, STORE_EMPTY);
    if (answer == STORE_OK)
        answer = db_run_with(db, "DELETE FROM requests WHERE job = ?", sequence);
    if (answer == STORE_OK)
        answer = db_run_with(db, "DELETE FROM jobs WHERE sequence = ?", sequence);
    return answer == STORE_OK && result ? sqlite_result_forget(db, result) : answer;
}

enum store_answer sqlite_remove(struct store *store, const char *id) {
    return sqlite_write(store, DB_DURABLE, remove_operation, (void *)(uintptr_t)id);
}
