/* SPDX-License-Identifier: MIT */
#include "desk.h"
#include "client.h"
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>

/* In the order of arrival. */
struct line {
    struct exchange *first, **end;
};

struct desk {
    void (*attend)(struct exchange *exchange);
    atomic_int_fast64_t usual_us[DESK_KINDS]; /* of late; one that took longer counts at once */
    pthread_mutex_t lock;                     /* of what is below */
    pthread_cond_t changed;
    struct line lines[DESK_KINDS];
    int readers; /* threads with one of DESK_READS */
    bool stopping;
    int threads;
    pthread_t thread[DESK_THREADS];
};

/* With the lock: takes the first of the line; NULL when it is empty. */
static struct exchange *take_first(struct line *line) {
    struct exchange *exchange = line->first;
    if (!exchange)
        return NULL;
    line->first = exchange->next;
    if (!line->first)
        line->end = &line->first;
    exchange->next = NULL;
    return exchange;
}

/* With the lock: the next one and its kind; NULL at the end. */
static struct exchange *next(struct desk *desk, enum desk_kind *kind) {
    for (;;) {
        struct exchange *exchange = take_first(&desk->lines[ *kind = DESK_CHANGES]);
        if (!exchange && desk->readers < DESK_READERS)
            exchange = take_first(&desk->lines[ *kind = DESK_READS]);
        if (exchange || (desk->stopping && !desk->lines[DESK_READS].first))
            return exchange;
        pthread_cond_wait(&desk->changed, &desk->lock);
    }
}

/* One that has read may have kept another from it. */
static void *serve(void *context) {
    struct desk *desk = context;
    struct exchange *exchange;
    enum desk_kind kind;
    pthread_mutex_lock(&desk->lock);
    while ((exchange = next(desk, &kind))) {
        desk->readers += kind == DESK_READS;
        pthread_mutex_unlock(&desk->lock);
        desk->attend(exchange);
        pthread_mutex_lock(&desk->lock);
        desk->readers -= kind == DESK_READS;
    }
    pthread_cond_broadcast(&desk->changed);
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
