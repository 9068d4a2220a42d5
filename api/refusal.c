/* SPDX-License-Identifier: MIT */
#include "refusal.h"

#include <stdio.h>

static enum api_problem_id set_cut_problem(struct api_problem *problem,
                                           const struct cut_fault *fault,
                                           const struct drape_settings *settings) {
    static const struct {
        const char *what, *remedy;
    } texts[] = {
        [CUT_OFF_PART] = {"is further from the part than a spacing", "move its path onto the part"},
        [CUT_SHORT] = {"is shorter than a spacing", "lengthen it or leave it out"},
        [CUT_AT_START] = {"passes the start", "move the start or the cut"},
        [CUT_CROSSES] = {"crosses another cut", "end it before that one, or begin it there"},
        [CUT_CROSSES_SELF] = {"crosses itself, or comes back to itself",
                              "end its path before that place, or lead it round"},
        [CUT_BEGINS_INSIDE] = {"begins inside the part",
                               "begin its path at an edge of the part, of a hole or of a cut "
                               "before it"},
        [CUT_SPLITS] = {"ends at an edge, so that it divides the part", "end its path inside"},
    };
    /* an end of the path, or the point that it leaves the part towards */
    const struct drape_cut_line *line = &settings->cuts[fault->cut];
    size_t point = fault->kind == CUT_SPLITS ? line->count - 1 : 0;
    bool off = fault->kind == CUT_OFF_PART;
    double least = vec3_distance(line->path[0], fault->at);
    for (size_t k = 1; k < line->count && off; k++) {
        double detour = vec3_distance(line->path[k - 1], fault->at) +
                        vec3_distance(fault->at, line->path[k]) -
                        vec3_distance(line->path[k - 1], line->path[k]);
        point = detour < least ? k : point;
        least = fmin(detour, least);
    }
    bool known = off || fault->kind == CUT_SPLITS || fault->kind == CUT_BEGINS_INSIDE;
    char pointer[64];
    snprintf(pointer, sizeof pointer, known ? "/cuts/%zu/path/%zu" : "/cuts/%zu", fault->cut,
             point);
    return api_problem_set_at(problem, API_INVALID_REQUEST, pointer,
                              "%s, at (%.6g, %.6g, %.6g): %s", texts[fault->kind].what, fault->at.x,
                              fault->at.y, fault->at.z, texts[fault->kind].remedy);
}

enum api_problem_id refusal_of_status(struct api_problem *problem, enum status status,
                                      const struct drape_settings *settings,
                                      const struct drape_result *result) {
    const char *generator = result->faulty_generator == 1 ? "/generators/weft" : "/generators/warp";
    switch (status) {
    case STATUS_OK:
        return API_OK;
    case STATUS_OUT_OF_MEMORY:
        return api_problem_no_memory(problem, "the drape");
    case STATUS_CANCELLED:
        return api_problem_set(problem, API_CANCELLED, "the drape was cancelled");
    case STATUS_TOO_MANY_NODES:
        return api_problem_set_at(
            problem, API_INVALID_REQUEST, "/fabric/spacing",
            "is too small: the net would have more than the %zu nodes allowed",
            settings->max_nodes);
    case STATUS_START_STUCK:
        return api_problem_set_at(problem, API_INVALID_REQUEST, "/start",
                                  "all four yarns leave the part within one spacing of the start; "
                                  "turn the direction, move the start or take a smaller spacing");
    case STATUS_DEGENERATE_SURFACE:
        return api_problem_set_at(problem, API_DEGENERATE_SURFACE, "/start",
                                  "the surface has no tangent plane at the start");
    case STATUS_GENERATOR_OFF_START:
        return api_problem_set_at(problem, API_INVALID_REQUEST, generator,
                                  "must pass through the start, to a thousandth of the spacing");
    case STATUS_GENERATOR_PARALLEL:
        return api_problem_set_at(problem, API_INVALID_REQUEST, generator,
                                  "must not be parallel to the other generator, nor a tangent "
                                  "plane");
    case STATUS_CUT:
        return set_cut_problem(problem, &result->faulty_cut, settings);
    case STATUS_INVALID:
        if (settings->generator[0].kind == DRAPE_GENERATOR_PLACES)
            return api_problem_set_at(problem, API_INVALID_REQUEST, "/generators/warp/places",
                                      "must be a spacing apart, and go on from each other");
        /* Ranges were checked; that the direction has a part in the tangent plane was not. */
        if (settings->direction_kind == DRAPE_DIRECTION_VECTOR)
            return api_problem_set_at(problem, API_INVALID_REQUEST, "/direction/vector",
                                      "must not be at right angles to the surface at the start");
        if (settings->zero.kind == DRAPE_ZERO_ROSETTE)
            return api_problem_set_at(problem, API_INVALID_REQUEST, "/rosette/x",
                                      "must not be at right angles to the surface at the start: "
                                      "turn the rosette, move the start, or give the direction as "
                                      "a vector");
        break;
    case STATUS_START_OFF_SURFACE: /* `refuse_start` */
    case STATUS_NO_CONVERGENCE:
        break;
    }
    return api_problem_set(problem, API_INTERNAL, "the solver did not accept the decoded request");
}
