/* SPDX-License-Identifier: MIT */
#include "drape.h"

#include "solver/march/march.h"
#include "solver/march/start.h"
#include "solver/mesh/tessellation.h"
#include "solver/report/estimate.h"
#include "solver/report/report.h"
#include "solver/shell/offset.h"
#include <float.h>

const char *drape_reason_name(enum drape_reason reason) {
    static const char *const names[] = {
#define X(id, name) name,
        DRAPE_REASON_LIST(X)
#undef X
    };
    return names[reason];
}

/* Written so that NaN is refused. */
static bool in_range(double x, double low, double high) {
    return x >= low && x <= high;
}

static bool valid_extent(const struct drape_settings *s, int k) {
    return !s->has_extent[k] || (s->extent[k][0] <= 0 && s->extent[k][1] >= 0);
}

/* Patches of the mosaic against the spacing (paper, Fig. 9), and how many there may be against the
 * nodes allowed: two triangles to a square patch, with a margin. */
static const double patch_size = 0.25;
static const size_t patches_per_node = 80;

static enum status check_settings(const struct drape_settings *s) {
    bool good = in_range(s->spacing[0], DBL_MIN, DBL_MAX) &&
                in_range(s->spacing[1], DBL_MIN, DBL_MAX) &&
                in_range(s->direction_deg, -1e6, 1e6) && in_range(s->pre_shear_deg, -80, 80) &&
                valid_extent(s, 0) && valid_extent(s, 1) && s->max_nodes > 0;
    return good ? STATUS_OK : STATUS_INVALID;
}

/* Ghosts beyond the last node inside: what the stencils of the shear angle reach, and in a first
 * march those of the correction beyond them. */
enum { FRINGE = 2, FRINGE_BEFORE = 4 };

/* A net that nobody watches is given up when it has so many times the nodes that its cells would
 * have unsheared. */
static const double layers_most = 4;
static const size_t nodes_least = 1000;

/* A net on a shell with one boundary is not expected to meet itself, and on most it does not: one
 * that does, as round a deep cup, is marched again and watched from its first node on. Round its
 * wall a net that is not watched may go on without an end. */
static enum status march_on(struct march *march) {
    const struct march begun = *march;
    if (march->mesh || !march->surface->shell || march->watched)
        return march_run(march);
    struct drape_settings bounded = *march->settings;
    double cells = march_area(march) / (bounded.spacing[0] * bounded.spacing[1]);
    size_t most = nodes_least + (size_t)fmin(layers_most * cells, (double)SIZE_MAX / 4);
    bounded.max_nodes = most < bounded.max_nodes ? most : bounded.max_nodes;
    march->settings = &bounded;
    enum status status = march_run(march);
    march->settings = begun.settings;
    bool folded = status == STATUS_TOO_MANY_NODES;
    if (status == STATUS_OK)
        status = march_find_fold(march, &folded);
    if (!folded)
        return status;
    *march = begun;
    march->watched = true;
    return march_run(march);
}

/* The march, twice for a method that corrects its first net, which has an arena of its own: the
 * report needs it no longer than to take the estimates from it. */
static enum status march_all(struct march *march) {
    struct arena *arena = march->arena;
    bool corrected = march->settings->method == DRAPE_GIB4;
    march->fringe = corrected ? FRINGE_BEFORE : FRINGE;
    if (corrected && !(march->arena = arena_child(arena)))
        return STATUS_OUT_OF_MEMORY;
    enum status status = march_on(march);
    if (status != STATUS_OK || !corrected)
        return status;
    *march = (struct march){.surface = march->surface,
                            .slit = march->slit,
                            .cut_centre = {march->cut_centre[0], march->cut_centre[1]},
                            .settings = march->settings,
                            .monitor = march->monitor,
                            .arena = arena,
                            .start = march->start,
                            .first = march->net,
                            .before = net_view(march->net),
                            .watch = march->watch,
                            .watched = march->watched,
                            .fringe = FRINGE};
    status = march_on(march);
    return status == STATUS_OK ? estimate_make(march) : status;
}

/* ---- the method mosaic ---- */

/* Of a shell by the side that its first face then has. */
struct drape_facets {
    const struct mesh *side[2];
    double size;
    int32_t component; /* 0 of a surface */
};

static double facet_size(const struct drape_settings *settings) {
    return patch_size * fmin(settings->spacing[0], settings->spacing[1]);
}

static int side_of(const struct surface *surface) {
    return surface->shell && shell_surface(surface->shell, 0)->side < 0;
}

static int32_t component_of(const struct surface *surface) {
    return surface->shell ? shell_component(surface->shell, surface->face) : 0;
}

/* The surface, or the faces of its shell, as triangles. */
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

/* Those of a component of a shell, for starts on faces that have their side as its first has, and
 * for the others. */
static enum status make_sides(const struct shell *shell, const struct drape_settings *settings,
                              struct arena *arena, struct drape_facets *facets) {
    struct shell *oriented = NULL;
    for (int32_t k = 0; k < (int32_t)shell_face_count(shell); k++) {
        bool others = oriented != NULL;
        if (shell_component(shell, k) != facets->component ||
            (others && shell_surface(oriented, k)->side > 0))
            continue;
        enum status status = shell_orient(shell, k, arena, &oriented);
        const struct surface *face = status == STATUS_OK ? shell_surface(oriented, k) : NULL;
        if (face)
            status = make_facets(face, settings, arena, &facets->side[side_of(face)]);
        if (status != STATUS_OK || others)
            return status;
    }
    return STATUS_OK;
}

enum status drape_prepare_facets(const struct surface *surface, const struct shell *shell,
                                 int32_t component, const struct drape_settings *settings,
                                 struct arena *arena, const struct drape_facets **facets) {
    struct drape_facets *made = arena_alloc(arena, 1, sizeof *made);
    enum status status = made ? STATUS_OK : STATUS_OUT_OF_MEMORY;
    *facets = NULL;
    if (settings->method != DRAPE_MOSAIC || !made)
        return status;
    made->size = facet_size(settings);
    *facets = made;
    if (shell && shell_face_count(shell) == 1) /* draped as that face's surface */
        surface = shell_plain_surface(shell, 0);
    if (surface)
        return make_facets(surface, settings, arena, &made->side[0]);
    made->component = component;
    return make_sides(shell, settings, arena, made);
}

/* Has the march go over triangles: those that are ready, or its own. */
static enum status tessellate(struct march *march) {
    const struct surface *surface = march->surface;
    const struct drape_facets *ready = march->settings->facets;
    enum status status = STATUS_OK;
    if (ready && ready->size == facet_size(march->settings) &&
        ready->component == component_of(surface))
        march->mesh = ready->side[side_of(surface)];
    if (!march->mesh)
        status = make_facets(surface, march->settings, march->arena, &march->mesh);
    return status == STATUS_OK ? start_move_to_mesh(march) : status;
}

static enum status finish(struct march *march, struct drape_result *result) {
    struct march_watch watch = {.busy = ATOMIC_FLAG_INIT};
    march->watch = &watch;
    enum status status = march_all(march);
    if (status == STATUS_OK)
        status = march_part_layers(march);
    return status == STATUS_OK ? report_make(march, result) : status;
}

/* Whether a start that nobody asked for lies where no cloth begins, on an edge or in a corner of a
 * part that is larger than a few cells: then one inside is better. */
static bool begins_nowhere(enum status status, const struct march *march,
                           const struct drape_result *result) {
    const struct drape_settings *s = march->settings;
    if (s->start_kind != DRAPE_START_CENTROID || s->has_extent[0] || s->has_extent[1])
        return false;
    return status == STATUS_START_STUCK || (status == STATUS_OK && result->cells.count == 0 &&
                                            march_area(march) > 8 * s->spacing[0] * s->spacing[1]);
}

enum status drape_solve(const struct surface *surface, const struct drape_settings *settings,
                        const struct drape_monitor *monitor, struct arena *arena,
                        struct drape_result *result) {
    struct march march = {
        .surface = surface, .settings = settings, .monitor = monitor, .arena = arena};
    bool mosaic = settings->method == DRAPE_MOSAIC;
    enum status status = check_settings(settings);
    if (status == STATUS_OK)
        status = start_find(surface, settings, &march.start, &result->faulty_generator);
    if (status == STATUS_OK)
        status = march_open(&march);
    if (status == STATUS_OK && mosaic)
        status = tessellate(&march);
    if (status == STATUS_OK)
        status = finish(&march, result);
    if (mosaic || !begins_nowhere(status, &march, result))
        return status;
    struct vec3 centroid;
    double inner[2];
    if (settings->trim)
        trim_area(settings->trim, &centroid);
    else
        surface_area(surface, &centroid);
    if (!(start_inside(surface, settings->trim, centroid, inner) < HUGE_VAL))
        return status;
    march = (struct march){
        .surface = surface, .settings = settings, .monitor = monitor, .arena = arena};
    status = start_find_at(surface, settings, inner, &march.start, &result->faulty_generator);
    if (status == STATUS_OK)
        status = march_open(&march);
    return status == STATUS_OK ? finish(&march, result) : status;
}

static int32_t largest_component(const struct shell *shell) {
    int32_t largest = 0, count = (int32_t)shell_component_count(shell);
    for (int32_t k = 1; k < count; k++)
        if (shell_area(shell, k, NULL) > shell_area(shell, largest, NULL))
            largest = k;
    return largest;
}

/* The place of a shell at which the settings start: a face and its parameters. */
static enum status find_face(const struct shell *shell, const struct drape_settings *settings,
                             struct shell_point *place) {
    double distance, reach = fmax(settings->spacing[0], settings->spacing[1]);
    reach += fabs(surface_offset_height(shell_surface(shell, 0)));
    struct vec3 target = settings->start_point;
    int32_t component = SHELL_ANY;
    if (settings->start_kind == DRAPE_START_UV) {
        place->face = settings->start_face;
        bool there = place->face >= 0 && (size_t)place->face < shell_face_count(shell);
        return there ? STATUS_OK : STATUS_START_OFF_SURFACE;
    }
    if (settings->start_kind == DRAPE_START_CENTROID) {
        component = largest_component(shell);
        (void)shell_area(shell, component, &target);
        reach = HUGE_VAL;
    }
    shell_nearest(shell, target, component, place, &distance);
    return distance <= reach ? STATUS_OK : STATUS_START_OFF_SURFACE;
}

/* A shell of one face as its surface. */
static enum status solve_face(const struct shell *shell, const struct drape_settings *settings,
                              const struct drape_monitor *monitor, struct arena *arena,
                              struct drape_result *result) {
    struct drape_settings on_face = *settings;
    if (settings->start_kind == DRAPE_START_UV && settings->start_face != 0)
        return STATUS_START_OFF_SURFACE;
    on_face.trim = shell_trim(shell, 0);
    enum status status =
        drape_solve(shell_plain_surface(shell, 0), &on_face, monitor, arena, result);
    if (status != STATUS_OK)
        return status;
    result->nodes.face = arena_alloc(arena, result->nodes.count, sizeof *result->nodes.face);
    result->rim.face = arena_alloc(arena, result->rim.count, sizeof *result->rim.face);
    return result->nodes.face && result->rim.face ? STATUS_OK : STATUS_OUT_OF_MEMORY;
}

/* The place of the largest component that is nearest to its centroid, but inside a face. */
static bool find_inside(const struct shell *shell, struct shell_point *place) {
    struct vec3 centroid;
    double least = HUGE_VAL;
    int32_t component = largest_component(shell);
    (void)shell_area(shell, component, &centroid);
    for (int32_t k = 0; k < (int32_t)shell_face_count(shell); k++) {
        double inner[2], distance;
        if (shell_component(shell, k) != component)
            continue;
        distance = start_inside(shell_surface(shell, k), shell_trim(shell, k), centroid, inner);
        if (!(distance < least))
            continue;
        least = distance;
        *place = (struct shell_point){.face = k, .inner = {inner[0], inner[1]}};
    }
    return least < HUGE_VAL;
}

/* From a place, whose inner parameters count unless the settings have others; `nowhere` as
 * `begins_nowhere`. */
static enum status solve_from(const struct shell *shell, const struct shell_point *place,
                              const struct drape_settings *settings,
                              const struct drape_monitor *monitor, struct arena *arena,
                              struct drape_result *result, bool *nowhere) {
    struct drape_settings on_face = *settings;
    struct march march = {.settings = settings, .monitor = monitor, .arena = arena};
    struct shell *oriented;
    enum status status = shell_orient(shell, place->face, arena, &oriented);
    if (status != STATUS_OK)
        return status;
    march.surface = shell_surface(oriented, place->face);
    on_face.trim = shell_trim(shell, place->face);
    if (settings->start_kind == DRAPE_START_UV)
        status = start_find(march.surface, &on_face, &march.start, &result->faulty_generator);
    else
        status = start_find_at(march.surface, settings, place->inner, &march.start,
                               &result->faulty_generator);
    if (status == STATUS_OK)
        status = march_open(&march);
    if (status == STATUS_OK && settings->method == DRAPE_MOSAIC)
        status = tessellate(&march);
    if (status == STATUS_OK)
        status = finish(&march, result);
    *nowhere = begins_nowhere(status, &march, result);
    return status;
}

enum status drape_solve_shell(const struct shell *shell, const struct drape_settings *settings,
                              const struct drape_monitor *monitor, struct arena *arena,
                              struct drape_result *result) {
    struct shell_point place;
    if (settings->trim)
        return STATUS_INVALID;
    if (shell_face_count(shell) == 1)
        return solve_face(shell, settings, monitor, arena, result);
    enum status status = check_settings(settings);
    if (status == STATUS_OK)
        status = find_face(shell, settings, &place);
    bool nowhere = false;
    if (status == STATUS_OK)
        status = solve_from(shell, &place, settings, monitor, arena, result, &nowhere);
    if (nowhere && find_inside(shell, &place))
        status = solve_from(shell, &place, settings, monitor, arena, result, &nowhere);
    return status;
}

/* The methods that a mesh of the caller's can be draped with. */
static bool suits_mesh(const struct drape_settings *s) {
    bool smooth = s->method != DRAPE_GIB4 && s->yarn_path == DRAPE_PATH_CHORD;
    return !s->trim && (s->method == DRAPE_MOSAIC || smooth);
}

enum status drape_prepare_mesh(const struct mesh *mesh, enum drape_method method,
                               struct arena *arena, const struct mesh_smooth **smooth) {
    struct mesh_smooth *made = NULL;
    enum status status = method == DRAPE_MOSAIC ? STATUS_OK : mesh_smooth_make(mesh, arena, &made);
    *smooth = made;
    return status;
}

enum status drape_solve_mesh(const struct mesh *mesh, const struct drape_settings *settings,
                             const struct drape_monitor *monitor, struct arena *arena,
                             struct drape_result *result) {
    struct march march = {.mesh = mesh, .settings = settings, .monitor = monitor, .arena = arena};
    enum status status = check_settings(settings);
    if (status == STATUS_OK && !suits_mesh(settings))
        status = STATUS_INVALID;
    march.smooth = settings->smooth;
    if (status == STATUS_OK && !march.smooth)
        status = drape_prepare_mesh(mesh, settings->method, arena, &march.smooth);
    if (status == STATUS_OK)
        status = start_find_on_mesh(&march, &result->faulty_generator);
    return status == STATUS_OK ? finish(&march, result) : status;
}
