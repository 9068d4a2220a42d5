/* SPDX-License-Identifier: MIT */
#include "check.h"
#include "api/request/decode.h"
#include "api/request/digest.h"
#include "api/request/prepared_mesh.h"
#include "api/request/prepared_shell.h"
#include "api/request/prepared_surface.h"
#include "api/request/preview.h"
#include <string.h>

static enum api_problem_id no_memory(struct api_problem *problem, const char *what) {
    api_problem_set(problem, API_OUT_OF_MEMORY, "%s needs more memory than allowed", what);
    return problem->id;
}

enum api_problem_id api_check_decoded(struct api_request *request, const struct api_limits *limits,
                                      struct arena *arena, struct api_problem *problem) {
    struct prepared_part shape;
    return prepared_surface_is_large(&request->surface)
               ? API_OK
               : prepared_part_make(request, limits, arena, &shape, problem);
}

static enum api_problem_id check_drape(const struct api_input *input,
                                       const struct api_limits *limits, struct arena *arena,
                                       struct api_check *check, struct api_problem *problem) {
    struct api_request request;
    if (api_decode(input, limits, arena, &request, problem) != API_OK)
        return problem->id;
    memcpy(check->surface, request.surface.id, sizeof check->surface);
    check->needs_surface = request.surface.kind == API_SURFACE_NAMED;
    if (check->needs_surface || api_check_decoded(&request, limits, arena, problem) != API_OK)
        return problem->id;
    if (!api_digest_request(&request, arena, check->digest))
        return no_memory(problem, "the request");
    return API_OK;
}

enum api_problem_id api_check_drape(const struct api_input *input, const struct api_limits *limits,
                                    struct api_check *check, struct api_problem *problem) {
    struct arena *arena = arena_new(limits->max_memory);
    *check = (struct api_check){0};
    if (arena)
        check_drape(input, limits, arena, check, problem);
    else
        no_memory(problem, "the request");
    arena_free(arena);
    return problem->id;
}

static bool write_text(const struct api_sink *sink, const char *text) {
    return sink->write(sink->context, text, strlen(text));
}

static enum api_problem_id check_surface(const struct api_input *input,
                                         const struct api_limits *limits,
                                         const struct api_sink *sink, struct arena *arena,
                                         struct api_check *check, struct api_problem *problem) {
    struct api_surface surface;
    if (api_decode_surface(input->request, input->request_length, limits, arena, &surface,
                           problem) != API_OK)
        return problem->id;
    const char *description = prepared_surface_describe(&surface, arena, problem);
    if (!description)
        return problem->id;
    const char *definition = api_normalise_surface(&surface, arena);
    if (!definition || !api_digest_surface(&surface, arena, check->surface) ||
        !write_text(sink, definition) || !write_text(sink, description))
        return no_memory(problem, "the surface");
    check->definition_length = strlen(definition);
    return API_OK;
}

enum api_problem_id api_check_surface(const struct api_input *input,
                                      const struct api_limits *limits, const struct api_sink *sink,
                                      struct api_check *check, struct api_problem *problem) {
    struct arena *arena = arena_new(limits->max_memory);
    *check = (struct api_check){0};
    if (arena)
        check_surface(input, limits, sink, arena, check, problem);
    else
        no_memory(problem, "the surface");
    arena_free(arena);
    return problem->id;
}

static enum api_problem_id check_material(const struct api_input *input,
                                          const struct api_limits *limits,
                                          const struct api_sink *sink, struct arena *arena,
                                          struct api_check *check, struct api_problem *problem) {
    struct api_material material;
    const char *head;
    if (api_material_decode(input->request, input->request_length, limits, arena, &material, &head,
                            problem) != API_OK)
        return problem->id;
    strcpy(check->material, material.name);
    check->definition_length = material.length;
    return write_text(sink, material.json) && write_text(sink, head)
               ? API_OK
               : no_memory(problem, "the material");
}

enum api_problem_id api_check_material(const struct api_input *input,
                                       const struct api_limits *limits, const struct api_sink *sink,
                                       struct api_check *check, struct api_problem *problem) {
    struct arena *arena = arena_new(limits->max_memory);
    *check = (struct api_check){0};
    if (arena)
        (void)!check_material(input, limits, sink, arena, check, problem);
    else
        no_memory(problem, "the material");
    arena_free(arena);
    return problem->id;
}

enum api_problem_id api_check_mentions(struct api_input *input, const char *own, size_t own_length,
                                       const struct api_sink *sink, struct arena *arena,
                                       struct api_check *check, struct api_problem *problem) {
    const char *wanted =
        own ? "" : api_material_wanted(input->request, input->request_length, arena);
    if (!wanted)
        return no_memory(problem, "the request");
    check->needs_materials = *wanted != '\0';
    if (check->needs_materials)
        return write_text(sink, wanted) ? API_OK : no_memory(problem, "the request");
    const char *filled = api_material_fill(input->request, input->request_length, own ? own : "",
                                           own_length, arena, &check->filled_length);
    if (!filled)
        return no_memory(problem, "the request");
    input->request = filled;
    input->request_length = check->filled_length;
    return API_OK;
}

enum api_problem_id api_check_preview(const struct api_input *input,
                                      const struct api_limits *limits, const struct api_sink *sink,
                                      struct api_problem *problem) {
    struct arena *arena = arena_new(limits->max_memory);
    struct api_surface surface;
    enum api_problem_id id = API_OK;
    if (!arena)
        id = no_memory(problem, "the preview");
    else if (api_decode_surface(input->request, input->request_length, limits, arena, &surface,
                                problem) == API_OK)
        id = api_preview(&surface, sink, arena, problem);
    arena_free(arena);
    return id != API_OK ? id : problem->id;
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
    if (problem->id == API_OK && (!text || !write_text(sink, text)))
        no_memory(problem, "the request");
    arena_free(arena);
    return problem->id;
}
