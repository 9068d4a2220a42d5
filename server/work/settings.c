/* SPDX-License-Identifier: MIT */
#include "settings.h"

struct dispatcher_settings dispatcher_settings_default(void) {
    return (struct dispatcher_settings){
        .workers = 1,
        .job_timeout_ms = 600 * 1000,
        .renew_ms = 15 * 1000,
        .progress_ms = 200,
        .sweep_ms = 250,
        .beat_ms = 5000,
        .role = "all",
        .max_result = INT64_C(64) << 30,
        .limits = api_limits_default,
    };
}
