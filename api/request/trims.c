/* SPDX-License-Identifier: MIT */
#include "members.h"

enum curve_type { CURVE_SPLINE, CURVE_FREEFORM, CURVE_CONTAINER, CURVE_TYPE_COUNT };

static const char *const curve_types[CURVE_TYPE_COUNT] = {"spline", "freeform", "container"};

static bool read_trim_points(const struct json_value *json, struct trim_curve *curve) {
    double *rows;
    if (!value_rows(json, decode_coordinates, 2, 2, &rows, &curve->count))
        return false;
    curve->points = (const double(*)[2])rows;
    return true;
}

static bool decode_spline(const struct json_value *json, struct trim_curve *curve) {
    static const char *const keys[] = {
        "degree",    "knotvector", "control_points", "weights", "reversed", "type",      "rational",
        "dimension", "delta",      "name",           "id",      "bbox",     "precision", NULL};
    struct json_value degree = value_member(json, "degree");
    struct json_value knots = value_member(json, "knotvector");
    struct decode_control control;
    size_t knot_count;
    value_object(json, keys);
    decode_control_find(json, &control);
    bool ok = value_integer(&degree, 1, NURBS_DEGREE_MAX, &curve->degree);
    ok = value_numbers(&knots, decode_coordinates, 4, &curve->knots, &knot_count) && ok;
    ok = read_trim_points(&control.points, curve) && ok;
    if (ok && value_given(&control.weights)) {
        size_t count;
        ok = value_numbers(&control.weights, decode_lengths, 2, &curve->weights, &count);
        if (ok && count != curve->count)
            ok =
                value_fault(&control.weights, "the number of weights must be the number of points");
    }
    if (!ok)
        return false;
    if (knot_count != curve->count + (size_t)curve->degree + 1)
        return value_fault(&knots, "the number of knots must be the number of points + degree + 1");
    for (size_t i = 1; i < knot_count; i++) {
        if (curve->knots[i] < curve->knots[i - 1]) {
            struct json_value knot = value_element(&knots, i);
            return value_fault(&knot, "a knot must not be less than the one before it");
        }
    }
    return curve->knots[curve->count] > curve->knots[curve->degree] ||
           value_fault(&knots, "the domain between knot[degree] and knot[size] is empty");
}

/* What `type` says, else what the keys say. */
static bool read_type(const struct json_value *json, enum curve_type *type) {
    struct json_value name = value_member(json, "type");
    struct json_value points = value_member(json, "points"), data = value_member(json, "data");
    int index = value_given(&points) ? CURVE_FREEFORM
                : value_given(&data) ? CURVE_CONTAINER
                                     : CURVE_SPLINE;
    bool ok = !value_given(&name) || value_choice(&name, curve_types, CURVE_TYPE_COUNT, &index);
    *type = (enum curve_type)index;
    return ok;
}

/* A loop: a curve alone, or a container of several. */
static bool decode_trim(const struct json_value *json, struct trim_loop *trim) {
    static const char *const keys[] = {"type", "count", "data", "reversed", "name", "id", NULL};
    static const char *const freeform_keys[] = {"points", "reversed", "type", "dimension",
                                                "name",   "id",       NULL};
    struct json_value reversed = value_member(json, "reversed"), data = value_member(json, "data");
    enum curve_type type;
    if (!read_type(json, &type))
        return false;
    bool ok = !value_given(&reversed) || value_boolean(&reversed, &trim->reversed);
    bool several = type == CURVE_CONTAINER;
    if (several) {
        value_object(json, keys);
        if (!value_array(&data, 1))
            return false;
    }
    trim->count = several ? value_length(&data) : 1;
    struct trim_curve *curves = json_tree_alloc(json->tree, trim->count, sizeof *curves);
    trim->curves = curves;
    for (size_t i = 0; curves && i < trim->count; i++) {
        struct json_value curve = several ? value_element(&data, i) : *json;
        struct json_value points = value_member(&curve, "points");
        if (!read_type(&curve, &type)) {
            ok = false;
        } else if (type == CURVE_SPLINE) {
            ok = decode_spline(&curve, &curves[i]) && ok;
        } else if (type == CURVE_CONTAINER) {
            ok = value_fault(&curve, "a container must not hold another");
        } else {
            value_object(&curve, freeform_keys);
            curves[i].degree = 1;
            ok = read_trim_points(&points, &curves[i]) && ok;
        }
    }
    return curves && ok;
}

bool decode_trims(const struct json_value *json, struct api_surface *surface) {
    static const char *const keys[] = {"count", "data", NULL};
    bool wrapped = value_type(json) == VALUE_OBJECT;
    struct json_value list = wrapped ? value_member(json, "data") : *json;
    if (wrapped)
        value_object(json, keys);
    if (!value_array(&list, 0))
        return false;
    surface->trim_count = value_length(&list);
    struct trim_loop *trims = json_tree_alloc(json->tree, surface->trim_count, sizeof *trims);
    bool ok = trims != NULL;
    for (size_t i = 0; trims && i < surface->trim_count; i++) {
        struct json_value trim = value_element(&list, i);
        ok = decode_trim(&trim, &trims[i]) && ok;
    }
    surface->trims = trims;
    return ok;
}
