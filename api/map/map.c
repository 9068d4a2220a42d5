/* SPDX-License-Identifier: MIT */
#include "map.h"

#include "api/result/fieldset.h"
#include "cavity.h"
#include "channel.h"
#include "map_columns.h"
#include "net.h"
#include "solver/permeability.h"
#include <string.h>

enum { ASK_EVERY = 1024 }; /* points between two questions to the monitor */

/* Beside those of the cells: id, pid, role, the tensor, distance and extrapolated; and the plies'.
 */
enum { OWN_COLUMNS = 11 + MAP_PLY_COLUMNS, TENSOR_PARTS = 6 };

/* One run: the columns that are filled, by name. */
struct mapping {
    const struct map_target *target;
    const struct drape_monitor *monitor;
    struct map_net net;
    double *column[API_COLUMNS_MAX];             /* those of the cells, in their order */
    double *principal[3], *tensor[TENSOR_PARTS]; /* of k1, k2, k3; NULL without a permeability */
    double *distance, *extrapolated;
    int shear, thickness, fraction; /* their offsets in a row, or -1 */
    struct map_stack *stack;        /* NULL: onto points */
    struct cavity cavity;
    size_t far; /* points that are too far away */
    double farthest;
};

/* ---- columns ---- */

static bool make_columns(struct mapping *mapping, struct arena *arena, struct api_map *map) {
    const struct map_net *net = &mapping->net;
    bool tensor = false, good = net->column_count + OWN_COLUMNS <= API_COLUMNS_MAX;
    size_t column = 0;
    map_columns_ids(map, mapping->target);
    for (size_t k = 0; good && k < net->group_count; k++) {
        const struct map_group *group = &net->group[k];
        tensor = tensor || group->kind == MAP_TENSOR;
        if (group->spec == &column_specs[COLUMN_CELLS_shear_deg])
            mapping->shear = (int)group->offset;
        if (group->spec == &column_specs[COLUMN_CELLS_thickness])
            mapping->thickness = (int)group->offset;
        if (group->spec == &column_specs[COLUMN_CELLS_fiber_volume_fraction])
            mapping->fraction = (int)group->offset;
        for (size_t c = 0; good && c < group->columns; c++, column++) {
            const struct api_column *own = &group->column[c];
            double *values = arena_take(arena, map->fields.element_count, sizeof *values);
            mapping->column[column] = map_columns_add(map, own->name, own->integer, values);
            good = mapping->column[column] != NULL;
            if (group->kind == MAP_TENSOR && c < 3)
                mapping->principal[c] = values;
        }
    }
    for (int k = 0; good && tensor && k < TENSOR_PARTS; k++) {
        mapping->tensor[k] = map_columns_new(map, COLUMN_CELLS_permeability, k, arena);
        good = mapping->tensor[k] != NULL;
    }
    mapping->distance = good ? map_columns_new(map, COLUMN_CELLS_distance, 0, arena) : NULL;
    mapping->extrapolated = good ? map_columns_new(map, COLUMN_CELLS_extrapolated, 0, arena) : NULL;
    return mapping->distance && mapping->extrapolated;
}

/* ---- one point ---- */

static void put_row(const struct mapping *mapping, const struct facets_point *point,
                    const double *values, size_t row) {
    const struct map_net *net = &mapping->net;
    struct vec3 warp, weft;
    size_t column = 0;
    map_net_yarns(net, point, values, &warp, &weft);
    for (size_t k = 0; k < net->group_count; column += net->group[k++].columns) {
        const struct map_group *group = &net->group[k];
        const double *own = values + group->offset;
        if (group->kind == MAP_TENSOR) { /* k1, k2, k3 and the direction of k1; in global axes */
            struct permeability principal = permeability_principal(own[0], own[1], own[2], own[3]);
            struct vec3 d = permeability_direction(&principal, warp, weft);
            const double parts[FIELDSET_TENSOR_COLUMNS] = {
                principal.k1, principal.k2, principal.k3, d.x,    d.y,    d.z,
                warp.x,       warp.y,       warp.z,       weft.x, weft.y, weft.z};
            double tensor[TENSOR_PARTS];
            fieldset_tensor(parts, tensor);
            for (int i = 0; i < MAP_TENSOR_COLUMNS; i++)
                mapping->column[column + (size_t)i][row] = parts[i];
            for (int i = 0; i < TENSOR_PARTS; i++)
                mapping->tensor[i][row] = tensor[i];
        } else if (group->kind != MAP_VECTOR) {
            mapping->column[column][row] = own[0];
        } else {
            struct vec3 v = group->offset == net->warp ? warp : weft;
            mapping->column[column][row] = v.x;
            mapping->column[column + 1][row] = v.y;
            mapping->column[column + 2][row] = v.z;
        }
    }
}

/* ---- all of them ---- */

static enum api_problem_id map_points(struct mapping *mapping, struct api_problem *problem) {
    const struct map_net *net = &mapping->net;
    const struct api_request *cloth = mapping->target->cloth;
    struct vec3 warp, weft;
    size_t count = mapping->target->element_count;
    double values[API_COLUMNS_MAX];
    struct facets_search walk = facets_search_begin(net->facets);
    struct facets_point point;
    for (size_t row = 0; row < count; row++) {
        if (row % ASK_EVERY == 0 && mapping->monitor &&
            !mapping->monitor->progress(mapping->monitor->context, (double)row / (double)count))
            return api_problem_set(problem, API_CANCELLED, "the map was cancelled");
        facets_nearest(&walk, map_target_point(mapping->target, row), &point);
        map_net_interpolate(net, &point, values);
        bool beyond = map_net_is_beyond(net, &point);
        /* The fields in the cavity that the target says is there, or in the drape's own. */
        if (cloth) {
            const double shear = values[mapping->shear];
            map_net_yarns(net, &point, values, &warp, &weft);
            double height = cavity_height(&mapping->cavity, row, vec3_unit(vec3_cross(warp, weft)));
            bool own = !(height > 0);
            mapping->cavity.open += !beyond && mapping->cavity.punch && own;
            if (!own || cloth->cavity.rigid) {
                bool packed =
                    press_row(net, cloth, own ? cloth->cavity.height : height, shear, values);
                mapping->cavity.packed += !beyond && packed;
                mapping->cavity.loose += !beyond && !own && height > press_thickness(cloth, shear);
            }
        }
        put_row(mapping, &point, values, row);
        double thickness = mapping->thickness < 0 ? 0 : values[mapping->thickness];
        /* The drape is the one ply at an element, unless that lies beyond the cloth. */
        if (mapping->stack && map_stack_next(mapping->stack, row, problem) != API_OK)
            return problem->id;
        if (mapping->stack && !beyond) {
            struct map_ply ply = {.shear_deg = mapping->shear < 0 ? 0 : values[mapping->shear],
                                  .thickness = thickness,
                                  .fiber_volume_fraction =
                                      mapping->fraction < 0 ? 0 : values[mapping->fraction]};
            map_net_yarns(net, &point, values, &ply.warp, &ply.weft);
            map_stack_lay(mapping->stack, 0, &ply);
        }
        mapping->distance[row] = point.distance;
        mapping->extrapolated[row] = beyond;
        mapping->far += point.distance > net->spacing && point.distance > thickness;
        mapping->farthest = point.distance > mapping->farthest ? point.distance : mapping->farthest;
    }
    return API_OK;
}

/* What follows the points: the channel along the rim, where the target asks for one, the columns of
 * the stack and all warnings. */
static enum api_problem_id finish_map(struct mapping *mapping, const struct api_reader *reader,
                                      struct arena *arena, struct api_map *map,
                                      struct api_problem *problem) {
    const struct map_target *target = mapping->target;
    size_t count = target->element_count, bare = 0, marked = 1;
    if (target->has_role[MAP_CHANNEL] &&
        map_channel_mark(target, reader, &mapping->net.columns, arena, &marked, problem) != API_OK)
        return problem->id;
    if (marked == 0)
        map_warn(map, "edge_channel: no element has its middle that close to the rim of the cloth; "
                      "check that the width is in the drape's length unit");
    map_channel_fill(target, mapping->principal, mapping->tensor, map);
    if (mapping->stack) {
        map->fields.plies = &map->stack.plies;
        map->fields.column_count +=
            map_stack_end(mapping->stack, map->columns + map->fields.column_count);
        bare = map_stack_bare(mapping->stack);
    }
    if (target->warning)
        map_warn_text(map, target->warning);
    if (mapping->far > count / 2) /* where most lies elsewhere, that it has no ply is no news */
        map_warn(map,
                 "%zu of %zu points are further from the cloth than its spacing and thickness, up "
                 "to %.3g %s: check their length unit and their position",
                 mapping->far, count, mapping->farthest, map->fields.unit->name);
    else if (bare > 0)
        map_warn(map,
                 "%zu of %zu elements have no ply: the middle of %zu lies beyond the cloth, and "
                 "%zu have no area",
                 bare, count, bare - mapping->stack->flat, mapping->stack->flat);
    if (cavity_given(target))
        cavity_warn(&mapping->cavity, map, "drape");
    return API_OK;
}

struct map_fields map_target_fields(const struct map_target *target,
                                    const struct api_column_source *columns) {
    return (struct map_fields){.vertices = target->vertices,
                               .vertex_count = target->vertex_count,
                               .elements = target->elements,
                               .element_count = target->element_count,
                               .ids = target->ids,
                               .vertex_ids = target->vertex_ids,
                               .pids = target->pids,
                               .sets = target->sets,
                               .set_count = target->set_count,
                               .columns = columns,
                               .roles = target->roles,
                               .channel_permeability = target->channel_permeability};
}

enum api_problem_id api_map_make(const struct api_reader *reader, const struct map_target *target,
                                 const struct drape_monitor *monitor, struct arena *arena,
                                 struct api_map *map, struct api_problem *problem) {
    static const char *const names[] = {"ply_1"};
    struct mapping *mapping = arena_alloc(arena, 1, sizeof *mapping);
    memset(map, 0, sizeof *map);
    if (!mapping)
        return map_net_no_memory(problem);
    if (cavity_given(target) && !(target->cloth && target->cloth->fabric.thickness > 0))
        return api_problem_set(problem, API_INVALID_REQUEST,
                               "cavity heights need the fabric.thickness of the drape request");
    map->fields = map_target_fields(target, map->columns);
    mapping->target = target;
    mapping->monitor = monitor;
    mapping->shear = mapping->thickness = mapping->fraction = -1;
    if (map_net_open(reader, &mapping->net, problem) != API_OK)
        return problem->id;
    map->fields.unit = mapping->net.columns.unit;
    const struct api_rosette *rosette = &mapping->net.columns.start.rosette;
    map->fields.rosette = vec3_norm2(rosette->x) > 0 ? rosette : NULL;
    bool room = make_columns(mapping, arena, map);
    if (room && target->elements) { /* onto a mesh the drape is a stack of one ply */
        const struct map_plies plies = {.ply_count = 1,
                                        .side = 1,
                                        .names = names,
                                        .kinds = target->yarns,
                                        .thickness = mapping->thickness >= 0,
                                        .fraction = mapping->fraction >= 0};
        mapping->stack = &map->stack;
        room = map_stack_begin(&map->stack, target, &plies, target->element_count, arena);
    }
    if (!room || !cavity_begin(&mapping->cavity, mapping->target, arena))
        return map_net_no_memory(problem);
    struct arena_mark mark = arena_mark(arena);
    if (map_net_load(reader, monitor, arena, &mapping->net, problem) == API_OK &&
        map_points(mapping, problem) == API_OK)
        (void)!finish_map(mapping, reader, arena, map, problem);
    arena_rewind(arena, mark);
    return problem->id;
}
