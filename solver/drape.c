/* SPDX-License-Identifier: MIT */
#include "drape.h"

#include "solver/angle.h"
#include "solver/march/cuts.h"
#include "solver/march/march.h"
#include "solver/march/start.h"
#include "solver/mesh/tessellation.h"
#include "solver/report/estimate.h"
#include "solver/report/report.h"
#include "solver/rim/rim.h"
#include "solver/shell/offset.h"
#include "solver/steer/slope.h"
#include "solver/steer/steer.h"
#include <float.h>

/* Patches of the mosaic against the spacing (paper, Fig. 9), and how many there may be against the
 * nodes allowed: two triangles to a square patch, with a margin. */
static const double patch_size = 0.25;
static const size_t patches_per_node = 80;

/* Written so that NaN is refused. */
static bool in_range(double x, double low, double high) {
    return x >= low && x <= high;
}

static bool valid_extent(const struct drape_settings *s, int k) {
    return !s->has_extent[k] || (s->extent[k][0] <= 0 && s->extent[k][1] >= 0);
}

/* The curvature of one that is steered, and of one that is sought the lengths, if any. */
static bool is_valid_curvature(const struct drape_generator *generator) {
    const struct drape_curvature *c = &generator->curvature;
    bool steered = generator->kind == DRAPE_GENERATOR_STEERED;
    if (!steered && generator->kind != DRAPE_GENERATOR_LEAST)
        return true;
    return c->points >= 1 && c->points <= DRAPE_CURVATURE_POINTS &&
           in_range(c->length[0], 0, DBL_MAX) && in_range(c->length[1], 0, DBL_MAX) &&
           (!steered || curvature_most(c) <= DBL_MAX);
}

static bool are_valid_energies(const struct drape_settings *s) {
    const struct drape_energy *e = &s->energy;
    bool valid = e->shear_count != 1;
    for (size_t k = 1; k < e->shear_count; k++)
        valid = valid && e->shear_curve[k][0] > e->shear_curve[k - 1][0] &&
                e->shear_curve[k][1] >= e->shear_curve[k - 1][1];
    return valid && (e->norm == 0 || in_range(e->norm, 1, 64)) &&
           in_range(e->bending, 0, DBL_MAX) && in_range(e->min_radius, 0, DBL_MAX) &&
           is_valid_curvature(&s->generator[0]) && is_valid_curvature(&s->generator[1]);
}

static bool are_valid(const struct drape_settings *s) {
    return in_range(s->spacing[0], DBL_MIN, DBL_MAX) && in_range(s->spacing[1], DBL_MIN, DBL_MAX) &&
           in_range(s->direction_deg, -1e6, 1e6) && in_range(s->pre_shear_deg, -80, 80) &&
           in_range(s->slide, 0, 1) && are_valid_energies(s) &&
           (s->slide == 0 ||
            (s->pre_shear_deg == 0 && s->generator[0].kind != DRAPE_GENERATOR_LEAST &&
             s->generator[1].kind == DRAPE_GENERATOR_GEODESIC)) &&
           valid_extent(s, 0) && valid_extent(s, 1) && s->max_nodes > 0 &&
           s->generator[1].kind != DRAPE_GENERATOR_PLACES &&
           (s->generator[0].kind != DRAPE_GENERATOR_PLACES ||
            s->generator[0].place_start < s->generator[0].place_count);
}

/* ---- what many drapes share ---- */

struct drape_prepared {
    const struct mesh_smooth *smooth; /* of a mesh */
    const struct mesh *facets[2];     /* by the side that the first face of a shell then has */
    const struct mesh *tube[2];
    double facet_size;
    int32_t component; /* 0 of a surface */
};

static double facet_size(const struct drape_settings *settings) {
    return patch_size * fmin(settings->spacing[0], settings->spacing[1]);
}

static int side_of(const struct surface *surface) {
    return surface->shell && shell_surface(surface->shell, 0)->side < 0;
}

/* The surface, or the component of its shell, as triangles. */
static enum status make_facets(const struct surface *surface, const struct drape_settings *settings,
                               struct arena *arena, const struct mesh **facets) {
    struct mesh *mesh = NULL;
    size_t most = patches_per_node * settings->max_nodes;
    double size = facet_size(settings);
    enum status status =
        surface->shell ? mesh_from_shell(surface->shell, surface->face, size, most, arena, &mesh)
                       : mesh_from_surface(surface, size, most, arena, &mesh);
    *facets = mesh;
    return status;
}

/* A shell of one face is draped as that face's surface. */
static struct drape_part without_joints(const struct drape_part *part) {
    if (!part->shell || shell_face_count(part->shell) > 1)
        return *part;
    return (struct drape_part){.surface = shell_plain_surface(part->shell, 0),
                               .trim = shell_trim(part->shell, 0)};
}

static enum status make_smooth(const struct mesh *mesh, struct arena *arena,
                               const struct mesh_smooth **smooth) {
    struct mesh_smooth *made = NULL;
    enum status status = mesh_smooth_make(mesh, arena, &made);
    *smooth = made;
    return status;
}

enum status drape_prepare(const struct drape_part *whole, int32_t component,
                          const struct drape_settings *settings, struct arena *arena,
                          const struct drape_prepared **prepared) {
    const struct drape_part part = without_joints(whole);
    bool flat = drape_method_traits[settings->method].flat;
    struct drape_prepared *made = arena_alloc(arena, 1, sizeof *made);
    *prepared = made;
    if (!made)
        return STATUS_OUT_OF_MEMORY;
    if (part.mesh)
        return flat ? STATUS_OK : make_smooth(part.mesh, arena, &made->smooth);
    made->facet_size = flat ? facet_size(settings) : 0;
    if (part.surface)
        return flat ? make_facets(part.surface, settings, arena, &made->facets[0]) : STATUS_OK;
    made->component = component;
    /* Those of a component of a shell, for starts on faces that have their side as its first has,
     * and for the others. */
    struct shell *oriented = NULL;
    for (int32_t k = 0; k < (int32_t)shell_face_count(part.shell); k++) {
        bool others = oriented != NULL;
        if (shell_component(part.shell, k) != component ||
            (others && shell_surface(oriented, k)->side > 0))
            continue;
        enum status status = shell_orient(part.shell, k, arena, &oriented);
        const struct surface *face = status == STATUS_OK ? shell_surface(oriented, k) : NULL;
        if (face && flat)
            status = make_facets(face, settings, arena, &made->facets[side_of(face)]);
        if (face && status == STATUS_OK)
            status = march_tube_mesh(face, arena, &made->tube[side_of(face)]);
        if (status != STATUS_OK || others)
            return status;
    }
    return STATUS_OK;
}

void drape_prepared_relocate(struct relocation *relocation, void *field) {
    struct drape_prepared *prepared = relocate_once(relocation, field, 1, sizeof *prepared);
    for (int k = 0; prepared && k < 2; k++)
        mesh_relocate(relocation, &prepared->tube[k]);
}

/* ---- starts ---- */

/* The place of the largest component that is nearest to its centroid, but inside a face. */
static bool find_inside(const struct drape_part *part, struct shell_point *place) {
    const struct shell *shell = part->shell;
    struct vec3 centroid;
    double least = HUGE_VAL;
    int32_t component = shell ? shell_largest_component(shell) : 0;
    int32_t faces = shell ? (int32_t)shell_face_count(shell) : 1;
    if (shell)
        (void)shell_area(shell, component, &centroid);
    else if (part->trim)
        (void)trim_area(part->trim, &centroid);
    else
        (void)surface_area(part->surface, &centroid);
    for (int32_t k = 0; k < faces; k++) {
        double inner[2], distance;
        if (shell && shell_component(shell, k) != component)
            continue;
        distance = start_inside(shell ? shell_surface(shell, k) : part->surface,
                                shell ? shell_trim(shell, k) : part->trim, centroid, inner);
        if (!(distance < least))
            continue;
        least = distance;
        *place = (struct shell_point){.face = k, .inner = {inner[0], inner[1]}};
    }
    return least < HUGE_VAL;
}

static enum status begin_on_mesh(struct march *march, int *faulty) {
    const struct drape_prepared *ready = march->settings->prepared;
    const struct drape_method_traits *method = march->method;
    bool suits = method->flat || march->settings->yarn_path == DRAPE_PATH_CHORD;
    enum status status = method->on_meshes && suits ? STATUS_OK : STATUS_INVALID;
    march->smooth = ready ? ready->smooth : NULL;
    if (status == STATUS_OK && !march->smooth && !method->flat)
        status = make_smooth(march->mesh, march->arena, &march->smooth);
    return status == STATUS_OK ? start_find_on_mesh(march, faulty) : status;
}

/* Whether the places of a generator are of the part's faces, and follow each other. */
static bool are_places(const struct drape_part *part, const struct drape_generator *warp,
                       double spacing) {
    struct surface_cursor cursor = {0};
    struct surface_point before, at;
    for (size_t k = 0; k < warp->place_count; k++, before = at) {
        const struct drape_place *place = &warp->places[k];
        if (part->shell &&
            (place->face < 0 || (size_t)place->face >= shell_face_count(part->shell)))
            return false;
        const struct surface *surface =
            part->shell ? shell_surface(part->shell, place->face) : part->surface;
        double inner[2];
        surface_inner(surface, place->uv, inner);
        if (!surface_point_at(surface, &cursor, inner, &at))
            return false;
        if (k > 0 && !drape_place_follows(vec3_distance(at.jet.r, before.jet.r) / spacing))
            return false;
    }
    return true;
}

/* Where the march is to start: as its settings have it or, unless it is NULL, at a place `at` of
 * the part, by its inner parameters. */
static enum status begin(const struct drape_part *part, const struct shell_point *at,
                         struct march *march, int *faulty) {
    const struct drape_settings *s = march->settings;
    const struct shell *shell = part->shell;
    const struct trim *trim = part->trim;
    const struct drape_generator *warp = &s->generator[0];
    bool by_places = warp->kind == DRAPE_GENERATOR_PLACES;
    bool by_uv = s->start_kind == DRAPE_START_UV && !by_places;
    struct shell_point place = {.face = s->start_face};
    struct shell *oriented;
    if (part->mesh)
        return by_places ? STATUS_INVALID : begin_on_mesh(march, faulty);
    if (by_places) {
        const struct drape_place *first = &warp->places[warp->place_start];
        place.face = first->face;
        if (!are_places(part, warp, s->spacing[0]))
            return STATUS_INVALID;
        surface_inner(shell ? shell_surface(shell, place.face) : part->surface, first->uv,
                      place.inner);
        at = &place;
    }
    if (shell && !at && by_uv) {
        if (place.face < 0 || (size_t)place.face >= shell_face_count(shell))
            return STATUS_START_OFF_SURFACE;
    } else if (shell && !at) { /* the face that is nearest to the target */
        double distance, reach = fmax(s->spacing[0], s->spacing[1]);
        reach += fabs(surface_offset_height(shell_surface(shell, 0)));
        struct vec3 target = s->start_point;
        int32_t component = SHELL_ANY;
        if (s->start_kind == DRAPE_START_CENTROID) {
            component = shell_largest_component(shell);
            (void)shell_area(shell, component, &target);
            reach = HUGE_VAL;
        }
        shell_nearest(shell, target, component, &place, &distance);
        if (!(distance <= reach))
            return STATUS_START_OFF_SURFACE;
    }
    enum status status = STATUS_OK;
    if (shell) {
        at = at ? at : &place;
        status = shell_orient(shell, at->face, march->arena, &oriented);
        if (status != STATUS_OK)
            return status;
        march->surface = shell_surface(oriented, at->face);
        trim = shell_trim(shell, at->face);
        at = by_uv ? NULL : at;
    }
    status = start_find(march->surface, trim, s, at ? at->inner : NULL, &march->start, faulty);
    int32_t component =
        march->surface->shell ? shell_component(march->surface->shell, march->surface->face) : 0;
    const struct drape_prepared *ready = s->prepared;
    ready = ready && ready->component == component ? ready : NULL;
    march->tube = ready ? ready->tube[side_of(march->surface)] : NULL;
    if (status == STATUS_OK)
        status = march_open(march);
    if (status != STATUS_OK || !march->method->flat)
        return status;
    /* The march goes over triangles: those that are ready, or its own. */
    if (ready && ready->facet_size == facet_size(s))
        march->mesh = ready->facets[side_of(march->surface)];
    if (!march->mesh)
        status = make_facets(march->surface, s, march->arena, &march->mesh);
    return status == STATUS_OK ? start_move_to_mesh(march) : status;
}

/* Lays the cuts, and sees that they begin at edges. */
static enum status make_cuts(struct march *march, const struct cuts_to_apexes *apexes,
                             struct cut_fault *fault) {
    const double *d = march->settings->spacing;
    struct rim_edges edges;
    enum status status = cuts_make(march, apexes, fault);
    return status == STATUS_OK && march->cuts
               ? rim_edges_make(march, RIM_TOLERANCE / 3 * fmin(d[0], d[1]), &edges, fault)
               : status;
}

/* The cuts of the settings, and those that the part asks for, unless one of these does not begin at
 * an edge. */
static enum status begin_cuts(struct march *march, struct cut_fault *fault) {
    const struct cuts_to_apexes none = {NULL, 0};
    struct cuts_to_apexes apexes;
    enum status status = cuts_to_apexes(march, &apexes);
    if (status == STATUS_OK)
        status = make_cuts(march, &apexes, fault);
    return status == STATUS_CUT && apexes.count > 0 ? make_cuts(march, &none, fault) : status;
}

enum status drape_check_cuts(const struct drape_part *whole, const struct drape_settings *settings,
                             struct arena *arena, struct drape_result *result) {
    const struct drape_part part = without_joints(whole);
    struct march_watch watch = {.busy = ATOMIC_FLAG_INIT};
    struct drape_settings plain = *settings;
    for (int k = 0; k < 2; k++)
        plain.generator[k] = (struct drape_generator){.kind = DRAPE_GENERATOR_GEODESIC};
    struct march march = {.surface = part.surface,
                          .trim = part.trim,
                          .mesh = part.mesh,
                          .settings = &plain,
                          .method = &drape_method_traits[settings->method],
                          .arena = arena,
                          .watch = &watch};
    enum status status = begin(&part, NULL, &march, &result->faulty_generator);
    if (status == STATUS_OK)
        status = begin_cuts(&march, &result->faulty_cut);
    return status == STATUS_CUT || status == STATUS_OUT_OF_MEMORY ? status : STATUS_OK;
}

/* The row that was asked for: from the column next to the start on to both sides, as long as there
 * are places. */
static enum status take_row(struct march *march, struct drape_row *row) {
    enum { COLUMNS_TRIED = 4096 };
    int32_t low = 0, high;
    row->count = 0;
    for (int32_t k = 1; k < COLUMNS_TRIED && !net_place(march->net, low, row->j); k++)
        low = k % 2 ? -(k + 1) / 2 : k / 2;
    if (!net_place(march->net, low, row->j) || march->mesh)
        return STATUS_OK;
    high = low;
    while (net_place(march->net, low - 1, row->j))
        low--;
    while (net_place(march->net, high + 1, row->j))
        high++;
    size_t count = (size_t)(high - low) + 1;
    *row = (struct drape_row){.j = row->j,
                              .first = low,
                              .places = arena_alloc(march->arena, count, sizeof *row->places),
                              .r = arena_alloc(march->arena, count, sizeof *row->r),
                              .inside = arena_alloc(march->arena, count, sizeof *row->inside),
                              .count = count};
    if (!row->places || !row->r || !row->inside)
        return STATUS_OUT_OF_MEMORY;
    for (size_t k = 0; k < count; k++) {
        const struct net_node *node = net_place(march->net, low + (int32_t)k, row->j);
        row->places[k].face = node->face;
        surface_outer(march_surface(march, node), node->uv, row->places[k].uv);
        row->r[k] = node->r;
        row->inside[k] = node->state == NET_INSIDE;
    }
    for (size_t k = 0; k < count; k++)
        row->places[k].along = vec3_sub(row->r[k + 1 < count ? k + 1 : k], row->r[k ? k - 1 : k]);
    return STATUS_OK;
}

/* A `steer_lay` of a part: the drape of settings that seek no generator. */
static enum status lay(const void *context, const struct drape_settings *settings,
                       const struct drape_monitor *monitor, struct arena *arena,
                       struct drape_result *result) {
    const struct drape_part *whole = context, part = without_joints(whole);
    struct shell_point inside, *at = NULL;
    enum status status = STATUS_OK;
    if (whole->shell && part.surface && settings->start_kind == DRAPE_START_UV &&
        settings->start_face != 0)
        return STATUS_START_OFF_SURFACE;
    for (;;) {
        struct march_watch watch = {.busy = ATOMIC_FLAG_INIT};
        struct march march = {.surface = part.surface,
                              .trim = part.trim,
                              .mesh = part.mesh,
                              .settings = settings,
                              .method = &drape_method_traits[settings->method],
                              .monitor = monitor,
                              .arena = arena,
                              .watch = &watch};
        status = begin(&part, at, &march, &result->faulty_generator);
        if (status == STATUS_OK)
            status = begin_cuts(&march, &result->faulty_cut);
        if (status == STATUS_OK)
            status = march_run(&march);
        if (status == STATUS_OK && march.before.net)
            status = estimate_make(&march);
        if (status == STATUS_OK)
            status = march_separate_layers(&march);
        if (status == STATUS_OK && settings->row)
            status = take_row(&march, settings->row);
        if (status == STATUS_OK)
            status = report_make(&march, result);
        if (status == STATUS_OK && settings->slope &&
            settings->slope->wanted(settings->slope->context, result))
            status = steer_slope_make(&march);
        /* Where a start that nobody asked for lies where no cloth begins, on an edge or in a corner
         * of a part that is larger than a few cells, one inside is better. On triangles only nets
         * of shells are tried again. */
        const double *d = settings->spacing;
        bool unasked = settings->start_kind == DRAPE_START_CENTROID && !settings->has_extent[0] &&
                       !settings->has_extent[1] &&
                       settings->generator[0].kind != DRAPE_GENERATOR_PLACES;
        bool nowhere =
            status == STATUS_START_STUCK || (status == STATUS_OK && result->cells.count == 0 &&
                                             march_area(&march) > 8 * d[0] * d[1]);
        if (at || (march.mesh && !part.shell) || !unasked || !nowhere ||
            !find_inside(&part, &inside))
            break;
        at = &inside;
    }
    if (status != STATUS_OK || !whole->shell || part.shell)
        return status;
    result->nodes.face = arena_alloc(arena, result->nodes.count, sizeof *result->nodes.face);
    result->rim.face = arena_alloc(arena, result->rim.count, sizeof *result->rim.face);
    return result->nodes.face && result->rim.face ? STATUS_OK : STATUS_OUT_OF_MEMORY;
}

enum status drape_solve(const struct drape_part *part, const struct drape_settings *settings,
                        const struct drape_monitor *monitor, struct arena *arena,
                        struct drape_result *result) {
    const struct steer_lay of_part = {lay, part};
    if (!are_valid(settings))
        return STATUS_INVALID;
    if (!steer_seeks(settings))
        return lay(part, settings, monitor, arena, result);
    return part->mesh ? STATUS_INVALID : steer_solve(&of_part, settings, monitor, arena, result);
}

void drape_find_bends(const struct drape_part *part, struct surface_bends *bends) {
    *bends = (struct surface_bends){.least_radius = HUGE_VAL};
    if (part->surface)
        surface_bends_find(part->surface, part->trim, bends);
    for (int32_t k = 0; part->shell && k < (int32_t)shell_face_count(part->shell); k++) {
        struct surface_bends face;
        surface_bends_find(shell_surface(part->shell, k), shell_trim(part->shell, k), &face);
        bends->least_radius = fmin(bends->least_radius, face.least_radius);
    }
}

int32_t drape_find_hole(const struct drape_part *part, double least, struct vec3 *at,
                        double *spread) {
    int32_t faces = part->shell ? (int32_t)shell_face_count(part->shell) : part->surface != NULL;
    for (int32_t k = 0; k < faces; k++)
        if (surface_has_spread_pole(part->shell ? shell_surface(part->shell, k) : part->surface,
                                    least, at, spread))
            return k;
    if (!part->shell)
        return -1;
    const struct shell_edges edges = shell_edges(part->shell);
    *at = edges.shortest_at;
    *spread = edges.shortest / ANGLE_PI;
    return edges.shortest > 0 && *spread < least ? edges.shortest_face : -1;
}
