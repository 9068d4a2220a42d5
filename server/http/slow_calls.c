/* SPDX-License-Identifier: MIT */
#include "slow_calls.h"
#include "client.h"
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

/* In the order of arrival. */
struct line {
    struct exchange *first, **end;
};

/* What a thread attends to. */
struct seat {
    bool taken, reads;
    char owner[sizeof((struct request *)NULL)->owner];
};

struct slow_calls {
    void (*attend)(struct exchange *exchange);
    atomic_int_fast64_t
        usual_us[SLOW_CALLS_KINDS]; /* of late; one that took longer counts at once */
    pthread_mutex_t lock;           /* of what is below */
    pthread_cond_t changed;
    struct line lines[SLOW_CALLS_KINDS];
    struct seat seats[SLOW_CALLS_THREADS];
    int seated; /* threads that have taken their seat */
    bool stopping;
    int threads;
    pthread_t thread[SLOW_CALLS_THREADS];
};

/* With the lock: the calls under way, of an owner or, with NULL, those that read. */
static int count_seats(const struct slow_calls *slow_calls, const char *owner) {
    int count = 0;
    for (const struct seat *seat = slow_calls->seats; seat < slow_calls->seats + SLOW_CALLS_THREADS;
         seat++)
        count += seat->taken && (owner ? !strcmp(seat->owner, owner) : seat->reads);
    return count;
}

/* With the lock: takes out of the line the first of the owner with the fewest under way; NULL when
 * it is empty. */
static struct exchange *take_next(const struct slow_calls *slow_calls, struct line *line) {
    struct exchange **best = NULL;
    int least = SLOW_CALLS_THREADS + 1;
    for (struct exchange **at = &line->first; *at && least > 0; at = &(*at)->next) {
        int count = count_seats(slow_calls, (*at)->request->owner);
        if (count >= least)
            continue;
        best = at;
        least = count;
    }
    if (!best)
        return NULL;
    struct exchange *exchange = *best;
    *best = exchange->next;
    if (!*best)
        line->end = best;
    exchange->next = NULL;
    return exchange;
}

/* A thread: attends to one call after the other, changes first. */
static void *serve_slow_calls(void *context) {
    struct slow_calls *slow_calls = context;
    struct line *lines = slow_calls->lines;
    pthread_mutex_lock(&slow_calls->lock);
    struct seat *seat = &slow_calls->seats[slow_calls->seated++];
    for (;;) {
        struct exchange *exchange = take_next(slow_calls, &lines[SLOW_CALLS_CHANGES]);
        seat->reads = !exchange;
        if (!exchange && count_seats(slow_calls, NULL) < SLOW_CALLS_READERS)
            exchange = take_next(slow_calls, &lines[SLOW_CALLS_READS]);
        if (!exchange && slow_calls->stopping && !lines[SLOW_CALLS_READS].first)
            break;
        if (!exchange) {
            pthread_cond_wait(&slow_calls->changed, &slow_calls->lock);
            continue;
        }
        seat->taken = true;
        memcpy(seat->owner, exchange->request->owner, sizeof seat->owner);
        pthread_mutex_unlock(&slow_calls->lock);
        slow_calls->attend(exchange);
        pthread_mutex_lock(&slow_calls->lock);
        seat->taken = false;
    }
    /* one that was the last to read kept others waiting */
    pthread_cond_broadcast(&slow_calls->changed);
    pthread_mutex_unlock(&slow_calls->lock);
    return NULL;
}

struct slow_calls *slow_calls_start(void (*attend)(struct exchange *exchange)) {
    struct slow_calls *slow_calls = calloc(1, sizeof *slow_calls);
    if (!slow_calls)
        return NULL;
    slow_calls->attend = attend;
    for (int kind = 0; kind < SLOW_CALLS_KINDS; kind++)
        slow_calls->lines[kind].end = &slow_calls->lines[kind].first;
    pthread_mutex_init(&slow_calls->lock, NULL);
    pthread_cond_init(&slow_calls->changed, NULL);
    while (slow_calls->threads < SLOW_CALLS_THREADS &&
           pthread_create(&slow_calls->thread[slow_calls->threads], NULL, serve_slow_calls,
                          slow_calls) == 0)
        slow_calls->threads++;
    if (slow_calls->threads == SLOW_CALLS_THREADS)
        return slow_calls;
    slow_calls_stop(slow_calls);
    slow_calls_free(slow_calls);
    return NULL;
}

void slow_calls_stop(struct slow_calls *slow_calls) {
    if (!slow_calls)
        return;
    pthread_mutex_lock(&slow_calls->lock);
    slow_calls->stopping = true;
    pthread_cond_broadcast(&slow_calls->changed);
    pthread_mutex_unlock(&slow_calls->lock);
    while (slow_calls->threads > 0)
        pthread_join(slow_calls->thread[--slow_calls->threads], NULL);
}

void slow_calls_free(struct slow_calls *slow_calls) {
    if (!slow_calls)
        return;
    pthread_cond_destroy(&slow_calls->changed);
    pthread_mutex_destroy(&slow_calls->lock);
    free(slow_calls);
}

void slow_calls_note(struct slow_calls *slow_calls, enum slow_calls_kind kind, int64_t us) {
    int64_t usual = atomic_load_explicit(&slow_calls->usual_us[kind], memory_order_relaxed);
    usual -= usual / 8;
    atomic_store_explicit(&slow_calls->usual_us[kind], us > usual ? us : usual,
                          memory_order_relaxed);
}

bool slow_calls_are_slow(struct slow_calls *slow_calls, enum slow_calls_kind kind) {
    return atomic_load_explicit(&slow_calls->usual_us[kind], memory_order_relaxed) >
           SLOW_CALLS_SLOW_US;
}

void slow_calls_hand_over(struct slow_calls *slow_calls, enum slow_calls_kind kind,
                          struct exchange *exchange) {
    struct line *line = &slow_calls->lines[kind];
    pthread_mutex_lock(&slow_calls->lock);
    *line->end = exchange;
    line->end = &exchange->next;
    pthread_cond_signal(&slow_calls->changed);
    pthread_mutex_unlock(&slow_calls->lock);
}
