/* SPDX-License-Identifier: MIT */
/* Any bytes as a stored result: a damaged one is told, never followed. */
#include "encode.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    encode_all(data, size, false);
    return 0;
}
