/* SPDX-License-Identifier: MIT */
/* Whether a case for LCMsim can be made of fields. */
#include "encoder.h"
#include "lcmsim.h"

enum { BLOCK = 1024 };

/* Without pores, or without a flow in every direction, LCMsim's equations have no solution. */
static const char *const positive[] = {"thickness", "porosity", "k1", "k2", "k3"};
enum { POSITIVE = sizeof positive / sizeof *positive };

static bool has_columns(const struct map_fields *fields, struct api_problem *problem) {
    static const char *const needed[] = {"thickness", "porosity", "k1",   "k2",
                                         "k3",        "k1_x",     "k1_y", "k1_z"};
    for (size_t k = 0; k < sizeof needed / sizeof *needed; k++) {
        if (encoder_find(fields->columns, fields->column_count, API_TABLE_CELLS, needed[k]))
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
    size_t count = 0;
    for (size_t first = 0; first < fields->element_count; first += BLOCK) {
        size_t left = fields->element_count - first, rows = left < BLOCK ? left : BLOCK;
        for (int k = 0; k < POSITIVE; k++) {
            const struct api_column_source *column =
                encoder_find(fields->columns, fields->column_count, API_TABLE_CELLS, positive[k]);
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
