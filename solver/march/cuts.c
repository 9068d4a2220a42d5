/* SPDX-License-Identifier: MIT */
#include "cuts.h"

#include "solver/laid_line.h"
#include "solver/mesh/mesh.h"
#include "solver/net/curtain.h"
#include "solver/shell/crossing.h"
#include "solver/surface/trim.h"
#include <stdlib.h>
#include <string.h>

/* A line may pass so far above the part, as a share of its length, before it is moved to it. */
static const double rise_share = 1e-3;

/* The steps in which a path is followed, as a share of the spacing. */
static const double path_step = 0.25;

/* How far beside a line its lips are taken, as a share of the spacing and at least beyond what is
 * taken to be on a joint: so each lies on the face on its side. */
static const double beside = 1e-6, beside_joint = 4;

/* Two lines on faces change from one to the other within this share of a step. */
static const double change = 1e-12;

/* How high the curtain is, in spacings: no chord over a fold is deeper; and in radii of curvature:
 * chords of yarns rise less, and beyond lies the other side of a tube. */
static const double curtain_height = 1, curtain_radii = 0.7;

/* A line goes on beyond the edge at which it begins as far as ghosts do, in spacings, or to where
 * the part begins again: on the other side of a hole. It may begin so far inside, or beside a cut
 * before it, at which it then begins. */
static const double beyond = 10, inside_edge = 0.5, on_part = 0.1;

/* A start, or a line, that is nearer to a cut than this share of a spacing lies on it. */
static const double on_cut = 1e-6;

/* A path in space, by its length from its first point. */
struct path_line {
    struct drape_cut_line cut;
    double *at; /* of each point */
    double length;
};

struct maker {
    struct march *march;
    const struct cuts *laid; /* the cuts before */
    struct path_line line;
    double spacing, aside;
    double *stops; /* lengths at which the line is looked at, rising */
    size_t count, room;
};

static struct vec3 path_at(const struct path_line *line, double s, struct vec3 *along) {
    size_t k = 1;
    while (k + 1 < line->cut.count && line->at[k] < s)
        k++;
    const struct vec3 *p = &line->cut.path[k - 1];
    *along = vec3_unit(vec3_sub(p[1], p[0]));
    return vec3_axpy(s - line->at[k - 1], *along, p[0]);
}

bool cuts_nearest(struct march *march, struct vec3 r, struct surface_point *place) {
    double distance;
    if (!march->surface) {
        struct mesh_point nearest;
        int32_t component =
            march->mesh->component[march_mesh_point_of(&march->start.point).triangle];
        bool found = mesh_nearest(march->mesh, r, component, &nearest, NULL);
        if (found)
            *place = march_mesh_point(march, &nearest);
        return found;
    }
    return surface_point_nearest(march->surface, &march->cursor, r, place, &distance) &&
           !surface_point_at_pole(place->surface, place);
}

/* Lips end so near to the ends of the line, as a share of the spacing: there, at a pole or a corner
 * of faces, what lies to the left and to the right may not be told. */
static const double at_end = 1e-3;

/* The place of the line at s, from one near it or, where that is no place, from anywhere. */
static bool place_on_line(struct maker *m, double s, struct surface_point *place,
                          struct vec3 *along) {
    struct vec3 r = path_at(&m->line, s, along);
    struct surface_point near = *place;
    double distance;
    bool found = near.surface
                     ? surface_point_nearest_from(&m->march->cursor, &near, r, place, &distance) &&
                           !surface_point_at_pole(place->surface, place)
                     : cuts_nearest(m->march, r, place);
    if (!found)
        place->surface = NULL;
    return found;
}

/* Where its lips have a place beside that at s. */
static double lip_at(const struct maker *m, double s) {
    return fmax(at_end * m->spacing, fmin(s, m->line.length - at_end * m->spacing));
}

/* The place of the lip on the left (side 1) or right (-1) of a place of the line. */
static struct surface_point place_beside_cut(struct maker *m, const struct surface_point *place,
                                             struct vec3 along, int side) {
    struct surface_cursor *cursor = &m->march->cursor;
    struct vec3 step = vec3_scale(side * m->aside, vec3_unit(vec3_cross(place->normal, along)));
    struct surface_point there;
    if (!m->march->surface)
        return cuts_nearest(m->march, vec3_add(place->jet.r, step), &there) ? there : *place;
    return surface_point_move(cursor, place, step, &there) &&
                   (!there.surface->shell || crossing_settle(cursor, &there))
               ? there
               : *place;
}

static bool add_stop(struct maker *m, double s) {
    if (m->count == m->room)
        m->stops = arena_enlarge(m->march->arena, m->stops, m->count, sizeof *m->stops, &m->room);
    if (m->stops)
        m->stops[m->count++] = s;
    return m->stops;
}

/* The place of a lip at s, from a place of the line near it. */
static bool find_lip(struct maker *m, double s, int side, struct surface_point *near,
                     struct surface_point *lip) {
    struct vec3 along;
    if (!place_on_line(m, lip_at(m, s), near, &along))
        return false;
    *lip = place_beside_cut(m, near, along, side);
    return true;
}

/* The stops at which a lip changes from face to face between two stops: the last before each change
 * and the first behind it. */
static bool add_changes(struct maker *m, double from, double to, int side,
                        struct surface_point *near) {
    enum { CHANGES_MOST = 32 };
    struct surface_point begin, end, middle;
    if (!find_lip(m, to, side, near, &end))
        return true;
    for (int n = 0; n < CHANGES_MOST && find_lip(m, from, side, near, &begin); n++) {
        double low = from, high = to;
        if (begin.surface == end.surface)
            return true;
        while (high - low > change * m->spacing) {
            double half = (low + high) / 2;
            if (!(half > low && half < high) || !find_lip(m, half, side, near, &middle))
                break;
            if (middle.surface == begin.surface)
                low = half;
            else
                high = half;
        }
        if (!add_stop(m, low) || !add_stop(m, high))
            return false;
        from = high;
    }
    return true;
}

static int compare_stops(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Stops in small steps, at the points of the path, and wherever a lip changes its face. */
static enum status find_stops(struct maker *m) {
    const struct path_line *line = &m->line;
    m->stops = NULL;
    m->count = m->room = 0;
    bool all = add_stop(m, 0);
    for (size_t k = 1; k < line->cut.count; k++) {
        double length = line->at[k] - line->at[k - 1];
        size_t steps = 1 + (size_t)fmin(length / (path_step * m->spacing), 1e5);
        for (size_t n = 1; n <= steps && all; n++)
            all = add_stop(m, line->at[k - 1] + length * (double)n / (double)steps);
    }
    struct surface_point near = {.surface = NULL};
    size_t steps = m->count;
    for (size_t k = 1; k < steps && all && m->march->surface && m->march->surface->shell; k++)
        all = add_changes(m, m->stops[k - 1], m->stops[k], 1, &near) &&
              add_changes(m, m->stops[k - 1], m->stops[k], -1, &near);
    if (all)
        qsort(m->stops, m->count, sizeof *m->stops, compare_stops);
    return all ? STATUS_OK : STATUS_OUT_OF_MEMORY;
}

/* Adds a place to a lip: not one that is where its last one is, on the same face. Parameters of
 * closed directions go on without a jump. */
static void add_to_lip(struct maker *m, struct cut *cut, int number,
                       const struct surface_point *place) {
    struct cut_vertex *lip = cut->lip[number], *last = lip + cut->count[number] - 1;
    struct cut_vertex vertex = {
        .face = march_face(m->march, place), .uv = {place->uv[0], place->uv[1]}, .r = place->jet.r};
    bool first = cut->count[number] == 0, same = !first && last->face == vertex.face;
    for (int k = 0; k < 2 && same && place->surface; k++) {
        const struct surface_axis *axis = &place->surface->axis[k];
        double turn = surface_axis_length(axis);
        if (axis->closed)
            vertex.uv[k] += turn * round((last->uv[k] - vertex.uv[k]) / turn);
    }
    if (same && vec3_distance(last->r, vertex.r) < on_cut * m->spacing)
        return;
    if (!first)
        last->leaps = !same && place->surface;
    lip[cut->count[number]++] = vertex;
}

static double height_at(const struct maker *m, const struct surface_point *place) {
    const double *d = m->march->settings->spacing;
    double height = curtain_height * fmax(d[0], d[1]), mean = 0, spread = 0;
    if (place->surface)
        surface_point_principal_curvatures(place, &mean, &spread);
    return fmin(height, curtain_radii / (fabs(mean) + spread));
}

/* The place of a cut's left lip that is nearest to a place, and how far that is. */
static double nearest_on_cut(const struct cut *cut, struct vec3 r, struct vec3 *nearest) {
    double least = HUGE_VAL;
    for (size_t k = 0; k + 1 < cut->count[0]; k++) {
        struct vec3 from = cut->lip[0][k].r, along = vec3_sub(cut->lip[0][k + 1].r, from);
        double share = vec3_dot(vec3_sub(r, from), along) / vec3_norm2(along);
        struct vec3 at = vec3_axpy(share > 0 ? fmin(share, 1) : 0, along, from);
        if (!(vec3_distance(at, r) < least))
            continue;
        least = vec3_distance(at, r);
        *nearest = at;
    }
    return least;
}

/* Whether a place in space lies on what is to be covered. */
static bool is_on_part(const struct maker *m, struct vec3 r) {
    struct march *march = m->march;
    struct surface_point place;
    double uv[2];
    if (!cuts_nearest(march, r, &place) || vec3_distance(place.jet.r, r) > on_part * m->spacing)
        return false;
    return !march->trim || (march_parameters(march, &place, uv) && trim_contains(march->trim, uv));
}

/* Where the curtain of a line begins that comes from `start` in the direction `along`. */
static struct vec3 begin_curtain(const struct maker *m, struct vec3 start, struct vec3 along) {
    const double *d = m->march->settings->spacing;
    struct vec3 nearest = start;
    for (size_t k = 0; k < m->laid->count; k++)
        if (nearest_on_cut(&m->laid->cut[k], start, &nearest) <= inside_edge * m->spacing)
            return nearest;
    double far = inside_edge * m->spacing, most = beyond * fmax(d[0], d[1]);
    while (far < most && !is_on_part(m, vec3_axpy(-far, along, start)))
        far += path_step * m->spacing;
    return vec3_axpy(-far, along, start);
}

/* The lips of a cut, and the posts of its curtain, which begins beyond the edge. */
static enum status lay_cut(struct maker *m, struct cut *cut, struct curtain_line *line,
                           struct cut_fault *fault) {
    struct arena *arena = m->march->arena;
    enum status status = find_stops(m);
    struct curtain_post *posts = arena_alloc(arena, m->count + 1, sizeof *posts);
    for (int k = 0; k < 2; k++)
        cut->lip[k] = arena_alloc(arena, m->count, sizeof *cut->lip[k]);
    if (status != STATUS_OK || !posts || !cut->lip[0] || !cut->lip[1])
        return STATUS_OUT_OF_MEMORY;
    line->posts = posts;
    line->count = 1;
    struct surface_point place = {.surface = NULL}, lip;
    for (size_t k = 0; k < m->count; k++) {
        double s = m->stops[k], inside = lip_at(m, s);
        struct vec3 along, r = path_at(&m->line, s, &along), normal = {0, 0, 0};
        fault->at = r;
        fault->kind = CUT_OFF_PART;
        if ((!place_on_line(m, s, &place, &along) && !place_on_line(m, inside, &place, &along)) ||
            !(vec3_distance(place.jet.r, r) <= m->spacing))
            return STATUS_CUT;
        posts[line->count].r = place.jet.r;
        posts[line->count].height = height_at(m, &place);
        if (inside != s && !place_on_line(m, inside, &place, &along))
            return STATUS_CUT;
        for (int side = 1; side >= -1; side -= 2) {
            lip = place_beside_cut(m, &place, along, side);
            normal = vec3_add(normal, lip.normal);
            add_to_lip(m, cut, side < 0, &lip);
        }
        posts[line->count].normal = vec3_unit(normal);
        if (k > 0 &&
            vec3_distance(posts[line->count].r, posts[line->count - 1].r) < on_cut * m->spacing)
            continue;
        line->count++;
    }
    /* The curtain ends before the tip, along whose normal the part may go on: an edge of a box. */
    struct vec3 along;
    posts[line->count - 1].r = path_at(&m->line, m->line.length - at_end * m->spacing, &along);
    fault->kind = CUT_SHORT;
    for (size_t k = 2; k < line->count; k++)
        cut->length += vec3_distance(posts[k].r, posts[k - 1].r);
    if (!(cut->length >= m->spacing))
        return STATUS_CUT;
    posts[0] = posts[1];
    posts[0].r = begin_curtain(m, posts[1].r, vec3_unit(vec3_sub(posts[2].r, posts[1].r)));
    return STATUS_OK;
}

/* A cut that comes back to itself within this share of a spacing crosses itself: chords of steps
 * that cross on a curved part are less far apart. */
static const double on_itself = 0.02;

/* Whether a cut crosses itself, on the posts of its curtain. */
static enum status find_own_crossing(const struct maker *m, const struct curtain_line *line,
                                     size_t own, struct cut_fault *fault) {
    double within = on_itself * m->spacing;
    size_t count = 1;
    struct vec3 *points = arena_take(m->march->arena, line->count, sizeof *points), at;
    if (!points)
        return STATUS_OUT_OF_MEMORY;
    points[0] = line->posts[1].r;            /* the first post is beyond the edge */
    for (size_t k = 2; k < line->count; k++) /* short steps, at joints, may go to and fro */
        if (vec3_distance(line->posts[k].r, points[count - 1]) > within)
            points[count++] = line->posts[k].r;
    if (!laid_line_meets_itself(&(struct drape_cut_line){points, count}, within, &at))
        return STATUS_OK;
    *fault = (struct cut_fault){CUT_CROSSES_SELF, own, own, at};
    return STATUS_CUT;
}

/* Whether a cut crosses one before it: a step of it pierces that one's curtain, but the first, with
 * which it may begin there. */
static enum status find_crossed_cut(const struct maker *m, const struct curtain_line *lines,
                                    size_t own, struct cut_fault *fault) {
    const struct curtain_post *posts = lines[own].posts;
    for (size_t other = 0; other < own; other++) {
        struct curtain_line line = {lines[other].posts + 1, lines[other].count - 1};
        struct curtain *curtain;
        struct vec3 normal;
        enum status status = curtain_make(&line, 1, m->march->arena, &curtain);
        for (size_t k = 3; k < lines[own].count && status == STATUS_OK; k++) {
            if (!curtain_parts(curtain, posts[k - 1].r, posts[k].r, &normal) ||
                !(vec3_dot(normal, posts[k].normal) > 0))
                continue;
            *fault = (struct cut_fault){CUT_CROSSES, own, other, posts[k].r};
            return STATUS_CUT;
        }
        if (status != STATUS_OK)
            return status;
    }
    return STATUS_OK;
}

static bool nearest_to_cut(const void *context, struct vec3 r, struct vec3 *place,
                           struct vec3 *normal) {
    const struct maker *m = context;
    struct surface_point nearest;
    if (!cuts_nearest(m->march, r, &nearest))
        return false;
    *place = nearest.jet.r;
    *normal = nearest.normal;
    return true;
}

/* How far above the part a line may pass before it is moved to it: by the line alone, so that it is
 * the same for all nets, but within a spacing, where places are looked for. */
static double line_reach(const struct maker *m, const struct drape_cut_line *asked) {
    double length = 0;
    for (size_t k = 1; k < asked->count; k++)
        length += vec3_distance(asked->path[k - 1], asked->path[k]);
    return fmin(rise_share * length, m->spacing);
}

/* The line that is asked for, along the part. */
static enum status lay_line(struct maker *m, const struct drape_cut_line *asked) {
    const struct laid_line_part part = {nearest_to_cut, m};
    struct path_line *line = &m->line;
    enum status status =
        laid_line_make(&part, asked, line_reach(m, asked), m->march->arena, &line->cut);
    if (status == STATUS_OK)
        line->at = arena_alloc(m->march->arena, line->cut.count, sizeof *line->at);
    if (!line->at)
        return STATUS_OUT_OF_MEMORY;
    for (size_t k = 1; k < line->cut.count; k++)
        line->length = line->at[k] =
            line->at[k - 1] + vec3_distance(line->cut.path[k], line->cut.path[k - 1]);
    return STATUS_OK;
}

/* Lays the next cut along a line; where it cannot be laid there is none. */
static enum status add_next_cut(struct maker *m, struct cuts *cuts,
                                const struct drape_cut_line *asked, struct curtain_line *lines,
                                struct cut_fault *fault) {
    struct cut *cut = &cuts->cut[cuts->count];
    struct vec3 nearest;
    *fault = (struct cut_fault){.cut = cuts->count};
    m->line = (struct path_line){.at = NULL};
    enum status status = lay_line(m, asked);
    if (status == STATUS_OK)
        status = lay_cut(m, cut, &lines[cuts->count], fault);
    fault->kind = status == STATUS_OK ? CUT_AT_START : fault->kind;
    if (status == STATUS_OK &&
        nearest_on_cut(cut, m->march->start.point.jet.r, &nearest) < 1e-3 * m->spacing)
        status = STATUS_CUT;
    if (status == STATUS_OK)
        status = find_own_crossing(m, &lines[cuts->count], cuts->count, fault);
    if (status == STATUS_OK)
        status = find_crossed_cut(m, lines, cuts->count, fault);
    cuts->count += status == STATUS_OK;
    return status;
}

/* Whether a cut leads to a place, or passes by it. */
static bool is_cut_at(const struct maker *m, struct vec3 r) {
    struct vec3 nearest;
    for (size_t k = 0; k < m->laid->count; k++)
        if (nearest_on_cut(&m->laid->cut[k], r, &nearest) < m->spacing)
            return true;
    return false;
}

enum status cuts_make(struct march *march, const struct cuts_to_apexes *apexes,
                      struct cut_fault *fault) {
    const struct drape_settings *s = march->settings;
    const double *d = s->spacing;
    struct maker m = {.march = march, .spacing = fmin(d[0], d[1])};
    struct arena *arena = march->arena;
    size_t most = s->cut_count + apexes->count;
    march->cuts = NULL;
    if (most == 0)
        return STATUS_OK;
    struct cuts *cuts = arena_alloc(arena, 1, sizeof *cuts);
    struct curtain_line *lines = arena_alloc(arena, most, sizeof *lines);
    if (!cuts || !lines || !(cuts->cut = arena_alloc(arena, most, sizeof *cuts->cut)))
        return STATUS_OUT_OF_MEMORY;
    m.laid = cuts;
    m.aside = beside * m.spacing;
    if (march->surface && march->surface->shell)
        m.aside = fmax(m.aside, beside_joint * shell_joint_width(march->surface->shell));
    enum status status = STATUS_OK;
    for (size_t k = 0; k < s->cut_count && status == STATUS_OK; k++)
        status = add_next_cut(&m, cuts, &s->cuts[k], lines, fault);
    for (size_t k = 0; k < apexes->count && status == STATUS_OK; k++) {
        const struct drape_cut_line *line = &apexes->line[k];
        if (!is_cut_at(&m, line->path[line->count - 1]))
            status = add_next_cut(&m, cuts, line, lines, fault);
        status = status == STATUS_CUT ? STATUS_OK : status;
    }
    if (status != STATUS_OK || cuts->count == 0)
        return status;
    march->cuts = cuts;
    status = curtain_make(lines, cuts->count, arena, &cuts->curtain);
    if (status == STATUS_OK)
        cuts->near =
            curtain_box(cuts->curtain, (CUTS_POINT_REACH + CUTS_CELL_REACH) * fmax(d[0], d[1]));
    return status;
}
