/* SPDX-License-Identifier: MIT */
#include "checksum.h"
#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

_Static_assert(sizeof(XXH3_state_t) <= CHECKSUM_STATE, "the library's state fits");

int64_t checksum_of(int64_t of, const void *bytes, size_t length) {
    return (int64_t)XXH3_64bits_withSeed(bytes, bytes ? length : 0, (uint64_t)of);
}

int64_t checksum_text(int64_t of, const char *text) {
    return checksum_of(of, text, text ? strlen(text) : 0);
}

static XXH3_state_t *library_state(struct checksum *checksum) {
    return (XXH3_state_t *)(void *)checksum->state;
}

void checksum_begin(struct checksum *checksum) {
    XXH3_128bits_reset(library_state(checksum));
}

void checksum_add(struct checksum *checksum, const void *bytes, size_t length) {
    if (length > 0)
        XXH3_128bits_update(library_state(checksum), bytes, length);
}

void checksum_end(struct checksum *checksum, char digits[CHECKSUM_SIZE]) {
    const XXH128_hash_t hash = XXH3_128bits_digest(library_state(checksum));
    snprintf(digits, CHECKSUM_SIZE, "%016" PRIx64 "%016" PRIx64, hash.high64, hash.low64);
}
