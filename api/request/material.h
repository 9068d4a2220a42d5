/* SPDX-License-Identifier: MIT */
/*
 * The library of fabrics, api/materials, in the program: each a JSON document with where its
 * figures come from. A request names one as `fabric.material`; what it says beside that wins.
 */
#ifndef API_REQUEST_MATERIAL_H
#define API_REQUEST_MATERIAL_H

#include <stddef.h>

struct api_material {
    const char *name, *about;
    const char *json; /* lengths in m; permeability as in a request */
    size_t length;
};

/* Walked, by name; NULL after the last. */
const struct api_material *api_material_at(size_t index);

/* NULL when there is none. */
const struct api_material *api_material_named(const char *name);

/* All of them without their figures: {"materials": [{"name", "about", "source", "example"}...]}. */
const char *api_materials_json(void);

#endif
