/* SPDX-License-Identifier: MIT */
#include "hub.h"
#include <pthread.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Enough that thousands of waiters seldom share a list. */
enum { HUB_BUCKETS = 1024 };

const char hub_queue[] = "queue";

struct bucket {
    pthread_mutex_t lock;
    struct hub_watch *first;
};

struct hub {
    struct bucket buckets[HUB_BUCKETS];
};

/* FNV-1a. */
static struct bucket *bucket_of(struct hub *hub, const char *subject) {
    uint32_t hash = 2166136261U;
    for (const char *c = subject; *c; c++)
        hash = (hash ^ (unsigned char)*c) * 16777619U;
    return &hub->buckets[hash % HUB_BUCKETS];
}

struct hub *hub_new(void) {
    struct hub *hub = calloc(1, sizeof *hub);
    if (!hub)
        return NULL;
    for (int i = 0; i < HUB_BUCKETS; i++)
        pthread_mutex_init(&hub->buckets[i].lock, NULL);
    return hub;
}

void hub_free(struct hub *hub) {
    if (!hub)
        return;
    for (int i = 0; i < HUB_BUCKETS; i++)
        pthread_mutex_destroy(&hub->buckets[i].lock);
    free(hub);
}

void hub_subscribe(struct hub *hub, struct hub_watch *watch, const char *subject,
                   enum hub_news least, void (*wake)(void *context), void *context) {
    *watch = (struct hub_watch){.wake = wake, .context = context, .least = least};
    snprintf(watch->subject, sizeof watch->subject, "%s", subject);
    struct bucket *bucket = bucket_of(hub, watch->subject);
    pthread_mutex_lock(&bucket->lock);
    watch->next = bucket->first;
    if (watch->next)
        watch->next->previous = watch;
    bucket->first = watch;
    pthread_mutex_unlock(&bucket->lock);
}

void hub_unsubscribe(struct hub *hub, struct hub_watch *watch) {
    struct bucket *bucket = bucket_of(hub, watch->subject);
    pthread_mutex_lock(&bucket->lock);
    if (watch->previous)
        watch->previous->next = watch->next;
    else
        bucket->first = watch->next;
    if (watch->next)
        watch->next->previous = watch->previous;
    pthread_mutex_unlock(&bucket->lock);
}

void hub_notify(struct hub *hub, const char *subject, enum hub_news news) {
    struct bucket *bucket = bucket_of(hub, subject);
    pthread_mutex_lock(&bucket->lock);
    for (struct hub_watch *watch = bucket->first; watch; watch = watch->next)
        if (watch->least >= news && !strcmp(watch->subject, subject))
            watch->wake(watch->context);
    pthread_mutex_unlock(&bucket->lock);
}
