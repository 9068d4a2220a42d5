/* SPDX-License-Identifier: MIT */
#include "http.h"
#include "client.h"
#include "interpose.h"
#include "lingering_close.h"
#include "listener.h"
#include "server/clock.h"
#include "server/config.h"
#include "server/log.h"
#include <microhttpd.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

enum {
    THREADS_PER_CORE = 4, /* a thread whose request waits for the disk answers no other */
    THREADS_MAX = 16,
    FLUSH_MS = 2000,   /* answers under way get this long at the end */
    FLUSH_STEP_MS = 10 /* and are looked at this often */
};

/* ------------------------------------------------------------------ notices of the library */

static struct client *client_of(struct MHD_Connection *connection) {
    const union MHD_ConnectionInfo *info =
        MHD_get_connection_info(connection, MHD_CONNECTION_INFO_SOCKET_CONTEXT);
    return info ? info->socket_context : NULL;
}

/* The library is about to answer with a page of its own. */
static void replace_page(struct MHD_Connection *connection, unsigned status) {
    struct client *client = client_of(connection);
    if (client)
        client_refuse_status(client, status);
}

/* The first and last notice of a connection. */
static void connection_notified(void *context, struct MHD_Connection *connection, void **state,
                                enum MHD_ConnectionNotificationCode code) {
    if (code == MHD_CONNECTION_NOTIFY_STARTED) {
        const union MHD_ConnectionInfo *info =
            MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CONNECTION_FD);
        const union MHD_ConnectionInfo *peer =
            MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CLIENT_ADDRESS);
        *state =
            info ? client_open(context, info->connect_fd, peer ? peer->client_addr : NULL) : NULL;
    } else if (*state) {
        struct client *client = *state;
        if (client->exchange) /* the library forgets it when the query overflows its memory */
            exchange_end(client->exchange);
        client_close(client);
    }
}

/* The first notice of a request. */
static void *request_begins(void *context, const char *target, struct MHD_Connection *connection) {
    struct client *client = client_of(connection);
    (void)context;
    return client ? exchange_new(client, connection, target) : NULL;
}

static enum MHD_Result request_continues(void *context, struct MHD_Connection *connection,
                                         const char *url, const char *method, const char *version,
                                         const char *data, size_t *size, void **state) {
    (void)context, (void)connection, (void)url;
    if (!*state)
        return MHD_NO; /* there was no memory when the request began */
    return exchange_step(*state, method, version, data, size) ? MHD_YES : MHD_NO;
}

/* The last notice of a request, whichever way it ended. */
static void request_ends(void *context, struct MHD_Connection *connection, void **state,
                         enum MHD_RequestTerminationCode code) {
    struct http *http = context;
    struct exchange *exchange = *state;
    (void)connection;
    *state = NULL;
    if (!exchange)
        return;
    if (exchange->unread && code == MHD_REQUEST_TERMINATED_COMPLETED_OK)
        lingering_close_add(http->linger, exchange->client->deadline.socket);
    struct client *client = exchange->client;
    deadlines_turn(http->deadlines, &client->deadline, DEADLINES_IDLE, 0);
    exchange_end(exchange);
    client_ended(client);
}

/* What the library reports about broken clients. */
static void log_library(void *context, const char *format, va_list arguments) {
    (void)context;
    char text[256];
    vsnprintf(text, sizeof text, format, arguments);
    text[strcspn(text, "\n")] = '\0';
    log_debug(log_event("microhttpd"), log_text("message", text));
}

/* ------------------------------------------------------------------ start and stop */

bool http_start(const struct http_settings *settings, struct http **out) {
    const struct config *config = settings->config;
    const int64_t limits[] = {[QUOTAS_CONNECTIONS] = config->max_connections,
                              [QUOTAS_STREAMS] = config->max_connections,
                              [QUOTAS_BODIES] = config->max_bodies};
    const struct interpose_hooks hooks = {replace_page, client_received};
    const unsigned flags =
        MHD_USE_EPOLL_INTERNAL_THREAD | MHD_USE_ITC | MHD_ALLOW_SUSPEND_RESUME | MHD_USE_ERROR_LOG;
    const unsigned connections =
        (unsigned)config->max_connections + ADMISSION_RESERVE + ADMISSION_CLOSING;
    /* More than the cores: submits that come in while a commit waits for the disk share the next
     * one. Never more than the least --max-connections, which are divided among them. */
    long cores = sysconf(_SC_NPROCESSORS_ONLN), threads = cores * THREADS_PER_CORE;
    threads = cores < 1 ? 1 : threads < THREADS_MAX ? threads : THREADS_MAX;
    struct http *http = calloc(1, sizeof *http);
    if (!http)
        return false;
    http->settings = *settings;
    http->socket = listener_open(config);
    http->linger = lingering_close_start();
    http->deadlines = deadlines_new(client_refuse_late, http);
    http->quotas = quotas_new(limits);
    http->slow_calls = slow_calls_start(exchange_attend);
    if (http->quotas)
        http->admissions = admissions_new(http->quotas, config->owner_connections);
    if (http->socket >= 0 && http->slow_calls && http->linger && http->deadlines &&
        http->admissions && suspension_start(http) &&
        interpose_init(&hooks, listener_descriptors()))
        http->daemon = MHD_start_daemon(
            flags, 0, NULL, NULL, request_continues, http, MHD_OPTION_EXTERNAL_LOGGER, log_library,
            NULL, MHD_OPTION_LISTEN_SOCKET, http->socket, MHD_OPTION_THREAD_POOL_SIZE,
            (unsigned)threads, MHD_OPTION_CONNECTION_LIMIT, connections,
            MHD_OPTION_CONNECTION_TIMEOUT, (unsigned)DEADLINES_IDLE_MS / 1000,
            MHD_OPTION_CONNECTION_MEMORY_LIMIT, (size_t)CLIENT_POOL_BYTES,
            MHD_OPTION_NOTIFY_CONNECTION, connection_notified, http, MHD_OPTION_URI_LOG_CALLBACK,
            request_begins, http, MHD_OPTION_NOTIFY_COMPLETED, request_ends, http, MHD_OPTION_END);
    if (http->daemon) {
        *out = http;
        return true;
    }
    if (http->socket >= 0)
        log_error(log_event("http_failed"), log_text("error", "threads cannot be started"));
    http_stop(http);
    return false;
}

uint16_t http_port(const struct http *http) {
    return listener_port(http->socket);
}

void http_drain(struct http *http) {
    if (atomic_exchange(&http->draining, true))
        return;
    MHD_quiesce_daemon(http->daemon);
    /* New connections are refused at once. Closing has to wait for the library's threads, which may
     * be about to use the descriptor. A socket of the service manager's keeps callers for the next
     * daemon. */
    if (http->settings.config->inherited < 0)
        shutdown(http->socket, SHUT_RDWR);
}

void http_stop(struct http *http) {
    if (!http)
        return;
    suspension_stop(http);
    slow_calls_stop(http->slow_calls); /* nothing is handed over any more */
    if (http->daemon) {
        http_drain(http);
        int64_t until = clock_ms() + FLUSH_MS;
        while (atomic_load(&http->exchanges) > 0 && clock_ms() < until)
            nanosleep(&(struct timespec){0, FLUSH_STEP_MS * 1000000}, NULL);
        MHD_stop_daemon(http->daemon);
    }
    lingering_close_stop(http->linger);
    deadlines_free(http->deadlines);
    admissions_free(http->admissions);
    quotas_free(http->quotas);
    slow_calls_free(http->slow_calls);
    if (http->socket >= 0)
        close(http->socket);
    pthread_cond_destroy(&http->changed);
    pthread_mutex_destroy(&http->lock);
    free(http);
}
