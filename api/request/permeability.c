/* SPDX-License-Identifier: MIT */
#include "parts.h"

static const struct tree_range permeabilities = {1e-30, 1, false}; /* m^2 */
static const struct tree_range radii = {1e-9, 1, false};           /* m */
static const struct tree_range shears = {0, 90, false};            /* deg */
static const double least_step = 1e-6;                             /* deg */

static bool decode_kozeny_carman(const struct tree_place *place, struct api_permeability *k) {
    static const char *const keys[] = {"model", "k1", "k2", "k3", "at_fiber_volume_fraction", NULL};
    struct tree_place k1 = tree_member(place, "k1"), k2 = tree_member(place, "k2");
    struct tree_place k3 = tree_member(place, "k3");
    struct tree_place at = tree_member(place, "at_fiber_volume_fraction");
    tree_object(place, keys);
    bool ok = tree_number(&k1, permeabilities, &k->k1);
    ok = tree_number(&k2, permeabilities, &k->k2) && ok;
    ok = tree_number(&k3, permeabilities, &k->k3) && ok;
    return tree_number(&at, decode_fractions, &k->at_fiber_volume_fraction) && ok;
}

static bool decode_gebart(const struct tree_place *place, struct api_permeability *k) {
    static const char *const keys[] = {"model", "fiber_radius", "packing", NULL};
    struct tree_place radius = tree_member(place, "fiber_radius");
    struct tree_place packing = tree_member(place, "packing");
    int index = 0;
    tree_object(place, keys);
    bool ok = tree_number(&radius, radii, &k->fiber_radius);
    ok = tree_choice(&packing, api_packing_names, API_PACKING_COUNT, &index) && ok;
    k->packing = (enum api_packing)index;
    return ok;
}

/* One more column of a table, as long as the first. */
static bool read_column(const struct tree_place *table, const char *key, struct tree_range range,
                        size_t rows, const double **values) {
    struct tree_place column = tree_member(table, key);
    size_t count;
    if (!tree_numbers(&column, range, 1, values, &count))
        return false;
    if (count == rows)
        return true;
    tree_fault(&column, "must have as many values as shear_deg");
    return false;
}

/* By no less than a measurement can tell, so that slopes between values are finite. */
static bool check_increasing(const struct tree_place *column, const double *values, size_t count) {
    for (size_t i = 1; i < count; i++) {
        if (values[i] - values[i - 1] < least_step) {
            struct tree_place value = tree_element(column, i);
            tree_fault(&value, "must be greater than the value before it, by at least %g",
                       least_step);
            return false;
        }
    }
    return true;
}

static bool decode_table(const struct tree_place *place, struct api_permeability *k) {
    static const struct tree_range angles = {-90, 90, false};
    static const char *const keys[] = {"model", "shear_deg", "k1", "k2", "k3", "angle_deg", NULL};
    struct tree_place shear = tree_member(place, "shear_deg");
    struct tree_place angle = tree_member(place, "angle_deg");
    tree_object(place, keys);
    if (!tree_numbers(&shear, shears, 1, &k->shear_deg, &k->rows))
        return false;
    bool ok = check_increasing(&shear, k->shear_deg, k->rows);
    ok = read_column(place, "k1", permeabilities, k->rows, &k->table_k1) && ok;
    ok = read_column(place, "k2", permeabilities, k->rows, &k->table_k2) && ok;
    ok = read_column(place, "k3", permeabilities, k->rows, &k->table_k3) && ok;
    if (tree_given(&angle))
        ok = read_column(place, "angle_deg", angles, k->rows, &k->angle_deg) && ok;
    return ok;
}

bool decode_permeability(const struct tree_place *place, struct api_permeability *permeability) {
    struct tree_place model = tree_member(place, "model");
    int index;
    if (tree_type(place) != TREE_OBJECT) {
        tree_fault(place, "must be an object");
        return false;
    }
    if (!tree_choice(&model, api_permeability_names, API_PERMEABILITY_COUNT, &index))
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
