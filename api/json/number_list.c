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

static bool are_bits_equal(const double *a, const double *b, size_t count) {
    return memcmp(a, b, count * sizeof *a) == 0;
}

size_t api_number_list(char *text, const double *values, size_t count, int digits) {
    struct digits_lanes lanes;
    size_t length = 0; /* of the last text */
    char *at = text;
    for (size_t i = 0, lane = 0; i < count; i++, lane++, at += length) {
        if (i % DIGITS_TOGETHER == 0) {
            size_t left = count - i < DIGITS_TOGETHER ? count - i : DIGITS_TOGETHER;
            bool one = are_bits_equal(&values[i + 1], &values[i], left - 1);
            spell_several(values + i, digits != 0 || one ? 0 : left, &lanes);
            lane = 0;
        }
        if (i > 0)
            *at++ = ',';
        if (i > 0 && are_bits_equal(&values[i], &values[i - 1], 1)) {
            char copy[API_NUMBER_SIZE];
            memcpy(copy, at - 1 - length, sizeof copy);
            memcpy(at, copy, sizeof copy);
            continue;
        }
        length = 0;
        if (lanes.sure[lane])
            length = digits_write(at, signbit(values[i]) ? 1 : 0,
                                  digits_of((char)lanes.first[lane], lanes.next[lane],
                                            lanes.last[lane], (int)lanes.point[lane]));
        if (length == 0)
            length = write_alone(at, values[i], digits);
    }
    return (size_t)(at - text);
}
