/* SPDX-License-Identifier: MIT */
/*
 * Shared by the files of the pool of checker processes: a check is one order on its way
 * (document_pool_order.c). The queues in which checks wait and run, and what threads and processes
 * do with them, is document_pool.c.
 */
#ifndef SERVER_WORK_DOCUMENT_POOL_INTERNAL_H
#define SERVER_WORK_DOCUMENT_POOL_INTERNAL_H

#include "child.h"
#include "document_pool.h"
#include <pthread.h>

enum { DOCUMENT_POOL_LONG_OWNERS = 32 }; /* of whom it is known that their orders take long */

enum check_state {
    CHECK_WAITING,
    CHECK_RUNNING,
    CHECK_ADOPTED, /* its order is on the way; a thread of the pool is to follow it */
    CHECK_DONE
};

enum check_queue { QUEUE_FAST, QUEUE_SLOW, QUEUES };

/* A process, or room for one, and the bounds that it has now. */
struct checker_process {
    struct child child;
    uint64_t base;  /* bytes of address space it starts with */
    uint64_t limit; /* the bytes it may have now; 0: not bounded yet */
    bool slow;      /* runs at the lower priority */
    bool imports;   /* its process is the importer */
    struct checker_process *next;
};

struct check {
    struct document_pool *pool;
    struct document_pool_columns columns;
    char subject[ID_SIZE], owner[DOCUMENT_POOL_OWNER_SIZE];
    struct checker_order packet;
    char *inlined; /* the documents in the packet */
    size_t inlined_length;
    int files[CHECKER_FILES]; /* -1: none */
    int64_t reserve;          /* bytes; grows to all that the slow queue has, once */
    size_t max_memory;        /* of the order's limits */
    struct checker_answer answer;
    bool crashed; /* its last process */

    struct check *next; /* under the lock, like what follows: in the list it is in */
    enum check_state state;
    enum check_queue queue;
    bool last; /* its owner's orders took long lately */
    struct checker_process *process;
    int64_t begun_ms;
    int turns; /* it has had in the slow queue */
    bool dropped;
};

struct document_pool {
    struct job_events *events;
    struct document_pool_settings settings;
    int process_count;
    struct checker_process *processes;
    pthread_t *threads; /* one a process */
    int thread_count;

    pthread_mutex_t lock; /* what is below */
    pthread_cond_t changed;
    int processes_ready;
    struct checker_process *idle;
    struct check *waiting, *running; /* lists; of `waiting` the first comes next, all else equal */
    int64_t yielded_ms;              /* when an order gave way last */
    struct {
        char owner[DOCUMENT_POOL_OWNER_SIZE];
        int64_t until_ms;
    } long_owners[DOCUMENT_POOL_LONG_OWNERS];
    struct document_pool_stats stats;
    bool stopping;
};

/* How a look at a check ended. */
enum check_outcome {
    CHECK_LATER, /* no answer yet */
    CHECK_ANSWER,
    CHECK_CRASHED,
    CHECK_TIMEOUT,
    CHECK_DROPPED,
    CHECK_NOT_BEGUN,
    CHECK_QUOTA,
    CHECK_AGAIN /* the slow queue has no room for it, or no longer: it has to begin anew */
};

/* ---- an order ---- */

/* A check of the order, whose columns are then its own; not yet in any list. NULL, with the columns
 * still the caller's, without memory or room for the documents. */
struct check *check_new(struct document_pool *pool, const struct document_pool_order *order,
                        const char *subject);

void check_free(struct check *check);

/* Closes its files from `begin` to before `end`. */
void check_close(struct check *check, int begin, int end);

/* The most that one order may take: the budget without what is kept for the fast queue. */
int64_t check_most(const struct document_pool *pool);

/* How long it may take, ms. */
int64_t check_timeout(const struct check *check);

/* Whether the check takes the importer. */
bool check_imports(const struct check *check);

/* Makes what the process reads and writes besides the documents, unless it is there. */
bool check_files(struct check *check);

/* False when the process is gone, or its socket does not take the packet. */
bool check_send(struct check *check);

/* Waits at most `ms` for the answer. */
enum check_outcome check_receive(struct check *check, int64_t ms);

/* What the caller is answered when there is no answer of the process, or one in words that are for
 * a drape. */
void check_explain(struct check *check, enum check_outcome outcome);

/* Too many of the owner's wait in the queue. */
void check_explain_quota(struct api_problem *problem, enum check_queue queue);

#endif
