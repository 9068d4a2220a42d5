/* SPDX-License-Identifier: MIT */
#include "files.h"

#include "api/json/text.h"
#include "api/request/request.h"
#include "triangles.h"
#include <stdio.h>
#include <string.h>
#include <strings.h>

const struct file_format file_formats[FILE_FORMATS] = {
    {"step", "model/step", {".step", ".stp", ".p21"}, true, NULL},
    {"iges", "model/iges", {".iges", ".igs"}, true, NULL},
    {"stl", "model/stl", {".stl"}, false, NULL},
    {"obj", "model/obj", {".obj"}, false, NULL},
    {"nastran", "text/x-nastran", {".bdf", ".nas", ".dat"}, false, map_target_nastran},
    {"abaqus", "text/x-abaqus", {".inp"}, false, map_target_abaqus},
    {"lsdyna", "text/x-lsdyna", {".k", ".key"}, false, map_target_lsdyna},
    {"gmsh", "text/x-gmsh", {".msh"}, false, map_target_gmsh},
    {"unv", "text/x-unv", {".unv"}, false, map_target_universal},
    {"vtu", "application/vnd.vtk", {".vtu"}, false, map_target_vtu},
};

/* Files that are taken for parts, and what to do with them. */
static const struct {
    const char *endings, *what;
} others[] = {
    {".fcstd", "FreeCAD's own document: export the part from FreeCAD as STEP"},
    {".cdb .rad .med .vtk .ply .3mf .off .gltf .glb .amf .wrl",
     "a mesh in a format that is not read: save its shell as STL, OBJ or Nastran bulk data"},
    {".sldprt .sldasm .catpart .catproduct .prt .asm .ipt .iam .par .f3d .3dm .dwg .dxf .x_t .x_b "
     ".xmt_txt .sat .sab .brep .brp .jt .3ds .skp .blend",
     "a CAD system's own document: export the part as STEP"},
    {".zip .gz .7z .zst .xz", "an archive: unpack it"},
};

bool file_refuse(const char *path, char text[FILE_REFUSAL_SIZE]) {
    const char *slash = strrchr(path, '/'), *dot = strrchr(slash ? slash : path, '.'), *what = NULL;
    size_t length = dot ? strlen(dot) : 0;
    for (size_t k = 0; dot && k < sizeof others / sizeof *others; k++)
        for (const char *at = others[k].endings; *at; at += strcspn(at, " "), at += *at == ' ')
            if (strcspn(at, " ") == length && strncasecmp(at, dot, length) == 0)
                what = others[k].what;
    if (what)
        (void)snprintf(text, FILE_REFUSAL_SIZE, "a file that ends in %.16s is %s", dot, what);
    else
        (void)snprintf(text, FILE_REFUSAL_SIZE,
                       "must end in .step, .stp, .p21, .iges, .igs, .stl, .obj, .bdf, .nas, .dat, "
                       ".inp, .k, .key, "
                       ".msh, .unv or .vtu");
    return what != NULL;
}

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

/* The triangles of a file, welded. */
static bool read_triangles(const struct file_format *format, const char *bytes, size_t length,
                           struct triangles *triangles) {
    return (strcmp(format->name, "stl") == 0 ? triangles_read_stl(triangles, bytes, length)
            : strcmp(format->name, "obj") == 0
                ? triangles_read_obj(triangles, bytes, length)
                : triangles_read_shells(triangles, format->read, bytes, length)) &&
           triangles_weld(triangles);
}

enum api_problem_id file_read_target(const struct file_format *format, const char *bytes,
                                     size_t length, struct arena *arena, struct map_target *target,
                                     struct api_problem *problem) {
    if (format->read)
        return format->read(bytes, length, arena, target, problem);
    struct triangles triangles = {.arena = arena, .problem = problem};
    if (!read_triangles(format, bytes, length, &triangles))
        return problem->id;
    int32_t(*elements)[4] = arena_take(arena, triangles.count, sizeof *elements);
    if (!elements)
        return api_problem_no_memory(problem, "the mesh");
    for (size_t k = 0; k < triangles.count; k++) {
        memcpy(elements[k], triangles.corners[k], sizeof triangles.corners[k]);
        elements[k][3] = -1;
    }
    *target = (struct map_target){.vertices = triangles.vertices,
                                  .vertex_count = triangles.vertex_count,
                                  .elements = (const int32_t(*)[4])elements,
                                  .element_count = triangles.count};
    return API_OK;
}

enum api_problem_id file_read_mesh(const struct file_format *format, const char *bytes,
                                   size_t length, const char *unit, struct arena *arena,
                                   const char **text, size_t *text_length,
                                   struct api_problem *problem) {
    struct triangles triangles = {.arena = arena, .problem = problem};
    if (!read_triangles(format, bytes, length, &triangles))
        return problem->id;
    const struct {
        size_t count;
        const char *what;
    } notes[] = {{triangles.without_area, "with no area, or almost none"},
                 {triangles.duplicate, "with the same corners as another one"}};
    struct api_text mesh = api_text_growing(arena);
    char note[96];
    bool first = *unit != '\0';
    api_text_raw(&mesh, "{");
    api_text_key_rows(&mesh, "vertices", &triangles.vertices[0].x, 3, triangles.vertex_count);
    api_text_raw(&mesh, ",\"triangles\":[");
    for (size_t k = 0; k < triangles.count; k++) {
        api_text_raw(&mesh, k ? "," : "");
        api_text_integers(&mesh, triangles.corners[k], 3);
    }
    api_text_raw(&mesh, "]");
    api_text_key_string(&mesh, "length_unit", *unit ? unit : FILE_UNIT);
    api_text_raw(&mesh, ",\"notes\":[");
    if (!*unit)
        api_text_string(&mesh, "the file states no unit: " FILE_UNIT " is assumed");
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
