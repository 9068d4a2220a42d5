/* SPDX-License-Identifier: MIT */
#include "lingering_close.h"
#include "server/clock.h"
#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

enum {
    LINGER_MAX = 64,     /* sockets at once: so many are refused at a time only in an attack */
    LINGER_MS = 2000,    /* what RFC 9112 calls a period; nginx waits 5 s, we have less to do */
    LINGER_READ = 65536, /* bytes thrown away at a time */
    LINGER_READS_MAX = 16384, /* 1 GiB: a client that still sends then gets the reset */
};

struct lingering {
    int socket, reads;
    int64_t until;
};

struct lingering_close {
    pthread_t thread;
    pthread_mutex_t lock;
    int event;
    bool stop;
    size_t count;
    struct lingering entries[LINGER_MAX];
};

static void drop_entry(struct lingering_close *pool, size_t k) {
    close(pool->entries[k].socket);
    pool->entries[k] = pool->entries[--pool->count];
}

static void *read_lingering(void *context) {
    static char away[LINGER_READ]; /* never looked at; one thread */
    struct lingering_close *pool = context;
    struct pollfd set[LINGER_MAX + 1] = {{pool->event, POLLIN, 0}};
    pthread_mutex_lock(&pool->lock);
    while (!pool->stop) {
        int64_t now = clock_ms(), first = INT64_MAX;
        nfds_t count = pool->count + 1;
        for (size_t k = 0; k < pool->count; k++) {
            set[k + 1] = (struct pollfd){pool->entries[k].socket, POLLIN, 0};
            if (pool->entries[k].until < first)
                first = pool->entries[k].until;
        }
        int wait = !pool->count ? -1 : first > now ? (int)(first - now) : 0;
        pthread_mutex_unlock(&pool->lock);
        poll(set, count, wait);
        uint64_t events;
        if (set[0].revents && read(pool->event, &events, sizeof events) < 0)
            poll(NULL, 0, 1); /* cannot happen; do not spin */
        pthread_mutex_lock(&pool->lock);
        /* reads once from those that have something; drops those that have ended or had their time
         */
        now = clock_ms();
        for (size_t k = pool->count; k-- > 0;) {
            struct lingering *entry = &pool->entries[k];
            ssize_t got = recv(entry->socket, away, sizeof away, MSG_DONTWAIT);
            if (got == 0 || now >= entry->until || (got > 0 && ++entry->reads >= LINGER_READS_MAX))
                drop_entry(pool, k);
        }
    }
    while (pool->count)
        drop_entry(pool, pool->count - 1);
    pthread_mutex_unlock(&pool->lock);
    return NULL;
}

struct lingering_close *lingering_close_start(void) {
    struct lingering_close *pool = calloc(1, sizeof *pool);
    if (!pool)
        return NULL;
    pool->event = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    pthread_mutex_init(&pool->lock, NULL);
    if (pool->event >= 0 && !pthread_create(&pool->thread, NULL, read_lingering, pool))
        return pool;
    if (pool->event >= 0)
        close(pool->event);
    pthread_mutex_destroy(&pool->lock);
    free(pool);
    return NULL;
}

static void poke(struct lingering_close *pool) {
    uint64_t one = 1;
    (void)!write(pool->event, &one, sizeof one); /* it only fails when it is awake already */
}

void lingering_close_add(struct lingering_close *pool, int socket) {
    pthread_mutex_lock(&pool->lock);
    int copy = pool->count < LINGER_MAX ? fcntl(socket, F_DUPFD_CLOEXEC, 0) : -1;
    if (copy >= 0) {
        shutdown(copy, SHUT_WR);
        pool->entries[pool->count++] = (struct lingering){copy, 0, clock_ms() + LINGER_MS};
    }
    pthread_mutex_unlock(&pool->lock);
    if (copy >= 0)
        poke(pool);
}

void lingering_close_stop(struct lingering_close *pool) {
    if (!pool)
        return;
    pthread_mutex_lock(&pool->lock);
    pool->stop = true;
    pthread_mutex_unlock(&pool->lock);
    poke(pool);
    pthread_join(pool->thread, NULL);
    close(pool->event);
    pthread_mutex_destroy(&pool->lock);
    free(pool);
}
