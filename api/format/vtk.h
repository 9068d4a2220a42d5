/* SPDX-License-Identifier: MIT */
/*
 * A VTK XML file (version 1.0, little-endian, 64-bit headers) with its arrays appended raw, written
 * piece by piece: the description of all arrays, then each as its length in bytes (8 bytes) and its
 * values. Its whole length is known from the start.
 */
#ifndef API_FORMAT_VTK_H
#define API_FORMAT_VTK_H

#include "api/json/text.h"
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    VTK_ARRAYS_MAX = 400,
    VTK_NAME_SIZE = 64,
    VTK_BLOCK = 32768,        /* bytes of values that one piece has at most */
    VTK_PIECE = VTK_BLOCK * 2 /* room that a piece needs, the description too */
};

enum vtk_type { VTK_FLOAT64, VTK_INT64, VTK_INT32, VTK_UINT8 };

/* What an array is for, in the order in which they have to be added. */
enum vtk_section { VTK_POINT_DATA, VTK_CELL_DATA, VTK_POINTS, VTK_TOPOLOGY, VTK_SECTIONS };

struct vtk_array {
    enum vtk_section section;
    enum vtk_type type;
    int components;
    bool flat;     /* described as one component: a list that happens to come in rows */
    uint64_t rows; /* of `components` values each */
    char name[VTK_NAME_SIZE];
    int kind, source; /* for `fill` alone */
};

struct vtk_file {
    bool polydata; /* else an unstructured grid */
    uint64_t points, cells;
    size_t count;
    struct vtk_array array[VTK_ARRAYS_MAX];
    /* Puts the values of the rows first .. first + count - 1 of an array into `bytes` (VTK_BLOCK
     * bytes of room, aligned for any of the types); false when they cannot be read. */
    bool (*fill)(void *context, const struct vtk_array *array, uint64_t first, size_t count,
                 void *bytes);
    void *context;
    /* Where the file is; zero at the start. */
    bool described;
    size_t at;
    uint64_t row;
};

/* Appends an array; false when there are too many. The name needs no escaping. */
bool vtk_add(struct vtk_file *file, const struct vtk_array *array);

/* The bytes of the whole file. */
uint64_t vtk_length(const struct vtk_file *file);

/* Appends the next piece to `piece`, which has VTK_PIECE bytes of room left; `*ended` is set with
 * the last one. False when `fill` failed or the description found no room. */
bool vtk_next(struct vtk_file *file, struct api_text *piece, bool *ended);

#endif
