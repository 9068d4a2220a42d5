/* SPDX-License-Identifier: MIT */
/* One variant of a study: its drape request, /v1/studies/{id}/variants/{k}/request, and with
 * ?sample=k its drape in place of the study's own result, or for a map. */
#include "checking.h"
#include "handlers.h"
#include <stdlib.h>

/* The segment of the path that has the number of the variant. */
enum { VARIANT_SEGMENT = 4 };

/* The documents of the study; false: the reply says why they cannot be had. The caller frees both
 * in any case. */
static bool fetch_documents(struct call *call, const struct store_job *job, char **request,
                            size_t *length, struct store_item *surface) {
    struct store *store = call->services->store;
    enum store_answer answer = store_request(store, job->id, request, length);
    if (answer != STORE_OK) {
        jobs_request_failed(call, answer);
        return false;
    }
    answer = job->surface[0] ? store_item_get(store, STORE_SURFACES, NULL, job->surface, surface)
                             : STORE_OK;
    if (answer == STORE_EMPTY)
        reply_refuse(call->reply, API_GONE, "the surface of the study has been deleted");
    else if (answer != STORE_OK)
        call_store_failed(call, answer);
    return answer == STORE_OK;
}

bool studies_begin(struct call *call, struct document_pool_order *order, size_t variant) {
    struct store_job job = {0};
    struct store_item surface = {0};
    char *request = NULL;
    size_t length = 0;
    if (call_find_job(call, &job) && results_ready(call, &job) &&
        fetch_documents(call, &job, &request, &length, &surface) &&
        maps_take_columns(call, order, NULL)) {
        order->variant = variant;
        order->document[CHECKER_REQUEST] = request;
        order->length[CHECKER_REQUEST] = length;
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
    struct check *check = call->request->state;
    enum checking_state state = checking_look(call, check);
    if (state == CHECKING_PASSED)
        reply_text(call->reply, 200, "application/json",
                   checking_text(check, 0, check_answer(check)->output_length));
    return state == CHECKING_WAIT ? HTTP_WAIT : HTTP_DONE;
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
