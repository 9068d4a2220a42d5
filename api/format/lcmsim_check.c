/* SPDX-License-Identifier: MIT */
/* Whether a case for LCMsim can be made of fields. */
#include "encoder.h"
#include "lcmsim.h"

enum { BLOCK = 1024 };

/* The first of the columns have to be positive: without pores, or without a flow in every
 * direction, LCMsim's equations have no solution. */
enum { POSITIVE = 5 };

void lcmsim_column_names(const char *names[LCMSIM_COLUMNS]) {
    static const enum column_id ids[] = {COLUMN_CELLS_thickness, COLUMN_CELLS_porosity,
                                         COLUMN_CELLS_k1,        COLUMN_CELLS_k2,
                                         COLUMN_CELLS_k3,        COLUMN_CELLS_k1_direction};
    column_part_names(ids, sizeof ids / sizeof *ids, names);
}

static const struct api_column_source *find(const struct map_fields *fields, const char *name) {
    return encoder_find(fields->columns, fields->column_count, API_TABLE_CELLS, name);
}

static bool has_columns(const struct map_fields *fields, struct api_problem *problem) {
    const char *needed[LCMSIM_COLUMNS];
    lcmsim_column_names(needed);
    for (size_t k = 0; k < LCMSIM_COLUMNS; k++) {
        if (find(fields, needed[k]))
            continue;
        api_problem_set(problem, API_INVALID_REQUEST,
                        "lcmsim needs a thickness, a fiber_volume_fraction and a permeability "
                        "in the drape request; there is no %s",
                        needed[k]);
        return false;
    }
    return true;
}

/* How many elements have a value that is not positive. */
static size_t count_impervious(const struct map_fields *fields) {
    double values[POSITIVE][BLOCK] = {{0}};
    const char *names[LCMSIM_COLUMNS];
    size_t count = 0;
    lcmsim_column_names(names);
    for (size_t first = 0; first < fields->element_count; first += BLOCK) {
        size_t left = fields->element_count - first, rows = left < BLOCK ? left : BLOCK;
        for (int k = 0; k < POSITIVE; k++) {
            const struct api_column_source *column = find(fields, names[k]);
            column->fill(column->context, first, rows, values[k]);
        }
        for (size_t row = 0; row < rows; row++) {
            bool good = true;
            for (int k = 0; k < POSITIVE; k++)
                good = good && values[k][row] > 0;
            count += !good;
        }
    }
    return count;
}

bool lcmsim_check(const struct map_fields *fields, struct api_problem *problem) {
    if (!has_columns(fields, problem))
        return false;
    if (fields->element_count == 0) {
        api_problem_set(problem, API_INVALID_REQUEST, "lcmsim needs a mesh with elements");
        return false;
    }
    if (fields->vertex_count > LCMSIM_NUMBER_MAX || fields->element_count > LCMSIM_NUMBER_MAX / 2) {
        api_problem_set(problem, API_TOO_LARGE, "the mesh has more elements than mesh.bdf can");
        return false;
    }
    size_t impervious = count_impervious(fields);
    if (impervious > 0)
        api_problem_set(problem, API_INVALID_REQUEST,
                        "%zu of %zu elements have no pores or no permeability left, which LCMsim "
                        "cannot simulate: the fabric is packed too densely (packing_exceeded)",
                        impervious, fields->element_count);
    return impervious == 0;
}
