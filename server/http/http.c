/* SPDX-License-Identifier: MIT */
#include "http.h"
#include "access.h"
#include "deadlines.h"
#include "linger.h"
#include "listener.h"
#include "server/clock.h"
#include "server/config.h"
#include "server/hub.h"
#include "server/id.h"
#include "server/log.h"
#include "server/resources/routes.h"
#include <dlfcn.h>
#include <microhttpd.h>
#include <poll.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

enum {
    HTTP_THREADS_PER_CORE = 4, /* a thread whose call waits for the disk answers nobody else */
    HTTP_THREADS_MAX = 16,
    HTTP_HEAD_BYTES = 32 * 1024,  /* request line and headers */
    HTTP_POOL_BYTES = 48 * 1024,  /* of a connection: the above, and room for the reply's headers */
    HTTP_BLOCK_BYTES = 16 * 1024, /* asked of a stream at a time */
    HTTP_LARGE_BLOCK_BYTES = 128 * 1024, /* the same when the length is known */
    HTTP_TICK_MS = 10,                   /* the timer looks no more often than this */
    HTTP_REAP_MS = 1000,                 /* and this often for clients that are slow or gone */
    HTTP_FLUSH_MS = 2000                 /* answers under way get this long at the end */
};

struct exchange;

struct http {
    struct http_services services;
    struct MHD_Daemon *daemon;
    int socket;
    struct linger_pool *linger;
    struct deadlines *deadlines;
    atomic_bool draining;
    atomic_int_fast64_t bodies; /* bytes of those that are being received */
    atomic_long exchanges;      /* requests that have begun and are not over */

    pthread_mutex_t lock; /* what is below; taken inside the hub's lock, outside of MHD's own */
    pthread_cond_t changed;
    pthread_t timer;
    bool ticking, stopping;
    struct exchange *suspended; /* a list */
    int64_t wake_at;            /* when the timer looks next */
};

/* A connection. */
struct client {
    struct deadlines_client deadline;
    struct http *http;
    struct exchange *exchange; /* the request under way, or NULL */
};

/* A request, its reply, and how far they are. */
struct exchange {
    struct request *request;
    struct reply reply;
    struct http *http;
    struct client *client;
    struct MHD_Connection *connection;
    const char *target; /* in the library's memory */
    int64_t begun_us;
    int64_t held;              /* bytes of body in `http->bodies` */
    int64_t received;          /* bytes of body, kept or not */
    struct routes_limit limit; /* of them */
    int64_t sent;              /* bytes of a stream */
    bool known;                /* the headers were looked at */
    bool unread;               /* answered before the body was here */
    bool watching;
    struct hub_watch watch;

    bool notified, suspended; /* under the lock; `notified` since the handler was called last */
    bool gone;                /* under the lock: nobody wants the answer any more */
    struct exchange *next, *previous;
};

/* ------------------------------------------------------------------ waiting */

/* With the lock. */
static void resume(struct exchange *exchange) {
    struct http *http = exchange->http;
    exchange->suspended = false;
    *(exchange->previous ? &exchange->previous->next : &http->suspended) = exchange->next;
    if (exchange->next)
        exchange->next->previous = exchange->previous;
    exchange->next = exchange->previous = NULL;
    MHD_resume_connection(exchange->connection);
}

/* Of the hub: the subject has changed. */
static void wake(void *context) {
    struct exchange *exchange = context;
    pthread_mutex_lock(&exchange->http->lock);
    exchange->notified = true;
    if (exchange->suspended)
        resume(exchange);
    pthread_mutex_unlock(&exchange->http->lock);
}

/* Suspends the connection until `wake` or `wake_at`. False when there is no need to: the subject
 * has changed since the handler was called, or the server is stopping. */
static bool suspend(struct exchange *exchange) {
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
        MHD_suspend_connection(exchange->connection);
        if (exchange->request->wake_at < http->wake_at)
            pthread_cond_signal(&http->changed);
    }
    pthread_mutex_unlock(&http->lock);
    return wait;
}

/* With the lock: resumes those whose time has come (all of them at the end); sets when to look
 * next. */
static void resume_due(struct http *http, int64_t now) {
    http->wake_at = INT64_MAX;
    for (struct exchange *exchange = http->suspended, *next; exchange; exchange = next) {
        next = exchange->next;
        int64_t due = exchange->request->wake_at;
        if (due <= now || http->stopping)
            resume(exchange);
        else if (due < http->wake_at)
            http->wake_at = due;
    }
    if (http->wake_at < now + HTTP_TICK_MS)
        http->wake_at = now + HTTP_TICK_MS;
}

/* Whether the client has closed its side of the connection. Most who do are gone, and for the rest
 * there is no telling: as with nginx, who wants the answer must leave its side open. */
static bool hung_up(const struct client *client) {
    struct pollfd side = {client->deadline.socket, POLLRDHUP, 0};
    return poll(&side, 1, 0) == 1;
}

/* With the lock: resumes those whose client is gone, so that their connections end. The library
 * does not look at the socket of one that is suspended. */
static void resume_gone(struct http *http) {
    for (struct exchange *exchange = http->suspended, *next; exchange; exchange = next) {
        next = exchange->next;
        exchange->gone = hung_up(exchange->client);
        if (exchange->gone)
            resume(exchange);
    }
}

static void *timer(void *context) {
    struct http *http = context;
    int64_t reap_at = 0;
    pthread_mutex_lock(&http->lock);
    while (!http->stopping) {
        int64_t now = clock_ms();
        if (now >= reap_at) {
            deadlines_reap(http->deadlines, now);
            resume_gone(http);
            reap_at = now + HTTP_REAP_MS;
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

void http_watch(struct request *request, const char *subject) {
    struct exchange *exchange = request->transport;
    if (exchange->watching)
        return;
    exchange->watching = true;
    hub_subscribe(exchange->http->services.hub, &exchange->watch, subject, wake, exchange);
}

/* Before every call of the routes: what they may want to know, and a fresh start for `notified`.
 * False when there is nobody left to answer. */
static bool refresh(struct exchange *exchange) {
    struct http *http = exchange->http;
    pthread_mutex_lock(&http->lock);
    exchange->notified = false;
    exchange->request->stopping = http->stopping;
    bool gone = exchange->gone;
    pthread_mutex_unlock(&http->lock);
    exchange->request->draining = atomic_load(&http->draining);
    return !gone;
}

/* ------------------------------------------------------------------ refusing */

/* Answers on the socket and lets go of the connection, when the library takes no answer: it has not
 * got the whole request, and will not. */
static void refuse_on_socket(struct client *client, enum api_problem_id problem,
                             const char *detail) {
    struct exchange *exchange = client->exchange;
    char id[ID_SIZE];
    id_make(id);
    int status = reply_on_socket(client->deadline.socket,
                                 exchange && exchange->request->id[0] ? exchange->request->id : id,
                                 problem, detail);
    linger_add(client->http->linger, client->deadline.socket);
    shutdown(client->deadline.socket, SHUT_WR);
    if (exchange)
        exchange->reply.status = status;
    else
        routes_count(NULL, status, 0);
}

/* What the library cannot read it answers by itself, with a page of its own. */
static void refuse_for_library(struct client *client, unsigned status) {
    bool body = client->exchange && client->exchange->known;
    switch (status) {
    case 413:
        refuse_on_socket(client, API_TOO_LARGE,
                         body ? "a chunk of the body is too large" : "the body is too large");
        break;
    case 414:
        refuse_on_socket(client, API_TARGET_TOO_LONG, "the request line does not fit");
        break;
    case 431:
        refuse_on_socket(client, API_HEADERS_TOO_LARGE, "the headers do not fit");
        break;
    case 500:
        refuse_on_socket(client, API_UNAVAILABLE, "there is no memory for the request now");
        break;
    case 505:
        refuse_on_socket(client, API_HTTP_VERSION, "the request is of another version of HTTP");
        break;
    default:
        refuse_on_socket(client, API_BAD_REQUEST,
                         body ? "the chunks of the body are malformed"
                              : "the request line or a header is malformed");
    }
}

static struct client *client_of(struct MHD_Connection *connection) {
    const union MHD_ConnectionInfo *info =
        MHD_get_connection_info(connection, MHD_CONNECTION_INFO_SOCKET_CONTEXT);
    return info ? info->socket_context : NULL;
}

typedef enum MHD_Result queue_function(struct MHD_Connection *connection, unsigned status,
                                       struct MHD_Response *response);
static queue_function *queue_response; /* the library's */

static bool find_queue_response(void) {
    *(void **)&queue_response = dlsym(RTLD_NEXT, "MHD_queue_response");
    return queue_response != NULL;
}

/* The library queues those pages by this public function of its own, but finds ours, which comes
 * first in the order of linking. Its page is queued nevertheless, though it cannot be sent any
 * more: when that fails, 0.9.75 frees the request and then goes on to parse it. */
enum MHD_Result MHD_queue_response(struct MHD_Connection *connection, unsigned status,
                                   struct MHD_Response *response) {
    struct client *client = client_of(connection);
    if (client)
        refuse_for_library(client, status);
    return queue_response(connection, status, response);
}

/* ------------------------------------------------------------------ answering */

/* The next bytes of a streamed reply. Zero is only returned with the connection suspended. */
static ssize_t pull(void *context, uint64_t position, char *buffer, size_t size) {
    struct exchange *exchange = context;
    struct deadlines *deadlines = exchange->http->deadlines;
    (void)position;
    for (;;) {
        if (!refresh(exchange))
            return MHD_CONTENT_READER_END_WITH_ERROR;
        deadlines_suspend(deadlines, &exchange->client->deadline);
        ssize_t got = exchange->reply.stream.next(exchange->reply.stream.context, buffer, size);
        if (got > 0) {
            exchange->sent += got;
            deadlines_reply(deadlines, &exchange->client->deadline, (size_t)got);
            return got;
        }
        if (got != REPLY_WAIT)
            return got == REPLY_END ? MHD_CONTENT_READER_END_OF_STREAM
                                    : MHD_CONTENT_READER_END_WITH_ERROR;
        if (suspend(exchange))
            return 0;
    }
}

static size_t block_of(const struct reply *reply) {
    if (reply->stream.block)
        return reply->stream.block;
    return reply->length ? HTTP_LARGE_BLOCK_BYTES : HTTP_BLOCK_BYTES;
}

static struct MHD_Response *make_response(struct exchange *exchange) {
    struct reply *reply = &exchange->reply;
    if (reply->streamed)
        return MHD_create_response_from_callback(reply->length ? reply->length : MHD_SIZE_UNKNOWN,
                                                 block_of(reply), pull, exchange, NULL);
    const char *bytes = reply->body ? reply->body : reply->literal;
    /* The bytes live as long as the exchange, and are not written to in spite of the type. */
    return MHD_create_response_from_buffer(reply->length, (void *)(uintptr_t)bytes,
                                           MHD_RESPMEM_PERSISTENT);
}

static enum MHD_Result send_reply(struct exchange *exchange) {
    struct reply *reply = &exchange->reply;
    access_cors(&exchange->http->services, exchange->request, reply);
    struct MHD_Response *response =
        deadlines_reply(exchange->http->deadlines, &exchange->client->deadline,
                        reply->streamed ? 0 : reply->length)
            ? make_response(exchange)
            : NULL;
    if (!response)
        return MHD_NO;
    for (size_t k = 0; k < reply->header_count; k++)
        MHD_add_response_header(response, reply->headers[k].name, reply->headers[k].value);
    MHD_add_response_header(response, "X-Request-Id", exchange->request->id);
    MHD_add_response_header(response, "X-Content-Type-Options", "nosniff");
    if (exchange->unread || atomic_load(&exchange->http->draining))
        MHD_add_response_header(response, "Connection", "close");
    enum MHD_Result result =
        queue_response(exchange->connection, (unsigned)reply->status, response);
    MHD_destroy_response(response);
    return result;
}

/* Asks the routes until there is an answer or a reason to wait. */
static enum MHD_Result answer(struct exchange *exchange) {
    for (;;) {
        if (!refresh(exchange))
            return MHD_NO;
        const struct http_services *services = &exchange->http->services;
        if (routes_handle(services, exchange->request, &exchange->reply) == ROUTES_DONE)
            return send_reply(exchange);
        if (suspend(exchange))
            return MHD_YES;
    }
}

/* ------------------------------------------------------------------ receiving */

/* A walk along the head as it lies in memory. */
struct head_walk {
    struct request *request;
    const char *last; /* the value, or version, before */
};

static enum MHD_Result take_header(void *context, enum MHD_ValueKind kind, const char *name,
                                   const char *value) {
    struct head_walk *walk = context;
    (void)kind;
    value = value ? value : name + strlen(name);
    request_add_header(walk->request, name, value);
    request_check_gap(walk->request, walk->last, strlen(walk->last), name, 2);
    walk->last = value;
    return MHD_YES;
}

/* The headers, and that there is nothing between the parts of the head that is in none of them. */
static void take_head(struct exchange *exchange, const char *version, size_t size) {
    struct request *request = exchange->request;
    struct head_walk walk = {.request = request, .last = version};
    const char *method = request->method;
    request_check_gap(request, method, strlen(method), exchange->target, 1);
    request_check_gap(request, exchange->target, strlen(request->target), version, 1);
    MHD_get_connection_values(exchange->connection, MHD_HEADER_KIND, take_header, &walk);
    request_check_gap(request, walk.last, strlen(walk.last), method + size, 4);
}

static void refuse_size(struct exchange *exchange) {
    reply_refuse(&exchange->reply, exchange->request->id, API_TOO_LARGE,
                 "the body is over the limit of %lld bytes (--%s)",
                 (long long)exchange->limit.bytes, exchange->limit.flag);
}

static bool bodies_fit(struct http *http, int64_t more) {
    return (int64_t)atomic_load(&http->bodies) + more <= http->services.config->max_bodies;
}

static void refuse_bodies(struct exchange *exchange) {
    reply_header(&exchange->reply, "Retry-After", "1");
    reply_refuse(&exchange->reply, exchange->request->id, API_UNAVAILABLE,
                 "too many bodies are being received at the moment (--max-bodies)");
}

/* Keeps a piece of the body. What is not sent yet takes no memory and counts for nothing, or slow
 * clients could keep others away by announcements. */
static void keep(struct exchange *exchange, const char *bytes, size_t length) {
    if (!bodies_fit(exchange->http, (int64_t)length)) {
        refuse_bodies(exchange);
    } else if (!request_append_body(exchange->request, bytes, length)) {
        reply_refuse(&exchange->reply, exchange->request->id, API_UNAVAILABLE,
                     "there is no memory for the body now");
    } else {
        atomic_fetch_add(&exchange->http->bodies, (int_fast64_t)length);
        exchange->held += (int64_t)length;
    }
}

/* With all headers: sets the reply if it is clear already. True when it cannot wait for the rest of
 * the message: its end is unknown, or the client had better not send it. */
static bool screen(struct exchange *exchange) {
    struct request *request = exchange->request;
    int64_t length;
    request_check_framing(request);
    request_choose_id(request);
    bool has_body = request_has_body(request, &length);
    bool passed = refresh(exchange) && !request->fault[0] &&
                  !routes_screen(&exchange->http->services, request, &exchange->reply);
    exchange->limit = routes_limit(&exchange->http->services, request);
    bool large = length > exchange->limit.bytes;
    if (request->fault[0])
        reply_refuse(&exchange->reply, request->id, API_BAD_REQUEST, "%s", request->fault);
    else if (passed && large)
        refuse_size(exchange);
    else if (passed && length > 0 && !bodies_fit(exchange->http, length))
        refuse_bodies(exchange);
    bool refused = exchange->reply.status != 0;
    return refused &&
           (request->fault[0] || (has_body && (large || request_expects_continue(request))));
}

/* With all headers. */
static enum MHD_Result begin(struct exchange *exchange, const char *method, const char *version) {
    struct request *request = exchange->request;
    exchange->known = true;
    request->method = method;
    request->http_1_0 = !strcmp(version, "HTTP/1.0");
    const union MHD_ConnectionInfo *info =
        MHD_get_connection_info(exchange->connection, MHD_CONNECTION_INFO_REQUEST_HEADER_SIZE);
    if (!info || !deadlines_body(exchange->http->deadlines, &exchange->client->deadline))
        return MHD_NO;
    take_head(exchange, version, info->header_size);
    if (info->header_size > HTTP_HEAD_BYTES) {
        refuse_for_library(exchange->client, strlen(request->target) < HTTP_HEAD_BYTES ? 431 : 414);
        return MHD_NO;
    }
    if (!screen(exchange))
        return MHD_YES;
    exchange->unread = true;
    return send_reply(exchange);
}

/* A piece of the body; that of a request which is refused already is dropped. Without a
 * Content-Length only here it turns out to be over the limit. */
static enum MHD_Result receive(struct exchange *exchange, const char *bytes, size_t length) {
    struct reply *reply = &exchange->reply;
    exchange->received += (int64_t)length;
    if (!deadlines_received(exchange->http->deadlines, &exchange->client->deadline, length))
        return MHD_NO;
    if (exchange->received > exchange->limit.bytes) {
        char detail[64];
        snprintf(detail, sizeof detail, "the body is over the limit (--%s)", exchange->limit.flag);
        refuse_on_socket(exchange->client, API_TOO_LARGE, detail);
        return MHD_NO;
    }
    if (!reply->status)
        keep(exchange, bytes, length);
    return MHD_YES;
}

/* MHD's access handler: once with the headers, once for each piece of body, once at the end, and
 * again after each suspension. */
static enum MHD_Result handle(void *context, struct MHD_Connection *connection, const char *url,
                              const char *method, const char *version, const char *data,
                              size_t *size, void **state) {
    struct exchange *exchange = *state;
    (void)context, (void)url;
    (void)connection;
    if (!exchange)
        return MHD_NO; /* no memory when the request began */
    if (!exchange->known)
        return begin(exchange, method, version);
    if (*size) {
        size_t length = *size;
        *size = 0;
        return receive(exchange, data, length);
    }
    if (!deadlines_suspend(exchange->http->deadlines, &exchange->client->deadline))
        return MHD_NO;
    return exchange->reply.status ? send_reply(exchange) : answer(exchange);
}

/* ------------------------------------------------------------------ beginnings and ends */

static void log_access(const struct exchange *exchange) {
    const struct request *request = exchange->request;
    int64_t bytes = exchange->reply.streamed ? exchange->sent : (int64_t)exchange->reply.length;
    enum log_level level = routes_quiet(request) ? LOG_LEVEL_DEBUG : LOG_LEVEL_INFO;
    log_write(level,
              LOG_FIELDS(log_event("request"), log_text("request_id", request->id),
                         log_text("caller", request->caller), log_text("method", request->method),
                         log_text("target", request->target),
                         log_int("status", exchange->reply.status),
                         log_int("received", exchange->received), log_int("sent", bytes),
                         log_real("ms", (double)(clock_us() - exchange->begun_us) / 1e3)));
}

static void finish(struct exchange *exchange) {
    struct http *http = exchange->http;
    exchange->client->exchange = NULL;
    if (exchange->watching)
        hub_unsubscribe(http->services.hub, &exchange->watch);
    atomic_fetch_sub(&http->bodies, (int_fast64_t)exchange->held);
    routes_count(exchange->request, exchange->reply.status, clock_us() - exchange->begun_us);
    if (exchange->known)
        log_access(exchange);
    reply_clear(&exchange->reply);
    request_free(exchange->request);
    free(exchange);
    atomic_fetch_sub(&http->exchanges, 1);
}

/* MHD's first and last word of a connection. */
static void connection_notified(void *context, struct MHD_Connection *connection, void **state,
                                enum MHD_ConnectionNotificationCode code) {
    struct http *http = context;
    struct client *client = *state;
    if (code == MHD_CONNECTION_NOTIFY_STARTED) {
        const union MHD_ConnectionInfo *info =
            MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CONNECTION_FD);
        *state = client = info ? calloc(1, sizeof *client) : NULL;
        if (!client)
            return; /* its requests will be refused */
        client->http = http;
        deadlines_add(http->deadlines, &client->deadline, info->connect_fd);
    } else if (client) {
        if (client->exchange)
            finish(client->exchange); /* MHD forgets it when the query overflows its memory */
        deadlines_remove(http->deadlines, &client->deadline);
        free(client);
    }
}

/* MHD's first word of a request: the target as it was sent. */
static void *request_begins(void *context, const char *target, struct MHD_Connection *connection) {
    struct http *http = context;
    struct client *client = client_of(connection);
    struct exchange *exchange = client ? calloc(1, sizeof *exchange) : NULL;
    struct request *request = exchange ? request_new(target) : NULL;
    if (!request) {
        free(exchange);
        return NULL;
    }
    exchange->request = request;
    exchange->http = http;
    exchange->client = client;
    exchange->connection = connection;
    exchange->target = target;
    exchange->begun_us = clock_us();
    request->transport = exchange;
    client->exchange = exchange;
    atomic_fetch_add(&http->exchanges, 1);
    return exchange;
}

/* MHD's last word of a request, whichever way it ended. */
static void request_ends(void *context, struct MHD_Connection *connection, void **state,
                         enum MHD_RequestTerminationCode code) {
    struct http *http = context;
    struct exchange *exchange = *state;
    (void)connection;
    *state = NULL;
    if (!exchange)
        return;
    if (exchange->unread && code == MHD_REQUEST_TERMINATED_COMPLETED_OK)
        linger_add(http->linger, exchange->client->deadline.socket);
    deadlines_idle(http->deadlines, &exchange->client->deadline);
    finish(exchange);
}

/* What the library says about broken clients. */
static void log_library(void *context, const char *format, va_list arguments) {
    (void)context;
    char text[256];
    vsnprintf(text, sizeof text, format, arguments);
    text[strcspn(text, "\n")] = '\0';
    log_debug(log_event("microhttpd"), log_text("message", text));
}

/* ------------------------------------------------------------------ start and stop */

static bool start_timer(struct http *http) {
    pthread_condattr_t monotonic;
    pthread_condattr_init(&monotonic);
    pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC);
    pthread_mutex_init(&http->lock, NULL);
    pthread_cond_init(&http->changed, &monotonic);
    pthread_condattr_destroy(&monotonic);
    return pthread_create(&http->timer, NULL, timer, http) == 0;
}

/* More than the cores: submits that come in while a commit waits for the disk share the next one.
 * Never more than the least --max-connections, which are divided among them. */
static unsigned thread_count(void) {
    long cores = sysconf(_SC_NPROCESSORS_ONLN);
    long threads = cores < 1 ? 1 : cores * HTTP_THREADS_PER_CORE;
    return threads < HTTP_THREADS_MAX ? (unsigned)threads : HTTP_THREADS_MAX;
}

static bool start_daemon(struct http *http) {
    unsigned connections = (unsigned)http->services.config->max_connections;
    unsigned flags =
        MHD_USE_EPOLL_INTERNAL_THREAD | MHD_USE_ITC | MHD_ALLOW_SUSPEND_RESUME | MHD_USE_ERROR_LOG;
    http->daemon = MHD_start_daemon(
        flags, 0, NULL, NULL, handle, http, MHD_OPTION_EXTERNAL_LOGGER, log_library, NULL,
        MHD_OPTION_LISTEN_SOCKET, http->socket, MHD_OPTION_THREAD_POOL_SIZE, thread_count(),
        MHD_OPTION_CONNECTION_LIMIT, connections, MHD_OPTION_CONNECTION_TIMEOUT,
        (unsigned)DEADLINES_IDLE_MS / 1000, MHD_OPTION_CONNECTION_MEMORY_LIMIT,
        (size_t)HTTP_POOL_BYTES, MHD_OPTION_NOTIFY_CONNECTION, connection_notified, http,
        MHD_OPTION_URI_LOG_CALLBACK, request_begins, http, MHD_OPTION_NOTIFY_COMPLETED,
        request_ends, http, MHD_OPTION_END);
    return http->daemon != NULL;
}

bool http_start(const struct http_services *services, struct http **out) {
    struct http *http = calloc(1, sizeof *http);
    if (!http)
        return false;
    http->services = *services;
    http->socket = listener_open(services->config);
    http->linger = linger_start();
    http->deadlines = deadlines_new();
    http->ticking = http->deadlines && start_timer(http);
    bool listening = http->socket >= 0;
    if (listening && http->linger && http->ticking && find_queue_response() && start_daemon(http)) {
        *out = http;
        return true;
    }
    if (listening)
        log_error(log_event("http_failed"), log_text("error", "threads cannot be started"));
    http_stop(http);
    return false;
}

uint16_t http_port(const struct http *http) {
    return listener_port(http->socket);
}

void http_touch(struct http *http) {
    pthread_mutex_lock(&http->lock);
    pthread_mutex_unlock(&http->lock);
}

void http_drain(struct http *http) {
    if (atomic_exchange(&http->draining, true))
        return;
    MHD_quiesce_daemon(http->daemon);
    /* Who calls now is refused at once. Closing has to wait for MHD's threads, which may be about
     * to use the descriptor. A socket of the service manager's keeps callers for the next daemon.
     */
    if (http->services.config->inherited < 0)
        shutdown(http->socket, SHUT_RDWR);
}

static void stop_timer(struct http *http) {
    pthread_mutex_lock(&http->lock);
    http->stopping = true;
    pthread_cond_signal(&http->changed);
    pthread_mutex_unlock(&http->lock);
    pthread_join(http->timer, NULL);
}

static void stop_daemon(struct http *http) {
    http_drain(http);
    int64_t until = clock_ms() + HTTP_FLUSH_MS;
    while (atomic_load(&http->exchanges) > 0 && clock_ms() < until)
        nanosleep(&(struct timespec){0, HTTP_TICK_MS * 1000000}, NULL);
    MHD_stop_daemon(http->daemon);
}

void http_stop(struct http *http) {
    if (!http)
        return;
    if (http->ticking)
        stop_timer(http);
    if (http->daemon)
        stop_daemon(http);
    linger_stop(http->linger);
    deadlines_free(http->deadlines);
    if (http->socket >= 0)
        close(http->socket);
    pthread_cond_destroy(&http->changed);
    pthread_mutex_destroy(&http->lock);
    free(http);
}
