/* SPDX-License-Identifier: MIT */
#include "cavity.h"

#include "api/json/number.h"
#include "api/request/decode.h"
#include "map_columns.h"
#include "solver/surface/boxes.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

#define FAIL(problem, ...) (api_problem_set(problem, API_INVALID_REQUEST, __VA_ARGS__), false)

/* As a share of the diagonal of the punch's box. */
static const double farthest = 0.1, nearest = 1e-4;

/* Of a triangle: what lies on an edge is not between two of them. */
static const double rounding = 1e-9;

static const double most_height = 1e12;

/* ---- the punch ---- */

struct punch {
    const struct vec3 *vertices;
    const int32_t (*elements)[4];
    struct boxes *boxes;
    double size; /* the diagonal */
};

/* A line that is being followed. */
struct ray {
    const struct punch *punch;
    struct vec3 from, direction;
    double height; /* the least so far */
};

static struct punch *punch_make(const struct map_target *target, struct arena *arena) {
    size_t count = target->punch_count;
    struct punch *punch = arena_alloc(arena, 1, sizeof *punch);
    struct box *box = arena_take(arena, count, sizeof *box);
    if (!punch || !box)
        return NULL;
    *punch = (struct punch){target->punch_vertices, target->punch, NULL, 0};
    struct box whole = {0};
    for (size_t k = 0; k < count; k++) {
        const int32_t *corners = punch->elements[k];
        const struct vec3 *v = punch->vertices;
        box[k] = box_round(v[corners[0]], v[corners[1]], 0);
        struct box rest = box_round(v[corners[2]], v[corners[corners[3] < 0 ? 2 : 3]], 0);
        box[k] = box_join(&box[k], &rest);
        whole = k ? box_join(&whole, &box[k]) : box[k];
    }
    punch->size = vec3_distance(whole.lower, whole.upper);
    return boxes_make(box, count, arena, &punch->boxes) == STATUS_OK ? punch : NULL;
}

/* Where the line p + t d meets the triangle a, b, c: t = det(ac, q) / det with q = ap x ab (T.
 * Moeller, B. Trumbore, 1997), from both sides. HUGE_VAL where it does not. */
static double meet(const struct ray *ray, struct vec3 a, struct vec3 b, struct vec3 c) {
    struct vec3 ab = vec3_sub(b, a), ac = vec3_sub(c, a), ap = vec3_sub(ray->from, a);
    struct vec3 across = vec3_cross(ray->direction, ac), q = vec3_cross(ap, ab);
    double det = vec3_dot(ab, across);
    if (!(fabs(det) > 0))
        return HUGE_VAL;
    double u = vec3_dot(ap, across) / det, v = vec3_dot(ray->direction, q) / det;
    bool within = u >= -rounding && v >= -rounding && u + v <= 1 + rounding;
    return within ? vec3_dot(ac, q) / det : HUGE_VAL;
}

/* A quad is two triangles. */
static bool look(void *context, int32_t number) {
    struct ray *ray = context;
    const struct vec3 *v = ray->punch->vertices;
    const int32_t *corner = ray->punch->elements[number];
    for (int k = 0; k < (corner[3] < 0 ? 1 : 2); k++) {
        double t = fabs(meet(ray, v[corner[0]], v[corner[1 + k]], v[corner[2 + k]]));
        ray->height = t < ray->height ? t : ray->height;
    }
    return true;
}

/* In a stretch of the line that grows: what it holds is as near as it is long. */
static double punch_height(const struct punch *punch, struct vec3 point, struct vec3 direction) {
    struct ray ray = {punch, point, direction, HUGE_VAL};
    for (double reach = nearest * punch->size; reach <= farthest * punch->size; reach *= 2) {
        struct box stretch = box_round(vec3_axpy(-reach, direction, point),
                                       vec3_axpy(reach, direction, point), nearest * reach);
        boxes_visit(punch->boxes, &stretch, look, &ray);
        if (ray.height <= reach)
            return ray.height;
    }
    return 0;
}

/* ---- the cavity ---- */

bool cavity_given(const struct map_target *target) {
    return target->heights || target->punch_count;
}

bool cavity_begin(struct cavity *cavity, const struct map_target *target, struct arena *arena) {
    *cavity = (struct cavity){.target = target};
    if (target->punch_count)
        cavity->punch = punch_make(target, arena);
    return !target->punch_count || cavity->punch;
}

double cavity_height(const struct cavity *cavity, size_t place, struct vec3 normal) {
    const struct map_target *target = cavity->target;
    if (cavity->punch)
        return punch_height(cavity->punch, map_target_point(target, place), normal);
    return target->heights ? target->heights[place] : 0;
}

void cavity_warn(const struct cavity *cavity, struct api_map *map, const char *whose) {
    const size_t count = cavity->target->element_count;
    if (cavity->packed) {
        (void)snprintf(map->packed, API_MAP_WARNING_SIZE,
                       "packing_exceeded: at %zu of %zu places a ply has more fibres than can be "
                       "packed: the cavity is too thin, or the pressure too high",
                       cavity->packed, count);
        map_warn(map, map->packed);
    }
    if (cavity->loose) {
        (void)snprintf(map->loose, API_MAP_WARNING_SIZE,
                       "at %zu of %zu places the plies by themselves are thinner than the cavity: "
                       "they would not fill it",
                       cavity->loose, count);
        map_warn(map, map->loose);
    }
    if (cavity->open) {
        (void)snprintf(map->open, API_MAP_WARNING_SIZE,
                       "the punch is not above %zu of %zu places, within a tenth of its size: they "
                       "have the %s's own cavity",
                       cavity->open, count, whose);
        map_warn(map, map->open);
    }
}

static bool no_memory(struct api_problem *problem) {
    api_problem_set(problem, API_OUT_OF_MEMORY, "the mesh needs more memory than allowed");
    return false;
}

/* Whether the thickness is the same everywhere, as between rigid faces. */
static bool may_be_rigid(const struct api_columns *columns) {
    const char *name = column_specs[COLUMN_CELLS_thickness].name;
    const struct api_column *column = api_columns_find(columns, API_TABLE_CELLS, name);
    return column && column->form == API_FORM_REPEATED;
}

/* Where the unit is what a stored surface says, the thickness of a material was read in another. */
static void take_unit(struct api_request *cloth, const struct api_columns *columns) {
    if (cloth->unit_of_surface && cloth->fabric.material)
        cloth->fabric.thickness *= cloth->length_unit->metres / columns->unit->metres;
}

bool cavity_take_cloth(struct map_target *target, const struct api_reader *reader,
                       const struct api_input *input, const struct api_limits *limits,
                       struct arena *arena, struct api_problem *problem) {
    struct api_columns *columns = arena_alloc(arena, 1, sizeof *columns);
    struct api_request *cloth = arena_alloc(arena, 1, sizeof *cloth);
    if (!columns || !cloth)
        return no_memory(problem);
    if (api_columns_open(reader, columns, problem) != API_OK)
        return false;
    if (!cavity_given(target) && !may_be_rigid(columns))
        return true;
    if (api_decode(input, limits, arena, cloth, problem) != API_OK)
        return false;
    take_unit(cloth, columns);
    if (cavity_given(target) || cloth->cavity.rigid)
        target->cloth = cloth;
    return true;
}

/* ---- options ---- */

/* "pid:N" if that stands here: where it ends, else NULL. */
static const char *read_property(const char *text, int32_t *pid) {
    int64_t number = 0;
    if (strncmp(text, "pid:", 4) != 0)
        return NULL;
    const char *at = text + 4;
    for (; *at >= '0' && *at <= '9' && number <= INT32_MAX; at++)
        number = 10 * number + (*at - '0');
    *pid = (int32_t)number;
    return at > text + 4 && number <= INT32_MAX ? at : NULL;
}

/* One of the list: where it ends, NULL when it is none. */
static const char *read_height(const char *text, bool *has_pid, int32_t *pid, double *height) {
    const char *at = read_property(text, pid);
    *has_pid = at != NULL;
    if (at && *at++ != ':')
        return NULL;
    at = at ? at : text;
    size_t taken = api_number_read(at, strlen(at), height);
    at += taken;
    bool good = taken > 0 && *height > 0 && *height <= most_height && (!*at || *at == ',');
    return good ? at : NULL;
}

bool cavity_take_heights(struct map_target *target, const char *value, struct arena *arena,
                         struct api_problem *problem) {
    size_t count = target->element_count;
    if (target->heights || target->punch)
        return FAIL(problem,
                    "cavity_height: the cavity is given by heights or by a punch, not both, "
                    "and once");
    double *heights = arena_alloc(arena, count, sizeof *heights);
    if (!heights)
        return no_memory(problem);
    for (const char *at = value;; at++) {
        int32_t pid = 0;
        double height;
        bool has_pid, found = false;
        at = read_height(at, &has_pid, &pid, &height);
        if (!at)
            return FAIL(problem, "cavity_height must be a positive height, or heights by property "
                                 "parted by commas, such as pid:3:0.002,pid:4:0.003");
        for (size_t k = 0; k < count; k++) {
            bool own = !has_pid || (target->pids && target->pids[k] == pid);
            heights[k] = own ? height : heights[k];
            found = found || own;
        }
        if (!found)
            return FAIL(problem, "cavity_height: the mesh has no element of property %d", pid);
        if (!*at)
            break;
    }
    target->heights = heights;
    return true;
}

/* Whether the list, which has been read once, names a property. */
static bool names(const char *list, int32_t pid) {
    int32_t own;
    for (const char *at = list; (at = read_property(at, &own)); at++)
        if (own == pid)
            return true;
        else if (!*at)
            break;
    return false;
}

/* The elements for which `punch` says so become the punch; the others stay, in their order. */
static bool part_elements(struct map_target *target, const char *list, struct arena *arena) {
    size_t count = target->element_count, kept = 0;
    int32_t(*elements)[4] = arena_take(arena, count, sizeof *elements);
    int32_t(*punch)[4] = arena_take(arena, count, sizeof *punch);
    int32_t *pids = arena_take(arena, count, sizeof *pids);
    int32_t *ids = arena_take(arena, count, sizeof *ids);
    if (!elements || !punch || !pids || !ids)
        return false;
    for (size_t k = 0; k < count; k++) {
        if (names(list, target->pids[k])) {
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

bool cavity_take_punch(struct map_target *target, const char *value, struct arena *arena,
                       struct api_problem *problem) {
    int32_t pid;
    const char *at = read_property(value, &pid);
    while (at && *at == ',')
        at = read_property(at + 1, &pid);
    if (!at || *at)
        return FAIL(problem, "punch must be properties of the mesh, parted by commas, such as "
                             "pid:7,pid:8; as JSON a punch is given beside the mesh");
    if (target->heights || target->punch)
        return FAIL(problem, "punch: the cavity is given by heights or by a punch, not both, and "
                             "once");
    if (!target->pids)
        return FAIL(problem, "punch: the mesh has no properties");
    if (!part_elements(target, value, arena))
        return no_memory(problem);
    if (target->punch_count == 0)
        return FAIL(problem, "punch: the mesh has no element of property %d", pid);
    return target->element_count > 0 || FAIL(problem, "punch: no element of the mesh is left");
}
