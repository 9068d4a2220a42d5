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

/* The stacks of a run have the same plies. They are points with two coordinates a layer, thickness
 * and angle, and a group is a box of them: begun with all, and halved at its widest coordinate
 * until every one is at most `within` from the middle. */
struct grouping {
    const struct map_fields *fields;
    bool angles;
    double within; /* degrees and percent, above 0 */
    struct stack_groups *groups;
    int32_t *scratch;
    bool *begins; /* a group, at this member */
};

/* Angles run from the bottom ply, and have no sign. */
static double angle_from_bottom(const struct map_fields *fields, size_t element, size_t k) {
    return element_fold_deg(stack_layer(fields, element, k)->angle_deg -
                            stack_layer(fields, element, 0)->angle_deg);
}

/* Coordinate c of a stack: of layer c / 2 the thickness, or the angle, near that of `base`. */
static double stack_coordinate(const struct grouping *grouping, size_t element, size_t c,
                               size_t base) {
    const struct map_fields *fields = grouping->fields;
    if (c % 2 == 0)
        return stack_layer(fields, element, c / 2)->thickness;
    double near = angle_from_bottom(fields, base, c / 2);
    return near + element_fold_deg(angle_from_bottom(fields, element, c / 2) - near);
}

/* Half of the box from..to along coordinate c: degrees, or percent of the middle. */
static double measure_extent(const struct grouping *grouping, size_t from, size_t to, size_t c,
                             double *middle) {
    const int32_t *member = grouping->groups->member;
    size_t base = (size_t)member[from];
    double low = INFINITY, high = -INFINITY;
    for (size_t m = from; m < to; m++) {
        double value = stack_coordinate(grouping, (size_t)member[m], c, base);
        low = fmin(low, value);
        high = fmax(high, value);
    }
    *middle = low + (high - low) / 2;
    return (high - low) / 2 * (c % 2 == 0 ? 100 / *middle : 1);
}

/* Halves the stacks from..to of one run, the members of a half in their order. */
static void halve_until_alike(struct grouping *grouping, size_t from, size_t to) {
    struct stack_groups *groups = grouping->groups;
    while (true) {
        size_t count = 2 * stack_layers(grouping->fields, (size_t)groups->member[from]), widest = 0;
        size_t base = (size_t)groups->member[from], split = from, rest = 0;
        double extent = 0, angle = 0, thickness = 0, middle = 0, at;
        for (size_t c = 0; c < count; c += grouping->angles ? 1 : 2) {
            double half = measure_extent(grouping, from, to, c, &at);
            if (half > extent) {
                extent = half;
                widest = c;
                middle = at;
            }
            *(c % 2 ? &angle : &thickness) = fmax(c % 2 ? angle : thickness, half);
        }
        if (extent <= grouping->within) {
            grouping->begins[from] = true;
            groups->angle_deg = fmax(groups->angle_deg, angle);
            groups->thickness_percent = fmax(groups->thickness_percent, thickness);
            return;
        }
        for (size_t m = from; m < to; m++) {
            size_t e = (size_t)groups->member[m];
            if (stack_coordinate(grouping, e, widest, base) <= middle)
                groups->member[split++] = (int32_t)e;
            else
                grouping->scratch[rest++] = (int32_t)e;
        }
        memcpy(groups->member + split, grouping->scratch, rest * sizeof *grouping->scratch);
        /* The smaller half by a call, so that calls nest no deeper than the logarithm of `to`. */
        bool less = split - from < to - split;
        halve_until_alike(grouping, less ? from : split, less ? split : to);
        *(less ? &from : &to) = split;
    }
}

/* By the plies from bottom to top, then by the element. */
static int compare_sequences(const void *x, const void *y, void *context) {
    const struct map_fields *fields = *(const struct map_fields *const *)context;
    int32_t a = *(const int32_t *)x, b = *(const int32_t *)y;
    size_t p = stack_layers(fields, (size_t)a), q = stack_layers(fields, (size_t)b);
    int order = (p > q) - (p < q);
    for (size_t k = 0; order == 0 && k < p; k++)
        order = stack_layer(fields, (size_t)a, k)->ply - stack_layer(fields, (size_t)b, k)->ply;
    return order;
}

/* The middles of the boxes, as stacks of their own. */
static bool take_middles(const struct grouping *grouping) {
    struct stack_groups *groups = grouping->groups;
    const struct map_fields *fields = grouping->fields;
    size_t layers = 0;
    for (size_t g = 0; g < groups->count; g++)
        layers += stack_layers(fields, (size_t)groups->member[groups->start[g]]);
    groups->layer = malloc((layers + 1) * sizeof *groups->layer);
    groups->first = malloc((groups->count + 1) * sizeof *groups->first);
    if (!groups->layer || !groups->first)
        return false;
    layers = 0;
    for (size_t g = 0; g < groups->count; g++) {
        size_t from = groups->start[g], to = groups->start[g + 1];
        size_t element = (size_t)groups->member[from], count = stack_layers(fields, element);
        groups->first[g] = layers;
        for (size_t k = 0; k < count; k++, layers++) {
            struct stack_layer *layer = &groups->layer[layers];
            layer->ply = stack_layer(fields, element, k)->ply;
            measure_extent(grouping, from, to, 2 * k, &layer->thickness);
            measure_extent(grouping, from, to, 2 * k + 1, &layer->angle_deg);
            layer->angle_deg = element_fold_deg(layer->angle_deg);
        }
    }
    groups->first[groups->count] = layers;
    return true;
}

bool stack_groups_make(struct stack_groups *groups, const struct map_fields *fields, bool angles,
                       double within) {
    size_t elements = fields->element_count, count = 0;
    *groups = (struct stack_groups){.group = malloc((elements + 1) * sizeof *groups->group),
                                    .member = malloc((elements + 1) * sizeof *groups->member),
                                    .start = malloc((elements + 1) * sizeof *groups->start)};
    struct grouping grouping = {.fields = fields,
                                .angles = angles,
                                .within = fmax(within, 1e-7),
                                .groups = groups,
                                .scratch = groups->group, /* has its values last */
                                .begins = calloc(elements + 1, sizeof *grouping.begins)};
    bool good = groups->group && groups->member && groups->start && grouping.begins;
    for (size_t e = 0; good && e < elements; e++)
        if (stack_layers(fields, e) > 0)
            groups->member[count++] = (int32_t)e;
    if (good)
        qsort_r(groups->member, count, sizeof *groups->member, compare_sequences, &fields);
    for (size_t from = 0, to; good && from < count; from = to) {
        for (to = from + 1; to < count && compare_sequences(&groups->member[from],
                                                            &groups->member[to], &fields) == 0;)
            to++;
        halve_until_alike(&grouping, from, to);
    }
    for (size_t e = 0; good && e < elements; e++)
        groups->group[e] = -1;
    for (size_t m = 0; good && m < count; m++) {
        if (grouping.begins[m])
            groups->start[groups->count++] = m;
        groups->group[groups->member[m]] = (int32_t)groups->count - 1;
    }
    if (good)
        groups->start[groups->count] = count;
    free(grouping.begins);
    return good && take_middles(&grouping);
}

void stack_groups_free(struct stack_groups *groups) {
    free(groups->group);
    free(groups->member);
    free(groups->start);
    free(groups->layer);
    free(groups->first);
}
