/* SPDX-License-Identifier: MIT */
#include "material.h"
#include "api/json/text.h"
#include "api/request/material.h"
#include <stdlib.h>
#include <string.h>

bool material_resolve(struct files_bytes *request, const struct material_files *files,
                      const struct api_limits *limits, struct api_problem *problem) {
    struct arena *arena = files->count ? arena_new(limits->max_memory) : NULL;
    struct api_text lines = api_text_growing(arena);
    struct files_bytes filled = {0};
    bool good = true;
    if (!files->count)
        return true;
    /* The document of each file, checked as the service would, as a line of its own. */
    for (int k = 0; arena && good && k < files->count; k++) {
        struct files_bytes file = {0};
        struct api_material material;
        const char *head;
        good = files_read(files->path[k], &file);
        if (good && api_material_decode(file.data, file.length, limits, arena, &material, &head,
                                        problem) != API_OK) {
            files_complain(files->path[k], "is not a material");
            good = false;
        }
        free(file.data);
        if (good) {
            api_text_bytes(&lines, material.json, material.length);
            api_text_raw(&lines, "\n");
        }
    }
    const char *text = arena && good
                           ? api_material_fill(request->data, request->length, lines.bytes,
                                               lines.length, arena, &filled.length)
                           : NULL;
    filled.data = text ? malloc(filled.length + 1) : NULL;
    if (filled.data) {
        memcpy(filled.data, text, filled.length + 1);
        free(request->data);
        *request = filled;
    } else if (good) {
        api_problem_set(problem, API_OUT_OF_MEMORY, "no memory for the materials");
    }
    arena_free(arena);
    return filled.data != NULL;
}
