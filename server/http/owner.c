/* SPDX-License-Identifier: MIT */
#include "owner.h"
#include <arpa/inet.h>
#include <netinet/in.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

/* An address of either family, IPv4 as IPv6 maps it (RFC 4291, 2.5.5.2). */
struct address {
    struct in6_addr bytes;
    bool known;
};

static struct address from_v4(struct in_addr v4) {
    struct address address = {.known = true};
    address.bytes.s6_addr[10] = address.bytes.s6_addr[11] = 0xff;
    memcpy(&address.bytes.s6_addr[12], &v4, sizeof v4);
    return address;
}

static struct address from_socket(const struct sockaddr *socket) {
    if (socket && socket->sa_family == AF_INET)
        return from_v4(((const struct sockaddr_in *)(const void *)socket)->sin_addr);
    if (socket && socket->sa_family == AF_INET6)
        return (struct address){((const struct sockaddr_in6 *)(const void *)socket)->sin6_addr,
                                true};
    return (struct address){.known = false};
}

/* Reads an address as these headers write it: bare, in quotes or brackets, with a port or without.
 */
static struct address from_text(const char *text, size_t length) {
    char bare[INET6_ADDRSTRLEN] = "";
    struct in_addr v4;
    struct in6_addr v6;
    if (length >= 2 && text[0] == '"' && text[length - 1] == '"')
        text++, length -= 2;
    const char *bracket = length && text[0] == '[' ? memchr(text, ']', length) : NULL;
    const char *colon = memchr(text, ':', length);
    if (bracket) {
        length = (size_t)(bracket - ++text);
    } else if (colon && !memchr(colon + 1, ':', length - (size_t)(colon + 1 - text))) {
        length = (size_t)(colon - text);
    }
    if (length >= sizeof bare)
        return (struct address){.known = false};
    memcpy(bare, text, length);
    if (inet_pton(AF_INET, bare, &v4) == 1)
        return from_v4(v4);
    if (inet_pton(AF_INET6, bare, &v6) == 1)
        return (struct address){v6, true};
    return (struct address){.known = false};
}

static void name_address(struct address address, char name[REQUEST_CALLER_SIZE]) {
    char text[INET6_ADDRSTRLEN] = "";
    if (!address.known) {
        snprintf(name, REQUEST_CALLER_SIZE, "@");
    } else if (IN6_IS_ADDR_V4MAPPED(&address.bytes)) {
        inet_ntop(AF_INET, &address.bytes.s6_addr[12], text, sizeof text);
        snprintf(name, REQUEST_CALLER_SIZE, "@%s", text);
    } else {
        memset(&address.bytes.s6_addr[8], 0, 8);
        inet_ntop(AF_INET6, &address.bytes, text, sizeof text);
        snprintf(name, REQUEST_CALLER_SIZE, "@%s/64", text);
    }
}

void owner_of_address(const struct sockaddr *address, char name[REQUEST_CALLER_SIZE]) {
    name_address(from_socket(address), name);
}

/* ------------------------------------------------------------------ lists */

/* The next item of a list that commas split, without blanks around it; false at the end. */
static bool next_item(const char **list, const char **item, size_t *length) {
    const char *text = *list;
    if (!text)
        return false;
    size_t width = strcspn(text, ",");
    *list = text[width] ? text + width + 1 : NULL;
    while (width && (*text == ' ' || *text == '\t'))
        text++, width--;
    while (width && (text[width - 1] == ' ' || text[width - 1] == '\t'))
        width--;
    *item = text;
    *length = width;
    return true;
}

bool owner_are_addresses(const char *list) {
    const char *item;
    size_t length;
    if (!*list)
        return true;
    while (next_item(&list, &item, &length))
        if (!from_text(item, length).known)
            return false;
    return true;
}

static bool list_has_address(const char *list, struct address address) {
    const char *item;
    size_t length;
    while (address.known && next_item(&list, &item, &length)) {
        struct address one = from_text(item, length);
        if (one.known && !memcmp(&one.bytes, &address.bytes, sizeof one.bytes))
            return true;
    }
    return false;
}

bool owner_trusts(const char *trusted, const struct sockaddr *peer) {
    return *trusted && list_has_address(trusted, from_socket(peer));
}

/* ------------------------------------------------------------------ what proxies say */

bool owner_is_local(const struct sockaddr *peer, const struct request *request) {
    struct address address = from_socket(peer);
    bool loopback = address.known &&
                    (IN6_IS_ADDR_LOOPBACK(&address.bytes) ||
                     (IN6_IS_ADDR_V4MAPPED(&address.bytes) && address.bytes.s6_addr[12] == 127));
    return loopback && !request_header(request, "Forwarded") &&
           !request_header(request, "X-Forwarded-For") && !request_header(request, "Via");
}

/* The address in an element of Forwarded: the value of its parameter `for`. */
static struct address forwarded_for(const char *element, size_t length) {
    for (size_t at = 0; at < length;) {
        while (at < length && (element[at] == ' ' || element[at] == ';'))
            at++;
        size_t end = at;
        while (end < length && element[end] != ';')
            end++;
        if (end - at > 4 && !strncasecmp(element + at, "for=", 4))
            return from_text(element + at + 4, end - at - 4);
        at = end;
    }
    return (struct address){.known = false};
}

/* Follows the lines of the header of that name from the first proxy's entry to the last. `*client`
 * is the last one that is not trusted, or unknown where one cannot be read: what stands before it
 * counts for nothing. */
static bool follow_header(const char *trusted, const struct request *request, const char *name,
                          struct address (*read)(const char *, size_t), struct address *client) {
    bool any = false;
    for (size_t k = 0; k < request->header_count; k++) {
        const char *list = request->headers[k].value, *item;
        size_t length;
        if (strcasecmp(request->headers[k].name, name) != 0)
            continue;
        while (next_item(&list, &item, &length)) {
            struct address address = read(item, length);
            if (!any || !address.known || !list_has_address(trusted, address))
                *client = address;
            any = true;
        }
    }
    return any;
}

void owner_of_request(const char *trusted, const struct sockaddr *peer,
                      const struct request *request, char name[REQUEST_CALLER_SIZE]) {
    struct address client = from_socket(peer), said = {.known = false};
    bool any = owner_trusts(trusted, peer) &&
               (follow_header(trusted, request, "Forwarded", forwarded_for, &said) ||
                follow_header(trusted, request, "X-Forwarded-For", from_text, &said));
    name_address(any && said.known ? said : client, name);
}
