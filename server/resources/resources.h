/* SPDX-License-Identifier: MIT */
/*
 * The handlers of the table in `routes.c`, one file a resource, and what they share. All have the
 * contract of `routes_handler`.
 */
#ifndef SERVER_RESOURCES_RESOURCES_H
#define SERVER_RESOURCES_RESOURCES_H

#include "api/format/format.h"
#include "api/limits.h"
#include "routes.h"
#include "server/store/store.h"

typedef enum routes_next routes_handler(const struct http_services *services,
                                        struct request *request, struct reply *reply);

enum {
    RESOURCES_WAIT_MAX = 60, /* seconds a call may wait */
    RESOURCES_PAGE = 50,     /* entries of a list when the caller does not say */
    RESOURCES_PAGE_MAX = 1000
};

/* drapes.c */
routes_handler drapes_create, drapes_list, drapes_status, drapes_request, drapes_cancel,
    drapes_delete;
/* events.c */
routes_handler events_stream;
/* results.c */
routes_handler results_get, results_pattern;
/* maps.c */
routes_handler maps_create;
/* surfaces.c */
routes_handler surfaces_create, surfaces_list, surfaces_get, surfaces_delete;
/* meta.c */
routes_handler meta_openapi, meta_limits, meta_health, meta_ready, meta_version, meta_metrics;
/* viewer.c */
routes_handler viewer_page, viewer_file;

/* Method and pattern of the route with that number of `metrics_count`; the last stands for requests
 * without a route. False beyond it. */
bool routes_describe(size_t route, const char **method, const char **pattern);

/* What one job may cost, by the configuration. */
struct api_limits resources_limits(const struct http_services *services);

/* Whose things the caller sees, as the store takes it: NULL for everybody's. */
const char *resources_owner(const struct request *request);

/* 503 for a store that is busy or down; also for answers that should not occur. */
enum routes_next resources_store_failed(const struct request *request, struct reply *reply,
                                        enum store_answer answer);

/* 503 for work that comes too late. */
enum routes_next resources_draining(const struct request *request, struct reply *reply);

/* Reads the job of the path, which for others than its owner is not there. False: the reply says
 * why not. Otherwise the caller clears it. */
bool resources_job(const struct http_services *services, const struct request *request,
                   struct reply *reply, struct store_job *job);

/* 404 for the path's id. */
enum routes_next resources_not_found(const struct request *request, struct reply *reply,
                                     const char *what);

/* A list's `limit` and `cursor` of the query. False: the reply says what is wrong. */
bool resources_page(const struct request *request, struct reply *reply, int *limit,
                    int64_t *cursor);

/* When a handler that waits since `begun` should look at the store for itself, now being `now`:
 * often at first, more seldom later, because the hub tells of nearly everything. */
int64_t resources_poll_at(int64_t begun, int64_t now);

/* The format of a document that a caller wants: by `?format=`, else by Accept. NULL: the reply says
 * 406. */
const struct format *resources_format(const struct request *request, struct reply *reply,
                                      enum format_use use);

/* How a caller wants a document. */
struct results_choice {
    const struct format *format;
    struct format_options options; /* points into the request */
};

/* Reads it of the request. False: the reply says what is wrong (406, 422). */
bool results_choose(const struct request *request, struct reply *reply, enum format_use use,
                    struct results_choice *choice);

/* Whether there is a result. False: the reply says why not, with the drape's own problem if it
 * failed. */
bool results_ready(const struct request *request, const struct store_job *job, struct reply *reply);

/* Answers with the result of a job that has ended, or with the problem it ended with. */
void results_reply(const struct http_services *services, const struct request *request,
                   const struct store_job *job, const struct results_choice *choice,
                   struct reply *reply);

#endif
