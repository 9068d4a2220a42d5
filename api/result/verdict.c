/* SPDX-License-Identifier: MIT */
#include "verdict.h"

#include "api/json/text.h"
#include "api/json/value.h"
#include "api/request/request.h"
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* Hardly a woven fabric bears more. */
static const double usual_limit_deg = 60;

static const char *const obstacle_names[VERDICT_COUNT] = {"none",   "uncovered", "shear",
                                                          "fibres", "limit",     "failed"};

void verdict_shear_limits(const struct api_request *request, double limit_deg[2]) {
    for (int k = 0; k < 2; k++) {
        double angle = request->fabric.locking_angle_deg[k];
        limit_deg[k] = angle < 0 ? usual_limit_deg : angle;
    }
}

/* ---- where the cloth ends ---- */

/* How many places (i, j) the front has for a reason; `at` gets the node that is nearest in the net
 * to the one of them that is nearest to the start. */
static size_t front_of(const struct drape_result *result, enum drape_reason reason,
                       struct vec3 *at) {
    const struct drape_front *front = &result->front;
    const struct drape_nodes *nodes = &result->nodes;
    size_t count = 0, first = 0, nearest = 0;
    long least = LONG_MAX;
    for (size_t k = 0; k < front->count; k++) {
        long steps = labs((long)front->i[k]) + labs((long)front->j[k]);
        bool counts = front->reason[k] == reason;
        first = counts && steps < least ? k : first;
        least = counts && steps < least ? steps : least;
        count += counts;
    }
    least = LONG_MAX;
    for (size_t k = 0; k < nodes->count && count > 0; k++) {
        long steps =
            labs((long)nodes->i[k] - front->i[first]) + labs((long)nodes->j[k] - front->j[first]);
        nearest = steps < least ? k : nearest;
        least = steps < least ? steps : least;
    }
    *at = vec3_make(nodes->x[nearest], nodes->y[nearest], nodes->z[nearest]);
    return count;
}

bool verdict_find_end(const struct drape_result *result, struct verdict_end *end) {
    static const enum drape_reason reasons[] = {DRAPE_REASON_COLLAPSED, DRAPE_REASON_NO_CONVERGENCE,
                                                DRAPE_REASON_FOLD};
    const struct drape_rim *rim = &result->rim;
    *end = (struct verdict_end){.reason = DRAPE_REASON_BOUNDARY};
    for (size_t k = 0; k < sizeof reasons / sizeof *reasons; k++) {
        end->count = front_of(result, reasons[k], &end->at);
        if (end->count > 0) {
            end->reason = reasons[k];
            return true;
        }
    }
    for (size_t k = rim->count; k-- > 0;)
        if (!rim->covered[k]) {
            end->at = vec3_make(rim->x[k], rim->y[k], rim->z[k]);
            end->count++;
        }
    return end->count > 0;
}

/* ---- judging ---- */

struct verdict_case verdict_case_of(const struct drape_result *result, const double limit_deg[2]) {
    const struct drape_summary *s = &result->summary;
    struct verdict_end end;
    struct drape_most most = {s->max_shear_deg, s->max_shear_point};
    int sign = s->most[1].shear_deg - limit_deg[1] > s->most[0].shear_deg - limit_deg[0];
    if (limit_deg[0] != limit_deg[1])
        most = s->most[sign];
    struct verdict_case c = {.coverage = s->cloth_coverage,
                             .shear_deg = most.shear_deg,
                             .limit_deg = limit_deg[sign],
                             .placed = true,
                             .at = most.point};
    if (s->outcome == DRAPE_COMPLETE)
        return c;
    /* A net that ends by its extent alone covers what was asked. */
    bool ends = verdict_find_end(result, &end);
    c.bare =
        s->front_reasons[DRAPE_REASON_EXTENT] == 0 || (ends && end.reason != DRAPE_REASON_BOUNDARY);
    if (c.bare) {
        c.placed = ends;
        c.at = end.at;
    }
    return c;
}

void verdict_judge(const struct verdict_case *c, struct api_verdict *verdict) {
    char where[80] = "";
    /* a coordinate that is nothing beside the others is 0 */
    double least = 1e-9 * fmax(fmax(fabs(c->at.x), fabs(c->at.y)), fabs(c->at.z));
    if (c->placed)
        snprintf(where, sizeof where, " at (%.4g, %.4g, %.4g)", fabs(c->at.x) < least ? 0 : c->at.x,
                 fabs(c->at.y) < least ? 0 : c->at.y, fabs(c->at.z) < least ? 0 : c->at.z);
    *verdict = (struct api_verdict){.variant = -1, .placed = c->placed, .at = c->at};
    const char *how = c->courses ? "in courses" : "in one piece";
    char *detail = verdict->detail;
    const size_t size = sizeof verdict->detail;
    if (c->bare) {
        verdict->obstacle = VERDICT_UNCOVERED;
        snprintf(detail, size, "not %s: %.4g %% is covered, and the cloth ends%s; %s", how,
                 100 * c->coverage, where, c->remedy);
    } else if (c->shear_deg > c->limit_deg) {
        verdict->obstacle = VERDICT_SHEAR;
        snprintf(detail, size, "not within %g degrees %s: the cloth shears by %.1f%s; %s",
                 c->limit_deg, how, c->shear_deg, where, c->remedy);
    } else if (c->packed_cells > 0) {
        verdict->obstacle = VERDICT_FIBRES;
        snprintf(detail, size, "more fibres than can be packed in %.0f cells, the most%s",
                 c->packed_cells, where);
    } else {
        verdict->placed = false;
        snprintf(detail, size,
                 "drapable %s: %.4g %% is covered, within %g degrees of shear, %.1f at "
                 "the most",
                 how, 100 * c->coverage, c->limit_deg, c->shear_deg);
    }
}

/* ---- documents ---- */

void verdict_write(struct api_text *text, const struct api_verdict *verdict, bool study) {
    api_text_raw(text, "{");
    api_text_key(text, "drapable");
    api_text_raw(text, verdict->obstacle == VERDICT_DRAPABLE ? "true" : "false");
    api_text_key(text, "obstacle");
    if (verdict->obstacle == VERDICT_DRAPABLE)
        api_text_raw(text, "null");
    else
        api_text_string(text, obstacle_names[verdict->obstacle]);
    api_text_key(text, "at");
    if (verdict->placed) {
        api_text_raw(text, "{");
        api_text_key_number(text, "x", verdict->at.x);
        api_text_key_number(text, "y", verdict->at.y);
        api_text_key_number(text, "z", verdict->at.z);
        api_text_raw(text, "}");
    } else {
        api_text_raw(text, "null");
    }
    if (study)
        api_text_key_number(text, "variant", verdict->variant < 0 ? (double)NAN : verdict->variant);
    api_text_key_string(text, "detail", verdict->detail);
    api_text_raw(text, "}");
}

void verdict_read(const struct json_value *json, struct api_verdict *verdict) {
    static const struct value_range any = {-1e300, 1e300, false};
    struct json_value obstacle = value_member(json, "obstacle"), at = value_member(json, "at");
    struct json_value variant = value_member(json, "variant");
    struct json_value detail = value_member(json, "detail");
    double *const place[] = {&verdict->at.x, &verdict->at.y, &verdict->at.z};
    static const char *const axes[] = {"x", "y", "z"};
    const char *words;
    int index = VERDICT_DRAPABLE;
    *verdict = (struct api_verdict){.variant = -1};
    if (value_type(&obstacle) == VALUE_STRING)
        value_choice(&obstacle, obstacle_names, VERDICT_COUNT, &index);
    verdict->obstacle = (enum verdict_obstacle)index;
    if (value_type(&variant) == VALUE_NUMBER)
        value_integer(&variant, 0, INT_MAX, &verdict->variant);
    verdict->placed = value_type(&at) == VALUE_OBJECT;
    for (int k = 0; k < 3 && verdict->placed; k++) {
        struct json_value own = value_member(&at, axes[k]);
        value_number(&own, any, place[k]);
    }
    if (value_given(&detail) && value_string(&detail, &words))
        snprintf(verdict->detail, sizeof verdict->detail, "%s", words);
}
