/* SPDX-License-Identifier: MIT */
#include "client.h"
#include "interpose.h"
#include "origin.h"
#include "owner.h"
#include "server/clock.h"
#include "server/config.h"
#include "server/log.h"
#include <microhttpd.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

enum {
    BLOCK_BYTES = 16 * 1024,       /* asked of a stream at a time */
    LARGE_BLOCK_BYTES = 128 * 1024 /* the same when the length is known */
};

/* ------------------------------------------------------------------ sending */

static ssize_t ask_stream(struct exchange *exchange, char *buffer, size_t size) {
    const struct reply_stream *stream = &exchange->reply.stream;
    int64_t begun = clock_us();
    ssize_t got = stream->next(stream->context, buffer, size);
    slow_calls_note(exchange->http->slow_calls, SLOW_CALLS_READS, clock_us() - begun);
    return got;
}

/* Has `slow_calls` fetch the next piece, when looking for it has become slow. True: the exchange is
 * not this thread's any more. */
static bool fetch_elsewhere(struct exchange *exchange, size_t size) {
    if (!slow_calls_are_slow(exchange->http->slow_calls, SLOW_CALLS_READS))
        return false;
    exchange->ahead.bytes = malloc(size);
    exchange->ahead.used = size;
    if (exchange->ahead.bytes && suspension_hand_over(exchange, SLOW_CALLS_READS))
        return true;
    free(exchange->ahead.bytes);
    exchange->ahead.bytes = NULL;
    return false;
}

/* On a thread of `slow_calls`. */
static void fetch(struct exchange *exchange) {
    char *bytes = exchange->ahead.bytes;
    size_t size = exchange->ahead.used;
    ssize_t got = REPLY_BROKEN;
    exchange->ahead.used = 0;
    while (suspension_refresh(exchange) &&
           (got = ask_stream(exchange, bytes, size)) == REPLY_WAIT) {
        exchange->ahead.bytes = NULL;
        if (suspension_begin(exchange)) {
            free(bytes);
            return;
        }
        exchange->ahead.bytes = bytes;
    }
    exchange->ahead.length = got == REPLY_WAIT ? REPLY_BROKEN : got;
    suspension_return(exchange);
}

/* What `next` would have given, of what `slow_calls` has fetched. */
static ssize_t take_fetched(struct exchange *exchange, char *buffer, size_t size) {
    ssize_t left = exchange->ahead.length;
    if (left > 0) {
        left -= (ssize_t)exchange->ahead.used;
        size = (size_t)left < size ? (size_t)left : size;
        memcpy(buffer, exchange->ahead.bytes + exchange->ahead.used, size);
        exchange->ahead.used += size;
    }
    if (left <= (ssize_t)size) {
        free(exchange->ahead.bytes);
        exchange->ahead.bytes = NULL;
    }
    return left > 0 ? (ssize_t)size : left;
}

/* The next bytes of a streamed reply. Zero is only returned with the connection suspended. */
static ssize_t pull(void *context, uint64_t position, char *buffer, size_t size) {
    struct exchange *exchange = context;
    struct deadlines *deadlines = exchange->http->deadlines;
    (void)position;
    for (;;) {
        bool fetched = exchange->ahead.bytes != NULL;
        if (!fetched && !suspension_refresh(exchange))
            return MHD_CONTENT_READER_END_WITH_ERROR;
        deadlines_suspend(deadlines, &exchange->client->deadline);
        if (!fetched && fetch_elsewhere(exchange, size))
            return 0;
        ssize_t got =
            fetched ? take_fetched(exchange, buffer, size) : ask_stream(exchange, buffer, size);
        if (got > 0) {
            exchange->sent += got;
            deadlines_reply(deadlines, &exchange->client->deadline, (size_t)got);
            return got;
        }
        if (got != REPLY_WAIT)
            return got == REPLY_END ? MHD_CONTENT_READER_END_OF_STREAM
                                    : MHD_CONTENT_READER_END_WITH_ERROR;
        if (suspension_begin(exchange))
            return 0;
    }
}

static struct MHD_Response *make_response(struct exchange *exchange) {
    struct reply *reply = &exchange->reply;
    if (reply->streamed) {
        size_t block = reply->stream.block ? reply->stream.block
                       : reply->length     ? LARGE_BLOCK_BYTES
                                           : BLOCK_BYTES;
        return MHD_create_response_from_callback(reply->length ? reply->length : MHD_SIZE_UNKNOWN,
                                                 block, pull, exchange, NULL);
    }
    const char *bytes = reply->body ? reply->body : reply->literal;
    /* The bytes live as long as the exchange, and are not written to in spite of the type. */
    return MHD_create_response_from_buffer(reply->length, (void *)(uintptr_t)bytes,
                                           MHD_RESPMEM_PERSISTENT);
}

static bool send_reply(struct exchange *exchange) {
    struct http *http = exchange->http;
    struct reply *reply = &exchange->reply;
    origin_share(http->settings.config, exchange->request, reply);
    if (!deadlines_reply(http->deadlines, &exchange->client->deadline,
                         reply->streamed ? 0 : reply->length))
        return false;
    struct MHD_Response *response = make_response(exchange);
    if (!response)
        return false;
    for (size_t k = 0; k < reply->header_count; k++)
        MHD_add_response_header(response, reply->headers[k].name, reply->headers[k].value);
    MHD_add_response_header(response, "X-Request-Id", exchange->request->id);
    MHD_add_response_header(response, "X-Content-Type-Options", "nosniff");
    if (exchange->unread || atomic_load(&http->draining) ||
        exchange->client->admission.how != ADMISSION_SERVED)
        MHD_add_response_header(response, "Connection", "close");
    bool queued = interpose_queue(exchange->connection, (unsigned)reply->status, response);
    MHD_destroy_response(response);
    return queued;
}

static enum slow_calls_kind kind_of(const struct request *request) {
    bool reads = !strcmp(request->method, "GET") || !strcmp(request->method, "HEAD");
    return reads ? SLOW_CALLS_READS : SLOW_CALLS_CHANGES;
}

/* Asks the handler. True when it has to wait: the exchange is not this thread's any more. */
static bool ask(struct exchange *exchange) {
    const struct http_handler *handler = &exchange->http->settings.handler;
    struct request *request = exchange->request;
    int64_t begun = clock_us();
    enum http_next next = handler->handle(handler->context, request, &exchange->reply);
    slow_calls_note(exchange->http->slow_calls, kind_of(request), clock_us() - begun);
    return next == HTTP_WAIT && suspension_begin(exchange);
}

void exchange_attend(struct exchange *exchange) {
    if (exchange->reply.status) {
        fetch(exchange);
        return;
    }
    while (!exchange->reply.status && suspension_refresh(exchange))
        if (ask(exchange))
            return;
    suspension_return(exchange);
}

/* With the whole request: asks the handler until there is an answer or a reason to wait, or has the
 * `slow_calls` do so. Probes are answered here, whatever those threads have to do. */
static bool answer(struct exchange *exchange) {
    if (!deadlines_suspend(exchange->http->deadlines, &exchange->client->deadline))
        return false;
    enum slow_calls_kind kind = kind_of(exchange->request);
    while (!exchange->reply.status) {
        if (!suspension_refresh(exchange))
            return false;
        bool slow =
            !exchange->request->quiet && slow_calls_are_slow(exchange->http->slow_calls, kind);
        if ((slow && suspension_hand_over(exchange, kind)) || ask(exchange))
            return true;
    }
    return send_reply(exchange);
}

/* ------------------------------------------------------------------ the head */

static enum MHD_Result take_header(void *context, enum MHD_ValueKind kind, const char *name,
                                   const char *value) {
    (void)kind;
    request_add_header(context, name, value ? value : "");
    return MHD_YES;
}

static bool bodies_fit(struct http *http, int64_t more) {
    return more <= quotas_left(http->quotas, QUOTAS_BODIES);
}

static void refuse_bodies(struct exchange *exchange) {
    reply_header(&exchange->reply, "Retry-After", "1");
    reply_refuse(&exchange->reply, API_UNAVAILABLE,
                 "too many bodies are being received at the moment (--max-bodies)");
}

/* 429 for what the owner has as much of as it may: its bound, `most`, or what is left to others. */
static void refuse_share(struct reply *reply, const char *what, int64_t wants, const char *flag,
                         int64_t most, const char *all) {
    reply_header(reply, "Retry-After", "1");
    if (wants > most)
        reply_refuse(reply, API_QUOTA, "you have as many %s as one owner may: %lld (--%s)", what,
                     (long long)most, flag);
    else
        reply_refuse(reply, API_QUOTA, "you have as many %s as are left to others (--%s)", what,
                     all);
}

/* Of the body that did not fit. */
static void refuse_room(struct exchange *exchange, int64_t more) {
    int64_t held = quotas_of(exchange->http->quotas, exchange->request->owner, QUOTAS_BODIES);
    if (held == exchange->held || !bodies_fit(exchange->http, more))
        refuse_bodies(exchange);
    else
        refuse_share(&exchange->reply, "bytes of bodies on the way", held + more, "owner-bodies",
                     exchange->http->settings.config->owner_bodies, "max-bodies");
}

/* Takes room for more of the body: of the owner's share, of which the only body may be more, and of
 * all. False: the reply says why not. */
static bool take_room(struct exchange *exchange, int64_t more) {
    struct quotas *quotas = exchange->http->quotas;
    const char *owner = exchange->request->owner;
    int64_t most = exchange->http->settings.config->owner_bodies;
    bool taken = quotas_take(quotas, owner, QUOTAS_BODIES, more, most) ||
                 quotas_grow(quotas, owner, QUOTAS_BODIES, more, exchange->held);
    if (taken)
        exchange->held += more;
    else
        refuse_room(exchange, more);
    return taken;
}

bool http_take_stream(struct request *request, struct reply *reply) {
    struct exchange *exchange = request->transport;
    struct quotas *quotas = exchange->http->quotas;
    int64_t most = exchange->http->settings.config->owner_streams;
    if (!exchange->streams)
        exchange->streams = quotas_take(quotas, request->owner, QUOTAS_STREAMS, 1, most);
    if (!exchange->streams)
        refuse_share(reply, "event streams and waiting calls",
                     quotas_of(quotas, request->owner, QUOTAS_STREAMS) + 1, "owner-streams", most,
                     "max-connections");
    return exchange->streams;
}

static void leave_shares(struct exchange *exchange) {
    struct http *http = exchange->http;
    const char *owner = exchange->request->owner;
    if (exchange->held)
        quotas_give(http->quotas, owner, QUOTAS_BODIES, exchange->held);
    if (exchange->streams)
        quotas_give(http->quotas, owner, QUOTAS_STREAMS, 1);
}

/* On a connection in reserve only probes are answered. */
static void refuse_connection(struct exchange *exchange) {
    const struct config *config = exchange->http->settings.config;
    struct reply *reply = &exchange->reply;
    if (exchange->client->admission.how == ADMISSION_OWNER_FULL) {
        refuse_share(reply, "connections from your address",
                     quotas_of(exchange->http->quotas, exchange->client->admission.owner,
                               QUOTAS_CONNECTIONS) +
                         1,
                     "owner-connections", config->owner_connections, "max-connections");
    } else {
        reply_header(reply, "Retry-After", "1");
        reply_refuse(reply, API_UNAVAILABLE, "all connections are taken (--max-connections)");
    }
}

static bool coded(const struct request *request) {
    const char *coding = request_header(request, "Content-Encoding");
    return coding && strcasecmp(coding, "identity") != 0;
}

static void refuse_coding(struct reply *reply) {
    reply_header(reply, "Accept-Encoding", "identity");
    reply_refuse(reply, API_UNSUPPORTED_MEDIA_TYPE,
                 "a request's body is taken as it is, without Content-Encoding");
}

/* Sets the reply if it is clear from the head. True when it cannot wait for the rest of the
 * message: its end is unknown, or the client had better not send it. */
static bool check_request_head(struct exchange *exchange) {
    const struct http_handler *handler = &exchange->http->settings.handler;
    struct request *request = exchange->request;
    struct reply *reply = &exchange->reply;
    int64_t length;
    bool has_body = request_has_body(request, &length);
    bool good = suspension_refresh(exchange) && !request->fault[0] &&
                !handler->check_head(handler->context, request, reply);
    bool large = length > request->limit.bytes;
    bool reserved = exchange->client->admission.how != ADMISSION_SERVED && !request->quiet;
    if (request->fault[0])
        reply_refuse(reply, API_BAD_REQUEST, "%s", request->fault);
    else if (good && reserved)
        refuse_connection(exchange);
    else if (good && has_body && coded(request))
        refuse_coding(reply);
    else if (good && large)
        reply_refuse(reply, API_TOO_LARGE, "the body is over the limit of %lld bytes (--%s)",
                     (long long)request->limit.bytes, request->limit.flag);
    else if (good && length > 0 && !bodies_fit(exchange->http, length))
        refuse_bodies(exchange);
    return reply->status &&
           (request->fault[0] ||
            (has_body && (large || reserved || request_expects_continue(request))));
}

static bool begin(struct exchange *exchange, const char *method, const char *version) {
    struct request *request = exchange->request;
    exchange->known = true;
    request->method = method;
    request->http_1_0 = !strcmp(version, "HTTP/1.0");
    request->limit = (struct request_limit){exchange->http->settings.config->max_body, "max-body"};
    MHD_get_connection_values(exchange->connection, MHD_HEADER_KIND, take_header, request);
    request_choose_id(request);
    owner_of_request(exchange->http->settings.config->trusted_proxy,
                     (const struct sockaddr *)&exchange->client->peer, request, request->owner);
    request->local = owner_is_local((const struct sockaddr *)&exchange->client->peer, request);
    admission_busy(exchange->http->admissions, &exchange->client->admission, true);
    if (!deadlines_body(exchange->http->deadlines, &exchange->client->deadline))
        return false;
    if (!check_request_head(exchange))
        return true;
    exchange->unread = true;
    return send_reply(exchange);
}

/* ------------------------------------------------------------------ the body */

/* Keeps a piece of the body. What is not sent yet takes no memory and counts for nothing, or slow
 * clients could keep others away by announcements. */
static void keep(struct exchange *exchange, const char *bytes, size_t length) {
    if (take_room(exchange, (int64_t)length) &&
        !request_append_body(exchange->request, bytes, length))
        reply_refuse(&exchange->reply, API_UNAVAILABLE, "there is no memory for the body now");
}

/* A piece of the body; that of a request which is refused already is dropped. Without a
 * Content-Length only here it turns out to be over the limit. */
static bool receive(struct exchange *exchange, const char *bytes, size_t length) {
    const struct request_limit *limit = &exchange->request->limit;
    exchange->received += (int64_t)length;
    if (!deadlines_received(exchange->http->deadlines, &exchange->client->deadline, length))
        return false;
    if (exchange->received > limit->bytes) {
        char detail[64];
        snprintf(detail, sizeof detail, "the body is over the limit (--%s)", limit->flag);
        client_refuse(exchange->client, API_TOO_LARGE, detail);
        return false;
    }
    if (!exchange->reply.status)
        keep(exchange, bytes, length);
    return true;
}

bool exchange_step(struct exchange *exchange, const char *method, const char *version,
                   const char *data, size_t *size) {
    size_t length = *size;
    *size = 0;
    if (exchange->client->refused)
        return false;
    if (!client_checked(exchange->client, exchange->known && !length)) {
        log_error(log_event("unchecked_request"), log_text("request_id", exchange->request->id));
        return false;
    }
    if (!exchange->known)
        return begin(exchange, method, version);
    if (length)
        return receive(exchange, data, length);
    if (!exchange->complete && !exchange->reply.status && !request_complete_body(exchange->request))
        reply_refuse(&exchange->reply, API_UNAVAILABLE, "there is no memory for the body now");
    exchange->complete = true;
    return answer(exchange);
}

/* ------------------------------------------------------------------ beginning and end */

struct exchange *exchange_new(struct client *client, struct MHD_Connection *connection,
                              const char *target) {
    struct exchange *exchange = calloc(1, sizeof *exchange);
    struct request *request = exchange ? request_new(target) : NULL;
    if (!request) {
        free(exchange);
        return NULL;
    }
    exchange->request = request;
    exchange->reply.request_id = request->id;
    exchange->http = client->http;
    exchange->client = client;
    exchange->connection = connection;
    exchange->begun_us = clock_us();
    request->transport = exchange;
    client->exchange = exchange;
    atomic_fetch_add(&client->http->exchanges, 1);
    return exchange;
}

static void log_access(const struct exchange *exchange) {
    const struct request *request = exchange->request;
    int64_t bytes = exchange->reply.streamed ? exchange->sent : (int64_t)exchange->reply.length;
    log_write(request->quiet ? LOG_LEVEL_DEBUG : LOG_LEVEL_INFO,
              LOG_FIELDS(log_event("request"), log_text("request_id", request->id),
                         log_text("caller", request->caller), log_text("method", request->method),
                         log_text("target", request->target),
                         log_int("status", exchange->reply.status),
                         log_int("received", exchange->received), log_int("sent", bytes),
                         log_word("drape", request->drape),
                         log_real("ms", (double)(clock_us() - exchange->begun_us) / 1e3)));
}

void exchange_end(struct exchange *exchange) {
    struct http *http = exchange->http;
    const struct http_handler *handler = &http->settings.handler;
    exchange->client->exchange = NULL;
    if (exchange->watching)
        job_events_unsubscribe(http->settings.events, &exchange->watch);
    leave_shares(exchange);
    free(exchange->ahead.bytes);
    handler->count(handler->context, exchange->request, exchange->reply.status,
                   clock_us() - exchange->begun_us);
    if (exchange->known)
        log_access(exchange);
    reply_clear(&exchange->reply);
    request_free(exchange->request);
    free(exchange);
    atomic_fetch_sub(&http->exchanges, 1);
}
