/* SPDX-License-Identifier: MIT */
#include "course_limits.h"

#include "solver/laid_line.h"
#include "solver/shell/shell.h"
#include "solver/surface/measure.h"
#include <math.h>
#include <stdio.h>

void course_limits_settle(const struct courses_settings *lay, const struct drape_settings *drape,
                          struct courses_settings *settings) {
    *settings = *lay;
    settings->drape = *drape;
    settings->drape.has_extent[0] = settings->drape.has_extent[1] = false;
    settings->most = lay->most ? lay->most : COURSES_MAX;
}

enum api_problem_id course_limits_refuse(const struct course_limits *l, enum api_problem_id id,
                                         const char *member, const char *detail) {
    char pointer[API_POINTER_MAX];
    (void)snprintf(pointer, sizeof pointer, "%s%s", l->prefix, member);
    return id == API_INVALID_REQUEST ? api_problem_add(l->problem, pointer, "%s", detail)
                                     : api_problem_set_at(l->problem, id, pointer, "%s", detail);
}

static double box_diagonal(const struct drape_part *part) {
    struct vec3 low, high;
    if (part->shell)
        return shell_size(part->shell);
    surface_bounds(part->surface, &low, &high);
    return vec3_distance(low, high);
}

static double most_of_offset(const struct courses_offset *offset) {
    double most = 0;
    for (size_t n = 0; n < offset->count; n++)
        most = fmax(most, fabs(offset->values[n]));
    return most;
}

/* Lengths that no part of this size has room for. */
static enum api_problem_id check_lengths(const struct course_limits *l,
                                         const struct courses_settings *settings) {
    enum { SIZE = 200 };
    static const double narrowest = 1e-4; /* of the part; its lines take steps of its width */
    char text[SIZE], member[40];
    double size = box_diagonal(l->part);
    const char *unit = l->unit->name;
    for (size_t n = 0; n < settings->width_count; n++) {
        bool wide = settings->widths[n] > size;
        (void)snprintf(text, sizeof text,
                       "is %s the part, which fits a box with a diagonal of %.4g %s: take a %s "
                       "roll",
                       wide ? "wider than" : "less than a ten-thousandth of", size, unit,
                       wide ? "narrower" : "wider");
        (void)snprintf(member, sizeof member,
                       settings->width_count > 1 ? "/courses/width/%zu" : "/courses/width", n);
        if (wide || settings->widths[n] < narrowest * size)
            return course_limits_refuse(l, API_INVALID_REQUEST, member, text);
    }
    (void)snprintf(text, sizeof text,
                   "must be less than the part's size, a diagonal of %.4g %s of its box", size,
                   unit);
    if (!(most_of_offset(&settings->first) < size))
        return course_limits_refuse(l, API_INVALID_REQUEST, "/courses/first_offset", text);
    for (size_t n = 0; n < settings->gap_count; n++)
        if (!(most_of_offset(&settings->gaps[n]) < size))
            return course_limits_refuse(l, API_INVALID_REQUEST, "/courses/gap", text);
    if (!(settings->drape.spacing[0] < size))
        return course_limits_refuse(l, API_INVALID_REQUEST, "/fabric/spacing", text);
    return API_OK;
}

/* Within a spacing a course cannot be laid to the side of a path that it is beside itself. */
static enum api_problem_id check_path(const struct course_limits *l,
                                      const struct courses_settings *settings) {
    const struct drape_cut_line line = {settings->path, settings->path_count};
    struct vec3 at;
    char text[200];
    if (settings->along != COURSES_ALONG_PATH ||
        !laid_line_meets_itself(&line, settings->drape.spacing[0], &at))
        return API_OK;
    (void)snprintf(text, sizeof text,
                   "crosses itself, or comes back to itself, at (%.6g, %.6g, %.6g), so that it has "
                   "no side for courses: end it before that place, or lead it round",
                   at.x, at.y, at.z);
    return course_limits_refuse(l, API_INVALID_REQUEST, "/courses/along/path", text);
}

enum api_problem_id course_limits_check(const struct course_limits *l,
                                        const struct courses_settings *settings) {
    return check_lengths(l, settings) == API_OK ? check_path(l, settings) : l->problem->id;
}
