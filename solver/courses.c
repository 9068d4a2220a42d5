/* SPDX-License-Identifier: MIT */
#include "courses.h"

#include "solver/angle.h"
#include "solver/course/line.h"
#include "solver/laid_line.h"
#include "solver/power.h"
#include "solver/shell/crossing.h"
#include "solver/shell/shell.h"
#include "solver/surface/spans.h"
#include <string.h>

/* An edge of the part ends at corners of more than 30 degrees. */
static const double corner_cosine = 0.866;

/* Places are told to this share of a spacing: by the caller's parameters, and along the part's edge
 * between points of the rim. */
static const double told_slack = 1e-3;

/* A line is followed beyond the part so far, in sizes of the part. */
static const double most_of_line = 4;

/* The error allowed of the geodesics to near edges, in spacings. */
static const double exact_edges = 1e-10, rough_edges = 1e-5;

/* Areas are known to this share. */
static const double rounding = 1e-12;

struct layer {
    const struct drape_part *part;
    const struct courses_settings *settings;
    const struct drape_monitor *monitor;
    struct arena *arena;
    const struct surface
        *surface; /* of a shell any face, with all normals on the first one's side */
    double size, part_area;
    bool to_right; /* of the courses that are being laid */
};

/* Written so that NaN is refused. */
static bool layer_is_valid(const struct layer *l) {
    const struct courses_settings *s = l->settings;
    const struct drape_settings *d = &s->drape;
    bool valid = s->width_count > 0 && s->most <= COURSES_MAX && s->ends >= 0 &&
                 s->first.count <= COURSES_VALUES_MAX && d->spacing[0] > 0 && d->spacing[1] > 0 &&
                 d->spacing[0] < l->size && d->cut_count == 0 && d->pre_shear_deg == 0;
    for (size_t k = 0; k < s->width_count; k++)
        valid = valid && s->widths[k] > 0 && s->widths[k] <= l->size &&
                s->widths[k] / d->spacing[1] < (double)INT32_MAX / 4;
    for (size_t k = 0; k < s->origin_count; k++)
        valid = valid && s->origins[k] >= 0 && s->origins[k] <= 1;
    for (size_t k = 0; k < s->gap_count; k++) {
        valid = valid && s->gaps[k].count <= COURSES_VALUES_MAX;
        for (size_t n = 0; valid && n < s->gaps[k].count; n++)
            valid = s->gaps[k].values[n] > -courses_value(s->widths, s->width_count, k, 0) &&
                    s->gaps[k].values[n] < l->size;
    }
    for (size_t n = 0; valid && n < s->first.count; n++)
        valid = fabs(s->first.values[n]) < l->size;
    return valid && (s->along != COURSES_ALONG_PATH || s->path_count >= 2);
}

/* ---- the line along which the first course is laid ---- */

static bool layer_point(const struct layer *l, int32_t face, const double uv[2],
                        struct surface_point *point) {
    struct surface_cursor cursor = {0};
    const struct surface *surface =
        l->surface->shell ? shell_surface(l->surface->shell, face) : l->surface;
    double inner[2];
    surface_inner(surface, uv, inner);
    return surface_point_at(surface, &cursor, inner, point);
}

static bool nearest_point(const struct layer *l, struct vec3 r, struct surface_point *point) {
    struct surface_cursor cursor = {0};
    double distance;
    return surface_point_nearest(l->surface, &cursor, r, point, &distance) &&
           distance <= l->settings->drape.spacing[0];
}

/* A net of a few nodes, which tells where the start is and what the part's edges are. */
static enum status look(const struct layer *l, const struct drape_settings *settings,
                        struct drape_result *seen) {
    struct drape_settings s = *settings;
    s.row = NULL;
    s.statistics = NULL;
    s.generator[0].kind = s.generator[1].kind = DRAPE_GENERATOR_GEODESIC;
    for (int k = 0; k < 2; k++) {
        s.has_extent[k] = true;
        s.extent[k][0] = -1;
        s.extent[k][1] = 1;
    }
    return drape_solve(l->part, &s, NULL, l->arena, seen);
}

static enum status along_direction(const struct layer *l, struct course_line *line) {
    struct drape_result seen;
    enum status status = look(l, &l->settings->drape, &seen);
    if (status != STATUS_OK)
        return status;
    if (!line_alloc(line, 1, l->arena))
        return STATUS_OUT_OF_MEMORY;
    line->count = 1;
    line->tangent[0] = seen.start_warp;
    return layer_point(l, seen.start_face, seen.start_uv, &line->at[0]) ? STATUS_OK
                                                                        : STATUS_DEGENERATE_SURFACE;
}

static bool nearest_in_space(const void *context, struct vec3 r, struct vec3 *place,
                             struct vec3 *normal) {
    const struct layer *l = context;
    struct surface_cursor cursor = {0};
    struct surface_point nearest;
    double distance;
    if (!surface_point_nearest(l->surface, &cursor, r, &nearest, &distance))
        return false;
    *place = nearest.jet.r;
    *normal = nearest.normal;
    return true;
}

static enum status along_path(const struct layer *l, struct course_line *line) {
    const struct courses_settings *s = l->settings;
    const struct laid_line_part part = {nearest_in_space, l};
    const struct drape_cut_line asked = {s->path, s->path_count};
    struct drape_cut_line laid;
    double step = s->drape.spacing[0];
    size_t room = 1;
    if (laid_line_make(&part, &asked, step, l->arena, &laid) != STATUS_OK)
        return STATUS_OUT_OF_MEMORY;
    for (size_t k = 1; k < laid.count; k++)
        room += 1 + (size_t)fmin(vec3_distance(laid.path[k - 1], laid.path[k]) / step, 1e5);
    if (!line_alloc(line, room, l->arena))
        return STATUS_OUT_OF_MEMORY;
    for (size_t k = 0; k < laid.count; k++) {
        struct vec3 from = laid.path[k > 0 ? k - 1 : 0], way = vec3_sub(laid.path[k], from);
        size_t steps = k > 0 ? 1 + (size_t)fmin(vec3_norm(way) / step, 1e5) : 1;
        for (size_t n = 1; n <= steps; n++) {
            struct surface_point *at = &line->at[line->count];
            if (!nearest_point(l, vec3_axpy((double)n / (double)steps, way, from), at))
                return STATUS_START_OFF_SURFACE;
            line->count += line->count == 0 || vec3_distance(at->jet.r, at[-1].jet.r) > step / 16;
        }
    }
    if (line->count < 2)
        return STATUS_START_OFF_SURFACE;
    line_complete(line);
    return STATUS_OK;
}

static struct vec3 cloth_rim_point(const struct drape_rim *rim, size_t k) {
    return vec3_make(rim->x[k], rim->y[k], rim->z[k]);
}

/* Whether the loop of the rim's points from `first` on, `count` of them, turns sharply at point k
 * of it. */
static bool turns_at(const struct drape_rim *rim, size_t first, size_t count, size_t k) {
    struct vec3 r = cloth_rim_point(rim, first + k);
    struct vec3 back = vec3_sub(cloth_rim_point(rim, first + (k + count - 1) % count), r);
    struct vec3 ahead = vec3_sub(cloth_rim_point(rim, first + (k + 1) % count), r);
    return vec3_dot(vec3_unit(back), vec3_unit(ahead)) > -corner_cosine;
}

/* The distance of a point from the piece between two points of the rim. */
static double piece_distance(const struct drape_rim *rim, size_t from, size_t to, struct vec3 at) {
    struct vec3 a = cloth_rim_point(rim, from), way = vec3_sub(cloth_rim_point(rim, to), a);
    double length2 = vec3_norm2(way), x = vec3_dot(vec3_sub(at, a), way);
    x = length2 > 0 ? fmin(fmax(x / length2, 0), 1) : 0;
    return vec3_distance(vec3_axpy(x, way, a), at);
}

/* Points of the surface on a run of the rim, a step apart: between its points the straight line in
 * the parameters, which the part's edge is. */
static enum status follow_rim(const struct layer *l, const struct drape_rim *rim, size_t first,
                              size_t count, size_t begin, size_t pieces, struct course_line *line) {
    double step = l->settings->drape.spacing[0], length = 0;
    size_t room = 2;
    for (size_t n = 0; n < pieces; n++)
        length += vec3_distance(cloth_rim_point(rim, first + (begin + n) % count),
                                cloth_rim_point(rim, first + (begin + n + 1) % count));
    room += (size_t)fmin(2 * length / step, 1e6);
    double own = length / fmax(floor(length / step), 1), ahead = 0, gone = 0;
    if (!line_alloc(line, room, l->arena))
        return STATUS_OUT_OF_MEMORY;
    for (size_t n = 0; n < pieces; n++) {
        size_t a = first + (begin + n) % count, b = first + (begin + n + 1) % count;
        int32_t face = rim->face ? rim->face[a] : 0;
        double piece = vec3_distance(cloth_rim_point(rim, a), cloth_rim_point(rim, b));
        bool leaps = rim->face && rim->face[b] != face, last = n + 1 == pieces;
        while (line->count < room && piece > 0 && !leaps &&
               (ahead <= gone + piece || (last && ahead < length + own / 2))) {
            double x = fmin((ahead - gone) / piece, 1);
            const double uv[2] = {rim->u[a] + x * (rim->u[b] - rim->u[a]),
                                  rim->v[a] + x * (rim->v[b] - rim->v[a])};
            line->count += layer_point(l, face, uv, &line->at[line->count]);
            ahead += own;
        }
        gone += piece;
    }
    if (line->count < 2)
        return STATUS_START_OFF_SURFACE;
    line_complete(line);
    return STATUS_OK;
}

static enum status along_edge(const struct layer *l, struct course_line *line) {
    struct drape_settings s = l->settings->drape;
    struct drape_result seen;
    s.start_kind = DRAPE_START_POINT;
    s.start_point = l->settings->edge;
    s.direction_kind = DRAPE_DIRECTION_ANGLE;
    enum status status = look(l, &s, &seen);
    if (status != STATUS_OK)
        return status;
    const struct drape_rim *rim = &seen.rim;
    size_t best = 0, first = 0, count = 0;
    double least = HUGE_VAL;
    for (size_t begin = 0, end; begin < rim->count; begin = end) {
        for (end = begin; end < rim->count && rim->loop[end] == rim->loop[begin];)
            end++;
        for (size_t k = begin; k < end; k++) {
            size_t next = k + 1 < end ? k + 1 : begin;
            double distance = piece_distance(rim, k, next, l->settings->edge);
            if (!(distance < least))
                continue;
            least = distance;
            best = k - begin;
            first = begin;
            count = end - begin;
        }
    }
    if (!(least <= s.spacing[0]))
        return STATUS_START_OFF_SURFACE;
    size_t begin = best, pieces = 1;
    while (pieces < count && !turns_at(rim, first, count, begin)) {
        begin = (begin + count - 1) % count;
        pieces++;
    }
    while (pieces < count && !turns_at(rim, first, count, (begin + pieces) % count))
        pieces++;
    return follow_rim(l, rim, first, count, begin, pieces, line);
}

/* ---- a course ---- */

/* Whether the trimmed region has a point, or one beside it at no more than `slack`. */
static bool trim_reaches(const struct trim *trim, const struct surface_point *at, double slack) {
    double uv[2], inner[2];
    for (int k = 0; k < 9; k++) { /* with the point itself in the middle */
        const int side[2] = {(k + 4) / 3 % 3 - 1, (k + 4) % 3 - 1};
        for (int x = 0; x < 2; x++) {
            const struct surface_axis *axis = &at->surface->axis[x];
            double low = surface_axis_lower(axis), high = surface_axis_upper(axis);
            inner[x] = surface_axis_wrap(axis, at->uv[x]);
            inner[x] += side[x] * slack / sqrt(at->first[2 * x]);
            inner[x] = fmin(fmax(inner[x], low), high);
        }
        surface_outer(at->surface, inner, uv);
        if (trim_contains(trim, uv))
            return true;
        if (slack == 0)
            return false;
    }
    return false;
}

/* Whether a point is on the part, or beside its edge at no more than `slack`. */
static bool reaches_part(const struct layer *l, const struct surface_point *at, double slack) {
    const struct shell *shell = l->surface->shell;
    struct crossing crossing;
    if (shell) {
        crossing_find(at, NULL, &crossing);
        return crossing.kind == CROSSING_NONE ||
               crossing.distance <= fmax(slack, shell_joint_width(shell));
    }
    return !surface_point_is_beyond(at, SURFACE_POINT_BOUNDARY_WIDTH) &&
           (!l->part->trim || trim_reaches(l->part->trim, at, slack));
}

/* Whether places of a line are on the part: along its edge, as far as they are told. */
static bool *mark_inside(const struct layer *l, const struct course_line *line) {
    bool *inside = arena_alloc(l->arena, line->count, sizeof *inside);
    for (size_t k = 0; inside && k < line->count; k++)
        inside[k] = reaches_part(l, &line->at[k], told_slack * l->settings->drape.spacing[0]);
    return inside;
}

/* The arc length at which a line leaves the part, between one that is on it and one that is not. */
static double find_exit(const struct layer *l, const struct course_line *line, double on,
                        double off) {
    enum { HALVINGS = 24 };
    struct surface_cursor cursor = {0};
    for (int k = 0; k < HALVINGS; k++) {
        struct surface_point at;
        struct vec3 tangent;
        double middle = (on + off) / 2;
        bool there = line_point(line, middle, &cursor, &at, &tangent) && reaches_part(l, &at, 0);
        *(there ? &on : &off) = middle;
    }
    return on;
}

/* The run of places on the part, or of those that are not, from place k on: the place after it. */
static size_t end_of_run(const struct course_line *line, const bool *inside, size_t k) {
    size_t end = k + 1;
    while (end < line->count && inside[end] == inside[k])
        end++;
    return end;
}

/* From where to where the run from k to before `end` is on the part. */
static void find_run(const struct layer *l, const struct course_line *line, size_t k, size_t end,
                     double range[2]) {
    range[0] = k > 0 ? find_exit(l, line, line->s[k], line->s[k - 1]) : line->s[k];
    range[1] =
        end < line->count ? find_exit(l, line, line->s[end - 1], line->s[end]) : line->s[end - 1];
}

/* Where a line is on the part, from the first end of a run to the last; of one that is beyond it
 * everywhere its ends. */
static void find_range(const struct layer *l, const struct course_line *line, const bool *inside,
                       double range[2]) {
    bool found = false;
    double run[2];
    range[0] = line->s[0];
    range[1] = line->s[line->count - 1];
    for (size_t k = 0, end; k < line->count; k = end) {
        end = end_of_run(line, inside, k);
        if (!inside[k])
            continue;
        find_run(l, line, k, end, run);
        range[0] = found ? range[0] : run[0];
        range[1] = run[1];
        found = true;
    }
}

static double range_share(const double range[2], double share) {
    return range[0] + share * (range[1] - range[0]);
}

/* Whether the caller's parameters tell where a point is: those of one far out on the continuation,
 * near where a rational direction goes through infinity, may not. */
static bool is_told(const struct layer *l, const struct surface_point *at) {
    struct surface_point again;
    double outer[2];
    surface_outer(at->surface, at->uv, outer);
    return layer_point(l, at->surface->face, outer, &again) &&
           vec3_distance(again.jet.r, at->jet.r) < told_slack * l->settings->drape.spacing[0];
}

/* Ends a line about its point `middle` where places no longer follow each other: far beyond the
 * part the continuation runs away. */
static void end_where_torn(const struct layer *l, struct course_line *line, size_t *middle) {
    const struct surface_point *at = line->at;
    double spacing = l->settings->drape.spacing[0];
    size_t first = *middle, last = *middle;
    while (first > 0 && is_told(l, &at[first - 1]) &&
           drape_place_follows(vec3_distance(at[first].jet.r, at[first - 1].jet.r) / spacing))
        first--;
    while (last + 1 < line->count && is_told(l, &at[last + 1]) &&
           drape_place_follows(vec3_distance(at[last].jet.r, at[last + 1].jet.r) / spacing))
        last++;
    for (size_t k = last + 1; k-- > first;)
        line->s[k] -= line->s[first];
    *line = (struct course_line){line->at + first, line->tangent + first, line->s + first,
                                 last - first + 1};
    *middle -= first;
}

/* The places of a near edge, and its origin, from the parallel of a line. */
static enum status set_places(const struct layer *l, const struct course_line *edge, size_t middle,
                              struct course *course) {
    struct drape_place *places = arena_alloc(l->arena, edge->count, sizeof *places);
    if (!places)
        return STATUS_OUT_OF_MEMORY;
    for (size_t k = 0; k < edge->count; k++) {
        const struct surface *surface = edge->at[k].surface;
        places[k].face = surface->shell ? surface->face : 0;
        surface_outer(surface, edge->at[k].uv, places[k].uv);
        places[k].along = edge->tangent[k];
    }
    course->places = places;
    course->place_count = edge->count;
    course->place_start = middle;
    return STATUS_OK;
}

/* Gap and overlap between a course's near edge and a run of the line it is laid along, on the part,
 * by the rule of Simpson; of the overlap the sign of the distance tells. */
static void add_gap(const struct line_distance *distance, double from, double to,
                    struct course *course, bool first) {
    enum { INTERVALS = 256 };
    double h = (to - from) / INTERVALS;
    for (int k = 0; k <= INTERVALS; k++) {
        double at = line_distance_at(distance, from + k * h), size = fabs(at);
        double weight = (k == 0 || k == INTERVALS ? 1 : k % 2 ? 4 : 2) * h / 3;
        course->gap[0] = fmin(course->gap[0], at);
        course->gap[1] = fmax(course->gap[1], at);
        if (!first)
            *(at < 0 ? &course->overlap_area : &course->gap_area) += weight * size;
    }
}

/* The same of all runs of the line that are on the part. */
static void measure_gap(const struct layer *l, const struct line_distance *distance,
                        const struct course_line *line, const bool *inside, struct course *course,
                        bool first) {
    course->gap[0] = HUGE_VAL;
    course->gap[1] = -HUGE_VAL;
    for (size_t k = 0, end; k < line->count; k = end) {
        end = end_of_run(line, inside, k);
        if (!inside[k])
            continue;
        double run[2];
        find_run(l, line, k, end, run);
        add_gap(distance, run[0], run[1], course, first);
    }
    if (course->gap[0] > course->gap[1]) /* it is beyond the part */
        course->gap[0] = course->gap[1] = line_distance_at(distance, distance->from);
}

/* The near edge of a course at its distance from a line. */
static enum status lay_edge(const struct layer *l, const struct course_line *line, size_t number,
                            struct course *course, struct course_line *edge) {
    const struct courses_settings *s = l->settings;
    const struct courses_offset *offset = &s->first;
    double values[COURSES_VALUES_MAX] = {0}, range[2];
    if (number > 0)
        offset =
            s->gap_count ? &s->gaps[(number < s->gap_count ? number : s->gap_count) - 1] : NULL;
    size_t count = offset && offset->count ? offset->count : 1, middle;
    for (size_t k = 0; offset && k < offset->count; k++)
        values[k] = (l->to_right ? -1 : 1) * offset->values[k];
    bool *inside = mark_inside(l, line);
    if (!inside)
        return STATUS_OUT_OF_MEMORY;
    find_range(l, line, inside, range);
    struct line_distance distance = {values, count, range[0], range[1]};
    double origin = courses_value(s->origins, s->origin_count, number, 0.5);
    double accuracy = s->rough ? rough_edges : exact_edges;
    enum status status = line_parallel(line, &distance, range_share(range, origin),
                                       s->drape.spacing[0], accuracy, l->arena, edge, &middle);
    if (status != STATUS_OK)
        return status;
    end_where_torn(l, edge, &middle);
    for (size_t k = 0; k < count; k++)
        values[k] = offset && offset->count ? offset->values[k] : 0;
    measure_gap(l, &distance, line, inside, course, number == 0);
    return set_places(l, edge, middle, course);
}

/* The greatest angle of a cell's warp from the wanted direction in the plane of its yarns. */
static double most_from_wanted(const struct drape_cells *cells, struct vec3 wanted) {
    double most = 0;
    for (size_t k = 0; k < cells->count; k++) {
        struct vec3 warp = {cells->warp_x[k], cells->warp_y[k], cells->warp_z[k]};
        struct vec3 weft = {cells->weft_x[k], cells->weft_y[k], cells->weft_z[k]};
        struct vec3 normal = vec3_unit(vec3_cross(warp, weft));
        struct vec3 way = vec3_axpy(-vec3_dot(wanted, normal), normal, wanted);
        if (vec3_norm2(way) > 0)
            most = fmax(
                most, angle_atan2_deg(vec3_norm(vec3_cross(way, warp)), fabs(vec3_dot(way, warp))));
    }
    return most;
}

/* Widens a range by the straight piece of the rim between two points, as far as it lies in the rows
 * of the cloth. */
static void add_rim_piece(const struct drape_rim *rim, size_t from, size_t to,
                          const int32_t rows[2], double range[2]) {
    const double slack = 1e-6;
    double dp = rim->p[to] - rim->p[from], dq = rim->q[to] - rim->q[from], share[2] = {0, 1};
    for (int side = 0; side < 2; side++) {
        double inward = side ? -1 : 1, away = inward * (rows[side] - rim->q[from]);
        double by = inward * dq;
        if (by > slack * slack)
            share[0] = fmax(share[0], away / by);
        else if (away > slack)
            return;
        else if (by < -slack * slack)
            share[1] = fmin(share[1], away / by);
    }
    for (int end = 0; end < 2 && share[0] <= share[1] + slack; end++) {
        range[0] = fmin(range[0], rim->p[from] + share[end] * dp);
        range[1] = fmax(range[1], rim->p[from] + share[end] * dp);
    }
}

/* Widens a range by where an edge of the cloth, whose point k is that of column `first` + k, is on
 * the part. */
static bool widen_columns(const struct layer *l, const struct course_line *edge, int32_t first,
                          double range[2]) {
    bool *inside = mark_inside(l, edge);
    double run[2];
    for (size_t k = 0, end; inside && k < edge->count; k = end) {
        end = end_of_run(edge, inside, k);
        if (!inside[k])
            continue;
        find_run(l, edge, k, end, run);
        double before = k > 0 ? (edge->s[k] - run[0]) / (edge->s[k] - edge->s[k - 1]) : 0;
        double after =
            end < edge->count ? (run[1] - edge->s[end - 1]) / (edge->s[end] - edge->s[end - 1]) : 0;
        range[0] = fmin(range[0], first + (double)k - before);
        range[1] = fmax(range[1], first + (double)(end - 1) + after);
    }
    return inside;
}

/* From end to end of the cloth on the part, in p: its nodes, where the part's edge cuts it, and its
 * own edges. */
static void find_cloth_ends(const struct drape_result *net, const int32_t rows[2],
                            double range[2]) {
    const struct drape_nodes *nodes = &net->nodes;
    const struct drape_rim *rim = &net->rim;
    for (size_t k = 0; k < nodes->count; k++) {
        range[0] = fmin(range[0], nodes->i[k]);
        range[1] = fmax(range[1], nodes->i[k]);
    }
    for (size_t begin = 0, end; begin < rim->count; begin = end) {
        for (end = begin; end < rim->count && rim->loop[end] == rim->loop[begin];)
            end++;
        for (size_t k = begin; k < end; k++) {
            size_t next = k + 1 < end ? k + 1 : begin;
            if (rim->covered[k] && rim->covered[next])
                add_rim_piece(rim, k, next, rows, range);
        }
    }
}

/* What a course is, by its ends on the part in p. */
static void measure_course(const struct layer *l, const double ends[2], struct course *course) {
    const struct courses_settings *settings = l->settings;
    for (int k = 0; k < 2; k++)
        course->ends[k] = course->spacing[0] * ends[k] + (k ? 1 : -1) * settings->ends;
    course->cut_length = fmax(course->ends[1] - course->ends[0], 0);
    course->area = course->width * course->cut_length;
    course->net_area = course->net.summary.flat_area;
    double trim_area = course->area - course->net_area;
    course->trim_area = trim_area > rounding * course->area ? trim_area : 0;
    if (vec3_norm2(settings->wanted) > 0)
        course->wanted_most_deg = fmax(most_from_wanted(&course->net.cells, settings->wanted),
                                       most_from_wanted(&course->net.cut.cells, settings->wanted));
}

/* The net of a course along its places; `row` gets its far edge, `ends` are widened by its cloth.
 */
static enum status drape_course(const struct layer *l, size_t number, struct course *course,
                                struct drape_row *row, double ends[2]) {
    const struct courses_settings *settings = l->settings;
    struct drape_settings s = settings->drape;
    struct drape_statistics *statistics = arena_alloc(l->arena, 1, sizeof *statistics);
    if (!statistics)
        return STATUS_OUT_OF_MEMORY;
    course->width = courses_value(settings->widths, settings->width_count, number, 0);
    course->rows = (int32_t)fmax(ceil(course->width / s.spacing[1] * (1 - 1e-9)), 1);
    s.spacing[1] = course->width / course->rows;
    memcpy(course->spacing, s.spacing, sizeof s.spacing);
    s.generator[0] = (struct drape_generator){.kind = DRAPE_GENERATOR_PLACES,
                                              .places = course->places,
                                              .place_count = course->place_count,
                                              .place_start = course->place_start};
    s.generator[1] = (struct drape_generator){.kind = DRAPE_GENERATOR_GEODESIC};
    /* Left of warp is that of the normal of the start's face. */
    const struct shell *shell = l->surface->shell;
    bool turned = shell && shell_side(shell, course->places[course->place_start].face) < 0;
    bool right = l->to_right != turned;
    course->to_right = right;
    s.has_extent[0] = false;
    s.has_extent[1] = true;
    s.extent[1][0] = right ? -course->rows : 0;
    s.extent[1][1] = right ? 0 : course->rows;
    row->j = right ? -course->rows : course->rows;
    s.row = row;
    statistics->wanted = settings->wanted;
    statistics->exponent = settings->exponent;
    s.statistics = statistics;
    enum status status = drape_solve(l->part, &s, l->monitor, l->arena, &course->net);
    if (status != STATUS_OK)
        return status;
    find_cloth_ends(&course->net, s.extent[1], ends);
    if (vec3_norm2(settings->wanted) > 0)
        course->wanted_deg = statistics->wanted_deg;
    return STATUS_OK;
}

/* The far edge as a line, in the sense of warp. */
static enum status line_of_row(const struct layer *l, const struct drape_row *row,
                               struct course_line *line) {
    if (row->count < 2)
        return STATUS_NO_CONVERGENCE;
    if (!line_alloc(line, row->count, l->arena))
        return STATUS_OUT_OF_MEMORY;
    for (size_t k = 0; k < row->count; k++)
        if (!layer_point(l, row->places[k].face, row->places[k].uv, &line->at[k]))
            return STATUS_DEGENERATE_SURFACE;
    line->count = row->count;
    line_complete(line);
    return STATUS_OK;
}

/* Means are sums by area until all courses are laid; of an angle of its p-th power. */
static void add_up(struct courses_result *result, const struct course *course, double part_area,
                   double exponent) {
    const struct drape_summary *summary = &course->net.summary;
    double power = exponent > 1 ? power_of(course->wanted_deg, exponent) : course->wanted_deg;
    result->mean_shear_deg += course->net_area * summary->mean_shear_deg;
    result->wanted_deg += course->net_area * power;
    if (result->count > 0 && course->net_area > 0)
        result->gap_most = fmax(result->gap_most, course->gap[1]);
    result->area += course->area;
    result->net_area += course->net_area;
    result->trim_area += course->trim_area;
    result->gap_area += course->gap_area;
    result->overlap_area += course->overlap_area;
    result->max_shear_deg = fmax(result->max_shear_deg, summary->max_shear_deg);
    result->wanted_most_deg = fmax(result->wanted_most_deg, course->wanted_most_deg);
    result->cloth_coverage += (summary->cloth_area - course->overlap_area) / part_area;
}

/* The course beside a line: its near edge, its net, its figures; `line` becomes its far edge, or
 * stays where it has none. `more`: whether that is on the part. */
static enum status lay_course(const struct layer *l, size_t number, struct course *course,
                              struct course_line *line, struct course_line *near, bool *more) {
    struct drape_row row = {0};
    double ends[2] = {HUGE_VAL, -HUGE_VAL};
    size_t before;
    *more = false;
    enum status status =
        line_extend(line, l->settings->drape.spacing[0], most_of_line * l->size, l->arena, &before);
    if (status == STATUS_OK)
        status = lay_edge(l, line, number, course, near);
    if (status == STATUS_OK)
        status = drape_course(l, number, course, &row, ends);
    if (status != STATUS_OK)
        return status;
    for (size_t k = 0; k < row.count; k++)
        *more = *more || row.inside[k];
    if (*more || row.count >= 2)
        status = line_of_row(l, &row, line);
    if (status == STATUS_OK && row.count >= 2 && !widen_columns(l, line, row.first, ends))
        return STATUS_OUT_OF_MEMORY;
    if (!widen_columns(l, near, -(int32_t)course->place_start, ends))
        return STATUS_OUT_OF_MEMORY;
    measure_course(l, ends, course);
    return status;
}

/* One course after the other, the next one along a line, each other along the far edge of the one
 * before. `near` gets the near edge of the first of them. */
static enum status lay_side(const struct layer *l, struct course_line *line, size_t most,
                            struct courses_result *result, struct course_line *near) {
    size_t begin = result->count;
    for (bool more = true; more && result->count < most;) {
        struct course *course = &result->courses[result->count];
        struct course_line edge;
        result->faulty = result->count;
        enum status status = lay_course(l, result->count, course, line, &edge, &more);
        bool lies = status == STATUS_OK && course->net_area > 0;
        if (result->count > 0 && (status == STATUS_START_STUCK || (status == STATUS_OK && !lies)))
            return STATUS_OK;
        if (status != STATUS_OK)
            return status;
        if (result->count == begin)
            *near = edge;
        add_up(result, course, l->part_area, l->settings->exponent);
        result->count++;
    }
    return STATUS_OK;
}

/* All courses: those of one side, and from the first one's near edge those of the other. */
static enum status lay_all(struct layer *l, struct course_line *line,
                           struct courses_result *result) {
    size_t most = l->settings->most ? l->settings->most : COURSES_MAX;
    struct course_line near = {.count = 0}, other;
    result->courses = arena_alloc(l->arena, most, sizeof *result->courses);
    if (!result->courses)
        return STATUS_OUT_OF_MEMORY;
    enum status status = lay_side(l, line, most, result, &near);
    if (status != STATUS_OK || !l->settings->both || near.count == 0)
        return status;
    bool *inside = mark_inside(l, &near), any = false;
    if (!inside)
        return STATUS_OUT_OF_MEMORY;
    for (size_t k = 0; k < near.count; k++)
        any = any || inside[k];
    l->to_right = !l->to_right;
    return any ? lay_side(l, &near, most, result, &other) : STATUS_OK;
}

/* The component of a shell that the line lies on, with all normals on the side of its first face.
 */
static enum status open_shell(struct layer *l) {
    const struct courses_settings *s = l->settings;
    const struct shell *shell = l->part->shell;
    struct shell *oriented;
    struct shell_point nearest = {0};
    double distance;
    bool by_point = s->drape.start_kind == DRAPE_START_POINT;
    int32_t component = shell_largest_component(shell), first = 0;
    if (s->along == COURSES_ALONG_EDGE)
        shell_nearest(shell, s->edge, SHELL_ANY, &nearest, &distance);
    else if (s->along == COURSES_ALONG_PATH && s->path_count > 0)
        shell_nearest(shell, s->path[0], SHELL_ANY, &nearest, &distance);
    else if (by_point)
        shell_nearest(shell, s->drape.start_point, SHELL_ANY, &nearest, &distance);
    else if (s->drape.start_kind == DRAPE_START_UV)
        nearest.face = s->drape.start_face;
    else
        while (shell_component(shell, nearest.face) != component)
            nearest.face++;
    if (nearest.face < 0 || (size_t)nearest.face >= shell_face_count(shell))
        return STATUS_START_OFF_SURFACE;
    component = shell_component(shell, nearest.face);
    while (shell_component(shell, first) != component || shell_side(shell, first) < 0)
        first++;
    enum status status = shell_orient(shell, first, l->arena, &oriented);
    if (status != STATUS_OK)
        return status;
    l->surface = shell_surface(oriented, first);
    l->part_area = shell_area(oriented, component, NULL);
    l->size = shell_size(oriented);
    return STATUS_OK;
}

enum status courses_lay(const struct drape_part *part, const struct courses_settings *settings,
                        const struct drape_monitor *monitor, struct arena *arena,
                        struct courses_result *result) {
    struct layer l = {.part = part,
                      .settings = settings,
                      .monitor = monitor,
                      .arena = arena,
                      .surface = part->surface,
                      .to_right = settings->to_right};
    enum status status = STATUS_OK;
    struct course_line line;
    struct vec3 centroid;
    *result = (struct courses_result){0};
    if (part->mesh)
        return STATUS_INVALID;
    if (part->shell) {
        status = open_shell(&l);
    } else {
        l.size = part->surface->size;
        l.part_area =
            part->trim ? trim_area(part->trim, &centroid) : surface_area(part->surface, NULL);
    }
    if (status == STATUS_OK && !layer_is_valid(&l))
        status = STATUS_INVALID;
    if (status != STATUS_OK)
        return status;
    status = settings->along == COURSES_ALONG_DIRECTION ? along_direction(&l, &line)
             : settings->along == COURSES_ALONG_EDGE    ? along_edge(&l, &line)
                                                        : along_path(&l, &line);
    if (status == STATUS_OK)
        status = lay_all(&l, &line, result);
    double power = settings->exponent > 1 ? 1 / settings->exponent : 1;
    if (result->net_area > 0) { /* of the sums */
        result->mean_shear_deg /= result->net_area;
        result->wanted_deg /= result->net_area;
        result->wanted_deg = power < 1 ? power_of(result->wanted_deg, power) : result->wanted_deg;
    }
    return status;
}
