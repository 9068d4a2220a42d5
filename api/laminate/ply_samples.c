/* SPDX-License-Identifier: MIT */
#include "ply_samples.h"

#include "api/map/channel.h"
#include "api/map/net.h"
#include "flat_plies.h"
#include "region.h"
#include "solver/permeability.h"

enum { ASK_EVERY = 1024 };

bool ply_samples_no_memory(struct ply_samples *m) {
    return api_problem_no_memory(m->problem, "the map") == API_OK;
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

static double net_height(const struct ply_samples *m, size_t net) {
    return m->laminate->plies[m->laminate->net_ply[net]].drape.offset;
}

/* The element of a net nearest to a point. Surfaces that are moved along their normal have the foot
 * of one normal in common: what was found on the first net is moved by what lies between, so that
 * the search begins next to its end. `sense` is the side of that normal that heights count to: 0
 * until it is known. Beside a rim, and where that leads beyond it, the point itself is taken. */
static void find_nearest(struct ply_samples *m, size_t net, size_t element,
                         const struct map_net *cloth, struct facets_search *search,
                         struct vec3 point, double *sense, struct facets_point *at) {
    const struct sample_frame *frame = &m->frames[element];
    bool known = vec3_norm2(frame->normal) > 0;
    double between = net_height(m, net) - frame->height;
    if (known && *sense != 0) {
        struct vec3 over = vec3_axpy(*sense * between, frame->normal, frame->foot);
        facets_nearest(search, over, at);
        at->distance = vec3_distance(point, at->r);
        if (!at->outside && !map_net_is_beyond(cloth, at))
            return;
    }
    facets_nearest(search, point, at);
    if (known && *sense == 0)
        *sense = between * vec3_dot(vec3_sub(at->r, frame->foot), frame->normal) < 0 ? -1 : 1;
}

static bool sample_net(struct ply_samples *m, size_t net, const struct map_net *cloth, size_t shear,
                       const struct bounded *bounded, size_t bounded_count) {
    struct facets_search search = facets_search_begin(cloth->facets);
    struct facets_point at;
    struct vec3 warp, weft;
    double values[API_COLUMNS_MAX], pq[2];
    double nets = (double)m->laminate->net_count, sense = 0;
    for (size_t element = 0; element < m->count; element++) {
        struct vec3 point = map_target_point(m->target, element);
        size_t own = net * m->count + element;
        struct ply_sample *sample = &m->samples[own];
        struct sample_frame *frame = &m->frames[element];
        if (!ply_samples_go_on(m, element,
                               ((double)net + (double)element / (double)m->count) / nets))
            return false;
        find_nearest(m, net, element, cloth, &search, point, &sense, &at);
        m->distance[element] = fmin(m->distance[element], at.distance);
        sample->shear_deg = NAN;
        if (map_net_is_beyond(cloth, &at))
            continue;
        map_net_interpolate(cloth, &at, values);
        map_net_yarns(cloth, &at, values, &warp, &weft);
        if (!(vec3_norm2(frame->normal) > 0)) { /* the first net to reach the element */
            frame->first = warp;
            frame->second = permeability_across(warp, weft);
            frame->normal = vec3_unit(vec3_cross(frame->first, frame->second));
            frame->foot = at.r;
            frame->height = net_height(m, net);
        }
        double x = vec3_dot(warp, frame->first), y = vec3_dot(warp, frame->second);
        double size = sqrt(x * x + y * y);
        sample->shear_deg = values[shear];
        sample->warp[0] = size > 0 ? x / size : 1;
        sample->warp[1] = size > 0 ? y / size : 0;
        m->mirrored[own] = vec3_dot(vec3_cross(warp, weft), frame->normal) < 0;
        if (bounded_count)
            map_net_coordinates(cloth->facets, &at, pq);
        for (size_t k = 0; k < bounded_count; k++)
            bounded[k].inside[element] = region_contains(&bounded[k].region, pq);
    }
    return true;
}

/* Samples a net; of the first one also the channel along its rim, where the target asks for it. */
static bool read_ply_net(struct ply_samples *m, size_t net, const struct api_reader *reader) {
    static const enum column_id kept[] = {COLUMN_CELLS_shear_deg, COLUMN_CELLS_warp,
                                          COLUMN_CELLS_weft};
    struct arena_mark mark = arena_mark(m->arena);
    struct map_net *cloth = arena_alloc(m->arena, 1, sizeof *cloth);
    struct bounded *bounded = arena_alloc(m->arena, m->laminate->count, sizeof *bounded);
    size_t count = 0, marked;
    if (!cloth || !bounded)
        return ply_samples_no_memory(m);
    if (map_net_open(reader, cloth, m->problem) != API_OK)
        return false;
    map_net_keep(cloth, kept, sizeof kept / sizeof *kept);
    size_t shear = cloth->group[0].offset;
    bool channel = m->target->has_role[MAP_CHANNEL] && !m->channelled;
    m->channelled = true;
    m->spacing = fmax(m->spacing, cloth->spacing);
    m->map->fields.unit = cloth->columns.unit;
    bool good = map_net_load(reader, m->monitor, m->arena, cloth, m->problem) == API_OK &&
                (!channel || map_channel_mark(m->target, reader, &cloth->columns, m->arena, &marked,
                                              m->problem) == API_OK);
    for (size_t k = 0; good && k < m->laminate->count; k++) {
        const struct laminate_ply *ply = &m->laminate->plies[k];
        if (ply->net != net || !m->inside[k])
            continue;
        struct bounded *own = &bounded[count++];
        own->inside = m->inside[k];
        if (laminate_is_split(ply)) {
            own->region = m->pieces[k];
            continue;
        }
        good = region_make(m->laminate, k, cloth->facets, cloth->columns.grid.spacing, m->arena,
                           &own->region, m->problem) == API_OK;
        m->away[k] = good ? own->region.away : 0;
    }
    good = good && sample_net(m, net, cloth, shear, bounded, count);
    arena_rewind(m->arena, mark);
    return good;
}

bool ply_samples_has(const struct ply_samples *m, size_t k, size_t element) {
    size_t net = m->laminate->plies[k].net;
    if (!m->there[net] || isnan(m->samples[net * m->count + element].shear_deg))
        return false;
    return !m->inside[k] || m->inside[k][element];
}

/* The regions of pieces are their patterns. */
static bool find_pieces(struct ply_samples *m, const struct api_reader *const *nets) {
    const struct laminate *laminate = m->laminate;
    struct flat_plies shapes = {0};
    bool any = false, good = true;
    m->pieces = arena_alloc(m->arena, laminate->count, sizeof *m->pieces);
    for (size_t k = 0; k < laminate->count; k++)
        any = any || laminate_is_split(&laminate->plies[k]);
    if (!m->pieces)
        return ply_samples_no_memory(m);
    if (any)
        good =
            flat_plies_make(laminate, nets, LAMINATE_ALL, m->arena, &shapes, m->problem) == API_OK;
    for (size_t n = 0; n < shapes.count && good; n++) {
        const struct flat_ply *shape = &shapes.shapes[n];
        const double *spacing = laminate->plies[shape->ply].drape.settings.spacing;
        if (shape->piece &&
            !region_of_polygons(&shape->cut, spacing, m->arena, &m->pieces[shape->ply]))
            good = ply_samples_no_memory(m);
    }
    flat_plies_free(&shapes);
    return good;
}

bool ply_samples_read(struct ply_samples *m, const struct api_reader *const *nets) {
    const struct laminate *laminate = m->laminate;
    size_t count = m->count, net_count = laminate->net_count;
    bool any = false;
    m->frames = arena_alloc(m->arena, count, sizeof *m->frames);
    m->samples = arena_take(m->arena, net_count * count, sizeof *m->samples);
    m->mirrored = arena_take(m->arena, net_count * count, sizeof *m->mirrored);
    m->inside = arena_alloc(m->arena, laminate->count, sizeof *m->inside);
    m->away = arena_alloc(m->arena, laminate->count, sizeof *m->away);
    m->there = arena_alloc(m->arena, net_count, sizeof *m->there);
    m->distance = arena_take(m->arena, count, sizeof *m->distance);
    if (!m->frames || !m->samples || !m->mirrored || !m->inside || !m->away || !m->there ||
        !m->distance)
        return ply_samples_no_memory(m);
    for (size_t k = 0; k < count; k++)
        m->distance[k] = HUGE_VAL;
    for (size_t k = 0; k < laminate->count; k++) {
        const struct laminate_ply *ply = &laminate->plies[k];
        bool bounded = ply->boundary.count > 0 || laminate_is_split(ply);
        m->inside[k] = bounded ? arena_alloc(m->arena, count, 1) : NULL;
        if (bounded && !m->inside[k])
            return ply_samples_no_memory(m);
    }
    if (!find_pieces(m, nets))
        return false;
    for (size_t net = 0; net < net_count; net++) {
        m->there[net] = nets[net] != NULL;
        any = any || m->there[net];
        if (m->there[net] && !read_ply_net(m, net, nets[net]))
            return false;
    }
    for (size_t k = 0; k < laminate->count; k++)
        for (size_t element = 0; element < count; element++)
            m->rows += ply_samples_has(m, k, element);
    if (!any)
        api_problem_set(m->problem, API_INVALID_REQUEST,
                        "no ply of the laminate could be draped, so there is nothing to map");
    return any;
}
