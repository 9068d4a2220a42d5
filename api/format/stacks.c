/* SPDX-License-Identifier: MIT */
#include "stacks.h"

#include <math.h>
#include <stdlib.h>

struct grouping {
    const struct map_fields *fields;
    bool angles;
    int64_t turns; /* steps of angles in half a turn, after which a fibre is the same */
    double share;  /* a step of logarithms of thicknesses */
};

/* A layer as whole numbers, equal when it counts as the same. */
struct layer {
    int64_t ply, thickness, angle;
};

static struct layer layer_of(const struct grouping *grouping, size_t element, size_t k) {
    const struct map_ply_row *row = cards_layer(grouping->fields, element, k);
    const struct map_ply_row *first = cards_layer(grouping->fields, element, 0);
    double turn = cards_fold_deg(row->angle_deg - first->angle_deg) + 90;
    int64_t step = llround(turn / 180 * (double)grouping->turns) % grouping->turns;
    return (struct layer){row->ply, llround(log(row->thickness) / grouping->share),
                          grouping->angles ? step : 0};
}

static uint64_t mix(uint64_t hash, int64_t value) {
    hash = (hash ^ (uint64_t)value) * 0x9E3779B97F4A7C15u;
    return hash ^ hash >> 29;
}

static uint64_t hash_of(const struct grouping *grouping, size_t element) {
    uint64_t hash = 0;
    for (size_t k = 0; k < cards_layers(grouping->fields, element); k++) {
        struct layer layer = layer_of(grouping, element, k);
        hash = mix(mix(mix(hash, layer.ply), layer.thickness), layer.angle);
    }
    return hash;
}

static bool are_alike(const struct grouping *grouping, size_t a, size_t b) {
    size_t count = cards_layers(grouping->fields, a);
    bool alike = count == cards_layers(grouping->fields, b);
    for (size_t k = 0; alike && k < count; k++) {
        struct layer p = layer_of(grouping, a, k), q = layer_of(grouping, b, k);
        alike = p.ply == q.ply && p.thickness == q.thickness && p.angle == q.angle;
    }
    return alike;
}

/* Gives every element its group by a table of the groups' first members, open addressing. */
static void find_groups(struct stacks *stacks, const struct grouping *grouping, int32_t *table,
                        size_t size) {
    for (size_t e = 0; e < grouping->fields->element_count; e++) {
        stacks->group[e] = -1;
        if (cards_is_bare(grouping->fields, e))
            continue;
        size_t slot = hash_of(grouping, e) & (size - 1);
        while (table[slot] && !are_alike(grouping, e, (size_t)table[slot] - 1))
            slot = (slot + 1) & (size - 1);
        if (!table[slot]) {
            table[slot] = (int32_t)e + 1;
            stacks->group[e] = (int32_t)stacks->count++;
        } else {
            stacks->group[e] = stacks->group[table[slot] - 1];
        }
    }
}

/* Members by group, in their order: a counting sort. */
static bool list_members(struct stacks *stacks, size_t elements) {
    stacks->start = calloc(stacks->count + 2, sizeof *stacks->start);
    if (!stacks->start)
        return false;
    size_t *place = stacks->start + 1; /* of the next member, until it has moved on to its end */
    for (size_t e = 0; e < elements; e++)
        if (stacks->group[e] >= 0)
            place[stacks->group[e] + 1]++;
    for (size_t g = 1; g <= stacks->count; g++)
        place[g] += place[g - 1];
    for (size_t e = 0; e < elements; e++)
        if (stacks->group[e] >= 0)
            stacks->member[place[stacks->group[e]]++] = (int32_t)e;
    return true;
}

bool stacks_make(struct stacks *stacks, const struct map_fields *fields, bool angles,
                 double within) {
    double step = within > 0 ? within : 1e-6;
    const struct grouping grouping = {fields, angles, (int64_t)ceil(180 / step), step / 100};
    size_t elements = fields->element_count, size = 16;
    while (size < 2 * elements)
        size *= 2;
    int32_t *table = calloc(size, sizeof *table);
    *stacks = (struct stacks){.group = malloc(elements * sizeof *stacks->group),
                              .member = malloc(elements * sizeof *stacks->member)};
    bool good = table && stacks->group && stacks->member;
    if (good)
        find_groups(stacks, &grouping, table, size);
    good = good && list_members(stacks, elements);
    free(table);
    return good;
}

void stacks_free(struct stacks *stacks) {
    free(stacks->group);
    free(stacks->member);
    free(stacks->start);
}

/* ---- of a deck ---- */

bool stacks_begin(struct encoder *encoder, bool angles, struct api_problem *problem) {
    if (!cards_check(encoder, INT32_MAX, problem))
        return false;
    if (!stacks_make(encoder->state, &encoder->fields, angles, encoder->options.within))
        api_problem_set(problem, API_OUT_OF_MEMORY, "no memory to group the elements");
    return problem->id == API_OK;
}

size_t stacks_groups(const struct encoder *encoder) {
    return ((const struct stacks *)encoder->state)->count;
}

void stacks_end(struct encoder *encoder) {
    stacks_free(encoder->state);
}
