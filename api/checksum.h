/* SPDX-License-Identifier: MIT */
/*
 * Checksums that tell bytes from others by accident, not by intent (XXH3, as fast as memory). By
 * short ones each thing that is stored is known to be what was written, wherever the database put
 * it (`server/store/seal.h`), and prepared forms are. By long ones a back-up is compared with what
 * was read of the database.
 */
#ifndef API_CHECKSUM_H
#define API_CHECKSUM_H

#include <stddef.h>
#include <stdint.h>

/* 64 bits of the bytes and of `of`, which may be what they belong to or the checksum of bytes
 * before them. `bytes` NULL: of none. */
int64_t checksum_of(int64_t of, const void *bytes, size_t length);

/* The same of a text up to its zero. */
int64_t checksum_text(int64_t of, const char *text);

enum { CHECKSUM_SIZE = 33, CHECKSUM_STATE = 576 };

/* 128 bits of what is fed piece by piece. Plain memory; the field belongs to this module. */
struct checksum {
    _Alignas(64) unsigned char state[CHECKSUM_STATE];
};

void checksum_begin(struct checksum *checksum);
void checksum_add(struct checksum *checksum, const void *bytes, size_t length);

/* 32 hexadecimal digits and the final zero. */
void checksum_end(struct checksum *checksum, char digits[CHECKSUM_SIZE]);

#endif
