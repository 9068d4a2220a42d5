/* SPDX-License-Identifier: MIT */
#include "api/json/place.h"
#include "parts.h"
#include <stdio.h>
#include <string.h>

static const struct place_range pre_shears = {-80, 80, false};     /* deg */
static const struct place_range locking_angles = {0, 90, false};   /* deg */
static const struct place_range law_factors = {1e-12, 1e3, false}; /* a */
static const struct place_range law_exponents = {1e-3, 10, false}; /* b */
enum { PLIES_MAX = 10000 };

/* What a fabric is, of a request or of a material; lengths are in `metres`, and become the
 * request's. */
static void read_fabric(const struct json_place *place, double metres,
                        struct api_request *request) {
    struct json_place thickness = place_member(place, "thickness");
    struct json_place fraction = place_member(place, "fiber_volume_fraction");
    struct json_place locking = place_member(place, "locking_angle_deg");
    struct api_fabric *fabric = &request->fabric;
    if (place_given(&thickness) && place_number(&thickness, decode_lengths, &fabric->thickness)) {
        if (metres != request->length_unit->metres)
            fabric->thickness *= metres / request->length_unit->metres;
        fabric->material = NULL;
    }
    if (place_given(&fraction))
        place_number(&fraction, decode_fractions, &fabric->fiber_volume_fraction);
    if (place_given(&locking))
        place_number(&locking, locking_angles, &fabric->locking_angle_deg);
}

void decode_compaction(const struct json_place *place, struct api_compaction *law) {
    static const char *const keys[] = {"a", "b", NULL};
    struct json_place a = place_member(place, "a"), b = place_member(place, "b");
    if (!place_object(place, keys))
        return;
    place_number(&a, law_factors, &law->a);
    place_number(&b, law_exponents, &law->b);
}

void decode_material(const struct json_place *place, struct api_request *request) {
    static const char *const keys[] = {"name",         "about",        "source",
                                       "example",      "areal_weight", "fabric",
                                       "permeability", "compaction",   NULL};
    static const char *const fabric_keys[] = {"thickness", "fiber_volume_fraction",
                                              "locking_angle_deg", NULL};
    struct json_place fabric = place_member(place, "fabric");
    struct json_place permeability = place_member(place, "permeability");
    struct json_place weight = place_member(place, "areal_weight");
    struct json_place law = place_member(place, "compaction");
    if (!place_object(place, keys) || !place_object(&fabric, fabric_keys))
        return;
    read_fabric(&fabric, 1, request);
    if (place_given(&weight))
        place_number(&weight, decode_areal_weights, &request->fabric.areal_weight);
    if (place_given(&permeability))
        decode_permeability(&permeability, &request->permeability);
    if (place_given(&law))
        decode_compaction(&law, &request->fabric.compaction);
}

/* Of the library, which is right. */
static void decode_named(const struct json_place *place, struct api_request *request) {
    const struct json_tree *own = place->tree;
    const char *name;
    struct json_tree tree;
    if (!place_string(place, &name))
        return;
    const struct api_material *material = api_material_named(name);
    char *text = material ? json_tree_alloc(own, strlen(name) + 3, 1) : NULL;
    if (!material) {
        place_fault(place, "is no material of the library or of your own (GET /v1/materials, "
                           "drape --materials)");
        return;
    }
    if (!text || json_tree_parse(&tree, material->json, material->length, &api_limits_default,
                                 own->arena, own->problem) != API_OK)
        return;
    struct json_place root = place_root(&tree);
    decode_material(&root, request);
    json_tree_free(&tree);
    (void)sprintf(text, "\"%s\"", name);
    request->fabric.material = text;
}

/* The figures of a material, which what the request says itself replaces afterwards. */
static void decode_fabric_material(const struct json_place *place, struct api_request *request) {
    struct api_material material;
    if (place_type(place) != PLACE_OBJECT) {
        decode_named(place, request);
        return;
    }
    decode_material(place, request);
    if (place->tree->problem->id == API_OK && material_read(place, &material))
        request->fabric.material = material.json;
}

void decode_fabric(const struct json_place *place, struct api_request *request) {
    static const char *const keys[] = {
        "material",          "spacing",       "thickness", "fiber_volume_fraction",
        "locking_angle_deg", "pre_shear_deg", "plies",     NULL};
    if (!place_object(place, keys))
        return;
    struct json_place material = place_member(place, "material");
    struct json_place spacing = place_member(place, "spacing");
    struct json_place pre_shear = place_member(place, "pre_shear_deg");
    struct json_place plies = place_member(place, "plies");
    double *distance = request->settings.spacing;
    if (place_type(&spacing) == PLACE_ARRAY)
        place_vector(&spacing, decode_lengths, 2, distance);
    else if (place_number(&spacing, decode_lengths, &distance[0]))
        distance[1] = distance[0];
    if (place_given(&material))
        decode_fabric_material(&material, request);
    read_fabric(place, request->length_unit->metres, request);
    if (place_given(&pre_shear))
        place_number(&pre_shear, pre_shears, &request->settings.pre_shear_deg);
    if (place_given(&plies))
        place_integer(&plies, 1, PLIES_MAX, &request->fabric.plies);
}
