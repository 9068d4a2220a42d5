/* SPDX-License-Identifier: MIT */
#include "solver/permeability.h"
#include "members.h"
#include <math.h>

static const struct value_range permeabilities = {1e-30, 1, false}; /* m^2 */
static const struct value_range radii = {1e-9, 1, false};           /* m */
static const struct value_range shears = {0, 90, false};            /* deg */
static const double least_step = 1e-6;                              /* deg */

bool decode_rising(const struct json_value *column, const double *values, size_t count) {
    for (size_t i = 1; i < count; i++) {
        if (values[i] - values[i - 1] < least_step) {
            struct json_value value = value_element(column, i);
            return value_fault(&value, "must be greater than the value before it, by at least %g",
                               least_step);
        }
    }
    return true;
}

/* One more column of a table: a value for each shear angle, or a row of them, one for each
 * fraction. */
static bool read_table_values(const struct json_value *table, const char *key,
                              struct value_range range, const struct api_permeability *k,
                              const double **values) {
    struct json_value column = value_member(table, key);
    double *rows;
    size_t count;
    if (!(k->fractions ? value_rows(&column, range, k->fractions, 1, &rows, &count)
                       : value_numbers(&column, range, 1, values, &count)))
        return false;
    if (k->fractions)
        *values = rows;
    return count == k->rows ||
           value_fault(&column, k->fractions ? "must have a row for each value of shear_deg"
                                             : "must have as many values as shear_deg");
}

/* A denser fabric has to fill more slowly: k / (1 - Vf) falls along every row. */
static bool check_falling(const struct json_value *table, const char *key,
                          const struct api_permeability *k, const double *values) {
    const double *vf = k->table_fractions;
    struct json_value column = value_member(table, key);
    for (size_t i = 0; i < k->rows; i++)
        for (size_t j = 1; j < k->fractions; j++) {
            const double *value = values + i * k->fractions + j;
            if (permeability_falls(value[-1], vf[j - 1], value[0], vf[j]))
                continue;
            struct json_value row = value_element(&column, i), at = value_element(&row, j);
            return value_fault(
                &at,
                "must fall faster with fiber_volume_fraction, to at most %.3g after %.3g; "
                "otherwise a thinner cavity would fill sooner",
                value[-1] * exp(-(vf[j] - vf[j - 1]) / (1 - vf[j])), value[-1]);
        }
    return true;
}

static bool decode_table(const struct json_value *json, struct api_permeability *k) {
    static const struct value_range angles = {-90, 90, false};
    static const char *const keys[] = {
        "model", "shear_deg", "fiber_volume_fraction", "k1", "k2", "k3", "angle_deg", NULL};
    struct json_value shear = value_member(json, "shear_deg");
    struct json_value fraction = value_member(json, "fiber_volume_fraction");
    struct json_value angle = value_member(json, "angle_deg");
    value_object(json, keys);
    if (!value_numbers(&shear, shears, 1, &k->shear_deg, &k->rows))
        return false;
    bool ok = decode_rising(&shear, k->shear_deg, k->rows);
    if (value_given(&fraction) &&
        (!value_numbers(&fraction, decode_fractions, 2, &k->table_fractions, &k->fractions) ||
         !decode_rising(&fraction, k->table_fractions, k->fractions)))
        return false;
    const struct {
        const char *key;
        const double **values;
    } columns[] = {{"k1", &k->table_k1}, {"k2", &k->table_k2}, {"k3", &k->table_k3}};
    for (size_t c = 0; c < sizeof columns / sizeof *columns; c++)
        ok = read_table_values(json, columns[c].key, permeabilities, k, columns[c].values) &&
             check_falling(json, columns[c].key, k, *columns[c].values) && ok;
    if (value_given(&angle))
        ok = read_table_values(json, "angle_deg", angles, k, &k->angle_deg) && ok;
    return ok;
}

bool decode_permeability(const struct json_value *json, struct api_permeability *permeability) {
    static const char *const scaled_keys[] = {"model", "k1", "k2", "k3", "at_fiber_volume_fraction",
                                              NULL};
    static const char *const gebart_keys[] = {"model", "fiber_radius", "packing", NULL};
    struct json_value model = value_member(json, "model");
    int index;
    if (value_type(json) != VALUE_OBJECT)
        return value_fault(json, "must be an object");
    if (!value_choice(&model, api_permeability_names, API_PERMEABILITY_COUNT, &index))
        return false;
    permeability->model = (enum api_permeability_model)index;
    bool ok;
    if (permeability->model == API_PERMEABILITY_KOZENY_CARMAN) {
        struct json_value k1 = value_member(json, "k1"), k2 = value_member(json, "k2");
        struct json_value k3 = value_member(json, "k3");
        struct json_value at = value_member(json, "at_fiber_volume_fraction");
        value_object(json, scaled_keys);
        ok = value_number(&k1, permeabilities, &permeability->k1);
        ok = value_number(&k2, permeabilities, &permeability->k2) && ok;
        ok = value_number(&k3, permeabilities, &permeability->k3) && ok;
        return value_number(&at, decode_fractions, &permeability->at_fiber_volume_fraction) && ok;
    }
    if (permeability->model == API_PERMEABILITY_GEBART) {
        struct json_value radius = value_member(json, "fiber_radius");
        struct json_value packing = value_member(json, "packing");
        value_object(json, gebart_keys);
        index = 0;
        ok = value_number(&radius, radii, &permeability->fiber_radius);
        ok = value_choice(&packing, api_packing_names, API_PACKING_COUNT, &index) && ok;
        permeability->packing = (enum api_packing)index;
        return ok;
    }
    return decode_table(json, permeability);
}
