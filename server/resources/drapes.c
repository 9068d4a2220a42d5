/* SPDX-License-Identifier: MIT */
/* /v1/drapes: submit, list, status, request as understood, cancel, delete. */
#include "api/request/decode.h"
#include "api/request/digest.h"
#include "api/request/normalise.h"
#include "api/request/shape.h"
#include "api/request/shape_mesh.h"
#include "documents.h"
#include "handlers.h"
#include "queue_rate.h"
#include "server/clock.h"
#include "server/config.h"
#include "server/http/negotiate.h"
#include "server/work/stored_result.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void reply_status(struct call *call, int status, const struct store_job *job) {
    reply_text(call->reply, status, "application/json", documents_status(job));
    reply_header(call->reply, "Cache-Control", "no-store");
}

/* ------------------------------------------------------------------ waiting for the end */

/* `request->state` of a call that may wait for the end of a drape. */
struct waiting {
    char id[ID_SIZE];
    int64_t begun, deadline; /* `clock_ms`; equal: it does not wait */
};

/* False without memory: the reply says so. */
static bool start_waiting(struct call *call, const char *id, int64_t seconds) {
    struct waiting *waiting = calloc(1, sizeof *waiting);
    if (!waiting) {
        reply_refuse(call->reply, API_UNAVAILABLE, "there is no memory for this now");
        return false;
    }
    snprintf(waiting->id, sizeof waiting->id, "%.32s", id);
    waiting->begun = clock_ms();
    waiting->deadline = waiting->begun + seconds * 1000;
    call->request->state = waiting;
    return true;
}

/* Whether to go on waiting for the job; sets when to look again. */
static bool must_wait(struct request *request, const struct store_job *job) {
    const struct waiting *waiting = request->state;
    int64_t now = clock_ms();
    if (!waiting || request->stopping || store_status_ended(job->status) ||
        now >= waiting->deadline)
        return false;
    request->wake_at = call_poll_at(waiting->begun, now);
    if (request->wake_at > waiting->deadline)
        request->wake_at = waiting->deadline;
    return true;
}

/* ------------------------------------------------------------------ POST /v1/drapes */

/* A posted drape request on its way into the store. */
struct posted {
    struct arena *arena;
    struct api_request decoded;
    struct store_surface surface; /* the stored one that it names */
    char digest[API_ID_SIZE];
};

/* All that can be known about a drape request before it is solved: decodes it, with the stored
 * surface if it names one, makes its surface or mesh and its digest. */
static enum api_problem_id check_posted(struct call *call, struct posted *posted,
                                        struct api_problem *problem) {
    const struct request *request = call->request;
    const struct api_limits limits = call_limits(call);
    struct api_input input = {request->body ? request->body : "", request->body_length, NULL, 0};
    struct api_request *decoded = &posted->decoded;
    struct surface *surface;
    struct mesh *mesh;
    if (api_decode(&input, &limits, posted->arena, decoded, problem) != API_OK)
        return problem->id;
    if (decoded->surface.kind == API_SURFACE_NAMED) {
        char id[API_ID_SIZE];
        memcpy(id, decoded->surface.id, sizeof id);
        enum store_answer answer =
            store_surface_get(call->services->store, call_owner(call), id, &posted->surface);
        if (answer == STORE_EMPTY)
            api_problem_add(problem, "/surface/id", "there is no stored surface '%s'", id);
        else if (answer != STORE_OK)
            api_problem_set(problem, API_UNAVAILABLE, "the store is %s", store_answer_name(answer));
        input.surface = posted->surface.definition;
        input.surface_length = posted->surface.definition_length;
        if (answer != STORE_OK ||
            api_decode(&input, &limits, posted->arena, decoded, problem) != API_OK)
            return problem->id;
    }
    enum api_problem_id shaped =
        decoded->surface.kind == API_SURFACE_MESH
            ? api_shape_mesh(decoded, &limits, posted->arena, &mesh, problem)
            : api_shape_make(decoded, &limits, posted->arena, &surface, problem);
    if (shaped == API_OK && !api_digest_request(decoded, posted->arena, posted->digest))
        api_problem_set(problem, API_OUT_OF_MEMORY, "the request needs more memory than allowed");
    return problem->id;
}

/* Queues the drape; its id is that of the receipt. False: the reply says why not. */
static bool submit(struct call *call, const struct posted *posted, struct store_receipt *receipt) {
    const struct request *request = call->request;
    struct reply *reply = call->reply;
    struct api_problem problem = {0};
    const struct store_submission submission = {
        .request = request->body,
        .request_length = request->body_length,
        .digest = posted->digest,
        .surface = posted->surface.definition ? posted->decoded.surface.id : NULL,
        .owner = request->caller,
        .key = request_header(request, "Idempotency-Key"),
    };
    enum store_answer answer = store_submit(call->services->store, &submission, receipt);
    switch (answer) {
    case STORE_OK:
        break;
    case STORE_CONFLICT:
        reply_refuse(reply, API_IDEMPOTENCY_MISMATCH,
                     "this Idempotency-Key came with another body before");
        break;
    case STORE_FULL:
        reply_header(reply, "Retry-After", "%d",
                     queue_rate_retry_seconds(call->services->config->queue_limit));
        reply_refuse(reply, API_QUEUE_FULL, "the queue is at its limit (--queue-limit)");
        break;
    case STORE_EMPTY: /* deleted since it was read */
        api_problem_add(&problem, "/surface/id", "there is no stored surface '%s'",
                        posted->decoded.surface.id);
        reply_problem(reply, &problem);
        break;
    default:
        call_store_failed(call, answer);
    }
    return answer == STORE_OK;
}

/* Keys of other bytes need be no text, which PostgreSQL does not take. */
static bool check_key(struct call *call) {
    const char *key = request_header(call->request, "Idempotency-Key");
    size_t length = 0;
    while (key && key[length] >= ' ' && key[length] <= '~')
        length++;
    if (!key || (length > 0 && length < STORE_KEY_SIZE && !key[length]))
        return true;
    reply_refuse(call->reply, API_INVALID_REQUEST,
                 "the Idempotency-Key must have 1 to %d characters of ASCII", STORE_KEY_SIZE - 1);
    return false;
}

/* The first call: checks and stores the drape. False: the reply says why not. */
static bool accept_drape(struct call *call) {
    struct posted posted = {.arena = NULL};
    struct api_problem problem = {0};
    struct store_receipt receipt;
    int64_t wait = negotiate_wait(request_header(call->request, "Prefer"), CALL_WAIT_MAX);
    if (!check_key(call) || !start_waiting(call, "", wait))
        return false;
    struct waiting *waiting = call->request->state;
    queue_rate_sample(call->services->store);
    posted.arena = arena_new(call_limits(call).max_memory);
    if (!posted.arena)
        api_problem_set(&problem, API_UNAVAILABLE, "there is no memory for this now");
    else
        check_posted(call, &posted, &problem);
    if (problem.id != API_OK)
        reply_problem(call->reply, &problem);
    bool stored = problem.id == API_OK && submit(call, &posted, &receipt);
    store_surface_clear(&posted.surface);
    arena_free(posted.arena);
    if (stored)
        memcpy(waiting->id, receipt.id, sizeof waiting->id);
    return stored;
}

/* 202 and the status, or, when it ended while the caller waited, what it ended with. */
static void reply_created(struct call *call, const struct store_job *job,
                          const struct call_choice *choice) {
    const struct waiting *waiting = call->request->state;
    if (waiting->begun == waiting->deadline || !store_status_ended(job->status)) {
        reply_status(call, 202, job);
    } else {
        results_reply(call, job, choice);
        reply_header(call->reply, "Preference-Applied", "wait");
        if (call->reply->status == 200)
            reply_header(call->reply, "Content-Location", "/v1/drapes/%s/result", job->id);
    }
    reply_header(call->reply, "Location", "/v1/drapes/%s", job->id);
}

enum http_next drapes_create(struct call *call) {
    struct call_choice choice;
    struct store_job job = {0};
    enum http_next next = HTTP_DONE;
    if (!call_choose(call, FORMAT_RESULT, &choice) ||
        (!call->request->state && !accept_drape(call)))
        return HTTP_DONE;
    const struct waiting *waiting = call->request->state;
    if (waiting->deadline > waiting->begun)
        http_watch(call->request, waiting->id);
    enum store_answer answer = store_get(call->services->store, waiting->id, &job);
    if (answer == STORE_EMPTY)
        call_not_found(call, "drape (it has been deleted)");
    else if (answer != STORE_OK)
        call_store_failed(call, answer);
    else if (must_wait(call->request, &job))
        next = HTTP_WAIT;
    else
        reply_created(call, &job, &choice);
    store_job_clear(&job);
    return next;
}

/* ------------------------------------------------------------------ reading */

enum http_next drapes_list(struct call *call) {
    struct store_filter filter = {.owner = call_owner(call)};
    struct store_page page;
    const char *status = request_query(call->request, "status");
    filter.has_status = status != NULL;
    if (status && !store_status_from_name(status, &filter.status)) {
        reply_refuse(call->reply, API_INVALID_REQUEST,
                     "the query parameter 'status' must be queued, running, succeeded, failed or "
                     "cancelled");
        return HTTP_DONE;
    }
    if (!call_read_page(call, &filter.limit, &filter.cursor))
        return HTTP_DONE;
    enum store_answer answer = store_list(call->services->store, &filter, &page);
    if (answer == STORE_OK)
        reply_text(call->reply, 200, "application/json", documents_list(&page));
    else
        call_store_failed(call, answer);
    reply_header(call->reply, "Cache-Control", "no-store");
    store_page_clear(&page);
    return HTTP_DONE;
}

/* The `wait` of the query starts the waiting at the first call. False: the reply says why not. */
static bool read_wait(struct call *call) {
    const char *text = request_query(call->request, "wait");
    int64_t seconds = 0;
    if (!text || call->request->state)
        return true;
    if (request_parse_int(text, 0, CALL_WAIT_MAX, &seconds))
        return !seconds || start_waiting(call, call->request->parameter, seconds);
    reply_refuse(call->reply, API_INVALID_REQUEST,
                 "the query parameter 'wait' must be a whole number of seconds from 0 to %d",
                 CALL_WAIT_MAX);
    return false;
}

enum http_next drapes_status(struct call *call) {
    struct store_job job = {0};
    enum http_next next = HTTP_DONE;
    if (!read_wait(call))
        return HTTP_DONE;
    if (call->request->state && id_valid(call->request->parameter))
        http_watch(call->request, call->request->parameter);
    if (call_find_job(call, &job)) {
        if (must_wait(call->request, &job))
            next = HTTP_WAIT;
        else
            reply_status(call, 200, &job);
    }
    store_job_clear(&job);
    return next;
}

/* ------------------------------------------------------------------ the request as understood */

/* What the solve started from, if there is a result that says so. */
static bool read_start(struct call *call, const char *id, struct api_start *start) {
    struct stored_result stored = {.store = call->services->store};
    struct api_problem problem = {0};
    if (store_result_find(stored.store, id, &stored.result) != STORE_OK)
        return false;
    struct api_reader reader = stored_result_reader(&stored);
    struct api_columns *columns = malloc(sizeof *columns);
    bool found = columns && api_columns_open(&reader, columns, &problem) == API_OK;
    if (found)
        *start = columns->start;
    free(columns);
    return found;
}

/* The drape request of `length` bytes with every default filled in, malloc'ed; NULL with the
 * problem. */
static char *normalise(struct call *call, const char *id, const char *bytes, size_t length,
                       struct api_problem *problem) {
    const struct api_limits limits = call_limits(call);
    struct arena *arena = arena_new(limits.max_memory);
    struct api_input input = {bytes, length, NULL, 0};
    struct api_request decoded;
    struct api_start start;
    bool started = read_start(call, id, &start);
    char *copy = NULL;
    if (arena && api_decode(&input, &limits, arena, &decoded, problem) == API_OK) {
        const char *text = api_normalise(&decoded, started ? &start : NULL, arena);
        copy = text ? strdup(text) : NULL;
    }
    if (!copy)
        api_problem_set(problem, API_OUT_OF_MEMORY, "the request needs more memory than allowed");
    arena_free(arena);
    return copy;
}

enum http_next drapes_request(struct call *call) {
    struct store_job job = {0};
    struct api_problem problem = {0};
    char *bytes = NULL;
    size_t length;
    if (!call_find_job(call, &job))
        return HTTP_DONE;
    enum store_answer answer = store_request(call->services->store, job.id, &bytes, &length);
    if (answer == STORE_EMPTY)
        api_problem_set(&problem, API_GONE,
                        "the request has been removed (--retention, --retention-bytes)");
    char *text = answer == STORE_OK ? normalise(call, job.id, bytes, length, &problem) : NULL;
    if (text)
        reply_text(call->reply, 200, "application/json", text);
    else if (problem.id != API_OK)
        reply_problem(call->reply, &problem);
    else
        call_store_failed(call, answer);
    free(bytes);
    store_job_clear(&job);
    return HTTP_DONE;
}

/* ------------------------------------------------------------------ ending */

enum http_next drapes_cancel(struct call *call) {
    struct store_job job = {0};
    bool found = call_find_job(call, &job);
    store_job_clear(&job);
    if (!found)
        return HTTP_DONE;
    enum store_answer answer = store_cancel(call->services->store, call->request->parameter);
    if (answer == STORE_EMPTY)
        return call_not_found(call, "drape");
    if (answer != STORE_OK && answer != STORE_CONFLICT)
        return call_store_failed(call, answer);
    if (call_find_job(call, &job))
        reply_status(call, answer == STORE_OK ? 202 : 200, &job);
    store_job_clear(&job);
    return HTTP_DONE;
}

enum http_next drapes_delete(struct call *call) {
    struct store_job job = {0};
    bool found = call_find_job(call, &job);
    store_job_clear(&job);
    if (!found)
        return HTTP_DONE;
    enum store_answer answer = store_delete(call->services->store, call->request->parameter);
    if (answer == STORE_EMPTY)
        return call_not_found(call, "drape");
    if (answer != STORE_OK)
        return call_store_failed(call, answer);
    reply_empty(call->reply, 204);
    return HTTP_DONE;
}
