/* SPDX-License-Identifier: MIT */
/*
 * A layer of courses on the blade-like mould, searched for the least shear, the least cloth that is
 * trimmed off, and the least angle between warp and the blade's axis, one after the other: what
 * KinDrapeMAX has published of the same mould beside it (docs/validation.md).
 *
 *     blade SURFACE.json
 */
#include "api/limits.h"
#include "api/request/decode.h"
#include "api/request/prepared_form.h"
#include "api/run.h"
#include "solver/courses.h"
#include "solver/surface/surface.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

/* What may be chosen: the first course's offset at FIRST places, GAPS values of the gap to each
 * next course, where each course's weft generator lies, the width of each. */
enum { COURSES = 5, FIRST = 5, GAPS = 3, UNKNOWNS = FIRST + (COURSES - 1) * GAPS + 2 * COURSES };
enum { WORKERS = 2, SAMPLES = 10, PARENTS = 5 };

static const double spacing_checked = 0.0125; /* m */

/* A search: its spacing, the share of the part that is to lie under cloth or in gaps between
 * courses, as far as such nets tell, the first step in shares of the ranges, and how many layers.
 */
static const struct phase {
    double spacing, whole, step;
    int evaluations;
} phases[] = {{0.05, 0.996, 0.15, 130}, {0.025, 0.9988, 0.05, 60}};
enum { PHASES = sizeof phases / sizeof *phases };

enum goal { SHEAR, TRIM, DIRECTION, GOALS };

/* The range of each kind of unknown, and where the search for a goal begins; lengths in m. Without
 * trimming the first course follows the edge, and courses overlap where the part is narrow. */
struct range {
    double least, most, begin[GOALS];
};
static const struct range range_first = {-0.2, 0.05, {-0.1, 0, 0}},
                          range_gap_ends = {-0.07, 0.012, {0, 0, 0}},
                          range_gap = {-0.07, 0.012, {-0.02, -0.05, -0.02}},
                          range_origin = {0, 1, {0.5, 0.5, 0.5}},
                          range_width = {0.3, 0.45, {0.35, 0.335, 0.35}};

static const struct {
    const char *name, *unit;
    double theirs, seconds;
} goals[GOALS] = {{"greatest shear", "degrees", 2.70, 1039},
                  {"area trimmed off", "m^2", 0.101, 932},
                  {"warp from the axis", "degrees", 12.3, 976}};

struct layer {
    struct drape_part part;
    double part_area;
    struct arena *arena;
};

/* A layer as the unknowns have it. */
struct plan {
    double first[FIRST], gap[COURSES - 1][GAPS], origin[COURSES], width[COURSES];
    struct courses_offset gaps[COURSES - 1];
    struct courses_settings settings;
};

static void plan_make(struct plan *plan, const double x[UNKNOWNS], double spacing) {
    size_t k = 0;
    for (size_t n = 0; n < FIRST; n++)
        plan->first[n] = x[k++];
    for (size_t c = 0; c + 1 < COURSES; c++) {
        plan->gaps[c] = (struct courses_offset){plan->gap[c], GAPS};
        for (size_t n = 0; n < GAPS; n++)
            plan->gap[c][n] = x[k++];
    }
    for (size_t c = 0; c < COURSES; c++)
        plan->origin[c] = x[k++];
    for (size_t c = 0; c < COURSES; c++)
        plan->width[c] = x[k++];
    plan->settings = (struct courses_settings){
        .drape = {.method = DRAPE_GIB, .spacing = {spacing, spacing}, .max_nodes = 1000000},
        .along = COURSES_ALONG_EDGE,
        .edge = {0.6801, 2.0000, -0.7458},
        .widths = plan->width,
        .width_count = COURSES,
        .first = {plan->first, FIRST},
        .gaps = plan->gaps,
        .gap_count = COURSES - 1,
        .origins = plan->origin,
        .origin_count = COURSES,
        .most = COURSES,
        .wanted = {0, 1, 0}};
}

static bool evaluate(const struct layer *layer, const double x[UNKNOWNS], double spacing,
                     struct courses_result *result) {
    struct plan plan;
    plan_make(&plan, x, spacing);
    return courses_lay(&layer->part, &plan.settings, NULL, layer->arena, result) == STATUS_OK;
}

static bool open_layer(const char *path, struct layer *layer) {
    static const char fabric[] = ", \"fabric\": {\"spacing\": 0.05}}";
    enum { BYTES_MOST = 1 << 20 };
    static char text[BYTES_MOST + sizeof fabric];
    static struct api_request request;
    static struct prepared_part part;
    struct api_problem problem = {0};
    FILE *file = fopen(path, "rb");
    size_t length = file ? fread(text, 1, BYTES_MOST, file) : 0;
    if (file)
        fclose(file);
    while (length > 0 && text[length - 1] != '}')
        length--;
    if (length == 0)
        return false;
    memcpy(text + length - 1, fabric, sizeof fabric);
    struct api_input input = {.request = text, .request_length = strlen(text)};
    layer->arena = arena_new((size_t)2 << 30);
    bool opened =
        layer->arena && api_prepare() &&
        api_decode(&input, &api_limits_default, layer->arena, &request, &problem) == API_OK &&
        prepared_part_make(&request, &api_limits_default, layer->arena, &part, &problem) == API_OK;
    layer->part = part.part;
    layer->part_area = opened ? surface_area(part.part.surface, NULL) : 0;
    return opened;
}

/* What is to be small: the goal, and beyond what may be bare a penalty that outweighs it. */
static double cost(const struct courses_result *r, double part_area, double whole, enum goal goal) {
    double bare = whole - (r->cloth_coverage + r->gap_area / part_area);
    double value = goal == SHEAR  ? r->max_shear_deg
                   : goal == TRIM ? r->trim_area
                                  : r->wanted_most_deg;
    return value + (bare > 0 ? (goal == TRIM ? 30 : 1000) * bare : 0);
}

static const struct range *range_of(size_t k) {
    const size_t gaps = FIRST, origins = gaps + (COURSES - 1) * GAPS, widths = origins + COURSES;
    if (k < gaps)
        return &range_first;
    if (k < origins)
        return (k - gaps) % GAPS % (GAPS - 1) ? &range_gap : &range_gap_ends;
    return k < widths ? &range_origin : &range_width;
}

/* Normally distributed, by the sum of twelve uniform numbers (splitmix64). */
static double normal(uint64_t *seed) {
    double sum = -6;
    for (int k = 0; k < 12; k++) {
        uint64_t z = *seed += 0x9e3779b97f4a7c15u;
        z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
        z = (z ^ z >> 27) * 0x94d049bb133111ebu;
        sum += (double)((z ^ z >> 31) >> 11) * 0x1p-53;
    }
    return sum;
}

struct candidate {
    double y[UNKNOWNS], x[UNKNOWNS], cost;
};

static int compare_candidates(const void *a, const void *b) {
    const struct candidate *p = a, *q = b;
    return (p->cost > q->cost) - (p->cost < q->cost);
}

/* The unknowns of a place of the unit cube, which is mirrored at its faces. */
static void to_unknowns(const double y[UNKNOWNS], double x[UNKNOWNS]) {
    for (size_t k = 0; k < UNKNOWNS; k++) {
        const struct range *range = range_of(k);
        double t = fabs(fmod(y[k], 2));
        t = t > 1 ? 2 - t : t;
        x[k] = range->least + t * (range->most - range->least);
    }
}

/* An evolution strategy with a step of its own for each unknown (separable CMA-ES: Ros and Hansen
 * 2008): normally distributed candidates, of which the better half moves the mean and the steps. */
struct strategy {
    double mean[UNKNOWNS], variance[UNKNOWNS], path[UNKNOWNS], walk[UNKNOWNS];
    double weight[PARENTS], mu, sigma;
    uint64_t seed;
};

static void strategy_begin(struct strategy *s, const double mean[UNKNOWNS], double step,
                           uint64_t seed) {
    double sum = 0, sum2 = 0;
    *s = (struct strategy){.sigma = step, .seed = seed};
    memcpy(s->mean, mean, sizeof s->mean);
    for (int k = 0; k < UNKNOWNS; k++)
        s->variance[k] = 1;
    for (int k = 0; k < PARENTS; k++)
        sum += s->weight[k] = log(PARENTS + 0.5) - log(k + 1.0);
    for (int k = 0; k < PARENTS; k++) {
        s->weight[k] /= sum;
        sum2 += s->weight[k] * s->weight[k];
    }
    s->mu = 1 / sum2;
}

/* By candidates, the best ones first. */
static void strategy_learn(struct strategy *s, const struct candidate *candidates) {
    const double n = UNKNOWNS, mu = s->mu, cs = (mu + 2) / (n + mu + 3), cc = 4 / (n + 4);
    const double expected = sqrt(n) * (1 - 1 / (4 * n) + 1 / (21 * n * n)), wide = n + sqrt(2);
    double rate =
        2 / (mu * wide * wide) + (1 - 1 / mu) * fmin(1, (2 * mu - 1) / ((n + 2) * (n + 2) + mu));
    double length2 = 0;
    rate *= (n + 2) / 3;
    for (int k = 0; k < UNKNOWNS; k++) {
        double next = 0, spread = 0;
        for (int c = 0; c < PARENTS; c++) {
            double away = (candidates[c].y[k] - s->mean[k]) / s->sigma;
            next += s->weight[c] * candidates[c].y[k];
            spread += s->weight[c] * away * away;
        }
        double step = (next - s->mean[k]) / s->sigma;
        s->walk[k] = (1 - cs) * s->walk[k] + sqrt(cs * (2 - cs) * mu) * step / sqrt(s->variance[k]);
        s->path[k] = (1 - cc) * s->path[k] + sqrt(cc * (2 - cc) * mu) * step;
        s->variance[k] = (1 - rate) * s->variance[k] + rate / mu * s->path[k] * s->path[k] +
                         rate * (1 - 1 / mu) * spread;
        s->mean[k] = next;
        length2 += s->walk[k] * s->walk[k];
    }
    s->sigma *= exp(cs / (1 + cs) * (sqrt(length2) / expected - 1));
}

/* A search from `best` on, which gets the best layer of those looked at. */
static void search(const struct layer *layer, enum goal goal, const struct phase *phase,
                   uint64_t seed, struct candidate *best) {
    struct candidate candidates[SAMPLES];
    struct strategy s;
    strategy_begin(&s, best->y, phase->step, seed);
    best->cost = HUGE_VAL;
    for (int done = 0; done < phase->evaluations; done += SAMPLES) {
        for (int c = 0; c < SAMPLES; c++) {
            struct courses_result result;
            struct arena_mark mark = arena_mark(layer->arena);
            double *y = candidates[c].y;
            for (int k = 0; k < UNKNOWNS; k++)
                y[k] = s.mean[k] +
                       (done + c > 0 ? s.sigma * sqrt(s.variance[k]) * normal(&s.seed) : 0);
            to_unknowns(y, candidates[c].x);
            bool laid = evaluate(layer, candidates[c].x, phase->spacing, &result);
            candidates[c].cost =
                laid ? cost(&result, layer->part_area, phase->whole, goal) : HUGE_VAL;
            arena_rewind(layer->arena, mark);
        }
        qsort(candidates, SAMPLES, sizeof *candidates, compare_candidates);
        if (candidates[0].cost < best->cost)
            *best = candidates[0];
        strategy_learn(&s, candidates);
    }
}

static double seconds_of(clockid_t clock) {
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* The workers' searches at the same time, each from a seed of its own; the best of both. */
static bool search_all(const struct layer *layer, enum goal goal, struct candidate *best,
                       double *processor) {
    struct shared {
        struct candidate best;
        double processor;
    } *shared = mmap(NULL, WORKERS * sizeof *shared, PROT_READ | PROT_WRITE,
                     MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (shared == MAP_FAILED)
        return false;
    for (int w = 0; w < WORKERS; w++) {
        pid_t child = fork();
        if (child == 0) {
            for (size_t k = 0; k < UNKNOWNS; k++) {
                const struct range *range = range_of(k);
                shared[w].best.y[k] =
                    (range->begin[goal] - range->least) / (range->most - range->least);
            }
            for (int p = 0; p < PHASES; p++)
                search(layer, goal, &phases[p], (uint64_t)w, &shared[w].best);
            shared[w].processor = seconds_of(CLOCK_PROCESS_CPUTIME_ID);
            _exit(0);
        }
    }
    while (wait(NULL) > 0)
        continue;
    *best = shared[0].best;
    *processor = 0;
    for (int w = 0; w < WORKERS; w++) {
        *best = shared[w].best.cost < best->cost ? shared[w].best : *best;
        *processor = fmax(*processor, shared[w].processor);
    }
    return munmap(shared, WORKERS * sizeof *shared) == 0;
}

int main(int argc, char **argv) {
    struct layer layer;
    if (argc != 2 || !open_layer(argv[1], &layer)) {
        fprintf(stderr, "usage: blade SURFACE.json\n");
        return 2;
    }
    printf("least                      KinDrapeMAX     here   seconds   seconds   covered   bare "
           "in gaps  "
           "overlaps\n");
    for (int goal = 0; goal < GOALS; goal++) {
        struct candidate best;
        struct courses_result r;
        double processor;
        struct arena_mark mark = arena_mark(layer.arena);
        if (!search_all(&layer, (enum goal)goal, &best, &processor) ||
            !evaluate(&layer, best.x, spacing_checked, &r))
            return 1;
        printf("%-18s %-8s %10.3f %8.3f %9.0f %9.1f %9.4f %10.4f m^2 %5.2f m^2\n", goals[goal].name,
               goals[goal].unit, goals[goal].theirs,
               goal == SHEAR  ? r.max_shear_deg
               : goal == TRIM ? r.trim_area
                              : r.wanted_most_deg,
               goals[goal].seconds, processor, r.cloth_coverage, r.gap_area, r.overlap_area);
        fflush(stdout);
        arena_rewind(layer.arena, mark);
    }
    arena_free(layer.arena);
    return 0;
}
