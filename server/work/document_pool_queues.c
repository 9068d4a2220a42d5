/* SPDX-License-Identifier: MIT */
#include "document_pool_internal.h"

#include "server/clock.h"
#include <string.h>

void queue_append(struct check **list, struct check *check) {
    while (*list)
        list = &(*list)->next;
    check->next = NULL;
    *list = check;
}

void queue_withdraw(struct check **list, const struct check *check) {
    while (*list && *list != check)
        list = &(*list)->next;
    if (*list)
        *list = check->next;
}

/* The checks of a list that are the owner's, in any queue when that is QUEUES. */
static int count_checks(const struct check *list, const char *owner, enum check_queue queue) {
    int found = 0;
    for (; list; list = list->next)
        found += !strcmp(list->owner, owner) && (queue == QUEUES || list->queue == queue);
    return found;
}

bool queue_full(const struct document_pool *pool, const char *owner, enum check_queue queue) {
    return count_checks(pool->waiting, owner, queue) >=
           (queue == QUEUE_SLOW ? DOCUMENT_POOL_SLOW_MAX : DOCUMENT_POOL_WAITING_MAX);
}

/* Whether the slow queue has room for a check of the owner. */
static bool slow_has_room(const struct document_pool *pool, const char *owner) {
    int most = pool->settings.slow;
    int share = most > 1 ? most - 1 : 1;
    return pool->stats.under_way[QUEUE_SLOW] < most &&
           count_checks(pool->running, owner, QUEUE_SLOW) < share;
}

bool queue_takes_long(const struct document_pool *pool, const char *owner, int64_t now) {
    for (int k = 0; k < DOCUMENT_POOL_LONG_OWNERS; k++)
        if (pool->long_owners[k].until_ms > now && !strcmp(pool->long_owners[k].owner, owner))
            return true;
    return false;
}

void queue_note_long(struct document_pool *pool, const char *owner, int64_t now) {
    int at = 0;
    for (int k = 0; k < DOCUMENT_POOL_LONG_OWNERS; k++) {
        if (!strcmp(pool->long_owners[k].owner, owner)) {
            at = k;
            break;
        }
        if (pool->long_owners[k].until_ms < pool->long_owners[at].until_ms)
            at = k;
    }
    memcpy(pool->long_owners[at].owner, owner, DOCUMENT_POOL_OWNER_SIZE);
    pool->long_owners[at].until_ms = now + DOCUMENT_POOL_LONG_MS;
    for (struct check *check = pool->waiting; check; check = check->next)
        check->last = check->last || !strcmp(check->owner, owner);
}

bool queue_may_begin(const struct document_pool *pool, const struct check *check) {
    int kept = check->last && pool->settings.fast > 1; /* for the others */
    if (!pool->idle || pool->stats.reserved + check->reserve > pool->settings.memory)
        return false;
    return check->queue == QUEUE_SLOW
               ? slow_has_room(pool, check->owner)
               : pool->stats.under_way[QUEUE_FAST] < pool->settings.fast - kept;
}

struct check *queue_choose(const struct document_pool *pool) {
    struct check *best = NULL;
    int least = 0;
    for (struct check *check = pool->waiting; check; check = check->next) {
        if (!queue_may_begin(pool, check))
            continue;
        int rank = count_checks(pool->running, check->owner, QUEUES);
        if (check->queue == QUEUE_FAST && check->last)
            rank += pool->process_count;
        if (best && rank >= least)
            continue;
        best = check;
        least = rank;
    }
    return best;
}

void queue_begin(struct document_pool *pool, struct check *check) {
    check->process = pool->idle;
    pool->idle = check->process->next;
    check->state = CHECK_RUNNING;
    check->begun_ms = clock_ms();
    pool->stats.under_way[check->queue]++;
    pool->stats.reserved += check->reserve;
    queue_append(&pool->running, check);
}

/* A process, or bytes of the budget, have become free: most of the time nobody waits for them. */
static void wake_for_waiting(struct document_pool *pool) {
    if (pool->waiting)
        pthread_cond_broadcast(&pool->changed);
}

void queue_leave(struct document_pool *pool, struct check *check) {
    struct check *own = NULL, **end = &own, **at = &pool->waiting;
    queue_withdraw(&pool->running, check);
    while (*at) { /* what waits of the owner comes behind all else that waits */
        struct check *waits = *at;
        if (strcmp(waits->owner, check->owner) != 0) {
            at = &waits->next;
            continue;
        }
        *at = waits->next;
        *end = waits;
        end = &waits->next;
    }
    *end = NULL;
    *at = own;
    check->process->next = pool->idle;
    pool->idle = check->process;
    check->process = NULL;
    pool->stats.under_way[check->queue]--;
    pool->stats.reserved -= check->reserve;
    wake_for_waiting(pool);
}

bool queue_must_yield(struct document_pool *pool, struct check *check, int64_t now) {
    int64_t turn = pool->settings.turn_ms << (check->turns < 16 ? check->turns : 16);
    bool awaited = false; /* by another owner with nothing in the slow queue */
    if (now < check->begun_ms + turn || now < pool->yielded_ms + DOCUMENT_POOL_YIELD_MS)
        return false;
    for (const struct check *other = pool->waiting; other && !awaited; other = other->next)
        awaited = other->queue == QUEUE_SLOW && strcmp(other->owner, check->owner) != 0 &&
                  count_checks(pool->running, other->owner, QUEUE_SLOW) == 0;
    if (!awaited)
        return false;
    pool->yielded_ms = now;
    check->turns++;
    return true;
}

enum check_outcome queue_move_to_slow(struct document_pool *pool, struct check *check) {
    pthread_mutex_lock(&pool->lock);
    bool room = slow_has_room(pool, check->owner);
    bool full = queue_full(pool, check->owner, QUEUE_SLOW);
    queue_note_long(pool, check->owner, clock_ms());
    if (room) {
        pool->stats.under_way[QUEUE_FAST]--;
        pool->stats.under_way[QUEUE_SLOW]++;
        check->queue = QUEUE_SLOW;
        wake_for_waiting(pool);
    }
    pthread_mutex_unlock(&pool->lock);
    return room ? CHECK_LATER : full ? CHECK_QUOTA : CHECK_AGAIN;
}
