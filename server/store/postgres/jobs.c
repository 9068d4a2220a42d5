/* SPDX-License-Identifier: MIT */
#include "postgres.h"
#include "server/store/sql.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SUBMIT_TRIES = 2 };

/* ------------------------------------------------------------------ submit */

/* What there is of the owner, and how many jobs of all wait. */
#define SUBMIT_HAS                                                                                 \
    " has AS MATERIALIZED ("                                                                       \
    " SELECT coalesce(sum(queued - tasks), 0) AS queued, coalesce(sum(results + others), 0) AS"    \
    "  bytes, (SELECT sum(n[1]) FROM draped.counts) AS waiting FROM draped.owners"                 \
    "  WHERE owner = $5),"

/* `known` is the job that this very call made before its connection was lost, or the earlier one of
 * the key. The result and the surface are locked against those who would delete them. The limits
 * are looked at without a lock: as many as are submitted at the same moment may come in beyond
 * them. The columns of its row: an answer, of the job id, status and whether it was there before,
 * and which limit is reached; of the share of what is left, `share_fits`. */
static const char submit_sql[] =
    "WITH " POSTGRES_USABLE ", known AS MATERIALIZED ("
    " SELECT id, status, id = $2 OR key_digest = sha256($9) AND kind = $14 AS same"
    "  FROM draped.jobs"
    "  WHERE id = $2 OR (owner = $5 AND key = $8) LIMIT 1),"
    " twin AS MATERIALIZED ("
    " SELECT number FROM draped.results WHERE owner = $5 AND digest = $6"
    "  AND state = " SQL_COMPLETE " FOR SHARE),"
    " stored AS MATERIALIZED ("
    " SELECT 1 FROM draped.surfaces WHERE id = $7 FOR KEY SHARE)," SUBMIT_HAS
    " bound AS MATERIALIZED ("
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
    "   ended, CASE WHEN result IS NULL THEN 0 ELSE 1 END, result, octet_length($9), $13, $14, $15"
    "  FROM (SELECT result, now, CASE WHEN result IS NULL THEN 0 ELSE now END AS ended"
    "   FROM fit, (SELECT " POSTGRES_NOW " AS now) clock WHERE answer = 0) fitting"
    "  RETURNING sequence, id, status),"
    " kept AS (INSERT INTO draped.requests (job, bytes) SELECT sequence, $9 FROM made)"
    " SELECT CASE WHEN same THEN 0 ELSE 2 END, id, status, id <> $2, 0" /* STORE_CONFLICT */
    "  FROM known"
    " UNION ALL SELECT 0, id, status, false, 0 FROM made"
    " UNION ALL SELECT answer, $2, 0, false, reached FROM fit WHERE answer <> 0";

_Static_assert(STORE_BOUND_QUEUE == 0 && STORE_BOUND_OWNER_QUEUED == 1 &&
                   STORE_BOUND_OWNER_BYTES == 2 && STORE_BOUND_SHARE == 3,
               "as in submit_sql");
_Static_assert(STORE_EMPTY == 1 && STORE_CONFLICT == 2 && STORE_FULL == 3, "as in submit_sql");

/* A laminate with its drapes. Of these the first $15 are numbered from 0: $16 has their ids, $17
 * their digests, $18 where each ends in $19, which has all their requests; the texts are lists with
 * commas. A drape whose result is there finds it when it is claimed. */
static const char submit_family_sql[] =
    "WITH " POSTGRES_USABLE ", known AS MATERIALIZED ("
    " SELECT id, status, id = $2 OR key_digest = sha256($9) AND kind = $14 AS same"
    "  FROM draped.jobs"
    "  WHERE id = $2 OR (owner = $5 AND key = $8) LIMIT 1),"
    " stored AS MATERIALIZED ("
    " SELECT 1 FROM draped.surfaces WHERE id = $7 FOR KEY SHARE)," SUBMIT_HAS
    " bound AS MATERIALIZED ("
    " SELECT CASE WHEN $11 > 0 AND queued + $15 > $11 THEN 1"
    "   WHEN $12 > 0 AND bytes + octet_length($9) + octet_length($19) > $12 THEN 2"
    "   WHEN waiting + $15 > $10 THEN 0"
    "   WHEN queued + $15 - 1 >= $10 - waiting - ($15 - 1) THEN 3 END AS reached FROM has),"
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
    "   $15::integer, $15 FROM fit, (SELECT " POSTGRES_NOW " AS now) clock WHERE answer = 0"
    "  RETURNING sequence, id, rank, created),"
    " lists AS MATERIALIZED (SELECT string_to_array($16, ',') AS ids,"
    "  string_to_array($17, ',') AS digests, ('{0,' || $18 || '}')::integer[] AS ends),"
    " members AS (INSERT INTO draped.jobs (id, status, rank, priority, owner, digest, surface,"
    "   created, request_bytes, origin, total, parent, position)"
    "  SELECT ids[k], " SQL_QUEUED ", made.rank, $3, $5, digests[k], $7, made.created,"
    "   ends[k + 1] - ends[k], $13, 1, made.sequence, k - 1"
    "  FROM made, lists, generate_series(1, $15::integer) k RETURNING sequence, position),"
    " kept AS (INSERT INTO draped.requests (job, bytes) SELECT sequence, $9 FROM made UNION ALL"
    "  SELECT sequence, substring($19 FROM ends[position + 1] + 1 FOR ends[position + 2] - "
    "ends[position + 1])"
    "  FROM members, lists)"
    " SELECT CASE WHEN same THEN 0 ELSE 2 END, id, status, id <> $2, 0" /* STORE_CONFLICT */
    "  FROM known"
    " UNION ALL SELECT 0, id, " SQL_RUNNING ", false, 0 FROM made"
    " UNION ALL SELECT answer, $2, 0, false, reached FROM fit WHERE answer <> 0";

static struct pg_query bind_submission(struct store *store, const char *sql,
                                       const struct store_submission *submission, const char *id) {
    const char *surface = submission->surface;
    struct pg_query query = postgres_query_now(store, sql);
    pg_bind_text(&query, id);
    pg_bind_int(&query, submission->priority);
    pg_bind_int(&query, store_rank(submission, 0));
    pg_bind_text(&query, submission->owner ? submission->owner : "");
    pg_bind_text(&query, submission->digest);
    pg_bind_text(&query, surface && surface[0] ? surface : NULL);
    pg_bind_text(&query, submission->key);
    pg_bind_bytes(&query, submission->request, submission->request_length);
    pg_bind_int(&query, store->options.queue_limit);
    pg_bind_int(&query, submission->quota.queued);
    pg_bind_int(&query, submission->quota.bytes);
    pg_bind_text(&query, submission->origin);
    pg_bind_int(&query, submission->kind);
    return query;
}

/* Ends the query. */
static enum store_answer read_receipt(struct pg_query query, struct store_receipt *receipt,
                                      bool *taken) {
    enum store_answer found = STORE_DOWN;
    if (pg_run(&query)) {
        int64_t status = pg_int(&query, 0, 2);
        found = (enum store_answer)pg_int(&query, 0, 0);
        pg_copy(&query, 0, 1, receipt->id, sizeof receipt->id);
        receipt->status = status < 0 ? STORE_RUNNING : (enum store_status)status;
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
    enum store_answer answer = STORE_CONFLICT;
    bool taken = true;
    id_make(id);
    for (int k = 0; k < SUBMIT_TRIES && taken; k++) {
        struct pg_query query = bind_submission(store, submit_sql, submission, id);
        pg_bind_int(&query, submission->total);
        answer = read_receipt(query, receipt, &taken);
    }
    return answer;
}

/* ------------------------------------------------------------------ a laminate with its drapes */

/* Its drapes as the statement takes them; malloc'ed. */
struct lists {
    char *ids, *digests, *ends, *requests;
    size_t length; /* of the requests */
};

static void free_lists(struct lists *lists) {
    free(lists->ids);
    free(lists->digests);
    free(lists->ends);
    free(lists->requests);
}

/* False without memory. */
static bool make_lists(const struct store_family *family, struct lists *lists) {
    enum { NUMBER_SIZE = 21 };
    size_t all = 0, end = 0;
    for (size_t k = 0; k < family->count; k++)
        all += family->members[k].request_length;
    *lists = (struct lists){.ids = malloc(family->count * ID_SIZE),
                            .digests = malloc(family->count * STORE_DIGEST_SIZE),
                            .ends = malloc(family->count * NUMBER_SIZE),
                            .requests = malloc(all + 1),
                            .length = all};
    if (!lists->ids || !lists->digests || !lists->ends || !lists->requests)
        return false;
    char *digest = lists->digests, *number = lists->ends;
    for (size_t k = 0; k < family->count; k++) {
        const struct store_member *member = &family->members[k];
        const char *comma = k + 1 < family->count ? "," : "";
        id_make(lists->ids + k * ID_SIZE);
        lists->ids[k * ID_SIZE + ID_SIZE - 1] = *comma;
        memcpy(lists->requests + end, member->request, member->request_length);
        end += member->request_length;
        digest += snprintf(digest, STORE_DIGEST_SIZE + 1, "%s%s", member->digest, comma);
        number += snprintf(number, NUMBER_SIZE, "%zu%s", end, comma);
    }
    return true;
}

enum store_answer postgres_submit_family(struct store *store, const struct store_family *family,
                                         struct store_receipt *receipt) {
    char id[ID_SIZE];
    struct lists lists;
    bool taken = make_lists(family, &lists);
    enum store_answer answer = STORE_DOWN;
    id_make(id);
    for (int k = 0; k < SUBMIT_TRIES && taken; k++) {
        struct pg_query query = bind_submission(store, submit_family_sql, &family->parent, id);
        pg_bind_int(&query, (int64_t)family->count);
        pg_bind_text(&query, lists.ids);
        pg_bind_text(&query, lists.digests);
        pg_bind_text(&query, lists.ends);
        pg_bind_bytes(&query, lists.requests, lists.length);
        answer = read_receipt(query, receipt, &taken);
    }
    free_lists(&lists);
    return answer;
}

/* ------------------------------------------------------------------ looking */

#define JOB_COLUMNS                                                                                \
    "j.sequence, j.id, j.status, j.progress, j.created, j.started, j.finished, j.attempts,"        \
    " j.priority, j.expired, j.owner, j.surface, j.digest, j.error,"                               \
    " coalesce(r.summary, j.summary), j.kind, j.done, j.total, j.position, j.round"                \
    " FROM draped.jobs j LEFT JOIN draped.results r ON r.number = j.result"

static void read_job(struct pg_query *query, size_t row, struct store_job *job) {
    job->sequence = pg_int(query, row, 0);
    pg_copy(query, row, 1, job->id, sizeof job->id);
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
    job->kind = (enum store_kind)pg_int(query, row, 15);
    job->done = pg_int(query, row, 16);
    job->total = pg_int(query, row, 17);
    job->position = pg_int(query, row, 18);
    store_job_show(job, pg_int(query, row, 2), pg_int(query, row, 19));
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

enum store_answer postgres_members(struct store *store, const char *id, struct store_page *page) {
    struct pg_query query = postgres_query(
        store, "SELECT " JOB_COLUMNS " WHERE j.parent = (SELECT sequence FROM draped.jobs"
               " WHERE id = $1 AND kind = " SQL_LAMINATE ") ORDER BY j.position");
    pg_bind_text(&query, id);
    size_t rows = pg_run(&query);
    page->jobs = calloc(rows + 1, sizeof *page->jobs);
    for (size_t row = 0; page->jobs && row < rows; row++)
        read_job(&query, row, &page->jobs[page->count++]);
    enum store_answer answer = pg_end(&query);
    return page->jobs ? answer : STORE_DOWN;
}

#define LIST_OF(which)                                                                             \
    "SELECT " JOB_COLUMNS " WHERE j.sequence < $1 AND " which " ORDER BY j.sequence DESC LIMIT $3"

/* A statement each, so that it has the index it needs. One row more than asked tells whether there
 * is a next page. */
static struct pg_query list_query(struct store *store, const struct store_filter *filter) {
    struct pg_query query = postgres_query(
        store,
        filter->owner
            ? (filter->has_status ? LIST_OF("j.owner = $2 AND j.kind = $4 AND $5 = " SQL_SHOWN)
                                  : LIST_OF("j.owner = $2 AND j.kind = $4"))
        : filter->kind != STORE_DRAPE
            ? (filter->has_status ? LIST_OF("$2::text IS NULL AND j.kind > 0 AND j.kind = $4 AND"
                                            " $5 = " SQL_SHOWN)
                                  : LIST_OF("$2::text IS NULL AND j.kind > 0 AND j.kind = $4"))
            : (filter->has_status ? LIST_OF("$2::text IS NULL AND j.kind = $4 AND j.status = $5")
                                  : LIST_OF("$2::text IS NULL AND j.kind = $4")));
    pg_bind_int(&query, filter->cursor > 0 ? filter->cursor : INT64_MAX);
    pg_bind_text(&query, filter->owner);
    pg_bind_int(&query, filter->limit + 1);
    pg_bind_int(&query, filter->kind);
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
              " sum(n[5])::bigint, (SELECT min(created) FROM ((SELECT created FROM draped.jobs"
              " WHERE kind = " SQL_DRAPE " AND status = " SQL_QUEUED " ORDER BY sequence LIMIT 1)"
              " UNION ALL (SELECT created FROM draped.jobs WHERE kind = " SQL_STUDY
              " AND status = " SQL_QUEUED " AND round = 0 ORDER BY sequence LIMIT 1)) oldest),"
              " sum(succeeded)::bigint, sum(failed)::bigint,"
              " sum(cancelled)::bigint, sum(crashed)::bigint, hosts, workers, busy,"
              " sum(n[6])::bigint, sum(n[7])::bigint"
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
        counts->tasks[0] = pg_int(&query, 0, 13);
        counts->tasks[1] = pg_int(&query, 0, 14);
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
        store, "SELECT coalesce(sum(queued - tasks), 0)::bigint, coalesce(sum(running), 0)::bigint,"
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
                                  " WHERE sequence = (SELECT draped.lock_family($2))"
                                  " AND status < " SQL_FIRST_ENDED " RETURNING 1");
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
        postgres_query(store, "WITH gone AS (DELETE FROM draped.jobs WHERE sequence ="
                              " (SELECT draped.lock_family($1)) RETURNING sequence, result),"
                              " with_it AS (DELETE FROM draped.requests USING gone"
                              " WHERE job = gone.sequence)"
                              " SELECT count(*), draped.forget_results(array_agg(result))"
                              " FROM gone HAVING count(*) > 0");
    pg_bind_text(&query, id);
    return postgres_end(&query, pg_run(&query), STORE_EMPTY);
}
