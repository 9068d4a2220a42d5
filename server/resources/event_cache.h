/* SPDX-License-Identifier: MIT */
/*
 * What the event streams of a process know of jobs, together: hundreds of streams may follow one
 * job, and are all woken by one change of it. The first to look reads the job from the store and
 * keeps the document in the cache; the others take it from there, unless they have been woken since
 * that read began.
 */
#ifndef SERVER_RESOURCES_EVENT_CACHE_H
#define SERVER_RESOURCES_EVENT_CACHE_H

#include "server/store/store.h"

/* The job as a read that began at `since` (`clock_us`) or later has found it: of `job` attempts,
 * status and progress are set, nothing else and nothing to be cleared; `document` is its status
 * document, malloc'ed, NULL without memory. Both mean something with STORE_OK only. Otherwise the
 * answer of the store. */
enum store_answer event_cache_look(struct store *store, const char *id, int64_t since,
                                   struct store_job *job, char **document);

#endif
