/* SPDX-License-Identifier: MIT */
#include "server/store/seal.h"
#include "server/store/sql.h"
#include "sqlite.h"

enum { PACE_CHUNKS = 64 }; /* of a result, 4 MiB, that go to the disk together */

/* ------------------------------------------------------------------ writing */

static enum store_answer insert_chunks(struct db *db, const struct store_segment *segment) {
    enum store_answer answer = STORE_OK;
    int64_t row = segment->number * STORE_CHUNKS_MAX + segment->index;
    for (size_t k = 0; segment_chunk_length(segment, k) > 0 && answer == STORE_OK; k++) {
        struct query query = db_query(db, "INSERT INTO chunks (id, seal, bytes) VALUES (?, ?, ?)");
        query_bind(&query, of_int(row++), of_int(segment_seal(segment, k)),
                   of_bytes(segment->chunks[k], segment_chunk_length(segment, k)));
        answer = query_run(&query);
    }
    return answer;
}

/* A result of the claim's job, which must still be running under it. */
static enum store_answer insert_result(struct db *db, struct store_segment *segment, int state) {
    struct query query =
        db_query(db, "INSERT INTO results"
                     " (owner, digest, state, job, token, length, summary, summary_seal)"
                     " SELECT owner, digest, ?, sequence, token, ?, ?, ? FROM jobs"
                     " WHERE sequence = ? AND token = ? AND status = " SQL_RUNNING);
    query_bind(&query, of_int(state), of_int(segment->total), of_text(segment->summary),
               of_int(seal_of_text(segment->summary)), of_int(segment->claim->sequence),
               of_int(segment->claim->token));
    enum store_answer answer = db_change(&query, STORE_CONFLICT);
    segment->number = db_last_row(db);
    return answer;
}

/* Between two segments the result may have been given up (its job cancelled, say). */
static enum store_answer append_operation(struct sqlite_store *store, struct db *db,
                                          void *context) {
    (void)store;
    struct store_segment *segment = context;
    enum store_answer answer;
    if (segment->index == 0) {
        answer = insert_result(db, segment, RESULT_BUILDING);
    } else {
        struct query query = db_query(
            db, "SELECT 1 FROM results r JOIN jobs j ON j.sequence = r.job AND j.token = r.token"
                " WHERE r.number = ? AND r.state = " SQL_BUILDING " AND j.status = " SQL_RUNNING);
        query_bind(&query, of_int(segment->number));
        answer = query_find(&query, STORE_CONFLICT);
    }
    return answer == STORE_OK ? insert_chunks(db, segment) : answer;
}

/* Small results are not worth a wait of their own. */
enum store_answer sqlite_result_append(struct store *store, struct store_segment *segment) {
    int64_t end = segment->index + (int64_t)(segment->length / STORE_CHUNK_BYTES);
    enum store_answer answer = sqlite_room_for(store, segment->length);
    if (answer == STORE_OK)
        answer = sqlite_write(store, DB_LAZY, append_operation, segment);
    if (answer == STORE_OK && end / PACE_CHUNKS > segment->index / PACE_CHUNKS)
        answer = sqlite_pace(store, PACE_CHUNKS * STORE_CHUNK_BYTES);
    return answer;
}

/* Makes the result whole, or drops it for a twin that was first. Whoever ends a job is going to
 * claim the next: that changes the same pages, which are then written once. */
static enum store_answer commit_operation(struct sqlite_store *store, struct db *db,
                                          void *context) {
    struct store_segment *segment = context;
    struct query query =
        db_query(db, "SELECT r.number FROM jobs j JOIN results r ON r.owner = j.owner AND"
                     " r.digest = j.digest AND r.state = " SQL_COMPLETE " WHERE j.sequence = ?");
    query_bind(&query, of_int(segment->claim->sequence));
    int64_t number = 0;
    enum store_answer answer = query_number(&query, STORE_OK, &number);
    if (answer != STORE_OK)
        return answer;
    if (number != 0) {
        if (segment->number)
            answer = db_run_with(db, "UPDATE results SET state = " SQL_DOOMED " WHERE number = ?",
                                 segment->number);
        segment->number = 0;
    } else {
        if (segment->number) {
            query =
                db_query(db, "UPDATE results SET state = " SQL_COMPLETE ", length = ?, summary = ?,"
                             " summary_seal = ? WHERE number = ? AND state = " SQL_BUILDING);
            query_bind(&query, of_int(segment->total), of_text(segment->summary),
                       of_int(seal_of_text(segment->summary)), of_int(segment->number));
            answer = db_change(&query, STORE_CONFLICT);
        } else {
            answer = insert_result(db, segment, RESULT_COMPLETE);
        }
        number = segment->number;
        if (answer == STORE_OK)
            answer = insert_chunks(db, segment);
    }
    if (answer != STORE_OK)
        return answer;
    query = db_query(
        db,
        "UPDATE jobs SET status = " SQL_SUCCEEDED ", progress = 1, finished = ?, result = ?,"
        " lease = NULL, holder = NULL WHERE sequence = ? AND token = ? AND status = " SQL_RUNNING);
    query_bind(&query, of_int(sqlite_now(store)), of_int(number), of_int(segment->claim->sequence),
               of_int(segment->claim->token));
    answer = db_change(&query, STORE_CONFLICT);
    return answer == STORE_OK && segment->next ? sqlite_claim_too(store, db, segment->next)
                                               : answer;
}

enum store_answer sqlite_result_commit(struct store *store, struct store_segment *segment) {
    enum store_answer room = sqlite_room_for(store, segment->length);
    return room == STORE_OK ? sqlite_write(store, DB_DURABLE, commit_operation, segment) : room;
}

enum store_answer sqlite_result_drop(struct store *store, int64_t number) {
    struct query query = {.sql = "UPDATE results SET state = " SQL_DOOMED " WHERE number = ?"};
    query_bind(&query, of_int(number));
    return sqlite_change(store, DB_LAZY, &query, STORE_OK);
}

enum store_answer sqlite_result_forget(struct db *db, int64_t number) {
    return db_run_with(db,
                       "UPDATE results SET state = " SQL_DOOMED " WHERE number = ?1"
                       " AND NOT EXISTS (SELECT 1 FROM jobs WHERE result = ?1)",
                       number);
}
