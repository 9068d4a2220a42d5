/* SPDX-License-Identifier: MIT */
#include "api/request/prepared_part.h"
#include "solver/surface/bounds.h"
#include "solver/surface/spans.h"

#include "patch.h"
#include "support.h"
#include "tests/check.h"
#include <float.h>
#include <jansson.h>
#include <math.h>

enum {
    SURFACES = 60,
    GRID = 80,
    SPAN_GRID = 16, /* places in a span, and where an extreme hides between them */
    SPAN_GRID_FINE = 64,
    PLACES_MAX = PATCH_SIZE_MAX * SPAN_GRID_FINE + 1,
    TURNS = 30,
    CIRCLE = 9,
    PROFILE_MAX = 9
};

/* Shares of the size: what is promised, and how well the search by samples finds an extreme. */
static const double promised = 1e-9, walked = 1e-6;

static void assert_box(const struct surface *surface, const double low[3], const double high[3]) {
    struct vec3 lower, upper;
    bounds_tight(surface, &lower, &upper);
    const double found[2][3] = {{lower.x, lower.y, lower.z}, {upper.x, upper.y, upper.z}};
    double size = 0;
    for (int k = 0; k < 3; k++)
        size = fmax(size, high[k] - low[k]);
    for (int k = 0; k < 3; k++)
        if (!(fabs(found[0][k] - low[k]) <= promised * size) ||
            !(fabs(found[1][k] - high[k]) <= promised * size))
            fail_msg("coordinate %d: %.12g to %.12g, not %.12g to %.12g", k, found[0][k],
                     found[1][k], low[k], high[k]);
}

/* ---- surfaces of revolution, turned at random ---- */

/* A curve in the half-plane of radius and height, revolved about an axis. */
struct profile {
    int degree, size;
    double radius[PROFILE_MAX], height[PROFILE_MAX], weight[PROFILE_MAX];
    double knots[PROFILE_MAX + 4];
};

static const double circle_knots[] = {0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4};

static struct vec3 random_unit(struct random *random) {
    struct vec3 d;
    do
        d = vec3_make(random_between(random, -1, 1), random_between(random, -1, 1),
                      random_between(random, -1, 1));
    while (!(vec3_norm(d) > 0.1 && vec3_norm(d) < 1));
    return vec3_unit(d);
}

static void revolve(const struct profile *profile, struct vec3 axis, struct random *random,
                    struct arena *arena, struct surface **surface) {
    static const double x[CIRCLE] = {1, 1, 0, -1, -1, -1, 0, 1, 1};
    static const double y[CIRCLE] = {0, 1, 1, 1, 0, -1, -1, -1, 0};
    struct vec3 points[CIRCLE * PROFILE_MAX];
    double weights[CIRCLE * PROFILE_MAX];
    struct vec3 right = vec3_unit(vec3_cross(axis, random_unit(random)));
    struct vec3 front = vec3_cross(axis, right);
    for (int i = 0; i < CIRCLE; i++)
        for (int j = 0; j < profile->size; j++) {
            int at = i * profile->size + j;
            points[at] = vec3_scale(profile->radius[j] * x[i], right);
            points[at] = vec3_axpy(profile->radius[j] * y[i], front, points[at]);
            points[at] = vec3_axpy(profile->height[j], axis, points[at]);
            weights[at] = profile->weight[j] * (i % 2 ? sqrt(0.5) : 1);
        }
    const struct nurbs nurbs = {
        .u = {2, CIRCLE, circle_knots, CIRCLE + 3},
        .v = {profile->degree, profile->size, profile->knots,
              (size_t)(profile->size + profile->degree + 1)},
        .points = points,
        .point_count = (size_t)(CIRCLE * profile->size),
        .weights = weights,
        .weight_count = (size_t)(CIRCLE * profile->size),
    };
    assert_int_equal(surface_make(&nurbs, arena, surface), STATUS_OK);
}

/* In a direction at an angle to the axis, given by its cosine: from the middle to the end. */
typedef double reach_of(double cosine);

static void check_revolved(const struct profile *profile, reach_of *reach, const char *name) {
    struct random random = random_begin(name);
    for (int k = 0; k < TURNS; k++) {
        struct arena *arena = arena_new((size_t)1 << 24);
        struct surface *surface;
        struct vec3 axis = k < 3 ? vec3_make(k == 0, k == 1, k == 2) : random_unit(&random);
        double high[3] = {reach(axis.x), reach(axis.y), reach(axis.z)};
        double low[3] = {-high[0], -high[1], -high[2]};
        revolve(profile, axis, &random, arena, &surface);
        assert_box(surface, low, high);
        arena_free(arena);
    }
}

static double sphere_reach(double cosine) {
    (void)cosine;
    return 2;
}

static void test_bounds_of_a_sphere(void **state) {
    (void)state;
    const double h = sqrt(0.5);
    const struct profile profile = {
        2, 5, {0, 2, 2, 2, 0}, {-2, -2, 0, 2, 2}, {1, h, 1, h, 1}, {0, 0, 0, 1, 1, 2, 2, 2}};
    check_revolved(&profile, sphere_reach, __func__);
}

static double cylinder_reach(double cosine) {
    return 3 * fabs(cosine) + 0.5 * sqrt(fmax(0, 1 - cosine * cosine));
}

static void test_bounds_of_a_cylinder(void **state) {
    (void)state;
    const struct profile profile = {1, 2, {0.5, 0.5}, {-3, 3}, {1, 1}, {0, 0, 1, 1}};
    check_revolved(&profile, cylinder_reach, __func__);
}

static double torus_reach(double cosine) {
    return 3 * sqrt(fmax(0, 1 - cosine * cosine)) + 1;
}

static void test_bounds_of_a_torus(void **state) {
    (void)state;
    const double h = sqrt(0.5);
    const struct profile profile = {2,
                                    9,
                                    {4, 4, 3, 2, 2, 2, 3, 4, 4},
                                    {0, 1, 1, 1, 0, -1, -1, -1, 0},
                                    {1, h, 1, h, 1, h, 1, h, 1},
                                    {0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4}};
    check_revolved(&profile, torus_reach, __func__);
}

/* ---- flat and saddle ---- */

/* z = (x^2 - y^2) / 2 over [-2, 2]^2: the control points reach twice as far. */
static void test_bounds_of_a_saddle(void **state) {
    (void)state;
    static const double knots[] = {0, 0, 0, 1, 1, 1};
    const struct nurbs_axis axis = {2, 3, knots, 6};
    const double square[3] = {4, -4, 4};
    struct vec3 points[9];
    for (int k = 0; k < 9; k++)
        points[k] =
            vec3_make(2 * (k / 3 - 1), 2 * (k % 3 - 1), (square[k / 3] - square[k % 3]) / 2);
    const struct nurbs nurbs = {.u = axis, .v = axis, .points = points, .point_count = 9};
    struct arena *arena = arena_new(1 << 20);
    struct surface *surface;
    struct vec3 lower, upper;
    assert_int_equal(surface_make(&nurbs, arena, &surface), STATUS_OK);
    surface_bounds(surface, &lower, &upper);
    assert_true(lower.z == -4 && upper.z == 4);
    bounds_tight(surface, &lower, &upper);
    assert_true(lower.x == -2 && lower.y == -2 && lower.z == -2);
    assert_true(upper.x == 2 && upper.y == 2 && upper.z == 2);
    arena_free(arena);
}

/* The stored surface is described by its own box, and by the area that trims leave of it: here the
 * half u <= (lower + upper) / 2, of which the saddle has two alike. */
static void test_bounds_and_area_describe_a_trimmed_surface(void **state) {
    (void)state;
    struct arena *arena = arena_new((size_t)1 << 24);
    struct api_request request;
    struct api_problem problem;
    struct surface *surface;
    double lower[2], upper[2], area, low[3], high[3];
    prepare();
    assert_int_equal(decode_text(request_text("saddle"), arena, &request, &problem), API_OK);
    assert_int_equal(surface_make(&request.surface.nurbs, arena, &surface), STATUS_OK);
    surface_domain(surface, lower, upper);
    const double middle = (lower[0] + upper[0]) / 2;
    const double edge[][2] = {
        {lower[0], lower[1]}, {middle, lower[1]}, {middle, upper[1]}, {lower[0], upper[1]}};
    const struct trim_curve curve = {.degree = 1, .points = edge, .count = 4};
    const struct trim_loop loop = {.reversed = true, .curves = &curve, .count = 1};
    request.surface.trims = &loop;
    request.surface.trim_count = 1;
    const char *text = describe_text(&request.surface, arena, &problem);
    assert_non_null(text);
    json_t *json = json_loads(text, 0, NULL);
    assert_int_equal(json_unpack(json, "{s:F,s:[[F,F,F],[F,F,F]]}", "area", &area, "bounding_box",
                                 &low[0], &low[1], &low[2], &high[0], &high[1], &high[2]),
                     0);
    check_below(fabs(area - 29.7850269 / 2), 1e-4 * 15);
    for (int k = 0; k < 3; k++)
        assert_true(low[k] == -2 && high[k] == 2);
    json_decref(json);
    arena_free(arena);
}

/* ---- random surfaces ---- */

struct question {
    const struct surface *surface;
    struct surface_cursor cursor;
    double lower[2], upper[2];
    struct vec3 direction;
};

static double coordinate_at(struct question *q, double u, double v) {
    struct surface_jet jet;
    surface_evaluate(q->surface, &q->cursor, u, v, &jet);
    return vec3_dot(jet.r, q->direction);
}

/* Downhill in eight directions by steps that are halved when none helps. */
static double walk_downhill(struct question *q, double u, double v) {
    double least = coordinate_at(q, u, v), step = 1.0 / GRID;
    while (step > 1e-9) {
        double at[2] = {u, v}, before = least;
        for (int k = 0; k < 9; k++) {
            double x = u + (k / 3 - 1) * step * (q->upper[0] - q->lower[0]);
            double y = v + (k % 3 - 1) * step * (q->upper[1] - q->lower[1]);
            x = fmin(fmax(x, q->lower[0]), q->upper[0]);
            y = fmin(fmax(y, q->lower[1]), q->upper[1]);
            double value = coordinate_at(q, x, y);
            if (!(value < least))
                continue;
            least = value;
            at[0] = x;
            at[1] = y;
        }
        u = at[0];
        v = at[1];
        if (!(least < before))
            step /= 2;
    }
    return least;
}

/* Parameters along one direction: some in every span, however narrow. */
static int make_places(const struct surface_axis *axis, int span_grid, double *places) {
    int count = 0;
    for (int s = 0; s < axis->span_count; s++)
        for (int i = 0; i < span_grid; i++)
            places[count++] = surface_axis_outer(
                axis, axis->breaks[s] + (axis->breaks[s + 1] - axis->breaks[s]) * i / span_grid);
    places[count++] = surface_axis_outer(axis, axis->breaks[axis->span_count]);
    return count;
}

/* The least coordinate of a grid of samples, each that is less than its neighbours refined. */
static double search(struct question *q, int span_grid) {
    static double grid[PLACES_MAX][PLACES_MAX];
    double least = DBL_MAX, place[2][PLACES_MAX];
    int n = make_places(&q->surface->axis[0], span_grid, place[0]);
    int m = make_places(&q->surface->axis[1], span_grid, place[1]);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < m; j++)
            grid[i][j] = coordinate_at(q, place[0][i], place[1][j]);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < m; j++) {
            double c = grid[i][j];
            if ((i > 0 && grid[i - 1][j] < c) || (i < n - 1 && grid[i + 1][j] < c) ||
                (j > 0 && grid[i][j - 1] < c) || (j < m - 1 && grid[i][j + 1] < c))
                continue;
            least = fmin(least, walk_downhill(q, place[0][i], place[1][j]));
        }
    return least;
}

/* hull <= box <= any place found, and the walk comes close: it stops short of extremes at creases,
 * where it has eight directions and needs another. */
static void check_random(const struct surface *surface) {
    struct vec3 hull[2], tight[2];
    surface_bounds(surface, &hull[0], &hull[1]);
    bounds_tight(surface, &tight[0], &tight[1]);
    double size = vec3_distance(hull[0], hull[1]);
    for (int k = 0; k < 6; k++) {
        double sign = k < 3 ? 1 : -1;
        struct question q = {.surface = surface};
        q.direction = vec3_make(sign * (k % 3 == 0), sign * (k % 3 == 1), sign * (k % 3 == 2));
        surface_domain(surface, q.lower, q.upper);
        double value = vec3_dot(q.direction, tight[k / 3]), found = search(&q, SPAN_GRID);
        if (value < found - walked * size)
            found = search(&q, SPAN_GRID_FINE);
        check_at_least(value, vec3_dot(q.direction, hull[k / 3]) - 1e-12 * size);
        if (!(value <= found + promised * size && value >= found - walked * size))
            fail_msg("side %d: %.12g, but the surface reaches %.12g", k, value, found);
    }
}

static void test_bounds_are_those_of_a_search(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    for (int k = 0; k < SURFACES; k++) {
        struct patch patch;
        struct surface *surface;
        struct patch_kind kind = {1 + random_index(&random, NURBS_DEGREE_MAX),
                                  1 + random_index(&random, NURBS_DEGREE_MAX), k % 2 == 0,
                                  k % 4 < 2};
        struct arena *arena = arena_new((size_t)1 << 26);
        patch_make(&patch, &kind, &random);
        assert_int_equal(surface_make(&patch.nurbs, arena, &surface), STATUS_OK);
        check_random(surface);
        arena_free(arena);
    }
}

/* ---- the bound ---- */

struct gap {
    double least;
    double width; /* of the cells looked at */
    double bound;
};

static int judge_gap(void *context, const struct bounds_cell *cell) {
    struct gap *gap = context;
    double width = cell->upper[0] - cell->lower[0], height = cell->upper[1] - cell->lower[1];
    if (width > gap->width)
        return 0;
    if (height > gap->width)
        return 1;
    gap->bound = fmin(gap->bound, bounds_least(cell));
    gap->least = fmin(gap->least, bounds_least_corner(cell, NULL));
    return BOUNDS_SETTLED;
}

/* f = (x - 1/3)^2 + (y - 2/3)^2 - x y / 4 over weights that vary: what the least ratio is below f
 * goes down with the square of the cells, and never above it. */
static void test_bounds_close_with_the_square_of_the_cells(void **state) {
    (void)state;
    static struct bounds_search search;
    double gaps[2];
    for (int k = 0; k < 2; k++) {
        struct gap gap = {DBL_MAX, 1.0 / (32 << k), DBL_MAX};
        search = (struct bounds_search){.degree = {2, 2}, .judge = judge_gap, .context = &gap};
        for (int i = 0; i < 9; i++) {
            double a = 1.0 / 3, b = 2.0 / 3, x = i / 3 / 2.0, y = i % 3 / 2.0;
            double xx = i / 3 == 2 ? 1 : 0, yy = i % 3 == 2 ? 1 : 0; /* blossoms of x^2, y^2 */
            double w = 1 + 0.2 * x + 0.1 * y;
            search.store[i] =
                (bounds_pair){xx - 2 * a * x + a * a + yy - 2 * b * y + b * b - x * y / 4, w};
        }
        bounds_run(&search);
        check_at_most(gap.bound, gap.least);
        gaps[k] = gap.least - gap.bound;
    }
    check_above(gaps[0], 0);
    check_below(gaps[0], 1e-2);
    if (!(gaps[1] < 0.35 * gaps[0]))
        fail_msg("gaps %g and %g", gaps[0], gaps[1]);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_bounds_of_a_sphere),
        cmocka_unit_test(test_bounds_of_a_cylinder),
        cmocka_unit_test(test_bounds_of_a_torus),
        cmocka_unit_test(test_bounds_of_a_saddle),
        cmocka_unit_test(test_bounds_and_area_describe_a_trimmed_surface),
        cmocka_unit_test(test_bounds_are_those_of_a_search),
        cmocka_unit_test(test_bounds_close_with_the_square_of_the_cells),
    };
    return cmocka_run_group_tests_name("bounds", tests, NULL, NULL);
}
