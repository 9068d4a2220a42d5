/* SPDX-License-Identifier: MIT */
#include "check.h"
#include "api/request/decode.h"
#include "api/request/digest.h"
#include "api/request/prepared_form.h"
#include "api/request/preview.h"
#include "refusal.h"
#include <string.h>

/* A patch of fewer control points is decoded and made sooner than its form is handed over. */
enum { FORM_POINTS_LEAST = 256 };

bool api_check_expects_form(struct api_request *request, struct arena *arena) {
    struct api_surface *surface = &request->surface;
    bool stored = surface->id[0] != '\0';
    if (stored && !surface->form && !prepared_part_is_large(surface)) {
        surface->form = prepared_form_make(surface, arena);
        return surface->form != NULL;
    }
    return !prepared_form_part(request) && (stored || surface->kind != API_SURFACE_NURBS ||
                                            surface->nurbs.point_count >= FORM_POINTS_LEAST);
}

void api_check_write_form(const struct api_request *request, const struct prepared_part *part,
                          struct arena *arena, const struct api_sink *forms,
                          struct api_check *check) {
    const struct api_surface *surface = &request->surface;
    bool stored = surface->id[0] != '\0';
    check->form_length =
        prepared_form_write(request, part, stored ? surface->id : check->text, arena, forms);
    check->form_renewed = stored && !surface->form->source[0] && check->form_length > 0;
}

enum api_problem_id api_check_names(const struct api_input *input,
                                    const struct api_request *request, struct arena *arena,
                                    struct api_check *check, struct api_problem *problem) {
    memcpy(check->surface, request->surface.id, sizeof check->surface);
    check->needs_surface = request->surface.kind == API_SURFACE_NAMED;
    api_digest_bytes(input->request, input->request_length, check->text);
    return !check->surface[0] || api_digest_ground(request, arena, check->ground)
               ? API_OK
               : api_problem_no_memory(problem, "the request");
}

static enum api_problem_id lay_cuts(const struct prepared_part *part,
                                    const struct drape_settings *settings, struct arena *arena,
                                    struct api_problem *problem) {
    struct drape_result result = {0};
    struct arena_mark mark = arena_mark(arena);
    if (settings->cut_count > 0) {
        enum status status = drape_check_cuts(&part->part, settings, arena, &result);
        (void)!refusal_of_status(problem, status, settings, &result);
    }
    arena_rewind(arena, mark);
    return problem->id;
}

/* Of a surface with very many spans it is left for the solver to say whether it takes that. */
static enum api_problem_id check_part(struct api_request *request, const struct api_limits *limits,
                                      struct arena *arena, const struct api_sink *forms,
                                      struct api_check *check, struct api_problem *problem) {
    struct prepared_part part;
    if (prepared_part_is_large(&request->surface))
        return API_OK;
    bool wanted = forms && api_check_expects_form(request, arena);
    struct drape_settings settings = request->settings;
    if (prepared_part_make(request, limits, arena, &part, problem) == API_OK &&
        prepared_part_settle(&part, arena, &settings, problem) == API_OK &&
        lay_cuts(&part, &settings, arena, problem) == API_OK && wanted)
        api_check_write_form(request, &part, arena, forms, check);
    return problem->id;
}

enum api_problem_id api_check_decoded(struct api_request *request, const struct api_limits *limits,
                                      struct arena *arena, struct api_problem *problem) {
    return check_part(request, limits, arena, NULL, NULL, problem);
}

enum api_problem_id api_check_drape(const struct api_input *input, const struct api_limits *limits,
                                    const struct api_sink *forms, struct api_check *check,
                                    struct api_problem *problem) {
    struct arena *arena = arena_new(limits->max_memory);
    struct api_request request;
    *check = (struct api_check){0};
    if (!arena)
        return api_problem_no_memory(problem, "the request");
    if (forms)
        arena_clear(arena);
    if (api_decode(input, limits, arena, &request, problem) == API_OK &&
        api_check_names(input, &request, arena, check, problem) == API_OK &&
        !check->needs_surface &&
        check_part(&request, limits, arena, forms, check, problem) == API_OK &&
        !api_digest_request(&request, arena, check->digest))
        api_problem_no_memory(problem, "the request");
    arena_free(arena);
    return problem->id;
}

static bool write_string(const struct api_sink *sink, const char *text) {
    return sink->write(sink->context, text, strlen(text));
}

/* The definition is written once; what describes it has its id. */
static enum api_problem_id describe_surface(struct api_request *request,
                                            const struct prepared_part *whole,
                                            const struct api_problem *fault, struct arena *arena,
                                            const struct api_sink *sink, struct api_check *check,
                                            struct api_problem *problem) {
    struct api_surface *surface = &request->surface;
    const char *definition = api_normalise_surface(surface, arena), *description = NULL;
    size_t length = definition ? strlen(definition) : 0;
    if (definition) {
        api_digest_bytes(definition, length, surface->id);
        memcpy(check->surface, surface->id, sizeof check->surface);
        description = prepared_part_describe(surface, whole, fault, arena, problem);
    }
    if (description && write_string(sink, definition) && write_string(sink, description))
        check->definition_length = length;
    else if (problem->id == API_OK)
        api_problem_no_memory(problem, "the surface");
    return problem->id;
}

enum api_problem_id api_check_surface(const struct api_input *input,
                                      const struct api_limits *limits, const struct api_sink *sink,
                                      const struct api_sink *forms, struct api_check *check,
                                      struct api_problem *problem) {
    struct arena *arena = arena_new(limits->max_memory), *text = arena ? arena_child(arena) : NULL;
    struct api_request request = {0};
    struct prepared_part whole;
    struct api_problem fault = {0};
    *check = (struct api_check){0};
    if (!text) {
        arena_free(arena);
        return api_problem_no_memory(problem, "the surface");
    }
    if (forms)
        arena_clear(arena);
    if (api_decode_surface(input->request, input->request_length, limits, arena, &request.surface,
                           problem) == API_OK) {
        enum api_problem_id id = prepared_part_make_whole(&request.surface, arena, &whole, &fault);
        if (id != API_OK)
            *problem = fault;
        else if (describe_surface(&request, &whole, &fault, text, sink, check, problem) == API_OK &&
                 forms && !prepared_part_is_large(&request.surface))
            check->form_length =
                prepared_form_write(&request, &whole, check->surface, arena, forms);
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
