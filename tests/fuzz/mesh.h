/* SPDX-License-Identifier: MIT */
/* What the targets of both readers of meshes share. */
#ifndef TESTS_FUZZ_MESH_H
#define TESTS_FUZZ_MESH_H

#include "fuzz.h"

#include "api/map/target.h"

typedef enum api_problem_id mesh_reader(const char *bytes, size_t length, struct arena *arena,
                                        struct map_target *mesh, struct api_problem *problem);

/* Reads, and follows every index of what was read. */
int mesh_fuzz(mesh_reader *read, const uint8_t *data, size_t size);

#endif
