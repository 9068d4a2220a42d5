/* SPDX-License-Identifier: MIT */
#include "api/request/decode.h"
#include "api/request/digest.h"
#include "api/request/normalise.h"
#include "api/request/shape.h"
#include "documents.h"
#include "resources.h"
#include "server/config.h"
#include "server/id.h"
#include <stdlib.h>
#include <string.h>

/* Checks the posted surface and makes what is stored of it; the texts lie in the arena. */
static enum api_problem_id read_surface(const struct http_services *services,
                                        const struct request *request, struct arena *arena,
                                        struct store_surface *stored, struct api_problem *problem) {
    struct api_limits limits = resources_limits(services);
    struct api_surface surface;
    const char *body = request->body ? request->body : "";
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

enum routes_next surfaces_create(const struct http_services *services, struct request *request,
                                 struct reply *reply) {
    struct api_problem problem = {0};
    struct store_surface stored = {0};
    memcpy(stored.owner, request->caller, sizeof stored.owner);
    struct arena *arena = arena_new((size_t)services->config->job_memory);
    enum store_answer answer = STORE_DOWN;
    bool created = false;
    if (!arena)
        api_problem_set(&problem, API_UNAVAILABLE, "there is no memory for this now");
    else if (read_surface(services, request, arena, &stored, &problem) == API_OK)
        answer = store_surface_put(services->store, &stored, &created);
    if (problem.id != API_OK) {
        reply_problem(reply, request->id, &problem);
    } else if (answer != STORE_OK) {
        resources_store_failed(request, reply, answer);
    } else {
        reply_text(reply, created ? 201 : 200, "application/json", stored.description);
        stored.description = NULL; /* the reply has it */
        reply_header(reply, "Location", "/v1/surfaces/%s", stored.id);
    }
    store_surface_clear(&stored);
    arena_free(arena);
    return ROUTES_DONE;
}

enum routes_next surfaces_list(const struct http_services *services, struct request *request,
                               struct reply *reply) {
    struct store_surfaces page = {0};
    int limit;
    int64_t cursor;
    if (!resources_page(request, reply, &limit, &cursor))
        return ROUTES_DONE;
    enum store_answer answer =
        store_surface_list(services->store, resources_owner(request), cursor, limit, &page);
    if (answer == STORE_OK)
        reply_text(reply, 200, "application/json", documents_surfaces(&page));
    else
        resources_store_failed(request, reply, answer);
    store_surfaces_clear(&page);
    return ROUTES_DONE;
}

enum routes_next surfaces_get(const struct http_services *services, struct request *request,
                              struct reply *reply) {
    struct store_surface surface = {0};
    enum store_answer answer = STORE_EMPTY;
    if (id_valid(request->parameter))
        answer = store_surface_get(services->store, resources_owner(request), request->parameter,
                                   &surface);
    if (answer == STORE_OK) {
        reply_text(reply, 200, "application/json", surface.definition);
        surface.definition = NULL; /* the reply has it */
    } else if (answer == STORE_EMPTY) {
        resources_not_found(request, reply, "surface");
    } else {
        resources_store_failed(request, reply, answer);
    }
    store_surface_clear(&surface);
    return ROUTES_DONE;
}

enum routes_next surfaces_delete(const struct http_services *services, struct request *request,
                                 struct reply *reply) {
    enum store_answer answer = STORE_EMPTY;
    if (id_valid(request->parameter))
        answer =
            store_surface_delete(services->store, resources_owner(request), request->parameter);
    if (answer == STORE_OK)
        reply_empty(reply, 204);
    else if (answer == STORE_EMPTY)
        resources_not_found(request, reply, "surface");
    else if (answer == STORE_CONFLICT)
        reply_refuse(reply, request->id, API_CONFLICT, "a queued or running drape needs it");
    else
        resources_store_failed(request, reply, answer);
    return ROUTES_DONE;
}
