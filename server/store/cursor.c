/* SPDX-License-Identifier: MIT */
#include "cursor.h"
#include <sodium.h>
#include <string.h>

enum { HALF_BITS = 31 };
#define HALF_MASK ((UINT64_C(1) << HALF_BITS) - 1)

/* The key of the lists that the owner sees. */
static void make_key(const unsigned char secret[CURSOR_SECRET_BYTES], const char *owner,
                     unsigned char key[crypto_shorthash_KEYBYTES]) {
    unsigned char all = !owner;
    crypto_generichash_state state;
    crypto_generichash_init(&state, secret, CURSOR_SECRET_BYTES, crypto_shorthash_KEYBYTES);
    crypto_generichash_update(&state, &all, sizeof all);
    if (owner)
        crypto_generichash_update(&state, (const unsigned char *)owner, strlen(owner));
    crypto_generichash_final(&state, key, crypto_shorthash_KEYBYTES);
}

static uint64_t mix(const unsigned char key[crypto_shorthash_KEYBYTES], int round, uint64_t half) {
    unsigned char in[9], out[crypto_shorthash_BYTES];
    uint64_t mixed;
    in[0] = (unsigned char)round;
    memcpy(in + 1, &half, sizeof half);
    crypto_shorthash(out, in, sizeof in, key);
    memcpy(&mixed, out, sizeof mixed);
    return mixed & HALF_MASK;
}

int64_t cursor_seal(const unsigned char secret[CURSOR_SECRET_BYTES], const char *owner,
                    int64_t position) {
    unsigned char key[crypto_shorthash_KEYBYTES];
    uint64_t left = (uint64_t)position >> HALF_BITS, right = (uint64_t)position & HALF_MASK;
    if (position <= 0 || left > HALF_MASK)
        return 0;
    make_key(secret, owner, key);
    for (int round = 0; round < CURSOR_ROUNDS; round++) {
        uint64_t next = left ^ mix(key, round, right);
        left = right;
        right = next;
    }
    return (int64_t)(left << HALF_BITS | right) + 1;
}

int64_t cursor_open(const unsigned char secret[CURSOR_SECRET_BYTES], const char *owner,
                    int64_t cursor) {
    unsigned char key[crypto_shorthash_KEYBYTES];
    uint64_t sealed = (uint64_t)cursor - 1;
    uint64_t left = sealed >> HALF_BITS, right = sealed & HALF_MASK;
    if (cursor <= 0 || left > HALF_MASK)
        return 0;
    make_key(secret, owner, key);
    for (int round = CURSOR_ROUNDS - 1; round >= 0; round--) {
        uint64_t next = right ^ mix(key, round, left);
        right = left;
        left = next;
    }
    return (int64_t)(left << HALF_BITS | right);
}
