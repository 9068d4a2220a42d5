/* SPDX-License-Identifier: MIT */
#include "postgres.h"
#include "server/store/seal.h"
#include "server/store/sql.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { COMMIT_TRIES = 3 };

/* ------------------------------------------------------------------ writing */

/* The segment travels as one value and is cut by the server. $4: index of the first chunk, $5: the
 * bytes, $6: the seals of all, a list; `made` is a row with a `number`. A statement that runs once
 * more finds its chunks. Gives the number. */
#define STORE_CHUNKS                                                                               \
    " stored AS (INSERT INTO draped.chunks (result, index, seal, bytes)"                           \
    " SELECT number, $4 + i, ($6::bigint[])[i + 1],"                                               \
    "  substring($5 FROM i * 65536 + 1 FOR 65536) FROM made,"                                      \
    " generate_series(0, (octet_length($5) + 65535) / 65536 - 1) i ON CONFLICT DO NOTHING)"        \
    " SELECT number"

_Static_assert(STORE_CHUNK_BYTES == 65536, "as in STORE_CHUNKS");

static const char append_first_sql[] =
    "WITH made AS (INSERT INTO draped.results (owner, digest, state, job, token, length)"
    " SELECT owner, digest, " SQL_BUILDING ", sequence, token, 0 FROM draped.jobs"
    " WHERE $1::bigint IS NOT NULL AND" POSTGRES_HELD " RETURNING number)," STORE_CHUNKS
    ", " POSTGRES_LAZY " FROM made";

/* Between two segments the result may have been given up (its job cancelled, say). */
static const char append_sql[] =
    "WITH made AS (SELECT r.number FROM draped.results r"
    " JOIN draped.jobs j ON j.sequence = r.job AND j.token = r.token"
    " WHERE r.number = $1 AND r.state = " SQL_BUILDING " AND j.sequence = $2 AND j.token = $3"
    " AND j.status = " SQL_RUNNING ")," STORE_CHUNKS ", " POSTGRES_LAZY " FROM made";

/* The job ends with the result that is `chosen`. */
#define END_JOB                                                                                    \
    "UPDATE draped.jobs SET status = " SQL_SUCCEEDED ", progress = 1, finished = " POSTGRES_NOW    \
    ", result = chosen.number, lease = NULL FROM chosen WHERE" POSTGRES_HELD " RETURNING "

/* The job ends, and only if it does, its result is made. */
static const char commit_new_sql[] =
    "WITH chosen AS MATERIALIZED (SELECT draped.next_number() AS number),"
    " ended AS (" END_JOB "sequence, token, owner, digest, chosen.number),"
    " made AS (INSERT INTO draped.results"
    "  (number, owner, digest, state, job, token, length, summary, summary_seal)"
    "  SELECT number, owner, digest, " SQL_COMPLETE ", sequence, token, $7, $8, $9 FROM ended"
    "  RETURNING number)," STORE_CHUNKS " FROM made";

static const char commit_begun_sql[] =
    "WITH chosen AS MATERIALIZED (SELECT number FROM draped.results WHERE number = $10"
    "  AND state = " SQL_BUILDING " FOR UPDATE),"
    " ended AS (" END_JOB "chosen.number),"
    " made AS (UPDATE draped.results r SET state = " SQL_COMPLETE ", length = $7, summary = $8,"
    "  summary_seal = $9 FROM ended WHERE r.number = ended.number RETURNING r.number)," STORE_CHUNKS
    " FROM made";

static const char commit_twin_sql[] =
    "WITH chosen AS MATERIALIZED (SELECT r.number FROM draped.jobs j JOIN draped.results r"
    " ON r.owner = j.owner AND r.digest = j.digest AND r.state = " SQL_COMPLETE
    " WHERE j.sequence = $2 FOR SHARE OF r) " END_JOB "1";

/* The segment in one piece, malloc'ed. */
static unsigned char *join_chunks(const struct store_segment *segment) {
    unsigned char *bytes = malloc(segment->length + 1);
    for (size_t at = 0; at < segment->length && bytes; at += STORE_CHUNK_BYTES) {
        size_t left = segment->length - at;
        memcpy(bytes + at, segment->chunks[at / STORE_CHUNK_BYTES],
               left < STORE_CHUNK_BYTES ? left : STORE_CHUNK_BYTES);
    }
    return bytes;
}

/* The seals of a segment as a value of the server. */
enum { SEALS_SIZE = 21 * STORE_SEGMENT_CHUNKS + 3 };

/* `seals` is to be there until the first row. */
static void bind_segment(struct query *query, const struct store_segment *segment,
                         const unsigned char *bytes, char seals[SEALS_SIZE]) {
    size_t used = 0;
    for (size_t k = 0; segment_chunk_length(segment, k) > 0; k++)
        used += (size_t)snprintf(seals + used, SEALS_SIZE - used, "%c%lld", k ? ',' : '{',
                                 (long long)segment_seal(segment, k));
    snprintf(seals + used, SEALS_SIZE - used, "%s", used ? "}" : "{}");
    query_bind(query, of_int(segment->claim->sequence), of_int(segment->claim->token),
               of_int(segment->index), of_bytes(bytes, segment->length), of_text(seals));
}

enum store_answer postgres_result_append(struct store *store, struct store_segment *segment) {
    unsigned char *bytes = join_chunks(segment);
    if (!bytes)
        return STORE_DOWN;
    struct query query = postgres_query(store, segment->index ? append_sql : append_first_sql);
    char seals[SEALS_SIZE];
    query_bind(&query, of_int(segment->number));
    bind_segment(&query, segment, bytes, seals);
    bool found = query_row(&query);
    if (found)
        segment->number = query_int(&query, 0);
    free(bytes);
    return query_end_found(&query, found, STORE_CONFLICT);
}

/* A twin that was there may be gone when it is to be taken: then the own result is stored. */
enum store_answer postgres_result_commit(struct store *store, struct store_segment *segment) {
    unsigned char *bytes = join_chunks(segment);
    enum store_answer answer = bytes ? STORE_CONFLICT : STORE_DOWN;
    for (int k = 0; k < COMMIT_TRIES && answer == STORE_CONFLICT; k++) {
        struct query query =
            postgres_query_now(store, segment->number ? commit_begun_sql : commit_new_sql);
        char seals[SEALS_SIZE];
        bind_segment(&query, segment, bytes, seals);
        query_bind(&query, of_int(segment->total), of_text(segment->summary),
                   of_int(seal_of_text(segment->summary)));
        if (segment->number)
            query_bind(&query, of_int(segment->number));
        bool found = query_row(&query);
        if (found)
            segment->number = query_int(&query, 0);
        bool taken = query.taken; /* there is a result of that digest */
        answer = query_end_found(&query, found, STORE_CONFLICT);
        if (!taken)
            break;
        query = postgres_held_query(store, commit_twin_sql, segment->claim);
        answer = query_find(&query, STORE_CONFLICT);
        if (answer == STORE_OK && segment->number)
            (void)!postgres_result_drop(store, segment->number); /* else the sweep finds it */
        if (answer == STORE_OK)
            segment->number = 0;
    }
    free(bytes);
    return answer;
}

/* Not one that was committed after all, by a statement whose answer was lost. */
enum store_answer postgres_result_drop(struct store *store, int64_t number) {
    struct query query = postgres_query(store, "UPDATE draped.results SET state = " SQL_DOOMED
                                               " WHERE number = $1 AND state = " SQL_BUILDING
                                               " RETURNING " POSTGRES_LAZY);
    query_bind(&query, of_int(number));
    return query_run(&query);
}
