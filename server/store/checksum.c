/* SPDX-License-Identifier: MIT */
#include "checksum.h"
#include <sodium.h>

enum { BYTES = (CHECKSUM_SIZE - 1) / 2 };

_Static_assert(sizeof(crypto_generichash_state) <= CHECKSUM_STATE, "the library's state fits");

static crypto_generichash_state *sodium_state(struct checksum *checksum) {
    return (crypto_generichash_state *)(void *)checksum->state;
}

void checksum_begin(struct checksum *checksum) {
    crypto_generichash_init(sodium_state(checksum), NULL, 0, BYTES);
}

void checksum_add(struct checksum *checksum, const void *bytes, size_t length) {
    if (length > 0)
        crypto_generichash_update(sodium_state(checksum), bytes, length);
}

void checksum_end(struct checksum *checksum, char digits[CHECKSUM_SIZE]) {
    unsigned char bytes[BYTES];
    crypto_generichash_final(sodium_state(checksum), bytes, sizeof bytes);
    sodium_bin2hex(digits, CHECKSUM_SIZE, bytes, sizeof bytes);
}
