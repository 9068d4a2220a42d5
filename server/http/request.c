/* SPDX-License-Identifier: MIT */
#include "request.h"
#include "server/id.h"
#include "server/spool.h"
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/mman.h>
#include <unistd.h>

/* The first fault wins. */
static void set_fault(struct request *request, const char *fault) {
    if (!request->fault[0])
        snprintf(request->fault, sizeof request->fault, "%s", fault);
}

/* Undoes percent-encoding in place. A zero byte would end the string early: it is not allowed. */
static void decode_in_place(struct request *request, char *text, bool plus_is_space) {
    char *out = text;
    for (const char *in = text; *in; in++) {
        int c = *in == '+' && plus_is_space ? ' ' : (unsigned char)*in;
        if (c == '%') {
            int high = wire_hex_value((unsigned char)in[1]);
            int low = high < 0 ? -1 : wire_hex_value((unsigned char)in[2]);
            in += low < 0 ? 0 : 2;
            c = low < 0 ? 0 : high * 16 + low;
            c = c ? c : -1;
        } else if (c < ' ' || c == 0x7f) {
            c = -1;
        }
        if (c < 0) {
            set_fault(request,
                      "the target has a control character, or a % that does not begin an escape");
            return;
        }
        *out++ = (char)c;
    }
    *out = '\0';
}

struct request *request_new(const char *target) {
    struct request *request = calloc(1, sizeof *request);
    if (!request)
        return NULL;
    request->method = "";
    request->body_file = -1;
    request->target = strdup(target);
    request->decoded = strdup(target);
    if (!request->target || !request->decoded) {
        request_free(request);
        return NULL;
    }
    /* A path, an absolute URI or "*". A path of "/" has no segments; one more than any route has is
     * not found. */
    char *path = request->decoded;
    if (*path != '/' && *path != '*') {
        char *authority = strchr(path, '/') + 2;
        path = authority + strcspn(authority, "/");
        request->authority = strndup(authority, (size_t)(path - authority));
    }
    if (*path != '/')
        return request;
    char *query = strchr(path, '?');
    if (query)
        *query++ = '\0';
    char *rest = path[1] ? path + 1 : NULL;
    for (char *segment; (segment = strsep(&rest, "/"));) {
        if (request->segment_count == REQUEST_SEGMENTS_MAX)
            break;
        decode_in_place(request, segment, false);
        request->segments[request->segment_count++] = segment;
    }
    for (char *pair; (pair = strsep(&query, "&"));) {
        if (!*pair)
            continue;
        if (request->query_count == REQUEST_QUERY_MAX) {
            set_fault(request, "the query has too many parameters");
            break;
        }
        char *value = strchr(pair, '=');
        if (value)
            *value++ = '\0';
        else
            value = pair + strlen(pair);
        decode_in_place(request, pair, true);
        decode_in_place(request, value, true);
        request->query[request->query_count++] = (struct request_field){pair, value};
    }
    return request;
}

void request_free(struct request *request) {
    if (!request)
        return;
    free(request->target);
    free(request->decoded);
    free(request->authority);
    if (request->body_file < 0)
        free(request->body);
    else if (request->body)
        munmap(request->body, request->body_capacity);
    if (request->body_file >= 0)
        close(request->body_file);
    for (size_t k = 0; k < request->owned_count; k++)
        free(request->owned[k]);
    if (request->state_free && request->state)
        request->state_free(request->state);
    else
        free(request->state);
    free(request);
}

/* The number of the first header of that name; `header_count` without. */
static size_t find_header(const struct request *request, const char *name) {
    size_t k = 0;
    while (k < request->header_count && strcasecmp(request->headers[k].name, name) != 0)
        k++;
    return k;
}

/* Takes over a string of malloc; `fallback` without one, or without room. */
static const char *own_text(struct request *request, char *text, const char *fallback) {
    if (!text || request->owned_count == REQUEST_OWNED_MAX) {
        free(text);
        return fallback;
    }
    return request->owned[request->owned_count++] = text;
}

static bool is_named(const char *name, const char *const *names, size_t count) {
    size_t k = 0;
    while (k < count && strcasecmp(names[k], name) != 0)
        k++;
    return k < count;
}

void request_add_header(struct request *request, const char *name, const char *value) {
    /* Lists that are read here may come in several lines (RFC 9110, 5.3). */
    static const char *const lists[] = {"Accept", "Accept-Encoding", "Content-Encoding",
                                        "If-None-Match", "Prefer"};
    /* Of others another reader on the way may go by the other line. Those of framing and
     * Authorization are not let through by `wire.h`. */
    static const char *const singles[] = {"Content-Type",  "Idempotency-Key", "If-Range",
                                          "Last-Event-ID", "Origin",          "Range",
                                          "Sec-Fetch-Site"};
    size_t length = strlen(value), sent = length;
    while (length && strchr(" \t", value[length - 1]))
        length--;
    if (length < sent)
        value = own_text(request, strndup(value, length), value);
    size_t first = find_header(request, name);
    bool again = first < request->header_count;
    if (again && is_named(name, lists, sizeof lists / sizeof *lists)) {
        const char *before = request->headers[first].value;
        char *joined = NULL;
        if (asprintf(&joined, "%s, %s", before, value) < 0)
            joined = NULL; /* without memory it is as if it had not come */
        request->headers[first].value = own_text(request, joined, before);
        return;
    }
    if (again && is_named(name, singles, sizeof singles / sizeof *singles) && !request->fault[0])
        snprintf(request->fault, sizeof request->fault, "there is more than one %s", name);
    if (request->header_count < REQUEST_HEADERS_MAX)
        request->headers[request->header_count++] = (struct request_field){name, value};
}

void request_choose_id(struct request *request) {
    static const char allowed[] =
        "0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ._:-";
    const char *given = request_header(request, "X-Request-Id");
    size_t length = given ? strlen(given) : 0;
    _Static_assert((int)REQUEST_ID_SIZE >= (int)ID_SIZE, "an id of ours must fit");
    if (length > 0 && length < REQUEST_ID_SIZE && strspn(given, allowed) == length)
        memcpy(request->id, given, length + 1);
    else
        id_make(request->id);
}

const char *request_header(const struct request *request, const char *name) {
    size_t k = find_header(request, name);
    return k < request->header_count ? request->headers[k].value : NULL;
}

const char *request_query(const struct request *request, const char *name) {
    for (size_t k = 0; k < request->query_count; k++)
        if (!strcmp(request->query[k].name, name))
            return request->query[k].value;
    return NULL;
}

bool request_has_body(const struct request *request, int64_t *length) {
    const char *text = request_header(request, "Content-Length");
    *length = -1;
    if (text && request_parse_int(text, 0, INT64_MAX, length))
        return *length > 0;
    return request_header(request, "Transfer-Encoding") != NULL;
}

bool request_append_body(struct request *request, const char *bytes, size_t length) {
    size_t needed = request->body_length + length + 1;
    if (needed > request->body_capacity) {
        size_t capacity = request->body_capacity ? 2 * request->body_capacity : 8192;
        if (capacity < needed)
            capacity = needed;
        bool moves = request->body_file < 0 && needed > REQUEST_BODY_IN_HEAP; /* into a file */
        int file = moves ? spool_new(0, "") : request->body_file;
        char *body = NULL;
        if (!moves && file < 0)
            body = realloc(request->body, capacity);
        else if (file >= 0 && ftruncate(file, (off_t)capacity) == 0)
            body = moves ? mmap(NULL, capacity, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0)
                         : mremap(request->body, request->body_capacity, capacity, MREMAP_MAYMOVE);
        if (!body || body == MAP_FAILED) {
            if (moves && file >= 0)
                close(file); /* what there is stays in the heap */
            return false;
        }
        if (moves) {
            if (request->body_length)
                memcpy(body, request->body, request->body_length);
            free(request->body);
        }
        request->body_file = file;
        request->body = body;
        request->body_capacity = capacity;
    }
    memcpy(request->body + request->body_length, bytes, length);
    request->body_length += length;
    request->body[request->body_length] = '\0';
    return true;
}

/* A file is sealed only when nobody has it mapped for writing. */
bool request_complete_body(struct request *request) {
    size_t capacity = request->body_length + 1;
    if (request->body_file < 0)
        return true;
    munmap(request->body, request->body_capacity);
    request->body = NULL;
    request->body_capacity = capacity;
    if (ftruncate(request->body_file, (off_t)capacity) != 0 || !spool_seal(request->body_file))
        return false;
    void *body = mmap(NULL, capacity, PROT_READ, MAP_SHARED, request->body_file, 0);
    request->body = body == MAP_FAILED ? NULL : body;
    return request->body != NULL;
}

bool request_parse_int(const char *text, int64_t low, int64_t high, int64_t *value) {
    if (*text < '0' || *text > '9')
        return false; /* strtoll would take signs and blanks */
    char *end;
    errno = 0;
    long long number = strtoll(text, &end, 10);
    if (errno || *end || number < low || number > high)
        return false;
    *value = number;
    return true;
}
