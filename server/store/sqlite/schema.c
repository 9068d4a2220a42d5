/* SPDX-License-Identifier: MIT */
#include "server/clock.h"
#include "server/store/sql.h"
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

/* Schema 4: what each owner has is known at any time, and whose turn it is to be claimed from. A
 * result belongs to one owner: others learn nothing of it, not even by the time their own takes.
 * owners.others are the bytes of requests and surfaces; owners.turn is the number of the latest
 * claim from the owner, at first of the latest from any. */
static const char schema_4[] =
    "CREATE TABLE turns (n INTEGER NOT NULL);" /* claims so far */
    "INSERT INTO turns VALUES (0);"
    "CREATE TABLE owners ("
    " owner TEXT PRIMARY KEY,"
    " queued INTEGER NOT NULL DEFAULT 0,"
    " running INTEGER NOT NULL DEFAULT 0,"
    " results INTEGER NOT NULL DEFAULT 0,"
    " others INTEGER NOT NULL DEFAULT 0,"
    " turn INTEGER NOT NULL DEFAULT 0) WITHOUT ROWID;"
    "ALTER TABLE jobs ADD COLUMN request_bytes INTEGER NOT NULL DEFAULT 0;"
    "UPDATE jobs SET request_bytes ="
    " coalesce((SELECT length(bytes) FROM requests WHERE job = jobs.sequence), 0);"
    "ALTER TABLE results ADD COLUMN owner TEXT NOT NULL DEFAULT '';"
    "UPDATE results SET owner = coalesce("
    " (SELECT owner FROM jobs WHERE result = results.number ORDER BY sequence LIMIT 1),"
    " (SELECT owner FROM jobs WHERE sequence = results.job), '');"
    "DROP INDEX results_digest;"
    "CREATE UNIQUE INDEX results_digest ON results (owner, digest) WHERE state = 1;"
    "INSERT INTO owners (owner, queued, running, results, others)"
    " SELECT owner, sum(queued), sum(running), sum(results), sum(others) FROM"
    "  (SELECT owner, status = 0 AS queued, status = 1 AS running, 0 AS results,"
    "    (expired = 0) * request_bytes AS others FROM jobs"
    "   UNION ALL SELECT owner, 0, 0, length, 0 FROM results WHERE state = 1"
    "   UNION ALL SELECT owner, 0, 0, 0, length(definition) FROM surfaces) GROUP BY owner;"
    "CREATE INDEX owners_turn ON owners (running, turn) WHERE queued > 0;"
    "CREATE INDEX owners_results ON owners (results);"
    "CREATE INDEX jobs_owner_result ON jobs (owner, finished) WHERE result IS NOT NULL;"

    "CREATE TRIGGER owner_job_inserted AFTER INSERT ON jobs BEGIN"
    " INSERT INTO owners (owner, queued, running, others, turn) VALUES (new.owner, new.status = 0,"
    "  new.status = 1, new.request_bytes, (SELECT n FROM turns))"
    "  ON CONFLICT (owner) DO UPDATE SET queued = queued + excluded.queued,"
    "  running = running + excluded.running, others = others + excluded.others; END;"
    "CREATE TRIGGER owner_job_claimed AFTER UPDATE OF status ON jobs"
    " WHEN new.status = 1 AND old.status = 0 BEGIN"
    " UPDATE turns SET n = n + 1;"
    " UPDATE owners SET queued = queued - 1, running = running + 1, turn = (SELECT n FROM turns)"
    "  WHERE owner = new.owner; END;"
    "CREATE TRIGGER owner_job_moved AFTER UPDATE OF status ON jobs"
    " WHEN new.status <> old.status AND (new.status <> 1 OR old.status <> 0) BEGIN"
    " UPDATE owners SET queued = queued + (new.status = 0) - (old.status = 0),"
    "  running = running + (new.status = 1) - (old.status = 1) WHERE owner = new.owner; END;"
    "CREATE TRIGGER owner_job_expired AFTER UPDATE OF expired ON jobs"
    " WHEN new.expired > old.expired BEGIN"
    " UPDATE owners SET others = others - old.request_bytes WHERE owner = old.owner; END;"
    "CREATE TRIGGER owner_job_deleted AFTER DELETE ON jobs BEGIN"
    " UPDATE owners SET queued = queued - (old.status = 0), running = running - (old.status = 1),"
    "  others = others - (old.expired = 0) * old.request_bytes WHERE owner = old.owner; END;"
    "CREATE TRIGGER owner_result_inserted AFTER INSERT ON results WHEN new.state = 1 BEGIN"
    " INSERT INTO owners (owner, results, turn)"
    "  VALUES (new.owner, new.length, (SELECT n FROM turns))"
    "  ON CONFLICT (owner) DO UPDATE SET results = results + excluded.results; END;"
    "CREATE TRIGGER owner_result_changed AFTER UPDATE OF state, length ON results"
    " WHEN old.state = 1 OR new.state = 1 BEGIN"
    " UPDATE owners SET results = results + (new.state = 1) * new.length"
    "  - (old.state = 1) * old.length WHERE owner = new.owner; END;"
    "CREATE TRIGGER owner_result_deleted AFTER DELETE ON results WHEN old.state = 1 BEGIN"
    " UPDATE owners SET results = results - old.length WHERE owner = old.owner; END;"
    "CREATE TRIGGER owner_surface_inserted AFTER INSERT ON surfaces BEGIN"
    " INSERT INTO owners (owner, others, turn)"
    "  VALUES (new.owner, length(new.definition), (SELECT n FROM turns))"
    "  ON CONFLICT (owner) DO UPDATE SET others = others + excluded.others; END;"
    "CREATE TRIGGER owner_surface_deleted AFTER DELETE ON surfaces BEGIN"
    " UPDATE owners SET others = others - length(old.definition) WHERE owner = old.owner; END;"
    "CREATE TRIGGER owner_left AFTER UPDATE ON owners WHEN new.queued = 0 AND new.running = 0"
    " AND new.results = 0 AND new.others = 0 BEGIN"
    " DELETE FROM owners WHERE owner = new.owner; END;";

/* Schema 5: who shares the store, by their signs of life; which HTTP request a job came by; how
 * many have ended, which never becomes less; `probe` stays for hosts of an older version. The last
 * of `ended` are the failed ones that crashed.
 */
static const char schema_5[] =
    "CREATE TABLE hosts ("
    " name TEXT PRIMARY KEY,"
    " host TEXT NOT NULL,"
    " role TEXT NOT NULL,"
    " version TEXT NOT NULL,"
    " workers INTEGER NOT NULL,"
    " busy INTEGER NOT NULL,"
    " seen INTEGER NOT NULL);"
    "ALTER TABLE jobs ADD COLUMN origin TEXT;"
    "CREATE TABLE ended (status INTEGER PRIMARY KEY, n INTEGER NOT NULL);"
    "INSERT INTO ended VALUES (2, 0), (3, 0), (4, 0), (5, 0);"
    "CREATE TRIGGER job_came_ended AFTER INSERT ON jobs WHEN new.status >= 2 BEGIN"
    " UPDATE ended SET n = n + 1 WHERE status = new.status; END;"
    "CREATE TRIGGER job_ended AFTER UPDATE OF status ON jobs"
    " WHEN new.status >= 2 AND old.status < 2 BEGIN"
    " UPDATE ended SET n = n + 1 WHERE status = new.status;"
    " UPDATE ended SET n = n + 1 WHERE status = 5 AND new.status = 3"
    "  AND new.error LIKE '%\"/problems/solver-crashed\"%'; END;";

/* Schema 6: the key of cursors. */
static const char schema_6[] = "CREATE TABLE secret (bytes BLOB NOT NULL);"
                               "INSERT INTO secret VALUES (randomblob(32));";

/*
 * Schema 7: jobs that have jobs. jobs.parent is the sequence of the study or laminate a job belongs
 * to, jobs.part its place there. Of a parent jobs.round counts its rounds so far, jobs.open the
 * jobs of the present one that have not ended, jobs.done and jobs.total variants or drapes; a task
 * has its variants in jobs.total, itself in jobs.task and, when it has ended, its numbers in
 * `task_numbers`. jobs.spent is the time of tasks, in microseconds. A parent that waits has the
 * status -1.
 *
 * counts has tasks as 8 and 9. owners.tasks are those of owners.queued that no limit counts: tasks,
 * and studies between two rounds. What becomes of a family when one of it ends is here alone, so
 * that it is right however that came.
 */
#define BEHIND_NEW "(new.status = 0 AND (new.kind = " SQL_TASK " OR new.round > 0))"
#define BEHIND_OLD "(old.status = 0 AND (old.kind = " SQL_TASK " OR old.round > 0))"
#define COUNTED_NEW                                                                                \
    "CASE WHEN new.kind = " SQL_TASK " THEN 8 + new.status"                                        \
    " WHEN new.status < 1 AND new.round > 0 THEN 1 ELSE new.status END"
#define COUNTED_OLD                                                                                \
    "CASE WHEN old.kind = " SQL_TASK " THEN 8 + old.status"                                        \
    " WHEN old.status < 1 AND old.round > 0 THEN 1 ELSE old.status END"

static const char schema_7_columns[] =
    "ALTER TABLE jobs ADD COLUMN kind INTEGER NOT NULL DEFAULT 0;"
    "ALTER TABLE jobs ADD COLUMN parent INTEGER;"
    "ALTER TABLE jobs ADD COLUMN part INTEGER NOT NULL DEFAULT 0;"
    "ALTER TABLE jobs ADD COLUMN round INTEGER NOT NULL DEFAULT 0;"
    "ALTER TABLE jobs ADD COLUMN open INTEGER NOT NULL DEFAULT 0;"
    "ALTER TABLE jobs ADD COLUMN done INTEGER NOT NULL DEFAULT 0;"
    "ALTER TABLE jobs ADD COLUMN total INTEGER NOT NULL DEFAULT 0;"
    "ALTER TABLE jobs ADD COLUMN spent INTEGER NOT NULL DEFAULT 0;"
    "ALTER TABLE jobs ADD COLUMN task BLOB;"
    "CREATE TABLE task_numbers ("
    " parent INTEGER NOT NULL,"
    " round INTEGER NOT NULL,"
    " part INTEGER NOT NULL,"
    " bytes BLOB NOT NULL,"
    " PRIMARY KEY (parent, round, part));"
    "DROP INDEX jobs_status;"
    "CREATE INDEX jobs_status ON jobs (kind, status, sequence);"
    "DROP INDEX jobs_owner;"
    "CREATE INDEX jobs_owner ON jobs (owner, kind, sequence);"
    "CREATE INDEX jobs_kind ON jobs (kind, sequence) WHERE kind > 0;"
    "CREATE INDEX jobs_parent ON jobs (parent, part) WHERE parent IS NOT NULL;";

static const char schema_7_counts[] =
    "INSERT INTO counts VALUES (8, 0), (9, 0);"
    "DROP TRIGGER jobs_inserted;"
    "DROP TRIGGER jobs_deleted;"
    "DROP TRIGGER jobs_moved;"
    "CREATE TRIGGER jobs_inserted AFTER INSERT ON jobs BEGIN"
    " UPDATE counts SET n = n + 1 WHERE status = " COUNTED_NEW "; END;"
    "CREATE TRIGGER jobs_deleted AFTER DELETE ON jobs BEGIN"
    " UPDATE counts SET n = n - 1 WHERE status = " COUNTED_OLD "; END;"
    "CREATE TRIGGER jobs_moved AFTER UPDATE OF status ON jobs"
    " WHEN new.status <> old.status BEGIN"
    " UPDATE counts SET n = n - 1 WHERE status = " COUNTED_OLD ";"
    " UPDATE counts SET n = n + 1 WHERE status = " COUNTED_NEW "; END;"
    "DROP TRIGGER job_ended;"
    "CREATE TRIGGER job_ended AFTER UPDATE OF status ON jobs"
    " WHEN new.status >= 2 AND old.status < 2 AND new.kind <> " SQL_TASK " BEGIN"
    " UPDATE ended SET n = n + 1 WHERE status = new.status;"
    " UPDATE ended SET n = n + 1 WHERE status = 5 AND new.status = 3"
    "  AND new.error LIKE '%\"/problems/solver-crashed\"%'; END;"

    "ALTER TABLE owners ADD COLUMN tasks INTEGER NOT NULL DEFAULT 0;"
    "DROP TRIGGER owner_job_inserted;"
    "DROP TRIGGER owner_job_claimed;"
    "DROP TRIGGER owner_job_moved;"
    "DROP TRIGGER owner_job_deleted;"
    "CREATE TRIGGER owner_job_inserted AFTER INSERT ON jobs BEGIN"
    " INSERT INTO owners (owner, queued, tasks, running, others, turn) VALUES (new.owner,"
    "  new.status = 0, " BEHIND_NEW ", new.status = 1, new.request_bytes,"
    "  (SELECT n FROM turns))"
    "  ON CONFLICT (owner) DO UPDATE SET queued = queued + excluded.queued,"
    "  tasks = tasks + excluded.tasks, running = running + excluded.running,"
    "  others = others + excluded.others; END;"
    "CREATE TRIGGER owner_job_claimed AFTER UPDATE OF status ON jobs"
    " WHEN new.status = 1 AND old.status = 0 BEGIN"
    " UPDATE turns SET n = n + 1;"
    " UPDATE owners SET queued = queued - 1, tasks = tasks - " BEHIND_OLD ","
    "  running = running + 1, turn = (SELECT n FROM turns) WHERE owner = new.owner; END;"
    "CREATE TRIGGER owner_job_moved AFTER UPDATE OF status ON jobs"
    " WHEN new.status <> old.status AND (new.status <> 1 OR old.status <> 0) BEGIN"
    " UPDATE owners SET queued = queued + (new.status = 0) - (old.status = 0),"
    "  tasks = tasks + " BEHIND_NEW " - " BEHIND_OLD ","
    "  running = running + (new.status = 1) - (old.status = 1) WHERE owner = new.owner; END;"
    "CREATE TRIGGER owner_job_deleted AFTER DELETE ON jobs BEGIN"
    " UPDATE owners SET queued = queued - (old.status = 0), tasks = tasks - " BEHIND_OLD ","
    "  running = running - (old.status = 1),"
    "  others = others - (old.expired = 0) * old.request_bytes WHERE owner = old.owner; END;";

static const char schema_7_families[] =
    "CREATE TRIGGER family_member_ended AFTER UPDATE OF status ON jobs"
    " WHEN new.parent IS NOT NULL AND new.status >= 2 AND old.status < 2 BEGIN"
    " UPDATE jobs SET open = open - 1, done = done + new.total, spent = spent + new.spent,"
    "  status = CASE WHEN new.kind = " SQL_TASK " AND new.status <> " SQL_SUCCEEDED
    "    THEN " SQL_FAILED " WHEN open > 1 THEN " SQL_WAITING "   WHEN kind = " SQL_LAMINATE
    " THEN " SQL_SUCCEEDED " ELSE " SQL_QUEUED " END,"
    "  error = CASE WHEN new.kind = " SQL_TASK " THEN new.error END,"
    "  finished = CASE WHEN open = 1 AND kind = " SQL_LAMINATE " OR new.kind = " SQL_TASK
    "   AND new.status <> " SQL_SUCCEEDED " THEN new.finished ELSE 0 END"
    "  WHERE sequence = new.parent AND status = " SQL_WAITING "; END;"
    "CREATE TRIGGER family_member_removed AFTER DELETE ON jobs"
    " WHEN old.parent IS NOT NULL AND old.status < 2 BEGIN"
    " UPDATE jobs SET open = open - 1, done = done + old.total,"
    "  status = CASE WHEN open > 1 THEN " SQL_WAITING " ELSE " SQL_SUCCEEDED " END,"
    "  finished = CASE WHEN open > 1 THEN 0 ELSE max(created, coalesce("
    "   (SELECT max(m.finished) FROM jobs m WHERE m.parent = old.parent), 0)) END"
    "  WHERE sequence = old.parent AND status = " SQL_WAITING " AND kind = " SQL_LAMINATE "; END;"
    "CREATE TRIGGER study_ended AFTER UPDATE OF status ON jobs"
    " WHEN new.kind = " SQL_STUDY " AND new.status >= 2 AND old.status < 2 BEGIN"
    " DELETE FROM jobs WHERE parent = new.sequence;"
    " DELETE FROM task_numbers WHERE parent = new.sequence; END;"
    "CREATE TRIGGER laminate_cancelled AFTER UPDATE OF status ON jobs"
    " WHEN new.kind = " SQL_LAMINATE " AND new.status = " SQL_CANCELLED " BEGIN"
    " UPDATE jobs SET status = " SQL_CANCELLED ", finished = new.finished, lease = NULL,"
    "  holder = NULL WHERE parent = new.sequence AND status < 2; END;"
    "CREATE TRIGGER family_removed AFTER DELETE ON jobs WHEN old.kind IN (" SQL_STUDY
    ", " SQL_LAMINATE ") BEGIN"
    " UPDATE results SET state = " SQL_DOOMED " WHERE state = " SQL_COMPLETE " AND number IN"
    "  (SELECT result FROM jobs WHERE parent = old.sequence) AND NOT EXISTS (SELECT 1 FROM jobs j"
    "  WHERE j.result = results.number AND j.parent IS NOT old.sequence);"
    " DELETE FROM requests WHERE job IN (SELECT sequence FROM jobs WHERE parent = old.sequence);"
    " DELETE FROM jobs WHERE parent = old.sequence;"
    " DELETE FROM task_numbers WHERE parent = old.sequence; END;";

/* Schema 8: materials, as surfaces are kept. */
static const char schema_8[] =
    "CREATE TABLE materials ("
    " sequence INTEGER PRIMARY KEY AUTOINCREMENT,"
    " id TEXT NOT NULL,"
    " owner TEXT NOT NULL,"
    " created INTEGER NOT NULL,"
    " description TEXT NOT NULL,"
    " definition BLOB NOT NULL,"
    " UNIQUE (id, owner));"
    "CREATE INDEX materials_owner ON materials (owner, sequence);"
    "CREATE TRIGGER owner_material_inserted AFTER INSERT ON materials BEGIN"
    " INSERT INTO owners (owner, others, turn)"
    "  VALUES (new.owner, length(new.definition), (SELECT n FROM turns))"
    "  ON CONFLICT (owner) DO UPDATE SET others = others + excluded.others; END;"
    "CREATE TRIGGER owner_material_deleted AFTER DELETE ON materials BEGIN"
    " UPDATE owners SET others = others - length(old.definition) WHERE owner = old.owner; END;";

/* Schema 9: an index that every claim and every end of a job had to write, and nobody to read. What
 * runs is found by `jobs_running`. */
static const char schema_9[] = "DROP INDEX jobs_lease;";

/* Migrations in order, of a few scripts each: the n-th leads to version n. */
enum { SCRIPTS = 3 };
static const char *const migrations[][SCRIPTS] = {
    {schema_1},
    {schema_2},
    {schema_3},
    {schema_4},
    {schema_5},
    {schema_6},
    {schema_7_columns, schema_7_counts, schema_7_families},
    {schema_8},
    {schema_9}};

enum { CURRENT = sizeof migrations / sizeof migrations[0] };

int64_t sqlite_schema(void) {
    return CURRENT;
}

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
    const char *const *scripts = migrations[version - 1];
    for (int k = 0; k < SCRIPTS && scripts[k]; k++)
        if (db_script(db, scripts[k]) != STORE_OK)
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
