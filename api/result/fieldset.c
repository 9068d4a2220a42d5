/* SPDX-License-Identifier: MIT */
#include "fieldset.h"

#include "solver/vec.h"
#include <stdio.h>
#include <string.h>

const char *const fieldset_tensor_columns[FIELDSET_TENSOR_COLUMNS] = {
    "k1",     "k2",     "k3",     "k1_x",   "k1_y",   "k1_z",
    "warp_x", "warp_y", "warp_z", "weft_x", "weft_y", "weft_z"};

static const char *const tensor_names[] = {"kxx", "kyy", "kzz", "kxy", "kyz", "kxz"};

static bool begins_tensor(const char *const *names, size_t left) {
    for (size_t k = 0; k < 6; k++)
        if (k >= left || strcmp(names[k], tensor_names[k]) != 0)
            return false;
    return true;
}

/* Whether the names are BASE_x, BASE_y, BASE_z. */
static bool begins_vector(const char *const *names, size_t left, size_t *base) {
    size_t length = strlen(names[0]);
    if (left < 3 || length < 3)
        return false;
    *base = length - 2;
    for (size_t k = 0; k < 3; k++)
        if (strlen(names[k]) != length || memcmp(names[k], names[0], *base) != 0 ||
            names[k][*base] != '_' || names[k][*base + 1] != "xyz"[k])
            return false;
    return true;
}

size_t fieldset_make(const char *const *names, size_t count, size_t first,
                     struct fieldset_field *field) {
    const char *const *own = names + first;
    size_t base = 0;
    memset(field, 0, sizeof *field);
    field->components = 1;
    if (begins_tensor(own, count - first)) {
        field->components = 6;
        strcpy(field->name, "permeability");
    } else if (begins_vector(own, count - first, &base)) {
        field->components = 3;
        bool k1 = base == 2 && memcmp(own[0], "k1", 2) == 0;
        snprintf(field->name, sizeof field->name, "%.*s%s", (int)base, own[0],
                 k1 ? "_direction" : "");
    } else {
        snprintf(field->name, sizeof field->name, "%s", own[0]);
    }
    for (int k = 0; k < field->components; k++)
        field->column[k] = first + (size_t)k;
    return (size_t)field->components;
}

static void add_dyad(double tensor[6], double factor, struct vec3 a) {
    const double dyad[6] = {a.x * a.x, a.y * a.y, a.z * a.z, a.x * a.y, a.y * a.z, a.x * a.z};
    for (int k = 0; k < 6; k++)
        tensor[k] += factor * dyad[k];
}

void fieldset_tensor(const double v[FIELDSET_TENSOR_COLUMNS], double tensor[6]) {
    struct vec3 first = vec3_make(v[3], v[4], v[5]);
    struct vec3 warp = vec3_make(v[6], v[7], v[8]), weft = vec3_make(v[9], v[10], v[11]);
    struct vec3 normal = vec3_unit(vec3_cross(warp, weft));
    memset(tensor, 0, 6 * sizeof *tensor);
    add_dyad(tensor, v[0], first);
    add_dyad(tensor, v[1], vec3_cross(normal, first));
    add_dyad(tensor, v[2], normal);
}
