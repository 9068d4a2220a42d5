/* SPDX-License-Identifier: MIT */
/*
 * Cursors of lists. A position in a list is a number that all owners' entries share, so that two of
 * them tell how many others came between. Callers get it permuted by a key of the store and of the
 * owner: no order, no difference and nothing of another owner's can be seen in it.
 *
 * The permutation is a Feistel network of CURSOR_ROUNDS rounds over 62 bits with SipHash-2-4 as its
 * round function (Luby and Rackoff, SIAM J. Comput. 17, 1988: four suffice).
 */
#ifndef SERVER_STORE_CURSOR_H
#define SERVER_STORE_CURSOR_H

#include <stdint.h>

enum { CURSOR_SECRET_BYTES = 32, CURSOR_ROUNDS = 6 };

/* What a caller gets for a position >= 1 and < 2^62: >= 1 and at most 2^62. `owner` NULL: a list of
 * all owners. 0 stays 0. */
int64_t cursor_seal(const unsigned char secret[CURSOR_SECRET_BYTES], const char *owner,
                    int64_t position);

/* The position; some other one for what no list has given, 0 for what cannot be one. */
int64_t cursor_open(const unsigned char secret[CURSOR_SECRET_BYTES], const char *owner,
                    int64_t cursor);

#endif
