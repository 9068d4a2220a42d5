/* SPDX-License-Identifier: MIT */
/* Meshes of a map, read from text by either reader. */
#ifndef UNIT_MESH_TEXT_H
#define UNIT_MESH_TEXT_H

#include "api/map/mesh.h"

/* api_map_mesh_json or api_map_mesh_nastran. */
typedef enum api_problem_id mesh_reader(const char *text, size_t length, struct arena *arena,
                                        struct api_map_mesh *mesh, struct api_problem *problem);

/* Reads a copy that ends where the text ends, so that a sanitizer sees who reads on. */
enum api_problem_id mesh_text_read(mesh_reader *reader, const char *text, size_t length,
                                   struct arena *arena, struct api_map_mesh *mesh,
                                   struct api_problem *problem);

/* The mesh; the test fails when the text is refused. */
struct api_map_mesh mesh_text_good(mesh_reader *reader, const char *text, struct arena *arena);

#endif
