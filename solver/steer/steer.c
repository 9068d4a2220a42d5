/* SPDX-License-Identifier: MIT */
#include "steer.h"

#include "damped_step.h"
#include <string.h>

/* So many nodes are enough to look round by, and to find a generator by; a finer net is only laid.
 */
static const double nodes_rough = 600, nodes_enough = 3000;

/* Steps of one descent, steps refused one after the other, and descents from kicked values. */
enum { ITERATIONS_MAX = 30, REFUSED_MAX = 6, KICKS = 3 };

/* By so much a kick turns a generator, rad, over one of its sides. */
static const double kick_turn = 0.5;

/* Where the next step is to win no more than this share of the energy, or the mean shear is no more
 * than this angle, rad, the search ends. */
static const double share_enough = 3e-5, unsheared = 2e-4;

/* No value makes a generator turn by more than this, rad, within a spacing. */
static const double turn_most = 0.25;

static const double damping_first = 1e-3, damping_least = 1e-7;

static bool is_sought(const struct drape_generator *generator) {
    return generator->kind == DRAPE_GENERATOR_LEAST;
}

/* Whether its values stand on the sides of a geodesic, which are to be measured. */
static bool is_unmeasured(const struct drape_generator *generator) {
    bool steered = generator->kind == DRAPE_GENERATOR_STEERED || is_sought(generator);
    return steered && !(generator->curvature.length[0] > 0 && generator->curvature.length[1] > 0);
}

bool steer_seeks(const struct drape_settings *settings) {
    const struct drape_generator *generator = settings->generator;
    return is_sought(&generator[0]) || is_sought(&generator[1]) || is_unmeasured(&generator[0]) ||
           is_unmeasured(&generator[1]);
}

/* The fractions of part of a run as those of the whole: `from` to `to`. */
struct stage {
    const struct drape_monitor *monitor;
    double from, to;
};

static bool report_stage(void *context, double fraction) {
    const struct stage *stage = context;
    return !stage->monitor ||
           stage->monitor->progress(stage->monitor->context,
                                    stage->from + fraction * (stage->to - stage->from));
}

struct search {
    const struct steer_lay *lay;
    struct drape_settings settings; /* with the values that are best so far */
    struct stage stage;
    struct arena *arena;
    struct drape_statistics *statistics;
    double *density;           /* of all bins, of the energy of the settings */
    struct steer_slope *slope; /* of those values; its variation is gone */
    double energy;             /* of those, bending included */
    double most;               /* that a value may be */
    double area;               /* of the part */
    double cloth;              /* flat, on the part, of the first drape on this net; 0: none yet */
    int iterations;
};

/* ---- values ---- */

/* The values of all generators that are sought, in a row: out of the settings, or into them. */
static void copy_values(struct drape_settings *settings, const bool sought[2], double *values,
                        bool into) {
    for (int k = 0; k < 2; k++) {
        struct drape_curvature *curvature = &settings->generator[k].curvature;
        for (int n = 0; sought[k] && n < 2 * curvature->points; n++) {
            double *own = &curvature->value[n];
            *(into ? own : values) = *(into ? values : own);
            values++;
        }
    }
}

/* Makes geodesics of those that are sought. */
static void make_geodesics(struct drape_settings *settings, const bool sought[2]) {
    for (int k = 0; k < 2; k++)
        if (sought[k])
            settings->generator[k].kind = DRAPE_GENERATOR_GEODESIC;
}

/* How far a yarn through the start reaches on both sides, to the middle of the gap beyond. */
static void measure_sides(const struct drape_nodes *nodes, int k, double spacing,
                          double length[2]) {
    const int32_t *along = k ? nodes->j : nodes->i, *across = k ? nodes->i : nodes->j;
    int32_t most[2] = {0, 0};
    for (size_t n = 0; n < nodes->count; n++) {
        int side = along[n] > 0, reach = along[n] < 0 ? -along[n] : along[n];
        if (across[n] == 0 && reach > most[side])
            most[side] = reach;
    }
    for (int side = 0; side < 2; side++)
        if (!(length[side] > 0))
            length[side] = (most[side] + 0.5) * spacing;
}

/* ---- the search ---- */

/* The energy of a drape, by which it is compared. The part should be covered, or, by cloth whose
 * extent is given, as much cloth lie on it as with the first generators on the net. */
static double energy_of(struct search *s, const struct drape_result *result) {
    const struct drape_summary *summary = &result->summary;
    bool whole = !s->settings.has_extent[0] && !s->settings.has_extent[1];
    if (!(s->cloth > 0))
        s->cloth = summary->flat_area;
    double bare =
        whole ? (1 - summary->cloth_coverage) * summary->part_area : s->cloth - summary->flat_area;
    return steer_energy_of(s->density, s->statistics, bare);
}

/* The net of the search: of the same order or by chords, with no more nodes than are enough. */
static void coarsen(struct drape_settings *settings, double part_area, double enough) {
    double *d = settings->spacing, nodes = part_area / (d[0] * d[1]);
    double factor = nodes > enough ? sqrt(nodes / enough) : 1;
    settings->method =
        drape_method_traits[settings->method].yarn == DRAPE_YARN_CHORD ? DRAPE_BASIC : DRAPE_GIB;
    settings->yarn_path = DRAPE_PATH_CHORD;
    for (int k = 0; k < 2; k++) {
        settings->extent[k][0] = (int)floor(settings->extent[k][0] / factor);
        settings->extent[k][1] = (int)ceil(settings->extent[k][1] / factor);
        d[k] *= factor;
    }
}

/* A drape that is measured, and the energy of shear that it has to stay below. */
struct trial {
    struct search *search;
    double limit, energy;
};

static bool costs_less(void *context, const struct drape_result *result) {
    struct trial *trial = context;
    trial->energy = energy_of(trial->search, result);
    return trial->energy < trial->limit;
}

/* The energy of other settings, and, where it is below a limit, their slope; infinite where they
 * cannot be draped. */
static enum status try_values(struct search *s, const struct drape_settings *settings, double limit,
                              struct steer_slope *slope, double *energy) {
    struct arena_mark mark = arena_mark(s->arena);
    const struct drape_monitor monitor = {report_stage, &s->stage};
    struct trial trial = {s, limit, HUGE_VAL};
    struct drape_settings own = *settings;
    struct drape_result result;
    own.slope = slope;
    memcpy(slope->varied, s->slope->varied, sizeof slope->varied);
    slope->stiffness = s->slope->stiffness;
    slope->wanted = costs_less;
    slope->context = &trial;
    slope->bending = 0;
    enum status status = s->lay->lay(s->lay->context, &own, &monitor, s->arena, &result);
    *energy = status == STATUS_OK ? trial.energy + slope->bending : HUGE_VAL;
    arena_rewind(s->arena, mark);
    return status == STATUS_CANCELLED || status == STATUS_OUT_OF_MEMORY ? status : STATUS_OK;
}

/* From the best values: one step after the other, each damped the more the less well the model has
 * foretold the last. */
static enum status descend(struct search *s, struct steer_slope *next) {
    double values[STEER_PARAMETERS], step[STEER_PARAMETERS], damping = damping_first;
    int refused = 0, last = s->iterations + ITERATIONS_MAX;
    enum status status = STATUS_OK;
    copy_values(&s->settings, s->slope->varied, values, false);
    while (status == STATUS_OK && s->iterations < last && refused < REFUSED_MAX) {
        struct drape_settings moved = s->settings;
        double energy, fall = steer_damped_step(s->slope, values, s->most, damping, step);
        if (!(fall > share_enough * s->energy) || !(s->energy > unsheared * unsheared * s->area))
            return STATUS_OK;
        for (int n = 0; n < s->slope->variation.parameters; n++)
            step[n] += values[n];
        copy_values(&moved, s->slope->varied, step, true);
        s->iterations++;
        status = try_values(s, &moved, s->energy, next, &energy);
        double kept = status == STATUS_OK ? (s->energy - energy) / fall : 0;
        if (!(kept > 0)) {
            damping *= 8;
            refused++;
            continue;
        }
        damping = fmax(damping_least, damping * (kept > 0.75 ? 0.2 : kept > 0.25 ? 1 : 4));
        refused = 0;
        s->settings = moved;
        s->energy = energy;
        *s->slope = *next;
        memcpy(values, step, sizeof values);
    }
    return status;
}

/* From here on the energy is that of the norm p. */
static void set_norm(struct search *s, double p) {
    s->settings.energy.norm = p;
    steer_densities(&s->settings.energy, s->density);
    s->slope->stiffness = steer_bending(&s->settings.energy, s->area);
}

/* A high norm is hard to descend by, flat where shear is small: the work itself first, then twice
 * the norm again and again. */
static enum status raise_norm(struct search *s, struct steer_slope *next) {
    double norm = s->settings.energy.norm;
    enum status status = STATUS_OK;
    for (double p = 2; p < norm && status == STATUS_OK; p *= 2) {
        set_norm(s, p);
        status = try_values(s, &s->settings, HUGE_VAL, s->slope, &s->energy);
        if (status == STATUS_OK)
            status = descend(s, next);
    }
    set_norm(s, norm);
    if (status == STATUS_OK)
        status = try_values(s, &s->settings, HUGE_VAL, s->slope, &s->energy);
    return status == STATUS_OK ? descend(s, next) : status;
}

/* Begins on a net of `enough` nodes with the values at hand. */
static enum status begin_on(struct search *s, const struct drape_settings *asked, double enough) {
    struct drape_generator generator[2];
    memcpy(generator, s->settings.generator, sizeof generator);
    s->settings = *asked;
    memcpy(s->settings.generator, generator, sizeof generator);
    coarsen(&s->settings, s->area, enough);
    return try_values(s, &s->settings, HUGE_VAL, s->slope, &s->energy);
}

/* Numbers that have nothing to do with each other, -1..1: the golden ratio's multiples. */
static double kick_number(int n) {
    double at = n * 0.6180339887498949;
    return 2 * (at - floor(at)) - 1;
}

/* Descends from the best values turned aside, too: where a part is symmetric the slope is 0 at its
 * geodesics, which then need not be a minimum, and roughness of the rim may end a descent early. */
static enum status look_round(struct search *s, struct steer_slope *next) {
    enum status status = STATUS_OK;
    for (int kick = 0; kick < KICKS && status == STATUS_OK; kick++) {
        const struct drape_settings best = s->settings;
        double energy = s->energy, values[STEER_PARAMETERS];
        if (!(energy > unsheared * unsheared * s->area))
            return STATUS_OK;
        for (int k = 0, n = 0; k < 2; k++) {
            struct drape_curvature *curvature = &s->settings.generator[k].curvature;
            double length = (curvature->length[0] + curvature->length[1]) / 2;
            for (int m = 0; s->slope->varied[k] && m < 2 * curvature->points; m++, n++) {
                values[n] = curvature->value[m] +
                            kick_turn / length * kick_number(kick * STEER_PARAMETERS + n + 1);
                values[n] = fmin(fmax(values[n], -s->most), s->most);
            }
        }
        copy_values(&s->settings, s->slope->varied, values, true);
        status = try_values(s, &s->settings, HUGE_VAL, s->slope, &s->energy);
        if (status == STATUS_OK)
            status = descend(s, next);
        if (!(s->energy < energy)) {
            s->settings = best;
            s->energy = energy;
        }
    }
    return status;
}

/* Ends on a finer net, from what was found on the rough one or, where that does not resolve the
 * part, as fillets, and geodesics are better, from these. */
static enum status end_on_finer_net(struct search *s, const struct drape_settings *asked,
                                    struct steer_slope *next) {
    struct search straight = *s;
    struct steer_slope *slope = arena_alloc(s->arena, 1, sizeof *slope);
    if (!slope)
        return STATUS_OUT_OF_MEMORY;
    *slope = *s->slope;
    straight.slope = slope;
    for (int k = 0; k < 2; k++)
        if (slope->varied[k])
            memset(straight.settings.generator[k].curvature.value, 0,
                   sizeof straight.settings.generator[k].curvature.value);
    straight.cloth = 0;
    enum status status = begin_on(&straight, asked, nodes_enough);
    s->cloth = straight.cloth;
    if (status == STATUS_OK)
        status = begin_on(s, asked, nodes_enough);
    if (straight.energy < s->energy) {
        s->settings = straight.settings;
        s->energy = straight.energy;
        *s->slope = *slope;
    }
    return status == STATUS_OK ? descend(s, next) : status;
}

/* Lays the geodesics once for what is to be known beforehand, then searches from the values given,
 * first on a rough net. The result has what is at fault, if there is something. */
static enum status search_from(struct search *s, const struct drape_settings *asked,
                               struct drape_result *result) {
    struct steer_slope *next = arena_alloc(s->arena, 1, sizeof *next);
    struct arena_mark mark = arena_mark(s->arena);
    const struct drape_monitor monitor = {report_stage, &s->stage};
    if (!next)
        return STATUS_OUT_OF_MEMORY;
    struct drape_settings straight = s->settings;
    for (int k = 0; k < 2; k++)
        if (s->slope->varied[k] || is_unmeasured(&straight.generator[k]))
            straight.generator[k].kind = DRAPE_GENERATOR_GEODESIC;
    enum status status = s->lay->lay(s->lay->context, &straight, &monitor, s->arena, result);
    if (status != STATUS_OK)
        return status;
    const double *d = s->settings.spacing;
    for (int k = 0; k < 2; k++)
        if (s->slope->varied[k] || is_unmeasured(&s->settings.generator[k])) {
            s->settings.generator[k].kind = DRAPE_GENERATOR_STEERED;
            measure_sides(&result->nodes, k, d[k], s->settings.generator[k].curvature.length);
        }
    s->area = result->summary.part_area;
    s->slope->stiffness = steer_bending(&s->settings.energy, s->area);
    arena_rewind(s->arena, mark);
    if (!s->slope->varied[0] && !s->slope->varied[1])
        return STATUS_OK;
    s->most = turn_most / fmax(d[0], d[1]);
    if (s->settings.energy.min_radius > 0)
        s->most = fmin(s->most, 1 / s->settings.energy.min_radius);
    struct drape_settings own = *asked;
    own.statistics = s->statistics;
    status = begin_on(s, &own, nodes_rough);
    if (status == STATUS_OK)
        status = raise_norm(s, next);
    if (status == STATUS_OK)
        status = look_round(s, next);
    return status == STATUS_OK ? end_on_finer_net(s, &own, next) : status;
}

/* Lays the drape as it was asked for with the generators found, or straight ones; its energy. */
static enum status lay_found(struct search *s, const struct drape_settings *settings, bool straight,
                             struct drape_result *result, double *energy) {
    const struct drape_monitor monitor = {report_stage, &s->stage};
    struct drape_settings own = *settings;
    own.statistics = s->statistics;
    memcpy(own.generator, s->settings.generator, sizeof own.generator);
    if (straight)
        make_geodesics(&own, s->slope->varied);
    enum status status = s->lay->lay(s->lay->context, &own, &monitor, s->arena, result);
    *energy = status == STATUS_OK ? energy_of(s, result) : HUGE_VAL;
    return status;
}

enum status steer_solve(const struct steer_lay *lay, const struct drape_settings *settings,
                        const struct drape_monitor *monitor, struct arena *arena,
                        struct drape_result *result) {
    struct search s = {.lay = lay,
                       .settings = *settings,
                       .stage = {monitor, 0, 0.5},
                       .arena = arena,
                       .statistics = settings->statistics,
                       .density = arena_take(arena, DRAPE_SHEAR_BINS, sizeof *s.density),
                       .slope = arena_alloc(arena, 1, sizeof *s.slope)};
    if (!s.statistics)
        s.statistics = arena_alloc(arena, 1, sizeof *s.statistics);
    if (!s.statistics || !s.density || !s.slope)
        return STATUS_OUT_OF_MEMORY;
    steer_densities(&settings->energy, s.density);
    s.settings.statistics = s.statistics;
    for (int k = 0; k < 2; k++)
        s.slope->varied[k] = settings->generator[k].kind == DRAPE_GENERATOR_LEAST;
    enum status status = search_from(&s, settings, result);
    if (status != STATUS_OK)
        return status;
    if (!s.slope->varied[0] && !s.slope->varied[1]) {
        s.settings.statistics = settings->statistics;
        return lay->lay(lay->context, &s.settings, monitor, arena, result);
    }
    struct drape_steering found = {.iterations = s.iterations};
    struct arena_mark mark = arena_mark(arena);
    s.stage = (struct stage){monitor, 0.5, 0.75};
    s.cloth = 0;
    status = lay_found(&s, settings, true, result, &found.energy[0]);
    if (status != STATUS_OK)
        return status;
    bool straight = true;
    for (int k = 0; k < 2; k++)
        straight = straight &&
                   (!s.slope->varied[k] || curvature_is_none(&s.settings.generator[k].curvature));
    found.energy[1] = found.energy[0];
    s.stage = (struct stage){monitor, 0.75, 1};
    if (!straight) {
        arena_rewind(arena, mark);
        status = lay_found(&s, settings, false, result, &found.energy[1]);
        found.fell = status == STATUS_OK && found.energy[1] < found.energy[0];
        if (status == STATUS_CANCELLED || status == STATUS_OUT_OF_MEMORY)
            return status;
        if (!found.fell) {
            arena_rewind(arena, mark);
            status = lay_found(&s, settings, true, result, &found.energy[1]);
        }
    }
    for (int k = 0; k < 2; k++) {
        found.sought[k] = s.slope->varied[k];
        found.curvature[k] = s.settings.generator[k].curvature;
        if (!found.fell)
            memset(found.curvature[k].value, 0, sizeof found.curvature[k].value);
    }
    result->steering = found;
    return status;
}
