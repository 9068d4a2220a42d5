/* SPDX-License-Identifier: MIT */
#include "courses.h"

#include "api/request/members.h"
#include <math.h>
#include <string.h>

static const struct value_range not_negative = {0, 1e12, false}, figures_range = {-1e300, 1e300, 0};
static const struct value_range shares = {0, 1, false};

const char *const course_figure_names[COURSE_FIGURES + 1] = {
    [COURSE_WIDTH] = "width",
    [COURSE_CUT_LENGTH] = "cut_length",
    [COURSE_AREA] = "area",
    [COURSE_NET_AREA] = "net_area",
    [COURSE_TRIM_AREA] = "trim_area",
    [COURSE_COVERAGE] = "cloth_coverage",
    [COURSE_MEAN_SHEAR] = "mean_shear_deg",
    [COURSE_MAX_SHEAR] = "max_shear_deg",
    [COURSE_WANTED] = "angle_deviation_deg",
    [COURSE_WANTED_MOST] = "angle_deviation_max_deg",
    [COURSE_GAP_LEAST] = "gap_least",
    [COURSE_GAP_MOST] = "gap_greatest",
    [COURSE_GAP_AREA] = "gap_area",
    [COURSE_OVERLAP_AREA] = "overlap_area",
    [COURSE_STAGGER] = "stagger"};

/* ---- the request ---- */

/* A number, or as many as there may be courses. */
static bool decode_one_or_more(const struct json_value *json, struct value_range range, int most,
                               const double **values, size_t *count) {
    if (value_type(json) == VALUE_ARRAY)
        return value_numbers(json, range, 1, values, count) &&
               (*count <= (size_t)most || value_fault(json, "must have at most %d values", most));
    double *one = json_tree_alloc(json->tree, 1, sizeof *one);
    *values = one;
    *count = one ? 1 : 0;
    return one && value_number(json, range, one);
}

static void decode_along(const struct json_value *json, const struct json_value *start,
                         struct courses_settings *lay) {
    static const char *const names[] = {"direction"}, *const keys[] = {"edge", "path", NULL};
    struct json_value edge = value_member(json, keys[0]), path = value_member(json, keys[1]);
    struct drape_cut_line line = {0};
    int index;
    if (value_type(json) == VALUE_STRING) {
        value_choice(json, names, 1, &index);
        return;
    }
    if (!value_object(json, keys))
        return;
    if (value_given(&edge) == value_given(&path)) {
        value_fault(json, "must be \"direction\", or have either \"edge\" or \"path\"");
    } else if (value_given(&edge)) {
        lay->along = COURSES_ALONG_EDGE;
        value_vector(&edge, decode_coordinates, 3, &lay->edge.x);
    } else {
        lay->along = COURSES_ALONG_PATH;
        decode_cut_path(&path, &line);
        lay->path = line.path;
        lay->path_count = line.count;
    }
    if (value_given(start))
        value_fault(start, "must be left out: courses along an edge or a path begin there");
}

/* `gap`: of all courses, or for each next one its values; or `overlap`, which is less than none. */
static void decode_gaps(const struct json_value *json, struct courses_settings *lay) {
    struct json_value gap = value_member(json, "gap"), overlap = value_member(json, "overlap");
    bool listed = value_type(&gap) == VALUE_ARRAY;
    size_t count = listed ? value_length(&gap) : 1;
    if (value_given(&gap) && value_given(&overlap)) {
        value_fault(&overlap, "must be left out beside \"gap\": neighbours have either");
        return;
    }
    if (listed && !decode_count(&gap, 1, LAMINATE_COURSES_MAX, "courses", &count))
        return;
    struct courses_offset *gaps = json_tree_alloc(json->tree, count, sizeof *gaps);
    double *one = json_tree_alloc(json->tree, 1, sizeof *one);
    if (!gaps || !one)
        return;
    gaps[0] = (struct courses_offset){one, 1};
    if (value_given(&overlap) && value_number(&overlap, decode_lengths, one))
        *one = -*one;
    else if (value_given(&gap) && !listed)
        value_number(&gap, not_negative, one);
    for (size_t k = 0; k < count && listed; k++) {
        struct json_value own = value_element(&gap, k);
        if (!decode_one_or_more(&own, decode_coordinates, COURSES_VALUES_MAX, &gaps[k].values,
                                &gaps[k].count))
            return;
    }
    lay->gaps = gaps;
    lay->gap_count = count;
    for (size_t k = 0; k < count && lay->width_count; k++) {
        double width = lay->widths[k < lay->width_count ? k : lay->width_count - 1];
        const struct json_value *at = value_given(&overlap) ? &overlap : &gap;
        for (size_t n = 0; n < gaps[k].count; n++)
            if (-gaps[k].values[n] >= width) {
                value_fault(at, "lets a course overlap its neighbour by its whole width, %g",
                            width);
                return;
            }
    }
}

static void decode_ends(const struct json_value *json, double *ends) {
    static const char *const names[] = {"part"};
    int index;
    if (value_type(json) == VALUE_STRING)
        value_choice(json, names, 1, &index);
    else
        value_number(json, not_negative, ends);
}

/* What a ply must not say beside its courses. */
static void refuse_beside_courses(const struct json_value *courses, const struct json_value *ply,
                                  const struct api_request *cloth) {
    static const char *const keys[] = {"splits", "seam", "boundary", "cuts", "extent"};
    struct json_value fabric = value_member(ply, "fabric");
    struct json_value generators = value_member(ply, "generators");
    struct json_value pre_shear = value_member(&fabric, "pre_shear_deg");
    for (size_t k = 0; k < sizeof keys / sizeof *keys; k++) {
        struct json_value own = value_member(ply, keys[k]);
        if (value_given(&own))
            value_fault(&own, "must be left out beside \"courses\"");
    }
    for (int k = 0; k < 2; k++)
        if (cloth->settings.generator[k].kind != DRAPE_GENERATOR_GEODESIC) {
            value_fault(&generators, "must be left out beside \"courses\", whose edges are theirs");
            break;
        }
    if (cloth->settings.pre_shear_deg != 0)
        value_fault(&pre_shear, "must be 0 of courses, which leave their roll unsheared");
    if (cloth->surface.kind == API_SURFACE_MESH)
        value_fault(courses, "need a surface, along which parallels are exact: a triangle mesh "
                             "has none");
}

struct laminate_courses *courses_decode(const struct json_value *json, const struct json_value *ply,
                                        const struct api_request *cloth) {
    static const char *const keys[] = {
        "width",   "along", "first_offset",     "gap",  "overlap", "origin", "order",
        "stagger", "ends",  "wanted_direction", "most", NULL};
    static const char *const orders[] = {"left", "right"};
    const struct json_value start = value_member(ply, "start");
    const struct json_value along = value_member(json, "along"), most = value_member(json, "most");
    const struct json_value width = value_member(json, "width"), ends = value_member(json, "ends");
    const struct json_value first = value_member(json, "first_offset");
    const struct json_value origin = value_member(json, "origin");
    const struct json_value order = value_member(json, "order");
    const struct json_value stagger = value_member(json, "stagger");
    const struct json_value wanted = value_member(json, "wanted_direction");
    struct laminate_courses *courses = json_tree_alloc(json->tree, 1, sizeof *courses);
    int index, number = 0;
    if (!courses || !value_object(json, keys))
        return courses;
    struct courses_settings *lay = &courses->lay;
    refuse_beside_courses(json, ply, cloth);
    if (!decode_one_or_more(&width, decode_lengths, LAMINATE_COURSES_MAX, &lay->widths,
                            &lay->width_count))
        lay->width_count = 0;
    if (value_given(&along))
        decode_along(&along, &start, lay);
    if (value_given(&first))
        decode_one_or_more(&first, decode_coordinates, COURSES_VALUES_MAX, &lay->first.values,
                           &lay->first.count);
    decode_gaps(json, lay);
    if (value_given(&origin))
        decode_one_or_more(&origin, shares, LAMINATE_COURSES_MAX, &lay->origins,
                           &lay->origin_count);
    lay->both = !value_given(&order) && lay->along != COURSES_ALONG_EDGE;
    if (value_given(&order) && value_choice(&order, orders, 2, &index))
        lay->to_right = index == 1;
    if (value_given(&most) && value_integer(&most, 1, LAMINATE_COURSES_MAX, &number))
        lay->most = (size_t)number;
    if (value_given(&stagger))
        value_number(&stagger, not_negative, &courses->stagger);
    if (value_given(&ends))
        decode_ends(&ends, &lay->ends);
    if (value_given(&wanted) && value_vector(&wanted, decode_coordinates, 3, &lay->wanted.x) &&
        vec3_norm(lay->wanted) < decode_lengths.low)
        value_fault(&wanted, "must be longer than %g", decode_lengths.low);
    return courses;
}

void courses_normalise(struct api_text *text, const struct laminate_courses *courses) {
    const struct courses_settings *lay = &courses->lay;
    api_text_key_object(text, "courses");
    api_text_key_numbers(text, "width", lay->widths, lay->width_count);
    if (lay->along == COURSES_ALONG_DIRECTION) {
        api_text_key_string(text, "along", "direction");
    } else {
        bool edge = lay->along == COURSES_ALONG_EDGE;
        api_text_key_object(text, "along");
        if (edge)
            api_text_key_numbers(text, "edge", &lay->edge.x, 3);
        else
            api_text_key_rows(text, "path", &lay->path[0].x, 3, lay->path_count);
        api_text_raw(text, "}");
    }
    if (lay->first.count)
        api_text_key_numbers(text, "first_offset", lay->first.values, lay->first.count);
    api_text_key(text, "gap");
    for (size_t k = 0; k < lay->gap_count; k++) {
        api_text_raw(text, k ? "," : "[");
        api_text_numbers(text, lay->gaps[k].values, lay->gaps[k].count);
    }
    api_text_raw(text, "]");
    if (lay->origin_count)
        api_text_key_numbers(text, "origin", lay->origins, lay->origin_count);
    if (!lay->both)
        api_text_key_string(text, "order", lay->to_right ? "right" : "left");
    if (lay->most > 0)
        api_text_key_integer(text, "most", (int64_t)lay->most);
    if (courses->stagger > 0)
        api_text_key_number(text, "stagger", courses->stagger);
    if (lay->ends > 0)
        api_text_key_number(text, "ends", lay->ends);
    if (vec3_norm2(lay->wanted) > 0)
        api_text_key_numbers(text, "wanted_direction", &lay->wanted.x, 3);
    api_text_raw(text, "}");
}

/* ---- what became of them ---- */

void courses_write_figures(struct api_text *text, const double figures[COURSE_FIGURES]) {
    for (int k = 0; k < COURSE_FIGURES; k++)
        if (!isnan(figures[k]))
            api_text_key_number(text, course_figure_names[k], figures[k]);
}

void courses_decode_figures(const struct json_value *json, double figures[COURSE_FIGURES]) {
    bool object = value_given(json) && value_object(json, course_figure_names);
    for (int k = 0; k < COURSE_FIGURES; k++) {
        struct json_value own = value_member(json, course_figure_names[k]);
        figures[k] = NAN;
        if (object && value_given(&own))
            value_number(&own, figures_range, &figures[k]);
    }
}

void courses_sum_up(const struct laminate_pieces *pieces, double sums[COURSE_FIGURES]) {
    static const enum course_figure summed[] = {COURSE_AREA,      COURSE_NET_AREA,
                                                COURSE_TRIM_AREA, COURSE_COVERAGE,
                                                COURSE_GAP_AREA,  COURSE_OVERLAP_AREA};
    static const enum course_figure greatest[] = {COURSE_MAX_SHEAR, COURSE_WANTED_MOST};
    for (int k = 0; k < COURSE_FIGURES; k++)
        sums[k] = NAN;
    for (size_t n = 0; n < pieces->count; n++) {
        const double *own = pieces->pieces[n].figures;
        for (size_t k = 0; k < sizeof summed / sizeof *summed; k++)
            sums[summed[k]] = (n ? sums[summed[k]] : 0) + own[summed[k]];
        for (size_t k = 0; k < sizeof greatest / sizeof *greatest; k++)
            sums[greatest[k]] = fmax(sums[greatest[k]], own[greatest[k]]);
        sums[COURSE_STAGGER] = fmin(sums[COURSE_STAGGER], own[COURSE_STAGGER]);
    }
    sums[COURSE_COVERAGE] = fmin(sums[COURSE_COVERAGE], 1);
}
