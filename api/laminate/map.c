/* SPDX-License-Identifier: MIT */
#include "map.h"

#include "api/map/cavity.h"
#include "api/map/channel.h"
#include "api/map/map_columns.h"
#include "api/map/net.h"
#include "api/result/permeability.h"
#include "region.h"
#include "solver/angle.h"
#include <stdio.h>
#include <string.h>

enum { ASK_EVERY = 1024, TENSOR_PARTS = 6 };

/* What a net says at an element. */
struct spot {
    double shear_deg; /* NaN: the net does not reach it */
    double warp[2];   /* the unit warp in the element's base */
};

/* Where the first net reaches an element: two directions of its tangent plane, their normal, the
 * place, and how far that net's surface was moved. */
struct base {
    struct vec3 first, second, normal; /* zero: no net has reached the element */
    struct vec3 foot;
    double height;
};

/* Columns that are filled row by row; NULL where they are left out. */
struct filled {
    double *count, *shear, *thickness, *fraction, *porosity, *pressure;
    double *k1, *k2, *k3, *direction[3], *locked, *packed, *out_of_table, *tensor[TENSOR_PARTS];
    double *distance, *extrapolated;
};

struct mapping {
    const struct laminate *laminate;
    const struct map_target *target;
    const struct drape_monitor *monitor;
    struct api_map *map;
    struct arena *arena;
    struct api_problem *problem;
    size_t count; /* places */
    struct base *bases;
    struct spot *spots; /* [net][place] */
    uint8_t *mirrored;  /* alike: the net's normal is against the base's */
    uint8_t **inside;   /* of each ply with a boundary, by place; else NULL */
    bool *there;        /* of each net */
    double *distance;   /* of each place: to the nearest net */
    size_t rows;        /* plies at places, together */
    bool thickness, fraction, law, permeability, locking, table; /* what all, or any, plies have */
    struct filled out;
    const struct punch *punch;     /* NULL: there is none */
    double *relieved[MAP_RELIEFS]; /* as in map_fields; NULL: nothing gives way */
    size_t packed, loose, far, open;
    bool channelled;
    double spacing, farthest;
};

static bool no_memory(struct mapping *m) {
    api_problem_set(m->problem, API_OUT_OF_MEMORY, "the map needs more memory than allowed");
    return false;
}

static bool go_on(struct mapping *m, size_t done, double share) {
    if (done % ASK_EVERY != 0 || !m->monitor || m->monitor->progress(m->monitor->context, share))
        return true;
    api_problem_set(m->problem, API_CANCELLED, "the map was cancelled");
    return false;
}

/* ---- one net ---- */

/* Where the plies of this net have a boundary. */
struct bounded {
    struct region region;
    uint8_t *inside;
};

static bool make_regions(struct mapping *m, size_t net, const struct map_net *cloth,
                         struct bounded *bounded, size_t *count) {
    *count = 0;
    for (size_t k = 0; k < m->laminate->count; k++) {
        const struct laminate_ply *ply = &m->laminate->plies[k];
        struct vec3 at;
        if (ply->net != net || ply->boundary.count == 0)
            continue;
        struct bounded *own = &bounded[(*count)++];
        own->inside = m->inside[k];
        switch (region_make(&ply->boundary, cloth->facets, cloth->columns.grid.spacing, m->arena,
                            &own->region, &at)) {
        case STATUS_OK:
            break;
        case STATUS_OUT_OF_MEMORY:
            return no_memory(m);
        default:
            api_problem_set(m->problem, API_INVALID_REQUEST,
                            "the boundary of ply %zu (\"%s\") cannot be followed on its cloth near "
                            "(%.6g, %.6g, %.6g): the cloth ends there, or the boundary is too far "
                            "from it; start the ply inside its boundary, or give more points of it",
                            k + 1, ply->name, at.x, at.y, at.z);
            return false;
        }
    }
    return true;
}

static double height_of(const struct mapping *m, size_t net) {
    return m->laminate->plies[m->laminate->net_ply[net]].drape.offset;
}

/* The first net to reach a place gives it its base. */
static struct base *base_at(struct mapping *m, size_t net, size_t place,
                            const struct facets_place *at, struct vec3 warp, struct vec3 weft) {
    struct base *base = &m->bases[place];
    if (vec3_norm2(base->normal) > 0)
        return base;
    base->first = warp;
    base->second = permeability_across(warp, weft);
    base->normal = vec3_unit(vec3_cross(base->first, base->second));
    base->foot = at->r;
    base->height = height_of(m, net);
    return base;
}

/* The place of a net nearest to a point. Surfaces that are moved along their normal have the foot
 * of one normal in common: what was found on the first net is moved by what lies between, so that
 * the search begins next to its end. `sense` is the side of that normal that heights count to: 0
 * until it is known. Beside a rim, and where that leads beyond it, the point itself is taken. */
static void find_place(struct mapping *m, size_t net, size_t place, const struct map_net *cloth,
                       struct vec3 point, double *sense, struct facets_place *at) {
    const struct base *base = &m->bases[place];
    bool known = vec3_norm2(base->normal) > 0;
    double between = height_of(m, net) - base->height;
    if (known && *sense != 0) {
        struct vec3 over = vec3_axpy(*sense * between, base->normal, base->foot);
        facets_nearest(cloth->facets, over, at->cell, at);
        at->distance = vec3_distance(point, at->r);
        if (!at->outside && !map_net_is_beyond(cloth, at))
            return;
    }
    facets_nearest(cloth->facets, point, at->cell, at);
    if (known && *sense == 0)
        *sense = between * vec3_dot(vec3_sub(at->r, base->foot), base->normal) < 0 ? -1 : 1;
}

static void note_spot(struct mapping *m, size_t net, size_t place, const struct map_net *cloth,
                      const struct facets_place *at, size_t shear) {
    size_t own = net * m->count + place;
    double values[API_COLUMNS_MAX];
    struct vec3 warp, weft;
    map_net_interpolate(cloth, at, values);
    map_net_yarns(cloth, at, values, &warp, &weft);
    const struct base *base = base_at(m, net, place, at, warp, weft);
    m->spots[own].shear_deg = values[shear];
    double x = vec3_dot(warp, base->first), y = vec3_dot(warp, base->second);
    double size = sqrt(x * x + y * y);
    m->spots[own].warp[0] = size > 0 ? x / size : 1;
    m->spots[own].warp[1] = size > 0 ? y / size : 0;
    m->mirrored[own] = vec3_dot(vec3_cross(warp, weft), base->normal) < 0;
}

static bool place_all(struct mapping *m, size_t net, const struct map_net *cloth, size_t shear,
                      const struct bounded *bounded, size_t bounded_count) {
    struct facets_place at = {.cell = 0};
    double nets = (double)m->laminate->net_count, sense = 0;
    for (size_t place = 0; place < m->count; place++) {
        struct vec3 point = map_target_place(m->target, place);
        double pq[2];
        if (!go_on(m, place, ((double)net + (double)place / (double)m->count) / nets))
            return false;
        find_place(m, net, place, cloth, point, &sense, &at);
        m->distance[place] = fmin(m->distance[place], at.distance);
        m->spots[net * m->count + place].shear_deg = NAN;
        if (map_net_is_beyond(cloth, &at))
            continue;
        note_spot(m, net, place, cloth, &at, shear);
        if (bounded_count)
            region_coordinates(cloth->facets, &at, pq);
        for (size_t k = 0; k < bounded_count; k++)
            bounded[k].inside[place] = region_contains(&bounded[k].region, pq);
    }
    return true;
}

/* The channel along the rim of the first net, where the target asks for one. */
static bool mark_channel(struct mapping *m, const struct api_reader *reader,
                         const struct map_net *cloth) {
    size_t marked;
    bool wanted = m->target->has_gate[MAP_CHANNEL] && !m->channelled;
    m->channelled = true;
    return !wanted || map_channel_mark(m->target, reader, &cloth->columns, m->arena, &marked,
                                       m->problem) == API_OK;
}

static bool read_net(struct mapping *m, size_t net, const struct api_reader *reader) {
    static const enum column_id kept[] = {COLUMN_CELLS_shear_deg, COLUMN_CELLS_warp,
                                          COLUMN_CELLS_weft};
    struct arena_mark mark = arena_mark(m->arena);
    struct map_net *cloth = arena_alloc(m->arena, 1, sizeof *cloth);
    struct bounded *bounded = arena_alloc(m->arena, m->laminate->count, sizeof *bounded);
    size_t count;
    if (!cloth || !bounded)
        return no_memory(m);
    if (map_net_open(reader, cloth, m->problem) != API_OK)
        return false;
    map_net_keep(cloth, kept, sizeof kept / sizeof *kept);
    size_t shear = cloth->group[0].place;
    m->spacing = fmax(m->spacing, cloth->spacing);
    m->map->fields.unit = cloth->columns.unit;
    bool good = map_net_load(reader, m->monitor, m->arena, cloth, m->problem) == API_OK &&
                mark_channel(m, reader, cloth) && make_regions(m, net, cloth, bounded, &count) &&
                place_all(m, net, cloth, shear, bounded, count);
    arena_rewind(m->arena, mark);
    return good;
}

/* Whether ply k lies at a place. */
static bool lies(const struct mapping *m, size_t k, size_t place) {
    size_t net = m->laminate->plies[k].net;
    if (!m->there[net] || isnan(m->spots[net * m->count + place].shear_deg))
        return false;
    return !m->inside[k] || m->inside[k][place];
}

/* A net without a cell reaches nothing. */
static bool read_nets(struct mapping *m, const struct api_reader *const *nets) {
    const struct laminate *laminate = m->laminate;
    bool any = false;
    for (size_t net = 0; net < laminate->net_count; net++) {
        m->there[net] = nets[net] != NULL;
        any = any || m->there[net];
        if (m->there[net] && !read_net(m, net, nets[net]))
            return false;
    }
    for (size_t k = 0; k < laminate->count; k++)
        for (size_t place = 0; place < m->count; place++)
            m->rows += lies(m, k, place);
    if (!any)
        api_problem_set(m->problem, API_INVALID_REQUEST,
                        "no ply of the laminate could be draped, so there is nothing to map");
    return any;
}

/* ---- columns ---- */

/* Adds the parts of a column if it is wanted; false without memory. */
static bool add(struct mapping *m, bool wanted, enum column_id id, double **values) {
    for (int part = 0; wanted && part < column_specs[id].parts; part++) {
        values[part] = map_columns_new(m->map, id, part, m->arena);
        if (!values[part])
            return no_memory(m);
    }
    return true;
}

static bool add_columns(struct mapping *m) {
    struct filled *out = &m->out;
    bool both = m->thickness && m->fraction;
    map_columns_ids(m->map, m->target);
    return add(m, true, COLUMN_CELLS_ply_count, &out->count) &&
           add(m, true, COLUMN_CELLS_shear_deg, &out->shear) &&
           add(m, m->thickness, COLUMN_CELLS_thickness, &out->thickness) &&
           add(m, both, COLUMN_CELLS_fiber_volume_fraction, &out->fraction) &&
           add(m, both, COLUMN_CELLS_porosity, &out->porosity) &&
           add(m, m->law, COLUMN_CELLS_pressure, &out->pressure) &&
           add(m, m->permeability, COLUMN_CELLS_k1, &out->k1) &&
           add(m, m->permeability, COLUMN_CELLS_k2, &out->k2) &&
           add(m, m->permeability, COLUMN_CELLS_k3, &out->k3) &&
           add(m, m->permeability, COLUMN_CELLS_k1_direction, out->direction) &&
           add(m, m->locking, COLUMN_CELLS_locked, &out->locked) &&
           add(m, both, COLUMN_CELLS_packing_exceeded, &out->packed) &&
           add(m, m->table, COLUMN_CELLS_out_of_table, &out->out_of_table) &&
           add(m, m->permeability, COLUMN_CELLS_permeability, out->tensor) &&
           add(m, true, COLUMN_CELLS_distance, &out->distance) &&
           add(m, true, COLUMN_CELLS_extrapolated, &out->extrapolated);
}

/* ---- one place ---- */

static bool has_heights(const struct mapping *m) {
    return m->target->heights || m->target->punch_count;
}

/* Of plies that say nothing of a property, nothing can be said of the stack. */
static void find_properties(struct mapping *m) {
    const struct laminate *laminate = m->laminate;
    m->thickness = m->fraction = m->permeability = true;
    for (size_t k = 0; k < laminate->count; k++) {
        const struct api_request *drape = &laminate->plies[k].drape;
        m->thickness = m->thickness && drape->fabric.thickness > 0;
        m->fraction = m->fraction && drape->fabric.fiber_volume_fraction > 0;
        m->permeability = m->permeability && drape->permeability.model != API_PERMEABILITY_NONE;
        m->table = m->table || drape->permeability.model == API_PERMEABILITY_TABLE;
        m->locking = m->locking || drape->fabric.locking_angle_deg >= 0;
        m->law = m->law || laminate->plies[k].a > 0;
    }
    m->permeability = m->permeability && m->thickness;
    m->law = m->law && (laminate->cavity.kind != STACK_FLEXIBLE || has_heights(m));
}

/* The plies at a place. */
struct gathered {
    size_t count;
    size_t *ply;
    struct stack_ply *pressed;
};

static void gather(const struct mapping *m, size_t place, struct gathered *plies) {
    plies->count = 0;
    for (size_t k = 0; k < m->laminate->count; k++) {
        const struct laminate_ply *ply = &m->laminate->plies[k];
        const struct api_fabric *fabric = &ply->drape.fabric;
        if (!lies(m, k, place))
            continue;
        double shear = m->spots[ply->net * m->count + place].shear_deg;
        plies->ply[plies->count] = k;
        plies->pressed[plies->count++] = (struct stack_ply){
            .thickness = laminate_layers(ply) * fabric->thickness * permeability_areal_ratio(shear),
            .fraction = fabric->fiber_volume_fraction,
            .a = ply->a,
            .b = ply->b};
    }
}

/* The warp of a ply in the base, and the direction at right angles to it towards the weft. */
static void frame_of(const struct spot *spot, bool mirrored, double along[2], double across[2]) {
    double side = mirrored ? -1 : 1;
    along[0] = spot->warp[0];
    along[1] = spot->warp[1];
    across[0] = -side * along[1];
    across[1] = side * along[0];
}

static struct vec3 in_space(const struct base *base, double x, double y) {
    return vec3_axpy(y, base->second, vec3_scale(x, base->first));
}

static void lay(struct mapping *m, size_t place, const struct gathered *plies, size_t n) {
    size_t k = plies->ply[n], own = m->laminate->plies[k].net * m->count + place;
    const struct spot *spot = &m->spots[own];
    const struct base *base = &m->bases[place];
    double along[2], across[2], sine, cosine;
    frame_of(spot, m->mirrored[own], along, across);
    angle_sincos_deg(spot->shear_deg, &sine, &cosine);
    const struct map_ply row = {.warp = in_space(base, along[0], along[1]),
                                .weft = in_space(base, sine * along[0] + cosine * across[0],
                                                 sine * along[1] + cosine * across[1]),
                                .shear_deg = spot->shear_deg,
                                .thickness = m->thickness ? plies->pressed[n].thickness : 0,
                                .fiber_volume_fraction =
                                    m->fraction ? plies->pressed[n].fraction : 0};
    map_stack_lay(&m->map->stack, (int)k, &row);
}

/* K = k1 d d^T + k2 e e^T + k3 n n^T in global axes, VTK's order. */
static void put_permeability(struct mapping *m, size_t place, const struct stack_sum *sum) {
    static const int axes[TENSOR_PARTS][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {0, 2}};
    const struct base *base = &m->bases[place];
    struct permeability k = stack_permeability(sum);
    struct vec3 d = in_space(base, k.along, k.across), e = vec3_cross(base->normal, d);
    const double v[3][3] = {
        {d.x, d.y, d.z}, {e.x, e.y, e.z}, {base->normal.x, base->normal.y, base->normal.z}};
    const double values[3] = {k.k1, k.k2, k.k3};
    m->out.k1[place] = k.k1;
    m->out.k2[place] = k.k2;
    m->out.k3[place] = k.k3;
    for (int x = 0; x < 3; x++)
        m->out.direction[x][place] = v[0][x];
    for (int part = 0; part < TENSOR_PARTS; part++)
        for (int n = 0; n < 3; n++)
            m->out.tensor[part][place] += values[n] * v[n][axes[part][0]] * v[n][axes[part][1]];
}

/* The flags and the tensors of one ply. */
static void add_ply(struct mapping *m, size_t place, const struct gathered *plies, size_t n,
                    struct stack_sum *sum) {
    const struct laminate_ply *ply = &m->laminate->plies[plies->ply[n]];
    const struct api_request *drape = &ply->drape;
    size_t own = ply->net * m->count + place;
    const struct stack_ply *pressed = &plies->pressed[n];
    double shear = m->spots[own].shear_deg, along[2], across[2];
    bool outside = false;
    if (fabs(shear) > fabs(m->out.shear[place]))
        m->out.shear[place] = shear;
    if (drape->fabric.locking_angle_deg >= 0 && fabs(shear) > drape->fabric.locking_angle_deg)
        m->out.locked[place] = 1;
    if (m->out.packed && pressed->fraction > api_packing_limit(&drape->permeability))
        m->out.packed[place] = 1;
    if (!m->permeability)
        return;
    struct permeability k =
        api_permeability_at(&drape->permeability, pressed->fraction, shear, &outside);
    frame_of(&m->spots[own], m->mirrored[own], along, across);
    stack_add(sum, pressed->thickness, &k, along, across);
    if (outside)
        m->out.out_of_table[place] = 1;
}

/* The cavity at a place: that of the laminate where the target says nothing of it. */
static struct stack_cavity cavity_at(struct mapping *m, size_t place) {
    const struct stack_cavity *whole = &m->laminate->cavity;
    double height = m->target->heights ? m->target->heights[place] : 0;
    if (m->punch) {
        height = punch_height(m->punch, map_target_place(m->target, place), m->bases[place].normal);
        m->open += height > 0 ? 0 : 1;
    }
    return height > 0 ? (struct stack_cavity){.kind = STACK_HEIGHT, .height = height} : *whole;
}

/* The porosity where the resin carries a part of the pressure, and the fibres the rest. */
static void put_relieved(struct mapping *m, size_t place, struct gathered *plies) {
    for (int k = 0; k < MAP_RELIEFS; k++) {
        struct stack_cavity rest = m->laminate->cavity;
        double whole = 0, fibres = 0;
        rest.pressure -= m->map->fields.relief[k];
        gather(m, place, plies);
        (void)stack_press(&rest, plies->count, plies->pressed);
        for (size_t n = 0; n < plies->count; n++) {
            whole += plies->pressed[n].thickness;
            fibres += plies->pressed[n].thickness * plies->pressed[n].fraction;
        }
        m->relieved[k][place] = plies->count ? 1 - fibres / whole : 0;
    }
}

static void put_place(struct mapping *m, size_t place, struct gathered *plies) {
    struct stack_sum sum = {.thickness = 0};
    double by_itself = 0, whole = 0, fibres = 0;
    if (m->relieved[0])
        put_relieved(m, place, plies);
    gather(m, place, plies);
    for (size_t n = 0; n < plies->count; n++)
        by_itself += plies->pressed[n].thickness;
    const struct stack_cavity cavity =
        plies->count ? cavity_at(m, place) : (struct stack_cavity){.kind = STACK_FLEXIBLE};
    double pressure = m->thickness ? stack_press(&cavity, plies->count, plies->pressed) : 0;
    for (size_t n = 0; n < plies->count; n++) {
        whole += plies->pressed[n].thickness;
        fibres += plies->pressed[n].thickness * plies->pressed[n].fraction;
        add_ply(m, place, plies, n, &sum);
        if (m->target->elements)
            lay(m, place, plies, n);
    }
    m->out.count[place] = (double)plies->count;
    m->out.distance[place] = m->distance[place];
    m->out.extrapolated[place] = plies->count == 0;
    if (m->out.thickness)
        m->out.thickness[place] = whole;
    if (m->out.fraction) {
        m->out.fraction[place] = plies->count ? fibres / whole : 0;
        m->out.porosity[place] = 1 - m->out.fraction[place];
        m->packed += m->out.packed[place] > 0;
    }
    if (m->out.pressure)
        m->out.pressure[place] = pressure;
    if (m->permeability && plies->count)
        put_permeability(m, place, &sum);
    m->loose += cavity.kind == STACK_HEIGHT && cavity.height > by_itself;
    m->far += m->distance[place] > m->spacing && m->distance[place] > whole;
    m->farthest = fmax(m->farthest, m->distance[place]);
}

static bool put_all(struct mapping *m) {
    struct gathered plies = {.ply = arena_alloc(m->arena, m->laminate->count, sizeof *plies.ply),
                             .pressed =
                                 arena_alloc(m->arena, m->laminate->count, sizeof *plies.pressed)};
    if (!plies.ply || !plies.pressed)
        return no_memory(m);
    for (size_t place = 0; place < m->count; place++) {
        if (m->target->elements && !map_stack_next(&m->map->stack, place, m->problem))
            return false;
        put_place(m, place, &plies);
        if (!go_on(m, place, 1))
            return false;
    }
    return true;
}

/* ---- the whole ---- */

static void warn_of_failed(struct mapping *m) {
    char *text = m->map->failed;
    size_t failed = 0, length = 0;
    for (size_t k = 0; k < m->laminate->count; k++) {
        if (m->there[m->laminate->plies[k].net])
            continue;
        failed++;
        if (length < API_MAP_WARNING_SIZE / 2)
            length += (size_t)snprintf(text + length, API_MAP_WARNING_SIZE - length,
                                       "%s%zu (\"%.40s\")", failed == 1 ? "no drape of ply " : ", ",
                                       k + 1, m->laminate->plies[k].name);
    }
    if (failed && length < API_MAP_WARNING_SIZE)
        (void)snprintf(text + length, API_MAP_WARNING_SIZE - length,
                       ": %zu of %zu plies are left out", failed, m->laminate->count);
    if (failed)
        map_warn(m->map, text);
}

static void warn_of_places(struct mapping *m) {
    size_t bare = m->target->elements ? map_stack_bare(&m->map->stack) : 0;
    if (m->far > m->count / 2) {
        (void)snprintf(m->map->too_far, API_MAP_WARNING_SIZE,
                       "%zu of %zu places lie further from the plies than their spacing and "
                       "thickness, up to %.3g %s: are they in the laminate's length unit and "
                       "position?",
                       m->far, m->count, m->farthest, m->map->fields.unit->name);
        map_warn(m->map, m->map->too_far);
    } else if (bare) {
        (void)snprintf(m->map->bare, API_MAP_WARNING_SIZE,
                       "%zu of %zu elements have no ply: the middle of %zu lies beyond all of "
                       "them, and %zu have no area",
                       bare, m->count, bare - m->map->stack.flat, m->map->stack.flat);
        map_warn(m->map, m->map->bare);
    }
}

static void warn_of_pressing(struct mapping *m) {
    if (m->packed) {
        (void)snprintf(m->map->packed, API_MAP_WARNING_SIZE,
                       "packing_exceeded: at %zu of %zu places a ply has more fibres than can be "
                       "packed: the cavity is too thin, or the pressure too high",
                       m->packed, m->count);
        map_warn(m->map, m->map->packed);
    }
    if (m->loose) {
        (void)snprintf(m->map->loose, API_MAP_WARNING_SIZE,
                       "at %zu of %zu places the plies by themselves are thinner than the cavity: "
                       "they would not fill it",
                       m->loose, m->count);
        map_warn(m->map, m->map->loose);
    }
    if (m->open) {
        (void)snprintf(m->map->open, API_MAP_WARNING_SIZE,
                       "the punch is not above %zu of %zu places, within a tenth of its size: they "
                       "have the laminate's own cavity",
                       m->open, m->count);
        map_warn(m->map, m->map->open);
    }
}

static bool begin_cavity(struct mapping *m) {
    if (has_heights(m) && !m->thickness) {
        api_problem_set(m->problem, API_INVALID_REQUEST,
                        "heights of the cavity need the fabric.thickness of every ply");
        return false;
    }
    if (m->target->punch_count)
        m->punch = punch_make(m->target, m->arena);
    return !m->target->punch_count || m->punch || no_memory(m);
}

/* Under a pressure plies with a law give way to the resin. */
static bool begin_relief(struct mapping *m) {
    static const double shares[MAP_RELIEFS] = {0.4, 0.8}; /* of the pressure */
    const struct stack_cavity *cavity = &m->laminate->cavity;
    bool gives = m->law && m->thickness && m->fraction && cavity->kind == STACK_PRESSURE;
    for (int k = 0; gives && !has_heights(m) && k < MAP_RELIEFS; k++) {
        m->relieved[k] = arena_alloc(m->arena, m->count, sizeof *m->relieved[k]);
        if (!m->relieved[k])
            return no_memory(m);
        m->map->fields.relieved[k] = m->relieved[k];
        m->map->fields.relief[k] = shares[k] * cavity->pressure;
    }
    return true;
}

static bool begin(struct mapping *m) {
    const struct laminate *laminate = m->laminate;
    size_t count = m->count, nets = laminate->net_count;
    m->bases = arena_alloc(m->arena, count, sizeof *m->bases);
    m->spots = arena_take(m->arena, nets * count, sizeof *m->spots);
    m->mirrored = arena_take(m->arena, nets * count, sizeof *m->mirrored);
    m->inside = arena_alloc(m->arena, laminate->count, sizeof *m->inside);
    m->there = arena_alloc(m->arena, nets, sizeof *m->there);
    m->distance = arena_take(m->arena, count, sizeof *m->distance);
    if (!m->bases || !m->spots || !m->mirrored || !m->inside || !m->there || !m->distance)
        return no_memory(m);
    for (size_t k = 0; k < laminate->count; k++) {
        if (laminate->plies[k].boundary.count == 0)
            continue;
        m->inside[k] = arena_alloc(m->arena, count, 1);
        if (!m->inside[k])
            return no_memory(m);
    }
    for (size_t k = 0; k < count; k++)
        m->distance[k] = HUGE_VAL;
    return true;
}

/* Names for cards, in which each has to be another: one that was there before gets its number. */
static const char *const *unique_names(struct mapping *m) {
    const struct laminate *laminate = m->laminate;
    const char **names = arena_alloc(m->arena, laminate->count, sizeof *names);
    enum { SIZE = LAMINATE_NAME_MAX + 16 };
    for (size_t k = 0; names && k < laminate->count; k++) {
        char *own = arena_alloc(m->arena, SIZE, 1);
        bool again = false;
        if (!own)
            return NULL;
        for (size_t n = 0; n < k; n++)
            again = again || strcmp(laminate->plies[n].name, laminate->plies[k].name) == 0;
        (void)snprintf(own, SIZE, again ? "%s_%zu" : "%s", laminate->plies[k].name, k + 1);
        names[k] = own;
    }
    return names;
}

static bool begin_stack(struct mapping *m) {
    const struct map_plies plies = {.ply_count = m->laminate->count,
                                    .side = m->laminate->side,
                                    .names = unique_names(m),
                                    .thickness = m->thickness,
                                    .fraction = m->fraction};
    if (!m->target->elements)
        return true;
    return (plies.names && map_stack_begin(&m->map->stack, m->target, &plies, m->rows, m->arena)) ||
           no_memory(m);
}

static void end_stack(struct mapping *m) {
    struct map_fields *fields = &m->map->fields;
    if (!m->target->elements)
        return;
    fields->plies = &m->map->stack.plies;
    fields->column_count += map_stack_end(&m->map->stack, m->map->columns + fields->column_count);
}

enum api_problem_id laminate_map(const struct laminate *laminate,
                                 const struct api_reader *const *nets,
                                 const struct map_target *target,
                                 const struct drape_monitor *monitor, struct arena *arena,
                                 struct api_map *map, struct api_problem *problem) {
    struct mapping m = {.laminate = laminate,
                        .target = target,
                        .monitor = monitor,
                        .map = map,
                        .arena = arena,
                        .problem = problem,
                        .count = target->element_count};
    memset(map, 0, sizeof *map);
    map->fields = map_target_fields(target, map->columns);
    find_properties(&m);
    if (!begin_cavity(&m) || !begin_relief(&m) || !begin(&m) || !read_nets(&m, nets) ||
        !add_columns(&m) || !begin_stack(&m) || !put_all(&m))
        return problem->id;
    end_stack(&m);
    if (target->warning)
        map_warn(map, target->warning);
    warn_of_failed(&m);
    warn_of_places(&m);
    warn_of_pressing(&m);
    return API_OK;
}
