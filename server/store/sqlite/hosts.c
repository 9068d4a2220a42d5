/* SPDX-License-Identifier: MIT */
#include "sqlite.h"

/* A column that is gone fails the statement when it is prepared. */
static const char usable_sql[] =
    "SELECT j.summary, j.summary_seal, j.error, j.error_seal, j.result, j.excused, j.origin,"
    " r.digest, r.owner, r.job, r.token, r.length, r.summary, r.summary_seal, c.id, c.seal, "
    "c.bytes,"
    " q.job, q.seal, q.bytes, s.id, s.owner, s.seal, s.definition, m.id, m.owner, m.seal,"
    " m.definition, t.bytes, e.n FROM jobs j, results r, chunks c, requests q, surfaces s,"
    " materials m, stored t, ended e WHERE 0";

/* Alone with the database, a process knows that all others are gone. */
static enum store_answer beat_operation(struct sqlite_store *store, struct db *db, void *context) {
    const struct store_host *host = context;
    int64_t now = sqlite_now(store);
    struct query query = db_query(db, "DELETE FROM hosts WHERE name <> ? AND (? OR seen < ?)");
    query_bind(&query, of_text(host->name), of_int(!sqlite_options(store)->shared),
               of_int(now - STORE_FORGOTTEN_US));
    enum store_answer answer = query_run(&query);
    if (answer != STORE_OK)
        return answer;
    query = db_query(db, "INSERT INTO hosts VALUES (?, ?, ?, ?, ?, ?, ?)"
                         " ON CONFLICT (name) DO UPDATE SET host = excluded.host,"
                         " role = excluded.role, version = excluded.version,"
                         " workers = excluded.workers, busy = excluded.busy,"
                         " seen = max(seen + 1, excluded.seen)");
    query_bind(&query, of_text(host->name), of_text(host->host), of_text(host->role),
               of_text(host->version), of_int(host->workers), of_int(host->busy), of_int(now));
    answer = query_run(&query);
    if (answer == STORE_OK)
        answer = db_run(db, usable_sql);
    return answer == STORE_OK ? sqlite_try_claim(store, db) : answer;
}

/* After a failure the log is taken as well: that the database itself can be written is known then.
 */
enum store_answer sqlite_beat(struct store *store, const struct store_host *host) {
    struct store_host own = *host;
    bool broken = sqlite_broken(sqlite_of(store));
    enum store_answer answer = sqlite_room_for(store, 0);
    if (answer == STORE_OK)
        answer = sqlite_write(store, DB_LAZY, beat_operation, &own);
    return answer == STORE_OK && broken ? sqlite_take_log(store) : answer;
}

/* If it cannot be removed it ages. */
void sqlite_leave(struct store *store, const char *name) {
    struct query query = {.sql = "DELETE FROM hosts WHERE name = ?"};
    query_bind(&query, of_text(name));
    (void)!sqlite_change(store, DB_LAZY, &query, STORE_EMPTY);
}
