/* SPDX-License-Identifier: MIT */
#include "postgres.h"
#include "notify.h"
#include "pool.h"
#include <stdio.h>
#include <stdlib.h>

struct postgres_store {
    struct store base;
    struct pool *pool;
    struct notify *notify;
};

static struct postgres_store *postgres_of(struct store *store) {
    return (struct postgres_store *)store;
}

struct query postgres_query(struct store *store, const char *sql) {
    return pg_query(postgres_of(store)->pool, sql);
}

struct query postgres_query_now(struct store *store, const char *sql) {
    int64_t (*clock)(void) = store->options.clock;
    struct query query = postgres_query(store, sql);
    query_bind(&query, clock ? of_int(clock()) : of_no_int());
    return query;
}

struct query postgres_held_query(struct store *store, const char *sql,
                                 const struct store_claim *claim) {
    struct query query = postgres_query_now(store, sql);
    query_bind(&query, of_int(claim->sequence), of_int(claim->token));
    return query;
}

/* ------------------------------------------------------------------ open and close */

static void postgres_close(struct store *base) {
    struct postgres_store *store = postgres_of(base);
    notify_stop(store->notify);
    pool_close(store->pool);
    free(store);
}

/* A primary that has become a replica is as good as none. */
static enum store_answer postgres_ping(struct store *store) {
    struct query query = postgres_query(store, "SELECT 1 FROM draped.schema_version"
                                               " WHERE NOT pg_is_in_recovery() LIMIT 1");
    return query_find(&query, STORE_DOWN);
}

/* Rows that need new pages, which others find and use again. */
enum store_answer postgres_grow(struct store *store) {
    char why[STORE_WHY_SIZE];
    bool good =
        pg_script(postgres_of(store)->pool,
                  "INSERT INTO draped.chunks SELECT -1, pg_backend_pid(), 0,"
                  " decode(string_agg(md5(random()::text), ''), 'hex')"
                  " FROM generate_series(1, 65536);"
                  "DELETE FROM draped.chunks WHERE result = -1 AND index = pg_backend_pid()",
                  NULL, why);
    return good ? STORE_OK : STORE_NO_SPACE;
}

static void postgres_announce(struct store *store, const char *subject) {
    notify_announce(postgres_of(store)->notify, subject);
}

/* Numbers of statuses are the places in `counts.n`. */
static const struct dialect dialect = {
    .counts = "SELECT k + CASE WHEN k > 5 THEN 2 ELSE -1 END, CAST(sum(n[k]) AS bigint)"
              " FROM draped.counts, generate_series(1, 7) k GROUP BY k"
              " UNION ALL SELECT 12, CAST(sum(succeeded) AS bigint) FROM draped.counts"
              " UNION ALL SELECT 13, CAST(sum(failed) AS bigint) FROM draped.counts"
              " UNION ALL SELECT 14, CAST(sum(cancelled) AS bigint) FROM draped.counts"
              " UNION ALL SELECT 15, CAST(sum(crashed) AS bigint) FROM draped.counts",
    .hosts = "SELECT count(*), CAST(coalesce(sum(workers), 0) AS bigint),"
             " CAST(coalesce(sum(busy), 0) AS bigint) FROM draped.hosts"
             " WHERE seen > " POSTGRES_NOW " - $2",
    .chunk = "SELECT bytes, seal FROM draped.chunks WHERE result = $1 AND index = $2",
};

struct reader postgres_reader(struct pool *pool) {
    return (struct reader){pg_query, pool, &dialect};
}

static const struct store_ops postgres_ops = {
    .wall_leases = true,
    .fails_late = true,
    .close = postgres_close,
    .announce = postgres_announce,
    .ping = postgres_ping,
    .beat = postgres_beat,
    .leave = postgres_leave,
    .submit = postgres_submit,
    .submit_family = postgres_submit_family,
    .cancel = postgres_cancel,
    .remove = postgres_remove,
    .claim = postgres_claim,
    .starving = postgres_starving,
    .renew = postgres_renew,
    .fail = postgres_fail,
    .requeue = postgres_requeue,
    .begin_round = postgres_begin_round,
    .end_task = postgres_end_task,
    .change_task = postgres_change_task,
    .find_ended = postgres_find_ended,
    .take_over = postgres_take_over,
    .find_due = postgres_find_due,
    .step = postgres_step,
    .result_append = postgres_result_append,
    .result_commit = postgres_result_commit,
    .result_drop = postgres_result_drop,
    .item_put = postgres_item_put,
    .form_put = postgres_form_put,
    .item_delete = postgres_item_delete,
};

struct store *store_postgres_open(const char *url, const struct store_options *options,
                                  struct job_events *events, char why[STORE_WHY_SIZE]) {
    struct postgres_store *store = calloc(1, sizeof *store);
    if (!store) {
        snprintf(why, STORE_WHY_SIZE, "no memory for the database");
        return NULL;
    }
    store->base.ops = &postgres_ops;
    store->base.events = events;
    store->base.options = *options;
    store->pool = pool_open(url, options->busy_ms, why);
    bool good = store->pool != NULL;
    if (good) { /* what must be so for answers to mean what they say */
        struct query query =
            pg_query(store->pool, "SELECT pg_is_in_recovery() OR"
                                  " current_setting('default_transaction_read_only') = 'on',"
                                  " current_setting('synchronous_commit') = 'off'");
        bool found = query_row(&query);
        bool read_only = found && query_int(&query, 0), loose = found && query_int(&query, 1);
        bool answered = query_end(&query) == STORE_OK;
        good = answered && !read_only && !loose;
        if (!answered)
            snprintf(why, STORE_WHY_SIZE, "the database does not answer (see the log)");
        else if (read_only)
            snprintf(why, STORE_WHY_SIZE,
                     "the database is a replica or set read-only: name the primary in the URL; "
                     "with several hosts there, add target_session_attrs=read-write");
        else if (loose)
            snprintf(why, STORE_WHY_SIZE,
                     "the database has synchronous_commit off for this user, so it could lose "
                     "drapes that were accepted: ALTER ROLE ... SET synchronous_commit = on");
    }
    if (good && postgres_prepare_tables(store->pool, why)) {
        store->base.reader = postgres_reader(store->pool);
        store->notify = notify_start(store->pool, events);
        if (store->notify)
            return &store->base;
        snprintf(why, STORE_WHY_SIZE, "no memory or thread for notifications");
    }
    postgres_close(&store->base);
    return NULL;
}
