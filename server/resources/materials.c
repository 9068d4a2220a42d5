/* SPDX-License-Identifier: MIT */
/* The library of fabrics: GET /v1/materials, GET /v1/materials/{name}. */
#include "api/request/material.h"
#include "handlers.h"
#include <string.h>

enum http_next materials_list(struct call *call) {
    const char *text = api_materials_json();
    reply_literal(call->reply, 200, "application/json", text, strlen(text));
    return HTTP_DONE;
}

enum http_next materials_get(struct call *call) {
    const struct api_material *material = api_material_named(call->request->parameter);
    if (material)
        reply_literal(call->reply, 200, "application/json", material->json, material->length);
    else
        reply_refuse(call->reply, API_NOT_FOUND, "there is no material of this name");
    return HTTP_DONE;
}
