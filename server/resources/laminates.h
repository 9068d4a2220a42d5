/* SPDX-License-Identifier: MIT */
/* What handlers of jobs and maps leave to laminates. */
#ifndef SERVER_RESOURCES_LAMINATES_H
#define SERVER_RESOURCES_LAMINATES_H

#include "call.h"
#include "checking.h"
#include "server/store/store.h"

/* Submits a laminate that `check` has passed, with its drapes. */
enum store_answer laminates_submit(struct call *call, struct check *check,
                                   const struct store_submission *submission,
                                   struct store_receipt *receipt) STORE_MUST_USE;

/* The status document with what became of every ply; malloc'ed, NULL without memory. */
char *laminates_status(struct store *store, const struct store_job *job);

/* As `maps_take_columns`, of a laminate: `*record` has to be freed when the check has begun. */
bool laminates_take_columns(struct call *call, struct document_pool_order *order, char **record);

#endif
