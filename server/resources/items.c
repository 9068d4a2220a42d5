/* SPDX-License-Identifier: MIT */
/* /v1/surfaces, /v1/materials and /v1/links: store, list, get, delete, and the preview of a
 * surface. Beside the materials that callers keep there is the library's; links are stored by
 * `links.c`. */
#include "items.h"
#include "api/files/files.h"
#include "api/request/material.h"
#include "checking.h"
#include "documents.h"
#include "forms.h"
#include "handlers.h"
#include "server/http/negotiate.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* In paths and lists, and in messages. */
static const struct {
    const char *collection, *missing;
} kinds[] = {
    [STORE_SURFACES] = {"surfaces", "there is no surface with this id"},
    [STORE_MATERIALS] = {"materials", "there is no material of this name"},
    [STORE_LINKS] = {"links", "there is no link with this id"},
};

/* The item of that kind that the caller keeps under that name, or, for callers who see that, others
 * do. STORE_EMPTY as well for a name that none can have. To be cleared in any case. */
static enum store_answer find_item(struct call *call, enum store_item_kind kind, const char *name,
                                   struct store_item *item) {
    struct store *store = call->services->store;
    const bool material = kind == STORE_MATERIALS;
    *item = (struct store_item){0};
    if (material ? strlen(name) >= API_MATERIAL_NAME_SIZE : !id_valid(name))
        return STORE_EMPTY;
    if (!material)
        return store_item_get(store, kind, call_owner(call), name, item);
    /* Names are the owners' own: what others have is looked at after one's own. */
    enum store_answer answer = store_item_get(store, kind, call->request->owner, name, item);
    if (answer == STORE_EMPTY && !call_owner(call))
        answer = store_item_get(store, kind, NULL, name, item);
    return answer;
}

/* Answers for an item that cannot be had or changed. HTTP_DONE. */
static enum http_next item_failed(struct call *call, enum store_answer answer) {
    if (answer == STORE_EMPTY)
        reply_refuse(call->reply, API_NOT_FOUND, "%s", kinds[call->item].missing);
    else if (answer == STORE_CONFLICT)
        reply_refuse(call->reply, API_CONFLICT,
                     "a drape, study or laminate that has not ended needs it: cancel that one, or "
                     "wait until it ends");
    else
        call_store_failed(call, answer);
    return HTTP_DONE;
}

/* ------------------------------------------------------------------ storing */

const struct file_format *items_file_of(const char *type) {
    for (int k = 0; type && k < FILE_FORMATS; k++)
        if (negotiate_is_type(type, file_formats[k].media_type))
            return &file_formats[k];
    return NULL;
}

/* What file the body of a surface is said to be; NULL: JSON. */
static const struct file_format *source_of(const struct request *request) {
    const char *name = request_query(request, "format");
    const char *type = request_header(request, "Content-Type");
    if (name)
        return file_format_named(name);
    return items_file_of(type);
}

bool items_check_file(struct call *call) {
    const struct request *request = call->request;
    const struct file_format *source = source_of(request);
    const char *format = request_query(request, "format"), *unit = request_query(request, "unit");
    const char *type = request_header(request, "Content-Type");
    /* a type that a form of a web page can send without the browser asking first */
    bool form = !type || negotiate_is_type(type, "text/plain") ||
                negotiate_is_type(type, "multipart/form-data") ||
                negotiate_is_type(type, "application/x-www-form-urlencoded");
    char ending[16], why[FILE_REFUSAL_SIZE];
    snprintf(ending, sizeof ending, ".%s", format ? format : "");
    bool known = file_refuse(ending, why);
    if (format && !source && strcmp(format, "json") && known)
        reply_refuse(call->reply, API_INVALID_REQUEST, "%s", why);
    else if (format && !source && strcmp(format, "json"))
        reply_refuse(
            call->reply, API_INVALID_REQUEST,
            "'%.64s' is not a format: ?format= takes json, step, iges, stl, obj, nastran, abaqus, "
            "lsdyna, gmsh, unv and vtu; the name of a file %s",
            format, why);
    else if (unit && !file_unit_known(unit))
        reply_refuse(call->reply, API_INVALID_REQUEST,
                     "?unit= takes m, mm, cm, um, in and ft, and not '%.64s'", unit);
    else if (unit && !source)
        reply_refuse(call->reply, API_INVALID_REQUEST,
                     "?unit= is for files that state no unit: in JSON use \"length_unit\"");
    else if (source && request_header(request, "Origin") && form)
        reply_refuse(call->reply, API_UNSUPPORTED_MEDIA_TYPE,
                     "from a web page the Content-Type must be '%s'", source->media_type);
    else if (source && source->cad && !document_pool_can_import())
        reply_refuse(call->reply, API_UNSUPPORTED_MEDIA_TYPE,
                     "STEP and IGES files need the importer, which is not installed: "
                     "apt install draped-import");
    return source || call->reply->status;
}

/* Puts what the check has read into the store, as the caller's own, unless it is there: an owner's
 * name of a material is for one material. Callers without tokens see what any of them has stored,
 * and get the surface that is there already rather than an entry of each address. What the check
 * has written is the definition and behind that the description. */
static void store_checked_item(struct call *call, struct check *check) {
    const struct checker_answer *checked = check_answer(check);
    const bool material = call->item == STORE_MATERIALS;
    const char *name = material ? checked->check.material : checked->check.surface;
    const uint64_t split = checked->check.definition_length;
    struct store_item there = {0}, posted = {.definition_length = (size_t)split};
    enum store_answer answer = STORE_EMPTY;
    bool created = false;
    snprintf(posted.owner, sizeof posted.owner, "%s", call->request->owner);
    snprintf(posted.id, sizeof posted.id, "%s", name);
    posted.definition = checking_text(check, 0, split);
    posted.description = checking_text(check, split, checked->output_length - split);
    if (!posted.definition || !posted.description)
        reply_no_memory(call->reply);
    else if (material || !call->services->tokens)
        answer = find_item(call, call->item, name, &there);
    bool same =
        !material || (there.definition_length == posted.definition_length && there.definition &&
                      posted.definition && !memcmp(there.definition, posted.definition, split));
    if (!call->reply->status && answer == STORE_EMPTY)
        posted.form = forms_posted(call, check, &posted.form_length);
    if (!call->reply->status && answer == STORE_EMPTY &&
        call_has_room(call, (size_t)split + posted.form_length)) {
        answer = store_item_put(call->services->store, call->item, &posted, &created);
        same = created || !material;
    }
    if (!call->reply->status && answer != STORE_OK)
        call_store_failed(call, answer);
    else if (!call->reply->status && !same)
        reply_refuse(call->reply, API_CONFLICT,
                     "you have stored another material as '%s': delete that one first, or give "
                     "this one another name",
                     posted.id);
    else if (!call->reply->status) {
        char **shown = material ? &posted.definition : &posted.description;
        reply_text(call->reply, created ? 201 : 200, "application/json", *shown);
        *shown = NULL; /* the reply has it */
        reply_header(call->reply, "Location", "/v1/%s/%s", kinds[call->item].collection, posted.id);
    }
    store_item_clear(&there);
    store_item_clear(&posted);
}

enum http_next items_create(struct call *call) {
    bool surface = call->item == STORE_SURFACES;
    const struct file_format *source = surface ? source_of(call->request) : NULL;
    struct document_pool_order order =
        checking_order(call, surface ? CHECKER_SURFACE : CHECKER_MATERIAL);
    order.source = source ? source->name : NULL;
    order.unit = request_query(call->request, "unit");
    if (!call->request->state && !checking_keep(call, &order))
        return HTTP_DONE;
    return checking_answer(call, store_checked_item);
}

/* ------------------------------------------------------------------ reading */

enum http_next items_list(struct call *call) {
    struct store_items page = {0};
    int limit;
    int64_t cursor;
    if (!call_read_page(call, &limit, &cursor))
        return HTTP_DONE;
    enum store_answer answer =
        store_item_list(call->services->store, call->item, call_owner(call), cursor, limit, &page);
    const char *first = call->item == STORE_MATERIALS && !cursor ? api_materials_heads() : "";
    if (answer == STORE_OK)
        reply_text(call->reply, 200, "application/json",
                   documents_items(kinds[call->item].collection, first, &page));
    else
        call_store_failed(call, answer);
    store_items_clear(&page);
    return HTTP_DONE;
}

/* The library's of that name, if the path is about materials and there is one. */
static const struct api_material *library_material(const struct call *call) {
    return call->item == STORE_MATERIALS ? api_material_named(call->request->parameter) : NULL;
}

enum http_next items_get(struct call *call) {
    const struct api_material *material = library_material(call);
    struct store_item item = {0};
    if (material) {
        reply_literal(call->reply, 200, "application/json", material->json, material->length);
        return HTTP_DONE;
    }
    enum store_answer answer = find_item(call, call->item, call->request->parameter, &item);
    if (answer == STORE_OK) {
        char **shown = call->item == STORE_LINKS ? &item.description : &item.definition;
        reply_text(call->reply, 200, "application/json", *shown);
        *shown = NULL; /* the reply has it */
    } else {
        item_failed(call, answer);
    }
    store_item_clear(&item);
    return HTTP_DONE;
}

enum http_next items_delete(struct call *call) {
    const char *name = call->request->parameter;
    enum store_answer answer = STORE_EMPTY;
    if (library_material(call)) {
        reply_refuse(call->reply, API_FORBIDDEN,
                     "this material belongs to the library and cannot be deleted");
        return HTTP_DONE;
    }
    if (call->item == STORE_MATERIALS ? strlen(name) < API_MATERIAL_NAME_SIZE : id_valid(name))
        answer = store_item_delete(call->services->store, call->item, call_owner(call), name);
    if (answer != STORE_OK)
        return item_failed(call, answer);
    reply_empty(call->reply, 204);
    return HTTP_DONE;
}

char *items_collect_materials(struct call *call, char *names, size_t *length) {
    char *lines = NULL;
    enum store_answer answer = STORE_OK;
    FILE *stream = open_memstream(&lines, length);
    for (char *name = names, *end; stream && (end = strchr(name, '\n')); name = end + 1) {
        struct store_item item;
        *end = '\0';
        answer = find_item(call, STORE_MATERIALS, name, &item);
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
        reply_no_memory(call->reply);
    free(lines);
    return NULL;
}

/* ------------------------------------------------------------------ the preview */

static void reply_preview(struct call *call, struct check *check) {
    size_t length = (size_t)check_answer(check)->output_length;
    char *bytes = checking_text(check, 0, length);
    if (bytes)
        reply_bytes(call->reply, 200, "model/gltf-binary", bytes, length);
    else
        reply_no_memory(call->reply);
}

/* The first call begins to make the preview of the stored surface. */
enum http_next items_preview(struct call *call) {
    const char *format = request_query(call->request, "format");
    struct store_item surface;
    if (call->request->state)
        return checking_answer(call, reply_preview);
    if (format && strcmp(format, "glb")) {
        reply_refuse(call->reply, API_NOT_ACCEPTABLE, "a preview is available as glb only");
        return HTTP_DONE;
    }
    enum store_answer answer = find_item(call, STORE_SURFACES, call->request->parameter, &surface);
    if (answer == STORE_OK) {
        struct document_pool_order order = checking_order(call, CHECKER_PREVIEW);
        order.document[CHECKER_BODY] = surface.definition;
        order.length[CHECKER_BODY] = surface.definition_length;
        order.body_file = -1;
        (void)checking_keep(call, &order);
    } else {
        item_failed(call, answer);
    }
    store_item_clear(&surface);
    return call->request->state ? checking_answer(call, reply_preview) : HTTP_DONE;
}
