/* SPDX-License-Identifier: MIT */
#include "postgres.h"
#include "server/store/sql.h"
#include <stdlib.h>
#include <string.h>

enum { COMMIT_TRIES = 3 };

/* ------------------------------------------------------------------ writing */

/* The segment travels as one value and is cut by the server. $4: index of the first chunk, $5: the
 * bytes; `result` is a row with a `number`. A statement that runs once more finds its chunks. */
#define STORE_CHUNKS(result)                                                                       \
    " stored AS (INSERT INTO draped.chunks (result, index, bytes)"                                 \
    " SELECT number, $4 + i, substring($5 FROM i * 65536 + 1 FOR 65536) FROM " result ","          \
    " generate_series(0, (octet_length($5) + 65535) / 65536 - 1) i ON CONFLICT DO NOTHING)"

_Static_assert(STORE_CHUNK_BYTES == 65536, "as in STORE_CHUNKS");

#define HELD " sequence = $2 AND token = $3 AND status = " SQL_RUNNING

static const char append_first_sql[] =
    "WITH made AS (INSERT INTO draped.results (owner, digest, state, job, token, length)"
    " SELECT owner, digest, " SQL_BUILDING
    ", sequence, token, 0 FROM draped.jobs WHERE $1::bigint IS NOT NULL AND" HELD
    " RETURNING number)," STORE_CHUNKS("made") " SELECT number, " POSTGRES_LAZY " FROM made";

/* Between two segments the result may have been given up (its job cancelled, say). */
static const char append_sql[] =
    "WITH building AS (SELECT r.number FROM draped.results r"
    " JOIN draped.jobs j ON j.sequence = r.job AND j.token = r.token"
    " WHERE r.number = $1 AND r.state = " SQL_BUILDING
    " AND j.sequence = $2 AND j.token = $3 AND j.status = "
    "1)," STORE_CHUNKS("building") " SELECT number, " POSTGRES_LAZY " FROM building";

#define END_JOB(number)                                                                            \
    "UPDATE draped.jobs SET status = " SQL_SUCCEEDED ", progress = 1, finished = " POSTGRES_NOW    \
    ","                                                                                            \
    " result = " number ", lease = NULL"

/* The job ends, and only if it does, its result is made. */
static const char commit_new_sql[] =
    "WITH fresh AS MATERIALIZED (SELECT draped.next_number() AS number),"
    " ended AS (" END_JOB(
        "fresh.number") " FROM fresh WHERE" HELD
                        "  RETURNING sequence, token, owner, digest, fresh.number),"
                        " made AS (INSERT INTO draped.results"
                        "  (number, owner, digest, state, job, token, length, summary)"
                        "  SELECT number, owner, digest, " SQL_COMPLETE
                        ", sequence, token, $6, $7 FROM ended"
                        "  RETURNING number)," STORE_CHUNKS("made") " SELECT number FROM made";

static const char commit_begun_sql[] =
    "WITH begun AS MATERIALIZED (SELECT number FROM draped.results WHERE number = $8"
    "  AND state = " SQL_BUILDING " FOR UPDATE),"
    " ended AS (" END_JOB(
        "begun.number") " FROM begun WHERE" HELD " RETURNING begun.number),"
                        " made AS (UPDATE draped.results r SET state = " SQL_COMPLETE
                        ", length = $6, summary = $7"
                        "  FROM ended WHERE r.number = ended.number RETURNING "
                        "r.number)," STORE_CHUNKS("made") " SELECT number FROM made";

static const char commit_twin_sql[] =
    "WITH twin AS MATERIALIZED (SELECT r.number FROM draped.jobs j JOIN draped.results r"
    " ON r.owner = j.owner AND r.digest = j.digest AND r.state = " SQL_COMPLETE
    " WHERE j.sequence = $2 FOR SHARE OF r) " END_JOB("twin.number") " FROM twin WHERE" HELD
                                                                     " RETURNING 1";

/* The segment in one piece, malloc'ed. */
static unsigned char *join(const struct store_segment *segment) {
    unsigned char *bytes = malloc(segment->length + 1);
    for (size_t at = 0; at < segment->length && bytes; at += STORE_CHUNK_BYTES) {
        size_t left = segment->length - at;
        memcpy(bytes + at, segment->chunks[at / STORE_CHUNK_BYTES],
               left < STORE_CHUNK_BYTES ? left : STORE_CHUNK_BYTES);
    }
    return bytes;
}

static void bind_segment(struct pg_query *query, const struct store_segment *segment,
                         const unsigned char *bytes) {
    pg_bind_int(query, segment->claim->sequence);
    pg_bind_int(query, segment->claim->token);
    pg_bind_int(query, segment->index);
    pg_bind_bytes(query, bytes, segment->length);
}

enum store_answer postgres_result_append(struct store *store, struct store_segment *segment) {
    unsigned char *bytes = join(segment);
    if (!bytes)
        return STORE_DOWN;
    struct pg_query query = postgres_query(store, segment->index ? append_sql : append_first_sql);
    pg_bind_int(&query, segment->number);
    bind_segment(&query, segment, bytes);
    size_t rows = pg_run(&query);
    if (rows)
        segment->number = pg_int(&query, 0, 0);
    free(bytes);
    return postgres_end(&query, rows, STORE_CONFLICT);
}

/* `*taken`: there is a result of that digest. */
static enum store_answer commit_own(struct store *store, struct store_segment *segment,
                                    const unsigned char *bytes, bool *taken) {
    struct pg_query query =
        postgres_query_now(store, segment->number ? commit_begun_sql : commit_new_sql);
    bind_segment(&query, segment, bytes);
    pg_bind_int(&query, segment->total);
    pg_bind_text(&query, segment->summary);
    if (segment->number)
        pg_bind_int(&query, segment->number);
    size_t rows = pg_run(&query);
    if (rows)
        segment->number = pg_int(&query, 0, 0);
    *taken = query.taken;
    return postgres_end(&query, rows, STORE_CONFLICT);
}

static enum store_answer commit_twin(struct store *store, struct store_segment *segment) {
    struct pg_query query = postgres_query_now(store, commit_twin_sql);
    pg_bind_int(&query, segment->claim->sequence);
    pg_bind_int(&query, segment->claim->token);
    enum store_answer answer = postgres_end(&query, pg_run(&query), STORE_CONFLICT);
    if (answer != STORE_OK)
        return answer;
    if (segment->number)
        (void)!postgres_result_drop(store, segment->number); /* else the sweep finds it */
    segment->number = 0;
    return STORE_OK;
}

/* A twin that was there may be gone when it is to be taken: then the own result is stored. */
enum store_answer postgres_result_commit(struct store *store, struct store_segment *segment) {
    unsigned char *bytes = join(segment);
    enum store_answer answer = bytes ? STORE_CONFLICT : STORE_DOWN;
    for (int k = 0; k < COMMIT_TRIES && answer == STORE_CONFLICT; k++) {
        bool taken = false;
        answer = commit_own(store, segment, bytes, &taken);
        if (answer == STORE_CONFLICT && !taken)
            break;
        if (taken)
            answer = commit_twin(store, segment);
    }
    free(bytes);
    return answer;
}

/* Not one that was committed after all, by a statement whose answer was lost. */
enum store_answer postgres_result_drop(struct store *store, int64_t number) {
    struct pg_query query = postgres_query(store, "UPDATE draped.results SET state = " SQL_DOOMED
                                                  " WHERE number = $1 AND state = " SQL_BUILDING
                                                  " RETURNING " POSTGRES_LAZY);
    pg_bind_int(&query, number);
    pg_run(&query);
    return pg_end(&query);
}

/* ------------------------------------------------------------------ reading */

enum store_answer postgres_result_find(struct store *store, const char *id,
                                       struct store_result *result) {
    struct pg_query query = postgres_query(
        store, "SELECT r.number, r.length FROM draped.jobs j JOIN draped.results r"
               " ON r.number = j.result WHERE j.id = $1 AND r.state = " SQL_COMPLETE);
    pg_bind_text(&query, id);
    size_t rows = pg_run(&query);
    if (rows) {
        result->number = pg_int(&query, 0, 0);
        result->length = pg_int(&query, 0, 1);
    }
    return postgres_end(&query, rows, STORE_EMPTY);
}

enum store_answer postgres_result_read(struct store *store, int64_t number, int64_t index,
                                       void *bytes, size_t length) {
    struct pg_query query = postgres_query(
        store, "SELECT bytes FROM draped.chunks WHERE result = $1 AND index = $2::integer");
    pg_bind_int(&query, number);
    pg_bind_int(&query, index);
    size_t rows = pg_run(&query);
    size_t found = 0;
    const void *from = rows ? pg_bytes(&query, 0, 0, &found) : NULL;
    if (from && found == length)
        memcpy(bytes, from, length);
    enum store_answer answer = postgres_end(&query, rows, STORE_EMPTY);
    return answer == STORE_OK && found != length ? STORE_DOWN : answer;
}
