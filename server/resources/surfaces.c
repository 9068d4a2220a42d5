/* SPDX-License-Identifier: MIT */
/* /v1/surfaces: store, list, get, delete. */
#include "api/files/files.h"
#include "checking.h"
#include "handlers.h"
#include "server/config.h"
#include "server/http/negotiate.h"
#include <string.h>

/* Puts it into the store. Callers without tokens see what any of them has stored, and get what is
 * there already rather than an entry of each address. False: the reply says why not. */
static bool put_surface(struct call *call, const struct store_item *stored, bool *created) {
    struct store *store = call->services->store;
    struct store_item there = {0};
    enum store_answer answer = STORE_EMPTY;
    if (!call->services->tokens)
        answer = store_item_get(store, STORE_SURFACES, NULL, stored->id, &there);
    store_item_clear(&there);
    *created = false;
    if (answer == STORE_EMPTY) {
        if (!call_has_room(call, stored->definition_length))
            return false;
        answer = store_item_put(store, STORE_SURFACES, stored, created);
    }
    if (answer != STORE_OK)
        call_store_failed(call, answer);
    return answer == STORE_OK;
}

/* Stores the surface that the check has read. */
static void store_surface(struct call *call, struct check *check) {
    struct store_item stored;
    bool created = false;
    if (checking_item(call, check, check_answer(check)->check.surface, &stored) &&
        put_surface(call, &stored, &created)) {
        reply_text(call->reply, created ? 201 : 200, "application/json", stored.description);
        stored.description = NULL; /* the reply has it */
        reply_header(call->reply, "Location", "/v1/surfaces/%s", stored.id);
    }
    store_item_clear(&stored);
}

/* What file the body is said to be; NULL: JSON. */
static const struct file_format *source_of(const struct request *request) {
    const char *name = request_query(request, "format");
    const char *type = request_header(request, "Content-Type");
    if (name)
        return file_format_named(name);
    for (int k = 0; type && k < FILE_FORMATS; k++)
        if (negotiate_is_type(type, file_formats[k].media_type))
            return &file_formats[k];
    return NULL;
}

/* A type that a form of a web page can send without the browser asking first. */
static bool is_form(const char *type) {
    return negotiate_is_type(type, "text/plain") ||
           negotiate_is_type(type, "multipart/form-data") ||
           negotiate_is_type(type, "application/x-www-form-urlencoded");
}

bool surfaces_check_file(struct call *call) {
    const struct request *request = call->request;
    const struct file_format *source = source_of(request);
    const char *format = request_query(request, "format"), *unit = request_query(request, "unit");
    const char *type = request_header(request, "Content-Type");
    if (format && !source && strcmp(format, "json"))
        reply_refuse(call->reply, API_INVALID_REQUEST,
                     "?format= takes json, step, iges, stl, obj and nastran, and not '%.64s'",
                     format);
    else if (unit && !file_unit_known(unit))
        reply_refuse(call->reply, API_INVALID_REQUEST,
                     "?unit= takes m, mm, cm, um, in and ft, and not '%.64s'", unit);
    else if (unit && !source)
        reply_refuse(call->reply, API_INVALID_REQUEST,
                     "?unit= is for files that state none; a JSON surface has \"length_unit\"");
    else if (source && request_header(request, "Origin") && (!type || is_form(type)))
        reply_refuse(call->reply, API_UNSUPPORTED_MEDIA_TYPE,
                     "from a page the Content-Type must be '%s'", source->media_type);
    else if (source && source->cad && !document_pool_can_import())
        reply_refuse(call->reply, API_UNSUPPORTED_MEDIA_TYPE,
                     "STEP and IGES files need the importer, which is not installed: "
                     "apt install draped-import");
    return source || call->reply->status;
}

enum http_next surfaces_create(struct call *call) {
    struct request *request = call->request;
    const struct file_format *source = source_of(request);
    struct document_pool_order order = checking_order(call, CHECKER_SURFACE);
    order.source = source ? source->name : NULL;
    order.unit = request_query(request, "unit");
    if (!request->state && !checking_keep(call, &order))
        return HTTP_DONE;
    enum checking_state state = checking_look(call, request->state);
    if (state == CHECKING_PASSED)
        store_surface(call, request->state);
    return state == CHECKING_WAIT ? HTTP_WAIT : HTTP_DONE;
}

enum http_next surfaces_list(struct call *call) {
    return call_list_items(call, STORE_SURFACES, "surfaces", "");
}

enum http_next surfaces_get(struct call *call) {
    const char *id = call->request->parameter;
    struct store_item surface = {0};
    enum store_answer answer = STORE_EMPTY;
    if (id_valid(id))
        answer =
            store_item_get(call->services->store, STORE_SURFACES, call_owner(call), id, &surface);
    if (answer == STORE_OK) {
        reply_text(call->reply, 200, "application/json", surface.definition);
        surface.definition = NULL; /* the reply has it */
    } else if (answer == STORE_EMPTY) {
        call_not_found(call, "surface");
    } else {
        call_store_failed(call, answer);
    }
    store_item_clear(&surface);
    return HTTP_DONE;
}

/* Begins to make the preview of the stored surface. False: the reply says why not. */
static bool begin_preview(struct call *call) {
    const char *id = call->request->parameter, *format = request_query(call->request, "format");
    struct store_item surface = {0};
    enum store_answer answer = STORE_EMPTY;
    if (format && strcmp(format, "glb")) {
        reply_refuse(call->reply, API_NOT_ACCEPTABLE, "a preview is available as glb");
        return false;
    }
    if (id_valid(id))
        answer =
            store_item_get(call->services->store, STORE_SURFACES, call_owner(call), id, &surface);
    if (answer == STORE_EMPTY) {
        call_not_found(call, "surface");
    } else if (answer != STORE_OK) {
        call_store_failed(call, answer);
    } else {
        struct document_pool_order order = checking_order(call, CHECKER_PREVIEW);
        order.document[CHECKER_BODY] = surface.definition;
        order.length[CHECKER_BODY] = surface.definition_length;
        order.body_file = -1;
        (void)checking_keep(call, &order);
    }
    store_item_clear(&surface);
    return call->request->state != NULL;
}

enum http_next surfaces_preview(struct call *call) {
    if (!call->request->state && !begin_preview(call))
        return HTTP_DONE;
    struct check *check = call->request->state;
    enum checking_state state = checking_look(call, check);
    if (state == CHECKING_PASSED) {
        size_t length = (size_t)check_answer(check)->output_length;
        char *bytes = checking_text(check, 0, length);
        if (bytes)
            reply_bytes(call->reply, 200, "model/gltf-binary", bytes, length);
        else
            reply_refuse(call->reply, API_UNAVAILABLE, "there is no memory for this now");
    }
    return state == CHECKING_WAIT ? HTTP_WAIT : HTTP_DONE;
}

enum http_next surfaces_delete(struct call *call) {
    const char *id = call->request->parameter;
    enum store_answer answer = STORE_EMPTY;
    if (id_valid(id))
        answer = store_item_delete(call->services->store, STORE_SURFACES, call_owner(call), id);
    if (answer == STORE_EMPTY)
        return call_not_found(call, "surface");
    if (answer == STORE_CONFLICT)
        reply_refuse(call->reply, API_CONFLICT,
                     "a drape, study or laminate that has not ended needs it");
    else if (answer != STORE_OK)
        return call_store_failed(call, answer);
    else
        reply_empty(call->reply, 204);
    return HTTP_DONE;
}
