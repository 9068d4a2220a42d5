/* SPDX-License-Identifier: MIT */
/* What parameters add to a target, because the mesh's file cannot say it: inlet, outlet and
 * channel, the cavity, and the direction that angles run from. */
#include "target.h"

#include "api/json/number.h"
#include "channel.h"
#include "ids.h"
#include <math.h>
#include <string.h>

/* ---- lists ---- */

/* A whole number without a sign; where it ends, or NULL. */
static const char *read_whole(const char *text, int32_t *value) {
    int64_t number = 0;
    const char *at = text;
    for (; *at >= '0' && *at <= '9' && number <= INT32_MAX; at++)
        number = 10 * number + (*at - '0');
    *value = (int32_t)number;
    return at > text && number <= INT32_MAX ? at : NULL;
}

/* "pid:N" if that stands here: where it ends, else NULL. */
static const char *read_property(const char *text, int32_t *pid) {
    return strncmp(text, "pid:", 4) == 0 ? read_whole(text + 4, pid) : NULL;
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

/* ---- inlet and outlet ---- */

/* A list that is being applied. */
struct marking {
    struct map_target *target;
    const char *option;
    const struct map_id *ids; /* sorted; NULL: elements are counted from 0 */
    enum map_role role;
    struct api_problem *problem;
};

static bool mark_element(const struct marking *marking, size_t element) {
    const struct map_target *target = marking->target;
    uint8_t *role = &target->roles[element];
    if (*role != MAP_FABRIC && *role != marking->role)
        return MAP_REFUSE(marking->problem, "%s: element %d is both in the inlet and in the outlet",
                          marking->option, target->ids ? target->ids[element] : (int)element);
    *role = (uint8_t)marking->role;
    return true;
}

/* Marks what one entry of the list names: an element, all of a property, or all whose middle lies
 * in a region. Where the entry ends, NULL with the problem set. */
static const char *mark_entry(const struct marking *marking, const char *text) {
    const struct map_target *target = marking->target;
    struct vec3 line[2];
    double distance = 0, v[7] = {0};
    int32_t number;
    bool property = strncmp(text, "pid:", 4) == 0, found = false;
    bool sphere = strncmp(text, "sphere:", 7) == 0;
    const char *whole = property ? read_property(text, &number) : read_whole(text, &number);
    const char *end = whole && *whole != ':' ? whole : NULL;
    /* "sphere:x:y:z:radius" or "line:x:y:z:x:y:z:distance", from its first to its second point. */
    if (sphere || strncmp(text, "line:", 5) == 0) {
        end = read_reals(strchr(text, ':') + 1, ':', sphere ? 4 : 7, v);
        distance = end ? v[sphere ? 3 : 6] : 0;
        line[0] = vec3_make(v[0], v[1], v[2]);
        line[1] = sphere ? line[0] : vec3_make(v[3], v[4], v[5]);
        end = distance > 0 ? end : NULL;
    }
    if (!end || (*end != '\0' && *end != ',')) {
        api_problem_set(marking->problem, API_INVALID_REQUEST,
                        "%s must list elements, properties or regions, separated by commas, such "
                        "as 17,18,pid:3,sphere:x:y:z:radius,line:x:y:z:x:y:z:distance",
                        marking->option);
        return NULL;
    }
    if (end == whole && !property) {
        int32_t element = marking->ids ? map_ids_find(marking->ids, target->element_count, number)
                          : (size_t)number < target->element_count ? number
                                                                   : -1;
        if (element < 0)
            api_problem_set(marking->problem, API_INVALID_REQUEST, "%s: the mesh has no element %d",
                            marking->option, number);
        return element >= 0 && mark_element(marking, (size_t)element) ? end : NULL;
    }
    for (size_t k = 0; k < target->element_count; k++) {
        bool own =
            end == whole
                ? target->pids && target->pids[k] == number
                : !(map_segment_distance(line[0], line[1], map_target_point(target, k)) > distance);
        found = found || own;
        if (own && !mark_element(marking, k))
            return NULL;
    }
    if (!found && end == whole)
        api_problem_set(marking->problem, API_INVALID_REQUEST,
                        "%s: the mesh has no element of property %d", marking->option, number);
    else if (!found)
        api_problem_set(marking->problem, API_INVALID_REQUEST,
                        "%s: no element has its middle within %g of that point or line; check that "
                        "the numbers are in the drape's length unit",
                        marking->option, distance);
    return found ? end : NULL;
}

/* Inlet, outlet or channel, each once. */
static bool set_role(struct map_target *target, enum map_role role, const char *value,
                     struct arena *arena, struct api_problem *problem) {
    static const char *const options[] = {[MAP_FABRIC] = "",
                                          [MAP_INLET] = "inlet",
                                          [MAP_OUTLET] = "outlet",
                                          [MAP_CHANNEL] = "edge_channel"};
    struct marking marking = {target, options[role], NULL, role, problem};
    double numbers[2];
    if (!target->elements)
        return MAP_REFUSE(problem, "%s needs a mesh", marking.option);
    if (target->has_role[role])
        return MAP_REFUSE(problem, "%s is given twice", marking.option);
    target->has_role[role] = true;
    if (!target->roles)
        target->roles = arena_alloc(arena, target->element_count, 1);
    if (!target->roles)
        return map_target_no_memory(problem);
    if (role != MAP_CHANNEL) {
        struct arena_mark scratch = arena_mark(arena);
        if (target->ids)
            marking.ids = map_ids_sort(target->ids, target->element_count, arena);
        if (target->ids && !marking.ids)
            return map_target_no_memory(problem);
        const char *at = mark_entry(&marking, value);
        while (at && *at)
            at = mark_entry(&marking, at + 1);
        arena_rewind(arena, scratch);
        return at != NULL;
    }
    const char *end = read_reals(value, ',', 2, numbers);
    if (!end || *end || !(numbers[0] > 0) || !(numbers[1] > 0))
        return MAP_REFUSE(problem,
                          "edge_channel must be two positive numbers, the width in the drape's "
                          "length unit and the permeability in m^2, such as 5,1e-8");
    target->channel_width = numbers[0];
    target->channel_permeability = numbers[1];
    return true;
}

/* ---- the cavity ---- */

/* "H", or a list "pid:3:0.002,pid:4:0.003,0.0025" by the mesh's properties, in which what stands
 * later holds. */
static bool set_heights(struct map_target *target, const char *value, struct arena *arena,
                        struct api_problem *problem) {
    size_t count = target->element_count;
    if (target->heights || target->punch)
        return MAP_REFUSE(
            problem, "cavity_height: give the cavity once, by heights or by a punch, not both");
    double *heights = arena_alloc(arena, count, sizeof *heights);
    if (!heights)
        return map_target_no_memory(problem);
    for (const char *at = value;; at++) {
        int32_t pid = 0;
        double height;
        bool found = false;
        const char *property = read_property(at, &pid);
        bool good = !property || *property == ':';
        at = property ? property + good : at;
        size_t taken = good ? api_number_read(at, strlen(at), &height) : 0;
        at += taken;
        if (taken == 0 || !(height > 0) || !(height <= MAP_COORDINATE_MAX) || (*at && *at != ','))
            return MAP_REFUSE(problem,
                              "cavity_height must be a positive height, or heights by property "
                              "separated by commas, such as pid:3:0.002,pid:4:0.003");
        for (size_t k = 0; k < count; k++) {
            bool own = !property || (target->pids && target->pids[k] == pid);
            heights[k] = own ? height : heights[k];
            found = found || own;
        }
        if (!found)
            return MAP_REFUSE(problem, "cavity_height: the mesh has no element of property %d",
                              pid);
        if (!*at)
            break;
    }
    target->heights = heights;
    return true;
}

/* "pid:7,pid:8": the elements of these properties become the punch; the others stay, in their
 * order. */
static bool set_punch(struct map_target *target, const char *value, struct arena *arena,
                      struct api_problem *problem) {
    size_t count = target->element_count, kept = 0;
    int32_t pid, own;
    const char *at = read_property(value, &pid);
    while (at && *at == ',')
        at = read_property(at + 1, &pid);
    if (!at || *at)
        return MAP_REFUSE(problem,
                          "punch must list properties of the mesh, separated by commas, such as "
                          "pid:7,pid:8; in a JSON body give \"punch\" beside \"mesh\"");
    if (target->heights || target->punch)
        return MAP_REFUSE(problem,
                          "punch: give the cavity once, by heights or by a punch, not both");
    if (!target->pids)
        return MAP_REFUSE(problem, "punch: the mesh has no properties");
    int32_t(*elements)[4] = arena_take(arena, count, sizeof *elements);
    int32_t(*punch)[4] = arena_take(arena, count, sizeof *punch);
    int32_t *pids = arena_take(arena, count, sizeof *pids);
    int32_t *ids = arena_take(arena, count, sizeof *ids);
    if (!elements || !punch || !pids || !ids)
        return map_target_no_memory(problem);
    for (size_t k = 0; k < count; k++) {
        bool named = false;
        for (at = value; !named && at; at = *at ? at + 1 : NULL) {
            at = read_property(at, &own);
            named = own == target->pids[k];
        }
        if (named) {
            memcpy(punch[target->punch_count++], target->elements[k], sizeof *punch);
            continue;
        }
        memcpy(elements[kept], target->elements[k], sizeof *elements);
        pids[kept] = target->pids[k];
        ids[kept] = target->ids ? target->ids[k] : (int32_t)k;
        if (target->roles)
            target->roles[kept] = target->roles[k];
        kept++;
    }
    target->element_count = kept;
    target->elements = (const int32_t(*)[4])elements;
    target->punch = (const int32_t(*)[4])punch;
    target->punch_vertices = target->vertices;
    target->pids = pids;
    target->ids = ids;
    if (target->punch_count == 0)
        return MAP_REFUSE(problem, "punch: the mesh has no element of property %d", pid);
    return target->element_count > 0 ||
           MAP_REFUSE(problem, "punch: the mesh has no elements besides the punch");
}

/* ---- all ---- */

bool map_target_option(struct map_target *target, const char *name, const char *value,
                       struct arena *arena, struct api_problem *problem) {
    if (strcmp(name, "reference") == 0) { /* "x,y,z" */
        double v[3];
        const char *end = read_reals(value, ',', 3, v);
        if (!end || *end)
            return MAP_REFUSE(
                problem,
                "reference must be a direction, three numbers separated by commas, such as 1,0,0");
        target->reference = vec3_make(v[0], v[1], v[2]);
        target->has_reference = true;
        double norm2 = vec3_norm2(target->reference);
        return (norm2 > 0 && isfinite(norm2)) ||
               MAP_REFUSE(problem, "reference must not have length zero");
    }
    if (strcmp(name, "cavity_height") == 0)
        return set_heights(target, value, arena, problem);
    if (strcmp(name, "punch") == 0)
        return set_punch(target, value, arena, problem);
    if (strcmp(name, "inlet") == 0 || strcmp(name, "inlet_elements") == 0)
        return set_role(target, MAP_INLET, value, arena, problem);
    if (strcmp(name, "outlet") == 0)
        return set_role(target, MAP_OUTLET, value, arena, problem);
    return strcmp(name, "edge_channel") == 0 &&
           set_role(target, MAP_CHANNEL, value, arena, problem);
}
