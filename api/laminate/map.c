/* SPDX-License-Identifier: MIT */
#include "map.h"

#include "api/map/cavity.h"
#include "api/map/channel.h"
#include "api/map/map_columns.h"
#include "api/result/permeability.h"
#include "api/result/shear_limit.h"
#include "laser.h"
#include "ply_samples.h"
#include "solver/angle.h"
#include <stdio.h>
#include <string.h>

enum { TENSOR_PARTS = 6 };

/* Beyond so many spacings off its cloth a boundary is called ragged. */
static const double boundary_away = 2;

/* Columns that are filled row by row; NULL where they are left out. */
struct filled {
    double *count, *shear, *thickness, *fraction, *porosity, *pressure;
    double *k1, *k2, *k3, *direction[3], *locked, *severity, *packed, *out_of_table,
        *tensor[TENSOR_PARTS];
    double *distance, *extrapolated;
};

struct mapping {
    struct ply_samples at;
    bool thickness, fraction, law, permeability, locking, limit,
        table; /* what all, or any, plies have */
    struct filled out;
    struct cavity cavity;
    double *relieved[MAP_RELIEFS]; /* as in map_fields; NULL: nothing gives way */
    size_t far;
    double farthest;
};

/* ---- columns ---- */

/* Adds the columns that are wanted; false without memory. */
static bool add_stack_columns(struct mapping *m) {
    struct filled *out = &m->out;
    bool both = m->thickness && m->fraction, permeability = m->permeability;
    const struct {
        bool wanted;
        enum column_id id;
        double **values; /* of each part */
    } columns[] = {{true, COLUMN_CELLS_ply_count, &out->count},
                   {true, COLUMN_CELLS_shear_deg, &out->shear},
                   {m->thickness, COLUMN_CELLS_thickness, &out->thickness},
                   {both, COLUMN_CELLS_fiber_volume_fraction, &out->fraction},
                   {both, COLUMN_CELLS_porosity, &out->porosity},
                   {m->law, COLUMN_CELLS_pressure, &out->pressure},
                   {permeability, COLUMN_CELLS_k1, &out->k1},
                   {permeability, COLUMN_CELLS_k2, &out->k2},
                   {permeability, COLUMN_CELLS_k3, &out->k3},
                   {permeability, COLUMN_CELLS_k1_direction, out->direction},
                   {m->locking, COLUMN_CELLS_locked, &out->locked},
                   {m->limit, COLUMN_CELLS_severity, &out->severity},
                   {both, COLUMN_CELLS_packing_exceeded, &out->packed},
                   {m->table, COLUMN_CELLS_out_of_table, &out->out_of_table},
                   {permeability, COLUMN_CELLS_permeability, out->tensor},
                   {true, COLUMN_CELLS_distance, &out->distance},
                   {true, COLUMN_CELLS_extrapolated, &out->extrapolated}};
    map_columns_ids(m->at.map, m->at.target);
    for (size_t k = 0; k < sizeof columns / sizeof *columns; k++)
        for (int part = 0; columns[k].wanted && part < column_specs[columns[k].id].parts; part++) {
            double *values = map_columns_new(m->at.map, columns[k].id, part, m->at.arena);
            columns[k].values[part] = values;
            if (!values)
                return ply_samples_no_memory(&m->at);
        }
    return true;
}

/* ---- one element ---- */

/* The plies at a element. */
struct gathered {
    size_t count;
    size_t *ply;
    struct stack_ply *pressed;
};

static void gather_plies(const struct mapping *m, size_t element, struct gathered *plies) {
    plies->count = 0;
    for (size_t k = 0; k < m->at.laminate->count; k++) {
        const struct laminate_ply *ply = &m->at.laminate->plies[k];
        const struct api_fabric *fabric = &ply->drape.fabric;
        if (!ply_samples_has(&m->at, k, element))
            continue;
        double shear = m->at.samples[ply->net * m->at.count + element].shear_deg;
        plies->ply[plies->count] = k;
        plies->pressed[plies->count++] = (struct stack_ply){
            .thickness = laminate_layers(ply) * fabric->thickness *
                         permeability_areal_ratio(shear, ply->drape.settings.slide),
            .fraction = fabric->fiber_volume_fraction,
            .a = ply->law.a,
            .b = ply->law.b};
    }
}

static struct vec3 in_space(const struct sample_frame *frame, double x, double y) {
    return vec3_axpy(y, frame->second, vec3_scale(x, frame->first));
}

/* K = k1 d d^T + k2 e e^T + k3 n n^T in global axes, VTK's order. */
static void put_stack_permeability(struct mapping *m, size_t element, const struct stack_sum *sum) {
    static const int axes[TENSOR_PARTS][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {0, 2}};
    const struct sample_frame *frame = &m->at.frames[element];
    struct permeability k = stack_permeability(sum);
    struct vec3 d = in_space(frame, k.along, k.across), e = vec3_cross(frame->normal, d);
    const double v[3][3] = {
        {d.x, d.y, d.z}, {e.x, e.y, e.z}, {frame->normal.x, frame->normal.y, frame->normal.z}};
    const double values[3] = {k.k1, k.k2, k.k3};
    m->out.k1[element] = k.k1;
    m->out.k2[element] = k.k2;
    m->out.k3[element] = k.k3;
    for (int x = 0; x < 3; x++)
        m->out.direction[x][element] = v[0][x];
    for (int part = 0; part < TENSOR_PARTS; part++)
        for (int n = 0; n < 3; n++)
            m->out.tensor[part][element] += values[n] * v[n][axes[part][0]] * v[n][axes[part][1]];
}

/* The flags and the tensors of one ply; on a mesh also its row. */
static void add_ply(struct mapping *m, size_t element, const struct gathered *plies, size_t n,
                    struct stack_sum *sum) {
    const struct laminate_ply *ply = &m->at.laminate->plies[plies->ply[n]];
    const struct api_request *drape = &ply->drape;
    const struct stack_ply *pressed = &plies->pressed[n];
    const struct sample_frame *frame = &m->at.frames[element];
    size_t own = ply->net * m->at.count + element;
    const double *along = m->at.samples[own].warp; /* in the base */
    double shear = m->at.samples[own].shear_deg, side = m->at.mirrored[own] ? -1 : 1;
    /* At right angles to the warp, towards the weft. */
    const double across[2] = {-side * along[1], side * along[0]};
    bool outside = false;
    if (fabs(shear) > fabs(m->out.shear[element]))
        m->out.shear[element] = shear;
    if (shear_limit_locks(&drape->fabric, shear))
        m->out.locked[element] = 1;
    if (drape->fabric.limit.rows > 0)
        m->out.severity[element] =
            fmax(m->out.severity[element], shear_limit_severity(&drape->fabric, shear));
    if (m->out.packed && pressed->fraction > api_packing_limit(&drape->permeability))
        m->out.packed[element] = 1;
    if (m->permeability) {
        struct permeability k = api_permeability_at(&drape->permeability, pressed->fraction, shear,
                                                    drape->settings.slide, &outside);
        stack_add(sum, pressed->thickness, &k, along, across);
    }
    if (outside)
        m->out.out_of_table[element] = 1;
    if (m->at.target->elements) {
        double sine, cosine;
        angle_sincos_deg(shear, &sine, &cosine);
        const struct map_ply row = {.warp = in_space(frame, along[0], along[1]),
                                    .weft = in_space(frame, sine * along[0] + cosine * across[0],
                                                     sine * along[1] + cosine * across[1]),
                                    .shear_deg = shear,
                                    .thickness = m->thickness ? pressed->thickness : 0,
                                    .fiber_volume_fraction = m->fraction ? pressed->fraction : 0};
        map_stack_lay(&m->at.map->stack, (int)plies->ply[n], &row);
    }
}

static void put_element(struct mapping *m, size_t element, struct gathered *plies) {
    struct stack_sum sum = {.thickness = 0};
    double by_itself = 0, whole = 0, fibres = 0;
    /* The porosity where the resin carries a part of the pressure, and the fibres the rest. */
    for (int k = 0; m->relieved[0] && k < MAP_RELIEFS; k++) {
        struct stack_cavity rest = m->at.laminate->cavity;
        double all = 0, solid = 0;
        rest.pressure -= m->at.map->fields.relief[k];
        gather_plies(m, element, plies);
        (void)stack_press(&rest, plies->count, plies->pressed);
        for (size_t n = 0; n < plies->count; n++) {
            all += plies->pressed[n].thickness;
            solid += plies->pressed[n].thickness * plies->pressed[n].fraction;
        }
        m->relieved[k][element] = plies->count ? 1 - solid / all : 0;
    }
    gather_plies(m, element, plies);
    for (size_t n = 0; n < plies->count; n++)
        by_itself += plies->pressed[n].thickness;
    struct stack_cavity cavity = {.kind = STACK_FLEXIBLE};
    if (plies->count) { /* that of the laminate where the target says nothing of it */
        double height = cavity_height(&m->cavity, element, m->at.frames[element].normal);
        m->cavity.open += m->cavity.punch && !(height > 0);
        cavity = height > 0 ? (struct stack_cavity){.kind = STACK_HEIGHT, .height = height}
                            : m->at.laminate->cavity;
    }
    double pressure = m->thickness ? stack_press(&cavity, plies->count, plies->pressed) : 0;
    for (size_t n = 0; n < plies->count; n++) {
        whole += plies->pressed[n].thickness;
        fibres += plies->pressed[n].thickness * plies->pressed[n].fraction;
        add_ply(m, element, plies, n, &sum);
    }
    m->out.count[element] = (double)plies->count;
    m->out.distance[element] = m->at.distance[element];
    m->out.extrapolated[element] = plies->count == 0;
    if (m->out.thickness)
        m->out.thickness[element] = whole;
    if (m->out.fraction) {
        m->out.fraction[element] = plies->count ? fibres / whole : 0;
        m->out.porosity[element] = 1 - m->out.fraction[element];
        m->cavity.packed += m->out.packed[element] > 0;
    }
    if (m->out.pressure)
        m->out.pressure[element] = pressure;
    if (m->permeability && plies->count)
        put_stack_permeability(m, element, &sum);
    m->cavity.loose += cavity.kind == STACK_HEIGHT && cavity.height > by_itself;
    m->far += m->at.distance[element] > m->at.spacing && m->at.distance[element] > whole;
    m->farthest = fmax(m->farthest, m->at.distance[element]);
}

/* ---- the whole ---- */

/* Of plies that failed, of points that are far off, and of boundaries. */
static void warn_of_plies(struct mapping *m) {
    char text[API_MAP_WARNING_SIZE];
    size_t failed = 0, length = 0;
    const struct laminate *laminate = m->at.laminate;
    const struct map_stack *stack = &m->at.map->stack;
    const char *unit = m->at.map->fields.unit->name;
    size_t bare = m->at.target->elements ? map_stack_bare(stack) : 0, worst = 0, far = 0;
    if (m->at.target->warning)
        map_warn_text(m->at.map, m->at.target->warning);
    for (size_t k = 0; k < laminate->count; k++) {
        far += m->at.away[k] > boundary_away * m->at.spacing;
        worst = m->at.away[k] > m->at.away[worst] ? k : worst;
        if (m->at.there[laminate->plies[k].net])
            continue;
        char title[LAMINATE_TITLE_SIZE];
        laminate_title(&laminate->plies[k], title);
        failed++;
        if (length < API_MAP_WARNING_SIZE / 2)
            length += (size_t)snprintf(text + length, API_MAP_WARNING_SIZE - length,
                                       "%s%zu (\"%.40s\")", failed == 1 ? "no drape of ply " : ", ",
                                       laminate->plies[k].number + 1, title);
    }
    if (failed && length < API_MAP_WARNING_SIZE)
        (void)snprintf(text + length, API_MAP_WARNING_SIZE - length,
                       ": %zu of %zu plies are left out", failed, laminate->count);
    if (failed)
        map_warn(m->at.map, "%s", text);
    if (m->far > m->at.count / 2)
        map_warn(m->at.map,
                 "%zu of %zu points are further from the plies than their spacing and thickness, "
                 "up to %.3g %s: check their length unit and their position",
                 m->far, m->at.count, m->farthest, unit);
    else if (bare)
        map_warn(m->at.map,
                 "%zu of %zu elements have no ply: the middles of %zu lie beyond every ply, and "
                 "%zu have no area",
                 bare, m->at.count, bare - stack->flat, stack->flat);
    /* A boundary is projected on the cloth: where it lies far from it, as a polygon of few points
     * does on what is curved, its element there is a matter of chance. */
    if (far)
        map_warn(m->at.map,
                 "the boundary of ply %zu (\"%.40s\") lies up to %.3g %s off its cloth, and %zu of "
                 "its %zu points by more than twice the spacing: its projection may be wrong. Give "
                 "the boundary more points",
                 worst + 1, laminate->plies[worst].name, m->at.away[worst], unit, far,
                 laminate->count);
}

/* Names for cards, in which each has to be another: one that was there before gets its number. */
static const char *const *unique_names(struct mapping *m) {
    const struct laminate *laminate = m->at.laminate;
    const char **names = arena_alloc(m->at.arena, laminate->count, sizeof *names);
    enum { SIZE = LAMINATE_TITLE_SIZE + 16 };
    for (size_t k = 0; names && k < laminate->count; k++) {
        char *own = arena_alloc(m->at.arena, SIZE, 1);
        bool again = false;
        char title[LAMINATE_TITLE_SIZE], other[LAMINATE_TITLE_SIZE];
        if (!own)
            return NULL;
        laminate_title(&laminate->plies[k], title);
        for (size_t n = 0; n < k; n++) {
            laminate_title(&laminate->plies[n], other);
            again = again || strcmp(other, title) == 0;
        }
        (void)snprintf(own, SIZE, again ? "%s_%zu" : "%s", title, k + 1);
        names[k] = own;
    }
    return names;
}

/* Of each ply and piece its numbers in the request, in `numbers`; false without memory. They stay
 * NULL where all plies are of one piece. */
static bool number_pieces(struct mapping *m, const int (**numbers)[2]) {
    const struct laminate *laminate = m->at.laminate;
    *numbers = NULL;
    if (laminate->count == laminate->ply_count)
        return true;
    int(*own)[2] = arena_alloc(m->at.arena, laminate->count, sizeof *own);
    for (size_t k = 0; own && k < laminate->count; k++) {
        own[k][0] = (int)laminate->plies[k].number + 1;
        own[k][1] = laminate->plies[k].pieces ? (int)laminate->plies[k].piece + 1 : 0;
    }
    *numbers = (const int(*)[2])own;
    return own;
}

/* All elements; on a mesh with the rows of the plies. */
static bool map_elements(struct mapping *m) {
    const struct laminate *laminate = m->at.laminate;
    struct map_fields *fields = &m->at.map->fields;
    struct map_stack *stack = &m->at.map->stack;
    bool rows = m->at.target->elements != NULL;
    struct gathered plies = {.ply = arena_alloc(m->at.arena, laminate->count, sizeof *plies.ply),
                             .pressed =
                                 arena_alloc(m->at.arena, laminate->count, sizeof *plies.pressed)};
    struct map_plies kept = {.ply_count = laminate->count,
                             .side = laminate->side,
                             .names = rows ? unique_names(m) : NULL,
                             .thickness = m->thickness,
                             .fraction = m->fraction};
    struct map_ply_kind *kinds = arena_alloc(m->at.arena, laminate->count, sizeof *kinds);
    kept.kinds = kinds;
    for (size_t k = 0; kinds && k < laminate->count; k++)
        kinds[k] = map_ply_kind_of(&laminate->plies[k].drape);
    if (!kinds || !plies.ply || !plies.pressed || !number_pieces(m, &kept.numbers) ||
        (rows &&
         (!kept.names || !map_stack_begin(stack, m->at.target, &kept, m->at.rows, m->at.arena))))
        return ply_samples_no_memory(&m->at);
    for (size_t element = 0; element < m->at.count; element++) {
        if (rows && map_stack_next(stack, element, m->at.problem) != API_OK)
            return false;
        put_element(m, element, &plies);
        if (!ply_samples_go_on(&m->at, element, 1))
            return false;
    }
    if (rows) {
        fields->plies = &stack->plies;
        fields->column_count += map_stack_end(stack, m->at.map->columns + fields->column_count);
    }
    return true;
}

/* The laminate's rosette, of which a z that is not given is the normal, on the side of the plies,
 * where the first net starts. */
static bool note_rosette(struct mapping *m, const struct api_reader *const *nets) {
    const struct laminate *laminate = m->at.laminate;
    struct arena *arena = m->at.arena;
    const struct drape_zero *zero = &laminate->plies[0].drape.settings.zero;
    size_t net = 0;
    if (zero->kind != DRAPE_ZERO_ROSETTE)
        return true;
    while (net + 1 < laminate->net_count && !nets[net])
        net++;
    struct api_rosette *rosette = arena_alloc(arena, 1, sizeof *rosette);
    struct arena_mark mark = arena_mark(arena);
    struct api_columns *columns = arena_alloc(arena, 1, sizeof *columns);
    if (!rosette || !columns)
        return ply_samples_no_memory(&m->at);
    if (api_columns_open(nets[net], columns, m->at.problem) != API_OK)
        return false;
    *rosette = columns->start.rosette;
    if (vec3_norm2(zero->z) == 0)
        rosette->z = vec3_scale(laminate->side, rosette->z);
    m->at.map->fields.rosette = rosette;
    arena_rewind(arena, mark);
    return true;
}

enum api_problem_id laminate_map(const struct laminate *laminate,
                                 const struct api_reader *const *nets,
                                 const struct map_target *target,
                                 const struct drape_monitor *monitor, struct arena *arena,
                                 struct api_map *map, struct api_problem *problem) {
    struct mapping m = {.at = {.laminate = laminate,
                               .target = target,
                               .monitor = monitor,
                               .map = map,
                               .arena = arena,
                               .problem = problem,
                               .count = target->element_count}};
    static const double shares[MAP_RELIEFS] = {0.4, 0.8}; /* of the pressure */
    const struct stack_cavity *cavity = &laminate->cavity;
    memset(map, 0, sizeof *map);
    map->fields = map_target_fields(target, map->columns);
    char *revision = arena_alloc(arena, API_ID_SIZE, 1);
    if (!revision)
        return api_problem_no_memory(problem, "the map");
    map->fields.revision = memcpy(revision, laminate->revision, API_ID_SIZE);
    /* Of plies that say nothing of a property, nothing can be said of the stack. */
    m.thickness = m.fraction = m.permeability = true;
    for (size_t k = 0; k < laminate->count; k++) {
        const struct api_request *drape = &laminate->plies[k].drape;
        m.thickness = m.thickness && drape->fabric.thickness > 0;
        m.fraction = m.fraction && drape->fabric.fiber_volume_fraction > 0;
        m.permeability = m.permeability && drape->permeability.model != API_PERMEABILITY_NONE;
        m.table = m.table || drape->permeability.model == API_PERMEABILITY_TABLE;
        m.locking = m.locking || shear_limit_given(&drape->fabric);
        m.limit = m.limit || drape->fabric.limit.rows > 0;
        m.law = m.law || laminate->plies[k].law.a > 0;
    }
    m.permeability = m.permeability && m.thickness;
    m.law = m.law && (cavity->kind != STACK_FLEXIBLE || cavity_given(target));
    if (cavity_given(target) && !m.thickness)
        return api_problem_set(problem, API_INVALID_REQUEST,
                               "heights of the cavity need the fabric.thickness of every ply");
    if (!cavity_begin(&m.cavity, target, arena))
        return api_problem_no_memory(problem, "the map");
    /* Under a pressure plies with a law give way to the resin. */
    bool gives = m.law && m.thickness && m.fraction && cavity->kind == STACK_PRESSURE;
    for (int k = 0; gives && !cavity_given(target) && k < MAP_RELIEFS; k++) {
        m.relieved[k] = arena_alloc(arena, m.at.count, sizeof *m.relieved[k]);
        if (!m.relieved[k])
            return api_problem_no_memory(problem, "the map");
        map->fields.relieved[k] = m.relieved[k];
        map->fields.relief[k] = shares[k] * cavity->pressure;
    }
    if (!ply_samples_read(&m.at, nets) || !add_stack_columns(&m) || !map_elements(&m))
        return problem->id;
    if (!note_rosette(&m, nets))
        return problem->id;
    if (target->elements && target->wants_outlines &&
        laser_outlines(laminate, nets, arena, &map->stack.plies.outlines, problem) != API_OK)
        return problem->id;
    map_channel_fill(target, (double *const[]){m.out.k1, m.out.k2, m.out.k3}, m.out.tensor, map);
    warn_of_plies(&m);
    cavity_warn(&m.cavity, map, "laminate");
    return API_OK;
}
