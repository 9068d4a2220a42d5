/* SPDX-License-Identifier: MIT */
/*
 * Starts at corners, on edges and on trims, in all directions: some generators leave the part at
 * once. On flat parts the net is the square grid through the start, whatever it grew from; it
 * covers the part up to a strip of a cell's diagonal.
 */
#include "measure.h"
#include "tests/check.h"
#include <math.h>
#include <stdio.h>

enum { DIRECTIONS = 20, ROWS = 12, VERTICES = (ROWS + 1) * (ROWS + 1) };

static const double SPACING = 0.05;

/* A part as triangles, its area and perimeter, and starts: corners and places on its edges. */
struct part {
    const char *name;
    struct vec3 (*map)(double u, double v); /* of [0, 1]^2; may join places */
    bool flat;
    double area, perimeter;
    struct vec3 starts[6];
    int start_count;
    int stuck; /* how often all four yarns leave at once, as they do in a corner of 60 degrees */
};

static struct vec3 square(double u, double v) {
    return vec3_make(u, v, 0);
}

static struct vec3 triangle(double u, double v) {
    return vec3_make(u * (1 - v / 2), u * v * sqrt(0.75), 0);
}

static struct vec3 disk(double u, double v) {
    return vec3_make(u / 2 * cos(2 * M_PI * v), u / 2 * sin(2 * M_PI * v), 0);
}

static struct vec3 octant(double u, double v) {
    double a = u * M_PI / 2, b = v * M_PI / 2;
    return vec3_make(sin(a) * cos(b), sin(a) * sin(b), cos(a));
}

static const struct part parts[] = {
    {"square",
     square,
     true,
     1,
     4,
     {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0.5, 0, 0}, {1, 0.3, 0}},
     5,
     0},
    {"triangle",
     triangle,
     true,
     0.4330127018922193,
     3,
     {{0, 0, 0},
      {1, 0, 0},
      {0.5, 0.8660254037844386, 0},
      {0.5, 0, 0},
      {0.75, 0.4330127018922193, 0}},
     5,
     16},
    {"disk",
     disk,
     true,
     0.75,
     3.11,
     {{0.5, 0, 0}, {0, 0.5, 0}, {-0.25, -0.43301270189221935, 0}},
     3,
     0},
    {"octant", octant, false, 1.5707963267948966, 4.72, {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}}, 3, 0},
};

/* Rows of quadrilaterals, each two triangles; places that the map joins are one vertex. */
static struct mesh *make_mesh(const struct part *part, struct arena *arena) {
    static struct vec3 vertices[VERTICES];
    static int32_t index[ROWS + 1][ROWS + 1], triangles[2 * ROWS * ROWS][3];
    size_t count = 0, total = 0;
    for (int i = 0; i <= ROWS; i++)
        for (int j = 0; j <= ROWS; j++) {
            struct vec3 r = part->map((double)i / ROWS, (double)j / ROWS);
            size_t at = 0;
            while (at < count && vec3_distance(vertices[at], r) > 1e-12)
                at++;
            vertices[at] = at < count ? vertices[at] : r;
            count += at == count;
            index[i][j] = (int32_t)at;
        }
    for (int k = 0; k < 2 * ROWS * ROWS; k++) {
        int i = k / 2 / ROWS, j = k / 2 % ROWS;
        int32_t a = index[i][j], b = index[i + 1][j], c = index[i + 1][j + 1], d = index[i][j + 1];
        int32_t t[3] = {a, k % 2 ? c : b, k % 2 ? d : c};
        if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0])
            continue;
        for (int x = 0; x < 3; x++)
            triangles[total][x] = t[x];
        total++;
    }
    struct mesh_source source = {.vertices = vertices,
                                 .vertex_count = count,
                                 .triangles = (const int32_t(*)[3])triangles,
                                 .triangle_count = total};
    struct mesh *mesh;
    struct mesh_fault fault;
    assert_int_equal(mesh_make(&source, arena, &mesh, &fault), STATUS_OK);
    return mesh;
}

/* How far nodes are from r(start) + i d warp + j d weft. */
static double grid_gap(const struct drape_result *result, const double d[2]) {
    double gap = 0;
    for (size_t k = 0; k < result->nodes.count; k++) {
        struct vec3 warp = vec3_scale(d[0] * result->nodes.i[k], result->start_warp);
        struct vec3 weft = vec3_scale(d[1] * result->nodes.j[k], result->start_weft);
        struct vec3 wanted = vec3_add(result->start_point, vec3_add(warp, weft));
        gap = fmax(gap, vec3_distance(node_point(&result->nodes, (int)k), wanted));
    }
    return gap;
}

/* What is not covered is a strip along the edge. At a pole a direction is found to 1e-8, by a
 * search for a largest cosine; elsewhere all is exact. */
static void check_covered(const char *name, double area, double perimeter, const double d[2],
                          const struct drape_result *result, bool flat) {
    double strip = hypot(d[0], d[1]) * perimeter / area;
    if (1 - result->summary.coverage > strip)
        fail_msg("%s: coverage %.3f", name, result->summary.coverage);
    if (flat && grid_gap(result, d) > 2e-7)
        fail_msg("%s: %g from the square grid", name, grid_gap(result, d));
    assert_true(!flat || result->summary.max_shear_deg < 1e-3);
}

static struct drape_settings settings_to(int direction, enum drape_method method) {
    double angle = 2 * M_PI * direction / DIRECTIONS;
    return (struct drape_settings){.method = method,
                                   .spacing = {SPACING, 0.8 * SPACING},
                                   .direction_kind = DRAPE_DIRECTION_VECTOR,
                                   .direction_vector = {cos(angle), sin(angle), 0.3},
                                   .start_kind = DRAPE_START_POINT,
                                   .max_nodes = 100000};
}

static void test_exact_starts_on_meshes(void **state) {
    (void)state;
    for (size_t p = 0; p < sizeof parts / sizeof *parts; p++) {
        const struct part *part = &parts[p];
        struct arena *arena = arena_new((size_t)1 << 28);
        struct mesh *mesh = make_mesh(part, arena);
        int stuck = 0;
        double least = 1;
        for (int k = 0; k < part->start_count * DIRECTIONS; k++) {
            struct arena_mark mark = arena_mark(arena);
            struct drape_settings settings = settings_to(k % DIRECTIONS, DRAPE_MOSAIC);
            struct drape_result result;
            settings.start_point = part->starts[k / DIRECTIONS];
            enum status status =
                drape_solve(&(struct drape_part){.mesh = mesh}, &settings, NULL, arena, &result);
            stuck += status == STATUS_START_STUCK;
            if (status != STATUS_START_STUCK) {
                assert_int_equal(status, STATUS_OK);
                check_covered(part->name, mesh->area, part->perimeter, settings.spacing, &result,
                              part->flat);
                least = fmin(least, result.summary.coverage);
            }
            arena_rewind(arena, mark);
        }
        printf("  %-9s %3d starts, coverage %.3f at least, %d stuck\n", part->name,
               part->start_count * DIRECTIONS, least, stuck);
        assert_int_equal(stuck, part->stuck);
        arena_free(arena);
    }
}

static const enum drape_method methods[] = {DRAPE_GIB, DRAPE_GEODESIC, DRAPE_BASIC};

/* A triangle that tapers to a pole at (0, 0), the same cut out of a square by a trim, and a disk,
 * from their corners and edges. */
static void check_method(const char *name, struct surface *surface, const struct trim *trim,
                         const struct part *part, enum drape_method method, int most_stuck,
                         struct arena *arena) {
    double least = 1;
    int stuck = 0;
    for (int k = 0; k < part->start_count * DIRECTIONS; k++) {
        struct arena_mark mark = arena_mark(arena);
        struct drape_settings settings = settings_to(k % DIRECTIONS, method);
        struct drape_result result;
        settings.start_point = part->starts[k / DIRECTIONS];
        enum status status = drape_solve(&(struct drape_part){.surface = surface, .trim = trim},
                                         &settings, NULL, arena, &result);
        stuck += status == STATUS_START_STUCK;
        if (status != STATUS_START_STUCK) {
            assert_int_equal(status, STATUS_OK);
            check_at_most(vec3_distance(result.start_point, settings.start_point), 4e-5);
            check_covered(name, part->area, part->perimeter, settings.spacing, &result, true);
            least = fmin(least, result.summary.coverage);
        }
        arena_rewind(arena, mark);
    }
    printf("  %-9s %3d starts, coverage %.3f at least, %d stuck\n", name,
           part->start_count * DIRECTIONS, least, stuck);
    check_at_most(stuck, most_stuck);
}

static void check_surface(const char *name, struct surface *surface, const struct trim *trim,
                          const struct part *part, int most_stuck, struct arena *arena) {
    for (size_t m = 0; m < sizeof methods / sizeof *methods; m++)
        check_method(name, surface, trim, part, methods[m], most_stuck, arena);
}

static const double knots[] = {0, 0, 1, 1};

static void test_exact_starts_on_triangular_patches(void **state) {
    (void)state;
    const struct part *part = &parts[1];
    struct arena *arena = arena_new((size_t)1 << 28);
    const struct vec3 points[] = {part->starts[0], part->starts[0], part->starts[1],
                                  part->starts[2]};
    struct nurbs nurbs = {
        .u = {1, 2, knots}, .v = {1, 2, knots}, .points = points, .point_count = 4};
    struct surface *surface;
    assert_int_equal(surface_make(&nurbs, arena, &surface), STATUS_OK);
    check_surface("patch", surface, NULL, part, 4, arena); /* at the pole */
    arena_free(arena);
}

/* At the corners of the patch r_u and r_v are parallel: the net begins 3e-5 of its
 * size inside. */
static void test_exact_starts_on_singular_corners(void **state) {
    (void)state;
    static const struct part part = {.name = "disk in one patch",
                                     .area = M_PI / 4,
                                     .perimeter = M_PI,
                                     .starts = {{0.35355339059327379, 0.35355339059327379, 0},
                                                {-0.35355339059327379, 0.35355339059327379, 0},
                                                {-0.35355339059327379, -0.35355339059327379, 0},
                                                {0.35355339059327379, -0.35355339059327379, 0},
                                                {0.5, 0, 0},
                                                {-0.3, 0.4, 0}},
                                     .start_count = 6};
    static struct shape shape;
    struct arena *arena = arena_new((size_t)1 << 28);
    struct surface *surface;
    shape_disk(&shape, 0.5);
    struct nurbs nurbs = shape_nurbs(&shape);
    assert_int_equal(surface_make(&nurbs, arena, &surface), STATUS_OK);
    check_surface(part.name, surface, NULL, &part, 0, arena);
    arena_free(arena);
}

static void test_exact_starts_on_trims(void **state) {
    (void)state;
    const struct part *part = &parts[1];
    struct arena *arena = arena_new((size_t)1 << 28);
    static const struct vec3 points[] = {{-1, -1, 0}, {-1, 1, 0}, {1, -1, 0}, {1, 1, 0}};
    struct nurbs nurbs = {
        .u = {1, 2, knots}, .v = {1, 2, knots}, .points = points, .point_count = 4};
    struct surface *surface;
    struct trim *trim;
    double corners[3][2];
    for (int k = 0; k < 3; k++) {
        corners[k][0] = (part->starts[k].x + 1) / 2;
        corners[k][1] = (part->starts[k].y + 1) / 2;
    }
    struct trim_curve curve = {.degree = 1, .points = (const double(*)[2])corners, .count = 3};
    struct trim_loop loop = {true, &curve, 1};
    assert_int_equal(surface_make(&nurbs, arena, &surface), STATUS_OK);
    assert_int_equal(trim_make(surface, &loop, 1, arena, &trim), STATUS_OK);
    check_surface("trim", surface, trim, part, 0, arena);

    struct drape_settings settings = settings_to(0, DRAPE_GIB);
    struct drape_result result;
    settings.start_point = vec3_make(0.5, -1e-4, 0);
    assert_int_equal(drape_solve(&(struct drape_part){.surface = surface, .trim = trim}, &settings,
                                 NULL, arena, &result),
                     STATUS_START_OFF_SURFACE);
    arena_free(arena);
}

/* From the pole of an octant straight down its middle: weft leaves the octant at once, but goes on
 * over the continuation, and carries more of the net than a yarn that begins across warp would. */
static void test_exact_starts_at_the_pole_of_an_octant(void **state) {
    (void)state;
    static const double quarter[2] = {0, M_PI / 2};
    static struct shape shape;
    struct drape_settings settings = {.method = DRAPE_GIB,
                                      .spacing = {0.03, 0.03},
                                      .start_kind = DRAPE_START_UV,
                                      .start_uv = {0.5, 1},
                                      .max_nodes = 100000};
    struct drape_run run;
    shape_sphere(&shape, 1, quarter, quarter, M_PI / 2);
    drape_begin(&run, &shape, &settings);
    struct frame start = {run.result.start_point, run.result.start_warp, run.result.start_weft};
    double gap = sphere_gap(&run, vec3_make(0, 0, 0), &start, settings.spacing, 8);
    printf("  octant: coverage %.3f, %.1e from the sphere's net\n", run.result.summary.coverage,
           gap);
    assert_true(gap < 1e-6 && run.result.summary.coverage > 0.945);
    drape_end(&run);
}

/* A flat wedge whose tip of 30 degrees is the centroid of the hook that it ends in. Nobody asked
 * for a start in that tip, where no yarn at 45 degrees stays: it is one inside. */
static void test_exact_starts_by_default_where_cloth_begins(void **state) {
    (void)state;
    enum { STRAIGHT = 9, TURN = 49, COUNT = STRAIGHT + TURN };
    struct vec3 points[2 * COUNT];
    double along[COUNT + 2];
    for (int k = 0; k < STRAIGHT; k++)
        for (int side = 0; side < 2; side++)
            points[2 * k + side] = vec3_make(0.1 * k, (side ? 0.1 : -0.1) * k * tan(M_PI / 12), 0);
    for (int k = 1; k <= TURN; k++)
        for (int side = 0; side < 2; side++) {
            double angle = M_PI / 12 + k * 5 * M_PI / 3 / TURN, radius = side ? 0.8 : 1.2;
            points[2 * (STRAIGHT + k - 1) + side] =
                vec3_make(radius * cos(angle), radius * sin(angle), 0);
        }
    for (int k = 0; k < COUNT + 2; k++)
        along[k] = k == 0 ? 0 : k > COUNT ? COUNT - 1 : k - 1;
    static const double across[] = {0, 0, 1, 1};
    const struct nurbs nurbs = {
        .u = {1, COUNT, along}, .v = {1, 2, across}, .points = points, .point_count = 2 * COUNT};
    struct arena *arena = arena_new((size_t)1 << 30);
    struct surface *surface;
    assert_int_equal(surface_make(&nurbs, arena, &surface), STATUS_OK);
    double least = HUGE_VAL;
    for (int k = 0; k < DIRECTIONS; k++) {
        struct drape_settings settings = settings_to(k, DRAPE_GIB);
        struct drape_result result;
        settings.start_kind = DRAPE_START_CENTROID;
        assert_int_equal(
            drape_solve(&(struct drape_part){.surface = surface}, &settings, NULL, arena, &result),
            STATUS_OK);
        least = fmin(least, (double)result.cells.count);
    }
    printf("  hook: %.0f cells at least\n", least);
    check_above(least, 20);
    arena_free(arena);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_exact_starts_on_meshes),
        cmocka_unit_test(test_exact_starts_on_triangular_patches),
        cmocka_unit_test(test_exact_starts_on_singular_corners),
        cmocka_unit_test(test_exact_starts_on_trims),
        cmocka_unit_test(test_exact_starts_at_the_pole_of_an_octant),
        cmocka_unit_test(test_exact_starts_by_default_where_cloth_begins),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
