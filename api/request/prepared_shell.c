/* SPDX-License-Identifier: MIT */
#include "prepared_shell.h"

#include "api/json/text.h"
#include "normalise.h"
#include "prepared_form.h"
#include "prepared_surface.h"
#include "solver/surface/bounds.h"
#include "solver/surface/contour.h"
#include "solver/surface/measure.h"
#include <stdio.h>
#include <string.h>

enum { TITLE_SIZE = API_FACE_TITLE_SIZE, LIST_SIZE = 192 };

/* How far a point that selects a face may be from it, of the size of the part. */
static const double seed_near = 0.01;

/* ---- what is wrong with faces ---- */

void prepared_shell_face_title(const struct api_surface *surface, int32_t number,
                               char title[API_FACE_TITLE_SIZE]) {
    const char *name = surface->faces[number].face_name;
    if (name)
        (void)snprintf(title, TITLE_SIZE, "%d (\"%.40s\")", number, name);
    else
        (void)snprintf(title, TITLE_SIZE, "%d", number);
}

/* `base` leads to the surface in the caller's document, `offset` is what it is to be moved by. */
static void explain_fault(const struct api_surface *surface, const struct shell_fault *fault,
                          const int32_t *numbers, const char *base, double offset,
                          struct api_problem *problem) {
    char list[LIST_SIZE], pointer[API_POINTER_MAX], within[48] = "";
    struct vec3 at = fault->at;
    /* "faces 3, 7 and 9 ("rib")" */
    int length = snprintf(list, LIST_SIZE, fault->face_count == 1 ? "face" : "faces");
    for (int k = 0; k < fault->face_count && length < LIST_SIZE; k++) {
        char title[TITLE_SIZE];
        const char *before = k == 0 ? " " : k == fault->face_count - 1 ? " and " : ", ";
        prepared_shell_face_title(surface, numbers[fault->face[k]], title);
        length += snprintf(list + length, LIST_SIZE - (size_t)length, "%s%s", before, title);
    }
    (void)snprintf(pointer, sizeof pointer, "%s/%s", base,
                   fault->kind == SHELL_TOLERANCE_BAD ? "tolerance" : "faces");
    switch (fault->kind) {
    case SHELL_TOLERANCE_BAD:
        api_problem_add(
            problem, pointer,
            "is as large as the part, so that the edges of all faces would meet: make it smaller");
        break;
    case SHELL_THREE_FACES:
        if (surface->tolerance > 0)
            (void)snprintf(within, sizeof within, ", within the tolerance of %.3g",
                           surface->tolerance);
        api_problem_add(
            problem, pointer,
            "%s meet at one edge%s, near (%.6g, %.6g, %.6g): choose only the faces to be draped",
            list, within, at.x, at.y, at.z);
        break;
    case SHELL_ONE_SIDED:
        api_problem_add(problem, pointer,
                        "%s cannot be given a common orientation: the faces have only one side, "
                        "like a Moebius band",
                        list);
        break;
    case SHELL_NOTHING_LEFT:
        api_problem_set_at(problem, API_DEGENERATE_SURFACE, pointer,
                           "the trims leave no area of %s", list);
        break;
    case SHELL_LOOP_BAD:
        (void)snprintf(pointer, sizeof pointer, "%s/faces/%d/trims/%zu", base,
                       numbers[fault->face[0]], fault->loop.loop);
        prepared_surface_loop_fault(problem, pointer, list, &fault->loop);
        break;
    case SHELL_TOO_CURVED:
    case SHELL_FOLDS:
        prepared_surface_offset_fault(problem, offset, list, at, fault->radius, fault->fold_deg);
        break;
    default:
        api_problem_add(problem, pointer, "must be between 1 and %d faces", SHELL_FACES_MAX);
    }
}

/* ---- making a shell ---- */

size_t prepared_shell_bytes(const struct api_surface *surface) {
    size_t bytes = 0;
    for (size_t k = 0; k < surface->face_count; k++)
        bytes += (size_t)surface_span_bytes(&surface->faces[k].nurbs);
    return bytes;
}

/* The faces of these numbers, taken from `all` where that is there; NULL with the problem set.
 * `base` leads to the surface in the caller's document. */
static struct shell_patch *make_faces(const struct api_surface *surface,
                                      const struct prepared_shell *chosen, const char *base,
                                      struct arena *arena, struct api_problem *problem) {
    const struct shell *all = chosen->all;
    struct shell_patch *faces = arena_alloc(arena, chosen->count, sizeof *faces);
    enum status status = faces ? STATUS_OK : STATUS_OUT_OF_MEMORY;
    for (size_t k = 0; status == STATUS_OK && k < chosen->count; k++) {
        int32_t number = chosen->numbers[k];
        const struct api_surface *face = &surface->faces[number];
        struct surface *made = NULL;
        char title[TITLE_SIZE], pointer[API_POINTER_MAX];
        if (!all)
            status = surface_make(&face->nurbs, arena, &made);
        if (status == STATUS_OK) {
            faces[k] =
                (struct shell_patch){.surface = all ? shell_plain_surface(all, number) : made,
                                     .loops = face->trims,
                                     .loop_count = face->trim_count,
                                     .trim = all ? shell_trim(all, number) : NULL};
        } else if (status != STATUS_OUT_OF_MEMORY) {
            prepared_shell_face_title(surface, number, title);
            (void)snprintf(pointer, sizeof pointer, "%s/faces/%d", base, number);
            api_problem_set_at(problem, API_DEGENERATE_SURFACE, pointer, "face %s has no area",
                               title);
        }
    }
    if (status == STATUS_OUT_OF_MEMORY)
        api_problem_no_memory(problem, "the faces");
    return status == STATUS_OK ? faces : NULL;
}

/* The shell of the chosen faces, moved by `offset`. */
static enum api_problem_id join_faces(const struct api_surface *surface,
                                      struct prepared_shell *chosen, const char *base,
                                      double offset, struct arena *arena,
                                      struct api_problem *problem) {
    struct shell_fault fault = {0};
    struct shell *shell;
    struct shell_patch *faces = make_faces(surface, chosen, base, arena, problem);
    if (!faces)
        return problem->id;
    enum status status =
        shell_make(faces, chosen->count, surface->tolerance, arena, &shell, &fault);
    if (status == STATUS_OK && offset != 0)
        status = shell_offset(shell, faces, offset, arena, &shell, &fault);
    if (status == STATUS_OUT_OF_MEMORY)
        return api_problem_no_memory(problem, "the faces");
    if (status != STATUS_OK)
        explain_fault(surface, &fault, chosen->numbers, base, offset, problem);
    else
        chosen->shell = shell;
    return problem->id;
}

/* All faces, joined where they can be, unless they are already. `chosen` has their numbers. */
static enum api_problem_id make_apart(const struct api_surface *surface,
                                      struct prepared_shell *chosen, const char *base,
                                      struct arena *arena, struct api_problem *problem) {
    if (chosen->all)
        return API_OK;
    struct shell *shell;
    struct shell_patch *faces = make_faces(surface, chosen, base, arena, problem);
    if (!faces)
        return problem->id;
    enum status status =
        shell_make_lenient(faces, chosen->count, surface->tolerance, arena, &shell);
    if (status == STATUS_OUT_OF_MEMORY)
        return api_problem_no_memory(problem, "the faces");
    if (status != STATUS_OK) /* why, it says itself */
        return join_faces(surface, chosen, base, 0, arena, problem);
    chosen->all = shell;
    return API_OK;
}

/* Chooses all faces. False without memory. */
static bool choose_all(const struct api_surface *surface, struct arena *arena,
                       struct prepared_shell *chosen) {
    int32_t *numbers = arena_alloc(arena, surface->face_count, sizeof *numbers);
    for (size_t k = 0; numbers && k < surface->face_count; k++)
        numbers[k] = (int32_t)k;
    chosen->numbers = numbers;
    chosen->count = surface->face_count;
    return numbers != NULL;
}

enum api_problem_id prepared_shell_make_whole(const struct api_surface *surface,
                                              struct arena *arena, struct prepared_shell *shell,
                                              struct api_problem *fault) {
    struct api_problem apart = {0};
    *shell = (struct prepared_shell){0};
    if (!choose_all(surface, arena, shell))
        return api_problem_no_memory(fault, "the faces");
    struct arena_mark mark = arena_mark(arena);
    shell->sound = join_faces(surface, shell, "", 0, arena, fault) == API_OK;
    shell->all = shell->shell;
    if (shell->sound || fault->id == API_OUT_OF_MEMORY)
        return fault->id;
    arena_rewind(arena, mark);
    if (make_apart(surface, shell, "", arena, &apart) == API_OUT_OF_MEMORY)
        *fault = apart;
    return apart.id == API_OUT_OF_MEMORY ? API_OUT_OF_MEMORY : API_OK;
}

/* ---- the selection ---- */

static enum api_problem_id refuse_number(const struct api_surface *surface, const char *pointer,
                                         struct api_problem *problem) {
    return api_problem_add(problem, pointer, "must be less than %zu, the number of faces",
                           surface->face_count);
}

/* The face that is nearest to a point. */
static enum api_problem_id seed_face(const struct shell *shell, struct vec3 point, int32_t *face,
                                     struct api_problem *problem) {
    struct shell_point place;
    double distance;
    shell_nearest(shell, point, SHELL_ANY, &place, &distance);
    *face = place.face;
    if (distance <= seed_near * shell_size(shell))
        return API_OK;
    return api_problem_add(problem, "/surface/grow_from/point",
                           "is %.4g away from the faces, the nearest of which is %d", distance,
                           place.face);
}

/* The numbers of the faces that the request selects. */
static enum api_problem_id choose_faces(const struct api_surface *surface, struct arena *arena,
                                        struct prepared_shell *shell, struct api_problem *problem) {
    const struct api_selection *selection = &surface->selection;
    char pointer[API_POINTER_MAX];
    if (selection->kind == API_SELECT_LIST) {
        for (size_t k = 0; k < selection->count; k++)
            if ((size_t)selection->faces[k] >= surface->face_count) {
                (void)snprintf(pointer, sizeof pointer, "/surface/faces/%zu", k);
                return refuse_number(surface, pointer, problem);
            }
        shell->numbers = selection->faces;
        shell->count = selection->count;
        return API_OK;
    }
    if (!choose_all(surface, arena, shell))
        return api_problem_no_memory(problem, "the faces");
    if (selection->kind != API_SELECT_GROWN)
        return API_OK;
    /* Of all faces those stay that are reached. */
    if ((size_t)selection->grow_from >= surface->face_count)
        return refuse_number(surface, "/surface/grow_from", problem);
    if (selection->seed == API_SEED_ELEMENT)
        return api_problem_add(problem, "/surface/grow_from/element",
                               "is for meshes: name a face by its number, or by a point on it");
    if (make_apart(surface, shell, "/surface", arena, problem) != API_OK)
        return problem->id;
    int32_t from = selection->grow_from;
    if (selection->seed == API_SEED_POINT &&
        seed_face(shell->all, selection->point, &from, problem) != API_OK)
        return problem->id;
    int32_t *numbers = arena_alloc(arena, shell->count, sizeof *numbers);
    uint8_t *reached = arena_alloc(arena, shell->count, 1);
    if (!numbers || !reached ||
        shell_grow(shell->all, from, selection->up_to_deg, arena, reached) != STATUS_OK)
        return api_problem_no_memory(problem, "the faces");
    size_t kept = 0;
    for (size_t k = 0; k < shell->count; k++)
        if (reached[k])
            numbers[kept++] = (int32_t)k;
    shell->numbers = numbers;
    shell->count = kept;
    return API_OK;
}

void prepared_shell_name_left_out(const struct api_request *request,
                                  const struct prepared_shell *chosen, struct arena *arena,
                                  struct api_problem *problem) {
    const struct drape_settings *settings = &request->settings;
    struct prepared_shell every = {.all = chosen->all};
    struct api_problem ignored = {0};
    struct shell_point place;
    double distance;
    char title[TITLE_SIZE];
    if (settings->start_kind != DRAPE_START_POINT || chosen->count == request->surface.face_count ||
        !choose_all(&request->surface, arena, &every) ||
        make_apart(&request->surface, &every, "", arena, &ignored) != API_OK)
        return;
    shell_nearest(every.all, settings->start_point, SHELL_ANY, &place, &distance);
    if (distance > fmax(settings->spacing[0], settings->spacing[1]))
        return;
    prepared_shell_face_title(&request->surface, place.face, title);
    api_problem_set_at(problem, API_START_OFF_SURFACE, "/start",
                       "the start is on face %s, which is not among those chosen", title);
}

/* The faces that the request chooses, as they were made ready before, or their numbers alone. */
static enum api_problem_id begin_shell(const struct api_request *request, struct arena *arena,
                                       struct prepared_shell *shell, struct api_problem *problem) {
    const struct prepared_part *ready = prepared_form_part(request);
    const struct prepared_form *form = request->surface.form;
    *shell = (struct prepared_shell){0};
    if (ready) {
        *shell = ready->shell;
        return API_OK;
    }
    if (form) {
        shell->all = form->part.shell.all;
        shell->sound = form->part.shell.sound;
    }
    return choose_faces(&request->surface, arena, shell, problem);
}

/* Joins the faces, unless they are already. */
static enum api_problem_id join_chosen(const struct api_request *request, struct arena *arena,
                                       struct prepared_shell *shell, struct api_problem *problem) {
    bool whole = shell->count == request->surface.face_count && request->offset == 0;
    if (whole && shell->sound)
        shell->shell = shell->all;
    if (shell->shell)
        return API_OK;
    if (join_faces(&request->surface, shell, "/surface", request->offset, arena, problem) != API_OK)
        return problem->id;
    shell->sound = shell->sound || whole;
    shell->all = whole ? shell->shell : shell->all;
    return API_OK;
}

enum api_problem_id prepared_shell_make(const struct api_request *request,
                                        const struct api_limits *limits, struct arena *arena,
                                        struct prepared_shell *shell, struct api_problem *problem) {
    const struct drape_settings *settings = &request->settings;
    double largest = 0;
    if (begin_shell(request, arena, shell, problem) != API_OK)
        return problem->id;
    /* Where in the shell the start's face is. */
    size_t at = 0;
    bool on_face = settings->start_kind == DRAPE_START_UV;
    while (on_face && at < shell->count && shell->numbers[at] != settings->start_face)
        at++;
    if (on_face && at == shell->count) {
        char title[TITLE_SIZE];
        prepared_shell_face_title(&request->surface, settings->start_face, title);
        return api_problem_add(problem, "/start/face", "face %s is not among those chosen", title);
    }
    shell->start_face = (int32_t)at;
    if (join_chosen(request, arena, shell, problem) != API_OK)
        return problem->id;
    for (size_t k = 0; k < shell_component_count(shell->shell); k++)
        largest = fmax(largest, shell_area(shell->shell, (int32_t)k, NULL));
    if (settings->has_extent[0] || settings->has_extent[1])
        return API_OK;
    return prepared_surface_check_nodes(largest / (settings->spacing[0] * settings->spacing[1]),
                                        "the faces", limits, problem);
}

/* ---- its description ---- */

/* Faces that cannot be one surface may be stored by an importer, for some of them can be chosen:
 * then the fault is a note, and they are joined where they can be. */
static enum api_problem_id describe_edges(const struct api_surface *surface,
                                          const struct shell *all, const struct api_problem *fault,
                                          struct api_text *text, struct api_problem *problem) {
    if (fault->id != API_OK && !surface->notes) {
        *problem = *fault;
        return problem->id;
    }
    struct shell_edges edges = all ? shell_edges(all) : (struct shell_edges){0};
    api_text_key_object(text, "edges");
    api_text_key_integer(text, "shared", (int64_t)edges.joined);
    api_text_key_integer(text, "free", (int64_t)edges.free);
    api_text_key_integer(text, "faulty",
                         fault->id != API_OK && edges.faulty == 0 ? 1 : (int64_t)edges.faulty);
    api_text_key_number(text, "largest_gap", edges.largest_gap);
    api_text_raw(text, "}");
    if (all) {
        api_text_key_number(text, "tolerance", shell_tolerance(all));
        /* [face, face, fold in degrees] of every joint. */
        size_t count = shell_edge_count(all);
        const char *before = "[";
        api_text_key(text, "joints");
        for (size_t k = 0; k < count; k++) {
            int32_t face[2];
            double fold;
            if (!shell_joint(all, k, face, &fold))
                continue;
            api_text_raw(text, before);
            api_text_numbers(text, (const double[]){face[0], face[1], fold}, 3);
            before = ",";
        }
        api_text_raw(text, *before == '[' ? "[]" : "]");
        api_text_key_integer(text, "components", (int64_t)shell_component_count(all));
    }
    api_normalise_notes(text, surface, fault->id != API_OK ? fault->error[0].detail : "");
    return API_OK;
}

enum api_problem_id prepared_shell_describe(const struct api_surface *surface,
                                            const struct prepared_shell *whole,
                                            const struct api_problem *fault, struct api_text *text,
                                            struct arena *arena, struct api_problem *problem) {
    struct vec3 lower = {0}, upper = {0};
    double area = 0;
    api_text_key(text, "faces");
    api_text_raw(text, "[");
    for (size_t k = 0; k < surface->face_count; k++) {
        const struct api_surface *face = &surface->faces[k];
        struct contour_measure measure;
        const struct surface *plain =
            whole->all ? shell_plain_surface(whole->all, (int32_t)k) : NULL;
        struct surface *made = NULL;
        struct arena_mark mark = arena_mark(arena);
        enum status status = plain ? STATUS_OK : surface_make(&face->nurbs, arena, &made);
        if (status == STATUS_OK)
            status = contour_measure(plain ? plain : made, face->trims, face->trim_count, arena,
                                     &measure);
        arena_rewind(arena, mark);
        if (status == STATUS_OUT_OF_MEMORY)
            return api_problem_no_memory(problem, "the faces");
        if (status != STATUS_OK) /* its number stays */
            measure = (struct contour_measure){0};
        api_text_raw(text, k ? ",{" : "{");
        api_text_key_integer(text, "index", (int64_t)k);
        api_text_key_number(text, "area", measure.area);
        api_text_box(text, &measure.lower.x, &measure.upper.x);
        api_text_key_numbers(text, "centre", &measure.centre.x, 3);
        api_text_key_numbers(text, "normal", &measure.normal.x, 3);
        api_text_key_string(text, "kind", face->face_kind ? face->face_kind : "nurbs");
        if (face->face_name)
            api_text_key_string(text, "name", face->face_name);
        if (face->face_colour)
            api_text_key_string(text, "colour", face->face_colour);
        api_text_raw(text, "}");
        if (status != STATUS_OK)
            continue;
        lower = area > 0 ? vec3_min(lower, measure.lower) : measure.lower;
        upper = area > 0 ? vec3_max(upper, measure.upper) : measure.upper;
        area += measure.area;
    }
    api_text_raw(text, "]");
    if (!(area > 0))
        return api_problem_set_at(problem, API_DEGENERATE_SURFACE, "/faces", "no face has an area");
    if (describe_edges(surface, whole->all, fault, text, problem) != API_OK)
        return problem->id;
    api_text_box(text, &lower.x, &upper.x);
    api_text_key_number(text, "area", area);
    return API_OK;
}
