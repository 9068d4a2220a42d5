/* SPDX-License-Identifier: MIT */
#include "scratch.h"
#include "cluster.h"
#include "server/clock.h"
#include "server/log.h"
#include "server/store/postgres/pool.h"
#include "server/store/postgres/statement.h"
#include "server/store/sqlite/db.h"
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

/* Some day in 2001: nothing may depend on when the tests run. */
_Atomic int64_t scratch_now = INT64_C(1000000000) * 1000000;

struct cluster scratch_cluster;

_Atomic int64_t scratch_jump;

static int64_t clock_of_test(void) {
    return scratch_now + scratch_jump;
}

static int64_t monotonic_clock_of_test(void) {
    return scratch_now;
}

void scratch_make(struct scratch *scratch) {
    const char *base = getenv("TMPDIR");
    memset(scratch, 0, sizeof *scratch);
    assert_true(id_init());
    log_init((enum log_level)(LOG_LEVEL_ERROR + 1)); /* failures are asserted, not read */
    snprintf(scratch->folder, sizeof scratch->folder, "%s/draped-test-XXXXXX",
             base && strlen(base) < 64 ? base : "/tmp");
    assert_non_null(mkdtemp(scratch->folder));
    snprintf(scratch->path, sizeof scratch->path, "%.100s/store.db", scratch->folder);
    scratch->remote = scratch_cluster.pid != 0;
    if (scratch->remote)
        snprintf(scratch->path, sizeof scratch->path, "%s", scratch_cluster.url);
    scratch_forget(scratch);
    scratch->options = store_options_default;
    scratch->options.clock = clock_of_test;
    scratch->options.monotonic_clock = monotonic_clock_of_test;
    scratch->options.clock_trust_us = 0;
    scratch_jump = 0;
}

void scratch_forget(struct scratch *scratch) {
    if (scratch->remote)
        scratch_script(scratch, "DROP SCHEMA IF EXISTS draped CASCADE");
    else
        unlink(scratch->path); /* closed, it is one file */
}

void scratch_start(struct scratch *scratch) {
    char why[STORE_WHY_SIZE] = "";
    scratch->events = job_events_new();
    assert_non_null(scratch->events);
    scratch->store = store_open(scratch->path, &scratch->options, scratch->events, why);
    if (!scratch->store)
        fail_msg("the store does not open: %s", why);
}

void scratch_stop(struct scratch *scratch) {
    store_close(scratch->store);
    job_events_free(scratch->events);
    scratch->store = NULL;
    scratch->events = NULL;
}

/* An empty database of the current schema, as the store leaves it. Making it takes longer than most
 * tests, so it is made once and copied. */
static struct {
    unsigned char *bytes;
    size_t length;
} empty;

static void read_empty(const struct scratch *scratch) {
    FILE *file = fopen(scratch->path, "rb");
    assert_non_null(file);
    assert_int_equal(fseek(file, 0, SEEK_END), 0);
    empty.length = (size_t)ftell(file);
    empty.bytes = malloc(empty.length);
    rewind(file);
    assert_non_null(empty.bytes);
    assert_int_equal(fread(empty.bytes, 1, empty.length, file), empty.length);
    fclose(file);
}

static void copy_empty(struct scratch *scratch) {
    if (scratch->remote)
        return;
    if (!empty.bytes) {
        scratch_start(scratch);
        scratch_stop(scratch);
        read_empty(scratch);
    }
    int file = open(scratch->path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    assert_true(file >= 0);
    assert_int_equal(write(file, empty.bytes, empty.length), empty.length);
    close(file);
}

void scratch_open(struct scratch *scratch) {
    scratch_make(scratch);
    copy_empty(scratch);
    scratch_start(scratch);
}

void scratch_open_live(struct scratch *scratch) {
    scratch_make(scratch);
    copy_empty(scratch);
    scratch->options.clock = NULL;
    scratch->options.monotonic_clock = NULL;
    scratch_start(scratch);
}

void scratch_remove(struct scratch *scratch) {
    char path[2 * SCRATCH_PATH_SIZE + 256];
    if (scratch->store)
        scratch_stop(scratch);
    DIR *folder = opendir(scratch->folder);
    assert_non_null(folder);
    for (struct dirent *entry = NULL; (entry = readdir(folder)) != NULL;) {
        snprintf(path, sizeof path, "%s/%s", scratch->folder, entry->d_name);
        if (entry->d_name[0] != '.')
            unlink(path);
    }
    closedir(folder);
    assert_int_equal(rmdir(scratch->folder), 0);
}

int scratch_set_up(void **state) {
    struct scratch *scratch = malloc(sizeof *scratch);
    scratch_open(scratch);
    *state = scratch;
    return 0;
}

int scratch_tear_down(void **state) {
    scratch_remove(*state);
    free(*state);
    return 0;
}

/* ------------------------------------------------------------------ both backends */

int scratch_start_cluster(void **state) {
    (void)state;
    cluster_start(&scratch_cluster);
    return 0;
}

int scratch_remove_cluster(void **state) {
    (void)state;
    cluster_remove(&scratch_cluster);
    return 0;
}

int scratch_run_tests(const char *name, const struct CMUnitTest *tests, size_t count,
                      const struct CMUnitTest *only_sqlite, size_t only_count) {
    char group[128];
    snprintf(group, sizeof group, "%s, SQLite", name);
    int failed = _cmocka_run_group_tests(group, tests, count, NULL, NULL);
    if (only_count > 0)
        failed += _cmocka_run_group_tests(group, only_sqlite, only_count, NULL, NULL);
    snprintf(group, sizeof group, "%s, PostgreSQL", name);
    return failed + _cmocka_run_group_tests(group, tests, count, scratch_start_cluster,
                                            scratch_remove_cluster);
}

static int64_t sqlite_number(const char *path, const char *sql) {
    char why[STORE_WHY_SIZE];
    char text[512] = "";
    struct db *db = db_open(path, 1000, why);
    assert_non_null(db);
    for (const char *from = sql; *from; from += !strncmp(from, "draped.", 7) ? 7 : 1) {
        size_t used = strlen(text);
        assert_true(used + 1 < sizeof text);
        if (strncmp(from, "draped.", 7) != 0)
            text[used] = *from;
    }
    struct query query = db_query(db, text);
    assert_true(query_row(&query));
    int64_t number = query_int(&query, 0);
    assert_int_equal(query_end(&query), STORE_OK);
    db_close(db);
    return number;
}

int64_t scratch_number(struct scratch *scratch, const char *sql) {
    char why[STORE_WHY_SIZE];
    if (!scratch->remote)
        return sqlite_number(scratch->path, sql);
    struct pool *pool = pool_open(scratch->path, POOL_PATIENCE_MS, why);
    assert_non_null(pool);
    struct query query = pg_query(pool, sql);
    assert_true(query_row(&query));
    int64_t number = query_int(&query, 0);
    assert_int_equal(query_end(&query), STORE_OK);
    pool_close(pool);
    return number;
}

void scratch_script(struct scratch *scratch, const char *sql) {
    char why[STORE_WHY_SIZE] = "";
    struct pool *pool = scratch->remote ? pool_open(scratch->path, POOL_PATIENCE_MS, why) : NULL;
    struct db *db = scratch->remote ? NULL : db_open(scratch->path, 1000, why);
    bool good = pool ? pg_script(pool, sql, NULL, why) : db && db_script(db, sql) == STORE_OK;
    if (!good)
        fail_msg("the script fails: %s", why);
    pool_close(pool);
    db_close(db);
}

/* ------------------------------------------------------------------ jobs */

void scratch_submit(struct scratch *scratch, const char *body, char id[ID_SIZE]) {
    char digest[STORE_DIGEST_SIZE];
    struct store_receipt receipt;
    snprintf(digest, sizeof digest, "%s", body);
    struct store_submission submission = {
        .request = body, .request_length = strlen(body), .digest = digest};
    assert_int_equal(store_submit(scratch->store, &submission, &receipt), STORE_OK);
    assert_true(id_valid(receipt.id));
    memcpy(id, receipt.id, ID_SIZE);
}

struct store_claim scratch_claimed(struct scratch *scratch, const char *body) {
    char id[ID_SIZE];
    struct store_claim claim;
    scratch_submit(scratch, body, id);
    assert_int_equal(store_claim(scratch->store, &claim), STORE_OK);
    assert_string_equal(claim.id, id);
    return claim;
}

enum store_answer scratch_commit(struct scratch *scratch, const struct store_claim *claim,
                                 const void *bytes, size_t length) {
    return scratch_commit_and_claim(scratch, claim, bytes, length, NULL);
}

enum store_answer scratch_commit_and_claim(struct scratch *scratch, const struct store_claim *claim,
                                           const void *bytes, size_t length,
                                           struct store_claim *next) {
    struct store_writer *writer = store_writer_new(scratch->store, claim);
    assert_non_null(writer);
    enum store_answer answer = store_writer_append(writer, bytes, length);
    if (answer == STORE_OK)
        answer = store_writer_commit_and_claim(writer, "{\"nodes\":1}", next);
    store_writer_free(writer);
    return answer;
}

enum store_status scratch_status(struct scratch *scratch, const char *id) {
    struct store_job job;
    assert_int_equal(store_get(scratch->store, id, &job), STORE_OK);
    store_job_clear(&job);
    return job.status;
}

struct store_sweep scratch_sweep(struct scratch *scratch) {
    struct store_sweep sweep;
    assert_int_equal(store_sweep(scratch->store, &sweep), STORE_OK);
    return sweep;
}

void scratch_expect_result(struct scratch *scratch, const char *id, const void *bytes,
                           size_t length, size_t piece) {
    struct store_result result;
    unsigned char *got = malloc(length + 1);
    assert_non_null(got);
    assert_int_equal(store_result_find(scratch->store, id, &result), STORE_OK);
    assert_int_equal(result.length, length);
    for (size_t at = 0; at < length; at += piece) {
        size_t left = length - at;
        assert_int_equal(store_result_read(scratch->store, &result, (int64_t)at, got + at,
                                           left < piece ? left : piece),
                         STORE_OK);
    }
    assert_memory_equal(got, bytes, length);
    free(got);
}

/* splitmix64 */
uint64_t scratch_random(uint64_t *state) {
    uint64_t z = *state += UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return z ^ (z >> 31);
}

void scratch_sleep(int ms) {
    struct timespec pause = {ms / 1000, ms % 1000 * 1000000L};
    while (nanosleep(&pause, &pause) != 0 && errno == EINTR)
        continue;
}
