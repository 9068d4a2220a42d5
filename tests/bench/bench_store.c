/* SPDX-License-Identifier: MIT */
/*
 * What the store costs: each operation for itself, the same from eight threads at once, and a claim
 * beside ever more jobs that have ended. Usage: bench_store URL, an empty database or a new file.
 */
#include "server/log.h"
#include "server/store/postgres/pool.h"
#include "server/store/postgres/statement.h"
#include "server/store/sqlite/db.h"
#include "server/store/store.h"
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { JOBS = 300, THREADS = 8, RESULT_BYTES = 170000 };

static void must(bool good, const char *what) {
    if (good)
        return;
    fprintf(stderr, "bench_store: %s failed\n", what);
    exit(1);
}

static double now_us(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec * 1e6 + (double)now.tv_nsec / 1e3;
}

static int ascending(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void print_times(const char *what, double *us, size_t count) {
    qsort(us, count, sizeof *us, ascending);
    printf("  %-34s %9.0f %9.0f\n", what, us[count / 2], us[count - 1 - count / 100]);
}

/* ------------------------------------------------------------------ operations */

static void submit(struct store *store, const char *prefix, int number) {
    static char request[1000]; /* as large as a small one */
    char digest[64];
    struct store_receipt receipt;
    snprintf(digest, sizeof digest, "%s %d", prefix, number);
    struct store_submission submission = {
        .request = request, .request_length = sizeof request, .digest = digest};
    must(store_submit(store, &submission, &receipt) == STORE_OK, "submit");
}

static void commit(struct store *store, const struct store_claim *claim) {
    static const unsigned char bytes[RESULT_BYTES];
    struct store_writer *writer = store_writer_new(store, claim);
    must(writer && store_writer_append(writer, bytes, sizeof bytes) == STORE_OK &&
             store_writer_commit(writer, "{\"nodes\":841}") == STORE_OK,
         "commit");
    store_writer_free(writer);
}

/* What PostgreSQL has written to its log so far; 0 for SQLite. */
static int64_t log_bytes(const char *url) {
    char why[STORE_WHY_SIZE];
    struct pool *pool = store_url_remote(url) ? pool_open(url, 60000, why) : NULL;
    if (!pool)
        return 0;
    struct query query =
        pg_query(pool, "SELECT (pg_current_wal_insert_lsn() - '0/0'::pg_lsn)::bigint");
    int64_t bytes = query_row(&query) ? query_int(&query, 0) : 0;
    must(query_end(&query) == STORE_OK, "position in the log");
    pool_close(pool);
    return bytes;
}

static void bench_operations(struct store *store, const char *url) {
    int64_t written = log_bytes(url);
    static double us[7][JOBS];
    for (int k = 0; k < JOBS; k++) {
        struct store_claim claim;
        struct store_job job;
        struct store_sweep sweep;
        double t[8];
        t[0] = now_us();
        submit(store, "one", k);
        t[1] = now_us();
        must(store_claim(store, &claim) == STORE_OK, "claim");
        t[2] = now_us();
        must(store_renew(store, &claim, 0.5) == STORE_OK, "renew");
        t[3] = now_us();
        must(store_check(store, &claim) == STORE_OK, "check");
        t[4] = now_us();
        commit(store, &claim);
        t[5] = now_us();
        must(store_get(store, claim.id, &job) == STORE_OK, "get");
        t[6] = now_us();
        must(store_claim(store, &claim) == STORE_EMPTY, "claim of nothing");
        t[7] = now_us();
        store_job_clear(&job);
        for (int n = 0; n < 7; n++)
            us[n][k] = t[n + 1] - t[n];
        if (k % 100 == 0)
            must(store_sweep(store, &sweep) == STORE_OK, "sweep");
    }
    static const char *const names[] = {
        "submit", "claim", "renew", "check", "commit of 170 kB", "get", "claim of an empty queue"};
    printf("  %-34s %9s %9s\n", "one caller, us", "median", "99 %");
    for (int n = 0; n < 7; n++)
        print_times(names[n], us[n], JOBS);
    written = log_bytes(url) - written;
    if (written > 0)
        printf("  %-34s %9.0f\n", "log of such a drape, bytes", (double)written / JOBS);
}

/* ------------------------------------------------------------------ many callers */

struct caller {
    struct store *store;
    char name[16];
    struct store_claim claims[JOBS];
    pthread_t thread;
};

static void *submit_many(void *context) {
    struct caller *caller = context;
    for (int k = 0; k < JOBS; k++)
        submit(caller->store, caller->name, k);
    return NULL;
}

static void *claim_many(void *context) {
    struct caller *caller = context;
    for (int k = 0; k < JOBS; k++)
        must(store_claim(caller->store, &caller->claims[k]) == STORE_OK, "claim");
    return NULL;
}

static void *fail_claimed(void *context) {
    struct caller *caller = context;
    for (int k = 0; k < JOBS; k++)
        must(store_fail(caller->store, &caller->claims[k], "{}") == STORE_OK, "fail");
    return NULL;
}

static void *claim_nothing(void *context) {
    struct caller *caller = context;
    struct store_claim claim;
    for (int k = 0; k < JOBS; k++)
        must(store_claim(caller->store, &claim) == STORE_EMPTY, "claim of nothing");
    return NULL;
}

static void run_callers(struct store *store, const char *what, void *(*act)(void *context)) {
    static struct caller callers[THREADS];
    double begun = now_us();
    for (int k = 0; k < THREADS; k++) {
        callers[k].store = store;
        snprintf(callers[k].name, sizeof callers[k].name, "caller %d", k);
        must(pthread_create(&callers[k].thread, NULL, act, &callers[k]) == 0, "thread");
    }
    for (int k = 0; k < THREADS; k++)
        pthread_join(callers[k].thread, NULL);
    printf("  %-34s %9.0f\n", what, THREADS * JOBS / (now_us() - begun) * 1e6);
}

/* ------------------------------------------------------------------ beside jobs that have ended */

/* Jobs that ended, with request and result, made by the database itself. Counting so many one by
 * one in a transaction would take PostgreSQL for ever. */
static const char ended_sqlite[] =
    "BEGIN;"
    "INSERT INTO results (digest, state, job, token, length, summary)"
    " WITH RECURSIVE n (k) AS (SELECT %d UNION ALL SELECT k + 1 FROM n WHERE k < %d)"
    " SELECT 'ended ' || k, 1, 0, 0, 170000, '{\"nodes\":841}' FROM n;"
    "INSERT INTO jobs (id, status, rank, priority, owner, digest, created, started, finished,"
    " progress, attempts, token, result)"
    " SELECT lower(hex(randomblob(16))), 2, r.number, 0, '', r.digest, 1, 1,"
    "  strftime('%%s', 'now') * 1000000, 1, 1, 1, r.number FROM results r WHERE r.job = 0;"
    "INSERT INTO requests (job, bytes) SELECT j.sequence, zeroblob(1000) FROM jobs j"
    " JOIN results r ON r.number = j.result WHERE r.job = 0;"
    "UPDATE results SET job = 1 WHERE job = 0;"
    "COMMIT";

static const char ended_postgres[] =
    "ALTER TABLE draped.jobs DISABLE TRIGGER USER;"
    "ALTER TABLE draped.results DISABLE TRIGGER USER;"
    "WITH made AS (INSERT INTO draped.results (digest, state, job, token, length, summary)"
    "  SELECT 'ended ' || k, 1, 1, 1, 170000, '{\"nodes\":841}' FROM generate_series(%d, %d) k"
    "  RETURNING number, digest),"
    " ended AS (INSERT INTO draped.jobs (id, status, rank, priority, owner, digest, created,"
    "  started, finished, progress, attempts, token, result)"
    "  SELECT md5(digest), 2, number, 0, '', digest, 1, 1,"
    "   (extract(epoch FROM clock_timestamp()) * 1000000)::bigint, 1, 1, 1, number FROM made"
    "  RETURNING sequence)"
    " INSERT INTO draped.requests (job, bytes)"
    "  SELECT sequence, decode(repeat('00', 1000), 'hex') FROM ended;"
    "UPDATE draped.counts SET n[3] = n[3] + %d - %d + 1 WHERE slot = 0;"
    "UPDATE draped.owners SET results = results + 170000 WHERE owner = '' AND slot ="
    " (SELECT min(slot) FROM draped.owners WHERE owner = '');"
    "ALTER TABLE draped.results ENABLE TRIGGER USER;"
    "ALTER TABLE draped.jobs ENABLE TRIGGER USER";

static void add_ended(const char *url, int from, int to) {
    enum { STEP = 20000 };
    char why[STORE_WHY_SIZE], sql[2048];
    bool remote = store_url_remote(url);
    struct pool *pool = remote ? pool_open(url, 60000, why) : NULL;
    struct db *db = remote ? NULL : db_open(url, 60000, why);
    must(pool || db, "open");
    for (int k = from; k < to; k += STEP) {
        int last = (k + STEP < to ? k + STEP : to) - 1;
        if (remote)
            snprintf(sql, sizeof sql, ended_postgres, k, last, last, k);
        else
            snprintf(sql, sizeof sql, ended_sqlite, k, last);
        must(remote ? pg_script(pool, sql, NULL, why) : db_script(db, sql) == STORE_OK,
             "ended jobs");
    }
    /* What the server has to tidy up after so large an insertion is not what is measured. */
    must(!pool || (pg_script(pool, "VACUUM ANALYZE", NULL, why) &&
                   pg_script(pool, "CHECKPOINT", NULL, why)),
         "vacuum");
    pool_close(pool);
    db_close(db);
}

static void bench_claims(struct store *store, const char *url) {
    static const int levels[] = {100, 10000, 1000000};
    double us[JOBS];
    int ended = 0;
    printf("  %-34s %9s %9s\n", "a claim, us, jobs that have ended:", "median", "99 %");
    for (size_t n = 0; n < sizeof levels / sizeof *levels; n++) {
        char what[32], prefix[32];
        struct store_claim claim;
        add_ended(url, ended, levels[n]);
        ended = levels[n];
        snprintf(prefix, sizeof prefix, "beside %d", ended);
        for (int k = 0; k < JOBS; k++)
            submit(store, prefix, k);
        for (int k = 0; k < JOBS; k++) {
            double begun = now_us();
            must(store_claim(store, &claim) == STORE_OK, "claim");
            us[k] = now_us() - begun;
            must(store_fail(store, &claim, "{}") == STORE_OK, "fail");
        }
        snprintf(what, sizeof what, "%d", ended);
        print_times(what, us, JOBS);
    }
}

int main(int argc, char **argv) {
    struct store_options options = store_options_default;
    char why[STORE_WHY_SIZE] = "";
    struct job_events *events = job_events_new();
    options.shared = true;
    options.queue_limit = 1000000;
    must(argc == 2 && events && id_init(), "usage: bench_store URL");
    struct store *store = store_open(argv[1], &options, events, why);
    if (!store)
        fprintf(stderr, "%s\n", why);
    must(store, "open");
    bench_operations(store, argv[1]);
    printf("  %-34s %9s\n", "eight callers", "a second");
    run_callers(store, "submit", submit_many);
    run_callers(store, "claim", claim_many);
    run_callers(store, "fail", fail_claimed);
    run_callers(store, "claim of an empty queue", claim_nothing);
    bench_claims(store, argv[1]);
    store_close(store);
    job_events_free(events);
    return 0;
}
