/* SPDX-License-Identifier: MIT */
/* The inlet of a target, named beside it: for a file that has no place for it. */
#include "target.h"

#include "ids.h"

#define FAIL(problem, ...) (api_problem_set(problem, API_INVALID_REQUEST, __VA_ARGS__), false)

/* One number of the list; where it ends, or NULL. */
static const char *read_number(const char *text, int32_t *value) {
    int64_t number = 0;
    const char *at = text;
    for (; *at >= '0' && *at <= '9' && number <= INT32_MAX; at++)
        number = 10 * number + (*at - '0');
    *value = (int32_t)number;
    return at > text && number <= INT32_MAX ? at : NULL;
}

/* The element with that id, or -1. */
static int32_t find(const struct map_target *target, const struct map_id *ids, int32_t id) {
    if (ids)
        return map_ids_find(ids, target->element_count, id);
    return (size_t)id < target->element_count ? id : -1;
}

static bool mark(const struct map_target *target, const struct map_id *ids, const char *list,
                 uint8_t *inlet, struct api_problem *problem) {
    for (const char *at = list; at;) {
        int32_t id;
        at = read_number(at, &id);
        if (!at || (*at && *at != ','))
            return FAIL(problem, "inlet_elements must be elements parted by commas, such as 17,18");
        int32_t element = find(target, ids, id);
        if (element < 0)
            return FAIL(problem, "inlet_elements: the mesh has no element %d", id);
        inlet[element] = 1;
        at = *at ? at + 1 : NULL;
    }
    return true;
}

enum api_problem_id map_target_inlet(struct map_target *target, const char *list,
                                     struct arena *arena, struct api_problem *problem) {
    if (!target->elements || target->inlet) {
        api_problem_set(problem, API_INVALID_REQUEST,
                        target->inlet ? "inlet_elements is given both in the document and beside it"
                                      : "inlet_elements needs a mesh");
        return problem->id;
    }
    uint8_t *inlet = arena_alloc(arena, target->element_count, 1);
    struct arena_mark scratch = arena_mark(arena);
    struct map_id *ids =
        target->ids ? map_ids_sort(target->ids, target->element_count, arena) : NULL;
    if (!inlet || (target->ids && !ids))
        api_problem_set(problem, API_OUT_OF_MEMORY, "the mesh needs more memory than allowed");
    else if (mark(target, ids, list, inlet, problem))
        target->inlet = inlet;
    arena_rewind(arena, scratch);
    return problem->id;
}
