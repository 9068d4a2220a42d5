/* SPDX-License-Identifier: MIT */
#include "server/store/survey.h"
#include "pool.h"
#include "postgres.h"

enum { PATIENCE_MS = 10000 };

bool postgres_survey(const char *url, survey_look *look, void *context, char why[STORE_WHY_SIZE]) {
    int64_t now;
    struct pool *pool = pool_open(url, PATIENCE_MS, why);
    if (!pool)
        return false;
    const struct reader reader = postgres_reader(pool);
    struct query query =
        pg_query(pool, "SELECT (extract(epoch FROM clock_timestamp()) * 1000000)::bigint");
    bool good =
        query_number(&query, STORE_OK, &now) == STORE_OK && look(&reader, now, context, why);
    if (!good && !why[0])
        pool_say(why, "the database has no store of draped, or it cannot be read (see above)");
    pool_close(pool);
    return good;
}
