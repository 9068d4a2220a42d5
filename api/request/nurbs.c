/* SPDX-License-Identifier: MIT */
#include "members.h"
#include "solver/shell/shell.h"

#include <math.h>
#include <string.h>

_Static_assert(sizeof(struct vec3) == 3 * sizeof(double), "rows of three numbers are vectors");

/* Knots that differ by less than this share of the domain, but do differ, would make derivatives
 * overflow; it is far below the last digit of any knot but one near 0. */
static const double SPAN_LEAST = 1e-20;

/* Where each member of a definition is, by `enum nurbs_member`. */
struct nurbs_places {
    struct decode_control control;
    struct json_value part[NURBS_WEIGHTS + 1];
};

void decode_control_find(const struct json_value *owner, struct decode_control *control) {
    static const char *const keys[] = {"points", "weights", NULL};
    control->net = value_member(owner, "control_points");
    if (value_type(&control->net) != VALUE_OBJECT) {
        control->points = control->net;
        control->weights = value_member(owner, "weights");
        return;
    }
    value_object(&control->net, keys);
    control->points = value_member(&control->net, "points");
    control->weights = value_member(&control->net, "weights");
    struct json_value beside = value_member(owner, "weights");
    if (value_given(&beside))
        value_fault(&beside, "must be a member of control_points, beside the points");
}

static bool fault_part(const struct nurbs_places *places, const struct nurbs_fault *fault) {
    const struct json_value *json = &places->part[fault->member];
    struct json_value element = value_element(json, fault->index);
    return value_fault(fault->has_index ? &element : json, "%s", fault->reason);
}

/* What most often makes the knots of a direction too many or too few, as a question; "" when
 * nothing explains their number. */
static const char *guess_at_knots(const struct nurbs *nurbs, int direction) {
    const struct nurbs_axis *own = direction == 0 ? &nurbs->u : &nurbs->v;
    const struct nurbs_axis *other = direction == 0 ? &nurbs->v : &nurbs->u;
    size_t m = own->knot_count, n = other->knot_count;
    size_t own_size = (size_t)own->size, other_size = (size_t)other->size;
    size_t own_order = (size_t)own->degree + 1, other_order = (size_t)other->degree + 1;
    if (m == other_size + own_order && n == own_size + other_order)
        return "; are size_u and size_v swapped?";
    if (m == own_size + other_order && n == other_size + own_order)
        return "; are degree_u and degree_v swapped?";
    if (m == other_size + other_order && n == own_size + own_order)
        return "; are knotvector_u and knotvector_v swapped?";
    if (m + 2 == own_size + own_order)
        return "; Rhino and openNURBS leave out the first and the last knot: repeat both ends once "
               "more";
    return "";
}

/* Checks one direction alone, so that its faults are found beside those of the rest: the other
 * one is a plain span, and the control points, which come last, are not looked at. */
static bool check_axis(const struct nurbs_places *places, const struct nurbs *nurbs,
                       int direction) {
    static const double plain_knots[] = {0, 0, 1, 1};
    static const struct nurbs_axis plain = {1, 2, plain_knots, 4};
    const struct nurbs_axis *axis = direction == 0 ? &nurbs->u : &nurbs->v;
    const struct json_value *knots = &places->part[direction == 0 ? NURBS_KNOTS_U : NURBS_KNOTS_V];
    const struct nurbs alone = {.u = direction == 0 ? *axis : plain,
                                .v = direction == 0 ? plain : *axis};
    size_t wanted = (size_t)axis->size + (size_t)axis->degree + 1;
    char letter = direction == 0 ? 'u' : 'v';
    struct nurbs_fault fault;
    /* Too few control points for the degree are reported as such. */
    if (axis->knot_count != wanted && axis->size > axis->degree)
        return value_fault(knots, "the number of knots is %zu; size_%c + degree_%c + 1 is %zu%s",
                           axis->knot_count, letter, letter, wanted,
                           guess_at_knots(nurbs, direction));
    if (nurbs_validate(&alone, &fault) != STATUS_OK && fault.member < NURBS_POINTS)
        return fault_part(places, &fault);
    /* What `nurbs_validate` does not ask, but finite derivatives need. */
    double domain = axis->knots[axis->size] - axis->knots[axis->degree];
    if (domain < decode_lengths.low)
        return value_fault(knots, "the domain must be at least %g long", decode_lengths.low);
    for (size_t i = 1; i < axis->knot_count; i++) {
        double span = axis->knots[i] - axis->knots[i - 1];
        if (span > 0 && span < SPAN_LEAST * domain) {
            struct json_value knot = value_element(knots, i);
            return value_fault(&knot, "is too close to the knot before it, but not equal");
        }
    }
    return true;
}

/* Reads both directions, and reports the faults of both. */
static bool read_axes(const struct nurbs_places *places, struct nurbs *nurbs) {
    static const enum nurbs_member degree[2] = {NURBS_DEGREE_U, NURBS_DEGREE_V};
    static const enum nurbs_member size[2] = {NURBS_SIZE_U, NURBS_SIZE_V};
    static const enum nurbs_member knots[2] = {NURBS_KNOTS_U, NURBS_KNOTS_V};
    const struct json_value *part = places->part;
    struct nurbs_axis *axes[2] = {&nurbs->u, &nurbs->v};
    bool read[2], ok = true;
    for (int k = 0; k < 2; k++) {
        read[k] = value_integer(&part[degree[k]], 1, NURBS_DEGREE_MAX, &axes[k]->degree);
        read[k] = value_integer(&part[size[k]], 2, NURBS_SIZE_MAX, &axes[k]->size) && read[k];
        read[k] = value_numbers(&part[knots[k]], decode_coordinates, 1, &axes[k]->knots,
                                &axes[k]->knot_count) &&
                  read[k];
    }
    for (int k = 0; k < 2; k++)
        ok = read[k] && check_axis(places, nurbs, k) && ok;
    return ok;
}

/* One of the columns of control points, against the sizes where those are known. */
static bool check_column_count(const struct nurbs *nurbs, const struct json_value *column,
                               size_t count, const char *noun) {
    size_t wanted = (size_t)nurbs->u.size * (size_t)nurbs->v.size;
    if (count == 0 || wanted == 0 || count == wanted)
        return true;
    return value_fault(column, "the number of %s is %zu; size_u * size_v is %zu * %zu = %zu", noun,
                       count, (size_t)nurbs->u.size, (size_t)nurbs->v.size, wanted);
}

bool decode_nurbs(const struct json_value *json, bool of_shell, struct api_surface *surface) {
    static const char *const keys[] = {
        "kind", "colour", /* of faces alone */
        "degree_u", "degree_v", "size_u", "size_v", "knotvector_u", "knotvector_v",
        "control_points", "weights", "trims",
        /* written by geomdl, rw3dm, Sverchok or CurvesWB; they do not matter here */
        "type", "rational", "dimension", "pdimension", "delta", "sample_size", "name", "id", "bbox",
        "reversed", "precision", NULL};
    static const char *const parts[] = {
        [NURBS_DEGREE_U] = "degree_u",    [NURBS_DEGREE_V] = "degree_v",
        [NURBS_SIZE_U] = "size_u",        [NURBS_SIZE_V] = "size_v",
        [NURBS_KNOTS_U] = "knotvector_u", [NURBS_KNOTS_V] = "knotvector_v",
    };
    if (!value_object(json, of_shell ? keys : keys + 2))
        return false;
    struct nurbs *nurbs = &surface->nurbs;
    struct nurbs_places places;
    struct nurbs_fault fault;
    decode_control_find(json, &places.control);
    const struct json_value *points = &places.control.points, *weights = &places.control.weights;
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++)
        places.part[i] = value_member(json, parts[i]);
    places.part[NURBS_POINTS] = *points;
    places.part[NURBS_WEIGHTS] = *weights;
    bool ok = read_axes(&places, nurbs);
    double *rows;
    if (value_rows(points, decode_coordinates, 3, 4, &rows, &nurbs->point_count))
        nurbs->points = (const void *)rows;
    else
        ok = false;
    if (value_given(weights))
        ok = value_numbers(weights, decode_lengths, 4, &nurbs->weights, &nurbs->weight_count) && ok;
    ok = check_column_count(nurbs, points, nurbs->point_count, "control points") && ok;
    ok = check_column_count(nurbs, weights, nurbs->weight_count, "weights") && ok;
    if (ok && nurbs_validate(nurbs, &fault) != STATUS_OK)
        ok = fault_part(&places, &fault);
    /* Weights that are all 1 say nothing. */
    size_t units = 0;
    while (ok && units < nurbs->weight_count && nurbs->weights[units] == 1)
        units++;
    if (ok && units == nurbs->weight_count) {
        nurbs->weights = NULL;
        nurbs->weight_count = 0;
    }
    struct json_value trims = value_member(json, "trims");
    if (value_given(&trims))
        ok = decode_trims(&trims, surface) && ok;
    return ok;
}
