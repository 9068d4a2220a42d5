/* SPDX-License-Identifier: MIT */
/* The shells of a VTK XML file (.vtu). Cells have their numbers from a whole-number array `id` and
 * their property from `pid`, where these are there, as in the maps that are written. */
#include "ids.h"
#include "target.h"
#include "vtk_xml.h"

#include <math.h>
#include <stdio.h>

enum { PIXEL = 8, CORNERS_ANY = 0, WARNING_SIZE = 160 };

/* VTK's numbers for the shapes of shells. A polygon has as many corners as it has; of a pixel the
 * last two are the other way round. */
static const struct {
    int type, corners;
    bool curved;
} shells[] = {{5, 3, false}, {7, CORNERS_ANY, false}, {PIXEL, 4, false}, {9, 4, false},
              {22, 3, true}, {34, 3, true},           {23, 4, true},     {28, 4, true}};
enum { SHELLS = sizeof shells / sizeof *shells };

struct shell_mesh {
    int32_t (*elements)[4];
    int32_t *ids, *pids;
    size_t count, curved, passed;
};

/* A whole number from `least` to the largest int32_t. */
static bool take_whole(double value, double least, const char *what, size_t cell, int32_t *whole,
                       struct api_problem *problem) {
    bool good = value >= least && value <= INT32_MAX && floor(value) == value;
    *whole = good ? (int32_t)value : 0;
    return good || MAP_REFUSE(problem, "cell %zu: its %s is %g", cell, what, value);
}

/* Takes a cell, if it is a shell: its corners are from `first` to before `end` in the list. */
static bool take_shell_cell(const struct vtk_grid *grid, size_t cell, size_t first, size_t end,
                            struct shell_mesh *mesh, struct api_problem *problem) {
    size_t k = 0, kept = mesh->count;
    while (k < SHELLS && grid->values[VTK_TYPES][cell] != shells[k].type)
        k++;
    size_t corners = k == SHELLS                        ? 0
                     : shells[k].corners == CORNERS_ANY ? end - first
                                                        : (size_t)shells[k].corners;
    if (corners < 3 || corners > 4) {
        mesh->passed++;
        return true;
    }
    if (end - first < corners)
        return MAP_REFUSE(problem, "cell %zu has %zu points, not %zu", cell, end - first, corners);
    int32_t *element = mesh->elements[kept];
    element[3] = -1;
    for (size_t c = 0; c < corners; c++) {
        size_t to = shells[k].type == PIXEL && c > 1 ? 5 - c : c;
        if (!take_whole(grid->values[VTK_CONNECTIVITY][first + c], 0, "corner", cell, &element[to],
                        problem))
            return false;
        if ((size_t)element[to] >= grid->points)
            return MAP_REFUSE(problem, "cell %zu has the corner %d, but there are %zu points", cell,
                              element[to], grid->points);
    }
    mesh->curved += shells[k].curved;
    mesh->count++;
    return (!mesh->ids ||
            take_whole(grid->values[VTK_IDS][cell], 1, "id", cell, &mesh->ids[kept], problem)) &&
           (!mesh->pids ||
            take_whole(grid->values[VTK_PIDS][cell], 0, "pid", cell, &mesh->pids[kept], problem));
}

static bool take_cells(const struct vtk_grid *grid, struct shell_mesh *mesh,
                       struct api_problem *problem) {
    size_t first = 0;
    for (size_t cell = 0; cell < grid->cells; cell++) {
        double offset = grid->values[VTK_OFFSETS][cell];
        if (!(offset >= (double)first && offset <= (double)grid->count[VTK_CONNECTIVITY]))
            return MAP_REFUSE(problem, "cell %zu ends at %g in a list of %zu points", cell, offset,
                              grid->count[VTK_CONNECTIVITY]);
        if (!take_shell_cell(grid, cell, first, (size_t)offset, mesh, problem))
            return false;
        first = (size_t)offset;
    }
    return mesh->count > 0 ||
           MAP_REFUSE(problem,
                      "the file has no triangles or quadrilaterals; beside %zu points it "
                      "has %zu other cells",
                      grid->points, mesh->passed);
}

/* That the arrays are as long as the piece says. */
static bool is_complete_grid(const struct vtk_grid *grid, struct api_problem *problem) {
    static const char *const names[] = {"points", "connectivity", "offsets", "types"};
    for (int use = 0; use <= VTK_TYPES; use++)
        if (!grid->values[use])
            return MAP_REFUSE(problem, "the file has no array of %s", names[use]);
    if (grid->count[VTK_POINTS_ARRAY] != 3 * grid->points)
        return MAP_REFUSE(problem, "%zu points have %zu coordinates", grid->points,
                          grid->count[VTK_POINTS_ARRAY]);
    for (int use = VTK_OFFSETS; use < VTK_ARRAYS; use++)
        if (grid->values[use] && grid->count[use] != grid->cells)
            return MAP_REFUSE(problem, "%zu cells have %zu %s", grid->cells, grid->count[use],
                              use == VTK_OFFSETS ? "offsets"
                              : use == VTK_TYPES ? "types"
                                                 : "numbers");
    for (size_t k = 0; k < 3 * grid->points; k++)
        if (!(fabs(grid->values[VTK_POINTS_ARRAY][k]) <= MAP_COORDINATE_MAX))
            return MAP_REFUSE(problem, "point %zu: a coordinate must be a number of at most 1e12",
                              k / 3);
    return true;
}

/* What was passed over. */
static const char *warning_of(const struct shell_mesh *mesh, struct arena *arena) {
    char *text = arena_alloc(arena, WARNING_SIZE, 1);
    if (text)
        (void)snprintf(text, WARNING_SIZE,
                       "%zu cells that are no triangles or quadrilaterals are ignored, and %zu are "
                       "read by their corners, without the nodes in the middle of their edges",
                       mesh->passed, mesh->curved);
    return text;
}

enum api_problem_id map_target_vtu(const char *bytes, size_t length, struct arena *arena,
                                   struct map_target *target, struct api_problem *problem) {
    struct vtk_grid grid;
    struct shell_mesh mesh = {0};
    *target = (struct map_target){0};
    if (!vtk_xml_read(bytes, length, arena, &grid, problem) || !is_complete_grid(&grid, problem))
        return problem->id;
    mesh.elements = arena_take(arena, grid.cells, sizeof *mesh.elements);
    mesh.ids = grid.values[VTK_IDS] ? arena_take(arena, grid.cells, sizeof *mesh.ids) : NULL;
    mesh.pids = grid.values[VTK_PIDS] ? arena_take(arena, grid.cells, sizeof *mesh.pids) : NULL;
    if (!mesh.elements || (grid.values[VTK_IDS] && !mesh.ids) ||
        (grid.values[VTK_PIDS] && !mesh.pids))
        return api_problem_no_memory(problem, "the mesh");
    if (!take_cells(&grid, &mesh, problem))
        return problem->id;
    if (mesh.ids) {
        struct arena_mark mark = arena_mark(arena);
        const struct map_id *ids = map_ids_sort(mesh.ids, mesh.count, arena);
        int32_t twice = ids ? map_ids_repeated(ids, mesh.count) : -1;
        arena_rewind(arena, mark);
        if (!ids)
            return api_problem_no_memory(problem, "the mesh");
        if (twice >= 0)
            return api_problem_set(problem, API_INVALID_REQUEST, "the id %d is defined twice",
                                   mesh.ids[twice]);
    }
    *target = (struct map_target){.vertices = (const struct vec3 *)grid.values[VTK_POINTS_ARRAY],
                                  .vertex_count = grid.points,
                                  .elements = (const int32_t(*)[4])mesh.elements,
                                  .element_count = mesh.count,
                                  .ids = mesh.ids,
                                  .pids = mesh.pids};
    if (mesh.passed || mesh.curved) {
        target->warning = warning_of(&mesh, arena);
        if (!target->warning)
            api_problem_no_memory(problem, "the mesh");
    }
    return problem->id;
}
