/* SPDX-License-Identifier: MIT */
#include "control.h"
#include "parts.h"

enum curve_type { CURVE_SPLINE, CURVE_FREEFORM, CURVE_CONTAINER, CURVE_TYPE_COUNT };

static const char *const curve_types[CURVE_TYPE_COUNT] = {"spline", "freeform", "container"};

static bool check_knots(const struct trim_curve *curve, const struct json_place *knots,
                        size_t knot_count) {
    if (knot_count != curve->count + (size_t)curve->degree + 1) {
        place_fault(knots, "the number of knots must be the number of points + degree + 1");
        return false;
    }
    for (size_t i = 1; i < knot_count; i++) {
        if (curve->knots[i] < curve->knots[i - 1]) {
            struct json_place knot = place_element(knots, i);
            place_fault(&knot, "a knot must not be less than the one before it");
            return false;
        }
    }
    if (curve->knots[curve->count] > curve->knots[curve->degree])
        return true;
    place_fault(knots, "the domain between knot[degree] and knot[size] is empty");
    return false;
}

static bool read_points(const struct json_place *place, struct trim_curve *curve) {
    double *rows;
    if (!place_rows(place, decode_coordinates, 2, 2, &rows, &curve->count))
        return false;
    curve->points = (const double(*)[2])rows;
    return true;
}

static bool read_weights(const struct json_place *place, struct trim_curve *curve) {
    size_t count;
    if (!place_numbers(place, decode_lengths, 2, &curve->weights, &count))
        return false;
    if (count == curve->count)
        return true;
    place_fault(place, "the number of weights must be the number of points");
    return false;
}

static bool decode_spline(const struct json_place *place, struct trim_curve *curve) {
    static const char *const keys[] = {
        "degree",    "knotvector", "control_points", "weights", "reversed", "type",      "rational",
        "dimension", "delta",      "name",           "id",      "bbox",     "precision", NULL};
    struct json_place degree = place_member(place, "degree");
    struct json_place knots = place_member(place, "knotvector");
    struct decode_control control;
    size_t knot_count;
    place_object(place, keys);
    decode_control_find(place, &control);
    bool ok = place_integer(&degree, 1, NURBS_DEGREE_MAX, &curve->degree);
    ok = place_numbers(&knots, decode_coordinates, 4, &curve->knots, &knot_count) && ok;
    ok = read_points(&control.points, curve) && ok;
    if (ok && place_given(&control.weights))
        ok = read_weights(&control.weights, curve);
    return ok && check_knots(curve, &knots, knot_count);
}

static bool decode_freeform(const struct json_place *place, struct trim_curve *curve) {
    static const char *const keys[] = {"points", "reversed", "type", "dimension",
                                       "name",   "id",       NULL};
    struct json_place points = place_member(place, "points");
    place_object(place, keys);
    curve->degree = 1;
    return read_points(&points, curve);
}

/* What `type` says, else what the keys say. */
static bool read_type(const struct json_place *place, enum curve_type *type) {
    struct json_place name = place_member(place, "type");
    struct json_place points = place_member(place, "points"), data = place_member(place, "data");
    int index = place_given(&points) ? CURVE_FREEFORM
                : place_given(&data) ? CURVE_CONTAINER
                                     : CURVE_SPLINE;
    bool ok = !place_given(&name) || place_choice(&name, curve_types, CURVE_TYPE_COUNT, &index);
    *type = (enum curve_type)index;
    return ok;
}

static bool decode_curve(const struct json_place *place, struct trim_curve *curve) {
    enum curve_type type;
    if (!read_type(place, &type))
        return false;
    if (type == CURVE_CONTAINER) {
        place_fault(place, "a container must not hold another");
        return false;
    }
    return type == CURVE_SPLINE ? decode_spline(place, curve) : decode_freeform(place, curve);
}

static bool decode_container(const struct json_place *place, struct trim_loop *trim) {
    static const char *const keys[] = {"type", "count", "data", "reversed", "name", "id", NULL};
    struct json_place data = place_member(place, "data");
    place_object(place, keys);
    if (!place_array(&data, 1))
        return false;
    trim->count = place_length(&data);
    struct trim_curve *curves = json_tree_alloc(place->tree, trim->count, sizeof *curves);
    bool ok = curves != NULL;
    for (size_t i = 0; curves && i < trim->count; i++) {
        struct json_place curve = place_element(&data, i);
        ok = decode_curve(&curve, &curves[i]) && ok;
    }
    trim->curves = curves;
    return ok;
}

static bool decode_trim(const struct json_place *place, struct trim_loop *trim) {
    struct json_place reversed = place_member(place, "reversed");
    enum curve_type type;
    if (!read_type(place, &type))
        return false;
    bool ok = !place_given(&reversed) || place_boolean(&reversed, &trim->reversed);
    if (type == CURVE_CONTAINER)
        return decode_container(place, trim) && ok;
    struct trim_curve *curve = json_tree_alloc(place->tree, 1, sizeof *curve);
    trim->curves = curve;
    trim->count = 1;
    return curve && decode_curve(place, curve) && ok;
}

bool decode_trims(const struct json_place *place, struct api_surface *surface) {
    static const char *const keys[] = {"count", "data", NULL};
    bool wrapped = place_type(place) == PLACE_OBJECT;
    struct json_place list = wrapped ? place_member(place, "data") : *place;
    if (wrapped)
        place_object(place, keys);
    if (!place_array(&list, 0))
        return false;
    surface->trim_count = place_length(&list);
    struct trim_loop *trims = json_tree_alloc(place->tree, surface->trim_count, sizeof *trims);
    bool ok = trims != NULL;
    for (size_t i = 0; trims && i < surface->trim_count; i++) {
        struct json_place trim = place_element(&list, i);
        ok = decode_trim(&trim, &trims[i]) && ok;
    }
    surface->trims = trims;
    return ok;
}
