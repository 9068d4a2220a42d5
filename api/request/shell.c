/* SPDX-License-Identifier: MIT */
#include "members.h"

#include "solver/shell/shell.h"
#include <string.h>

enum { MARK_MAX = 512, NOTES_MAX = 100000 };

/* A string in the arena, where it is given; longer ones are cut. */
static bool copy_string(const struct json_value *json, const char **copy) {
    const char *text;
    *copy = NULL;
    if (!value_given(json))
        return true;
    if (!value_string(json, &text))
        return false;
    size_t length = strnlen(text, MARK_MAX);
    char *bytes = json_tree_alloc(json->tree, length + 1, 1);
    if (!bytes)
        return false;
    memcpy(bytes, text, length);
    *copy = bytes;
    return true;
}

bool decode_faces(const struct json_value *list, struct api_surface *surface) {
    surface->kind = API_SURFACE_SHELL;
    if (!value_array(list, 1))
        return false;
    size_t count = value_length(list);
    if (count > SHELL_FACES_MAX)
        return value_fault(list, "must have at most %d faces, and has %zu", SHELL_FACES_MAX, count);
    struct api_surface *faces = json_tree_alloc(list->tree, count, sizeof *faces);
    bool ok = faces != NULL;
    for (size_t k = 0; faces && k < count; k++) {
        struct json_value face = value_element(list, k), name = value_member(&face, "name");
        struct json_value kind = value_member(&face, "kind");
        struct json_value colour = value_member(&face, "colour");
        faces[k] = (struct api_surface){.kind = API_SURFACE_NURBS};
        ok = decode_nurbs(&face, true, &faces[k]) && ok;
        ok = copy_string(&name, &faces[k].face_name) && ok;
        ok = copy_string(&kind, &faces[k].face_kind) && ok;
        ok = copy_string(&colour, &faces[k].face_colour) && ok;
    }
    surface->faces = faces;
    surface->face_count = ok ? count : 0;
    return ok;
}

bool decode_origin(const struct json_value *json, struct api_surface *surface) {
    struct json_value unit = value_member(json, "length_unit");
    struct json_value notes = value_member(json, "notes");
    bool ok = !value_given(&unit) || decode_unit_name(&unit, &surface->length_unit);
    if (!value_given(&notes))
        return ok;
    if (!value_array(&notes, 0) || value_length(&notes) > NOTES_MAX)
        return false;
    surface->note_count = value_length(&notes);
    const char **texts = json_tree_alloc(json->tree, surface->note_count + 1, sizeof *texts);
    ok = ok && texts;
    for (size_t k = 0; texts && k < surface->note_count; k++) {
        struct json_value note = value_element(&notes, k);
        ok = copy_string(&note, &texts[k]) && ok;
    }
    surface->notes = texts;
    return ok;
}

bool decode_shell(const struct json_value *json, struct api_surface *surface) {
    static const char *const keys[] = {"faces", "tolerance", "length_unit", "notes",
                                       "name",  "id",        NULL};
    struct json_value faces = value_member(json, "faces");
    struct json_value tolerance = value_member(json, "tolerance");
    surface->kind = API_SURFACE_SHELL;
    if (!value_object(json, keys))
        return false;
    bool ok = decode_faces(&faces, surface);
    if (value_given(&tolerance))
        ok = value_number(&tolerance, decode_lengths, &surface->tolerance) && ok;
    return decode_origin(json, surface) && ok;
}

/* What a selection grows from: the number of a face, {"element": n} or {"point": [x, y, z]}. */
static bool decode_seed(const struct json_value *json, struct api_selection *selection) {
    static const char *const keys[] = {"element", "point", NULL};
    struct json_value element = value_member(json, "element"), point = value_member(json, "point");
    if (value_type(json) != VALUE_OBJECT)
        return value_integer(json, 0, SHELL_FACES_MAX - 1, &selection->grow_from);
    if (!value_object(json, keys))
        return false;
    if (value_given(&element) == value_given(&point))
        return value_fault(json, "must have either \"element\" or \"point\"");
    selection->seed = value_given(&point) ? API_SEED_POINT : API_SEED_ELEMENT;
    if (value_given(&point))
        return value_vector(&point, decode_coordinates, 3, &selection->point.x);
    return value_integer(&element, 0, INT32_MAX, &selection->grow_from);
}

bool decode_selection(const struct json_value *json, struct api_surface *surface) {
    static const char *const keys[] = {"id", "faces", "grow_from", "up_to_deg", NULL};
    static const struct value_range folds = {0, 180, false};
    struct api_selection *selection = &surface->selection;
    struct json_value faces = value_member(json, "faces"), from = value_member(json, "grow_from");
    struct json_value up_to = value_member(json, "up_to_deg");
    if (!value_object(json, keys))
        return false;
    if (value_given(&faces) && value_given(&from))
        return value_fault(json, "must have either \"faces\" or \"grow_from\"");
    if (value_given(&up_to) && !value_given(&from))
        return value_fault(&up_to, "needs \"grow_from\"");
    if (value_given(&faces)) {
        size_t count = value_length(&faces);
        if (!value_array(&faces, 1))
            return false;
        int *list = json_tree_alloc(json->tree, count, sizeof *list);
        bool ok = list != NULL;
        for (size_t k = 0; list && k < count; k++) {
            struct json_value face = value_element(&faces, k);
            bool good = value_integer(&face, 0, SHELL_FACES_MAX - 1, &list[k]);
            if (good && k > 0 && ok && list[k] <= list[k - 1])
                good = value_fault(&face, "must be greater than the number before it");
            ok = ok && good;
        }
        *selection = (struct api_selection){.kind = API_SELECT_LIST, .faces = list, .count = count};
        return ok;
    }
    if (!value_given(&from))
        return true;
    selection->kind = API_SELECT_GROWN;
    selection->up_to_deg = API_UP_TO_DEG;
    return decode_seed(&from, selection) &&
           (!value_given(&up_to) || value_number(&up_to, folds, &selection->up_to_deg));
}
