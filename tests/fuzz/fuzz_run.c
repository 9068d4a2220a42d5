/* SPDX-License-Identifier: MIT */
/* A whole job within tiny budgets, from any request to its result in every format. */
#include "encode.h"

#include "api/run.h"
#include <string.h>

enum {
    BUDGET = 1 << 25,
    NODES = 300,
    LOOKS = 2000 /* of the monitor, until the job is cancelled */
};

static const struct api_limits limits = {
    .max_nodes = NODES, .max_memory = BUDGET, .max_elements = 500, .max_depth = 16, .threads = 1};

struct result {
    uint8_t *data;
    size_t size, capacity;
};

static bool take(void *context, const void *bytes, size_t length) {
    struct result *result = context;
    if (result->size + length > result->capacity) {
        result->capacity = 2 * result->capacity + length;
        result->data = realloc(result->data, result->capacity);
        FUZZ_PROMISE(result->data != NULL);
    }
    memcpy(result->data + result->size, bytes, length);
    result->size += length;
    return true;
}

static bool go_on(void *context, double fraction) {
    int *looks = context;
    FUZZ_PROMISE(fraction >= 0.0 && fraction <= 1.0);
    return ++*looks < LOOKS;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static bool prepared;
    int looks = 0;
    struct result result = {0};
    struct api_problem problem = {0};
    if (!prepared)
        prepared = api_prepare();
    const struct api_input input = {.request = (const char *)data, .request_length = size};
    const struct api_sink sink = {.write = take, .context = &result};
    const struct drape_monitor monitor = {go_on, &looks};
    enum api_problem_id id = api_run(&input, &limits, &monitor, &sink, &problem);
    FUZZ_PROMISE(id == problem.id && id != API_INTERNAL);
    if (id == API_OK)
        encode_all(result.data, result.size, true);
    free(result.data);
    return 0;
}
