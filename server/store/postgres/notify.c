/* SPDX-License-Identifier: MIT */
#include "notify.h"
#include "pool.h"
#include "server/clock.h"
#include <libpq-fe.h>
#include <poll.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <unistd.h>

enum {
    RETRY_FIRST_MS = 250,
    RETRY_DOUBLED_MOST = 5,
    LISTEN_MS = 60000,
    ANNOUNCE_EVERY_MS = 5,
    TEXT_MAX = 7900, /* bytes: the server takes less than 8000 */
    ROOM_FOR_QUEUE = 8
};

/* Subjects are collected while one text is on its way; a text names as many as fit. */
struct notify {
    struct pool *pool;
    PGconn *connection; /* of the thread; NULL without */
    struct job_events *events;
    pthread_t thread;
    int wake; /* eventfd */
    atomic_bool stopping;
    pthread_mutex_t lock;
    bool queue;  /* job_events_queue is to be announced */
    size_t used; /* of the text, which has each id behind a blank */
    char text[TEXT_MAX + 1];
};

/* ------------------------------------------------------------------ what is to be announced */

static void wake_thread(struct notify *notify) {
    uint64_t one = 1;
    (void)!write(notify->wake, &one, sizeof one); /* it only fails when it is awake already */
}

/* What does not fit is left out: it is found by looking. */
void notify_announce(struct notify *notify, const char *subject) {
    size_t length = strlen(subject);
    pthread_mutex_lock(&notify->lock);
    if (!strcmp(subject, job_events_queue)) {
        notify->queue = true;
    } else if (notify->used + length + 1 < sizeof notify->text - ROOM_FOR_QUEUE) {
        notify->text[notify->used] = ' ';
        memcpy(notify->text + notify->used + 1, subject, length);
        notify->used += length + 1;
    }
    pthread_mutex_unlock(&notify->lock);
    wake_thread(notify);
}

/* ------------------------------------------------------------------ the connection */

static void disconnect(struct notify *notify) {
    PQfinish(notify->connection);
    notify->connection = NULL;
}

/* Passes on the subjects that others have announced as job events; whether there was anything.
 * Words of another program on our channel name nothing here and do no harm. */
static bool pass_on_all(struct notify *notify) {
    bool any = false;
    PGnotify *received = NULL;
    for (; (received = PQnotifies(notify->connection)) != NULL; PQfreemem(received)) {
        any = true;
        const char *text =
            received->be_pid == PQbackendPID(notify->connection) ? "" : received->extra;
        while (*text) {
            char subject[ID_SIZE];
            size_t length = strcspn(text, " ");
            if (length > 0 && length < sizeof subject) {
                memcpy(subject, text, length);
                subject[length] = '\0';
                job_events_notify(notify->events, subject, JOB_CHANGED);
            }
            text += length + (text[length] == ' ');
        }
    }
    return any;
}

/* Waits for announcements of others or until there is something to announce, and announces it;
 * false when there is no connection: wait before trying again. One text goes every few milliseconds
 * at the most, however much happens. In a transaction of its own, which writes nothing: the server
 * lets only one transaction that announces end at a time, and one that waited for its disk
 * meanwhile would hold up all others. */
static bool carry_once(struct notify *notify) {
    char text[TEXT_MAX + 1];
    uint64_t count = 0;
    if (!notify->connection) {
        notify->connection = pool_connect(notify->pool);
        PGresult *result = PQexec(notify->connection, "LISTEN draped");
        bool good = PQresultStatus(result) == PGRES_COMMAND_OK &&
                    PQsetnonblocking(notify->connection, 1) == 0;
        PQclear(result);
        if (!good) {
            disconnect(notify);
            return false;
        }
    }
    struct pollfd files[2] = {{.fd = PQsocket(notify->connection), .events = POLLIN},
                              {.fd = notify->wake, .events = POLLIN}};
    bool any = pass_on_all(notify); /* some came while we announced */
    if (poll(files, 2, any ? 0 : LISTEN_MS) > 0 && files[0].revents) {
        if (!PQconsumeInput(notify->connection)) {
            disconnect(notify);
            return false;
        }
        pass_on_all(notify);
    }
    (void)!read(notify->wake, &count, sizeof count);
    pthread_mutex_lock(&notify->lock);
    any = notify->queue || notify->used > 0;
    snprintf(text, sizeof text, "%s%.*s", notify->queue ? job_events_queue : "", (int)notify->used,
             notify->text);
    notify->queue = false;
    notify->used = 0;
    pthread_mutex_unlock(&notify->lock);
    if (!any)
        return true;
    const char *value = text;
    int64_t until = clock_ms() + pool_patience_ms(notify->pool);
    bool sent = PQsendQueryParams(notify->connection, "SELECT pg_notify('draped', $1)", 1, NULL,
                                  &value, NULL, NULL, 0);
    PGresult *result = sent ? pool_receive(notify->connection, until) : NULL;
    bool good = PQresultStatus(result) == PGRES_TUPLES_OK;
    PQclear(result);
    if (!good)
        disconnect(notify);
    nanosleep(&(struct timespec){.tv_nsec = ANNOUNCE_EVERY_MS * 1000000L}, NULL);
    return good;
}

/* ------------------------------------------------------------------ the thread */

int notify_pause_ms(int failures) {
    return RETRY_FIRST_MS << (failures < RETRY_DOUBLED_MOST ? failures : RETRY_DOUBLED_MOST);
}

static void *carry(void *context) {
    struct notify *notify = context;
    int failures = 0;
    while (!atomic_load(&notify->stopping)) {
        if (carry_once(notify)) {
            failures = 0;
            continue;
        }
        int64_t until = clock_ms() + notify_pause_ms(failures++);
        while (!atomic_load(&notify->stopping) && clock_ms() < until)
            nanosleep(&(struct timespec){.tv_nsec = 50 * 1000000L}, NULL);
    }
    return NULL;
}

static void notify_free(struct notify *notify) {
    disconnect(notify);
    if (notify->wake >= 0)
        close(notify->wake);
    pthread_mutex_destroy(&notify->lock);
    free(notify);
}

struct notify *notify_start(struct pool *pool, struct job_events *events) {
    struct notify *notify = calloc(1, sizeof *notify);
    if (!notify)
        return NULL;
    notify->pool = pool;
    notify->events = events;
    notify->wake = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    pthread_mutex_init(&notify->lock, NULL);
    if (notify->wake >= 0 && pthread_create(&notify->thread, NULL, carry, notify) == 0)
        return notify;
    notify_free(notify);
    return NULL;
}

void notify_stop(struct notify *notify) {
    if (!notify)
        return;
    atomic_store(&notify->stopping, true);
    wake_thread(notify);
    pthread_join(notify->thread, NULL);
    notify_free(notify);
}
