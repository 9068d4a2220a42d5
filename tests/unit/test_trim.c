/* SPDX-License-Identifier: MIT */
#include "solver/surface/trim.h"

#include "own_arena.h"
#include "support.h"
#include "tests/check.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The unit square, twice as long in v as in space, so that area and parameters differ. */
static struct surface *square(void) {
    static const double knots[] = {0, 0, 1, 1};
    static const struct vec3 points[] = {{0, 0, 0}, {0, 2, 0}, {1, 0, 0}, {1, 2, 0}};
    struct nurbs nurbs = {
        .u = {1, 2, knots}, .v = {1, 2, knots}, .points = points, .point_count = 4};
    struct surface *surface;
    assert_int_equal(surface_make(&nurbs, arena, &surface), STATUS_OK);
    return surface;
}

/* A loop that is one polyline. */
struct polyline {
    double (*points)[2];
    size_t count;
    struct trim_curve curve;
};

static struct polyline polyline_make(size_t count) {
    struct polyline line = {.count = count};
    line.points = arena_alloc(arena, count, sizeof *line.points);
    assert_non_null(line.points);
    return line;
}

static struct trim_loop polyline_loop(struct polyline *line, bool reversed) {
    line->curve = (struct trim_curve){
        .degree = 1, .points = (const double(*)[2])line->points, .count = line->count};
    return (struct trim_loop){reversed, &line->curve, 1};
}

/* ---- the region, against the definition ---- */

/* Whether a ray to the left crosses the polyline an odd number of times. */
static bool is_inside(const struct polyline *line, const double uv[2]) {
    bool inside = false;
    for (size_t k = 0; k < line->count; k++) {
        const double *a = line->points[k], *b = line->points[(k + 1) % line->count];
        if ((a[1] <= uv[1]) == (b[1] <= uv[1]))
            continue;
        if (a[1] > b[1]) {
            const double *swap = a;
            a = b;
            b = swap;
        }
        if (a[0] + (uv[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]) <= uv[0])
            inside = !inside;
    }
    return inside;
}

enum { LOOPS_MAX = 6, SAMPLES = 400 };

static bool is_kept(const struct polyline *lines, const struct trim_loop *loops, size_t count,
                    const double uv[2]) {
    bool any = false, kept = false;
    for (size_t k = 0; k < count; k++) {
        bool inside = is_inside(&lines[k], uv);
        if (inside && !loops[k].reversed)
            return false;
        any = any || loops[k].reversed;
        kept = kept || inside;
    }
    return kept || !any;
}

/* Any closed polyline: most cross themselves and each other, some reach beyond the domain, places
 * repeat, edges lie on each other and along the lines v = const. */
static void random_loops(struct random *random, struct polyline *lines, struct trim_loop *loops,
                         size_t count) {
    for (size_t k = 0; k < count; k++) {
        lines[k] = polyline_make((size_t)(2 + random_index(random, 30)));
        bool coarse = random_index(random, 2);
        for (size_t p = 0; p < lines[k].count; p++)
            for (int x = 0; x < 2; x++) {
                double at = random_between(random, -0.2, 1.2);
                lines[k].points[p][x] = coarse ? floor(8 * at) / 8 : at;
            }
        loops[k] = polyline_loop(&lines[k], random_index(random, 2));
    }
}

static void test_trim_keeps_what_its_loops_say(void **state) {
    (void)state;
    struct random random = random_begin("trim");
    const struct surface *surface = square();
    for (int round = 0; round < check_sized(80, 16); round++) {
        struct arena_mark mark = arena_mark(arena);
        struct polyline lines[LOOPS_MAX];
        struct trim_loop loops[LOOPS_MAX];
        size_t count = (size_t)(1 + random_index(&random, LOOPS_MAX));
        struct trim *trim;
        random_loops(&random, lines, loops, count);
        enum status status = trim_make(surface, loops, count, arena, &trim);
        double sum = 0;
        for (int line = 0; line < 512; line++)
            for (int k = 0; k < SAMPLES; k++) {
                /* of every 64 lines one goes through places of coarse loops */
                double uv[2] = {(k + 0.5) / SAMPLES, (line + (line % 64 ? 0.5 : 0)) / 512};
                bool kept = is_kept(lines, loops, count, uv);
                sum += kept;
                if (status == STATUS_OK && line % 16 == 0 && kept != trim_contains(trim, uv))
                    fail_msg("round %d: (%g, %g)", round, uv[0], uv[1]);
                if (status != STATUS_OK && kept)
                    fail_msg("round %d: (%g, %g) is left", round, uv[0], uv[1]);
            }
        struct vec3 centroid;
        double share = sum / (512.0 * SAMPLES);
        if (status == STATUS_OK && fabs(trim_area(trim, &centroid) / 2 - share) > 30.0 / SAMPLES)
            fail_msg("round %d: area %g, not %g", round, trim_area(trim, &centroid) / 2, share);
        arena_rewind(arena, mark);
    }
}

/* A rational circle, as four arcs: flattened so finely that a part in 1e5 of its radius tells. */
static void test_trim_is_flat_to_a_millionth(void **state) {
    (void)state;
    static const double knots[] = {0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4};
    static const double side[9][2] = {{1, 0},   {1, 1},  {0, 1},  {-1, 1}, {-1, 0},
                                      {-1, -1}, {0, -1}, {1, -1}, {1, 0}};
    const double radius = 0.4;
    double points[9][2], weights[9];
    for (int k = 0; k < 9; k++) {
        points[k][0] = 0.5 + radius * side[k][0];
        points[k][1] = 0.5 + radius * side[k][1];
        weights[k] = k % 2 ? sqrt(0.5) : 1;
    }
    struct trim_curve curve = {.degree = 2,
                               .points = (const double(*)[2])points,
                               .weights = weights,
                               .count = 9,
                               .knots = knots};
    struct trim_loop loop = {true, &curve, 1};
    struct trim *trim;
    assert_int_equal(trim_make(square(), &loop, 1, arena, &trim), STATUS_OK);
    for (int k = 0; k < 1000; k++)
        for (int out = 0; out < 2; out++) {
            double angle = 6.283185307179586 * (k + 0.5) / 1000;
            double r = radius * (out ? 1 + 1e-5 : 1 - 1e-5);
            double uv[2] = {0.5 + r * cos(angle), 0.5 + r * sin(angle)};
            if (trim_contains(trim, uv) == out)
                fail_msg("%s the circle at %g", out ? "outside" : "inside", angle);
        }
}

/* A roof with its ridge off the middle: the area is that of two planes. */
static void test_trim_area_of_a_creased_surface(void **state) {
    (void)state;
    static const double u_knots[] = {0, 0, 0.3, 1, 1}, v_knots[] = {0, 0, 1, 1};
    static const struct vec3 points[] = {{0, 0, 0},     {0, 1, 0}, {0.3, 0, 0.4},
                                         {0.3, 1, 0.4}, {1, 0, 0}, {1, 1, 0}};
    struct nurbs nurbs = {
        .u = {1, 3, u_knots}, .v = {1, 2, v_knots}, .points = points, .point_count = 6};
    nurbs.u.knot_count = 5;
    nurbs.v.knot_count = 4;
    struct surface *surface;
    struct polyline line = polyline_make(4);
    struct trim *trim;
    struct vec3 centroid;
    static const double sides[][2] = {{0.25, 0.75}, {0.2, 0.8}, {0.4567, 0.4678}};
    assert_int_equal(surface_make(&nurbs, arena, &surface), STATUS_OK);
    for (int k = 0; k < 3; k++) {
        double low = sides[k][0], high = sides[k][1];
        const double corner[4][2] = {{0.1, low}, {0.9, low}, {0.9, high}, {0.1, high}};
        memcpy(line.points, corner, sizeof corner);
        struct trim_loop loop = polyline_loop(&line, true);
        assert_int_equal(trim_make(surface, &loop, 1, arena, &trim), STATUS_OK);
        double area = (high - low) * (0.2 * hypot(0.3, 0.4) / 0.3 + 0.6 * hypot(0.7, 0.4) / 0.7);
        check_below(fabs(trim_area(trim, &centroid) - area), 1e-12);
        check_below(fabs(centroid.y - (low + high) / 2), 1e-12);
    }
}

/* ---- work ---- */

static void comb_up(double uv[2], size_t k, size_t n) {
    uv[0] = (double)k / (double)n;
    uv[1] = k % 2 ? 0.9 : 0.1;
}

static void comb_across(double uv[2], size_t k, size_t n) {
    uv[0] = k % 2 ? 0.9 : 0.1;
    uv[1] = (double)k / (double)n;
}

/* All edges cross nearly all others. */
static void star(double uv[2], size_t k, size_t n) {
    double angle = 3.14159265358979 * (double)(k * (n / 2 - 1) % n) / (double)n * 2;
    uv[0] = 0.5 + 0.4 * cos(angle);
    uv[1] = 0.5 + 0.4 * sin(angle);
}

static void spiral(double uv[2], size_t k, size_t n) {
    double share = (double)k / (double)n, angle = 2000 * share;
    uv[0] = 0.5 + 0.45 * share * cos(angle);
    uv[1] = 0.5 + 0.45 * share * sin(angle);
}

/* All but one place within 1e-9. */
static void cluster(double uv[2], size_t k, size_t n) {
    uv[0] = 0.5 + (k ? 1e-9 * cos((double)k) : 0.4);
    uv[1] = 0.5 + (k ? 1e-9 * sin((double)(k * k % n)) : 0.4);
}

/* To and fro on one line. */
static void overlaps(double uv[2], size_t k, size_t n) {
    double at = k == n - 1 ? 0.9 : (double)(k * 7919 % n) / (double)n;
    uv[0] = k == n - 1 ? 0.1 : at;
    uv[1] = at;
}

/* Ends of edges far beyond the domain. */
static void far_away(double uv[2], size_t k, size_t n) {
    uv[0] = (k % 3 ? 1e60 : -1e60) * (double)k / (double)n;
    uv[1] = k % 2 ? 1e60 : -1e60;
}

static void circle(double uv[2], size_t k, size_t n) {
    uv[0] = 0.5 + 0.4 * cos(6.283185307179586 * (double)k / (double)n);
    uv[1] = 0.5 + 0.4 * sin(6.283185307179586 * (double)k / (double)n);
}

static void test_trim_work_grows_with_the_points_alone(void **state) {
    (void)state;
    static void (*const shapes[])(double uv[2], size_t k, size_t n) = {
        comb_up, comb_across, star, spiral, cluster, overlaps, far_away, circle};
    for (size_t shape = 0; shape < sizeof shapes / sizeof *shapes; shape++)
        for (size_t n = 1000; n <= (size_t)check_sized(100000, 10000); n *= 10) {
            struct arena *own = arena_new((size_t)1 << 27), *shared = arena;
            arena = own;
            struct polyline line = polyline_make(n);
            struct trim *trim;
            for (size_t k = 0; k < n; k++)
                shapes[shape](line.points[k], k, n);
            struct trim_loop loop = polyline_loop(&line, true);
            enum status status = trim_make(square(), &loop, 1, arena, &trim);
            assert_true(status == STATUS_OK || status == STATUS_DEGENERATE_SURFACE);
            /* 2^18 crossings looked at five times at the most, and a few dozen steps an edge. */
            if (trim_steps(trim) > ((size_t)5 << 18) + 64 * n + 2048)
                fail_msg("shape %zu of %zu points: %zu steps", shape, n, trim_steps(trim));
            arena = shared;
            arena_free(own);
        }
}

/* Control points to and fro over 1e9 domains: no piece of the curve is ever flat. */
static void test_trim_flattens_wild_curves_within_bounds(void **state) {
    (void)state;
    enum { POINTS = 2000, DEGREE = 5 };
    double(*points)[2] = arena_alloc(arena, POINTS, sizeof *points);
    double *knots = arena_alloc(arena, POINTS + DEGREE + 1, sizeof *knots);
    assert_true(points && knots);
    for (size_t k = 0; k < POINTS; k++) {
        points[k][0] = k % 2 ? 1e9 : -1e9;
        points[k][1] = k % 3 ? 1e9 : -1e9;
    }
    for (size_t k = 0; k < POINTS + DEGREE + 1; k++)
        knots[k] = (double)k;
    struct trim_curve curve = {
        .degree = DEGREE, .points = (const double(*)[2])points, .count = POINTS, .knots = knots};
    struct trim_loop loop = {true, &curve, 1};
    struct trim *trim;
    enum status status = trim_make(square(), &loop, 1, arena, &trim);
    assert_true(status == STATUS_OK || status == STATUS_DEGENERATE_SURFACE);
    assert_true(trim_steps(trim) < (size_t)64 << 18);
}

/* A perforated sheet has its area exactly where the lines of the quadrature allow it. */
static void test_trim_area_of_a_perforated_sheet(void **state) {
    (void)state;
    enum { SIDE = 60, CORNERS = 24 };
    size_t count = SIDE * SIDE;
    struct polyline *lines = arena_alloc(arena, count, sizeof *lines);
    struct trim_loop *loops = arena_alloc(arena, count, sizeof *loops);
    double radius = 0.3 / SIDE, hole = CORNERS / 2.0 * sin(6.283185307179586 / CORNERS);
    for (size_t h = 0; h < count; h++) {
        lines[h] = polyline_make(CORNERS);
        for (size_t k = 0; k < CORNERS; k++) {
            double angle = 6.283185307179586 * (double)k / CORNERS;
            lines[h].points[k][0] = ((double)(h % SIDE) + 0.5) / SIDE + radius * cos(angle);
            lines[h].points[k][1] = ((double)(h / SIDE) + 0.5) / SIDE + radius * sin(angle);
        }
        loops[h] = polyline_loop(&lines[h], false);
    }
    struct trim *trim;
    struct vec3 centroid;
    assert_int_equal(trim_make(square(), loops, count, arena, &trim), STATUS_OK);
    double area = 2 * (1 - (double)count * hole * radius * radius);
    check_below(fabs(trim_area(trim, &centroid) - area), 2e-3 * area);
    check_below(fabs(centroid.x - 0.5), 1e-3);
    check_below(fabs(centroid.y - 1), 1e-3);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_trim_keeps_what_its_loops_say, set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_trim_is_flat_to_a_millionth, set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_trim_area_of_a_creased_surface, set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_trim_work_grows_with_the_points_alone, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(test_trim_flattens_wild_curves_within_bounds, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(test_trim_area_of_a_perforated_sheet, set_up, tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
