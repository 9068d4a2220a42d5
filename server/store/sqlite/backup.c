/* SPDX-License-Identifier: MIT */
/*
 * Copies of an SQLite store. The library's online back-up copies the pages of one read
 * transaction, so that writers go on meanwhile and never make it begin anew. A copy is one file
 * without a log, with a table `backup` of what it should hold.
 */
#include "server/store/backup.h"
#include "server/store/process_lock.h"
#include "sqlite.h"
#include <errno.h>
#include <fcntl.h>
#include <libgen.h>
#include <limits.h>
#include <sqlite3.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum {
    BUSY_MS = 30000,  /* to wait for locks of other processes */
    STEP_PAGES = 4096 /* copied at a time */
};

static bool say_error(char why[STORE_WHY_SIZE], sqlite3 *handle, const char *path) {
    return backup_fail(why, "%s: %s", path,
                       handle ? sqlite3_errmsg(handle) : "no memory for the database");
}

/* NULL with `why`; the handle is the caller's to close. */
static sqlite3 *open_file(const char *path, int flags, char why[STORE_WHY_SIZE]) {
    sqlite3 *handle = NULL;
    if (sqlite3_open_v2(path, &handle, flags | SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_EXRESCODE, NULL) ==
        SQLITE_OK) {
        sqlite3_busy_timeout(handle, BUSY_MS);
        return handle;
    }
    say_error(why, handle, path);
    sqlite3_close(handle);
    return NULL;
}

static bool run_sql(sqlite3 *handle, const char *path, const char *sql, char why[STORE_WHY_SIZE]) {
    return sqlite3_exec(handle, sql, NULL, NULL, NULL) == SQLITE_OK || say_error(why, handle, path);
}

static bool select_number(sqlite3 *handle, const char *sql, int64_t *number) {
    sqlite3_stmt *statement = NULL;
    bool good = sqlite3_prepare_v2(handle, sql, -1, &statement, NULL) == SQLITE_OK &&
                sqlite3_step(statement) == SQLITE_ROW;
    *number = good ? sqlite3_column_int64(statement, 0) : 0;
    sqlite3_finalize(statement);
    return good;
}

/* ------------------------------------------------------------------ what it holds */

/* Every row, in the order of the table's own key. Each value comes with its kind and length, so
 * that no two rows look alike. */
static bool sum_table(sqlite3 *handle, struct backup_table *table) {
    char sql[BACKUP_NAME_SIZE + 32];
    struct checksum checksum;
    sqlite3_stmt *statement = NULL;
    snprintf(sql, sizeof sql, "SELECT * FROM \"%s\"", table->name);
    int code = sqlite3_prepare_v2(handle, sql, -1, &statement, NULL);
    checksum_begin(&checksum);
    while (code == SQLITE_OK && (code = sqlite3_step(statement)) == SQLITE_ROW) {
        for (int k = 0; k < sqlite3_column_count(statement); k++) {
            int type = sqlite3_column_type(statement, k);
            const void *bytes = sqlite3_column_blob(statement, k);
            const int head[2] = {type, sqlite3_column_bytes(statement, k)};
            checksum_add(&checksum, head, sizeof head);
            checksum_add(&checksum, bytes, (size_t)head[1]);
        }
        table->rows++;
        code = SQLITE_OK;
    }
    checksum_end(&checksum, table->checksum);
    sqlite3_finalize(statement);
    return code == SQLITE_DONE;
}

/* The tables but `backup`, and the version of their schema. */
static bool read_contents(sqlite3 *handle, const char *path, struct backup_contents *contents,
                          char why[STORE_WHY_SIZE]) {
    sqlite3_stmt *names = NULL;
    int64_t application = 0;
    memset(contents, 0, sizeof *contents);
    if (!select_number(handle, "PRAGMA application_id", &application))
        return say_error(why, handle, path);
    if (application != SQLITE_APPLICATION ||
        !select_number(handle, "SELECT max(version) FROM schema_version", &contents->schema))
        return backup_fail(why, "%s is not a database of draped", path);
    int code = sqlite3_prepare_v2(handle,
                                  "SELECT name FROM sqlite_schema WHERE type = 'table'"
                                  " AND name <> 'backup' ORDER BY name",
                                  -1, &names, NULL);
    while (code == SQLITE_OK && (code = sqlite3_step(names)) == SQLITE_ROW) {
        struct backup_table *table = &contents->tables[contents->count];
        code = contents->count < BACKUP_TABLES ? SQLITE_OK : SQLITE_TOOBIG;
        if (code != SQLITE_OK)
            break;
        snprintf(table->name, sizeof table->name, "%s",
                 (const char *)sqlite3_column_text(names, 0));
        contents->count++;
        if (!sum_table(handle, table))
            code = SQLITE_ERROR;
    }
    sqlite3_finalize(names);
    return code == SQLITE_DONE || say_error(why, handle, path);
}

static bool check_pages(sqlite3 *handle, const char *path, char why[STORE_WHY_SIZE]) {
    sqlite3_stmt *statement = NULL;
    const char *verdict = NULL;
    if (sqlite3_prepare_v2(handle, "PRAGMA integrity_check(1)", -1, &statement, NULL) ==
            SQLITE_OK &&
        sqlite3_step(statement) == SQLITE_ROW)
        verdict = (const char *)sqlite3_column_text(statement, 0);
    bool good = verdict && !strcmp(verdict, "ok");
    if (!good)
        backup_fail(why, "%s is damaged: %s", path, verdict ? verdict : sqlite3_errmsg(handle));
    sqlite3_finalize(statement);
    return good;
}

/* The table `backup` of a copy. */
static bool write_manifest(sqlite3 *handle, const char *path,
                           const struct backup_contents *contents, char why[STORE_WHY_SIZE]) {
    sqlite3_stmt *statement = NULL;
    bool good = run_sql(handle, path,
                        "BEGIN; CREATE TABLE backup (name TEXT PRIMARY KEY, rows INTEGER NOT NULL,"
                        " checksum TEXT NOT NULL)",
                        why) &&
                (sqlite3_prepare_v2(handle, "INSERT INTO backup VALUES (?, ?, ?)", -1, &statement,
                                    NULL) == SQLITE_OK ||
                 say_error(why, handle, path));
    for (size_t k = 0; k < contents->count && good; k++) {
        const struct backup_table *table = &contents->tables[k];
        sqlite3_bind_text(statement, 1, table->name, -1, SQLITE_STATIC);
        sqlite3_bind_int64(statement, 2, table->rows);
        sqlite3_bind_text(statement, 3, table->checksum, -1, SQLITE_STATIC);
        good = sqlite3_step(statement) == SQLITE_DONE || say_error(why, handle, path);
        sqlite3_reset(statement);
    }
    sqlite3_finalize(statement);
    return good && run_sql(handle, path, "COMMIT", why);
}

/* A copy made by hand has none. */
static bool read_manifest(sqlite3 *handle, const char *path, int64_t schema,
                          struct backup_contents *contents, char why[STORE_WHY_SIZE]) {
    sqlite3_stmt *statement = NULL;
    memset(contents, 0, sizeof *contents);
    contents->schema = schema;
    int code = sqlite3_prepare_v2(handle, "SELECT name, rows, checksum FROM backup ORDER BY name",
                                  -1, &statement, NULL);
    while (code == SQLITE_OK && contents->count < BACKUP_TABLES &&
           sqlite3_step(statement) == SQLITE_ROW) {
        struct backup_table *table = &contents->tables[contents->count++];
        snprintf(table->name, sizeof table->name, "%s",
                 (const char *)sqlite3_column_text(statement, 0));
        table->rows = sqlite3_column_int64(statement, 1);
        snprintf(table->checksum, sizeof table->checksum, "%s",
                 (const char *)sqlite3_column_text(statement, 2));
    }
    sqlite3_finalize(statement);
    if (contents->count == 0)
        backup_fail(why, "%s is not a back-up: it lacks the list of its contents", path);
    return contents->count > 0;
}

/* ------------------------------------------------------------------ copying */

/* Copies all pages of a source that is inside a read transaction, so that none can change, and
 * reads the copy anew, from the disk. The log mode is a mark in the file, which a daemon sets
 * again. */
static bool copy_to(sqlite3 *from, const char *path, const struct backup_contents *contents,
                    bool manifest, char why[STORE_WHY_SIZE]) {
    sqlite3 *to = open_file(path, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, why);
    sqlite3_backup *copy = to ? sqlite3_backup_init(to, "main", from, "main") : NULL;
    int code = copy ? SQLITE_OK : SQLITE_ERROR;
    while (code == SQLITE_OK)
        code = sqlite3_backup_step(copy, STEP_PAGES);
    bool good = copy && sqlite3_backup_finish(copy) == SQLITE_OK && code == SQLITE_DONE;
    if (to && !good)
        say_error(why, to, path);
    good = good && run_sql(to, path, "PRAGMA journal_mode=DELETE; PRAGMA synchronous=FULL", why) &&
           (manifest ? write_manifest(to, path, contents, why)
                     : run_sql(to, path, "DROP TABLE IF EXISTS backup", why));
    if (sqlite3_close(to) != SQLITE_OK && good)
        good = say_error(why, to, path);
    struct backup_contents found;
    sqlite3 *read =
        good && backup_sync(path, why) ? open_file(path, SQLITE_OPEN_READONLY, why) : NULL;
    good = read && check_pages(read, path, why) && read_contents(read, path, &found, why) &&
           backup_same(&found, contents, why);
    sqlite3_close(read);
    return good;
}

bool sqlite_backup_make(const char *database, const char *path, struct backup_contents *contents,
                        char why[STORE_WHY_SIZE]) {
    sqlite3 *from = open_file(database, SQLITE_OPEN_READWRITE, why);
    bool good = from && run_sql(from, database, "BEGIN; SELECT count(*) FROM sqlite_schema", why) &&
                read_contents(from, database, contents, why) &&
                copy_to(from, path, contents, true, why);
    sqlite3_close(from);
    return good;
}

/* ------------------------------------------------------------------ putting back */

static bool beside(const char *database, const char *suffix, char path[PATH_MAX],
                   char why[STORE_WHY_SIZE]) {
    int length = snprintf(path, PATH_MAX, "%s%s", database, suffix);
    if (length > 0 && length < PATH_MAX)
        return true;
    return backup_fail(why, "the name of the database is too long");
}

/* What root puts into the folder of another account is for that account. */
static bool give_to_account(const char *database, const char *path, char why[STORE_WHY_SIZE]) {
    char folder[PATH_MAX];
    struct stat status;
    snprintf(folder, sizeof folder, "%s", database);
    if (geteuid() != 0 || stat(dirname(folder), &status) != 0 ||
        chown(path, status.st_uid, status.st_gid) == 0 || errno == ENOENT)
        return true;
    return backup_fail(why, "the owner of %s cannot be set to that of its folder: %s", path,
                       strerror(errno));
}

/* A second name for a file, if it is there. */
static bool link_file(const char *from, const char *to, char why[STORE_WHY_SIZE]) {
    if (link(from, to) == 0 || errno == ENOENT)
        return true;
    return backup_fail(why, "%s cannot be kept as %s: %s", from, to, strerror(errno));
}

static bool remove_file(const char *path, char why[STORE_WHY_SIZE]) {
    if (unlink(path) == 0 || errno == ENOENT)
        return true;
    return backup_fail(why, "%s cannot be removed: %s", path, strerror(errno));
}

/* What is there of a stage: nothing may be left beside a new one. The copy of a database with a log
 * has one too, until its mode is changed. */
static bool remove_stage(const char *stage, char why[STORE_WHY_SIZE]) {
    static const char *const parts[] = {"-journal", "-wal", "-shm", ""};
    char part[PATH_MAX];
    for (size_t k = 0; k < sizeof parts / sizeof *parts; k++)
        if (!beside(stage, parts[k], part, why) || !remove_file(part, why))
            return false;
    return true;
}

/* The old database gets a second name, with its log, before the new one takes its first: whenever
 * this ends, there is a whole database at the path, the old or the new one. */
static bool swap_databases(const char *database, const char *stage, char kept[BACKUP_KEPT_SIZE],
                           char why[STORE_WHY_SIZE]) {
    char log[PATH_MAX], shared[PATH_MAX], kept_log[PATH_MAX], folder[PATH_MAX];
    char time[BACKUP_TIME_SIZE];
    bool there = access(database, F_OK) == 0;
    backup_time(time);
    snprintf(folder, sizeof folder, "%s", database);
    const char *parent = dirname(folder);
    int length = snprintf(kept, BACKUP_KEPT_SIZE, "%s.before-%s", database, time);
    if (length < 0 || length >= BACKUP_KEPT_SIZE || !beside(database, "-wal", log, why) ||
        !beside(database, "-shm", shared, why) || !beside(kept, "-wal", kept_log, why))
        return false;
    /* What the log holds is taken into the database, so that the one file is all; it may be
     * damaged, and then both are kept as they are. */
    sqlite3 *handle = there ? open_file(database, SQLITE_OPEN_READWRITE, why) : NULL;
    if (handle)
        (void)sqlite3_wal_checkpoint_v2(handle, NULL, SQLITE_CHECKPOINT_TRUNCATE, NULL, NULL);
    sqlite3_close(handle);
    if (!link_file(database, kept, why) || !link_file(log, kept_log, why) ||
        !backup_sync(parent, why) || !remove_file(log, why) || !remove_file(shared, why))
        return false;
    if (rename(stage, database) != 0)
        return backup_fail(why, "%s cannot be renamed: %s", stage, strerror(errno));
    if (!there)
        kept[0] = '\0';
    return backup_sync(parent, why);
}

bool sqlite_backup_restore(const char *database, const char *path, struct backup_contents *contents,
                           char kept[BACKUP_KEPT_SIZE], char why[STORE_WHY_SIZE]) {
    char stage[PATH_MAX], lock_file[PATH_MAX];
    struct backup_contents found;
    if (!beside(database, ".restoring", stage, why) || !beside(database, "-lock", lock_file, why))
        return false;
    struct process_lock *lock = process_lock_take(database, false, why);
    sqlite3 *from = lock && give_to_account(database, lock_file, why)
                        ? open_file(path, SQLITE_OPEN_READONLY, why)
                        : NULL;
    bool good = from && run_sql(from, path, "BEGIN", why) && check_pages(from, path, why) &&
                read_contents(from, path, &found, why) &&
                read_manifest(from, path, found.schema, contents, why) &&
                backup_same(&found, contents, why) && store_schema_known(path, found.schema, why) &&
                remove_stage(stage, why) && copy_to(from, stage, contents, false, why) &&
                give_to_account(database, stage, why) && swap_databases(database, stage, kept, why);
    char ignored[STORE_WHY_SIZE];
    if (!good && lock)
        (void)remove_stage(stage, ignored);
    sqlite3_close(from);
    process_lock_free(lock);
    return good;
}
