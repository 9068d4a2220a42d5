/* SPDX-License-Identifier: MIT */
#include "survey.h"
#include "backend.h"
#include "sql.h"
#include <string.h>

bool survey_schema(const struct reader *reader, int64_t *schema, char why[STORE_WHY_SIZE]) {
    struct query query =
        reader->query(reader->of, "SELECT max(version) FROM draped.schema_version");
    return query_number(&query, STORE_OK, schema) == STORE_OK &&
           store_schema_known("the store", *schema, why);
}

static bool read_survey(const struct reader *reader, int64_t now, void *context,
                        char why[STORE_WHY_SIZE]) {
    struct survey *survey = context;
    survey->now = now;
    if (!survey_schema(reader, &survey->schema, why) ||
        reads_counts(reader, survey->now, &survey->counts) != STORE_OK)
        return false;
    struct query query = reader->query(
        reader->of, "SELECT host, role, version, workers, busy, seen FROM draped.hosts"
                    " ORDER BY seen DESC, host LIMIT $1");
    query_bind(&query, of_int(SURVEY_HOSTS));
    for (; survey->host_count < SURVEY_HOSTS && query_row(&query); survey->host_count++) {
        struct store_host *host = &survey->hosts[survey->host_count].host;
        query_copy(&query, 0, host->host, sizeof host->host);
        query_copy(&query, 1, host->role, sizeof host->role);
        query_copy(&query, 2, host->version, sizeof host->version);
        host->workers = query_int(&query, 3);
        host->busy = query_int(&query, 4);
        survey->hosts[survey->host_count].seen = query_int(&query, 5);
    }
    if (query_end(&query) != STORE_OK)
        return false;
    query = reader->query(reader->of,
                          "SELECT id, finished, error FROM draped.jobs WHERE kind IN (" SQL_DRAPE
                          ", " SQL_STUDY ", " SQL_LAMINATE ") AND status = " SQL_FAILED
                          " ORDER BY sequence DESC LIMIT 1");
    if (query_row(&query)) {
        query_copy(&query, 0, survey->failed, sizeof survey->failed);
        survey->failed_at = query_int(&query, 1);
        query_copy(&query, 2, survey->error, sizeof survey->error);
    }
    return query_end(&query) == STORE_OK;
}

bool survey_by(const char *url, survey_look *look, void *context, char why[STORE_WHY_SIZE]) {
    why[0] = '\0';
    return store_url_remote(url) ? postgres_survey(url, look, context, why)
                                 : sqlite_survey(store_url_path(url), look, context, why);
}

bool survey_store(const char *url, struct survey *survey, char why[STORE_WHY_SIZE]) {
    memset(survey, 0, sizeof *survey);
    return survey_by(url, read_survey, survey, why);
}
