/* SPDX-License-Identifier: MIT */
/* Columns as the arrays of a VTK file: vectors and tensors as such (`fieldset.h`), the rest as
 * numbers, whole ones as integers. */
#ifndef API_FORMAT_VTK_FIELDS_H
#define API_FORMAT_VTK_FIELDS_H

#include "api/result/fieldset.h"
#include "vtk.h"

/* `kind` of the arrays that are added here; a file's own kinds follow these. */
enum vtk_fields_kind { VTK_FIELDS_DATA, VTK_FIELDS_TENSOR, VTK_FIELDS_KINDS };

struct vtk_fields {
    size_t count;
    struct {
        const struct api_column_source *column[FIELDSET_TENSOR_COLUMNS];
    } field[VTK_ARRAYS_MAX];
    double values[VTK_BLOCK / 8];
    double rows[FIELDSET_TENSOR_COLUMNS * VTK_BLOCK / (6 * 8)];
};

/* Adds an array of `components` columns under a name; false when there are too many. */
bool vtk_fields_add(struct vtk_fields *fields, struct vtk_file *file, enum vtk_section section,
                    const char *name, int components,
                    const struct api_column_source *const *columns);

/* Adds an array for every field of a list of columns of one table; the columns outlive the file. */
bool vtk_fields_add_all(struct vtk_fields *fields, struct vtk_file *file, enum vtk_section section,
                        const struct api_column_source *columns, size_t count);

/* Adds the permeability, when all that it follows from is among the columns of the cells and it is
 * not there itself. */
bool vtk_fields_add_tensor(struct vtk_fields *fields, struct vtk_file *file,
                           const struct api_column_source *columns, size_t count);

/* As `fill` of the file, for arrays added here. */
bool vtk_fields_fill(struct vtk_fields *fields, const struct vtk_array *array, uint64_t first,
                     size_t count, void *bytes);

#endif
