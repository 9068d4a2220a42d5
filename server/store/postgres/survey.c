/* SPDX-License-Identifier: MIT */
#include "server/store/survey.h"
#include "pool.h"
#include "postgres.h"
#include "server/store/sql.h"
#include <stdio.h>

enum { PATIENCE_MS = 10000 };

static bool read_schema(struct pool *pool, struct survey *survey) {
    struct pg_query query =
        pg_query(pool, "SELECT max(version), (extract(epoch FROM clock_timestamp())"
                       " * 1000000)::bigint FROM draped.schema_version");
    if (pg_run(&query)) {
        survey->schema = pg_int(&query, 0, 0);
        survey->now = pg_int(&query, 0, 1);
    }
    return pg_end(&query) == STORE_OK;
}

static bool read_hosts(struct pool *pool, struct survey *survey) {
    struct pg_query query =
        pg_query(pool, "SELECT host, role, version, workers, busy, seen FROM draped.hosts"
                       " ORDER BY seen DESC, host LIMIT $1");
    pg_bind_int(&query, SURVEY_HOSTS);
    survey->host_count = pg_run(&query);
    for (size_t k = 0; k < survey->host_count; k++) {
        struct store_host *host = &survey->hosts[k].host;
        pg_copy(&query, k, 0, host->host, sizeof host->host);
        pg_copy(&query, k, 1, host->role, sizeof host->role);
        pg_copy(&query, k, 2, host->version, sizeof host->version);
        host->workers = pg_int(&query, k, 3);
        host->busy = pg_int(&query, k, 4);
        survey->hosts[k].seen = pg_int(&query, k, 5);
    }
    return pg_end(&query) == STORE_OK;
}

static bool read_failure(struct pool *pool, struct survey *survey) {
    struct pg_query query =
        pg_query(pool, "SELECT id, finished, error FROM draped.jobs WHERE kind <> " SQL_TASK
                       " AND status = " SQL_FAILED " ORDER BY sequence DESC LIMIT 1");
    if (pg_run(&query)) {
        pg_copy(&query, 0, 0, survey->failed, sizeof survey->failed);
        survey->failed_at = pg_int(&query, 0, 1);
        pg_copy(&query, 0, 2, survey->error, sizeof survey->error);
    }
    return pg_end(&query) == STORE_OK;
}

bool postgres_survey(const char *url, struct survey *survey, char why[STORE_WHY_SIZE]) {
    struct pool *pool = pool_open(url, PATIENCE_MS, why);
    if (!pool)
        return false;
    bool good = read_schema(pool, survey);
    if (!good)
        pool_say(why, "the database holds no store of draped, or it cannot be read (see above)");
    else if (!store_schema_known("the store", survey->schema, why))
        good = false;
    else if (!(good = postgres_read_counts(pool, survey->now, &survey->counts) == STORE_OK &&
                      read_hosts(pool, survey) && read_failure(pool, survey)))
        pool_say(why, "the database cannot be read (see above)");
    pool_close(pool);
    return good;
}
