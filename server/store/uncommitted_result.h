/* SPDX-License-Identifier: MIT */
/*
 * The end of a result in memory, all of it if it is short: what a writer has not stored yet. While
 * a short result is being committed it is listed, and can be read by those that wait for its
 * job (`store.h`). Its chunks go to the cache of stored ones at last.
 */
#ifndef SERVER_STORE_UNCOMMITTED_RESULT_H
#define SERVER_STORE_UNCOMMITTED_RESULT_H

#include "backend.h"
#include <stdatomic.h>

/* The fields but `uses` and `number` are the writer's until it is listed; then they do not change.
 */
struct store_uncommitted {
    struct store *store;
    char id[ID_SIZE]; /* of the job */
    atomic_int uses;
    atomic_int_fast64_t number; /* of the result in the store; 0: not yet, or never */
    int64_t index;              /* of the first chunk */
    size_t length;
    unsigned char *chunks[STORE_SEGMENT_CHUNKS]; /* malloc'ed when they are needed */
    bool listed;
    struct store_uncommitted *next;
};

/* An empty one, in use by the writer; NULL without memory. */
struct store_uncommitted *uncommitted_new(struct store *store, const char *id);

/* From now on it can be taken; once. */
void uncommitted_list(struct store_uncommitted *uncommitted);

/* It has become the result of that number (0: it has not), and cannot be taken any more. The writer
 * does not use it after this. NULL is allowed. */
void uncommitted_close(struct store_uncommitted *uncommitted, int64_t number);

#endif
