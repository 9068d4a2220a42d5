/* SPDX-License-Identifier: MIT */
/*
 * Copies of a PostgreSQL store, made by `pg_dump` and put back by `pg_restore` and `psql`, which
 * have to be installed. They are told of the database by their environment: command lines can be
 * read by everybody. What they have to complain about they write on stderr themselves.
 */
#include "server/store/backup.h"
#include "pool.h"
#include "postgres.h"
#include <errno.h>
#include <fcntl.h>
#include <libpq-fe.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

enum { SQL_SIZE = 2048, NAME_SIZE = 64, CONNECT_MS = 10000, NOT_FOUND = 127 };

/* Has the URL and a name of its own, by which the server tells it from daemons, in the environment
 * of this process and its children. NULL with `why`. */
static struct pool *open_database(const char *url, char why[STORE_WHY_SIZE]) {
    setenv("PGAPPNAME", "draped-backup", 1);
    struct pool *pool = pool_open(url, CONNECT_MS, why);
    PQconninfoOption *options = pool ? PQconninfoParse(url, NULL) : NULL;
    for (const PQconninfoOption *option = options; option && option->keyword; option++)
        if (option->envvar && option->val)
            setenv(option->envvar, option->val, 1);
    PQconninfoFree(options);
    return pool;
}

/* ------------------------------------------------------------------ PostgreSQL's programs */

/* Starts it with that input and output, as far as they are not -1; it ends when this process does.
 */
static pid_t start_program(char *const arguments[], int in, int out) {
    pid_t own = getpid(), child = fork();
    if (child != 0)
        return child;
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() == own && (in < 0 || dup2(in, STDIN_FILENO) >= 0) &&
        (out < 0 || dup2(out, STDOUT_FILENO) >= 0))
        execvp(arguments[0], arguments);
    _exit(NOT_FOUND);
}

static bool end_program(const char *name, pid_t child, char why[STORE_WHY_SIZE]) {
    int status = -1;
    while (child > 0 && waitpid(child, &status, 0) < 0 && errno == EINTR)
        continue;
    if (status == 0)
        return true;
    return WIFEXITED(status) && WEXITSTATUS(status) == NOT_FOUND
               ? backup_fail(why,
                             "%s cannot be started: install PostgreSQL's client programs, of the "
                             "server's version or newer (on Debian: apt install postgresql-client)",
                             name)
               : backup_fail(why, "%s has failed (see above)", name);
}

/* Writes the statements of the copy to `out`; has read it to its end when this is true. */
static bool read_copy(const char *path, int out, char why[STORE_WHY_SIZE]) {
    char file[BACKUP_KEPT_SIZE], to[] = "--file=/dev/null";
    char *const arguments[] = {"pg_restore", "--no-owner", "--no-privileges", to, file, NULL};
    snprintf(file, sizeof file, "%s", path);
    if (out >= 0)
        snprintf(to, sizeof to, "--file=-");
    return end_program(arguments[0], start_program(arguments, -1, out), why);
}

/* ------------------------------------------------------------------ what it holds */

/* By the transaction that is open, if one is. */
static bool count_contents(struct pool *pool, struct backup_contents *contents,
                           char why[STORE_WHY_SIZE]) {
    static const char *const tables[] = {"jobs", "results", "surfaces"};
    struct query query =
        pg_query(pool, "SELECT max(version), (SELECT count(*) FROM draped.jobs),"
                       " (SELECT count(*) FROM draped.results),"
                       " (SELECT count(*) FROM draped.surfaces) FROM draped.schema_version");
    if (query_row(&query)) {
        contents->schema = query_int(&query, 0);
        for (contents->count = 0; contents->count < 3; contents->count++) {
            struct backup_table *table = &contents->tables[contents->count];
            snprintf(table->name, sizeof table->name, "%s", tables[contents->count]);
            table->rows = query_int(&query, (int)contents->count + 1);
        }
    }
    return query_end(&query) == STORE_OK ||
           backup_fail(why, "the database has no store of draped, or it cannot be read");
}

/* ------------------------------------------------------------------ making a copy */

/* The file is complete when it can be read from end to end, as it is on the disk. */
bool postgres_backup_make(const char *url, const char *path, struct backup_contents *contents,
                          char why[STORE_WHY_SIZE]) {
    char snapshot[NAME_SIZE] = "--snapshot=", file[BACKUP_KEPT_SIZE];
    char *const arguments[] = {"pg_dump",    "--format=custom", "--compress=1", "--schema=draped",
                               "--no-owner", "--no-privileges", snapshot,       file,
                               NULL};
    size_t length = strlen(snapshot);
    struct pool *pool = open_database(url, why);
    bool good = pool != NULL;
    if (good && snprintf(file, sizeof file, "--file=%s", path) >= (int)sizeof file)
        good = backup_fail(why, "the name of the folder is too long");
    /* One thread has one connection, so that the transaction is that of all statements here. The
     * numbers of rows and the copy are of one moment. */
    good = good &&
           pg_script(pool,
                     "SET idle_in_transaction_session_timeout = 0; SET statement_timeout = 0;"
                     "BEGIN ISOLATION LEVEL REPEATABLE READ READ ONLY",
                     NULL, why) &&
           count_contents(pool, contents, why);
    if (good) {
        struct query query = pg_query(pool, "SELECT pg_export_snapshot()");
        if (query_row(&query))
            query_copy(&query, 0, snapshot + length, sizeof snapshot - length);
        good = query_end(&query) == STORE_OK
                   ? end_program(arguments[0], start_program(arguments, -1, -1), why)
                   : backup_fail(why, "the database did not give a snapshot (see above)");
    }
    pool_close(pool);
    return good && backup_sync(path, why) && read_copy(path, -1, why);
}

/* ------------------------------------------------------------------ putting back */

/* Before the copy's own statements: what is there gets another name. Processes that use it are in
 * the way. */
static const char before_sql[] =
    "BEGIN; SELECT pg_advisory_xact_lock(7237965216410200);"
    "DO $$ DECLARE others integer; BEGIN"
    " SELECT count(*) INTO others FROM pg_stat_activity WHERE datname = current_database()"
    "  AND application_name = 'draped';"
    " IF others > 0 THEN RAISE EXCEPTION"
    "  'draped has %% connections to the database: stop all of its processes', others; END IF;"
    " IF to_regnamespace('draped') IS NOT NULL THEN"
    "  ALTER SCHEMA draped RENAME TO %s; END IF; "
    "END $$;\n";

/* And after them. */
static const char after_sql[] =
    "\nDO $$ BEGIN"
    " IF (SELECT max(version) FROM draped.schema_version) IS DISTINCT FROM %d THEN"
    "  RAISE EXCEPTION 'the copy was made by another version of draped: restore it with that';"
    " END IF; "
    "END $$; COMMIT;\n";

static bool write_all(int out, const char *text) {
    size_t length = strlen(text);
    return write(out, text, length) == (ssize_t)length;
}

/* All of it is one transaction of psql, which ends without a commit unless it is told to at the
 * end: what is not whole has changed nothing. */
static bool restore_into(const char *path, const char *old, char why[STORE_WHY_SIZE]) {
    static char *const arguments[] = {
        "psql",     "--no-psqlrc", "--quiet", "--set=ON_ERROR_STOP=1", "--output=/dev/null",
        "--file=-", NULL};
    char before[SQL_SIZE], after[SQL_SIZE];
    int pipes[2];
    snprintf(before, sizeof before, before_sql, old);
    snprintf(after, sizeof after, after_sql, (int)STORE_SCHEMA);
    if (pipe2(pipes, O_CLOEXEC) != 0)
        return backup_fail(why, "no pipe: %s", strerror(errno));
    pid_t psql = start_program(arguments, pipes[0], -1);
    close(pipes[0]);
    bool read =
        write_all(pipes[1], before) && read_copy(path, pipes[1], why) && write_all(pipes[1], after);
    close(pipes[1]);
    char ended[STORE_WHY_SIZE];
    bool good = end_program(arguments[0], psql, ended);
    if (!good)
        memcpy(why, ended, sizeof ended);
    else if (!read)
        backup_fail(why, "%s cannot be read (see above)", path);
    return good && read;
}

bool postgres_backup_restore(const char *url, const char *path, struct backup_contents *contents,
                             char kept[BACKUP_KEPT_SIZE], char why[STORE_WHY_SIZE]) {
    char old[NAME_SIZE], time[BACKUP_TIME_SIZE], start[5] = "";
    FILE *in = fopen(path, "re");
    bool good = in && fread(start, 1, sizeof start, in) == sizeof start &&
                !memcmp(start, "PGDMP", sizeof start);
    if (in)
        fclose(in);
    if (!good)
        return backup_fail(why, "%s is not a back-up of a PostgreSQL store", path);
    if (!read_copy(path, -1, why))
        return false;
    struct pool *pool = open_database(url, why);
    if (!pool)
        return false;
    /* The name that the old schema gets, if there is one. */
    struct query query = pg_query(pool, "SELECT to_regnamespace('draped') IS NOT NULL");
    bool there = query_row(&query) && query_int(&query, 0) != 0;
    backup_time(time);
    for (char *c = time; *c; c++)
        *c = *c == '.' ? '_' : *c == 'T' ? 't' : *c == 'Z' ? 'z' : *c;
    snprintf(old, sizeof old, "draped_before_%s", time);
    good = (query_end(&query) == STORE_OK || backup_fail(why, "the database cannot be read")) &&
           restore_into(path, old, why) && count_contents(pool, contents, why);
    pool_close(pool);
    if (good && there)
        snprintf(kept, BACKUP_KEPT_SIZE, "schema %s", old);
    return good;
}
