/* SPDX-License-Identifier: MIT */
/* POST /v1/drapes/{id}/map: the fields of a drape on the caller's points or mesh; of a study those
 * of one of its variants, of a laminate those of its plies. */
#include "checking.h"
#include "handlers.h"
#include "laminates.h"
#include "server/config.h"
#include "server/http/negotiate.h"
#include "server/http/stream.h"
#include "server/spool.h"
#include "server/work/stored_result.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { COPY_BYTES = 256 * 1024 };

/* ------------------------------------------------------------------ the answer */

/* What is read of a map's output, and how far. */
struct output {
    struct check *check;
    uint64_t offset;
};

static ssize_t read_output(void *context, char *buffer, size_t size) {
    struct output *output = context;
    ssize_t got = check_read(output->check, output->offset, buffer, size);
    output->offset += got > 0 ? (uint64_t)got : 0;
    return got;
}

static void free_output(void *context) {
    struct output *output = context;
    check_drop(output->check);
    free(output);
}

/* Of a check that is done; the reply takes it over. With an entity tag its headers are the
 * caller's. */
static void reply_output(struct call *call, const struct format *format, const char *etag) {
    struct output *output = calloc(1, sizeof *output);
    if (!output) {
        reply_refuse(call->reply, API_UNAVAILABLE, "there is no memory for this now");
        return;
    }
    output->check = call->request->state;
    call->request->state = NULL;
    const struct checker_answer *answer = check_answer(output->check);
    const struct stream_source source = {read_output, free_output, output, etag,
                                         answer->output_length};
    if (*answer->note)
        reply_header(call->reply, "Draped-Binning", "%s", answer->note);
    if (!etag) {
        reply_header(call->reply, "Vary", "Accept, Accept-Encoding");
        reply_header(call->reply, "Cache-Control", "no-store");
    }
    stream_reply(call->request, call->reply, format->media_type,
                 compress_choose(request_header(call->request, "Accept-Encoding")), &source);
}

/* ------------------------------------------------------------------ the columns */

/* Copies a stored result to the file, on a thread of the pool. */
static bool write_columns(void *context, int file) {
    struct stored_result *stored = context;
    struct api_reader reader = stored_result_reader(stored);
    char *bytes = malloc(COPY_BYTES);
    uint64_t end = (uint64_t)stored->result.length;
    bool good = bytes != NULL;
    for (uint64_t at = 0; good && at < end; at += COPY_BYTES) {
        size_t length = end - at < COPY_BYTES ? (size_t)(end - at) : COPY_BYTES;
        good =
            reader.read_at(reader.context, at, bytes, length) && spool_write(file, bytes, length);
    }
    free(bytes);
    return good;
}

/* The job's result, malloc'ed. NULL: the reply says why there is none. */
static struct stored_result *find_result(struct call *call, const struct store_job *job) {
    struct stored_result *stored = NULL;
    if (results_ready(call, job)) {
        stored = calloc(1, sizeof *stored);
        enum store_answer answer = STORE_BUSY;
        if (stored) {
            stored->store = call->services->store;
            answer = store_result_find(stored->store, job->id, &stored->result);
        }
        if (answer == STORE_EMPTY)
            reply_refuse(call->reply, API_GONE, "the result has been removed");
        else if (answer != STORE_OK)
            call_store_failed(call, answer);
        if (answer != STORE_OK) {
            free(stored);
            stored = NULL;
        }
    }
    return stored;
}

/* False: the reply says why there is none. */
static bool take_request(struct call *call, const char *id, struct document_pool_order *order,
                         char **request) {
    enum store_answer answer =
        store_request(call->services->store, id, request, &order->length[CHECKER_SECOND]);
    order->document[CHECKER_SECOND] = *request;
    if (answer != STORE_OK)
        jobs_request_failed(call, answer);
    return answer == STORE_OK;
}

bool maps_take_columns(struct call *call, struct document_pool_order *order, char **request) {
    struct store_job job = {0};
    struct stored_result *stored = call_find_job(call, &job) ? find_result(call, &job) : NULL;
    if (stored && request && !take_request(call, job.id, order, request)) {
        free(stored);
        stored = NULL;
    }
    if (stored)
        order->columns = (struct document_pool_columns){write_columns, free, stored,
                                                        (size_t)stored->result.length};
    store_job_clear(&job);
    return stored != NULL;
}

/* ------------------------------------------------------------------ the call */

/* The query as the checker takes it, malloc'ed: of each parameter its name and its value, both
 * zero-terminated. NULL without memory. */
static char *copy_options(const struct request *request, size_t *length) {
    char *options = NULL;
    FILE *stream = open_memstream(&options, length);
    if (!stream)
        return NULL;
    for (size_t k = 0; k < request->query_count; k++)
        fprintf(stream, "%s%c%s%c", request->query[k].name, 0, request->query[k].value, 0);
    return fclose(stream) == 0 ? options : NULL;
}

bool maps_begin(struct call *call, struct document_pool_order *order, char *record) {
    struct request *request = call->request;
    char *options = copy_options(request, &order->length[CHECKER_OPTIONS]);
    order->document[CHECKER_OPTIONS] = options;
    if (options)
        (void)checking_keep(call, order);
    else
        reply_refuse(call->reply, API_UNAVAILABLE, "there is no memory for this now");
    free(options);
    free(record);
    if (!request->state)
        free(order->columns.context);
    return request->state != NULL;
}

enum http_next maps_answer(struct call *call, const struct format *format, const char *etag) {
    enum checking_state state = checking_look(call, call->request->state);
    if (state == CHECKING_PASSED)
        reply_output(call, format, etag);
    return state == CHECKING_WAIT ? HTTP_WAIT : HTTP_DONE;
}

/* False: the reply says why no map is begun. */
static bool begin_map(struct call *call, const struct call_choice *choice) {
    const char *type = request_header(call->request, "Content-Type");
    struct document_pool_order order = checking_order(call, CHECKER_MAP);
    char *record = NULL;
    bool stack = call->kind == STORE_LAMINATE;
    size_t sample;
    order.nastran = type && negotiate_is_type(type, "text/x-nastran");
    order.id = call->request->parameter;
    order.format = choice->format->name;
    if (call->kind == STORE_STUDY) {
        order.kind = CHECKER_SAMPLE_MAP;
        return studies_read_sample(call, &sample) && studies_begin(call, &order, sample);
    }
    if (!(stack ? laminates_take_columns(call, &order, &record)
                : maps_take_columns(call, &order, &record)))
        return false;
    return maps_begin(call, &order, record);
}

enum http_next maps_create(struct call *call) {
    struct call_choice choice;
    if (!call_choose(call, FORMAT_MAP, &choice) ||
        (!call->request->state && !begin_map(call, &choice)))
        return HTTP_DONE;
    return maps_answer(call, choice.format, NULL);
}
