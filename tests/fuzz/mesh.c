/* SPDX-License-Identifier: MIT */
#include "mesh.h"

#include <math.h>

enum { BUDGET = 1 << 24 };

static void expect_sound(const struct map_target *mesh) {
    double sum = 0.0;
    FUZZ_PROMISE(mesh->element_count > 0);
    FUZZ_PROMISE(mesh->elements || mesh->element_count == mesh->vertex_count);
    for (size_t k = 0; k < mesh->vertex_count; k++) {
        const struct vec3 *p = &mesh->vertices[k];
        FUZZ_PROMISE(fabs(p->x) <= 1e12 && fabs(p->y) <= 1e12 && fabs(p->z) <= 1e12);
    }
    for (size_t k = 0; mesh->elements && k < mesh->element_count; k++)
        for (int c = 0; c < 4; c++) {
            int32_t vertex = mesh->elements[k][c];
            FUZZ_PROMISE(vertex < (int64_t)mesh->vertex_count && vertex >= (c == 3 ? -1 : 0));
        }
    for (size_t k = 0; k < mesh->element_count; k++)
        sum += (mesh->ids ? mesh->ids[k] : 0) + (mesh->roles ? mesh->roles[k] : 0);
    FUZZ_PROMISE(sum == sum);
}

int mesh_fuzz(mesh_reader *read, const uint8_t *data, size_t size) {
    struct map_target mesh = {0};
    struct api_problem problem = {0};
    struct arena *arena = arena_new(BUDGET);
    enum api_problem_id id = read((const char *)data, size, arena, &mesh, &problem);
    FUZZ_PROMISE(id == problem.id);
    FUZZ_PROMISE(id == API_OK || id == API_MALFORMED_JSON || id == API_INVALID_REQUEST ||
                 id == API_OUT_OF_MEMORY);
    if (id == API_OK) {
        expect_sound(&mesh);
    } else {
        char *text = api_problem_json(&problem, NULL);
        FUZZ_PROMISE(text != NULL);
        free(text);
    }
    arena_free(arena);
    return 0;
}
