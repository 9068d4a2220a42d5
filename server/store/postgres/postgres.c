/* SPDX-License-Identifier: MIT */
#include "postgres.h"
#include <stdio.h>
#include <stdlib.h>

struct postgres_store {
    struct store base;
    struct store_options options;
    struct pg *pg;
    struct bell *bell;
};

static struct postgres_store *postgres_of(struct store *store) {
    return (struct postgres_store *)store;
}

const struct store_options *postgres_options(struct store *store) {
    return &postgres_of(store)->options;
}

struct pg_query postgres_query(struct store *store, const char *sql) {
    return pg_query(postgres_of(store)->pg, sql);
}

struct pg_query postgres_query_now(struct store *store, const char *sql) {
    const struct postgres_store *postgres = postgres_of(store);
    struct pg_query query = pg_query(postgres->pg, sql);
    if (postgres->options.clock)
        pg_bind_int(&query, postgres->options.clock());
    else
        pg_bind_no_int(&query);
    return query;
}

enum store_answer postgres_end(struct pg_query *query, size_t rows, enum store_answer none) {
    enum store_answer answer = pg_end(query);
    return answer == STORE_OK && rows == 0 ? none : answer;
}

/* ------------------------------------------------------------------ open and close */

static void postgres_close(struct store *base) {
    struct postgres_store *store = postgres_of(base);
    bell_stop(store->bell);
    pg_close(store->pg);
    free(store);
}

/* A primary that has become a replica is as good as none. */
static enum store_answer postgres_ping(struct store *store) {
    struct pg_query query = postgres_query(store, "SELECT 1 FROM draped.schema_version"
                                                  " WHERE NOT pg_is_in_recovery() LIMIT 1");
    return postgres_end(&query, pg_run(&query), STORE_DOWN);
}

static void postgres_announce(struct store *store, const char *subject) {
    bell_ring(postgres_of(store)->bell, subject);
}

static const struct store_ops postgres_ops = {
    .close = postgres_close,
    .announce = postgres_announce,
    .ping = postgres_ping,
    .submit = postgres_submit,
    .get = postgres_get,
    .request = postgres_request,
    .list = postgres_list,
    .cancel = postgres_cancel,
    .remove = postgres_remove,
    .counts = postgres_counts,
    .claim = postgres_claim,
    .renew = postgres_renew,
    .check = postgres_check,
    .fail = postgres_fail,
    .crashed = postgres_crashed,
    .release = postgres_release,
    .sweep = postgres_sweep,
    .result_append = postgres_result_append,
    .result_commit = postgres_result_commit,
    .result_drop = postgres_result_drop,
    .result_find = postgres_result_find,
    .result_read = postgres_result_read,
    .surface_put = postgres_surface_put,
    .surface_get = postgres_surface_get,
    .surface_list = postgres_surface_list,
    .surface_delete = postgres_surface_delete,
};

struct store *store_postgres_open(const char *url, const struct store_options *options,
                                  struct hub *hub, char why[STORE_WHY_SIZE]) {
    struct postgres_store *store = calloc(1, sizeof *store);
    if (!store) {
        snprintf(why, STORE_WHY_SIZE, "no memory for the database");
        return NULL;
    }
    store->base.ops = &postgres_ops;
    store->base.hub = hub;
    store->options = *options;
    store->pg = pg_open(url, options->busy_ms, why);
    if (store->pg && postgres_migrate(store->pg, why)) {
        store->bell = bell_start(store->pg, hub);
        if (store->bell)
            return &store->base;
        snprintf(why, STORE_WHY_SIZE, "no memory or thread for notifications");
    }
    postgres_close(&store->base);
    return NULL;
}
