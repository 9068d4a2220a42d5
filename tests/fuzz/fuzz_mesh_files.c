/* SPDX-License-Identifier: MIT */
/* Any bytes as a mesh of Abaqus, LS-DYNA, Gmsh, a universal file or VTK: the first byte chooses. */
#include "mesh.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static mesh_reader *const readers[] = {map_target_abaqus, map_target_lsdyna, map_target_gmsh,
                                           map_target_universal, map_target_vtu};
    return size ? mesh_fuzz(readers[data[0] % 5], data + 1, size - 1) : 0;
}
