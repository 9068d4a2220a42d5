/* SPDX-License-Identifier: MIT */
#include "fields.h"

#include "shear_limit.h"
#include "solver/permeability.h"
#include <math.h>
#include <string.h>

/* ---- one cell; shear in degrees ---- */

/* n t0: the plies of the unsheared fabric */
static double stack_thickness(const struct api_request *request) {
    return request->fabric.plies * request->fabric.thickness;
}

/* t = n t0 A / A0 between flexible faces, else the height: mass conservation. */
static double thickness_of(const struct api_request *request, double shear_deg) {
    const struct api_cavity *cavity = &request->cavity;
    return cavity->rigid ? cavity->height
                         : stack_thickness(request) *
                               permeability_areal_ratio(shear_deg, request->settings.slide);
}

/* Vf = Vf0 between flexible faces, else Vf0 (n t0 / h) A / A0: mass conservation. It may
 * exceed what is possible: `packing_exceeded`. */
double api_fields_fiber_volume_fraction(const struct api_request *request, double shear_deg) {
    const struct api_cavity *cavity = &request->cavity;
    double unsheared = request->fabric.fiber_volume_fraction;
    if (!cavity->rigid)
        return unsheared;
    return unsheared * (stack_thickness(request) / cavity->height) *
           permeability_areal_ratio(shear_deg, request->settings.slide);
}

/* phi = 1 - Vf */
static double porosity_of(const struct api_request *request, double shear_deg) {
    return 1 - api_fields_fiber_volume_fraction(request, shear_deg);
}

static double packing_exceeded(const struct api_request *request, double shear_deg) {
    return api_fields_fiber_volume_fraction(request, shear_deg) >
           api_packing_limit(&request->permeability);
}

static double is_locked(const struct api_request *request, double shear_deg) {
    return shear_limit_locks(&request->fabric, shear_deg);
}

static double severity_of(const struct api_request *request, double shear_deg) {
    return shear_limit_severity(&request->fabric, shear_deg);
}

/* The columns that follow from the shear of a cell. */
static double (*const derived[COLUMN_COUNT])(const struct api_request *request,
                                             double shear_deg) = {
    [COLUMN_CELLS_thickness] = thickness_of,
    [COLUMN_CELLS_fiber_volume_fraction] = api_fields_fiber_volume_fraction,
    [COLUMN_CELLS_porosity] = porosity_of,
    [COLUMN_CELLS_locked] = is_locked,
    [COLUMN_CELLS_severity] = severity_of,
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
        return shear_limit_given(fabric);
    case COLUMN_LIMIT:
        return fabric->limit.rows > 0;
    default:
        return true;
    }
}

/* The cells, or those that the rim cuts. */
static const struct drape_cells *cells_of(const struct api_fields *fields, bool cut) {
    return cut ? &fields->result->cut.cells : &fields->result->cells;
}

/* Where the values of a column that is not derived lie: int32_t of an integer, uint8_t of a reason
 * and of flags that the solver sets, double of others. For each part the offset of the pointer to
 * them in the struct of the table, or in that of the permeability. */
enum owner {
    OWNER_NONE,
    OWNER_NODES,
    OWNER_CELLS,
    OWNER_PERMEABILITY,
    OWNER_FRONT,
    OWNER_RIM,
    OWNER_CUTS,
    OWNER_REQUEST
};

#define AT(TABLE, type, field) [COLUMN_##TABLE##_##field] = {OWNER_##TABLE, {offsetof(type, field)}}
#define NODES(field) AT(NODES, struct drape_nodes, field)
#define FRONT(field) AT(FRONT, struct drape_front, field)
#define RIM(field) AT(RIM, struct drape_rim, field)
#define CUTS(field) AT(CUTS, struct drape_cuts, field)
#define CELLS(field) AT(CELLS, struct drape_cells, field)
#define K(field)                                                                                   \
    [COLUMN_CELLS_##                                                                               \
        field] = {OWNER_PERMEABILITY, {offsetof(struct api_permeability_columns, field)}}
#define VECTOR(column, owner, type, stem)                                                          \
    [COLUMN_CELLS_##column] = {                                                                    \
        owner, {offsetof(type, stem##_x), offsetof(type, stem##_y), offsetof(type, stem##_z)}}

static const struct {
    enum owner owner;
    size_t offset[3];
} stored[COLUMN_COUNT] = {
    NODES(i),
    NODES(j),
    NODES(u),
    NODES(v),
    NODES(face),
    NODES(x),
    NODES(y),
    NODES(z),
    NODES(shear_deg),
    NODES(error_estimate),
    NODES(shear_error_deg),
    NODES(grown),
    CELLS(i),
    CELLS(j),
    CELLS(shear_deg),
    VECTOR(warp, OWNER_CELLS, struct drape_cells, warp),
    VECTOR(weft, OWNER_CELLS, struct drape_cells, weft),
    K(k1),
    K(k2),
    K(k3),
    VECTOR(k1_direction, OWNER_PERMEABILITY, struct api_permeability_columns, k1),
    K(out_of_table),
    FRONT(i),
    FRONT(j),
    FRONT(reason),
    RIM(loop),
    RIM(face),
    RIM(x),
    RIM(y),
    RIM(z),
    RIM(u),
    RIM(v),
    RIM(p),
    RIM(q),
    RIM(covered),
    RIM(cut),
    CUTS(length),
    CUTS(tip_angle_deg),
    CUTS(mouth_width),
    CUTS(area),
    CUTS(covered),
    [COLUMN_CUTS_allowance] = {OWNER_REQUEST, {offsetof(struct api_request, cut_allowances)}},
};

/* ---- columns ---- */

bool api_fields_copy(const void *context, size_t first, size_t count, double *values) {
    memcpy(values, (const double *)context + first, count * sizeof *values);
    return true;
}

bool api_fields_columns(enum column_id first, int count, size_t rows, struct arena *arena,
                        double **values, struct api_column_source *sources) {
    for (int c = 0; c < count; c++) {
        const struct column_spec *spec = &column_specs[(int)first + c];
        values[c] = arena_take(arena, rows, sizeof *values[c]);
        if (!values[c])
            return false;
        sources[c] = (struct api_column_source){.table = spec->table,
                                                .name = spec->name,
                                                .integer = column_kind_is_integer(spec->kind),
                                                .rows = rows,
                                                .fill = api_fields_copy,
                                                .context = values[c]};
    }
    return true;
}

bool api_fields_read_row(const struct api_reader *result, const struct api_columns *columns,
                         enum column_id first, int count, size_t row, double *values) {
    for (int c = 0; c < count; c++) {
        const struct column_spec *spec = &column_specs[(int)first + c];
        const struct api_column *column = api_columns_find(columns, spec->table, spec->name);
        if (!column || !api_columns_read(result, column, row, 1, &values[c]))
            return false;
    }
    return true;
}

static bool fill_index(const void *context, size_t first, size_t count, double *values) {
    for (size_t i = 0; i < count; i++)
        values[i] = ((const int32_t *)context)[first + i];
    return true;
}

static bool fill_number(const void *context, size_t first, size_t count, double *values) {
    (void)context;
    for (size_t i = 0; i < count; i++)
        values[i] = (double)(first + i);
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

/* Adds the columns that `id` is stored as, if it is there; `cut`: of the cells that the rim cuts.
 */
static void list_column(struct api_fields *fields, enum column_id id, bool cut) {
    const struct column_spec *spec = &column_specs[id];
    enum api_table table = cut ? API_TABLE_CUT : spec->table;
    const struct drape_result *result = fields->result;
    size_t rows = table == API_TABLE_NODES   ? result->nodes.count
                  : table == API_TABLE_CELLS ? result->cells.count
                  : table == API_TABLE_FRONT ? result->front.count
                  : table == API_TABLE_CUT   ? result->cut.cells.count
                  : table == API_TABLE_CUTS  ? result->cuts.count
                                             : result->rim.count;
    const void *const owners[] = {[OWNER_NODES] = &result->nodes,
                                  [OWNER_CELLS] = cells_of(fields, cut),
                                  [OWNER_PERMEABILITY] = &fields->permeability[cut],
                                  [OWNER_FRONT] = &result->front,
                                  [OWNER_RIM] = &result->rim,
                                  [OWNER_CUTS] = &result->cuts,
                                  [OWNER_REQUEST] = fields->request};
    const char *owner = owners[stored[id].owner];
    for (int part = 0; part < spec->parts; part++) {
        struct api_column_source source = {.table = table,
                                           .name = spec->part[part],
                                           .integer = column_kind_is_integer(spec->kind),
                                           .rows = rows};
        if (derived[id] && is_given(fields->request, id)) {
            struct api_derived_column *own = &fields->derived[cut][id];
            *own = (struct api_derived_column){fields, cells_of(fields, cut), id};
            source.fill = fill_derived;
            source.context = own;
        } else if (id == COLUMN_CUTS_name) {
            source.fill = fill_number;
            source.context = rows ? fields : NULL;
        } else {
            if (owner)
                memcpy(&source.context, owner + stored[id].offset[part], sizeof source.context);
            bool bytes = spec->kind == COLUMN_REASON ||
                         (spec->kind == COLUMN_FLAG && stored[id].owner != OWNER_PERMEABILITY);
            source.fill = spec->kind == COLUMN_INTEGER ? fill_index
                          : bytes                      ? fill_byte
                                                       : api_fields_copy;
        }
        if (source.context)
            fields->source[fields->count++] = source;
    }
}

const char *const api_fields_corners[12] = {"x0", "y0", "z0", "x1", "y1", "z1",
                                            "x2", "y2", "z2", "x3", "y3", "z3"};

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
        list_column(fields, (enum column_id)id, false);
    /* The cells that the rim cuts, which maps alone take from a stored result: what whole cells
     * have, and their corners. */
    const struct drape_cut *cut = &result->cut;
    for (int id = 0; id < COLUMN_COUNT && cut->cells.count > 0; id++)
        if (column_specs[id].table == API_TABLE_CELLS)
            list_column(fields, (enum column_id)id, true);
    for (int k = 0; k < 12 && cut->cells.count > 0; k++)
        fields->source[fields->count++] = (struct api_column_source){.table = API_TABLE_CUT,
                                                                     .name = api_fields_corners[k],
                                                                     .rows = cut->cells.count,
                                                                     .fill = api_fields_copy,
                                                                     .context = cut->corner[k]};
    return STATUS_OK;
}

double api_fields_count(enum column_id flag, const struct api_request *request,
                        const struct drape_cells *cells) {
    size_t count = 0;
    if (!is_given(request, flag))
        return -1;
    for (size_t i = 0; i < cells->count; i++)
        count += derived[flag](request, cells->shear_deg[i]) > 0;
    return (double)count;
}

double api_fields_most(enum column_id id, const struct api_request *request,
                       const struct drape_cells *cells) {
    double most = -1;
    for (size_t i = 0; i < cells->count && is_given(request, id); i++)
        most = fmax(most, derived[id](request, cells->shear_deg[i]));
    return most;
}

double api_fields_thickness_error(const struct api_request *request,
                                  const struct drape_nodes *nodes) {
    static const double steepest_deg = 89.9;
    double most = 0;
    if (!nodes->shear_error_deg || !is_given(request, COLUMN_CELLS_thickness))
        return -1;
    for (size_t k = 0; k < nodes->count; k++) {
        double shear = fmin(fabs(nodes->shear_deg[k]), steepest_deg);
        double beyond = fmin(shear + nodes->shear_error_deg[k], steepest_deg);
        most = fmax(most, thickness_of(request, beyond) - thickness_of(request, shear));
    }
    return most;
}
