/* SPDX-License-Identifier: MIT */
/*
 * What is cut: the polygons of the cloth in the coordinates (p, q) of the net. They follow the rim
 * and, where no cloth reaches it, the outline of the cells; all of that in a result without a rim.
 */
#ifndef API_RESULT_FLAT_PATTERN_H
#define API_RESULT_FLAT_PATTERN_H

#include "outline.h"
#include "polygons.h"

/* Where a generator crosses the edge of the cut: a place, and the way along the yarn out of the
 * cloth, +1 or -1 along warp (family 0) or weft (1). */
struct pattern_notch {
    double p, q;
    int family, way;
};

struct flat_pattern {
    struct polygons polygons;
    struct pattern_notch *notches; /* malloc'ed */
    size_t notch_count;
};

/* Makes the polygons, within `tolerance` of the rim, of what `pattern` (zero-initialised) is to
 * hold. API_OUT_OF_MEMORY, or API_INTERNAL when the container is damaged. The caller frees it in
 * any case. */
enum api_problem_id flat_pattern_make(struct flat_pattern *pattern, const struct api_reader *reader,
                                      const struct api_columns *columns,
                                      const struct outline *outline, double tolerance,
                                      struct api_problem *problem) STATUS_MUST_USE;

void flat_pattern_free(struct flat_pattern *pattern);

#endif
