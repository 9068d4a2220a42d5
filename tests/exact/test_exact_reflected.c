/* SPDX-License-Identifier: MIT */
/* Zones of a surface of revolution, each reflected in the plane of the parallel that it has in
 * common with the one before: a bellows. What lies within the surface stays as it is, so that the
 * net is that of the whole surface, zone by zone reflected, beyond the ends of the creases too. */
#include "measure.h"
#include "tests/check.h"
#include <math.h>
#include <stdio.h>

enum { ZONES_MAX = 3 };
static const uint64_t SEED = 20261123;

/* Zones between latitudes, of a sphere, or of the outer side of a torus when `major` > 0; r =
 * (x, y, side z + shift) in each. */
struct bellows {
    double major, latitude[ZONES_MAX + 1], turn[2];
    double side[ZONES_MAX], shift[ZONES_MAX];
    int zones, home; /* which is as it is on the whole */
    struct shape whole, zone[ZONES_MAX];
};

static const double radius = 100;

static void make_zone(const struct bellows *b, int from, int to, struct shape *shape) {
    const double arc[2] = {b->latitude[from], b->latitude[to]};
    if (b->major > 0)
        shape_torus(shape, b->major, radius, b->turn, arc, M_PI / 2);
    else
        shape_sphere(shape, radius, b->turn, arc, M_PI / 2);
}

/* Reflects zone k in the parallel that it has in common with `before`. */
static void reflect(struct bellows *b, int k, int before) {
    double common = radius * sin(b->latitude[k > before ? k : before]);
    double z = b->side[before] * common + b->shift[before];
    b->side[k] = -b->side[before];
    b->shift[k] = z - b->side[k] * common;
}

/* Creases turn by 30 degrees at least, and 150 at most. */
static void bellows_make(struct bellows *b, uint64_t *seed) {
    static const double end = 50 * M_PI / 180, flat = 15 * M_PI / 180, least = 15 * M_PI / 180;
    double half = random_between(seed, 0.4, 0.8);
    b->major = random_unit(seed) < 0.5 ? 0 : random_between(seed, 120, 250);
    b->turn[0] = -half;
    b->turn[1] = half;
    b->zones = random_unit(seed) < 0.5 ? 2 : 3;
    b->home = (int)(random_unit(seed) * b->zones);
    b->latitude[0] = -end;
    b->latitude[b->zones] = end;
    for (int k = 1; k < b->zones; k++) {
        double low = b->zones == 2 || k == 2 ? flat : -end + least;
        double high = b->zones == 2 || k == 2 ? end - least : -flat;
        b->latitude[k] = random_between(seed, low, high);
    }
    b->side[b->home] = 1;
    b->shift[b->home] = 0;
    for (int k = b->home + 1; k < b->zones; k++)
        reflect(b, k, k - 1);
    for (int k = b->home; k-- > 0;)
        reflect(b, k, k + 1);
    make_zone(b, 0, b->zones, &b->whole);
    for (int k = 0; k < b->zones; k++) {
        struct motion motion = motion_stretch(1, 1, b->side[k]);
        motion.shift.z = b->shift[k];
        make_zone(b, k, k + 1, &b->zone[k]);
        shape_move(&b->zone[k], &motion);
    }
}

static struct shell *bellows_join(struct bellows *b, struct arena *arena) {
    struct shell_patch part[ZONES_MAX] = {{0}};
    struct shell_fault fault;
    struct shell *shell;
    for (int k = 0; k < b->zones; k++) {
        struct nurbs nurbs = shape_nurbs(&b->zone[k]);
        struct surface *surface;
        assert_int_equal(surface_make(&nurbs, arena, &surface), STATUS_OK);
        part[k].surface = surface;
    }
    assert_int_equal(shell_make(part, (size_t)b->zones, 0, arena, &shell, &fault), STATUS_OK);
    return shell;
}

/* Where a place of the whole lies on the bellows. */
static struct vec3 fold(const struct bellows *b, struct vec3 r) {
    double latitude = atan2(r.z, sqrt(r.x * r.x + r.y * r.y) - b->major);
    int k = 0;
    while (k + 1 < b->zones && latitude > b->latitude[k + 1])
        k++;
    return vec3_make(r.x, r.y, b->side[k] * r.z + b->shift[k]);
}

/* The largest distance of a node from that of the whole net, in spacings; `missing` counts those of
 * the whole that are not there. */
static double largest_error(const struct bellows *b, const struct drape_run *whole,
                            const struct drape_nodes *nodes, double d, int *missing) {
    struct grid grid;
    double largest = 0;
    *missing = 0;
    grid_make(&grid, nodes);
    for (size_t k = 0; k < whole->result.nodes.count; k++) {
        const struct drape_nodes *of = &whole->result.nodes;
        int at = grid_find(&grid, of->i[k], of->j[k]);
        if (at < 0)
            *missing += 1;
        else
            largest = fmax(
                largest, vec3_distance(node_point(nodes, at), fold(b, node_point(of, (int)k))) / d);
    }
    grid_free(&grid);
    return largest;
}

/* Whether nodes have grown from what there was, where no cell led to them: from how much of the
 * continuation there was hangs on the size of the part, which the bellows changes. */
static bool has_grown(const struct drape_nodes *nodes) {
    for (size_t k = 0; k < nodes->count; k++)
        if (nodes->grown[k])
            return true;
    return false;
}

static const struct {
    const char *name;
    enum drape_method id;
    double position;
} methods[] = {
    {"geodesic", DRAPE_GEODESIC, 1e-9}, {"gib", DRAPE_GIB, 1e-3}, {"gib4", DRAPE_GIB4, 5e-3}};

static int ended_early; /* nets that end inside, and say so */

static int is_wrong(uint64_t seed) {
    static struct bellows b;
    int wrong = 0;
    uint64_t from = seed;
    bellows_make(&b, &seed);
    double cells = random_between(&seed, 150, 800), share[2];
    for (int k = 0; k < 2; k++)
        share[k] = random_between(&seed, 0.3, 0.7);
    const double d = sqrt(shape_area(&b.whole) / cells);
    struct drape_settings settings = {.start_kind = DRAPE_START_POINT,
                                      .start_point = shape_point(&b.zone[b.home], share),
                                      .spacing = {d, d},
                                      .direction_deg = random_between(&seed, 0, 90),
                                      .max_nodes = 10000};
    for (size_t m = 0; m < sizeof methods / sizeof *methods; m++) {
        struct arena *arena = arena_new((size_t)1 << 30);
        struct drape_run whole;
        struct drape_result result;
        int missing;
        settings.method = methods[m].id;
        assert_int_equal(drape_try(&whole, &b.whole, &settings), STATUS_OK);
        assert_int_equal(drape_solve(&(struct drape_part){.shell = bellows_join(&b, arena)},
                                     &settings, NULL, arena, &result),
                         STATUS_OK);
        double off = largest_error(&b, &whole, &result.nodes, d, &missing);
        bool other = has_grown(&whole.result.nodes) || has_grown(&result.nodes);
        /* Zones that lie near each other are taken for cloth on cloth at times; the result says so.
         */
        bool ended = off < methods[m].position &&
                     result.summary.front_reasons[DRAPE_REASON_FOLD] > 0 &&
                     result.summary.outcome == DRAPE_PARTIAL;
        ended_early += ended && missing > 0;
        bool right = other || ended || (off < methods[m].position && missing == 0);
        printf("    seed %llu %-8s %4zu nodes of %d zones, %d missing, %.1e d%s\n",
               (unsigned long long)from, methods[m].name, whole.result.nodes.count, b.zones,
               missing, off,
               other                  ? ": grown"
               : ended && missing > 0 ? ": ended at a fold"
               : right                ? ""
                                      : ": WRONG");
        wrong += !right;
        drape_end(&whole);
        arena_free(arena);
    }
    return wrong;
}

/* A cell just beyond a crease has no D by chords, which lead back and forth over it; and a joint
 * goes on beyond its end where the continuations of its faces cross. */
static void test_exact_reflected_zones(void **state) {
    (void)state;
    assert_int_equal(check_rounds(SEED, 24, 6, is_wrong), 0);
    check_at_most(ended_early, 3); /* one part by three methods */
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_exact_reflected_zones)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
