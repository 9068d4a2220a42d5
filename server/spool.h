/* SPDX-License-Identifier: MIT */
/*
 * Files without a name, for bytes that go from one process to another or wait for a slow caller.
 * Short ones lie in memory; long ones in a folder where there is one, so that they can leave
 * memory. They are gone when their last descriptor is closed.
 */
#ifndef SERVER_SPOOL_H
#define SERVER_SPOOL_H

#include <stdbool.h>
#include <stddef.h>

enum { SPOOL_MEMORY_MAX = 4 * 1024 * 1024 }; /* bytes of what is kept in memory */

/* A new file for about `length` bytes; `folder` is "" when there is none. -1 when it cannot be had.
 */
int spool_new(size_t length, const char *folder);

/* A sealed memory file with the bytes, which can be read but never changed. -1 without memory. */
int spool_of_bytes(const void *bytes, size_t length);

/* Writes all of it at the end; false when there is no room. */
bool spool_write(int file, const void *bytes, size_t length);

/* Closes a memory file for changes by any process. */
bool spool_seal(int file);

#endif
