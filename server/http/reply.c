/* SPDX-License-Identifier: MIT */
#include "reply.h"
#include "server/metrics.h"
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>

/* The problem when there is no memory for another. */
static const char no_memory[] = "{\"type\": \"/problems/internal\", \"title\": \"The service "
                                "failed\", \"status\": 500, \"detail\": \"out of memory\"}";

void reply_clear(struct reply *reply) {
    free(reply->body);
    if (reply->streamed && reply->stream.free)
        reply->stream.free(reply->stream.context);
    memset(reply, 0, sizeof *reply);
}

void reply_header(struct reply *reply, const char *name, const char *format, ...) {
    if (reply->header_count == REPLY_HEADERS_MAX)
        return;
    struct reply_header *header = &reply->headers[reply->header_count];
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(header->value, sizeof header->value, format, arguments);
    va_end(arguments);
    if (length < 0 || (size_t)length >= sizeof header->value)
        return;
    for (const char *c = header->value; *c; c++)
        if ((unsigned char)*c < ' ' || *c == 0x7f)
            return;
    header->name = name;
    reply->header_count++;
}

bool reply_has_header(const struct reply *reply, const char *name) {
    for (size_t k = 0; k < reply->header_count; k++)
        if (!strcmp(reply->headers[k].name, name))
            return true;
    return false;
}

/* Drops an earlier body; headers stay. */
static void set_body(struct reply *reply, int status, const char *type) {
    free(reply->body);
    reply->body = NULL;
    reply->status = status;
    if (type)
        reply_header(reply, "Content-Type", "%s", type);
}

void reply_text(struct reply *reply, int status, const char *type, char *text) {
    if (!text) {
        reply_literal(reply, 500, "application/problem+json", no_memory, sizeof no_memory - 1);
        return;
    }
    reply_bytes(reply, status, type, text, strlen(text));
}

void reply_bytes(struct reply *reply, int status, const char *type, char *bytes, size_t length) {
    set_body(reply, status, type);
    reply->body = bytes;
    reply->length = length;
}

void reply_literal(struct reply *reply, int status, const char *type, const char *text,
                   size_t length) {
    set_body(reply, status, type);
    reply->literal = text;
    reply->length = length;
}

void reply_empty(struct reply *reply, int status) {
    set_body(reply, status, NULL);
}

void reply_stream(struct reply *reply, int status, const char *type, struct reply_stream stream,
                  size_t length) {
    set_body(reply, status, type);
    reply->length = length;
    reply->streamed = true;
    reply->stream = stream;
}

void reply_problem(struct reply *reply, const struct api_problem *problem) {
    metrics_refuse(problem->id);
    reply_text(reply, api_problem_status(problem->id), "application/problem+json",
               api_problem_json(problem, reply->request_id));
}

static void refuse_with(struct reply *reply, enum api_problem_id problem, const char *detail,
                        va_list arguments) {
    struct api_problem refusal = {0};
    char text[API_DETAIL_MAX];
    vsnprintf(text, sizeof text, detail, arguments);
    api_problem_set(&refusal, problem, "%s", text);
    reply_problem(reply, &refusal);
}

void reply_refuse(struct reply *reply, enum api_problem_id problem, const char *detail, ...) {
    va_list arguments;
    va_start(arguments, detail);
    refuse_with(reply, problem, detail, arguments);
    va_end(arguments);
}

void reply_refuse_for(struct reply *reply, int seconds, enum api_problem_id problem,
                      const char *detail, ...) {
    va_list arguments;
    va_start(arguments, detail);
    reply_header(reply, "Retry-After", "%d", seconds);
    refuse_with(reply, problem, detail, arguments);
    va_end(arguments);
}

void reply_no_memory(struct reply *reply) {
    reply_refuse(reply, API_UNAVAILABLE, "there is no memory for this now: try again");
}

int reply_on_socket(int socket, const char *request_id, enum api_problem_id problem,
                    const char *detail) {
    struct reply reply = {.request_id = request_id};
    char *message = NULL;
    reply_refuse(&reply, problem, "%s", detail);
    int length = asprintf(&message,
                          "HTTP/1.1 %d %s\r\nContent-Type: application/problem+json\r\n"
                          "Content-Length: %zu\r\nConnection: close\r\nX-Request-Id: %s\r\n\r\n%s",
                          reply.status, api_problem_title(problem), reply.length, request_id,
                          reply.body ? reply.body : reply.literal);
    if (length > 0 && send(socket, message, (size_t)length, MSG_NOSIGNAL | MSG_DONTWAIT) < 0)
        length = 0; /* the client is gone, or takes nothing in */
    if (length >= 0)
        free(message);
    int status = reply.status;
    reply_clear(&reply);
    return status;
}
