/* SPDX-License-Identifier: MIT */
#include "clock_check.h"
#include <stdlib.h>

/* More than a clock that is slewed gains between two looks, or than a busy database takes to tell
 * its time. */
#define TOLERANCE_US INT64_C(2000000)

void clock_check_compare(struct clock_check *clocks, int64_t wall_us, int64_t own_us) {
    int64_t difference = (wall_us - clocks->wall_us) - (own_us - clocks->own_us);
    if (clocks->own_us == 0) {
        clocks->since_us = own_us;
    } else if (llabs(difference) > TOLERANCE_US) {
        clocks->since_us = own_us;
        clocks->jumps++;
    }
    clocks->wall_us = wall_us;
    clocks->own_us = own_us;
}

int64_t clock_check_agreed_us(const struct clock_check *clocks) {
    return clocks->own_us - clocks->since_us;
}
