/* SPDX-License-Identifier: MIT */
#include "flat_pattern.h"

#include "outline.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The loops of the rim. */
static bool add_rim(struct polygons *polygons, const struct outline_rim *rim) {
    for (size_t k = 0; k < rim->count; k++) {
        if (!polygons_add(polygons, rim->p[k], rim->q[k]))
            return false;
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
                                         const struct api_reader *reader,
                                         const struct api_columns *columns, double tolerance,
                                         struct api_problem *problem) {
    enum { LOOP, P, Q, COVERED, COLUMNS };
    static const char *const names[COLUMNS] = {"loop", "p", "q", "covered"};
    size_t count = api_columns_rows(columns, API_TABLE_RIM);
    double *values = malloc((COLUMNS * count + 1) * sizeof *values);
    bool read = values != NULL, covered = count > 0;
    struct polygons *polygons = &pattern->polygons;
    struct outline outline = {0};
    if (!values)
        return api_problem_no_memory(problem, "the pattern");
    for (int k = 0; count > 0 && read && k < COLUMNS; k++) {
        const struct api_column *column = api_columns_find(columns, API_TABLE_RIM, names[k]);
        read = column && api_columns_read(reader, column, 0, count, values + (size_t)k * count);
    }
    const struct outline_rim rim = {values, values + P * count, values + Q * count,
                                    values + COVERED * count, count};
    for (size_t k = 0; read && k < count; k++)
        covered = covered && rim.covered[k] != 0;
    if (!read)
        api_problem_set(problem, API_INTERNAL, "the stored result is damaged");
    else if (covered && !add_rim(polygons, &rim))
        api_problem_no_memory(problem, "the pattern");
    else if (!covered && outline_make(reader, columns, &rim, &outline, problem) == API_OK)
        (void)!add_fronts(pattern, &outline, reader, columns, problem);
    if (!covered) {
        *polygons = outline.polygons;
        outline.polygons = (struct polygons){0};
    }
    outline_free(&outline);
    if (count > 0 && problem->id == API_OK)
        polygons_simplify(polygons, tolerance);
    free(values);
    return problem->id;
}

/* Where the polygons cross the lines x = 0 and y = 0: outwards is the way to their right. */
static void add_notches(struct flat_pattern *pattern) {
    for (size_t k = 0, first = 0; k < pattern->polygons.count; k++) {
        const struct polygons_point *at = pattern->polygons.points;
        const struct polygons_point *a = &at[k], *b = &at[a->last ? first : k + 1];
        first = a->last ? k + 1 : first;
        const double across[2][2] = {{a->y, b->y}, {a->x, b->x}};
        for (int family = 0; family < 2; family++) {
            double from = across[family][0], to = across[family][1];
            if ((from < 0) == (to < 0))
                continue;
            double share = from / (from - to);
            int way = (family == 0) == (to > from) ? 1 : -1;
            pattern->notches[pattern->notch_count++] =
                (struct pattern_notch){family ? 0 : a->x + share * (b->x - a->x),
                                       family ? a->y + share * (b->y - a->y) : 0, family, way};
        }
    }
}

enum api_problem_id flat_pattern_make(struct flat_pattern *pattern, const struct api_reader *reader,
                                      const struct api_columns *columns, double tolerance,
                                      struct api_problem *problem) {
    if (make_polygons(pattern, reader, columns, tolerance, problem) != API_OK)
        return problem->id;
    pattern->notches = calloc(2 * pattern->polygons.count + 1, sizeof *pattern->notches);
    if (!pattern->notches)
        return api_problem_no_memory(problem, "the pattern");
    add_notches(pattern);
    return API_OK;
}

void flat_pattern_free(struct flat_pattern *pattern) {
    polygons_free(&pattern->polygons);
    free(pattern->notches);
    free(pattern->fronts);
    *pattern = (struct flat_pattern){0};
}
