/* SPDX-License-Identifier: MIT */
/* /v1/materials: the library of fabrics, and those that callers keep beside it. */
#include "materials.h"
#include "api/request/material.h"
#include "checking.h"
#include "handlers.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum store_answer materials_find(struct call *call, const char *name, struct store_item *item) {
    struct store *store = call->services->store;
    enum store_answer answer =
        store_item_get(store, STORE_MATERIALS, call->request->owner, name, item);
    if (answer == STORE_EMPTY && !call_owner(call))
        answer = store_item_get(store, STORE_MATERIALS, NULL, name, item);
    return answer;
}

/* ------------------------------------------------------------------ keeping one */

/* One of that name is there: what is posted has to be the same. */
static bool is_same(struct call *call, const struct store_item *there,
                    const struct store_item *posted) {
    bool same = there->definition_length == posted->definition_length &&
                memcmp(there->definition, posted->definition, posted->definition_length) == 0;
    if (!same)
        reply_refuse(call->reply, API_CONFLICT,
                     "you keep another material as '%s': delete that first, or give this one "
                     "another name",
                     posted->id);
    return same;
}

/* Puts it into the store unless it is there. False: the reply says why not. */
static bool keep(struct call *call, const struct store_item *posted, bool *created) {
    struct store_item there = {0};
    enum store_answer answer = materials_find(call, posted->id, &there);
    bool good = answer == STORE_OK && is_same(call, &there, posted);
    *created = false;
    if (answer == STORE_EMPTY && call_has_room(call, posted->definition_length)) {
        answer = store_item_put(call->services->store, STORE_MATERIALS, posted, created);
        good = answer == STORE_OK && *created;
        if (answer == STORE_OK && !good)
            reply_refuse(call->reply, API_CONFLICT, "another call has just kept one of this name");
    }
    if (answer != STORE_OK && answer != STORE_EMPTY)
        call_store_failed(call, answer);
    store_item_clear(&there);
    return good;
}

/* Keeps the material that the check has read. */
static void store_material(struct call *call, struct check *check) {
    struct store_item posted;
    bool created = false;
    if (checking_item(call, check, check_answer(check)->check.material, &posted) &&
        keep(call, &posted, &created)) {
        reply_text(call->reply, created ? 201 : 200, "application/json", posted.definition);
        posted.definition = NULL; /* the reply has it */
        reply_header(call->reply, "Location", "/v1/materials/%s", posted.id);
    }
    store_item_clear(&posted);
}

enum http_next materials_create(struct call *call) {
    struct request *request = call->request;
    struct document_pool_order order = checking_order(call, CHECKER_MATERIAL);
    if (!request->state && !checking_keep(call, &order))
        return HTTP_DONE;
    enum checking_state state = checking_look(call, request->state);
    if (state == CHECKING_PASSED)
        store_material(call, request->state);
    return state == CHECKING_WAIT ? HTTP_WAIT : HTTP_DONE;
}

/* ------------------------------------------------------------------ for a request */

char *materials_collect(struct call *call, char *names, size_t *length) {
    char *lines = NULL;
    enum store_answer answer = STORE_OK;
    FILE *stream = open_memstream(&lines, length);
    for (char *name = names, *end; stream && (end = strchr(name, '\n')); name = end + 1) {
        struct store_item item = {0};
        *end = '\0';
        answer = materials_find(call, name, &item);
        if (answer == STORE_OK)
            fputs(item.definition, stream);
        store_item_clear(&item);
        if (answer != STORE_OK && answer != STORE_EMPTY)
            break;
        fputc('\n', stream);
        answer = STORE_OK;
    }
    bool good = stream && fputc('\n', stream) != EOF && !ferror(stream);
    if ((!stream || fclose(stream) == 0) && good && answer == STORE_OK)
        return lines;
    if (answer != STORE_OK)
        call_store_failed(call, answer);
    else
        reply_refuse(call->reply, API_UNAVAILABLE, "there is no memory for this now");
    free(lines);
    return NULL;
}

/* ------------------------------------------------------------------ reading */

enum http_next materials_list(struct call *call) {
    return call_list_items(call, STORE_MATERIALS, "materials", api_materials_heads());
}

static enum http_next not_there(struct call *call) {
    reply_refuse(call->reply, API_NOT_FOUND, "there is no material of this name");
    return HTTP_DONE;
}

enum http_next materials_get(struct call *call) {
    const char *name = call->request->parameter;
    const struct api_material *material = api_material_named(name);
    struct store_item item = {0};
    enum store_answer answer = STORE_OK;
    if (material)
        reply_literal(call->reply, 200, "application/json", material->json, material->length);
    else
        answer =
            strlen(name) < API_MATERIAL_NAME_SIZE ? materials_find(call, name, &item) : STORE_EMPTY;
    if (answer == STORE_OK && !material) {
        reply_text(call->reply, 200, "application/json", item.definition);
        item.definition = NULL; /* the reply has it */
    } else if (answer == STORE_EMPTY) {
        not_there(call);
    } else if (answer != STORE_OK) {
        call_store_failed(call, answer);
    }
    store_item_clear(&item);
    return HTTP_DONE;
}

enum http_next materials_delete(struct call *call) {
    const char *name = call->request->parameter;
    enum store_answer answer = STORE_EMPTY;
    if (api_material_named(name)) {
        reply_refuse(call->reply, API_FORBIDDEN, "this material is of the library");
        return HTTP_DONE;
    }
    if (strlen(name) < API_MATERIAL_NAME_SIZE)
        answer = store_item_delete(call->services->store, STORE_MATERIALS, call_owner(call), name);
    if (answer == STORE_EMPTY)
        return not_there(call);
    if (answer != STORE_OK)
        return call_store_failed(call, answer);
    reply_empty(call->reply, 204);
    return HTTP_DONE;
}
