/* SPDX-License-Identifier: MIT */
#include "origin.h"
#include <arpa/inet.h>
#include <string.h>
#include <strings.h>

/* ------------------------------------------------------------------ Host */

/* A host without its port: `length` bytes. */
struct host {
    const char *text;
    size_t length;
};

static struct host host_of(const char *authority) {
    const char *end = *authority == '[' ? strchr(authority, ']') : NULL;
    size_t length = end ? (size_t)(end + 1 - authority) : strcspn(authority, ":");
    return (struct host){authority, length};
}

/* The authority that the request names (RFC 9112, 3.2.2), or NULL. */
static const char *authority_of(const struct request *request) {
    return request->authority ? request->authority : request_header(request, "Host");
}

/* Whether the list that commas split has this item, in any case of letters, or is "*". */
static bool list_has_host(const char *list, struct host item) {
    if (!strcmp(list, "*"))
        return true;
    for (;; list++) {
        size_t width = strcspn(list, ",");
        if (width == item.length && !strncasecmp(list, item.text, width))
            return width > 0;
        list += width;
        if (!*list)
            return false;
    }
}

/* Whether the host is an address, and one of loopback or of the configured ones. No name can be
 * rebound to look like an address. */
static bool is_own_address(const struct config *config, struct host host) {
    const struct sockaddr_in *v4 = (const struct sockaddr_in *)&config->address;
    const struct sockaddr_in6 *v6 = (const struct sockaddr_in6 *)&config->address;
    sa_family_t family = config->address.ss_family;
    char text[INET6_ADDRSTRLEN] = "";
    struct in_addr short_one;
    struct in6_addr long_one;
    bool any = (family == AF_INET && v4->sin_addr.s_addr == htonl(INADDR_ANY)) ||
               (family == AF_INET6 && IN6_IS_ADDR_UNSPECIFIED(&v6->sin6_addr));
    bool brackets = host.length > 2 && host.text[0] == '[';
    size_t length = host.length - (brackets ? 2 : 0);
    if (length >= sizeof text)
        return false;
    memcpy(text, host.text + brackets, length);
    if (!brackets && inet_pton(AF_INET, text, &short_one) == 1)
        return any || ntohl(short_one.s_addr) >> 24 == 127 ||
               (family == AF_INET && short_one.s_addr == v4->sin_addr.s_addr);
    if (brackets && inet_pton(AF_INET6, text, &long_one) == 1)
        return any || IN6_IS_ADDR_LOOPBACK(&long_one) ||
               (family == AF_INET6 && IN6_ARE_ADDR_EQUAL(&long_one, &v6->sin6_addr));
    return false;
}

bool origin_are_hosts(const char *list, bool origins) {
    if (!*list || !strcmp(list, "*"))
        return true;
    for (const char *one = list;; one++) {
        size_t width = strcspn(one, ",");
        size_t scheme = !origins                       ? 0
                        : !strncmp(one, "https://", 8) ? 8
                        : !strncmp(one, "http://", 7)  ? 7
                                                       : width;
        if (scheme >= width || !wire_is_authority(one + scheme, width - scheme) ||
            memchr(one, '*', width) || (!origins && memchr(one, ':', width)))
            return false;
        one += width;
        if (!*one)
            return true;
    }
}

bool origin_allows_host(const struct config *config, const struct request *request,
                        struct reply *reply) {
    static const char local[] = "localhost";
    const char *authority = authority_of(request);
    if (!authority && request->http_1_0)
        return true;
    struct host host = host_of(authority ? authority : "");
    if (list_has_host(local, host) || list_has_host(config->public_name, host) ||
        is_own_address(config, host))
        return true;
    reply_refuse(reply, API_FORBIDDEN,
                 "the host '%.*s' is not a name of this service: --public-name sets its names",
                 host.length < 64 ? (int)host.length : 64, host.text);
    return false;
}

/* ------------------------------------------------------------------ Origin */

/* A page is of the same origin if it has the host of the request, or a public name: behind a proxy
 * the two may differ. The scheme cannot be compared, since a proxy may have ended TLS. */
bool origin_allows_change(const struct config *config, const struct request *request,
                          struct reply *reply) {
    const char *site = request_header(request, "Sec-Fetch-Site");
    const char *origin = request_header(request, "Origin");
    bool listed = origin && config->cors_origin[0] &&
                  list_has_host(config->cors_origin, (struct host){origin, strlen(origin)});
    bool own = site ? !strcmp(site, "same-origin") || !strcmp(site, "none") : !origin;
    const char *host = !site && origin ? strstr(origin, "://") : NULL; /* NULL: "null" */
    const char *authority = authority_of(request), *names = config->public_name;
    if (host)
        own = (authority && !strcasecmp(host + 3, authority)) ||
              (names[0] && strcmp(names, "*") != 0 && list_has_host(names, host_of(host + 3)));
    if (own || listed)
        return true;
    reply_refuse(reply, API_FORBIDDEN,
                 "a web page of another origin may change nothing here; --cors-origin names those "
                 "that may");
    return false;
}

/* Credentials in the browser's sense, cookies, are not used here: a page that has a token sends it
 * by itself, so that any origin may be allowed without giving anything away. */
void origin_share(const struct config *config, const struct request *request, struct reply *reply) {
    const char *origin = request_header(request, "Origin");
    if (!config->cors_origin[0])
        return;
    reply_header(reply, "Vary", "Origin");
    if (!origin || !list_has_host(config->cors_origin, (struct host){origin, strlen(origin)}))
        return;
    reply_header(reply, "Access-Control-Allow-Origin", "%s", origin);
    reply_header(reply, "Access-Control-Expose-Headers",
                 "Allow, Content-Location, Content-Range, Draped-Binning, ETag, Location, "
                 "Preference-Applied, Retry-After, Server-Timing, X-Request-Id");
    if (strcmp(request->method, "OPTIONS") != 0 ||
        !request_header(request, "Access-Control-Request-Method"))
        return;
    reply_header(reply, "Access-Control-Allow-Methods", "GET, HEAD, POST, DELETE");
    reply_header(reply, "Access-Control-Allow-Headers",
                 "Authorization, Content-Type, Idempotency-Key, If-None-Match, If-Range, "
                 "Last-Event-ID, Prefer, Range, X-Request-Id");
    reply_header(reply, "Access-Control-Max-Age", "600");
}
