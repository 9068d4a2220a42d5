/* SPDX-License-Identifier: MIT */
/* /v1/surfaces: store, list, get, delete. */
#include "api/request/decode.h"
#include "api/request/digest.h"
#include "api/request/normalise.h"
#include "api/request/shape.h"
#include "documents.h"
#include "handlers.h"
#include "server/config.h"
#include <stdlib.h>
#include <string.h>

/* Checks the posted surface and makes what is stored of it. */
static enum api_problem_id read_surface(struct call *call, struct arena *arena,
                                        struct store_surface *stored, struct api_problem *problem) {
    const struct request *request = call->request;
    const struct api_limits limits = call_limits(call);
    const char *body = request->body ? request->body : "";
    struct api_surface surface;
    if (api_decode_surface(body, request->body_length, &limits, arena, &surface, problem) != API_OK)
        return problem->id;
    const char *description = api_shape_describe(&surface, arena, problem);
    if (!description)
        return problem->id;
    const char *definition = api_normalise_surface(&surface, arena);
    if (!definition || !api_digest_surface(&surface, arena, stored->id)) {
        api_problem_set(problem, API_OUT_OF_MEMORY, "the surface needs more memory than allowed");
        return problem->id;
    }
    stored->definition = strdup(definition);
    stored->definition_length = strlen(definition);
    stored->description = strdup(description);
    if (!stored->definition || !stored->description)
        api_problem_set(problem, API_UNAVAILABLE, "there is no memory for this now");
    return problem->id;
}

enum http_next surfaces_create(struct call *call) {
    struct api_problem problem = {0};
    struct store_surface stored = {0};
    memcpy(stored.owner, call->request->caller, sizeof stored.owner);
    struct arena *arena = arena_new((size_t)call->services->config->job_memory);
    enum store_answer answer = STORE_DOWN;
    bool created = false;
    if (!arena)
        api_problem_set(&problem, API_UNAVAILABLE, "there is no memory for this now");
    else if (read_surface(call, arena, &stored, &problem) == API_OK)
        answer = store_surface_put(call->services->store, &stored, &created);
    if (problem.id != API_OK) {
        reply_problem(call->reply, &problem);
    } else if (answer != STORE_OK) {
        call_store_failed(call, answer);
    } else {
        reply_text(call->reply, created ? 201 : 200, "application/json", stored.description);
        stored.description = NULL; /* the reply has it */
        reply_header(call->reply, "Location", "/v1/surfaces/%s", stored.id);
    }
    store_surface_clear(&stored);
    arena_free(arena);
    return HTTP_DONE;
}

enum http_next surfaces_list(struct call *call) {
    struct store_surfaces page = {0};
    int limit;
    int64_t cursor;
    if (!call_read_page(call, &limit, &cursor))
        return HTTP_DONE;
    enum store_answer answer =
        store_surface_list(call->services->store, call_owner(call), cursor, limit, &page);
    if (answer == STORE_OK)
        reply_text(call->reply, 200, "application/json", documents_surfaces(&page));
    else
        call_store_failed(call, answer);
    store_surfaces_clear(&page);
    return HTTP_DONE;
}

enum http_next surfaces_get(struct call *call) {
    const char *id = call->request->parameter;
    struct store_surface surface = {0};
    enum store_answer answer = STORE_EMPTY;
    if (id_valid(id))
        answer = store_surface_get(call->services->store, call_owner(call), id, &surface);
    if (answer == STORE_OK) {
        reply_text(call->reply, 200, "application/json", surface.definition);
        surface.definition = NULL; /* the reply has it */
    } else if (answer == STORE_EMPTY) {
        call_not_found(call, "surface");
    } else {
        call_store_failed(call, answer);
    }
    store_surface_clear(&surface);
    return HTTP_DONE;
}

enum http_next surfaces_delete(struct call *call) {
    const char *id = call->request->parameter;
    enum store_answer answer = STORE_EMPTY;
    if (id_valid(id))
        answer = store_surface_delete(call->services->store, call_owner(call), id);
    if (answer == STORE_EMPTY)
        return call_not_found(call, "surface");
    if (answer == STORE_CONFLICT)
        reply_refuse(call->reply, API_CONFLICT, "a queued or running drape needs it");
    else if (answer != STORE_OK)
        return call_store_failed(call, answer);
    else
        reply_empty(call->reply, 204);
    return HTTP_DONE;
}
