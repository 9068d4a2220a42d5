/* SPDX-License-Identifier: MIT */
#include "api/json/value.h"
#include "members.h"
#include <stdio.h>
#include <string.h>

static const struct value_range pre_shears = {-80, 80, false}; /* deg */
enum { PLIES_MAX = 10000 };

void decode_fabric(const struct json_value *json, struct api_request *request) {
    static const char *const keys[] = {"material",
                                       "spacing",
                                       "thickness",
                                       "fiber_volume_fraction",
                                       "locking_angle_deg",
                                       "limit_curve",
                                       "pre_shear_deg",
                                       "plies",
                                       "kinematics",
                                       "shear_curve",
                                       "bending",
                                       "balance",
                                       "lamina",
                                       NULL};
    if (!value_object(json, keys))
        return;
    struct json_value material = value_member(json, "material");
    struct json_value spacing = value_member(json, "spacing");
    struct json_value pre_shear = value_member(json, "pre_shear_deg");
    struct json_value plies = value_member(json, "plies");
    const struct json_tree *tree = json->tree;
    const char *name;
    double *distance = request->settings.spacing;
    if (value_type(&spacing) == VALUE_ARRAY)
        value_vector(&spacing, decode_lengths, 2, distance);
    else if ((value_given(&spacing) || distance[0] == 0) &&
             value_number(&spacing, decode_lengths, &distance[0]))
        distance[1] = distance[0];
    /* The figures of a material, which what the request says itself replaces afterwards. */
    if (value_type(&material) == VALUE_OBJECT) {
        struct api_material own;
        decode_material(&material, request);
        if (tree->problem->id == API_OK && material_read(&material, &own))
            request->fabric.material = own.json;
    } else if (value_given(&material) && value_string(&material, &name)) {
        /* Of the library, which is right. */
        const struct api_material *named = api_material_named(name);
        char *text = named ? json_tree_alloc(tree, strlen(name) + 3, 1) : NULL;
        struct json_tree own;
        if (!named) {
            value_fault(&material, "is neither a material of the library nor one of yours (see GET "
                                   "/v1/materials, drape --materials)");
        } else if (text && json_tree_parse(&own, named->json, named->length, &api_limits_default,
                                           tree->arena, tree->problem) == API_OK) {
            struct json_value root = value_root(&own);
            decode_material(&root, request);
            json_tree_free(&own);
            (void)sprintf(text, "\"%s\"", name);
            request->fabric.material = text;
        }
    }
    decode_figures(json, request->length_unit->metres, request);
    decode_shear_energy(json, &request->settings.energy);
    if (value_given(&pre_shear) &&
        value_number(&pre_shear, pre_shears, &request->settings.pre_shear_deg) &&
        request->settings.slide > 0 && request->settings.pre_shear_deg != 0)
        value_fault(&pre_shear, "must be left out or 0 where weft slides along warp (kinematics): "
                                "fabrics that slide begin unsheared");
    if (value_given(&plies))
        value_integer(&plies, 1, PLIES_MAX, &request->fabric.plies);
}
