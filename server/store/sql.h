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

/* A job that waits for its own: nobody's, and reported as running. */
#define SQL_WAITING "-1"

/* jobs.kind is enum store_kind. */
#define SQL_DRAPE "0"
#define SQL_STUDY "1"
#define SQL_TASK "2"
#define SQL_LAMINATE "3"

_Static_assert(STORE_DRAPE == 0 && STORE_STUDY == 1 && STORE_TASK == 2 && STORE_LAMINATE == 3,
               "as in the words above");

/* jobs.rank of studies and their tasks is so much larger, later than any time: they come after the
 * other jobs of their owner. */
#define SQL_BACKGROUND "1152921504606846976"

/* The status that is reported: what has begun a round is running until it ends. `j` is the job. */
#define SQL_SHOWN "CASE WHEN j.status < 1 AND j.round > 0 THEN 1 ELSE j.status END"

_Static_assert(STORE_QUEUED == 0 && STORE_RUNNING == 1 && STORE_SUCCEEDED == 2 &&
                   STORE_FAILED == 3 && STORE_CANCELLED == 4,
               "as in the words above");

/* results.state: being written under a claim; whole, and named by jobs; to be deleted step by step.
 */
#define SQL_BUILDING "0"
#define SQL_COMPLETE "1"
#define SQL_DOOMED "2"

#endif
