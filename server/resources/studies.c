/* SPDX-License-Identifier: MIT */
/* /v1/studies/{id}/variants/{k}/request: the drape request of one variant of a study. */
#include "checking.h"
#include "handlers.h"
#include <stdlib.h>

/* The segment of the path that has the number of the variant. */
enum { VARIANT_SEGMENT = 4 };

/* The documents of the study; false: the reply says why they cannot be had. The caller frees both
 * in any case. */
static bool fetch_documents(struct call *call, const struct store_job *job, char **request,
                            size_t *length, struct store_surface *surface) {
    struct store *store = call->services->store;
    enum store_answer answer = store_request(store, job->id, request, length);
    if (answer != STORE_OK) {
        jobs_request_failed(call, answer);
        return false;
    }
    answer = job->surface[0] ? store_surface_get(store, NULL, job->surface, surface) : STORE_OK;
    if (answer == STORE_EMPTY)
        reply_refuse(call->reply, API_GONE, "the surface of the study has been deleted");
    else if (answer != STORE_OK)
        call_store_failed(call, answer);
    return answer == STORE_OK;
}

/* False: the reply says why nothing is begun. */
static bool begin(struct call *call, size_t variant) {
    struct store_job job = {0};
    struct store_surface surface = {0};
    char *request = NULL;
    size_t length = 0;
    struct checkers_order order = checking_order(call, CHECKER_VARIANT);
    if (call_find_job(call, &job) && results_ready(call, &job) &&
        fetch_documents(call, &job, &request, &length, &surface) &&
        maps_take_columns(call, &order)) {
        order.variant = variant;
        order.document[CHECKER_BODY] = request;
        order.length[CHECKER_BODY] = length;
        order.body_file = -1;
        order.document[CHECKER_SECOND] = surface.definition;
        order.length[CHECKER_SECOND] = surface.definition_length;
        call->request->state = checking_begin(call, &order);
        call->request->state_free = checking_free;
        if (!call->request->state)
            free(order.columns.context);
    }
    free(request);
    store_surface_clear(&surface);
    store_job_clear(&job);
    return call->request->state != NULL;
}

enum http_next studies_variant(struct call *call) {
    int64_t variant = 0;
    if (!request_parse_int(call->request->segments[VARIANT_SEGMENT], 0, INT32_MAX, &variant))
        return call_not_found(call, "variant");
    if (!call->request->state && !begin(call, (size_t)variant))
        return HTTP_DONE;
    struct check *check = call->request->state;
    enum checking_state state = checking_look(call, check);
    if (state == CHECKING_PASSED)
        reply_text(call->reply, 200, "application/json",
                   checking_text(check, 0, check_answer(check)->output_length));
    return state == CHECKING_WAIT ? HTTP_WAIT : HTTP_DONE;
}
