/* SPDX-License-Identifier: MIT */
/* Any bytes as Nastran bulk data. */
#include "mesh.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    return mesh_fuzz(map_target_nastran, data, size);
}
