/* SPDX-License-Identifier: MIT */
/*
 * For programs of tests: cmocka with what it wants included before it, comparisons of numbers that
 * say both when they fail, the size of a test and the seed of a random one.
 */
#ifndef TESTS_CHECK_H
#define TESTS_CHECK_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

/* Compared as doubles, which hold every integer below 2^53; a NaN fails. */
#define CHECK_ORDER(value, relation, limit)                                                        \
    do {                                                                                           \
        double value_ = (double)(value), limit_ = (double)(limit);                                 \
        if (!(value_ relation limit_))                                                             \
            fail_msg("%s is %.9g, not " #relation " %s, which is %.9g", #value, value_, #limit,    \
                     limit_);                                                                      \
    } while (0)

#define check_below(value, limit) CHECK_ORDER(value, <, limit)
#define check_above(value, limit) CHECK_ORDER(value, >, limit)
#define check_at_most(value, limit) CHECK_ORDER(value, <=, limit)
#define check_at_least(value, limit) CHECK_ORDER(value, >=, limit)

/*
 * Of `whole` rounds, levels or nodes those that this run is for, at least `least`: all, or the
 * share that DRAPED_TEST_SIZE says (1 is all), where a sanitizer makes each many times slower.
 */
static inline int check_sized(int whole, int least) {
    const char *text = getenv("DRAPED_TEST_SIZE");
    double size = text ? strtod(text, NULL) : 1;
    int count = size < 1 ? (int)(whole * size) : whole;
    return count > least ? count : least;
}

/*
 * The seed of a random test, printed: DRAPED_SEED, else the usual one, so that a run says of a tree
 * what the run before it said. `make seeds` looks for what others find.
 */
static inline uint64_t check_seed(uint64_t usual) {
    const char *text = getenv("DRAPED_SEED");
    uint64_t seed = text ? strtoull(text, NULL, 0) : usual;
    print_message("# DRAPED_SEED=%llu\n", (unsigned long long)seed);
    return seed;
}

/*
 * How many of a random test's cases are wrong: those named from the seed on, DRAPED_ROUNDS of them,
 * else as many as this run is for. `wrong_of` says which with its name.
 */
static inline int check_rounds(uint64_t usual, int whole, int least, int (*wrong_of)(uint64_t)) {
    const char *text = getenv("DRAPED_ROUNDS");
    uint64_t first = check_seed(usual);
    int rounds = text ? atoi(text) : check_sized(whole, least), wrong = 0;
    for (int round = 0; round < rounds; round++)
        wrong += wrong_of(first + (uint64_t)round);
    return wrong;
}

/* The step of a loop over cases: 1, in short runs `short_step`. */
static inline int check_stride(int short_step) {
    return check_sized(short_step, 1) < short_step ? short_step : 1;
}

#endif
