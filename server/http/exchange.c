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

static ssize_t read_stream(struct exchange *exchange, char *buffer, size_t size) {
    const struct reply_stream *stream = &exchange->reply.stream;
    int64_t begun = clock_us();
    ssize_t got = stream->next(stream->context, buffer, size);
    slow_calls_note(exchange->http->slow_calls, SLOW_CALLS_READS, clock_us() - begun);
    return got;
}

/* The next bytes of a streamed reply. Zero is only returned with the connection suspended: it
 * waits, or `slow_calls` fetches the next piece, since looking for it has become slow. */
static ssize_t next_bytes(void *context, uint64_t position, char *buffer, size_t size) {
    struct exchange *exchange = context;
    struct http *http = exchange->http;
    struct deadlines_client *deadline = &exchange->client->deadline;
    (void)position;
    for (;;) {
        bool fetched = exchange->ahead.bytes != NULL;
        if (!fetched && !suspension_refresh(exchange))
            return MHD_CONTENT_READER_END_WITH_ERROR;
        deadlines_turn(http->deadlines, deadline, DEADLINES_OURS, 0);
        if (!fetched && slow_calls_are_slow(http->slow_calls, SLOW_CALLS_READS)) {
            exchange->ahead.bytes = malloc(size);
            exchange->ahead.used = size;
            if (exchange->ahead.bytes && suspension_hand_over(exchange, SLOW_CALLS_READS))
                return 0;
            free(exchange->ahead.bytes);
            exchange->ahead.bytes = NULL;
        }
        ssize_t got = fetched ? exchange->ahead.length : read_stream(exchange, buffer, size);
        if (fetched && got > 0) {
            got -= (ssize_t)exchange->ahead.used;
            got = (size_t)got < size ? got : (ssize_t)size;
            memcpy(buffer, exchange->ahead.bytes + exchange->ahead.used, (size_t)got);
            exchange->ahead.used += (size_t)got;
        }
        if (fetched && (ssize_t)exchange->ahead.used >= exchange->ahead.length) {
            free(exchange->ahead.bytes);
            exchange->ahead.bytes = NULL;
        }
        if (got > 0) {
            exchange->sent += got;
            deadlines_turn(http->deadlines, deadline, DEADLINES_REPLY, (size_t)got);
            return got;
        }
        if (got != REPLY_WAIT)
            return got == REPLY_END ? MHD_CONTENT_READER_END_OF_STREAM
                                    : MHD_CONTENT_READER_END_WITH_ERROR;
        if (suspension_begin(exchange))
            return 0;
    }
}

/* The bytes of the reply live as long as the exchange, and are not written to in spite of the type.
 */
static bool send_reply(struct exchange *exchange) {
    struct http *http = exchange->http;
    struct reply *reply = &exchange->reply;
    const char *bytes = reply->body ? reply->body : reply->literal;
    size_t block = reply->stream.block ? reply->stream.block
                   : reply->length     ? LARGE_BLOCK_BYTES
                                       : BLOCK_BYTES;
    origin_share(http->settings.config, exchange->request, reply);
    if (!deadlines_turn(http->deadlines, &exchange->client->deadline, DEADLINES_REPLY,
                        reply->streamed ? 0 : reply->length))
        return false;
    struct MHD_Response *response =
        reply->streamed
            ? MHD_create_response_from_callback(reply->length ? reply->length : MHD_SIZE_UNKNOWN,
                                                block, next_bytes, exchange, NULL)
            : MHD_create_response_from_buffer(reply->length, (void *)(uintptr_t)bytes,
                                              MHD_RESPMEM_PERSISTENT);
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

/* Asks the handler. True when it has to wait: the exchange is not this thread's any more. */
static bool ask_handler(struct exchange *exchange) {
    const struct http_handler *handler = &exchange->http->settings.handler;
    int64_t begun = clock_us();
    enum http_next next = handler->handle(handler->context, exchange->request, &exchange->reply);
    slow_calls_note(exchange->http->slow_calls, exchange->kind, clock_us() - begun);
    return next == HTTP_WAIT && suspension_begin(exchange);
}

void exchange_attend(struct exchange *exchange) {
    char *bytes = exchange->ahead.bytes;
    size_t size = exchange->ahead.used;
    ssize_t got = REPLY_BROKEN;
    if (!exchange->reply.status) {
        while (!exchange->reply.status && suspension_refresh(exchange))
            if (ask_handler(exchange))
                return;
        suspension_return(exchange);
        return;
    }
    /* the next piece of the stream */
    exchange->ahead.used = 0;
    while (suspension_refresh(exchange) &&
           (got = read_stream(exchange, bytes, size)) == REPLY_WAIT) {
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

/* ------------------------------------------------------------------ the head */

static enum MHD_Result take_header(void *context, enum MHD_ValueKind kind, const char *name,
                                   const char *value) {
    (void)kind;
    request_add_header(context, name, value ? value : "");
    return MHD_YES;
}

/* 429 for what the owner has as much of as it may: its bound, `most`, or what is left to others. */
static void refuse_quota(struct reply *reply, const char *what, int64_t wants, const char *flag,
                         int64_t most, const char *all) {
    if (wants > most)
        reply_refuse_for(reply, 1, API_QUOTA,
                         "you have as many %s as one owner may have: %lld (--%s)", what,
                         (long long)most, flag);
    else
        reply_refuse_for(reply, 1, API_QUOTA,
                         "you have as many %s as are still free, and these are kept for others "
                         "(--%s): try again later",
                         what, all);
}

static void refuse_bodies(struct reply *reply) {
    reply_refuse_for(reply, 1, API_UNAVAILABLE,
                     "too many request bodies are being received now (--max-bodies): try again");
}

bool http_take_stream(struct request *request, struct reply *reply) {
    struct exchange *exchange = request->transport;
    struct quotas *quotas = exchange->http->quotas;
    int64_t most = exchange->http->settings.config->owner_streams;
    if (!exchange->streams)
        exchange->streams = quotas_take(quotas, request->owner, QUOTAS_STREAMS, 1, most);
    if (!exchange->streams)
        refuse_quota(reply, "event streams and waiting calls",
                     quotas_of(quotas, request->owner, QUOTAS_STREAMS) + 1, "owner-streams", most,
                     "max-connections");
    return exchange->streams;
}

/* Sets the reply if it is clear from the head. True when it cannot wait for the rest of the
 * message: its end is unknown, or the client had better not send it. On a connection in reserve
 * only probes are answered. */
static bool check_request_head(struct exchange *exchange) {
    const struct http_handler *handler = &exchange->http->settings.handler;
    const struct admission_client *admission = &exchange->client->admission;
    struct quotas *quotas = exchange->http->quotas;
    struct request *request = exchange->request;
    struct reply *reply = &exchange->reply;
    const char *coding = request_header(request, "Content-Encoding");
    const char *expect = request_header(request, "Expect");
    int64_t length;
    bool has_body = request_has_body(request, &length);
    bool good = suspension_refresh(exchange) && !request->fault[0] &&
                !handler->check_head(handler->context, request, reply);
    bool large = length > request->limit.bytes;
    bool reserved = admission->how != ADMISSION_SERVED && !request->quiet;
    if (request->fault[0]) {
        reply_refuse(reply, API_BAD_REQUEST, "%s", request->fault);
    } else if (good && reserved && admission->how == ADMISSION_OWNER_FULL) {
        refuse_quota(reply, "connections from your address",
                     quotas_of(quotas, admission->owner, QUOTAS_CONNECTIONS) + 1,
                     "owner-connections", exchange->http->settings.config->owner_connections,
                     "max-connections");
    } else if (good && reserved) {
        reply_refuse_for(reply, 1, API_UNAVAILABLE,
                         "all connections are in use (--max-connections): try again");
    } else if (good && has_body && coding && strcasecmp(coding, "identity") != 0) {
        reply_header(reply, "Accept-Encoding", "identity");
        reply_refuse(reply, API_UNSUPPORTED_MEDIA_TYPE,
                     "the body must be sent without Content-Encoding");
    } else if (good && large) {
        reply_refuse(reply, API_TOO_LARGE, "the body is over the limit of %lld bytes (--%s)",
                     (long long)request->limit.bytes, request->limit.flag);
    } else if (good && length > 0 && length > quotas_left(quotas, QUOTAS_BODIES)) {
        refuse_bodies(reply);
    }
    return reply->status &&
           (request->fault[0] ||
            (has_body && (large || reserved || (expect && !strcasecmp(expect, "100-continue")))));
}

/* ------------------------------------------------------------------ the body */

/* A piece of the body; that of a request which is refused already is dropped. Without a
 * Content-Length only here it turns out to be over the limit. It takes room of the owner's quota,
 * of which the only body may be more, and of all; what is not sent yet takes no memory and counts
 * for nothing, or slow clients could keep others away by announcements. */
static bool receive_body(struct exchange *exchange, const char *bytes, size_t length) {
    const struct request_limit *limit = &exchange->request->limit;
    const char *owner = exchange->request->owner;
    struct quotas *quotas = exchange->http->quotas;
    int64_t most = exchange->http->settings.config->owner_bodies, more = (int64_t)length;
    exchange->received += more;
    if (!deadlines_turn(exchange->http->deadlines, &exchange->client->deadline, DEADLINES_RECEIVED,
                        length))
        return false;
    if (exchange->received > limit->bytes) {
        char detail[64];
        snprintf(detail, sizeof detail, "the body is over the limit (--%s)", limit->flag);
        client_refuse(exchange->client, API_TOO_LARGE, detail);
        return false;
    }
    if (exchange->reply.status)
        return true;
    bool taken = quotas_take(quotas, owner, QUOTAS_BODIES, more, most) ||
                 quotas_grow(quotas, owner, QUOTAS_BODIES, more, exchange->held);
    exchange->held += taken ? more : 0;
    int64_t held = quotas_of(quotas, owner, QUOTAS_BODIES);
    if (taken && !request_append_body(exchange->request, bytes, length))
        reply_no_memory(&exchange->reply);
    else if (!taken && (held == exchange->held || more > quotas_left(quotas, QUOTAS_BODIES)))
        refuse_bodies(&exchange->reply);
    else if (!taken)
        refuse_quota(&exchange->reply, "bytes of request bodies being received", held + more,
                     "owner-bodies", most, "max-bodies");
    return true;
}

/* ------------------------------------------------------------------ from step to step */

bool exchange_step(struct exchange *exchange, const char *method, const char *version,
                   const char *data, size_t *size) {
    struct http *http = exchange->http;
    struct request *request = exchange->request;
    struct deadlines_client *deadline = &exchange->client->deadline;
    size_t length = *size;
    *size = 0;
    if (exchange->client->refused)
        return false;
    if (!client_checked(exchange->client, exchange->known && !length)) {
        log_error(log_event("unchecked_request"), log_text("request_id", request->id));
        return false;
    }
    if (!exchange->known) {
        /* the head: takes its fields and looks at what is clear from it */
        const struct sockaddr *peer = (const struct sockaddr *)&exchange->client->peer;
        bool reads = !strcmp(method, "GET") || !strcmp(method, "HEAD");
        exchange->known = true;
        exchange->kind = reads ? SLOW_CALLS_READS : SLOW_CALLS_CHANGES;
        request->method = method;
        request->http_1_0 = !strcmp(version, "HTTP/1.0");
        request->limit = (struct request_limit){http->settings.config->max_body, "max-body"};
        MHD_get_connection_values(exchange->connection, MHD_HEADER_KIND, take_header, request);
        request_choose_id(request);
        owner_of_request(http->settings.config->trusted_proxy, peer, request, request->owner);
        request->local = owner_is_local(peer, request);
        admission_busy(http->admissions, &exchange->client->admission, true);
        if (!deadlines_turn(http->deadlines, deadline, DEADLINES_BODY, 0))
            return false;
        exchange->unread = check_request_head(exchange);
        return !exchange->unread || send_reply(exchange);
    }
    if (length)
        return receive_body(exchange, data, length);
    /* the end: asks the handler until there is an answer or a reason to wait, or has `slow_calls`
     * do so; probes are answered here, whatever those threads have to do */
    if (!exchange->complete && !exchange->reply.status && !request_complete_body(request))
        reply_no_memory(&exchange->reply);
    exchange->complete = true;
    if (!deadlines_turn(http->deadlines, deadline, DEADLINES_OURS, 0))
        return false;
    while (!exchange->reply.status) {
        if (!suspension_refresh(exchange))
            return false;
        bool slow = !request->quiet && slow_calls_are_slow(http->slow_calls, exchange->kind);
        if ((slow && suspension_hand_over(exchange, exchange->kind)) || ask_handler(exchange))
            return true;
    }
    return send_reply(exchange);
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

void exchange_end(struct exchange *exchange) {
    struct http *http = exchange->http;
    const struct http_handler *handler = &http->settings.handler;
    const struct request *request = exchange->request;
    const struct reply *reply = &exchange->reply;
    int64_t us = clock_us() - exchange->begun_us;
    exchange->client->exchange = NULL;
    if (exchange->watching)
        job_events_unsubscribe(http->settings.events, &exchange->watch);
    if (exchange->held)
        quotas_give(http->quotas, request->owner, QUOTAS_BODIES, exchange->held);
    if (exchange->streams)
        quotas_give(http->quotas, request->owner, QUOTAS_STREAMS, 1);
    free(exchange->ahead.bytes);
    handler->count(handler->context, request, reply->status, us);
    if (exchange->known)
        log_write(
            request->quiet ? LOG_LEVEL_DEBUG : LOG_LEVEL_INFO,
            LOG_FIELDS(log_event("request"), log_text("request_id", request->id),
                       log_text("caller", request->caller), log_text("method", request->method),
                       log_text("target", request->target), log_int("status", reply->status),
                       log_int("received", exchange->received),
                       log_int("sent", reply->streamed ? exchange->sent : (int64_t)reply->length),
                       log_word("drape", request->drape), log_real("ms", (double)us / 1e3)));
    reply_clear(&exchange->reply);
    request_free(exchange->request);
    free(exchange);
    atomic_fetch_sub(&http->exchanges, 1);
}
