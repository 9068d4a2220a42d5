/* SPDX-License-Identifier: MIT */
/*
 * A checksum that is fed piece by piece: BLAKE2b with 256 bits, as hexadecimal digits. By it a
 * back-up is compared with what was read of the database.
 */
#ifndef SERVER_STORE_CHECKSUM_H
#define SERVER_STORE_CHECKSUM_H

#include <stddef.h>

enum { CHECKSUM_SIZE = 65, CHECKSUM_STATE = 384 };

/* Plain memory; the field belongs to this module. */
struct checksum {
    _Alignas(64) unsigned char state[CHECKSUM_STATE];
};

void checksum_begin(struct checksum *checksum);
void checksum_add(struct checksum *checksum, const void *bytes, size_t length);

/* 64 digits and the final zero. */
void checksum_end(struct checksum *checksum, char digits[CHECKSUM_SIZE]);

#endif
