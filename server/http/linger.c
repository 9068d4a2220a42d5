/* SPDX-License-Identifier: MIT */
#include "linger.h"
#include "request.h"
#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <stdlib.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

enum {
    FAREWELL_MAX = 64,     /* sockets at once: so many are refused at a time only in an attack */
    FAREWELL_MS = 2000,    /* what RFC 9112 calls a period; nginx waits 5 s, we have less to do */
    FAREWELL_READ = 65536, /* bytes thrown away at a time */
    FAREWELL_READS_MAX = 16384, /* 1 GiB: who still sends then gets the reset */
};

struct lingering {
    int socket, reads;
    int64_t until;
};

struct farewell {
    pthread_t thread;
    pthread_mutex_t lock;
    int event;
    bool stop;
    size_t count;
    struct lingering entries[FAREWELL_MAX];
};

static void drop(struct farewell *farewell, size_t k) {
    close(farewell->entries[k].socket);
    farewell->entries[k] = farewell->entries[--farewell->count];
}

/* Reads once from those that have something; drops those that have ended or had their time. */
static void read_away(struct farewell *farewell, int64_t now) {
    static char away[FAREWELL_READ]; /* never looked at; one thread */
    for (size_t k = farewell->count; k-- > 0;) {
        struct lingering *entry = &farewell->entries[k];
        ssize_t got = recv(entry->socket, away, sizeof away, MSG_DONTWAIT);
        bool idle = got < 0;
        if (got == 0 || now >= entry->until || (!idle && ++entry->reads >= FAREWELL_READS_MAX))
            drop(farewell, k);
    }
}

/* Fills the poll set; returns how many, and the milliseconds to wait. */
static nfds_t watch(struct farewell *farewell, struct pollfd *set, int *wait) {
    int64_t now = request_clock_ms(), first = INT64_MAX;
    set[0] = (struct pollfd){farewell->event, POLLIN, 0};
    for (size_t k = 0; k < farewell->count; k++) {
        set[k + 1] = (struct pollfd){farewell->entries[k].socket, POLLIN, 0};
        if (farewell->entries[k].until < first)
            first = farewell->entries[k].until;
    }
    *wait = !farewell->count ? -1 : first > now ? (int)(first - now) : 0;
    return farewell->count + 1;
}

static void *run(void *context) {
    struct farewell *farewell = context;
    struct pollfd set[FAREWELL_MAX + 1];
    pthread_mutex_lock(&farewell->lock);
    while (!farewell->stop) {
        int wait;
        nfds_t count = watch(farewell, set, &wait);
        pthread_mutex_unlock(&farewell->lock);
        poll(set, count, wait);
        uint64_t events;
        if (set[0].revents && read(farewell->event, &events, sizeof events) < 0)
            poll(NULL, 0, 1); /* cannot happen; do not spin */
        pthread_mutex_lock(&farewell->lock);
        read_away(farewell, request_clock_ms());
    }
    while (farewell->count)
        drop(farewell, farewell->count - 1);
    pthread_mutex_unlock(&farewell->lock);
    return NULL;
}

struct farewell *farewell_start(void) {
    struct farewell *farewell = calloc(1, sizeof *farewell);
    if (!farewell)
        return NULL;
    farewell->event = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    pthread_mutex_init(&farewell->lock, NULL);
    if (farewell->event >= 0 && !pthread_create(&farewell->thread, NULL, run, farewell))
        return farewell;
    if (farewell->event >= 0)
        close(farewell->event);
    pthread_mutex_destroy(&farewell->lock);
    free(farewell);
    return NULL;
}

static void poke(struct farewell *farewell) {
    uint64_t one = 1;
    if (write(farewell->event, &one, sizeof one) < 0)
        return; /* the counter is full: it is awake anyway */
}

void farewell_add(struct farewell *farewell, int socket) {
    pthread_mutex_lock(&farewell->lock);
    int copy = farewell->count < FAREWELL_MAX ? fcntl(socket, F_DUPFD_CLOEXEC, 0) : -1;
    if (copy >= 0) {
        shutdown(copy, SHUT_WR);
        farewell->entries[farewell->count++] =
            (struct lingering){copy, 0, request_clock_ms() + FAREWELL_MS};
    }
    pthread_mutex_unlock(&farewell->lock);
    if (copy >= 0)
        poke(farewell);
}

void farewell_stop(struct farewell *farewell) {
    if (!farewell)
        return;
    pthread_mutex_lock(&farewell->lock);
    farewell->stop = true;
    pthread_mutex_unlock(&farewell->lock);
    poke(farewell);
    pthread_join(farewell->thread, NULL);
    close(farewell->event);
    pthread_mutex_destroy(&farewell->lock);
    free(farewell);
}
