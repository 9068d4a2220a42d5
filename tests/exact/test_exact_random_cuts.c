/* SPDX-License-Identifier: MIT */
/*
 * Random pyramids and ends of prisms, cut along their edges: they unfold, so that the net is the
 * square grid and has no shear, every dart opens by what the part's angles lack of a turn, and all
 * is covered. DRAPED_SEED sets the seed and DRAPED_ROUNDS the number; what fails says its seed.
 */
#include "polyhedron.h"
#include "tests/check.h"
#include <math.h>
#include <stdio.h>

enum { ROUNDS = 120 };
static const uint64_t SEED = 1;

/* What a drape may be off: nodes, in spacings, angles at tips and shear, in degrees, and the share
 * that is bare. Nodes all but on a fold are as exact as on folds without cuts (random_folds). Where
 * a lip leaves less than a cell of a sharp corner of the rim, as at the base of a pyramid of 3, no
 * yarn leads there, and a ghost would lie beyond the cut. */
struct promise {
    enum drape_method method;
    double node, tip_deg, shear_deg, bare;
};

static const struct promise promises[] = {{DRAPE_GIB, 1e-4, 1e-2, 0.3, 5e-3},
                                          {DRAPE_GIB4, 1e-4, 1e-2, 0.3, 5e-3},
                                          {DRAPE_GEODESIC, 1e-8, 1e-6, 0.3, 5e-3}};
enum { PROMISES = sizeof promises / sizeof *promises };

/* What a result has of each promise, the worst. */
static struct promise measure(const struct polyhedron *p, const struct drape_result *result,
                              double d) {
    struct promise worst = {.bare = 1 - result->summary.cloth_coverage};
    double e[2], f[2], origin[2], at[2];
    int face = result->start_face;
    polyhedron_unfold_direction(p, face, result->start_warp, e);
    polyhedron_unfold_direction(p, face, result->start_weft, f);
    for (size_t n = 0; n < result->nodes.count; n++)
        if (result->nodes.i[n] == 0 && result->nodes.j[n] == 0)
            polyhedron_unfold(p, face,
                              vec3_make(result->nodes.x[n], result->nodes.y[n], result->nodes.z[n]),
                              origin);
    for (size_t n = 0; n < result->nodes.count; n++) {
        struct vec3 r = {result->nodes.x[n], result->nodes.y[n], result->nodes.z[n]};
        double i = result->nodes.i[n], j = result->nodes.j[n];
        polyhedron_unfold(p, result->nodes.face[n], r, at);
        worst.node = fmax(worst.node, hypot(at[0] - origin[0] - d * (i * e[0] + j * f[0]),
                                            at[1] - origin[1] - d * (i * e[1] + j * f[1])) /
                                          d);
        worst.shear_deg = fmax(worst.shear_deg, fabs(result->nodes.shear_deg[n]));
    }
    for (size_t k = 0; k < result->cells.count; k++)
        worst.shear_deg = fmax(worst.shear_deg, fabs(result->cells.shear_deg[k]));
    worst.shear_deg = fmax(worst.shear_deg, result->summary.max_shear_deg);
    for (size_t k = 0; k < result->cuts.count; k++) {
        double off = fabs(result->cuts.tip_angle_deg[k] - p->tip_deg[k]);
        worst.tip_deg = fmax(worst.tip_deg, result->cuts.covered[k] ? off : 0);
    }
    return worst;
}

static int wrong_of(uint64_t name) {
    static struct polyhedron p;
    uint64_t seed = name * 7919;
    struct arena *arena = arena_new((size_t)1 << 30);
    struct drape_result result = {0};
    bool prism = random_unit(&seed) < 0.5;
    int n = 3 + (int)(random_unit(&seed) * 5);
    double height = random_between(&seed, 30, 100), d = random_between(&seed, 3, 6);
    (prism ? polyhedron_prism : polyhedron_pyramid)(&p, n, height, &seed);
    const struct promise *promise = &promises[name % PROMISES];
    int face = (int)(random_unit(&seed) * p.count);
    struct vec3 start = polyhedron_inside(&p, face, &seed);
    struct drape_settings settings = {.method = promise->method,
                                      .spacing = {d, d},
                                      .start_kind = DRAPE_START_POINT,
                                      .start_point = start,
                                      .direction_kind = DRAPE_DIRECTION_ANGLE,
                                      .direction_deg = random_between(&seed, 0, 360),
                                      .cuts = p.cuts,
                                      .cut_count = (size_t)p.cut_count,
                                      .max_nodes = 100000};
    struct drape_part part = {.shell = polyhedron_shell(&p, arena)};
    enum status status = drape_solve(&part, &settings, NULL, arena, &result);
    struct promise worst = {.node = HUGE_VAL};
    if (status == STATUS_OK)
        worst = measure(&p, &result, d);
    bool wrong = !(worst.node < promise->node) || !(worst.tip_deg < promise->tip_deg) ||
                 !(worst.shear_deg < promise->shear_deg) || !(worst.bare < promise->bare);
    if (wrong || getenv("DRAPED_VERBOSE"))
        printf("  seed %llu: %s of %d, %s, start on %d, status %d (%d of cut %zu): %zu nodes, off "
               "%.1e, bare %.1e, shear %.1e, tips %.1e deg\n",
               (unsigned long long)name, prism ? "prism" : "pyramid", n,
               drape_method_names[promise->method], face, status, result.faulty_cut.kind,
               result.faulty_cut.cut, result.nodes.count, worst.node, worst.bare, worst.shear_deg,
               worst.tip_deg);
    arena_free(arena);
    return wrong;
}

static void test_exact_random_cuts_unfold(void **state) {
    (void)state;
    assert_int_equal(check_rounds(SEED, ROUNDS, 4, wrong_of), 0);
}

/* A yarn that sets off across one that is folded there: by the chords of that to both sides, which
 * cut the corner, it left 27 degrees aside and its nodes lay 0.92 spacings off. */
static void test_exact_random_cuts_yarn_begins_across_a_fold(void **state) {
    (void)state;
    assert_int_equal(wrong_of(188), 0);
}

/* A yarn that goes on over the lips, round the tip and back to the face that it came from: taken
 * for an arc between ends alike, it was found to pass no cut, and its node lay 2.8 spacings off. */
static void test_exact_random_cuts_yarn_comes_back_to_its_face(void **state) {
    (void)state;
    assert_int_equal(wrong_of(80) + wrong_of(131) + wrong_of(1130), 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_exact_random_cuts_yarn_comes_back_to_its_face),
        cmocka_unit_test(test_exact_random_cuts_yarn_begins_across_a_fold),
        cmocka_unit_test(test_exact_random_cuts_unfold),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
