/* SPDX-License-Identifier: MIT */
#include "clock.h"

static int64_t microseconds(clockid_t clock) {
    struct timespec now;
    clock_gettime(clock, &now);
    return (int64_t)now.tv_sec * 1000000 + now.tv_nsec / 1000;
}

int64_t clock_ms(void) {
    return clock_us() / 1000;
}

int64_t clock_us(void) {
    return microseconds(CLOCK_MONOTONIC);
}

int64_t clock_utc_us(void) {
    return microseconds(CLOCK_REALTIME);
}

struct timespec clock_after_ms(int64_t ms) {
    int64_t then = clock_us() + ms * 1000;
    return (struct timespec){then / 1000000, then % 1000000 * 1000};
}
