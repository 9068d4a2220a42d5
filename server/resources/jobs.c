/* SPDX-License-Identifier: MIT */
/*
 * Jobs of any kind: submit, list, status, request as understood, cancel, delete. `call->kind` is
 * the kind that the path is about.
 */
#include "checking.h"
#include "documents.h"
#include "forms.h"
#include "handlers.h"
#include "items.h"
#include "laminates.h"
#include "queue_rate.h"
#include "server/clock.h"
#include "server/config.h"
#include "server/http/negotiate.h"
#include "server/work/stored_result.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void reply_status(struct call *call, int status, const struct store_job *job) {
    reply_text(call->reply, status, "application/json",
               job->kind == STORE_LAMINATE ? laminates_status(call->services->store, job)
                                           : documents_status(job, NULL));
    reply_header(call->reply, "Cache-Control", "no-store");
}

/* ------------------------------------------------------------------ waiting for the end */

/* `request->state` of a call that may wait for the end of a job. */
struct waiting {
    char id[ID_SIZE];          /* of the job; "": it is not stored yet */
    int64_t begun, deadline;   /* `clock_ms`; equal: it does not wait */
    bool unpromised;           /* stored, but not yet so as to survive a power cut... */
    bool queued;               /* ...which its end makes it, when it had to be queued */
    struct check *check;       /* of a posted job, until it is stored */
    struct store_item surface; /* the stored one that it names, where there is no form of it */
    struct forms_found form;   /* of the surface, or the one that the check has made */
    char *materials;           /* the owner's that it names: CHECKER_MATERIALS */
    size_t materials_length;
    struct results_early *early; /* of the result, while that is being stored */
};

static void free_waiting(void *state) {
    struct waiting *waiting = state;
    check_drop(waiting->check);
    store_item_clear(&waiting->surface);
    forms_close(&waiting->form);
    free(waiting->materials);
    results_free_early(waiting->early);
    free(waiting);
}

/* False without memory: the reply says so. */
static bool start_waiting(struct call *call, const char *id, int64_t seconds) {
    struct waiting *waiting = calloc(1, sizeof *waiting);
    if (!waiting) {
        reply_no_memory(call->reply);
        return false;
    }
    snprintf(waiting->id, sizeof waiting->id, "%.32s", id);
    waiting->form.file = -1;
    waiting->begun = clock_ms();
    waiting->deadline = waiting->begun + seconds * 1000;
    call->request->state = waiting;
    call->request->state_free = free_waiting;
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

/* ------------------------------------------------------------------ POST */

/* The check of the body, with the stored surface and the materials that it names once these are
 * known. False: the reply says why there is none. */
static bool begin_check(struct call *call) {
    struct waiting *waiting = call->request->state;
    static const enum checker_kind checks[STORE_KIND_COUNT] = {[STORE_DRAPE] = CHECKER_DRAPE,
                                                               [STORE_STUDY] = CHECKER_STUDY,
                                                               [STORE_LAMINATE] = CHECKER_LAMINATE};
    struct document_pool_order order = checking_order(call, checks[call->kind]);
    order.document[CHECKER_SECOND] = waiting->surface.definition;
    order.length[CHECKER_SECOND] = waiting->surface.definition_length;
    order.form_file = waiting->form.file;
    order.length[CHECKER_FORM] = waiting->form.length;
    order.document[CHECKER_MATERIALS] = waiting->materials;
    order.length[CHECKER_MATERIALS] = waiting->materials_length;
    check_drop(waiting->check);
    waiting->check = checking_begin(call, &order);
    return waiting->check != NULL;
}

/* 422 for a body that names a stored surface which is not there, or not any more. */
static void refuse_surface(struct call *call, const char *surface) {
    const char *pointer = call->kind == STORE_STUDY ? "/drape/surface/id" : "/surface/id";
    struct api_problem problem = {0};
    api_problem_add(&problem, pointer, "there is no stored surface '%s'", surface);
    reply_problem(call->reply, &problem);
}

/* 429 for the bound that the submission would have been over. */
static void refuse_full(struct call *call, enum store_bound bound) {
    const struct config *config = call->services->config;
    struct reply *reply = call->reply;
    int retry = queue_rate_retry_seconds(bound == STORE_BOUND_QUEUE ? config->queue_limit
                                                                    : config->owner_queue);
    if (bound == STORE_BOUND_OWNER_BYTES)
        call_bytes_full(call);
    else if (bound == STORE_BOUND_OWNER_QUEUED)
        reply_refuse_for(reply, retry, API_QUOTA,
                         "you have as many drapes and studies waiting as one owner may have: %lld "
                         "(--owner-queue)",
                         (long long)config->owner_queue);
    else if (bound == STORE_BOUND_SHARE)
        reply_refuse_for(reply, retry, API_QUOTA,
                         "you have as many drapes and studies waiting as the queue has free "
                         "places, and these are kept for others (--queue-limit): try again later");
    else
        reply_refuse_for(reply, retry, API_QUEUE_FULL,
                         "the queue is full (--queue-limit): try again later");
}

/* Queues what the check has passed: the body, with its materials in it. `waiting->id` is the job's
 * then. False: the reply says why not. */
static bool submit_checked(struct call *call, const struct api_check *check) {
    const struct request *request = call->request;
    const struct config *config = call->services->config;
    struct waiting *waiting = request->state;
    struct store_receipt receipt;
    const char *key = request_header(request, "Idempotency-Key");
    const size_t filled = check->filled_length;
    char *text = filled ? checking_text(waiting->check, 0, filled) : NULL;
    waiting->unpromised = waiting->deadline > waiting->begun && !key;
    const struct store_submission submission = {
        .kind = call->kind,
        .total = (int64_t)check->variants,
        .request = filled ? text : request->body,
        .request_length = filled ? filled : request->body_length,
        .digest = check->digest,
        .surface = check->surface[0] ? check->surface : NULL,
        .owner = request->owner,
        .key = key,
        .origin = request->id,
        .quota = {.queued = config->owner_queue, .bytes = config->owner_bytes},
        .unpromised = waiting->unpromised,
    };
    enum store_answer answer = STORE_BUSY;
    if (call->kind == STORE_LAMINATE)
        answer = laminates_submit(call, waiting->check, &submission, &receipt);
    else if (!filled || text)
        answer = store_submit(call->services->store, &submission, &receipt);
    free(text);
    if (answer == STORE_OK) {
        memcpy(waiting->id, receipt.id, sizeof waiting->id);
        waiting->queued = receipt.status == STORE_QUEUED;
        memcpy(call->request->drape, receipt.id, sizeof receipt.id);
    } else if (answer == STORE_CONFLICT) {
        reply_refuse(call->reply, API_IDEMPOTENCY_MISMATCH,
                     "the Idempotency-Key was used with another body before: choose a new key");
    } else if (answer == STORE_FULL) {
        refuse_full(call, receipt.full);
    } else if (answer == STORE_EMPTY) { /* deleted since it was read */
        refuse_surface(call, check->surface);
    } else {
        call_store_failed(call, answer);
    }
    return answer == STORE_OK;
}

/* Goes on with the check, as far as that has come, up to the submission. Fetches what the request
 * names beside itself: the caller's materials, or a stored surface. */
static enum checking_state accept_body(struct call *call) {
    struct waiting *waiting = call->request->state;
    for (;;) {
        enum checking_state state = checking_look(call, waiting->check);
        if (state != CHECKING_PASSED)
            return state;
        const struct api_check *check = &check_answer(waiting->check)->check;
        if (!check->needs_surface && !check->needs_materials) {
            forms_keep(call, waiting->check, &waiting->form);
            return submit_checked(call, check) ? CHECKING_PASSED : CHECKING_REFUSED;
        }
        if (check->needs_materials) {
            char *names =
                checking_text(waiting->check, 0, check_answer(waiting->check)->output_length);
            if (names)
                waiting->materials =
                    items_collect_materials(call, names, &waiting->materials_length);
            else
                reply_no_memory(call->reply);
            free(names);
            if (!waiting->materials || !begin_check(call))
                return CHECKING_REFUSED;
            continue;
        }
        enum store_answer answer = forms_find(call, check, &waiting->form, &waiting->surface);
        if (answer == STORE_EMPTY)
            refuse_surface(call, check->surface);
        else if (answer == STORE_ALTERED)
            call_altered(call, check->surface);
        else if (answer != STORE_OK)
            reply_refuse(call->reply, API_UNAVAILABLE, "the store is %s",
                         store_answer_name(answer));
        if (answer != STORE_OK || !begin_check(call))
            return CHECKING_REFUSED;
    }
}

/* 202 and the status, or, when it ended while the caller waited, what it ended with. Only here the
 * job is promised: where its end has not made it durable, the disk is waited for now. */
static void reply_created(struct call *call, const struct store_job *job,
                          const struct call_choice *choice) {
    const struct waiting *waiting = call->request->state;
    bool ended = store_status_ended(job->status), result = job->kind != STORE_LAMINATE;
    bool waited = ended && waiting->begun != waiting->deadline;
    bool open = waiting->unpromised && !(waiting->queued && ended);
    enum store_answer answer = open ? store_flush(call->services->store) : STORE_OK;
    if (answer != STORE_OK) {
        call_store_failed(call, answer);
        return;
    }
    if (waited && result)
        results_reply(call, job, choice, waiting->early);
    else
        reply_status(call, waited ? 200 : 202, job); /* a laminate has no result of its own */
    if (waited)
        reply_header(call->reply, "Preference-Applied", "wait");
    if (waited && result && call->reply->status == 200)
        reply_header(call->reply, "Content-Location", "/v1/%s/%s/result",
                     documents_collection(job->kind), job->id);
    reply_header(call->reply, "Location", "/v1/%s/%s", documents_collection(job->kind), job->id);
}

/* Idempotency keys of other bytes need be no text, which PostgreSQL does not take. */
enum http_next jobs_create(struct call *call) {
    struct call_choice choice;
    struct store_job job = {0};
    enum http_next next = HTTP_DONE;
    if (!call_choose(call, FORMAT_RESULT, &choice))
        return HTTP_DONE;
    if (!call->request->state) { /* the first call */
        int64_t wait = negotiate_wait(request_header(call->request, "Prefer"), CALL_WAIT_MAX);
        const char *key = request_header(call->request, "Idempotency-Key");
        size_t length = 0;
        queue_rate_sample(call->services->store);
        while (key && key[length] >= ' ' && key[length] <= '~')
            length++;
        if (key && (length == 0 || length >= STORE_KEY_SIZE || key[length])) {
            reply_refuse(call->reply, API_INVALID_REQUEST,
                         "the Idempotency-Key must have 1 to %d printable ASCII characters",
                         STORE_KEY_SIZE - 1);
            return HTTP_DONE;
        }
        if ((wait && !http_take_stream(call->request, call->reply)) ||
            !start_waiting(call, "", wait) || !begin_check(call))
            return HTTP_DONE;
    }
    struct waiting *waiting = call->request->state;
    enum checking_state state = waiting->id[0] ? CHECKING_PASSED : accept_body(call);
    if (state != CHECKING_PASSED)
        return state == CHECKING_WAIT ? HTTP_WAIT : HTTP_DONE;
    if (waiting->deadline > waiting->begun)
        http_watch(call->request, waiting->id, JOB_RESULT_READABLE);
    enum store_answer answer = store_get(call->services->store, waiting->id, &job);
    if (answer == STORE_EMPTY)
        reply_refuse(call->reply, API_NOT_FOUND, "the %s has been deleted",
                     store_kind_name(call->kind));
    else if (answer != STORE_OK)
        call_store_failed(call, answer);
    else if (must_wait(call->request, &job))
        next = HTTP_WAIT;
    else
        reply_created(call, &job, &choice);
    if (next == HTTP_WAIT && !waiting->early) /* make ready what there is of the answer */
        waiting->early = results_begin_early(call, &job, &choice);
    store_job_clear(&job);
    return next;
}

/* ------------------------------------------------------------------ reading */

enum http_next jobs_list(struct call *call) {
    struct store_filter filter = {.kind = call->kind, .owner = call_owner(call)};
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
        reply_text(call->reply, 200, "application/json", documents_list(call->kind, &page));
    else
        call_store_failed(call, answer);
    reply_header(call->reply, "Cache-Control", "no-store");
    store_page_clear(&page);
    return HTTP_DONE;
}

/* The `wait` of the query starts the waiting at the first call. */
enum http_next jobs_status(struct call *call) {
    struct request *request = call->request;
    const char *text = request_query(request, "wait");
    struct store_job job = {0};
    enum http_next next = HTTP_DONE;
    int64_t seconds = 0;
    if (text && !request_parse_int(text, 0, CALL_WAIT_MAX, &seconds)) {
        reply_refuse(call->reply, API_INVALID_REQUEST,
                     "the query parameter 'wait' must be a whole number of seconds from 0 to %d",
                     CALL_WAIT_MAX);
        return HTTP_DONE;
    }
    if (seconds && !request->state &&
        (!http_take_stream(request, call->reply) ||
         !start_waiting(call, request->parameter, seconds)))
        return HTTP_DONE;
    if (request->state && id_valid(request->parameter))
        http_watch(request, request->parameter, JOB_CHANGED);
    if (call_find_job(call, &job)) {
        if (must_wait(request, &job))
            next = HTTP_WAIT;
        else
            reply_status(call, 200, &job);
    }
    store_job_clear(&job);
    return next;
}

/* ------------------------------------------------------------------ the request as understood */

/* The first call begins to write down the stored request with every default filled in. */
enum http_next jobs_request(struct call *call) {
    bool drape = call->kind == STORE_DRAPE;
    struct stored_result stored = {.store = call->services->store};
    struct api_columns *columns = NULL; /* of a result, which say what the solve started from */
    struct api_problem problem = {0};
    struct store_job job = {0};
    char *bytes = NULL;
    if (call->request->state)
        return checking_answer(call, checking_reply_json);
    struct document_pool_order order =
        checking_order(call, drape ? CHECKER_NORMALISE : CHECKER_UNDERSTOOD);
    if (call_find_job(call, &job) &&
        (bytes = call_stored_request(call, job.id, &order.length[CHECKER_BODY]))) {
        order.document[CHECKER_BODY] = bytes;
        order.body_file = -1;
        struct api_reader reader = stored_result_reader(&stored);
        if (drape && store_result_find(stored.store, job.id, &stored.result) == STORE_OK &&
            (columns = malloc(sizeof *columns)) &&
            api_columns_open(&reader, columns, &problem) == API_OK)
            order.start = &columns->start;
        (void)checking_keep(call, &order);
    }
    free(columns);
    free(bytes);
    store_job_clear(&job);
    return call->request->state ? checking_answer(call, checking_reply_json) : HTTP_DONE;
}

/* ------------------------------------------------------------------ ending */

/* POST cancels it, DELETE removes it. */
enum http_next jobs_end(struct call *call) {
    struct store *store = call->services->store;
    const char *id = call->request->parameter;
    bool cancel = !strcmp(call->request->method, "POST");
    struct store_job job = {0};
    if (!call_find_job(call, &job))
        return HTTP_DONE;
    store_job_clear(&job);
    enum store_answer answer = cancel ? store_cancel(store, id) : store_delete(store, id);
    if (answer == STORE_EMPTY)
        return call_not_found(call, store_kind_name(call->kind));
    if (answer != STORE_OK && (!cancel || answer != STORE_CONFLICT))
        return call_store_failed(call, answer);
    if (!cancel)
        reply_empty(call->reply, 204);
    else if (call_find_job(call, &job))
        reply_status(call, answer == STORE_OK ? 202 : 200, &job);
    store_job_clear(&job);
    return HTTP_DONE;
}
