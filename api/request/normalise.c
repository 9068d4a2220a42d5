/* SPDX-License-Identifier: MIT */
#include "normalise.h"

#include "api/json/text.h"

static void normalise_control(struct api_text *text, const double *points, size_t width,
                              const double *weights, size_t count) {
    api_text_key_object(text, "control_points");
    api_text_key_rows(text, "points", points, width, count);
    if (weights)
        api_text_key_numbers(text, "weights", weights, count);
    api_text_raw(text, "}");
}

void api_normalise_trims(struct api_text *text, const struct trim_loop *trims, size_t count) {
    api_text_key(text, "trims");
    api_text_raw(text, "[");
    for (size_t i = 0; i < count; i++) {
        api_text_raw(text, i ? "," : "");
        api_text_raw(text, "{\"type\":\"container\",\"data\":[");
        for (size_t k = 0; k < trims[i].count; k++) {
            api_text_raw(text, k ? "," : "");
            const struct trim_curve *curve = &trims[i].curves[k];
            api_text_raw(text, "{");
            api_text_key_string(text, "type", curve->knots ? "spline" : "freeform");
            if (curve->knots) {
                api_text_key_integer(text, "degree", curve->degree);
                api_text_key_numbers(text, "knotvector", curve->knots,
                                     curve->count + (size_t)curve->degree + 1);
                normalise_control(text, curve->points[0], 2, curve->weights, curve->count);
            } else {
                api_text_key_rows(text, "points", curve->points[0], 2, curve->count);
            }
            api_text_raw(text, "}");
        }
        api_text_raw(text, trims[i].reversed ? "],\"reversed\":true}" : "],\"reversed\":false}");
    }
    api_text_raw(text, "]");
}

static void normalise_nurbs(struct api_text *text, const struct api_surface *surface) {
    const struct nurbs *nurbs = &surface->nurbs;
    api_text_raw(text, "{");
    if (surface->face_name)
        api_text_key_string(text, "name", surface->face_name);
    if (surface->face_kind)
        api_text_key_string(text, "kind", surface->face_kind);
    if (surface->face_colour)
        api_text_key_string(text, "colour", surface->face_colour);
    api_text_key_integer(text, "degree_u", nurbs->u.degree);
    api_text_key_integer(text, "degree_v", nurbs->v.degree);
    api_text_key_numbers(text, "knotvector_u", nurbs->u.knots, nurbs->u.knot_count);
    api_text_key_numbers(text, "knotvector_v", nurbs->v.knots, nurbs->v.knot_count);
    api_text_key_integer(text, "size_u", nurbs->u.size);
    api_text_key_integer(text, "size_v", nurbs->v.size);
    normalise_control(text, &nurbs->points[0].x, 3, nurbs->weights, nurbs->point_count);
    if (surface->trim_count)
        api_normalise_trims(text, surface->trims, surface->trim_count);
    api_text_raw(text, "}");
}

void api_normalise_notes(struct api_text *text, const struct api_surface *surface,
                         const char *more) {
    api_text_key(text, "notes");
    api_text_raw(text, "[");
    for (size_t k = 0; k < surface->note_count; k++) {
        api_text_raw(text, k ? "," : "");
        api_text_string(text, surface->notes[k]);
    }
    if (*more) {
        api_text_raw(text, surface->note_count ? "," : "");
        api_text_string(text, more);
    }
    api_text_raw(text, "]");
}

static void normalise_definition(struct api_text *text, const struct api_surface *surface) {
    if (surface->kind == API_SURFACE_NURBS) {
        normalise_nurbs(text, surface);
        return;
    }
    const struct api_mesh *mesh = &surface->mesh;
    bool on_mesh = surface->kind == API_SURFACE_MESH;
    api_text_raw(text, "{");
    if (on_mesh)
        api_text_key_rows(text, "vertices", &mesh->vertices[0].x, 3, mesh->vertex_count);
    api_text_key(text, on_mesh ? "triangles" : "faces");
    api_text_raw(text, "[");
    for (size_t k = 0; k < (on_mesh ? mesh->triangle_count : surface->face_count); k++) {
        api_text_raw(text, k ? "," : "");
        if (on_mesh)
            api_text_integers(text, mesh->triangles[k], 3);
        else
            normalise_nurbs(text, &surface->faces[k]);
    }
    api_text_raw(text, "]");
    if (!on_mesh && surface->tolerance > 0)
        api_text_key_number(text, "tolerance", surface->tolerance);
    /* What an importer wrote beside the geometry. */
    if (surface->length_unit)
        api_text_key_string(text, "length_unit", surface->length_unit->name);
    if (surface->notes)
        api_normalise_notes(text, surface, "");
    api_text_raw(text, "}");
}

void api_normalise_steered(struct api_text *text, const struct drape_curvature *curvature,
                           bool values) {
    api_text_raw(text, "{");
    api_text_key_object(text, "steered");
    api_text_key_integer(text, "points", curvature->points);
    if (values)
        api_text_key_numbers(text, "values", curvature->value, 2 * (size_t)curvature->points);
    if (curvature->length[0] > 0)
        api_text_key_numbers(text, "length", curvature->length, 2);
    api_text_raw(text, "}}");
}

/* What cloth costs, as far as it is not the default. */
static void normalise_energy(struct api_text *text, const struct drape_energy *energy) {
    if (!(energy->norm > 0) && !(energy->min_radius > 0))
        return;
    api_text_key_object(text, "energy");
    if (energy->norm > 0)
        api_text_key_number(text, "norm", energy->norm);
    if (energy->min_radius > 0)
        api_text_key_number(text, "min_radius", energy->min_radius);
    api_text_raw(text, "}");
}

static void normalise_shear_energy(struct api_text *text, const struct drape_energy *energy) {
    if (energy->bending > 0)
        api_text_key_number(text, "bending", energy->bending);
    if (energy->shear_count == 0)
        return;
    api_text_key_object(text, "shear_curve");
    for (int column = 0; column < 2; column++) {
        api_text_key(text, column ? "force" : "shear_deg");
        for (size_t k = 0; k < energy->shear_count; k++) {
            api_text_raw(text, k ? "," : "[");
            api_text_number(text, energy->shear_curve[k][column]);
        }
        api_text_raw(text, "]");
    }
    api_text_raw(text, "}");
}

static void normalise_generator(struct api_text *text, const char *key,
                                const struct drape_generator *generator) {
    api_text_key(text, key);
    switch (generator->kind) {
    case DRAPE_GENERATOR_GEODESIC:
        api_text_string(text, "geodesic");
        break;
    case DRAPE_GENERATOR_CURVE:
        api_text_raw(text, "{");
        api_text_key_rows(text, "uv", generator->curve[0], 2, generator->curve_count);
        api_text_raw(text, "}");
        break;
    case DRAPE_GENERATOR_STEERED:
    case DRAPE_GENERATOR_LEAST:
        api_normalise_steered(text, &generator->curvature,
                              generator->kind == DRAPE_GENERATOR_STEERED);
        break;
    case DRAPE_GENERATOR_PLANE:
        api_text_raw(text, "{");
        api_text_key_numbers(text, "plane", &generator->plane_normal.x, 3);
        api_text_raw(text, "}");
        break;
    case DRAPE_GENERATOR_PLACES:
        api_text_raw(text, "{");
        api_text_key(text, "places");
        for (size_t k = 0; k < generator->place_count; k++) {
            const struct drape_place *place = &generator->places[k];
            const struct vec3 *along = &place->along;
            const double row[] = {place->face, place->uv[0], place->uv[1],
                                  along->x,    along->y,     along->z};
            api_text_raw(text, k ? "," : "[");
            api_text_numbers(text, row, 6);
        }
        api_text_raw(text, "]");
        api_text_key_integer(text, "start", (int64_t)generator->place_start);
        api_text_raw(text, "}");
        break;
    }
}

void api_normalise_permeability(struct api_text *text, const struct api_permeability *k) {
    const struct {
        const char *key;
        const double *values;
    } columns[] = {
        {"k1", k->table_k1}, {"k2", k->table_k2}, {"k3", k->table_k3}, {"angle_deg", k->angle_deg}};
    if (k->model == API_PERMEABILITY_NONE)
        return;
    api_text_key_object(text, "permeability");
    api_text_key_string(text, "model", api_permeability_names[k->model]);
    if (k->model == API_PERMEABILITY_KOZENY_CARMAN) {
        api_text_key_number(text, "k1", k->k1);
        api_text_key_number(text, "k2", k->k2);
        api_text_key_number(text, "k3", k->k3);
        api_text_key_number(text, "at_fiber_volume_fraction", k->at_fiber_volume_fraction);
    } else if (k->model == API_PERMEABILITY_GEBART) {
        api_text_key_number(text, "fiber_radius", k->fiber_radius);
        api_text_key_string(text, "packing", api_packing_names[k->packing]);
    } else {
        api_text_key_numbers(text, "shear_deg", k->shear_deg, k->rows);
        if (k->fractions > 0)
            api_text_key_numbers(text, "fiber_volume_fraction", k->table_fractions, k->fractions);
        /* A value for each shear angle, or a row of values. */
        for (size_t i = 0; i < sizeof columns / sizeof *columns; i++)
            if (columns[i].values && k->fractions > 0)
                api_text_key_rows(text, columns[i].key, columns[i].values, k->fractions, k->rows);
            else if (columns[i].values)
                api_text_key_numbers(text, columns[i].key, columns[i].values, k->rows);
    }
    api_text_raw(text, "}");
}

void api_normalise_shear_limits(struct api_text *text, const struct api_fabric *fabric) {
    const double *locking = fabric->locking_angle_deg;
    const struct api_limit_curve *limit = &fabric->limit;
    if (locking[0] >= 0 && locking[0] == locking[1]) {
        api_text_key_number(text, "locking_angle_deg", locking[0]);
    } else if (locking[0] >= 0) {
        api_text_key_object(text, "locking_angle_deg");
        api_text_key_number(text, "positive", locking[0]);
        api_text_key_number(text, "negative", locking[1]);
        api_text_raw(text, "}");
    }
    if (limit->rows == 0)
        return;
    api_text_key_object(text, "limit_curve");
    api_text_key_numbers(text, "shear_deg", limit->shear_deg, limit->rows);
    api_text_key_numbers(text, "severity", limit->severity, limit->rows);
    api_text_raw(text, "}");
}

void api_normalise_kinematics(struct api_text *text, double slide) {
    if (slide == 1) {
        api_text_key_string(text, "kinematics", "parallel_fibers");
    } else if (slide > 0) {
        api_text_key_object(text, "kinematics");
        api_text_key_number(text, "slide", slide);
        api_text_raw(text, "}");
    }
}

void api_normalise_yarns(struct api_text *text, const struct api_fabric *fabric) {
    const struct lamina *lamina = &fabric->lamina;
    if (fabric->balance > 0)
        api_text_key_number(text, "balance", fabric->balance);
    if (lamina->e1 == 0)
        return;
    api_text_key_object(text, "lamina");
    api_text_key_number(text, "e1", lamina->e1);
    api_text_key_number(text, "e2", lamina->e2);
    api_text_key_number(text, "nu12", lamina->nu12);
    api_text_key_number(text, "g12", lamina->g12);
    api_text_raw(text, "}");
}

void api_normalise_compaction(struct api_text *text, const struct api_compaction *law) {
    if (law->a == 0)
        return;
    api_text_key_object(text, "compaction");
    api_text_key_number(text, "a", law->a);
    api_text_key_number(text, "b", law->b);
    api_text_raw(text, "}");
}

void api_normalise_ground(struct api_text *text, const struct api_surface *surface,
                          const struct api_unit *unit) {
    api_text_key(text, "surface");
    if (surface->id[0]) {
        api_text_raw(text, "{");
        api_text_key_string(text, "id", surface->id);
        const struct api_selection *selection = &surface->selection;
        if (selection->kind == API_SELECT_LIST) {
            api_text_key_integers(text, "faces", selection->faces, selection->count);
        } else if (selection->kind == API_SELECT_GROWN) {
            if (selection->seed == API_SEED_FACE)
                api_text_key_integer(text, "grow_from", selection->grow_from);
            else
                api_text_key_object(text, "grow_from");
            if (selection->seed == API_SEED_ELEMENT)
                api_text_key_integer(text, "element", selection->grow_from);
            if (selection->seed == API_SEED_POINT)
                api_text_key_numbers(text, "point", &selection->point.x, 3);
            api_text_raw(text, selection->seed == API_SEED_FACE ? "" : "}");
            api_text_key_number(text, "up_to_deg", selection->up_to_deg);
        }
        api_text_raw(text, "}");
    } else {
        normalise_definition(text, surface);
    }
    if (unit)
        api_text_key_string(text, "length_unit", unit->name);
}

void api_normalise_rosette(struct api_text *text, const struct api_request *request) {
    const struct drape_zero *zero = &request->settings.zero;
    if (zero->kind != DRAPE_ZERO_ROSETTE)
        return;
    api_text_key_object(text, "rosette");
    api_text_key_numbers(text, "origin", &request->rosette_origin.x, 3);
    api_text_key_numbers(text, "x", &zero->x.x, 3);
    if (vec3_norm2(zero->z) > 0)
        api_text_key_numbers(text, "z", &zero->z.x, 3);
    api_text_raw(text, "}");
}

static void normalise_cuts(struct api_text *text, const struct api_request *request) {
    api_text_key(text, "cuts");
    for (size_t k = 0; k < request->settings.cut_count; k++) {
        const struct drape_cut_line *cut = &request->settings.cuts[k];
        api_text_raw(text, k ? ",{" : "[{");
        api_text_key_rows(text, "path", &cut->path[0].x, 3, cut->count);
        api_text_key_string(text, "name", request->cut_names[k]);
        if (request->cut_allowances[k] > 0)
            api_text_key_number(text, "allowance", request->cut_allowances[k]);
        api_text_raw(text, "}");
    }
    api_text_raw(text, "]");
}

void api_normalise_cloth(struct api_text *text, const struct api_request *request,
                         const struct api_start *chosen) {
    const struct drape_settings *settings = &request->settings;
    const struct api_fabric *fabric = &request->fabric;
    api_text_key_object(text, "fabric");
    api_text_key_numbers(text, "spacing", settings->spacing, 2);
    if (fabric->material && request->unit_of_surface) { /* no unit to state a thickness in */
        api_text_key(text, "material");
        api_text_raw(text, fabric->material);
    } else if (fabric->thickness > 0) {
        api_text_key_number(text, "thickness", fabric->thickness);
    }
    if (fabric->fiber_volume_fraction > 0)
        api_text_key_number(text, "fiber_volume_fraction", fabric->fiber_volume_fraction);
    api_normalise_shear_limits(text, fabric);
    api_text_key_number(text, "pre_shear_deg", settings->pre_shear_deg);
    api_text_key_integer(text, "plies", fabric->plies);
    api_normalise_kinematics(text, settings->slide);
    api_normalise_yarns(text, fabric);
    normalise_shear_energy(text, &settings->energy);
    api_text_raw(text, "}");
    if (settings->generator[0].kind == DRAPE_GENERATOR_PLACES) {
        /* they have the start */
    } else if (settings->start_kind == DRAPE_START_POINT) {
        api_text_key_object(text, "start");
        api_text_key_numbers(text, "point", &settings->start_point.x, 3);
        api_text_raw(text, "}");
    } else if (settings->start_kind != DRAPE_START_CENTROID || chosen) {
        bool given = settings->start_kind == DRAPE_START_UV;
        bool faces = request->surface.kind != API_SURFACE_NURBS && !given && chosen->face >= 0;
        api_text_key_object(text, "start");
        if (faces || (given && request->start_on_face))
            api_text_key_integer(text, "face", given ? settings->start_face : chosen->face);
        api_text_key_numbers(text, "uv", given ? settings->start_uv : chosen->uv, 2);
        api_text_raw(text, "}");
    }
    api_text_key_object(text, "direction");
    if (settings->direction_kind == DRAPE_DIRECTION_VECTOR)
        api_text_key_numbers(text, "vector", &settings->direction_vector.x, 3);
    else
        api_text_key_number(text, "angle_deg", settings->direction_deg);
    api_text_raw(text, "}");
    api_text_key_object(text, "generators");
    normalise_generator(text, "warp", &settings->generator[0]);
    normalise_generator(text, "weft", &settings->generator[1]);
    api_text_raw(text, "}");
    normalise_energy(text, &settings->energy);
    api_text_key_string(text, "method", drape_method_names[settings->method]);
    api_text_key_string(text, "yarn_path", api_yarn_path_names[settings->yarn_path]);
    if (settings->cut_count)
        normalise_cuts(text, request);
    if (!settings->has_extent[0] && !settings->has_extent[1])
        return;
    api_text_key_object(text, "extent");
    for (int k = 0; k < 2; k++)
        if (settings->has_extent[k])
            api_text_key_integers(text, k ? "weft" : "warp", settings->extent[k], 2);
    api_text_raw(text, "}");
}

const char *api_normalise(const struct api_request *request, const struct api_start *chosen,
                          struct arena *arena) {
    struct api_text text = api_text_growing(arena);
    const struct api_unit *unit = request->length_unit;
    if (request->unit_of_surface)
        unit = chosen ? &api_units[chosen->unit] : NULL;
    api_text_raw(&text, "{");
    api_normalise_ground(&text, &request->surface, unit);
    if (request->offset != 0)
        api_text_key_number(&text, "offset", request->offset);
    api_normalise_rosette(&text, request);
    api_normalise_cloth(&text, request, chosen);
    if (request->cavity.rigid) {
        api_text_key_object(&text, "cavity");
        api_text_key_number(&text, "height", request->cavity.height);
        api_text_raw(&text, "}");
    } else {
        api_text_key_string(&text, "cavity", "flexible");
    }
    api_normalise_permeability(&text, &request->permeability);
    api_text_raw(&text, "}");
    return api_text_finish(&text);
}

const char *api_normalise_surface(const struct api_surface *surface, struct arena *arena) {
    struct api_text text = api_text_growing(arena);
    normalise_definition(&text, surface);
    return api_text_finish(&text);
}
