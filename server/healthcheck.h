/* SPDX-License-Identifier: MIT */
/* The health check of container engines: asks the daemon that runs with the same configuration. It
 * spares images a client of HTTP. */
#ifndef SERVER_HEALTHCHECK_H
#define SERVER_HEALTHCHECK_H

#include "config.h"

/* Whether GET /healthz at the configured address answers 200 within a few seconds. If not, why
 * stands on stderr. */
bool healthcheck_passes(const struct config *config);

#endif
