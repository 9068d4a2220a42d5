/* SPDX-License-Identifier: MIT */
#include "postgres.h"

/* Rows that are long silent go by the way; what others hold is left. */
static const char beat_sql[] =
    "WITH " POSTGRES_USABLE ", gone AS (DELETE FROM draped.hosts WHERE name IN"
    " (SELECT name FROM draped.hosts WHERE seen < " POSTGRES_NOW " - $8 FOR UPDATE SKIP LOCKED)"
    " AND name <> $2)"
    " INSERT INTO draped.hosts AS h VALUES ($2, $3, $4, $5, $6, $7, " POSTGRES_NOW ")"
    " ON CONFLICT (name) DO UPDATE SET host = excluded.host, role = excluded.role,"
    " version = excluded.version, workers = excluded.workers, busy = excluded.busy,"
    " seen = greatest(h.seen + 1, excluded.seen) RETURNING " POSTGRES_LAZY;

/* After a full disk was seen, that a row is written over is not enough. */
enum store_answer postgres_beat(struct store *store, const struct store_host *host) {
    struct pg_query query = postgres_query_now(store, beat_sql);
    pg_bind_text(&query, host->name);
    pg_bind_text(&query, host->host);
    pg_bind_text(&query, host->role);
    pg_bind_text(&query, host->version);
    pg_bind_int(&query, host->workers);
    pg_bind_int(&query, host->busy);
    pg_bind_int(&query, STORE_FORGOTTEN_US);
    enum store_answer answer = postgres_end(&query, pg_run(&query), STORE_DOWN);
    if (answer == STORE_OK)
        answer = postgres_try_claim(store);
    if (answer == STORE_OK && store_health(store) == STORE_NO_SPACE)
        answer = postgres_grow(store);
    return answer == STORE_CONFLICT ? STORE_DOWN : answer;
}

/* If it cannot be removed it ages. */
void postgres_leave(struct store *store, const char *name) {
    struct pg_query query =
        postgres_query(store, "DELETE FROM draped.hosts WHERE name = $1 RETURNING 1");
    pg_bind_text(&query, name);
    pg_run(&query);
    enum store_answer answer = pg_end(&query);
    (void)answer;
}
