/* SPDX-License-Identifier: MIT */
#include "call.h"
#include "server/config.h"
#include "server/http/negotiate.h"
#include "server/job_events.h"
#include "server/work/stored_result.h"
#include <stdio.h>
#include <string.h>

enum { POLL_MAX_MS = 2000 };

const char *call_owner(const struct call *call) {
    return call->request->sees_all ? NULL : call->request->owner;
}

enum http_next call_store_failed(struct call *call, enum store_answer answer) {
    if (answer == STORE_ALTERED)
        return call_altered(call, call->request->parameter);
    reply_refuse_for(call->reply, answer == STORE_BUSY ? 1 : 10, API_UNAVAILABLE, "the store is %s",
                     store_answer_name(answer));
    return HTTP_DONE;
}

enum http_next call_altered(struct call *call, const char *id) {
    reply_refuse(call->reply, API_DAMAGED,
                 "what the store has of %s is damaged: delete it and post it again, or restore a "
                 "back-up of before",
                 id);
    return HTTP_DONE;
}

enum http_next call_draining(struct call *call) {
    reply_refuse_for(call->reply, 5, API_UNAVAILABLE, "the service is shutting down");
    return HTTP_DONE;
}

enum http_next call_bytes_full(struct call *call) {
    reply_refuse_for(call->reply, 60, API_QUOTA,
                     "you have stored as much as one owner may: %lld bytes (--owner-bytes); "
                     "delete what you no longer need",
                     (long long)call->services->config->owner_bytes);
    return HTTP_DONE;
}

bool call_has_room(struct call *call, size_t bytes) {
    struct store_usage usage = {0};
    int64_t most = call->services->config->owner_bytes;
    if (!most)
        return true;
    enum store_answer answer = store_usage(call->services->store, call->request->owner, &usage);
    if (answer != STORE_OK)
        call_store_failed(call, answer);
    else if (usage.bytes + (int64_t)bytes > most)
        call_bytes_full(call);
    return answer == STORE_OK && usage.bytes + (int64_t)bytes <= most;
}

enum http_next call_not_found(struct call *call, const char *what) {
    reply_refuse(call->reply, API_NOT_FOUND, "there is no %s with this id", what);
    return HTTP_DONE;
}

enum store_answer call_see_job(struct call *call, const char *id, struct store_job *job) {
    const char *owner = call_owner(call);
    enum store_answer answer =
        id_valid(id) ? store_get(call->services->store, id, job) : STORE_EMPTY;
    bool hidden = owner && strcmp(job->owner, owner) != 0;
    return answer == STORE_OK && (hidden || job->kind == STORE_TASK) ? STORE_EMPTY : answer;
}

bool call_find_job(struct call *call, struct store_job *job) {
    struct request *request = call->request;
    enum store_answer answer = call_see_job(call, request->parameter, job);
    if (answer == STORE_OK && job->kind != call->kind)
        answer = STORE_EMPTY;
    if (answer != STORE_OK)
        store_job_clear(job);
    if (answer == STORE_OK)
        memcpy(request->drape, job->id, sizeof request->drape);
    else if (answer == STORE_EMPTY)
        call_not_found(call, store_kind_name(call->kind));
    else
        call_store_failed(call, answer);
    return answer == STORE_OK;
}

bool call_read_page(struct call *call, int *limit, int64_t *cursor) {
    const char *limit_text = request_query(call->request, "limit");
    const char *cursor_text = request_query(call->request, "cursor");
    int64_t number = CALL_PAGE;
    *cursor = 0;
    if (limit_text && !request_parse_int(limit_text, 1, CALL_PAGE_MAX, &number)) {
        reply_refuse(call->reply, API_INVALID_REQUEST,
                     "the query parameter 'limit' must be a whole number from 1 to %d",
                     CALL_PAGE_MAX);
        return false;
    }
    if (cursor_text && !request_parse_int(cursor_text, 1, INT64_MAX, cursor)) {
        reply_refuse(call->reply, API_INVALID_REQUEST,
                     "the query parameter 'cursor' must be the 'next' of an earlier page");
        return false;
    }
    *limit = (int)number;
    return true;
}

enum http_next call_request_failed(struct call *call, enum store_answer answer) {
    if (answer != STORE_EMPTY)
        return call_store_failed(call, answer);
    reply_refuse(call->reply, API_GONE,
                 "the request has been removed (--retention, --retention-bytes)");
    return HTTP_DONE;
}

char *call_stored_request(struct call *call, const char *id, size_t *length) {
    char *request = NULL;
    enum store_answer answer = store_request(call->services->store, id, &request, length);
    if (answer != STORE_OK)
        call_request_failed(call, answer);
    return request;
}

/* What a result begins with is looked at before the answer begins, and then in memory: as much as
 * is cheap, in steps that miss no chunk. */
enum { AHEAD_BYTES = 1 << 20, STEP_BYTES = 1 << 16 };

bool call_stored_result(struct call *call, const char *id, struct stored_result *stored) {
    stored->store = call->services->store;
    enum store_answer answer = store_result_find(stored->store, id, &stored->result);
    const int64_t length = answer == STORE_OK ? stored->result.length : 0;
    char byte;
    for (int64_t at = 0; at < length && at < AHEAD_BYTES && answer == STORE_OK; at += STEP_BYTES)
        answer = store_result_read(stored->store, &stored->result, at, &byte, 1);
    if (answer == STORE_EMPTY)
        reply_refuse(call->reply, API_GONE, "the result has been removed");
    else if (answer != STORE_OK)
        call_store_failed(call, answer);
    return answer == STORE_OK;
}

bool call_choose(struct call *call, enum format_use use, struct call_choice *choice) {
    const struct request *request = call->request;
    const char *name = request_query(request, "format"),
               *accept = request_header(request, "Accept");
    const struct format *format;
    struct api_problem problem = {0};
    char names[128] = "";
    size_t used = 0;
    int highest = 0;
    *choice = (struct call_choice){0};
    for (size_t k = 0; (format = format_at(use, k)); k++) { /* the first that is wanted the most */
        int quality =
            name ? !strcmp(name, format->name) : negotiate_quality(accept, format->media_type);
        if (quality > highest)
            choice->format = format;
        highest = quality > highest ? quality : highest;
        if (used < sizeof names)
            used += (size_t)snprintf(names + used, sizeof names - used, "%s%s", k ? ", " : "",
                                     format->name);
    }
    if (!choice->format) {
        reply_refuse(call->reply, API_NOT_ACCEPTABLE,
                     "the format is not available: choose one of %s", names);
        return false;
    }
    for (size_t k = 0; k < request->query_count; k++)
        format_option(&choice->options, request->query[k].name, request->query[k].value, &problem);
    if (problem.id != API_OK)
        reply_problem(call->reply, &problem);
    return problem.id == API_OK;
}

int64_t call_poll_at(int64_t begun, int64_t now) {
    int64_t pause = (now - begun) / 4;
    if (pause < JOB_EVENTS_POLL_MS)
        pause = JOB_EVENTS_POLL_MS;
    return now + (pause < POLL_MAX_MS ? pause : POLL_MAX_MS);
}
