/* SPDX-License-Identifier: MIT */
/* A result in the store, as the columns' readers take it. */
#ifndef SERVER_WORK_STORED_RESULT_H
#define SERVER_WORK_STORED_RESULT_H

#include "api/result/columns.h"
#include "server/store/store.h"

/* Plain memory; the store is borrowed. */
struct stored_result {
    struct store *store;
    struct store_result result;
};

/* Its bytes; false for those beyond its end, or when the store does not give them. The reader
 * borrows `stored`. */
struct api_reader stored_result_reader(struct stored_result *stored);

/* Appends its bytes to the file. False when they cannot be read or written. */
bool stored_result_copy(struct stored_result *stored, int file);

#endif
