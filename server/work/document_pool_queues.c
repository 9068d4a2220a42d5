/* SPDX-License-Identifier: MIT */
#include "document_pool_parts.h"

#include "server/clock.h"
#include <string.h>

void lane_append(struct check **list, struct check *check) {
    while (*list)
        list = &(*list)->next;
    check->next = NULL;
    *list = check;
}

void lane_withdraw(struct check **list, const struct check *check) {
    while (*list && *list != check)
        list = &(*list)->next;
    if (*list)
        *list = check->next;
}

/* The checks of a list that are the owner's, in any lane when that is LANES. */
static int count(const struct check *list, const char *owner, enum check_lane lane) {
    int found = 0;
    for (; list; list = list->next)
        found += !strcmp(list->owner, owner) && (lane == LANES || list->lane == lane);
    return found;
}

bool lane_full(const struct document_pool *pool, const char *owner, enum check_lane lane) {
    return count(pool->waiting, owner, lane) >=
           (lane == LANE_SLOW ? DOCUMENT_POOL_SLOW_MAX : DOCUMENT_POOL_WAITING_MAX);
}

/* Whether the slow lane has a place for the owner. */
static bool slow_place(const struct document_pool *pool, const char *owner) {
    int most = pool->settings.slow;
    int share = most > 1 ? most - 1 : 1;
    return pool->stats.under_way[LANE_SLOW] < most &&
           count(pool->running, owner, LANE_SLOW) < share;
}

bool lane_takes_long(const struct document_pool *pool, const char *owner, int64_t now) {
    for (int k = 0; k < DOCUMENT_POOL_LONG_OWNERS; k++)
        if (pool->long_owners[k].until_ms > now && !strcmp(pool->long_owners[k].owner, owner))
            return true;
    return false;
}

void lane_note_long(struct document_pool *pool, const char *owner, int64_t now) {
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

bool lane_may_begin(const struct document_pool *pool, const struct check *check) {
    int kept = check->last && pool->settings.express > 1; /* for the others */
    if (!pool->idle || pool->stats.reserved + check->reserve > pool->settings.memory)
        return false;
    return check->lane == LANE_SLOW
               ? slow_place(pool, check->owner)
               : pool->stats.under_way[LANE_EXPRESS] < pool->settings.express - kept;
}

struct check *lane_choose(const struct document_pool *pool) {
    struct check *best = NULL;
    int least = 0;
    for (struct check *check = pool->waiting; check; check = check->next) {
        if (!lane_may_begin(pool, check))
            continue;
        int rank = count(pool->running, check->owner, LANES);
        if (check->lane == LANE_EXPRESS && check->last)
            rank += pool->value_count;
        if (best && rank >= least)
            continue;
        best = check;
        least = rank;
    }
    return best;
}

void lane_begin(struct document_pool *pool, struct check *check) {
    check->place = pool->idle;
    pool->idle = check->place->next;
    check->state = STATE_RUNNING;
    check->begun_ms = clock_ms();
    pool->stats.under_way[check->lane]++;
    pool->stats.reserved += check->reserve;
    lane_append(&pool->running, check);
}

/* A place, or bytes of the budget, have become free: most of the time nobody waits for them. */
static void wake_for_waiting(struct document_pool *pool) {
    if (pool->waiting)
        pthread_cond_broadcast(&pool->changed);
}

/* What waits of the owner comes behind all else that waits. */
static void put_last(struct document_pool *pool, const char *owner) {
    struct check *own = NULL, **end = &own, **at = &pool->waiting;
    while (*at) {
        struct check *check = *at;
        if (strcmp(check->owner, owner) != 0) {
            at = &check->next;
            continue;
        }
        *at = check->next;
        *end = check;
        end = &check->next;
    }
    *end = NULL;
    *at = own;
}

void lane_leave(struct document_pool *pool, struct check *check) {
    lane_withdraw(&pool->running, check);
    put_last(pool, check->owner);
    check->place->next = pool->idle;
    pool->idle = check->place;
    check->place = NULL;
    pool->stats.under_way[check->lane]--;
    pool->stats.reserved -= check->reserve;
    wake_for_waiting(pool);
}

/* Whether another owner waits for the slow lane, with nothing in it. */
static bool is_awaited(const struct document_pool *pool, const char *owner) {
    for (const struct check *check = pool->waiting; check; check = check->next)
        if (check->lane == LANE_SLOW && strcmp(check->owner, owner) != 0 &&
            count(pool->running, check->owner, LANE_SLOW) == 0)
            return true;
    return false;
}

bool lane_must_yield(struct document_pool *pool, struct check *check, int64_t now) {
    int64_t turn = pool->settings.turn_ms << (check->turns < 16 ? check->turns : 16);
    if (now < check->begun_ms + turn || now < pool->yielded_ms + DOCUMENT_POOL_YIELD_MS ||
        !is_awaited(pool, check->owner))
        return false;
    pool->yielded_ms = now;
    check->turns++;
    return true;
}

enum check_outcome lane_move_to_slow(struct document_pool *pool, struct check *check) {
    pthread_mutex_lock(&pool->lock);
    bool room = slow_place(pool, check->owner);
    bool full = lane_full(pool, check->owner, LANE_SLOW);
    lane_note_long(pool, check->owner, clock_ms());
    if (room) {
        pool->stats.under_way[LANE_EXPRESS]--;
        pool->stats.under_way[LANE_SLOW]++;
        check->lane = LANE_SLOW;
        wake_for_waiting(pool);
    }
    pthread_mutex_unlock(&pool->lock);
    return room ? OUTCOME_LATER : full ? OUTCOME_QUOTA : OUTCOME_AGAIN;
}
