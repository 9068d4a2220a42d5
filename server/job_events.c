/* SPDX-License-Identifier: MIT */
#include "job_events.h"
#include <pthread.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Enough that thousands of waiters seldom share a list. */
enum { WATCH_LISTS = 1024 };

const char job_events_queue[] = "queue";

struct watch_list {
    pthread_mutex_t lock;
    struct job_watch *first;
};

struct job_events {
    struct watch_list lists[WATCH_LISTS];
};

static struct watch_list *watch_list_of(struct job_events *events, const char *subject) {
    return &events->lists[id_hash(subject) % WATCH_LISTS];
}

struct job_events *job_events_new(void) {
    struct job_events *events = calloc(1, sizeof *events);
    if (!events)
        return NULL;
    for (int i = 0; i < WATCH_LISTS; i++)
        pthread_mutex_init(&events->lists[i].lock, NULL);
    return events;
}

void job_events_free(struct job_events *events) {
    if (!events)
        return;
    for (int i = 0; i < WATCH_LISTS; i++)
        pthread_mutex_destroy(&events->lists[i].lock);
    free(events);
}

void job_events_subscribe(struct job_events *events, struct job_watch *watch, const char *subject,
                          enum job_event least, void (*wake)(void *context), void *context) {
    *watch = (struct job_watch){.wake = wake, .context = context, .least = least};
    snprintf(watch->subject, sizeof watch->subject, "%s", subject);
    struct watch_list *list = watch_list_of(events, watch->subject);
    pthread_mutex_lock(&list->lock);
    watch->next = list->first;
    if (watch->next)
        watch->next->previous = watch;
    list->first = watch;
    pthread_mutex_unlock(&list->lock);
}

void job_events_unsubscribe(struct job_events *events, struct job_watch *watch) {
    struct watch_list *list = watch_list_of(events, watch->subject);
    pthread_mutex_lock(&list->lock);
    *(watch->previous ? &watch->previous->next : &list->first) = watch->next;
    if (watch->next)
        watch->next->previous = watch->previous;
    pthread_mutex_unlock(&list->lock);
}

void job_events_notify(struct job_events *events, const char *subject, enum job_event news) {
    struct watch_list *list = watch_list_of(events, subject);
    pthread_mutex_lock(&list->lock);
    for (struct job_watch *watch = list->first; watch; watch = watch->next)
        if (watch->least >= news && !strcmp(watch->subject, subject))
            watch->wake(watch->context);
    pthread_mutex_unlock(&list->lock);
}
