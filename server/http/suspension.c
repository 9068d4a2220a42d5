/* SPDX-License-Identifier: MIT */
#include "client.h"
#include "server/clock.h"
#include <microhttpd.h>
#include <poll.h>
#include <string.h>

enum {
    TICK_MS = 10,  /* the timer looks no more often than this */
    SEEN_MS = 100, /* what is no older is good enough for one who just looks now and then */
    REAP_MS = 1000 /* and this often for clients that are slow or gone */
};

/* With the lock. */
static void resume_exchange(struct exchange *exchange) {
    struct http *http = exchange->http;
    exchange->suspended = false;
    *(exchange->previous ? &exchange->previous->next : &http->suspended) = exchange->next;
    if (exchange->next)
        exchange->next->previous = exchange->previous;
    exchange->next = exchange->previous = NULL;
    MHD_resume_connection(exchange->connection);
}

/* Called by the job events: the subject has changed. */
static void wake_exchange(void *context) {
    struct exchange *exchange = context;
    pthread_mutex_lock(&exchange->http->lock);
    exchange->notified = true;
    exchange->woken_us = clock_us();
    if (exchange->suspended)
        resume_exchange(exchange);
    pthread_mutex_unlock(&exchange->http->lock);
}

void http_watch(struct request *request, const char *subject, enum job_event least) {
    struct exchange *exchange = request->transport;
    struct job_events *events = exchange->http->settings.events;
    if (exchange->watching && !strcmp(exchange->watch.subject, subject))
        return;
    if (exchange->watching)
        job_events_unsubscribe(events, &exchange->watch);
    exchange->watching = true;
    job_events_subscribe(events, &exchange->watch, subject, least, wake_exchange, exchange);
    pthread_mutex_lock(&exchange->http->lock);
    request->woken_us = exchange->woken_us = clock_us();
    pthread_mutex_unlock(&exchange->http->lock);
}

bool suspension_begin(struct exchange *exchange) {
    struct http *http = exchange->http;
    pthread_mutex_lock(&http->lock);
    bool wait = !exchange->notified && !http->stopping;
    exchange->notified = false;
    if (wait) {
        exchange->suspended = true;
        exchange->next = http->suspended;
        if (exchange->next)
            exchange->next->previous = exchange;
        http->suspended = exchange;
        if (!exchange->away)
            MHD_suspend_connection(exchange->connection);
        exchange->away = false;
        if (exchange->request->wake_at < http->wake_at)
            pthread_cond_signal(&http->changed);
    }
    pthread_mutex_unlock(&http->lock);
    return wait;
}

bool suspension_hand_over(struct exchange *exchange, enum slow_calls_kind kind) {
    struct http *http = exchange->http;
    pthread_mutex_lock(&http->lock);
    bool open = !http->stopping;
    if (open) {
        exchange->away = true;
        MHD_suspend_connection(exchange->connection);
        slow_calls_hand_over(http->slow_calls, kind, exchange);
    }
    pthread_mutex_unlock(&http->lock);
    return open;
}

void suspension_return(struct exchange *exchange) {
    struct http *http = exchange->http;
    pthread_mutex_lock(&http->lock);
    exchange->away = false;
    MHD_resume_connection(exchange->connection);
    pthread_mutex_unlock(&http->lock);
}

bool suspension_refresh(struct exchange *exchange) {
    struct http *http = exchange->http;
    pthread_mutex_lock(&http->lock);
    exchange->notified = false;
    exchange->request->stopping = http->stopping;
    exchange->request->woken_us = exchange->woken_us;
    bool gone = exchange->gone;
    pthread_mutex_unlock(&http->lock);
    exchange->request->draining = atomic_load(&http->draining);
    return !gone;
}

/* With the lock: resumes those whose time has come (all of them at the end); sets when to look
 * next. Nothing is known to have changed, so that what others saw just now will do for them. */
static void resume_due(struct http *http, int64_t now) {
    const int64_t since = (now - SEEN_MS) * 1000;
    http->wake_at = INT64_MAX;
    for (struct exchange *exchange = http->suspended, *next; exchange; exchange = next) {
        next = exchange->next;
        int64_t due = exchange->request->wake_at;
        if (due <= now || http->stopping) {
            if (exchange->woken_us < since)
                exchange->woken_us = since;
            resume_exchange(exchange);
        } else if (due < http->wake_at) {
            http->wake_at = due;
        }
    }
    if (http->wake_at < now + TICK_MS)
        http->wake_at = now + TICK_MS;
}

static void *run_timer(void *context) {
    struct http *http = context;
    int64_t reap_at = 0;
    pthread_mutex_lock(&http->lock);
    while (!http->stopping) {
        int64_t now = clock_ms();
        if (now >= reap_at) {
            deadlines_reap(http->deadlines, now);
            /* Those whose client has closed its side of the connection are resumed, so that their
             * connections end. Most that do are gone, and the rest cannot be told apart: as with
             * nginx, a client that wants the answer must leave its side open. The library does not
             * look at the socket of one that is suspended. */
            for (struct exchange *one = http->suspended, *next; one; one = next) {
                struct pollfd side = {one->client->deadline.socket, POLLRDHUP, 0};
                next = one->next;
                one->gone = poll(&side, 1, 0) == 1;
                if (one->gone)
                    resume_exchange(one);
            }
            reap_at = now + REAP_MS;
        }
        resume_due(http, now);
        if (http->wake_at > reap_at)
            http->wake_at = reap_at;
        struct timespec until = {http->wake_at / 1000, http->wake_at % 1000 * 1000000};
        pthread_cond_timedwait(&http->changed, &http->lock, &until);
    }
    resume_due(http, clock_ms());
    pthread_mutex_unlock(&http->lock);
    return NULL;
}

bool suspension_start(struct http *http) {
    pthread_condattr_t monotonic;
    pthread_condattr_init(&monotonic);
    pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC);
    pthread_mutex_init(&http->lock, NULL);
    pthread_cond_init(&http->changed, &monotonic);
    pthread_condattr_destroy(&monotonic);
    http->ticking = pthread_create(&http->timer, NULL, run_timer, http) == 0;
    return http->ticking;
}

void suspension_stop(struct http *http) {
    if (!http->ticking)
        return;
    pthread_mutex_lock(&http->lock);
    http->stopping = true;
    pthread_cond_signal(&http->changed);
    pthread_mutex_unlock(&http->lock);
    pthread_join(http->timer, NULL);
}
