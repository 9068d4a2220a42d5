/* SPDX-License-Identifier: MIT */
/* Generators that are steered, or have their places, and what those that are sought are to cost the
 * least of. */
#include "api/json/value.h"
#include "members.h"
#include "solver/shell/shell.h"
#include <limits.h>
#include <math.h>

static const struct value_range curvatures = {-1e12, 1e12, false};
static const struct value_range steered_lengths = {1e-12, 1e12, false};
static const struct value_range forces = {0, 1e12, false}, bendings = {0, 1e12, false};
static const struct value_range shears = {0, 89, false}, norms = {1, 64, false};

/* As many values as points on both sides, from which these follow where they are not given. */
static void decode_curvature_values(const struct json_value *json, bool points_given,
                                    struct drape_curvature *curvature) {
    const double *values;
    size_t count;
    if (!value_numbers(json, curvatures, 2, &values, &count))
        return;
    if (!points_given && count % 2 == 0 && count <= DRAPE_CURVATURE_VALUES)
        curvature->points = (int)count / 2;
    if (count != 2 * (size_t)curvature->points) {
        value_fault(json, "must be an even number of values, twice the points of a side, of which "
                          "there are at most 16");
        return;
    }
    for (size_t k = 0; k < count; k++)
        curvature->value[k] = values[k];
}

void decode_steered(const struct json_value *json, struct drape_generator *generator) {
    static const char *const keys[] = {"points", "values", "length", NULL};
    struct json_value points = value_member(json, keys[0]), values = value_member(json, keys[1]);
    struct json_value length = value_member(json, keys[2]);
    bool listed = value_type(json) == VALUE_ARRAY;
    struct drape_curvature *curvature = &generator->curvature;
    *curvature = (struct drape_curvature){.points = DECODE_STEERED_POINTS};
    generator->kind = DRAPE_GENERATOR_LEAST;
    if (!listed && !value_object(json, keys))
        return;
    if (value_given(&points))
        value_integer(&points, 1, DRAPE_CURVATURE_POINTS, &curvature->points);
    if (listed || value_given(&values)) {
        generator->kind = DRAPE_GENERATOR_STEERED;
        decode_curvature_values(listed ? json : &values, value_given(&points), curvature);
    }
    if (value_given(&length))
        value_vector(&length, steered_lengths, 2, curvature->length);
}

void decode_places(const struct json_value *json, struct drape_generator *generator) {
    static const char *const keys[] = {"places", "start", NULL};
    struct json_value list = value_member(json, keys[0]), start = value_member(json, keys[1]);
    double *rows;
    size_t count;
    int number = 0;
    if (!value_object(json, keys) || !value_rows(&list, decode_coordinates, 6, 1, &rows, &count))
        return;
    if (value_given(&start) && value_integer(&start, 0, INT_MAX, &number) &&
        (size_t)number >= count)
        value_fault(&start, "must be less than %zu, the number of places", count);
    struct drape_place *places = json_tree_alloc(json->tree, count, sizeof *places);
    for (size_t k = 0; places && k < count; k++) {
        const double *row = rows + 6 * k;
        struct json_value own = value_element(&list, k);
        places[k] = (struct drape_place){
            (int32_t)row[0], {row[1], row[2]}, vec3_make(row[3], row[4], row[5])};
        if (!(row[0] >= 0 && row[0] < SHELL_FACES_MAX && row[0] == floor(row[0]))) {
            value_fault(&own, "must begin with the number of a face, 0 of a part of one");
            return;
        }
    }
    generator->kind = DRAPE_GENERATOR_PLACES;
    generator->places = places;
    generator->place_count = count;
    generator->place_start = (size_t)number;
}

/* Rows of an angle and a force, from two columns. */
static void decode_shear_curve(const struct json_value *json, struct drape_energy *energy) {
    static const char *const keys[] = {"shear_deg", "force", NULL};
    struct json_value shear = value_member(json, keys[0]), force = value_member(json, keys[1]);
    const double *angles, *given;
    size_t rows, count;
    if (!value_object(json, keys) || !value_numbers(&shear, shears, 2, &angles, &rows) ||
        !value_numbers(&force, forces, 2, &given, &count))
        return;
    if (count != rows) {
        value_fault(&force, "must have as many values as shear_deg");
        return;
    }
    double(*curve)[2] = json_tree_alloc(json->tree, rows, sizeof *curve);
    for (size_t k = 0; curve && k < rows; k++) {
        struct json_value angle = value_element(&shear, k), at = value_element(&force, k);
        curve[k][0] = angles[k];
        curve[k][1] = given[k];
        if (k > 0 && !(angles[k] > angles[k - 1])) {
            value_fault(&angle, "must be greater than the angle before it");
            return;
        }
        if (k > 0 && given[k] < given[k - 1]) {
            value_fault(&at,
                        "must not be less than the force before it: of cloth that softens when "
                        "it is sheared has no least energy");
            return;
        }
    }
    if (curve && !(given[rows - 1] > 0)) {
        value_fault(&force, "must not be 0 throughout");
        return;
    }
    energy->shear_curve = (const double(*)[2])curve;
    energy->shear_count = curve ? rows : 0;
}

void decode_shear_energy(const struct json_value *fabric, struct drape_energy *energy) {
    struct json_value curve = value_member(fabric, "shear_curve");
    struct json_value bending = value_member(fabric, "bending");
    if (value_given(&curve))
        decode_shear_curve(&curve, energy);
    if (value_given(&bending))
        value_number(&bending, bendings, &energy->bending);
}

void decode_energy(const struct json_value *json, struct drape_energy *energy) {
    static const char *const keys[] = {"norm", "min_radius", NULL};
    struct json_value norm = value_member(json, keys[0]), radius = value_member(json, keys[1]);
    if (!value_object(json, keys))
        return;
    if (value_given(&norm))
        value_number(&norm, norms, &energy->norm);
    if (value_given(&radius))
        value_number(&radius, decode_lengths, &energy->min_radius);
}

void decode_check_steered(const struct json_value *generator, const struct drape_settings *settings,
                          int k, bool on_mesh) {
    const struct drape_generator *own = &settings->generator[k];
    double radius = settings->energy.min_radius, most = curvature_most(&own->curvature);
    double spacing = settings->spacing[k];
    if (own->kind != DRAPE_GENERATOR_STEERED && own->kind != DRAPE_GENERATOR_LEAST)
        return;
    if (on_mesh)
        value_fault(generator, "must not be steered on a triangle mesh, whose geodesics have no "
                               "curvature of their own");
    else if (own->kind == DRAPE_GENERATOR_LEAST && settings->slide > 0)
        value_fault(generator, "must have values where weft slides along warp "
                               "(fabric.kinematics): none are found there");
    else if (own->kind == DRAPE_GENERATOR_STEERED && most * radius > 1)
        value_fault(generator, "bends with a radius of %.3g, less than energy.min_radius, %g",
                    1 / most, radius);
    else if (own->kind == DRAPE_GENERATOR_STEERED && most * spacing > 1)
        value_fault(generator,
                    "bends with a radius of %.3g, less than the spacing of its nodes, %g: no yarn "
                    "keeps that; give smaller values, or a finer spacing",
                    1 / most, spacing);
}
