/* SPDX-License-Identifier: MIT */
#include "solver/permeability.h"
#include "parts.h"
#include <math.h>

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

/* The same with a row for each shear angle, of a value for each fraction. */
static bool read_rows(const struct json_place *table, const char *key, struct place_range range,
                      const struct api_permeability *k, const double **values) {
    struct json_place column = place_member(table, key);
    double *rows;
    size_t count;
    if (!place_rows(&column, range, k->fractions, 1, &rows, &count))
        return false;
    *values = rows;
    if (count == k->rows)
        return true;
    place_fault(&column, "must have a row for each value of shear_deg");
    return false;
}

static bool read_values(const struct json_place *table, const char *key, struct place_range range,
                        const struct api_permeability *k, const double **values) {
    return k->fractions ? read_rows(table, key, range, k, values)
                        : read_column(table, key, range, k->rows, values);
}

/* A denser fabric has to fill more slowly: k / (1 - Vf) falls along every row. */
static bool check_falling(const struct json_place *table, const char *key,
                          const struct api_permeability *k, const double *values) {
    const double *vf = k->table_fractions;
    struct json_place column = place_member(table, key);
    for (size_t i = 0; i < k->rows; i++)
        for (size_t j = 1; j < k->fractions; j++) {
            const double *value = values + i * k->fractions + j;
            if (permeability_falls(value[-1], vf[j - 1], value[0], vf[j]))
                continue;
            struct json_place row = place_element(&column, i), at = place_element(&row, j);
            place_fault(&at,
                        "must fall faster with fiber_volume_fraction, to at most %.3g after %.3g: "
                        "else a thinner cavity would fill sooner",
                        value[-1] * exp(-(vf[j] - vf[j - 1]) / (1 - vf[j])), value[-1]);
            return false;
        }
    return true;
}

static bool decode_table(const struct json_place *place, struct api_permeability *k) {
    static const struct place_range angles = {-90, 90, false};
    static const char *const keys[] = {
        "model", "shear_deg", "fiber_volume_fraction", "k1", "k2", "k3", "angle_deg", NULL};
    struct json_place shear = place_member(place, "shear_deg");
    struct json_place fraction = place_member(place, "fiber_volume_fraction");
    struct json_place angle = place_member(place, "angle_deg");
    place_object(place, keys);
    if (!place_numbers(&shear, shears, 1, &k->shear_deg, &k->rows))
        return false;
    bool ok = check_increasing(&shear, k->shear_deg, k->rows);
    if (place_given(&fraction) &&
        (!place_numbers(&fraction, decode_fractions, 2, &k->table_fractions, &k->fractions) ||
         !check_increasing(&fraction, k->table_fractions, k->fractions)))
        return false;
    const struct {
        const char *key;
        const double **values;
    } columns[] = {{"k1", &k->table_k1}, {"k2", &k->table_k2}, {"k3", &k->table_k3}};
    for (size_t c = 0; c < sizeof columns / sizeof *columns; c++)
        ok = read_values(place, columns[c].key, permeabilities, k, columns[c].values) &&
             check_falling(place, columns[c].key, k, *columns[c].values) && ok;
    if (place_given(&angle))
        ok = read_values(place, "angle_deg", angles, k, &k->angle_deg) && ok;
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
