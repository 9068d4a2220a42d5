/* SPDX-License-Identifier: MIT */
#include "yarn_plies.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { NAME_SIZE = 160 };

/* The layers of a ply are its warp and its weft, or its classes of shear. */
struct layering {
    struct yarn_plies *layers;
    const struct map_plies *plies;
    enum format_plies_as as;
    double step; /* of shear from class to class, degrees */
    size_t room; /* layers of a ply at the most: 2, or the classes of 90 degrees */
};

struct map_ply_kind yarn_plies_kind(const struct map_plies *plies, int ply) {
    return plies->kinds ? plies->kinds[ply] : (struct map_ply_kind){.warp_share = 0.5};
}

static size_t class_of(const struct layering *layering, const struct map_ply_row *row) {
    return (size_t)lround(fmin(fabs(row->shear_deg), 90) / layering->step);
}

static bool is_split_as(const struct layering *layering, int ply, enum format_plies_as as) {
    return layering->as == as && yarn_plies_kind(layering->plies, ply).warp_share < 1;
}

/* How many layers a row comes to, and the first of them among those of its ply. */
static size_t layers_of(const struct layering *layering, const struct map_ply_row *row,
                        size_t *first) {
    *first = is_split_as(layering, row->ply, PLIES_AS_BISECTOR) ? class_of(layering, row) : 0;
    return is_split_as(layering, row->ply, PLIES_AS_YARNS) ? 2 : 1;
}

/* ---- what a layer is of ---- */

static struct lamina layer_lamina(const struct layering *layering, int ply, size_t layer) {
    struct map_ply_kind kind = yarn_plies_kind(layering->plies, ply);
    double a = kind.warp_share, q[LAMINA_ENTRIES] = {0};
    if (kind.lamina.e1 == 0 || layering->as == PLIES_AS_YARNS || a == 1)
        return kind.lamina;
    bool bisector = layering->as == PLIES_AS_BISECTOR;
    double from_warp = bisector ? (90 - (double)layer * layering->step) / 2 : 0;
    lamina_add(&kind.lamina, from_warp, a, q);
    lamina_add(&kind.lamina, bisector ? -from_warp : 90, 1 - a, q);
    return lamina_of(q);
}

static void name_layer(const struct layering *layering, int ply, size_t layer, char *name) {
    const char *own = layering->plies->names[ply];
    if (is_split_as(layering, ply, PLIES_AS_YARNS))
        (void)snprintf(name, NAME_SIZE, "%s, %s", own, layer == 0 ? "warp" : "weft");
    else if (is_split_as(layering, ply, PLIES_AS_BISECTOR))
        (void)snprintf(name, NAME_SIZE, "%s, sheared by %g degrees", own,
                       (double)layer * layering->step);
    else
        (void)snprintf(name, NAME_SIZE, "%s", own);
}

/* ---- which there are ---- */

/* Numbers those layers that occur, and says what they are. */
static bool number_layers(const struct layering *layering, struct api_problem *problem) {
    struct yarn_plies *layers = layering->layers;
    const struct map_plies *plies = layering->plies;
    size_t room = plies->ply_count * layering->room, count = 0, first;
    layers->number = calloc(room, sizeof *layers->number);
    for (size_t k = 0; layers->number && k < plies->row_count; k++) {
        const struct map_ply_row *row = &plies->rows[k];
        for (size_t n = layers_of(layering, row, &first); n-- > 0;)
            layers->number[(size_t)row->ply * layering->room + first + n] = 1;
    }
    for (size_t k = 0; layers->number && k < room; k++)
        layers->number[k] = layers->number[k] ? (int32_t)count++ : -1;
    layers->plies.ply_count = count;
    layers->names = calloc(count + 1, sizeof *layers->names);
    layers->lamina = calloc(count + 1, sizeof *layers->lamina);
    bool good = layers->number && layers->names && layers->lamina;
    for (size_t k = 0; good && k < room; k++) {
        int32_t number = layers->number[k];
        int ply = (int)(k / layering->room);
        if (number < 0)
            continue;
        layers->names[number] = malloc(NAME_SIZE);
        good = layers->names[number];
        if (good)
            name_layer(layering, ply, k % layering->room, layers->names[number]);
        layers->lamina[number] = layer_lamina(layering, ply, k % layering->room);
    }
    layers->plies.names = (const char *const *)layers->names;
    return good || !api_problem_no_memory(problem, "the layers of plies");
}

/* ---- rows ---- */

/* The layers of a ply at an element, from the first on the tool. */
static size_t put_layers(const struct layering *layering, const struct map_ply_row *row,
                         struct map_ply_row layer[2]) {
    size_t first, count = layers_of(layering, row, &first);
    const int32_t *number = layering->layers->number + (size_t)row->ply * layering->room + first;
    double share = yarn_plies_kind(layering->plies, row->ply).warp_share;
    layer[0] = *row;
    if (is_split_as(layering, row->ply, PLIES_AS_BISECTOR))
        layer[0].angle_deg =
            (row->angle_deg + element_weft_deg(row)) / 2 + (row->shear_deg < 0 ? 90 : 0);
    layer[0].ply = (int16_t)number[0];
    if (count == 1)
        return count;
    layer[1] = *row;
    layer[0].thickness *= share;
    layer[1].thickness *= 1 - share;
    layer[1].angle_deg = element_weft_deg(row);
    layer[1].ply = (int16_t)number[1];
    return count;
}

static bool put_rows(const struct layering *layering, const struct map_fields *fields) {
    struct yarn_plies *layers = layering->layers;
    const struct map_plies *plies = layering->plies;
    size_t count = 0;
    layers->rows = malloc((2 * plies->row_count + 1) * sizeof *layers->rows);
    layers->first = malloc((fields->element_count + 1) * sizeof *layers->first);
    if (!layers->rows || !layers->first)
        return false;
    for (size_t e = 0; e < fields->element_count; e++) {
        layers->first[e] = count;
        for (size_t k = plies->first[e]; k < plies->first[e + 1]; k++)
            count += put_layers(layering, &plies->rows[k], layers->rows + count);
    }
    layers->first[fields->element_count] = count;
    layers->plies.rows = layers->rows;
    layers->plies.row_count = count;
    layers->plies.first = layers->first;
    layers->plies.kinds = NULL;
    return true;
}

/* ---- all of it ---- */

/* The bisector needs constants, and as much of one yarn as of the other. */
static bool check_bisector(const struct map_plies *plies, const char *format,
                           struct api_problem *problem) {
    for (size_t k = 0; k < plies->ply_count; k++) {
        struct map_ply_kind kind = yarn_plies_kind(plies, (int)k);
        if (kind.warp_share == 1)
            continue;
        if (kind.lamina.e1 == 0)
            return !api_problem_set(problem, API_INVALID_REQUEST,
                                    "%s: plies_as=bisector needs fabric.lamina of every woven "
                                    "ply, which %.60s has not; plies_as=yarns needs none",
                                    format, plies->names[k]);
        if (fabs(kind.warp_share - 0.5) > 1e-9)
            return !api_problem_set(problem, API_INVALID_REQUEST,
                                    "%s: of %.60s %g is warp (fabric.balance), so it is not "
                                    "orthotropic on the bisector: choose plies_as=yarns",
                                    format, plies->names[k], kind.warp_share);
    }
    return true;
}

bool yarn_plies_make(struct yarn_plies *layers, const struct map_fields *fields,
                     enum format_plies_as as, double within, const char *format,
                     struct api_problem *problem) {
    struct layering layering = {.layers = layers,
                                .plies = fields->plies,
                                .as = as,
                                .step = fmax(within / 2, YARN_PLIES_FINEST),
                                .room = 2};
    *layers = (struct yarn_plies){.plies = *fields->plies};
    if (as == PLIES_AS_BISECTOR)
        layering.room = (size_t)lround(90 / layering.step) + 1;
    if (as == PLIES_AS_BISECTOR && !check_bisector(fields->plies, format, problem))
        return false;
    if (!number_layers(&layering, problem))
        return false;
    if (layers->plies.ply_count > MAP_PLIES_MAX)
        return !api_problem_set(problem, API_TOO_LARGE,
                                "%s: the plies have %zu layers, and the most is %d: choose a "
                                "larger within",
                                format, layers->plies.ply_count, MAP_PLIES_MAX);
    if (!put_rows(&layering, fields))
        return !api_problem_no_memory(problem, "the layers of plies");
    return true;
}

void yarn_plies_free(struct yarn_plies *layers) {
    for (size_t k = 0; layers->names && k < layers->plies.ply_count; k++)
        free(layers->names[k]);
    free(layers->names);
    free(layers->lamina);
    free(layers->rows);
    free(layers->first);
    free(layers->number);
}
