/* SPDX-License-Identifier: MIT */
/* What parameters add to a target, because the mesh's file cannot say it: inlet, outlet and
 * channel, the cavity, and the direction that angles run from. */
#include "target.h"

#include "api/json/number.h"
#include "api/json/text.h"
#include "channel.h"
#include "ids.h"
#include <math.h>
#include <string.h>
#include <strings.h>

/* ---- lists ---- */

/* A list of elements that is being read. */
struct listing {
    struct map_target *target;
    const char *option;
    const struct map_id *ids; /* sorted; NULL: elements are counted from 0 */
    uint8_t *member;          /* of each element, whether the last entry names it */
    struct arena *arena;
    struct api_problem *problem;
};

static bool begin_listing(struct listing *listing) {
    const struct map_target *target = listing->target;
    listing->member = arena_take(listing->arena, target->element_count, 1);
    if (target->ids)
        listing->ids = map_ids_sort(target->ids, target->element_count, listing->arena);
    return (listing->member && (listing->ids || !target->ids)) ||
           map_target_no_memory(listing->problem);
}

/* A whole number without a sign; where it ends, or NULL. */
static const char *read_whole(const char *text, int32_t *value) {
    int64_t number = 0;
    const char *at = text;
    for (; *at >= '0' && *at <= '9' && number <= INT32_MAX; at++)
        number = 10 * number + (*at - '0');
    *value = (int32_t)number;
    return at > text && number <= INT32_MAX ? at : NULL;
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

/* The number of the set of a name, in any case; 0, refused, when there is none. */
static size_t find_named(const struct listing *listing, const char *name, int length) {
    const struct map_target *target = listing->target;
    struct api_text names = api_text_growing(listing->arena);
    for (size_t k = 0; k < target->set_count; k++) {
        const char *known = target->sets[k].name;
        if (strlen(known) == (size_t)length && strncasecmp(known, name, (size_t)length) == 0)
            return k + 1;
        api_text_format(&names, "%s%s", k ? ", " : "", known);
    }
    const char *all = api_text_finish(&names);
    api_problem_set(listing->problem, API_INVALID_REQUEST,
                    "%s: the mesh has no set %.*s; its sets are: %.200s", listing->option,
                    length < 64 ? length : 64, name, all && *all ? all : "none");
    return 0;
}

/* The elements of a set beside those of its property. */
static void add_ranges(const struct listing *listing, int32_t set) {
    const struct map_target *target = listing->target;
    size_t count = listing->ids ? target->element_count : 0;
    for (size_t r = 0; r < target->range_count; r++) {
        const struct map_range *range = &target->ranges[r];
        for (size_t k = range->set == set ? map_ids_from(listing->ids, count, range->first) : count;
             k < count && listing->ids[k].id <= range->last; k++)
            if ((listing->ids[k].id - range->first) % range->step == 0)
                listing->member[listing->ids[k].index] = 1;
    }
}

/* Finds the members of a part of the mesh, "pid:N" or "set:NAME", of which there are some. Where
 * the entry ends; NULL with the problem set, or without one when it is neither. */
static const char *read_part(const struct listing *listing, const char *text) {
    const struct map_target *target = listing->target;
    bool named = strncmp(text, "set:", 4) == 0, any = false;
    int length = (int)strcspn(text, ",");
    int32_t pid = 0;
    size_t set = 0;
    const char *end = NULL;
    if (named) {
        end = text + 4 + strcspn(text + 4, ":,");
        set = find_named(listing, text + 4, (int)(end - text) - 4);
        if (!set)
            return NULL;
        pid = target->sets[set - 1].property;
    } else if (strncmp(text, "pid:", 4) == 0) {
        end = read_whole(text + 4, &pid);
    }
    if (!end)
        return NULL;
    for (size_t k = 0; k < target->element_count; k++)
        listing->member[k] = target->pids && target->pids[k] == pid;
    if (named)
        add_ranges(listing, (int32_t)set);
    for (size_t k = 0; k < target->element_count; k++)
        any = any || listing->member[k];
    if (any)
        return end;
    api_problem_set(
        listing->problem, API_INVALID_REQUEST,
        named ? "%s: %.*s has no shell element" : "%s: the mesh has no element of property %.*s",
        listing->option, named ? length : (int)(end - text) - 4, named ? text : text + 4);
    return NULL;
}

/* ---- inlet and outlet ---- */

/* Finds the members of a region, "sphere:x:y:z:radius" or "line:x:y:z:x:y:z:distance" from its
 * first to its second point: those whose middle is so near. As `read_part`. */
static const char *read_region(const struct listing *listing, const char *text) {
    const struct map_target *target = listing->target;
    double v[7] = {0};
    bool sphere = strncmp(text, "sphere:", 7) == 0, any = false;
    if (!sphere && strncmp(text, "line:", 5) != 0)
        return NULL;
    const char *end = read_reals(strchr(text, ':') + 1, ':', sphere ? 4 : 7, v);
    double distance = end ? v[sphere ? 3 : 6] : 0;
    struct vec3 from = vec3_make(v[0], v[1], v[2]);
    struct vec3 to = sphere ? from : vec3_make(v[3], v[4], v[5]);
    if (!(distance > 0))
        return NULL;
    for (size_t k = 0; k < target->element_count; k++) {
        bool near = !(map_segment_distance(from, to, map_target_point(target, k)) > distance);
        listing->member[k] = near;
        any = any || near;
    }
    if (any)
        return end;
    api_problem_set(listing->problem, API_INVALID_REQUEST,
                    "%s: no element has its middle within %g of that point or line; check that the "
                    "numbers are in the drape's length unit",
                    listing->option, distance);
    return NULL;
}

/* The index of the element of that number. As `read_part`. */
static const char *read_one(const struct listing *listing, const char *text, size_t *element) {
    const struct map_target *target = listing->target;
    int32_t number;
    const char *end = read_whole(text, &number);
    if (!end || (*end != '\0' && *end != ','))
        return NULL;
    int32_t index = listing->ids ? map_ids_find(listing->ids, target->element_count, number)
                    : (size_t)number < target->element_count ? number
                                                             : -1;
    if (index < 0)
        api_problem_set(listing->problem, API_INVALID_REQUEST, "%s: the mesh has no element %d",
                        listing->option, number);
    *element = (size_t)index;
    return index >= 0 ? end : NULL;
}

static bool mark_element(const struct listing *listing, enum map_role role, size_t element) {
    const struct map_target *target = listing->target;
    uint8_t *own = &target->roles[element];
    if (*own != MAP_FABRIC && *own != role)
        return MAP_REFUSE(listing->problem, "%s: element %d is both in the inlet and in the outlet",
                          listing->option, target->ids ? target->ids[element] : (int)element);
    *own = (uint8_t)role;
    return true;
}

/* Marks what one entry of a list names. Where it ends, NULL with the problem set. */
static const char *mark_entry(const struct listing *listing, enum map_role role, const char *text) {
    struct api_problem *problem = listing->problem;
    size_t element;
    const char *end = read_one(listing, text, &element);
    if (end)
        return mark_element(listing, role, element) ? end : NULL;
    end = problem->id == API_OK ? read_part(listing, text) : NULL;
    end = end || problem->id != API_OK ? end : read_region(listing, text);
    if (problem->id == API_OK && (!end || (*end != '\0' && *end != ',')))
        (void)MAP_REFUSE(
            problem,
            "%s must list elements, properties, sets or regions, separated by commas, "
            "such as 17,18,pid:3,set:NAME,sphere:x:y:z:radius,line:x:y:z:x:y:z:distance",
            listing->option);
    bool good = problem->id == API_OK;
    for (size_t k = 0; good && k < listing->target->element_count; k++)
        good = !listing->member[k] || mark_element(listing, role, k);
    return good ? end : NULL;
}

/* Inlet, outlet or channel, each once. */
static bool set_role(struct map_target *target, enum map_role role, const char *value,
                     struct arena *arena, struct api_problem *problem) {
    static const char *const options[] = {[MAP_FABRIC] = "",
                                          [MAP_INLET] = "inlet",
                                          [MAP_OUTLET] = "outlet",
                                          [MAP_CHANNEL] = "edge_channel"};
    struct listing listing = {target, options[role], NULL, NULL, arena, problem};
    double numbers[2];
    if (!target->elements)
        return MAP_REFUSE(problem, "%s needs a mesh", listing.option);
    if (target->has_role[role])
        return MAP_REFUSE(problem, "%s is given twice", listing.option);
    target->has_role[role] = true;
    if (!target->roles)
        target->roles = arena_alloc(arena, target->element_count, 1);
    if (!target->roles)
        return map_target_no_memory(problem);
    if (role != MAP_CHANNEL) {
        struct arena_mark scratch = arena_mark(arena);
        const char *at = begin_listing(&listing) ? mark_entry(&listing, role, value) : NULL;
        while (at && *at)
            at = mark_entry(&listing, role, at + 1);
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

/* "H", or a list "pid:3:0.002,set:NAME:0.003,0.0025" by the mesh's parts, in which what stands
 * later holds. */
static bool set_heights(struct map_target *target, const char *value, struct arena *arena,
                        struct api_problem *problem) {
    struct listing listing = {target, "cavity_height", NULL, NULL, arena, problem};
    size_t count = target->element_count;
    if (target->heights || target->punch)
        return MAP_REFUSE(
            problem, "cavity_height: give the cavity once, by heights or by a punch, not both");
    double *heights = arena_alloc(arena, count, sizeof *heights);
    if (!heights || !begin_listing(&listing))
        return map_target_no_memory(problem);
    for (const char *at = value;; at++) {
        double height;
        const char *part = read_part(&listing, at);
        if (problem->id != API_OK)
            return false;
        bool good = !part || *part == ':';
        at = part ? part + good : at;
        size_t taken = good ? api_number_read(at, strlen(at), &height) : 0;
        at += taken;
        if (taken == 0 || !(height > 0) || !(height <= MAP_COORDINATE_MAX) || (*at && *at != ','))
            return MAP_REFUSE(
                problem, "cavity_height must be a positive height, or heights by property or set "
                         "separated by commas, such as pid:3:0.002,set:NAME:0.003");
        for (size_t k = 0; k < count; k++)
            heights[k] = !part || listing.member[k] ? height : heights[k];
        if (!*at)
            break;
    }
    target->heights = heights;
    return true;
}

/* Takes the elements that are named out of the mesh, as its punch; the others keep their order. */
static bool take_punch(struct map_target *target, const uint8_t *named, struct arena *arena) {
    size_t count = target->element_count, kept = 0;
    int32_t(*elements)[4] = arena_take(arena, count, sizeof *elements);
    int32_t(*punch)[4] = arena_take(arena, count, sizeof *punch);
    int32_t *pids = arena_take(arena, count, sizeof *pids);
    int32_t *ids = arena_take(arena, count, sizeof *ids);
    if (!elements || !punch || !pids || !ids)
        return false;
    for (size_t k = 0; k < count; k++) {
        if (named[k]) {
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
    return true;
}

/* "pid:7,set:NAME": the elements of these become the punch. */
static bool set_punch(struct map_target *target, const char *value, struct arena *arena,
                      struct api_problem *problem) {
    struct listing listing = {target, "punch", NULL, NULL, arena, problem};
    if (target->heights || target->punch)
        return MAP_REFUSE(problem,
                          "punch: give the cavity once, by heights or by a punch, not both");
    if (!target->pids)
        return MAP_REFUSE(problem, "punch: the mesh has no properties");
    uint8_t *named = arena_alloc(arena, target->element_count, 1);
    if (!named || !begin_listing(&listing))
        return map_target_no_memory(problem);
    for (const char *at = value, *end;; at = end + 1) {
        end = read_part(&listing, at);
        if (problem->id != API_OK)
            return false;
        if (!end || (*end && *end != ','))
            return MAP_REFUSE(
                problem,
                "punch must list properties or sets of the mesh, separated by commas, such "
                "as pid:7,set:NAME; in a JSON body give \"punch\" beside \"mesh\"");
        for (size_t k = 0; k < target->element_count; k++)
            named[k] |= listing.member[k];
        if (!*end)
            break;
    }
    if (!take_punch(target, named, arena))
        return map_target_no_memory(problem);
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
