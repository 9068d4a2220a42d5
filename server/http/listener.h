/* SPDX-License-Identifier: MIT */
/* The listening socket. */
#ifndef SERVER_HTTP_LISTENER_H
#define SERVER_HTTP_LISTENER_H

#include "server/config.h"
#include <stdint.h>

/* Binds and listens where it is configured to, or takes the socket that was inherited, ready for as
 * many connections as it allows, as far as the system permits. The socket, which the caller
 * closes; -1 with a line in the log. */
int listener_open(const struct config *config);

/* How many descriptors the process may have since then, at most a million. */
size_t listener_descriptors(void);

/* The port in use; the one the system chose when the configuration said 0. */
uint16_t listener_port(int socket);

#endif
