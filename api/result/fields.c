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
 * exceed what is possible: `packing_exceeded`. */
double api_fields_fiber_volume_fraction(const struct api_request *request, double shear_deg) {
    const struct api_cavity *cavity = &request->cavity;
    double unsheared = request->fabric.fiber_volume_fraction;
    if (!cavity->rigid)
        return unsheared;
    return unsheared * (stack_thickness(request) / cavity->height) *
           permeability_areal_ratio(shear_deg);
}

/* phi = 1 - Vf */
static double porosity(const struct api_request *request, double shear_deg) {
    return 1 - api_fields_fiber_volume_fraction(request, shear_deg);
}

static double packing_exceeded(const struct api_request *request, double shear_deg) {
    return api_fields_fiber_volume_fraction(request, shear_deg) >
           api_packing_limit(&request->permeability);
}

static double locked(const struct api_request *request, double shear_deg) {
    return fabs(shear_deg) > request->fabric.locking_angle_deg;
}

/* The columns that follow from the shear of a cell. */
static double (*const derived[COLUMN_COUNT])(const struct api_request *request,
                                             double shear_deg) = {
    [COLUMN_CELLS_thickness] = thickness,
    [COLUMN_CELLS_fiber_volume_fraction] = api_fields_fiber_volume_fraction,
    [COLUMN_CELLS_porosity] = porosity,
    [COLUMN_CELLS_locked] = locked,
    [COLUMN_CELLS_packing_exceeded] = packing_exceeded,
};

bool api_fields_derive(enum column_id id, const struct api_request *request, double shear_deg,
                       double *value) {
    if (derived[id])
        *value = derived[id](request, shear_deg);
    return derived[id] != NULL;
}

/* Whether the request gave what a derived column follows from. */
static bool is_given(const struct api_request *request, enum column_id id) {
    const struct api_fabric *fabric = &request->fabric;
    bool rigid = request->cavity.rigid;
    switch (column_specs[id].need) {
    case COLUMN_THICKNESS:
        return rigid || fabric->thickness > 0;
    case COLUMN_FRACTION:
        return fabric->fiber_volume_fraction > 0 && (!rigid || fabric->thickness > 0);
    case COLUMN_LOCKING:
        return fabric->locking_angle_deg >= 0;
    default:
        return true;
    }
}

/* The cells, or those that the rim cuts. */
static const struct drape_cells *cells_of(const struct api_fields *fields, bool cut) {
    return cut ? &fields->result->cut.cells : &fields->result->cells;
}

/* The values of a component of a column that is not derived: int32_t of an integer, uint8_t of a
 * reason and of flags that the solver sets, double of others. NULL when the column is not there. */
static const void *values_of(const struct api_fields *fields, enum column_id id, int part,
                             bool cut) {
    const struct drape_nodes *nodes = &fields->result->nodes;
    const struct drape_cells *cells = cells_of(fields, cut);
    const struct drape_front *front = &fields->result->front;
    const struct drape_rim *rim = &fields->result->rim;
    const struct api_permeability_columns *k = &fields->permeability[cut];
    switch (id) {
    case COLUMN_NODES_i:
        return nodes->i;
    case COLUMN_NODES_j:
        return nodes->j;
    case COLUMN_NODES_u:
        return nodes->u;
    case COLUMN_NODES_v:
        return nodes->v;
    case COLUMN_NODES_face:
        return nodes->face;
    case COLUMN_NODES_x:
        return nodes->x;
    case COLUMN_NODES_y:
        return nodes->y;
    case COLUMN_NODES_z:
        return nodes->z;
    case COLUMN_NODES_shear_deg:
        return nodes->shear_deg;
    case COLUMN_NODES_error_estimate:
        return nodes->error_estimate;
    case COLUMN_NODES_grown:
        return nodes->grown;
    case COLUMN_CELLS_i:
        return cells->i;
    case COLUMN_CELLS_j:
        return cells->j;
    case COLUMN_CELLS_shear_deg:
        return cells->shear_deg;
    case COLUMN_CELLS_warp:
        return (double *const[]){cells->warp_x, cells->warp_y, cells->warp_z}[part];
    case COLUMN_CELLS_weft:
        return (double *const[]){cells->weft_x, cells->weft_y, cells->weft_z}[part];
    case COLUMN_CELLS_k1:
        return k->k1;
    case COLUMN_CELLS_k2:
        return k->k2;
    case COLUMN_CELLS_k3:
        return k->k3;
    case COLUMN_CELLS_k1_direction:
        return (double *const[]){k->k1_x, k->k1_y, k->k1_z}[part];
    case COLUMN_CELLS_out_of_table:
        return k->out_of_table;
    case COLUMN_FRONT_i:
        return front->i;
    case COLUMN_FRONT_j:
        return front->j;
    case COLUMN_FRONT_reason:
        return front->reason;
    case COLUMN_RIM_loop:
        return rim->loop;
    case COLUMN_RIM_face:
        return rim->face;
    case COLUMN_RIM_x:
        return rim->x;
    case COLUMN_RIM_y:
        return rim->y;
    case COLUMN_RIM_z:
        return rim->z;
    case COLUMN_RIM_u:
        return rim->u;
    case COLUMN_RIM_v:
        return rim->v;
    case COLUMN_RIM_p:
        return rim->p;
    case COLUMN_RIM_q:
        return rim->q;
    case COLUMN_RIM_covered:
        return rim->covered;
    default:
        return NULL;
    }
}

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
    const double *shear = column->cells->shear_deg + first;
    for (size_t i = 0; i < count; i++)
        values[i] = derived[column->id](fields->request, shear[i]);
    return true;
}

static size_t rows_of(const struct drape_result *result, enum api_table table) {
    return table == API_TABLE_NODES   ? result->nodes.count
           : table == API_TABLE_CELLS ? result->cells.count
           : table == API_TABLE_FRONT ? result->front.count
           : table == API_TABLE_CUT   ? result->cut.cells.count
                                      : result->rim.count;
}

/* Adds the columns that `id` is stored as, if it is there; `cut`: of the cells that the rim cuts.
 */
static void add(struct api_fields *fields, enum column_id id, bool cut) {
    const struct column_spec *spec = &column_specs[id];
    enum api_table table = cut ? API_TABLE_CUT : spec->table;
    for (int part = 0; part < spec->parts; part++) {
        struct api_column_source source = {.table = table,
                                           .name = spec->part[part],
                                           .integer = column_kind_is_integer(spec->kind),
                                           .rows = rows_of(fields->result, table)};
        if (derived[id] && is_given(fields->request, id)) {
            struct api_derived_column *own = &fields->derived[cut][id];
            *own = (struct api_derived_column){fields, cells_of(fields, cut), id};
            source.fill = fill_derived;
            source.context = own;
        } else {
            source.context = values_of(fields, id, part, cut);
            bool bytes =
                spec->kind == COLUMN_REASON || id == COLUMN_NODES_grown || id == COLUMN_RIM_covered;
            source.fill = spec->kind == COLUMN_INTEGER ? fill_index : bytes ? fill_byte : fill_real;
        }
        if (source.context)
            fields->source[fields->count++] = source;
    }
}

const char *const api_fields_corners[12] = {"x0", "y0", "z0", "x1", "y1", "z1",
                                            "x2", "y2", "z2", "x3", "y3", "z3"};

/* The cells that the rim cuts, which maps alone take from a stored result: their corners, and what
 * whole cells have. */
static void add_cut(struct api_fields *fields) {
    const struct drape_cut *cut = &fields->result->cut;
    if (cut->cells.count == 0)
        return;
    for (int id = 0; id < COLUMN_COUNT; id++)
        if (column_specs[id].table == API_TABLE_CELLS)
            add(fields, (enum column_id)id, true);
    for (int k = 0; k < 12; k++)
        fields->source[fields->count++] = (struct api_column_source){.table = API_TABLE_CUT,
                                                                     .name = api_fields_corners[k],
                                                                     .rows = cut->cells.count,
                                                                     .fill = fill_real,
                                                                     .context = cut->corner[k]};
}

enum status api_fields_list(struct api_fields *fields, const struct api_request *request,
                            const struct drape_result *result, struct arena *arena) {
    *fields = (struct api_fields){.request = request, .result = result};
    enum status status = STATUS_OK;
    for (int cut = 0; cut < 2 && status == STATUS_OK; cut++)
        status = api_permeability_columns(request, cells_of(fields, cut),
                                          api_fields_fiber_volume_fraction, arena,
                                          &fields->permeability[cut]);
    if (status != STATUS_OK)
        return status;
    for (int id = 0; id < COLUMN_COUNT; id++)
        add(fields, (enum column_id)id, false);
    add_cut(fields);
    return STATUS_OK;
}

static double count_flag(enum column_id flag, const struct api_request *request,
                         const struct drape_cells *cells) {
    size_t count = 0;
    if (!is_given(request, flag))
        return -1;
    for (size_t i = 0; i < cells->count; i++)
        count += derived[flag](request, cells->shear_deg[i]) > 0;
    return (double)count;
}

double api_fields_locked(const struct api_request *request, const struct drape_cells *cells) {
    return count_flag(COLUMN_CELLS_locked, request, cells);
}

double api_fields_packing_exceeded(const struct api_request *request,
                                   const struct drape_cells *cells) {
    return count_flag(COLUMN_CELLS_packing_exceeded, request, cells);
}
