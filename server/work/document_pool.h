/* SPDX-License-Identifier: MIT */
/*
 * The pool of checker processes (`checker.h`): what callers send is decoded, checked, shaped and
 * mapped there, under a deadline, a bound of memory and one budget for all, so that HTTP threads
 * only move bytes and no document can do more than fail.
 *
 * Two queues. Every order begins in the fast queue, whose processes are for those that take
 * DOCUMENT_POOL_FAST_MS at the most. One that takes longer moves to the slow queue with its
 * process, at a lower priority, and another process takes its place; when the slow queue has no
 * room left, it is stopped and begins anew there later. So a small drape never waits behind a large
 * one. Among those that wait the owner with the fewest orders under way comes first, of these the
 * one whose latest ended first, and no owner has all processes of the slow queue. An order that has
 * had a turn there (DOCUMENT_POOL_TURN_MS, and twice as long each time) gives way when another
 * owner waits with nothing in that queue: it is stopped and begins anew behind the others, one at a
 * time in DOCUMENT_POOL_YIELD_MS. An owner whose order has left the fast queue, or has taken more
 * than DOCUMENT_POOL_QUICK_MS of a processor there, comes last for DOCUMENT_POOL_LONG_MS, and such
 * owners together leave one of its processes to all others.
 *
 * What an order may take of the budget goes by its length. One that turns out to need more is begun
 * anew in the slow queue with all that this may have.
 *
 * An order that a free process answers at once is answered on the caller's own thread, within
 * DOCUMENT_POOL_AT_ONCE_MS; the threads of the pool take over the others.
 */
#ifndef SERVER_WORK_DOCUMENT_POOL_H
#define SERVER_WORK_DOCUMENT_POOL_H

#include "checker.h"
#include "server/job_events.h"
#include <sys/types.h>

enum {
    DOCUMENT_POOL_AT_ONCE_MS = 4,
    DOCUMENT_POOL_FAST_MS = 200,
    DOCUMENT_POOL_QUICK_MS = 30,
    DOCUMENT_POOL_LONG_MS = 10000,
    DOCUMENT_POOL_TURN_MS = 10000,
    DOCUMENT_POOL_YIELD_MS = 1000,
    DOCUMENT_POOL_PROCESSES_MAX = 8, /* of a queue; more than that waits for the store anyway */
    DOCUMENT_POOL_OWNER_SIZE = 65,
    DOCUMENT_POOL_WAITING_MAX =
        1024,                   /* orders of one owner that may wait; beyond it they are refused */
    DOCUMENT_POOL_SLOW_MAX = 32 /* of them, in the slow queue */
};

/* The importer of CAD files, beside the daemon's own program. */
#define DOCUMENT_POOL_IMPORTER "drape-import"

struct document_pool;
struct check;

struct document_pool_settings {
    int fast, slow;     /* processes of each queue, >= 1 */
    int64_t memory;     /* bytes for all orders under way together: the budget */
    int64_t timeout_ms; /* of an order, waiting not counted */
    int64_t map_timeout_ms, import_timeout_ms; /* the same of maps and of CAD files */
    int64_t turn_ms;                           /* DOCUMENT_POOL_TURN_MS, but in tests */
    int64_t max_output;                        /* bytes */
    const char *folder;      /* where long outputs are kept while they are sent; "": in memory */
    const char *memory_flag; /* the one that sets `memory`, for messages */
};

/* The container of a job's result, written to a file by a thread of the
 * pool. The context belongs to the check as soon as that is begun. */
struct document_pool_columns {
    bool (*write)(void *context, int file); /* NULL: none are needed */
    void (*free)(void *context);
    void *context;
    size_t length;
};

/* What is to be checked. The documents are copied, the body's file is not. */
struct document_pool_order {
    enum checker_kind kind;
    const char *owner; /* who has few or many orders under way */
    struct api_limits limits;
    const char *document[CHECKER_DOCUMENTS]; /* NULL: none */
    size_t length[CHECKER_DOCUMENTS];
    int body_file;                 /* the sealed memory file with the body; -1: none */
    int form_file;                 /* that with the prepared form, where that has a length */
    const struct api_start *start; /* or NULL */
    const char *source, *unit;     /* of a surface that is a file: its format, and the unit of one
                                      that says none; NULL: neither */
    struct document_pool_columns columns; /* of a map, a variant or a report */
    size_t variant;
    const char *mesh;        /* of a map: the format of its mesh; NULL: JSON */
    const char *id, *format; /* of a map, sample or report */
};

/* For /metrics. */
struct document_pool_stats {
    int64_t under_way[2]; /* in the fast and the slow queue */
    int64_t waiting;
    int64_t reserved; /* bytes of the budget */
    int64_t done, timeouts;
    int64_t crashes;  /* checks that crashed two processes */
    int64_t restarts; /* begun anew, for the slow queue, after a turn there or after a crash */
};

/* Starts processes and threads. NULL when they cannot be had. */
struct document_pool *document_pool_start(struct job_events *events,
                                          const struct document_pool_settings *settings);

/* Whether the importer is there. */
bool document_pool_can_import(void);

/* Ends what is under way. No check may be left. NULL is allowed. */
void document_pool_stop(struct document_pool *document_pool);

void document_pool_stats(struct document_pool *document_pool, struct document_pool_stats *stats);

/* Begins a check, and ends it when it is quick. `subject` is notified when a check that was
 * not done yet is. NULL with the problem set: API_TOO_LARGE (more than the whole budget),
 * API_QUOTA (too many of this owner wait), API_UNAVAILABLE. */
struct check *document_pool_begin(struct document_pool *document_pool,
                                  const struct document_pool_order *order, const char *subject,
                                  struct api_problem *problem);

bool check_done(struct check *check);

/* Of a check that is done; lives as long as it. */
const struct checker_answer *check_answer(const struct check *check);

/* Of a check that is done: the sealed memory file with the prepared form that it has made, which
 * the caller closes, and its length; -1: it has made none. */
int check_form(const struct check *check, size_t *length);

/* The bytes from `offset` on of what a check that is done has written, at most `size`: how many; 0
 * at the end; -1 when they cannot be read. */
ssize_t check_read(struct check *check, uint64_t offset, char *buffer, size_t size);

/* Ends it if it is under way. NULL is allowed. */
void check_drop(struct check *check);

#endif
