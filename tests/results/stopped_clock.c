/* SPDX-License-Identifier: MIT */
/*
 * Preloaded into the command, whose results then tell no time: solving takes 0 ms, always, and ends
 * in the first second of 1970. So every byte of a result can be compared.
 */
#include <time.h>

int clock_gettime(clockid_t clock, struct timespec *now) {
    (void)clock;
    *now = (struct timespec){.tv_sec = 1};
    return 0;
}

time_t time(time_t *now) {
    if (now)
        *now = 1;
    return 1;
}
