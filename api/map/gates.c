/* SPDX-License-Identifier: MIT */
/* What is said of a target beside it, for a file that has no place for it: the inlet and the
 * outlet, and the direction that angles run from. */
#include "target.h"

#include "api/json/number.h"
#include "ids.h"
#include <math.h>
#include <string.h>

static const char *const gate_names[] = {
    [MAP_NO_GATE] = "", [MAP_INLET] = "inlet", [MAP_OUTLET] = "outlet"};

#define FAIL(problem, ...) (api_problem_set(problem, API_INVALID_REQUEST, __VA_ARGS__), false)

/* A list that is being applied. */
struct gating {
    const struct map_target *target;
    const struct map_id *ids; /* sorted; NULL: elements are counted from 0 */
    enum map_gate gate;
    uint8_t *gates;
    struct api_problem *problem;
};

static bool set(const struct gating *gating, size_t element) {
    uint8_t *gate = &gating->gates[element];
    if (*gate != MAP_NO_GATE && *gate != gating->gate)
        return FAIL(gating->problem, "%s: element %d is both in the inlet and in the outlet",
                    gate_names[gating->gate],
                    gating->target->ids ? gating->target->ids[element] : (int)element);
    *gate = (uint8_t)gating->gate;
    return true;
}

static bool set_element(const struct gating *gating, int32_t id) {
    const struct map_target *target = gating->target;
    int32_t element = gating->ids ? map_ids_find(gating->ids, target->element_count, id)
                      : (size_t)id < target->element_count ? id
                                                           : -1;
    if (element < 0)
        return FAIL(gating->problem, "%s: the mesh has no element %d", gate_names[gating->gate],
                    id);
    return set(gating, (size_t)element);
}

static bool set_property(const struct gating *gating, int32_t pid) {
    const struct map_target *target = gating->target;
    bool found = false;
    for (size_t k = 0; target->pids && k < target->element_count; k++) {
        if (target->pids[k] != pid)
            continue;
        found = true;
        if (!set(gating, k))
            return false;
    }
    return found || FAIL(gating->problem, "%s: the mesh has no element of property %d",
                         gate_names[gating->gate], pid);
}

/* The number at `text`, whole and positive; where it ends, or NULL. */
static const char *read_number(const char *text, int32_t *value) {
    int64_t number = 0;
    const char *at = text;
    for (; *at >= '0' && *at <= '9' && number <= INT32_MAX; at++)
        number = 10 * number + (*at - '0');
    *value = (int32_t)number;
    return at > text && number <= INT32_MAX ? at : NULL;
}

static bool apply(const struct gating *gating, const char *list) {
    for (const char *at = list; at;) {
        bool property = strncmp(at, "pid:", 4) == 0;
        int32_t number;
        at = read_number(property ? at + 4 : at, &number);
        if (!at || (*at && *at != ','))
            return FAIL(gating->problem,
                        "%s must be elements and properties parted by commas, such as 17,18,pid:3",
                        gate_names[gating->gate]);
        if (!(property ? set_property : set_element)(gating, number))
            return false;
        at = *at ? at + 1 : NULL;
    }
    return true;
}

static bool begin(struct gating *gating, struct map_target *target, struct arena *arena) {
    if (!target->elements)
        return FAIL(gating->problem, "%s needs a mesh", gate_names[gating->gate]);
    if (target->has_gate[gating->gate])
        return FAIL(gating->problem, "%s is given twice", gate_names[gating->gate]);
    target->has_gate[gating->gate] = true;
    if (!target->gates)
        target->gates = arena_alloc(arena, target->element_count, 1);
    gating->gates = target->gates;
    return true;
}

/* "x,y,z" */
static bool set_reference(struct map_target *target, const char *value,
                          struct api_problem *problem) {
    double v[3] = {0};
    const char *at = value;
    for (int k = 0; k < 3; k++) {
        size_t length = strcspn(at, ",");
        if (length == 0 || api_number_read(at, length, &v[k]) != length ||
            at[length] != (k < 2 ? ',' : '\0'))
            return FAIL(problem, "reference must be a direction, three numbers parted by commas, "
                                 "such as 1,0,0");
        at += length + (k < 2);
    }
    target->reference = vec3_make(v[0], v[1], v[2]);
    target->has_reference = true;
    double norm2 = vec3_norm2(target->reference);
    return (norm2 > 0 && isfinite(norm2)) ||
           FAIL(problem, "reference must be a direction, and not of length zero");
}

bool map_target_option(struct map_target *target, const char *name, const char *value,
                       struct arena *arena, struct api_problem *problem) {
    if (strcmp(name, "reference") == 0)
        return set_reference(target, value, problem);
    bool inlet = strcmp(name, "inlet") == 0 || strcmp(name, "inlet_elements") == 0;
    struct gating gating = {target, NULL, inlet ? MAP_INLET : MAP_OUTLET, NULL, problem};
    if (!inlet && strcmp(name, "outlet") != 0)
        return false;
    if (!begin(&gating, target, arena))
        return false;
    struct arena_mark scratch = arena_mark(arena);
    if (target->ids)
        gating.ids = map_ids_sort(target->ids, target->element_count, arena);
    bool room = gating.gates && (!target->ids || gating.ids);
    bool good = room && apply(&gating, value);
    if (!room)
        api_problem_set(problem, API_OUT_OF_MEMORY, "the mesh needs more memory than allowed");
    arena_rewind(arena, scratch);
    return good;
}
