/* SPDX-License-Identifier: MIT */
#include "postgres.h"
#include "server/clock.h"
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <time.h>
#include <unistd.h>

enum {
    RETRY_FIRST_MS = 250,
    RETRY_MOST_MS = 8000,
    LISTEN_MS = 60000,
    SAY_EVERY_MS = 5,
    ROOM_FOR_QUEUE = 8
};

/* Subjects are collected while one text is on its way; a text names as many as fit. */
struct bell {
    struct pg_ear *ear;
    struct hub *hub;
    pthread_t thread;
    int wake; /* eventfd */
    atomic_bool stopping;
    pthread_mutex_t lock;
    bool queue;  /* hub_queue is to be told */
    size_t used; /* of the text, which has each id behind a blank */
    char text[PG_TEXT_MAX + 1];
};

static void wake_up(struct bell *bell) {
    uint64_t one = 1;
    ssize_t written = write(bell->wake, &one, sizeof one);
    (void)written; /* it only fails when it is awake already */
}

/* What does not fit is left out: it is found by looking. */
void bell_ring(struct bell *bell, const char *subject) {
    size_t length = strlen(subject);
    pthread_mutex_lock(&bell->lock);
    if (!strcmp(subject, hub_queue)) {
        bell->queue = true;
    } else if (bell->used + length + 1 < sizeof bell->text - ROOM_FOR_QUEUE) {
        bell->text[bell->used] = ' ';
        memcpy(bell->text + bell->used + 1, subject, length);
        bell->used += length + 1;
    }
    pthread_mutex_unlock(&bell->lock);
    wake_up(bell);
}

/* The text to be sent; false when there is none. */
static bool collect(struct bell *bell, char text[PG_TEXT_MAX + 1]) {
    pthread_mutex_lock(&bell->lock);
    bool any = bell->queue || bell->used > 0;
    snprintf(text, PG_TEXT_MAX + 1, "%s%.*s", bell->queue ? hub_queue : "", (int)bell->used,
             bell->text);
    bell->queue = false;
    bell->used = 0;
    pthread_mutex_unlock(&bell->lock);
    return any;
}

/* Words of another program on our channel name nobody here and do no harm. */
static void hear(void *context, const char *text) {
    struct bell *bell = context;
    char subject[ID_SIZE];
    while (*text) {
        size_t length = strcspn(text, " ");
        if (length > 0 && length < sizeof subject) {
            memcpy(subject, text, length);
            subject[length] = '\0';
            hub_notify(bell->hub, subject);
        }
        text += length + (text[length] == ' ');
    }
}

/* Waits, unless it is to stop, in vain for what would be said meanwhile. */
static void pause_ms(struct bell *bell, int ms) {
    int64_t until = clock_ms() + ms;
    while (!atomic_load(&bell->stopping) && clock_ms() < until)
        nanosleep(&(struct timespec){.tv_nsec = SAY_EVERY_MS * 10 * 1000000L}, NULL);
}

/* One text every few milliseconds at the most, however much happens. */
static bool speak(struct bell *bell) {
    char text[PG_TEXT_MAX + 1];
    uint64_t count = 0;
    ssize_t got = read(bell->wake, &count, sizeof count);
    (void)got;
    if (!collect(bell, text))
        return true;
    bool good = pg_ear_say(bell->ear, text);
    nanosleep(&(struct timespec){.tv_nsec = SAY_EVERY_MS * 1000000L}, NULL);
    return good;
}

static void *carry(void *context) {
    struct bell *bell = context;
    int retry_ms = RETRY_FIRST_MS;
    while (!atomic_load(&bell->stopping)) {
        if (pg_ear_wait(bell->ear, bell->wake, LISTEN_MS, hear, bell) && speak(bell)) {
            retry_ms = RETRY_FIRST_MS;
            continue;
        }
        pause_ms(bell, retry_ms);
        retry_ms = retry_ms * 2 < RETRY_MOST_MS ? retry_ms * 2 : RETRY_MOST_MS;
    }
    return NULL;
}

static void bell_free(struct bell *bell) {
    pg_ear_free(bell->ear);
    if (bell->wake >= 0)
        close(bell->wake);
    pthread_mutex_destroy(&bell->lock);
    free(bell);
}

struct bell *bell_start(struct pg *pg, struct hub *hub) {
    struct bell *bell = calloc(1, sizeof *bell);
    if (!bell)
        return NULL;
    bell->hub = hub;
    bell->ear = pg_ear_new(pg);
    bell->wake = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    pthread_mutex_init(&bell->lock, NULL);
    if (bell->ear && bell->wake >= 0 && pthread_create(&bell->thread, NULL, carry, bell) == 0)
        return bell;
    bell_free(bell);
    return NULL;
}

void bell_stop(struct bell *bell) {
    if (!bell)
        return;
    atomic_store(&bell->stopping, true);
    wake_up(bell);
    pthread_join(bell->thread, NULL);
    bell_free(bell);
}
