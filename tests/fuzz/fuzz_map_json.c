/* SPDX-License-Identifier: MIT */
/* Any bytes as the JSON body of a map request. */
#include "mesh.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    return mesh_fuzz(map_target_json, data, size);
}
