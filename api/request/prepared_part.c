/* SPDX-License-Identifier: MIT */
#include "prepared_part.h"

#include "api/json/text.h"
#include "digest.h"
#include "normalise.h"
#include "prepared_form.h"
#include "prepared_mesh.h"
#include "prepared_surface.h"
#include "solver/drape.h"
#include "solver/surface/measure.h"
#include <stdio.h>
#include <string.h>

bool prepared_part_is_large(const struct api_surface *surface) {
    return surface->kind == API_SURFACE_SHELL
               ? prepared_shell_bytes(surface) > PREPARED_SPANS_MAX
               : surface->kind == API_SURFACE_NURBS &&
                     surface_span_bytes(&surface->nurbs) > PREPARED_SPANS_MAX;
}

enum api_problem_id prepared_part_make(const struct api_request *request,
                                       const struct api_limits *limits, struct arena *arena,
                                       struct prepared_part *prepared,
                                       struct api_problem *problem) {
    const struct prepared_part *ready = prepared_form_part(request);
    enum api_problem_id id;
    *prepared = (struct prepared_part){0};
    if (ready) {
        prepared->bends = ready->bends;
        prepared->prepared = ready->prepared;
    }
    switch (request->surface.kind) {
    case API_SURFACE_MESH:
        return prepared_mesh_make(request, limits, arena, &prepared->part.mesh, problem);
    case API_SURFACE_SHELL:
        id = prepared_shell_make(request, limits, arena, &prepared->shell, problem);
        prepared->part.shell = prepared->shell.shell;
        return id;
    default:
        return prepared_surface_make(request, limits, arena, &prepared->part, problem);
    }
}

const struct surface_bends *prepared_part_bends(struct prepared_part *prepared) {
    if (prepared->bends.least_radius == 0)
        drape_find_bends(&prepared->part, &prepared->bends);
    return &prepared->bends;
}

/* The places with faces as a shell counts them; a face that it does not have is faulty. */
static enum api_problem_id settle_places(const struct prepared_shell *shell,
                                         struct drape_generator *generator, struct arena *arena,
                                         struct api_problem *problem) {
    size_t count = generator->place_count;
    struct drape_place *places = arena_alloc(arena, count, sizeof *places);
    char pointer[API_POINTER_MAX];
    if (!places)
        return api_problem_no_memory(problem, "the drape");
    memcpy(places, generator->places, count * sizeof *places);
    for (size_t k = 0; k < count; k++) {
        size_t at = 0, faces = shell->shell ? shell->count : 1;
        while (at < faces && places[k].face != (shell->shell ? shell->numbers[at] : 0))
            at++;
        (void)snprintf(pointer, sizeof pointer, "/generators/warp/places/%zu", k);
        if (at == faces)
            return api_problem_add(problem, pointer, "is on face %d, which the part does not have",
                                   (int)places[k].face);
        places[k].face = (int32_t)at;
    }
    generator->places = places;
    return API_OK;
}

enum api_problem_id prepared_part_settle(const struct prepared_part *prepared, struct arena *arena,
                                         struct drape_settings *settings,
                                         struct api_problem *problem) {
    settings->start_face = prepared->shell.start_face;
    settings->prepared = prepared->prepared;
    return settings->generator[0].kind == DRAPE_GENERATOR_PLACES
               ? settle_places(&prepared->shell, &settings->generator[0], arena, problem)
               : API_OK;
}

enum api_problem_id prepared_part_make_whole(const struct api_surface *surface, struct arena *arena,
                                             struct prepared_part *whole,
                                             struct api_problem *fault) {
    enum api_problem_id id;
    *whole = (struct prepared_part){0};
    switch (surface->kind) {
    case API_SURFACE_MESH:
        return prepared_mesh_make_whole(surface, arena, &whole->part.mesh, fault);
    case API_SURFACE_SHELL:
        id = prepared_shell_make_whole(surface, arena, &whole->shell, fault);
        whole->part.shell = whole->shell.shell;
        return id;
    default:
        return prepared_part_is_large(surface)
                   ? API_OK
                   : prepared_surface_make_whole(surface, arena, &whole->part, fault);
    }
}

const char *prepared_part_describe(const struct api_surface *surface,
                                   const struct prepared_part *whole,
                                   const struct api_problem *fault, struct arena *arena,
                                   struct api_problem *problem) {
    bool on_mesh = surface->kind == API_SURFACE_MESH, on_shell = surface->kind == API_SURFACE_SHELL;
    char id[API_ID_SIZE];
    struct api_text text = api_text_growing(arena);
    if (!api_digest_surface(surface, arena, id)) {
        api_problem_no_memory(problem, "the description of the surface");
        return NULL;
    }
    api_text_raw(&text, "{");
    api_text_key_string(&text, "id", id);
    if (on_mesh    ? prepared_mesh_describe(surface, whole->part.mesh, &text, arena, problem)
        : on_shell ? prepared_shell_describe(surface, &whole->shell, fault, &text, arena, problem)
                   : prepared_surface_describe(surface, &whole->part, &text, arena, problem))
        return NULL;
    if (on_mesh)
        api_normalise_notes(&text, surface, "");
    if (surface->length_unit)
        api_text_key_string(&text, "length_unit", surface->length_unit->name);
    api_text_raw(&text, "}");
    const char *document = api_text_finish(&text);
    if (!document)
        api_problem_no_memory(problem, "the description of the surface");
    return document;
}
