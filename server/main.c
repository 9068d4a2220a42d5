/* SPDX-License-Identifier: MIT */
/*
 * draped: the daemon. Opens the store, starts the dispatcher and the HTTP front, prints on stdout
 * where it listens, notifies the service manager, waits for a signal, and takes everything down in
 * the opposite order.
 */
#include "api/run.h"
#include "backup.h"
#include "config.h"
#include "healthcheck.h"
#include "id.h"
#include "job_events.h"
#include "log.h"
#include "server/http/http.h"
#include "server/http/tokens.h"
#include "server/resources/routes.h"
#include "server/store/store.h"
#include "server/work/dispatcher.h"
#include "server/work/document_pool.h"
#include "server/work/fork_server.h"
#include "server/work/form_cache.h"
#include "server/work/worker.h"
#include "status.h"
#include "systemd.h"
#include <errno.h>
#include <limits.h>
#include <malloc.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum {
    EXIT_FAILED = 1,
    EXIT_USAGE = 2,
    REMOTE_PROGRESS_MS = 1000,
    REMOTE_SWEEP_MS = 1000,
    STOP_SECONDS = 28,           /* whatever hangs at the end, the process does not outlive this */
    LARGE_BLOCK = 1024 * 1024,   /* bytes; such memory goes back to the system when it is freed */
    KEPT_MOST = 4 * LARGE_BLOCK, /* of smaller ones, by each arena */
    ARENAS_MOST = 4              /* by itself eight a processor, which all fill in time */
};

/* What runs; NULL: not yet. */
struct service {
    const struct config *config;
    struct job_events *events;
    struct store *store;
    struct dispatcher *dispatcher;
    struct document_pool *document_pool;
    struct form_cache *forms;
    struct tokens *tokens;
    struct services services; /* the above, for the handlers */
    struct http *http;
};

/* Logs the reason why the daemon does not start; always false. */
static bool refuse(const char *what, const char *why) {
    log_error(log_event("start_failed"), log_text("what", what), log_text("why", why));
    return false;
}

/* ------------------------------------------------------------------ signals */

/* Those that stop, and SIGHUP. */
static sigset_t waited_signals(void) {
    sigset_t signals;
    sigemptyset(&signals);
    sigaddset(&signals, SIGTERM);
    sigaddset(&signals, SIGINT);
    sigaddset(&signals, SIGHUP);
    return signals;
}

static void end_at_once(int number) {
    (void)number;
    _exit(0); /* the store need not be closed: what runs is taken up again at the next start */
}

/* Returns at the first signal that stops; from then on a second one ends the process at once, even
 * where a shell has started us with signals ignored. Until then it notifies the service manager
 * that the daemon is alive whenever the daemon answers a request through its own front door: twice
 * as often as it must, so that one late answer does not count. The request does not reach the
 * store: a restart does not mend a database that is away. */
static void wait_for_signal(struct service *service) {
    int64_t half_ms = systemd_watchdog_ms(), every_ms = half_ms > 1 ? half_ms / 2 : half_ms;
    const struct timespec step = {every_ms / 1000, every_ms % 1000 * 1000000};
    sigset_t signals = waited_signals();
    int number = 0;
    while (number != SIGTERM && number != SIGINT) {
        char why[TOKENS_WHY_SIZE];
        number = sigtimedwait(&signals, NULL, every_ms ? &step : NULL);
        if (number == SIGHUP) {
            /* A file that cannot be used changes nothing: the tokens of before stay valid. */
            systemd_reloading();
            if (service->tokens && tokens_reload(service->tokens, why))
                log_info(log_event("tokens_read"),
                         log_int("tokens", (int64_t)tokens_count(service->tokens)));
            else if (service->tokens)
                log_error(log_event("tokens_kept"), log_text("why", why));
            systemd_ready();
        } else if (number < 0 && errno == EAGAIN) {
            const char *silent = healthcheck_ask(service->config, http_port(service->http));
            if (silent)
                log_error(log_event("no_answer"), log_text("path", "/healthz"),
                          log_text("why", silent));
            else
                systemd_alive();
        }
    }
    log_info(log_event("stopping"), log_text("signal", number == SIGTERM ? "SIGTERM" : "SIGINT"));
    signal(SIGALRM, end_at_once);
    alarm(STOP_SECONDS);
    signal(SIGTERM, SIG_DFL);
    signal(SIGINT, SIG_DFL);
    signal(SIGHUP, SIG_IGN);
    pthread_sigmask(SIG_UNBLOCK, &signals, NULL);
}

/* ------------------------------------------------------------------ the store */

/* Like mkdir -p. */
static bool make_folder(const char *folder) {
    char path[PATH_MAX];
    size_t length = strlen(folder);
    if (length + 1 > sizeof path)
        return refuse(folder, "the name is too long");
    memcpy(path, folder, length + 1);
    for (size_t k = 1; k <= length; k++) {
        if (path[k] != '/' && path[k] != '\0')
            continue;
        path[k] = '\0';
        if (mkdir(path, 0700) != 0 && errno != EEXIST)
            return refuse(folder, strerror(errno));
        path[k] = folder[k];
    }
    if (access(folder, W_OK | X_OK) != 0)
        return refuse(folder, strerror(errno));
    return true;
}

static bool open_store(struct service *service) {
    const struct config *config = service->config;
    struct store_options options = store_options_default;
    char url[PATH_MAX];
    char why[STORE_WHY_SIZE];
    options.queue_limit = config->queue_limit;
    options.owner_running = config->owner_running;
    options.retention_us = config->retention * INT64_C(3600) * 1000000;
    options.records_us = config->retention_jobs * INT64_C(3600) * 1000000;
    options.retention_bytes = config->retention_bytes;
    options.lease_us = config->lease * 1000000;
    options.shared = config->role != CONFIG_ROLE_ALL;
    if ((!config->store[0] && !make_folder(config->data)) || !config_store_url(config, url))
        return refuse("store", "it cannot be found");
    service->store = store_open(url, &options, service->events, why);
    return service->store || refuse("store", why);
}

/* ------------------------------------------------------------------ start and stop */

/* A daemon of the role `api` sweeps as well: the workers may all be gone. Of what many machines
 * write to one database the progress is the bulk, so that there it is stored less often. */
static bool start_dispatcher(struct service *service) {
    const struct config *config = service->config;
    static const char *const roles[] = {
        [CONFIG_ROLE_ALL] = "all", [CONFIG_ROLE_API] = "api", [CONFIG_ROLE_WORKER] = "worker"};
    struct dispatcher_settings settings = dispatcher_settings_default();
    settings.role = roles[config->role];
    settings.workers = config->role == CONFIG_ROLE_API ? 0 : (int)config->workers;
    settings.renew_ms = config->lease * 1000 / 4;
    if (store_url_remote(config->store)) {
        settings.progress_ms = REMOTE_PROGRESS_MS;
        settings.sweep_ms = REMOTE_SWEEP_MS;
    }
    settings.job_timeout_ms = config->job_timeout * 1000;
    settings.max_result = config->max_result;
    settings.forms = service->forms;
    settings.limits = config_limits(config, (int)config->threads_per_job);
    service->dispatcher = dispatcher_start(service->store, service->events, &settings);
    return service->dispatcher || refuse("workers", "their threads cannot be started");
}

static bool start_front(struct service *service) {
    const struct config *config = service->config;
    /* As many processes of each queue as there are cores, and two at least: a slow one is then
     * never alone. */
    long cores = sysconf(_SC_NPROCESSORS_ONLN);
    int processes = cores < 2                             ? 2
                    : cores > DOCUMENT_POOL_PROCESSES_MAX ? DOCUMENT_POOL_PROCESSES_MAX
                                                          : (int)cores;
    const struct document_pool_settings pool = {
        .fast = processes,
        .slow = processes,
        .memory = config->check_memory,
        .timeout_ms = config->check_timeout * 1000,
        .map_timeout_ms = config->job_timeout * 1000,
        .import_timeout_ms = config->import_timeout * 1000,
        .turn_ms = DOCUMENT_POOL_TURN_MS,
        .max_output = config->max_result,
        .folder = access(config->data, W_OK | X_OK) == 0 ? config->data : "",
        .memory_flag = "check-memory",
    };
    if (config->role != CONFIG_ROLE_WORKER)
        service->document_pool = document_pool_start(service->events, &pool);
    if (config->role != CONFIG_ROLE_WORKER && !service->document_pool)
        return refuse("document checkers", "their threads cannot be started");
    char why[TOKENS_WHY_SIZE];
    service->tokens = config->tokens[0] ? tokens_open(config->tokens, why) : NULL;
    if (config->tokens[0] && !service->tokens)
        return refuse("tokens", why);
    service->services = (struct services){
        .config = config,
        .store = service->store,
        .tokens = service->tokens,
        .document_pool = service->document_pool,
        .forms = service->forms,
        .dispatcher = config->role == CONFIG_ROLE_API ? NULL : service->dispatcher,
    };
    const struct http_settings settings = {config, service->events,
                                           routes_handler(&service->services)};
    return http_start(&settings, &service->http);
}

static int serve(const struct config *config) {
    struct service service = {.config = config};
    log_init((enum log_level)config->log_level);
    /* By itself the C library raises this as it goes, and then keeps what a large map had. */
    mallopt(M_MMAP_THRESHOLD, LARGE_BLOCK);
    mallopt(M_TRIM_THRESHOLD, KEPT_MOST);
    mallopt(M_ARENA_MAX, ARENAS_MOST);
    umask(077); /* what customers sent is for this user alone */
    /* Threads inherit that the signals wait for the main thread. A full disk and a closed
     * connection are reported by errno, not by a signal. */
    sigset_t signals = waited_signals();
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN);
    signal(SIGUSR1, SIG_IGN); /* from programs that rotate logs; there is no file to reopen */
    pthread_sigmask(SIG_BLOCK, &signals, NULL);
    bool good = (api_prepare() && id_init()) || refuse("random numbers", "the system gives none");
    if (good)
        service.events = job_events_new();
    service.forms = form_cache_new();
    good = good && (service.events || refuse("memory", strerror(errno))) && open_store(&service) &&
           fork_server_open() && start_dispatcher(&service) && start_front(&service);
    if (good) {
        /* The one line on stdout, for the process that started this one and waits for it. */
        uint16_t port = http_port(service.http);
        int host = (int)(strrchr(config->listen, ':') - config->listen);
        printf("draped listening on http://%.*s:%u\n", host, config->listen, port);
        fflush(stdout);
        log_info(log_event("ready"), log_text("version", DRAPE_VERSION),
                 log_text("listen", config->listen), log_int("port", port),
                 log_int("workers", config->role == CONFIG_ROLE_API ? 0 : config->workers));
        systemd_ready();
        wait_for_signal(&service);
        systemd_stopping();
    }
    /* Requests that wait for a running drape still get it: the front goes after the dispatcher,
     * which it may look at until then. */
    if (service.http)
        http_drain(service.http);
    dispatcher_stop(service.dispatcher, config->drain_timeout * 1000);
    http_stop(service.http);
    document_pool_stop(service.document_pool);
    fork_server_close();
    tokens_free(service.tokens);
    form_cache_free(service.forms);
    dispatcher_free(service.dispatcher);
    store_close(service.store);
    job_events_free(service.events);
    if (good)
        log_info(log_event("stopped"));
    return good ? 0 : EXIT_FAILED;
}

int main(int argc, char **argv) {
    static const struct fork_server_role roles[] = {{WORKER_ARGUMENT, worker_main},
                                                    {CHECKER_ARGUMENT, checker_main}};
    struct config config;
    if (argc == 2 && !strcmp(argv[1], FORK_SERVER_ARGUMENT))
        return fork_server_serve(argv, roles, sizeof roles / sizeof *roles);
    if (argc == 2 && !strcmp(argv[1], WORKER_ARGUMENT))
        return worker_main();
    if (argc == 2 && !strcmp(argv[1], CHECKER_ARGUMENT))
        return checker_main();
    if (argc >= 2 && !strcmp(argv[1], "hash-token"))
        return id_init() ? tokens_command(argc, argv, stdin, stdout, stderr) : EXIT_FAILED;
    if (argc >= 2 && !strcmp(argv[1], "backup"))
        return id_init() ? backup_command(argc, argv) : EXIT_FAILED;
    if (argc >= 2 && !strcmp(argv[1], "restore"))
        return id_init() ? restore_command(argc, argv) : EXIT_FAILED;
    if (argc >= 2 && !strcmp(argv[1], "status"))
        return id_init() ? status_command(argc, argv) : EXIT_FAILED;
    if (argc >= 2 && !strcmp(argv[1], "check"))
        return id_init() ? check_command(argc, argv) : EXIT_FAILED;
    switch (config_parse(argc, argv, &config)) {
    case CONFIG_DONE:
        return 0;
    case CONFIG_PROBE:
        return healthcheck_passes(&config) ? 0 : EXIT_FAILED;
    case CONFIG_BAD:
        return EXIT_USAGE;
    case CONFIG_RUN:
        break;
    }
    return serve(&config);
}
