/* SPDX-License-Identifier: MIT */
/*
 * A VTK XML file (version 1.0, little-endian, 64-bit headers) with its arrays appended raw, written
 * piece by piece: the description of all arrays, then each as its length in bytes (8 bytes) and its
 * values. Its whole length is known from the start.
 *
 * Columns become arrays of the file: vectors and tensors as such (`api/result/fieldset.h`), the
 * rest as numbers, whole ones as integers. Other arrays are filled by the format.
 */
#ifndef API_FORMAT_VTK_H
#define API_FORMAT_VTK_H

#include "api/result/fieldset.h"
#include "encoder.h"

enum {
    VTK_ARRAYS_MAX = 400,
    VTK_NAME_SIZE = 64,
    VTK_BLOCK = 32768,        /* bytes of values that one piece has at most */
    VTK_PIECE = VTK_BLOCK * 2 /* room that a piece needs, the description too */
};

enum vtk_type { VTK_FLOAT64, VTK_INT64, VTK_INT32, VTK_UINT8 };

/* What an array is for, in the order in which they have to be added. */
enum vtk_section { VTK_POINT_DATA, VTK_CELL_DATA, VTK_POINTS, VTK_TOPOLOGY, VTK_SECTIONS };

/* `kind` of the arrays that columns become, and those of a ply; a format's own kinds follow these.
 */
enum { VTK_COLUMNS, VTK_TENSOR, VTK_PLY, VTK_OWN_KINDS };

struct vtk_array {
    enum vtk_section section;
    enum vtk_type type;
    int components;
    bool flat;     /* described as one component: a list that happens to come in rows */
    uint64_t rows; /* of `components` values each */
    char name[VTK_NAME_SIZE];
    int kind, source; /* source: of plies' arrays and for `fill` */
    const struct api_column_source *column[FIELDSET_TENSOR_COLUMNS]; /* of the first two kinds */
};

/* The state of a format of such files begins with this. */
struct vtk_file {
    bool polydata;        /* else an unstructured grid */
    const char *revision; /* of a laminate, for a comment; NULL: none */
    uint64_t points, cells;
    size_t count;
    struct vtk_array array[VTK_ARRAYS_MAX];
    /* Puts the values of the rows first .. first + count - 1 of an array of an own kind into
     * `bytes` (VTK_BLOCK bytes of room, aligned for any of the types); false when they cannot be
     * read. */
    bool (*fill)(struct encoder *encoder, const struct vtk_array *array, uint64_t first,
                 size_t count, void *bytes);
    /* Where the file is; zero at the start. */
    size_t at;
    uint64_t row;
    double rows[FIELDSET_TENSOR_COLUMNS * VTK_BLOCK / (6 * 8)];
};

/* Appends an array; false when there are too many. The name needs no escaping. */
bool vtk_add(struct vtk_file *file, const struct vtk_array *array);

/* Adds an array of `components` columns under a name. */
bool vtk_add_columns(struct vtk_file *file, enum vtk_section section, const char *name,
                     int components, const struct api_column_source *const *columns);

/* Adds an array for every field of a list of columns of one table, those of plies left out; the
 * columns outlive the file. */
bool vtk_add_fields(struct vtk_file *file, enum vtk_section section,
                    const struct api_column_source *columns, size_t count);

/* Adds the permeability, when all that it follows from is among the columns of the cells and it is
 * not there itself. */
bool vtk_add_tensor(struct vtk_file *file, const struct api_column_source *columns, size_t count);

/* Adds all fields of a map's elements: the columns, the permeability, and those of the plies by
 * ply, angle_1, shear_1, thickness_1, ..., NaN where the ply is not. False when they are too many.
 */
bool vtk_add_elements(struct vtk_file *file, const struct map_fields *fields);

/* Puts the values of rows of an array into `bytes`, VTK_BLOCK of room aligned for any type; false
 * when they cannot be read. `count` rows have room there. */
bool vtk_fill(struct encoder *encoder, const struct vtk_array *array, uint64_t first, size_t count,
              void *bytes);

/* Sets the length of the encoder's document, once all arrays are added. */
void vtk_begin(struct encoder *encoder);

/* `next` of such a format. */
void vtk_next(struct encoder *encoder);

#endif
