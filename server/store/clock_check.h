/* SPDX-License-Identifier: MIT */
/*
 * Whether the wall clock by which times are stored can be relied on: it is compared, at every
 * sweep, with the monotonic clock of this process, which cannot be set. Where the two have advanced
 * by different amounts, the wall clock was set (or the machine was asleep).
 */
#ifndef SERVER_STORE_CLOCK_CHECK_H
#define SERVER_STORE_CLOCK_CHECK_H

#include <stdint.h>

/* Zero-initialised before the first look. */
struct clock_check {
    int64_t wall_us, own_us; /* at the latest look; own_us 0: none yet */
    int64_t since_us;        /* of our own clock: from when on both have agreed */
    int64_t jumps;
};

/* Looks at both clocks, in microseconds. The wall clock may be another machine's. */
void clock_check_compare(struct clock_check *clocks, int64_t wall_us, int64_t own_us);

/* For how long both have agreed, in microseconds. */
int64_t clock_check_agreed_us(const struct clock_check *clocks);

#endif
