/* SPDX-License-Identifier: MIT */
#include "postgres.h"
#include "server/store/sql.h"
#include <stdlib.h>

/* ------------------------------------------------------------------ submit */

/* `known` is the job that this very call made before its connection was lost, or the earlier one of
 * the key. The result and the surface are locked against those who would delete them. The limits
 * are looked at without a lock: as many as are submitted at the same moment may come in beyond
 * them. The columns of its row: an answer, of the job id, status and whether it was there before,
 * and which limit is reached. */
static const char submit_sql[] =
    "WITH " POSTGRES_USABLE ", known AS MATERIALIZED ("
    " SELECT id, status, id = $2 OR key_digest = sha256($9) AS same FROM draped.jobs"
    "  WHERE id = $2 OR (owner = $5 AND key = $8) LIMIT 1),"
    " twin AS MATERIALIZED ("
    " SELECT number FROM draped.results WHERE owner = $5 AND digest = $6"
    "  AND state = " SQL_COMPLETE " FOR SHARE),"
    " stored AS MATERIALIZED ("
    " SELECT 1 FROM draped.surfaces WHERE id = $7 FOR KEY SHARE),"
    " has AS MATERIALIZED ("
    " SELECT sum(queued) AS queued, sum(results + others) AS bytes FROM draped.owners"
    "  WHERE owner = $5 AND ($11 > 0 OR $12 > 0)),"
    " bound AS MATERIALIZED ("
    " SELECT CASE WHEN NOT EXISTS (SELECT 1 FROM twin) AND $11 > 0 AND queued >= $11 THEN 1"
    "   WHEN $12 > 0 AND coalesce(bytes, 0) + octet_length($9) > $12 THEN 2"
    "   WHEN NOT EXISTS (SELECT 1 FROM twin)"
    "    AND (SELECT sum(n[1]) FROM draped.counts) >= $10 THEN 0 END AS reached FROM has),"
    " fit AS MATERIALIZED ("
    " SELECT (SELECT number FROM twin) AS result, reached, CASE"
    "   WHEN $7::text IS NOT NULL AND NOT EXISTS (SELECT 1 FROM stored) THEN 1" /* STORE_EMPTY */
    "   WHEN reached IS NOT NULL THEN 3"                                        /* STORE_FULL */
    "   ELSE 0 END AS answer"
    "  FROM bound WHERE NOT EXISTS (SELECT 1 FROM known)),"
    " made AS ("
    " INSERT INTO draped.jobs (id, status, rank, priority, owner, digest, surface, key, key_digest,"
    "   created, started, finished, progress, result, request_bytes, origin)"
    "  SELECT $2, CASE WHEN result IS NULL THEN " SQL_QUEUED " ELSE " SQL_SUCCEEDED " END,"
    "   now - $4, $3, $5, $6, $7, $8, CASE WHEN $8 IS NOT NULL THEN sha256($9) END, now, ended,"
    "   ended, CASE WHEN result IS NULL THEN 0 ELSE 1 END, result, octet_length($9), $13"
    "  FROM (SELECT result, now, CASE WHEN result IS NULL THEN 0 ELSE now END AS ended"
    "   FROM fit, (SELECT " POSTGRES_NOW " AS now) clock WHERE answer = 0) fitting"
    "  RETURNING sequence, id, status),"
    " kept AS (INSERT INTO draped.requests (job, bytes) SELECT sequence, $9 FROM made)"
    " SELECT CASE WHEN same THEN 0 ELSE 2 END, id, status, id <> $2, 0" /* STORE_CONFLICT */
    "  FROM known"
    " UNION ALL SELECT 0, id, status, false, 0 FROM made"
    " UNION ALL SELECT answer, $2, 0, false, reached FROM fit WHERE answer <> 0";

_Static_assert(STORE_BOUND_QUEUE == 0 && STORE_BOUND_OWNER_QUEUED == 1 &&
                   STORE_BOUND_OWNER_BYTES == 2,
               "as in submit_sql");
_Static_assert(STORE_EMPTY == 1 && STORE_CONFLICT == 2 && STORE_FULL == 3, "as in submit_sql");

static struct pg_query bind_submission(struct store *store,
                                       const struct store_submission *submission, const char *id) {
    const char *surface = submission->surface;
    struct pg_query query = postgres_query_now(store, submit_sql);
    pg_bind_text(&query, id);
    pg_bind_int(&query, submission->priority);
    pg_bind_int(&query, submission->priority * STORE_PRIORITY_US);
    pg_bind_text(&query, submission->owner ? submission->owner : "");
    pg_bind_text(&query, submission->digest);
    pg_bind_text(&query, surface && surface[0] ? surface : NULL);
    pg_bind_text(&query, submission->key);
    pg_bind_bytes(&query, submission->request, submission->request_length);
    pg_bind_int(&query, store->options.queue_limit);
    pg_bind_int(&query, submission->quota.queued);
    pg_bind_int(&query, submission->quota.bytes);
    pg_bind_text(&query, submission->origin);
    return query;
}

static enum store_answer try_submit(struct store *store, const struct store_submission *submission,
                                    const char *id, struct store_receipt *receipt, bool *taken) {
    struct pg_query query = bind_submission(store, submission, id);
    enum store_answer found = STORE_DOWN;
    if (pg_run(&query)) {
        found = (enum store_answer)pg_int(&query, 0, 0);
        pg_copy(&query, 0, 1, receipt->id, sizeof receipt->id);
        receipt->status = (enum store_status)pg_int(&query, 0, 2);
        receipt->existing = pg_int(&query, 0, 3) != 0;
        receipt->full = (enum store_bound)pg_int(&query, 0, 4);
    }
    *taken = query.taken;
    enum store_answer answer = pg_end(&query);
    return answer == STORE_OK ? found : answer;
}

/* Another with the same key may come in between the look and the insertion: then it is there at the
 * second look. */
enum store_answer postgres_submit(struct store *store, const struct store_submission *submission,
                                  struct store_receipt *receipt) {
    char id[ID_SIZE];
    bool taken = false;
    id_make(id);
    enum store_answer answer = try_submit(store, submission, id, receipt, &taken);
    return taken ? try_submit(store, submission, id, receipt, &taken) : answer;
}

/* ------------------------------------------------------------------ looking */

#define JOB_COLUMNS                                                                                \
    "j.sequence, j.id, j.status, j.progress, j.created, j.started, j.finished, j.attempts,"        \
    " j.priority, j.expired, j.owner, j.surface, j.digest, j.error,"                               \
    " coalesce(j.summary, r.summary)"                                                              \
    " FROM draped.jobs j LEFT JOIN draped.results r ON r.number = j.result"

static void read_job(struct pg_query *query, size_t row, struct store_job *job) {
    job->sequence = pg_int(query, row, 0);
    pg_copy(query, row, 1, job->id, sizeof job->id);
    job->status = (enum store_status)pg_int(query, row, 2);
    job->progress = pg_real(query, row, 3);
    job->created = pg_int(query, row, 4);
    job->started = pg_int(query, row, 5);
    job->finished = pg_int(query, row, 6);
    job->attempts = (int)pg_int(query, row, 7);
    job->priority = (int)pg_int(query, row, 8);
    job->expired = pg_int(query, row, 9) != 0;
    pg_copy(query, row, 10, job->owner, sizeof job->owner);
    pg_copy(query, row, 11, job->surface, sizeof job->surface);
    pg_copy(query, row, 12, job->digest, sizeof job->digest);
    pg_duplicate(query, row, 13, &job->error, NULL);
    pg_duplicate(query, row, 14, &job->summary, NULL);
}

enum store_answer postgres_get(struct store *store, const char *id, struct store_job *job) {
    struct pg_query query = postgres_query(store, "SELECT " JOB_COLUMNS " WHERE j.id = $1");
    pg_bind_text(&query, id);
    size_t rows = pg_run(&query);
    if (rows)
        read_job(&query, 0, job);
    return postgres_end(&query, rows, STORE_EMPTY);
}

enum store_answer postgres_request(struct store *store, const char *id, char **bytes,
                                   size_t *length) {
    struct pg_query query =
        postgres_query(store, "SELECT q.bytes FROM draped.jobs j"
                              " JOIN draped.requests q ON q.job = j.sequence WHERE j.id = $1");
    pg_bind_text(&query, id);
    size_t rows = pg_run(&query);
    if (rows)
        pg_duplicate(&query, 0, 0, bytes, length);
    return postgres_end(&query, rows, STORE_EMPTY);
}

#define LIST_OF(which)                                                                             \
    "SELECT " JOB_COLUMNS " WHERE j.sequence < $1 AND " which " ORDER BY j.sequence DESC LIMIT $3"

/* A statement each, so that it has the index it needs. One row more than asked tells whether there
 * is a next page. */
static struct pg_query list_query(struct store *store, const struct store_filter *filter) {
    struct pg_query query = postgres_query(
        store, filter->owner ? (filter->has_status ? LIST_OF("j.owner = $2 AND j.status = $4")
                                                   : LIST_OF("j.owner = $2"))
                             : (filter->has_status ? LIST_OF("$2::text IS NULL AND j.status = $4")
                                                   : LIST_OF("$2::text IS NULL")));
    pg_bind_int(&query, filter->cursor > 0 ? filter->cursor : INT64_MAX);
    pg_bind_text(&query, filter->owner);
    pg_bind_int(&query, filter->limit + 1);
    if (filter->has_status)
        pg_bind_int(&query, filter->status);
    return query;
}

enum store_answer postgres_list(struct store *store, const struct store_filter *filter,
                                struct store_page *page) {
    size_t limit = (size_t)filter->limit;
    page->jobs = calloc(limit, sizeof *page->jobs);
    if (!page->jobs)
        return STORE_DOWN;
    struct pg_query query = list_query(store, filter);
    size_t rows = pg_run(&query);
    for (size_t row = 0; row < rows && row < limit; row++)
        read_job(&query, row, &page->jobs[page->count++]);
    if (rows > limit)
        page->next = page->jobs[limit - 1].sequence;
    return pg_end(&query);
}

/* `now` 0: by the database's clock. */
enum store_answer postgres_read_counts(struct pool *pool, int64_t now,
                                       struct store_counts *counts) {
    struct pg_query query = pg_query(
        pool, "SELECT sum(n[1])::bigint, sum(n[2])::bigint, sum(n[3])::bigint, sum(n[4])::bigint,"
              " sum(n[5])::bigint, (SELECT created FROM draped.jobs WHERE status = " SQL_QUEUED
              " ORDER BY sequence LIMIT 1), sum(succeeded)::bigint, sum(failed)::bigint,"
              " sum(cancelled)::bigint, sum(crashed)::bigint, hosts, workers, busy"
              " FROM draped.counts, (SELECT count(*) AS hosts, coalesce(sum(h.workers), 0)::bigint"
              "  AS workers, coalesce(sum(h.busy), 0)::bigint AS busy FROM draped.hosts h"
              "  WHERE h.seen > " POSTGRES_NOW " - $2) alive GROUP BY hosts, workers, busy");
    if (now)
        pg_bind_int(&query, now);
    else
        pg_bind_no_int(&query);
    pg_bind_int(&query, STORE_SEEN_US);
    size_t rows = pg_run(&query);
    for (int k = 0; k < STORE_STATUS_COUNT && rows; k++)
        counts->jobs[k] = pg_int(&query, 0, k);
    if (rows) {
        counts->oldest_queued = pg_int(&query, 0, 5);
        counts->ended[STORE_SUCCEEDED] = pg_int(&query, 0, 6);
        counts->ended[STORE_FAILED] = pg_int(&query, 0, 7);
        counts->ended[STORE_CANCELLED] = pg_int(&query, 0, 8);
        counts->crashed = pg_int(&query, 0, 9);
        counts->hosts = pg_int(&query, 0, 10);
        counts->workers = pg_int(&query, 0, 11);
        counts->busy = pg_int(&query, 0, 12);
    }
    return postgres_end(&query, rows, STORE_DOWN);
}

enum store_answer postgres_counts(struct store *store, struct store_counts *counts) {
    return postgres_read_counts(postgres_pool(store),
                                store->options.clock ? store->options.clock() : 0, counts);
}

enum store_answer postgres_usage(struct store *store, const char *owner,
                                 struct store_usage *usage) {
    struct pg_query query = postgres_query(
        store, "SELECT coalesce(sum(queued), 0)::bigint, coalesce(sum(running), 0)::bigint,"
               " coalesce(sum(results + others), 0)::bigint FROM draped.owners WHERE owner = $1");
    pg_bind_text(&query, owner);
    if (pg_run(&query)) {
        usage->queued = pg_int(&query, 0, 0);
        usage->running = pg_int(&query, 0, 1);
        usage->bytes = pg_int(&query, 0, 2);
    }
    return pg_end(&query);
}

/* ------------------------------------------------------------------ ending by the caller */

static enum store_answer known(struct store *store, const char *id) {
    struct pg_query query = postgres_query(store, "SELECT 1 FROM draped.jobs WHERE id = $1");
    pg_bind_text(&query, id);
    return postgres_end(&query, pg_run(&query), STORE_EMPTY);
}

enum store_answer postgres_cancel(struct store *store, const char *id) {
    struct pg_query query =
        postgres_query_now(store, "UPDATE draped.jobs SET status = " SQL_CANCELLED
                                  ", finished = " POSTGRES_NOW ", lease = NULL"
                                  " WHERE id = $2 AND status < " SQL_FIRST_ENDED " RETURNING 1");
    pg_bind_text(&query, id);
    enum store_answer answer = postgres_end(&query, pg_run(&query), STORE_EMPTY);
    if (answer != STORE_EMPTY)
        return answer;
    answer = known(store, id);
    return answer == STORE_OK ? STORE_CONFLICT : answer;
}

/* The function is called when the job is gone, and sees that. */
enum store_answer postgres_remove(struct store *store, const char *id) {
    struct pg_query query =
        postgres_query(store, "WITH gone AS (DELETE FROM draped.jobs WHERE id = $1"
                              " RETURNING sequence, result),"
                              " with_it AS (DELETE FROM draped.requests USING gone"
                              " WHERE job = gone.sequence)"
                              " SELECT count(*), draped.forget_results(array_agg(result))"
                              " FROM gone HAVING count(*) > 0");
    pg_bind_text(&query, id);
    return postgres_end(&query, pg_run(&query), STORE_EMPTY);
}
