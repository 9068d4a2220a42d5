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
    struct query query = postgres_query_now(store, beat_sql);
    query_bind(&query, of_text(host->name), of_text(host->host), of_text(host->role),
               of_text(host->version), of_int(host->workers), of_int(host->busy),
               of_int(STORE_FORGOTTEN_US));
    enum store_answer answer = query_find(&query, STORE_DOWN);
    if (answer == STORE_OK)
        answer = postgres_try_claim(store);
    if (answer == STORE_OK && store_health(store) == STORE_NO_SPACE)
        answer = postgres_grow(store);
    return answer == STORE_CONFLICT ? STORE_DOWN : answer;
}

/* If it cannot be removed it ages. */
void postgres_leave(struct store *store, const char *name) {
    struct query query =
        postgres_query(store, "DELETE FROM draped.hosts WHERE name = $1 RETURNING 1");
    query_bind(&query, of_text(name));
    (void)!query_run(&query);
}
