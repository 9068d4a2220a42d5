/* SPDX-License-Identifier: MIT */
#include "healthcheck.h"
#include <errno.h>
#include <string.h>
#include <sys/time.h>
#include <unistd.h>

enum { STEP_SECONDS = 3 }; /* for the connection, and again for the answer */

/* 0.0.0.0 and [::] need no translation: as a destination they mean this machine. */
const char *healthcheck_ask(const struct config *config, uint16_t port) {
    static const char request[] = "GET /healthz HTTP/1.0\r\nHost: localhost\r\n\r\n";
    static const char wanted[] = "HTTP/1.1 200 ";
    const struct timeval step = {.tv_sec = STEP_SECONDS};
    char answer[sizeof wanted - 1];
    union {
        struct sockaddr_storage storage;
        struct sockaddr any;
        struct sockaddr_in v4;
        struct sockaddr_in6 v6;
    } address = {config->address};
    *(address.any.sa_family == AF_INET6 ? &address.v6.sin6_port : &address.v4.sin_port) =
        htons(port);
    /* Sends the request and reads the first bytes of the answer. */
    const char *why = NULL;
    ssize_t got = 0;
    int client = socket(config->address.ss_family, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (client < 0 || setsockopt(client, SOL_SOCKET, SO_RCVTIMEO, &step, sizeof step) != 0 ||
        setsockopt(client, SOL_SOCKET, SO_SNDTIMEO, &step, sizeof step) != 0 ||
        connect(client, &address.any, config->address_length) != 0 ||
        send(client, request, sizeof request - 1, MSG_NOSIGNAL) != (ssize_t)sizeof request - 1)
        why = strerror(errno);
    else if ((got = recv(client, answer, sizeof answer, MSG_WAITALL)) < 0)
        why = errno == EAGAIN ? "no answer in time" : strerror(errno);
    else if (got != (ssize_t)sizeof answer || memcmp(answer, wanted, sizeof answer) != 0)
        why = "the answer is not 200";
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
