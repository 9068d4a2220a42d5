/* SPDX-License-Identifier: MIT */
#include "material.h"

#include "materials.h" /* made from api/materials */
#include <string.h>

const struct api_material *api_material_at(size_t index) {
    return index < sizeof materials / sizeof *materials ? &materials[index] : NULL;
}

const struct api_material *api_material_named(const char *name) {
    const struct api_material *material;
    for (size_t k = 0; (material = api_material_at(k)); k++)
        if (strcmp(material->name, name) == 0)
            return material;
    return NULL;
}

const char *api_materials_json(void) {
    return materials_json;
}
