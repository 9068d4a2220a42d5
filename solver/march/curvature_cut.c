/* SPDX-License-Identifier: MIT */
#include "curvature_cut.h"

#include "solver/path/path.h"
#include "solver/shell/crossing.h"
#include <string.h>

/* Normal curvatures that differ by less than this share of themselves have no directions of their
 * own. */
static const double roundest = 1e-3;

/* From step to step, and over joints, a line turns by less than 26 degrees. */
static const double straight_cosine = 0.9;

/* Halvings of a step that find where it leaves a face, and by what share of it the next face is
 * entered. A line that goes over so many edges without a whole step between them goes back and
 * forth over one along which it runs, and is given up. */
enum { HALVINGS_TO_EDGE = 48, EDGES_MOST = 16 };
static const double past_edge = 1e-6;

/* Of a line that comes back: rounds in which its last step is found, steps that it has at the
 * least, how many times as many find its half, and how near it comes to where it began, in steps.
 */
enum { ROUNDS_BACK = 4, LEAST_ROUND = 4, FINER = 4 };
static const double off_place = 1e-2;

/* Places that a line may have, and how many of its steps one round the section has. */
enum { PLACES_MOST = 20000, STEPS_ROUND = 4 };

/* A line of curvature on its way, of which places are kept where there is room. */
struct curvature_line {
    struct surface_cursor cursor;
    struct surface_point at;
    struct vec3 along; /* unit */
    double step;
    struct shell_slit_piece *pieces;
    double (*uv)[2];
    struct vec3 *r;
    size_t count, used, room; /* pieces, places, and room for both */
    double gone;              /* its length so far */
    int edges;                /* over which it has gone since its last whole step */
};

/* The directions of principal curvature, where these differ. */
static bool find_principal(const struct surface_point *point, struct vec3 principal[2]) {
    double mean, half;
    surface_point_principal_curvatures(point, &mean, &half);
    return half > roundest * fabs(mean) && surface_point_principal(point, principal);
}

/* That of them which is next to `near`. */
static bool principal_near(const struct surface_point *point, struct vec3 near,
                           struct vec3 *direction) {
    struct vec3 principal[2];
    if (!find_principal(point, principal))
        return false;
    bool second = fabs(vec3_dot(principal[1], near)) > fabs(vec3_dot(principal[0], near));
    double cosine = vec3_dot(principal[second], near);
    *direction = vec3_scale(cosine < 0 ? -1 : 1, principal[second]);
    return fabs(cosine) > straight_cosine;
}

/* Where a step of the length h leads, by the Runge-Kutta method of fourth order in the parameters
 * of the face. */
static bool step_along(struct curvature_line *line, double h, struct surface_point *to,
                       struct vec3 *along) {
    static const double before[4] = {0, 0.5, 0.5, 1}, weight[4] = {1, 2, 2, 1};
    double rate[2] = {0, 0}, sum[2] = {0, 0}, uv[2];
    for (int stage = 0; stage < 4; stage++) {
        for (int k = 0; k < 2; k++)
            uv[k] = line->at.uv[k] + before[stage] * h * rate[k];
        if (!surface_point_at(line->at.surface, &line->cursor, uv, to) ||
            !principal_near(to, line->along, along) || !surface_point_components(to, *along, rate))
            return false;
        for (int k = 0; k < 2; k++)
            sum[k] += weight[stage] / 6 * rate[k];
    }
    for (int k = 0; k < 2; k++)
        uv[k] = line->at.uv[k] + h * sum[k];
    return surface_point_at(line->at.surface, &line->cursor, uv, to) &&
           principal_near(to, line->along, along);
}

static bool keep_place(struct curvature_line *line) {
    if (line->room == 0)
        return true;
    if (line->used == line->room)
        return false;
    memcpy(line->uv[line->used], line->at.uv, sizeof *line->uv);
    line->r[line->used++] = line->at.jet.r;
    line->pieces[line->count - 1].count++;
    return true;
}

static bool begin_piece(struct curvature_line *line, bool begins) {
    if (line->room > 0 && line->used < line->room)
        line->pieces[line->count++] = (struct shell_slit_piece){.face = line->at.surface->face,
                                                                .uv = line->uv + line->used,
                                                                .r = line->r + line->used,
                                                                .begins = begins};
    return keep_place(line);
}

/* Goes on to the edge of the face that a step crosses, and over it: to the next face, or nowhere on
 * the shell's boundary. */
static bool cross_edge(struct curvature_line *line, bool *ends) {
    double inside = 0, outside = line->step;
    struct surface_point to;
    struct crossing crossing;
    struct vec3 along;
    if (++line->edges > EDGES_MOST)
        return false;
    for (int k = 0; k < HALVINGS_TO_EDGE; k++) {
        double middle = (inside + outside) / 2;
        if (!step_along(line, middle, &to, &along))
            return false;
        bool within = crossing_within(to.surface, to.uv);
        inside = within ? middle : inside;
        outside = within ? outside : middle;
    }
    if (!step_along(line, fmin(outside + past_edge * line->step, line->step), &to, &along))
        return false;
    struct surface_point beyond = to;
    crossing_find(&to, NULL, &crossing);
    *ends = crossing.kind == CROSSING_FREE;
    if (!step_along(line, inside, &to, &line->along))
        return false;
    line->at = to;
    line->gone += fmin(outside + past_edge * line->step, line->step);
    if (!keep_place(line))
        return false;
    if (*ends || crossing.kind == CROSSING_NONE)
        return true;
    along = crossing_turn(&crossing, along);
    if (!crossing_settle(&line->cursor, &beyond) || beyond.surface == line->at.surface)
        return false;
    line->at = beyond;
    return principal_near(&line->at, along, &line->along) && begin_piece(line, false);
}

/* Goes on by a step, or over the edge of the face in its way. */
static bool follow_step(struct curvature_line *line, bool *ends) {
    struct surface_point to;
    struct vec3 along;
    if (!step_along(line, line->step, &to, &along))
        return false;
    if (!crossing_within(to.surface, to.uv))
        return cross_edge(line, ends);
    line->at = to;
    line->along = along;
    line->gone += line->step;
    line->edges = 0;
    return keep_place(line);
}

/* Goes on along the line to the shell's boundary. */
static bool follow(struct curvature_line *line, double most) {
    bool ends = false;
    for (double gone = 0; gone < most && !ends; gone += line->step)
        if (!follow_step(line, &ends))
            return false;
    return ends;
}

/* The last step of a line that comes back: how far ahead, within a step, it has a place; negative
 * where that lies elsewhere. */
static double find_last_step(struct curvature_line *line, struct vec3 place) {
    struct surface_point to = line->at;
    struct vec3 along = line->along, way = vec3_sub(place, to.jet.r);
    double ahead = 0;
    if (vec3_norm(way) > 1.5 * line->step || vec3_dot(way, along) < 0)
        return -1;
    for (int k = 0; k < ROUNDS_BACK; k++) {
        ahead += vec3_dot(way, along);
        if (!(ahead >= 0 && ahead <= line->step) || !step_along(line, ahead, &to, &along))
            return -1;
        way = vec3_sub(place, to.jet.r);
    }
    if (vec3_norm(way) > off_place * line->step)
        return -1;
    line->at = to;
    line->along = along;
    return ahead;
}

/* Goes round the line to where it begins; its length, 0 where it does not come back. */
static double follow_round(struct curvature_line *line, double most) {
    struct vec3 place = line->at.jet.r;
    bool ends = false;
    line->gone = 0;
    while (line->gone < most && !ends) {
        if (!follow_step(line, &ends))
            return 0;
        double last = line->gone > LEAST_ROUND * line->step ? find_last_step(line, place) : -1;
        if (last >= 0)
            return keep_place(line) ? line->gone + last : 0;
    }
    return 0;
}

/* Goes on along the line by a length. */
static bool follow_length(struct curvature_line *line, double length) {
    double step = line->step, least = past_edge * step;
    bool ends = false;
    for (line->gone = 0; length - line->gone > least && !ends;) {
        line->step = fmin(step, length - line->gone);
        if (!follow_step(line, &ends))
            return false;
    }
    line->step = step;
    return !ends;
}

/* The girth of the tube: the length of its section through the start by a plane; 0 where that does
 * not come back within the length `most`. */
static double girth_in(const struct surface_point *start, struct vec3 plane, double step,
                       double most) {
    struct surface_cursor cursor = {0};
    struct path path;
    struct surface_point at;
    struct vec3 tangent;
    struct crossing crossing;
    if (!path_section(&path, start->surface, start, plane, vec3_cross(plane, start->normal)))
        return 0;
    for (double gone = step; gone < most; gone += step) {
        if (!path_advance(&path, step) || !path_surface_point(&path, &cursor, &at, &tangent))
            return 0;
        crossing_find(&at, NULL, &crossing);
        if (crossing.kind == CROSSING_FREE)
            return 0;
        struct vec3 to = vec3_sub(start->jet.r, at.jet.r);
        double ahead = vec3_dot(to, tangent);
        if (gone < 3 * step || vec3_norm(to) > 1.5 * step || !(ahead >= 0) || ahead > step)
            continue;
        if (!path_advance(&path, ahead) || !path_surface_point(&path, &cursor, &at, &tangent))
            return 0;
        to = vec3_sub(start->jet.r, at.jet.r);
        ahead += vec3_dot(to, tangent);
        return vec3_norm(to) < step / 4 ? gone + ahead : 0;
    }
    return 0;
}

/* The place half way round, and which way the tube goes there; the girth, 0 where there is none. */
static double find_opposite(const struct surface_point *start, double step, double most,
                            struct curvature_line *line) {
    struct vec3 principal[2], plane = {0, 0, 0}, tangent;
    double girth = 0;
    struct path path;
    if (!find_principal(start, principal))
        return 0;
    for (int k = 0; k < 2; k++) {
        double own = girth_in(start, principal[k], step, girth > 0 ? girth : most);
        plane = own > 0 ? principal[k] : plane;
        girth = own > 0 ? own : girth;
    }
    bool found =
        girth > 0 &&
        path_section(&path, start->surface, start, plane, vec3_cross(plane, start->normal)) &&
        path_advance(&path, girth / 2) &&
        path_surface_point(&path, &line->cursor, &line->at, &tangent) &&
        crossing_settle(&line->cursor, &line->at) &&
        principal_near(&line->at, vec3_cross(line->at.normal, tangent), &line->along);
    return found ? girth : 0;
}

/* For the places of a line of twice that length. */
static bool make_line_room(struct curvature_line *line, double most, struct arena *arena) {
    line->room = (size_t)fmin(2 * most / line->step, PLACES_MOST);
    line->pieces = arena_alloc(arena, line->room, sizeof *line->pieces);
    line->uv = arena_alloc(arena, line->room, sizeof *line->uv);
    line->r = arena_alloc(arena, line->room, sizeof *line->r);
    return line->pieces && line->uv && line->r;
}

/* First from the place opposite the start to one border, and then from there to the other. */
enum status curvature_cut_make(const struct surface_point *start, double step, double most,
                               struct arena *arena, struct curvature_cut *cut) {
    struct curvature_line line = {.step = step};
    *cut = (struct curvature_cut){.girth = find_opposite(start, STEPS_ROUND * step, most, &line)};
    cut->opposite = line.at.jet.r;
    for (int k = 0; k < 2 && cut->girth > 0; k++)
        line.at.uv[k] = surface_axis_wrap(&line.at.surface->axis[k], line.at.uv[k]);
    if (!(cut->girth > 0) || !follow(&line, most))
        return STATUS_OK;
    line.along = vec3_scale(-1, line.along);
    if (!make_line_room(&line, most, arena))
        return STATUS_OUT_OF_MEMORY;
    bool arrives = begin_piece(&line, true) && follow(&line, 2 * most);
    line.pieces[line.count - 1].ends = true;
    cut->pieces = line.pieces;
    cut->count = arrives ? line.count : 0;
    return STATUS_OK;
}

/* Half way round the line through the start that sets off along `along`, with shorter steps, whose
 * error is that of the place. */
static bool follow_half_round(const struct surface_point *start, struct vec3 along, double step,
                              double most, struct curvature_line *line) {
    const struct curvature_line begin = {.at = *start, .along = along, .step = step / FINER};
    *line = begin;
    double round = follow_round(line, most);
    *line = begin;
    bool found = round > 0 && follow_length(line, round / 2);
    line->step = step;
    return found;
}

/* Half way round one family's line through the start the other's is opposite. */
enum status curvature_cut_rings(const struct surface_point *start, double step, double most,
                                struct arena *arena, struct curvature_cut cut[2]) {
    struct vec3 principal[2];
    cut[0] = cut[1] = (struct curvature_cut){.count = 0};
    if (!find_principal(start, principal))
        return STATUS_OK;
    for (int k = 0; k < 2; k++) {
        struct curvature_line line;
        if (!follow_half_round(start, principal[k], step, most, &line) ||
            !principal_near(&line.at, vec3_cross(line.at.normal, line.along), &line.along))
            break;
        if (!make_line_room(&line, most, arena))
            return STATUS_OUT_OF_MEMORY;
        if (!begin_piece(&line, false) || !(follow_round(&line, most) > 0))
            break;
        cut[k] = (struct curvature_cut){.pieces = line.pieces, .count = line.count};
    }
    cut[0].count = cut[1].count > 0 ? cut[0].count : 0;
    return STATUS_OK;
}
