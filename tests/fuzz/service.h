/* SPDX-License-Identifier: MIT */
/* What handlers work with, without sockets: a store with one surface, and one drape of it that
 * has a result. */
#ifndef TESTS_FUZZ_SERVICE_H
#define TESTS_FUZZ_SERVICE_H

#include "server/resources/call.h"

/* Made at the first call, removed when the process ends. */
const struct services *service(void);

/* Makes a new one at the next call: the old one is not as it was. */
void service_spoil(void);

/* Ids of the drape and of the surface that `service` has now. */
extern char service_drape[], service_surface[];

#endif
