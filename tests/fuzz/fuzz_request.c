/* SPDX-License-Identifier: MIT */
/* A whole request as the front hands it on, from its first line to the last byte of its answer:
 * METHOD TARGET VERSION, headers (NAME:VALUE), a line each, an empty line, the body. In the target
 * {drape} and {surface} stand for the ids of those that are stored. */
#include "fuzz.h"

#include "server/config.h"
#include "server/http/negotiate.h"
#include "server/http/origin.h"
#include "server/resources/routes.h"
#include "service.h"
#include <jansson.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum { CALLS = 10 }; /* a small map is ready by then; a drape never will be: nobody works */

/* Of the front, for handlers that wait. Here they are called again without being told. */
void http_watch(struct request *request, const char *subject, enum job_event least) {
    (void)request, (void)subject, (void)least;
}

bool http_take_stream(struct request *request, struct reply *reply) {
    (void)request, (void)reply;
    return true;
}

static void expect_printable(const char *text) {
    for (; *text; text++)
        FUZZ_PROMISE(*text > ' ' && *text < 0x7f);
}

/* ------------------------------------------------------------------ the head */

static void read_headers(const struct request *request) {
    for (size_t k = 0; k < request->header_count; k++) {
        const char *value = request->headers[k].value;
        int64_t number;
        int quality = negotiate_quality(value, "application/json");
        int coding = negotiate_coding(value, "gzip");
        FUZZ_PROMISE(quality >= 0 && quality <= 1000 && coding >= 0 && coding <= 1000);
        int64_t wait = negotiate_wait(value, 60);
        FUZZ_PROMISE(wait >= 0 && wait <= 60);
        (void)negotiate_etag_matches(value, "\"a\"");
        (void)negotiate_is_json(value);
        if (request_parse_int(value, 5, 99, &number))
            FUZZ_PROMISE(number >= 5 && number <= 99);
    }
}

/* The target with {drape} and {surface} filled in; malloc'ed. */
static char *fill_in(const char *target) {
    char *text = NULL;
    const char *id = service_drape, *place = strstr(target, "{drape}");
    if (!place) {
        id = service_surface;
        place = strstr(target, "{surface}");
    }
    if (!place)
        return strdup(target);
    FUZZ_PROMISE(asprintf(&text, "%.*s%s%s", (int)(place - target), target, id,
                          strchr(place, '}') + 1) >= 0);
    return text;
}

/* Whether the head is one that the front hands on, `target` being filled in. */
static bool passes(const char *method, const char *target, const char *version,
                   const struct request_field *fields, size_t count) {
    struct wire wire;
    char *head = NULL;
    size_t length;
    FILE *out = open_memstream(&head, &length);
    FUZZ_PROMISE(out != NULL);
    fprintf(out, "%s %s %s\r\n", method, target, version);
    for (size_t k = 0; k < count; k++)
        fprintf(out, "%s:%s\r\n", fields[k].name, fields[k].value);
    fputs("\r\n", out);
    fclose(out);
    wire_init(&wire);
    bool good = wire_check(&wire, head, length, NULL) == length && wire.problem == API_OK;
    free(head);
    return good;
}

/* NULL when the head is not well-formed; `*text` moves on to the body. */
static struct request *read_head(char **text) {
    struct request_field fields[REQUEST_HEADERS_MAX];
    size_t count = 0;
    int64_t length;
    char *line = strsep(text, "\n"), *method = strsep(&line, " ");
    char *target = fill_in(line ? strsep(&line, " ") : "/");
    const char *version = line ? line : "HTTP/1.1";
    for (char *field; (field = strsep(text, "\n")) && *field && count < REQUEST_HEADERS_MAX;) {
        char *value = strchr(field, ':');
        if (value)
            *value++ = '\0';
        fields[count++] = (struct request_field){field, value ? value + strspn(value, " ") : ""};
    }
    struct request *request =
        passes(method, target, version, fields, count) ? request_new(target) : NULL;
    free(target);
    if (!request)
        return NULL;
    request->method = method;
    request->http_1_0 = !strcmp(version, "HTTP/1.0");
    for (size_t k = 0; k < count; k++)
        request_add_header(request, fields[k].name, fields[k].value);
    request_choose_id(request);
    expect_printable(request->id);
    bool body = request_has_body(request, &length);
    FUZZ_PROMISE(length >= -1 && (body || length <= 0));
    FUZZ_PROMISE(request_header(request, "host") || request->http_1_0);
    read_headers(request);
    return request;
}

/* ------------------------------------------------------------------ the answer */

static void expect_problem(const struct request *request, const struct reply *reply,
                           const json_t *problem) {
    const char *type = json_string_value(json_object_get(problem, "type"));
    const char *id = json_string_value(json_object_get(problem, "request_id"));
    FUZZ_PROMISE(type && !strncmp(type, "/problems/", 10) && strcmp(type, "/problems/internal"));
    FUZZ_PROMISE(json_integer_value(json_object_get(problem, "status")) == reply->status);
    FUZZ_PROMISE(id && !strcmp(id, request->id));
}

static void expect_body(const struct request *request, const struct reply *reply) {
    const char *bytes = reply->body ? reply->body : reply->literal, *type = "";
    for (size_t k = 0; k < reply->header_count; k++)
        if (!strcmp(reply->headers[k].name, "Content-Type"))
            type = reply->headers[k].value;
    FUZZ_PROMISE(!strcmp(type, "application/problem+json") == (reply->status >= 400));
    if (!strstr(type, "json") || reply_has_header(reply, "Content-Encoding"))
        return;
    json_t *json = json_loadb(bytes, reply->length, JSON_DECODE_ANY, NULL);
    FUZZ_PROMISE(json != NULL || reply->status == 206);
    if (reply->status >= 400)
        expect_problem(request, reply, json);
    json_decref(json);
}

/* To its end; a stream of events, which has none, until it waits. */
static void expect_stream(const struct reply *reply) {
    static char piece[4096];
    size_t total = 0;
    ssize_t got;
    while ((got = reply->stream.next(reply->stream.context, piece, sizeof piece)) > 0)
        total += (size_t)got;
    FUZZ_PROMISE(got == REPLY_END || got == REPLY_WAIT);
    FUZZ_PROMISE(!reply->length || got == REPLY_WAIT || total == reply->length);
}

static void expect_answer(const struct request *request, const struct reply *reply) {
    FUZZ_PROMISE(reply->status >= 200 && reply->status < 504 && reply->status != 500);
    FUZZ_PROMISE(reply->header_count < REPLY_HEADERS_MAX);
    FUZZ_PROMISE(reply->status != 405 || reply_has_header(reply, "Allow"));
    FUZZ_PROMISE(reply->status != 201 || reply_has_header(reply, "Location"));
    if (reply->streamed)
        expect_stream(reply);
    else if (reply->length)
        expect_body(request, reply);
}

/* ------------------------------------------------------------------ from one to the other */

static void handle(struct request *request, struct reply *reply) {
    const struct http_handler handler = routes_handler(service());
    for (int k = 0; handler.handle(handler.context, request, reply) == HTTP_WAIT; k++) {
        FUZZ_PROMISE(!request->stopping);
        request->stopping = k == CALLS;
        usleep(1000);
    }
}

/* Whether the answer says that something of the service has changed. */
static bool serve(struct request *request, const char *body, size_t length) {
    const struct http_handler handler = routes_handler(service());
    struct reply reply = {.request_id = request->id};
    request->limit = (struct request_limit){service()->config->max_body, "max-body"};
    bool refused = handler.check_head(handler.context, request, &reply);
    FUZZ_PROMISE(refused == (reply.status != 0));
    FUZZ_PROMISE(refused || request->route);
    if (!refused && (int64_t)length > request->limit.bytes)
        length = 0;
    if (!refused) {
        FUZZ_PROMISE(!length || request_append_body(request, body, length));
        handle(request, &reply);
    }
    origin_share(service()->config, request, &reply);
    expect_answer(request, &reply);
    bool changed = reply.status > 200 && reply.status < 300 && strcmp(request->method, "GET") != 0;
    reply_clear(&reply);
    return changed;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    (void)service(); /* for the ids */
    char *text = malloc(size + 1), *rest = text;
    FUZZ_PROMISE(text != NULL);
    memcpy(text, data, size);
    text[size] = '\0';
    struct request *request = read_head(&rest);
    bool changed = request && !request->fault[0] &&
                   serve(request, rest, rest ? size - (size_t)(rest - text) : 0);
    request_free(request); /* which may still have a check in the service's pool */
    free(text);
    if (changed)
        service_spoil();
    return 0;
}
