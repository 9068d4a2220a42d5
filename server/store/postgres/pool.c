/* SPDX-License-Identifier: MIT */
#include "pool.h"
#include "server/clock.h"
#include "server/log.h"
#include <errno.h>
#include <libpq-fe.h>
#include <poll.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    VERSION_MIN = 130000,
    IDLE_MS = 60000, /* a connection unused for so long is closed */
    BACK_OFF_FIRST_MS = 100,
    BACK_OFF_MOST_MS = 5000
};

/* A thread that waits for a connection. */
struct waiter {
    struct waiter *next;
};

struct pool {
    char *url;
    char *password; /* NULL without; to be kept out of messages */
    int64_t patience_ms;
    atomic_bool nameless;

    pthread_mutex_t lock;
    pthread_cond_t back;    /* a connection was given back, or another is the first to wait */
    struct waiter *waiting; /* a list: who came first is first */
    struct pool_connection *idle[POOL_CONNECTIONS];
    size_t idle_count, open;
    unsigned generation; /* grows when connections turn out to be lost */
    bool down, trying;   /* the last try failed; a thread tries now */
    int64_t back_off_ms, try_at_ms;
};

int64_t pool_patience_ms(const struct pool *pool) {
    return pool->patience_ms;
}

bool pool_nameless(struct pool *pool) {
    return atomic_load(&pool->nameless);
}

void pool_set_nameless(struct pool *pool) {
    atomic_store(&pool->nameless, true);
}

/* ------------------------------------------------------------------ messages */

void pool_say(char why[STORE_WHY_SIZE], const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(why, STORE_WHY_SIZE, format, arguments);
    va_end(arguments);
    for (char *c = why; *c; c++)
        if (*c == '\n' || *c == '\t')
            *c = c[1] ? ' ' : '\0';
}

void pool_hide_password(const struct pool *pool, char *text) {
    size_t length = pool->password ? strlen(pool->password) : 0;
    for (char *found = text; length > 0 && (found = strstr(found, pool->password)) != NULL;)
        memset(found, '*', length);
}

/* ------------------------------------------------------------------ connections */

static void connection_free(struct pool_connection *connection) {
    if (!connection)
        return;
    PQfinish(connection->libpq);
    free(connection);
}

/* Without this libpq would write them on stderr, where the log is. */
static void take_notice(void *context, const char *message) {
    (void)context;
    log_debug(log_event("store_notice"), log_text("text", message));
}

PGconn *pool_connect(const struct pool *pool) {
    static const char *const names[] = {
        "fallback_application_name", "connect_timeout", "keepalives_idle", "keepalives_interval",
        "keepalives_count",          "client_encoding", "dbname",          NULL};
    const char *const values[] = {"draped", "5", "10", "5", "3", "UTF8", pool->url, NULL};
    PGconn *libpq = PQconnectdbParams(names, values, 1); /* the URL comes last and wins */
    PQsetNoticeProcessor(libpq, take_notice, NULL);
    return libpq;
}

/* A lock is waited for a little less long than an answer. */
static struct pool_connection *connection_new(const struct pool *pool, char why[STORE_WHY_SIZE]) {
    struct pool_connection *connection = calloc(1, sizeof *connection);
    if (!connection) {
        pool_say(why, "no memory for a connection");
        return NULL;
    }
    char sql[64];
    snprintf(sql, sizeof sql, "SET lock_timeout = %lld", (long long)pool->patience_ms * 4 / 5);
    connection->libpq = pool_connect(pool);
    bool good = PQstatus(connection->libpq) == CONNECTION_OK;
    PGresult *result = good ? PQexec(connection->libpq, sql) : NULL;
    good = good && PQresultStatus(result) == PGRES_COMMAND_OK;
    PQclear(result);
    if (!good) {
        pool_say(why, "the database cannot be used: %s", PQerrorMessage(connection->libpq));
        pool_hide_password(pool, why);
    } else if (PQserverVersion(connection->libpq) < VERSION_MIN)
        pool_say(why, "the database server is PostgreSQL %d: use 13 or newer",
                 PQserverVersion(connection->libpq) / 10000);
    else if (PQsetnonblocking(connection->libpq, 1) == 0)
        return connection;
    connection_free(connection);
    return NULL;
}

/* A new connection; the lock is held and given up meanwhile. After a failure a call before the next
 * try is due fails at once, so that the threads which serve callers do not all wait. */
static struct pool_connection *open_connection(struct pool *pool) {
    char why[STORE_WHY_SIZE] = "";
    bool was_down = pool->down;
    unsigned generation = pool->generation;
    pool->open++;
    pool->trying = pool->down;
    pthread_mutex_unlock(&pool->lock);
    struct pool_connection *connection = connection_new(pool, why);
    if (!connection)
        log_warning(log_event("store_unreachable"), log_text("why", why));
    else if (was_down)
        log_info(log_event("store_reached"));
    pthread_mutex_lock(&pool->lock);
    pool->trying = false;
    pool->down = !connection;
    int64_t next = pool->back_off_ms * 2;
    pool->back_off_ms = connection                 ? 0
                        : next < BACK_OFF_FIRST_MS ? BACK_OFF_FIRST_MS
                        : next > BACK_OFF_MOST_MS  ? BACK_OFF_MOST_MS
                                                   : next;
    pool->try_at_ms = clock_ms() + pool->back_off_ms;
    if (connection)
        connection->generation = generation;
    else
        pool->open--;
    pthread_cond_broadcast(&pool->back);
    return connection;
}

struct pool_connection *pool_take(struct pool *pool, enum store_answer *answer) {
    struct timespec until = clock_after_ms(pool->patience_ms);
    struct pool_connection *connection = NULL;
    struct waiter me = {0}, **at = &pool->waiting;
    int code = 0;
    *answer = STORE_DOWN;
    pthread_mutex_lock(&pool->lock);
    /* Waits until there is a connection, or may be, and nobody has waited for it longer. */
    while (*at)
        at = &(*at)->next;
    *at = &me;
    while (code == 0 &&
           (pool->waiting != &me || (pool->idle_count == 0 && pool->open == POOL_CONNECTIONS)))
        code = pthread_cond_timedwait(&pool->back, &pool->lock, &until);
    for (at = &pool->waiting; *at != &me;)
        at = &(*at)->next;
    *at = me.next;
    if (pool->waiting)
        pthread_cond_broadcast(&pool->back);
    if (pool->idle_count > 0)
        connection = pool->idle[--pool->idle_count];
    else if (pool->open == POOL_CONNECTIONS)
        *answer = STORE_BUSY;
    else if (!pool->down || (!pool->trying && clock_ms() >= pool->try_at_ms))
        connection = open_connection(pool);
    pthread_mutex_unlock(&pool->lock);
    return connection;
}

/* The last one used is used next. One that was lost takes along those made before: what cut it has
 * cut them. */
void pool_give(struct pool *pool, struct pool_connection *connection, bool lost) {
    struct pool_connection *drop[POOL_CONNECTIONS + 1] = {0};
    size_t count = 0;
    pthread_mutex_lock(&pool->lock);
    if (lost && connection->generation == pool->generation) {
        pool->generation++;
        while (pool->idle_count > 0)
            drop[count++] = pool->idle[--pool->idle_count];
        pool->open -= count;
    }
    if (connection->generation == pool->generation) {
        connection->used_ms = clock_ms();
        pool->idle[pool->idle_count++] = connection;
        /* The one that was used longest ago goes if that is long enough. */
        if (pool->idle_count > 1 && clock_ms() - pool->idle[0]->used_ms >= IDLE_MS) {
            drop[count++] = pool->idle[0];
            memmove(pool->idle, pool->idle + 1, --pool->idle_count * sizeof *pool->idle);
            pool->open--;
        }
    } else {
        drop[count++] = connection;
        pool->open--;
    }
    pthread_cond_broadcast(&pool->back);
    pthread_mutex_unlock(&pool->lock);
    for (size_t k = 0; k < count; k++)
        connection_free(drop[k]);
}

/* ------------------------------------------------------------------ answers */

PGresult *pool_receive(PGconn *libpq, int64_t until_ms) {
    PGresult *kept = NULL;
    bool good = true;
    while (good) {
        /* Until the next one is complete, unless the connection is lost or the time is over. */
        int unsent = PQflush(libpq);
        while (good && (unsent > 0 || PQisBusy(libpq))) {
            struct pollfd file = {.fd = PQsocket(libpq),
                                  .events = (short)(POLLIN | (unsent > 0 ? POLLOUT : 0))};
            int64_t left = until_ms - clock_ms();
            int ready = left > 0 ? poll(&file, 1, (int)left) : 0;
            good = ready != 0 && (ready > 0 || errno == EINTR) && PQconsumeInput(libpq);
            unsent = good ? PQflush(libpq) : unsent;
        }
        good = good && unsent == 0;
        PGresult *next = good ? PQgetResult(libpq) : NULL;
        if (!next)
            break;
        bool failed = PQresultStatus(kept) == PGRES_FATAL_ERROR && kept;
        PQclear(failed ? next : kept);
        kept = failed ? kept : next;
    }
    if (good && PQstatus(libpq) == CONNECTION_OK)
        return kept;
    PQclear(kept);
    return NULL;
}

/* ------------------------------------------------------------------ open and close */

struct pool *pool_open(const char *url, int64_t patience_ms, char why[STORE_WHY_SIZE]) {
    pthread_condattr_t monotonic;
    struct pool *pool = calloc(1, sizeof *pool);
    if (!pool || !(pool->url = strdup(url))) {
        pool_say(why, "no memory for the database");
        free(pool);
        return NULL;
    }
    pthread_condattr_init(&monotonic);
    pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC);
    pthread_mutex_init(&pool->lock, NULL);
    pthread_cond_init(&pool->back, &monotonic);
    pthread_condattr_destroy(&monotonic);
    pool->patience_ms = patience_ms;
    /* A password with an unescaped @ or / shifts what follows, and parts of it would be taken for a
     * host or a database and reported as such; likewise by libpq's own messages. */
    PQconninfoOption *options = PQconninfoParse(url, NULL);
    bool good = options != NULL;
    for (PQconninfoOption *option = options; option && option->keyword; option++) {
        const char *name = option->keyword, *value = option->val ? option->val : "";
        if (!strcmp(name, "password") && value[0])
            pool->password = strdup(value);
        else if (!strcmp(name, "port"))
            good = good && value[strspn(value, "0123456789,")] == 0;
        else if (!strcmp(name, "dbname") || (!strcmp(name, "host") && value[0] != '/'))
            good = good && !strchr(value, '@');
    }
    PQconninfoFree(options);
    if (!good)
        pool_say(why,
                 "the URL of the store cannot be read: it is postgresql://USER:PASSWORD@HOST:PORT/"
                 "DATABASE, with %%40 for an @, %%2F for a / and %%25 for a %% in the password");
    /* The first connection says why there is none. */
    struct pool_connection *first = good ? connection_new(pool, why) : NULL;
    if (!first) {
        pool_close(pool);
        return NULL;
    }
    pool->open = 1;
    pool_give(pool, first, false);
    return pool;
}

void pool_close(struct pool *pool) {
    if (!pool)
        return;
    while (pool->idle_count > 0)
        connection_free(pool->idle[--pool->idle_count]);
    pthread_mutex_destroy(&pool->lock);
    pthread_cond_destroy(&pool->back);
    free(pool->password);
    free(pool->url);
    free(pool);
}
