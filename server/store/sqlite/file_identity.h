/* SPDX-License-Identifier: MIT */
/*
 * Whether the database is still at its path. SQLite goes on writing to files that were removed,
 * moved or replaced, and all of it is lost: so the device and inode of the database and of its log
 * are compared with those that were opened, as PostgreSQL does with its process id file.
 */
#ifndef SERVER_STORE_SQLITE_FILE_IDENTITY_H
#define SERVER_STORE_SQLITE_FILE_IDENTITY_H

#include <stdbool.h>

struct file_identity;

/* Of a database that is open with a write-ahead log. NULL without memory or files. */
struct file_identity *file_identity_new(const char *path);

/* NULL is allowed. */
void file_identity_free(struct file_identity *identity);

/* Whether the same files are there; a change is logged, once. It may come back: files that were
 * moved away and are moved back are the same. Any thread; it takes three calls of the system. */
bool file_identity_check(struct file_identity *identity);

#endif
