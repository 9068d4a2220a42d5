/* SPDX-License-Identifier: MIT */
#include "healthcheck.h"
#include <errno.h>
#include <string.h>
#include <sys/time.h>
#include <unistd.h>

enum { STEP_SECONDS = 3 }; /* for the connection, and again for the answer */

/* Sends the request and reads the first bytes of the answer. NULL, or what went wrong. */
static const char *ask_socket(int client, const struct config *config, uint16_t port) {
    static const char request[] = "GET /healthz HTTP/1.0\r\nHost: localhost\r\n\r\n";
    static const char wanted[] = "HTTP/1.1 200 ";
    char answer[sizeof wanted - 1];
    union {
        struct sockaddr_storage storage;
        struct sockaddr any;
        struct sockaddr_in v4;
        struct sockaddr_in6 v6;
    } address = {config->address};
    *(address.any.sa_family == AF_INET6 ? &address.v6.sin6_port : &address.v4.sin_port) =
        htons(port);
    if (connect(client, &address.any, config->address_length) != 0 ||
        send(client, request, sizeof request - 1, MSG_NOSIGNAL) != (ssize_t)sizeof request - 1)
        return strerror(errno);
    ssize_t got = recv(client, answer, sizeof answer, MSG_WAITALL);
    if (got < 0)
        return errno == EAGAIN ? "no answer in time" : strerror(errno);
    return got == (ssize_t)sizeof answer && !memcmp(answer, wanted, sizeof answer)
               ? NULL
               : "the answer is not 200";
}

/* 0.0.0.0 and [::] need no translation: as a destination they mean this machine. */
const char *healthcheck_ask(const struct config *config, uint16_t port) {
    const struct timeval step = {.tv_sec = STEP_SECONDS};
    int client = socket(config->address.ss_family, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const char *why =
        client < 0 || setsockopt(client, SOL_SOCKET, SO_RCVTIMEO, &step, sizeof step) != 0 ||
                setsockopt(client, SOL_SOCKET, SO_SNDTIMEO, &step, sizeof step) != 0
            ? strerror(errno)
            : ask_socket(client, config, port);
    if (client >= 0)
        close(client);
    return why;
}

/* The port stands at the same place in both families. */
bool healthcheck_passes(const struct config *config) {
    const struct sockaddr_in *address = (const struct sockaddr_in *)&config->address;
    const char *why = healthcheck_ask(config, ntohs(address->sin_port));
    if (why)
        fprintf(stderr, "draped: %s: %s\n", config->listen, why);
    return !why;
}
