/* SPDX-License-Identifier: MIT */
#include "checking.h"
#include "server/config.h"
#include <stdlib.h>

struct document_pool_order checking_order(const struct call *call, enum checker_kind kind) {
    const struct request *request = call->request;
    struct document_pool_order order = {
        .kind = kind,
        .owner = request->owner,
        .limits = config_limits(call->services->config, 1),
        .body_file = request->body_file,
    };
    order.document[CHECKER_BODY] = request->body ? request->body : "";
    order.length[CHECKER_BODY] = request->body_length;
    return order;
}

struct check *checking_begin(struct call *call, const struct document_pool_order *order) {
    struct api_problem problem = {0};
    char subject[ID_SIZE];
    id_make(subject);
    http_watch(call->request, subject, JOB_CHANGED);
    struct check *check =
        document_pool_begin(call->services->document_pool, order, subject, &problem);
    if (!check) {
        reply_header(call->reply, "Retry-After", "1");
        reply_problem(call->reply, &problem);
    }
    return check;
}

static void drop_check(void *state) {
    check_drop(state);
}

bool checking_keep(struct call *call, const struct document_pool_order *order) {
    call->request->state = checking_begin(call, order);
    call->request->state_free = drop_check;
    return call->request->state != NULL;
}

enum checking_state checking_look(struct call *call, struct check *check) {
    if (!check_done(check)) {
        call->request->wake_at = INT64_MAX; /* the pool notifies */
        if (!call->request->stopping)
            return CHECKING_WAIT;
        call_draining(call);
        return CHECKING_REFUSED;
    }
    const struct api_problem *problem = &check_answer(check)->problem;
    if (problem->id == API_OK)
        return CHECKING_PASSED;
    reply_problem(call->reply, problem);
    return CHECKING_REFUSED;
}

char *checking_text(struct check *check, uint64_t offset, uint64_t length) {
    char *text = malloc((size_t)length + 1);
    uint64_t have = 0;
    while (text && have < length) {
        ssize_t got = check_read(check, offset + have, text + have, (size_t)(length - have));
        if (got <= 0) {
            free(text);
            return NULL;
        }
        have += (uint64_t)got;
    }
    if (text)
        text[length] = '\0';
    return text;
}

enum http_next checking_answer(struct call *call,
                               void (*passed)(struct call *call, struct check *check)) {
    struct check *check = call->request->state;
    enum checking_state state = checking_look(call, check);
    if (state == CHECKING_PASSED)
        passed(call, check);
    return state == CHECKING_WAIT ? HTTP_WAIT : HTTP_DONE;
}

void checking_reply_json(struct call *call, struct check *check) {
    reply_text(call->reply, 200, "application/json",
               checking_text(check, 0, check_answer(check)->output_length));
}
