/* SPDX-License-Identifier: MIT */
#include "routes.h"
#include "resources.h"
#include "server/config.h"
#include "server/http/access.h"
#include "server/http/negotiate.h"
#include "server/metrics.h"
#include <stdio.h>
#include <string.h>

enum {
    ROUTE_BODY = 1,  /* takes a JSON document */
    ROUTE_WORK = 2,  /* new work: not while draining */
    ROUTE_QUIET = 4, /* probes and scrapes: not worth a line of the log each */
    ROUTE_LOOSE = 8, /* takes any query */
    ROUTE_MESH = 16, /* takes a mesh, JSON or Nastran */
    ROUTE_OPEN = 32  /* for everybody, without a token */
};

struct route {
    const char *method, *pattern;
    routes_handler *handler;
    unsigned flags;
    const char *query[6]; /* the query parameters it knows, up to a NULL */
};

#define RESULT_QUERY "format", "table", "fields", "precision"
#define MAP_QUERY "format", "fields", "precision", "inlet_elements"

static const struct route routes[] = {
    {"POST", "/v1/drapes", drapes_create, ROUTE_BODY | ROUTE_WORK, {RESULT_QUERY}},
    {"GET", "/v1/drapes", drapes_list, 0, {"status", "limit", "cursor"}},
    {"GET", "/v1/drapes/{id}", drapes_status, 0, {"wait"}},
    {"DELETE", "/v1/drapes/{id}", drapes_delete, 0, {0}},
    {"GET", "/v1/drapes/{id}/result", results_get, 0, {RESULT_QUERY}},
    {"GET", "/v1/drapes/{id}/pattern", results_pattern, 0, {"format"}},
    {"GET", "/v1/drapes/{id}/request", drapes_request, 0, {0}},
    {"GET", "/v1/drapes/{id}/events", events_stream, 0, {0}},
    {"POST", "/v1/drapes/{id}/cancel", drapes_cancel, 0, {0}},
    {"POST", "/v1/drapes/{id}/map", maps_create, ROUTE_MESH | ROUTE_WORK, {MAP_QUERY}},
    {"POST", "/v1/surfaces", surfaces_create, ROUTE_BODY | ROUTE_WORK, {0}},
    {"GET", "/v1/surfaces", surfaces_list, 0, {"limit", "cursor"}},
    {"GET", "/v1/surfaces/{id}", surfaces_get, 0, {0}},
    {"DELETE", "/v1/surfaces/{id}", surfaces_delete, 0, {0}},
    {"GET", "/v1/openapi.json", meta_openapi, ROUTE_OPEN, {0}},
    {"GET", "/v1/limits", meta_limits, ROUTE_OPEN, {0}},
    {"GET", "/", viewer_page, ROUTE_LOOSE | ROUTE_OPEN, {0}},
    {"GET", "/viewer/{digest}/{file}", viewer_file, ROUTE_LOOSE | ROUTE_OPEN, {0}},
    {"GET", "/healthz", meta_health, ROUTE_QUIET | ROUTE_LOOSE | ROUTE_OPEN, {0}},
    {"GET", "/readyz", meta_ready, ROUTE_QUIET | ROUTE_LOOSE | ROUTE_OPEN, {0}},
    {"GET", "/version", meta_version, ROUTE_LOOSE | ROUTE_OPEN, {0}},
    {"GET", "/metrics", meta_metrics, ROUTE_QUIET | ROUTE_LOOSE, {0}},
};

enum { ROUTE_COUNT = sizeof routes / sizeof *routes };

_Static_assert((int)ROUTE_COUNT < (int)METRICS_ROUTES_MAX, "every route and `none` are counted");

/* ------------------------------------------------------------------ matching */

/* Whether the segments are those of the pattern; `*parameter` is what stands for {id},
 * for the last one if there are several. */
static bool match(const char *pattern, const struct request *request, const char **parameter) {
    size_t k = 0;
    *parameter = NULL;
    if (!strcmp(pattern, "/"))
        return request->segment_count == 0 && *request->target != '*';
    for (const char *part = pattern; *part; k++) {
        size_t length = strcspn(++part, "/");
        if (k == request->segment_count)
            return false;
        const char *segment = request->segments[k];
        if (*part == '{')
            *parameter = segment;
        else if (strlen(segment) != length || strncmp(segment, part, length) != 0)
            return false;
        part += length;
    }
    return k == request->segment_count;
}

/* HEAD is answered by whatever answers GET; the body is left out on the way. */
static bool method_matches(const struct route *route, const char *method) {
    return !strcmp(route->method, method) ||
           (!strcmp(method, "HEAD") && !strcmp(route->method, "GET"));
}

/* Sets the route. `allow` gets the methods of the path, "" when there is no such path. Who only
 * works is probed and scraped, no more. */
static void find_route(const struct http_services *services, struct request *request, char *allow,
                       size_t size) {
    bool works = services->config->role == CONFIG_ROLE_WORKER;
    size_t used = 0;
    *allow = '\0';
    for (size_t k = 0; k < ROUTE_COUNT; k++) {
        const char *parameter;
        if ((works && !(routes[k].flags & ROUTE_QUIET)) ||
            !match(routes[k].pattern, request, &parameter))
            continue;
        bool get = !strcmp(routes[k].method, "GET");
        used += (size_t)snprintf(allow + used, size - used, "%s%s", routes[k].method,
                                 get ? ", HEAD, " : ", ");
        if (method_matches(&routes[k], request->method)) {
            request->route = &routes[k];
            request->parameter = parameter;
        }
    }
    if (used)
        snprintf(allow + used, size - used, "OPTIONS");
}

/* ------------------------------------------------------------------ screening */

/* For a path without the method: 404, 405, or the answer to OPTIONS. */
static void refuse_route(const struct request *request, struct reply *reply, const char *allow) {
    bool options = !strcmp(request->method, "OPTIONS");
    if (options && !strcmp(request->target, "*")) {
        reply_empty(reply, 204);
        return;
    }
    if (!*allow) {
        reply_refuse(reply, request->id, API_NOT_FOUND,
                     "there is nothing at this path; GET /v1/openapi.json tells what there is");
        return;
    }
    reply_header(reply, "Allow", "%s", allow);
    if (options)
        reply_empty(reply, 204);
    else
        reply_refuse(reply, request->id, API_METHOD_NOT_ALLOWED, "this path takes %s", allow);
}

static bool known_parameter(const struct route *route, const char *name) {
    for (const char *const *known = route->query; *known; known++)
        if (!strcmp(*known, name))
            return true;
    return false;
}

static bool check_query(const struct request *request, struct reply *reply) {
    if (request->route->flags & ROUTE_LOOSE)
        return true;
    for (size_t k = 0; k < request->query_count; k++) {
        const char *name = request->query[k].name;
        bool known = known_parameter(request->route, name);
        if (known && request_query(request, name) == request->query[k].value)
            continue;
        reply_refuse(reply, request->id, API_INVALID_REQUEST,
                     known ? "the query parameter '%.64s' is there more than once"
                           : "this path has no query parameter '%.64s'",
                     name);
        return false;
    }
    return true;
}

/* A missing type passes: bare HTTP clients send none. Form types do not, since any web page may
 * make a browser send those here. */
static bool check_media_type(const struct request *request, struct reply *reply) {
    const char *type = request_header(request, "Content-Type");
    bool mesh = request->route->flags & ROUTE_MESH;
    if (!(request->route->flags & (ROUTE_BODY | ROUTE_MESH)) || !type || negotiate_is_json(type) ||
        (mesh && negotiate_is_type(type, "text/x-nastran")))
        return true;
    reply_header(reply, "Accept", "application/json%s", mesh ? ", text/x-nastran" : "");
    reply_refuse(reply, request->id, API_UNSUPPORTED_MEDIA_TYPE,
                 "the Content-Type is '%.64s' but must be application/json%s; with curl: -H "
                 "'Content-Type: application/json'",
                 type, mesh ? " or text/x-nastran" : "");
    return false;
}

/* What stores nothing is reading, a map of the caller's mesh as well. */
static enum tokens_role role_needed(const struct route *route) {
    return !strcmp(route->method, "GET") || route->flags & ROUTE_MESH ? TOKENS_READ : TOKENS_WRITE;
}

/* Answers that depend on who asks are not for caches that others use. */
static void mark(const struct http_services *services, const struct request *request,
                 struct reply *reply) {
    if (!(request->route->flags & ROUTE_OPEN))
        access_mark(services, reply);
}

bool routes_screen(const struct http_services *services, struct request *request,
                   struct reply *reply) {
    char allow[64];
    find_route(services, request, allow, sizeof allow);
    if (!request->route) {
        refuse_route(request, reply, allow);
        return true;
    }
    const struct route *route = request->route;
    bool good =
        (route->flags & ROUTE_OPEN || access_allow(services, request, role_needed(route), reply)) &&
        check_query(request, reply) && check_media_type(request, reply);
    if (good && request->draining && route->flags & ROUTE_WORK)
        resources_draining(request, reply);
    if (reply->status)
        mark(services, request, reply);
    return reply->status != 0;
}

struct routes_limit routes_limit(const struct http_services *services,
                                 const struct request *request) {
    if (request->route && request->route->flags & ROUTE_MESH)
        return (struct routes_limit){services->config->max_mesh, "max-mesh"};
    return (struct routes_limit){services->config->max_body, "max-body"};
}

enum routes_next routes_handle(const struct http_services *services, struct request *request,
                               struct reply *reply) {
    enum routes_next next = request->route->handler(services, request, reply);
    if (next == ROUTES_DONE)
        mark(services, request, reply);
    return next;
}

/* ------------------------------------------------------------------ counting */

static size_t route_number(const struct request *request) {
    return request && request->route ? (size_t)(request->route - routes) : ROUTE_COUNT;
}

void routes_count(const struct request *request, int status, int64_t us) {
    metrics_count(route_number(request), status, us);
}

bool routes_quiet(const struct request *request) {
    return request->route && (request->route->flags & ROUTE_QUIET);
}

bool routes_describe(size_t route, const char **method, const char **pattern) {
    *method = route < ROUTE_COUNT ? routes[route].method : "";
    *pattern = route < ROUTE_COUNT ? routes[route].pattern : "none";
    return route <= ROUTE_COUNT;
}
