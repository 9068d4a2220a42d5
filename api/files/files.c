/* SPDX-License-Identifier: MIT */
#include "files.h"

#include "api/json/text.h"
#include "api/request/request.h"
#include "triangles.h"
#include <stdio.h>
#include <string.h>
#include <strings.h>

const struct file_format file_formats[FILE_FORMATS] = {
    {"step", "model/step", {".step", ".stp", NULL}, true},
    {"iges", "model/iges", {".iges", ".igs", NULL}, true},
    {"stl", "model/stl", {".stl", NULL, NULL}, false},
    {"obj", "model/obj", {".obj", NULL, NULL}, false},
    {"nastran", "text/x-nastran", {".bdf", ".nas", NULL}, false},
};

const struct file_format *file_format_named(const char *name) {
    for (int k = 0; k < FILE_FORMATS; k++)
        if (strcmp(file_formats[k].name, name) == 0)
            return &file_formats[k];
    return NULL;
}

const struct file_format *file_format_of(const char *path) {
    const char *dot = strrchr(path, '.');
    for (int k = 0; dot && k < FILE_FORMATS; k++)
        for (const char *const *suffix = file_formats[k].suffixes; *suffix; suffix++)
            if (strcasecmp(*suffix, dot) == 0)
                return &file_formats[k];
    return NULL;
}

bool file_unit_known(const char *unit) {
    for (int k = 0; k < API_UNIT_COUNT; k++)
        if (strcmp(api_units[k].name, unit) == 0)
            return true;
    return false;
}

enum api_problem_id file_read_mesh(const struct file_format *format, const char *bytes,
                                   size_t length, const char *unit, struct arena *arena,
                                   const char **text, size_t *text_length,
                                   struct api_problem *problem) {
    struct triangles triangles = {.arena = arena, .problem = problem};
    bool good = strcmp(format->name, "stl") == 0 ? triangles_read_stl(&triangles, bytes, length)
                : strcmp(format->name, "obj") == 0
                    ? triangles_read_obj(&triangles, bytes, length)
                    : triangles_read_nastran(&triangles, bytes, length);
    if (!good || !triangles_weld(&triangles))
        return problem->id;
    const struct {
        size_t count;
        const char *what;
    } notes[] = {{triangles.without_area, "with no area, or almost none"},
                 {triangles.duplicate, "with the same corners as another one"}};
    struct api_text mesh = api_text_growing(arena);
    char note[96];
    bool first = true;
    api_text_raw(&mesh, "{");
    api_text_key_rows(&mesh, "vertices", &triangles.vertices[0].x, 3, triangles.vertex_count);
    api_text_raw(&mesh, ",\"triangles\":[");
    for (size_t k = 0; k < triangles.count; k++) {
        api_text_raw(&mesh, k ? "," : "");
        api_text_integers(&mesh, triangles.corners[k], 3);
    }
    api_text_raw(&mesh, "]");
    if (*unit)
        api_text_key_string(&mesh, "length_unit", unit);
    api_text_raw(&mesh, ",\"notes\":[");
    for (size_t k = 0; k < sizeof notes / sizeof *notes; k++) {
        if (!notes[k].count)
            continue;
        snprintf(note, sizeof note, "left out: %zu triangles %s", notes[k].count, notes[k].what);
        api_text_raw(&mesh, first ? "" : ",");
        api_text_string(&mesh, note);
        first = false;
    }
    api_text_raw(&mesh, "]}");
    *text_length = mesh.length;
    *text = api_text_finish(&mesh);
    return *text ? API_OK : api_problem_no_memory(problem, "the mesh");
}
