/* SPDX-License-Identifier: MIT */
#include "fields.h"

#include <math.h>
#include <string.h>

static const double PI = 3.14159265358979323846;

/* What no arrangement of fibres exceeds in practice, where no packing is given. */
static const double VF_LIMIT = 0.9;

/* ---- one cell; shear in degrees ---- */

/* A / A0 = 1 / cos gamma; finite, because no double is exactly 90 degrees in radians. */
static double areal_ratio(double shear_deg) {
    return 1 / cos(shear_deg * (PI / 180));
}

/* n t0 */
static double stack_thickness(const struct api_request *request) {
    return request->fabric.plies * request->fabric.thickness;
}

static double thickness(const struct api_request *request, double shear_deg) {
    const struct api_cavity *cavity = &request->cavity;
    return cavity->rigid ? cavity->height : stack_thickness(request) * areal_ratio(shear_deg);
}

static double fiber_volume_fraction(const struct api_request *request, double shear_deg) {
    const struct api_cavity *cavity = &request->cavity;
    double unsheared = request->fabric.fiber_volume_fraction;
    if (!cavity->rigid)
        return unsheared;
    return unsheared * (stack_thickness(request) / cavity->height) * areal_ratio(shear_deg);
}

static double porosity(const struct api_request *request, double shear_deg) {
    return 1 - fiber_volume_fraction(request, shear_deg);
}

/* The densest parallel fibres: pi/4 in a square, pi/(2 sqrt 3) in a hexagonal arrangement. */
static double packing_limit(const struct api_permeability *permeability) {
    if (permeability->model != API_PERMEABILITY_GEBART)
        return VF_LIMIT;
    return permeability->packing == API_PACKING_QUADRATIC ? PI / 4 : PI / (2 * sqrt(3));
}

static double packing_exceeded(const struct api_request *request, double shear_deg) {
    return fiber_volume_fraction(request, shear_deg) > packing_limit(&request->permeability);
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

static void fill_real(const void *context, size_t first, size_t count, double *values) {
    memcpy(values, (const double *)context + first, count * sizeof *values);
}

static void fill_index(const void *context, size_t first, size_t count, double *values) {
    for (size_t i = 0; i < count; i++)
        values[i] = ((const int32_t *)context)[first + i];
}

static void fill_byte(const void *context, size_t first, size_t count, double *values) {
    for (size_t i = 0; i < count; i++)
        values[i] = ((const uint8_t *)context)[first + i];
}

static void fill_derived(const void *context, size_t first, size_t count, double *values) {
    const struct api_derived_column *column = context;
    const struct api_fields *fields = column->fields;
    const double *shear = fields->result->cells.shear_deg + first;
    for (size_t i = 0; i < count; i++)
        values[i] = column->derived->value(fields->request, shear[i]);
}

static void add(struct api_fields *fields, enum api_table table, const char *name, size_t rows,
                void (*fill)(const void *, size_t, size_t, double *), const void *context) {
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
    add_derived(fields, flags, sizeof flags / sizeof *flags, fields->derived + scalar_count);
}

static void add_front(struct api_fields *fields, const struct drape_front *front) {
    add(fields, API_TABLE_FRONT, "i", front->count, fill_index, front->i);
    add(fields, API_TABLE_FRONT, "j", front->count, fill_index, front->j);
    add(fields, API_TABLE_FRONT, "reason", front->count, fill_byte, front->reason);
}

void api_fields_list(struct api_fields *fields, const struct api_request *request,
                     const struct drape_result *result) {
    *fields = (struct api_fields){.request = request, .result = result};
    add_nodes(fields, &result->nodes);
    add_cells(fields, &result->cells);
    add_front(fields, &result->front);
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
