/* SPDX-License-Identifier: MIT */
#include "resources.h"
#include "server/config.h"
#include "server/http/negotiate.h"
#include "server/hub.h"
#include <stdio.h>
#include <string.h>

enum { POLL_MAX_MS = 2000 };

struct api_limits resources_limits(const struct http_services *services) {
    const struct config *config = services->config;
    return (struct api_limits){
        .max_nodes = (size_t)config->max_nodes,
        .max_memory = (size_t)config->job_memory,
        .max_elements = (size_t)config->max_elements,
        .max_control_points = (size_t)config->max_control_points,
        .max_depth = (int)config->max_depth,
        .threads = 1,
    };
}

const char *resources_owner(const struct request *request) {
    return request->sees_all ? NULL : request->caller;
}

enum routes_next resources_store_failed(const struct request *request, struct reply *reply,
                                        enum store_answer answer) {
    bool busy = answer == STORE_BUSY;
    reply_header(reply, "Retry-After", "%d", busy ? 1 : 10);
    reply_refuse(reply, request->id, API_UNAVAILABLE, "the store is %s", store_answer_name(answer));
    return ROUTES_DONE;
}

enum routes_next resources_draining(const struct request *request, struct reply *reply) {
    reply_header(reply, "Retry-After", "5");
    reply_refuse(reply, request->id, API_UNAVAILABLE, "the service is shutting down");
    return ROUTES_DONE;
}

enum routes_next resources_not_found(const struct request *request, struct reply *reply,
                                     const char *what) {
    reply_refuse(reply, request->id, API_NOT_FOUND, "there is no %s with this id", what);
    return ROUTES_DONE;
}

bool resources_job(const struct http_services *services, const struct request *request,
                   struct reply *reply, struct store_job *job) {
    enum store_answer answer = STORE_EMPTY;
    if (id_valid(request->parameter))
        answer = store_get(services->store, request->parameter, job);
    if (answer == STORE_OK && !request->sees_all && strcmp(job->owner, request->caller) != 0) {
        store_job_clear(job);
        answer = STORE_EMPTY;
    }
    if (answer == STORE_OK)
        return true;
    if (answer == STORE_EMPTY)
        resources_not_found(request, reply, "drape");
    else
        resources_store_failed(request, reply, answer);
    return false;
}

bool resources_page(const struct request *request, struct reply *reply, int *limit,
                    int64_t *cursor) {
    const char *limit_text = request_query(request, "limit");
    const char *cursor_text = request_query(request, "cursor");
    int64_t number = RESOURCES_PAGE;
    *cursor = 0;
    if (limit_text && !request_parse_int(limit_text, 1, RESOURCES_PAGE_MAX, &number)) {
        reply_refuse(reply, request->id, API_INVALID_REQUEST,
                     "the query parameter 'limit' must be a whole number from 1 to %d",
                     RESOURCES_PAGE_MAX);
        return false;
    }
    if (cursor_text && !request_parse_int(cursor_text, 1, INT64_MAX, cursor)) {
        reply_refuse(reply, request->id, API_INVALID_REQUEST,
                     "the query parameter 'cursor' must be the 'next' of an earlier page");
        return false;
    }
    *limit = (int)number;
    return true;
}

/* The format of that name; else of those that `accept` wants the most the first. */
static const struct format *find_format(enum format_use use, const char *name, const char *accept) {
    const struct format *format, *found = NULL;
    int highest = 0;
    for (size_t k = 0; (format = format_at(use, k)); k++) {
        int quality =
            name ? !strcmp(name, format->name) : negotiate_quality(accept, format->media_type);
        if (quality <= highest)
            continue;
        highest = quality;
        found = format;
    }
    return found;
}

const struct format *resources_format(const struct request *request, struct reply *reply,
                                      enum format_use use) {
    const struct format *format =
        find_format(use, request_query(request, "format"), request_header(request, "Accept"));
    char names[128] = "";
    if (format)
        return format;
    for (size_t k = 0, used = 0; (format = format_at(use, k)) && used < sizeof names; k++)
        used += (size_t)snprintf(names + used, sizeof names - used, "%s%s", k ? ", " : "",
                                 format->name);
    reply_refuse(reply, request->id, API_NOT_ACCEPTABLE, "this is available as %s", names);
    return NULL;
}

int64_t resources_poll_at(int64_t begun, int64_t now) {
    int64_t pause = (now - begun) / 4;
    if (pause < HUB_POLL_MS)
        pause = HUB_POLL_MS;
    return now + (pause < POLL_MAX_MS ? pause : POLL_MAX_MS);
}
