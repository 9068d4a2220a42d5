/* SPDX-License-Identifier: MIT */
/* One variant of a study: its drape request, /v1/studies/{id}/variants/{k}/request, and with
 * ?sample=k its drape in place of the study's own result, or for a map. */
#include "checking.h"
#include "handlers.h"
#include <stdlib.h>

/* The segment of the path that has the number of the variant. */
enum { VARIANT_SEGMENT = 4 };

bool studies_begin(struct call *call, struct document_pool_order *order, size_t variant) {
    struct store_job job = {0};
    struct store_item surface = {0};
    enum store_answer answer = STORE_OK;
    char *request = NULL;
    if (call_find_job(call, &job) && results_ready(call, &job))
        request = call_stored_request(call, job.id, &order->length[CHECKER_REQUEST]);
    if (request && job.surface[0])
        answer = store_item_get(call->services->store, STORE_SURFACES, NULL, job.surface, &surface);
    if (answer == STORE_EMPTY)
        reply_refuse(call->reply, API_GONE, "the surface of the study has been deleted");
    else if (answer == STORE_ALTERED)
        call_altered(call, job.surface);
    else if (answer != STORE_OK)
        call_store_failed(call, answer);
    else if (request && maps_take_columns(call, order, NULL)) {
        order->variant = variant;
        order->document[CHECKER_REQUEST] = request;
        order->document[CHECKER_SECOND] = surface.definition;
        order->length[CHECKER_SECOND] = surface.definition_length;
        maps_begin(call, order, NULL);
    }
    free(request);
    store_item_clear(&surface);
    store_job_clear(&job);
    return call->request->state != NULL;
}

enum http_next studies_variant(struct call *call) {
    int64_t variant = 0;
    if (!request_parse_int(call->request->segments[VARIANT_SEGMENT], 0, INT32_MAX, &variant))
        return call_not_found(call, "variant");
    struct document_pool_order order = checking_order(call, CHECKER_VARIANT);
    if (!call->request->state && !studies_begin(call, &order, (size_t)variant))
        return HTTP_DONE;
    return checking_answer(call, checking_reply_json);
}

bool studies_read_sample(struct call *call, size_t *sample) {
    int64_t number = 0;
    const char *text = request_query(call->request, "sample");
    if (text && request_parse_int(text, 0, INT32_MAX, &number)) {
        *sample = (size_t)number;
        return true;
    }
    reply_refuse(call->reply, API_INVALID_REQUEST,
                 text ? "the query parameter 'sample' must be the number of a variant, from 0"
                      : "the query parameter 'sample' is required: the number of the variant whose "
                        "drape is to be mapped");
    return false;
}

enum http_next studies_sample(struct call *call) {
    struct call_choice choice;
    size_t sample;
    if (!call_choose(call, FORMAT_RESULT, &choice) || !studies_read_sample(call, &sample))
        return HTTP_DONE;
    struct document_pool_order order = checking_order(call, CHECKER_SAMPLE);
    order.id = call->request->parameter;
    order.format = choice.format->name;
    if (!call->request->state && !studies_begin(call, &order, sample))
        return HTTP_DONE;
    return maps_answer(call, choice.format, NULL);
}
