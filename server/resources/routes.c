/* SPDX-License-Identifier: MIT */
#include "routes.h"
#include "handlers.h"
#include "items.h"
#include "links.h"
#include "server/config.h"
#include "server/http/access.h"
#include "server/http/negotiate.h"
#include "server/http/origin.h"
#include "server/metrics.h"
#include <stdio.h>
#include <string.h>

enum {
    ROUTE_BODY = 1,        /* takes a JSON document */
    ROUTE_WORK = 2,        /* new work: not while draining */
    ROUTE_QUIET = 4,       /* probes and scrapes: not worth a line of the log each */
    ROUTE_LOOSE = 8,       /* takes any query */
    ROUTE_MESH = 16,       /* takes a mesh, JSON or Nastran */
    ROUTE_OPEN = 32,       /* for everybody, without a token */
    ROUTE_FILE = 128,      /* takes a file of CAD or mesh as well */
    ROUTE_STUDY = 256,     /* about studies and not drapes */
    ROUTE_LAMINATE = 512,  /* about laminates */
    ROUTE_MATERIAL = 1024, /* about materials and not surfaces */
    ROUTE_LINK = 2048,     /* about links */
    ROUTE_ADMIN = 64       /* speaks of all owners: for administrators, or on this machine */
};

struct route {
    const char *method, *pattern;
    call_handler *handler;
    unsigned flags;
    const char *query[20]; /* the query parameters it knows, up to a NULL */
};

#define RESULT_QUERY "format", "table", "fields", "precision"
#define MAP_QUERY                                                                                  \
    "format", "table", "fields", "precision", "reference", "within", "plies_as", "inlet",          \
        "inlet_elements", "outlet", "edge_channel", "cavity_height", "punch", "lcmsim_version",    \
        "at_most_fiber_volume_fraction"

#define JSON_WORK (ROUTE_BODY | ROUTE_WORK)
#define MESH_WORK (ROUTE_MESH | ROUTE_WORK)
#define LAMINATE ROUTE_LAMINATE
#define PROBE (ROUTE_QUIET | ROUTE_LOOSE | ROUTE_OPEN)

/* clang-format off: a row a line */
static const struct route routes[] = {
    {"POST", "/v1/drapes", jobs_create, JSON_WORK, {RESULT_QUERY}},
    {"GET", "/v1/drapes", jobs_list, 0, {"status", "limit", "cursor"}},
    {"GET", "/v1/drapes/{id}", jobs_status, 0, {"wait"}},
    {"DELETE", "/v1/drapes/{id}", jobs_end, 0, {0}},
    {"GET", "/v1/drapes/{id}/events", events_stream, 0, {0}},
    {"POST", "/v1/drapes/{id}/cancel", jobs_end, 0, {0}},
    {"GET", "/v1/drapes/{id}/result", results_get, 0, {RESULT_QUERY}},
    {"GET",
     "/v1/drapes/{id}/pattern",
     results_pattern,
     0,
     {"format", "allowance", "partial", "part", "ply"}},
    {"GET", "/v1/drapes/{id}/report", results_report, 0, {"format", "allowance", "part", "ply"}},
    {"GET", "/v1/drapes/{id}/request", jobs_request, 0, {0}},
    {"POST", "/v1/drapes/{id}/map", maps_create, MESH_WORK, {MAP_QUERY}},

    {"POST", "/v1/studies", jobs_create, ROUTE_STUDY | JSON_WORK, {RESULT_QUERY}},
    {"GET", "/v1/studies", jobs_list, ROUTE_STUDY, {"status", "limit", "cursor"}},
    {"GET", "/v1/studies/{id}", jobs_status, ROUTE_STUDY, {"wait"}},
    {"DELETE", "/v1/studies/{id}", jobs_end, ROUTE_STUDY, {0}},
    {"GET", "/v1/studies/{id}/events", events_stream, ROUTE_STUDY, {0}},
    {"POST", "/v1/studies/{id}/cancel", jobs_end, ROUTE_STUDY, {0}},
    {"GET", "/v1/studies/{id}/result", results_get, ROUTE_STUDY, {RESULT_QUERY, "sample"}},
    {"POST", "/v1/studies/{id}/map", maps_create, ROUTE_STUDY | MESH_WORK, {MAP_QUERY, "sample"}},
    {"GET", "/v1/studies/{id}/request", jobs_request, ROUTE_STUDY, {0}},
    {"GET", "/v1/studies/{id}/variants/{k}/request", studies_variant, ROUTE_STUDY, {0}},

    {"POST", "/v1/laminates", jobs_create, LAMINATE | JSON_WORK, {RESULT_QUERY}},
    {"GET", "/v1/laminates", jobs_list, LAMINATE, {"status", "limit", "cursor"}},
    {"GET", "/v1/laminates/{id}", jobs_status, LAMINATE, {"wait"}},
    {"DELETE", "/v1/laminates/{id}", jobs_end, LAMINATE, {0}},
    {"GET", "/v1/laminates/{id}/events", events_stream, LAMINATE, {0}},
    {"POST", "/v1/laminates/{id}/cancel", jobs_end, LAMINATE, {0}},
    {"GET", "/v1/laminates/{id}/request", laminates_request, LAMINATE, {0}},
    {"GET",
     "/v1/laminates/{id}/plies/{k}/pattern",
     laminates_pattern,
     LAMINATE,
     {"format", "partial"}},
    {"GET",
     "/v1/laminates/{id}/patterns",
     laminates_patterns,
     LAMINATE,
     {"format", "width", "gap", "turn", "roll", "partial"}},
    {"GET",
     "/v1/laminates/{id}/report",
     laminates_report,
     LAMINATE,
     {"format", "width", "gap", "turn"}},
    {"GET",
     "/v1/laminates/{id}/laser",
     laminates_laser,
     LAMINATE,
     {"format", "tolerance", "partial"}},
    {"GET",
     "/v1/laminates/{id}/bundle.zip",
     laminates_bundle,
     LAMINATE,
     {"format", "width", "gap", "turn", "tolerance", "partial"}},
    {"POST", "/v1/laminates/{id}/map", maps_create, LAMINATE | MESH_WORK, {MAP_QUERY}},

    {"POST", "/v1/surfaces", items_create, ROUTE_FILE | JSON_WORK, {"format", "unit"}},
    {"GET", "/v1/surfaces", items_list, 0, {"limit", "cursor"}},
    {"GET", "/v1/surfaces/{id}", items_get, 0, {0}},
    {"DELETE", "/v1/surfaces/{id}", items_delete, 0, {0}},
    {"GET", "/v1/surfaces/{id}/preview", items_preview, 0, {"format"}},
    {"POST", "/v1/materials", items_create, ROUTE_MATERIAL | JSON_WORK, {0}},
    {"GET", "/v1/materials", items_list, ROUTE_MATERIAL, {"limit", "cursor"}},
    {"GET", "/v1/materials/{name}", items_get, ROUTE_MATERIAL, {0}},
    {"DELETE", "/v1/materials/{name}", items_delete, ROUTE_MATERIAL, {0}},

    {"POST", "/v1/links", links_create, ROUTE_LINK, {"of", "expires_in"}},
    {"GET", "/v1/links", items_list, ROUTE_LINK, {"limit", "cursor"}},
    {"GET", "/v1/links/{link}", items_get, ROUTE_LINK, {0}},
    {"DELETE", "/v1/links/{link}", items_delete, ROUTE_LINK, {0}},

    {"GET", "/v1/openapi.json", meta_openapi, ROUTE_OPEN, {0}},
    {"GET", "/v1/limits", meta_limits, ROUTE_OPEN, {0}},
    {"GET", "/", viewer_page, ROUTE_LOOSE | ROUTE_OPEN, {0}},
    {"GET", "/viewer/{digest}/{file}", viewer_file, ROUTE_LOOSE | ROUTE_OPEN, {0}},
    {"GET", "/healthz", meta_health, PROBE, {0}},
    {"GET", "/readyz", meta_ready, PROBE, {0}},
    {"GET", "/version", meta_version, ROUTE_LOOSE | ROUTE_OPEN, {0}},
    {"GET", "/metrics", meta_metrics, ROUTE_QUIET | ROUTE_LOOSE | ROUTE_ADMIN, {0}},
};
/* clang-format on */

enum { ROUTE_COUNT = sizeof routes / sizeof *routes };

_Static_assert((int)ROUTE_COUNT < (int)METRICS_ROUTES_MAX, "every route and `none` are counted");

/* ------------------------------------------------------------------ matching */

/* Whether the segments are those of the pattern; `*parameter` is what stands for {id}, for the
 * first one if there are several. */
static bool match_pattern(const char *pattern, const struct request *request,
                          const char **parameter) {
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
            *parameter = *parameter ? *parameter : segment;
        else if (strlen(segment) != length || strncmp(segment, part, length) != 0)
            return false;
        part += length;
    }
    return k == request->segment_count;
}

/* Sets the route. `allow` gets the methods of the path, "" when there is no such path. HEAD is
 * answered by what answers GET; the body is left out on the way. In the role `worker` there are
 * only the paths of probes and scrapes. */
static void find_route(const struct config *config, struct request *request, char *allow,
                       size_t size) {
    bool works = config->role == CONFIG_ROLE_WORKER, head = !strcmp(request->method, "HEAD");
    size_t used = 0;
    *allow = '\0';
    for (size_t k = 0; k < ROUTE_COUNT; k++) {
        const char *parameter;
        if ((works && !(routes[k].flags & ROUTE_QUIET)) ||
            !match_pattern(routes[k].pattern, request, &parameter))
            continue;
        bool get = !strcmp(routes[k].method, "GET");
        used += (size_t)snprintf(allow + used, size - used, "%s%s", routes[k].method,
                                 get ? ", HEAD, " : ", ");
        if ((get && head) || !strcmp(routes[k].method, request->method)) {
            request->route = &routes[k];
            request->parameter = parameter;
        }
    }
    if (used)
        snprintf(allow + used, size - used, "OPTIONS");
}

/* ------------------------------------------------------------------ before the body */

/* Whether the path knows the parameters of the query, and each is there once. */
static bool check_query(struct call *call) {
    const struct request *request = call->request;
    const struct route *route = request->route;
    for (size_t k = 0; !(route->flags & ROUTE_LOOSE) && k < request->query_count; k++) {
        const char *name = request->query[k].name;
        const char *const *known = route->query;
        while (*known && strcmp(*known, name) != 0)
            known++;
        if (*known && request_query(request, name) == request->query[k].value)
            continue;
        reply_refuse(call->reply, API_INVALID_REQUEST,
                     *known ? "the query parameter '%.64s' is given more than once"
                            : "the path has no query parameter '%.64s'",
                     name);
        return false;
    }
    return true;
}

/* A missing type passes, since bare HTTP clients send none, but not from a web page, which can make
 * a browser send a body without one. Form types do not pass, for the same reason. */
static bool check_media_type(struct call *call) {
    const struct route *route = call->request->route;
    const char *type = request_header(call->request, "Content-Type");
    bool mesh = route->flags & ROUTE_MESH, page = request_header(call->request, "Origin");
    const struct file_format *file = items_file_of(type);
    if (route->flags & ROUTE_FILE && items_check_file(call))
        return !call->reply->status;
    if (!(route->flags & (ROUTE_BODY | ROUTE_MESH)) || (!type && !page) ||
        (type && negotiate_is_json(type)) || (type && mesh && file && !file->cad))
        return true;
    reply_header(call->reply, "Accept", "application/json%s",
                 mesh ? ", text/x-nastran, text/x-abaqus, text/x-lsdyna, text/x-gmsh, text/x-unv, "
                        "application/vnd.vtk, "
                        "model/stl, model/obj"
                      : "");
    reply_refuse(call->reply, API_UNSUPPORTED_MEDIA_TYPE,
                 "the Content-Type is '%.64s' but must be application/json%s; with curl: -H "
                 "'Content-Type: application/json'",
                 type ? type : "", mesh ? " or that of a mesh (text/x-nastran, ...)" : "");
    return false;
}

/* Answers that depend on the caller are not for caches that others use. */
static void mark_private(struct call *call) {
    if ((call->services->tokens || call->request->link) &&
        !(call->request->route->flags & ROUTE_OPEN))
        access_mark(call->reply);
}

static bool check_route(void *context, struct request *request, struct reply *reply) {
    struct call call = {.services = context, .request = request, .reply = reply};
    const struct config *config = call.services->config;
    char allow[64];
    find_route(config, request, allow, sizeof allow);
    const struct route *route = request->route;
    /* Probes say nothing that a page could use, and come under any name. */
    bool probe = route && route->flags & ROUTE_QUIET && route->flags & ROUTE_OPEN;
    if (!probe && !origin_allows_host(config, request, reply))
        return true;
    if (!route) { /* 404, 405, or the answer to OPTIONS */
        bool options = !strcmp(request->method, "OPTIONS");
        if (*allow)
            reply_header(reply, "Allow", "%s", allow);
        if (options && (*allow || !strcmp(request->target, "*")))
            reply_empty(reply, 204);
        else if (*allow)
            reply_refuse(reply, API_METHOD_NOT_ALLOWED, "the path takes only %s", allow);
        else
            reply_refuse(reply, API_NOT_FOUND,
                         "there is nothing at this path: GET /v1/openapi.json lists all paths");
        return true;
    }
    request->quiet = route->flags & ROUTE_QUIET;
    if (route->flags & ROUTE_MESH)
        request->limit = (struct request_limit){config->max_mesh, "max-mesh"};
    /* What stores nothing is reading, a map of the caller's mesh as well. */
    enum tokens_role needed = route->flags & ROUTE_ADMIN && !request->local ? TOKENS_ADMIN
                              : !strcmp(route->method, "GET") || route->flags & ROUTE_MESH
                                  ? TOKENS_READ
                                  : TOKENS_WRITE;
    /* What is named by its id, and read. */
    bool links_show = needed == TOKENS_READ && strstr(route->pattern, "/{id}");
    bool good = (!strcmp(route->method, "GET") || origin_allows_change(config, request, reply)) &&
                (route->flags & ROUTE_OPEN ||
                 access_allow(call.services->tokens, request, needed, links_show, reply)) &&
                check_query(&call) && check_media_type(&call);
    if (good && request->draining && route->flags & ROUTE_WORK)
        call_draining(&call);
    if (reply->status)
        mark_private(&call);
    return reply->status != 0;
}

static enum http_next handle_request(void *context, struct request *request, struct reply *reply) {
    const unsigned flags = request->route->flags;
    struct call call = {
        .services = context,
        .request = request,
        .reply = reply,
        .kind = flags & ROUTE_STUDY ? STORE_STUDY
                : flags & LAMINATE  ? STORE_LAMINATE
                                    : STORE_DRAPE,
        .item = flags & ROUTE_MATERIAL ? STORE_MATERIALS
                : flags & ROUTE_LINK   ? STORE_LINKS
                                       : STORE_SURFACES,
    };
    enum http_next next = HTTP_DONE;
    if (!request->link || links_admit(&call))
        next = request->route->handler(&call);
    if (next == HTTP_DONE)
        mark_private(&call);
    return next;
}

/* ------------------------------------------------------------------ counting */

static void count_answer(void *context, const struct request *request, int status, int64_t us) {
    (void)context;
    metrics_count(request && request->route ? (size_t)(request->route - routes) : ROUTE_COUNT,
                  status, us);
}

bool routes_describe(size_t route, const char **method, const char **pattern) {
    *method = route < ROUTE_COUNT ? routes[route].method : "";
    *pattern = route < ROUTE_COUNT ? routes[route].pattern : "none";
    return route <= ROUTE_COUNT;
}

struct http_handler routes_handler(const struct services *services) {
    return (struct http_handler){(void *)(uintptr_t)services, check_route, handle_request,
                                 count_answer};
}
