/* SPDX-License-Identifier: MIT */
#include "plies.h"

#include "api/request/request.h"

struct map_ply_kind map_ply_kind_of(const struct api_request *cloth) {
    double balance = cloth->fabric.balance > 0 ? cloth->fabric.balance : 0.5;
    return (struct map_ply_kind){.warp_share = cloth->settings.slide == 1 ? 1 : balance,
                                 .lamina = cloth->fabric.lamina};
}

bool map_stack_begin(struct map_stack *stack, const struct map_target *target,
                     const struct map_plies *plies, size_t room, struct arena *arena) {
    *stack = (struct map_stack){.plies = *plies, .target = target, .room = room};
    stack->rows = arena_take(arena, room, sizeof *stack->rows);
    stack->first = arena_take(arena, target->element_count + 1, sizeof *stack->first);
    stack->plies.rows = stack->rows;
    stack->plies.first = stack->first;
    stack->plies.reference = target->has_reference ? &target->reference : NULL;
    return stack->rows && stack->first;
}

enum api_problem_id map_stack_next(struct map_stack *stack, size_t element,
                                   struct api_problem *problem) {
    const struct map_target *target = stack->target;
    enum element_fault fault = element_frame_make(target->vertices, target->elements[element],
                                                  stack->plies.reference, &stack->frame);
    stack->element = element;
    stack->sound = fault == ELEMENT_SOUND;
    stack->flat += fault == ELEMENT_FLAT;
    stack->first[element] = stack->plies.row_count;
    if (fault != ELEMENT_PERPENDICULAR)
        return API_OK;
    return api_problem_set(
        problem, API_INVALID_REQUEST,
        "reference is normal to element %d, so no angle can be measured from it there: choose "
        "another direction, or none to measure from the first edge of each element",
        target->ids ? target->ids[element] : (int)element);
}

void map_stack_lay(struct map_stack *stack, int ply, const struct map_ply *laid) {
    if (!stack->sound || stack->plies.row_count == stack->room)
        return;
    struct map_ply_row *row = &stack->rows[stack->plies.row_count++];
    *row = (struct map_ply_row){.element = (int32_t)stack->element,
                                .ply = (int16_t)ply,
                                .shear_deg = laid->shear_deg,
                                .thickness = laid->thickness,
                                .fiber_volume_fraction = laid->fiber_volume_fraction};
    element_lay(&stack->frame, laid->warp, laid->weft, row);
}

/* ---- columns ---- */

static bool fill_ply_column(const void *context, size_t first, size_t count, double *values) {
    const struct map_ply_column *column = context;
    const struct map_stack *stack = column->stack;
    const int32_t *ids = stack->target->ids;
    const int(*numbers)[2] = stack->plies.numbers;
    for (size_t k = 0; k < count; k++) {
        const struct map_ply_row *row = &stack->plies.rows[first + k];
        const double own[MAP_PLY_COLUMNS] = {ids ? ids[row->element] : row->element,
                                             numbers ? numbers[row->ply][0] : row->ply + 1,
                                             numbers ? numbers[row->ply][1] : 0,
                                             row->angle_deg,
                                             row->shear_deg,
                                             row->thickness,
                                             row->fiber_volume_fraction};
        values[k] = own[column->of - COLUMN_PLIES_element];
    }
    return true;
}

size_t map_stack_end(struct map_stack *stack, struct api_column_source columns[MAP_PLY_COLUMNS]) {
    size_t count = 0;
    stack->first[stack->target->element_count] = stack->plies.row_count;
    for (int id = COLUMN_PLIES_element; id <= COLUMN_PLIES_fiber_volume_fraction; id++) {
        if ((id == COLUMN_PLIES_piece && !stack->plies.numbers) ||
            (id == COLUMN_PLIES_thickness && !stack->plies.thickness) ||
            (id == COLUMN_PLIES_fiber_volume_fraction && !stack->plies.fraction))
            continue;
        const struct column_spec *spec = &column_specs[id];
        stack->column[count] = (struct map_ply_column){stack, id};
        columns[count] = (struct api_column_source){.table = spec->table,
                                                    .name = spec->name,
                                                    .integer = column_kind_is_integer(spec->kind),
                                                    .rows = stack->plies.row_count,
                                                    .fill = fill_ply_column,
                                                    .context = &stack->column[count]};
        count++;
    }
    return count;
}

size_t map_stack_bare(const struct map_stack *stack) {
    size_t bare = 0;
    for (size_t e = 0; e < stack->target->element_count; e++)
        bare += stack->first[e + 1] == stack->first[e];
    return bare;
}
