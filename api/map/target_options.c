/* SPDX-License-Identifier: MIT */
/* What parameters add to a target, because the mesh's file cannot say it: inlet, outlet and
 * channel, and the direction that angles run from. */
#include "target.h"

#include "api/json/number.h"
#include "cavity.h"
#include "channel.h"
#include "ids.h"
#include <math.h>
#include <string.h>

static const char *const role_names[] = {
    [MAP_FABRIC] = "",
    [MAP_INLET] = "inlet",
    [MAP_OUTLET] = "outlet",
    [MAP_CHANNEL] = "edge_channel",
};

#define FAIL(problem, ...) (api_problem_set(problem, API_INVALID_REQUEST, __VA_ARGS__), false)

/* A list that is being applied. */
struct marking {
    const struct map_target *target;
    const struct map_id *ids; /* sorted; NULL: elements are counted from 0 */
    enum map_role role;
    uint8_t *roles;
    struct api_problem *problem;
};

static bool set(const struct marking *marking, size_t element) {
    uint8_t *role = &marking->roles[element];
    if (*role != MAP_FABRIC && *role != marking->role)
        return FAIL(marking->problem, "%s: element %d is both in the inlet and in the outlet",
                    role_names[marking->role],
                    marking->target->ids ? marking->target->ids[element] : (int)element);
    *role = (uint8_t)marking->role;
    return true;
}

static bool set_element(const struct marking *marking, int32_t id) {
    const struct map_target *target = marking->target;
    int32_t element = marking->ids ? map_ids_find(marking->ids, target->element_count, id)
                      : (size_t)id < target->element_count ? id
                                                           : -1;
    if (element < 0)
        return FAIL(marking->problem, "%s: the mesh has no element %d", role_names[marking->role],
                    id);
    return set(marking, (size_t)element);
}

static bool set_property(const struct marking *marking, int32_t pid) {
    const struct map_target *target = marking->target;
    bool found = false;
    for (size_t k = 0; target->pids && k < target->element_count; k++) {
        if (target->pids[k] != pid)
            continue;
        found = true;
        if (!set(marking, k))
            return false;
    }
    return found || FAIL(marking->problem, "%s: the mesh has no element of property %d",
                         role_names[marking->role], pid);
}

/* All elements whose middle is near to the line from place[0..2] to place[3..5]. */
static bool set_near(const struct marking *marking, const double place[6], double distance) {
    struct vec3 a = vec3_make(place[0], place[1], place[2]);
    struct vec3 b = vec3_make(place[3], place[4], place[5]);
    bool found = false;
    for (size_t k = 0; k < marking->target->element_count; k++) {
        struct vec3 middle = map_target_point(marking->target, k);
        if (map_segment_distance(a, b, middle) > distance)
            continue;
        found = true;
        if (!set(marking, k))
            return false;
    }
    return found || FAIL(marking->problem,
                         "%s: no element has its middle within %g of that place; are the numbers "
                         "in the drape's length unit?",
                         role_names[marking->role], distance);
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
static const char *apply_one(const struct marking *marking, const char *text) {
    double place[6], distance;
    int32_t number;
    bool property = strncmp(text, "pid:", 4) == 0;
    const char *whole = read_number(property ? text + 4 : text, &number);
    const char *end = whole && *whole != ':' ? whole : read_place(text, place, &distance);
    bool good = end && (*end == '\0' || *end == ',');
    if (!good)
        good = FAIL(marking->problem,
                    "%s must be elements, properties and places parted by commas, such as "
                    "17,18,pid:3,sphere:x:y:z:radius,line:x:y:z:x:y:z:distance",
                    role_names[marking->role]);
    else if (end != whole)
        good = set_near(marking, place, distance);
    else
        good = (property ? set_property : set_element)(marking, number);
    return good ? end : NULL;
}

static bool apply(const struct marking *marking, const char *list) {
    const char *at = apply_one(marking, list);
    while (at && *at)
        at = apply_one(marking, at + 1);
    return at != NULL;
}

static bool begin(struct marking *marking, struct map_target *target, struct arena *arena) {
    if (!target->elements)
        return FAIL(marking->problem, "%s needs a mesh", role_names[marking->role]);
    if (target->has_role[marking->role])
        return FAIL(marking->problem, "%s is given twice", role_names[marking->role]);
    target->has_role[marking->role] = true;
    if (!target->roles)
        target->roles = arena_alloc(arena, target->element_count, 1);
    if (!target->roles)
        api_problem_set(marking->problem, API_OUT_OF_MEMORY,
                        "the mesh needs more memory than allowed");
    marking->roles = target->roles;
    return target->roles != NULL;
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

static bool take_list(struct marking *marking, const char *list, struct arena *arena) {
    const struct map_target *target = marking->target;
    struct arena_mark scratch = arena_mark(arena);
    if (target->ids)
        marking->ids = map_ids_sort(target->ids, target->element_count, arena);
    bool room = !target->ids || marking->ids;
    bool good = room && apply(marking, list);
    if (!room)
        api_problem_set(marking->problem, API_OUT_OF_MEMORY,
                        "the mesh needs more memory than allowed");
    arena_rewind(arena, scratch);
    return good;
}

static enum map_role role_of(const char *name) {
    return strcmp(name, "inlet") == 0 || strcmp(name, "inlet_elements") == 0 ? MAP_INLET
           : strcmp(name, "outlet") == 0                                     ? MAP_OUTLET
           : strcmp(name, "edge_channel") == 0                               ? MAP_CHANNEL
                                                                             : MAP_FABRIC;
}

bool map_target_option(struct map_target *target, const char *name, const char *value,
                       struct arena *arena, struct api_problem *problem) {
    if (strcmp(name, "reference") == 0)
        return set_reference(target, value, problem);
    if (strcmp(name, "cavity_height") == 0)
        return cavity_take_heights(target, value, arena, problem);
    if (strcmp(name, "punch") == 0)
        return cavity_take_punch(target, value, arena, problem);
    struct marking marking = {target, NULL, role_of(name), NULL, problem};
    if (marking.role == MAP_FABRIC || !begin(&marking, target, arena))
        return false;
    return marking.role == MAP_CHANNEL ? take_channel(target, value, problem)
                                       : take_list(&marking, value, arena);
}
