/* SPDX-License-Identifier: MIT */
/*
 * An unstructured grid of one piece from a VTK XML file (.vtu; docs.vtk.org, "VTK XML formats"),
 * with arrays as text, in base64 or appended, as they are or packed by zlib, of either byte order.
 *
 * The file is well-formed XML up to what is appended. The parser is stopped there, and what it has
 * found are the places of the arrays.
 */
#ifndef API_MAP_VTK_XML_H
#define API_MAP_VTK_XML_H

#include "api/problem.h"
#include "solver/arena.h"
#include <stdbool.h>
#include <stddef.h>

/* The arrays that are read: of the points, of the cells, and of the cells' data those of whole
 * numbers named id and pid. */
enum vtk_array_use {
    VTK_POINTS_ARRAY,
    VTK_CONNECTIVITY,
    VTK_OFFSETS,
    VTK_TYPES,
    VTK_IDS,
    VTK_PIDS,
    VTK_ARRAYS
};

struct vtk_grid {
    size_t points, cells;
    double *values[VTK_ARRAYS]; /* NULL: there is no such array */
    size_t count[VTK_ARRAYS];   /* of the numbers in it, which may be any */
};

/* Reads one, in `arena`. False with the problem set: API_INVALID_REQUEST or API_OUT_OF_MEMORY. */
bool vtk_xml_read(const char *bytes, size_t length, struct arena *arena, struct vtk_grid *grid,
                  struct api_problem *problem);

#endif
