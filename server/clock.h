/* SPDX-License-Identifier: MIT */
/*
 * The two clocks of the daemon: the monotonic one for waiting, which cannot be set, and the wall
 * clock for what is shown and stored.
 */
#ifndef SERVER_CLOCK_H
#define SERVER_CLOCK_H

#include <stdint.h>
#include <time.h>

/* Milliseconds of CLOCK_MONOTONIC. */
int64_t clock_ms(void);

/* The same in microseconds. */
int64_t clock_us(void);

/* `ms` from now by CLOCK_MONOTONIC, for timed waits on conditions that use it. */
struct timespec clock_after_ms(int64_t ms);

/* Microseconds since 1970 UTC. */
int64_t clock_utc_us(void);

#endif
