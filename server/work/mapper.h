/* SPDX-License-Identifier: MIT */
/*
 * Makes maps away from the threads that serve HTTP: a map of a million elements takes seconds, and
 * other callers must not wait for it. Two threads work; what they hold is bounded by the number of
 * maps that there may be, waiting, being made or being sent, and by the memory of each. When one is
 * done its subject is notified through the hub.
 */
#ifndef SERVER_WORK_MAPPER_H
#define SERVER_WORK_MAPPER_H

#include "api/format/format.h"
#include "server/hub.h"
#include "server/store/store.h"

enum { MAPPER_THREADS = 2, MAPPER_MAPS_MAX = 16 };

struct mapper;
struct map_task;

struct mapper_settings {
    size_t memory;      /* bytes of one map */
    int64_t timeout_ms; /* for which one may be made */
};

/* What a map is made of. Strings are copied. */
struct mapper_order {
    struct store_result result; /* of the drape */
    const char *id;
    const struct format *format;
    struct format_options options;
    bool nastran;      /* whether the body is bulk data; else JSON */
    const char *inlet; /* elements of the inlet beside the body, or NULL */
};

/* NULL without threads or memory. The store and the hub are borrowed and must outlive it. */
struct mapper *mapper_start(struct store *store, struct hub *hub,
                            const struct mapper_settings *settings);

/* Gives up what is being made and frees it; all tasks must have been dropped. NULL is allowed. */
void mapper_stop(struct mapper *mapper);

/* Begins a map of the `length` bytes at `*body`, which are taken over (and `*body` set NULL) unless
 * the answer is NULL: there are too many maps, or no memory. `subject` is notified once
 * `mapper_done`. The caller drops the task. */
struct map_task *mapper_begin(struct mapper *mapper, const struct mapper_order *order, char **body,
                              size_t length, const char *subject);

bool mapper_done(struct map_task *task);

const struct format *mapper_format(const struct map_task *task);

/* Of a task that is done: its encoder, which lives as long as the task; NULL with the problem. */
struct encoder *mapper_result(struct map_task *task, struct api_problem *problem);

/* Frees the task; one that is being made is given up soon. */
void mapper_drop(struct map_task *task);

#endif
