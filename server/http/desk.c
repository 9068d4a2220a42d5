/* SPDX-License-Identifier: MIT */
#include "desk.h"
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

struct desk {
    void (*attend)(struct exchange *exchange);
    atomic_int_fast64_t usual_us[DESK_KINDS]; /* of late; one that took longer counts at once */
    pthread_mutex_t lock;                     /* of what is below */
    pthread_cond_t changed;
    struct line lines[DESK_KINDS];
    struct seat seats[DESK_THREADS];
    int seated; /* threads that have taken their seat */
    bool stopping;
    int threads;
    pthread_t thread[DESK_THREADS];
};

static int readers(const struct desk *desk) {
    int count = 0;
    for (int k = 0; k < DESK_THREADS; k++)
        count += desk->seats[k].taken && desk->seats[k].reads;
    return count;
}

static int under_way(const struct desk *desk, const char *owner) {
    int count = 0;
    for (int k = 0; k < DESK_THREADS; k++)
        count += desk->seats[k].taken && !strcmp(desk->seats[k].owner, owner);
    return count;
}

/* With the lock: takes out of the line the first of the owner with the fewest under way; NULL when
 * it is empty. */
static struct exchange *take_next(const struct desk *desk, struct line *line) {
    struct exchange **best = NULL;
    int least = DESK_THREADS + 1;
    for (struct exchange **at = &line->first; *at && least > 0; at = &(*at)->next) {
        int count = under_way(desk, (*at)->request->owner);
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

/* With the lock: the next one, for that seat; NULL at the end. */
static struct exchange *next(struct desk *desk, struct seat *seat) {
    for (;;) {
        struct exchange *exchange = take_next(desk, &desk->lines[DESK_CHANGES]);
        seat->reads = !exchange;
        if (!exchange && readers(desk) < DESK_READERS)
            exchange = take_next(desk, &desk->lines[DESK_READS]);
        seat->taken = exchange != NULL;
        if (exchange)
            memcpy(seat->owner, exchange->request->owner, sizeof seat->owner);
        if (exchange || (desk->stopping && !desk->lines[DESK_READS].first))
            return exchange;
        pthread_cond_wait(&desk->changed, &desk->lock);
    }
}

static void *serve(void *context) {
    struct desk *desk = context;
    struct exchange *exchange;
    pthread_mutex_lock(&desk->lock);
    struct seat *seat = &desk->seats[desk->seated++];
    while ((exchange = next(desk, seat))) {
        pthread_mutex_unlock(&desk->lock);
        desk->attend(exchange);
        pthread_mutex_lock(&desk->lock);
        seat->taken = false;
    }
    pthread_cond_broadcast(&desk->changed); /* one that was the last to read kept others waiting */
    pthread_mutex_unlock(&desk->lock);
    return NULL;
}

struct desk *desk_start(void (*attend)(struct exchange *exchange)) {
    struct desk *desk = calloc(1, sizeof *desk);
    if (!desk)
        return NULL;
    desk->attend = attend;
    for (int kind = 0; kind < DESK_KINDS; kind++)
        desk->lines[kind].end = &desk->lines[kind].first;
    pthread_mutex_init(&desk->lock, NULL);
    pthread_cond_init(&desk->changed, NULL);
    while (desk->threads < DESK_THREADS &&
           pthread_create(&desk->thread[desk->threads], NULL, serve, desk) == 0)
        desk->threads++;
    if (desk->threads == DESK_THREADS)
        return desk;
    desk_stop(desk);
    desk_free(desk);
    return NULL;
}

void desk_stop(struct desk *desk) {
    if (!desk)
        return;
    pthread_mutex_lock(&desk->lock);
    desk->stopping = true;
    pthread_cond_broadcast(&desk->changed);
    pthread_mutex_unlock(&desk->lock);
    while (desk->threads > 0)
        pthread_join(desk->thread[--desk->threads], NULL);
}

void desk_free(struct desk *desk) {
    if (!desk)
        return;
    pthread_cond_destroy(&desk->changed);
    pthread_mutex_destroy(&desk->lock);
    free(desk);
}

void desk_note(struct desk *desk, enum desk_kind kind, int64_t us) {
    int64_t usual = atomic_load_explicit(&desk->usual_us[kind], memory_order_relaxed);
    usual -= usual / 8;
    atomic_store_explicit(&desk->usual_us[kind], us > usual ? us : usual, memory_order_relaxed);
}

bool desk_needed(struct desk *desk, enum desk_kind kind) {
    return atomic_load_explicit(&desk->usual_us[kind], memory_order_relaxed) > DESK_SLOW_US;
}

void desk_hand_over(struct desk *desk, enum desk_kind kind, struct exchange *exchange) {
    struct line *line = &desk->lines[kind];
    pthread_mutex_lock(&desk->lock);
    *line->end = exchange;
    line->end = &exchange->next;
    pthread_cond_signal(&desk->changed);
    pthread_mutex_unlock(&desk->lock);
}
