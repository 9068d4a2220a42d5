/* SPDX-License-Identifier: MIT */
/* POST /v1/drapes/{id}/map: the fields of a drape on the caller's points or mesh. */
#include "handlers.h"
#include "server/http/negotiate.h"
#include "server/http/stream.h"
#include "server/id.h"
#include "server/work/mapper.h"
#include <stdlib.h>
#include <string.h>

/* ------------------------------------------------------------------ the answer */

static ssize_t read_task(void *context, char *buffer, size_t size) {
    struct api_problem problem;
    return encoder_read(mapper_result(context, &problem), buffer, size);
}

static void free_task(void *context) {
    mapper_drop(context);
}

/* Of a task that is done, which it takes over. */
static void reply_task(struct call *call, struct map_task *task) {
    struct api_problem problem = {0};
    struct encoder *encoder = mapper_result(task, &problem);
    if (!encoder) {
        reply_problem(call->reply, &problem);
        mapper_drop(task);
        return;
    }
    const char *binning = encoder_binning(encoder);
    if (*binning)
        reply_header(call->reply, "Draped-Binning", "%s", binning);
    reply_header(call->reply, "Vary", "Accept, Accept-Encoding");
    reply_header(call->reply, "Cache-Control", "no-store");
    const struct stream_source source = {read_task, free_task, task, NULL, encoder_length(encoder)};
    stream_reply(call->request, call->reply, mapper_format(task)->media_type,
                 compress_choose(request_header(call->request, "Accept-Encoding")), &source);
}

/* ------------------------------------------------------------------ waiting for it */

/* With the task in `request->state`, until the reply takes it over. */
static enum http_next continue_task(struct call *call) {
    struct request *request = call->request;
    struct map_task *task = request->state;
    bool done = mapper_done(task);
    if (!done && !request->stopping) {
        request->wake_at = INT64_MAX; /* the mapper notifies */
        return HTTP_WAIT;
    }
    request->state = NULL;
    if (done) {
        reply_task(call, task);
        return HTTP_DONE;
    }
    mapper_drop(task);
    return call_draining(call);
}

/* ------------------------------------------------------------------ the beginning */

/* Sets the order's format and options by headers and query. False: the reply says why not. */
static bool read_order(struct call *call, struct mapper_order *order) {
    const char *type = request_header(call->request, "Content-Type");
    struct call_choice choice;
    if (!call_choose(call, FORMAT_MAP, &choice))
        return false;
    order->format = choice.format;
    order->options = choice.options;
    order->nastran = type && negotiate_is_type(type, "text/x-nastran");
    order->inlet = request_query(call->request, "inlet_elements");
    return true;
}

/* The drape's result. False: the reply says why there is none. */
static bool find_result(struct call *call, struct mapper_order *order) {
    struct store_job job = {0};
    if (!call_find_job(call, &job))
        return false;
    bool found = results_ready(call, &job);
    enum store_answer answer =
        found ? store_result_find(call->services->store, job.id, &order->result) : STORE_OK;
    if (answer == STORE_EMPTY)
        reply_refuse(call->reply, API_GONE, "the result has been removed");
    else if (answer != STORE_OK)
        call_store_failed(call, answer);
    store_job_clear(&job);
    return found && answer == STORE_OK;
}

enum http_next maps_create(struct call *call) {
    struct request *request = call->request;
    struct mapper_order order = {.id = request->parameter};
    char subject[ID_SIZE];
    if (request->state)
        return continue_task(call);
    if (!read_order(call, &order) || !find_result(call, &order))
        return HTTP_DONE;
    id_make(subject);
    http_watch(request, subject);
    request->state =
        mapper_begin(call->services->mapper, &order, &request->body, request->body_length, subject);
    request->state_free = free_task;
    if (request->state)
        return continue_task(call);
    reply_header(call->reply, "Retry-After", "5");
    reply_refuse(call->reply, API_UNAVAILABLE,
                 "%d maps are being made or fetched already: try again later", MAPPER_MAPS_MAX);
    return HTTP_DONE;
}
