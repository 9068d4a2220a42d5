/* SPDX-License-Identifier: MIT */
/* What a format for fields on a mesh is made of, for those who write one. */
#ifndef API_FORMAT_MESH_FORMAT_H
#define API_FORMAT_MESH_FORMAT_H

#include "api/json/text.h"
#include "mesh_encode.h"

enum { MESH_PIECE = 128 * 1024, MESH_NOTE_SIZE = 128 };

struct api_mesh_encoder {
    const struct api_mesh_format *format;
    struct api_mesh_fields fields;
    struct api_text piece;
    size_t sent;
    bool ended, failed;
    uint64_t length;
    char binning[MESH_NOTE_SIZE];
    void *state;
    char buffer[MESH_PIECE];
};

struct api_mesh_format {
    const char *name, *media_type;
    bool no_elements; /* also for points, which are no elements */
    size_t state_size;
    /* As in `format.h`: prepares the zeroed state; appends the next piece, of at most
     * MESH_PIECE bytes; frees what the state holds (may be NULL). */
    bool (*begin)(struct api_mesh_encoder *encoder, struct api_problem *problem);
    void (*next)(struct api_mesh_encoder *encoder);
    void (*end)(struct api_mesh_encoder *encoder);
};

extern const struct api_mesh_format mesh_format_json, mesh_format_csv, mesh_format_vtu,
    mesh_format_lcmsim;

/* The column of that name, or NULL. */
const struct api_column_source *mesh_column(const struct api_mesh_fields *fields, const char *name);

#endif
