/* SPDX-License-Identifier: MIT */
#include "cut_search.h"

#include "score.h"

#include "api/result/fields.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* The first step is this share of the mean length of the cuts, and the last so many spacings. */
static const double first_step = 0.25, last_step = 0.25;

/* Of equally long cuts those with less shear are better: this share of the length for all that the
 * limit allows. So a step aside that helps is taken, and the cut can be shorter then. */
static const double shear_weight = 0.05;

/* A gain of less than this share of a step in length, or of what limits are missed by, is none. */
static const double worth = 0.05;

/* A net that breaks the limits so near, in spacings, to a cut that it has asks for a longer one. */
static const double near_cut = 4;

enum { GROWTHS_MOST = 12, MOVES = 7 };

/* Cuts to be tried together. */
struct trial {
    struct study_cut cut[API_STUDY_CUTS];
    size_t count;
};

/* Where a search is, after some of its rounds. */
enum search_phase {
    SEARCH_GROWS, /* the cuts that the last net asks for are added */
    SEARCH_MOVES, /* each cut is moved alone */
    SEARCH_JOINS, /* what was better of each is tried together */
    SEARCH_ENDS
};
struct cut_search {
    const struct api_study *study;
    enum search_phase phase;
    int round;
    double step;
    bool whole;                     /* whether cuts are to be left out, too */
    const struct study_row *best;   /* of all */
    const struct study_row *centre; /* from which cuts are moved */
    const struct study_row *last;   /* round */
    size_t last_count;
    struct trial grown[MOUTHS];        /* what is tried next while it grows, .. */
    enum proposal_mouth mouth[MOUTHS]; /* .. and where each has its mouths */
    size_t grown_count;
};

static double spacing_of(const struct api_study *study) {
    const double *d = study->request.drape.settings.spacing;
    return fmax(d[0], d[1]);
}

static double cut_length_of(const struct study_cut *cuts, size_t count) {
    double length = 0;
    for (size_t k = 0; k < count; k++)
        length += vec3_distance(cuts[k].mouth, cuts[k].tip);
    return length;
}

static double length_of_row(const struct study_row *row) {
    return cut_length_of(row->variant.cuts, row->variant.cut_count);
}

static double cost_of(const struct api_study *study, const struct study_row *row) {
    double allowed = study->request.limit[QUANTITY_MAX_SHEAR].max;
    return length_of_row(row) * (1 + shear_weight * row->quantity[QUANTITY_MAX_SHEAR] / allowed);
}

/* Whether a row is better than another, which may be NULL, by more than a share of what that misses
 * the limits by, or if it keeps them of `step` in length. */
static bool is_better(const struct api_study *study, const struct study_row *a,
                      const struct study_row *b, double share, double step) {
    double x = study_violation(study, a), y = b ? study_violation(study, b) : HUGE_VAL;
    if (x > 0 || y > 0 || !b)
        return !b || x < y * (1 - share);
    return cost_of(study, a) < cost_of(study, b) - share * step;
}

/* ---- growing ---- */

/* From a place to a cut along the part, which is straight from one place to the next. */
static double distance_to_cut(const struct api_study *study, const struct study_cut *cut,
                              struct vec3 r) {
    size_t steps = 1 + (size_t)(vec3_distance(cut->mouth, cut->tip) / spacing_of(study));
    struct vec3 from = cut->mouth;
    double least = HUGE_VAL;
    for (size_t k = 1; k <= steps; k++) {
        struct vec3 to = proposal_place(&study->part, cut, (double)k / (double)steps);
        const struct proposal_edge piece = {1, &from, &to};
        least = fmin(least, vec3_distance(r, proposal_edge_nearest(&piece, r)));
        from = to;
    }
    return least;
}

/* The cuts of a row with those along its ridges; false where that is nothing new. */
static bool grow(const struct cut_search *s, const struct study_row *row, enum proposal_mouth mouth,
                 struct trial *trial) {
    const struct api_study *study = s->study;
    double spacing = spacing_of(study);
    bool grown = false;
    trial->count = row->variant.cut_count;
    if (trial->count)
        memcpy(trial->cut, row->variant.cuts, trial->count * sizeof *trial->cut);
    for (size_t k = 0; k < row->ridge_count; k++) {
        const struct study_ridge *own = &row->ridges[k];
        struct study_cut *known = NULL;
        for (size_t n = 0; n < row->variant.cut_count; n++)
            if (distance_to_cut(study, &trial->cut[n], own->inner) < near_cut * spacing ||
                distance_to_cut(study, &trial->cut[n], own->outer) < near_cut * spacing)
                known = &trial->cut[n];
        if (known) { /* to the end of the ridge, and at least two spacings further */
            double length = vec3_distance(known->mouth, known->tip);
            if (vec3_distance(known->mouth, own->inner) > length + spacing)
                known->tip = own->inner;
            else
                known->tip = proposal_place(&study->part, known, 1 + 2 * spacing / length);
            grown = true;
        } else if (trial->count < study->request.splits) {
            trial->cut[trial->count++] =
                proposal_cut(&study->part, &study->edge, spacing, own, mouth);
            grown = true;
        }
    }
    return grown && study_violation(study, row) > 0;
}

/* Whether all cuts of two trials have their ends within a spacing. */
static bool same_trial(const struct trial *a, const struct trial *b, double spacing) {
    bool same = a->count == b->count;
    for (size_t k = 0; k < a->count && same; k++)
        same = vec3_distance(a->cut[k].mouth, b->cut[k].mouth) < spacing &&
               vec3_distance(a->cut[k].tip, b->cut[k].tip) < spacing;
    return same;
}

/* What the nets of a round ask for, as long as it is shorter than what keeps the limits already: of
 * the first, without cuts, by both kinds of mouths. */
static void grow_all(struct cut_search *s, const struct study_row *rows, size_t count) {
    const enum proposal_mouth kinds[MOUTHS] = {s->mouth[0], s->mouth[1]};
    bool first = s->round == 1;
    s->grown_count = 0;
    for (size_t k = 0; k < (first ? MOUTHS : count); k++) {
        struct trial *trial = &s->grown[s->grown_count];
        enum proposal_mouth mouth = first ? (enum proposal_mouth)k : kinds[k];
        if (!grow(s, &rows[first ? 0 : k], mouth, trial) ||
            (study_violation(s->study, s->best) == 0 &&
             cut_length_of(trial->cut, trial->count) > length_of_row(s->best)) ||
            (s->grown_count && same_trial(trial, s->grown, spacing_of(s->study))))
            continue;
        s->mouth[s->grown_count++] = mouth;
    }
}

/* ---- moving ---- */

/* Unit, across the cut at one of its ends, along the part. */
static struct vec3 across_cut(const struct study_part *part, const struct study_cut *cut,
                              struct vec3 end) {
    struct part_point at;
    struct vec3 normal, along;
    double distance;
    study_part_nearest(part, end, &at, &distance);
    (void)study_part_axes(part, &at, &normal, &along);
    return vec3_unit(vec3_cross(normal, vec3_sub(cut->tip, cut->mouth)));
}

/* Move number `move` of a cut: shorter or, to keep limits that are broken, longer; the tip to one
 * side and the other; the mouth likewise, along the edge. */
static struct study_cut move_cut(const struct cut_search *s, const struct study_cut *cut, int move,
                                 bool longer) {
    const struct study_part *part = &s->study->part;
    struct study_cut moved = *cut;
    double length = vec3_distance(cut->mouth, cut->tip), distance;
    double side = move % 2 ? s->step : -s->step;
    struct part_point nearest;
    if (move == 0) {
        moved.tip = proposal_place(part, cut, 1 + (longer ? 1 : -1) * s->step / length);
    } else if (move <= 2) {
        study_part_nearest(part, vec3_axpy(side, across_cut(part, cut, cut->tip), cut->tip),
                           &nearest, &distance);
        moved.tip = nearest.r;
    } else {
        struct vec3 aside = vec3_axpy(side, across_cut(part, cut, cut->mouth), cut->mouth);
        moved.mouth = proposal_edge_nearest(&s->study->edge, aside);
    }
    return moved;
}

/* All trials round the centre. */
static size_t move_all(const struct cut_search *s, struct trial *trials) {
    const struct study_variant *centre = &s->centre->variant;
    double least = 2 * spacing_of(s->study);
    bool broken = study_violation(s->study, s->centre) > 0;
    struct trial own = {.count = centre->cut_count};
    size_t made = 0;
    if (own.count)
        memcpy(own.cut, centre->cuts, own.count * sizeof *own.cut);
    for (size_t k = 0; k < own.count; k++) {
        for (int move = 0; move < MOVES - 2; move++) {
            struct study_cut moved = move_cut(s, &own.cut[k], move, broken);
            if (!(vec3_distance(moved.mouth, moved.tip) > least))
                continue;
            trials[made] = own;
            trials[made++].cut[k] = moved;
        }
        if (!s->whole)
            continue;
        trials[made] = own; /* without it */
        trials[made].cut[k] = own.cut[own.count - 1];
        trials[made++].count--;
    }
    return made;
}

static bool same_cut(const struct study_cut *a, const struct study_cut *b) {
    return vec3_distance(a->mouth, b->mouth) == 0 && vec3_distance(a->tip, b->tip) == 0;
}

/* Of each cut what was best of it alone in the last round, if that was better than the centre;
 * false unless two are. */
static bool join_moves(const struct cut_search *s, struct trial *trial) {
    const struct study_variant *centre = &s->centre->variant;
    size_t joined = 0;
    trial->count = centre->cut_count;
    if (trial->count)
        memcpy(trial->cut, centre->cuts, trial->count * sizeof *trial->cut);
    for (size_t k = 0; k < trial->count; k++) {
        const struct study_row *best = s->centre;
        for (size_t n = 0; n < s->last_count; n++) {
            const struct study_row *row = &s->last[n];
            if (row->variant.cut_count == trial->count &&
                !same_cut(&row->variant.cuts[k], &centre->cuts[k]) &&
                is_better(s->study, row, best, 0, 0))
                best = row;
        }
        joined += best != s->centre;
        trial->cut[k] = best->variant.cuts[k];
    }
    return joined > 1;
}

/* ---- rounds ---- */

/* From here on cuts are moved. */
static void begin_moves(struct cut_search *s) {
    s->centre = s->best;
    s->phase = s->best->variant.cut_count ? SEARCH_MOVES : SEARCH_ENDS;
    s->step =
        fmax(first_step * length_of_row(s->best) / fmax((double)s->best->variant.cut_count, 1),
             last_step * spacing_of(s->study));
    s->whole = s->best->variant.cut_count > 1;
}

/* After moves from a centre: on from the best, with half the step if that is still the centre. */
static void settle(struct cut_search *s) {
    bool fewer = s->best->variant.cut_count < s->centre->variant.cut_count;
    bool gained = s->best != s->centre && is_better(s->study, s->best, s->centre, worth, s->step);
    s->whole = fewer && s->best->variant.cut_count > 1;
    s->centre = s->best;
    s->step *= gained ? 1 : 0.5;
    s->phase = s->step < last_step * spacing_of(s->study) ? SEARCH_ENDS : SEARCH_MOVES;
}

/* Takes the rows of one round. */
static void take_round(struct cut_search *s, const struct study_row *rows, size_t count) {
    struct trial trial;
    for (size_t k = 0; k < count; k++)
        if (is_better(s->study, &rows[k], s->best, 0, 0))
            s->best = &rows[k];
    s->last = rows;
    s->last_count = count;
    s->round++;
    if (s->phase == SEARCH_GROWS)
        grow_all(s, rows, count);
    if (s->phase == SEARCH_GROWS && (s->round > GROWTHS_MOST || s->grown_count == 0))
        begin_moves(s);
    else if (s->phase == SEARCH_MOVES && join_moves(s, &trial))
        s->phase = SEARCH_JOINS;
    else if (s->phase != SEARCH_GROWS)
        settle(s);
}

/* The trials of the next round; room for each of them moved. */
static size_t next_trials(const struct cut_search *s, struct trial *trials) {
    if (!s->last) {
        trials->count = 0;
        return 1;
    }
    if (s->phase == SEARCH_MOVES)
        return move_all(s, trials);
    if (s->phase == SEARCH_GROWS)
        memcpy(trials, s->grown, s->grown_count * sizeof *trials);
    return s->phase == SEARCH_ENDS    ? 0
           : s->phase == SEARCH_GROWS ? s->grown_count
                                      : (size_t)join_moves(s, trials);
}

enum api_problem_id cut_search_plan(const struct api_study *study, const struct study_row *rows,
                                    size_t count, struct arena *arena, struct api_study_plan *plan,
                                    struct api_problem *problem) {
    struct cut_search s = {.study = study, .phase = SEARCH_GROWS};
    struct trial *trials = arena_alloc(arena, API_STUDY_CUTS * MOVES, sizeof *trials);
    struct api_study_task *list = arena_alloc(arena, API_STUDY_CUTS * MOVES, sizeof *list);
    if (!trials || !list)
        return api_problem_no_memory(problem, "the study");
    for (size_t k = 0, next; k < count; k = next) {
        for (next = k + 1; next < count && rows[next].round == rows[k].round; next++)
            ;
        take_round(&s, rows + k, next - k);
    }
    size_t budget = study->request.budget - count, made = next_trials(&s, trials);
    made = made < budget ? made : budget;
    for (size_t k = 0; k < made; k++) {
        list[k] = (struct api_study_task){.kind = STUDY_TASK_CUTS,
                                          .variants = 1,
                                          .round = s.round,
                                          .first = (int64_t)trials[k].count,
                                          .coarseness = 1};
        memcpy(list[k].cuts, trials[k].cut, trials[k].count * sizeof *trials[k].cut);
    }
    plan->tasks = list;
    plan->count = made;
    plan->variants = count + made;
    for (double step = s.step; s.phase != SEARCH_ENDS && step > last_step * spacing_of(study);
         step /= 2) /* two more rounds a step, about */
        plan->variants += 2 * made;
    plan->variants =
        made ? (size_t)fmin((double)plan->variants, (double)study->request.budget) : count;
    return API_OK;
}

/* ---- variants ---- */

enum status cut_search_prepare(struct api_study *study) {
    const struct drape_settings *settings = &study->request.drape.settings;
    struct drape_result *result = arena_alloc(study->arena, 1, sizeof *result);
    if (!result)
        return STATUS_OUT_OF_MEMORY;
    enum status status = drape_solve(&study->part.geometry, settings, NULL, study->arena, result);
    if (status == STATUS_OK)
        status = proposal_edge_make(&result->rim, study->arena, &study->edge);
    return status == STATUS_OUT_OF_MEMORY ? status : STATUS_OK;
}

enum status cut_search_lay(const struct api_study *study, const struct study_cut *cuts,
                           size_t count, struct arena *arena, struct study_variant *variant) {
    const struct drape_settings *own = &study->request.drape.settings;
    const double *d = own->spacing;
    struct drape_cut_line *lines = arena_alloc(arena, own->cut_count + count + 1, sizeof *lines);
    if (!lines)
        return STATUS_OUT_OF_MEMORY;
    if (own->cut_count)
        memcpy(lines, own->cuts, own->cut_count * sizeof *lines);
    for (size_t k = 0; k < count; k++)
        if (proposal_line(&study->part, &cuts[k], fmin(d[0], d[1]), arena,
                          &lines[own->cut_count + k]) != STATUS_OK)
            return STATUS_OUT_OF_MEMORY;
    variant->cuts = cuts;
    variant->cut_count = count;
    variant->lines = lines;
    return STATUS_OK;
}

/* ---- the table `proposed` ---- */

/* Its columns: the variant, the number of the cut from 1, and the ends. */
enum { PLACES = 6 };

size_t cut_search_columns(const struct study_row *rows, size_t count, struct arena *arena,
                          struct api_column_source *sources) {
    size_t all = 0;
    for (size_t k = 0; k < count; k++)
        all += rows[k].variant.cut_count;
    double *values[2 + PLACES];
    if (!api_fields_columns(COLUMN_PROPOSED_variant, 2 + PLACES, all, arena, values, sources))
        return SIZE_MAX;
    for (size_t k = 0, row = 0; k < count; k++)
        for (size_t n = 0; n < rows[k].variant.cut_count; n++, row++) {
            const struct study_cut *cut = &rows[k].variant.cuts[n];
            values[0][row] = (double)k;
            values[1][row] = (double)(n + 1);
            vec3_to_columns(cut->mouth, values[2], values[3], values[4], row);
            vec3_to_columns(cut->tip, values[5], values[6], values[7], row);
        }
    return 2 + PLACES;
}

enum api_problem_id cut_search_read(const struct api_study *study, const struct api_reader *result,
                                    const struct api_columns *columns, size_t k,
                                    struct arena *arena, struct study_variant *variant,
                                    struct api_problem *problem) {
    size_t rows = api_columns_rows(columns, API_TABLE_PROPOSED), count = 0;
    struct study_cut *cuts = arena_alloc(arena, API_STUDY_CUTS, sizeof *cuts);
    if (!cuts)
        return api_problem_no_memory(problem, "the study");
    for (size_t row = 0; row < rows && count < API_STUDY_CUTS; row++) {
        double value[2 + PLACES];
        if (!api_fields_read_row(result, columns, COLUMN_PROPOSED_variant, 2 + PLACES, row, value))
            return api_problem_set(problem, API_INTERNAL, "the stored result is damaged");
        if (value[0] == (double)k)
            cuts[count++] = (struct study_cut){vec3_make(value[2], value[3], value[4]),
                                               vec3_make(value[5], value[6], value[7])};
    }
    if (cut_search_lay(study, cuts, count, arena, variant) != STATUS_OK)
        return api_problem_no_memory(problem, "the study");
    return API_OK;
}

enum api_problem_id cut_search_name(const struct api_study *study,
                                    const struct study_variant *variant, struct arena *arena,
                                    struct api_request *request, struct api_problem *problem) {
    const struct api_request *drape = &study->request.drape;
    size_t own = drape->settings.cut_count, all = own + variant->cut_count;
    char(*names)[API_CUT_NAME_MAX + 1] = arena_alloc(arena, all + 1, sizeof *names);
    double *allowances = arena_alloc(arena, all + 1, sizeof *allowances);
    if (!names || !allowances)
        return api_problem_no_memory(problem, "the study");
    for (size_t k = 0; k < all; k++) {
        if (k >= own)
            (void)snprintf(names[k], sizeof names[k], "proposed_%zu", k - own + 1);
        else
            memcpy(names[k], drape->cut_names[k], sizeof names[k]);
        allowances[k] = k < own ? drape->cut_allowances[k] : 0;
    }
    request->cut_names = (const char(*)[API_CUT_NAME_MAX + 1]) names;
    request->cut_allowances = allowances;
    return API_OK;
}
