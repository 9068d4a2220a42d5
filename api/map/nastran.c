/* SPDX-License-Identifier: MIT */
/* The Nastran bulk data of a map request: its grids and elements. */
#include "target.h"

#include "bulk_data.h"
#include "ids.h"
#include <string.h>

/* The data of the file, in the order of its cards. */
struct grids {
    size_t count;
    struct vec3 *point;
    int32_t *id;
    uint32_t *line;
};

struct elements {
    size_t count;
    int32_t (*nodes)[4]; /* ids of grids; the fourth of a triangle is -1 */
    int32_t *id;
    uint32_t *line;
};

struct file {
    struct api_problem *problem;
    bool counting; /* the first of two passes: nothing is kept */
    struct grids grids;
    struct elements elements;
};

#define FAIL(problem, ...) (api_problem_set(problem, API_INVALID_REQUEST, __VA_ARGS__), false)

/* ---- cards ---- */

/* GRID ID CP X1 X2 X3 CD ..: CD, the system of displacements, means nothing here. */
static bool take_grid(struct file *file, const struct bulk_card *card) {
    struct api_problem *problem = file->problem;
    struct grids *grids = &file->grids;
    double x[3] = {0};
    int32_t id;
    if (!bulk_id(card, 0, "the id", &id, problem))
        return false;
    if (card->field[1][0] && strcmp(card->field[1], "0") != 0)
        return FAIL(
            problem,
            "line %zu: GRID %d is in the coordinate system '%s'; only the basic one is read",
            card->line, id, card->field[1]);
    for (int k = 0; k < 3; k++)
        if (!bulk_coordinate(card, 2 + k, &x[k], problem))
            return false;
    if (!file->counting) {
        grids->point[grids->count] = vec3_make(x[0], x[1], x[2]);
        grids->id[grids->count] = id;
        grids->line[grids->count] = (uint32_t)card->line;
    }
    grids->count++;
    return true;
}

/* CTRIA3 EID PID G1 G2 G3, CQUAD4 EID PID G1 G2 G3 G4: the property and what follows the corners
 * mean nothing here. */
static bool take_element(struct file *file, const struct bulk_card *card, int corners) {
    struct api_problem *problem = file->problem;
    struct elements *elements = &file->elements;
    int32_t id, nodes[4] = {-1, -1, -1, -1};
    if (!bulk_id(card, 0, "the id", &id, problem))
        return false;
    for (int k = 0; k < corners; k++)
        if (!bulk_id(card, 2 + k, "a corner", &nodes[k], problem))
            return false;
    if (!file->counting) {
        memcpy(elements->nodes[elements->count], nodes, sizeof nodes);
        elements->id[elements->count] = id;
        elements->line[elements->count] = (uint32_t)card->line;
    }
    elements->count++;
    return true;
}

/* Cards that say nothing about where the elements are. */
static bool means_nothing(const char *name) {
    return strcmp(name, "PARAM") == 0 || strcmp(name, "PSHELL") == 0 ||
           strncmp(name, "PCOMP", 5) == 0 || strncmp(name, "MAT", 3) == 0;
}

static bool take_card(struct file *file, const struct bulk_card *card) {
    if (strcmp(card->name, "GRID") == 0)
        return take_grid(file, card);
    if (strcmp(card->name, "CTRIA3") == 0)
        return take_element(file, card, 3);
    if (strcmp(card->name, "CQUAD4") == 0)
        return take_element(file, card, 4);
    if (means_nothing(card->name))
        return true;
    for (const char *c = card->name; *c; c++)
        if (*c < ' ' || *c > '~')
            return FAIL(file->problem, "line %zu: this is no card", card->line);
    return FAIL(file->problem, "line %zu: %s is not supported; GRID, CTRIA3 and CQUAD4 are read",
                card->line, card->name);
}

/* One pass. */
static bool read_cards(struct file *file, const char *bytes, size_t length) {
    struct bulk_reader reader = bulk_begin(bytes, length, file->problem);
    struct bulk_card card;
    file->grids.count = file->elements.count = 0;
    while (bulk_next(&reader, &card))
        if (!take_card(file, &card))
            return false;
    return file->problem->id == API_OK;
}

/* ---- ids ---- */

static bool connect(struct file *file, const struct map_id *grids) {
    struct elements *elements = &file->elements;
    for (size_t row = 0; row < elements->count; row++) {
        for (int k = 0; k < 4 && elements->nodes[row][k] >= 0; k++) {
            int32_t id = elements->nodes[row][k];
            int32_t index = map_ids_find(grids, file->grids.count, id);
            if (index < 0)
                return FAIL(file->problem,
                            "line %u: element %d has the corner %d, but there is no GRID %d",
                            elements->line[row], elements->id[row], id, id);
            elements->nodes[row][k] = index;
        }
    }
    return true;
}

/* Looks for repeated ids and turns the elements' ids of corners into places. */
static bool resolve(struct file *file, struct arena *arena) {
    struct arena_mark mark = arena_mark(arena);
    struct api_problem *problem = file->problem;
    struct map_id *grids = map_ids_sort(file->grids.id, file->grids.count, arena);
    struct map_id *elements = map_ids_sort(file->elements.id, file->elements.count, arena);
    if (!grids || !elements) {
        api_problem_set(problem, API_OUT_OF_MEMORY, "the mesh needs more memory than allowed");
        return false;
    }
    int32_t grid = map_ids_repeated(grids, file->grids.count);
    int32_t element = map_ids_repeated(elements, file->elements.count);
    if (grid >= 0)
        return FAIL(problem, "line %u: there is another GRID %d before it", file->grids.line[grid],
                    file->grids.id[grid]);
    if (element >= 0)
        return FAIL(problem, "line %u: there is another element %d before it",
                    file->elements.line[element], file->elements.id[element]);
    bool good = connect(file, grids);
    arena_rewind(arena, mark);
    return good;
}

/* ---- the file ---- */

static bool allocate(struct file *file, struct arena *arena) {
    struct grids *grids = &file->grids;
    struct elements *elements = &file->elements;
    grids->point = arena_take(arena, grids->count, sizeof *grids->point);
    grids->id = arena_take(arena, grids->count, sizeof *grids->id);
    grids->line = arena_take(arena, grids->count, sizeof *grids->line);
    elements->nodes = arena_take(arena, elements->count, sizeof *elements->nodes);
    elements->id = arena_take(arena, elements->count, sizeof *elements->id);
    elements->line = arena_take(arena, elements->count, sizeof *elements->line);
    if (grids->point && grids->id && grids->line && elements->nodes && elements->id &&
        elements->line)
        return true;
    api_problem_set(file->problem, API_OUT_OF_MEMORY, "the mesh needs more memory than allowed");
    return false;
}

enum api_problem_id map_target_nastran(const char *bytes, size_t length, struct arena *arena,
                                       struct map_target *target, struct api_problem *problem) {
    struct file file = {.problem = problem, .counting = true};
    *target = (struct map_target){0};
    if (!read_cards(&file, bytes, length))
        return problem->id;
    if (file.elements.count == 0) {
        api_problem_set(problem, API_INVALID_REQUEST, "the file has no CTRIA3 and no CQUAD4");
        return problem->id;
    }
    file.counting = false;
    if (!allocate(&file, arena) || !read_cards(&file, bytes, length) || !resolve(&file, arena))
        return problem->id;
    *target = (struct map_target){.vertices = file.grids.point,
                                  .vertex_count = file.grids.count,
                                  .elements = (const int32_t(*)[4])file.elements.nodes,
                                  .element_count = file.elements.count,
                                  .ids = file.elements.id};
    return API_OK;
}
