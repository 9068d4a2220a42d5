/* SPDX-License-Identifier: MIT */
/*
 * The JSON documents about jobs, as in the contract. Every function returns a malloc'ed string that
 * the caller frees (`reply_text` takes it over), or NULL without memory.
 */
#ifndef SERVER_RESOURCES_DOCUMENTS_H
#define SERVER_RESOURCES_DOCUMENTS_H

#include "api/problem.h"
#include "server/store/store.h"

/* The status document, in one line; of a laminate with its member `plies` (JSON), or NULL. */
char *documents_status(const struct store_job *job, const char *plies);

/* What jobs of a kind are together, in paths and lists: "drapes", "studies", "laminates". */
const char *documents_collection(enum store_kind kind);

/* {"drapes": [...], "next": cursor or null}; or of another kind. */
char *documents_list(enum store_kind kind, const struct store_page *page);

/* {"COLLECTION": [...], "next": cursor or null}; the elements of `first`, "" or more, come before
 * those of the page. */
char *documents_items(const char *collection, const char *first, const struct store_items *page);

/* The problem of a failed job (`job->error`) with the request's id, and its HTTP status. */
char *documents_job_problem(const struct store_job *job, const char *request_id, int *status);

/* RFC 3339 in UTC of microseconds since 1970. */
enum { DOCUMENTS_TIME_SIZE = 28 };
void documents_time(char date[DOCUMENTS_TIME_SIZE], int64_t us);

/* How long a job waited in the queue, in milliseconds. */
double documents_queue_ms(const struct store_job *job);

#endif
