/* SPDX-License-Identifier: MIT */
/*
 * The settings of a dispatcher: what the configuration decides and every run of a job needs.
 */
#ifndef SERVER_WORK_SETTINGS_H
#define SERVER_WORK_SETTINGS_H

#include "api/limits.h"
#include <stdint.h>

/* How often a dispatcher looks for itself at what other processes may have changed. */
enum { WORK_POLL_MS = 500 };

struct form_cache;

struct dispatcher_settings {
    int workers;              /* threads and processes; 0 only sweeps */
    int64_t job_timeout_ms;   /* one attempt; then the job fails as `job-timeout` */
    int64_t renew_ms;         /* lease renewal, well below the store's lease */
    int64_t progress_ms;      /* progress is stored at most this often */
    int64_t sweep_ms;         /* between two sweeps */
    int64_t beat_ms;          /* between two signs of life; after a failure each sweep gives one */
    const char *role;         /* as others see it: a literal */
    int64_t max_result;       /* bytes; a job with more fails as `too-large` */
    struct api_limits limits; /* of one job */
    struct form_cache *forms; /* what checks have made; NULL: nothing */
};

/* One worker, 600 s, 15 s, 200 ms, 250 ms, 5 s, "all", 64 GiB, api_limits_default. */
struct dispatcher_settings dispatcher_settings_default(void);

#endif
