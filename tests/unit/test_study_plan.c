/* SPDX-License-Identifier: MIT */
/* How a study is cut into tasks, what a search looks through, and which unknowns its courses have:
 * exact numbers on both sides of every limit. */
#include "api/study/course_plan.h"
#include "api/study/course_search.h"
#include "api/study/cut_search.h"
#include "api/study/rounds.h"
#include "api/study/setup.h"
#include "studied.h"
#include "support.h"
#include "tests/check.h"
#include <math.h>
#include <string.h>

#define COUNT(table) (sizeof(table) / sizeof *(table))

/* ---- tasks ---- */

/* Bytes that are no task are refused, and those at the limits are not. */
static void test_task_is_sound_within_its_limits(void **state) {
    static const struct {
        struct api_study_task task;
        bool sound;
    } rows[] = {
        {{.kind = STUDY_TASK_GRID}, true},
        {{.kind = -1}, false},
        {{.kind = STUDY_TASK_KINDS}, false},
        {{.kind = STUDY_TASK_SAMPLE, .variants = 512, .first = 1}, true},
        {{.kind = STUDY_TASK_OPTIMISE, .variants = 513}, false},
        {{.kind = STUDY_TASK_GRID, .variants = -1}, false},
        {{.kind = STUDY_TASK_GRID, .first = -1}, false},
        {{.kind = STUDY_TASK_GRID, .crash_count = API_STUDY_CRASHES}, true},
        {{.kind = STUDY_TASK_GRID, .crash_count = API_STUDY_CRASHES + 1}, false},
        {{.kind = STUDY_TASK_GRID, .crash_count = -1}, false},
        {{.kind = STUDY_TASK_LIST, .variants = API_STUDY_LISTED}, true},
        {{.kind = STUDY_TASK_LIST, .variants = API_STUDY_LISTED + 1}, false},
        {{.kind = STUDY_TASK_CUTS, .variants = 1, .first = API_STUDY_CUTS}, true},
        {{.kind = STUDY_TASK_CUTS, .variants = 1, .first = API_STUDY_CUTS + 1}, false},
        {{.kind = STUDY_TASK_CUTS, .variants = 2}, false},
        {{.kind = STUDY_TASK_CUTS, .variants = 0}, false},
        {{.kind = STUDY_TASK_COURSES, .variants = 1, .coarseness = 1}, true},
        {{.kind = STUDY_TASK_COURSES, .variants = 1, .coarseness = 0.99}, false},
        {{.kind = STUDY_TASK_COURSES, .variants = 1, .coarseness = 2, .first = API_STUDY_UNKNOWNS},
         true},
        {{.kind = STUDY_TASK_COURSES,
          .variants = 1,
          .coarseness = 2,
          .first = API_STUDY_UNKNOWNS + 1},
         false},
        {{.kind = STUDY_TASK_COURSES, .variants = 2, .coarseness = 1}, false},
    };
    (void)state;
    for (size_t k = 0; k < COUNT(rows); k++)
        if (task_is_sound(&rows[k].task) != rows[k].sound)
            fail_msg("task %zu", k);
}

/* A share of the round, but of 3e4 to 6e4 nodes, one variant to 512 of them. */
static void test_tasks_have_their_share_of_a_round(void **state) {
    static const struct {
        struct task_range range;
        size_t count;
        int each, last;
    } rows[] = {
        {{.first = 0, .end = 1000, .nodes = 1e3}, 34, 30, 10},
        {{.first = 7, .end = 1007, .nodes = 3e3}, 67, 15, 10},
        {{.first = 0, .end = 1000, .nodes = 6e3}, 100, 10, 10},
        {{.first = 0, .end = 3, .nodes = 7e4}, 3, 1, 1},
        {{.first = 0, .end = 1025, .nodes = 1}, 3, 512, 1},
        {{.first = 5, .end = 6, .nodes = 1e3, .round = 3}, 1, 1, 1},
        {{.first = 6, .end = 6, .nodes = 1e3}, 0, 0, 0},
    };
    struct arena *arena = arena_new((size_t)1 << 24);
    (void)state;
    for (size_t k = 0; k < COUNT(rows); k++) {
        struct api_study_plan plan = {0}, more = {0}, none = {0};
        struct api_problem problem = {.id = API_OK};
        struct task_range range = rows[k].range;
        range.kind = STUDY_TASK_SAMPLE;
        assert_int_equal(task_make_range(&range, arena, &plan, &problem), API_OK);
        assert_int_equal(plan.count, rows[k].count);
        for (size_t n = 0; n < plan.count; n++) {
            const struct api_study_task *task = &plan.tasks[n];
            assert_int_equal(task->kind, STUDY_TASK_SAMPLE);
            assert_int_equal(task->round, range.round);
            assert_int_equal(task->variants, n + 1 < plan.count ? rows[k].each : rows[k].last);
            assert_int_equal(task->first, range.first + n * (size_t)rows[k].each);
        }
        /* joined to another, and to none */
        range = (struct task_range){.kind = STUDY_TASK_GRID, .first = 9, .end = 10, .nodes = 1e5};
        assert_int_equal(task_make_range(&range, arena, &more, &problem), API_OK);
        assert_int_equal(task_join(arena, &plan, &more, &problem), API_OK);
        assert_int_equal(task_join(arena, &plan, &none, &problem), API_OK);
        assert_int_equal(plan.count, rows[k].count + 1);
        assert_int_equal(plan.tasks[plan.count - 1].first, 9);
        assert_int_equal(plan.tasks[0].kind, rows[k].count ? STUDY_TASK_SAMPLE : STUDY_TASK_GRID);
    }
    arena_free(arena);
}

/* The first few are known by their number. */
static void test_task_keeps_the_variants_that_crashed(void **state) {
    struct api_study_task task = {.kind = STUDY_TASK_GRID};
    (void)state;
    for (size_t k = 0; k < API_STUDY_CRASHES + 2; k++)
        api_study_task_crashed(&task, 10 + k);
    assert_int_equal(task.crash_count, API_STUDY_CRASHES);
    for (int k = 0; k < API_STUDY_CRASHES; k++)
        assert_int_equal(task.crashed[k], 10 + k);
}

/* ---- what a search looks through ---- */

/* A study of angles on a plane of so many cells, on which all yarns are alike. */
static void make_plain(struct api_study *study, double cells) {
    *study = (struct api_study){.part = {.area = cells},
                                .request = {.starts = STUDY_STARTS_GRID,
                                            .drape.settings.spacing = {1, 1},
                                            .drape.permeability.model = API_PERMEABILITY_NONE,
                                            .angle = {.count = 1, .to = 85, .step = 5}}};
}

/* The net is the same after a quarter turn unless warp and weft differ, and after half a turn
 * unless they have a side. */
static void test_search_turns_the_warp_as_far_as_nets_differ(void **state) {
    static struct api_study study;
    struct study_request *r = &study.request;
    struct drape_settings *s = &r->drape.settings;
    (void)state;
    for (int k = 0; k < 12; k++) {
        make_plain(&study, 100);
        s->has_extent[0] = k == 1;
        s->has_extent[1] = k == 2;
        s->generator[0].kind = k == 3 ? DRAPE_GENERATOR_PLANE : DRAPE_GENERATOR_GEODESIC;
        s->generator[1].kind = k == 4 ? DRAPE_GENERATOR_CURVE : DRAPE_GENERATOR_GEODESIC;
        s->pre_shear_deg = k == 5 ? -1 : 0;
        r->pre_shear.count = k == 6;
        s->spacing[1] = k == 7 ? 2 : 1;
        r->wanted.y = k == 8 ? 0.1 : 0;
        r->drape.permeability.model = k == 9    ? API_PERMEABILITY_KOZENY_CARMAN
                                      : k == 10 ? API_PERMEABILITY_GEBART
                                                : API_PERMEABILITY_NONE;
        assert_true(optimise_space(&study).turn == (k >= 1 && k <= 4   ? 360
                                                    : k >= 5 && k <= 9 ? 180
                                                                       : 90));
    }
}

/* A range that ends a step before a whole turn is all of it. */
static void test_search_knows_a_range_that_closes(void **state) {
    static const struct {
        double to, step, period;
        size_t count;
    } rows[] = {{85, 5, 90, 1},           {85, 5, 0, 0},         {80, 5, 0, 1}, {90, 5, 90, 1},
                {80, 10 - 90e-10, 90, 1}, {80, 10 - 90e-8, 0, 1}};
    static struct api_study study;
    (void)state;
    for (size_t k = 0; k < COUNT(rows); k++) {
        make_plain(&study, 100);
        study.request.angle = (struct study_angles){
            .count = rows[k].count, .from = 0, .to = rows[k].to, .step = rows[k].step};
        assert_true(optimise_space(&study).period == rows[k].period);
    }
}

/* Beyond 6000 nodes it looks on nets of 2500, and proposes on nets of 25,000 on the mean, of which
 * a 32nd at least are the drape's own. */
static void test_search_looks_on_coarser_nets(void **state) {
    static const struct {
        double nodes, coarseness, fine;
    } rows[] = {{6000, 1, 1},
                {6400, 1.6, 1},
                {25000, 3.1622776601683795, 1},
                {5e4, 4.47213595499958, 0.5},
                {8e5, 17.88854381999832, 0.03125},
                {1e6, 20, 0.03125}};
    static struct api_study study;
    (void)state;
    for (size_t k = 0; k < COUNT(rows); k++) {
        make_plain(&study, rows[k].nodes - 1);
        const struct optimise_space space = optimise_space(&study);
        check_at_most(fabs(space.coarseness - rows[k].coarseness), 1e-12);
        assert_true(space.fine == rows[k].fine);
    }
}

/* Epochs end at 100, 500, 1000, ...; half of each looks everywhere, with three angles a quarter
 * turn and three pre-shears at each start, the first after what is obvious. */
static void test_search_goes_on_in_epochs(void **state) {
    static const struct {
        size_t obvious, angles, pre_shears, number;
        enum study_starts starts;
        size_t start_count;
        struct optimise_epoch epoch;
    } rows[] = {
        {0, 1, 0, 0, STUDY_STARTS_GRID, 0, {0, 100, 16, 3}},
        {8, 1, 0, 0, STUDY_STARTS_GRID, 0, {8, 100, 14, 3}},
        {8, 1, 0, 1, STUDY_STARTS_GRID, 0, {100, 500, 66, 3}},
        {8, 1, 0, 2, STUDY_STARTS_GRID, 0, {500, 1000, 83, 3}},
        {8, 1, 0, 3, STUDY_STARTS_GRID, 0, {1000, 2000, 166, 3}},
        {8, 0, 0, 0, STUDY_STARTS_GRID, 0, {8, 100, 42, 1}},
        {8, 0, 1, 0, STUDY_STARTS_GRID, 0, {8, 100, 42, 1}},
        {8, 0, 2, 0, STUDY_STARTS_GRID, 0, {8, 100, 14, 3}},
        {8, 1, 2, 0, STUDY_STARTS_GRID, 0, {8, 100, 4, 9}},
        {90, 1, 0, 0, STUDY_STARTS_GRID, 0, {90, 100, 1, 3}},
        {8, 1, 0, 0, STUDY_STARTS_POINTS, 5, {8, 100, 5, 8}},
        {8, 1, 0, 0, STUDY_STARTS_POINTS, 20, {8, 100, 14, 3}},
        {8, 1, 0, 0, STUDY_STARTS_KEPT, 1, {8, 100, 1, 42}},
    };
    static struct api_study study;
    (void)state;
    for (size_t k = 0; k < COUNT(rows); k++) {
        make_plain(&study, 100);
        study.obvious_count = rows[k].obvious;
        study.request.starts = rows[k].starts;
        study.request.start_count = rows[k].start_count;
        study.request.angle.count = rows[k].angles;
        study.request.pre_shear.count = rows[k].pre_shears;
        const struct optimise_epoch epoch = optimise_epoch(&study, rows[k].number);
        if (epoch.first != rows[k].epoch.first || epoch.end != rows[k].epoch.end ||
            epoch.starts != rows[k].epoch.starts || epoch.each != rows[k].epoch.each)
            fail_msg("row %zu: %zu to %zu, %zu starts of %zu", k, epoch.first, epoch.end,
                     epoch.starts, epoch.each);
    }
}

/* Cuts that keep the limits are moved: five ways each, twice for every step that is more than a
 * quarter of a spacing, from a quarter of their length on. */
static void test_search_of_cuts_takes_two_rounds_a_step(void **state) {
    static const char plane[] =
        "{\"surface\":{\"degree_u\":1,\"degree_v\":1,\"size_u\":2,\"size_v\":2,"
        "\"knotvector_u\":[0,0,1,1],\"knotvector_v\":[0,0,1,1],"
        "\"control_points\":[[0,0,0],[0,4,0],[4,0,0],[4,4,0]]},\"fabric\":{\"spacing\":0.125}}";
    static const struct {
        double length;
        size_t rows, budget, tasks, variants;
    } rows[] = {{0, 0, 500, 1, 1},      {0, 1, 500, 0, 1},      {1, 1, 500, 5, 1 + 5 + 3 * 10},
                {1.001, 1, 500, 5, 46}, {2, 1, 500, 5, 46},     {1, 1, 36, 5, 36},
                {1, 1, 35, 5, 35},      {1, 1, 4, 3, 1 + 3 + 0}};
    struct api_problem problem = {0};
    struct bytes text = studied_text(plane, "\"vary\":{\"splits\":\"proposed\"},"
                                            "\"objectives\":[\"cut_length\"],"
                                            "\"limits\":{\"max_shear_deg\":{\"max\":10}}");
    const struct api_input input = studied_input(&text);
    (void)state;
    prepare();
    struct api_study *study = api_study_open(&input, &api_limits_default, &problem);
    if (!study)
        fail_msg("%s: %s", problem.error[0].pointer, problem.error[0].detail);
    for (size_t k = 0; k < COUNT(rows); k++) {
        const struct study_cut cut = {.mouth = {2, 0, 0}, .tip = {2, rows[k].length, 0}};
        const struct study_row row = {.variant = {.cuts = &cut, .cut_count = rows[k].length > 0}};
        struct arena *arena = arena_new((size_t)1 << 24);
        struct api_study_plan plan;
        study->request.budget = rows[k].budget;
        assert_int_equal(cut_search_plan(study, &row, rows[k].rows, arena, &plan, &problem),
                         API_OK);
        if (plan.count != rows[k].tasks || plan.variants != rows[k].variants)
            fail_msg("row %zu: %zu tasks, %zu variants", k, plan.count, plan.variants);
        arena_free(arena);
    }
    api_study_close(study);
    bytes_free(&text);
}

/* ---- courses ---- */

/* What is laid at the end is in turn the best of what keeps the limits for certain and of what may
 * keep them on a closer net, which covers 4 (d / w)^4 more; and what a limit is missed by counts
 * ten times. */
static void test_search_of_courses_ends_with_what_may_keep_the_limits(void **state) {
    static const double origin = 0, width = 24, q = 1.0 / (12 * 12 * 12 * 12); /* d = 2 */
    static const struct laminate_courses base = {
        .lay = {.origins = &origin, .origin_count = 1, .widths = &width, .width_count = 1}};
    enum { ROWS = 41, LAST = 21 };
    static const struct {
        double missing, cost;
        size_t place; /* among the last */
    } ends[] = {{0, 3.0e-4, 0},       {0, 3.1e-4, 2}, {3.9 * q, 1.1e-4, 1},
                {4.1 * q, 1.0e-4, 3}, {1e-3, 0, 5},   {0, 9.5e-3, 4}};
    static struct api_study study;
    static struct study_row rows[ROWS];
    static double unknowns[ROWS];
    struct study_request *r = &study.request;
    struct api_problem problem = {0};
    struct arena *arena = arena_new((size_t)1 << 24);
    struct api_study_plan plan;
    (void)state;
    make_plain(&study, 100);
    r->courses = (struct study_courses){.base = &base, .count = 1, .origin = {1, 0, 1}};
    r->budget = ROWS + COUNT(ends);
    r->objective[QUANTITY_WASTE_AREA] = true;
    r->limit[QUANTITY_CLOTH_COVERAGE] = (struct study_limit){.has_min = true, .min = 0.9};
    for (size_t k = 0; k < ROWS; k++) {
        size_t n = k - LAST;
        unknowns[k] = (double)k / ROWS;
        rows[k].variant = (struct study_variant){.unknowns = &unknowns[k], .coarseness = 2};
        rows[k].quantity[QUANTITY_CLOTH_COVERAGE] = n < COUNT(ends) ? 0.9 - ends[n].missing : 0.5;
        rows[k].quantity[QUANTITY_WASTE_AREA] = n < COUNT(ends) ? 100 * ends[n].cost : 1;
    }
    assert_int_equal(course_search_plan(&study, rows, ROWS, arena, &plan, &problem), API_OK);
    assert_int_equal(plan.count, COUNT(ends));
    for (size_t n = 0; n < COUNT(ends); n++)
        if (plan.tasks[ends[n].place].courses[0] != unknowns[LAST + n])
            fail_msg("row %zu is not at %zu", n, ends[n].place);
    arena_free(arena);
}

static const double offsets[] = {-0.5, 0, 0.25}, gap_values[] = {0.01, 0.03}, next_gap[] = {0.02};
static const double origins[] = {0.2, 0.8}, widths[] = {1, 2, 4};
static const struct courses_offset gaps[] = {{gap_values, 2}, {next_gap, 1}};
static const struct laminate_courses laid = {.lay = {.first = {offsets, 3},
                                                     .gaps = gaps,
                                                     .gap_count = 2,
                                                     .origins = origins,
                                                     .origin_count = 2,
                                                     .widths = widths,
                                                     .width_count = 3}};

static void check_values(const double *values, const double *wanted, size_t count) {
    for (size_t k = 0; k < count; k++)
        if (values[k] != wanted[k])
            fail_msg("value %zu is %g, not %g", k, values[k], wanted[k]);
}

/* All four kinds, in order, from what the study has, spread over as many values as are varied, and
 * within their ranges. */
static void test_course_plan_has_its_unknowns_in_order(void **state) {
    const struct study_courses c = {.base = &laid,
                                    .count = 3,
                                    .first = {2, -0.4, 1},
                                    .gap = {3, 0.01, 0.025},
                                    .origin = {1, 0.3, 0.7},
                                    .width = {1, 0.5, 3},
                                    .wanted = {0, 1, 0}};
    static const double begin[] = {-0.4, 0.25, /* of a first one of three values the ends */
                                   0.01, 0.025, 0.025, 0.02, 0.02, 0.02, /* of two neighbours */
                                   0.3,  0.7,   0.7, /* the last origin goes on */
                                   1,    2,     3};
    double unknowns[COUNT(begin) + 1] = {[COUNT(begin)] = 77};
    struct course_plan plan;
    (void)state;
    assert_int_equal(course_plan_unknowns(&c), COUNT(begin));
    course_plan_begin(&c, unknowns);
    check_values(unknowns, begin, COUNT(begin));
    assert_true(unknowns[COUNT(begin)] == 77);
    for (size_t k = 0; k < COUNT(begin); k++) {
        struct study_span span = course_plan_span(&c, k);
        const struct study_span *own = k < 2    ? &c.first
                                       : k < 8  ? &c.gap
                                       : k < 11 ? &c.origin
                                                : &c.width;
        assert_memory_equal(&span, own, sizeof span);
        unknowns[k] = (double)k;
    }
    course_plan_make(&c, unknowns, &plan);
    assert_int_equal(plan.count, 3);
    assert_int_equal(plan.lay.first.count, 2);
    check_values(plan.lay.first.values, unknowns, 2);
    assert_int_equal(plan.lay.gap_count, 2);
    for (size_t n = 0; n < 2; n++) {
        assert_int_equal(plan.lay.gaps[n].count, 3);
        check_values(plan.lay.gaps[n].values, unknowns + 2 + 3 * n, 3);
    }
    assert_int_equal(plan.lay.origin_count, 3);
    assert_int_equal(plan.lay.width_count, 3);
    check_values(plan.lay.origins, unknowns + 8, 3);
    check_values(plan.lay.widths, unknowns + 11, 3);
    assert_true(plan.lay.wanted.y == 1);
}

/* What is not varied stays, the last value for all further courses; of a single course there is one
 * distance, and courses with values of their own are those of the longest list. */
static void test_course_plan_keeps_what_is_not_varied(void **state) {
    const struct study_courses c = {.base = &laid, .count = 1, .gap = {1, 0, 1}};
    struct course_plan plan;
    double unknowns[2] = {0, 77};
    (void)state;
    assert_int_equal(course_plan_unknowns(&c), 1);
    course_plan_begin(&c, unknowns);
    check_values(unknowns, (const double[]){0.01, 77}, 2);
    unknowns[0] = 0.5;
    course_plan_make(&c, unknowns, &plan);
    assert_int_equal(plan.count, 3);
    check_values(plan.lay.first.values, offsets, 3);
    assert_int_equal(plan.lay.first.count, 3);
    assert_int_equal(plan.lay.gap_count, 2);
    for (size_t n = 0; n < 2; n++) {
        assert_int_equal(plan.lay.gaps[n].count, 1);
        assert_true(plan.lay.gaps[n].values[0] == 0.5);
    }
    check_values(plan.lay.origins, (const double[]){0.2, 0.8, 0.8}, 3);
    check_values(plan.lay.widths, widths, 3);

    const struct study_courses of_origins = {.base = &laid, .count = 1, .origin = {1, 0, 1}};
    assert_int_equal(course_plan_unknowns(&of_origins), 1);
    course_plan_begin(&of_origins, unknowns);
    assert_true(unknowns[0] == 0.2);
    course_plan_make(&of_origins, (const double[]){0.9}, &plan);
    check_values(plan.lay.origins, (const double[]){0.9, 0.9, 0.9}, 3);
    assert_int_equal(plan.lay.gaps[0].count, 2);
    check_values(plan.lay.gaps[0].values, gap_values, 2);
    check_values(plan.lay.gaps[1].values, next_gap, 1);
}

/* Of widths that there are the unknown is the place in the list, that of the nearest at first. */
static void test_course_plan_takes_widths_that_there_are(void **state) {
    static const double there_are[] = {0.5, 1.4, 1.6, 9};
    const struct study_courses c = {.base = &laid,
                                    .count = 4,
                                    .width = {1, 0.5, 9},
                                    .widths = there_are,
                                    .width_count = COUNT(there_are)};
    struct course_plan plan;
    double unknowns[4];
    (void)state;
    assert_int_equal(course_plan_unknowns(&c), 4);
    course_plan_begin(&c, unknowns);
    check_values(unknowns, (const double[]){1.5, 2.5, 2.5, 2.5}, 4);
    struct study_span span = course_plan_span(&c, 3);
    assert_true(span.points == 1 && span.from == 0 && span.to == 4);
    course_plan_make(&c, (const double[]){0, 0.99, 3.5, 4}, &plan);
    assert_int_equal(plan.count, 4);
    assert_int_equal(plan.lay.gap_count, 3);
    check_values(plan.lay.widths, (const double[]){0.5, 0.5, 9, 9}, 4);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_task_is_sound_within_its_limits),
        cmocka_unit_test(test_tasks_have_their_share_of_a_round),
        cmocka_unit_test(test_task_keeps_the_variants_that_crashed),
        cmocka_unit_test(test_search_turns_the_warp_as_far_as_nets_differ),
        cmocka_unit_test(test_search_knows_a_range_that_closes),
        cmocka_unit_test(test_search_looks_on_coarser_nets),
        cmocka_unit_test(test_search_goes_on_in_epochs),
        cmocka_unit_test(test_search_of_cuts_takes_two_rounds_a_step),
        cmocka_unit_test(test_search_of_courses_ends_with_what_may_keep_the_limits),
        cmocka_unit_test(test_course_plan_has_its_unknowns_in_order),
        cmocka_unit_test(test_course_plan_keeps_what_is_not_varied),
        cmocka_unit_test(test_course_plan_takes_widths_that_there_are),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
