/* SPDX-License-Identifier: MIT */
/*
 * The numbers that stand for states in the tables of both backends, as words for their statements:
 * literals, because a partial index is used only where its condition is seen when a statement is
 * prepared.
 */
#ifndef SERVER_STORE_SQL_H
#define SERVER_STORE_SQL_H

#include "store.h"

/* jobs.status is enum store_status. */
#define SQL_QUEUED "0"
#define SQL_RUNNING "1"
#define SQL_SUCCEEDED "2"
#define SQL_FAILED "3"
#define SQL_CANCELLED "4"
#define SQL_FIRST_ENDED SQL_SUCCEEDED /* this status and all above have ended */

_Static_assert(STORE_QUEUED == 0 && STORE_RUNNING == 1 && STORE_SUCCEEDED == 2 &&
                   STORE_FAILED == 3 && STORE_CANCELLED == 4,
               "as in the words above");

/* results.state: being written under a claim; whole, and named by jobs; to be deleted step by step.
 */
#define SQL_BUILDING "0"
#define SQL_COMPLETE "1"
#define SQL_DOOMED "2"

#endif
