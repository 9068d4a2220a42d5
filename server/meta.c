/* SPDX-License-Identifier: MIT */
/* The service about itself: description, limits, health, version, counters. */
#include "config.h"
#include "dispatcher.h"
#include "metrics.h"
#include "openapi_json.h"
#include "resources.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum routes_next meta_openapi(const struct http_services *services, struct request *request,
                              struct reply *reply) {
    (void)services, (void)request;
    reply_literal(reply, 200, "application/json", openapi_json, sizeof openapi_json - 1);
    return ROUTES_DONE;
}

enum routes_next meta_limits(const struct http_services *services, struct request *request,
                             struct reply *reply) {
    (void)request;
    reply_text(reply, 200, "application/json", config_limits_json(services->config));
    return ROUTES_DONE;
}

enum routes_next meta_health(const struct http_services *services, struct request *request,
                             struct reply *reply) {
    static const char alive[] = "{\"status\":\"ok\"}";
    (void)services, (void)request;
    reply_literal(reply, 200, "application/json", alive, sizeof alive - 1);
    return ROUTES_DONE;
}

enum routes_next meta_ready(const struct http_services *services, struct request *request,
                            struct reply *reply) {
    static const char ready[] = "{\"status\":\"ready\"}";
    enum store_answer answer = store_ping(services->store);
    if (answer != STORE_OK)
        return resources_store_failed(request, reply, answer);
    if (request->draining)
        return resources_draining(request, reply);
    reply_literal(reply, 200, "application/json", ready, sizeof ready - 1);
    return ROUTES_DONE;
}

enum routes_next meta_version(const struct http_services *services, struct request *request,
                              struct reply *reply) {
    static const char version[] = "{\"name\":\"draped\",\"version\":\"" DRAPED_VERSION
                                  "\",\"solver_version\":\"" DRAPE_SOLVER_VERSION "\"}";
    (void)services, (void)request;
    reply_literal(reply, 200, "application/json", version, sizeof version - 1);
    return ROUTES_DONE;
}

/* ------------------------------------------------------------------ metrics */

static void head(FILE *out, const char *name, const char *type, const char *help) {
    fprintf(out, "# HELP %s %s\n# TYPE %s %s\n", name, help, name, type);
}

static void write_route(void *context, size_t route, int status, long count) {
    const char *method, *pattern;
    if (routes_describe(route, &method, &pattern))
        fprintf(context,
                "draped_http_requests_total{method=\"%s\",route=\"%s\",status=\"%d\"} %ld\n",
                method, pattern, status, count);
}

static void write_jobs(FILE *out, const struct store_counts *counts) {
    head(out, "draped_jobs", "gauge", "Drapes in the store by status.");
    for (int k = 0; k < STORE_STATUS_COUNT; k++)
        fprintf(out, "draped_jobs{status=\"%s\"} %lld\n", store_status_name((enum store_status)k),
                (long long)counts->jobs[k]);
    head(out, "draped_queue_depth", "gauge", "Drapes that wait for a worker.");
    fprintf(out, "draped_queue_depth %lld\n", (long long)counts->jobs[STORE_QUEUED]);
}

static void write_counter(FILE *out, const char *name, const char *help, int64_t value) {
    head(out, name, "counter", help);
    fprintf(out, "%s %lld\n", name, (long long)value);
}

static void write_workers(FILE *out, struct dispatcher *dispatcher, int64_t workers) {
    struct dispatcher_stats stats;
    dispatcher_stats(dispatcher, &stats);
    head(out, "draped_workers", "gauge", "Worker processes of this daemon.");
    fprintf(out, "draped_workers %lld\n", (long long)workers);
    head(out, "draped_workers_busy", "gauge", "Worker processes that are solving.");
    fprintf(out, "draped_workers_busy %lld\n", (long long)stats.busy);
    head(out, "draped_drapes_total", "counter", "Drapes that ended in this process, by how.");
    fprintf(out, "draped_drapes_total{outcome=\"succeeded\"} %lld\n", (long long)stats.succeeded);
    fprintf(out, "draped_drapes_total{outcome=\"failed\"} %lld\n", (long long)stats.failed);
    fprintf(out, "draped_drapes_total{outcome=\"reused\"} %lld\n", (long long)stats.reused);
    fprintf(out, "draped_drapes_total{outcome=\"stopped\"} %lld\n", (long long)stats.stopped);
    write_counter(out, "draped_worker_crashes_total", "Workers that died on their own.",
                  stats.crashes);
    write_counter(out, "draped_worker_timeouts_total", "Workers killed for taking too long.",
                  stats.timeouts);
    write_counter(out, "draped_worker_restarts_total", "Workers started in place of another.",
                  stats.restarts);
}

enum routes_next meta_metrics(const struct http_services *services, struct request *request,
                              struct reply *reply) {
    struct store_counts counts;
    char *text = NULL;
    size_t length;
    FILE *out = open_memstream(&text, &length);
    (void)request;
    if (out) {
        head(out, "draped_build_info", "gauge", "The version that runs, as labels of 1.");
        fputs("draped_build_info{version=\"" DRAPED_VERSION
              "\",solver_version=\"" DRAPE_SOLVER_VERSION "\"} 1\n",
              out);
        head(out, "draped_http_requests_total", "counter", "Answers by route and status.");
        metrics_each(write_route, out);
        bool up = store_counts(services->store, &counts) == STORE_OK;
        head(out, "draped_store_up", "gauge", "Whether the store answers.");
        fprintf(out, "draped_store_up %d\n", up);
        if (up)
            write_jobs(out, &counts);
        if (services->dispatcher)
            write_workers(out, services->dispatcher, services->config->workers);
        fclose(out);
    }
    reply_text(reply, 200, "text/plain; version=0.0.4; charset=utf-8", text);
    return ROUTES_DONE;
}
