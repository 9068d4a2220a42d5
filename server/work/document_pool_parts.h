/* SPDX-License-Identifier: MIT */
/*
 * The parts of the pool of checker processes, for its own files: a check, which is one order on its
 * way (document_pool_order.c); the place of a process (document_pool_place.c); and the lanes in
 * which checks wait and run (document_pool_lanes.c). What threads do with them is document_pool.c.
 */
#ifndef SERVER_WORK_DOCUMENT_POOL_PARTS_H
#define SERVER_WORK_DOCUMENT_POOL_PARTS_H

#include "child.h"
#include "document_pool.h"
#include <pthread.h>

enum { DOCUMENT_POOL_LONG_OWNERS = 32 }; /* of whom it is known that their orders take long */

enum check_state {
    STATE_WAITING,
    STATE_RUNNING,
    STATE_ADOPTED, /* its order is on the way; a thread of the pool is to follow it */
    STATE_DONE
};

enum check_lane { LANE_EXPRESS, LANE_SLOW, LANES };

/* A place for a process, and the bounds that it has now. */
struct check_place {
    struct child child;
    uint64_t base;  /* bytes of address space it starts with */
    uint64_t limit; /* the bytes it may have now; 0: not bounded yet */
    bool slow;      /* runs at the lower priority */
    bool imports;   /* its process is the importer */
    struct check_place *next;
};

struct check {
    struct document_pool *pool;
    struct document_pool_columns columns;
    char subject[ID_SIZE], owner[DOCUMENT_POOL_OWNER_SIZE];
    struct checker_order packet;
    char *inlined; /* the documents in the packet */
    size_t inlined_length;
    int files[CHECKER_DOCUMENTS + 1]; /* -1: none */
    int64_t reserve;                  /* bytes; grows to all that the slow lane has, once */
    size_t max_memory;                /* of the order's limits */
    struct checker_answer answer;
    bool crashed; /* its last process */

    struct check *next; /* under the lock, like what follows: in the list it is in */
    enum check_state state;
    enum check_lane lane;
    bool last; /* its owner's orders took long lately */
    struct check_place *place;
    int64_t begun_ms;
    int turns; /* it has had in the slow lane */
    bool dropped;
};

struct document_pool {
    struct job_events *events;
    struct document_pool_settings settings;
    int value_count;
    struct check_place *places;
    pthread_t *threads; /* one a place */
    int thread_count;

    pthread_mutex_t lock; /* what is below */
    pthread_cond_t changed;
    int places_ready;
    struct check_place *idle;
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
    OUTCOME_LATER, /* no answer yet */
    OUTCOME_ANSWER,
    OUTCOME_CRASHED,
    OUTCOME_TIMEOUT,
    OUTCOME_DROPPED,
    OUTCOME_NOT_BEGUN,
    OUTCOME_QUOTA,
    OUTCOME_AGAIN /* no place in the slow lane, or no longer: to be begun anew */
};

/* ---- an order ---- */

/* A check of the order, whose columns are then its own; not yet in any list. NULL, with the columns
 * still the caller's, without memory or room for the documents. */
struct check *check_new(struct document_pool *pool, const struct document_pool_order *order,
                        const char *subject);

void check_free(struct check *check);

/* Closes its files before `end`. */
void check_close(struct check *check, int end);

/* The most that one order may take: the budget without what is kept for the express lane. */
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

/* Too many of the owner's wait in the lane. */
void check_explain_quota(struct api_problem *problem, enum check_lane lane);

/* ---- a place ---- */

/* Starts the place's process if it has none, and waits for its word that it is locked in. */
bool place_start(struct document_pool *pool, struct check_place *place, bool imports);

/* Bounds its memory for the order, whose documents are mapped beside it; most orders have the same.
 */
void place_bound(struct check *check);

/* Gives the process the priority of the slow lane. */
void place_lower(struct check_place *place);

/* Ends the process; one that crashed is said in the log. */
void place_end(struct check_place *place, bool crashed);

/* ---- lanes, with the lock ---- */

/* Of the lists, `waiting` and `running`. */
void lane_append(struct check **list, struct check *check);
void lane_withdraw(struct check **list, const struct check *check);

/* Whether as many of the owner's wait as may, in the lane. */
bool lane_full(const struct document_pool *pool, const char *owner, enum check_lane lane);

/* Whether orders of the owner took long lately. */
bool lane_takes_long(const struct document_pool *pool, const char *owner, int64_t now);

/* An order of the owner has taken long in the express lane: its next ones come last there. */
void lane_note_long(struct document_pool *pool, const char *owner, int64_t now);

/* Whether the check may begin now, in the lane it is in. */
bool lane_may_begin(const struct document_pool *pool, const struct check *check);

/* The check that begins next: of those that may, the first of the owner with the fewest under way,
 * of whom nothing took long lately. NULL: none may. */
struct check *lane_choose(const struct document_pool *pool);

/* Gives the check, which is in no list, the first idle place. */
void lane_begin(struct document_pool *pool, struct check *check);

/* Gives back the place and its share of the budget; what else of its owner waits comes behind what
 * others wait with. */
void lane_leave(struct document_pool *pool, struct check *check);

/* Whether the check, in the slow lane, has had its turn there and another owner waits for one. */
bool lane_must_yield(struct document_pool *pool, struct check *check, int64_t now);

/* Without the lock. Moves the check, which takes too long for the express lane, to the slow one
 * with its process, if that has a place; if not, it has to begin anew there, unless too many of the
 * owner's wait. */
enum check_outcome lane_move_to_slow(struct document_pool *pool, struct check *check);

#endif
