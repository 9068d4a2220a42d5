/* SPDX-License-Identifier: MIT */
/* The Nastran bulk data of a map request: its grids and shell elements. */
#include "target.h"

#include "api/json/text.h"
#include "bulk_data.h"
#include "ids.h"
#include "systems.h"
#include <stdio.h>
#include <string.h>

/* The data of the file, in the order of its cards. */
struct elements {
    size_t count;
    int32_t (*nodes)[4]; /* ids of grids; the fourth of a triangle is -1 */
    int32_t *id, *pid;
    uint32_t *line;
};

/* Cards that are passed over, by their names. */
enum { PASSED_NAMES = 24 };

struct passed {
    size_t names, others; /* others: cards of further names */
    struct {
        char name[BULK_NAME_SIZE];
        size_t count;
    } name[PASSED_NAMES];
};

struct file {
    struct api_problem *problem;
    int32_t grid_system; /* of grids that name none: GRDSET, wherever it stands */
    struct grids grids;
    struct elements elements;
    struct systems systems;
    struct passed passed;
    size_t curved; /* elements with nodes in the middle of edges */
};

enum { SYSTEM_UNNAMED = -1 }; /* of a grid, until all cards are read */

/* ---- cards ---- */

/* A field with an id, or 0 for none; `*id` as it is when the field is blank. */
static bool take_id(const struct bulk_card *card, int field, const char *what, int32_t *id,
                    struct api_problem *problem) {
    if (!card->field[field][0])
        return true;
    *id = 0;
    return strcmp(card->field[field], "0") == 0 || bulk_id(card, field, what, id, problem);
}

/* CTRIA3 EID PID G1 G2 G3, CQUAD4 EID PID G1 G2 G3 G4; without a PID it is the EID. FreeCAD
 * writes 0. Nodes in the middle of edges, and what follows them, mean nothing here. */
static bool take_element(struct file *file, const struct bulk_card *card, int corners) {
    struct api_problem *problem = file->problem;
    struct elements *elements = &file->elements;
    int32_t id, pid, nodes[4] = {-1, -1, -1, -1};
    if (!bulk_id(card, 0, "the id", &id, problem))
        return false;
    pid = id;
    if (!take_id(card, 1, "the property", &pid, problem))
        return false;
    for (int k = 0; k < corners; k++)
        if (!bulk_id(card, 2 + k, "a corner", &nodes[k], problem))
            return false;
    memcpy(elements->nodes[elements->count], nodes, sizeof nodes);
    elements->id[elements->count] = id;
    elements->pid[elements->count] = pid;
    elements->line[elements->count++] = (uint32_t)card->line;
    return true;
}

static void pass_over(struct passed *passed, const char *name, size_t count) {
    size_t k = 0;
    while (k < passed->names && strcmp(passed->name[k].name, name) != 0)
        k++;
    if (k == PASSED_NAMES) {
        passed->others += count;
        return;
    }
    passed->names += k == passed->names;
    strcpy(passed->name[k].name, name);
    passed->name[k].count += count;
}

static bool take_card(struct file *file, const struct bulk_card *card) {
    static const char letters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789";
    static const struct {
        char name[8];
        int corners;
        bool curved; /* it may have nodes in the middle of edges, behind the corners */
    } shells[] = {{"CTRIA3", 3, false}, {"CTRIAR", 3, false}, {"CTRIA6", 3, true},
                  {"CQUAD4", 4, false}, {"CQUADR", 4, false}, {"CQUAD8", 4, true},
                  {"CQUAD9", 4, true},  {"CQUAD", 4, true}};
    struct grids *grids = &file->grids;
    struct system found[2];
    struct vec3 point;
    int32_t id, system = SYSTEM_UNNAMED;
    /* GRID ID CP X1 X2 X3 CD ..: CD, the system of displacements, means nothing here. */
    if (strcmp(card->name, "GRID") == 0) {
        if (!bulk_id(card, 0, "the id", &id, file->problem) ||
            !take_id(card, 1, "the coordinate system", &system, file->problem) ||
            !bulk_point(card, 2, &point, file->problem))
            return false;
        grids->point[grids->count] = point;
        grids->id[grids->count] = id;
        grids->system[grids->count] = system;
        grids->line[grids->count++] = (uint32_t)card->line;
        return true;
    }
    for (size_t k = 0; k < sizeof shells / sizeof *shells; k++) {
        if (strcmp(card->name, shells[k].name) != 0)
            continue;
        file->curved += shells[k].curved && card->field[2 + shells[k].corners][0];
        return take_element(file, card, shells[k].corners);
    }
    int count = systems_read(card, found, file->problem);
    for (int k = 0; k < count; k++)
        file->systems.system[file->systems.count++] = found[k];
    if (count != 0)
        return count > 0;
    if (strcmp(card->name, "GRDSET") == 0)
        return take_id(card, 1, "the coordinate system", &file->grid_system, file->problem);
    if (strcmp(card->name, "INCLUDE") == 0)
        return MAP_REFUSE(file->problem,
                          "line %zu: the file that INCLUDE names is not read: send one file with "
                          "everything in it",
                          card->line);
    bool name = *card->name >= 'A' && *card->name <= 'Z'; /* then letters and digits */
    if (!name || card->name[strspn(card->name, letters)] != '\0')
        return MAP_REFUSE(file->problem, "line %zu: this is not a card%s", card->line,
                          strcmp(card->name, "-1") == 0
                              ? " but a universal file (UNV): export Nastran bulk data"
                              : "");
    pass_over(&file->passed, card->name, 1);
    return true;
}

static bool read_cards(struct file *file, struct bulk_reader *reader) {
    struct bulk_card card;
    while (bulk_next(reader, &card))
        if (!take_card(file, &card))
            return false;
    for (size_t k = 0; k < file->grids.count; k++)
        if (file->grids.system[k] == SYSTEM_UNNAMED)
            file->grids.system[k] = file->grid_system;
    return file->problem->id == API_OK;
}

/* Room for so many cards as there are lines that begin like one: GR.., CO.. (two systems each),
 * CTR.. and CQ.. . */
static bool make_card_room(struct file *file, const struct bulk_reader *reader,
                           struct arena *arena) {
    struct grids *grids = &file->grids;
    struct elements *elements = &file->elements;
    size_t grid_count = 0, system_count = 0, element_count = 0;
    char head[BULK_HEAD];
    for (const char *at = reader->at; bulk_head(&at, reader->end, head);) {
        grid_count += memcmp(head, "GR", 2) == 0;
        system_count += memcmp(head, "CO", 2) == 0 ? 2 : 0;
        element_count += memcmp(head, "CTR", 3) == 0 || memcmp(head, "CQ", 2) == 0;
    }
    grids->point = arena_take(arena, grid_count, sizeof *grids->point);
    grids->id = arena_take(arena, grid_count, sizeof *grids->id);
    grids->system = arena_take(arena, grid_count, sizeof *grids->system);
    grids->line = arena_take(arena, grid_count, sizeof *grids->line);
    elements->nodes = arena_take(arena, element_count, sizeof *elements->nodes);
    elements->id = arena_take(arena, element_count, sizeof *elements->id);
    elements->pid = arena_take(arena, element_count, sizeof *elements->pid);
    elements->line = arena_take(arena, element_count, sizeof *elements->line);
    file->systems.system = arena_take(arena, system_count, sizeof *file->systems.system);
    return grids->point && grids->id && grids->system && grids->line && elements->nodes &&
           elements->id && elements->pid && elements->line && file->systems.system;
}

/* ---- ids ---- */

/* Turns the ids of corners into numbers of grids; false with the problem set when an id is there
 * twice, or a corner is not. */
static bool connect_ids(struct file *file, struct arena *arena) {
    struct grids *grids = &file->grids;
    struct systems *systems = &file->systems;
    int32_t *system_ids = arena_take(arena, systems->count, sizeof *system_ids);
    for (size_t k = 0; system_ids && k < systems->count; k++)
        system_ids[k] = systems->system[k].id;
    struct map_id *elements = map_ids_sort(file->elements.id, file->elements.count, arena);
    grids->by_id = map_ids_sort(grids->id, grids->count, arena);
    systems->by_id = system_ids ? map_ids_sort(system_ids, systems->count, arena) : NULL;
    if (!grids->by_id || !elements || !systems->by_id)
        return map_target_no_memory(file->problem);
    int32_t grid = map_ids_repeated(grids->by_id, grids->count);
    int32_t element = map_ids_repeated(elements, file->elements.count);
    int32_t system = map_ids_repeated(systems->by_id, systems->count);
    if (grid >= 0)
        return MAP_REFUSE(file->problem, "line %u: GRID %d is defined twice", grids->line[grid],
                          grids->id[grid]);
    if (element >= 0)
        return MAP_REFUSE(file->problem, "line %u: element %d is defined twice",
                          file->elements.line[element], file->elements.id[element]);
    if (system >= 0)
        return MAP_REFUSE(file->problem, "line %u: coordinate system %d is defined twice",
                          systems->system[system].line, systems->system[system].id);
    for (size_t row = 0; row < file->elements.count; row++) {
        int32_t *nodes = file->elements.nodes[row];
        for (int k = 0; k < 4 && nodes[k] >= 0; k++) {
            int32_t index = map_ids_find(grids->by_id, grids->count, nodes[k]);
            if (index < 0)
                return MAP_REFUSE(
                    file->problem, "line %u: element %d has the corner %d, but there is no GRID %d",
                    file->elements.line[row], file->elements.id[row], nodes[k], nodes[k]);
            nodes[k] = index;
        }
    }
    return true;
}

/* ---- the file ---- */

/* "24 CBAR, 3 SPC1". */
static void name_passed(const struct passed *passed, char *text, size_t size) {
    size_t length = 0;
    for (size_t k = 0; k < passed->names && length < size; k++)
        length += (size_t)snprintf(text + length, size - length, "%s%zu %s", k ? ", " : "",
                                   passed->name[k].count, passed->name[k].name);
    if (passed->others > 0 && length < size)
        snprintf(text + length, size - length, ", %zu others", passed->others);
}

/* Elements get numbers of grids, and grids basic coordinates. */
static bool connect_mesh(struct file *file, struct arena *arena) {
    struct arena_mark mark = arena_mark(arena);
    bool good =
        connect_ids(file, arena) && systems_apply(&file->systems, &file->grids, file->problem);
    for (size_t k = 0; good && k < file->systems.count; k++)
        if (file->systems.system[k].state == SYSTEM_UNUSED)
            pass_over(&file->passed, file->systems.system[k].name, 1);
    arena_rewind(arena, mark);
    return good;
}

enum api_problem_id map_target_nastran(const char *bytes, size_t length, struct arena *arena,
                                       struct map_target *target, struct api_problem *problem) {
    struct file file = {.problem = problem};
    struct bulk_reader reader = bulk_begin(bytes, length, problem);
    char names[64 + PASSED_NAMES * (BULK_NAME_SIZE + 24)] = "no cards";
    *target = (struct map_target){0};
    if (!make_card_room(&file, &reader, arena)) {
        (void)map_target_no_memory(problem);
        return problem->id;
    }
    if (!read_cards(&file, &reader))
        return problem->id;
    if (file.elements.count == 0) {
        if (file.passed.names > 0)
            name_passed(&file.passed, names, API_DETAIL_MAX - 100);
        return api_problem_set(
            problem, API_INVALID_REQUEST,
            "the file has no shell elements (CTRIA3, CQUAD4, ...); beside %zu GRIDs it has %s",
            file.grids.count, names);
    }
    if (!connect_mesh(&file, arena))
        return problem->id;
    *target = (struct map_target){.vertices = file.grids.point,
                                  .vertex_count = file.grids.count,
                                  .elements = (const int32_t(*)[4])file.elements.nodes,
                                  .element_count = file.elements.count,
                                  .ids = file.elements.id,
                                  .vertex_ids = file.grids.id,
                                  .pids = file.elements.pid};
    if (file.passed.names == 0 && file.curved == 0)
        return API_OK;
    struct api_text text = api_text_growing(arena);
    if (file.passed.names > 0) {
        name_passed(&file.passed, names, sizeof names);
        api_text_raw(&text, "ignored: ");
        api_text_raw(&text, names);
        api_text_raw(&text, " (only GRIDs and shell elements are read)");
    }
    if (file.curved > 0)
        api_text_format(&text,
                        "%s%zu elements are read by their corners, without the nodes in the middle "
                        "of their edges",
                        file.passed.names > 0 ? "; " : "", file.curved);
    target->warning = api_text_finish(&text);
    if (!target->warning)
        (void)map_target_no_memory(problem);
    return problem->id;
}
