/* SPDX-License-Identifier: MIT */
/* POST /v1/drapes/{id}/map: the fields of a drape on the caller's points or mesh; of a study those
 * of one of its variants, of a laminate those of its plies. */
#include "checking.h"
#include "handlers.h"
#include "items.h"
#include "laminates.h"
#include "server/config.h"
#include "server/http/stream.h"
#include "server/work/stored_result.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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

/* ------------------------------------------------------------------ the columns */

/* Copies the stored result to the file, on a thread of the pool. */
static bool write_columns(void *context, int file) {
    return stored_result_copy(context, file);
}

bool maps_take_columns(struct call *call, struct document_pool_order *order, char **request) {
    struct store_job job = {0};
    struct stored_result *stored = NULL;
    bool good = call_find_job(call, &job) && results_ready(call, &job);
    if (good) {
        stored = calloc(1, sizeof *stored);
        good = stored && call_stored_result(call, job.id, stored);
    }
    if (good && request) {
        *request = call_stored_request(call, job.id, &order->length[CHECKER_SECOND]);
        order->document[CHECKER_SECOND] = *request;
        good = *request != NULL;
    }
    if (good)
        order->columns = (struct document_pool_columns){write_columns, free, stored,
                                                        (size_t)stored->result.length};
    else if (!call->reply->status)
        reply_no_memory(call->reply);
    if (!good)
        free(stored);
    store_job_clear(&job);
    return good;
}

/* ------------------------------------------------------------------ the call */

/* The query goes along as the checker takes it: of each parameter its name and its value, both
 * zero-terminated. */
bool maps_begin(struct call *call, struct document_pool_order *order, char *record) {
    struct request *request = call->request;
    char *options = NULL;
    FILE *stream = open_memstream(&options, &order->length[CHECKER_OPTIONS]);
    for (size_t k = 0; stream && k < request->query_count; k++)
        fprintf(stream, "%s%c%s%c", request->query[k].name, 0, request->query[k].value, 0);
    if (stream && fclose(stream) == 0) {
        order->document[CHECKER_OPTIONS] = options;
        (void)checking_keep(call, order);
    } else {
        reply_no_memory(call->reply);
    }
    free(options);
    free(record);
    if (!request->state)
        free(order->columns.context);
    return request->state != NULL;
}

/* With an entity tag the headers for caches are the caller's. */
enum http_next maps_answer(struct call *call, const struct format *format, const char *etag) {
    enum checking_state state = checking_look(call, call->request->state);
    if (state != CHECKING_PASSED)
        return state == CHECKING_WAIT ? HTTP_WAIT : HTTP_DONE;
    struct output *output = calloc(1, sizeof *output);
    if (!output) {
        reply_no_memory(call->reply);
        return HTTP_DONE;
    }
    output->check = call->request->state;
    call->request->state = NULL; /* the reply takes it over */
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
    return HTTP_DONE;
}

enum http_next maps_create(struct call *call) {
    const struct file_format *mesh = items_file_of(request_header(call->request, "Content-Type"));
    struct call_choice choice;
    if (!call_choose(call, FORMAT_MAP, &choice))
        return HTTP_DONE;
    if (!call->request->state) { /* the first call */
        struct document_pool_order order = checking_order(call, CHECKER_MAP);
        char *record = NULL;
        bool begun;
        size_t sample;
        order.mesh = mesh ? mesh->name : NULL;
        order.id = call->request->parameter;
        order.format = choice.format->name;
        if (call->kind == STORE_STUDY) {
            order.kind = CHECKER_SAMPLE_MAP;
            begun = studies_read_sample(call, &sample) && studies_begin(call, &order, sample);
        } else {
            begun = (call->kind == STORE_LAMINATE ? laminates_take_columns(call, &order, &record)
                                                  : maps_take_columns(call, &order, &record)) &&
                    maps_begin(call, &order, record);
        }
        if (!begun)
            return HTTP_DONE;
    }
    return maps_answer(call, choice.format, NULL);
}
