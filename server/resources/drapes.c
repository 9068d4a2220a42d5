/* SPDX-License-Identifier: MIT */
#include "api/request/decode.h"
#include "api/request/digest.h"
#include "api/request/normalise.h"
#include "api/request/shape.h"
#include "api/request/shape_mesh.h"
#include "documents.h"
#include "queue_rate.h"
#include "resources.h"
#include "server/clock.h"
#include "server/config.h"
#include "server/http/negotiate.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* What a call that waits for the end of a drape remembers. */
struct waiting {
    char id[ID_SIZE];
    int64_t begun, deadline;
};

static void reply_status(struct reply *reply, int status, const struct store_job *job) {
    reply_text(reply, status, "application/json", documents_status(job));
    reply_header(reply, "Cache-Control", "no-store");
}

/* Makes the call one that waits. False without memory: then it does not wait. */
static bool start_waiting(struct request *request, const char *id, int64_t seconds) {
    struct waiting *waiting = calloc(1, sizeof *waiting);
    if (!waiting)
        return false;
    snprintf(waiting->id, sizeof waiting->id, "%.32s", id);
    waiting->begun = clock_ms();
    waiting->deadline = waiting->begun + seconds * 1000;
    request->state = waiting;
    return true;
}

/* Whether to go on waiting for the job; sets when to look again. */
static bool must_wait(struct request *request, const struct store_job *job) {
    const struct waiting *waiting = request->state;
    int64_t now = clock_ms();
    if (!waiting || request->stopping || store_status_ended(job->status) ||
        now >= waiting->deadline)
        return false;
    request->wake_at = resources_poll_at(waiting->begun, now);
    if (request->wake_at > waiting->deadline)
        request->wake_at = waiting->deadline;
    return true;
}

/* ------------------------------------------------------------------ POST /v1/drapes */

/* A posted request on its way into the store. */
struct intake {
    struct api_limits limits;
    struct arena *arena;
    struct api_request decoded;
    struct store_surface surface; /* the stored one it names */
    char digest[API_ID_SIZE];
};

/* Fetches the stored surface the request names and decodes again, with it. */
static enum api_problem_id intake_surface(const struct http_services *services,
                                          const struct request *request,
                                          const struct api_input *body, struct intake *intake,
                                          struct api_problem *problem) {
    char id[API_ID_SIZE];
    memcpy(id, intake->decoded.surface.id, sizeof id);
    enum store_answer answer =
        store_surface_get(services->store, resources_owner(request), id, &intake->surface);
    if (answer == STORE_EMPTY) {
        api_problem_add(problem, "/surface/id", "there is no stored surface '%s'", id);
        return problem->id;
    }
    if (answer != STORE_OK) {
        api_problem_set(problem, API_UNAVAILABLE, "the store is %s", store_answer_name(answer));
        return problem->id;
    }
    struct api_input both = {body->request, body->request_length, intake->surface.definition,
                             intake->surface.definition_length};
    return api_decode(&both, &intake->limits, intake->arena, &intake->decoded, problem);
}

static enum api_problem_id check_shape(struct intake *intake, struct api_problem *problem) {
    struct surface *surface;
    struct mesh *mesh;
    struct api_request *decoded = &intake->decoded;
    if (decoded->surface.kind == API_SURFACE_MESH)
        return api_shape_mesh(decoded, &intake->limits, intake->arena, &mesh, problem);
    return api_shape_make(decoded, &intake->limits, intake->arena, &surface, problem);
}

/* All that can be known about a request before it is solved. */
static enum api_problem_id intake_check(const struct http_services *services,
                                        const struct request *request, struct intake *intake,
                                        struct api_problem *problem) {
    struct api_input body = {request->body ? request->body : "", request->body_length, NULL, 0};
    enum api_problem_id id =
        api_decode(&body, &intake->limits, intake->arena, &intake->decoded, problem);
    if (id == API_OK && intake->decoded.surface.kind == API_SURFACE_NAMED)
        id = intake_surface(services, request, &body, intake, problem);
    if (id == API_OK)
        id = check_shape(intake, problem);
    if (id == API_OK && !api_digest_request(&intake->decoded, intake->arena, intake->digest))
        api_problem_set(problem, API_OUT_OF_MEMORY, "the request needs more memory than allowed");
    return problem->id;
}

static enum store_answer submit(const struct http_services *services, const struct request *request,
                                const struct intake *intake, struct store_receipt *receipt) {
    struct store_submission submission = {
        .request = request->body,
        .request_length = request->body_length,
        .digest = intake->digest,
        .surface = intake->surface.definition ? intake->decoded.surface.id : NULL,
        .owner = request->caller,
        .key = request_header(request, "Idempotency-Key"),
    };
    return store_submit(services->store, &submission, receipt);
}

static void refuse_submission(const struct http_services *services, const struct request *request,
                              const struct intake *intake, enum store_answer answer,
                              struct reply *reply) {
    struct api_problem problem = {0};
    switch (answer) {
    case STORE_CONFLICT:
        reply_refuse(reply, request->id, API_IDEMPOTENCY_MISMATCH,
                     "this Idempotency-Key came with another body before");
        break;
    case STORE_FULL:
        reply_header(reply, "Retry-After", "%d",
                     queue_rate_retry_seconds(services->config->queue_limit));
        reply_refuse(reply, request->id, API_QUEUE_FULL,
                     "the queue is at its limit (--queue-limit)");
        break;
    case STORE_EMPTY: /* deleted since it was read */
        api_problem_add(&problem, "/surface/id", "there is no stored surface '%s'",
                        intake->decoded.surface.id);
        reply_problem(reply, request->id, &problem);
        break;
    default:
        resources_store_failed(request, reply, answer);
    }
}

/* Checks and stores the drape. False: the reply says why not. */
static bool take_in(const struct http_services *services, const struct request *request,
                    struct reply *reply, struct store_receipt *receipt) {
    struct intake intake = {.limits = resources_limits(services)};
    struct api_problem problem = {0};
    enum store_answer answer = STORE_DOWN;
    queue_rate_sample(services->store);
    intake.arena = arena_new(intake.limits.max_memory);
    if (!intake.arena)
        api_problem_set(&problem, API_UNAVAILABLE, "there is no memory for this now");
    else if (intake_check(services, request, &intake, &problem) == API_OK)
        answer = submit(services, request, &intake, receipt);
    if (problem.id != API_OK)
        reply_problem(reply, request->id, &problem);
    else if (answer != STORE_OK)
        refuse_submission(services, request, &intake, answer, reply);
    store_surface_clear(&intake.surface);
    arena_free(intake.arena);
    return !reply->status;
}

/* Other bytes need be no text, which PostgreSQL does not take. */
static bool is_printable(const char *text) {
    while (*text >= ' ' && *text <= '~')
        text++;
    return !*text;
}

static bool check_key(const struct request *request, struct reply *reply) {
    const char *key = request_header(request, "Idempotency-Key");
    if (!key || (*key && strlen(key) < STORE_KEY_SIZE && is_printable(key)))
        return true;
    reply_refuse(reply, request->id, API_INVALID_REQUEST,
                 "the Idempotency-Key must have 1 to %d characters of ASCII", STORE_KEY_SIZE - 1);
    return false;
}

/* 202 and the status, or, when it ended while the caller waited, what it ended with. */
static void reply_created(const struct http_services *services, const struct request *request,
                          const struct store_job *job, const struct results_choice *choice,
                          struct reply *reply) {
    if (!request->state || !store_status_ended(job->status)) {
        reply_status(reply, 202, job);
        reply_header(reply, "Location", "/v1/drapes/%s", job->id);
        return;
    }
    results_reply(services, request, job, choice, reply);
    reply_header(reply, "Preference-Applied", "wait");
    reply_header(reply, "Location", "/v1/drapes/%s", job->id);
    if (reply->status == 200)
        reply_header(reply, "Content-Location", "/v1/drapes/%s/result", job->id);
}

static bool create(const struct http_services *services, struct request *request,
                   struct reply *reply, char id[ID_SIZE]) {
    struct store_receipt receipt;
    if (!check_key(request, reply) || !take_in(services, request, reply, &receipt))
        return false;
    memcpy(id, receipt.id, ID_SIZE);
    int64_t wait = negotiate_wait(request_header(request, "Prefer"), RESOURCES_WAIT_MAX);
    if (wait)
        start_waiting(request, receipt.id, wait);
    return true;
}

enum routes_next drapes_create(const struct http_services *services, struct request *request,
                               struct reply *reply) {
    struct results_choice choice;
    struct store_job job = {0};
    const struct waiting *waiting = request->state;
    char id[ID_SIZE];
    if (!results_choose(request, reply, FORMAT_RESULT, &choice))
        return ROUTES_DONE;
    if (waiting)
        memcpy(id, waiting->id, ID_SIZE);
    else if (!create(services, request, reply, id))
        return ROUTES_DONE;
    if (request->state)
        http_watch(request, id);
    enum store_answer answer = store_get(services->store, id, &job);
    bool wait = answer == STORE_OK && must_wait(request, &job);
    if (answer == STORE_EMPTY)
        resources_not_found(request, reply, "drape (it has been deleted)");
    else if (answer != STORE_OK)
        resources_store_failed(request, reply, answer);
    else if (!wait)
        reply_created(services, request, &job, &choice, reply);
    store_job_clear(&job);
    return wait ? ROUTES_WAIT : ROUTES_DONE;
}

/* ------------------------------------------------------------------ reading */

static bool read_filter(const struct request *request, struct reply *reply,
                        struct store_filter *filter) {
    const char *status = request_query(request, "status");
    filter->has_status = status != NULL;
    if (status && !store_status_from_name(status, &filter->status)) {
        reply_refuse(reply, request->id, API_INVALID_REQUEST,
                     "the query parameter 'status' must be queued, running, succeeded, failed or "
                     "cancelled");
        return false;
    }
    return resources_page(request, reply, &filter->limit, &filter->cursor);
}

enum routes_next drapes_list(const struct http_services *services, struct request *request,
                             struct reply *reply) {
    struct store_filter filter = {.owner = resources_owner(request)};
    struct store_page page;
    if (!read_filter(request, reply, &filter))
        return ROUTES_DONE;
    enum store_answer answer = store_list(services->store, &filter, &page);
    if (answer == STORE_OK)
        reply_text(reply, 200, "application/json", documents_list(&page));
    else
        resources_store_failed(request, reply, answer);
    reply_header(reply, "Cache-Control", "no-store");
    store_page_clear(&page);
    return ROUTES_DONE;
}

/* The `wait` of the query starts the waiting at the first call. */
static bool read_wait(struct request *request, struct reply *reply) {
    const char *text = request_query(request, "wait");
    int64_t seconds = 0;
    if (!text || request->state)
        return true;
    if (!request_parse_int(text, 0, RESOURCES_WAIT_MAX, &seconds)) {
        reply_refuse(reply, request->id, API_INVALID_REQUEST,
                     "the query parameter 'wait' must be a whole number of seconds from 0 to %d",
                     RESOURCES_WAIT_MAX);
        return false;
    }
    if (seconds)
        start_waiting(request, request->parameter, seconds);
    return true;
}

enum routes_next drapes_status(const struct http_services *services, struct request *request,
                               struct reply *reply) {
    struct store_job job = {0};
    bool wait = false;
    if (!read_wait(request, reply))
        return ROUTES_DONE;
    if (request->state && id_valid(request->parameter))
        http_watch(request, request->parameter);
    if (resources_job(services, request, reply, &job)) {
        wait = must_wait(request, &job);
        if (!wait)
            reply_status(reply, 200, &job);
    }
    store_job_clear(&job);
    return wait ? ROUTES_WAIT : ROUTES_DONE;
}

/* ------------------------------------------------------------------ the request as understood */

static bool stored_read_at(void *context, uint64_t offset, void *buffer, size_t length) {
    void *const *pair = context;
    const struct store_result *result = pair[1];
    uint64_t end = (uint64_t)result->length;
    return offset <= end && length <= end - offset &&
           store_result_read(pair[0], result, (int64_t)offset, buffer, length) == STORE_OK;
}

/* What the solve started from, if there is a result that tells. */
static bool read_start(const struct http_services *services, const char *id,
                       struct api_start *start) {
    struct store_result result;
    struct api_problem problem = {0};
    if (store_result_find(services->store, id, &result) != STORE_OK)
        return false;
    void *pair[] = {services->store, &result};
    struct api_reader reader = {stored_read_at, pair};
    struct api_columns *columns = malloc(sizeof *columns);
    bool found = columns && api_columns_open(&reader, columns, &problem) == API_OK;
    if (found)
        *start = columns->start;
    free(columns);
    return found;
}

static char *normalise(const struct http_services *services, const char *id, const char *bytes,
                       size_t length, struct api_problem *problem) {
    struct api_limits limits = resources_limits(services);
    struct arena *arena = arena_new(limits.max_memory);
    struct api_input input = {bytes, length, NULL, 0};
    struct api_request decoded;
    struct api_start start;
    bool started = read_start(services, id, &start);
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

enum routes_next drapes_request(const struct http_services *services, struct request *request,
                                struct reply *reply) {
    struct store_job job = {0};
    struct api_problem problem = {0};
    char *bytes = NULL;
    size_t length;
    if (!resources_job(services, request, reply, &job))
        return ROUTES_DONE;
    enum store_answer answer = store_request(services->store, job.id, &bytes, &length);
    if (answer == STORE_EMPTY)
        api_problem_set(&problem, API_GONE,
                        "the request has been removed (--retention, --retention-bytes)");
    char *text = answer == STORE_OK ? normalise(services, job.id, bytes, length, &problem) : NULL;
    if (text)
        reply_text(reply, 200, "application/json", text);
    else if (problem.id != API_OK)
        reply_problem(reply, request->id, &problem);
    else
        resources_store_failed(request, reply, answer);
    free(bytes);
    store_job_clear(&job);
    return ROUTES_DONE;
}

/* ------------------------------------------------------------------ ending */

enum routes_next drapes_cancel(const struct http_services *services, struct request *request,
                               struct reply *reply) {
    struct store_job job = {0};
    bool found = resources_job(services, request, reply, &job);
    store_job_clear(&job);
    if (!found)
        return ROUTES_DONE;
    enum store_answer answer = store_cancel(services->store, request->parameter);
    if (answer == STORE_EMPTY)
        return resources_not_found(request, reply, "drape");
    if (answer != STORE_OK && answer != STORE_CONFLICT)
        return resources_store_failed(request, reply, answer);
    if (resources_job(services, request, reply, &job))
        reply_status(reply, answer == STORE_OK ? 202 : 200, &job);
    store_job_clear(&job);
    return ROUTES_DONE;
}

enum routes_next drapes_delete(const struct http_services *services, struct request *request,
                               struct reply *reply) {
    struct store_job job = {0};
    bool found = resources_job(services, request, reply, &job);
    store_job_clear(&job);
    if (!found)
        return ROUTES_DONE;
    enum store_answer answer = store_delete(services->store, request->parameter);
    if (answer == STORE_EMPTY)
        return resources_not_found(request, reply, "drape");
    if (answer != STORE_OK)
        return resources_store_failed(request, reply, answer);
    reply_empty(reply, 204);
    return ROUTES_DONE;
}
