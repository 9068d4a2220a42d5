/* SPDX-License-Identifier: MIT */
/* A study as it was understood; its arrays lie in the arena it was decoded with. */
#ifndef API_STUDY_REQUEST_H
#define API_STUDY_REQUEST_H

#include "api/input.h"
#include "api/limits.h"
#include "api/problem.h"
#include "api/request/request.h"
#include "api/result/quantity.h"
#include "course_plan.h"
#include "solver/arena.h"
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum study_search { STUDY_SEARCH_GRID, STUDY_SEARCH_OPTIMISE, STUDY_SEARCH_COUNT };

/* How a start is varied. */
enum study_starts {
    STUDY_STARTS_KEPT,
    STUDY_STARTS_GRID,   /* `start_count` places, spread evenly over the area */
    STUDY_STARTS_POINTS, /* those of `points` */
    STUDY_STARTS_DISC    /* drawn from the disc of `radius` round the drape's own */
};

/* A start as a drape request gives it. */
struct study_point {
    enum drape_start_kind kind; /* by parameters or by a point */
    bool on_face;               /* of parameters on several faces: of this one */
    int face;
    double uv[2];
    struct vec3 point;
};

/* The values of an angle. */
struct study_angles {
    size_t count;         /* 0: kept as in the drape */
    const double *values; /* NULL: from, from + step, ... */
    double from, to, step;
    double deviation; /* drawn from a normal distribution about the drape's own; 0: not drawn */
};

struct study_limit {
    bool has_min, has_max;
    double min, max;
};

struct study_request {
    struct api_request drape;
    enum study_starts starts;
    size_t start_count;
    const struct study_point *points;
    double radius;
    struct study_angles angle, pre_shear;
    int steering;  /* points a side of the generators that each variant seeks; 0: it has the drape's
                    */
    size_t splits; /* cuts that may be proposed; 0: none are */
    struct study_courses courses; /* laid in place of the drape, where it has a base */
    bool objective[QUANTITY_COUNT];
    struct study_limit limit[QUANTITY_COUNT];
    enum study_search search;
    size_t budget;      /* variants that an optimisation may look at */
    struct vec3 wanted; /* zero: not given */
    double exponent;    /* p of the mean angle from there, 1 to 64 */
    size_t sample;      /* variants to be drawn; 0: none is */
    uint32_t seed;
};

/* The names that the document uses, in the order of the enumerations. */
extern const char *const study_search_names[STUDY_SEARCH_COUNT];

/* The value number k of a range of angles. */
double study_angle(const struct study_angles *angles, size_t k);

/* Whether a quantity has to be computed for each variant. */
bool study_judges(const struct study_request *request, enum quantity_id id);

/* How many variants there are: of an optimisation and of samples at the most. */
size_t study_variants(const struct study_request *request);

/* Decodes a study; a surface by id as `api_decode`. Problems: those of `api_decode`, and
 * API_INVALID_REQUEST for more than `limits->max_variants`. */
enum api_problem_id study_decode(const struct api_input *input, const struct api_limits *limits,
                                 struct arena *arena, struct study_request *request,
                                 struct api_problem *problem) STATUS_MUST_USE;

/* The study as it was understood, with every default filled in, in `arena`; NULL without memory. */
const char *study_normalise(const struct study_request *request, struct arena *arena);

/* The id of what a study asks for; as `api_digest_request`. */
bool study_digest(const struct study_request *request, struct arena *arena,
                  char id[API_ID_SIZE]) STATUS_MUST_USE;

#endif
