/* SPDX-License-Identifier: MIT */
/*
 * Content ids: BLAKE2b of the canonical document (`normalise.h`), 128 bits in lower-case hex. How
 * the JSON was spelled (key order, spaces, 1 or 1.0, weights that are all 1, whole geomdl file or
 * bare surface) makes no difference. The only file of api/ that knows libsodium.
 */
#ifndef API_REQUEST_DIGEST_H
#define API_REQUEST_DIGEST_H

#include "request.h"
#include "solver/arena.h"
#include <stdbool.h>
#include <stddef.h>

/* Sets up libsodium for this process; see `api_prepare`. */
bool api_digest_prepare(void) STATUS_MUST_USE;

/* The id of `length` bytes. */
void api_digest_bytes(const void *bytes, size_t length, char id[API_ID_SIZE]);

/* The digest of two pieces of memory, one behind the other. */
enum { API_DIGEST_BYTES = 32 };
void api_digest_pieces(const void *head, size_t head_length, const void *bytes, size_t length,
                       unsigned char digest[API_DIGEST_BYTES]);

/* SHA-256 of what is fed piece by piece, for those who compare files: 64 hexadecimal digits and the
 * final zero. Plain memory; the field belongs to this module. */
enum { API_SHA256_SIZE = 65, API_SHA256_STATE = 128 };
struct api_sha256 {
    _Alignas(16) unsigned char state[API_SHA256_STATE];
};
void api_sha256_begin(struct api_sha256 *hash);
void api_sha256_add(struct api_sha256 *hash, const void *bytes, size_t length);
void api_sha256_end(struct api_sha256 *hash, char digits[API_SHA256_SIZE]);

/* The id of a surface, which is the one it is stored under: that of its definition, or for
 * API_SURFACE_NAMED the one it was named by. Scratch comes from `arena` and is given back; false
 * without memory. */
bool api_digest_surface(const struct api_surface *surface, struct arena *arena,
                        char id[API_ID_SIZE]) STATUS_MUST_USE;

/* The id of what a request that names a stored surface drapes on: of the surface itself, or where
 * it chooses faces or moves it, of that with the choice and the offset. Likewise. */
bool api_digest_ground(const struct api_request *request, struct arena *arena,
                       char id[API_ID_SIZE]) STATUS_MUST_USE;

/* The id of what a request asks for: its surface's id (inline or stored, the same), everything else
 * in it, and DRAPE_VERSION. Requests with equal ids have equal results. */
bool api_digest_request(const struct api_request *request, struct arena *arena,
                        char id[API_ID_SIZE]) STATUS_MUST_USE;

#endif
