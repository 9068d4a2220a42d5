/* SPDX-License-Identifier: MIT */
/*
 * Columns put together to what they are, for formats that know vectors and tensors (`column_list.h`
 * says which those are); and the tensor that follows from k1, k2, k3 with their directions,
 *
 *   K = k1 e1 e1^T + k2 e2 e2^T + k3 n n^T,  n = warp x weft / |warp x weft|,  e2 = n x e1.
 */
#ifndef API_RESULT_FIELDSET_H
#define API_RESULT_FIELDSET_H

#include "columns.h"
#include <stddef.h>

struct fieldset_field {
    const char *name; /* lives as long as the columns' names */
    int components;   /* 1, 3, or 6 in VTK's order XX YY ZZ XY YZ XZ: as many columns */
};

/* The field that begins at the first of `count` columns: a vector or tensor when all its components
 * follow each other, else that column alone. */
struct fieldset_field fieldset_first(const struct api_column_source *columns, size_t count);

/* The columns that a tensor follows from: k1, k2, k3, the direction of k1, warp and weft. */
enum { FIELDSET_TENSOR_COLUMNS = 12 };
void fieldset_tensor_names(const char *names[FIELDSET_TENSOR_COLUMNS]);

/* One tensor of those columns' values. */
void fieldset_tensor(const double values[FIELDSET_TENSOR_COLUMNS], double tensor[6]);

#endif
