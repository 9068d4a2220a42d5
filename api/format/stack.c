/* SPDX-License-Identifier: MIT */
#include "stack.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- one element ---- */

bool stack_is_upward(const struct map_fields *fields, size_t element) {
    const struct map_plies *plies = fields->plies;
    return plies->rows[plies->first[element]].mirrored == (plies->side < 0);
}

size_t stack_layers(const struct map_fields *fields, size_t element) {
    const size_t *first = fields->plies->first;
    return first[element + 1] - first[element];
}

const struct map_ply_row *stack_layer(const struct map_fields *fields, size_t element, size_t k) {
    size_t first = fields->plies->first[element], count = stack_layers(fields, element);
    return &fields->plies->rows[first + (stack_is_upward(fields, element) ? k : count - 1 - k)];
}

const struct map_ply_row *stack_row(const struct map_fields *fields, size_t element, int ply) {
    const struct map_plies *plies = fields->plies;
    for (size_t k = plies->first[element]; k < plies->first[element + 1]; k++)
        if (plies->rows[k].ply == ply)
            return &plies->rows[k];
    return NULL;
}

struct element_frame stack_frame(const struct map_fields *fields, size_t element) {
    struct element_frame frame;
    (void)element_frame_make(fields->vertices, fields->elements[element], fields->plies->reference,
                             &frame);
    return frame;
}

double stack_least_thickness(const struct map_fields *fields, int ply) {
    const struct map_plies *plies = fields->plies;
    double least = 0;
    for (size_t k = 0; k < plies->row_count; k++)
        if (plies->rows[k].ply == ply && (least == 0 || plies->rows[k].thickness < least))
            least = plies->rows[k].thickness;
    return least;
}

/* ---- groups of like stacks ---- */

struct grouping {
    const struct map_fields *fields;
    bool angles;
    int64_t turns; /* steps of angles in half a turn, after which a fibre is the same */
    double share;  /* a step of logarithms of thicknesses */
};

/* A layer as whole numbers, equal when it counts as the same: ply, thickness, angle. */
enum { LAYER = 3 };

static void read_layer(const struct grouping *grouping, size_t element, size_t k,
                       int64_t layer[LAYER]) {
    const struct map_ply_row *row = stack_layer(grouping->fields, element, k);
    const struct map_ply_row *first = stack_layer(grouping->fields, element, 0);
    double turn = element_fold_deg(row->angle_deg - first->angle_deg) + 90;
    int64_t step = llround(turn / 180 * (double)grouping->turns) % grouping->turns;
    layer[0] = row->ply;
    layer[1] = llround(log(row->thickness) / grouping->share);
    layer[2] = grouping->angles ? step : 0;
}

static bool stacks_are_alike(const struct grouping *grouping, size_t a, size_t b) {
    size_t count = stack_layers(grouping->fields, a);
    bool alike = count == stack_layers(grouping->fields, b);
    for (size_t k = 0; alike && k < count; k++) {
        int64_t p[LAYER], q[LAYER];
        read_layer(grouping, a, k, p);
        read_layer(grouping, b, k, q);
        alike = memcmp(p, q, sizeof p) == 0;
    }
    return alike;
}

bool stack_groups_make(struct stack_groups *groups, const struct map_fields *fields, bool angles,
                       double within) {
    double step = within > 0 ? within : 1e-6;
    const struct grouping grouping = {fields, angles, (int64_t)ceil(180 / step), step / 100};
    size_t elements = fields->element_count, size = 16;
    while (size < 2 * elements)
        size *= 2;
    int32_t *table = calloc(size, sizeof *table);
    *groups = (struct stack_groups){.group = malloc(elements * sizeof *groups->group),
                                    .member = malloc(elements * sizeof *groups->member)};
    bool good = table && groups->group && groups->member;
    /* Every element gets its group by a table of the groups' first members, open addressing. */
    for (size_t e = 0; good && e < elements; e++) {
        size_t layers = stack_layers(fields, e);
        uint64_t hash = 0;
        int64_t layer[LAYER];
        groups->group[e] = -1;
        if (layers == 0)
            continue;
        for (size_t k = 0; k < layers; k++) {
            read_layer(&grouping, e, k, layer);
            for (int v = 0; v < LAYER; v++) {
                hash = (hash ^ (uint64_t)layer[v]) * 0x9E3779B97F4A7C15u;
                hash ^= hash >> 29;
            }
        }
        size_t slot = hash & (size - 1);
        while (table[slot] && !stacks_are_alike(&grouping, e, (size_t)table[slot] - 1))
            slot = (slot + 1) & (size - 1);
        if (!table[slot]) {
            table[slot] = (int32_t)e + 1;
            groups->group[e] = (int32_t)groups->count++;
        } else {
            groups->group[e] = groups->group[table[slot] - 1];
        }
    }
    free(table);
    groups->start = good ? calloc(groups->count + 2, sizeof *groups->start) : NULL;
    if (!groups->start)
        return false;
    /* Members by group, in their order: a counting sort. */
    size_t *place = groups->start + 1; /* of the next member, until it has moved on to its end */
    for (size_t e = 0; e < elements; e++)
        if (groups->group[e] >= 0)
            place[groups->group[e] + 1]++;
    for (size_t g = 1; g <= groups->count; g++)
        place[g] += place[g - 1];
    for (size_t e = 0; e < elements; e++)
        if (groups->group[e] >= 0)
            groups->member[place[groups->group[e]]++] = (int32_t)e;
    return true;
}

void stack_groups_free(struct stack_groups *groups) {
    free(groups->group);
    free(groups->member);
    free(groups->start);
}
