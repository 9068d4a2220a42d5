/* SPDX-License-Identifier: MIT */
/* Any bytes as the JSON body of a map request. */
#include "mesh.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    return mesh_fuzz(api_map_mesh_json, data, size);
}
