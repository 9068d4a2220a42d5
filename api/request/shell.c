/* SPDX-License-Identifier: MIT */
#include "parts.h"

#include "solver/shell/shell.h"
#include <string.h>

enum { MARK_MAX = 512, NOTES_MAX = 100000 };

/* A string in the arena, where it is given; longer ones are cut. */
static bool copy_string(const struct json_place *place, const char **copy) {
    const char *text;
    *copy = NULL;
    if (!place_given(place))
        return true;
    if (!place_string(place, &text))
        return false;
    size_t length = strnlen(text, MARK_MAX);
    char *bytes = json_tree_alloc(place->tree, length + 1, 1);
    if (!bytes)
        return false;
    memcpy(bytes, text, length);
    *copy = bytes;
    return true;
}

static bool decode_face(const struct json_place *place, struct api_surface *face) {
    struct json_place name = place_member(place, "name"), kind = place_member(place, "kind");
    struct json_place colour = place_member(place, "colour");
    *face = (struct api_surface){.kind = API_SURFACE_NURBS};
    bool ok = decode_nurbs(place, true, face);
    ok = copy_string(&name, &face->face_name) && ok;
    ok = copy_string(&kind, &face->face_kind) && ok;
    return copy_string(&colour, &face->face_colour) && ok;
}

bool decode_faces(const struct json_place *list, struct api_surface *surface) {
    surface->kind = API_SURFACE_SHELL;
    if (!place_array(list, 1))
        return false;
    size_t count = place_length(list);
    if (count > SHELL_FACES_MAX) {
        place_fault(list, "must have at most %d faces, and has %zu", SHELL_FACES_MAX, count);
        return false;
    }
    struct api_surface *faces = json_tree_alloc(list->tree, count, sizeof *faces);
    bool ok = faces != NULL;
    for (size_t k = 0; faces && k < count; k++) {
        struct json_place face = place_element(list, k);
        ok = decode_face(&face, &faces[k]) && ok;
    }
    surface->faces = faces;
    surface->face_count = ok ? count : 0;
    return ok;
}

bool decode_origin(const struct json_place *place, struct api_surface *surface) {
    struct json_place unit = place_member(place, "length_unit");
    struct json_place notes = place_member(place, "notes");
    const char *names[API_UNIT_COUNT];
    int index = 0;
    for (int k = 0; k < API_UNIT_COUNT; k++)
        names[k] = api_units[k].name;
    bool ok = !place_given(&unit) || place_choice(&unit, names, API_UNIT_COUNT, &index);
    if (place_given(&unit))
        surface->length_unit = &api_units[index];
    if (!place_given(&notes))
        return ok;
    if (!place_array(&notes, 0) || place_length(&notes) > NOTES_MAX)
        return false;
    surface->note_count = place_length(&notes);
    const char **texts = json_tree_alloc(place->tree, surface->note_count + 1, sizeof *texts);
    ok = ok && texts;
    for (size_t k = 0; texts && k < surface->note_count; k++) {
        struct json_place note = place_element(&notes, k);
        ok = copy_string(&note, &texts[k]) && ok;
    }
    surface->notes = texts;
    return ok;
}

bool decode_shell(const struct json_place *place, struct api_surface *surface) {
    static const char *const keys[] = {"faces", "tolerance", "length_unit", "notes",
                                       "name",  "id",        NULL};
    struct json_place faces = place_member(place, "faces");
    struct json_place tolerance = place_member(place, "tolerance");
    surface->kind = API_SURFACE_SHELL;
    if (!place_object(place, keys))
        return false;
    bool ok = decode_faces(&faces, surface);
    if (place_given(&tolerance))
        ok = place_number(&tolerance, decode_lengths, &surface->tolerance) && ok;
    return decode_origin(place, surface) && ok;
}

static bool decode_list(const struct json_place *list, struct api_selection *selection) {
    size_t count = place_length(list);
    if (!place_array(list, 1))
        return false;
    int *faces = json_tree_alloc(list->tree, count, sizeof *faces);
    bool ok = faces != NULL;
    for (size_t k = 0; faces && k < count; k++) {
        struct json_place face = place_element(list, k);
        bool good = place_integer(&face, 0, SHELL_FACES_MAX - 1, &faces[k]);
        if (good && k > 0 && ok && faces[k] <= faces[k - 1]) {
            place_fault(&face, "must be more than the number before it");
            good = false;
        }
        ok = ok && good;
    }
    *selection = (struct api_selection){.kind = API_SELECT_LIST, .faces = faces, .count = count};
    return ok;
}

bool decode_selection(const struct json_place *place, struct api_surface *surface) {
    static const char *const keys[] = {"id", "faces", "grow_from", "up_to_deg", NULL};
    static const struct place_range folds = {0, 180, false};
    struct api_selection *selection = &surface->selection;
    struct json_place faces = place_member(place, "faces"), from = place_member(place, "grow_from");
    struct json_place up_to = place_member(place, "up_to_deg");
    if (!place_object(place, keys))
        return false;
    if (place_given(&faces) && place_given(&from)) {
        place_fault(place, "must have either \"faces\" or \"grow_from\"");
        return false;
    }
    if (place_given(&up_to) && !place_given(&from)) {
        place_fault(&up_to, "needs \"grow_from\"");
        return false;
    }
    if (place_given(&faces))
        return decode_list(&faces, selection);
    if (!place_given(&from))
        return true;
    selection->kind = API_SELECT_GROWN;
    selection->up_to_deg = API_UP_TO_DEG;
    return place_integer(&from, 0, SHELL_FACES_MAX - 1, &selection->grow_from) &&
           (!place_given(&up_to) || place_number(&up_to, folds, &selection->up_to_deg));
}
