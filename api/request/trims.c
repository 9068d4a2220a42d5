/* SPDX-License-Identifier: MIT */
#include "parts.h"

enum curve_type { CURVE_SPLINE, CURVE_FREEFORM, CURVE_CONTAINER, CURVE_TYPE_COUNT };

static const char *const curve_types[CURVE_TYPE_COUNT] = {"spline", "freeform", "container"};

static bool check_knots(const struct trim_curve *curve, const struct tree_place *knots,
                        size_t knot_count) {
    if (knot_count != curve->count + (size_t)curve->degree + 1) {
        tree_fault(knots, "the number of knots must be the number of points + degree + 1");
        return false;
    }
    for (size_t i = 1; i < knot_count; i++) {
        if (curve->knots[i] < curve->knots[i - 1]) {
            struct tree_place knot = tree_element(knots, i);
            tree_fault(&knot, "a knot must not be less than the one before it");
            return false;
        }
    }
    if (curve->knots[curve->count] > curve->knots[curve->degree])
        return true;
    tree_fault(knots, "the domain between knot[degree] and knot[size] is empty");
    return false;
}

static bool read_points(const struct tree_place *place, struct trim_curve *curve) {
    double *rows;
    if (!tree_rows(place, decode_coordinates, 2, 2, &rows, &curve->count))
        return false;
    curve->points = (const double(*)[2])rows;
    return true;
}

static bool read_weights(const struct tree_place *place, struct trim_curve *curve) {
    size_t count;
    if (!tree_numbers(place, decode_lengths, 2, &curve->weights, &count))
        return false;
    if (count == curve->count)
        return true;
    tree_fault(place, "the number of weights must be the number of points");
    return false;
}

static bool decode_spline(const struct tree_place *place, struct trim_curve *curve) {
    static const char *const keys[] = {
        "degree",    "knotvector", "control_points", "weights", "reversed", "type",      "rational",
        "dimension", "delta",      "name",           "id",      "bbox",     "precision", NULL};
    struct tree_place degree = tree_member(place, "degree");
    struct tree_place knots = tree_member(place, "knotvector");
    struct decode_control control;
    size_t knot_count;
    tree_object(place, keys);
    decode_control_find(place, &control);
    bool ok = tree_integer(&degree, 1, NURBS_DEGREE_MAX, &curve->degree);
    ok = tree_numbers(&knots, decode_coordinates, 4, &curve->knots, &knot_count) && ok;
    ok = read_points(&control.points, curve) && ok;
    if (ok && tree_given(&control.weights))
        ok = read_weights(&control.weights, curve);
    return ok && check_knots(curve, &knots, knot_count);
}

static bool decode_freeform(const struct tree_place *place, struct trim_curve *curve) {
    static const char *const keys[] = {"points", "reversed", "type", "dimension",
                                       "name",   "id",       NULL};
    struct tree_place points = tree_member(place, "points");
    tree_object(place, keys);
    curve->degree = 1;
    return read_points(&points, curve);
}

/* What `type` says, else what the keys say. */
static bool read_type(const struct tree_place *place, enum curve_type *type) {
    struct tree_place name = tree_member(place, "type");
    struct tree_place points = tree_member(place, "points"), data = tree_member(place, "data");
    int index = tree_given(&points) ? CURVE_FREEFORM
                : tree_given(&data) ? CURVE_CONTAINER
                                    : CURVE_SPLINE;
    bool ok = !tree_given(&name) || tree_choice(&name, curve_types, CURVE_TYPE_COUNT, &index);
    *type = (enum curve_type)index;
    return ok;
}

static bool decode_curve(const struct tree_place *place, struct trim_curve *curve) {
    enum curve_type type;
    if (!read_type(place, &type))
        return false;
    if (type == CURVE_CONTAINER) {
        tree_fault(place, "a container must not hold another");
        return false;
    }
    return type == CURVE_SPLINE ? decode_spline(place, curve) : decode_freeform(place, curve);
}

static bool decode_container(const struct tree_place *place, struct trim_loop *trim) {
    static const char *const keys[] = {"type", "count", "data", "reversed", "name", "id", NULL};
    struct tree_place data = tree_member(place, "data");
    tree_object(place, keys);
    if (!tree_array(&data, 1))
        return false;
    trim->count = tree_length(&data);
    struct trim_curve *curves = tree_alloc(place->tree, trim->count, sizeof *curves);
    bool ok = curves != NULL;
    for (size_t i = 0; curves && i < trim->count; i++) {
        struct tree_place curve = tree_element(&data, i);
        ok = decode_curve(&curve, &curves[i]) && ok;
    }
    trim->curves = curves;
    return ok;
}

static bool decode_single(const struct tree_place *place, struct trim_loop *trim) {
    struct trim_curve *curve = tree_alloc(place->tree, 1, sizeof *curve);
    trim->curves = curve;
    trim->count = 1;
    return curve && decode_curve(place, curve);
}

static bool decode_trim(const struct tree_place *place, struct trim_loop *trim) {
    struct tree_place reversed = tree_member(place, "reversed");
    enum curve_type type;
    if (!read_type(place, &type))
        return false;
    bool ok = !tree_given(&reversed) || tree_boolean(&reversed, &trim->reversed);
    bool decoded =
        type == CURVE_CONTAINER ? decode_container(place, trim) : decode_single(place, trim);
    return decoded && ok;
}

bool decode_trims(const struct tree_place *place, struct api_surface *surface) {
    static const char *const keys[] = {"count", "data", NULL};
    bool wrapped = tree_type(place) == TREE_OBJECT;
    struct tree_place list = wrapped ? tree_member(place, "data") : *place;
    if (wrapped)
        tree_object(place, keys);
    if (!tree_array(&list, 0))
        return false;
    surface->trim_count = tree_length(&list);
    struct trim_loop *trims = tree_alloc(place->tree, surface->trim_count, sizeof *trims);
    bool ok = trims != NULL;
    for (size_t i = 0; trims && i < surface->trim_count; i++) {
        struct tree_place trim = tree_element(&list, i);
        ok = decode_trim(&trim, &trims[i]) && ok;
    }
    surface->trims = trims;
    return ok;
}
