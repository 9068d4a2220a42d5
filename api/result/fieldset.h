/* SPDX-License-Identifier: MIT */
/*
 * Columns put together to what they mean, for formats that know vectors and tensors: NAME_x, NAME_y
 * and NAME_z are one vector (k1_x.. is called k1_direction, because k1 is a number of its own), and
 * k1, k2, k3 with their directions are one symmetric tensor,
 *
 *   K = k1 e1 e1^T + k2 e2 e2^T + k3 n n^T,  n = warp x weft / |warp x weft|,  e2 = n x e1.
 */
#ifndef API_RESULT_FIELDSET_H
#define API_RESULT_FIELDSET_H

#include "columns.h"
#include <stddef.h>

enum { FIELDSET_NAME_SIZE = API_COLUMN_NAME_SIZE + 16, FIELDSET_PARTS = 6 };

struct fieldset_field {
    char name[FIELDSET_NAME_SIZE];
    int components;                /* 1, 3, or 6 in VTK's order XX YY ZZ XY YZ XZ */
    size_t column[FIELDSET_PARTS]; /* of the list it was made from, one a component */
};

/* Makes the field that begins at the column `first` of a list of `count` names; returns how many
 * columns it takes: 6 for kxx, kyy, kzz, kxy, kyz, kxz, 3 for a vector, else 1. */
size_t fieldset_make(const char *const *names, size_t count, size_t first,
                     struct fieldset_field *field);

/* The columns that a tensor follows from, in this order. */
enum { FIELDSET_TENSOR_COLUMNS = 12 };
extern const char *const fieldset_tensor_columns[FIELDSET_TENSOR_COLUMNS];

/* One tensor of those columns' values. */
void fieldset_tensor(const double values[FIELDSET_TENSOR_COLUMNS], double tensor[6]);

#endif
