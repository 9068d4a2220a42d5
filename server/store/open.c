/* SPDX-License-Identifier: MIT */
#include "backend.h"
#include <stdio.h>
#include <string.h>

const struct store_options store_options_default = {
    .queue_limit = 10000,
    .lease_us = INT64_C(60) * 1000000,
    .max_attempts = 3,
    .busy_ms = 5000,
    .retention_us = INT64_C(168) * 3600 * 1000000,
    .records_us = INT64_C(4) * 168 * 3600 * 1000000,
    .clock_trust_us = INT64_C(300) * 1000000,
};

bool store_schema_known(const char *what, int64_t schema, char why[STORE_WHY_SIZE]) {
    if (schema != STORE_SCHEMA)
        snprintf(why, STORE_WHY_SIZE, "%s has schema %lld, and this version of draped uses %d: %s",
                 what, (long long)schema, (int)STORE_SCHEMA,
                 schema > STORE_SCHEMA
                     ? "use a newer one"
                     : "use the older version that made it, or name an empty store by --store");
    return schema == STORE_SCHEMA;
}

bool store_url_remote(const char *url) {
    return !strncmp(url, "postgresql://", 13) || !strncmp(url, "postgres://", 11);
}

const char *store_url_path(const char *url) {
    return strncmp(url, "sqlite:", 7) ? url : url + 7;
}

/* A URL of an unknown kind may hold a password: it is not quoted. */
struct store *store_open(const char *url, const struct store_options *options,
                         struct job_events *events, char why[STORE_WHY_SIZE]) {
    const char *path = store_url_path(url);
    struct store *store = NULL;
    if (store_url_remote(url))
        store = store_postgres_open(url, options, events, why);
    else if (strstr(url, "://"))
        snprintf(why, STORE_WHY_SIZE,
                 "the store is of an unknown kind: give sqlite:PATH or postgresql://...");
    else if (!path[0] || path[0] == ':')
        snprintf(why, STORE_WHY_SIZE, "'%s' does not name a file: the store must be a file", url);
    else
        store = store_sqlite_open(path, options, events, why);
    if (!store)
        return NULL;
    pthread_mutex_init(&store->health.lock, NULL);
    pthread_mutex_init(&store->uncommitted.lock, NULL);
    id_make(store->health.host.name);
    store->cache = store_cache_new();
    bool keyed = reads_secret(store, store->secret) == STORE_OK;
    if (store->cache && keyed)
        return store;
    snprintf(why, STORE_WHY_SIZE, "%s",
             keyed ? "no memory for the store" : "the key of cursors cannot be read (see the log)");
    store_close(store);
    return NULL;
}
