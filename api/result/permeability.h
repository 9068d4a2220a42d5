/* SPDX-License-Identifier: MIT */
/* The permeability of every cell, by the model of the request. */
#ifndef API_RESULT_PERMEABILITY_H
#define API_RESULT_PERMEABILITY_H

#include "api/request/request.h"
#include "solver/arena.h"
#include "solver/drape.h"
#include "solver/permeability.h"

/* Columns with a row for each cell; all NULL when the request asks for no permeability. */
struct api_permeability_columns {
    double *k1, *k2, *k3;       /* m^2 */
    double *k1_x, *k1_y, *k1_z; /* the direction of k1, a unit vector */
    double *out_of_table;       /* 1 where the shear lies outside the table; NULL: there is none */
};

/* The packing beyond which the request's model, or without one any fabric, has no meaning. */
double api_packing_limit(const struct api_permeability *permeability);

/* At one place of cloth with this shear and slide, of a fibre volume fraction, which a table over
 * shear alone does not use; `outside` (may be NULL) is whether the shear lies outside a table.
 * There is a model. */
struct permeability api_permeability_at(const struct api_permeability *model, double vf,
                                        double shear_deg, double slide, bool *outside);

/* Computes the columns in `arena`; `vf` is the fibre volume fraction of a cell by its shear in
 * degrees. STATUS_OUT_OF_MEMORY. */
enum status
api_permeability_columns(const struct api_request *request, const struct drape_cells *cells,
                         double (*vf)(const struct api_request *request, double shear_deg),
                         struct arena *arena,
                         struct api_permeability_columns *columns) STATUS_MUST_USE;

#endif
