/* SPDX-License-Identifier: MIT */
/*
 * Random names of jobs, requests (of the log) and processes: 128 bits from the kernel, as 32
 * lower-case hexadecimal digits. They cannot be guessed and need no coordination between machines.
 */
#ifndef SERVER_ID_H
#define SERVER_ID_H

#include <stdbool.h>
#include <stdint.h>

/* Characters of an id with its final zero. */
enum { ID_SIZE = 33 };

/* Readies libsodium; once, before any other thread runs. False when the kernel has no randomness:
 * then nothing of this process may go on. */
bool id_init(void);

/* A new id. Any thread. */
void id_make(char id[ID_SIZE]);

/* Whether `text` could be an id: a path segment that is none need not be looked up. */
bool id_valid(const char *text);

/* A number of an id or an owner, for tables. Who chooses owners to collide has that many addresses
 * anyway. */
uint32_t id_hash(const char *name);

#endif
