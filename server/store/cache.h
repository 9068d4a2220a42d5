/* SPDX-License-Identifier: MIT */
/*
 * The chunks of results that were written or read last. A drape is nearly always fetched as soon as
 * it is done, and encoders ask for it in small pieces. What a result holds never changes and its
 * number is never used again, so nothing in here can be out of date.
 */
#ifndef SERVER_STORE_CACHE_H
#define SERVER_STORE_CACHE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct store_cache;

/* NULL without memory. */
struct store_cache *store_cache_new(void);

/* NULL is allowed. No other call may be under way. */
void store_cache_free(struct store_cache *cache);

/* Copies a part of the chunk; false when the chunk is not here. Any thread. */
bool store_cache_read(struct store_cache *cache, int64_t number, int64_t index, size_t offset,
                      void *bytes, size_t length);

/* Keeps the whole chunk, which must have been malloc'ed and belongs to the cache from now on. The
 * one that was used longest ago makes room. Any thread. */
void store_cache_put(struct store_cache *cache, int64_t number, int64_t index, void *bytes,
                     size_t length);

#endif
