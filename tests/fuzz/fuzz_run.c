/* SPDX-License-Identifier: MIT */
/* A whole job within tiny budgets, from any request to its result in every format. */
#include "encode.h"

#include "api/run.h"

enum {
    LOOKS = 2000 /* of the monitor, until the job is cancelled */
};

static bool go_on(void *context, double fraction) {
    int *looks = context;
    FUZZ_PROMISE(fraction >= 0.0 && fraction <= 1.0);
    return ++*looks < LOOKS;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static bool prepared;
    int looks = 0;
    struct fuzz_bytes result = {0};
    struct api_problem problem = {0};
    if (!prepared)
        prepared = api_prepare();
    const struct api_input input = {.request = (const char *)data, .request_length = size};
    const struct api_sink sink = {.write = fuzz_append, .context = &result};
    const struct drape_monitor monitor = {go_on, &looks};
    enum api_problem_id id = api_run(&input, &fuzz_limits, &monitor, &sink, &problem);
    FUZZ_PROMISE(id == problem.id && id != API_INTERNAL);
    if (id == API_OK)
        encode_all(result.data, result.size, true);
    free(result.data);
    return 0;
}
