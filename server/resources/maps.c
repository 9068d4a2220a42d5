/* SPDX-License-Identifier: MIT */
/* POST /v1/drapes/{id}/map: the fields of a drape on the caller's points or mesh. */
#include "resources.h"
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
static void reply_task(const struct request *request, struct map_task *task, struct reply *reply) {
    struct api_problem problem = {0};
    struct encoder *encoder = mapper_result(task, &problem);
    if (!encoder) {
        reply_problem(reply, request->id, &problem);
        mapper_drop(task);
        return;
    }
    const char *binning = encoder_binning(encoder);
    if (*binning)
        reply_header(reply, "Draped-Binning", "%s", binning);
    reply_header(reply, "Vary", "Accept, Accept-Encoding");
    reply_header(reply, "Cache-Control", "no-store");
    const struct stream_source source = {read_task, free_task, task, NULL, encoder_length(encoder)};
    stream_reply(request, reply, mapper_format(task)->media_type,
                 compress_choose(request_header(request, "Accept-Encoding")), &source);
}

/* ------------------------------------------------------------------ waiting for it */

/* `request->state`: the task, until the reply takes it over. */
static void drop_state(void *state) {
    mapper_drop(state);
}

static enum routes_next go_on(struct request *request, struct reply *reply) {
    struct map_task *task = request->state;
    bool done = mapper_done(task);
    if (!done && !request->stopping) {
        request->wake_at = INT64_MAX; /* the mapper tells */
        return ROUTES_WAIT;
    }
    request->state = NULL;
    if (done) {
        reply_task(request, task, reply);
        return ROUTES_DONE;
    }
    mapper_drop(task);
    return resources_draining(request, reply);
}

/* ------------------------------------------------------------------ the beginning */

/* Sets the order's format and options by headers and query. */
static bool read_order(const struct request *request, struct reply *reply,
                       struct mapper_order *order) {
    const char *type = request_header(request, "Content-Type");
    struct results_choice choice;
    if (!results_choose(request, reply, FORMAT_MAP, &choice))
        return false;
    order->format = choice.format;
    order->options = choice.options;
    order->nastran = type && negotiate_is_type(type, "text/x-nastran");
    order->inlet = request_query(request, "inlet_elements");
    return true;
}

/* The drape's result. False: the reply says why there is none. */
static bool find_result(const struct http_services *services, const struct request *request,
                        struct reply *reply, struct mapper_order *order) {
    struct store_job job = {0};
    if (!resources_job(services, request, reply, &job))
        return false;
    bool found = results_ready(request, &job, reply);
    enum store_answer answer =
        found ? store_result_find(services->store, job.id, &order->result) : STORE_OK;
    if (answer == STORE_EMPTY)
        reply_refuse(reply, request->id, API_GONE, "the result has been removed");
    else if (answer != STORE_OK)
        resources_store_failed(request, reply, answer);
    store_job_clear(&job);
    return found && answer == STORE_OK;
}

enum routes_next maps_create(const struct http_services *services, struct request *request,
                             struct reply *reply) {
    struct mapper_order order = {.id = request->parameter};
    char subject[ID_SIZE];
    if (request->state)
        return go_on(request, reply);
    if (!read_order(request, reply, &order) || !find_result(services, request, reply, &order))
        return ROUTES_DONE;
    id_make(subject);
    http_watch(request, subject);
    request->state =
        mapper_begin(services->mapper, &order, &request->body, request->body_length, subject);
    request->state_free = drop_state;
    if (request->state)
        return go_on(request, reply);
    reply_header(reply, "Retry-After", "5");
    reply_refuse(reply, request->id, API_UNAVAILABLE,
                 "%d maps are being made or fetched already: try again later", MAPPER_MAPS_MAX);
    return ROUTES_DONE;
}
