/* SPDX-License-Identifier: MIT */
#include "status.h"
#include "config.h"
#include "log.h"
#include "server/store/survey.h"
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { FAILED = 1, USAGE = 2, ARGUMENTS = 64 };

static const char status_usage[] =
    "usage: draped status [--data DIR] [--store URL]\n\n"
    "Shows the queue, the hosts with their workers and when each last wrote to the store, and the\n"
    "drape that failed last. Exit status: 0; 1 when the store cannot be read, no host has written "
    "to\nit for half a minute, or drapes wait without workers; 2 for invalid arguments.\n";

static const char check_usage[] =
    "usage: draped check [--data DIR] [--store URL]\n\n"
    "Reads everything in the store, beside a daemon that uses it or without any, and lists the "
    "jobs,\nresults, surfaces, materials and links that are not what was written. Exit status: 0; "
    "1 when "
    "something is\ndamaged, or the store cannot be read; 2 for invalid arguments.\n";

static int64_t seconds(int64_t us) {
    return us > 0 ? us / 1000000 : 0;
}

/* 0 when the service can work. */
static int show_store(const char *url) {
    char why[STORE_WHY_SIZE], failed_at[32];
    struct tm date;
    struct survey *survey = malloc(sizeof *survey);
    if (!survey || !survey_store(url, survey, why)) {
        fprintf(stderr, "draped: %s\n", survey ? why : "no memory");
        free(survey);
        return FAILED;
    }
    printf("store    %s, schema %" PRId64 "\n", store_url_remote(url) ? "PostgreSQL" : "SQLite",
           survey->schema);
    const struct store_counts *counts = &survey->counts;
    printf("queue    %" PRId64 " waiting", counts->jobs[STORE_QUEUED]);
    if (counts->oldest_queued)
        printf(", the first for %" PRId64 " s", seconds(survey->now - counts->oldest_queued));
    printf(", %" PRId64 " running\n", counts->jobs[STORE_RUNNING]);
    if (counts->tasks[STORE_QUEUED] + counts->tasks[STORE_RUNNING] > 0)
        printf("tasks    %" PRId64 " of studies waiting, %" PRId64 " running\n",
               counts->tasks[STORE_QUEUED], counts->tasks[STORE_RUNNING]);
    printf("ended    %" PRId64 " succeeded, %" PRId64 " failed (%" PRId64 " by crashes), %" PRId64
           " cancelled\n",
           counts->ended[STORE_SUCCEEDED], counts->ended[STORE_FAILED], counts->crashed,
           counts->ended[STORE_CANCELLED]);
    printf("workers  %" PRId64 ", %" PRId64 " busy, on %" PRId64 " hosts\n", counts->workers,
           counts->busy, counts->hosts);
    for (size_t k = 0; k < survey->host_count; k++) {
        const struct store_host *host = &survey->hosts[k].host;
        int64_t silent = seconds(survey->now - survey->hosts[k].seen);
        printf("host     %s, %s, version %s, %" PRId64 " workers, %" PRId64 " busy, wrote %" PRId64
               " s ago%s\n",
               host->host, host->role, host->version, host->workers, host->busy, silent,
               silent > STORE_SEEN_SECONDS ? ": SILENT" : "");
    }
    time_t whole = (time_t)(survey->failed_at / 1000000);
    strftime(failed_at, sizeof failed_at, "%Y-%m-%dT%H:%M:%SZ", gmtime_r(&whole, &date));
    if (survey->failed[0])
        printf("failed   %s %s %s\n", survey->failed, failed_at, survey->error);
    else
        puts("failed   none");
    bool well = counts->hosts > 0 && (counts->jobs[STORE_QUEUED] == 0 || counts->workers > 0);
    puts(well                ? "verdict  well"
         : counts->hosts > 0 ? "verdict  drapes wait, and there are no workers"
                             : "verdict  no host has written to the store for half a minute");
    free(survey);
    return well && fflush(stdout) == 0 ? 0 : FAILED;
}

static void show_damage(const char *kind, const char *id, const char *what) {
    printf("damaged  %s%s%s: %s\n", kind, *id ? " " : "", id, what);
}

/* 0 when all is what was written. */
static int show_check(const char *url) {
    char why[STORE_WHY_SIZE];
    struct store_audit audit;
    if (!audit_store(url, show_damage, &audit, why)) {
        fprintf(stderr, "draped: the store cannot be read to its end: %s\n", why);
        return FAILED;
    }
    printf("read     %" PRId64 " jobs, %" PRId64 " results, %" PRId64 " surfaces, %" PRId64
           " materials, %" PRId64 " links, %.1f MB\n",
           audit.jobs, audit.results, audit.items[STORE_SURFACES], audit.items[STORE_MATERIALS],
           audit.items[STORE_LINKS], (double)audit.bytes / 1e6);
    if (audit.damaged > 0)
        printf("verdict  %" PRId64 " damaged: delete these and post them again, or restore a "
               "back-up\n",
               audit.damaged);
    else
        puts("verdict  well");
    return audit.damaged == 0 && fflush(stdout) == 0 ? 0 : FAILED;
}

/* A command whose arguments name a store. */
static int run_on_store(int argc, char **argv, const char *usage, int (*run)(const char *)) {
    struct config config;
    char url[PATH_MAX], *rest[ARGUMENTS];
    int count = argc > ARGUMENTS ? -1 : config_parse_store(argc - 2, argv + 2, &config, rest);
    if (count == 1 && !strcmp(rest[0], "--help")) {
        fputs(usage, stdout);
        return 0;
    }
    if (count != 0) {
        fputs(usage, stderr);
        return USAGE;
    }
    log_init(LOG_LEVEL_ERROR);
    return config_store_url(&config, url) ? run(url) : USAGE;
}

int status_command(int argc, char **argv) {
    return run_on_store(argc, argv, status_usage, show_store);
}

int check_command(int argc, char **argv) {
    return run_on_store(argc, argv, check_usage, show_check);
}
