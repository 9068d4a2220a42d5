/* SPDX-License-Identifier: MIT */
#include "checksum.h"
#include <sodium.h>

enum { BYTES = (CHECKSUM_SIZE - 1) / 2 };

_Static_assert(sizeof(crypto_generichash_state) <= CHECKSUM_STATE, "the library's state fits");

static crypto_generichash_state *state_of(struct checksum *checksum) {
    return (crypto_generichash_state *)(void *)checksum->state;
}

void checksum_begin(struct checksum *checksum) {
    crypto_generichash_init(state_of(checksum), NULL, 0, BYTES);
}

void checksum_add(struct checksum *checksum, const void *bytes, size_t length) {
    if (length > 0)
        crypto_generichash_update(state_of(checksum), bytes, length);
}

void checksum_end(struct checksum *checksum, char digits[CHECKSUM_SIZE]) {
    unsigned char bytes[BYTES];
    crypto_generichash_final(state_of(checksum), bytes, sizeof bytes);
    sodium_bin2hex(digits, CHECKSUM_SIZE, bytes, sizeof bytes);
}
