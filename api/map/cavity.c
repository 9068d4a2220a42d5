/* SPDX-License-Identifier: MIT */
#include "cavity.h"

#include "api/request/decode.h"
#include "api/result/fields.h"
#include "api/result/permeability.h"
#include "map_columns.h"
#include "solver/surface/boxes.h"
#include <math.h>

/* As a share of the diagonal of the punch's box. */
static const double farthest = 0.1, nearest = 1e-4;

/* Of a triangle: what lies on an edge is not between two of them. */
static const double rounding = 1e-9;

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

/* Where the line p + t d meets the triangle a, b, c: t = det(ac, q) / det with q = ap x ab (T.
 * Moeller, B. Trumbore, 1997), from both sides. HUGE_VAL where it does not. */
static double meet_triangle(const struct ray *ray, struct vec3 a, struct vec3 b, struct vec3 c) {
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
static bool meet_element(void *context, int32_t number) {
    struct ray *ray = context;
    const struct vec3 *v = ray->punch->vertices;
    const int32_t *corner = ray->punch->elements[number];
    for (int k = 0; k < (corner[3] < 0 ? 1 : 2); k++) {
        double t = fabs(meet_triangle(ray, v[corner[0]], v[corner[1 + k]], v[corner[2 + k]]));
        ray->height = t < ray->height ? t : ray->height;
    }
    return true;
}

/* ---- the cavity ---- */

bool cavity_given(const struct map_target *target) {
    return target->heights || target->punch_count;
}

bool cavity_begin(struct cavity *cavity, const struct map_target *target, struct arena *arena) {
    size_t count = target->punch_count;
    const struct vec3 *v = target->punch_vertices;
    *cavity = (struct cavity){.target = target};
    if (!count)
        return true;
    struct punch *punch = arena_alloc(arena, 1, sizeof *punch);
    struct box *box = arena_take(arena, count, sizeof *box), whole = {0};
    if (!punch || !box)
        return false;
    *punch = (struct punch){v, target->punch, NULL, 0};
    for (size_t k = 0; k < count; k++) {
        const int32_t *corners = punch->elements[k];
        box[k] = box_round(v[corners[0]], v[corners[1]], 0);
        struct box rest = box_round(v[corners[2]], v[corners[corners[3] < 0 ? 2 : 3]], 0);
        box[k] = box_join(&box[k], &rest);
        whole = k ? box_join(&whole, &box[k]) : box[k];
    }
    punch->size = vec3_distance(whole.lower, whole.upper);
    cavity->punch = punch;
    return boxes_make(box, count, arena, &punch->boxes) == STATUS_OK;
}

/* That of a punch in a stretch of the normal that grows: what it holds is as near as it is long. */
double cavity_height(const struct cavity *cavity, size_t number, struct vec3 normal) {
    const struct map_target *target = cavity->target;
    const struct punch *punch = cavity->punch;
    if (!punch)
        return target->heights ? target->heights[number] : 0;
    struct ray ray = {punch, map_target_point(target, number), normal, HUGE_VAL};
    for (double reach = nearest * punch->size; reach <= farthest * punch->size; reach *= 2) {
        struct box stretch = box_round(vec3_axpy(-reach, normal, ray.from),
                                       vec3_axpy(reach, normal, ray.from), nearest * reach);
        boxes_visit(punch->boxes, &stretch, meet_element, &ray);
        if (ray.height <= reach)
            return ray.height;
    }
    return 0;
}

void cavity_warn(const struct cavity *cavity, struct api_map *map, const char *whose) {
    const size_t count = cavity->target->element_count;
    if (cavity->packed)
        map_warn(map,
                 "packing_exceeded: at %zu of %zu points a ply has more fibres than can be packed: "
                 "the cavity is too thin, or the pressure too high",
                 cavity->packed, count);
    if (cavity->loose)
        map_warn(map,
                 "at %zu of %zu points the plies are thinner than the cavity and would not fill it",
                 cavity->loose, count);
    if (cavity->open)
        map_warn(map,
                 "the punch is not above %zu of %zu points, within a tenth of its size: the %s's "
                 "own cavity is used there",
                 cavity->open, count, whose);
}

bool cavity_take_cloth(struct map_target *target, const struct api_reader *reader,
                       const struct api_input *input, const struct api_limits *limits,
                       struct arena *arena, struct api_problem *problem) {
    struct api_columns *columns = arena_alloc(arena, 1, sizeof *columns);
    struct api_request *cloth = arena_alloc(arena, 1, sizeof *cloth);
    if (!columns || !cloth)
        return map_target_no_memory(problem);
    if (api_columns_open(reader, columns, problem) != API_OK)
        return false;
    /* Between rigid faces the thickness is the same everywhere. */
    const struct api_column *thickness =
        api_columns_find(columns, API_TABLE_CELLS, column_specs[COLUMN_CELLS_thickness].name);
    bool may_be_rigid = thickness && thickness->form == API_FORM_REPEATED;
    if (!cavity_given(target) && !may_be_rigid && !target->wants_yarns)
        return true;
    if (api_decode(input, limits, arena, cloth, problem) != API_OK)
        return false;
    /* Where the unit is what a stored surface says, the thickness of a material was read in
     * another.
     */
    if (cloth->unit_of_surface && cloth->fabric.material)
        cloth->fabric.thickness *= cloth->length_unit->metres / columns->unit->metres;
    if (cavity_given(target) || cloth->cavity.rigid)
        target->cloth = cloth;
    struct map_ply_kind *kind = arena_alloc(arena, 1, sizeof *kind);
    if (!kind)
        return map_target_no_memory(problem);
    *kind = map_ply_kind_of(cloth);
    target->yarns = kind;
    return true;
}

/* ---- cloth in it ---- */

double press_thickness(const struct api_request *cloth, double shear_deg) {
    struct api_request flexible = *cloth;
    double thickness = 0;
    flexible.cavity.rigid = false;
    (void)api_fields_derive(COLUMN_CELLS_thickness, &flexible, shear_deg, &thickness);
    return thickness;
}

/* Whether the cloth is locked, and how severe its shear is, is not the cavity's matter. */
bool press_row(const struct map_net *net, const struct api_request *cloth, double height,
               double shear_deg, double *row) {
    struct api_request pressed = *cloth;
    struct permeability k = {0};
    bool outside = false;
    double packed = 0;
    pressed.cavity = (struct api_cavity){.rigid = true, .height = height};
    if (cloth->permeability.model != API_PERMEABILITY_NONE)
        k = api_permeability_at(&cloth->permeability,
                                api_fields_fiber_volume_fraction(&pressed, shear_deg), shear_deg,
                                cloth->settings.slide, &outside);
    for (size_t g = 0; g < net->group_count; g++) {
        const struct map_group *group = &net->group[g];
        double *own = row + group->offset;
        if (!group->spec)
            continue;
        const enum column_id id = (enum column_id)(group->spec - column_specs);
        if (group->kind == MAP_TENSOR)
            map_tensor_values(k.k1, k.k2, k.k3, k.along, k.across, own);
        else if (id == COLUMN_CELLS_out_of_table)
            *own = outside;
        else if (id != COLUMN_CELLS_locked && id != COLUMN_CELLS_severity)
            (void)api_fields_derive(id, &pressed, shear_deg, own);
        packed = id == COLUMN_CELLS_packing_exceeded ? *own : packed;
    }
    return packed > 0;
}
