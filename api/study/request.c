/* SPDX-License-Identifier: MIT */
#include "request.h"

#include "course_search.h"
#include "study.h"

#include "api/json/text.h"
#include "api/laminate/courses.h"
#include "api/request/digest.h"
#include "api/request/members.h"
#include "api/request/normalise.h"
#include "api/result/shear_limit.h"
#include "api/result/verdict.h"
#include <math.h>
#include <string.h>

const char *const study_search_names[STUDY_SEARCH_COUNT] = {"grid", "optimise"};

enum {
    STARTS_MAX = 1000000000,
    BUDGET = 500,
    BUDGET_CUTS = 200,
    BUDGET_COURSES = 500,
    BUDGET_MIN = 20,
    BUDGET_MAX = 1000000
};
static const struct value_range angles = {-1e6, 1e6, false};
static const struct value_range pre_shears = {-80, 80, false};
static const struct value_range steps = {1e-9, 1e6, false};
static const struct value_range deviations = {1e-9, 90, false};

/* A step that ends within this share of itself of the last value reaches it. */
static const double last_step = 1e-9;

double study_angle(const struct study_angles *a, size_t k) {
    return a->values ? a->values[k] : a->from + (double)k * a->step;
}

bool study_judges(const struct study_request *request, enum quantity_id id) {
    const struct study_limit *limit = &request->limit[id];
    return request->objective[id] || limit->has_min || limit->has_max;
}

/* ---- what is varied ---- */

static bool is_drawn(const struct study_request *r) {
    return r->starts == STUDY_STARTS_DISC || r->angle.deviation > 0 || r->pre_shear.deviation > 0;
}

static double count_variants(const struct study_request *r) {
    double starts = r->starts == STUDY_STARTS_KEPT ? 1 : (double)r->start_count;
    bool searched = r->search == STUDY_SEARCH_OPTIMISE || r->splits > 0 || r->courses.base;
    return searched ? (double)r->budget
           : r->sample > 0
               ? (double)r->sample
               : starts * fmax((double)r->angle.count, 1) * fmax((double)r->pre_shear.count, 1);
}

size_t study_variants(const struct study_request *request) {
    return (size_t)count_variants(request);
}

/* {"from", "to", "step"}, a list, or {"normal": s}. */
static void decode_angles(const struct json_value *json, struct value_range range,
                          struct study_angles *a) {
    static const char *const keys[] = {"from", "to", "step", "normal", NULL};
    struct json_value from = value_member(json, "from"), to = value_member(json, "to");
    struct json_value step = value_member(json, "step"), normal = value_member(json, "normal");
    if (value_type(json) == VALUE_ARRAY) {
        if (!value_numbers(json, range, 1, &a->values, &a->count))
            return;
        a->from = a->to = a->values[0];
        for (size_t k = 1; k < a->count; k++) {
            a->from = fmin(a->from, a->values[k]);
            a->to = fmax(a->to, a->values[k]);
        }
        return;
    }
    if (value_type(json) != VALUE_OBJECT) {
        value_fault(json, "must be an array of angles, or an object with \"from\", \"to\" and "
                          "\"step\" or with \"normal\"");
        return;
    }
    if (!value_object(json, keys))
        return;
    if (value_given(&normal)) {
        if (value_given(&from) || value_given(&to) || value_given(&step))
            value_fault(json, "must have either \"normal\" or \"from\", \"to\" and \"step\"");
        value_number(&normal, deviations, &a->deviation);
        return;
    }
    if (!value_number(&from, range, &a->from) || !value_number(&to, range, &a->to) ||
        !value_number(&step, steps, &a->step))
        return;
    if (a->to < a->from)
        value_fault(&to, "must not be less than \"from\"");
    else
        a->count = (size_t)floor((a->to - a->from) / a->step + last_step) + 1;
}

/* {"grid": n}, {"points": [...]} or {"radius": r, "count": n}. */
static void decode_starts(const struct json_value *json, struct study_request *r) {
    static const char *const keys[] = {"grid", "points", "radius", "count", NULL};
    struct json_value grid = value_member(json, "grid"), points = value_member(json, "points");
    struct json_value radius = value_member(json, "radius"), count = value_member(json, "count");
    int number = 0;
    if (!value_object(json, keys))
        return;
    if (value_given(&grid) + value_given(&points) + value_given(&radius) != 1) {
        value_fault(json, "must have one of \"grid\", \"points\" and \"radius\"");
    } else if (value_given(&grid)) {
        r->starts = STUDY_STARTS_GRID;
        if (value_integer(&grid, 1, STARTS_MAX, &number))
            r->start_count = (size_t)number;
    } else if (value_given(&points)) {
        size_t given = value_array(&points, 1) ? value_length(&points) : 0;
        struct study_point *list = given ? json_tree_alloc(json->tree, given, sizeof *list) : NULL;
        if (given)
            r->starts = STUDY_STARTS_POINTS;
        r->start_count = given;
        r->points = list;
        bool good = list != NULL;
        for (size_t k = 0; good && k < given; k++) {
            struct json_value point = value_element(&points, k);
            struct api_request with = r->drape;
            const struct drape_settings *s = &with.settings;
            double at[3] = {0, 0, 0};
            if (value_type(&point) == VALUE_ARRAY) { /* a point alone */
                good = value_vector(&point, decode_coordinates, 3, at);
                list[k] = (struct study_point){.kind = DRAPE_START_POINT,
                                               .point = vec3_make(at[0], at[1], at[2])};
                continue;
            }
            decode_start(&point, &with); /* a start as in a drape request */
            list[k] = (struct study_point){.kind = s->start_kind,
                                           .on_face = with.start_on_face,
                                           .face = s->start_face,
                                           .uv = {s->start_uv[0], s->start_uv[1]},
                                           .point = s->start_point};
            good = json->tree->problem->id == API_OK;
        }
    } else {
        r->starts = STUDY_STARTS_DISC;
        value_number(&radius, decode_lengths, &r->radius);
    }
    if (value_given(&count) && !value_given(&radius))
        value_fault(&count, "is allowed only with \"radius\"");
    else if (value_given(&count) && value_integer(&count, 1, STARTS_MAX, &number))
        r->start_count = (size_t)number;
}

/* Both generators of each variant are sought, with so many points a side. */
static void decode_varied_steering(const struct json_value *json, struct study_request *r) {
    static const char *const keys[] = {"points", NULL};
    struct json_value points = value_member(json, "points");
    struct drape_settings *settings = &r->drape.settings;
    r->steering = DECODE_STEERED_POINTS;
    if (!value_object(json, keys))
        return;
    if (value_given(&points))
        value_integer(&points, 1, DRAPE_CURVATURE_POINTS, &r->steering);
    for (int k = 0; k < 2; k++) {
        struct drape_generator *own = &settings->generator[k];
        if (own->kind != DRAPE_GENERATOR_GEODESIC && own->kind != DRAPE_GENERATOR_LEAST) {
            value_fault(json,
                        "needs drape.generators that are \"geodesic\": it seeks them anew for "
                        "each variant");
            return;
        }
        own->kind = DRAPE_GENERATOR_LEAST;
        own->curvature = (struct drape_curvature){.points = r->steering};
        decode_check_steered(json, settings, k, r->drape.surface.kind == API_SURFACE_MESH);
    }
}

/* "proposed" or {"proposed": n}. */
static void decode_proposed_cuts(const struct json_value *json, struct study_request *r) {
    static const char *const keys[] = {"proposed", NULL}, *const words[] = {"proposed"};
    struct json_value most = value_member(json, "proposed");
    int number = API_STUDY_CUTS, index;
    if (value_type(json) == VALUE_OBJECT) {
        if (!value_object(json, keys) || !value_integer(&most, 1, API_STUDY_CUTS, &number))
            return;
    } else if (!value_choice(json, words, 1, &index)) {
        return;
    }
    r->splits = (size_t)number;
    if (r->drape.settings.cut_count + r->splits > API_CUTS_MAX)
        value_fault(json, "must leave room: the drape has %zu cuts, and %d are allowed together",
                    r->drape.settings.cut_count, API_CUTS_MAX);
}

/* {"from", "to"} and, of a distance, "points"; those of widths may be a list. */
static void decode_span(const struct json_value *json, bool points, struct value_range range,
                        struct study_span *span) {
    static const char *const keys[] = {"from", "to", "points", NULL};
    struct json_value from = value_member(json, keys[0]), to = value_member(json, keys[1]);
    struct json_value count = value_member(json, keys[2]);
    int number = 1;
    if (!value_given(json) || !value_object(json, keys) ||
        !value_number(&from, range, &span->from) || !value_number(&to, range, &span->to))
        return;
    if (span->to < span->from)
        value_fault(&to, "must not be less than \"from\"");
    else if (value_given(&count) && !points)
        value_fault(&count, "must be left out: a course has one");
    else if (!value_given(&count) || value_integer(&count, 1, COURSES_VALUES_MAX, &number))
        span->points = (size_t)number;
}

/* What is varied of the study's courses. */
static void decode_varied_courses(const struct json_value *json, struct study_request *r) {
    static const char *const keys[] = {"count", "first_offset", "offsets", "origin", "width", NULL};
    static const struct value_range shares = {0, 1, false};
    struct json_value count = value_member(json, "count"), width = value_member(json, "width");
    struct json_value first = value_member(json, "first_offset");
    struct json_value offsets = value_member(json, "offsets");
    struct json_value origin = value_member(json, "origin");
    struct study_courses *c = &r->courses;
    const struct courses_settings *lay = &c->base->lay;
    int number = 1;
    c->count = 1;
    if (!value_object(json, keys))
        return;
    if (value_given(&count) && value_integer(&count, 1, STUDY_COURSES_MAX, &number))
        c->count = (size_t)number;
    decode_span(&first, true, decode_coordinates, &c->first);
    decode_span(&offsets, true, decode_coordinates, &c->gap);
    decode_span(&origin, false, shares, &c->origin);
    if (value_type(&width) != VALUE_ARRAY)
        decode_span(&width, false, decode_lengths, &c->width);
    else if (value_numbers(&width, decode_lengths, 1, &c->widths, &c->width_count))
        c->width = (struct study_span){.points = 1};
    size_t unknowns = course_plan_unknowns(c);
    double narrow = c->width.points && !c->widths ? c->width.from : HUGE_VAL;
    for (size_t k = 0; k < c->width_count; k++)
        narrow = fmin(narrow, c->widths[k]);
    for (size_t k = 0; !c->width.points && k < lay->width_count; k++)
        narrow = fmin(narrow, lay->widths[k]);
    if (lay->width_count > STUDY_COURSES_MAX || lay->gap_count >= STUDY_COURSES_MAX ||
        lay->origin_count > STUDY_COURSES_MAX)
        value_fault(json, "need \"courses\" of which at most %d have values of their own",
                    STUDY_COURSES_MAX);
    if (unknowns == 0)
        value_fault(json, "has nothing to vary: give first_offset, offsets, origin or width");
    if (unknowns > API_STUDY_UNKNOWNS)
        value_fault(json,
                    "has %zu values to vary, and %d are allowed: take a smaller count, or "
                    "fewer points",
                    unknowns, API_STUDY_UNKNOWNS);
    if (c->gap.points && -c->gap.from >= narrow) {
        struct json_value from = value_member(&offsets, "from");
        value_fault(&from, "lets a course overlap its neighbour by its whole width, %g", narrow);
    }
}

static void decode_vary(const struct json_value *root, struct study_request *r) {
    static const char *const keys[] = {
        "start", "angle_deg", "pre_shear_deg", "steering", "splits", "courses", NULL};
    static const char *const names[] = {"warp", "weft"};
    struct json_value drape = value_member(root, "drape"), vary = value_member(root, "vary");
    struct json_value generators = value_member(&drape, "generators");
    struct json_value start = value_member(&vary, "start");
    struct json_value angle = value_member(&vary, "angle_deg");
    struct json_value pre_shear = value_member(&vary, "pre_shear_deg");
    struct json_value splits = value_member(&vary, "splits");
    if (!value_object(&vary, keys))
        return;
    struct json_value steering = value_member(&vary, "steering");
    struct json_value courses = value_member(&vary, "courses");
    struct json_value base = value_member(root, "courses");
    bool alone = value_given(&courses) && !value_given(&splits);
    bool other = value_given(&start) || value_given(&angle) || value_given(&pre_shear) ||
                 value_given(&steering);
    if (!other && !value_given(&splits) && !value_given(&courses))
        value_fault(&vary, "has nothing to vary: give start, angle_deg, pre_shear_deg, "
                           "steering, splits or courses");
    if (value_given(&courses) != value_given(&base))
        value_fault(value_given(&base) ? &courses : &base,
                    value_given(&base) ? "is required with \"courses\", of which it varies some"
                                       : "is required with \"vary.courses\": the courses of a ply");
    if (value_given(&courses) && (other || !alone))
        value_fault(&courses, "must be alone: courses have no start and direction of their own");
    else if (r->courses.base)
        decode_varied_courses(&courses, r);
    if (other && value_given(&splits))
        value_fault(&splits,
                    "must be alone: cuts are proposed for one start and direction, which a "
                    "study without them finds first");
    if (value_given(&splits))
        decode_proposed_cuts(&splits, r);
    if (value_given(&steering))
        decode_varied_steering(&steering, r);
    if (value_given(&start))
        decode_starts(&start, r);
    if (value_given(&angle))
        decode_angles(&angle, angles, &r->angle);
    if (value_given(&pre_shear))
        decode_angles(&pre_shear, pre_shears, &r->pre_shear);
    if (value_given(&pre_shear) && r->drape.settings.slide > 0)
        value_fault(&pre_shear, "must be left out where weft slides along warp "
                                "(drape.fabric.kinematics): fabrics that slide begin unsheared");
    bool turned = r->angle.count > 0 || r->angle.deviation > 0;
    bool sheared = r->pre_shear.count > 0 || r->pre_shear.deviation > 0;
    for (int k = 0; k < 2; k++) { /* generators fix what is to be varied */
        enum drape_generator_kind kind = r->drape.settings.generator[k].kind;
        struct json_value json = value_member(&generators, names[k]);
        bool fixed = kind == DRAPE_GENERATOR_CURVE || kind == DRAPE_GENERATOR_PLANE;
        if (kind == DRAPE_GENERATOR_CURVE && r->starts != STUDY_STARTS_KEPT)
            value_fault(&json, "must not be a curve, which passes one start, when starts vary");
        else if (fixed && (k == 0 ? turned : sheared))
            value_fault(&json, "must be \"geodesic\" when %s varies: it fixes the yarn's direction",
                        k == 0 ? "angle_deg" : "pre_shear_deg");
    }
}

/* ---- what is wanted ---- */

/* What a search for cuts is to reach where the study does not say: the whole part is covered within
 * the locking angle, with the least length of cut. */
static void want_few_cuts(struct study_request *r) {
    struct study_limit *shear = &r->limit[QUANTITY_MAX_SHEAR];
    struct study_limit *cover = &r->limit[QUANTITY_CLOTH_COVERAGE];
    bool wished = false;
    double limit_deg[2];
    for (int k = 0; k < QUANTITY_COUNT; k++)
        wished = wished || r->objective[k];
    r->objective[QUANTITY_CUT_LENGTH] = r->objective[QUANTITY_CUT_LENGTH] || !wished;
    verdict_shear_limits(&r->drape, limit_deg);
    if (!shear->has_max)
        shear->max = fmin(limit_deg[0], limit_deg[1]);
    shear->has_max = true;
    if (!cover->has_min && !cover->has_max)
        *cover = (struct study_limit){.has_min = true, .min = DRAPE_COMPLETE_COVERAGE};
}

/* What a search for courses is to reach where the study does not say: nothing stays bare but gaps
 * between courses. */
static void want_whole_courses(struct study_request *r) {
    static const enum quantity_id covers[] = {QUANTITY_CLOTH_COVERAGE, QUANTITY_LAID_COVERAGE,
                                              QUANTITY_UNCOVERED_AREA};
    bool wished = r->objective[QUANTITY_UNCOVERED_AREA];
    for (size_t k = 0; k < sizeof covers / sizeof *covers; k++)
        wished = wished || r->limit[covers[k]].has_min || r->limit[covers[k]].has_max;
    if (!wished)
        r->limit[QUANTITY_LAID_COVERAGE] =
            (struct study_limit){.has_min = true, .min = DRAPE_COMPLETE_COVERAGE};
}

static void decode_wishes(const struct json_value *root, struct study_request *r) {
    static const char *const ends[] = {"min", "max", NULL};
    struct json_value list = value_member(root, "objectives");
    struct json_value limits = value_member(root, "limits");
    struct json_value wanted = value_member(root, "wanted_direction");
    struct json_value sample = value_member(root, "sample");
    struct json_value norm = value_member(root, "deviation_norm");
    static const struct value_range norms = {1, 64, false};
    const char *names[QUANTITY_COUNT], *keys[QUANTITY_COUNT + 1] = {NULL};
    size_t count = 0;
    double v[3];
    int index;
    for (int k = 0; k < QUANTITY_COUNT; k++) {
        keys[k] = quantities[k].name;
        if (quantities[k].role == QUANTITY_OBJECTIVE)
            names[count++] = quantities[k].name;
    }
    bool sampled = value_given(&sample) && !value_given(&list);
    if (sampled)
        r->objective[QUANTITY_MAX_SHEAR] = true;
    bool settled = sampled || (r->splits > 0 && !value_given(&list));
    size_t objectives = !settled && value_array(&list, 1) ? value_length(&list) : 0;
    for (size_t k = 0; k < objectives; k++) {
        struct json_value name = value_element(&list, k);
        if (!value_choice(&name, names, count, &index))
            continue;
        if (r->objective[index])
            value_fault(&name, "is given twice");
        r->objective[index] = true;
    }
    bool limited = value_given(&limits) && value_object(&limits, keys);
    for (int k = 0; limited && k < QUANTITY_COUNT; k++) {
        struct json_value own = value_member(&limits, keys[k]);
        struct json_value min = value_member(&own, "min"), max = value_member(&own, "max");
        const struct value_range range = {quantities[k].least, quantities[k].most, false};
        struct study_limit *limit = &r->limit[k];
        if (!value_given(&own) || !value_object(&own, ends))
            continue;
        if (!value_given(&min) && !value_given(&max))
            value_fault(&own, "must have \"min\" or \"max\"");
        limit->has_min = value_given(&min) && value_number(&min, range, &limit->min);
        limit->has_max = value_given(&max) && value_number(&max, range, &limit->max);
        if (limit->has_min && limit->has_max && limit->min > limit->max)
            value_fault(&min, "must not be greater than \"max\": no variant could keep both");
    }
    if (r->splits > 0)
        want_few_cuts(r);
    if (r->courses.base)
        want_whole_courses(r);
    if (r->courses.base && objectives > 1)
        value_fault(&list, "must have one alone with \"courses\", which are searched for one");
    r->exponent = 1;
    if (value_given(&norm))
        value_number(&norm, norms, &r->exponent);
    if (value_given(&wanted) && value_vector(&wanted, decode_coordinates, 3, v)) {
        r->wanted = vec3_make(v[0], v[1], v[2]);
        if (vec3_norm(r->wanted) < decode_lengths.low)
            value_fault(&wanted, "must be longer than %g", decode_lengths.low);
        r->courses.wanted = r->wanted;
    }
}

/* What a quantity asks of the drape, at the place where it is missing. */
static void check_needs(const struct json_value *root, const struct study_request *r) {
    struct json_value drape = value_member(root, "drape"), fabric = value_member(&drape, "fabric");
    struct json_value locking = value_member(&fabric, "locking_angle_deg");
    struct json_value curve = value_member(&fabric, "limit_curve");
    struct json_value fraction = value_member(&fabric, "fiber_volume_fraction");
    struct json_value thickness = value_member(&fabric, "thickness");
    struct json_value cavity = value_member(&drape, "cavity");
    struct json_value permeability = value_member(&drape, "permeability");
    struct json_value wanted = value_member(root, "wanted_direction");
    bool range = study_judges(r, QUANTITY_FRACTION_RANGE);
    /* Which are known of courses, and which of them alone. */
    static const enum quantity_id others[] = {QUANTITY_P95_SHEAR,     QUANTITY_LOCKED_AREA,
                                              QUANTITY_SEVERITY_AREA, QUANTITY_FRACTION_RANGE,
                                              QUANTITY_K1_RATIO,      QUANTITY_CUT_LENGTH};
    static const enum quantity_id of_courses[] = {QUANTITY_ANGLE_DEVIATION_MAX, QUANTITY_GAP_WIDTH,
                                                  QUANTITY_LAID_COVERAGE};
    struct json_value courses = value_member(root, "courses");
    for (size_t k = 0; r->courses.base && k < sizeof others / sizeof *others; k++)
        if (study_judges(r, others[k]))
            value_fault(&courses, "must be left out for %s, which is not known of courses",
                        quantities[others[k]].name);
    for (size_t k = 0; !r->courses.base && k < sizeof of_courses / sizeof *of_courses; k++)
        if (study_judges(r, of_courses[k]))
            value_fault(&courses, "is required for %s", quantities[of_courses[k]].name);
    const struct {
        bool missing;
        const struct json_value *json;
        enum quantity_id id;
    } needs[] = {
        {study_judges(r, QUANTITY_LOCKED_AREA) && !shear_limit_given(&r->drape.fabric), &locking,
         QUANTITY_LOCKED_AREA},
        {study_judges(r, QUANTITY_SEVERITY_AREA) && r->drape.fabric.limit.rows == 0, &curve,
         QUANTITY_SEVERITY_AREA},
        {study_judges(r, QUANTITY_ANGLE_DEVIATION) && !value_given(&wanted), &wanted,
         QUANTITY_ANGLE_DEVIATION},
        {study_judges(r, QUANTITY_ANGLE_DEVIATION_MAX) && !value_given(&wanted), &wanted,
         QUANTITY_ANGLE_DEVIATION_MAX},
        {range && !(r->drape.fabric.fiber_volume_fraction > 0), &fraction, QUANTITY_FRACTION_RANGE},
        {range && !(r->drape.fabric.thickness > 0), &thickness, QUANTITY_FRACTION_RANGE},
        {study_judges(r, QUANTITY_K1_RATIO) && r->drape.permeability.model == API_PERMEABILITY_NONE,
         &permeability, QUANTITY_K1_RATIO}};
    for (size_t k = 0; k < sizeof needs / sizeof *needs; k++)
        if (needs[k].missing)
            value_fault(needs[k].json, "is required for %s", quantities[needs[k].id].name);
    if (range && !r->drape.cavity.rigid)
        value_fault(&cavity,
                    "must have a \"height\" for %s, because in a flexible cavity the fraction is "
                    "the same everywhere",
                    quantities[QUANTITY_FRACTION_RANGE].name);
}

/* ---- how ---- */

static void decode_sample(const struct json_value *root, const struct api_limits *allowed,
                          struct study_request *r) {
    struct json_value sample = value_member(root, "sample"), seed = value_member(root, "seed");
    struct json_value vary = value_member(root, "vary"), search = value_member(root, "search");
    struct json_value budget = value_member(root, "budget");
    bool optimise = r->search == STUDY_SEARCH_OPTIMISE;
    int number = 0;
    bool listed = r->angle.count > 0 || r->pre_shear.count > 0 || r->starts == STUDY_STARTS_GRID ||
                  r->starts == STUDY_STARTS_POINTS;
    if (value_given(&seed) && !value_given(&sample))
        value_fault(&seed, "is allowed only with \"sample\"");
    if (value_given(&seed) && value_integer(&seed, 0, STARTS_MAX, &number))
        r->seed = (uint32_t)number;
    if (value_given(&sample) && value_integer(&sample, 2, STARTS_MAX, &number))
        r->sample = (size_t)number;
    if (is_drawn(r) && !value_given(&sample))
        value_fault(&sample, "is required with \"radius\" or \"normal\": the number of samples");
    if (is_drawn(r) ? listed : value_given(&sample) && value_given(&vary))
        value_fault(&vary, "must vary only by \"radius\" and \"normal\" with \"sample\"");
    if (r->sample > 0 && optimise)
        value_fault(&search, "must not be \"optimise\" with \"sample\"");
    /* Before any memory is taken for the variants. A budget holds for whatever makes them. */
    double variants = count_variants(r);
    if ((r->splits > 0 || r->courses.base) && (optimise || value_given(&sample)))
        value_fault(optimise ? &search : &sample, "must be left out with \"%s\"",
                    r->splits > 0 ? "splits" : "courses");
    if (r->courses.base && r->budget < COURSE_SEARCH_LEAST)
        value_fault(&budget, "must be at least %d with \"courses\"", COURSE_SEARCH_LEAST);
    if (value_given(&budget) && variants > (double)r->budget)
        value_fault(&budget,
                    "must be at least the %.6g variants that \"%s\" makes, or be given with "
                    "\"search\": \"optimise\", which chooses among them",
                    variants, r->sample > 0 ? "sample" : "vary");
    if (variants > (double)allowed->max_variants)
        value_fault(optimise        ? &budget
                    : r->sample > 0 ? &sample
                                    : &vary,
                    "makes %.6g variants, and %zu are allowed%s", variants, allowed->max_variants,
                    optimise || r->sample ? "" : ": take fewer starts or longer steps");
}

static void decode_courses_of_study(const struct json_value *root, const struct api_request *drape,
                                    struct study_courses *courses) {
    struct json_value json = value_member(root, "courses"), ply = value_member(root, "drape");
    struct json_value wanted = value_member(&json, "wanted_direction");
    struct json_value offset = value_member(&ply, "offset");
    struct json_value stagger = value_member(&json, "stagger");
    if (!value_given(&json))
        return;
    if (value_given(&wanted))
        value_fault(&wanted, "must be left out: it is that of the study");
    if (value_given(&stagger))
        value_fault(&stagger, "must be left out: a study has one ply");
    if (drape->offset != 0)
        value_fault(&offset, "must be left out beside \"courses\"");
    if (value_type(&ply) == VALUE_OBJECT && root->tree->problem->id == API_OK)
        courses->base = courses_decode(&json, &ply, drape);
}

enum api_problem_id study_decode(const struct api_input *input, const struct api_limits *limits,
                                 struct arena *arena, struct study_request *request,
                                 struct api_problem *problem) {
    static const char *const keys[] = {"drape",  "vary",    "objectives",     "limits",
                                       "search", "budget",  "sample",         "wanted_direction",
                                       "seed",   "courses", "deviation_norm", NULL};
    struct json_tree tree;
    int index = 0, number;
    *request = (struct study_request){.search = STUDY_SEARCH_GRID};
    if (json_tree_parse(&tree, input->request, input->request_length, limits, arena, problem) !=
        API_OK)
        return problem->id;
    struct json_value root = value_root(&tree), drape = value_member(&root, "drape");
    struct json_value search = value_member(&root, "search");
    struct json_value budget = value_member(&root, "budget");
    if (value_object(&root, keys)) {
        decode_drape(&drape, input, limits, &request->drape);
        decode_courses_of_study(&root, &request->drape, &request->courses);
        decode_vary(&root, request);
        number = request->courses.base ? BUDGET_COURSES
                 : request->splits > 0 ? BUDGET_CUTS
                                       : BUDGET;
        decode_wishes(&root, request);
        check_needs(&root, request);
        if (value_given(&search))
            value_choice(&search, study_search_names, STUDY_SEARCH_COUNT, &index);
        if (value_given(&budget))
            value_integer(&budget, BUDGET_MIN, BUDGET_MAX, &number);
        request->search = (enum study_search)index;
        request->budget = (size_t)number;
        decode_sample(&root, limits, request);
    }
    json_tree_free(&tree);
    return problem->id;
}

/* ---- as it was understood ---- */

static void write_angles(struct api_text *text, const char *key, const struct study_angles *a) {
    if (a->count == 0 && !(a->deviation > 0))
        return;
    if (a->values) {
        api_text_key_numbers(text, key, a->values, a->count);
        return;
    }
    api_text_key_object(text, key);
    if (a->deviation > 0) {
        api_text_key_number(text, "normal", a->deviation);
    } else {
        api_text_key_number(text, "from", a->from);
        api_text_key_number(text, "to", a->to);
        api_text_key_number(text, "step", a->step);
    }
    api_text_raw(text, "}");
}

static void write_starts(struct api_text *text, const struct study_request *r) {
    if (r->starts == STUDY_STARTS_KEPT)
        return;
    api_text_key_object(text, "start");
    if (r->starts == STUDY_STARTS_GRID) {
        api_text_key_integer(text, "grid", (int64_t)r->start_count);
    } else if (r->starts == STUDY_STARTS_DISC) {
        api_text_key_number(text, "radius", r->radius);
        if (r->start_count)
            api_text_key_integer(text, "count", (int64_t)r->start_count);
    } else {
        api_text_key(text, "points");
        api_text_raw(text, "[");
        for (size_t k = 0; k < r->start_count; k++) {
            const struct study_point *p = &r->points[k];
            bool by_point = p->kind == DRAPE_START_POINT;
            api_text_raw(text, k ? ",{" : "{");
            if (p->on_face && !by_point)
                api_text_key_integer(text, "face", p->face);
            if (by_point)
                api_text_key_numbers(text, "point", &p->point.x, 3);
            else
                api_text_key_numbers(text, "uv", p->uv, 2);
            api_text_raw(text, "}");
        }
        api_text_raw(text, "]");
    }
    api_text_raw(text, "}");
}

static void write_span(struct api_text *text, const char *key, const struct study_span *span,
                       bool points) {
    if (span->points == 0)
        return;
    api_text_key_object(text, key);
    api_text_key_number(text, "from", span->from);
    api_text_key_number(text, "to", span->to);
    if (points)
        api_text_key_integer(text, "points", (int64_t)span->points);
    api_text_raw(text, "}");
}

static void write_varied_courses(struct api_text *text, const struct study_courses *c) {
    api_text_key_object(text, "courses");
    api_text_key_integer(text, "count", (int64_t)c->count);
    write_span(text, "first_offset", &c->first, true);
    write_span(text, "offsets", &c->gap, true);
    write_span(text, "origin", &c->origin, false);
    if (c->widths)
        api_text_key_numbers(text, "width", c->widths, c->width_count);
    else
        write_span(text, "width", &c->width, false);
    api_text_raw(text, "}");
}

/* The study with `drape`, a JSON value, for its drape. */
static const char *write_study(const struct study_request *r, const char *drape,
                               struct arena *arena) {
    struct api_text text = api_text_growing(arena);
    api_text_raw(&text, "{\"drape\":");
    api_text_raw(&text, drape);
    api_text_key_object(&text, "vary");
    write_starts(&text, r);
    write_angles(&text, "angle_deg", &r->angle);
    write_angles(&text, "pre_shear_deg", &r->pre_shear);
    if (r->steering > 0) {
        api_text_key_object(&text, "steering");
        api_text_key_integer(&text, "points", r->steering);
        api_text_raw(&text, "}");
    }
    if (r->splits > 0) {
        api_text_key_object(&text, "splits");
        api_text_key_integer(&text, "proposed", (int64_t)r->splits);
        api_text_raw(&text, "}");
    }
    if (r->courses.base)
        write_varied_courses(&text, &r->courses);
    api_text_raw(&text, "}");
    if (r->courses.base)
        courses_normalise(&text, r->courses.base);
    bool first = true;
    api_text_key(&text, "objectives");
    api_text_raw(&text, "[");
    for (int k = 0; k < QUANTITY_COUNT; k++) {
        if (!r->objective[k])
            continue;
        api_text_raw(&text, first ? "" : ",");
        api_text_string(&text, quantities[k].name);
        first = false;
    }
    api_text_raw(&text, "]");
    api_text_key_object(&text, "limits");
    for (int k = 0; k < QUANTITY_COUNT; k++) {
        const struct study_limit *limit = &r->limit[k];
        if (!limit->has_min && !limit->has_max)
            continue;
        api_text_key_object(&text, quantities[k].name);
        if (limit->has_min)
            api_text_key_number(&text, "min", limit->min);
        if (limit->has_max)
            api_text_key_number(&text, "max", limit->max);
        api_text_raw(&text, "}");
    }
    api_text_raw(&text, "}");
    if (vec3_norm2(r->wanted) > 0)
        api_text_key_numbers(&text, "wanted_direction", &r->wanted.x, 3);
    if (r->exponent > 1)
        api_text_key_number(&text, "deviation_norm", r->exponent);
    if (r->sample > 0) {
        api_text_key_integer(&text, "sample", (int64_t)r->sample);
        api_text_key_integer(&text, "seed", r->seed);
    } else {
        api_text_key_string(&text, "search", study_search_names[r->search]);
    }
    if (r->search == STUDY_SEARCH_OPTIMISE || r->splits > 0 || r->courses.base)
        api_text_key_integer(&text, "budget", (int64_t)r->budget);
    api_text_raw(&text, "}");
    return api_text_finish(&text);
}

const char *study_normalise(const struct study_request *request, struct arena *arena) {
    const char *drape = api_normalise(&request->drape, NULL, arena);
    return drape ? write_study(request, drape, arena) : NULL;
}

/* That of the study whose drape is its own id, which has the solver's version in it. */
bool study_digest(const struct study_request *request, struct arena *arena, char id[API_ID_SIZE]) {
    char drape[API_ID_SIZE + 2] = "\"";
    struct arena_mark mark = arena_mark(arena);
    const char *text = NULL;
    if (api_digest_request(&request->drape, arena, drape + 1))
        text = write_study(request, strcat(drape, "\""), arena);
    if (text)
        api_digest_bytes(text, strlen(text), id);
    arena_rewind(arena, mark);
    return text != NULL;
}
