/* SPDX-License-Identifier: MIT */
/* What is said of a target beside it, for a file that has no place for it: the inlet, the outlet
 * and the channel, and the direction that angles run from. */
#include "target.h"

#include "api/format/element.h"
#include "api/json/number.h"
#include "cavity.h"
#include "channel.h"
#include "ids.h"
#include <math.h>
#include <string.h>

static const char *const gate_names[] = {
    [MAP_NO_GATE] = "",
    [MAP_INLET] = "inlet",
    [MAP_OUTLET] = "outlet",
    [MAP_CHANNEL] = "edge_channel",
};

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

/* All elements whose middle is near to the line from place[0..2] to place[3..5]. */
static bool set_near(const struct gating *gating, const double place[6], double distance) {
    struct vec3 a = vec3_make(place[0], place[1], place[2]);
    struct vec3 b = vec3_make(place[3], place[4], place[5]);
    bool found = false;
    for (size_t k = 0; k < gating->target->element_count; k++) {
        struct vec3 middle = map_target_place(gating->target, k);
        if (map_segment_distance(a, b, middle) > distance)
            continue;
        found = true;
        if (!set(gating, k))
            return false;
    }
    return found || FAIL(gating->problem,
                         "%s: no element has its middle within %g of that place; are the numbers "
                         "in the drape's length unit?",
                         gate_names[gating->gate], distance);
}

/* `count` numbers, each after a `mark` but the first; where they end, or NULL. */
static const char *read_reals(const char *text, char mark, size_t count, double *values) {
    for (size_t k = 0; k < count; k++) {
        size_t taken = 0;
        if (k == 0 || *text++ == mark)
            taken = api_number_read(text, strlen(text), &values[k]);
        if (taken == 0)
            return NULL;
        text += taken;
    }
    return text;
}

/* "sphere:x:y:z:radius" or "line:x:y:z:x:y:z:distance": where it ends, NULL if it is neither. */
static const char *read_place(const char *text, double place[6], double *distance) {
    bool sphere = strncmp(text, "sphere:", 7) == 0, line = strncmp(text, "line:", 5) == 0;
    double values[7];
    size_t count = sphere ? 4 : 7;
    const char *end = sphere ? read_reals(text + 7, ':', count, values)
                      : line ? read_reals(text + 5, ':', count, values)
                             : NULL;
    if (!end || !(values[count - 1] > 0))
        return NULL;
    memcpy(place, values, 3 * sizeof *place);
    memcpy(place + 3, sphere ? values : values + 3, 3 * sizeof *place);
    *distance = values[count - 1];
    return end;
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

/* One of the list: sets what it names; where it ends, NULL with the problem set. */
static const char *apply_one(const struct gating *gating, const char *text) {
    double place[6], distance;
    int32_t number;
    bool property = strncmp(text, "pid:", 4) == 0;
    const char *whole = read_number(property ? text + 4 : text, &number);
    const char *end = whole && *whole != ':' ? whole : read_place(text, place, &distance);
    bool good = end && (*end == '\0' || *end == ',');
    if (!good)
        good = FAIL(gating->problem,
                    "%s must be elements, properties and places parted by commas, such as "
                    "17,18,pid:3,sphere:x:y:z:radius,line:x:y:z:x:y:z:distance",
                    gate_names[gating->gate]);
    else if (end != whole)
        good = set_near(gating, place, distance);
    else
        good = (property ? set_property : set_element)(gating, number);
    return good ? end : NULL;
}

static bool apply(const struct gating *gating, const char *list) {
    const char *at = apply_one(gating, list);
    while (at && *at)
        at = apply_one(gating, at + 1);
    return at != NULL;
}

static bool begin(struct gating *gating, struct map_target *target, struct arena *arena) {
    if (!target->elements)
        return FAIL(gating->problem, "%s needs a mesh", gate_names[gating->gate]);
    if (target->has_gate[gating->gate])
        return FAIL(gating->problem, "%s is given twice", gate_names[gating->gate]);
    target->has_gate[gating->gate] = true;
    if (!target->gates)
        target->gates = arena_alloc(arena, target->element_count, 1);
    if (!target->gates)
        api_problem_set(gating->problem, API_OUT_OF_MEMORY,
                        "the mesh needs more memory than allowed");
    gating->gates = target->gates;
    return target->gates != NULL;
}

static bool take_channel(struct map_target *target, const char *value,
                         struct api_problem *problem) {
    double numbers[2];
    const char *end = read_reals(value, ',', 2, numbers);
    if (!end || *end || !(numbers[0] > 0) || !(numbers[1] > 0))
        return FAIL(problem, "edge_channel must be its width, in the drape's length unit, and its "
                             "permeability in m^2, both positive, such as 5,1e-8");
    target->channel_width = numbers[0];
    target->channel_permeability = numbers[1];
    return true;
}

/* "x,y,z" */
static bool set_reference(struct map_target *target, const char *value,
                          struct api_problem *problem) {
    double v[3];
    const char *end = read_reals(value, ',', 3, v);
    if (!end || *end)
        return FAIL(problem, "reference must be a direction, three numbers parted by commas, "
                             "such as 1,0,0");
    target->reference = vec3_make(v[0], v[1], v[2]);
    target->has_reference = true;
    double norm2 = vec3_norm2(target->reference);
    return (norm2 > 0 && isfinite(norm2)) ||
           FAIL(problem, "reference must be a direction, and not of length zero");
}

static bool take_list(struct gating *gating, const char *list, struct arena *arena) {
    const struct map_target *target = gating->target;
    struct arena_mark scratch = arena_mark(arena);
    if (target->ids)
        gating->ids = map_ids_sort(target->ids, target->element_count, arena);
    bool room = !target->ids || gating->ids;
    bool good = room && apply(gating, list);
    if (!room)
        api_problem_set(gating->problem, API_OUT_OF_MEMORY,
                        "the mesh needs more memory than allowed");
    arena_rewind(arena, scratch);
    return good;
}

static enum map_gate gate_of(const char *name) {
    return strcmp(name, "inlet") == 0 || strcmp(name, "inlet_elements") == 0 ? MAP_INLET
           : strcmp(name, "outlet") == 0                                     ? MAP_OUTLET
           : strcmp(name, "edge_channel") == 0                               ? MAP_CHANNEL
                                                                             : MAP_NO_GATE;
}

bool map_target_option(struct map_target *target, const char *name, const char *value,
                       struct arena *arena, struct api_problem *problem) {
    if (strcmp(name, "reference") == 0)
        return set_reference(target, value, problem);
    if (strcmp(name, "cavity_height") == 0)
        return cavity_take_heights(target, value, arena, problem);
    if (strcmp(name, "punch") == 0)
        return cavity_take_punch(target, value, arena, problem);
    struct gating gating = {target, NULL, gate_of(name), NULL, problem};
    if (gating.gate == MAP_NO_GATE || !begin(&gating, target, arena))
        return false;
    return gating.gate == MAP_CHANNEL ? take_channel(target, value, problem)
                                      : take_list(&gating, value, arena);
}

struct vec3 map_target_place(const struct map_target *target, size_t element) {
    return target->elements ? element_middle(target->vertices, target->elements[element])
                            : target->vertices[element];
}
