/* SPDX-License-Identifier: MIT */
/*
 * The service manager (systemd, or what speaks like it): the socket it may have opened for us
 * (sd_listen_fds(3)) and what it wants to hear of us (sd_notify(3)). Both protocols are a few
 * environment variables and a datagram, fixed and documented for programs without libsystemd, which
 * would bring four compression libraries into a daemon that listens. Without a manager all of this
 * does nothing.
 */
#ifndef SERVER_SYSTEMD_H
#define SERVER_SYSTEMD_H

#include <stdbool.h>
#include <stdint.h>

/* The listening TCP socket that was handed over, made close-on-exec and non-blocking; -1: none was.
 * False: something else was handed over; `why` is then a constant text. The descriptor stays the
 * caller's, and shared with the manager: never shut it down, only close it. */
bool systemd_socket(int *socket, const char **why) __attribute__((warn_unused_result));

/* The daemon answers calls, at the start and after `systemd_reloading`. */
void systemd_ready(void);

/* The daemon reads again what SIGHUP is for; it answers calls meanwhile. */
void systemd_reloading(void);

/* The daemon is draining. */
void systemd_stopping(void);

/* The daemon is alive: to be called every `systemd_watchdog_ms`, or it will be killed. */
void systemd_alive(void);

/* Half of what the manager's watchdog allows between two signs of life; 0: it has none for us. */
int64_t systemd_watchdog_ms(void);

#endif
