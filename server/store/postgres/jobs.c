/* SPDX-License-Identifier: MIT */
#include "postgres.h"
#include "server/store/seal.h"
#include "server/store/sql.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SUBMIT_TRIES = 2 };

/* ------------------------------------------------------------------ submit */

/* The job that this call made before its connection was lost, or the earlier one of the key. */
#define SUBMIT_KNOWN                                                                               \
    "WITH " POSTGRES_USABLE ", known AS MATERIALIZED ("                                            \
    " SELECT id, status, id = $2 OR key_digest = sha256($9) AND kind = $14 AS same"                \
    "  FROM draped.jobs"                                                                           \
    "  WHERE id = $2 OR (owner = $5 AND key = $8) LIMIT 1),"

/* The surface, what there is of the owner, and how many jobs of all wait. */
#define SUBMIT_HAS                                                                                 \
    " stored AS MATERIALIZED ("                                                                    \
    " SELECT 1 FROM draped.surfaces WHERE id = $7 FOR KEY SHARE),"                                 \
    " has AS MATERIALIZED ("                                                                       \
    " SELECT coalesce(sum(queued - tasks), 0) AS queued, coalesce(sum(results + others), 0) AS"    \
    "  bytes, (SELECT sum(n[1]) FROM draped.counts) AS waiting FROM draped.owners"                 \
    "  WHERE owner = $5),"

/* The result and the surface are locked against those who would delete them. The limits are looked
 * at without a lock: as many as are submitted at the same moment may come in beyond them. The
 * columns of its row: an answer, of the job id, status and whether it was there before, and which
 * limit is reached; of the share of what is left, `share_fits`. */
static const char submit_sql[] = SUBMIT_KNOWN
    " twin AS MATERIALIZED ("
    " SELECT number FROM draped.results WHERE owner = $5 AND digest = $6"
    "  AND state = " SQL_COMPLETE " FOR SHARE)," SUBMIT_HAS " bound AS MATERIALIZED ("
    " SELECT CASE WHEN NOT EXISTS (SELECT 1 FROM twin) AND $11 > 0 AND queued >= $11 THEN 1"
    "   WHEN $12 > 0 AND bytes + octet_length($9) > $12 THEN 2"
    "   WHEN EXISTS (SELECT 1 FROM twin) THEN NULL"
    "   WHEN waiting >= $10 THEN 0 WHEN queued >= $10 - waiting THEN 3 END AS reached FROM has),"
    " fit AS MATERIALIZED ("
    " SELECT (SELECT number FROM twin) AS result, reached, CASE"
    "   WHEN $7::text IS NOT NULL AND NOT EXISTS (SELECT 1 FROM stored) THEN 1" /* STORE_EMPTY */
    "   WHEN reached IS NOT NULL THEN 3"                                        /* STORE_FULL */
    "   ELSE 0 END AS answer"
    "  FROM bound WHERE NOT EXISTS (SELECT 1 FROM known)),"
    " made AS ("
    " INSERT INTO draped.jobs (id, status, rank, priority, owner, digest, surface, key, key_digest,"
    "   created, started, finished, progress, result, request_bytes, origin, kind, total)"
    "  SELECT $2, CASE WHEN result IS NULL THEN " SQL_QUEUED " ELSE " SQL_SUCCEEDED " END,"
    "   now + $4, $3, $5, $6, $7, $8, CASE WHEN $8 IS NOT NULL THEN sha256($9) END, now, ended,"
    "   ended, CASE WHEN result IS NULL THEN 0 ELSE 1 END, result, octet_length($9), $13, $14, $16"
    "  FROM (SELECT result, now, CASE WHEN result IS NULL THEN 0 ELSE now END AS ended"
    "   FROM fit, (SELECT " POSTGRES_NOW " AS now) clock WHERE answer = 0) fitting"
    "  RETURNING sequence, id, status),"
    " kept AS (INSERT INTO draped.requests (job, seal, bytes) SELECT sequence, $15, $9 FROM made)"
    " SELECT CASE WHEN same THEN 0 ELSE 2 END, id, status, id <> $2, 0" /* STORE_CONFLICT */
    "  FROM known"
    " UNION ALL SELECT 0, id, status, false, 0 FROM made"
    " UNION ALL SELECT answer, $2, 0, false, reached FROM fit WHERE answer <> 0";

_Static_assert(STORE_BOUND_QUEUE == 0 && STORE_BOUND_OWNER_QUEUED == 1 &&
                   STORE_BOUND_OWNER_BYTES == 2 && STORE_BOUND_SHARE == 3,
               "as in submit_sql");
_Static_assert(STORE_EMPTY == 1 && STORE_CONFLICT == 2 && STORE_FULL == 3, "as in submit_sql");

/* A laminate with its drapes. Of these the first $16 are numbered from 0: $17 has their ids, $18
 * their digests, $19 where each ends in $20, which has all their requests, $21 the seals of these;
 * the texts are lists with commas. A drape whose result is there finds it when it is claimed. */
static const char submit_family_sql[] = SUBMIT_KNOWN SUBMIT_HAS
    " bound AS MATERIALIZED ("
    " SELECT CASE WHEN $11 > 0 AND queued + $16 > $11 THEN 1"
    "   WHEN $12 > 0 AND bytes + octet_length($9) + octet_length($20) > $12 THEN 2"
    "   WHEN waiting + $16 > $10 THEN 0"
    "   WHEN queued + $16 - 1 >= $10 - waiting - ($16 - 1) THEN 3 END AS reached FROM has),"
    " fit AS MATERIALIZED ("
    " SELECT reached, CASE"
    "   WHEN $7::text IS NOT NULL AND NOT EXISTS (SELECT 1 FROM stored) THEN 1" /* STORE_EMPTY */
    "   WHEN reached IS NOT NULL THEN 3"                                        /* STORE_FULL */
    "   ELSE 0 END AS answer"
    "  FROM bound WHERE NOT EXISTS (SELECT 1 FROM known)),"
    " made AS ("
    " INSERT INTO draped.jobs (id, status, rank, priority, owner, digest, surface, key, key_digest,"
    "   created, started, request_bytes, origin, kind, round, open, total)"
    "  SELECT $2, " SQL_WAITING ", now + $4, $3, $5, $6, $7, $8,"
    "   CASE WHEN $8 IS NOT NULL THEN sha256($9) END, now, now, octet_length($9), $13, $14, 1,"
    "   $16::integer, $16 FROM fit, (SELECT " POSTGRES_NOW " AS now) clock WHERE answer = 0"
    "  RETURNING sequence, id, rank, created),"
    " lists AS MATERIALIZED (SELECT string_to_array($17, ',') AS ids,"
    "  string_to_array($18, ',') AS digests, ('{0,' || $19 || '}')::integer[] AS ends,"
    "  ('{' || $21 || '}')::bigint[] AS seals),"
    " members AS (INSERT INTO draped.jobs (id, status, rank, priority, owner, digest, surface,"
    "   created, request_bytes, origin, total, parent, position)"
    "  SELECT ids[k], " SQL_QUEUED ", made.rank, $3, $5, digests[k], $7, made.created,"
    "   ends[k + 1] - ends[k], $13, 1, made.sequence, k - 1"
    "  FROM made, lists, generate_series(1, $16::integer) k RETURNING sequence, position),"
    " kept AS (INSERT INTO draped.requests (job, seal, bytes)"
    "  SELECT sequence, $15, $9 FROM made UNION ALL"
    "  SELECT sequence, seals[position + 1], substring($20 FROM ends[position + 1] + 1 FOR "
    "ends[position + 2] - "
    "ends[position + 1])"
    "  FROM members, lists)"
    " SELECT CASE WHEN same THEN 0 ELSE 2 END, id, status, id <> $2, 0" /* STORE_CONFLICT */
    "  FROM known"
    " UNION ALL SELECT 0, id, " SQL_RUNNING ", false, 0 FROM made"
    " UNION ALL SELECT answer, $2, 0, false, reached FROM fit WHERE answer <> 0";

static struct query bind_submission(struct store *store, const char *sql,
                                    const struct store_submission *submission, const char *id) {
    const char *surface = submission->surface;
    struct query query = postgres_query_now(store, sql);
    query_bind(&query, of_text(id), of_int(submission->priority), of_int(store_rank(submission, 0)),
               of_text(submission->owner ? submission->owner : ""), of_text(submission->digest),
               of_text(surface && surface[0] ? surface : NULL), of_text(submission->key),
               of_bytes(submission->request, submission->request_length),
               of_int(store->options.queue_limit), of_int(submission->quota.queued),
               of_int(submission->quota.bytes), of_text(submission->origin),
               of_int(submission->kind),
               of_int(seal_of_request(id, submission->request, submission->request_length)));
    return query;
}

/* Ends the query. */
static enum store_answer read_receipt(struct query query, struct store_receipt *receipt,
                                      bool *taken) {
    enum store_answer found = STORE_DOWN;
    if (query_row(&query)) {
        int64_t status = query_int(&query, 2);
        found = (enum store_answer)query_int(&query, 0);
        query_copy(&query, 1, receipt->id, sizeof receipt->id);
        receipt->status = status < 0 ? STORE_RUNNING : (enum store_status)status;
        receipt->existing = query_int(&query, 3) != 0;
        receipt->full = (enum store_bound)query_int(&query, 4);
    }
    *taken = query.taken;
    enum store_answer answer = query_end(&query);
    return answer == STORE_OK ? found : answer;
}

/* Another with the same key may come in between the look and the insertion: then it is there at the
 * second look. */
enum store_answer postgres_submit(struct store *store, const struct store_submission *submission,
                                  struct store_receipt *receipt) {
    char id[ID_SIZE];
    enum store_answer answer = STORE_CONFLICT;
    bool taken = true;
    id_make(id);
    for (int k = 0; k < SUBMIT_TRIES && taken; k++) {
        struct query query = bind_submission(store, submit_sql, submission, id);
        query_bind(&query, of_int(submission->total));
        answer = read_receipt(query, receipt, &taken);
    }
    return answer;
}

/* ------------------------------------------------------------------ a laminate with its drapes */

enum store_answer postgres_submit_family(struct store *store, const struct store_family *family,
                                         struct store_receipt *receipt) {
    enum { NUMBER_SIZE = 22 };
    char id[ID_SIZE];
    size_t all = 0, end = 0;
    for (size_t k = 0; k < family->count; k++)
        all += family->members[k].request_length;
    /* The drapes as the statement takes them. */
    char *ids = malloc(family->count * ID_SIZE),
         *digests = malloc(family->count * STORE_DIGEST_SIZE);
    char *ends = malloc(family->count * NUMBER_SIZE), *seals = malloc(family->count * NUMBER_SIZE);
    char *requests = malloc(all + 1), *digest = digests, *number = ends, *seal = seals;
    bool taken = ids && digests && ends && seals && requests;
    for (size_t k = 0; k < family->count && taken; k++) {
        const struct store_member *member = &family->members[k];
        const char *comma = k + 1 < family->count ? "," : "";
        id_make(ids + k * ID_SIZE);
        seal += snprintf(
            seal, NUMBER_SIZE, "%lld%s",
            (long long)seal_of_request(ids + k * ID_SIZE, member->request, member->request_length),
            comma);
        ids[k * ID_SIZE + ID_SIZE - 1] = *comma;
        memcpy(requests + end, member->request, member->request_length);
        end += member->request_length;
        digest += snprintf(digest, STORE_DIGEST_SIZE + 1, "%s%s", member->digest, comma);
        number += snprintf(number, NUMBER_SIZE, "%zu%s", end, comma);
    }
    enum store_answer answer = STORE_DOWN;
    id_make(id);
    for (int k = 0; k < SUBMIT_TRIES && taken; k++) {
        struct query query = bind_submission(store, submit_family_sql, &family->parent, id);
        query_bind(&query, of_int((int64_t)family->count), of_text(ids), of_text(digests),
                   of_text(ends), of_bytes(requests, all), of_text(seals));
        answer = read_receipt(query, receipt, &taken);
    }
    free(ids);
    free(digests);
    free(ends);
    free(seals);
    free(requests);
    return answer;
}

/* ------------------------------------------------------------------ ending by the caller */

enum store_answer postgres_cancel(struct store *store, const char *id) {
    struct query query =
        postgres_query_now(store, "UPDATE draped.jobs SET status = " SQL_CANCELLED
                                  ", finished = " POSTGRES_NOW ", lease = NULL"
                                  " WHERE sequence = (SELECT draped.lock_family($2))"
                                  " AND status < " SQL_FIRST_ENDED " RETURNING 1");
    query_bind(&query, of_text(id));
    enum store_answer answer = query_find(&query, STORE_EMPTY);
    if (answer != STORE_EMPTY)
        return answer;
    query = postgres_query(store, "SELECT 1 FROM draped.jobs WHERE id = $1");
    query_bind(&query, of_text(id));
    answer = query_find(&query, STORE_EMPTY);
    return answer == STORE_OK ? STORE_CONFLICT : answer;
}

/* The function is called when the job is gone, and sees that. */
enum store_answer postgres_remove(struct store *store, const char *id) {
    struct query query =
        postgres_query(store, "WITH gone AS (DELETE FROM draped.jobs WHERE sequence ="
                              " (SELECT draped.lock_family($1)) RETURNING sequence, result),"
                              " with_it AS (DELETE FROM draped.requests USING gone"
                              " WHERE job = gone.sequence)"
                              " SELECT count(*), draped.forget_results(array_agg(result))"
                              " FROM gone HAVING count(*) > 0");
    query_bind(&query, of_text(id));
    return query_find(&query, STORE_EMPTY);
}
