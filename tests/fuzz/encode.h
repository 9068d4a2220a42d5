/* SPDX-License-Identifier: MIT */
/* What whole jobs are given and give. */
#ifndef TESTS_FUZZ_ENCODE_H
#define TESTS_FUZZ_ENCODE_H

#include "fuzz.h"

#include "api/limits.h"
#include <stdbool.h>

/* `api_prepare`, once. */
void fuzz_prepare(void);

/* Tiny budgets. */
extern const struct api_limits fuzz_limits;

/* The `progress` of a monitor whose context counts its looks, an int: too many cancel the job. */
bool fuzz_go_on(void *looks, double fraction);

struct fuzz_bytes {
    uint8_t *data; /* the caller's, to be freed */
    size_t size, capacity;
};

/* The `write` of a sink whose context is a `struct fuzz_bytes`. */
bool fuzz_append(void *context, const void *bytes, size_t length);

/* Encodes a result container, sound or not, in every format; aborts when a `sound` one is refused,
 * or when an encoder gives another length than it promised. */
void encode_all(const uint8_t *data, size_t size, bool sound);

#endif
