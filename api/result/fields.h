/* SPDX-License-Identifier: MIT */
/*
 * The columns of a result: what the solver computed, and the local inputs of a mould-filling code
 * that follow from the shear angle gamma of each cell (mass conservation). With the areal weight of
 * the fabric A = A0 (cos gamma)^(c - 1), c being its slide:
 *
 *   flexible cavity:        thickness = n t0 A / A0,  Vf = Vf0
 *   rigid cavity, height h: thickness = h,            Vf = Vf0 (n t0 / h) A / A0
 *
 * for n plies of thickness t0. The permeability is that of `permeability.h`. Fields whose
 * inputs the request did not give are left out. docs/fields.md says what each means.
 */
#ifndef API_RESULT_FIELDS_H
#define API_RESULT_FIELDS_H

#include "api/request/request.h"
#include "columns.h"
#include "permeability.h"
#include "solver/drape.h"
#include <stddef.h>

/* The columns of one result; both must outlive it. Not to be moved once listed. */
struct api_fields {
    const struct api_request *request;
    const struct drape_result *result;
    struct api_permeability_columns permeability[2]; /* of the cells, and of those that are cut */
    struct api_derived_column {
        const struct api_fields *fields;
        const struct drape_cells *cells;
        enum column_id id;
    } derived[2][COLUMN_COUNT];
    size_t count;
    struct api_column_source source[API_COLUMNS_MAX];
};

/* Lists the columns in the order of `column_list.h`; those of the permeability are computed now, in
 * `arena`. STATUS_OUT_OF_MEMORY. */
enum status api_fields_list(struct api_fields *fields, const struct api_request *request,
                            const struct drape_result *result, struct arena *arena) STATUS_MUST_USE;

/* The fibre volume fraction of cloth of this shear. */
double api_fields_fiber_volume_fraction(const struct api_request *request, double shear_deg);

/* What a column has at cloth of this shear; false for one that does not follow from the shear. */
bool api_fields_derive(enum column_id id, const struct api_request *request, double shear_deg,
                       double *value);

/* The columns of the table `cut` with the corners of its cells, as in `struct drape_cut`. */
extern const char *const api_fields_corners[12];

/* Fills a column, whose context are its values. */
bool api_fields_copy(const void *context, size_t first, size_t count, double *values);

/* `count` columns of one table, `first` and those that follow it, of so many rows: `values` gets
 * room in the arena for those of each, which the caller sets. False without memory. */
bool api_fields_columns(enum column_id first, int count, size_t rows, struct arena *arena,
                        double **values, struct api_column_source *sources);

/* Of such columns what a stored result has in a row. False where it lacks one of them. */
bool api_fields_read_row(const struct api_reader *result, const struct api_columns *columns,
                         enum column_id first, int count, size_t row, double *values);

/* How many cells have a derived flag: are beyond the locking angle, or the packing limit; -1 where
 * the request does not say. */
double api_fields_count(enum column_id flag, const struct api_request *request,
                        const struct drape_cells *cells);

/* The most that they have of such a column; -1 likewise, and without cells. */
double api_fields_most(enum column_id id, const struct api_request *request,
                       const struct drape_cells *cells);

/* How far the thickness may be wrong at the most, by the errors of the nodes' shear; in the unit of
 * the request. Negative where these are not estimated, or without a thickness. */
double api_fields_thickness_error(const struct api_request *request,
                                  const struct drape_nodes *nodes);

#endif
