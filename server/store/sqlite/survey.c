/* SPDX-License-Identifier: MIT */
#include "server/store/survey.h"
#include "server/clock.h"
#include "server/store/sql.h"
#include "sqlite.h"
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum { BUSY_MS = 5000 };

static enum store_answer read_hosts(struct db *db, struct survey *survey) {
    struct query query = db_query(db, "SELECT host, role, version, workers, busy, seen FROM hosts"
                                      " ORDER BY seen DESC, host LIMIT ?");
    query_bind_int(&query, SURVEY_HOSTS);
    for (size_t k = 0; k < SURVEY_HOSTS && query_row(&query); k++) {
        struct store_host *host = &survey->hosts[k].host;
        query_copy(&query, 0, host->host, sizeof host->host);
        query_copy(&query, 1, host->role, sizeof host->role);
        query_copy(&query, 2, host->version, sizeof host->version);
        host->workers = query_int(&query, 3);
        host->busy = query_int(&query, 4);
        survey->hosts[k].seen = query_int(&query, 5);
        survey->host_count = k + 1;
    }
    return query_end(&query);
}

static enum store_answer read_failure(struct db *db, struct survey *survey) {
    struct query query = db_query(
        db, "SELECT id, finished, error FROM jobs WHERE kind IN (" SQL_DRAPE ", " SQL_STUDY
            ", " SQL_LAMINATE ") AND status = " SQL_FAILED " ORDER BY sequence DESC LIMIT 1");
    if (query_row(&query)) {
        query_copy(&query, 0, survey->failed, sizeof survey->failed);
        survey->failed_at = query_int(&query, 1);
        query_copy(&query, 2, survey->error, sizeof survey->error);
    }
    return query_end(&query);
}

static bool read_all(struct db *db, struct survey *survey, char why[STORE_WHY_SIZE]) {
    struct query query = db_query(db, "SELECT max(version) FROM schema_version");
    survey->schema = query_row(&query) ? query_int(&query, 0) : 0;
    survey->now = clock_utc_us();
    if (query_end(&query) != STORE_OK) {
        db_explain(db, why);
        return false;
    }
    if (!store_schema_known("the store", survey->schema, why))
        return false;
    bool good = sqlite_read_counts(db, survey->now, &survey->counts) == STORE_OK &&
                read_hosts(db, survey) == STORE_OK && read_failure(db, survey) == STORE_OK;
    if (!good)
        db_explain(db, why);
    return good;
}

bool sqlite_survey(const char *path, struct survey *survey, char why[STORE_WHY_SIZE]) {
    if (access(path, R_OK) != 0) { /* opening it would make it */
        snprintf(why, STORE_WHY_SIZE, "the database %s: %s", path, strerror(errno));
        return false;
    }
    struct db *db = db_open(path, BUSY_MS, why);
    bool good = db && db_set_up(db, "PRAGMA query_only=ON", why) && read_all(db, survey, why);
    db_close(db);
    return good;
}
