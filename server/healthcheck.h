/* SPDX-License-Identifier: MIT */
/* The health check of container engines: asks the daemon that runs with the same configuration. It
 * spares images a client of HTTP. */
#ifndef SERVER_HEALTHCHECK_H
#define SERVER_HEALTHCHECK_H

#include "config.h"

/* Asks for /healthz as any client does, at the address of --listen and that port, for six seconds
 * at the most. NULL when it is answered with 200, else what is wrong: a text that lives until the
 * next call of `strerror`. */
const char *healthcheck_ask(const struct config *config, uint16_t port);

/* Whether GET /healthz at the configured address answers 200 within a few seconds. If not, why
 * stands on stderr. */
bool healthcheck_passes(const struct config *config);

#endif
