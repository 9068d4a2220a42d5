/* SPDX-License-Identifier: MIT */
/*
 * Shells of rings: faces that close on themselves and meet along whole circles, as turned parts
 * have them. Cylinders are developable: the net is square whatever the rings, and covers all.
 */
#include "measure.h"
#include "shapes.h"
#include "tests/check.h"
#include <stdio.h>

static const double DEG = M_PI / 180, HEIGHT = 2, SPACING = 0.15;

enum { RINGS = 3 };

/* What a ring is of: a face of its own, all of that face by a trim, or a part of the whole. */
enum ring_kind { RING_OWN, RING_TRIMMED, RING_PART, RING_KINDS };

static const char *const kind_names[] = {"faces", "trimmed faces", "parts of one"};

struct rings {
    struct shape shape[RINGS];
    double corners[RINGS][5][2];
    struct trim_curve curve[RINGS];
    struct trim_loop loop[RINGS];
};

static const double knots[] = {0, 0, 1, 2, 3, 4, 4};

/* The rings of a cylinder between `z`, the seam of each somewhere else unless `aligned`. */
static struct shell *make_rings(struct rings *rings, enum ring_kind kind, const double *z,
                                bool aligned, struct arena *arena) {
    struct shell_patch *parts = arena_alloc(arena, RINGS, sizeof *parts);
    struct shell *shell = NULL;
    for (int k = 0; k < RINGS; k++) {
        double turn = aligned ? 0.4 : 0.4 + 1.7 * k;
        double low = kind == RING_PART ? 0 : z[k], high = kind == RING_PART ? HEIGHT : z[k + 1];
        double v[2] = {(z[k] - low) / (high - low), (z[k + 1] - low) / (high - low)};
        struct surface *surface;
        shape_frustum(&rings->shape[k], (double[2]){turn, turn + 2 * M_PI}, (double[2]){1, low},
                      (double[2]){1, high}, M_PI / 2);
        struct nurbs nurbs = shape_nurbs(&rings->shape[k]);
        assert_int_equal(surface_make(&nurbs, arena, &surface), STATUS_OK);
        for (int n = 0; n < 5; n++) {
            rings->corners[k][n][0] = (n + 1) / 2 % 2;
            rings->corners[k][n][1] = v[n / 2 % 2];
        }
        rings->curve[k] = (struct trim_curve){1, (const double(*)[2])rings->corners[k], 5,
                                              k % 2 ? knots : NULL, NULL};
        rings->loop[k] = (struct trim_loop){true, &rings->curve[k], 1};
        parts[k] = (struct shell_patch){
            .surface = surface, .loops = &rings->loop[k], .loop_count = kind != RING_OWN};
    }
    assert_int_equal(shell_make(parts, RINGS, 0, arena, &shell, NULL), STATUS_OK);
    return shell;
}

/* Whether cloth reaches all of a rim that is there. */
static bool is_covered(const struct drape_rim *rim) {
    bool covered = rim->count > 0;
    for (size_t k = 0; k < rim->count; k++)
        covered = covered && rim->covered[k];
    return covered;
}

/* How far the nodes are from the unrolled square grid, in spacings. */
static double off_grid(const struct drape_result *result, double angle_deg) {
    const struct drape_nodes *nodes = &result->nodes;
    double c = cos(angle_deg * DEG), s = sin(angle_deg * DEG), worst = 0;
    struct vec3 start = result->start_point;
    for (size_t k = 0; k < nodes->count; k++) {
        double x = SPACING * (c * nodes->i[k] - s * nodes->j[k]);
        double y = SPACING * (s * nodes->i[k] + c * nodes->j[k]);
        double turn = atan2(start.y, start.x) + x;
        struct vec3 exact = vec3_make(cos(turn), sin(turn), start.z + y);
        worst = fmax(worst, vec3_distance(exact, node_point(nodes, (int)k)) / SPACING);
    }
    return worst;
}

static void test_exact_rings_are_the_cylinder(void **state) {
    static struct rings rings;
    uint64_t seed = 5;
    (void)state;
    for (int n = 0; n < 24; n++) {
        enum ring_kind kind = n % RING_KINDS;
        bool aligned = n / RING_KINDS % 2;
        struct arena *arena = arena_new((size_t)1 << 28);
        double z[RINGS + 1] = {0, random_between(&seed, 0.2, 0.9), random_between(&seed, 1, 1.8),
                               HEIGHT};
        double angle = n % 4 ? random_between(&seed, -45, 45) : 0;
        struct shell *shell = make_rings(&rings, kind, z, aligned, arena);
        struct drape_result result;
        struct drape_settings settings = {.method = DRAPE_GEODESIC,
                                          .spacing = {SPACING, SPACING},
                                          .start_kind = DRAPE_START_UV,
                                          .start_uv = {n % 5 ? random_unit(&seed) : 0.5, 0.5},
                                          .start_face = n % RINGS,
                                          .direction_deg = angle,
                                          .max_nodes = 100000};
        if (kind == RING_PART)
            settings.start_uv[1] = (z[n % RINGS] + z[n % RINGS + 1]) / 2 / HEIGHT;
        assert_int_equal(shell_component_count(shell), 1);
        check_below(shell_edges(shell).largest_gap, 1e-9);
        assert_int_equal(
            drape_solve(&(struct drape_part){.shell = shell}, &settings, NULL, arena, &result),
            STATUS_OK);
        bool covered = is_covered(&result.rim);
        double area = rim_flat_area(&result.rim, settings.spacing) / (2 * M_PI * HEIGHT) - 1;
        double off = off_grid(&result, angle);
        if (!covered || fabs(area) > 1e-3 || off > 1e-6)
            printf("  case %d, %s%s, from u = %.3f of %d at %.1f degrees:\n", n, kind_names[kind],
                   aligned ? ", seams in line" : "", settings.start_uv[0], settings.start_face,
                   angle);
        check_below(off, 1e-6);
        check_below(fabs(area), 1e-3);
        assert_true(covered);
        check_at_least(result.summary.cloth_coverage, DRAPE_COMPLETE_COVERAGE);
        arena_free(arena);
    }
}

/* A sphere in halves that meet at both poles, each trimmed by one polyline round its share of the
 * domain, from somewhere on: the nodes of the whole. */
static void test_exact_rings_halves_of_a_sphere(void **state) {
    static struct rings rings;
    static struct shape whole;
    (void)state;
    shape_sphere(&whole, 1, (double[2]){0, 2 * M_PI}, (double[2]){-M_PI / 2, M_PI / 2}, M_PI / 2);
    for (int n = 0; n < 8; n++) {
        struct arena *arena = arena_new((size_t)1 << 28);
        struct shell_patch parts[2] = {{0}};
        struct shell *shell = NULL;
        struct drape_run run;
        struct drape_result result;
        double seam = n % 2 ? 0.5 : 0.37, worst = 0;
        for (int k = 0; k < 2; k++) {
            const double u[2] = {k ? seam : 0, k ? 1 : seam};
            struct nurbs nurbs = shape_nurbs(&whole);
            struct surface *surface;
            assert_int_equal(surface_make(&nurbs, arena, &surface), STATUS_OK);
            for (int m = 0; m < 5; m++) { /* from each of the corners on */
                int corner = (m + n / 2) % 4;
                rings.corners[k][m][0] = u[(corner + 1) / 2 % 2];
                rings.corners[k][m][1] = corner / 2;
            }
            rings.curve[k] = (struct trim_curve){1, (const double(*)[2])rings.corners[k], 5,
                                                 k % 2 ? knots : NULL, NULL};
            rings.loop[k] = (struct trim_loop){true, &rings.curve[k], 1};
            parts[k] =
                (struct shell_patch){.surface = surface, .loops = &rings.loop[k], .loop_count = 1};
        }
        struct drape_settings settings = {.method = n % 4 ? DRAPE_GIB : DRAPE_GEODESIC,
                                          .spacing = {SPACING, SPACING},
                                          .start_kind = DRAPE_START_UV,
                                          .start_uv = {0.2, 0.45},
                                          .direction_deg = 25,
                                          .max_nodes = 100000};
        drape_begin(&run, &whole, &settings);
        assert_int_equal(shell_make(parts, 2, 0, arena, &shell, NULL), STATUS_OK);
        assert_int_equal(
            drape_solve(&(struct drape_part){.shell = shell}, &settings, NULL, arena, &result),
            STATUS_OK);
        assert_int_equal(result.nodes.count, run.result.nodes.count);
        for (size_t k = 0; k < result.nodes.count; k++) {
            int at = grid_find(&run.grid, result.nodes.i[k], result.nodes.j[k]);
            assert_true(at >= 0);
            worst = fmax(worst, vec3_distance(node_point(&result.nodes, (int)k),
                                              node_point(&run.result.nodes, at)));
        }
        check_below(worst, 1e-7);
        check_below(fabs(result.summary.cloth_coverage - run.result.summary.cloth_coverage), 1e-3);
        drape_end(&run);
        arena_free(arena);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_exact_rings_are_the_cylinder),
        cmocka_unit_test(test_exact_rings_halves_of_a_sphere),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
