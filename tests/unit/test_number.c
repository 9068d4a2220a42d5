/* SPDX-License-Identifier: MIT */
#include "api/json/digits_text.h"
#include "api/json/number.h"
#include "api/json/shortest.h"
#include "solver/wide.h"

#include "support.h"
#include "tests/check.h"
#include <float.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static double read_back(const char *text, size_t length) {
    char copy[API_NUMBER_SIZE + 1];
    char *end;
    assert_in_range(length, 1, API_NUMBER_SIZE);
    memcpy(copy, text, length);
    copy[length] = '\0';
    double value = strtod(copy, &end);
    assert_ptr_equal(end, copy + length);
    return value;
}

static uint64_t bits_of(double value) {
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

static double random_double(struct random *random) {
    double value;
    do {
        uint64_t bits = random_bits(random);
        memcpy(&value, &bits, sizeof value);
    } while (!isfinite(value));
    return value;
}

/* What the grammar of JSON calls a number. */
static bool is_json_number(const char *text, size_t length) {
    size_t i = text[0] == '-', digits = i;
    while (i < length && text[i] >= '0' && text[i] <= '9')
        i++;
    bool ok = i > digits && (text[digits] != '0' || i == digits + 1);
    if (i < length && text[i] == '.') {
        digits = ++i;
        while (i < length && text[i] >= '0' && text[i] <= '9')
            i++;
        ok = ok && i > digits;
    }
    if (i < length && text[i] == 'e') {
        i++;
        i += i < length && (text[i] == '+' || text[i] == '-');
        digits = i;
        while (i < length && text[i] >= '0' && text[i] <= '9')
            i++;
        ok = ok && i > digits;
    }
    return ok && i == length;
}

static void test_number_shortest_reads_back_to_the_same_bits(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    for (int i = 0; i < 100000; i++) {
        char text[API_NUMBER_SIZE];
        double value = random_double(&random);
        size_t length = api_number_shortest(text, value);
        assert_true(is_json_number(text, length));
        assert_int_equal(bits_of(read_back(text, length)), bits_of(value));
    }
}

/* Of many magnitudes; every eighth has few digits, is the end of intervals of two lengths, or
 * halfway between two whole numbers of the digits there are. */
static double varied_double(struct random *random, int i) {
    if (i % 8 == 2)
        return ldexp(1, random_index(random, 2084) - 1060);
    if (i % 8 == 3)
        return ldexp(floor(ldexp(random_between(random, 1, 2), 52)), -random_index(random, 4));
    double value = i % 4 ? random_between(random, -1, 1) *
                               pow(10, random_between(random, i % 2 ? -20 : -4, 18))
                         : random_double(random);
    return i % 8 == 1 ? round(value * 1e3) / 1e3 : value;
}

/* The fast way for the magnitudes of results writes what the library writes for all. */
static void test_number_shortest_is_the_text_of_the_standard_library(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    size_t fast = 0;
    for (int i = 0; i < 1000000; i++) {
        char text[API_NUMBER_SIZE], expected[API_NUMBER_SIZE];
        double value = varied_double(&random, i);
        fast += shortest_write(text, value) > 0;
        size_t length = api_number_shortest(text, value);
        assert_int_equal(length, api_number_by_library(expected, value));
        assert_memory_equal(text, expected, length);
    }
    check_above(fast, 500000);
}

/* Whatever registers the processor has, a number among others has the digits that it has alone; all
 * its neighbours as well, where one of its last bits counts most. Most are found side by side. */
static void check_kernel(digits_kernel *kernel, struct random *random) {
    size_t sure = 0;
    for (int round = 0; round < 50000; round++) {
        double values[DIGITS_TOGETHER];
        struct digits_lanes lanes;
        for (int k = 0; k < DIGITS_TOGETHER; k++) {
            values[k] = round % 4 == 0        ? varied_double(random, k)
                        : round % 4 == 1 && k ? nextafter(values[k - 1], HUGE_VAL)
                                              : random_between(random, -1, 1) *
                                                    pow(10, random_between(random, -9, 17));
        }
        size_t count = round % 16 ? DIGITS_TOGETHER : (size_t)random_index(random, DIGITS_TOGETHER);
        kernel(values, count, &lanes);
        for (size_t k = 0; k < DIGITS_TOGETHER; k++) {
            char text[API_NUMBER_SIZE], expected[API_NUMBER_SIZE];
            struct digits digits =
                digits_of((char)lanes.first[k], lanes.next[k], lanes.last[k], (int)lanes.point[k]);
            size_t length =
                lanes.sure[k] ? digits_write(text, signbit(values[k]) ? 1 : 0, digits) : 0;
            assert_true(k < count || !lanes.sure[k]);
            sure += lanes.sure[k] != 0;
            if (length > 0) {
                assert_int_equal(length, api_number_by_library(expected, values[k]));
                assert_memory_equal(text, expected, length);
            }
        }
    }
    check_above(sure, 1000000);
}

static void test_number_digits_side_by_side_are_those_of_one(void **state) {
    (void)state;
#if WIDE_FILES
    struct random random = random_begin(__func__);
    if (wide_has(4) && __builtin_cpu_supports("fma"))
        check_kernel(digits_kernel_4, &random);
    if (wide_has(8))
        check_kernel(digits_kernel_8, &random);
#endif
}

static void test_number_list_is_its_numbers_with_commas(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    for (int i = 0; i < 6000; i++) {
        double values[99];
        char list[99 * API_NUMBER_SIZE], expected[sizeof list];
        size_t count = (size_t)random_index(&random, 100), length = 0;
        int digits = i % 4 ? 0 : random_index(&random, API_PRECISION_EXACT + 2) - 1;
        for (size_t k = 0; k < count; k++) {
            values[k] = k > 0 && random_index(&random, 3) == 0 ? values[k - 1]
                        : random_index(&random, 9) == 0        ? (double)NAN
                                                               : varied_double(&random, (int)k);
            if (k > 0)
                expected[length++] = ',';
            if (isnan(values[k]))
                length += (size_t)(stpcpy(expected + length, "null") - (expected + length));
            else if (digits == API_PRECISION_WHOLE)
                length += api_number_integer(expected + length,
                                             (int64_t)(values[k] = floor(fmod(values[k], 1e6))));
            else if (digits > 0)
                length += api_number_rounded(expected + length, values[k], digits);
            else
                length += api_number_by_library(expected + length, values[k]);
        }
        assert_int_equal(api_number_list(list, values, count, digits), length);
        assert_memory_equal(list, expected, length);
    }
}

static void test_number_shortest_is_no_longer_than_any_rounding(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    for (int i = 0; i < 5000; i++) {
        char text[API_NUMBER_SIZE], rounded[64];
        double value = random_double(&random);
        size_t length = api_number_shortest(text, value);
        int digits = 1;
        while (snprintf(rounded, sizeof rounded, "%.*e", digits - 1, value) > 0 &&
               bits_of(strtod(rounded, NULL)) != bits_of(value))
            digits++;
        assert_in_range(length, 1, strlen(rounded));
    }
}

static void test_number_shortest_of_known_values(void **state) {
    (void)state;
    static const struct {
        double value;
        const char *text;
    } known[] = {{0, "0"},        {-0.0, "-0"},       {1, "1"},
                 {0.1, "0.1"},    {-2.5, "-2.5"},     {1.0 / 3, "0.3333333333333333"},
                 {1e22, "1e+22"}, {5e-324, "5e-324"}, {DBL_MAX, "1.7976931348623157e+308"}};
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        char text[API_NUMBER_SIZE + 1];
        text[api_number_shortest(text, known[i].value)] = '\0';
        assert_string_equal(text, known[i].text);
    }
}

static void test_number_rounded_is_correctly_rounded(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    for (int i = 0; i < 20000; i++) {
        char text[API_NUMBER_SIZE], printed[64];
        double value = i % 2 ? random_double(&random) : random_between(&random, -1000, 1000);
        int digits = 1 + random_index(&random, API_PRECISION_EXACT);
        size_t length = api_number_rounded(text, value, digits);
        snprintf(printed, sizeof printed, "%.*e", digits - 1, value);
        if (isinf(strtod(printed, NULL)))
            continue; /* rounded up beyond the largest double */
        assert_true(is_json_number(text, length));
        assert_int_equal(bits_of(read_back(text, length)), bits_of(strtod(printed, NULL)));
    }
}

static void test_number_integer_writes_all_of_int64(void **state) {
    (void)state;
    static const int64_t values[] = {0, 7, -7, INT64_MAX, INT64_MIN};
    for (size_t i = 0; i < sizeof values / sizeof *values; i++) {
        char text[API_NUMBER_SIZE + 1], expected[API_NUMBER_SIZE];
        text[api_number_integer(text, values[i])] = '\0';
        snprintf(expected, sizeof expected, "%" PRId64, values[i]);
        assert_string_equal(text, expected);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_number_shortest_reads_back_to_the_same_bits),
        cmocka_unit_test(test_number_shortest_is_the_text_of_the_standard_library),
        cmocka_unit_test(test_number_digits_side_by_side_are_those_of_one),
        cmocka_unit_test(test_number_list_is_its_numbers_with_commas),
        cmocka_unit_test(test_number_shortest_is_no_longer_than_any_rounding),
        cmocka_unit_test(test_number_shortest_of_known_values),
        cmocka_unit_test(test_number_rounded_is_correctly_rounded),
        cmocka_unit_test(test_number_integer_writes_all_of_int64),
    };
    return cmocka_run_group_tests_name("number", tests, NULL, NULL);
}
