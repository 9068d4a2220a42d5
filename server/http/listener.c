/* SPDX-License-Identifier: MIT */
#include "listener.h"
#include "server/log.h"
#include <errno.h>
#include <netinet/tcp.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

enum {
    BACKLOG = 1024,          /* connections the kernel may hold for us */
    DESCRIPTORS_OTHER = 256, /* for everything but connections */
    DESCRIPTORS_MAX = 1 << 20,
    SILENCE_S = 15,    /* a client that is silent for so long is probed */
    PROBE_S = 5,       /* and again */
    UNHEARD_MS = 60000 /* what was sent or asked must arrive within that */
};

size_t listener_descriptors(void) {
    struct rlimit limit;
    bool known = getrlimit(RLIMIT_NOFILE, &limit) == 0 && limit.rlim_cur < DESCRIPTORS_MAX;
    return known ? (size_t)limit.rlim_cur : DESCRIPTORS_MAX;
}

int listener_open(const struct config *config) {
    /* A client whose machine or line has gone sends no FIN: its connections, which inherit this,
     * are closed within two minutes. */
    static const struct {
        int level, name, value;
    } options[] = {{SOL_SOCKET, SO_KEEPALIVE, 1},
                   {IPPROTO_TCP, TCP_KEEPIDLE, SILENCE_S},
                   {IPPROTO_TCP, TCP_KEEPINTVL, PROBE_S},
                   {IPPROTO_TCP, TCP_USER_TIMEOUT, UNHEARD_MS}};
    const struct sockaddr *address = (const struct sockaddr *)&config->address;
    int on = 1, off = 0; /* [::] is every address, of IPv4 too, however the system is set */
    int listener = config->inherited;
    struct rlimit limit;
    rlim_t wanted = (rlim_t)config->max_connections + DESCRIPTORS_OTHER;
    if (getrlimit(RLIMIT_NOFILE, &limit) == 0 && limit.rlim_cur < wanted) {
        limit.rlim_cur = limit.rlim_max < wanted ? limit.rlim_max : wanted;
        if (setrlimit(RLIMIT_NOFILE, &limit) != 0 || limit.rlim_cur < wanted)
            log_warning(log_event("few_descriptors"), log_int("wanted", (int64_t)wanted),
                        log_int("allowed", (int64_t)limit.rlim_cur));
    }
    if (config->inherited < 0) {
        listener = socket(address->sa_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
        if (listener >= 0 && address->sa_family == AF_INET6)
            (void)setsockopt(listener, IPPROTO_IPV6, IPV6_V6ONLY, &off, sizeof off);
        if (listener < 0 || setsockopt(listener, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on) != 0 ||
            bind(listener, address, config->address_length) != 0 ||
            listen(listener, BACKLOG) != 0) {
            log_error(log_event("listen_failed"), log_text("address", config->listen),
                      log_text("error", strerror(errno)));
            if (listener >= 0)
                close(listener);
            return -1;
        }
    }
    for (size_t k = 0; k < sizeof options / sizeof *options; k++)
        (void)setsockopt(listener, options[k].level, options[k].name, &options[k].value,
                         sizeof options[k].value);
    return listener;
}

uint16_t listener_port(int listener) {
    union {
        struct sockaddr any;
        struct sockaddr_in v4;
        struct sockaddr_in6 v6;
    } bound = {0};
    socklen_t length = sizeof bound;
    if (getsockname(listener, &bound.any, &length) != 0)
        return 0;
    return ntohs(bound.any.sa_family == AF_INET6 ? bound.v6.sin6_port : bound.v4.sin_port);
}
