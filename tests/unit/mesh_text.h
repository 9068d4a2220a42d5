/* SPDX-License-Identifier: MIT */
/* Meshes of a map, read from text by either reader. */
#ifndef UNIT_MESH_TEXT_H
#define UNIT_MESH_TEXT_H

#include "api/map/target.h"

/* map_target_json or map_target_nastran. */
typedef enum api_problem_id mesh_reader(const char *text, size_t length, struct arena *arena,
                                        struct map_target *mesh, struct api_problem *problem);

/* Reads a copy that ends where the text ends, so that a sanitizer sees who reads on. */
enum api_problem_id mesh_text_read(mesh_reader *reader, const char *text, size_t length,
                                   struct arena *arena, struct map_target *mesh,
                                   struct api_problem *problem);

/* The mesh; the test fails when the text is refused. */
struct map_target mesh_text_good(mesh_reader *reader, const char *text, struct arena *arena);

#endif
