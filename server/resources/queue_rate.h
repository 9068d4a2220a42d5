/* SPDX-License-Identifier: MIT */
/* How fast the queue empties, for callers that have to come back: estimated from the number of
 * jobs that ended in the last seconds, on any machine. One of the process; any thread. */
#ifndef SERVER_RESOURCES_QUEUE_RATE_H
#define SERVER_RESOURCES_QUEUE_RATE_H

#include "server/store/store.h"

enum { QUEUE_RATE_UNKNOWN_SECONDS = 5, QUEUE_RATE_MAX_SECONDS = 600 };

/* Looks at the store if the last look is over a second ago. To be called with every submission. */
void queue_rate_sample(struct store *store);

/* The seconds, 1 to QUEUE_RATE_MAX_SECONDS, after which a tenth of a queue of that length (but at
 * least one job) has been worked off, so that callers that come back find room. */
int queue_rate_retry_seconds(int64_t queue);

#endif
