/* SPDX-License-Identifier: MIT */
#include "clock.h"

int64_t clock_ms(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (int64_t)now.tv_sec * 1000 + now.tv_nsec / 1000000;
}

int64_t clock_us(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (int64_t)now.tv_sec * 1000000 + now.tv_nsec / 1000;
}

struct timespec clock_after_ms(int64_t ms) {
    struct timespec then;
    clock_gettime(CLOCK_MONOTONIC, &then);
    int64_t nanoseconds = then.tv_nsec + ms % 1000 * 1000000;
    then.tv_sec += ms / 1000 + nanoseconds / 1000000000;
    then.tv_nsec = nanoseconds % 1000000000;
    return then;
}

int64_t clock_utc_us(void) {
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    return (int64_t)now.tv_sec * 1000000 + now.tv_nsec / 1000;
}
