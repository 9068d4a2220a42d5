/* SPDX-License-Identifier: MIT */
#include "server/clock.h"
#include "sqlite.h"
#include <stdio.h>

/* Marks a file as ours: "drap". */
enum { APPLICATION = 0x64726170 };

/*
 * Schema 1.
 *
 * jobs.rank orders the queue of an owner: the time of creation less a minute a step of priority, so
 * that priority and age are one number that never has to be updated. jobs.key_digest is of the body
 * posted with the idempotency key. jobs.token is the fencing token of the latest claim.
 * jobs.excused counts the attempts that are not held against the job. chunks.id is result * 2^24 +
 * index. counts is kept by triggers: counting rows would cost more with every job.
 */
static const char schema_1[] =
    "CREATE TABLE schema_version (version INTEGER NOT NULL, applied INTEGER NOT NULL);"

    "CREATE TABLE results ("
    " number INTEGER PRIMARY KEY AUTOINCREMENT,"
    " digest TEXT NOT NULL,"
    " state INTEGER NOT NULL," /* RESULT_BUILDING, ... */
    " job INTEGER NOT NULL,"   /* while building: by this claim */
    " token INTEGER NOT NULL,"
    " length INTEGER NOT NULL,"
    " summary TEXT);"
    "CREATE UNIQUE INDEX results_digest ON results (digest) WHERE state = 1;"
    "CREATE INDEX results_unfinished ON results (state) WHERE state <> 1;"

    "CREATE TABLE chunks (id INTEGER PRIMARY KEY, bytes BLOB NOT NULL);"

    "CREATE TABLE jobs ("
    " sequence INTEGER PRIMARY KEY AUTOINCREMENT,"
    " id TEXT NOT NULL UNIQUE,"
    " status INTEGER NOT NULL," /* enum store_status */
    " rank INTEGER NOT NULL,"
    " priority INTEGER NOT NULL,"
    " owner TEXT NOT NULL,"
    " digest TEXT NOT NULL,"
    " surface TEXT,"
    " key TEXT,"
    " key_digest BLOB,"
    " created INTEGER NOT NULL,"
    " started INTEGER NOT NULL DEFAULT 0,"
    " finished INTEGER NOT NULL DEFAULT 0,"
    " progress REAL NOT NULL DEFAULT 0,"
    " attempts INTEGER NOT NULL DEFAULT 0,"
    " excused INTEGER NOT NULL DEFAULT 0,"
    " token INTEGER NOT NULL DEFAULT 0,"
    " lease INTEGER,"
    " holder TEXT,"
    " result INTEGER REFERENCES results (number),"
    " summary TEXT," /* kept here when the result has expired */
    " error TEXT,"
    " expired INTEGER NOT NULL DEFAULT 0);"
    "CREATE INDEX jobs_queue ON jobs (rank, sequence) WHERE status = 0;"
    "CREATE INDEX jobs_lease ON jobs (lease) WHERE status = 1;"
    "CREATE INDEX jobs_status ON jobs (status, sequence);"
    "CREATE INDEX jobs_finished ON jobs (expired, finished) WHERE status >= 2;"
    "CREATE INDEX jobs_result ON jobs (result) WHERE result IS NOT NULL;"
    "CREATE INDEX jobs_surface ON jobs (surface) WHERE surface IS NOT NULL AND status < 2;"
    "CREATE UNIQUE INDEX jobs_key ON jobs (owner, key) WHERE key IS NOT NULL;"

    "CREATE TABLE requests (job INTEGER PRIMARY KEY, bytes BLOB NOT NULL);"

    "CREATE TABLE surfaces ("
    " sequence INTEGER PRIMARY KEY AUTOINCREMENT,"
    " id TEXT NOT NULL UNIQUE,"
    " owner TEXT NOT NULL,"
    " created INTEGER NOT NULL,"
    " description TEXT NOT NULL,"
    " definition BLOB NOT NULL);"

    "CREATE TABLE probe (n INTEGER NOT NULL);" /* written to find out whether that works */
    "INSERT INTO probe VALUES (0);"

    "CREATE TABLE counts (status INTEGER PRIMARY KEY, n INTEGER NOT NULL);"
    "INSERT INTO counts VALUES (0, 0), (1, 0), (2, 0), (3, 0), (4, 0);"
    "CREATE TRIGGER jobs_inserted AFTER INSERT ON jobs BEGIN"
    " UPDATE counts SET n = n + 1 WHERE status = new.status; END;"
    "CREATE TRIGGER jobs_deleted AFTER DELETE ON jobs BEGIN"
    " UPDATE counts SET n = n - 1 WHERE status = old.status; END;"
    "CREATE TRIGGER jobs_moved AFTER UPDATE OF status ON jobs"
    " WHEN new.status <> old.status BEGIN"
    " UPDATE counts SET n = n - 1 WHERE status = old.status;"
    " UPDATE counts SET n = n + 1 WHERE status = new.status; END;";

/* Schema 2: shares of owners. The queue is in the order of each owner, and what runs of whom can be
 * counted. */
static const char schema_2[] =
    "DROP INDEX jobs_queue;"
    "CREATE INDEX jobs_queue ON jobs (owner, rank, sequence) WHERE status = 0;"
    "CREATE INDEX jobs_running ON jobs (owner) WHERE status = 1;";

/* Schema 3: surfaces are named by their content, and several owners may have the same. What one
 * owner has is listed by an index of his own. How much all results hold is known at any time. */
static const char schema_3[] =
    "CREATE TABLE owned_surfaces ("
    " sequence INTEGER PRIMARY KEY AUTOINCREMENT,"
    " id TEXT NOT NULL,"
    " owner TEXT NOT NULL,"
    " created INTEGER NOT NULL,"
    " description TEXT NOT NULL,"
    " definition BLOB NOT NULL,"
    " UNIQUE (id, owner));"
    "INSERT INTO owned_surfaces SELECT sequence, id, owner, created, description, definition"
    " FROM surfaces;"
    "DROP TABLE surfaces;"
    "ALTER TABLE owned_surfaces RENAME TO surfaces;"
    "CREATE TABLE stored (bytes INTEGER NOT NULL);" /* of complete results, kept by triggers */
    "INSERT INTO stored SELECT coalesce(sum(length), 0) FROM results WHERE state = 1;"
    "CREATE TRIGGER results_inserted AFTER INSERT ON results WHEN new.state = 1 BEGIN"
    " UPDATE stored SET bytes = bytes + new.length; END;"
    "CREATE TRIGGER results_deleted AFTER DELETE ON results WHEN old.state = 1 BEGIN"
    " UPDATE stored SET bytes = bytes - old.length; END;"
    "CREATE TRIGGER results_changed AFTER UPDATE OF state, length ON results"
    " WHEN old.state = 1 OR new.state = 1 BEGIN"
    " UPDATE stored SET bytes = bytes + (new.state = 1) * new.length - (old.state = 1) * "
    "old.length;"
    " END;"
    "CREATE INDEX surfaces_owner ON surfaces (owner, sequence);"
    "CREATE INDEX jobs_owner ON jobs (owner, sequence);";

/* Migrations in order: the n-th leads to version n. */
static const char *const migrations[] = {schema_1, schema_2, schema_3};

enum { CURRENT = sizeof migrations / sizeof migrations[0] };

static bool read_number(struct db *db, const char *sql, int64_t *number) {
    struct query query = db_query(db, sql);
    *number = query_row(&query) ? query_int(&query, 0) : 0;
    return query_end(&query) == STORE_OK;
}

/* The version of the file: 0 for an empty one, -1 for one that is not ours. */
static bool read_version(struct db *db, int64_t *version) {
    int64_t application = 0;
    int64_t tables = 0;
    if (!read_number(db, "SELECT application_id FROM pragma_application_id", &application) ||
        !read_number(db, "SELECT count(*) FROM sqlite_schema", &tables))
        return false;
    *version = tables == 0 ? 0 : -1;
    if (tables == 0 || application != APPLICATION)
        return true;
    return read_number(db, "SELECT max(version) FROM schema_version", version);
}

static bool apply(struct db *db, int64_t version) {
    if (db_script(db, migrations[version - 1]) != STORE_OK)
        return false;
    struct query query = db_query(db, "INSERT INTO schema_version VALUES (?, ?)");
    query_bind_int(&query, version);
    query_bind_int(&query, clock_utc_us());
    return query_run(&query) == STORE_OK;
}

bool sqlite_migrate(struct db *db, char why[STORE_WHY_SIZE]) {
    int64_t version = 0;
    if (!read_version(db, &version)) {
        db_explain(db, why);
        return false;
    }
    if (version < 0) {
        snprintf(why, STORE_WHY_SIZE, "the database %s belongs to another program", db_path(db));
        return false;
    }
    if (version > CURRENT) {
        snprintf(
            why, STORE_WHY_SIZE,
            "the database %s has schema %lld, this version of draped knows %d: use a newer one",
            db_path(db), (long long)version, (int)CURRENT);
        return false;
    }
    bool good = version > 0 || db_script(db, "PRAGMA application_id = 0x64726170") == STORE_OK;
    while (good && version < CURRENT)
        good = apply(db, ++version);
    if (!good)
        db_explain(db, why);
    return good;
}
