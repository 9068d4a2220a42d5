/* SPDX-License-Identifier: MIT */
#include "number.h"

#include "digits_text.h"
#include "shortest.h"
#include "solver/wide.h"
#include <math.h>

/* The digits of the next numbers, at most DIGITS_TOGETHER; of none where the processor has no
 * registers for them. */
static void spell_several(const double *values, size_t count, struct digits_lanes *lanes) {
#if WIDE_FILES
    if (wide_has(8)) {
        digits_kernel_8(values, count, lanes);
        return;
    }
    if (wide_has(4) && __builtin_cpu_supports("fma")) {
        digits_kernel_4(values, count, lanes);
        return;
    }
#endif
    (void)values, (void)count;
    memset(lanes->sure, 0, sizeof lanes->sure);
}

static __attribute__((noinline)) size_t write_alone(char *text, double value, int digits) {
    if (isnan(value)) {
        memcpy(text, "null", 4);
        return 4;
    }
    if (digits == API_PRECISION_WHOLE)
        return api_number_integer(text, (int64_t)value);
    return digits ? api_number_rounded(text, value, digits) : api_number_shortest(text, value);
}

size_t api_number_list(char *text, const double *values, size_t count, int digits) {
    struct digits_lanes lanes;
    uint64_t bits, before = 0; /* of the last number */
    size_t length = 0;         /* and of its text */
    char *at = text;
    for (size_t begin = 0; begin < count; begin += DIGITS_TOGETHER) {
        const double *value = values + begin;
        size_t left = count - begin < DIGITS_TOGETHER ? count - begin : DIGITS_TOGETHER;
        bool one = memcmp(value + 1, value, (left - 1) * sizeof *value) == 0;
        spell_several(value, digits != 0 || one ? 0 : left, &lanes);
        for (size_t lane = 0; lane < left; lane++, at += length, *at++ = ',') {
            memcpy(&bits, &value[lane], sizeof bits);
            if (bits == before && length > 0) {
                char copy[API_NUMBER_SIZE];
                memcpy(copy, at - 1 - length, sizeof copy);
                memcpy(at, copy, sizeof copy);
                continue;
            }
            before = bits;
            length = 0;
            if (lanes.sure[lane])
                length = digits_write(at, bits >> 63,
                                      digits_of((char)lanes.first[lane], lanes.next[lane],
                                                lanes.last[lane], (int)lanes.point[lane]));
            if (length == 0)
                length = write_alone(at, value[lane], digits);
        }
    }
    return count > 0 ? (size_t)(at - text) - 1 : 0;
}
