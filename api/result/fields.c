/* SPDX-License-Identifier: MIT */
#include "fields.h"

#include "solver/permeability.h"
#include <math.h>
#include <string.h>

/* ---- one cell; shear in degrees ---- */

/* n t0: the plies of the unsheared fabric */
static double stack_thickness(const struct api_request *request) {
    return request->fabric.plies * request->fabric.thickness;
}

/* t = n t0 / cos gamma between flexible faces, else the height: mass conservation. */
static double thickness(const struct api_request *request, double shear_deg) {
    const struct api_cavity *cavity = &request->cavity;
    return cavity->rigid ? cavity->height
                         : stack_thickness(request) * permeability_areal_ratio(shear_deg);
}

/* Vf = Vf0 between flexible faces, else Vf0 (n t0 / h) / cos gamma: mass conservation. It may
 * exceed what is possible, which `packing_exceeded` tells. */
static double fiber_volume_fraction(const struct api_request *request, double shear_deg) {
    const struct api_cavity *cavity = &request->cavity;
    double unsheared = request->fabric.fiber_volume_fraction;
    if (!cavity->rigid)
        return unsheared;
    return unsheared * (stack_thickness(request) / cavity->height) *
           permeability_areal_ratio(shear_deg);
}

/* phi = 1 - Vf */
static double porosity(const struct api_request *request, double shear_deg) {
    return 1 - fiber_volume_fraction(request, shear_deg);
}

static double packing_exceeded(const struct api_request *request, double shear_deg) {
    return fiber_volume_fraction(request, shear_deg) > api_packing_limit(&request->permeability);
}

static double locked(const struct api_request *request, double shear_deg) {
    return fabs(shear_deg) > request->fabric.locking_angle_deg;
}

/* ---- whether the request gave what it takes ---- */

static bool has_thickness(const struct api_request *request) {
    return request->cavity.rigid || request->fabric.thickness > 0;
}

static bool has_fraction(const struct api_request *request) {
    return request->fabric.fiber_volume_fraction > 0 &&
           (!request->cavity.rigid || request->fabric.thickness > 0);
}

static bool has_locking(const struct api_request *request) {
    return request->fabric.locking_angle_deg >= 0;
}

struct api_derived {
    const char *name;
    bool integer;
    bool (*given)(const struct api_request *request);
    double (*value)(const struct api_request *request, double shear_deg);
};

static const struct api_derived scalars[] = {
    {"thickness", false, has_thickness, thickness},
    {"fiber_volume_fraction", false, has_fraction, fiber_volume_fraction},
    {"porosity", false, has_fraction, porosity},
};

static const struct api_derived flags[] = {
    {"locked", true, has_locking, locked},
    {"packing_exceeded", true, has_fraction, packing_exceeded},
};

/* ---- columns ---- */

static bool fill_real(const void *context, size_t first, size_t count, double *values) {
    memcpy(values, (const double *)context + first, count * sizeof *values);
    return true;
}

static bool fill_index(const void *context, size_t first, size_t count, double *values) {
    for (size_t i = 0; i < count; i++)
        values[i] = ((const int32_t *)context)[first + i];
    return true;
}

static bool fill_byte(const void *context, size_t first, size_t count, double *values) {
    for (size_t i = 0; i < count; i++)
        values[i] = ((const uint8_t *)context)[first + i];
    return true;
}

static bool fill_derived(const void *context, size_t first, size_t count, double *values) {
    const struct api_derived_column *column = context;
    const struct api_fields *fields = column->fields;
    const double *shear = fields->result->cells.shear_deg + first;
    for (size_t i = 0; i < count; i++)
        values[i] = column->derived->value(fields->request, shear[i]);
    return true;
}

static void add(struct api_fields *fields, enum api_table table, const char *name, size_t rows,
                bool (*fill)(const void *, size_t, size_t, double *), const void *context) {
    fields->source[fields->count++] =
        (struct api_column_source){.table = table,
                                   .name = name,
                                   .integer = fill == fill_index || fill == fill_byte,
                                   .rows = rows,
                                   .fill = fill,
                                   .context = context};
}

static void add_derived(struct api_fields *fields, const struct api_derived *derived, size_t count,
                        struct api_derived_column *columns) {
    for (size_t k = 0; k < count; k++) {
        if (!derived[k].given(fields->request))
            continue;
        columns[k] = (struct api_derived_column){fields, &derived[k]};
        add(fields, API_TABLE_CELLS, derived[k].name, fields->result->cells.count, fill_derived,
            &columns[k]);
        fields->source[fields->count - 1].integer = derived[k].integer;
    }
}

static void add_nodes(struct api_fields *fields, const struct drape_nodes *nodes) {
    const struct {
        const char *name;
        const double *values;
    } columns[] = {{"u", nodes->u},
                   {"v", nodes->v},
                   {"x", nodes->x},
                   {"y", nodes->y},
                   {"z", nodes->z},
                   {"shear_deg", nodes->shear_deg},
                   {"error_estimate", nodes->error_estimate}};
    add(fields, API_TABLE_NODES, "i", nodes->count, fill_index, nodes->i);
    add(fields, API_TABLE_NODES, "j", nodes->count, fill_index, nodes->j);
    for (size_t k = 0; k < sizeof columns / sizeof *columns; k++)
        if (columns[k].values)
            add(fields, API_TABLE_NODES, columns[k].name, nodes->count, fill_real,
                columns[k].values);
}

/* What the permeability follows from was given, or there would be no model. */
static void add_permeability(struct api_fields *fields, size_t cells) {
    const struct api_permeability_columns *k = &fields->permeability;
    const struct {
        const char *name;
        const double *values;
    } columns[] = {{"k1", k->k1},     {"k2", k->k2},     {"k3", k->k3},
                   {"k1_x", k->k1_x}, {"k1_y", k->k1_y}, {"k1_z", k->k1_z}};
    for (size_t i = 0; k->k1 && i < sizeof columns / sizeof *columns; i++)
        add(fields, API_TABLE_CELLS, columns[i].name, cells, fill_real, columns[i].values);
}

static void add_cells(struct api_fields *fields, const struct drape_cells *cells) {
    const struct {
        const char *name;
        const double *values;
    } directions[] = {{"warp_x", cells->warp_x}, {"warp_y", cells->warp_y},
                      {"warp_z", cells->warp_z}, {"weft_x", cells->weft_x},
                      {"weft_y", cells->weft_y}, {"weft_z", cells->weft_z}};
    const size_t scalar_count = sizeof scalars / sizeof *scalars;
    add(fields, API_TABLE_CELLS, "i", cells->count, fill_index, cells->i);
    add(fields, API_TABLE_CELLS, "j", cells->count, fill_index, cells->j);
    add(fields, API_TABLE_CELLS, "shear_deg", cells->count, fill_real, cells->shear_deg);
    add_derived(fields, scalars, scalar_count, fields->derived);
    for (size_t k = 0; k < sizeof directions / sizeof *directions; k++)
        add(fields, API_TABLE_CELLS, directions[k].name, cells->count, fill_real,
            directions[k].values);
    add_permeability(fields, cells->count);
    add_derived(fields, flags, sizeof flags / sizeof *flags, fields->derived + scalar_count);
    if (!fields->permeability.out_of_table)
        return;
    add(fields, API_TABLE_CELLS, "out_of_table", cells->count, fill_real,
        fields->permeability.out_of_table);
    fields->source[fields->count - 1].integer = true;
}

static void add_front(struct api_fields *fields, const struct drape_front *front) {
    add(fields, API_TABLE_FRONT, "i", front->count, fill_index, front->i);
    add(fields, API_TABLE_FRONT, "j", front->count, fill_index, front->j);
    add(fields, API_TABLE_FRONT, "reason", front->count, fill_byte, front->reason);
}

enum status api_fields_list(struct api_fields *fields, const struct api_request *request,
                            const struct drape_result *result, struct arena *arena) {
    *fields = (struct api_fields){.request = request, .result = result};
    enum status status = api_permeability_columns(request, &result->cells, fiber_volume_fraction,
                                                  arena, &fields->permeability);
    if (status != STATUS_OK)
        return status;
    add_nodes(fields, &result->nodes);
    add_cells(fields, &result->cells);
    add_front(fields, &result->front);
    return STATUS_OK;
}

static size_t count_flag(const struct api_derived *flag, const struct api_request *request,
                         const struct drape_cells *cells) {
    size_t count = 0;
    for (size_t i = 0; flag->given(request) && i < cells->count; i++)
        count += flag->value(request, cells->shear_deg[i]) > 0;
    return count;
}

size_t api_fields_locked(const struct api_request *request, const struct drape_cells *cells) {
    return count_flag(&flags[0], request, cells);
}

size_t api_fields_packing_exceeded(const struct api_request *request,
                                   const struct drape_cells *cells) {
    return count_flag(&flags[1], request, cells);
}
