/* SPDX-License-Identifier: MIT */
#include "systemd.h"
#include "clock.h"
#include "log.h"
#include <errno.h>
#include <fcntl.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

enum { FIRST_SOCKET = 3 }; /* SD_LISTEN_FDS_START */

/* A positive number in the environment; 0 without one. */
static int64_t number_in_environment(const char *variable) {
    const char *text = getenv(variable);
    char *end = NULL;
    errno = 0;
    long long number = text ? strtoll(text, &end, 10) : 0;
    return end != text && end && !*end && errno == 0 && number > 0 ? number : 0;
}

/* ------------------------------------------------------------------ the socket */

static int option_of(int socket, int name) {
    int value = 0;
    socklen_t length = sizeof value;
    return getsockopt(socket, SOL_SOCKET, name, &value, &length) == 0 ? value : -1;
}

bool systemd_socket(int *socket, const char **why) {
    *socket = -1;
    int64_t count = number_in_environment("LISTEN_FDS");
    if (number_in_environment("LISTEN_PID") != getpid() || count == 0)
        return true;
    *why = count > 1 ? "draped takes one socket, but more were handed over (LISTEN_FDS)"
                     : "the socket that was handed over (LISTEN_FDS) is not a listening TCP socket";
    int domain = option_of(FIRST_SOCKET, SO_DOMAIN);
    if (count > 1 || (domain != AF_INET && domain != AF_INET6) ||
        option_of(FIRST_SOCKET, SO_TYPE) != SOCK_STREAM ||
        option_of(FIRST_SOCKET, SO_ACCEPTCONN) != 1)
        return false;
    *why = "the socket that was handed over cannot be set up";
    *socket = FIRST_SOCKET;
    return fcntl(FIRST_SOCKET, F_SETFD, FD_CLOEXEC) == 0 &&
           fcntl(FIRST_SOCKET, F_SETFL, fcntl(FIRST_SOCKET, F_GETFL) | O_NONBLOCK) == 0;
}

/* ------------------------------------------------------------------ notices */

static void notify_systemd(const char *words) {
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    const char *path = getenv("NOTIFY_SOCKET");
    size_t length = path ? strlen(path) : 0;
    const char *why = NULL;
    if (length == 0)
        return;
    if ((path[0] != '/' && path[0] != '@') || length >= sizeof address.sun_path) {
        why = "this is not the address of a socket";
    } else {
        memcpy(address.sun_path, path, length);
        if (path[0] == '@')
            address.sun_path[0] = '\0'; /* an abstract name, which ends where its length says */
        const struct sockaddr *to = (const struct sockaddr *)&address;
        socklen_t size = (socklen_t)(offsetof(struct sockaddr_un, sun_path) + length);
        int sender = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
        if (sender < 0 || sendto(sender, words, strlen(words), MSG_NOSIGNAL, to, size) < 0)
            why = strerror(errno);
        if (sender >= 0)
            close(sender);
    }
    if (why)
        log_warning(log_event("notify_failed"), log_text("socket", path), log_text("error", why));
}

void systemd_ready(void) {
    notify_systemd("READY=1\nSTATUS=Draping");
}

void systemd_reloading(void) {
    char words[96];
    snprintf(words, sizeof words, "RELOADING=1\nMONOTONIC_USEC=%lld\nSTATUS=Reading the tokens",
             (long long)clock_us());
    notify_systemd(words);
}

void systemd_stopping(void) {
    notify_systemd("STOPPING=1\nSTATUS=Draining: running drapes finish");
}

void systemd_alive(void) {
    notify_systemd("WATCHDOG=1");
}

int64_t systemd_watchdog_ms(void) {
    int64_t limit_us = number_in_environment("WATCHDOG_USEC");
    bool ours = !getenv("WATCHDOG_PID") || number_in_environment("WATCHDOG_PID") == getpid();
    int64_t half_ms = limit_us / 2000;
    return !ours || limit_us == 0 ? 0 : half_ms > 0 ? half_ms : 1;
}
