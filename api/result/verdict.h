/* SPDX-License-Identifier: MIT */
/*
 * The verdict on a drape, and by the best of its variants on a study: whether the fabric can be
 * laid as asked, in one piece and within the shear that it bears, or what stands in the way and
 * where.
 */
#ifndef API_RESULT_VERDICT_H
#define API_RESULT_VERDICT_H

#include "solver/result.h"
#include <stdbool.h>
#include <stddef.h>

struct api_request;
struct api_text;
struct json_value;

/* What stands in the way: the first of these that does. */
enum verdict_obstacle {
    VERDICT_DRAPABLE,
    VERDICT_UNCOVERED, /* the cloth ends within the part */
    VERDICT_SHEAR,     /* it shears by more than the fabric bears */
    VERDICT_FIBRES,    /* cells hold more fibres than can be packed */
    VERDICT_LIMIT,     /* no variant keeps another limit of the study */
    VERDICT_FAILED,    /* no variant could be draped */
    VERDICT_COUNT
};

struct api_verdict {
    enum verdict_obstacle obstacle;
    int variant;      /* of a study, the one that is judged; -1: none, of a drape always */
    bool placed;      /* whether `at` is known */
    struct vec3 at;   /* where the obstacle is */
    char detail[300]; /* a sentence for people; "" of a result that an earlier version stored */
};

/* What a verdict is made of. */
struct verdict_case {
    bool bare;           /* the cloth ends within the part, where nobody asked it to */
    double coverage;     /* share of the part that is covered */
    double shear_deg;    /* the greatest of the cloth, of the sign that goes furthest .. */
    double limit_deg;    /* .. beyond what it may have, in degrees */
    double packed_cells; /* with more fibres than can be packed; none at or below 0 */
    bool placed;         /* whether `at` is known */
    struct vec3 at;      /* where it is bare, else of the greatest shear */
    const char *remedy;  /* the sentence after what stands in the way */
    bool courses;        /* the cloth is many courses and not one piece */
};

/* Sets all but `variant`, which becomes -1. */
void verdict_judge(const struct verdict_case *c, struct api_verdict *verdict);

/* The case of a drape whose positive and negative shear may have so many degrees, without
 * `packed_cells` and `remedy`. */
struct verdict_case verdict_case_of(const struct drape_result *result, const double limit_deg[2]);

/* These limits of the fabric of a request: its locking angles or, without any, what hardly a woven
 * fabric bears. */
void verdict_shear_limits(const struct api_request *request, double limit_deg[2]);

/* Where and why the cloth of a drape ends within the part: the reason of its front, with the place
 * that is nearest to the start in the net and how many there are; else DRAPE_REASON_BOUNDARY and
 * the points of the part's edge without cloth. False where it ends nowhere. */
struct verdict_end {
    enum drape_reason reason;
    size_t count;
    struct vec3 at;
};
bool verdict_find_end(const struct drape_result *result, struct verdict_end *end);

/* As the contract has it: {"drapable", "obstacle", "at", "detail"} and of a study "variant". */
void verdict_write(struct api_text *text, const struct api_verdict *verdict, bool study);

/* Reads it; what is wrong is reported to the place's problem. One that is missing, in a result that
 * an earlier version stored, has no detail. */
void verdict_read(const struct json_value *json, struct api_verdict *verdict);

#endif
