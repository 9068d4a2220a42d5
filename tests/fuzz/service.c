/* SPDX-License-Identifier: MIT */
#include "service.h"

#include "api/run.h"
#include "encode.h"
#include "server/config.h"
#include "server/job_events.h"
#include "server/log.h"
#include "server/store/store.h"
#include "server/work/document_pool.h"
#include <string.h>
#include <unistd.h>

enum { BUDGET = 1 << 25 };

#define SURFACE                                                                                    \
    "{\"degree_u\":1,\"degree_v\":1,\"size_u\":2,\"size_v\":2,\"knotvector_u\":[0,0,1,1],"         \
    "\"knotvector_v\":[0,0,1,1],\"control_points\":[[0,0,0],[0,1,0],[1,0,0],[1,1,1]]}"

static char request[] = "{\"surface\":" SURFACE ",\"fabric\":{\"spacing\":0.3}}";

static const struct config config = {
    .role = CONFIG_ROLE_API,
    .cors_origin = "https://a.example",
    .public_name = "*",
    .queue_limit = 3,
    .max_body = 4096,
    .max_mesh = 8192,
    .max_nodes = 300,
    .max_control_points = 100,
    .max_elements = 500,
    .max_depth = 16,
    .job_memory = BUDGET,
};

static struct services services = {.config = &config};
static struct job_events *events;
static char folder[] = "/tmp/draped-fuzz-XXXXXX", path[sizeof folder + 16];
char service_drape[ID_SIZE], service_surface[] = "0123456789abcdef0123456789abcdef";

static bool write_result(void *writer, const void *bytes, size_t length) {
    return store_writer_append(writer, bytes, length) == STORE_OK;
}

static void solve(const struct store_claim *claim) {
    const struct api_input input = {.request = request, .request_length = sizeof request - 1};
    struct store_writer *writer = store_writer_new(services.store, claim);
    const struct api_sink sink = {.write = write_result, .context = writer};
    struct api_problem problem = {0};
    FUZZ_PROMISE(api_run(&input, &fuzz_limits, NULL, &sink, &problem) == API_OK);
    FUZZ_PROMISE(store_writer_commit(writer, "{}") == STORE_OK);
    store_writer_free(writer);
}

static void fill(void) {
    char definition[] = SURFACE, description[] = "{}";
    struct store_item surface = {.definition = definition,
                                 .definition_length = sizeof definition - 1,
                                 .description = description};
    const struct store_submission submission = {
        .request = request, .request_length = sizeof request - 1, .digest = "a"};
    struct store_receipt receipt;
    struct store_claim claim;
    bool created;
    memcpy(surface.id, service_surface, sizeof service_surface);
    FUZZ_PROMISE(store_item_put(services.store, STORE_SURFACES, &surface, &created) == STORE_OK);
    FUZZ_PROMISE(store_submit(services.store, &submission, &receipt) == STORE_OK);
    FUZZ_PROMISE(store_claim(services.store, &claim) == STORE_OK);
    memcpy(service_drape, receipt.id, ID_SIZE);
    solve(&claim);
}

void service_spoil(void) {
    document_pool_stop(services.document_pool);
    store_close(services.store);
    services.document_pool = NULL;
    services.store = NULL;
    unlink(path); /* closed, it is one file */
}

static void clear_away(void) {
    char lock[sizeof path + 8];
    snprintf(lock, sizeof lock, "%s-lock", path);
    service_spoil();
    job_events_free(events);
    unlink(lock);
    rmdir(folder);
}

/* Once in a process. */
static void prepare(void) {
    log_init((enum log_level)(LOG_LEVEL_ERROR + 1));
    FUZZ_PROMISE(api_prepare() && id_init() && mkdtemp(folder));
    snprintf(path, sizeof path, "%s/draped.db", folder);
    events = job_events_new();
    atexit(clear_away);
}

const struct services *service(void) {
    const struct document_pool_settings document_pool = {.fast = 1,
                                                         .slow = 1,
                                                         .memory = 8 * (int64_t)BUDGET,
                                                         .timeout_ms = 10000,
                                                         .map_timeout_ms = 10000,
                                                         .import_timeout_ms = 10000,
                                                         .max_output = BUDGET,
                                                         .folder = "",
                                                         .memory_flag = "check-memory"};
    char why[STORE_WHY_SIZE];
    if (!events)
        prepare();
    if (services.store)
        return &services;
    services.store = store_open(path, &store_options_default, events, why);
    FUZZ_PROMISE(services.store != NULL);
    services.document_pool = document_pool_start(events, &document_pool);
    FUZZ_PROMISE(services.document_pool != NULL);
    fill();
    return &services;
}

/* The pool starts this same program as its processes. */
int LLVMFuzzerInitialize(int *argc, char ***argv) {
    if (*argc == 2 && !strcmp((*argv)[1], CHECKER_ARGUMENT))
        exit(checker_main());
    return 0;
}
