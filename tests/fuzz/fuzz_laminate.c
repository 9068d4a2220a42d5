/* SPDX-License-Identifier: MIT */
/* A whole laminate within tiny budgets, from any request to the account of its plies; what was
 * understood is written down and must be understood again. */
#include "encode.h"

#include "api/json/text.h"
#include "api/laminate/account.h"
#include "api/laminate/run.h"
#include "api/run.h"
#include <string.h>

enum {
    NETS = 8 /* that are draped, at the most */
};

static void expect_round_trip(const struct laminate *laminate, struct arena *arena) {
    struct laminate again;
    struct api_problem problem = {0};
    const char *text = laminate_normalise(laminate, arena), *second;
    if (!text)
        return; /* out of memory */
    const struct api_input input = {.request = text, .request_length = strlen(text)};
    enum api_problem_id id = laminate_decode(&input, &fuzz_limits, arena, &again, &problem);
    if (id == API_OUT_OF_MEMORY || id == API_TOO_LARGE)
        return;
    FUZZ_PROMISE(id == API_OK);
    second = laminate_normalise(&again, arena);
    FUZZ_PROMISE(!second || strcmp(text, second) == 0);
}

/* Drapes the nets and accounts for the plies. */
static void drape_all(const struct laminate *laminate, const struct api_input *input,
                      struct arena *arena) {
    struct fuzz_bytes containers[NETS] = {0};
    struct api_memory memories[NETS];
    struct api_reader readers[NETS];
    const struct api_reader *nets[NETS] = {0};
    struct api_problem problems[NETS] = {0}, problem = {0};
    for (size_t n = 0; n < laminate->net_count; n++) {
        int looks = 0;
        const struct drape_monitor monitor = {fuzz_go_on, &looks};
        const struct api_sink sink = {.write = fuzz_append, .context = &containers[n]};
        enum api_problem_id id =
            laminate_run(laminate, n, input, &fuzz_limits, &monitor, &sink, &problems[n]);
        FUZZ_PROMISE(id == problems[n].id && id != API_INTERNAL);
        memories[n] = (struct api_memory){(const char *)containers[n].data, containers[n].size};
        readers[n] = api_reader_of(&memories[n]);
        if (id == API_OK)
            nets[n] = &readers[n];
    }
    struct api_text text = api_text_growing(arena);
    enum api_problem_id id = laminate_account_write(laminate, nets, problems, &text, &problem);
    FUZZ_PROMISE(id == problem.id && id != API_INTERNAL);
    for (size_t n = 0; n < NETS; n++)
        free(containers[n].data);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    struct laminate laminate;
    struct api_problem problem = {0};
    fuzz_prepare();
    struct arena *arena = arena_new(fuzz_limits.max_memory);
    const struct api_input input = {.request = (const char *)data, .request_length = size};
    enum api_problem_id id = laminate_decode(&input, &fuzz_limits, arena, &laminate, &problem);
    FUZZ_PROMISE(id == problem.id && id != API_INTERNAL);
    if (id == API_OK) {
        expect_round_trip(&laminate, arena);
        if (laminate.surface.kind != API_SURFACE_NAMED)
            id = laminate_resolve(&laminate, &fuzz_limits, arena, &problem);
        FUZZ_PROMISE(id == problem.id && id != API_INTERNAL);
        if (id == API_OK && laminate.surface.kind != API_SURFACE_NAMED &&
            laminate.net_count <= NETS)
            drape_all(&laminate, &input, arena);
    }
    arena_free(arena);
    return 0;
}
