/* SPDX-License-Identifier: MIT */
#include "request.h"

#include "members.h"

const struct api_unit api_units[API_UNIT_COUNT] = {
    {"m", 1}, {"cm", 1e-2}, {"mm", 1e-3}, {"um", 1e-6}, {"in", 0.0254}, {"ft", 0.3048},
};

const char *const api_yarn_path_names[DRAPE_PATH_RELAXATION + 1] = {
    [DRAPE_PATH_CHORD] = "chord",
    [DRAPE_PATH_RELAXATION] = "relaxation",
};

const char *const api_permeability_names[API_PERMEABILITY_COUNT] = {
    [API_PERMEABILITY_KOZENY_CARMAN] = "kozeny_carman",
    [API_PERMEABILITY_GEBART] = "gebart",
    [API_PERMEABILITY_TABLE] = "table",
};

const char *const api_packing_names[API_PACKING_COUNT] = {
    [API_PACKING_QUADRATIC] = "quadratic",
    [API_PACKING_HEXAGONAL] = "hexagonal",
};

bool decode_unit_name(const struct json_value *json, const struct api_unit **unit) {
    const char *names[API_UNIT_COUNT];
    int index = 0;
    for (int i = 0; i < API_UNIT_COUNT; i++)
        names[i] = api_units[i].name;
    if (!value_choice(json, names, API_UNIT_COUNT, &index))
        return false;
    *unit = &api_units[index];
    return true;
}
