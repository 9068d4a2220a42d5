/* SPDX-License-Identifier: MIT */
#include "desk.h"
#include "client.h"
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>

struct desk {
    void (*attend)(struct exchange *exchange);
    atomic_int_fast64_t usual_us; /* of late; one that took longer counts at once */
    pthread_mutex_t lock;         /* of what is below */
    pthread_cond_t changed;
    struct exchange *first, **end; /* in the order of arrival */
    bool stopping;
    int threads;
    pthread_t thread[DESK_THREADS];
};

/* With the lock: the next one; NULL at the end. */
static struct exchange *next(struct desk *desk) {
    while (!desk->first && !desk->stopping)
        pthread_cond_wait(&desk->changed, &desk->lock);
    struct exchange *exchange = desk->first;
    if (!exchange)
        return NULL;
    desk->first = exchange->next;
    if (!desk->first)
        desk->end = &desk->first;
    exchange->next = NULL;
    return exchange;
}

static void *serve(void *context) {
    struct desk *desk = context;
    struct exchange *exchange;
    pthread_mutex_lock(&desk->lock);
    while ((exchange = next(desk))) {
        pthread_mutex_unlock(&desk->lock);
        desk->attend(exchange);
        pthread_mutex_lock(&desk->lock);
    }
    pthread_mutex_unlock(&desk->lock);
    return NULL;
}

struct desk *desk_start(void (*attend)(struct exchange *exchange)) {
    struct desk *desk = calloc(1, sizeof *desk);
    if (!desk)
        return NULL;
    desk->attend = attend;
    desk->end = &desk->first;
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

void desk_note(struct desk *desk, int64_t us) {
    int64_t usual = atomic_load_explicit(&desk->usual_us, memory_order_relaxed);
    usual -= usual / 8;
    atomic_store_explicit(&desk->usual_us, us > usual ? us : usual, memory_order_relaxed);
}

bool desk_needed(struct desk *desk) {
    return atomic_load_explicit(&desk->usual_us, memory_order_relaxed) > DESK_SLOW_US;
}

void desk_hand_over(struct desk *desk, struct exchange *exchange) {
    pthread_mutex_lock(&desk->lock);
    *desk->end = exchange;
    desk->end = &exchange->next;
    pthread_cond_signal(&desk->changed);
    pthread_mutex_unlock(&desk->lock);
}
