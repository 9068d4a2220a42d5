/* SPDX-License-Identifier: MIT */
#include "cut_sheet.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LINES = 15, CROSSINGS = 64 };

static int compare_crossings(const void *a, const void *b) {
    const double *x = a, *y = b;
    return (*x > *y) - (*x < *y);
}

/* Between the first and second, the third and fourth, ... crossing of a line with the edge the
 * shape lies. */
struct cut_chord cut_chord_of(const struct nesting_shape *shape) {
    const struct polygons_point *p = shape->cut->points;
    struct cut_chord best = {{shape->low[0], shape->low[0]}, shape->low[1]};
    for (int line = 0; line < LINES; line++) {
        int step = (line + 1) / 2 * (line % 2 ? 1 : -1); /* the middle first */
        double y = shape->low[1] + (shape->high[1] - shape->low[1]) * (0.5 + step / (LINES + 1.0));
        double x[CROSSINGS];
        size_t count = 0;
        for (size_t k = 0, first = 0; k < shape->cut->count && count < CROSSINGS; k++) {
            const struct polygons_point *next = &p[p[k].last ? first : k + 1];
            first = p[k].last ? k + 1 : first;
            if ((p[k].y <= y) != (next->y <= y))
                x[count++] = p[k].x + (y - p[k].y) / (next->y - p[k].y) * (next->x - p[k].x);
        }
        qsort(x, count, sizeof *x, compare_crossings);
        for (size_t k = 0; k + 1 < count; k += 2)
            if (x[k + 1] - x[k] > (best.x[1] - best.x[0]) * (1 + 1e-9))
                best = (struct cut_chord){{x[k], x[k + 1]}, y};
    }
    return best;
}

void cut_layer_title(const struct cut_roll *roll, const struct nesting_place *place,
                     char title[CUT_TEXT_SIZE]) {
    int layers = roll->shapes[place->shape].layers;
    const char *name = roll->pieces[place->shape].title;
    if (layers > 1)
        (void)snprintf(title, CUT_TEXT_SIZE, "%s (%d of %d)", name, place->layer + 1, layers);
    else
        (void)snprintf(title, CUT_TEXT_SIZE, "%s", name);
}

void cut_sheet_summary(const struct cut_sheet *sheet, const struct cut_roll *roll,
                       char summary[CUT_TEXT_SIZE]) {
    size_t patterns = 0;
    double length = 0, area = 0;
    for (size_t k = 0; k < sheet->roll_count; k++) {
        const struct cut_roll *own = &sheet->rolls[k];
        if (roll && own != roll)
            continue;
        patterns += own->place_count;
        length += own->length;
        area += own->area;
    }
    double used = 100 * area / (sheet->width * length);
    char rolls[32] = "";
    if (!roll && sheet->roll_count > 1)
        (void)snprintf(rolls, sizeof rolls, " on %zu rolls", sheet->roll_count);
    (void)snprintf(summary, CUT_TEXT_SIZE,
                   "%zu patterns on %.6g x %.6g %s of roll%s, warp along it; cloth %.6g %s2, "
                   "utilisation %.1f %%, waste %.1f %%; revision %s",
                   patterns, length, sheet->width, sheet->unit->name, rolls, area,
                   sheet->unit->name, used, 100 - used, sheet->revision);
    size_t said = strlen(summary);
    if (!roll && sheet->left_out == 1)
        (void)snprintf(summary + said, CUT_TEXT_SIZE - said,
                       "; without \"%s\", which could not be draped", sheet->left_out_first);
    else if (!roll && sheet->left_out > 1)
        (void)snprintf(summary + said, CUT_TEXT_SIZE - said,
                       "; without %zu plies that could not be draped, the first of them \"%s\"",
                       sheet->left_out, sheet->left_out_first);
}
