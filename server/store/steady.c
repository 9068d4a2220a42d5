/* SPDX-License-Identifier: MIT */
#include "steady.h"
#include <stdlib.h>

/* More than a clock that is slewed gains between two looks, or than a busy database takes to tell
 * its time. */
#define TOLERANCE_US INT64_C(2000000)

void steady_look(struct steady *steady, int64_t wall_us, int64_t own_us) {
    int64_t difference = (wall_us - steady->wall_us) - (own_us - steady->own_us);
    if (steady->own_us == 0) {
        steady->since_us = own_us;
    } else if (llabs(difference) > TOLERANCE_US) {
        steady->since_us = own_us;
        steady->jumps++;
    }
    steady->wall_us = wall_us;
    steady->own_us = own_us;
}

int64_t steady_for(const struct steady *steady) {
    return steady->own_us - steady->since_us;
}
