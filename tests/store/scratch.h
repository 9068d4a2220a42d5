/* SPDX-License-Identifier: MIT */
/*
 * A store for one test, with a clock that the test sets: SQLite in a folder of its own, or an empty
 * PostgreSQL database. What any store has to do is tested on both, by `scratch_run`.
 */
#ifndef TESTS_SCRATCH_H
#define TESTS_SCRATCH_H

#include "cluster.h"
#include "server/job_events.h"
#include "server/store/store.h"
#include "tests/check.h"
#include <stdbool.h>

enum { SCRATCH_PATH_SIZE = 256 };

struct scratch {
    char folder[SCRATCH_PATH_SIZE];
    char path[SCRATCH_PATH_SIZE]; /* of the database, or its URL */
    bool remote;                  /* it is PostgreSQL */
    struct store_options options;
    struct job_events *events;
    struct store *store;
};

/* What the store takes for the time, in microseconds. Moved by tests. */
extern _Atomic int64_t scratch_now;

/* By how much the wall clock has been set forward or back since; 0 in a new store. */
extern _Atomic int64_t scratch_jump;

/* The server while tests run with PostgreSQL. */
extern struct cluster scratch_cluster;

/* Set-up and tear-down of a group of tests: while they run, all stores are PostgreSQL's. */
int scratch_start_cluster(void **state);
int scratch_remove_cluster(void **state);

/* Runs the tests with SQLite and then with PostgreSQL; `only_sqlite`, which may be NULL, with the
 * former alone. The number that failed. */
#define scratch_run(name, tests, only_sqlite, only_count)                                          \
    scratch_run_tests(name, tests, sizeof(tests) / sizeof *(tests), only_sqlite, only_count)
int scratch_run_tests(const char *name, const struct CMUnitTest *tests, size_t count,
                      const struct CMUnitTest *only_sqlite, size_t only_count);

/* A new folder and, in it, a store with default options and the clock of the test. */
void scratch_open(struct scratch *scratch);

/* The same with the system's clock, for tests that run workers. */
void scratch_open_live(struct scratch *scratch);

/* Only the folder. */
void scratch_make(struct scratch *scratch);

/* Opens and closes the store of a folder that is there, with `scratch->options`. */
void scratch_start(struct scratch *scratch);
void scratch_stop(struct scratch *scratch);

/* Makes an empty one of a database that nobody has open. */
void scratch_forget(struct scratch *scratch);

/* Closes the store and removes the folder. */
void scratch_remove(struct scratch *scratch);

/* Set-up and tear-down of a test: `*state` is one that `scratch_open` made. */
int scratch_set_up(void **state);
int scratch_tear_down(void **state);

/* Submits a body whose digest is the body itself (its first 64 bytes). The answer must be OK. */
void scratch_submit(struct scratch *scratch, const char *body, char id[ID_SIZE]);

/* Submits and claims; the queue must have been empty. */
struct store_claim scratch_claimed(struct scratch *scratch, const char *body);

/* Ends the claimed job with a result of these bytes. */
enum store_answer scratch_commit(struct scratch *scratch, const struct store_claim *claim,
                                 const void *bytes, size_t length);
/* The same; of `next` as `store_writer_commit_and_claim`. */
enum store_answer scratch_commit_and_claim(struct scratch *scratch, const struct store_claim *claim,
                                           const void *bytes, size_t length,
                                           struct store_claim *next);

/* The status of a job that must exist. */
enum store_status scratch_status(struct scratch *scratch, const char *id);

/* The number a statement tells, seen by a connection of its own. Tables of PostgreSQL are written
 * as `draped.NAME`; for SQLite that is taken for NAME. */
int64_t scratch_number(struct scratch *scratch, const char *sql);

/* Executes statements on the database. */
void scratch_script(struct scratch *scratch, const char *sql);

/* One sweep, which must succeed. */
struct store_sweep scratch_sweep(struct scratch *scratch);

/* Asserts that the result of the job has these bytes, read in pieces of `piece`. */
void scratch_expect_result(struct scratch *scratch, const char *id, const void *bytes,
                           size_t length, size_t piece);

/* The next of a sequence of well mixed numbers. */
uint64_t scratch_random(uint64_t *state);

/* Sleeps for so many milliseconds. */
void scratch_sleep(int ms);

#endif
