/* SPDX-License-Identifier: MIT */
#include "server/clock.h"
#include "server/store/sql.h"
#include "sqlite.h"
#include <stdio.h>

/*
 * The columns of jobs, in PostgreSQL alike:
 *
 * rank orders the queue of an owner: the time of creation less a minute a step of priority, so that
 * priority and age are one number that never has to be updated. key_digest is of the body posted
 * with the idempotency key. token is the fencing token of the latest claim, and excused counts the
 * attempts that are not held against the job. summary is kept here when the result has expired.
 *
 * parent is the sequence of the study or laminate a job belongs to, position its place there. Of a
 * parent round counts its rounds so far, open the jobs of the present one that have not ended, done
 * and total variants or drapes; a task has its variants in total, itself in task and, when it has
 * ended, its numbers in `task_numbers`. spent is the time of tasks, in microseconds. A parent that
 * waits has the status -1.
 *
 * Each seal is the checksum (seal.h) of what stands beside it.
 */
static const char tables[] =
    "CREATE TABLE schema_version (version INTEGER NOT NULL, applied INTEGER NOT NULL);"

    /* The key of cursors. */
    "CREATE TABLE secret (bytes BLOB NOT NULL);"
    "INSERT INTO secret VALUES (randomblob(32));"

    /* job and token: the claim under which it is being written. A result belongs to one owner:
     * others learn nothing of it, not even by the time their own takes. */
    "CREATE TABLE results ("
    " number INTEGER PRIMARY KEY AUTOINCREMENT,"
    " owner TEXT NOT NULL DEFAULT '',"
    " digest TEXT NOT NULL,"
    " state INTEGER NOT NULL,"
    " job INTEGER NOT NULL,"
    " token INTEGER NOT NULL,"
    " length INTEGER NOT NULL,"
    " summary TEXT,"
    " summary_seal INTEGER);"
    "CREATE UNIQUE INDEX results_digest ON results (owner, digest) WHERE state = 1;"
    "CREATE INDEX results_unfinished ON results (state) WHERE state <> 1;"

    /* id is the number of the result * 2^24 + index. */
    "CREATE TABLE chunks (id INTEGER PRIMARY KEY, seal INTEGER NOT NULL, bytes BLOB NOT NULL);"

    "CREATE TABLE jobs ("
    " sequence INTEGER PRIMARY KEY AUTOINCREMENT,"
    " id TEXT NOT NULL UNIQUE,"
    " kind INTEGER NOT NULL DEFAULT 0,"
    " status INTEGER NOT NULL,"
    " rank INTEGER NOT NULL,"
    " priority INTEGER NOT NULL,"
    " owner TEXT NOT NULL,"
    " digest TEXT NOT NULL,"
    " surface TEXT,"
    " key TEXT,"
    " key_digest BLOB,"
    " origin TEXT," /* the HTTP request by which it came */
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
    " summary TEXT,"
    " summary_seal INTEGER,"
    " error TEXT,"
    " error_seal INTEGER,"
    " expired INTEGER NOT NULL DEFAULT 0,"
    " request_bytes INTEGER NOT NULL DEFAULT 0,"
    " parent INTEGER,"
    " position INTEGER NOT NULL DEFAULT 0,"
    " round INTEGER NOT NULL DEFAULT 0,"
    " open INTEGER NOT NULL DEFAULT 0,"
    " done INTEGER NOT NULL DEFAULT 0,"
    " total INTEGER NOT NULL DEFAULT 0,"
    " spent INTEGER NOT NULL DEFAULT 0,"
    " task BLOB);"
    "CREATE INDEX jobs_queue ON jobs (owner, rank, sequence) WHERE status = 0;"
    "CREATE INDEX jobs_running ON jobs (owner) WHERE status = 1;"
    "CREATE INDEX jobs_status ON jobs (kind, status, sequence);"
    "CREATE INDEX jobs_finished ON jobs (expired, finished) WHERE status >= 2;"
    "CREATE INDEX jobs_result ON jobs (result) WHERE result IS NOT NULL;"
    "CREATE INDEX jobs_owner_result ON jobs (owner, finished) WHERE result IS NOT NULL;"
    "CREATE INDEX jobs_surface ON jobs (surface) WHERE surface IS NOT NULL AND status < 2;"
    "CREATE INDEX jobs_owner ON jobs (owner, kind, sequence);"
    "CREATE INDEX jobs_kind ON jobs (kind, sequence) WHERE kind > 0;"
    "CREATE INDEX jobs_parent ON jobs (parent, position) WHERE parent IS NOT NULL;"
    "CREATE UNIQUE INDEX jobs_key ON jobs (owner, key) WHERE key IS NOT NULL;";

static const char more_tables[] =
    "CREATE TABLE requests ("
    " job INTEGER PRIMARY KEY,"
    " seal INTEGER NOT NULL,"
    " bytes BLOB NOT NULL);"

    "CREATE TABLE task_numbers ("
    " parent INTEGER NOT NULL,"
    " round INTEGER NOT NULL,"
    " position INTEGER NOT NULL,"
    " seal INTEGER NOT NULL,"
    " bytes BLOB NOT NULL,"
    " PRIMARY KEY (parent, round, position));"

    /* Who shares the store, by their heartbeats. */
    "CREATE TABLE hosts ("
    " name TEXT PRIMARY KEY,"
    " host TEXT NOT NULL,"
    " role TEXT NOT NULL,"
    " version TEXT NOT NULL,"
    " workers INTEGER NOT NULL,"
    " busy INTEGER NOT NULL,"
    " seen INTEGER NOT NULL);"

    /* What follows is kept by triggers, because to count rows would cost more with every job. Jobs
     * by the status that is reported; tasks as 8 and 9. */
    "CREATE TABLE counts (status INTEGER PRIMARY KEY, n INTEGER NOT NULL);"
    "INSERT INTO counts VALUES (0, 0), (1, 0), (2, 0), (3, 0), (4, 0), (8, 0), (9, 0);"
    /* How many have ended, which never becomes less; 5: the failed ones that crashed. */
    "CREATE TABLE ended (status INTEGER PRIMARY KEY, n INTEGER NOT NULL);"
    "INSERT INTO ended VALUES (2, 0), (3, 0), (4, 0), (5, 0);"
    "CREATE TABLE stored (bytes INTEGER NOT NULL);" /* of complete results */
    "INSERT INTO stored VALUES (0);"
    "CREATE TABLE turns (n INTEGER NOT NULL);" /* claims so far */
    "INSERT INTO turns VALUES (0);"
    /* tasks are those of queued that no limit counts: tasks, and studies between two rounds. others
     * are the bytes of requests, surfaces and materials. turn is the number of the latest claim
     * from the owner, at first of the latest from any. */
    "CREATE TABLE owners ("
    " owner TEXT PRIMARY KEY,"
    " queued INTEGER NOT NULL DEFAULT 0,"
    " tasks INTEGER NOT NULL DEFAULT 0,"
    " running INTEGER NOT NULL DEFAULT 0,"
    " results INTEGER NOT NULL DEFAULT 0,"
    " others INTEGER NOT NULL DEFAULT 0,"
    " turn INTEGER NOT NULL DEFAULT 0) WITHOUT ROWID;"
    "CREATE INDEX owners_turn ON owners (running, turn) WHERE queued > 0;"
    "CREATE INDEX owners_results ON owners (results);";

/* Whether no limit counts a queued job, and as what it is counted. */
#define BEHIND_NEW "(new.status = 0 AND (new.kind = " SQL_TASK " OR new.round > 0))"
#define BEHIND_OLD "(old.status = 0 AND (old.kind = " SQL_TASK " OR old.round > 0))"
#define COUNTED_NEW                                                                                \
    "CASE WHEN new.kind = " SQL_TASK " THEN 8 + new.status"                                        \
    " WHEN new.status < 1 AND new.round > 0 THEN 1 ELSE new.status END"
#define COUNTED_OLD                                                                                \
    "CASE WHEN old.kind = " SQL_TASK " THEN 8 + old.status"                                        \
    " WHEN old.status < 1 AND old.round > 0 THEN 1 ELSE old.status END"

static const char counting[] =
    "CREATE TRIGGER job_inserted AFTER INSERT ON jobs BEGIN"
    " UPDATE counts SET n = n + 1 WHERE status = " COUNTED_NEW ";"
    " INSERT INTO owners (owner, queued, tasks, running, others, turn) VALUES (new.owner,"
    "  new.status = 0, " BEHIND_NEW ", new.status = 1, new.request_bytes,"
    "  (SELECT n FROM turns))"
    "  ON CONFLICT (owner) DO UPDATE SET queued = queued + excluded.queued,"
    "  tasks = tasks + excluded.tasks, running = running + excluded.running,"
    "  others = others + excluded.others; END;"
    "CREATE TRIGGER job_came_ended AFTER INSERT ON jobs WHEN new.status >= 2 BEGIN"
    " UPDATE ended SET n = n + 1 WHERE status = new.status; END;"

    "CREATE TRIGGER job_moved AFTER UPDATE OF status ON jobs WHEN new.status <> old.status BEGIN"
    " UPDATE counts SET n = n - 1 WHERE status = " COUNTED_OLD ";"
    " UPDATE counts SET n = n + 1 WHERE status = " COUNTED_NEW "; END;"
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
    "CREATE TRIGGER job_ended AFTER UPDATE OF status ON jobs"
    " WHEN new.status >= 2 AND old.status < 2 AND new.kind <> " SQL_TASK " BEGIN"
    " UPDATE ended SET n = n + 1 WHERE status = new.status;"
    " UPDATE ended SET n = n + 1 WHERE status = 5 AND new.status = 3"
    "  AND new.error LIKE '%\"/problems/solver-crashed\"%'; END;"
    "CREATE TRIGGER job_expired AFTER UPDATE OF expired ON jobs"
    " WHEN new.expired > old.expired BEGIN"
    " UPDATE owners SET others = others - old.request_bytes WHERE owner = old.owner; END;"

    "CREATE TRIGGER job_deleted AFTER DELETE ON jobs BEGIN"
    " UPDATE counts SET n = n - 1 WHERE status = " COUNTED_OLD ";"
    " UPDATE owners SET queued = queued - (old.status = 0), tasks = tasks - " BEHIND_OLD ","
    "  running = running - (old.status = 1),"
    "  others = others - (old.expired = 0) * old.request_bytes WHERE owner = old.owner; END;"

    "CREATE TRIGGER result_inserted AFTER INSERT ON results WHEN new.state = 1 BEGIN"
    " UPDATE stored SET bytes = bytes + new.length;"
    " INSERT INTO owners (owner, results, turn)"
    "  VALUES (new.owner, new.length, (SELECT n FROM turns))"
    "  ON CONFLICT (owner) DO UPDATE SET results = results + excluded.results; END;"
    "CREATE TRIGGER result_changed AFTER UPDATE OF state, length ON results"
    " WHEN old.state = 1 OR new.state = 1 BEGIN"
    " UPDATE stored SET bytes = bytes + (new.state = 1) * new.length"
    "  - (old.state = 1) * old.length;"
    " UPDATE owners SET results = results + (new.state = 1) * new.length"
    "  - (old.state = 1) * old.length WHERE owner = new.owner; END;"
    "CREATE TRIGGER result_deleted AFTER DELETE ON results WHEN old.state = 1 BEGIN"
    " UPDATE stored SET bytes = bytes - old.length;"
    " UPDATE owners SET results = results - old.length WHERE owner = old.owner; END;"

    "CREATE TRIGGER owner_left AFTER UPDATE ON owners WHEN new.queued = 0 AND new.running = 0"
    " AND new.results = 0 AND new.others = 0 BEGIN"
    " DELETE FROM owners WHERE owner = new.owner; END;";

/* Surfaces, materials and links: several owners may have one of the same name. form is the prepared
 * form of a surface. */
#define ITEM_BYTES(row) "length(" row ".definition) + coalesce(length(" row ".form), 0)"
#define ITEMS(table)                                                                               \
    "CREATE TABLE " table " ("                                                                     \
    " sequence INTEGER PRIMARY KEY AUTOINCREMENT,"                                                 \
    " id TEXT NOT NULL,"                                                                           \
    " owner TEXT NOT NULL,"                                                                        \
    " created INTEGER NOT NULL,"                                                                   \
    " seal INTEGER NOT NULL,"                                                                      \
    " description TEXT NOT NULL,"                                                                  \
    " definition BLOB NOT NULL,"                                                                   \
    " form BLOB,"                                                                                  \
    " UNIQUE (id, owner));"                                                                        \
    "CREATE INDEX " table "_owner ON " table " (owner, sequence);"                                 \
    "CREATE TRIGGER " table "_inserted AFTER INSERT ON " table " BEGIN"                            \
    " INSERT INTO owners (owner, others, turn)"                                                    \
    "  VALUES (new.owner, " ITEM_BYTES(                                                            \
        "new") ", (SELECT n FROM turns))"                                                          \
               "  ON CONFLICT (owner) DO UPDATE SET others = others + excluded.others; END;"       \
               "CREATE TRIGGER " table "_changed AFTER UPDATE OF form ON " table " BEGIN"          \
               " UPDATE owners SET others = others + " ITEM_BYTES("new") " - (" ITEM_BYTES(        \
                   "old") ")"                                                                      \
                          "  WHERE owner = old.owner; END;"                                        \
                          "CREATE TRIGGER " table "_deleted AFTER DELETE ON " table " BEGIN"       \
                          " UPDATE owners SET others = others - (" ITEM_BYTES(                     \
                              "old") ") WHERE owner = old.owner; END;"

#define SURFACES ITEMS("surfaces")
#define MATERIALS ITEMS("materials")
#define LINKS ITEMS("links")
static const char items[] = SURFACES MATERIALS LINKS;

/* What becomes of a family when one of it ends is here alone, so that it is right however that
 * came. */
static const char families[] =
    "CREATE TRIGGER family_member_ended AFTER UPDATE OF status ON jobs"
    " WHEN new.parent IS NOT NULL AND new.status >= 2 AND old.status < 2 BEGIN"
    " UPDATE jobs SET open = open - 1, done = done + new.total, spent = spent + new.spent,"
    "  status = CASE WHEN new.kind = " SQL_TASK " AND new.status <> " SQL_SUCCEEDED
    "    THEN " SQL_FAILED " WHEN open > 1 THEN " SQL_WAITING " WHEN kind = " SQL_LAMINATE
    "    THEN " SQL_SUCCEEDED " ELSE " SQL_QUEUED " END,"
    "  error = CASE WHEN new.kind = " SQL_TASK " THEN new.error END,"
    "  error_seal = CASE WHEN new.kind = " SQL_TASK " THEN new.error_seal END,"
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

static bool read_one_number(struct db *db, const char *sql, int64_t *number) {
    struct query query = db_query(db, sql);
    return query_number(&query, STORE_OK, number) == STORE_OK;
}

bool sqlite_check_tables(struct db *db, bool *empty, char why[STORE_WHY_SIZE]) {
    int64_t tables_there = 0, application = 0, version = 0;
    bool good =
        read_one_number(db, "SELECT count(*) FROM sqlite_schema", &tables_there) &&
        read_one_number(db, "SELECT application_id FROM pragma_application_id", &application);
    *empty = tables_there == 0;
    if (good && !*empty && application != SQLITE_APPLICATION) {
        snprintf(why, STORE_WHY_SIZE, "the database %s belongs to another program", db_path(db));
        return false;
    }
    if (good && !*empty)
        good = read_one_number(db, "SELECT max(version) FROM schema_version", &version);
    if (!good)
        db_explain(db, why);
    return good && (*empty || store_schema_known(db_path(db), version, why));
}

bool sqlite_prepare_tables(struct db *db, char why[STORE_WHY_SIZE]) {
    bool empty, good = sqlite_check_tables(db, &empty, why);
    if (!good || !empty)
        return good;
    /* SQLITE_APPLICATION */
    good = db_script(db, "PRAGMA application_id = 0x64726170") == STORE_OK &&
           db_script(db, tables) == STORE_OK && db_script(db, more_tables) == STORE_OK &&
           db_script(db, counting) == STORE_OK && db_script(db, items) == STORE_OK &&
           db_script(db, families) == STORE_OK;
    if (good) {
        struct query query = db_query(db, "INSERT INTO schema_version VALUES (?, ?)");
        query_bind(&query, of_int(STORE_SCHEMA), of_int(clock_utc_us()));
        good = query_run(&query) == STORE_OK;
    }
    if (!good)
        db_explain(db, why);
    return good;
}
