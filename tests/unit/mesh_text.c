/* SPDX-License-Identifier: MIT */
#include "mesh_text.h"

#include "tests/check.h"
#include <stdlib.h>
#include <string.h>

enum api_problem_id mesh_text_read(mesh_reader *reader, const char *text, size_t length,
                                   struct arena *arena, struct map_target *mesh,
                                   struct api_problem *problem) {
    char *copy = malloc(length ? length : 1);
    assert_non_null(copy);
    memcpy(copy, text, length);
    memset(problem, 0, sizeof *problem);
    enum api_problem_id id = reader(copy, length, arena, mesh, problem);
    free(copy);
    return id;
}

struct map_target mesh_text_good(mesh_reader *reader, const char *text, struct arena *arena) {
    struct map_target mesh;
    struct api_problem problem;
    if (mesh_text_read(reader, text, strlen(text), arena, &mesh, &problem) != API_OK)
        fail_msg("%s\n%s", text, problem.error[0].detail);
    return mesh;
}
