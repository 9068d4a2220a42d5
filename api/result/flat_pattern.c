/* SPDX-License-Identifier: MIT */
#include "flat_pattern.h"

#include "outline.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LIP_NOTCHES = 3 };

/* The rim as it is stored; `cut` is all 0 without cuts. */
struct rim_columns {
    double *loop, *p, *q, *covered, *cut, *r[3];
    size_t count;
};

/* The point behind another in its loop. */
static size_t rim_next(const struct rim_columns *rim, size_t k) {
    size_t first = k;
    if (k + 1 < rim->count && rim->loop[k + 1] == rim->loop[k])
        return k + 1;
    while (first > 0 && rim->loop[first - 1] == rim->loop[k])
        first--;
    return first;
}

/* The point before another in its loop. */
static size_t rim_before(const struct rim_columns *rim, size_t k) {
    if (k > 0 && rim->loop[k - 1] == rim->loop[k])
        return k - 1;
    while (k + 1 < rim->count && rim->loop[k + 1] == rim->loop[k])
        k++;
    return k;
}

/* How far the next one is on the part. */
static double rim_step(const struct rim_columns *rim, size_t k) {
    double sum = 0;
    size_t next = rim_next(rim, k);
    for (int c = 0; c < 3; c++)
        sum += (rim->r[c][next] - rim->r[c][k]) * (rim->r[c][next] - rim->r[c][k]);
    return sqrt(sum);
}

/* Reads the rim into one block, which the caller frees as `loop`. */
static enum api_problem_id read_rim(struct rim_columns *rim, const struct api_reader *reader,
                                    const struct api_columns *columns,
                                    struct api_problem *problem) {
    static const char *const names[] = {"loop", "p", "q", "covered", "cut", "x", "y", "z"};
    enum { COLUMNS = sizeof names / sizeof *names };
    double **const into[COLUMNS] = {&rim->loop, &rim->p,    &rim->q,    &rim->covered,
                                    &rim->cut,  &rim->r[0], &rim->r[1], &rim->r[2]};
    rim->count = api_columns_rows(columns, API_TABLE_RIM);
    double *block = calloc(COLUMNS * rim->count + 1, sizeof *block);
    if (!block)
        return api_problem_no_memory(problem, "the pattern");
    for (size_t k = 0; k < COLUMNS; k++) {
        const struct api_column *column = api_columns_find(columns, API_TABLE_RIM, names[k]);
        *into[k] = block + k * rim->count;
        bool wanted = rim->count > 0 && (column || into[k] != &rim->cut);
        if (wanted && (!column || !api_columns_read(reader, column, 0, rim->count, *into[k])))
            api_problem_set(problem, API_INTERNAL, "the stored result is damaged");
    }
    return problem->id;
}

/* The loops of the rim. */
static bool add_rim(struct polygons *polygons, const struct rim_columns *rim) {
    for (size_t k = 0; k < rim->count; k++) {
        if (!polygons_add(polygons, rim->p[k], rim->q[k]))
            return false;
        polygons->points[polygons->count - 1].part = (int)fabs(rim->cut[k]);
        if (k + 1 == rim->count || rim->loop[k + 1] != rim->loop[k])
            polygons_close(polygons);
    }
    return true;
}

/* ---- where the net ended ---- */

/* A place without a node, and why. */
struct place {
    int32_t i, j;
    enum drape_reason reason;
};

static int compare_front_places(const void *a, const void *b) {
    const struct place *x = a, *y = b;
    return x->j != y->j ? (x->j > y->j) - (x->j < y->j) : (x->i > y->i) - (x->i < y->i);
}

/* The front of a result, sorted, in the heap; NULL, with the problem set, where it cannot be. */
static struct place *read_front(const struct api_reader *reader, const struct api_columns *columns,
                                size_t *count, struct api_problem *problem) {
    enum { BLOCK = 512, COLUMNS = 3 };
    static const char *const names[COLUMNS] = {"i", "j", "reason"};
    double block[COLUMNS][BLOCK];
    *count = api_columns_rows(columns, API_TABLE_FRONT);
    struct place *places = malloc((*count + 1) * sizeof *places);
    bool read = true;
    for (size_t first = 0, held; places && read && first < *count; first += held) {
        held = *count - first < BLOCK ? *count - first : BLOCK;
        for (int k = 0; k < COLUMNS; k++) {
            const struct api_column *column = api_columns_find(columns, API_TABLE_FRONT, names[k]);
            read = read && column && api_columns_read(reader, column, first, held, block[k]);
        }
        for (size_t k = 0; read && k < held; k++)
            places[first + k] = (struct place){(int32_t)block[0][k], (int32_t)block[1][k],
                                               (enum drape_reason)block[2][k]};
    }
    if (!places)
        api_problem_no_memory(problem, "the pattern");
    else if (!read)
        api_problem_set(problem, API_INTERNAL, "the stored result is damaged");
    if (places && read && *count)
        qsort(places, *count, sizeof *places, compare_front_places);
    if (places && !read)
        free(places);
    return read ? places : NULL;
}

/* Notes the sides of the outline with the reasons that the corners of the cell beyond them have:
 * not those where the cloth meets itself, nor of a drape that covers the part. */
static enum api_problem_id add_fronts(struct flat_pattern *pattern, const struct outline *outline,
                                      const struct api_reader *reader,
                                      const struct api_columns *columns,
                                      struct api_problem *problem) {
    size_t count;
    if (columns->summary.outcome == DRAPE_COMPLETE)
        return API_OK;
    struct place *places = read_front(reader, columns, &count, problem);
    pattern->fronts = places ? calloc(outline->count + 1, sizeof *pattern->fronts) : NULL;
    for (size_t k = 0; pattern->fronts && k < outline->count; k++) {
        const struct outline_side *side = &outline->sides[k];
        double right[2] = {side->to[1] - side->from[1], side->from[0] - side->to[0]};
        bool found[DRAPE_REASON_COUNT] = {false};
        for (int end = 0; end < 4; end++) {
            const double *at = end % 2 ? side->to : side->from;
            double out = end < 2 ? 0 : 1, length = fabs(right[0]) + fabs(right[1]);
            struct place key = {(int32_t)round(at[0] + out * right[0] / length),
                                (int32_t)round(at[1] + out * right[1] / length), 0};
            const struct place *place =
                bsearch(&key, places, count, sizeof *places, compare_front_places);
            if (place)
                found[place->reason] = true;
        }
        bool collapsed = found[DRAPE_REASON_COLLAPSED];
        if (found[DRAPE_REASON_FOLD] && !collapsed)
            continue;
        struct pattern_front *front = &pattern->fronts[pattern->front_count++];
        memcpy(front->from, side->from, sizeof front->from);
        memcpy(front->to, side->to, sizeof front->to);
        front->end = collapsed ? PATTERN_END_COLLAPSED : PATTERN_END_BARE;
    }
    free(places);
    return problem->id == API_OK && !pattern->fronts ? api_problem_no_memory(problem, "the pattern")
                                                     : problem->id;
}

/* The polygons: the rim where the cloth reaches all of it, else the outline of the cloth. */
static enum api_problem_id make_polygons(struct flat_pattern *pattern,
                                         const struct rim_columns *rim, bool covered,
                                         const struct api_reader *reader,
                                         const struct api_columns *columns, double tolerance,
                                         struct api_problem *problem) {
    struct polygons *polygons = &pattern->polygons;
    struct outline outline = {0};
    const struct outline_rim known = {rim->loop, rim->p, rim->q, rim->covered, rim->count};
    if (covered && !add_rim(polygons, rim))
        api_problem_no_memory(problem, "the pattern");
    else if (!covered && outline_make(reader, columns, &known, &outline, problem) == API_OK)
        (void)!add_fronts(pattern, &outline, reader, columns, problem);
    if (!covered) {
        *polygons = outline.polygons;
        outline.polygons = (struct polygons){0};
    }
    outline_free(&outline);
    if (rim->count > 0 && problem->id == API_OK)
        polygons_simplify(polygons, tolerance);
    return problem->id;
}

/* Where the polygons cross the lines x = 0 and y = 0: outwards is the way to their right. */
size_t flat_pattern_generator_notches(const struct polygons *polygons,
                                      struct pattern_notch *notches) {
    size_t count = 0;
    for (size_t k = 0, first = 0; k < polygons->count; k++) {
        const struct polygons_point *at = polygons->points;
        const struct polygons_point *a = &at[k], *b = &at[a->last ? first : k + 1];
        first = a->last ? k + 1 : first;
        const double across[2][2] = {{a->y, b->y}, {a->x, b->x}};
        for (int family = 0; family < 2; family++) {
            double from = across[family][0], to = across[family][1];
            if ((from < 0) == (to < 0))
                continue;
            double share = from / (from - to), in = (family == 0) == (to > from) ? -1 : 1;
            notches[count++] =
                (struct pattern_notch){.p = family ? 0 : a->x + share * (b->x - a->x),
                                       .q = family ? a->y + share * (b->y - a->y) : 0,
                                       .in = {family ? 0 : in, family ? in : 0}};
        }
    }
    return count;
}

/* The point of the rim at which the right lip of a cut begins: its tip, behind the left lip. */
static size_t find_tip(const struct rim_columns *rim, int number) {
    size_t found = rim->count;
    for (size_t k = 0; k < rim->count; k++)
        if (rim->cut[rim_next(rim, k)] == -number && rim->cut[k] != -number &&
            (found == rim->count || rim->cut[k] == number))
            found = rim_next(rim, k);
    return found;
}

/* Marks a lip where so much of its length on the part lies between the tip and there. Other cuts
 * may begin on the lip. */
static void add_lip_notch(struct flat_pattern *pattern, const struct rim_columns *rim, size_t tip,
                          bool right, double length) {
    double lip = right ? rim->cut[tip] : -rim->cut[tip], done = 0;
    size_t k = right ? tip : rim_before(rim, tip);
    for (size_t n = 0; n < rim->count; n++, k = right ? rim_next(rim, k) : rim_before(rim, k)) {
        size_t next = rim_next(rim, k);
        double step = rim->cut[k] == lip ? rim_step(rim, k) : 0;
        double dp = rim->p[next] - rim->p[k], dq = rim->q[next] - rim->q[k], flat = hypot(dp, dq);
        if (done + step < length || step == 0 || flat == 0) {
            done += step;
            continue;
        }
        double share = (length - done) / step;
        share = right ? share : 1 - share;
        pattern->notches[pattern->notch_count++] =
            (struct pattern_notch){.p = rim->p[k] + share * dp,
                                   .q = rim->q[k] + share * dq,
                                   .in = {-dq / flat, dp / flat}};
        return;
    }
}

/* Marks both lips of each cut at quarters of its length: they are one line of the part, so that the
 * marks meet when it is closed. */
static void add_lip_notches(struct flat_pattern *pattern, const struct rim_columns *rim,
                            size_t cuts) {
    for (int number = 1; number <= (int)cuts; number++) {
        double length = 0;
        size_t tip = find_tip(rim, number);
        for (size_t k = 0; k < rim->count; k++)
            length += rim->cut[k] == number ? rim_step(rim, k) : 0;
        for (int k = 1; k <= LIP_NOTCHES && tip < rim->count; k++)
            for (int side = 0; side < 2; side++)
                add_lip_notch(pattern, rim, tip, side, length * k / (LIP_NOTCHES + 1));
    }
}

enum api_problem_id flat_pattern_make(struct flat_pattern *pattern, const struct api_reader *reader,
                                      const struct api_columns *columns, double tolerance,
                                      struct api_problem *problem) {
    struct rim_columns rim = {0};
    bool covered = true;
    if (read_rim(&rim, reader, columns, problem) == API_OK) {
        for (size_t k = 0; k < rim.count; k++)
            covered = covered && rim.covered[k] != 0;
        covered = covered && rim.count > 0;
        make_polygons(pattern, &rim, covered, reader, columns, tolerance, problem);
    }
    size_t most = 2 * (pattern->polygons.count + LIP_NOTCHES * columns->cut_count);
    pattern->notches = calloc(most + 1, sizeof *pattern->notches);
    if (problem->id == API_OK && !pattern->notches)
        api_problem_no_memory(problem, "the pattern");
    if (problem->id == API_OK) {
        pattern->notch_count = pattern->generator_notches =
            flat_pattern_generator_notches(&pattern->polygons, pattern->notches);
        if (covered)
            add_lip_notches(pattern, &rim, columns->cut_count);
    }
    free(rim.loop);
    return problem->id;
}

void flat_pattern_free(struct flat_pattern *pattern) {
    polygons_free(&pattern->polygons);
    free(pattern->notches);
    free(pattern->fronts);
    *pattern = (struct flat_pattern){0};
}
