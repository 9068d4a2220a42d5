/* SPDX-License-Identifier: MIT */
#include "run.h"

#include "api/check.h"
#include "api/request/normalise.h"
#include "api/run.h"
#include <string.h>

const char *laminate_request(const struct laminate *laminate, size_t n, struct arena *arena) {
    const struct api_request drape = laminate_drape(laminate, laminate->net_ply[n]);
    return api_normalise(&drape, NULL, arena);
}

enum api_problem_id laminate_check_drapes(const struct laminate *laminate,
                                          const struct api_limits *limits, struct arena *arena,
                                          struct api_problem *problem) {
    for (size_t n = 0; n < laminate->net_count; n++) {
        const struct laminate_pieces *pieces = laminate->plies[laminate->net_ply[n]].pieces;
        if (pieces && pieces->courses) /* which have been laid */
            continue;
        struct api_request drape = laminate_drape(laminate, laminate->net_ply[n]);
        struct api_problem own = {.id = API_OK};
        struct arena_mark mark = arena_mark(arena);
        if (api_check_decoded(&drape, limits, arena, &own) != API_OK)
            laminate_fault_of_ply(laminate, laminate->net_ply[n], &own, problem);
        arena_rewind(arena, mark);
    }
    return problem->id;
}

enum api_problem_id laminate_run(const struct laminate *laminate, size_t n,
                                 const struct api_input *input, const struct api_limits *limits,
                                 const struct drape_monitor *monitor, const struct api_sink *sink,
                                 struct api_problem *problem) {
    struct api_problem own = {.id = API_OK};
    struct arena *arena = arena_new(limits->max_memory);
    const char *request = arena ? laminate_request(laminate, n, arena) : NULL;
    if (request) {
        const struct api_input one = {.request = request,
                                      .request_length = strlen(request),
                                      .surface = input->surface,
                                      .surface_length = input->surface_length};
        if (api_run_in(arena, &one, limits, monitor, sink, &own) != API_OK)
            laminate_fault_of_ply(laminate, laminate->net_ply[n], &own, problem);
    } else {
        api_problem_no_memory(problem, "the laminate");
    }
    arena_free(arena);
    return problem->id;
}
