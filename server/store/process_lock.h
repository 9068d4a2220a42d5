/* SPDX-License-Identifier: MIT */
/*
 * Which processes have a database open, and which of those that had it are gone. Every process
 * holds a lock on a file of its own beside the database; when it ends, in whatever way, the kernel
 * frees the lock, and the next process that looks knows that its claims will never be completed and
 * need not wait for their leases.
 *
 * A further lock, on the file `PATH-lock`, keeps out a second process unless both are configured to
 * share: two daemons on one database are nearly always a mistake.
 */
#ifndef SERVER_STORE_PROCESS_LOCK_H
#define SERVER_STORE_PROCESS_LOCK_H

#include "answer.h"

struct process_lock;

/* Takes the locks for the database at `path`, and clears away what dead processes left. NULL with a
 * sentence in `why` when another process is in the way or the folder cannot be written. */
struct process_lock *process_lock_take(const char *path, bool shared, char why[STORE_WHY_SIZE]);

/* Frees the locks. NULL is allowed. */
void process_lock_free(struct process_lock *lock);

/* The name of this process, as stored with its claims. */
const char *process_lock_name(const struct process_lock *lock);

/* Whether the process of that name is gone. Any thread. */
bool process_lock_gone(const struct process_lock *lock, const char *name);

#endif
