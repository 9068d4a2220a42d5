/* SPDX-License-Identifier: MIT */
/* Any bytes as a drape request, and as a surface; what was understood is written down and must be
 * understood again. */
#include "encode.h"

#include "api/request/decode.h"
#include "api/request/digest.h"
#include "api/request/normalise.h"
#include "api/run.h"
#include <string.h>

static void expect_consistent(enum api_problem_id id, const struct api_problem *problem) {
    FUZZ_PROMISE(id == problem->id);
    FUZZ_PROMISE(id == API_OK || id == API_MALFORMED_JSON || id == API_TOO_LARGE ||
                 id == API_INVALID_REQUEST || id == API_OUT_OF_MEMORY);
    if (id == API_OK)
        return;
    char *text = api_problem_json(problem, NULL);
    FUZZ_PROMISE(text != NULL);
    free(text);
}

/* The request with every default filled in is a request that means the same. */
static void expect_round_trip(const struct api_request *request, struct arena *arena) {
    struct api_request again;
    struct api_problem problem = {0};
    char first[API_ID_SIZE], second[API_ID_SIZE];
    const char *text = api_normalise(request, NULL, arena);
    if (!text || !api_digest_request(request, arena, first))
        return; /* out of memory */
    const struct api_input input = {.request = text, .request_length = strlen(text)};
    enum api_problem_id id = api_decode(&input, &fuzz_limits, arena, &again, &problem);
    if (id == API_OUT_OF_MEMORY || id == API_TOO_LARGE)
        return;
    FUZZ_PROMISE(id == API_OK);
    if (api_digest_request(&again, arena, second))
        FUZZ_PROMISE(strcmp(first, second) == 0);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    struct api_request request;
    struct api_surface surface;
    struct api_problem problem = {0};
    fuzz_prepare();
    struct arena *arena = arena_new(fuzz_limits.max_memory);
    const struct api_input input = {.request = (const char *)data, .request_length = size};
    enum api_problem_id id = api_decode(&input, &fuzz_limits, arena, &request, &problem);
    expect_consistent(id, &problem);
    if (id == API_OK)
        expect_round_trip(&request, arena);
    problem = (struct api_problem){0};
    id = api_decode_surface((const char *)data, size, &fuzz_limits, arena, &surface, &problem);
    expect_consistent(id, &problem);
    arena_free(arena);
    return 0;
}
