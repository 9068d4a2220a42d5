/* SPDX-License-Identifier: MIT */
#include "laid_courses.h"

#include "course_limits.h"

#include "api/request/prepared_part.h"
#include "solver/shell/shell.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Places of a near edge beyond the columns of its net that are kept at both ends. */
enum { PLACES_BEYOND = 4 };

/* So many places along a joint are looked at for the stagger. */
enum { STAGGER_PLACES = 33 };

struct laying {
    const struct laminate *laminate;
    size_t ply;
    struct course_limits limits; /* of it */
    struct prepared_part shape;
    struct arena *arena; /* what stays */
    struct api_problem *problem;
};

/* ---- what cannot be laid ---- */

/* The first point of the path that is off the part, or else the path. */
static enum api_problem_id refuse_path(const struct laying *l,
                                       const struct courses_settings *settings) {
    const struct drape_part *part = &l->shape.part;
    char member[64] = "/courses/along/path";
    for (size_t n = 0; n < settings->path_count; n++) {
        double uv[2], distance;
        struct shell_point nearest;
        if (part->shell)
            shell_nearest(part->shell, settings->path[n], SHELL_ANY, &nearest, &distance);
        else
            surface_nearest(part->surface, settings->path[n], uv, &distance);
        if (distance > settings->drape.spacing[0]) {
            (void)snprintf(member, sizeof member, "/courses/along/path/%zu", n);
            break;
        }
    }
    return course_limits_refuse(
        &l->limits, API_INVALID_REQUEST, member,
        "is further from the part than the spacing, or the way to it is: move it onto "
        "the part, or give the path more points");
}

/* What stopped the courses, the first of them `faulty`. */
static enum api_problem_id refuse_status(const struct laying *l,
                                         const struct courses_settings *settings,
                                         enum status status, size_t faulty) {
    char text[300];
    switch (status) {
    case STATUS_OUT_OF_MEMORY:
        return api_problem_no_memory(l->problem, "the courses");
    case STATUS_TOO_MANY_NODES:
        (void)snprintf(text, sizeof text,
                       "is too small: course %zu would have more than the %zu nodes allowed",
                       faulty + 1, settings->drape.max_nodes);
        return course_limits_refuse(&l->limits, API_INVALID_REQUEST, "/fabric/spacing", text);
    case STATUS_START_OFF_SURFACE:
        if (settings->along == COURSES_ALONG_PATH)
            return refuse_path(l, settings);
        return settings->along == COURSES_ALONG_EDGE
                   ? course_limits_refuse(
                         &l->limits, API_INVALID_REQUEST, "/courses/along/edge",
                         "is further than a spacing from every edge of the part: give a "
                         "point next to the edge")
                   : course_limits_refuse(&l->limits, API_START_OFF_SURFACE, "/start",
                                          "must be on the surface, or within the spacing of it");
    case STATUS_START_STUCK:
        return course_limits_refuse(
            &l->limits, API_INVALID_REQUEST, "/courses",
            "do not lie on the part: the first one is beyond it. Take another "
            "first_offset or the other order");
    case STATUS_DEGENERATE_SURFACE:
        return course_limits_refuse(&l->limits, API_DEGENERATE_SURFACE, "/courses",
                                    "begin, or run, where the surface has no tangent plane");
    case STATUS_NO_CONVERGENCE:
        (void)snprintf(
            text, sizeof text,
            "cannot be followed: course %zu has no near edge, because the line that it "
            "is a parallel of bends more sharply than the distance to it, or ends before "
            "the part does. Lay courses along another line, or in the other order",
            faulty + 1);
        return course_limits_refuse(&l->limits, API_INVALID_REQUEST, "/courses/along", text);
    default:
        return course_limits_refuse(
            &l->limits, API_INVALID_REQUEST, "/direction",
            "must not be at right angles to the surface where the courses begin");
    }
}

/* ---- what is laid ---- */

/* The settings of the ply, its first course laid back by the stagger of the plies before it. */
static bool settle_courses(const struct laying *l, size_t number,
                           const struct laminate_courses *courses,
                           const struct api_request *request, struct courses_settings *settings) {
    course_limits_settle(&courses->lay, &request->settings, settings);
    size_t count = settings->first.count ? settings->first.count : 1;
    double pitch = settings->widths[0] + settings->gaps[0].values[0];
    double back = fmod((double)number * courses->stagger, pitch);
    double *values = arena_alloc(l->arena, count, sizeof *values);
    for (size_t n = 0; values && n < count; n++)
        values[n] = (settings->first.count ? settings->first.values[n] : 0) - back;
    settings->first = (struct courses_offset){values, count};
    return values;
}

/* The places of the near edge as the request counts faces, as far as the net goes. */
static bool keep_places(const struct laying *l, const struct course *course,
                        struct drape_generator *generator) {
    size_t first = 0, end = course->place_count, start = course->place_start;
    const int32_t *range = course->net.warp_range;
    if ((int64_t)start + range[0] - PLACES_BEYOND > 0)
        first = start - (size_t)(PLACES_BEYOND - range[0]);
    if (start + (size_t)range[1] + PLACES_BEYOND + 1 < end)
        end = start + (size_t)range[1] + PLACES_BEYOND + 1;
    struct drape_place *places = arena_alloc(l->arena, end - first, sizeof *places);
    for (size_t n = first; places && n < end; n++) {
        places[n - first] = course->places[n];
        if (l->shape.part.shell)
            places[n - first].face = l->shape.shell.numbers[course->places[n].face];
    }
    *generator = (struct drape_generator){.kind = DRAPE_GENERATOR_PLACES,
                                          .places = places,
                                          .place_count = end - first,
                                          .place_start = start - first};
    return places;
}

static void set_figures(const struct course *course, bool wanted, bool first,
                        double figures[COURSE_FIGURES]) {
    const struct drape_summary *summary = &course->net.summary;
    const double own[COURSE_FIGURES] = {
        [COURSE_WIDTH] = course->width,
        [COURSE_CUT_LENGTH] = course->cut_length,
        [COURSE_AREA] = course->area,
        [COURSE_NET_AREA] = course->net_area,
        [COURSE_TRIM_AREA] = course->trim_area,
        [COURSE_COVERAGE] = (summary->cloth_area - course->overlap_area) / summary->part_area,
        [COURSE_MEAN_SHEAR] = summary->mean_shear_deg,
        [COURSE_MAX_SHEAR] = summary->max_shear_deg,
        [COURSE_WANTED] = course->wanted_deg,
        [COURSE_WANTED_MOST] = course->wanted_most_deg,
        [COURSE_GAP_LEAST] = course->gap[0],
        [COURSE_GAP_MOST] = course->gap[1],
        [COURSE_GAP_AREA] = course->gap_area,
        [COURSE_OVERLAP_AREA] = course->overlap_area,
        [COURSE_STAGGER] = (double)NAN};
    memcpy(figures, own, sizeof own);
    if (!wanted)
        figures[COURSE_WANTED] = figures[COURSE_WANTED_MOST] = NAN;
    if (first)
        figures[COURSE_GAP_LEAST] = figures[COURSE_GAP_MOST] = NAN;
}

/* The drape of a course: the ply's, along its places and as wide as it is. */
static bool make_course_piece(const struct laying *l, const struct courses_settings *settings,
                              const struct course *course, size_t number,
                              struct laminate_piece *piece) {
    const struct laminate_ply *ply = &l->laminate->plies[l->ply];
    char *name = arena_alloc(l->arena, LAMINATE_NAME_MAX + 1, 1);
    *piece = (struct laminate_piece){.name = name, .drape = ply->drape};
    struct drape_settings *drape = &piece->drape.settings;
    if (!name || !keep_places(l, course, &drape->generator[0]))
        return false;
    (void)snprintf(name, LAMINATE_NAME_MAX + 1, "course_%zu", number + 1);
    const struct drape_place *start = &course->places[course->place_start];
    const struct shell *shell = l->shape.part.shell;
    bool turned = shell && shell_side(shell, start->face) < 0;
    bool right = course->to_right != turned;
    drape->start_kind = DRAPE_START_CENTROID;
    drape->spacing[1] = course->spacing[1];
    drape->has_extent[1] = true;
    drape->extent[1][0] = right ? -course->rows : 0;
    drape->extent[1][1] = right ? 0 : course->rows;
    set_figures(course, vec3_norm2(settings->wanted) > 0, number == 0, piece->figures);
    return true;
}

/* ---- stagger ---- */

static double distance_from_joint(struct vec3 r, const struct vec3 *points, size_t count) {
    double least = HUGE_VAL;
    for (size_t n = 1; n < count; n++) {
        struct vec3 way = vec3_sub(points[n], points[n - 1]), to = vec3_sub(r, points[n - 1]);
        double share = vec3_dot(to, way) / vec3_norm2(way);
        struct vec3 foot = vec3_axpy(fmin(fmax(share, 0), 1), way, points[n - 1]);
        least = fmin(least, vec3_distance(foot, r));
    }
    return least;
}

/* The least distance of a joint's places from those of the ply below. */
static double find_stagger(const struct vec3 *points, size_t count, const struct joints *below) {
    double least = NAN;
    size_t places = count < STAGGER_PLACES ? count : STAGGER_PLACES;
    for (size_t k = 0; k < below->count; k++)
        for (size_t n = 0; n < places; n++) {
            size_t at = places > 1 ? n * (count - 1) / (places - 1) : 0;
            size_t from = below->first[k], own = below->first[k + 1] - from;
            if (own > 1)
                least = fmin(least, distance_from_joint(points[at], below->points + from, own));
        }
    return least;
}

/* The nodes of the near edges of all courses but the first, in order along them. */
static bool make_joints(const struct courses_result *laid, struct arena *arena,
                        struct joints *joints) {
    size_t total = 0, count = laid->count;
    for (size_t k = 1; k < count; k++)
        total +=
            (size_t)(laid->courses[k].net.warp_range[1] - laid->courses[k].net.warp_range[0]) + 1;
    struct vec3 *points = arena_alloc(arena, total + 1, sizeof *points);
    bool *there = arena_alloc(arena, total + 1, sizeof *there);
    size_t *first = arena_alloc(arena, count + 1, sizeof *first), end = 0, at = 0;
    if (!points || !there || !first)
        return false;
    for (size_t k = 1; k < count; k++) {
        const struct drape_nodes *nodes = &laid->courses[k].net.nodes;
        const int32_t *range = laid->courses[k].net.warp_range;
        for (size_t n = 0; n < nodes->count; n++)
            if (nodes->j[n] == 0) {
                size_t place = at + (size_t)(nodes->i[n] - range[0]);
                points[place] = vec3_make(nodes->x[n], nodes->y[n], nodes->z[n]);
                there[place] = true;
            }
        first[k - 1] = end;
        for (size_t last = at + (size_t)(range[1] - range[0]); at <= last; at++)
            if (there[at])
                points[end++] = points[at];
        first[k] = end;
    }
    *joints = (struct joints){points, first, count > 0 ? count - 1 : 0};
    return true;
}

/* ---- the whole ---- */

/* The courses that have cloth on the part become the pieces. */
static enum api_problem_id keep_courses(const struct laying *l,
                                        const struct courses_settings *settings,
                                        const struct courses_result *laid, struct joints *below,
                                        struct laminate_pieces *pieces) {
    struct laminate_piece *all = arena_alloc(l->arena, laid->count + 1, sizeof *all);
    struct joints joints;
    size_t count = 0;
    if (!all || !make_joints(laid, l->arena, &joints))
        return api_problem_no_memory(l->problem, "the courses");
    for (size_t n = 0; n < laid->count; n++) {
        const struct course *course = &laid->courses[n];
        if (!(course->net_area > 0))
            continue;
        if (!make_course_piece(l, settings, course, count, &all[count]))
            return api_problem_no_memory(l->problem, "the courses");
        if (n > 0)
            all[count].figures[COURSE_STAGGER] = find_stagger(
                joints.points + joints.first[n - 1], joints.first[n] - joints.first[n - 1], below);
        count++;
    }
    pieces->pieces = all;
    pieces->count = count;
    *below = joints;
    return count > 0 ? API_OK : refuse_status(l, settings, STATUS_START_STUCK, 0);
}

enum api_problem_id laid_courses_make(const struct laminate *laminate, size_t k, size_t number,
                                      const struct api_limits *limits, struct arena *arena,
                                      struct joints *below, struct laminate_pieces *pieces,
                                      struct api_problem *problem) {
    struct laying l = {
        .laminate = laminate,
        .ply = k,
        .arena = arena,
        .problem = problem,
        .limits = {.part = &l.shape.part, .unit = laminate->length_unit, .problem = problem}};
    (void)snprintf(l.limits.prefix, sizeof l.limits.prefix, "/plies/%zu",
                   laminate->plies[k].number);
    struct api_request request = laminate_drape(laminate, k);
    struct courses_settings settings;
    struct courses_result laid;
    struct api_problem own = {.id = API_OK};
    struct arena *scratch = arena_new(limits->max_memory);
    if (!scratch)
        return api_problem_no_memory(problem, "the courses");
    request.settings.has_extent[0] = request.settings.has_extent[1] = true;
    if (prepared_part_make(&request, limits, scratch, &l.shape, &own) != API_OK ||
        prepared_part_settle(&l.shape, scratch, &request.settings, &own) != API_OK)
        laminate_fault_of_ply(laminate, k, &own, problem);
    else if (!settle_courses(&l, number, pieces->courses, &request, &settings))
        api_problem_no_memory(problem, "the courses");
    else if (course_limits_check(&l.limits, &settings) == API_OK) {
        enum status status = courses_lay(&l.shape.part, &settings, NULL, scratch, &laid);
        if (status != STATUS_OK)
            (void)!refuse_status(&l, &settings, status, laid.faulty);
        else if (laid.count > LAMINATE_COURSES_MAX)
            (void)!course_limits_refuse(
                &l.limits, API_INVALID_REQUEST, "/courses/width",
                "takes more than 255 courses, which are allowed: take a wider roll");
        else
            (void)!keep_courses(&l, &settings, &laid, below, pieces);
    }
    arena_free(scratch);
    return problem->id;
}
