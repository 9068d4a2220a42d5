/* SPDX-License-Identifier: MIT */
/* A result container in memory, sound or not. */
#ifndef TESTS_FUZZ_ENCODE_H
#define TESTS_FUZZ_ENCODE_H

#include "fuzz.h"

#include <stdbool.h>

/* Encodes the container in every format; aborts when a `sound` one is refused, or when an encoder
 * gives another length than it promised. */
void encode_all(const uint8_t *data, size_t size, bool sound);

#endif
