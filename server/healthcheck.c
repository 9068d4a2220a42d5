/* SPDX-License-Identifier: MIT */
#include "healthcheck.h"
#include <errno.h>
#include <string.h>
#include <sys/time.h>
#include <unistd.h>

enum { STEP_SECONDS = 3 }; /* for the connection, and again for the answer */

/* Sends the request and reads the first bytes of the answer. NULL, or what went wrong. */
static const char *ask(int client, const struct config *config) {
    static const char request[] = "GET /healthz HTTP/1.0\r\nHost: localhost\r\n\r\n";
    static const char wanted[] = "HTTP/1.1 200 ";
    char answer[sizeof wanted - 1];
    if (connect(client, (const struct sockaddr *)&config->address, config->address_length) != 0 ||
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
bool healthcheck_passes(const struct config *config) {
    const struct timeval step = {.tv_sec = STEP_SECONDS};
    int client = socket(config->address.ss_family, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const char *why =
        client < 0 || setsockopt(client, SOL_SOCKET, SO_RCVTIMEO, &step, sizeof step) != 0 ||
                setsockopt(client, SOL_SOCKET, SO_SNDTIMEO, &step, sizeof step) != 0
            ? strerror(errno)
            : ask(client, config);
    if (client >= 0)
        close(client);
    if (why)
        fprintf(stderr, "draped: %s: %s\n", config->listen, why);
    return !why;
}
