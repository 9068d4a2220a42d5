/* SPDX-License-Identifier: MIT */
#include "check.h"
#include "api/request/decode.h"
#include "api/request/digest.h"
#include "api/request/prepared_part.h"
#include "api/request/preview.h"
#include <string.h>

enum api_problem_id api_check_decoded(const struct api_request *request,
                                      const struct api_limits *limits, struct arena *arena,
                                      struct api_problem *problem) {
    struct prepared_part part;
    return prepared_part_is_large(&request->surface)
               ? API_OK
               : prepared_part_make(request, limits, arena, &part, problem);
}

enum api_problem_id api_check_drape(const struct api_input *input, const struct api_limits *limits,
                                    struct api_check *check, struct api_problem *problem) {
    struct arena *arena = arena_new(limits->max_memory);
    struct api_request request;
    *check = (struct api_check){0};
    if (!arena)
        return api_problem_no_memory(problem, "the request");
    if (api_decode(input, limits, arena, &request, problem) == API_OK) {
        memcpy(check->surface, request.surface.id, sizeof check->surface);
        check->needs_surface = request.surface.kind == API_SURFACE_NAMED;
        if (!check->needs_surface &&
            api_check_decoded(&request, limits, arena, problem) == API_OK &&
            !api_digest_request(&request, arena, check->digest))
            api_problem_no_memory(problem, "the request");
    }
    arena_free(arena);
    return problem->id;
}

static bool write_string(const struct api_sink *sink, const char *text) {
    return sink->write(sink->context, text, strlen(text));
}

enum api_problem_id api_check_surface(const struct api_input *input,
                                      const struct api_limits *limits, const struct api_sink *sink,
                                      struct api_check *check, struct api_problem *problem) {
    struct arena *arena = arena_new(limits->max_memory);
    struct api_surface surface;
    *check = (struct api_check){0};
    if (!arena)
        return api_problem_no_memory(problem, "the surface");
    if (api_decode_surface(input->request, input->request_length, limits, arena, &surface,
                           problem) == API_OK) {
        /* The definition is written once; what describes it has its id. */
        const char *definition = api_normalise_surface(&surface, arena), *description = NULL;
        size_t length = definition ? strlen(definition) : 0;
        if (definition) {
            api_digest_bytes(definition, length, surface.id);
            memcpy(check->surface, surface.id, sizeof check->surface);
            description = prepared_part_describe(&surface, arena, problem);
        }
        if (description && write_string(sink, definition) && write_string(sink, description))
            check->definition_length = length;
        else if (problem->id == API_OK)
            api_problem_no_memory(problem, "the surface");
    }
    arena_free(arena);
    return problem->id;
}

enum api_problem_id api_check_material(const struct api_input *input,
                                       const struct api_limits *limits, const struct api_sink *sink,
                                       struct api_check *check, struct api_problem *problem) {
    struct arena *arena = arena_new(limits->max_memory);
    struct api_material material;
    const char *head;
    *check = (struct api_check){0};
    if (!arena)
        return api_problem_no_memory(problem, "the material");
    if (api_material_decode(input->request, input->request_length, limits, arena, &material, &head,
                            problem) == API_OK) {
        strcpy(check->material, material.name);
        if (write_string(sink, material.json) && write_string(sink, head))
            check->definition_length = material.length;
        else
            api_problem_no_memory(problem, "the material");
    }
    arena_free(arena);
    return problem->id;
}

enum api_problem_id api_check_mentions(struct api_input *input, const char *own, size_t own_length,
                                       const struct api_sink *sink, struct arena *arena,
                                       struct api_check *check, struct api_problem *problem) {
    const char *wanted =
        own ? "" : api_material_wanted(input->request, input->request_length, arena);
    if (!wanted)
        return api_problem_no_memory(problem, "the request");
    check->needs_materials = *wanted != '\0';
    if (check->needs_materials)
        return write_string(sink, wanted) ? API_OK : api_problem_no_memory(problem, "the request");
    size_t length = 0;
    const char *filled = api_material_fill(input->request, input->request_length, own ? own : "",
                                           own_length, arena, &length);
    if (!filled)
        return api_problem_no_memory(problem, "the request");
    check->filled_length = length;
    input->request = filled;
    input->request_length = check->filled_length;
    return API_OK;
}

enum api_problem_id api_check_preview(const struct api_input *input,
                                      const struct api_limits *limits, const struct api_sink *sink,
                                      struct api_problem *problem) {
    struct arena *arena = arena_new(limits->max_memory);
    struct api_surface surface;
    if (!arena)
        return api_problem_no_memory(problem, "the preview");
    if (api_decode_surface(input->request, input->request_length, limits, arena, &surface,
                           problem) == API_OK)
        (void)!api_preview(&surface, sink, arena, problem);
    arena_free(arena);
    return problem->id;
}

enum api_problem_id api_check_normalise(const struct api_input *input,
                                        const struct api_limits *limits,
                                        const struct api_start *start, const struct api_sink *sink,
                                        struct api_problem *problem) {
    struct arena *arena = arena_new(limits->max_memory);
    struct api_request request;
    const char *text = NULL;
    if (arena && api_decode(input, limits, arena, &request, problem) == API_OK)
        text = api_normalise(&request, start, arena);
    if (problem->id == API_OK && (!text || !write_string(sink, text)))
        api_problem_no_memory(problem, "the request");
    arena_free(arena);
    return problem->id;
}
