/* SPDX-License-Identifier: MIT */
/* What LCMsim needs to know of each element. */
#include "encoder.h"
#include "lcmsim.h"
#include <math.h>

static double value_at(const struct api_column_source *column, size_t element) {
    double value = 0;
    column->fill(column->context, element, 1, &value);
    return value;
}

static struct lcmsim_inputs read_own(const struct lcmsim_source *source, size_t element) {
    double v[LCMSIM_COLUMNS];
    for (int k = 0; k < LCMSIM_COLUMNS; k++)
        v[k] = value_at(source->column[k], element);
    struct lcmsim_inputs in = {v[0] * source->fields->unit->metres, v[1],        v[2], v[3], v[4],
                               vec3_make(v[5], v[6], v[7]),         {v[1], v[1]}};
    for (int k = 0; k < MAP_RELIEFS; k++)
        if (source->fields->relieved[k])
            in.relieved[k] = source->fields->relieved[k][element];
    return in;
}

/* Without pores, or without a flow in every direction, LCMsim's equations have no solution; beyond
 * the packing limit what they are given means nothing. */
static bool can_be_filled(const struct lcmsim_source *source, size_t element,
                          const struct lcmsim_inputs *in) {
    bool packed = source->packing && value_at(source->packing, element) > 0;
    return in->porosity > 0 && in->k1 > 0 && in->k2 > 0 && in->k3 > 0 && in->thickness > 0 &&
           !packed;
}

/* (1 - Vf)^3 / Vf^2 */
static double kozeny_carman_factor(double fraction) {
    return pow(1 - fraction, 3) / (fraction * fraction);
}

/* The inputs at the cap: those of the densest element below it, by Kozeny and Carman. */
static void take_densest(struct lcmsim_source *source) {
    double densest = -1;
    for (size_t element = 0; element < source->fields->element_count; element++) {
        struct lcmsim_inputs in = read_own(source, element);
        double fraction = 1 - in.porosity;
        if (fraction <= densest || fraction > source->cap || !can_be_filled(source, element, &in))
            continue;
        densest = fraction;
        source->capped = in;
    }
    source->has_capped = densest > 0;
    double ratio =
        source->has_capped ? kozeny_carman_factor(source->cap) / kozeny_carman_factor(densest) : 1;
    source->capped.porosity = 1 - source->cap;
    for (int k = 0; k < MAP_RELIEFS; k++)
        source->capped.relieved[k] = source->capped.porosity;
    source->capped.k1 *= ratio;
    source->capped.k2 *= ratio;
    source->capped.k3 *= ratio;
}

/* A channel has a permeability of its own, the same in every direction. */
static void take_channel(const struct lcmsim_source *source, size_t element,
                         struct lcmsim_inputs *in) {
    const struct map_fields *fields = source->fields;
    if (fields->roles && fields->roles[element] == MAP_CHANNEL)
        in->k1 = in->k2 = in->k3 = fields->channel_permeability;
}

enum lcmsim_state lcmsim_read(const struct lcmsim_source *source, size_t element,
                              struct lcmsim_inputs *in) {
    *in = read_own(source, element);
    bool fillable = can_be_filled(source, element, in);
    if (source->has_capped && (!fillable || 1 - in->porosity > source->cap)) {
        struct lcmsim_inputs own = *in;
        *in = source->capped;
        in->thickness = own.thickness;
        in->direction = own.direction;
        take_channel(source, element, in);
        return own.thickness > 0 ? LCMSIM_CAPPED : LCMSIM_LEFT_OUT;
    }
    take_channel(source, element, in);
    return fillable ? LCMSIM_AS_IT_IS : LCMSIM_LEFT_OUT;
}

double lcmsim_fraction(const struct lcmsim_source *source, size_t element) {
    return 1 - value_at(source->column[1], element);
}

bool lcmsim_open(struct lcmsim_source *source, const struct map_fields *fields, double cap,
                 struct api_problem *problem) {
    static const enum column_id ids[] = {COLUMN_CELLS_thickness, COLUMN_CELLS_porosity,
                                         COLUMN_CELLS_k1,        COLUMN_CELLS_k2,
                                         COLUMN_CELLS_k3,        COLUMN_CELLS_k1_direction};
    const char *names[LCMSIM_COLUMNS];
    struct lcmsim_inputs in;
    size_t left_out = 0;
    *source = (struct lcmsim_source){.fields = fields, .cap = cap};
    column_part_names(ids, sizeof ids / sizeof *ids, names);
    for (size_t k = 0; k < LCMSIM_COLUMNS; k++) {
        source->column[k] =
            encoder_find(fields->columns, fields->column_count, API_TABLE_CELLS, names[k]);
        if (source->column[k])
            continue;
        return !api_problem_set(
            problem, API_INVALID_REQUEST,
            "an input of a filling simulation needs a thickness, a fiber_volume_fraction and a "
            "permeability: the drape request has no %s",
            names[k]);
    }
    source->packing = encoder_find(fields->columns, fields->column_count, API_TABLE_CELLS,
                                   column_specs[COLUMN_CELLS_packing_exceeded].name);
    if (fields->element_count == 0)
        return !api_problem_set(problem, API_INVALID_REQUEST, "the mesh has no elements");
    if (fields->vertex_count > LCMSIM_NUMBER_MAX || fields->element_count > LCMSIM_NUMBER_MAX / 2)
        return !api_problem_set(
            problem, API_TOO_LARGE,
            "the mesh has more vertices or elements than a filling simulation can take");
    if (cap > 0)
        take_densest(source);
    for (size_t element = 0; element < fields->element_count; element++)
        left_out += lcmsim_read(source, element, &in) == LCMSIM_LEFT_OUT;
    if (left_out == fields->element_count)
        api_problem_set(
            problem, API_INVALID_REQUEST,
            "none of the %zu elements can be filled: the fabric is packed too densely everywhere "
            "(packing_exceeded); check the thickness of the cavity and its unit",
            fields->element_count);
    return problem->id == API_OK;
}
