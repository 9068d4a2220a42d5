/* SPDX-License-Identifier: MIT */
/* The service about itself: description, limits, health, version, counters. */
#include "handlers.h"
#include "openapi_json.h"
#include "routes.h"
#include "server/clock.h"
#include "server/config.h"
#include "server/metrics.h"
#include "server/work/dispatcher.h"
#include <stdio.h>
#include <string.h>

enum http_next meta_openapi(struct call *call) {
    reply_literal(call->reply, 200, "application/json", openapi_json, sizeof openapi_json - 1);
    return HTTP_DONE;
}

enum http_next meta_limits(struct call *call) {
    reply_text(call->reply, 200, "application/json", config_limits_json(call->services->config));
    return HTTP_DONE;
}

enum http_next meta_health(struct call *call) {
    static const char alive[] = "{\"status\":\"ok\"}";

    reply_literal(call->reply, 200, "application/json", alive, sizeof alive - 1);
    return HTTP_DONE;
}

enum http_next meta_ready(struct call *call) {
    static const char ready[] = "{\"status\":\"ready\"}";
    enum store_answer answer = store_ping(call->services->store);
    if (answer != STORE_OK)
        return call_store_failed(call, answer);
    if (call->request->draining)
        return call_draining(call);
    reply_literal(call->reply, 200, "application/json", ready, sizeof ready - 1);
    return HTTP_DONE;
}

enum http_next meta_version(struct call *call) {
    static const char version[] = "{\"name\":\"draped\",\"version\":\"" DRAPE_VERSION
                                  "\",\"solver_version\":\"" DRAPE_VERSION "\"}";

    reply_literal(call->reply, 200, "application/json", version, sizeof version - 1);
    return HTTP_DONE;
}

/* ------------------------------------------------------------------ metrics */

static void write_metric_head(FILE *out, const char *name, const char *type, const char *help) {
    fprintf(out, "# HELP %s %s\n# TYPE %s %s\n", name, help, name, type);
}

static void write_metric(FILE *out, const char *name, const char *type, const char *help,
                         int64_t value) {
    write_metric_head(out, name, type, help);
    fprintf(out, "%s %lld\n", name, (long long)value);
}

/* `labels` ends with a comma, or is empty. */
static void write_times(FILE *out, const char *name, const char *labels, size_t times) {
    struct metrics_histogram histogram;
    if (!metrics_histogram(times, &histogram) && labels[0])
        return;
    for (size_t k = 0; k + 1 < METRICS_BOUNDS; k++)
        fprintf(out, "%s_bucket{%sle=\"%g\"} %ld\n", name, labels, histogram.bounds[k],
                histogram.counts[k]);
    long all = histogram.counts[METRICS_BOUNDS - 1];
    int bare = labels[0] ? (int)strlen(labels) - 1 : 0;
    const char *open = labels[0] ? "{" : "", *close = labels[0] ? "}" : "";
    fprintf(out, "%s_bucket{%sle=\"+Inf\"} %ld\n", name, labels, all);
    fprintf(out, "%s_sum%s%.*s%s %.6f\n", name, open, bare, labels, close, histogram.sum);
    fprintf(out, "%s_count%s%.*s%s %ld\n", name, open, bare, labels, close, all);
}

static void write_answers(FILE *out) {
    static const char *const kinds[][2] = {
        {"draped_queue_seconds", "Time of drapes from submission to a worker."},
        {"draped_solve_seconds", "Time on a worker of drapes that gave a result."},
        {"draped_encode_seconds", "Time spent encoding a document that is sent."}};
    const char *name = "draped_http_request_seconds", *method, *pattern;
    int status;
    long count;
    write_metric_head(
        out, "draped_http_requests_total", "counter",
        "Answers by route and status; status 0 when the caller had closed the connection.");
    for (size_t route = 0; routes_describe(route, &method, &pattern); route++)
        for (size_t k = 0; metrics_answers(route, k, &status, &count); k++)
            if (count)
                fprintf(out,
                        "draped_http_requests_total{method=\"%s\",route=\"%s\",status=\"%d\"} "
                        "%ld\n",
                        method, pattern, status, count);
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++) {
        write_metric_head(out, kinds[k][0], "histogram", kinds[k][1]);
        write_times(out, kinds[k][0], "", k);
    }
    write_metric_head(out, name, "histogram",
                      "Time of answers from the first header to the last byte.");
    for (size_t route = 0; routes_describe(route, &method, &pattern); route++) {
        char labels[128];
        snprintf(labels, sizeof labels, "method=\"%s\",route=\"%s\",", method, pattern);
        write_times(out, name, labels, METRICS_ROUTE + route);
    }
}

static void write_jobs(FILE *out, const struct store_counts *counts) {
    write_metric_head(out, "draped_jobs", "gauge", "Drapes in the store by status.");
    for (int k = 0; k < STORE_STATUS_COUNT; k++)
        fprintf(out, "draped_jobs{status=\"%s\"} %lld\n", store_status_name((enum store_status)k),
                (long long)counts->jobs[k]);
    write_metric_head(out, "draped_store_drapes_total", "counter",
                      "Drapes that have ended in the store, on whatever host, by how.");
    for (int k = STORE_SUCCEEDED; k < STORE_STATUS_COUNT; k++)
        fprintf(out, "draped_store_drapes_total{outcome=\"%s\"} %lld\n",
                store_status_name((enum store_status)k), (long long)counts->ended[k]);
    write_metric(out, "draped_store_crashed_total", "counter",
                 "Of the failed ones, those whose workers died at every attempt.", counts->crashed);
    write_metric_head(out, "draped_store_tasks", "gauge", "Tasks of studies by status.");
    for (int k = STORE_QUEUED; k <= STORE_RUNNING; k++)
        fprintf(out, "draped_store_tasks{status=\"%s\"} %lld\n",
                store_status_name((enum store_status)k), (long long)counts->tasks[k]);
    write_metric(out, "draped_store_hosts", "gauge",
                 "Daemons that wrote to the store in the last 30 s.", counts->hosts);
    write_metric(out, "draped_store_workers", "gauge", "Worker processes of all of them.",
                 counts->workers);
    write_metric(out, "draped_store_workers_busy", "gauge", "Of these, those that are solving.",
                 counts->busy);
    write_metric(out, "draped_queue_depth", "gauge",
                 "Drapes, studies and tasks that wait for a worker.",
                 counts->jobs[STORE_QUEUED] + counts->tasks[STORE_QUEUED]);
    /* By our clock; a database on another machine has its own. */
    int64_t age_us = counts->oldest_queued ? clock_utc_us() - counts->oldest_queued : 0;
    write_metric_head(out, "draped_queue_age_seconds", "gauge",
                      "Time since which the oldest of them waits.");
    fprintf(out, "draped_queue_age_seconds %.3f\n", age_us > 0 ? (double)age_us / 1e6 : 0);
}

enum http_next meta_metrics(struct call *call) {
    struct store_counts counts;
    struct work_counts work;
    char *text = NULL;
    size_t length;
    FILE *out = open_memstream(&text, &length);

    if (out) {
        write_metric_head(out, "draped_build_info", "gauge",
                          "The version that runs, in the labels; the value is 1.");
        fputs("draped_build_info{version=\"" DRAPE_VERSION "\",solver_version=\"" DRAPE_VERSION
              "\"} 1\n",
              out);
        write_answers(out);
        write_metric_head(out, "draped_rejections_total", "counter",
                          "Answers that are problems, by reason.");
        for (enum api_problem_id k = API_OK + 1; k < API_PROBLEM_COUNT; k++)
            if (metrics_refused(k))
                fprintf(out, "draped_rejections_total{reason=\"%s\"} %ld\n", api_problem_slug(k),
                        metrics_refused(k));
        write_metric_head(out, "draped_store_errors_total", "counter",
                          "Statements that failed in the database.");
        for (int busy = 0; busy < 2; busy++)
            fprintf(out, "draped_store_errors_total{kind=\"%s\"} %ld\n", busy ? "busy" : "down",
                    metrics_store_failures(busy));
        write_metric(out, "draped_store_altered_total", "counter",
                     "Requests, results and surfaces that were read and are not what was written.",
                     metrics_store_alterations());
        write_metric(out, "process_resident_memory_bytes", "gauge",
                     "Memory of the daemon without workers.", metrics_resident());
        write_metric(out, "process_open_fds", "gauge", "Descriptors that the daemon has open.",
                     metrics_descriptors());
        write_metric(out, "draped_store_up", "gauge", "Whether the store can be read and written.",
                     store_ping(call->services->store) == STORE_OK);
        if (store_counts(call->services->store, &counts) == STORE_OK)
            write_jobs(out, &counts);
        if (call->services->dispatcher) {
            dispatcher_stats(call->services->dispatcher, &work);
            write_metric(out, "draped_workers", "gauge", "Worker processes of this daemon.",
                         call->services->config->workers);
            write_metric(out, "draped_workers_busy", "gauge", "Worker processes that are solving.",
                         work.busy);
            write_metric_head(out, "draped_drapes_total", "counter",
                              "Drapes that ended in this process, by how.");
#define X(name, help)                                                                              \
    fprintf(out, "draped_drapes_total{outcome=\"" #name "\"} %lld\n", (long long)work.name);
            WORK_OUTCOMES(X)
#undef X
#define X(name, help)                                                                              \
    write_metric(out, "draped_worker_" #name "_total", "counter", help, work.name);
            WORK_EVENTS(X)
#undef X
        }
        fclose(out);
    }
    reply_text(call->reply, 200, "text/plain; version=0.0.4; charset=utf-8", text);
    return HTTP_DONE;
}
