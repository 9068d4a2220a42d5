/* SPDX-License-Identifier: MIT */
/*
 * Fields on a caller's own mesh, streamed in the formats of mould-filling tools. Like the encoders
 * of results (`encode.h`), these give their bytes as they are asked for; what they write lies in
 * the caller's memory.
 */
#ifndef API_FORMAT_MESH_ENCODE_H
#define API_FORMAT_MESH_ENCODE_H

#include "api/problem.h"
#include "api/request/request.h"
#include "api/result/columns.h"
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

/* All arrays are the caller's and outlive the encoder. */
struct api_mesh_fields {
    const char *id;              /* of the drape */
    const struct api_unit *unit; /* of the vertices and of all lengths */
    const struct vec3 *vertices;
    size_t vertex_count;
    const int32_t (*elements)[4]; /* vertices from 0, in order; the fourth of a triangle is -1 */
    size_t element_count;
    const struct api_column_source *columns; /* one row an element; named as in a result's cells */
    size_t column_count;
    const uint8_t *inlet; /* for each element whether it belongs to the inlet; NULL: none does */
    const char *warning;  /* what the caller should know about the fields; NULL: nothing */
    int precision; /* of text: significant digits; 0: the shortest that reads back the same */
};

struct api_mesh_format;

/*
 * - "vtu" (application/vnd.vtk): VTK XML UnstructuredGrid, appended raw; all columns as cell data,
 *   the directions as vectors, the permeability as a tensor.
 * - "lcmsim" (application/zip): a case for LCMsim, see `lcmsim.h`; takes the columns thickness,
 *   porosity, k1, k2, k3, k1_x, k1_y and k1_z.
 * - "json" (application/json) and "csv" (text/csv): the columns alone, also of points, which have
 * no elements. NULL when there is no such format.
 */
const struct api_mesh_format *api_mesh_format_named(const char *name);
const char *api_mesh_format_media_type(const struct api_mesh_format *format);
const char *api_mesh_format_name(const struct api_mesh_format *format);

/* Walks all formats, the default first; NULL after the last. */
const struct api_mesh_format *api_mesh_format_at(size_t index);

/* Whether the format is of elements, and so not for points. */
bool api_mesh_format_needs_elements(const struct api_mesh_format *format);

struct api_mesh_encoder;

/* A new encoder; `fields` is copied, its arrays are not. NULL with `problem` set:
 * API_INVALID_REQUEST when a column is missing that the format needs, API_TOO_LARGE,
 * API_OUT_OF_MEMORY. The caller owns it. */
struct api_mesh_encoder *api_mesh_encoder_new(const struct api_mesh_format *format,
                                              const struct api_mesh_fields *fields,
                                              struct api_problem *problem);

/* The next bytes, at most `size`: how many; 0 at the end; -1 when they cannot be made. */
ssize_t api_mesh_encoder_read(struct api_mesh_encoder *encoder, char *buffer, size_t size);

/* The length of the whole document, 0 when it is only known at its end. */
uint64_t api_mesh_encoder_length(const struct api_mesh_encoder *encoder);

/* For the header `Draped-Binning`: what the binning of `lcmsim` costs, as in
 * "bins=125; direction_deg=2.1; k1=0.03; thickness=0.01"; "" for other formats. Lives as long as
 * the encoder. */
const char *api_mesh_encoder_binning(const struct api_mesh_encoder *encoder);

/* NULL is allowed. */
void api_mesh_encoder_free(struct api_mesh_encoder *encoder);

#endif
