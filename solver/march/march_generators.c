/* SPDX-License-Identifier: MIT */
/* The four arms of the two generator yarns. */
#include "march.h"

#include "solver/fishnet/correction.h"
#include "solver/fishnet/fishnet_geodesic.h"
#include "solver/fishnet/rough.h"
#include "solver/path/path.h"

/* A path at a node, the point there and its tangent. */
struct stop {
    struct path path;
    struct surface_point point;
    struct vec3 tangent;
    bool known; /* there is such a point */
};

static bool find_stop_point(struct march *march, struct stop *stop) {
    stop->known = path_surface_point(&stop->path, &march->cursor, &stop->point, &stop->tangent);
    return stop->known;
}

/* Whether the surface folds between two places so that no straight chord is a yarn's: where
 * triangles were made of it, as they do. */
static bool folds_between(const struct march *march, const struct surface_point *from,
                          const struct surface_point *to, double d) {
    return march_mesh_folds(march) ? vec3_dot(from->normal, to->normal) < MARCH_MESH_CREASE &&
                                         rough_is_rough(from, to, d)
                                   : rough_is_fold(from, to, d);
}

/* To the next node, a spacing along the path: in a straight line by the method basic, unless that
 * leads over a fold. What is steered is as exact as can be: it is compared with others next to it.
 */
static bool advance_stop(struct march *march, struct stop *stop, double d) {
    enum drape_yarn yarn = march->method->yarn;
    if (yarn != DRAPE_YARN_GEODESIC && !stop->path.curvature)
        path_follow_net(&stop->path, d, march->before.net ? 4 : 2);
    const struct stop from = *stop;
    if (yarn == DRAPE_YARN_CHORD) {
        bool gone = path_advance_chord(&stop->path, &march->cursor, d);
        if (gone && find_stop_point(march, stop) &&
            !(from.known && folds_between(march, &from.point, &stop->point, d)))
            return true;
        *stop = from;
    }
    return path_advance(&stop->path, d) && find_stop_point(march, stop);
}

/* A yarn that goes straight on and whose chord is this share of its arc's has not gone round a
 * corner and come back, where ends may be alike over no arc. Generators may bend sideways. */
static const double not_back = 0.99;

/* Geodesics between the nodes of a generator that is none are found to this share of a spacing. */
static const double between_nodes = 1e-7;

/* Notes for march_place whether the edge to the neighbour on the side (di, dj), along which a path
 * went, is rough: no arc or with a chord that is less than this share of the arc's. The yarn over a
 * rough edge is its geodesic, though the path, unless it `is_straight`, bends there. */
static void note_path_edge(struct march *march, const struct stop *from, const struct stop *to,
                           int di, int dj, double least, bool is_straight) {
    const struct surface_point *start = &from->point, *end = &to->point;
    double d = march->length[dj != 0], chord = d, curvature;
    march->edges.rough = 0;
    if (!from->known)
        return;
    curvature = surface_point_normal_curvature(start, from->tangent);
    bool even = march->method->yarn == DRAPE_YARN_CHORD
                    ? !rough_is_fold(start, end, d)
                    : rough_is_arc(start, end, curvature, d) ||
                          rough_edge(start, end, curvature, d, &chord) < ROUGH_UNEVEN;
    least *= fmin(chord, fishnet_arc_chord(d, curvature));
    if (even && vec3_distance(start->jet.r, end->jet.r) >= least)
        return;
    struct vec3 leave = fishnet_path_tangent(&from->path, start, from->tangent);
    struct vec3 arrive = fishnet_path_tangent(&to->path, end, to->tangent);
    if (!is_straight) /* or, where none is found, as the path goes */
        (void)!fishnet_geodesic_between(march->surface, &march->cursor, start, end, between_nodes,
                                        &d, &leave, &arrive);
    march_note_edge(march, di ? 0 : 1, di + dj, leave, arrive);
}

/* A path that gets no further although the way to the border is longer than this, in spacings, does
 * not end there. */
static const double stuck_within = 0.25;

/* Why a path could not be followed: the surface folds back on itself, or has no tangent plane there
 * or ahead, as at a cusp, well within the part; else its boundary. */
static enum drape_reason why_path_ended(struct march *march, const struct path *path, double d) {
    const struct trim *trim = march->trim;
    struct surface_cursor cursor = {0};
    struct surface_point at;
    struct surface_jet border;
    double share = HUGE_VAL, uv[2], end[2];
    if (path->ended)
        return DRAPE_REASON_NO_CONVERGENCE;
    if (path->surface->shell || !path_surface_point(path, &march->cursor, &at, NULL) ||
        !march_parameters(march, &at, uv))
        return DRAPE_REASON_BOUNDARY;
    /* Where the straight line ahead in the parameters meets the border of the domain. */
    for (int k = 0; k < 2; k++) {
        const struct surface_axis *axis = &path->surface->axis[k];
        double by = path->velocity[k];
        double limit = by > 0 ? surface_axis_upper(axis) : surface_axis_lower(axis);
        if (!axis->closed && by != 0)
            share = fmin(share, fmax((limit - path->uv[k]) / by, 0));
    }
    for (int k = 0; k < 2; k++)
        end[k] = path->uv[k] + (share < HUGE_VAL ? share * path->velocity[k] : 0);
    surface_jet_at(path->surface, &cursor, end[0], end[1], &border);
    bool within =
        vec3_distance(border.r, at.jet.r) > stuck_within * d && (!trim || trim_contains(trim, uv));
    return within ? DRAPE_REASON_DEGENERATE : DRAPE_REASON_BOUNDARY;
}

bool march_straight_on(struct march *march, const struct surface_point *from, struct vec3 direction,
                       int di, int dj, struct surface_point *point, enum drape_reason *reason) {
    struct stop start, end;
    double d = march->length[dj != 0];
    *reason = DRAPE_REASON_BOUNDARY;
    if (march->mesh)
        return march_mesh_straight_on(march, from, direction, di, dj, point);
    if (!path_geodesic(&start.path, from->surface, from, direction))
        return false;
    start.path.reach = march_reach(march);
    (void)find_stop_point(march, &start);
    end = start;
    if (!advance_stop(march, &end, d)) {
        *reason = why_path_ended(march, &end.path, d);
        return false;
    }
    note_path_edge(march, &start, &end, di, dj, not_back, true);
    *point = end.point;
    return true;
}

/* A generator on one side of the start, nodes k (di, dj), k = 1, 2, .. */
struct arm {
    struct stop at;
    struct march_mesh_yarn yarn; /* on a mesh of the caller's, instead of the path */
    struct surface_point last;   /* on a mesh made of a surface: where the arm is on the mesh */
    int di, dj;
    int32_t outside;  /* nodes since the last one inside */
    struct vec3 left; /* where it went there; not on a mesh */
    bool started, ended;
    const struct drape_generator *through; /* along places that are given; else NULL */
    int32_t next;                          /* the place ahead */
};

/* No hole is longer than the part: an arm that is outside for longer comes to it from behind. So
 * does one beyond the domain that has turned back after this share of that. */
static const double turns_after = 0.25;

/* Whether an arm that is outside goes round the part, as below the rim of a dome. */
static bool goes_round(const struct march *march, const struct arm *arm, double d) {
    if (march->mesh || arm->outside == 0)
        return false;
    bool turned =
        surface_point_is_beyond(&arm->at.point, 0) && vec3_dot(arm->left, arm->at.tangent) < 0;
    return arm->outside * d > (turned ? turns_after : 1) * march->size;
}

/* An arm along a polyline goes on where its points end as a geodesic. */
static struct arm make_arm(struct march *march, int number) {
    int sign = number % 2 ? -1 : 1, k = number / 2;
    const struct drape_generator *generator = &march->settings->generator[k];
    const struct march_start *start = &march->start;
    const struct march_curve *curve = &start->curve[k];
    const struct surface_point *from = march->mesh ? &start->smooth : &start->point;
    struct vec3 direction = vec3_scale(sign, k == 0 ? start->warp : start->weft);
    struct arm arm = {.di = k == 0 ? sign : 0, .dj = k == 0 ? 0 : sign, .last = start->point};
    int sense = sign * curve->sense, side = sense > 0 ? 0 : 1;
    bool is_curve = generator->kind == DRAPE_GENERATOR_CURVE;
    if (march->mesh && march->surface)
        direction = vec3_scale(sign, start->smooth_direction[k]);
    if (!march->surface)
        arm.started = march_mesh_arm(march, &start->point, generator, direction, &arm.yarn);
    else if (is_curve && !curve->ends[side])
        arm.started = path_curve(&arm.at.path, march->surface, &curve->from, generator->curve,
                                 generator->curve_count, curve->next[side], sense);
    else if (generator->kind == DRAPE_GENERATOR_PLANE)
        arm.started = path_section(&arm.at.path, march->surface, from,
                                   vec3_unit(generator->plane_normal), direction);
    else if (generator->kind == DRAPE_GENERATOR_STEERED)
        arm.started = path_steered(&arm.at.path, march->surface, from, direction,
                                   &generator->curvature, sign);
    else
        arm.started =
            path_geodesic(&arm.at.path, march->surface, is_curve ? &curve->from : from, direction);
    arm.at.path.reach = march_reach(march);
    if (arm.started && march->surface)
        (void)find_stop_point(march, &arm.at);
    if (generator->kind == DRAPE_GENERATOR_PLACES) {
        arm.through = generator;
        arm.next = (int32_t)generator->place_start + sign;
    }
    return arm;
}

/* To the place ahead of those that are given. False where there is none, or no tangent plane. */
static bool advance_to_place(struct march *march, struct arm *arm) {
    const struct drape_generator *through = arm->through;
    int sign = arm->di;
    if (!through || arm->next < 0 || (size_t)arm->next >= through->place_count)
        return false;
    const struct drape_place *place = &through->places[arm->next];
    const struct surface *surface = march->surface;
    struct stop to = {.known = true};
    double uv[2];
    if (surface->shell)
        surface = shell_surface(surface->shell, place->face);
    surface_inner(surface, place->uv, uv);
    if (!surface_point_at(surface, &march->cursor, uv, &to.point) ||
        !path_geodesic(&to.path, surface, &to.point, vec3_scale(sign, place->along)))
        return false;
    to.tangent = surface_point_tangent(&to.point, vec3_scale(sign, place->along));
    arm->next += sign;
    arm->at = to;
    return true;
}

/* To node k in a second march, the edge's chord being the corrected one like those of the yarns
 * beside it, so that they fit to the last order. False where there is none. */
static bool advance_corrected(struct march *march, struct arm *arm, int32_t k, double d) {
    struct correction correction;
    const struct stop *from = &arm->at;
    struct stop to = {.path = from->path};
    double chord;
    int32_t i = (k - 1) * arm->di, j = (k - 1) * arm->dj;
    net_view_move(&march->before, i, j);
    path_follow_net(&to.path, d, 4);
    if (!correction_find(&march->before, i, j, arm->di, arm->dj, d, &correction) ||
        !correction.whole || !correction_chord(&correction, &chord) || !from->known ||
        !path_advance_chord(&to.path, &march->cursor, chord) || !find_stop_point(march, &to))
        return false;
    double leaving = surface_point_normal_curvature(&from->point, from->tangent);
    double arriving = surface_point_normal_curvature(&to.point, to.tangent);
    if (!correction_agrees(&correction, 0, &from->point, leaving) ||
        !correction_agrees(&correction, 1, &to.point, arriving))
        return false;
    arm->at = to;
    return true;
}

static enum status grow_arm(struct march *march, struct arm *arm, int32_t k) {
    struct surface_point on_mesh;
    enum surface_point_zone zone;
    int32_t i = k * arm->di, j = k * arm->dj;
    double d = march->settings->spacing[arm->dj != 0];
    arm->ended = true;
    if (!march_in_extent(march, i, j))
        return march_fail(march, i, j, DRAPE_REASON_EXTENT);
    bool lost = false;
    enum drape_reason reason;
    struct stop before = arm->at;
    bool gone = arm->started;
    if (gone && march->mesh && !march->surface) {
        gone = march_mesh_lay(march, &arm->yarn, arm->di, arm->dj, &on_mesh, &lost);
    } else if (gone && march->mesh) { /* along the generator of the surface it was made of */
        gone = (advance_to_place(march, arm) || advance_stop(march, &arm->at, d)) &&
               march_zone(march, &arm->at.point, false, &reason) == SURFACE_POINT_INSIDE;
        bool folded = gone && before.known && march_mesh_folds(march) &&
                      folds_between(march, &before.point, &arm->at.point, d);
        gone = gone && march_mesh_towards(march, &arm->last, arm->at.point.jet.r, arm->dj != 0,
                                          folded, &on_mesh, &lost);
        if (gone)
            march_mesh_note(march, &arm->last, &on_mesh, folded, arm->di, arm->dj, before.tangent,
                            arm->at.tangent);
        arm->last = gone ? on_mesh : arm->last;
    } else if (gone && !advance_to_place(march, arm) &&
               !(march->before.net && advance_corrected(march, arm, k, d)))
        gone = advance_stop(march, &arm->at, d);
    if (!gone)
        return march_fail(march, i, j,
                          lost                           ? DRAPE_REASON_NO_CONVERGENCE
                          : arm->started && !march->mesh ? why_path_ended(march, &arm->at.path, d)
                                                         : DRAPE_REASON_BOUNDARY);
    const struct surface_point *point = march->mesh ? &on_mesh : &arm->at.point;
    if (!march->mesh)
        note_path_edge(march, &before, &arm->at, arm->di, arm->dj, 0,
                       march->settings->generator[arm->dj != 0].kind == DRAPE_GENERATOR_GEODESIC);
    if (march_is_parted(march, i, j, -arm->di, -arm->dj, point))
        return STATUS_OK;
    enum status status = march_place(march, i, j, point, &zone);
    if (arm->outside == 0 && !march->mesh)
        arm->left = before.tangent;
    arm->outside = zone == SURFACE_POINT_GHOST ? arm->outside + 1 : 0;
    arm->ended = zone == SURFACE_POINT_BEYOND || goes_round(march, arm, d);
    return status;
}

static double gauss_at(const struct stop *stop) {
    double gauss = stop->known ? surface_point_gauss_curvature(&stop->point) : 0;
    return isfinite(gauss) ? gauss : 0;
}

int32_t march_arm_stops(struct march *march, int number, int32_t count, struct march_stop *stops) {
    struct arm arm = make_arm(march, number);
    struct stop *at = &arm.at, before, middle;
    double d = march->settings->spacing[arm.dj != 0], gauss_before = 0;
    bool chords = march->method->yarn == DRAPE_YARN_CHORD;
    for (int32_t k = 0; k < count; k++) {
        if (!arm.started || !at->known)
            return k;
        stops[k] = (struct march_stop){.gone = at->path.gone,
                                       .r = at->point.jet.r,
                                       .tangent = at->tangent,
                                       .left = vec3_cross(at->point.normal, at->tangent),
                                       .gauss = gauss_at(at),
                                       .gauss_before = gauss_before};
        before = *at;
        arm.started = (chords ? path_advance_chord(&at->path, &march->cursor, d)
                              : path_advance(&at->path, d)) &&
                      find_stop_point(march, at);
        middle = before;
        gauss_before = path_advance(&middle.path, (at->path.gone - before.path.gone) / 2) &&
                               find_stop_point(march, &middle)
                           ? gauss_at(&middle)
                           : 0;
    }
    return count;
}

/* All four side by side, so that on a closed surface they meet half way. */
enum status march_generators(struct march *march) {
    struct arm arms[4];
    enum surface_point_zone zone;
    enum status status = march_place(march, 0, 0, &march->start.point, &zone);
    if (status == STATUS_OK && zone == SURFACE_POINT_BEYOND)
        return STATUS_START_STUCK;
    for (int a = 0; a < 4; a++)
        arms[a] = make_arm(march, a);
    bool going = true;
    for (int32_t k = 1; going && status == STATUS_OK; k++) {
        going = false;
        for (int a = 0; a < 4 && status == STATUS_OK; a++) {
            if (!arms[a].ended)
                status = grow_arm(march, &arms[a], k);
            going = going || !arms[a].ended;
        }
    }
    return status;
}
