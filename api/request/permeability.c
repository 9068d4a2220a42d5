/* SPDX-License-Identifier: MIT */
#include "parts.h"

static const struct place_range permeabilities = {1e-30, 1, false}; /* m^2 */
static const struct place_range radii = {1e-9, 1, false};           /* m */
static const struct place_range shears = {0, 90, false};            /* deg */
static const double least_step = 1e-6;                              /* deg */

static bool decode_kozeny_carman(const struct json_place *place, struct api_permeability *k) {
    static const char *const keys[] = {"model", "k1", "k2", "k3", "at_fiber_volume_fraction", NULL};
    struct json_place k1 = place_member(place, "k1"), k2 = place_member(place, "k2");
    struct json_place k3 = place_member(place, "k3");
    struct json_place at = place_member(place, "at_fiber_volume_fraction");
    place_object(place, keys);
    bool ok = place_number(&k1, permeabilities, &k->k1);
    ok = place_number(&k2, permeabilities, &k->k2) && ok;
    ok = place_number(&k3, permeabilities, &k->k3) && ok;
    return place_number(&at, decode_fractions, &k->at_fiber_volume_fraction) && ok;
}

static bool decode_gebart(const struct json_place *place, struct api_permeability *k) {
    static const char *const keys[] = {"model", "fiber_radius", "packing", NULL};
    struct json_place radius = place_member(place, "fiber_radius");
    struct json_place packing = place_member(place, "packing");
    int index = 0;
    place_object(place, keys);
    bool ok = place_number(&radius, radii, &k->fiber_radius);
    ok = place_choice(&packing, api_packing_names, API_PACKING_COUNT, &index) && ok;
    k->packing = (enum api_packing)index;
    return ok;
}

/* One more column of a table, as long as the first. */
static bool read_column(const struct json_place *table, const char *key, struct place_range range,
                        size_t rows, const double **values) {
    struct json_place column = place_member(table, key);
    size_t count;
    if (!place_numbers(&column, range, 1, values, &count))
        return false;
    if (count == rows)
        return true;
    place_fault(&column, "must have as many values as shear_deg");
    return false;
}

/* By no less than a measurement resolves, so that slopes between values are finite. */
static bool check_increasing(const struct json_place *column, const double *values, size_t count) {
    for (size_t i = 1; i < count; i++) {
        if (values[i] - values[i - 1] < least_step) {
            struct json_place value = place_element(column, i);
            place_fault(&value, "must be greater than the value before it, by at least %g",
                        least_step);
            return false;
        }
    }
    return true;
}

static bool decode_table(const struct json_place *place, struct api_permeability *k) {
    static const struct place_range angles = {-90, 90, false};
    static const char *const keys[] = {"model", "shear_deg", "k1", "k2", "k3", "angle_deg", NULL};
    struct json_place shear = place_member(place, "shear_deg");
    struct json_place angle = place_member(place, "angle_deg");
    place_object(place, keys);
    if (!place_numbers(&shear, shears, 1, &k->shear_deg, &k->rows))
        return false;
    bool ok = check_increasing(&shear, k->shear_deg, k->rows);
    ok = read_column(place, "k1", permeabilities, k->rows, &k->table_k1) && ok;
    ok = read_column(place, "k2", permeabilities, k->rows, &k->table_k2) && ok;
    ok = read_column(place, "k3", permeabilities, k->rows, &k->table_k3) && ok;
    if (place_given(&angle))
        ok = read_column(place, "angle_deg", angles, k->rows, &k->angle_deg) && ok;
    return ok;
}

bool decode_permeability(const struct json_place *place, struct api_permeability *permeability) {
    struct json_place model = place_member(place, "model");
    int index;
    if (place_type(place) != PLACE_OBJECT) {
        place_fault(place, "must be an object");
        return false;
    }
    if (!place_choice(&model, api_permeability_names, API_PERMEABILITY_COUNT, &index))
        return false;
    permeability->model = (enum api_permeability_model)index;
    switch (permeability->model) {
    case API_PERMEABILITY_KOZENY_CARMAN:
        return decode_kozeny_carman(place, permeability);
    case API_PERMEABILITY_GEBART:
        return decode_gebart(place, permeability);
    default:
        return decode_table(place, permeability);
    }
}
