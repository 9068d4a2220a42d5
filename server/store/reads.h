/* SPDX-License-Identifier: MIT */
/*
 * What is read, in one text for both databases: most functions of `store.h` that only look. They
 * begin a statement by the store's reader; what has to be written differently is in its dialect.
 */
#ifndef SERVER_STORE_READS_H
#define SERVER_STORE_READS_H

#include "cursor.h"
#include "query.h"
#include "store.h"

/* Whole statements. */
struct dialect {
    /* Numbers with what they count: jobs by the status that is reported; queued and running tasks
     * as 8 and 9; jobs that have ended, as 10 and their status; of these, crashed ones as 15. */
    const char *counts;
    /* How many hosts, their workers and those that are busy, of those seen $2 before $1, the time
     * or null, at the earliest. */
    const char *hosts;
    /* The bytes of a chunk and their seal: result $1, index $2. */
    const char *chunk;
    /* What is wrong with the database's own file, a sentence a row, "ok" for nothing; NULL: it
     * cannot be asked. */
    const char *check;
};

struct reader {
    struct query (*query)(void *of, const char *sql);
    void *of;
    const struct dialect *dialect;
};

/* Without `now` (0) by the database's clock. */
enum store_answer reads_counts(const struct reader *reader, int64_t now,
                               struct store_counts *counts) STORE_MUST_USE;

/* The row of a claim: sequence, id, surface, token, attempts, number of the complete result of its
 * digest (0: none), owner, origin, kind, spent, task, id of its parent, how long it has waited. */
void reads_claim(const struct query *query, struct store_claim *claim, int64_t *result);

/* One chunk of a result, which has that length. STORE_EMPTY: the result has been removed. */
enum store_answer reads_chunk(struct store *store, const struct store_result *result, int64_t index,
                              void *bytes, size_t length) STORE_MUST_USE;

/* The attempts of a job that runs under the claim, and how many of them are excused: not held
 * against it. STORE_CONFLICT when it does not. */
enum store_answer reads_attempts(struct store *store, const struct store_claim *claim,
                                 int64_t *attempts, int64_t *excused) STORE_MUST_USE;

/* The key of the store's cursors. */
enum store_answer reads_secret(struct store *store,
                               unsigned char secret[CURSOR_SECRET_BYTES]) STORE_MUST_USE;

#endif
