/* SPDX-License-Identifier: MIT */
#include "db.h"
#include "server/clock.h"
#include "server/log.h"
#include "server/metrics.h"
#include <pthread.h>
#include <sqlite3.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SET_UP_MS = 1000, SET_UP_PAUSE_MS = 10 }; /* for how long to try, and how often */
enum { STATEMENTS = 128 }; /* prepared ones kept per connection; the backend has about 70 */

struct db {
    sqlite3 *handle;
    char *path;
    enum db_durability durability;
    size_t count;
    struct {
        const char *sql;
        sqlite3_stmt *statement;
    } cache[STATEMENTS];
};

/* What a code of SQLite means: the answer, and what is wrong with the database. */
struct meaning {
    int code;
    enum store_answer answer;
    const char *what;
};

static struct meaning meaning_of(int code) {
    static const struct meaning meanings[] = {
        {SQLITE_BUSY, STORE_BUSY, "is locked by another process"},
        {SQLITE_LOCKED, STORE_BUSY, "is locked by another process"},
        {SQLITE_FULL, STORE_NO_SPACE, "cannot grow: the disk is full"},
        {SQLITE_READONLY, STORE_READ_ONLY, "cannot be written"},
        {SQLITE_PERM, STORE_DOWN, "cannot be written"},
        {SQLITE_CORRUPT, STORE_DAMAGED, "is damaged: restore it from a backup"},
        {SQLITE_NOTADB, STORE_DAMAGED,
         "is not a database, or is damaged: restore it from a backup"}};
    for (size_t k = 0; k < sizeof meanings / sizeof *meanings; k++)
        if (meanings[k].code == (code & 0xff))
            return meanings[k];
    return (struct meaning){code, STORE_DOWN, "cannot be opened"};
}

static enum store_answer log_failure(struct db *db, int code) {
    int kind = code & 0xff;
    if (kind == SQLITE_OK || kind == SQLITE_ROW || kind == SQLITE_DONE)
        return STORE_OK;
    enum store_answer answer = meaning_of(kind).answer;
    metrics_store_failed(answer == STORE_BUSY);
    log_error(log_event("store_error"), log_text("answer", store_answer_name(answer)),
              log_int("code", code), log_text("detail", sqlite3_errmsg(db->handle)));
    return answer;
}

/* ------------------------------------------------------------------ open and close */

/* Explains a failure to open; the extended code and SQLite's text have the rest. */
static void explain_open(char why[STORE_WHY_SIZE], const struct db *db, int code,
                         const char *detail) {
    snprintf(why, STORE_WHY_SIZE, "the database %s %s (%s)", db->path, meaning_of(code).what,
             detail);
}

void db_close(struct db *db) {
    if (!db)
        return;
    for (size_t k = 0; k < db->count; k++)
        sqlite3_finalize(db->cache[k].statement);
    sqlite3_close(db->handle);
    free(db->path);
    free(db);
}

/* Before the library is used first: nobody asks how much memory it has, and to count that takes a
 * lock for every allocation. */
static void configure(void) {
    sqlite3_config(SQLITE_CONFIG_MEMSTATUS, 0);
}

struct db *db_open(const char *path, int64_t busy_ms, char why[STORE_WHY_SIZE]) {
    static pthread_once_t once = PTHREAD_ONCE_INIT;
    pthread_once(&once, configure);
    struct db *db = calloc(1, sizeof *db);
    if (!db || !(db->path = strdup(path))) {
        snprintf(why, STORE_WHY_SIZE, "no memory for the database");
        free(db);
        return NULL;
    }
    int flags =
        SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_EXRESCODE;
    int code = sqlite3_open_v2(path, &db->handle, flags, NULL);
    if (code == SQLITE_OK)
        code = sqlite3_db_config(db->handle, SQLITE_DBCONFIG_MAINDBNAME, "draped");
    if (code == SQLITE_OK) {
        db_wait_for_locks(db, busy_ms);
        return db;
    }
    explain_open(why, db, code, db->handle ? sqlite3_errmsg(db->handle) : "no memory");
    db_close(db);
    return NULL;
}

const char *db_path(const struct db *db) {
    return db->path;
}

void db_explain(const struct db *db, char why[STORE_WHY_SIZE]) {
    explain_open(why, db, sqlite3_errcode(db->handle), sqlite3_errmsg(db->handle));
}

void db_wait_for_locks(struct db *db, int64_t ms) {
    (void)sqlite3_busy_timeout(db->handle, (int)ms);
}

bool db_read_only(struct db *db) {
    return sqlite3_db_readonly(db->handle, "main") == 1;
}

/* Processes that turn a new file to a log at the same time get "busy" at once, without the wait of
 * other locks: they would wait for each other. */
bool db_set_up(struct db *db, const char *sql, char why[STORE_WHY_SIZE]) {
    const int64_t until = clock_ms() + SET_UP_MS;
    int code;
    while ((code = sqlite3_exec(db->handle, sql, NULL, NULL, NULL) & 0xff) == SQLITE_BUSY &&
           clock_ms() < until)
        sqlite3_sleep(SET_UP_PAUSE_MS);
    if (code != SQLITE_OK)
        db_explain(db, why);
    return code == SQLITE_OK;
}

enum store_answer db_script(struct db *db, const char *sql) {
    return log_failure(db, sqlite3_exec(db->handle, sql, NULL, NULL, NULL));
}

bool db_check(struct db *db, const char *sql, char why[STORE_WHY_SIZE]) {
    char verdict[256] = "";
    struct query query = db_query(db, sql);
    if (query_row(&query))
        query_copy(&query, 0, verdict, sizeof verdict);
    int code = query.code;
    if (query_end(&query) == STORE_OK && !strcmp(verdict, "ok"))
        return true;
    explain_open(why, db, code == SQLITE_ROW ? SQLITE_CORRUPT : code, verdict);
    return false;
}

bool db_in_transaction(struct db *db) {
    return !sqlite3_get_autocommit(db->handle);
}

/* SQLite obeys this pragma when it is compiled, so it must not be a kept statement. */
enum store_answer db_keep(struct db *db, enum db_durability durability) {
    if (db->durability == durability)
        return STORE_OK;
    enum store_answer answer = db_script(db, durability == DB_LAZY ? "PRAGMA synchronous=NORMAL"
                                                                   : "PRAGMA synchronous=FULL");
    if (answer == STORE_OK)
        db->durability = durability;
    return answer;
}

enum store_answer db_checkpoint(struct db *db, bool *all) {
    int pages, copied;
    int code =
        sqlite3_wal_checkpoint_v2(db->handle, NULL, SQLITE_CHECKPOINT_PASSIVE, &pages, &copied);
    *all = code == SQLITE_OK && copied == pages;
    return (code & 0xff) == SQLITE_BUSY ? STORE_BUSY : log_failure(db, code);
}

enum store_answer db_sync_log(struct db *db) {
    sqlite3_file *log = NULL;
    int code = sqlite3_file_control(db->handle, "main", SQLITE_FCNTL_JOURNAL_POINTER, &log);
    if (code == SQLITE_OK && log && log->pMethods)
        code = log->pMethods->xSync(log, SQLITE_SYNC_DATAONLY | SQLITE_SYNC_NORMAL);
    return log_failure(db, code);
}

/* ------------------------------------------------------------------ statements */

static bool db_row(struct query *query) {
    sqlite3_stmt *statement = query->statement;
    int count = query->row++ == 0 ? query->bound : 0;
    for (int k = 0; k < count && query->code == SQLITE_OK; k++) {
        const struct query_value *value = &query->values[k];
        if (value->null)
            query->code = sqlite3_bind_null(statement, k + 1);
        else if (value->kind == QUERY_INT)
            query->code = sqlite3_bind_int64(statement, k + 1, value->integer);
        else if (value->kind == QUERY_REAL)
            query->code = sqlite3_bind_double(statement, k + 1, value->real);
        else if (value->kind == QUERY_TEXT)
            query->code = sqlite3_bind_text(statement, k + 1, value->bytes, -1, SQLITE_STATIC);
        else
            query->code =
                sqlite3_bind_blob64(statement, k + 1, value->bytes, value->length, SQLITE_STATIC);
    }
    if (query->code != SQLITE_OK && query->code != SQLITE_ROW)
        return false;
    query->code = sqlite3_step(statement);
    return query->code == SQLITE_ROW;
}

static struct query_value db_column(const struct query *query, int column) {
    sqlite3_stmt *statement = query->statement;
    struct query_value value = {0};
    switch (sqlite3_column_type(statement, column)) {
    case SQLITE_INTEGER:
        value.kind = QUERY_INT;
        value.integer = sqlite3_column_int64(statement, column);
        break;
    case SQLITE_FLOAT:
        value.kind = QUERY_REAL;
        value.real = sqlite3_column_double(statement, column);
        break;
    case SQLITE_TEXT:
        value.kind = QUERY_TEXT;
        value.bytes = sqlite3_column_text(statement, column);
        break;
    case SQLITE_BLOB:
        value.kind = QUERY_BYTES;
        value.bytes = sqlite3_column_blob(statement, column);
        break;
    default:
        value.null = true;
    }
    if (value.kind == QUERY_TEXT || value.kind == QUERY_BYTES)
        value.length = (size_t)sqlite3_column_bytes(statement, column);
    return value;
}

static enum store_answer db_end(struct query *query) {
    enum store_answer answer = log_failure(query->connection, query->code);
    if (query->statement) {
        sqlite3_reset(query->statement);
        sqlite3_clear_bindings(query->statement);
    }
    return answer;
}

struct query db_query(void *connection, const char *sql) {
    struct db *db = connection;
    static const struct query_driver driver = {db_row, db_column, db_end};
    struct query query = {.driver = &driver, .connection = db, .sql = sql};
    for (size_t k = 0; k < db->count && !query.statement; k++)
        if (db->cache[k].sql == sql)
            query.statement = db->cache[k].statement;
    if (query.statement)
        return query;
    sqlite3_stmt *statement = NULL;
    query.code =
        db->count == STATEMENTS
            ? SQLITE_FULL
            : sqlite3_prepare_v3(db->handle, sql, -1, SQLITE_PREPARE_PERSISTENT, &statement, NULL);
    query.statement = statement;
    if (query.code == SQLITE_OK) {
        db->cache[db->count].sql = sql;
        db->cache[db->count++].statement = statement;
    }
    return query;
}

enum store_answer db_change(struct query *query, enum store_answer none) {
    enum store_answer answer = query_run(query);
    return answer == STORE_OK && db_changes(query->connection) == 0 ? none : answer;
}

enum store_answer db_run(struct db *db, const char *sql) {
    struct query query = db_query(db, sql);
    return query_run(&query);
}

enum store_answer db_run_with(struct db *db, const char *sql, int64_t parameter) {
    struct query query = db_query(db, sql);
    query_bind(&query, of_int(parameter));
    return query_run(&query);
}

int64_t db_changes(struct db *db) {
    return sqlite3_changes64(db->handle);
}

int64_t db_last_row(struct db *db) {
    return sqlite3_last_insert_rowid(db->handle);
}
