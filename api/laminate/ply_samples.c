/* SPDX-License-Identifier: MIT */
#include "ply_samples.h"

#include "api/map/channel.h"
#include "api/map/net.h"
#include "region.h"
#include "solver/permeability.h"

enum { ASK_EVERY = 1024 };

bool ply_samples_no_memory(struct ply_samples *m) {
    api_problem_set(m->problem, API_OUT_OF_MEMORY, "the map needs more memory than allowed");
    return false;
}

bool ply_samples_go_on(struct ply_samples *m, size_t done, double share) {
    if (done % ASK_EVERY != 0 || !m->monitor || m->monitor->progress(m->monitor->context, share))
        return true;
    api_problem_set(m->problem, API_CANCELLED, "the map was cancelled");
    return false;
}

/* Where the plies of this net have a boundary. */
struct bounded {
    struct region region;
    uint8_t *inside;
};

static bool make_regions(struct ply_samples *m, size_t net, const struct map_net *cloth,
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
            m->away[k] = own->region.away;
            break;
        case STATUS_OUT_OF_MEMORY:
            return ply_samples_no_memory(m);
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

static double height_of(const struct ply_samples *m, size_t net) {
    return m->laminate->plies[m->laminate->net_ply[net]].drape.offset;
}

/* The first net to reach a place gives it its base. */
static struct sample_frame *base_at(struct ply_samples *m, size_t net, size_t place,
                                    const struct facets_point *at, struct vec3 warp,
                                    struct vec3 weft) {
    struct sample_frame *base = &m->bases[place];
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
static void find_place(struct ply_samples *m, size_t net, size_t place, const struct map_net *cloth,
                       struct facets_search *walk, struct vec3 point, double *sense,
                       struct facets_point *at) {
    const struct sample_frame *base = &m->bases[place];
    bool known = vec3_norm2(base->normal) > 0;
    double between = height_of(m, net) - base->height;
    if (known && *sense != 0) {
        struct vec3 over = vec3_axpy(*sense * between, base->normal, base->foot);
        facets_nearest(walk, over, at);
        at->distance = vec3_distance(point, at->r);
        if (!at->outside && !map_net_is_beyond(cloth, at))
            return;
    }
    facets_nearest(walk, point, at);
    if (known && *sense == 0)
        *sense = between * vec3_dot(vec3_sub(at->r, base->foot), base->normal) < 0 ? -1 : 1;
}

static void note_spot(struct ply_samples *m, size_t net, size_t place, const struct map_net *cloth,
                      const struct facets_point *at, size_t shear) {
    size_t own = net * m->count + place;
    double values[API_COLUMNS_MAX];
    struct vec3 warp, weft;
    map_net_interpolate(cloth, at, values);
    map_net_yarns(cloth, at, values, &warp, &weft);
    const struct sample_frame *base = base_at(m, net, place, at, warp, weft);
    m->samples[own].shear_deg = values[shear];
    double x = vec3_dot(warp, base->first), y = vec3_dot(warp, base->second);
    double size = sqrt(x * x + y * y);
    m->samples[own].warp[0] = size > 0 ? x / size : 1;
    m->samples[own].warp[1] = size > 0 ? y / size : 0;
    m->mirrored[own] = vec3_dot(vec3_cross(warp, weft), base->normal) < 0;
}

static bool place_all(struct ply_samples *m, size_t net, const struct map_net *cloth, size_t shear,
                      const struct bounded *bounded, size_t bounded_count) {
    struct facets_search walk = facets_search_begin(cloth->facets);
    struct facets_point at;
    double nets = (double)m->laminate->net_count, sense = 0;
    for (size_t place = 0; place < m->count; place++) {
        struct vec3 point = map_target_point(m->target, place);
        double pq[2];
        if (!ply_samples_go_on(m, place, ((double)net + (double)place / (double)m->count) / nets))
            return false;
        find_place(m, net, place, cloth, &walk, point, &sense, &at);
        m->distance[place] = fmin(m->distance[place], at.distance);
        m->samples[net * m->count + place].shear_deg = NAN;
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
static bool mark_channel(struct ply_samples *m, const struct api_reader *reader,
                         const struct map_net *cloth) {
    size_t marked;
    bool wanted = m->target->has_role[MAP_CHANNEL] && !m->channelled;
    m->channelled = true;
    return !wanted || map_channel_mark(m->target, reader, &cloth->columns, m->arena, &marked,
                                       m->problem) == API_OK;
}

static bool read_net(struct ply_samples *m, size_t net, const struct api_reader *reader) {
    static const enum column_id kept[] = {COLUMN_CELLS_shear_deg, COLUMN_CELLS_warp,
                                          COLUMN_CELLS_weft};
    struct arena_mark mark = arena_mark(m->arena);
    struct map_net *cloth = arena_alloc(m->arena, 1, sizeof *cloth);
    struct bounded *bounded = arena_alloc(m->arena, m->laminate->count, sizeof *bounded);
    size_t count;
    if (!cloth || !bounded)
        return ply_samples_no_memory(m);
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

static bool begin(struct ply_samples *m) {
    const struct laminate *laminate = m->laminate;
    size_t count = m->count, nets = laminate->net_count;
    m->bases = arena_alloc(m->arena, count, sizeof *m->bases);
    m->samples = arena_take(m->arena, nets * count, sizeof *m->samples);
    m->mirrored = arena_take(m->arena, nets * count, sizeof *m->mirrored);
    m->inside = arena_alloc(m->arena, laminate->count, sizeof *m->inside);
    m->away = arena_alloc(m->arena, laminate->count, sizeof *m->away);
    m->there = arena_alloc(m->arena, nets, sizeof *m->there);
    m->distance = arena_take(m->arena, count, sizeof *m->distance);
    if (!m->bases || !m->samples || !m->mirrored || !m->inside || !m->away || !m->there ||
        !m->distance)
        return ply_samples_no_memory(m);
    for (size_t k = 0; k < laminate->count; k++) {
        if (laminate->plies[k].boundary.count == 0)
            continue;
        m->inside[k] = arena_alloc(m->arena, count, 1);
        if (!m->inside[k])
            return ply_samples_no_memory(m);
    }
    for (size_t k = 0; k < count; k++)
        m->distance[k] = HUGE_VAL;
    return true;
}

bool ply_samples_has(const struct ply_samples *m, size_t k, size_t place) {
    size_t net = m->laminate->plies[k].net;
    if (!m->there[net] || isnan(m->samples[net * m->count + place].shear_deg))
        return false;
    return !m->inside[k] || m->inside[k][place];
}

bool ply_samples_read(struct ply_samples *m, const struct api_reader *const *nets) {
    const struct laminate *laminate = m->laminate;
    bool any = false;
    if (!begin(m))
        return false;
    for (size_t net = 0; net < laminate->net_count; net++) {
        m->there[net] = nets[net] != NULL;
        any = any || m->there[net];
        if (m->there[net] && !read_net(m, net, nets[net]))
            return false;
    }
    for (size_t k = 0; k < laminate->count; k++)
        for (size_t place = 0; place < m->count; place++)
            m->rows += ply_samples_has(m, k, place);
    if (!any)
        api_problem_set(m->problem, API_INVALID_REQUEST,
                        "no ply of the laminate could be draped, so there is nothing to map");
    return any;
}
