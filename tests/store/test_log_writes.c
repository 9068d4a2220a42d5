/* SPDX-License-Identifier: MIT */
/*
 * Databases whose log goes through `log_writes.h`, against what SQLite without it finds in the same
 * files: random transactions, larger than the writer's cache so that they are written before their
 * end, with savepoints and roll-backs, none of which waits for the disk.
 */
#include "scratch.h"
#include "server/store/sqlite/log_writes.h"
#include <sqlite3.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <unistd.h>

enum { ROUNDS = 250, COPY_EVERY = 10, BLOB_MOST = 60000, ROWS = 40 };

static atomic_int writes; /* of the SQLite library, since it was set to 0 */

ssize_t pwrite64(int file, const void *bytes, size_t length, off_t at);
ssize_t pwrite64(int file, const void *bytes, size_t length, off_t at) {
    atomic_fetch_add(&writes, 1);
    return (ssize_t)syscall(SYS_pwrite64, file, bytes, length, at);
}

/* What a connection sees of the table: enough to tell two states apart. */
struct sight {
    int64_t rows, bytes, sum;
};

static sqlite3 *open_plainly(const char *path) {
    sqlite3 *db = NULL;
    int flags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE;
    assert_int_equal(sqlite3_open_v2(path, &db, flags, NULL), SQLITE_OK);
    return db;
}

static sqlite3 *open_with_layer(const char *path) {
    sqlite3 *db = NULL;
    int flags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE;
    assert_int_equal(log_writes_open(path, &db, flags), SQLITE_OK);
    return db;
}

static void run(sqlite3 *db, const char *sql) {
    if (sqlite3_exec(db, sql, NULL, NULL, NULL) != SQLITE_OK)
        fail_msg("%s: %s", sql, sqlite3_errmsg(db));
}

static struct sight look(sqlite3 *db) {
    sqlite3_stmt *statement = NULL;
    assert_int_equal(sqlite3_prepare_v2(db,
                                        "SELECT count(*), total(length(bytes)), total(id * mark)"
                                        " FROM t",
                                        -1, &statement, NULL),
                     SQLITE_OK);
    assert_int_equal(sqlite3_step(statement), SQLITE_ROW);
    struct sight sight = {sqlite3_column_int64(statement, 0), sqlite3_column_int64(statement, 1),
                          sqlite3_column_int64(statement, 2)};
    sqlite3_finalize(statement);
    return sight;
}

static void expect(const struct sight *a, const struct sight *b) {
    assert_int_equal(a->rows, b->rows);
    assert_int_equal(a->bytes, b->bytes);
    assert_int_equal(a->sum, b->sum);
}

static int draw(uint64_t *random, int most) {
    return (int)(scratch_random(random) % (uint64_t)most);
}

static void change(sqlite3 *db, uint64_t *random) {
    char sql[160];
    snprintf(sql, sizeof sql, "INSERT OR REPLACE INTO t VALUES (%d, randomblob(%d), %d)",
             draw(random, ROWS), draw(random, 8) ? draw(random, 500) : draw(random, BLOB_MOST),
             draw(random, 1000));
    run(db, sql);
    if (draw(random, 4) == 0) {
        snprintf(sql, sizeof sql, "DELETE FROM t WHERE id = %d", draw(random, ROWS));
        run(db, sql);
    }
}

/* A transaction up to its end; `other` sees nothing of it meanwhile. */
static void change_some(sqlite3 *db, sqlite3 *other, uint64_t *random) {
    struct sight before = look(other);
    run(db, "BEGIN IMMEDIATE");
    for (int k = draw(random, 12); k >= 0; k--) {
        run(db, "SAVEPOINT one");
        change(db, random);
        if (draw(random, 3) == 0)
            run(db, "ROLLBACK TO one");
        run(db, "RELEASE one");
    }
    struct sight during = look(other);
    expect(&during, &before);
}

/* What is in the files now is what a power cut, or a kill, would leave to be recovered. */
static void check_copy(const char *path, const struct sight *sight) {
    char command[8 * SCRATCH_PATH_SIZE], copy[SCRATCH_PATH_SIZE + 8];
    snprintf(copy, sizeof copy, "%s.copy", path);
    snprintf(command, sizeof command, "rm -f %s*; cp %s %s; cp %s-wal %s-wal", copy, path, copy,
             path, copy);
    assert_int_equal(system(command), 0);
    sqlite3 *db = open_plainly(copy);
    struct sight found = look(db);
    expect(&found, sight);
    sqlite3_stmt *statement = NULL;
    assert_int_equal(sqlite3_prepare_v2(db, "PRAGMA integrity_check", -1, &statement, NULL),
                     SQLITE_OK);
    assert_int_equal(sqlite3_step(statement), SQLITE_ROW);
    assert_string_equal((const char *)sqlite3_column_text(statement, 0), "ok");
    sqlite3_finalize(statement);
    sqlite3_close(db);
}

static void set_up_table(sqlite3 *db) {
    run(db, "PRAGMA page_size=8192; PRAGMA journal_mode=WAL; PRAGMA synchronous=NORMAL;"
            "PRAGMA cache_size=10; PRAGMA wal_autocheckpoint=0; PRAGMA journal_size_limit=100000;"
            "CREATE TABLE t (id INTEGER PRIMARY KEY, bytes, mark)");
}

static void test_log_writes_leave_what_sqlite_would(void **state) {
    (void)state;
    struct scratch scratch;
    scratch_make(&scratch);
    sqlite3 *db = open_with_layer(scratch.path);
    set_up_table(db);
    sqlite3 *other = open_plainly(scratch.path);
    uint64_t random = check_seed(1);
    struct sight last = look(db);
    for (int round = 0; round < ROUNDS; round++) {
        change_some(db, other, &random);
        struct sight own = look(db);
        bool kept = draw(&random, 4) > 0;
        run(db, kept ? "COMMIT" : "ROLLBACK");
        struct sight after = look(db), seen = look(other);
        expect(&after, kept ? &own : &last);
        expect(&seen, &after);
        last = after;
        if (round % COPY_EVERY == 0)
            check_copy(scratch.path, &after);
        if (draw(&random, 8) == 0)
            run(draw(&random, 2) ? db : other, "PRAGMA wal_checkpoint(TRUNCATE)");
    }
    sqlite3_close(other);
    sqlite3_close(db);
    scratch_remove(&scratch);
}

/* Two writers: what one has given up is not written over what the other then commits. */
static void test_log_writes_forget_what_was_rolled_back(void **state) {
    (void)state;
    struct scratch scratch;
    scratch_make(&scratch);
    sqlite3 *first = open_with_layer(scratch.path);
    set_up_table(first);
    sqlite3 *second = open_with_layer(scratch.path);
    run(second, "PRAGMA cache_size=10");
    uint64_t random = check_seed(1);
    for (int round = 0; round < ROUNDS; round++) {
        sqlite3 *one = round % 2 ? first : second, *other = round % 2 ? second : first;
        if (round % 3)
            run(one, "PRAGMA wal_checkpoint(TRUNCATE)");
        run(one, "BEGIN IMMEDIATE");
        for (int k = draw(&random, 3); k >= 0; k--)
            run(one, "INSERT INTO t VALUES (NULL, randomblob(110000), 1)");
        run(one, "ROLLBACK");
        run(other, "BEGIN IMMEDIATE");
        for (int k = draw(&random, 20); k >= 0; k--)
            change(other, &random);
        run(other, "COMMIT");
        struct sight committed = look(other), seen = look(one);
        expect(&seen, &committed);
        if (round % COPY_EVERY == 0)
            check_copy(scratch.path, &committed);
    }
    sqlite3_close(first);
    sqlite3_close(second);
    scratch_remove(&scratch);
}

/* 500 kB are 62 pages, each of which SQLite writes by two calls. */
static void test_log_writes_are_few(void **state) {
    (void)state;
    struct scratch scratch;
    int count[2];
    for (int layered = 0; layered < 2; layered++) {
        scratch_make(&scratch);
        sqlite3 *db = layered ? open_with_layer(scratch.path) : open_plainly(scratch.path);
        set_up_table(db);
        run(db, "PRAGMA cache_size=1000");
        atomic_store(&writes, 0);
        run(db, "INSERT INTO t VALUES (1, randomblob(500000), 1)");
        count[layered] = atomic_load(&writes);
        sqlite3_close(db);
        scratch_remove(&scratch);
    }
    print_message("%d writes, %d without\n", count[1], count[0]);
    assert_true(count[0] > 120);
    assert_true(count[1] < 12);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_log_writes_leave_what_sqlite_would),
        cmocka_unit_test(test_log_writes_forget_what_was_rolled_back),
        cmocka_unit_test(test_log_writes_are_few),
    };
    return cmocka_run_group_tests_name("log writes", tests, NULL, NULL);
}
