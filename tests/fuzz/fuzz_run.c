/* SPDX-License-Identifier: MIT */
/* A whole job within tiny budgets, from any request to its result in every format. */
#include "encode.h"

#include "api/run.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    int looks = 0;
    struct fuzz_bytes result = {0};
    struct api_problem problem = {0};
    fuzz_prepare();
    const struct api_input input = {.request = (const char *)data, .request_length = size};
    const struct api_sink sink = {.write = fuzz_append, .context = &result};
    const struct drape_monitor monitor = {fuzz_go_on, &looks};
    enum api_problem_id id = api_run(&input, &fuzz_limits, &monitor, &sink, &problem);
    FUZZ_PROMISE(id == problem.id && id != API_INTERNAL);
    if (id == API_OK)
        encode_all(result.data, result.size, true);
    free(result.data);
    return 0;
}
