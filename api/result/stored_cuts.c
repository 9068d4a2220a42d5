/* SPDX-License-Identifier: MIT */
#include "stored_cuts.h"

#include <math.h>
#include <stdio.h>

bool stored_cuts_read(const struct api_reader *reader, const struct api_columns *columns,
                      struct stored_cut cuts[API_CUTS_MAX]) {
    static const struct {
        const char *name;
        size_t offset;
    } members[] = {
#define MEMBER(name) #name, offsetof(struct stored_cut, name)
        {MEMBER(length)}, {MEMBER(tip_angle_deg)}, {MEMBER(mouth_width)},
        {MEMBER(area)},   {MEMBER(covered)},       {MEMBER(allowance)},
#undef MEMBER
    };
    double values[API_CUTS_MAX];
    size_t count = columns->cut_count;
    for (size_t n = 0; n < count; n++)
        cuts[n].name = columns->cut_names[n];
    for (size_t k = 0; k < sizeof members / sizeof *members && count > 0; k++) {
        const struct api_column *column =
            api_columns_find(columns, API_TABLE_CUTS, members[k].name);
        if (!column || column->rows != count || !api_columns_read(reader, column, 0, count, values))
            return false;
        for (size_t n = 0; n < count; n++)
            *(double *)(void *)((char *)&cuts[n] + members[k].offset) = values[n];
    }
    return true;
}

void stored_cut_describe(const struct stored_cut *cut, const char *unit,
                         char text[STORED_CUT_TEXT]) {
    static const double slight = 0.05, narrow = 1e-3; /* degrees; widths by the length */
    double angle = fabs(cut->tip_angle_deg), width = fabs(cut->mouth_width);
    int length =
        snprintf(text, STORED_CUT_TEXT, "%s: %.4g %s long, ", cut->name, cut->length, unit);
    char *rest = text + length;
    size_t room = STORED_CUT_TEXT - (size_t)length;
    if (cut->covered == 0)
        snprintf(rest, room, "not covered");
    else if (angle < slight && width < narrow * cut->length)
        snprintf(rest, room, "a slit");
    else
        snprintf(rest, room, "%s of %.4g degrees at its tip, %.4g %s %s at its mouth, %.4g %s2 %s",
                 cut->tip_angle_deg >= 0 ? "a dart" : "an overlap", angle, width, unit,
                 cut->mouth_width < 0 ? "too narrow" : "wide", fabs(cut->area), unit,
                 cut->area < 0 ? "lacking" : "cut out");
}
